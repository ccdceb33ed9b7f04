"""The gravity between two bodies against sums of 30 digits, a quadrature of exact ellipsoids and closed forms."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from oracles import ellipsoid_pairs as oracle
from poinsot.forces import MutualGravity, MutualHarmonics, MutualMascons

STATIC = json.loads((Path(__file__).parent / "pair_cases.json").read_text())["static"]
CASES = [(case, name) for case in STATIC for name in case["values"]]


def relative(a, b):
    return np.linalg.norm(np.subtract(a, b)) / np.linalg.norm(b)


def made_of(points):
    points = np.array(points)
    return pt.Body.from_shape(pt.shapes.Mascons(points[:, 0], points[:, 1:]))


def gravity(pair, force, separation, attitudes):
    """Potential energy, force on the secondary and both torques, in space; of one state or of several."""
    system: Any = pt.System(pair, force)
    still = np.zeros((2, 3))
    state = pair.state(separation, np.zeros(3), attitudes, omega_body=still)
    load = system.dynamics.load_at(system.at(state))
    pull, *torques = (np.stack(list(v), axis=-1).astype(float) for v in (load.force, *load.torques))
    return system.potential_energy(state), pull, *(a.apply(t) for a, t in zip(attitudes, torques, strict=True))


def turns(seed, count=None):
    """Two attitudes, or two times several."""
    random = np.random.default_rng(seed)
    return [Rotation.random(count, random) for _ in range(2)]


# ---------------------------------------------------------------------- sums over points of mass


def forces_of(name, pair):
    if name == "exact":
        return [MutualMascons.of_shapes(pair)]
    degree = int(name.split()[1])
    if not degree:
        return []
    return [MutualHarmonics.of_shapes(pair, degree)] + [MutualGravity()] * (degree == 2)


@pytest.mark.parametrize(("case", "name"), CASES, ids=lambda x: x if isinstance(x, str) else x["name"])
def test_static_cases(case, name):
    pair = pt.TwoBodies(made_of(case["points1"]), made_of(case["points2"]), G=case["G"])
    attitudes = [Rotation.from_quat(case[f"attitude{k}"], scalar_first=True) for k in (1, 2)]
    expected = case["values"][name]
    for force in forces_of(name, pair):
        found = gravity(pair, force, case["position"], attitudes)
        for what, number in zip(("potential", "force_on_2", "torque_on_1", "torque_on_2"), found, strict=True):
            assert relative(number, np.array(expected[what], dtype=float)) < 1e-14, what


CLOUDS = [np.column_stack([w, x]) for w, x in [
    (np.array([2.0, 1.0, 3.0, 1.5, 2.5]), np.random.default_rng(1).normal(size=(5, 3))),
    (np.array([0.2, 0.3, 0.1, 0.4]), 0.4 * np.random.default_rng(2).normal(size=(4, 3))),
]]  # fmt: skip


@pytest.mark.parametrize("degree", [2, 3, 4, 5, 8])
def test_what_a_degree_leaves_falls_with_the_next_power_of_the_distance(degree):
    pair = pt.TwoBodies(*map(made_of, CLOUDS), G=1.0)
    exact, series = MutualMascons.of_shapes(pair), MutualHarmonics.of_shapes(pair, degree)
    directions, attitudes = turns(9, 20)[0].apply([1, 0, 0]), turns(3, 20)
    reach = sum(body.shape.circumscribing_radius for body in pair.bodies.values())

    def rest(force, distance):
        separation = distance * reach * directions
        return [
            np.linalg.norm(np.subtract(a, b))  # of 20 states: the next but one has 1/12 of its size at most
            for a, b in zip(*(gravity(pair, each, separation, attitudes) for each in (force, exact)), strict=True)
        ]

    near, far = rest(series, 12.0), rest(series, 24.0)
    powers = np.log2(np.divide(near, far))
    assert powers == pytest.approx(degree + np.array([2, 3, 2, 2]), abs=0.25)


# ---------------------------------------------------------------------- exact ellipsoids

SEMIAXES = np.array([(1.0, 0.85, 0.7), (0.4, 0.3, 0.25)])
MASSES = (1.0, 0.05)
ELLIPSOIDS = [pt.shapes.Ellipsoid(a, mass=m) for a, m in zip(SEMIAXES, MASSES, strict=True)]
LONGEST = SEMIAXES[:, 0].sum()


def ellipsoid_pair():
    return pt.TwoBodies(*map(pt.Body.from_shape, ELLIPSOIDS), G=1.0)


def errors(force, distance, count=6):
    """Those of potential, force and torques of some states at a distance in sums of the longest semiaxes."""
    attitudes = turns(2, count)
    separation = distance * LONGEST * turns(102, count)[0].apply([1, 0, 0])
    found = gravity(ellipsoid_pair(), force, separation, attitudes)
    matrices = zip(*(a.as_matrix() for a in attitudes), strict=True)
    exact = [oracle.gravity(MASSES, SEMIAXES, *each) for each in zip(separation, matrices, strict=True)]
    return [relative(a, b) for a, b in zip(found, map(np.array, zip(*exact, strict=True)), strict=True)]


def test_the_field_of_the_oracle_is_that_of_a_shape():
    points = np.array([(1.5, 0.2, -0.3), (-0.1, 0.2, 0.9), (0.0, 3.0, 0.0)])
    potential, attraction = oracle.field(MASSES[0], SEMIAXES[0], points)
    shape = ELLIPSOIDS[0]
    assert relative(-potential, shape.potential(points)) < 1e-15
    assert relative(attraction, shape.attraction(points)) < 4e-15


def test_the_oracle_has_converged():
    attitudes, separation = [a.as_matrix() for a in turns(5)], 1.5 * LONGEST * np.array([0.48, 0.6, -0.64])
    few, many = (oracle.gravity(MASSES, SEMIAXES, separation, attitudes, nodes) for nodes in (16, 24))
    assert [relative(a, b) for a, b in zip(few, many, strict=True)] == pytest.approx(np.zeros(4), abs=2e-12)


def test_spheres_of_the_oracle_are_points():
    potential, force, *torques = oracle.gravity((2.0, 3.0), np.ones((2, 3)), np.array([0, 3.0, 4.0]), [np.eye(3)] * 2)
    assert potential == pytest.approx(-1.2, rel=1e-14, abs=0)
    assert force == pytest.approx([0, -0.144, -0.192], abs=1e-14)
    assert np.max(np.abs(torques)) < 3e-14


@pytest.mark.parametrize(("degree", "force", "torque"), [(2, 2e-3, 3e-2), (4, 1.6e-4, 6e-3)])
def test_errors_of_near_ellipsoids_have_the_known_size(degree, force, torque):
    """At 1.5 times the sum of the longest semiaxes; other ellipsoids and attitudes have up to three times as much."""
    found = errors(MutualHarmonics.of_shapes(ellipsoid_pair(), degree), 1.5)
    assert force / 3 < found[1] < 3 * force
    assert torque / 3 < max(found[2:]) < 3 * torque


def test_degrees_converge_to_exact_ellipsoids():
    """Odd degrees are zero; two even ones that follow have the ratio 1 / 9 for points at the ends, less for solids."""
    found = np.array([errors(MutualHarmonics.of_shapes(ellipsoid_pair(), n), 3.0) for n in (2, 4, 6, 8)])
    assert np.all(found[1:] < found[:-1] / 9)
    assert np.all(found[-1] < 1e-6)


@pytest.mark.samples
@pytest.mark.parametrize(
    ("degree", "distance"), [(2, 1.05), (3, 1.5), (4, 3.0), (6, 1.05), (2, 3.0), (4, 1.5), (3, 1.05), (6, 3.0)]
)
def test_the_estimate_of_the_truncation_is_above_the_error_and_not_far(degree, distance):
    pair = ellipsoid_pair()
    force = MutualHarmonics.of_shapes(pair, degree)
    typical = errors(force, distance)[1]
    state = pair.state((distance * LONGEST, 0, 0), (0, 0, 0), turns(1), omega_body=np.zeros((2, 3)))
    estimate = force.truncation(pt.System(pair, force).at(state))
    assert typical < estimate < 30 * typical
    if degree == 2:  # whose radii are those of the ellipsoids too
        other = MutualGravity().truncation(pt.System(pair, MutualGravity()).at(state))
        assert other == pytest.approx(estimate, rel=1e-13, abs=0)


# ---------------------------------------------------------------------- one extended body

BONE = pt.shapes.Mascons([1.0, 2.0, 1.5, 0.5], [(1, 0.1, 0), (-0.7, 0.3, 0.1), (0.1, -0.4, 0.3), (0.3, 0.3, -0.8)])


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("degree", [2, 5, 8])
def test_a_sphere_is_an_attractor(degree, place):
    """Beside the point masses the energy is that of the field on an orbit that is given."""
    ball, bone = pt.shapes.Ellipsoid((0.4, 0.4, 0.4), mass=0.7), BONE
    shapes = (bone, ball)[:: 1 - 2 * place]
    pair = pt.TwoBodies(*map(pt.Body.from_shape, shapes), G=1.3)
    separation, attitudes = np.array([1.9, -1.2, 1.4]), turns(8)
    energy, _, *torques = gravity(pair, MutualHarmonics.of_shapes(pair, degree), separation, attitudes)
    from_ball = separation if place else -separation
    orbit = pt.orbits.FixedPosition(pair.G * ball.mass, position=from_ball)
    body = pair.bodies["secondary" if place else "primary"]
    alone = pt.System(body, pt.forces.HarmonicGravity(orbit, bone.field(degree)))
    state = body.state(attitudes[place], omega_body=(0, 0, 0))
    points = -pair.G * np.prod(pair.masses) / np.linalg.norm(separation)
    assert energy - points == pytest.approx(alone.potential_energy(state), rel=1e-13, abs=0)
    assert relative(torques[place], attitudes[place].apply(alone.torque_body(state))) < 1e-14
    assert np.max(np.abs(torques[1 - place])) < 1e-15


def test_a_sphere_next_to_points_is_exact():
    pair = pt.TwoBodies(pt.Body.from_shape(BONE), pt.Body.from_ellipsoid(0.7, (0.4, 0.4, 0.4)), G=1.3)
    separation, attitudes = np.array([1.9, -1.2, 1.4]), turns(8)
    energy, force, *_ = gravity(pair, MutualMascons.of_shapes(pair), separation, attitudes)
    place = attitudes[0].inv().apply(separation)
    assert energy == pytest.approx(-0.91 * float(BONE.potential(place)), rel=1e-14, abs=0)
    assert relative(force, 0.91 * attitudes[0].apply(BONE.attraction(place))) < 1e-14


def test_a_far_field_of_points_keeps_its_digits():
    """The torque at a distance of 1e5 times the size, where sums of m / |r + x| would keep five digits of sixteen."""
    pair = pt.TwoBodies(*map(made_of, CLOUDS), G=1.0)
    separation, attitudes = 1e5 * np.array([1.9, -1.2, 1.4]), turns(8)
    exact = gravity(pair, MutualMascons.of_shapes(pair), separation, attitudes)
    series = gravity(pair, MutualHarmonics.of_shapes(pair, 4), separation, attitudes)
    assert max(relative(a, b) for a, b in zip(exact, series, strict=True)) < 3e-15
