"""Pictures against time: what they draw, in which units, of one motion and of ensembles."""

import re
from functools import partial
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.dates import num2date
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.kinematics.euler import SEQUENCES
from poinsot.kinematics.frame import from_roll_pitch_yaw, roll_pitch_yaw
from poinsot.propagation.column_reader import MotionRows

ORBIT = pt.KeplerOrbit(
    398600.4418,
    semimajor_axis=7000.0,
    eccentricity=0.1,
    inclination=0.9,
    node=0.3,
    argument_of_periapsis=0.5,
    true_anomaly=0.2,
)
BODY = pt.Body((400.0, 500.0, 600.0))
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT), units={"time": "s", "inertia": "kg m2"})
TIMES = np.linspace(0, 6000, 61)
IN_S: dict[str, Any] = {"time_unit": "s"}
IN_SI: dict[str, Any] = {"time_unit": "s", "rate_unit": "rad/s"}
PLOTS: dict[str, Any] = {
    "quaternions": partial(pt.plot.quaternions, **IN_S),
    "euler": partial(pt.plot.euler_angles, **IN_S),
    "level": partial(pt.plot.roll_pitch_yaw, **IN_S),
    "rates": partial(pt.plot.angular_velocity, **IN_SI),
    "momentum": partial(pt.plot.angular_momentum, **IN_S),
    "drift": partial(pt.plot.drift, **IN_S),
    "difference": lambda motion: pt.plot.difference(motion, motion, **IN_S),
}


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def motion():
    return pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001)), TIMES)


@pytest.fixture(scope="module")
def members():
    rates = np.linspace([0.001, 0.002, 0.001], [0.0011, 0.0021, 0.0012], 21)
    return pt.propagate(SYSTEM, BODY.state(np.tile([0.5, 0.5, 0.5, 0.5], (21, 1)), omega_body=rates), TIMES)


def curves(axes):
    return [line.get_ydata() for panel in np.atleast_1d(axes) for line in panel.lines]


def replaced(motion, q, times=TIMES):
    """The motion with other attitudes, at other times, and momenta that are all the same in the body."""
    phase = {"quaternion": q, "angular_momentum_body": (0.3, -0.2, 0.5) + 0 * q[..., :3]}
    return pt.Trajectory(motion.system, motion.initial, times, MotionRows(phase), motion.run)


def labels(axes):
    return [panel.get_ylabel() for panel in np.atleast_1d(axes)]


@pytest.mark.parametrize("name", PLOTS)
def test_units_and_names_are_on_the_axes(name, motion):
    axes = np.atleast_1d(PLOTS[name](motion))
    assert all(panel.get_xlabel() == "time [s]" for panel in axes)
    assert all(panel.get_ylabel() for panel in axes)
    assert all(panel.get_xlim() == (0, 6000) for panel in axes)
    if name != "difference":
        assert all(panel.get_legend() for panel in axes)


@pytest.mark.parametrize("name", PLOTS)
def test_an_ensemble_is_its_median_between_bands(name, members):
    axes = np.atleast_1d(PLOTS[name](members))
    bands = [[each for each in panel.collections if each.get_label() != "near gimbal lock"] for panel in axes]
    assert [len(each) for each in bands] == [2 * len(panel.lines) for panel in axes]


def test_medians_and_bands_are_those_of_the_members(members):
    axes = pt.plot.angular_velocity(members, **IN_SI)
    assert np.allclose(curves(axes)[2], np.median(members.omega_body[..., 2], axis=0), rtol=0, atol=1e-15)
    wide, narrow = (path.get_paths()[0].get_extents() for path in axes[0].collections[:2])
    low, high = np.percentile(members.omega_body[..., 0], [5, 95], axis=0)
    assert (wide.y0, wide.y1) == pytest.approx((low.min(), high.max()))
    assert wide.y0 < narrow.y0 < narrow.y1 < wide.y1


def test_failed_members_are_left_out(members):
    phase = {name: values.copy() for name, values in members.phase.items()}
    phase["quaternion"][3, 40:] = np.nan
    failed = pt.Trajectory(members.system, members.initial, members.times, MotionRows(phase), members.run)
    drawn = curves(pt.plot.quaternions(failed))[0]
    assert np.allclose(drawn, np.median(np.delete(members.quaternion, 3, axis=0)[..., 0], axis=0), rtol=0, atol=1e-15)


def test_a_caption_names_the_bands(motion, members):
    stopped = members.quaternion.copy()
    stopped[3, 40:] = np.nan
    words = [
        pt.plot.angular_velocity(each)[0].figure.get_supxlabel()
        for each in (motion, members, replaced(members, stopped))
    ]
    assert words == [
        "",
        "Median of 21 members, and bands from 25 to 75 % and 5 to 95 % of them.",
        "Median of the 20 of 21 members that did not stop, and bands from 25 to 75 % and 5 to 95 % of them.",
    ]


@pytest.mark.parametrize("name", [name for name in PLOTS if name != "difference"])
def test_a_single_time_is_drawn_as_points(name, motion, members):
    for each in (motion, members):
        alone = replaced(each, each.quaternion[..., 7:8, :], TIMES[7:8])
        for panel in np.atleast_1d(PLOTS[name](alone)):
            assert all(line.get_marker() == "o" and line.get_xdata() == TIMES[7] for line in panel.lines)
            panel.figure.draw_without_rendering()


def test_backwards_in_time_the_axis_still_goes_forwards(motion):
    back = replaced(motion, motion.quaternion[::-1], TIMES[::-1])
    assert pt.plot.quaternions(back, time_unit="s")[0].get_xlim() == (0, 6000)
    there, and_back = (curves(pt.plot.euler_angles(each, angle_unit="rad")) for each in (motion, back))
    for one, other in zip(there, and_back, strict=True):
        np.testing.assert_array_equal(one[::-1], other)


def test_components_are_those_of_the_motion(motion):
    expected = {
        "quaternions": (motion.quaternion, motion.conjugate_momenta),
        "rates": (motion.omega_body, motion.omega_space),
        "momentum": (motion.angular_momentum_body, motion.angular_momentum_space),
    }
    for name, parts in expected.items():
        assert np.array_equal(np.array(curves(PLOTS[name](motion))).T, np.concatenate(parts, axis=-1))


def whole(line):
    """The values of a line without its gaps."""
    return line[np.isfinite(line)]


@pytest.mark.parametrize("frame", [None, ORBIT.frame], ids=["space", "orbit"])
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angles_of_every_sequence_are_wrapped_and_come_back_to_the_attitude(motion, sequence, frame):
    """SciPy turns them back; a line never goes from one edge to the other."""
    motion = replaced(motion, motion.quaternion[1:], TIMES[1:])  # for the start is in gimbal lock of three of them
    panel = pt.plot.euler_angles(motion, sequence, frame, angle_unit="rad")
    drawn = curves(panel)
    assert labels(panel) == [f"Euler angles {'-'.join(sequence)}{' from the frame' if frame else ''} [rad]"]
    assert all(np.nanmax(np.abs(line)) < np.pi + 1e-5 for line in drawn)
    assert all(np.nanmax(np.abs(np.diff(line))) < 0.8 * np.pi for line in drawn)
    back = Rotation.from_euler(sequence.translate(str.maketrans("123", "XYZ")), np.transpose([*map(whole, drawn)]))
    attitude = motion.attitude if frame is None else motion.relative_to(frame).attitude
    assert np.max((back.inv() * attitude).magnitude()) < 1e-14


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_the_second_angle_is_drawn_at_gimbal_lock_of_every_sequence(motion, sequence):
    """Which is no reason to refuse the picture of a motion that stays there."""
    axes, second = sequence.translate(str.maketrans("123", "XYZ")), 0.0 if sequence[0] == sequence[2] else 90.0
    locked = Rotation.from_euler(axes, [[20, second, 30], [20, second + 3, 30], [20, second + 7, 30]], degrees=True)
    panel = pt.plot.euler_angles(
        replaced(motion, locked.as_quat(scalar_first=True), TIMES[:3]), sequence, time_unit="s", angle_unit="deg"
    )
    first, middle, third = curves(panel)
    folded = second if second == 0 else 90.0 - np.array([0, 3, 7])
    assert middle == pytest.approx([0, 3, 7] if second == 0 else folded, abs=1e-5)
    assert np.isnan(first[0])
    assert np.isnan(third[0])
    (shade,) = panel.collections
    assert shade.get_label() == "near gimbal lock"
    assert shade.get_paths()[0].get_extents().x1 == (TIMES[1] + TIMES[2]) / 2


def test_members_are_whole_turns_apart_only_where_they_turned():
    """Starts on both sides of the half turn, at which roll jumps."""
    rolls = np.radians(np.linspace(170, 190, 21))
    level = [from_roll_pitch_yaw((roll, 0.1, 0.2)) for roll in rolls]
    start = BODY.state(level, omega_body=(0.0, 0.0, 0.0), frame=ORBIT.frame)
    panel = pt.plot.roll_pitch_yaw(pt.propagate(SYSTEM, start, (0.0, 1.0, 2.0)))
    assert curves(panel)[0] == pytest.approx(180, abs=0.01)
    edges = panel.collections[0].get_paths()[0].get_extents()
    assert (edges.y0, edges.y1) == pytest.approx((171, 189), abs=0.01)


def test_the_orbit_of_two_forces_is_one_orbit(motion):
    system = pt.System(BODY, pt.GravityGradient(ORBIT), pt.forces.Oblateness(ORBIT, 1e-3, 6000.0, (0, 0, 1)))
    twice = pt.propagate(system, motion.initial, TIMES)
    drawn = [curves(pt.plot.roll_pitch_yaw(twice, *orbit)) for orbit in ((), (ORBIT,))]
    for one, other in zip(*drawn, strict=True):
        np.testing.assert_array_equal(one, other)


def test_roll_pitch_yaw_by_hand(motion):
    """Axes forward, against the normal, down, from position and velocity; SciPy's own angles."""
    r, v = (np.stack(list(part(TIMES)), axis=-1) for part in (ORBIT.position_at, ORBIT.velocity_at))
    down = -r / np.linalg.norm(r, axis=-1, keepdims=True)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v), axis=-1, keepdims=True)
    level = np.stack([np.cross(-normal, down), -normal, down], axis=-1)
    assert np.all(np.sum(level[..., 0] * v, axis=-1) > 0)
    expected = (Rotation.from_matrix(level).inv() * motion.attitude).as_euler("ZYX")[:, ::-1]
    found = motion.relative_to(ORBIT.frame).roll_pitch_yaw
    assert np.max(np.abs(np.sin(0.5 * (found - expected)))) < 1e-13
    assert np.max(np.abs(found)) <= np.pi
    drawn = [values[np.isfinite(values)] for values in curves(pt.plot.roll_pitch_yaw(motion, ORBIT))]
    assert np.allclose(np.radians(drawn).T, found, rtol=0, atol=1e-14)


@pytest.mark.parametrize("degrees", [True, False])
def test_roll_pitch_yaw_goes_through_gimbal_lock(degrees):
    """Turned about the second axis alone: at a pitch of 90 degrees roll and yaw jump by half a turn together."""
    begin = from_roll_pitch_yaw(np.radians([(0, angle, 0) for angle in (0, 30, 60, 86, 90)]))
    beyond = from_roll_pitch_yaw(np.radians([(180, angle, 180) for angle in (80, 40, 0)]))
    along = Rotation.from_quat(ORBIT.frame.quaternion(TIMES[:8]), scalar_first=True)
    q = (along * Rotation.from_quat(np.concatenate([begin, beyond]), scalar_first=True)).as_quat(scalar_first=True)
    motion = pt.propagate(SYSTEM, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0)), TIMES)
    unit = "deg" if degrees else "rad"
    panel = pt.plot.roll_pitch_yaw(replaced(motion, q, TIMES[:8]), ORBIT, angle_unit=unit, time_unit="s")
    roll, pitch, yaw = (x if degrees else np.degrees(x) for x in curves(panel))
    assert pitch == pytest.approx([0, 30, 60, 86, 90, 80, 40, 0], abs=1e-5)
    for angle in (roll, yaw):
        assert np.all(np.isnan(angle[4]))
        assert np.abs(angle[:4]) == pytest.approx(0, abs=1e-9)
        assert angle[5:] == pytest.approx(180, abs=1e-9)  # on one side of the half turn, whatever rounding says
    (shade,) = panel.collections
    (box,) = (path.get_extents() for path in shade.get_paths())
    assert (box.x0, box.x1) == ((TIMES[2] + TIMES[3]) / 2, (TIMES[4] + TIMES[5]) / 2)
    texts = [text.get_text() for text in panel.get_legend().get_texts()]
    assert texts == ["roll", "pitch", "yaw", "near gimbal lock"]


def test_roll_pitch_yaw_of_one_motion_begins_anew_at_half_a_turn(motion):
    turns = from_roll_pitch_yaw(np.radians([(0, 0, 50 * i) for i in range(9)]))
    along = Rotation.from_quat(ORBIT.frame.quaternion(TIMES[:9]), scalar_first=True)
    q = (along * Rotation.from_quat(turns, scalar_first=True)).as_quat(scalar_first=True)
    panel = pt.plot.roll_pitch_yaw(replaced(motion, q, TIMES[:9]), ORBIT)
    expected = [0, 50, 100, 150, np.nan, -160, -110, -60, -10, 40]
    assert curves(panel)[2] == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert not panel.collections


def test_roll_pitch_yaw_that_stays_in_gimbal_lock_is_its_pitch(motion):
    level = Rotation.from_quat(from_roll_pitch_yaw((0, np.pi / 2, 0)), scalar_first=True)
    q = (ORBIT.frame.attitude(0.0) * level).as_quat(scalar_first=True)
    roll, pitch, yaw = curves(pt.plot.roll_pitch_yaw(replaced(motion, q[None], TIMES[:1]), ORBIT))
    assert np.isnan([roll, yaw]).all()
    assert pitch == pytest.approx(90, abs=1e-5)


def test_attitudes_from_roll_pitch_yaw_are_theirs(rng):
    angles = rng.uniform(-1, 1, (50, 3)) * (np.pi, 1.5, np.pi)
    assert np.allclose(roll_pitch_yaw(from_roll_pitch_yaw(angles)), angles, rtol=0, atol=1e-14)
    down = Rotation.from_quat(from_roll_pitch_yaw((0, 0, 0)), scalar_first=True).apply((0, 0, 1))
    assert np.allclose(down, (-1, 0, 0), rtol=0, atol=1e-15)


def rows_of(panel):
    """Return the words of a legend row by row, each from left to right."""
    panel.figure.draw_without_rendering()
    placed = [(text.get_window_extent(), text.get_text()) for text in panel.get_legend().get_texts()]
    rows: list[list[Any]] = []
    for box, word in sorted(placed, key=lambda each: -each[0].y0):
        if not rows or rows[-1][0][0].y0 - box.y0 > 0.5 * box.height:
            rows.append([])
        rows[-1].append((box, word))
    return [[word for _, word in sorted(row, key=lambda each: each[0].x0)] for row in rows]


def read(panel):
    """Return the words of a legend in the order in which a reader reads them."""
    return [word for row in rows_of(panel) for word in row]


def test_a_legend_of_two_rows_is_read_in_the_order_of_the_curves():
    free = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), TIMES)
    panel = pt.plot.drift(free)
    assert [len(row) for row in rows_of(panel)] == [3, 3]
    assert read(panel) == [line.get_label() for line in panel.lines]


def test_rounding_of_a_constant_is_not_enlarged():
    """The angular momentum of a free body in space changes by a relative 1e-15."""
    free = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), TIMES)
    panel = pt.plot.angular_momentum(free, separate=True)[1].child_axes[0]
    low, high = panel.get_ylim()
    assert high - low > 0.9 * np.max(np.abs(curves(panel)))
    panel.figure.draw_without_rendering()
    assert panel.yaxis.get_offset_text().get_text() == ""


def test_drifts_are_on_a_log_axis():
    free = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), TIMES)
    panel = pt.plot.drift(free)
    assert panel.get_yscale() == "log"
    norms = ["norm error $|q| - 1$", r"tangency error $q \cdot Q\,/\,|Q|$"]
    momenta = [f"angular momentum $G_{{{i}}}$ = {value}" for i, value in ((1, 40), (2, 100), (3, 180))]
    assert read(panel) == [*norms, "energy $H$ = 39", *momenta]
    assert np.allclose(curves(panel)[2], np.maximum(np.abs(free.drift["energy"]), 2**-53), rtol=1e-15, atol=0)


def test_what_is_conserved_is_named_with_its_value_and_unit():
    circle = pt.System(
        BODY, pt.GravityGradient(pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0)), units=SYSTEM.units
    )
    motion = pt.propagate(circle, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001)), TIMES)
    names = read(pt.plot.drift(motion))
    value = motion.integrals["jacobi_energy"][0]
    assert names[2:] == [rf"energy $H-n \cdot G$ = {value:.5g} [J]"]


def test_difference_is_the_angle_between_attitudes(motion):
    turned = pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.00101)), TIMES)
    drawn = curves(pt.plot.difference(motion, turned))[0]
    expected = np.degrees((motion.attitude.inv() * turned.attitude).magnitude())
    assert np.allclose(drawn[1:], expected[1:], rtol=1e-11, atol=0)


def test_times_that_a_file_of_dates_rounded_are_the_same_times(motion):
    near = replaced(motion, motion.quaternion, TIMES + 4e-7)
    assert np.max(curves(pt.plot.difference(motion, near, angle_unit="rad"))) < 1e-15
    with pytest.raises(ValueError, match=r"^other must have the same times, got 61 times"):
        pt.plot.difference(motion, replaced(motion, motion.quaternion, TIMES + 6e-7))
    unnamed = replaced(pt.propagate(pt.System(BODY), motion.initial, TIMES), motion.quaternion)
    with pytest.raises(ValueError, match=r"^other must have the same times, got 61 times"):
        pt.plot.difference(unnamed, near)


@pytest.mark.parametrize("times", [(-432000, 432000), (0, 1e-5), (0, 99999)])
def test_ticks_do_not_run_into_each_other(motion, times):
    panels = pt.plot.angular_velocity(replaced(motion, motion.quaternion, np.linspace(*times, 61)))
    panels[0].figure.canvas.draw()
    for panel in panels:
        boxes = [label.get_window_extent() for label in panel.get_xticklabels() if label.get_text()]
        left, right = panel.bbox.x0 - 20, panel.bbox.x1 + 20
        seen = [box for box in boxes if left < box.x0 and box.x1 < right]
        assert len(seen) > 2
        assert all(one.x1 < two.x0 for one, two in pairwise(seen))


def test_dates_of_a_scenario_or_a_table_are_on_the_axis(motion):
    dated = replaced(motion, motion.quaternion)
    dated._complete(provenance={"calendar": pt.Calendar("2026-11-21", "UTC")})
    since = "time [min] since 2026-11-21T00:00:00 UTC"
    assert pt.plot.angular_velocity(dated, time_unit="min")[0].get_xlabel() == since
    panel = pt.plot.angular_velocity(dated)[0]
    assert panel.get_xlabel() == "date, from 2026-11-21T00:00:00 UTC"
    assert num2date(panel.lines[0].get_xdata()[-1]).isoformat() == "2026-11-21T01:40:00+00:00"
    panel.figure.canvas.draw()
    ticks = [tick.get_text() for tick in panel.get_xticklabels()]
    assert ticks[:3] == ["00:00", "00:30", "01:00"]
    with pytest.raises(ValueError, match=r"^time_unit must not be 'date' without a calendar of the times"):
        pt.plot.angular_velocity(motion, time_unit="date")


@pytest.mark.parametrize("span", [30, 170, 190, 7e3, 1e5, 2.5e5, 4e6, 9e7, 6e8])
def test_dates_have_ticks_at_every_span(motion, span):
    """Without a warning of matplotlib, which has no suitable interval for too few of them."""
    dated = replaced(motion, motion.quaternion, np.linspace(7e5, 7e5 + span, 61))
    dated._complete(provenance={"calendar": pt.Calendar("2011-03-05T06:07:08.5", "TDB")})
    panel = pt.plot.drift(dated)
    panel.figure.draw_without_rendering()
    left, right = panel.get_xlim()
    boxes = [
        tick.label1.get_window_extent() for tick in panel.xaxis.get_major_ticks() if left <= tick.get_loc() <= right
    ]
    assert 3 <= len(boxes) <= 7
    assert all(one.x1 < two.x0 for one, two in pairwise(boxes))


def test_the_legend_does_not_cover_a_power_of_ten():
    heavy = pt.Body((4e9, 5e9, 6e9))
    motion = pt.free_motion(heavy, heavy.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), TIMES, units=SYSTEM.units)
    panel = pt.plot.angular_momentum(motion)[0]
    panel.figure.draw_without_rendering()
    power = panel.yaxis.get_offset_text()
    assert "10" in power.get_text()
    [*_, lowest] = panel.get_legend().get_texts()
    assert lowest.get_window_extent().y0 > power.get_window_extent().y1


def test_dates_are_those_of_astropy_after_a_leap_second(motion):
    """Counted from before the one at the end of 2016, as the calendar counts."""
    calendar = pt.Calendar("2016-12-31T23:00:00", "UTC")
    dated = replaced(motion, motion.quaternion)
    dated._complete(provenance={"calendar": calendar})
    x: Any = pt.plot.drift(dated).lines[0].get_xdata()
    assert num2date(x[-1]).replace(microsecond=0).isoformat() == "2017-01-01T00:39:59+00:00"


@pytest.mark.parametrize(
    ("span", "unit"),
    [(100, "s"), (599, "s"), (600, "min"), (9999, "min"), (10_000, "h"), (50_000, "h"), (864_000, "d"), (1e9, "yr")],
)
def test_the_unit_of_time_suits_the_span(motion, span, unit):
    """Hours, days or years wherever a span in seconds would have five digits."""
    there = replaced(motion, motion.quaternion, np.linspace(7e5, 7e5 + span, 61))
    assert pt.plot.drift(there).get_xlabel() == f"time [{unit}]"
    assert pt.plot.momentum_sphere(there).figure.legends[0].get_texts()[-1].get_text().endswith(f" {unit}")


@pytest.mark.parametrize(
    ("rate", "unit"),
    [
        (1.05, "rpm"),
        (1.04, "deg s⁻¹"),
        (0.1, "deg s⁻¹"),
        (7.5e-4, "deg s⁻¹"),
        (1e-4, "deg h⁻¹"),
        (2e-6, "deg d⁻¹"),
        (0.0, "deg d⁻¹"),
    ],
)
def test_the_unit_of_rates_suits_the_largest(rate, unit):
    turning = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate)), TIMES[:2], units=SYSTEM.units)
    assert pt.plot.angular_velocity(turning)[0].get_ylabel() == f"angular velocity, body axes [{unit}]"


def test_small_angles_are_in_arc_seconds(motion):
    other = replaced(motion, (motion.attitude * Rotation.from_rotvec((0, 0, 1e-3))).as_quat(scalar_first=True))
    panel = pt.plot.difference(motion, other)
    assert labels(panel) == ["difference of attitude [arcsec]"]
    assert curves(panel)[0] == pytest.approx(np.degrees(3.6), rel=1e-9, abs=0)


def test_difference_with_other_times_takes_the_dense_output(motion):
    dense = pt.propagate(SYSTEM, motion.initial, TIMES, dense=True)
    others = TIMES[:-1] + 37.0
    table = pt.propagate(SYSTEM, dense(37.0), others)
    panel = pt.plot.difference(dense, table, angle_unit="rad", time_unit="s")
    assert np.array_equal(panel.lines[0].get_xdata(), others)
    assert np.max(curves(panel)[0]) < 1e-13


# ---------------------------------------------------------------------- files


def noisy(count):
    times = np.linspace(0, 6000, count)
    turn = np.random.default_rng(5).normal(size=(count, 4))
    return times, turn / np.linalg.norm(turn, axis=-1, keepdims=True)


def test_of_very_many_samples_the_extremes_are_drawn(motion):
    times, q = noisy(300_000)
    slow = q + [10, 20, 30, 40] * np.sin(times / 900)[:, None]  # every sample is a turning point: drawn as an envelope
    lines = pt.plot.quaternions(replaced(motion, np.sort(slow, axis=0), times), time_unit="s")[0].lines
    assert len(lines) == 4
    for k, line in enumerate(lines):
        x, y = line.get_data()
        assert x.size < 6100
        assert np.all(np.diff(x) > 0)
        assert (x[0], x[-1]) == (0, 6000)
        for low in (0, 1236, 5992):
            sorted_k = np.sort(slow[:, k])
            within, drawn_part = (values[(at >= low) & (at < low + 8)] for at, values in ((times, sorted_k), (x, y)))
            assert (drawn_part.min(), drawn_part.max()) == (within.min(), within.max())


def test_of_fast_oscillations_the_envelope_is_drawn(motion):
    """The band between the least and the largest value of each column, whose sizes beat here."""
    times = np.linspace(0, 6000, 100_001)
    beating = (1 + 0.5 * np.sin(times / 900)) * np.sin(5 * times)
    q = np.stack([beating, 0 * times, np.cos(times / 900), 0 * times], axis=-1)
    panel = pt.plot.quaternions(replaced(motion, q, times), time_unit="s")[0]
    assert [text.get_text() for text in panel.get_legend().get_texts()] == [f"$q_{i}$" for i in range(4)]
    assert len(panel.lines) == 3
    (band,) = panel.collections
    assert panel.get_xlim() == (0, 6000)
    x, y = band.get_paths()[0].vertices[1:-1].T
    upper, lower = (y > 0) & (x > 10) & (x < 5990), (y < 0) & (x > 10) & (x < 5990)
    assert 1000 < np.count_nonzero(upper) <= 1500
    assert np.max(np.abs(y[upper] - (1 + 0.5 * np.sin(x[upper] / 900)))) < 0.02
    assert np.max(np.abs(y[lower] + (1 + 0.5 * np.sin(x[lower] / 900)))) < 0.02


def test_a_window_is_drawn_alone_and_fills_the_panel(motion):
    panel = pt.plot.angular_velocity(motion, window=(950, 2000), **IN_SI)[0]
    chosen = (TIMES >= 950) & (TIMES <= 2000)
    assert np.array_equal(panel.lines[1].get_data(), [TIMES[chosen], motion.omega_body[chosen, 1]])
    assert panel.get_xlim() == (1000, 2000)
    dated = replaced(motion, motion.quaternion)
    dated._complete(provenance={"calendar": pt.Calendar("2026-11-21", "UTC")})
    window = ("2026-11-21T00:20:00 UTC", "2026-11-21T00:30:00 UTC")
    assert pt.plot.drift(dated, window=window, time_unit="s").get_xlim() == (1200, 1800)
    with pytest.raises(
        ValueError, match=r"^window must hold a time of the motion, which are from 0 to 6000, got \(7000"
    ):
        pt.plot.drift(motion, window=(7000, 8000))


@pytest.mark.parametrize("separate", [False, True])
def test_degrees_are_counted_in_right_angles(motion, separate):
    panel = pt.plot.roll_pitch_yaw(motion, ORBIT, separate=separate)
    part: Any = panel.child_axes[0] if separate else panel
    part.figure.draw_without_rendering()
    low, high = part.get_ylim()
    assert {tick for tick in part.get_yticks() if low <= tick <= high} >= {-180, 0, 180}
    assert all(tick % 30 == 0 for tick in part.get_yticks())


def test_separate_curves_are_one_below_the_other_on_one_axis_of_time(motion):
    panels = pt.plot.angular_velocity(motion, separate=True, **IN_SI)
    assert labels(panels) == [f"angular velocity, {axes} axes [rad s⁻¹]" for axes in ("body", "space")]
    left = panels[0]
    parts = left.child_axes
    assert [part.get_ylabel() for part in parts] == [rf"$\omega_{i}$" for i in (1, 2, 3)]
    assert np.array_equal([part.lines[0].get_ydata() for part in parts], motion.omega_body.T)
    tops = [part.get_position().y0 for part in parts]
    assert tops == sorted(tops, reverse=True)
    left.set_xlim(100, 200)
    assert all(part.get_xlim() == (100, 200) for part in parts)
    left.figure.draw_without_rendering()
    ticks = [tick.get_window_extent().x0 for part in parts for tick in part.get_yticklabels() if tick.get_text()]
    assert left.yaxis.label.get_window_extent().x1 < min(ticks)


def test_events_are_marked_with_their_names():
    event = pt.events.SpinFlip((0, 1, 0))
    times = np.linspace(0, 6e4, 301)
    start = BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001))
    flipping = pt.propagate(SYSTEM, start, times, events=[event])
    (found,) = flipping.events
    assert len(found) > 3
    panel = pt.plot.angular_velocity(flipping, time_unit="s")[0]
    (marks,) = panel.collections
    assert [segment[0, 0] for segment in marks.get_segments()] == pytest.approx(found.times)
    assert marks.get_label() == f"spin flip, {len(found)} times"
    assert marks.get_label() in [text.get_text() for text in panel.get_legend().get_texts()]
    assert {tuple(segment[:, 1]) for segment in marks.get_segments()} == {(0, 1)}
    until = pt.plot.angular_velocity(flipping, time_unit="s", window=(0, found.times[0] + 300))[0]
    assert until.collections[0].get_label() == "spin flip"


def test_a_vector_file_is_small_and_has_text(motion, tmp_path):
    times, q = noisy(300_000)
    long = replaced(motion, q, times)
    pictures = {
        "quaternions": pt.plot.quaternions(long, time_unit="s")[0],
        "sphere": pt.plot.momentum_sphere(long, time_unit="s"),
    }
    for name, panel in pictures.items():
        for suffix in ("svg", "pdf"):
            path = tmp_path / f"{name}.{suffix}"
            panel.figure.savefig(path)
            assert path.stat().st_size < 3e6
        assert re.search(r"<text[^>]*>(at )?time( 6000 s| \[s\])</text>", (tmp_path / f"{name}.svg").read_text())
        assert b"/Type3" not in (tmp_path / f"{name}.pdf").read_bytes()
    assert mpl.rcParams["svg.fonttype"] == "path"


def test_bad_input(motion):
    other = pt.propagate(SYSTEM, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.002, 0.001)), TIMES[:9])
    with pytest.raises(ValueError, match=r"other must have the same times, got 9 times from 0 to 800 and 61 times"):
        pt.plot.difference(motion, other)
    with pytest.raises(TypeError, match=r"orbit must be an Orbit, got OrbitFrame"):
        pt.plot.roll_pitch_yaw(motion, ORBIT.frame)
    free = pt.propagate(pt.System(BODY), motion.initial, (0.0, 1.0))
    with pytest.raises(ValueError, match=r"orbit must be named where the system has not exactly one, but it has none"):
        pt.plot.roll_pitch_yaw(free)
    two = pt.System(
        BODY,
        pt.GravityGradient(ORBIT),
        pt.GravityGradient(pt.KeplerOrbit(4902.8, semimajor_axis=7000.0, eccentricity=0)),
    )
    with pytest.raises(ValueError, match=r"but it has 2\. Pass roll_pitch_yaw\(motion, orbit\)\.$"):
        pt.plot.roll_pitch_yaw(pt.propagate(two, motion.initial, (0.0, 1.0)))
    with pytest.raises(ValueError, match=r"^motion must contain times to draw, got none\.$"):
        pt.plot.angular_velocity(replaced(motion, motion.quaternion[:0], motion.times[:0]))
    stopped = np.full((2, *motion.quaternion.shape), np.nan)
    with pytest.raises(ValueError, match=r"^motion must have a member that reached its last time, but none did\.$"):
        pt.plot.angular_velocity(replaced(motion, stopped))
    for plot in PLOTS.values():
        with pytest.raises(TypeError, match=r"motion must be a Trajectory, got State"):
            plot(motion.initial)


# ---------------------------------------------------------------------- two bodies


def pair_motion(count=41, dense=False):
    first, second = pt.Body.from_ellipsoid(50.0, (1.0, 0.9, 0.7)), pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3))
    pair = pt.TwoBodies(first, second, G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "inertia": "kg m2", "length": "m"})
    start = pair.kick(pair.synchronous(distance=4.0, primary_rate=2.0), (0.0, -0.3, 0.1))
    motion: Any = pt.propagate(system, start, np.linspace(0, 8, count), dense=dense)
    return motion


def test_of_two_bodies_the_distance_and_both_rates_are_drawn():
    motion = pair_motion()
    panel = pt.plot.distance(motion)
    assert labels(panel) == ["distance of the centres of mass [m]"]
    assert np.array_equal(curves(panel), [np.linalg.norm(motion.position, axis=-1)])
    axes = pt.plot.angular_velocity(motion, **IN_SI)
    assert labels(axes) == [f"angular velocity of the {body} [rad s⁻¹]" for body in ("primary", "secondary")]
    both = np.concatenate([motion.primary.omega_body, motion.secondary.omega_body], axis=-1)
    assert np.array_equal(np.array(curves(axes)).T, both)


def test_drifts_of_two_bodies_are_those_of_each_and_of_the_whole():
    motion = pair_motion()
    panel = pt.plot.drift(motion)
    names, errors = read(panel), ("norm error $|q| - 1$", r"tangency error $q \cdot Q\,/\,|Q|$")
    norms = [rf"{error} of the {body}" for body in ("primary", "secondary") for error in errors]
    assert names[:4] == norms
    values = [motion.energy[0], *motion.angular_momentum_space[0]]
    units = ["J", *["N m s"] * 3]
    symbols = ["energy $H", *(f"angular momentum $G_{{{i}}}" for i in (1, 2, 3))]
    assert names[4:] == [f"{s}$ = {v:.5g} [{u}]" for s, v, u in zip(symbols, values, units, strict=True)]
    assert np.allclose(curves(panel)[2], np.maximum(np.abs(motion.secondary.norm_error), 2**-53), rtol=1e-15, atol=0)
    assert np.allclose(curves(panel)[4], np.maximum(np.abs(motion.drift["energy"]), 2**-53), rtol=1e-15, atol=0)


def test_the_difference_of_two_bodies_is_that_of_each():
    motion, other = pair_motion(dense=True), pair_motion(count=9)
    turned: Any = pt.propagate(other.system, other.system.body.kick(other.initial, (0.01, 0.0, 0.0)), other.times)
    panel = pt.plot.difference(motion, turned, angle_unit="rad")
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["primary", "secondary"]
    for drawn, one, two in zip(curves(panel), *(x.of_bodies.values() for x in (other, turned)), strict=True):
        expected = (one.attitude.inv() * two.attitude).magnitude()
        assert np.allclose(drawn[1:], expected[1:], rtol=1e-10, atol=0)
    with pytest.raises(
        ValueError, match=r"^other must be of one body, got two bodies\. Take other\.primary or other\.s"
    ):
        pt.plot.difference(other.primary, other)


# ---------------------------------------------------------------------- curves and marks that remain visible


def styles(panel):
    """Return the line style of each curve by its name."""
    return {line.get_label(): line.get_linestyle() for line in panel.lines}


def test_a_curve_that_covers_another_is_dashed():
    """A sphere keeps its angular velocity, here with equal components."""
    ball = pt.System(pt.Body((1.0, 1.0, 1.0)), units={"time": "s"})
    equal = pt.propagate(ball, ball.state((1, 0, 0, 0), omega_body=(0.1, 0.1, 0.1)), np.linspace(0, 9, 91))
    assert styles(pt.plot.angular_velocity(equal)[0]) == {
        r"$\omega_1$": "-",
        r"$\omega_2$": "--",
        r"$\omega_3$": "-.",
    }
    apart = pt.propagate(ball, ball.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), np.linspace(0, 9, 91))
    assert set(styles(pt.plot.angular_velocity(apart)[0]).values()) == {"-"}
    for part in pt.plot.angular_velocity(equal, separate=True)[0].child_axes:
        assert part.lines[0].get_linestyle() == "-"


def test_curves_that_cross_are_solid(motion):
    assert set(styles(pt.plot.roll_pitch_yaw(motion)).values()) == {"-"}


def test_median_curves_that_coincide_differ_in_style():
    ball = pt.System(pt.Body((1.0, 1.0, 1.0)), units={"time": "s"})
    rates = np.linspace([0.1, 0.1, 0.3], [0.2, 0.2, 0.4], 5)
    spins = pt.propagate(ball, ball.state((1, 0, 0, 0), omega_body=rates), np.linspace(0, 9, 91))
    assert list(styles(pt.plot.angular_velocity(spins)[0]).values()) == ["-", "--", "-"]


def with_event(kind, times, terminal=True):
    """Return a free rotation with an event at time 5.25."""

    class Passing(pt.Event):
        def value(self, instant):
            return instant.time - 5.25

        @property
        def kind(self):
            return kind

    ball = pt.System(pt.Body((1.0, 1.0, 1.0)), units={"time": "s"})
    start = ball.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    return pt.propagate(ball, start, times, events=[Passing(terminal=terminal)])


@pytest.mark.parametrize("times", [np.arange(10.0), np.array([0.0, 9.0])])
def test_a_terminal_event_is_marked_after_the_last_output_time(times):
    found = with_event("Stop", times)
    assert found.times[-1] < 5.25
    panel = pt.plot.angular_velocity(found)[0]
    (marks,) = panel.collections
    assert [segment[0, 0] for segment in marks.get_segments()] == pytest.approx([5.25])
    assert panel.get_xlim()[1] > 5.25
    first_rows = pt.plot.angular_velocity(found, window=(0, 0.5))[0] if times.size > 2 else None
    assert first_rows is None or not first_rows.collections


def test_a_terminal_event_of_a_part_of_a_motion_is_outside_its_plot():
    assert not pt.plot.angular_velocity(with_event("Stop", np.arange(10.0))[:3])[0].collections


def test_a_long_name_of_an_event_is_within_the_figure():
    long = "SecondaryReachesTheSurfaceOfThePrimary" * 3
    found = with_event(long, np.arange(10.0), terminal=False)
    panel = pt.plot.angular_velocity(found)[0]
    panel.figure.draw_without_rendering()
    box, figure = panel.get_legend().get_window_extent(), panel.figure.bbox
    assert box.x0 >= 0
    assert box.x1 <= panel.figure.axes[1].get_window_extent().x0
    assert box.y1 <= figure.y1
