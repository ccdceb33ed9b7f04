"""What the package uses of cupy, with arrays of NumPy and CUDA C compiled for the processor."""

from __future__ import annotations

import ctypes
import functools
import shutil
import subprocess
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

COMPILER = next(filter(None, map(shutil.which, ("c++", "g++", "clang++"))), None)

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="needs a compiler of C++")

STUBS = """
#include <math.h>
#include <string.h>
#define __global__
#define __device__
#define __noinline__
#define __launch_bounds__(threads)
static struct { unsigned x; } blockIdx, threadIdx;
static unsigned long long atomicAdd(unsigned long long *x, unsigned long long n) {
    unsigned long long old = *x; *x += n; return old;
}
static long long __double_as_longlong(double x) { long long y; memcpy(&y, &x, 8); return y; }
static double __longlong_as_double(long long x) { double y; memcpy(&y, &x, 8); return y; }
"""

LAUNCH = """
extern "C" void launch(unsigned blocks, unsigned threads, char *queue, long long count) {
    for (blockIdx.x = 0; blockIdx.x < blocks; blockIdx.x++)
        for (threadIdx.x = 0; threadIdx.x < threads; threadIdx.x++) propagate(queue, count);
}
"""


@functools.cache
def built(code: str, entry: str = LAUNCH) -> Any:
    """Return a library: CUDA C, and a function of the processor's behind it."""
    folder = tempfile.mkdtemp()
    source, library = Path(folder, "kernel.cpp"), Path(folder, "kernel.so")
    source.write_text(STUBS + code + entry)
    options = ["-std=c++17", "-O0", "-ffp-contract=off", "-fno-strict-aliasing", "-fPIC", "-shared", "-w"]
    subprocess.run([str(COMPILER), *options, str(source), "-o", str(library)], check=True)
    loaded = ctypes.CDLL(str(library))
    shutil.rmtree(folder)
    return loaded


class Array(np.ndarray[Any, Any]):
    """An array with the address that cupy's have; one of NumPy does not take it where cupy's does not."""

    @property
    def data(self) -> Any:
        return SimpleNamespace(ptr=self.ctypes.data)


def asarray(array: Any) -> Array:
    """Return a copy, as on another machine."""
    return np.array(array).view(Array)


def asnumpy(array: Array) -> Any:
    """Return a copy, as on another machine."""
    assert isinstance(array, Array)
    return np.array(array)


class RawModule:
    """A module of one kernel."""

    def __init__(self, code: str, options: tuple[str, ...]) -> None:
        assert "--fmad=false" in options
        self._library = built(code)

    def get_function(self, name: str) -> Any:
        """Return what launches the kernel."""
        assert name == "propagate"

        def launch(grid: tuple[int], block: tuple[int], arguments: tuple[Any, ...]) -> None:
            queue, count = arguments
            assert isinstance(queue, Array)
            self._library.launch(grid[0], block[0], ctypes.c_void_p(queue.data.ptr), ctypes.c_longlong(int(count)))

        return launch


class CUDARuntimeError(RuntimeError):
    """What the driver complains of."""


class OutOfMemoryError(MemoryError):
    """No room on the device."""


runtime = SimpleNamespace(
    getDeviceCount=lambda: 1, memGetInfo=lambda: (2**33, 2**34), CUDARuntimeError=CUDARuntimeError
)
cuda = SimpleNamespace(runtime=runtime, memory=SimpleNamespace(OutOfMemoryError=OutOfMemoryError))
