"""The public names, and what importing them costs."""

import subprocess
import sys

import poinsot

NAMES = [
    "Andoyer",
    "Attitude",
    "Body",
    "Calendar",
    "CassiniState",
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
    "PeriodicMotion",
    "Potential",
    "PrecessingOrbit",
    "PropagationError",
    "PropagationInterrupted",
    "RotatingFrame",
    "RotatingPoint",
    "Sky",
    "State",
    "System",
    "ThreeBodyOrbit",
    "Torque",
    "Trajectory",
    "UniformGravity",
    "Vector",
    "cassini_state",
    "equilibria",
    "free_motion",
    "functions",
    "omm_orbit",
    "orbit_sum",
    "periodic_motion",
    "planet_orbit",
    "plot_herpolhode",
    "plot_momentum_sphere",
    "plot_poinsot",
    "plot_polhode",
    "plot_quaternions",
    "project_to_tangent",
    "propagate",
    "read_oem",
    "save",
    "spice_orbit",
    "tle_orbit",
    "two_body_orbit",
]


def test_public_names_are_these_and_documented():
    assert poinsot.__all__ == NAMES
    assert all(getattr(poinsot, name).__doc__ for name in NAMES)


def test_import_leaves_heavy_packages_alone():
    code = "import sys, poinsot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"matplotlib", "xarray", "pandas", "netCDF4", "typer", "rich", "scipy.spatial"}
    assert not (heavy | {"astropy", "erfa", "sgp4", "spiceypy"}) & set(loaded)
