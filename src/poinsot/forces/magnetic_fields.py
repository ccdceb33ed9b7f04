"""Magnetic fields that rotate with their planet."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.solid_harmonics import SolidHarmonics, exterior_field
from poinsot.errors import optional, real_numbers
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Dated, Orbit
from poinsot.mechanics.gravity_field import norms
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.periapsis_warning import warn_below
from poinsot.mechanics.planet_axes import PlanetAxes
from poinsot.quantities import Array, Real, Time
from poinsot.records.calendar import Calendar
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Positive, Table, listed
from poinsot.taylor.graph import Graph, number, tangents

__all__ = ["IGRF", "MagneticField", "MagneticHarmonics", "SecularHarmonics", "TiltedDipole"]


class MagneticField(Dated, ABC):
    """Magnetic field of a planet along the orbit of the body; base class of the models.

    A subclass defines `at`, the field along the axes of the planet.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the planet.
    rotation : RotationModel
        Orientation of the planet's axes.

    Examples
    --------
    >>> class Uniform(pt.forces.MagneticField):
    ...     size: float
    ...     def at(self, position, time):
    ...         return pt.functions.Vector((self.size, 0.0, 0.0))
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(2, 0, 0))
    >>> field = Uniform(orbit, pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.1), 3e-5)
    >>> [round(1e9 * float(x)) for x in field.in_space(orbit.position_at(0.0), 0.0)]  # nT
    [0, 30000, 0]
    """

    orbit: Orbit
    rotation: PlanetAxes

    @of_scalars
    @abstractmethod
    def at(self, position: Vector, time: Scalar) -> Vector:
        """Return the field, tesla, at a position relative to the planet's centre, both along the axes of the planet."""

    @of_scalars
    def in_space(self, position: Vector, time: Scalar) -> Vector:
        """Return the field, tesla, at a position relative to the planet's centre, both along the space axes."""
        return self.rotation.to_space(self.at(self.rotation.to_planet(position, time), time), time)

    @of_scalars
    def in_body(self, instant: Instant) -> Vector:
        """Return the field at the position of the body, tesla, along the body axes."""
        return instant.attitude.to_body(self.in_space(instant.position(self.orbit), instant.time))

    @of_scalars
    def rate_in_body(self, instant: Instant) -> Vector:
        """Return the rate of change of the field in body axes, as an onboard magnetometer measures it.

        It equals the rate of change along the orbit, expressed in body axes, minus omega x B.
        """
        graph, velocity = Graph(), instant.velocity(self.orbit)
        time = graph.variable(instant.time)
        position = Vector(map(graph.variable, instant.position(self.orbit)))
        seeds = {time: 1.0, **dict(zip(position, velocity, strict=True))}
        along_orbit = graph.finished(tangents(list(self.in_space(position, time)), seeds))
        turning = functions.cross(instant.omega_body, self.in_body(instant))
        return Vector(instant.attitude.to_body(along_orbit) - turning)

    @of_scalars
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return, by name, conditions that hold where the field is used outside its range of validity."""
        return {}

    @property
    @override
    def reference_frame(self) -> str:
        return self.rotation.reference_frame


class _OfSources(MagneticField):
    """Field with sources inside a sphere; a subclass declares its `radius`."""

    if TYPE_CHECKING:

        @property
        def radius(self) -> Any:
            """Radius of a sphere that contains the sources, in the length unit of the orbit."""

    def __post_init__(self) -> None:
        super().__post_init__()
        consequence = "the field outside the planet is continued inwards"
        warn_below(self, self.orbit, self.radius, "the reference radius", consequence)

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        return {"below_reference_radius": functions.less(1, self.radius * instant.inverse_distance(self.orbit))}


class TiltedDipole(_OfSources):
    """Magnetic field of a dipole at the centre of a planet: harmonics of degree 1.

    B = (R/r)^3 (3 u (u.d) - d), with d = (g11, h11, g10) along the axes of the planet and u the unit vector to the
    body.

    Parameters
    ----------
    g10, g11, h11 : float
        Coefficients in tesla: -29350e-9, -1410.3e-9 and 4545.5e-9 for the Earth in 2025 (IGRF-14).
    radius : float
        Reference radius R of the coefficients, in the unit of length of the orbit: 6371.2 km for the Earth.

    Raises
    ------
    ValueError
        If the radius is not positive.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=6871.2, eccentricity=0.0)  # km, s
    >>> earth = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.292115e-5)
    >>> field = pt.forces.TiltedDipole(orbit, earth, -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2)
    >>> [round(1e9 * float(x)) for x in field.in_space(orbit.position_at(0.0), 0.0)]  # nT
    [-7247, 1124, 23398]
    """

    g10: Real
    g11: Real
    h11: Real
    radius: Positive

    @override
    def at(self, position: Vector, time: Scalar) -> Vector:
        return self._around(Vector((self.g11, self.h11, self.g10)), position)

    @override
    def in_space(self, position: Vector, time: Scalar) -> Vector:
        return self._around(self.rotation.to_space((self.g11, self.h11, self.g10), time), position)

    def _around(self, dipole: Vector, position: Vector) -> Vector:
        """Return the field of a dipole at a position, both along the same axes as the result."""
        inverse = 1 / functions.norm(position)
        size, direction = self.radius * inverse, Vector(position) * inverse
        return Vector((direction * (3 * functions.dot(direction, dipole)) - dipole) * (size * size * size))


class MagneticHarmonics(_OfSources):
    """Magnetic field of a planet in spherical harmonics with Schmidt semi-normalised Legendre functions.

    B = -grad V, V = R sum_n (R/r)^(n+1) sum_m P_nm(sin latitude) (g_nm cos(m longitude) + h_nm sin(m longitude)). P_nm
    does not include the phase (-1)^m. The IGRF and models of other planets use this convention.

    Parameters
    ----------
    degree : int
        Highest degree of the harmonics, at least 1.
    radius : float
        Reference radius R of the coefficients, in the unit of length of the orbit.
    g, h : array (degree + 1, degree + 1)
        Coefficients in tesla. Rows are degrees n, columns are orders m. Row 0, h_n0 and the elements right of the
        diagonal are ignored.

    Raises
    ------
    ValueError
        If the degree is below 1 or the radius is not positive.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(2, 0, 0))
    >>> axes = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.1)
    >>> field = pt.forces.MagneticHarmonics(orbit, axes, 1, 1.0, [(0, 0), (3e-5, 1e-5)], np.zeros((2, 2)))
    >>> [round(1e9 * float(x)) for x in field.at((2.0, 0.0, 0.0), 0.0)]  # nT
    [2500, 0, -3750]
    """

    degree: int
    radius: Positive
    g: Annotated[Any, ("orders", "orders")]
    h: Annotated[Any, ("orders", "orders")]

    def __post_init__(self) -> None:
        _check_degree(self.degree)
        super().__post_init__()

    @property
    def orders(self) -> int:
        """Number of orders, degree + 1."""
        return self.degree + 1

    @override
    def at(self, position: Vector, time: Scalar) -> Vector:
        return self._sums(self._inverted(position), self.g, self.h)

    def _inverted(self, position: Vector) -> SolidHarmonics:
        """Return solid harmonics of R x / r^2: exterior ones are these times R / r."""
        inverse = self.radius / functions.dot(position, position)
        return SolidHarmonics(Vector(position) * inverse, squared=self.radius * inverse)

    def _sums(self, harmonics: SolidHarmonics, g: Any, h: Any) -> Vector:
        factors, total = _schmidt(self.degree), Vector((0.0, 0.0, 0.0))
        for n in range(1, self.degree + 1):
            row = [(factors[n, m] * g[n, m], factors[n, m] * h[n, m] if m else 0.0) for m in range(n + 1)]
            total = total + Vector(harmonics.sum(exterior_field(row, k)) for k in range(3))
        return Vector(total * functions.sqrt(harmonics.squared))


class SecularHarmonics(MagneticHarmonics):
    """Magnetic field in spherical harmonics with secular variation: coefficients linear in time.

    Parameters
    ----------
    radius : float
        Reference radius of the coefficients, in the unit of length of the orbit.
    g, h : array (degree + 1, degree + 1)
        Coefficients at the epoch in tesla, as in `MagneticHarmonics`.
    g_rate, h_rate : array (degree + 1, degree + 1)
        Rates of change of the coefficients, in tesla per unit of time.
    epoch : float
        Time to which `g` and `h` refer.

    Raises
    ------
    ValueError
        If the degree is below 1 or the radius is not positive.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(2, 0, 0))
    >>> axes, none = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.1), np.zeros((2, 2))
    >>> g, g_rate = [(0, 0), (3e-5, 0)], [(0, 0), (1e-6, 0)]
    >>> field = pt.forces.SecularHarmonics(orbit, axes, 1, 1.0, g, none, g_rate, none, epoch=0.0)
    >>> round(1e9 * float(field.at((2.0, 0.0, 0.0), 10.0)[2]))  # nT
    -5000
    """

    g_rate: Annotated[Any, ("orders", "orders")]
    h_rate: Annotated[Any, ("orders", "orders")]
    epoch: Time

    @override
    def at(self, position: Vector, time: Scalar) -> Vector:
        harmonics = self._inverted(position)
        change = self._sums(harmonics, self.g_rate, self.h_rate) * (time - self.epoch)
        return Vector(self._sums(harmonics, self.g, self.h) + change)


class _Epochs(Table):
    """The coefficients of the IGRF, tesla, at its epochs, which are times of a calendar."""

    title = "IGRF"

    def __init__(self, calendar: Calendar) -> None:
        years, g, h = _coefficients()
        self.knots = np.array([calendar.time(f"{year}-01-01T00:00:00 TT") for year in years.tolist()])
        self.calendar, self.values = calendar, np.stack([g, h])
        self.rates = np.diff(self.values, axis=1) / np.diff(self.knots)[:, None, None]


@functools.lru_cache(16)
def _epochs(calendar: Calendar) -> _Epochs:
    return _Epochs(calendar)


@functools.cache
def _coefficients() -> tuple[NDArray[np.int_], Array, Array]:
    """Return the years and the coefficients, shape (years, 14, 14), that the package ppigrf has."""
    frames = optional("ppigrf.ppigrf", "the coefficients of the IGRF").read_shc()
    years = np.array([date.year for date in frames[0].index])
    out = np.zeros((2, years.size, IGRF_DEGREE + 1, IGRF_DEGREE + 1))
    for array, frame in zip(out, frames, strict=True):
        for n, m in frame.columns:
            array[:, n, m] = 1e-9 * frame[n, m].to_numpy(dtype=float)
    return years, *out


IGRF_DEGREE = 13
"""Degree of the IGRF."""

MAX_RADII = 50
"""Largest distance in planetary radii, far outside the magnetosphere. A larger one indicates inconsistent units."""


class IGRF(_OfSources):
    """International Geomagnetic Reference Field (IGRF-14), 1900 to 2030, with coefficients linear between epochs.

    `MagneticHarmonics` defines the field, with coefficients from the package ppigrf, `pip install 'poinsot[sky]'`
    (Alken et al. 2021, Earth, Planets and Space 73, 49). The integration stops at each epoch, every five years.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the Earth. The orbit or the rotation defines the calendar.
    rotation : RotationModel
        Orientation of the Earth's axes.
    degree : int
        Highest degree of the harmonics, from 1 to 13.
    radius : float
        Reference radius 6371.2 km, in the unit of length of the orbit.

    Raises
    ------
    ValueError
        If the degree is out of range, the orbit is beyond 50 radii, neither rotation nor orbit defines a calendar, or a
        time is before 1900 or after 2030.
    ImportError
        If ppigrf is missing.

    Examples
    --------
    >>> orbit, earth = pt.orbits.FixedPosition(1.0, position=(7000, 0, 0)), pt.orbits.RotationModel.iau("earth")
    >>> pt.forces.IGRF(orbit, earth, degree=14)
    Traceback (most recent call last):
    ValueError: degree must be from 1 to 13, got 14.
    """

    degree: int
    epochs: _Epochs = field(init=False)
    radius: Positive = 6371.2

    def __post_init__(self) -> None:
        _check_degree(self.degree, IGRF_DEGREE)
        found = [each.calendar for each in (self.rotation, self.orbit) if getattr(each, "calendar", None) is not None]
        if not found:
            raise ValueError("rotation must have a calendar for a field of dates, got none. RotationModel.earth has.")
        object.__setattr__(self, "epochs", _epochs(found[0]))
        super().__post_init__()
        farthest = np.max(getattr(self.orbit, "periapsis_distance", 0.0) / np.asarray(self.radius))
        if farthest > MAX_RADII:
            hint = "The radius is 6371.2 km in the unit of the orbit."
            raise ValueError(f"orbit must be within {MAX_RADII} radii of the Earth, got {farthest:.6g}. {hint}")

    @override
    def __repr__(self) -> str:
        name, fields = self.definition
        return f"{name}({', '.join(f'{key}={listed(value)}' for key, value in fields.items())})"

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        name, fields = super().definition
        return name, {key: value for key, value in fields.items() if key != "epochs"}

    @property
    @override
    def span(self) -> tuple[float, float]:
        return self.epochs.span

    @property
    @override
    def calendar(self) -> Any:
        return self.epochs.calendar

    @property
    def knots(self) -> Array:
        """Times of the epochs."""
        return self.epochs.knots

    @override
    def between_knots(self, time: ArrayLike) -> SecularHarmonics:  # type: ignore[override]
        return self._piece(self.epochs.pieces_around(time), time)

    def _piece(self, piece: NDArray[np.int_], time: ArrayLike) -> SecularHarmonics:
        table, degrees = self.epochs, slice(self.degree + 1)
        (g, h), (g_rate, h_rate) = (array[:, piece, degrees, degrees] for array in (table.values, table.rates))
        return SecularHarmonics.unchecked(
            orbit=self.orbit.between_knots(time),
            rotation=self.rotation,
            radius=self.radius,
            degree=self.degree,
            g=g,
            h=h,
            g_rate=g_rate,
            h_rate=h_rate,
            epoch=table.knots[piece],
        )

    @override
    def at(self, position: Vector, time: Scalar) -> Vector:
        known = real_numbers("time", number(time))
        here = self._piece(self.epochs.pieces_at(known), known)
        return here.with_numbers(here.numbers).at(position, time)


def _check_degree(degree: Any, highest: int | None = None) -> None:
    """Raise a ValueError for a degree out of range."""
    if isinstance(degree, int) and (degree < 1 or (highest and degree > highest)):
        words = f"from 1 to {highest}" if highest else "at least 1"
        raise ValueError(f"degree must be {words}, got {degree}.")


@functools.cache
def _schmidt(degree: int) -> Array:
    """Return the factors from Schmidt coefficients to coefficients without normalisation."""
    plain: Array = norms(degree) / np.sqrt(2 * np.arange(degree + 1) + 1)[:, None]
    return plain
