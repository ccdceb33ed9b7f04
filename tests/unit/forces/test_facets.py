"""Facets, and what presses on them: single facets by hand, spheres, stability, and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces import Atmosphere, AtmosphericDrag, ExponentialAtmosphere, Facets, Occulter, RadiationPressure

AU = 149597870700.0
IDENTITY, AT_REST = (1, 0, 0, 0), (0, 0, 0)
BODY = pt.Body((1.3, 1.0, 0.7))
SUN = pt.orbits.FixedPosition(1.0, position=(-AU, 0, 0))  # towards +x


class Still(Atmosphere):
    """Air of one density everywhere."""

    value: float

    def density(self, instant, orbit):  # noqa: ARG002
        return self.value


class Passing(pt.Orbit):
    """A body that passes the planet at a constant velocity."""

    mu: float
    velocity: pt.SpaceVector

    def position_at(self, time):
        return pt.functions.Vector((2.0, 0.0, 0.0)) + pt.functions.Vector(self.velocity) * time

    def velocity_at(self, time):
        return pt.functions.Vector(x + 0.0 * time for x in self.velocity)


def torque(force, quaternion=IDENTITY):
    system = pt.System(BODY, force)
    return system.torque_body(system.state(quaternion, omega_body=AT_REST))


# ---------------------------------------------------------------------- one facet, by hand


def test_light_on_one_facet():
    """The light comes at 60 degrees to the normal: of the force, the parts along the light and along the normal."""
    normal, arm, s, d = np.array([0.5, 0.75**0.5, 0]), np.array([0.1, -0.2, 0.3]), 0.3, 0.2
    force = RadiationPressure(SUN, Facets([2.0], [normal], [arm], s, d), pressure=4e-6)
    absorbed = 4e-6 * 2.0 * 0.5 * np.array([-1.0, 0, 0])
    by_mirror, diffusely = -2 * 0.5 * s * normal, -2 / 3 * d * normal
    expected = (1 - s) * absorbed + 4e-6 * 2.0 * 0.5 * (by_mirror + diffusely)
    assert np.max(np.abs(torque(force) - np.cross(arm, expected))) < 2e-21  # ten roundings of 1e-6
    assert not np.any(torque(force, (0, 0, 0, 1)))  # from behind


def test_pressure_falls_with_the_square_of_the_distance():
    plate = Facets([2.0], [(1, 0, 0)], [(0, 0.1, 0)])
    far = pt.orbits.FixedPosition(1.0, position=(-5.2 * AU, 0, 0))
    near, far = (torque(RadiationPressure(sun, plate))[2] for sun in (SUN, far))
    assert abs(near / (0.2 * 1361.0 / 299792458.0) - 1) < 1e-14
    assert abs(near / far / 5.2**2 - 1) < 1e-14


def test_a_mirror_at_normal_incidence_feels_twice_the_pressure_and_a_diffuse_plate_five_thirds():
    plates = [Facets([1.0], [(1, 0, 0)], [(0, 1, 0)], s, d) for s, d in ((0, 0), (1, 0), (0, 1))]
    black, mirror, diffuse = (torque(RadiationPressure(SUN, plate))[2] for plate in plates)
    assert abs(mirror / black - 2) < 1e-15
    assert abs(diffuse / black - 5 / 3) < 1e-15


def test_air_on_one_facet():
    """Molecules that leave diffusely push along the wind; those that leave as from a mirror along the normal."""
    velocity, normal, arm = np.array([3.0, 4.0, 0]), np.array([0, 0.6, 0.8]), np.array([0.1, -0.2, 0.3])
    orbit = Passing(1.0, velocity)
    for accommodation in (1.0, 0.25):
        facets = Facets([2.0], [normal], [arm], drag=2.1, accommodation=accommodation)
        along = normal @ velocity
        flow = -0.5 * 0.3 * 2.1 * 2.0 * along
        expected = flow * (accommodation * velocity + (1 - accommodation) * 2 * along * normal)
        found = torque(AtmosphericDrag(orbit, Still(0.3), facets))
        assert np.max(np.abs(found - np.cross(arm, expected))) < 1e-14
    behind = Facets([2.0], [-normal], [arm])
    assert not np.any(torque(AtmosphericDrag(orbit, Still(0.3), behind)))


def test_air_turns_with_the_planet():
    """At (2, 0, 0) air that turns about the third axis moves along the second one: it takes the wind away."""
    orbit, facets = Passing(1.0, (0, 3.0, 0)), Facets([1.0], [(0, 1, 0)], [(0.1, 0, 0)])
    still, turning, with_it = (
        torque(AtmosphericDrag(orbit, Still(1.0, omega_space=(0, 0, rate)), facets))[2] for rate in (0.0, 0.5, 1.5)
    )
    assert abs(turning / still - (2 / 3) ** 2) < 1e-15
    assert with_it == 0.0


def test_density_falls_by_e_with_each_scale_height():
    facets = Facets([1.0], [(0, 1, 0)], [(0.1, 0, 0)])
    air = ExponentialAtmosphere(0.7, 1.4, 0.6)
    here = torque(AtmosphericDrag(Passing(1.0, (0, 3.0, 0)), air, facets))
    assert np.allclose(
        here, np.exp(-1) * torque(AtmosphericDrag(Passing(1.0, (0, 3.0, 0)), Still(0.7), facets)), rtol=1e-14, atol=0
    )


# ---------------------------------------------------------------------- bodies


def ball():
    """An octahedron, each face cut in 64: nearly a sphere, and symmetric about its centre."""
    vertices = [np.array(v, dtype=float) for v in [(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)]]
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    triangles = [[vertices[i] for i in face] for face in faces]
    for _ in range(2):
        triangles = [
            piece
            for a, b, c in triangles
            for ab, bc, ca in [[(x + y) / np.linalg.norm(x + y) for x, y in ((a, b), (b, c), (c, a))]]
            for piece in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        ]
    corners, places = np.unique(np.round(np.reshape(triangles, (-1, 3)), 12), axis=0, return_inverse=True)
    return pt.shapes.Mesh(corners, places.reshape(-1, 3), density=1.0)


def test_normals_areas_and_centres_of_a_mesh():
    mesh = ball().moved((0.3, -0.2, 0.1), Rotation.from_rotvec((0.2, 0.5, -0.3)))
    assert mesh.face_normals.shape == mesh.face_centers.shape == (128, 3)
    weighted = mesh.face_areas[:, None] * mesh.face_normals
    assert np.max(np.abs(weighted.sum(axis=0))) < 1e-14  # closed
    volume = np.sum(weighted * mesh.face_centers) / 3  # Gauss
    assert abs(volume / mesh.volume - 1) < 1e-13
    box = pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0)
    assert np.allclose(
        np.bincount(np.argmax(abs(box.face_normals), axis=1), box.face_areas), (12, 6, 4), rtol=1e-15, atol=0
    )


@pytest.mark.parametrize("turn", Rotation.random(3, np.random.default_rng(4)).as_quat(scalar_first=True))
def test_a_sphere_feels_no_torque(turn):
    facets = Facets.from_mesh(ball(), specular=0.3, diffuse=0.4, accommodation=0.6)
    drag = AtmosphericDrag(Passing(1.0, (3.0, 4.0, 0)), Still(0.3), facets)
    for force, size in ((RadiationPressure(SUN, facets, pressure=1.0), 1.0), (drag, 0.3 * 12.5 * 2.2)):
        assert np.max(np.abs(torque(force, turn))) < 2e-3 * size * np.pi  # what faces leave of a sphere
    symmetric = torque(RadiationPressure(SUN, Facets.from_mesh(ball()), pressure=1.0), turn)
    off = torque(RadiationPressure(SUN, moved(Facets.from_mesh(ball()), (0.5, 0, 0)), pressure=1.0), turn)
    assert np.linalg.norm(off) > 50 * np.linalg.norm(symmetric)


def moved(facets, shift):
    return Facets(facets.areas, facets.normals, facets.positions + shift)


def test_a_box_with_wings_is_its_facets():
    box = Facets.from_box(
        (1, 2, 3), (0.1, 0, 0), wing_areas=[4.0], wing_normals=[(0, 0, 1)], wing_positions=[(0, 5, 0)], specular=0.1
    )
    assert box.count == 8
    assert list(box.areas) == [6, 6, 3, 3, 2, 2, 4, 4]
    assert np.array_equal(box.positions[0], (0.6, 0, 0))
    assert np.array_equal(box.normals[6], -box.normals[7])
    assert box.closed
    apart = Facets.from_box((1, 2, 3), (0.1, 0, 0), specular=0.1)
    panel = Facets([4.0, 4.0], [(0, 0, 1), (0, 0, -1)], [(0, 5, 0)] * 2, specular=0.1, closed=True)
    same = apart.joined(panel)
    assert all(np.array_equal(getattr(box, name), getattr(same, name)) for name in ("areas", "normals", "positions"))
    assert same.structure == box.structure


def test_a_body_with_its_centre_of_pressure_behind_swings_like_a_pendulum():
    """w^2 = rho v^2 Cd A L/(2 I): drag on a plate across the wind, on an arm behind the centre of mass."""
    rho, speed, drag, area, arm = 1e-3, 5.0, 2.2, 0.5, 2.0
    facets = Facets([area], [(1, 0, 0)], [(-arm, 0, 0)], drag=drag)
    orbit = Passing(1.0, (speed, 0, 0))
    system = pt.System(pt.Body((1.0, 1.6, 1.6)), AtmosphericDrag(orbit, Still(rho), facets))
    small = 1e-4
    start = system.state(Rotation.from_rotvec((0, 0, small)), omega_body=AT_REST)
    # cos of the angle between normal and wind, and the arm across it: both second order in the angle.
    rate = np.sqrt(rho * speed**2 * drag * area * arm / (2 * 1.6))
    motion = pt.propagate(system, start, np.linspace(0, 2 * np.pi / rate, 9))
    angle = 2 * motion.quaternion[:, 3]
    assert np.max(np.abs(angle - small * np.cos(rate * motion.times))) < 1e-11  # small^3, over the period


def test_members_have_coefficients_of_their_own():
    areas, normals, places = [1.0, 2.0], [(1, 0, 0), (0, 0.6, 0.8)], [(0, 0.3, 0), (0.2, 0, 0.1)]
    specular = np.array([[0.1, 0.2], [0.3, 0.5], [0.8, 0.0]])
    start = np.array([0.3, -0.4, 0.2])
    every = pt.System(BODY, RadiationPressure(SUN, Facets(areas, normals, places, specular), pressure=0.1))
    motion = pt.propagate(every, every.state(IDENTITY, omega_body=start), np.linspace(0, 20, 5))
    for i, row in enumerate(specular):
        one = pt.System(BODY, RadiationPressure(SUN, Facets(areas, normals, places, row), pressure=0.1))
        alone = pt.propagate(one, one.state(IDENTITY, omega_body=start), np.linspace(0, 20, 5))
        assert np.max(np.abs(motion.quaternion[i] - alone.quaternion)) < 1e-12


def test_two_occulters_multiply_and_what_is_behind_the_body_shades_nothing():
    plate = Facets([1.0], [(1, 0, 0)], [(0, 1, 0)])

    def seen(*places):
        spheres = [Occulter(pt.orbits.FixedPosition(1.0, position=place), 1e6) for place in places]
        force = RadiationPressure(SUN, plate, spheres)
        system = pt.System(BODY, force)
        return float(force.sunlight(system.at(system.state(IDENTITY, omega_body=AT_REST))))

    one, other = (-3e8, 0, 0), (-4e8, 1.5e6, 0)
    assert 0.4 < seen(one) < 0.6
    assert 0.4 < seen(other) < 1
    assert abs(seen(one, other) - seen(one) * seen(other)) < 1e-15
    assert seen((3e8, 0, 0)) == 1.0
    assert seen((-1.5e6, 0, 0)) == 0.0


# ---------------------------------------------------------------------- what is refused

GOOD = {"areas": [1.0, 2.0], "normals": [(1, 0, 0), (0, 1, 0)], "positions": [(0, 0, 0)] * 2}


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"areas": [1.0, -2.0]}, r"areas must not be negative, got -2\.0\."),
        ({"areas": 1.0}, r"areas must have shape \(n,\) or \(members, n\), got shape \(\)\."),
        ({"areas": []}, r"areas must have shape \(0,\) or \(members, 0\), got shape \(0,\)\."),
        ({"normals": [(1, 0, 0), (0, 1, 1)]}, r"normals must be a unit vector, got length 1\.414213562\. Divide"),
        ({"normals": [(1, 0, 0)]}, r"normals must have shape \(2, 3\) or \(members, 2, 3\) along the body axes"),
        ({"specular": 1.2}, r"specular must be at most 1, got 1\.2\. It is a share of what arrives\."),
        ({"diffuse": [0.1, -0.1]}, r"diffuse must not be negative, got -0\.1\."),
        ({"accommodation": 2}, r"accommodation must be at most 1, got 2\."),
        ({"drag": -1}, r"drag must not be negative, got -1\."),
        (
            {"specular": [0.1, 0.7], "diffuse": 0.6},
            r"specular and diffuse must add up to at most 1, got 0\.7 \+ 0\.6 of facet 1\. The rest is absorbed\.",
        ),
        ({"closed": True}, r"normals must close: .* got a vector of length 2\.24\. Is a facet inside out"),
    ],
)
def test_bad_facets_are_reported(wrong, sentence):
    with pytest.raises(ValueError, match=sentence):
        Facets(**{**GOOD, **wrong})


def test_a_facet_inside_out_and_a_whole_surface_inside_out_are_reported():
    box = Facets.from_box((1, 2, 3))
    one = box.normals * np.where(np.arange(6) == 2, -1, 1)[:, None]
    two = box.normals * np.where(np.arange(6) < 2, -1, 1)[:, None]  # opposite ones, whose sum stays zero
    for normals, sentence in (
        (one, r"normals must close: .* of length 6\. Is a facet inside out"),
        (two, r"normals and positions must form a closed surface, .* by 8\. Are two facets"),
        (-box.normals, r"normals must point outwards, .* volume -6\. All are inside out"),
    ):
        for given in (normals, np.array([box.normals, normals])):  # of one, and of one member of two
            with pytest.raises(ValueError, match=sentence):
                Facets(box.areas, given, box.positions, closed=True)
    assert Facets(box.areas, np.array([box.normals] * 2), box.positions, closed=True).closed


def test_a_sun_in_other_units_is_reported():
    plate = Facets([1.0], [(1, 0, 0)], [(0, 1, 0)])
    kilometres = pt.orbits.FixedPosition(1.0, position=(-1.496e8, 0, 0))
    with pytest.raises(ValueError, match=r"sun_radius must be less than the distance of the Sun, got 6.957e\+08 and"):
        RadiationPressure(kilometres, plate)
    with pytest.warns(UserWarning, match="inside the sphere nothing is seen"):
        Occulter(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1), 0.95)
