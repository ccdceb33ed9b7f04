"""The first sign change of a Taylor polynomial within a step, in LLVM's representation.

The search goes from the start by as much as the slope and a bound of the second derivative allow, less what rounding
and truncation may be: it comes up to a zero from before it, quadratically, and passes none, however close the next one.
"""

from __future__ import annotations

import functools
import math

from poinsot.taylor.llvm_ir import INTEGER, Array, Value

__all__ = ["first_change"]

ROUNDING = 2.0**-50
"""What rounding may be of the value of a polynomial, relative to the sum of its terms' sizes."""

TRUNCATED, NEXT = 1e-7, 2.0**-5
"""The largest share of the last four terms in that sum for which a polynomial stands for its function, and what part of
these the rest of the series is at most then."""

MOST_ADVANCES = 60
"""Near a minimum that touches zero each advance leaves a third of the way; a step that ends there is as good as any."""

RESOLVED, CERTAIN = 0.25, 2.0
"""The least advance, and how close a zero is taken for certain, in parts of the time within which all is at once."""


class _Series:
    """A polynomial of the share of a step.

    Attributes
    ----------
    unit : vector
        The part of the step that the shares are of: shorter where the series hardly converges.
    total : vector
        The sum of the sizes of its terms.
    curvature, beyond : vectors
        Bounds of the second derivative and of the rest of the series, relative to that.
    """

    def __init__(self, coefficients: Value, h: Value, at_once: Value, orders: int, lanes: int) -> None:
        self._lines, self._terms, self._orders, self._lanes = h.function, Array(coefficients, h.type), orders, lanes
        self._at_once, one = at_once, h.like(1.0)
        self.unit, self.total, bend, tail = self._lines.repeat(
            [one, *self._scaled(h)], lambda unit, total, _, tail: self._is_poor(unit, total, tail).any(), self._halved
        )
        self.curvature = (bend / self.total).larger(1e-300)
        self.beyond = NEXT * tail / self.total

    def _is_poor(self, unit: Value, total: Value, tail: Value) -> Value:
        return (tail.is_("gt", TRUNCATED * total) | total.is_("eq", math.inf)) & unit.is_("gt", self._at_once)

    def _halved(self, unit: Value, total: Value, _: Value, tail: Value) -> list[Value]:
        factor = self._is_poor(unit, total, tail).choose(unit.like(0.5), 1.0)
        return [unit * factor, *self._scaled(factor)]

    def _scaled(self, factor: Value) -> list[Value]:
        """Multiply the terms by powers; return the sum of sizes, a bound of the second derivative, the last sizes."""

        def scale(n: Value, power: Value, total: Value, bend: Value, *last: Value) -> list[Value]:
            self._terms[n] = term = self._terms[n] * power
            weight = (n * (n - 1)).to_double().spread(self._lanes)
            return [n + 1, power * factor, total + abs(term), weight.fma(abs(term), bend), *last[1:], abs(term)]

        one, zero = factor.like(1.0), factor.like(0.0)
        lowest = [self._lines.constant(INTEGER, 0), one, zero, zero, *[zero] * 4]
        _, _, total, bend, *last = self._lines.repeat(lowest, lambda n, *_: n.is_("lt", self._orders), scale)
        return [total, bend, functools.reduce(Value.larger, last)]

    def at(self, share: Value, side: Value) -> list[Value]:
        """Return value, slope, error and the slope of the error, relative to the sum of the sizes."""

        def lower(n: Value, value: Value, slope: Value, size: Value) -> list[Value]:
            term = self._terms[n]
            return [n - 1, value.fma(share, term), slope.fma(share, value), size.fma(share, abs(term))]

        highest = [self._lines.constant(INTEGER, self._orders - 1), *[share.like(0.0)] * 3]
        _, value, slope, size = self._lines.repeat(highest, lambda n, *_: n.is_("ge", 0), lower)
        power, doublings = share, self._orders.bit_length() - 1
        for _ in range(doublings):
            power = power * power
        truncated = self.beyond * power
        error = ROUNDING * size / self.total + truncated
        return [side * value / self.total, side * slope / self.total, error, 2.0**doublings * truncated / share]


def first_change(coefficients: Value, h: Value, side: Value, at_once: Value, orders: int, lanes: int) -> Value:
    """Return up to which share of a step a function keeps its sign, and 1 if the sign changes there.

    It is at a zero of the function, or before one that truncation makes uncertain, where the sign does not change.
    The share is 1 if it keeps it to the end, and 0 if it has another one at the start, or just behind a zero there.

    Parameters
    ----------
    coefficients : address of vectors (orders,)
        Those of the function; they are overwritten.
    h : vector
        The length of the step, negative backwards.
    side : vector
        The sign that the function has, 1 or -1.
    at_once : vector
        The share of the step in which all happens at once.
    """
    lines, one, zero = h.function, h.like(1.0), h.like(0.0)
    start = side * Array(coefficients, h.type)[0]
    series = _Series(coefficients, h, at_once, orders, lanes)
    total, unit = series.total, series.unit
    at_once = at_once / unit
    finite = (0.0 * total).is_("eq", 0.0)
    watched = (2.0 * start).is_("le", total) & finite & total.is_("gt", 0.0)

    def search() -> list[Value]:
        curvature = series.curvature + orders**2 * series.beyond
        first = series.at(at_once, side)
        wrong = watched & first[0].is_("lt", 0.0)
        going = watched & ~wrong & at_once.is_("lt", 1.0)

        def advance(left: Value, going: Value, share: Value, *found: Value) -> list[Value]:
            value, slope, error, increase = found
            room, slope = value - error, slope - increase
            root = (slope * slope + 2.0 * curvature * room).intrinsic("sqrt")
            rising = slope.is_("ge", 0.0)
            ahead = rising.choose((slope + root) / curvature, 2.0 * room / (root - slope))
            further = going & room.is_("gt", 0.0) & ahead.is_("gt", RESOLVED * at_once)
            share = further.choose((share + ahead).smaller(1.0), share)
            moved = [further.choose(new, old) for new, old in zip(series.at(share, side), found, strict=True)]
            return [left - 1, further & share.is_("lt", 1.0), share, *moved]

        begin = [lines.constant(INTEGER, MOST_ADVANCES), going, at_once, *first]
        _, _, share, value, slope, *_ = lines.repeat(
            begin, lambda left, going, *_: left.is_("gt", 0) & going.any(), advance
        )
        changes = share.is_("lt", 1.0) & slope.is_("lt", 0.0) & (value + CERTAIN * slope * at_once).is_("lt", 0.0)
        share = changes.choose((share - value / slope).larger(at_once), share).smaller(1.0)
        share = wrong.choose(zero, watched.choose(share * unit, unseen))
        return [share, (watched & changes & ~wrong).choose(one, zero)]

    # The rates of the other branch may be no numbers.
    unseen = (~finite & start.is_("lt", 0.0)).choose(zero, finite.choose(unit, one))
    return lines.struct(*lines.either(watched.any(), [unseen, zero], search))
