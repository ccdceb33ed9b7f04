"""Positions of the planets from VSOP2013 and of the Moon from ELP2000-82B, evaluated with NumPy.

Sources: Simon, Francou, Fienga and Manche 2013, A&A 557, A49 (planets); Chapront-Touze and Chapront 1983, A&A 124, 50
(Moon). The variables are Poisson series

    x_i = sum T^k (C_jk cos phi_j + S_jk sin phi_j),  phi_j = sum n_jl angle_l(T)

with integers n_jl and polynomials angle_l of the time T in TDB from J2000. `theories.npz` contains for each body, after
its name:

angles : float64 (angles, powers)
    Coefficients of the polynomials, radians. The last one is a part of the longitude.
multiples : int16 (parts, angles)
    Integers of parts of arguments.
factors : int16 (2, arguments)
    The two parts whose sum is phi_j. There are fewer parts than arguments, so that exp(i phi_j) is faster as a product.
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
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.double_double import PI, DoubleDouble
from poinsot.functions import eccentric_anomaly
from poinsot.quantities import Array

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["moon_position", "planet_position"]

JULIAN_CENTURY = 36525 * 86400.0

OBLIQUITY, NODE = math.radians(23 + 26 / 60 + 21.41136 / 3600), math.radians(-0.05188 / 3600)
"""Rotation from the dynamical ecliptic of VSOP2013 in the ICRF (Simon et al. 2013)."""

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
"""Rotation from the dynamical ecliptic of ELP2000-82B."""

TURN = PI.scaled(2.0)

LONGITUDE = 1
"""Index of the longitude among the variables: a, lambda, k, h, q, p, or distance, longitude, latitude, Q, P."""

ARGUMENTS_PER_BLOCK = 1 << 16
"""Number of arguments evaluated together, so that the arrays stay in the cache."""


class SeriesTable(NamedTuple):
    """Series of one body: the arrays of the file, with angles in turns and amplitudes C - i S of exp(i phi)."""

    angles: list[DoubleDouble]
    multiples: csr_array
    factors: NDArray[np.int16]
    columns: NDArray[np.int8]
    amplitudes: csr_array


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
    arguments = len(table.factors[0])
    size = ARGUMENTS_PER_BLOCK // arguments
    blocks = np.resize(seconds, (-(-seconds.size // size), size))
    waves = np.empty((2, arguments, size), dtype=complex)
    values = np.empty((1 + table.columns[-1, 0], *blocks.shape))
    for i, block in enumerate(blocks):
        values[:, i] = _block(table, DoubleDouble(block) / unit, waves)
    return values.reshape(len(values), -1)[:, : seconds.size]


def _block(table: SeriesTable, time: DoubleDouble, waves: NDArray[np.complex128]) -> Array:
    """Return the variables at some times; `waves` is memory for the product of two factors."""
    angles = _turns(table, time)
    turns = table.multiples @ angles
    turns -= np.rint(turns)
    turns *= 2 * math.pi
    factors = np.empty(turns.shape, dtype=complex)
    np.cos(turns, out=factors.real)
    np.sin(turns, out=factors.imag)
    first, second = waves
    for wave, which in zip(waves, table.factors, strict=True):
        np.take(factors, which, axis=0, out=wave, mode="clip")
    first *= second
    sums = (table.amplitudes @ first).real
    variables, powers, _ = table.columns.T
    sums *= np.vander(time.hi, 1 + np.max(powers), increasing=True).T[powers]
    totals: Array = np.add.reduceat(sums, np.flatnonzero(np.diff(variables, prepend=-1)))
    totals[LONGITUDE] += 2 * math.pi * angles[-1]
    return totals


def _turns(table: SeriesTable, time: DoubleDouble) -> Array:
    """Return the angles in turns, without whole turns, (angles, n)."""
    constant, rate, *higher = table.angles
    linear = DoubleDouble.product(time.hi, rate.hi)
    curved = functools.reduce(lambda total, row: total * time.hi + row.hi, reversed(higher), 0.0) * time.hi**2
    rest = linear.lo + (time.hi * rate.lo + time.lo * rate.hi) + curved + constant.hi
    turns = (linear.hi - np.rint(linear.hi)) + rest
    return np.asarray(turns - np.rint(turns))


@functools.cache
def _table(name: str) -> SeriesTable:
    from scipy.sparse import csr_array  # the products do not depend on the number of threads or on the block

    with resources.files("poinsot.orbits").joinpath("theories.npz").open("rb") as file, np.load(file) as arrays:
        angles, multiples, factors, columns, present, digits = (
            arrays[f"{name}_{key}"] for key in ("angles", "multiples", "factors", "columns", "present", "amplitudes")
        )
    shape = factors.shape[1], len(columns)
    mask = np.unpackbits(present, count=math.prod(shape)).astype(bool).reshape(shape)
    unsigned = np.ascontiguousarray(digits.T).view("<u8").reshape(2, -1)
    odd = unsigned & 1
    cosine, sine = np.where(odd, -1.0, 1.0) * ((unsigned + odd) >> 1)
    amplitudes = np.zeros(shape, dtype=complex)
    amplitudes[mask] = cosine - 1j * sine
    amplitudes *= 2.0 ** columns[:, 2]
    return SeriesTable(
        [DoubleDouble(power[:, None]) / TURN for power in angles.T],
        csr_array(multiples.astype(float)),
        factors,
        columns,
        csr_array(amplitudes.T),
    )
