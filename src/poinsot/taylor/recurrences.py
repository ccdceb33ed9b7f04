"""The recurrences of Taylor coefficients in LLVM's representation: order 0 of all operations, and an order n > 0."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

from typing_extensions import override

from poinsot.taylor import llvm_functions, wide_functions
from poinsot.taylor.decomposition import Coefficient, Function, Integral
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Array, Record, Value
from poinsot.taylor.schedule import Row, Schedule, varying

__all__ = ["HigherOrder", "ZerothOrder"]

NOTHING = Coefficient(0.0)

BLOCK, MAX_UNCUT = 30, 1000
"""Operations of a block of straight-line code, and how many are left in one block: the scheduling of instructions and
the allocation of registers take a time that grows with more than the length of a block."""


class ZerothOrder:
    """Writes the values of all operations; each kind of these has the method of its name."""

    def __init__(self, kernel: Any, work: Record) -> None:
        self._kernel, self._work = kernel, work
        self._schedule: Schedule = kernel.schedule
        self._kind: str = kernel.number
        self._states: Array | Sequence[Value] = kernel.layout.states(work.address, 0)
        self._values: list[Value] = []

    def outputs(self) -> list[Value]:
        """Write all operations, and return the rates and, behind them, what is watched."""
        large = len(self._schedule.operations) > MAX_UNCUT
        for k, operation in enumerate(self._schedule.operations):
            if large and k % BLOCK == 0:
                self._work.address.function.cut(self._work.array("active", INTEGER)[0].is_("ge", 0))
            write = getattr(self, f"_{type(operation).__name__.lower()}", None)
            if write is None:
                raise TypeError(f"operation must be one with a recurrence, got {operation}.")
            self._values.append(write(*operation))
            self._keep(k, self._values[k])
        return list(map(self._value, self._schedule.outputs))

    def _value(self, of: Coefficient | int) -> Value:
        return self._values[of] if isinstance(of, int) else self._constant(of)

    def _constant(self, coefficient: Coefficient) -> Value:
        """Return the coefficient, of this order, of what stays."""
        return self._coefficient(coefficient)

    def _coefficient(self, coefficient: Coefficient) -> Value:
        number: Any = coefficient.number
        parameter = coefficient.parameter
        if parameter is None:
            return self._work.address.function.constant(self._kind, number)
        value = self._field("parameters", parameter)
        if abs(number) != 1.0:
            value = value * abs(number)
        return value if number > 0 else -value

    def _field(self, name: str, place: int) -> Value:
        return self._work.array(name, self._kind)[place]

    def _keep(self, k: int, value: Value) -> None:
        """Store what higher orders need of order 0."""
        if k in self._schedule.zeros:
            self._work.array("zeros", self._kind)[self._schedule.zeros[k]] = value
        if k in self._schedule.reciprocals:
            self._work.array("reciprocals", self._kind)[self._schedule.reciprocals[k]] = 1.0 / value

    def _state(self, place: int) -> Value:
        return self._states[place]

    def _time(self) -> Value:
        return self._field("time", 0)

    def _sum(self, terms: Sequence[tuple[Coefficient, int]], constants: Sequence[Coefficient]) -> Value:
        """Write a linear sum; terms with one factor share it, and what is known last comes last."""
        shared: dict[Coefficient, list[tuple[int, bool]]] = {}
        for coefficient, k in sorted(terms, key=lambda term: term[1]):
            number: Any = coefficient.number
            size = coefficient._replace(number=abs(number))
            shared.setdefault(size, []).append((k, coefficient.number < 0))
        given = list(map(self._coefficient, constants))
        total = functools.reduce(Value.__add__, given) if given else None
        for size, members in sorted(shared.items(), key=lambda item: item[1][-1]):
            total = self._added(total, size, members)
        return self._coefficient(NOTHING) if total is None else total

    def _added(self, total: Value | None, size: Coefficient, members: Sequence[tuple[int, bool]]) -> Value:
        """Write a total and a factor times some values, those that are marked with a minus."""
        if size == Coefficient(1.0):
            return self._signed(total, members)
        negative = members[0][1]
        inner = self._signed(None, [(k, minus != negative) for k, minus in members])
        factor = self._coefficient(size)
        if total is None:
            return -(factor * inner) if negative else factor * inner
        return (-factor if negative else factor).fma(inner, total)

    def _signed(self, total: Value | None, members: Sequence[tuple[int, bool]]) -> Value:
        if total is None:
            (first, minus), *members = sorted(members, key=lambda member: member[1])
            total = -self._values[first] if minus else self._values[first]
        for k, minus in members:
            total = total - self._values[k] if minus else total + self._values[k]
        return total

    def _product(self, first: int, second: int) -> Value:
        return self._values[first] * self._values[second]

    def _quotient(self, numerator: Coefficient | int, denominator: int) -> Value:
        return self._value(numerator) / self._values[denominator]

    def _select(self, condition: int, first: Coefficient | int, second: Coefficient | int) -> Value:
        held = self._work.array("parameters", self._kernel.kind)[condition]
        return held.is_("eq", 0.0).choose(self._value(second), self._value(first))

    def _function(self, *parts: Any) -> Value:
        function = Function(*parts)
        write = wide_functions.elementary if self._kernel.wide else llvm_functions.elementary
        return write(function, list(map(self._value, function.arguments)), self._kernel.lanes)

    def _integral(self, roots: Sequence[int]) -> Value:
        first, *others = (self._values[root] for root in roots)
        return functools.reduce(lambda total, root: root.fma(root, total), others, first * first)


class HigherOrder(ZerothOrder):
    """Writes the coefficients of an order n > 0 of all operations; those of states may be in registers."""

    def __init__(self, kernel: Any, work: Record, n: Value, states: Sequence[Value]) -> None:
        super().__init__(kernel, work)
        self._rows = set(self._schedule.rows)
        self._n, self._states = n, states or kernel.layout.states(work.address, n)
        self._inner: Callable[[int], Value] = kernel.layout.inner_sums(work.address, n)
        self._over_order, self._weight = kernel.over_order(work, n), n.to_double().spread(kernel.lanes)

    @override
    def _constant(self, coefficient: Coefficient) -> Value:
        return self._coefficient(NOTHING)

    @override
    def _keep(self, k: int, value: Value) -> None:
        """Store what inner sums of higher orders read."""
        for row in (Row(k, False), Row(k, True)):
            if row in self._rows:
                kept = value * self._weight if row.weighted else value
                self._kernel.layout.keep(self._work.address, self._n, row, kept)

    def _zero(self, operation: int) -> Value:
        """Return order 0 of an operation."""
        return self._field("zeros", self._schedule.zeros[operation])

    def _inner_sum(self, part: int = 0) -> Value:
        """Return an inner sum of the operation that is written now."""
        return self._inner(self._schedule.places[len(self._values), part])

    @override
    def _time(self) -> Value:
        one = self._n.function.constant(DOUBLE, 1.0)
        rate = self._kernel.in_unit(self._work, one.spread(self._kernel.lanes))
        return self._coefficient(NOTHING).like(self._n.is_("eq", 1).choose(rate, 0.0))

    @override
    def _sum(self, terms: Sequence[tuple[Coefficient, int]], constants: Sequence[Coefficient]) -> Value:
        operations = self._schedule.operations
        return super()._sum([(c, k) for c, k in terms if not isinstance(operations[k], Integral)], ())

    @override
    def _product(self, first: int, second: int) -> Value:
        inner, (early, late) = self._inner_sum(), sorted((first, second))
        if early == late:
            return (2.0 * self._zero(early)).fma(self._values[early], inner)
        # The last step waits for the operand that is known last.
        return self._zero(early).fma(self._values[late], self._zero(late).fma(self._values[early], inner))

    @override
    def _quotient(self, numerator: Coefficient | int, denominator: int) -> Value:
        result = -self._zero(len(self._values)).fma(self._values[denominator], self._inner_sum())
        if isinstance(numerator, int):
            result = self._values[numerator] + result
        return result * self._field("reciprocals", self._schedule.reciprocals[denominator])

    @override
    def _function(self, *parts: Any) -> Value:
        own = varying(Function(*parts))
        inner = [self._inner_sum(i) for i, _, slope in own if isinstance(slope, int)]
        result = self._over_order(sum(inner[1:], inner[0])) if inner else self._coefficient(NOTHING)
        for _, argument, slope in own:
            factor = self._zero(slope) if isinstance(slope, int) else self._coefficient(slope)
            result = factor.fma(self._values[argument], result)
        return result

    @override
    def _integral(self, roots: Sequence[int]) -> Value:
        return self._coefficient(NOTHING)
