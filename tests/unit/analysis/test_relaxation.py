"""The averaged loss of energy inside a tumbling body."""

import itertools

import numpy as np
import pytest

import poinsot as pt
from poinsot.analysis import InelasticRelaxation
from poinsot.analysis.relaxation import ODD, _elasticity
from poinsot.parts import CreepingTide

VOLUME = 4 / 3 * np.pi
SEMIAXES = np.array([1.1, 0.8, 0.6])
BODY = pt.Body.from_ellipsoid(VOLUME * np.prod(SEMIAXES), SEMIAXES)
LOVE = 2 * np.pi / 171
"""Elastic energy of an incompressible sphere that rotates, less that of its mean pressure, in rho^2 R^7 w^4 / mu.

The surface rises by h2 U / g, h2 = 5 rho g R / (19 mu), under the part of degree two of the centrifugal potential (Love
1911, Some Problems of Geodynamics): half the work of it, U2 = -w^2 R^2 / 3 at the pole, <P2^2> = 1/5.
"""


def test_a_rotating_sphere_has_the_energy_of_love():
    axes = (1 + 1e-9, 1.0, 1 - 1e-9)
    relaxation = InelasticRelaxation(pt.Body.from_ellipsoid(VOLUME, axes), 1.0, 1.0, poisson_ratio=0.4999999)
    # Compressible by 2e-7 of its rigidity, which counts some times.
    assert relaxation._compliance[2, 2] / 2 == pytest.approx(LOVE, rel=1e-5)
    # A product of two rates is two squares at half a right angle: (w1^2 - w2^2) / 2 turned, three times a square.
    assert relaxation._compliance[5, 5] == pytest.approx(12 * LOVE / 2, rel=1e-5)


def strain_at(displacement, x, step=1e-4):
    gradient = np.array([(displacement(x + e) - displacement(x - e)) / (2 * step) for e in step * np.eye(3)]).T
    return (gradient + gradient.T) / 2


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3])
def test_the_strain_balances_the_forces_of_inertia_and_leaves_the_surface_free(poisson_ratio):
    # Of a cubic displacement differences of strains are exact, and those of itself to step^2.
    stiffness, loads = _elasticity(SEMIAXES, poisson_ratio)
    omega, moments = np.array([0.7, -0.4, 1.1]), BODY.moments
    f = [*omega**2, omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]]
    weights = np.linalg.solve(stiffness, loads @ f).reshape(3, len(ODD))

    def displacement(x):
        return weights @ np.array([np.prod((x / SEMIAXES) ** power) for power in ODD])

    def stress(x):
        strain = strain_at(displacement, x)
        return 2 * strain + 2 * poisson_ratio / (1 - 2 * poisson_ratio) * np.trace(strain) * np.eye(3)

    turning = np.cross(moments * omega, omega) / moments
    for direction in np.random.default_rng(3).normal(size=(5, 3)):
        direction /= np.linalg.norm(direction)
        outside, inside = SEMIAXES * direction, 0.7 * SEMIAXES * direction
        assert np.max(np.abs(stress(outside) @ (direction / SEMIAXES))) < 1e-7
        divergence = sum(
            (stress(inside + 0.1 * e) - stress(inside - 0.1 * e))[:, j] / 0.2 for j, e in enumerate(np.eye(3))
        )
        acceleration = np.cross(turning, inside) + np.cross(omega, np.cross(omega, inside))
        np.testing.assert_allclose(divergence, acceleration, rtol=0, atol=1e-7)


@pytest.mark.parametrize("omega", [(0.9, 0.1, 0.2), (0.1, 0.2, 0.9), (0.5, 0.5, 0.5)], ids=["long", "short", "between"])
def test_the_mean_is_that_over_the_harmonics_of_a_run(omega):
    start = BODY.state((1, 0, 0, 0), omega_body=omega)
    rotation = pt.analysis.FreeRotation(BODY, start)
    period, count = rotation.rotation_period, 1024
    w = pt.propagate(pt.System(BODY), start, np.arange(count) / count * period).omega_body.T
    w = w[np.argsort(BODY.moments)]
    relaxation = InelasticRelaxation(BODY, rigidity=3.0, quality_factor=20.0)
    products = np.array([*w**2, w[1] * w[2], w[2] * w[0], w[0] * w[1]])
    lost = 0.0
    for k in range(1, 200):  # each harmonic loses 2 pi / Q of the largest energies of its cosine and its sine
        turns = 2 * np.pi * k * np.arange(count) / count
        for amplitude in (2 * np.mean(products * np.cos(turns), axis=1), 2 * np.mean(products * np.sin(turns), axis=1)):
            lost += 2 * np.pi * k / period * amplitude @ relaxation._compliance @ amplitude / 2 / 20.0
    found = relaxation.power(rotation.angular_momentum, rotation.dynamic_moment)
    assert found == pytest.approx(lost, rel=1e-10, abs=0)


def test_a_creeping_sphere_loses_as_much_with_the_quality_of_its_lag():
    # A viscous strain of relaxation time T has 1 / Q = w T at the frequency w; a small wobble has one frequency.
    oblate, rigidity, lag = 0.998, 1e5, 0.1
    body = pt.Body.from_ellipsoid(VOLUME * oblate, (1, 1, oblate))
    moments = body.moments
    wobble = moments[2] / moments[0] - 1
    relaxation = InelasticRelaxation(body, rigidity, 1 / (wobble * lag), poisson_ratio=0.4999999)
    # D = 12 LOVE omega omega^T / (2 mu) = k R^5 / (3 G) omega omega^T.
    tide = CreepingTide(love_number=1.0, radius=1.0, relaxation_time=lag, G=rigidity / (36 * LOVE / 2))
    system = pt.System(body, tide)
    start = system.state((1, 0, 0, 0), omega_body=(0.1, 0, 1.0))
    motion = pt.propagate(system, start, [100.0, 100.0 + 2 * np.pi / wobble])
    lost = (motion.energy[0] - motion.energy[1]) / np.ptp(motion.times)
    rotation = pt.analysis.FreeRotation(body, body.state((1, 0, 0, 0), omega_body=(0.1, 0, 1.0)))
    found = relaxation.power(rotation.angular_momentum, rotation.dynamic_moment)
    # The body is no sphere by 0.002, which counts some times, and its wobble of 0.1 rad counts by the square.
    assert found == pytest.approx(lost, rel=0.02, abs=0)


def test_a_small_nutation_falls_as_the_damping_time_says():
    relaxation, C = InelasticRelaxation(BODY, 1.0, 1.0), np.max(BODY.moments)
    for short in (1e-4, 1e-6):
        J = C * (1 - short)
        excess = (1 / J - 1 / C) / 2
        assert 2 * excess / relaxation.power(1.0, J) == pytest.approx(
            relaxation.damping_time(1 / C), rel=100 * short, abs=0
        )


def test_the_power_is_continuous_at_the_separatrix_and_vanishes_in_steady_rotation():
    relaxation = InelasticRelaxation(BODY, 1.0, 1.0)
    low, middle, high = np.sort(BODY.moments)
    assert np.all(relaxation.power(1.0, [low, high]) == 0)
    near = relaxation.power(1.0, middle + middle * np.array([-1e-12, 0, 1e-12]))
    assert np.ptp(near) < 1e-3 * near[1]
    # A revolution next to the separatrix takes log(1 / distance): so does the mean.
    near, nearer = relaxation.power(1.0, middle * np.array([1 + 1e-4, 1 + 1e-8]))
    assert 0.4 < nearer / near < 0.7


@pytest.mark.parametrize("semiaxes", [(1, 1, 0.5), (1, 0.5, 0.5)])
def test_bodies_of_revolution(semiaxes):
    relaxation = InelasticRelaxation(pt.Body.from_ellipsoid(1.0, semiaxes), 1.0, 1.0)
    moments = np.sort(relaxation.body.moments)
    power = relaxation.power(1.0, np.linspace(moments[0], moments[2], 7))
    assert np.all(power[1:-1] > 0)
    assert power[-1] == 0


def test_a_long_axis_mode_ends_about_the_short_axis():
    relaxation = InelasticRelaxation(BODY, 1.0, 1.0)
    low, middle, high = np.sort(BODY.moments)
    rate, start = 1.3, low * 1.01

    damping = float(relaxation.damping_time(rate))
    slow = 10 * damping

    def brake(state):
        return {"rate": -state["rate"] / slow}

    times = np.linspace(0, 6, 61) * damping
    begin = {"rate": rate, "dynamic_moment": start}
    J = pt.analysis.secular_evolution([relaxation.rates], begin, times).values["dynamic_moment"]
    assert np.all(np.diff(J) > 0)
    assert J[0] < middle < J[-1]
    late = np.log((high - J[-11]) / (high - J[-1])) / (times[-1] - times[-11])  # of the square of the nutation
    assert late * damping == pytest.approx(2, rel=1e-3)
    # At constant momentum energy goes at the power: J = G^2 / (2 T).
    power = relaxation.power(rate * high, start)
    slope = relaxation.rates(begin)["dynamic_moment"]
    assert slope == pytest.approx(2 * start**2 / (rate * high) ** 2 * power, rel=1e-14, abs=0)
    # Beside another effect: the slower the body turns, by the cube of the rate, the slower it relaxes.
    slowed = pt.analysis.secular_evolution([relaxation.rates, brake], begin, times).values
    np.testing.assert_allclose(slowed["rate"], rate * np.exp(-times / slow), rtol=1e-14)
    passed = slow / 3 * (1 - np.exp(-3 * times / slow))
    again = pt.analysis.secular_evolution([relaxation.rates], begin, passed).values["dynamic_moment"]
    np.testing.assert_allclose(slowed["dynamic_moment"], again, rtol=1e-8)


def test_times_scale_with_rigidity_quality_density_and_size():
    first = InelasticRelaxation(BODY, 1.0, 1.0).damping_time(1.0)
    larger = pt.Body.from_ellipsoid(8 * 1.7 * VOLUME * np.prod(SEMIAXES), 2 * SEMIAXES)
    second = InelasticRelaxation(larger, 5.0, 7.0).damping_time(3.0)
    assert second / first == pytest.approx(5 * 7 / 1.7 / 4 / 27, rel=1e-12, abs=0)


def test_the_order_of_the_axes_is_no_matter():
    times = [
        InelasticRelaxation(pt.Body.from_ellipsoid(1.0, axes), 1.0, 1.0).damping_time(1.0)
        for axes in itertools.permutations(SEMIAXES)
    ]
    np.testing.assert_allclose(times, times[0], rtol=1e-12)


@pytest.mark.parametrize(
    ("body", "numbers", "sentence"),
    [
        (pt.Body((1, 2, 2.5)), {}, "body must be one ellipsoid, got another body"),
        (pt.Body.from_ellipsoid(1.0, (1, 1, 1)), {}, "body must not be a sphere, got three equal moments"),
        (BODY, {"rigidity": 0.0}, "rigidity must be positive, got 0.0"),
        (BODY, {"quality_factor": -1.0}, "quality_factor must be positive, got -1.0"),
        (BODY, {"poisson_ratio": 0.5}, "poisson_ratio must be from -1 to below 1/2, got 0.5"),
    ],
)
def test_what_is_refused(body, numbers, sentence):
    with pytest.raises(ValueError, match=sentence):
        InelasticRelaxation(body, **{"rigidity": 1.0, "quality_factor": 1.0, **numbers})


def test_a_dynamic_moment_beyond_the_body_is_refused():
    with pytest.raises(ValueError, match="dynamic_moment must be from"):
        InelasticRelaxation(BODY, 1.0, 1.0).power(1.0, 99.0)
