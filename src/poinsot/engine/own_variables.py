"""The variables of parts behind those of a formulation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.engine.formulations import Formulation
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.part import Part
from poinsot.mechanics.state import Phase, State
from poinsot.mechanics.system import System

__all__ = ["WithParts", "formulation_with_parts"]


class WithParts(Formulation):
    """A formulation with the variables of parts: first those that scale as the angular momentum does.

    Parameters
    ----------
    rigid : Formulation
        Of attitude and angular momentum.
    parts : sequence of Part
    sizes : mapping
        How large each scalar of a part is, by the name of the part; the size of momenta is not asked.
    """

    def __init__(self, rigid: Formulation, parts: list[Part], sizes: Mapping[str, NDArray[np.float64]]) -> None:
        self.rigid, self.name, self.turns = rigid, rigid.name, rigid.turns
        flags = [(part.name, i, i in _momenta(part)) for part in parts for i in range(part.size)]
        flags.sort(key=lambda flag: not flag[2])
        places = {(name, i): rigid.size + place for place, (name, i, _) in enumerate(flags)}
        self._places = {part.name: [places[part.name, i] for i in range(part.size)] for part in parts}
        self.own_places = tuple(place for own in self._places.values() for place in own)
        self.tangent = (*rigid.tangent, *range(6, 6 + len(flags))) if rigid.tangent else ()
        self._momenta = sum(flag for _, _, flag in flags)
        self._order = [(name, i) for name, i, _ in flags]
        self._factors = {
            part.name: [None if i in _momenta(part) else _power(sizes[part.name][i]) for i in range(part.size)]
            for part in parts
        }
        self.blocks = {**rigid.blocks, **{name: len(own) for name, own in self._places.items()}}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, WithParts) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[Any, ...]:
        return self.rigid, *((name, *factors) for name, factors in self._factors.items())

    @property
    @override
    def tangent_factors(self) -> tuple[float | None, ...]:
        return *self.rigid.tangent_factors, *(factor for own in self._factors.values() for factor in own)

    @property
    @override
    def momenta(self) -> slice:
        return slice(self.rigid.momenta.start, self.rigid.size + self._momenta)

    @property
    @override
    def quaternions(self) -> list[slice]:
        return self.rigid.quaternions

    @override
    def check_variables(self, variables: NDArray[np.float64]) -> None:
        self.rigid.check_variables(variables[..., : self.rigid.size])

    @override
    def own(self, variables: Any, scale: Scalar) -> dict[str, Vector]:
        return {
            name: Vector(
                variables[place] * (1 / (scale if factor is None else factor))
                for place, factor in zip(places, self._factors[name], strict=True)
            )
            for name, places in self._places.items()
        }

    @override
    def own_rates(self, rates: Mapping[str, Vector], scale: Scalar) -> list[Scalar]:
        factors = (self._factors[name][i] for name, i in self._order)
        return [
            rates[name][i] * (scale if factor is None else factor)
            for (name, i), factor in zip(self._order, factors, strict=True)
        ]

    @override
    def nearness(self, variables: Any) -> Scalar | None:
        return self.rigid.nearness(variables)

    @override
    def physical(self, variables: Any) -> tuple[Attitude, Vector]:
        return self.rigid.physical(variables[: self.rigid.size])

    @override
    def rates(
        self, variables: Any, omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        return self.rigid.rates(variables[: self.rigid.size], omega, g_rate, torque, turning)

    @override
    def from_state(self, state: State) -> NDArray[np.float64]:
        rigid, own = self.rigid.from_state(state), state.own
        for name, places in self._places.items():
            if np.shape(own.get(name, ()))[-1] != len(places):
                raise ValueError(
                    f"state must have the {len(places)} variables of the part {name!r}, got {sorted(own) or 'none'}. "
                    "Make it by system.state(...)."
                )
        columns = [np.asarray(own[name])[..., i] * (self._factors[name][i] or 1.0) for name, i in self._order]
        return np.concatenate([rigid, np.stack(columns, axis=-1).astype(rigid.dtype)], axis=-1)

    @override
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        own = {
            name: np.stack(
                [
                    variables[..., place] / (factor or 1.0)
                    for place, factor in zip(places, self._factors[name], strict=True)
                ],
                axis=-1,
            )
            for name, places in self._places.items()
        }
        return {**self.rigid.to_phase(variables[..., : self.rigid.size]), **own}


def formulation_with_parts(rigid: Formulation, system: System, state: State) -> Formulation:
    """Return a formulation with the variables of the parts of a system, scaled for the motion from a state."""
    parts = [part for part in system.moving_parts if part.size]
    if not parts:
        return rigid
    twin = system.beside(state.quaternion.shape[:-1])
    with np.errstate(all="ignore"):
        rates = twin.own_rates(twin.at(state))
        fastest = float(np.max(np.linalg.norm(system.omega_body(state), axis=-1)))
    sizes = {}
    for part in parts:
        changes = np.stack(np.broadcast_arrays(*rates[part.name]), axis=-1) / (fastest or 1.0)
        both = np.maximum(np.abs(state.own[part.name]), np.abs(changes))
        sizes[part.name] = np.max(both.reshape(-1, part.size), axis=0)
    return WithParts(rigid, parts, sizes)


def _momenta(part: Part) -> set[int]:
    return {i for place in part.momentum_places for i in range(place.start, place.stop)}


def _power(size: float) -> float:
    """Return the power of two that brings a size near a tenth, without rounding; 1 for a size of zero."""
    return float(np.exp2(np.round(np.log2(0.1 / size)))) if 0 < size < np.inf else 1.0
