"""Arguments of ensembles in chunks: number of members in a chunk, stored variables, reduction and store."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from poinsot.printable import quoted, shortened
from poinsot.storage.ensemble_store import MAX_CHUNK_BYTES
from poinsot.storage.memory import available_memory
from poinsot.storage.selection import refuse_other_names
from poinsot.storage.workers import check_client
from poinsot.storage.zarr_group import Described, Numbers

if TYPE_CHECKING:
    import xarray
    from distributed import Client

__all__ = ["Chunking", "Plan", "Selection", "StoredVariable", "plan_of", "with_thinned_times"]

MEMORY_SHARE = 16
"""Available memory divided by the largest size of the rows of a chunk."""

COPIES_IN_MEMORY = 4
"""Memory of a chunk while it is computed and written, divided by the size of its rows."""


class Chunking(TypedDict, total=False):
    """Arguments that divide an ensemble into chunks of members and send each chunk to a store or a reduction.

    Parameters
    ----------
    out : str or Path
        Name of a store, `.zarr`, to which each chunk is written when it is computed. The same call resumes an
        incomplete store.
    chunk : int
        Number of members in a chunk. Default: as many as memory allows.
    variables : list of str, or mapping
        Names of the stored variables, as in `motion.dataset`. Default: the state variables. A mapping has options for
        each name: `{"quaternion": {"dtype": "float32", "every": 10}}` stores every tenth time.
    reduce : callable
        Function of the dataset of a chunk that returns another dataset, which replaces the first one.
    client : dask.distributed.Client
        Client of the workers that compute the chunks, each on `threads`, by default one. All workers must see the
        folder of `out`.
    provenance : mapping
        Entries of the motion about the scenario that asks for it, for the store: `title`, `seed`, `scenario`.
    """

    out: str | Path | None
    chunk: int | None
    variables: Sequence[str] | Mapping[str, Mapping[str, Any]] | None
    reduce: Callable[[Any], Any] | None
    client: Any
    provenance: Mapping[str, Any]


@dataclass(frozen=True)
class StoredVariable:
    """Options of a stored variable: its type, and the number of times of which one is stored."""

    dtype: str = "float64"
    every: int = 1

    def __post_init__(self) -> None:
        if self.dtype not in ("float64", "float32"):
            raise ValueError(f"dtype must be 'float64' or 'float32', got {quoted(self.dtype)}.")
        if type(self.every) is bool or not isinstance(self.every, int | np.integer) or self.every < 1:
            raise ValueError(f"every must be a positive whole number, got {quoted(self.every)}.")
        object.__setattr__(self, "every", int(self.every))

    @property
    def times(self) -> str:
        """Name of the dimension of the times of the variable."""
        return f"time_{self.every}" if self.every > 1 else "time"

    def described(self, variable: Described) -> Described:
        """Return the description of the variable as it is stored."""
        kind = self.dtype if variable.kind.startswith("float") else variable.kind
        dims = tuple(self.times if dim == "time" else dim for dim in variable.dims)
        lengths = zip(variable.dims, variable.shape, strict=True)
        shape = tuple(-(-length // self.every) if dim == "time" else length for dim, length in lengths)
        return replace(variable, dims=dims, shape=shape, kind=kind)

    def rows(self, variable: Described, values: Numbers) -> Numbers:
        """Return the stored rows of the variable, from the rows at all times."""
        at = tuple(slice(None, None, self.every if dim == "time" else 1) for dim in variable.dims)
        return values[at].astype(self.described(variable).dtype.newbyteorder("="), copy=False)


Selection = Mapping[str, StoredVariable]
"""Options of the selected variables by name."""


@dataclass(frozen=True)
class Plan:
    """Checked arguments of chunks."""

    out: Path | None = None
    chunk: int | None = None
    variables: Selection = field(default_factory=dict)
    reduce: Callable[[xarray.Dataset], xarray.Dataset] | None = None
    client: Client | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def threads(self, given: int | None) -> int | None:
        """Return the number of threads of a chunk: a dask worker computes as many chunks at a time as it has."""
        return 1 if self.client is not None and given is None else given

    def selection(self, variables: Collection[str], stored: Collection[str]) -> Selection:
        """Return the variables that are computed: given ones, or all for a reduction, or `stored` by default."""
        refuse_other_names("variables", self.variables, variables)
        default = stored if self.reduce is None else variables
        return self.variables or dict.fromkeys(default, StoredVariable())

    def members_of_chunk(self, members: int, member_bytes: int) -> int:
        """Return the number of members in a chunk, for which memory is available, from the bytes of one member."""
        free, each = available_memory(), max(member_bytes, 1)
        if self.chunk is None:
            most = min(max(min(free // MEMORY_SHARE, MAX_CHUNK_BYTES) // each, 1), members)
            chunk = 1 << (most.bit_length() - 1) if most < members else most
        else:
            chunk = min(self.chunk, members)
        if COPIES_IN_MEMORY * chunk * each > free:
            remedy = "Leave chunk out." if self.chunk is not None and chunk > 1 else "Give fewer times."
            raise ValueError(
                f"chunk must fit into the memory that this process may use, {free / 1e9:.3g} GB, got {chunk} members, "
                f"which take {COPIES_IN_MEMORY * chunk * each / 1e9:.3g} GB. {remedy}"
            )
        return chunk


def plan_of(
    *,
    out: str | Path | None = None,
    chunk: int | None = None,
    variables: Sequence[str] | Mapping[str, Mapping[str, Any]] | None = None,
    reduce: Callable[[xarray.Dataset], xarray.Dataset] | None = None,
    client: Client | None = None,
    provenance: Mapping[str, Any] | None = None,
) -> Plan | None:
    """Return the checked arguments of chunks; None if there are none."""
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
    members = None if chunk is None else int(chunk)
    return Plan(None if out is None else Path(out), members, _selection(variables), reduce, client, provenance or {})


def _selection(variables: Sequence[str] | Mapping[str, Mapping[str, Any]] | None) -> dict[str, StoredVariable]:
    if variables is None:
        return {}
    if not variables:
        raise ValueError("variables must name at least one, got none. Leave them out for what the motion is made of.")
    given = variables if isinstance(variables, Mapping) else {name: {} for name in variables}
    for name, options in given.items():
        if not isinstance(options, Mapping) or not {*options} <= {"dtype", "every"}:
            raise TypeError(
                f"variables[{quoted(name)}] must be a mapping with dtype, every or neither, got {quoted(options)}. "
                "An empty one, {}, keeps all of it."
            )
    return {str(name): StoredVariable(**options) for name, options in given.items()}


def with_thinned_times(data: xarray.Dataset, selection: Selection) -> xarray.Dataset:
    """Return a dataset with the times of the variables that are not stored at every time."""
    thinned = {each.times: each.every for each in selection.values() if each.every > 1 and "time" in data.coords}
    return data.assign_coords({name: (name, data.time.values[::n], data.time.attrs) for name, n in thinned.items()})
