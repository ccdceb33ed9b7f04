"""Every part that is shipped, two parts of a user, and states in which no variable of a part is zero."""

import numpy as np

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.part import Part
from poinsot.parts import (
    ControlMomentGyro,
    CreepingTide,
    GimballedRotor,
    Gyrostat,
    KaneDamper,
    MomentumWheel,
    MovingMasses,
    ReactionWheel,
    ReactionWheels,
    SloshPendulum,
    SpringMass,
    VaryingInertia,
)

BODY = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
OMEGA = np.array([0.4, -0.9, 0.3])
IDENTITY = (1, 0, 0, 0)


class Boom(Part):
    """A user's part: two tip masses that a motor runs out, a given change of inertia without variables."""

    mass: float
    speed: float

    def inertia(self, own, time):  # noqa: ARG002
        square = self.mass * (1 + self.speed * time) ** 2
        return ((0.0, 0.0, 0.0), (0.0, square, 0.0), (0.0, 0.0, square))


class Gimbal(Part):
    """A user's part: a rotor whose axis a spring holds in the body, its angle a variable."""

    spin: float
    stiffness: float
    variables = {"angle": 1, "momentum": 1}  # noqa: RUF012
    momenta = frozenset({"momentum"})
    moment = 0.3

    def momentum(self, own, time):  # noqa: ARG002
        angle, p = own
        return Vector((self.spin * pt.functions.cos(angle), self.spin * pt.functions.sin(angle), p))

    def spinning_inertia(self, own):  # noqa: ARG002
        return ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, self.moment))

    def internal_energy(self, own, time):  # noqa: ARG002
        angle, p = own
        return p * p / (2 * self.moment) + self.stiffness * angle * angle / 2

    def rates(self, instant, generalised_force):  # noqa: ARG002
        # H = (g - h) . K (g - h) / 2 + internal: angle' = dH/dp, p' = -dH/d angle.
        angle, p = instant.own(self)
        w1, w2, w3 = instant.omega_body
        twist = self.spin * (w2 * pt.functions.cos(angle) - w1 * pt.functions.sin(angle))
        return Vector((p / self.moment - w3, twist - self.stiffness * angle))


AXES = ((0.6, 0, 0.8), (0, 0.6, -0.8), (0.8, -0.6, 0), (0, 1, 0))
PLACES = [(0.3, 0.2, 1), (-0.2, 0.4, -0.5)], [(0.6, -0.3, 1.2), (-0.2, 0.8, -0.5)]
CHANGE = ((0.5, 0.1, 0.2), (0.1, 0.7, -0.1), (0.2, -0.1, 0.4))
PARTS = (
    Gyrostat((0.3, -0.2, 0.5)),
    ReactionWheel((0.6, 0, 0.8), 0.1, 0.02, 0.01),
    KaneDamper(0.4, 0.1),
    SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0, 0.3),
    CreepingTide(0.9, 1.1, 2.5, 0.6),
    MomentumWheel((0.6, 0, 0.8), 0.1, 3.0, 0.05, 0.2, 0.02),
    ReactionWheels(AXES, [0.1, 0.2, 0.3, 0.1], pt.forces.LinearDamping(0.3), 0.8, 20.0, [0.01, 0.02, 0.0, 0.03]),
    ControlMomentGyro((0.6, 0, 0.8), (-0.8, 0, 0.6), 0.7, 0.3),
    GimballedRotor((0.6, 0, 0.8), (-0.8, 0, 0.6), 0.7, 0.3, 0.1, 1.5, 0.2),
    SloshPendulum(1, 10, (0.3, 0.2, 0.4), (0, 0.6, -0.8), (1, 0, 0), 0.5, 1.5, 0.1),
    MovingMasses([1, 0.5], 10, *PLACES, -3.0, 21.0),
    VaryingInertia(CHANGE, -3.0, 21.0),
    Boom(0.2, 0.1),
    Gimbal(0.7, 1.5),
)
FREE_OF_LOSS = (
    Gyrostat((0.3, -0.2, 0.5)),
    ReactionWheel((0.6, 0, 0.8), 0.1),
    KaneDamper(0.4, 0.0),
    SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0),
    GimballedRotor((0.6, 0, 0.8), (-0.8, 0, 0.6), 0.7, 0.3, 0.0, 1.5),
    SloshPendulum(1, 10, (0.3, 0.2, 0.4), (0, 0.6, -0.8), (1, 0, 0), 0.5, 1.5),
    SloshPendulum(1, 10, (0.3, 0.2, 0.4), (0, 0.6, -0.8), (1, 0, 0), 0.5, 1.5, planar=True),
    Gimbal(0.7, 1.5),
)


def started(system, **own):
    """A state in which no variable is zero."""
    at_rest = system.state(IDENTITY, omega_body=OMEGA).own
    moved = {name: values + 0.1 + 0.05 * np.arange(values.shape[-1]) for name, values in at_rest.items()}
    return system.state(IDENTITY, omega_body=OMEGA, **{**moved, **own})
