"""Ensemble of members that is computed in chunks: descriptions of variables, and the function of some members.

Motions and results of analyses are ensembles of the same kind. Nothing here contains a system or a state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol, TypeVar

from poinsot.display.progress import Progress
from poinsot.storage.run_record import RunRecord
from poinsot.storage.zarr_group import Described, Numbers, Variables

if TYPE_CHECKING:
    import xarray

    from poinsot.storage.ensemble_store import EnsembleStore

__all__ = ["ChunkResult", "Ensemble"]

Result = TypeVar("Result")


class ChunkResult(NamedTuple):
    """Results of the members of one chunk.

    Attributes
    ----------
    rows : mapping
        Numbers of each variable by name, members first.
    extra : mapping
        Dimensions, numbers and attributes of each extra array, which does not lie along members, by name.
    about : mapping
        `failures` by the number of the member in the ensemble, and `run`, how the chunk was computed.
    interrupted : bool
        True if Ctrl-C ended the computation before its end.
    """

    rows: Mapping[str, Numbers]
    extra: Variables
    about: Mapping[str, Any]
    interrupted: bool

    @classmethod
    def of(
        cls,
        failures: Mapping[int, str],
        run: RunRecord,
        first: int,
        rows: Mapping[str, Numbers],
        extra: Variables,
        interrupted: bool,
    ) -> ChunkResult:
        """Return the result of members whose first one has a number in the ensemble."""
        own = {str(first + member): why for member, why in failures.items()}
        return cls(rows, extra, {"failures": own, "run": run.of_chunk}, interrupted)


class Compute(Protocol):
    """Function that computes some variables of some members."""

    def __call__(self, members: slice, names: tuple[str, ...], progress: Progress) -> ChunkResult: ...


@dataclass(frozen=True)
class Ensemble(Generic[Result]):
    """Computation of members that can be done chunk by chunk. Decisions that depend on all members are made before it.

    Parameters
    ----------
    members : int
        Number of members.
    last : float
        Last time.
    problem : mapping
        Digest of each argument by its name: a store resumes the same problem only.
    variables : mapping
        Description of each variable along members that can be computed, by name.
    stored : tuple of str
        Variables that are stored by default.
    member_bytes : int
        Bytes of the rows of one member during the computation.
    fixed : xarray.Dataset
        Variables that are the same for all chunks, and the attributes.
    compute : Compute
        Computes some members, here or in another process.
    open : callable
        Returns the result that is in a store.
    """

    members: int
    last: float
    problem: Mapping[str, str]
    variables: Mapping[str, Described]
    stored: tuple[str, ...]
    member_bytes: int
    fixed: xarray.Dataset
    compute: Compute
    open: Callable[[EnsembleStore], Result]
