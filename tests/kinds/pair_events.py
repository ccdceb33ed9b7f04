"""Every event of two bodies but the contact, with its quantity computed by numpy."""

import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

AXIS, TARGET = np.array([0.2, 1.0, -0.4]), np.array([0.5, -0.3, 0.8])


def axis_at_target(motion):
    matrices = Rotation.from_quat(motion.secondary.quaternion, scalar_first=True).as_matrix()
    return (matrices @ AXIS) @ TARGET


def relative_rate(motion):
    r, v = motion.position, motion.velocity
    normal = np.cross(r, v)
    omega = Rotation.from_quat(motion.secondary.quaternion, scalar_first=True).apply(motion.secondary.omega_body)
    return np.sum(normal * (omega - normal / np.sum(r * r, axis=1)[:, None]), axis=1)


EVENTS = {
    "PairApsis": (pt.events.PairApsis(), lambda m: np.gradient(m.distance, m.times)),
    "DistanceCrossing": (pt.events.DistanceCrossing(6.0), lambda m: m.distance - 6.0),
    "LibrationExtreme": (pt.events.LibrationExtreme(), relative_rate),
    "AxisCrossing, of the secondary": (pt.events.AxisCrossing(AXIS, TARGET).on("secondary"), axis_at_target),
    "RateCrossing, of the primary": (
        pt.events.RateCrossing((1, 0, 0), rate=0.05).on("primary"),
        lambda m: m.primary.omega_body[:, 0] - 0.05,
    ),
}
