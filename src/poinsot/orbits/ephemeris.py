"""Tabulated orbits as piecewise polynomials, at whose knots a kernel stops."""

from __future__ import annotations

import itertools
import math
import operator
import warnings
from collections.abc import Callable
from dataclasses import KW_ONLY
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.errors import level_of_user, real_array, real_numbers, refuse_nonpositive
from poinsot.functions import Scalar
from poinsot.mechanics.environment import FrameOfOrbit, Orbit
from poinsot.orbits import piecewise_chebyshev as pieces
from poinsot.orbits.conic import Radius, check_surface, shown
from poinsot.printable import described, message_of, quoted, shortened
from poinsot.quantities import Array, Real, Time, Times
from poinsot.records.calendar import Calendar
from poinsot.records.parameters import Points, Positive, Table, listed
from poinsot.taylor.graph import Graph, number, tangents

__all__ = ["Ephemeris", "EphemerisFrame", "kilometres_to_metres"]

KILOMETRE = 1000.0


class PolynomialArc(Orbit):
    """Piece of an ephemeris: a polynomial of s, the time from the middle in units of half the length of the piece.

    Parameters
    ----------
    mu : float
        Gravitational parameter.
    terms : int
    middle, half_length : float
        Time in the middle of the piece, and half the length of the piece.
    coefficients : array (3, terms)
        Coefficients of the powers of s, beginning with the constant, of the position, space axes.
    """

    mu: Real
    _: KW_ONLY
    terms: int
    middle: Real
    half_length: Real
    coefficients: Annotated[Any, (3, "terms")]

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        s = (time - self.middle) / self.half_length
        powers = list(itertools.accumulate([s] * (self.terms - 1), operator.mul))
        rows = [self.coefficients[i] for i in range(3)]
        return functions.Vector(sum((c * x for c, x in zip(row[1:], powers, strict=True)), row[0]) for row in rows)

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        graph = Graph()
        moving = graph.variable(time)
        return functions.Vector(graph.finished(tangents(self.position_at(moving), {moving: 1.0})))


DISTANCE_SAMPLES = np.linspace(-1, 1, 17)
"""Places in a piece, in units of s, at which the distance is sampled for the periapsis."""


END_MARGIN = 5e-4
"""Time beyond the ends of an ephemeris, in lengths of its first or last piece, at which positions are known: the light
time of readings at the first time. The error of a polynomial of degree 12 is at most 1.2 times its error inside."""


class _Pieces(Table):
    """Polynomials of an ephemeris."""

    title = "ephemeris"

    @property
    @override
    def end_margin(self) -> float:
        return 2 * END_MARGIN * float(min(self.half_lengths[0], self.half_lengths[-1]))

    def __init__(self, knots: Array, coefficients: Array, error: float, labels: tuple[Any, Any, Any]) -> None:
        self.knots, self.coefficients, self.error = knots, coefficients, error
        self.reference_frame, self.origin, self.calendar = _checked_labels(*labels)
        self.middles, self.half_lengths = 0.5 * (knots[1:] + knots[:-1]), 0.5 * np.diff(knots)
        ends = [
            pieces.values(coefficients, self.half_lengths, np.full(len(self.middles), end), order)
            for order in (0, 1)
            for end in (1.0, -1.0)
        ]
        self.position_jumps, velocity_jumps = (
            np.linalg.norm(before[:-1] - after[1:], axis=-1) for before, after in (ends[:2], ends[2:])
        )
        self.position_jump, self.velocity_jump = (
            float(np.max(jumps, initial=0.0)) for jumps in (self.position_jumps, velocity_jumps)
        )
        between = (
            pieces.values(coefficients, self.half_lengths, np.full(len(self.middles), s), 0) for s in DISTANCE_SAMPLES
        )
        self.closest = float(min(np.min(np.linalg.norm(r, axis=-1)) for r in between))


class Ephemeris(Orbit):
    """Orbit of the body from a table or a function of time, as piecewise Chebyshev polynomials.

    `Ephemeris.from_function` approximates a function, `Ephemeris.from_table` interpolates positions and velocities. The
    compiled kernel receives the polynomial of the current interval as runtime parameters, and the integration stops at
    each knot.

    Attributes
    ----------
    mu : float
        Gravitational parameter of the attractor, in length^3 / time^2.
    reference_frame, origin : str
        Names of the space axes and of the attractor in the source.
    calendar : Calendar, optional
        Dates of the times; None if the source defines none.
    radius : float
        Radius of the attractor's surface, in length; 0: a point. An orbit below it causes a warning.

    Examples
    --------
    >>> def position(times):
    ...     return np.stack([np.cos(times), np.sin(times), 0 * times], axis=-1)
    >>> orbit = pt.orbits.Ephemeris.from_function(1.0, position=position, start=0.0, stop=6.0)
    >>> orbit.error < 1e-12
    True
    """

    mu: Positive
    _: KW_ONLY
    pieces: _Pieces
    radius: Radius = 0.0

    @classmethod
    @checked
    def from_function(
        cls,
        mu: float,
        *,
        position: Callable[[Array], ArrayLike],
        start: Time,
        stop: Time,
        tolerance: float = 1e-13,
        reference_frame: str = "space axes",
        origin: str = "attractor",
        calendar: Calendar | None = None,
        radius: float = 0.0,
    ) -> Ephemeris:
        """Approximate a function of time between two times by polynomials of degree 12.

        The intervals are halved until the polynomials reach the tolerance at intermediate times, or until only rounding
        errors of the function remain. At least 4000 times, evenly spaced, then test the result: the `error` is twice
        the largest difference. Features shorter than the span over 4000 may remain undetected; split the span to
        resolve them. A jump of the function becomes a knot at which the orbit jumps, with a warning that gives its time
        and size.

        Parameters
        ----------
        position : callable
            Function of the times, shape (n,), that returns positions of the body relative to the attractor, space axes,
            shape (n, 3).
        start, stop : float
            First and last time.
        tolerance : float
            Largest error relative to the distance.

        Returns
        -------
        Ephemeris
            The approximation.

        Raises
        ------
        ValueError
            If the times do not increase, or the function returns a wrong shape or numbers that are not finite.
        """
        first, last = (float(real_array(name, t, ())) for name, t in (("start", start), ("stop", stop)))
        if not first < last:
            raise ValueError(f"stop must be after start, got start = {first:.10g} and stop = {last:.10g}.")

        tolerance = float(real_array("tolerance", tolerance, ()))
        refuse_nonpositive("tolerance", tolerance)

        def positions(times: Array) -> Array:
            try:
                found = position(times)
            except TypeError as error:
                raise TypeError(
                    "position must be a function of times, shape (n,), but on such an array it raised "
                    f"a TypeError: {shortened(message_of(error))}."
                ) from error
            return real_array("position(times)", found, (times.size, 3))

        knots, coefficients, error = pieces.fitted(positions, first, last, tolerance)
        made = _Pieces(knots, coefficients, error, (reference_frame, origin, calendar))
        _warn_of_jumps(made)
        return cls(mu, pieces=made, radius=radius)

    @classmethod
    @checked
    def from_table(
        cls,
        mu: float,
        *,
        times: Times,
        positions: Points,
        velocities: Points,
        reference_frame: str = "space axes",
        origin: str = "attractor",
        calendar: Calendar | None = None,
        radius: float = 0.0,
    ) -> Ephemeris:
        """Interpolate a table of positions and velocities by Hermite polynomials through 2, 4 or 6 rows.

        The number of rows is the one that agrees best with the polynomial through two more rows. The difference,
        multiplied by 2 to 20 depending on the convergence of the orders, is the estimated upper bound `error`.
        Positions and velocities equal the table at its times, so both are continuous.

        Parameters
        ----------
        times : array (n,)
            Times, strictly increasing.
        positions, velocities : array (n, 3), space axes
            Position in length and velocity in length per time of the body relative to the attractor.

        Returns
        -------
        Ephemeris
            The interpolation.

        Raises
        ------
        ValueError
            If the times do not increase or contain a gap, or the shapes do not match.
        """
        t = real_array("times", times, (None,))
        r = real_array("positions", positions, (t.size, 3))
        v = real_array("velocities", velocities, (t.size, 3))
        _check_times(t)
        coefficients, error, difference = pieces.interpolated(t, r, v)
        size = float(np.max(np.linalg.norm(r, axis=-1)))
        if difference > COHERENCE_TOLERANCE * size:
            raise ValueError(
                f"positions and velocities must be of one smooth motion, but from row to row they miss each other by "
                f"{difference:.3g} of {size:.3g}. Are their units consistent, and the rows near enough?"
            )
        return cls(mu, pieces=_Pieces(t, coefficients, error, (reference_frame, origin, calendar)), radius=radius)

    @classmethod
    @checked
    def from_pieces(
        cls,
        mu: float,
        *,
        knots: Times,
        coefficients: Annotated[ArrayLike, ("pieces", 3, "terms")],
        reference_frame: str = "space axes",
        origin: str = "attractor",
        error: float | None = None,
        radius: float = 0.0,
        dated: bool = True,
        calendar: Calendar | None = None,
    ) -> Ephemeris:
        """Return an ephemeris from its knots and Chebyshev coefficients.

        Parameters
        ----------
        knots : array (n + 1,)
            Times between the intervals, strictly increasing.
        coefficients : array (n, 3, terms), space axes
            Chebyshev coefficients of the position relative to the attractor in each interval, in length.
        error : float, optional
            Estimated error of the positions, in length. Default: unknown.
        dated : bool
            True if the times belong to the calendar.

        Returns
        -------
        Ephemeris
            The piecewise polynomials.
        """
        times = real_array("knots", knots, (None,))
        if times.size < 2 or np.any(np.diff(times) <= 0):
            raise ValueError("knots must be two or more that rise, got others.")
        polynomials = real_array("coefficients", coefficients, (times.size - 1, 3, None))
        if not polynomials.size:
            raise ValueError("coefficients must not be empty, got none.")
        bound = math.nan if error is None else float(real_array("error", error, ()))
        labels = (reference_frame, origin, calendar if dated else None)
        return cls(mu, pieces=_Pieces(times, polynomials, bound, labels), radius=radius)

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        made = self.pieces
        names = ("knots", "coefficients", "reference_frame", "origin")
        error = {} if math.isnan(made.error) else {"error": made.error}
        fields = {"mu": self.mu, **{name: getattr(made, name) for name in names}, **error}
        return "Ephemeris.from_pieces", {**fields, "dated": made.calendar is not None, "radius": self.radius}

    def __post_init__(self) -> None:
        super().__post_init__()
        check_surface(self)

    def __repr__(self) -> str:
        first, last = self.span
        return (
            f"Ephemeris(mu={listed(self.mu)}, {len(self.knots) - 1} pieces over [{first:.10g}, {last:.10g}], "
            f"{self.reference_frame}, origin {self.origin}, error {self.error:.2g}, jumps {self.position_jump:.2g} and "
            f"{self.velocity_jump:.2g})"
        )

    knots = shown("pieces.knots", "Times between the intervals, including both ends of the span; shape (n + 1,).")
    error = shown(
        "pieces.error",
        """Estimated bound of the approximation or interpolation error, length.

        NaN for a table too short for an estimate.""",
    )
    position_jump = shown("pieces.position_jump", "Largest jump of the position at a knot, length.")
    velocity_jump = shown("pieces.velocity_jump", "Largest jump of the velocity at a knot, length over time.")
    reference_frame = shown("pieces.reference_frame", "Name of the space axes in the source.")
    origin = shown("pieces.origin", "Name of the attractor in the source.")
    calendar = shown("pieces.calendar", "Dates of the times; None if the source defines none.")
    periapsis_distance = shown("pieces.closest", "Smallest distance among 17 times of each interval.")

    @property
    @override
    def span(self) -> tuple[float, float]:
        return self.pieces.span

    @property
    def frame(self) -> EphemerisFrame:
        """Orbital axes: radial (away from the attractor), transverse (forward) and normal."""
        return EphemerisFrame(self)

    @property
    @override
    def sample_time(self) -> float:
        return float(self.pieces.middles[len(self.pieces.middles) // 2])

    def between_knots(self, time: ArrayLike) -> PolynomialArc:  # type: ignore[override]
        """Return the piece around a time, or, for an array of times, the piece around each time."""
        table, i = self.pieces, self.pieces.pieces_around(time)
        coefficients = pieces.powers(table.coefficients[i])
        fields = {"mu": self.mu, "middle": table.middles[i], "half_length": table.half_lengths[i]}
        return PolynomialArc.unchecked(terms=coefficients.shape[-1], **fields, coefficients=coefficients)

    def position_at(self, time: Scalar) -> functions.Vector:
        """Return the components of the position at a number, an array, or a time with derivatives."""
        return self._along(time, 0)

    def velocity_at(self, time: Scalar) -> functions.Vector:
        """Return the components of the velocity at a number, an array, or a time with derivatives."""
        return self._along(time, 1)

    def acceleration_at(self, time: Scalar) -> functions.Vector:
        """Return the components of the second derivative of the position, which may jump at knots."""
        return self._along(time, 2)

    def _along(self, time: Scalar, order: int) -> functions.Vector:
        here = number(time)
        value = self._derivative(here, order)
        return value if here is time else functions.Vector(value + self._derivative(here, order + 1) * (time - here))

    def _derivative(self, time: Any, order: int) -> functions.Vector:
        t, table = real_numbers("time", time), self.pieces
        i = table.pieces_at(t)
        s = (t - table.middles[i]) / table.half_lengths[i]
        values = pieces.values(table.coefficients[i], table.half_lengths[i], s, order)
        return functions.Vector(np.moveaxis(values, -1, 0))


@checked
def kilometres_to_metres(orbit: Ephemeris) -> Ephemeris:
    """Convert an ephemeris in kilometres to metres.

    Files and analytical theories give kilometres. Radiation, drag and magnetic fields require lengths and moments of
    inertia in one system of units.

    Parameters
    ----------
    orbit : Ephemeris
        Ephemeris in km, km/s and km3/s2.

    Returns
    -------
    Ephemeris
        The same ephemeris in m, m/s and m3/s2.

    Examples
    --------
    >>> mars = pt.orbits.planet_orbit("mars", "sun", "2026-01-01T00:00:00 TDB", "2026-01-02T00:00:00 TDB")
    >>> float(pt.orbits.kilometres_to_metres(mars).mu / mars.mu)
    1000000000.0
    """
    made = orbit.pieces
    labels = made.reference_frame, made.origin, made.calendar
    longer = _Pieces(made.knots, KILOMETRE * made.coefficients, KILOMETRE * made.error, labels)
    return Ephemeris(KILOMETRE**3 * orbit.mu, pieces=longer, radius=KILOMETRE * orbit.radius)


class EphemerisFrame(FrameOfOrbit):
    """Radial (away from the attractor), transverse (forward), normal to position and velocity, along an ephemeris.

    Along an array of times the quaternion does not jump.
    """

    @override
    def quaternion(self, time: ArrayLike) -> Array:
        q = super().quaternion(time)
        if np.ndim(time):
            same = quat.dot(q[..., 1:, :], q[..., :-1, :]) >= 0
            q[..., 1:, :] *= np.cumprod(np.where(same, 1, -1), axis=-1)[..., None]
        return q


def _warn_of_jumps(made: _Pieces) -> None:
    """Warn of knots at which a function jumps: neighbouring polynomials that meet it differ by the error at most."""
    found = np.flatnonzero(made.position_jumps > made.error)
    if not found.size:
        return
    largest = found[np.argmax(made.position_jumps[found])]
    size, time = made.position_jumps[largest], made.knots[1 + largest]
    calendar = made.calendar
    date = "" if calendar is None else f" ({calendar.date(time).isot} {calendar.scale})"
    number = "a jump" if found.size == 1 else f"{found.size} jumps, the largest"
    warnings.warn(
        f"the position relative to {made.origin} must be continuous from start to stop, got {number} of {size:.6g} at "
        f"t = {time:.10g}{date}. The orbit jumps there too. End it before, or begin it after the jump.",
        stacklevel=level_of_user(),
    )


COHERENCE_TOLERANCE = 0.01
"""Largest error of an accepted table, relative to the largest distance."""

GAP_RATIO = 1.75
"""An interval that is longer than this times the median of eleven around it is a gap."""


def _checked_labels(reference_frame: Any, origin: Any, calendar: Any) -> tuple[str, str, Any]:
    for name, value in (("reference_frame", reference_frame), ("origin", origin)):
        if not isinstance(value, str) or not value:
            raise TypeError(f"{name} must be a name, got {quoted(value)}.")
    if calendar is not None and not isinstance(calendar, Calendar):
        raise TypeError(f"calendar must be a Calendar, got {described(calendar)}.")
    return FRAMES.get(reference_frame.upper(), reference_frame), origin, calendar


FRAMES = dict.fromkeys(("ICRF", "GCRF", "EME2000", "J2000"), "ICRF") | {"TEME": "TEME"}
"""Names of one frame, to 0.03 arcseconds."""


def _check_times(t: Array) -> None:
    if t.size < 2:
        raise ValueError(f"times must be two or more, got {t.size}.")
    steps = np.diff(t)
    if np.any(steps <= 0):
        i = int(np.argmax(steps <= 0))
        raise ValueError(
            f"times must rise strictly, got times[{i}] = {t[i]:.17g} and times[{i + 1}] = {t[i + 1]:.17g}. "
            "Sort the rows, and remove repeated times."
        )
    around = np.lib.stride_tricks.sliding_window_view(np.pad(steps, 5, mode="symmetric"), 11)
    ratios = steps / np.median(around, axis=-1)
    if np.any(ratios > GAP_RATIO):
        i = int(np.argmax(ratios))
        raise ValueError(
            f"times must have no gaps, but {steps[i]:.6g} lie between times[{i}] = {t[i]:.10g} and the next, "
            f"{ratios[i]:.3g} times as long as the intervals around. Make a table of each part."
        )
