"""Errors, and the checks whose failure is one sentence: `{name} must {rule}, but {what came}. {hint}`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["PropagationError", "member_array", "real_array"]


class PropagationError(RuntimeError):
    """A run stopped before its last time.

    Attributes
    ----------
    time : float
        The time reached.
    trajectory : Trajectory
        What was computed: every requested time that was reached before the run stopped.
    """

    def __init__(self, message: str, time: float, trajectory: Any) -> None:
        super().__init__(message)
        self.time = time
        self.trajectory = trajectory


def real_array(name: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape; `None` in the shape is any length."""
    array = _floats(name, value)
    if len(array.shape) != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        raise ValueError(f"{name} must have shape {_written(shape)}, but shape {array.shape} came.")
    return array


def member_array(name: str, value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return `value` as finite floats of the given shape, or with one leading member axis more."""
    array = _floats(name, value)
    if array.shape[max(array.ndim - len(shape), 0) :] != shape or array.ndim > len(shape) + 1:
        members = _written(("members", *shape))
        raise ValueError(f"{name} must have shape {_written(shape)} or {members}, but {array.shape} came.")
    return array


def _floats(name: str, value: Any) -> NDArray[np.float64]:
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be real numbers, but {type(value).__name__} {_short(value)} came.") from None
    if not np.all(np.isfinite(array)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        place = f"{name}[{', '.join(map(str, where))}]" if where else name
        raise ValueError(f"{name} must be finite, but {place} = {array[where]}.")
    return array


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _written(shape: tuple[Any, ...]) -> str:
    names = ["n" if n is None else str(n) for n in shape]
    return f"({names[0]},)" if len(names) == 1 else f"({', '.join(names)})"
