"""A tumbling body, and attitude messages made from it with scipy's rotations alone."""

import datetime as dt
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

BODY = pt.Body.from_inertia([[5.0, 0.3, -0.4], [0.3, 6.0, 0.5], [-0.4, 0.5, 7.0]])
START = BODY.state((0.5, -0.5, 0.1, 0.7), omega_body=(0.3, 0.4, 0.5))
TIMES = np.linspace(0.0, 10.0, 41)
MOTION = pt.free_motion(BODY, START, TIMES)
CALENDAR = pt.Calendar("2026-11-21T00:00:00", "TAI")
NAMED: dict[str, Any] = {"calendar": CALENDAR, "reference_frame": "ICRF"}

STEP = 1e-4


def dated(seconds):
    return (dt.datetime(2026, 11, 21) + dt.timedelta(seconds=float(seconds))).isoformat(timespec="microseconds")


def turn(body_is_b, times=TIMES):
    """The rotations that turn the axes of A into those of B, and the angular velocity of B relative to A along B."""
    state = MOTION(times)
    rotation, omega = state.attitude, MOTION.system.omega_body(state)
    return (rotation, omega) if body_is_b else (rotation.inv(), -rotation.apply(omega))


def continuous_quaternions(body_is_b, times):
    """Quaternions, scalar last as scipy has them, that do not jump."""
    q = np.asarray(MOTION(times).quaternion)[:, [1, 2, 3, 0]]
    return q if body_is_b else q * [-1, -1, -1, 1]


def derivative(values, period=None):
    ahead, behind = (np.asarray(values(TIMES + shift)) for shift in (STEP, -STEP))
    change = ahead - behind
    if period:
        change = (change + period / 2) % period - period / 2
    return change / (2 * STEP)


def columns(kind, body_is_b=True, sequence="ZXY", rate_in_a=False):
    """The numbers of the rows of a message, in the order of the standard, version 2."""
    rotation, omega = turn(body_is_b)
    form, _, more = kind.partition("/")
    if form == "QUATERNION":
        first = continuous_quaternions(body_is_b, TIMES)
        change = derivative(lambda t: continuous_quaternions(body_is_b, t))
    else:
        first = rotation.as_euler(sequence, degrees=True)
        change = derivative(lambda t: turn(body_is_b, t)[0].as_euler(sequence, degrees=True), 360.0)
    along = np.degrees(rotation.apply(omega) if rate_in_a else omega)
    second = {"": first[:, :0], "DERIVATIVE": change, "ANGVEL": along, "RATE": np.full((41, 3), 9.0)}[more]
    return np.concatenate([first, second], axis=1)


def attitude_matrices(table):
    """The matrices that turn components along the body into those along the reference frame."""
    q0, q1, q2, q3 = table.quaternion.T
    return Rotation.from_quat(np.stack([q1, q2, q3, q0], axis=-1)).as_matrix()


def check(table, tolerance=1e-13, rate_tolerance=1e-13):
    """Compare a table with the motion: sign of quaternions aside, attitudes, rates and times."""
    np.testing.assert_allclose(table.times, TIMES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(attitude_matrices(table), MOTION.attitude.as_matrix(), rtol=0, atol=tolerance)
    if rate_tolerance is None:
        assert table.omega_body is None
    else:
        np.testing.assert_allclose(table.omega_body, MOTION.omega_body, rtol=0, atol=rate_tolerance)
