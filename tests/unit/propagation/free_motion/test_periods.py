"""States with given periods, against closed forms with 40 digits, propagations, and published rotations."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

import poinsot as pt

EPS = np.finfo(float).eps
from_periods = pt.analysis.FreeRotation.from_periods

APOPHIS = pt.Body((0.61, 0.965, 1.0))  # Pravec et al. 2014, Icarus 233, 48: hours
TOUTATIS = pt.Body((3.0836, 3.235, 1.0))  # Hudson and Ostro 1995, Science 270, 84: days, long axis third
PUBLISHED = {
    "Apophis": (APOPHIS, "short-axis", {"rotation_period": 263.0, "precession_period": 27.38}),
    "Toutatis": (TOUTATIS, "long-axis", {"rotation_period": 5.41, "precession_period": 7.35}),
}
CASES = {
    **PUBLISHED,
    "nearly steady": (APOPHIS, "short-axis", {"rotation_period": 7.5670, "precession_period": 1.0}),
    "near the separatrix": (APOPHIS, "short-axis", {"rotation_period": 50.0, "precession_period": 1.0}),
    "needle": (pt.Body((1.0, 1e-3, 1.0002)), "long-axis", {"rotation_period": 0.01, "precession_period": 1.0}),
    "disc": (pt.Body((1.9, 1.0, 1.1)), "short-axis", {"rotation_period": 3.0, "precession_period": 1.0}),
}


def periods_of(moments, is_long, tangent):
    """P_psi and P_phi at unit angular momentum, by complete elliptic integrals.

    The momentum is at an angle from the axis 3 towards the intermediate axis 2 whose tangent is given. The mean of the
    precession G (2 T - g3^2/I3)/(G^2 - g3^2) with g3^2 = g3(0)^2 + ... is a complete integral of the third kind.
    """
    I1, I2, I3 = sorted(map(mpf, moments), reverse=is_long)
    sine2 = tangent**2 / (1 + tangent**2)
    T2 = sine2 / I2 + (1 - sine2) / I3
    largest = (T2 - 1 / I1) / (1 / I3 - 1 / I1)  # g3^2 where g2 = 0
    rate = mp.sqrt((I3 - I2) * (1 - T2 * I1) / (I1 * I2 * I3))
    m = (I2 - I1) * (T2 * I3 - 1) / ((I3 - I2) * (1 - T2 * I1))
    K = mp.ellipk(m)
    third = mp.ellippi(-largest * m / (1 - largest), m) / K
    return 4 * K / rate, 2 * mp.pi / (1 / I3 + (T2 - 1 / I3) / (1 - largest) * third)


@pytest.mark.parametrize("name", CASES)
def test_nutation_and_momentum_have_the_ratio_of_the_periods(name):
    body, mode, periods = CASES[name]
    found = from_periods(body, mode, **periods, rotation_angle=0.3)
    with mp.workdps(40):
        target = mpf(periods["rotation_period"]) / mpf(periods["precession_period"])

        def excess(log_tangent):
            P_psi, P_phi = periods_of(body.moments, mode == "long-axis", mp.exp(log_tangent))
            return P_psi / P_phi / target - 1

        logarithm = mp.findroot(excess, (-15, 12), solver="bisect", tol=1e-22, maxsteps=100, verify=False)
        unit = periods_of(body.moments, mode == "long-axis", mp.exp(logarithm))[1]
        G, widest = unit / periods["precession_period"], mp.atan(mp.exp(logarithm))
        slope = abs(mp.diff(excess, logarithm)) / mp.sin(2 * widest)  # of the logarithm of the ratio by 2 N
        bound = 5 * EPS * float(1 + 1 / slope + mp.exp(2 * logarithm))  # rounding near the separatrix
        assert abs(found.angular_momentum / G - 1) < bound
        assert abs(found.nutation_range[1] - widest) < bound


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 2, 4.0])
def test_state_has_the_periods(name, angle):
    body, mode, periods = CASES[name]
    found = from_periods(body, mode, **periods, rotation_angle=angle)
    assert found.mode == mode
    bound = 5 * EPS * (1 + np.tan(found.nutation_range[1]) ** 2)  # rounding against the distance of the separatrix
    assert abs(found.rotation_period / periods["rotation_period"] - 1) < bound
    assert abs(found.precession_period / periods["precession_period"] - 1) < bound


@pytest.mark.parametrize("axes", ["space", "ecliptic"])
@pytest.mark.parametrize("name", PUBLISHED)
def test_attitude_is_the_product_of_the_stated_rotations(name, axes):
    body, mode, periods = PUBLISHED[name]
    angles = {"longitude": 4.3, "latitude": -1.2, "precession_angle": 2.6, "rotation_angle": 0.25}
    found = from_periods(body, mode, **periods, **angles, axes=axes, time=3.0)
    body_g = found.state.angular_momentum_body / found.angular_momentum
    theta = np.arccos(body_g[2])
    # both bodies have the circled axis third
    turned = Rotation.from_euler("ZYZ", [4.3, np.pi / 2 + 1.2, 2.6]) * Rotation.from_euler("XZ", [theta, 0.25])
    if axes == "ecliptic":
        turned = Rotation.from_euler("X", np.radians(84381.448 / 3600)) * turned
    apart = (turned.inv() * found.state.attitude).magnitude()
    assert apart < (1e-14 if axes == "space" else np.radians(0.1 / 3600))
    expected = turned.apply((np.sin(theta) * np.sin(0.25), np.sin(theta) * np.cos(0.25), np.cos(theta)))
    np.testing.assert_allclose(
        found.state.angular_momentum_space / found.angular_momentum, expected, rtol=0, atol=max(apart, 1e-14)
    )
    assert found.state.time == 3.0


@settings(derandomize=True, max_examples=25, deadline=None, database=None)
@given(
    st.floats(0.05, 1.0),
    st.floats(0.05, 1.0),
    st.floats(0.02, 0.98),
    st.sampled_from(["short-axis", "long-axis"]),
    st.floats(1.001, 3.0),
    st.floats(0.0, 6.2),
)
def test_any_possible_pair_of_periods_returns(first, second, between, mode, excess, angle):
    """Draw triaxial bodies, and ratios of periods between one and three times the ratio of steady rotation."""
    low, middle = sorted((first, second))
    largest = middle + between * low
    if middle - low < 1e-3 or largest - middle < 1e-3:
        return
    body = pt.Body((middle, largest, low))
    third, (a, b) = (largest, (low, middle)) if mode == "short-axis" else (low, (middle, largest))
    ratio = (1 if mode == "short-axis" else -1) + np.sqrt(a * b / ((third - a) * (third - b)))
    found = from_periods(body, mode, rotation_period=excess * ratio * 5.0, precession_period=5.0, rotation_angle=angle)
    bound = 20 * EPS * (1 + np.tan(found.nutation_range[1]) ** 2) * (1 + 1 / ratio)
    assert found.mode == mode
    assert abs(found.rotation_period / (excess * ratio * 5.0) - 1) < bound
    assert abs(found.precession_period / 5.0 - 1) < bound


@pytest.mark.parametrize("name", PUBLISHED)
def test_lines_of_a_propagation_are_the_periods(name):
    body, mode, periods = PUBLISHED[name]
    found = from_periods(body, mode, **periods, rotation_angle=1.0, precession_angle=0.3)
    P_psi, P_phi = periods.values()
    times = np.linspace(0, 40 * P_psi, 8192)
    motion = pt.propagate(pt.System(body), found.state, times)
    g = motion.angular_momentum_body
    winding = pt.analysis.frequencies(g[:, 0] + 1j * g[:, 1], times, 3).frequencies[0]
    sense = 1 if mode == "short-axis" else -1  # of the momentum along the body axes
    assert abs(winding * P_psi / (2 * np.pi) - sense) < 1e-11
    axes = motion.attitude.as_matrix()
    circled = axes[:, 0, 2] + 1j * axes[:, 1, 2]
    assert abs(pt.analysis.frequencies(circled, times, 3).frequencies[0] * P_phi / (2 * np.pi) - 1) < 1e-11
    long_axis = axes[:, :2, int(np.argmin(body.moments))] @ (1, 1j)
    line = pt.analysis.frequencies(long_axis, times, 5).frequencies[0]
    assert abs(line * found.long_axis_precession_period / (2 * np.pi) - 1) < 1e-11


def test_published_rotation_of_apophis():
    found = from_periods(APOPHIS, "short-axis", rotation_period=263.0, precession_period=27.38)
    assert abs(found.long_axis_precession_period - 30.56) < 0.005  # P1 of Pravec et al.
    assert abs(found.energy_ratio - 1.024) < 0.013
    other = from_periods(APOPHIS, "short-axis", rotation_period=263.0, long_axis_precession_period=30.56)
    assert abs(other.precession_period - 1 / (1 / 30.56 + 1 / 263)) < 1e-12


def test_published_rotation_of_toutatis():
    """The long axis is at 50 degrees from the momentum (Hudson and Ostro 1995)."""
    found = from_periods(TOUTATIS, "long-axis", rotation_period=5.41, long_axis_precession_period=7.35)
    assert abs(found.precession_period - 7.35) < 1e-12
    np.testing.assert_allclose(np.degrees(found.nutation_range), 50, rtol=0, atol=2)


@pytest.mark.parametrize("shift", range(3))
@pytest.mark.parametrize("name", PUBLISHED)
def test_names_and_directions_of_the_axes_change_no_motion(name, shift):
    body, mode, periods = PUBLISHED[name]
    angles = {"rotation_angle": 0.4, "longitude": 1.0, "latitude": 0.2}
    reference = from_periods(body, mode, **periods, **angles)
    moments = np.roll(body.moments, shift)
    renamed = from_periods(pt.Body(moments), mode, **periods, **angles)
    turn = Rotation.from_rotvec((0.3, -0.5, 0.8))
    oblique = pt.Body.from_inertia(turn.as_matrix() @ np.diag(moments) @ turn.as_matrix().T)
    found = from_periods(oblique, mode, **periods, **angles)
    for other in (renamed, found):
        assert abs(other.angular_momentum / reference.angular_momentum - 1) < 1e-13
        np.testing.assert_allclose(other.nutation_range, reference.nutation_range, rtol=1e-12, atol=0)
        np.testing.assert_allclose(
            other.state.angular_momentum_space, reference.state.angular_momentum_space, rtol=0, atol=1e-13
        )


@pytest.mark.parametrize(("moments", "mode"), [((1.0, 1.0, 1.7), "short-axis"), ((1.0, 1.0, 0.4), "long-axis")])
def test_symmetric_bodies_have_the_closed_form(moments, mode):
    across, _, along = moments
    for nutation in (0.01, 0.5, 1.4):
        G = 0.8
        P_phi, P_psi = 2 * np.pi * across / G, 2 * np.pi / (G * np.cos(nutation) * abs(1 / across - 1 / along))
        found = from_periods(pt.Body(moments), mode, rotation_period=P_psi, precession_period=P_phi)
        assert abs(found.angular_momentum / G - 1) < 1e-14
        np.testing.assert_allclose(found.nutation_range, nutation, rtol=1e-11, atol=0)


def test_members_have_periods_and_moments_of_their_own():
    moments = np.array([[0.61, 0.965, 1.0], [1.0, 0.5, 0.8]])
    P_psi, P_phi = np.array([263.0, 50.0]), np.array([27.38, 5.0])
    angles = {"rotation_angle": np.array([0.1, 2.0]), "longitude": np.array([0.3, 0.4])}
    both = from_periods(pt.Body(moments), "short-axis", rotation_period=P_psi, precession_period=P_phi, **angles)
    for i in range(2):
        own = {name: values[i] for name, values in angles.items()}
        one = from_periods(
            pt.Body(moments[i]), "short-axis", rotation_period=P_psi[i], precession_period=P_phi[i], **own
        )
        np.testing.assert_allclose(both.state.quaternion[i], one.state.quaternion, rtol=0, atol=1e-14)
        np.testing.assert_allclose(
            both.state.angular_momentum_body[i], one.state.angular_momentum_body, rtol=1e-13, atol=1e-16
        )
    shared = from_periods(APOPHIS, "short-axis", rotation_period=[250.0, 263.0], precession_period=27.38)
    np.testing.assert_allclose(shared.rotation_period, [250.0, 263.0], rtol=1e-12, atol=0)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no such ratio": (
        {"rotation_period": 50.0},
        "rotation_period must be between 7.56693 and 89.07 times the precession_period for moments [0.61, 0.965, 1.0] "
        "in the short-axis mode, got 1.82615 times. Other moments or the other mode have another range.",
    ),
    "no such mode": ({"mode": "long"}, "mode must be one of short-axis, long-axis, got 'long'."),
    "negative": ({"rotation_period": -1.0}, "rotation_period must be positive, got -1.0."),
    "zero": ({"precession_period": 0.0}, "precession_period must be positive, got 0.0."),
    "none": (
        {"precession_period": None},
        "the rotation must have exactly one of precession_period, long_axis_precession_period, got none.",
    ),
    "symmetric": (
        {"body": pt.Body((0.61, 1.0, 1.0))},
        "mode must be possible for the body, got short-axis for moments [0.61, 1.0, 1.0], of which the two largest are "
        "equal. Use mode='long-axis' if the third differs.",
    ),
    "members": (
        {"rotation_period": [263.0, 264.0], "rotation_angle": [0.1, 0.2, 0.3]},
        "rotation_angle must have as many members as rotation_period, got 3 and 2.",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments(name):
    changed, sentence = WRONG[name]
    arguments: dict[str, Any] = {
        "body": APOPHIS,
        "mode": "short-axis",
        "rotation_period": 263.0,
        "precession_period": 27.38,
    }
    with pytest.raises(ValueError, match="^" + re.escape(sentence) + "$"):
        from_periods(**(arguments | changed))
