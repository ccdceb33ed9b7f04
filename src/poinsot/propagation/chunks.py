"""Ensembles in chunks of members, whose results go to a store or to a reduction as they end."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypedDict

import numpy as np

from poinsot.atomic_write import exists, new_folder
from poinsot.display.progress import Progress, bar
from poinsot.errors import PropagationInterrupted
from poinsot.printable import quoted, shortened
from poinsot.propagation.ensemble_store import (
    EnsembleStore,
    Frame,
    coordinates_of,
    dataset_of_arrays,
    frame_of,
    plain_variables,
)
from poinsot.propagation.fingerprint import fingerprint
from poinsot.propagation.lease import lease
from poinsot.propagation.memory import available_memory
from poinsot.propagation.reductions import concatenated, reduced, reduction
from poinsot.propagation.run_record import versions
from poinsot.propagation.selection import refuse_other_names
from poinsot.propagation.workers import check_client, on_workers
from poinsot.propagation.zarr_group import GROUP, StoreError, plain

if TYPE_CHECKING:
    import xarray
    from distributed import Client

__all__ = [
    "Chunking",
    "Done",
    "Ensemble",
    "Part",
    "Plan",
    "Task",
    "in_chunks",
    "plan_of",
    "saved_in_chunks",
    "selected",
]

LARGEST = 128 * 1024**2
"""Bytes of the rows of a chunk at most: larger ones are no faster."""

SHARE = 16
"""Parts of the available memory, of which the rows of a chunk take one."""

AT_WORK = 4
"""The bytes that a chunk takes while it is computed and written, over those of its rows."""


class Chunking(TypedDict, total=False):
    """How an ensemble is cut into chunks of members, and what is done with each.

    Parameters
    ----------
    out : str or Path
        The name of a store, `.zarr`: each chunk is written when it is done. The same call goes on with a store that
        is not complete.
    chunk : int
        Members of a chunk. Default: as many as memory allows.
    variables : list of str, or mapping
        What is stored, by the names in `motion.dataset`; default: what the motion is made of. A mapping has for each
        name what is special: `{"quaternion": {"dtype": "float32", "every": 10}}`, every tenth time.
    reduce : callable
        Takes the dataset of a chunk and returns another one, which is kept in its place.
    client : dask.distributed.Client
        Whose workers compute the chunks, each on `threads`, by default one; `out` is a folder that all of them see.
    provenance : mapping
        What the motion knows of the scenario that asks for it, for the store: `title`, `seed`, `scenario`.
    """

    out: str | Path | None
    chunk: int | None
    variables: Sequence[str] | Mapping[str, Mapping[str, Any]] | None
    reduce: Callable[[Any], Any] | None
    client: Any
    provenance: Mapping[str, Any]


@dataclass(frozen=True)
class Kept:
    """How a variable is kept."""

    dtype: str = "float64"
    every: int = 1

    def __post_init__(self) -> None:
        if self.dtype not in ("float64", "float32"):
            raise ValueError(f"dtype must be 'float64' or 'float32', got {quoted(self.dtype)}.")
        if type(self.every) is bool or not isinstance(self.every, int | np.integer) or self.every < 1:
            raise ValueError(f"every must be a positive whole number, got {quoted(self.every)}.")
        object.__setattr__(self, "every", int(self.every))


@dataclass(frozen=True)
class Plan:
    """Arguments of chunks, checked."""

    out: Path | None = None
    chunk: int | None = None
    variables: Mapping[str, Kept] = field(default_factory=dict)
    reduce: Callable[[xarray.Dataset], xarray.Dataset] | None = None
    client: Client | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def threads(self, given: int | None) -> int | None:
        """Return on how many threads a chunk is computed: workers do as many at a time as they have in dask."""
        return 1 if self.client is not None and given is None else given


class Part(NamedTuple):
    """What comes of some members.

    Attributes
    ----------
    data : xarray.Dataset
        Along `member`, then `time`.
    aside : mapping
        Name -> dimensions, numbers and attributes of what does not lie along members.
    about : mapping
        `failures`, by the number in the ensemble, and how they were computed, `run`.
    interrupted : bool
    """

    data: xarray.Dataset
    aside: Mapping[str, Any]
    about: Mapping[str, Any]
    interrupted: bool


class Ensemble(Protocol):
    """A computation of members that can be done chunk by chunk. What depends on all of them is decided before.

    Attributes
    ----------
    members : int
    member_bytes : int
        Of the rows of one member while it is computed.
    names : tuple of str
        The variables that its dataset can have.
    kept : tuple of str
        Those that are stored by default.
    problem : mapping
        What it is by name: values of JSON, or anything that has a fingerprint.
    last : float
        Its last time.
    """

    @property
    def members(self) -> int: ...  # noqa: D102 - they are above

    @property
    def member_bytes(self) -> int: ...  # noqa: D102

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def kept(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def problem(self) -> Mapping[str, Any]: ...  # noqa: D102

    @property
    def last(self) -> float: ...  # noqa: D102

    def fixed(self) -> xarray.Dataset:
        """Return the variables that are the same for all chunks, and the attributes."""

    def empty(self, names: Iterable[str]) -> xarray.Dataset:
        """Return the other variables of one member, of any numbers."""

    def computed(self, members: slice, names: Iterable[str], progress: Progress) -> Part:
        """Compute some members."""

    def opened(self, store: EnsembleStore) -> Any:
        """Return the result that is in a store."""


class Done(NamedTuple):
    """What is told of a chunk: its number, its members, what a reduction made of it without a store."""

    number: int
    members: int
    interrupted: bool = False
    reduced: Any = None


def plan_of(
    *,
    out: str | Path | None = None,
    chunk: int | None = None,
    variables: Sequence[str] | Mapping[str, Mapping[str, Any]] | None = None,
    reduce: Callable[[xarray.Dataset], xarray.Dataset] | None = None,
    client: Client | None = None,
    provenance: Mapping[str, Any] | None = None,
) -> Plan | None:
    """Return what the arguments of chunks ask for; None if there are none."""
    if out is None and chunk is None and variables is None and reduce is None and client is None:
        return None
    if out is None and reduce is None:
        raise ValueError(
            "chunk, variables and client must come with out= or reduce=, got neither. Name a store: out='run.zarr'."
        )
    if out is not None and Path(out).suffix != ".zarr":
        raise ValueError(f"out must be the name of a store that ends in .zarr, got {quoted(Path(out).name)}.")
    if out is not None and not Path(out).parent.is_dir():
        raise FileNotFoundError(f"No such folder: {shortened(Path(out).parent)}")
    if chunk is not None and chunk < 1:
        raise ValueError(f"chunk must be a positive whole number of members, got {chunk}.")
    if client is not None:
        check_client(client)
    of_members = None if chunk is None else int(chunk)
    return Plan(None if out is None else Path(out), of_members, _kept(variables), reduce, client, provenance or {})


def _kept(variables: Any) -> dict[str, Kept]:
    if variables is None:
        return {}
    if not variables:
        raise ValueError("variables must name at least one, got none. Leave them out for what the motion is made of.")
    given = variables if isinstance(variables, Mapping) else {name: {} for name in variables}
    for name, special in given.items():
        if not isinstance(special, Mapping) or not {*special} <= {"dtype", "every"}:
            raise TypeError(
                f"variables[{quoted(name)}] must be a mapping with dtype, every or neither, got {quoted(special)}. "
                "An empty one, {}, keeps all of it."
            )
    return {str(name): Kept(**special) for name, special in given.items()}


# ---------------------------------------------------------------------- one chunk


@dataclass(frozen=True)
class Task:
    """What is done with each chunk, in this process or in another one.

    Parameters
    ----------
    ensemble : Ensemble
    plan : Plan
    chunk : int
        Members of a chunk.
    """

    ensemble: Ensemble
    plan: Plan
    chunk: int

    def __call__(self, number: int, progress: Progress = False) -> Done:
        """Compute a chunk and write or reduce it."""
        return self.reduced(number, self.computed(number, progress))()

    def computed(self, number: int, progress: Progress) -> Part:
        """Compute the members of a chunk."""
        return self.ensemble.computed(self._members(number), self.names, progress)

    def reduced(self, number: int, part: Part) -> Callable[[], Done]:
        """Reduce what was computed of a chunk; return what is left to do, in any thread: to write it."""
        members = self._members(number)
        if part.interrupted:
            return partial(Done, number, 0, True)
        reduced = None if self.plan.reduce is None else reduction(self.plan.reduce, self._labelled(part, members))
        if self.plan.out is None:
            return partial(Done, number, members.stop - members.start, reduced=reduced)
        if reduced is not None:
            store = EnsembleStore(self.plan.out)
            other = np.flatnonzero(store.whole)[:1].tolist()
            before = [dataset_of_arrays(*store.aside(chunk)) for chunk in other]
            concatenated([*before, reduced])  # refuses what differs
        return partial(self._write, self.plan.out, number, part, reduced)

    def _write(self, out: Path, number: int, part: Part, reduced: xarray.Dataset | None) -> Done:
        rows = plain_variables(selected(part.data, self.kept)) if reduced is None else {}
        aside, words = (part.aside, {}) if reduced is None else (plain_variables(reduced), coordinates_of(reduced))
        members = self._members(number)
        with _writing(out):
            about = {"members": [members.start, members.stop], **part.about, **words}
            EnsembleStore(out).write(number, rows, aside, about)
        return Done(number, members.stop - members.start)

    def _members(self, number: int) -> slice:
        return slice(number * self.chunk, min((number + 1) * self.chunk, self.ensemble.members))

    @property
    def kept(self) -> Mapping[str, Kept]:
        """How each variable is stored."""
        return self.plan.variables or dict.fromkeys(self.ensemble.kept, Kept())

    @property
    def names(self) -> tuple[str, ...]:
        """The variables that are computed."""
        return tuple(self.kept) if self.plan.reduce is None or self.plan.variables else self.ensemble.names

    def _labelled(self, part: Part, members: slice) -> xarray.Dataset:
        """Return what a reduction is given: with the numbers of members, the times and the other labels."""
        data = selected(part.data, dict.fromkeys(self.names, Kept()) | dict(self.plan.variables))
        labels = _with_times(part.data, self.plan.variables).coords
        own = {name: each.variable for name, each in labels.items() if {*each.dims} <= {*data.dims}}
        return data.assign_coords({**own, "member": np.arange(members.start, members.stop)})


def selected(data: xarray.Dataset, kept: Mapping[str, Kept]) -> xarray.Dataset:
    """Return some variables of a dataset, each in its kind and at every so many of the times."""
    import xarray

    found = {}
    for name, how in kept.items():
        variable = data.variables[name]
        if how.every > 1 and "time" in variable.dims:
            variable = variable.isel(time=slice(None, None, how.every))
            dims = [times_every(how.every) if dim == "time" else dim for dim in variable.dims]
            variable = xarray.Variable(dims, variable.values, variable.attrs)
        found[name] = variable.astype(how.dtype, copy=False) if variable.dtype.kind == "f" else variable
    return xarray.Dataset(found, attrs=data.attrs)


def times_every(every: int) -> str:
    """Return the name of the dimension of every so many of the times."""
    return f"time_{every}" if every > 1 else "time"


# ---------------------------------------------------------------------- all of them


def in_chunks(ensemble: Ensemble, plan: Plan, shown: bool) -> Any:
    """Compute an ensemble chunk by chunk; return the result in the store, or what the reductions have made."""
    refuse_other_names("variables", plan.variables, ensemble.names)
    if plan.out is None:
        task = Task(ensemble, plan, chunk_of(ensemble, plan.chunk))
        found: dict[int, Any] = {}
        try:
            _run(
                task,
                range(-(-ensemble.members // task.chunk)),
                0,
                shown,
                lambda done: _take(found, done),
            )
        except KeyboardInterrupt:
            raise _interrupted(ensemble, sum(done.members for done in found.values()), None) from None
        return concatenated(found[number].reduced for number in sorted(found))
    try:
        return _in_store(ensemble, plan, _opened(ensemble, plan, plan.out), shown)
    except UnwritableError as error:
        raise OSError(f"{error}{_finished(plan.out)}") from error
    except StoreError as error:
        raise ValueError(
            f"out must be a whole store, got {shortened(plan.out)} with parts missing: {error}. Remove it, and the "
            "same call "
            "computes it anew."
        ) from None


def _in_store(ensemble: Ensemble, plan: Plan, store: EnsembleStore, shown: bool) -> Any:
    """Compute the chunks that a store has not, and return the result in it."""
    if store.whole.all() and not os.access(store.folder, os.W_OK):  # nothing to write, and nowhere
        store.check_files()
        return _result(ensemble, plan, store)
    frame = _frame(ensemble, plan, store.chunk, store.attributes["store"]["problem"])
    try:
        with contextlib.ExitStack() as until_then:
            with _writing(store.folder):
                held = until_then.enter_context(lease(store.folder))
                store = EnsembleStore(store.folder)
                store.mend(frame)
            store = EnsembleStore(store.folder)
            task, left = Task(ensemble, plan, store.chunk), np.flatnonzero(~store.whole).tolist()
            _run(task, left, store.finished, shown, lambda _: held.check())
    except KeyboardInterrupt:
        store = EnsembleStore(store.folder)
        raise _interrupted(ensemble, store.finished, _result(ensemble, plan, store)) from None
    return _result(ensemble, plan, EnsembleStore(store.folder))


class UnwritableError(OSError):
    """A store cannot be written: its folder, its disk, and not what a user's function opens."""


@contextlib.contextmanager
def _writing(out: Path) -> Iterator[None]:
    """Say of what goes wrong that it is the store."""
    try:
        yield
    except OSError as error:
        first = error.__cause__ if isinstance(error.__cause__, OSError) else error
        why = first.strerror or first
        raise UnwritableError(f"out must be a store that can be written, got {shortened(out)}: {why}.") from error


def _finished(out: Path) -> str:
    """Return a sentence on what is there; none if there is no store."""
    try:
        whole = EnsembleStore(out).whole
    except (StoreError, OSError):
        return ""
    return f" {whole.sum()} of {whole.size} chunks are whole; the same call goes on."


def _run(task: Task, numbers: Sequence[int], done: int, shown: bool, take: Callable[[Done], None]) -> None:
    """Do the chunks that are left, and hand on what is told of each."""
    with bar("members", task.ensemble.members, shown) as told:
        told(done)
        with contextlib.closing(_done(task, numbers, told if shown else False)) as each_done:
            for each in each_done:
                if each.interrupted:
                    raise KeyboardInterrupt
                take(each)


def _take(found: dict[int, Any], done: Done) -> None:
    """Keep what a reduction has made of a chunk, if it goes with that of another one."""
    concatenated([*(one.reduced for one in list(found.values())[:1]), done.reduced])
    found[done.number] = done


def _written_behind(task: Task, numbers: Sequence[int], progress: Progress) -> Generator[Done]:
    """Do chunks one after another in this process; each is written while the next one is computed."""
    with ThreadPoolExecutor(1) as writer:
        before: list[Future[Done]] = []
        for number in numbers:
            part = task.computed(number, progress)
            yield from (written.result() for written in before)
            before = [writer.submit(task.reduced(number, part))]
            del part  # no more than one chunk waits
        yield from (written.result() for written in before)


def _done(task: Task, numbers: Sequence[int], progress: Progress) -> Generator[Done]:
    """Do chunks in this process, or on workers."""
    client, out = task.plan.client, task.plan.out
    if client is None or not numbers:
        yield from _written_behind(task, numbers, progress)
        return
    kept = task.plan.variables or dict.fromkeys(task.names, Kept())
    plan = replace(task.plan, client=None, variables=kept, out=None if out is None else out.absolute())
    ensemble: Any = task.ensemble  # without what it has computed and keeps
    for each in on_workers(client, replace(task, plan=plan, ensemble=replace(ensemble)), numbers):
        if callable(progress):
            progress(each.members)
        yield each


def _interrupted(ensemble: Ensemble, members: int, result: Any) -> PropagationInterrupted:
    goes_on = "" if result is None else " The same call continues the run."
    message = f"propagation was interrupted: {members} of {ensemble.members} members are done.{goes_on}"
    return PropagationInterrupted(message, ensemble.last, result)


def _result(ensemble: Ensemble, plan: Plan, store: EnsembleStore) -> Any:
    return reduced(store) if plan.reduce is not None else ensemble.opened(store)


# ---------------------------------------------------------------------- size and store


def chunk_of(ensemble: Ensemble, given: int | None) -> int:
    """Return how many members a chunk has, for which there is memory."""
    free, each = available_memory(), max(ensemble.member_bytes, 1)
    if given is None:
        most = min(max(min(free // SHARE, LARGEST) // each, 1), ensemble.members)
        chunk = 1 << (most.bit_length() - 1) if most < ensemble.members else most
    else:
        chunk = min(given, ensemble.members)
    if AT_WORK * chunk * each > free:
        hint = "Leave chunk out." if given is not None and chunk > 1 else "Give fewer times."
        raise ValueError(
            f"chunk must fit into the memory that this process may use, {free / 1e9:.3g} GB, got {chunk} members, "
            f"which take {AT_WORK * chunk * each / 1e9:.3g} GB. {hint}"
        )
    return chunk


def saved_in_chunks(data: xarray.Dataset, folder: Path, about: Mapping[str, Any]) -> None:
    """Write a dataset into a new folder as a store: what has members and times in chunks of members."""
    names = [str(name) for name, each in data.variables.items() if each.dims[:2] == ("member", "time")]
    members = data.sizes["member"] if names else 0
    bytes_of_all = sum(data.variables[name].size for name in names) * 8
    chunk = -(-members // max(-(-bytes_of_all // LARGEST), 1)) if names else 0
    said = {"summary": {name: plain(value) for name, value in sorted(about["summary"].items())}}
    folder.mkdir()
    fixed, grown = data.drop_vars(names), data[names].drop_vars(data.coords, errors="ignore")
    frame_of(fixed, grown.isel(member=slice(0, 1), missing_dims="ignore"), members, chunk, said).write(folder)
    store = EnsembleStore(folder)
    for number in range(store.whole.size):
        own = store.members_of(number)
        failures = {str(k): why for k, why in about["failures"].items() if own.start <= k < own.stop}
        store.write(number, plain_variables(grown.isel(member=own)), {}, {"failures": failures, "run": about["run"]})


def _opened(ensemble: Ensemble, plan: Plan, out: Path) -> EnsembleStore:
    """Return the store of a problem, which is made if it is not there; refuse that of another one."""
    problem = _problem(ensemble, plan)
    with _writing(out):
        there = exists(out)
    if not there and out.is_symlink():
        raise ValueError(
            f"out must be a new name or the store of this problem, got {shortened(out)}, a link to nothing."
        )
    if not there:
        _make(ensemble, plan, out, problem)
    try:
        store = EnsembleStore(out)
    except StoreError as error:
        raise ValueError(
            f"out must be a new name or the store of this problem, got {shortened(out)}: {error}."
        ) from None
    said = store.attributes["store"].get("problem") or {}
    other = [_told(name, said, problem) for name in {**problem, **said} if problem.get(name) != said.get(name)]
    if not other and plan.chunk not in (None, store.chunk) and store.chunk < ensemble.members:
        other = [f"chunks, of {store.chunk} members"]
    if other:
        raise ValueError(
            f"out must be a new name or the store of this problem, got {shortened(out)}, which differs in its "
            f"{' and '.join(other)}. Give another name."
        )
    return store


def _make(ensemble: Ensemble, plan: Plan, out: Path, problem: Mapping[str, Any]) -> None:
    """Make the store of a problem without chunks, unless another run does so at this moment."""
    frame = _frame(ensemble, plan, chunk_of(ensemble, plan.chunk), problem)
    try:
        with _writing(out), new_folder(out, False, GROUP) as part:
            part.mkdir()
            frame.write(part)
    except UnwritableError:
        if not out.exists():
            raise


def _frame(ensemble: Ensemble, plan: Plan, chunk: int, problem: Mapping[str, Any]) -> Frame:
    """Return what the store of a problem has before its chunks."""
    kept = Task(ensemble, plan, chunk).kept if plan.reduce is None else {}
    fixed, empty = _with_times(ensemble.fixed(), kept), selected(ensemble.empty(tuple(kept)), kept)
    return frame_of(fixed, empty, ensemble.members, chunk, {"problem": problem})


def _told(name: str, said: Mapping[str, Any], problem: Mapping[str, Any]) -> str:
    """Return what differs between two problems."""
    theirs, ours = said.get(name), problem.get(name)
    if name != "versions" or not isinstance(theirs, dict) or not isinstance(ours, dict):
        return name
    packages = [package for package in ours if theirs.get(package) != ours[package]]
    return "versions, " + ", ".join(f"{package} {theirs.get(package)} and now {ours[package]}" for package in packages)


def _problem(ensemble: Ensemble, plan: Plan) -> dict[str, Any]:
    """Return what a store says of its problem."""
    kept = Task(ensemble, plan, 1).kept if plan.reduce is None or plan.variables else {}
    own = {name: fingerprint(value) for name, value in ensemble.problem.items()}
    of = versions()
    return {
        **own,
        "variables": {name: [how.dtype, how.every] for name, how in kept.items()},
        "reduce": "" if plan.reduce is None else fingerprint(plan.reduce),
        "versions": {name: of[name] for name in ("poinsot", "llvmlite")},
    }


def _with_times(data: xarray.Dataset, kept: Mapping[str, Kept]) -> xarray.Dataset:
    """Return a dataset with the times at which variables are kept."""
    times = {times_every(how.every): how.every for how in kept.values() if how.every > 1 and "time" in data.coords}
    return data.assign_coords({name: (name, data.time.values[::n], data.time.attrs) for name, n in times.items()})
