"""Identification of spectral lines as integer combinations of base frequencies.

The light curve of a tumbling body has lines at n1 f_phi + n2 f_psi (Kaasalainen 2001, A&A 376, 302). Two lines and
their integers determine both frequencies. Each such pair of frequencies is compared with all lines. The frequencies of
pairs whose agreement is least likely by chance are fitted by least squares.

In the long-axis mode the precession of the long axis is f_long = f_phi, in the short-axis mode f_long = f_phi - f_psi
and n1 f_phi + n2 f_psi = n1 f_long + (n1 + n2) f_psi. A homogeneous ellipsoid looks the same after half a turn about
the circled axis, hence n2 is even.
"""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.analysis.line_spectrum import LineSpectrum
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.mechanics.body import Body
from poinsot.propagation.free_motion.periods import MODES, cyclic_order, least_ratio
from poinsot.quantities import AngularVelocities
from poinsot.records.units import PER_TIME

__all__ = ["LineIdentification", "identify_lines"]

Array = NDArray[Any]
Integers = NDArray[np.int_]

MAX_DEVIATION = 4.0
"""Largest difference between a line and its combination, in standard errors."""
START_LINES = 3
"""Number of strongest lines of which two determine the base frequencies."""
MAX_START_ORDER = 4
"""Largest order of a line that determines the base frequencies."""
ODD = 2
"""Increase of the order of a combination by an odd n2."""
STRONGEST = {"short-axis": (2, -2), "long-axis": (2, 0)}
"""Combination of the strongest line of an elongated body."""
MIN_SHORT_AXIS_RATIO = 2.0
"""P_psi/P_phi of any body in the short-axis mode is above this ratio."""
ASSIGNMENTS = 400
"""Number of assignments of integers that are fitted."""
ROUNDS = 6
"""Largest number of assignments to fitted frequencies."""
USUAL = np.log(1e6)
"""Evidence of the usual strongest line of an elongated body."""
MAX_COMBINATIONS = 100_000


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class LineIdentification(Summarized):
    """Lines as integer combinations of base frequencies: one of the alternatives that `identify_lines` returns.

    Attributes
    ----------
    base : array (k,)
        Base frequencies, radians per unit of time. Those found by `identify_lines` are f_phi and f_psi.
    base_errors : array (k,)
        Standard errors of the base frequencies; zero if they were given.
    lines : array (lines,)
        Frequencies of the lines, the strongest first, without the mean.
    line_errors : array (lines,)
        Standard errors of the lines.
    multiples : int array (lines, k)
        Integers of each line, zero for lines without a combination.
    deviations : array (lines,)
        Differences from the combinations in standard errors, NaN for lines without a combination.
    mode : str
        Mode of the free rotation, "short-axis" or "long-axis", or nothing if the base frequencies were given.
    order : int
        Largest sum of the magnitudes of the integers, in the short-axis mode of n1 and n1 + n2.
    evidence : float
        Logarithm of the odds against chance agreement, by which alternatives are ordered.

    Examples
    --------
    >>> times = np.linspace(0, 300, 3001)
    >>> found = pt.analysis.frequencies(np.cos(2 * times) + 0.1 * np.cos(3.1 * times), times, 2)
    >>> pt.analysis.identify_lines(found, base=(1.0, 0.3))[0].multiples.tolist()
    [[2, 0], [4, -3]]
    """

    base: Array
    base_errors: Array
    lines: Array
    line_errors: Array
    multiples: Integers
    deviations: Array
    mode: str
    order: int
    evidence: float

    @property
    def periods(self) -> Array:
        """Periods of the base frequencies; P_phi and P_psi of the circled axis."""
        return 2 * np.pi / self.base

    @property
    def period_errors(self) -> Array:
        """Standard errors of the periods."""
        return self.periods * self.base_errors / self.base

    @property
    def chi2(self) -> float:
        """Sum of the squares of the deviations."""
        return float(np.nansum(self.deviations**2))

    @property
    def explained(self) -> int:
        """Number of lines with a combination."""
        return int(np.count_nonzero(np.isfinite(self.deviations)))

    @checked
    def alternatives(self, line: int) -> Integers:
        """Return all combinations (n, k) within four standard errors of a line, the lowest first."""
        if not -self.lines.size <= line < self.lines.size:
            raise ValueError(f"line must be below the number of lines, {self.lines.size}, got {line}.")
        integers = _combinations(self.base.size, self.order, self.mode)[0]
        error = np.hypot(self.line_errors[line], np.abs(integers) @ self.base_errors)
        near: Integers = integers[np.abs(integers @ self.base - self.lines[line]) <= MAX_DEVIATION * error]
        return near

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        rows = {
            f"{nu:.6g}": "none"
            if not np.any(n)
            else f"{' '.join(f'{x:+d}' for x in n)}, {deviation:+.1f} standard errors"
            for nu, n, deviation in zip(self.lines, self.multiples, self.deviations, strict=True)
        }
        return f"Identification of {self.explained} of {self.lines.size} lines", {
            "base frequencies": formatted(self.base, PER_TIME),
            "periods": formatted(self.periods),
            "standard errors of the periods": formatted(self.period_errors),
            "mode": self.mode,
            "evidence": formatted(self.evidence),
            **rows,
        }


@checked
def identify_lines(
    spectrum: LineSpectrum,
    base: AngularVelocities | None = None,
    *,
    body: Body | None = None,
    order: int = 8,
    count: int = 10,
) -> list[LineIdentification]:
    """Return identifications of lines as integer combinations of base frequencies, the most plausible first.

    Without `base` they are the precession f_phi and the rotation f_psi of a tumbling body, in either mode. Lines alone
    do not distinguish the alternatives. Their order is the order of `evidence`, the sum of -ln p of the lines, where p
    is the probability that a random frequency is within four standard errors of one of the combinations that are as
    simple as the combination of the line. The simplest combinations have the smallest sum |n1| + |n2|, in the
    short-axis mode |n1| + |n1 + n2|; an odd n2 counts two more, because n2 is even for ellipsoids. The strongest line
    of an elongated body is the second harmonic of the precession of the long axis (Pravec et al. 2005, Icarus 173,
    108): 2 f_phi - 2 f_psi in the short-axis mode, 2 f_phi in the long-axis mode. If so, the evidence gains ln 1e6.

    Parameters
    ----------
    spectrum : LineSpectrum
        Lines of one signal.
    base : array (k,), optional
        Known base frequencies, radians per unit of time. The result then has one entry, with the smallest integers.
    body : Body, optional
        Body whose moments limit the ratio of the periods: other pairs are omitted.
    order : int
        Largest sum of the magnitudes of the integers, in the short-axis mode of n1 and n1 + n2.
    count : int
        Largest number of alternatives.

    Returns
    -------
    list of LineIdentification

    Raises
    ------
    TypeError, ValueError
        If the spectrum has several signals, too few lines, or lines without an error, or a base frequency is not
        positive.

    Examples
    --------
    >>> times = np.linspace(0, 300, 3001)
    >>> lines = {2.0: 1.0, 1.1: 0.2, 2.2: 0.1, 0.9: 0.05}
    >>> signal = sum(size * np.cos(rate * times) for rate, size in lines.items())
    >>> found = pt.analysis.identify_lines(pt.analysis.frequencies(signal, times, 4))[0]
    >>> found.mode, found.base.round(3), found.multiples.tolist()
    ('short-axis', array([1.1, 0.1]), [[2, -2], [1, 0], [2, 0], [1, -2]])
    """
    refuse_nonpositive("order", order)
    refuse_nonpositive("count", count)
    nu, errors = _lines_of(spectrum, 1 if base is not None else 2)
    if base is not None:
        known = real_array("base", base, (None,))
        if not known.size:
            raise ValueError("base must have at least one frequency, got none. Leave it out for a tumbling body.")
        refuse_nonpositive("base", known)
        ladder = _Ladder(*_combinations(known.size, order), nu)
        multiples, evidence = ladder.nearest(ladder.integers @ known, np.zeros(len(ladder.integers)), nu, errors)
        off = _deviations(nu, errors, multiples, known)
        none = np.zeros(known.size)
        return [LineIdentification(known, none, nu, errors, multiples, off, "", order, float(evidence))]
    found: dict[tuple[str, bytes], LineIdentification] = {}
    for mode in MODES:
        ladder, least = _Ladder(*_combinations(2, order, mode), nu), _least_ratio(body, mode)
        for multiples in _assignments(nu, errors, ladder) if np.isfinite(least) else ():
            one = _fitted(nu, errors, multiples, ladder, mode, order)
            if one and one.base[0] / one.base[1] > least:
                found.setdefault((mode, one.multiples.tobytes()), one)
    return sorted(found.values(), key=lambda one: (-round(one.evidence, 6), one.chi2))[:count]


def _lines_of(spectrum: LineSpectrum, least: int) -> tuple[Array, Array]:
    """Return the frequencies and the errors of the lines of one signal, without a mean."""
    if spectrum.frequencies.ndim != 1:
        raise ValueError(
            f"spectrum must have the lines of one signal, got shape {spectrum.frequencies.shape}. "
            "Pass each signal alone."
        )
    moving = np.isfinite(spectrum.frequencies) & (spectrum.frequencies != 0)
    nu, errors = spectrum.frequencies[moving], spectrum.errors[moving]
    if nu.size < least:
        raise ValueError(f"spectrum must have at least {least} lines beyond the mean, got {nu.size}.")
    if not np.all(errors > 0):
        raise ValueError(f"spectrum must have positive errors of its lines, got {np.min(errors)}.")
    return nu, errors


def _combinations(count: int, order: int, mode: str = "") -> tuple[Integers, Integers]:
    """Return all integers (n, count) of an order of at most `order`, the simplest first, and how simple each is."""
    if (2 * order + 1) ** count > MAX_COMBINATIONS:
        raise ValueError(
            f"order must have at most {MAX_COMBINATIONS} combinations of {count} base frequencies, got {order}."
        )
    every = np.array(list(itertools.product(range(-order, order + 1), repeat=count)))
    size = np.sum(np.abs(every), axis=1)
    every, size = every[(size > 0) & (size <= order)], size[(size > 0) & (size <= order)]
    if mode == "short-axis":  # from multiples of f_long and f_psi
        every = every @ np.array([[1, -1], [0, 1]])
    complexity = size + ODD * (every[:, -1] % 2) if mode else size
    simplest = np.argsort(complexity, kind="stable")
    return every[simplest], complexity[simplest]


class _Ladder:
    """Combinations, the simplest first, and the probability of a chance agreement with one of the first of them."""

    def __init__(self, integers: Integers, complexity: Integers, nu: Array) -> None:
        self.integers, self.complexity = integers, complexity
        as_simple = np.searchsorted(complexity, complexity, side="right")
        self.density = (
            as_simple * MAX_DEVIATION / np.max(np.abs(nu))
        )  # half of the combinations are positive, and two sides

    def nearest(self, values: Array, own: Array, nu: Array, errors: Array) -> tuple[Integers, Array]:
        """Return the simplest combination of each line within its error, zero without one, and the evidence.

        The values (..., n) of combinations have errors of their own.
        """
        variance = own[..., None, :] ** 2 + errors[:, None] ** 2
        near = (values[..., None, :] - nu[:, None]) ** 2 <= MAX_DEVIATION**2 * variance
        first = np.argmax(near, axis=-1)
        has_one = np.any(near, axis=-1)
        chance = self.density[first] * np.sqrt(np.take_along_axis(variance, first[..., None], axis=-1)[..., 0])
        evidence = np.sum(-np.log(np.minimum(chance, 1.0)), axis=-1, where=has_one)
        return np.where(has_one[..., None], self.integers[first], 0), evidence


def _assignments(nu: Array, errors: Array, ladder: _Ladder) -> Integers:
    """Return the integers (m, lines, 2) of the assignments with the largest evidence, which pairs of lines start."""
    integers = ladder.integers
    starts = integers[ladder.complexity <= MAX_START_ORDER]
    found, evidences = [np.empty((0, nu.size, 2), int)], [np.empty(0)]
    pairs = {*itertools.combinations(range(min(nu.size, START_LINES)), 2), *((0, j) for j in range(1, nu.size))}
    for i, j in sorted(pairs):
        for first in starts:
            both = np.stack([np.broadcast_to(first, starts.shape), starts], axis=1)
            both = both[both[:, 0, 0] * both[:, 1, 1] != both[:, 0, 1] * both[:, 1, 0]]
            inverse = np.linalg.inv(both)
            inverse = inverse[np.all(inverse @ nu[[i, j]] > 0, axis=1)]
            parts = integers @ inverse
            multiples, evidence = ladder.nearest(
                parts @ nu[[i, j]], np.sqrt(parts**2 @ errors[[i, j]] ** 2), nu, errors
            )
            best = np.argsort(-evidence)[:ASSIGNMENTS]
            found.append(multiples[best])
            evidences.append(evidence[best])
    order = np.argsort(-np.concatenate(evidences), kind="stable")
    _, first_of_each = np.unique(np.concatenate(found)[order], axis=0, return_index=True)
    return np.concatenate(found)[order][np.sort(first_of_each)][:ASSIGNMENTS]


def _fitted(
    nu: Array, errors: Array, multiples: Integers, ladder: _Ladder, mode: str, order: int
) -> LineIdentification | None:
    """Return the identification with fitted base frequencies, to which the integers are assigned again."""
    for _ in range(ROUNDS):
        used = np.any(multiples, axis=1)
        design = multiples[used] / errors[used, None]
        if np.linalg.matrix_rank(design) < 2:
            return None
        covariance = np.linalg.inv(design.T @ design)
        base, base_errors = covariance @ design.T @ (nu[used] / errors[used]), np.sqrt(np.diag(covariance))
        if not np.all(base > MAX_DEVIATION * base_errors):
            return None
        own = np.sqrt(np.sum((ladder.integers @ covariance) * ladder.integers, axis=1))
        before, (multiples, evidence) = multiples, ladder.nearest(ladder.integers @ base, own, nu, errors)
        if np.array_equal(multiples, before):
            break
    else:
        return None
    strongest = tuple(multiples[0].tolist()) == STRONGEST[mode]
    weight, deviations = float(evidence) + USUAL * strongest, _deviations(nu, errors, multiples, base)
    return LineIdentification(base, base_errors, nu, errors, multiples, deviations, mode, order, weight)


def _least_ratio(body: Body | None, mode: str) -> float:
    """Return the smallest P_psi/P_phi in a mode of a body, or of any body; infinite without the mode."""
    if body is None:
        return MIN_SHORT_AXIS_RATIO if mode == "short-axis" else 0.0
    moments = real_array("moments of the body", body.moments, (3,))
    third = np.argmax(moments) if mode == "short-axis" else np.argmin(moments)
    if np.count_nonzero(moments == moments[third]) > 1:
        return np.inf
    return float(least_ratio(moments[cyclic_order(moments, mode)], mode))


def _deviations(nu: Array, errors: Array, multiples: Integers, base: Array) -> Array:
    """Return the differences of lines from their combinations in standard errors, NaN without a combination."""
    return np.where(np.any(multiples, axis=1), (nu - multiples @ base) / errors, np.nan)
