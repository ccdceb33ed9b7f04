"""The path along which a kernel carries a body is that of 50-digit solutions, for every two-body orbit at any time."""

import mpmath
import numpy as np
import pytest

import poinsot as pt
from in_order import in_order
from oracles import two_body as oracle
from poinsot import functions as fn

MU, EPS = 1.7, np.finfo(float).eps
BOUND = 1e-14
"""Of a position, relative to the distance and to the way of one unit of time: a kernel rounds its time, and the mean
anomaly that goes with it. Measured: 5e-16."""
ON_ELLIPSE = np.array([-1.1, -0.5, -1e-3, -1e-7, 0.0, 1e-6, 0.02, 0.48, 1.3])  # periods since the periapsis
ON_ESCAPE = np.array([-1.0, -0.1, -1e-3, -1e-5, 0.0, 1e-6, 1e-4, 0.03, 1.2])  # of the farthest time
ELLIPSES = (0.0, 1e-9, 0.1, 0.69, 0.71, 0.9, 0.99, 1 - 1e-4, 1 - 1e-6, 1 - 1e-9)
ESCAPES = (1.0, 1 + 1e-9, 1 + 1e-5, 1.05, 1.3, 3.7, 10.0)


class Turn(pt.Torque):
    """Along the orbit's normal at the orbit's rate: the angular momentum grows by as much as the true anomaly."""

    orbit: pt.Orbit

    def torque(self, instant):
        inverse = instant.inverse_distance(self.orbit)
        return instant.attitude.to_body(
            fn.cross(instant.position(self.orbit), instant.velocity(self.orbit)) * (inverse * inverse)
        )


def check(orbit, exact_at, times, start, in_space, periapsis, resolved=True):
    """Judge the places of a run and what the true anomaly has grown by.

    Once a periapsis was passed that a rounding of the time does not resolve, that rounding is what is left.
    """
    body = pt.Body(np.array([1.0, 1.1, 1.2]) * (100 + np.ptp(times)))  # so slow that the orbit is all there is
    still = [pt.UniformGravity(0.0, (1, 0, 0))] * in_space
    state = body.state((0.6, 0.8, 0, 0), omega_body=(0, 0, 0), time=start)
    motion = pt.propagate(pt.System(body, Turn(orbit), *still), state, times)
    found = np.stack(np.broadcast_arrays(*motion.environment.position(orbit)), axis=-1)
    grown = motion.angular_momentum_space @ orbit.normal
    fastest = np.sqrt(MU * orbit.parameter) / orbit.periapsis_distance**2
    longest = np.max(np.abs(times)) + np.max(np.abs(times - periapsis))
    with mpmath.workdps(60):
        before = exact_at(start)
        for x, t, growth in zip(found, times, grown, strict=True):
            place, late = exact_at(t), abs(t) + abs(t - periapsis)
            r, v = size(place.position), size(place.velocity)
            off = size([mpmath.mpf(float(a)) - b for a, b in zip(x, place.position, strict=True)])
            assert off < BOUND * (r + v * late) if resolved else off < 10 * BOUND * (r + v * longest)
            # A noise of the rate, and the time of a passage rounded, at other times other than at the epoch. Nothing
            # else moves, so that steps are 5 rad of the orbit and its sines amplify rounding by e^5: measured 6e-13.
            between = (growth - turned(before, place) + np.pi) % (2 * np.pi) - np.pi
            assert abs(between) < 2e-12 + 2 * EPS * fastest * (longest if orbit.period < np.inf else late)


def size(vector):
    return float(mpmath.norm(vector))


def turned(start, place):
    """The angle from one place to another, along the motion."""
    (a, v), b = (start.position, start.velocity), place.position
    normal = cross(a, v)
    aside = sum(x * y for x, y in zip(cross(a, b), normal, strict=True)) / mpmath.norm(normal)
    return float(mpmath.atan2(aside, sum(x * y for x, y in zip(a, b, strict=True))))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


@pytest.mark.parametrize(("start", "in_space"), [(0, False), (-1, True)])
@pytest.mark.parametrize("eccentricity", ELLIPSES)
def test_ellipse(eccentricity, start, in_space):
    random = np.random.default_rng(11)
    for epoch, anomaly in ((0.0, 0.0), (0.25, 2.9)):
        elements = (MU, 1.3, eccentricity, *random.uniform(-3, 3, 3), anomaly, epoch)
        orbit = in_order(pt.KeplerOrbit, *elements)
        periapsis = epoch - orbit.mean_anomaly_at_epoch / orbit.mean_motion
        times, near = periapsis + ON_ELLIPSE * orbit.period, eccentricity <= 1 - 1e-6
        check(orbit, lambda t, own=elements: oracle.ellipse(own, t), times, times[start], in_space, periapsis, near)


@pytest.mark.parametrize(("start", "in_space"), [(0, False), (4, True), (-1, False)])
@pytest.mark.parametrize("eccentricity", ESCAPES)
def test_escape(eccentricity, start, in_space):
    random = np.random.default_rng(12)
    for farthest, epoch in ((30.0, 0.0), (3e4, -7.0), (1e9, 0.0)):
        elements = (MU, 1.3, eccentricity, *random.uniform(-3, 3, 3), 0.5 * epoch, epoch)
        times = 0.5 * epoch + ON_ESCAPE * farthest
        orbit = in_order(pt.orbits.EscapeOrbit, *elements)
        check(orbit, lambda t, own=elements: oracle.escape(own, t), times, times[start], in_space, 0.5 * epoch)


@pytest.mark.parametrize("in_space", [False, True])
@pytest.mark.parametrize("eccentricity", [0.3, 0.9, 1 - 1e-4])
def test_precessing_ellipse(eccentricity, in_space):
    """Against its closed form, which is judged elsewhere."""
    orbit = pt.orbits.PrecessingOrbit(
        pt.KeplerOrbit(
            MU,
            semimajor_axis=1.3,
            eccentricity=eccentricity,
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            true_anomaly=0.3,
        ),
        node_rate=-3e-3,
        periapsis_rate=7e-3,
        anomaly_rate=1e-3,
    )
    times = ON_ELLIPSE * orbit.period
    still = [pt.UniformGravity(0.0, (1, 0, 0))] * in_space
    start = pt.Body((1e3, 1.1e3, 1.2e3)).state((0.6, 0.8, 0, 0), omega_body=(0, 0, 0), time=times[0])
    motion = pt.propagate(pt.System(pt.Body((1e3, 1.1e3, 1.2e3)), Turn(orbit), *still), start, times)
    r, v, found = (
        np.stack(x) for x in (orbit.position_at(times), orbit.velocity_at(times), motion.environment.position(orbit))
    )
    reach = np.linalg.norm(r, axis=0) + np.linalg.norm(v, axis=0) * (np.abs(times) + orbit.period)
    assert np.all(np.linalg.norm(found - r, axis=0) < BOUND * reach)


@pytest.mark.parametrize("in_space", [False, True])
def test_members_short_and_long(in_space):
    e = np.array([0.3, 0.8, 0.999])
    still = [pt.UniformGravity(0.1, (1, 0, 0))] * in_space
    body = pt.Body((1.0, 1.1, 1.2))
    start = body.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3), time=0.2)

    def run(eccentricity):
        orbit = pt.KeplerOrbit(
            MU,
            semimajor_axis=1.3,
            eccentricity=eccentricity,
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            true_anomaly=0.3,
        )
        return pt.propagate(pt.System(body, pt.GravityGradient(orbit), *still), start, [0.2, 1.0, 3.0])

    together = run(e)
    for i in range(3):
        np.testing.assert_allclose(together.quaternion[i], run(e[i]).quaternion, rtol=0, atol=8e-15)
