"""Periodic motions of two bodies in turning axes: small oscillations, Kepler's orbits, and their equations by SciPy."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt

analysis = pt.analysis
TRIAXIAL, LONG = pt.Body.from_ellipsoid(1.0, (1.1, 1.0, 0.8)), pt.Body.from_ellipsoid(0.1, (0.5, 0.4, 0.3))
FLAT = pt.Body.from_ellipsoid(1.0, (1.0, 1.0, 0.8))
BOTH = pt.TwoBodies(TRIAXIAL, LONG, G=1.0)
SPINNING = pt.TwoBodies(FLAT, LONG, G=1.0)


def system_of(pair) -> Any:
    return pt.System(pair, pt.forces.MutualGravity())


def at_rest(pair):
    guess = pair.doubly_synchronous(distance=4.0) if pair is BOTH else pair.synchronous(distance=4.0, primary_rate=0.3)
    return analysis.pair_equilibria(system_of(pair), guess)[0]


def oscillation(pair, number, amplitude) -> tuple[Any, Any]:
    rest = at_rest(pair)
    guess = rest.displaced(number, amplitude)
    return rest, analysis.periodic_motion(system_of(pair), guess, 2 * np.pi / rest.frequencies[number])


# ---------------------------------------------------------------------- small oscillations


# The second and the fourth of a spinning primary are near a resonance of three modes.
@pytest.mark.parametrize(("pair", "number"), [*((BOTH, k) for k in range(1, 7)), (SPINNING, 3), (SPINNING, 5)])
def test_small_oscillations_are_those_of_the_linear_equations(pair, number):
    off = []
    for amplitude in (1e-3, 2e-3):
        rest, found = oscillation(pair, number, amplitude)
        period = 2 * np.pi / rest.frequencies[number]
        linear = list(np.exp(rest.eigenvalues * period))
        for one in (1.0, 1.0):  # of the energy and of the time
            linear.pop(int(np.argmin(np.abs(np.array(linear) - one))))
        assert len(linear) == found.multipliers.size == (12 if pair is BOTH else 10)
        apart = [np.min(np.abs(found.multipliers - each)) for each in linear]
        off.append([found.period / period - 1, found.turn / (np.linalg.norm(rest.rate) * period) - 1, np.max(apart)])
        assert found.stable
    assert np.max(np.abs(off[0])) < 1e-3
    ratios = np.divide(*off[::-1])
    assert np.all(np.abs(ratios - 4) < 0.05), ratios  # the amplitude squared


def test_a_relative_equilibrium_repeats_itself_after_any_period():
    rest = at_rest(BOTH)
    found = analysis.periodic_motion(system_of(BOTH), rest.state, 20.0)
    assert abs(found.period - 20.0) < 1e-12
    assert abs(found.turn - 20.0 * np.linalg.norm(rest.rate)) < 4e-14
    expected = np.exp(20.0 * rest.eigenvalues)
    assert np.max(np.min(np.abs(found.multipliers[:, None] - expected), axis=0)) < 1e-12


# ---------------------------------------------------------------------- large motions


def rates(pair):
    """Newton's and Euler's equations of second degree, with matrices."""
    tensors = [np.asarray(body.inertia) for body in pair.bodies.values()]
    (m1, m2), inverse = map(float, pair.masses), [np.linalg.inv(tensor) for tensor in tensors]
    trace = m1 * np.trace(tensors[1]) + m2 * np.trace(tensors[0])

    def of(t, y):  # noqa: ARG001
        r, v, turns, omegas = y[:3], y[3:6], y[6:24].reshape(2, 3, 3), y[24:].reshape(2, 3)
        d, space = np.sqrt(r @ r), [turn @ tensor @ turn.T for turn, tensor in zip(turns, tensors, strict=True)]
        J = m1 * space[1] + m2 * space[0]
        force = -m1 * m2 * r / d**3 - 1.5 * trace * r / d**5 - 3 * J @ r / d**5 + 7.5 * (r @ J @ r) * r / d**7
        turning, speeding = [], []
        for other, turn, tensor, solve, w in zip((m2, m1), turns, tensors, inverse, omegas, strict=True):
            u = turn.T @ r
            turning.append(turn @ np.cross(np.eye(3), w))
            speeding.append(solve @ (3 * other * np.cross(u, tensor @ u) / d**5 - np.cross(w, tensor @ w)))
        return np.concatenate([v, force * (m1 + m2) / (m1 * m2), np.ravel(turning), np.ravel(speeding)])

    return of


def seen_from_the_secondary(y, symmetric):
    """What no turn of space changes, nor a spin of a symmetric primary."""
    turns, omegas = y[6:24].reshape(2, 3, 3), y[24:].reshape(2, 3)
    first = turns[1].T @ turns[0]
    seen = [turns[1].T @ y[:3], turns[1].T @ y[3:6], omegas[1], first[:, 2], first @ omegas[0]]
    return np.concatenate(seen if symmetric else [*seen, *first])


def start_of(found, pair):
    bodies = [found.state.primary, found.state.secondary]
    turns = [Rotation.from_quat(each.quaternion, scalar_first=True).as_matrix() for each in bodies]
    omegas = [
        np.linalg.solve(body.inertia, each.angular_momentum_body)
        for body, each in zip(pair.bodies.values(), bodies, strict=True)
    ]
    velocity = found.state.momentum / pair.reduced_mass
    return np.concatenate([found.state.position, velocity, np.ravel(turns), np.ravel(omegas)])


def eccentric(pair):
    """A synchronous secondary on an ellipse."""
    orbit = pt.KeplerOrbit(pair.mu, semimajor_axis=4.0, eccentricity=0.15)
    rates = [(0, 0, 0.3), (0, 0, orbit.mean_motion)]
    start = pair.state_on(orbit, [(1, 0, 0, 0)] * 2, omega_body=rates)
    return analysis.periodic_motion(system_of(pair), start, orbit.period)


@pytest.mark.parametrize(
    ("found", "pair"),
    [
        (lambda: oscillation(BOTH, 2, 0.1)[1], BOTH),
        (lambda: oscillation(BOTH, 4, 0.1)[1], BOTH),
        (lambda: eccentric(SPINNING), SPINNING),
    ],
)
def test_another_integration_comes_back(found, pair):
    motion = found()
    start = start_of(motion, pair)
    run = solve_ivp(rates(pair), (0, motion.period), start, method="DOP853", rtol=3e-14, atol=1e-15, dense_output=True)
    first, last = (seen_from_the_secondary(run.y[:, i], pair is SPINNING) for i in (0, -1))
    assert np.max(np.abs(last - first)) < 1e-11
    middle = seen_from_the_secondary(run.sol(0.4 * motion.period), pair is SPINNING)
    assert np.max(np.abs(middle - first)) > 0.05
    longitudes = np.unwrap(np.arctan2(*run.y[1::-1]))
    if np.ptp(run.y[2]) < 1e-9:
        assert abs(motion.turn - (longitudes[-1] - longitudes[0])) < 3e-13


def test_energy_and_angular_momentum_are_those_of_the_guess():
    system = system_of(SPINNING)
    orbit = pt.KeplerOrbit(SPINNING.mu, semimajor_axis=4.0, eccentricity=0.1)
    tilted = (np.cos(0.02), np.sin(0.02), 0, 0)
    guess = SPINNING.state_on(orbit, [(1, 0, 0, 0), tilted], omega_body=[(0, 0, 0.3), (0, 0, orbit.mean_motion)])
    found: Any = analysis.periodic_motion(system, guess, orbit.period)
    assert found.system.energy(found.state) == pytest.approx(system.energy(guess), rel=1e-14, abs=0)
    assert np.allclose(found.state.angular_momentum_space, guess.angular_momentum_space, rtol=0, atol=1e-15)
    assert found.state.primary.angular_momentum_body[2] == pytest.approx(0.3 * 0.4, rel=1e-12, abs=0)
    assert np.ptp(found.over_period().distance) > 0.5  # not the relative equilibrium


@pytest.mark.parametrize("number", [2, 4])
def test_motions_repeat_themselves_in_their_frame(number):
    """Multiples of the residual of one period, along the axes of the frame."""
    _, found = oscillation(BOTH, number, 0.1)
    motion: Any = pt.propagate(found.system, found.state, [0, found.period, 2 * found.period])
    back = found.frame.attitude(motion.times).inv()
    for seen in (back.apply(motion.position), back.apply(motion.velocity)):
        assert np.max(np.abs(seen - seen[0])) < 1e-11
    for body in (motion.primary, motion.secondary):
        assert np.max((back * body.attitude * (back[0] * body.attitude[0]).inv()).magnitude()) < 1e-11
        assert np.max(np.abs(body.omega_body - body.omega_body[0])) < 1e-13


def test_the_matrix_is_that_of_differences():
    _, found = oscillation(BOTH, 4, 0.1)
    pair, h = BOTH, 1e-5
    x = np.zeros(18)
    x[[1, 8, 12, 16]] = 0.3, -0.2, 0.5, 0.02

    def after(share):
        turns = [Rotation.from_rotvec(share * v) for v in (x[:3], x[6:9])]
        bodies = [found.state.primary, found.state.secondary]
        attitudes = [each.attitude * turn for each, turn in zip(bodies, turns, strict=True)]
        position, momentum = found.state.position + share * x[12:15], found.state.momentum + share * x[15:]
        omegas = [
            body.omega(each.angular_momentum_body) for body, each in zip(pair.bodies.values(), bodies, strict=True)
        ]
        start = pair.state(position, momentum / pair.reduced_mass, attitudes, omega_body=omegas)
        motion: Any = pt.propagate(found.system, start, [found.period])
        back = found.frame.attitude(found.period).inv()
        return back, motion

    (back, plus), (_, minus) = after(h), after(-h)
    moved = found.matrix @ x
    assert np.allclose(back.apply(plus.position[0] - minus.position[0]) / (2 * h), moved[12:15], rtol=0, atol=1e-6)
    for i, body in enumerate(("primary", "secondary")):
        one, other = getattr(plus, body), getattr(minus, body)
        turn = (other.attitude[0].inv() * one.attitude[0]).as_rotvec() / (2 * h)
        assert np.allclose(turn, moved[6 * i : 6 * i + 3], rtol=0, atol=1e-6)


def test_two_spheres_keep_keplers_period():
    ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    orbit = pt.KeplerOrbit(2.0, semimajor_axis=3.0, eccentricity=0.3, inclination=0.4, node=0.3)
    start = pair.state_on(orbit, [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0)] * 2)
    found = analysis.periodic_motion(system_of(pair), start, 1.0005 * orbit.period)
    mean: Any = pt.propagate(found.system, found.state, [found.period / 2])
    axis = mean.elements.semimajor_axis[0]
    assert abs(found.period / (2 * np.pi * np.sqrt(axis**3 / 2.0)) - 1) < 3e-14
    assert abs(found.turn - 2 * np.pi) < 1e-12
    assert np.allclose(found.multipliers, 1.0, rtol=0, atol=1e-4)  # the fourth root of rounding: all are one


# ---------------------------------------------------------------------- what is refused


def test_what_is_refused():
    system, rest = system_of(BOTH), at_rest(BOTH)
    with pytest.raises(ValueError, match=r"frame must be left out of two bodies, got RotatingFrame\. The motion has"):
        analysis.periodic_motion(system, rest.state, 20.0, pt.RotatingFrame((1, 0, 0, 0), (0, 0, 1)))
    motion = analysis.periodic_motion(system, rest.state, 20.0)
    with pytest.raises(ValueError, match=r"motion must be of one body, got one of two bodies\. Take their values one"):
        analysis.continue_motion(motion, "G", 1.1)
    one = TRIAXIAL.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    with pytest.raises(TypeError, match=r"guess must be a PairState of two bodies, got a State\."):
        analysis.periodic_motion(system, one, 1.0)
    with pytest.raises(TypeError, match=r"guess must be a State of one body, got a PairState\."):
        analysis.periodic_motion(pt.System(TRIAXIAL), rest.state, 1.0)
