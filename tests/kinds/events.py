"""Every event of one body that is shipped, with its quantity computed by numpy."""

# ruff: noqa: ARG001, ARG005

import numpy as np

import poinsot as pt

BODY = pt.Body((1.0, 1.3, 1.9))
ORBIT = pt.KeplerOrbit(
    1.0, semimajor_axis=1.0, eccentricity=0.3, inclination=0.4, node=0.5, argument_of_periapsis=0.6, true_anomaly=0.7
)
AXIS, DIRECTION = np.array([0.2, 1.0, -0.4]), np.array([0.5, -0.3, 0.8])


def angle_to(directions):
    """The angle between the axis in space and directions there, (n, 3); falling where they close up."""

    def quantity(matrices, omega, times):
        axes = matrices @ AXIS / np.linalg.norm(AXIS)
        to = directions(times)
        return -np.arccos(np.clip(np.sum(axes * to / np.linalg.norm(to, axis=1)[:, None], axis=1), -1, 1))

    return quantity


def eccentric_anomaly(times):
    first = 2 * np.arctan(np.sqrt(0.7 / 1.3) * np.tan(0.35))  # at a true anomaly of 0.7
    M = first - 0.3 * np.sin(first) + times
    E = M
    for _ in range(60):
        E = M + 0.3 * np.sin(E)
    return E


def towards_attractor(times):
    """Minus the position on an ellipse by Kepler's equation, from its elements."""
    E = eccentric_anomaly(times)
    x, y = np.cos(E) - 0.3, np.sqrt(1 - 0.3**2) * np.sin(E)
    cw, sw, ci, si, cn, sn = (f(a) for a in (0.6, 0.4, 0.5) for f in (np.cos, np.sin))
    u, v = x * cw - y * sw, x * sw + y * cw
    return -np.stack([u * cn - v * ci * sn, u * sn + v * ci * cn, v * si], axis=1)


def radial_rate(matrices, omega, times):
    return np.sin(eccentric_anomaly(times))


def andoyer_g(matrices, omega, times):
    """The angle along the plane across the momentum, from its node on the horizontal plane to that on the equator."""
    momenta = omega * BODY.moments
    G = np.einsum("nij,nj->ni", matrices, momenta)
    third, unit = matrices[:, :, 2], G / np.linalg.norm(G, axis=1)[:, None]
    first = np.cross([0, 0, 1.0], unit)
    second = np.cross(unit, first)
    line = np.cross(unit, third)
    return np.arctan2(np.sum(line * second, axis=1), np.sum(line * first, axis=1)) - 0.8


EVENTS = {
    "AxisCrossing": (
        pt.events.AxisCrossing(AXIS, DIRECTION),
        lambda *a: angle_to(lambda t: DIRECTION + 0 * t[:, None])(*a) + np.pi / 2,
    ),
    "AxisCrossing, cone": (
        pt.events.AxisCrossing(AXIS, DIRECTION, angle=1.1),
        lambda *a: angle_to(lambda t: DIRECTION + 0 * t[:, None])(*a) + 1.1,
    ),
    "AttractorCrossing": (
        pt.events.AttractorCrossing(AXIS, ORBIT, angle=1.3),
        lambda *a: angle_to(towards_attractor)(*a) + 1.3,
    ),
    "RateCrossing": (pt.events.RateCrossing(AXIS, rate=0.2), lambda m, w, t: w @ AXIS / np.linalg.norm(AXIS) - 0.2),
    "SpinFlip": (pt.events.SpinFlip(AXIS), lambda m, w, t: (w * BODY.moments) @ AXIS),
    "AndoyerCrossing": (pt.events.AndoyerCrossing(angle=0.8), andoyer_g),
    "Apsis": (pt.events.Apsis(ORBIT), radial_rate),
    "AtTime": (pt.events.AtTime(3.7), lambda m, w, t: t - 3.7),
}
