"""Arithmetic between runtime parameters, done once for a run and not at every step.

A formula that multiplies two parameters, or takes the cosine of one, makes a derived constant. Only the
constants that meet a variable of the motion become parameters of the kernel; their values follow from the
numbers of a system by replaying the arithmetic, for one body or for arrays of members.

A formula on variables makes multiples: a number, a constant and an expression of the variables, whose product
is not taken before a sum needs it, so that 2 (3 (a x)) costs one operation of the kernel.
"""

from __future__ import annotations

import functools
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot import functions as formulas
from poinsot.algebra.dual import Dual
from poinsot.functions import Combining, Commuting, Vector

__all__ = ["Constant", "Constants", "Multiple"]


LARGEST_POWER = 256
"""Whole powers up to this one are products, which have derivatives at zero; the engine's power divides by its base."""

POWERS: dict[Any, Callable[[Any, Any, Any], Any]] = {
    operator.add: lambda a, b, _: a or b,
    operator.sub: lambda a, b, _: a or b,
    operator.mul: lambda a, b, _: a + b,
    operator.truediv: lambda a, b, _: a - b,
    operator.neg: lambda a, _, __: a,
    operator.pow: lambda a, _, exponent: a * exponent,
    formulas.sqrt: lambda a, _, __: a / 2,
}
"""The power of what a function makes of two arguments, from theirs and the number that the second one is."""


NEUTRAL = {operator.add: 0, operator.sub: 0, operator.mul: 1}
"""The operand that leaves the other one as it is; of a difference the second."""


class Constants:
    """The constants of one kernel: numbered places, those of inputs and literal numbers filled from outside."""

    def __init__(self) -> None:
        self._count = 0
        self._inputs: list[int] = []
        self._literals: dict[float, int] = {}
        self._recipes: dict[int, tuple[Callable[..., Any], tuple[int, ...]]] = {}
        self._known: dict[Any, Constant] = {}
        self._parameters: dict[int, Any] = {}
        self._factors: list[Any] = []
        self._numbered: dict[Any, int] = {}
        self._conditions: dict[Any, int] = {}
        self._roots: dict[Any, int] = {}
        self.stand_ins: dict[Any, Any] = {}  # symbols in formulas, and the functions of the variables they stand for

    def _new_place(self) -> int:
        self._count += 1
        return self._count - 1

    def inputs(self) -> Iterator[Constant]:
        """Yield one constant after another, for the numbers that a run is given, in order."""
        while True:
            self._inputs.append(self._new_place())
            yield Constant(self, self._inputs[-1])

    def variable(self, expression: Any) -> Multiple:
        """Return a variable of the motion, or the time, for formulas that also have constants."""
        number = self._numbered.setdefault(expression, len(self._factors))
        self._factors[number:] = self._factors[number:] or [expression]
        return Multiple(self, 1.0, None, (number,))

    def factor(self, number: int) -> Any:
        """Return the expression of a factor."""
        return self._factors[number]

    def derived(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Constant:
        """Return the constant that a function makes of constants and numbers."""
        places = tuple(map(self._place, arguments))
        if (function, places) not in self._known:
            self._known[function, places] = derived = Constant(self, self._new_place())
            self._recipes[derived.place] = function, places
        return self._known[function, places]

    def _place(self, argument: Any) -> int:
        if isinstance(argument, Constant):
            return argument.place
        if argument not in self._literals:
            self._literals[argument] = self._new_place()
        return self._literals[argument]

    def parameter(self, constant: Constant | Condition) -> Any:
        """Return the kernel's parameter for a constant that meets a variable, or for a condition."""
        return self._parameters.setdefault(constant.place, hy.par[self.next_parameter()])

    def next_parameter(self) -> int:
        """Return the number of the first parameter that none of the constants has."""
        return len(self._parameters)

    def expression(self, scalar: Any) -> Any:
        """Return a scalar of a formula as an expression of the engine, or as the number it is."""
        if isinstance(scalar, Multiple):
            return scalar.whole
        return self.parameter(scalar) if isinstance(scalar, Constant) else scalar

    def condition(self, function: Any) -> Condition:
        """Return the condition that a function of the variables is negative."""
        function = self.expression(function)
        if function not in self._conditions:
            self._conditions[function] = self._new_place()
        return Condition(self, self._conditions[function])

    def root(self, argument: Any) -> Multiple:
        """Return the square root of a function of the variables, plus a parameter that is zero but from rest."""
        argument = self.expression(argument)
        function = hy.subs(argument, self.stand_ins)
        if function not in self._roots:
            self._roots[function] = self._new_place()
        return self.variable(formulas.sqrt(argument + self.parameter(Constant(self, self._roots[function]))))

    @property
    def roots(self) -> list[tuple[Any, int]]:
        """The functions under square roots, and the numbers of their parameters."""
        places = {place: number for number, place in enumerate(self._parameters)}
        return [(function, places[place]) for function, place in self._roots.items()]

    @property
    def conditions(self) -> list[tuple[Any, int]]:
        """The functions of the conditions on which a formula branches, and the numbers of their parameters."""
        places = {place: number for number, place in enumerate(self._parameters)}
        return [(function, places[place]) for function, place in self._conditions.items() if place in places]

    def values(self, numbers: Sequence[Any]) -> list[Any]:
        """Return the values of the kernel's parameters for the numbers of a run, scalars or arrays.

        Those of conditions change on the way, those of roots at a start; they are zero here.
        """
        # one input more was named than there are numbers
        known = {**self._fixed, **dict(zip(self._inputs, numbers, strict=False))}
        with np.errstate(all="ignore"):  # a constant that is not finite stops the run with a sentence
            for place, function, places in self._needed:
                known[place] = function(*map(known.__getitem__, places))
        return [known[place] for place in self._parameters]

    def derivatives(self, inputs: Iterable[int]) -> dict[int, Any]:
        """Return the derivatives of the kernel's parameters by a common change of inputs: those that are not zero."""
        return self._differentiated(dict(enumerate(self._parameters)), inputs)

    def second_derivatives(self, inputs: Iterable[int], others: Iterable[int]) -> dict[int, Any]:
        """Return the second derivatives of the kernel's parameters by two changes of inputs."""
        slopes = {n: x.place for n, x in self.derivatives(inputs).items() if isinstance(x, Constant)}
        return self._differentiated(slopes, others)

    def _differentiated(self, places: dict[int, int], inputs: Iterable[int]) -> dict[int, Any]:
        known: dict[int, Any] = {place: number for number, place in self._literals.items()}
        known |= {self._inputs[i]: Dual(Constant(self, self._inputs[i]), {"change": 1}) for i in inputs}
        for place, (function, arguments) in list(self._recipes.items()):
            values = [known.get(argument, Constant(self, argument)) for argument in arguments]
            if any(isinstance(value, Dual) for value in values):
                known[place] = function(*values)
        found = {n: known.get(place) for n, place in places.items()}
        slopes = {n: dual.partials["change"] for n, dual in found.items() if isinstance(dual, Dual)}
        return {n: slope for n, slope in slopes.items() if not _is(slope, 0)}

    @functools.cached_property
    def powers(self) -> NDArray[np.int_]:
        """To which power of the first input each of the kernel's parameters goes: all are homogeneous in it."""
        known: dict[int, Any] = {self._inputs[0]: 1}
        literals = {place: number for number, place in self._literals.items()}
        for place, function, places in self._needed:
            first, second = (*places, *places)[:2]
            powers = known.get(first, 0), known.get(second, 0)
            known[place] = POWERS[function](*powers, literals.get(second, 0)) if function in POWERS else 0
        return np.array([known.get(place, 0) for place in self._parameters], dtype=int)

    @functools.cached_property
    def _fixed(self) -> dict[int, Any]:
        """The values that no run changes."""
        literals = {place: number for number, place in self._literals.items()}
        return {**dict.fromkeys([*self._conditions.values(), *self._roots.values()], 0.0), **literals}

    @functools.cached_property
    def _needed(self) -> list[tuple[int, Callable[..., Any], tuple[int, ...]]]:
        """The recipes on which the parameters depend, in order; asked for when the equations are complete."""
        needed = set(self._parameters)
        for place in reversed(self._recipes):
            if place in needed:
                needed.update(self._recipes[place][1])
        return [(place, *recipe) for place, recipe in self._recipes.items() if place in needed]


class Constant(Combining):
    """A number of a run; arithmetic with numbers and constants gives constants, with variables expressions."""

    def __init__(self, home: Constants, place: int) -> None:
        self.home, self.place = home, place

    def combined(self, operation: Callable[..., Any], *operands: Any) -> Any:
        """Return the constant that an operation makes of constants and numbers; zero and one are no operands."""
        if not all(isinstance(operand, Constant | int | float) for operand in operands):
            return NotImplemented
        neutral = NEUTRAL.get(operation)
        if operation is operator.mul and any(_is(operand, 0) for operand in operands):
            return 0.0
        if _is(operands[-1], neutral):
            return operands[0]
        if operation is not operator.sub and _is(operands[0], neutral):
            return operands[1]
        return self.home.derived(operation, operands)

    def __bool__(self) -> bool:
        raise TypeError("a formula must not branch with `if` on a value, but it does.")

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function of scalars, this one among them."""
        return self.combined(getattr(formulas, name), *arguments)


class Condition:
    """Whether a function of the variables is negative: a parameter that changes where the function has a zero."""

    def __init__(self, home: Constants, place: int) -> None:
        self.home, self.place = home, place

    def __bool__(self) -> bool:
        raise TypeError("a formula must not branch with `if` on a value, but it does.")

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return `where` of this condition and two scalars."""
        condition, *branches = arguments
        if name != "where" or condition is not self:
            raise TypeError(f"{name} must be of numbers, got a condition.")
        if any(isinstance(branch, Dual) for branch in branches):
            return NotImplemented
        branches = [self.home.expression(branch) for branch in branches]
        return self.home.variable(hy.select(self.home.parameter(self), *branches))


class Multiple(Commuting):
    """A number times a constant (or None) times the product of factors, expressions of the variables."""

    __array_ufunc__ = None

    def __init__(self, home: Constants, number: float, constant: Constant | None, factors: tuple[int, ...]) -> None:
        self.home, self.number, self.constant, self.factors = home, number, constant, factors

    @property
    def expression(self) -> Any:
        """The product of the factors, the highest powers first, for they are what products have in common."""
        powers = Counter(self.factors)
        ordered = sorted(powers, key=lambda factor: (-powers[factor], factor))
        return functools.reduce(operator.mul, (_power(self.home.factor(factor), powers[factor]) for factor in ordered))

    @property
    def size(self) -> Any:
        """The expression times constant and number, without the sign."""
        if self.constant is not None:
            return self.home.parameter(abs(self.number) * self.constant) * self.expression
        return self.expression if abs(self.number) == 1 else abs(self.number) * self.expression

    @property
    def whole(self) -> Any:
        """The expression times constant and number."""
        return -self.size if self.number < 0 else self.size

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Vector | Dual):
            return NotImplemented
        if isinstance(other, Multiple):
            return self._sum(other)
        if _is(other, 0):
            return self
        if self.constant is None:  # c + n x = n (c/n + x)
            return self.number * self.home.variable(self.home.expression(other / self.number) + self.expression)
        term = self.home.expression(other)
        return self.home.variable(term - self.size if self.number < 0 else term + self.size)

    def _sum(self, other: Multiple) -> Any:
        if self.factors == other.factors:
            return (self._coefficient + other._coefficient) * Multiple(self.home, 1.0, None, self.factors)
        if self.constant is other.constant and abs(self.number) == abs(other.number):
            x, y = self.expression, other.expression
            total = self.home.variable(x + y if self.number == other.number else x - y)
            return Multiple(self.home, self.number, self.constant, total.factors)
        if self.number < 0 and other.number < 0:
            return -self.home.variable(self.size + other.size)
        if self.number < 0:
            return self.home.variable(other.size - self.size)
        return self.home.variable(self.size - other.size if other.number < 0 else self.size + other.size)

    @property
    def _coefficient(self) -> Any:
        return self.number if self.constant is None else self.number * self.constant

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Vector | Dual):
            return NotImplemented
        if isinstance(other, Multiple):
            return self._product(other)
        if _is(other, 0):
            return 0.0
        if isinstance(other, Constant):
            return Multiple(self.home, self.number, _times(self.constant, other), self.factors)
        return Multiple(self.home, self.number * other, self.constant, self.factors)

    def _product(self, other: Multiple) -> Multiple:
        """Return the product; a constant with one factor is multiplied in, for that may serve other products."""
        number, constant = self.number * other.number, _times(self.constant, other.constant)
        if (self.constant is None) != (other.constant is None):
            scaled, plain = (other, self) if self.constant is None else (self, other)
            if len(scaled.factors) == 1:
                sized = self.home.variable(Multiple(self.home, abs(number), constant, scaled.factors).size)
                number, constant = math.copysign(1.0, number), None
                return Multiple(self.home, number, constant, _merged(sized.factors, plain.factors))
        return Multiple(self.home, number, constant, _merged(self.factors, other.factors))

    def __neg__(self) -> Multiple:
        return Multiple(self.home, -self.number, self.constant, self.factors)

    def __sub__(self, other: Any) -> Any:
        return NotImplemented if isinstance(other, Vector | Dual) else self + (-other)

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Multiple):
            return self._applied(operator.truediv, self, other)
        return NotImplemented if isinstance(other, Vector | Dual) else self * (1 / other)

    def __pow__(self, power: Any) -> Any:
        if not (isinstance(power, int | float) and 0 <= power <= LARGEST_POWER and power == int(power)):
            return self._applied(operator.pow, self, power)
        n = int(power)
        constant = None if self.constant is None else self.constant**n
        return Multiple(self.home, self.number**n, constant, self.factors * n) if n else 1.0

    def __rtruediv__(self, other: Any) -> Any:
        return self._applied(operator.truediv, other, self)

    def __rpow__(self, base: Any) -> Any:
        return self._applied(operator.pow, base, self)

    def apply(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """Return an elementary function of scalars, this one among them."""
        if name == "less" and not any(isinstance(argument, Dual) for argument in arguments):
            return self.home.condition(arguments[0] - arguments[1])
        if name == "sqrt":
            return self.home.root(self)
        return self._applied(getattr(formulas, name), *arguments)

    def _applied(self, function: Callable[..., Any], *arguments: Any) -> Any:
        if any(isinstance(argument, Dual) for argument in arguments):
            return NotImplemented
        return self.home.variable(function(*map(self.home.expression, arguments)))


def _power(x: Any, n: int) -> Any:
    """Return x^n, n > 0, as products of squares: half the engine's work for a product, and no division by x."""
    if n == 1:
        return x
    square = _power(x, n // 2) ** 2
    return square * x if n % 2 else square


def _times(a: Constant | None, b: Constant | None) -> Constant | None:
    return b if a is None else a if b is None else a * b


def _merged(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(a + b))


def _is(value: Any, number: int | None) -> bool:
    return isinstance(value, int | float) and value == number
