"""What the motion of two bodies conserves, found from the formulas themselves."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.branch_exploration import BRANCHES, conditions, on_branches
from poinsot.mechanics.circular_pair import mean_motion
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import PairLoad
from poinsot.mechanics.integrals import EPS, ROUNDINGS, Integral, component_of
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.probing import samples
from poinsot.taylor.graph import Graph, tangents

__all__ = ["integrals_of_pair"]

Array = NDArray[np.float64]

SAMPLES = 6


def integrals_of_pair(system: Any) -> tuple[Integral, ...]:
    """Return the integrals of two bodies: the energy, and the total angular momentum along the axes of space."""
    rows, branching = _rates_at(system, SAMPLES)
    if branching:
        others, _ = _rates_at(system, BRANCHES, forced=True)
        rows = [np.concatenate(pair, axis=-1) for pair in zip(rows, others, strict=True)]
    plain, shaken = ([row[..., half, :] for row in rows] for half in (0, 1))
    noise = [_largest(x - y) for x, y in zip(plain, shaken, strict=True)]
    (energy, change), power, torque = plain[:2], plain[2:POWERS], plain[POWERS:]
    found = []
    alike = _vanishes(change, EPS * _largest(energy))
    if alike and _vanishes(sum(power), sum(noise[2:POWERS]) + EPS * np.max([_largest(term) for term in power], axis=0)):
        found.append(Integral("energy", "H", "H = T + U", system.energy, is_energy=True))
    sizes = np.max([_largest(rate) for rate in torque], axis=0)
    for i in range(3):
        spread = sum(noise[POWERS + i :: 3]) + EPS * sizes
        if _vanishes(sum(torque[i::3]), spread):
            meaning = f"the total angular momentum along the axis {i + 1} in space"
            value = functools.partial(component_of, "space", np.eye(3)[i])
            found.append(Integral(f"angular_momentum_space_{i + 1}", f"G{i + 1}", meaning, value))
    return tuple(found)


POWERS = 5
"""Rows before those of the torque: the energy, its change, and three of its rate."""


def _samples(system: Any, count: int) -> dict[str, Array]:
    """Return attitudes, directions, times and rates at samples, followed by their neighbours a rounding away."""
    random = np.random.default_rng(20061027)
    q, time, omega = samples(system, count)
    more = {
        "second": random.normal(size=(count, 4)),
        "place": random.normal(size=(count, 3)),
        "velocity": random.normal(size=(count, 3)),
        "stretch": random.uniform(0.7, 2.0, count),
    }
    for name in ("second", "place"):
        more[name] /= np.linalg.norm(more[name], axis=-1, keepdims=True)
    plain = {"first": q, "time": time, "omega": omega, **more}
    shaken = {name: x * (1 + EPS * random.uniform(-2, 2, x.shape)) for name, x in plain.items()}
    return {name: np.concatenate((x, shaken[name])) for name, x in plain.items()}


def _rates_at(system: Any, count: int, forced: bool = False) -> tuple[list[Array], bool]:
    """Return rows at samples and at neighbours a rounding away, (..., 2, n), and whether formulas have conditions.

    The energy, its change to another time, the terms of its rate (explicit, of forces, of torques) and, by axes of
    space, the terms of the torque about the barycentre. Forced conditions go every way, and the change of the energy is
    that to the other branches.
    """
    given, graph, twin = _samples(system, count), Graph(), system.beside((*system.members, count))
    pair, pace = twin.pair, np.asarray(mean_motion(system.pair, system.sample_distance))[..., None]

    def variables(values: Any) -> Vector:
        return Vector(map(graph.variable, values))

    time = graph.variable(given["time"])
    position = variables(x * system.sample_distance * given["stretch"] for x in given["place"].T)
    momentum = variables(pair.reduced_mass * system.sample_distance * pace * x for x in given["velocity"].T)
    attitudes = [Attitude.from_quaternion(variables(given[name].T)) for name in ("first", "second")]
    rate = variables(pace * x for x in given["omega"].T)
    momenta = [Vector(body.angular_momentum(rate)) for body in pair.bodies.values()]
    instant = PairInstant(pair, attitudes, position, Environment(time), momentum, momenta)
    energy, load = twin.potential_at(instant.without_rates), twin.load_at(instant)
    (explicit,) = tangents([energy], {time: 1.0})
    loads = [force.load(instant) for force in twin.forces if isinstance(force, PairLoad)]
    pushing = sum(functions.dot(each.force, instant.relative_velocity) for each in loads)
    twisting = sum(functions.dot(torque, rate) for each in loads for torque in each.torques)
    turned = [a.to_space(torque) for a, torque in zip(attitudes, load.torques, strict=True)]
    terms = [x for vector in (functions.cross(position, load.force), *turned) for x in vector]
    rows = [energy, explicit, pushing, twisting, *terms]
    branching = bool(conditions(rows))
    still = [Attitude.from_quaternion(Vector(given[name].T)) for name in ("first", "second")]
    place = [x.value for x in position]  # a condition on attitudes and position alone switches nothing
    timed = twin.potential_at(PairInstant(pair, still, place, Environment(time)))
    if forced:
        here, there = (on_branches(graph, [timed], 2 * count, other)[0] for other in (False, True))
        rows = on_branches(graph, rows, 2 * count)
    else:
        later = twin.potential_at(PairInstant(pair, still, place, Environment(np.roll(given["time"], 1))))
        here, there, *rows = graph.evaluated([timed, later, *rows])
    shape = (*system.members, 2 * count)
    found = [np.broadcast_to(np.asarray(row, dtype=float), shape) for row in (rows[0], here - there, *rows[1:])]
    return [row.reshape(*row.shape[:-1], 2, -1) for row in found], branching


def _largest(values: Any) -> Any:
    return np.max(np.abs(values), axis=-1)


def _vanishes(rate: Any, noise: Any) -> bool:
    return bool(np.all(_largest(rate) <= ROUNDINGS * noise))
