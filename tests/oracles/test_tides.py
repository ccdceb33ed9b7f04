"""Tides in one body: the motion of another program, closed forms, and an integration in space axes."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import poinsot as pt
from poinsot.forces import TidalTorque, pseudo_synchronous_rate
from poinsot.parts import CreepingTide

CASE = json.loads((Path(__file__).parent / "tidal_torque.json").read_text())["tide_constant_time_lag"]
UPRIGHT = (1, 0, 0, 0)


def largest(difference):
    return np.max(np.abs(difference))


def ellipse(eccentricity):
    return pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=eccentricity)


def upright(system, spins):
    return system.state(UPRIGHT, omega_body=np.stack([0 * spins, 0 * spins, spins], axis=-1))


# ---------------------------------------------------------------------- constant time lag


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
def test_constant_time_lag(formulation):
    orbit = pt.KeplerOrbit(CASE["mu"], semimajor_axis=CASE["semimajor_axis"], eccentricity=CASE["eccentricity"])
    # 3 k2 (mu^2 / G) R^5 dt in numbers that leave none of them out.
    tide = TidalTorque(orbit, love_number=0.5, radius=2.0, time_lag=0.25, G=12.0 / CASE["K"])
    body = pt.Body(CASE["moments"])
    start = body.state(CASE["quaternion0"], omega_body=CASE["omega_body0"])
    motion = pt.propagate(pt.System(body, tide), start, CASE["times"], formulation=formulation)
    # Twenty times what the reference is known to, and as much again for 500 radians of spin in units of 2.2e-16.
    bound = 20 * CASE["estimated_error_of_reference"] + 500 * 2.2e-16
    assert largest(motion.quaternion - CASE["quaternion"]) < bound
    assert largest(motion.omega_body - CASE["omega_body"]) < bound


def test_means_over_a_revolution():
    orbit, moment = ellipse(CASE["eccentricity"]), 1.0
    system = pt.System(pt.Body((moment,) * 3), TidalTorque(orbit, love_number=1 / 3, radius=1.0, time_lag=1.0, G=1.0))
    # Equal steps of a period integrate a periodic function to rounding: the coefficients fall by 0.1 a harmonic.
    times = np.arange(64) * (orbit.period / 64)

    def mean(spin):
        states = [system.state(UPRIGHT, omega_body=(0, 0, spin), time=time) for time in times]
        return np.mean([system.torque_body(state)[2] for state in states])

    assert abs(mean(0.0) / CASE["mean_r_minus8_momentum"] - 1) < 1e-14
    assert abs((mean(0.0) - mean(1.0)) / CASE["mean_r_minus6"] - 1) < 1e-14
    assert abs(pseudo_synchronous_rate(CASE["eccentricity"]) / CASE["equilibrium_rate_over_mean_motion"] - 1) < 1e-15
    assert abs(mean(pseudo_synchronous_rate(CASE["eccentricity"]))) < 1e-14


def spinning(eccentricity, strength, spins, turns):
    """The spins after some revolutions of upright spheres on an ellipse, which K = strength turns."""
    orbit = ellipse(eccentricity)
    tide = TidalTorque(orbit, love_number=strength / 3, radius=1.0, time_lag=1.0, G=1.0)
    system = pt.System(pt.Body((MOMENT,) * 3), tide)
    return pt.propagate(system, upright(system, spins), [turns * orbit.period]).omega_body[:, 0, 2]


MOMENT = 0.4
each_ellipse = pytest.mark.parametrize("eccentricity", [0.1, 0.3, 0.6])


@each_ellipse
def test_spins_tend_to_the_pseudo_synchronous_rate(eccentricity):
    # C w' = -K (w / r^6 - |x x v| / r^8) is linear: spins approach each other by exp(-K <r^-6> t / C).
    # They begin up to 8 apart, and some hundred steps round at 1e-15.
    strength, turns = 1e-3, 40
    spins = pseudo_synchronous_rate(eccentricity) + np.array([-2.0, 0.0, 5.0])
    ends = spinning(eccentricity, strength, spins, turns)
    x = eccentricity**2
    decay = strength / MOMENT * (1 + 3 * x + 3 / 8 * x**2) / (1 - x) ** 4.5 * turns * 2 * np.pi
    np.testing.assert_allclose(ends - ends[1], (spins - spins[1]) * np.exp(-decay), rtol=1e-12, atol=5e-13)


@each_ellipse
def test_at_the_pseudo_synchronous_rate_a_revolution_changes_nothing_to_second_order(eccentricity):
    # The way in and the way out mirror each other, which leaves odd orders alone: a third one.
    rate = pseudo_synchronous_rate(eccentricity)
    strong, weak = (spinning(eccentricity, k, np.array([rate]), 1)[0] - rate for k in (1e-3, 5e-4))
    assert strong / weak == pytest.approx(8, rel=0.1)


def test_derivatives_by_the_numbers_of_a_tide_on_a_circle():
    # C w' = -K (w - n) / a^6 with K = 3 k2 (mu^2 / G) R^5 dt: each number counts with its power in K.
    love, radius, lag, G, time, spin = 0.3, 1.1, 0.02, 0.7, 5.0, 2.2
    tide = TidalTorque(ellipse(0.0), love, radius, lag, G)
    system = pt.System(pt.Body((MOMENT,) * 3), tide)
    start = system.state(UPRIGHT, omega_body=(0, 0, spin))
    powers = {"love_number": 1 / love, "forces[0].radius": 5 / radius, "time_lag": 1 / lag, "G": -1 / G}
    found = pt.analysis.state_transition(system, start, [time], list(powers))
    decay = 3 * love / G * radius**5 * lag / MOMENT * time
    slope = -MOMENT * (spin - 1) * decay * np.exp(-decay)
    np.testing.assert_allclose(found.sensitivity[0, 5], slope * np.array(list(powers.values())), rtol=1e-14)
    assert abs(found.matrix[0, 5, 5] - np.exp(-decay)) < 3e-15


def test_no_eccentricity_of_an_escape():
    with pytest.raises(ValueError, match=r"eccentricity must be from 0 to below 1, got 1\.2"):
        pseudo_synchronous_rate(1.2)


# ---------------------------------------------------------------------- creeping figure


LOVE, RADIUS, G = 0.9, 1.3, 2.5
HEAVY = pt.Body((1e7, 1e7, 1e7))
"""A sphere whose spin a tide changes by 1e-5 in a run; torques round at 1e7 2.2e-16."""


def creeping(body, orbit, relaxation_time):
    tide = CreepingTide(LOVE, RADIUS, relaxation_time, G)
    return pt.System(body, tide, pt.GravityGradient(orbit))


def torques(system, motion):
    """The torque at each time, shape (..., times, 3)."""
    shape = motion.omega_body.shape
    momenta, own = motion.angular_momentum_body.reshape(-1, 3), motion.own["creeping_tide"].reshape(-1, 5)
    times = np.broadcast_to(motion.times, shape[:-1]).ravel()
    own = {part.name: own for part in system.parts}
    states = system.state(motion.quaternion.reshape(-1, 4), angular_momentum_body=momenta, time=times, **own)
    return system.torque_body(states).reshape(shape)


def test_a_uniform_turn_feels_the_response_of_a_maxwell_body():
    # <tau> = -3/2 mu^2 R^5 / (G a^6) k w T / (1 + (w T)^2) at the frequency w = 2 (spin - n) of the tide.
    relaxation = 0.7
    frequencies = np.array([-20.0, -1.0, -0.03, 0.1, 1.0, 1 / 0.7, 3.0, 40.0])
    system = creeping(HEAVY, ellipse(0.0), relaxation)
    motion = pt.propagate(system, upright(system, 1 + frequencies / 2), [50 * relaxation])
    phase = 2 * (motion.omega_body[:, -1, 2] - 1) * relaxation
    expected = -1.5 * RADIUS**5 / G * LOVE * phase / (1 + phase**2)
    # The figure of the start goes as e^-50. The spin changes by 1e-7 a unit of time, so much by one relaxation time.
    np.testing.assert_allclose(torques(system, motion)[:, -1, 2], expected, rtol=1e-6)


def hansen(eccentricity, k):
    """The coefficient X_k^(-3, 2): of cos(k M) and sin(k M) in (a / r)^3 exp(2 i f)."""
    E = 2 * np.pi * (np.arange(512) + 0.5) / 512
    r = 1 - eccentricity * np.cos(E)
    f = 2 * np.arctan2(np.sqrt(1 + eccentricity) * np.sin(E / 2), np.sqrt(1 - eccentricity) * np.cos(E / 2))
    return np.mean(np.cos(2 * f - k * (E - eccentricity * np.sin(E))) / r**2)


def mean_torque(spin, eccentricity, relaxation):
    """The mean over the angle between spin and orbit: the sum over harmonics (Correia et al. 2014, eq. (37))."""
    harmonics = np.arange(-10, 30)
    phase = (2 * np.asarray(spin)[..., None] - harmonics) * relaxation
    weights = np.array([hansen(eccentricity, k) ** 2 for k in harmonics])
    return -1.5 * RADIUS**5 / G * LOVE * np.sum(weights * phase / (1 + phase**2), axis=-1)


def test_the_mean_torque_on_an_ellipse_is_the_sum_over_harmonics():
    eccentricity, relaxation = 0.2, 6.0
    orbit = ellipse(eccentricity)
    spins = np.array([1.47, 1.5, 1.53, 1.9])
    system = creeping(HEAVY, orbit, relaxation)
    times = 40 * relaxation + np.arange(256) / 256 * orbit.period
    motion = pt.propagate(system, upright(system, spins), times)
    found = np.mean(torques(system, motion)[..., 2], axis=-1)
    expected = mean_torque(np.mean(motion.omega_body[..., 2], axis=-1), eccentricity, relaxation)
    assert expected[0] > 0 > expected[2]  # held at 3/2
    # The spin changes by 1e-7 a unit of time, and torques in a relaxation time by 36 as much.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)


def test_a_moon_that_slows_down_is_caught_at_three_halves():
    eccentricity, relaxation = 0.3, 30.0
    system = creeping(pt.Body((60.0, 60.0, 60.0)), ellipse(eccentricity), relaxation)
    times = np.linspace(0, 640 * np.pi, 3201)
    spin = pt.propagate(system, system.state(UPRIGHT, omega_body=(0, 0, 1.8)), times).omega_body[:, 2]
    # Caught where the mean torque is zero, and not where a constant time lag would bring it; the spin swings by 0.01
    # within a revolution, and the torque of that adds the square of it.
    caught = brentq(lambda spin: mean_torque(spin, eccentricity, relaxation), 1.49, 1.51)
    assert abs(np.mean(spin[-1000:]) - caught) < 1e-4
    assert pseudo_synchronous_rate(eccentricity) > 1.55


def test_short_relaxation_is_a_constant_time_lag():
    # Torques are proportional to the lag, and differ by its square times a frequency: half the lag, half the ratio.
    spins, apart = np.array([0.3, 1.0, 2.5]), []
    for lag in (4e-3, 2e-3):
        orbit = ellipse(0.3)
        slow = creeping(HEAVY, orbit, lag)
        motion = pt.propagate(slow, upright(slow, spins), np.linspace(0.5, 6.5, 13))
        lagged = pt.System(HEAVY, TidalTorque(orbit, LOVE, RADIUS, lag, G))
        expected = torques(lagged, motion)[..., 2]
        apart.append(largest(torques(slow, motion)[..., 2] - expected) / largest(expected))
    assert apart[0] < 0.05
    assert apart[0] / apart[1] == pytest.approx(2, rel=0.2)


def in_space_axes(moments, relaxation, position):
    """Rates of rotation matrix, angular momentum, and change of the inertia tensor, all along space axes.

    D' = W D - D W + (D_e - D) / T, where W x is omega x x: no body axes but those of the rigid part.
    """
    size = LOVE * RADIUS**5 / (3 * G)

    def rates(time, y):
        A, momentum, D = y[:9].reshape(3, 3), y[9:12], y[12:].reshape(3, 3)
        x = position(time)
        pull = 3 / np.linalg.norm(x) ** 5
        inertia = A @ np.diag(moments) @ A.T + D
        omega = np.linalg.solve(inertia, momentum)
        W = np.cross(omega, np.eye(3)).T
        forced = np.outer(omega, omega) - pull * np.outer(x, x)
        forced -= np.trace(forced) / 3 * np.eye(3)
        creep = W @ D - D @ W + (size * forced - D) / relaxation
        return np.concatenate([(W @ A).ravel(), pull * np.cross(x, inertia @ x), creep.ravel()])

    return rates


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
def test_a_creeping_body_moves_by_the_equations_in_space_axes(formulation):
    moments, relaxation, times = np.array([3.0, 3.3, 3.8]), 2.5, np.linspace(0, 20, 9)
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.3, inclination=0.4, node=0.2)
    system = creeping(pt.Body(moments), orbit, relaxation)
    omega = np.array([0.3, -0.4, 0.9])
    own = np.array([0.03, -0.1, 0.05, 0.02, -0.04])
    start = system.state(UPRIGHT, omega_body=omega, creeping_tide=own)
    motion = pt.propagate(system, start, times, formulation=formulation)

    a, b, c, d, e = own
    D = np.array([(a, c, d), (c, b, e), (d, e, -a - b)])
    first = [*np.eye(3).ravel(), *((np.diag(moments) + D) @ omega), *D.ravel()]
    rates = in_space_axes(moments, relaxation, lambda t: np.array(list(orbit.position_at(t))))
    y = solve_ivp(rates, (0, 20), first, "DOP853", times, rtol=3e-14, atol=1e-14).y.T
    A, D = y[:, :9].reshape(-1, 3, 3), y[:, 12:].reshape(-1, 3, 3)
    # The other integration leaves 1e-13 at its tolerance of 3e-14: ten times that.
    assert largest(motion.attitude.as_matrix() - A) < 1e-12
    assert largest(motion.angular_momentum_space - y[:, 9:12]) < 1e-12
    seen = A.transpose(0, 2, 1) @ D @ A
    five = np.stack([seen[:, i, j] for i, j in ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))], axis=-1)
    assert largest(motion.own["creeping_tide"] - five) < 1e-12


def test_energy_goes_by_creep_alone():
    # Beside an attractor at rest: H' = -T (3 G / (2 k R^5)) D':D', with D' from the variables alone.
    relaxation = 2.5
    place = pt.orbits.FixedPosition(1.0, position=(1.2, 0.3, -0.4))
    system = creeping(pt.Body((3.0, 3.3, 3.8)), place, relaxation)
    start = system.state(UPRIGHT, omega_body=(0.3, -0.4, 0.9), creeping_tide=(0.03, -0.1, 0.05, 0.02, -0.04))
    nodes, weights = np.polynomial.legendre.leggauss(80)
    times = 5 * (nodes + 1)
    motion = pt.propagate(system, start, [0.0, *times, 10.0])
    tide = system.parts[0]
    seen = motion.attitude.inv().apply(np.array(place.position))
    rate = (tide.at_equilibrium(motion.omega_body, seen, 1.0) - motion.own["creeping_tide"]) / relaxation
    a, b, c, d, e = rate[1:-1].T
    square = a**2 + b**2 + (a + b) ** 2 + 2 * (c**2 + d**2 + e**2)
    loss = relaxation * 1.5 * G / (LOVE * RADIUS**5) * 5 * weights @ square
    assert loss > 0.01
    assert abs(motion.energy[0] - motion.energy[-1] - loss) < 1e-13


def test_a_body_in_equilibrium_stays_so():
    # Upright and synchronous on a circle; its figure is that of spin and tide, at rest.
    tide = CreepingTide(LOVE, RADIUS, 0.5, G)
    orbit = ellipse(0.0)
    system = pt.System(pt.Body((3.0, 3.0, 3.0)), tide, pt.GravityGradient(orbit))
    own = tide.at_equilibrium((0, 0, 1), (1, 0, 0), 1.0)
    motion = pt.propagate(system, system.state(UPRIGHT, omega_body=(0, 0, 1), creeping_tide=own), [0.0, 20.0])
    assert largest(motion.own["creeping_tide"] - own) < 1e-14
    assert largest(motion.omega_body - (0, 0, 1)) < 1e-14
    # k R^5 / (3 G) times (1/3 - 1 - 2, 1/3 ... ): the long axis is along the attractor, the short one the spin.
    unit = LOVE * RADIUS**5 / (3 * G)
    np.testing.assert_allclose(own, unit * np.array([-7 / 3, 2 / 3, 0, 0, 0]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["love_number", "radius", "relaxation_time", "G"])
def test_numbers_of_a_creeping_body_must_be_positive(name):
    with pytest.raises(ValueError, match=f"{name} must be positive, got 0.0"):
        CreepingTide(**{"love_number": 1.0, "radius": 1.0, "relaxation_time": 1.0, "G": 1.0, name: 0.0})
