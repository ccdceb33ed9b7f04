"""What a motion conserves, found from the formulas themselves.

An integral belongs to a symmetry (Noether). Each candidate symmetry is tried on the system's own formulas at
fixed sample states, so that a user's potential is served as well as the package's: invariance in time gives
the energy; in a turning frame, the Jacobi integral; about a space axis, that component of the angular
momentum; about a symmetry axis of the body, that component in body axes.
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
from poinsot.mechanics.attitude import Attitude, rotation_matrix
from poinsot.mechanics.force import Torque
from poinsot.mechanics.frame import RotatingFrame
from poinsot.mechanics.samples import SAME, orbits_of, samples, time_scale
from poinsot.mechanics.sky import Sky

if TYPE_CHECKING:
    from poinsot.mechanics.state import State
    from poinsot.mechanics.system import System

__all__ = ["Integral", "integrals_of"]

Array = NDArray[np.float64]

REST = np.zeros(3)


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
    return (*_energies(system), *_space_components(system), *_body_components(system))


def _energies(system: System) -> Iterator[Integral]:
    if any(isinstance(force, Torque) for force in system.forces):
        return
    if _invariant(system, later=1.0):
        yield Integral("energy", "H", "H = T + U", system.energy, is_energy=True)
        return
    for orbit in orbits_of(system):
        rate = orbit.uniform_rotation
        if rate is not None and rate.ndim == 1 and _invariant(system, later=1.0, about_space=rate):
            yield Integral(
                "jacobi_energy",
                "H-n.G",
                "H - n . G on a circular orbit",
                functools.partial(_jacobi, system, rate),
                is_energy=True,
            )
            return


def _space_components(system: System) -> Iterator[Integral]:
    for name, axis in _space_axes(system):
        if _invariant(system, about_space=axis) and not _pushed(system, axis, "space"):
            value = functools.partial(_component, "space", axis)
            yield Integral(f"angular_momentum_space_{name}", f"G{name}", f"G along the axis {name} in space", value)


def _body_components(system: System) -> Iterator[Integral]:
    for k, axis in enumerate(np.eye(3)):
        if _symmetric(system, axis) and _invariant(system, about_body=axis) and not _pushed(system, axis, "body"):
            value = functools.partial(_component, "body", axis)
            yield Integral(f"angular_momentum_body_{k + 1}", f"g{k + 1}", "g along the body's symmetry axis", value)


def _jacobi(system: System, rate: Array, state: State) -> Any:
    return system.energy(state) - state.angular_momentum_space @ rate


def _component(axes: str, axis: Array, state: State) -> Any:
    return getattr(state, f"angular_momentum_{axes}") @ axis


def _symmetric(system: System, axis: Array) -> bool:
    """Whether the inertia tensor is unchanged by turning the body about an axis."""
    turn, inertia = rotation_matrix(_turn(axis, 1.0)), system.body.inertia
    return np.allclose(turn @ inertia @ turn.T, inertia, rtol=0, atol=1e-15 * float(np.max(inertia)))


def _invariant(system: System, later: float = 0.0, about_space: Array = REST, about_body: Array = REST) -> bool:
    """Whether the potential energy is unchanged when time passes and the body turns at constant rates."""
    q, t, _ = samples(system)
    before = _potential(system, q, t)
    largest = np.max(np.abs(before), axis=-1, keepdims=True)
    slack = SAME * np.ptp(before, axis=-1, keepdims=True) + 8 * np.finfo(float).eps * largest

    def after(step: float) -> Array:
        turned = quat.product(quat.product(_turn(about_space, step), q), _turn(about_body, step))
        return _potential(system, turned, t + later * step)

    return all(bool(np.all(np.abs(after(step * time_scale(system)) - before) <= slack)) for step in (0.7, 1.9))


def _pushed(system: System, axis: Array, axes: str) -> bool:
    """Whether a torque without potential has a component along an axis of the body or of space."""
    q, t, omega = samples(system)
    twin = system.beside_samples
    attitude = Attitude.from_quaternion(functions.Vector(q.T))
    for force in twin.forces:
        if isinstance(force, Torque):
            torque = functions.Vector(force.torque(twin.body, attitude, functions.Vector(omega.T), Sky(t)))
            size = np.max(np.abs(np.broadcast_arrays(*torque)))
            along = functions.dot(attitude.to_space(torque) if axes == "space" else torque, axis)
            if np.max(np.abs(along)) > SAME * size:
                return True
    return False


def _potential(system: System, q: Array, t: Array) -> Array:
    potential = system.beside_samples.potential_at(functions.Vector(q.T), t)
    return np.asarray(potential + np.zeros_like(t))


def _turn(rate: Array, step: float) -> Array:
    return RotatingFrame([1.0, 0, 0, 0], rate).quaternion(step)


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
