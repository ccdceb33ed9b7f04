"""Rotation models of planets and moons: pole, prime meridian, and their rates."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, InitVar, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import member_array, real_array, real_numbers, refuse_nonpositive
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.kinematics.euler import quaternion_from_angles
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.mechanics.planet_axes import PlanetAxes
from poinsot.orbits import iau_rotations
from poinsot.orbits.angle_reduction import angle_at
from poinsot.orbits.planets import J2000
from poinsot.orbits.pole import REFERENCE_FRAMES, pole_attitude
from poinsot.printable import quoted
from poinsot.quantities import Angle, AngularVelocity, Duration, Real, Time, Times
from poinsot.records.calendar import Calendar
from poinsot.records.members import of_scalars
from poinsot.taylor.graph import Graph, tangents

__all__ = ["NutatingRotation", "RotationModel"]

QUARTER = np.pi / 2


class RotationModel(PlanetAxes):
    """Orientation of a rotating planet or moon with a slowly precessing pole.

    x_space = R3(right_ascension + 90 deg) R1(90 deg - declination) R3(prime_meridian) x_planet, with active rotations
    R. The third axis is the pole. The first axis lies on the prime meridian, the angle `prime_meridian` east of the
    ascending node of the equator on the plane of the first two space axes. The angles are polynomials of time and
    reduced to a few revolutions with twice the digits.

    Parameters
    ----------
    right_ascension, declination : float
        Direction of the pole at the epoch, radians, relative to the space axes.
    prime_meridian : float
        Angle of the prime meridian at the epoch, radians.
    rate : float
        Rate of the prime meridian, radians per unit of time; the angular velocity of the rotation for a fixed pole.
    right_ascension_rate, declination_rate : float
        Rates of the pole, radians per unit of time.
    acceleration : float
        Second derivative of the prime meridian, radians per unit of time squared.
    epoch : float
        Time to which the angles refer.
    reference_frame : str
        Name of the space axes. An orbit along axes with another name raises an error.
    calendar : Calendar, optional
        Dates of the times.

    Examples
    --------
    >>> mars = pt.orbits.RotationModel.iau("mars")
    >>> round(float(np.degrees(mars.right_ascension)), 3), round(24 * 7.292115e-5 / float(mars.rate), 2)
    (317.269, 24.69)
    """

    right_ascension: Angle
    declination: Angle
    prime_meridian: Angle
    _: KW_ONLY
    rate: AngularVelocity
    right_ascension_rate: AngularVelocity = 0.0
    declination_rate: AngularVelocity = 0.0
    acceleration: Real = 0.0
    epoch: Time = 0.0
    reference_frame: str = SPACE_AXES_UNNAMED
    calendar: InitVar[Calendar | None] = field(default=None, kw_only=True)

    def __post_init__(self, calendar: Any) -> None:
        super().__post_init__()
        object.__setattr__(self, "calendar", calendar)

    @classmethod
    @checked
    def iau(cls, body: str, *, calendar: Calendar = J2000) -> RotationModel:
        """Return the IAU rotation model of the Sun, a planet or a large moon, relative to the ICRF.

        The model includes periodic terms (Archinal et al. 2018, CMDA 130, 22). For the Earth, `earth` is far more
        accurate.

        Parameters
        ----------
        body : str
            Name, such as "sun", "mars", "moon" or "titan".
        calendar : Calendar, optional
            Dates of the times. Default: TDB from 2000-01-01T12:00:00, in seconds. Other calendars require astropy, and
            the model ignores their periodic difference from TDB, at most 1.7 ms.

        Returns
        -------
        RotationModel
            The model, a `NutatingRotation` where it has periodic terms.

        Raises
        ------
        ValueError
            If the body is unknown.
        """
        name = body.lower()
        if name not in iau_rotations.MODELS:
            raise ValueError(f"body must be one of {', '.join(iau_rotations.MODELS)}, got {quoted(body)}.")
        numbers, periodic = iau_rotations.at_zero(name, calendar, J2000)
        fields: dict[str, Any] = {**numbers, "reference_frame": "ICRF", "calendar": calendar}
        return NutatingRotation(**fields, terms=len(periodic), periodic=periodic) if periodic else cls(**fields)

    @classmethod
    @checked
    def from_pole(
        cls,
        longitude: Angle,
        latitude: Angle,
        period: Duration,
        angle: Angle = 0.0,
        *,
        epoch: Time = 0.0,
        axes: str = "space",
        calendar: Calendar | None = None,
    ) -> RotationModel:
        """Return the rotation of a body about the fixed pole of a catalogue, such as DAMIT.

        x_space = R3(longitude) R2(90 deg - latitude) R3(angle + 2 pi (t - epoch)/period) x_body, with active rotations
        R (Durech, Sidorin and Kaasalainen 2010, A&A 513, A46). Longitude and latitude are right ascension and
        declination for `axes="equatorial"`. At rest in these axes a body has the state
        `body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=model, time=t)`.

        Parameters
        ----------
        longitude, latitude : float
            Direction of the third body axis, radians.
        period : float
            Sidereal period; positive, as the body rotates in the positive sense about the pole.
        angle : float
            Rotation angle at the epoch, radians.
        axes : {"space", "equatorial", "ecliptic"}
            Axes of longitude and latitude: space axes, equator or ecliptic of J2000. The latter two give a model in
            the ICRF.

        Raises
        ------
        ValueError
            If the period is not positive or the axes are unknown.
        """
        turn = member_array("period", period, ())
        refuse_nonpositive("period", turn, "The pole of a retrograde rotation has a negative latitude.")
        rising, _, pole = np.moveaxis(rotation_matrix(pole_attitude(longitude, latitude, angle, axes)), -1, 0)
        ascension, declination = np.arctan2(pole[..., 1], pole[..., 0]), np.arctan2(pole[..., 2], np.hypot(*pole.T[:2]))
        node = np.stack([-np.sin(ascension), np.cos(ascension), np.zeros_like(ascension)], axis=-1)
        meridian = np.arctan2(np.vecdot(np.cross(pole, node), rising), np.vecdot(node, rising))
        rate = np.asarray(2 * np.pi / turn)
        fields: dict[str, Any] = {"epoch": epoch, "reference_frame": REFERENCE_FRAMES[axes], "calendar": calendar}
        return cls(ascension[()], declination[()], meridian[()], rate=rate[()], **fields)

    @classmethod
    @checked
    def earth(
        cls, *, calendar: Calendar = J2000, ut1_minus_utc: Real = 0.0, reference_frame: str = "ICRF"
    ) -> RotationModel:
        """Return the Earth's rotation model: Earth rotation angle and IAU 2006 precession, linear in time.

        The linearisation is around the calendar's zero. The model ignores nutation (17 arcseconds), polar motion and
        changes of the length of day. It requires astropy.

        Parameters
        ----------
        calendar : Calendar, optional
            Dates of the times. Default: TDB from 2000-01-01T12:00:00, in seconds.
        ut1_minus_utc : float
            UT1 - UTC at the calendar's zero, seconds. Its magnitude is below 0.9 s, which corresponds to 14 arcseconds.
        reference_frame : {"ICRF", "TEME"}
            Space axes. TEME, true equator and mean equinox of date, is the frame of two-line elements.

        Returns
        -------
        RotationModel
            The linear model.

        Raises
        ------
        ValueError
            If the reference frame is unknown.
        """
        if reference_frame not in ("ICRF", "TEME"):
            raise ValueError(f"reference_frame must be ICRF or TEME, got {quoted(reference_frame)}.")
        offset = float(real_array("ut1_minus_utc", ut1_minus_utc, ()))
        numbers = iau_rotations.earth_at_zero(calendar, offset, reference_frame == "TEME")
        fields: dict[str, Any] = {**numbers, "reference_frame": reference_frame, "calendar": calendar}
        return cls(**fields)

    # ------------------------------------------------------------------ formulas

    @of_scalars
    def angles_at(self, time: Scalar) -> Vector:
        """Return right ascension and declination of the pole, and prime meridian; for floats modulo two revolutions."""
        since = time - self.epoch
        ascension = angle_at(self.right_ascension, self.right_ascension_rate, time, self.epoch)
        declination = angle_at(self.declination, self.declination_rate, time, self.epoch)
        meridian = angle_at(self.prime_meridian, self.rate, time, self.epoch)
        return Vector((ascension, declination, meridian + 0.5 * self.acceleration * (since * since)))

    @of_scalars
    def axes_at(self, time: Scalar) -> tuple[Vector, Vector, Vector]:
        """Return the three axes of the planet along the space axes."""
        (rising, ahead, pole), (c, s) = self._turn(time)
        return rising * c + ahead * s, ahead * c - rising * s, pole

    @override
    def to_planet(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        (rising, ahead, pole), (c, s) = self._turn(time)
        x, y, z = (functions.dot(axis, vector) for axis in (rising, ahead, pole))
        return Vector((c * x + s * y, c * y - s * x, z))

    @override
    def to_space(self, vector: Iterable[Scalar], time: Scalar) -> Vector:
        (rising, ahead, pole), (c, s) = self._turn(time)
        x, y, z = vector
        return Vector(rising * (c * x - s * y) + ahead * (s * x + c * y) + pole * z)

    def _turn(self, time: Scalar) -> tuple[tuple[Vector, Vector, Vector], tuple[Scalar, Scalar]]:
        """Return axes that do not rotate with the planet, and cosine and sine of the rotation angle about the third.

        The first axis is the ascending node of the planet's equator on the plane of the first two space axes.
        """
        (ca, sa), (cd, sd), turned = ((functions.cos(x), functions.sin(x)) for x in self.angles_at(time))
        still = Vector((-sa, ca, 0.0)), Vector((-sd * ca, -sd * sa, cd)), Vector((cd * ca, cd * sa, sd))
        return still, turned

    # ------------------------------------------------------------------ the frame

    @override
    def quaternion(self, time: Times) -> NDArray[np.float64]:
        ascension, declination, meridian = self.angles_at(real_numbers("time", time))
        angles = np.broadcast_arrays(ascension + QUARTER, QUARTER - declination, meridian)
        return np.asarray(quaternion_from_angles(np.stack(angles, axis=-1), "313"))

    @override
    def omega_space(self, time: Times) -> NDArray[np.float64]:
        t, graph = real_numbers("time", time), Graph()
        moving = graph.variable(t)
        ascension, declination, meridian = graph.finished(tangents(list(self.angles_at(moving)), {moving: 1.0}))
        alpha, _, _ = self.angles_at(t)
        pole, rising = self.axes_at(t)[2], Vector((-np.sin(alpha), np.cos(alpha), 0.0))
        omega = pole * meridian - rising * declination + Vector((0.0, 0.0, ascension))
        return np.stack(np.broadcast_arrays(*omega, t)[:3], axis=-1)


class NutatingRotation(RotationModel):
    """Rotation model with periodic terms of the angles: nutation and physical libration.

    The periodic terms are amplitude sin(phase + rate (time - epoch)) for right ascension and prime meridian, and
    amplitude cos(phase + rate (time - epoch)) for the declination. The other parameters describe the angles without
    these terms.

    Parameters
    ----------
    terms : int
        Number of periodic terms.
    periodic : array (terms, 5)
        Rows of the amplitudes in right ascension, declination and prime meridian, radians, the phase at the epoch,
        radians, and its rate, radians per unit of time.

    Examples
    --------
    >>> moon = pt.orbits.RotationModel.iau("moon")
    >>> moon.terms, round(float(np.degrees(moon.angles_at(0.0)[1])), 2)
    (13, 65.64)
    """

    _: KW_ONLY
    terms: int
    periodic: Annotated[Any, ("terms", 5)]

    @override
    def angles_at(self, time: Scalar) -> Vector:
        ascension, declination, meridian = super().angles_at(time)
        for i in range(self.terms):
            *sizes, start, rate = self.periodic[i]
            phase = angle_at(start, rate, time, self.epoch)
            sine, cosine = functions.sin(phase), functions.cos(phase)
            ascension = ascension + sizes[0] * sine
            declination = declination + sizes[1] * cosine
            meridian = meridian + sizes[2] * sine
        return Vector((ascension, declination, meridian))
