"""Cassini states and free librations: judged by an integration and by theories that share nothing with the package.

The integration is of a rotation matrix and of its variations by DOP853, along an ellipse whose node turns. On a circle
of small inclination the linear equations have closed solutions. On an ellipse the averaged theory takes the mean over
the orbit of the gravity gradient on a body that turns evenly about its third axis; what it leaves out is of the order
of the flattening, which sets its tolerances. Peale's equation (1969, Astron. J. 74, 483) is its closed form.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

import poinsot as pt
from oracles.cassini_worlds import DEGREE, WORLDS, YEAR, World, about, angle, hansen, peale, rates, reference, start

each_world = pytest.mark.parametrize("name", WORLDS)


def cassini_state(world):
    ellipse = pt.KeplerOrbit(
        world.mu,
        semimajor_axis=world.a,
        eccentricity=world.e,
        inclination=world.i,
        node=world.node,
        argument_of_periapsis=world.periapsis,
    )
    orbit = pt.orbits.PrecessingOrbit.from_mean_motion(ellipse, mean_motion=world.rate, node_rate=world.node_rate)
    return pt.analysis.cassini_state(pt.Body(world.moments), orbit, world.spin)


@pytest.fixture(scope="module")
def states():
    return {name: cassini_state(world) for name, world in WORLDS.items()}


# ---------------------------------------------------------------------- integration


@each_world
def test_motion_and_its_matrix_are_those_of_an_integration(states, name):
    world, motion = WORLDS[name], states[name].motion
    A, omega = motion.state.attitude.as_matrix(), motion.state.angular_momentum_body / world.moments
    period = float(world.period)
    assert motion.period == pytest.approx(period, rel=1e-14, abs=0)
    size = np.concatenate([np.ones(9), np.full(3, world.rate), np.ones(18), np.full(18, world.rate)])
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14 * size}
    end = solve_ivp(rates(world), (0, period), start(A, omega), **options).y[:, -1]
    node = about(2, world.node_rate * period)
    np.testing.assert_allclose(end[:9].reshape(3, 3), node @ A, rtol=0, atol=1e-12)
    np.testing.assert_allclose(end[9:12], omega, rtol=0, atol=5e-14 * world.rate)
    units = np.concatenate([np.ones(3), np.full(3, 1 / period)])  # of angles, and of rates that make them in a period
    own = np.concatenate([np.ones(3), np.asarray(world.moments)]) * units
    matrix = end[12:].reshape(6, 6) * units / units[:, None]
    np.testing.assert_allclose(motion.matrix * own / own[:, None], matrix, rtol=0, atol=1e-12)


@pytest.mark.slow
@each_world
def test_angles_and_frequencies_to_many_digits(states, name):
    (obliquity, inclination), frequencies = reference(WORLDS[name])
    assert states[name].obliquity == pytest.approx(obliquity, abs=1e-13)
    assert states[name].inclination == pytest.approx(inclination, abs=1e-13)
    motion = states[name].motion
    slowest = np.min(frequencies) * motion.period  # an angle t is that of m + 1/m = 2 - t^2, known to rounding
    np.testing.assert_allclose(motion.frequencies, frequencies, rtol=2e-11 + 2 * np.finfo(float).eps / slowest**2)


# ---------------------------------------------------------------------- linear theory on a circle


def circle(moments, i, node_rate=-0.003, gradient=1.07):
    """In units of the rate of the longitude seen from the node; the attractor pulls a little more than Kepler's."""
    return World(moments, gradient, 1.0, 0.0, i, 1.0, node_rate)


SHAPES = [(0.97, 0.985, 1.0), (0.9995, 0.9998, 1.0), (0.7, 0.85, 1.0)]


def folded(frequencies):
    return np.abs((np.asarray(frequencies) + 0.5) % 1 - 0.5)


@pytest.mark.parametrize("moments", SHAPES)
def test_free_frequencies_on_a_circle(moments):
    """Those of DeBra and Delp in the axes of the orbit, which turn at N = 1 + node_rate.

    About the normal C t3'' = -3 (B - A) gradient t3; across it t1, t2 with rates w1 = t1' - N t2, w2 = t2' + N t1
    obey A w1' = -(C - B) N w2 and B w2' = (C - A) N w1 - 3 (C - A) gradient t2.
    """
    world = circle(moments, 0.0)
    A, B, C = moments
    N, g = 1 + world.node_rate, world.gradient
    # (t1, t2, w1, w2)
    matrix = np.array(
        [
            [0, N, 1, 0],
            [-N, 0, 0, 1],
            [0, 0, 0, -(C - B) / A * N],
            [0, -3 * (C - A) / B * g, (C - A) / B * N, 0],
        ]
    )
    across = np.sort(np.abs(np.linalg.eigvals(matrix).imag))[::2]
    longitude = np.sqrt(3 * (B - A) / C * g)
    state = cassini_state(world)
    np.testing.assert_allclose(state.longitude, folded(longitude), rtol=0, atol=1e-14)
    np.testing.assert_allclose(sorted([state.precession, state.wobble]), sorted(folded(across)), rtol=0, atol=1e-14)
    assert state.obliquity < 1e-12


@pytest.mark.parametrize("moments", SHAPES[:2])
@pytest.mark.parametrize("node_rate", [-0.003, -1e-4])
def test_obliquity_on_a_circle_of_small_inclination(moments, node_rate):
    """The forced motion of the same equations: t1 = a cos u, t2 = -b sin u, to first order in the inclination.

    The axes of the orbit turn at node_rate i (sin u, cos u) across the normal too, so that w1 = P sin u and
    w2 = Q cos u with P = W i - a + b N, Q = W i - b + a N. The mean tilt about the node is (a + b)/2.
    """
    i = 2e-4
    world = circle(moments, i, node_rate)
    A, B, C = moments
    W, N, g = node_rate, 1 + node_rate, world.gradient
    # A P + (C - B) N Q = 0 and B Q + (C - A) N P + 3 (C - A) gradient b = 0.
    one = np.array([-A + (C - B) * N * N, A * N - (C - B) * N])
    two = np.array([B * N - (C - A) * N, -B + (C - A) * N * N + 3 * (C - A) * g])
    known = -W * i * np.array([A + (C - B) * N, B + (C - A) * N])
    a, b = np.linalg.solve([one, two], known)
    tilt = (a + b) / 2
    state = cassini_state(world)
    assert state.obliquity == pytest.approx(abs(tilt), rel=1e-6)
    assert state.inclination == pytest.approx(abs(i + tilt), rel=1e-6)


# ---------------------------------------------------------------------- averaged theory


class Averaged:
    """L = omega . I omega / 2 - the mean of 3 mu/(2 r^3) u . I u, with I the mean of the inertia about the third axis.

    The variables are the 3-1-3 angles of the body from axes that turn with the node, the third at the periapsis. The
    error is of the order of the flattening: the spin axis is not quite the third one, and the mean is of first order.
    """

    def __init__(self, world):
        self.world = world
        E = np.arange(600 * world.turns) * 2 * np.pi / 600
        self.M, r = E - world.e * np.sin(E), 1 - world.e * np.cos(E)
        self.weight = 1.5 * world.gradient * r**-2 / E.size  # dM = r dE
        self.u = (
            np.stack([np.cos(E) - world.e, np.sqrt(1 - world.e**2) * np.sin(E), 0 * E]).T @ world.plane.T / r[:, None]
        )

    def potential(self, angles):
        world, turned = self.world, self.u @ about(2, angles[0]) @ about(0, angles[1])
        spun = angles[2] + world.spin * self.M
        x = turned[:, 0] * np.cos(spun) + turned[:, 1] * np.sin(spun)
        y = turned[:, 1] * np.cos(spun) - turned[:, 0] * np.sin(spun)
        A, B, C = world.moments
        return self.weight @ ((A - C) * x**2 + (B - C) * y**2)

    def slope(self, angles):
        return np.array([difference(lambda x, k=k: self.potential(angles + x * np.eye(3)[k])) for k in range(3)])

    def equilibrium(self, start):
        A, B, C = self.world.moments
        mean, W, spin = (A + B) / 2, self.world.node_rate, self.world.spin * self.world.rate

        def unbalance(angles):
            s, c = np.sin(angles[1]), np.cos(angles[1])
            push = np.array([0, W * s * (mean * W * c - C * (spin + W * c)), 0])
            return (push - self.slope(angles)) / (self.world.gradient * (C - A)) / [s, 1, 1]

        found = root(unbalance, start, tol=1e-9)
        assert np.max(np.abs(found.fun)) < 1e-9, found
        return found.x

    def frequencies(self, angles):
        A, B, C = self.world.moments
        mean, W, spin = (A + B) / 2, self.world.node_rate, self.world.spin * self.world.rate
        s, c, c2 = np.sin(angles[1]), np.cos(angles[1]), np.cos(2 * angles[1])
        inertia = np.array([[mean * s * s + C * c * c, 0, C * c], [0, mean, 0], [C * c, 0, C]])
        mixed = np.zeros((3, 3))  # of L, by rates and angles
        mixed[0, 1], mixed[2, 1] = 2 * mean * W * s * c - C * W * s * c - C * (spin + W * c) * s, -C * W * s
        by_angles = -np.array([difference(lambda x, k=k: self.slope(angles + x * np.eye(3)[k])) for k in range(3)])
        by_angles = (by_angles + by_angles.T) / 2
        by_angles[1, 1] += mean * W * W * c2 - C * W * (spin * c + W * c2)
        matrix = np.block(
            [
                [np.zeros((3, 3)), np.eye(3)],
                [np.linalg.solve(inertia, by_angles), np.linalg.solve(inertia, mixed.T - mixed)],
            ]
        )
        values = np.linalg.eigvals(matrix).imag
        return np.sort(values[values > 0])  # precession, longitude and, near the spin, what the mean inertia leaves


def difference(function, h=2e-3):
    return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)


def slack(world):
    """What the theory leaves out of the obliquity: the flattening; of synchronous bodies also e^2 cos^2 w.

    Of these a torque rests in the body, of first order in e: it shifts the third axis from the spin axis by about
    3 e times the obliquity, because the wobble that it drives is slow.
    """
    return 2.5 * world.flattening + (world.spin == 1) * 1.2 * world.e**2 * np.cos(world.periapsis) ** 2


@each_world
def test_averaged_theory(states, name):
    world, state = WORLDS[name], states[name]
    beyond = name == "Moon"  # the axis is beyond the pole, its own node opposite to that of the orbit
    start = np.array([world.node, state.inclination, world.periapsis]) + beyond * np.pi * np.array([1, 0, -1])
    theory = Averaged(world)
    angles = theory.equilibrium(start)
    axis = (about(2, angles[0]) @ about(0, angles[1]))[:, 2]
    precession, longitude, _ = theory.frequencies(angles)
    assert state.motion.stable
    assert state.obliquity == pytest.approx(angle(axis, world.plane[:, 2]), rel=slack(world), abs=0)
    assert state.inclination == pytest.approx(angles[1], abs=slack(world) * state.obliquity)
    assert state.precession == pytest.approx(precession, rel=2.5 * world.flattening, abs=0)
    assert state.longitude == pytest.approx(longitude, rel=0.6 * world.longitude_constant, abs=0)


def test_hansen_coefficients():
    """Their series: 1 - 5 e^2/2 + 13 e^4/16, 7 e/2 - 123 e^3/16; (1 - e^2)^(-3/2) in closed form."""
    e = 0.01
    assert hansen(2, 2, e) == pytest.approx(1 - 5 * e**2 / 2 + 13 * e**4 / 16, abs=1e-12)
    assert hansen(3, 2, e) == pytest.approx(7 * e / 2 - 123 * e**3 / 16, abs=1e-8)
    assert hansen(0, 0, 0.2) == pytest.approx(0.96**-1.5, rel=1e-14, abs=0)


@each_world
def test_equation_of_peale(states, name):
    world, state = WORLDS[name], states[name]
    x, longitude = peale(world)
    assert (x < 0) == (name == "Moon")
    assert state.obliquity == pytest.approx(abs(x), rel=slack(world), abs=0)
    assert state.inclination == pytest.approx(abs(world.i + x), abs=slack(world) * abs(x))
    assert state.longitude == pytest.approx(longitude, rel=0.6 * world.longitude_constant, abs=0)


# ---------------------------------------------------------------------- the forced libration in longitude


@pytest.mark.parametrize("e", [1e-3, 0.05, 0.3])
@pytest.mark.parametrize("spin", [1.0, 1.5])
def test_forced_libration_in_the_plane(e, spin):
    """The odd periodic solution of x'' = -(3/2) K (a/r)^3 sin 2 (x - f), by DOP853 over half the period."""
    A, B, C = 0.9991, 0.9995, 1.0
    K = (B - A) / C

    def rates(t, y):
        E = t
        for _ in range(12):
            E = E - (E - e * np.sin(E) - t) / (1 - e * np.cos(E))
        r = 1 - e * np.cos(E)
        f = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(E / 2), np.sqrt(1 - e) * np.cos(E / 2))
        return y[1], -1.5 * K * r**-3 * np.sin(2 * (y[0] - f))

    half = np.pi * (1 if spin == 1 else 2)

    def missed(rate):
        return solve_ivp(rates, (0, half), (0, rate), method="DOP853", rtol=1e-13, atol=1e-13).y[0, -1] - spin * half

    rate = brentq(missed, spin - 0.01, spin + 0.01, xtol=1e-14)
    state = cassini_state(World((A, B, C), 1.0, 1.0, e, 0.0, 1.0, 0.0, spin))
    assert state.motion.state.angular_momentum_body[2] / C == pytest.approx(rate, abs=3e-13)
    if spin == 1 and e < 0.01:  # linear theory leaves out e^2 sin 2 M
        assert rate - 1 == pytest.approx(-2 * e * 3 * K / (1 - 3 * K), rel=1.2 * e, abs=0)


# ---------------------------------------------------------------------- what others found


PUBLISHED = {
    # Musotto, Varadi, Moore and Schubert (2002, BAAS 34, 35.12): about 13 and about 230 days.
    "Io": {"longitude": (13 / YEAR, 0.04), "wobble": (230 / YEAR, 0.02)},
    # Noyelles, Lemaitre and Vienne (2008, A&A 478, 959), with the same J2, C22 and C/(M R^2).
    "Titan": {"longitude": (2.0977, 2e-3), "wobble": (306.3360, 2e-3)},
    # Yang, Li, Ping and Hanada (2017, RAA 17, 127), from the ephemeris DE430: 1056.16, 8806.9 and 27262.99 days.
    "Moon": {
        "longitude": (1056.16 / YEAR, 2e-3),
        "precession": (8806.9 / YEAR, 3e-3),
        "wobble": (27262.99 / YEAR, 4e-3),
    },
    # Rambaux and Bois (2004, A&A 413, 381).
    "Mercury": {"longitude": (15.847, 5e-4), "precession": (1066.0, 1e-3)},
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_periods(states, name):
    for mode, (years, tolerance) in PUBLISHED[name].items():
        assert 2 * np.pi / getattr(states[name], mode) / YEAR == pytest.approx(years, rel=tolerance, abs=0), mode


def test_titan_precesses_in_space_as_published(states):
    """167.4883 years (Noyelles and others, 2008): seen from the node, which moves the same way, it is slower."""
    in_space = states["Titan"].precession - WORLDS["Titan"].node_rate
    assert 2 * np.pi / in_space / YEAR == pytest.approx(167.4883, rel=2e-3)


def test_moon_is_in_cassini_state_2(states):
    """The tilt is 1.54 degrees to the ecliptic, 6.68 to the orbit, with the nodes opposite."""
    moon = states["Moon"]
    assert moon.inclination / DEGREE == pytest.approx(1.54, abs=0.02)
    assert moon.obliquity / DEGREE == pytest.approx(6.68, abs=0.02)
    assert moon.obliquity - moon.inclination == pytest.approx(WORLDS["Moon"].i, abs=1e-6)


def test_moons_with_slow_nodes_and_mercury_are_in_cassini_state_1(states):
    for name in ("Europa", "Io", "Titan", "Mercury"):
        assert states[name].inclination - states[name].obliquity == pytest.approx(WORLDS[name].i, abs=1e-6), name
