"""The state vector of a kernel: slots for attitude and momentum, parts, orbits integrated along and tangent vectors."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.integration.formulations import Formulation
from poinsot.integration.problem import Problem
from poinsot.integration.scaling import sizes_of_blocks
from poinsot.integration.tangent_vectors import Variations
from poinsot.integration.turned_rows import turn_rows
from poinsot.lazy import cached_property
from poinsot.mechanics.dynamics import AnyDynamics
from poinsot.mechanics.environment import Environment, OrbitBlock, Views, viewed
from poinsot.mechanics.members import expanded
from poinsot.mechanics.state import AnyState, Phase, named
from poinsot.taylor.rescaling import SMALL

__all__ = ["Slot", "StateVector", "blocks_of", "factors_of_parts"]

Array = NDArray[np.float64]

BLOCK = 8192
"""Rows converted together: their intermediate results stay in the processor's cache."""

EVERY = slice(None)

STRUCTURAL = ("structure", "along_orbits", "size", "charts", "momenta")
"""What the variables of all systems of one structure have in common."""

CHART, TANGENT = "attitude and momentum", "tangent vectors"
"""Names of slots that no part has."""

Factors = tuple[Any, ...]
"""What each variable of a slot is multiplied by, powers of two; None for the scale of the momenta."""


class Slot(NamedTuple):
    """Where variables with a name are, and what each is multiplied by: numbers, or arrays (members,)."""

    place: slice
    factors: Factors

    def physical(self, variables: Any, scale: Scalar) -> Vector:
        """Return the variables in physical units, scalars of any kind."""
        factors = zip(variables[self.place], self.factors, strict=True)
        return Vector(x * (1 / (scale if factor is None else factor)) for x, factor in factors)

    def scaled(self, values: Any, scale: Scalar) -> list[Scalar]:
        """Return values in physical units as the variables."""
        return [x * (scale if factor is None else factor) for x, factor in zip(values, self.factors, strict=True)]

    @property
    def momenta(self) -> list[int]:
        """Where the variables are that scale as the angular momentum does."""
        return [self.place.start + i for i, factor in enumerate(self.factors) if factor is None]


@dataclass(eq=False)
class StateVector:
    """The variables of a kernel.

    Parameters
    ----------
    formulation : Formulation
        The chart of attitude and momentum of each body.
    scale : float or array (members,)
        What the momenta are multiplied by.
    parts : mapping
        The factors of each part by its name.
    orbits : tuple of OrbitBlock
        What is integrated along of orbits.
    views : tuple
        For each orbit of the problem the number of the block that it views, or None.
    comoving : bool
        Whether the attitude refers to the comoving axes of the one block.
    variations : Variations, optional
        The tangent vectors.
    ratios : mapping
        What the momenta of each body are multiplied by beside the scale; 1 for the first.
    """

    formulation: Formulation
    scale: Any
    parts: Mapping[str, Factors]
    orbits: tuple[OrbitBlock, ...] = ()
    views: Views = ()
    comoving: bool = False
    variations: Variations | None = None
    ratios: Mapping[str, Any] = field(default_factory=lambda: {"": 1.0})

    def sharing(self, known: dict[Any, Any]) -> StateVector:
        """Return the variables with what another system of the structure has found of its own; `known` keeps it."""
        key = self.formulation, self.views, self.comoving, *[block.structure for block in self.orbits]
        if key not in known:
            known[key] = {name: getattr(self, name) for name in STRUCTURAL}
        vars(self).update(known[key])
        return self

    @cached_property
    def slots(self) -> dict[str, Slot]:
        """The slots by name, in the order of the variables."""
        chart, tangent = self.formulation, self.variations
        momenta = range(chart.size)[chart.momenta]
        of_chart = tuple(None if i in momenta else 1.0 for i in range(chart.size))
        factors: dict[str, Factors] = {_chart_of(body): of_chart for body in self.ratios}
        factors |= self.parts
        factors |= {f"orbits[{i}]": (1.0,) * block.size for i, block in enumerate(self.orbits)}
        if tangent:
            factors[TANGENT] = tuple(None if i in tangent.momenta else 1.0 for i in range(tangent.size))
        ends = itertools.accumulate(map(len, factors.values()))
        return {
            name: Slot(slice(end - len(own), end), own) for (name, own), end in zip(factors.items(), ends, strict=True)
        }

    @cached_property
    def size(self) -> int:
        """The number of variables."""
        along: int = self.along_orbits.stop
        return along + (self.variations.size if self.variations else 0)

    @property
    def sizes(self) -> dict[str, int]:
        """How many numbers each array of a phase has in a row."""
        chart = self.formulation.to_phase(np.full(self.formulation.size, np.nan))
        rigid = {named(body, name): row.size for body in self.ratios for name, row in chart.items()}
        return rigid | {name: len(own) for name, own in self.parts.items()}

    @cached_property
    def charts(self) -> list[slice]:
        """Where attitude and momentum of each body are."""
        size = self.formulation.size
        return [slice(i * size, (i + 1) * size) for i in range(len(self.ratios))]

    @property
    def attitude(self) -> list[int]:
        """Where the attitudes are."""
        count = next(iter(self.formulation.blocks.values()))
        return [own.start + k for own in self.charts for k in range(count)]

    @cached_property
    def along_orbits(self) -> slice:
        """Where the variables of orbits are."""
        first = len(self.ratios) * self.formulation.size + sum(map(len, self.parts.values()))
        return slice(first, first + sum([block.size for block in self.orbits]))

    @property
    def tangent_vectors(self) -> slice:
        """Where the tangent vectors are."""
        return slice(self.along_orbits.stop, None)

    @cached_property
    def momenta(self) -> slice | list[int]:
        """Where the momenta of the motion are."""
        if not self.parts:
            return self.formulation.momenta
        names = (*map(_chart_of, self.ratios), *self.parts)
        return [place for name in names for place in self.slots[name].momenta]

    @cached_property
    def conjugates(self) -> list[tuple[slice, slice]]:
        """Where q and Q of each body are, in a formulation of these."""
        if not self.formulation.conjugate:
            return []
        return [(slice(own.start, own.start + 4), slice(own.start + 4, own.stop)) for own in self.charts]

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations, without any real number of the system."""
        variations = self.variations and replace(self.variations, initial=None, sizes=())
        blocks = tuple([block.structure for block in self.orbits])
        parts = tuple([(name, *(factor is None for factor in own)) for name, own in self.parts.items()])
        return self.formulation, tuple(self.ratios), parts, blocks, self.views, self.comoving, variations

    @property
    def factors(self) -> tuple[Any, ...]:
        """The ratios of further bodies and the factors of parts that are numbers: parameters of a kernel."""
        _, *ratios = self.ratios.values()
        return *ratios, *[factor for own in self.parts.values() for factor in own if factor is not None]

    def with_factors(self, factors: Iterator[Any]) -> StateVector:
        """Return the same with other ratios and factors in place of the numbers, scalars of any kind."""
        ratios = {body: next(factors) if i else ratio for i, (body, ratio) in enumerate(self.ratios.items())}
        parts = {n: tuple(x if x is None else next(factors) for x in own) for n, own in self.parts.items()}
        return replace(self, parts=parts, ratios=ratios)

    def scales(self, scale: Scalar) -> list[Scalar]:
        """Return what the momenta of each body are multiplied by."""
        return [scale * ratio if i else scale for i, ratio in enumerate(self.ratios.values())]

    @property
    def of_one(self) -> bool:
        """Whether scales and orbits are the same for all members."""
        numbers = self.scale, *self.factors, *(number for block in self.orbits for number in block.numbers)
        return not any(map(np.ndim, numbers))

    @cached_property
    def scaled(self) -> list[int]:
        """Where all variables are that scale as the angular momentum does, of tangent vectors too."""
        return [place for slot in self.slots.values() for place in slot.momenta]

    @property
    def tangent_coordinates(self) -> list[int]:
        """Which of the tangent coordinates there are: of each body six, and those of parts."""
        rigid = [6 * i + place for i in range(len(self.ratios)) for place in self.formulation.tangent]
        own = sum(map(len, self.parts.values()))
        return rigid + list(range(6 * len(self.ratios), 6 * len(self.ratios) + own))

    @property
    def tangent_scales(self) -> tuple[bool, ...]:
        """Which of the tangent coordinates scale as momenta do."""
        rigid = (place >= 3 for _ in self.ratios for place in self.formulation.tangent)
        return *rigid, *(factor is None for own in self.parts.values() for factor in own)

    @property
    def tangent_units(self) -> Array:
        """What the variables multiply each tangent coordinate by; shape (k,) or (members, k)."""
        each = zip(self.ratios, self.scales(self.scale), strict=True)
        rigid = [own if place >= 3 else 1.0 for _, own in each for place in self.formulation.tangent]
        parts = [self.scale if x is None else x for own in self.parts.values() for x in own]
        return np.stack(np.broadcast_arrays(*rigid, *parts), axis=-1)

    def of_members(self, members: int | NDArray[np.int_]) -> StateVector:
        """Return that of one member of an ensemble, or of some."""

        def chosen(number: Any) -> Any:
            return number[members] if np.ndim(number) else number

        orbits = tuple(block.with_numbers(map(chosen, block.numbers)) for block in self.orbits)
        own = replace(self, scale=chosen(self.scale), orbits=orbits)
        return own.with_factors(map(chosen, self.factors)) if self.factors else own

    # ------------------------------------------------------------------ numbers

    def from_state(self, state: AnyState) -> Array:
        """Return the variables of a state; shape (..., size)."""
        if not self.orbits and not self.variations:
            return self._packed(state)
        orbits = [block.start_in_two_parts(state.time) for block in self.orbits]
        own = self._packed(state, orbits[0][2] if self.comoving else None)
        starts = [high.astype(own.dtype) + low.astype(own.dtype) for high, low, _ in orbits]
        out = np.empty((*own.shape[:-1], self.size), own.dtype)
        place = 0
        for each in (own, *starts, *([self.variations.start()] if self.variations else ())):
            first, place = place, place + each.shape[-1]
            out[..., first:place] = each
        return out

    def with_state(self, row: Array, state: AnyState, time: Array) -> Array:
        """Return attitude, momentum and parts of a state, beside the orbits in the variables of one body."""
        turn = None
        if self.comoving:
            own = np.asarray(row[self.along_orbits], dtype=float)
            turn = quat.conjugate(self.orbits[0].quaternion(time, own))
        return self._packed(state, turn)

    def _packed(self, state: AnyState, turn: Array | None = None) -> Array:
        """Return the variables of attitude, momentum and parts."""
        chart, bodies = self.formulation, []
        for each, scale in zip(state.of_bodies.values(), self.scales(self.scale), strict=True):
            body = chart.from_state(each)
            momenta = body.T[chart.momenta]
            momenta *= np.asarray(scale, dtype=body.dtype)
            if turn is not None:
                self._turn(body, turn)
            chart.check_variables(body)
            bodies.append(body)
        rigid = np.concatenate(bodies, axis=-1) if len(bodies) > 1 else bodies[0]
        if not self.parts:
            return rigid
        columns, own = [], state.own
        for name in self.parts:
            columns += self.slots[name].scaled(np.moveaxis(np.asarray(own[name]), -1, 0), self.scale)
        return np.concatenate([rigid, np.stack(columns, axis=-1).astype(rigid.dtype)], axis=-1)

    def _turn(self, rigid: Array, turn: Array) -> None:
        for place in self.formulation.quaternions:
            turn_rows(turn, rigid[..., place])

    def to_phase(self, times: Array, variables: Array) -> Phase:
        """Return q, the momenta and the variables of parts along the times; shapes (..., n, 4) and so on."""
        rows = np.empty((*variables.shape[:-1], self.along_orbits.stop), variables.dtype)
        for block in blocks_of(len(times)) if variables.ndim == 2 else [EVERY]:
            rows[block] = variables[block, ..., : self.along_orbits.stop]
            self.make_physical(times[block], rows[block])
        return self.phase_of(rows)

    def make_physical(self, times: Array, rows: Array) -> None:
        """Turn attitudes to the space axes, and bring momenta and variables of parts to physical units, in place."""
        momenta = range(self.formulation.size)[self.formulation.momenta]
        for place, scale in zip(self.charts, self.scales(self.scale), strict=True):
            scale = np.asarray(scale)[..., None]
            for i in momenta:  # a column at a time: rows are short
                rows[..., place.start + i] /= scale
        if self.comoving:
            (block,) = self.orbits
            if rows.ndim == 3:
                block = block.with_numbers(expanded(number, 2) for number in block.numbers)
            self._turn(rows, block.quaternion(times, rows[..., self.along_orbits]))
        for name in self.parts:
            for i, factor in enumerate(self.slots[name].factors, self.slots[name].place.start):
                rows[..., i] *= 1 / np.asarray(self.scale if factor is None else factor)[..., None]

    def phase_of(self, rows: Array) -> Phase:
        """Return what rows in physical units have in a phase, as views unless the chart computes it."""
        phase = Phase()
        for body, place in zip(self.ratios, self.charts, strict=True):
            phase |= {named(body, name): row for name, row in self._of_chart(rows[..., place]).items()}
        return phase | {name: rows[..., self.slots[name].place] for name in self.parts}

    def _of_chart(self, rigid: Array) -> Phase:
        read = self.formulation.to_phase
        if rigid.ndim == 3 or len(rigid) <= BLOCK or np.may_share_memory(rigid, read(rigid[:1])["quaternion"]):
            return read(rigid)
        out = Phase()
        for block in blocks_of(len(rigid)):
            for name, values in read(rigid[block]).items():
                if name not in out:
                    out[name] = np.empty((len(rigid), values.shape[-1]), values.dtype)
                out[name][block] = values
        return out

    def environment(self, problem: Problem, times: Array, values: Array) -> Environment:
        """Return the environment at the times with variables of orbits, shape (..., n, along_orbits)."""
        blocks = viewed(problem.beside(values.shape[:-1]).orbits, self.views)
        columns = np.moveaxis(values, -1, 0)
        places = itertools.accumulate((block.size for block in blocks), initial=0)
        own = (Vector(columns[place : place + block.size]) for block, place in zip(blocks, places, strict=False))
        return Environment(times, list(zip(blocks, own, strict=True)))

    # ------------------------------------------------------------------ symbols

    def physical(self, variables: Any, scale: Scalar) -> dict[str, Vector]:
        """Return the variables of parts in physical units, by the name of the part."""
        return {name: self.slots[name].physical(variables, scale) for name in self.parts}

    def rates(self, by_block: Mapping[str, Vector], scale: Scalar) -> Iterator[Scalar]:
        """Yield the rates of the variables of parts and orbits, from those in physical units."""
        for name, slot in self.slots.items():
            if name in by_block:
                yield from slot.scaled(by_block[name], scale)


def blocks_of(count: int) -> list[slice]:
    """Return so many rows in blocks."""
    return [slice(first, first + BLOCK) for first in range(0, count, BLOCK)] if count > BLOCK else [EVERY]


def _chart_of(body: str) -> str:
    """Return the name of the slot of attitude and momentum."""
    return f"{CHART} of the {body}" if body else CHART


def factors_of_parts(system: AnyDynamics, state: AnyState) -> dict[str, Factors]:
    """Return factors that bring the variables of parts near a tenth, along the motion from a state."""
    parts = system.inner_blocks
    if not parts:
        return {}
    sizes, factors = sizes_of_blocks(system, state), {}
    for part in parts:
        momenta = {i for place in part.momentum_places for i in range(place.start, place.stop)}
        factors[part.name] = tuple(None if i in momenta else _power(sizes[part.name][..., i]) for i in range(part.size))
    return factors


def _power(size: Any) -> Any:
    """Return the powers of two that bring sizes near a tenth, without rounding; 1 for a size of zero."""
    sound = (size > 0) & (size < np.inf)
    return np.exp2(np.round(np.log2(SMALL / np.where(sound, size, SMALL))))[()]
