"""Errors, and the checks whose failure is one sentence: `{name} must {rule}, but {what came}. {hint}`."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "PropagationError",
    "PropagationInterrupted",
    "member_array",
    "optional",
    "real_array",
    "real_numbers",
    "refuse_nonpositive",
]


class _Stopped(BaseException):
    def __init__(self, message: str, time: float, trajectory: Any) -> None:
        super().__init__(message)
        self.time = time
        self.trajectory = trajectory


class PropagationError(_Stopped, RuntimeError):
    """A run stopped before its last time.

    Attributes
    ----------
    time : float
        The time reached.
    trajectory : Trajectory
        What was computed: every requested time that was reached before the run stopped.
    """


class PropagationInterrupted(_Stopped, KeyboardInterrupt):
    """A run was stopped by Ctrl-C; it has the attributes of `PropagationError`."""


def real_array(name: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape; `None` in the shape is any length."""
    array = real_numbers(name, value)
    if len(array.shape) != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        raise ValueError(f"{name} must have shape {_written(shape)}, but shape {array.shape} came.")
    return array


def member_array(name: str, value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape, or with one leading member axis more."""
    array = real_numbers(name, value)
    if array.shape[max(array.ndim - len(shape), 0) :] != shape or array.ndim > len(shape) + 1 or 0 in array.shape:
        members = _written(("members", *shape))
        raise ValueError(f"{name} must have shape {_written(shape)} or {members}, but shape {array.shape} came.")
    return array


def real_numbers(name: str, value: Any) -> NDArray[np.float64]:
    """Return `value` as finite floats of any shape."""
    try:
        array = np.array(value)
    except ValueError:  # rows of unequal length
        array = np.array(None)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be real numbers, but {type(value).__name__} {_short(value)} came.")
    array = array.astype(float)
    if not np.all(np.isfinite(array)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        place = f"{name}[{', '.join(map(str, where))}]" if where else name
        raise ValueError(f"{name} must be finite, but {place} = {array[where]}.")
    return array


def refuse_nonpositive(name: str, value: Any) -> None:
    """Raise a ValueError that shows the first number that is not positive."""
    wrong = np.atleast_1d(value)[np.atleast_1d(value) <= 0]
    if wrong.size:
        raise ValueError(f"{name} must be positive, but {wrong.flat[0]} came.")


def optional(name: str, purpose: str) -> Any:
    """Return a module of the extra `sky`, or raise an ImportError that says how to install it."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        package = name.partition(".")[0]
        raise ImportError(
            f"{package} must be installed for {purpose}, but it is not. `pip install 'poinsot[sky]'` brings it."
        ) from None


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _written(shape: tuple[Any, ...]) -> str:
    names = ["n" if n is None else str(n) for n in shape]
    return f"({names[0]},)" if len(names) == 1 else f"({', '.join(names)})"
