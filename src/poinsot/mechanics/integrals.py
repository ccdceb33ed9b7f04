"""What a motion conserves, found from the formulas themselves.

A quantity is an integral if its time derivative, taken with the system's own torques and energies, vanishes
at sample states; so a user's forces are served as well as the package's. Tried are the energy, the Jacobi
integral of a circular orbit, the angular momentum along the axes of space and those that orbits single out,
and along the symmetry axes of the body.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.dual import partial, seeded
from poinsot.mechanics.force import Torque
from poinsot.mechanics.samples import orbits_of, samples, time_scale
from poinsot.mechanics.sky import Sky
from poinsot.mechanics.wrapped import BRANCHES, ExploredSky, opened

if TYPE_CHECKING:
    from poinsot.mechanics.state import State
    from poinsot.mechanics.system import System

__all__ = ["Integral", "integrals_of"]

Array = NDArray[np.float64]

SAME = 1e-11
"""What counts as zero, relative to the largest value of the same kind."""

ROUNDING = 64 * np.finfo(float).eps


@dataclasses.dataclass(frozen=True)
class Integral:
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


def integrals_of(system: System) -> tuple[Integral, ...]:
    """Return the integrals of a system."""
    rates = _Rates(system)
    return (*_energies(system, rates), *_space_components(system, rates), *_body_components(system, rates))


def _energies(system: System, rates: _Rates) -> Iterator[Integral]:
    if any(isinstance(force, Torque) for force in system.forces):
        return
    if rates.vanish(rates.of_energy) and rates.vanish(rates.between_times):
        yield Integral("energy", "H", "H = T + U", system.energy, is_energy=True)
        return
    for orbit in orbits_of(system):
        turn = orbit.uniform_rotation
        if turn is not None and turn.ndim == 1 and rates.vanish(rates.of_energy - rates.along_space(turn)):
            value = functools.partial(_jacobi, system, turn)
            yield Integral("jacobi_energy", "H-n.G", "H - n . G on a circular orbit", value, is_energy=True)
            return


def _space_components(system: System, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _space_axes(system):
        if rates.vanish(rates.along_space(axis), rates.torque_size):
            value = functools.partial(_component, "space", axis)
            yield Integral(f"angular_momentum_space_{name}", f"G{name}", f"G along the axis {name} in space", value)


def _body_components(system: System, rates: _Rates) -> Iterator[Integral]:
    for name, axis in _body_axes(system):
        if _symmetric(system, axis) and rates.vanish(rates.along_body(axis), rates.torque_size):
            value = functools.partial(_component, "body", axis)
            yield Integral(f"angular_momentum_body_{name}", f"g{name}", "g along the body's symmetry axis", value)


def _jacobi(system: System, rate: Array, state: State) -> Any:
    return system.energy(state) - state.angular_momentum_space @ rate


def _component(axes: str, axis: Array, state: State) -> Any:
    return getattr(state, f"angular_momentum_{axes}") @ axis


class _Rates:
    """The rates of change of energy and angular momentum at sample states, members first."""

    def __init__(self, system: System) -> None:
        parts = [_at_samples(system, samples(system), Sky, lambda t: Sky(np.roll(t, 1)))]
        skies: list[ExploredSky] = []

        def explored(time: Any, other: bool = False) -> Sky:
            skies.append(ExploredSky(time, other))
            return skies[-1]

        branches = _at_samples(system, samples(system, BRANCHES), explored, lambda t: explored(t, other=True))
        if any(sky.asked for sky in skies):
            parts.append(branches)
        energy, rate, between, *torques = (np.concatenate(values, axis=-1) for values in zip(*parts, strict=True))
        self.of_energy, self.between_times = rate, between
        self._in_body, self._in_space = torques[:3], torques[3:]
        self.torque_size = np.max(np.abs(torques[:3]), axis=(0, -1))
        self._energy_size = np.max(np.abs(energy), axis=-1)
        self._energy_rate = np.ptp(energy, axis=-1) / time_scale(system)
        self._rounding = ROUNDING * self._energy_size * max(1.0, 1 / time_scale(system))

    def along_space(self, axis: Array) -> Any:
        return functions.dot(self._in_space, axis)

    def along_body(self, axis: Array) -> Any:
        return functions.dot(self._in_body, axis)

    def vanish(self, rate: Any, size: Any = None) -> bool:
        """Return whether a rate is zero at all samples, against a size of its kind."""
        slack = SAME * (self._energy_rate if size is None else size) + self._rounding
        return bool(np.all(np.max(np.abs(np.atleast_1d(rate)), axis=-1) <= slack))


def _at_samples(
    system: System, sampled: tuple[Array, Array, Array], sky: Callable[[Any], Sky], another: Callable[[Array], Sky]
) -> list[Array]:
    """Return energy, its rate, its change to another sky, and the torque along body and space axes, members first."""
    q, t, omega = sampled
    twin = system.beside_samples
    attitude = Attitude.from_quaternion(functions.Vector(q.T))
    energy = twin.potential_at(functions.Vector(q.T), t, sky(seeded([t], "time")[0]))
    here, there = (opened(twin.potential_at(functions.Vector(q.T), t, world)) for world in (sky(t), another(t)))
    torque = [opened(x) for x in twin.torque_at(attitude, functions.Vector(omega.T), sky(t))]
    values = opened(getattr(energy, "value", energy)), opened(partial(energy, "time", 0)), here - there
    rows = (*values, *torque, *attitude.to_space(torque))
    return [np.broadcast_to(np.asarray(row, dtype=float), (*system.members, t.size)) for row in rows]


def _symmetric(system: System, axis: Array) -> bool:
    """Whether the inertia tensor is a multiple of one across an axis."""
    inertia = system.body.inertia
    across = np.eye(3) - np.outer(axis, axis)
    moment = np.trace(across @ inertia, axis1=-2, axis2=-1)[..., None, None] / 2
    along = np.einsum("i,...ij,j->...", axis, inertia, axis)[..., None, None]
    alike = moment * across + along * np.outer(axis, axis)
    return np.allclose(alike, inertia, rtol=0, atol=4e-15 * float(np.max(inertia)))


def _space_axes(system: System) -> Iterator[tuple[str, Array]]:
    """Yield the coordinate axes, and the directions that the orbits at hand single out."""
    axes = [(str(i + 1), np.eye(3)[i]) for i in range(3)]
    for orbit in orbits_of(system):
        for label, vector in orbit.directions.items():
            if vector.ndim > 1:  # each member has its own
                continue
            unit = vector / np.linalg.norm(vector)
            if all(abs(unit @ other) < 1 - 1e-12 for _, other in axes):
                axes.append((label, unit))
    yield from axes


def _body_axes(system: System) -> Iterator[tuple[str, Array]]:
    """Yield the given axes, or the principal axes of a body for which those are others."""
    principal = system.body.principal_axes.as_matrix()
    if principal.ndim > 2:  # each member has its own
        return
    given = quat.norm(principal - np.eye(3)).max() < 1e-15
    for i in range(3):
        yield (str(i + 1) if given else f"principal_{i + 1}"), principal[:, i]
