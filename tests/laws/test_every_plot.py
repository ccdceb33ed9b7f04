"""Every plot draws on the given axes, returns them, and shows its numbers in the units of its labels."""

import inspect

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import poinsot as pt
from public_calls import BODY, CIRCLE, START, ensemble, free, pair_motion, public_calls

mpl.use("Agg")

SOLID = {"momentum_sphere", "poinsot_construction", "polhode"}
SPHERE = "poinsot_construction"
WRITTEN = {"deg": "deg", "mrad/d": "mrad d⁻¹"}
TIMES_DRAWN = np.linspace(0.0, 100.0, 51)


@pytest.fixture(autouse=True)
def no_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    found = public_calls(tmp_path_factory.mktemp("calls"))
    return {name: found[f"plot.{name}"] for name in pt.plot.__all__}


def in_seconds(arguments):
    """The argument that has units, in seconds."""
    if "spectrum" in arguments:
        return {"time": "s"}
    if getattr(arguments.get("motion"), "system", None) is free().system:
        return {"motion": pt.free_motion(BODY, START, TIMES_DRAWN, units={"time": "s"})}
    return {}


def axes_for(name):
    solid = {"projection": "3d"} if name in SOLID else {}
    return plt.subplots(1, 2, subplot_kw=solid)[1]


def lines_of(drawn):
    """The coordinates of every line, by panel."""
    drawn = list(np.ravel(drawn))
    lines = [[line for line in panel.lines if of_data(panel, line)] for panel in drawn]
    return [[np.array(getattr(line, "_verts3d", line.get_data()), dtype=float) for line in part] for part in lines]


def of_data(panel, line):
    """Whether the coordinates of a line are those of the axes."""
    return hasattr(line, "_verts3d") or line.get_transform() == panel.transData


@pytest.mark.samples
@pytest.mark.parametrize("name", pt.plot.__all__)
def test_every_plot_draws_on_the_given_axes(calls, name):
    draw, arguments = calls[name]
    given, several = axes_for(name), "axes" in inspect.signature(draw).parameters
    place = {"axes": given} if several else {"ax": given[1]}
    found = draw(**{**arguments, **place})
    assert plt.get_fignums() == [given[0].figure.number]
    assert list(found) == list(given) if several else found is given[1]
    assert several or not given[0].has_data()
    fresh = draw(**arguments)
    assert type(fresh) is type(found)
    assert isinstance(fresh, np.ndarray) == several
    assert all(isinstance(panel, Axes) for panel in np.ravel(fresh))
    pairs = list(zip(np.ravel(found), np.ravel(fresh), strict=True))
    assert all(a.get_xlabel() == b.get_xlabel() and a.get_ylabel() == b.get_ylabel() for a, b in pairs)
    assert name == "momentum_sphere" or all(b.get_xlabel() and b.get_ylabel() for _, b in pairs)
    for one, other in zip(lines_of(found), lines_of(fresh), strict=True):
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


OF_PAIRS = {"distance", "librations", "mutual_orbit"}
ALSO_OF_PAIRS = {"angular_velocity", "difference", "drift"}
WITH_MOTION = [name for name in pt.plot.__all__ if "motion" in inspect.signature(getattr(pt.plot, name)).parameters]
OF_MOTIONS = [name for name in WITH_MOTION if name not in OF_PAIRS]
REFUSED = {
    "parts": {"herpolhode", "poinsot_construction"},
    "ensemble": {"herpolhode", "momentum_sphere", "part_variables", "poinsot_construction", "polhode", "sky"},
}


def with_parts():
    """A body whose wheel speeds up and whose damper turns it towards its short axis."""
    wheel, damper = pt.parts.ReactionWheel((0, 0, 1), 0.1, torque=2e-3), pt.parts.KaneDamper(0.1, 0.05)
    system = pt.System(BODY, wheel, damper, pt.GravityGradient(CIRCLE), units={"time": "s"})
    return pt.propagate(system, system.state(START.quaternion, omega_body=(0.4, -0.3, 0.6)), TIMES_DRAWN)


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("name", OF_MOTIONS)
def test_every_plot_of_a_motion_takes_parts_and_ensembles_or_says_why_not(calls, name, kind):
    draw, arguments = calls[name]
    motion = with_parts() if kind == "parts" else ensemble()
    arguments = {**arguments, "motion": motion, **({"other": motion} if name == "difference" else {})}
    if name in REFUSED[kind]:
        with pytest.raises(ValueError, match=r"^motion must be of (a rigid|one|a) body.*, got .*\.$"):
            draw(**arguments)
    else:
        assert all(panel.has_data() for panel in np.ravel(draw(**arguments)))


def given(arguments, motion):
    """The arguments of a plot with another motion, for its other one, too."""
    return {**arguments, **{name: motion for name in ("motion", "other") if name in arguments}}


@pytest.mark.parametrize("name", WITH_MOTION)
def test_every_plot_of_a_motion_takes_two_bodies_or_names_the_motions_of_each(calls, name):
    draw, arguments = calls[name]
    motion = pair_motion()
    if name in OF_PAIRS | ALSO_OF_PAIRS:
        assert all(panel.has_data() for panel in np.ravel(draw(**given(arguments, motion))))
    else:
        sentence = r"^motion must be of one body, got two bodies\. Take motion\.primary or motion\.secondary\.$"
        with pytest.raises(ValueError, match=sentence):
            draw(**given(arguments, motion))


OF_FREE_BODIES = {"herpolhode", "poinsot_construction"}
"""Which one of two bodies is not; nor has it parts."""


@pytest.mark.parametrize("body", ["primary", "secondary"])
@pytest.mark.parametrize("name", OF_MOTIONS)
def test_every_plot_of_a_motion_takes_one_of_two_bodies_or_says_why_not(calls, name, body):
    draw, arguments = calls[name]
    one = getattr(pair_motion(), body)
    if name in OF_FREE_BODIES | {"part_variables"}:
        sentence = r"^motion must (have a constant angular momentum|be of a body with a part)"
        with pytest.raises(ValueError, match=sentence):
            draw(**given(arguments, one))
    else:
        assert all(panel.has_data() for panel in np.ravel(draw(**given(arguments, one))))


@pytest.mark.parametrize("name", sorted(OF_PAIRS))
def test_plots_of_two_bodies_refuse_one(calls, name):
    draw, arguments = calls[name]
    with pytest.raises(TypeError, match=r"^motion must be the motion of two bodies, got the motion of one body\.$"):
        draw(**given(arguments, free()))


@pytest.mark.parametrize("name", pt.plot.__all__)
def test_what_is_no_axes_is_refused(calls, name):
    draw, arguments = calls[name]
    several = "axes" in inspect.signature(draw).parameters
    for wrong in (3, "ax", [1, 2], plt.figure()):
        with pytest.raises(TypeError, match=r"^axes must be 2 Axes" if several else r"^ax must be (an|3D) (A|a)xes"):
            draw(**{**arguments, ("axes" if several else "ax"): wrong})


TIMES, RATES = {"h": 1 / 3600, "yr": 1 / 31557600}, {"deg": 180 / np.pi, "rpm": 30 / np.pi, "mrad/d": 86400e3}
ANGLES = {"deg": 180 / np.pi, "rev": 0.5 / np.pi, "arcsec": 648000 / np.pi}
AGAINST_TIME = {"angular_momentum", "angular_velocity", "chaos", "difference", "drift", "euler_angles", "quaternions"}
AGAINST_TIME |= {"attitude_error", "torques"}
AGAINST_TIME |= {"distance", "librations", "part_variables"}
X, Y, ALL = [0], [1], [0, 1, 2]
SCALED = {
    "time_unit": (TIMES, dict.fromkeys(AGAINST_TIME | {"roll_pitch_yaw", "uncertainty"}, X)),
    "rate_unit": (RATES, {"angular_velocity": Y, "herpolhode": ALL, "polhode": ALL, "spectrum": X} | {SPHERE: ALL}),
    "angle_unit": (
        ANGLES,
        {
            "attitude_error": Y,
            "difference": Y,
            "euler_angles": Y,
            "librations": Y,
            "roll_pitch_yaw": Y,
            "uncertainty": Y,
            "yorp": X,
        },
    ),
}
"""By option: units with the factors from seconds and radians, and which coordinates of which plots have them."""


@pytest.mark.parametrize("option", SCALED)
def test_units_scale_the_numbers_and_are_written_next_to_them(calls, option):
    units, plots = SCALED[option]
    for name, coordinates in plots.items():
        draw, arguments = calls[name]
        base = {
            **{key: value for key, value in arguments.items() if not key.endswith("_unit")},
            **in_seconds(arguments),
        }
        base |= {each: "rad" for each in ("angle_unit", "rate_unit") if each in inspect.signature(draw).parameters}
        base |= {"time_unit": "s"} if "time_unit" in inspect.signature(draw).parameters else {}
        plain = draw(**base)
        for unit, factor in units.items():
            plt.close("all")
            found = draw(**{**base, option: unit})
            before, after = (lines_of(np.ravel(each)[:1]) for each in (plain, found))
            for one, other in zip(before[0], after[0], strict=True):
                expected = [factor * x if i in coordinates else x for i, x in enumerate(one)]
                for ours, theirs in zip(other, expected, strict=True):
                    np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12 * np.nanmax(np.abs(theirs)))
            panel = np.ravel(found)[0]
            label = panel.get_ylabel() if coordinates == Y else panel.get_xlabel()
            assert f"[{WRITTEN.get(unit, unit)}" in label, label


MEASURED = {
    "length_unit": {"km": 1e-3, "au": 1 / 149597870700, "mm": 1e3},
    "momentum_unit": {"mN m s": 1e3, "kg km2 d-1": 86400e-6, "g cm2 min-1": 6e8, "J h": 1 / 3600},
    "torque_unit": {"uN m": 1e6, "kg km2 d-2": 86400**2 * 1e-6, "MJ": 1e-6},
}
"""By option: units with the factors from those of kg, m and s."""
WITH_UNIT = [
    (name, option)
    for option in MEASURED
    for name in pt.plot.__all__
    if option in inspect.signature(getattr(pt.plot, name)).parameters
]


@pytest.mark.parametrize(("name", "option"), WITH_UNIT)
def test_units_of_lengths_momenta_and_torques_scale_the_numbers(name, option):
    """The first panel's numbers against time, or both coordinates of an orbit; what is no such unit is refused."""
    draw, pair = getattr(pt.plot, name), option == "length_unit"
    motion = two_balls() if pair else flipping()
    plain = draw(motion)
    for unit, factor in MEASURED[option].items():
        found = draw(motion, **{option: unit})
        for one, other in zip(lines_of(plain)[0], lines_of(found)[0], strict=True):
            axes = (0, 1) if name == "mutual_orbit" else (1,)
            expected = [factor * x if i in axes else x for i, x in enumerate(one)]
            np.testing.assert_allclose(other, expected, rtol=1e-12)
        written = unit.replace("-1", "⁻¹").replace("-2", "⁻²").replace("2", "²")
        assert f"[{written}]" in np.ravel(found)[0].get_ylabel()
    for wrong in ("s", "furlong", "m m", ""):
        sentence = f"^{option} must be of the kind of '.*', the unit of the motion, got '{wrong}'"
        with pytest.raises(ValueError, match=sentence):
            draw(motion, **{option: wrong})


def two_balls():
    ball = pt.Body.from_ellipsoid(1e9, (100, 90, 80))
    pair = pt.TwoBodies(ball, ball)
    units = {"time": "s", "inertia": "kg m2", "length": "m"}
    start = pair.state((500, 0, 0), (0, 0.01, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1e-4)] * 2)
    return pt.propagate(pt.System(pair, pt.forces.MutualGravity(), units=units), start, np.linspace(0, 1e5, 50))


OPTION = {
    option: [name for name in pt.plot.__all__ if option in inspect.signature(getattr(pt.plot, name)).parameters]
    for option in ("window", "separate")
}


def labels_of(calls, name):
    """A plot and its arguments, of a motion in seconds with an event where it takes one, in units that stay."""
    draw, arguments = calls[name]
    units = {"angle_unit": "rad", "rate_unit": "rad", "time_unit": "s"}
    return draw, arguments | {each: unit for each, unit in units.items() if each in inspect.signature(draw).parameters}


@pytest.mark.parametrize("name", OPTION["window"])
def test_every_window_draws_the_samples_in_it_and_no_others(calls, name):
    draw, arguments = labels_of(calls, name)
    whole = lines_of(draw(**arguments))
    times = whole[0][0][0]
    first, last = times[times.size // 4], times[-1 - times.size // 4]
    for one, other in zip(whole, lines_of(draw(**arguments, window=(first, last))), strict=True):
        for line, part in zip(one, other, strict=True):
            drawn = line[:, (line[0] >= first) & (line[0] <= last)]
            assert np.array_equal(part[:, np.isfinite(part[1])], drawn[:, np.isfinite(drawn[1])])
    with pytest.raises(
        ValueError, match=r"^window must hold a time of the (motion|readings), which are from .*, got \("
    ):
        draw(**arguments, window=(-2.0, -1.0))
    with pytest.raises(ValueError, match=r"^window must have shape \(2,\)"):
        draw(**arguments, window=(1.0, 2.0, 3.0))


@pytest.mark.samples
@pytest.mark.parametrize("name", OPTION["separate"])
def test_every_separate_curve_has_a_part_of_its_panel(calls, name):
    draw, arguments = labels_of(calls, name)
    together, apart = (np.ravel(draw(**arguments, separate=each)) for each in (False, True))
    for one, other, lines in zip(together, apart, lines_of(together), strict=True):
        assert (one.get_xlabel(), one.get_ylabel()) == (other.get_xlabel(), other.get_ylabel())
        parts = other.child_axes if len(lines) > 1 else [other]
        for line, [drawn] in zip(lines, lines_of(parts), strict=True):
            assert np.array_equal(line, drawn, equal_nan=True)


@pytest.mark.parametrize("name", [name for name in OPTION["window"] if name in OF_MOTIONS])
def test_every_plot_against_time_marks_the_events(calls, name):
    draw, arguments = labels_of(calls, name)
    motion = flipping()
    [found] = motion.events
    assert 2 < len(found) < 20
    for panel in np.ravel(draw(**given(arguments, motion))):
        [marks] = [each for each in panel.collections if str(each.get_label()).startswith("spin flip")]
        assert [segment[0, 0] for segment in marks.get_segments()] == pytest.approx(found.times)


def flipping():
    """A motion with events, an orbit, a force and a part."""
    damper = pt.parts.KaneDamper(0.1, 0.05)
    units = {"time": "s", "inertia": "kg m2"}
    system = pt.System(pt.Body((1.0, 1.6, 2.5)), damper, pt.GravityGradient(CIRCLE), units=units)
    start = system.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.1, 1.0, 0.1))
    event = pt.events.SpinFlip((0, 1, 0))
    return pt.propagate(system, start, np.linspace(0, 24, 121), events=[event])


def test_units_that_are_none_are_refused():
    motion, unnamed = pt.free_motion(BODY, START, TIMES_DRAWN, units={"time": "s"}), free()
    for call, sentence in (
        (lambda: pt.plot.drift(motion, time_unit="weeks"), "time_unit must be one of s, min, h, d, yr, got 'weeks'."),
        (
            lambda: pt.plot.euler_angles(motion, angle_unit="h"),
            "angle_unit must be one of rad, mrad, deg, arcmin, .*'h'.",
        ),
        (lambda: pt.plot.polhode(motion, rate_unit="rad/m"), "rate_unit must be rpm, or an angle .* got 'rad/m'."),
        (lambda: pt.plot.polhode(motion, rate_unit="/s"), "rate_unit must be rpm, or an angle .* got '/s'."),
        (lambda: pt.plot.drift(unnamed, time_unit="h"), "time_unit must be left out where the unit of time of the"),
        (lambda: pt.plot.polhode(unnamed, rate_unit="rpm"), "rate_unit must be left out where the unit of time of the"),
    ):
        with pytest.raises(ValueError, match=f"^{sentence}"):
            call()
    assert pt.plot.polhode(unnamed, rate_unit="deg").get_xlabel() == r"$\omega_1$ [deg / unit of time]"
