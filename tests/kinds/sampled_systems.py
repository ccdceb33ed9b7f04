"""Systems with laws that are computed at samples and held between them."""

import numpy as np

import poinsot as pt
from poinsot.control import OrbitPointing, QuaternionFeedback, RateDamping, Sampled
from poinsot.functions import Vector
from poinsot.orbits.ephemeris import Ephemeris
from poinsot.parts import ReactionWheels

BODY = pt.Body.from_inertia([(1.3, 0.05, -0.02), (0.05, 1.0, 0.03), (-0.02, 0.03, 0.7)])
ORBIT = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.3, inclination=0.7, node=-0.4, true_anomaly=0.3)
TABLE = Ephemeris.from_function(1.1, position=lambda t: np.stack([*ORBIT.position_at(t)], -1), start=-1.0, stop=5.0)
START = {"attitude": (0.1, 0.7, -0.5, 0.5), "omega_body": (0.4, -0.3, 0.6)}
FEEDBACK = QuaternionFeedback(0.8, 1.1, 0.3, target=(0.6, 0.0, 0.8, 0.0))


class Integrating(pt.Part, pt.Torque):
    """A user's digital controller with a memory: it adds up the rates that it sees."""

    gain: float
    period: float
    variables = {"torque": 3, "sum": 3}  # noqa: RUF012

    @property
    def jump(self):
        return pt.mechanics.Jump(self.period, 0.1)

    def update(self, instant, draws):  # noqa: ARG002
        total = Vector(instant.own(self)[3:]) + self.period * instant.omega_body
        return Vector((*(-self.gain * (instant.omega_body + 0.2 * total)), *total))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return Vector((0.0,) * 6)

    def torque(self, instant):
        return Vector(instant.own(self)[:3])


class Driven(pt.Part):
    """A user's wheel that a law drives: the law is a field, and the torque on the wheel is the opposite of its."""

    law: pt.Torque
    moment: float
    variables = {"momentum": 1}  # noqa: RUF012
    momenta = frozenset({"momentum"})

    def momentum(self, own, time):  # noqa: ARG002
        return Vector((0.0, 0.0, own[0]))

    def spinning_inertia(self, own):  # noqa: ARG002
        return ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, self.moment))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return Vector((-self.law.torque(instant)[2],))


class Growth(pt.Torque):
    """A torque that multiplies the momentum by e in each unit of time over `rate`."""

    rate: float

    def torque(self, instant):
        return self.rate * instant.angular_momentum_body


class Pole(pt.Torque):
    """A torque that is singular at a time."""

    time: float

    def torque(self, instant):
        return Vector((0.1 / (self.time - instant.time), 0.0, 0.0))


SYSTEMS = {
    "feedback": (Sampled(FEEDBACK, 0.3, 0.1),),
    "feedback and gravity": (Sampled(FEEDBACK, 0.3, 0.1), pt.GravityGradient(ORBIT)),
    "pointing in comoving axes": (
        Sampled(OrbitPointing(2.0, 3.0, 0.7, ORBIT), 0.3, 0.1),
        pt.GravityGradient(ORBIT),
    ),
    "pointing along a table, two controllers": (
        Sampled(OrbitPointing(2.0, 3.0, 0.7, TABLE), 0.3, 0.1),
        Sampled(RateDamping(0.2, 5.0), 0.45, name="slow"),
    ),
    "two controllers": (
        Sampled(RateDamping(0.8, 5.0), 0.3, 0.1),
        Sampled(FEEDBACK, 0.45, name="slow"),
    ),
    "a memory": (Integrating(0.9, 0.3),),
    "a wheel with a law": (Driven(Sampled(FEEDBACK, 0.3, 0.1), 0.1),),
    "wheels with a law": (ReactionWheels(np.eye(3), 0.1, Sampled(FEEDBACK, 0.3, 0.1), 0.25, 30.0),),
    "growing momenta": (Sampled(FEEDBACK, 0.3, 0.1), Growth(2.0)),
    "with a continuous law": (Sampled(RateDamping(0.8, 5.0), 0.3, 0.1), FEEDBACK),
}
