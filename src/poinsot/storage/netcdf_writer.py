"""Writing of a NetCDF-4 file by one thread of the process at a time: the C libraries are not thread-safe."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray

__all__ = ["write_netcdf"]


def write_netcdf(data: xarray.Dataset, path: Path) -> None:
    """Write a dataset to a new file; numbers that are NaN are not marked as missing.

    xarray locks only parts of `to_netcdf`, and two threads that create variables at the same time crash the process.
    This function holds the lock of xarray from the opening to the closing of the file, so that it excludes also the
    locked parts of the user's calls of xarray. The lock is not reentrant; the store therefore receives another one.
    """
    from xarray.backends import NetCDF4DataStore
    from xarray.backends.common import ArrayWriter
    from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

    floats = [name for name, array in data.variables.items() if array.dtype.kind == "f"]
    writer = ArrayWriter()
    with (
        NETCDF4_PYTHON_LOCK,
        contextlib.closing(NetCDF4DataStore.open(str(path), mode="w", lock=threading.Lock())) as store,
    ):
        data.dump_to_store(store, writer=writer, encoding={name: {"_FillValue": None} for name in floats})
        writer.sync()
