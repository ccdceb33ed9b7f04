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

_Step = tuple[int, Callable[..., Any], tuple[int, ...], int]
"""The place of a result, the operation, the places of its operands, and the numbers that it depends on, as bits."""

EVERY = -1
"""All bits."""

SWEEPS = 8
"""Sets of numbers that change together, of which the steps that they need are remembered."""


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
        self._typed, self._numbers = typed, list[Any]()
        nodes = [x for x in outputs if isinstance(x, Node)]
        given = {node.place: number for number, node in enumerate(first)}
        inputs = [node for node in needed(nodes, given) if node.name == "input"]
        given |= {node.place: len(first) + node.operands[0] for node in inputs}
        places = {place: self._new() for place in given}
        needs = {places[place]: 1 << number for place, number in given.items()}
        self._given = {number: places[place] for place, number in given.items()}
        steps: list[_Step] = []
        for node in needed(nodes, given):
            if node.name in ("value", HELD):
                places[node.place] = self._new(node.value if node.name == "value" else 0.0)
            else:
                operands = tuple(places[x.place] if isinstance(x, Node) else self._new(x) for x in node.operands)
                places[node.place] = self._new()
                needs[places[node.place]] = own = functools.reduce(or_, (needs.get(x, 0) for x in operands), 0)
                steps.append((places[node.place], operation_of(node), operands, own or EVERY))
        self._due = functools.lru_cache(SWEEPS)(lambda changed: [step for step in steps if step[-1] & changed])
        self._last: tuple[tuple[Any, ...], list[Any]] = (), []
        self._places = [places[x.place] if isinstance(x, Node) else self._new(x) for x in outputs]

    def _new(self, value: Any = 0.0) -> int:
        self._numbers.append(value)
        return len(self._numbers) - 1

    def __call__(self, given: Sequence[Any]) -> list[Any]:
        """Return the values, scalars or arrays."""
        last, before = self._last  # threads exchange both at once
        changed = _changed(given, last) if last else range(len(given))
        bits = sum([1 << number for number in changed]) if last else EVERY
        known = (before if last else self._numbers).copy()
        for number in changed:
            if number in self._given:
                value = given[number]  # to convert a scalar takes as long as four products
                known[self._given[number]] = value if type(value) is self._typed else self._typed(value)
        value_at = known.__getitem__
        for place, operation, operands, _ in self._due(bits):
            if len(operands) == 2:  # as most have: without a list of arguments
                first, second = operands
                known[place] = operation(known[first], known[second])
            else:
                known[place] = operation(*map(value_at, operands))
        self._last = ((), []) if np.ndarray in set(map(type, given)) else (tuple(given), known)
        return [*map(value_at, self._places)]


def _changed(given: Sequence[Any], last: Sequence[Any]) -> list[int]:
    """Return which numbers are others than the last time."""
    others = itertools.compress(range(len(given)), map(is_not, given, last))
    return [number for number in others if not _is_same(given[number], last[number])]


def _is_same(x: Any, y: Any) -> bool:
    return type(x) is type(y) and x == y and (bool(x) or math.copysign(1, x) == math.copysign(1, y))
