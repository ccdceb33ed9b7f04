"""Plots of results: a spectrum, its units and digits, and the points of a section."""

import re
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


def spectrum(nu, amplitudes, errors, residual):
    resolved = np.ones(len(nu), bool)
    return pt.analysis.LineSpectrum(np.array(nu), np.array(amplitudes), np.array(errors), resolved, residual)


def test_stems_residual_and_units():
    found = spectrum([1.2, -0.5], [2j, 0.1], [1e-4, 0.02], 1e-3)
    axes = pt.plot.spectrum(found, time="s", unit="kg m2 s-1", rate_unit="rad/s", title="momentum")
    lines: Any = axes.collections
    stems = lines[0].get_segments()
    np.testing.assert_allclose([stem[:, 0] for stem in stems], [[1.2, 1.2], [-0.5, -0.5]], rtol=1e-15)
    np.testing.assert_allclose([stem[1, 1] for stem in stems], [2.0, 0.1], rtol=1e-15)
    ticks, level = axes.lines[0], axes.lines[1]
    np.testing.assert_allclose(ticks.get_data(), [[1.2, -0.5], [2.0, 0.1]], rtol=1e-15)
    np.testing.assert_allclose(level.get_ydata(), 1e-3, rtol=1e-15)
    bars = lines[1].get_segments()
    np.testing.assert_allclose([np.ptp(bar[:, 0]) for bar in bars], [2e-4, 0.04], rtol=1e-12)
    assert axes.get_yscale() == "log"
    assert axes.get_xlabel() == "frequency [rad s⁻¹]"
    assert axes.get_ylabel() == "amplitude [N m s]"
    assert axes.figure.get_suptitle() == "momentum"
    assert [text.get_text() for text in axes.texts] == ["1.2000(1)", "-0.50(2)"]


def test_unresolved_lines_have_open_circles():
    found = pt.analysis.LineSpectrum(
        np.array([1.2, 0.5]), np.array([2j, 0.1]), np.array([1e-4, 0.02]), np.array([True, False]), residual=1e-3
    )
    circles = {str(line.get_label()): line for line in pt.plot.spectrum(found).containers}
    assert list(circles) == ["lines", "lines not resolved"]
    for label, nu, fill in (("lines", 1.2, "full"), ("lines not resolved", 0.5, "none")):
        (line, _, _) = circles[label]
        assert list(line.get_xdata()) == [nu]
        assert line.get_fillstyle() == fill


@pytest.mark.parametrize(
    ("value", "error", "written"),
    [
        (0.47139459023, 2e-7, "0.4713946(2)"),
        (0.47139459023, 1e-16, "0.4713945902"),
        (0.5, 0.096, "0.5(1)"),
        (123.4, 33.0, "120(40)"),
        (0.0, 0.0, "0"),
        (-2.5e-5, 1e-9, "-0.000025000(1)"),
        (3.3, 5.0, "3(5)"),
    ],
)
def test_frequencies_are_written_to_their_errors(value, error, written):
    (text,) = pt.plot.spectrum(spectrum([value], [1.0], [error], 0.1)).texts
    assert text.get_text() == written


def test_a_signal_without_lines_and_one_without_rest():
    axes = pt.plot.spectrum(pt.analysis.frequencies(np.zeros(80), 1.0))
    assert not axes.texts
    axes = pt.plot.spectrum(spectrum([1.0], [1.0], [0.0], 0.0))
    assert len(axes.lines) == 1
    axes.figure.canvas.draw()


def test_only_one_signal_is_drawn():
    two = pt.analysis.frequencies(np.cos(np.arange(64) * [[0.5], [0.7]]), 1.0, count=2)
    sentence = "spectrum must be of one signal, got frequencies of shape (2, 2)."
    with pytest.raises(ValueError, match="^" + re.escape(sentence)):
        pt.plot.spectrum(two)
    with pytest.raises(TypeError, match=r"^spectrum must be a LineSpectrum, got list\.$"):
        pt.plot.spectrum([1.0])


@pytest.fixture
def section():
    body = pt.Body((1.0, 2.0, 3.0))
    system = pt.System(body, units={"time": "s"})
    state = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.1))
    motion = pt.propagate(system, state, [0.0, 20.0], events=[pt.events.AxisCrossing((0, 0, 1), (1, 0, 0))])
    return pt.analysis.section(
        motion, lambda at: (at.omega_body[:, 0], at.omega_body[:, 1]), labels=("phase [rad]", "rate [rad/s]")
    )


@pytest.mark.parametrize(("angle_unit", "factor"), [("deg", 180 / np.pi), ("rad", 1.0)])
def test_points_are_in_the_unit_of_the_axis(section, angle_unit, factor):
    axes = pt.plot.section(section, angle_unit=angle_unit, rate_unit="rpm")
    drawn = np.concatenate([each.get_offsets() for each in axes.collections])
    wanted = np.stack([section.x * factor, section.y * 30 / np.pi], axis=-1)
    wanted = wanted[np.isfinite(wanted[:, 0])]
    assert len(wanted) > 1
    order, found = np.lexsort(wanted.T), np.lexsort(np.asarray(drawn).T)
    np.testing.assert_allclose(np.asarray(drawn)[found], wanted[order], rtol=1e-14)
    assert angle_unit in axes.get_xlabel()
    assert "rpm" in axes.get_ylabel()
