"""Branches of forced motions: judged by Beletsky's equation, Colombo's top and the regions of Lagrange and of DeBra.

None of the three knows the package: the first is integrated by DOP853, the others are closed forms.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipk

import poinsot as pt

# ---------------------------------------------------------------------- Beletsky's equation


def beletsky(e, K, slope):
    """Angle and rate by the true anomaly after half a turn, from the angle 0 at the periapsis and a rate.

    (1 + e cos f) t'' - 2 e sin f t' + K sin t cos t = 2 e sin f, K = 3 (B - A)/C, t from the radius (Beletsky 1959).
    """

    def rates(f, y):
        return y[1], (2 * e * np.sin(f) * (1 + y[1]) - K * np.sin(y[0]) * np.cos(y[0])) / (1 + e * np.cos(f))

    return solve_ivp(rates, (0, np.pi), (0, slope), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]


def planar_trace(e, K, slope):
    """The trace of the monodromy matrix of the same equation, over a turn."""

    def rates(f, y):
        q = 1 + e * np.cos(f)
        t, dt, *xi = y
        acceleration = (2 * e * np.sin(f) * (1 + dt) - K * np.sin(t) * np.cos(t)) / q
        bent = [(2 * e * np.sin(f) * v - K * np.cos(2 * t) * x) / q for x, v in (xi[:2], xi[2:])]
        return dt, acceleration, xi[1], bent[0], xi[3], bent[1]

    y = solve_ivp(rates, (0, 2 * np.pi), (0, slope, 1, 0, 0, 1), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return y[2] + y[5]


def satellite(e, body):
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=e)
    return pt.System(body, pt.GravityGradient(orbit)), orbit


def on_the_ellipse(body, to):
    """The branch of forced librations, from rest on the circle on."""
    system, orbit = satellite(0.0, body)
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1.0))
    return pt.analysis.continue_motion(pt.analysis.periodic_motion(system, start, orbit.period), "eccentricity", to)


BODIES = {"slow": pt.Body((1.0, 1.3, 1.6)), "fast": pt.Body((0.9, 1.6, 1.65))}


@pytest.fixture(scope="module")
def branches():
    return {name: on_the_ellipse(body, 0.5) for name, body in BODIES.items()}


def slope_of(motion, e):
    """dt/df at the periapsis, where df/dt = (1 + e)^2 (1 - e^2)^(-3/2)."""
    body = motion.system.body
    return motion.state.angular_momentum_body[2] / body.moments[2] / ((1 + e) ** 2 * (1 - e * e) ** -1.5) - 1


def constant(body):
    A, B, C = body.moments
    return 3 * (B - A) / C


@pytest.mark.parametrize("name", BODIES)
def test_librations_are_those_of_beletskys_equation(branches, name):
    branch, K = branches[name], constant(BODIES[name])
    chosen = list(zip(branch.values, branch.motions, strict=True))[::6]
    assert len(chosen) > 3
    for e, motion in chosen:
        own = slope_of(motion, e)
        near = brentq(lambda slope, e=e: beletsky(e, K, slope)[0], own - 1e-3, own + 1e-3, xtol=1e-15)
        assert own == pytest.approx(near, abs=3e-13)
        z = np.ix_([2, 5], [2, 5])
        assert np.trace(motion.matrix[z]) == pytest.approx(planar_trace(e, K, near), abs=2e-11)
        np.testing.assert_allclose(motion.matrix[np.ix_([2, 5], [0, 1, 3, 4])], 0, rtol=0, atol=1e-12)


def test_libration_slower_than_the_orbit_goes_on_to_any_ellipse(branches):
    branch = branches["slow"]
    assert (branch.values[-1], branch.ending) == (0.5, "forces[0].orbit.eccentricity = 0.5")
    assert "fold" not in {each.kind for each in branch.bifurcations}


def test_libration_faster_than_the_orbit_ends_in_a_fold(branches):
    """Back on the circle it is the free libration of the period 4 F(m) / sqrt K = 2 pi, m = t'^2/K + sin^2 t."""
    branch, K = branches["fast"], constant(BODIES["fast"])
    assert branch.ending == "forces[0].orbit.eccentricity = 0, where it began"
    free = branch.motions[-1]
    angle = 2 * np.arctan2(free.state.quaternion[3], free.state.quaternion[0])  # any phase repeats itself
    m = slope_of(free, 0.0) ** 2 / K + np.sin(angle) ** 2
    assert 4 * ellipk(m) / np.sqrt(K) == pytest.approx(2 * np.pi, rel=1e-14, abs=0)
    (fold,) = (each for each in branch.bifurcations if each.kind == "fold")

    def eccentricity(slope):
        return brentq(lambda e: beletsky(e, K, slope)[0], 0.02, 0.06, xtol=1e-15)

    own = slope_of(fold.motion, fold.value)
    at = minimize_scalar(lambda slope: -eccentricity(slope), (own - 0.05, own, own + 0.05), tol=1e-8)
    assert fold.value == pytest.approx(-at.fun, abs=1e-13)
    assert own == pytest.approx(at.x, abs=1e-7)
    assert np.min(np.abs(fold.motion.multipliers - 1)) < 1e-4
    crossing = [each.value for each in branch.bifurcations if each.kind == "branching"]
    assert crossing == pytest.approx([0.0], abs=1e-12)  # on the circle librations of any phase cross
    doubling = next(each for each in branch.bifurcations if each.kind == "doubling")
    assert np.min(np.abs(doubling.motion.multipliers + 1)) < 1e-4


@pytest.mark.parametrize("name", BODIES)
def test_forced_libration_of_small_eccentricity(name):
    """To first order in e: t = 2 e sin f / (K - 1), with the free libration removed."""
    body = BODIES[name]
    K = constant(body)
    near = on_the_ellipse(body, 1e-5)
    motion = near.motions[-1]
    assert slope_of(motion, 1e-5) == pytest.approx(2e-5 / (K - 1), rel=1e-3)
    along = motion.over_period(64).relative_to(satellite(1e-5, body)[1].frame).attitude.as_rotvec()
    f = 2 * np.pi * np.arange(64) / 64  # up to e
    np.testing.assert_allclose(along[:, 2], 2e-5 / (K - 1) * np.sin(f), rtol=0, atol=1e-8)


# ---------------------------------------------------------------------- Colombo's top


def colombo_fold(flattening, i):
    """Where Cassini states 1 and 4 of an axially symmetric body end, as the rate of the node over the precession."""
    C, A = 1.0, 1 - flattening
    orbit = pt.orbits.PrecessingOrbit(
        pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=i), node_rate=-0.7 * flattening
    )
    motion = pt.analysis.cassini_state(pt.Body((A, A, C)), orbit).motion
    time = float(motion.state.time)

    def node(system):
        return pt.RotatingFrame((1, 0, 0, 0), (0, 0, float(system.forces[0].orbit.node_rate)), time)

    branch = pt.analysis.continue_motion(motion, "node_rate", -2 * flattening, frame=node)
    (fold,) = (each for each in branch.bifurcations if each.kind == "fold")
    assert branch.values[-1] == branch.values[0]
    axis = np.mean(fold.motion.over_period().relative_to(fold.motion.frame).attitude.apply((0, 0, 1)), axis=0)
    tilt = np.arctan2(np.hypot(*axis[:2]), axis[2]) - i
    first, after = branch.stable[: fold.after], branch.stable[fold.after + 2 :]
    assert np.all(first)
    assert not np.any(after)
    return -fold.value / (1.5 * flattening / C), tilt


@pytest.mark.parametrize("i", [pytest.param(0.1, marks=pytest.mark.slow), 0.4])
def test_cassini_states_1_and_4_meet_where_colombos_top_says(i):
    """|node rate| / precession = (sin^(2/3) i + cos^(2/3) i)^(-3/2), at the tilt atan (tan i)^(1/3).

    Henrard and Murigande (1987, Celest. Mech. 40, 345); Ward and Hamilton (2004, AJ 128, 2501). The balance is
    node rate sin(i + x) + precession sin x cos x = 0 with its derivative. The theory leaves out the order of the
    flattening: two extrapolations to none remove its first two powers.
    """
    by_flattening = np.array([colombo_fold(f, i) for f in (2e-2, 1e-2, 5e-3)])
    once = 2 * by_flattening[1:] - by_flattening[:-1]
    rate, tilt = (4 * once[1] - once[0]) / 3
    assert rate == pytest.approx((np.sin(i) ** (2 / 3) + np.cos(i) ** (2 / 3)) ** -1.5, rel=1.5e-5)
    assert tilt == pytest.approx(np.arctan(np.tan(i) ** (1 / 3)), rel=1e-4)


# ---------------------------------------------------------------------- regions of stability on a circle


def grows(A, B, C):
    """Whether a body at rest in the axes radial A, transverse B, normal C of a circular orbit is unstable.

    Pitch: B > A. Roll and yaw, a = (C - B)/A, b = (C - A)/B: s^4 + (1 + 3 b + a b) s^2 + 4 a b = 0 in units of the
    mean motion (DeBra and Delp 1961).
    """
    a, b = (C - B) / A, (C - A) / B
    middle = 1 + 3 * b + a * b
    return A > B or a * b < 0 or middle < 0 or middle**2 < 16 * a * b


def boundary(moments, k, low, high):
    """The value of the k-th moment at which the closed form changes."""

    def unstable(value):
        return grows(*(value if j == k else moment for j, moment in enumerate(moments)))

    assert unstable(low) != unstable(high)
    below = unstable(low)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if unstable(middle) == below else (low, middle)
    return low


CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.3, node=0.2, argument_of_periapsis=0.1)
REGIONS = {
    "Lagrange, pitch": ((1.0, 1.3, 1.6), 0, 1.5, "branching", 1.2, 1.4),
    "Lagrange, roll and yaw": ((1.0, 1.3, 1.6), 2, 1.1, "branching", 1.2, 1.4),
    "DeBra and Delp": ((1.0, 1.2, 0.5), 2, 0.98, "collision", 0.6, 0.95),
}


@pytest.mark.parametrize("name", [*[*REGIONS][:2], pytest.param([*REGIONS][2], marks=pytest.mark.slow)])
def test_boundaries_of_stability(name):
    moments, k, to, kind, low, high = REGIONS[name]
    body = pt.Body(moments)
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=CIRCLE.frame)
    period = 0.2 * CIRCLE.period  # an equilibrium repeats itself after any
    motion = pt.analysis.periodic_motion(pt.System(body, pt.GravityGradient(CIRCLE)), start, period, CIRCLE.frame)
    branch = pt.analysis.continue_motion(motion, f"moments[{k}]", to)
    (found,) = branch.bifurcations
    assert found.kind == kind
    assert found.value == pytest.approx(boundary(moments, k, low, high), rel=4e-15, abs=0)
    for value, stable in zip(branch.values, branch.stable, strict=True):
        assert stable != grows(*(value if j == k else moment for j, moment in enumerate(moments)))
