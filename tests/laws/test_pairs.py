"""What holds for two bodies: limits, exchange, units, kernels, ensembles, the way back, tangent vectors."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from kinds.pairs import ENDS, NAMES, PAIR_FORCES, SPINS, TURNS, propagated, rows, start_of, system_of

each_system = pytest.mark.parametrize("name", NAMES)


def test_every_force_on_two_bodies_is_here():
    """Potentials are here or in the laws of forces on one body."""
    assert concrete_subclasses(pt.mechanics.PairLoad) == {
        force for force in PAIR_FORCES if issubclass(force, pt.mechanics.PairLoad)
    }


# ---------------------------------------------------------------------- symmetries


@each_system
def test_exchange_of_the_two_bodies_changes_nothing(name):
    system = system_of(name, exchanged=True)
    motion, swapped = propagated(name), pt.propagate(system, start_of(system, exchanged=True), ENDS)
    own = np.concatenate([rows(motion)[:, :6], rows(motion)[:, 6:]], axis=1)
    other = rows(swapped)
    back = np.concatenate([-other[:, :6], other[:, 13:], other[:, 6:13]], axis=1)
    assert np.max(np.abs(own - back)) < 2e-13


@each_system
@pytest.mark.parametrize("units", [(5.2e11, 1183.7, 6830.0), (1e-12, 1e-3, 1.0), (3e24, 4e8, 9e7)])
def test_the_units_change_nothing(name, units):
    M, L, T = units
    system = system_of(name, M=M, L=L, T=T)
    other = pt.propagate(system, start_of(system, L=L, T=T), T * ENDS)
    assert np.max(np.abs(rows(other) - rows(propagated(name)))) < 2e-13


@each_system
def test_a_motion_runs_back_to_its_start(name):
    motion = propagated(name)
    back: Any = pt.propagate(motion.system, motion.isel(time=-1), [0.0])
    start = start_of(motion.system)
    whole: Any = pt.propagate(motion.system, start, [0.0])
    assert np.max(np.abs(rows(back) - rows(whole))) < 1.5e-13  # three times the worst of shaken starts


# ---------------------------------------------------------------------- kernels and ensembles


@each_system
def test_both_precisions_give_one_motion(name):
    assert np.max(np.abs(rows(propagated(name)) - rows(propagated(name, precision="quadruple")))) < 1e-13


@each_system
def test_members_of_an_ensemble_are_those_alone(name):
    system = system_of(name)
    shifts = np.linspace(0, 0.5, 5)[:, None] * np.array([0.3, -0.8, 0.2])
    together: Any = pt.propagate(system, start_of(system, shift=shifts), ENDS)
    for i, shift in enumerate(shifts):
        alone = pt.propagate(system, start_of(system, shift=shift), ENDS)
        assert np.max(np.abs(rows(together.member(i)) - rows(alone))) < 1e-13


# ---------------------------------------------------------------------- tangent vectors


@pytest.mark.parametrize("name", [*NAMES[:2], *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES[2:])])
def test_columns_are_differences_of_motions(name):
    system = system_of(name)
    start, h = start_of(system), 1e-5
    matrix = pt.analysis.state_transition(system, start, [8.0]).matrix[0]
    ahead, behind = (coordinates(system, start, sign * h * np.eye(18)) for sign in (1, -1))
    differences = (ahead - behind).T / (2 * h)
    # what differences leave is of the third derivatives times the square of the step, 1.4e-8 of the largest entry
    assert np.max(np.abs(matrix - differences)) < 6e-8 * np.max(np.abs(matrix))


def coordinates(system, start, changes):
    """Where changed starts lead, by the coordinates about the one that was not changed; shape (18, 18)."""
    turned, momenta = [], []
    for i, state in enumerate((start.primary, start.secondary)):
        theta, gamma = changes[:, 6 * i : 6 * i + 3], changes[:, 6 * i + 3 : 6 * i + 6]
        turned.append((state.attitude * Rotation.from_rotvec(theta)).as_quat(scalar_first=True))
        momenta.append(state.angular_momentum_body + gamma)
    moved, velocity = start.position + changes[:, 12:15], (start.momentum + changes[:, 15:]) / system.body.reduced_mass
    motion: Any = pt.propagate(system, system.state(moved, velocity, turned, angular_momentum_body=momenta), [8.0])
    base: Any = pt.propagate(system, start, [8.0])
    found = []
    for own, view in ((base.primary, motion.primary), (base.secondary, motion.secondary)):
        turn = own.attitude.inv() * Rotation.from_quat(view.quaternion[:, 0], scalar_first=True)
        found += [turn.as_rotvec(), view.angular_momentum_body[:, 0] - own.angular_momentum_body]
    return np.concatenate([*found, motion.position[:, 0] - base.position, motion.momentum[:, 0] - base.momentum], 1)


# ---------------------------------------------------------------------- one extended body


def attitude_off(mass, size):
    """How far the rotation of a secondary is from that of a body on a given ellipse, after a revolution; radians."""
    moon = pt.Body(mass * size**2 * np.array([0.7, 1.0, 1.3]), mass=mass)
    pair = pt.TwoBodies(pt.Body((0.4, 0.4, 0.4), mass=1.0), moon, G=1.0)
    r, v = np.array([10.0, 0, 0]), np.array([0, 0.33, 0.04])
    spin = (0.01, 0.02, 0.04)
    times = np.linspace(0, 200, 5)
    start = pair.state(r, v, [(1, 0, 0, 0), TURNS[1]], omega_body=[(0, 0, 0), spin])
    coupled: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, times)
    orbit = pt.KeplerOrbit.from_vectors(1.0, position=r, velocity=v)
    given = pt.System(moon, pt.GravityGradient(orbit))
    alone = pt.propagate(given, moon.state(TURNS[1], omega_body=spin), times)
    return 2 * np.linalg.norm(coupled.secondary.quaternion[-1] - alone.quaternion[-1])


def test_a_light_secondary_turns_as_in_a_given_orbit_to_first_order_in_its_mass():
    """Its mass moves the attractor; its size is nothing here."""
    off = [attitude_off(mass, 1e-9) for mass in (1e-5, 1e-4, 1e-3)]
    assert off[0] < 1e-3
    assert np.allclose(np.diff(np.log10(off)), 1.0, rtol=0, atol=0.02)


def test_a_small_secondary_turns_as_in_a_given_orbit_to_second_order_in_its_size():
    """Its moments move the orbit; its mass is nothing here."""
    off = [attitude_off(1e-18, size) for size in (0.01, 0.03, 0.09)]
    assert off[0] < 1e-4
    assert np.allclose(np.diff(np.log(off)) / np.log(3), 2.0, rtol=0, atol=0.02)


def test_an_oblate_attractor_turns_a_body_and_bends_its_orbit():
    """Against the torque on a body at a given place, and the acceleration by J2 of textbooks."""
    radius, j2 = 2.0, 0.03
    attractor = pt.Body((1.6, 1.6, 1.6 + j2 * 3.0 * radius**2), mass=3.0)
    moon = pt.Body((0.1, 0.12, 0.15), mass=0.5)
    ball = pt.Body((0.12, 0.12, 0.12), mass=0.5)
    r = np.array([5.0, -2.0, 3.0])
    upright = (1, 0, 0, 0)
    loads = []
    for body in (moon, ball):
        system: Any = pt.System(pt.TwoBodies(attractor, body, G=1.0), pt.forces.MutualGravity())
        state = system.state(r, (0, 0.5, 0), [upright, TURNS[1]], omega_body=SPINS)
        loads.append(system.dynamics.load_at(system.at(state)))
    place = pt.orbits.FixedPosition(3.0, position=r)
    torque = pt.System(moon, pt.GravityGradient(place)).torque_body(moon.state(TURNS[1], omega_body=SPINS[1]))
    assert np.allclose(list(loads[0].torques[1]), torque, rtol=0, atol=1e-15 * np.linalg.norm(torque) * 8)
    x, y, z = r
    distance = np.linalg.norm(r)
    height = 5 * z**2 / distance**2
    by_j2 = -1.5 * j2 * 3.0 * radius**2 / distance**5 * np.array([x * (1 - height), y * (1 - height), z * (3 - height)])
    force = 0.5 * (-3.0 * r / distance**3 + by_j2)
    assert np.allclose(list(loads[1].force), force, rtol=0, atol=2e-15 * np.linalg.norm(force))
    back = np.cross(r, list(loads[1].force)) + list(loads[1].torques[0])
    assert np.linalg.norm(back) < 1e-15 * distance * np.linalg.norm(force)


# ---------------------------------------------------------------------- long motions


def test_spheres_move_on_the_ellipse_of_kepler():
    """And turn uniformly, over 100 revolutions."""
    mass, a, e = 3.5, 5.0, 0.4
    pair = pt.TwoBodies(pt.Body((0.8,) * 3, mass=3.0), pt.Body((0.05,) * 3, mass=0.5), G=1.0)
    n = np.sqrt(mass / a**3)
    tilt = Rotation.from_rotvec((0.3, -0.2, 0.5))
    r, v = tilt.apply((a * (1 - e), 0, 0)), tilt.apply((0, n * a * np.sqrt((1 + e) / (1 - e)), 0))
    start = pair.state(r, v, TURNS, omega_body=SPINS)
    times = np.linspace(0, 200 * np.pi / n, 13)
    motion: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, times)
    mean = np.remainder(n * times, 2 * np.pi)
    E = mean
    for _ in range(60):
        E = mean + e * np.sin(E)
    ellipse = np.stack([a * (np.cos(E) - e), a * np.sqrt(1 - e**2) * np.sin(E), 0 * E], axis=-1)
    # Roundings of the start change the energy, and with it the phase after 628 radians: three times the worst of ten
    # shaken starts, 5.1e-12 of the semimajor axis, and 1.9e-12 in the attitudes.
    assert np.max(np.abs(motion.position - tilt.apply(ellipse))) < 1.6e-11 * a
    for view, turn, spin in zip((motion.primary, motion.secondary), TURNS, SPINS, strict=True):
        turned = Rotation.from_quat(turn, scalar_first=True) * Rotation.from_rotvec(np.outer(times, spin))
        assert np.max((view.attitude.inv() * turned).magnitude()) < 6e-12


@pytest.mark.parametrize(("orbits", "bound"), [(300, 5e-14), pytest.param(10_000, 5e-13, marks=pytest.mark.slow)])
def test_energy_and_angular_momentum_are_conserved(orbits, bound):
    """Measured on shaken starts: 1e-14 and 7e-14 of the momentum, 8e-16 and 3e-15 of the energy."""
    system = system_of("gravity")
    period = 2 * np.pi * 6.4**1.5 / np.sqrt(3.5)
    motion: Any = pt.propagate(system, start_of(system), np.linspace(0, orbits * period, 21))
    G = motion.angular_momentum_space
    assert np.max(np.abs(motion.energy / motion.energy[0] - 1)) < bound / 10
    assert np.max(np.linalg.norm(G - G[0], axis=-1)) < bound * np.linalg.norm(G[0])
