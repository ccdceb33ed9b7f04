"""Spins in the format of DAMIT: pole, period, phase and law of scattering of an asteroid."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from poinsot.atomic_write import write_text
from poinsot.checked import checked, checked_fields
from poinsot.display.html_text import Summarized
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.files.observations.julian_rows import calendar_before, julian_date
from poinsot.files.rows import number
from poinsot.files.untrusted import read_text
from poinsot.orbits.rotation import RotationModel
from poinsot.printable import quoted, shortened
from poinsot.quantities import plain
from poinsot.records.calendar import SECONDS, Calendar, julian_dates, times_of_julian_dates
from poinsot.shapes.scattering import LambertLommelSeeliger

__all__ = ["DamitSpin", "read_damit_spin", "write_damit_spin"]

ANGLES = ("longitude", "latitude", "angle")

DIGITS = 14
"""Significant digits of written angles and periods."""

SPIN = (("lambda", "beta", "period"), ("JD0", "phi0"))
"""Names of the numbers in the first lines of a file."""

LAW = (("a", "d", "k"), ("c",))
"""Names of the numbers in the last lines of a file, which it may lack."""

MAX_PERIOD = 1e9
"""h."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class DamitSpin(Summarized):
    """Uniform rotation of an asteroid about a fixed pole, as in the database DAMIT.

    x_ecliptic = R3(longitude) R2(90 deg - latitude) R3(angle + 2 pi (t - epoch)/period) x_asteroid, with active
    rotations R (Durech, Sidorin and Kaasalainen 2010, A&A 513, A46).

    Parameters
    ----------
    longitude, latitude : float
        Direction of the third body axis along the ecliptic axes of J2000, radians.
    period : float
        Sidereal period in the unit of the calendar.
    epoch : float
        Time at which the rotation angle is `angle`.
    angle : float
        Rotation angle at the epoch, radians.
    calendar : Calendar
        Calendar of the epoch.
    law : LambertLommelSeeliger, optional
        Law of scattering with the phase function of the model.

    Examples
    --------
    >>> spin = pt.files.read_damit_spin("spin.txt", calendar=pt.Calendar("2000-01-01", "TDB", "h"))
    >>> spin.period, spin.rotation.reference_frame
    (5.27, 'ICRF')
    """

    longitude: float
    latitude: float
    period: float
    epoch: float
    angle: float
    calendar: Calendar
    law: LambertLommelSeeliger | None = None

    def __post_init__(self) -> None:
        for name in ("longitude", "latitude", "period", "epoch", "angle"):
            value = plain(name, getattr(self, name), "rad" if name in ANGLES else None)
            object.__setattr__(self, name, float(real_array(name, value, ())))
        refuse_nonpositive("period", self.period)
        checked_fields(self)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        unit = self.calendar.unit
        return "Spin of DAMIT", {
            "pole": f"longitude {np.degrees(self.longitude):.10g} deg, latitude {np.degrees(self.latitude):.10g} deg",
            "period": f"{self.period:.12g} {unit}",
            "angle": f"{np.degrees(self.angle):.10g} deg at t = {self.epoch:.12g} {unit}",
            "law": "" if self.law is None else repr(self.law),
        }

    @property
    def rotation(self) -> RotationModel:
        """Orientation of the body axes along the ICRF, by the formula of the class."""
        return RotationModel.from_pole(
            self.longitude,
            self.latitude,
            self.period,
            self.angle,
            epoch=self.epoch,
            axes="ecliptic",
            calendar=self.calendar,
        )


@checked
def read_damit_spin(path: str | Path, *, calendar: Calendar | None = None) -> DamitSpin:
    """Return the spin in a file of DAMIT (spin.txt).

    The file contains a line with the ecliptic longitude and latitude of the pole in degrees and the sidereal period in
    hours, a line with the Julian date of the epoch, TDB, and the rotation angle in degrees, and optionally the numbers
    a, d, k of the phase function a exp(-alpha/d) + k alpha + 1 and the weight c of Lambert's law.

    Parameters
    ----------
    path : str or Path
        Name of the file.
    calendar : Calendar, optional
        Calendar of the epoch. Default: hours of TDB from the midnight before the epoch.

    Returns
    -------
    DamitSpin
        The spin, whose `rotation` is a `RotationModel`.

    Raises
    ------
    OSError, ValueError, ImportError
        If the file cannot be read or is in another format, a number is not finite, or the calendar counts in another
        scale than TDB and astropy is not installed.

    Examples
    --------
    >>> spin = pt.files.read_damit_spin("spin.txt")
    >>> round(float(np.degrees(spin.latitude)), 6)
    -63.0
    """
    name = shortened(path)
    lines = [(f"{name}, line {i}", line.split()) for i, line in enumerate(read_text(path).splitlines(), 1)]
    lines = [(place, words) for place, words in lines if words]
    known = SPIN if len(lines) <= len(SPIN) else SPIN + LAW
    found = dict[str, str]()
    for (place, words), keys in zip(lines, known, strict=False):
        if len(words) != len(keys):
            raise ValueError(f"{place} must have {', '.join(keys)}, got {quoted(' '.join(words)[:60])}.")
        found |= dict(zip(keys, words, strict=True))
    if len(lines) != len(known):
        raise ValueError(f"{name} must be a spin of DAMIT in {len(SPIN)} or {len(SPIN + LAW)} lines, got {len(lines)}.")
    numbers = {key: number(key, word, name) for key, word in found.items() if key != "JD0"}
    if not 0 < numbers["period"] < MAX_PERIOD:
        raise ValueError(f"{lines[0][0]} must have a positive period in hours, got {quoted(found['period'])}.")
    if not abs(numbers["beta"]) <= 90:
        raise ValueError(f"{lines[0][0]} must have a latitude from -90 to 90 deg, got {quoted(found['beta'])}.")
    date = julian_date(found["JD0"], lines[1][0])
    counted = calendar or calendar_before(date, "TDB", "h")
    (epoch,) = times_of_julian_dates([date], "TDB", counted)
    period = numbers["period"] * (SECONDS["h"] / SECONDS[counted.unit])
    longitude, latitude, angle = (float(np.radians(numbers[key])) for key in ("lambda", "beta", "phi0"))
    law: Any = None
    if known != SPIN:
        try:
            law = LambertLommelSeeliger(**{key: numbers[key] for keys in LAW for key in keys})
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    return DamitSpin(longitude, latitude, period, float(epoch), angle, counted, law)


@checked
def write_damit_spin(spin: DamitSpin, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a spin in the format of DAMIT, angles and period with 14 digits.

    Parameters
    ----------
    spin : DamitSpin
        Spin to write.
    path : str or Path
        Name of the file.
    overwrite : bool
        True to replace an existing file.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, OSError
        If the first argument is no spin, or the file exists.

    Examples
    --------
    >>> path = pt.files.write_damit_spin(pt.files.read_damit_spin("spin.txt"), "again.txt")
    >>> path.read_text().split()[:3]
    ['251', '-63', '5.27']
    """
    longitude, latitude, angle = (f"{np.degrees(x):.{DIGITS}g}" for x in (spin.longitude, spin.latitude, spin.angle))
    period = f"{spin.period * (SECONDS[spin.calendar.unit] / SECONDS['h']):.{DIGITS}g}"
    (date,) = julian_dates(np.array([spin.epoch]), "TDB", spin.calendar)
    lines = [f"{longitude} {latitude} {period}", f"{date} {angle}"]
    if spin.law is not None:
        lines += [" ".join(repr(float(getattr(spin.law, key))) for key in keys) for keys in LAW]
    return write_text(path, "\n".join(lines) + "\n", overwrite)
