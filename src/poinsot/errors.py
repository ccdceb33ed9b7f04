"""Errors, and the checks whose failure is one sentence: `{name} must {rule}, got {what}. {hint}`."""

from __future__ import annotations

import datetime as dt
import importlib
import re
import sys
import warnings
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.dimensions import check_components, names_of
from poinsot.printable import kind_of, quoted
from poinsot.quantities import plain

__all__ = [
    "DATES",
    "PropagationError",
    "PropagationInterrupted",
    "array_of",
    "exactly_one",
    "level_of_user",
    "member_array",
    "optional",
    "real_array",
    "real_numbers",
    "reals_or_nan",
    "refuse_negative",
    "refuse_nonpositive",
    "refuse_other_length",
    "refuse_other_members",
    "refuse_others_than_shares",
    "refuse_outside",
    "refuse_zero",
    "scalar",
    "warn_of_negative",
]

DATES = dt.date | np.datetime64
"""Classes of a date in addition to texts and classes of astropy, which have a time scale instead of a time zone."""

DURATIONS = dt.timedelta | np.timedelta64


class _Stopped(BaseException):
    def __init__(self, message: str, time: float, trajectory: Any) -> None:
        super().__init__(message)
        self.time = time
        self.trajectory = trajectory

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (*self.args, self.time, self.trajectory), vars(self)


class PropagationError(_Stopped, RuntimeError):
    """Error of a propagation that stopped before its last time.

    Attributes
    ----------
    time : float
        Time that the run reached.
    trajectory : Trajectory
        Motion at all requested times before the run stopped.

    Examples
    --------
    >>> body = pt.Body((1.0, 1.0, 1.0))
    >>> start = body.state((0.5**0.5, 0.5**0.5, 0, 0), omega_body=(-1, 0, 0))
    >>> try:
    ...     pt.propagate(pt.System(body), start, [9.0], formulation="euler_angles")
    ... except pt.PropagationError as error:
    ...     print(round(float(error.time), 2))
    1.57
    """


class PropagationInterrupted(_Stopped, KeyboardInterrupt):
    """Interruption of a propagation by Ctrl-C, with the attributes of `PropagationError`.

    Examples
    --------
    >>> issubclass(pt.PropagationInterrupted, KeyboardInterrupt)
    True
    """


def real_array(
    name: str, value: Any, shape: tuple[int | None, ...], time_unit: str | None = None
) -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape; `None` in the shape is any length."""
    array = real_numbers(name, value, time_unit)
    others = [n for n, m in zip(shape, array.shape, strict=False) if n not in (None, m)]
    if others or array.ndim != len(shape):
        raise ValueError(f"{name} must have shape {_written(shape)}, got shape {array.shape}.")
    return array


def member_array(name: str, value: Any, shape: tuple[int, ...], axes: str = "") -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape, or with one leading member axis more."""
    if names := names_of(value):
        check_components(name, names, len(shape))
    array = real_numbers(name, value)
    if array.shape[max(array.ndim - len(shape), 0) :] != shape or array.ndim > len(shape) + 1 or 0 in array.shape:
        members, along = _written(("members", *shape)), f" along the {axes}" if axes else ""
        raise ValueError(f"{name} must have shape {_written(shape)} or {members}{along}, got shape {array.shape}.")
    return array


def real_numbers(name: str, value: Any, time_unit: str | None = None) -> NDArray[np.float64]:
    """Return `value` as finite floats of any shape; a quantity of time in a unit."""
    array = reals_or_nan(name, value, time_unit)
    _refuse_infinite(name, array)
    return array


def _refuse_infinite(name: str, array: Any) -> None:
    """Raise a ValueError that shows the first number of an array that is infinite or NaN."""
    finite = np.isfinite(array)
    if np.count_nonzero(finite) < finite.size:  # in a fifth of the time of `all`
        where = tuple(int(i) for i in np.argwhere(~finite)[0])
        place = f"{name}[{', '.join(map(str, where))}]" if where else name
        raise ValueError(f"{name} must be finite, got {place} = {np.asarray(array)[where]}.")


def reals_or_nan(name: str, value: Any, time_unit: str | None = None) -> NDArray[np.float64]:
    """Return `value` as floats of any shape, finite or not; a quantity of time in a unit."""
    array = array_of(name, value, time_unit)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be real numbers, got {kind_of(value)} {quoted(value)}.{_hint(name, array)}")
    return array.astype(float, copy=False)


def _hint(name: str, array: NDArray[Any]) -> str:
    """Return how dates and durations become numbers; nothing of other values."""
    first = array.flat[0] if array.size else None
    if isinstance(first, DURATIONS):
        return f" Durations become numbers: np.array({name}, 'm8[us]') / np.timedelta64(1, 's')."
    if isinstance(first, DATES) or hasattr(first, "jd1") or (isinstance(first, str) and re.match(r"\d{4}-\d", first)):
        return f" A calendar makes numbers of dates: {name}=pt.Calendar('2026-01-01T00:00:00', 'UTC').time(dates)."
    return ""


def scalar(name: str, value: Any) -> Any:
    """Return a finite number, an array or an expression, of the kind that is given, for a formula."""
    if value.__class__ in (np.ndarray, np.float64) and value.dtype == np.float64:
        _refuse_infinite(name, value)
        return value
    value = plain(name, value)
    real = not isinstance(value, np.ndarray | np.generic) or value.dtype.kind in "ifuO"
    each: Any = (value,)
    if isinstance(value, np.ndarray):
        each = value.flat if value.dtype == object else ()
    if real and all(isinstance(one, float | np.generic) or _is_symbolic(one) for one in each):
        if isinstance(value, float | np.generic | np.ndarray) and np.asarray(value).dtype != object:
            _refuse_infinite(name, value)
        return value
    return real_numbers(name, value)[()]


def _is_symbolic(value: Any) -> bool:
    """Return True for a value that formulas accept but that is not a float: a symbol, an mpmath number or a node."""
    kind = type(value)
    known = kind.__module__.partition(".")[0] in ("sympy", "mpmath", __name__.partition(".")[0])
    return known and hasattr(kind, "__neg__") and not hasattr(kind, "__getitem__")


def array_of(name: str, value: Any, time_unit: str | None = None) -> NDArray[Any]:
    """Return any value without a unit or a mask as an array, of objects where it is no rectangle of numbers."""
    value = plain(name, value, time_unit)
    try:
        return np.array(value)
    except Exception:  # rows of unequal length, or a class of the user's own
        return np.array(None)


def refuse_nonpositive(name: str, value: Any, hint: str = "") -> None:
    """Raise a ValueError that shows the first number that is not positive."""
    wrong = np.atleast_1d(value)[np.atleast_1d(value) <= 0]
    if wrong.size:
        raise ValueError(f"{name} must be positive, got {wrong.flat[0]}. {hint}".rstrip())


def refuse_negative(name: str, value: Any, hint: str = "") -> None:
    """Raise a ValueError that shows the least number if it is negative."""
    if np.any(np.asarray(value) < 0):
        raise ValueError(f"{name} must not be negative, got {np.min(value)}. {hint}".rstrip())


def refuse_outside(low: float, high: float, limits: str, name: str, value: Any, hint: str = "") -> None:
    """Raise a ValueError that shows the first number outside limits, which a text describes: "from 0 to pi"."""
    numbers = np.ravel(value)
    wrong = numbers[(numbers < low) | (numbers > high)]
    if wrong.size:
        raise ValueError(f"{name} must be {limits}, got {wrong[0]:.10g}. {hint}".rstrip())


def refuse_others_than_shares(name: str, value: Any, hint: str = "") -> None:
    """Raise a ValueError that shows a number outside of [0, 1]."""
    refuse_negative(name, value, hint)
    if np.any(np.asarray(value) > 1):
        raise ValueError(f"{name} must be at most 1, got {np.max(value)}. {hint}".rstrip())


def warn_of_negative(name: str, value: Any, hint: str = "") -> None:
    """Warn at the user's line, with the least number, if it is negative."""
    if np.any(np.asarray(value) < 0):
        sentence = f"{name} should not be negative, got {np.min(value)}. {hint}".rstrip()
        warnings.warn(sentence, stacklevel=level_of_user())


def level_of_user() -> int:
    """Return the stack level, as seen by the caller, of the first line outside the package.

    The generated `__init__` of a record of the user is no such line.
    """
    frame: FrameType | None = sys._getframe(1)
    level = 1
    while frame and (
        frame.f_globals.get("__name__", "").partition(".")[0] == __name__.partition(".")[0]
        or (frame.f_code.co_filename, frame.f_code.co_name) == ("<string>", "__init__")
    ):
        frame, level = frame.f_back, level + 1
    return level


def refuse_zero(name: str, vector: Any, hint: str = "") -> None:
    """Raise a ValueError if a vector, shape (..., n), is zero."""
    if np.any(np.all(np.asarray(vector) == 0, axis=-1)):
        raise ValueError(f"{name} must not be zero, got all components 0. {hint}".rstrip())


def refuse_other_length(name: str, vector: Any, hint: str = "") -> None:
    """Raise a ValueError if a direction, shape (..., 3), is no unit vector to 1e-9."""
    lengths = np.ravel(np.linalg.norm(vector, axis=-1))
    worst = lengths[np.argmax(np.abs(lengths - 1))]
    if abs(worst - 1) > 1e-9:
        raise ValueError(f"{name} must be a unit vector, got length {worst:.10g}. {hint}".rstrip())


def refuse_other_members(**counts: tuple[int, ...]) -> None:
    """Raise a ValueError unless those shapes of members, by name, that are not () are equal."""
    (first, members), *others = [(name, count) for name, count in counts.items() if count] or [("", ())]
    for name, count in others:
        if count != members:
            raise ValueError(f"{name} must have as many members as {first}, got {count[0]} and {members[0]}.")


def exactly_one(what: str, given: dict[str, Any]) -> tuple[str, Any]:
    """Return name and value of the one that is given, or raise a ValueError."""
    chosen = [(name, value) for name, value in given.items() if value is not None]
    if len(chosen) != 1:
        named = " and ".join(name for name, _ in chosen) or "none"
        raise ValueError(f"{what} must have exactly one of {', '.join(given)}, got {named}.")
    return chosen[0]


def optional(name: str, purpose: str, extra: str = "sky") -> Any:
    """Return a module of an extra, or raise an ImportError that says how to install it."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        package = name.partition(".")[0]
        raise ImportError(
            f"{package} must be installed for {purpose}, got none. `pip install 'poinsot[{extra}]'` brings it."
        ) from None


def _written(shape: tuple[Any, ...]) -> str:
    names = ["n" if n is None else str(n) for n in shape]
    return f"({names[0]},)" if len(names) == 1 else f"({', '.join(names)})"
