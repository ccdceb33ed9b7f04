"""Log of the events that a kernel has found: records, actions on the state, ends of motions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poinsot.integration.kernel_parameters import KernelParameters
from poinsot.integration.report import REASONS, HeldInterrupts, Recorded
from poinsot.integration.rows import Action
from poinsot.kinematics.state import AnyState, State, changed, state_of
from poinsot.mechanics.event import Event
from poinsot.printable import described, message_of, quoted
from poinsot.quantities import Array
from poinsot.records.members import members_of
from poinsot.taylor.queue import Queue
from poinsot.taylor.tasks import Status

__all__ = ["EventLog"]

MIN_INTERVAL_RATIO = 1e-5
"""Ratio of the time between two actions to the longest time, below which shrinking intervals never end."""

MAX_MOMENTUM = float(np.sqrt(np.finfo(float).max))
"""Largest momentum whose rates do not overflow."""


class EventLog:
    """Events of the tasks of a queue.

    Parameters
    ----------
    parameters : KernelParameters
    queue : Queue
    members : array (n,)
        Member of each task.
    failed : dict
        Task -> reason why it is given up, which receives the reasons of tasks that stop at an action.
    interrupts : HeldInterrupts
        Receiver of Ctrl-C within an action. Events act no more if the run is to stop.

    Attributes
    ----------
    records : list of lists of Recorded
        Occurrences of events in each task.
    actions : list of lists of Action
        Results of the actions in each task.
    causes : dict
        Task -> exception raised by an action.
    """

    def __init__(
        self,
        parameters: KernelParameters,
        queue: Queue,
        members: NDArray[np.int_],
        failed: dict[int, str],
        interrupts: HeldInterrupts,
    ) -> None:
        self._parameters, self._queue, self._members = parameters, queue, members
        self._failed, self._interrupts, self._counting = failed, interrupts, parameters.formulas.counting
        tasks, self._events = queue.tasks, parameters.problem.events
        self.records: list[list[Recorded]] = [[] for _ in tasks]
        self.actions: list[list[Action[float]]] = [[] for _ in tasks]
        self.causes: dict[int, BaseException] = {}
        self._last = np.repeat(tasks["time"][:, :1], len(self._events), axis=1)
        samples = tasks["numbers"] * tasks["periods"] + tasks["offsets"]
        self._to_sample = np.min(samples, axis=1, initial=np.inf) - tasks["time"][:, 0]
        self._since, self._longest = np.zeros((2, tasks.size, len(self._events)))

    def take(self, notes: NDArray[np.void]) -> NDArray[np.int_]:
        """Apply the recorded crossings in their order; return the tasks that stopped at an event and go on."""
        counts, rows = self._counts(notes), notes["state"]
        columns = [notes[name].tolist() for name in ("task", "crossed", "time", "simultaneity")]
        for row, own, task, crossed, time, near in zip(rows, counts, *columns, strict=True):
            happened = [i for i, counted in enumerate(own) if counted and crossed[i]]
            new = [(i, int(crossed[i])) for i in happened if self._is_new(task, i, time, near)]
            if self._let_happen(task, new, time, row):
                self.actions[task].append(Action(time, near, row, *self._samples_around(task)))
                self._put_rows(task, self.actions[task][-1])
            if any(crossed[len(own) :]):  # variables near their singularity
                self._failed[task] = REASONS["angles"]
        tasks = self._queue.tasks
        stopped: NDArray[np.int_] = np.flatnonzero(tasks["status"] == Status.EVENT)
        tasks["status"][stopped] = Status.UNDER_WAY
        return stopped

    def _counts(self, notes: NDArray[np.void]) -> NDArray[np.bool_]:
        """Return the mask of the events that count at each crossing, shape (crossings, events)."""
        counts, members = np.ones((notes.size, len(self._events)), dtype=bool), self._members[notes["task"]]
        if notes.size:
            given = [*notes["state"].T, notes["time"], *self._parameters.inputs_around(notes["time"], members)]
            for i, value in enumerate(self._counting(given)):
                counts[:, i] = value > 0
        return counts

    def _is_new(self, task: int, number: int, time: float, near: float) -> bool:
        """Return True unless the same zero of the event was recorded before, and record its time.

        A zero near the start of a task was recorded by an earlier task, unless it comes after a sample.
        """
        since = abs(time - self._last[task, number])
        self._last[task, number] = time
        if since <= near and not (self._since[task, number] == 0.0 and 0.0 < self._to_sample[task] <= near):
            return False
        if since >= self._since[task, number]:
            self._longest[task, number] = since
        elif self._events[number].acts and since < MIN_INTERVAL_RATIO * self._longest[task, number]:
            self._failed[task] = REASONS["zeno"]
        self._since[task, number] = since
        return True

    def _let_happen(self, task: int, new: list[tuple[int, int]], time: float, row: Array) -> bool:
        """Record events with their directions and apply their actions, in order; return True if an event has acted."""
        acted = False
        for number, direction in new:
            event = self._events[number]
            self.records[task].append(Recorded(number, time, direction, row.copy()))
            if event.acts and not self._interrupts.stop:
                acted |= self._act(task, number, time, row)
            if event.terminal:
                self._queue.tasks["status"][task] = Status.ENDED
        return acted

    def _change(self, own: np.void, before: Array, after: Array) -> None:
        """Set the variables of a task after an action; low parts of unchanged variables remain."""
        low = own["below"][: after.size]
        own["state"][: after.size], own["signs"] = after, 0.0
        low[:] = np.where(after == before, low, 0.0) if self._queue.wide else 0.0

    def _put_rows(self, task: int, action: Action[float]) -> None:
        """Write the variables after an action into the rows at its time, which the kernel wrote before the action."""
        own, output = self._queue.tasks[task], self._queue.output
        rows, stride = output.rows.reshape(-1, action.row.size), int(own["stride"])
        for back in range(1, int(own["index"]) + 1):
            step = (int(own["index"]) - back) * stride
            if not action.at(output.times[own["first"] + step]):
                return
            rows[own["place"] + step] = action.row

    def _samples_around(self, task: int) -> tuple[float, float]:
        """Return the times of the last completed sample of a task and of the next sample."""
        own = self._queue.tasks[task]
        done, ahead = ((own["numbers"] - back) * own["periods"] + own["offsets"] for back in (1.0, 0.0))
        return float(np.max(done, initial=-np.inf)), float(np.min(ahead, initial=np.inf))

    def _act(self, task: int, number: int, time: float, row: Array) -> bool:
        """Set the state that an event returns, or record the reason of a failure; return True for success."""
        own, member = self._queue.tasks[task], int(self._members[task])
        try:
            after = _acted(self._parameters, number, member, time, row)
        except KeyboardInterrupt:
            self._interrupts.interrupt()
        except Exception as error:
            self._failed[task], self.causes[task] = _why_failed(self._events[number], error), error
        else:
            self._change(own, row[: after.size], after)
            row[: after.size] = after
            return True
        return False


def _acted(parameters: KernelParameters, number: int, member: int, time: float, row: Array) -> Array:
    """Return the variables of the state that an event of a member returns; omitted variables of parts stay."""
    variables, problem = members_of(parameters.variables, member), parameters.problem
    phase = variables.to_phase(np.array([time]), row[None])
    state, system = state_of(changed(phase, np.ravel), np.array(time)), problem.dynamics
    body = system.with_records(members_of(record, member) for record in system.records).at(state).acted_on
    event: Event = members_of(problem.events[number], member)
    after: AnyState = event.act(body, state)  # type: ignore[arg-type]
    if type(after) is not type(state) or after.shape:
        what = described(after) if type(after) is not type(state) else "one of several members"
        kind = "State of one body" if type(state) is State else "PairState"
        raise TypeError(f"an action must return a {kind}, got {what}.")
    if other := sorted(set(after.own) - set(state.own)):
        raise ValueError(f"an action must return variables of parts of the system, got some of {quoted(other[0])}.")
    after = state_of({**state.own, **after.phase}, after.time)
    largest = max(float(np.max(np.abs(values))) for values in after.phase.values())
    if largest > MAX_MOMENTUM:
        raise ValueError(f"an action must return momenta whose squares are finite, got {largest:.3g}.")
    new: Array = variables.with_state(row, after, np.array(time))
    return new


def _why_failed(event: Event, error: Exception) -> str:
    """Return the error message of an action that failed."""
    text = f"{type(event).__name__}.act failed with {type(error).__name__}: {message_of(error)}"
    return text.rstrip(": .") + "."
