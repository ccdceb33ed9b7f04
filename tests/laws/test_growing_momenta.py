"""Momenta that grow or shrink by many orders of magnitude on the way: every kind of run keeps q and g to rounding.

A torque k omega on a sphere of inertia I keeps the axis: g = g0 exp(s), s = k t / I, and the body turns by
g0 (exp(s) - 1) / k about it. With a torque k omega sin t, s = k (1 - cos t) / I.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ive

import poinsot as pt
from poinsot import functions

EPS = np.finfo(float).eps
INERTIA, RATE = 2.0, 0.1
BALL = pt.Body((INERTIA,) * 3)
AXIS = np.array([0.36, -0.48, 0.8])
TILTED = Rotation.from_euler("ZXZ", [0.3, 1.1, 0.4])
FACTORS = (1e-9, 1e-3, 1e9, 1e13)
ORBIT = pt.KeplerOrbit(
    1.0,
    semimajor_axis=4.0,
    eccentricity=0.2,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=0.3,
    epoch=0.0,
)
FORMULATIONS = ("lie_poisson", "canonical", "euler_angles", "planar")


class Spinning(pt.Torque):
    """k omega."""

    k: float

    def torque(self, instant):
        return self.k * instant.omega_body


class Swinging(pt.Torque):
    """k omega sin t."""

    k: float

    def torque(self, instant):
        return self.k * functions.sin(instant.time) * instant.omega_body


class Switched(pt.Torque):
    """k omega, until a time."""

    k: float
    end: float

    def torque(self, instant):
        on = functions.where(functions.less(instant.time, self.end), self.k, 0.0)
        return on * instant.omega_body


class Kick(pt.events.AtTime):
    """Gives the body an angular momentum."""

    momentum: pt.mechanics.Vector

    def act(self, body, state):
        return body.state(state.quaternion, angular_momentum_body=self.momentum, time=state.time)


def start(formulation, factor):
    """Return attitude and axis of rotation of a start, and its rate: the larger rate is 1."""
    rate = 1.0 if factor < 1 else 1 / factor
    if formulation == "planar":
        return Rotation.from_rotvec([0, 0, 0.3]), np.array([0.0, 0.0, 1.0]), rate
    return TILTED, np.array([0.0, 0.0, 1.0]) if formulation == "euler_angles" else AXIS, rate


def grown(factor, way=1, rate=1.0):
    """Return a torque by which momenta change by a factor in a time, backwards too, that time and the angle."""
    s = np.log(factor)
    return (
        Spinning(way * RATE * INERTIA * np.sign(s)),
        way * abs(s) / RATE,
        way * rate * (factor - 1) / RATE / np.sign(s),
    )


def check(motion, attitude, turned, omega, index=-1):
    """Check attitude and rate; a rounding of the rate in each step turns the body by so much of its angle.

    The bound is three times the worst of shaken starts: momenta that have shrunk next to Euler angles of some turns,
    relative to which truncation is.
    """
    bound = 7 * max(motion.run.steps, 50) * EPS
    q, w = motion.quaternion.reshape(-1, 4)[index], motion.omega_body.reshape(-1, 3)[index]
    expected = (attitude * Rotation.from_rotvec(turned)).as_quat(scalar_first=True)
    assert min(np.abs(q - expected).max(), np.abs(q + expected).max()) < bound * (1 + np.linalg.norm(turned))
    assert np.abs(w - omega).max() < bound * np.linalg.norm(omega)


def members(*states):
    """Return states as one of members."""
    q, Q = ([getattr(state, name) for state in states] for name in ("quaternion", "conjugate_momenta"))
    return pt.State(q, Q, time=[state.time for state in states])


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_growth_of_one_body_and_of_members(formulation, factor, way):
    attitude, axis, rate = start(formulation, factor)
    torque, time, angle = grown(factor, way, rate)
    system = pt.System(BALL, torque)
    one = BALL.state(attitude, omega_body=rate * axis, time=0.5)
    plain = pt.propagate(system, one, [0.5 + time], formulation=formulation)
    check(plain, attitude, angle * axis, factor * rate * axis)
    others = [BALL.state(attitude, omega_body=rate * axis * f, time=0.5) for f in (1.7, 0.2)]
    several = pt.propagate(system, members(others[0], one, others[1]), [0.5 + time], formulation=formulation)
    for member, f in enumerate((1.7, 1.0, 0.2)):
        check(several, attitude, angle * axis * f, factor * rate * axis * f, member)


@pytest.mark.parametrize("factor", FACTORS)
def test_growth_with_dense_output_and_events(factor):
    attitude, axis, rate = start("lie_poisson", factor)
    torque, time, angle = grown(factor, 1, rate)
    marks = time * np.array([0.3, 0.9])
    times = np.linspace(0, time, 7)
    system, one = pt.System(BALL, torque), BALL.state(attitude, omega_body=rate * axis)
    events = [pt.events.AtTime(mark) for mark in marks]
    dense = pt.propagate(system, one, times, dense=True, events=events)
    plain = pt.propagate(system, one, times, events=events)
    assert np.abs(dense.quaternion - plain.quaternion).max() < 100 * EPS * (1 + abs(angle))
    for mark, *found in zip(marks, dense.events, plain.events, strict=True):
        gain = np.exp(np.sign(np.log(factor)) * RATE * mark)
        states = [dense(mark), *(event.states for event in found)]
        for state in states:
            g = np.ravel(state.angular_momentum_body)
            assert np.abs(g - INERTIA * rate * gain * axis).max() < 100 * EPS * INERTIA * rate * gain
            turned = rate * (gain - 1) / RATE * np.sign(np.log(factor)) * axis
            expected = (attitude * Rotation.from_rotvec(turned)).as_quat(scalar_first=True)
            assert np.abs(np.ravel(state.quaternion) - expected).max() < 4 * EPS * (1 + abs(angle))


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("kind", ["orbit", "table", "wide"])
def test_growth_in_carried_axes_between_knots_and_in_wide_precision(kind, factor):
    attitude, axis, rate = start("lie_poisson", factor)
    torque, time, angle = grown(factor, 1, rate)
    orbit = (
        pt.orbits.Ephemeris.from_function(
            1.0, position=lambda t: np.stack(ORBIT.position_at(t), axis=-1), start=0.0, stop=time
        )
        if kind == "table"
        else ORBIT
    )
    system = pt.System(BALL, torque, pt.GravityGradient(orbit))  # which does not turn a ball
    one = BALL.state(attitude, omega_body=rate * axis)
    options = {"precision": "quadruple"} if kind == "wide" else {}
    motion = pt.propagate(system, one, [time], **options)
    check(motion, attitude, angle * axis, factor * rate * axis)
    if kind != "wide":
        several = pt.propagate(system, members(one, one, one), [time])
        check(several, attitude, angle * axis, factor * rate * axis)


@pytest.mark.parametrize("times", [[2 * np.pi], np.linspace(1.0, 2 * np.pi, 9)])
@pytest.mark.parametrize("gain", [-100.0, -13.0, 13.0, 100.0])
@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
def test_momenta_that_rise_and_fall_or_fall_and_rise_within_a_chunk_of_steps(formulation, gain, times):
    rate = 1.0 if gain < 0 else np.exp(-2 * gain)
    system = pt.System(BALL, Swinging(gain * INERTIA))
    angle = 2 * np.pi * ive(0, abs(gain))
    one = BALL.state(TILTED, omega_body=rate * AXIS)
    for state in (one, members(one, one)):
        check(pt.propagate(system, state, times, formulation=formulation), TILTED, angle * AXIS, rate * AXIS)
    wide = pt.propagate(system, one, times, formulation=formulation, precision="quadruple")
    check(wide, TILTED, angle * AXIS, rate * AXIS)


def test_growth_until_a_switch():
    factor = 1e12
    _, time, angle = grown(factor, 1, 1 / factor)
    system = pt.System(BALL, Switched(RATE * INERTIA, time))
    one = BALL.state(TILTED, omega_body=AXIS / factor)
    for state in (one, members(one, one, one)):
        motion = pt.propagate(system, state, [time + 5])
        check(motion, TILTED, (angle + 5) * AXIS, AXIS)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize(("before", "after"), [(0.0, 1e20), (0.0, 1e-20), (1e-13, 1.0), (1.0, 1e-9), (1e-9, 0.0)])
def test_kicks(formulation, before, after):
    attitude, axis, _ = start(formulation, 1.0)
    size = max(before, after)
    body = pt.Body(size * np.array([INERTIA] * 3))
    kick = Kick(1.0, INERTIA * after * axis)
    one = body.state(attitude, angular_momentum_body=INERTIA * before * axis)
    turned = (before + 20 * after) / size * axis
    for state in (one, members(one, one, one)):
        motion = pt.propagate(pt.System(body), state, [21.0], events=[kick], formulation=formulation)
        if after:
            check(motion, attitude, turned, after / size * axis)
        else:
            assert not np.any(motion.omega_body)


@pytest.mark.parametrize("rate", [1e-15, 1e-17])
def test_rotations_slower_than_the_taylor_coefficients_of_a_free_step_hold(rate):
    motion = pt.propagate(pt.System(BALL), BALL.state(TILTED, omega_body=rate * AXIS), [10 / rate])
    check(motion, TILTED, 10 * AXIS, rate * AXIS)


def test_rotations_that_would_take_steps_without_end_are_refused():
    with pytest.raises(pt.PropagationError, match=r"would not end\. Count in a longer unit of time\."):
        pt.propagate(pt.System(BALL), BALL.state(TILTED, omega_body=1e-30 * AXIS), [1e31])


@pytest.mark.parametrize("factor", FACTORS)
def test_tangent_vectors_of_a_growing_motion(factor):
    attitude, axis, rate = start("lie_poisson", factor)
    torque, time, angle = grown(factor, 1, rate)
    one = BALL.state(attitude, omega_body=rate * axis)
    found = pt.analysis.state_transition(pt.System(BALL, torque), one, [time], ["forces[0].k"])
    hat = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = Rotation.from_rotvec(angle * axis).as_matrix()
    right = np.eye(3) - (1 - np.cos(angle)) / angle * hat + (1 - np.sin(angle) / angle) * hat @ hat
    unit = rate * INERTIA  # momenta in the size of the start
    gain = abs((factor - 1) / RATE) * rate
    expected = np.block([[turn.T, right * gain], [np.zeros((3, 3)), factor * np.eye(3)]])
    got = found.matrix[0] * np.repeat([1, unit], 3) / np.repeat([1, unit], 3)[:, None]
    assert np.abs(got - expected)[:3].max() < 40 * EPS * (1 + gain)
    assert np.abs(got - expected)[3:].max() < 40 * EPS * factor
    by_k = time / INERTIA * factor * unit * axis
    assert np.abs(found.sensitivity[0, 3:, 0] - by_k).max() < 40 * EPS * np.abs(by_k).max()


@pytest.mark.parametrize("size", [5e-324, 4e-311, 1e-300])
@pytest.mark.parametrize("count", [1, 9])
def test_the_smallest_momenta_are_preserved(size, count):
    q, Q = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), np.tile([0.0, size, 0.0, 0.0], (count, 1))
    start = pt.State(q, Q) if count > 1 else pt.State(q[0], Q[0])
    motion = pt.propagate(pt.System(BALL), start, [1.0], progress=False)
    np.testing.assert_allclose(motion.quaternion.reshape(count, 4), q, rtol=0, atol=size)
    # Each of the ten products from Q to g and back may lose one of the smallest numbers.
    np.testing.assert_allclose(motion.conjugate_momenta.reshape(count, 4), Q, rtol=4 * EPS, atol=10 * 5e-324)
