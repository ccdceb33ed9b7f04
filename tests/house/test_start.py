"""The first motion of a process loads no library that it does not use."""

import platform
import subprocess
import sys

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
