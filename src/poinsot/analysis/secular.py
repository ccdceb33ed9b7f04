"""Averaged evolution of a rotation: effects whose rates of change add up."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.errors import real_array
from poinsot.html_text import Summarized, told, told_times
from poinsot.printable import described, kind_of, quoted, shortened
from poinsot.quantities import Times

__all__ = ["SecularEvolution", "secular_evolution"]

Array = NDArray[np.float64]
Effect = Callable[[Mapping[str, float]], Mapping[str, float]]

TOLERANCE = 1e-11
"""Relative, of a step."""

LEAST = 1e-14
"""Of a variable, over its start, below which its error does not count."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class SecularEvolution(Summarized):
    """Averaged variables of a rotation at times.

    Attributes
    ----------
    times : array (n,)
        Those that were reached.
    values : mapping
        The variables by name, each an array (n,).
    stopped : float or None
        The time at which the evolution stopped before its last time; None if it did not.

    Examples
    --------
    >>> def drag(state):
    ...     return {"rate": -0.1 * state["rate"]}
    >>> pt.analysis.secular_evolution([drag], {"rate": 2.0}, [0.0, 10.0]).values["rate"].round(4)
    array([2.    , 0.7358])
    """

    times: Array
    values: Mapping[str, Array]
    stopped: float | None = None

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        lines = {"times": told_times(self.times), **{name: told(values) for name, values in self.values.items()}}
        return "SecularEvolution", {**lines, "stopped": told(self.stopped)}


@checked
def secular_evolution(
    effects: Sequence[Effect],
    start: Mapping[str, float],
    times: Times,
    *,
    until: Callable[[Mapping[str, float]], float] | None = None,
) -> SecularEvolution:
    """Return how averaged variables evolve, under the sum of the rates of change of all effects.

    Parameters
    ----------
    effects : sequence of functions
        Each of a mapping of the variables by name; it returns the rates of change of those that it changes, by name.
        `YorpCoefficients.drift` makes one, of "rate" and "obliquity".
    start : mapping
        The variables by name at the first time.
    times : array (n,)
        Strictly ascending.
    until : function, optional
        Of the variables, as an effect is; the evolution stops where it becomes zero.

    Returns
    -------
    SecularEvolution

    Raises
    ------
    ValueError
        If an effect reads or changes what is no variable, the times do not ascend, or rates of change become infinite.

    Examples
    --------
    >>> def warming(state):
    ...     return {"rate": 0.5, "obliquity": -0.1 / state["rate"]}
    >>> found = pt.analysis.secular_evolution([warming, warming], {"rate": 1.0, "obliquity": 1.0}, [0.0, 1.0])
    >>> found.values["obliquity"].round(4)
    array([1.    , 0.8614])
    """
    from scipy.integrate import solve_ivp

    names, values = list(start), [float(real_array(_checked_name(name), value, ())) for name, value in start.items()]
    at = real_array("times", times, (None,))
    if len(at) < 2 or np.any(np.diff(at) <= 0):
        raise ValueError(f"times must be two at least and ascend, got {told(at) or 'none'}.")

    def state_of(values: Array) -> dict[str, float]:
        return dict(zip(names, map(float, values), strict=True))

    def slope(_: float, values: Array) -> list[float]:
        return _summed(effects, state_of(values))

    def reached(_: float, values: Array) -> float:
        return float(real_array("what until returns", until(state_of(values)), ())) if until else 1.0

    floor = np.where(values, np.abs(values), 1.0)
    reached.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(slope, (at[0], at[-1]), values, "DOP853", at, rtol=TOLERANCE, atol=LEAST * floor, events=reached)
    if found.status < 0:
        raise ValueError(
            f"effects must have finite rates of change, got others at t = {found.t[-1]:g}: {found.message}"
        )
    events: Any = found.t_events
    stopped = float(events[0][0]) if found.status else None
    return SecularEvolution(found.t, dict(zip(names, found.y, strict=True)), stopped)


def _summed(effects: Sequence[Effect], state: Mapping[str, float]) -> list[float]:
    """Return the sums of the rates of change, in the order of the variables."""
    total = dict.fromkeys(state, 0.0)
    for effect in effects:
        try:
            rates = effect(state)
        except KeyError as error:
            hint = "An effect reads it."
            raise ValueError(
                f"start must have the variable {error}, got {', '.join(state) or 'none'}. {hint}"
            ) from None
        if not isinstance(rates, Mapping):
            raise TypeError(f"effects must return mappings of rates of change by name, got {kind_of(rates)}.")
        for name, rate in rates.items():
            if name not in total:
                raise ValueError(f"effects must change variables of the start, {', '.join(state)}, got {quoted(name)}.")
            total[name] += float(real_array(f"the rate of change of {name}", rate, ()))
    return list(total.values())


def _checked_name(name: Any) -> str:
    """Return the name of a variable for error messages."""
    if not isinstance(name, str):
        raise TypeError(f"start must be a mapping of numbers by names, got a name that is {described(name)}.")
    return shortened(name)
