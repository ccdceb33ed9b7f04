"""Systems with each force, orbit and part, and with formulas at their limits."""

import numpy as np

import poinsot as pt
from kinds.forces import FORCES, label
from kinds.orbits import ORBITS
from kinds.parts import BODY as LARGE
from kinds.parts import PARTS
from poinsot.functions import Vector, norm
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.kernel_parameters import formulas_of
from poinsot.integration.problem import Problem
from poinsot.orbits.ephemeris import Ephemeris

BODY = pt.Body((1.3, 1.0, 0.7))
START = {"quaternion": (0.1, 0.7, -0.5, 0.5), "omega_body": (0.4, -0.3, 0.6)}


class Growth(pt.Torque):
    """A torque that multiplies the momentum by e in each unit of time over `rate`."""

    rate: float

    def torque(self, instant):
        return self.rate * instant.angular_momentum_body


class Drag(pt.Torque):
    """A torque whose formula has the root of what is zero at rest."""

    strength: float

    def torque(self, instant):
        return -self.strength * norm(instant.omega_body) * instant.omega_body


class Pole(pt.Torque):
    """A torque that is singular at a time."""

    time: float

    def torque(self, instant):
        return Vector((0.1 / (self.time - instant.time), 0.0, 0.0))


class Cancelling(pt.Torque):
    """A torque with factors, a numerator and a divisor whose terms cancel, to zero and to a number."""

    size: float

    def torque(self, instant):
        _, x, y, z = instant.attitude.quaternion
        nothing = (x + y) - y - x
        one = nothing + self.size
        return Vector((nothing * (y + z), nothing / (2.0 + y * y) + x / one, one * z * one))


LONG = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.95, true_anomaly=1.0, inclination=0.4)
TABLE = Ephemeris.from_function(1.0, position=lambda t: np.stack([*LONG.position_at(t)], -1), start=-2.0, stop=4.0)
GRAVITY = pt.UniformGravity(0.7, (0.3, -0.2, 0.5))
SYSTEMS = {
    **{f"force: {label(force)}": (BODY, force) for force in FORCES if not hasattr(force, "limit")},  # no kinks
    **{f"orbit: {name}": (BODY, pt.GravityGradient(orbit)) for name, orbit in ORBITS.items()},
    "table with knots": (BODY, pt.GravityGradient(TABLE)),
    **{f"part: {type(part).__name__}": (LARGE, part) for part in PARTS},
    "no force": (BODY,),
    "forces at rest and moving": (BODY, GRAVITY, *FORCES[1:3]),
    "part and forces": (LARGE, PARTS[1], GRAVITY, FORCES[1]),
    "long ellipse in comoving axes": (BODY, pt.GravityGradient(LONG)),
    "long ellipse in space axes": (BODY, pt.GravityGradient(LONG), GRAVITY),
    "needle": (pt.Body((1.0, 1.0, 1e-8)), GRAVITY),
    "spin-up": (BODY, Growth(1.6)),
    "spin-down": (BODY, Growth(-8.0)),
    "terms that cancel": (BODY, Cancelling(0.3)),
    "drag": (BODY, Drag(0.02), GRAVITY),
}


def start_of(system, omega=START["omega_body"], time=0.0):
    return system.state(START["quaternion"], omega_body=omega, time=time)


def switches(system):
    """Whether a formula has a condition on what varies."""
    problem = Problem(system)
    variables = equations.state_vector(problem, start_of(system), FORMULATIONS["lie_poisson"], "double")
    return formulas_of(problem.between_knots(), variables).constants.switches
