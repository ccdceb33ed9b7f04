"""Chaos indicators against independent integrations, closed forms and published exponents."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt

ECCENTRICITY = 0.123233
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=ECCENTRICITY)
HYPERION = pt.Body.from_ratios(beta=0.47, gamma=0.26)
SPIN_ORBIT = pt.System(HYPERION, pt.GravityGradient(ORBIT))
A, B, C = HYPERION.moments
YEAR = 2 * np.pi


def in_plane(angle, rate):
    """States with the long axis at an angle from the periapsis, where they are at t = 0."""
    angle, rate = np.broadcast_arrays(angle, rate)
    zero = np.zeros_like(angle)
    q = np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=-1)
    return HYPERION.state(q, omega_body=np.stack([zero, zero, rate], axis=-1))


def spin_orbit_with_its_variation(angle, rate, vector, momentum_unit, times):
    """ln |u|, Y and its mean: theta'' = -3 (B - A)/(2 C r^3) sin 2(theta - f), its variation, int t dg, int Y dt."""
    strength, e, sense = 3 * (B - A) / C, ECCENTRICITY, np.sign(times[-1])

    def rates(time, y):
        theta, omega, f, angle, speed, moment, _ = y
        inverse = (1 + e * np.cos(f)) / (1 - e**2)
        change = np.array([speed, -strength * inverse**3 * np.cos(2 * (theta - f)) * angle])
        u = np.array([angle, C * speed / momentum_unit])
        growing = u @ (change * [1, C / momentum_unit]) / (u @ u)
        return [
            omega,
            -strength / 2 * inverse**3 * np.sin(2 * (theta - f)),
            np.sqrt(1 - e**2) * inverse**2,
            *change,
            growing * time,
            2 * moment / time if time else 0.0,
        ]

    begin = [angle, rate, 0.0, vector[0], vector[1] * momentum_unit / C, 0.0, 0.0]
    grid = {"t_eval": times, "method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    found = solve_ivp(rates, (0.0, times[-1]), begin, first_step=1e-6, **grid).y
    growth = np.log(np.hypot(found[3], C * found[4] / momentum_unit))
    return growth, 2 * found[5] / times, sense * found[6] / np.abs(times)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("angle", "rate", "chaotic"), [(0.2, 2.9, False), (0.1, 0.35, False), (0.01, 1.0, True)])
def test_growth_and_megno_of_the_spin_orbit_problem(angle, rate, chaotic, sense):
    times = sense * np.array([0.3, 2.0, 5.5, 8.0, 12.0]) * YEAR
    found = pt.analysis.chaos_indicators(SPIN_ORBIT, in_plane(angle, rate), times, formulation="planar")
    reference = spin_orbit_with_its_variation(angle, rate, found.vectors[0], found.momentum_unit, times)
    growth, megno, mean = reference
    assert (growth[-1] > 6) == chaotic
    np.testing.assert_allclose(found.growth, growth, rtol=0, atol=3e-7 if chaotic else 1e-10)
    np.testing.assert_allclose(found.lyapunov, growth / np.abs(times), rtol=0, atol=4e-10)
    errors = np.abs([found.megno - megno, found.mean_megno - mean]) / np.maximum(2.0, np.abs(megno))
    assert np.all(errors[:, 0] < 0.03)
    assert np.all(errors[:, 1:] < 5e-3)


def test_growth_in_space_against_neighbours_in_wide_precision():
    start = HYPERION.state((0.5, 0.1, -0.7, 0.5), omega_body=(0.3, -0.8, 1.1))
    times, h = np.array([1.0, 6.0, 15.0]), 1e-5
    found = pt.analysis.chaos_indicators(SPIN_ORBIT, start, times, vectors=2)
    q0, g0 = Rotation.from_quat(start.quaternion, scalar_first=True), start.angular_momentum_body
    ends = []
    for u in h * found.vectors:
        pair = [
            pt.propagate(
                SPIN_ORBIT,
                HYPERION.state(q0 * Rotation.from_rotvec(sign * u[:3]), angular_momentum_body=g0 + sign * u[3:] * unit),
                times,
                precision="quadruple",
            )
            for unit in [found.momentum_unit]
            for sign in (1, -1)
        ]
        turn = (pair[1].attitude.inv() * pair[0].attitude).as_rotvec()
        change = (pair[0].angular_momentum_body - pair[1].angular_momentum_body) / found.momentum_unit
        ends.append(np.concatenate([turn, change], axis=-1) / (2 * h))
    lengths = np.linalg.norm(ends, axis=-1)
    np.testing.assert_allclose(found.growth, np.log(lengths[0]), rtol=0, atol=5e-9)
    cosine = np.sum(ends[0] * np.array(ends[1]), axis=-1) / np.prod(lengths, axis=0)
    np.testing.assert_allclose(found.gali, np.sqrt(1 - cosine**2), rtol=1e-6)


# ---------------------------------------------------------------------- closed forms

KOVALEVSKAYA = pt.System(pt.Body((2.0, 2.0, 1.0)), pt.UniformGravity(1.0, (0.7, 0.0, 0.0)))
LAGRANGE = pt.System(pt.Body((1.0, 1.0, 0.6)), pt.UniformGravity(1.0, (0.0, 0.0, 0.5)))
FREE = pt.System(pt.Body((1.0, 1.5, 2.0)))
TILTED = (0.8, 0.5, -0.2, np.sqrt(1 - 0.93))


@pytest.mark.parametrize(
    ("system", "attitude", "rates"),
    [
        (FREE, TILTED, (0.4, 0.3, 1.0)),
        (LAGRANGE, TILTED, (0.3, -0.4, 2.5)),
        (LAGRANGE, (1, 0, 0, 0), (0.0, 0.0, 4.0)),
        (KOVALEVSKAYA, TILTED, (0.5, 0.2, 0.9)),
        (KOVALEVSKAYA, TILTED, (-0.9, 0.6, 2.0)),
    ],
    ids=["free", "Lagrange", "sleeping", "Kovalevskaya", "Kovalevskaya, fast"],
)
def test_integrable_motions_are_regular(system, attitude, rates):
    start = system.body.state(attitude, omega_body=rates)
    times = np.geomspace(10, 3000, 40)
    found = pt.analysis.chaos_indicators(system, start, times)
    assert abs(found.mean_megno[-1] - 2) < 0.06
    slope = np.polyfit(np.log(times[15:]), found.growth[15:], 1)[0]
    assert abs(slope - 1) < 0.2
    assert found.lyapunov[-1] < 1.6 * np.log(3000) / 3000


def unstable_motions():
    """Systems, starts, exponents and their number: about the middle axis; upright tops that spin too slowly."""
    I1, I2, I3 = FREE.body.moments
    middle = 1.3 * np.sqrt((I2 - I1) * (I3 - I2) / (I1 * I3))
    yield FREE, FREE.body.state((1, 0, 0, 0), omega_body=(0, 1.3, 0)), middle, 1
    J, _, axial = LAGRANGE.body.moments
    slow = np.sqrt(0.5 / J - (axial * 1.2 / (2 * J)) ** 2)
    yield LAGRANGE, LAGRANGE.body.state((1, 0, 0, 0), omega_body=(0, 0, 1.2)), slow, 2


@pytest.mark.parametrize(
    ("system", "start", "exponent", "count"), list(unstable_motions()), ids=["middle axis", "upright"]
)
def test_unstable_equilibria_have_the_exponent_of_linear_theory(system, start, exponent, count):
    times = np.array([40.0, 240.0]) / exponent
    found = pt.analysis.chaos_indicators(system, start, times)
    assert np.diff(found.growth)[0] == pytest.approx(200, rel=1e-3)
    assert found.megno[-1] == pytest.approx(240, rel=0.02)
    assert found.mean_megno[-1] == pytest.approx(120, rel=0.02)
    spectrum = pt.analysis.lyapunov_spectrum(system, start, times).exponents
    from_first_to_last = (spectrum[1] * times[1] - spectrum[0] * times[0]) / (times[1] - times[0])
    expected = exponent * np.array([1] * count + [0] * (6 - 2 * count) + [-1] * count)
    np.testing.assert_allclose(from_first_to_last, expected, rtol=0, atol=0.03 * exponent)
    np.testing.assert_allclose(from_first_to_last[[0, -1]], expected[[0, -1]], rtol=2e-13)


@pytest.mark.parametrize("coefficient", [0.0, 0.03])
def test_the_sum_of_a_spectrum_is_the_divergence_of_the_flow(coefficient):
    body = pt.Body((1.25, 1.0, 0.75))
    system = pt.System(body, pt.UniformGravity(0.5, (1, 0.2, -0.3)), pt.forces.LinearDamping(coefficient))
    start = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    spectrum = pt.analysis.lyapunov_spectrum(system, start, [30.0, 60.0, 200.0])
    divergence = -coefficient * np.sum(1 / np.array(body.moments))
    np.testing.assert_allclose(np.sum(spectrum.exponents, axis=-1), divergence, rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- chaos


def test_hyperion_has_the_published_exponent():
    """Case 8 of the external cases: 0.75 to 0.95 in an orbit, the mean over neighbouring starts."""
    starts = in_plane(0.01 + np.linspace(-1e-3, 1e-3, 100), 1.0)
    found = pt.analysis.chaos_indicators(SPIN_ORBIT, starts, [100 * YEAR], formulation="planar", tolerance=1e-12)
    assert 0.75 < np.mean(found.lyapunov) * YEAR < 0.95
    assert np.mean(found.mean_megno / found.growth) == pytest.approx(0.5, abs=0.1)


def test_a_chaotic_top_has_one_pair_of_exponents():
    """Energy and the vertical momentum are conserved: four exponents of six are zero."""
    system = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1, 0.2, -0.3)))
    start = system.body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    times = np.array([500.0, 2000.0])
    spectrum = pt.analysis.lyapunov_spectrum(system, start, times).exponents
    np.testing.assert_allclose(spectrum, -spectrum[:, ::-1], rtol=0, atol=0.01)
    found = pt.analysis.chaos_indicators(system, start, times)
    np.testing.assert_allclose(spectrum[:, 0], found.lyapunov, rtol=0, atol=0.03)  # the scatter of neighbouring starts
    assert spectrum[-1, 0] > 0.03
    assert np.all(np.abs(spectrum[-1, 1:5]) < 0.006)


def test_a_thousand_orbits_of_chaos_are_twice_five_hundred():
    starts = in_plane(0.01 + np.linspace(-1e-3, 1e-3, 24), 1.0)
    half, whole = 500 * YEAR, 1000 * YEAR
    options = {"formulation": "planar", "tolerance": 1e-12}
    found = pt.analysis.chaos_indicators(SPIN_ORBIT, starts, [half, whole], **options)
    assert np.all(np.isfinite(found.growth))
    assert np.max(found.growth) > 750  # the vectors have grown beyond the largest float
    middle = pt.propagate(SPIN_ORBIT, starts, [half], formulation="planar", tolerance=1e-12)
    again = pt.State(middle.quaternion[:, 0], middle.conjugate_momenta[:, 0], half)
    second = pt.analysis.chaos_indicators(SPIN_ORBIT, again, [whole], **options)
    halves = np.concatenate([found.lyapunov[:, 0], second.lyapunov[:, 0]])
    error = np.std(halves) / np.sqrt(halves.size)
    assert abs(np.mean(found.lyapunov[:, 1]) - np.mean(halves)) < 3 * np.sqrt(2) * error
    assert error < 0.05 * np.mean(halves)


def test_gali_of_two_vectors_in_the_plane():
    """Their area is that at the start over the product of their lengths: t^-2, or exp(-2 lambda t)."""
    times = np.geomspace(3, 300, 30) * YEAR
    regular, chaotic = (
        pt.analysis.chaos_indicators(SPIN_ORBIT, in_plane(angle, rate), span, vectors=2, formulation="planar")
        for angle, rate, span in ((0.2, 2.9, times), (0.01, 1.0, np.arange(1, 16) * YEAR))
    )
    assert np.polyfit(np.log(times), np.log(regular.gali), 1)[0] == pytest.approx(-2, abs=0.1)
    assert np.all(np.abs(np.log(chaotic.gali) + 2 * chaotic.growth) < 4)
    assert chaotic.gali[-1] < 1e-7


def test_gali_in_space_stays_where_motion_is_regular():
    start = LAGRANGE.body.state(TILTED, omega_body=(0.3, -0.4, 2.5))
    times = np.geomspace(10, 3000, 20)
    pair, all_six = (pt.analysis.chaos_indicators(LAGRANGE, start, times, vectors=count) for count in (2, 6))
    assert np.polyfit(np.log(times[5:]), np.log(pair.gali[5:]), 1)[0] == pytest.approx(0, abs=0.1)
    assert np.polyfit(np.log(times[5:]), np.log(all_six.gali[5:]), 1)[0] == pytest.approx(-6, abs=0.5)
    tumbling = HYPERION.state((0.5, 0.1, -0.7, 0.5), omega_body=(0.3, -0.8, 1.1))
    chaotic = pt.analysis.chaos_indicators(SPIN_ORBIT, tumbling, [90 * YEAR], vectors=2)
    assert chaotic.gali[0] < 1e-8 * np.min(pair.gali)
