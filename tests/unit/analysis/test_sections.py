"""Sections: which points of which member, and what is refused."""

import matplotlib as mpl
import numpy as np
import pytest

import poinsot as pt

mpl.use("Agg")

BODY = pt.Body((1.0, 2.0, 3.0))
FREE = pt.System(BODY)
ACROSS = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), direction=1)


def spinning(rate):
    return BODY.state((1, 0, 0, 0), omega_body=np.multiply.outer(np.asarray(rate, dtype=float), (0, 0, 1)))


def time_and_rate(points):
    return points.times, points.omega_body[:, 2]


def test_members_have_rows_and_missing_points_are_nan():
    motion = pt.propagate(FREE, spinning([2.0, 0.5, 1.0]), [20.0], events=[pt.events.AtTime(3.0), ACROSS])
    section = pt.analysis.section(motion, time_and_rate, 1, labels=("t", "rate"))
    counts = [6, 1, 3]
    assert np.isfinite(section.x).sum(axis=1).tolist() == counts
    for k, (rate, count) in enumerate(zip([2.0, 0.5, 1.0], counts, strict=True)):
        assert np.allclose(section.x[k, :count], (2 * np.arange(count) + 1.5) * np.pi / rate, rtol=1e-14, atol=0)
        assert np.allclose(section.y[k, :count], rate, rtol=1e-15, atol=0)
    assert section.labels == ("t", "rate")
    assert repr(section).startswith("Section of 3 motions of System(")
    assert "  points: 10\n" in repr(section)


def test_without_an_event_all_times_are_points_also_of_one_body():
    section = pt.analysis.section(pt.propagate(FREE, spinning(0.5), [1.0, 2.0, 3.0]), time_and_rate)
    assert section.x.tolist() == [[1.0, 2.0, 3.0]]
    rising = pt.analysis.section(
        pt.propagate(FREE, spinning(0.5), [1.0, 2.0]), lambda points: (points.times, points.directions)
    )
    assert rising.y.tolist() == [[1.0, 1.0]]
    members = pt.analysis.section(pt.propagate(FREE, spinning([0.5, 0.7]), [1.0, 2.0, 3.0]), time_and_rate)
    assert np.allclose(members.y, [[0.5] * 3, [0.7] * 3], rtol=1e-15, atol=0)


def test_of_a_motion_that_ended_there_are_the_points_before():
    ends = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), direction=-1, terminal=True)
    motion = pt.propagate(FREE, spinning([1.0, 0.1]), [1.0, 2.0, 3.0], events=[ends])
    assert np.isfinite(pt.analysis.section(motion, time_and_rate).x).sum(axis=1).tolist() == [1, 3]
    none = pt.propagate(FREE, spinning(0.1), [1.0], events=[ACROSS])
    assert pt.analysis.section(none, time_and_rate, 0).x.shape == (1, 0)


def test_andoyer_of_no_passage_is_empty():
    start = BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.1, 0.2, 0.3))
    assert pt.analysis.andoyer_section(FREE, start, 1e-3).x.shape == (1, 0)


def test_angles_of_andoyers_section_may_have_members():
    start, angles = pt.Andoyer(l=0.3, g=0.8, h=0.2, L=0.5, G=1.0, H=0.3).state(), np.array([0.1, 0.8, 2.0])
    together = pt.analysis.andoyer_section(FREE, start, 20.0, angle=angles)
    for k, angle in enumerate(angles):
        alone = pt.analysis.andoyer_section(FREE, start, 20.0, angle=angle)
        for own, rows in ((alone.x, together.x[k]), (alone.y, together.y[k])):
            assert np.allclose(own[0], rows[np.isfinite(rows)], rtol=0, atol=1e-12)
    assert (together.x[1, 0], together.y[1, 0]) == pytest.approx((0.3, 0.5), abs=1e-15)


def test_a_section_of_the_shortest_motion_is_its_start():
    start = pt.Andoyer(l=0.3, g=0.8, h=0.2, L=0.5, G=1.0, H=0.3).state()
    for time in (5e-324, -5e-324):
        assert pt.analysis.andoyer_section(FREE, start, time, angle=0.8).x == pytest.approx(
            np.array([[0.3]]), abs=1e-15
        )


def test_the_first_point_of_a_spin_orbit_section_is_the_start():
    orbit = pt.KeplerOrbit(
        3.0,
        semimajor_axis=2.0,
        eccentricity=0.2,
        inclination=0.5,
        node=0.6,
        argument_of_periapsis=0.7,
        true_anomaly=2.0,
        epoch=-3.0,
    )
    system = pt.System(BODY, pt.GravityGradient(orbit))
    section = pt.analysis.spin_orbit_section(system, [0.3, 3.5], 1.4, 2)
    assert np.allclose(section.x[:, 0], [0.3, 3.5 - np.pi], rtol=1e-14, atol=0)
    assert np.allclose(section.y[:, 0], 1.4, rtol=1e-14, atol=0)
    positions = np.stack([np.asarray(x) for x in orbit.position_at(section.motion.times)], axis=-1)
    assert np.allclose(np.linalg.norm(positions, axis=-1), orbit.periapsis_distance, rtol=1e-14, atol=0)
    assert np.allclose(system.omega_body(section.motion.initial), (0, 0, 1.4), rtol=0, atol=1e-14)
    one = pt.analysis.spin_orbit_section(system, 0.3, 1.4, 2)
    assert np.allclose(one.x, section.x[:1], rtol=1e-11, atol=0)


def test_rates_of_a_spin_orbit_section_are_those_of_the_unit_of_time():
    """The same motion in seconds and in hours."""
    seen = []
    for unit, hour in (("s", 1.0), ("h", 3600.0)):
        orbit = pt.KeplerOrbit(
            3.0 * hour**2, semimajor_axis=2.0, eccentricity=0.2, inclination=0.5, node=0.6, argument_of_periapsis=0.7
        )
        system = pt.System(BODY, pt.GravityGradient(orbit), units={"time": unit})
        section = pt.analysis.spin_orbit_section(system, 0.3, 1.4 * hour, 3)
        assert section.labels[1] == f"angular velocity [rad/{unit}]"
        seen.append((section.x, section.y / hour))
    np.testing.assert_allclose(seen[1], seen[0], rtol=1e-10)
    assert seen[0][1][0, 0] == pytest.approx(1.4, rel=1e-14, abs=0)


class Spinner(pt.Torque):
    """A torque about the normal of an orbit."""

    size: float
    orbit: pt.Orbit

    def torque(self, instant):  # noqa: ARG002
        return pt.functions.Vector((0.0, 0.0, self.size))


def test_forces_may_share_the_orbit_of_a_spin_orbit_section():
    orbit = pt.KeplerOrbit(
        3.0, semimajor_axis=2.0, eccentricity=0.2, inclination=0.5, node=0.6, argument_of_periapsis=0.7
    )
    gravity = pt.GravityGradient(orbit)
    alone = pt.analysis.spin_orbit_section(pt.System(BODY, gravity), 0.3, 1.4, 3)
    both = pt.analysis.spin_orbit_section(pt.System(BODY, gravity, Spinner(0.0, orbit)), 0.3, 1.4, 3)
    assert np.allclose(both.y, alone.y, rtol=1e-12, atol=0)
    other = Spinner(
        0.0,
        pt.KeplerOrbit(3.0, semimajor_axis=2.5, eccentricity=0.2, inclination=0.5, node=0.6, argument_of_periapsis=0.7),
    )
    with pytest.raises(TypeError, match=r"must have one KeplerOrbit, got KeplerOrbit, KeplerOrbit\."):
        pt.analysis.spin_orbit_section(pt.System(BODY, gravity, other), 0.3, 1.4, 3)


def test_the_picture_has_all_points_and_the_labels():
    section = pt.analysis.section(
        pt.propagate(FREE, spinning(np.linspace(0.2, 2, 7)), [20.0], events=[ACROSS]),
        time_and_rate,
        0,
        labels=("t [s]", "rate"),
    )
    axes = pt.plot.section(section, title="title")
    drawn = np.concatenate([dots.get_offsets() for dots in axes.collections])
    seen = np.isfinite(section.x)
    assert sorted(map(tuple, drawn.tolist())) == sorted(
        zip(section.x[seen].tolist(), section.y[seen].tolist(), strict=True)
    )
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.figure.get_suptitle()) == ("t [s]", "rate", "title")
    mpl.pyplot.close("all")


def test_angles_of_a_section_are_drawn_in_degrees():
    found = pt.analysis.andoyer_section(FREE, BODY.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2)), 50.0)
    axes = pt.plot.section(found)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("l [deg]", "L / G")
    drawn = np.concatenate([dots.get_offsets() for dots in axes.collections])
    np.testing.assert_allclose(drawn, np.stack([found.x[0] * 180 / np.pi, found.y[0]], axis=-1), rtol=1e-14)
    assert pt.plot.section(found, angle_unit="rad").get_xlabel() == "l [rad]"
    mpl.pyplot.close("all")


@pytest.mark.parametrize(
    ("time", "chosen", "label", "factor"),
    [
        ("d", None, "angular velocity [deg h⁻¹]", 180 / np.pi / 24),
        ("s", "rad", "angular velocity [rad s⁻¹]", 1.0),
        (None, None, "angular velocity [rad / unit of time]", 1.0),
    ],
)
def test_rates_of_a_section_are_drawn_in_a_unit_that_suits_them(time, chosen, label, factor):
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
    system = pt.System(BODY, pt.GravityGradient(orbit), units=time and {"time": time})
    found = pt.analysis.spin_orbit_section(system, [0.3], [1.2], 3)
    axes = pt.plot.section(found, rate_unit=chosen)
    assert axes.get_ylabel() == label
    drawn = np.concatenate([dots.get_offsets() for dots in axes.collections])
    np.testing.assert_allclose(drawn[:, 1], found.y[0] * factor, rtol=1e-14, atol=0)
    mpl.pyplot.close("all")


def test_wrong_arguments_are_refused_in_a_sentence():
    motion = pt.propagate(FREE, spinning(1.0), [5.0], events=[ACROSS])
    orbit = pt.KeplerOrbit(
        3.0, semimajor_axis=2.0, eccentricity=0.2, inclination=0.5, node=0.6, argument_of_periapsis=0.7
    )
    system = pt.System(BODY, pt.GravityGradient(orbit))
    with pytest.raises(TypeError, match=r"motion must be a Trajectory, got int\."):
        pt.analysis.section(3, time_and_rate)
    with pytest.raises(ValueError, match=r"event must be below the 1 events of the motion, got 1\."):
        pt.analysis.section(motion, time_and_rate, 1)
    with pytest.raises(ValueError, match=r"coordinates must be two arrays of shape \(1,\), got \(1,\) and \(1, 3\)\."):
        pt.analysis.section(motion, lambda points: (points.times, points.omega_body), 0)
    with pytest.raises(TypeError, match=r"event must be a whole number of at most 63 bits, got float 0\.0\."):
        pt.analysis.section(motion, time_and_rate, 0.0)
    with pytest.raises(TypeError, match=r"coordinates must be a function of one value, got str 'x'\."):
        pt.analysis.section(motion, "x")
    with pytest.raises(TypeError, match=r"coordinates must return x and y, got NoneType\."):
        pt.analysis.section(motion, lambda _: None)
    with pytest.raises(ValueError, match=r"labels must be two words, got \('x',\)\."):
        pt.analysis.section(motion, time_and_rate, labels=("x",))
    with pytest.raises(ValueError, match=r"rate must have as many members as angle, got 2 and 3\."):
        pt.analysis.spin_orbit_section(system, [0.0, 1.0, 2.0], [1.0, 1.5], 3)
    with pytest.raises(TypeError, match=r"the forces of the system must have one KeplerOrbit, got none\."):
        pt.analysis.spin_orbit_section(FREE, 0.0, 1.0, 3)
    with pytest.raises(ValueError, match=r"revolutions must be positive, got 0\."):
        pt.analysis.spin_orbit_section(system, 0.0, 1.0, 0)
    with pytest.raises(ValueError, match=r"one for all members"):
        pt.analysis.spin_orbit_section(
            pt.System(
                BODY,
                pt.GravityGradient(
                    pt.KeplerOrbit(
                        3.0,
                        semimajor_axis=2.0,
                        eccentricity=[0.2, 0.3],
                        inclination=0.5,
                        node=0.6,
                        argument_of_periapsis=0.7,
                    )
                ),
            ),
            0.0,
            1.0,
            3,
        )
    with pytest.raises(TypeError, match=r"section must be a Section, got int\."):
        pt.plot.section(3)
