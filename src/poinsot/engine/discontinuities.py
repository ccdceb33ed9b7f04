"""What changes on the way of a run: the pieces of tables, and the conditions on which formulas branch.

A Taylor polynomial sees neither a knot of a table nor a branch of `where`. So both are held in parameters of the
kernel, and each change is a terminal event of the engine: the step ends there, the parameters change, and the next
step begins with the other formula.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot.engine.kernel_watch import AT_ONCE
from poinsot.engine.problem import Problem

__all__ = [
    "LARGE",
    "SMALL",
    "Discontinuities",
    "Pieces",
    "event_class",
    "lane_of",
    "time_scale",
]

SMALL, LARGE = 0.05, 0.5
"""What the functions of events are scaled to, and where they are scaled anew.

The engine's step control looks at them as at the variables, of which the attitude is of size one.
"""

BLIND = 1e-13
"""Ten times the time after a zero in which the engine does not look for the next one, times the scaled derivative."""

SHORT = 0.01
"""Part of the time in which the attitude changes, within which the polynomial of the last step holds."""

NEVER = 1e300
"""A time that no run reaches."""

BLOCK = 256
"""Pieces whose parameters are computed together."""

KEPT = 8
"""Blocks that are kept during a run."""


class Pieces:
    """The values of a kernel's constants in each piece between two knots of a system.

    Parameters
    ----------
    problem : Problem
    values : callable
        A problem without knots to the constants, numbers that broadcast to (pieces, members).
    """

    def __init__(self, problem: Problem, values: Callable[[Problem], tuple[Any, ...]]) -> None:
        self.problem, self.knots, self._values = problem, problem.knots, values
        self._blocks: dict[int, list[Any]] = {}

    def at(self, time: float, forwards: bool) -> int:
        """Return the number of the piece in which a motion goes on from a time."""
        return int(np.searchsorted(self.knots, time, side="right" if forwards else "left"))

    def values(self, piece: int, member: int) -> list[float]:
        """Return the constants of a piece, which is the one before the knot of this number."""
        block, place = divmod(piece - 1, BLOCK)
        if block not in self._blocks:
            if len(self._blocks) >= KEPT:
                self._blocks.clear()
            self._blocks[block] = self._computed(block)
        return [value[min(place, len(value) - 1), min(member, value.shape[1] - 1)] for value in self._blocks[block]]

    def _computed(self, block: int) -> list[Any]:
        problem = self.problem
        if self.knots.size:
            knots = self.knots[block * BLOCK : (block + 1) * BLOCK + 1]
            problem = problem.between_knots(0.5 * (knots[1:] + knots[:-1])[:, None])
        return [np.atleast_2d(value) for value in self._values(problem)]


class Discontinuities:
    """The events of one integrator, and the parameters that they change.

    Parameters
    ----------
    functions : list of expressions
        What is negative where each condition holds.
    places : list of int
        The parameters that hold the conditions.
    look : compiled function
        Of variables and time: the functions, their derivatives along the motion, and those of the attitude.
    first : int
        The number of the first parameter that nothing else has.
    lanes : int
    kind : type
        Of the numbers.

    Attributes
    ----------
    look : callable
        Of engine and lane: lets the user's events happen that are due where something changes; whether the motion
        goes on.
    jump : callable or None
        Of engine, lane, the time within which all is at once, and the conditions before and behind a switch: lets
        tangent vectors jump; whether the motion goes on. None where nothing jumps.
    scales : Scales
        Those of the momenta, the kernel's.
    spans : array (lanes,)
        The times that the run takes.
    """

    def __init__(
        self,
        functions: list[Any],
        places: list[int],
        look: Any,
        first: int,
        lanes: int,
        kind: Any,
    ) -> None:
        self.look: Callable[[Any, int], bool] = lambda _engine, _lane: True
        self.jump: Callable[[Any, int, float, NDArray[Any], NDArray[Any]], bool] | None = None
        self.scales: Any = None
        self._forwards = True
        self._pieces: Any = None
        self._members: NDArray[np.int_] = np.zeros(lanes, dtype=int)
        self._piece = np.zeros(lanes, dtype=int)
        self._ends, self._due, self.spans = np.zeros((3, lanes))
        self._places, self._look = places, look
        self._fixed = np.setdiff1d(np.arange(first), places)
        self._scales, self._lifts = first + np.arange(2 * len(functions)).reshape(2, -1)
        self._sizes = np.zeros((lanes, len(functions)))
        self._stop = first + 2 * len(functions)
        build = event_class(lanes, kind)
        places_of_each = zip(functions, self._scales, self._lifts, strict=True)
        scaled = [hy.par[scale] * function + hy.par[lift] for function, scale, lift in places_of_each]
        self.events = [build(function, callback=self._crossing(i)) for i, function in enumerate(scaled)]
        self.events += [build(0.1 * (f**2 - LARGE**2), callback=self._growing(i)) for i, f in enumerate(scaled)]
        self.events.append(build(alarm(self._stop), callback=self._entering()))

    def begin(self, engine: Any, pieces: Pieces, forwards: bool, members: NDArray[np.int_]) -> None:
        """Set the parameters for the time and the state of an integrator, of all its lanes.

        `members` are those in the lanes, looked at and never changed here.
        """
        self._pieces, self._forwards, self._members = pieces, forwards, members
        self._sizes[:] = 0.0
        engine.pars[self._places] = 0.0  # a run depends on nothing that the one before it has left
        for lane, time in enumerate(np.ravel(engine.time)):
            self._enter(engine, lane, pieces.at(float(time), forwards))

    def repeat(self, busy: int, idle: NDArray[np.int_]) -> None:
        """Let lanes follow another one."""
        for own in (self._piece, self._sizes, self._ends, self._due):
            own[idle] = own[busy]

    @property
    def parameters(self) -> int:
        """The number of the first parameter behind its own."""
        return int(self._stop + 2)

    @property
    def _sign(self) -> int:
        return 1 if self._forwards else -1

    # ------------------------------------------------------------------ events

    # The engine copies what it is given, but for plain functions.

    def _entering(self) -> Callable[..., bool]:
        def entered(engine: Any, _: int, lane: int = 0) -> bool:
            if self._due[lane] * self._sign < self._ends[lane] * self._sign:
                self._come_back(engine, lane, NEVER)
                goes_on = self.switch(engine, lane)
            else:
                goes_on = self._enter(engine, lane, self._piece[lane] + self._sign)
            return goes_on and self.look(engine, lane)

        return entered

    def _crossing(self, number: int) -> Callable[..., bool]:
        def crossed(engine: Any, slope: int, lane: int = 0) -> bool:
            return self._switched(engine, lane, lambda: switched(engine, slope, lane))

        def switched(engine: Any, slope: int, lane: int) -> bool:
            self.settle(engine, lane)
            before = np.array(lane_of(engine.state, lane))
            if not self.look(engine, lane):
                return False
            if not slope:
                self._lift(engine, lane)
            if not slope or np.any(lane_of(engine.state, lane) != before):
                return True
            holds = (slope < 0) == self._forwards
            place = self._places[number]
            lane_of(engine.pars, lane)[place] = holds
            found, count = self._values_of_functions(engine, lane), len(self._places)
            onwards = float(found[number + count]) * self._sign
            if onwards > 0 if holds else onwards < 0:
                return False
            scaled = abs(onwards) * float(lane_of(engine.pars, lane)[self._scales[number]])
            ahead = blind(engine, lane, scaled, self._pace(found[2 * count :], lane)) * self._sign
            lane_of(engine.pars, lane)[place] = self._holds_ahead(engine, lane, number, holds, ahead)
            return True

        return crossed

    def _lift(self, engine: Any, lane: int) -> None:
        """Take functions that stay zero away from it until something changes: they would stop the engine for ever."""
        here, count = self._values_of_functions(engine, lane), len(self._places)
        time = np.ravel(engine.time)[lane] + SHORT * self._pace(here[2 * count :], lane) * self._sign
        stay = (here[:count] == 0) & (self._ahead(engine, lane, time)[:count] == 0)
        lane_of(engine.pars, lane)[self._lifts[stay]] = SMALL

    def _holds_ahead(self, engine: Any, lane: int, number: int, holds: bool, ahead: float) -> bool:
        """Return whether a condition holds behind a zero, and come back at the next one if the engine misses it."""

        def is_behind(time: Any) -> bool:
            return bool(self._ahead(engine, lane, time)[number] < 0) == holds

        passed, due = look_ahead(is_behind, np.ravel(engine.time)[lane], ahead)
        if due is not None:
            self._come_back(engine, lane, due)
        return holds == passed

    def _ahead(self, engine: Any, lane: int, time: Any) -> Any:
        """Return the functions and derivatives at another time, by the polynomials of the last step."""
        engine.update_d_output([time] * len(self._piece) if len(self._piece) > 1 else time)
        return self._evaluated(engine, lane, np.append(lane_of(engine.d_output, lane), time))

    def _growing(self, number: int) -> Callable[..., bool]:
        def grown(engine: Any, _: int, lane: int = 0) -> bool:
            self._sizes[lane, number] *= LARGE / SMALL**2
            lane_of(engine.pars, lane)[self._scales[number]] = SMALL / self._sizes[lane, number]
            return True

        return grown

    def _enter(self, engine: Any, lane: int, piece: int) -> bool:
        """Let a lane go on in a piece; beyond the last one, in that. Return that the motion goes on."""
        knots = self._pieces.knots
        self._piece[lane] = inside = min(max(piece, 1), max(knots.size - 1, 1))
        constants = self.scales.parameters(np.array(self._pieces.values(inside, self._members[lane])), lane)
        lane_of(engine.pars, lane)[self._fixed] = constants[self._fixed]
        self._ends[lane] = NEVER * self._sign
        if knots.size:
            end = knots[inside if self._forwards else inside - 1]
            far = (knots[-1] - knots[0]) * self._sign
            self._ends[lane] = end if inside == piece else end + far
        self._come_back(engine, lane, NEVER)
        return self.settle(engine, lane)

    def _come_back(self, engine: Any, lane: int, due: float) -> None:
        """Let a lane stop at a time, or at the end of its piece where that is earlier."""
        self._due[lane] = due if due != NEVER else NEVER * self._sign
        until = min(self._due[lane], self._ends[lane], key=lambda time: time * self._sign)
        set_alarm(engine, lane, self._stop, until)

    def _pace(self, turning: NDArray[Any], lane: int) -> float:
        """Return the time in which the attitude changes, or that of the run if that is less."""
        return min(time_scale(turning), float(self.spans[lane]))

    def overlooked(self, engine: Any, lane: int) -> bool:
        """Return whether a condition is not as its function says: the engine has lost a zero."""
        pars, count = lane_of(engine.pars, lane), len(self._places)
        if not count:
            return False
        found = self._values_of_functions(engine, lane)
        values, rates, pace = found[:count], found[count : 2 * count], self._pace(found[2 * count :], lane)
        near = AT_ONCE * max(abs(float(np.ravel(engine.time)[lane])), pace) * np.abs(rates)
        return bool(np.any((np.abs(values) > near) & ((values < 0) != (pars[self._places] != 0))))

    def switch(self, engine: Any, lane: int) -> bool:
        """Let conditions switch that jumped over zero; return whether the motion goes on."""
        return self._switched(engine, lane, lambda: self.settle(engine, lane))

    def _switched(self, engine: Any, lane: int, act: Callable[[], bool]) -> bool:
        """Let conditions switch, and then tangent vectors jump; return whether the motion goes on."""
        if self.jump is None:
            return act()
        pars = lane_of(engine.pars, lane)
        before = pars[self._places].copy()
        goes_on, behind = act(), pars[self._places]
        if not goes_on or np.array_equal(before, behind):
            return goes_on
        pace = self._pace(self._values_of_functions(engine, lane)[2 * len(before) :], lane)
        near = AT_ONCE * max(abs(float(np.ravel(engine.time)[lane])), pace)
        return self.jump(engine, lane, near, before, behind)

    def settle(self, engine: Any, lane: int) -> bool:
        """Set each condition by the sign of its function, at a zero by that of the derivative; and its scale.

        Return that the motion goes on.
        """
        pars = lane_of(engine.pars, lane)
        time, count = abs(float(np.ravel(engine.time)[lane])), len(self._places)
        pars[self._lifts] = 0.0
        for i, place in enumerate(self._places):
            values = self._values_of_functions(engine, lane)
            value, rate, pace = values[i], values[i + count] * self._sign, self._pace(values[2 * count :], lane)
            at_zero = abs(value) <= AT_ONCE * max(time, pace) * abs(rate)
            pars[place] = (rate if at_zero else value) < 0
            size = max(self._sizes[lane, i], abs(float(value)), abs(float(rate)) * (pace or 1.0))
            self._sizes[lane, i] = size or 1.0
            pars[self._scales[i]] = SMALL / self._sizes[lane, i]
        return True

    def _values_of_functions(self, engine: Any, lane: int) -> Any:
        """Return the functions of the conditions, then their derivatives, then those of the attitude."""
        return self._evaluated(engine, lane, np.append(lane_of(engine.state, lane), np.ravel(engine.time)[lane]))

    def _evaluated(self, engine: Any, lane: int, inputs: NDArray[Any]) -> Any:
        look: Any = self._look
        return look(inputs, pars=np.ascontiguousarray(lane_of(engine.pars, lane)[: look.nparams]))


def lane_of(array: NDArray[Any], lane: int) -> NDArray[Any]:
    """Return a view of what is one lane's."""
    return array[:, lane] if array.ndim > 1 else array


def alarm(place: int) -> Any:
    """Return a function that is zero at the time in a parameter of the kernel; the next one scales it."""
    return hy.par[place + 1] * (hy.time - hy.par[place])


def set_alarm(engine: Any, lane: int, place: int, time: float) -> None:
    """Set the time at which an alarm stops a lane."""
    left = abs(time - float(np.ravel(engine.time)[lane]))
    lane_of(engine.pars, lane)[[place, place + 1]] = time, SMALL / (left or 1.0)


def blind(engine: Any, lane: int, rate: float, pace: float) -> Any:
    """Return the time after a zero of a scaled function in which the engine may miss the next one.

    It is more than rounding, and less than the time in which the motion changes.
    """
    near = AT_ONCE * max(abs(float(np.ravel(engine.time)[lane])), pace)
    return max(min(BLIND / rate if rate else np.inf, SHORT * pace), 4 * near)


def look_ahead(is_behind: Callable[[Any], bool], here: Any, ahead: Any) -> tuple[bool, float | None]:
    """Return whether a function has passed its zero here, and when it comes back if it does within a time ahead."""
    if is_behind(here + ahead):
        return True, None
    first = last = ahead
    while not is_behind(here + first):
        last, first = first, 0.5 * first
        if here + first == here:
            return False, None
    while here + first != here + (middle := 0.5 * (first + last)) != here + last:
        if is_behind(here + middle):
            first = middle
        else:
            last = middle
    return True, float(here + last)


def time_scale(turning: NDArray[Any]) -> float:
    """Return the time in which the attitude changes, from its derivatives; infinite where it rests."""
    fastest = max((abs(float(rate)) for rate in turning), default=0.0)
    return 1 / fastest if fastest > 0 else np.inf


def event_class(lanes: int, kind: Any, terminal: bool = True) -> Any:
    """Return the engine's class of events for lanes and a kind of numbers."""
    prefix, names = "t_event" if terminal else "nt_event", {np.float64: "dbl", np.longdouble: "ldbl"}
    return getattr(hy, f"{prefix}_batch_dbl" if lanes > 1 else f"{prefix}_{names.get(kind, 'f128')}")
