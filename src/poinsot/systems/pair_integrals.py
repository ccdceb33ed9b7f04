"""Integrals of the motion of two bodies: the energy, and the total angular momentum along the space axes."""

from __future__ import annotations

import functools
from collections.abc import Iterable

import numpy as np

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import PairLoad
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.two_bodies import mean_motion
from poinsot.quantities import Array
from poinsot.systems.integrals import (
    EPS,
    Integral,
    SampledRates,
    TracedRates,
    component_of,
    largest,
    shaken,
    vanishes,
)
from poinsot.systems.pair_dynamics import PairDynamics
from poinsot.systems.probing import samples
from poinsot.taylor.graph import Graph, tangents

__all__ = ["integrals_of_pair"]


def integrals_of_pair(system: PairDynamics) -> tuple[Integral, ...]:
    """Return the integrals of a system of two bodies."""
    found = SampledRates(system, functools.partial(_traced, system))
    (energy, *power), torque = found.rows[:ENERGY_ROWS], found.rows[ENERGY_ROWS:]
    noise_of_power, noise = sum(found.noise[1:ENERGY_ROWS]), found.noise[ENERGY_ROWS:]
    integrals = []
    alike = vanishes(found.between_times, EPS * largest(energy))
    if alike and vanishes(
        sum(power, start=np.zeros(())), noise_of_power + EPS * np.max([largest(term) for term in power], axis=0)
    ):
        integrals.append(Integral("energy", "H", "H = T + U", system.energy, is_energy=True))
    sizes = np.max([largest(rate) for rate in torque], axis=0)
    for i in range(3):
        spread = sum(noise[i::3]) + EPS * sizes
        if vanishes(sum(torque[i::3], start=np.zeros(())), spread):
            meaning = f"the total angular momentum along the axis {i + 1} in space"
            value = functools.partial(component_of, "space", np.eye(3)[i])
            integrals.append(Integral(f"angular_momentum_space_{i + 1}", f"G{i + 1}", meaning, value))
    return tuple(integrals)


ENERGY_ROWS = 4
"""Number of rows before the rows of the torque: the energy, and three terms of its rate."""


def _samples(system: PairDynamics, count: int) -> dict[str, Array]:
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
    return {name: shaken(x, random) for name, x in {"first": q, "time": time, "omega": omega, **more}.items()}


def _traced(system: PairDynamics, graph: Graph, count: int) -> TracedRates:
    """Return the energy, the terms of its rate, and the terms of the torque about the barycentre, space axes.

    The rate of the energy has an explicit term, and terms of forces and of torques without a potential.
    """
    given, twin = _samples(system, count), system.broadcast_to((*system.members, count))
    pair, pace = twin.body, np.asarray(mean_motion(system.body, system.sample_distance))[..., None]

    def variables(values: Iterable[Scalar]) -> Vector:
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
    still = [Attitude.from_quaternion(Vector(given[name].T)) for name in ("first", "second")]
    place = [x.value for x in position]  # a condition on attitudes and position alone switches nothing

    def energy_at(moment: Scalar) -> Scalar:
        return twin.potential_at(PairInstant(pair, still, place, Environment(moment)))

    return TracedRates([energy, explicit, pushing, twisting, *terms], energy_at, time, np.roll(given["time"], 1))
