"""The writer of stores measured side by side with `zarr` and region writes of `xarray`: same arrays, same chunks.

Run `python -m benchmarks.zarr_writers`. Each writer stores the states of an ensemble in four chunks of members, one
shard for each chunk, with checksums, without compression and flushed to the disk, and writes one chunk a second time,
as a resumed run does. The table lists the minima of the wall time and of the processor time, and which files differ
from the files of the package.
"""

import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import xarray
import zarr
from zarr.codecs import BytesCodec, Crc32cCodec

from benchmarks.measure import pin
from poinsot.atomic_write import synced
from poinsot.storage.ensemble_store import EnsembleStore, header_of, plain_variables
from poinsot.storage.zarr_group import Described

CHUNKS, TIMES = 4, 100
CHECKED = [BytesCodec(), Crc32cCodec()]


def arrays(members):
    """Return quaternions and angular momenta of members at all times."""
    random = np.random.default_rng(1)
    sizes = {"quaternion": ("parameter", 4), "angular_momentum_body": ("body", 3)}
    data = {
        name: (("member", "time", axis), random.normal(size=(members, TIMES, n))) for name, (axis, n) in sizes.items()
    }
    return xarray.Dataset(data)


def header_in(folder, data, chunk):
    """Write the header of a store: arrays without chunks, and their descriptions."""
    folder.mkdir()
    rows = {name: Described.of(*each) for name, each in plain_variables(data).items()}
    header_of(xarray.Dataset({"time": np.arange(float(TIMES))}), rows, data.sizes["member"], chunk, {}).write(folder)


def by_package(folder, data, chunk):
    """Return the function that writes one chunk by the writer of the package."""
    header_in(folder, data, chunk)
    store = EnsembleStore(folder)
    rows = {name: each.values for name, each in data.data_vars.items()}
    return lambda at: store.write(at.start // chunk, {name: each[at] for name, each in rows.items()}, {}, {})


def by_zarr(folder, data, chunk):
    """Return the function that writes one chunk by `zarr`."""
    header_in(folder, data, chunk)
    group = zarr.open_group(folder, mode="r+")

    def write(at):
        for name in data.data_vars:
            group[name][at] = data[name].values[at]
        flush(folder, data.data_vars)

    return write


def by_xarray(folder, data, chunk):
    """Return the function that writes one chunk by region writes of `xarray`."""
    header_in(folder, data, chunk)

    def write(at):
        data.isel(member=at).to_zarr(folder, region={"member": at}, mode="r+", consolidated=False)
        flush(folder, data.data_vars)

    return write


def flush(folder, names):
    """Flush the newest file of each array to the disk, as the package does before it calls a chunk complete."""
    for name in names:
        newest = max((folder / name).iterdir(), key=lambda path: path.stat().st_mtime_ns)
        with newest.open("rb") as file:
            os.fsync(file.fileno())
        synced(folder / name)


WRITERS = {"poinsot": by_package, "zarr": by_zarr, "xarray": by_xarray}


def files_of(folder, names):
    """Return the content of the files of arrays by name."""
    return {f"{name}/{path.name}": path.read_bytes() for name in names for path in (folder / name).iterdir()}


def measured(members, rounds):
    """Return for each writer the minima of wall time and processor time, and the files that differ."""
    data, chunk = arrays(members), members // CHUNKS
    places = [slice(first, first + chunk) for first in range(0, members, chunk)]
    wall, used = ({name: [] for name in WRITERS} for _ in range(2))
    found = {}
    for _ in range(rounds):
        for name, writer in WRITERS.items():
            with tempfile.TemporaryDirectory() as parent:
                folder = Path(parent) / "ensemble.zarr"
                write = writer(folder, data, chunk)
                began, processor = time.perf_counter(), time.process_time()
                for at in places:
                    write(at)
                wall[name].append(time.perf_counter() - began)
                used[name].append(time.process_time() - processor)
                write(places[1])
                found[name] = files_of(folder, data.data_vars)
    own = found["poinsot"]
    different = {name: [file for file in own if files.get(file) != own[file]] for name, files in found.items()}
    return {name: (min(wall[name]), min(used[name]), different[name]) for name in WRITERS}


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    pin(2)
    members = int(sys.argv[1]) if sys.argv[1:] else 16_384
    print(
        f"{members} members at {TIMES} times in {CHUNKS} chunks; zarr {zarr.__version__}, xarray {xarray.__version__}"
    )
    print(f"{'writer':10}{'wall, s':>10}{'processor, s':>14}  files that differ")
    for name, (wall, used, different) in measured(members, 7).items():
        print(f"{name:10}{wall:10.3f}{used:14.3f}  {', '.join(different) or 'none'}")
