"""Rotation of rigid bodies: `propagate(System(body, *forces), state, times) -> Trajectory`."""

from poinsot import functions
from poinsot.analysis.chaos import ChaosIndicators, LyapunovSpectrum, chaos_indicators, lyapunov_spectrum
from poinsot.analysis.continuation import Bifurcation, Branch, continue_motion
from poinsot.analysis.equilibria import Equilibrium, equilibria
from poinsot.analysis.free_rotation import FreeRotation
from poinsot.analysis.frequencies import LineSpectrum, diffusion, frequencies
from poinsot.analysis.periodic import CassiniState, PeriodicMotion, cassini_state, periodic_motion
from poinsot.analysis.sections import Section, andoyer_section, section, spin_orbit_section
from poinsot.analysis.state_transition import StateTransition, state_transition
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.files.attitudes.aem import read_aem, write_aem
from poinsot.files.attitudes.apm import read_apm, write_apm
from poinsot.files.attitudes.attitude_table import AttitudeTable
from poinsot.files.attitudes.ck import spice_attitude, write_ck
from poinsot.files.attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from poinsot.files.attitudes.stk import read_stk_attitude, write_stk_attitude
from poinsot.files.bodies.fields import read_field
from poinsot.files.bodies.meshes import read_mesh
from poinsot.files.netcdf import load, save
from poinsot.files.orbits.oem import read_oem
from poinsot.files.orbits.spk import spice_orbit
from poinsot.files.orbits.tle import omm_orbit, tle_orbit
from poinsot.files.scenarios.scenario import Scenario, read_scenario
from poinsot.forces.damping import LinearDamping
from poinsot.forces.ellipsoid import EllipsoidGravity
from poinsot.forces.gravity import GravityGradient, HarmonicGravity, Oblateness, UniformGravity
from poinsot.forces.mascons import MasconGravity
from poinsot.mechanics.andoyer import Andoyer
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import Calendar
from poinsot.mechanics.crossings import (
    AndoyerCrossing,
    Apsis,
    AttractorCrossing,
    AxisCrossing,
    Instant,
    RateCrossing,
    SpinFlip,
)
from poinsot.mechanics.event import Event
from poinsot.mechanics.force import Potential, Torque
from poinsot.mechanics.frame import Frame, RotatingFrame
from poinsot.mechanics.gravity_field import GravityField
from poinsot.mechanics.parameters import Vector
from poinsot.mechanics.sky import Orbit, Sky
from poinsot.mechanics.state import State, project_to_tangent
from poinsot.mechanics.system import System
from poinsot.motion.events import Crossings
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
from poinsot.pictures.continuation import plot_branch
from poinsot.pictures.geometry import plot_herpolhode, plot_poinsot, plot_polhode
from poinsot.pictures.histories import (
    plot_angular_momentum,
    plot_difference,
    plot_drift,
    plot_euler_angles,
    plot_quaternions,
    plot_rates,
    plot_roll_pitch_yaw,
)
from poinsot.pictures.maps import plot_chaos, plot_map
from poinsot.pictures.momentum_sphere import plot_momentum_sphere
from poinsot.pictures.sections import plot_section
from poinsot.pictures.spectrum import plot_spectrum
from poinsot.pictures.uncertainty import plot_uncertainty
from poinsot.pictures.view import view
from poinsot.shapes.assembly import Assembly
from poinsot.shapes.mascons import Mascons
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.shape import Shape
from poinsot.shapes.solids import Cylinder, Ellipsoid

__version__ = "0.1.0"

__all__ = [
    "Andoyer",
    "AndoyerCrossing",
    "Apsis",
    "Assembly",
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
    "Crossings",
    "Cylinder",
    "Ellipsoid",
    "EllipsoidGravity",
    "Ephemeris",
    "Equilibrium",
    "EscapeOrbit",
    "Event",
    "FixedPoint",
    "Frame",
    "FreeRotation",
    "GravityField",
    "GravityGradient",
    "HarmonicGravity",
    "Instant",
    "KeplerOrbit",
    "LagrangePoint",
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
    "RotatingPoint",
    "Scenario",
    "Section",
    "Shape",
    "Sky",
    "SpinFlip",
    "State",
    "StateTransition",
    "System",
    "ThreeBodyOrbit",
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
    "plot_angular_momentum",
    "plot_branch",
    "plot_chaos",
    "plot_difference",
    "plot_drift",
    "plot_euler_angles",
    "plot_herpolhode",
    "plot_map",
    "plot_momentum_sphere",
    "plot_poinsot",
    "plot_polhode",
    "plot_quaternions",
    "plot_rates",
    "plot_roll_pitch_yaw",
    "plot_section",
    "plot_spectrum",
    "plot_uncertainty",
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
