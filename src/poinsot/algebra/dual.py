"""Derivatives of formulas: forward differentiation of a value and its partial derivatives, rule by rule.

Values and partials are scalars of any kind (floats, arrays, heyoka or SymPy expressions, mpmath numbers), so
that one derivative serves kernels, diagnostics and proofs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from poinsot import functions
from poinsot.functions import Commuting, Scalar, Vector

__all__ = ["Dual", "composed", "partial", "seeded"]


class Dual(Commuting):
    """A scalar and its partial derivatives, by the name of the variable."""

    __array_ufunc__ = None

    def __init__(self, value: Scalar, partials: Mapping[Any, Scalar]) -> None:
        self.value = value
        self.partials = partials

    def chain(self, value: Scalar, slope: Scalar) -> Dual:
        """Return a function of this scalar, from its value and its derivative."""
        return Dual(value, {name: _times(slope, partial) for name, partial in self.partials.items()})

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return NotImplemented
        other = _dual(other)
        shared = {name: self.partials[name] + p for name, p in other.partials.items() if name in self.partials}
        return Dual(self.value + other.value, {**self.partials, **other.partials, **shared})

    def __neg__(self) -> Dual:
        return self.chain(-self.value, -1)

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return NotImplemented
        if not isinstance(other, Dual):
            return self.chain(self.value * other, other)
        value = self.value * other.value
        if other is self:
            return self.chain(value, 2 * self.value)
        return Dual(value, (self.chain(value, other.value) + other.chain(value, self.value)).partials)

    def __truediv__(self, other: Any) -> Any:
        return self * (other**-1 if isinstance(other, Dual) else 1 / other)

    def __pow__(self, power: Any) -> Dual:
        if isinstance(power, Dual):
            exponential: Dual = functions.exp(power * functions.log(self))
            return exponential
        if isinstance(power, int | float) and power == 0:
            return self.chain(1.0, 0.0)
        return self.chain(self.value**power, power * self.value ** (power - 1))

    def __rtruediv__(self, other: Any) -> Any:
        return other * self**-1

    def __rpow__(self, base: Any) -> Dual:
        exponential: Dual = functions.exp(self * functions.log(base))
        return exponential

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function of scalars, this one among them."""
        if name == "less":
            return functions.less(*(_dual(argument).value for argument in arguments))
        if name == "where":
            return _where(*arguments)
        if name == "atan2":
            y, x = map(_dual, arguments)
            size2 = x.value * x.value + y.value * y.value
            value = functions.atan2(y.value, x.value)
            return Dual(value, (y.chain(0, x.value / size2) + x.chain(0, -y.value / size2)).partials)
        if name == "eccentric_anomaly":
            e, M = map(_dual, arguments)
            E = functions.eccentric_anomaly(e.value, M.value)
            slope = 1 / (1 - e.value * functions.cos(E))
            return Dual(E, (M.chain(0, slope) + e.chain(0, slope * functions.sin(E))).partials)
        if name not in SLOPES:
            raise TypeError(f"{name} must not depend on the attitude in a potential, but it does.")
        value = getattr(functions, name)(self.value)
        return self.chain(value, SLOPES[name](self.value, value))


SLOPES: Mapping[str, Callable[[Scalar, Scalar], Scalar]] = {
    "sqrt": lambda x, y: 0.5 / y,  # noqa: ARG005
    "exp": lambda x, y: y,  # noqa: ARG005
    "sine_defect": lambda x, y: 1 - functions.cos(x),  # noqa: ARG005
    "log": lambda x, y: 1 / x,  # noqa: ARG005
    "sin": lambda x, y: functions.cos(x),  # noqa: ARG005
    "cos": lambda x, y: -functions.sin(x),  # noqa: ARG005
    "tan": lambda x, y: 1 + y * y,  # noqa: ARG005
    "asin": lambda x, y: 1 / functions.sqrt(1 - x * x),  # noqa: ARG005
    "acos": lambda x, y: -1 / functions.sqrt(1 - x * x),  # noqa: ARG005
    "atan": lambda x, y: 1 / (1 + x * x),  # noqa: ARG005
    "tanh": lambda x, y: 1 - y * y,  # noqa: ARG005
}


def seeded(scalars: Iterable[Scalar], block: Any) -> Vector:
    """Return the scalars as variables named (block, 0), (block, 1), ..., besides what they depend on already."""
    duals = map(_dual, scalars)
    return Vector(Dual(dual.value, {**dual.partials, (block, i): 1}) for i, dual in enumerate(duals))


def partial(expression: Any, block: Any, index: int) -> Scalar:
    """Return the derivative of a result with respect to one variable."""
    return _dual(expression).partials.get((block, index), 0.0)


def composed(function: Callable[[Scalar], Scalar], scalar: Scalar) -> Scalar:
    """Return a function of one scalar; its derivative is taken once, whatever the number of variables behind it."""
    if not isinstance(scalar, Dual):
        return function(scalar)
    inner = _dual(function(Dual(scalar.value, {"inner": 1})))
    return scalar.chain(inner.value, inner.partials.get("inner", 0.0))


def _where(condition: Any, a: Any, b: Any) -> Dual:
    a, b = _dual(a), _dual(b)
    names = {**a.partials, **b.partials}
    return Dual(
        functions.where(condition, a.value, b.value),
        {name: functions.where(condition, a.partials.get(name, 0.0), b.partials.get(name, 0.0)) for name in names},
    )


def _dual(scalar: Any) -> Dual:
    return scalar if isinstance(scalar, Dual) else Dual(scalar, {})


def _times(a: Scalar, b: Scalar) -> Scalar:
    """Return a b, without a trace of the ones that seeds bring."""
    return a if isinstance(b, int) and b == 1 else a * b
