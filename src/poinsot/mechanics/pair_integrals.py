"""What the motion of two bodies conserves, found from the formulas themselves."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.algebra.program import Graph, tangents
from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import PairLoad
from poinsot.mechanics.integrals import EPS, ROUNDINGS, SAME, Integral, component_of
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.probing import samples

__all__ = ["integrals_of_pair"]

Array = NDArray[np.float64]

SAMPLES = 6


def integrals_of_pair(system: Any) -> tuple[Integral, ...]:
    """Return the integrals of two bodies: the energy, and the total angular momentum along the axes of space."""
    plain, shaken = (_rates_at(system, sampled) for sampled in _samples(system))
    noise = [_largest(x - y) for x, y in zip(plain, shaken, strict=True)]
    energy, power, torque = plain[0], plain[1], plain[2:]
    found = []
    if _vanishes(power, noise[1] + SAME * _largest(energy) * system_pace(system)):
        found.append(Integral("energy", "H", "H = T + U", system.energy, is_energy=True))
    sizes = np.max([_largest(rate) for rate in torque], axis=0)
    for i in range(3):
        terms = torque[i::3]
        spread = sum(noise[2 + i :: 3]) + EPS * sizes
        if _vanishes(sum(terms), spread):
            meaning = f"the total angular momentum along the axis {i + 1} in space"
            value = functools.partial(component_of, "space", np.eye(3)[i])
            found.append(Integral(f"angular_momentum_space_{i + 1}", f"G{i + 1}", meaning, value))
    return tuple(found)


def system_pace(system: Any) -> Any:
    """Return the mean motion of a circular orbit at the distance of the samples."""
    pair = system.pair
    return np.sqrt(pair.G * pair.total_mass / system.sample_distance**3)


def _samples(system: Any) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return attitudes, directions, times and rates at samples, and their neighbours a rounding away."""
    random = np.random.default_rng(20061027)
    q, time, omega = samples(system, SAMPLES)
    more = {
        "second": random.normal(size=(SAMPLES, 4)),
        "place": random.normal(size=(SAMPLES, 3)),
        "velocity": random.normal(size=(SAMPLES, 3)),
        "stretch": random.uniform(0.7, 2.0, SAMPLES),
    }
    for name in ("second", "place"):
        more[name] /= np.linalg.norm(more[name], axis=-1, keepdims=True)
    plain = {"first": q, "time": time, "omega": omega, **more}
    return plain, {name: x * (1 + EPS * random.uniform(-2, 2, x.shape)) for name, x in plain.items()}


def _rates_at(system: Any, given: dict[str, Array]) -> list[Array]:
    """Return energy, its rate and, by body axes of space, the terms of the torque about the barycentre; (..., n)."""
    graph, twin = Graph(), system.beside_samples
    pair, time, pace = twin.pair, graph.variable(given["time"]), np.asarray(system_pace(system))[..., None]
    distance = system.sample_distance * given["stretch"]
    position = Vector(x * distance for x in given["place"].T)
    momentum = Vector(pair.reduced_mass * system.sample_distance * pace * x for x in given["velocity"].T)
    attitudes = [Attitude.from_quaternion(Vector(given[name].T)) for name in ("first", "second")]
    rate = Vector(pace * x for x in given["omega"].T)
    momenta = [Vector(body.angular_momentum(rate)) for body in pair.bodies.values()]
    instant = PairInstant(pair, attitudes, position, Environment(time), momentum, momenta)
    energy, load = twin.potential_at(instant.without_rates), twin.load_at(instant)
    (explicit,) = tangents([energy], {time: 1.0})
    power = explicit
    for each in (force.load(instant) for force in twin.forces if isinstance(force, PairLoad)):
        power = power + functions.dot(each.force, instant.relative_velocity)
        power = power + sum(functions.dot(torque, rate) for torque in each.torques)
    turned = [a.to_space(torque) for a, torque in zip(attitudes, load.torques, strict=True)]
    terms = [x for vector in (functions.cross(position, load.force), *turned) for x in vector]
    rows = graph.evaluated([energy, power, *terms])
    shape = (*system.members, SAMPLES)
    return [np.broadcast_to(np.asarray(row, dtype=float), shape) for row in rows]


def _largest(values: Any) -> Any:
    return np.max(np.abs(values), axis=-1)


def _vanishes(rate: Any, noise: Any) -> bool:
    return bool(np.all(_largest(rate) <= ROUNDINGS * noise))
