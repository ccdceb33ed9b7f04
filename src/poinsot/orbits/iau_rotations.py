"""Parameters of rotation models: values of the IAU working group, and rotation angle and precession of the Earth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from poinsot.records.calendar import SECONDS, Calendar, leap_second_gone

__all__ = ["MODELS", "at_zero", "earth_at_zero"]

J2000_TT, J2000_UTC = (Calendar("2000-01-01T12:00:00", scale) for scale in ("TT", "UTC"))

DAY, CENTURY = 86400, 86400 * 36525
"""Seconds."""

FAST = {"TCB": 1 - 1.550519768e-8, "TCG": 1 - 6.969290134e-10}
"""TDB and TT seconds in one of these scales."""

MARS = (
    (0.000068, 0, 0, 198.991226, 19139.4819985),
    (0.000238, 0, 0, 226.292679, 38280.8511281),
    (0.000052, 0, 0, 249.663391, 57420.7251593),
    (0.000009, 0, 0, 266.183510, 76560.6367950),
    (0.419057, 0, 0, 79.398797, 0.5042615),
    (0, 0.000051, 0, 122.433576, 19139.9407476),
    (0, 0.000141, 0, 43.058401, 38280.8753272),
    (0, 0.000031, 0, 57.663379, 57420.7517205),
    (0, 0.000005, 0, 79.476401, 76560.6495004),
    (0, 1.591274, 0, 166.325722, 0.5042615),
    (0, 0, 0.000145, 129.071773, 19140.0328244),
    (0, 0, 0.000157, 36.352167, 38281.0473591),
    (0, 0, 0.000040, 56.668646, 57420.9295360),
    (0, 0, 0.000001, 67.364003, 76560.2552215),
    (0, 0, 0.000001, 104.792680, 95700.4387578),
    (0, 0, 0.584542, 95.391654, 0.5042615),
)
MOON = (
    (-3.8787, 1.5419, 3.5610, 125.045, -1935.5364525),
    (-0.1204, 0.0239, 0.1208, 250.089, -3871.072905),
    (0.0700, -0.0278, -0.0642, 260.008, 475263.3328725),
    (-0.0172, 0.0068, 0.0158, 176.625, 487269.629985),
    (0, 0, 0.0252, 357.529, 35999.0509575),
    (0.0072, -0.0029, -0.0066, 311.589, 964468.49931),
    (0, 0.0009, -0.0047, 134.963, 477198.869325),
    (0, 0, -0.0046, 276.617, 12006.300765),
    (0, 0, 0.0028, 34.226, 63863.5132425),
    (-0.0052, 0.0008, 0.0052, 15.134, -5806.6093575),
    (0, 0, 0.0040, 119.743, 131.84064),
    (0, 0, 0.0019, 239.961, 6003.1503825),
    (0.0043, -0.0009, -0.0044, 25.053, 473327.79642),
)
J3, J4, J5, J6, J7, J8 = (
    (283.90, 4850.7),
    (355.80, 1191.3),
    (119.90, 262.1),
    (229.80, 64.3),
    (352.25, 2382.6),
    (113.35, 6070.0),
)

MODELS: dict[str, tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], Sequence[Sequence[float]]]] = {
    "sun": ((286.13, 0), (63.87, 0), (84.176, 14.1844, 0), ()),
    "mercury": (
        (281.0103, -0.0328),
        (61.4155, -0.0049),
        (329.5988, 6.1385108, 0),
        (
            (0, 0, 0.01067257, 174.7910857, 149472.535875),
            (0, 0, -0.00112309, 349.5821714, 298945.07175),
            (0, 0, -0.00011040, 164.3732571, 448417.607625),
            (0, 0, -0.00002539, 339.1643429, 597890.1435),
            (0, 0, -0.00000571, 153.9554286, 747362.679375),
        ),
    ),
    "venus": ((272.76, 0), (67.16, 0), (160.20, -1.4813688, 0), ()),
    "earth": ((0, -0.641), (90, -0.557), (190.147, 360.9856235, 0), ()),
    "moon": ((269.9949, 0.0031), (66.5392, 0.0130), (38.3213, 13.17635815, -1.4e-12), MOON),
    "mars": ((317.269202, -0.10927547), (54.432516, -0.05827105), (176.049863, 350.891982443297, 0), MARS),
    "jupiter": (
        (268.056595, -0.006499),
        (64.495303, 0.002413),
        (284.95, 870.536, 0),
        (
            (0.000117, 0.000050, 0, 99.360714, 4850.4046),
            (0.000938, 0.000404, 0, 175.895369, 1191.9605),
            (0.001432, 0.000617, 0, 300.323162, 262.5475),
            (0.000030, -0.000013, 0, 114.012305, 6070.2476),
            (0.002150, 0.000926, 0, 49.511251, 64.3),
        ),
    ),
    "saturn": ((40.589, -0.036), (83.537, -0.004), (38.90, 810.7939024, 0), ()),
    "uranus": ((257.311, 0), (-15.175, 0), (203.81, -501.1600928, 0), ()),
    "neptune": ((299.36, 0), (43.46, 0), (249.978, 541.1397757, 0), ((0.70, -0.51, -0.48, 357.85, 52.316),)),
    "pluto": ((132.993, 0), (-6.163, 0), (302.695, 56.3625225, 0), ()),
    "io": (
        (268.05, -0.009),
        (64.50, 0.003),
        (200.39, 203.4889538, 0),
        ((0.094, 0.040, -0.085, *J3), (0.024, 0.011, -0.022, *J4)),
    ),
    "europa": (
        (268.08, -0.009),
        (64.51, 0.003),
        (36.022, 101.3747235, 0),
        (
            (1.086, 0.468, -0.980, *J4),
            (0.060, 0.026, -0.054, *J5),
            (0.015, 0.007, -0.014, *J6),
            (0.009, 0.002, -0.008, *J7),
        ),
    ),
    "ganymede": (
        (268.20, -0.009),
        (64.57, 0.003),
        (44.064, 50.3176081, 0),
        ((-0.037, -0.016, 0.033, *J4), (0.431, 0.186, -0.389, *J5), (0.091, 0.039, -0.082, *J6)),
    ),
    "callisto": (
        (268.72, -0.009),
        (64.83, 0.003),
        (259.51, 21.5710715, 0),
        ((-0.068, -0.029, 0.061, *J5), (0.590, 0.254, -0.533, *J6), (0.010, -0.004, -0.009, *J8)),
    ),
    "titan": ((39.4827, 0), (83.4279, 0), (186.5855, 22.5769768, 0), ()),
}
"""Pole: right ascension and declination, deg and deg per century; prime meridian: deg, deg/d, deg/d2; periodic terms:
amplitudes of the three, deg, phase, deg, and its rate, deg per century. Time is TDB from J2000. Archinal et al. 2018,
CMDA 130, 22, as NAIF's pck00011.tpc has them."""


def at_zero(body: str, calendar: Calendar, origin: Calendar) -> tuple[dict[str, float], list[list[float]]]:
    """Return the fields of a model, radians and units of a calendar, at its zero, and the rows of periodic terms.

    Decimal numbers are converted exactly, so that angles have all digits of a double.
    """
    zero = Fraction(float(origin.converted(np.zeros(1), calendar)[0]))
    unit = Fraction(SECONDS[calendar.unit] * FAST.get(calendar.scale, 1.0))
    days, centuries = zero / DAY, zero / CENTURY
    ascension, declination, meridian, periodic = MODELS[body]
    (a, da), (d, dd), (w, dw, ddw) = (tuple(map(_decimal, row)) for row in (ascension, declination, meridian))
    fields = {
        "right_ascension": _radians(a + da * centuries),
        "declination": _radians(d + dd * centuries),
        "prime_meridian": _radians((w + dw * days + ddw * days * days) % 360),
        "rate": _radians((dw + 2 * ddw * days) * unit / DAY),
        "right_ascension_rate": _radians(da * unit / CENTURY),
        "declination_rate": _radians(dd * unit / CENTURY),
        "acceleration": _radians(2 * ddw * (unit / DAY) ** 2),
    }
    rows = []
    for *sizes, phase, rate in (tuple(map(_decimal, row)) for row in periodic):
        now = (phase + rate * centuries) % 360
        rows.append([*map(_radians, sizes), _radians(now), _radians(rate * unit / CENTURY)])
    return fields, rows


def _decimal(x: float) -> Fraction:
    return Fraction(repr(x))


def _radians(degrees: Fraction) -> float:
    return math.radians(degrees)


ARCSECOND = math.pi / 648000
PRECESSION = {"zeta": (2.650545, 2306.083227, 0.2988499), "z": (-2.650545, 2306.077181, 1.0927348)}
THETA, SIDEREAL = (0.0, 2004.191903, -0.4294934), (0.014506, 4612.156534, 1.3915817)
"""Angles of precession, and sidereal time less the Earth rotation angle: arcseconds and powers of centuries of TT.
Capitaine, Wallace and Chapront 2003, A&A 412, 567; cubes are below 0.02 arcseconds in 50 years."""

TURN_AT_J2000, TURNS_A_DAY = Fraction("0.7790572732640"), Fraction("1.00273781191135448")
"""Earth rotation angle in revolutions: value at J2000 and rate per day of UT1.
Capitaine, Guinot and McCarthy 2000, A&A 355, 398."""


def earth_at_zero(calendar: Calendar, ut1_minus_utc: float, of_date: bool) -> dict[str, float]:
    """Return the fields of the Earth's model at a calendar's zero, along the ICRF or along axes of date.

    The precession matrix is R3(-z) R2(theta) R3(-zeta), and the rotation is R3 of the sidereal time.
    """
    terrestrial, universal = (float(each.converted(np.zeros(1), calendar)[0]) for each in (J2000_TT, J2000_UTC))
    unit, instant = SECONDS[calendar.unit] * FAST.get(calendar.scale, 1.0), J2000_UTC.date(universal)
    days = Fraction(float(instant.jd1)) - 2451545 + Fraction(float(instant.jd2)) + Fraction(ut1_minus_utc) / DAY
    days += Fraction(float(leap_second_gone(instant)))
    centuries, century = terrestrial / CENTURY, unit / CENTURY
    turns = (TURN_AT_J2000 + TURNS_A_DAY * days) % 1
    (zeta, zeta_rate), (z, z_rate), (theta, theta_rate), (ahead, ahead_rate) = (
        _along(row, centuries) for row in (*PRECESSION.values(), THETA, SIDEREAL)
    )
    turning, rate = 2 * math.pi * float(turns) + ahead, 2 * math.pi * float(TURNS_A_DAY) * unit / DAY
    if of_date:
        angles = {"right_ascension": -math.pi / 2, "declination": math.pi / 2, "prime_meridian": turning}
        return {**angles, "rate": rate + ahead_rate * century}
    return {
        "right_ascension": -zeta,
        "declination": math.pi / 2 - theta,
        "prime_meridian": turning - z - math.pi / 2,
        "rate": rate + (ahead_rate - z_rate) * century,
        "right_ascension_rate": -zeta_rate * century,
        "declination_rate": -theta_rate * century,
    }


def _along(row: tuple[float, ...], t: float) -> tuple[float, float]:
    """Return a polynomial of arcseconds and its derivative, radians."""
    c0, c1, c2 = row
    return ARCSECOND * (c0 + t * (c1 + t * c2)), ARCSECOND * (c1 + 2 * t * c2)
