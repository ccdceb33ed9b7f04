"""The page of the 3D view, run in Chromium without a screen or a network."""

import io
import os
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.propagation.column_reader import MotionRows

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(BROWSER is None, reason="no chromium on this machine"),
]

BODY = pt.Body((2.0, 2.5, 3.5))
STATE = BODY.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=(0.5, -0.7, 1.1))
MOTION = pt.free_motion(BODY, STATE, np.linspace(-3, 40, 302))
SINGLE = 2e-7
"""What single precision leaves of a quaternion."""


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as session:
        chromium = session.chromium.launch(executable_path=BROWSER, args=flags)
        yield chromium
        chromium.close()


NO_WEBGL = """HTMLCanvasElement.prototype.getContext = (original => function (kind, ...rest) {
    return kind === "2d" ? original.call(this, kind, ...rest) : null;
})(HTMLCanvasElement.prototype.getContext)"""


UNFOLD = "() => { for (const group of document.querySelectorAll('details')) group.open = true; }"


class Visit:
    """A page in the browser, with all that it says and asks for."""

    def __init__(self, browser, path, webgl=True, at="", width=480, height=400, **options):
        self.messages, self.asked = [], []
        self.page = browser.new_page(viewport={"width": width, "height": height}, **options)
        if not webgl:  # which loads in a fraction of the time
            self.page.add_init_script(NO_WEBGL)
        self.page.on("console", lambda message: self.messages.append(message.text))
        self.page.on("pageerror", lambda error: self.messages.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(f"{path.as_uri()}{at}")
        self(UNFOLD)

    def __call__(self, script, argument=None):
        return self.page.evaluate(script, argument)

    def until(self, condition):
        """Wait as `wait_for_function` does, but without `eval`, which the policy of the page forbids."""
        for _ in range(500):
            if self(condition):
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(f"{condition} has not come true")

    def quaternion_at(self, time):
        return np.array(self("t => { poinsot.setTime(t); return poinsot.quaternion; }", float(time)))


@pytest.fixture(scope="module")
def free(browser, tmp_path_factory):
    """One visit for all tests that leave the page as they find it."""
    visit = Visit(browser, pt.view(MOTION, tmp_path_factory.mktemp("view") / "free.html"))
    yield visit
    assert visit.messages == []
    assert len(visit.asked) == 1
    visit.page.close()


def apart(p, q):
    """The angle in radians between attitudes."""
    turns = [Rotation.from_quat(each, scalar_first=True) for each in (p, q)]
    return np.max((turns[0].inv() * turns[1]).magnitude())


# ---------------------------------------------------------------------- the body


def test_the_body_has_the_stored_attitudes(free):
    for i in (0, 1, 57, 300, 301):
        assert np.max(np.abs(free.quaternion_at(MOTION.times[i]) - MOTION.quaternion[i])) < SINGLE


CUBIC_TURN = 2e-6
"""What a cubic leaves of an attitude, h^4/384 times its fourth derivative, up to 1 for h up to 0.25; a great circle
leaves 5e-4."""


def test_the_body_moves_as_its_rates_say_between_them(free):
    times = np.random.default_rng(1).uniform(-3, 40, 40)
    shown = np.array([free.quaternion_at(t) for t in times])
    np.testing.assert_allclose(np.linalg.norm(shown, axis=-1), 1, rtol=0, atol=1e-15)
    assert apart(shown, MOTION(times).quaternion) < CUBIC_TURN


@pytest.mark.parametrize("motion", ["flipped", "backwards"])
def test_the_body_moves_alike_with_other_signs_and_in_the_other_order(motion, browser, tmp_path):
    times = np.linspace(0, 20, 81)
    shown = pt.free_motion(BODY, STATE, times[:: {"flipped": 1, "backwards": -1}[motion]])
    if motion == "flipped":
        signs = np.where(np.random.default_rng(2).random(times.size) < 0.5, -1.0, 1.0)[:, None]
        phase = {**shown.phase, "quaternion": signs * shown.quaternion}
        shown = pt.Trajectory(shown.system, shown.initial, times, MotionRows(phase), shown.run)
    visit = Visit(browser, pt.view(shown, tmp_path / "motion.html"), webgl=False)
    exact = pt.free_motion(BODY, STATE, np.sort(np.random.default_rng(3).uniform(0, 20, 20)))
    for t, attitude in zip(exact.times, exact.quaternion, strict=True):
        assert apart(visit("t => motion.quaternion(t)", t), attitude) < CUBIC_TURN
    for i in (0, 2, 5):
        shown_there = visit("t => motion.quaternion(t)", shown.times[i])
        assert np.max(np.abs(shown_there - shown.quaternion[i])) < SINGLE
    visit.page.close()


@pytest.mark.parametrize("step", [2.2, 3.0])
def test_rates_tell_turns_of_more_than_half_a_turn(step, browser, tmp_path):
    """Steady rotation by 4.4 and 6 radians from time to time."""
    ball = pt.Body((1.0, 1.0, 1.0))
    start = ball.state((0.5, 0.5, -0.5, 0.5), omega_body=(1.2, 0.0, 1.6))
    shown = pt.free_motion(ball, start, np.arange(8) * step)
    visit = Visit(browser, pt.view(shown, tmp_path / "motion.html"), webgl=False)
    exact = pt.free_motion(ball, start, np.sort(np.random.default_rng(4).uniform(0, 7 * step, 20)))
    found = [visit("t => motion.quaternion(t)", t) for t in exact.times]
    assert apart(np.array(found), exact.quaternion) < 5 * SINGLE
    visit.page.close()


def test_vectors_turn_with_the_body(free):
    for i in (0, 100, 301):
        shown = free("t => rotate(motion.quaternion(t), motion.vector('omega_body', t))", MOTION.times[i])
        np.testing.assert_allclose(shown, MOTION.omega_space[i], rtol=0, atol=SINGLE)
        shown = free("t => motion.vector('angular_momentum_space', t)", MOTION.times[i])
        np.testing.assert_allclose(shown, MOTION.angular_momentum_space[i], rtol=0, atol=SINGLE)


PATHS = """name => [Array.from(motion.fine), Array.from(poinsot.scene.paths[name])]"""


def test_the_polhode_is_that_of_poinsot(free):
    """On the ellipsoids of energy and of momentum, up to the chords between stored rates."""
    times, path = map(np.array, free(PATHS, "polhode"))
    path, moments = path.reshape(-1, 3), np.array([2.0, 2.5, 3.5])
    expected = np.stack([np.interp(times, MOTION.times, each) for each in MOTION.omega_body.T], axis=-1)
    np.testing.assert_allclose(path, expected, rtol=0, atol=SINGLE)
    assert np.allclose(path**2 @ moments, 2 * MOTION.kinetic_energy[0], rtol=2e-4, atol=0)
    assert np.allclose(np.linalg.norm(path * moments, axis=-1), np.sqrt(0.5**2 + 0.7**2 + 1.1**2), rtol=2e-4, atol=0)


def test_the_herpolhode_is_between_its_circles_on_the_invariable_plane(free):
    """The radii are G sqrt((D - 1/I_k) (1/I_i - D)), with D = 2T/G^2; here k = 3."""
    path = np.array(free(PATHS, "herpolhode")[1]).reshape(-1, 3)
    G, I = np.array(MOTION.angular_momentum_space[0]), np.array([2.0, 2.5, 3.5])
    size = np.linalg.norm(G)
    D = 2 * MOTION.kinetic_energy[0] / size**2
    along = path @ G / size
    assert np.allclose(along, D * size, rtol=2e-4, atol=0)
    across = np.linalg.norm(path - np.outer(along, G / size), axis=-1)
    radii = sorted(size * np.sqrt((D - 1 / I[2]) * (1 / I[:2] - D)))
    assert (np.min(across), np.max(across)) == pytest.approx(radii, rel=2e-3)


TAIL = """([name, t]) => {
    poinsot.setTime(t);
    const tail = name === "trace" ? poinsot.scene.traces[2] : poinsot.scene.tails[name];
    const [{ start, count }, { array: index }] = [tail.geometry.drawRange, tail.geometry.index];
    const corners = Array.from(index.subarray(start, start + count));
    return ["instanceStart", "instanceEnd"].map((end) => {
        const { array } = tail.geometry.attributes[end];
        return corners.filter((_, k) => k % 6 === 0).map((at) => Array.from(array.subarray(3 * at, 3 * at + 3)));
    });
}"""


@pytest.mark.parametrize("name", ["polhode", "herpolhode", "trace"])
def test_tails_are_joined_and_end_at_the_tip_of_the_instant(name, free):
    for i in (57, 300, 1, 301, 120):
        starts, ends = map(np.array, free(TAIL, [name, MOTION.times[i]]))
        assert np.array_equal(starts[1:], ends[:-1])
        tip = {
            "polhode": MOTION.omega_body[i],
            "herpolhode": MOTION.omega_space[i],
            "trace": 1.35 * MOTION.attitude[i].apply((0, 0, 1)),
        }[name]
        np.testing.assert_allclose(ends[-1], tip, rtol=0, atol=3e-7)


def test_a_tail_is_ten_turns_long_of_many_stored_times(browser, tmp_path):
    spin = pt.Body((1.0, 1.0, 1.0))
    times = np.linspace(0, 40 * np.pi, 10_001)
    motion = pt.free_motion(spin, spin.state((1, 0, 0, 0), omega_body=(0.6, 0.0, 0.8)), times)
    visit = Visit(browser, pt.view(motion, tmp_path / "motion.html"))
    starts, _ = visit(TAIL, ["trace", 30 * np.pi])
    np.testing.assert_allclose(starts[0], 1.35 * motion.attitude[2500].apply((0, 0, 1)), rtol=0, atol=0.15)
    assert np.sum(np.linalg.norm(np.diff(starts, axis=0), axis=-1)) == pytest.approx(20 * np.pi * 1.35 * 0.6, rel=0.01)
    assert visit("motion.fine.length") < 1500
    assert visit.messages == []
    visit.page.close()


CORNERS = """() => poinsot.scene.drawn.shape.children.map(part => {
    part.updateWorldMatrix(true, false);
    const place = part.geometry.attributes.position;
    const point = new THREE.Vector3();
    const inSpace = (_, i) => point.fromBufferAttribute(place, i).applyMatrix4(part.matrixWorld).toArray();
    return Array.from({ length: place.count }, inSpace);
})"""


def test_a_shape_stands_in_space_as_the_attitude_says(browser, tmp_path):
    """How far each part reaches along three directions of space."""
    turn = Rotation.from_rotvec([0.5, -1.1, 0.7])
    parts: list[Any] = [
        pt.shapes.Cylinder(0.3, 2.0, mass=3.0).moved((0.5, 1.0, -2.0), turn),
        pt.shapes.Ellipsoid((0.5, 1.0, 0.7), mass=4.0).moved((-1.0, 0.0, 2.0), turn.inv()),
        pt.shapes.Mesh.from_box((0.2, 0.4, 0.6), mass=1.0).moved((0.0, -2.0, 0.0), turn),
        pt.shapes.Mascons((1.0, 2.0), ((0.0, 0.0, 0.0), (3.0, 0.0, 0.0))),
    ]
    reaches = [
        lambda d: 0.3 * np.linalg.norm(d[..., :2], axis=-1) + np.abs(d[..., 2]),
        lambda d: np.linalg.norm(d * (0.5, 1.0, 0.7), axis=-1),
        lambda d: np.abs(d) @ (0.1, 0.2, 0.3),
    ]
    shape = pt.shapes.Assembly(parts)
    body = pt.Body.from_shape(shape)
    motion = pt.free_motion(body, body.state((0.1, 0.7, -0.5, 0.5), omega_body=(1, 2, -1)), np.linspace(0, 3, 61))
    visit = Visit(browser, pt.view(motion, tmp_path / "motion.html"))
    visit.quaternion_at(motion.times[33])
    drawn = [np.array(each) * shape.circumscribing_radius for each in visit(CORNERS)]
    places = [(0.5, 1.0, -2.0), (-1.0, 0.0, 2.0), (0.0, -2.0, 0.0)]
    for corners, reach, own, place in zip(drawn, reaches, (turn, turn.inv(), turn), places, strict=False):
        center = motion.attitude[33].apply(place - shape.center_of_mass)
        towards = (motion.attitude[33] * own).inv().apply(np.eye(3))
        found = [np.max((corners - center) @ side) for side in np.eye(3)]
        np.testing.assert_allclose(found, reach(towards), rtol=4e-3)
    middle = motion.attitude[33].inv().apply(drawn[3].reshape(2, -1, 3).mean(axis=1)) + shape.center_of_mass
    np.testing.assert_allclose(middle, parts[3].positions, rtol=0, atol=1e-6)
    assert visit.messages == []
    visit.page.close()


# ---------------------------------------------------------------------- two bodies

CUBIC = 1e-4
"""What a cubic over 0.1 leaves of a position, h^4/384 times its fourth derivative, up to 400; a chord leaves 1e-2."""
PLACED = """t => {
    poinsot.setTime(t);
    const { bodies, world } = poinsot.scene;
    return [...Object.values(bodies).map(({ body }) => {
        const { x, y, z, w } = body.quaternion;
        return [body.position.toArray(), [w, x, y, z]];
    }), world.position.toArray()];
}"""
REACHED = """name => {
    const { drawn } = poinsot.scene.bodies[name];
    const part = drawn.shape?.children[0] ?? drawn.ellipsoid;
    part.updateWorldMatrix(true, false);
    const place = part.geometry.attributes.position;
    const point = new THREE.Vector3();
    return Array.from({ length: place.count }, (_, i) =>
        point.fromBufferAttribute(place, i).applyMatrix4(part.matrixWorld).toArray());
}"""


@pytest.fixture(scope="module")
def two(browser, tmp_path_factory):
    first = pt.Body.from_shape(pt.shapes.Ellipsoid((1.0, 0.9, 0.7), mass=50.0).moved((3, 2, 1)))
    pair = pt.TwoBodies(first, pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3)), G=1.0)
    start = pair.state((4, 0, 0), (0.2, 3.0, 0.5), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0.3, 2), (0, 0.1, 0.9)])
    motion: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, 12, 121), dense=True)
    visit = Visit(browser, pt.view(motion, tmp_path_factory.mktemp("view") / "pair.html"))
    yield motion, visit
    assert visit.messages == []
    visit.page.close()


def test_two_bodies_stand_about_their_barycentre_to_scale(two):
    motion, visit = two
    length = (motion.distance.max() * 50 / 52 + 0.5) / 1.85
    for time in (motion.times[0], motion.times[77], 5.04, 11.93):
        at = motion(time)
        *bodies, target = visit(PLACED, time)
        for (place, attitude), share, own in zip(bodies, (-2 / 52, 50 / 52), at.of_bodies.values(), strict=True):
            np.testing.assert_allclose(length * np.array(place), share * at.position, rtol=0, atol=CUBIC)
            stored = time in motion.times
            assert apart(attitude, own.quaternion) < (4 * SINGLE if stored else 3e-3)
        assert np.all(np.array(target) == 0)
    corners = length * (np.array(visit(REACHED, "secondary")) - bodies[1][0])
    along = at.secondary.attitude.inv().apply(np.eye(3))
    np.testing.assert_allclose(np.max(corners, axis=0), np.linalg.norm(along * (0.5, 0.4, 0.3), axis=-1), rtol=4e-3)
    corners = length * (np.array(visit(REACHED, "primary")) - bodies[0][0])
    along = at.primary.attitude.inv().apply(np.eye(3))
    np.testing.assert_allclose(np.max(corners, axis=0), np.linalg.norm(along * (1.0, 0.9, 0.7), axis=-1), rtol=4e-3)


def test_the_paths_of_two_bodies_are_those_of_their_orbit(two):
    motion, visit = two
    length = (motion.distance.max() * 50 / 52 + 0.5) / 1.85
    times = np.array(visit("Array.from(motion.fine)"))
    path = np.array(visit("Array.from(poinsot.scene.bodies.secondary.points)")).reshape(-1, 3)
    np.testing.assert_allclose(length * path, 50 / 52 * motion(times).position, rtol=0, atol=CUBIC)


def test_the_view_follows_a_body_and_the_numbers_the_time(two):
    motion, visit = two
    visit.page.select_option("#view", "secondary")
    _, (place, _), moved = visit(PLACED, motion.times[30])
    np.testing.assert_array_equal(moved, -np.array(place))
    visit.page.select_option("#view", "space")
    assert visit(PLACED, motion.times[30])[-1] == [0, 0, 0]
    shown = visit.page.locator("[data-quantity=distance] output").text_content()
    assert float(shown) == pytest.approx(motion.distance[30], rel=5.1e-3)
    visit.page.locator("#plots select").nth(1).select_option("secondary_omega_body")
    visit("t => poinsot.setTime(t)", motion.times[30])
    rate = visit.page.locator("[data-quantity=secondary_omega_body] output").all_text_contents()
    assert [float(x.replace("−", "-")) for x in rate] == pytest.approx(motion.secondary.omega_body[30], rel=5.1e-3)
    sizes = [float(x) for x in visit.page.locator("#parts output").all_text_contents()]
    vectors = motion.primary.omega_body, motion.secondary.omega_body, motion.angular_momentum_space
    assert sizes == pytest.approx([np.linalg.norm(x[30]) for x in vectors], rel=1e-3)


PAIR_SEEN = """t => {
    poinsot.setTime(t);
    poinsot.scene.render();
    const { around, bodies, ghosts, parts } = poinsot.scene;
    const at = (each) => each.getWorldPosition(new THREE.Vector3()).toArray();
    const q = parts.orbit_frame.getWorldQuaternion(new THREE.Quaternion());
    return {
        attractor: at(around.far.ball), scale: around.far.scale, frame: [q.w, q.x, q.y, q.z],
        bodies: Object.values(bodies).map(({ body }) => at(body)),
        ghosts: ghosts.bodies.map((body) => [body.visible, at(body), body.quaternion.w]),
    };
}"""


def test_two_bodies_have_their_attractor_and_other_motions_around_them(browser, tmp_path):
    ball = pt.Body.from_ellipsoid(50.0, (1, 1, 0.9))
    pair = pt.TwoBodies(ball, pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3)), G=1.0)
    sun = pt.KeplerOrbit(1e6, semimajor_axis=1e3, eccentricity=0.2, inclination=0.4)
    system = pt.System(pair, pt.forces.MutualGravity(), pt.forces.ThirdBody(sun))
    own: Any
    other: Any
    own, other = (
        pt.propagate(system, start, np.linspace(0, end, 121))
        for start, end in (
            (pair.state((4, 0, 0), (0.2, y, 0.5), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0.3, 2), (0, 0.1, 0.9)]), end)
            for y, end in ((3.0, 12.0), (3.3, 6.0))
        )
    )
    visit = Visit(browser, pt.view(own, tmp_path / "pair.html", others=other))
    length = (own.distance.max() * 50 / 52 + 0.5) / 1.85
    for i in (0, 40, 120):
        seen = visit(PAIR_SEEN, other.times[i])
        place, velocity = (
            np.array([float(x) for x in at(other.times[i])]) for at in (sun.position_at, sun.velocity_at)
        )
        np.testing.assert_allclose(seen["attractor"], -seen["scale"] * place, rtol=1e-5)
        normal = np.cross(place, velocity)
        axes = Rotation.from_quat(seen["frame"], scalar_first=True).as_matrix().T
        np.testing.assert_allclose(axes[0], place / np.linalg.norm(place), rtol=0, atol=1e-5)
        np.testing.assert_allclose(axes[2], normal / np.linalg.norm(normal), rtol=0, atol=1e-5)
        for (shown, where, w), share, each in zip(
            seen["ghosts"], (-2 / 52, 50 / 52), other.of_bodies.values(), strict=True
        ):
            assert shown
            np.testing.assert_allclose(length * np.array(where), share * other.position[i], rtol=0, atol=CUBIC)
            assert abs(w) == pytest.approx(abs(each.quaternion[i, 0]), abs=4 * SINGLE)
    assert not any(shown for shown, *_ in visit(PAIR_SEEN, 7.0)["ghosts"])
    visit.page.select_option("#view", "attractor")
    np.testing.assert_allclose(visit(PAIR_SEEN, 3.0)["attractor"], 0, rtol=0, atol=1e-6)
    visit.page.select_option("#view", "primary")
    np.testing.assert_allclose(visit(PAIR_SEEN, 3.0)["bodies"][0], 0, rtol=0, atol=1e-6)
    assert visit.messages == []
    visit.page.close()


def test_slow_frames_have_fewer_dots_and_points_and_a_picture_at_rest_all(browser, tmp_path):
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html"))
    points = "poinsot.scene.parts.polhode.children.find(each => each.isLine).geometry.drawRange.count"
    visit("""() => (function busy() {
        const start = performance.now();
        while (!window.idle && performance.now() - start < 40);
        requestAnimationFrame(busy);
    })()""")
    dots = "document.getElementById('scene').width / document.getElementById('scene').clientWidth"
    visit.page.keyboard.press("Space")
    visit.until("poinsot.sharpness === 0.36")
    assert visit(dots) == pytest.approx(0.36, abs=0.01)
    visit.until(f"{points} === 778")
    visit.page.keyboard.press("Space")
    visit.until(f"{dots} >= 1")
    assert visit(points) == 6000
    shown = visit("document.getElementById('now').textContent")
    assert float(shown[4:].replace("−", "-")) == pytest.approx(visit("poinsot.time"), rel=1e-5)
    visit.page.close()


# ---------------------------------------------------------------------- the controls


def test_time_stays_within_the_motion(free):
    assert [free("t => { poinsot.setTime(t); return poinsot.time; }", t) for t in (-5, 1.25, 99)] == [-3, 1.25, 40]


def test_the_slider_moves_the_body(free):
    free("document.getElementById('time').value = 12.5")
    free.page.dispatch_event("#time", "input")
    free.until("document.getElementById('now').textContent === 't = 12.5'")
    assert apart(free("poinsot.quaternion"), MOTION(12.5).quaternion) < CUBIC_TURN


def test_the_plots_move_the_body(free):
    plot = free.page.locator("[data-quantity=momenta] canvas")
    plot.click(position={"x": 58 + (plot.bounding_box()["width"] - 68) / 4, "y": 40})
    assert free("poinsot.time") == pytest.approx(-3 + 43 / 4, abs=0.2)


def test_the_cursor_and_the_numbers_follow(free):
    free.quaternion_at(MOTION.times[123])
    for name, values in {"quaternion": MOTION.quaternion, "momenta": MOTION.conjugate_momenta}.items():
        shown = free.page.locator(f"[data-quantity={name}] output").all_text_contents()
        assert [float(text.replace("−", "-")) for text in shown] == pytest.approx(values[123], rel=5.1e-3)
        frame, cursor = (
            free.page.locator(f"[data-quantity={name}] {part}").bounding_box() for part in ("canvas", ".cursor")
        )
        u = (cursor["x"] + 0.5 - frame["x"] - 58) / (frame["width"] - 68)
        assert u == pytest.approx((MOTION.times[123] + 3) / 43, abs=2e-3)
    for name, values in {"G": MOTION.angular_momentum_space, "omega": MOTION.omega_space}.items():
        assert float(free.page.locator(f"#{name}").text_content()) == pytest.approx(
            np.linalg.norm(values[123]), rel=1e-3
        )


def test_arrows_step_through_the_stored_times(free):
    free.quaternion_at(0.5 * (MOTION.times[10] + MOTION.times[11]))
    reached = []
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft", "ArrowLeft", "End", "ArrowRight", "ArrowLeft", "Home"):
        free.page.keyboard.press(key)
        reached.append(np.searchsorted(MOTION.times, free("poinsot.time")))
        assert free("poinsot.time") in MOTION.times
    assert reached == [11, 12, 11, 10, 301, 301, 300, 0]


def test_play_goes_on_until_paused_or_over(free):
    free.quaternion_at(-3)
    free.page.keyboard.press("Space")
    free.until("poinsot.time > -2")
    free.page.keyboard.press("Space")
    paused = free("poinsot.time")
    free.page.wait_for_timeout(150)
    assert (free("poinsot.time"), free("poinsot.playing")) == (paused, False)
    free.page.select_option("#rate", index=7)
    free.page.click("#play")
    assert free("poinsot.playing")
    free.until("poinsot.time === 40 && !poinsot.playing")
    free.page.click("#play")
    free.until("poinsot.time < 39")
    free.page.click("#play")
    free.until("!poinsot.playing")


def test_speed_is_what_the_page_says(free):
    free.quaternion_at(-3)
    free.page.select_option("#rate", index=2)
    per_second = float(re.match(r"[\d.]+", free.page.locator("#rate option").nth(2).text_content())[0])
    clock = "new Promise(done => requestAnimationFrame(now => done([now, poinsot.time])))"
    free.page.click("#play")
    free.until("poinsot.time > -3")
    start, end = free(clock), (free.page.wait_for_timeout(1000), free(clock))[1]
    free.page.click("#play")
    assert (end[1] - start[1]) / (end[0] - start[0]) * 1000 == pytest.approx(per_second, rel=0.3)


def test_every_solid_trace_and_part_can_be_drawn(free):
    picture = free.page.locator("#scene")
    free.page.evaluate("poinsot.setTime(30)")
    boxes = free.page.locator("#parts input").all()
    for box in boxes:
        box.check()
    pictures = [picture.screenshot()]
    for name in ("box", "ellipsoid"):
        free.page.select_option("#solid", name)
        pictures.append(picture.screenshot())
    free.page.select_option("#traced", "0")
    pictures.append(picture.screenshot())
    for box in boxes:
        box.uncheck()
        pictures.append(picture.screenshot())
    assert len(set(pictures)) == len(pictures) == 11


def test_dragging_turns_the_view_and_not_the_time(free):
    free.page.evaluate("poinsot.setTime(3)")
    before = free.page.locator("#scene").screenshot()
    free.page.mouse.move(100, 100)
    free.page.mouse.down()
    free.page.mouse.move(160, 120, steps=3)
    free.page.mouse.up()
    free.page.wait_for_timeout(200)
    assert free.page.locator("#scene").screenshot() != before
    assert free("poinsot.time") == 3


def test_the_keyboard_turns_the_view_and_not_the_time(free):
    free.page.evaluate("poinsot.setTime(3)")
    eye = "poinsot.scene.controls.object.position.toArray()"
    before = np.array(free(eye))
    for keys in ("ArrowRight", "ArrowDown"):
        free.page.keyboard.press(f"Shift+{keys}")
        after = np.array(free(eye))
        assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before), rel=1e-6)
        across = np.hypot(*before[:2]) if keys == "ArrowRight" else np.linalg.norm(before)
        assert np.linalg.norm(after - before) == pytest.approx(2 * np.sin(0.05) * across, rel=1e-6)
        before = after
    free.page.keyboard.press("Shift+PageUp")
    np.testing.assert_allclose(free(eye), 0.9 * before, rtol=1e-6)
    free.page.keyboard.press("Shift+PageDown")
    assert free("poinsot.time") == 3


# ---------------------------------------------------------------------- the page


def test_the_network_is_out_of_reach(browser, tmp_path):
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html"), webgl=False)
    refused = visit("""() => new Promise(done => {
        document.addEventListener("securitypolicyviolation", event => done(event.effectiveDirective));
        fetch("http://127.0.0.1:9/").catch(() => null);
    })""")
    assert refused == "connect-src"
    assert len(visit.asked) == 1
    visit.page.close()


def test_names_with_markup_run_nothing(browser, tmp_path):
    hostile = "</script><script>window.caught = 1</script><img src=x onerror='window.caught = 2'>"
    system = pt.System(BODY, units={"time": hostile})
    motion = pt.propagate(system, STATE, (0.0, 1.0, 2.0))
    visit = Visit(browser, pt.view(motion, tmp_path / "motion.html"), webgl=False)
    assert visit("window.caught") is None
    visit("poinsot.setTime(1)")
    assert visit.page.locator("#now").text_content() == f"t = 1 {hostile}"
    assert visit("document.querySelectorAll('#plots select')[1].selectedOptions[0].text").startswith(
        "conjugate momenta Q [<"
    )
    visit.page.close()


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["desktop", "phone"])
def test_everything_fits_into_the_window(size, browser, tmp_path):
    width, height = size
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html"), width=width, height=height)
    assert visit("document.documentElement.scrollWidth") <= width
    parts = {name: visit.page.locator(name).bounding_box() for name in ("#space", "#player", "#controls", "#plots")}
    for box in parts.values():
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
        assert box["width"] > 250
        assert box["height"] > 24
    first = ("#space", "#player") if width < 760 else parts
    assert all(parts[name]["y"] + parts[name]["height"] <= height for name in first)
    assert visit.messages == []
    if folder := os.environ.get("POINSOT_SCREENSHOTS"):
        visit.quaternion_at(30)
        visit.page.screenshot(path=f"{folder}/view-{width}.png", full_page=True)
    visit.page.close()


def test_a_notebook_shows_the_same_page(browser, tmp_path):
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!DOCTYPE html><meta charset=utf-8>{pt.view(MOTION)._repr_html_()}")
    visit = Visit(browser, notebook)
    frame = visit.page.frames[1]
    shown = frame.evaluate("t => { poinsot.setTime(t); return poinsot.quaternion; }", MOTION.times[7])
    np.testing.assert_allclose(shown, MOTION.quaternion[7], rtol=0, atol=SINGLE)
    assert visit.messages == []
    visit.page.close()


def test_two_views_in_one_page(browser, tmp_path):
    other = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(1, 2, 3)), np.linspace(0, 5, 51))
    notebook = tmp_path / "notebook.html"
    frames = "".join(pt.view(motion)._repr_html_() for motion in (MOTION, other))
    notebook.write_text(f"<!DOCTYPE html><meta charset=utf-8>{frames}")
    visit = Visit(browser, notebook)
    for frame, motion in zip(visit.page.frames[1:], (MOTION, other), strict=True):
        frame.evaluate("t => poinsot.setTime(t)", motion.times[7])
    for frame, motion in zip(visit.page.frames[1:], (MOTION, other), strict=True):
        np.testing.assert_allclose(frame.evaluate("poinsot.quaternion"), motion.quaternion[7], rtol=0, atol=SINGLE)
    assert visit.messages == []
    assert all(url.startswith("file:") or url == "about:srcdoc" for url in visit.asked)
    visit.page.close()


def shown_at(frame, visit, label):
    """Wait until a page in a notebook shows a time."""
    for _ in range(250):
        if frame.locator("#now").text_content() == label:
            return
        visit.page.wait_for_timeout(20)
    raise AssertionError(frame.locator("#now").text_content())


def test_an_exported_notebook_has_formulas_plots_and_a_slider_without_a_network(browser, tmp_path):
    """Formulas are typeset by the browser itself: a fraction stands in two lines, and an index below its letter."""
    attractor = pt.orbits.FixedPosition(1.0, position=(3, 0, 0))
    system = pt.System(BODY, pt.UniformGravity(0.1, (1, 0, 0)), pt.GravityGradient(attractor))
    moved = pt.propagate(system, STATE, np.linspace(0, 40, 302))
    cells = "".join(f"<div>{thing._repr_html_()}</div>" for thing in (system, moved, pt.view(moved), BODY, STATE))
    (tmp_path / "export.html").write_text(f"<!DOCTYPE html><meta charset=utf-8>{cells}")
    visit = Visit(browser, tmp_path / "export.html", width=1000)
    places = "each => { const box = each.getBoundingClientRect(); return [box.top, box.bottom, box.width]; }"
    fraction = "Array.from(document.querySelectorAll('mfrac')).at(-1)"
    upper, lower = (visit(f"({places})({fraction}.children[{i}])") for i in (0, 1))
    assert 0 < upper[1] <= lower[0] + 1
    letter, index = (visit(f"({places})(document.querySelector('msub').children[{i}])") for i in (0, 1))
    assert index[1] > letter[1]
    assert visit("document.querySelectorAll('svg polyline').length") == 5 + len(moved.drift)
    frame = visit.page.frames[1]
    frame.frame_element().scroll_into_view_if_needed()  # what is out of sight is not drawn
    shown_at(frame, visit, "t = 0")
    frame.locator("#time").evaluate("each => { each.value = 20; each.dispatchEvent(new Event('input')) }")
    shown_at(frame, visit, "t = 20")
    assert visit.messages == []
    assert all(url.startswith("file:") or url == "about:srcdoc" for url in visit.asked)
    visit.page.close()


def test_without_webgl_the_plots_and_the_time_remain(browser, tmp_path):
    """And no control of the scene."""
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html"), webgl=False)
    assert visit.page.locator("#space").text_content() == "The body cannot be drawn: this browser has no WebGL."
    visit("poinsot.setTime(5)")
    assert visit.page.locator("#now").text_content() == "t = 5"
    assert visit("Array.from(document.querySelectorAll('input, select, button'), each => each.id)") == [
        *("play", "time", "rate", "loop", "event", "", "")  # and the choices of the plotted quantities
    ]
    shown = visit.page.locator("#G").text_content()
    assert float(shown) == pytest.approx(np.linalg.norm(MOTION.angular_momentum_space[0]), rel=1e-3)
    visit.page.close()


# ---------------------------------------------------------------------- what is around a body

ORBIT = pt.KeplerOrbit(3.986004418e14, semimajor_axis=7.2e6, eccentricity=0.1, inclination=0.7, node=0.3)
SUN = (-1.2e11, 8e10, 2e10)


@pytest.fixture(scope="module")
def orbiting(browser, tmp_path_factory):
    facets = pt.forces.Facets.from_box((0.2, 0.3, 0.4))
    light = pt.forces.RadiationPressure(
        pt.orbits.FixedPosition(1.327e20, position=SUN), facets, [pt.forces.Occulter(ORBIT, 6.3781e6)]
    )
    wheels = pt.parts.Gyrostat((0, 0.1, 0.2))
    system = pt.System(pt.Body((4.0, 5.0, 6.0)), pt.GravityGradient(ORBIT), light, wheels, units={"time": "s"})
    start = system.state((0.5, 0.5, -0.5, 0.5), omega_body=(1e-2, 2e-2, 5e-2))
    event = pt.events.SpinFlip((1, 0, 0))
    motion = pt.propagate(system, start, np.linspace(0, 5000, 2001), events=[event], dense=True)
    motion._complete(provenance={"calendar": pt.Calendar("2029-04-13T21:46:00", "TDB")})
    visit = Visit(browser, pt.view(motion, tmp_path_factory.mktemp("view") / "orbit.html"))
    yield motion, visit
    assert visit.messages == []
    visit.page.close()


WORLD = """() => {
    poinsot.scene.render();
    const { world, body, around, parts } = poinsot.scene;
    const turned = (each) => each.getWorldQuaternion(new THREE.Quaternion());
    const turn = (each) => { const q = turned(each); return [q.w, q.x, q.y, q.z]; };
    const place = (each) => each.getWorldPosition(new THREE.Vector3()).toArray();
    const tip = (each) => new THREE.Vector3(0, 1, 0).applyQuaternion(turned(each)).toArray();
    return {
        body: turn(body), world: turn(world), attractor: place(around.far.ball), here: place(body),
        scale: around.far.scale, size: around.far.size, frame: turn(parts.orbit_frame), sun: tip(parts.sun),
        lit: tip(around.far.night), torque: tip(parts.torque_0),
    };
}"""


def seen_at(visit, time, view):
    visit.page.select_option("#view", view)
    visit("t => poinsot.setTime(t)", time)
    return {name: np.array(value) for name, value in visit(WORLD).items()}


@pytest.mark.parametrize("time", [0.0, 1234.5, 4999.0])
def test_orbit_and_sun_are_where_the_forces_have_them(time, orbiting):
    _, visit = orbiting
    seen = seen_at(visit, time, "space")
    position, velocity = (np.array([float(x) for x in at(time)]) for at in (ORBIT.position_at, ORBIT.velocity_at))
    np.testing.assert_allclose(seen["attractor"], -seen["scale"] * position, rtol=1e-5, atol=1e-4)
    assert seen["size"] == pytest.approx(6.3781e6 * seen["scale"])
    assert np.linalg.norm(seen["attractor"]) - seen["size"] > 2
    axes = Rotation.from_quat(seen["frame"], scalar_first=True).as_matrix().T
    normal = np.cross(position, velocity)
    np.testing.assert_allclose(axes[0], position / np.linalg.norm(position), rtol=0, atol=1e-5)
    np.testing.assert_allclose(axes[2], normal / np.linalg.norm(normal), rtol=0, atol=1e-5)
    np.testing.assert_allclose(axes[1], np.cross(axes[2], axes[0]), rtol=0, atol=1e-12)
    for towards in (seen["sun"], seen["lit"]):
        np.testing.assert_allclose(towards, -np.array(SUN) / np.linalg.norm(SUN), rtol=0, atol=1e-6)


def test_a_torque_turns_with_the_body(orbiting):
    motion, visit = orbiting
    i = 777
    (largest, torque) = max(motion.torques_body.items(), key=lambda each: np.max(np.linalg.norm(each[1], axis=-1)))
    assert largest == "GravityGradient"
    tip = seen_at(visit, motion.times[i], "space")["torque"]
    expected = motion.attitude[i].apply(torque[i])
    np.testing.assert_allclose(tip, expected / np.linalg.norm(expected), rtol=0, atol=1e-5)


def test_wheels_turn_in_the_body_about_their_axes(browser, tmp_path):
    axis = np.array((0.48, 0.6, 0.64))
    wheel = pt.parts.ReactionWheel(axis, moment=0.1, torque=0.002)
    system = pt.System(BODY, wheel)
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0.5)), np.linspace(0, 40, 401))
    visit = Visit(browser, pt.view(motion, tmp_path / "wheel.html"))
    turn = """t => { poinsot.setTime(t); const q = poinsot.scene.parts.wheels.children[0].quaternion;
        return [q.w, q.x, q.y, q.z]; }"""
    turns = [Rotation.from_quat(visit(turn, t), scalar_first=True) for t in (0.0, 13.0, 40.0)]
    speeds = wheel.speed(motion.own["reaction_wheel"], motion.omega_body)
    angles = np.append(0, np.cumsum(0.05 * (speeds[1:] + speeds[:-1])))
    slower = visit("motion.page.around.wheels.slower")
    for own, i in zip(turns, (0, 130, 400), strict=True):
        np.testing.assert_allclose(own.apply((0, 1, 0)), axis, rtol=0, atol=1e-14)
        expected = Rotation.from_rotvec(angles[i] / slower * axis) * turns[0]
        assert (expected.inv() * own).magnitude() < 1e-5
    assert abs(angles[-1] / slower) > 1
    assert visit.messages == []
    visit.page.close()


def test_the_camera_is_fixed_to_body_orbit_or_attractor(orbiting):
    """What it is fixed to has one attitude on the screen at all times."""
    _, visit = orbiting
    times = (100.0, 1500.0, 3333.0)
    in_body = [seen_at(visit, t, "body")["body"] for t in times]
    for q in in_body:
        np.testing.assert_allclose(np.abs(q), (1, 0, 0, 0), rtol=0, atol=1e-14)
    frames = [Rotation.from_quat(seen_at(visit, t, "orbit")["frame"], scalar_first=True).as_matrix() for t in times]
    for frame in frames:  # radial upwards, transverse to the right
        np.testing.assert_allclose(frame.T, [(0, 0, 1), (1, 0, 0), (0, 1, 0)], rtol=0, atol=1e-14)
    for t in times:
        seen = seen_at(visit, t, "attractor")
        np.testing.assert_allclose(seen["attractor"], 0, rtol=0, atol=1e-6)
        np.testing.assert_allclose(seen["here"], seen["scale"] * np.array(ORBIT.position_at(t)), rtol=1e-5, atol=1e-4)
        np.testing.assert_allclose(seen["world"], (1, 0, 0, 0), rtol=0, atol=1e-12)
    visit.page.select_option("#view", "space")


def test_the_camera_looks_along_the_line_of_sight(browser, tmp_path):
    """From the observer: the arrow to the observer points to the eye, and s3 is upwards."""
    motion = pt.free_motion(BODY, STATE, np.linspace(0, 10, 101))
    observer, sun = (-3.0, 4.0, -1.0), (1.0, 2.0, -2.0)
    orbits = {name: pt.orbits.FixedPosition(1.0, position=at) for name, at in (("observer", observer), ("sun", sun))}
    visit = Visit(browser, pt.view(motion, tmp_path / "seen.html", **orbits))
    script = """t => {
        poinsot.setTime(t);
        const { world, parts, camera, render } = poinsot.scene;
        render();
        const turned = (each) => each.getWorldQuaternion(new THREE.Quaternion());
        const tip = (each) => new THREE.Vector3(0, 1, 0).applyQuaternion(turned(each));
        const north = new THREE.Vector3(0, 0, 1).applyQuaternion(turned(world));
        const screen = (each) => each.applyQuaternion(turned(camera).invert()).toArray();
        return [tip(parts.observer), tip(parts.sun), north].map(screen);
    }"""
    in_space = visit(script, 3.0)
    assert not np.allclose(in_space[0], (0, 0, 1), rtol=0, atol=0.1)
    visit.page.select_option("#view", "observer")
    to_observer, to_sun, north = map(np.array, visit(script, 3.0))
    np.testing.assert_allclose(to_observer, (0, 0, 1), rtol=0, atol=1e-6)
    assert abs(north[0]) < 1e-6
    assert north[1] > 0
    eye = -np.array(observer) / np.linalg.norm(observer)
    east = np.cross((0, 0, 1), -eye)  # of the sky behind the body: on the left
    expected = -np.array(sun) @ -east / np.linalg.norm(sun) / np.linalg.norm(east)
    assert to_sun[0] == pytest.approx(expected, rel=0, abs=1e-6)
    assert visit.messages == []
    visit.page.close()


def test_events_and_dates_are_on_the_line_of_time(orbiting):
    motion, visit = orbiting
    times = motion.events[0].times
    listed = visit.page.locator("#event option").all_text_contents()
    assert len(listed) == times.size + 1
    visit.page.select_option("#event", index=1)
    assert visit("poinsot.time") == times[0]
    visit("poinsot.setTime(61)")
    assert visit.page.locator("#date").text_content() == "2029-04-13 21:47:01 TDB"
    assert visit.page.locator("#time").get_attribute("aria-valuetext") == "t = 1.01667 min, 2029-04-13 21:47:01 TDB"


def test_the_page_shows_its_numbers_in_the_units_of_its_labels(orbiting):
    """The page shows minutes and degrees per second of a motion in seconds."""
    motion, visit = orbiting
    i = 40
    visit("t => poinsot.setTime(t)", float(motion.times[i]))
    assert visit.page.locator("#now").text_content() == f"t = {motion.times[i] / 60:.6g} min"
    shown = visit.page.locator("#omega").text_content()
    assert float(shown) == pytest.approx(np.degrees(np.linalg.norm(motion.omega_body[i])), rel=1e-3)
    assert "[deg s⁻¹]" in visit.page.locator("label:has(#omega)").text_content()
    first = visit.page.locator("#event option").nth(1).text_content()
    assert float(first.split()[0]) == pytest.approx(motion.events[0].times[0] / 60, rel=1e-6)
    assert visit.page.locator("#rate option").first.text_content().endswith(" min per second")


def test_real_time_is_one_second_per_second_and_loops_begin_anew(orbiting):
    _, visit = orbiting
    visit.page.select_option("#rate", label="real time")
    assert visit.page.locator("#rate").input_value() == "1"
    visit("poinsot.setTime(4999.8)")
    visit.page.check("#loop")
    visit.page.click("#play")
    visit.until("poinsot.time < 3")
    assert visit("poinsot.playing")
    visit.page.click("#play")
    visit.page.uncheck("#loop")


def test_the_scene_is_saved_as_a_picture(orbiting):
    _, visit = orbiting
    visit.page.select_option("#view", "orbit")
    with visit.page.expect_download() as saved:
        visit.page.click("#save")
    assert saved.value.suggested_filename == f"{visit.page.title()}.png"
    with Image.open(saved.value.path()) as picture:
        shown = np.asarray(picture.convert("RGB"))
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) > 50


@pytest.fixture(scope="module")
def spinning(browser, tmp_path_factory):
    """A body that turns once in 6, seen from the tip of omega, with nothing but itself and its first axis."""
    long = pt.Body.from_shape(pt.shapes.Mesh.from_box((9.0, 2.0, 1.0), mass=2.0))
    motion = pt.free_motion(long, long.state((1, 0, 0, 0), omega_body=(0, 0, np.pi / 3)), np.linspace(0, 12, 121))
    visit = Visit(browser, pt.view(motion, tmp_path_factory.mktemp("view") / "spin.html"))
    for box in visit.page.locator("#parts input").all():
        box.uncheck()
    visit("() => { poinsot.scene.turn(0, -2, 1); poinsot.setTime(11); }")
    yield visit
    assert visit.messages == []
    visit.page.close()


def direction(picture):
    """The direction of the long side of the body, modulo half a turn, counterclockwise from the right."""
    red, _, blue = np.moveaxis(picture[:-40].astype(int), -1, 0)
    y, x = np.nonzero((blue > red + 5) & (red > 80))
    assert x.size > 1000
    covariance = np.cov(x, -y)
    return 0.5 * np.arctan2(2 * covariance[0, 1], covariance[0, 0] - covariance[1, 1])


def test_a_film_as_gif_shows_the_motion_at_its_speed(spinning):
    """From the time on, here 11 of 12, in frames of a twentieth of a second."""
    visit = spinning
    per_second = float(visit.page.locator("#rate").input_value())
    expected_count = round(20 / per_second)
    with visit.page.expect_download() as saved:
        visit.page.click("#gif")
    assert saved.value.suggested_filename == f"{visit.page.title()}.gif"
    with Image.open(saved.value.path()) as film:
        size = visit("[scene.clientWidth, scene.clientHeight]")
        assert np.max(np.abs(np.array(film.size) - size)) <= 1
        frames = [(np.asarray(frame.convert("RGB")), frame.info["duration"]) for frame in ImageSequence.Iterator(film)]
        assert film.info["loop"] == 0
    assert len(frames) == expected_count
    assert {duration for _, duration in frames} == {50}
    angles = np.unwrap([direction(picture) for picture, _ in frames], period=np.pi)
    times = per_second * np.arange(expected_count) / 20
    np.testing.assert_allclose(angles - angles[0], np.pi / 3 * times, rtol=0, atol=0.03)
    visit.until("document.getElementById('gif').textContent === 'Save GIF'")
    assert visit("poinsot.time") == 11


def test_a_gif_has_the_pictures_that_it_is_given(spinning):
    """Many shades and 108 colours nearly, noise of two colours exactly; the second and the third picture are one."""
    visit = spinning
    width, height = 120, 90
    random = np.random.default_rng(5)
    shades = np.add.outer(np.arange(height), np.arange(width))[..., None] * (1.0, 0.5, -0.8) + (20, 30, 220)
    blocks = np.kron(random.integers(0, 256, (9, 12, 3)), np.ones((10, 10, 1)))
    noise = np.where(random.random((height, width, 1)) < 0.5, 0, 255) * np.ones(3)
    pictures = [np.clip(each, 0, 255).astype(int) for each in (shades, blocks, blocks, noise)]
    given = [np.dstack([each, np.full((height, width), 255)]).ravel().tolist() for each in pictures]
    made = """([pictures, width, height]) => {
        const film = new Gif(width, height, paletteOf(pictures));
        for (const picture of pictures) film.add(picture, 7);
        return Array.from(film.bytes);
    }"""
    data = bytes([*visit(made, [given, width, height]), 0x3B])
    with Image.open(io.BytesIO(data)) as film:
        frames = [np.asarray(frame.convert("RGB")).astype(int) for frame in ImageSequence.Iterator(film)]
    errors = [np.sqrt(np.mean((frame - given) ** 2)) for frame, given in zip(frames, pictures, strict=True)]
    assert errors[0] < 8
    assert max(errors[1:3]) < 16
    assert errors[3] == 0


def test_a_film_is_recorded_as_the_browser_can(spinning):
    visit = spinning
    kind = visit("VIDEO")
    assert visit.page.locator("#video").text_content() == f"Save {kind.upper()}"
    with visit.page.expect_download() as saved:
        visit.page.click("#video")
    data = Path(saved.value.path()).read_bytes()
    assert {"mp4": data[4:8] == b"ftyp", "webm": data[:4] == b"\x1a\x45\xdf\xa3"}[kind]
    assert len(data) > 2000


def test_a_link_says_the_time(browser, tmp_path):
    path = pt.view(MOTION, tmp_path / "free.html")
    visit = Visit(browser, path, webgl=False, at="#t=12.5")
    assert visit("poinsot.time") == 12.5
    visit("poinsot.setTime(7.25)")
    assert visit.page.url == f"{path.as_uri()}#t=7.25"
    slide = "s => { s.value = 9.5; s.dispatchEvent(new Event('input')); }"
    visit(f"({slide})(document.getElementById('time'))")  # at once: a frame would put the slider back
    visit.until("location.hash === '#t=9.5'")
    visit("location.hash = '#t=3'")
    visit.until("poinsot.time === 3")
    visit.page.close()


def test_other_motions_are_drawn_during_their_times(browser, tmp_path):
    starts = BODY.state(STATE.quaternion, angular_momentum_body=[(0.5, -0.7, 1.1 + 0.1 * k) for k in range(1, 4)])
    others = pt.propagate(pt.System(BODY), starts, np.linspace(-3, 20, 200))
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html", others=others))
    turns = """t => { poinsot.setTime(t); return poinsot.scene.ghosts.bodies.map(({ quaternion: q, visible }) =>
        [visible, q.w, q.x, q.y, q.z]); }"""
    for i in (0, 57, 199):
        shown = np.array(visit(turns, others.times[i]))
        assert np.all(shown[:, 0])
        assert apart(shown[:, 1:], others.quaternion[:, i]) < 2 * SINGLE
    assert not any(each[0] for each in visit(turns, 21.0))
    assert visit.messages == []
    visit.page.close()


# ---------------------------------------------------------------------- for everybody

AXE = Path(__file__).parent / "data" / "axe.min.js"
RULES = {"runOnly": {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["desktop", "phone"])
def test_the_page_keeps_to_the_guidelines_for_accessibility(size, scheme, orbiting, browser, tmp_path):
    """WCAG 2.2, level AA, as far as axe-core can tell."""
    width, height = size
    path = pt.view(orbiting[0], tmp_path / "orbit.html")
    visit = Visit(browser, path, width=width, height=height, has_touch=width < 500, color_scheme=scheme)
    visit(AXE.read_text(encoding="utf-8"))
    found = visit("rules => axe.run(document, rules)", RULES)
    assert [(each["id"], [node["html"] for node in each["nodes"]]) for each in found["violations"]] == []
    assert len(found["passes"]) > 10
    visit.page.close()


def test_dark_is_dark_and_light_is_light(browser, tmp_path):
    path = pt.view(MOTION, tmp_path / "free.html")
    visit = Visit(browser, path, color_scheme="dark")
    for sky, scheme, is_dark in (("space", "light", True), ("plain", "dark", True), ("plain", "light", False)):
        visit.page.select_option("#sky", sky)
        visit.page.emulate_media(color_scheme=scheme)
        visit.page.wait_for_timeout(100)
        with Image.open(io.BytesIO(visit.page.locator("#scene").screenshot())) as picture:
            assert (np.median(np.asarray(picture.convert("L"))) < 60) == is_dark
    visit.page.close()


def test_a_finger_on_the_scene_can_scroll_the_page_and_targets_are_large(browser, tmp_path):
    visit = Visit(
        browser, pt.view(MOTION, tmp_path / "free.html"), width=390, height=600, has_touch=True, is_mobile=True
    )
    assert visit("getComputedStyle(document.getElementById('scene')).touchAction") == "pan-y"
    for control in visit.page.locator("input, select, button").all():
        if control.is_visible():
            box = control.bounding_box()
            assert min(box["width"], box["height"]) >= 24
    visit.page.close()


def test_vectors_in_one_place_are_inside_each_other(browser, tmp_path):
    """Of a steady spin G, omega, an axis of the body and one of space have one direction; no radius is another's."""
    spin = pt.Body((1.0, 1.0, 2.0))
    motion = pt.free_motion(spin, spin.state((1, 0, 0, 0), omega_body=(0, 0, 1)), np.linspace(0, 30, 301))
    visit = Visit(browser, pt.view(motion, tmp_path / "spin.html"), width=640, height=480)
    radii = np.sort(visit("Object.values(SHAFT)"))
    assert np.all(radii[1:] / radii[:-1] > 1 / np.cos(np.pi / 12))
    tips = visit("""() => ["angular_momentum", "space_axes"].map(name => {
        const { scene, camera, parts } = poinsot.scene;
        scene.updateMatrixWorld();
        const heights = [];
        parts[name].traverse(part => {
            if (!part.isLabel) return;
            const place = part.getWorldPosition(new THREE.Vector3()).project(camera);
            heights.push(Math.abs(place.y));
        });
        return Math.max(...heights);
    })""")
    assert max(tips) < 1
    visit.page.close()


WORDS = """([time, turn]) => {
    poinsot.scene.turn(turn, 0, 1);
    poinsot.setTime(time);
    const box = (each) => each.getBoundingClientRect();
    const edges = ({ left, right, top, bottom }) => [left, right, top, bottom];
    return [...document.querySelectorAll("#labels span:not([hidden])")].map((each) => edges(box(each)));
}"""


def test_words_do_not_cover_one_another(browser, tmp_path):
    """Of a spin that is nearly steady, where axes of body and space, momentum and rate have one direction."""
    spin = pt.Body((1.0, 1.2, 2.0))
    motion = pt.free_motion(spin, spin.state((1, 0, 0, 0), omega_body=(1e-2, 0, 1)), np.linspace(0, 30, 301))
    visit = Visit(browser, pt.view(motion, tmp_path / "spin.html"))
    for box in visit.page.locator("#parts input").all():
        box.check()
    frame = visit.page.locator("#space").bounding_box()
    for time, turn in ((0.0, 0.0), (6.25, 0.4), (9.5, 1.1), (12.6, -0.7)):
        left, right, top, bottom = np.transpose(visit(WORDS, [time, turn]))
        assert left.size >= 6  # of 8, of which those without a place near their arrows are hidden
        first, second = np.triu_indices(left.size, 1)
        separate = (left[first] >= right[second]) | (left[second] >= right[first])
        above = (top[first] >= bottom[second] - 1) | (top[second] >= bottom[first] - 1)
        assert np.all(separate | above)
        assert np.all((left >= frame["x"] - 1) & (right <= frame["x"] + frame["width"] + 1))
    assert visit.messages == []
    visit.page.close()


def test_labels_are_hidden_with_their_arrows(browser, tmp_path):
    visit = Visit(browser, pt.view(MOTION, tmp_path / "free.html"))
    shown = "[...document.querySelectorAll('#labels span:not([hidden])')].map((each) => each.textContent)"
    visit("poinsot.setTime(3)")
    assert set(visit(shown)) <= {"b₁", "b₂", "b₃", "G", "ω"}
    visit.page.locator("[data-part=body_axes]").uncheck()
    visit("poinsot.setTime(3)")
    assert set(visit(shown)) == {"G", "ω"}
    visit.page.close()


def test_plotted_quantities_suit_the_system(orbiting, two):
    motion, visit = orbiting
    assert visit("[...document.querySelectorAll('figure')].map((each) => each.dataset.quantity)") == [
        "roll_pitch_yaw",
        "omega_body",
    ]
    i = 500
    visit("t => poinsot.setTime(t)", motion.times[i])
    shown = visit.page.locator("[data-quantity=roll_pitch_yaw] output").all_text_contents()
    expected = np.degrees(motion.relative_to(ORBIT.frame).roll_pitch_yaw[i])
    assert [float(text.replace("−", "-")) for text in shown] == pytest.approx(expected, rel=5.1e-3, abs=0.01)
    motion, visit = two
    assert "libration" in visit("[...document.querySelectorAll('#plots select')[0].options].map((each) => each.value)")


def test_rounding_reads_0(browser, tmp_path):
    """A spin about the third axis from the identity; the first axis has the rounding 1e-17."""
    top = pt.Body((1.0, 1.0, 2.0))
    motion = pt.free_motion(top, top.state((1, 0, 0, 0), omega_body=(0, 0, 1)), np.linspace(0, 10, 101))
    quaternion = motion.quaternion.copy()
    quaternion[:, 1] = 1e-17
    phase = {**motion.phase, "quaternion": quaternion}
    shown = pt.Trajectory(motion.system, motion.initial, motion.times, MotionRows(phase), motion.run)
    visit = Visit(browser, pt.view(shown, tmp_path / "spin.html"), webgl=False)
    readings = visit(
        """t => { poinsot.setTime(t);
        return [...document.querySelectorAll('[data-quantity=quaternion] output')].map(each => each.textContent); }""",
        3.0,
    )
    assert readings[1:3] == ["0", "0"]
    assert "0" not in (readings[0], readings[3])
    assert visit("short(3e-9, 3, 1)") == "3.0e−9"
    visit.page.close()


JUMPS = """() => {
    const { lineTo, moveTo } = CanvasRenderingContext2D.prototype;
    const steps = [];
    let last = null;
    const pen = CanvasRenderingContext2D.prototype;
    pen.lineTo = function (x, y) { steps.push(Math.abs(y - last)); last = y; return lineTo.call(this, x, y); };
    pen.moveTo = function (x, y) { last = y; return moveTo.call(this, x, y); };
    const select = document.querySelector('[data-quantity=roll_pitch_yaw] select');
    const canvas = document.querySelector('[data-quantity=roll_pitch_yaw] canvas');
    select.dispatchEvent(new Event('change'));
    Object.assign(pen, { lineTo, moveTo });
    const grid = canvas.clientHeight - 42;
    return steps.filter((step) => step > 0.6 * grid && step < 0.99 * grid).length;
}"""


def test_angles_continue_at_the_other_edge_after_half_a_turn(browser, tmp_path):
    system = pt.System(pt.Body((1.0, 2.0, 2.5)), pt.GravityGradient(ORBIT))
    start = system.state((0.6, 0, 0, 0.8), omega_body=(1.0, 0, 0), frame=ORBIT.frame)
    motion = pt.propagate(system, start, np.linspace(0, 10, 101))
    visit = Visit(browser, pt.view(motion, tmp_path / "spin.html"), webgl=False)
    assert visit(JUMPS) == 0
    roll = motion.relative_to(ORBIT.frame).roll_pitch_yaw[:, 0]
    (first, _) = np.flatnonzero(np.abs(np.diff(roll)) > np.pi)
    visit("t => poinsot.setTime(t)", motion.times[first] + 0.05)
    shown = visit.page.locator("[data-quantity=roll_pitch_yaw] output").first.text_content()
    assert abs(float(shown.replace("−", "-"))) > 170
    visit.page.close()


def test_times_far_from_zero_are_read_with_all_digits(browser, tmp_path):
    motion = pt.free_motion(BODY, STATE, 2e9 + np.linspace(0, 1e5, 51))
    visit = Visit(browser, pt.view(motion, tmp_path / "far.html"), webgl=False)
    visit("poinsot.setTime(2.00005e9)")
    assert visit("document.getElementById('now').textContent") == "t = 2.00005e9"
    visit.page.close()
    motion = pt.free_motion(BODY, STATE, [2e9, 2e9 + 4.8e-7])
    visit = Visit(browser, pt.view(motion, tmp_path / "near.html"), webgl=False)
    assert visit.messages == [message for message in visit.messages if "WebGL" in message]
    visit.page.close()
