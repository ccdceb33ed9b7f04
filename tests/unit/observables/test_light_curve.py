"""Tests of light curves: magnitudes, light time, two bodies, members, shapes, invalid input."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.observables import Lambert, LightCurve, LommelSeeliger
from poinsot.shapes.brightness import brightness_of
from poinsot.shapes.surface import Surface
from poinsot.shapes.visibility import clear_faces, clear_parts

AU = 149597870.7
LAW = LommelSeeliger(0.2)
BALL = pt.shapes.Ellipsoid((2.0, 2.0, 2.0), density=1.0)
EGG = pt.shapes.Ellipsoid((3.0, 2.0, 1.5), density=1.0)
BODY = pt.Body((1.25, 1.0, 0.75))
START = BODY.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.1, 0.3, 2))
TIMES = np.linspace(0.0, 3.0, 7)
UNITS = {"time": "s", "inertia": "kg km2"}


def fixed(*position):
    return pt.orbits.FixedPosition(1.0, position=position)


SUN, EARTH = fixed(1.1 * AU, 0.3 * AU, 0.2 * AU), fixed(0.3 * AU, -0.2 * AU, 0.5 * AU)


def moved(units=UNITS, times=TIMES, **options):
    return pt.propagate(pt.System(BODY, units=units), START, times, **options)


def curve(shape=EGG, law=LAW, sun=SUN, observer=EARTH, light_time=False, **options):
    return LightCurve(shape, law, sun, observer, light_time=light_time, **options)


def directions(motion):
    """Return the directions to Sun and observer, body axes, without code of observables."""
    rotations = Rotation.from_quat(motion.quaternion, scalar_first=True)
    return [rotations.inv().apply(-np.array(orbit.position)) for orbit in (SUN, EARTH)]


@pytest.mark.parametrize(
    ("brightness", "sun_distance", "distance", "expected"),
    [
        (4.848682336726737, 1.179786134857882, 0.583323283037265, 12.832005408435853),
        (4.660252403357454, 2.208446234636313, 1.802936723602974, 16.686814721928734),
    ],
)
def test_magnitudes(brightness, sun_distance, distance, expected):
    """Values with 50 digits of independent code; the Lambert ball at zero phase has B = 2 pi albedo R^2 / 3."""
    radius = np.sqrt(brightness / (2 * np.pi / 3))
    ball = pt.shapes.Ellipsoid((radius,) * 3, density=1.0)
    seen = curve(ball, Lambert(1.0), fixed(sun_distance * AU, 0, 0), fixed(distance * AU, 0, 0), kind="magnitude")
    assert np.allclose(pt.observe(moved(), seen).values, expected, rtol=0, atol=3e-10)


def test_kinds_agree():
    motion = moved()
    flux, magnitude, relative = pt.observe(motion, *(curve(kind=kind) for kind in ("flux", "magnitude", "relative")))
    s, e = directions(motion)
    expected = brightness_of(EGG, LAW, s.T, e.T)
    assert np.allclose(magnitude.values, -26.76 - 2.5 * np.log10(flux.values), rtol=1e-15, atol=0)
    reach = AU / np.linalg.norm(SUN.position) / np.linalg.norm(EARTH.position)
    assert np.allclose(flux.values, expected / np.pi * reach**2, rtol=1e-14, atol=0)
    assert np.ptp(relative.values / expected) < 1e-15
    assert [each.attributes["units"] for each in (flux, magnitude, relative)] == ["1", "mag", "1"]


@pytest.mark.parametrize("semiaxes", [(2.0, 2.0, 2.0), (3.0, 2.0, 1.5), (4.0, 1.0, 1.0)])
def test_a_relative_brightness_is_relative_to_the_mean_projected_area(semiaxes):
    """A quarter of the area of the surface (Cauchy); of a prolate spheroid in closed form."""
    (area,) = curve(pt.shapes.Ellipsoid(semiaxes, density=1.0), kind="relative").shape.areas
    a, b, c = semiaxes
    if a == b == c:
        assert abs(area / (4 * np.pi * a * a) - 1) < 1e-14
    elif b == c:
        e = np.sqrt(1 - (b / a) ** 2)
        assert abs(area / (2 * np.pi * b * b * (1 + a / b * np.arcsin(e) / e)) - 1) < 1e-12
    mesh = pt.shapes.Mesh.from_box(semiaxes, density=1.0)
    assert abs(sum(curve(mesh).shape.areas) / (2 * (a * b + b * c + c * a)) - 1) < 1e-14


def test_light_time_shows_an_earlier_attitude():
    motion, delay = moved(dense=True, times=np.linspace(-3000.0, 3.0, 7)), np.linalg.norm(EARTH.position) / 299792.458
    times = np.array([-1.0, 0.0, 2.5])
    seen = pt.observe(motion, curve(light_time=True), times=times)
    assert np.array_equal(seen.times, times)
    assert np.allclose(seen.values, pt.observe(motion, curve(), times=times - delay).values, rtol=1e-13, atol=0)
    assert np.allclose(seen.values, pt.observe(moved(), curve(light_time=True), times=times).values, rtol=1e-9, atol=0)


def test_light_time_needs_units():
    with pytest.raises(ValueError, match=r"light_time must have known units of time and length .* or light_time=False"):
        pt.observe(moved(units={}), curve(light_time=True))


def test_the_astronomical_unit_has_the_unit_of_length():
    motion = moved(units={"time": "s", "inertia": "kg m2"})
    with pytest.raises(ValueError, match=r"astronomical_unit must be 1\.495978707e\+11 for lengths in m, got"):
        pt.observe(motion, curve())
    assert pt.observe(motion, curve(kind="relative")).values.size == 7
    assert pt.observe(motion, curve(astronomical_unit=149597870700.0)).values.size == 7


def test_shapes_of_all_kinds():
    box = pt.shapes.Mesh.from_box((3.0, 2.0, 1.0), density=1.0)
    panels = pt.forces.Facets.from_box((3.0, 2.0, 1.0))
    motion = moved()
    of_mesh, of_panels = pt.observe(motion, curve(box), curve(panels))
    assert np.allclose(of_mesh.values, of_panels.values, rtol=1e-13, atol=0)


def test_a_stretched_ball_is_an_ellipsoid():
    stretched, egg = pt.observe(moved(), curve(BALL, stretch=(1.5, 1.0, 0.75)), curve(EGG))
    assert np.allclose(stretched.values, egg.values, rtol=1e-13, atol=0)


@pytest.mark.parametrize("name", ["sun", "observer"])
def test_sun_and_observer_are_outside_of_the_body(name):
    near = pt.orbits.FixedPosition(1.0, position=(0, 2.5, 0))
    message = rf"{name} must be outside of the body, got the distance 2\.5 at the time 0, below the radius 3\."
    with pytest.raises(ValueError, match=message):
        pt.observe(moved(), curve(**{name: near}))
    assert np.isfinite(pt.observe(moved(), curve(kind="relative", **{name: near})).values).all()
    members = pt.orbits.FixedPosition(1.0, position=[(0, 2.5, 0), (0, 9.0, 0)])
    with pytest.raises(ValueError, match=message):
        pt.observe(moved(), curve(**{name: members}))
    with pytest.raises(ValueError, match=f"{name} must be outside of the body"):
        pt.observe(moved(), curve(**{name: fixed(0, 9.0, 0)}, stretch=(4.0, 1, 1)))


def test_zero_flux_has_no_magnitude():
    plate = pt.forces.Facets([1.0], [(1, 0, 0)], [(0, 0, 0)])
    motion = moved()
    flux = pt.observe(motion, curve(plate)).values
    dark = flux == 0
    assert 0 < dark.sum() < dark.size
    with pytest.warns(UserWarning, match=rf"LightCurve .* none at some of 7 times: zero flux at {dark.sum()}"):
        magnitude = pt.observe(motion, curve(plate, kind="magnitude")).values
    assert np.array_equal(np.isnan(magnitude), dark)


def pair_motion():
    bodies = pt.TwoBodies(*(pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8)) for _ in range(2)), 1.0)
    state = bodies.state(
        (40, 0, 0), (0, 0.3, 0), [(0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0)], omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)]
    )
    return pt.propagate(pt.System(bodies, pt.forces.MutualGravity()), state, TIMES)


def two_boxes(sides, *places):
    """Return equal boxes at several places as one mesh."""
    box = pt.shapes.Mesh.from_box(sides, density=1.0)
    vertices = np.concatenate([box.vertices + place for place in places])
    faces = np.concatenate([box.faces + 8 * k for k in range(len(places))])
    return pt.shapes.Mesh(vertices, faces, density=1.0)


def test_two_bodies_add_their_light():
    motion, second = pair_motion(), Lambert(0.3)
    both = pt.observe(motion, curve((EGG, BALL), secondary_law=second, shadows=False))
    one, other = pt.observe(motion, curve(EGG).on("primary"), curve(BALL, second).on("secondary"))
    assert np.allclose(both.values, one.values + other.values, rtol=1e-14, atol=0)
    with pytest.raises(TypeError, match="LightCurve must be for the bodies of its system"):
        pt.observe(moved(), curve((EGG, BALL), shadows=False))
    with pytest.raises(TypeError, match="of two bodies"):
        pt.observe(motion, curve(EGG))


ANGLE = two_boxes((2.0, 1.0, 1.0), (0, 0, 0), (-0.75, 0, 1.0))
"""Two boxes, of which the upper one throws shadows on the lower one."""


@pytest.mark.parametrize("stretch", [(1.0, 1.0, 1.0), (1.2, 0.9, 1.1)])
def test_shadows_of_a_mesh(stretch):
    """The motion is about one axis, and the Sun is low."""
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body, units=UNITS), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), TIMES)
    seen = [
        curve(ANGLE, kind="relative", stretch=stretch, shadows=mode) for mode in ("exact", "centroids", "none", False)
    ]
    exact, centroids, none, again = (readings.values for readings in pt.observe(motion, *seen))
    assert np.array_equal(none, again)
    assert np.array_equal(exact, pt.observe(motion, curve(ANGLE, kind="relative", stretch=stretch)).values)
    assert np.all(exact <= none * (1 + 1e-14))
    assert np.sum(exact < 0.97 * none) > 2
    assert np.sum(centroids < 0.97 * none) > 2
    s, e = directions(motion)
    for mode, values in (("exact", exact), ("centroids", centroids)):
        expected = brightness_of(ANGLE, LAW, s.T, e.T, stretch, mode) * 4 / np.sum(ANGLE.face_areas)
        np.testing.assert_allclose(values, expected, rtol=1e-13, atol=1e-16)


def near_pair():
    """Return a system of two bodies near each other, and a state in which each passes before the other."""
    bodies = pt.TwoBodies(*(pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8)) for _ in range(2)), 1.0)
    state = bodies.state(
        (4, 0, 0.4), (0, 1, 0.1), [(0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0)], omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)]
    )
    return pt.System(bodies, pt.forces.MutualGravity()), state


def eclipsing(**options):
    """Return the light curve of two meshes; Sun and observer are near the plane of the orbit, and without parallax."""
    far = 1e5 * AU
    sun, observer = fixed(-0.9 * far, -0.5 * far, 0.03 * far), fixed(-1.0 * far, 0.1 * far, 0.05 * far)
    meshes = ANGLE, two_boxes((1.0, 1.5, 1.2), (0, 0, 0), (0.3, 0.6, 0.9))
    return curve(meshes, sun=sun, observer=observer, secondary_law=LommelSeeliger(0.3), kind="relative", **options)


def test_two_bodies_shadow_and_hide_each_other():
    """The reference is one mesh with the faces of both."""
    system, state = near_pair()
    motion = pt.propagate(system, state, np.linspace(0.0, 30.0, 41))
    seen = eclipsing()
    both = [pt.observe(motion, each) for each in (seen, eclipsing(shadows="centroids"))]
    meshes = seen.shape.each
    sides = [Rotation.from_quat(body.quaternion, scalar_first=True) for body in (motion.primary, motion.secondary)]
    area = sum(seen.shape.areas)
    for k, separation in enumerate(motion.position):
        vertices = [
            (mesh.vertices - mesh.center_of_mass) @ turn[k].as_matrix().T
            for mesh, turn in zip(meshes, sides, strict=True)
        ]
        vertices[1] = vertices[1] + separation
        faces = np.concatenate([meshes[0].faces, meshes[1].faces + len(vertices[0])])
        one = Surface(pt.shapes.Mesh(np.concatenate(vertices), faces, density=1.0))
        s, e = (-np.array(orbit.position) / np.linalg.norm(orbit.position) for orbit in (seen.sun, seen.observer))
        mu0, mu = np.maximum(one.normals @ s, 0), np.maximum(one.normals @ e, 0)
        light = (
            mu0 * mu / np.where(mu0 > 0, mu0 + mu, 1) / 4 * np.repeat((0.2, 0.3), [len(mesh.faces) for mesh in meshes])
        )
        areas = clear_parts(one, [s[None], e[None]]).areas[0], one.areas * clear_faces(one, [s[None], e[None]])[0]
        for found, clear in zip(both, areas, strict=True):
            assert found.values[k] == pytest.approx(clear @ light * 4 / area, rel=1e-11, abs=1e-14)
    laws = LAW, LommelSeeliger(0.3)
    alone = [
        own * pt.observe(motion, curve(mesh, law, seen.sun, seen.observer, kind="relative").on(name)).values
        for mesh, law, name, own in zip(meshes, laws, ("primary", "secondary"), seen.shape.areas, strict=True)
    ]
    lost = 1 - both[0].values * area / np.sum(alone, axis=0)
    assert lost.max() > 0.3
    assert 5 < np.sum(lost > 1e-3) < 36


def test_members_of_two_bodies_have_mutual_shadows():
    system, state = near_pair()
    positions = state.position + np.array([(0, 0, 0), (0.1, 0.2, -0.3), (-0.2, 0.1, 0.1)])
    starts = pt.PairState(positions, state.momentum, state.primary, state.secondary)
    motion, stretch = (
        pt.propagate(system, starts, np.linspace(0.0, 20.0, 9)),
        np.array([[1.0, 1, 1], [1.1, 1, 0.9], [1, 1, 1]]),
    )
    found = pt.observe(motion, eclipsing(stretch=stretch)).values
    assert found.shape == (3, 9)
    for k in range(3):
        alone = pt.observe(motion.member(k), eclipsing(stretch=stretch[k])).values
        np.testing.assert_allclose(found[k], alone, rtol=1e-12, atol=1e-15)


def test_derivatives_of_mutual_shadows():
    system, state = near_pair()
    seen, times = eclipsing(), np.array([5.0, 11.0, 17.0, 20.0])
    found = pt.analysis.observed_partials(system, state, seen, times, ["stretch"])

    def values(position=(0, 0, 0), stretch=(0, 0, 0)):
        shifted = pt.PairState(state.position + position, state.momentum, state.primary, state.secondary)
        motion = pt.propagate(system, shifted, times)
        return pt.observe(motion, eclipsing(stretch=1 + np.array(stretch))).values

    columns = [found.coordinates.index(f"position_{k}") for k in (1, 2, 3)]
    for k, step in enumerate(1e-5 * np.eye(3)):
        for change, slope in (
            (values(step) - values(-step), found.by_start[..., columns[k]]),
            (values((0, 0, 0), step) - values((0, 0, 0), -step), found.by_parameters[..., k]),
        ):
            np.testing.assert_allclose(slope, change / 2e-5, rtol=1e-5, atol=1e-6)


def test_members_of_albedo_stretch_orbits_and_states():
    albedo, stretch = np.array([0.1, 0.3]), np.array([[1.0, 1, 1], [1.2, 1, 0.8]])
    places = np.array([[0.3 * AU, 0, 0.5 * AU], [0.5 * AU, 0.1 * AU, 0]])
    observer = pt.orbits.FixedPosition(1.0, position=places)
    states = BODY.state((0.5, 0.5, -0.5, 0.5), omega_body=np.array([[0.1, 0.3, 2], [1, 0.2, 0.3]]))
    mesh = EGG.mesh(80) if hasattr(EGG, "mesh") else pt.shapes.Mesh.from_box((3.0, 2.0, 1.0), density=1.0)
    for shape, law in ((EGG, LommelSeeliger), (EGG, Lambert), (mesh, LommelSeeliger)):
        many = curve(shape, law(albedo), observer=observer, stretch=stretch)
        for start in (START, states):
            motion = pt.propagate(pt.System(BODY, units=UNITS), start, TIMES)
            seen = pt.observe(motion, many).values
            assert seen.shape == (2, 7)
            for i in (0, 1):
                own = motion.member(i) if motion.is_ensemble else motion
                alone = curve(shape, law(albedo[i]), observer=fixed(*places[i]), stretch=stretch[i])
                assert np.allclose(seen[i], pt.observe(own, alone).values, rtol=1e-13, atol=0)


def test_a_curve_can_be_pickled_and_compared():
    seen = curve(kind="magnitude", noise=0.02)
    again = pickle.loads(pickle.dumps(seen))
    assert repr(again) == repr(seen)
    motion = moved()
    assert np.array_equal(pt.observe(motion, again).values, pt.observe(motion, seen).values)
    assert pt.observables.Readings(seen, TIMES).sigma == 0.02


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "mag"}, "kind must be 'flux', 'magnitude', 'relative', got 'mag'"),
        ({"shadows": "all"}, "shadows must be 'exact', 'centroids', 'none' or False, got 'all'"),
        ({"shadows": 3}, "shadows must be a str, got int"),
        ({"shadows": True}, "shadows must be 'exact', 'centroids', 'none' or False, got True"),
        ({"secondary_law": LAW}, "secondary_law must be one law, .* the numbers of laws and shapes 1 and 1"),
        ({"shape": (EGG, EGG), "secondary_law": (LAW, LAW)}, "secondary_law must be one law, .* shapes 2 and 2"),
        ({"shape": 3.0}, "shape must be a Mesh, an Ellipsoid or Facets, got"),
        ({"shape": (EGG, EGG, EGG)}, "shape must be one shape, or two for two bodies, got 3"),
        ({"stretch": (1, 0, 1)}, "stretch must be positive"),
        ({"law": EGG}, "law must be a ScatteringLaw"),
        ({"sun": (1, 0, 0)}, "sun must be an Orbit"),
        ({"noise": -1.0}, "noise must not be negative"),
        ({"astronomical_unit": 0.0}, "astronomical_unit must be positive"),
        ({"light_time": 1.0}, "light_time must be"),
        (
            {"shape": pt.forces.Facets([[1.0], [2.0]], [(0, 0, 1)], [(0, 0, 0)])},
            "shape must be the same for all members",
        ),
    ],
)
def test_invalid_arguments(options, message):
    with pytest.raises((TypeError, ValueError), match=message):
        curve(**options)


def test_two_bodies_without_meshes_have_no_eclipses():
    with pytest.warns(
        UserWarning, match=r"^the shapes of two bodies should be meshes, got Ellipsoid and Ellipsoid\. The"
    ):
        LightCurve((EGG, BALL), LAW, SUN, EARTH)
    LightCurve((EGG.mesh(20), BALL.mesh(20)), LAW, SUN, EARTH)
    LightCurve((EGG, BALL), LAW, SUN, EARTH, shadows=False)
