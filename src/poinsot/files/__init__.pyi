"""The public names of poinsot.files, by the module of each, as `make face` writes them."""

from .attitudes.aem import read_aem, write_aem
from .attitudes.apm import read_apm, write_apm
from .attitudes.attitude_format import AttitudeFormat
from .attitudes.attitude_table import AttitudeTable
from .attitudes.ck import read_ck, spice_attitude, write_ck
from .attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from .attitudes.stk import read_stk_attitude, write_stk_attitude
from .bodies.fields import read_field
from .bodies.meshes import read_mesh, write_damit_shape
from .netcdf import load, save
from .observations.alcdef import read_alcdef, write_alcdef
from .observations.damit_curves import read_damit, write_damit
from .observations.damit_spin import DamitSpin, read_damit_spin, write_damit_spin
from .observations.readings_csv import read_gyro_csv, read_readings_csv, write_readings_csv
from .observations.readings_netcdf import read_readings, write_readings
from .orbits.oem import read_oem
from .orbits.spk import spice_orbit
from .orbits.tle import omm_orbit, tle_orbit
from .scenario import Scenario, read_scenario

__all__ = [
    "AttitudeFormat",
    "AttitudeTable",
    "DamitSpin",
    "Scenario",
    "load",
    "omm_orbit",
    "read_aem",
    "read_alcdef",
    "read_apm",
    "read_ck",
    "read_damit",
    "read_damit_spin",
    "read_field",
    "read_gyro_csv",
    "read_mesh",
    "read_oem",
    "read_quaternion_csv",
    "read_readings",
    "read_readings_csv",
    "read_scenario",
    "read_stk_attitude",
    "save",
    "spice_attitude",
    "spice_orbit",
    "tle_orbit",
    "write_aem",
    "write_alcdef",
    "write_apm",
    "write_ck",
    "write_damit",
    "write_damit_shape",
    "write_damit_spin",
    "write_quaternion_csv",
    "write_readings",
    "write_readings_csv",
    "write_stk_attitude",
]
