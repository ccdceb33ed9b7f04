"""Gravity on bodies against sums over points of mass."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from in_order import in_order
from oracles import euler_newton
from oracles import mass_points as oracle

MU, J2, RADIUS = 1.3, 0.4, 0.9
POLE = np.array([0.48, -0.36, 0.8])
POSITION = np.array([1.1, -0.7, 0.9])
ATTRACTOR = oracle.OblateAttractor(MU, J2, RADIUS, POLE)
TURN, OTHER = Rotation.from_rotvec([0.7, -0.2, 1.1]), Rotation.from_rotvec([-1.0, 0.4, 0.3])


def cloud(mirrored):
    """Masses and points about their centre; a mirrored cloud has no third moments."""
    random = np.random.default_rng(4)
    masses, points = random.uniform(1, 2, 7), random.normal(size=(7, 3)) * [1.0, 0.7, 0.4]
    if mirrored:
        return np.tile(masses, 2), np.concatenate([points, -points])
    return masses, points - masses @ points / np.sum(masses)


def oblate(orbit, *flattening):
    return pt.GravityGradient(orbit), pt.forces.Oblateness(orbit, *flattening)


FORCE = oblate(pt.orbits.FixedPosition(MU, position=POSITION), J2, RADIUS, POLE)


def torque(body, forces, turn=TURN):
    return pt.System(body, *forces).torque_body(body.state(turn, omega_body=(0, 0, 0)))


def energy(body, forces, turn=TURN):
    return pt.System(body, *forces).potential_energy(body.state(turn, omega_body=(0, 0, 0)))


def relative(a, b):
    return np.linalg.norm(a - b) / np.linalg.norm(b)


# ---------------------------------------------------------------------- the oracle itself


@pytest.mark.parametrize("attractor", [ATTRACTOR, oracle.ringed(MU, 0.3, 0.5, POLE)], ids=["oblate", "ring"])
def test_the_attraction_of_the_oracle_is_the_slope_of_its_potential(attractor):
    h = 1e-5 * np.eye(3)
    slope = (attractor.potential(POSITION + h) - attractor.potential(POSITION - h)) / 2e-5
    assert np.max(np.abs(slope + attractor.attraction(POSITION))) < 1e-10


def test_the_tides_of_the_oracle_are_the_slopes_of_its_attraction():
    h = 1e-5 * np.eye(3)
    slopes = -(ATTRACTOR.attraction(POSITION + h) - ATTRACTOR.attraction(POSITION - h)) / 2e-5
    assert np.max(np.abs(slopes - ATTRACTOR.tides(POSITION))) < 1e-9


# ---------------------------------------------------------------------- an oblate attractor


@pytest.mark.parametrize(("mirrored", "rate"), [(False, 2), (True, 4)], ids=["any cloud", "mirrored cloud"])
def test_torque_is_the_limit_of_small_bodies(mirrored, rate):
    masses, points = cloud(mirrored)
    derived = torque(pt.Body.from_point_masses(masses, points), FORCE)

    def error(size):
        pulled = oracle.torque_of(ATTRACTOR, POSITION, masses, size * TURN.apply(points))
        return relative(TURN.inv().apply(pulled) / size**2, derived)

    sizes = (4e-3, 2e-3, 1e-3)
    errors = [error(size) for size in sizes]
    assert errors[-1] < (5e-3 if rate == 2 else 1e-5)
    assert errors[0] / errors[1] == pytest.approx(rate, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(rate, rel=0.02)


def test_energy_is_the_limit_of_small_bodies():
    """The difference between two attitudes."""
    masses, points = cloud(mirrored=True)
    body = pt.Body.from_point_masses(masses, points)
    derived = energy(body, FORCE, TURN) - energy(body, FORCE, OTHER)

    def error(size):
        here, there = (
            oracle.energy_of(ATTRACTOR, POSITION, masses, size * turn.apply(points)) for turn in (TURN, OTHER)
        )
        return abs((here - there) / size**2 / derived - 1)

    errors = [error(size) for size in (8e-3, 4e-3, 2e-3)]
    assert errors[-1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize("turn", list(Rotation.random(5, np.random.default_rng(8))))
def test_torque_of_the_inertia_alone(turn):
    masses, points = cloud(mirrored=False)
    derived = torque(pt.Body.from_point_masses(masses, points), FORCE, turn)
    inertia = oracle.inertia_of(masses, turn.apply(points))
    assert relative(turn.apply(derived), oracle.torque_of_tides(ATTRACTOR, POSITION, inertia)) < 3e-14


def test_a_small_ring_is_an_oblate_attractor():
    """The ring's own J4 and more leave a difference with the fourth power of its radius."""
    masses, points = cloud(mirrored=True)
    body, size, fraction = pt.Body.from_point_masses(masses, points), 1e-5, 0.5

    def error(radius):
        pulled = oracle.torque_of(
            oracle.ringed(MU, fraction, radius, POLE), POSITION, masses, size * TURN.apply(points)
        )
        forces = oblate(pt.orbits.FixedPosition(MU, position=POSITION), fraction / 2, radius, POLE)
        return relative(TURN.inv().apply(pulled) / size**2, torque(body, forces))

    errors = [error(radius) for radius in (0.12, 0.06, 0.03)]
    assert errors[-1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.05)


def test_a_second_flattening_turns_the_body_elsewhere():
    """What the tests above would miss: without j2, or about another pole, the torque is another one."""
    body = pt.Body.from_point_masses(*cloud(mirrored=False))
    point = pt.orbits.FixedPosition(MU, position=POSITION)
    for other in ((pt.GravityGradient(point),), oblate(point, J2, RADIUS, (0, 0, 1))):
        assert relative(torque(body, other), torque(body, FORCE)) > 0.05


TIMES = np.array([-3.0, -1.0, 0.3, 2.0, 5.0])


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@pytest.mark.parametrize("seed", range(2))
def test_motion_about_two_oblate_attractors_is_that_of_euler_and_newton(seed, formulation):
    random = np.random.default_rng(seed)
    masses, points = cloud(mirrored=False)
    inertia = oracle.inertia_of(masses, points) / 10
    turn, omega = Rotation.random(None, random), random.uniform(-1, 1, 3)
    elements = (1.3, 1.4, 0.3, 0.8, *random.uniform(-2, 2, 3))
    poles = [direction / np.linalg.norm(direction) for direction in random.normal(size=(2, 3))]
    orbits = (in_order(pt.KeplerOrbit, *elements, epoch=0.2), pt.orbits.FixedPosition(0.9, position=POSITION))
    attractors = (
        euler_newton.Attractor(elements[0], *euler_newton.cartesian_vectors(*elements), epoch=0.2),
        euler_newton.Attractor(0.9, POSITION),
    )
    fields = [oracle.OblateAttractor(a.mu, 0.2, 0.7, pole) for a, pole in zip(attractors, poles, strict=True)]

    def pulled(index):
        def torque(A, _omega, positions):
            return A.T @ oracle.torque_of_tides(fields[index], positions[index], A @ inertia @ A.T)

        return torque

    judged = euler_newton.integrate(inertia, turn.as_matrix(), omega, 0.0, TIMES, [pulled(0), pulled(1)], attractors)
    body = pt.Body.from_inertia(inertia)
    forces = [f for orbit, pole in zip(orbits, poles, strict=True) for f in oblate(orbit, 0.2, 0.7, pole)]
    state = body.state(turn, omega_body=omega)
    motion = pt.propagate(pt.System(body, *forces), state, TIMES, formulation=formulation)
    assert np.max(np.abs(motion.attitude.as_matrix() - judged[0])) < 1e-11
    assert np.max(np.abs(motion.omega_body - judged[1])) < 1e-11


# ---------------------------------------------------------------------- several attractors


def test_three_attractors_are_the_sum_of_their_points():
    masses, points = cloud(mirrored=True)
    body, size = pt.Body.from_point_masses(masses, points), 1e-4
    places, mus = np.array([[3.0, 1, 0], [-2, 2, 1], [0.5, -3, 2]]), np.array([2.0, 0.7, 1.1])
    # The attractors stand around the body, which is at the origin.
    attractors = [
        pt.GravityGradient(pt.orbits.FixedPosition(mu, position=-place)) for place, mu in zip(places, mus, strict=True)
    ]
    system = pt.System(body, *attractors)
    derived = system.torque_body(body.state(TURN, omega_body=(0, 0, 0)))
    pulled = oracle.torque_of(oracle.PointAttractor(mus, places), np.zeros(3), masses, size * TURN.apply(points))
    assert relative(TURN.inv().apply(pulled) / size**2, derived) < 1e-7


# ---------------------------------------------------------------------- a body from its gravity field


@pytest.mark.parametrize("seed", range(4))
def test_body_from_the_stokes_coefficients_of_points(seed):
    random = np.random.default_rng(seed)
    masses, points, radius = random.uniform(1, 2, 6), random.normal(size=(6, 3)), 1.7
    points -= masses @ points / np.sum(masses)
    inertia, mass = oracle.inertia_of(masses, points), np.sum(masses)
    coefficients = oracle.stokes(masses, points, radius)
    assert coefficients.pop("S20") == 0
    body = pt.Body.from_stokes(
        **coefficients, polar_moment_factor=inertia[2, 2] / (mass * radius**2), mass=mass, radius=radius
    )
    assert np.max(np.abs(body.inertia - inertia)) < 1e-14 * np.trace(inertia)
    assert np.max(np.abs(body.inertia - pt.Body.from_point_masses(masses, points).inertia)) < 1e-14 * np.trace(inertia)


def test_the_coefficients_are_those_of_the_potential_outside():
    """What degree 2 leaves falls as r^-4: the signs and factors of all five coefficients are the usual ones."""
    masses, points = cloud(mirrored=False)
    coefficients, direction = oracle.stokes(masses, points, 2.0), np.array([0.36, -0.48, 0.8])
    attractor = oracle.PointAttractor(masses, points)

    def rest(r):
        return attractor.potential(r * direction) - oracle.outer_potential(
            np.sum(masses), 2.0, coefficients, r * direction
        )

    assert rest(200.0) / rest(400.0) == pytest.approx(16, rel=0.03)
    assert rest(400.0) / rest(800.0) == pytest.approx(16, rel=0.03)
