"""The public names of poinsot.plot, by the module of each, as `make face` writes them."""

from .angles import euler_angles, roll_pitch_yaw
from .comparison import attitude_error, difference
from .continuation import branch
from .distribution import histogram
from .frequencies import spectrum
from .geometry import herpolhode, poinsot_construction, polhode
from .libration import librations
from .maps import chaos, map  # noqa: A004
from .mean_torques import yorp
from .pair_orbit import mutual_orbit
from .sections import section
from .sphere import momentum_sphere
from .state_transition import uncertainty
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
    "poinsot_construction",
    "polhode",
    "quaternions",
    "roll_pitch_yaw",
    "section",
    "spectrum",
    "torques",
    "uncertainty",
    "yorp",
]
