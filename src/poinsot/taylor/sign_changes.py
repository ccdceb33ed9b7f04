"""The first sign change of a Taylor polynomial within a step, in LLVM's representation.

The search advances from the start by as much as the slope and a bound of the second derivative allow, less the bounds
of rounding and truncation errors. It converges to the first zero from before it, quadratically, and passes no zero,
however close the next one is.
"""

from __future__ import annotations

import functools
import math

from poinsot.taylor.llvm_ir import INTEGER, Array, Value

__all__ = ["first_change"]

ROUNDING_BOUND = 2.0**-50
"""Bound of the rounding error of a polynomial, relative to the sum of the sizes of its terms."""

MAX_TRUNCATED, NEXT = 1e-7, 2.0**-5
"""The largest share of the last four terms in that sum for which a polynomial stands for its function, and what part of
these the rest of the series is at most then."""

MAX_ADVANCES = 60
"""The most advances of a search. Near a minimum that touches zero each advance leaves a third of the way; a step that
ends there is as good as any."""

RESOLVED, CERTAIN = 0.25, 2.0
"""The least advance, and how close a zero is taken for certain, in parts of the time within which events coincide."""


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

    def __init__(self, coefficients: Value, h: Value, simultaneous: Value, orders: int) -> None:
        self._lines, self._terms, self._orders = h.function, Array(coefficients, h.type), orders
        self._simultaneous, one = simultaneous, h.like(1.0)
        self.unit, self.total, bend, tail = self._lines.repeat(
            [one, *self._scaled(h)], lambda unit, total, _, tail: self._is_poor(unit, total, tail).any(), self._halved
        )
        self.curvature = (bend / self.total).larger(1e-300)
        self.beyond = NEXT * tail / self.total

    def _is_poor(self, unit: Value, total: Value, tail: Value) -> Value:
        return (tail.is_("gt", MAX_TRUNCATED * total) | total.is_("eq", math.inf)) & unit.is_("gt", self._simultaneous)

    def _halved(self, unit: Value, total: Value, _: Value, tail: Value) -> list[Value]:
        factor = self._is_poor(unit, total, tail).choose(unit.like(0.5), 1.0)
        return [unit * factor, *self._scaled(factor)]

    def _scaled(self, factor: Value) -> list[Value]:
        """Multiply the terms by powers; return the sum of sizes, a bound of the second derivative, the last sizes."""

        def scale(n: Value, power: Value, total: Value, bend: Value, *last: Value) -> list[Value]:
            self._terms[n] = term = self._terms[n] * power
            weight = (n * (n - 1)).to_double().spread(power.lanes)
            return [n + 1, power * factor, total + abs(term), weight.fma(abs(term), bend), *last[1:], abs(term)]

        one, zero = factor.like(1.0), factor.like(0.0)
        lowest = [self._lines.constant(INTEGER, 0), one, zero, zero, *[zero] * 4]
        _, _, total, bend, *last = self._lines.repeat(lowest, lambda n, *_: n.is_("lt", self._orders), scale)
        return [total, bend, functools.reduce(Value.larger, last)]

    def at(self, share: Value, sign: Value) -> list[Value]:
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
        error = ROUNDING_BOUND * size / self.total + truncated
        return [sign * value / self.total, sign * slope / self.total, error, 2.0**doublings * truncated / share]


def first_change(coefficients: Value, h: Value, sign: Value, simultaneous: Value, orders: int) -> tuple[Value, Value]:
    """Return up to which share of a step a function keeps its sign, and the mask where the sign changes there.

    The share is at a zero of the function, or before one that truncation makes uncertain, where the sign does not
    change. It is 1 if the function keeps its sign to the end, and 0 if the function has another sign at the start, or
    just behind a zero there.

    Parameters
    ----------
    coefficients : address of vectors (orders,)
        Taylor coefficients of the function; they are overwritten.
    h : vector
        Length of the step, negative backwards.
    sign : vector
        Sign of the function, 1 or -1.
    simultaneous : vector
        Share of the step within which events coincide.
    """
    lines, pair = h.function, f"{{{h.type}, {h.type}}}"
    search = functools.partial(_search, orders=orders)
    found = lines.call_defined(pair, "first_change", search, coefficients, h, sign, simultaneous)
    return found.part(0), found.part(1).is_("gt", 0.0)


def _search(coefficients: Value, h: Value, sign: Value, simultaneous: Value, orders: int) -> Value:
    lines, one, zero = h.function, h.like(1.0), h.like(0.0)
    start = sign * Array(coefficients, h.type)[0]
    series = _Series(coefficients, h, simultaneous, orders)
    total, unit = series.total, series.unit
    simultaneous = simultaneous / unit
    finite = (0.0 * total).is_("eq", 0.0)
    watched = (2.0 * start).is_("le", total) & finite & total.is_("gt", 0.0)

    def search() -> list[Value]:
        curvature = series.curvature + orders**2 * series.beyond
        first = series.at(simultaneous, sign)
        wrong = watched & first[0].is_("lt", 0.0)
        going = watched & ~wrong & simultaneous.is_("lt", 1.0)

        def advance(left: Value, going: Value, share: Value, *found: Value) -> list[Value]:
            value, slope, error, increase = found
            room, slope = value - error, slope - increase
            root = (slope * slope + 2.0 * curvature * room).intrinsic("sqrt")
            rising = slope.is_("ge", 0.0)
            ahead = rising.choose((slope + root) / curvature, 2.0 * room / (root - slope))
            further = going & room.is_("gt", 0.0) & ahead.is_("gt", RESOLVED * simultaneous)
            share = further.choose((share + ahead).smaller(1.0), share)
            moved = [further.choose(new, old) for new, old in zip(series.at(share, sign), found, strict=True)]
            return [left - 1, further & share.is_("lt", 1.0), share, *moved]

        begin = [lines.constant(INTEGER, MAX_ADVANCES), going, simultaneous, *first]
        _, _, share, value, slope, *_ = lines.repeat(
            begin, lambda left, going, *_: left.is_("gt", 0) & going.any(), advance
        )
        changes = share.is_("lt", 1.0) & slope.is_("lt", 0.0) & (value + CERTAIN * slope * simultaneous).is_("lt", 0.0)
        share = changes.choose((share - value / slope).larger(simultaneous), share).smaller(1.0)
        share = wrong.choose(zero, watched.choose(share * unit, unseen))
        return [share, (watched & changes & ~wrong).choose(one, zero)]

    # The rates of the other branch may be no numbers.
    unseen = (~finite & start.is_("lt", 0.0)).choose(zero, finite.choose(unit, one))
    return lines.struct(*lines.either(watched.any(), [unseen, zero], search))
