"""What holds for every gravity between two bodies; a new one joins by one instance in `kinds/mutual_gravity.py`."""

import itertools
import re

import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from kinds import concrete_subclasses
from kinds.mutual_gravity import FORCES, PAIR
from poinsot.algebra.quaternion import product
from poinsot.functions import Vector
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph, Node, gradient, ordered, tangents

each_force = pytest.mark.parametrize("force", FORCES, ids=lambda force: type(force).__name__)

SEPARATION = np.array([1.9, -1.2, 1.4])
ATTITUDES = Rotation.random(2, np.random.default_rng(4)).as_quat(scalar_first=True)
PLACES = (slice(0, 3), slice(3, 7), slice(7, 11))
START = np.concatenate([SEPARATION, *ATTITUDES])


def instant(system, values):
    """Of separation and two quaternions, eleven scalars of any kind."""
    position, first, second = (Vector(values[place]) for place in PLACES)
    bodies = [(pt.Attitude.from_quaternion(q), Vector((0, 0, 0))) for q in (first, second)]
    return system.dynamics.instant(bodies, {"orbit": Vector((*position, 0, 0, 0))}, pt.mechanics.Environment(0))


def load(system, values):
    """Force and torques, nine scalars."""
    found = system.dynamics.load_at(instant(system, values))
    return [*found.force, *found.torques[0], *found.torques[1]]


def slopes_of_energy(system):
    """Minus those by the separation and by small turns about the axes of both bodies, by differences of 40 digits."""
    exact = formulas.copied(system, (mpmath.mpf(float(x)) for x in system.dynamics.numbers))
    start, step = [mpmath.mpf(float(x)) for x in START], mpmath.mpf(10) ** -10

    def moved(coordinate, by):
        values, k = list(start), coordinate % 3
        if coordinate < 3:
            values[k] += by
        else:
            turn = [mpmath.cos(by / 2), 0, 0, 0]
            turn[k + 1] = mpmath.sin(by / 2)
            place = PLACES[coordinate // 3]
            values[place] = product(Vector(start[place]), Vector(turn))
        return exact.dynamics.potential_at(instant(exact, values))

    return np.array([float((moved(k, -step) - moved(k, step)) / (2 * step)) for k in range(9)])


def test_every_gravity_of_two_bodies_is_here():
    shipped = {
        kind for kind in concrete_subclasses(pt.Potential) if kind.__module__.startswith("poinsot.forces.mutual")
    }
    assert shipped == {type(force) for force in FORCES}


@each_force
def test_force_and_torques_are_the_slopes_of_the_energy_in_all_engines(force):
    system = pt.System(PAIR, force)
    with mpmath.workdps(40):
        expected = slopes_of_energy(system)
    found = np.array(load(system, START), dtype=float)
    bound = 1e-14 * np.max(np.abs(expected))
    assert np.max(np.abs(found - expected)) < bound
    graph = Graph()
    symbols = [graph.symbol(k) for k in range(11)]
    compiled = WideEvaluator(load(formulas.copied(system, map(graph.input, itertools.count())), symbols), symbols)
    assert np.max(np.abs(np.array(compiled([*START, *system.dynamics.numbers])[:9]) - expected)) < bound
    numbers = [sympy.Float(float(x), 17) for x in START]
    assert np.max(np.abs(np.array(load(system, numbers), dtype=float) - expected)) < bound


@each_force
def test_derivatives_of_the_load_are_those_of_differences(force):
    """By all variables and numbers: what variational equations and derivatives by parameters take."""
    system, graph = pt.System(PAIR, force), Graph()
    inputs = [graph.input(k) for k in range(len(system.dynamics.numbers))]
    symbols = [graph.symbol(k) for k in range(11)]
    outputs = load(formulas.copied(system, inputs), symbols)
    values = [*START, *(float(x) for x in system.dynamics.numbers)]
    directions = np.random.default_rng(8).normal(size=(2, len(values)))
    directions[0, 11:], directions[1, :11] = 0, 0

    def at(shift):
        moved = np.array(values) + shift
        return np.array(load(formulas.copied(system, moved[11:]), moved[:11]), dtype=float)

    for direction in directions:
        seeds = dict(zip([*symbols, *inputs], direction, strict=True))
        known = dict(zip([*symbols, *inputs], values, strict=True))
        found = np.array(graph.evaluated(tangents(outputs, seeds), known), dtype=float)
        step = 1e-5
        expected = (8 * (at(step * direction) - at(-step * direction)) - at(2 * step * direction)) / (12 * step)
        expected += at(-2 * step * direction) / (12 * step)
        assert np.max(np.abs(found - expected)) < 1e-9 * np.max(np.abs(expected))


def products(outputs):
    """How many products and quotients of variables there are."""
    found = [node for node in ordered(outputs) if node.name in ("mul", "div")]
    return sum(all(isinstance(x, Node) and x.varies for x in node.operands) for node in found)


@each_force
def test_reverse_derivatives_cost_fewer_products_than_forward_ones(force):
    """The product of two variables has two in its derivatives, by however many variables there are."""
    system, graph = pt.System(PAIR, force), Graph()
    symbols = [graph.symbol(k) for k in range(11)]
    copied = formulas.copied(system, map(graph.input, range(len(system.dynamics.numbers))))
    energy = copied.dynamics.potential_at(instant(copied, symbols))
    forward = [tangents([energy], {symbol: 1.0})[0] for symbol in symbols]
    assert products([energy, *gradient(energy, symbols)]) <= 3 * products([energy])
    assert products([energy, *forward]) > 4 * products([energy])


def counts(name):
    """Return True if a number of a force counts: the masses and the extent of a field do not."""
    name = name.rpartition(".")[2]
    if name[0] not in "CS":
        return name not in ("mass", "extent")
    n, m = map(int, re.findall(r"\d+", name))
    return n >= 2 and (name[0] == "S") <= m <= n


@each_force
def test_each_number_that_counts_reaches_the_load(force):
    system = pt.System(PAIR, force)
    here, count = load(system, START), len(force.numbers)
    names = [name for name, _ in force.number_names()]
    for k, name in enumerate(names, start=len(system.dynamics.numbers) - count):
        numbers = [float(x) for x in system.dynamics.numbers]
        numbers[k] += 0.07
        there = load(formulas.copied(system, numbers), START)
        assert (np.max(np.abs(np.subtract(there, here).astype(float))) > 1e-7) == counts(name), name
