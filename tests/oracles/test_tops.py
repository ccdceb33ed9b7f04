"""Heavy tops: Lagrange's in closed form, the sleeping one at its limit, and Kovalevskaya's with her integral."""

import functools
from dataclasses import dataclass, replace

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from oracles import euler_newton
from oracles.lagrange_top import LagrangeTop
from poinsot.algebra import quaternion as quat

UNITS = {"lie_poisson": 10, "canonical": 25}
FORMULATIONS = pytest.mark.parametrize("formulation", UNITS)
EPSILON = np.finfo(float).eps
LEVER = 0.5
"""The distance of the centre of mass from the fixed point, so that weight and torque are different numbers."""


def largest(difference):
    return np.max(np.abs(difference))


# ---------------------------------------------------------------------- the symmetric top


@dataclass(frozen=True)
class Top:
    """A symmetric top about the third axis: A, C, M g l, and its start by Euler angles of the sequence 3-1-3."""

    transverse: float
    axial: float
    gravity: float
    tilt: float
    precession: float
    nutation: float
    axial_momentum: float
    angles: tuple[float, float] = (0.4, -1.1)

    @property
    def quaternion(self):
        (phi, psi), half = self.angles, self.tilt / 2
        upright, fallen = np.cos(half), np.sin(half)
        plus, minus = (phi + psi) / 2, (phi - psi) / 2
        return np.array(
            [upright * np.cos(plus), fallen * np.cos(minus), fallen * np.sin(minus), upright * np.sin(plus)]
        )

    @property
    def momentum(self):
        sine, cosine, across = np.sin(self.angles[1]), np.cos(self.angles[1]), self.precession * np.sin(self.tilt)
        g1, g2 = across * sine + self.nutation * cosine, across * cosine - self.nutation * sine
        return np.array([self.transverse * g1, self.transverse * g2, self.axial_momentum])

    @property
    def closed_form(self):
        return LagrangeTop(self.transverse, self.axial, self.gravity, self.quaternion, self.momentum)

    @property
    def moments(self):
        return self.transverse, self.transverse, self.axial

    def propagate(self, times, turn=(1, 0, 0, 0), lever=LEVER, start=None, **options):
        """The motion of a body whose axes are turned: `turn` takes its components to those of the symmetric top."""
        start = start or self
        to_body = np.rint(Rotation.from_quat(turn, scalar_first=True).as_matrix()).T
        body = pt.Body(np.abs(to_body) @ self.moments)
        center = to_body @ [0, 0, lever]
        q, g = quat.product(start.quaternion, turn), to_body @ start.momentum
        system = pt.System(body, pt.UniformGravity(self.gravity / LEVER, center))
        return pt.propagate(system, body.state(q, angular_momentum_body=g), times, **options)


def difference(motion, judged, turn=(1, 0, 0, 0)):
    """In the components of q, with their sign, and in g over |g|."""
    q, g = judged
    from_body = np.rint(Rotation.from_quat(turn, scalar_first=True).as_matrix())
    momenta = motion.angular_momentum_body @ from_body.T
    return max(largest(motion.quaternion - quat.product(q, turn)), largest(momenta - g) / largest(g))


def steady_precession(top, sign):
    """A root of A cos(theta) Omega^2 - p Omega + M g l = 0."""
    lever, p = top.transverse * np.cos(top.tilt), top.axial_momentum
    return (p + sign * np.sqrt(p**2 - 4 * lever * top.gravity)) / (2 * lever)


def tops(kind, A, C, P):
    slow = Top(A, C, P, 0.9, 0.0, 0.0, 2.2)
    # Through the upright G = p, which is A sin(theta)^2 Omega = p (1 - cos(theta)).
    return {
        f"{kind}, cusps": Top(A, C, P, 0.8, 0.0, 0.0, 2.1),
        f"{kind}, loops": Top(A, C, P, 0.8, -0.25, 0.0, 2.1),
        f"{kind}, monotone": Top(A, C, P, 1.1, 0.45, 0.05, 2.4),
        f"{kind}, slow steady": replace(slow, precession=steady_precession(slow, -1)),
        f"{kind}, fast steady": replace(slow, precession=steady_precession(slow, 1)),
        f"{kind}, backward loops": Top(A, C, P, 1.4, 0.6, 0.1, -1.5),
        f"{kind}, through the upright": Top(A, C, P, 0.8, 0.9 / (A * (1 + np.cos(0.8))), 1.4, 0.9),
        f"{kind}, without spin": Top(A, C, P, 2.0, 0.4, 0.3, 0.0),
    }


TOPS = {**tops("oblate", 1.0, 1.6, 0.8), **tops("prolate", 1.3, 0.4, 0.7)}
NAMES = pytest.mark.parametrize("name", TOPS)
TURNS = {
    "third axis": (1, 0, 0, 0),
    "first axis": (0.5, -0.5, -0.5, -0.5),
    "second axis": (0.5, 0.5, 0.5, 0.5),
    "third axis, downwards": (0, 1, 0, 0),
}


@functools.cache
def judged(name):
    """Times over fifty nutations, and the closed form there."""
    closed = TOPS[name].closed_form
    times = np.linspace(-10, 40, 62) * float(closed.period)
    return times, closed.states(times)


def allowed(name, formulation="lie_poisson"):
    """Units of rounding for every radian that the body turns; three times what is measured.

    A rate that is off by one unit, such as that of 1/I rounded, puts the body off by one unit for every radian;
    by more where the vertical, reached or nearly so, is unstable.
    """
    top, (times, (_, g)) = TOPS[name], judged(name)
    rates = np.linalg.norm(g / top.moments, axis=-1)
    units = UNITS[formulation] * (2 if name.endswith(("upright", "without spin")) else 1)
    return units * EPSILON * np.mean(rates) * times[-1]


@NAMES
def test_tops_move_as_they_are_called(name):
    top, closed = TOPS[name], TOPS[name].closed_form
    lowest, highest, _ = map(float, closed.roots)
    kind = name.split(", ")[1]
    if kind == "without spin":
        assert closed.axial_momentum == 0
        return
    between = top.axial_momentum / (2 * top.transverse * np.cos(top.tilt))  # the two steady precessions
    turns_back = float(closed.vertical_momentum / closed.axial_momentum)  # u where phi' = 0
    assert {
        "cusps": abs(turns_back - highest) < 1e-15,
        "loops": lowest + 0.02 < turns_back < highest - 0.02,
        "backward loops": lowest + 0.02 < turns_back < highest - 0.02,
        "monotone": lowest < highest < turns_back - 0.02,
        "slow steady": highest - lowest < 1e-14 and top.precession < between,
        "fast steady": highest - lowest < 1e-14 and top.precession > between,
        "through the upright": abs(highest - 1) < 1e-14 and abs(turns_back - 1) < 1e-14,
    }[kind]


@NAMES
def test_closed_form_is_the_motion_of_euler_and_newton(name):
    top, times = TOPS[name], np.array([-3.0, -1.0, 0.5, 2.0, 5.0])
    q, g = top.closed_form.states(times)
    start = Rotation.from_quat(top.quaternion, scalar_first=True).as_matrix()
    gravity = euler_newton.uniform_gravity(top.gravity / LEVER, (0, 0, LEVER))
    matrices, rates = euler_newton.integrate(
        np.diag(top.moments), start, top.momentum / top.moments, 0.0, times, [gravity]
    )
    assert largest(Rotation.from_quat(q, scalar_first=True).as_matrix() - matrices) < 3e-12
    assert largest(g / top.moments - rates) < 3e-12


@FORMULATIONS
@pytest.mark.parametrize("turn", TURNS.values(), ids=TURNS)
@NAMES
def test_symmetric_top(name, turn, formulation):
    times, closed = judged(name)
    motion = TOPS[name].propagate(times, turn, formulation=formulation)
    assert difference(motion, closed, turn) < allowed(name, formulation)


@pytest.mark.parametrize("constant", ["transverse", "axial", "gravity"])
@pytest.mark.parametrize("name", [name for name in TOPS if "without" not in name])
def test_a_change_of_a_constant_in_the_eleventh_digit_would_be_noticed(name, constant):
    top, (times, closed) = TOPS[name], judged(name)
    changed = replace(top, **{constant: getattr(top, constant) * (1 + 1e-11)})
    assert difference(changed.propagate(times, start=top), closed) > 5 * allowed(name)


@NAMES
def test_gravity_of_the_wrong_sign_would_be_noticed(name):
    times, closed = judged(name)
    assert difference(TOPS[name].propagate(times, lever=-LEVER), closed) > 0.1


@FORMULATIONS
@pytest.mark.parametrize("name", [name for name in TOPS if "steady" in name])
def test_steady_precession_is_uniform(name, formulation):
    top, (times, _) = TOPS[name], judged(name)
    spin = top.axial_momentum / top.axial - top.precession * np.cos(top.tilt)
    phi, psi = top.angles[0] + top.precession * times, top.angles[1] + spin * times
    plus, minus = np.exp(0.5j * (phi + psi)), np.exp(0.5j * (phi - psi))
    up, down = np.cos(top.tilt / 2) * plus, np.sin(top.tilt / 2) * minus
    q = np.stack([up.real, down.real, down.imag, up.imag], axis=-1)
    assert largest(top.propagate(times, formulation=formulation).quaternion - q) < allowed(name, formulation)


# ---------------------------------------------------------------------- the sleeping top


TILT = 1e-6


def sleeper(excess, tilt=TILT):
    """A top with p^2 = 4 A M g l (1 + excess), its axis at rest at a small angle from the vertical."""
    return Top(1.0, 0.7, 1.0, tilt, 0.0, 0.0, 2 * np.sqrt(1 + excess), (1.0, 0.4))


def squared_sine_of_largest_half_tilt(excess, tilt):
    """The positive root x of x^2 + excess x = (1 + excess) sin(tilt/2)^2, where f(1 - 2 x) = 0."""
    half, right = -excess / 2, (1 + excess) * np.sin(tilt / 2) ** 2
    far = abs(half) + np.sqrt(half**2 + right)
    return far if half >= 0 else right / far


def squared_sine_of_half_tilt(motion):
    return np.sum(motion.quaternion[:, 1:3] ** 2, axis=-1)


@FORMULATIONS
@pytest.mark.parametrize(
    ("excess", "tilt", "bound"),
    # The energy, rounded, is what tells one tilt from another: where the vertical is unstable, an error grows to
    # EPSILON/tilt^2 in one period, and these bounds are for ten.
    [(0.04, 1e-6, 5e-12), (0.01, 1e-6, 5e-12), (0.0, 1e-4, 3e-10), (-0.01, 1e-2, 5e-11), (-0.04, 1e-2, 5e-11)],
)
def test_nearly_upright_top(excess, tilt, bound, formulation):
    top = sleeper(excess, tilt)
    closed = top.closed_form
    times = np.linspace(0, 10, 41) * float(closed.period)
    assert difference(top.propagate(times, formulation=formulation), closed.states(times)) < bound


@FORMULATIONS
@pytest.mark.parametrize("excess", [-0.04, -0.01, 0.0, 0.01, 0.04])
def test_linear_theory_of_the_sleeping_top(excess, formulation):
    # A zeta'' - i p zeta' - M g l zeta = 0 for zeta = x + i y of the axis, so zeta exp(-i p t/(2 A)) is any
    # combination of exp(r t) and exp(-r t), r^2 = (4 A M g l - p^2)/(2 A)^2, and its second differences show r^2:
    # a frequency above the limit, a rate of growth below. What is nonlinear is of the order of TILT^2.
    top, step = sleeper(excess), 2.0
    times = step * np.arange(-2, 3)
    motion = top.propagate(times, formulation=formulation)
    x, y, _ = motion.attitude.as_matrix()[:, :, 2].T
    slow = (x + 1j * y) * np.exp(-0.5j * top.axial_momentum / top.transverse * times)
    squared_rate = (4 * top.transverse * top.gravity - top.axial_momentum**2) / (2 * top.transverse) ** 2
    cosine = np.cosh(step * np.sqrt(complex(squared_rate)))
    assert largest((slow[2:] + slow[:-2]) / (2 * slow[1:-1]) - cosine) < 1e-10
    measured = np.arccosh((slow[3] + slow[1]) / (2 * slow[2])) ** 2 / step**2
    assert abs(measured - squared_rate) < 2e-12


@pytest.mark.parametrize("excess", [-0.04, -0.01, -1e-4, 0.0, 1e-4, 0.01, 0.04])
def test_sleeping_top_wakes_below_the_limit_only(excess):
    top = sleeper(excess)
    times = np.linspace(0, float(top.closed_form.period), 201)
    tilts = squared_sine_of_half_tilt(top.propagate(times))
    expected = squared_sine_of_largest_half_tilt(excess, TILT)
    # At the limit one unit of rounding in p^2 is 2e-10 in x.
    assert abs(tilts[100] / expected - 1) < (1e-9 if excess else 1e-7)
    assert np.max(tilts) == tilts[100]
    assert (tilts[100] > 1e-5) == (excess < 0)


def test_stability_limit_to_the_thirteenth_digit():
    # The largest tilt is a multiple of the first one above the limit, does not depend on it below, and is the root
    # of twice the first one at the limit, from which 1e-13 in p^2 moves it by five times the error allowed here.
    tilt = 1e-4
    top = sleeper(0.0, tilt)
    half_period = float(top.closed_form.period) / 2
    measured = squared_sine_of_half_tilt(top.propagate([half_period]))[0]
    assert abs(measured / np.sin(tilt / 2) - 1) < 2e-10
    for excess in (-1e-13, 1e-13):
        assert abs(measured / squared_sine_of_largest_half_tilt(excess, tilt) - 1) > 5e-10


@FORMULATIONS
def test_upright_top_stays_upright_and_keeps_its_sign(formulation):
    # Also far below the limit: nothing pushes it over.
    top = replace(sleeper(-0.99), tilt=0.0)
    motion = top.propagate([1000.0], formulation=formulation)
    half = 0.5 * (sum(top.angles) + top.axial_momentum / top.axial * 1000)
    assert np.all(motion.quaternion[:, 1:3] == 0)
    assert largest(motion.quaternion[0] - [np.cos(half), 0, 0, np.sin(half)]) < 2e-12


# ---------------------------------------------------------------------- Kovalevskaya's top


WEIGHT, CENTER = 1.3, np.array([0.6, -0.5, 0.0])


def kovalevskaya_terms(motion):
    """(omega1 + i omega2)^2 and (M g/C)(c1 + i c2)(gamma1 + i gamma2), gamma = s3 along the body axes, C = 1.

    For gravity along -s3 and the centre of mass at c, the modulus of their difference is constant if A = B = 2 C.
    """
    omega, up = motion.omega_body, motion.attitude.as_matrix()[:, 2]
    return (omega[:, 0] + 1j * omega[:, 1]) ** 2, WEIGHT * complex(*CENTER[:2]) * (up[:, 0] + 1j * up[:, 1])


def kovalevskaya_motion(seed, transverse=2.0, **options):
    random = np.random.default_rng(seed)
    body = pt.Body((transverse, transverse, 1.0))
    start = body.state(Rotation.random(None, random), omega_body=random.normal(size=3))
    return pt.propagate(
        pt.System(body, pt.UniformGravity(WEIGHT, CENTER)), start, np.linspace(0, 1000, 2001), **options
    )


def change_of_the_integral(motion, sign=-1):
    squared, lever = kovalevskaya_terms(motion)
    return np.ptp(np.abs(squared + sign * lever)) / np.max(np.abs(squared) + np.abs(lever))


@FORMULATIONS
@pytest.mark.parametrize("seed", range(4))
def test_integral_of_kovalevskaya(seed, formulation):
    assert change_of_the_integral(kovalevskaya_motion(seed, formulation=formulation)) < 2e-13


@pytest.mark.parametrize("seed", range(4))
def test_integral_of_kovalevskaya_is_one_for_her_moments_and_her_sign_only(seed):
    assert change_of_the_integral(kovalevskaya_motion(seed, 1.9)) > 0.01
    assert change_of_the_integral(kovalevskaya_motion(seed), sign=1) > 0.1


def test_motion_of_delone():
    # Where the integral is zero at the start, omega1 + i omega2 is a root of its second term for ever.
    body, attitude = pt.Body((2.0, 2.0, 1.0)), Rotation.from_rotvec([0.3, 0.9, -0.4])
    up = attitude.as_matrix()[2]
    rate = np.sqrt(WEIGHT * complex(*CENTER[:2]) * complex(*up[:2]))
    start = body.state(attitude, omega_body=(rate.real, rate.imag, 0.8))
    system = pt.System(body, pt.UniformGravity(WEIGHT, CENTER))
    squared, lever = kovalevskaya_terms(pt.propagate(system, start, np.linspace(0, 100, 201)))
    assert largest(squared - lever) < 1e-13


def test_difference_of_the_terms_turns_at_the_rate_of_the_spin():
    # For all q, g, C, M g and c: its logarithmic derivative is -i omega3, so its modulus is constant.
    q, g, c = sp.symbols("q:4", real=True), sp.symbols("g1:4", real=True), sp.symbols("c1:3", real=True)
    C, weight = sp.symbols("C weight", positive=True)

    def rest(transverse):
        numbers = (transverse, transverse, C, weight, *c, 0)
        top = formulas.copied(pt.System(pt.Body((1, 1, 1)), pt.UniformGravity(1, (1, 0, 0))), numbers)
        up = 2 * sp.I * (q[0] - sp.I * q[3]) * (q[1] + sp.I * q[2])
        number = ((g[0] + sp.I * g[1]) / transverse) ** 2 - weight / C * (c[0] + sp.I * c[1]) * up
        rates = formulas.rates(top, "lie_poisson", [*q, *g], 0)
        change = sum(sp.diff(number, x) * rate for x, rate in zip((*q, *g), rates, strict=True))
        polynomial = sp.expand(sp.nsimplify(change + sp.I * g[2] / C * number, rational=True))
        return sp.expand(sp.rem(polynomial, sum(x * x for x in q) - 1, q[0]))

    assert rest(2 * C) == 0
    assert rest(sp.Rational(19, 10) * C) != 0
