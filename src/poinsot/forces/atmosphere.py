"""Atmospheres: density of the air and its rotation with the planet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import KW_ONLY
from typing import Annotated, Any

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Dated, Orbit
from poinsot.mechanics.instant import Instant
from poinsot.quantities import Along, Quantity
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative, Positive

__all__ = ["Atmosphere", "ExponentialAtmosphere"]


class Atmosphere(Dated, ABC):
    """Atmosphere of a planet, given by its density; base class of the models.

    A subclass defines the method `density`. The fields of the subclass are the parameters of the model.

    Parameters
    ----------
    omega_space : array (3,), space axes
        Angular velocity of the rotating atmosphere, in angle per time: (0, 0, 7.2921159e-5) rad/s for the Earth.
        Default: zero, an atmosphere at rest.

    Examples
    --------
    >>> class Thin(pt.forces.Atmosphere):
    ...     scale: float
    ...     def density(self, instant, orbit):
    ...         return self.scale * instant.inverse_distance(orbit) ** 50
    >>> Thin(2.0)
    Thin(omega_space=[0.0, 0.0, 0.0], scale=2.0)
    """

    _: KW_ONLY
    omega_space: Annotated[Any, (3,), Along("space axes"), Quantity("rate")] = (0.0, 0.0, 0.0)

    @of_scalars
    @abstractmethod
    def density(self, instant: Instant, orbit: Orbit) -> Scalar:
        """Return the density at the position of the body, in mass per length^3."""

    @of_scalars
    def relative_velocity(self, instant: Instant, orbit: Orbit) -> Vector:
        """Return the velocity of the body relative to the air, v - omega x r, along the body axes."""
        turning = functions.cross(self.omega_space, instant.position(orbit))
        return instant.attitude.to_body(instant.velocity(orbit) - turning)


class ExponentialAtmosphere(Atmosphere):
    """Atmosphere with exponential density, rho0 exp(-(r - r0) / H).

    Parameters
    ----------
    reference_density : float
        Density rho0 at the reference radius, in mass per length^3; not negative.
    reference_radius : float
        Distance r0 from the centre of the planet, in the unit of length of the orbit.
    scale_height : float
        Scale height H, in the unit of length of the orbit.

    Raises
    ------
    ValueError
        If the density is negative, or a length is not positive.

    Examples
    --------
    >>> earth = pt.forces.ExponentialAtmosphere(3.7e-12, 6.778e6, 5.8e4, omega_space=(0, 0, 7.2921159e-5))  # at 400 km
    >>> orbit = pt.orbits.FixedPosition(3.986004418e14, position=(6.836e6, 0, 0))
    >>> system = pt.System(pt.Body((1, 1, 1)))
    >>> instant = system.at(system.state((1, 0, 0, 0), omega_body=(0, 0, 0)))
    >>> round(float(earth.density(instant, orbit) / 3.7e-12), 4)
    0.3679
    """

    reference_density: NotNegative
    reference_radius: Positive
    scale_height: Positive

    @override
    def density(self, instant: Instant, orbit: Orbit) -> Scalar:
        height = 1 / instant.inverse_distance(orbit) - self.reference_radius
        return self.reference_density * functions.exp(-height / self.scale_height)
