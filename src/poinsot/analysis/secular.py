"""Averaged evolution of a rotation under effects whose rates of change add up."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times
from poinsot.errors import real_array
from poinsot.printable import described, kind_of, quoted, shortened
from poinsot.quantities import Array, Times

__all__ = ["SecularEvolution", "secular_evolution"]

Result = TypeVar("Result")

Effect = Callable[[Mapping[str, float]], Mapping[str, float]]

STEP_TOLERANCE = 1e-11
"""Relative tolerance of a step."""

MIN_VARIABLE = 1e-14
"""Size of a variable, relative to its initial value, below which its error does not count."""

MAX_STEP = 0.01 + 1e-9
"""Largest step of the integrator, divided by the total time; 101 evenly spaced times require 100 steps."""

MAX_STRETCH = 1.1
"""Ratio of the first step after a time to the longest step before it: rounding must not leave a tiny second step."""

TIME_TOLERANCE = 4 * np.finfo(float).eps
"""Relative tolerance of the time of a zero."""

SAMPLES_PER_STEP = 10
"""Number of times in each step at which `until` is evaluated."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class SecularEvolution(Summarized):
    """Averaged variables of a rotation as functions of time.

    Attributes
    ----------
    times : array (n,)
        Times that the evolution reached.
    values : mapping
        Variables by name, each an array (n,).
    stopped : float or None
        Time at which the evolution stopped before the last requested time, or None.

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
        lines = {
            "times": formatted_times(self.times),
            **{name: formatted(values) for name, values in self.values.items()},
        }
        return "SecularEvolution", {**lines, "stopped": formatted(self.stopped)}


@checked
def secular_evolution(
    effects: Sequence[Effect],
    start: Mapping[str, float],
    times: Times,
    *,
    until: Callable[[Mapping[str, float]], float] | None = None,
) -> SecularEvolution:
    """Integrate averaged variables under the sum of the rates of change of all effects.

    Each step of the integrator ends at the next of the times or earlier, and is at most a hundredth of the total time.
    An effect that acts for a third of such a step is integrated. The function `until` is evaluated at ten times in each
    step and detects two zeros that are a tenth of a step apart. More times resolve shorter events.

    Parameters
    ----------
    effects : sequence of functions
        Functions of a mapping of the variables by name. Each returns the rates of change of some variables by name.
        `YorpCoefficients.drift` makes such a function, for "rate" and "obliquity".
    start : mapping
        Variables by name at the first time.
    times : array (n,)
        Strictly ascending times.
    until : function, optional
        Function of the mapping of the variables. The evolution stops where the sign of its value changes or its value
        is zero, also at the first time.

    Returns
    -------
    SecularEvolution
        Variables at the times that the evolution reached.

    Raises
    ------
    ValueError
        If an effect uses or changes an unknown variable, the times do not ascend, or rates of change become infinite.

    Examples
    --------
    >>> def warming(state):
    ...     return {"rate": 0.5, "obliquity": -0.1 / state["rate"]}
    >>> found = pt.analysis.secular_evolution([warming, warming], {"rate": 1.0, "obliquity": 1.0}, [0.0, 1.0])
    >>> found.values["obliquity"].round(4)
    array([1.    , 0.8614])
    """
    names, values = list(start), [float(real_array(_checked_name(name), value, ())) for name, value in start.items()]
    at = _ascending(times)

    def state_of(values: Array) -> dict[str, float]:
        return dict(zip(names, map(float, values), strict=True))

    def slope(_: float, values: Array) -> Array:
        return np.array(_summed(effects, state_of(values)))

    def reached(values: Array) -> float:
        return float(real_array("value of until", _called(until, state_of(values), "until"), ())) if until else 1.0

    rows, before = [np.array(values)], reached(np.array(values))
    stopped = None if before else float(at[0])
    for solver in _steps(slope, at, rows[0]) if before else ():
        if until:
            stopped, before = _zero_in_step(reached, solver, before)
        if solver.t == solver.t_bound and stopped in (None, solver.t):
            rows.append(solver.y)
        if stopped is not None:
            break
    return SecularEvolution(at[: len(rows)], dict(zip(names, np.transpose(rows), strict=True)), stopped)


def _ascending(times: Times) -> Array:
    """Return two or more ascending times."""
    at = real_array("times", times, (None,))
    if len(at) < 2 or np.any(np.diff(at) <= 0):
        raise ValueError(f"times must be two at least and ascend, got {formatted(at) or 'none'}.")
    return at


def _steps(slope: Callable[[float, Array], Array], at: Array, y: Array) -> Iterator[Any]:
    """Yield the integrator after each step; steps end at all times."""
    from scipy.integrate import DOP853

    least: Any = MIN_VARIABLE * np.where(y, np.abs(y), 1.0)
    longest, step = MAX_STEP * (at[-1] - at[0]), np.inf
    for begin, end in itertools.pairwise(at):
        first_step = min(MAX_STRETCH * step, end - begin) if step < np.inf else None
        solver: Any = DOP853(slope, begin, y, end, longest, STEP_TOLERANCE, least, first_step=first_step)
        step = 0.0
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise ValueError(f"effects must have finite rates of change, got others at t = {solver.t:g}: {message}")
            step = max(step, solver.step_size)
            yield solver
        y = solver.y


def _zero_in_step(reached: Callable[[Array], float], solver: Any, before: float) -> tuple[float | None, float]:
    """Return the first time in the last step at which a function of the variables is zero, and its last value.

    The function is sampled at equal intervals. Its value at the start of the step is not zero.
    """
    from scipy.optimize import brentq

    between, start = solver.dense_output(), solver.t_old

    def value(t: float) -> float:
        return reached(solver.y if t == solver.t else between(t))

    for k in range(1, SAMPLES_PER_STEP + 1):
        end = solver.t if k == SAMPLES_PER_STEP else solver.t_old + k * solver.step_size / SAMPLES_PER_STEP
        now = value(end)
        if now == 0:
            return float(end), now
        if (now > 0) != (before > 0):
            return float(brentq(value, start, end, xtol=TIME_TOLERANCE * solver.step_size, rtol=TIME_TOLERANCE)), now
        start, before = end, now
    return None, before


def _summed(effects: Sequence[Effect], state: Mapping[str, float]) -> list[float]:
    """Return the sums of the rates of change, in the order of the variables."""
    total = dict.fromkeys(state, 0.0)
    for effect in effects:
        rates = _called(effect, state, "An effect")
        if not isinstance(rates, Mapping):
            raise TypeError(f"effects must return mappings of rates of change by name, got {kind_of(rates)}.")
        for name, rate in rates.items():
            if name not in total:
                raise ValueError(f"effects must change variables of the start, {', '.join(state)}, got {quoted(name)}.")
            total[name] += float(real_array(f"the rate of change of {name}", rate, ()))
    return list(total.values())


def _called(function: Callable[[Mapping[str, float]], Result], state: Mapping[str, float], reader: str) -> Result:
    """Return the value of a user's function of the variables."""
    try:
        return function(state)
    except KeyError as error:
        known = ", ".join(state) or "none"
        raise ValueError(f"start must have the variable {error}, got {known}. {reader} reads it.") from None


def _checked_name(name: Any) -> str:
    """Return the name of a variable for error messages."""
    if not isinstance(name, str):
        raise TypeError(f"start must be a mapping of numbers by names, got a name that is {described(name)}.")
    return shortened(name)
