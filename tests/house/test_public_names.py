"""The public names, and what importing them costs."""

import subprocess
import sys

import poinsot

NAMES = [
    "Andoyer",
    "Assembly",
    "Attitude",
    "AttitudeTable",
    "Body",
    "Calendar",
    "CassiniState",
    "Cylinder",
    "Ellipsoid",
    "EllipsoidGravity",
    "Ephemeris",
    "Equilibrium",
    "EscapeOrbit",
    "FixedPoint",
    "Frame",
    "FreeRotation",
    "GravityField",
    "GravityGradient",
    "HarmonicGravity",
    "KeplerOrbit",
    "LagrangePoint",
    "LineSpectrum",
    "LinearDamping",
    "MasconGravity",
    "Mascons",
    "Mesh",
    "Oblateness",
    "Orbit",
    "PeriodicMotion",
    "Potential",
    "PrecessingOrbit",
    "PropagationError",
    "PropagationInterrupted",
    "RotatingFrame",
    "RotatingPoint",
    "Scenario",
    "Shape",
    "Sky",
    "State",
    "System",
    "ThreeBodyOrbit",
    "Torque",
    "Trajectory",
    "UniformGravity",
    "Vector",
    "cassini_state",
    "diffusion",
    "equilibria",
    "free_motion",
    "frequencies",
    "functions",
    "load",
    "omm_orbit",
    "orbit_sum",
    "periodic_motion",
    "planet_orbit",
    "plot_angular_momentum",
    "plot_difference",
    "plot_drift",
    "plot_euler_angles",
    "plot_herpolhode",
    "plot_momentum_sphere",
    "plot_poinsot",
    "plot_polhode",
    "plot_quaternions",
    "plot_rates",
    "plot_roll_pitch_yaw",
    "project_to_tangent",
    "propagate",
    "read_aem",
    "read_apm",
    "read_field",
    "read_mesh",
    "read_oem",
    "read_quaternion_csv",
    "read_scenario",
    "read_stk_attitude",
    "save",
    "spice_attitude",
    "spice_orbit",
    "tle_orbit",
    "two_body_orbit",
    "view",
    "write_aem",
    "write_apm",
    "write_ck",
    "write_quaternion_csv",
    "write_stk_attitude",
]


def test_public_names_are_these_and_documented():
    assert poinsot.__all__ == NAMES
    assert all(getattr(poinsot, name).__doc__ for name in NAMES)


def test_import_leaves_heavy_packages_alone():
    code = "import sys, poinsot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"matplotlib", "xarray", "pydantic", "zarr", "pandas", "netCDF4", "typer", "rich", "scipy.spatial"}
    assert not (heavy | {"astropy", "erfa", "sgp4", "spiceypy", "trimesh"}) & set(loaded)
