"""The first motion of a process loads no library that it does not use."""

import os
import platform
import subprocess
import sys

import pytest

NOT_NEEDED = (
    *("asyncio", "concurrent.futures", "difflib", "email", "importlib.metadata", "logging", "multiprocessing"),
    *("socket", "sqlite3", "ssl", "subprocess", "unittest", "xml"),
    *("astropy", "dask", "google_crc32c", "heyoka", "matplotlib", "mpmath", "netCDF4", "numpy.ma", "numpy.testing"),
    *("pandas", "pydantic", "rich", "scipy", "spiceypy", "sympy", "trimesh", "typer", "xarray"),
)
"""Libraries that only some functions of the package use: an import in such a function loads them."""

FIRST_MOTION = """
import sys
import poinsot as pt
system = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(weight=0.5, center_of_mass=(1, 0, 0)))
motion = pt.propagate(system, system.body.state((0, 0.6, 0, 0.8), omega_body=(0, 1, 2)), [0.0, 10.0])
motion.quaternion
print(*sys.modules)
"""


def test_the_first_motion_loads_no_library_that_it_does_not_use():
    found = subprocess.run([sys.executable, "-c", FIRST_MOTION], capture_output=True, text=True, check=True)
    assert sorted({*found.stdout.split()} & {*NOT_NEEDED}) == []


def test_without_llvmlite_one_message_names_the_platform():
    code = "import sys; sys.modules['llvmlite.binding'] = None; import poinsot; poinsot.propagate"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    last = found.stderr.splitlines()[-1]
    assert last.startswith("ImportError: llvmlite must be installed, which compiles the equations of motion, got on ")
    assert platform.machine() in last


@pytest.mark.skipif(sys.platform != "linux", reason="needs a folder that root cannot write")
def test_a_home_folder_that_cannot_be_written_costs_one_warning(tmp_path):
    environment = {name: value for name, value in os.environ.items() if name not in ("POINSOT_CACHE", "XDG_CACHE_HOME")}
    program = [
        sys.executable,
        "-c",
        FIRST_MOTION
        + "pt.propagate(pt.System(system.body), system.body.state((1, 0, 0, 0), omega_body=(0, 1, 2)), [1.0])",
    ]
    environment["HOME"] = "/proc"
    found = subprocess.run(program, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert found.stderr.count("UserWarning") == 1
    assert "the cache folder /proc/.cache/poinsot must be writable, got: " in found.stderr
    assert "Set POINSOT_CACHE to another folder, or to an empty text to use none." in found.stderr
