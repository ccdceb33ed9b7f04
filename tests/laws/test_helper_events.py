"""Each event of the package means what its name says: its passages are those of the quantity itself, none more or less.

The quantity is computed by numpy from dense samples of attitude and rates, without a formula of the package.
"""

# ruff: noqa: ARG001, ARG005

import numpy as np
import pytest

import poinsot as pt
from poinsot.events import standard_events as crossings

BODY = pt.Body((1.0, 1.3, 1.9))
ORBIT = pt.KeplerOrbit(
    1.0, semimajor_axis=1.0, eccentricity=0.3, inclination=0.4, node=0.5, argument_of_periapsis=0.6, true_anomaly=0.7
)
AXIS, DIRECTION = np.array([0.2, 1.0, -0.4]), np.array([0.5, -0.3, 0.8])
SPAN = 25.3


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


def test_every_event_of_the_package_is_here():
    assert {name.partition(",")[0] for name in EVENTS} == set(crossings.__all__)


def starts(count):
    rng = np.random.default_rng(4)
    q = rng.normal(size=(count, 4))
    return BODY.state(q / np.linalg.norm(q, axis=1)[:, None], omega_body=rng.normal(size=(count, 3)))


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("weight", [0.0, 0.8], ids=["free", "heavy"])
@pytest.mark.parametrize("name", EVENTS)
def test_passages_are_those_of_the_quantity(name, weight, sign):
    event, quantity = EVENTS[name]
    system = pt.System(BODY, pt.UniformGravity(weight, (0.1, 0.2, 0.9)))
    times = sign * np.linspace(0, SPAN, 20_001)
    together = pt.propagate(system, starts(3), times, events=[event])
    for k in range(3):
        matrices = pt.State(together.quaternion[k], together.conjugate_momenta[k], times).attitude.as_matrix()
        values = quantity(matrices, together.omega_body[k], times)
        crossed = (np.sign(values[1:]) != np.sign(values[:-1])) & (np.abs(values[1:] - values[:-1]) < 1)
        found = together.events[0].member(k)
        assert len(found) == np.sum(crossed)
        late = np.searchsorted(sign * times, sign * found.times)
        assert np.all(crossed[late - 1])
        assert np.array_equal(found.directions, sign * np.sign(values[1:] - values[:-1])[crossed])
        start = starts(3)
        one = pt.State(start.quaternion[k], start.conjugate_momenta[k], 0.0)
        alone = pt.propagate(system, one, [sign * SPAN], events=[event]).events[0]
        assert np.allclose(
            np.sort(sign * alone.times), np.sort(sign * found.times), rtol=0, atol=1e-10
        )  # rounding over the slowest passage
