"""Gravity on bodies of any shape against sums over points of mass and Carlson's integrals, in many digits."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from in_order import in_order
from oracles import euler_newton, mass_points
from oracles import real_bodies as oracle

MU = 1.3
TURN, OTHER = Rotation.from_rotvec([0.7, -0.2, 1.1]), Rotation.from_rotvec([-1.0, 0.4, 0.3])
DIRECTION = np.array([0.48, -0.36, 0.8])
RANDOM = np.random.default_rng(4)
MASSES = RANDOM.uniform(1, 2, 8)
POINTS = RANDOM.normal(size=(8, 3)) * [1.0, 0.7, 0.4]
POINTS -= MASSES @ POINTS / np.sum(MASSES)
POINTS /= np.max(np.linalg.norm(POINTS, axis=-1))
CLOUD = pt.Body.from_point_masses(MASSES, POINTS)
ATTRACTOR = mass_points.PointAttractor(np.array([MU]), np.zeros((1, 3)))


def field(degree, size=1.0):
    """The field of the cloud; the points are within the unit sphere times a size."""
    return pt.GravityField(
        degree, np.sum(MASSES), size, *clean(oracle.coefficients(MASSES, size * POINTS, size, degree))
    )


def clean(coefficients):
    """Degree 1 is zero but for rounding."""
    for array in coefficients:
        assert np.max(np.abs(array[1])) < 1e-15
        array[1] = 0
    return coefficients


def torque(body, force, time=0.0, turn=TURN):
    return pt.System(body, force).torque_body(body.state(turn, omega_body=(0, 0, 0), time=time))


def energy(body, force, turn=TURN):
    return pt.System(body, force).potential_energy(body.state(turn, omega_body=(0, 0, 0)))


def pulled(position, masses=MASSES, points=POINTS, turn=TURN):
    with mpmath.workdps(40):
        return oracle.torque_on_points(MU, turn.inv().apply(position), masses, points)


def relative(a, b):
    return np.linalg.norm(np.subtract(a, b)) / np.linalg.norm(b)


# ---------------------------------------------------------------------- the oracle itself


def test_the_torque_on_an_ellipsoid_is_the_slope_of_its_energy():
    body, place = oracle.Ellipsoid(2.0, (1.0, 0.7, 0.5)), np.array([0.9, -0.6, 0.8])
    with mpmath.workdps(40):
        for k in range(3):
            turned = [euler_newton.about(k, sign * 1e-5) @ place for sign in (1, -1)]
            slope = float(body.energy(MU, turned[0]) - body.energy(MU, turned[1])) / 2e-5
            assert body.torque(MU, place)[k] == pytest.approx(slope, rel=1e-9, abs=0)


def test_an_ellipsoid_is_many_points():
    """Those of a lattice, 40 on the longest axis: the attraction differs by the roughness of the surface."""
    semiaxes, place = np.array([1.0, 0.7, 0.5]), np.array([0.9, -0.6, 0.8])
    line = (np.arange(40) + 0.5) / 20 - 1
    grid = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    points = grid[np.sum(grid**2, axis=-1) < 1] * semiaxes
    lattice = mass_points.torque_of(ATTRACTOR, -place, np.full(len(points), 2.0 / len(points)), points)
    assert relative(lattice, oracle.Ellipsoid(2.0, semiaxes).torque(MU, place)) < 3e-3


# ---------------------------------------------------------------------- spherical harmonics


@pytest.mark.parametrize(
    ("degree", "near"), [(2, 60.0), (3, 60.0), (4, 30.0), (5, 20.0), (6, 12.0), (7, 10.0), (8, 8.0)]
)
def test_what_a_field_leaves_falls_with_the_degree_after_it(degree, near):
    """The torque of degree n goes with r^-(n + 1); the one after that is the larger, the nearer."""
    force = [
        pt.forces.HarmonicGravity(pt.orbits.FixedPosition(MU, position=r * DIRECTION), field(degree))
        for r in (near, 2 * near)
    ]
    errors = [
        np.linalg.norm(torque(CLOUD, one) - pulled(r * DIRECTION))
        for one, r in zip(force, (near, 2 * near), strict=True)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(degree + 2, abs=0.25)


@pytest.mark.parametrize(("distance", "bound"), [(1.5, 5e-3), (2.0, 1e-4), (3.0, 2e-7), (10.0, 2e-14)])
def test_a_field_of_degree_16(distance, bound):
    force = pt.forces.HarmonicGravity(pt.orbits.FixedPosition(MU, position=distance * DIRECTION), field(16))
    assert relative(torque(CLOUD, force), pulled(distance * DIRECTION)) < bound


ELEMENTS = (MU, 20.0, 0.3, 0.8, -0.4, 1.9, 0.3)
ELLIPSE = in_order(pt.KeplerOrbit, *ELEMENTS, epoch=0.2)
FLYBY = pt.orbits.EscapeOrbit(
    MU, periapsis_distance=15.0, eccentricity=1.4, inclination=0.6, node=0.3, argument_of_periapsis=-0.9
)
TABLE = np.linspace(-20, 20, 41)
LIBRATION = pt.orbits.LagrangePointPath(0.8 * MU, 0.2 * MU, separation=20.0, point="L4")
ORBITS = {
    "at rest": pt.orbits.FixedPosition(MU, position=20 * DIRECTION),
    "ellipse": ELLIPSE,
    "hyperbola": FLYBY,
    "table": pt.orbits.Ephemeris.from_table(
        MU,
        times=TABLE,
        positions=np.stack(list(ELLIPSE.position_at(TABLE)), axis=-1),
        velocities=np.stack(list(ELLIPSE.velocity_at(TABLE)), axis=-1),
    ),
    "libration point": LIBRATION.from_secondary,
}


@pytest.mark.parametrize("orbit", ORBITS.values(), ids=ORBITS)
def test_the_attractor_is_on_its_side_of_every_orbit(orbit):
    """Degree 3 changes its sign with the side."""
    mu, force = float(orbit.mu), pt.forces.HarmonicGravity(orbit, field(12))
    for time in (-3.0, 0.7):
        position = np.array([float(x) for x in orbit.position_at(time)])
        derived = torque(CLOUD, force, time)
        assert relative(derived, pulled(position) * mu / MU) < 3e-12
        assert relative(derived, pulled(-position) * mu / MU) > 1e-2


@pytest.mark.parametrize(
    ("name", "exact"),
    [("ellipse", False), ("hyperbola", False), ("at rest", True), ("hyperbola", True), ("table", True)],
    ids=lambda value: {True: "mascons", False: "field"}.get(value, value),
)
def test_motion_is_that_of_euler_and_newton(name, exact):
    """Of a body so close that degree 3 counts, pulled at every point."""
    omega, times = np.array([0.02, -0.03, 0.04]), np.array([-15.0, 4.0, 15.0])
    orbit, inertia, start = ORBITS[name], mass_points.inertia_of(MASSES, 4 * POINTS), 0.5
    position, velocity = (np.array([float(x) for x in part(start)]) for part in (orbit.position_at, orbit.velocity_at))
    path = euler_newton.Attractor(MU, position, None if name == "at rest" else velocity, start)

    def pull(A, _omega, positions):
        return A.T @ mass_points.torque_of(ATTRACTOR, positions[0], MASSES, 4 * POINTS @ A.T)

    judged = euler_newton.integrate(inertia, TURN.as_matrix(), omega, start, times, [pull], [path])
    body = pt.Body.from_point_masses(MASSES, 4 * POINTS)
    force = (
        pt.forces.MasconGravity(orbit, MASSES, 4 * POINTS)
        if exact
        else pt.forces.HarmonicGravity(orbit, field(6, size=4.0))
    )
    motion = pt.propagate(pt.System(body, force), body.state(TURN, omega_body=omega, time=start), times)
    bound = {True: 1e-11, False: 1e-4}[exact] + (1e-7 if name == "table" else 0)
    assert np.max(np.abs(motion.attitude.as_matrix() - judged[0])) < bound
    round_one = pt.propagate(
        pt.System(body, pt.GravityGradient(orbit)), body.state(TURN, omega_body=omega, time=start), times
    )
    assert np.max(np.abs(round_one.attitude.as_matrix() - judged[0])) > 1e-3


# ---------------------------------------------------------------------- points of mass


@pytest.mark.parametrize("distance", [0.3, 1.1, 3.0, 1e3, 1e6, 1e9])
def test_points_of_mass_lose_no_digits(distance):
    """Also within them; mirrored, so that their centre is at the origin to the last digit."""
    masses, points = np.tile(MASSES, 2), np.concatenate([POINTS, -POINTS])
    body, position = pt.Body.from_point_masses(masses, points), distance * DIRECTION
    derived = torque(body, pt.forces.MasconGravity(pt.orbits.FixedPosition(MU, position=position), masses, points))
    assert relative(derived, pulled(position, masses, points)) < 1e-14


@pytest.mark.parametrize("distance", [1.1, 5.0, 1e3])
def test_the_energy_of_points_of_mass_is_theirs(distance):
    with mpmath.workdps(40):
        position = distance * DIRECTION
        force = pt.forces.MasconGravity(pt.orbits.FixedPosition(MU, position=position), MASSES, POINTS)

        def exact(turn):
            places = turn.inv().apply(position) + POINTS
            return -MU * sum(
                mpmath.mpf(m) / mpmath.norm(oracle.many_digits(x)) for m, x in zip(MASSES, places, strict=True)
            )

        expected = float(exact(TURN) - exact(OTHER))
    # The doubles of the places are rounded: by eps of their size, against a difference in degree 2.
    slack = 1e-14 * distance**2
    assert energy(CLOUD, force, TURN) - energy(CLOUD, force, OTHER) == pytest.approx(expected, rel=1e-13 + slack, abs=0)


# ---------------------------------------------------------------------- ellipsoids

SHAPES = [
    (1.0, 0.9, 0.8),
    (0.5, 1.0, 0.7),
    (0.7, 0.5, 1.0),
    (1.0, 1.0, 0.3),
    (0.3, 1.0, 0.3),
    (1.0, 0.5, 0.1),
    (1.0, 1.0, 0.01),
    (1.0, 0.01, 0.01),
    (1.0, 1.0 - 1e-9, 0.6),
    (1.0, 1.0 - 1e-7, 1.0 - 3e-7),
    (1.0, 1.0 - 1e-13, 1.0 - 3e-13),
]


def directions(count):
    random = np.random.default_rng(7).normal(size=(count, 3))
    near_axes = np.eye(3) + 0.03
    rows = np.concatenate([random, near_axes])
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def worst_torque(shape, distance, count=4):
    body, judge = pt.Body.from_ellipsoid(2.0, shape), oracle.Ellipsoid(2.0, shape)
    worst = 0.0
    for place in distance * directions(count):
        derived = torque(
            body,
            pt.forces.EllipsoidGravity(pt.orbits.FixedPosition(MU, position=-place), 2.0, shape),
            turn=Rotation.identity(),
        )
        with mpmath.workdps(40):
            worst = max(worst, relative(derived, judge.torque(MU, place)))
    return worst


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("distance", [1.2, 2.0, 1e4])
def test_an_ellipsoid_from_near_and_far(shape, distance):
    # Three times the worst of ten distances about the farthest, for the needle: 1.1e-14.
    assert worst_torque(shape, distance) < 3.5e-14


@pytest.mark.parametrize(
    ("shape", "distance", "bound"),
    [
        ((1.0, 0.9, 0.8), 1.0001, 1e-14),
        ((1.0, 0.7, 0.5), 1.0001, 2e-14),
        ((1.0, 1.0, 0.3), 1.05, 1e-10),
        ((1.0, 0.5, 0.1), 1.05, 1e-9),
    ],
    ids=str,
)
def test_what_remains_below(shape, distance, bound):
    assert worst_torque(shape, distance) < bound


def test_a_flat_ellipsoid_at_its_edge_is_beyond_the_formula():
    assert worst_torque((1.0, 1.0, 0.01), 1.0001) > 1e-5


@pytest.mark.parametrize("shape", SHAPES[:6], ids=str)
def test_the_energy_of_an_ellipsoid(shape):
    """From the same distance in two directions."""
    judge, body = oracle.Ellipsoid(2.0, shape), pt.Body.from_ellipsoid(2.0, shape)
    for distance in (1.2, 3.0):
        places = distance * directions(1)
        with mpmath.workdps(40):
            exact = [
                judge.energy(MU, place) + mpmath.mpf(2) * MU / mpmath.norm(oracle.many_digits(place))
                for place in places
            ]
        for place, expected in zip(places, exact, strict=True):
            force = pt.forces.EllipsoidGravity(pt.orbits.FixedPosition(MU, position=-place), 2.0, shape)
            # Of the size that degree 2 may have, as there are directions without any: three times the worst.
            slack = 2e-15 * 2.0 * MU / distance**3
            assert energy(body, force, Rotation.identity()) == pytest.approx(float(expected), abs=slack)


def test_a_homogeneous_sphere_feels_nothing():
    force = pt.forces.EllipsoidGravity(pt.orbits.FixedPosition(MU, position=2 * DIRECTION), 2.0, (0.7, 0.7, 0.7))
    body = pt.Body.from_ellipsoid(2.0, (0.7, 0.7, 0.7))
    assert energy(body, force) == 0
    assert np.all(torque(body, force) == 0)
    motion = pt.propagate(pt.System(body, force), body.state(TURN, omega_body=(0.1, 0.2, -0.3)), [0.0, 10.0])
    assert np.allclose(motion.omega_body[1], (0.1, 0.2, -0.3), rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- action and reaction

BOX = (1.1, 0.8, 0.5)
FORCES = {
    "field": lambda orbit: (CLOUD, pt.forces.HarmonicGravity(orbit, field(4))),
    "mascons": lambda orbit: (CLOUD, pt.forces.MasconGravity(orbit, MASSES, POINTS)),
    "ellipsoid": lambda orbit: (pt.Body.from_ellipsoid(2.0, BOX), pt.forces.EllipsoidGravity(orbit, 2.0, BOX)),
}


@pytest.mark.parametrize("make", FORCES.values(), ids=FORCES)
def test_the_attractor_takes_the_momentum_that_the_body_gains(make):
    """Torque plus r x F is zero, F the slope of the energy by the position; in 30 digits."""
    position = 1.7 * DIRECTION
    body, force = make(pt.orbits.FixedPosition(MU, position=position))
    system, step = pt.System(body, force), mpmath.mpf(10) ** -12
    numbers = [float(x) for x in system.dynamics.numbers]
    first = next(i for i in range(len(numbers)) if np.array_equal(numbers[i : i + 3], position))

    def at(shift, axis):
        exact = list(map(mpmath.mpf, numbers))
        exact[first + axis] += shift
        copied = formulas.copied(system, iter(exact))
        return formulas.potential(copied, TURN.as_quat(scalar_first=True), mpmath.mpf(0))

    with mpmath.workdps(40):
        push = [-float((at(step, k) - at(-step, k)) / (2 * step)) for k in range(3)]
    gained = TURN.apply(torque(body, force))
    assert np.allclose(gained + np.cross(position, push), 0, rtol=0, atol=4e-15 * np.linalg.norm(push))
    assert np.linalg.norm(gained) > 0.01


@pytest.mark.parametrize("make", FORCES.values(), ids=FORCES)
def test_energy_stays_where_the_attractor_rests(make):
    body, force = make(pt.orbits.FixedPosition(MU, position=1.7 * DIRECTION))
    state = body.state(TURN, omega_body=(0.1, 0.3, -0.2))
    motion = pt.propagate(pt.System(body, force), state, np.linspace(0, 30, 31))
    assert list(motion.drift) == ["energy", "angular_momentum_space_attractor"]
    assert all(np.max(np.abs(drift)) < 3e-14 for drift in motion.drift.values())
    assert np.ptp(motion.potential_energy) > 0.01


# ---------------------------------------------------------------------- two bodies, both free

COMPANION = 1.7
"""The mass of a point that is no fixed attractor; the constant of gravity is 1."""


def two_bodies(_time, state):
    """Newton's law for each point of the cloud and for its companion, Euler's equation for the cloud."""
    (r, v, other, drift, omega), A = state[:15].reshape(5, 3), state[15:].reshape(3, 3)
    away = other - r - POINTS @ A.T
    pulls = COMPANION * MASSES[:, None] * away / np.linalg.norm(away, axis=-1, keepdims=True) ** 3
    pull, twist = pulls.sum(axis=0), A.T @ np.cross(POINTS @ A.T, pulls).sum(axis=0)
    inertia = mass_points.inertia_of(MASSES, POINTS)
    turning = np.linalg.solve(inertia, np.cross(inertia @ omega, omega) + twist)
    return np.concatenate(
        [v, pull / np.sum(MASSES), drift, -pull / COMPANION, turning, (A @ euler_newton.skew(omega)).ravel()]
    )


def momentum_and_energy(state):
    (r, v, other, drift, omega), A = state[:15].reshape(5, 3), state[15:].reshape(3, 3)
    spin, mass = mass_points.inertia_of(MASSES, POINTS) @ omega, np.sum(MASSES)
    momentum = A @ spin + mass * np.cross(r, v) + COMPANION * np.cross(other, drift)
    distances = np.linalg.norm(other - r - POINTS @ A.T, axis=-1)
    kinetic = (omega @ spin + mass * v @ v + COMPANION * drift @ drift) / 2
    return np.array([*momentum, kinetic - COMPANION * np.sum(MASSES / distances)])


def test_two_free_bodies_keep_their_momentum_and_energy_with_the_torque_of_the_forces():
    """The attractor recoils; its distance and direction alone make the torque."""
    mass, distance = np.sum(MASSES), np.array([3.5, 0.6, -1.1])
    speed = np.sqrt((mass + COMPANION) / 4) * np.array([0.1, 0.9, 0.3])
    share = np.array([-COMPANION, mass])[:, None] / (mass + COMPANION)
    places, velocities = share * distance, share * speed
    start = np.concatenate(
        [places[0], velocities[0], places[1], velocities[1], (0.3, -0.2, 0.5), TURN.as_matrix().ravel()]
    )
    times = np.linspace(0, 4, 9)
    states = solve_ivp(two_bodies, (0, 4), start, t_eval=times, **euler_newton.PRECISION).y.T
    conserved = np.array([momentum_and_energy(state) for state in states])
    assert np.allclose(conserved, conserved[0], rtol=0, atol=1e-11 * np.max(np.abs(conserved)))
    spins = [state[15:].reshape(3, 3) @ mass_points.inertia_of(MASSES, POINTS) @ state[12:15] for state in states]
    assert np.linalg.norm(spins[-1] - spins[0]) > 0.1  # the bodies do exchange momentum
    high = field(16)
    for state in states:
        A = state[15:].reshape(3, 3)
        turning = two_bodies(0, state)[12:15]
        inertia = mass_points.inertia_of(MASSES, POINTS)
        twist = inertia @ turning - np.cross(inertia @ state[12:15], state[12:15])
        orbit = pt.orbits.FixedPosition(COMPANION, position=state[:3] - state[6:9])
        exact, series = (
            torque(CLOUD, force, turn=Rotation.from_matrix(A))
            for force in (pt.forces.MasconGravity(orbit, MASSES, POINTS), pt.forces.HarmonicGravity(orbit, high))
        )
        assert relative(exact, twist) < 1e-11
        assert relative(series, twist) < 1e-7


# ---------------------------------------------------------------------- on the path of a planet


def test_degree_two_is_the_gravity_gradient_on_the_path_of_a_planet():
    """Of the Moon by the Earth: lengths in km, moments in M R^2 of the Moon, times in seconds."""
    orbit = pt.orbits.planet_orbit("moon", "earth", "2025-01-01 TDB", "2025-01-29 TDB")
    second = {"C20": -2.033e-4, "C22": 2.24e-5}
    body = pt.Body.from_stokes(**second, polar_moment_factor=0.3930, mass=1.0, radius=1738.0)
    C, S = np.zeros((2, 4, 4))
    C[0, 0], C[2, 0], C[2, 2] = 1, second["C20"], second["C22"]
    even, third = C.copy(), C.copy()
    third[3, 1] = 3e-5
    first = orbit.span[0]
    start = body.state(TURN, omega_body=(0, 0, 2.66e-6), time=first)
    times = first + np.linspace(0, 25 * 86400.0, 6)
    gradient, series, more = (
        pt.propagate(pt.System(body, force), start, times)
        for force in (
            pt.GravityGradient(orbit),
            pt.forces.HarmonicGravity(orbit, pt.GravityField(3, 1.0, 1738.0, even, S)),
            pt.forces.HarmonicGravity(orbit, pt.GravityField(3, 1.0, 1738.0, third, S)),
        )
    )
    assert np.allclose(series.quaternion, gradient.quaternion, rtol=0, atol=5e-15)
    assert np.allclose(series.omega_body, gradient.omega_body, rtol=0, atol=4e-21)  # of 2.7e-6
    assert np.max(np.abs(more.quaternion - gradient.quaternion)) > 1e-7
