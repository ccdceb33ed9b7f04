"""Detection of sign changes in a kernel: conditions, on which formulas switch, and events, which are recorded.

A step ends at the first sign change of a watched function. A function whose sign changes at the same time is found when
the next step begins: its coefficients there have another sign than the one that is stored. Then a step of length zero
follows ("waits"), so that the coefficients of the next step are those of the new branches.

The stored sign of a function, in the field `signs` for events and as parameter 1 (negative) or 0 for conditions, is its
sign on the side of the last zero where the motion is:

| stored sign of an event | value at the start of a step | meaning |
|---|---|---|
| 0 | any | the task is new, or an action has changed the state: the sign is the present one |
| 0 | not above `sign_uncertainty` | an action has left the value at zero: the sign is the sign of the rate |
| +1 or -1 | the same sign | no zero |
| +1 or -1 | the opposite sign | a zero at the same time as the last one; the event is recorded and its sign changes |
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from typing_extensions import override

from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.llvm_ir import BOOL, DOUBLE, INTEGER, POINTER, Structure, Value, vector
from poinsot.taylor.memory import Context, KernelPart, Work
from poinsot.taylor.sign_changes import first_change

__all__ = ["Detection"]

SIMULTANEOUS = 16 * np.finfo(float).eps
"""Times that differ by less, relative to the time and to that in which the attitude changes, are one: events may
coincide. A time in which the attitude changes is that of the run at most."""


AT_TARGET = 0.125
"""The part of the time of coincident events within which an event is at an output time, a sample or the end."""

NEARBY = 0.25
"""The part of a step within which a zero has 32 digits. Coefficients of a watched function may fall more slowly than
those of the variables; the rest of its series is smaller by this to the power of the order. A step to a zero farther
away ends half-way."""

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


class _Starts(NamedTuple):
    """The watched functions at the start of a step.

    Attributes
    ----------
    signs : list of vectors
    passed : list of vectors
        Times from the start behind which zeros are searched for.
    shifts : list of vectors
        For each event the time from the start to its zero, 0 where it is far.
    delayed : dict
        For events by number the mask of lanes where the event comes after a sample at the start.
    """

    signs: list[Value]
    passed: list[Value]
    shifts: list[Value]
    delayed: dict[int, Value]


class Detection(KernelPart):
    """The part of a kernel that detects sign changes of conditions and events.

    Fields: `span`, the time of the run; `branches`, the conditions of the last step, and `next_branches`, those at the
    end of a task; `signs` and `sign_uncertainty` of the values of events; `crossed`, for each event 1 or -1 where it
    happens and its value rises or falls with time, otherwise 0; `simultaneity`, the time within which events coincide;
    `shift`, the time from the start of a step to its events; `switched`, the count of successive steps of length zero;
    and the block of recorded events.

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
        self._at_target = AT_TARGET * (2.0**-52 if context.wide else 1.0)
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
        """Return whether there is room for the records of one more step."""
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
        starts, first = self._starts(work, near, linear), len(self._conditions)
        wrong = list[Value]()
        for i, sign in enumerate(starts.signs):
            reach = (abs(h.high).larger(starts.passed[i])).intrinsic("copysign", way)
            given = work.per_unit(reach), sign, starts.passed[i] / abs(reach)
            share, changes = first_change(work.doubles("watched").at(i * self._orders), *given, self._orders)
            if i - first in starts.delayed:
                share = starts.delayed[i - first].choose(share.like(1.0), share)
            wrong.append(share.is_("eq", 0.0))
            before = share.is_("lt", 1.0) & ~wrong[-1]
            chosen = before.choose(changes.choose(chosen.like(i), -1), chosen)
            end = self._polished(work, i, share * reach, before & changes, near)
            h, early, waits = before.choose(end, h), early | before, waits | wrong[-1]
        last_near[0] = near
        if self.context.wide:
            far = chosen.is_("ge", 0) & abs(h.high).is_("gt", NEARBY * abs(whole.high))
            h, chosen = far.choose(h.times_power_of_two(0.5), h), far.choose(chosen.like(-1), chosen)
        h = self._at_targets(work, h, chosen.is_("ge", first), near)
        stops = self._recorded(work, starts, wrong, active) | (self._switched(work) & ~waits)
        waits = waits | stops
        for i, place in enumerate(self._conditions):
            branches = work.doubles("branches")
            branches[i] = waits.choose(branches[i], work.doubles("parameters")[place])
        crossed = [mask | (~waits & chosen.is_("eq", i)) for i, mask in enumerate(wrong)]
        self._cross(work, starts.signs, crossed, ~waits)
        last_near[0] = (waits | chosen.is_("ge", 0)).choose(near, 0.0)
        return Cut(waits.choose(h.like(0.0), h), early | waits, waits, stops)

    def _at_targets(self, work: Work, h: Value, is_event: Value, near: Value) -> Value:
        """Return the time of a zero. An event within some roundings of an output time, a sample or the end is there."""
        found = h
        for target in ("end", "output_time") if self._events else ():
            ahead = self._ahead(work, target)
            h = (is_event & abs(ahead - h).is_("le", self._at_target * near)).choose(ahead, h)
        for target in self._deadlines if self._events else ():  # a sample comes before its events
            ahead = self._ahead(work, target)
            h = (is_event & abs(ahead - found).is_("le", self._at_target * near)).choose(ahead, h)
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
        return scale.larger(abs(work.doubles("time")[0])) * SIMULTANEOUS

    def _starts(self, work: Work, near: Value, linear: Value) -> _Starts:
        """Return the watched functions at the start of the step.

        Where an action has left the value of an event at zero, its zero is passed no farther than it was known to be
        there, and then behind the zero. The rate behind an action may be so small that the zero of the rounded value is
        far ahead. Rounding may let a step pass a zero, by no more than is linear.

        An event that is new and that is at the start but for rounding has happened, unless it waits for a sample
        between the start and its zero.
        """
        way = work.doubles("way")[0]
        signs = [1.0 - 2.0 * work.doubles("parameters")[place] for place in self._conditions]
        starts = _Starts(signs, [near] * len(signs), [], {})
        for i in range(self._events):
            value, slope = (work.doubles("watched")[len(starts.signs) * self._orders + n] for n in (0, 1))
            slope = work.per_unit(slope)
            sign, uncertainty, shift = work.doubles("signs")[i], work.doubles("sign_uncertainty"), -value / slope
            at_zero = sign.is_("eq", 0.0) & abs(value).is_("le", uncertainty[i])
            present = at_zero.choose(slope * way, value)
            starts.signs.append(sign.is_("eq", 0.0).choose(sign.like(1.0).intrinsic("copysign", present), sign))
            starts.passed.append(at_zero.choose(near.larger((2.0 * abs(shift)).smaller(linear)), near))
            for target in self._deadlines:
                ahead = self._ahead(work, target).high
                new = sign.is_("eq", 0.0) & ~at_zero & shift.is_("le", near)
                starts.delayed[i] = new & ahead.is_("gt", 0.0) & shift.is_("ge", ahead - AT_TARGET * near)
            starts.shifts.append(abs(shift).is_("le", linear).choose(shift, 0.0))
            uncertainty[i] = near * abs(slope)
        return starts

    def _switched(self, work: Work) -> Value:
        """Return where a condition that stops a lane has switched since its last step, if it has taken one."""
        switched = work.lines.constant(vector(BOOL, self.context.lanes), 0)
        for i in self._stops:
            change = work.doubles("parameters")[self._conditions[i]] - work.doubles("branches")[i]
            switched = switched | abs(change).is_("gt", 0.5)
        return switched

    def _cross(self, work: Work, signs: Sequence[Value], crossed: Sequence[Value], moves: Value) -> None:
        """Switch conditions and change the signs of events; mark the events at the end of the step."""
        first = len(self._conditions)
        for i, place in enumerate(self._conditions):
            held = work.doubles("parameters")[place]
            work.doubles("parameters")[place] = crossed[i].choose(1.0 - held, held)
        way = work.doubles("way")[0]
        for i, (sign, mask) in enumerate(zip(signs[first:], crossed[first:], strict=True)):
            work.doubles("crossed")[i] = (mask & moves).choose(-(sign * way), 0.0)
            work.doubles("signs")[i] = mask.choose(-sign, sign)

    def _recorded(self, work: Work, starts: _Starts, wrong: Sequence[Value], active: Value) -> Value:
        """Record the events at the start of the step, and return where one stops the lane."""
        nowhere = work.lines.constant(vector(BOOL, self.context.lanes), 0)
        if not self._events:
            return nowhere
        way, first = work.doubles("way")[0], len(self._conditions)
        crossed, marks, happens, stops = work.doubles("crossed"), list[Value](), nowhere, nowhere
        for i, crossing in enumerate(self._crossings):
            changes = wrong[first + i] & work.doubles("signs")[i].is_("ne", 0.0)
            # An event whose sign changes back is not there yet.
            back = crossed[i].is_("ne", 0.0).choose(way.like(0.0), -(starts.signs[first + i] * way))
            direction = changes.choose(back, crossed[i])
            if crossing.direction:
                direction = direction.is_("eq", crossing.direction).choose(direction, 0.0)
            crossed[i] = direction
            marks.append(direction.is_("ne", 0.0))
            happens, stops = happens | marks[i], stops | marks[i] if crossing.stops else stops
        shift = way.like(0.0)
        for mask, own in zip(marks, starts.shifts, strict=True):
            shift = (mask & ~stops).choose(own, shift)
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
