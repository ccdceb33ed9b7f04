"""What a motion conserves, found from the formulas themselves.

A quantity is an integral if its time derivative, taken with the system's own torques and energies, vanishes
at sample states, to the rounding of that derivative; so a user's forces are served as well as the package's. Tried are
the energy, the Jacobi integral of a circular orbit, the angular momentum along the axes of space and those that orbits
single out, its size, also with that of a rotor, that along the symmetry axes of the body, and those of parts.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.immutable import Immutable
from poinsot.lazy import cached_property
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.branch_exploration import BRANCHES, conditions, on_branches
from poinsot.mechanics.dynamics import Dynamics
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.probing import samples, time_scale
from poinsot.taylor.graph import Graph, tangents

if TYPE_CHECKING:
    from poinsot.mechanics.part import Part
    from poinsot.mechanics.state import State

__all__ = ["EPS", "ROUNDINGS", "SAME", "Integral", "component_of", "integrals_of"]

Array = NDArray[np.float64]

SAME = 1e-11
"""What counts as zero of a rate of the energy, relative to the changes of the energy."""

EPS = np.finfo(float).eps
ROUNDINGS = 64
"""How many roundings of a rate count as zero."""


@dataclasses.dataclass(frozen=True)
class Integral(Immutable):
    """A conserved quantity.

    Attributes
    ----------
    name : str
        `energy`, `jacobi_energy`, `angular_momentum_space_3`, `angular_momentum_body_3`, ...
    symbol : str
        `H`, `H-n.G`, `G3`, `g3`, ...
    meaning : str
        One line for people.
    value : callable
        State -> its value, shape (...).
    is_energy : bool
        Whether its drift is measured against |T| + |U|, or against |g|.
    """

    name: str
    symbol: str
    meaning: str
    value: Callable[[State], Any]
    is_energy: bool = False


def integrals_of(system: Dynamics) -> tuple[Integral, ...]:
    """Return the integrals of a system."""
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


def _energies(system: Dynamics, rates: _Rates) -> Iterator[Integral]:
    if not rates.vanish(rates.power, rates.power_noise):
        return
    if rates.vanish(rates.of_energy, rates.energy_noise) and rates.vanish(rates.between_times, rates.rounding):
        yield Integral("energy", "H", "H = T + U", system.energy, is_energy=True)
        return
    for orbit in system.orbits:
        turn = orbit.uniform_rotation
        if turn is None or turn.ndim > 1:
            continue
        noise = rates.energy_noise + np.linalg.norm(turn) * rates.torque_noise
        if rates.vanish(rates.of_energy - rates.along_space(turn), noise):
            value = functools.partial(_jacobi, system, turn)
            yield Integral("jacobi_energy", "H-n.G", "H - n . G on a circular orbit", value, is_energy=True)
            return


def _space_components(system: Dynamics, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _space_axes(system):
        if rates.vanish(rates.along_space(axis), rates.torque_noise):
            value = functools.partial(component_of, "space", axis)
            yield Integral(f"angular_momentum_space_{name}", f"G{name}", f"G along the axis {name} in space", value)


def _sizes(rates: _Rates) -> Iterator[Integral]:
    """Yield |G| where every torque is normal to it, and |g + h| where they are those of a rotor, h x omega."""
    if rates.vanish(rates.along_momentum, rates.twist_noise):
        value = functools.partial(_size, np.zeros(3))
        yield Integral("angular_momentum_size", "|G|", "the size of the angular momentum", value)
    rotor, rest = rates.rotor
    if np.any(rotor) and rates.vanish(rest, rates.torque_noise):
        value = functools.partial(_size, rotor)
        meaning = "the size of the angular momentum with that of a rotor, h along the body axes"
        yield Integral("angular_momentum_size_with_rotor", "|g+h|", meaning, value)


def _body_components(system: Dynamics, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _body_axes(system):
        symmetric = system.parts or _symmetric(system, axis)
        if symmetric and rates.vanish(rates.along_body(axis), rates.gyration_noise):
            value = functools.partial(component_of, "body", axis)
            yield Integral(f"angular_momentum_body_{name}", f"g{name}", "g along the body's symmetry axis", value)


def _part_momenta(system: Dynamics, rates: _Rates) -> Iterator[Integral]:
    """Yield momenta of parts that nothing changes, such as that of a wheel that turns freely."""
    for number, ((part, place), (rate, noise)) in enumerate(zip(_places(system), rates.of_momenta, strict=True), 1):
        if rates.vanish(rate, noise):
            name = f"angular_momentum_{part.name}" + f"_{place + 1}" * (part.size > 1)
            value = functools.partial(_part_momentum, part.name, place)
            yield Integral(name, f"p{number}", f"the angular momentum of {part.name}", value)


def _places(system: Dynamics) -> list[tuple[Part, int]]:
    """Return where the angular momenta of parts are among their variables."""
    found = ((part, place) for part in system.parts for place in part.momentum_places)
    return [(part, i) for part, place in found for i in range(place.start, place.stop)]


def _part_momentum(name: str, place: int, state: State) -> Any:
    return state.own[name][..., place]


def _jacobi(system: Dynamics, rate: Array, state: State) -> Any:
    return system.energy(state) - state.angular_momentum_space @ rate


def _size(rotor: Array, state: State) -> Any:
    g = state.angular_momentum_body
    return np.linalg.norm(g + np.reshape(rotor, (*rotor.shape[:-1], *(1,) * (g.ndim - rotor.ndim), 3)), axis=-1)


def component_of(axes: str, axis: Array, state: State) -> Any:
    """Return the angular momentum of a state along an axis in body or space."""
    return getattr(state, f"angular_momentum_{axes}") @ axis


class _Rates:
    """The rates of change of energy and angular momentum at sample states, members first."""

    def __init__(self, system: Dynamics) -> None:
        rows, branching = _rates_at(system, samples(system))
        if branching:
            others, _ = _rates_at(system, samples(system, BRANCHES), forced=True)
            rows = [np.concatenate(pair, axis=-1) for pair in zip(rows, others, strict=True)]
        plain, shaken = ([row[..., half, :] for row in rows] for half in (0, 1))
        self.omega, energy, self.of_energy, self.between_times, self.power, self.along_momentum = plain[:6]
        self._in_body, self._in_space, self._gyration = (np.stack(plain[i : i + 3]) for i in (6, 9, 12))
        moved = [_largest(other - value) for value, other in zip(plain, shaken, strict=True)]
        self.torque_noise = np.maximum.reduce(moved[6:12]) + EPS * np.max(np.abs(self._in_body), axis=(0, -1))
        self.gyration_noise = self.torque_noise + np.maximum.reduce(moved[12:15])
        self.of_momenta = list(zip(plain[15:], moved[15:], strict=True))
        self.power_noise = self.gyration_noise * np.max(np.linalg.norm(self.omega, axis=0))
        self.twist_noise = self.power_noise * np.max(system.body.moments, axis=-1)
        self.energy_noise = moved[2] + SAME * np.ptp(energy, axis=-1) / time_scale(system)
        self.rounding = EPS * _largest(energy)

    def along_space(self, axis: Array) -> Any:
        return functions.dot(self._in_space, axis)

    def along_body(self, axis: Array) -> Any:
        return functions.dot(self._in_body + self._gyration, axis)

    @cached_property
    def rotor(self) -> tuple[Array, Array]:
        """The h, shape (..., 3), for which h x omega is nearest to the torque, and the differences."""
        w = self.omega.T
        normal = np.einsum("nk,nk->", w, w) * np.eye(3) - w.T @ w
        torque = np.moveaxis(self._in_body, 0, -1)
        h = np.einsum("ij,...j->...i", np.linalg.inv(normal), np.sum(np.cross(w, torque), axis=-2))
        return h, np.linalg.norm(torque - np.cross(h[..., None, :], w), axis=-1)

    def vanish(self, rate: Any, noise: Any) -> bool:
        """Return whether a rate is zero at all samples, but for its rounding."""
        return bool(np.all(_largest(rate) <= ROUNDINGS * noise))


def _largest(values: Any) -> Any:
    """Return the largest size over the samples, the last axis."""
    return np.max(np.abs(values), axis=-1)


def _rates_at(system: Dynamics, sampled: tuple[Array, Array, Array], forced: bool = False) -> tuple[list[Array], bool]:
    """Return rates at samples and at neighbours a rounding away, (..., 2, n), and whether formulas have conditions.

    Omega, energy, its rate, its change to another time, power and g . torque of torques, and torque, members first. The
    power is that of the forces without a potential; the torque is along the body axes, then along the space axes.
    Forced conditions go every way, and the change of the energy is that to the other branches.
    """
    random = np.random.default_rng(1)
    shaken = (values * (1 + EPS * random.uniform(-2, 2, values.shape)) for values in sampled)
    q, t, omega = (np.concatenate(pair) for pair in zip(sampled, shaken, strict=True))
    graph, twin = Graph(), system.beside((*system.members, len(t)))
    time, rate = graph.variable(t), functions.Vector(omega.T)
    body = twin.body_at({part.name: _own_samples(part, t, rate) for part in twin.parts}, t)

    attitude, spin = functions.Vector(q.T), rate
    if not twin.parts:  # conditions on what varies are found; of parts the rate of the energy needs values
        attitude, spin = (functions.Vector(map(graph.variable, vector)) for vector in (attitude, rate))
    now = Instant(body, Attitude.from_quaternion(attitude), Environment(time), spin)
    energy, torque, g = twin.potential_at(now), twin.torque_at(now), now.angular_momentum_body
    (explicit,) = tangents([energy], {time: 1.0})
    power = sum(functions.dot(force.torque(now), spin) for force in twin.forces if isinstance(force, Torque))
    gyration, momenta = functions.Vector((0.0, 0.0, 0.0)), []  # without parts symmetry is a matter of the tensor
    if twin.parts:
        rates = twin.rates(now)
        power = _change_of_energy(twin, now, rates) - explicit
        gyration, momenta = functions.cross(g, rate), [rates[part.name][i] for part, i in _places(twin)]
    along = power, functions.dot(g, torque), *torque, *now.attitude.to_space(torque), *gyration, *momenta
    rows = [energy, explicit, *along]
    still = Attitude.from_quaternion(functions.Vector(q.T))  # a condition on the attitude alone switches nothing
    timed = twin.potential_at(Instant(body, still, Environment(time), rate))
    if forced:
        here, there = (on_branches(graph, [timed], len(t), other)[0] for other in (False, True))
        rows = on_branches(graph, rows, len(t))
    else:
        here, there = timed, twin.potential_at(Instant(body, still, Environment(np.roll(t, 1)), rate))
        here, there, *rows = graph.evaluated([here, there, *rows])
    rows = [omega.T, *rows[:2], here - there, *rows[2:]]
    shapes = [(3,), *[system.members] * (len(rows) - 1)]
    found = [
        np.broadcast_to(np.asarray(row, dtype=float), (*shape, len(t))) for shape, row in zip(shapes, rows, strict=True)
    ]
    return [row.reshape(*row.shape[:-1], 2, -1) for row in found], bool(conditions([energy, explicit, *along]))


def _own_samples(part: Part, time: Any, omega: functions.Vector) -> functions.Vector:
    """Return variables of a part about those of rest, always the same ones."""
    random = np.random.default_rng(20061027)
    return functions.Vector(x + x * random.normal() + 0.1 * random.normal() for x in part.start(time, omega))


def _change_of_energy(system: Dynamics, instant: Instant, rates: Mapping[str, functions.Vector]) -> Any:
    """Return the rate of T + U along the equations of motion, those of the parts included."""
    time, seeds = instant.time, {instant.time: 1.0}

    def moving(values: Any, name: str) -> functions.Vector:
        variables = functions.Vector(map(time.graph.variable, values))
        seeds.update(zip(variables, rates[name], strict=True))
        return variables

    own = {part.name: moving(instant.own(part), part.name) for part in system.parts if part.size}
    body, q = system.body_at(own, time), moving(instant.attitude.quaternion, "quaternion")
    potential = system.potential_at(Instant(body, Attitude.from_quaternion(q), instant.environment))
    kinetic = body.kinetic_energy(moving(instant.angular_momentum_body, "angular_momentum_body"))
    return tangents([kinetic + potential], seeds)[0]


def _symmetric(system: Dynamics, axis: Array) -> bool:
    """Whether the inertia tensor is a multiple of one across an axis."""
    inertia = system.body.inertia
    across = np.eye(3) - np.outer(axis, axis)
    moment = np.trace(across @ inertia, axis1=-2, axis2=-1)[..., None, None] / 2
    along = np.einsum("i,...ij,j->...", axis, inertia, axis)[..., None, None]
    alike = moment * across + along * np.outer(axis, axis)
    return np.allclose(alike, inertia, rtol=0, atol=4e-15 * float(np.max(inertia)))


def _space_axes(system: Dynamics) -> Iterator[tuple[str, Array]]:
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


def _body_axes(system: Dynamics) -> Iterator[tuple[str, Array]]:
    """Yield the given axes, or the principal axes of a body for which those are others."""
    principal = system.body.principal_axes.as_matrix()
    if principal.ndim > 2:  # each member has its own
        return
    given = quat.norm(principal - np.eye(3)).max() < 1e-15
    for i in range(3):
        yield (str(i + 1) if given else f"principal_{i + 1}"), principal[:, i]
