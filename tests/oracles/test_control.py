"""Feedback laws and digital controllers: the motion of another program, closed forms, and SciPy between samples."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import poinsot as pt
from poinsot.control import OrbitPointing, QuaternionFeedback, RateDamping, Sampled

CASES = json.loads((Path(__file__).parent / "spacecraft_control.json").read_text())["cases"]
IDENTITY = (1, 0, 0, 0)
INERTIA = np.array([[10.0, 0.3, -0.2], [0.3, 12.0, 0.1], [-0.2, 0.1, 8.0]])
START = np.array([0.1, 0.7, -0.5, 0.5, 0.03, -0.02, 0.01])
"""Quaternion and rates of a slew that starts far from its target."""
HUGE = 1e6


def hamilton(p, q):
    """The product of two quaternions, scalar first."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def coasted(state, torque, until):
    """Quaternion and rates under a constant torque, by SciPy's integrator."""

    def rate(_, y):
        q, w = y[:4], y[4:]
        turning = 0.5 * hamilton(q, np.array([0.0, *w]))
        return np.concatenate([turning, np.linalg.solve(INERTIA, torque - np.cross(w, INERTIA @ w))])

    return solve_ivp(rate, (0.0, until), state, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]


def fed_back(state, kp, kd, limit, target=IDENTITY):
    """The torque of a saturated feedback, which takes the shorter way."""
    error = hamilton(np.array(target) * (1, -1, -1, -1), state[:4])
    return np.clip(-kp * error[1:] * (-1 if error[0] < 0 else 1) - kd * state[4:], -limit, limit)


# ---------------------------------------------------------------------- continuous laws


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
def test_saturated_feedback_as_another_program_has_it(formulation):
    case = CASES["pd_saturated"]
    law = QuaternionFeedback(case["kp"], case["kd"], case["max_torque"])
    body = pt.Body.from_inertia(case["inertia"])
    start = body.state(case["quaternion0"], omega_body=case["omega_body0"])
    motion = pt.propagate(pt.System(body, law), start, case["times"], formulation=formulation)
    # 20 estimated errors of the reference; canonical momenta of a body at rest have some roundings more.
    assert np.max(np.abs(motion.quaternion - case["quaternion"])) < 20 * case["estimated_error_of_reference"]
    assert np.max(np.abs(motion.omega_body - case["omega_body"])) < 20 * case["estimated_error_of_reference"]


@pytest.mark.parametrize(("kp", "kd"), [(0.6, 4.0), (3.0, 1.0)], ids=["overdamped", "underdamped"])
def test_small_errors_go_as_the_characteristic_equation_says(kp, kd):
    moments, small, times = np.array((10.0, 12.0, 8.0)), 1e-7, np.linspace(0, 40, 9)
    body = pt.Body(moments)
    start = body.state((1, 0.5 * small, 0, 0), omega_body=(0, 0.3 * small, 0))
    motion = pt.propagate(pt.System(body, QuaternionFeedback(kp, kd)), start, times)
    for axis, x in ((0, (small, 0.0)), (1, (0.0, 0.3 * small))):
        plant = np.array([[0.0, 1.0], [-0.5 * kp / moments[axis], -kd / moments[axis]]])  # I s^2 + kd s + kp/2
        expected = np.array([expm(plant * t) @ x for t in times])
        found = np.stack([2 * motion.quaternion[:, 1 + axis], motion.omega_body[:, axis]], axis=-1)
        # What is not linear is of the third order, or a product of two axes: 1e-7 of the whole; roundings of q.
        assert np.max(np.abs(found - expected)) < 1e-7 * small


def test_a_body_on_the_axes_of_its_orbit_stays_there_without_torque():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.4, node=0.3)
    system = pt.System(pt.Body((1, 2, 2.5)), OrbitPointing(2.0, 5.0, 1.0, orbit))
    start = system.body.state(orbit.frame.attitude(0.0), omega_body=(0, 0, 1.0))
    motion = pt.propagate(system, start, [0.0, 10.0, 30.0])
    # About the normal, an axis of a principal moment, a body on a circular orbit turns freely.
    assert np.max(np.abs(motion.relative_to(orbit.frame).quaternion - IDENTITY)) < 1e-14


def test_the_error_of_pointing_has_its_digits_at_every_angle():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)  # whose axes are those of space at zero
    system = pt.System(pt.Body((1, 2, 2.5)), OrbitPointing(2.0, 5.0, 10.0, orbit))
    for axis in (*np.eye(3), np.array((0.6, -0.48, 0.64))):
        for angle in (0.0, 1e-12, 1e-8, 1e-4, 1.0, 2.0, 3.1):
            q = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
            slip = np.array((0.1, -0.2, 0.3))
            turned = hamilton(hamilton(q * (1, -1, -1, -1), np.array((0.0, 0.0, 0.0, 1.0))), q)[1:]
            found = system.torque_body(system.state(q, omega_body=turned + slip))
            # roundings of the matrix and of the sums, of numbers up to 4
            assert np.max(np.abs(found - fed_back(np.array([*q, *slip]), 2.0, 5.0, 10.0))) < 2e-14


def test_pointing_along_an_ellipse_follows_its_axes():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1, inclination=0.4, node=0.3)
    target = (0.8, 0.0, 0.6, 0.0)
    system = pt.System(pt.Body((1, 2, 2.5)), OrbitPointing(800.0, 80.0, 100.0, orbit, target))
    start = system.body.state(IDENTITY, omega_body=(0, 0, 1.0))
    motion = pt.propagate(system, start, [20.0, 25.0])
    relative = motion.relative_to(orbit.frame).quaternion
    # Gyroscopic torques and the acceleration of the axes, 2 or less, are balanced by an error of 2 * 2/800.
    assert np.max(np.abs(np.abs(relative @ target) - 1)) < 1e-4


# ---------------------------------------------------------------------- sampled laws


PERIOD, PHASE, GAINS = 0.7, 0.2, (0.6, 4.0, 0.05)


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
def test_a_sampled_slew_as_scipy_integrates_it_between_samples(formulation):
    law = Sampled(QuaternionFeedback(*GAINS), PERIOD, PHASE)
    system = pt.System(pt.Body.from_inertia(INERTIA), law)
    samples = PHASE + PERIOD * np.arange(70)
    motion = pt.propagate(
        system, system.state(START[:4], omega_body=START[4:]), samples[9::10], formulation=formulation
    )
    state, torque, found = coasted(START, np.zeros(3), PHASE), np.zeros(3), []
    for _ in samples:
        torque = fed_back(state, *GAINS)
        found.append((state, torque))
        state = coasted(state, torque, PERIOD)
    expected, torques = (np.array(each) for each in zip(*found[9::10], strict=True))
    # The other integrator's tolerance, over 70 pieces.
    assert np.max(np.abs(np.column_stack([motion.quaternion, motion.omega_body]) - expected)) < 1e-14
    assert np.max(np.abs(motion.own["sampled"] - torques)) < 1e-14


def test_held_torques_on_a_linear_plant_have_a_closed_form():
    moment, kp, kd, period, small = 10.0, 3.0, 4.0, 0.5, 1e-7
    system = pt.System(pt.Body((moment, 12.0, 8.0)), Sampled(QuaternionFeedback(kp, kd, HUGE), period))
    start = system.state((1, 0.5 * small, 0, 0), omega_body=(0.2 * small, 0, 0))
    motion = pt.propagate(system, start, period * np.arange(41))
    step = np.array([[1.0, period], [0.0, 1.0]]) - np.outer((0.5 * period**2, period), (0.5 * kp, kd)) / moment
    expected = [np.linalg.matrix_power(step, k) @ (small, 0.2 * small) for k in range(41)]
    found = np.stack([2 * motion.quaternion[:, 1], motion.omega_body[:, 0]], axis=-1)
    assert np.max(np.abs(found - expected)) < 1e-14 * small  # sin x = x to 1e-14; the rest is rounding of q
    assert np.linalg.norm(expected[-1]) < 0.1 * small


def test_two_controllers_of_different_periods_do_as_alone_on_their_axes():
    moments, gain, periods, times = (10.0, 12.0, 8.0), 2.0, (0.5, 0.8), np.linspace(0.05, 20, 41)

    class About(pt.Torque):
        gain: pt.BodyVector

        def torque(self, instant):
            return -self.gain * instant.omega_body

    laws = [
        Sampled(About(gain * axis), period, name=f"law_{i}")
        for i, (axis, period) in enumerate(zip(np.eye(3), periods, strict=False))
    ]
    one, both = (pt.System(pt.Body(moments), *some) for some in (laws[:1], laws))
    alone, together = (
        pt.propagate(system, system.state(IDENTITY, omega_body=(0.3, 0, 0)), times) for system in (one, both)
    )
    assert np.max(np.abs(together.omega_body - alone.omega_body)) < 1e-15
    turning = pt.propagate(both, both.state(IDENTITY, omega_body=(0, 0.3, 0)), times)
    # w' = -gain w_k / I between samples.
    k, rest = np.divmod(times, periods[1])
    expected = 0.3 * (1 - gain * periods[1] / moments[1]) ** k * (1 - gain * rest / moments[1])
    assert np.max(np.abs(turning.omega_body[:, 1] - expected)) < 1e-15 * 20
    assert np.max(np.abs(turning.omega_body[:, [0, 2]])) == 0


def test_damping_at_samples_by_hand():
    gain, period, moment = 2.0, 1.0, 10.0
    system = pt.System(pt.Body((moment, 12.0, 8.0)), Sampled(RateDamping(gain), period))
    motion = pt.propagate(system, system.state(IDENTITY, omega_body=(0.1, 0, 0)), [0.0, 1.0, 2.5, 3.0])
    factor = 1 - gain * period / moment
    rates = 0.1 * np.array((1.0, factor, 0.5 * (factor**2 + factor**3), factor**3))
    assert np.max(np.abs(motion.omega_body[:, 0] - rates)) < 1e-16
    held = -gain * 0.1 * np.array((1.0, factor, factor**2, factor**3))
    assert np.max(np.abs(motion.own["sampled"][:, 0] - held)) < 2e-16  # of 0.2, a few roundings
