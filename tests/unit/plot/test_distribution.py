"""Histograms over the members of an ensemble."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt

mpl.use("Agg")

BODY = pt.Body((1.25, 1.0, 0.75))
RATES = np.random.default_rng(3).normal((0.2, 0.3, 1.5), 0.3, (500, 3))
START = BODY.state((1, 0, 0, 0), omega_body=RATES)
UNITS = {"time": "s", "inertia": "kg m2"}


@pytest.fixture(autouse=True)
def no_figures():
    yield
    plt.close("all")


def counted(panel):
    """The edges and heights of the bars."""
    return np.array([(bar.get_x(), bar.get_width(), bar.get_height()) for bar in panel.patches]).T


@pytest.mark.parametrize("quantity", ["effective_rate", "rate", "angular_momentum"])
def test_bars_count_the_members_at_the_last_time(quantity):
    """Of free motion, whose energy and momentum are those of the start: I of the principal axes, by hand."""
    inertia = np.array([1.25, 1.0, 0.75])
    motion = pt.propagate(pt.System(BODY, units=UNITS), START, [0, 3.0])
    end = motion.omega_body[:, -1]
    values = {
        "effective_rate": np.sum(inertia * RATES**2, axis=1) / np.linalg.norm(inertia * RATES, axis=1),
        "rate": np.linalg.norm(end, axis=1),
        "angular_momentum": np.linalg.norm(inertia * RATES, axis=1),
    }[quantity]
    options = {} if quantity == "angular_momentum" else {"rate_unit": "deg/h"}
    factor = 180 / np.pi * 3600 if options else 1.0
    panel = pt.plot.histogram(motion, quantity, **options)
    left, width, height = counted(panel)
    assert height.sum() == 500
    for lower, upper, count in zip(left, left + width, height, strict=True):
        slack = 1e-9 * upper
        assert abs(np.sum((factor * values > lower + slack) & (factor * values < upper - slack)) - count) <= 1
    medians = [float(np.ravel(line.get_xdata())[0]) for line in panel.lines]
    np.testing.assert_allclose(medians[:3], factor * np.percentile(values, [5, 95, 50]), rtol=1e-14)
    assert ("[deg h⁻¹]" if options else "[N m s]") in panel.get_xlabel()


def test_the_turn_is_that_of_the_angular_momentum():
    """Uniform gravity turns G about the vertical alone: its third component stays."""
    motion = pt.propagate(pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0))), START, [0, 3.0])
    one, other = (motion.angular_momentum_space[:, i] for i in (0, 1))
    angles = np.degrees(
        [np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)) for a, b in zip(one, other, strict=True)]
    )
    panel = pt.plot.histogram(motion, "turn")
    assert float(np.ravel(panel.lines[2].get_xdata())[0]) == pytest.approx(np.median(angles), rel=1e-13, abs=0)
    assert panel.get_xlabel().endswith("[deg]")


def test_what_is_no_ensemble_or_no_quantity_is_refused():
    one = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0, 1])
    with pytest.raises(ValueError, match=r"^ensemble must have members, got the motion of one body\.$"):
        pt.plot.histogram(one)
    with pytest.raises(ValueError, match=r"^quantity must be one of effective_rate, rate, .*, got 'mass'\.$"):
        pt.plot.histogram(pt.propagate(pt.System(BODY), START, [0, 1]), "mass")
