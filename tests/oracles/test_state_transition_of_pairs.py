"""State transition of two bodies against equations written by hand, differentiated by a complex step, and integrated
by SciPy; and the Poisson structure.
"""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import poinsot as pt

NUMBERS = {"I1": (2.0, 2.5, 3.0), "I2": (0.1, 0.12, 0.15), "masses": (3.0, 0.5), "G": 1.0}
TURNS = [np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]
T = np.array([2.0, 9.0])


def pair_of(I1, I2, masses, G):
    return pt.TwoBodies(pt.Body(I1, mass=masses[0]), pt.Body(I2, mass=masses[1]), G=G)


def start_of(pair):
    rates = [(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)]
    return pair.state((4.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=rates)


SYSTEM = pt.System(pair_of(**NUMBERS), pt.forces.MutualGravity())
START = start_of(SYSTEM.body)


def hat(x):
    zero = np.zeros_like(x[0])
    return np.array([[zero, -x[2], x[1]], [x[2], zero, -x[0]], [-x[1], x[0], zero]])


def vee(m):
    return np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / 2


def field(_, y, I1, I2, masses, G):
    """The equations of motion with rotation matrices: (R1, g1, R2, g2, r, p) of each column."""
    y = y.reshape(30, -1)
    r, p = y[24:27], y[27:]
    distance = np.sqrt(np.sum(r * r, axis=0))
    rates, force = [], -G * masses[0] * masses[1] * r / distance**3
    for k, (moments, other) in enumerate(((I1, masses[1]), (I2, masses[0]))):
        R, g = y[12 * k : 12 * k + 9].reshape(3, 3, -1), y[12 * k + 9 : 12 * k + 12]
        moments = np.reshape(moments, (3, 1))
        omega, x = g / moments, np.einsum("jic,jc->ic", R, r)
        about = np.sum(moments * x * x, axis=0)
        # V = -G m / (2 r^3) (tr I - 3 x.I x / r^2), x = R^T r
        slope = -G * other / 2 * (-6 * moments * x / distance**5)
        force = force + G * other / 2 * (-3 * np.sum(moments) * r / distance**5 + 15 * about * r / distance**7)
        force = force - np.einsum("ijc,jc->ic", R, slope)
        turned = np.einsum("ijc,jkc->ikc", R, hat(omega))
        gyration, torque = np.cross(g, omega, axis=0), np.cross(x, slope, axis=0)
        rates += [turned.reshape(9, -1), gyration + torque]
    mu = masses[0] * masses[1] / (masses[0] + masses[1])
    return np.concatenate([*rates, p / mu, force]).ravel()


def embedded(xi):
    """Return the start displaced by xi, (18, columns)."""
    out = []
    for k, each in enumerate((START.primary, START.secondary)):
        R = [each.attitude.as_matrix() @ expm(hat(theta)) for theta in xi[6 * k : 6 * k + 3].T]
        out += [np.reshape(R, (-1, 9)).T, each.angular_momentum_body[:, None] + xi[6 * k + 3 : 6 * k + 6]]
    return np.concatenate([*out, START.position[:, None] + xi[12:15], START.momentum[:, None] + xi[15:]])


def displacements(y, reference):
    """Return xi of columns from a reference column, at each time."""
    out = []
    for a, b in zip(y, reference, strict=True):
        xi = []
        for k in range(2):
            of = slice(12 * k, 12 * k + 9)
            turn = np.einsum("ji,jkc->ikc", b[of].reshape(3, 3), a[of].reshape(3, 3, -1))
            sine = vee(turn)
            square = np.sum(sine * sine, axis=0)
            xi += [
                sine * (1 + square / 6 + 3 * square**2 / 40),
                a[12 * k + 9 : 12 * k + 12] - b[12 * k + 9 : 12 * k + 12],
            ]
        out.append(np.concatenate([*xi, a[24:] - b[24:]]))
    return np.array(out)


def integrated(xi, **numbers):
    start = embedded(xi.astype(complex))
    numbers = NUMBERS | numbers
    found = solve_ivp(
        field, (0, T[-1]), start.ravel(), "DOP853", T, rtol=3e-14, atol=1e-15, args=tuple(numbers.values())
    )
    return np.moveaxis(found.y.reshape(30, -1, T.size), -1, 0)


REFERENCE = integrated(np.zeros((18, 1)))[:, :, :1].real
STEP = 1e-30


def test_each_column_is_the_derivative_by_the_start():
    found = pt.analysis.state_transition(SYSTEM, START, T)
    exact = displacements(integrated(1j * STEP * np.eye(18)), REFERENCE).imag / STEP
    size = np.max(np.abs(exact), axis=(0, 1))
    assert np.max(np.abs(found.matrix - exact) / size) < 3e-13
    assert found.coordinates[5:8] == ("primary.g_3", "secondary.theta_1", "secondary.theta_2")
    assert found.coordinates[11:13] == ("secondary.g_3", "position_1")


def test_sensitivities_are_the_derivatives_by_masses_moments_and_G():
    names = ["masses[1]", "primary.moments[0]", "secondary.moments[2]", "G"]
    found = pt.analysis.state_transition(SYSTEM, START, T, names).sensitivity
    i = 1j * STEP
    changed: list[Any] = [
        {"masses": (3.0, 0.5 + i)},
        {"I1": (2.0 + i, 2.5, 3.0)},
        {"I2": (0.1, 0.12, 0.15 + i)},
        {"G": 1.0 + i},
    ]
    for column, change in enumerate(changed):
        exact = displacements(integrated(np.zeros((18, 1)), **change), REFERENCE)[..., 0].imag / STEP
        size = np.max(np.abs(exact))
        assert size > 0.1
        assert np.max(np.abs(found[..., column] - exact)) < 1e-13 * size, names[column]


@pytest.mark.slow
def test_second_derivatives_are_differences_of_first_ones():
    found = pt.analysis.state_transition(SYSTEM, START, T, order=2).second
    direction, h = np.random.default_rng(3).normal(size=18), 1e-4
    direction[9:12] *= 0.1  # relative to the momentum of the secondary
    columns = {
        k: displacements(integrated(k * h * direction[:, None] + 1j * STEP * np.eye(18)), REFERENCE).imag / STEP
        for k in (-2, -1, 1, 2)
    }
    exact = (8 * (columns[1] - columns[-1]) - (columns[2] - columns[-2])) / (12 * h)
    bent = np.einsum("nijk,j->nik", found, direction)
    assert np.max(np.abs(bent - exact) / np.max(np.abs(exact), axis=(0, 1))) < 1e-7


def poisson(g1, g2):
    """Return the brackets of the 18 coordinates: canonical ones of position and momentum, those of (theta, g)."""
    bracket = np.zeros((18, 18))
    for k, g in enumerate((g1, g2)):
        own, momenta = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
        bracket[own, momenta], bracket[momenta, own] = np.eye(3), -np.eye(3)
        bracket[momenta, momenta] = hat(g)
    bracket[12:15, 15:], bracket[15:, 12:15] = np.eye(3), -np.eye(3)
    return bracket


def test_the_matrix_keeps_the_poisson_brackets():
    found = pt.analysis.state_transition(SYSTEM, START, np.linspace(5, 30, 6))
    motion: Any = found.motion
    before = poisson(START.primary.angular_momentum_body, START.secondary.angular_momentum_body)
    for i, matrix in enumerate(found.matrix):
        after = poisson(motion.primary.angular_momentum_body[i], motion.secondary.angular_momentum_body[i])
        size = np.abs(matrix) @ np.abs(before) @ np.abs(matrix).T
        assert np.max(np.abs(matrix @ before @ matrix.T - after) / size) < 1e-12


def test_members_are_those_one_by_one():
    mass = np.array([0.45, 0.5, 0.55])
    pair = pt.TwoBodies(pt.Body(NUMBERS["I1"], mass=3.0), pt.Body(NUMBERS["I2"], mass=mass), G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity())
    found = pt.analysis.state_transition(system, start_of(pair), T, ["masses[1]"])
    assert found.matrix.shape == (3, 2, 18, 18)
    alone = pt.analysis.state_transition(SYSTEM, START, T, ["masses[1]"])
    for name in ("matrix", "sensitivity"):
        one, of = getattr(alone, name), getattr(found, name)[1]
        assert np.max(np.abs(one - of)) < 1e-12 * np.max(np.abs(one))
    motions: Any = [each.motion for each in (found, alone)]
    assert np.max(np.abs(motions[0].position[1] - motions[1].position)) < 1e-13


def test_covariance_is_that_of_an_ensemble():
    random, members = np.random.default_rng(5), 4000
    sizes = np.repeat([1e-4, 1e-4, 1e-4, 1e-5, 1e-4, 1e-4], 3)
    initial = np.diag(sizes**2)
    initial[0, 12] = initial[12, 0] = 0.5 * sizes[0] * sizes[12]
    predicted = pt.analysis.state_transition(SYSTEM, START, T).covariance(initial)
    x = random.multivariate_normal(np.zeros(18), initial, members)
    pair: Any = SYSTEM.body
    bodies = [
        body.state(each.attitude * Rotation.from_rotvec(own[:, :3]), angular_momentum_body=momentum + own[:, 3:])
        for body, each, own, momentum in (
            (pair.primary, START.primary, x[:, :6], START.primary.angular_momentum_body),
            (pair.secondary, START.secondary, x[:, 6:12], START.secondary.angular_momentum_body),
        )
    ]
    starts = pt.PairState(START.position + x[:, 12:15], START.momentum + x[:, 15:], *bodies)
    motion: Any = pt.propagate(SYSTEM, starts, T, progress=False)
    for n in range(T.size):
        moved = [motion.position[:, n], motion.momentum[:, n]]
        for each in (motion.secondary, motion.primary):
            turn = Rotation.from_quat(each.quaternion[:, n], scalar_first=True)
            moved = [(turn.mean().inv() * turn).as_rotvec(), each.angular_momentum_body[:, n], *moved]
        deviations = np.sqrt(np.diag(predicted[n]))
        scatter = np.sqrt((predicted[n] ** 2 + np.outer(deviations, deviations) ** 2) / members)
        assert np.max(np.abs(np.cov(np.concatenate(moved, axis=-1).T) - predicted[n]) / scatter) < 5.5


def test_parameters_are_named_by_the_body_they_are_of():
    with pytest.raises(
        ValueError, match=r"single numbers of the system, got 'moments\[0\]'. Near: body.primary.moments"
    ):
        pt.analysis.state_transition(SYSTEM, START, T, ["moments[0]"])
