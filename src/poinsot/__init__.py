"""Rotation of rigid bodies: `propagate(System(body, *forces), state, times) -> Trajectory`."""

from poinsot import functions
from poinsot.analysis.equilibria import Equilibrium, equilibria
from poinsot.analysis.free_rotation import FreeRotation
from poinsot.analysis.periodic import CassiniState, PeriodicMotion, cassini_state, periodic_motion
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.files.netcdf import save
from poinsot.files.oem import read_oem
from poinsot.files.spk import spice_orbit
from poinsot.files.tle import omm_orbit, tle_orbit
from poinsot.forces.damping import LinearDamping
from poinsot.forces.gravity import GravityGradient, OblateGravityGradient, UniformGravity
from poinsot.mechanics.andoyer import Andoyer
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.force import Potential, Torque
from poinsot.mechanics.frame import Frame, RotatingFrame
from poinsot.mechanics.parameters import Vector
from poinsot.mechanics.sky import Orbit, Sky
from poinsot.mechanics.state import State, project_to_tangent
from poinsot.mechanics.system import System
from poinsot.motion.free.motion import free_motion
from poinsot.motion.propagate import propagate
from poinsot.motion.trajectory import Trajectory
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.fixed import FixedPoint
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.orbits.lagrange import LagrangePoint, RotatingPoint
from poinsot.orbits.planets import planet_orbit
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.orbits.restricted import ThreeBodyOrbit
from poinsot.orbits.sums import orbit_sum
from poinsot.orbits.two_body import two_body_orbit
from poinsot.pictures.geometry import plot_herpolhode, plot_poinsot, plot_polhode
from poinsot.pictures.momentum_sphere import plot_momentum_sphere
from poinsot.pictures.quaternions import plot_quaternions

__version__ = "0.1.0"

__all__ = [
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
