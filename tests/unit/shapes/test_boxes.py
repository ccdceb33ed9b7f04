"""Overlaps of boxes against the comparison of all pairs."""

import numpy as np
import pytest

from poinsot.shapes.boxes import Boxes, ranges


@pytest.mark.parametrize("sizes", [(0.1, 0.2), (0.01, 1.5), (0.0, 0.3)])
def test_pairs_are_the_pairs_that_overlap_and_each_occurs_once(sizes):
    rng = np.random.default_rng(7)
    low, other_low = rng.uniform(-1, 0.5, (40, 3)), rng.uniform(-1, 0.5, (60, 3))
    high, other_high = (x + rng.uniform(0, size, x.shape) for x, size in zip((low, other_low), sizes, strict=True))
    rows, other_rows = rng.integers(0, 3, 40), rng.integers(0, 3, 60)
    one, other = Boxes(other_rows, other_low, other_high, 2.0).overlapping(rows, low, high)
    meets = (rows[:, None] == other_rows) & (other_high[:, 2] >= low[:, None, 2])
    for k in (0, 1):
        meets &= (other_high[:, k] >= low[:, None, k]) & (other_low[:, k] <= high[:, None, k])
    assert sorted(zip(one, other, strict=True)) == list(zip(*np.nonzero(meets), strict=True))
    assert len(one) > 3


def test_no_boxes_overlap_nothing():
    none, some = np.zeros((0, 3)), np.zeros((2, 3))
    rows = np.arange(2)
    for boxes, (at, low) in (
        (Boxes(rows[:0], none, none, 1.0), (rows, some)),
        (Boxes(rows, some, some, 1.0), (rows[:0], none)),
    ):
        assert [len(x) for x in boxes.overlapping(at, low, low)] == [0, 0]


def test_ranges_follow_each_other():
    assert list(ranges(np.array([3, 5, 0]), np.array([6, 5, 2]))) == [3, 4, 5, 0, 1]
