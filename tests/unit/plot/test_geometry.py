"""The pictures of free rotation show what they say: facts of the lines drawn, not of pixels."""

import io
import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpl_toolkits.mplot3d.proj3d import proj_transform
from scipy import special
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.analysis import polhodes
from poinsot.plot import page_content
from poinsot.plot.labels import BLACK, BLUE, GREEN, GREY, VERMILION
from poinsot.plot.solids import DrawnEllipsoid, DrawnSolid, right_and_up, solid_axes, view_direction
from poinsot.propagation.column_reader import MotionRows

SI = {"time": "s", "inertia": "kg m2"}
TURNED = Rotation.from_rotvec([0.4, -0.9, 0.5]).as_matrix()
BODIES = {
    "paper": pt.Body((1.25, 1.0, 0.75)),
    "triaxial": pt.Body((2.0, 2.5, 3.5)),
    "needle": pt.Body((1.1, 0.15, 1.0)),
    "plate": pt.Body((1.0, 2.9, 1.9)),
    "prolate": pt.Body((3.0, 3.0, 1.2)),
    "oblate": pt.Body((2.6, 1.5, 1.5)),
    "sphere": pt.Body((2.0, 2.0, 2.0)),
    "oblique": pt.Body.from_inertia(TURNED @ np.diag([2.0, 3.0, 4.0]) @ TURNED.T),
}
TRIAXIAL = ["paper", "triaxial", "needle", "plate", "oblique"]
MOMENTA = {"short": (0.5, 0.6, 1.5), "long": (1.5, 0.2, -0.3), "near_separatrix": (0.0, 2.0, 0.01)}


@pytest.fixture(autouse=True)
def no_window():
    mpl.use("Agg")
    yield
    plt.close("all")


def motion_of(body, g=(0.5, -0.7, 1.1), times=None, units=None):
    state = body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g)
    return pt.propagate(pt.System(body, units=units), state, np.linspace(0, 40, 801) if times is None else times)


@pytest.fixture(scope="module", params=BODIES)
def motion(request):
    return motion_of(BODIES[request.param])


def points(line):
    """The points of a 3D line, without the gaps."""
    xyz = np.stack(np.broadcast_arrays(*line.get_data_3d()), axis=-1).astype(float)
    return xyz[~np.isnan(xyz[:, 0])]


def drawn(axes, colour, zorder=(2, 3)):
    """The points of each line of a colour on the surface of a solid, far (2) or near (3)."""
    lines = [points(line) for line in axes.lines if line.get_color() == colour and line.get_zorder() in zorder]
    return [line for line in lines if len(line)]


def labels(axes):
    return [text.get_text() for legend in axes.figure.legends for text in legend.get_texts()]


def upright(G):
    """The matrix of the shortest rotation that takes G to the third axis."""
    axis = np.cross(G, (0, 0, 1))
    angle = np.arctan2(np.linalg.norm(axis), G[2])
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()


def inertia_drawn(motion, index):
    """The inertia tensor in the axes of `pt.plot.poinsot_construction`."""
    A = upright(motion.angular_momentum_space[0]) @ motion.attitude[index].as_matrix()
    return A @ motion.system.body.inertia @ A.T


# ---------------------------------------------------------------------- Poinsot's construction


def test_polhode_of_the_construction_keeps_energy_and_momentum(motion):
    index = -1
    inertia, G = inertia_drawn(motion, index), np.linalg.norm(motion.angular_momentum_space[index])
    for omega in drawn(pt.plot.poinsot_construction(motion, index), BLUE):
        momentum = omega @ inertia
        assert np.allclose(np.sum(omega * momentum, axis=-1), 2 * motion.kinetic_energy[index], rtol=1e-12, atol=0)
        assert np.allclose(np.linalg.norm(momentum, axis=-1), G, rtol=1e-12, atol=0)


def test_the_plane_touches_the_ellipsoid_at_the_tip_of_omega(motion):
    index = 137
    axes, inertia = pt.plot.poinsot_construction(motion, index), inertia_drawn(motion, index)
    (tip,) = (points(line)[0] for line in axes.lines if line.get_marker() == "o")
    G = inertia @ tip  # half the gradient of omega . I omega: the normal
    size = np.linalg.norm(motion.angular_momentum_space[index])
    assert np.allclose(G, (0, 0, size), rtol=0, atol=1e-14 * size)
    height = np.sqrt(2 * motion.kinetic_energy[index] * np.linalg.inv(inertia)[2, 2])  # of the ellipsoid's top
    (herpolhode,) = (points(line) for line in axes.lines if line.get_color() == VERMILION)
    assert np.allclose(herpolhode[:, 2], tip[2], rtol=1e-12, atol=0)
    assert np.isclose(tip[2], height, rtol=1e-12, atol=0)
    assert np.allclose(herpolhode[index], tip, rtol=0, atol=1e-12 * size)
    polhode = np.concatenate(drawn(axes, BLUE))
    assert np.min(np.linalg.norm(polhode - tip, axis=-1)) < 0.01 * np.linalg.norm(tip)


def test_omega_and_momentum_start_at_the_centre_and_the_momentum_is_vertical():
    axes = pt.plot.poinsot_construction(motion_of(BODIES["paper"]))
    shafts = [points(line) for line in axes.lines if len(points(line)) == 2]
    assert sum(not np.any(shaft[0]) for shaft in shafts) == 2
    assert sum(not np.any(shaft[:, :2]) for shaft in shafts) == 2


def test_the_construction_is_drawn_with_g_up_for_momenta_along_the_axes():
    body = BODIES["triaxial"]
    for G in ((0, 0, 1.0), (0, 0, -1.0), (1e-9, 0, -1.0), (1.0, 0, 0)):
        state = body.state((1, 0, 0, 0), angular_momentum_space=G)
        axes = pt.plot.poinsot_construction(pt.propagate(pt.System(body), state, [0.0, 1.0]))
        tip = next(points(line)[0] for line in axes.lines if line.get_marker() == "o")
        assert np.isclose(tip[2], 2 * body.kinetic_energy(state.angular_momentum_body), rtol=1e-12)


def test_lengths_on_paper_are_lengths_across_the_line_of_sight(rng):
    motion, x = motion_of(BODIES["needle"]), rng.normal(size=(20, 3))
    for axes in (
        pt.plot.poinsot_construction(motion),
        pt.plot.polhode(motion),
        pt.plot.momentum_sphere(motion),
    ):
        right, up = right_and_up(view_direction((axes.elev, axes.azim)))
        paper = np.stack(proj_transform(*x.T, axes.get_proj())[:2])
        scale = (paper[0, 1] - paper[0, 0]) / ((x[1] - x[0]) @ right)
        seen = scale * np.stack([x @ right, x @ up])
        assert np.allclose(np.diff(paper), np.diff(seen), rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- polhode and herpolhode


def test_every_line_of_the_polhode_picture_lies_on_the_ellipsoid(motion):
    axes, body = pt.plot.polhode(motion), motion.system.body
    for line in axes.lines:
        omega = points(line)
        if len(omega):
            energy = body.kinetic_energy(body.angular_momentum(omega))
            assert np.allclose(energy, motion.kinetic_energy[-1], rtol=1e-12, atol=0)


def test_the_path_of_omega_is_that_of_the_motion_in_the_given_axes(motion):
    path = np.concatenate(drawn(pt.plot.polhode(motion), BLUE))
    assert {tuple(omega) for omega in path} == {tuple(omega) for omega in motion.omega_body}


def test_the_path_of_omega_is_the_closed_form_in_elliptic_functions():
    """Landau and Lifshitz, Mechanics, Sec. 37: cn, sn, dn where G^2 > 2T I_2, the start at omega_2 = 0."""
    I1, I2, I3 = moments = np.array([2.0, 2.5, 3.5])
    g = np.array([0.9, 0.0, 1.4])
    times = np.linspace(0, 60, 601)
    (path,) = drawn(pt.plot.polhode(motion_of(pt.Body(moments), g, times), view=(90, 0)), BLUE)
    energy, size = np.sum(g**2 / moments), np.sum(g**2)
    tau = times * np.sqrt((I3 - I2) * (size - energy * I1) / np.prod(moments))
    m = (I2 - I1) * (energy * I3 - size) / ((I3 - I2) * (size - energy * I1))
    sn, cn, dn, _ = special.ellipj(tau, m)
    expected = np.stack(
        [
            np.sqrt((energy * I3 - size) / (I1 * (I3 - I1))) * cn,
            np.sqrt((energy * I3 - size) / (I2 * (I3 - I2))) * sn,
            np.sqrt((size - energy * I1) / (I3 * (I3 - I1))) * dn,
        ],
        axis=-1,
    )
    assert np.allclose(path, expected, rtol=0, atol=1e-12)


def test_the_path_in_the_invariable_plane_is_the_closed_form_in_elliptic_functions():
    """The radius of the same motion, rho^2 = |omega|^2 - (2T/G)^2."""
    moments, g, times = np.array([2.0, 2.5, 3.5]), np.array([0.9, 0.0, 1.4]), np.linspace(0, 60, 601)
    I1, I2, I3 = moments
    axes = pt.plot.herpolhode(motion_of(pt.Body(moments), g, times))
    (path,) = (np.hypot(*line.get_data()) for line in axes.lines if line.get_color() == VERMILION)
    energy, size = np.sum(g**2 / moments), np.sum(g**2)
    m = (I2 - I1) * (energy * I3 - size) / ((I3 - I2) * (size - energy * I1))
    sn = special.ellipj(times * np.sqrt((I3 - I2) * (size - energy * I1) / np.prod(moments)), m)[0]
    squares = np.sum((g / moments) ** 2) + sn**2 * (
        (energy * I3 - size) * (1 / (I2 * (I3 - I2)) - 1 / (I1 * (I3 - I1)))
        - m * (size - energy * I1) / (I3 * (I3 - I1))
    )
    assert np.allclose(path**2, squares - energy**2 / size, rtol=0, atol=1e-14)


def test_other_polhodes_keep_the_momentum_too():
    motion = motion_of(BODIES["oblique"])
    axes, body = pt.plot.polhode(motion), motion.system.body
    for omega in drawn(axes, GREY) + drawn(axes, BLACK):
        G = np.linalg.norm(body.angular_momentum(omega), axis=-1)
        assert np.allclose(G, G[0], rtol=1e-14, atol=0)


def test_a_forced_polhode_is_drawn_without_ellipsoid(top, start):
    motion = pt.propagate(top, start, np.linspace(0, 5, 51))
    axes = pt.plot.polhode(motion)
    path, point = (points(line) for line in axes.lines)
    assert np.array_equal(path, motion.omega_body)
    assert np.array_equal(point[0], motion.omega_body[-1])


def test_names_of_axes_do_not_cover_long_numbers():
    body, orbit = (
        pt.Body((500, 600, 400)),
        pt.KeplerOrbit(398600.4418, semimajor_axis=7000, eccentricity=0.01, inclination=0.9),
    )
    start = body.state((0.5, -0.5, 0.5, -0.5), omega_body=(0, -1.08e-3, 2e-4))
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit), units=SI), start, np.linspace(0, 29000, 301))
    panel = pt.plot.polhode(motion, view=(20, -60))
    panel.figure.canvas.draw()
    widest = max(text.get_window_extent().width for text in panel.zaxis.get_majorticklabels())
    name, line = panel.zaxis.label.get_window_extent(), panel.zaxis.line.get_window_extent()
    assert max(name.x0 - line.x1, line.x0 - name.x1) > widest


def test_a_polhode_may_start_at_rest_under_forces(top, body):
    start = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0, 0, 0))
    pt.plot.polhode(pt.propagate(top, start, np.linspace(0, 1, 11)))


@pytest.mark.parametrize("mode", MOMENTA)
@pytest.mark.parametrize("name", TRIAXIAL)
def test_herpolhode_stays_between_its_circles_and_reaches_them(name, mode):
    motion = motion_of(BODIES[name], MOMENTA[mode], np.linspace(0, 200, 20001))
    axes = pt.plot.herpolhode(motion)
    radii = sorted(np.hypot(*line.get_data())[0] for line in axes.lines if line.get_color() == GREY)
    (path,) = (np.hypot(*line.get_data()) for line in axes.lines if line.get_color() == VERMILION)
    size = np.max(np.linalg.norm(motion.omega_body, axis=-1))
    assert radii[0] - 1e-12 * size <= np.min(path) < radii[0] + 1e-3 * size
    assert radii[1] - 1e-3 * size < np.max(path) <= radii[1] + 1e-12 * size
    G = motion.angular_momentum_space / np.linalg.norm(motion.angular_momentum_space, axis=-1, keepdims=True)
    across = np.linalg.norm(np.cross(motion.omega_space, G), axis=-1)
    assert np.allclose(path, across, rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("name", ["prolate", "oblate"])
def test_herpolhode_of_a_symmetric_body_is_a_circle(name):
    motion = motion_of(BODIES[name])
    axes = pt.plot.herpolhode(motion)
    radii = [np.hypot(*line.get_data())[0] for line in axes.lines if line.get_color() == GREY]
    (path,) = (np.hypot(*line.get_data()) for line in axes.lines if line.get_color() == VERMILION)
    assert np.allclose(radii, radii[0], rtol=1e-12, atol=0)
    assert np.allclose(path, radii[0], rtol=1e-12, atol=0)


def test_herpolhode_has_equal_aspect_and_turns_as_the_construction_does():
    motion = motion_of(BODIES["triaxial"])
    flat, solid = pt.plot.herpolhode(motion), pt.plot.poinsot_construction(motion)
    assert flat.get_aspect() == 1
    (path,) = (np.stack(line.get_data()) for line in flat.lines if line.get_color() == VERMILION)
    (same,) = (points(line)[:, :2].T for line in solid.lines if line.get_color() == VERMILION)
    assert np.array_equal(path, same)


@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_steady_rotation_is_drawn(axis):
    motion = motion_of(BODIES["triaxial"], axis, [0.0, 1.0, 2.0])
    for plot in (pt.plot.poinsot_construction, pt.plot.polhode, pt.plot.herpolhode):
        plot(motion)


# ---------------------------------------------------------------------- the sphere of angular momentum


@pytest.mark.parametrize("name", BODIES)
def test_curves_of_the_sphere_keep_momentum_and_energy(name):
    body = BODIES[name]
    state = body.state((1, 0, 0, 0), angular_momentum_body=(0.5, -0.7, 1.1))
    axes = pt.plot.momentum_sphere(body, state)
    d = 1 / body.moments
    for colour in (BLUE, VERMILION, BLACK, GREEN):
        for n in drawn(axes, colour):
            D = n**2 @ d
            assert np.allclose(np.linalg.norm(n, axis=-1), 1, rtol=0, atol=1e-14)
            assert np.allclose(D, D[0], rtol=1e-14, atol=0)


@pytest.mark.parametrize("name", TRIAXIAL)
def test_modes_lie_on_their_sides_of_the_separatrices(name):
    body = BODIES[name]
    axes = pt.plot.momentum_sphere(body)
    long, middle, short = np.argsort(body.moments)
    d = 1 / body.moments
    for colour, k, sign in ((BLUE, short, -1), (VERMILION, long, 1)):
        lines = drawn(axes, colour)
        assert len(lines) >= 10
        for n in lines:
            assert np.all(sign * (n**2 @ d - d[middle]) > 0)
            assert np.all(n[:, k] > 0) or np.all(n[:, k] < 0)  # round one end of its axis
    for n in drawn(axes, BLACK):
        assert np.allclose(n**2 @ d, d[middle], rtol=1e-14, atol=0)
    assert labels(axes) == ["short-axis mode", "long-axis mode", "separatrices"]


@pytest.mark.parametrize("name", TRIAXIAL)
def test_separatrices_cross_at_the_intermediate_axis(name):
    moments = BODIES[name].moments
    middle = np.eye(3)[np.argsort(moments)[1]]
    lines = polhodes.separatrices(moments)
    assert len(lines) == 2
    for n in lines:
        for end in (middle, -middle):
            assert np.min(np.linalg.norm(n - end, axis=-1)) < 1e-15


def test_a_motion_goes_along_its_curve_in_the_principal_axes():
    body = BODIES["oblique"]
    motion = motion_of(body)
    g = motion.angular_momentum_body @ body.principal_axes.as_matrix()
    n = g / np.linalg.norm(g, axis=-1, keepdims=True)
    path = np.concatenate(drawn(pt.plot.momentum_sphere(motion), GREEN))
    between = np.linalg.norm(path[:, None] - n, axis=-1)
    assert max(np.max(np.min(between, axis=0)), np.max(np.min(between, axis=1))) < 1.5e-15
    curve = polhodes.energy_curve(body.moments, n[0])
    distances = np.linalg.norm(n[:, None] - curve, axis=-1)
    assert np.max(np.min(distances, axis=-1)) < 0.01


@pytest.mark.parametrize(("name", "axis", "word"), [("prolate", 2, "long-axis mode"), ("oblate", 0, "short-axis mode")])
def test_curves_of_a_symmetric_body_are_circles_of_latitude(name, axis, word):
    axes = pt.plot.momentum_sphere(BODIES[name])
    for n in drawn(axes, BLUE) + drawn(axes, VERMILION):
        assert np.allclose(n[:, axis], n[0, axis], rtol=0, atol=1e-15)
    for n in drawn(axes, BLACK):
        assert np.allclose(n[:, axis], 0, rtol=0, atol=1e-15)
    assert labels(axes) == [word, "fixed directions"]


def test_states_are_marked_together_with_a_motion():
    motion = motion_of(BODIES["oblique"])
    body, alone = motion.system.body, pt.plot.momentum_sphere(motion)
    state = body.state((1, 0, 0, 0), omega_body=(1, 2, 3))
    both, marked = pt.plot.momentum_sphere(motion, state), pt.plot.momentum_sphere(body, state)
    assert set(labels(both)) == set(labels(alone)) | set(labels(marked))
    assert len(both.lines) - len(alone.lines) == len(marked.lines) - len(pt.plot.momentum_sphere(body).lines)


def test_a_spherical_body_has_no_curves_and_the_title_says_so():
    body = BODIES["sphere"]
    state = body.state((1, 0, 0, 0), omega_body=(1, 2, 3))
    axes = pt.plot.momentum_sphere(body, state)
    assert axes.figure.get_suptitle().startswith("Spherical body: ")
    assert not any(drawn(axes, colour) for colour in (BLUE, VERMILION, BLACK, GREEN))
    assert not pt.plot.momentum_sphere(body).figure.legends


def test_each_of_an_array_of_states_is_marked():
    body = BODIES["triaxial"]
    g = np.array([(1, 2, 3), (-1, 2, 0.5), (0, 0, 1.0)])
    axes = pt.plot.momentum_sphere(body, body.state([(1, 0, 0, 0)] * 3, angular_momentum_body=g))
    marks = np.concatenate([points(line) for line in axes.lines if line.get_marker() == "o"])
    assert np.allclose(marks, g / np.linalg.norm(g, axis=-1, keepdims=True), rtol=0, atol=1e-15)


NAMES = {
    "triaxial": ["long axis", "intermediate axis", "short axis"],
    "paper": ["short axis", "intermediate axis", "long axis"],
    "prolate": ["equatorial axis", "equatorial axis", "long axis"],
    "oblate": ["short axis", "equatorial axis", "equatorial axis"],
    "sphere": ["axis", "axis", "axis"],
}


@pytest.mark.parametrize("name", NAMES)
def test_principal_axes_are_named_at_their_near_ends(name):
    body = BODIES[name]
    axes = pt.plot.momentum_sphere(body, body.state((1, 0, 0, 0), angular_momentum_body=(1, -2, 3)))
    ends = [rf"$\mathbf{{e}}_{i}$" for i in (1, 2, 3)]
    ends[1] = r"$-\mathbf{e}_2$"
    expected = [f"{word}\n{end}" for word, end in zip(NAMES[name], ends, strict=True)]
    assert [text.get_text() for text in axes.texts] == expected


# ---------------------------------------------------------------------- what is near and what is far


@pytest.mark.parametrize("view", [(30, 40), (-50, 200), (90, 0), (-90, 0), (0, 0)])
def test_what_is_hidden_is_faded(view):
    eye = view_direction(view)
    ellipsoid = DrawnEllipsoid(TURNED, np.array([1.0, 2.0, 0.5]))
    solid = DrawnSolid(solid_axes(eye, ""), ellipsoid, eye)
    count = len(solid.axes.lines)
    for pole in np.eye(3):
        solid.curve(ellipsoid.section(pole), BLUE, 1)
    for line in solid.axes.lines[count:]:
        facing = ellipsoid.normals(points(line)) @ eye / np.linalg.norm(ellipsoid.normals(points(line)), axis=-1)
        near = line.get_alpha() == 1
        assert np.all(facing > -0.05) if near else np.all(facing < 0.05)  # they overlap by a segment
    outline = ellipsoid.outline(eye)
    assert np.allclose(ellipsoid.normals(outline) @ eye, 0, rtol=0, atol=1e-14)
    inside = outline @ TURNED / ellipsoid.semiaxes
    assert np.allclose(np.linalg.norm(inside, axis=-1), 1, rtol=0, atol=1e-14)


def test_eye_is_given_by_elevation_and_azimuth():
    assert np.allclose(view_direction((0, 90)), (0, 1, 0), rtol=0, atol=1e-15)
    assert np.allclose(view_direction((90, 30)), (0, 0, 1), rtol=0, atol=1e-15)
    axes = pt.plot.poinsot_construction(motion_of(BODIES["paper"]), view=(-25, 100))
    assert np.allclose((axes.elev, axes.azim), (-25, 100), rtol=1e-14, atol=0)


def test_the_state_is_on_the_near_side():
    for g in ((1, 2, 3), (-1, 0.3, -2), (0.1, -3, 0)):
        for name in ("paper", "oblique"):
            body = BODIES[name]
            axes = pt.plot.momentum_sphere(body, body.state((1, 0, 0, 0), angular_momentum_body=g))
            (mark,) = (line for line in axes.lines if line.get_marker() == "o")
            assert mark.get_alpha() == 1


# ---------------------------------------------------------------------- words


def test_labels_carry_units():
    motion = motion_of(BODIES["paper"], times=[0.0, 2.5], units=SI)
    axes = pt.plot.poinsot_construction(motion)
    assert axes.get_xlabel() == r"$\omega_x \perp \mathbf{G}$ [rpm]"
    assert axes.get_zlabel() == r"$\omega_z \parallel \mathbf{G}$ [rpm]"
    assert axes.figure.get_suptitle() == "Poinsot's construction at time 2.5 s"
    assert pt.plot.polhode(motion).get_zlabel() == r"$\omega_3$ [rpm]"
    assert pt.plot.herpolhode(motion).get_ylabel() == r"$\omega_y \perp \mathbf{G}$ [rpm]"


def test_labels_without_units_say_so():
    motion = motion_of(BODIES["paper"], times=[0.0, 2.5])
    assert pt.plot.polhode(motion).get_xlabel() == r"$\omega_1$ [rad / unit of time]"
    assert pt.plot.poinsot_construction(motion).figure.get_suptitle() == "Poinsot's construction at time 2.5"


def test_the_sphere_of_a_forced_body_says_whose_curves_are_drawn(top):
    start = BODIES["paper"].state((0.1, 0.7, -0.5, 0.5), omega_body=(0.1, 0.2, 0.3))
    forced = pt.propagate(top, start, np.linspace(0, 1, 11))
    damper = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.parts.KaneDamper(0.1, 0.05))
    damped = pt.propagate(damper, damper.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 1.0])
    free = motion_of(BODIES["paper"])
    titles = [pt.plot.momentum_sphere(each).figure.get_suptitle() for each in (forced, damped, free, BODIES["paper"])]
    assert ["curves of the body free of torques" in title for title in titles] == [True, True, False, False]


SOLIDS = pt.plot.poinsot_construction, pt.plot.polhode, pt.plot.momentum_sphere
VIEWS = None, (20, -60), (-35, 200)


@pytest.mark.parametrize(
    ("plot", "name", "view"),
    [
        (plot, name, VIEWS[(i + j) % 3])  # each two of plot, body and view meet
        for i, plot in enumerate(SOLIDS)
        for j, name in enumerate(("paper", "needle", "plate"))
    ],
)
def test_the_solid_fills_its_figure(plot, name, view):
    """The lines take most of the width or the height; all of them, and all names, lie inside and above the legend."""
    axes = plot(motion_of(BODIES[name], units=SI), view=view)
    figure = axes.figure
    figure.canvas.draw()
    lines = [np.stack(line.get_data(), axis=-1) for line in axes.lines]
    paths = [path.vertices for each in axes.collections for path in each.get_paths()]
    flat = np.concatenate([*lines, *paths]).astype(float)
    seen = figure.transFigure.inverted().transform(axes.transData.transform(flat[~np.isnan(flat[:, 0])]))
    axis_labels = [axis.label for axis in (axes.xaxis, axes.yaxis, axes.zaxis) if axis.get_visible()]
    names = [label.get_window_extent().get_points() for label in axis_labels]
    inside = np.concatenate([seen, *map(figure.transFigure.inverted().transform, names)])
    legend = figure.transFigure.inverted().transform(figure.legends[0].get_window_extent().get_points())
    assert np.max(np.ptp(seen, axis=0)) > 0.6
    assert np.all((inside >= 0) & (inside <= 1))
    assert np.min(inside[:, 1]) >= legend[1, 1]


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_pictures_are_painted(kind):
    motion = motion_of(BODIES["paper"])
    pictures = (
        pt.plot.poinsot_construction,
        pt.plot.polhode,
        pt.plot.herpolhode,
        pt.plot.momentum_sphere,
    )
    for plot in pictures:
        file = io.BytesIO()
        plot(motion).figure.savefig(file, format=kind)
        assert file.tell() > 10_000


# ---------------------------------------------------------------------- what is refused

BODY = BODIES["paper"]
START = BODY.state((1, 0, 0, 0), omega_body=(0.4, -0.3, 0.6))
REST = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0))
FREE = pt.System(BODY)
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)))
MANY = BODY.state([(1, 0, 0, 0)] * 3, omega_body=(0.4, -0.3, 0.6))
ENSEMBLE = "motion must be of one body, got an ensemble of 3 members. Take one: motion.member(0)."
NO_MOTION = "motion must be a Trajectory, got State."
AT_REST = "motion must have an angular momentum, but g = 0. A body at rest has no axis of rotation."
NO_TIMES = "motion must contain times to draw, got none."


def free(state=START):
    return pt.propagate(FREE, state, (0.0, 1.0))


NOTHING = {"quaternion": np.empty((0, 4)), "angular_momentum_body": np.empty((0, 3))}
EMPTY = pt.Trajectory(FREE, START, np.empty(0), MotionRows(NOTHING), free().run)


REFUSED = {
    "index_beyond": (
        lambda: pt.plot.poinsot_construction(free(), 2),
        IndexError,
        "time_index must lie within [-2, 1], got 2.",
    ),
    "index_float": (
        lambda: pt.plot.poinsot_construction(free(), 1.0),
        TypeError,
        "time_index must be a whole number of at most 63 bits, got float 1.0.",
    ),
    "index_truth": (
        lambda: pt.plot.poinsot_construction(free(), True),
        TypeError,
        "time_index must be a whole number of at most 63 bits, got bool True.",
    ),
    "view": (
        lambda: pt.plot.poinsot_construction(free(), view=(1, 2, 3)),
        ValueError,
        "view must have shape (2,), got shape (3,).",
    ),
    "view_word": (
        lambda: pt.plot.momentum_sphere(BODY, view="top"),
        TypeError,
        "view must be real numbers, got str 'top'.",
    ),
    "order": (
        lambda: pt.plot.momentum_sphere(START, BODY),
        TypeError,
        "motion must be a Trajectory or a Body, got State.",
    ),
    "bodies": (
        lambda: pt.plot.momentum_sphere(pt.Body([(1, 1, 1)] * 3)),
        ValueError,
        "motion must be of one body, got an ensemble of 3 members.",
    ),
    "state": (lambda: pt.plot.momentum_sphere(BODY, (1, 0, 0)), TypeError, "state must be a State, got tuple."),
    "state_at_rest": (
        lambda: pt.plot.momentum_sphere(BODY, REST),
        ValueError,
        "state must have an angular momentum, but g = 0. A body at rest has no direction to draw.",
    ),
    "sphere_ensemble": (lambda: pt.plot.momentum_sphere(free(MANY)), ValueError, ENSEMBLE),
    "sphere_empty": (lambda: pt.plot.momentum_sphere(EMPTY), ValueError, NO_TIMES),
    "flat axes": (
        lambda: pt.plot.polhode(free(), ax=plt.figure().add_subplot()),
        TypeError,
        'ax must be 3D axes of matplotlib, got Axes. They come from plt.subplots(subplot_kw={"projection": "3d"}).',
    ),
}
for plot in (pt.plot.poinsot_construction, pt.plot.polhode, pt.plot.herpolhode):
    REFUSED[f"{plot.__name__}_state"] = (lambda plot=plot: plot(START), TypeError, NO_MOTION)
    REFUSED[f"{plot.__name__}_ensemble"] = (
        lambda plot=plot: plot(free(MANY)),
        ValueError,
        ENSEMBLE,
    )
    REFUSED[f"{plot.__name__}_rest"] = (lambda plot=plot: plot(free(REST)), ValueError, AT_REST)
    REFUSED[f"{plot.__name__}_empty"] = (lambda plot=plot: plot(EMPTY), ValueError, NO_TIMES)


@pytest.mark.parametrize("name", REFUSED)
def test_wrong_arguments_are_refused_in_a_sentence(name):
    call, kind, sentence = REFUSED[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence)}$") as caught:
        call()
    assert caught.type is kind


@pytest.mark.parametrize("plot", [pt.plot.poinsot_construction, pt.plot.herpolhode])
@pytest.mark.parametrize("state", [START, REST])
def test_the_construction_refuses_torques(plot, state):
    motion = pt.propagate(TOP, state, np.linspace(0, 3, 31))
    G, G0 = motion.angular_momentum_space, state.angular_momentum_space
    change = np.max(np.linalg.norm(G - G0, axis=-1)) / np.max(np.linalg.norm(G, axis=-1))
    sentence = (
        f"motion must have a constant angular momentum in space, but it changes by {change:.2g} of its size. "
        "Propagate System(body) without forces: only free motion has an invariable plane."
    )
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        plot(motion)


def test_with_parts_no_curve_of_a_rigid_body_is_drawn():
    """A rotor keeps the kinetic energy of a free body, whose polhode is then not along the curves of equal energy."""
    system = pt.System(BODY, pt.parts.Gyrostat((0.3, 0.2, 0.1)))
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.4, -0.3, 0.6)), np.linspace(0, 9, 91))
    assert len(pt.plot.polhode(motion).lines) == 2
    content = page_content.content_of(motion)
    assert content["plane"] is None
    assert content["solids"]["inertia_ellipsoid"] is None


def test_a_force_without_strength_is_no_obstacle():
    weightless = pt.System(BODY, pt.UniformGravity(0.0, (1, 0, 0)))
    pt.plot.poinsot_construction(pt.propagate(weightless, START, np.linspace(0, 3, 31)))
