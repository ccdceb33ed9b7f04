"""Laws of every system on the kernel: double against quadruple precision, ensembles against single bodies.

Where formulas switch, an integration of Euler's equations with SciPy that starts anew at each switch judges too.
"""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds.forces import FORCES
from kinds.systems import BODY, START, SYSTEMS, Pole, start_of
from poinsot import functions as fn
from poinsot.functions import Vector
from poinsot.integration import equations
from poinsot.kinematics.state import state_of

EPS = np.finfo(float).eps
TIMES = np.array([-0.9, -0.55, -0.2, 0.0, 0.3, 0.7, 1.3, 1.9, 2.6])
"""On both sides of the start; every other one is read from dense output."""


EASY = [name for name in SYSTEMS if name != "needle"]
LATER = [name for name in EASY if name.startswith("orbit")][1::2]
"""Orbits that have their turn with `-m slow`: others share their formulas, and each has its own law."""
AT_REST = ("drag", "forces at rest and moving")
CASES = [
    *(
        pytest.param(name, "lie_poisson", START["omega_body"], marks=[pytest.mark.slow] * (name in LATER))
        for name in EASY
    ),
    *((name, "lie_poisson", (0.0, 0.0, 0.0)) for name in AT_REST),
    pytest.param("needle", "lie_poisson", (0.4, -0.3, 6.0), marks=pytest.mark.slow),
    *(pytest.param(name, "canonical", START["omega_body"], marks=pytest.mark.slow) for name in EASY if name != "drag"),
    ("drag", "canonical", START["omega_body"]),
]


@pytest.fixture(autouse=True)
def any_body(monkeypatch):
    """Whether or not the body of a force is the one that turns."""
    for force in FORCES:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


def values(motion):
    """All variables of a motion."""
    own = [motion.quaternion, motion.angular_momentum_body, *motion.own.values()]
    return np.concatenate([np.reshape(x, (*x.shape[: motion.quaternion.ndim - 1], -1)) for x in own], axis=-1)


def error(motion, judge):
    """The largest error, relative to the size of each variable."""
    size = np.maximum(np.max(np.abs(values(judge)), axis=0), np.finfo(float).tiny)
    return np.max(np.abs(values(motion) - values(judge)) / size)


@pytest.mark.samples
@pytest.mark.parametrize(("name", "formulation", "omega"), CASES)
def test_one_body(name, formulation, omega):
    system = pt.System(*SYSTEMS[name])
    start = start_of(system, omega)
    options = {"formulation": formulation, "dense": True}
    own = pt.propagate(system, start, TIMES[::2], **options)
    judge = pt.propagate(system, start, TIMES, formulation=formulation, precision="quadruple")
    # Rounding errors add up as the root of the steps. Starts some rounding errors away show how much the motion
    # multiplies them.
    floor = 4 * EPS * np.sqrt(own.run.steps)
    if name == "needle":  # the angular velocity about its axis is the momentum over a small moment
        floor *= max(system.of_bodies[""].moments) / min(system.of_bodies[""].moments)
    shaken = [start_of(system, np.multiply(omega, 1 + k * EPS)) for k in (-2, -1, 1, 2)]
    others = [pt.propagate(system, near, TIMES, formulation=formulation, precision="quadruple") for near in shaken]
    assert error(own(TIMES), judge) <= 3 * max(error(motion, judge) for motion in others) + floor
    np.testing.assert_allclose(values(own(TIMES[::2])), values(own), rtol=16 * EPS, atol=16 * EPS)
    back = pt.propagate(system, start, TIMES[::-2], formulation=formulation)
    assert np.array_equal(values(back)[::-1], values(own))


# ---------------------------------------------------------------------- ensembles


def members_of(system, count, factor=1.0):
    """Starts of members at times of their own, fast and slow ones in turn, some of them among the times."""
    random = np.random.default_rng(5)
    omega = factor * random.normal(size=(count, 3)) * (1 + np.arange(count) % 4)[:, None]
    return start_of(system, omega, np.array([0.0, -0.4, 0.7, 2.6, -0.9, 0.31])[np.arange(count) % 6])


def alone(system, start, k, **options):
    phase = {name: np.broadcast_to(x, (17, x.shape[-1]))[k] for name, x in start.phase.items()}
    return pt.propagate(system, state_of(phase, np.float64(start.time[k])), TIMES, **options)


ENSEMBLES = (
    "force: UniformGravity",
    "long ellipse in comoving axes",
    "part and forces",
    "spin-up",
    "drag",
    pytest.param("table with knots", marks=pytest.mark.slow),
)


@pytest.mark.parametrize("name", ENSEMBLES)
def test_members(name, monkeypatch):
    system = pt.System(*SYSTEMS[name])
    start = members_of(system, 17)
    together, judges = (pt.propagate(system, start, TIMES, precision=p) for p in ("double", "quadruple"))
    floor = 4 * EPS * np.sqrt(together.run.steps / 17)
    shaken = pt.propagate(system, members_of(system, 17, 1 + 2 * EPS), TIMES, precision="quadruple")
    for k in range(17):
        assert error(together[k], judges[k]) <= 3 * error(shaken[k], judges[k]) + floor
        assert np.array_equal(values(alone(system, start, k)), values(together[k]))
        assert np.array_equal(values(alone(system, start, k, precision="quadruple")), values(judges[k]))
    counts = (1, 7, 9, 17)
    for i, lanes in enumerate((1, 2, 4, 8)):  # each meets three counts, one and two threads
        monkeypatch.setattr(equations, "LANES", lanes)
        for count, threads in ((counts[i], 1), (counts[i - 1], 2), (counts[i - 2], 2)):
            few = pt.propagate(system, first(start, count), TIMES[::-1], threads=threads)
            assert np.array_equal(values(few)[:, ::-1], values(together)[:count]), (lanes, count, threads)


def first(start, count):
    phase = {name: x[:count] if x.ndim > 1 else x for name, x in start.phase.items()}
    return state_of(phase, start.time[:count])


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_a_member_that_fails_disturbs_no_other(lanes, monkeypatch):
    monkeypatch.setattr(equations, "LANES", lanes)
    poles = np.where(np.arange(9) % 4 == 1, 1.0, 9.0)
    together = pt.propagate(pt.System(BODY, Pole(poles)), start_of(pt.System(BODY)), TIMES)
    assert list(together.failures) == [1, 5]
    for k, pole in enumerate(poles):
        own = values(together[k])
        if pole == 1.0:
            assert np.array_equal(together[k].times, TIMES[TIMES < 1])
            assert np.all(np.isfinite(own))
        else:
            one = pt.propagate(pt.System(BODY, Pole(pole)), start_of(pt.System(BODY)), TIMES)
            assert np.array_equal(own, values(one))


# ---------------------------------------------------------------------- formulas that switch


class Window(pt.Torque):
    """A torque between two times."""

    begin: float
    off: float

    def torque(self, instant):
        inside = fn.where(instant.time < self.begin, 0.0, fn.where(instant.time < self.off, 1.0, 0.0))
        return inside * Vector((0.3, -0.1, 0.2))

    @staticmethod
    def plain(time, _axes, _omega, branches, on, off):
        return (~branches[0] & branches[1]) * np.array((0.3, -0.1, 0.2)), [time - on, time - off]


class Corner(pt.Torque):
    """A torque that changes its sign with a component of a body axis."""

    size: float

    def torque(self, instant):
        tilt = instant.attitude.to_space((0.0, 0.0, 1.0))[0]
        return Vector((0.1, 0.0, self.size * fn.sign(tilt)))

    @staticmethod
    def plain(_time, axes, _omega, branches, size):
        return np.array((0.1, 0.0, -size if branches[0] else size)), [axes[0, 2]]


class Saturated(pt.Torque):
    """A feedback of attitude and rate that each wheel limits."""

    gain: float
    limit: float

    def torque(self, instant):
        axis, omega = instant.attitude.to_body((1.0, 0.0, 0.0)), instant.omega_body
        wanted = (-omega[0], -axis[2] - omega[1], axis[1] - omega[2])
        return Vector([fn.clip(self.gain * x, -self.limit, self.limit) for x in wanted])

    @staticmethod
    def plain(_time, axes, omega, branches, gain, limit):
        axis = axes[0]
        wanted = gain * np.array((-omega[0], -axis[2] - omega[1], axis[1] - omega[2]))
        sides = np.reshape(branches, (2, 3))
        torque = [(-limit, x, limit)[1 - low + high] for x, low, high in zip(wanted, *sides, strict=True)]
        return np.array(torque), [*(wanted + limit), *(limit - wanted)]


SWITCHED = {
    "a time": Window(0.2, 1.6),
    "times that are rows": Window(-0.2, 0.7),
    "a time before all": Window(-7.0, 9.0),
    "the attitude": Corner(0.4),
    "a limit": Saturated(0.8, 0.2),
    "a limit that is never reached": Saturated(0.8, 20.0),
}


def restarted(force, start, time):
    """Return quaternion and rates at a time, from SciPy's integrator with the branch held up to the next switch."""
    moments, numbers = np.array(BODY.moments), [*map(float, force.numbers)]

    def plain(t, y, branches):
        return force.plain(t, Rotation.from_quat(y[:4], scalar_first=True).as_matrix(), y[4:], branches, *numbers)

    def rate(t, y, branches):
        w, axis, omega = y[0], y[1:4], y[4:]
        turning = 0.5 * np.array([-axis @ omega, *(w * omega + np.cross(axis, omega))])
        return np.concatenate([turning, (plain(t, y, branches)[0] - np.cross(omega, moments * omega)) / moments])

    step, here, y = 1e-9 * np.sign(time), 0.0, np.concatenate([start.quaternion, START["omega_body"]])
    while here != time:
        branches = np.zeros(6, dtype=bool)
        for ahead in (0.0, step):  # those of the start, then those just behind it
            branches = np.less(plain(here + ahead, y + ahead * rate(here, y, branches), branches)[1], 0)
        events: list[Any] = [lambda t, y, now, i=i: plain(t, y, now)[1][i] for i in range(branches.size)]
        for event, holds in zip(events, branches, strict=True):
            event.terminal, event.direction = True, 1 if holds else -1
        options = {"args": (branches,), "events": events, "rtol": 1e-13, "atol": 1e-14}
        found = solve_ivp(rate, (here, time), y, "DOP853", **options)
        here, y = found.t[-1], found.y[:, -1]
    return y


@pytest.mark.parametrize("name", SWITCHED)
def test_switches(name):
    force = SWITCHED[name]
    system = pt.System(BODY, force)
    start = start_of(system)
    own = pt.propagate(system, start, TIMES[::2], dense=True)
    judge = pt.propagate(system, start, TIMES, precision="quadruple")
    # A switch is at most 16 rounding errors of the time, or of a step, from its own time.
    floor = 16 * EPS * np.max(np.abs(TIMES)) + 4 * EPS * np.sqrt(own.run.steps)
    assert error(own(TIMES), judge) <= 10 * floor
    for time in TIMES[[0, 6, 8]]:
        expected, found = restarted(force, start, time), own(time)
        variables = np.concatenate([found.quaternion, system.omega_body(found)])
        assert np.allclose(variables, expected, rtol=0, atol=1e-12)
    assert np.array_equal(values(pt.propagate(system, start, TIMES[::-2]))[::-1], values(own))


@pytest.mark.parametrize("precision", ["double", "quadruple"])
@pytest.mark.parametrize("name", SWITCHED)
def test_switches_of_members(name, precision, monkeypatch):
    force = SWITCHED[name]
    shifts = np.linspace(0.9, 1.1, 17)
    system = pt.System(BODY, force.with_numbers([number * shifts for number in force.numbers]))
    start = members_of(system, 17)
    for lanes in (1, 2, 4, 8) if precision == "double" else (4, 8):
        monkeypatch.setattr(equations, "LANES", lanes)
        together = pt.propagate(system, start, TIMES, precision=precision)
        for k in range(17):
            one = pt.System(BODY, force.with_numbers([number * shifts[k] for number in force.numbers]))
            assert np.array_equal(values(alone(one, start, k, precision=precision)), values(together[k]))


# ---------------------------------------------------------------------- events


class Kick(pt.events.AxisCrossing):
    """What turns and shortens the momentum."""

    def act(self, body, state):
        x, y, z = state.angular_momentum_body
        changed = 0.9 * np.array([y, -x, z])
        return body.state(state.quaternion, angular_momentum_body=changed, time=state.time)


EVENTS = {
    "recorded": [pt.events.RateCrossing((0.2, 1.0, 0.1)), pt.events.AtTime(0.7)],
    "falling": [pt.events.RateCrossing((0.2, 1.0, 0.1), direction=-1)],
    "terminal": [
        pt.events.RateCrossing((1.0, 0.0, 0.1)),
        pt.events.AxisCrossing((0, 1, 0), (0.3, 0, 1), terminal=True),
    ],
    "acting": [Kick((0, 0, 1), (1, 0.2, 0)), pt.events.RateCrossing((0.2, 1.0, 0.1))],
}
WATCHED = [
    *((kind, "a limit") for kind in ("recorded", "terminal")),
    ("acting", "forces at rest and moving"),
    *(pytest.param(kind, "table with knots", marks=pytest.mark.slow) for kind in EVENTS),
    *(pytest.param(kind, "a limit", marks=pytest.mark.slow) for kind in ("falling", "acting")),
]


@pytest.mark.parametrize(("kind", "name"), WATCHED)
def test_events(kind, name, monkeypatch):
    system = pt.System(BODY, SWITCHED[name]) if name in SWITCHED else pt.System(*SYSTEMS[name])
    start, options = members_of(system, 17), {"events": EVENTS[kind]}
    double, quadruple = (pt.propagate(system, start, TIMES, precision=p, **options) for p in ("double", "quadruple"))
    assert sum(map(len, double.events)) > 5
    assert np.array_equal(np.isfinite(double.quaternion), np.isfinite(quadruple.quaternion))
    for own, other in zip(double.events, quadruple.events, strict=True):
        assert np.array_equal(own.members, other.members)
        assert np.array_equal(own.directions, other.directions)
        assert np.allclose(own.times, other.times, rtol=0, atol=2e-13)
        assert np.allclose(own.states.quaternion, other.states.quaternion, rtol=0, atol=1e-12)
    singles = [alone(system, start, k, **options) for k in range(17)]
    for lanes in (1, 4, 8):
        monkeypatch.setattr(equations, "LANES", lanes)
        together = pt.propagate(system, start, TIMES, **options)
        for k, one in enumerate(singles):
            assert np.array_equal(values(one), values(together[k]))
            for own, other in zip(one.events, together.events, strict=True):
                assert np.array_equal(own.times, other.member(k).times)
                assert np.array_equal(own.states.quaternion, other.member(k).states.quaternion)


def kicked(name):
    """Return random starts, and starts that are one but for rounding."""
    rng = np.random.default_rng(5)
    if name == "in ulps":
        near = members_of(pt.System(*SYSTEMS["table with knots"]), 17)
        own = {quantity: np.broadcast_to(x, (17, x.shape[-1]))[13] for quantity, x in near.phase.items()}
        shaken = {quantity: x * (1 + EPS * rng.integers(-1, 2, (200, x.size))) for quantity, x in own.items()}
        return state_of(shaken, near.time[13])
    q = rng.normal(size=(1000, 4))
    return BODY.state(q / np.linalg.norm(q, axis=1)[:, None], omega_body=rng.normal(size=(1000, 3)))


@pytest.mark.parametrize("name", ["in ulps", "table with knots", "no force"])
def test_actions_happen_once(name):
    """The value that an action leaves is zero but for rounding: that is no zero ahead, however slowly it changes."""
    system = pt.System(*SYSTEMS.get(name, SYSTEMS["table with knots"]))
    motion = pt.propagate(system, kicked(name), [2.6], events=list(EVENTS["acting"])[:1])
    assert not motion.failures
    found = motion.events[0]
    follows = found.members[1:] == found.members[:-1]
    assert np.min(np.diff(found.times)[follows]) > 1e-9
    # The way in which a value leaves zero is opposite to that in which it comes back.
    x, y, z = np.moveaxis(found.states.angular_momentum_body, -1, 0)
    omega = 0.9 * np.stack([y, -x, z], axis=-1) / BODY.moments
    turning = Rotation.from_quat(found.states.quaternion, scalar_first=True).apply(np.cross(omega, (0, 0, 1)))
    rate = turning @ (1, 0.2, 0)
    assert np.array_equal(found.directions[1:][follows], -np.sign(rate[:-1][follows]))
