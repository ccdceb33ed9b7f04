"""Write the tables of VSOP2013 and ELP2000-82B in the package from heyoka's formulas: `python -m tools.theories`.

Requires heyoka and SymPy. heyoka contains the coefficients of both theories and truncates them at a threshold.
`poinsot.orbits.theories` describes the tables and evaluates them.
"""

from __future__ import annotations

import functools
import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import heyoka as hy
import numpy as np
import sympy
from numpy.typing import NDArray

TABLES = Path(__file__).parents[1] / "src" / "poinsot" / "orbits" / "theories.npz"

PLANETS = {
    "mercury": (1, 1e-9),
    "venus": (2, 1e-9),
    "earth": (3, 1e-9),
    "mars": (4, 1e-9),
    "jupiter": (5, 1e-9),
    "saturn": (6, 1e-8),
    "uranus": (7, 1e-8),
    "neptune": (8, 1e-8),
    "pluto": (9, 1e-7),
}
"""Number in VSOP2013, and the smallest amplitude in the tables: au for the semi-major axis, otherwise dimensionless."""

MOON_THRESHOLD = 1e-7
"""Smallest amplitude of the terms of ELP2000-82B, relative to the largest one."""

PLANET_RESOLUTION, MOON_RESOLUTION = 5e-16, 1e-10
"""Largest displacements by the units of the amplitudes within 6000 years from J2000: au for planets, km for the Moon.
"""

LARGE = 512
"""Largest multiple of an angle, so that its rounding error stays small: a power of two."""

LONGITUDE = 1
"""Index of the variable whose polynomial of time becomes the last angle, because it is many turns."""

Polynomial = tuple[float, ...]
"""Coefficients of the powers of time, from the constant on."""

Angle = frozenset[tuple[Polynomial, int]]
"""Sum of integer multiples of polynomials of time, radians."""

Series = dict[tuple[Angle, int], complex]
"""Coefficients of exp(i angle) T^power."""

CONSTANT: tuple[Angle, int] = (frozenset(), 0)


def tree(formula: Any) -> Any:
    """Return the expression tree of heyoka as SymPy's, with all numbers and operations unchanged."""
    with sympy.evaluate(False):
        return hy.to_sympy(formula)


def coefficients(terms: Series) -> Polynomial:
    """Return the coefficients of a series that is a polynomial of time."""
    found = [0.0] * (1 + max(power for _, power in terms))
    for (angle, power), value in terms.items():
        if angle or value.imag:
            raise ValueError(f"terms must be a polynomial of time, got an angle {sorted(angle)} with {value}.")
        found[power] = value.real
    return tuple(found)


def angle_of(node: Any) -> dict[Polynomial, int]:
    """Return the multiples of the fundamental angles in the argument of a sine or cosine.

    A fundamental angle is a polynomial of time: a number plus multiples of powers, or a number times time.
    """
    factor, rest = node.args if node.is_Mul and len(node.args) == 2 else (sympy.S.One, node)
    if node.is_Mul and factor.is_Number and not rest.is_Symbol:
        number = float(factor)
        if not number.is_integer():
            raise ValueError(f"node must be a multiple by an integer, got {shortened(node)}.")
        return {base: int(number) * count for base, count in angle_of(rest).items()}
    if node.is_Add and not any(part.is_Number for part in node.args):
        total: dict[Polynomial, int] = defaultdict(int)
        for part in node.args:
            for base, count in angle_of(part).items():
                total[base] += count
        return total
    return {coefficients(series(node)): 1}


def shortened(node: Any) -> str:
    """Return the first characters of a formula."""
    return str(node)[:200]


def product(a: Series, b: Series) -> Series:
    """Return the product of two series."""
    return combined(
        ((added(first, second), power + other), x * y)
        for (first, power), x in a.items()
        for (second, other), y in b.items()
    )


def combined(terms: Iterable[tuple[tuple[Angle, int], complex]]) -> Series:
    """Return the series of some terms, without coefficients that are zero."""
    total: Series = defaultdict(complex)
    for key, value in terms:
        total[key] += value
    return {key: value for key, value in total.items() if value != 0}


@functools.cache
def added(a: Angle, b: Angle) -> Angle:
    """Return the sum of two angles."""
    total: dict[Polynomial, int] = defaultdict(int)
    for base, count in (*a, *b):
        total[base] += count
    return frozen(total)


def frozen(multiples: dict[Polynomial, int]) -> Angle:
    """Return the angle from the multiples of its fundamental angles."""
    return frozenset((base, count) for base, count in multiples.items() if count)


KNOWN: dict[int, tuple[Any, Series]] = {}
"""Series of nodes by their identity, each with the node, because nodes of the Moon's formulas have many parents."""


def series(node: Any) -> Series:
    """Return the Poisson series of a formula."""
    if id(node) not in KNOWN:
        KNOWN[id(node)] = node, _series(node)
    return KNOWN[id(node)][1]


def _series(node: Any) -> Series:
    if node.is_Number:
        return {CONSTANT: complex(float(node))}
    if node.is_Symbol:
        return {(frozenset(), 1): 1.0 + 0.0j}
    if node.is_Add:
        return combined((key, value) for part in node.args for key, value in series(part).items())
    if node.is_Mul:
        return functools.reduce(product, map(series, node.args))
    if node.is_Pow:
        return power_of(series(node.base), int(node.exp))
    if isinstance(node, sympy.cos | sympy.sin):
        forward = angle_of(node.args[0])
        plus, minus = frozen(forward), frozen({base: -count for base, count in forward.items()})
        half = 0.5 + 0.0j if isinstance(node, sympy.cos) else -0.5j
        return {(plus, 0): half, (minus, 0): half.conjugate()}
    raise ValueError(f"node must be a number, time, sum, product, power, sine or cosine, got {shortened(node)}.")


def power_of(base: Series, exponent: int) -> Series:
    """Return an integer power of a series; of a number if it is negative."""
    if exponent < 0:
        if set(base) != {CONSTANT}:
            raise ValueError(f"exponent must not be negative for a series that depends on time, got {exponent}.")
        return {CONSTANT: base[CONSTANT] ** exponent}
    return functools.reduce(product, [base] * exponent, {CONSTANT: 1.0 + 0.0j})


def table(variables: Sequence[Series], sizes: NDArray[np.float64], span: float) -> dict[str, NDArray[Any]]:
    """Return the arrays of a body, see `poinsot.orbits.theories`.

    Parameters
    ----------
    variables : sequence of Series
    sizes : array (variables,)
        Displacement of the body by 1 in each variable, over the resolution.
    span : float
        Largest time.
    """
    variables = list(variables)
    turning = {key: value for key, value in variables[LONGITUDE].items() if not key[0]}
    variables[LONGITUDE] = {key: value for key, value in variables[LONGITUDE].items() if key[0]}
    used = {angle for variable in variables for angle, _ in variable}
    bases = sorted({base for angle in used for base, _ in small_multiples(angle)})
    bases.append(coefficients(turning))
    angles = np.zeros((len(bases), max(map(len, bases))))
    for i, base in enumerate(bases):
        angles[i, : len(base)] = base

    entries: dict[tuple[tuple[int, ...], tuple[int, int]], complex] = {}
    for i, variable in enumerate(variables):
        for (angle, power), value in variable.items():
            counts = dict(small_multiples(angle))
            row = tuple(counts.get(base, 0) for base in bases)
            first = next(filter(None, row), 0)
            if first >= 0:  # the conjugate term, whose angle is the negative one, contains the same numbers
                entries[row, (i, power)] = (2 if first else 1) * value
    rows, columns = (sorted(set(keys)) for keys in zip(*entries, strict=True))
    rows.reverse()  # so that sums add the constants, which are the largest terms, last: smaller rounding errors
    units = np.array([math.floor(-math.log2(sizes[i] * span**power)) for i, power in columns])
    values = np.zeros((2, len(rows), len(columns)))
    for (row, column), value in entries.items():
        values[:, rows.index(row), columns.index(column)] = value.real, -value.imag
    integers = np.rint(values / 2.0**units).astype(np.int64)
    present = np.any(integers != 0, axis=0)
    unsigned = np.where(integers < 0, -2 * integers - 1, 2 * integers)[:, present].astype("<u8")
    multiples, factors = split(np.array(rows))
    return {
        "angles": angles,
        "multiples": multiples.astype(np.int16),
        "factors": factors.astype(np.int16),
        "columns": np.column_stack([columns, units]).astype(np.int8),
        "present": np.packbits(present),
        "amplitudes": np.ascontiguousarray(unsigned.reshape(-1, 1).view(np.uint8).T),
    }


def small_multiples(angle: Angle) -> Angle:
    """Return the same angle with multiples of at most LARGE, of fundamental angles and of 2 LARGE times these.

    Pluto's arguments are multiples of a single angle, up to 362731.
    """
    found: dict[Polynomial, int] = defaultdict(int)
    for base, count in angle:
        many = round(count / (2 * LARGE)) if abs(count) > LARGE else 0
        found[base] += count - 2 * LARGE * many
        found[tuple(2 * LARGE * x for x in base)] += many
    return frozen(found)


def split(rows: NDArray[np.int_]) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Return few parts and, for each row, the two parts whose sum it is, (2, rows).

    Each angle occurs in the first or in the second parts only. Angles change sides while that makes fewer parts.
    """
    first = np.arange(rows.shape[1]) % 2 == 0

    def parts(first: NDArray[np.bool_]) -> list[tuple[NDArray[np.int_], NDArray[np.int_]]]:
        return [np.unique(np.where(side, rows, 0), axis=0, return_inverse=True) for side in (first, ~first)]

    def count(first: NDArray[np.bool_]) -> int:
        return sum(len(found) for found, _ in parts(first))

    while True:
        others = [first ^ (np.arange(len(first)) == i) for i in range(len(first))]
        best = min(others, key=count)
        if count(best) >= count(first):
            break
        first = best
    (one, which), (two, other) = parts(first)
    return np.concatenate([one, two]), np.array([which.ravel(), len(one) + other.ravel()])


def planet(number: int, threshold: float) -> dict[str, NDArray[Any]]:
    """Return the arrays of a planet: a in au, lambda, k, h, q, p; times in millennia."""
    time = hy.make_vars("T")
    formulas = [hy.model.vsop2013_elliptic(number, i, time_expr=time, thresh=threshold) for i in range(1, 7)]
    variables = [series(tree(formula)) for formula in formulas]
    semimajor_axis = variables[0][CONSTANT].real
    return table(variables, np.array([1.0, *[semimajor_axis] * 5]) / PLANET_RESOLUTION, 6.0)


def moon(threshold: float) -> dict[str, NDArray[Any]]:
    """Return the arrays of the Moon: distance r in km, longitude V, latitude U, Laskar's Q and P; times in centuries.

    They are in z = -2 P c (r cos U) cos V + 2 Q c (r cos U) sin V + (1 - 2 P^2 - 2 Q^2) (r sin U).
    """
    time = hy.make_vars("T")
    along, across, above = tree(hy.model.elp2000_cartesian_e2000(time_expr=time, thresh=threshold)[2]).args
    p, q = (term.args[0].args[0].args[1] for term in (along, across))
    longitude = across.args[1].args[1].args[0]
    distance, sine = above.args[1].args
    variables = [series(node) for node in (distance, longitude, sine.args[0], q, p)]
    mean_distance = variables[0][CONSTANT].real
    return table(variables, np.array([1.0, *[mean_distance] * 4]) / MOON_RESOLUTION, 60.0)


def main() -> None:
    """Write the tables."""
    tables = {name: planet(*how) for name, how in PLANETS.items()}
    tables["moon"] = moon(MOON_THRESHOLD)
    arrays: dict[str, Any] = {f"{name}_{key}": array for name, found in tables.items() for key, array in found.items()}
    np.savez_compressed(TABLES, **arrays)
    print(f"{TABLES}: {TABLES.stat().st_size} bytes")


if __name__ == "__main__":
    main()
