"""Integrals of the motion of one body with parts.

Candidates are the energy, the Jacobi integral of a circular orbit, the angular momentum along the space axes and along
directions that orbits define, its size, its size together with the momentum of a rotor, the angular momentum along the
symmetry axes of the body, and the angular momenta of parts.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.state import State
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import Part
from poinsot.quantities import Array
from poinsot.systems.body_dynamics import BodyDynamics
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
from poinsot.systems.probing import samples, time_scale
from poinsot.taylor.graph import Graph, tangents

__all__ = ["integrals_of_body"]

ENERGY_RATE_TOLERANCE = 1e-11
"""Rate of the energy that counts as zero, relative to the changes of the energy in a unit of time."""


def integrals_of_body(system: BodyDynamics) -> tuple[Integral, ...]:
    """Return the integrals of a system of one body."""
    rates = _Rates(system)
    components = tuple(_space_components(system, rates))
    sizes = () if len(components) >= 3 else _sizes(rates)
    return (
        *_energies(system, rates),
        *components,
        *sizes,
        *_body_components(system, rates),
        *_part_momenta(system, rates),
    )


def _energies(system: BodyDynamics, rates: _Rates) -> Iterator[Integral]:
    if not vanishes(rates.power, rates.power_noise):
        return
    if vanishes(rates.of_energy, rates.energy_noise) and vanishes(rates.between_times, rates.rounding):
        yield Integral("energy", "H", "H = T + U", system.energy, is_energy=True)
        return
    for orbit in system.orbits:
        turn = orbit.uniform_rotation
        if turn is None or turn.ndim > 1:
            continue
        noise = rates.energy_noise + np.linalg.norm(turn) * rates.torque_noise
        if vanishes(rates.of_energy - rates.along_space(turn), noise):
            value = functools.partial(_jacobi, system, turn)
            yield Integral("jacobi_energy", "H-n.G", "H - n . G on a circular orbit", value, is_energy=True)
            return


def _space_components(system: BodyDynamics, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _space_axes(system):
        if vanishes(rates.along_space(axis), rates.torque_noise):
            value = functools.partial(component_of, "space", axis)
            yield Integral(f"angular_momentum_space_{name}", f"G{name}", f"G along the axis {name} in space", value)


def _sizes(rates: _Rates) -> Iterator[Integral]:
    """Yield |G| if every torque is normal to it, or |g + h| if the torques are the torque h x omega of a rotor."""
    if vanishes(rates.along_momentum, rates.twist_noise):
        value = functools.partial(_size, np.zeros(3))
        yield Integral("angular_momentum_size", "|G|", "the size of the angular momentum", value)
    rotor, rest = rates.rotor
    if np.any(rotor) and vanishes(rest, rates.torque_noise):
        value = functools.partial(_size, rotor)
        meaning = "the size of the angular momentum with that of a rotor, h along the body axes"
        yield Integral("angular_momentum_size_with_rotor", "|g+h|", meaning, value)


def _body_components(system: BodyDynamics, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _body_axes(system):
        symmetric = system.parts or _symmetric(system, axis)
        if symmetric and vanishes(rates.along_body(axis), rates.gyration_noise):
            value = functools.partial(component_of, "body", axis)
            yield Integral(f"angular_momentum_body_{name}", f"g{name}", "g along the body's symmetry axis", value)


def _part_momenta(system: BodyDynamics, rates: _Rates) -> Iterator[Integral]:
    """Yield constant momenta of parts, such as the momentum of a wheel that turns freely."""
    for number, ((part, place), (rate, noise)) in enumerate(zip(_places(system), rates.of_momenta, strict=True), 1):
        if vanishes(rate, noise):
            name = f"angular_momentum_{part.name}" + f"_{place + 1}" * (part.size > 1)
            value = functools.partial(_part_momentum, part.name, place)
            yield Integral(name, f"p{number}", f"the angular momentum of {part.name}", value)


def _places(system: BodyDynamics) -> list[tuple[Part, int]]:
    """Return where the angular momenta of parts are among their variables."""
    found = ((part, place) for part in system.parts for place in part.momentum_places)
    return [(part, i) for part, place in found for i in range(place.start, place.stop)]


def _part_momentum(name: str, place: int, state: State) -> Array:
    return state.own[name][..., place]


def _jacobi(system: BodyDynamics, rate: Array, state: State) -> Array:
    return np.asarray(system.energy(state) - state.angular_momentum_space @ rate)


def _size(rotor: Array, state: State) -> Array:
    g = state.angular_momentum_body
    along = np.reshape(rotor, (*rotor.shape[:-1], *(1,) * (g.ndim - rotor.ndim), 3))
    return np.asarray(np.linalg.norm(g + along, axis=-1))


class _Rates:
    """Rates of change of energy and angular momentum at sample states, members first."""

    def __init__(self, system: BodyDynamics) -> None:
        found = SampledRates(system, functools.partial(_traced, system))
        self.omega, noise = np.concatenate([samples(system, count)[2] for count in found.counts]).T, found.noise
        (energy, self.of_energy, self.power, self.along_momentum), rest = found.rows[:4], found.rows[4:]
        self.between_times = found.between_times
        self._in_body, self._in_space, self._gyration = (np.stack(rest[i : i + 3]) for i in (0, 3, 6))
        self.torque_noise = np.maximum.reduce(noise[4:10]) + EPS * np.max(np.abs(self._in_body), axis=(0, -1))
        self.gyration_noise = self.torque_noise + np.maximum.reduce(noise[10:13])
        self.of_momenta = list(zip(rest[9:], noise[13:], strict=True))
        self.power_noise = self.gyration_noise * np.max(np.linalg.norm(self.omega, axis=0))
        self.twist_noise = self.power_noise * np.max(system.body.moments, axis=-1)
        self.energy_noise = noise[1] + ENERGY_RATE_TOLERANCE * np.ptp(energy, axis=-1) / time_scale(system)
        self.rounding = EPS * largest(energy)

    def along_space(self, axis: Array) -> Array:
        return np.asarray(functions.dot(self._in_space, axis))

    def along_body(self, axis: Array) -> Array:
        return np.asarray(functions.dot(self._in_body + self._gyration, axis))

    @cached_property
    def rotor(self) -> tuple[Array, Array]:
        """The h, shape (..., 3), for which h x omega is nearest to the torque, and the differences."""
        w = self.omega.T
        normal = np.einsum("nk,nk->", w, w) * np.eye(3) - w.T @ w
        torque = np.moveaxis(self._in_body, 0, -1)
        h = np.einsum("ij,...j->...i", np.linalg.inv(normal), np.sum(np.cross(w, torque), axis=-2))
        return h, np.linalg.norm(torque - np.cross(h[..., None, :], w), axis=-1)


def _traced(system: BodyDynamics, graph: Graph, count: int) -> TracedRates:
    """Return the energy, its explicit rate, power and g . torque of torques, torques, gyration, rates of momenta.

    The power includes the forces without a potential only. The torque is along the body axes, then the space axes.
    """
    random = np.random.default_rng(1)
    q, t, omega = (shaken(values, random) for values in samples(system, count))
    twin = system.broadcast_to((*system.members, len(t)))
    time, rate = graph.variable(t), Vector(omega.T)
    body = twin.body_at({part.name: _own_samples(part, t, rate) for part in twin.parts}, t)

    attitude, spin = Vector(q.T), rate
    if not twin.parts:  # conditions on what varies are found; of parts the rate of the energy needs values
        attitude, spin = (Vector(map(graph.variable, vector)) for vector in (attitude, rate))
    now = Instant(body, Attitude.from_quaternion(attitude), Environment(time), spin)
    energy, torque, g = twin.potential_at(now), twin.torque_at(now), now.angular_momentum_body
    (explicit,) = tangents([energy], {time: 1.0})
    power = sum(functions.dot(force.torque(now), spin) for force in twin.forces if isinstance(force, Torque))
    gyration, momenta = Vector((0.0, 0.0, 0.0)), []  # without parts symmetry is a matter of the tensor
    if twin.parts:
        rates = twin.rates(now)
        power = _change_of_energy(twin, now, rates) - explicit
        gyration, momenta = functions.cross(g, rate), [rates[part.name][i] for part, i in _places(twin)]
    along = power, functions.dot(g, torque), *torque, *now.attitude.to_space(torque), *gyration, *momenta
    still = Attitude.from_quaternion(Vector(q.T))  # a condition on the attitude alone switches nothing

    def energy_at(moment: Scalar) -> Scalar:
        return twin.potential_at(Instant(body, still, Environment(moment), rate))

    return TracedRates([energy, explicit, *along], energy_at, time, np.roll(t, 1))


def _own_samples(part: Part, time: Array, omega: Vector) -> Vector:
    """Return reproducible variables of a part near its variables at rest."""
    random = np.random.default_rng(20061027)
    return Vector(x + x * random.normal() + 0.1 * random.normal() for x in part.start(time, omega))


def _change_of_energy(system: BodyDynamics, instant: Instant, rates: Mapping[str, Vector]) -> Scalar:
    """Return the rate of T + U along the equations of motion, including the equations of the parts."""
    time: Any = instant.time
    seeds = {time: 1.0}

    def moving(values: Iterable[Scalar], name: str) -> Vector:
        variables = Vector(map(time.graph.variable, values))
        seeds.update(zip(variables, rates[name], strict=True))
        return variables

    own = {part.name: moving(instant.own(part), part.name) for part in system.parts if part.size}
    body, q = system.body_at(own, time), moving(instant.attitude.quaternion, "quaternion")
    potential = system.potential_at(Instant(body, Attitude.from_quaternion(q), instant.environment))
    kinetic = body.kinetic_energy(moving(instant.angular_momentum_body, "angular_momentum_body"))
    rate: Scalar = tangents([kinetic + potential], seeds)[0]
    return rate


def _symmetric(system: BodyDynamics, axis: Array) -> bool:
    """Return True if the inertia tensor is isotropic in the plane across an axis."""
    inertia = system.body.inertia
    across = np.eye(3) - np.outer(axis, axis)
    moment = np.trace(across @ inertia, axis1=-2, axis2=-1)[..., None, None] / 2
    along = np.einsum("i,...ij,j->...", axis, inertia, axis)[..., None, None]
    alike = moment * across + along * np.outer(axis, axis)
    return np.allclose(alike, inertia, rtol=0, atol=4e-15 * float(np.max(inertia)))


def _space_axes(system: BodyDynamics) -> Iterator[tuple[str, Array]]:
    """Yield the coordinate axes, and the directions that the orbits at hand single out."""
    axes = [(str(i + 1), np.eye(3)[i]) for i in range(3)]
    for orbit in system.orbits:
        for label, vector in orbit.directions.items():
            if vector.ndim > 1:  # each member has its own
                continue
            unit = vector / np.linalg.norm(vector)
            if all(abs(unit @ other) < 1 - 1e-12 for _, other in axes):
                axes.append((label, unit))
    yield from axes


def _body_axes(system: BodyDynamics) -> Iterator[tuple[str, Array]]:
    """Yield the given axes, or the principal axes of a body for which those are others."""
    principal = system.body.principal_axes.as_matrix()
    if principal.ndim > 2:  # each member has its own
        return
    given = quat.norm(principal - np.eye(3)).max() < 1e-15
    for i in range(3):
        yield (str(i + 1) if given else f"principal_{i + 1}"), principal[:, i]
