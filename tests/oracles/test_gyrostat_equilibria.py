"""All equilibria of a gyrostat on a circular orbit, against closed forms and an algebraic count of another kind.

With R, T, N the unit vectors radial, transverse and normal along the body axes and h the rotors' momentum over the mean
motion, a body at rest in the orbital frame feels the torque (I N + h) x N + 3 R x I R, which vanishes where
W = (3 R.I R - N.I N)/2 - h.N is stationary. Gutnik and Sarychev count 8 to 24 such attitudes, 4 to 2 of them stable;
Sarychev, Mirer and Degtyarev (2004, Keldysh preprint 46) have all for a rotor along a principal axis.
"""

from itertools import combinations_with_replacement

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.analysis.equilibrium import equilibria
from poinsot.parts import Gyrostat

ORBIT = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1, argument_of_periapsis=-0.7)
RATE = np.sqrt(2.0 / 1.5**3)


def found_with(moments, rotors):
    """The equilibria for a momentum of the rotors in units of the mean motion."""
    system = pt.System(pt.Body(moments), Gyrostat(RATE * np.asarray(rotors)), pt.GravityGradient(ORBIT))
    return equilibria(system, ORBIT.frame)


def axes_of(equilibrium):
    """R, T, N along the body axes, as rows."""
    return Rotation.from_quat(equilibrium.attitude, scalar_first=True).as_matrix()


def torque(axes, moments, rotors):
    R, _, N = axes
    return np.cross(moments * N + rotors, N) + 3 * np.cross(R, moments * R)


def random_moments(rng):
    masses = rng.uniform(0.2, 1, 3)
    return masses.sum() - masses


# ---------------------------------------------------------------------- a rotor along a principal axis


def with_rotor_along(k, moments, h):
    """All (R, T, N) of a rotor along the principal axis k: N along it, or R or T along another one and N oblique."""
    e = np.eye(3)
    others = [i for i in range(3) if i != k]
    out = []
    for along in (e[k], -e[k]):
        out += [(s * e[i], s * np.cross(along, e[i]), along) for i in others for s in (1, -1)]
    for i, j in (others, others[::-1]):
        for factor in (1, 4):  # R, then T, along +- e_i
            cosine = h / (factor * (moments[j] - moments[k]))
            if abs(cosine) >= 1:
                continue
            for sine in (np.sqrt(1 - cosine**2), -np.sqrt(1 - cosine**2)):
                N = cosine * e[k] + sine * e[j]
                ways = [(s * e[i], s * np.cross(N, e[i]), N) for s in (1, -1)]
                out += ways if factor == 1 else [(np.cross(R, N), R, N) for R, _, _ in ways]
    return np.array(out)


def test_the_closed_forms_solve_the_equations():
    rng = np.random.default_rng(1)
    for k in range(3):
        moments, h = random_moments(rng), 0.05
        for axes in with_rotor_along(k, moments, h):
            np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-15)
            assert np.linalg.det(axes) > 0
            np.testing.assert_allclose(torque(axes, moments, h * np.eye(3)[k]), 0, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("k", "part", "count"), [(0, 0.5, 24), (1, 0.9, 24), (2, 1.1, 20), (2, -1.1, 20)])
def test_rotor_along_a_principal_axis(k, part, count):
    moments = np.array([1.7, 1.4, 0.8])
    h = part * np.min(np.abs(np.delete(moments, k) - moments[k]))
    expected = with_rotor_along(k, moments, h)
    found = np.array([axes_of(e) for e in found_with(moments, h * np.eye(3)[k])])
    assert len(found) == len(expected) == count
    distances = np.max(np.abs(found[:, None] - expected), axis=(-1, -2))
    assert np.max(np.min(distances, axis=0)) < 1.5e-14


def test_boundaries_of_the_regions():
    """Four less beyond |h| = |I_j - I_k| and beyond 4 |I_j - I_k|, for both other axes j."""
    moments = np.array([1.7, 1.4, 0.8])
    for limit, count in ((0.3, 24), (0.9, 20), (1.2, 16), (3.6, 12)):
        for h, expected in ((limit * (1 - 1e-4), count), (limit * (1 + 1e-4), count - 4)):
            assert len(found_with(moments, (h, 0.0, 0.0))) == expected


# ---------------------------------------------------------------------- any rotor


def monomials(degree):
    return list(combinations_with_replacement(range(4), degree))


def stationary_attitudes(moments, rotors):
    """All real unit quaternions, one of each pair, at which W is stationary, by Macaulay's matrix.

    W is a quartic form in q. Where q is parallel to its gradient, the six minors of the two vanish. Their multiples by
    all monomials span all polynomials of degree 9 but as many as there are solutions in complex projective space;
    what multiplies by q1/q0, ... on that space has the solutions as eigenvalues.
    """
    q = sympy.symbols("q:4")
    a, b, c, d = q
    R = (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c))
    N = (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d)
    square = a * a + b * b + c * c + d * d
    W = sum(m * (3 * x * x - z * z) / 2 - h * z * square for m, h, x, z in zip(moments, rotors, R, N, strict=True))
    slopes = [sympy.diff(W, x) for x in q]
    minors = [sympy.Poly(q[i] * slopes[j] - q[j] * slopes[i], *q) for i in range(4) for j in range(i)]
    degree = 9
    columns = {powers_of(places): n for n, places in enumerate(monomials(degree))}
    rows = []
    for minor in minors:
        terms = [(np.array(powers), float(value)) for powers, value in minor.terms()]
        for places in monomials(degree - 4):
            row = np.zeros(len(columns))
            for powers, value in terms:
                row[columns[tuple(powers + powers_of(places))]] += value
            rows.append(row / np.linalg.norm(row))
    _, sizes, right = np.linalg.svd(np.array(rows))
    count = len(columns) - int(np.sum(sizes > 1e-9))
    assert sizes[len(columns) - count - 1] > 1e3 * sizes[len(columns) - count]
    null = right[-count:].T
    lower = [np.array(powers_of(places)) for places in monomials(degree - 1)]
    shifts = [np.array([null[columns[tuple(powers + np.eye(4, dtype=int)[i])]] for powers in lower]) for i in range(4)]
    mixed = np.tensordot((0.31, -0.52, 0.73, 0.29), shifts, axes=1)  # zero at no solution
    inverse = np.linalg.pinv(mixed)
    _, vectors = np.linalg.eig(inverse @ np.tensordot((0.61, 0.42, -0.33, 0.57), shifts, axes=1))
    ratios = np.array([np.diag(np.linalg.solve(vectors, inverse @ shift @ vectors)) for shift in shifts]).T
    real = ratios[np.max(np.abs(ratios.imag), axis=1) < 1e-6 * np.max(np.abs(ratios), axis=1)].real
    return count, real / np.linalg.norm(real, axis=1, keepdims=True)


def powers_of(places):
    return tuple(np.bincount(places, minlength=4)) if len(places) else (0, 0, 0, 0)


@pytest.mark.parametrize("size", [0.05, 0.3, 0.6, 3.0])
def test_none_is_missed(size):
    rng = np.random.default_rng(int(100 * size))
    moments, direction = random_moments(rng), rng.normal(size=3)
    rotors = size * direction / np.linalg.norm(direction)
    count, expected = stationary_attitudes(moments, rotors)
    found = found_with(moments, rotors)
    assert count == 40  # 16 on q.q = 0, which are never real
    assert len(found) == len(expected)
    nearest = np.max(np.abs(expected @ np.array([e.attitude for e in found]).T), axis=1)
    assert np.max(1 - nearest) < 2e-15


def index_of(axes, moments, rotors):
    """How many negative directions W has there, by differences of its gradient, the torque with the other sign."""
    step, slopes = 1e-5, []
    for turn in step * np.eye(3):
        ahead, behind = (axes @ Rotation.from_rotvec(s * turn).as_matrix() for s in (1, -1))
        slopes.append((torque(behind, moments, rotors) - torque(ahead, moments, rotors)) / (2 * step))
    return int(np.sum(np.linalg.eigvalsh(np.array(slopes) + np.transpose(slopes)) < 0))


def test_the_numbers_of_minima_and_saddles_are_those_of_morse():
    """On RP^3 those of index 0 to 3 are at least 1, 1, 1, 1, and the alternating sum is 0; minima are proven stable."""
    rng = np.random.default_rng(7)
    for size in (0.0, 0.1, 0.4, 1.0, 4.0):
        moments, rotors = random_moments(rng), size * rng.normal(size=3)
        found = found_with(moments, rotors)
        counts = [0, 0, 0, 0]
        for e in found:
            np.testing.assert_allclose(torque(axes_of(e), moments, rotors), 0, rtol=0, atol=1e-14 * (1 + size))
            counts[index := index_of(axes_of(e), moments, rotors)] += 1
            assert (e.stability == "lyapunov") == (index == 0)
        assert min(counts) >= 1
        assert counts[0] - counts[1] + counts[2] - counts[3] == 0
        assert 8 <= len(found) <= 24
        assert 2 <= counts[0] <= 4


@pytest.mark.parametrize(("size", "count", "stable"), [(1e-6, 24, 4), (30.0, 8, 2), (1e3, 8, 2)])
@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_slow_and_fast_rotors_in_other_units(size, count, stable, unit):
    orbit = pt.KeplerOrbit(1e-6, semimajor_axis=1.0, eccentricity=0.0, inclination=0.4)
    rotors = Gyrostat(unit * size * orbit.mean_motion * np.array([0.6, 0.48, 0.64]))
    system = pt.System(pt.Body(unit * np.array([2.0, 1.5, 1.0])), rotors, pt.GravityGradient(orbit))
    kinds = [e.stability for e in equilibria(system, orbit.frame)]
    assert (len(kinds), kinds.count("lyapunov"), kinds.count("unstable")) == (count, stable, count - stable)


def test_it_stays_for_some_orbits():
    moments, rotors = np.array([1.7, 1.4, 0.8]), np.array([0.2, -0.3, 0.25])
    system = pt.System(pt.Body(moments), Gyrostat(RATE * rotors), pt.GravityGradient(ORBIT))
    stable = [e for e in found_with(moments, rotors) if e.stability == "lyapunov"]
    assert len(stable) >= 2
    for e in stable:
        motion = pt.propagate(system, e.state, np.linspace(0, 5 * 2 * np.pi / RATE, 11))
        p = motion.relative_to(ORBIT.frame).quaternion
        assert np.max(1 - np.abs(p @ e.attitude)) < 1e-14
        assert np.max(np.abs(motion.drift["jacobi_energy"])) < 6e-15
