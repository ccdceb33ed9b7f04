"""What is computed from numbers alone in traced formulas, again and again: without the graph, and only what changes."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from operator import or_
from typing import Any

import numpy as np

from poinsot.taylor.graph import Node, needed, operation_of

__all__ = ["HELD", "Replay", "wide"]

HELD = "held"
"""The name of constants that no input gives: conditions and roots, which change at switches and at the start."""

WRITTEN = {"add": "{} + {}", "neg": "-{}", "mul": "{} * {}", "div": "{} / {}", "pow": "{} ** {}"}
"""Operations as Python has them; any other one is called."""

wide: Callable[[Any], Any] = np.longdouble(1).__mul__
"""Makes a long double of a number or an array, in a quarter of the time of `np.longdouble`."""

SWEEPS = 8
"""Sets of numbers that change together, for which there are functions of their own."""

_Step = tuple[int, str, tuple[int, ...], int]
"""The place of a result, the operation, the places of its operands, and the numbers that it depends on, as bits."""

_Sweep = Callable[[Sequence[Any], list[Any]], tuple[Any, ...]]
"""Puts numbers that are given, and what is computed of them, into a list of all that is known; returns the values."""

NOTHING: tuple[tuple[Any, ...], list[Any], tuple[Any, ...]] = (), [], ()
"""Numbers, all that is known of them, and the values, before there are any."""


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
                operands = tuple(places[x.place] if isinstance(x, Node) else self._new(x) for x in node.arguments)
                places[node.place] = self._new()
                needs[places[node.place]] = own = functools.reduce(or_, (needs.get(x, 0) for x in operands), 0)
                if node.name not in WRITTEN:
                    self._scope[node.name] = operation_of(node)
                self._steps.append((places[node.place], node.name, operands, own))
        self._places = [places[x.place] if isinstance(x, Node) else self._new(x) for x in outputs]
        used = {place for _, _, operands, own in self._steps for place in operands if needs.get(place) != own}
        self._kept = used.union(self._places)  # what other sweeps may read
        self._sweeps: dict[tuple[int, ...], _Sweep] = {}
        self._order, self._last = range(max(self._given, default=-1) + 1), NOTHING

    def _new(self, value: Any = 0.0) -> int:
        if isinstance(value, Fraction):
            value = np.longdouble(value.numerator) / np.longdouble(value.denominator)
        self._numbers.append(value)
        return len(self._numbers) - 1

    def __call__(self, given: Sequence[Any]) -> tuple[Any, ...]:
        """Return the values, scalars or arrays: the same tuple as the last time, where all numbers are those."""
        scalars = np.ndarray not in map(type, given)
        last, known, values = self._last if scalars else NOTHING  # threads exchange it whole
        changed = tuple([
            number
            for number, x, y in zip(self._order, given, last, strict=False)
            if x is not y and (x != y or (not x and math.copysign(1.0, x) != math.copysign(1.0, y)))
        ])  # fmt: skip
        if changed or not last:
            known = (known or self._numbers).copy()
            sweep = self._sweeps.get(changed) or self._sweep(changed)
            values = sweep(given, known)
            self._last = (tuple(given), known, values) if scalars else NOTHING
        return values

    def _sweep(self, changed: tuple[int, ...]) -> _Sweep:
        """Return what computes all that depends on some numbers, or on any where such sets are many."""
        changed = changed if len(self._sweeps) < SWEEPS else ()
        self._sweeps[changed] = self._sweeps.get(changed) or self._written(changed)
        return self._sweeps[changed]

    def _written(self, changed: tuple[int, ...]) -> _Sweep:
        """Return it as a function of Python with a line for each step: a loop over them takes five times as long.

        The text has places and names of known operations alone, no number and no name that anybody gives.
        """
        lines, new = ["def sweep(given, known):"], set[int]()
        for number, place in self._given.items():
            if not changed or number in changed:  # to convert a scalar takes as long as four products
                lines.append(f"known[{place}] = x{place} = typed(given[{number}])")
                new.add(place)
        bits = sum([1 << number for number in changed])

        def named(place: int) -> str:
            return f"x{place}" if place in new else f"known[{place}]"

        for place, name, operands, needs in self._steps:
            if not changed or needs & bits:
                own = [*map(named, operands)]
                result = WRITTEN[name].format(*own) if name in WRITTEN else f"{name}({', '.join(own)})"
                lines.append(f"{f'known[{place}] = ' * (place in self._kept)}x{place} = {result}")
                new.add(place)
        lines.append(f"return ({' '.join(f'{named(place)},' for place in self._places)})")
        scope = self._scope.copy()
        exec("\n ".join(lines), scope)  # noqa: S102
        sweep: _Sweep = scope["sweep"]
        return sweep
