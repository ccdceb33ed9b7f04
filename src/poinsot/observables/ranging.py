"""Ranges and range rates from a station to a point of the body, such as a retroreflector."""

from __future__ import annotations

from dataclasses import KW_ONLY

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.light_time import length_unit
from poinsot.mechanics.observable import Observable
from poinsot.quantities import BodyVector
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative
from poinsot.records.units import DerivedUnits

__all__ = ["Range", "RangeRate"]


class Range(Observable):
    """Distance from a station to a point of the body: |r + R p|.

    r is the position of the body relative to the station, R the rotation body -> space, and p the point, such as a
    retroreflector. The body is read when the light left it.

    Parameters
    ----------
    station : Orbit
        Orbit of the body relative to the station, such as a `GroundStation`.
    position : array (3,), body axes
        Position p of the point relative to the centre of mass, in the unit of length of the orbit.
    light_time : bool
        False if the times of the readings are already times at the body.
    noise : float
        Standard deviation of a reading.

    Examples
    --------
    >>> station = pt.orbits.FixedPosition(1.0, position=(3, 0, 0))
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, np.pi / 2])
    >>> pt.observe(motion, pt.observables.Range(station, (1, 0, 0), light_time=False)).values.round(4)
    array([4.    , 3.1623])
    """

    station: Orbit
    position: BodyVector = (0.0, 0.0, 0.0)
    _: KW_ONLY
    light_time: bool = True
    noise: NotNegative = 0.0

    @of_scalars
    def place(self, instant: Instant) -> Vector:
        """Return the position of the point relative to the station, space axes."""
        return instant.position(self.station) + instant.attitude.to_space(self.position)

    @override
    def reading(self, instant: Instant) -> Scalar:
        return functions.norm(self.place(instant))

    @override
    def unit(self, units: DerivedUnits) -> str:
        return length_unit(units)

    @property
    @override
    def light_path(self) -> Orbit | None:
        return self.station if self.light_time else None


class RangeRate(Range):
    """Rate of change of the distance from a station to a point of the body, by the time at the body.

    The rate is the component of v + R (omega x p) along r + R p, with the symbols of `Range` and the velocity v of the
    body relative to the station.

    Examples
    --------
    >>> station = pt.orbits.FixedPosition(1.0, position=(3, 0, 0))
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, np.pi / 2])
    >>> pt.observe(motion, pt.observables.RangeRate(station, (1, 0, 0), light_time=False)).values.round(4) + 0.0
    array([ 0.    , -0.9487])
    """

    @override
    def reading(self, instant: Instant) -> Scalar:
        place = self.place(instant)
        turning = instant.attitude.to_space(functions.cross(instant.omega_body, self.position))
        return functions.dot(place, instant.velocity(self.station) + turning) / functions.norm(place)

    @override
    def unit(self, units: DerivedUnits) -> str:
        length = length_unit(units)
        return f"{length} {units.per_time}" if length else ""
