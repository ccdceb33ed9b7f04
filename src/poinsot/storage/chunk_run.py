"""Run of an ensemble in chunks, in this process or on workers, for a store or a reduction."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from poinsot.display.progress import Progress, bar
from poinsot.errors import PropagationInterrupted
from poinsot.printable import shortened
from poinsot.storage.chunk_plan import Plan, Selection, with_thinned_times
from poinsot.storage.ensemble import ChunkResult, Compute, Ensemble, Result
from poinsot.storage.ensemble_store import EnsembleStore, coordinates_of, dataset_of_arrays, plain_variables
from poinsot.storage.lease import lease
from poinsot.storage.reductions import concatenated, reduced, reduction
from poinsot.storage.store_opening import StoreDescription, UnwritableError, is_there, writing
from poinsot.storage.workers import on_workers
from poinsot.storage.zarr_group import Attributes, Described, Numbers, StoreError, Variables

if TYPE_CHECKING:
    from concurrent.futures import Future

    import xarray
    from distributed import Client

__all__ = ["run_in_chunks"]


class Finished(NamedTuple):
    """Report of a chunk: its number, the number of finished members, and its reduced dataset if there is no store."""

    number: int
    members: int
    interrupted: bool = False
    reduced: xarray.Dataset | None = None


@dataclass(frozen=True)
class ChunkTask:
    """Work on each chunk: compute its members, reduce them, and write them to a store.

    Parameters
    ----------
    compute : Compute
        Computes some members.
    members, chunk : int
        Numbers of members, in all and in a chunk.
    variables : mapping
        Descriptions of the variables that are computed, by name.
    selection : mapping
        Options of these variables.
    reduce : callable or None
        Function of the dataset of a chunk.
    labels : xarray.Dataset or None
        Coordinates and attributes of the datasets for a reduction.
    out : Path or None
        Store.
    """

    compute: Compute
    members: int
    chunk: int
    variables: Mapping[str, Described]
    selection: Selection
    reduce: Callable[[xarray.Dataset], xarray.Dataset] | None
    labels: xarray.Dataset | None
    out: Path | None

    @classmethod
    def of(cls, ensemble: Ensemble[Result], plan: Plan, selection: Selection, chunk: int) -> ChunkTask:
        """Return the task of an ensemble."""
        variables = {name: ensemble.variables[name] for name in selection}
        labels = None
        if plan.reduce is not None:
            coordinates = ensemble.fixed.coords.to_dataset().assign_attrs(ensemble.fixed.attrs)
            labels = with_thinned_times(coordinates, selection)
        return cls(ensemble.compute, ensemble.members, chunk, variables, selection, plan.reduce, labels, plan.out)

    def __call__(self, number: int, progress: Progress = False) -> Finished:
        """Compute a chunk and write or reduce it."""
        return self.reduced(number, self.computed(number, progress))()

    def computed(self, number: int, progress: Progress) -> ChunkResult:
        """Compute the members of a chunk."""
        return self.compute(self._members(number), tuple(self.selection), progress)

    def reduced(self, number: int, result: ChunkResult) -> Callable[[], Finished]:
        """Reduce the result of a chunk and return the remaining work, which any thread can do: to write it."""
        members = self._members(number)
        if result.interrupted:
            return partial(Finished, number, 0, True)
        rows = {name: each.rows(self.variables[name], result.rows[name]) for name, each in self.selection.items()}
        reduced = None
        if self.reduce is not None and self.labels is not None:
            failures = result.about["failures"]
            attributes = {**result.about["run"], **({"failures": json.dumps(failures)} if failures else {})}
            labels = self.labels.assign_attrs(attributes)
            reduced = reduction(self.reduce, self._labelled(labels, rows, members))
        if self.out is None:
            return partial(Finished, number, members.stop - members.start, reduced=reduced)
        about = {"members": [members.start, members.stop], **result.about}
        if reduced is not None:
            store = EnsembleStore(self.out)
            other = np.flatnonzero(store.whole)[:1].tolist()
            before = [dataset_of_arrays(*store.extra_of(chunk)) for chunk in other]
            concatenated([*before, reduced])  # raises an error for other variables
            return partial(self._write, self.out, number, {}, plain_variables(reduced), about | coordinates_of(reduced))
        return partial(self._write, self.out, number, rows, result.extra, about)

    def _write(
        self, out: Path, number: int, rows: Mapping[str, Numbers], extra: Variables, about: Attributes
    ) -> Finished:
        members = self._members(number)
        with writing(out):
            EnsembleStore(out).write(number, rows, extra, about)
        return Finished(number, members.stop - members.start)

    def _members(self, number: int) -> slice:
        return slice(number * self.chunk, min((number + 1) * self.chunk, self.members))

    def _labelled(self, labels: xarray.Dataset, rows: Mapping[str, Numbers], members: slice) -> xarray.Dataset:
        """Return the dataset for a reduction, with the numbers of members, the times and the other labels."""
        import xarray

        stored = {name: options.described(self.variables[name]) for name, options in self.selection.items()}
        variables = {name: (about.dims, rows[name], about.attributes) for name, about in stored.items()}
        data = xarray.Dataset(variables, attrs=labels.attrs)
        own = {name: each.variable for name, each in labels.coords.items() if {*each.dims} <= {*data.dims}}
        return data.assign_coords({**own, "member": np.arange(members.start, members.stop)})


def run_in_chunks(ensemble: Ensemble[Result], plan: Plan, shown: bool) -> Result | xarray.Dataset:
    """Compute an ensemble chunk by chunk; return the result in the store, or the dataset of all reductions."""
    selection = plan.selection(ensemble.variables, ensemble.stored)
    if plan.out is None:
        chunk = plan.members_of_chunk(ensemble.members, ensemble.member_bytes)
        return _reduced_in_memory(ensemble, plan, ChunkTask.of(ensemble, plan, selection, chunk), shown)
    try:
        return _in_store(ensemble, plan, plan.out, selection, shown)
    except UnwritableError as error:
        raise OSError(f"{error}{_finished(plan.out)}") from error
    except StoreError as error:
        raise ValueError(
            f"out must be a whole store, got {shortened(plan.out)} with parts missing: {error}. Remove it, and the "
            "same call computes it anew."
        ) from None


def _reduced_in_memory(ensemble: Ensemble[Result], plan: Plan, task: ChunkTask, shown: bool) -> xarray.Dataset:
    """Return the reductions of all chunks as one dataset."""
    found: dict[int, Finished] = {}

    def take(each: Finished) -> None:
        _joined([*[*found.values()][:1], each])  # raises an error for other variables
        found[each.number] = each

    try:
        _run(task, plan.client, range(-(-task.members // task.chunk)), 0, shown, take)
    except KeyboardInterrupt:
        raise _interrupted(ensemble, sum(each.members for each in found.values()), None) from None
    return _joined(found[number] for number in sorted(found))


def _joined(reports: Iterable[Finished]) -> xarray.Dataset:
    return concatenated(each.reduced for each in reports if each.reduced is not None)


def _in_store(
    ensemble: Ensemble[Result], plan: Plan, out: Path, selection: Selection, shown: bool
) -> Result | xarray.Dataset:
    """Compute the chunks that a store does not contain yet, and return the result in the store."""
    open_result: Callable[[EnsembleStore], Result | xarray.Dataset] = ensemble.open if plan.reduce is None else reduced
    description = StoreDescription.of(ensemble, plan, selection)
    if not is_there(out):
        description.make(out, plan.members_of_chunk(ensemble.members, ensemble.member_bytes))
    store = description.open(out, plan.chunk)
    if store.whole.all() and not os.access(out, os.W_OK):  # nothing to write, and nowhere
        store.check_files()
        return open_result(store)
    try:
        with contextlib.ExitStack() as until_then:
            with writing(out):
                right = until_then.enter_context(lease(out))
                store = EnsembleStore(out)
                store.mend(description.header(store.chunk))
            store = EnsembleStore(out)
            task, left = ChunkTask.of(ensemble, plan, selection, store.chunk), np.flatnonzero(~store.whole).tolist()
            _run(task, plan.client, left, store.finished, shown, lambda _: right.check())
    except KeyboardInterrupt:
        store = EnsembleStore(out)
        raise _interrupted(ensemble, store.finished, open_result(store)) from None
    return open_result(EnsembleStore(out))


def _finished(out: Path) -> str:
    """Return a sentence about the finished chunks of a store; an empty text if there is no store."""
    try:
        whole = EnsembleStore(out).whole
    except (StoreError, OSError):
        return ""
    return f" {whole.sum()} of {whole.size} chunks are whole; the same call goes on."


def _interrupted(
    ensemble: Ensemble[Result], members: int, result: Result | xarray.Dataset | None
) -> PropagationInterrupted:
    remedy = "" if result is None else " The same call continues the run."
    message = f"propagation was interrupted: {members} of {ensemble.members} members are done.{remedy}"
    return PropagationInterrupted(message, ensemble.last, result)


# ---------------------------------------------------------------------- chunks, one after another or on workers


def _run(
    task: ChunkTask,
    client: Client | None,
    numbers: Sequence[int],
    finished: int,
    shown: bool,
    take: Callable[[Finished], None],
) -> None:
    """Run chunks and pass on the report of each; raise a KeyboardInterrupt where Ctrl-C ended one."""
    with bar("members", task.members, shown) as advance:
        advance(finished)
        progress = advance if shown else False
        here = client is None or not numbers
        reports = _written_behind(task, numbers, progress) if here else _on_workers(task, client, numbers, progress)
        with contextlib.closing(reports):
            for each in reports:
                if each.interrupted:
                    raise KeyboardInterrupt
                take(each)


def _written_behind(task: ChunkTask, numbers: Sequence[int], progress: Progress) -> Generator[Finished]:
    """Run chunks one after another in this process; each is written while the next one is computed."""
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as writer:
        before: list[Future[Finished]] = []
        for number in numbers:
            result = task.computed(number, progress)
            yield from (written.result() for written in before)
            before = [writer.submit(task.reduced(number, result))]
            del result  # no more than one chunk waits
        yield from (written.result() for written in before)


def _on_workers(
    task: ChunkTask, client: Client | None, numbers: Sequence[int], progress: Progress
) -> Generator[Finished]:
    """Run chunks on workers, which may have another working folder."""
    for each in on_workers(client, replace(task, out=task.out and task.out.absolute()), numbers):
        if callable(progress):
            progress(each.members)
        yield each
