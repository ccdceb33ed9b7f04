"""Detection of sign changes in a kernel: conditions, on which formulas switch, and events, which are recorded.

A step ends at the first sign change of a watched function. A function whose sign changes at the same time is found when
the next step begins: its coefficients there have another sign than the one that is stored. Then a step of length zero
follows ("waits"), so that the next step has the coefficients of the new branches.

The stored sign of a function, in the field `signs` for events and as parameter 1 (negative) or 0 for conditions, is its
sign on the side of the last zero where the motion is:

| stored sign of an event | value at the start of a step | meaning |
|---|---|---|
| 0 | any | the task is new, or an action has changed the state: the sign is the present one |
| 0 | not above `sign_uncertainty` | an action has left the value at zero: the sign is the sign of the rate |
| +1 or -1 | the same sign | no zero |
| +1 or -1 | the opposite sign | a zero at the same time as the last one; the event is recorded and its sign changes |

The search for the first sign change of a Taylor polynomial advances from the start of a step by as much as the slope
and a bound of the second derivative allow, less the bounds of rounding and truncation errors. It converges to the first
zero from before it, quadratically, and passes no zero, however close the next one is.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from typing_extensions import override

from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.llvm_ir import BOOL, DOUBLE, INTEGER, POINTER, Array, Structure, Value, vector
from poinsot.taylor.memory import Context, KernelPart, Work

__all__ = ["Detection"]

SIMULTANEITY_TOLERANCE = 16 * np.finfo(float).eps
"""Times that differ by less, relative to the time and to that in which the attitude changes, are one: events may
coincide. A time in which the attitude changes is that of the run at most."""


TARGET_TOLERANCE = 0.125
"""The part of the time of coincident events within which an event is at an output time, a sample or the end."""

MAX_SHARE_OF_WIDE_ZERO = 0.25
"""The part of a step within which a zero has 32 digits. Coefficients of a watched function may decrease more slowly
than coefficients of the variables; the rest of its series is smaller by this to the power of the order. A step to a
zero farther away ends half-way."""

LINEAR_PART = 2.0**-26
"""The part of a step in which variables are linear."""


class Cut(NamedTuple):
    """A step up to the first sign change.

    Attributes
    ----------
    length : vector of numbers
    early, waits, stops : masks
        Where the step ends at a sign change, where it waits with length zero, and where an event or a switch at its
        start stops the lane.
    """

    length: Value
    early: Value
    waits: Value
    stops: Value


class _Watched(NamedTuple):
    """A watched function at the start of a step.

    Attributes
    ----------
    sign : vector
    passed : vector
        Time from the start behind which zeros are searched for.
    shift : vector
        Time from the start to the zero of an event, 0 where it is far.
    delayed : mask, optional
        Lanes where the event comes after a sample at the start.
    """

    sign: Value
    passed: Value
    shift: Value
    delayed: Value | None = None


class Detection(KernelPart):
    """The part of a kernel that detects sign changes of conditions and events.

    Fields: `span`, the time of the run; `branches`, the conditions of the last step, and `next_branches`, the
    conditions at the end of a task; `signs` and `sign_uncertainty` of the values of events; `crossed`, for each event 1
    or -1 where it happens and its value rises or falls with time, otherwise 0; `simultaneity`, the time within which
    events coincide; `shift`, the time from the start of a step to its events; `switched`, the count of successive steps
    of length zero; and the block of recorded events.

    Parameters
    ----------
    deadlines : sequence of str
        Fields with times of samples, at which a step ends at the latest.

    Attributes
    ----------
    count : int
        Number of the watched functions: conditions, then values of events.
    """

    def __init__(self, context: Context, decomposition: Decomposition, deadlines: Sequence[str]) -> None:
        super().__init__(context)
        self._deadlines, self._orders = deadlines, context.order + 1
        self.count = len(decomposition.watched)
        self._conditions, self._events = context.conditions, context.events
        self._crossings, self._stops, self._attitude = decomposition.events, decomposition.stops, decomposition.attitude
        self._at_target = TARGET_TOLERANCE * (2.0**-52 if context.wide else 1.0)
        sizes = {"span": min(self.count, 1), "branches": len(self._conditions)}
        sizes |= dict.fromkeys(("signs", "sign_uncertainty", "crossed"), self._events)
        near = [("simultaneity", "f8", ())]
        self.of_tasks_and_lanes = [*((name, "f8", (size,)) for name, size in sizes.items()), *near]
        self.of_tasks = [("next_branches", "f8", (len(self._conditions),))]
        polynomials = {"watched": self.count, "watched_numbers": context.wide * 2 * self.count}
        self.of_lanes = [(name, "f8", (size, self._orders)) for name, size in polynomials.items()]
        self.of_lanes += [("shift", "f8", ()), ("switched", "i8", ())]
        arrays = [(name, "f8", (size,)) for name, size in (("crossed", self._events), ("state", context.variables))]
        self.record = np.dtype([("task", "i8"), ("time", "f8"), *near, *arrays])
        self.functions = {"record_events": self._record_events} if self._events else {}

    of_workers = [(name, "i8", ()) for name in ("records", "records_limit", "record_count")]  # noqa: RUF012

    @override
    def taken(self, work: Work, task: Structure, lane: Value) -> None:
        work.array("switched", INTEGER)[lane] = 0

    @override
    def left(self, work: Work, task: Structure, lane: Value) -> None:
        for i, place in enumerate(self._conditions):
            task.array("next_branches")[i] = work.array("parameters")[lane + place * self.context.lanes]

    def forget_branches(self, work: Work, lane: Value) -> None:
        """Count a condition that switches in this step of a lane as no switch: its variables have jumped."""
        for i in range(len(self._conditions)):
            work.array("branches")[lane + i * self.context.lanes] = np.nan

    def has_room(self, work: Work, room: Value) -> Value:
        """Return the mask where there is also room for the records of another step."""
        if not self._events:
            return room
        return room & work.array("record_count", INTEGER)[0].is_("le", work.array("records_limit", INTEGER)[0])

    def store(self, work: Work, n: Value, outputs: Sequence[Value]) -> None:
        """Store an order of the watched functions."""
        for i, value in enumerate(outputs):
            work.doubles("watched")[n + i * self._orders] = value.high
            if self.context.wide:
                work.numbers("watched_numbers")[n + i * self._orders] = value

    def defined(self, work: Work, finite: Value) -> Value:
        """Return where the values of all events are numbers too."""
        values = work.doubles("watched")
        for i in range(len(self._conditions), self.count):
            finite = finite & (values[i * self._orders] * 0.0).is_("eq", 0.0)
        return finite

    def held(self, work: Work, waits: Value) -> Value:
        """Return where conditions switch without end: the motion leads back from both sides."""
        if not self.count:
            return waits
        switched = work.integers("switched")
        switched[0] = waits.choose(switched[0] + 1, 0)
        return switched[0].is_("gt", 2 * self.count)

    def cut(self, work: Work, h: Value, active: Value) -> Cut:
        """Cut a step at the first sign change, and record the events at its start."""
        nowhere = work.lines.constant(vector(BOOL, self.context.lanes), 0)
        if not self.count:
            return Cut(h, nowhere, nowhere, nowhere)
        way = work.doubles("way")[0]
        # Behind a zero it is no shorter than before it: an action may let the body turn much faster.
        last_near = work.doubles("simultaneity")
        near = self._simultaneity(work).larger(last_near[0])
        chosen, early, waits, whole = work.lines.constant(self.context.whole, -1), nowhere, nowhere, h
        linear = near.larger(LINEAR_PART * abs(h.high))
        starts, wrong = self._starts(work, near, linear), list[Value]()
        for i, start in enumerate(starts):
            reach = (abs(h.high).larger(start.passed)).intrinsic("copysign", way)
            given = work.per_unit(reach), start.sign, start.passed / abs(reach)
            share, changes = _first_change(work.doubles("watched").at(i * self._orders), *given, self._orders)
            if start.delayed is not None:
                share = start.delayed.choose(share.like(1.0), share)
            wrong.append(share.is_("eq", 0.0))
            before = share.is_("lt", 1.0) & ~wrong[-1]
            chosen = before.choose(changes.choose(chosen.like(i), -1), chosen)
            end = self._polished(work, i, share * reach, before & changes, near)
            h, early, waits = before.choose(end, h), early | before, waits | wrong[-1]
        last_near[0] = near
        if self.context.wide:
            far = chosen.is_("ge", 0) & abs(h.high).is_("gt", MAX_SHARE_OF_WIDE_ZERO * abs(whole.high))
            h, chosen = far.choose(h.times_power_of_two(0.5), h), far.choose(chosen.like(-1), chosen)
        h = self._at_targets(work, h, chosen.is_("ge", len(self._conditions)), near)
        stops = self._recorded(work, starts, wrong, active) | (self._switched(work) & ~waits)
        waits = waits | stops
        for i, place in enumerate(self._conditions):
            branches = work.doubles("branches")
            branches[i] = waits.choose(branches[i], work.doubles("parameters")[place])
        crossed = [mask | (~waits & chosen.is_("eq", i)) for i, mask in enumerate(wrong)]
        self._cross(work, starts, crossed, ~waits)
        last_near[0] = (waits | chosen.is_("ge", 0)).choose(near, 0.0)
        return Cut(waits.choose(h.like(0.0), h), early | waits, waits, stops)

    def _at_targets(self, work: Work, h: Value, is_event: Value, near: Value) -> Value:
        """Return the time of a zero. An event within some roundings of an output time, a sample or the end is there."""
        found = h
        for target in ("end", "output_time", *self._deadlines) if self._events else ():
            ahead = self._ahead(work, target)
            distance = ahead - (found if target in self._deadlines else h)  # a sample comes before its events
            h = (is_event & abs(distance).is_("le", self._at_target * near)).choose(ahead, h)
        return h

    @staticmethod
    def _ahead(work: Work, target: str) -> Value:
        """Return the time from the start of the step to an output time, a sample or the end."""
        return work.ahead(work.doubles(target)[0])

    def _polished(self, work: Work, i: int, end: Value, changes: Value, near: Value) -> Value:
        """Return the time of a zero, improved by two steps of Newton in double-double arithmetic."""
        if not self.context.wide:
            return end
        terms, lines = work.numbers("watched_numbers"), work.lines

        def newton(h: Value) -> Value:
            def lower(n: Value, value: Value, slope: Value) -> list[Value]:
                return [n - 1, value.fma(h, terms[n + i * self._orders]), slope.fma(h.high, value.high)]

            start = [lines.constant(INTEGER, self._orders - 1), h.like(0.0), h.high.like(0.0)]
            _, value, slope = lines.repeat(start, lambda n, *_: n.is_("ge", 0), lower)
            return h - value / slope

        wide_end = lines.constant(self.context.number, 0.0).like(end)

        def improved() -> list[Value]:
            found = work.in_unit(newton(newton(work.per_unit(wide_end))))
            return [(abs((found - end).high)).is_("le", near).choose(found, end)]

        (found,) = lines.either(changes.any(), [wide_end], improved)
        return changes.choose(found, end)

    def _simultaneity(self, work: Work) -> Value:
        """Return the time within which events coincide: wherever the step is cut, the attitude hardly changes."""
        turning = work.states(1)
        scale = work.doubles("span")[0]
        if self._attitude:
            fastest = functools.reduce(Value.larger, [abs(turning[place].high) for place in self._attitude])
            scale = (1.0 / work.per_unit(fastest)).smaller(scale)
        return scale.larger(abs(work.doubles("time")[0])) * SIMULTANEITY_TOLERANCE

    def _starts(self, work: Work, near: Value, linear: Value) -> list[_Watched]:
        """Return the watched functions at the start of the step.

        Where an action has left the value of an event at zero, its zero is passed no farther than it was known to be
        there, and then behind the zero. The rate behind an action may be so small that the zero of the rounded value is
        far ahead. Rounding may let a step pass a zero, by no more than is linear.

        An event that is new and that is at the start but for rounding has happened, unless it waits for a sample
        between the start and its zero.
        """
        way = work.doubles("way")[0]
        held = [work.doubles("parameters")[place] for place in self._conditions]
        starts = [_Watched(1.0 - 2.0 * parameter, near, near.like(0.0)) for parameter in held]
        for i in range(self._events):
            value, slope = (work.doubles("watched")[len(starts) * self._orders + n] for n in (0, 1))
            slope = work.per_unit(slope)
            sign, uncertainty, shift = work.doubles("signs")[i], work.doubles("sign_uncertainty"), -value / slope
            at_zero = sign.is_("eq", 0.0) & abs(value).is_("le", uncertainty[i])
            present, delayed = at_zero.choose(slope * way, value), None
            passed = at_zero.choose(near.larger((2.0 * abs(shift)).smaller(linear)), near)
            for target in self._deadlines:
                ahead = self._ahead(work, target).high
                new = sign.is_("eq", 0.0) & ~at_zero & shift.is_("le", near)
                delayed = new & ahead.is_("gt", 0.0) & shift.is_("ge", ahead - TARGET_TOLERANCE * near)
            sign = sign.is_("eq", 0.0).choose(sign.like(1.0).intrinsic("copysign", present), sign)
            starts.append(_Watched(sign, passed, abs(shift).is_("le", linear).choose(shift, 0.0), delayed))
            uncertainty[i] = near * abs(slope)
        return starts

    def _switched(self, work: Work) -> Value:
        """Return where a condition that stops a lane has switched since its last step, if it has taken one."""
        switched = work.lines.constant(vector(BOOL, self.context.lanes), 0)
        for i in self._stops:
            change = work.doubles("parameters")[self._conditions[i]] - work.doubles("branches")[i]
            switched = switched | abs(change).is_("gt", 0.5)
        return switched

    def _cross(self, work: Work, starts: Sequence[_Watched], crossed: Sequence[Value], moves: Value) -> None:
        """Switch conditions and change the signs of events; mark the events at the end of the step."""
        first = len(self._conditions)
        for i, place in enumerate(self._conditions):
            held = work.doubles("parameters")[place]
            work.doubles("parameters")[place] = crossed[i].choose(1.0 - held, held)
        way = work.doubles("way")[0]
        for i, (start, mask) in enumerate(zip(starts[first:], crossed[first:], strict=True)):
            work.doubles("crossed")[i] = (mask & moves).choose(-(start.sign * way), 0.0)
            work.doubles("signs")[i] = mask.choose(-start.sign, start.sign)

    def _recorded(self, work: Work, starts: Sequence[_Watched], wrong: Sequence[Value], active: Value) -> Value:
        """Record the events at the start of the step, and return where one stops the lane."""
        nowhere = work.lines.constant(vector(BOOL, self.context.lanes), 0)
        if not self._events:
            return nowhere
        way, first = work.doubles("way")[0], len(self._conditions)
        crossed, marks, happens, stops = work.doubles("crossed"), list[Value](), nowhere, nowhere
        for i, crossing in enumerate(self._crossings):
            changes = wrong[first + i] & work.doubles("signs")[i].is_("ne", 0.0)
            # An event whose sign changes back is not there yet.
            back = crossed[i].is_("ne", 0.0).choose(way.like(0.0), -(starts[first + i].sign * way))
            direction = changes.choose(back, crossed[i])
            if crossing.direction:
                direction = direction.is_("eq", crossing.direction).choose(direction, 0.0)
            crossed[i] = direction
            marks.append(direction.is_("ne", 0.0))
            happens, stops = happens | marks[i], stops | marks[i] if crossing.stops else stops
        shift = way.like(0.0)
        for mask, start in zip(marks, starts[first:], strict=True):
            shift = (mask & ~stops).choose(start.shift, shift)
        work.doubles("shift")[0] = shift
        work.for_each(active & happens, "record_events")
        return stops

    def _record_events(self, work: Work, lane: Value) -> None:
        """Record the events at the start of the step of a lane."""
        lanes, count = self.context.lanes, work.array("record_count", INTEGER)
        record = Structure.of(work.array("records", POINTER)[0], count[0], self.context.record)
        count[0] = count[0] + 1
        record.array("task", INTEGER)[0] = work.array("task", INTEGER)[lane]
        for i in range(self._events):
            record.array("crossed")[i] = work.array("crossed")[lane + i * lanes]
        shift = ahead = work.array("shift")[lane]
        if self.context.wide:
            ahead = shift / work.array("unit")[lane]
        record.array("time")[0] = work.array("time")[lane] + shift
        record.array("simultaneity")[0] = work.array("simultaneity")[lane]
        states, rates = (work.states(n).of(DOUBLE) for n in (0, 1))
        out = record.array("state")
        for k in range(self.context.variables):
            value = rates[lane + k * lanes].high.fma(ahead, states[lane + k * lanes].high)
            out[k] = work.unscaled(k, value, lane)


# ---------------------------------------------------------------------- first sign change of a polynomial

ROUNDING_BOUND = 2.0**-50
"""Bound of the rounding error of a polynomial, relative to the sum of the sizes of its terms."""

MAX_TRUNCATED, REST_FACTOR = 1e-7, 2.0**-5
"""The largest share of the last four terms in that sum for which a polynomial represents its function, and the largest
ratio of the rest of the series to these terms then."""

MAX_ADVANCES = 60
"""Largest number of advances of a search. Near a minimum that touches zero each advance leaves a third of the way, so
that a step may end there."""

MIN_ADVANCE, ZERO_DISTANCE = 0.25, 2.0
"""Least advance, and the distance within which a zero is certain, in parts of the time within which events coincide."""


class _Series:
    """A polynomial of the share of a step.

    Attributes
    ----------
    unit : vector
        The part of the step that has the share 1: shorter where the series hardly converges.
    total : vector
        The sum of the sizes of its terms.
    curvature, beyond : vectors
        Bounds of the second derivative and of the rest of the series, relative to that.
    """

    def __init__(self, coefficients: Value, h: Value, simultaneous: Value, orders: int) -> None:
        self._lines, self._terms, self._orders = h.function, Array(coefficients, h.type), orders
        self._simultaneous, one = simultaneous, h.like(1.0)
        self.unit, self.total, bend, tail = self._lines.repeat(
            [one, *self._scaled(h)], lambda unit, total, _, tail: self._is_poor(unit, total, tail).any(), self._halved
        )
        self.curvature = (bend / self.total).larger(1e-300)
        self.beyond = REST_FACTOR * tail / self.total

    def _is_poor(self, unit: Value, total: Value, tail: Value) -> Value:
        return (tail.is_("gt", MAX_TRUNCATED * total) | total.is_("eq", math.inf)) & unit.is_("gt", self._simultaneous)

    def _halved(self, unit: Value, total: Value, _: Value, tail: Value) -> list[Value]:
        factor = self._is_poor(unit, total, tail).choose(unit.like(0.5), 1.0)
        return [unit * factor, *self._scaled(factor)]

    def _scaled(self, factor: Value) -> list[Value]:
        """Multiply the terms by powers; return the sum of sizes, a bound of the second derivative, the last sizes."""

        def scale(n: Value, power: Value, total: Value, bend: Value, *last: Value) -> list[Value]:
            self._terms[n] = term = self._terms[n] * power
            weight = (n * (n - 1)).to_double().spread(power.lanes)
            return [n + 1, power * factor, total + abs(term), weight.fma(abs(term), bend), *last[1:], abs(term)]

        one, zero = factor.like(1.0), factor.like(0.0)
        lowest = [self._lines.constant(INTEGER, 0), one, zero, zero, *[zero] * 4]
        _, _, total, bend, *last = self._lines.repeat(lowest, lambda n, *_: n.is_("lt", self._orders), scale)
        return [total, bend, functools.reduce(Value.larger, last)]

    def at(self, share: Value, sign: Value) -> list[Value]:
        """Return value, slope, error and the slope of the error, relative to the sum of the sizes."""

        def lower(n: Value, value: Value, slope: Value, size: Value) -> list[Value]:
            term = self._terms[n]
            return [n - 1, value.fma(share, term), slope.fma(share, value), size.fma(share, abs(term))]

        highest = [self._lines.constant(INTEGER, self._orders - 1), *[share.like(0.0)] * 3]
        _, value, slope, size = self._lines.repeat(highest, lambda n, *_: n.is_("ge", 0), lower)
        power, doublings = share, self._orders.bit_length() - 1
        for _ in range(doublings):
            power = power * power
        truncated = self.beyond * power
        error = ROUNDING_BOUND * size / self.total + truncated
        return [sign * value / self.total, sign * slope / self.total, error, 2.0**doublings * truncated / share]


def _first_change(coefficients: Value, h: Value, sign: Value, simultaneous: Value, orders: int) -> tuple[Value, Value]:
    """Return up to which share of a step a function keeps its sign, and the mask where the sign changes there.

    The share is at a zero of the function, or before one that truncation makes uncertain, where the sign does not
    change. It is 1 if the function keeps its sign to the end, and 0 if the function has another sign at the start, or
    just behind a zero there.

    Parameters
    ----------
    coefficients : address of vectors (orders,)
        Taylor coefficients of the function; they are overwritten.
    h : vector
        Length of the step, negative backwards.
    sign : vector
        Sign of the function, 1 or -1.
    simultaneous : vector
        Share of the step within which events coincide.
    """
    lines, pair = h.function, f"{{{h.type}, {h.type}}}"
    search = functools.partial(_search, orders=orders)
    found = lines.call_defined(pair, "first_change", search, coefficients, h, sign, simultaneous)
    return found.part(0), found.part(1).is_("gt", 0.0)


def _search(coefficients: Value, h: Value, sign: Value, simultaneous: Value, orders: int) -> Value:
    lines, one, zero = h.function, h.like(1.0), h.like(0.0)
    start = sign * Array(coefficients, h.type)[0]
    series = _Series(coefficients, h, simultaneous, orders)
    total, unit = series.total, series.unit
    simultaneous = simultaneous / unit
    finite = (0.0 * total).is_("eq", 0.0)
    watched = (2.0 * start).is_("le", total) & finite & total.is_("gt", 0.0)

    def search() -> list[Value]:
        curvature = series.curvature + orders**2 * series.beyond
        first = series.at(simultaneous, sign)
        wrong = watched & first[0].is_("lt", 0.0)
        going = watched & ~wrong & simultaneous.is_("lt", 1.0)

        def advance(left: Value, going: Value, share: Value, *found: Value) -> list[Value]:
            value, slope, error, increase = found
            room, slope = value - error, slope - increase
            root = (slope * slope + 2.0 * curvature * room).intrinsic("sqrt")
            rising = slope.is_("ge", 0.0)
            ahead = rising.choose((slope + root) / curvature, 2.0 * room / (root - slope))
            further = going & room.is_("gt", 0.0) & ahead.is_("gt", MIN_ADVANCE * simultaneous)
            share = further.choose((share + ahead).smaller(1.0), share)
            moved = [further.choose(new, old) for new, old in zip(series.at(share, sign), found, strict=True)]
            return [left - 1, further & share.is_("lt", 1.0), share, *moved]

        begin = [lines.constant(INTEGER, MAX_ADVANCES), going, simultaneous, *first]
        _, _, share, value, slope, *_ = lines.repeat(
            begin, lambda left, going, *_: left.is_("gt", 0) & going.any(), advance
        )
        beyond = value + ZERO_DISTANCE * slope * simultaneous
        changes = share.is_("lt", 1.0) & slope.is_("lt", 0.0) & beyond.is_("lt", 0.0)
        share = changes.choose((share - value / slope).larger(simultaneous), share).smaller(1.0)
        share = wrong.choose(zero, watched.choose(share * unit, unseen))
        return [share, (watched & changes & ~wrong).choose(one, zero)]

    # The rates of the other branch may be no numbers.
    unseen = (~finite & start.is_("lt", 0.0)).choose(zero, finite.choose(unit, one))
    return lines.struct(*lines.either(watched.any(), [unseen, zero], search))
