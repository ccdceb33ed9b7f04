"""What is read off a torque-free rotation, against other definitions of the same."""

import re
from fractions import Fraction
from itertools import permutations, product

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial.transform import Rotation

import poinsot as pt

EPS = np.finfo(float).eps
IDENTITY = (1, 0, 0, 0)
DIGITS = 30
ORDERS = list(permutations(range(3)))

# name: moments, momentum along the body axes
TRIAXIAL = {
    "short": ((1.25, 1.0, 0.75), (0.9, 0.3, 0.2)),
    "short, second axis, down": ((1.0, 1.25, 0.75), (0.3, -0.9, -0.2)),
    "short, third axis": ((0.75, 1.0, 1.25), (0.3, -0.5, 1.1)),
    "short, little nutation": ((1.0, 0.75, 1.25), (0.002, -0.001, 1.0)),
    "short, near the separatrix": ((1.3, 1.0, 0.8), (0.005, 0.9, 0.001)),
    "short, nearer": ((0.8, 1.0, 1.3), (1e-6, -0.9, 2e-6)),
    "short, nearly oblate": ((1.5, 1.0, 1 + 1e-9), (0.4, 0.5, -0.6)),
    "short, nearly a sphere": ((1.0, 1 + 2e-12, 1 - 3e-12), (0.1, -0.9, 0.3)),
    "short, nearly prolate": ((1.0, 1 + 1e-11, 0.6), (0.3, 1.0, 1e-11)),
    "disc": ((2.0, 1.0, 1 + 1e-6), (0.3, 0.6, 0.4)),
    "long": ((1.25, 1.0, 0.75), (0.2, 0.3, 0.9)),
    "long, first axis, down": ((0.75, 1.0, 1.25), (-0.9, 0.3, 0.2)),
    "long, second axis": ((1.0, 0.75, 1.25), (-0.5, 1.1, -0.2)),
    "long, little nutation": ((0.75, 1.25, 1.0), (-1.0, 0.003, 0.001)),
    "long, near the separatrix": ((1.3, 1.0, 0.8), (0.001, -0.9, 0.005)),
    "long, nearer": ((1.3, 0.8, 1.0), (3e-7, 1e-6, 0.9)),
    "long, nearly prolate": ((0.6, 1 + 1e-9, 1.0), (0.4, 0.5, -0.6)),
    "long, nearly oblate": ((2.0, 1.0, 1 + 1e-13), (1e-9, 1.0, 0.3)),
    "needle": ((1.0, 1e-4, 1 + 2e-5), (0.3, 0.01, 0.4)),
    "Toutatis": ((3.0836, 3.235, 1.0), (0.78, 1.89, -1.72)),
}
OFTEN = [name for name in TRIAXIAL if "near" not in name and name not in ("disc", "needle")]
"""Those in which every period is some times the shortest one."""


def rotation_of(name):
    moments, g = TRIAXIAL[name]
    body = pt.Body(moments)
    return pt.analysis.FreeRotation(body, body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g, time=0.5))


def relative(value, reference):
    return float(abs(mpf(float(value)) - reference) / abs(reference))


def apart(angles, others):
    return np.max(np.abs(np.exp(1j * np.asarray(angles)) - np.exp(1j * np.asarray(others))))


# ---------------------------------------------------------------------- the same by quadrature


class Reference:
    """The rotation in 60 digits by Landau and Lifshitz, Mechanics, Sec. 37: in T and G, where digits are plenty."""

    def __init__(self, rotation):
        g = [Fraction(x) for x in rotation.state.angular_momentum_body]
        moments = [Fraction(x) for x in rotation.body.moments]
        self.twice_energy = self.exact(sum(x * x / moment for x, moment in zip(g, moments, strict=True)))
        self.G2 = self.exact(sum(x * x for x in g))
        small, middle, large = (self.exact(moment) for moment in sorted(moments))
        with mp.workdps(60):
            self.is_long = self.twice_energy * middle > self.G2
        self.Ii, self.Ij, self.Ik = (large, middle, small) if self.is_long else (small, middle, large)

    @staticmethod
    def exact(fraction):
        with mp.workdps(60):
            return mpf(fraction.numerator) / fraction.denominator

    @property
    def rate_and_parameter(self):
        G2, T2, Ii, Ij, Ik = self.G2, self.twice_energy, self.Ii, self.Ij, self.Ik
        below = (Ik - Ij) * (G2 - T2 * Ii)
        return mp.sqrt(below / (Ii * Ij * Ik)), (Ij - Ii) * (T2 * Ik - G2) / below

    @property
    def rotation_period(self):
        with mp.workdps(60):
            rate, m = self.rate_and_parameter
            return 4 * mp.ellipk(m) / rate

    @property
    def precession_period(self):
        """From the mean of G (2 T - gk^2/Ik) / (G^2 - gk^2), the rate of the axis about the momentum."""
        with mp.workdps(60):
            _, m = self.rate_and_parameter
            G2, T2, Ii, Ik = self.G2, self.twice_energy, self.Ii, self.Ik
            largest = (G2 - T2 * Ii) * Ik / (Ik - Ii)

            def advance(amplitude):
                dn2 = 1 - m * mp.cos(amplitude) ** 2
                return mp.sqrt(G2) * (T2 - largest * dn2 / Ik) / (G2 - largest * dn2) / mp.sqrt(dn2)

            return 4 * mp.ellipk(m) * mp.pi / 2 / self.quadrature(advance, mp.sqrt(1 - m))

    @property
    def action(self):
        """(1 / 2 pi) times the integral of L dl, L^2 = (2 T - G^2 A) / (1/Ik - A), A = sin^2 l/Ii + cos^2 l/Ij."""
        with mp.workdps(60):

            def L(l):
                A = mp.sin(l) ** 2 / self.Ii + mp.cos(l) ** 2 / self.Ij
                return mp.sqrt((self.twice_energy - self.G2 * A) / (1 / self.Ik - A))

            distance = abs(1 - self.twice_energy * self.Ij / self.G2)
            return self.quadrature(L, mp.sqrt(distance)) * 2 / mp.pi

    @staticmethod
    def quadrature(function, width):
        """The integral from 0 to pi/2 of a function that has a peak or kink of some width at 0."""
        inner = [width * mpf(10) ** n for n in range(20)] if width else []
        with mp.workdps(DIGITS):
            return mp.quad(function, [0, *(x for x in inner if x < 1), mp.pi / 2])


@pytest.mark.parametrize("name", TRIAXIAL)
def test_periods_and_action_are_those_of_quadrature(name):
    rotation, reference = rotation_of(name), Reference(rotation_of(name))
    assert relative(rotation.rotation_period, reference.rotation_period) < 2 * EPS
    assert relative(rotation.precession_period, reference.precession_period) < 2 * EPS
    assert relative(rotation.actions[0], reference.action) < EPS
    assert (rotation.mode == "long-axis") == reference.is_long
    with mp.workdps(60):
        assert relative(rotation.energy, reference.twice_energy / 2) < EPS
        assert relative(rotation.angular_momentum, mp.sqrt(reference.G2)) < EPS
        assert relative(rotation.dynamic_moment, reference.G2 / reference.twice_energy) < EPS
        assert relative(rotation.modulus, mp.sqrt(reference.rate_and_parameter[1])) < EPS
        largest = max(reference.Ii, reference.Ik)
        assert relative(rotation.energy_ratio, largest * reference.twice_energy / reference.G2) < 2 * EPS


# ---------------------------------------------------------------------- the same along a motion


def propagated(rotation, end):
    start = rotation.state.time
    return pt.propagate(pt.System(rotation.body), rotation.state, [start, start + end], dense=True)


@pytest.mark.parametrize("name", [name for name in TRIAXIAL if "nearly" not in name])
def test_momentum_along_the_body_returns_after_a_rotation_period_and_not_before(name):
    rotation = rotation_of(name)
    period, G = rotation.rotation_period, rotation.angular_momentum
    motion = propagated(rotation, period)
    fractions = motion(rotation.state.time + period * np.array([0, 1 / 5, 1 / 4, 1 / 3, 1 / 2, 1]))
    off = np.linalg.norm(fractions.angular_momentum_body - TRIAXIAL[name][1], axis=-1) / G
    # Near the separatrix a perturbation grows as the momentum along the axis falls.
    lowest, highest = rotation.nutation_range
    phase = period * np.linalg.norm(rotation.body.omega(TRIAXIAL[name][1]))
    assert off[-1] < 1e-15 * (1 + phase / np.cos(highest))
    assert np.all(off[1:-1] > 1e3 * off[-1])
    assert off[-2] > 1.9 * np.sin(lowest)


def advance_of(axis, motion, times):
    """The angle by which a body axis goes round the momentum between the first and the last of dense times."""
    G = motion.angular_momentum_space[0]
    across = np.cross(G, np.roll(G, 1))
    further = np.cross(G, across) / np.linalg.norm(G)
    directions = motion(times).attitude.as_matrix()[..., axis]
    azimuth = np.unwrap(np.arctan2(directions @ further, directions @ across))
    return azimuth[-1] - azimuth[0]


@pytest.mark.parametrize("name", OFTEN)
def test_axes_go_round_the_momentum_in_their_mean_periods(name):
    rotation = rotation_of(name)
    moments = rotation.body.moments
    span = 10 * rotation.rotation_period
    motion = propagated(rotation, span)
    times = rotation.state.time + np.linspace(0, span, 4000)
    axes = {"short-axis": np.argmax(moments), "long-axis": np.argmin(moments)}
    for axis, period in (
        (axes[rotation.mode], rotation.precession_period),
        (np.argmin(moments), rotation.long_axis_precession_period),
    ):
        turns = advance_of(axis, motion, times) / (2 * np.pi)
        assert abs(turns * period / span - 1) < 1.6e-14  # three times the worst, 5.1e-15


@pytest.mark.parametrize("name", OFTEN)
def test_body_turns_about_its_axis_in_the_mean_spin_period(name):
    """The turn seen from space is l + g: from the fixed plane to the body, by way of the nodes of their planes."""
    rotation = rotation_of(name)
    axis = (np.argmax if rotation.mode == "short-axis" else np.argmin)(rotation.body.moments)
    span = 10 * rotation.rotation_period
    motion = propagated(rotation, span)
    there = motion(rotation.state.time + np.linspace(0, span, 4000))
    variables = about(there, cyclic(axis, TRIAXIAL[name][1][axis] > 0))
    turns = np.diff(np.unwrap(variables.l + variables.g)[[0, -1]])[0] / (2 * np.pi)
    assert abs(turns * rotation.spin_period / span - 1) < 1.6e-14


@pytest.mark.parametrize("name", [*OFTEN, "short, near the separatrix", "long, near the separatrix"])
def test_nutation_range_is_what_the_axis_does(name):
    rotation = rotation_of(name)
    axis = (np.argmax if rotation.mode == "short-axis" else np.argmin)(rotation.body.moments)
    motion = propagated(rotation, rotation.rotation_period)

    def tilt(times):
        g = motion(times).angular_momentum_body
        along, across = np.abs(g[..., axis]), np.linalg.norm(np.delete(g, axis, axis=-1), axis=-1)
        return np.arctan2(across, along)

    times = np.linspace(*motion.times, 201)
    samples = tilt(times)
    for sign, expected in zip((1, -1), rotation.nutation_range, strict=True):
        i = np.argmin(sign * samples[1:-1])
        found = minimize_scalar(lambda t, s=sign: s * tilt(t), bounds=times[[i, i + 2]], method="bounded")
        assert abs(sign * found.fun - expected) < 1e-13 * (1 + 1 / np.cos(expected))


@pytest.mark.parametrize("name", OFTEN)
def test_nothing_but_the_angles_depends_on_where_the_motion_is(name):
    rotation = rotation_of(name)
    motion = propagated(rotation, 2 * rotation.rotation_period)
    later = pt.analysis.FreeRotation(rotation.body, motion(np.linspace(*motion.times, 37)))
    for read in ("modulus", "precession_period", "rotation_period", "long_axis_precession_period", "energy"):
        assert np.max(np.abs(getattr(later, read) / getattr(rotation, read) - 1)) < 2e-13
    assert np.max(np.abs(np.array(later.actions) - np.array(rotation.actions)[:, None])) < 8e-15
    assert np.max(np.abs(np.array(later.nutation_range) - np.array(rotation.nutation_range)[:, None])) < 2e-15
    assert set(later.mode) == {rotation.mode}


# ---------------------------------------------------------------------- modes and degenerate cases


def special(moments, g):
    body = pt.Body(moments)
    return pt.analysis.FreeRotation(body, body.state(IDENTITY, angular_momentum_body=g))


@pytest.mark.parametrize(
    ("moments", "g", "mode"),
    [
        ((1.25, 1.0, 0.75), (0.9, 0.3, 0.2), "short-axis"),
        ((1.25, 1.0, 0.75), (0.2, 0.3, 0.9), "long-axis"),
        ((6, 4, 3), (1, 0.75, 1), "separatrix"),
        ((6, 4, 3), (-1, 0.75, 1), "separatrix"),
        ((4, 3, 6), (-(2.0**20), -0.75, 0.75), "separatrix"),
        ((6, 4, 3), (1, 0.75, 1 + EPS), "long-axis"),
        ((6, 4, 3), (1 + EPS, 0.75, 1), "short-axis"),
        ((6, 4, 3), (1, 1e9, 1 + EPS), "long-axis"),
        ((6, 4, 3), (-2, 0, 0), "principal"),
        ((6, 4, 3), (0, 2, 0), "principal"),
        ((6, 4, 3), (0, 0, -2), "principal"),
        ((6, 4, 3), (0, 2, 1e-100), "long-axis"),
        ((6, 4, 3), (1e-100, 2, 0), "short-axis"),
        ((1, 1, 1.5), (0.1, 0.2, 1e-3), "short-axis"),
        ((1, 1.5, 1), (0, 1, 0), "principal"),
        ((1, 1, 0.5), (0.1, 0.2, 1e-3), "long-axis"),
        ((0.5, 1, 1), (1, 0, 0), "principal"),
        ((1, 1, 0.5), (1, 0, 0), "principal"),
        ((1, 1, 0.5), (0, 1, 0), "principal"),
        ((1, 1, 0.5), (1, -2, 0), "principal"),
        ((1, 1, 1.5), (3, 1, 0), "principal"),
        ((2, 2, 2), (1, 2, 3), "principal"),
        ((1.25, 1.0, 0.75), (0, 0, 0), "rest"),
        ((1, 1, 1), (0, 0, 0), "rest"),
    ],
)
def test_mode(moments, g, mode):
    for order in ORDERS:
        turned = special(np.array(moments)[list(order)], np.array(g)[list(order)])
        assert turned.mode == mode


def test_rotation_about_the_principal_axes():
    about = {axis: special((6, 4, 3), 2 * np.eye(3)[axis]) for axis in range(3)}
    assert [about[axis].energy for axis in range(3)] == pytest.approx([2 / 6, 2 / 4, 2 / 3], rel=2 * EPS, abs=0)
    assert [about[axis].dynamic_moment for axis in range(3)] == pytest.approx([6, 4, 3], rel=2 * EPS, abs=0)
    assert [about[axis].energy_ratio for axis in range(3)] == pytest.approx([1, 1.5, 2], rel=2 * EPS, abs=0)
    assert [about[axis].nutation_range for axis in range(3)] == [(0, 0), (np.pi / 2, np.pi / 2), (0, 0)]
    # Small oscillations: the momentum circles the axis at G sqrt((1/Ii - 1/Ik)(1/Ij - 1/Ik)).
    circling = 2 * np.sqrt([(1 / 4 - 1 / 6) * (1 / 3 - 1 / 6), 0, (1 / 6 - 1 / 3) * (1 / 4 - 1 / 3)])
    assert [about[axis].frequencies[0] for axis in range(3)] == pytest.approx(circling * [-1, 0, 1], rel=4 * EPS, abs=0)
    # The body turns about the momentum at 2/I: the circling and the precession, in the same sense or against it.
    assert sum(about[0].frequencies) == pytest.approx(2 / 6, rel=4 * EPS, abs=0)
    assert sum(about[2].frequencies) == pytest.approx(2 / 3, rel=4 * EPS, abs=0)
    assert about[1].frequencies[1] == pytest.approx(2 / 4, rel=4 * EPS, abs=0)
    assert about[1].rotation_period == np.inf
    assert [about[axis].actions[:2] for axis in (0, 2)] == [(2, 2)] * 2


@pytest.mark.parametrize("exponent", [120, 140, 146, 152, 155, 158, 161, 165, 200, 300])
@pytest.mark.parametrize("axis", range(3))
def test_next_to_a_principal_axis_is_nearly_on_it(axis, exponent):
    g = np.full(3, 10.0**-exponent)
    g[axis] = 2.0
    rotation, steady = special((6, 4, 3), g), special((6, 4, 3), 2 * np.eye(3)[axis])
    assert rotation.energy == steady.energy
    assert rotation.dynamic_moment == steady.dynamic_moment
    logarithm = 0 if axis != 1 else 2 / exponent  # with which rate and frequency vanish on the separatrix
    assert abs(rotation.precession_period / steady.precession_period - 1) <= 2 * EPS + logarithm
    assert abs(rotation.frequencies[0] - steady.frequencies[0]) <= 2 * EPS + logarithm
    assert abs(rotation.nutation_range[1] - steady.nutation_range[1]) <= 2 * EPS
    assert abs(rotation.actions[0] - steady.actions[0]) <= 4 * EPS


@pytest.mark.parametrize(("unique", "equal"), [(1.6, 1.0), (0.3, 1.0), (1 + 1e-13, 1.0), (1.0, 1 + 1e-13)])
@pytest.mark.parametrize("axis", range(3))
def test_symmetric_body(unique, equal, axis):
    moments, g = np.full(3, equal), np.roll([0.4, -0.5, 0.6], axis)
    moments[axis] = unique
    rotation, along, G = special(moments, g), g[axis], np.linalg.norm(g)
    rate = abs(along) * (Fraction(1) / Fraction(equal) - Fraction(1) / Fraction(unique))
    assert rotation.precession_period == pytest.approx(2 * np.pi * equal / G, rel=4 * EPS, abs=0)
    assert rotation.rotation_period == pytest.approx(2 * np.pi / abs(float(rate)), rel=4 * EPS, abs=0)
    assert rotation.modulus == 0
    assert rotation.nutation_range == pytest.approx([np.arccos(abs(along) / G)] * 2, rel=4 * EPS, abs=0)
    assert rotation.actions[0] == pytest.approx(abs(along), rel=4 * EPS, abs=0)
    assert rotation.mode == ("short-axis" if unique > equal else "long-axis")
    # The rate of l is (1/I3 - 1/I1) L.
    assert rotation.frequencies[0] == pytest.approx(-float(rate), rel=4 * EPS, abs=0)


def test_sphere():
    rotation = special((2, 2, 2), (1, 2, -3))
    assert rotation.precession_period == pytest.approx(4 * np.pi / np.sqrt(14), rel=4 * EPS, abs=0)
    assert rotation.long_axis_precession_period == pytest.approx(4 * np.pi / np.sqrt(14), rel=4 * EPS, abs=0)
    assert rotation.rotation_period == np.inf
    assert rotation.dynamic_moment == pytest.approx(2, rel=2 * EPS, abs=0)
    assert rotation.energy_ratio == pytest.approx(1, rel=2 * EPS, abs=0)


def test_rest():
    rotation = special((1.25, 1.0, 0.75), (0, 0, 0))
    assert rotation.energy == rotation.angular_momentum == 0
    assert rotation.actions == (0, 0, 0)
    assert rotation.frequencies == (0, 0, 0)
    assert rotation.precession_period == rotation.rotation_period == rotation.long_axis_precession_period == np.inf


@pytest.mark.parametrize(("moments", "g"), [((6, 4, 3), (1, 0.75, 1)), ((4, 6, 3), (2.0**20, -0.75, 0.75))])
def test_separatrix(moments, g):
    rotation, middle = special(moments, g), sorted(moments)[1]
    G = np.linalg.norm(g)
    assert rotation.modulus == 1
    assert rotation.rotation_period == np.inf
    assert rotation.precession_period == pytest.approx(2 * np.pi * middle / G, rel=4 * EPS, abs=0)
    assert rotation.long_axis_precession_period == pytest.approx(2 * np.pi * middle / G, rel=4 * EPS, abs=0)
    assert rotation.dynamic_moment == pytest.approx(middle, rel=2 * EPS, abs=0)
    assert rotation.nutation_range[1] == np.pi / 2
    assert relative(rotation.actions[0], Reference(rotation).action) < 4 * EPS
    assert rotation.frequencies[0] == 0
    assert np.isnan(rotation.angles[0])


@pytest.mark.parametrize(("b", "offset"), [((0.0, 0.75, 30.0)[n % 3], 10.0**-n) for n in range(2, 16)])
def test_actions_of_both_sides_make_the_momentum_on_the_separatrix(offset, b):
    moments = (6, 4, 3)
    on_it = special(moments, (1, b, 1))
    short, long = special(moments, (1 + offset, b, 1)), special(moments, (1, b, 1 + offset))
    assert (short.mode, long.mode) == ("short-axis", "long-axis")
    G = on_it.angular_momentum
    limits = on_it.actions[0], G - on_it.actions[0]
    for side, limit in zip((short, long), limits, strict=True):
        assert relative(side.actions[0], Reference(side).action) < EPS
        # J has a square root in its rate: near it the change is as offset log offset.
        assert abs(side.actions[0] - limit) < offset * (3 + abs(np.log(offset))) + 4 * EPS * G
        assert abs(side.precession_period / on_it.precession_period - 1) < 3 / abs(np.log(offset))
    assert abs(short.actions[0] + long.actions[0] - G) < 2 * offset * (3 + abs(np.log(offset))) + 4 * EPS * G


# ---------------------------------------------------------------------- members


def test_members_are_as_one_by_one():
    pairs = [
        *TRIAXIAL.values(),
        ((6, 4, 3), (1, 0.75, 1)),
        ((6, 4, 3), (0, 1, 0)),
        ((6, 4, 3), (0, 0, -1)),
        ((1, 1, 0.5), (0.3, 0.2, 0.4)),
        ((1, 1.5, 1), (0.3, 0.2, -0.4)),
        ((1, 1, 0.5), (0.3, 0.2, 0)),
        ((1, 1, 1), (0.3, 0.2, 0.4)),
    ]
    moments, g = (np.array(values, dtype=float) for values in zip(*pairs, strict=True))
    bodies, q = pt.Body(moments), (0.5, 0.5, -0.5, 0.5)
    many = pt.analysis.FreeRotation(bodies, bodies.state(q, angular_momentum_body=g))
    single = [pt.analysis.FreeRotation(pt.Body(m), pt.Body(m).state(q, angular_momentum_body=x)) for m, x in pairs]
    assert many.mode.tolist() == [one.mode for one in single]
    for read in (
        *("modulus", "precession_period", "rotation_period", "long_axis_precession_period", "energy"),
        *("dynamic_moment", "energy_ratio", "angular_momentum"),
    ):
        assert np.array_equal(getattr(many, read), [getattr(one, read) for one in single])
    for read in ("nutation_range", "actions", "frequencies"):
        assert np.array_equal(np.transpose(getattr(many, read)), [getattr(one, read) for one in single])
    found, expected = np.transpose(many.angles), np.array([one.angles for one in single])
    assert np.array_equal(np.isnan(found), np.isnan(expected))
    assert apart(np.nan_to_num(found), np.nan_to_num(expected)) < 8 * EPS


def test_one_body_in_many_states_and_many_bodies_in_one_state():
    g = np.array([(0.9, 0.3, 0.2), (0, 0, 0), (0.2, 0.3, 0.9)])
    body = pt.Body((1.25, 1.0, 0.75))
    rotation = pt.analysis.FreeRotation(body, body.state(IDENTITY, angular_momentum_body=g))
    assert rotation.mode.tolist() == ["short-axis", "rest", "long-axis"]
    assert rotation.energy_ratio.shape == rotation.actions[2].shape == (3,)
    bodies = pt.Body([(1.25, 1.0, 0.75), (0.75, 1.0, 1.25), (1, 1, 1)])
    rotation = pt.analysis.FreeRotation(bodies, body.state(IDENTITY, angular_momentum_body=g[0]))
    assert rotation.mode.tolist() == ["short-axis", "long-axis", "principal"]
    assert rotation.energy.tolist() == pytest.approx(
        np.sum(g[0] ** 2 / bodies.moments, axis=-1) / 2, rel=4 * EPS, abs=0
    )
    assert all(x.shape == (3,) for x in (*rotation.actions, *rotation.angles, *rotation.nutation_range))


# ---------------------------------------------------------------------- actions and angles


def sixth_order(function, step):
    """The derivative at zero."""
    weights = np.array([-1, 9, -45, 45, -9, 1]) / (60 * step)
    return sum(w * function(n * step) for w, n in zip(weights, (-3, -2, -1, 1, 2, 3), strict=True))


@pytest.mark.parametrize("name", OFTEN)
def test_frequencies_are_derivatives_of_the_energy_by_the_actions(name, rng):
    moments, g = TRIAXIAL[name]
    body, smallest = pt.Body(moments), np.min(np.abs(g))
    rotation = rotation_of(name)

    def read(momentum):
        there = pt.analysis.FreeRotation(body, body.state(IDENTITY, angular_momentum_body=momentum))
        return np.array([there.energy, *there.actions[:2]])

    for _ in range(3):
        direction = rng.normal(size=3)
        energy, J, G = sixth_order(lambda x, d=direction: read(np.array(g) + x * d), 0.02 * smallest)
        assert abs(energy - (rotation.frequencies[0] * J + rotation.frequencies[1] * G)) < 1e-10
        assert abs(J) + abs(G) > 1e-3


OBLIQUE = Rotation.from_rotvec([0.4, -0.7, 0.3])


def bodies_of(moments):
    """The body along its principal axes, and along others."""
    tensor = OBLIQUE.as_matrix() @ np.diag(moments) @ OBLIQUE.as_matrix().T
    return pt.Body(moments), pt.Body.from_inertia((tensor + tensor.T) / 2)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("g", [(0.9, 0.3, 0.2), (0.2, 0.3, 0.9)])
def test_angles_grow_with_the_frequencies(order, g):
    bodies = bodies_of(np.array([1.25, 1.0, 0.75])[list(order)])
    for i, signs in enumerate(product((1, -1), repeat=3)):  # each body with an even and an odd number of reflections
        momentum, body = (np.array(signs) * g)[list(order)], bodies[i // 2 % 2]
        along = momentum if type(body) is pt.Body else OBLIQUE.apply(momentum)
        start = pt.analysis.FreeRotation(body, body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=along))
        motion = pt.propagate(pt.System(body), start.state, np.linspace(0, 2 * start.rotation_period, 21))
        there = pt.analysis.FreeRotation(body, pt.State(motion.quaternion, motion.conjugate_momenta))
        expected = np.array(start.angles)[:, None] + np.array(start.frequencies)[:, None] * motion.times
        assert apart(there.angles, expected) < 1.2e-13


@pytest.mark.parametrize(
    ("moments", "g", "offset", "mode"),
    [
        ((6, 4, 3), (1, 0.75, 1), (1, 0, 0), "short-axis"),
        ((4, 6, 3), (0.75, 1, 1), (0, 1, 0), "short-axis"),
        ((13, 12, 25), (0.75, 12, 5), (0, 0, 1), "short-axis"),
        ((9, 8, 4), (3, 0.75, 1), (0, 0, 1), "long-axis"),
    ],
)
@pytest.mark.parametrize("signs", [(1, 1, 1), (1, -1, 1), (-1, 1, 1), (-1, -1, -1)])
def test_angles_on_the_separatrix_are_limits(moments, g, offset, mode, signs):
    """Beside it they change as the first frequency, 1 / log of the offset, which two of them eliminate."""
    limit = special(moments, signs * np.array(g))
    near = [special(moments, signs * (g + size * np.array(offset))) for size in (1e-9, 1e-13)]
    assert (limit.mode, *(rotation.mode for rotation in near)) == ("separatrix", mode, mode)
    (rate, _, _), (other_rate, _, _) = (rotation.frequencies for rotation in near)
    angles, others = (np.array(rotation.angles) for rotation in near)
    extrapolated = angles + np.angle(np.exp(1j * (others - angles))) * rate / (rate - other_rate)
    assert np.isnan(limit.angles[0])
    assert apart(extrapolated[1:], limit.angles[1:]) < 1e-8
    assert apart(4 * extrapolated[0], 0) < 1e-8


def test_angles_about_the_middle_axis_are_limits_along_the_separatrix():
    steady = special((6, 4, 3), (0, 1, 0))
    assert steady.mode == "principal"
    assert np.isnan(steady.angles[0])
    near = special((6, 4, 3), (1e-9, 1, 1e-9))
    assert near.mode == "separatrix"
    assert apart(near.angles[1:], steady.angles[1:]) < 1e-8


CANONICAL = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])


MOMENTA = ((0.9, 0.3, 0.2), (0.2, 0.3, 0.9), (1.0, -0.2, -0.3), (-0.1, 0.2, -1.0), (0.7, 0.9, -0.6))


@pytest.mark.parametrize(
    ("order", "g"), [(order, MOMENTA[(i + k) % 5]) for i, order in enumerate(ORDERS) for k in (0, 2)]
)
def test_angles_and_actions_are_canonical(order, g):
    """The 15 brackets of angles and actions, by differences with respect to Andoyer's variables."""
    body, momentum = pt.Body(np.array([1.25, 1.0, 0.75])[list(order)]), np.array(g)[list(order)]
    variables = pt.Andoyer.from_state(body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=momentum))
    place = np.array([getattr(variables, name) for name in ("l", "g", "h", "L", "G", "H")])
    middle = pt.analysis.FreeRotation(body, pt.Andoyer(*place).state()).angles

    def read(numbers):
        rotation = pt.analysis.FreeRotation(body, pt.Andoyer(*numbers).state())
        angles = np.array(middle) + np.angle(np.exp(1j * (np.array(rotation.angles) - middle)))
        return np.array([*angles, *rotation.actions])

    matrix = np.array([sixth_order(lambda x, u=unit: read(place + x * u), 6e-4) for unit in np.eye(6)]).T
    assert np.max(np.abs(matrix @ CANONICAL @ matrix.T - CANONICAL)) < 1e-10


def about(state, axes):
    """Andoyer's variables with respect to other axes, columns of a rotation matrix."""
    attitude = state.attitude * Rotation.from_matrix(axes)
    return pt.Andoyer.from_state(
        pt.Body((1, 1, 1)).state(attitude, angular_momentum_body=state.angular_momentum_body @ axes)
    )


def cyclic(axis, up):
    """The axes in cyclic order with the given one third, turned over if the momentum is below."""
    axes = np.eye(3)[:, [(axis + 1) % 3, (axis + 2) % 3, axis]]
    return axes if up else axes * [1, -1, -1]


@pytest.mark.parametrize("unique", [1.6, 0.3])
@pytest.mark.parametrize("axis", range(3))
def test_angles_of_a_symmetric_body_are_those_of_andoyer(unique, axis, rng):
    moments = np.ones(3)
    moments[axis] = unique
    body = pt.Body(moments)
    for g in rng.normal(size=(8, 3)):
        rotation = pt.analysis.FreeRotation(body, body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g))
        expected = about(rotation.state, cyclic(axis, g[axis] > 0))
        assert apart(rotation.angles, (expected.l, expected.g, expected.h)) < 4e-15
        assert np.max(np.abs(np.array(rotation.actions) - [expected.L, expected.G, expected.H])) < 4 * EPS


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("axis", "across"), [(0, 1), (0, 2), (2, 0), (2, 1)])
def test_angles_are_those_of_andoyer_where_the_momentum_passes_a_plane(order, axis, across):
    """There, a quarter of a period apart, the periodic part vanishes."""
    moments, order = np.array([1.25, 1.0, 0.75]), list(order)
    body = pt.Body(moments[order])
    for signs in product((1, -1), repeat=2):
        g = np.zeros(3)
        g[[axis, across]] = np.array(signs) * (0.9, 0.2)
        rotation = pt.analysis.FreeRotation(body, body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g[order]))
        expected = about(rotation.state, cyclic(order.index(axis), signs[0] > 0))
        assert apart(rotation.angles, (expected.l, expected.g, expected.h)) < 4e-15


def test_andoyer_variables_are_those_of_the_body_axes():
    rotation = rotation_of("short")
    assert vars(rotation.andoyer) == vars(pt.Andoyer.from_state(rotation.state))
    assert np.max(np.abs(rotation.andoyer.L - 0.2)) < 2 * EPS


# ---------------------------------------------------------------------- published


def test_toutatis():
    # Takahashi, Busch and Scheeres (2013): degrees and days, the long axis third.
    body = pt.Body((3.0836, 3.235, 1))
    attitude = Rotation.from_euler("ZXZ", [145.498, 65.865, 241.524], degrees=True)
    rotation = pt.analysis.FreeRotation(body, body.state(attitude, omega_body=np.deg2rad([14.51, 33.529, -98.709])))
    assert rotation.mode == "long-axis"
    assert abs(rotation.precession_period - 7.412) < 0.0005
    assert abs(rotation.rotation_period - 5.369) < 0.0005
    assert rotation.long_axis_precession_period == rotation.precession_period


def test_apophis():
    # Pravec et al. (2014): moments, P_phi = 27.38 h and P_psi = 263 h make E/E0 = 1.024; the strongest frequency of the
    # light curve is 1/P_phi - 1/P_psi = 1/30.56 h.
    body = pt.Body((0.61, 0.965, 1.0))

    def tilted(angle):
        g = (0, np.sin(angle), np.cos(angle))
        return pt.analysis.FreeRotation(body, body.state(IDENTITY, angular_momentum_body=g))

    def off(angle):
        return tilted(angle).rotation_period / tilted(angle).precession_period - 263 / 27.38

    rotation = tilted(brentq(off, 0.1, 1.1, xtol=1e-14))
    assert rotation.mode == "short-axis"
    assert abs(rotation.energy_ratio - 1.024) < 0.0005
    assert abs(27.38 * rotation.long_axis_precession_period / rotation.precession_period - 30.56) < 0.005


# ---------------------------------------------------------------------- bad input

BODY = pt.Body((1.25, 1.0, 0.75))
STATE = BODY.state(IDENTITY, omega_body=(0.4, -0.3, 0.6))
BAD = {
    "order": (
        lambda: pt.analysis.FreeRotation(STATE, BODY),
        TypeError,
        "body must be a Body, got State. The order is FreeRotation(body, state).",
    ),
    "system": (
        lambda: pt.analysis.FreeRotation(pt.System(BODY), STATE),
        TypeError,
        "body must be a Body, got System. The order is FreeRotation(body, state).",
    ),
    "state": (
        lambda: pt.analysis.FreeRotation(BODY, (1, 0, 0, 0)),
        TypeError,
        "state must be a State, got tuple. The order is FreeRotation(body, state).",
    ),
    "members": (
        lambda: pt.analysis.FreeRotation(pt.Body(np.ones((3, 3))), pt.State(np.tile(IDENTITY, (2, 1)), (0, 1, 0, 0))),
        ValueError,
        "state and system must have equally many members, got 2 and 3.",
    ),
    "angles_at_rest": (
        lambda: special((1, 1, 1), (0, 0, 0)).angles,
        ValueError,
        "state must have an angular momentum for angles, but the body is at rest.",
    ),
    "andoyer_at_rest": (
        lambda: special((1, 1, 1), (0, 0, 0)).andoyer,
        ValueError,
        "G must be positive, got 0.0. A body at rest has no such variables.",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_wrong_arguments_get_a_sentence(name):
    call, kind, sentence = BAD[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence)}$"):
        call()


def test_repr_shows_body_and_periods():
    rotation = pt.analysis.FreeRotation(BODY, STATE)
    title, *lines = repr(rotation).splitlines()
    assert title == f"Free rotation of {BODY!r}"
    assert f"  precession period: {rotation.precession_period:.6g}" in lines


def test_spin_period_is_that_of_the_spin_where_there_is_no_nutation():
    for axis, moment in enumerate((2.0, 2.5, 3.5)):
        if axis == 1:
            continue  # the intermediate axis has no small nutation
        momentum = 0.7 * np.eye(3)[axis]
        rotation = pt.analysis.FreeRotation(
            (body := pt.Body((2.0, 2.5, 3.5))), body.state((1, 0, 0, 0), angular_momentum_body=momentum)
        )
        assert abs(rotation.spin_period / (2 * np.pi * moment / 0.7) - 1) < 1e-15


def test_a_member_at_rest_has_no_angles_and_the_others_do():
    body = pt.Body((2.0, 2.5, 3.5))
    momenta = np.array([[1.0, 2, 3], [0, 0, 0]])
    rotation = pt.analysis.FreeRotation(
        body, body.state(np.tile([1.0, 0, 0, 0], (2, 1)), angular_momentum_body=momenta)
    )
    alone = pt.analysis.FreeRotation(body, body.state((1.0, 0, 0, 0), angular_momentum_body=momenta[0]))
    assert list(rotation.mode) == [alone.mode, "rest"]
    for angles, angle in zip(rotation.angles, alone.angles, strict=True):
        assert angles[0] == angle
        assert np.isnan(angles[1])
