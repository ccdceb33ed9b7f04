"""Relative equilibria against closed forms: satellites, dumbbells, tops, pendulums, permanent rotations."""

from itertools import permutations, product

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.analysis.equilibrium import equilibria

IDENTITY = (1, 0, 0, 0)
ORBIT = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.0,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
N = np.sqrt(2.0 / 1.5**3)
TO_ORBIT = np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
"""Columns: roll (along the orbit), pitch (along its normal), yaw (along the radius) in radial, transverse, normal."""


def satellite(moments):
    return pt.System(pt.Body(moments), pt.GravityGradient(ORBIT))


def turning(rate):
    return pt.RotatingFrame(IDENTITY, (0, 0, rate))


def axes_of(equilibrium):
    """The frame's axes, each by its components along the body axes, as rows."""
    return Rotation.from_quat(equilibrium.attitude, scalar_first=True).as_matrix()


def moments_along_orbit(moments, equilibrium):
    """The moments about the axes radial, transverse, normal of a body whose axes lie along them."""
    return np.rint(np.abs(axes_of(equilibrium))) @ moments


def assert_same(values, others, tolerance=1e-12):
    np.testing.assert_allclose(np.sort(values), np.sort(others), rtol=0, atol=tolerance)


def random_moments(rng):
    masses = rng.uniform(0.05, 1, 3)
    return masses.sum() - masses


# ---------------------------------------------------------------------- the satellite of DeBra and Delp


def quartic(roll, pitch, yaw):
    """The coefficients of s^4 + b s^2 + c, s in units of the mean motion (DeBra and Delp 1961)."""
    k_roll, k_yaw = (pitch - yaw) / roll, (pitch - roll) / yaw
    return 1 + 3 * k_roll + k_roll * k_yaw, 4 * k_roll * k_yaw


def roots_of(roll, pitch, yaw):
    """Roll-yaw and pitch, s in units of the mean motion."""
    b, c = quartic(roll, pitch, yaw)
    squares = np.array([*np.roots([1, b, c]), -3 * (roll - yaw) / pitch], dtype=complex)
    return np.concatenate([np.sqrt(squares), -np.sqrt(squares)])


def kind_of(roll, pitch, yaw):
    if pitch > roll > yaw:
        return "lyapunov"
    b, c = quartic(roll, pitch, yaw)
    return "linear" if roll > yaw and b > 0 and c > 0 and b * b > 4 * c else "unstable"


def to_second_order(expression, variables):
    terms = sp.Poly(expression, *variables).terms()
    return sum(value * sp.prod(map(sp.Pow, variables, powers)) for powers, value in terms if sum(powers) <= 2)


def test_quartic_follows_from_the_lagrangian():
    """T - U = omega . I omega / 2 - 3/2 n^2 down . I down, to second order in turns about roll, pitch and yaw."""
    roll, pitch, yaw = moments = sp.symbols("roll pitch yaw", positive=True)
    s, angles, rates = sp.Symbol("s"), sp.symbols("a:3"), sp.symbols("v:3")

    def shortened(matrix):
        return matrix.applyfunc(lambda entry: to_second_order(entry, (*angles, *rates)))

    # Axes: along the orbit, against its normal, down; in units of the mean motion the orbit turns at -1 about pitch.
    A, change = sp.eye(3), sp.zeros(3, 3)
    for i in (2, 1, 0):
        axis = sp.Matrix(np.eye(3, dtype=int)[i]).hat()
        turn = sp.eye(3) + angles[i] * axis + angles[i] ** 2 * axis**2 / 2
        change = shortened(change * turn + A * (rates[i] * axis + angles[i] * rates[i] * axis**2))
        A = shortened(A * turn)
    spin = A.T * change
    omega, down = sp.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]]) - A.T[:, 1], A.T[:, 2]
    lagrangian = sum(I * (x**2 - 3 * y**2) / 2 for I, x, y in zip(moments, shortened(omega), down, strict=True))
    lagrangian = to_second_order(lagrangian, (*angles, *rates))
    second = sp.hessian(lagrangian, (*angles, *rates))
    cross = second[3:, :3]
    equations = s**2 * second[3:, 3:] + s * (cross - cross.T) - second[:3, :3]
    b, c = quartic(roll, pitch, yaw)
    expected = roll * pitch * yaw * (s**4 + b * s**2 + c) * (s**2 + 3 * (roll - yaw) / pitch)
    assert sp.expand(equations.det() - expected) == 0


def test_satellite_has_24_equilibria_with_frequencies_of_debra_and_delp(rng):
    for _ in range(6):
        moments = random_moments(rng)
        found = equilibria(satellite(moments), ORBIT.frame)
        assert len(found) == 24
        assert len({tuple(np.rint(axes_of(e)).ravel()) for e in found}) == 24
        for e in found:
            np.testing.assert_allclose(axes_of(e), np.rint(axes_of(e)), rtol=0, atol=2e-15)
            yaw, roll, pitch = moments_along_orbit(moments, e)
            expected = N * roots_of(roll, pitch, yaw)
            for root in expected:
                assert np.min(np.abs(e.eigenvalues - root)) < 2e-14 * max(1, np.max(np.abs(expected)))
            assert_same(e.frequencies, expected.imag[expected.imag > 1e-6], 1e-10)
            assert_same(e.growth_rates, expected.real[expected.real > 1e-6], 1e-10)
            assert e.family == 0


def test_satellite_in_textbook_order():
    system = satellite((1.2, 1.5, 0.6))  # roll, pitch, yaw
    (e,) = equilibria(system, ORBIT.frame, guesses=Rotation.from_matrix(TO_ORBIT))
    pitch = N * np.sqrt(3 * (1.2 - 0.6) / 1.5)
    assert np.min(np.abs(e.frequencies - pitch)) < 1e-14
    assert e.stability == "lyapunov"


def test_stability_regions_over_random_bodies(rng):
    counts = dict.fromkeys(("lyapunov", "linear", "unstable"), 0)
    guess = Rotation.from_matrix(TO_ORBIT)
    for _ in range(150):
        moments = random_moments(rng)
        b, c = quartic(*moments)
        if min(abs(b * b - 4 * c), abs(c), abs(moments[0] - moments[2])) < 1e-6:
            continue
        (e,) = equilibria(satellite(moments), ORBIT.frame, guesses=guess)
        assert e.stability == kind_of(*moments), moments
        assert e.stable == (e.stability != "unstable")
        counts[e.stability] += 1
    assert min(counts.values()) >= 2, counts


def test_debra_delp_region_is_reached():
    """Pitch is the smallest moment, roll the largest; beyond the border of the region oscillations grow."""
    for pitch, kind in ((0.83, "linear"), (0.75, "unstable")):
        moments = 1.35, pitch, 0.855
        (e,) = equilibria(satellite(moments), ORBIT.frame, guesses=Rotation.from_matrix(TO_ORBIT))
        assert e.stability == kind_of(*moments) == kind


@pytest.mark.parametrize("thin", [1e-3, 1e-9])
def test_dumbbell(thin):
    """sqrt(3) in the plane of the orbit and 2 out of it, in units of the mean motion, where it is thin."""
    found = equilibria(satellite((thin, 1.0, 1.0)), ORBIT.frame)
    assert len(found) == 6
    assert {e.family for e in found} == {1}
    along_radius = [e for e in found if abs(axes_of(e)[0, 0]) > 0.5]
    assert len(along_radius) == 2
    for e in along_radius:
        assert e.stability == "lyapunov"
        assert_same(e.frequencies, N * np.sqrt([3 * (1 - thin), 4 - 3 * thin]))
    assert {e.stability for e in found if abs(axes_of(e)[0, 0]) < 0.5} == {"unstable"}


# ---------------------------------------------------------------------- frequencies as they are measured


def measured(signal, step, count):
    """The frequencies of a sum of sinusoids, from the linear recurrence that its samples obey (Prony)."""
    size = 2 * count
    rows = np.stack([signal[i : len(signal) - size + i] for i in range(size + 1)], axis=-1)
    symmetric = [rows[:, i] + rows[:, size - i] for i in range(count)] + [rows[:, count]]
    solution = np.linalg.lstsq(np.stack(symmetric[1:], axis=-1), -symmetric[0], rcond=None)[0]
    coefficients = np.array([1, *solution, *solution[-2::-1], 1])
    return np.sort(np.abs(np.angle(np.roots(coefficients))))[::2] / step


def libration(system, equilibrium, frame, tilt, step, samples=400):
    """The small turns of a body from an equilibrium, which it leaves at rest: twice the vector of p0~ p."""
    p0 = Rotation.from_quat(equilibrium.attitude, scalar_first=True)
    start = system.body.state(p0 * Rotation.from_rotvec(tilt), omega_body=(0, 0, 0), frame=frame)
    motion = pt.propagate(system, start, step * np.arange(samples))
    p = Rotation.from_quat(motion.relative_to(frame).quaternion, scalar_first=True)
    return (p0.inv() * p).as_rotvec()


@pytest.mark.parametrize("moments", [(1.2, 1.5, 0.6), (1.35, 0.83, 0.855)], ids=["Lagrange", "DeBra-Delp"])
def test_frequencies_of_librations_in_orbit(moments):
    system = satellite(moments)
    (e,) = equilibria(system, ORBIT.frame, guesses=Rotation.from_matrix(TO_ORBIT))
    step = 0.4 / max(e.frequencies)
    pitch = measured(libration(system, e, ORBIT.frame, (0, 1e-5, 0), step)[:, 1], step, 1)
    roll_yaw = measured(libration(system, e, ORBIT.frame, (1e-5, 0, 2e-5), step)[:, 0], step, 2)
    np.testing.assert_allclose(np.sort([*pitch, *roll_yaw]), e.frequencies, rtol=1e-8)


def test_frequencies_of_a_hanging_body():
    system = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1.0, 0.2, -0.3)))
    e = next(e for e in equilibria(system) if e.stable)
    rest = pt.RotatingFrame(IDENTITY, (0, 0, 0))
    down = axes_of(e).T @ (0, 0, -1)
    tilt = np.cross(down, (1, 2, 3)) * 1e-5
    # A body that swings also turns about the vertical, at a rate of second order only; the signal has no part of it.
    signal = libration(system, e, rest, tilt, 0.4) @ np.cross(down, (3, -1, 1))
    np.testing.assert_allclose(measured(signal, 0.4, 2), e.frequencies, rtol=1e-6)


def test_frequencies_of_a_sleeping_top():
    frame = turning(2.3)
    system = pt.System(pt.Body((1, 1, 0.5)), pt.UniformGravity(0.5, (0, 0, 0.5)))
    (e,) = equilibria(system, frame, guesses=IDENTITY)
    signal = libration(system, e, frame, (1e-5, 0, 0), 0.3)[:, 0]
    np.testing.assert_allclose(measured(signal, 0.3, 2), e.frequencies, rtol=5e-9)


# ---------------------------------------------------------------------- tops and pendulums


@pytest.mark.parametrize("ratio", [0.3, 0.98, 1 - 1e-6, 1 + 1e-6, 1.02, 3.0])
@pytest.mark.parametrize(("A", "C"), [(1.0, 0.5), (1.3, 1.7)])
def test_sleeping_top_is_stable_above_its_limit(A, C, ratio):
    weight, height = 0.8, 0.7
    spin = np.sqrt(ratio * 4 * A * weight * height) / C  # (C w)^2 = ratio 4 A M g l
    system = pt.System(pt.Body((A, A, C)), pt.UniformGravity(weight, (0, 0, height)))
    (e,) = equilibria(system, turning(spin), guesses=IDENTITY)
    assert e.stable == (ratio > 1)
    # A z'' - i C w z' - M g l z = 0 in space; the frame turns at w.
    roots = 1j * np.roots([A, -C * spin, weight * height]) - 1j * spin
    roots = np.concatenate([roots, roots.conj()])
    assert_same(e.frequencies, roots.imag[roots.imag > 1e-6], 1e-9)
    assert_same(e.growth_rates, roots.real[roots.real > 1e-6], 1e-9)
    assert e.family == 1


def test_sleeping_top_is_proven_stable_by_energy_where_it_spins_about_its_short_axis():
    weight, height, A, C = 0.8, 0.7, 1.0, 1.6
    for factor, kind in ((0.99, "linear"), (1.01, "lyapunov")):
        spin = np.sqrt(factor * weight * height / (C - A))
        system = pt.System(pt.Body((A, A, C)), pt.UniformGravity(weight, (0, 0, height)))
        (e,) = equilibria(system, turning(spin), guesses=IDENTITY)
        assert e.stability == kind


def test_sleeping_top_at_its_limit_is_undecided():
    system = pt.System(pt.Body((1, 1, 0.5)), pt.UniformGravity(0.5, (0, 0, 0.5)))
    (e,) = equilibria(system, turning(2.0), guesses=IDENTITY)
    assert (e.stability, e.stable) == ("undecided", False)


def test_pendulum_of_any_body():
    """Small oscillations about a fixed point: the generalised eigenvalues of stiffness and inertia."""
    inertia = np.array([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
    center, weight = np.array([0.3, -0.2, 0.5]), 0.7
    hanging, upright = equilibria(pt.System(pt.Body.from_inertia(inertia), pt.UniformGravity(weight, center)))
    lever = np.linalg.norm(center)
    across = np.eye(3) - np.outer(center, center) / lever**2
    squares = np.linalg.eigvals(np.linalg.solve(inertia, weight * lever * across)).real
    rates = np.sort(np.sqrt(np.abs(squares)))[1:]
    if not hanging.stable:
        hanging, upright = upright, hanging
    np.testing.assert_allclose(hanging.frequencies, rates, rtol=4e-15)
    np.testing.assert_allclose(upright.growth_rates, rates, rtol=4e-15)
    assert (hanging.stability, upright.stability) == ("lyapunov", "unstable")


def test_body_at_rest_near_an_attractor():
    moments, mu, position = (1.0, 1.3, 1.6), 0.9, np.array([0.8, -0.5, 0.7])
    found = equilibria(pt.System(pt.Body(moments), pt.GravityGradient(pt.orbits.FixedPosition(mu, position=position))))
    assert len(found) == 6  # each axis either way, and any angle about it
    strength, direction = 3 * mu / np.linalg.norm(position) ** 3, position / np.linalg.norm(position)
    for e in found:
        radial = axes_of(e).T @ direction
        i = int(np.argmax(np.abs(radial)))
        assert abs(radial[i]) == pytest.approx(1, abs=1e-12)
        squares = [strength * (moments[j] - moments[i]) / moments[3 - i - j] for j in range(3) if j != i]
        assert_same(e.frequencies, [np.sqrt(x) for x in squares if x > 0])
        assert_same(e.growth_rates, [np.sqrt(-x) for x in squares if x < 0])
        assert e.stability == ("lyapunov" if i == 0 else "unstable")


# ---------------------------------------------------------------------- permanent rotations


@pytest.mark.parametrize("moments", list(permutations((1.0, 2.0, 2.5))))
def test_permanent_rotations_of_a_free_body(moments):
    spin = 0.7
    found = equilibria(pt.System(pt.Body(moments)), turning(spin))
    assert len(found) == 6
    for e in found:
        vertical = axes_of(e)[2]
        i = int(np.argmax(np.abs(vertical)))
        I, J, K = (moments[(i + k) % 3] for k in range(3))
        G = I * spin
        square = (G / I) ** 2 * (I - J) * (I - K) / (J * K)
        kind = {max(moments): "lyapunov", min(moments): "linear"}.get(I, "unstable")
        assert e.stability == kind
        if kind == "unstable":
            middle, small, large = I, min(moments), max(moments)
            rate = G * np.sqrt((1 / small - 1 / middle) * (1 / middle - 1 / large))
            assert_same(e.growth_rates, [rate])
        else:
            assert_same(e.frequencies, [np.sqrt(square), spin])


@pytest.mark.parametrize("spin", [0.3, 1.0, 1.7, 4.0])
def test_permanent_rotations_of_a_heavy_body(spin):
    """Staude's: the vertical b along the body makes M g c . b - w^2 b . I b / 2 stationary on the sphere.

    b = M g (mu + w^2 I)^-1 c, with mu a root of |b|^2 = 1: a polynomial of degree six.
    """
    moments, weight, center = np.array([1.25, 1.0, 0.75]), 0.5, np.array([1.0, 0.2, -0.3])
    shifts = spin**2 * moments
    squares = [np.polynomial.Polynomial([shift, 1]) ** 2 for shift in shifts]
    secular = np.prod(squares) - sum(
        (weight * center[i]) ** 2 * squares[(i + 1) % 3] * squares[(i + 2) % 3] for i in range(3)
    )
    roots = secular.roots()
    multipliers = roots.real[np.abs(roots.imag) < 1e-6]
    for _ in range(3):  # Newton on the equation itself, better conditioned than the polynomial
        sizes = np.sum((weight * center) ** 2 / (multipliers[:, None] + shifts) ** 2, axis=-1)
        slopes = -2 * np.sum((weight * center) ** 2 / (multipliers[:, None] + shifts) ** 3, axis=-1)
        multipliers = multipliers - (sizes - 1) / slopes
    verticals = np.array([weight * center / (mu + shifts) for mu in multipliers])
    found = equilibria(pt.System(pt.Body(moments), pt.UniformGravity(weight, center)), turning(spin))
    assert len(found) == len(verticals)
    own = np.array([axes_of(e)[2] for e in found])
    distance = np.linalg.norm(own[:, None] - verticals, axis=-1)
    assert np.max(np.min(distance, axis=0)) < 2e-13
    for e, vertical, multiplier in zip(found, own, multipliers[np.argmin(distance, axis=1)], strict=True):
        across = np.linalg.svd(vertical[None])[2][1:]
        curvature = np.linalg.eigvalsh(across @ np.diag(-shifts - multiplier) @ across.T)
        assert (e.stability == "lyapunov") == bool(np.all(curvature > 0))


def test_oblique_body_has_the_same_frequencies():
    turn = Rotation.from_rotvec((0.3, -0.5, 0.8)).as_matrix()
    moments = (1.0, 1.3, 1.6)
    oblique = pt.System(pt.Body.from_inertia(turn @ np.diag(moments) @ turn.T), pt.GravityGradient(ORBIT))
    found, others = equilibria(oblique, ORBIT.frame), equilibria(satellite(moments), ORBIT.frame)
    assert len(found) == len(others) == 24
    for e, (one, other) in product(found, [(e, axes_of(e)) for e in others]):
        if np.max(np.abs(axes_of(e) @ turn - other)) < 1e-6:
            assert_same(e.frequencies, one.frequencies)
            assert e.stability == one.stability
            break
    else:
        pytest.fail("no equilibrium lies along the principal axes")
