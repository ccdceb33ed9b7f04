"""What is done with the events that a looped kernel has noted: they are recorded, act on the state and end a motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.dense_output import Action
from poinsot.integration.problem import Problem
from poinsot.integration.state_vector import StateVector
from poinsot.integration.termination import REASONS
from poinsot.mechanics.event import Event
from poinsot.mechanics.parameters import kinds_of, of_each
from poinsot.mechanics.state import State, changed, state_of
from poinsot.printable import described, message_of, quoted
from poinsot.taylor.detection import bit_of
from poinsot.taylor.kernels import Queue, Status
from poinsot.taylor.replay import Replay

__all__ = ["NotedEvents", "Recorded"]

ZENO = 1e-5
"""Actions are without end where the time between them shrinks from one to the next, by this at last."""

LARGEST = float(np.sqrt(np.finfo(float).max))
"""Momenta above this have rates that overflow."""

Recorded = tuple[int, float, int, NDArray[Any]]
"""Number of the event, time, sign of the rate in time, variables."""

Array = NDArray[Any]


class NotedEvents:
    """The events of the tasks of a queue.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    counting : Replay
        What is positive where zeros count, of variables, time and inputs.
    queue : Queue
    members : array (n,)
        Of each task.
    inputs : callable
        Times and members to the values of the inputs of the formulas.
    interrupt : callable
        Called on Ctrl-C within an action.
    stopped : callable
        Whether the run is to stop, so that nothing acts any more.

    Attributes
    ----------
    records : list of lists of Recorded
        What happened to each task.
    actions : list of lists of Action
        What the actions of each task have made.
    failed : dict
        Task -> why it stopped at an action.
    causes : dict
        Task -> what an action raised.
    """

    def __init__(
        self,
        problem: Problem,
        variables: StateVector,
        counting: Replay,
        queue: Queue,
        members: NDArray[np.int_],
        inputs: Callable[[Array, NDArray[np.int_]], list[Any]],
        interrupt: Callable[[], None],
        stopped: Callable[[], bool],
    ) -> None:
        self._problem, self._variables, self._counting, self._queue = problem, variables, counting, queue
        self._members, self._inputs, self._interrupt, self._stopped = members, inputs, interrupt, stopped
        tasks, events = queue.tasks, problem.events
        self.records: list[list[Recorded]] = [[] for _ in tasks]
        self.actions: list[list[Action]] = [[] for _ in tasks]
        self.failed: dict[int, str] = {}
        self.causes: dict[int, BaseException] = {}
        self._last = np.repeat(tasks["time"][:, :1], len(events), axis=1)
        samples = tasks["numbers"] * tasks["periods"] + tasks["phases"]
        self._to_sample = np.min(samples, axis=1, initial=np.inf) - tasks["time"][:, 0]
        self._since, self._longest = np.zeros((2, tasks.size, len(events)))
        self._bits = [(i, *bit_of(i)) for i in range(len(events))]
        self._singular = bit_of(len(events))

    def take(self, notes: Array) -> NDArray[np.int_]:
        """Let happen what was noted; return the tasks that stopped at an event and are to go on."""
        counts, rows = self._counts(notes), notes["state"]
        columns = [notes[name].tolist() for name in ("task", "which", "rising", "time", "near")]
        for row, own, task, which, rising, time, near in zip(rows, counts, *columns, strict=True):
            found = [
                (i, 1 if rising[word] & bit else -1) for i, word, bit in self._bits if which[word] & bit and own[i]
            ]
            new = [(i, direction) for i, direction in found if self._is_new(task, i, time, near)]
            if self._let_happen(task, new, time, row):
                self.actions[task].append(Action(time, near, row, *self._samples_around(task)))
                self._put_rows(task, self.actions[task][-1])
            word, bit = self._singular
            if word < len(which) and which[word] & bit:
                self.failed[task] = REASONS["angles"]
        tasks = self._queue.tasks
        stopped: NDArray[np.int_] = np.flatnonzero(tasks["status"] == Status.EVENT)
        tasks["status"][stopped] = Status.UNDER_WAY
        return stopped

    def _counts(self, notes: Array) -> Array:
        """Return which events count where they were noted, shape (notes, events)."""
        counts, members = np.ones((notes.size, len(self._bits)), dtype=bool), self._members[notes["task"]]
        if notes.size:
            given = [*notes["state"].T, notes["time"], *self._inputs(notes["time"], members)]
            for i, value in enumerate(self._counting(given)):
                counts[:, i] = value > 0
        return counts

    def _is_new(self, task: int, number: int, time: float, near: float) -> bool:
        """Return whether the event has not just happened, and note that it has.

        What the start of a task is near to has happened, unless it comes after a sample.
        """
        since = abs(time - self._last[task, number])
        self._last[task, number] = time
        if since <= near and not (self._since[task, number] == 0.0 and 0.0 < self._to_sample[task] <= near):
            return False
        if since >= self._since[task, number]:
            self._longest[task, number] = since
        elif self._problem.events[number].acts and since < ZENO * self._longest[task, number]:
            self.failed[task] = REASONS["zeno"]
        self._since[task, number] = since
        return True

    def _let_happen(self, task: int, new: list[tuple[int, int]], time: float, row: Array) -> bool:
        """Record events with their directions, and act, in the order of the list; return True if an event has acted."""
        acted = False
        for number, direction in new:
            event = self._problem.events[number]
            self.records[task].append((number, time, direction, row.copy()))
            if event.acts and not self._stopped():
                acted |= self._act(task, number, time, row)
            if event.terminal:
                self._queue.tasks["status"][task] = Status.ENDED
        return acted

    def _change(self, own: Any, before: Array, after: Array) -> None:
        """Give a task the variables after an action; unchanged ones have their low parts in quadruple precision."""
        low = own["below"][: after.size]
        own["state"][: after.size], own["sides"] = after, 0.0
        low[:] = np.where(after == before, low, 0.0) if self._queue.wide else 0.0

    def _put_rows(self, task: int, action: Action) -> None:
        """Put the variables after an action into the rows at its time, which the kernel writes before the action."""
        own, output = self._queue.tasks[task], self._queue.output
        rows, stride = output.rows.reshape(-1, action.row.size), int(own["stride"])
        for back in range(1, int(own["index"]) + 1):
            step = (int(own["index"]) - back) * stride
            if not action.at(output.times[own["first"] + step]):
                return
            rows[own["place"] + step] = action.row

    def _samples_around(self, task: int) -> tuple[float, float]:
        """Return the times of the last sample of a task that is done and of the next one."""
        own = self._queue.tasks[task]
        done, ahead = ((own["numbers"] - back) * own["periods"] + own["phases"] for back in (1.0, 0.0))
        return float(np.max(done, initial=-np.inf)), float(np.min(ahead, initial=np.inf))

    def _act(self, task: int, number: int, time: float, row: Array) -> bool:
        """Give a task the state that an event returns, or note why not; return True if there is one."""
        own, member = self._queue.tasks[task], int(self._members[task])
        try:
            after = _acted(self._problem, self._variables, number, member, time, row)
        except KeyboardInterrupt:
            self._interrupt()
        except Exception as error:
            self.failed[task], self.causes[task] = _why_failed(self._problem.events[number], error), error
        else:
            self._change(own, row[: after.size], after)
            row[: after.size] = after
            return True
        return False


def _acted(
    problem: Problem, variables: StateVector, number: int, member: int, time: float, row: NDArray[Any]
) -> NDArray[Any]:
    """Return the variables of the state that an event of a member returns; those of parts that it leaves out stay."""
    variables = variables.of_members(member)
    phase = variables.to_phase(np.array([time]), row[None])
    state, system = state_of(changed(phase, np.ravel), np.array(time)), problem.dynamics
    event, *records = (_of_member(record, member) for record in (problem.events[number], *system.records))
    body = system.with_records(records).at(state).acted_on
    after = event.act(body, state)
    if type(after) is not type(state) or after.shape:
        what = described(after) if type(after) is not type(state) else "one of several members"
        kind = "State of one body" if type(state) is State else "PairState"
        raise TypeError(f"an action must return a {kind}, got {what}.")
    if other := sorted(set(after.own) - set(state.own)):
        raise ValueError(f"an action must return variables of parts of the system, got some of {quoted(other[0])}.")
    after = state_of({**state.own, **after.phase}, after.time)
    largest = max(float(np.max(np.abs(values))) for values in after.phase.values())
    if largest > LARGEST:
        raise ValueError(f"an action must return momenta whose squares are finite, got {largest:.3g}.")
    new: NDArray[Any] = variables.with_state(row, after, np.array(time))
    return new


def _of_member(record: Any, member: int) -> Any:
    """Return a record with the numbers of one member."""
    fields = {}
    for name, kind in kinds_of(type(record)).items():
        value = getattr(record, name)
        if isinstance(kind, tuple):
            fields[name] = value[member] if np.ndim(value) > len(kind) else value
        else:
            fields[name] = of_each(value, lambda inner: _of_member(inner, member))
    return type(record).unchecked(**fields)


def _why_failed(event: Event, error: Exception) -> str:
    """Return the sentence about an action that failed."""
    text = f"{type(event).__name__}.act failed with {type(error).__name__}: {message_of(error)}"
    return text.rstrip(": .") + "."
