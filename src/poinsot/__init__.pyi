"""The public names, by the module of each; imported when they are used first."""

from . import analysis, control, events, files, forces, functions, orbits, parts, plot, shapes
from .errors import PropagationError, PropagationInterrupted
from .files.netcdf import load, save
from .forces.gravity import GravityGradient, UniformGravity
from .mechanics.andoyer import Andoyer
from .mechanics.attitude import Attitude
from .mechanics.body import Body
from .mechanics.calendar import Calendar
from .mechanics.environment import Environment, Orbit
from .mechanics.event import Event
from .mechanics.force import Load, PairLoad, Potential, Torque
from .mechanics.frame import Frame, RotatingFrame
from .mechanics.gravity_field import GravityField
from .mechanics.instant import Instant
from .mechanics.pair_instant import PairInstant
from .mechanics.parameters import Vector
from .mechanics.part import Jump, Part
from .mechanics.state import PairState, State, project_to_tangent
from .mechanics.system import System
from .mechanics.two_bodies import TwoBodies
from .orbits.kepler import KeplerOrbit
from .plot.animation import animate
from .plot.view import view
from .propagation.event_record import EventRecord
from .propagation.free_motion.motion import free_motion
from .propagation.propagate import propagate
from .propagation.trajectory import Trajectory
from .quantities import BodyVector, SpaceVector

__all__ = [
    "Andoyer",
    "Attitude",
    "Body",
    "BodyVector",
    "Calendar",
    "Environment",
    "Event",
    "EventRecord",
    "Frame",
    "GravityField",
    "GravityGradient",
    "Instant",
    "Jump",
    "KeplerOrbit",
    "Load",
    "Orbit",
    "PairInstant",
    "PairLoad",
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
    "Vector",
    "analysis",
    "animate",
    "control",
    "events",
    "files",
    "forces",
    "free_motion",
    "functions",
    "load",
    "orbits",
    "parts",
    "plot",
    "project_to_tangent",
    "propagate",
    "save",
    "shapes",
    "view",
]

__version__: str
