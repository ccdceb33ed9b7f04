"""Magnetic fields and their torques: motions and fields of other programs, and closed forms."""

import datetime as dt
import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import lpmv

import poinsot as pt
from poinsot.forces import IGRF, BDot, EddyCurrents, MagneticHarmonics, MagneticMoment, SecularHarmonics, TiltedDipole
from poinsot.functions import Vector
from poinsot.orbits import FixedPosition, NutatingRotation, RotationModel

CASES = json.loads((Path(__file__).parent / "spacecraft_magnetism.json").read_text())["cases"]
UPRIGHT = RotationModel(-np.pi / 2, np.pi / 2, 0.0, rate=0.0)
"""Axes of the planet along those of space."""


def largest(difference):
    return np.max(np.abs(difference))


# ---------------------------------------------------------------------- other programs


def dipole_of(case, kind):
    """The field of the case, by the formula of a dipole or by harmonics of degree 1."""
    shape = {"semimajor_axis": case["semimajor_axis"], "eccentricity": 0.0, "inclination": case["inclination"]}
    latitude = case["argument_of_latitude0"]
    orbit = pt.KeplerOrbit(case["mu"], **shape, node=case["node"], true_anomaly=latitude)
    planet = RotationModel(-np.pi / 2, np.pi / 2, case["planet_angle0"], rate=case["planet_rate"])
    if kind is TiltedDipole:
        return TiltedDipole(orbit, planet, case["g10"], case["g11"], case["h11"], case["reference_radius"])
    g, h = [(0, 0), (case["g10"], case["g11"])], [(0, 0), (0, case["h11"])]
    return MagneticHarmonics(orbit, planet, 1, case["reference_radius"], g, h)


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@pytest.mark.parametrize("kind", [TiltedDipole, MagneticHarmonics])
def test_a_magnet_in_the_field_of_a_dipole_that_turns(kind, formulation):
    case = CASES["magnetic_dipole"]
    system = pt.System(
        pt.Body.from_inertia(case["inertia"]), MagneticMoment(case["moment_body"], dipole_of(case, kind))
    )
    start = system.state(case["quaternion0"], omega_body=case["omega_body0"])
    motion = pt.propagate(system, start, case["times"], formulation=formulation)
    bound = 20 * case["estimated_error_of_reference"]
    assert largest(motion.quaternion - case["quaternion"]) < bound
    assert largest(motion.omega_body - case["omega_body"]) < bound
    assert largest(system.torque_body(start) - case["torque_body0"]) < 1e-20


def along(vector, colatitude, longitude):
    """The components along r, theta (south) and phi (east)."""
    (ct, st), (cp, sp) = ((np.cos(x), np.sin(x)) for x in (colatitude, longitude))
    rows = np.array([(st * cp, st * sp, ct), (ct * cp, ct * sp, -st), (-sp, cp, 0)])
    return rows @ np.asarray(vector, dtype=float), rows[0]


@pytest.fixture(scope="module")
def ppigrf():
    return pytest.importorskip("ppigrf")


def igrf(degree, zero="2025-01-01T00:00:00"):
    orbit = FixedPosition(398600.4, position=(6871.2, 0, 0))
    return IGRF(orbit, RotationModel.iau("earth", calendar=pt.Calendar(zero, "TT")), degree)


@pytest.mark.usefixtures("ppigrf")
@pytest.mark.parametrize("point", CASES["igrf14"]["points"])
def test_igrf_at_points(point):
    field = igrf(point["degree"])
    years = 1900 + 5 * np.arange(field.knots.size)
    time = np.interp(point["year"], years, field.knots)
    colatitude, longitude = np.radians((point["colatitude_deg"], point["longitude_deg"]))
    _, up = along((0, 0, 0), colatitude, longitude)
    found, _ = along(list(field.at(Vector(point["radius_km"] * up), time)), colatitude, longitude)
    # 105 terms, of which the largest is 3e4 nT, to a few roundings each.
    assert largest(1e9 * found - point["B_r_theta_phi_nT"]) < 1e-10


def test_igrf_on_dates_and_everywhere(ppigrf):
    field, random = igrf(13), np.random.default_rng(5)
    for _ in range(30):
        r, colatitude, longitude = random.uniform((6371.2, 0.05, -3), (30000, 3.1, 3))
        date = dt.datetime(1900, 1, 1) + dt.timedelta(days=float(random.integers(0, 47400)))
        _, up = along((0, 0, 0), colatitude, longitude)
        time = field.calendar.time(date.strftime("%Y-%m-%dT%H:%M:%S TT"))
        found, _ = along(list(field.at(Vector(r * up), time)), colatitude, longitude)
        theirs = ppigrf.igrf_gc(r, np.degrees(colatitude), np.degrees(longitude), date)
        assert largest(1e9 * found - [float(np.ravel(x)[0]) for x in theirs]) < 2e-10


@pytest.mark.usefixtures("ppigrf")
def test_a_motion_through_an_epoch_of_the_igrf():
    """Against the formula with coefficients from one side and the other, in two runs."""
    field = igrf(4, "2020-01-01T00:00:00")
    body, start = pt.Body((0.02, 0.025, 0.012)), {"omega_body": (0.002, -0.003, 0.004)}
    before, after = (field.between_knots(t) for t in (-1.0, 1.0))
    assert not np.array_equal(before.g_rate, after.g_rate)
    whole, *halves = (pt.System(body, MagneticMoment((0.02, -0.01, 0.04), each)) for each in (field, before, after))
    begin = whole.state((0.5, -0.5, 0.5, 0.5), **start, time=-500.0)
    first = pt.propagate(halves[0], begin, [0.0])
    second = pt.propagate(halves[1], first.isel(time=-1), [700.0])
    motion = pt.propagate(whole, begin, [0.0, 700.0])
    assert largest(motion.quaternion[-1] - second.quaternion[-1]) < 6e-15


# ---------------------------------------------------------------------- fields


def by_potential(field, position, time):
    """Minus the gradient of the series of Schmidt's functions of SciPy, by differences of the fourth order."""
    since = time - getattr(field, "epoch", 0.0)
    g, h = (getattr(field, name) + getattr(field, f"{name}_rate", 0.0) * since for name in ("g", "h"))

    def potential(x):
        r, longitude = np.linalg.norm(x), np.arctan2(x[1], x[0])
        total = 0.0
        for n in range(1, field.degree + 1):
            for m in range(n + 1):
                norm = np.sqrt((2 - (m == 0)) * np.prod(1.0 / np.arange(n - m + 1, n + m + 1))) * (-1) ** m
                wave = g[n, m] * np.cos(m * longitude) + h[n, m] * np.sin(m * longitude)
                total += (field.radius / r) ** (n + 1) * norm * lpmv(m, n, x[2] / r) * wave
        return field.radius * total

    def slope(k):
        step = 1e-3 * np.eye(3)[k]
        near, far = ((potential(position + i * step) - potential(position - i * step)) / (2e-3 * i) for i in (1, 2))
        return (4 * near - far) / 3

    return [-slope(k) for k in range(3)]


def test_harmonics_are_the_slope_of_their_potential():
    random, orbit = np.random.default_rng(2), FixedPosition(1.0, position=(2, 0, 0))
    tables = random.normal(size=(4, 7, 7))
    plain = MagneticHarmonics(orbit, UPRIGHT, 6, 1.1, *tables[:2])
    secular = SecularHarmonics(orbit, UPRIGHT, 6, 1.1, *tables, epoch=0.3)
    for field in (plain, secular):
        for _ in range(5):
            position = random.normal(size=3)
            position *= random.uniform(1.3, 3) / np.linalg.norm(position)
            expected = by_potential(field, position, 1.7)
            # Truncation step^4 / 30 times the fifth derivative, some 1e5, and rounding over the step.
            assert largest(np.array(list(field.at(Vector(position), 1.7)), dtype=float) - expected) < 1e-9


# ---------------------------------------------------------------------- closed forms


UNIFORM = TiltedDipole(FixedPosition(1.0, position=(2.0, 0, 0)), UPRIGHT, -8.0, 0.0, 0.0, 1.0)
"""B = (0, 0, 1) where the body is, at rest."""


def test_the_energy_of_a_magnet_in_a_field_at_rest_is_conserved():
    system = pt.System(pt.Body((1.0, 1.6, 2.5)), MagneticMoment((0.3, -0.2, 0.5), UNIFORM))
    assert [integral.symbol for integral in system.integrals] == ["H", "G3"]
    start = system.state((0.5, -0.5, 0.5, 0.5), omega_body=(0.4, -0.3, 0.2))
    motion = pt.propagate(system, start, np.linspace(0, 100, 101))
    assert largest(motion.drift["energy"]) < 1e-14
    third = motion.attitude.inv().apply((0, 0, 1))
    assert np.allclose(motion.potential_energy, -third @ (0.3, -0.2, 0.5), rtol=0, atol=1e-15)


def test_eddy_currents_stop_what_turns_across_the_field_and_not_along():
    inertia, k = 1.3, 0.07
    system = pt.System(pt.Body((inertia,) * 3), EddyCurrents(k, UNIFORM))
    start = system.state((0.5, -0.5, 0.5, 0.5), omega_space=(0.4, -0.3, 0.7))
    times = np.linspace(0, 60, 7)
    motion = pt.propagate(system, start, times)
    rate = motion.attitude.apply(motion.omega_body)
    assert np.allclose(rate[:, :2], np.outer(np.exp(-k * times / inertia), (0.4, -0.3)), rtol=0, atol=1e-14)
    assert np.allclose(rate[:, 2], 0.7, rtol=0, atol=1e-14)


def test_eddy_currents_of_a_tensor_take_energy():
    tensor = np.array([(0.2, 0.05, 0.0), (0.05, 0.1, -0.02), (0.0, -0.02, 0.3)])
    system = pt.System(pt.Body((1.0, 1.6, 2.5)), EddyCurrents(tensor, UNIFORM))
    start = system.state((0.5, -0.1, 0.7, 0.5), omega_body=(0.4, -0.3, 0.7))
    field = start.attitude.inv().apply((0, 0, 1))
    across = np.cross((0.4, -0.3, 0.7), field)
    assert largest(system.torque_body(start) - np.cross(tensor @ across, field)) < 1e-16
    motion = pt.propagate(system, start, np.linspace(0, 30, 31))
    assert np.all(np.diff(motion.energy) < 0)


def body_field(case, rate, time):
    """The field of the dipole of the case along the axes of a body that turns about its own axis, in mpmath."""

    def rotated(axis, angle, vector):
        x, y, z = (vector[(axis + i) % 3] for i in range(3))
        c, s = mpmath.cos(angle), mpmath.sin(angle)
        out = [0, 0, 0]
        for i, value in enumerate((x, c * y - s * z, s * y + c * z)):
            out[(axis + i) % 3] = value
        return out

    a = mpmath.mpf(case["semimajor_axis"])
    latitude = case["argument_of_latitude0"] + mpmath.sqrt(case["mu"] / a**3) * time
    up = [mpmath.cos(latitude), mpmath.sin(latitude), mpmath.mpf(0)]
    up = rotated(2, case["node"], rotated(0, case["inclination"], up))
    dipole = [mpmath.mpf(case[name]) for name in ("g11", "h11", "g10")]
    dipole = rotated(2, case["planet_angle0"] + case["planet_rate"] * time, dipole)
    along_up = sum(u * d for u, d in zip(up, dipole, strict=True))
    size = (case["reference_radius"] / a) ** 3
    field = [size * (3 * u * along_up - d) for u, d in zip(up, dipole, strict=True)]
    return rotated(2, -rate * time, field)


def test_the_rate_that_a_magnetometer_sees():
    """On a body that turns about its third axis, which is that of space: q = (cos, 0, 0, sin) of half the angle."""
    case, rate = CASES["magnetic_dipole"], 0.05
    control = BDot(2e4, dipole_of(case, TiltedDipole), 1.0)
    system = pt.System(pt.Body((0.02, 0.02, 0.012)), control)
    for time in (0.0, 77.0, 1500.0):
        half = 0.5 * rate * time
        state = system.state((np.cos(half), 0, 0, np.sin(half)), omega_body=(0, 0, rate), time=time)
        with mpmath.workdps(30):
            slopes = [mpmath.diff(lambda t, i=i: body_field(case, rate, t)[i], time) for i in range(3)]
            field = np.array([float(x) for x in body_field(case, rate, mpmath.mpf(time))])
            expected = np.array([float(x) for x in slopes])
        found = np.array([float(x) for x in control.field.rate_in_body(system.at(state))])
        assert largest(found - expected) < 1e-20
        assert largest(system.torque_body(state) - np.cross(-2e4 * expected, field)) < 1e-20


def test_a_motion_in_the_field_of_a_planet_with_nutation():
    """Against Euler's equations with the axes as a frame, whose matrices have a test of their own."""
    terms = [(0.1, -0.2, 0.15, 0.4, 0.9), (-0.05, 0.1, 0.2, 1.0, -0.4)]
    rates = {"rate": 0.3, "right_ascension_rate": 0.02, "declination_rate": -0.03, "epoch": 0.5}
    planet = NutatingRotation(0.3, 0.8, -0.4, **rates, terms=2, periodic=terms)
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.2, inclination=0.5, node=0.3)
    moment, moments = np.array((0.5, -0.3, 0.7)), np.array((1.3, 1.0, 0.7))
    dipole = np.array((0.8, -1.1, -3.0))  # g11, h11, g10

    def rate(time, y):
        axes, omega = np.reshape(y[:9], (3, 3)), y[9:]  # axes[i]: the space axis i along the body
        place = np.array(list(orbit.position_at(time)))
        r, d = np.linalg.norm(place), planet.attitude(time).apply(dipole)
        field = (3 * place * (place @ d) / r**2 - d) / r**3
        turning = (np.cross(moment, field @ axes) - np.cross(omega, moments * omega)) / moments
        return np.concatenate([np.ravel([np.cross(axis, omega) for axis in axes]), turning])

    field = TiltedDipole(orbit, planet, dipole[2], dipole[0], dipole[1], 1.0)
    system = pt.System(pt.Body(moments), MagneticMoment(moment, field))
    start = system.state((0.5, -0.5, 0.5, 0.5), omega_body=(0.4, -0.3, 0.2))
    motion = pt.propagate(system, start, np.linspace(0, 8, 5))
    first = np.concatenate([np.ravel(start.attitude.as_matrix()), (0.4, -0.3, 0.2)])
    found = solve_ivp(rate, (0, 8), first, "DOP853", t_eval=motion.times, rtol=1e-12, atol=1e-13)
    assert largest(motion.omega_body - found.y[9:].T) < 1e-10
    assert largest(np.reshape(motion.attitude.as_matrix(), (-1, 9)) - found.y[:9].T) < 1e-10


def test_moments_stay_within_the_limit():
    system = pt.System(pt.Body((1.0, 1.6, 2.5)), BDot(5.0, UNIFORM, 0.3))
    for omega in ((0.01, 0.02, -0.03), (0.4, -0.5, 0.2), (4.0, 0.02, 1.0)):
        state = system.state((0.5, -0.5, 0.5, 0.5), omega_body=omega)
        field = state.attitude.inv().apply((0, 0, 1))
        moment = np.clip(5.0 * np.cross(omega, field), -0.3, 0.3)  # dB/dt of a field at rest is -omega x B
        assert largest(system.torque_body(state) - np.cross(moment, field)) < 1e-16


def test_a_motion_with_moments_at_their_limit():
    """Against an integration with a rotation matrix, whose steps do not see the kinks."""
    moments, gain, limit = np.array((1.0, 1.6, 2.5)), 2.0, 0.3

    def rate(_, y):
        axes, omega = np.reshape(y[:9], (3, 3)), y[9:]  # axes[i]: the space axis i along the body
        field = axes[2]
        torque = np.cross(np.clip(gain * np.cross(omega, field), -limit, limit), field)
        turning = (torque - np.cross(omega, moments * omega)) / moments
        return np.concatenate([np.ravel([np.cross(axis, omega) for axis in axes]), turning])

    system = pt.System(pt.Body(moments), BDot(gain, UNIFORM, limit))
    start = system.state((0.5, -0.5, 0.5, 0.5), omega_body=(0.4, -0.3, 0.2))
    motion = pt.propagate(system, start, np.linspace(0, 20, 6))
    first = np.concatenate([np.ravel(start.attitude.as_matrix()), (0.4, -0.3, 0.2)])
    found = solve_ivp(rate, (0, 20), first, "DOP853", t_eval=motion.times, rtol=1e-12, atol=1e-13, max_step=0.04)
    reached = np.abs(gain * np.cross(motion.omega_body, motion.attitude.inv().apply((0, 0, 1)))) > limit
    assert np.any(reached)
    assert not np.all(np.any(reached, axis=-1))
    assert largest(motion.omega_body - found.y[9:].T) < 3e-12
    assert largest(np.reshape(motion.attitude.as_matrix(), (-1, 9)) - found.y[:9].T) < 1.5e-11
    assert np.all(np.diff(motion.energy) < 0)
