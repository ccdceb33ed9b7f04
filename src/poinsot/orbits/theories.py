"""Positions of the planets from VSOP2013 and of the Moon from ELP2000-82B, evaluated with NumPy.

Sources: Simon, Francou, Fienga and Manche 2013, A&A 557, A49 (planets); Chapront-Touze and Chapront 1983, A&A 124, 50
(Moon). The variables are Poisson series

    x_i = sum T^k (C_jk cos phi_j + S_jk sin phi_j),  phi_j = sum n_jl angle_l(T)

with integers n_jl and polynomials angle_l of the time T in TDB from J2000. `theories.npz` contains for each body, after
its name:

angles : float64 (angles, powers)
    Coefficients of the polynomials, radians. The last one is a part of the longitude.
multiples : int32 (arguments, angles)
    Integers n_jl.
columns : int8 (columns, 3)
    Variable i, power k of the time, and binary exponent of the unit of the amplitudes.
present : uint8
    Bits of a mask, (arguments, columns): the pairs with an amplitude.
amplitudes : uint8 (8, 2 pairs)
    Bytes of the amplitudes C and S of these pairs in their units, from the least significant byte on, as integers
    without sign: 2 n for n >= 0, otherwise -2 n - 1.

`python -m tools.theories` writes the file.
"""

from __future__ import annotations

import functools
import math
from importlib import resources
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.double_double import PI, DoubleDouble
from poinsot.functions import eccentric_anomaly

__all__ = ["moon_position", "planet_position"]

Array = NDArray[np.float64]

JULIAN_CENTURY = 36525 * 86400.0

OBLIQUITY, NODE = math.radians(23 + 26 / 60 + 21.41136 / 3600), math.radians(-0.05188 / 3600)
"""Of the dynamical ecliptic of VSOP2013 in the ICRF (Simon et al. 2013)."""

PLANETS_TO_ICRF = np.array(
    [
        [math.cos(NODE), -math.sin(NODE) * math.cos(OBLIQUITY), math.sin(NODE) * math.sin(OBLIQUITY)],
        [math.sin(NODE), math.cos(NODE) * math.cos(OBLIQUITY), -math.cos(NODE) * math.sin(OBLIQUITY)],
        [0.0, math.sin(OBLIQUITY), math.cos(OBLIQUITY)],
    ]
)

MOON_TO_FK5 = np.array(
    [
        [1.0, 4.37913e-7, -1.89859e-7],
        [-4.77299e-7, 0.917482137607, -0.397776981701],
        [0.0, 0.397776981701, 0.917482137607],
    ]
)
"""From the dynamical ecliptic of ELP2000-82B."""

BLOCK = 1 << 16
"""Arguments that are evaluated at once, so that their arrays stay in the cache."""

TURN = PI.scaled(2.0)

LONGITUDE = 1
"""Index of the longitude among the variables: a, lambda, k, h, q, p, or distance, longitude, latitude, Q, P."""

GRID = 2.0**-30
"""Unit of the leading part of an angle, turns: its products with integers up to 2^22, and their sums, are exact."""


class Table(NamedTuple):
    """Series of one body: the arrays of the file, with the amplitudes in the units of the variables."""

    angles: Array
    multiples: Array
    columns: NDArray[np.int8]
    amplitudes: Array


def planet_position(name: str, seconds: Array) -> Array:
    """Return the positions of a planet from the Sun in VSOP2013.

    Parameters
    ----------
    name : str
        A planet in lower case, "earth" for the barycentre of Earth and Moon, or "pluto".
    seconds : array (n,)
        Times, TDB from J2000.

    Returns
    -------
    array (3, n), ICRF
        Positions in au.
    """
    a, longitude, k, h, q, p = _variables(name, seconds, 10 * JULIAN_CENTURY)
    eccentricity, periapsis = np.hypot(k, h), np.arctan2(h, k)
    anomaly = np.asarray(eccentric_anomaly(eccentricity, longitude - periapsis))
    along = a * (np.cos(anomaly) - eccentricity)
    across = a * np.sqrt((1 - eccentricity) * (1 + eccentricity)) * np.sin(anomaly)
    cosine, sine = np.cos(periapsis), np.sin(periapsis)
    in_orbit = np.array([along * cosine - across * sine, along * sine + across * cosine, np.zeros_like(a)])
    return PLANETS_TO_ICRF @ _inclined(in_orbit, q, p)


def moon_position(seconds: Array) -> Array:
    """Return the positions of the Moon from the Earth in ELP2000-82B.

    Parameters
    ----------
    seconds : array (n,)
        Times, TDB from J2000.

    Returns
    -------
    array (3, n), mean equator and equinox of J2000 (FK5)
        Positions in km.
    """
    distance, longitude, latitude, q, p = _variables("moon", seconds, JULIAN_CENTURY)
    directions = np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)
    return MOON_TO_FK5 @ _inclined(distance * np.array(directions), q, p)


def _inclined(position: Array, q: Array, p: Array) -> Array:
    """Return positions in an inclined plane in the axes of the reference plane.

    The inclination i and the longitude of the node enter as q = sin(i/2) cos(node) and p = sin(i/2) sin(node).
    """
    x, y, z = position
    cosine = np.sqrt(1 - p * p - q * q)
    return np.array(
        [
            (1 - 2 * p * p) * x + 2 * p * q * y + 2 * p * cosine * z,
            2 * p * q * x + (1 - 2 * q * q) * y - 2 * q * cosine * z,
            -2 * p * cosine * x + 2 * q * cosine * y + (1 - 2 * p * p - 2 * q * q) * z,
        ]
    )


def _variables(name: str, seconds: Array, unit: float) -> Array:
    """Return the variables of a theory, (variables, n), at times in seconds that the series counts in units."""
    table = _table(name)
    size = max(1, BLOCK // len(table.multiples))
    blocks = [seconds[i : i + size] for i in range(0, seconds.size, size)]
    return np.concatenate([_block(table, DoubleDouble(block) / unit) for block in blocks], axis=1)


def _block(table: Table, time: DoubleDouble) -> Array:
    leading, rest = _turns(table.angles, time)
    turns = table.multiples @ leading
    turns -= np.rint(turns)
    turns += table.multiples @ rest
    turns *= 2 * math.pi
    cosines, sines = table.amplitudes
    terms = cosines @ np.cos(turns) + sines @ np.sin(turns)
    variables, powers, _ = table.columns.T
    terms *= time.hi ** powers[:, None]
    sums = np.add.reduceat(terms, np.flatnonzero(np.diff(variables, prepend=-1)))
    sums[LONGITUDE] += 2 * math.pi * (leading[-1] + rest[-1])
    return sums


def _turns(angles: Array, time: DoubleDouble) -> tuple[Array, Array]:
    """Return the angles, (angles, n), without whole turns, as multiples of GRID and the rests."""
    constant, rate, *higher = angles.T[:, :, None]
    small = functools.reduce(lambda total, row: total * time.hi + row, reversed(higher), np.zeros_like(constant))
    turns = (time * rate + constant + small * time.hi**2) / TURN
    turns = turns - np.rint(turns.hi)
    leading = GRID * np.rint(turns.hi / GRID)
    return leading, (turns - leading).hi


@functools.cache
def _table(name: str) -> Table:
    with resources.files("poinsot.orbits").joinpath("theories.npz").open("rb") as file, np.load(file) as arrays:
        angles, multiples, columns, present, bytes_ = (
            arrays[f"{name}_{key}"] for key in ("angles", "multiples", "columns", "present", "amplitudes")
        )
    shape = len(multiples), len(columns)
    mask = np.unpackbits(present, count=math.prod(shape)).astype(bool).reshape(shape)
    integers = np.ascontiguousarray(bytes_.T).view("<u8").reshape(2, -1)
    amplitudes = np.zeros((2, *shape))
    amplitudes[:, mask] = np.where(integers & 1, -1.0, 1.0) * ((integers + (integers & 1)) >> 1)
    amplitudes *= 2.0 ** columns[:, 2]
    return Table(angles, multiples.astype(float), columns, np.ascontiguousarray(amplitudes.swapaxes(1, 2)))
