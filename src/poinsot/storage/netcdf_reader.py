"""Reading of a NetCDF-4 file in a separate process: the library does not validate pointers in the file."""

from __future__ import annotations

import json
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

__all__ = ["content"]

Variable = list[Any]


def content(path: str, size: int, names: list[str], beginnings: list[str]) -> tuple[Any, list[NDArray[Any]]]:
    """Return the attributes of a file, and its variables with one of the names or beginnings, with their arrays.

    The attribute `observables` names further variables.
    What `save` does not write is refused before it is read: groups, types of its own, and variables in chunks, with
    filters, or of more bytes than the file, `size`.
    """
    with netCDF4.Dataset(path) as file:
        if file.groups or file.cmptypes or file.vltypes or file.enumtypes:
            raise ValueError("it has groups or types of its own")
        known = {*names, *_named_in(file)}
        wanted = [name for name in file.variables if name in known or name.startswith(tuple(beginnings))]
        variables = [file.variables[name] for name in wanted]
        for variable in variables:
            if not isinstance(variable.dtype, np.dtype) or variable.dtype.kind not in "fiu":
                raise ValueError(f"{variable.name} has no numbers")
            if variable.ndim and variable.chunking() != "contiguous":
                raise ValueError(f"{variable.name} is in chunks, which may be compressed")
        announced = sum(int(np.prod(variable.shape, dtype=object)) * variable.dtype.itemsize for variable in variables)
        if announced > size:
            raise ValueError(f"{size} bytes cannot be the {announced} that it announces")
        file.set_auto_maskandscale(False)
        arrays = [np.asarray(variable[...]) for variable in variables]
        described = [[variable.name, variable.dimensions, _attributes(variable)] for variable in variables]
        return [_attributes(file), described], arrays


def _named_in(file: netCDF4.Dataset) -> list[str]:
    """Return the names of the readings in a file, which are the keys of its attribute `observables`."""
    text = file.getncattr("observables") if "observables" in file.ncattrs() else "{}"
    described = json.loads(text)
    return list(described) if isinstance(described, dict) else []


def _attributes(owner: Any) -> dict[str, Any]:
    return {name: _plain(name, owner.getncattr(name)) for name in owner.ncattrs()}


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, str):
        return value
    if np.ndim(value) or np.asarray(value).dtype.kind not in "fiu":
        raise ValueError(f"the attribute {name} is no number and no text")
    return np.asarray(value).item()
