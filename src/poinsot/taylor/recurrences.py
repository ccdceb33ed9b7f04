"""The recurrences of Taylor coefficients in LLVM's representation: order 0 of all operations, and an order n > 0."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

from typing_extensions import override

from poinsot.taylor.decomposition import Coefficient, CoefficientRow, Invariant, Operand, Schedule, magnitude, varying
from poinsot.taylor.elementary import elementary
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Array, Value
from poinsot.taylor.memory import Work

__all__ = ["HigherOrder", "ZerothOrder"]

ZERO = Coefficient(0.0)

MAX_BLOCK, MAX_UNCUT = 30, 1000
"""Operations of a block of straight-line code, and how many are left in one block: the scheduling of instructions and
the allocation of registers take a time that grows with more than the length of a block."""


class ZerothOrder:
    """Writer of the values of all operations; each kind of operation has a method of its name."""

    def __init__(self, work: Work, schedule: Schedule) -> None:
        self._work, self._context, self._schedule = work, work.context, schedule
        self._states: Array | Sequence[Value] = work.states(0)
        self._values: list[Value] = []

    def outputs(self) -> list[Value]:
        """Write all operations, and return the rates, then the watched functions."""
        large = len(self._schedule.operations) > MAX_UNCUT
        for k, operation in enumerate(self._schedule.operations):
            if large and k % MAX_BLOCK == 0:
                self._work.lines.cut(self._work.array("active", INTEGER)[0].is_("ge", 0))
            write = getattr(self, f"_{type(operation).__name__.lower()}", None)
            if write is None:
                raise TypeError(f"operation must be one with a recurrence, got {operation}.")
            self._values.append(write(*operation))
            self._store(k, self._values[k])
        return list(map(self._value, self._schedule.outputs))

    def _value(self, of: Operand) -> Value:
        return self._values[of] if isinstance(of, int) else self._constant(of)

    def _constant(self, coefficient: Coefficient) -> Value:
        """Return the Taylor coefficient of this order of a constant."""
        return self._coefficient(coefficient)

    def _coefficient(self, coefficient: Coefficient) -> Value:
        number, parameter = coefficient
        if parameter is None:
            return self._work.lines.constant(self._context.number, number)
        value = self._field("parameters", parameter)
        if magnitude(number) != 1.0:
            value = value * magnitude(number)
        return value if number > 0 else -value

    def _field(self, name: str, place: int) -> Value:
        return self._work.numbers(name)[place]

    def _store(self, k: int, value: Value) -> None:
        """Store the values of order 0 that enter higher orders."""
        if k in self._schedule.zeros:
            self._work.numbers("zeros")[self._schedule.zeros[k]] = value
        if k in self._schedule.reciprocals:
            self._work.numbers("reciprocals")[self._schedule.reciprocals[k]] = 1.0 / value

    def _variable(self, place: int) -> Value:
        return self._states[place]

    def _time(self) -> Value:
        return self._field("time", 0)

    def _sum(self, terms: Sequence[tuple[Coefficient, int]], constants: Sequence[Coefficient]) -> Value:
        """Write a linear sum; terms with one factor share it, and the operation that is known last comes last."""
        shared: dict[Coefficient, list[tuple[int, bool]]] = {}
        for coefficient, k in sorted(terms, key=lambda term: term[1]):
            size = coefficient._replace(number=magnitude(coefficient.number))
            shared.setdefault(size, []).append((k, coefficient.number < 0))
        given = list(map(self._coefficient, constants))
        total = functools.reduce(Value.__add__, given) if given else None
        for size, members in sorted(shared.items(), key=lambda item: item[1][-1]):
            total = self._added(total, size, members)
        return self._coefficient(ZERO) if total is None else total

    def _added(self, total: Value | None, size: Coefficient, members: Sequence[tuple[int, bool]]) -> Value:
        """Write a total plus a factor times some values, each with its sign."""
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

    def _quotient(self, numerator: Operand, denominator: int) -> Value:
        return self._value(numerator) / self._values[denominator]

    def _select(self, condition: int, first: Operand, second: Operand) -> Value:
        held = self._work.doubles("parameters")[condition]
        return held.is_("eq", 0.0).choose(self._value(second), self._value(first))

    def _function(self, name: str, arguments: Sequence[Operand], _: Sequence[Operand]) -> Value:
        return elementary(name, arguments, list(map(self._value, arguments)))

    def _invariant(self, roots: Sequence[int]) -> Value:
        first, *others = (self._values[root] for root in roots)
        return functools.reduce(lambda total, root: root.fma(root, total), others, first * first)


class HigherOrder(ZerothOrder):
    """Writer of the coefficients of an order n > 0 of all operations; coefficients of states may be in registers."""

    def __init__(self, work: Work, schedule: Schedule, n: Value, states: Sequence[Value]) -> None:
        super().__init__(work, schedule)
        self._rows = set(schedule.rows)
        self._n, self._states = n, states or work.states(n)
        self._inner: Callable[[int], Value] = self._context.layout.inner_sums(work.address, n)
        self._over_order, self._weight = work.over_order(n), n.to_double().spread(self._context.lanes)

    @override
    def _constant(self, coefficient: Coefficient) -> Value:
        return self._coefficient(ZERO)

    @override
    def _store(self, k: int, value: Value) -> None:
        """Store the rows of inner sums of higher orders."""
        for row in (CoefficientRow(k, False), CoefficientRow(k, True)):
            if row in self._rows:
                stored = value * self._weight if row.weighted else value
                self._context.layout.store(self._work.address, self._n, row, stored)

    def _zero(self, operation: int) -> Value:
        """Return order 0 of an operation."""
        return self._field("zeros", self._schedule.zeros[operation])

    def _inner_sum(self, part: int = 0) -> Value:
        """Return an inner sum of the operation that is written now."""
        return self._inner(self._schedule.places[len(self._values), part])

    @override
    def _time(self) -> Value:
        one = self._n.function.constant(DOUBLE, 1.0)
        rate = self._work.in_unit(one.spread(self._context.lanes))
        return self._coefficient(ZERO).like(self._n.is_("eq", 1).choose(rate, 0.0))

    @override
    def _sum(self, terms: Sequence[tuple[Coefficient, int]], constants: Sequence[Coefficient]) -> Value:
        operations = self._schedule.operations
        return super()._sum([(c, k) for c, k in terms if not isinstance(operations[k], Invariant)], ())

    @override
    def _product(self, first: int, second: int) -> Value:
        inner, (early, late) = self._inner_sum(), sorted((first, second))
        if early == late:
            return (2.0 * self._zero(early)).fma(self._values[early], inner)
        # The last step waits for the operand that is known last.
        return self._zero(early).fma(self._values[late], self._zero(late).fma(self._values[early], inner))

    @override
    def _quotient(self, numerator: Operand, denominator: int) -> Value:
        result = -self._zero(len(self._values)).fma(self._values[denominator], self._inner_sum())
        if isinstance(numerator, int):
            result = self._values[numerator] + result
        return result * self._field("reciprocals", self._schedule.reciprocals[denominator])

    @override
    def _function(self, name: str, arguments: Sequence[Operand], slopes: Sequence[Operand]) -> Value:
        own = varying(arguments, slopes)
        inner = [self._inner_sum(i) for i, _, slope in own if isinstance(slope, int)]
        result = self._over_order(sum(inner[1:], inner[0])) if inner else self._coefficient(ZERO)
        for _, argument, slope in own:
            factor = self._zero(slope) if isinstance(slope, int) else self._coefficient(slope)
            result = factor.fma(self._values[argument], result)
        return result

    @override
    def _invariant(self, roots: Sequence[int]) -> Value:
        return self._coefficient(ZERO)
