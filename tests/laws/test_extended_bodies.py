"""Gravity on bodies beyond their inertia: by harmonics, by points, of an ellipsoid; errors and warnings."""

import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

TURN = Rotation.from_rotvec([0.7, -0.2, 1.1])
OMEGA = (0.1, 0.3, -0.2)
POINT = pt.orbits.FixedPosition(1.3, position=(0.9, -1.2, 1.7))
ELLIPSE = pt.KeplerOrbit(
    1.1, semimajor_axis=3.0, eccentricity=0.3, inclination=0.7, node=-0.4, argument_of_periapsis=1.9, true_anomaly=0.3
)
CIRCLE = pt.KeplerOrbit(
    1.1, semimajor_axis=3.0, eccentricity=0.0, inclination=0.7, node=-0.4, argument_of_periapsis=1.9, true_anomaly=0.3
)
SECOND = {"C20": -0.1, "C22": 0.03, "C21": 0.01, "S21": -0.02, "S22": 0.015}
BODY = pt.Body.from_stokes(**SECOND, polar_moment_factor=0.4, mass=2.0, radius=0.8)


def field(degree=2, mass=2.0, radius=0.8, extent=0.0, seed=3, **second):
    """A field of second degree as that of the body, and higher terms by chance."""
    C, S = np.tril(np.random.default_rng(seed).normal(size=(2, degree + 1, degree + 1))) * 0.05
    C[:2], S[:2], S[:, 0] = 0, 0, 0
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
        pt.System(BODY, force(orbit)) for force in (lambda o: pt.forces.HarmonicGravity(o, field()), pt.GravityGradient)
    )
    turns = Rotation.random(5, np.random.default_rng(2))
    scale = 3 * orbit.mu / np.linalg.norm(orbit.position_at(0.3)) ** 3 * np.max(BODY.moments)
    constants = [system.potential_energy(still(BODY, 0.3, turn)) for turn in turns for system in (gradient, second)]
    differences = np.subtract(constants[::2], constants[1::2])
    assert np.ptp(differences) < 1e-14 * abs(differences[0])
    for turn in turns:
        torques = [system.torque_body(still(BODY, 0.3, turn)) for system in (second, gradient)]
        # Some twenty operations on terms of this size lead to each component; the moments come from the coefficients.
        assert np.allclose(*torques, rtol=0, atol=16 * np.finfo(float).eps * scale)


@pytest.mark.parametrize("orbit", [POINT, ELLIPSE, CIRCLE], ids=["at rest", "ellipse", "circle"])
def test_degree_two_is_the_gravity_gradient_in_a_kernel(orbit):
    forces = pt.forces.HarmonicGravity(orbit, field()), pt.GravityGradient(orbit)
    runs = [pt.propagate(pt.System(BODY, force), moving(BODY), [0.0, 20.0]) for force in forces]
    assert np.allclose(runs[0].quaternion, runs[1].quaternion, rtol=0, atol=1e-14)
    assert list(runs[0].drift) == list(runs[1].drift)


def test_higher_degrees_of_nothing_change_nothing():
    C, S = np.zeros((2, 6, 6))
    C[:3, :3], S[:3, :3] = field().C, field().S
    padded = pt.forces.HarmonicGravity(ELLIPSE, pt.GravityField(5, 2.0, 0.8, C, S))
    torques = [
        pt.System(BODY, force).torque_body(still(BODY))
        for force in (padded, pt.forces.HarmonicGravity(ELLIPSE, field()))
    ]
    assert np.array_equal(*torques)


@pytest.mark.parametrize("degree", [2, 5])
def test_a_sphere_feels_nothing(degree):
    empty = pt.GravityField(degree, 1.0, 1.0, *np.zeros((2, degree + 1, degree + 1)))
    system = pt.System(pt.Body((0.4, 0.4, 0.4)), pt.forces.HarmonicGravity(ELLIPSE, empty))
    assert np.all(system.torque_body(still(system.body)) == 0)
    assert system.potential_energy(still(system.body)) == 0


# ---------------------------------------------------------------------- one body, three ways


def test_an_ellipsoid_has_the_field_of_its_coefficients():
    """To degree 4, of a homogeneous one: what is left falls with (R/r)^4 against the second degree."""
    a, b, c, R = 0.6, 0.5, 0.35, 0.6
    C, S = np.zeros((2, 5, 5))
    C[2, 0], C[2, 2] = (2 * c**2 - a**2 - b**2) / (10 * R**2), (a**2 - b**2) / (20 * R**2)
    C[4, 0] = 15 / 7 * (C[2, 0] ** 2 + 2 * C[2, 2] ** 2)
    C[4, 2] = 5 / 7 * C[2, 0] * C[2, 2]
    C[4, 4] = 5 / 28 * C[2, 2] ** 2
    body, field_of_it = pt.Body.from_ellipsoid(2.0, (a, b, c)), pt.GravityField(4, 2.0, R, C, S)

    def rest(distance):
        orbit = pt.orbits.FixedPosition(1.3, position=distance * np.array([0.36, -0.48, 0.8]))
        forces = pt.forces.EllipsoidGravity(orbit, 2.0, (a, b, c)), pt.forces.HarmonicGravity(orbit, field_of_it)
        whole, series = (pt.System(body, force).torque_body(still(body)) for force in forces)
        return np.linalg.norm(whole - series) / np.linalg.norm(whole)

    assert rest(10.0) < 1e-5
    assert rest(10.0) / rest(20.0) == pytest.approx(16, rel=0.05)


def test_small_oscillations_are_those_of_the_series():
    """They are second derivatives of the energy."""
    semiaxes, orbit = (
        (1.0, 0.7, 0.5),
        pt.KeplerOrbit(1.0, semimajor_axis=3.0, eccentricity=0.0, inclination=0.4, node=1.1),
    )
    body, field_of_it = pt.Body.from_ellipsoid(2.0, semiaxes), pt.shapes.Ellipsoid(semiaxes, mass=2.0).field(20)
    forces = (
        pt.forces.EllipsoidGravity(orbit, 2.0, semiaxes),
        pt.forces.HarmonicGravity(orbit, field_of_it),
        pt.GravityGradient(orbit),
    )
    whole, series, gradient = (
        pt.analysis.equilibria(pt.System(body, force), orbit.frame, guesses=(1, 0, 0, 0))[0].frequencies
        for force in forces
    )
    assert np.allclose(whole, series, rtol=1e-10, atol=0)
    assert np.max(np.abs(gradient / whole - 1)) > 0.03


# ---------------------------------------------------------------------- members

MASSES, PLACES = np.array([1.0, 2.0, 1.5, 0.5]), np.random.default_rng(8).normal(size=(4, 3)) * 0.3
PLACES = PLACES - MASSES @ PLACES / MASSES.sum()


def test_members_with_fields_of_their_own():
    fields = [field(3, seed=seed) for seed in range(3)]
    together = pt.GravityField(3, 2.0, 0.8, *(np.stack([getattr(f, name) for f in fields]) for name in "CS"))
    many = pt.propagate(pt.System(BODY, pt.forces.HarmonicGravity(ELLIPSE, together)), moving(BODY), [0.0, 10.0])
    for member, one in enumerate(fields):
        alone = pt.propagate(pt.System(BODY, pt.forces.HarmonicGravity(ELLIPSE, one)), moving(BODY), [0.0, 10.0])
        assert np.allclose(many.quaternion[member], alone.quaternion, rtol=0, atol=1e-13)
    assert np.max(np.abs(many.quaternion[0] - many.quaternion[1])) > 1e-4


def members_of_points():
    """Half turns about principal axes keep the inertia."""
    body = pt.Body.from_point_masses(MASSES, PLACES)
    turns = Rotation.from_rotvec([[0, 0, 0], [np.pi, 0, 0], [0, np.pi, 0]])
    places = [turn.apply(PLACES @ body.principal_axes.as_matrix()) for turn in turns]
    alone = [(pt.Body(body.moments), pt.forces.MasconGravity(ELLIPSE, MASSES, place)) for place in places]
    return pt.Body(body.moments), pt.forces.MasconGravity(ELLIPSE, [MASSES] * 3, places), alone


def members_of_ellipsoids():
    semiaxes = np.array([(0.6, 0.5, 0.35), (0.6, 0.6, 0.3), (0.5, 0.4, 0.5)])
    alone = [(pt.Body.from_ellipsoid(2.0, each), pt.forces.EllipsoidGravity(ELLIPSE, 2.0, each)) for each in semiaxes]
    body = pt.Body([each.moments for each, _ in alone])
    return body, pt.forces.EllipsoidGravity(ELLIPSE, 2.0, semiaxes), alone


@pytest.mark.parametrize("make", [members_of_points, members_of_ellipsoids], ids=["points", "ellipsoids"])
def test_members_with_bodies_of_their_own(make):
    body, together, alone = make()
    q = np.broadcast_to(TURN.as_quat(scalar_first=True), (3, 4))
    torques = pt.System(body, together).torque_body(pt.State(q, np.zeros((3, 4))))
    for torque, one in zip(torques, alone, strict=True):
        expected = pt.System(*one).torque_body(still(one[0]))
        assert np.allclose(torque, expected, rtol=0, atol=1e-14 * np.linalg.norm(expected))
    assert np.linalg.norm(torques[0] - torques[1]) > 1e-3 * np.linalg.norm(torques[0])


# ---------------------------------------------------------------------- another body

OFF = PLACES + np.array([0.01, 0, 0])
OTHER_BODIES = {
    "field of another shape": (
        lambda: pt.System(BODY, pt.forces.HarmonicGravity(POINT, field(C20=-0.11))),
        "the field's degree 2 must agree with the inertia of the body, but the tensors differ by 0.016 of its largest "
        "moment. Take body and field from one shape along the same axes, or the body by Body.from_stokes from the "
        "field.",
    ),
    "points of another mass": (
        lambda: pt.System(
            pt.Body.from_point_masses(MASSES, PLACES), pt.forces.MasconGravity(POINT, 2 * MASSES, PLACES)
        ),
        "masses and positions must agree with the inertia of the body, but the tensors differ by 0.89 of its largest "
        "moment. Body.from_point_masses(masses, positions) has the right one.",
    ),
    "points not about their centre": (
        lambda: pt.System(pt.Body.from_point_masses(MASSES, OFF), pt.forces.MasconGravity(POINT, MASSES, OFF)),
        "positions must be from the centre of mass, but it is off the origin by 0.013 of the farthest point. "
        "Subtract it.",
    ),
    "an ellipsoid along other axes": (
        lambda: pt.System(
            pt.Body.from_ellipsoid(2.0, (0.6, 0.5, 0.4)), pt.forces.EllipsoidGravity(POINT, 2.0, (0.5, 0.6, 0.4))
        ),
        "mass and semiaxes must agree with the inertia of the body, but the tensors differ by 0.18 of its largest "
        "moment. Body.from_ellipsoid(mass, semiaxes) has the right one.",
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
        pt.System(BODY, pt.forces.HarmonicGravity(POINT, pt.GravityField(2, 2.0, 0.8, C, np.stack([field().S] * 3))))


def test_numbers_of_members_are_compared_elsewhere():
    force = pt.forces.EllipsoidGravity(POINT, [2.0, 2.0, 2.0], (0.5, 0.6, 0.4))
    with pytest.raises(ValueError, match=r"^body and forces must have equally many members, got 2 and 3\.$"):
        _ = pt.System(pt.Body(np.ones((2, 3))), force).members


@pytest.mark.parametrize("size", [1e-5, 1.0, 1e7])
def test_rounding_is_no_other_body(size):
    places, random = size * PLACES, Rotation.random(4, np.random.default_rng(1))
    for turn in random:
        turned = turn.apply(places)
        turned = turned - MASSES @ turned / MASSES.sum()
        pt.System(pt.Body.from_point_masses(MASSES, turned), pt.forces.MasconGravity(POINT, MASSES, turned))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda: pt.forces.MasconGravity(POINT, MASSES, PLACES[:3]),
            "masses must have shape (3,) or (members, 3), got shape (4,).",
        ),
        (
            lambda: pt.forces.MasconGravity(POINT, MASSES, PLACES[0]),
            "positions must have shape (n, 3) or (members, n, 3), got shape (3,).",
        ),
        (lambda: pt.forces.EllipsoidGravity(POINT, 2.0, (1, 0, 1)), "semiaxes must be positive, got 0.0."),
        (lambda: pt.forces.EllipsoidGravity(POINT, -2.0, (1, 1, 1)), "mass must be positive, got -2.0."),
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
    with pytest.warns(UserWarning, match="is 0.4 below the sphere that holds the body .* the series does not converge"):
        force = pt.forces.HarmonicGravity(ELLIPSE, field(extent=2.5))
    motion = pt.propagate(pt.System(BODY, force), moving(BODY), times)
    count = np.count_nonzero(distance < 2.5)
    assert 0 < count < 101
    assert motion.summary["inside_sphere"] == f"{count} of 101 times"
    assert motion.dataset.attrs["inside_sphere"] == f"{count} of 101 times"
    assert f"  inside_sphere: {count} of 101 times" in str(motion)
    for extent in (0.0, 1.0):
        quiet = pt.System(BODY, pt.forces.HarmonicGravity(ELLIPSE, field(extent=extent)))
        assert "inside_sphere" not in pt.propagate(quiet, moving(BODY), times).summary


def test_one_of_several_attractors_is_enough():
    times = np.linspace(0, ELLIPSE.period, 11)
    states = pt.State(np.tile([1.0, 0, 0, 0], (11, 1)), np.zeros((11, 4)), times)
    far = pt.forces.HarmonicGravity(pt.orbits.FixedPosition(1.0, position=(9.0, 0, 0)), field(extent=2.5))
    with pytest.warns(UserWarning, match="the series does not converge"):
        here = pt.forces.HarmonicGravity(ELLIPSE, field(extent=2.5))
    alone = pt.System(BODY, here).validity(states)["inside_sphere"]
    assert 0 < np.count_nonzero(alone) < 11
    for forces in ((here, far), (far, here)):
        assert np.array_equal(pt.System(BODY, *forces).validity(states)["inside_sphere"], alone)
    assert pt.System(BODY, pt.GravityGradient(ELLIPSE)).validity(states) == {}


def test_members_are_counted_together():
    """On the same kernel as the members above."""
    with pytest.warns(UserWarning, match="the periapsis of 2 of 3 members is below the sphere"):
        force = pt.forces.HarmonicGravity(ELLIPSE, field(3, extent=np.array([0.0, 2.5, 10.0])))
    times = np.linspace(0, ELLIPSE.period, 11)
    count = np.count_nonzero(np.linalg.norm([np.asarray(x) for x in ELLIPSE.position_at(times)], axis=0) < 2.5)
    motion = pt.propagate(pt.System(BODY, force), moving(BODY), times)
    assert 0 < count < 11
    assert motion.summary["inside_sphere"] == f"{count + 11} of 33 times"


def test_an_attractor_inside_an_ellipsoid_is_reported_before_and_after():
    semiaxes = (1.4, 1.3, 0.7)
    body = pt.Body.from_ellipsoid(2.0, semiaxes)
    sentence = (
        "EllipsoidGravity: the periapsis is 0.4 below the end of the longest semiaxis (distance 1, radius 1.4); inside "
        "the ellipsoid the field outside is continued inwards."
    )
    low = pt.orbits.EscapeOrbit(1.3, periapsis_distance=1.0, eccentricity=1.2)
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        force = pt.forces.EllipsoidGravity(low, 2.0, semiaxes)
    times = np.array([-5.0, 0.0, 5.0])
    states = pt.State(np.tile([1.0, 0, 0, 0], (3, 1)), np.zeros((3, 4)), times)
    assert list(pt.System(body, force).validity(states)["inside_ellipsoid"]) == [False, True, False]


def test_an_attractor_above_the_ellipsoid_raises_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pt.forces.EllipsoidGravity(
            pt.orbits.EscapeOrbit(1.3, periapsis_distance=1.5, eccentricity=1.2), 2.0, (1.4, 1.3, 0.7)
        )
