"""Threads that write NetCDF files at the same time, which crash the process where nothing excludes one another."""

import os
import threading

import numpy as np
import pytest
import xarray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

import forked
from poinsot.storage.netcdf_writer import write_netcdf

THREADS = """
import sys, threading
import numpy as np, poinsot as pt, xarray

body = pt.Body((1.25, 1.0, 0.75))
motion = pt.free_motion(body, body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), np.linspace(0, 1, 9))
first = pt.save(motion, f"{sys.argv[1]}/first.nc")
opened = [xarray.open_dataset(first, decode_times=False, cache=False) for _ in range(4)]
wrong, begin = [], threading.Barrier(16)

def save(number):
    pt.save(motion, f"{sys.argv[1]}/{number}.nc")
    return motion.quaternion

def load(number):
    return pt.load(first).quaternion

def read(number):
    for _ in range(20):
        found = opened[number % 4]["quaternion"].values
    return found

def check(task, number):
    begin.wait()
    try:
        if not np.array_equal(task(number), motion.quaternion):
            wrong.append(f"{task.__name__} {number}: other numbers")
    except BaseException as error:
        wrong.append(f"{task.__name__} {number}: {error!r}")

tasks = [save] * 12 + [load] + [read] * 3
threads = [threading.Thread(target=check, args=(task, number)) for number, task in enumerate(tasks)]
[each.start() for each in threads]
[each.join() for each in threads]
print(wrong)
"""


def test_threads_that_save_load_and_read_at_the_same_time_do_not_crash(tmp_path):
    ended = forked.run(THREADS, tmp_path)
    assert (ended.returncode, ended.stdout.strip()) == (0, "[]"), ended.stderr
    saved = [xarray.load_dataset(path, decode_times=False) for path in tmp_path.glob("*.nc")]
    assert len(saved) == 13
    assert all(each.identical(saved[0]) for each in saved)


def test_a_call_waits_for_the_lock_of_xarray(tmp_path):
    data, path = xarray.Dataset({"x": ("t", [1.0, np.nan])}, attrs={"a": "b"}), tmp_path / "it.nc"
    writer = threading.Thread(target=write_netcdf, args=(data, path))
    with NETCDF4_PYTHON_LOCK:
        writer.start()
        writer.join(0.2)
        assert writer.is_alive()
        assert not path.exists()
    writer.join()
    assert xarray.load_dataset(path).identical(data)


def test_the_lock_is_free_after_an_error(tmp_path):
    data = xarray.Dataset({"x": 1.0})
    with pytest.raises(OSError, match=r"No such file|Permission denied"):
        write_netcdf(data, tmp_path / "none" / "it.nc")
    write_netcdf(data, tmp_path / "it.nc")
    assert os.listdir(tmp_path) == ["it.nc"]


def test_arrays_of_dask_are_written(tmp_path):
    """Threads of dask write the blocks of an array while the lock is held."""
    data = xarray.Dataset({"x": (("member", "t"), np.arange(40.0).reshape(8, 5))})
    write_netcdf(data.chunk({"member": 2}), tmp_path / "it.nc")
    assert xarray.load_dataset(tmp_path / "it.nc").identical(data)
