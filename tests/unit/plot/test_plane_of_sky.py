"""Pictures of a body in the plane of the sky: directions, brightness, shadows, arrows and errors."""

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Annotation

import poinsot as pt
from poinsot.observables import Lambert, LightCurve, LommelSeeliger

UNITS = {"time": "s", "inertia": "kg km2"}
BALL = pt.shapes.Ellipsoid((1.0, 1.0, 1.0), density=1e12)
BODY = pt.Body((2.0, 2.5, 3.5))
OBSERVER = (1.0, -2.0, 0.5)
"""Direction of the body from the observer."""
ARROWS = {"#000000": "angular momentum", "#009E73": "angular velocity", "#E69F00": "Sun"}


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


def at(place, distance=1e6):
    return pt.orbits.FixedPosition(1.0, position=distance * np.asarray(place) / np.linalg.norm(place))


def curve(shape=BALL, sun=(0, 1, 0.2), law=None, observer=OBSERVER, **options) -> Any:
    given = {"kind": "relative", "light_time": False} | options
    return LightCurve(shape, law or Lambert(0.2), sun=at(sun), observer=at(observer), **given)


def motion_of(attitude=(1, 0, 0, 0), rate=(0.1, 0.2, 0.4), body=BODY) -> Any:
    return pt.free_motion(body, body.state(attitude, omega_body=rate), np.linspace(0, 60, 61), units=UNITS)


def sky_axes(observer=OBSERVER, north=(0, 0, 1)):
    """East and north on the sky at the body, seen from inside the sphere: east is where longitudes increase."""
    u = np.asarray(observer) / np.linalg.norm(observer)
    east = np.cross(north, u)
    east /= np.linalg.norm(east)
    return east, np.cross(u, east)


def arrows_of(panel):
    """The directions on the screen, to the right and upwards, by name; the first picture's."""
    found = {}
    for each in panel.texts:
        if isinstance(each, Annotation) and each.arrow_patch is not None:
            name = ARROWS[mpl.colors.to_hex(each.arrow_patch.get_edgecolor(), keep_alpha=False).upper()]
            found.setdefault(name, np.subtract(each.xy, each.xyann))
    return found


def drawn(panel, picture=0):
    """Middles of the facets and their greys."""
    collection = panel.collections[picture]
    corners = np.array([path.vertices[:-1] for path in collection.get_paths()])
    return np.mean(corners, axis=1), collection.get_facecolors()[:, 0]


@pytest.mark.parametrize("north", [(0, 0, 1), (0.3, 0.2, 2.0)])
def test_north_is_upwards_and_east_is_to_the_left(north):
    motion, sun = motion_of(), (0.3, 1, 0.2)
    found = arrows_of(pt.plot.sky(motion, curve(sun=sun), north=north))
    east, up = sky_axes(north=north)
    vectors = {
        "Sun": -np.array(sun),
        "angular momentum": motion.angular_momentum_space[0],
        "angular velocity": motion.omega_space[0],
    }
    for name, vector in vectors.items():
        unit = vector / np.linalg.norm(vector)
        expected = 1.45 * np.array([-unit @ east, unit @ up])
        np.testing.assert_allclose(found[name], expected, rtol=0, atol=1e-9)


def test_the_side_towards_the_sun_is_bright():
    """A ball that the Sun lights from the right, at a phase angle of 90 degrees."""
    east, _ = sky_axes()
    middles, grey = drawn(pt.plot.sky(motion_of(), curve(sun=east)))  # from the Sun to the body: the Sun is in the west
    assert np.all(grey[middles[:, 0] < -0.02] == pytest.approx(0.12, rel=0, abs=1e-9))
    right = middles[:, 0] > 0.1
    shade = (grey[right] - 0.12) / 0.85
    expected = np.sqrt(np.clip(middles[right, 0], 0, 1))  # Lambert: mu0 is the distance to the right of the middle
    np.testing.assert_allclose(shade, expected / np.sqrt(np.max(middles[:, 0])), rtol=0, atol=0.02)


def test_each_time_has_a_picture_with_its_attitude():
    """A long body is at each time where its attitude is; rows of four."""
    long = pt.shapes.Ellipsoid((3.0, 0.3, 0.3), density=1e12)
    motion, times = motion_of(), np.arange(0.0, 30, 5)
    panel = pt.plot.sky(motion, curve(shape=long), times, time_unit="s")
    assert len(panel.collections) == times.size
    assert [text.get_text() for text in panel.texts if text.get_text().startswith("time")] == [
        f"time {t:g} s" for t in times
    ]
    east, up = sky_axes()
    for i in range(times.size):
        middles, _ = drawn(panel, i)
        centre = 3.1 * 3.0 * np.array([i % 4, -(i // 4)])
        axis = motion.attitude[int(times[i])].apply((1, 0, 0))
        seen = np.array([-axis @ east, axis @ up])
        offsets = middles - centre
        longest = np.linalg.svd(offsets - offsets.mean(axis=0), full_matrices=False)[2][0]
        assert abs(longest @ seen) / np.linalg.norm(seen) == pytest.approx(1, rel=0, abs=0.02)


def test_light_time_shows_an_earlier_attitude():
    motion, distance = motion_of(), 10 * 299792.458  # ten seconds
    late = LightCurve(BALL, Lambert(0.2), sun=at((0, 1, 0)), observer=at(OBSERVER, distance), kind="relative")
    seen = arrows_of(pt.plot.sky(motion, late, [30.0]))["angular velocity"]
    before = arrows_of(pt.plot.sky(motion, curve(sun=(0, 1, 0)), [20.0]))["angular velocity"]
    now = arrows_of(pt.plot.sky(motion, curve(sun=(0, 1, 0)), [30.0]))["angular velocity"]
    np.testing.assert_allclose(seen, before, rtol=0, atol=1e-9)
    assert np.linalg.norm(seen - now) > 0.01


def corner():
    """A floor, 4 x 4 x 0.2, with a wall of 0.2 x 4 x 2 on it, along the second axis through the middle."""
    profile = [(-2, 0), (2, 0), (2, 0.2), (0.1, 0.2), (0.1, 2.2), (-0.1, 2.2), (-0.1, 0.2), (-2, 0.2)]
    ends = [(0, 1, 2), (0, 2, 3), (0, 3, 6), (0, 6, 7), (3, 4, 5), (3, 5, 6)]
    n = len(profile)
    vertices = [(x, y, z) for y in (-2.0, 2.0) for x, z in profile]
    faces = [*ends, *[(a + n, c + n, b + n) for a, b, c in ends]]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, i + n, j + n), (i, j + n, j)]
    return pt.shapes.Mesh(vertices, faces, mass=1.0)


def test_a_wall_throws_a_shadow_on_the_floor():
    """Seen from above; the Sun is 45 degrees high over the first axis, and the shadow as long as the wall is high."""
    mesh = corner()
    origin = mesh.center_of_mass
    still = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [0.0, 1.0], units=UNITS)
    seen = curve(shape=mesh, sun=(-1, 0, -1), observer=(0, 0, -1), law=LommelSeeliger(0.2))
    middles, grey = drawn(pt.plot.sky(still, seen, north=(0, 1, 0)))
    x, y = middles[:, 0] + origin[0], middles[:, 1] + origin[1]
    floor = (np.abs(y) < 1.8) & (np.abs(x) > 0.3)
    dark = grey < 0.13
    assert np.all(dark[floor & (x < -0.3) & (x > -1.9)])
    assert not np.any(dark[floor & (x > 0.3)])
    without = curve(shape=mesh, sun=(-1, 0, -1), observer=(0, 0, -1), law=LommelSeeliger(0.2), shadows="none")
    assert not np.any(drawn(pt.plot.sky(still, without, north=(0, 1, 0)))[1] < 0.13)


def test_facets_are_drawn_without_shadows():
    box = pt.forces.Facets.from_box((1, 1, 1), wing_areas=[1], wing_normals=[(0, 0, 1)], wing_positions=[(1.5, 0, 0)])
    middles, grey = drawn(pt.plot.sky(motion_of(), curve(shape=box, sun=(1, 0.3, -0.5))))
    assert len(middles) > 500
    assert np.unique(grey.round(6)).size <= 1 + 7


def test_a_glint_does_not_darken_the_other_facets():
    _, matt = drawn(pt.plot.sky(motion_of(), curve(sun=OBSERVER)))
    shiny = curve(sun=OBSERVER, law=pt.observables.Phong(0.1, 0.9, 2000))
    _, grey = drawn(pt.plot.sky(motion_of(), shiny))
    assert np.median(grey) > 0.3
    assert np.max(grey) == pytest.approx(np.max(matt), rel=0, abs=1e-3)


def test_the_scale_is_a_round_length_in_the_unit_of_the_system():
    panel = pt.plot.sky(motion_of(), curve(shape=pt.shapes.Ellipsoid((3.0, 2.0, 2.0), density=1.0)))
    [line] = [each for each in panel.lines if len(np.asarray(each.get_xdata())) == 2]
    assert abs(np.diff(np.asarray(line.get_xdata()))[0]) == pytest.approx(2.0, rel=1e-12, abs=0)
    assert "2 km" in [text.get_text() for text in panel.texts]
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("east to the left", "north upwards")
    assert [text.get_text() for text in panel.get_legend().get_texts()] == list(ARROWS.values())


def test_north_along_the_line_of_sight_is_refused():
    for north in (OBSERVER, (0, 0, 0)):
        with pytest.raises(ValueError, match=r"^north must not be zero or along the line of sight, got \[.*\]\. Give"):
            pt.plot.sky(motion_of(), curve(), north=north)


def test_times_that_the_motion_does_not_reach_are_refused():
    system = pt.System(BODY, units=UNITS)
    start = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.4))
    stopped = pt.propagate(system, start, np.arange(10.0), events=[pt.events.SpinFlip((1, 0, 0), terminal=True)])
    assert stopped.times.size < 10
    with pytest.raises(ValueError, match=r"^times must be times that the motion reaches, got 9\.0\.$"):
        pt.plot.sky(stopped, curve(), [0.0, 9.0])
    with pytest.raises(ValueError, match=r"^times must have shape \(n,\), got the number 3\.0\. Write \[3\.0\]\.$"):
        pt.plot.sky(motion_of(), curve(), 3.0)


def test_light_curves_of_members_are_refused():
    with pytest.raises(ValueError, match=r"^curve must be one light curve, got 2 members\. Pass one of them\.$"):
        pt.plot.sky(motion_of(), curve(stretch=np.ones((2, 3))))


def test_a_light_curve_of_two_bodies_is_refused():
    with pytest.raises(ValueError, match=r"^curve must be of one body, got a light curve of two bodies\. Draw"):
        pt.plot.sky(motion_of(), curve(shape=(BALL, BALL), shadows=False))
