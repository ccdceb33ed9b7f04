"""Orbits near two attractors and attitudes along them, against Newton's and Euler's equations in inertial axes,
the periodic orbits that JPL publishes, and the linear theory of the libration points."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import poinsot as pt

EPS = np.finfo(float).eps

# NASA/JPL, Three-Body Periodic Orbits API 1.0 (https://ssd-api.jpl.nasa.gov/doc/periodic_orbits.html): mass ratios,
# libration points and orbits, barycentric synodic axes, units of separation and mean motion. Orbits of the planes
# y = 0 and v_x = v_z = 0: x, z, v_y, period; Jacobi constant where it is quoted.
EARTH_MOON, SATURN_TITAN = 1.215058560962404e-02, 2.366393158331484e-04
POINTS = {
    EARTH_MOON: {"L1": 0.8369151257723572, "L2": 1.155682165444884, "L3": -1.005062645810278},
    SATURN_TITAN: {"L1": 0.9574961733241143, "L2": 1.043256421347392, "L3": -1.00009859971421},
}
# The growth over a period, about twice the stability index, multiplies the rounding of the published digits.
ORBITS = {
    "L2 halo, almost flat": (
        EARTH_MOON,
        1.1808985497899205,
        1.0295054075242347e-4,
        -0.15585631393981156,
        3.4155308065628454,
        None,
        1e-11,
    ),
    "L2 halo": (
        EARTH_MOON,
        1.1252564593293650,
        0.18187257007554328,
        -0.22544675199362010,
        2.9587012252195288,
        None,
        2e-13,
    ),
    "L2 halo, high": (
        EARTH_MOON,
        1.0831337559276397,
        0.20231055618100155,
        -0.20121168055184560,
        2.3861839336103214,
        None,
        1e-12,
    ),
    "L1 halo, far": (
        EARTH_MOON,
        -0.41456184803140111,
        0.90753120433295065,
        1.4076145460136695,
        3.1233143922761588,
        0.19516273085815472,
        5e-9,
    ),
    "butterfly": (
        SATURN_TITAN,
        0.97753007347844856,
        0.039522030056289147,
        -0.011884747036685137,
        3.6919029518069890,
        3.0091858300914192,
        1e-11,
    ),
}


def published(name):
    mu, x, z, v, period, jacobi, slack = ORBITS[name]
    return (
        pt.orbits.ThreeBodyPath(1 - mu, mu, separation=1.0, position=(x, 0, z), velocity=(0, v, 0)),
        period,
        jacobi,
        slack,
    )


def gradients(path):
    return pt.GravityGradient(path.from_primary), pt.GravityGradient(path.from_secondary)


def synodic(path, environment):
    """Position and velocity from the secondary along the turning axes, (n, 3) each."""
    turn = path.frame.attitude(environment.time).inv()
    r, v = (
        np.stack(vector, axis=-1)
        for vector in (environment.position(path.from_secondary), environment.velocity(path.from_secondary))
    )
    return turn.apply(r), turn.apply(v - np.cross(path.frame.omega_space(environment.time), r))


# ---------------------------------------------------------------------- published orbits

MOMENTS, OMEGA = (1.0, 1.2, 1.5), (0.1, 0.2, 0.3)
BODY = pt.Body(MOMENTS)
START = BODY.state((0.6, 0.8, 0, 0), omega_body=OMEGA)


@pytest.mark.parametrize("ratio", POINTS)
def test_libration_points_are_the_published_ones(ratio):
    for name, x in POINTS[ratio].items():
        point = pt.orbits.LagrangePointPath(1 - ratio, ratio, separation=1.0, point=name)
        assert abs(point.from_primary.position[0] - ratio - x) < 4 * EPS


@pytest.mark.parametrize("name", ORBITS)
def test_published_orbit_closes_and_keeps_its_jacobi_constant(name):
    path, period, jacobi, slack = published(name)
    if jacobi is not None:
        assert path.jacobi_constant == pytest.approx(jacobi, abs=1e-14)
    system = pt.System(BODY, *gradients(path))
    motion = pt.propagate(system, START, np.linspace(0, period, 41))
    by_series = np.stack(path.from_secondary.position_at(motion.times))
    assert np.max(np.abs(np.stack(motion.environment.position(path.from_secondary)) - by_series)) < 2e-12
    for environment in (
        motion.environment,
        pt.mechanics.Environment(motion.times),
    ):  # integrated along, and the series for numbers
        r, v = synodic(path, environment)
        assert np.max(np.abs(r[-1] - r[0])) < slack
        assert np.max(np.abs(v[-1] - v[0])) < slack
        assert np.max(np.linalg.norm(r - r[0], axis=-1)) > 0.05
        mu, place = path.mass_ratio, r + np.array([1 - path.mass_ratio, 0, 0])
        d1, d2 = np.linalg.norm(place + np.array([mu, 0, 0]), axis=-1), np.linalg.norm(r, axis=-1)
        C = np.sum(place[:, :2] ** 2, axis=-1) + 2 * (1 - mu) / d1 + 2 * mu / d2 - np.sum(v * v, axis=-1)
        assert np.max(np.abs(C - path.jacobi_constant)) < 5e-14


# ---------------------------------------------------------------------- Newton and Euler in inertial axes

MU1, MU2, SEPARATION, EPOCH = 3.1, 0.4, 2.5, 0.7


def newton_euler(moments, turn, omega, r, v, times):
    """Attitudes (n, 3, 3), rates and positions (n, 3): a body that both attractors pull and turn, axes at rest.

    The attractors go round their barycentre, the origin; everything begins at times[0].
    """
    moments, total = np.array(moments), MU1 + MU2
    rate = np.sqrt(total / SEPARATION**3)

    def attractors(t):
        towards = np.array([np.cos(rate * (t - EPOCH)), np.sin(rate * (t - EPOCH)), 0.0])
        return (MU1, -SEPARATION * MU2 / total * towards), (MU2, SEPARATION * MU1 / total * towards)

    def slopes(t, y):
        r, v, A, w = y[:3], y[3:6], y[6:15].reshape(3, 3), y[15:]
        pull, torque = np.zeros(3), np.zeros(3)
        for mu, place in attractors(t):
            d = r - place
            distance = np.linalg.norm(d)
            n = A.T @ (d / distance)
            pull -= mu * d / distance**3
            torque += 3 * mu / distance**3 * np.cross(n, moments * n)
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([v, pull, (A @ spin).ravel(), (torque - np.cross(w, moments * w)) / moments])

    y0 = np.concatenate([r, v, np.ravel(turn), omega])
    span = (times[0], times[-1])
    y = solve_ivp(slopes, span, y0, method="DOP853", t_eval=times, rtol=3e-14, atol=1e-15).y.T
    return y[:, 6:15].reshape(-1, 3, 3), y[:, 15:], y[:, :3]


@pytest.mark.parametrize("together", [True, False], ids=["both attractors", "with a force along space"])
def test_orbit_and_attitude_are_those_of_newton_and_euler(together):
    rate, barycentre = np.sqrt((MU1 + MU2) / SEPARATION**3), MU2 / (MU1 + MU2) * SEPARATION
    place, drift = np.array([1.9, 0.7, 0.3]), np.array([-0.2, 0.1, 0.15])
    path = pt.orbits.ThreeBodyPath(MU1, MU2, separation=SEPARATION, position=place, velocity=drift, epoch=EPOCH)
    times = EPOCH + np.linspace(0, 6, 25)
    turn = START.attitude.as_matrix()
    start = BODY.state(START.attitude, omega_body=OMEGA, time=EPOCH)
    velocity = drift + np.cross((0, 0, rate), place)
    A, omega, r = newton_euler(MOMENTS, turn, OMEGA, place, velocity, times)
    forces = gradients(path) if together else (*gradients(path), pt.UniformGravity(0.0, (1, 0, 0)))
    motion = pt.propagate(pt.System(BODY, *forces), start, times)
    towards = np.stack([np.cos(rate * (times - EPOCH)), np.sin(rate * (times - EPOCH)), 0 * times], axis=-1)
    from_primary = r + barycentre * towards
    assert np.max(np.abs(np.stack(motion.environment.position(path.from_primary), axis=-1) - from_primary)) < 1e-12
    assert np.max(np.abs(np.stack(path.from_primary.position_at(times), axis=-1) - from_primary)) < 2e-12
    assert np.max(np.abs(motion.attitude.as_matrix() - A)) < 1e-12
    assert np.max(np.abs(motion.omega_body - omega)) < 1e-12
    alone = pt.propagate(pt.System(BODY, gradients(path)[0]), start, times)
    assert np.max(np.abs(alone.omega_body - omega)) > 0.05
    assert np.min(np.linalg.norm(from_primary - SEPARATION * towards, axis=-1)) < 0.9


# ---------------------------------------------------------------------- near the libration points


@pytest.mark.parametrize("name", ["L1", "L2", "L3"])
def test_small_motions_have_the_frequencies_of_linear_theory(name):
    # Szebehely (1967), Sec. 5.3: x'' - 2 y' = (1 + 2c) x, y'' + 2 x' = (1 - c) y, z'' = -c z.
    point = pt.orbits.LagrangePointPath(1 - EARTH_MOON, EARTH_MOON, separation=1.0, point=name)
    d1, d2 = (np.linalg.norm(orbit.position) for orbit in (point.from_primary, point.from_secondary))
    c = (1 - EARTH_MOON) / d1**3 + EARTH_MOON / d2**3
    plane, normal = np.sqrt((2 - c + np.sqrt(9 * c * c - 8 * c)) / 2), np.sqrt(c)
    shape = (plane**2 + 1 + 2 * c) / (2 * plane)
    size = 1e-8
    path = point.path(offset=(size, 0, 0.5 * size), velocity=(0, -shape * plane * size, 0))
    times = np.linspace(-np.pi / plane, np.pi / plane, 21)
    motion = pt.propagate(pt.System(BODY, *gradients(path)), START, times)
    for environment in (motion.environment, pt.mechanics.Environment(times)):
        moved = (synodic(path, environment)[0] - point.from_secondary.position) / size
        expected = [np.cos(plane * times), -shape * np.sin(plane * times), 0.5 * np.cos(normal * times)]
        assert np.max(np.abs(moved - np.stack(expected, axis=-1))) < 2e-5


@pytest.mark.parametrize("name", ["L4", "L5"])
def test_body_left_at_a_triangular_point_stays_there(name):
    point = pt.orbits.LagrangePointPath(1 - EARTH_MOON, EARTH_MOON, separation=1.0, point=name, epoch=0.4)
    path, times = point.path(), np.linspace(-5, 10, 16)
    motion = pt.propagate(pt.System(BODY, *gradients(path)), START, times)
    r, v = synodic(path, motion.environment)
    assert np.max(np.abs(r - point.from_secondary.position)) < 5e-14
    assert np.max(np.abs(v)) < 3e-14
    held = pt.propagate(pt.System(BODY, *gradients(point)), START, times)
    assert np.max(np.abs(motion.quaternion - held.quaternion)) < 2e-13
    assert np.max(np.abs(motion.energy - held.energy)) < 3e-13
