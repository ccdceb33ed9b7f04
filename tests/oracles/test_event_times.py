"""Times of events against closed forms and against an integration that shares nothing."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import poinsot as pt

EPS = np.finfo(float).eps


def ulps(found, expected):
    return np.max(np.abs(found - expected) / np.spacing(np.abs(expected)))


@pytest.mark.parametrize("unit", [1.0, 86400.0, 1e-6])
def test_a_spinning_body_passes_planes_and_cones_within_ulps(unit):
    body = pt.Body(np.array([1.0, 2.0, 3.0]) * 1e30)
    start = body.state((1, 0, 0, 0), omega_body=np.array([0, 0, 0.7]) / unit)
    events = [
        pt.events.AxisCrossing((1, 0, 0), (2, 0, 0)),
        pt.events.AxisCrossing((3, 0, 0), (1, 0, 0), angle=np.pi / 3, direction=1),
    ]
    plane, cone = pt.propagate(pt.System(body), start, [300 * unit], events=events).events
    rate = 0.7 / unit
    assert ulps(plane.times, (np.arange(67) + 0.5) * np.pi / rate) < 16
    assert ulps(cone.times, (2 * np.pi * np.arange(1, 34) - np.pi / 3) / rate) < 16


def test_rates_of_a_free_body_vanish_at_multiples_of_a_quarter_period():
    """omega_2 = c sn(p t): its zeros are 2 K(m) / p apart (Landau and Lifshitz, Mechanics, 37)."""
    A, B, C = moments = np.array([1.0, 2.0, 3.0])
    body, w = pt.Body(moments), np.array([0.3, 0.0, 0.9])
    T2, G2 = np.sum(moments * w**2), np.sum((moments * w) ** 2)
    assert G2 > T2 * B
    p = np.sqrt((C - B) * (G2 - T2 * A) / (A * B * C))
    m = (B - A) * (T2 * C - G2) / ((C - B) * (G2 - T2 * A))
    start = body.state((1, 0, 0, 0), omega_body=w)
    events = [
        pt.events.RateCrossing((0, 1, 0)),
        pt.events.SpinFlip((0, 1, 0)),
        pt.events.RateCrossing((1, 0, 0)),
        pt.events.SpinFlip((1, 1, 0)),
    ]
    rate, flip, first, oblique = pt.propagate(pt.System(body), start, [200.0], events=events).events
    half = 2 * ellipk(m) / p
    k = np.arange(1, int(200 / half) + 1)
    assert np.allclose(rate.times, k * half, rtol=2e-14, atol=0)
    assert np.allclose(flip.times, k * half, rtol=2e-14, atol=0)
    assert np.allclose(first.times, (np.arange(len(first)) + 0.5) * half, rtol=2e-14, atol=0)
    assert len(oblique) > 10
    assert np.max(np.abs(oblique.states.angular_momentum_body @ [1, 1, 0])) < 3e-14


def test_the_pendulum_passes_its_lowest_point_twice_a_period():
    """A body swinging about its third axis, which is horizontal: period 4 K(sin^2(a/2)) / omega_0 (exact)."""
    body, amplitude = pt.Body((1.0, 2.5, 3.0)), 0.9
    system = pt.System(body, pt.UniformGravity(0.7, (0.0, -1.3, 0.0)))
    third_axis_level = np.array([np.sqrt(0.5), np.sqrt(0.5), 0, 0])  # the second one is up, so the mass hangs down
    c, s = np.cos(amplitude / 2), np.sin(amplitude / 2)
    q0, q1, _, _ = third_axis_level
    q = np.array([q0 * c, q1 * c, -q1 * s, q0 * s])
    start = body.state(q, omega_body=(0, 0, 0))
    period = 4 * ellipk(np.sin(amplitude / 2) ** 2) / np.sqrt(0.7 * 1.3 / 3.0)
    events = [pt.events.AxisCrossing((1, 0, 0), (0, 0, 1)), pt.events.RateCrossing((0, 0, 1))]
    lowest, turning = pt.propagate(system, start, [20.4 * period], events=events).events
    assert np.allclose(lowest.times, (np.arange(len(lowest)) + 0.5) * period / 2, rtol=4e-15, atol=0)
    assert np.allclose(turning.times, np.arange(1, len(turning) + 1) * period / 2, rtol=4e-15, atol=0)
    assert len(lowest) == 41


@pytest.mark.parametrize("eccentricity", [0.01, 0.3, 0.9])
def test_apsides_come_at_half_periods(eccentricity):
    orbit = pt.KeplerOrbit(
        4.0, semimajor_axis=2.0, eccentricity=eccentricity, inclination=0.3, node=0.4, argument_of_periapsis=0.5
    )
    body = pt.Body((1.0, 2.0, 3.0))
    system = pt.System(body, pt.GravityGradient(orbit))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    events = [pt.events.Apsis(orbit, direction=1), pt.events.Apsis(orbit, direction=-1)]
    nearest, farthest = pt.propagate(system, start, [20.2 * orbit.period], events=events).events
    assert np.allclose(nearest.times / orbit.period, np.arange(1, 21), rtol=4e-15 / eccentricity**0.5, atol=0)
    assert np.allclose(farthest.times / orbit.period, np.arange(20) + 0.5, rtol=4e-15 / eccentricity**0.5, atol=0)


def test_an_impulsive_torque_against_an_integration_in_pieces():
    """A kick in body axes each time the second rate rises through zero; rotation matrices by scipy's DOP853."""
    moments, kick = np.array([1.0, 2.0, 3.0]), np.array([0.02, 0.05, -0.01])

    class Kick(pt.events.RateCrossing):
        impulse: pt.mechanics.Vector

        def act(self, body, state):
            return body.state(
                state.quaternion, angular_momentum_body=state.angular_momentum_body + self.impulse, time=state.time
            )

    body = pt.Body(moments)
    start = body.state((1, 0, 0, 0), omega_body=(0.5, 0.1, 0.9))
    motion = pt.propagate(pt.System(body), start, [25.0], events=[Kick((0, 1, 0), kick, direction=1)])

    def rates(_, x):
        w = x[9:] / moments
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([(x[:9].reshape(3, 3) @ spin).ravel(), np.cross(x[9:], w)])

    def third_rate(_, x):
        return x[10]

    rising: Any = third_rate
    rising.terminal, rising.direction = True, 1
    x, time, times = np.concatenate([np.eye(3).ravel(), moments * [0.5, 0.1, 0.9]]), 0.0, []
    while time < 25.0:
        done = solve_ivp(rates, (time, 25.0), x, method="DOP853", rtol=1e-13, atol=1e-14, events=rising)
        x, time = done.y[:, -1], done.t[-1]
        if done.status == 1:
            times.append(time)
            x[9:] += kick
    assert len(times) == 3
    assert np.allclose(motion.events[0].times, times, rtol=0, atol=2e-13)
    assert np.allclose(motion.attitude.as_matrix()[0].ravel(), x[:9], rtol=0, atol=4e-12)
    assert np.allclose(motion.angular_momentum_body[0], x[9:], rtol=0, atol=3e-13)


def test_andoyers_angle_is_that_of_the_variables():
    body = pt.Body((1.0, 1.4, 2.0))
    system = pt.System(body, pt.UniformGravity(0.3, (0.2, 0.1, 0.5)))
    start = body.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.3, 0.9, 0.8))
    found = pt.propagate(system, start, [60.0], events=[pt.events.AndoyerCrossing(angle=0.4)]).events[0]
    g = pt.Andoyer.from_state(found.states).g
    assert len(found) > 5
    assert np.max(np.abs(g - 0.4)) < 8e-15


def test_the_spacecraft_sees_the_attractor_where_angles_say():
    orbit = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.2, inclination=0.3, node=0.4, argument_of_periapsis=0.5
    )
    body = pt.Body((1.0, 2.0, 3.0))
    start = body.state((1, 0, 0, 0), omega_body=(0.3, 0.1, 0.2))
    event = pt.events.AttractorCrossing((0, 1, 1), orbit, angle=1.1, direction=1)
    found = pt.propagate(pt.System(body), start, [100.0], events=[event]).events[0]
    positions = np.stack([np.asarray(x) for x in orbit.position_at(found.times)], axis=-1)
    axes = found.states.attitude.apply(np.array([0, 1, 1]) / np.sqrt(2))
    downwards = -positions / np.linalg.norm(positions, axis=1, keepdims=True)
    assert len(found) > 5
    # Sixteen roundings of a time of 100, at 0.37 rad per unit.
    assert np.max(np.abs(np.arccos(np.sum(axes * downwards, axis=1)) - 1.1)) < 0.37 * 16 * np.finfo(float).eps * 100
