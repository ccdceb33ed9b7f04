"""What is computed from numbers alone in traced formulas, again and again: without the graph, and only what changes."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from operator import is_not, or_
from typing import Any

import numpy as np

from poinsot.algebra.program import Node, needed, operation_of

__all__ = ["HELD", "Replay"]

HELD = "held"
"""The name of constants that no input gives: conditions and roots, which change at switches and at the start."""

WRITTEN = {"add": "{} + {}", "neg": "-{}", "mul": "{} * {}", "div": "{} / {}", "pow": "{} ** {}"}
"""Operations as Python has them; any other one is called."""

EVERY = -1
"""All bits."""

SWEEPS = 8
"""Sets of numbers that change together, for which there are functions of their own."""

_Step = tuple[int, str, tuple[int, ...], int]
"""The place of a result, the operation, the places of its operands, and the numbers that it depends on, as bits."""

_Sweep = Callable[[Sequence[Any], list[Any]], None]
"""Puts numbers that are given, and what is computed of them, into a list of all that is known."""


class Replay:
    """Constants computed again and again from numbers in a list; those that are held are 0.

    Of scalars only what depends on those that are others than the last time is computed anew.

    Parameters
    ----------
    outputs : sequence of scalars
        What is computed: nodes, or numbers.
    typed : callable
        Makes of each of the numbers, a scalar or an array, what is computed with.
    first : sequence of Node
        Nodes that the list begins with; the inputs of the run follow.
    """

    def __init__(self, outputs: Sequence[Any], typed: Callable[[Any], Any], first: Sequence[Node] = ()) -> None:
        self._scope, self._numbers = dict[str, Any](typed=typed), list[Any]()
        nodes = [x for x in outputs if isinstance(x, Node)]
        given = {node.place: number for number, node in enumerate(first)}
        inputs = [node for node in needed(nodes, given) if node.name == "input"]
        given |= {node.place: len(first) + node.operands[0] for node in inputs}
        places = {place: self._new() for place in given}
        needs = {places[place]: 1 << number for place, number in given.items()}
        self._given = {number: places[place] for place, number in given.items()}
        self._steps: list[_Step] = []
        for node in needed(nodes, given):
            if node.name in ("value", HELD):
                places[node.place] = self._new(node.value if node.name == "value" else 0.0)
            else:
                operands = tuple(places[x.place] if isinstance(x, Node) else self._new(x) for x in node.operands)
                places[node.place] = self._new()
                needs[places[node.place]] = own = functools.reduce(or_, (needs.get(x, 0) for x in operands), 0)
                if node.name not in WRITTEN:
                    self._scope[node.name] = operation_of(node)
                self._steps.append((places[node.place], node.name, operands, own or EVERY))
        self._sweeps: dict[int, _Sweep] = {}
        self._last: tuple[tuple[Any, ...], list[Any]] = (), []
        self._places = [places[x.place] if isinstance(x, Node) else self._new(x) for x in outputs]

    def _new(self, value: Any = 0.0) -> int:
        self._numbers.append(value)
        return len(self._numbers) - 1

    def __call__(self, given: Sequence[Any]) -> list[Any]:
        """Return the values, scalars or arrays."""
        last, before = self._last  # threads exchange both at once
        changed = sum([1 << number for number in _changed(given, last)]) if last else EVERY
        known = before
        if changed:
            known = (before if last else self._numbers).copy()
            self._sweep(changed)(given, known)
            self._last = ((), []) if np.ndarray in set(map(type, given)) else (tuple(given), known)
        return [*map(known.__getitem__, self._places)]

    def _sweep(self, changed: int) -> _Sweep:
        """Return what computes all that depends on some numbers."""
        if changed not in self._sweeps:
            changed = changed if len(self._sweeps) < SWEEPS else EVERY
            self._sweeps[changed] = self._sweeps.get(changed) or self._written(changed)
        return self._sweeps[changed]

    def _written(self, changed: int) -> _Sweep:
        """Return it as a function of Python with a line for each step: a loop over them takes five times as long.

        The text has places and names of known operations alone, no number and no name that anybody gives.
        """
        lines, new = ["def sweep(given, known):"], set[int]()
        for number, place in self._given.items():
            if changed >> number & 1:  # to convert a scalar takes as long as four products
                lines.append(f"x = given[{number}]")
                lines.append(f"known[{place}] = x{place} = x if x.__class__ is typed else typed(x)")
                new.add(place)
        for place, name, operands, needs in self._steps:
            if needs & changed:
                named = [f"x{x}" if x in new else f"known[{x}]" for x in operands]
                result = WRITTEN[name].format(*named) if name in WRITTEN else f"{name}({', '.join(named)})"
                lines.append(f"known[{place}] = x{place} = {result}")
                new.add(place)
        scope = self._scope.copy()
        exec("\n ".join([*lines, "return"]), scope)  # noqa: S102
        sweep: _Sweep = scope["sweep"]
        return sweep


def _changed(given: Sequence[Any], last: Sequence[Any]) -> list[int]:
    """Return which numbers are others than the last time."""
    others = itertools.compress(range(len(given)), map(is_not, given, last))
    return [number for number in others if not _is_same(given[number], last[number])]


def _is_same(x: Any, y: Any) -> bool:
    return type(x) is type(y) and x == y and (bool(x) or math.copysign(1, x) == math.copysign(1, y))
