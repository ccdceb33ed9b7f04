"""The schedule of Taylor coefficients: which inner sums share a loop."""

import itertools

import numpy as np
import pytest

from poinsot.taylor.decomposition import MAX_SUMS_IN_LOOP, Decomposition, Product, Schedule, Variable


@pytest.mark.parametrize(("states", "products"), [(4, 9), (7, 28), (9, 60), (30, 200)])
def test_each_loop_goes_on_with_the_inner_sum_that_loads_the_fewest_rows(states, products):
    pairs = [*itertools.combinations_with_replacement(range(states), 2)]
    chosen = np.random.default_rng(states).choice(len(pairs), products, replace=products > len(pairs))
    operations = (*map(Variable, range(states)), *(Product(*pairs[k]) for k in chosen))
    groups = Schedule(Decomposition(operations, tuple(range(states)), 0)).groups
    assert max(map(len, groups)) <= MAX_SUMS_IN_LOOP
    left = {place: pairs[k] for place, k in enumerate(chosen)}
    for group in groups:
        firsts, seconds = set(), set()

        def loads(place, pair, own=(firsts, seconds)):
            return sum(row not in loaded for row, loaded in zip(pair, own, strict=True)), place

        for place, first, second in group:
            pair = first.operation, second.operation
            assert pair in (left[place], left[place][::-1])
            assert loads(place, pair) == min(
                loads(k, option) for k, rows in left.items() for option in (rows, rows[::-1])
            )
            del left[place]
            firsts.add(pair[0])
            seconds.add(pair[1])
    assert not left
