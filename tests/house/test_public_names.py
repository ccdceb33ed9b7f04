"""The public names, and what importing them costs."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import poinsot


@pytest.mark.parametrize("package", [poinsot, poinsot.plot])
def test_every_name_of_the_stub_is_public_and_documented(package):
    stub = ast.parse(Path(package.__file__).with_suffix(".pyi").read_text())
    imported = [alias.name for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    (public,) = (ast.literal_eval(node.value) for node in stub.body if isinstance(node, ast.Assign))
    assert public == sorted(imported) == package.__all__
    assert all(getattr(package, name).__doc__ for name in public)


def test_every_name_of_the_plots_is_a_function_and_no_module():
    assert all(inspect.isfunction(getattr(poinsot.plot, name)) for name in poinsot.plot.__all__)


@pytest.mark.parametrize(
    ("use", "more"),
    [
        ("", {"numpy", "scipy", "heyoka"}),
        ("poinsot.propagate, poinsot.System, poinsot.KeplerOrbit", set()),
        ("[getattr(poinsot.plot, name) for name in poinsot.plot.__all__]", set()),
    ],
)
def test_import_leaves_heavy_packages_alone(use, more):
    code = f"import sys, poinsot; {use}; print(*sys.modules)" if use else "import sys, poinsot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"matplotlib", "xarray", "pydantic", "zarr", "pandas", "netCDF4", "typer", "rich", "scipy.spatial"}
    assert not (heavy | more | {"astropy", "erfa", "sgp4", "spiceypy", "trimesh"}) & set(loaded)
