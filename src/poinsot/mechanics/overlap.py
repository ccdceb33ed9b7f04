"""Whether two bodies that are ellipsoids are apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.algebra.ellipsoids import gap
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude

__all__ = ["gap_between", "refuse_overlap"]

OVERLAP_TOLERANCE = 1e-14
"""Largest relative overlap by rounding of ellipsoids in contact."""


def gap_between(semiaxes: Sequence[Any], attitudes: Sequence[Attitude], separation: Vector) -> Scalar:
    """Return the factor by which two ellipsoids must grow to touch, less one: see `algebra.ellipsoids.gap`.

    Semiaxes and attitudes are those of primary and secondary.
    """
    first, second = attitudes
    turn = [first.to_body(second.to_space(unit)) for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return gap(Vector(semiaxes[0]), Vector(semiaxes[1]), turn, first.to_body(separation))


def refuse_overlap(gaps: Any) -> None:
    """Raise a ValueError if ellipsoids overlap, by the least of the results of `gap_between`."""
    if (least := float(np.min(gaps))) < -OVERLAP_TOLERANCE:
        raise ValueError(
            f"position must separate the bodies, got ellipsoids that overlap: they touch when both are "
            f"{1 + least:.6g} times as large."
        )
