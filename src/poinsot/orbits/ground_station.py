"""Observers on the surface of a rotating planet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY
from functools import partial
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_outside
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED, Orbit, frames_of
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.mechanics.planet_axes import PlanetAxes
from poinsot.orbits.conic import shown
from poinsot.printable import quoted
from poinsot.quantities import Angle, Real, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Positive, QuarterTurn
from poinsot.taylor.graph import Graph, tangents

__all__ = ["GroundStation"]

EQUATORIAL_RADIUS, FLATTENING = 6_378_137.0, 1 / 298.257223563
"""Ellipsoid WGS 84, metres."""

MIN_SQUARED_RATE = 1e-9
"""Limit of mu / R^3 of the Earth, 1.5e-6 per square second, below which mu and R have different units of length."""


Flattening = Annotated[
    Real, Rule(partial(refuse_outside, 0.0, 0.99, "from 0 to 0.99"), "The Earth's is 1 / 298.257223563.")
]


class GroundStation(Orbit):
    """Position of the body relative to a station on the surface of a rotating planet.

    The station is at geodetic coordinates of an ellipsoid of revolution. It observes bodies whose elevation above the
    plane perpendicular to the ellipsoid's normal is at least a minimum. The model ignores refraction.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body relative to the centre of the planet.
    rotation : PlanetAxes
        Orientation of the planet, such as `RotationModel.earth()`.
    latitude, longitude : float
        Geodetic latitude and longitude, positive to the east, radians.
    height : float
        Height above the ellipsoid, in the unit of length of the orbit.
    minimum_elevation : float
        Elevation below which observables have no reading, radians. Default: 0, the horizon; -pi/2: no limit.
    equatorial_radius : float
        Equatorial radius of the ellipsoid. Default: 6378137 metres (WGS 84); other units require another value.
    flattening : float
        Flattening of the ellipsoid. Default: 1 / 298.257223563 (WGS 84).

    Raises
    ------
    ValueError
        If an angle is outside its range, or the orbit and the rotation have different space axes or calendars.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(3.986e14, position=(4.2164e7, 0, 0))  # m, s
    >>> earth = pt.orbits.RotationModel(0, np.pi / 2, -np.pi / 2, rate=7.292115e-5)
    >>> station = pt.orbits.GroundStation(orbit, earth, latitude=np.radians(48.0), longitude=0.0)
    >>> round(float(np.degrees(station.elevation_at(0.0))), 2)
    34.9
    """

    orbit: Orbit
    rotation: PlanetAxes
    _: KW_ONLY
    latitude: QuarterTurn
    longitude: Angle
    height: Real = 0.0
    minimum_elevation: QuarterTurn = 0.0
    equatorial_radius: Positive = EQUATORIAL_RADIUS
    flattening: Flattening = FLATTENING

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, values in (
            ("reference frame", frames_of((self.orbit.reference_frame, self.rotation.reference_frame))),
            ("calendar", list(dict.fromkeys(x.calendar for x in (self.orbit, self.rotation) if x.calendar))),
        ):
            if len(values) > 1:
                raise ValueError(
                    f"orbit and rotation must have one {name}, got {' and '.join(quoted(str(x)) for x in values)}."
                )
        radius, mu = (np.asarray(x, dtype=float) for x in (self.equatorial_radius, self.orbit.mu))
        if self.orbit.origin == "EARTH" and np.any(mu < MIN_SQUARED_RATE * radius**3):
            raise ValueError(
                f"equatorial_radius must be in the unit of length of the orbit, got {radius.max():.10g} for "
                f"mu = {mu.min():.10g}. It is 6378.137 for an orbit in km."
            )
        warn_below(self, self.orbit, self.equatorial_radius, "the surface", "give lengths in one unit")

    mu = shown("orbit.mu", "Gravitational parameter of the planet.")
    span = shown("orbit.span", "First and last time of the orbit.")
    closed_form = shown("orbit.closed_form", "True if the formulas accept symbols.")
    sample_time = shown("orbit.sample_time", "Time of a trial of formulas.")
    sample_reach = shown("orbit.sample_reach", "Interval around the time in which formulas may be evaluated.")

    @property
    @override
    def reference_frame(self) -> str:
        named = frames_of((self.orbit.reference_frame, self.rotation.reference_frame))
        return named[0] if named else SPACE_AXES_UNNAMED

    @property
    @override
    def calendar(self) -> Any:
        return self.orbit.calendar or self.rotation.calendar

    @property
    @override
    def origin(self) -> str:
        return "ground station"

    @of_scalars
    def zenith(self) -> Vector:
        """Return the normal of the ellipsoid at the station, along the axes of the planet."""
        (c, s), (cl, sl) = ((functions.cos(x), functions.sin(x)) for x in (self.latitude, self.longitude))
        return Vector((c * cl, c * sl, s))

    @of_scalars
    def place(self) -> Vector:
        """Return the position of the station relative to the centre of the planet, along the axes of the planet."""
        x, y, z = self.zenith()
        polar = (1 - self.flattening) * (1 - self.flattening)
        normal = self.equatorial_radius / functions.sqrt(1 - (1 - polar) * z * z)
        return Vector(((normal + self.height) * x, (normal + self.height) * y, (polar * normal + self.height) * z))

    @override
    def position_at(self, time: Scalar) -> Vector:
        return Vector(self.orbit.position_at(time)) - self.rotation.to_space(self.place(), time)

    @override
    def velocity_at(self, time: Scalar) -> Vector:
        graph = Graph()
        now = graph.variable(time)
        turning = graph.finished(tangents(list(self.rotation.to_space(self.place(), now)), {now: 1.0}))
        return Vector(self.orbit.velocity_at(time)) - Vector(turning)

    def elevation_at(self, time: Scalar) -> Scalar:
        """Return the elevation of the body above the horizon, radians."""
        up, place = self.rotation.to_space(self.zenith(), time), self.position_at(time)
        across = functions.cross(up, place)
        return functions.atan2(functions.dot(up, place), functions.sqrt(functions.dot(across, across)))

    @override
    def hidden_at(self, time: Scalar) -> Mapping[str, Scalar]:
        return {"below the minimum elevation": functions.less(self.elevation_at(time), self.minimum_elevation)}
