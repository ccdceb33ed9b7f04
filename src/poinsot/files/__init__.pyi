"""The public names of poinsot.files, by the module of each, as `make face` writes them."""

from .attitudes.aem import read_aem, write_aem
from .attitudes.apm import read_apm, write_apm
from .attitudes.attitude_format import AttitudeFormat
from .attitudes.attitude_table import AttitudeTable, stated_calendar
from .attitudes.ck import read_ck, spice_attitude, write_ck
from .attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from .attitudes.stk import read_stk_attitude, write_stk_attitude
from .bodies.fields import read_field
from .bodies.meshes import read_mesh, write_damit_shape
from .netcdf import READINGS, ReadingsFoundError, load, read_dataset, save, write_dataset
from .observations.alcdef import read_alcdef, write_alcdef
from .observations.julian_rows import JulianRows, calendar_before, check_not_falling, iso_text, julian_date
from .observations.readings_csv import read_readings_csv, write_readings_csv
from .observations.readings_netcdf import read_readings, write_readings
from .orbits.oem import read_oem
from .orbits.spk import spice_orbit
from .orbits.tle import omm_orbit, tle_orbit
from .scenario import Scenario, read_scenario

__all__ = [  # noqa: RUF022
    "AttitudeFormat",
    "AttitudeTable",
    "ReadingsFoundError",
    "JulianRows",
    "READINGS",
    "Scenario",
    "calendar_before",
    "check_not_falling",
    "iso_text",
    "julian_date",
    "load",
    "omm_orbit",
    "read_aem",
    "read_alcdef",
    "read_apm",
    "read_ck",
    "read_dataset",
    "read_field",
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
    "stated_calendar",
    "tle_orbit",
    "write_aem",
    "write_alcdef",
    "write_apm",
    "write_ck",
    "write_damit_shape",
    "write_dataset",
    "write_quaternion_csv",
    "write_readings",
    "write_readings_csv",
    "write_stk_attitude",
]
