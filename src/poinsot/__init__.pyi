"""The public names, by the module of each; imported when they are used first."""

from . import (
    analysis,
    control,
    estimation,
    events,
    files,
    forces,
    functions,
    mechanics,
    observables,
    orbits,
    parts,
    plot,
    shapes,
)
from .errors import PropagationError, PropagationInterrupted
from .files.netcdf import load, save
from .forces.gravity import GravityGradient, UniformGravity
from .kinematics.andoyer import Andoyer
from .kinematics.attitude import Attitude
from .kinematics.frame import RotatingFrame
from .kinematics.state import PairState, State
from .mechanics.body import Body
from .mechanics.environment import Orbit
from .mechanics.event import Event
from .mechanics.force import Potential, Torque
from .mechanics.gravity_field import GravityField
from .mechanics.instant import Instant
from .mechanics.observable import Observable
from .mechanics.part import Part
from .mechanics.two_bodies import TwoBodies
from .orbits.kepler import KeplerOrbit
from .plot.animation import animate
from .plot.view import view
from .propagation.event_record import EventRecord
from .propagation.free_motion.motion import free_motion
from .propagation.observe import observe
from .propagation.propagate import propagate
from .propagation.trajectory import Trajectory
from .quantities import BodyVector, SpaceVector
from .records.calendar import Calendar
from .systems.system import System

__all__ = [
    "Andoyer",
    "Attitude",
    "Body",
    "BodyVector",
    "Calendar",
    "Event",
    "EventRecord",
    "GravityField",
    "GravityGradient",
    "Instant",
    "KeplerOrbit",
    "Observable",
    "Orbit",
    "PairState",
    "Part",
    "Potential",
    "PropagationError",
    "PropagationInterrupted",
    "RotatingFrame",
    "SpaceVector",
    "State",
    "System",
    "Torque",
    "Trajectory",
    "TwoBodies",
    "UniformGravity",
    "analysis",
    "animate",
    "control",
    "estimation",
    "events",
    "files",
    "forces",
    "free_motion",
    "functions",
    "load",
    "mechanics",
    "observables",
    "observe",
    "orbits",
    "parts",
    "plot",
    "propagate",
    "save",
    "shapes",
    "view",
]

__version__: str
