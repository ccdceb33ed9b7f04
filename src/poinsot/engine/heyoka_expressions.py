"""A decomposition as expressions of heyoka, and functions compiled from them."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import heyoka as hy

from poinsot import functions
from poinsot.engine.decomposition import (
    Coefficient,
    Decomposition,
    Function,
    Integral,
    Operation,
    Product,
    Quotient,
    Select,
    State,
    Sum,
)

__all__ = ["Expressions"]

ZERO = hy.expression(0.0)


class Expressions:
    """The operations of a decomposition as expressions of the engine.

    Attributes
    ----------
    symbols : list of expressions
        The state variables.
    rates : list of expressions
        Their time derivatives.
    """

    def __init__(self, decomposition: Decomposition) -> None:
        self.symbols = [hy.expression(f"x{i}") for i in range(len(decomposition.rates))]
        self._made: list[Any] = []
        for operation in decomposition.operations:
            self._made.append(self._expression(operation))
        self.rates = self.of(decomposition.rates)

    def of(self, values: Sequence[Coefficient | int]) -> list[Any]:
        """Return values as expressions."""
        return [ZERO + self._of(value) for value in values]

    def compiled(self, values: Sequence[Any], kind: Any) -> Any:
        """Return a compiled function of the variables and, behind them, the time; its values are expressions."""
        time = hy.expression("time")
        outputs = hy.subs([ZERO * time + value for value in values], {hy.time: time})
        return hy.cfunc(outputs, vars=[*self.symbols, time], fp_type=kind)

    def _of(self, value: Coefficient | int) -> Any:
        if not isinstance(value, Coefficient):
            return self._made[value]
        return value.number if value.parameter is None else value.number * hy.par[value.parameter]

    def _expression(self, operation: Operation) -> Any:
        match operation:
            case State(place):
                return self.symbols[place]
            case Sum():
                return self._sum(operation)
            case Product(first, second):
                return self._made[first] ** 2 if first == second else self._made[first] * self._made[second]
            case Quotient(numerator, denominator):
                return self._of(numerator) / self._of(denominator)
            case Select(condition, first, second):
                return hy.select(hy.par[condition], *self.of((first, second)))
            case Function(name, arguments):
                return (operator.pow if name == "pow" else getattr(functions, name))(*self.of(arguments))
            case Integral(roots):
                return hy.sum([self._made[root] ** 2 for root in roots])
            case _:
                return hy.time

    def _sum(self, operation: Sum) -> Any:
        parts: dict[bool, list[Any]] = {True: [], False: []}
        for coefficient, place in operation.terms:
            parts[coefficient.number > 0].append(_times(coefficient, self._made[place]))
        for coefficient in operation.constants:
            parts[coefficient.number > 0].append(_times(coefficient, hy.expression(1.0)))
        positive, negative = (hy.sum(part) if part else None for part in parts.values())
        if negative is None:
            return positive
        return -negative if positive is None else positive - negative


def _times(coefficient: Coefficient, expression: Any) -> Any:
    """Return the size of a coefficient times an expression."""
    if coefficient.parameter is not None:
        expression = hy.par[coefficient.parameter] * expression
    return expression if abs(coefficient.number) == 1 else abs(coefficient.number) * expression
