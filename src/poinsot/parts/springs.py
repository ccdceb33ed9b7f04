"""Masses on springs: one mode of sloshing or vibration each."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import components
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, mixed_spread, outer, spread
from poinsot.mechanics.part import Part
from poinsot.quantities import BodyVector, Real
from poinsot.records.members import Components, of_arrays
from poinsot.records.parameters import BodyUnitVector, NotNegative, Positive

__all__ = ["AttachedMass", "SpringMass"]


class AttachedMass(Part):
    """Point mass that moves in a body.

    Parameters
    ----------
    mass : float
        Moving mass, positive and less than the total mass.
    total_mass : float
        Total mass of body and moving mass.
    """

    mass: Positive
    total_mass: Real
    moves_center_of_mass: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.asarray(self.mass) >= np.asarray(self.total_mass)):
            raise ValueError(f"mass must be less than total_mass, got {self.mass} and {self.total_mass}.")

    @property
    def reduced_mass(self) -> Scalar:
        """Reduced mass of the moving mass and the rest."""
        return self.mass * (self.total_mass - self.mass) / self.total_mass

    @override
    @abstractmethod
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector: ...


class SpringMass(AttachedMass):
    """Point mass on a line fixed in a free body, with a spring and a dashpot.

    p' = mu ((x . l) omega^2 - (omega . x)(omega . l)) - stiffness rho - damping rho' and rho' = p / mu - omega . d.
    Here rho is the displacement along the line l, x the position of the mass relative to the centre of mass of the
    rest, d = x x l and mu = mass (total_mass - mass) / total_mass the reduced mass. The inertia tensor of body and mass
    depends on rho.

    Parameters
    ----------
    position : array (3,), body axes
        Position of the mass with the spring relaxed, relative to the centre of mass of body and mass. The body's
        inertia tensor includes the mass in this position, about this centre.
    direction : array (3,), body axes
        Unit vector along the line.
    stiffness : float
        Force per displacement, not negative.
    damping : float
        Force per speed, not negative.

    Raises
    ------
    ValueError
        If the mass is not between 0 and the total mass, the direction is not a unit vector, or another number is
        negative.

    Examples
    --------
    >>> spring = pt.parts.SpringMass(0.1, 1.0, position=(1, 0, 0), direction=(0, 1, 0), stiffness=2.0)
    >>> round(float(spring.reduced_mass), 4)
    0.09
    """

    position: BodyVector
    direction: BodyUnitVector
    stiffness: NotNegative
    damping: NotNegative = 0.0
    variables: ClassVar[Mapping[str, int]] = {"displacement": 1, "momentum": 1}

    @property
    def _arm(self) -> functions.Vector:
        """Position of the mass at rest, relative to the centre of mass of the rest."""
        return functions.Vector(components(self.position)) * (self.total_mass / (self.total_mass - self.mass))

    @property
    def _lever(self) -> functions.Vector:
        """Angular momentum of a unit of p, independent of the position of the mass on its line."""
        return functions.cross(self._arm, components(self.direction))

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return functions.Vector(own[1] * component for component in self._lever)

    @override
    def inertia(self, own: functions.Vector, time: Scalar) -> Matrix:
        arm, line, rho = self._arm, functions.Vector(self.direction), own[0]
        linear = mixed_spread(arm, line) * self.reduced_mass * rho
        change: Matrix = linear + spread(line) * self.reduced_mass * (rho * rho)
        return change

    @override
    def spinning_inertia(self, own: functions.Vector) -> Matrix:
        return outer(self._lever, self._lever) * self.reduced_mass

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        rho, p = own
        value: Scalar = p * p / (2 * self.reduced_mass) + self.stiffness / 2 * (rho * rho)
        return value

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        rho, p = instant.own(self)
        omega, line = instant.omega_body, functions.Vector(self.direction)
        x = self._arm + line * rho
        speed = p * (1 / self.reduced_mass) - functions.dot(omega, self._lever)
        outward = functions.dot(x, line) * functions.dot(omega, omega)
        outward = outward - functions.dot(omega, x) * functions.dot(omega, line)
        force = self.reduced_mass * outward - self.stiffness * rho - self.damping * speed
        return functions.Vector((speed, force + generalised_force[0]))

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        return functions.Vector((0.0, self.reduced_mass * functions.dot(omega_body, self._lever)))

    @of_arrays(displacement=(), speed=(), omega_body=(3,))
    def at_displacement(self, displacement: Scalar, speed: Scalar, omega_body: Components) -> Any:
        """Return the variables, shape (..., 2), for a displacement, its rate and the body's angular velocity."""
        momentum = self.reduced_mass * (speed + functions.dot(self._lever, omega_body))
        return functions.Vector((displacement, momentum))

    @of_arrays(own=(2,), omega_body=(3,))
    def speed(self, own: Components, omega_body: Components) -> Any:
        """Return the rate of the displacement, shape (...), from variables and the body's angular velocity."""
        return own[1] / self.reduced_mass - functions.dot(self._lever, omega_body)
