"""Store of an ensemble: a Zarr group whose arrays grow by chunks of members.

A chunk of members is one shard of every array, and a group in `chunks/` with the failures, the events or the result of
a reduction. The description of this group is written last: a chunk that has it is complete.
"""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from poinsot.atomic_write import synced
from poinsot.printable import quoted, shortened
from poinsot.storage.memory import available_memory
from poinsot.storage.zarr_group import (
    BLOCK_BYTES,
    GROUP,
    Attributes,
    Described,
    Json,
    Numbers,
    Places,
    StoredArray,
    StoreError,
    Variables,
    check_descriptions,
    check_lengths,
    own_folder,
    plain,
    plain_attributes,
    read_group,
    side_by_side,
    write_group,
)

if TYPE_CHECKING:
    import xarray
    from xarray.backends import BackendArray
    from xarray.core.indexing import ExplicitIndexer

__all__ = [
    "MAX_CHUNK_BYTES",
    "EnsembleStore",
    "StoreHeader",
    "block_of",
    "coordinates_of",
    "dataset_of_arrays",
    "header_of",
    "plain_variables",
    "save_in_chunks",
]

CHUNKS = "chunks"

STORE_FORMAT = 1
"""Version of the folders and names in a store."""

MAX_CHUNK_BYTES = 128 * 1024**2
"""Largest size of the rows of a chunk: larger chunks are no faster."""

MAX_CHUNKS = 2**24
"""Largest number of chunks in one store, each of which is at least one file."""

WORDS, COORDINATES = "words", "coordinates"
"""Attribute of an array with the words for which its numbers stand, and attribute of a group with its coordinates."""

KINDS = {"f": "float64", "i": "int64", "u": "int64", "b": "int64"}


class EnsembleStore:
    """Store in the state in which it was opened.

    Parameters
    ----------
    folder : Path
        Folder of the store.

    Attributes
    ----------
    described : mapping
        Description of each array by name.
    attributes : mapping
        Attributes of the group.
    members, chunk : int
        Numbers of members, in all and in a chunk; 0 if no array lies along members.
    whole : array (chunks,) of bool
        True for each complete chunk.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.described, self.attributes = read_group(folder)
        store = self.attributes.get("store")
        if not isinstance(store, dict) or store.get("format") != STORE_FORMAT:
            raise StoreError("it is not of this format")
        members, chunk = store.get("members"), store.get("chunk")
        if not (type(members) is int and type(chunk) is int and 0 <= members < 2**48 and 0 <= chunk < 2**48):
            raise StoreError("it has no numbers of members")
        self.members: int = members
        self.chunk: int = chunk
        for name, about in self.described.items():
            if about.chunk and (about.chunk, about.shape[0]) != (self.chunk, self.members):
                raise StoreError(f"{name} has other chunks than the others")
        check_lengths(self.described)
        count = -(-self.members // self.chunk) if self.chunk else 0
        if count > MAX_CHUNKS:
            raise StoreError(f"it has {count} chunks, more than {MAX_CHUNKS}")
        self.whole = np.zeros(count, dtype=bool)
        self._look()

    def __str__(self) -> str:
        return f"{self.folder.name}, {self.whole.sum()} of {self.whole.size} chunks of {self.chunk} members"

    def _look(self) -> None:
        """Find the complete chunks."""
        with contextlib.suppress(FileNotFoundError):
            for entry in os.scandir(self.folder / CHUNKS):
                if entry.name.isdecimal() and int(entry.name) < self.whole.size:
                    self.whole[int(entry.name)] = os.path.exists(os.path.join(entry.path, GROUP))

    @functools.cached_property
    def arrays(self) -> dict[str, StoredArray]:
        """Arrays by name, which are read when they are indexed."""
        return {name: StoredArray(self.folder / name, about, self.whole) for name, about in self.described.items()}

    @property
    def sharded(self) -> dict[str, Described]:
        """Descriptions of the arrays in chunks by name."""
        return {name: about for name, about in self.described.items() if about.chunk}

    def members_of(self, number: int) -> slice:
        """Return the members of a chunk."""
        return slice(number * self.chunk, min((number + 1) * self.chunk, self.members))

    def _folder_of(self, number: int) -> Path:
        return self.folder / CHUNKS / f"{number:06}"

    @property
    def summary(self) -> dict[str, str | float]:
        """Recorded summary of all rows, with the drift of invariants in a store that `save` wrote; else empty."""
        return dict(self.attributes["store"].get("summary", {}))

    @property
    def finished(self) -> int:
        """Number of members in complete chunks."""
        members = (self.members_of(number) for number in np.flatnonzero(self.whole).tolist())
        return sum(part.stop - part.start for part in members)

    def check_files(self) -> None:
        """Raise a `StoreError` if files are missing, have other sizes than announced, or do not fit into memory.

        The size of a file with holes is larger than its space on the disk.
        """
        needed, left = (
            sum(about.total_bytes for about in self.described.values() if not about.chunk),
            available_memory(),
        )
        if needed > left:
            raise StoreError(f"it needs {needed} bytes of memory, of which {left} are left")
        for array in self.arrays.values():
            for number in np.flatnonzero(self.whole).tolist() if array.about.chunk else [0]:
                array.check_file(number)

    # ------------------------------------------------------------------ writing

    def write(self, number: int, rows: Mapping[str, Numbers], extra: Variables, attributes: Attributes) -> None:
        """Write a chunk: its rows of the arrays in shards, its extra arrays, and the attributes of its group."""
        side_by_side(functools.partial(self._write_rows, name, rows[name], number) for name in self.sharded)
        folder = own_folder(self._folder_of(number))
        described = {name: Described.of(*plain_variable(name, *given)) for name, given in extra.items()}
        for name, about in described.items():
            about.written(own_folder(folder / name), extra[name][1])
        write_group(folder, described, attributes)
        synced(folder.parent)
        self.whole[number] = True

    def _write_rows(self, name: str, values: Numbers, number: int) -> None:
        self.described[name].written(self.folder / name, values, number)
        synced(self.folder / name)

    def mend(self, header: StoreHeader) -> None:
        """Write a damaged or different header again, for example with another title; read the whole store.

        Damaged chunks count as missing, and unfinished files of earlier writers are removed.
        """
        for part in self.folder.rglob("*.part"):
            part.unlink(missing_ok=True)
        versions = {name: value for name, value in self.attributes.items() if name.startswith("version_")}
        header = header._replace(attributes={**header.attributes, **versions})
        if (self.described, self.attributes) != (header.described, header.attributes) or not self._is_sound():
            header.write(self.folder)
        for number in np.flatnonzero(self.whole).tolist():
            try:
                self._check_chunk(number)
            except StoreError:
                folder = self._folder_of(number)
                (folder if folder.is_symlink() else folder / GROUP).unlink(missing_ok=True)

    def _is_sound(self) -> bool:
        """Return True if everything that all chunks share is undamaged."""
        try:
            read_group(self.folder / CHUNKS)
            check_descriptions(self.folder, self.described)
            for array in self.arrays.values():
                if not array.about.chunk:
                    array.check_content()
        except StoreError:
            return False
        return not (self.folder / CHUNKS).is_symlink()

    def _check_chunk(self, number: int) -> None:
        """Raise a `StoreError` if a chunk is damaged."""
        arrays, _ = self.extra_of(number)
        check_descriptions(self._folder_of(number), {name: array.about for name, array in arrays.items()})
        for array in arrays.values():
            array.check_content()
        for name in self.sharded:
            self.arrays[name].check_content(number)

    def copy_to(self, folder: Path, attributes: Attributes) -> None:
        """Write a store with the same chunks and problem into a new folder, with some other attributes."""
        fixed = {name: array for name, array in self.arrays.items() if not array.about.chunk}
        values = {name: (array.about.dims, np.asarray(array), array.about.attributes) for name, array in fixed.items()}
        folder.mkdir()
        StoreHeader(values, self.described, {**self.attributes, **attributes}).write(folder)
        for number in np.flatnonzero(self.whole).tolist():
            self._check_chunk(number)
            for name, key in ((name, about.key(number)) for name, about in self.sharded.items() if not about.is_empty):
                shutil.copyfile(self.folder / name / key, folder / name / key)
            own = self._folder_of(number)
            shutil.copytree(own, folder / own.relative_to(self.folder), symlinks=True)  # whose targets are not read

    # ------------------------------------------------------------------ reading

    def extra_of(self, number: int) -> tuple[dict[str, StoredArray], dict[str, Any]]:
        """Return the extra arrays and the attributes of a complete chunk."""
        folder = self._folder_of(number)
        if folder.is_symlink() or folder.parent.is_symlink():
            raise StoreError(f"{shortened(folder.name)} is a link")
        described, attributes = read_group(folder)
        none = np.zeros(0, dtype=bool)
        arrays = {name: StoredArray(folder / name, about, none) for name, about in described.items()}
        for array in arrays.values():
            array.check_file()
        return arrays, attributes

    def extras(self) -> Iterator[tuple[dict[str, StoredArray], dict[str, Any]]]:
        """Yield the extra arrays and the attributes of each complete chunk."""
        return (self.extra_of(number) for number in np.flatnonzero(self.whole).tolist())

    def dataset(self) -> xarray.Dataset:
        """Return all arrays as a dataset that reads chunks when they are needed, of dask arrays if dask is there."""
        data = self.variables()
        if find_spec("dask") is None:
            return data
        return data.assign({name: data.variables[name].chunk({"member": self.chunk}) for name in self.sharded})

    def variables(self) -> xarray.Dataset:
        """Return all arrays as a dataset that reads rows when it is indexed."""
        attributes = {name: value for name, value in self.attributes.items() if name != "store"}
        return dataset_of_arrays(self.arrays, attributes)


class StoreHeader(NamedTuple):
    """Content of a store before its chunks.

    Attributes
    ----------
    fixed : mapping
        Variables that all chunks share.
    described : mapping
        Descriptions of these variables and of the arrays in chunks.
    attributes : mapping
        Attributes of the group.
    """

    fixed: Variables
    described: Mapping[str, Described]
    attributes: Attributes

    def write(self, folder: Path) -> None:
        """Write the header into a folder, which may contain another header and chunks."""
        write_group(own_folder(folder / CHUNKS), {}, {})
        fixed = {name: values for name, (_, values, _) in self.fixed.items()}
        side_by_side(
            functools.partial(self.described[name].written, own_folder(folder / name), fixed[name]) for name in fixed
        )
        write_group(folder, self.described, self.attributes)


def header_of(
    fixed: xarray.Dataset, rows: Mapping[str, Described], members: int, chunk: int, about: Attributes
) -> StoreHeader:
    """Return the content of a store before its chunks.

    Parameters
    ----------
    fixed : xarray.Dataset
        Variables that all chunks share, and the attributes.
    rows : mapping
        Descriptions of the variables along members by name.
    members, chunk : int
        Numbers of members, in all and in a chunk.
    about : mapping
        Further attributes of the store: its `problem`, or the `summary` of a motion.
    """
    whole = plain_variables(fixed)
    described = {name: Described.of(*given) for name, given in whole.items()}
    block = block_of(chunk, max((each.member_bytes for each in rows.values()), default=1))
    shards = {name: each.in_shards(chunk, block) for name, each in rows.items()}
    store = {"format": STORE_FORMAT, "members": members, "chunk": chunk, **about}
    return StoreHeader(
        whole, {**described, **shards}, plain_attributes({**fixed.attrs, **coordinates_of(fixed), "store": store})
    )


def save_in_chunks(data: xarray.Dataset, folder: Path, about: Mapping[str, Any]) -> None:
    """Write a dataset into a new folder as a store, variables along members and times in chunks of members.

    `about` contains the `summary` of all members, their `failures`, and the `run` of each chunk.
    """
    names = [str(name) for name, each in data.variables.items() if each.dims[:2] == ("member", "time")]
    members = data.sizes["member"] if names else 0
    bytes_of_all = sum(data.variables[name].size for name in names) * 8
    chunk = -(-members // max(-(-bytes_of_all // MAX_CHUNK_BYTES), 1)) if names else 0
    summary = {"summary": {name: plain(value) for name, value in sorted(about["summary"].items())}}
    folder.mkdir()
    rows = plain_variables(data[names].drop_vars(data.coords, errors="ignore"))
    described = {name: Described.of(*each) for name, each in rows.items()}
    header_of(data.drop_vars(names), described, members, chunk, summary).write(folder)
    store = EnsembleStore(folder)
    for number in range(store.whole.size):
        own = store.members_of(number)
        failures = {str(k): why for k, why in about["failures"].items() if own.start <= k < own.stop}
        numbers = {name: values[own] for name, (_, values, _) in rows.items()}
        store.write(number, numbers, {}, {"failures": failures, "run": about["run"]})


def block_of(chunk: int, member_bytes: int) -> int:
    """Return the number of members in a block, a divisor of the number in a chunk."""
    most = max(BLOCK_BYTES // max(member_bytes, 1), 1)
    return next((n for n in range(min(most, chunk), 1, -1) if chunk % n == 0), 1)


def plain_variables(data: xarray.Dataset) -> dict[str, tuple[tuple[str, ...], Numbers, dict[str, Json]]]:
    """Return the variables of a dataset as arrays of numbers; a coordinate in words has the words as an attribute."""
    found = {}
    for name, variable in data.variables.items():
        values, attributes = np.asarray(variable.values), dict(variable.attrs)
        if name in data.coords and values.dtype.kind in "OUT" and all(isinstance(word, str) for word in values.flat):
            attributes[WORDS] = [str(word) for word in values.flat]
            numbered = all(word.isdecimal() for word in attributes[WORDS])
            values = values.astype(np.int64) if numbered else np.arange(values.size).reshape(values.shape)
        found[str(name)] = plain_variable(str(name), tuple(map(str, variable.dims)), values, attributes)
    return found


def coordinates_of(data: xarray.Dataset) -> dict[str, str]:
    """Return the attribute in which xarray reads the names of the coordinates that are no dimensions."""
    names = [str(name) for name, each in data.coords.items() if each.dims != (name,)]
    return {COORDINATES: " ".join(names)} if names else {}


def dataset_of_arrays(arrays: Mapping[str, StoredArray], attributes: Attributes) -> xarray.Dataset:
    """Return arrays as a dataset that reads arrays in shards when it is indexed."""
    import xarray
    from xarray.core import indexing

    variables: dict[str, xarray.Variable] = {}
    for name, array in arrays.items():
        about = array.about
        own = {key: value for key, value in about.attributes.items() if key != WORDS}
        lazy = indexing.LazilyIndexedArray(_backend(array)) if about.chunk else None
        values = _in_words(name, array) if lazy is None else lazy
        variables[name] = xarray.Variable(about.dims, values, own)
    named = str(attributes.get(COORDINATES, "")).split()
    coordinates = [name for name in variables if (name,) == arrays[name].about.dims or name in named]
    others = {key: value for key, value in attributes.items() if key != COORDINATES}
    return xarray.Dataset(variables, attrs=others).set_coords(coordinates)


def _in_words(name: str, array: StoredArray) -> Numbers:
    """Return the numbers of an array, or the words for which they stand."""
    words = array.about.attributes.get(WORDS)
    if words is None:
        return np.asarray(array)
    if not isinstance(words, list) or len(words) != np.prod(array.shape) or not all(isinstance(w, str) for w in words):
        raise StoreError(f"{name} has other words than places")
    return np.array(words, dtype=str).reshape(array.shape)


def plain_variable(
    name: str, dims: tuple[str, ...], values: Numbers, attributes: Attributes
) -> tuple[tuple[str, ...], Numbers, dict[str, Json]]:
    """Return a variable as a store contains it."""
    kind = "float32" if values.dtype == np.float32 else KINDS.get(values.dtype.kind)
    if values.dtype == np.uint64 and values.max(initial=0).item() >= 2**63:
        raise ValueError(f"whole numbers of a store must be less than 2**63, got {name} up to {np.max(values)}.")
    if kind is None or not name.isidentifier():
        raise TypeError(f"variables of a store must be real numbers with names, got {quoted(name)} of {values.dtype}.")
    return dims, values.astype(kind, copy=False), dict(attributes)


def _backend(array: StoredArray) -> BackendArray:
    """Return an array that xarray reads when it is indexed."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    def read(key: tuple[Places, ...]) -> Numbers:
        first, *rest = key
        at = rest[0] if rest else slice(None)
        rows = array.members(first, at)
        axis = np.ndim(np.empty(len(array))[first]) + (not isinstance(at, int | np.integer))
        for index in rest[1:]:
            rows = rows[(slice(None),) * axis + (index,)]
            axis += not isinstance(index, int | np.integer)
        return rows

    class Lazy(BackendArray):
        shape, dtype = array.shape, array.dtype

        def __getitem__(self, key: ExplicitIndexer) -> Numbers:
            support = indexing.IndexingSupport.OUTER
            rows: Numbers = indexing.explicit_indexing_adapter(key, self.shape, support, read)
            return rows

        def __reduce__(self) -> tuple[Callable[[StoredArray], BackendArray], tuple[StoredArray]]:
            return _backend, (array,)

    return Lazy()
