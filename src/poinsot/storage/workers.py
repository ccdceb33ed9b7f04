"""Chunks of an ensemble on the workers of a dask cluster."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Iterator
from importlib import import_module
from typing import Any, Protocol, TypeVar

from poinsot.printable import kind_of, message_of, quoted
from poinsot.storage.run_record import versions

__all__ = ["check_client", "on_workers"]

SAME_VERSION_PACKAGES = ("poinsot", "llvmlite")
"""Packages whose versions on workers must equal the versions of the client: others may compute other bits."""

LARGEST_TASK = "1 TB"
"""Size of a task below which dask does not warn. A task in its graph outlives the workers that have it."""

RUNNING = "running"
"""Status of a client that is connected to a scheduler."""

Done = TypeVar("Done", covariant=True)


class Task(Protocol[Done]):
    """Function that computes the chunk with a number and returns its report."""

    def __call__(self, number: int) -> Done: ...


def check_client(client: Any) -> None:
    """Raise an error unless an object is a client of dask with a scheduler and workers."""
    if not callable(getattr(client, "submit", None)) or not callable(getattr(client, "nthreads", None)):
        raise TypeError(f"client must be a dask.distributed Client, got {kind_of(client)}.")
    if client.status != RUNNING:
        raise ValueError(f"client must be connected to its scheduler, got a client that is {client.status}.")
    if not client.nthreads():
        raise ValueError("client must have workers, got none. Wait for them: client.wait_for_workers(1).")


def on_workers(client: Any, task: Task[Done], numbers: Iterable[int]) -> Iterator[Done]:
    """Compute chunks on workers, and yield the report of each when it ends; repeat the chunks of a worker that dies.

    After an error or Ctrl-C, no further chunk begins; chunks under way end on their workers.
    """
    distributed: Any = import_module("distributed")
    dask: Any = import_module("dask")
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": LARGEST_TASK}):
        given = client.submit(_unpacked, _packed(task), _own_versions(), pure=False)
    futures = client.map(_chunk, list(numbers), task=given, pure=False)
    with client.as_current():  # another client may be open, whose event loop is another one
        completed = distributed.as_completed(futures, with_results=True)
    try:
        for _, done in completed:
            if isinstance(done, BaseException):  # a future that dask has given up
                raise RuntimeError(
                    f"client must be connected until the last chunk ends, got a client that is {client.status}. "
                    "The same call continues the run."
                )
            yield done
    except Exception as error:
        raise _explained(error) from error
    finally:
        if client.status == RUNNING:
            client.cancel([given, *futures], force=True)


def _packed(task: Task[Any]) -> bytes:
    """Return a task as bytes, with the classes and functions of a script."""
    cloudpickle: Any = import_module("cloudpickle")
    try:
        packed: bytes = cloudpickle.dumps(task)
    except Exception as error:
        raise TypeError(
            f"system, events and reduce must travel to the workers, got an object that does not: "
            f"{message_of(error)}. Let them hold numbers, and no open files, locks or connections."
        ) from error
    return packed


def _unpacked(packed: bytes, known: dict[str, str]) -> Task[Any]:
    """Return the task, on a worker."""
    own = _own_versions()
    if own != known:
        apart = " and ".join(
            f"{name} {own[name]}, not {known[name]}" for name in SAME_VERSION_PACKAGES if own[name] != known[name]
        )
        raise RuntimeError(f"workers must have the versions of the client, got {apart}.")
    try:
        task: Task[Any] = pickle.loads(packed)  # noqa: S301, of the client, to which the worker belongs
    except ModuleNotFoundError as error:
        raise RuntimeError(
            f"workers must have the modules of the system, got none with the name {quoted(error.name)}. Install it "
            "there, or define the class in the script."
        ) from error
    return task


def _chunk(number: int, task: Task[Done]) -> Done:
    return task(number)


def _own_versions() -> dict[str, str]:
    return {name: version for name, version in versions().items() if name in SAME_VERSION_PACKAGES}


def _explained(error: Exception) -> Exception:
    """Return the error with a remedy if workers died; any other error as it is."""
    if type(error).__name__ == "KilledWorker":
        died = getattr(error, "allowed_failures", 0) + 1
        return RuntimeError(
            f"workers must live as long as a chunk takes, got {died} that died on the same one. "
            "Give smaller chunks, or workers more memory or time; the same call goes on."
        )
    return error
