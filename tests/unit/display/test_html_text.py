"""Summaries, tables, small plots, and numbers in words."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from poinsot.display.html_text import Summarized, curves, formatted, formatted_times, markup_table, rounded, text_table


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
    assert formatted(values, unit) == text


def test_times_are_formatted_as_first_and_last():
    assert formatted_times(np.array([3.0, 2.0, -1.0]), "s") == "3, 3 ... -1 s"
    assert formatted_times(np.array([])) == "none"


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


class Result(Summarized):
    """A result of two lines, of which one is empty."""

    def _summary(self):
        return "Result of <a>", {"value": "1 & 2", "error": ""}


def test_a_summary_is_text_and_a_table():
    assert repr(Result()) == "Result of <a>\n  value: 1 & 2"
    assert Result()._repr_html_() == text_table("Result of <a>", {"value": "1 & 2", "error": ""})


def test_texts_of_a_table_are_no_markup():
    table = ET.fromstring(text_table("a < b", {"<i>": "x & y", "empty": ""}))
    assert table.findtext("caption") == "a < b"
    assert [(row.findtext("th"), row.findtext("td")) for row in table.iter("tr")] == [("<i>", "x & y")]


def test_cells_may_be_markup():
    table = ET.fromstring(markup_table("t", [("<b>n</b>", "<math><mi>x</mi></math>")]))
    assert table.find("tr/th/b").text == "n"
    assert table.find("tr/td/math/mi").text == "x"


# ------------------------------------------------------------------ small plots


HALF_STEP = 0.06
"""Points are rounded to 0.1 pixels."""


def points_of(text):
    """The points of each curve, pixels."""
    return [
        np.array([pair.split(",") for pair in points.split()], dtype=float)
        for points in re.findall(r'<polyline[^>]* points="([^"]*)"', text)
    ]


def labels_of(text):
    return [element.text for element in ET.fromstring(text).iter("text")]


def test_a_curve_spans_the_plot():
    x = np.linspace(0.0, 10.0, 11)
    (curve,) = points_of(curves("title", x, {"y": x**2}, "s"))
    left, right = curve[0, 0], curve[-1, 0]
    np.testing.assert_allclose(curve[:, 0], left + (right - left) * x / 10, rtol=0, atol=HALF_STEP)
    low, high = curve[0, 1], curve[-1, 1]
    assert high < low  # pixels count downwards
    np.testing.assert_allclose(curve[:, 1], low + (high - low) * x**2 / 100, rtol=0, atol=HALF_STEP)


def test_a_descending_curve_runs_from_its_first_abscissa():
    (curve,) = points_of(curves("t", np.array([3.0, 2.0, 1.0]), {"y": np.array([0.0, 1.0, 2.0])}))
    assert np.all(np.diff(curve[:, 0]) > 0)


def test_labels_are_the_ends_of_both_axes():
    text = curves("t", np.array([0.0, 2.0]), {"<y>": np.array([-1.0, 3.0])}, "d")
    assert labels_of(text)[1:] == ["3", "-1", "0 d", "2 d"]
    assert "&lt;y&gt;" in text


def test_errors_are_the_largest_so_far_on_a_logarithmic_scale():
    x = np.arange(4.0)
    text = curves("errors", x, {"e": np.array([0.0, -1e-9, 1e-12, 1e-6])}, errors=True)
    (curve,) = points_of(text)
    height = curve[0, 1] - curve[-1, 1]
    np.testing.assert_allclose((curve[0, 1] - curve[:, 1]) / height, [0, 0.75, 0.75, 1], rtol=0, atol=2e-3)
    assert labels_of(text)[1:3] == ["1.0e-06", "1.0e-18"]


def test_a_long_curve_keeps_the_extremes_of_each_interval():
    y = np.zeros(30_000)
    y[12_345], y[23_456] = 5.0, -3.0
    (curve,) = points_of(curves("t", np.arange(y.size, dtype=float), {"y": y}))
    assert len(curve) == 300
    assert np.count_nonzero(curve[:, 1] == curve[:, 1].min()) == 1
    assert np.count_nonzero(curve[:, 1] == curve[:, 1].max()) == 1
    assert np.all(np.diff(curve[:, 0]) >= 0)


def test_values_that_are_not_finite_are_left_out():
    (curve,) = points_of(curves("t", np.arange(5.0), {"y": np.array([0.0, np.nan, 1.0, np.inf, 2.0])}))
    assert len(curve) == 3


@pytest.mark.parametrize(("x", "y"), [([1.0], [1.0]), ([0.0, 1.0], [np.nan, np.nan])])
def test_a_plot_without_a_curve_is_empty(x, y):
    assert curves("t", np.array(x), {"y": np.array(y)}) == ""
    assert curves("t", np.arange(3.0), {}) == ""


def test_a_constant_is_drawn_in_the_middle():
    (curve,) = points_of(curves("t", np.arange(3.0), {"y": np.ones(3)}))
    (level,) = set(curve[:, 1])
    assert 36 < level < 112
