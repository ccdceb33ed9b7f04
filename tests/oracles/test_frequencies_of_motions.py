"""Frequencies read off motions, against Jacobi's and the pendulum's periods and linear theories of small librations."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

import poinsot as pt
from oracles.cassini_worlds import WORLDS

CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
PHOBOS = (0.3615, 0.4265, 0.5024)


def rates_of_free_rotation(moments, momentum):
    """The mean rate of the third axis about the momentum and the rate of the momentum about the third axis.

    Jacobi's, in 40 digits, for a momentum that goes round the third axis, be it the short or the long one.
    """
    with mp.workdps(40):
        I1, I2, I3 = (mp.mpf(float(x)) for x in moments)
        g = [mp.mpf(float(x)) for x in momentum]
        G2, T2 = sum(x * x for x in g), sum(x * x / I for x, I in zip(g, (I1, I2, I3), strict=True))
        across, along = T2 * I3 - G2, G2 - T2 * I1
        k2 = (I2 - I1) * across / ((I3 - I2) * along)
        rate, quarter = mp.sqrt((I3 - I2) * along / (I1 * I2 * I3)), mp.ellipk(k2)
        # With g1^2 = a1 cn^2 and g2^2 = a2 sn^2 the rate of the axis is G (g1^2/I1 + g2^2/I2)/(g1^2 + g2^2).
        a1, a2 = I1 * across / (I3 - I1), I2 * across / (I3 - I2)
        steady = (a2 / I2 - a1 / I1) / (a2 - a1)
        mean = steady + (1 / I1 - steady) * mp.ellippi(1 - a2 / a1, k2) / quarter
        return float(mp.sqrt(G2) * mean), float(mp.pi * rate / (2 * quarter) * mp.sign(I3 - I1))


SHORT, LONG = (2.0, 2.5, 3.5), (3.5, 2.5, 2.0)  # what the third axis is
ROTATIONS = [
    (SHORT, (0.3, 0.5, 2.0)),
    (SHORT, (0.5, 1.2, 1.5)),
    (SHORT, (0.1, 2.0, 0.9)),
    (LONG, (0.3, 0.5, 2.0)),
    (LONG, (0.4, 1.5, 1.2)),
    (LONG, (0.1, 2.0, 0.9)),
]


def signals_of(motion):
    """Signals with what their strongest frequency is made of: precession and rotation."""
    g = motion.angular_momentum_body
    upright = Rotation.align_vectors([[0, 0, 1.0]], [motion.angular_momentum_space[0]])[0]
    attitude = upright * Rotation.from_quat(motion.quaternion, scalar_first=True)
    q, axis = attitude.as_quat(scalar_first=True), attitude.as_matrix()[:, :, 2]
    return {
        "q0 + i q3": (q[:, 0] + 1j * q[:, 3], (0.5, -0.5)),
        "q1 + i q2": (q[:, 1] + 1j * q[:, 2], (0.5, 0.5)),
        "g1 + i g2": (g[:, 0] + 1j * g[:, 1], (0, 1)),
        "g1": (g[:, 0], (0, 1)),
        "third axis": (axis[:, 0] + 1j * axis[:, 1], (1, 0)),
        "precession angle": (np.exp(1j * np.arctan2(axis[:, 1], axis[:, 0])), (1, 0)),
        "rotation angle": (np.exp(1j * np.arctan2(g[:, 1], g[:, 0])), (0, 1)),
    }


def assert_both_rates(motion, count, rtol):
    initial = motion.initial
    both = precession, rotation = rates_of_free_rotation(motion.system.body.moments, initial.angular_momentum_body)
    for name, (signal, parts) in signals_of(motion).items():
        found = pt.analysis.frequencies(signal, motion.times, count=count)
        expected = np.dot(parts, both)
        expected = abs(expected) if np.isrealobj(signal) else expected
        assert found.frequencies[0] == pytest.approx(expected, rel=rtol, abs=0), name
    known = pt.analysis.FreeRotation(motion.system.body, initial)
    assert 2 * np.pi / known.precession_period == pytest.approx(precession, rel=1e-14, abs=0)
    assert 2 * np.pi / known.rotation_period == pytest.approx(abs(rotation), rel=1e-14, abs=0)


def integrated(body, *rest):
    return pt.propagate(pt.System(body), *rest)


@pytest.mark.samples
@pytest.mark.parametrize(
    ("moments", "momentum", "moved"),
    [(*one, pt.free_motion) for one in ROTATIONS] + [(*one, integrated) for one in ROTATIONS[1::3]],
)
def test_both_frequencies_of_free_rotation(moments, momentum, moved):
    body = pt.Body(moments)
    motion = moved(body, body.state((1, 0, 0, 0), angular_momentum_body=momentum), np.linspace(0, 900, 2**13))
    assert_both_rates(motion, count=5, rtol=2e-14)


@pytest.mark.parametrize(("moments", "off"), [(SHORT, 1e-6), pytest.param(LONG, 1e-12, marks=pytest.mark.slow)])
def test_both_frequencies_near_the_separatrix(moments, off):
    """Its rotation is slow and full of overtones."""
    I1, I2, I3 = moments
    first = np.sqrt(0.36 * (1 / I2 - 1 / I3) / (1 / I1 - 1 / I2))  # on the separatrix
    momentum = (first * (1 - off), 2.0, 0.6)
    body = pt.Body(moments)
    start = body.state((1, 0, 0, 0), angular_momentum_body=momentum)
    motion = pt.free_motion(body, start, np.linspace(0, 4000, 2**13))
    assert_both_rates(motion, count=8, rtol=2e-14)


@pytest.mark.parametrize("amplitude", [1e-4, 1e-2, 0.5])
def test_libration_of_phobos_on_a_circle(amplitude):
    phobos = pt.Body(PHOBOS)
    system = pt.System(phobos, pt.GravityGradient(CIRCLE))
    start = phobos.state((np.cos(amplitude / 2), 0, 0, np.sin(amplitude / 2)), omega_body=(0, 0, 1.0))
    times = np.linspace(0, 400, 4096)
    q = pt.propagate(system, start, times).relative_to(CIRCLE.frame).quaternion
    found = pt.analysis.frequencies(2 * np.arctan2(q[:, 3], q[:, 0]), times, count=6)
    pendulum = np.pi / (2 * ellipk(np.sin(amplitude) ** 2))  # of its small oscillations
    exact = np.sqrt(3 * (PHOBOS[1] - PHOBOS[0]) / PHOBOS[2]) * pendulum
    # Three times the worst of 20 starts shaken by an ulp; the roundings of an attitude, relative to a small amplitude.
    assert found.frequencies[0] == pytest.approx(exact, rel=4e-17 / amplitude + 8e-15, abs=0)


def test_librations_of_a_satellite_are_those_of_linear_theory():
    radial, along, normal = PHOBOS
    k_roll, k_yaw = (normal - radial) / along, (normal - along) / radial
    fast, slow = np.sqrt(-np.roots([1, 1 + 3 * k_roll + k_roll * k_yaw, 4 * k_roll * k_yaw]))
    satellite = pt.Body(PHOBOS)
    system = pt.System(satellite, pt.GravityGradient(CIRCLE))
    tilts = np.array([1e-4, -1e-4, 2e-4, -2e-4])
    start = satellite.state(Rotation.from_rotvec(tilts[:, None] * np.ones(3)), omega_space=(0, 0, 1.0))
    times = np.linspace(0, 800, 4096)
    q = pt.propagate(system, start, times, progress=False).relative_to(CIRCLE.frame).quaternion
    found = pt.analysis.frequencies(np.moveaxis(q[..., 1:], -1, 0), times, count=10).frequencies  # axis, tilt, line
    smallest = found.reshape(3, 2, 2, -1).mean(axis=2)
    smallest = (4 * smallest[:, 0] - smallest[:, 1]) / 3  # they grow with the square of the tilt, here in both senses
    np.testing.assert_allclose(np.sort(smallest[0, :2]), np.sort([slow, fast]), rtol=1e-12)
    np.testing.assert_allclose(np.sort(smallest[1, :2]), np.sort([slow, fast]), rtol=1e-12)
    pitch = np.sqrt(3 * (along - radial) / normal)
    assert smallest[2, 0] == pytest.approx(pitch, rel=1e-12, abs=0)
    resting = next(e for e in pt.analysis.equilibria(system, CIRCLE.frame) if e.stability == "lyapunov")
    np.testing.assert_allclose(resting.frequencies, np.sort([slow, pitch, fast]), rtol=2e-15)


# ---------------------------------------------------------------------- librations of worlds

SIZES = 1e-4 * np.array([1.0, 2.0])
LARGER = {"Mercury": 3}  # in its run rounding, which counts inversely, outweighs the next order of the amplitude
LIBRATIONS = {
    # Wobble and precession (the slower one first) and longitude, radians per day, as integrated in 64 bits of mantissa
    # by tests/oracles/cassini_worlds.py; periods, samples once in how many, bound of the relative difference.
    "Io": ((0.027640325575385156, 0.03915490607719866, 0.47139459023390917), 1024, 1, 5e-11),
    "Europa": ((0.003543772854225643, 0.004777123593324879, 0.11944423275239119), 4096, 4, 1e-10),
    "Moon": ((2.299056445954516e-4, 7.122533774344911e-4, 5.944449461198327e-3), 8192, 8, 2e-9),
    "Titan": ((5.6205457956291834e-5, 7.835745999933444e-5, 8.207665594609401e-3), 28672, 16, 3e-9),
    "Mercury": ((1.6143324852138236e-5, 2.9492603363605092e-5, 1.08546727364682e-3), 8192, 8, 6e-9),
}


def vanishing(signals, times, lines, count=12):
    """Strongest frequencies, ascending, of signals with amplitudes in the ratio 1 : 2, as these vanish."""
    one, two = np.sort(pt.analysis.frequencies(signals, times, count=count).frequencies[:, :lines])
    assert np.all(np.abs(two / one - 1) < 3e-6)
    return one + (one - two) / 3


def away_from(rest, motion, frame):
    """Rotation vectors (members, times, 3) from an attitude in a frame to those of a motion."""
    seen = Rotation.from_quat(motion.relative_to(frame).quaternion.reshape(-1, 4), scalar_first=True)
    return (rest.inv() * seen).as_rotvec().reshape(*motion.quaternion.shape[:2], 3)


@pytest.mark.parametrize(
    "name", [name if name in ("Io", "Moon") else pytest.param(name, marks=pytest.mark.slow) for name in LIBRATIONS]
)
def test_free_librations_about_cassini_states(name):
    """Seen once in a period, when the forced motion is the same; started off along all axes."""
    expected, periods, every, rtol = LIBRATIONS[name]
    world, sizes = WORLDS[name], LARGER.get(name, 1) * SIZES
    ellipse = pt.KeplerOrbit(
        world.mu,
        semimajor_axis=world.a,
        eccentricity=world.e,
        inclination=world.i,
        node=world.node,
        argument_of_periapsis=world.periapsis,
    )
    orbit = pt.orbits.PrecessingOrbit.from_mean_motion(ellipse, mean_motion=world.rate, node_rate=world.node_rate)
    forced = pt.analysis.cassini_state(pt.Body(world.moments), orbit, world.spin).motion
    state, body = forced.state, forced.system.of_bodies[""]
    g = state.angular_momentum_body + np.multiply.outer(sizes, (0.5, -0.5, 0)) * body.moments[2] * world.rate
    turned = state.attitude * Rotation.from_rotvec(np.multiply.outer(sizes, np.ones(3)))
    start = body.state(turned, angular_momentum_body=g, time=state.time)
    times = state.time + np.arange(0, periods, every) * forced.period
    motion = pt.propagate(forced.system, start, times, progress=False)
    signals = away_from(forced.frame.attitude(state.time).inv() * state.attitude, motion, forced.frame)
    across, longitude = (vanishing(signals[..., i], times, lines) for i, lines in ((0, 2), (2, 1)))
    np.testing.assert_allclose([*across, *longitude], expected, rtol=rtol)


@pytest.mark.parametrize("name", ["L1", "L2", "L3"])
def test_librations_at_the_points_in_line(name):
    """Both attractors pull like one with c = (1 - mu)/r1^3 + mu/r2^3 times the square of the mean motion."""
    A, B, C = 60.0, 120.0, 150.0
    point = pt.orbits.LagrangePointPath(1.0 - 0.0121, 0.0121, separation=1.0, point=name)
    r1, r2 = (np.linalg.norm(orbit.position) for orbit in (point.from_primary, point.from_secondary))
    c = (1 - 0.0121) / r1**3 + 0.0121 / r2**3
    equations = [[0, 1, 1, 0], [-1, 0, 0, 1], [0, 0, 0, (B - C) / A], [0, -3 * (C - A) / B * c, (C - A) / B, 0]]
    across = np.sort(np.abs(np.linalg.eigvals(equations).imag))[::2]
    craft = pt.Body((A, B, C))
    system = pt.System(craft, pt.GravityGradient(point.from_primary), pt.GravityGradient(point.from_secondary))
    turns = Rotation.from_rotvec(np.multiply.outer(SIZES, np.ones(3)))
    start = craft.state(turns, omega_space=(0, 0, 1.0))
    times = np.arange(1024) * 0.5
    signals = away_from(Rotation.identity(), pt.propagate(system, start, times, progress=False), point.frame)
    np.testing.assert_allclose(vanishing(signals[..., 0], times, 2), across, rtol=3e-9)
    in_plane = np.sqrt(3 * c * (B - A) / C)
    np.testing.assert_allclose(vanishing(signals[..., 2], times, 1), in_plane, rtol=3e-9)


ISLANDS = {"1:1": (0.0, 0.56, 1), "2:1": (0.0, 2.32, 1), "9:4": (0.0, 2.53225, 4), "1:2": (np.pi / 2, 0.8674, 2)}


def island(angle, rate, revolutions, alpha2=0.78, e=0.1):
    """Rate at the periapsis and multiplier of the symmetric motion x'' = -alpha2/(2 r^3) sin 2(x - f) near a rate."""

    def rates(E, y):  # x, x', and two columns of small motions
        x, v, dx, dv = y[0], y[1], y[2:4], y[4:]
        r, f = 1 - e * np.cos(E), 2 * np.arctan(np.sqrt((1 + e) / (1 - e)) * np.tan(E / 2))
        pull = alpha2 / (2 * r**3)
        return r * np.array([v, -pull * np.sin(2 * (x - f)), *dv, *(-2 * pull * np.cos(2 * (x - f)) * dx)])

    def moved(rate, E):
        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
        return solve_ivp(rates, (0, E), (angle, rate, 1, 0, 0, 1), **options).y[:, -1]

    half = np.pi * revolutions
    turns = np.round(2 * (moved(rate, half)[0] - angle) / np.pi) / 2 * np.pi
    exact = brentq(lambda rate: moved(rate, half)[0] - angle - turns, rate - 5e-3, rate + 5e-3, xtol=1e-15)
    end = moved(exact, 2 * half)
    return exact, np.arccos((end[2] + end[5]) / 2)


@pytest.mark.parametrize("name", ISLANDS)
def test_librations_on_the_islands_of_hyperion(name):
    angle, guess, revolutions = ISLANDS[name]
    rate, turn = island(angle, guess, revolutions)
    hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)
    system = pt.System(hyperion, pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)))
    turned = Rotation.from_rotvec(np.multiply.outer(angle + np.array([0.0, *SIZES]), (0, 0, 1.0)))
    start = hyperion.state(turned, omega_space=(0, 0, rate))
    times = np.arange(512) * 2 * np.pi * revolutions
    motion = pt.propagate(system, start, times, formulation="planar", progress=False)
    signals = away_from(turned[0], motion, pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0)))[1:, :, 2]
    np.testing.assert_allclose(vanishing(signals, times, 1) * times[1], turn, rtol=1e-8)


# ---------------------------------------------------------------------- chaos


def test_chaos_of_hyperion_drifts_and_its_regular_motions_do_not():
    ellipse = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.123233)
    hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)
    rates = np.array([0.3, 3.2, 1.0, 2.0])  # at the periapsis; the first librates, the second circulates
    spins = rates[:, None] * (0, 0, 1.0)
    start = hyperion.state(np.broadcast_to((1.0, 0, 0, 0), (4, 4)), omega_space=spins)
    times = np.arange(2048) * ellipse.period / 16
    motion = pt.propagate(pt.System(hyperion, pt.GravityGradient(ellipse)), start, times, progress=False)
    turning = (motion.quaternion[..., 0] + 1j * motion.quaternion[..., 3]) ** 2  # exp(i theta)
    drift = np.abs(pt.analysis.diffusion(turning, times)[:, 0])
    assert np.all(drift[:2] < 1e-7)
    assert np.all(drift[2:] > 1e-5)  # which drift is a draw: 1e-3 is the smallest of 32
