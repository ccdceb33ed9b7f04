"""Plots of ensembles: maps, chaos indicators and histograms."""

import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt

X, Y = np.array([0.0, 1.0, 2.0]), np.array([10.0, 20.0])
VALUES = np.array([[0.0, 2.0, 1.0], [5.0, np.nan, 40.0]])
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
BODY = pt.Body.from_ratios(beta=0.47, gamma=0.26)


TOP = pt.Body((1.25, 1.0, 0.75))
SPINS = np.random.default_rng(3).normal((0.2, 0.3, 1.5), 0.3, (500, 3))
SPREAD = TOP.state((1, 0, 0, 0), omega_body=SPINS)
UNITS_OF_TOP = {"time": "s", "inertia": "kg m2"}


@pytest.fixture(autouse=True)
def _figures():
    mpl.use("Agg")
    yield
    plt.close("all")


def bar(panel):
    return panel.figure.axes[1]


@pytest.mark.parametrize("values", [VALUES, VALUES.ravel()], ids=["grid", "members"])
def test_a_map_has_the_values_where_they_belong(values):
    panel = pt.plot.map(X, Y, values, "angle [deg]", "rate", "MEGNO", center=2, limits=(0, 10), title="A moon")
    (mesh,) = panel.collections
    shown = np.ma.filled(np.ma.reshape(mesh.get_array(), (2, 3)), np.nan)
    np.testing.assert_array_equal(shown, VALUES)
    assert panel.get_xlim() == (-0.5, 2.5)
    assert panel.get_ylim() == (5.0, 25.0)
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.figure.get_suptitle()) == ("angle [deg]", "rate", "A moon")
    assert bar(panel).get_ylabel() == "MEGNO"
    assert 2 in bar(panel).get_yticks()
    colour = {value: np.array(mesh.cmap(mesh.norm(value))[:3]) for value in (0.0, 2.0, 4.0, 8.0)}
    assert np.all(colour[2.0] > 0.95)  # white
    purple, orange = colour[0.0], colour[8.0]
    assert purple[2] > purple[0] > purple[1]
    assert orange[0] > orange[1] > orange[2]


def test_colours_about_a_center_have_one_scale():
    """What is as far below it as above it is as dark, and the bar counts evenly."""
    panel = pt.plot.map(X, Y, VALUES, center=2, limits=(0, 10))
    (mesh,) = panel.collections
    below, above = (np.mean(mesh.cmap(mesh.norm(value))[:3]) for value in (0.5, 3.5))
    assert below == pytest.approx(above, abs=0.05)
    assert np.mean(mesh.cmap(mesh.norm(9.0))[:3]) < above - 0.2
    ticks = panel.figure.axes[1].yaxis.get_transform().transform(np.array([0.0, 5.0, 10.0]))
    assert np.ptp(np.diff(ticks)) == 0


def test_limits_by_default_hold_nearly_all_values():
    values = np.concatenate([np.linspace(1, 3, 100), [1e6]]).reshape(1, -1).repeat(2, axis=0)
    (mesh,) = pt.plot.map(np.arange(101), Y, values).collections
    assert mesh.norm.vmin == pytest.approx(1, abs=0.05)
    assert mesh.norm.vmax == pytest.approx(3, abs=0.05)
    (mesh,) = pt.plot.map(np.arange(101), Y, values, center=7).collections
    low, high = mesh.get_clim()
    assert low < 3 < 7 < high
    (mesh,) = pt.plot.map(X, Y, np.full((2, 3), 4.0)).collections
    low, high = mesh.get_clim()
    assert low < high


@pytest.mark.parametrize("members", [(), (3,), (9,)])
def test_indicators_against_time(members):
    q = np.broadcast_to((1.0, 0, 0, 0), (*members, 4))
    rates = np.linspace(0.4, 2.9, 9)[: members[0]] if members else 2.9
    start = BODY.state(q, omega_body=np.multiply.outer(rates, (0, 0, 1.0)), time=1.0)
    system = pt.System(BODY, pt.GravityGradient(ORBIT), units={"time": "s", "inertia": "kg m2"})
    found = pt.analysis.chaos_indicators(system, start, np.linspace(2, 30, 8), formulation="planar")
    names = ["one", "two", "three"] if members == (3,) else ()
    left, right = pt.plot.chaos(found, names, title="A moon")
    curves = [line for line in left.lines if len(line.get_xdata()) == 8]
    assert len(curves) == len(right.lines) == (members[0] if members else 1)
    np.testing.assert_array_equal(curves[-1].get_xdata(), np.linspace(1, 29, 8))
    np.testing.assert_array_equal(curves[-1].get_ydata(), np.atleast_2d(found.mean_megno)[-1])
    np.testing.assert_array_equal(right.lines[-1].get_ydata(), np.atleast_2d(found.fli)[-1])
    assert left.get_xlabel() == "time from the start [s]"
    assert (left.get_legend() is not None) == (members == (3,))


@pytest.mark.parametrize(
    ("arguments", "options", "sentence"),
    [
        (
            (X, Y, VALUES.T),
            {},
            "values must have shape (2, 3) or (6,), got shape (3, 2). Take one time, as in mean_megno[:, -1].",
        ),
        ((X, Y, VALUES * np.nan), {}, "values must have something to draw, but all are NaN."),
        ((X[:1], Y, VALUES), {}, "x must be strictly monotonic with two values at least, got [0.]."),
        ((X, Y[[0, 0]], VALUES), {}, "y must be strictly monotonic with two values at least, got [10. 10.]."),
        ((X, Y, VALUES), {"limits": (3, 1)}, "limits must rise, got (3, 1)."),
        ((X, Y, VALUES), {"limits": (3, 9), "center": 2}, "limits must rise around 2, got (3, 9)."),
    ],
)
def test_bad_maps(arguments, options, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.plot.map(*arguments, **options)


def test_bad_indicators():
    with pytest.raises(TypeError, match=r"^found must be a ChaosIndicators, got int\.$"):
        pt.plot.chaos(3)
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1.0))
    found = pt.analysis.chaos_indicators(
        pt.System(BODY, pt.GravityGradient(ORBIT)), start, [1.0, 2.0], formulation="planar"
    )
    with pytest.raises(ValueError, match=r"^labels must name each of 1 members, got 2\.$"):
        pt.plot.chaos(found, ["one", "two"])


# ---------------------------------------------------------------------- histograms


def counted(panel):
    """The edges and heights of the bars."""
    return np.array([(bar.get_x(), bar.get_width(), bar.get_height()) for bar in panel.patches]).T


@pytest.mark.parametrize("quantity", ["effective_rate", "rate", "angular_momentum"])
def test_bars_count_the_members_at_the_last_time(quantity):
    """Energy and momentum of free motion equal the initial values, computed from the principal moments."""
    inertia = np.array([1.25, 1.0, 0.75])
    motion = pt.propagate(pt.System(TOP, units=UNITS_OF_TOP), SPREAD, [0, 3.0])
    end = motion.omega_body[:, -1]
    values = {
        "effective_rate": np.sum(inertia * SPINS**2, axis=1) / np.linalg.norm(inertia * SPINS, axis=1),
        "rate": np.linalg.norm(end, axis=1),
        "angular_momentum": np.linalg.norm(inertia * SPINS, axis=1),
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
    motion = pt.propagate(pt.System(TOP, pt.UniformGravity(0.5, (1, 0, 0))), SPREAD, [0, 3.0])
    one, other = (motion.angular_momentum_space[:, i] for i in (0, 1))
    angles = np.degrees(
        [np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)) for a, b in zip(one, other, strict=True)]
    )
    panel = pt.plot.histogram(motion, "turn")
    assert float(np.ravel(panel.lines[2].get_xdata())[0]) == pytest.approx(np.median(angles), rel=1e-13, abs=0)
    assert panel.get_xlabel().endswith("[deg]")


def test_what_is_no_ensemble_or_no_quantity_is_refused():
    one = pt.propagate(pt.System(TOP), TOP.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0, 1])
    with pytest.raises(ValueError, match=r"^ensemble must have members, got the motion of one body\.$"):
        pt.plot.histogram(one)
    with pytest.raises(ValueError, match=r"^quantity must be one of effective_rate, rate, .*, got 'mass'\.$"):
        pt.plot.histogram(pt.propagate(pt.System(TOP), SPREAD, [0, 1]), "mass")
