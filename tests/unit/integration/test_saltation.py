"""At which switches tangent vectors jump, several at once, and where a motion has no derivative by its start."""

from dataclasses import replace

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.kernel_parameters import formulas_of
from poinsot.integration.problem import Problem
from poinsot.integration.variational import Variations

BODY = pt.Body((1.0, 1.3, 1.7))
START = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))


def torque_of(formula):
    """Return a torque about the third axis of a formula of an instant and a number p."""

    class Own(pt.Torque):
        p: float

        def torque(self, instant):
            return fn.Vector((0.0, 0.0, formula(instant, self.p)))

    return Own


def height(instant):
    return instant.attitude.to_body((0.6, 0.0, 0.8))[0]


FORMULAS = {
    "maximum": (lambda i, p: fn.maximum(0.0, height(i) - p), 0, 1),
    "minimum of two": (lambda i, p: fn.minimum(height(i), p * i.omega_body[0]), 0, 1),
    "clip": (lambda i, p: fn.clip(height(i), -p, p), 0, 2),
    "abs": (lambda i, p: p * abs(height(i)), 0, 1),
    "corner that is not seen": (lambda i, p: fn.where(fn.less(height(i), p), 2 * height(i), height(i) + p), 1, 1),
    "sign": (lambda i, p: fn.sign(height(i) - p), 2, 2),
    "jump": (lambda i, p: fn.where(fn.less(height(i), p), 1.0, -1.0), 1, 1),
    "jump next to a corner": (lambda i, p: fn.maximum(0.0, height(i)) + fn.where(height(i) > 0.1, p, 0.0), 1, 2),
    "time": (lambda i, p: fn.where(fn.less(i.time, 0.5), p, 0.0), 0, 0),
    "time that a number says": (lambda i, p: fn.where(fn.less(i.time, p), 1.0, 0.0), 1, 1),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_what_tangent_vectors_stop_at(name):
    """To first order where a formula jumps, to second order at corners too, and nowhere for the time alone."""
    formula, *expected = FORMULAS[name]
    problem = Problem(pt.System(BODY, torque_of(formula)(0.3)))
    plain = equations.state_vector(problem, START, FORMULATIONS["lie_poisson"], "double")
    for order, stops in zip((1, 2), expected, strict=True):
        variations = Variations(plain.tangent_scales, 6, ((len(problem.numbers),),), order)
        found = formulas_of(problem, replace(plain, variations=variations)).saltation
        assert len(found.stops if found else ()) == stops


class Burns(pt.Torque):
    """Two thrusters about the third axis, and one more while both fire."""

    first: float
    second: float
    both: float = 0.0

    def torque(self, instant):
        one, two = (fn.where(fn.less(instant.time, end), 1.0, 0.0) for end in (self.first, self.second))
        return fn.Vector((0.0, 0.0, 0.3 * one + 0.5 * two + self.both * one * two))


def test_two_burns_that_end_at_once():
    system = pt.System(BODY, Burns(0.7, 0.7))
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.1))
    found = pt.analysis.state_transition(system, start, [2.0], ["first", "second"]).sensitivity[0]
    np.testing.assert_allclose(found[5], (0.3, 0.5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(found[2], np.array((0.3, 0.5)) * 1.3 / 1.7, rtol=0, atol=1e-14)


def test_a_switch_that_switches_another_one():
    """What jumps over zero with the time of a burn goes by the end of the burn."""

    def formula(instant, p):
        level = fn.where(fn.less(instant.time, p), 5.0, -5.0)
        return fn.where(fn.less(instant.omega_body[2], level), 0.3, -0.2)

    system = pt.System(BODY, torque_of(formula)(0.7))
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.1))
    found = pt.analysis.state_transition(system, start, [2.0], ["p"])
    np.testing.assert_allclose(found.sensitivity[0, [2, 5], 0], (0.5 * 1.3 / 1.7, 0.5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.matrix[0, [2, 5], [5, 5]], (2 / 1.7, 1.0), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("formula", "sentence"),
    [
        (lambda i, p: fn.where(fn.less((i.time - 1) ** 3, p), 0.1, 0.0), "it grazes the switch of a `where`"),
        (
            lambda i, p: fn.where(fn.less(fn.atan2(fn.sin(i.time), fn.cos(i.time)) + i.omega_body[0], p), 0.1, 0.0),
            "the condition of a `where` jumps.",
        ),
    ],
)
def test_where_neighbours_have_no_derivative(formula, sentence):
    system = pt.System(BODY, torque_of(formula)(0.0))
    with pytest.raises(pt.PropagationError, match=sentence):
        pt.analysis.state_transition(system, START, [5.0], ["p"])
