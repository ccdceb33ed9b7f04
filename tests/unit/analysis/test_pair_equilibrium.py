"""Relative equilibria of two bodies, against closed forms, 40-digit differences and published resonances."""

import json
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

CASES = Path(__file__).parents[2] / "oracles" / "pair_cases.json"
CASE = next(c for c in json.loads(CASES.read_text())["cases"] if c["name"] == "doubly_synchronous")
EQUAL = pt.TwoBodies(*(pt.Body.from_inertia(CASE[f"inertia{i}"], CASE[f"mass{i}"]) for i in (1, 2)), G=CASE["G"])
GRAVITY = pt.forces.MutualGravity()
FLAT, LONG = pt.Body.from_ellipsoid(1.0, (1.0, 1.0, 0.8)), pt.Body.from_ellipsoid(0.02, (0.3, 0.25, 0.2))
PAIR = pt.TwoBodies(FLAT, LONG, G=1.0)


def found_near(pair, guess, **kwargs):
    return pt.analysis.pair_equilibria(pt.System(pair, GRAVITY), guess, **kwargs)


# ---------------------------------------------------------------------- equations of Euler and Newton in 40 digits


def skew(v):
    return mp.matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turned(theta):
    """The matrix of a small turn, to its fifth order."""
    K = skew(theta)
    return mp.eye(3) + K + K * K / 2 + K * K * K / 6 + K * K * K * K / 24


def flow(pair, A, g, r, p, rate, spins):
    """Rates of rotation vectors and momenta along axes of the bodies, place and momentum in the turning axes."""
    m1, m2 = (mp.mpf(float(m)) for m in pair.masses)
    G, mu = mp.mpf(float(pair.G)), m1 * m2 / (m1 + m2)
    own = [mp.matrix(np.asarray(body.inertia).tolist()) for body in pair.bodies.values()]
    tensors = [A[i] * own[i] * A[i].T for i in range(2)]
    d = mp.sqrt((r.T * r)[0])
    S = m1 * sum(tensors[1][k, k] for k in range(3)) + m2 * sum(tensors[0][k, k] for k in range(3))
    J = m1 * tensors[1] + m2 * tensors[0]
    force = -G * m1 * m2 / d**3 * r
    force += G / 2 * (-3 * S / d**5 * r - 6 / d**5 * (J * r) + 15 * (r.T * J * r)[0] / d**7 * r)
    rates = []
    for i, other in ((0, m2), (1, m1)):
        torque = 3 * G * other / d**5 * (A[i].T * (skew(r) * (tensors[i] * r)))
        omega = mp.lu_solve(own[i], g[i])
        rates += [*(omega - A[i].T * rate - spins[i]), *(torque + skew(g[i]) * (omega - spins[i]))]
    return mp.matrix([*rates, *(p / mu - skew(rate) * r), *(force - skew(rate) * p)])


def matrix_by_differences(pair, equilibrium, spins=((0, 0, 0), (0, 0, 0))):
    """Return the rates at an equilibrium and their derivatives, all in 40 digits."""
    with mp.workdps(40):
        states = list(equilibrium.state.of_bodies.values())
        A = [mp.matrix(s.attitude.as_matrix().tolist()) for s in states]
        g = [mp.matrix(s.angular_momentum_body.tolist()) for s in states]
        r, p, rate = (
            mp.matrix(v.tolist()) for v in (equilibrium.state.position, equilibrium.state.momentum, equilibrium.rate)
        )
        spins = [mp.matrix(list(spin)) for spin in spins]
        n, d = float(mp.norm(rate)), equilibrium.distance
        J = [float(max(body.moments)) for body in pair.bodies.values()]
        units = np.array([1] * 3 + [J[0] * n] * 3 + [1] * 3 + [J[1] * n] * 3 + [d] * 3 + [float(mp.norm(p))] * 3)
        h = mp.mpf(10) ** -12
        columns = []
        for k in range(18):
            ends = []
            for way in (1, -1):
                x = mp.zeros(18, 1)
                x[k] = way * h * units[k]
                moved = [A[0] * turned(x[0:3]), A[1] * turned(x[6:9])]
                ends.append(flow(pair, moved, [g[0] + x[3:6], g[1] + x[9:12]], r + x[12:15], p + x[15:18], rate, spins))
            columns.append((ends[0] - ends[1]) / (2 * h))
        scaled = mp.matrix(18, 18)
        for k, column in enumerate(columns):
            for i in range(18):
                scaled[i, k] = column[i] / units[i] / n
        at_rest = np.array([float(x) for x in flow(pair, A, g, r, p, rate, spins)]) / units / n
        eigenvalues = np.array([complex(x) for x in mp.eig(scaled, left=False, right=False)]) * n
        return at_rest, np.array(scaled.tolist(), dtype=float), units, eigenvalues


def spun(found, pair):
    """How fast the bodies spin against the turning axes, along their own."""
    each = zip(pair.bodies.values(), found.state.of_bodies.values(), strict=True)
    return [body.omega(s.angular_momentum_body) - s.attitude.inv().apply(np.array(found.rate)) for body, s in each]


BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
TILTED = pt.TwoBodies(BALL, pt.Body((0.01, 0.01, 0.013), mass=0.02), G=1.0)


def tilted(angle, rotation=(0, 0, 0)):
    """A symmetric body with its axis across the line of centres: C omega_3 = A n cos(angle) makes g parallel to n."""
    start = TILTED.doubly_synchronous(distance=4.0)
    velocity = start.momentum / TILTED.reduced_mass
    pull = 3 * (0.01 * 2 + 0.013 - 3 * 0.01) / (2 * 0.02 * 16)
    n = np.array([0, 0, np.sqrt(1.02 / 64 * (1 + pull))])
    turn = Rotation.from_rotvec([angle, 0, 0])
    rate = turn.inv().apply(n)
    rate[2] *= 0.01 / 0.013
    attitudes = [(1, 0, 0, 0), turn * Rotation.from_rotvec(rotation)]
    return TILTED.state(start.position, 4.0 * n[2] * velocity / velocity[1], attitudes, omega_body=[n, rate])


@pytest.mark.parametrize("which", ["doubly synchronous", "synchronous", "tilted"])
def test_linear_equations_are_those_of_40_digits(which):
    pair, guess, trivial = {
        "doubly synchronous": (EQUAL, EQUAL.doubly_synchronous(distance=2500.0), 4),
        "synchronous": (PAIR, PAIR.synchronous(distance=4.0, primary_rate=2.3), 6),
        "tilted": (TILTED, tilted(0.4, (0.02, 0.03, 0)), 8),
    }[which]
    (found,) = found_near(pair, guess)
    spins = spun(found, pair)
    at_rest, scaled, units, eigenvalues = matrix_by_differences(pair, found, spins)
    n = np.linalg.norm(found.rate)
    assert np.max(np.abs(at_rest)) < 1e-12  # where Newton's method ends
    assert np.max(np.abs(found.matrix * units / units[:, None] / n - scaled)) < 1e-14 * np.max(np.abs(scaled))
    assert found.eigenvalues.size == 18 - trivial
    # of the trivial ones a pair is at the rate; the others are zero, to the root of the rounding of the state
    oscillating = np.sort(eigenvalues.imag[eigenvalues.imag > 1e-3 * n])
    assert oscillating.size == found.frequencies.size + 1
    left = np.delete(oscillating, np.argmin(np.abs(oscillating - n)))
    assert np.allclose(found.frequencies, left, rtol=1e-10, atol=0)


def test_frequencies_are_those_of_small_motions():
    (found,) = found_near(PAIR, PAIR.doubly_synchronous(distance=3.0))
    n = np.linalg.norm(found.rate)
    small = Rotation.from_rotvec([0, 0, 1e-5])
    start = PAIR.state(
        found.state.position,
        found.state.momentum / PAIR.reduced_mass,
        [found.state.primary.attitude, found.state.secondary.attitude * small],
        omega_space=[found.rate] * 2,
    )
    motion: Any = pt.propagate(pt.System(PAIR, GRAVITY), start, np.linspace(0, 200 * 2 * np.pi / n, 4096))
    yaw = pt.analysis.librations(motion).yaw
    lines = pt.analysis.frequencies(yaw, motion.times, 2).frequencies
    for line in lines[lines > 0.01 * n]:
        assert np.min(np.abs(found.frequencies / line - 1)) < 1e-7


# ---------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("turn", [(0, 0, 0), (0.05, -0.1, 0.2)])
def test_the_rate_from_a_nearby_guess_agrees_with_the_closed_form(turn):
    guess = EQUAL.doubly_synchronous(distance=2500.0)
    shaken = guess.secondary.attitude * Rotation.from_rotvec(turn)
    near = EQUAL.state(guess.position, (0, 0.22, 0.003), [(1, 0, 0, 0), shaken], omega_body=[(0, 0, 1e-4)] * 2)
    distances = [2500.0, 2000.0, 4000.0]
    for equilibrium, distance in zip(found_near(EQUAL, near, distances=distances), distances, strict=True):
        exact = EQUAL.doubly_synchronous(distance=distance)
        w = np.linalg.norm(exact.momentum) / EQUAL.reduced_mass / distance
        assert equilibrium.distance == pytest.approx(distance, rel=1e-15, abs=0)
        assert abs(np.linalg.norm(equilibrium.rate) / w - 1) < 1e-12
        along = Rotation.from_quat(equilibrium.state.primary.quaternion, scalar_first=True).inv()
        assert np.allclose(np.abs(along.apply([1, 0, 0])), [1, 0, 0], rtol=0, atol=1e-11)


@pytest.mark.parametrize(("ratio", "resonance"), [(np.sqrt(2), 1.0), (np.sqrt(13 / 11), 0.5)])
def test_published_resonances_of_a_synchronous_secondary(ratio, resonance):
    """A uniform ellipsoid about a point librates at the orbital frequency for a/b = sqrt 2, at half of it for 1.087."""
    assert round(ratio, 3) in (1.414, 1.087)
    pair = pt.TwoBodies(pt.Body((1e-9,) * 3, mass=1.0), pt.Body.from_ellipsoid(1e-9, (ratio, 1.0, 0.9)), G=1.0)
    (found,) = found_near(pair, pair.synchronous(distance=1e4, primary_rate=1.0))
    frequencies = found.frequencies / np.linalg.norm(found.rate)
    # the shape changes the orbit by 3/2 (A/d)^2, and splits two equal frequencies by the root of it
    assert np.min(np.abs(frequencies - resonance)) < (1e-8 if resonance < 1 else 1e-4)


def test_close_pairs_have_more_energy_than_others_of_their_angular_momentum():
    """L = (mu r^2 + C1 + C2) w(r) is least where the minimum of the energy ends (Darwin)."""
    body = pt.Body.from_ellipsoid(1.0, (1.02, 1.0, 0.98))
    pair = pt.TwoBodies(body, body, G=1.0)

    def momentum(r):
        return np.linalg.norm(pair.doubly_synchronous(distance=r).angular_momentum_space)

    r = np.linspace(2.05, 4, 201)
    least = r[np.argmin([momentum(x) for x in r])]
    far, near = found_near(pair, pair.doubly_synchronous(distance=4.0), distances=[1.01 * least, 0.99 * least])
    assert (far.stability, far.stable) == ("lyapunov", True)
    assert near.stability == "unstable"
    assert near.growth_rates.size == 1


def test_a_body_across_the_line_of_centres_falls_over():
    turn = Rotation.from_rotvec([0, 0, np.pi / 2])
    guess = PAIR.doubly_synchronous(distance=40.0)
    speed = guess.momentum / PAIR.reduced_mass
    attitudes, rates = [(1, 0, 0, 0), turn], [(0, 0, 1.0), (0, 0, speed[1] / 40.0)]
    (found,) = found_near(PAIR, PAIR.state(guess.position, speed, attitudes, omega_space=rates))
    a, b, c = LONG.moments
    assert found.stability == "unstable"
    # the secondary pulls at its orbit by its moments over mu r^2, here 2e-5, with factors of a few
    growth = found.growth_rates[-1] / np.linalg.norm(found.rate)
    assert growth == pytest.approx(np.sqrt(3 / 1.02 * (b - a) / c), rel=2e-4)  # the primary has 1 of 1.02


class Repulsion(pt.Potential):
    """What no expansion of gravity has."""

    strength: float

    def energy(self, instant):
        axis = instant.secondary.attitude.to_space((0.6, 0.0, 0.8))
        return self.strength * pt.functions.dot(axis, instant.separation) ** 2 / instant.distance**8


def test_other_potentials_have_other_equilibria():
    system = pt.System(PAIR, GRAVITY, Repulsion(0.3))
    (found,) = pt.analysis.pair_equilibria(system, PAIR.synchronous(distance=3.0, primary_rate=1.5))
    assert np.linalg.norm(found.state.secondary.quaternion[1:]) > 0.01
    n = np.linalg.norm(found.rate)
    motion: Any = pt.propagate(system, found.state, np.linspace(0, 10 / n, 5))
    assert np.ptp(motion.distance) < 1e-11
    relative = motion.secondary.relative_to(motion.orbit_frame)
    assert np.max(np.abs(relative.omega_body)) < 1e-11
    assert np.ptp(np.abs(relative.quaternion), axis=0).max() < 1e-11


class Drag(pt.mechanics.PairLoad):
    k: float

    def load(self, instant):
        nothing = pt.functions.Vector((0.0, 0.0, 0.0))
        return pt.mechanics.Load(-self.k * instant.relative_velocity, (nothing, nothing))


TRIAXIAL = pt.TwoBodies(pt.Body.from_ellipsoid(1.0, (1.1, 1.0, 0.8)), LONG, G=1.0)


@pytest.mark.parametrize(
    ("find", "sentence"),
    [
        (
            lambda: pt.analysis.pair_equilibria(
                pt.System(PAIR, GRAVITY, Drag(0.1)), PAIR.doubly_synchronous(distance=4.0)
            ),
            r"must conserve the energy and the angular momentum of two bodies, got integrals none\. Leave out",
        ),
        (
            lambda: found_near(PAIR, PAIR.doubly_synchronous(distance=np.array([4.0, 5.0]))),
            r"system and guess must be single ones, got an ensemble",
        ),
        (
            lambda: found_near(PAIR, PAIR.doubly_synchronous(distance=4.0), distances=[-1.0]),
            r"distances must be positive",
        ),
        (
            lambda: found_near(TRIAXIAL, TRIAXIAL.doubly_synchronous(distance=4.0), distances=[1e-9]),
            r"guess must be near a relative equilibrium, got none at the distance 1e-09",
        ),
        (
            lambda: pt.analysis.equilibria(pt.System(PAIR, GRAVITY)),
            r"must be a System of one body, got one of two bodies\. .* and pair_equilibria\.",
        ),
    ],
)
def test_what_is_refused(find, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        find()


def test_a_frequency_that_there_is_not_is_refused():
    body = pt.Body.from_ellipsoid(1.0, (1.2, 1.0, 0.9))
    pair = pt.TwoBodies(body, body, G=1.0)
    (rest,) = pt.analysis.pair_equilibria(
        pt.System(pair, pt.forces.MutualGravity()), pair.doubly_synchronous(distance=9.0)
    )
    last = len(rest.frequencies) - 1
    for wrong in (last + 1, -last - 2):
        with pytest.raises(
            ValueError, match=f"^number must be a whole number from {-last - 1} to {last}, got {wrong}.$"
        ):
            rest.displaced(wrong, 0.01)


@pytest.mark.parametrize("amplitude", [1e200, -1e308, 3.2])
def test_amplitudes_of_more_than_half_a_turn_raise_an_error(amplitude):
    body = pt.Body.from_ellipsoid(1.0, (1.2, 1.0, 0.9))
    pair = pt.TwoBodies(body, body, G=1.0)
    (rest,) = pt.analysis.pair_equilibria(
        pt.System(pair, pt.forces.MutualGravity()), pair.doubly_synchronous(distance=9.0)
    )
    with pytest.raises(ValueError) as caught:
        rest.displaced(-1, amplitude)
    assert str(caught.value) == (
        f"amplitude must be at most pi in size, got {amplitude!r}. Linear equations hold for small ones."
    )
