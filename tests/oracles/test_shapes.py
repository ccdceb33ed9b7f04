"""Shapes against exact rational integrals, closed forms, multi-precision quadrature and another library."""

from fractions import Fraction
from functools import cache
from itertools import product
from math import comb, factorial

import mpmath
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import poinsot as pt

BIPYRAMID = np.array([(6, 0, 0), (-2, 5, 1), (-3, -4, 0), (1, 1, 7), (0, 1, -4)])
SIDES = np.array([(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)])


# ---------------------------------------------------------------------- exact integrals over tetrahedra


def times(p, q):
    out = {}
    for (i, a), (j, b) in product(p.items(), q.items()):
        key = tuple(map(sum, zip(i, j, strict=True)))
        out[key] = out.get(key, 0) + a * b
    return out


@cache
def solid_harmonic(n, m):
    """Real and imaginary part of Z_nm as polynomials {(i, j, k): coefficient}, from the definition of P_nm."""
    whole = {}
    for k in range((n - m) // 2 + 1):
        legendre = Fraction((-1) ** k * comb(n, k) * comb(2 * n - 2 * k, n), 2**n)
        slope = legendre * Fraction(factorial(n - 2 * k), factorial(n - 2 * k - m))
        height = n - m - 2 * k
        for a, b in (pair for pair in product(range(k + 1), repeat=2) if sum(pair) <= k):
            many = factorial(k) // (factorial(a) * factorial(b) * factorial(k - a - b))
            key = (2 * a, 2 * b, 2 * (k - a - b) + height)
            whole[key] = whole.get(key, 0) + slope * many
    parts = [{}, {}]
    for j in range(m + 1):  # (x + i y)^m
        parts[j % 2][m - j, j, 0] = (-1) ** (j // 2) * comb(m, j)
    return [times(whole, part) for part in parts]


def moments(corners, n):
    """Integrals of all monomials of degree n over the tetrahedra (0, a, b, c), rational."""
    total = {key: Fraction(0) for key in product(range(n + 1), repeat=3) if sum(key) == n}
    unit = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    for triangle in corners:
        six_volumes = Fraction(round(np.linalg.det(np.array(triangle, dtype=float))))
        powers = []
        for axis in range(3):
            linear = {unit[v]: triangle[v][axis] for v in range(3)}
            rising = [{(0, 0, 0): 1}]
            for _ in range(n):
                rising.append(times(rising[-1], linear))
            powers.append(rising)
        for i, j, k in total:
            polynomial = times(times(powers[0][i], powers[1][j]), powers[2][k])
            value = sum(c * factorial(p) * factorial(q) * factorial(r) for (p, q, r), c in polynomial.items())
            total[i, j, k] += six_volumes * Fraction(value, factorial(n + 3))
    return total


def centred():
    """Corners of the faces of the bipyramid from its centre of mass, whole numbers: those of a scaled body."""
    cones = [round(np.linalg.det(t.astype(float))) for t in BIPYRAMID[SIDES]]
    center = [
        Fraction(int(sum(d * t[:, k].sum() for d, t in zip(cones, BIPYRAMID[SIDES], strict=True))), 4 * sum(cones))
        for k in range(3)
    ]
    scale = int(np.lcm.reduce([c.denominator for c in center]))
    vertices = [[int(scale * (int(x) - c)) for x, c in zip(v, center, strict=True)] for v in BIPYRAMID]
    return [[vertices[v] for v in side] for side in SIDES.tolist()], scale


@pytest.mark.parametrize("degree", [2, 3, 5, 16])
def test_stokes_coefficients_of_a_polyhedron_are_the_rational_ones_to_rounding(degree):
    corners, scale = centred()
    field = pt.shapes.Mesh(BIPYRAMID, SIDES, density=1.0).field(degree, radius=8.0)
    exact, volume = moments(corners, degree), moments(corners, 0)[0, 0, 0]
    found = field.normalized
    for m in range(degree + 1):
        size = Fraction((2 - (m == 0)) * factorial(degree - m), factorial(degree + m))
        norm = float(mpmath.sqrt(mpmath.mpf(size.numerator * (2 * degree + 1)) / size.denominator))
        for values, polynomial in zip(found, solid_harmonic(degree, m), strict=True):
            integral = sum(c * exact[key] for key, c in polynomial.items())
            reference = size * integral / (volume * Fraction(8 * scale) ** degree)
            assert abs(values[degree, m] - float(reference) / norm) < 3e-17


def test_the_mass_properties_of_a_polyhedron_are_the_rational_ones():
    corners, scale = centred()
    mesh = pt.shapes.Mesh(BIPYRAMID, SIDES, density=3.0)
    volume = moments(corners, 0)[0, 0, 0] / scale**3
    assert mesh.volume == pytest.approx(float(volume), rel=1e-15, abs=0)
    assert mesh.mass == pytest.approx(3 * float(volume), rel=1e-15, abs=0)
    spread = {key: 3 * float(value / Fraction(scale) ** 5) for key, value in moments(corners, 2).items()}
    xx, yy, zz, xy, xz, yz = (spread[k] for k in [(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1)])
    exact = [(yy + zz, -xy, -xz), (-xy, xx + zz, -yz), (-xz, -yz, xx + yy)]
    np.testing.assert_allclose(mesh.inertia, exact, rtol=0, atol=1e-14 * max(xx, yy, zz))


# ---------------------------------------------------------------------- polyhedra


def test_mass_properties_are_those_of_trimesh(rng):
    solid = trimesh.creation.icosphere(2)
    solid.vertices = (solid.vertices * (1 + 0.3 * rng.random((len(solid.vertices), 1)))) @ rng.normal(size=(3, 3)) + 5
    mesh = pt.shapes.Mesh(solid.vertices, solid.faces, density=2.0, repair=True)
    if solid.volume < 0:
        solid.invert()
    solid.density = 2.0
    assert mesh.mass == pytest.approx(solid.mass, rel=4e-15, abs=0)
    np.testing.assert_allclose(mesh.center_of_mass, solid.center_mass, rtol=8e-15)
    np.testing.assert_allclose(mesh.inertia, solid.moment_inertia, rtol=0, atol=1e-12 * np.max(mesh.inertia))


def cuboid_potential(sides, point):
    """Of density 1: the closed form by its eight corners (MacMillan 1930)."""
    total = 0.0
    for signs in product((-1, 1), repeat=3):
        x, y, z = (s * a / 2 - p for s, a, p in zip(signs, sides, point, strict=True))
        r = np.sqrt(x * x + y * y + z * z)
        value = sum(
            a * b * np.log(c + r) - c * c / 2 * np.arctan(a * b / (c * r))
            for a, b, c in ((x, y, z), (y, z, x), (z, x, y))
        )
        total += np.prod(signs) * value
    return total


@pytest.mark.parametrize("point", [(0.7, 0.9, 1.6), (0.1, -0.2, 0.3), (-2.0, 3.0, 4.0), (0.45, 0.95, -1.4)])
def test_a_box_pulls_as_its_closed_form(point):
    sides = np.array((1.0, 2.0, 3.0))
    box = pt.shapes.Mesh.from_box(sides, density=1.0)
    assert box.potential(point) == pytest.approx(cuboid_potential(sides, point), rel=2e-14, abs=0)
    step = 1e-3
    slopes = [  # fourth order
        (8 * (up - down) - (far_up - far_down)) / (12 * step)
        for up, down, far_up, far_down in (
            [cuboid_potential(sides, np.array(point) + k * step * axis) for k in (1, -1, 2, -2)] for axis in np.eye(3)
        )
    ]
    np.testing.assert_allclose(box.attraction(point), slopes, rtol=1e-9, atol=1e-9)


def cubature_of_tetrahedra(corners, count=24):
    """Weights and points: Gauss-Legendre in collapsed coordinates of the tetrahedra (0, a, b, c)."""
    nodes, gauss = np.polynomial.legendre.leggauss(count)
    t, w = (nodes + 1) / 2, gauss / 2
    r, u, v = (grid.ravel() for grid in np.meshgrid(t, t, t, indexing="ij"))
    weights = np.einsum("i,j,k->ijk", w, w, w).ravel() * r * r * u
    points = np.einsum("pk,fki->fpi", np.stack([r * (1 - u), r * u * (1 - v), r * u * v], axis=-1), corners)
    return np.outer(np.linalg.det(corners), weights).ravel(), points.reshape(-1, 3)


def test_an_irregular_polyhedron_pulls_as_brute_force_says():
    mesh = pt.shapes.Mesh(BIPYRAMID, SIDES, density=1.0)
    weights, points = cubature_of_tetrahedra((BIPYRAMID - mesh.center_of_mass)[SIDES])
    for place in np.array([(9.0, 1.0, -2.0), (-5.0, 8.0, 1.0), (2.0, -6.0, 12.0)]):
        away = points - place
        distance = np.linalg.norm(away, axis=-1)
        assert mesh.potential(place) == pytest.approx(np.sum(weights / distance), rel=1e-13, abs=0)
        np.testing.assert_allclose(mesh.attraction(place), (weights / distance**3) @ away, rtol=1e-12)


def test_solid_angles_close_inside_and_cancel_outside(rng):
    from poinsot.shapes.polyhedron import Triangles

    triangles = Triangles(BIPYRAMID.astype(float), SIDES)
    inside, outside = rng.uniform(-0.7, 0.7, size=(20, 3)), 9 * rng.choice([-1, 1], size=(20, 3))
    np.testing.assert_allclose(triangles.seen_from(inside)[2].sum(axis=1), 4 * np.pi, rtol=1e-14)
    np.testing.assert_allclose(triangles.seen_from(outside)[2].sum(axis=1), 0, rtol=0, atol=3e-16)


def series(field, points):
    """The potential by the coefficients, with scipy's Legendre functions."""
    from scipy.special import assoc_legendre_p_all

    total = np.zeros(len(points))
    for i, (x, y, z) in enumerate(points):
        r, longitude = np.sqrt(x * x + y * y + z * z), np.arctan2(y, x)
        legendre = assoc_legendre_p_all(field.degree, field.degree, z / r)[0]
        for n, m in zip(*np.tril_indices(field.degree + 1), strict=True):
            wave = field.C[n, m] * np.cos(m * longitude) + field.S[n, m] * np.sin(m * longitude)
            total[i] += field.mass / r * (field.radius / r) ** n * (-1) ** m * legendre[n, m] * wave
    return total


def test_the_series_of_a_field_converges_to_the_polyhedron_at_its_rate(rng):
    mesh = pt.shapes.Mesh(BIPYRAMID, SIDES, mass=1.0)
    directions = rng.normal(size=(20, 3))
    points = 2 * mesh.circumscribing_radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    exact = mesh.potential(points)
    errors = [np.max(np.abs(series(mesh.field(degree), points) / exact - 1)) for degree in (4, 12, 20, 40)]
    assert errors[0] < 2.0**-5
    assert errors[1] / errors[0] < 2.0**-8
    assert errors[2] / errors[1] < 2.0**-8
    assert errors[3] < 1.2e-14


def test_the_field_of_a_mesh_in_a_system_has_the_energy_of_the_whole_polyhedron(rng):
    mesh = pt.shapes.Mesh(BIPYRAMID, SIDES, density=1.0)
    orbit = pt.orbits.FixedPosition(3.0, position=2.5 * mesh.circumscribing_radius * np.array((0.6, 0, 0.8)))
    body = pt.Body.from_shape(mesh)
    system = pt.System(body, pt.forces.HarmonicGravity(orbit, mesh.field(24)))
    attitudes = rng.normal(size=(6, 4))
    attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
    energies = [system.potential_energy(body.state(q, omega_body=(0, 0, 0))) for q in attitudes]
    seen = (
        Rotation.from_quat(attitudes, scalar_first=True)
        .inv()
        .apply(-2.5 * mesh.circumscribing_radius * np.array((0.6, 0, 0.8)))
    )
    exact = -3.0 * mesh.potential(seen)
    np.testing.assert_allclose(np.diff(energies), np.diff(exact), rtol=0, atol=1e-11 * np.ptp(exact))


LUMP = pt.shapes.Mesh(BIPYRAMID / 7.0, SIDES, mass=2.0)
WAYS = np.random.default_rng(12).normal(size=(6, 3))
WAYS /= np.linalg.norm(WAYS, axis=-1, keepdims=True)


def torques_of(force, body, distance):
    """On a body at rest at six places, which are those of the members."""
    orbit = pt.orbits.FixedPosition(np.full(len(WAYS), 1.3), position=-distance * WAYS)
    attitudes = np.tile([1.0, 0, 0, 0], (len(WAYS), 1))
    return pt.System(body, force(orbit)).torque_body(pt.State(attitudes, np.zeros_like(attitudes)))


@pytest.mark.parametrize("ratio", [1.5, 2.0, 4.0, 8.0])
def test_the_torque_of_a_field_converges_to_that_of_the_polyhedron_at_its_rate(ratio):
    """The body gets what the attractor at p loses: -p x F, F the body's pull on it by edges and faces.

    To degree N it misses (R / r)^(N + 1), times coefficients that fall by a quarter a degree, at every distance.
    """
    body, distance, degrees = pt.Body.from_shape(LUMP), ratio * LUMP.circumscribing_radius, np.arange(2, 13)
    scale, rounding = 1.3 * LUMP.mass / distance, 2e-15 * ratio
    exact = -np.cross(distance * WAYS, 1.3 * LUMP.attraction(distance * WAYS))
    series = [
        torques_of(lambda orbit, n=n: pt.forces.HarmonicGravity(orbit, LUMP.field(n)), body, distance) for n in degrees
    ]
    errors = np.array([np.max(np.linalg.norm(found - exact, axis=-1)) for found in series]) / scale
    assert np.all(errors < 0.06 / ratio ** (degrees + 1) + rounding)
    reached = errors > 20 * rounding
    step = np.exp(np.polyfit(degrees[reached], np.log(errors[reached]), 1)[0])
    assert 0.7 / ratio < step < 0.8 / ratio


def computed(shape, degree):
    """The largest torque by the computed field, over the gravity times the distance of 4/3 radii."""
    body, distance = pt.Body.from_shape(shape), 1.2
    found = torques_of(lambda orbit: pt.forces.HarmonicGravity(orbit, shape.field(degree)), body, distance)
    return np.max(np.abs(found)) / (1.3 * shape.mass / distance)


def test_a_sphere_feels_nothing_from_its_computed_field():
    """A polyhedron of an icosahedron's symmetry has nothing below degree 6, and there what it lacks of the sphere."""
    ball = pt.shapes.Ellipsoid((0.9, 0.9, 0.9), mass=2.0)
    assert computed(ball, 8) == 0
    assert computed(ball.moved((0.1, 0.2, 0.3), (0.5, 0.1, -0.7, 0.5)), 8) < 1e-15  # by cubature
    left = []
    for finer in (2, 3, 4):
        sphere = trimesh.creation.icosphere(finer, radius=0.9)
        mesh = pt.shapes.Mesh(sphere.vertices, sphere.faces, mass=2.0)
        assert computed(mesh, 5) < 1e-15
        left.append(computed(mesh, 8))
        lacking = 1 - np.min(np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1), axis=-1)) / 0.9
        assert 0 < left[-1] < 0.1 * lacking
    np.testing.assert_allclose(np.divide(left[:-1], left[1:]), 4, rtol=0.03)


def test_a_shape_in_oblique_axes_moves_as_in_its_principal_axes():
    straight = LUMP.in_principal_axes()
    body, principal = pt.Body.from_shape(LUMP), pt.Body.from_shape(straight)
    turn = Rotation.from_rotvec([0.7, -0.2, 1.1])  # axes of the shape -> space
    omega = np.array([0.3, -0.5, 0.4])
    orbit = pt.KeplerOrbit(
        1.3,
        semimajor_axis=3.0 * LUMP.circumscribing_radius,
        eccentricity=0.2,
        inclination=0.3,
        node=0.5,
        argument_of_periapsis=-0.4,
    )
    times = np.linspace(0, orbit.period, 9)
    oblique, plain = (
        pt.propagate(
            pt.System(b, pt.forces.HarmonicGravity(orbit, shape.field(6))), b.state(attitude, omega_body=rate), times
        )
        for b, shape, attitude, rate in (
            (body, LUMP, turn, omega),
            (principal, straight, turn * LUMP.principal_axes, LUMP.principal_axes.inv().apply(omega)),
        )
    )
    assert np.max(np.abs(LUMP.principal_axes.as_rotvec())) > 0.1
    back = plain.attitude * LUMP.principal_axes.inv()
    assert np.max(np.abs(oblique.attitude.as_matrix() - back.as_matrix())) < 1e-13
    assert np.allclose(oblique.potential_energy, plain.potential_energy, rtol=0, atol=1e-15)
    assert np.allclose(oblique.angular_momentum_space, plain.angular_momentum_space, rtol=0, atol=3e-15)
    assert np.ptp(plain.potential_energy) > 1e-3


def test_a_mesh_of_a_sphere_becomes_the_sphere_with_more_faces():
    apart = []
    for finer in (2, 3, 4):
        ball = trimesh.creation.icosphere(finer)
        mesh, sphere = (
            pt.shapes.Mesh(ball.vertices, ball.faces, density=1.0),
            pt.shapes.Ellipsoid((1, 1, 1), density=1.0),
        )
        apart.append([1 - mesh.volume / sphere.volume, 1 - mesh.inertia[0, 0] / sphere.inertia[0, 0]])
        assert np.max(np.abs(mesh.field(5).C[2:])) < 1e-16  # an icosahedron has nothing below degree 6
        np.testing.assert_allclose(mesh.inertia, mesh.inertia[0, 0] * np.eye(3), rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.divide(apart[:-1], apart[1:]), 4, rtol=0.03)


# ---------------------------------------------------------------------- ellipsoid


def mean_over_ellipsoid(powers, semiaxes):
    """Of x^i y^j z^k, by gamma functions."""
    if any(p % 2 for p in powers):
        return mpmath.mpf(0)
    n = sum(powers)
    ball = mpmath.fprod(mpmath.gamma(mpmath.mpf(p + 1) / 2) for p in powers) / mpmath.gamma(mpmath.mpf(n + 3) / 2)
    ball /= mpmath.gamma(mpmath.mpf(1) / 2) ** 3 / mpmath.gamma(mpmath.mpf(3) / 2)
    return 3 * ball / (n + 3) * mpmath.fprod(mpmath.mpf(a) ** p for a, p in zip(semiaxes, powers, strict=True))


@pytest.mark.parametrize("degree", [2, 4, 10, 16])
def test_stokes_coefficients_of_an_ellipsoid_are_means_of_monomials(degree):
    semiaxes = (1.5, 1.25, 0.5)
    plain = pt.shapes.Ellipsoid(semiaxes, mass=2.0)
    turned = pt.shapes.Ellipsoid((1.25, 0.5, 1.5), mass=2.0).moved(attitude=(0.5, 0.5, 0.5, 0.5))  # by cubature
    (C, S), (c, s) = plain.field(degree).normalized, turned.field(degree).normalized
    for m in range(degree + 1):
        size = mpmath.mpf((2 - (m == 0)) * factorial(degree - m)) / factorial(degree + m)
        with mpmath.workdps(40):
            mean = mpmath.fsum(
                k.numerator * mean_over_ellipsoid(powers, semiaxes) / k.denominator
                for powers, k in ((p, Fraction(k)) for p, k in solid_harmonic(degree, m)[0].items())
            )
            exact = float(size * mean / mpmath.mpf(1.5) ** degree / mpmath.sqrt(size * (2 * degree + 1)))
        assert C[degree, m] == pytest.approx(exact, rel=1e-13, abs=1e-30)
        assert c[degree, m] == pytest.approx(exact, abs=8e-17)
    assert not S.any()
    assert np.max(np.abs(s)) < 5e-17


@pytest.mark.parametrize(
    "point", [(1.6, 0.3, -0.2), (0.1, 0.2, 0.6), (0.0, 0.0, 0.51), (0.4, 0.3, 0.2), (0.0, 1.25, 0.0), (9.0, -20.0, 4.0)]
)
def test_an_ellipsoid_pulls_as_the_integral_of_dirichlet(point):
    semiaxes = (1.5, 1.25, 0.5)
    body = pt.shapes.Ellipsoid(semiaxes, mass=2.0)
    with mpmath.workdps(30):
        squares, x2 = [mpmath.mpf(a) ** 2 for a in semiaxes], [mpmath.mpf(x) ** 2 for x in point]
        outside = sum(x / a for x, a in zip(x2, squares, strict=True)) > 1

        def excess(s):
            return sum(x / (a + s) for x, a in zip(x2, squares, strict=True)) - 1

        start = mpmath.findroot(excess, (0, sum(x2)), solver="anderson") if outside else mpmath.mpf(0)

        def over(value):
            root = lambda s: mpmath.sqrt(mpmath.fprod(a + s for a in squares))  # noqa: E731
            return mpmath.quad(lambda s: value(s) / root(s), [start, start + 1, start + 10, mpmath.inf])

        potential = mpmath.mpf(3) / 4 * 2 * over(lambda s: -excess(s))
        pulls = [-mpmath.mpf(3) / 2 * 2 * x * over(lambda s, k=k: 1 / (squares[k] + s)) for k, x in enumerate(point)]
    assert body.potential(point) == pytest.approx(float(potential), rel=2e-15, abs=0)
    np.testing.assert_allclose(body.attraction(point), [float(pull) for pull in pulls], rtol=4e-15, atol=1e-16)


def test_a_sphere_pulls_as_its_centre_outside_and_less_inside():
    sphere = pt.shapes.Ellipsoid((2.0, 2.0, 2.0), mass=3.0)
    assert sphere.potential((0, 3.0, 4.0)) == pytest.approx(3 / 5, rel=1e-15, abs=0)
    np.testing.assert_allclose(sphere.attraction((0, 3.0, 4.0)), [0, -9 / 125, -12 / 125], rtol=1e-15)
    assert sphere.potential((0, 0, 1.0)) == pytest.approx(3 * (3 * 4 - 1) / (2 * 8), rel=1e-15, abs=0)
    np.testing.assert_allclose(sphere.attraction((0, 0, 1.0)), [0, 0, -3 / 8], rtol=1e-15)


# ---------------------------------------------------------------------- cylinder


@pytest.mark.parametrize("height", [0.0, 0.9, 1.7, 6.0, 50.0])
def test_a_cylinder_pulls_along_its_axis_as_its_closed_form(height):
    radius, half = 0.5, 1.5
    body = pt.shapes.Cylinder(radius, 2 * half, mass=np.pi * radius**2 * 2 * half)
    with mpmath.workdps(30):
        disc = lambda z: 2 * mpmath.pi * (mpmath.sqrt(radius**2 + z * z) - abs(z))  # noqa: E731
        ends = sorted({mpmath.mpf(-half), mpmath.mpf(half), min(max(mpmath.mpf(height), -half), half)})
        potential = mpmath.quad(lambda z: disc(z - height), ends)
    pull = disc(mpmath.mpf(height) + half) - disc(mpmath.mpf(height) - half)
    assert body.potential((0, 0, height)) == pytest.approx(float(potential), rel=1e-13, abs=0)
    np.testing.assert_allclose(body.attraction((0, 0, height)), [0, 0, float(pull)], rtol=2e-12, atol=1e-13)


def test_a_cylinder_pulls_next_to_its_wall_as_brute_force_says():
    body, point = pt.shapes.Cylinder(0.5, 2.0, mass=1.0), np.array((0.7, 0.1, 0.4))
    nodes, gauss = np.polynomial.legendre.leggauss(80)
    square, height = np.meshgrid((nodes + 1) / 2 * 0.25, nodes, indexing="ij")
    angle = 2 * np.pi * (np.arange(320) + 0.25) / 320
    rho = np.sqrt(square)[..., None]
    away = np.stack(np.broadcast_arrays(rho * np.cos(angle), rho * np.sin(angle), height[..., None]), axis=-1) - point
    weights = np.outer(gauss, gauss)[..., None] / 4 / 320
    distance = np.linalg.norm(away, axis=-1)
    assert body.potential(point) == pytest.approx(np.sum(weights / distance), rel=1e-12, abs=0)
    exact = np.einsum("ijk,ijkn->n", weights / distance**3, away)
    np.testing.assert_allclose(body.attraction(point), exact, rtol=8e-13)


@pytest.mark.parametrize("degree", [2, 4, 8])
def test_stokes_coefficients_of_a_cylinder_are_means_of_monomials(degree):
    radius, half = 0.75, 1.25
    C, S = pt.shapes.Cylinder(radius, 2 * half, mass=5.0).field(degree, radius=1.5).normalized
    mean = Fraction(0)
    for (i, j, k), c in solid_harmonic(degree, 0)[0].items():
        if i % 2 == j % 2 == k % 2 == 0:
            ring = Fraction(comb(i, i // 2) * comb(j, j // 2), 2 ** (i + j) * comb((i + j) // 2, i // 2))
            across = ring * Fraction(3, 4) ** (i + j) * Fraction(2, i + j + 2)
            mean += c * across * Fraction(5, 4) ** k / (k + 1)
    assert C[degree, 0] == pytest.approx(
        float(mean / Fraction(3, 2) ** degree) / np.sqrt(2 * degree + 1), rel=1e-13, abs=0
    )
    assert np.max(np.abs(C[degree, 1:])) < 5e-17
    assert np.max(np.abs(S)) < 5e-17
