"""Formulas lowered to few operations: the same numbers, and as few products of series as a person would write."""

import re

import heyoka as hy
import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot import paper
from poinsot.algebra.program import Graph
from poinsot.engine import kernels
from poinsot.engine.formulations import FORMULATIONS
from poinsot.engine.heyoka_expressions import Expressions
from poinsot.engine.lowering import lowered
from poinsot.engine.problem import Problem

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3))

FORMULAS = {
    "where on a parameter": lambda k, z: fn.where(fn.less(k, 1.0), z, 2 * z),
    "where on a variable": lambda k, z: fn.where(fn.less(z, 5.0), k * z, z),
    "where of parameters": lambda k, z: fn.where(fn.less(-5.0, z), k, 0.0) * z,
    "less of a parameter and a variable": lambda k, z: fn.where(fn.less(-7 * k, z), z * z, z),
    "atan2 of a parameter and a variable": lambda k, z: fn.atan2(k + 2, z),
    "atan2 of a variable and a parameter": lambda k, z: fn.atan2(z, k),
    "powers": lambda k, z: (2 + z) ** k + k ** (2 + z),
    "divisions": lambda k, z: k / (2 + z) + (2 + z) / k + 1 / k + k / 2,
    "differences": lambda k, z: (k - z) * (z - k) + (1 - k) * (z - 0) + (k - 0) * z,
    "like products": lambda k, z: k * z * z + z * (3 * z) - z * k * z - (k * z) * (2 * z) + 2 * (z * z) - 0.5 * z,
    "signs": lambda k, z: -(k * z) - z * z + (-2 * z) * (-k) - (3 - z) * (-z) + (-z - k) - (z * z * z - 1),
    "products of sums": lambda k, z: (k * z + 1) * (2 * z - k) * (z * z - z * k) - 2 * (1 - 2 * z) * (4 * z),
    "nothing left": lambda k, z: z * z + (k * z - z * k) + (2 * z - z - z) * 5 + 0 * z,
    "functions": lambda k, z: fn.sin(k) * fn.sqrt(2 + z) + fn.exp(-k * z) + fn.log(2 + k) * z,
}


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical", "euler_angles"])
@pytest.mark.parametrize("name", FORMULAS)
def test_energy_is_conserved_with_the_torque_of_the_kernel(name, formulation):
    class Formula(pt.Potential):
        k: float

        def energy(self, instant):
            return 0.3 * FORMULAS[name](self.k, instant.attitude.to_body((0, 0.6, 0.8))[2])

    motion = pt.propagate(pt.System(BODY, Formula(0.7)), START, np.linspace(0, 3, 7), formulation=formulation)
    assert np.ptp(motion.potential_energy) > 1e-3
    assert np.max(np.abs(motion.drift["energy"])) < 1e-13


MULTIPLES = {name: FORMULAS[name] for name in ("like products", "signs", "products of sums", "nothing left", "powers")}


@pytest.mark.parametrize("name", MULTIPLES)
def test_multiples_are_the_same_numbers(name):
    graph = Graph()
    program = lowered(graph, [MULTIPLES[name](graph.input(0), graph.symbol(0))])
    made = Expressions(program.decomposition)
    compiled = hy.cfunc(made.rates, made.symbols)
    for number, value in ((0.7, 0.3), (-1.3, 1.9), (0.0, -0.4)):
        with np.errstate(divide="ignore", invalid="ignore"):
            expected = MULTIPLES[name](np.float64(number), np.float64(value))
        pars = np.array(program.values([np.float64(number)]), dtype=float)
        assert np.allclose(compiled([value], pars=pars)[0], expected, rtol=1e-14, atol=1e-14, equal_nan=True)


@pytest.mark.parametrize(
    ("system", "products", "squares"),
    [(paper.FREE, 15, 0), (paper.HEAVY_TOP, 19, 4), (paper.KEPLER, 25, 5)],
    ids=["free", "top", "kepler"],
)
def test_a_kernel_has_the_products_of_series_that_a_person_would_write(system, products, squares):
    state = paper.PRINTED_PAIR
    variables = kernels.state_vector(Problem(system), state, FORMULATIONS["lie_poisson"], "double")
    with kernels.kernel_of(Problem(system), variables, "double", 1e-15) as compiled:
        entries = [str(entry) for entry, _ in compiled.engine.decomposition]
    assert sum(bool(re.fullmatch(r"\(u_\d+ \* u_\d+\)", entry)) for entry in entries) == products
    assert sum(entry.count("**2") for entry in entries) == squares  # half the work of a product
