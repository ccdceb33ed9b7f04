"""Formulas lowered to few operations: the same numbers, and as few products of series as a person would write."""

import itertools
from collections import Counter

import numpy as np
import pytest

import poinsot as pt
from decompositions import rates
from kinds.forces import FORCES, label
from poinsot import functions as fn
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.kernel_parameters import program
from poinsot.integration.problem import Problem
from poinsot.taylor.decomposition import Function, Product, Quotient
from poinsot.taylor.graph import Evaluator, Graph
from poinsot.taylor.lowering import simplified
from poinsot.taylor.shared_products import Factoring

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
    program = simplified([MULTIPLES[name](graph.input(0), graph.symbol(0))])
    for number, value in ((0.7, 0.3), (-1.3, 1.9), (0.0, -0.4)):
        with np.errstate(divide="ignore", invalid="ignore"):
            expected = MULTIPLES[name](np.float64(number), np.float64(value))
            found = rates(program, [value], [number])[0]
        assert np.allclose(found, expected, rtol=1e-14, atol=1e-14, equal_nan=True)


def test_constants_have_the_same_bits_whatever_they_were_computed_for_before():
    graph = Graph()
    a, b = graph.input(0), graph.input(1)
    formulas = [fn.atan2(a, b) * 3, fn.sin(a) / b, fn.sqrt(b) + fn.exp(fn.cos(a) * b), 2 / a, b * b - fn.log(b)]
    program = simplified([x * graph.symbol(0) for x in formulas])
    numbers = [0.0, -0.0, 0.7, -1.3, np.nan, 2.0, 0.7]
    pairs = [[np.float64(x), np.float64(y)] for x in numbers for y in numbers]
    pairs += [[x, np.array([0.7, -0.2])] for x, _ in pairs[:3]] + pairs[::-1]
    for kind in (np.float64, np.longdouble):
        replay = Evaluator(program.parameters, kind)
        for given in pairs:
            with np.errstate(all="ignore"):
                values, expected = replay(given), Evaluator(program.parameters, kind)(given)
            for value, own in zip(values, expected, strict=True):
                assert np.array_equal(value, own, equal_nan=True)
                assert np.array_equal(np.signbit(value), np.signbit(own))
                assert np.asarray(value).dtype == np.asarray(own).dtype


KINEMATICS = 12 + 3
"""Products in q (0, omega) / 2, each of four by each of three, and in g x omega, whose terms go together."""

ROW, MATRIX = 4, 6
"""Products of two components of q in one row of a rotation matrix, and in all."""

OF_ROW, OF_MATRIX = 2, 3
"""Squares of components: their sum does not change, so that a row needs two and the whole matrix three."""

PAIRS = 3
"""Products u_i u_j in a torque u x I u: the two terms of each component go together."""

ORBIT = pt.KeplerOrbit(1.1, semimajor_axis=3.0, eccentricity=0.3, inclination=0.7, node=-0.4, true_anomaly=0.3)
AT_REST = pt.orbits.FixedPosition(0.9, position=(1.8, -0.5, 0.7))
POINTS = [(0.5, -0.3, 0.2), (-0.3, 0.4, -0.5), (0.1, 0.2, 0.6)]
SQUARE = np.array([(0.0, 0.0, 0.0)] * 2 + [(-0.3, 0.05, 0.1)])
ZONAL = pt.GravityField(2, 1.1, 0.8, SQUARE.tolist(), (SQUARE * [(0, 1, 1)]).tolist())

BY_HAND = {
    "no force": ((), KINEMATICS, 0, 0, 0),
    "uniform gravity": ((pt.UniformGravity(0.7, (0.3, -0.2, 0.5)),), KINEMATICS + ROW, OF_ROW, 0, 0),
    # c^3, c = 1 + e cos f, and c^3 u, u2 (c^3 u1), u3 (c^3 u1), u3 (c^3 u2); f' is proportional to c^2
    "gravity gradient on an orbit": ((pt.GravityGradient(ORBIT),), KINEMATICS + ROW + 1 + 2 + PAIRS, OF_ROW + 1, 0, 2),
    "gravity gradient at rest": ((pt.GravityGradient(AT_REST),), KINEMATICS + MATRIX + PAIRS, OF_MATRIX, 0, 0),
    # two vectors, n and k - 5 s n, that are constant in space
    "oblateness at rest": (
        (pt.forces.Oblateness(AT_REST, 0.3, 0.7, (0.4, -0.3, 0.8)),),
        KINEMATICS + MATRIX + 2 * PAIRS,
        OF_MATRIX,
        0,
        0,
    ),
    # n x slope, all six products of second degree; three of them are squares
    "harmonics of degree 2 at rest": (
        (pt.forces.HarmonicGravity(AT_REST, ZONAL),),
        KINEMATICS + MATRIX + 6,
        OF_MATRIX,
        0,
        0,
    ),
    # each point: root, 1 / root, x / (1 + root), and the slope by two products and a square; n x (sum m_i slope_i x_i)
    "three points at rest": (
        (pt.forces.MasconGravity(AT_REST, (0.6, 0.7, 0.5), POINTS),),
        KINEMATICS + MATRIX + 6 + 3 * 2,
        OF_MATRIX + 3,
        3 * 2,
        3,
    ),
    "linear damping": ((pt.forces.LinearDamping(0.05),), KINEMATICS, 0, 0, 0),
}


def operations_of(system):
    variables = equations.state_vector(Problem(system), START, FORMULATIONS["lie_poisson"], "double")
    return program(Problem(system), variables).decomposition.operations


@pytest.mark.parametrize("name", BY_HAND)
def test_a_program_has_no_more_operations_than_one_by_hand(name, monkeypatch):
    forces, products, squares, quotients, function_count = BY_HAND[name]
    for force in forces:
        monkeypatch.setattr(type(force), "check", lambda *_: None)
    operations = operations_of(pt.System(BODY, *forces))
    own = [x for x in operations if isinstance(x, Product)]
    assert sum(x.first != x.second for x in own) <= products
    assert sum(x.first == x.second for x in own) <= squares
    assert sum(isinstance(x, Quotient) for x in operations) <= quotients
    assert sum(isinstance(x, Function) for x in operations) <= function_count


PATH = (2, 1, 3)
"""The place on an ellipse and its distance, of the halved eccentric anomaly: sin cos and sin^2; the slope of E; E, sin
and cos. A velocity takes two products more."""

TURN = 9
"""Products that turn a vector of space to body axes, in addition to the products of the matrix."""

WHOLE = KINEMATICS + MATRIX + OF_MATRIX
IN_AXES_OF_THE_ORBIT = KINEMATICS + ROW + OF_ROW + 1
"""With c^2, c = 1 + e cos f, to which the rate of the anomaly is proportional."""

PLANET = 4 + 1
"""Products of cosines and sines in two axes of a planet, and the square of the time of an angle."""

# The dipole turned to space; u = r / |r|; d . u and u times it; |r|^-3 times all; turned to the body
DIPOLE_FIELD = PATH[0] + PLANET + (2 + 3) + (3 + 3) + (3 + 3) + (2 + 3) + TURN
# v; u . v, u' twice; each of nine products of angles twice, and W' twice; (u . d)'; two terms each of (u . d) u and B
ITS_RATE = 2 + (3 + 3 + 3) + (2 * 9 + 2) + 6 + 6 + (2 + 3 + 3) + TURN
# r turned to the planet; r / r^2; harmonics to degree 3 (4 + 2 x 2 of the column z); the root; turned back
HARMONICS_FIELD = PATH[0] + PLANET + (8 + 4) + (3 + 3) + (3 + 4 + 1 + 2 * 5) + 3 + (4 + 8) + TURN
CROSS = 6

ON_A_PATH = (PATH[1], PATH[2])
SHIPPED = {
    "UniformGravity": (KINEMATICS + ROW + OF_ROW, 0, 0),
    "GravityGradient KeplerOrbit": (IN_AXES_OF_THE_ORBIT + 1 + 2 + PAIRS, 0, 2),
    "GravityGradient FixedPosition": (WHOLE + PAIRS, 0, 0),
    # u in the plane; s^2, w = k - 5 s u, both turned; r^-2, r^-4, r^-5
    "Oblateness KeplerOrbit": (WHOLE + PATH[0] + 2 + 1 + 3 + 2 * (TURN + PAIRS) + 3 + 3 + 3, *ON_A_PATH),
    "Oblateness FixedPosition": (WHOLE + 2 * PAIRS, 0, 0),
    # all monomials of degree 2; c^3 and c^4 by the slopes of both degrees
    "HarmonicGravity KeplerOrbit GravityField": (IN_AXES_OF_THE_ORBIT + 6 + 2 + 6 + CROSS, 0, 2),
    "HarmonicGravity FixedPosition GravityField": (WHOLE + 6 + CROSS, 0, 0),
    "MasconGravity FixedPosition": (WHOLE + CROSS + 2 * (2 + 1), 2 * 2, 2),
    # squares of n; three steps of Laguerre, the first from 1; 1 / l^2, 1 / l^3, its root; three sums; slopes, n x slope
    "EllipsoidGravity FixedPosition": (WHOLE + 3 + (1 + 5 + 5) + 3 + 3 + 3 + CROSS, 3 + 1 + 4 + 12, 4 + 12),
    "LinearDamping": (KINEMATICS, 0, 0),
    # r, v and omega x r along the body axes, by two rows; r x (v - omega x r); r^-8
    "TidalTorque KeplerOrbit": (IN_AXES_OF_THE_ORBIT + 1 + 2 + 3 + 6 + CROSS + CROSS + 2 + 3, 1, 2),
    "MagneticMoment TiltedDipole": (WHOLE + DIPOLE_FIELD, 2, 10),
    "MagneticMoment MagneticHarmonics": (WHOLE + HARMONICS_FIELD, 3, 10),
    "MagneticMoment SecularHarmonics": (WHOLE + HARMONICS_FIELD + 3, 3, 10),
    "EddyCurrents TiltedDipole": (WHOLE + DIPOLE_FIELD + 2 * CROSS, 2, 10),
    "BDot TiltedDipole": (WHOLE + DIPOLE_FIELD + ITS_RATE + 2 * CROSS, 2, 10),
    # v; |v|, v / |v|; rho v^2
    "MeshDrag KeplerOrbit ExponentialAtmosphere DirectionalTorque": (
        WHOLE + PATH[0] + 2 + TURN + 3 + 3 + 2 + 3,
        2,
        5,
    ),
    "MeshRadiation KeplerOrbit DirectionalTorque": (IN_AXES_OF_THE_ORBIT + 3, 0, 2),
    "Yorp KeplerOrbit DirectionalTorque": (IN_AXES_OF_THE_ORBIT + 3, 0, 2),
    # (sum of lever arms) x u, and a square of each facet
    "AtmosphericDrag KeplerOrbit ExponentialAtmosphere Facets": (
        WHOLE + PATH[0] + 2 + TURN + CROSS + 2 + 3,
        1,
        4,
    ),
    "RadiationPressure KeplerOrbit Facets": (IN_AXES_OF_THE_ORBIT + CROSS + 2 + 3, 0, 2),
    "RadiationPressure FixedPosition Facets Occulter": (WHOLE + CROSS + 2, 0, 0),
}
"""Products with squares, quotients and functions of a script for each shipped force as `FORCES` has it."""

MORE = {
    "EllipsoidGravity FixedPosition": 1,
    "MagneticMoment MagneticHarmonics": 3,
    "MagneticMoment SecularHarmonics": 4,
}
"""Further products of a program."""


@pytest.mark.parametrize("force", FORCES, ids=label)
def test_every_shipped_force_has_the_products_of_a_script(force, monkeypatch):
    monkeypatch.setattr(type(force), "check", lambda *_: None)
    operations = operations_of(pt.System(BODY, force))
    products, quotients, functions = SHIPPED[label(force)]
    count = Counter(map(type, operations))
    found = count[Product], count[Quotient], count[Function]
    assert found == (products + MORE.get(label(force), 0), quotients, functions)


def test_what_divides_once_divides_at_once():
    """One quotient, also where the divisor is used otherwise; where two are divided by one, its reciprocal, once."""
    graph = Graph()
    x, y = graph.symbol(0), graph.symbol(1)
    for formula, quotients, products in (
        (y / x + fn.sin(x), 1, 0),
        (x**1.3, 1, 0),
        (y / x + fn.sin(y) / x, 1, 2),
        (y / (1 / x), 0, 1),
        (2 / (1 / x) + y, 0, 0),
    ):
        count = Counter(map(type, simplified([formula, y]).decomposition.operations))
        assert (count[Quotient], count[Product]) == (quotients, products)


def test_what_differs_in_constants_alone_is_one_product():
    graph = Graph()
    x, y, (a, b, c) = graph.symbol(0), graph.symbol(1), map(graph.input, range(3))
    program = simplified([x * (a * y) - y * (b * x) + c * (x * y), a * y])
    assert sum(isinstance(operation, Product) for operation in program.decomposition.operations) == 1
    got = rates(program, [0.3, 0.9], [2.0, 0.7, -1.1])
    assert np.allclose(got, [0.3 * 0.9 * (2.0 - 0.7 - 1.1), 1.8], rtol=1e-15, atol=0)


def test_multiples_that_differ_in_sign_have_one_parameter():
    graph = Graph()
    x, y, a = graph.symbol(0), graph.symbol(1), graph.input(0)
    program = simplified([(2 * a) * x + (-2 * a) * y, (-2 * a) * y])
    assert program.decomposition.parameters == 1
    got = rates(program, [0.3, 0.9], [0.7])
    assert np.allclose(got, [1.4 * (0.3 - 0.9), -1.4 * 0.9], rtol=1e-15, atol=0)


def factors_by_counting(monomials):
    """Count all pairs of factors anew for each product."""
    ways, left = {}, {x: tuple((factor,) for factor in x) for x in monomials}
    while left:
        counts = Counter(pair for parts in left.values() for pair in set(itertools.combinations(parts, 2)))
        for x in [x for x, parts in left.items() if len(parts) == 2]:
            ways[x] = left.pop(x)
        known = [pair for pair in counts if tuple(sorted(sum(pair, ()))) in ways]
        best = max(known or counts, key=lambda pair: counts[pair])
        if left:
            ways[tuple(sorted(sum(best, ())))] = best
        for x, parts in left.items():
            if best in itertools.combinations(parts, 2):
                rest = Counter(parts) - Counter(best)
                left[x] = tuple(sorted([*rest.elements(), tuple(sorted(sum(best, ())))]))
    return ways


@pytest.mark.parametrize(("count", "factors", "length"), [(5, 3, 4), (20, 4, 6), (40, 12, 5), (60, 30, 4)])
def test_products_have_the_factors_that_most_of_them_have(count, factors, length):
    """As few as where all pairs are counted anew for each, which is not the least: either may be luckier."""
    counted_ways, counted = 0, 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        lengths = random.integers(2, length + 1, count)
        monomials = {tuple(sorted(random.integers(factors, size=n).tolist())) for n in lengths}
        ways = Factoring(monomials).ways
        assert monomials <= ways.keys()
        for product, pair in ways.items():
            assert tuple(sorted(sum(pair, ()))) == product
            assert all(len(part) == 1 or part in ways for part in pair)
        counted_ways, counted = counted_ways + len(ways), counted + len(factors_by_counting(monomials))
    assert abs(counted_ways - counted) <= 0.02 * counted
