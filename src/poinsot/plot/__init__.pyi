"""The public names of poinsot.plot, by the module of each, as `make face` writes them."""

from .continuation import branch
from .frequencies import spectrum
from .geometry import herpolhode, poinsot_construction, polhode
from .libration import librations
from .maps import chaos, map  # noqa: A004
from .mean_torques import yorp
from .pair_orbit import mutual_orbit
from .sections import section
from .sphere import momentum_sphere
from .state_transition import uncertainty
from .time_series import (
    angular_momentum,
    angular_velocity,
    difference,
    distance,
    drift,
    euler_angles,
    part_variables,
    quaternions,
    roll_pitch_yaw,
    torques,
)

__all__ = [
    "angular_momentum",
    "angular_velocity",
    "branch",
    "chaos",
    "difference",
    "distance",
    "drift",
    "euler_angles",
    "herpolhode",
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
