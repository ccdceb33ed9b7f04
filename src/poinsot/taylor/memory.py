"""Memory of a kernel: places of the Taylor coefficients, fields of a worker, and the interface of parts of a kernel.

There are two layouts of the coefficients: vectors hold members ("batch"), or inner sums of one member ("single"). Both
write the loops of the inner sums and add in one order, sum_{j=2..n-1} a_j b_{n-j}, then a_1 b_{n-1}: what order n - 1
has just given comes last.
"""

from __future__ import annotations

import collections
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, TypeVar

import numpy as np
from typing_extensions import override

from poinsot.taylor.decomposition import CoefficientRow, Decomposition, Schedule
from poinsot.taylor.llvm_ir import (
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    Structure,
    Value,
    Wide,
    WideValue,
    host_features,
    vector,
)

__all__ = [
    "QUEUE",
    "Batch",
    "Body",
    "Context",
    "Field",
    "KernelPart",
    "Layout",
    "Rolled",
    "Single",
    "Work",
    "layout_of",
]

SUMS_PER_VECTOR = 4
"""Number of inner sums of one member in a vector."""

MIN_ROLLED = 200
"""Inner sums of one member from which on a loop over parts computes them. Fewer run faster as straight-line code."""

Layout = Literal["batch", "single"]

Element = TypeVar("Element")


class CoefficientMemory:
    """The memory of coefficients: double precision, or all high parts and behind them all low parts.

    Attributes
    ----------
    lanes : int
        Members in a vector.
    size : int
        Number of doubles.
    """

    def __init__(self, numbers: int, lanes: int, wide: bool) -> None:
        self._distance = -(-numbers // 8) * 8  # a multiple of the longest vector
        self.lanes, self._wide, self.size = lanes, wide, self._distance * (1 + wide)

    def _kind(self, lanes: int) -> str:
        """Return the type of vectors."""
        return Wide(vector(DOUBLE, lanes)) if self._wide else vector(DOUBLE, lanes)

    def _array(self, address: Value, lanes: int) -> Array:
        """Return memory as numbers or vectors of numbers."""
        return Array(address, self._kind(lanes), self._distance // lanes)

    def _together(self, lanes: int) -> int:
        """Return the number of vectors whose sums stay in registers together."""
        return max(_registers(lanes) // (6 if self._wide else 1), 1)


class Batch(CoefficientMemory):
    """Vectors hold members: coefficients of the states and of the rows of inner sums, order by order."""

    def __init__(self, schedule: Schedule, variables: int, order: int, lanes: int, wide: bool) -> None:
        states = {row: schedule.state_of(row) for row in schedule.rows}
        stored = [row for row, place in states.items() if place is None]
        self._stored = {row: variables + i for i, row in enumerate(stored)}
        self._places = self._stored | {row: place for row, place in states.items() if place is not None}
        self._stride = variables + len(stored)
        super().__init__((order + 1) * self._stride * lanes, lanes, wide)
        self._groups = _parts(schedule.groups, self._together(lanes))

    def states(self, memory: Value, n: Value | int) -> Array:
        """Return the coefficients of the states of some order."""
        whole = self._array(memory, self.lanes)
        return whole.from_(whole.at(n * self._stride))

    def store(self, memory: Value, n: Value, row: CoefficientRow, value: Value) -> None:
        """Store a row of inner sums of higher orders."""
        if row in self._stored:
            self.states(memory, n)[self._stored[row]] = value

    def inner_sums(self, memory: Value, n: Value) -> Callable[[int], Value]:
        """Write the inner sums of an order."""
        sums: dict[int, Value] = {}
        for group in self._groups:
            pairs = [(self._places[inner.first], self._places[inner.second]) for inner in group]
            found = _multiplied(n, functools.partial(self.states, memory), self._stride, pairs)
            sums |= {inner.place: total for inner, total in zip(group, found, strict=True)}
        return sums.__getitem__


class Single(CoefficientMemory):
    """Vectors hold inner sums of one member: each coefficient is stored once for each place where it is read."""

    def __init__(self, schedule: Schedule, variables: int, order: int, wide: bool, unit: int = SUMS_PER_VECTOR) -> None:
        inner = [inner for group in schedule.groups for inner in group]
        self._count = -(-len(inner) // unit) * unit
        self._index = {one.place: i for i, one in enumerate(inner)}
        self._places: dict[CoefficientRow, list[int]] = {}
        for i, one in enumerate(inner):
            self._places.setdefault(one.first, []).append(i)
            self._places.setdefault(one.second, []).append(self._count + i)
        self._variables, self._stride = variables, 2 * self._count
        self._open: dict[int, Value] = {}
        self._left: dict[int, int] = {}
        self._filled = collections.Counter(
            place // SUMS_PER_VECTOR for places in self._places.values() for place in places
        )
        self._sums = (order + 1) * self._stride
        self._ahead = (order + (len(schedule.outputs) > variables)) & 1
        self._states = self._sums + 2 * self._count
        super().__init__(self._states + (order + 1) * variables, 1, wide)

    def _at(self, memory: Value, place: Value | int, lanes: int = 1) -> Array:
        """Return memory from a place on, counted in numbers."""
        return self._array(self._array(memory, 1).at(place), lanes)

    def states(self, memory: Value, n: Value | int) -> Array:
        """Return the coefficients of the states of some order."""
        return self._at(memory, n * self._variables + self._states)

    def store(self, memory: Value, n: Value, row: CoefficientRow, value: Value) -> None:
        """Store a row of inner sums of higher orders, vectors as soon as they are complete."""
        for place in self._places.get(row, ()):
            block = place // SUMS_PER_VECTOR
            vector_of = self._open.setdefault(block, n.function.constant(self._kind(SUMS_PER_VECTOR), 0.0))
            self._open[block] = vector_of.with_lane(place % SUMS_PER_VECTOR, value)
            self._left[block] = self._left.get(block, self._filled[block]) - 1
            if not self._left[block]:
                self._at(memory, n * self._stride, SUMS_PER_VECTOR)[block] = self._open.pop(block)
                del self._left[block]

    def inner_sums(self, memory: Value, n: Value) -> Callable[[int], Value]:
        """Write the inner sums of an order; every other adds most terms of the next too, and loads nothing for them.

        The last order then adds nothing ahead, and the second order needs no terms of the first.
        """
        lines, far, stride = n.function, self._count // SUMS_PER_VECTOR, self._stride // SUMS_PER_VECTOR
        first_of_two = (n & 1).is_("eq", self._ahead) | n.is_("eq", 1)

        def arrays(memory: Value) -> tuple[Callable[[Value | int], Array], Array, Array]:
            found, ahead = (self._at(memory, self._sums + i * self._count, SUMS_PER_VECTOR) for i in range(2))
            return lambda j: self._at(memory, j * self._stride, SUMS_PER_VECTOR), found, ahead

        def two(memory: Value, part: Sequence[int]) -> None:
            rows, found, ahead = arrays(memory)
            own, following = _two_multiplied(n, rows, stride, [(block, block + far) for block in part])
            for block, total, later in zip(part, own, following, strict=True):
                found[block], ahead[block] = total, later

        def rest(memory: Value, part: Sequence[int]) -> None:
            rows, found, ahead = arrays(memory)
            for block in part:
                found[block] = _rest(n, rows, newest, (block, block + far), ahead[block])

        with lines.when(first_of_two):
            self._each_part(memory, two)
        with lines.when(~first_of_two):
            newest = n.is_("gt", 2).choose(n - 1, 0)  # the newest one that was not known ahead; of order 2 row 0: zero
            self._each_part(memory, rest)
        found = self._at(memory, self._sums)
        return lambda place: found[self._index[place]]

    def _each_part(self, memory: Value, write: Callable[[Value, Sequence[int]], None]) -> None:
        """Write the inner sums of parts: vectors by their numbers, in the memory from an address on."""
        for part in _parts([range(self._count // SUMS_PER_VECTOR)], max(self._together(SUMS_PER_VECTOR) // 3, 1)):
            write(memory, part)


class Rolled(Single):
    """Inner sums of one member in a loop over parts of equal size: one text for all parts of a large system.

    Each coefficient is stored by itself. The vectors of `Single` would stay open over thousands of operations, in
    registers that these need.
    """

    def __init__(self, schedule: Schedule, variables: int, order: int, wide: bool) -> None:
        self._part = range(1 if wide else _registers(SUMS_PER_VECTOR) // 3)
        super().__init__(schedule, variables, order, wide, len(self._part) * SUMS_PER_VECTOR)

    @override
    def store(self, memory: Value, n: Value, row: CoefficientRow, value: Value) -> None:
        for place in self._places.get(row, ()):
            self._at(memory, n * self._stride)[place] = value

    @override
    def _each_part(self, memory: Value, write: Callable[[Value, Sequence[int]], None]) -> None:
        unit, whole = len(self._part) * SUMS_PER_VECTOR, self._at(memory, 0)
        memory.function.count(self._count // unit, lambda part: write(whole.at(part * unit), self._part))


def layout_of(layout: Layout, schedule: Schedule, variables: int, order: int, lanes: int, wide: bool) -> Batch | Single:
    """Return the places of the coefficients of a schedule."""
    if layout == "batch":
        return Batch(schedule, variables, order, lanes, wide)
    return (Rolled if schedule.sums >= MIN_ROLLED else Single)(schedule, variables, order, wide)


def _rest(n: Value, rows: Callable[[Value | int], Array], newest: Value, pair: tuple[int, int], ahead: Value) -> Value:
    """Write the sum of an order whose terms were added ahead, but for j = n - 1 and, at last, j = 1."""
    first, second = pair
    total = rows(newest)[first].product_added(rows(newest.smaller(1))[second], ahead)
    return rows(1)[first].product_added(rows(n - 1)[second], total).normalized()


def _two_multiplied(
    n: Value, rows: Callable[[Value | int], Array], stride: int, pairs: Sequence[tuple[int, int]]
) -> tuple[list[Value], list[Value]]:
    """Write the sums of `_multiplied`, and the sums of the next order without j = n and, at last, j = 1."""
    count, ones = len(pairs), rows(1)

    def body(j: Value, up: Value, down: Value, *carried: Value) -> list[Value]:
        before, totals = carried[:count], carried[count:]
        first, second = ones.from_(up), ones.from_(down)
        firsts = [first[a] for a, _ in pairs]
        seconds = [second[b] for _, b in pairs]
        products = zip(firsts * 2, [*seconds, *before], totals, strict=True)
        sums = [a.product_added(b, total) for a, b, total in products]
        return [j + 1, first.at(stride), second.at(-stride), *seconds, *sums]

    newest, nothing = rows(n - 1), [n.function.constant(ones.type, 0.0)] * (2 * count)
    start = [n.like(2), rows(2).address, rows(n - 2).address, *(newest[b] for _, b in pairs), *nothing]
    sums = n.function.repeat(start, lambda j, *_: j.is_("lt", n), body)[3 + count :]
    oldest = rows((n - 1).smaller(1))  # of order 1 there are no terms
    own = [oldest[a].product_added(newest[b], total) for (a, b), total in zip(pairs, sums[:count], strict=True)]
    return [total.normalized() for total in own], sums[count:]


def _multiplied(
    n: Value, rows: Callable[[Value | int], Array], stride: int, pairs: Sequence[tuple[int, int]]
) -> list[Value]:
    """Write sum_{j=1..n-1} a_j b_{n-j} for pairs of places in an order, in one loop over j from 2 on; 1 comes last."""
    ones, oldest, newest = rows(1), rows(1).address, rows(n - 1).address

    def body(j: Value, up: Value, down: Value, *totals: Value) -> list[Value]:
        first, second = ones.from_(up), ones.from_(down)
        firsts, seconds = functools.cache(first.__getitem__), functools.cache(second.__getitem__)
        sums = [firsts(a).product_added(seconds(b), total) for (a, b), total in zip(pairs, totals, strict=True)]
        last = (j + 1).is_("eq", n)
        return [j + 1, last.choose(oldest, first.at(stride)), last.choose(newest, second.at(-stride)), *sums]

    nothing, alone = [n.function.constant(ones.type, 0.0)] * len(pairs), n.is_("eq", 2)
    starts = [alone.choose(oldest, rows(2).address), alone.choose(newest, rows(n - 2).address)]
    found = n.function.repeat([n.like(2), *starts, *nothing], lambda j, *_: j.is_("le", n), body)[3:]
    return [total.normalized() for total in found]


def _parts(groups: Sequence[Sequence[Element]], most: int) -> list[Sequence[Element]]:
    """Return groups cut into parts of about equal length."""
    parts = []
    for group in groups:
        count = -(-len(group) // most)
        parts += [group[i * len(group) // count : (i + 1) * len(group) // count] for i in range(count)]
    return parts


def _registers(lanes: int) -> int:
    """Return the number of vectors whose sums fit into the registers."""
    features = host_features()
    own, count = (8, 24) if features.get("avx512f") else (2, 24) if features.get("neon") else (4, 12)
    return max(count // -(-lanes // own), 1)


# ---------------------------------------------------------------------- memory of a worker

QUEUE = np.dtype([(name, "i8") for name in ("next", "count", "members", "tasks", "times", "rows")])
"""The record of a queue: counts and addresses."""

Field = tuple[str, str, tuple[int, ...]]
"""A field of a structure in memory: name, NumPy type and shape."""


class Context:
    """Sizes of a kernel, and the types of its vectors and structures.

    Parameters
    ----------
    decomposition : Decomposition
    order : int
        Degree of the Taylor polynomials.
    wide : bool
        True if numbers are double-double.
    layout : Batch or Single
        Places of the Taylor coefficients.

    Attributes
    ----------
    variables, parameters, events : int
        Numbers of state variables, of parameters of a member, and of events.
    conditions : tuple of int
        The parameters that hold the conditions.
    scaled : tuple of int
        The state variables that are proportional to the scale of momenta.
    lanes, words : int
        Members in a vector, and doubles in a number.
    kind, whole, number : str
        Types of vectors with one element for each lane: doubles, integers, and numbers in the precision of the kernel.
    work, task, step, record : structured types
        Memory of a worker, task, stored step, and record of events. The parts of the kernel declare their fields.
    """

    work: np.dtype[np.void]
    task: np.dtype[np.void]
    step: np.dtype[np.void]
    record: np.dtype[np.void]

    def __init__(self, decomposition: Decomposition, order: int, wide: bool, layout: Batch | Single) -> None:
        self.order, self.wide, self.layout = order, wide, layout
        self.variables, self.parameters = len(decomposition.rates), decomposition.parameters
        self.conditions, self.events = decomposition.conditions, len(decomposition.events)
        self.scaled, self.lanes, self.words = decomposition.momenta.scaled, layout.lanes, 1 + wide
        self.kind, self.whole = vector(DOUBLE, layout.lanes), vector(INTEGER, layout.lanes)
        self.number = Wide(self.kind) if wide else self.kind


class Work(Structure):
    """The memory of a worker, seen by the functions of a kernel.

    Fields of lanes are vectors with one element for each lane. A function of all lanes reads whole vectors (`doubles`,
    `integers`, `numbers`); a function of one lane reads elements (`array`).
    """

    def __init__(self, address: Value, context: Context) -> None:
        super().__init__(address, context.work)
        self.context, self.lines = context, address.function

    def doubles(self, name: str) -> Array:
        """Return a field as vectors of doubles."""
        return self.array(name, self.context.kind)

    def integers(self, name: str) -> Array:
        """Return a field as vectors of integers."""
        return self.array(name, self.context.whole)

    def numbers(self, name: str) -> Array:
        """Return a field as vectors of numbers in the precision of the kernel."""
        return self.array(name, self.context.number)

    @property
    def active(self) -> Value:
        """Mask of the lanes that have a task."""
        return self.integers("active")[0].is_("ne", 0)

    def states(self, n: Value | int) -> Array:
        """Return the coefficients of order n of the state variables."""
        return self.context.layout.states(self.address, n)

    def queue(self) -> Structure:
        """Return the record of the queue."""
        return Structure(self.array("queue", POINTER)[0], QUEUE)

    def task(self, lane: Value) -> Structure:
        """Return the task of a lane."""
        tasks, number = self.queue().array("tasks", POINTER)[0], self.array("task", INTEGER)[lane]
        return Structure.of(tasks, number, self.context.task)

    def in_unit(self, rate: Value) -> Value:
        """Return a rate, per unit of time of the Taylor coefficients.

        In quadruple precision the unit is about the radius of convergence, so that powers of it neither overflow nor
        lose digits at order 38. Rates have the unit 1 in double precision.
        """
        return rate.times_power_of_two(self.doubles("unit")[0]) if self.context.wide else rate

    def per_unit(self, time: Value) -> Value:
        """Return a time in that unit, or a rate from one in that unit."""
        return time.times_power_of_two(1.0 / self.doubles("unit")[0]) if self.context.wide else time

    def unscaled(self, k: int, value: Value, place: Value | int = 0) -> Value:
        """Return a variable, or a derivative of it, in the scale of momenta at the start."""
        scaled = k in self.context.scaled
        return value.times_power_of_two(self.array("outward", str(value.type))[place]) if scaled else value

    def over_order(self, n: Value) -> Callable[[Value], Value]:
        """Return the division by n, by 1/n in two parts: the rounding of one would have the same sign at every step."""
        parts = ("reciprocals_of_orders", "reciprocals_below")
        high, low = (self.array(name)[n].spread(self.context.lanes) for name in parts)
        if self.context.wide:
            return lambda value: value * WideValue(high, low)
        return lambda value: value.fma(high, value * low)

    def ahead(self, target: Value) -> Value:
        """Return the time from the start of the step to a time."""
        time = self.doubles("time")
        if self.context.wide:
            return WideValue(target, target.like(0.0)) - WideValue(time[0], time[1])
        return (target - time[0]) - time[1]

    def for_each(self, which: Value, name: str) -> None:
        """Call a function of one lane for the lanes of a mask."""
        lines = self.lines
        with lines.when(which.any()):
            flags = self.integers("flags")
            flags[0] = which.to_integer()

            def one(lane: Value) -> None:
                with lines.when(flags.of(INTEGER)[lane].is_("ne", 0)):
                    lines.run(name, self.address, lane)

            lines.count(self.context.lanes, one)


Body = Callable[[Work, Value], None]
"""The body of a function of one lane: it writes the instructions for the memory of a worker and a lane."""


class KernelPart:
    """A part of a kernel: its fields in memory, its functions, and its actions where lanes change their tasks.

    Attributes
    ----------
    of_tasks_and_lanes : sequence of Field
        Fields of a task that a lane copies when it takes the task, and copies back when it leaves the task.
    of_tasks, of_lanes, of_workers : sequence of Field
        Fields of tasks alone, of lanes alone, and of a worker.
    functions, seldom : dict
        Functions of one lane by their names: functions of steps, and functions that run at most once a task.
    """

    of_tasks_and_lanes: Sequence[Field] = ()
    of_tasks: Sequence[Field] = ()
    of_lanes: Sequence[Field] = ()
    of_workers: Sequence[Field] = ()
    functions: Mapping[str, Body] = {}
    seldom: Mapping[str, Body] = {}

    def __init__(self, context: Context) -> None:
        self.context = context

    def taken(self, work: Work, task: Structure, lane: Value) -> None:
        """Write the actions of a lane that has taken a task."""

    def stayed(self, work: Work, lane: Value) -> None:
        """Write the actions of a lane that stays in its task after it has called `leave`."""

    def left(self, work: Work, task: Structure, lane: Value) -> None:
        """Write the actions of a lane before it copies its fields back to its task."""
