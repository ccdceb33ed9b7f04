"""What a kernel watches for in each step: sign changes of conditions, which switch, and of events, which it notes.

The step is cut at the first of them. What changes its sign at the same time is found as the next step begins, from the
coefficients there; then a step waits for those that belong to the new branches.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.llvm_ir import BOOL, DOUBLE, INTEGER, POINTER, Array, Module, Record, Value, vector
from poinsot.taylor.llvm_ir import Function as Lines
from poinsot.taylor.sign_changes import first_change

__all__ = ["AT_ONCE", "Watch", "bit_of"]

AT_ONCE = 16 * np.finfo(float).eps
"""Times that differ by less, relative to the time and to that in which the attitude changes, are one: events may
coincide. A time in which the attitude changes is that of the run at most."""


AT_TARGET = 0.125
"""The part of the time of coincident events within which an event is at an output time, a sample or the end."""

NEARBY = 0.25
"""The part of a step within which a zero has 32 digits. Coefficients of a watched function may fall more slowly than
those of the variables; the rest of its series is smaller by this to the power of the order. A step to a zero farther
away ends half-way."""

LINEAR = 2.0**-26
"""The part of a step in which variables are linear."""

BITS = 64
"""Events of an integer that marks events by bits."""


def bit_of(event: int) -> tuple[int, int]:
    """Return the integer that marks an event, by its number among such integers, and the bit of the event."""
    word, bit = divmod(event, BITS)
    return word, 1 << bit


class Watch:
    """The part of a kernel that looks at conditions and events.

    Attributes
    ----------
    count, events, words : int
        Numbers of the functions that are watched, of the values of events among them, and of the integers that mark
        events by bits.
    conditions : tuple of int
        The parameters that hold the conditions.
    of_tasks, marks : list
        The fields that a lane and a task have for it, the marks of events apart.
    note : structured type
        Note of events: task, the events that happen and the events that rise (bits of integers), time, the time within
        which events coincide, and variables.
    """

    def __init__(self, kernel: Any, decomposition: Decomposition) -> None:
        self._kernel, self._lanes, self._orders = kernel, kernel.lanes, kernel.order + 1
        self.count, self.events = len(decomposition.watched), len(decomposition.events)
        self.words = max(-(-self.events // BITS), 1)
        self.conditions, self._crossings = decomposition.conditions, decomposition.events
        self._stops, self._attitude = decomposition.stops, decomposition.attitude
        self._at_target = AT_TARGET * (2.0**-52 if kernel.wide else 1.0)
        sizes = {"span": min(self.count, 1), "branches": len(self.conditions)}
        sizes |= dict.fromkeys(("sides", "uncertain"), self.events)
        self.of_tasks = [(name, "f8", (size,)) for name, size in sizes.items()]
        self.polynomials = {"watched": (self.count, self._orders, self._lanes)}
        if kernel.wide:
            self.polynomials["polynomials"] = (2 * self.count, self._orders, self._lanes)
        self.marks = [(name, "i8", (self.words,)) for name in ("which", "rising")]
        times = [(name, "f8") for name in ("time", "near")]
        self.note = np.dtype([("task", "i8"), *self.marks, *times, ("state", "f8", (kernel.variables,))])

    def define(self, module: Module) -> None:
        """Write the functions that it needs."""
        kind = self._kernel.kind
        if self.count:
            search = functools.partial(first_change, orders=self._orders, lanes=self._lanes)
            module.function("first_change", f"{{{kind}, {kind}}}", [POINTER, *(kind,) * 3], search)
        if self.events:
            module.function("note", "void", [POINTER, INTEGER], self._note)

    def store(self, work: Record, n: Value, outputs: Sequence[Value]) -> None:
        """Store an order of what is watched."""
        for i, value in enumerate(outputs):
            work.array("watched", self._kernel.kind)[n + i * self._orders] = value.high
            if self._kernel.wide:
                work.array("polynomials", self._kernel.number)[n + i * self._orders] = value

    def look(self, lines: Lines, work: Record, h: Value, active: Value) -> tuple[Value, ...]:
        """Cut a step at the first sign change, and note the events at its start.

        Return its length, and where it is cut, where it waits, and where an event or a switch stops the lane.
        """
        nowhere = lines.constant(vector(BOOL, self._lanes), 0)
        if not self.count:
            return h, nowhere, nowhere, nowhere
        kind, way = self._kernel.kind, work.array("way", self._kernel.kind)[0]
        # Behind a zero it is no shorter than before it: an action may let the body turn much faster.
        kept = work.array("near", kind)
        near = self._near(work).larger(kept[0])
        chosen, cut, waits, whole = lines.constant(self._kernel.whole, -1), nowhere, nowhere, h
        linear = near.larger(LINEAR * abs(h.high))
        sides, passed, shifts, waiting = self._starts(work, near, linear)
        wrong = list[Value]()
        for i, side in enumerate(sides):
            reach = (abs(h.high).larger(passed[i])).intrinsic("copysign", way)
            coefficients = work.array("watched", kind).at(i * self._orders)
            given = coefficients, self._kernel.per_unit(work, reach), side, passed[i] / abs(reach)
            found = lines.call(f"{{{kind}, {kind}}}", "first_change", *given)
            share, changes = found.part(0), found.part(1).is_("gt", 0.0)
            if i - len(self.conditions) in waiting:
                share = waiting[i - len(self.conditions)].choose(share.like(1.0), share)
            wrong.append(share.is_("eq", 0.0))
            earlier = share.is_("lt", 1.0) & ~wrong[-1]
            chosen = earlier.choose(changes.choose(chosen.like(i), -1), chosen)
            end = self._polished(lines, work, i, share * reach, earlier & changes, near)
            h, cut, waits = earlier.choose(end, h), cut | earlier, waits | wrong[-1]
        kept[0] = near
        if self._kernel.wide:
            far = chosen.is_("ge", 0) & abs(h.high).is_("gt", NEARBY * abs(whole.high))
            h, chosen = far.choose(h.times_power_of_two(0.5), h), far.choose(chosen.like(-1), chosen)
        is_event, found = chosen.is_("ge", len(self.conditions)), h
        for target in ("end", "output_time") if self.events else ():  # an event two roundings beside these is there
            ahead = self._ahead(work, target)
            h = (is_event & abs(ahead - h).is_("le", self._at_target * near)).choose(ahead, h)
        for target in self._kernel.sampling.targets if self.events else ():  # a sample comes before its events
            ahead = self._ahead(work, target)
            h = (is_event & abs(ahead - found).is_("le", self._at_target * near)).choose(ahead, h)
        stops = self._note_all(lines, work, sides, shifts, wrong, active) | (self._switched(lines, work) & ~waits)
        waits = waits | stops
        for i, place in enumerate(self.conditions):
            branches = work.array("branches", kind)
            branches[i] = waits.choose(branches[i], work.array("parameters", kind)[place])
        here = [mask | (~waits & chosen.is_("eq", i)) for i, mask in enumerate(wrong)]
        self._turn(work, sides, here, ~waits)
        kept[0] = (waits | chosen.is_("ge", 0)).choose(near, 0.0)
        return waits.choose(h.like(0.0), h), cut | waits, waits, stops

    def _ahead(self, work: Record, target: str) -> Value:
        """Return the time from the start of the step to an output time, a sample or the end."""
        ahead: Value = self._kernel.ahead(work, work.array(target, self._kernel.kind)[0])
        return ahead

    def _polished(self, lines: Lines, work: Record, i: int, end: Value, changes: Value, near: Value) -> Value:
        """Return the time of a zero, improved by two steps of Newton in double-double arithmetic."""
        if not self._kernel.wide:
            return end
        terms = work.array("polynomials", self._kernel.number)

        def newton(h: Value) -> Value:
            def lower(n: Value, value: Value, slope: Value) -> list[Value]:
                return [n - 1, value.fma(h, terms[n + i * self._orders]), slope.fma(h.high, value.high)]

            start = [lines.constant(INTEGER, self._orders - 1), h.like(0.0), h.high.like(0.0)]
            _, value, slope = lines.repeat(start, lambda n, *_: n.is_("ge", 0), lower)
            return h - value / slope

        def improved() -> list[Value]:
            start = self._kernel.per_unit(work, lines.constant(self._kernel.number, 0.0).like(end))
            found = self._kernel.in_unit(work, newton(newton(start)))
            return [(abs((found - end).high)).is_("le", near).choose(found, end)]

        (found,) = lines.either(changes.any(), [lines.constant(self._kernel.number, 0.0).like(end)], improved)
        return changes.choose(found, end)

    def defined(self, work: Record, finite: Value) -> Value:
        """Return where the values of all events are numbers too."""
        values = work.array("watched", self._kernel.kind)
        for i in range(len(self.conditions), self.count):
            finite = finite & (values[i * self._orders] * 0.0).is_("eq", 0.0)
        return finite

    def held(self, work: Record, waits: Value) -> Value:
        """Return where conditions switch without end: the motion leads back from both sides."""
        if not self.count:
            return waits
        switched = work.array("switched", self._kernel.whole)
        switched[0] = waits.choose(switched[0] + 1, 0)
        return switched[0].is_("gt", 2 * self.count)

    def _near(self, work: Record) -> Value:
        """Return the time within which all happens at once: wherever the step is cut, the attitude hardly changes."""
        kind, turning = self._kernel.kind, self._kernel.layout.states(work.address, 1)
        scale = work.array("span", kind)[0]
        if self._attitude:
            fastest = functools.reduce(Value.larger, [abs(turning[place].high) for place in self._attitude])
            fastest = self._kernel.per_unit(work, fastest)
            scale = (1.0 / fastest).smaller(scale)
        return scale.larger(abs(work.array("time", kind)[0])) * AT_ONCE

    def _starts(
        self, work: Record, near: Value, linear: Value
    ) -> tuple[list[Value], list[Value], list[Value], dict[int, Value]]:
        """Return the signs of the functions, the times behind which to look for zeros, and those to zeros of events.

        Of an event that is new the sign is the present one; where an action has left its value at zero, no farther
        than it was known to be there, that behind the zero. The rate behind an action may be so small that the zero of
        the rounded value is far ahead. Rounding may let a step pass a zero, by no more than is linear.

        An event that is new and that is at the start but for rounding has happened, unless it waits for a sample
        between the start and its zero. Events that wait are the last of what is returned.
        """
        kind, way = near.type, work.array("way", near.type)[0]
        sides = [1.0 - 2.0 * work.array("parameters", kind)[place] for place in self.conditions]
        passed, shifts, waiting = [near] * len(sides), list[Value](), dict[int, Value]()
        for i in range(self.events):
            value, slope = (work.array("watched", kind)[len(sides) * self._orders + n] for n in (0, 1))
            slope = self._kernel.per_unit(work, slope)
            side, uncertain, shift = work.array("sides", kind)[i], work.array("uncertain", kind), -value / slope
            left = side.is_("eq", 0.0) & abs(value).is_("le", uncertain[i])
            present = left.choose(slope * way, value)
            sides.append(side.is_("eq", 0.0).choose(side.like(1.0).intrinsic("copysign", present), side))
            passed.append(left.choose(near.larger((2.0 * abs(shift)).smaller(linear)), near))
            for target in self._kernel.sampling.targets:
                ahead = self._ahead(work, target).high
                new = side.is_("eq", 0.0) & ~left & shift.is_("le", near)
                waiting[i] = new & ahead.is_("gt", 0.0) & shift.is_("ge", ahead - AT_TARGET * near)
            shifts.append(abs(shift).is_("le", linear).choose(shift, 0.0))
            uncertain[i] = near * abs(slope)
        return sides, passed, shifts, waiting

    def _switched(self, lines: Lines, work: Record) -> Value:
        """Return where a condition that stops a lane has switched since its last step, if it has taken one."""
        kind, switched = self._kernel.kind, lines.constant(vector(BOOL, self._lanes), 0)
        for i in self._stops:
            change = work.array("parameters", kind)[self.conditions[i]] - work.array("branches", kind)[i]
            switched = switched | abs(change).is_("gt", 0.5)
        return switched

    def _turn(self, work: Record, sides: Sequence[Value], here: Sequence[Value], moves: Value) -> None:
        """Switch conditions and turn the sides of events; note which of these are at the end of the step."""
        kind, whole, first = self._kernel.kind, self._kernel.whole, len(self.conditions)
        for i, place in enumerate(self.conditions):
            held = work.array("parameters", kind)[place]
            work.array("parameters", kind)[place] = here[i].choose(1.0 - held, held)
        for name in ("which", "rising") if self.events else ():
            for word, marked in enumerate(self._bits(work, sides, [mask & moves for mask in here[first:]], name)):
                work.array(name, whole)[word] = marked
        for i in range(self.events):
            side = sides[first + i]
            work.array("sides", kind)[i] = here[first + i].choose(-side, side)

    def _bits(self, work: Record, sides: Sequence[Value], here: Sequence[Value], name: str) -> list[Value]:
        """Return the marks of the events that happen, or of the events among them that rise with time."""
        way, first = work.array("way", self._kernel.kind)[0], len(self.conditions)
        words = [work.array("which", self._kernel.whole)[0] * 0] * self.words
        for i, mask in enumerate(here):
            chosen = mask & (sides[first + i] * way).is_("lt", 0.0) if name == "rising" else mask
            words[i // BITS] = words[i // BITS] | (chosen.to_integer() << i % BITS)
        return words

    def _note_all(
        self,
        lines: Lines,
        work: Record,
        sides: Sequence[Value],
        shifts: Sequence[Value],
        wrong: Sequence[Value],
        active: Value,
    ) -> Value:
        """Note the events at the start of the step, and return where one stops the lane."""
        if not self.events:
            return lines.constant(vector(BOOL, self._lanes), 0)
        known = [work.array("sides", self._kernel.kind)[i].is_("ne", 0.0) for i in range(self.events)]
        here = [mask & side for mask, side in zip(wrong[len(self.conditions) :], known, strict=True)]
        for name in ("which", "rising"):
            bits = work.array(name, self._kernel.whole)
            for word, marked in enumerate(self._bits(work, sides, here, name)):
                bits[word] = bits[word] ^ marked  # what turns back is not there yet
        marks, nowhere = list[Value](), lines.constant(vector(BOOL, self._lanes), 0)
        happens = stops = nowhere
        for word in range(self.words):
            rising = work.array("rising", self._kernel.whole)[word]
            crossings = list(enumerate(self._crossings[word * BITS : (word + 1) * BITS]))
            falls, rises = (sum(1 << i for i, x in crossings if x.direction == way) for way in (-1, 1))
            stopping = sum(1 << i for i, x in crossings if x.stops)
            which = work.array("which", self._kernel.whole)[word] & ~((rising & falls) | (~rising & rises))
            work.array("which", self._kernel.whole)[word] = which
            stops, happens = stops | (which & stopping).is_("ne", 0), happens | which.is_("ne", 0)
            marks.append(which)
        shift = shifts[0] * 0.0
        for i, own in enumerate(shifts):
            word, bit = bit_of(i)
            shift = ((marks[word] & bit).is_("ne", 0) & ~stops).choose(own, shift)
        work.array("shift", self._kernel.kind)[0] = shift
        self._kernel.for_each(lines, work, active & happens, "note")
        return stops

    def _note(self, address: Value, lane: Value) -> None:
        """Note what happens to a lane."""
        kernel, work = self._kernel, Record(address, self._kernel.work)
        count = work.array("noted", INTEGER)
        notes = Array(work.array("notes", POINTER)[0], f"[{self.note.itemsize} x i8]")
        note = Record(notes.at(count[0]), self.note)
        count[0] = count[0] + 1
        note.array("task", INTEGER)[0] = work.array("task", INTEGER)[lane]
        for name in ("which", "rising"):
            for word in range(self.words):
                note.array(name, INTEGER)[word] = work.array(name, INTEGER)[lane + word * self._lanes]
        shift = ahead = work.array("shift")[lane]
        if kernel.wide:
            ahead = shift / work.array("unit")[lane]
        note.array("time")[0] = work.array("time")[lane] + shift
        note.array("near")[0] = work.array("near")[lane]
        states, rates = (kernel.layout.states(address, n).of(DOUBLE) for n in (0, 1))
        out = note.array("state")
        for k in range(kernel.variables):
            value = rates[lane + k * self._lanes].high.fma(ahead, states[lane + k * self._lanes].high)
            out[k] = kernel.momenta.outwards(work, k, value, lane)
