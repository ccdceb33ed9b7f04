"""The public names of poinsot.plot, by the module of each, as `make face` writes them."""

from .angles import euler_angles, librations, roll_pitch_yaw
from .comparison import attitude_error, difference, uncertainty
from .ensembles import chaos, histogram, map  # noqa: A004
from .geometry import herpolhode, poinsot_construction, polhode
from .measurements import phase_plane, phased, readings
from .pair_orbit import mutual_orbit
from .plane_of_sky import sky
from .results import branch, section, spectrum, yorp
from .sphere import momentum_sphere
from .time_series import angular_momentum, angular_velocity, distance, drift, part_variables, quaternions, torques

__all__ = [
    "angular_momentum",
    "angular_velocity",
    "attitude_error",
    "branch",
    "chaos",
    "difference",
    "distance",
    "drift",
    "euler_angles",
    "herpolhode",
    "histogram",
    "librations",
    "map",
    "momentum_sphere",
    "mutual_orbit",
    "part_variables",
    "phase_plane",
    "phased",
    "poinsot_construction",
    "polhode",
    "quaternions",
    "readings",
    "roll_pitch_yaw",
    "section",
    "sky",
    "spectrum",
    "torques",
    "uncertainty",
    "yorp",
]
