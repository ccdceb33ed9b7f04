"""State vector of a kernel: slots for attitude and momentum, parts, integrated orbits and tangent vectors."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.integration.formulations import Formulation
from poinsot.integration.problem import Problem
from poinsot.integration.scaling import Number, power_of_two, sizes_of_blocks
from poinsot.integration.turned_rows import turn_rows
from poinsot.integration.variational import Variations
from poinsot.kinematics.state import AnyState, Phase, named
from poinsot.mechanics.environment import Environment, OrbitBlock, Views, viewed
from poinsot.quantities import Array
from poinsot.records.members import expanded
from poinsot.systems.dynamics import AnyDynamics
from poinsot.taylor.rescaling import MOMENTUM_SCALE

__all__ = ["Slot", "StateVector", "blocks_of", "factors_of_parts"]

ROWS_PER_BLOCK = 8192
"""Number of rows converted together, so that intermediate results stay in the cache of the processor."""

EVERY = slice(None)

STRUCTURAL = ("structure", "along_orbits", "size", "charts", "momenta")
"""Attributes that the variables of all systems of one structure share."""

CHART, TANGENT = "attitude and momentum", "tangent vectors"
"""Names of slots in addition to the names of parts."""

Factors = tuple[Number | None, ...]
"""Factors of the variables of a slot, powers of two; None stands for the scale of the momenta."""


class Slot(NamedTuple):
    """Range of variables in the state vector, and the factor of each variable: a number, or an array (members,)."""

    place: slice
    factors: Factors

    def physical(self, variables: Sequence[Scalar], scale: Scalar) -> Vector:
        """Return the variables in physical units, scalars of any kind."""
        factors = zip(variables[self.place], self.factors, strict=True)
        return Vector(x * (1 / (scale if factor is None else factor)) for x, factor in factors)

    def scaled(self, values: Iterable[Scalar], scale: Scalar) -> list[Scalar]:
        """Return scaled variables from values in physical units."""
        return [x * (scale if factor is None else factor) for x, factor in zip(values, self.factors, strict=True)]

    @property
    def momenta(self) -> list[int]:
        """Places of the variables that scale like the angular momentum."""
        return [self.place.start + i for i, factor in enumerate(self.factors) if factor is None]


@dataclass(eq=False)
class StateVector:
    """Integrated variables of a kernel.

    Parameters
    ----------
    formulation : Formulation
        The chart of attitude and momentum of each body.
    scale : float or array (members,)
        Factor of the momenta.
    parts : mapping
        The factors of each part by its name.
    orbits : tuple of OrbitBlock
        Integrated orbits.
    views : tuple
        Number of the block of each orbit of the problem, or None.
    comoving : bool
        Whether the attitude refers to the comoving axes of the one block.
    variations : Variations, optional
        The tangent vectors.
    ratios : mapping
        Further factor of the momenta of each body; 1 for the first body.
    torque_scale : float or array (members,)
        Momenta that the forces give a body at rest, in physical units.
    """

    formulation: Formulation
    scale: Number
    parts: Mapping[str, Factors]
    orbits: tuple[OrbitBlock, ...] = ()
    views: Views = ()
    comoving: bool = False
    variations: Variations | None = None
    ratios: Mapping[str, Number] = field(default_factory=lambda: {"": 1.0})
    torque_scale: Number = 0.0

    def sharing(self, known: dict[Any, Any]) -> StateVector:
        """Return the variables with the structural attributes of another system of the structure, stored in `known`."""
        key = self.formulation, self.views, self.comoving, *[block.structure for block in self.orbits]
        if key not in known:
            known[key] = {name: getattr(self, name) for name in STRUCTURAL}
        vars(self).update(known[key])
        return self

    @cached_property
    def slots(self) -> dict[str, Slot]:
        """Slots by name, in the order of the variables."""
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
        """Number of variables."""
        along: int = self.along_orbits.stop
        return along + (self.variations.size if self.variations else 0)

    @property
    def sizes(self) -> dict[str, int]:
        """Length of a row of each array of a phase."""
        chart = self.formulation.to_phase(np.full(self.formulation.size, np.nan))
        rigid = {named(body, name): row.size for body in self.ratios for name, row in chart.items()}
        return rigid | {name: len(own) for name, own in self.parts.items()}

    @cached_property
    def charts(self) -> list[slice]:
        """Ranges of attitude and momentum of each body."""
        size = self.formulation.size
        return [slice(i * size, (i + 1) * size) for i in range(len(self.ratios))]

    @property
    def attitude(self) -> list[int]:
        """Places of the attitudes."""
        count = next(iter(self.formulation.blocks.values()))
        return [own.start + k for own in self.charts for k in range(count)]

    @cached_property
    def along_orbits(self) -> slice:
        """Range of the variables of orbits."""
        first = len(self.ratios) * self.formulation.size + sum(map(len, self.parts.values()))
        return slice(first, first + sum([block.size for block in self.orbits]))

    @property
    def tangent_vectors(self) -> slice:
        """Range of the tangent vectors."""
        return slice(self.along_orbits.stop, None)

    @cached_property
    def momenta(self) -> slice | list[int]:
        """Places of the momenta of the motion."""
        if not self.parts:
            return self.formulation.momenta
        names = (*map(_chart_of, self.ratios), *self.parts)
        return [place for name in names for place in self.slots[name].momenta]

    @cached_property
    def conjugates(self) -> list[tuple[slice, slice]]:
        """Ranges of q and Q of each body, in a formulation with these variables."""
        if not self.formulation.conjugate:
            return []
        return [(slice(own.start, own.start + 4), slice(own.start + 4, own.stop)) for own in self.charts]

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """Key of the equations, without any real number of the system."""
        variations = self.variations and replace(self.variations, initial=None, sizes=())
        blocks = tuple([block.structure for block in self.orbits])
        parts = tuple([(name, *(factor is None for factor in own)) for name, own in self.parts.items()])
        return self.formulation, tuple(self.ratios), parts, blocks, self.views, self.comoving, variations

    @property
    def factors(self) -> tuple[Number, ...]:
        """Ratios of further bodies and numeric factors of parts: parameters of a kernel."""
        _, *ratios = self.ratios.values()
        return *ratios, *[factor for own in self.parts.values() for factor in own if factor is not None]

    def with_factors(self, factors: Iterator[Any]) -> StateVector:
        """Return a copy with other ratios and factors, scalars of any kind, in place of the numbers."""
        ratios = {body: next(factors) if i else ratio for i, (body, ratio) in enumerate(self.ratios.items())}
        parts = {n: tuple(x if x is None else next(factors) for x in own) for n, own in self.parts.items()}
        return replace(self, parts=parts, ratios=ratios)

    def scales(self, scale: Scalar) -> list[Scalar]:
        """Return the factor of the momenta of each body."""
        return [scale * ratio if i else scale for i, ratio in enumerate(self.ratios.values())]

    @property
    def of_one(self) -> bool:
        """True if all members share scales and orbits."""
        numbers = self.scale, *self.factors, *(number for block in self.orbits for number in block.numbers)
        return not any(map(np.ndim, numbers))

    @cached_property
    def scaled(self) -> list[int]:
        """Places of all variables that scale like the angular momentum, including tangent vectors."""
        return [place for slot in self.slots.values() for place in slot.momenta]

    @property
    def tangent_coordinates(self) -> list[int]:
        """Numbers of the tangent coordinates: those of each body, out of six, and those of parts."""
        rigid = [6 * i + place for i in range(len(self.ratios)) for place in self.formulation.tangent]
        own = sum(map(len, self.parts.values()))
        return rigid + list(range(6 * len(self.ratios), 6 * len(self.ratios) + own))

    @cached_property
    def tangent_scales(self) -> tuple[bool, ...]:
        """Mask of the tangent coordinates that scale like momenta."""
        rigid = (place >= 3 for _ in self.ratios for place in self.formulation.tangent)
        return *rigid, *(factor is None for own in self.parts.values() for factor in own)

    @property
    def tangent_units(self) -> Array:
        """Factor of each tangent coordinate in the variables; shape (k,) or (members, k)."""
        each = zip(self.ratios, self.scales(self.scale), strict=True)
        rigid = [own if place >= 3 else 1.0 for _, own in each for place in self.formulation.tangent]
        parts = [self.scale if x is None else x for own in self.parts.values() for x in own]
        return quat.assemble((*rigid, *parts))

    _member_axes: ClassVar[Mapping[str, int]] = {"scale": 0, "parts": 0, "orbits": 0, "ratios": 0, "torque_scale": 0}

    def _with_values(self, **values: Any) -> StateVector:
        return replace(self, **values)

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
        """Return the variables of attitude, momentum and parts of a state, given a row with the orbits."""
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
            columns += self.slots[name].scaled(quat.components(own[name]), self.scale)
        return np.concatenate([rigid, np.stack([*map(np.asarray, columns)], axis=-1).astype(rigid.dtype)], axis=-1)

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
        """Rotate attitudes to the space axes and convert momenta and parts to physical units, in place."""
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
        """Return the phase of rows in physical units, as views unless the chart computes it."""
        phase = Phase()
        for body, place in zip(self.ratios, self.charts, strict=True):
            phase |= {named(body, name): row for name, row in self._of_chart(rows[..., place]).items()}
        return phase | {name: rows[..., self.slots[name].place] for name in self.parts}

    def _of_chart(self, rigid: Array) -> Phase:
        read = self.formulation.to_phase
        if rigid.ndim == 3 or len(rigid) <= ROWS_PER_BLOCK or np.may_share_memory(rigid, read(rigid[:1])["quaternion"]):
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
        blocks = viewed(problem.broadcast_to(values.shape[:-1]).orbits, self.views)
        columns = quat.components(values)
        places = itertools.accumulate((block.size for block in blocks), initial=0)
        own = (Vector(columns[place : place + block.size]) for block, place in zip(blocks, places, strict=False))
        return Environment(times, list(zip(blocks, own, strict=True)))

    # ------------------------------------------------------------------ symbols

    def physical(self, variables: Sequence[Scalar], scale: Scalar) -> dict[str, Vector]:
        """Return the variables of parts in physical units, by the name of the part."""
        return {name: self.slots[name].physical(variables, scale) for name in self.parts}

    def rates(self, by_block: Mapping[str, Vector], scale: Scalar) -> Iterator[Scalar]:
        """Yield the rates of the variables of parts and orbits, from those in physical units."""
        for name, slot in self.slots.items():
            if name in by_block:
                yield from slot.scaled(by_block[name], scale)


def blocks_of(count: int) -> list[slice]:
    """Return the ranges of blocks of rows."""
    return (
        [slice(first, first + ROWS_PER_BLOCK) for first in range(0, count, ROWS_PER_BLOCK)]
        if count > ROWS_PER_BLOCK
        else [EVERY]
    )


def _chart_of(body: str) -> str:
    """Return the name of the slot of attitude and momentum."""
    return f"{CHART} of the {body}" if body else CHART


def factors_of_parts(system: AnyDynamics, state: AnyState) -> dict[str, Factors]:
    """Return factors that scale the variables of parts to about a tenth along the motion from a state."""
    parts = system.inner_blocks
    if not parts:
        return {}
    sizes, factors = sizes_of_blocks(system, state), {}
    for part in parts:
        momenta = {i for place in part.momentum_places for i in range(place.start, place.stop)}
        factors[part.name] = tuple(None if i in momenta else _power(sizes[part.name][..., i]) for i in range(part.size))
    return factors


def _power(size: Number) -> Number:
    """Return the powers of two that scale sizes to about a tenth; 1 for a size of zero."""
    sound = (size > 0) & (size < np.inf)
    return power_of_two((MOMENTUM_SCALE / np.where(sound, size, MOMENTUM_SCALE))[()])
