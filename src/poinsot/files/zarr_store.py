"""Datasets as Zarr stores of format 2 without codecs: each array is one uncompressed file.

Such a store is read without a library, and cannot name a codec to execute.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.files.untrusted import read_bytes, read_text

if TYPE_CHECKING:
    import xarray

__all__ = ["GROUP", "plain", "read_store", "write_store"]

GROUP, ARRAY, ATTRIBUTES, DIMENSIONS = ".zgroup", ".zarray", ".zattrs", "_ARRAY_DIMENSIONS"

KINDS = ("<f8", "<i8")
"""Of numbers, which have 8 bytes."""

MOST_OF_JSON = 8 * 1024 * 1024
"""Bytes of the attributes of a store: its scenario, and the reason of each member that failed."""


def write_store(data: xarray.Dataset, folder: Path) -> None:
    """Write a dataset into a new folder."""
    folder.mkdir()
    texts = {GROUP: {"zarr_format": 2}, ATTRIBUTES: {str(name): plain(value) for name, value in data.attrs.items()}}
    for name, variable in data.variables.items():
        values = np.ascontiguousarray(variable.values).reshape(variable.shape)
        values = values.astype(values.dtype.newbyteorder("<"))
        (folder / str(name)).mkdir()
        texts[f"{name}/{ARRAY}"] = _about(values.dtype.str, list(values.shape))
        attributes = {str(key): plain(value) for key, value in variable.attrs.items()}
        texts[f"{name}/{ATTRIBUTES}"] = {DIMENSIONS: list(variable.dims)} | attributes
        if values.size:
            (folder / str(name) / _chunk(values.ndim)).write_bytes(values.tobytes())
    for path, text in texts.items():
        (folder / path).write_text(json.dumps(text, indent=1), encoding="utf-8")


def read_store(folder: Path, needed: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the variables whose names are needed, as a dataset takes them, and the attributes of a store.

    A ValueError refuses an array that is stored in another way than `write_store` does, has not the size that it
    announces, or leads out of the folder.
    """
    attributes = _read_json(folder, ATTRIBUTES)
    names = sorted(path.name for path in folder.iterdir() if needed(path.name))
    return {name: _variable(folder, name) for name in names}, attributes


def _variable(folder: Path, name: str) -> tuple[list[str], NDArray[Any], dict[str, Any]]:
    about, attributes = _read_json(folder, name, ARRAY), _read_json(folder, name, ATTRIBUTES)
    kind, dimensions = str(about.get("dtype")), _listed(attributes.pop(DIMENSIONS, None), str)
    shape = _listed(about.get("shape"), int)
    if kind not in KINDS or min(shape, default=0) < 0:
        raise ValueError(f"{name} has other numbers, or no shape")
    if about != _about(kind, shape):
        raise ValueError(f"{name} has chunks, a codec or a filter")
    return dimensions, _numbers(folder, name, kind, shape), attributes


def _listed(values: Any, kind: type) -> list[Any]:
    if not isinstance(values, list) or any(type(value) is not kind for value in values):
        raise ValueError(f"{values!r} is no list of {kind.__name__}")
    return values


def _numbers(folder: Path, name: str, kind: str, shape: list[int]) -> NDArray[Any]:
    count, content = math.prod(shape), b""
    if count:
        path = _inside(folder, name, _chunk(len(shape)))
        size = path.stat().st_size
        if size != 8 * count:
            raise ValueError(f"{name} announces {count} numbers, and {size} bytes are not as many")
        content = read_bytes(path, size)
    return np.frombuffer(content, dtype=kind).reshape(shape)


def _about(kind: str, shape: list[int]) -> dict[str, Any]:
    """Return what Zarr says of an array in one chunk without codecs, whose missing numbers are none."""
    return {
        "zarr_format": 2,
        "shape": shape,
        "chunks": [max(length, 1) for length in shape],
        "dtype": kind,
        "compressor": None,
        "filters": None,
        "fill_value": None,
        "order": "C",
    }


def _chunk(dimensions: int) -> str:
    return ".".join(["0"] * max(dimensions, 1))


def _inside(folder: Path, *names: str) -> Path:
    """Return the path of a file in a store, to which no link leads."""
    path = folder
    for name in names:
        path = path / name
        if path.is_symlink():
            raise ValueError(f"{name} is a link")
    return path


def _read_json(folder: Path, *names: str) -> dict[str, Any]:
    found = json.loads(read_text(_inside(folder, *names), MOST_OF_JSON))
    if not isinstance(found, dict):
        raise ValueError(f"{'/'.join(names)} is no table")
    return found


def plain(value: Any) -> Any:
    """Return a number of NumPy as one of Python."""
    return value.item() if isinstance(value, np.generic) else str(value) if isinstance(value, np.ndarray) else value
