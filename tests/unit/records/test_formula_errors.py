"""Faults in formulas of the user's own: each message names the formula, the fault and the remedy."""

import math
import re
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.functions import Vector

BODY = pt.Body((1.25, 1.0, 0.75))
RATE = (0.1, 0.2, 0.3)
FUNCTIONS: Any = pt.functions
START = BODY.state((1, 0, 0, 0), omega_body=RATE)


def moved(*forces):
    system = pt.System(BODY, *forces)
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=RATE), [0.0, 1.0])
    return motion.energy, motion.omega_body


def potential(formula):
    class Mine(pt.Potential):
        gain: float

        def energy(self, instant):
            return formula(self, instant, instant.time)

    return lambda: moved(Mine(2.0))


def torque(formula):
    class Mine(pt.Torque):
        gain: float

        def torque(self, instant):
            return Vector((formula(self, instant, instant.time), 0.0, 0.0))

    return lambda: moved(Mine(2.0))


def control_law(formula):
    class Mine(pt.Torque):
        gain: float

        def torque(self, instant):
            return Vector((formula(self, instant, instant.time), 0.0, 0.0))

    return lambda: moved(pt.control.Sampled(Mine(2.0), period=0.5))


def part(method):
    def made(formula):
        def value(name, record, instant, time, plain):
            return formula(record, instant, time) if name == method else plain

        class Mine(pt.Part):
            gain: float
            variables = {"angle": 1}  # noqa: RUF012

            def rates(self, instant, generalised_force):  # noqa: ARG002
                return Vector((value("rates", self, instant, instant.time, 0.1),))

            def start(self, time, omega_body):  # noqa: ARG002
                return Vector((value("start", self, None, time, 0.0),))

            def momentum(self, own, time):
                return Vector((0.0, 0.0, value("momentum", self, None, time, 0.1 * own[0])))

            def internal_energy(self, own, time):
                return value("internal_energy", self, None, time, own[0])

        return lambda: moved(Mine(2.0))

    return made


def event(formula):
    class Mine(pt.Event):
        gain: float

        def value(self, instant):
            return formula(self, instant, instant.time)

    return lambda: pt.propagate(pt.System(BODY), START, [0.0, 1.0], events=[Mine(2.0)])


def orbit(method):
    def made(formula):
        class Mine(pt.Orbit):
            mu: float
            gain: float

            def position_at(self, time):
                return Vector((formula(self, None, time) if method == "position_at" else 3.0, 2.0, 0.0))

            def velocity_at(self, time):
                return Vector((formula(self, None, time) if method == "velocity_at" else 0.0, 0.0, 0.0))

        return lambda: moved(pt.GravityGradient(Mine(1.0, 2.0)))

    return made


def frame(method):
    def made(formula):
        class Mine(pt.mechanics.Frame):
            gain = 2.0

            def quaternion(self, time):
                if method == "quaternion":
                    formula(self, None, time)
                return np.tile([1.0, 0, 0, 0], (*np.shape(time), 1))

            def omega_space(self, time):
                if method == "omega_space":
                    formula(self, None, time)
                return np.zeros((*np.shape(time), 3))

        motion = pt.propagate(pt.System(BODY), START, [0.0, 1.0])
        return lambda: (motion.relative_to(Mine()).quaternion, motion.relative_to(Mine()).omega_body)

    return made


OF_INSTANTS = {
    "energy": potential,
    "torque": torque,
    "torque of a control law": control_law,
    "rates": part("rates"),
    "value": event,
}
OF_TIMES = {
    "start": part("start"),
    "momentum": part("momentum"),
    "internal_energy": part("internal_energy"),
    "position_at": orbit("position_at"),
    "velocity_at": orbit("velocity_at"),
    "quaternion": frame("quaternion"),
    "omega_space": frame("omega_space"),
}
ALL = OF_INSTANTS | OF_TIMES


def raises(call, message):
    with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
        call()


@pytest.mark.parametrize("name", ALL)
def test_formulas_without_a_fault_run(name):
    ALL[name](lambda record, _, time: record.gain * pt.functions.sin(time) / 100)()


@pytest.mark.parametrize("name", ALL)
def test_a_mistyped_parameter_is_named_with_the_nearest_one(name):
    made = ALL[name](lambda record, _, time: record.gian * time)
    raises(
        made, f"Mine.{name.partition(' ')[0]} must use attributes that exist, got 'gian' of Mine. Did you mean 'gain'?"
    )


MISTYPED = {
    "instant": (lambda instant: instant.omega_bdy[0], "'omega_bdy' of Instant. Did you mean 'omega_body'?"),
    "attitude": (lambda instant: instant.attitude.to_bdy(RATE)[0], "'to_bdy' of Attitude. Did you mean 'to_body'?"),
    "functions": (
        lambda instant: FUNCTIONS.sinn(instant.time),
        "'sinn' of poinsot.functions. Did you mean 'sin'?",
    ),
    "nothing near": (lambda instant: instant.zzz, "'zzz' of Instant."),
}


@pytest.mark.parametrize("thing", MISTYPED)
@pytest.mark.parametrize("name", OF_INSTANTS)
def test_a_mistyped_attribute_is_named_with_the_nearest_one(name, thing):
    formula, fault = MISTYPED[thing]
    made = OF_INSTANTS[name](lambda _, instant, __: formula(instant))
    raises(made, f"Mine.{name.partition(' ')[0]} must use attributes that exist, got {fault}")


def test_a_mistyped_attribute_of_an_action_is_named():
    class Mine(pt.Event):
        def value(self, instant):
            return instant.omega_body[0] - 0.11

        def act(self, body, phase):  # noqa: ARG002
            return body.momnets

    with pytest.raises(pt.PropagationError, match=r"got 'momnets' of Body\. Did you mean 'moments'\?\.$"):
        pt.propagate(pt.System(BODY), START, [0.0, 20.0], events=[Mine()])


NUMERICAL = {  # functions of NumPy compute with the numbers that these formulas are called with
    "internal_energy",
    "velocity_at",
    "quaternion",
    "omega_space",
}


@pytest.mark.parametrize("name", sorted(ALL.keys() - NUMERICAL))
def test_functions_of_numpy_on_symbols_are_named_with_their_counterparts(name):
    rule = f"Mine.{name.partition(' ')[0]} must use + - * / ** and poinsot.functions alone"
    raises(ALL[name](lambda _, __, time: np.sin(time)), f"{rule}, got numpy.sin. Write poinsot.functions.sin.")


@pytest.mark.parametrize("name", sorted(ALL.keys() - {"velocity_at"}))
def test_functions_of_math_are_named_with_their_counterparts(name):
    rule = f"Mine.{name.partition(' ')[0]} must use + - * / ** and poinsot.functions alone"
    raises(ALL[name](lambda _, __, time: math.sin(time)), f"{rule}, got math.sin. Write poinsot.functions.sin.")


COUNTERPARTS = {
    **{name: name for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "abs", "sign")},
    **{"absolute": "abs", "fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan"},
}


@pytest.mark.parametrize("name", COUNTERPARTS)
def test_each_function_of_numpy_with_a_counterpart_is_named(name):
    foreign = getattr(np, name)
    with pytest.raises(TypeError, match=rf"poinsot\.functions\.{COUNTERPARTS[name]}\.$"):
        torque(lambda _, __, time: foreign(time))()


def test_a_function_without_a_counterpart_is_refused_with_the_functions_that_exist():
    existing = "abs, acos, asin, atan, atan2, clip, cos, cross, dot, eccentric_anomaly, exp, interp, less, log, "
    existing += "maximum, minimum, norm, sign, sin, sqrt, tan, tanh, where"
    rule = "Mine.torque must use + - * / ** and poinsot.functions alone"
    raises(torque(lambda _, __, time: np.cbrt(time)), f"{rule}, got numpy.cbrt. These are {existing}.")


def test_a_state_without_the_variables_of_parts_names_system_state():
    message = "state must have the 3 variables of the part 'kane_damper', got 0. Make it by system.state(...)."
    system = pt.System(BODY, pt.parts.KaneDamper(0.1, 0.2))
    for call in (pt.propagate, pt.analysis.state_transition, pt.analysis.chaos_indicators):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
            call(system, START, [0.0, 1.0])
