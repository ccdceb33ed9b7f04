"""Euler's equation and Newton's, with a rotation matrix and torques written by hand; knows nothing of poinsot."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

PRECISION = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


@dataclass
class Attractor:
    """Its gravitational parameter, and the body's position and velocity from it at its epoch; at rest if None."""

    mu: float
    position: np.ndarray
    velocity: np.ndarray | None = None
    epoch: float = 0.0


def uniform_gravity(weight, center_of_mass):
    """The force -weight s3 at the centre of mass: torque = lever x force, both along the body axes."""

    def torque(A, _omega, _positions):
        return cross(center_of_mass, A.T @ [0, 0, -weight])

    return torque


def gravity_gradient(inertia, attractor, index=0):
    """The torque 3 mu / r^5 r x I r, r along the body axes; `index` is the place of the attractor in the list."""

    def torque(A, _omega, positions):
        r = A.T @ positions[index]
        return 3 * attractor.mu / np.linalg.norm(r) ** 5 * cross(r, inertia @ r)

    return torque


def linear_damping(coefficient):
    def torque(_A, omega, _positions):
        return -coefficient * omega

    return torque


def cartesian_vectors(mu, a, e, inclination, node, argument, anomaly):
    """Position and velocity of an ellipse from its elements, by three rotation matrices."""
    p = a * (1 - e**2)
    to_space = about(2, node) @ about(0, inclination) @ about(2, argument)
    position = p / (1 + e * np.cos(anomaly)) * np.array([np.cos(anomaly), np.sin(anomaly), 0])
    velocity = np.sqrt(mu / p) * np.array([-np.sin(anomaly), e + np.cos(anomaly), 0])
    return to_space @ position, to_space @ velocity


def cross(a, b):
    return skew(a) @ b


def skew(a):
    """The matrix of the vector product with a from the left."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def about(axis, angle):
    """The active rotation matrix about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[j, i], matrix[i, j] = np.sin(angle), -np.sin(angle)
    return matrix


def integrate(inertia, matrix, omega, start, times, torques=(), attractors=()):
    """Return the active matrices (n, 3, 3) and the rates in body axes (n, 3) at the times, in any order.

    I omega' = (I omega) x omega + torques, A' = A [omega]x, r'' = -mu r / r^3 for each attractor that is not at
    rest, from the start time in both directions.
    """
    inertia, times = np.asarray(inertia, dtype=float), np.asarray(times, dtype=float)
    inverse = np.linalg.inv(inertia)
    orbits = np.concatenate([np.empty(0), *(_at(attractor, start) for attractor in attractors)])
    initial = np.concatenate([omega, np.ravel(matrix), orbits])

    def rates(_, state):
        omega, A, orbits = state[:3], state[3:12].reshape(3, 3), state[12:].reshape(-1, 2, 3)
        torque = sum((torque(A, omega, orbits[:, 0]) for torque in torques), start=np.zeros(3))
        acceleration = inverse @ (cross(inertia @ omega, omega) + torque)
        falling = [_orbital_rates(attractor, *orbit) for attractor, orbit in zip(attractors, orbits, strict=True)]
        return np.concatenate([acceleration, (A @ skew(omega)).ravel(), *falling])

    states = np.empty((times.size, initial.size))
    for one_way in (times >= start, times < start):
        chosen = np.flatnonzero(one_way)
        chosen = chosen[np.argsort(np.abs(times[chosen] - start))]
        states[chosen] = _integrated(rates, start, initial, times[chosen])
    return states[:, 3:12].reshape(-1, 3, 3), states[:, :3]


def _integrated(rates, start, initial, times):
    """The states at times that lead away from the start."""
    if times.size == 0 or times[-1] == start:
        return np.broadcast_to(initial, (times.size, initial.size))
    return solve_ivp(rates, (start, times[-1]), initial, t_eval=times, **PRECISION).y.T


def _orbital_rates(attractor, r, v):
    if attractor.velocity is None:
        return np.zeros(6)
    return np.concatenate([v, -attractor.mu / np.linalg.norm(r) ** 3 * r])


def _at(attractor, time):
    """Position and velocity of one attractor's orbit at a time, integrated from its epoch."""
    at_rest = attractor.velocity is None
    here = np.concatenate([attractor.position, np.zeros(3) if at_rest else attractor.velocity])
    if at_rest or time == attractor.epoch:
        return here

    def rates(_, state):
        return _orbital_rates(attractor, state[:3], state[3:])

    return _integrated(rates, attractor.epoch, here, np.array([time]))[-1]
