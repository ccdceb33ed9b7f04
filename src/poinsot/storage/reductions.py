"""Results of a user's function of each chunk of an ensemble, and the datasets of all chunks as one."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import TYPE_CHECKING

from poinsot.printable import described, quoted
from poinsot.storage.ensemble_store import EnsembleStore, dataset_of_arrays
from poinsot.storage.zarr_group import plain_attributes

if TYPE_CHECKING:
    import numpy as np
    import xarray
    from numpy.typing import NDArray

__all__ = ["concatenated", "reduced", "reduction"]


def reduction(reduce: Callable[[xarray.Dataset], xarray.Dataset], data: xarray.Dataset) -> xarray.Dataset:
    """Return the result of a user's function of a dataset, with the labels that are numbers or words."""
    import xarray

    try:
        found = reduce(data)
    except Exception as error:
        first, last = data.member.values[[0, -1]]
        error.add_note(f"reduce was given the members {first} to {last}.")
        raise
    if isinstance(found, xarray.DataArray):
        found = found.to_dataset(name=found.name or "reduced")
    if not isinstance(found, xarray.Dataset):
        raise TypeError(f"reduce must return a dataset, got {described(found)}.")
    labels = [name for name, each in found.coords.items() if _numbers_or_words(each.values)]
    stored = {name: found.variables[name] for name in (*found.data_vars, *labels)}
    plain = {name: (x.dims, x.values, plain_attributes(x.attrs)) for name, x in stored.items()}
    return xarray.Dataset(plain).set_coords(labels)


def _numbers_or_words(values: NDArray[np.generic]) -> bool:
    return values.dtype.kind in "biufU" or all(isinstance(value, str) for value in values.flat)


def reduced(store: EnsembleStore) -> xarray.Dataset:
    """Return the results of a reduction of the complete chunks."""
    return concatenated(dataset_of_arrays(*each) for each in store.extras())


def concatenated(parts: Iterable[xarray.Dataset]) -> xarray.Dataset:
    """Return datasets of chunks as one, joined along members if they lie along them, else along a dimension `chunk`."""
    import xarray

    found = list(parts)
    first = found[0] if found else xarray.Dataset()
    names = dict.fromkeys(name for part in found for name in part.variables)
    joined = {name: _joined(name, [part.variables.get(name) for part in found], name in first.coords) for name in names}
    return xarray.Dataset(joined).set_coords([name for name in first.coords if joined[name].dims == first[name].dims])


def _joined(name: Hashable, each: Sequence[xarray.Variable | None], coordinate: bool) -> xarray.Variable:
    """Return a variable of all chunks as one; a coordinate that all chunks share stays as it is."""
    import xarray

    known = [one for one in each if one is not None]
    first = known[0]
    if len(known) < len(each) or any(one.dims != first.dims or _shape(one) != _shape(first) for one in known):
        raise ValueError(
            f"reduce must return the same variables and dimensions for each chunk, got others of {quoted(str(name))}. "
            "Let what differs lie along member, or pad it."
        )
    plain = [xarray.DataArray(one.values, dims=one.dims, attrs=first.attrs) for one in known]
    if coordinate and "member" not in plain[0].dims and all(plain[0].equals(one) for one in plain):
        return plain[0].variable
    return xarray.concat(plain, "member" if "member" in plain[0].dims else "chunk").variable


def _shape(variable: xarray.Variable) -> dict[Hashable, int]:
    """Return the sizes of a variable without the number of members."""
    return {dim: size for dim, size in variable.sizes.items() if dim != "member"}
