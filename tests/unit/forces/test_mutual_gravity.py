"""The gravity of two bodies: its symmetries, its check of bodies, what it says where it need not hold."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces import MutualGravity, MutualHarmonics, MutualMascons

POINTS = pt.shapes.Mascons([1.0, 2.0, 1.5, 0.5], [(1, 0.1, 0), (-0.7, 0.3, 0.1), (0.1, -0.4, 0.3), (0.3, 0.3, -0.8)])
OTHERS = pt.shapes.Mascons([0.3, 0.2, 0.4, 0.1], [(0.5, 0, 0.2), (-0.3, 0.4, 0), (0, -0.3, -0.1), (-0.2, 0.1, 0.5)])
SEPARATION = np.array([1.9, -1.2, 1.4])
ATTITUDES = list(Rotation.random(2, np.random.default_rng(4)))
FORCES = {
    "second degree": lambda _: MutualGravity(),
    "degree 5": lambda pair: MutualHarmonics.of_shapes(pair, 5),
    "degree 8": lambda pair: MutualHarmonics.of_shapes(pair, 8),
    "points": MutualMascons.of_shapes,
}
each_force = pytest.mark.parametrize("make", FORCES.values(), ids=FORCES)


def pair_of(first=POINTS, second=OTHERS, G=1.3):
    return pt.TwoBodies(pt.Body.from_shape(first), pt.Body.from_shape(second), G=G)


def gravity(pair, force, separation=SEPARATION, attitudes=ATTITUDES):
    """Potential energy, force on the secondary and both torques, these in space."""
    system: Any = pt.System(pair, force)
    state = pair.state(separation, np.zeros(3), attitudes, omega_body=np.zeros((2, 3)))
    load = system.dynamics.load_at(system.at(state))
    pull, *torques = (np.array(list(v), dtype=float) for v in (load.force, *load.torques))
    return system.potential_energy(state), pull, *(a.apply(t) for a, t in zip(attitudes, torques, strict=True))


def near(found, expected, tolerance=1e-13):
    return all(
        np.linalg.norm(np.subtract(a, b)) < tolerance * np.linalg.norm(b) for a, b in zip(found, expected, strict=True)
    )


@each_force
def test_exchange_of_the_bodies_changes_nothing(make):
    energy, force, first, second = gravity(pair := pair_of(), make(pair))
    turned = gravity(pair := pair_of(OTHERS, POINTS), make(pair), -SEPARATION, ATTITUDES[::-1])
    assert near(turned, (energy, -force, second, first))


@each_force
def test_torques_and_the_force_at_its_lever_cancel(make):
    _, force, first, second = gravity(pair := pair_of(), make(pair))
    lever = np.cross(SEPARATION, force)
    assert np.linalg.norm(lever + first + second) < 1e-14 * np.linalg.norm(lever)
    assert min(np.linalg.norm(first), np.linalg.norm(second)) > 1e-3


@each_force
def test_the_same_in_any_axes_of_space(make):
    turn = Rotation.from_rotvec([0.3, 1.2, -0.4])
    here = gravity(pair := pair_of(), make(pair))
    there = gravity(pair, make(pair), turn.apply(SEPARATION), [turn * a for a in ATTITUDES])
    assert near(there, (here[0], *map(turn.apply, here[1:])))


@each_force
def test_the_same_along_any_axes_of_a_body(make):
    own = Rotation.from_rotvec([-0.7, 0.2, 0.9])
    here = gravity(pair := pair_of(), make(pair))
    shape = POINTS.moved(attitude=own)
    there = gravity(pair := pair_of(shape), make(pair), attitudes=[ATTITUDES[0] * own.inv(), ATTITUDES[1]])
    assert near(there, here)


@each_force
def test_the_same_in_other_units(make):
    length, mass, time = 1.7e3, 3.1e11, 4.3e4

    def scaled(shape):
        return pt.shapes.Mascons(mass * shape.masses, length * shape.positions)

    here = gravity(pair := pair_of(), make(pair))
    pair = pair_of(scaled(POINTS), scaled(OTHERS), G=1.3 * length**3 / (mass * time**2))
    there = gravity(pair, make(pair), length * SEPARATION)
    energy = mass * length**2 / time**2
    assert near((there[0] / energy, there[1] / (energy / length), there[2] / energy, there[3] / energy), here)


def test_the_energy_of_a_state_is_that_of_the_motion_and_of_gravity():
    pair = pair_of()
    system = pt.System(pair, MutualHarmonics.of_shapes(pair, 4))
    velocity, rates = (0.1, 0.3, -0.2), np.array([(0.1, 0.2, 0.3), (-0.2, 0.4, 0.1)])
    state = pair.state(SEPARATION, velocity, ATTITUDES, omega_body=rates)
    turning = sum(w @ body.inertia @ w for w, body in zip(rates, pair.bodies.values(), strict=True)) / 2
    moving = pair.reduced_mass * np.dot(velocity, velocity) / 2
    assert system.energy(state) == pytest.approx(moving + turning + system.potential_energy(state), rel=1e-14, abs=0)


def test_fields_of_second_degree_are_the_moments():
    pair = pair_of()
    assert near(gravity(pair, MutualHarmonics.of_shapes(pair, 2)), gravity(pair, MutualGravity()))


def test_the_length_to_which_coefficients_refer_does_not_matter():
    pair = pair_of()
    fields = POINTS.field(5, radius=0.3), OTHERS.field(5, radius=2.2)
    assert near(gravity(pair, MutualHarmonics(*fields, 5)), gravity(pair, MutualHarmonics.of_shapes(pair, 5)))


def test_higher_rows_of_a_field_do_not_count():
    pair = pair_of()
    assert near(
        gravity(pair, MutualHarmonics(POINTS.field(7), OTHERS.field(5), 4)),
        gravity(pair, MutualHarmonics.of_shapes(pair, 4)),
    )


def test_an_ensemble_over_a_coefficient():
    """Of the third degree, which moments do not know."""
    pair, first, second = pair_of(), POINTS.field(4), OTHERS.field(4)
    C = np.repeat(first.C[None], 3, axis=0)
    C[:, 3, 1] += [-0.2, 0.0, 0.3]
    field = pt.GravityField(4, first.mass, first.radius, C, first.S)
    states = pair.state(np.tile(SEPARATION, (3, 1)), np.zeros(3), ATTITUDES, omega_body=np.zeros((2, 3)))
    system = pt.System(pair, MutualHarmonics(field, second, 4))
    found = system.potential_energy(states)
    for energy, row in zip(found, C, strict=True):
        alone = MutualHarmonics(pt.GravityField(4, first.mass, first.radius, row, first.S), second, 4)
        assert energy == pytest.approx(gravity(pair, alone)[0], rel=1e-14, abs=0)
    assert np.ptp(found) > 1e-3
    assert system.dynamics.structure == pt.System(pair, MutualHarmonics(first, second, 4)).dynamics.structure


# ---------------------------------------------------------------------- where it need not hold


def test_near_bodies_are_counted():
    pair = pair_of()
    reach = POINTS.circumscribing_radius + OTHERS.circumscribing_radius
    direction = SEPARATION / np.linalg.norm(SEPARATION)
    states = pair.state(
        np.array([0.99, 1.01, 30])[:, None] * reach * direction, np.zeros(3), ATTITUDES, omega_body=np.zeros((2, 3))
    )
    validity = pt.System(pair, MutualHarmonics.of_shapes(pair, 4)).validity(states)
    assert list(validity["overlapping_spheres"]) == [True, False, False]
    assert list(validity["coarse_series"]) == [True, True, False]
    assert pt.System(pair, MutualMascons.of_shapes(pair)).validity(states) == {}


def test_moments_reach_as_far_as_the_homogeneous_ellipsoids_that_have_them():
    bodies = [
        pt.Body([mass / 5 * (b * b + c * c), mass / 5 * (a * a + c * c), mass / 5 * (a * a + b * b)], mass=mass)
        for mass, (a, b, c) in ((2.0, (3.0, 2.0, 1.0)), (0.5, (0.5, 1.5, 1.0)))
    ]
    pair = pt.TwoBodies(*bodies, G=1.3)
    places = np.array([0.99, 1.01])[:, None] * (3.0 + 1.5) * np.eye(3)[0]
    states = pair.state(places, np.zeros(3), ATTITUDES, omega_body=np.zeros((2, 3)))
    validity = pt.System(pair, MutualGravity()).validity(states)
    assert list(validity["overlapping_spheres"]) == [True, False]


def test_a_summary_tells_the_estimated_error():
    pair = pair_of()
    series = MutualHarmonics.of_shapes(pair, 4)
    system = pt.System(pair, series)
    reach = POINTS.circumscribing_radius + OTHERS.circumscribing_radius
    start = pair.state((1.5 * reach, 0, 0), (0, 0.1, 0), ATTITUDES, omega_body=np.zeros((2, 3)))
    motion = pt.propagate(system, start, [0.0])
    (estimate,) = np.atleast_1d(series.truncation(system.at(start)))
    assert estimate > 0.01
    assert motion.summary["coarse_series"] == f"1 of 1 times, error about {100 * estimate:.2g}%"


def test_gravity_on_a_given_orbit_is_refused():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    with pytest.raises(ValueError, match=r"GravityGradient must be for one body, .* Take ThirdBody\(orbit\)\."):
        pt.System(pair_of(), pt.GravityGradient(orbit))


def test_the_truncation_of_two_degrees_is_that_of_their_terms():
    """Mean squares over attitudes of the last two degrees, from the forces themselves."""
    pair = pair_of()
    four, two = (MutualHarmonics.of_shapes(pair, n) for n in (4, 2))
    count = 4000
    random = np.random.default_rng(6)
    attitudes = [Rotation.random(count, random) for _ in range(2)]
    distance = 20 * sum(s.circumscribing_radius for s in (POINTS, OTHERS))
    pulls = []
    for force in (four, two):
        system: Any = pt.System(pair, force)
        still = np.zeros((2, 3))
        states = pair.state((distance, 0, 0), np.zeros(3), attitudes, omega_body=still)
        pulls.append(np.stack(list(system.dynamics.load_at(system.at(states)).force)))
    terms = np.sqrt(np.mean(np.sum((pulls[0] - pulls[1]) ** 2, axis=0)))
    point = 1.3 * np.prod(pair.masses) / distance**2
    estimate = np.asarray(four.truncation(pt.System(pair, four).at(states)))[0]
    assert estimate == pytest.approx(terms / point / 400, rel=0.05)  # 4000 attitudes


# ---------------------------------------------------------------------- other bodies


BODY = pt.Body.from_shape(POINTS)
TWICE = pt.shapes.Mascons(2 * POINTS.masses, POINTS.positions)
TURNED = POINTS.moved(attitude=(0.8, 0, 0.6, 0))


@pytest.mark.parametrize(
    ("force", "sentence"),
    [
        (
            lambda: MutualHarmonics(TWICE.field(4), OTHERS.field(4), 4),
            "the field of the primary must have the mass of the body, 5, got 10",
        ),
        (
            lambda: MutualHarmonics(POINTS.field(4), OTHERS.moved(attitude=(0.8, 0, 0.6, 0)).field(4), 4),
            "degree 2 of the field of the secondary must agree with the inertia of the body",
        ),
        (
            lambda: MutualMascons(POINTS.masses, POINTS.positions, OTHERS.masses, centred(OTHERS)),
            "primary_positions must be from the centre of mass",
        ),
        (
            lambda: MutualMascons(TWICE.masses, centred(TWICE), OTHERS.masses, centred(OTHERS)),
            "primary_masses must have the mass of the body, 5, got 10",
        ),
        (
            lambda: MutualMascons(POINTS.masses, centred(TURNED), OTHERS.masses, centred(OTHERS)),
            "primary_masses and primary_positions must agree with the inertia of the body",
        ),
    ],
)
def test_a_force_of_other_bodies_is_refused(force, sentence):
    with pytest.raises(ValueError, match=sentence):
        pt.System(pair_of(), force())


def centred(shape):
    return shape.positions - shape.center_of_mass


@each_force
def test_one_body_is_refused(make):
    force = make(pair_of())
    with pytest.raises(ValueError, match=f"{type(force).__name__} must act between TwoBodies, got one body"):
        pt.System(BODY, force)


@pytest.mark.parametrize("degree", [1, 5])
def test_degree_beyond_the_fields(degree):
    with pytest.raises(ValueError, match=f"degree must be from 2 to 4, the lower one of the fields, got {degree}"):
        MutualHarmonics(POINTS.field(4), OTHERS.field(6), degree)


def test_a_body_without_a_shape_is_refused():
    pair = pt.TwoBodies(BODY, pt.Body((1.0, 1.2, 1.3), mass=1.0), G=1.0)
    with pytest.raises(ValueError, match=r"secondary must be made of a shape, by Body.from_shape, or be a sphere"):
        MutualHarmonics.of_shapes(pair, 4)
    with pytest.raises(ValueError, match=r"secondary must be made of Mascons, by Body.from_shape, or be a sphere"):
        MutualMascons.of_shapes(pair)


def test_a_sphere_needs_no_shape():
    ball, other = pt.Body.from_ellipsoid(0.7, (0.4, 0.4, 0.4)), pt.shapes.Ellipsoid((0.4, 0.4, 0.4), mass=0.7)
    pair, same = pt.TwoBodies(BODY, ball, G=1.0), pt.TwoBodies(BODY, pt.Body.from_shape(other), G=1.0)
    fields = MutualHarmonics.of_shapes(pair, 4)
    assert fields.secondary.extent == pytest.approx(0.4, rel=1e-15, abs=0)
    for found, expected in zip(gravity(pair, fields), gravity(same, MutualHarmonics.of_shapes(same, 4)), strict=True):
        assert np.max(np.abs(found - expected)) < 1e-15


def test_positions_of_one_point_need_two_axes():
    with pytest.raises(ValueError, match=r"secondary_positions must have shape \(n, 3\)"):
        MutualMascons(POINTS.masses, centred(POINTS), (1.0,), (0, 0, 0))
