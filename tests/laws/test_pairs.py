"""What holds for two bodies: limits, exchange, units, kernels, ensembles, the way back, tangent vectors."""

from typing import Any

import numpy as np

import poinsot as pt

TURNS = [np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]
SPINS = [np.array([0.1, 0.2, 1.0]), np.array([0.05, 0.1, 0.4])]


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
        loads.append(system.load_at(system.at(state)))
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
