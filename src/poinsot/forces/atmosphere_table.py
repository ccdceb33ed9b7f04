"""Atmospheres with a density tabulated along an orbit, such as the density of an empirical model."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import optional, real_array, real_numbers, refuse_nonpositive
from poinsot.forces.atmosphere import Atmosphere
from poinsot.functions import Scalar
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.quantities import AngularVelocities, Array, Real, Times
from poinsot.records.calendar import Calendar, leap_second_gone
from poinsot.records.parameters import Table
from poinsot.taylor.graph import number

__all__ = ["TabulatedAtmosphere"]

EQUATOR, FLATTENING = 6_378_137.0, 1 / 298.257223563
"""Equatorial radius in metres and flattening of the Earth's ellipsoid WGS 84."""

MIN_HEIGHT, MAX_HEIGHT = 0.0, 2.0e6
"""Smallest and largest height above the ellipsoid, metres. Other heights indicate positions in another unit."""


class _Piece(Atmosphere):
    """Atmosphere between two rows: the density is the exponential of a polynomial in the time since the first row."""

    terms: int
    start: Real
    coefficients: Annotated[Any, ("terms",)]

    @override
    def density(self, instant: Instant, orbit: Orbit) -> Scalar:
        since, total = instant.time - self.start, self.coefficients[self.terms - 1]
        for n in range(self.terms - 2, -1, -1):
            total = total * since + self.coefficients[n]
        value: Scalar = functions.exp(total)
        return value


class _Rows(Table):
    """The rows of a table, and cubic splines of the logarithm of the density."""

    title = "table of densities"

    def __init__(self, times: Array, densities: Array) -> None:
        from scipy.interpolate import CubicSpline

        self.knots, self.densities = times, densities
        self.coefficients = np.asarray(CubicSpline(times, np.log(densities)).c[::-1].T)


class TabulatedAtmosphere(Atmosphere):
    """Atmosphere with the density tabulated in time along one orbit, built by `TabulatedAtmosphere.from_table`.

    A cubic spline interpolates the logarithm of the density, and the integration stops at each row. A time outside the
    table raises a ValueError.

    Examples
    --------
    >>> times = np.linspace(0, 100, 21)
    >>> air = pt.forces.TabulatedAtmosphere.from_table(times, 1e-12 * (2 + np.cos(times / 20)))
    >>> air.span
    (0.0, 100.0)
    """

    rows: _Rows

    def __repr__(self) -> str:
        first, last = self.span
        return f"TabulatedAtmosphere({len(self.knots)} rows over [{first:.10g}, {last:.10g}])"

    @classmethod
    @checked
    def from_table(
        cls, times: Times, densities: ArrayLike, *, omega_space: AngularVelocities = (0.0, 0.0, 0.0)
    ) -> TabulatedAtmosphere:
        """Return an atmosphere from densities at given times.

        Parameters
        ----------
        times : array (n,)
            Times, strictly increasing; at least two.
        densities : array (n,)
            Densities in mass per length^3, positive.

        Returns
        -------
        TabulatedAtmosphere
            The interpolated atmosphere.

        Raises
        ------
        ValueError
            If the times do not increase, or a density is not positive.
        """
        known = real_array("times", times, (None,))
        values = real_array("densities", densities, known.shape)
        if known.size < 2 or np.any(np.diff(known) <= 0):
            raise ValueError("times must be two or more that rise, got others.")
        refuse_nonpositive("densities", values)
        return cls(_Rows(known, values), omega_space=omega_space)

    @classmethod
    @checked
    def from_msis(
        cls,
        orbit: Orbit,
        times: Times,
        *,
        f107: float = 150.0,
        f107a: float = 150.0,
        ap: float = 4.0,
        omega_space: AngularVelocities = (0.0, 0.0, 7.2921159e-5),
        calendar: Calendar | None = None,
    ) -> TabulatedAtmosphere:
        """Return the Earth's atmosphere along an orbit from NRLMSIS 2.1, in kg/m3; requires the package pymsis.

        The third space axis is the axis of the Earth. UT1 is set equal to UTC.

        Parameters
        ----------
        orbit : Orbit
            Orbit of the body about the Earth, in metres.
        times : array (n,)
            Times, strictly increasing. In a low orbit, intervals of one minute are sufficient.
        f107, f107a : float
            Solar flux at 10.7 cm of the previous day, and its mean over 81 days, in 1e-22 W/m2/Hz.
        ap : float
            Daily geomagnetic index.
        omega_space : array (3,), space axes
            Angular velocity of the rotating atmosphere. Default: the rotation of the Earth, in rad/s.
        calendar : Calendar
            Dates of the times. Default: the calendar of the orbit.

        Returns
        -------
        TabulatedAtmosphere
            The interpolated atmosphere.

        Raises
        ------
        ValueError
            If there is no calendar, or an altitude is outside 0 to 2000 km with positions in metres.
        ImportError
            If pymsis is missing.
        """
        known = real_array("times", times, (None,))
        dated = calendar or orbit.calendar
        if dated is None:
            raise ValueError("calendar must be given for an orbit without a calendar, got none.")
        model = optional("pymsis", "densities of NRLMSIS")
        dates = dated.date(known).utc
        longitudes, latitudes, heights = _geodetic(np.stack(np.broadcast_arrays(*orbit.position_at(known)), -1), dates)
        indices = np.full((known.size, 7), float(ap))
        fluxes = (np.full(known.size, float(each)) for each in (f107, f107a))
        found = model.calculate(dates.datetime64, longitudes, latitudes, heights / 1000, *fluxes, indices)
        return cls.from_table(known, np.asarray(found, dtype=float)[:, 0], omega_space=omega_space)

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        fields = {"times": self.rows.knots, "densities": self.rows.densities, "omega_space": self.omega_space}
        return "TabulatedAtmosphere.from_table", fields

    @property
    def knots(self) -> Array:
        """Times of the rows."""
        return self.rows.knots

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the table."""
        return self.rows.span

    def between_knots(self, time: ArrayLike) -> _Piece:  # type: ignore[override]
        """Return the atmosphere between the rows around a time, or, for an array of times, around each time."""
        return self._piece(self.rows.pieces_around(time))

    def _piece(self, i: NDArray[np.int_]) -> _Piece:
        coefficients = self.rows.coefficients[i]
        own = {"omega_space": self.omega_space, "start": self.rows.knots[i], "coefficients": coefficients}
        return _Piece.unchecked(**own, terms=coefficients.shape[-1])

    @override
    def density(self, instant: Instant, orbit: Orbit) -> Scalar:
        """Return the density at the time of the instant, or raise a ValueError for a time outside the table."""
        known = real_numbers("time", number(instant.time))
        piece = self._piece(self.rows.pieces_at(known))
        powers = (known - piece.start)[..., None] ** np.arange(piece.terms)
        value: Scalar = np.exp(np.sum(piece.coefficients * powers, axis=-1))
        return value


def _geodetic(positions: Array, dates: Any) -> tuple[Array, Array, Array]:
    """Return longitudes, latitudes in degrees and heights in metres, from positions along the space axes."""
    days = (dates.jd1 - 2451545.0) + dates.jd2 + leap_second_gone(dates)
    turn = 2 * np.pi * (0.7790572732640 + 0.00273781191135448 * days + np.mod(days, 1.0))  # IERS Conventions, (5.15)
    x, y, z = positions.T
    across = np.hypot(x, y)
    square = FLATTENING * (2 - FLATTENING)
    latitude = np.arctan2(z, across * (1 - square))
    for _ in range(5):  # each round leaves a part of the square of the eccentricity
        normal = EQUATOR / np.sqrt(1 - square * np.sin(latitude) ** 2)
        latitude = np.arctan2(z + square * normal * np.sin(latitude), across)
    normal = EQUATOR / np.sqrt(1 - square * np.sin(latitude) ** 2)
    heights = across * np.cos(latitude) + z * np.sin(latitude) - EQUATOR**2 / normal
    wrong = heights[(heights < MIN_HEIGHT) | (heights > MAX_HEIGHT)]
    if wrong.size:
        raise ValueError(
            f"orbit must be 0 to 2000 km above the Earth, in metres, got a height of {wrong[0] / 1000:.4g} km."
        )
    return np.degrees(np.mod(np.arctan2(y, x) - turn, 2 * np.pi)), np.degrees(latitude), heights
