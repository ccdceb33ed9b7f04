"""Programs: decompositions of formulas, and the formulas of their parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from poinsot.taylor.canonical_form import TIME, CanonicalForm, Root
from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.graph import Evaluator, GraphScalar, Node, Number, ordered, replaced, wide
from poinsot.taylor.rescaling import MOMENTUM_SCALE
from poinsot.taylor.sampling import Jumps, Update
from poinsot.taylor.shared_products import CommonSubexpressions, without_squares

__all__ = ["TIME", "Constants", "Program", "StartRoots", "conditions_of", "simplified"]

Doubles: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Program:
    """A decomposition and the formulas of its parameters.

    Attributes
    ----------
    decomposition : Decomposition
    formulas : list of Node
        The `Constants` of runs in which none of them is zero, then the parameters.
    roots : list of Root
    jumps : Jumps, optional
        Updates of variables at samples.
    """

    decomposition: Decomposition
    formulas: list[Node]
    roots: list[Root]
    jumps: Jumps | None = None

    @property
    def parameters(self) -> list[Node]:
        """The formulas of the parameters; 0 for those that a kernel holds."""
        return self.formulas[-self.decomposition.parameters :] if self.decomposition.parameters else []

    def with_jumps(self, own: list[Node], updates: list[Update]) -> Program:
        """Return the program with the formulas of updates, whose constants are parameters behind the others."""
        if not updates:
            return self
        first, constants = self.decomposition.parameters, _constants_met([x for each in updates for x in each.values])
        decomposition = replace(self.decomposition, parameters=first + len(constants))
        return Program(decomposition, [*self.formulas, *constants], self.roots, Jumps(own, updates, constants, first))


class Constants:
    """Constants that a variable meets in formulas, evaluated for the inputs of a run.

    Parameters
    ----------
    formulas : sequence of scalars
        Rates and watched functions.

    Attributes
    ----------
    count : int
        Number of constants.
    values : Evaluator
    switches : bool
        True if a formula branches along the motion.
    """

    def __init__(self, formulas: Sequence[GraphScalar]) -> None:
        nodes = ordered(formulas)
        conditions = {node.operands[0] for node in nodes if node.name == "where"}
        met = _constants_met(formulas)
        self.count, self.values = len(met), Evaluator(met, wide)
        self._never_conditions = [number for number, node in enumerate(met) if node not in conditions]
        self.switches = any(node.name == "less" and node.varies for node in nodes)

    def zeros(self, values: Sequence[Number], numbers: Sequence[Number]) -> tuple[int, ...]:
        """Return the numbers of the constants that are zero for all members; none if a constant is not finite.

        Values are a list of floats if all numbers are scalars; other values may follow the values of the constants.
        Conditions of branches do not count, nor constants that are zero by chance for the numbers of these members: no
        member depends on the others of its ensemble.
        """
        own = values[: self.count]
        alike = isinstance(own, list)
        total = sum(own if alike else [value for value in own if value.__class__ is not np.ndarray])
        if total - total:
            return ()
        if alike:
            return tuple([number for number in self._never_conditions if not own[number]])
        found = [number for number in self._never_conditions if _is_zero_for_all(values[number])]
        if found:
            others = self.values([_other_members(i) if np.ndim(x) else x for i, x in enumerate(numbers)])
            found = [number for number in found if _is_zero_for_all(others[number])]
        return tuple(found)


def _other_members(place: int) -> Doubles:
    """Return fixed numbers between 0 and 1 that members might have at a place."""
    return 0.1 + 0.8 * np.mod((place + 1) * (math.sqrt(5) - 1) / 2 + np.array([0.0, 0.29, 0.61]), 1.0)


def _constants_met(formulas: Sequence[GraphScalar]) -> list[Node]:
    met = [x for node in ordered(formulas) if node.varies for x in node.nodes if not x.varies]
    return [*dict.fromkeys([*met, *(x for x in formulas if isinstance(x, Node) and not x.varies)])]


def _is_zero_for_all(value: Number) -> bool:
    return not value.any() if value.__class__ is np.ndarray else not value


def conditions_of(outputs: Iterable[GraphScalar]) -> dict[Node, GraphScalar]:
    """Return the conditions on which formulas branch on the way, and functions that are negative where they hold."""
    found = [node for node in ordered(outputs) if node.name == "less" and node.varies]
    return {node: node.operands[0] - node.operands[1] for node in found}


def simplified(rates: Sequence[GraphScalar], zeros: Iterable[int] = (), events: Sequence[GraphScalar] = ()) -> Program:
    """Return the program of rates and values of events for runs in which some of the `Constants` are zero."""
    formulas = [*rates, *events]
    constants = _constants_met(formulas)
    left = replaced(formulas, {constants[number]: 0.0 for number in zeros})
    conditions = conditions_of(left)
    form = CanonicalForm((left[: len(rates)], [*conditions.values(), *left[len(rates) :]]))
    final = CommonSubexpressions(without_squares(form.drafts, form.outputs[0]), form)
    own, watched = (tuple(map(final.value, group)) for group in form.outputs)
    places = tuple(form.conditions[node.place] for node in conditions)
    decomposition = Decomposition(final.operations(), own, len(form.constants), watched, places)
    return Program(decomposition, [*constants, *form.constants], form.roots)


class StartRoots:
    """The square roots of members that are zero at the start, such as the length of the rate of a body at rest.

    A series of sqrt(s) about s = 0 does not exist. There the kernel computes sqrt(s + e^2), e a billionth of the size
    of the root. In a motion from rest the difference is of the size e^2, below the rounding error. The parameters e^2
    depend on the starts of the members.

    Parameters
    ----------
    program : Program
    size : int
        Number of variables.

    Attributes
    ----------
    places : list of int
        The numbers of the parameters.
    """

    def __init__(self, program: Program, size: int) -> None:
        self.places = [root.parameter for root in program.roots]
        symbols = [root.argument.graph.symbol(name) for root in program.roots[:1] for name in (*range(size), TIME)]
        self._under = Evaluator([root.argument for root in program.roots], np.asarray, symbols)

    def set(
        self,
        table: Doubles,
        numbers: Sequence[Number],
        starts: Doubles,
        times: Doubles,
        momenta: slice | list[int],
        negligible: float,
    ) -> None:
        """Set the parameters of members, shape (members, parameters), for their starts, shape (members, size).

        The part `negligible` of the size of a root counts for nothing when squared.
        """
        moving = starts.copy()
        moving[:, momenta] += MOMENTUM_SCALE
        given = [*map(wide, numbers)]
        resting, turning = (self._under([*rows.T, times, *given]) for rows in (starts, moving))
        for place, here, there in zip(self.places, resting, turning, strict=True):
            table[:, place] = np.where((here == 0) & (there > 0), negligible**2 * there, 0.0)
