"""Groups of arrays as Zarr stores of format 3, written and read without a library.

Numbers are little-endian and not compressed, and each block of numbers ends with its CRC-32C. An array is one block, or
it is divided along its first axis into shards, one for each chunk of members. A shard consists of blocks with equally
many members. The group describes all its arrays (`consolidated_metadata`). The reader accepts exactly the descriptions
that this module writes, so that no store can name a codec to execute.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import DTypeLike, NDArray

from poinsot.atomic_write import synced
from poinsot.operating_system import REGULAR_FILE
from poinsot.printable import quoted, shortened
from poinsot.storage.checksum import crc32c

__all__ = [
    "GROUP",
    "Attributes",
    "Described",
    "JoinedArrays",
    "Json",
    "Numbers",
    "Places",
    "StoreError",
    "StoredArray",
    "Variables",
    "check_descriptions",
    "check_lengths",
    "own_folder",
    "plain",
    "plain_attributes",
    "read_group",
    "side_by_side",
    "write_group",
]

GROUP = "zarr.json"

KINDS = {"float64": "<f8", "float32": "<f4", "int64": "<i8"}

MAX_JSON_BYTES = 8 * 1024 * 1024
"""Bytes of the description of a group: its scenario, and the reason of each member that failed."""

BLOCK_BYTES = 1_000_000
"""Approximate size of a block of members in bytes; one member requires the reading of its block."""

ABSENT = np.full(2, 2**64 - 1, dtype="<u8").tobytes()
Json = bool | int | float | str | None | Sequence["Json"] | Mapping[str, "Json"]
Attributes = Mapping[str, Json]
"""Attributes of a group or an array, in values of JSON."""

Numbers = NDArray[np.generic]

Variables = Mapping[str, tuple[tuple[str, ...], Numbers, Attributes]]
"""Dimensions, numbers and attributes of variables by name."""

BYTES: Json = {"name": "bytes", "configuration": {"endian": "little"}}
CHECKSUM: Json = {"name": "crc32c"}
SIZE_OF_CHECKSUM = 4

WRITER_THREADS = 4
"""Number of threads that write the files of a group."""


Places = int | slice | NDArray[np.int_] | NDArray[np.bool_]


class StoreError(ValueError):
    """A group or one of its arrays differs from the format of this module."""


@dataclass(frozen=True)
class Described:
    """Description of an array without its numbers.

    Parameters
    ----------
    dims : tuple of str
    shape : tuple of int
    kind : {"float64", "float32", "int64"}
    attributes : mapping
    chunk, block : int
        Members of a shard, and of a block in it; 0 of an array in one block.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    kind: str
    attributes: Attributes = field(default_factory=dict)
    chunk: int = 0
    block: int = 0

    @classmethod
    def of(cls, dims: tuple[str, ...], values: Numbers, attributes: Attributes) -> Described:
        """Return the description of an array in one block."""
        return cls(tuple(map(str, dims)), values.shape, values.dtype.name, plain_attributes(attributes))

    def in_shards(self, chunk: int, block: int) -> Described:
        """Return the description of the array in shards."""
        return replace(self, chunk=chunk, block=block)

    @property
    def dtype(self) -> np.dtype[np.generic]:
        """Type of the numbers in a file."""
        return np.dtype(KINDS[self.kind])

    @property
    def member_bytes(self) -> int:
        """Number of bytes of one place along the first axis."""
        return math.prod(self.shape[1:]) * self.dtype.itemsize

    @property
    def total_bytes(self) -> int:
        """Number of bytes of all numbers."""
        return math.prod(self.shape) * self.dtype.itemsize

    @property
    def is_empty(self) -> bool:
        """True if a length is zero: Zarr stores no file for such an array."""
        return 0 in self.shape

    @property
    def metadata(self) -> dict[str, Json]:
        """Zarr's description of the array."""
        inner: list[Json] = [BYTES, CHECKSUM]
        whole = [max(length, 1) for length in self.shape]
        chunk, codecs = whole, inner
        if self.chunk:
            chunk = [self.chunk, *whole[1:]]
            sharding: dict[str, Json] = {
                "chunk_shape": [self.block, *whole[1:]],
                "codecs": inner,
                "index_codecs": inner,
            }
            codecs = [{"name": "sharding_indexed", "configuration": {**sharding, "index_location": "end"}}]
        return {
            "zarr_format": 3,
            "node_type": "array",
            "shape": list(self.shape),
            "data_type": self.kind,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": 0 if self.kind == "int64" else "NaN",
            "codecs": codecs,
            "attributes": dict(self.attributes),
            "dimension_names": list(self.dims),
            "storage_transformers": [],
        }

    @classmethod
    def read(cls, name: str, given: Any) -> Described:
        """Return the description in a file; raise a `StoreError` unless this module writes it in the same way."""
        try:
            shape, chunk = given["shape"], given["chunk_grid"]["configuration"]["chunk_shape"]
            codec = given["codecs"][0]
            sharded = codec["name"] == "sharding_indexed"
            own = (chunk[0], codec["configuration"]["chunk_shape"][0]) if sharded else (0, 0)
            found = cls(tuple(given["dimension_names"]), tuple(shape), given["data_type"], given["attributes"], *own)
            whole = all(type(n) is int and 0 <= n < 2**48 for n in (*found.shape, *own))
            same = whole and found.kind in KINDS and found.metadata == given and (not sharded or own[0] % own[1] == 0)
        except (KeyError, IndexError, TypeError, ValueError, ZeroDivisionError, AttributeError):
            same = False
        if not same or not name.isidentifier():
            raise StoreError(f"{quoted(name)} is described in another way")
        return found

    # ------------------------------------------------------------------ numbers

    def key(self, number: int = 0) -> str:
        """Return the name of the file of a shard, or of an array in one block."""
        return ".".join(["c", str(number), *["0"] * (len(self.shape) - 1)]) if self.shape else "c"

    def written(self, folder: Path, values: Numbers, number: int = 0) -> None:
        """Write the numbers of the members of one shard, or of all, to a file that has its name when it is complete."""
        if self.is_empty:
            return
        with _new_file(folder / self.key(number)) as stream:
            for block in self._blocks(values):
                stream.write(block.data)
                stream.write(_checksum(block))
            stream.write(self.index(len(values)) if self.chunk else b"")

    def _blocks(self, values: Numbers) -> Iterator[Numbers]:
        """Yield the numbers as they are written, which are copied only where they are not in one piece."""
        if not self.chunk:
            yield np.ascontiguousarray(values, dtype=self.dtype)
            return
        for first in range(0, len(values), self.block):
            block = values[first : first + self.block]
            if len(block) < self.block:
                missing = (self.block - len(block), *self.shape[1:])
                block = np.concatenate([block, np.full(missing, 0 if self.kind == "int64" else np.nan, self.dtype)])
            yield np.ascontiguousarray(block, dtype=self.dtype)

    def index(self, members: int) -> bytes:
        """Return Zarr's index of the blocks of a shard."""
        count, size = -(-members // self.block), self.block * self.member_bytes
        places = np.empty((count, 2), dtype="<u8")
        places[:, 0], places[:, 1] = np.arange(count) * (size + SIZE_OF_CHECKSUM), size + SIZE_OF_CHECKSUM
        index = places.tobytes() + ABSENT * (self.chunk // self.block - count)
        return index + _checksum(index)

    def size_of(self, members: int) -> int:
        """Return the number of bytes of the file of a shard with so many members, or of the file of the array."""
        if not self.chunk:
            return self.total_bytes + SIZE_OF_CHECKSUM
        blocks = -(-members // self.block) * (self.block * self.member_bytes + SIZE_OF_CHECKSUM)
        return blocks + 16 * (self.chunk // self.block) + SIZE_OF_CHECKSUM


class StoredArray:
    """Array in a store, which is read when it is indexed; NaN for members of chunks that are not complete.

    Parameters
    ----------
    folder : Path
        Folder of the array.
    about : Described
        Description of the array.
    whole : array of bool
        True for each complete shard. An array in one block ignores it.
    """

    def __init__(self, folder: Path, about: Described, whole: NDArray[np.bool_]) -> None:
        self._folder, self.about, self._whole = folder, about, whole
        self.shape, self.ndim, self.dtype = about.shape, len(about.shape), about.dtype.newbyteorder("=")

    def __len__(self) -> int:
        return self.shape[0]

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> Numbers:
        return np.asarray(self.members(slice(None)) if self.about.chunk else self._whole_array(), dtype=dtype)

    def members(self, index: Places, at: Places = slice(None)) -> Numbers:
        """Return the rows of some members of an array in shards, at some places along the second axis."""
        places = np.arange(len(self))[index]
        wanted = np.atleast_1d(places)
        shape = np.empty(self.shape[1:], dtype=bool)[at].shape if self.ndim > 1 else ()
        fill = 0 if self.about.kind == "int64" else np.nan
        out = np.full((wanted.size, *shape), fill, dtype=self.dtype)
        own = wanted // self.about.block
        order = np.argsort(own, kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(own[order])) + 1) if order.size else ():
            block = int(own[group[0]])
            number, inside = divmod(block, self.about.chunk // self.about.block)
            if self._whole[number]:
                rows = self._block(number, inside)[wanted[group] - block * self.about.block]
                out[group] = rows[:, at] if self.ndim > 1 else rows
        return out if places.ndim else out[0]

    def _whole_array(self) -> Numbers:
        content = self._content(0, 0, self.about.total_bytes)
        return np.frombuffer(content, self.about.dtype).reshape(self.shape).astype(self.dtype, copy=False)

    def _block(self, number: int, inside: int) -> Numbers:
        size = self.about.block * self.about.member_bytes
        content = self._content(number, inside * (size + SIZE_OF_CHECKSUM), size)
        rows = np.frombuffer(content, self.about.dtype).reshape(self.about.block, *self.shape[1:])
        return rows.astype(self.dtype, copy=False)

    def _content(self, number: int, place: int, size: int) -> memoryview:
        """Return some bytes of a shard, which their checksum must follow; an empty array contains none."""
        if self.about.is_empty:
            return memoryview(b"")
        with self._opened(number) as stream:
            stream.seek(place)
            content = memoryview(stream.read(size + SIZE_OF_CHECKSUM))
        if _checksum(content[:size]) != content[size:]:
            raise StoreError(
                f"{shortened(self._folder)} has other numbers than were written, a checksum differs; the call that "
                "made the store computes them again"
            )
        return content[:size]

    def _members_of(self, number: int) -> int:
        return min(self.about.chunk, len(self) - number * self.about.chunk) if self.about.chunk else 0

    def _opened(self, number: int) -> BinaryIO:
        """Return the file of a shard, which is of the size that is announced."""
        path = self._folder / self.about.key(number)
        members = self._members_of(number)
        if self._folder.is_symlink():
            raise StoreError(f"{shortened(self._folder.name)} is a link")
        try:
            stream = open(path, "rb", opener=_plain_file)  # noqa: SIM115 - the caller closes it
        except OSError as error:
            raise StoreError(f"{shortened(path.parent.name)}/{shortened(path.name)}: {error.strerror}") from None
        found, announced = os.fstat(stream.fileno()).st_size, self.about.size_of(members)
        if found != announced:
            stream.close()
            raise StoreError(
                f"{shortened(path.parent.name)}/{shortened(path.name)} must have {announced} bytes and has {found}"
            )
        return stream

    def check_file(self, number: int = 0) -> None:
        """Raise a `StoreError` if the file of a shard is missing, or its size or its index is wrong."""
        if self.about.is_empty:
            return
        with self._opened(number) as stream:
            if self.about.chunk:
                index = self.about.index(self._members_of(number))
                stream.seek(-len(index), os.SEEK_END)
                if stream.read() != index:
                    raise StoreError(
                        f"{shortened(self._folder.name)} has its blocks in other places: the index differs"
                    )

    def check_content(self, number: int = 0) -> None:
        """Raise a `StoreError` if a checksum of a shard, or of an array in one block, differs; read all of it."""
        self.check_file(number)
        if not self.about.chunk:
            self._whole_array()
            return
        for inside in range(-(-self._members_of(number) // self.about.block)):
            self._block(number, inside)


class JoinedArrays:
    """Stored arrays, joined along their last axis."""

    def __init__(self, arrays: list[StoredArray]) -> None:
        self._arrays, first = arrays, arrays[0]
        self.shape = (*first.shape[:-1], sum(array.shape[-1] for array in arrays))
        self.ndim, self.dtype = first.ndim, first.dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> Numbers:
        return np.asarray(self.members(slice(None)), dtype=dtype)

    def members(self, index: Places, at: Places = slice(None)) -> Numbers:
        """Return the rows of some members at some places along the second axis."""
        return np.concatenate([array.members(index, at) for array in self._arrays], axis=-1)


# ---------------------------------------------------------------------- groups


def write_group(folder: Path, described: Mapping[str, Described], attributes: Attributes) -> None:
    """Write the descriptions of arrays into an existing folder, and last the description that completes the group."""
    arrays = {name: about.metadata for name, about in described.items()}
    side_by_side(partial(_write_description, own_folder(folder / name), each) for name, each in arrays.items())
    _write_json(folder / GROUP, _group(arrays, plain_attributes(attributes)))
    synced(folder)


def _write_description(folder: Path, metadata: Attributes) -> None:
    _write_json(folder / GROUP, metadata)
    synced(folder)


def side_by_side(writes: Iterable[Callable[[], None]]) -> None:
    """Write files on several threads, which wait for the disk most of the time."""
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(WRITER_THREADS) as writers:
        for written in [writers.submit(write) for write in writes]:
            written.result()


def own_folder(path: Path) -> Path:
    """Return the path of a folder; make it if it does not exist or is a link."""
    if path.is_symlink():
        path.unlink()
    path.mkdir(exist_ok=True)
    return path


def check_descriptions(folder: Path, described: Mapping[str, Described]) -> None:
    """Raise a `StoreError` if a description in the group differs from the array's, or an array is a link."""
    for name, about in described.items():
        if (folder / name).is_symlink():
            raise StoreError(f"{name} is a link")
        if _json_in(folder / name) != about.metadata:
            raise StoreError(f"{name} is described in another way")


def check_lengths(described: Mapping[str, Described]) -> None:
    """Raise a `StoreError` if two arrays have different lengths along a dimension, without reading them."""
    lengths: dict[str, int] = {}
    for name, about in described.items():
        if len(about.dims) != len(about.shape):
            raise StoreError(f"{name} has {len(about.dims)} dimensions and {len(about.shape)} lengths")
        for dim, length in zip(about.dims, about.shape, strict=True):
            if lengths.setdefault(dim, length) != length:
                raise StoreError(f"{name} has another length along {dim} than the others")


def read_group(folder: Path) -> tuple[dict[str, Described], dict[str, Any]]:
    """Return the arrays of a group and its attributes; raise a `StoreError` that names any other format."""
    found = _json_in(folder)
    try:
        attributes, arrays = dict(found["attributes"]), found["consolidated_metadata"]["metadata"]
        attributes.pop("digest", None)
        described = {str(name): Described.read(str(name), metadata) for name, metadata in arrays.items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise error if isinstance(error, StoreError) else StoreError(f"{GROUP} is no description of a group") from None
    if _group(arrays, attributes) != found:
        raise StoreError(f"{GROUP} has other numbers or texts than were written: the digest differs")
    return described, attributes


def _json_in(folder: Path) -> Any:
    """Return the description of an array or a group."""
    try:
        with open(folder / GROUP, "rb", opener=_plain_file) as stream:
            content = stream.read(MAX_JSON_BYTES + 1)
        if len(content) > MAX_JSON_BYTES:
            raise StoreError(f"{GROUP} is longer than {MAX_JSON_BYTES} bytes")
        return json.loads(content)
    except OSError as error:
        raise StoreError(f"{shortened(folder.name)}/{GROUP}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise error if isinstance(error, StoreError) else StoreError(f"{GROUP} is no description of a group") from None


def _group(arrays: Attributes, attributes: Attributes) -> dict[str, Json]:
    """Return Zarr's description of a group, with its SHA-256."""
    consolidated: Json = {"kind": "inline", "must_understand": False, "metadata": dict(arrays)}
    content = json.dumps([arrays, attributes], sort_keys=True).encode()
    own = {**attributes, "digest": hashlib.sha256(content).hexdigest()}
    return {"zarr_format": 3, "node_type": "group", "attributes": own, "consolidated_metadata": consolidated}


def _write_json(path: Path, content: Attributes) -> None:
    """Write a description, whole or not at all."""
    with _new_file(path) as stream:
        stream.write(json.dumps(content, indent=1).encode())


@contextlib.contextmanager
def _new_file(path: Path) -> Iterator[BinaryIO]:
    """Open a new file under a name that no other writer uses; flush it and give it its name in the end."""
    part = path.with_name(f"{path.name}.{os.urandom(8).hex()}.part")
    try:
        with part.open("wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _plain_file(path: str, flags: int) -> int:
    """Open a regular file; raise an error for a link, a pipe or a device."""
    number = os.open(path, flags | REGULAR_FILE)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise StoreError(f"{shortened(Path(path).name)} is no file")
    return number


def _checksum(content: bytes | memoryview | Numbers) -> bytes:
    """Return the CRC-32C of some bytes."""
    return crc32c(np.frombuffer(content, np.uint8)).to_bytes(SIZE_OF_CHECKSUM, "little")


def plain_attributes(attributes: Attributes) -> dict[str, Json]:
    """Return attributes as they are after writing and reading JSON."""
    try:
        out: dict[str, Json] = json.loads(json.dumps({str(name): plain(value) for name, value in attributes.items()}))
    except (TypeError, ValueError) as error:
        raise TypeError(f"attributes must be texts, numbers, and lists of these, got others: {error}.") from None
    return out


def plain(value: Json | np.generic | Numbers) -> Json:
    """Return a Python number for a NumPy number, and a text for an array."""
    return value.item() if isinstance(value, np.generic) else str(value) if isinstance(value, np.ndarray) else value
