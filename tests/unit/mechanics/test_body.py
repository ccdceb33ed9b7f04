"""The rigid body: moments, axes, rates and states."""

import itertools
import re
from typing import Any

import heyoka as hy
import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions

TURN = Rotation.from_rotvec([0.3, -0.5, 0.2])
MOMENTS = np.array([2.0, 3.0, 4.0])


def oblique(turn=TURN, moments=MOMENTS):
    """The body whose principal axes are turned, and its inertia tensor."""
    tensor = turn.as_matrix() @ np.diag(moments) @ turn.as_matrix().T
    return pt.Body.from_inertia(tensor), tensor


def gauss(low, high, count=8):
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (high + low) / 2 + (high - low) / 2 * nodes, (high - low) / 2 * weights


def integrated_moments(mass, x, y, z, weights):
    """Moments of a homogeneous solid, from points and weights that integrate over its volume."""
    density = mass / np.sum(weights)
    return density * np.array([np.sum(weights * s) for s in (y**2 + z**2, x**2 + z**2, x**2 + y**2)])


# ---------------------------------------------------------------------- homogeneous solids


def test_ellipsoid_against_an_integral_over_its_volume():
    a, b, c, mass = 1.2, 0.7, 2.0, 3.0
    (r, wr), (u, wu) = gauss(0, 1), gauss(-1, 1)
    phi = 2 * np.pi * np.arange(8) / 8
    r, u, phi = np.meshgrid(r, u, phi, indexing="ij")
    across = r * np.sqrt(1 - u * u)
    weights = r**2 * wr[:, None, None] * wu[None, :, None]
    expected = integrated_moments(mass, a * across * np.cos(phi), b * across * np.sin(phi), c * r * u, weights)
    assert np.allclose(pt.Body.from_ellipsoid(mass, (a, b, c)).moments, expected, rtol=1e-14, atol=0)


def test_box_against_an_integral_over_its_volume():
    sides, mass = (1.2, 0.7, 2.0), 3.0
    nodes, weights = zip(*(gauss(-s / 2, s / 2) for s in sides), strict=True)
    x, y, z = np.meshgrid(*nodes, indexing="ij")
    expected = integrated_moments(mass, x, y, z, np.einsum("i,j,k->ijk", *weights))
    assert np.allclose(pt.Body.from_box(mass, sides).moments, expected, rtol=1e-14, atol=0)


def test_cylinder_against_an_integral_over_its_volume():
    radius, height, mass = 0.8, 2.5, 3.0
    (r, wr), (z, wz) = gauss(0, radius), gauss(-height / 2, height / 2)
    phi = 2 * np.pi * np.arange(8) / 8
    r, z, phi = np.meshgrid(r, z, phi, indexing="ij")
    weights = r * wr[:, None, None] * wz[None, :, None]
    expected = integrated_moments(mass, r * np.cos(phi), r * np.sin(phi), z, weights)
    assert np.allclose(pt.Body.from_cylinder(mass, radius, height).moments, expected, rtol=1e-14, atol=0)


def test_point_masses_about_their_centre_of_mass():
    masses, positions = np.array([1.0, 2.0, 4.0]), np.array([[1.0, 0, 0], [0, 2, 0], [0.5, 0, 3]])
    centre = masses @ positions / 7
    expected = sum(
        m * ((x - centre) @ (x - centre) * np.eye(3) - np.outer(x - centre, x - centre))
        for m, x in zip(masses, positions, strict=True)
    )
    body = pt.Body.from_point_masses(masses, positions)
    assert np.allclose(body.inertia, expected, rtol=0, atol=1e-14 * np.max(expected))


def test_point_masses_do_not_depend_on_the_origin(rng):
    masses, positions = rng.uniform(1, 2, 5), rng.normal(size=(5, 3))
    here, there = (pt.Body.from_point_masses(masses, positions + shift) for shift in (0, np.array([5.0, -3.0, 1.0])))
    assert np.allclose(here.inertia, there.inertia, rtol=0, atol=1e-13)


# ---------------------------------------------------------------------- gravity fields and ratios

RATIOS = ("alpha", "beta", "gamma")
PAIRS = tuple(itertools.combinations(RATIOS, 2))


def ratios_of(body):
    a, b, c = body.moments
    return dict(zip(RATIOS, ((c - b) / a, (c - a) / b, (b - a) / c), strict=True))


def test_from_stokes_gives_europa():
    """J2 = 435.5e-6, C22 = 131.5e-6, C/MR^2 = 0.346: A < B < C and (B - A)/C = 4 C22 / 0.346."""
    europa = pt.Body.from_stokes(-435.5e-6, 131.5e-6, 0.346)
    assert type(europa) is pt.Body
    assert europa.moments == pytest.approx([0.3453015, 0.3458275, 0.346], rel=1e-15, abs=0)
    assert ratios_of(europa)["gamma"] == pytest.approx(1.52023e-3, rel=1e-5)


def test_from_stokes_of_a_homogeneous_ellipsoid():
    """C20 = (c^2 - (a^2 + b^2)/2) / (5 R^2), C22 = (a^2 - b^2) / (20 R^2)."""
    a, b, c, mass, radius = 1.3, 1.1, 0.9, 4.0, 1.7
    body = pt.Body.from_stokes(
        (c**2 - (a**2 + b**2) / 2) / (5 * radius**2),
        (a**2 - b**2) / (20 * radius**2),
        (a**2 + b**2) / (5 * radius**2),
        mass=mass,
        radius=radius,
    )
    assert body.moments == pytest.approx(pt.Body.from_ellipsoid(mass, (a, b, c)).moments, rel=1e-14, abs=0)
    assert np.all(np.diff(body.moments) > 0)


def test_from_stokes_keeps_the_given_axes():
    body = pt.Body.from_stokes(-0.02, 0.005, 0.35, C21=0.003, S21=-0.002, S22=0.001, mass=3.0, radius=2.0)
    expected = [(0.32, -0.002, -0.003), (-0.002, 0.34, 0.002), (-0.003, 0.002, 0.35)]
    assert np.allclose(body.inertia, 12 * np.array(expected), rtol=0, atol=6e-15)


def test_the_field_in_turned_axes_is_the_turned_body():
    """A body turned by an angle about its third axis has (C22, S22) turned by twice the angle."""
    angle, small = 0.3, 0.005
    body = pt.Body.from_stokes(-0.02, small * np.cos(2 * angle), 0.35, S22=small * np.sin(2 * angle))
    long_axis = body.principal_axes.as_matrix()[:, 0]
    assert np.allclose(long_axis, [np.cos(angle), np.sin(angle), 0], rtol=0, atol=1e-13)
    assert body.moments == pytest.approx(pt.Body.from_stokes(-0.02, small, 0.35).moments, rel=1e-15, abs=0)


def test_a_mean_moment_factor_becomes_a_polar_one():
    body = pt.Body.from_stokes(-0.02, 0.005, 0.35)
    assert np.mean(body.moments) - 2 / 3 * -0.02 == pytest.approx(0.35, rel=1e-15, abs=0)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
@pytest.mark.parametrize("moments", [(0.3615, 0.4265, 0.5024), (2.0, 3.0, 4.0), (4.0, 2.5, 3.0), (1.0, 1.0, 1.0)])
def test_any_two_ratios_make_the_body(moments, names):
    """The first moments are those of Phobos over M R^2; the third is another order of the axes."""
    ratios = ratios_of(pt.Body(moments))
    made = pt.Body.from_ratios(**{name: ratios[name] for name in names}, polar_moment=moments[2])
    assert made.moments == pytest.approx(moments, rel=1e-14, abs=0)
    assert ratios["beta"] * (1 + ratios["alpha"] * ratios["gamma"]) == pytest.approx(
        ratios["alpha"] + ratios["gamma"], abs=1e-15
    )


def test_the_moon_by_its_ratios_and_by_its_field():
    """beta and gamma of laser ranging, J2 and C22 of orbiters, to the digits of the polar moment."""
    ranged = pt.Body.from_ratios(beta=631.02e-6, gamma=227.73e-6, polar_moment=0.3931)
    orbited = pt.Body.from_stokes(-203.21e-6, 22.38e-6, 0.3931)
    assert ranged.moments == pytest.approx(orbited.moments, abs=2e-7)
    assert ranged.moments != pytest.approx(orbited.moments[::-1], abs=2e-5)


def test_the_polar_moment_changes_nothing_of_what_gravity_does():
    rates, orbit = (
        {"attitude": TURN, "omega_body": (0.3, -0.2, 0.9)},
        pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1, inclination=0.3),
    )
    bodies = [pt.Body.from_ratios(alpha=0.3, gamma=0.2, polar_moment=polar) for polar in (1.0, 7.0)]
    one, other = (
        pt.propagate(pt.System(body, pt.GravityGradient(orbit)), body.state(**rates), [0.0, 10.0]) for body in bodies
    )
    assert np.allclose(one.quaternion, other.quaternion, rtol=0, atol=1e-13)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_ratios_of_flat_plates(names):
    """A plate across the third axis has alpha = beta = 1, which leaves its own shape open."""
    if names == ("alpha", "beta"):
        with pytest.raises(ValueError, match=r"^moments must be positive, got 0\.0\.$"):
            pt.Body.from_ratios(alpha=1, beta=1)
    else:
        body = pt.Body.from_ratios(**{names[0]: 1.0}, gamma=0.2)
        assert body.moments == pytest.approx([0.4, 0.6, 1.0], rel=1e-15, abs=0)


BAD_CONSTRUCTORS = {
    "stokes_of_no_body": (
        lambda: pt.Body.from_stokes(-0.25, 0.125, 0.375),
        "moments must be positive, got -0.125.",
    ),
    "stokes_beyond_the_triangle": (
        lambda: pt.Body.from_stokes(-0.25, 0, 0.5 - 2**-5),
        "moments must satisfy the triangle inequality, but 0.46875 > 0.21875 + 0.21875. "
        "No rigid body has these moments.",
    ),
    "no_polar_moment": (
        lambda: pt.Body.from_stokes(-1e-3, 1e-4, 0.0),
        "polar_moment_factor must be positive, got 0.0.",
    ),
    "coefficient_of_members": (
        lambda: pt.Body.from_stokes([-1e-3], 1e-4, 0.4),
        "C20 must have shape (), got shape (1,).",
    ),
    "coefficient_that_is_none": (
        lambda: pt.Body.from_stokes(-1e-3, np.nan, 0.4),
        "C22 must be finite, got C22 = nan.",
    ),
    "one_ratio": (
        lambda: pt.Body.from_ratios(beta=0.1),
        "from_ratios must have exactly two of alpha, beta, gamma, got beta.",
    ),
    "three_ratios": (
        lambda: pt.Body.from_ratios(alpha=0.1, beta=0.2, gamma=0.1),
        "from_ratios must have exactly two of alpha, beta, gamma, got alpha and beta and gamma.",
    ),
    "no_ratio": (
        lambda: pt.Body.from_ratios(),
        "from_ratios must have exactly two of alpha, beta, gamma, got none.",
    ),
    "ratio_of_no_body": (
        lambda: pt.Body.from_ratios(alpha=0.1, gamma=-1.2),
        "gamma must lie in [-1, 1], got -1.2. No rigid body has these moments.",
    ),
}


@pytest.mark.parametrize("name", BAD_CONSTRUCTORS)
def test_fields_and_ratios_of_no_body(name):
    call, sentence = BAD_CONSTRUCTORS[name]
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        call()


# ---------------------------------------------------------------------- limits of the possible


@pytest.mark.parametrize("moments", [(1, 2, 3), (3, 1, 2), (0.1, 0.2, 0.1 + 0.2), (0.3, 0.1, 0.2), (1, 1e-9, 1)])
def test_flat_plates_and_needles_are_bodies(moments):
    assert pt.Body(moments).moments.tolist() == list(moments)


def test_every_turned_flat_plate_is_a_body(rng):
    for turn in Rotation.random(200, rng=rng):
        a, b = rng.uniform(0.01, 3, 2)
        body, _ = oblique(turn, np.array([a, b, a + b]))
        assert np.allclose(np.sort(body.moments), np.sort([a, b, a + b]), rtol=1e-13, atol=0)


def test_members_are_checked_one_by_one():
    assert pt.Body(np.array([[1.0, 1, 1], [1, 2, 3]])).moments.shape == (2, 3)
    with pytest.raises(ValueError, match=r"but 4\.0 > 1\.0 \+ 2\.0\."):
        pt.Body(np.array([[1.0, 1, 1], [4, 1, 2], [1, 2, 3]]))


def test_a_body_keeps_its_own_copy_of_the_moments():
    given = np.array([1.0, 1.0, 1.0])
    body = pt.Body(given)
    given[0] = -5.0
    assert body.moments[0] == 1.0


def test_a_body_is_frozen(body):
    with pytest.raises(AttributeError):
        body.moments = (1, 1, 1)


# ---------------------------------------------------------------------- momentum and rate


def test_omega_angular_momentum_and_energy_of_principal_axes():
    body, omega = pt.Body(MOMENTS), np.array([0.5, -1.0, 2.0])
    assert body.angular_momentum(omega).tolist() == [1.0, -3.0, 8.0]
    assert body.omega([1.0, -3.0, 8.0]).tolist() == omega.tolist()
    assert body.kinetic_energy([1.0, -3.0, 8.0]) == pytest.approx(0.5 * (2 * 0.25 + 3 * 1 + 4 * 4), rel=1e-15, abs=0)
    assert body.moment_about([0.6, 0, 0.8]) == pytest.approx(0.36 * 2 + 0.64 * 4, rel=1e-15, abs=0)


def test_rates_of_batches():
    body, g = pt.Body(MOMENTS), np.arange(12.0).reshape(4, 3)
    assert np.allclose(body.omega(g), g / MOMENTS, rtol=1e-15, atol=0)
    assert np.allclose(body.kinetic_energy(g), 0.5 * np.sum(g * g / MOMENTS, axis=-1), rtol=1e-15, atol=0)


def test_rates_of_an_oblique_body_are_those_of_its_tensor(rng):
    body, tensor = oblique()
    omega, u = rng.normal(size=(5, 3)), np.array([0.6, 0, 0.8])
    g = omega @ tensor
    assert np.allclose(body.angular_momentum(omega), g, rtol=0, atol=1e-14)
    assert np.allclose(body.omega(g), omega, rtol=0, atol=1e-14)
    assert np.allclose(body.kinetic_energy(g), 0.5 * np.sum(g * omega, axis=-1), rtol=1e-14, atol=0)
    assert body.moment_about(u) == pytest.approx(u @ tensor @ u, rel=1e-14, abs=0)


def test_kinetic_energy_is_one_formula_for_every_scalar():
    body, g = pt.Body(MOMENTS), (1.0, -3.0, 8.0)
    expected = body.kinetic_energy(g)
    symbols = sympy.symbols("g1:4")
    energy: Any = body.kinetic_energy(functions.Vector(symbols))
    assert float(energy.subs(dict(zip(symbols, g, strict=True)))) == pytest.approx(expected, rel=1e-15, abs=0)
    variables = [hy.expression(f"g{i}") for i in range(3)]
    compiled = hy.cfunc([body.kinetic_energy(functions.Vector(variables))], vars=variables)
    assert compiled(np.array(g))[0] == pytest.approx(expected, rel=1e-15, abs=0)


# ---------------------------------------------------------------------- axes


def test_from_inertia_keeps_the_users_axes():
    body, tensor = oblique()
    assert np.allclose(body.inertia, tensor, rtol=0, atol=1e-14)
    assert np.allclose(body.angular_momentum([1.0, 0, 0]), tensor[:, 0], rtol=0, atol=1e-14)


def test_from_inertia_of_a_diagonal_tensor_keeps_the_order():
    body = pt.Body.from_inertia(np.diag([3.0, 4.0, 2.0]))
    assert type(body) is pt.Body
    assert body.moments.tolist() == [3.0, 4.0, 2.0]


def test_inertia_and_axes_of_principal_moments():
    body = pt.Body(MOMENTS)
    assert body.inertia.tolist() == np.diag(MOMENTS).tolist()
    assert body.principal_axes.magnitude() == 0


@pytest.mark.parametrize("vector", [(0.3, -0.5, 0.2), (1.4, 0, 0), (2.0, 2.0, 0), (3.1, 0, 0.2), (0, 1e-6, 0)])
def test_principal_axes_diagonalise_and_are_the_nearest_right_handed_ones(vector):
    body, tensor = oblique(Rotation.from_rotvec(vector))
    axes = body.principal_axes.as_matrix()
    assert np.linalg.det(axes) == pytest.approx(1, rel=1e-14, abs=0)
    assert np.allclose(axes.T @ tensor @ axes, np.diag(body.moments), rtol=0, atol=1e-14)
    others = (
        axes[:, order] * signs
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1, -1), repeat=3)
    )
    nearest = min(Rotation.from_matrix(other).magnitude() for other in others if np.linalg.det(other) > 0)
    assert body.principal_axes.magnitude() == pytest.approx(nearest, abs=1e-7)


def test_principal_axes_of_a_symmetric_body_are_the_nearest_ones(rng):
    """Any axes across the symmetry axis are principal; the nearest only tilt the symmetry axis into place."""
    for turn in Rotation.random(20, rng=rng):
        body, _ = oblique(turn, np.array([1.0, 1.0, 1.5]))
        tilt = np.arccos(np.max(np.abs(turn.as_matrix()[:, 2])))
        assert body.principal_axes.magnitude() == pytest.approx(tilt, abs=1e-7)


def test_principal_axes_of_a_sphere_are_the_given_ones(rng):
    for turn in Rotation.random(20, rng=rng):
        assert oblique(turn, np.ones(3))[0].principal_axes.magnitude() < 1e-7


GAPS = (1.0, 1e-3, 1e-6, 1e-9, 1e-12)
"""Relative differences of two moments; eigenvectors in doubles are wrong by the rounding over the gap."""


@pytest.mark.parametrize("gap", GAPS)
def test_principal_moments_and_axes_are_rounded_eigenvectors_of_forty_digits(gap, rng):
    for turn in Rotation.random(5, rng=rng):
        _, tensor = oblique(turn, np.array([1.0, 1.0 + 0.9 * gap, 1.95]))
        body = pt.Body.from_inertia((tensor + tensor.T) / 2)
        with mpmath.workdps(40):
            moments, vectors = mpmath.eigsy(mpmath.matrix(((tensor + tensor.T) / 2).tolist()))
            exact = np.array(vectors.tolist())
            order = [int(np.argmax(np.abs((axis @ exact).astype(float)))) for axis in body.principal_matrix.T]
            signs = np.sign((exact[:, order] * body.principal_matrix).sum(axis=0).astype(float))
            wrong = (exact[:, order] * signs - body.principal_matrix).astype(float)
            wrong_moments = (np.array(moments.tolist()).ravel()[order] - body.moments).astype(float)
        assert np.all(np.abs(wrong) <= 0.5 * np.spacing(np.abs(body.principal_matrix)) + 1e-20)  # half a unit
        assert np.all(np.abs(wrong_moments) <= 0.5 * np.spacing(body.moments) * (1 + 1e-6))


@pytest.mark.parametrize("moments", [MOMENTS, (1.0, 1.0, 1.5), (1.0, 1.0 + 3e-14, 1.5), (1.0, 1.0, 1.0)])
def test_principal_axes_are_orthogonal_and_diagonalise_to_rounding(moments, rng):
    for turn in Rotation.random(10, rng=rng):
        _, tensor = oblique(turn, np.array(moments))
        tensor = (tensor + tensor.T) / 2
        body = pt.Body.from_inertia(tensor)
        with mpmath.workdps(40):
            axes = np.array(mpmath.matrix(body.principal_matrix.tolist()).tolist())
            defect = (axes.T @ axes - np.eye(3)).astype(float)
            rest = (axes.T @ np.array(mpmath.matrix(tensor.tolist()).tolist()) @ axes).astype(float)
        # three products of two components below 1, each component rounded by at most half of 2^-53
        assert np.max(np.abs(defect)) <= 3 * np.finfo(float).eps / 2
        assert np.max(np.abs(rest - np.diag(body.moments))) <= 3 * np.finfo(float).eps * max(moments)


def test_a_small_turn_keeps_the_order_of_the_moments():
    turn = Rotation.from_rotvec([0.1, 0.2, -0.1])
    body, _ = oblique(turn)
    assert np.allclose(body.moments, MOMENTS, rtol=1e-14, atol=0)
    assert (turn.inv() * body.principal_axes).magnitude() < 1e-14


# ---------------------------------------------------------------------- states

ATTITUDE = Rotation.from_rotvec([0.7, -0.2, 1.1])
BODIES = {"principal": pt.Body(MOMENTS), "oblique": oblique()[0]}
OMEGA = np.array([0.4, -0.3, 0.6])


def vectors(body):
    g = body.inertia @ OMEGA
    return {
        "omega_body": OMEGA,
        "omega_space": ATTITUDE.apply(OMEGA),
        "angular_momentum_body": g,
        "angular_momentum_space": ATTITUDE.apply(g),
    }


@pytest.mark.parametrize("name", ["omega_body", "omega_space", "angular_momentum_body", "angular_momentum_space"])
@pytest.mark.parametrize("kind", BODIES)
def test_state_from_each_of_the_four_vectors(kind, name):
    body = BODIES[kind]
    given = vectors(body)
    state = body.state(ATTITUDE, **{name: given[name]}, time=2.5)
    assert np.allclose(state.angular_momentum_body, given["angular_momentum_body"], rtol=0, atol=1e-14)
    assert np.allclose(state.angular_momentum_space, given["angular_momentum_space"], rtol=0, atol=1e-14)
    assert np.allclose(state.quaternion, ATTITUDE.as_quat(scalar_first=True), rtol=0, atol=1e-16)
    assert state.time == 2.5


def test_state_keeps_the_sign_of_a_given_quaternion():
    q = -ATTITUDE.as_quat(scalar_first=True)
    state = pt.Body(MOMENTS).state(q, omega_body=OMEGA)
    assert state.quaternion.tolist() == q.tolist()
    assert np.allclose(state.angular_momentum_body, MOMENTS * OMEGA, rtol=0, atol=1e-15)


def test_state_at_rest():
    state = pt.Body(MOMENTS).state(ATTITUDE, omega_body=(0, 0, 0))
    assert state.conjugate_momenta.tolist() == [0, 0, 0, 0]


def test_states_of_members():
    state = pt.Body(MOMENTS).state(ATTITUDE, omega_body=np.stack([OMEGA, 2 * OMEGA]))
    assert state.quaternion.shape == state.conjugate_momenta.shape == (2, 4)
    assert np.allclose(state.angular_momentum_body[1], 2 * MOMENTS * OMEGA, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["omega_body", "omega_space"])
@pytest.mark.parametrize("kind", BODIES)
def test_state_relative_to_a_frame(kind, name):
    """Attitude body -> frame; the rate relative to the frame, along the body's or the frame's axes."""
    body, time = BODIES[kind], 1.7
    frame = pt.RotatingFrame(Rotation.from_rotvec([0.2, 0.1, -0.4]), (0.3, -0.2, 0.5), epoch=0.5)
    rate = OMEGA if name == "omega_body" else ATTITUDE.apply(OMEGA)
    state = body.state(ATTITUDE, **{name: rate}, time=time, frame=frame)
    expected = frame.attitude(time) * ATTITUDE
    assert (expected.inv() * state.attitude).magnitude() < 1e-15
    inertial = expected.apply(OMEGA) + np.array([0.3, -0.2, 0.5])
    assert np.allclose(expected.apply(body.omega(state.angular_momentum_body)), inertial, rtol=0, atol=1e-14)


@pytest.mark.parametrize("coefficient", ["C21", "S21", "C22", "S22"])
@pytest.mark.parametrize("value", [-1e308, 1e308])
def test_coefficients_at_the_end_of_the_numbers_are_refused(coefficient, value):
    given = {"C20": -0.05, "C22": 0.01, "polar_moment_factor": 0.4, coefficient: value}
    with pytest.raises(ValueError, match=r"^(moments|tensor) must be (positive|finite), got |^moments must satisfy"):
        pt.Body.from_stokes(**given)
