"""The page of the 3D view: its content, its policy and its file."""

import base64
import datetime as dt
import hashlib
import html
import json
import re
from importlib import resources

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.plot.view import View
from poinsot.propagation.column_reader import MotionRows

SI = {"time": "s", "inertia": "kg m2"}
TURNED = Rotation.from_rotvec([0.4, -0.9, 0.5]).as_matrix()
OBLIQUE = pt.Body.from_inertia(TURNED @ np.diag([2.0, 3.0, 4.0]) @ TURNED.T)
PAGE = resources.files("poinsot.plot") / "page"


def free(body=OBLIQUE, g=(0.5, -0.7, 1.1), times=None, units=SI):
    state = body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g)
    return pt.propagate(pt.System(body, units=units), state, np.linspace(-3, 40, 301) if times is None else times)


def content(motion):
    """The data in the page, as its script reads them."""
    return content_in(pt.view(motion).html)


def content_in(page):
    return json.loads(re.search(r'<script type="application/json" id="motion">(.*?)</script>', page, re.DOTALL)[1])


def decoded(packed, columns):
    values = np.frombuffer(base64.b64decode(packed["data"]), "<f4").astype(float) * packed["scale"]
    return values.reshape(-1, columns)


# ---------------------------------------------------------------------- content


@pytest.mark.parametrize("order", [1, -1])
def test_the_page_has_the_motion_forwards_in_time(order):
    motion = free(times=np.linspace(-3, 40, 301)[::order])
    data = content(motion)
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(data["times"])), motion.times[::order])
    for name, values in {
        "quaternion": motion.quaternion,
        "omega_body": motion.omega_body,
        "angular_momentum_space": motion.angular_momentum_space,
    }.items():
        found = decoded(data["arrays"][name], values.shape[-1])
        np.testing.assert_allclose(found, values[::order], rtol=0, atol=6e-8 * np.abs(values).max())


def test_sizes_beyond_single_precision_are_preserved():
    jupiter = pt.Body((2.4e42, 2.4e42, 2.5e42))
    motion = free(jupiter, (1e38, 2e38, 4.4e38), np.linspace(0, 1e6, 11))
    found = decoded(content(motion)["arrays"]["angular_momentum_space"], 3)
    np.testing.assert_allclose(found, motion.angular_momentum_space, rtol=0, atol=1e32)


def test_units_label_what_is_shown():
    data, plain = content(free()), content(free(units={}))
    labels, factors = data["labels"], data["factors"]
    assert data["quantities"]["momenta"]["label"] == "conjugate momenta Q [N m s]"
    assert (labels["time"], labels["unit"], labels["omega_body"]) == ("time [s]", " s", " [deg s⁻¹]")
    assert factors == pytest.approx({"time": 1, "omega_body": 180 / np.pi})
    assert (plain["labels"]["unit"], plain["labels"]["omega_body"]) == ("", " [rad / unit of time]")
    assert set(plain["factors"].values()) == {1.0}


@pytest.mark.parametrize(
    ("units", "torque", "momentum"),
    [(SI, " [N m]", " [N m s]"), ({"time": "min", "inertia": "g cm2"}, " [g cm² min⁻²]", " [g cm² min⁻¹]")],
)
def test_torques_and_momenta_have_their_units(units, torque, momentum):
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    system = pt.System(OBLIQUE, pt.GravityGradient(orbit), pt.parts.Gyrostat((0, 0.1, 0.2)), units=units)
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 1.0)), np.linspace(0, 3, 7))
    vectors = content(motion)["around"]["vectors"]
    named = {vector["name"]: vector["unit"] for vector in vectors}
    assert named == {"torque of gravity gradient": torque, "momentum of gyrostat": momentum}


def test_long_times_are_shown_in_hours_and_fast_rotations_in_turns_a_minute():
    data = content(free(g=(0, 0, 8.0), times=np.linspace(0, 36000, 11)))
    assert (data["labels"]["time"], data["labels"]["unit"], data["labels"]["omega_body"]) == (
        "time [h]",
        " h",
        " [rpm]",
    )
    assert data["factors"]["time"] == pytest.approx(1 / 3600)
    assert data["factors"]["omega_body"] == pytest.approx(30 / np.pi)
    assert np.frombuffer(base64.b64decode(data["times"]))[-1] == 36000


@pytest.mark.parametrize("sides", [(1.0, 2.0, 3.0), (3.0, 0.5, 1.0)])
def test_the_solids_have_the_moments_of_the_body(sides):
    body = pt.Body.from_box(2.0, sides)
    extent = np.array(content(free(body))["solids"]["extent"])
    np.testing.assert_allclose(extent, np.array(sides) / max(sides), rtol=1e-12)
    for moments in (pt.Body.from_box(1.0, 2 * extent).moments, pt.Body.from_ellipsoid(1.0, extent).moments):
        np.testing.assert_allclose(moments / np.sum(moments), body.moments / np.sum(body.moments), rtol=1e-12)


def test_a_flat_plate_remains_visible():
    assert content(free(pt.Body((1.0, 2.0, 3.0))))["solids"]["extent"][2] == 0.01


def test_the_polhode_lies_on_the_inertia_ellipsoid():
    motion = free()
    solids = content(motion)["solids"]
    principal = Rotation.from_quat(solids["principal"], scalar_first=True)
    along = principal.inv().apply(motion.omega_body) / solids["inertia_ellipsoid"]
    np.testing.assert_allclose(np.linalg.norm(along, axis=-1), 1, rtol=1e-14)


def test_the_rate_touches_the_invariable_plane_within_its_disc():
    motion = free()
    plane = content(motion)["plane"]
    normal = np.array(plane["normal"])
    np.testing.assert_allclose(motion.omega_space @ normal, plane["height"], rtol=1e-12)
    across = motion.omega_space - np.outer(motion.omega_space @ normal, normal)
    assert np.max(np.linalg.norm(across, axis=-1)) < plane["radius"]


def test_under_torques_there_is_neither_ellipsoid_nor_plane(top, start):
    data = content(pt.propagate(top, start, np.linspace(0, 10, 101)))
    assert data["plane"] is None
    assert data["solids"]["inertia_ellipsoid"] is None


def test_a_body_at_rest_can_be_viewed():
    data = content(free(g=(0, 0, 0)))
    assert (data["mean_rate"], data["plane"], data["rate"]) == (0, None, 4.3)


def test_the_speed_of_the_start_is_a_turn_in_four_seconds():
    spin = free(pt.Body((1.0, 1.0, 1.0)), (0, 0, 2.0))
    assert content(spin)["rate"] == pytest.approx(2 * np.pi / 2.0 / 4, rel=1e-14, abs=0)
    assert content(spin)["mean_rate"] == pytest.approx(2.0, rel=1e-14, abs=0)


@pytest.mark.parametrize(("steps", "noted"), [(14, False), (12, True)])
def test_a_note_warns_of_large_turns_between_stored_times(steps, noted):
    spin = free(pt.Body((1.0, 1.0, 1.0)), (0, 0, 2.0), np.linspace(0, 20, steps + 1))
    note = content(spin)["note"]
    assert note.startswith("Between two times of the page the body turns by up to 191°") == noted
    assert bool(note) == noted


def test_a_mesh_is_drawn_from_its_centre_of_mass():
    mesh = pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), density=1.5).moved(position=(7.0, -3.0, 2.0))
    (part,) = content(free(pt.Body.from_shape(mesh)))["solids"]["shape"]
    corners = decoded(part["triangles"], 3)
    assert corners.shape == (36, 3)
    np.testing.assert_allclose(np.max(corners, axis=0), np.array([1, 2, 3]) / np.sqrt(14), rtol=1e-6)
    np.testing.assert_allclose(np.min(corners, axis=0), -np.array([1, 2, 3]) / np.sqrt(14), rtol=1e-6)
    volume = np.sum(np.linalg.det(corners.reshape(12, 3, 3))) / 6
    assert volume == pytest.approx(8 * 6 / 14**1.5, rel=1e-6)


TURN = Rotation.from_rotvec([0.5, -1.1, 0.7])
PARTS = (
    pt.shapes.Cylinder(0.3, 2.0, mass=3.0).moved((0.5, 1.0, -2.0), TURN),
    pt.shapes.Ellipsoid((0.5, 1.0, 0.7), mass=4.0).moved((-1.0, 0.0, 2.0), TURN.inv()),
)
POINTS = pt.shapes.Mascons((5.0, 1.0, 2.0, 2.5), ((2, 0, 0), (-3, 1, 0), (0, 2, 1), (0.3, -2, -1)))


def inertia_as_drawn(part, mass):
    """The tensor about the origin of the picture, from radii, place and turn alone."""
    a, b, c = part["sides"]
    moments = {
        "ellipsoid": mass / 5 * np.array([b * b + c * c, a * a + c * c, a * a + b * b]),
        "cylinder": mass / 12 * np.array([3 * a * a + 4 * c * c, 3 * a * a + 4 * c * c, 6 * a * a]),
    }[part["solid"]]
    turn, x = Rotation.from_quat(part["turn"], scalar_first=True).as_matrix(), np.array(part["place"])
    return turn @ np.diag(moments) @ turn.T + mass * (x @ x * np.eye(3) - np.outer(x, x))


def test_parts_are_drawn_where_their_mass_is():
    shape = pt.shapes.Assembly([PARTS[0], pt.shapes.Assembly([PARTS[1]])]).moved(
        (10.0, 20.0, 30.0), Rotation.from_rotvec([0, 1, 2])
    )
    body = pt.Body.from_shape(shape)
    drawn = content(free(body))["solids"]["shape"]
    assert [part["solid"] for part in drawn] == ["cylinder", "ellipsoid"]
    found = sum(inertia_as_drawn(part, mass) for part, mass in zip(drawn, (3.0, 4.0), strict=True))
    np.testing.assert_allclose(found * shape.circumscribing_radius**2, body.inertia, rtol=0, atol=1e-14 * 7 * 30)


def test_mass_points_are_spheres_of_volumes_like_their_masses():
    (part,) = content(free(pt.Body.from_shape(POINTS)))["solids"]["shape"]
    rows = decoded(part["spheres"], 4)
    places = (POINTS.positions - POINTS.center_of_mass) / POINTS.circumscribing_radius
    np.testing.assert_allclose(rows[:, :3], places, rtol=0, atol=1e-7)
    np.testing.assert_allclose(rows[:, 3], 0.1 * np.cbrt(POINTS.masses / 5), rtol=1e-6)


def test_of_very_many_mass_points_the_heaviest_are_drawn():
    points = np.random.default_rng(6).normal(size=(20_050, 3))
    masses = np.where(np.arange(20_050) % 401 == 7, 1.0, 2.0)
    (part,) = content(free(pt.Body.from_shape(pt.shapes.Mascons(masses, points)), times=(0.0, 1.0)))["solids"]["shape"]
    rows = decoded(part["spheres"], 4)
    assert np.ptp(rows[:, 3]) == 0
    assert len(rows) == 20_000


def test_a_body_without_a_shape_is_drawn_by_its_moments():
    assert content(free())["solids"]["shape"] is None


def test_the_title_names_bodies_forces_and_duration():
    body, units = pt.Body((1.0, 1 + 1 / 3, 1.5)), {"time": "s", "inertia": "kg m2"}
    assert content(free(body))["title"].startswith("One body, free rotation, ")
    forces = pt.UniformGravity(0.5, (1, 0, 0)), pt.forces.LinearDamping(0.01), pt.forces.LinearDamping(0.02)
    top = pt.System(body, *forces, units=units)
    motion = pt.propagate(top, top.state((1, 0, 0, 0), omega_body=(0, 0.1, 2)), np.linspace(0, 9000, 3))
    assert content(motion)["title"] == "One body, uniform gravity, linear damping, 150 minutes"
    assert "<title>A falling top</title>" in pt.view(motion, title="A falling top").html


# ---------------------------------------------------------------------- very many times


def shown_numbers(packed, columns):
    kind = {"f4": "<f4", "i2": "<i2"}[packed["kind"]]
    return np.frombuffer(base64.b64decode(packed["data"]), kind).astype(float).reshape(-1, columns) * packed["scale"]


@pytest.mark.parametrize("order", [1, -1])
def test_of_very_many_times_a_page_has_those_after_equal_turns_and_the_extremes_of_all(order):
    """A slow half and a fast one of 2e5 times each: the fast one has as many more times as it turns more."""
    body = pt.Body((1.0, 1.0, 1.0))
    slow, fast = 0.01, 1.0
    times = np.linspace(0, 4000, 400_001)
    angle = np.where(times < 2000, slow * times, slow * 2000 + fast * (times - 2000))
    rate = np.where(times < 2000, slow, fast)
    q = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=-1)
    phase = {"quaternion": q[::order], "angular_momentum_body": (np.array([[0, 0, 1]]) * rate[:, None])[::order]}
    made = free(body, (0, 0, 1), (0.0, 1.0))
    motion = pt.Trajectory(made.system, made.initial, times[::order], MotionRows(phase), made.run)
    page = pt.view(motion).html
    assert len(page) < 5e6
    data = content_in(page)
    assert data["stored"] == times.size
    chosen = np.frombuffer(base64.b64decode(data["times"]))
    assert np.all(np.diff(chosen) > 0)
    assert (chosen[0], chosen[-1]) == (0, 4000)
    at = np.searchsorted(times, chosen)
    np.testing.assert_allclose(shown_numbers(data["arrays"]["quaternion"], 4), q[at], rtol=0, atol=1 / 32767)
    share = np.mean(chosen < 2000)
    assert share == pytest.approx(0.5 * (0.5 + slow / (slow + fast)), abs=0.01)
    envelope = {side: shown_numbers(data["envelopes"]["quaternion"][side], 4) for side in ("low", "high")}
    edges = np.append(np.searchsorted(times, np.linspace(0, 4000, 1024, endpoint=False)), times.size)
    for first, last, low, high in list(zip(edges, edges[1:], envelope["low"], envelope["high"], strict=False))[::97]:
        np.testing.assert_allclose(low, np.min(q[first:last], axis=0), rtol=0, atol=1 / 32767)
        np.testing.assert_allclose(high, np.max(q[first:last], axis=0), rtol=0, atol=1 / 32767)


# ---------------------------------------------------------------------- what is around a body

MU, RADIUS, DISTANCE = 3.986004418e14, 6.3781e6, 7.2e6
SUN = (-1.2e11, 8e10, 2e10)
FACETS = pt.forces.Facets.from_box(
    (0.2, 0.3, 0.4),
    (0.01, 0, 0),
    wing_areas=[0.09],
    wing_normals=[(0, 0, 1)],
    wing_positions=[(0, 0.5, 0)],
    specular=0.25,
)


@pytest.fixture(scope="module")
def orbiting():
    orbit = pt.KeplerOrbit(MU, semimajor_axis=DISTANCE, eccentricity=0.1, inclination=0.7, node=0.3)
    earth = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.29e-5)
    forces = (
        pt.GravityGradient(orbit),
        pt.forces.RadiationPressure(
            pt.orbits.FixedPosition(1.327e20, position=SUN), FACETS, [pt.forces.Occulter(orbit, RADIUS)]
        ),
        pt.forces.MagneticMoment((0.1, 0, 0.2), pt.forces.TiltedDipole(orbit, earth, -3e-5, 0.0, 0.0, 6.3712e6)),
        pt.parts.Gyrostat((0, 0.1, 0.2)),
    )
    system = pt.System(pt.Body((4.0, 5.0, 6.0)), *forces, units=SI)
    start = system.state((0.5, 0.5, -0.5, 0.5), omega_body=(1e-3, 2e-3, 5e-3))
    event = pt.events.SpinFlip((0, 0, 1))
    motion = pt.propagate(system, start, np.linspace(0, 7000, 701), events=[event])
    return motion, content(motion)


def test_orbit_sun_and_shadow_are_those_of_the_forces(orbiting):
    """The Sun is in one direction, and all of it is behind the Earth in the cylinder behind that."""
    motion, data = orbiting
    around = data["around"]["orbit"]
    assert (around["attractor"], around["radius"], around["moves"], around["lit"]) == ("Earth", RADIUS, True, True)
    r, v = (decoded(data["arrays"][f"orbit_{name}"], 3) for name in ("position", "velocity"))
    distance = np.linalg.norm(r, axis=-1)
    assert (around["nearest"], around["farthest"]) == pytest.approx((distance.min(), distance.max()), rel=1e-6)
    np.testing.assert_allclose(np.sum(v**2, axis=-1), MU * (2 / distance - 1 / DISTANCE), rtol=1e-6)
    np.testing.assert_allclose(np.gradient(r, motion.times, axis=0)[1:-1], v[1:-1], rtol=0, atol=1e-4 * np.abs(v).max())
    towards = -np.array(SUN) / np.linalg.norm(SUN)
    np.testing.assert_allclose(decoded(data["arrays"]["sun"], 3), np.broadcast_to(towards, r.shape), rtol=0, atol=1e-7)
    behind, across = -r @ towards, np.linalg.norm(r - np.outer(r @ towards, towards), axis=-1)
    seen = decoded(data["arrays"]["sunlight"], 1)[:, 0]
    assert np.all(seen[(behind > 0) & (across < 0.98 * RADIUS)] == 0)
    assert np.all(seen[(behind < 0) | (across > 1.02 * RADIUS)] == 1)
    assert 0.1 < np.mean(seen) < 0.9


@pytest.mark.parametrize("bodies", [1, 2])
def test_arrows_point_to_the_sun_and_the_observer_that_are_given(bodies):
    towards = {"sun": np.array((1.0, 2.0, -2.0)), "observer": np.array((0.0, -3.0, 4.0))}
    orbits = {name: pt.orbits.FixedPosition(1.0, position=-5 * at) for name, at in towards.items()}
    motion = pair_motion() if bodies == 2 else free()
    page = pt.view(motion, **orbits).html
    data = content_in(page)
    assert data["around"]["arrows"] == ["sun", "observer"]
    for name, at in towards.items():
        expected = np.broadcast_to(at / np.linalg.norm(at), (motion.times.size, 3))
        np.testing.assert_allclose(decoded(data["arrays"][name], 3), expected, rtol=0, atol=1e-7)
        assert f'data-part="{name}" checked' in page
    assert not content(motion)["around"]["arrows"]
    assert 'data-part="observer"' not in pt.view(motion).html


def test_the_sun_that_is_given_takes_the_place_of_the_sun_of_the_forces(orbiting):
    motion, before = orbiting
    data = content_in(pt.view(motion, sun=pt.orbits.FixedPosition(1.0, position=(0, 0, -1.0))).html)
    np.testing.assert_allclose(decoded(data["arrays"]["sun"], 3)[7], (0, 0, 1), rtol=0, atol=1e-7)
    assert np.array_equal(decoded(data["arrays"]["sunlight"], 1), decoded(before["arrays"]["sunlight"], 1))


def test_an_observer_of_members_is_refused():
    many = pt.orbits.FixedPosition(1.0, position=np.eye(3))
    with pytest.raises(
        ValueError, match=r"^observer must be one orbit, got 3 members\. Pass the orbit of one member\.$"
    ):
        pt.view(free(), observer=many)


def test_vectors_are_the_torques_fields_and_momenta_along_the_body_axes(orbiting):
    """The torque of gravity is 3 mu/r^5 r x I r, the field that of a dipole, and the torque of the moment m x B."""
    motion, data = orbiting
    vectors = {vector["name"]: vector for vector in data["around"]["vectors"]}
    found = {name: decoded(data["arrays"][vector["array"]], 3) for name, vector in vectors.items()}
    assert set(found) == {
        *("torque of gravity gradient", "torque of radiation pressure", "torque of magnetic moment"),
        *("magnetic field", "momentum of gyrostat"),
    }
    r = motion.attitude.inv().apply(decoded(data["arrays"]["orbit_position"], 3))
    size = np.linalg.norm(r, axis=-1, keepdims=True)
    gravity = 3 * MU / size**5 * np.cross(r, r * (4.0, 5.0, 6.0))
    np.testing.assert_allclose(found["torque of gravity gradient"], gravity, rtol=0, atol=1e-6 * np.abs(gravity).max())
    field = found["magnetic field"]
    np.testing.assert_allclose(
        found["torque of magnetic moment"], np.cross((0.1, 0, 0.2), field), rtol=0, atol=1e-6 * np.abs(field).max()
    )
    pole = motion.attitude.inv().apply((0, 0, 1))
    dipole = 3e-5 * (6.3712e6 / size) ** 3 * (pole - 3 * np.sum(pole * r, axis=-1, keepdims=True) * r / size**2)
    np.testing.assert_allclose(field, dipole, rtol=0, atol=1e-6 * np.abs(dipole).max())
    np.testing.assert_allclose(
        found["momentum of gyrostat"], np.broadcast_to((0, 0.1, 0.2), r.shape), rtol=0, atol=1e-7
    )
    for name, values in found.items():
        assert vectors[name]["largest"] >= np.linalg.norm(values, axis=-1).max() * (1 - 1e-6)


def test_facets_are_drawn_with_their_areas_and_places(orbiting):
    """The sides of a box are its rectangles, a wing a square, all in one unit of length."""
    _, data = orbiting
    drawn = data["around"]["facets"]
    corners = drawn["size"] * decoded(drawn["corners"], 3).reshape(-1, 4, 3)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    np.testing.assert_allclose(np.cross(first, second), FACETS.areas[:, None] * FACETS.normals, rtol=0, atol=1e-7)
    np.testing.assert_allclose(corners.mean(axis=1), FACETS.positions, rtol=0, atol=1e-7)
    box = corners[:6].reshape(-1, 3) - (0.01, 0, 0)
    np.testing.assert_allclose(np.abs(box), np.broadcast_to((0.1, 0.15, 0.2), box.shape), rtol=0, atol=1e-7)
    assert drawn["shares"] == [[0.25, 0.0]] * 8


@pytest.mark.parametrize("order", [1, -1])
def test_wheels_turn_about_their_axes_by_a_round_part_of_their_angle(order):
    """Of a wheel with a constant torque the angle is 1/2 a t^2 relative to the body, which turns the other way."""
    wheel = pt.parts.ReactionWheel((0, 0, 1), moment=0.1, torque=0.02)
    still = pt.parts.ReactionWheel((0.6, 0.8, 0), moment=0.2, name="still")
    system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheel, still)
    start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    motion = pt.propagate(system, start, np.linspace(0, 4000, 4001)[::order])
    page = pt.view(motion).html
    data = content_in(page)
    assert data["around"]["wheels"]["axes"] == [[0, 0, 1], [0.6, 0.8, 0]]
    slower = data["around"]["wheels"]["slower"]
    speed = 0.02 * (1 / 0.1 + 1 / 0.65) * motion.times
    assert slower / 2.5 < np.max(speed) * data["rate"] / np.pi <= slower
    assert slower in (1, 2, 5, 10, 20, 50, 100, 200, 500)
    assert f"wheels, {slower} times slower" in page
    angles = decoded(data["arrays"]["wheel_angles"], 2)[::order]
    exact = 0.5 * speed * motion.times
    np.testing.assert_allclose(
        angles[:, 0] - angles[0, 0], (exact - exact[0]) / slower, rtol=0, atol=1e-6 * exact.max() / slower
    )
    np.testing.assert_allclose(angles[:, 1], 0, rtol=0, atol=1e-9 * exact.max() / slower)


def test_events_are_on_the_line_of_time(orbiting):
    motion, data = orbiting
    (found,) = data["events"]
    assert found["name"] == "SpinFlip"
    np.testing.assert_array_equal(found["times"], motion.events[0].times)


def test_a_known_parameter_names_the_attractor_and_its_size():
    for mu, length, unit in ((42828.4, 1.0, "s"), (4.28284e13, 1000.0, "s"), (42828.4 * 86400**2, 1.0, "d")):
        orbit = pt.KeplerOrbit(mu, semimajor_axis=9376.0 * length, eccentricity=0.01)
        system = pt.System(pt.Body((1.0, 2.0, 2.5)), pt.GravityGradient(orbit), units={"time": unit})
        motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 1e-4)), (0.0, 100.0))
        found = content(motion)["around"]["orbit"]
        assert (found["attractor"], found["radius"]) == ("Mars", 3396.19 * length)


def test_an_attractor_that_the_orbit_enters_is_drawn_small_and_the_sun_has_no_shadow():
    """A perigee below the ground, and light from the body about which the orbit is."""
    low = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.2)
    far = pt.KeplerOrbit(1.32712440018e20, semimajor_axis=1.5e11, eccentricity=0.0)
    light = pt.forces.RadiationPressure(far, FACETS)
    for force, size, lit in ((pt.GravityGradient(low), "drawn small, the orbit enters it", False), (light, "", False)):
        system = pt.System(pt.Body((4.0, 5.0, 6.0)), force, units=SI)
        start = system.state((0.5, 0.5, -0.5, 0.5), omega_body=(1e-3, 2e-3, 5e-3))
        page = pt.view(pt.propagate(system, start, np.linspace(0, 7000, 71))).html
        orbit = content_in(page)["around"]["orbit"]
        assert (orbit["radius"] is None, orbit["size"], orbit["lit"]) == (bool(size), size, lit)
        assert 'data-part="shadow"' not in page


def test_dates_are_those_of_the_calendar():
    calendar = pt.Calendar("2029-04-13T21:46:00", "TDB", "min")
    motion = free()
    motion._complete(provenance={"calendar": calendar})
    found = content(motion)["calendar"]
    shown = dt.datetime.fromtimestamp((found["zero"] + 1.5 * found["unit"]) / 1000, dt.UTC)
    assert (shown.isoformat(), found["scale"]) == ("2029-04-13T21:47:30+00:00", "TDB")


# ---------------------------------------------------------------------- other motions


def test_other_motions_share_the_page_and_of_many_some_are_there():
    starts = OBLIQUE.state((1, 0, 0, 0), omega_body=np.linspace((0.1, 0.2, 0.3), (0.4, 0.1, 0.2), 22))
    others = pt.propagate(pt.System(OBLIQUE, units=SI), starts, np.linspace(0, 10, 21)[::-1])
    page = pt.view(free(), others=[free(), others]).html
    ghosts = content_in(page)["ghosts"]
    assert len(ghosts) == 8
    assert ">8 other motions<" in page
    last = ghosts[-1]
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(last["times"])), others.times[::-1])
    np.testing.assert_allclose(decoded(last["arrays"]["quaternion"], 4), others.quaternion[21][::-1], rtol=0, atol=6e-8)
    np.testing.assert_allclose(decoded(last["arrays"]["omega_body"], 3), others.omega_body[21][::-1], rtol=0, atol=6e-8)


# ---------------------------------------------------------------------- two bodies


def pair_motion(shape=True, times=None, members=None):
    first = pt.Body.from_shape(pt.shapes.Ellipsoid((1.0, 0.9, 0.7), mass=50.0).moved((3, 2, 1), TURN))
    first = first if shape else pt.Body.from_inertia(first.inertia, mass=50.0)
    pair = pt.TwoBodies(first, pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3)), G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity(), units={**SI, "length": "m"})
    velocity = np.broadcast_to((0.2, 3.0, 0.5), (3,) if members is None else (members, 3))
    start = pair.state((4.0, 0.0, 0.0), velocity, [(1, 0, 0, 0)] * 2, omega_body=[(0, 0.3, 2), (0, 0.1, 0.9)])
    return pt.propagate(system, start, np.linspace(0, 12, 241) if times is None else times)


@pytest.mark.parametrize("order", [1, -1])
def test_the_page_of_two_bodies_has_their_motion(order):
    motion = pair_motion(times=np.linspace(0, 12, 241)[::order])
    data = content(motion)
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(data["times"])), motion.times[::order])
    for name, values in {
        "position": motion.position,
        "velocity": motion.velocity,
        "angular_momentum_space": motion.angular_momentum_space,
        "primary_quaternion": motion.primary.quaternion,
        "secondary_quaternion": motion.secondary.quaternion,
        "primary_omega_body": motion.primary.omega_body,
        "secondary_omega_body": motion.secondary.omega_body,
    }.items():
        found = decoded(data["arrays"][name], values.shape[-1])
        np.testing.assert_allclose(found, values[::order], rtol=0, atol=6e-8 * np.abs(values).max())
    assert data["quantities"]["distance"]["label"] == "distance of the centres of mass [m]"
    assert data["quantities"]["secondary_omega_body"]["label"] == "angular velocity of the secondary [rpm]"


@pytest.mark.parametrize("shape", [True, False])
def test_two_bodies_are_drawn_to_scale(shape):
    """The homogeneous ellipsoid has the moments and the mass; a shape fills its radius."""
    motion = pair_motion(shape)
    data = content(motion)
    for (name, body), mass in zip(motion.system.body.bodies.items(), (50.0, 2.0), strict=True):
        drawn = data["bodies"][name]
        own = pt.Body.from_ellipsoid(mass, drawn["semiaxes"])
        turn = Rotation.from_quat(drawn["principal"], scalar_first=True).as_matrix()
        np.testing.assert_allclose(turn @ np.diag(own.moments) @ turn.T, body.inertia, rtol=0, atol=1e-14 * mass)
    first, second = data["bodies"]["primary"], data["bodies"]["secondary"]
    assert (first["shape"] is not None) == shape
    assert (first["radius"], second["radius"]) == pytest.approx((1.0, 0.5), rel=1e-14, abs=0)
    assert 50 * first["share"] + 2 * second["share"] == pytest.approx(0, abs=1e-13)
    assert second["share"] - first["share"] == pytest.approx(1, rel=1e-15, abs=0)
    assert data["reach"] == pytest.approx(motion.distance.max() * 50 / 52 + 0.5, rel=1e-12, abs=0)


def test_the_speed_of_two_bodies_is_that_of_their_orbit():
    motion = pair_motion()
    angle = np.unwrap(np.arctan2(motion.position[:, 1], motion.position[:, 0]))
    assert content(motion)["mean_rate"] == pytest.approx((angle[-1] - angle[0]) / 12, rel=5e-3)
    assert content(motion)["note"] == ""


def test_the_faster_of_two_bodies_is_named_where_it_turns_too_far():
    motion = pair_motion(times=np.linspace(0, 12, 7))
    turns = {name: 2 * np.max(np.linalg.norm(one.omega_body, axis=-1)) for name, one in motion.of_bodies.items()}
    assert turns["primary"] < turns["secondary"]
    note = content(motion)["note"]
    assert note.startswith(
        f"Between two times of the page the secondary turns by up to {np.degrees(turns['secondary']):.0f}°"
    )


def test_the_page_of_two_bodies_allows_its_own_scripts():
    page = pt.view(pair_motion()).html
    policy = re.search(r"script-src ([^;]*);", page)[1].split()
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    assert policy == [f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts]
    assert "{{" not in page.replace("\n".join(scripts), "")


# ---------------------------------------------------------------------- what the page may do

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)">'


class Named(pt.Potential):
    """A force whose name is markup."""

    def energy(self, instant):
        return 0.0 * instant.attitude.to_body((1.0, 0.0, 0.0))[0]

    def __repr__(self):
        return HOSTILE


def test_the_title_of_a_scenario_comes_first():
    motion = free(pt.Body((1.0, 1.33333333333, 1.5)))
    motion._complete(provenance={"title": "A stone"})
    assert content(motion)["title"] == "A stone"


def test_names_cannot_become_markup():
    body = pt.Body((1.0, 2.0, 2.5))
    system = pt.System(body, Named(), units={"time": HOSTILE, "inertia": "&lt;b&gt;<!--"})
    motion = pt.propagate(system, body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), (0.0, 1.0))
    page = pt.view(motion, title=HOSTILE).html
    plain = pt.view(free()).html
    for markup in ("<script", "</script", "<img", "<!--"):
        assert page.count(markup) == plain.count(markup)
    data = content(motion)
    assert HOSTILE in data["title"]
    assert data["labels"]["unit"] == f" {HOSTILE}"


def test_the_policy_allows_the_scripts_of_the_page_and_no_network():
    page = pt.view(free()).html
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)[1]
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts]
    assert rules["script-src"].split() == hashes
    assert (rules["default-src"], rules["img-src"], rules["base-uri"]) == ("'none'", "data:", "'none'")
    assert not re.search(r"<(link|img|script|iframe)[^>]*(src|href)=\"(?!data:)", page)


def test_the_library_is_the_one_that_its_note_names():
    library = (PAGE / "three.min.js").read_bytes()
    assert hashlib.sha256(library).hexdigest() in (PAGE / "README.md").read_text()
    licence = (PAGE / "three.LICENSE").read_text()
    assert licence in library.decode()
    assert licence in pt.view(free()).html


# ---------------------------------------------------------------------- where it goes


def test_a_page_is_written_and_never_over_another(tmp_path):
    path = pt.view(free(), tmp_path / "motion.html")
    assert path == tmp_path / "motion.html"
    written = path.read_bytes()
    assert written.decode() == pt.view(free()).html
    with pytest.raises(FileExistsError, match=r"motion\.html already exists; overwrite=True replaces it\.$"):
        pt.view(free(g=(1, 1, 1)), str(path))
    assert path.read_bytes() == written
    pt.view(free(g=(1, 1, 1)), path, overwrite=True)
    assert path.read_bytes() != written


def test_a_notebook_shows_the_page_in_a_frame():
    shown = pt.view(free())
    assert isinstance(shown, View)
    assert re.fullmatch(r"View\(0\.\d MB of HTML\)", repr(shown))
    allowed = 'sandbox="allow-scripts allow-downloads"'
    frame = re.fullmatch(
        rf'<style>[^<>]*</style><div class="poinsot-view"><iframe srcdoc="([^"]*)" {allowed} [^<>]*></iframe></div>',
        shown._repr_html_(),
    )
    assert html.unescape(frame[1]) == shown.html


MANY = OBLIQUE.state([(1, 0, 0, 0)] * 3, omega_body=(0.4, -0.3, 0.6))
REFUSED = {
    "state": (lambda _: pt.view(MANY), TypeError, "motion must be a Trajectory, got State."),
    "ensemble": (
        lambda _: pt.view(pt.propagate(pt.System(OBLIQUE), MANY, (0.0, 1.0))),
        ValueError,
        "motion must be of one body, got an ensemble of 3 members. Take one: motion.member(0).",
    ),
    "ensemble_of_pairs": (
        lambda _: pt.view(pair_motion(members=3)),
        ValueError,
        "motion must be of one pair, got an ensemble of 3 members. Take one: motion.member(0).",
    ),
    "one_time": (
        lambda _: pt.view(free(times=(0.0,))),
        ValueError,
        "motion must have two times or more, got 1.",
    ),
    "suffix": (
        lambda folder: pt.view(free(), folder / "motion.htm"),
        ValueError,
        "path must end in .html, got 'motion.htm'.",
    ),
    "others_of_two_bodies": (
        lambda _: pt.view(pair_motion(), others=free()),
        ValueError,
        "others must be motions of as many bodies as the motion, got 1 for 2.",
    ),
    "others_at_one_time": (
        lambda _: pt.view(free(), others=free(times=(0.0,))),
        ValueError,
        "others must be motions at two times or more, got 1.",
    ),
    "folder": (
        lambda folder: pt.view(free(), folder / "no" / "motion.html"),
        FileNotFoundError,
        "No such folder: {folder}/no",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_wrong_arguments_are_refused_in_a_sentence(name, tmp_path):
    call, kind, sentence = REFUSED[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence.format(folder=tmp_path))}$") as caught:
        call(tmp_path)
    assert caught.type is kind
    assert not list(tmp_path.iterdir())
