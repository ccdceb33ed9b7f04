"""Gravity on bodies beyond their inertia: by harmonics, by points, of an ellipsoid; what is refused, and what is told."""

import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

TURN = Rotation.from_rotvec([0.7, -0.2, 1.1])
OMEGA = (0.1, 0.3, -0.2)
POINT = pt.FixedPoint((0.9, -1.2, 1.7), 1.3)
ELLIPSE = pt.KeplerOrbit(1.1, 3.0, 0.3, 0.7, -0.4, 1.9, 0.3)
CIRCLE = pt.KeplerOrbit(1.1, 3.0, 0.0, 0.7, -0.4, 1.9, 0.3)
SECOND = {"C20": -0.1, "C22": 0.03, "C21": 0.01, "S21": -0.02, "S22": 0.015}
BODY = pt.Body.from_stokes(**SECOND, polar_moment_factor=0.4, mass=2.0, radius=0.8)


def field(degree=2, mass=2.0, radius=0.8, extent=0.0, seed=3, **second):
    """A field of second degree as that of the body, and higher terms by chance."""
    C, S = np.tril(np.random.default_rng(seed).normal(size=(2, degree + 1, degree + 1))) * 0.05
    C[:2], S[:2] = 0, 0
    for name, value in {**SECOND, **second}.items():
        {"C": C, "S": S}[name[0]][2, int(name[2])] = value
    return pt.GravityField(degree, mass, radius, C, S, extent)


def still(body, time=0.0, turn=TURN):
    return body.state(turn, omega_body=(0, 0, 0), time=time)


def moving(body):
    return body.state(TURN, omega_body=OMEGA)


# ---------------------------------------------------------------------- the second degree


@pytest.mark.parametrize("orbit", [POINT, ELLIPSE], ids=["at rest", "ellipse"])
def test_degree_two_is_the_gravity_gradient(orbit):
    second, gradient = (
        pt.System(BODY, force(orbit)) for force in (lambda o: pt.HarmonicGravity(o, field()), pt.GravityGradient)
    )
    turns = Rotation.random(5, np.random.default_rng(2))
    size = np.linalg.norm(gradient.torque_body(still(BODY, 0.3)))
    constants = [system.potential_energy(still(BODY, 0.3, turn)) for turn in turns for system in (gradient, second)]
    differences = np.subtract(constants[::2], constants[1::2])
    assert np.ptp(differences) < 1e-14 * abs(differences[0])
    for turn in turns:
        torques = [system.torque_body(still(BODY, 0.3, turn)) for system in (second, gradient)]
        assert np.allclose(*torques, rtol=0, atol=2e-15 * size)


@pytest.mark.parametrize("orbit", [POINT, ELLIPSE, CIRCLE], ids=["at rest", "ellipse", "circle"])
def test_degree_two_is_the_gravity_gradient_in_a_kernel(orbit):
    forces = pt.HarmonicGravity(orbit, field()), pt.GravityGradient(orbit)
    runs = [pt.propagate(pt.System(BODY, force), moving(BODY), [0.0, 20.0]) for force in forces]
    assert np.allclose(runs[0].quaternion, runs[1].quaternion, rtol=0, atol=1e-12)
    assert list(runs[0].drift) == list(runs[1].drift)


def test_higher_degrees_of_nothing_change_nothing():
    C, S = np.zeros((2, 6, 6))
    C[:3, :3], S[:3, :3] = field().C, field().S
    padded = pt.HarmonicGravity(ELLIPSE, pt.GravityField(5, 2.0, 0.8, C, S))
    torques = [
        pt.System(BODY, force).torque_body(still(BODY)) for force in (padded, pt.HarmonicGravity(ELLIPSE, field()))
    ]
    assert np.array_equal(*torques)


@pytest.mark.parametrize("degree", [2, 5])
def test_a_sphere_feels_nothing(degree):
    empty = pt.GravityField(degree, 1.0, 1.0, *np.zeros((2, degree + 1, degree + 1)))
    system = pt.System(pt.Body((0.4, 0.4, 0.4)), pt.HarmonicGravity(ELLIPSE, empty))
    assert np.all(system.torque_body(still(system.body)) == 0)
    assert system.potential_energy(still(system.body)) == 0


# ---------------------------------------------------------------------- one body, three ways


def test_an_ellipsoid_has_the_field_of_its_coefficients():
    """C20, C22 and C40 of a homogeneous ellipsoid (Balmino 1994, Celest. Mech. 60, 331, eqs. (19)); far away."""
    a, b, c, R = 0.6, 0.5, 0.35, 0.6
    C, S = np.zeros((2, 5, 5))
    C[2, 0], C[2, 2] = (2 * c**2 - a**2 - b**2) / (10 * R**2), (a**2 - b**2) / (20 * R**2)
    C[4, 0] = 15 / 7 * (C[2, 0] ** 2 + 2 * C[2, 2] ** 2)
    C[4, 2] = 5 / 7 * C[2, 0] * C[2, 2]
    C[4, 4] = 5 / 28 * C[2, 2] ** 2
    body, orbit = pt.Body.ellipsoid(2.0, (a, b, c)), pt.FixedPoint((9.0, -12.0, 17.0), 1.3)
    forces = pt.EllipsoidGravity(orbit, 2.0, (a, b, c)), pt.HarmonicGravity(orbit, pt.GravityField(4, 2.0, R, C, S))
    torques = [pt.System(body, force).torque_body(still(body)) for force in (*forces, pt.GravityGradient(orbit))]
    size = np.linalg.norm(torques[0])
    assert np.linalg.norm(torques[0] - torques[1]) < 1e-7 * size  # of (R/r)^4
    assert np.linalg.norm(torques[0] - torques[2]) > 1e-5 * size  # of (R/r)^2


# ---------------------------------------------------------------------- members

MASSES, PLACES = np.array([1.0, 2.0, 1.5, 0.5]), np.random.default_rng(8).normal(size=(4, 3)) * 0.3
PLACES = PLACES - MASSES @ PLACES / MASSES.sum()


def members_of_fields():
    fields = [field(3, seed=seed) for seed in range(3)]
    together = pt.GravityField(3, 2.0, 0.8, *(np.stack([getattr(f, name) for f in fields]) for name in "CS"))
    return BODY, pt.HarmonicGravity(ELLIPSE, together), [pt.HarmonicGravity(ELLIPSE, f) for f in fields]


def members_of_points():
    turns = Rotation.from_rotvec([[0, 0, 0], [np.pi, 0, 0], [0, np.pi, 0]])
    body = pt.Body.point_masses(MASSES, PLACES)
    axes = body.principal_axes.as_matrix()
    along = pt.Body(body.moments)
    places = [turn.apply(PLACES @ axes) for turn in turns]  # half turns about principal axes keep the inertia
    together = pt.MasconGravity(ELLIPSE, MASSES, places)
    return along, together, [pt.MasconGravity(ELLIPSE, MASSES, place) for place in places]


@pytest.mark.parametrize("make", [members_of_fields, members_of_points], ids=["fields", "points"])
def test_members_with_bodies_of_their_own(make):
    body, together, alone = make()
    many = pt.propagate(pt.System(body, together), moving(body), [0.0, 10.0])
    for member, force in enumerate(alone):
        one = pt.propagate(pt.System(body, force), moving(body), [0.0, 10.0])
        assert np.allclose(many.quaternion[member], one.quaternion, rtol=0, atol=1e-13)
    assert np.max(np.abs(many.quaternion[0] - many.quaternion[1])) > 1e-4


def test_ellipsoids_as_members():
    semiaxes = np.array([(0.6, 0.5, 0.35), (0.6, 0.6, 0.3), (0.5, 0.5, 0.5)])
    bodies = [pt.Body.ellipsoid(2.0, each) for each in semiaxes]
    body = pt.Body([each.moments for each in bodies])
    start = pt.State(TURN.as_quat(scalar_first=True), np.zeros(4))
    many = pt.System(body, pt.EllipsoidGravity(ELLIPSE, 2.0, semiaxes)).torque_body(start)
    for member in range(3):
        alone = pt.System(bodies[member], pt.EllipsoidGravity(ELLIPSE, 2.0, semiaxes[member]))
        assert np.allclose(many[member], alone.torque_body(start), rtol=0, atol=1e-18)
    assert np.all(many[2] == 0)


# ---------------------------------------------------------------------- another body

OFF = PLACES + [0.01, 0, 0]
OTHER_BODIES = {
    "field of another shape": (
        lambda: pt.System(BODY, pt.HarmonicGravity(POINT, field(C20=-0.11))),
        "the field's degree 2 must agree with the inertia of the body, but the tensors differ by 0.017 of its largest "
        "moment. Take it from the field: Body.from_stokes with the coefficients of degree 2, mass and radius.",
    ),
    "points of another mass": (
        lambda: pt.System(pt.Body.point_masses(MASSES, PLACES), pt.MasconGravity(POINT, 2 * MASSES, PLACES)),
        "masses and positions must agree with the inertia of the body, but the tensors differ by 1 of its largest "
        "moment. Body.point_masses(masses, positions) has the right one.",
    ),
    "points not about their centre": (
        lambda: pt.System(pt.Body.point_masses(MASSES, OFF), pt.MasconGravity(POINT, MASSES, OFF)),
        "positions must be from the centre of mass, but it is off the origin by 0.013 of the farthest point. "
        "Subtract it.",
    ),
    "an ellipsoid along other axes": (
        lambda: pt.System(pt.Body.ellipsoid(2.0, (0.6, 0.5, 0.4)), pt.EllipsoidGravity(POINT, 2.0, (0.5, 0.6, 0.4))),
        "mass and semiaxes must agree with the inertia of the body, but the tensors differ by 0.18 of its largest "
        "moment. Body.ellipsoid(mass, semiaxes) has the right one.",
    ),
}


@pytest.mark.parametrize("case", OTHER_BODIES)
def test_a_force_on_another_body(case):
    make, sentence = OTHER_BODIES[case]
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        make()


def test_one_wrong_member_is_enough():
    C = np.stack([field().C] * 3)
    C[1, 2, 2] *= 1 + 1e-6
    with pytest.raises(ValueError, match=r"^the field's degree 2 must agree with the inertia"):
        pt.System(BODY, pt.HarmonicGravity(POINT, pt.GravityField(2, 2.0, 0.8, C, field().S)))


def test_numbers_of_members_are_compared_elsewhere():
    force = pt.EllipsoidGravity(POINT, [2.0, 2.0, 2.0], (0.5, 0.6, 0.4))
    with pytest.raises(ValueError, match=r"^body and forces must have equally many members, but 2 and 3 came\.$"):
        _ = pt.System(pt.Body(np.ones((2, 3))), force).members


@pytest.mark.parametrize("size", [1e-5, 1.0, 1e7])
def test_rounding_is_no_other_body(size):
    places, random = size * PLACES, Rotation.random(4, np.random.default_rng(1))
    for turn in random:
        turned = turn.apply(places)
        turned = turned - MASSES @ turned / MASSES.sum()
        pt.System(pt.Body.point_masses(MASSES, turned), pt.MasconGravity(POINT, MASSES, turned))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda: pt.MasconGravity(POINT, MASSES, PLACES[:3]),
            "masses must have shape (3,) or (members, 3), but shape (4,) came.",
        ),
        (
            lambda: pt.MasconGravity(POINT, MASSES, PLACES[0]),
            "positions must have shape (n, 3) or (members, n, 3), but shape (3,) came.",
        ),
        (lambda: pt.EllipsoidGravity(POINT, 2.0, (1, 0, 1)), "semiaxes must be positive, but 0.0 came."),
        (lambda: pt.EllipsoidGravity(POINT, -2.0, (1, 1, 1)), "mass must be positive, but -2.0 came."),
    ],
    ids=["count", "one point", "flat", "no mass"],
)
def test_what_is_no_body(make, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        make()


# ---------------------------------------------------------------------- where the formula does not hold


def test_a_result_tells_when_the_attractor_was_inside_the_sphere():
    times = np.linspace(0, ELLIPSE.period, 101)
    distance = np.linalg.norm([np.asarray(x) for x in ELLIPSE.position_at(times)], axis=0)
    force = pt.HarmonicGravity(ELLIPSE, field(extent=2.5))
    motion = pt.propagate(pt.System(BODY, force), moving(BODY), times)
    count = np.count_nonzero(distance < 2.5)
    assert 0 < count < 101
    assert motion.summary["inside_sphere"] == f"{count} of 101 times"
    assert motion.dataset.attrs["inside_sphere"] == f"{count} of 101 times"
    assert f"  inside_sphere: {count} of 101 times" in str(motion)
    for extent in (0.0, 1.0):
        quiet = pt.System(BODY, pt.HarmonicGravity(ELLIPSE, field(extent=extent)))
        assert "inside_sphere" not in pt.propagate(quiet, moving(BODY), times).summary


def test_members_are_counted_together():
    extents = np.array([0.0, 2.5, 10.0])
    times = np.linspace(0, ELLIPSE.period, 101)
    together = pt.propagate(pt.System(BODY, pt.HarmonicGravity(ELLIPSE, field(extent=extents))), moving(BODY), times)
    one = pt.propagate(pt.System(BODY, pt.HarmonicGravity(ELLIPSE, field(extent=2.5))), moving(BODY), times)
    count = int(one.summary["inside_sphere"].split()[0])
    assert together.summary["inside_sphere"] == f"{count + 101} of 303 times"


def test_an_attractor_inside_an_ellipsoid_is_told_before_and_after():
    semiaxes = (1.4, 1.3, 0.7)
    body = pt.Body.ellipsoid(2.0, semiaxes)
    sentence = (
        "EllipsoidGravity: the periapsis is 0.4 below the end of the longest semiaxis (distance 1, radius 1.4); inside "
        "the ellipsoid the field outside is continued inwards."
    )
    low = pt.EscapeOrbit(1.3, 1.0, 1.2, 0.0, 0.0, 0.0)
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        force = pt.EllipsoidGravity(low, 2.0, semiaxes)
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3), time=-5.0)
    motion = pt.propagate(pt.System(body, force), state, [-5.0, 5.0])
    assert "inside_ellipsoid" not in motion.summary
    motion = pt.propagate(pt.System(body, force), state, [-5.0, 0.0, 5.0])
    assert motion.summary["inside_ellipsoid"] == "1 of 3 times"


def test_an_attractor_above_the_ellipsoid_is_told_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pt.EllipsoidGravity(pt.EscapeOrbit(1.3, 1.5, 1.2, 0.0, 0.0, 0.0), 2.0, (1.4, 1.3, 0.7))
