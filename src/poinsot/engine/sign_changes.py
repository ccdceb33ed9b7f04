"""The first sign change of a Taylor polynomial within a step, in LLVM's representation.

The search goes from the start by as much as the slope and a bound of the second derivative allow, less what rounding
and truncation may be: it comes up to a zero from before it, quadratically, and passes none, however close the next one.
"""

from __future__ import annotations

from poinsot.engine.llvm_functions import rough_exp2, rough_log2
from poinsot.engine.llvm_ir import INTEGER, Array, Value

__all__ = ["first_change"]

ROUNDING = 2.0**-50
"""What rounding may be of the value of a polynomial, relative to the sum of its terms' sizes."""

TRUNCATED = 1e-8
"""The largest share of the last terms in that sum for which a polynomial stands for its function."""

MOST_ADVANCES = 60
"""Near a minimum that touches zero each advance leaves a third of the way; a step that ends there is as good as any."""

RESOLVED, CERTAIN = 0.25, 2.0
"""The least advance, and how close a zero is taken for certain, in parts of the time within which all is at once."""


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
    lines, terms = h.function, Array(coefficients, h.type)
    one, zero = h.like(1.0), h.like(0.0)

    def scale(n: Value, power: Value, total: Value, bend: Value, *last: Value) -> list[Value]:
        terms[n] = term = terms[n] * power
        weight = (n * (n - 1)).to_double().spread(lanes)
        return [n + 1, power * h, total + abs(term), weight.fma(abs(term), bend), *last[1:], abs(term)]

    lowest = [lines.constant(INTEGER, 0), one, zero, zero, *[zero] * 4]
    _, _, total, bend, *last = lines.repeat(lowest, lambda n, *_: n.is_("lt", orders), scale)
    before, tail = last[0].larger(last[1]), last[2].larger(last[3])
    poor = tail.is_("gt", TRUNCATED * total)
    finite = (0.0 * total).is_("eq", 0.0)
    watched = (poor | (2.0 * side * terms[0]).is_("le", total)) & finite & total.is_("gt", 0.0)

    beyond = (tail / total) * (tail / before).smaller(1.0)

    def at(share: Value) -> list[Value]:
        """Return value, slope, error and the slope of the error, relative to the sum of the sizes."""

        def lower(n: Value, value: Value, slope: Value, size: Value) -> list[Value]:
            term = terms[n]
            return [n - 1, value.fma(share, term), slope.fma(share, value), size.fma(share, abs(term))]

        highest = [lines.constant(INTEGER, orders - 1), zero, zero, zero]
        _, value, slope, size = lines.repeat(highest, lambda n, *_: n.is_("ge", 0), lower)
        power, doublings = share, orders.bit_length() - 1
        for _ in range(doublings):
            power = power * power
        truncated = beyond * power
        error = ROUNDING * size / total + truncated
        return [side * value / total, side * slope / total, error, 2.0**doublings * truncated / share]

    def search() -> list[Value]:
        curvature = (bend / total + orders**2 * beyond).larger(1e-300)
        root_of_tail = rough_exp2(rough_log2((tail / total).larger(1e-300)) * (-1 / (orders - 1)))
        most = poor.choose(TRUNCATED ** (1 / (orders - 1)) * root_of_tail, 1.0)
        first = at(at_once)
        wrong = watched & first[0].is_("lt", 0.0)
        going = watched & ~wrong & at_once.is_("lt", most)

        def advance(left: Value, going: Value, share: Value, *found: Value) -> list[Value]:
            value, slope, error, increase = found
            room, slope = value - error, slope - increase
            root = (slope * slope + 2.0 * curvature * room).intrinsic("sqrt")
            rising = slope.is_("ge", 0.0)
            ahead = rising.choose((slope + root) / curvature, 2.0 * room / (root - slope))
            further = going & room.is_("gt", 0.0) & ahead.is_("gt", RESOLVED * at_once)
            share = further.choose((share + ahead).smaller(most), share)
            moved = [further.choose(new, old) for new, old in zip(at(share), found, strict=True)]
            return [left - 1, further & share.is_("lt", most), share, *moved]

        begin = [lines.constant(INTEGER, MOST_ADVANCES), going, at_once, *first]
        _, _, share, value, slope, *_ = lines.repeat(
            begin, lambda left, going, *_: left.is_("gt", 0) & going.any(), advance
        )
        changes = share.is_("lt", most) & slope.is_("lt", 0.0) & (value + CERTAIN * slope * at_once).is_("lt", 0.0)
        share = changes.choose((share - value / slope).larger(at_once), share).smaller(1.0)
        share = wrong.choose(zero, watched.choose(share, unseen))
        return [share, (watched & changes & ~wrong).choose(one, zero)]

    # The rates of the other branch may be no numbers.
    unseen = (~finite & (side * terms[0]).is_("lt", 0.0)).choose(zero, one)
    return lines.pair(*lines.either(watched.any(), [unseen, zero], search))
