"""The count of operations of a Taylor step, on a system that can be counted by hand."""

import heyoka as hy
import pytest
from benchmarks import flops


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_products_of_a_step_are_counted_at_every_order(tolerance):
    x, y = hy.make_vars("x", "y")
    engine = hy.taylor_adaptive([(x, x * y), (y, 2.0 * x)], [0.1, 0.2], tol=tolerance)
    p = engine.order
    products = p * (p + 1) // 2 + p * (p - 1) // 2 + p  # x y: n + 1 and n at order n; 2 x: 1
    polynomials = 3 * 2 * p  # of two variables: the division by the order, Horner's product and sum
    pairs = p * (p - 1) // 2 + 2 * p
    assert flops.of_a_step(engine) == {
        "flops": products + polynomials,
        "instructions": products + polynomials - pairs,
        "order": p,
    }


def test_an_entry_that_has_no_count_is_refused():
    x = hy.make_vars("x")
    engine = hy.taylor_adaptive([(x, hy.erf(x))], [0.1])
    with pytest.raises(ValueError, match="must know every entry"):
        flops.of_a_step(engine)
