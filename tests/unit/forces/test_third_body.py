"""The tidal field of a third body on two, against Newton's law between points of mass in 60 digits."""

from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt

MU = 1.3e20
OFFSETS = [(1.0, 0.8, 0.5), (0.3, 0.2, 0.15)]
MASSES = (5e11, 4e9)
TURNS = Rotation.random(2, np.random.default_rng(3))
DIRECTION = np.array([0.6, -0.64, 0.48])


def body_of(mass, offsets):
    """The body of six equal points at both ends of three axes."""
    x, y, z = np.square(offsets)
    return pt.Body(mass / 3 * np.array([y + z, x + z, x + y]), mass=mass)


def newtons_law(place, separation, size):
    """The force along the separation and both torques, body axes, of points of mass."""
    R, r = ([mpmath.mpf(float(x)) for x in vector] for vector in (place, separation))
    m1, m2 = map(mpmath.mpf, MASSES)
    levers = (-m2 / (m1 + m2), m1 / (m1 + m2))
    forces, torques = [], []
    for mass, offsets, turn, lever in zip((m1, m2), OFFSETS, TURNS, levers, strict=True):
        q = [mpmath.mpf(float(x)) for x in turn.as_quat(scalar_first=True)]
        norm = mpmath.sqrt(sum(x * x for x in q))
        matrix = matrix_of([x / norm for x in q])
        force, torque = [mpmath.mpf(0)] * 3, [mpmath.mpf(0)] * 3
        for axis in range(3):
            for sign in (1, -1):
                arm = [sign * mpmath.mpf(size * offsets[axis]) * matrix[i][axis] for i in range(3)]
                at = [a + lever * b + c for a, b, c in zip(R, r, arm, strict=True)]
                pull = -mpmath.mpf(MU) * mass / 6 / mpmath.sqrt(sum(x * x for x in at)) ** 3
                each = [pull * x for x in at]
                force = [a + b for a, b in zip(force, each, strict=True)]
                cross = [arm[i - 2] * each[i - 1] - arm[i - 1] * each[i - 2] for i in range(3)]
                torque = [a + b for a, b in zip(torque, cross, strict=True)]
        forces.append(force)
        torques.append([sum(matrix[i][j] * torque[i] for i in range(3)) for j in range(3)])
    relative = [(m1 * b - m2 * a) / (m1 + m2) for a, b in zip(*forces, strict=True)]
    return [np.array(list(map(float, vector))) for vector in (relative, *torques)]


def matrix_of(q):
    w, x, y, z = q
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


@pytest.mark.parametrize(("distance", "size"), [(1.5e11, 100.0), (1e5, 20.0)], ids=["the Sun", "a close planet"])
def test_forces_and_torques_are_those_on_points_of_mass(distance, size):
    """Points leave what is of fourth degree: some (size / distance)^2 of the torque, and of its part of the force."""
    left = 10 * (size / distance) ** 2
    bounds = [4e-15 + left * size**2 / distance / 1000, 4e-15 + left, 4e-15 + left]
    pair = pt.TwoBodies(*(body_of(m, size * np.array(x)) for m, x in zip(MASSES, OFFSETS, strict=True)))
    orbit = pt.orbits.FixedPosition(MU, position=distance * DIRECTION)
    system: Any = pt.System(pair, pt.forces.ThirdBody(orbit))
    separation = np.array([900.0, -300.0, 450.0])
    start = pair.state(separation, (0, 0, 0), list(TURNS), omega_body=[(0, 0, 0)] * 2)
    load = system.dynamics.load_at(system.at(start))
    with mpmath.workdps(60):
        exact = newtons_law(orbit.position, separation, size)
    for found, vector, bound in zip((load.force, *load.torques), exact, bounds, strict=True):
        assert np.linalg.norm(np.array(list(found)) - vector) < bound * np.linalg.norm(vector)


def test_motion_is_that_of_three_bodies():
    """Of a light pair of spheres about a heavy body that Newton's law moves as well."""
    heavy, masses = 1000.0, np.array([0.02, 0.005])
    balls = [pt.Body((0.4 * m * 1e-4,) * 3, mass=m) for m in masses]
    pair = pt.TwoBodies(*balls, G=1.0)
    barycentre, speed = np.array([60.0, 0, 0]), np.array([0, 4.4, 0.6])
    r, v = np.array([0.5, 0.1, 0.2]), np.array([-0.02, 0.19, 0.08])
    orbit = pt.KeplerOrbit.from_vectors(heavy + masses.sum(), position=barycentre, velocity=speed)
    start = pair.state(r, v, [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
    times = np.linspace(0, 30, 4)
    system = pt.System(pair, pt.forces.MutualGravity(), pt.forces.ThirdBody(orbit))
    motion: Any = pt.propagate(system, start, times)

    def rates(_, y):
        places, gm = y[:9].reshape(3, 3), np.array([heavy, *masses])
        apart = places[None] - places[:, None] + 1e9 * np.eye(3)[:, :, None]
        pull = gm[None, :, None] * apart / np.linalg.norm(apart, axis=-1)[..., None] ** 3
        return np.concatenate([y[9:], np.sum(pull * (1 - np.eye(3))[..., None], axis=1).ravel()])

    first, second = masses / masses.sum()
    begin = [np.zeros(3), barycentre - second * r, barycentre + first * r]
    begin += [np.zeros(3), speed - second * v, speed + first * v]
    run = solve_ivp(rates, (0, 30), np.concatenate(begin), "DOP853", times, rtol=1e-12, atol=1e-12)
    apart = run.y[6:9] - run.y[3:6]
    plain: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, times)
    assert np.max(np.abs(plain.position - apart.T)) > 0.1
    # mu of the orbit is that of all three: the field is too strong by the pair's part of it, 2.5e-5
    assert np.max(np.abs(motion.position - apart.T)) < 2e-4
