"""Every result of the package, by a function that makes it, and its contents as plain numbers."""

import functools
from collections.abc import Mapping

import numpy as np
import pytest

import poinsot as pt
from public_calls import (
    BODY,
    CIRCLE,
    CORNERS,
    ELLIPSE,
    ESTIMATE,
    FACES,
    PRECESSING,
    SATELLITE,
    SCENARIO,
    SIGNAL,
    START,
    TIMES,
    TOP,
    along_orbit,
    branch,
    ephemeris,
    free,
    indicators,
    motion,
    pair_motion,
    periodic,
    table,
    text,
    transition,
    where,
)


class Drag(pt.Torque):
    """A force of the user's own."""

    coefficient: float

    def torque(self, instant):
        return pt.functions.Vector(-self.coefficient * component for component in instant.omega_body)


class Nearest(pt.Event):
    """Of two bodies: the extremes of their distance."""

    name = "nearest"

    def value(self, instant):
        return pt.functions.dot(instant.separation, instant.relative_velocity)


class Runaway(pt.Torque):
    """It makes the rate infinite in a finite time."""

    def torque(self, instant):
        return pt.functions.Vector(9 * component**3 for component in instant.omega_body)


CROSSING = pt.events.AxisCrossing((1, 0, 0), (0, 0, 1))


def members():
    return pt.State([START.quaternion] * 3, [START.conjugate_momenta] * 3)


def stopped():
    with pytest.raises(pt.PropagationError) as caught:
        pt.propagate(pt.System(BODY, Runaway()), START, TIMES)
    return caught.value


PAIR = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=[0.4, 0.5]), G=1.0)
ONE_PAIR = pt.TwoBodies(PAIR.primary, pt.Body((0.1, 0.12, 0.15), mass=0.5), G=1.0)
TURNS = (START.quaternion, (0.5, 0.5, -0.5, 0.5))


def of_two(pair=ONE_PAIR, **options):
    spins = [(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)]
    start = pair.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=spins)
    system = pt.System(pair, pt.forces.MutualGravity(), pt.forces.LinearDamping(1e-3).on("secondary"))
    return pt.propagate(system, start, np.linspace(0, 40, 5), **options)


def scenario(folder):
    return pt.files.read_scenario(text(folder / "top.toml", SCENARIO))


def loaded(folder):
    return pt.load(pt.save(motion(), folder / "m.nc", overwrite=True))


RESULTS = {
    "Revolutions": lambda _: pt.analysis.revolutions(pair_motion()),
    "Bifurcation": lambda _: next(iter(branch().bifurcations), None),
    "Branch": lambda _: branch(),
    "CassiniState": lambda _: pt.analysis.cassini_state(SATELLITE.body, PRECESSING, obliquity=0.1),
    "ChaosIndicators": lambda _: indicators(),
    "EventRecord": lambda _: pt.propagate(TOP, START, TIMES, events=[CROSSING]).events[0],
    "Ephemeris": lambda _: ephemeris(),
    "Equilibrium": lambda _: pt.analysis.equilibria(SATELLITE, CIRCLE.frame, guesses=(1.0, 0, 0, 0)),
    "Librations": lambda _: pt.analysis.librations(pair_motion()),
    "LineIdentification": lambda _: pt.analysis.identify_lines(
        pt.analysis.frequencies(SIGNAL, 0.1, 2), base=(1.0, 0.3)
    )[0],
    "LineSpectrum": lambda _: pt.analysis.frequencies(SIGNAL, 0.1, 2),
    "LyapunovSpectrum": lambda _: pt.analysis.lyapunov_spectrum(TOP, START, [1.0]),
    "ObservedPartials": lambda _: pt.analysis.observed_partials(TOP, START, pt.observables.Gyro(), [1.0]),
    "OsculatingElements": lambda _: pair_motion().elements,
    "PairEquilibrium": lambda _: pt.analysis.pair_equilibria(pair_motion().system, pair_motion().initial)[0],
    "PeriodicMotion": lambda _: periodic(),
    "PropagationError": lambda _: pt.PropagationError("it stopped.", 1.0, motion()),
    "PropagationInterrupted": lambda _: pt.PropagationInterrupted("it stopped.", 1.0, free()),
    "RunEstimate": lambda _: ESTIMATE,
    "Scenario": scenario,
    "Section": lambda _: pt.analysis.section(motion(), where),
    "SecularEvolution": lambda _: pt.analysis.secular_evolution([lambda _: {"rate": 0.1}], {"rate": 1.0}, TIMES),
    "StateTransition": lambda _: transition(),
    "Trajectory": lambda _: motion(),
    "YorpCoefficients": lambda _: pt.analysis.yorp_coefficients(
        pt.shapes.Mesh(CORNERS, FACES, mass=2.0), np.linspace(0, np.pi, 9)
    ),
    "FreeRotation": lambda _: pt.analysis.FreeRotation(BODY, START),
    "Andoyer": lambda _: pt.Andoyer.from_state(START),
    "Andoyer's variables of members": lambda _: pt.Andoyer.from_state(members()),
    "AttitudeTable": lambda _: table(),
    "closed form": lambda _: free(),
    "ensemble": lambda _: pt.propagate(SATELLITE, members(), TIMES),
    "along an ellipse": lambda _: pt.propagate(pt.System(BODY, pt.GravityGradient(ELLIPSE)), START, TIMES, dense=True),
    "both ways, in quadruple precision": lambda _: pt.propagate(
        TOP, START, TIMES - 1, dense=True, precision="quadruple", events=[pt.events.SpinFlip((1, 0, 0))]
    ),
    "own force": lambda _: pt.propagate(pt.System(BODY, Drag(0.1)), START, TIMES, dense=True),
    "relative to a frame": lambda _: along_orbit().relative_to(CIRCLE.frame),
    "read from a file": loaded,
    "stopped": lambda _: stopped(),
    "Trajectory of two bodies": lambda _: of_two(dense=True, events=[Nearest()]),
    "one of two bodies": lambda _: of_two(dense=True).secondary,
    "ensemble of two bodies": lambda _: of_two(PAIR, formulation="canonical"),
    "one of an ensemble of two bodies": lambda _: of_two(PAIR).primary,
    "state of two bodies": lambda _: of_two().initial,
    "events of two bodies": lambda _: of_two(events=[Nearest()]).events[0],
}


def contents(thing, seen=()):
    """What there is to read in a thing, as plain numbers, texts and bytes."""
    if isinstance(thing, np.ndarray):
        return (thing.shape, thing.tobytes())
    if isinstance(thing, Mapping):
        return {str(key): contents(value, seen) for key, value in thing.items()}
    if isinstance(thing, list | tuple):
        return [contents(item, seen) for item in thing]
    if type(thing).__module__.startswith("poinsot") or isinstance(thing, Drag | Runaway | Nearest):
        if id(thing) in seen:
            return "again"
        own = [
            name for name in vars(thing) if not isinstance(getattr(type(thing), name, None), functools.cached_property)
        ]
        names = [*own, *(name for name in READ if hasattr(thing, name))]
        public = {name: getattr(thing, name) for name in names if not name.startswith("_") and name not in UNREAD}
        return type(thing).__qualname__, contents(public, (*seen, id(thing)))
    return repr(thing) if not callable(thing) else getattr(thing, "__qualname__", "")


STATE = ("phase", "quaternion", "conjugate_momenta", "angular_momentum_body")
READ = (
    *STATE,
    "events",
    "position",
    "momentum",
    "energy",
    "drift",
    "integrals",
    "matrix",
    "numbers",
    "structure",
    "args",
)
UNREAD = ("environment", "origin_of", "alike", "results")
DESCRIPTIONS = {"Ephemeris", "PropagationError", "PropagationInterrupted", "stopped"}
"""An orbit, and errors, which have a sentence."""
