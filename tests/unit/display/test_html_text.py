"""Numbers in the texts of results."""

import numpy as np
import pytest

from poinsot.display.html_text import rounded, told, told_times


@pytest.mark.parametrize(
    ("values", "unit", "text"),
    [
        (None, "s", ""),
        ([], "s", ""),
        (1 / 3, "s", "0.333333 s"),
        ([2.0], "1", "2"),
        ([1e-12, -2 / 3, np.nan], "rad", "[1e-12, -0.666667, nan] rad"),
        (np.arange(7.0), "", "7, 0 ... 6"),
        ([[1.0, np.nan, -2.0, 3.0]] * 2, "rad s-1", "-2 ... 3 rad s-1, shape (2, 4)"),
        (np.full(9, np.nan), "s", "9, nan"),
    ],
)
def test_numbers_have_six_digits_and_a_unit(values, unit, text):
    assert told(values, unit) == text


def test_times_are_told_from_the_first_to_the_last():
    assert told_times(np.array([3.0, 2.0, -1.0]), "s") == "3, 3 ... -1 s"
    assert told_times(np.array([])) == "none"


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("Body(moments=[0.1234567890123456, 1.0])", "Body(moments=[0.123457, 1.0])"),
        ("GM=398600441800000.0, n=-1.2345678e-07", "GM=3.986e+14, n=-1.23457e-07"),
        ("2025-03-01T00:00:00 UTC", "2025-03-01T00:00:00 UTC"),
        ("1000 members of 1.5", "1000 members of 1.5"),
    ],
)
def test_descriptions_have_numbers_of_six_digits(text, short):
    assert rounded(text) == short


def test_a_long_description_is_cut():
    assert len(rounded("ab " * 1000)) < 260
