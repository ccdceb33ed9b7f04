"""Friction in two bodies, against the secular rates of Hut 1981 and closed forms."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt

PAIR = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5), G=1.0)
TURNS = [np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]
RATES = [np.array([0.1, 0.2, 1.0]), np.array([0.0, 0.1, 0.4])]
START = PAIR.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=RATES)


@pytest.mark.parametrize("body", ["primary", "secondary"])
@pytest.mark.parametrize("kind", ["tide", "damping"])
def test_energy_goes_at_the_rate_of_the_formula_and_no_angular_momentum(kind, body):
    tide = pt.forces.TidalFriction(body, love_number=0.3, radius=1.4, time_lag=0.2)
    force = tide if kind == "tide" else pt.forces.LibrationDamping(body, 0.02)
    system: Any = pt.System(PAIR, force)
    assert [integral.symbol for integral in system.integrals] == ["G1", "G2", "G3"]
    load = system.dynamics.load_at(system.at(START))
    number = ["primary", "secondary"].index(body)
    r, v = START.position, START.momentum * 3.5 / 1.5
    turn = (START.primary, START.secondary)[number].attitude
    slip = v - np.cross(turn.apply(RATES[number]), r)
    distance = np.linalg.norm(r)
    if kind == "tide":
        other = (0.5, 3.0)[number]
        bulge = 0.3 * other**2 * 1.4**5 * 0.2
        expected = -3 * bulge / distance**10 * (2 * (r @ v) ** 2 + distance**2 * (slip @ slip))
    else:
        across = slip - r * (r @ slip) / distance**2
        expected = -0.02 * (across @ across) / distance**2
    power = np.dot(list(load.force), v) + sum(
        np.dot(list(torque), rate) for torque, rate in zip(load.torques, RATES, strict=True)
    )
    assert abs(power / expected - 1) < 1e-14
    moment = np.cross(r, list(load.force)) + turn.apply(list(load.torques[number]))
    assert np.linalg.norm(moment) < 1e-15 * distance * np.linalg.norm(list(load.force))
    assert not np.any(list(load.torques[1 - number]))


@pytest.mark.parametrize("body", ["primary", "secondary"])
def test_orbit_and_spin_change_at_the_rates_of_hut(body):
    """Hut 1981, Astron. Astrophys. 99, 126, eqs. (9) to (11), over one revolution with a weak tide."""
    masses, a, e, spin, moment = np.array([3.0, 0.5]), 5.0, 0.3, 0.4, 0.8
    balls = [pt.Body((moment,) * 3, mass=m) for m in masses]
    pair = pt.TwoBodies(*balls, G=1.0)
    number = ["primary", "secondary"].index(body)
    love, radius, lag = 0.3, 1.1, 1e-5
    n = np.sqrt(masses.sum() / a**3)
    fast = n * a * np.sqrt((1 + e) / (1 - e))
    upright = [(1, 0, 0, 0)] * 2
    start = pair.state((a * (1 - e), 0, 0), (0, fast, 0), upright, omega_body=[(0, 0, spin)] * 2)
    force = pt.forces.TidalFriction(body, love_number=love, radius=radius, time_lag=lag)
    period = 2 * np.pi / n
    motion: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity(), force), start, [period])
    r, v = motion.position[0], motion.velocity[0]
    own = 1 / (2 / np.linalg.norm(r) - v @ v / masses.sum())
    eccentricity = np.sqrt(1 - np.linalg.norm(np.cross(r, v)) ** 2 / (masses.sum() * own))
    view = (motion.primary, motion.secondary)[number]

    M, m = masses[number], masses[1 - number]
    f1 = 1 + 31 / 2 * e**2 + 255 / 8 * e**4 + 185 / 16 * e**6 + 25 / 64 * e**8
    f2 = 1 + 15 / 2 * e**2 + 45 / 8 * e**4 + 5 / 16 * e**6
    f3 = 1 + 15 / 4 * e**2 + 15 / 8 * e**4 + 5 / 64 * e**6
    f4, f5, b = 1 + 3 / 2 * e**2 + e**4 / 8, 1 + 3 * e**2 + 3 / 8 * e**4, 1 - e**2
    q, ratio, over = m / M, radius / a, love * lag * M / radius**3
    da = -6 * over * q * (1 + q) * ratio**8 * a / b**7.5 * (f1 - b**1.5 * f2 * spin / n)
    de = -27 * over * q * (1 + q) * ratio**8 * e / b**6.5 * (f3 - 11 / 18 * b**1.5 * f4 * spin / n)
    gyration = moment / (M * radius**2)
    dw = 3 * over / gyration * q**2 * ratio**6 * n / b**6 * (f2 - b**1.5 * f5 * spin / n)
    # the rates are those of first order: the next one is below 1e-5 of them, rounding below 1e-5
    assert abs((own - a) / (da * period) - 1) < 3e-5
    assert abs((eccentricity - e) / (de * period) - 1) < 3e-5
    assert abs((view.omega_body[0, 2] - spin) / (dw * period) - 1) < 3e-5


def test_a_small_libration_decays():
    """Of a small secondary: C phi'' + c phi' + 3 n^2 (B - A) phi = 0."""
    moments, c = 1e-12 * np.array([1.0, 1.2, 1.5]), 2e-14
    pair = pt.TwoBodies(pt.Body((0.4,) * 3, mass=1.0), pt.Body(moments, mass=1e-6), G=1.0)
    n = 0.02
    distance = ((1 + 1e-6) / n**2) ** (1 / 3)
    angle = 1e-3
    turned = (np.cos(angle / 2), 0, 0, np.sin(angle / 2))
    speed = n * distance
    damping = pt.forces.LibrationDamping("secondary", c)
    system = pt.System(pair, pt.forces.MutualGravity(), damping)
    start = pair.state((distance, 0, 0), (0, speed, 0), [(1, 0, 0, 0), turned], omega_body=[(0, 0, n)] * 2)
    times = np.linspace(0, 150, 7)
    motion: Any = pt.propagate(system, start, times)
    q = motion.secondary.quaternion
    place = np.arctan2(motion.position[:, 1], motion.position[:, 0])
    phi = np.unwrap(2 * np.arctan2(q[:, 3], q[:, 0]) - place, period=np.pi)
    half = c / (2 * moments[2])
    w = np.sqrt(3 * n**2 * (moments[1] - moments[0]) / moments[2] - half**2)
    expected = angle * np.exp(-half * times) * (np.cos(w * times) + half / w * np.sin(w * times))
    assert np.max(np.abs(phi - expected)) < 1e-4 * angle  # the moments move the orbit by 1e-8 of a radian each radian


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: pt.forces.LibrationDamping("moon", 0.1), "body must be 'primary' or 'secondary', got 'moon'"),
        (
            lambda: pt.System(pt.Body((1, 1, 1)), pt.forces.LibrationDamping("primary", 0.1)),
            "must be a Potential, a Torque or",
        ),
        (lambda: pt.forces.TidalFriction("primary", 0.1, radius=-1.0, time_lag=0.1), "radius must be positive"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()
