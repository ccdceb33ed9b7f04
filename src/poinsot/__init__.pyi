"""The public names, by the module of each; imported when they are used first."""

from . import functions, plot
from .analysis.chaos import ChaosIndicators, LyapunovSpectrum, chaos_indicators, lyapunov_spectrum
from .analysis.continuation import Bifurcation, Branch, continue_motion
from .analysis.equilibria import Equilibrium, equilibria
from .analysis.free_rotation import FreeRotation
from .analysis.frequencies import LineSpectrum, diffusion, frequencies
from .analysis.periodic import CassiniState, PeriodicMotion, cassini_state, periodic_motion
from .analysis.sections import Section, andoyer_section, section, spin_orbit_section
from .analysis.state_transition import StateTransition, state_transition
from .errors import PropagationError, PropagationInterrupted
from .files.attitudes.aem import read_aem, write_aem
from .files.attitudes.apm import read_apm, write_apm
from .files.attitudes.attitude_table import AttitudeTable
from .files.attitudes.ck import spice_attitude, write_ck
from .files.attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from .files.attitudes.stk import read_stk_attitude, write_stk_attitude
from .files.bodies.fields import read_field
from .files.bodies.meshes import read_mesh
from .files.netcdf import load, save
from .files.orbits.oem import read_oem
from .files.orbits.spk import spice_orbit
from .files.orbits.tle import omm_orbit, tle_orbit
from .files.scenarios.scenario import Scenario, read_scenario
from .forces.damping import LinearDamping
from .forces.ellipsoid import EllipsoidGravity
from .forces.gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from .forces.mascons import MasconGravity
from .mechanics.andoyer import Andoyer
from .mechanics.attitude import Attitude
from .mechanics.body import Body
from .mechanics.calendar import Calendar
from .mechanics.environment import Environment, Orbit
from .mechanics.event import Event
from .mechanics.force import Potential, Torque
from .mechanics.frame import Frame, RotatingFrame
from .mechanics.gravity_field import GravityField
from .mechanics.instant import Instant
from .mechanics.parameters import Vector
from .mechanics.standard_events import (
    AndoyerCrossing,
    Apsis,
    AtTime,
    AttractorCrossing,
    AxisCrossing,
    RateCrossing,
    SpinFlip,
)
from .mechanics.state import State, project_to_tangent
from .mechanics.system import System
from .orbits.ephemeris import Ephemeris
from .orbits.escape import EscapeOrbit
from .orbits.fixed import FixedPosition
from .orbits.kepler import KeplerOrbit
from .orbits.lagrange import LagrangePointPath, RotatingPosition
from .orbits.planets import planet_orbit
from .orbits.precessing import PrecessingOrbit
from .orbits.restricted_three_body import ThreeBodyPath
from .orbits.sums import orbit_sum
from .orbits.two_body import two_body_orbit
from .plot.view import view
from .propagation.event_record import EventRecord
from .propagation.free_motion.motion import free_motion
from .propagation.propagate import propagate
from .propagation.trajectory import Trajectory
from .shapes.assembly import Assembly
from .shapes.mascons import Mascons
from .shapes.mesh import Mesh
from .shapes.shape import Shape
from .shapes.solids import Cylinder, Ellipsoid

__all__ = [
    "Andoyer",
    "AndoyerCrossing",
    "Apsis",
    "Assembly",
    "AtTime",
    "Attitude",
    "AttitudeTable",
    "AttractorCrossing",
    "AxisCrossing",
    "Bifurcation",
    "Body",
    "Branch",
    "Calendar",
    "CassiniState",
    "ChaosIndicators",
    "Cylinder",
    "Ellipsoid",
    "EllipsoidGravity",
    "Environment",
    "Ephemeris",
    "Equilibrium",
    "EscapeOrbit",
    "Event",
    "EventRecord",
    "FixedPosition",
    "Frame",
    "FreeRotation",
    "GravityField",
    "GravityGradient",
    "HarmonicGravity",
    "Instant",
    "KeplerOrbit",
    "LagrangePointPath",
    "LineSpectrum",
    "LinearDamping",
    "LyapunovSpectrum",
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
    "RateCrossing",
    "RotatingFrame",
    "RotatingPosition",
    "Scenario",
    "Section",
    "Shape",
    "SpinFlip",
    "State",
    "StateTransition",
    "System",
    "ThreeBodyPath",
    "Torque",
    "Trajectory",
    "UniformGravity",
    "Vector",
    "andoyer_section",
    "cassini_state",
    "chaos_indicators",
    "continue_motion",
    "diffusion",
    "equilibria",
    "free_motion",
    "frequencies",
    "functions",
    "load",
    "lyapunov_spectrum",
    "omm_orbit",
    "orbit_sum",
    "periodic_motion",
    "planet_orbit",
    "plot",
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
    "section",
    "spice_attitude",
    "spice_orbit",
    "spin_orbit_section",
    "state_transition",
    "tle_orbit",
    "two_body_orbit",
    "view",
    "write_aem",
    "write_apm",
    "write_ck",
    "write_quaternion_csv",
    "write_stk_attitude",
]

__version__: str
