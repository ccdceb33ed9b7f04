"""Store of an ensemble before its chunks: made for a problem, or opened again for the same problem."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from poinsot.atomic_write import exists, new_folder
from poinsot.printable import shortened
from poinsot.storage.chunk_plan import Plan, Selection, with_thinned_times
from poinsot.storage.ensemble import Ensemble, Result
from poinsot.storage.ensemble_store import EnsembleStore, StoreHeader, header_of
from poinsot.storage.fingerprint import fingerprint
from poinsot.storage.run_record import versions
from poinsot.storage.zarr_group import GROUP, Described, Json, StoreError

if TYPE_CHECKING:
    import xarray

__all__ = ["StoreDescription", "UnwritableError", "writing"]

VERSIONS = ("poinsot", "llvmlite")
"""Packages whose versions a store compares."""


@dataclass(frozen=True)
class StoreDescription:
    """Description of the store of an ensemble, without its chunks.

    Parameters
    ----------
    fixed : xarray.Dataset
        Variables that all chunks share, and the attributes.
    rows : mapping
        Descriptions of the stored variables along members by name.
    members : int
        Number of members.
    problem : mapping
        Entries that define the problem, as JSON values.
    """

    fixed: xarray.Dataset
    rows: Mapping[str, Described]
    members: int
    problem: Mapping[str, Json]

    @classmethod
    def of(cls, ensemble: Ensemble[Result], plan: Plan, selection: Selection) -> StoreDescription:
        """Return the description of the store of an ensemble, which stores selected variables or a reduction."""
        stored = selection if plan.reduce is None else {}
        chosen = selection if plan.reduce is None or plan.variables else {}
        own = versions()
        problem: dict[str, Json] = {
            **ensemble.problem,
            "variables": {name: [options.dtype, options.every] for name, options in chosen.items()},
            "reduce": "" if plan.reduce is None else fingerprint(plan.reduce),
            "versions": {name: own[name] for name in VERSIONS},
        }
        rows = {name: options.described(ensemble.variables[name]) for name, options in stored.items()}
        return cls(with_thinned_times(ensemble.fixed, stored), rows, ensemble.members, problem)

    def header(self, chunk: int) -> StoreHeader:
        """Return the content of the store before its chunks of so many members."""
        return header_of(self.fixed, self.rows, self.members, chunk, {"problem": self.problem})

    def make(self, out: Path, chunk: int) -> None:
        """Make the store without chunks, unless another run makes it at this moment."""
        try:
            with writing(out), new_folder(out, False, GROUP) as part:
                part.mkdir()
                self.header(chunk).write(part)
        except UnwritableError:
            if not out.exists():
                raise

    def open(self, out: Path, chunk: int | None) -> EnsembleStore:
        """Return the store of the problem, or raise a ValueError for another file or the store of another problem."""
        try:
            store = EnsembleStore(out)
        except StoreError as error:
            raise ValueError(
                f"out must be a new name or the store of this problem, got {shortened(out)}: {error}."
            ) from None
        stored = store.attributes["store"].get("problem") or {}
        names = {**self.problem, **stored}
        other = [
            _difference(name, stored.get(name), self.problem.get(name))
            for name in names
            if self.problem.get(name) != stored.get(name)
        ]
        if not other and chunk not in (None, store.chunk) and store.chunk < self.members:
            other = [f"chunks, of {store.chunk} members"]
        if other:
            raise ValueError(
                f"out must be a new name or the store of this problem, got {shortened(out)}, which differs in its "
                f"{' and '.join(other)}. Give another name."
            )
        return store


def is_there(out: Path) -> bool:
    """Return True if a store or another file has a name; raise a ValueError for a broken link."""
    with writing(out):
        there = exists(out)
    if not there and out.is_symlink():
        raise ValueError(
            f"out must be a new name or the store of this problem, got {shortened(out)}, a link to nothing."
        )
    return there


def _difference(name: str, stored: Json, given: Json) -> str:
    """Return the name of an entry in which two problems differ, for the versions with the packages."""
    if name != "versions" or not isinstance(stored, dict) or not isinstance(given, dict):
        return name
    packages = [package for package in given if stored.get(package) != given[package]]
    return "versions, " + ", ".join(f"{package} {stored.get(package)} and now {given[package]}" for package in packages)


class UnwritableError(OSError):
    """The folder or the disk of a store cannot be written, unlike a file that a user's function opens."""


@contextlib.contextmanager
def writing(out: Path) -> Iterator[None]:
    """Raise an OSError of the block as an error about the store."""
    try:
        yield
    except OSError as error:
        first = error.__cause__ if isinstance(error.__cause__, OSError) else error
        why = first.strerror or first
        raise UnwritableError(f"out must be a store that can be written, got {shortened(out)}: {why}.") from error
