"""Identification of spectral lines as integer combinations of base frequencies.

The light curve of a tumbling body has lines at n1 f_phi + n2 f_psi (Kaasalainen 2001, A&A 376, 302). Two lines and
their integers determine both frequencies. Each such pair of frequencies is compared with all lines. The frequencies of
pairs that agree with most lines are fitted by least squares, as Pravec et al. (2005, Icarus 173, 108) do.

Pairs are searched as the precession of the long axis, f_long, and f_psi. In the long-axis mode f_phi = f_long, in the
short-axis mode f_phi = f_long + f_psi and n1 f_long + n2 f_psi = n1 f_phi + (n2 - n1) f_psi.
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
"""Largest |n1| + |n2| of a line that determines the base frequencies."""
MIN_SHORT_AXIS_RATIO = 2.0
"""P_psi/P_phi of any body in the short-axis mode is above this ratio."""
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
        integers = _of_mode(_combinations(self.base.size, self.order), self.mode)
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
    do not distinguish the alternatives. First come those that explain most lines; of these, those whose strongest line
    is the second harmonic of the precession of the long axis, as of elongated bodies (Pravec et al. 2005, Icarus 173,
    108): 2 f_phi - 2 f_psi in the short-axis mode and 2 f_phi in the long-axis mode; then those with the smallest
    integers. An odd integer counts two more, because light curves of ellipsoids have even integers of f_psi.

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
    >>> signal = np.cos(2 * times) + 0.3 * np.cos(2.2 * times) + 0.1 * np.cos(1.8 * times)
    >>> found = pt.analysis.identify_lines(pt.analysis.frequencies(signal, times, 3))[0]
    >>> found.mode, found.base.round(3), found.multiples.tolist()
    ('short-axis', array([1.1, 0.1]), [[2, -2], [2, 0], [2, -4]])
    """
    refuse_nonpositive("order", order)
    refuse_nonpositive("count", count)
    nu, errors = _lines_of(spectrum, 1 if base is not None else 2)
    if base is not None:
        known = real_array("base", base, (None,))
        refuse_nonpositive("base", known)
        integers = _combinations(known.size, order)
        multiples, _ = _nearest(integers @ known, np.zeros(len(integers)), integers, nu, errors)
        off = _deviations(nu, errors, multiples, known)
        return [LineIdentification(known, np.zeros(known.size), nu, errors, multiples, off, "", order)]
    found = [
        one for multiples in _assignments(nu, errors, order) for one in _fitted(nu, errors, multiples, body, order)
    ]
    return sorted(found, key=_rank)[:count]


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


def _combinations(count: int, order: int) -> Integers:
    """Return all integers (n, count) with a sum of magnitudes from 1 to `order`, the smallest first."""
    if (2 * order + 1) ** count > MAX_COMBINATIONS:
        raise ValueError(
            f"order must have at most {MAX_COMBINATIONS} combinations of {count} base frequencies, got {order}."
        )
    every = np.array(list(itertools.product(range(-order, order + 1), repeat=count)))
    size = np.sum(np.abs(every), axis=1)
    every = every[(size > 0) & (size <= order)]
    ordered: Integers = every[np.argsort(_complexity(every), kind="stable")]
    return ordered


def _complexity(integers: Integers) -> Integers:
    """Return the sum of the magnitudes of integers, in which odd ones count two more."""
    total: Integers = np.sum(np.abs(integers) + 2 * (integers % 2), axis=-1)
    return total


def _of_mode(integers: Integers, mode: str) -> Integers:
    """Return the integers of f_phi and f_psi from the integers of f_long and f_psi; see the top of the module."""
    turn = np.array([[1, -1], [0, 1]]) if mode == "short-axis" else np.eye(integers.shape[-1], dtype=int)
    turned: Integers = integers @ turn
    return turned


def _nearest(values: Array, own: Array, integers: Integers, nu: Array, errors: Array) -> tuple[Integers, Integers]:
    """Return the simplest combination of each line within its error, and the number of lines with one.

    Integers of lines without one are zero. The values (..., n) of combinations have errors of their own.
    """
    off = np.abs(values[..., None, :] - nu[:, None]) <= MAX_DEVIATION * np.hypot(own[..., None, :], errors[:, None])
    first = np.argmax(off, axis=-1)
    has_one = np.any(off, axis=-1)
    return np.where(has_one[..., None], integers[first], 0), np.count_nonzero(has_one, axis=-1)


def _assignments(nu: Array, errors: Array, order: int) -> Integers:
    """Return the integers (m, lines, 2) by which two frequencies explain as many lines as possible."""
    starts, integers = _combinations(2, min(order, MAX_START_ORDER)), _combinations(2, order)
    found: list[Integers] = []
    most = 0
    for i, j in itertools.combinations(range(min(nu.size, START_LINES)), 2):
        for first in starts:
            pairs = np.stack([np.broadcast_to(first, starts.shape), starts], axis=1)
            pairs = pairs[pairs[:, 0, 0] * pairs[:, 1, 1] != pairs[:, 0, 1] * pairs[:, 1, 0]]
            inverse = np.linalg.inv(pairs)
            base = inverse @ nu[[i, j]]
            usable = np.all(base > 0, axis=1)
            parts = integers @ inverse[usable]
            own = np.sqrt(parts**2 @ errors[[i, j]] ** 2)
            multiples, explained = _nearest(parts @ nu[[i, j]], own, integers, nu, errors)
            if explained.size and (now := int(np.max(explained))) >= most:
                found = found if now == most else []
                most = now
                found.append(multiples[explained == most])
    return np.unique(np.concatenate(found), axis=0) if found else np.empty((0, nu.size, 2), int)


def _fitted(nu: Array, errors: Array, along: Integers, body: Body | None, order: int) -> list[LineIdentification]:
    """Return the identifications with fitted base frequencies, in each mode in which a body can have them.

    The integers are those of f_long and f_psi.
    """
    used = np.any(along, axis=1)
    design = along[used] / errors[used, None]
    if np.linalg.matrix_rank(design) < 2:
        return []
    covariance = np.linalg.inv(design.T @ design)
    base = covariance @ design.T @ (nu[used] / errors[used])
    deviations = _deviations(nu, errors, along, base)
    if np.nanmax(np.abs(deviations)) > MAX_DEVIATION:
        return []
    found = []
    for mode in MODES:
        turn = np.array([[1, 1], [0, 1]]) if mode == "short-axis" else np.eye(2)  # f_phi, f_psi of f_long, f_psi
        own, own_errors = turn @ base, np.sqrt(np.diag(turn @ covariance @ turn.T))
        if np.all(own > MAX_DEVIATION * own_errors) and own[0] / own[1] > _least_ratio(body, mode):
            multiples = _of_mode(along, mode)
            found.append(LineIdentification(own, own_errors, nu, errors, multiples, deviations, mode, order))
    return found


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


def _rank(found: LineIdentification) -> tuple[float, ...]:
    """Return the numbers by which identifications are ordered."""
    along_long_axis = found.multiples @ np.array([[1, 1], [0, 1]]) if found.mode == "short-axis" else found.multiples
    usual = tuple(along_long_axis[0].tolist()) == (2, 0)
    return -found.explained, not usual, int(np.sum(_complexity(along_long_axis))), found.chi2
