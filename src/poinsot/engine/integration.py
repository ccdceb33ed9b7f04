"""The integration of members in one direction, a chunk of steps at a time, on either of heyoka's engines.

The scalar engine has one lane, any precision and dense output; the batch engine has several lanes in double precision.
"""

from __future__ import annotations

import pickle
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.engine import kernels
from poinsot.engine.dense_output import Action, Side
from poinsot.engine.event_detection import Recorded
from poinsot.engine.state_vector import StateVector
from poinsot.engine.termination import INTERRUPTED, TRIES, reason

__all__ = ["BatchStepper", "DenseStepper", "Integration", "Polynomials", "ScalarStepper", "Stepper"]

SCALAR_STEPS, BATCH_STEPS = 20_000, 5_000
"""Steps between checks for Ctrl-C, of one body and of a batch: some hundredths of a second."""

Array = NDArray[Any]


class Stepper(ABC):
    """One of the two engines: how it takes times and grids, and where it leaves rows.

    Attributes
    ----------
    kernel : Kernel
    engine : the engine's integrator
    lanes : int
    chunk : int
        Steps at a time.
    """

    chunk: int

    def __init__(self, kernel: kernels.Kernel) -> None:
        self.kernel, self.engine = kernel, kernel.engine
        self.lanes = getattr(self.engine, "batch_size", 1)

    @abstractmethod
    def times(self) -> Array:
        """Return the time of each lane."""

    @abstractmethod
    def start(self, origins: Array, starts: Array) -> tuple[Any, Array]:
        """Return time and state for `place`, of lanes at their start."""

    @abstractmethod
    def place(self, time: Any, state: Array) -> None:
        """Set time and state of the lanes."""

    @abstractmethod
    def mark(self) -> tuple[Any, Array]:
        """Return time and state for `place`, with momenta in the scale of the start."""

    @abstractmethod
    def plan(self, ahead: list[Array], under_way: list[int], lead: int) -> Any:
        """Prepare steps along the times ahead of some lanes, of which `lead` has most; return where they end."""

    @abstractmethod
    def advance(self, most: int) -> tuple[list[Any], Array]:
        """Take so many steps at most; return what the engine says of each lane, and variables on the way.

        They have shape (n, size, lanes), and are NaN where there are none.
        """

    @abstractmethod
    def rows(self, lane: int, ahead: Array, passed: int) -> Array:
        """Return variables of a lane at the times ahead that it has passed in the last steps, in its own scale."""

    @abstractmethod
    def rows_of_all(self, ahead: list[Array]) -> Array | None:
        """Return those of the first lanes that have passed all times ahead; None if it cannot tell them at once."""

    def follow(self, lead: int, idle: list[int]) -> None:
        """Let idle lanes repeat another one."""
        raise NotImplementedError


class ScalarStepper(Stepper):
    """One lane, rows on a grid."""

    def __init__(self, kernel: kernels.Kernel, kind: Any) -> None:
        super().__init__(kernel)
        self.kind, self.chunk = kind, SCALAR_STEPS

    def _typed(self, values: Any) -> Array:
        return np.asarray(values) if self.kind is np.float64 else np.array([self.kind(x) for x in values])

    @override
    def times(self) -> Array:
        return np.array([float(self.engine.time)])

    @override
    def start(self, origins: Array, starts: Array) -> tuple[Any, Array]:
        return (self.kind(origins[0]), self.kind(0.0)), self._typed(starts[0])

    @override
    def place(self, time: Any, state: Array) -> None:
        self.engine.dtime, self.engine.state[:] = time, state

    @override
    def mark(self) -> tuple[Any, Array]:
        return self.engine.dtime, self.kernel.scales.outward(self.engine.state.copy(), 0)

    @override
    def plan(self, ahead: list[Array], under_way: list[int], lead: int) -> Any:
        self._grid = self._typed(ahead[0])
        return self._grid[-1]

    @override
    def advance(self, most: int) -> tuple[list[Any], Array]:
        if self._grid.size == 1:
            result = self.engine.propagate_until(self._grid[0], max_steps=most, **self.kernel.limits)
            self._found = np.empty((0, self.engine.state.size))
        else:
            grid = np.concatenate([self._typed([self.engine.time]), self._grid])  # the engine wants both
            result = self.engine.propagate_grid(grid, max_steps=most, **self.kernel.limits)
            self._found = result[5][1:]
        return [result], self._found[:, :, None]

    @override
    def rows(self, lane: int, ahead: Array, passed: int) -> Array:
        found = self._found[:passed]
        if len(found) < passed:  # the engine leaves out the row at which an event stops it, or has no grid
            found = np.concatenate([found, self.engine.state[None]])
        return np.asarray(found, dtype=float)

    @override
    def rows_of_all(self, ahead: list[Array]) -> Array | None:
        return self.rows(0, ahead[0], ahead[0].size)[None]


class DenseStepper(ScalarStepper):
    """One lane, rows from the polynomials of all steps, which are kept."""

    def __init__(self, kernel: kernels.Kernel, kind: Any, polynomials: Polynomials) -> None:
        super().__init__(kernel, kind)
        self._polynomials = polynomials

    @override
    def plan(self, ahead: list[Array], under_way: list[int], lead: int) -> Any:
        self._end = self.kind(ahead[0][-1])
        return self._end

    @override
    def advance(self, most: int) -> tuple[list[Any], Array]:
        result = self.engine.propagate_until(self._end, max_steps=most, c_output=True, **self.kernel.limits)
        self._piece = result[4]
        return [result], (self.engine.state[None] if self._piece is None else self._piece.tcs[:, :, 0])[..., None]

    @override
    def rows(self, lane: int, ahead: Array, passed: int) -> Array:
        if self._piece is None:
            return np.tile(np.asarray(self.engine.state, dtype=float), (passed, 1))
        self._polynomials.add(self._piece, int(self.kernel.scales.bits[0]))
        if not passed:
            return np.empty((0, self.engine.state.size))
        return np.array(self._piece(self._typed(ahead[:passed])), dtype=float)


class BatchStepper(Stepper):
    """Several lanes, each with its own time and grid.

    The engine wants grids of one length. What a grid lacks is filled up with times before its first one, at which
    nothing is read. Rows of a grid cost a tenth of the steps, so that one time ahead is no grid.
    """

    def __init__(self, kernel: kernels.Kernel) -> None:
        super().__init__(kernel)
        self.chunk = BATCH_STEPS

    @override
    def times(self) -> Array:
        return np.array(self.engine.time)

    @override
    def start(self, origins: Array, starts: Array) -> tuple[Any, Array]:
        return (origins, np.zeros(self.lanes)), starts.T

    @override
    def place(self, time: Any, state: Array) -> None:
        self.engine.state[:] = state
        self.engine.set_dtime(*map(list, time))

    @override
    def mark(self) -> tuple[Any, Array]:
        time, state = tuple(part.copy() for part in self.engine.dtime), self.engine.state.copy()
        for lane in map(int, np.flatnonzero(self.kernel.scales.bits)):
            state[:, lane] = self.kernel.scales.outward(state[:, lane], lane)
        return time, state

    @override
    def plan(self, ahead: list[Array], under_way: list[int], lead: int) -> Any:
        now, length = self.times(), ahead[lead].size
        short = [lane for lane in under_way if ahead[lane].size < length]
        near = [lane for lane in short if not _has_room(ahead[lane], now[lane], length)] if length > 1 else under_way
        if near:
            ends = now.copy()
            ends[near] = [ahead[lane][0] for lane in near]
            self._table, self._ends = None, ends
            return ends
        table = np.empty((length + 1, self.lanes))
        table[0], table[1:] = now, ahead[lead][:, None]
        for lane in under_way:
            table[-ahead[lane].size :, lane] = ahead[lane]
        for lane in short:
            table[:, lane] = _padded(ahead[lane], now[lane], length)
        self._table, self._ends = table, table[-1]
        return self._ends

    @override
    def advance(self, most: int) -> tuple[list[Any], Array]:
        if self._table is None:
            watched = self.kernel.detection is not None
            self.engine.propagate_until(list(self._ends), max_steps=most, write_tc=watched, **self.kernel.limits)
            self._found = np.where(self.times() == self._ends, self.engine.state, np.nan)[None]
        else:
            _, self._found = self.engine.propagate_grid(self._table, max_steps=most, **self.kernel.limits)
        return list(self.engine.propagate_res), self._found

    @override
    def rows(self, lane: int, ahead: Array, passed: int) -> Array:
        rows = self._found[-ahead.size :, :, lane][:passed]
        for row in np.flatnonzero(np.isnan(rows[:, 0])):  # the engine leaves these out where a lane stops or fails
            self.engine.update_d_output([ahead[row]] * self.lanes)
            rows[row] = self.engine.d_output[:, lane]
        return rows

    @override
    def rows_of_all(self, ahead: list[Array]) -> Array | None:
        length = ahead[0].size
        if any(grid.size != length for grid in ahead):
            return None
        rows = self._found[-length:, :, : len(ahead)].transpose(2, 0, 1)
        return None if np.isnan(rows[:, :, 0]).any() else rows

    @override
    def follow(self, lead: int, idle: list[int]) -> None:
        high, low = (np.array(part) for part in self.engine.dtime)  # the engine's time has two parts
        high[idle], low[idle] = high[lead], low[lead]
        self.engine.set_dtime(list(high), list(low))
        self.engine.state[:, idle] = self.engine.state[:, [lead]]
        self.kernel.repeat(lead, np.array(idle))


class Integration:
    """Members in the lanes of an engine, in one direction, each with its own start and its own times.

    The engine moves all its lanes. Those that are done, or that no member has, repeat one that is not, and nothing is
    taken from them.

    Parameters
    ----------
    stepper : Stepper
    members : array (count,)
        As many as there are lanes, or fewer.
    starts, origins : arrays (count, size) and (count,)
    grids : list of arrays
        The times of each, outwards from its origin.
    forwards : bool

    Attributes
    ----------
    steps, reached : arrays (count,)
        Steps taken, and the times reached.
    failed : list of str
        Why each stopped; empty if it did not.
    events : list of lists of Recorded
    actions : list of lists of Action
        What the actions of events have made of each member.
    cause : BaseException or None
        What an action raised.
    """

    def __init__(
        self,
        stepper: Stepper,
        members: NDArray[np.int_],
        starts: Array,
        origins: Array,
        grids: list[Array],
        forwards: bool,
    ) -> None:
        self._stepper, self._kernel, self._detection = stepper, stepper.kernel, stepper.kernel.detection
        self.members, self._starts, self._origins, self.forwards = members, starts, origins, forwards
        self.steps, self.reached = np.zeros(members.size, dtype=int), origins.copy()
        self.failed = [""] * members.size
        self.events: list[list[Recorded]] = [[] for _ in members]
        self.actions: list[list[Action]] = [[] for _ in members]
        self.cause: BaseException | None = None
        self.lasts = np.array([grid[-1] if grid.size else here for grid, here in zip(grids, origins, strict=True)])
        self._lanes = np.minimum(np.arange(stepper.lanes), members.size - 1)
        self._closely, self._tries = False, 0
        self._grids, self._ahead, self._rows = grids, list(grids), [list[Array]() for _ in members]
        self._later: Array | None = None  # the rows of all lanes behind the first ones, if they came at once
        for lane, grid in enumerate(grids):
            if grid.size and grid[0] == origins[lane]:
                self._ahead[lane], self._rows[lane] = grid[1:], [np.asarray(starts[lane : lane + 1], dtype=float)]

    def rows(self, lane: int) -> Array:
        """Return the variables of a lane at the times of its grid that it reached; shape (n, size)."""
        parts = self._rows[lane] if self._later is None else [*self._rows[lane], self._later[lane]]
        return parts[0] if len(parts) == 1 else np.concatenate([np.empty((0, self._starts.shape[1])), *parts])

    def put(self, out: Array, places: NDArray[np.intp]) -> None:
        """Put the variables at the times reached into an array (count, n, size), by where each lane starts in it."""
        if self._later is not None and (places == places[0]).all():
            here = out[:, places[0] :] if self.forwards else out[:, : places[0]][:, ::-1]
            first = len(self._rows[0])
            if first:
                here[:, 0] = self._starts
            here[:, first : first + self._later.shape[1]] = self._later
            return
        for lane, place in enumerate(places.tolist()):
            found = self.rows(lane)
            here = out[lane, place:] if self.forwards else out[lane, :place][::-1]
            here[: len(found)] = found

    def chunks(self) -> Iterator[None]:
        """Integrate every lane over its grid; yield after each chunk of steps."""
        self._chunk = self._kernel.steps_at_a_time(self._stepper.chunk, first=True)
        under_way = self._under_way()
        if under_way:
            self._limit_steps(0)
            self._place(self._lanes, *self._stepper.start(self._origins[self._lanes], self._starts[self._lanes]))
        while under_way and INTERRUPTED not in self.failed:
            self._advance(under_way)
            yield
            under_way = self._under_way()
        if self._detection is not None:
            self.cause = self._detection.error

    @property
    def finished(self) -> bool:
        """Whether all members are at their end."""
        return not self._under_way() and INTERRUPTED not in self.failed

    def _under_way(self) -> list[int]:
        """Return the lanes that have something ahead."""
        return [lane for lane, grid in enumerate(self._ahead) if grid.size]

    def _place(self, lanes: NDArray[np.int_], time: Any, state: Array) -> None:
        """Put the members of some lanes into the engine's, with states in the scale of the start."""
        self._stepper.place(time, state)
        self._kernel.begin(self.forwards, self.members[lanes])
        if self._detection is not None:
            self._detection.records, self._detection.actions = [], []

    def _limit_steps(self, tries: int) -> None:
        self._tries = tries
        if self._kernel.watches:
            self._kernel.limit_steps(np.abs(self.lasts - self._origins)[self._lanes], tries)

    def _mark(self, lead: int, idle: list[int]) -> Callable[[], None]:
        """Return what brings the engine back to where it is."""
        lanes, (time, state) = self._lanes, self._stepper.mark()
        if idle:
            lanes = lanes.copy()
            lanes[idle] = lead

        def back() -> None:
            self._place(lanes, time, state)
            if idle:
                self._stepper.follow(lead, idle)

        return back

    def _advance(self, under_way: list[int]) -> None:
        """Take a chunk of steps, or go back to where it began if it is to be taken again."""
        stepper, kernel = self._stepper, self._kernel
        sizes = [grid.size for grid in self._ahead]
        lead = sizes.index(max(sizes))
        idle = sorted({*range(stepper.lanes)}.difference(under_way))
        if idle:
            stepper.follow(lead, idle)
        before, back = stepper.times(), self._mark(lead, idle)
        ends = stepper.plan(self._ahead, under_way, lead)
        most = taken = self._chunk
        if self._closely:
            taken = kernel.sound_steps(ends, most)
            back()
        kernel.certain(self._closely)
        found = stepper.advance(taken)
        if self._closely:
            taken, found = self._sound(taken, found, before, under_way, back)
        results, on_the_way = found
        doubtful = kernel.doubtful(under_way, results, on_the_way)
        if self._goes_back(doubtful, under_way, back):
            return
        reached = stepper.times()
        if self._read_all(under_way, results, reached):
            return
        for lane in under_way:
            ended = kernel.outcome(results[lane][0], lane)
            self.steps[lane] += results[lane][3]
            if ended == "step_limit" and taken < most:  # only a full chunk tells whether the steps lead anywhere
                ended = "success"
            self._read(lane, ended, float(before[lane]), float(reached[lane]))
        self.take_events()
        kernel.rescale()
        self._chunk, self._closely = kernel.steps_at_a_time(stepper.chunk), doubtful

    def _sound(
        self, taken: int, found: Any, before: Array, under_way: list[int], back: Callable[[], None]
    ) -> tuple[int, Any]:
        """Take fewer steps where as many as were rehearsed fail, or more where they lead nowhere; return them.

        For each event at the start of a chunk the engine takes a step of length 0, in a rehearsal or here alone.
        """
        stepper, kernel, most = self._stepper, self._kernel, self._chunk
        while taken > 1 and kernel.failing(under_way, found[0]):
            taken //= 2
            back()
            found = stepper.advance(taken)
        while (
            taken < most
            and np.array_equal(stepper.times(), before)
            and all(kernel.outcome(found[0][lane][0], lane) == "step_limit" for lane in under_way)
        ):
            taken += 1
            back()
            found = stepper.advance(taken)
        return taken, found

    def _goes_back(self, doubtful: bool, under_way: list[int], back: Callable[[], None]) -> bool:
        """Go back to the start of a chunk that must be taken again, closely or for a lost zero; return whether so."""
        if doubtful and not self._closely:
            self._closely = True
        elif not (overlooked := self._kernel.overlooked(under_way)):
            if self._tries:
                self._limit_steps(0)
            return False
        elif self._tries == TRIES:
            for lane in overlooked:
                self._kernel.settle(lane)
            self._limit_steps(0)
            return False
        else:
            self._limit_steps(self._tries + 1)
        back()
        return True

    def _read_all(self, under_way: list[int], results: list[Any], reached: Array) -> bool:
        """Keep what the first chunk of steps has brought, if it has brought all members to their ends."""
        kernel, count = self._kernel, self.members.size
        if len(under_way) < count or self._detection is not None or kernel.scales.bits.any() or self.steps.any():
            return False
        if {int(result[0]) for result in results[:count]} != {kernels.TIME_LIMIT}:
            return False
        self._later = self._stepper.rows_of_all(self._ahead)
        if self._later is None:
            return False
        self.steps += [result[3] for result in results[:count]]
        self.reached, self._ahead = reached[:count], [reached[:0]] * count
        return True

    def _read(self, lane: int, ended: str, before: float, reached: float) -> None:
        """Keep what a chunk of steps has brought to a lane."""
        ahead, sign = self._ahead[lane], 1 if self.forwards else -1
        if ended == "err_nf_state":
            self._ahead[lane], self.failed[lane] = ahead[:0], reason(ended, 0.0, before, 0.0, self._chunk)
            return
        passed = int(np.searchsorted(sign * ahead, sign * reached, side="right"))
        rows = self._stepper.rows(lane, ahead, passed)
        self._rows[lane].append(self._kernel.scales.outward(rows, lane))
        self.reached[lane] = reached
        if passed == ahead.size and ended in ("time_limit", "step_limit", "success"):
            ended = self._look_at_end(lane)
        advance, left = abs(reached - before), abs(self.lasts[lane] - reached)
        self.failed[lane] = reason(ended, advance, reached, left, self._chunk)
        self._ahead[lane] = ahead[:0] if self.failed[lane] or ended == "event" else ahead[passed:]

    def _look_at_end(self, lane: int) -> str:
        """Let happen what is due at the end of a lane, and return how it ended."""
        if self._detection is None:
            return "time_limit"
        self._detection.look(self._stepper.engine, lane)
        return self._detection.stopped[lane] or "time_limit"

    def take_events(self) -> None:
        """Keep what happened in the last steps."""
        if self._detection is not None:
            for record in self._detection.records:
                self.events[record[1]].append(record)
            for lane, action in self._detection.actions:
                self.actions[lane].append(action)
                self._put_rows(lane, action)
            self._detection.records, self._detection.actions = [], []

    def _put_rows(self, lane: int, action: Action) -> None:
        """Put the variables after an action into the rows at its time."""
        parts = self._rows[lane]
        last = sum(map(len, parts))
        for i in range(len(parts) - 1, -1, -1):
            first = last - len(parts[i])
            here = np.abs(self._grids[lane][first:last] - action.time) <= action.near
            if here.any():
                parts[i] = np.where(here[:, None], action.row.astype(float), parts[i])
            last = first


def _has_room(ahead: Array, here: float, length: int) -> bool:
    """Whether the idle points that make a grid as long have room before its first time."""
    idle, ulp = length - ahead.size, np.spacing(max(abs(here), abs(ahead[0])))
    return bool(abs(ahead[0] - here) > 2 * (idle + 1) * ulp)


def _padded(ahead: Array, here: float, length: int) -> Array:
    """Return a grid of length + 1 that starts here and ends with the times ahead; the points between are idle."""
    idle = length - ahead.size
    return np.concatenate([here + (ahead[0] - here) * np.arange(idle + 1) / (idle + 1), ahead])


class Polynomials:
    """The Taylor polynomials of the steps of one body in one direction."""

    def __init__(self, variables: StateVector, kind: Any, forwards: bool) -> None:
        self._variables, self._kind, self._sign = variables, kind, 1.0 if forwards else -1.0
        self.pieces: list[Any] = []
        self._bits: list[int] = []

    def __getstate__(self) -> dict[str, Any]:  # with old protocols an engine's piece ends the interpreter
        return {**vars(self), "pieces": [pickle.dumps(piece) for piece in self.pieces]}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, pieces=[pickle.loads(piece) for piece in state["pieces"]])  # noqa: S301, as the rest

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self.pieces

    def add(self, piece: Any, bits: int) -> None:
        """Add those of a chunk of steps, with the scale of their momenta."""
        self.pieces.append(piece)
        self._bits.append(bits)

    def at(self, times: Array, side: Side = "left") -> Array:
        """Return the variables at times, at ends of pieces those of the piece on a side."""
        if len(self.pieces) == 1:
            return self._at(0, times)
        ends = np.array([float(piece.bounds[1]) for piece in self.pieces])
        which = np.minimum(np.searchsorted(self._sign * ends, self._sign * times, side), len(ends) - 1)
        out = np.empty((times.size, self._variables.size))
        for i in np.unique(which):
            chosen = which == i
            out[chosen] = self._at(i, times[chosen])
        return out

    def _at(self, number: int, times: Array) -> Array:
        typed = times if self._kind is np.float64 else np.array([self._kind(x) for x in times])
        rows = np.asarray(self.pieces[number](typed), dtype=float)
        return self._variables.rescaled(rows, -self._bits[number])
