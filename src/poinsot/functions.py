"""Functions for formulas: one function for floats, arrays, SymPy expressions and mpmath numbers.

A formula receives scalars, each of one of these kinds, and vectors of three scalars. It consists of `+ - * / **` and
the functions of this module. It must not branch on the values of scalars with `if`; `where` selects between two values.

>>> pt.functions.interp(1.5, (0.0, 1.0, 2.0), (0.0, 10.0, 30.0)), pt.functions.where(pt.functions.less(1, 2), 3.0, 4.0)
(array(20.), array(3.))
>>> pt.functions.cross((1, 0, 0), (0, 1, 0))
Vector((0, 0, 1))
"""

from __future__ import annotations

import builtins
import operator
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn, Protocol, TypeVar, cast

import numpy as np

from poinsot.printable import described, kind_of, quoted
from poinsot.suggestions import refuse_name

__all__ = [
    "Vector",
    "abs",
    "acos",
    "asin",
    "atan",
    "atan2",
    "clip",
    "cos",
    "cross",
    "dot",
    "eccentric_anomaly",
    "exp",
    "interp",
    "less",
    "log",
    "maximum",
    "minimum",
    "norm",
    "pi",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
    "where",
]

pi = float(np.pi)


class Scalar(Protocol):
    """A number in a formula: a float, an array of floats, a SymPy expression, an mpmath number or a node of a graph.

    Operators return a scalar of the kind of the operands.
    """

    def __add__(self, other: Any, /) -> Scalar: ...
    def __radd__(self, other: Any, /) -> Scalar: ...
    def __sub__(self, other: Any, /) -> Scalar: ...
    def __rsub__(self, other: Any, /) -> Scalar: ...
    def __mul__(self, other: Any, /) -> Scalar: ...
    def __rmul__(self, other: Any, /) -> Scalar: ...
    def __truediv__(self, other: Any, /) -> Scalar: ...
    def __rtruediv__(self, other: Any, /) -> Scalar: ...
    def __pow__(self, other: Any, /) -> Scalar: ...
    def __neg__(self) -> Scalar: ...
    def __abs__(self) -> Scalar: ...
    def __lt__(self, other: Any, /) -> Any: ...
    def __gt__(self, other: Any, /) -> Any: ...
    def __ge__(self, other: Any, /) -> Any: ...


Kind = TypeVar("Kind", bound=Scalar)


class FunctionOfScalar(Protocol):
    """Function whose value is of the kind of its argument."""

    __name__: str

    def __call__(self, scalar: Kind, /) -> Kind: ...


def _by_components(operation: Callable[[Scalar, Scalar], Scalar]) -> Callable[[Vector, Any], Vector]:
    return lambda vector, other: vector._each(operation, other)


def _of_sums(operation: Callable[[Scalar, Scalar], Scalar]) -> Callable[[Vector, Any], Vector]:
    def summed(vector: Vector, other: Any) -> Vector:
        if isinstance(other, np.ndarray) and other.ndim:
            raise TypeError(
                f"a Vector must be added to vectors and numbers, got an array of shape {other.shape}. "
                "np.stack(vector, axis=-1) converts the vector."
            )
        return vector._each(operation, other)

    return summed


class Vector(Sequence[Any]):
    """Vector in a formula: components that are scalars of any kind, with `+ - * /` by components.

    An array that multiplies or divides a vector contains one number for each member or time. A sum of a vector and an
    array is ambiguous and raises a TypeError.

    Parameters
    ----------
    scalars : iterable of scalars
        Components of the vector.

    Examples
    --------
    >>> 2 * pt.functions.Vector((1.0, 0.0, 0.5)) + pt.functions.Vector((0, 1, 0))
    Vector((2.0, 1.0, 1.0))
    """

    __array_ufunc__ = None  # an array times a vector is the vector's business

    def __init__(self, scalars: Iterable[Any]) -> None:
        self._scalars = tuple(scalars)

    def __len__(self) -> int:
        return len(self._scalars)

    def __getitem__(self, index: Any) -> Any:
        return self._scalars[index]

    def __repr__(self) -> str:
        return f"Vector({self._scalars})"

    def _each(self, operation: Callable[[Scalar, Scalar], Scalar], other: Any) -> Vector:
        others = other if isinstance(other, Vector) else (other,) * len(self)
        return Vector(operation(a, b) for a, b in zip(self, others, strict=True))

    def __rsub__(self, other: Any) -> Vector:
        return (-self).__radd__(other)

    def __neg__(self) -> Vector:
        return Vector(-a for a in self)

    __add__ = __radd__ = _of_sums(operator.add)
    __sub__ = _of_sums(operator.sub)
    __mul__ = __rmul__ = _by_components(operator.mul)
    __truediv__ = _by_components(operator.truediv)


class Comparable:
    """The comparisons of a kind of scalar: the conditions that `less` makes."""

    __slots__ = ()

    def __lt__(self, other: Any) -> Any:
        return less(cast("Scalar", self), other)

    def __gt__(self, other: Any) -> Any:
        return less(other, cast("Scalar", self))

    def __le__(self, other: Any) -> Any:
        raise TypeError("a formula must compare by < or >, as poinsot.functions.less(a, b) does, got <= or >=.")

    __ge__ = __le__


class ComovingVector(Vector):
    """A vector of the space, by its components along axes that move; formulas may not look at those.

    Sums, multiples, `dot`, `cross` and `norm` of such vectors do not depend on the axes. Anything else (a
    single component, a sum with a vector fixed in space) raises `NotComoving`.
    """

    def __getitem__(self, index: Any) -> Any:
        raise NotComoving

    @property
    def components(self) -> tuple[Any, ...]:
        """The components along the moving axes, for the mechanics alone."""
        return self._scalars

    def _each(self, operation: Callable[[Scalar, Scalar], Scalar], other: Any) -> Vector:
        if isinstance(other, ComovingVector):
            return ComovingVector(map(operation, self.components, other.components))
        if isinstance(other, Vector | tuple | list) or np.ndim(other):
            raise NotComoving
        return ComovingVector(operation(a, other) for a in self.components)

    def __neg__(self) -> Vector:
        return ComovingVector(-a for a in self.components)


class NotComoving(Exception):  # noqa: N818
    """A formula depends on the space axes themselves, and cannot be evaluated along moving ones."""


def _engine(*scalars: Scalar) -> Any:
    for scalar in scalars:
        name = type(scalar).__module__.partition(".")[0]
        if name in ("sympy", "mpmath"):
            return sys.modules[name]
    return np


def _own(name: str, scalars: tuple[Scalar, ...]) -> tuple[Scalar] | None:
    """Return, wrapped, what a scalar with rules of its own makes of a function; None if there is none."""
    for scalar in scalars:
        if hasattr(scalar, "apply"):
            value = scalar.apply(name, scalars)
            if value is not NotImplemented:
                return (value,)
    return None


ELEMENTARY = {
    "sqrt": ("square root", "4.0", "2.0"),
    "exp": ("exponential function", "0.0", "1.0"),
    "log": ("natural logarithm", "1.0", "0.0"),
    "sin": ("sine of an angle in radians", "0.5", "0.479"),
    "cos": ("cosine of an angle in radians", "0.5", "0.878"),
    "tan": ("tangent of an angle in radians", "0.5", "0.546"),
    "tanh": ("hyperbolic tangent", "0.5", "0.462"),
    "rint": ("nearest integer", "1.4", "1.0"),
    "asin": ("inverse sine, an angle in [-pi/2, pi/2]", "1.0", "1.571"),
    "acos": ("inverse cosine, an angle in [0, pi]", "0.0", "1.571"),
    "atan": ("inverse tangent, an angle in (-pi/2, pi/2)", "1.0", "0.785"),
    "atan2": ("angle of the point (x, y) in [-pi, pi], from y and x", "1.0, -1.0", "2.356"),
}
"""Meaning of each elementary function, and the arguments and the value of an example."""

DESCRIPTION = """Return the {meaning}.

Parameters
----------
*scalars : {count}
    Float, array, SymPy expression or mpmath number.

Returns
-------
scalar
    Value of the same kind.

Examples
--------
>>> round(float(pt.functions.{name}({arguments})), 3)
{value}
"""


def _elementary(name: str) -> Any:
    def function(*scalars: Scalar) -> Any:
        if own := _own(name, scalars):
            return own[0]
        if any(isinstance(scalar, np.ndarray) and scalar.dtype == object for scalar in scalars):
            of_arrays: Any = np.frompyfunc(function, len(scalars), 1)
            return of_arrays(*scalars)
        try:
            return getattr(_engine(*scalars), name)(*scalars)
        except (TypeError, ValueError, AttributeError):
            for other in filter(_is_no_number, scalars):
                given = f"{kind_of(other)} {quoted(other)}"
                raise TypeError(f"{name} must have numbers or arrays of them, got {given}.") from None
            raise

    function.__name__ = name
    meaning, arguments, value = ELEMENTARY[name]
    count = "two scalars" if "," in arguments else "one scalar"
    function.__doc__ = DESCRIPTION.format(meaning=meaning, count=count, name=name, arguments=arguments, value=value)
    return function


sqrt: FunctionOfScalar = _elementary("sqrt")
exp: FunctionOfScalar = _elementary("exp")
log: FunctionOfScalar = _elementary("log")
sin: FunctionOfScalar = _elementary("sin")
cos: FunctionOfScalar = _elementary("cos")
tan: FunctionOfScalar = _elementary("tan")
tanh: FunctionOfScalar = _elementary("tanh")
rint: FunctionOfScalar = _elementary("rint")
asin: FunctionOfScalar = _elementary("asin")
acos: FunctionOfScalar = _elementary("acos")
atan: FunctionOfScalar = _elementary("atan")
atan2: Callable[[Scalar, Scalar], Scalar] = _elementary("atan2")


def less(a: Scalar, b: Scalar) -> Any:
    """Return the condition a < b for `where`; `a < b` and `b > a` give the same condition.

    Parameters
    ----------
    a, b : scalar
        Scalars to compare.

    Returns
    -------
    condition
        True where a < b.

    Examples
    --------
    >>> pt.functions.less(1, 2)
    True
    """
    if own := _own("less", (a, b)):
        return own[0]
    return a < b


def where(condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
    """Return a where the condition holds and b elsewhere; both values are evaluated.

    Parameters
    ----------
    condition : condition
        Result of `less`.
    a, b : scalar
        Value where the condition holds, and value elsewhere.

    Returns
    -------
    scalar
        Selected value.

    Examples
    --------
    >>> float(pt.functions.where(pt.functions.less(1, 2), 3.0, 4.0))
    3.0
    """
    if own := _own("where", (condition, a, b)):
        return own[0]
    engine = _engine(condition, a, b)
    if engine.__name__ == "sympy":
        chosen: Scalar = engine.Piecewise((a, condition), (b, True))
    elif engine.__name__ == "mpmath":
        chosen = a if condition else b
    else:
        chosen = engine.where(condition, a, b)
    return chosen


def minimum(a: Scalar, b: Scalar) -> Scalar:
    """Return the smaller of two scalars.

    Parameters
    ----------
    a, b : scalar
        Scalars to compare.

    Returns
    -------
    scalar
        Smaller value.

    Examples
    --------
    >>> float(pt.functions.minimum(1.0, 2.0))
    1.0
    """
    return where(less(a, b), a, b)


def maximum(a: Scalar, b: Scalar) -> Scalar:
    """Return the larger of two scalars.

    Parameters
    ----------
    a, b : scalar
        Scalars to compare.

    Returns
    -------
    scalar
        Larger value.

    Examples
    --------
    >>> float(pt.functions.maximum(1.0, 2.0))
    2.0
    """
    return where(less(a, b), b, a)


def clip(x: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """Return x limited to the interval [low, high].

    Parameters
    ----------
    x : scalar
        Value to limit.
    low, high : scalar
        Limits, low <= high.

    Returns
    -------
    scalar
        low if x < low, high if x > high, otherwise x.

    Examples
    --------
    >>> float(pt.functions.clip(1.5, -1.0, 1.0))
    1.0
    """
    return minimum(maximum(x, low), high)


def abs(x: Scalar) -> Scalar:  # noqa: A001
    """Return the absolute value of a scalar.

    Parameters
    ----------
    x : scalar
        Float, array, SymPy expression or mpmath number.

    Returns
    -------
    scalar
        Absolute value |x|.

    Examples
    --------
    >>> float(pt.functions.abs(-1.5))
    1.5
    """
    return where(less(x, 0), -x, x)


def sign(x: Scalar) -> Scalar:
    """Return the sign of a scalar: -1, 0 or 1.

    Parameters
    ----------
    x : scalar
        Float, array, SymPy expression or mpmath number.

    Returns
    -------
    scalar
        -1 if x is negative, 0 if it is zero, 1 if it is positive.

    Examples
    --------
    >>> float(pt.functions.sign(-1.5))
    -1.0
    """
    return where(less(x, 0), -1.0, where(less(0, x), 1.0, 0.0))


def interp(x: Scalar, places: Sequence[Scalar], values: Sequence[Scalar]) -> Scalar:
    """Return the piecewise linear interpolation of a table, constant outside its first and last place.

    Parameters
    ----------
    x : scalar
        Place of the result.
    places : sequence of scalars
        Places of the table, ascending. A field annotated `Annotated[Any, (5,)]` contains five.
    values : sequence of scalars
        Values at the places, equally many.

    Returns
    -------
    scalar
        Interpolated value.

    Raises
    ------
    ValueError
        If the table is empty, the numbers of places and values differ, or places that are numbers do not ascend.

    Examples
    --------
    >>> float(pt.functions.interp(1.5, (0.0, 1.0, 2.0), (0.0, 10.0, 30.0)))
    20.0
    """
    if len(places) != len(values) or not len(places):
        raise ValueError(f"values must be as many as places, at least one, got {len(values)} and {len(places)}.")
    if isinstance(places[0], float | int) and np.any(np.diff(np.asarray(places, dtype=float)) <= 0):
        raise ValueError(f"places must ascend, got {list(places)}.")
    found = values[0]
    for here, there, value, following in zip(places, places[1:], values, values[1:], strict=False):
        found = where(less(x, here), found, value + (following - value) / (there - here) * (x - here))
    return where(less(x, places[-1]), found, values[-1])


def dot(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Return the scalar product a . b of two vectors.

    Parameters
    ----------
    a, b : iterable of scalars
        Vectors with equally many components.

    Returns
    -------
    scalar
        Sum of the products of the components.

    Examples
    --------
    >>> pt.functions.dot((1, 2, 3), (1, 0, 2))
    7
    """
    a, b, _ = _opened(a, b)
    try:
        first, *others = (x * y for x, y in zip(a, b, strict=True))
    except (TypeError, ValueError):
        _check_vectors("dot", "of equally many scalars, at least one", range(1, sys.maxsize), a, b)
        raise
    return sum(others, start=first)


def cross(a: Iterable[Scalar], b: Iterable[Scalar]) -> Vector:
    """Return the vector product a x b of two vectors of three scalars.

    Parameters
    ----------
    a, b : iterable of three scalars
        Vectors.

    Returns
    -------
    Vector
        Vector product.

    Examples
    --------
    >>> pt.functions.cross((1, 0, 0), (0, 1, 0))
    Vector((0, 0, 1))
    """
    a, b, kind = _opened(a, b)
    try:
        (a1, a2, a3), (b1, b2, b3) = a, b
        return kind((a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1))
    except (TypeError, ValueError):
        _check_vectors("cross", "of three scalars", range(3, 4), a, b)
        raise


def _opened(a: Iterable[Scalar], b: Iterable[Scalar]) -> tuple[Iterable[Scalar], Iterable[Scalar], type[Vector]]:
    if isinstance(a, ComovingVector) and isinstance(b, ComovingVector):
        return a.components, b.components, ComovingVector
    return a, b, Vector


def _check_vectors(name: str, rule: str, counts: range, *vectors: Any) -> None:
    """Raise an error that names what is no vector, or the numbers of scalars if they are others."""
    for vector in vectors:
        if not isinstance(vector, Iterable) or isinstance(vector, str | bytes):
            raise TypeError(f"{name} must have two vectors {rule}, got {described(vector)}.")
    first, second = (len(tuple(vector)) for vector in vectors)
    if first != second or first not in counts:
        raise ValueError(f"{name} must have two vectors {rule}, got {first} and {second}.")


def _is_no_number(value: Any) -> bool:
    """Return True if a value is neither a number nor an array of numbers."""
    return not hasattr(type(value), "__neg__") or getattr(value, "dtype", np.dtype(float)).kind not in "biufcO"


def norm(a: Iterable[Scalar]) -> Scalar:
    """Return the Euclidean length of a vector.

    Parameters
    ----------
    a : iterable of scalars
        Components of the vector.

    Returns
    -------
    scalar
        Square root of a . a.

    Examples
    --------
    >>> float(pt.functions.norm((3.0, 0.0, 4.0)))
    5.0
    """
    if not isinstance(a, Vector):
        if not isinstance(a, Iterable) or isinstance(a, str | bytes):
            raise TypeError(f"norm must have a vector of scalars, got {described(a)}.")
        a = tuple(a)
    return sqrt(dot(a, a))


def angle_between(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Return the angle between two vectors of any length, from 0 to pi, without loss of digits at 0 and pi."""
    return atan2(norm(cross(a, b)), dot(a, b))


def eccentric_anomaly(eccentricity: Scalar, mean_anomaly: Scalar) -> Scalar:
    """Return the eccentric anomaly E of Kepler's equation E - e sin E = M.

    Parameters
    ----------
    eccentricity : scalar
        Eccentricity e, 0 <= e < 1.
    mean_anomaly : scalar
        Mean anomaly M in radians.

    Returns
    -------
    scalar
        Eccentric anomaly E in radians.

    Examples
    --------
    >>> round(float(pt.functions.eccentric_anomaly(0.1, 1.0)), 4)
    1.0886
    """
    if own := _own("eccentric_anomaly", (eccentricity, mean_anomaly)):
        return own[0]
    engine = _engine(eccentricity, mean_anomaly)
    if engine.__name__ == "sympy":
        raise TypeError("eccentric_anomaly must have numbers, got a SymPy expression.")
    full_turns = 2 * engine.pi * engine.floor(mean_anomaly / (2 * engine.pi) + 0.5)
    reduced = mean_anomaly - full_turns
    anomaly = reduced + 0.85 * eccentricity * engine.sign(engine.sin(reduced))
    enough = 0.01 * (np.finfo(float).eps if engine is np else engine.eps) ** (1 / 3)
    elongated = engine is not np or np.any(eccentricity > 0.5)
    for _ in range(80):  # Halley's method from Danby's start; a handful of rounds, more only at e -> 1
        sine, cosine = engine.sin(0.5 * anomaly), engine.cos(0.5 * anomaly)
        slope = (1 - eccentricity) + 2 * eccentricity * sine * sine
        curvature = 2 * eccentricity * sine * cosine
        excess = anomaly - curvature - reduced
        if elongated:
            near = (1 - eccentricity) * anomaly + eccentricity * sine_defect(anomaly)
            excess = where(less(builtins.abs(anomaly), 2), near - reduced, excess)
        step = excess / (slope - excess * curvature / (2 * slope))
        anomaly = anomaly - step
        if np.all(builtins.abs(step) <= enough * builtins.abs(anomaly)):  # the next one would be the cube of that
            break
    eccentric: Scalar = full_turns + anomaly
    return eccentric


def sine_defect(angle: Scalar) -> Scalar:
    """Return x - sin x to machine precision, also near zero."""
    if own := _own("sine_defect", (angle,)):
        return own[0]
    engine = _engine(angle)
    far = angle - engine.sin(angle)
    return far if engine.__name__ == "sympy" else _defect(engine, angle, -1, far)


def asinh_defect(x: Scalar) -> Scalar:
    """Return x - asinh x to machine precision, also near zero."""
    if own := _own("asinh_defect", (x,)):
        return own[0]
    engine = _engine(x)
    angle = engine.asinh(x)
    return x - angle if engine.__name__ == "sympy" else _defect(engine, angle, 1, x - angle)


def _defect(engine: Any, angle: Scalar, sign: int, far: Scalar) -> Scalar:
    """Return the series x^3/3! + sign x^5/5! + ... below |x| = 2, and beyond it what is computed as a difference.

    A kernel chooses at the start of each step.
    """
    is_near = less(angle * angle, 4)
    near = where(is_near, angle, 0 * angle)
    square, series = near * near, cast("Scalar", 1)
    for k in range(40 if engine.__name__ == "mpmath" else 14, 0, -1):
        series = 1 + sign * square / ((2 * k + 2) * (2 * k + 3)) * series
    return where(is_near, near * square * series / 6, far)


def __getattr__(name: str) -> NoReturn:
    if name.startswith("_"):
        raise AttributeError(name=name, obj=sys.modules[__name__])
    refuse_name(__name__, name, __all__)


def __dir__() -> list[str]:
    return __all__
