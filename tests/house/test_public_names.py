"""The public names, and what importing them costs."""

import subprocess
import sys

import poinsot

NAMES = [
    "Andoyer",
    "Attitude",
    "Body",
    "Ephemeris",
    "Equilibrium",
    "EscapeOrbit",
    "FixedPoint",
    "Frame",
    "FreeRotation",
    "GravityGradient",
    "KeplerOrbit",
    "LagrangePoint",
    "LinearDamping",
    "OblateGravityGradient",
    "Orbit",
    "Potential",
    "PrecessingOrbit",
    "PropagationError",
    "PropagationInterrupted",
    "RotatingFrame",
    "RotatingPoint",
    "Sky",
    "State",
    "System",
    "Torque",
    "Trajectory",
    "UniformGravity",
    "Vector",
    "equilibria",
    "free_motion",
    "functions",
    "plot_herpolhode",
    "plot_momentum_sphere",
    "plot_poinsot",
    "plot_polhode",
    "plot_quaternions",
    "project_to_tangent",
    "propagate",
    "save",
    "two_body_orbit",
]


def test_public_names_are_these_and_documented():
    assert poinsot.__all__ == NAMES
    assert all(getattr(poinsot, name).__doc__ for name in NAMES)


def test_import_leaves_heavy_packages_alone():
    code = "import sys, poinsot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"matplotlib", "xarray", "pandas", "netCDF4", "typer", "rich", "scipy.spatial"} & set(loaded)
