"""Tests of gyros and magnetometers: closed forms, digits, ensembles, wheels, noise, and wrong arguments."""

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment
from poinsot.observables import Gyro, Magnetometer, Readings
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
FIT = json.loads((Path(__file__).parents[2] / "oracles" / "gyro_cases.json").read_text())
BODY = pt.Body((1.25, 1.0, 0.75))
TIMES = np.linspace(0.0, 3.0, 7)
ERRORS = {"bias": (0.01, -0.02, 0.03), "scale": (1e-2, -2e-2, 5e-3), "alignment": (0.3, -0.2, 0.1)}
ORBIT = pt.KeplerOrbit(398600.4418, semimajor_axis=6871.2, eccentricity=0.01, inclination=1.2)
FIELD = pt.forces.TiltedDipole(
    ORBIT, pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.3e-5), -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2
)


def tumbling(system=None, **state):
    system = pt.System(BODY) if system is None else system
    return pt.propagate(system, system.state((0.5, -0.5, 0.5, 0.5), **{"omega_body": (0.1, 0.3, 2)} | state), TIMES)


def of_sensor(vectors, bias, scale, alignment):
    return Rotation.from_rotvec(alignment).apply(vectors * (1 + np.asarray(scale))) + np.asarray(bias)


@pytest.fixture(scope="module")
def motion():
    return tumbling()


def test_a_gyro_without_errors_reads_the_angular_velocity(motion):
    assert np.array_equal(pt.observe(motion, Gyro()).values, motion.omega_body)


def test_a_gyro_scales_turns_and_adds_its_bias(motion):
    found = pt.observe(motion, Gyro(**ERRORS))
    assert np.allclose(found.values, of_sensor(motion.omega_body, **ERRORS), rtol=0, atol=16 * EPS)
    assert found.attributes["frame"] == "body"


def test_a_magnetometer_reads_the_field_along_the_body_axes(motion):
    errors = ERRORS | {"bias": (1e-6, -2e-6, 3e-6)}
    found = pt.observe(motion, Magnetometer(FIELD, **errors))
    place = np.stack(ORBIT.position_at(TIMES), axis=-1)
    field = np.stack([np.stack(FIELD.in_space(r, t)) for r, t in zip(place, TIMES, strict=True)]).astype(float)
    expected = of_sensor(motion.attitude.inv().apply(field), **errors)
    assert np.allclose(found.values, expected, rtol=0, atol=32 * EPS * np.max(np.abs(expected)))
    assert found.attributes["units"] == "T"


def test_units_of_a_gyro_are_those_of_the_system():
    motion = tumbling(pt.System(BODY, units={"time": "s", "inertia": "kg m2"}))
    assert pt.observe(motion, Gyro()).attributes["units"] == "rad s-1"


def test_a_gyro_reads_the_body_and_not_its_rotors():
    """The momentum h of a rotor is no part of omega = I^-1 (g - h)."""
    rotor = (0.0, 0.3, 0.5)
    motion = tumbling(pt.System(BODY, pt.parts.Gyrostat(rotor)))
    found = pt.observe(motion, Gyro()).values * (1.25, 1.0, 0.75) + rotor
    assert np.allclose(found, motion.angular_momentum_body, rtol=0, atol=8 * EPS)


def test_a_sampled_controller_changes_the_motion_and_not_the_gyro():
    law = pt.control.Sampled(
        pt.control.RateDamping(2.0, limit=1.0), 0.3, sensors=pt.control.NoisySensors(rate_noise=1e-3)
    )
    motion = tumbling(pt.System(BODY, law))
    assert np.array_equal(pt.observe(motion, Gyro()).values, motion.omega_body)


def test_members_have_sensors_of_their_own():
    biases, alignments = [(0.1, 0, 0), (0, 0.2, 0)], [(0.1, 0, 0), (0.0, 0.0, 0.0)]
    motion = tumbling(omega_body=[(0.1, 0.3, 2), (1.0, 0.2, 0.3)])
    both = pt.observe(motion, Gyro(bias=biases, alignment=alignments)).values
    assert both.shape == (2, TIMES.size, 3)
    for i in range(2):
        alone = pt.observe(motion.isel(member=i), Gyro(bias=biases[i], alignment=alignments[i])).values
        assert np.allclose(both[i], alone, rtol=0, atol=8 * EPS)


def test_derivatives_agree_with_digits():
    """All partial derivatives of a reading, by a formula in mpmath that shares no code with the package."""
    numbers = [*ERRORS["bias"], *ERRORS["scale"], *ERRORS["alignment"], 0.4, -1.1, 2.0]
    graph = Graph()
    nodes = [graph.variable(x) for x in numbers]
    gyro = Gyro.unchecked(bias=Vector(nodes[:3]), scale=Vector(nodes[3:6]), alignment=Vector(nodes[6:9]), noise=0.0)
    instant = pt.Instant(BODY, pt.Attitude.from_quaternion((1, 0, 0, 0)), Environment(0.0), Vector(nodes[9:]))
    reading = gyro.reading(instant)

    def exact(x):
        bias, scale, alignment, omega = (x[i : i + 3] for i in (0, 3, 6, 9))
        a, b, c = alignment
        turn = mpmath.expm(mpmath.matrix([[0, -c, b], [c, 0, -a], [-b, a, 0]]))
        turned = turn * mpmath.matrix([(1 + s) * w for s, w in zip(scale, omega, strict=True)])
        return [turned[i] + bias[i] for i in range(3)]

    with mpmath.workdps(40):
        x, h = [mpmath.mpf(number) for number in numbers], mpmath.mpf(10) ** -15
        for i, node in enumerate(nodes):
            found = graph.evaluated(tangents(list(reading), {node: 1.0}))
            low, high = (exact([*x[:i], x[i] + step, *x[i + 1 :]]) for step in (-h, h))
            expected = [float((b - a) / (2 * h)) for a, b in zip(low, high, strict=True)]
            assert np.allclose(found, expected, rtol=0, atol=16 * EPS)


def test_readings_and_partials_at_a_fit_with_many_digits():
    """Residuals, gradient and covariance at the estimate of an independent fit of momentum, moments and bias."""
    estimate, sigma = np.array(FIT["estimate"]), FIT["sigma"]
    body = pt.Body((estimate[3], estimate[4], FIT["moments_2"]))
    start = body.state((1, 0, 0, 0), angular_momentum_body=estimate[:3])
    gyro = Readings(Gyro(bias=estimate[5:]), FIT["times"], sigma=sigma)
    found = pt.analysis.observed_partials(pt.System(body), start, gyro, parameters=["moments[0]", "moments[1]", "bias"])
    residuals = (np.array(FIT["omega"]) - found.values).ravel() / sigma
    matrix = np.concatenate([found.by_start[..., 3:], found.by_parameters], axis=-1).reshape(-1, 8) / sigma
    deviations = np.sqrt(np.diag(FIT["covariance"]))
    assert np.sum(residuals**2) == pytest.approx(FIT["chi2"], rel=1e-13, abs=0)
    # The step of Gauss and Newton from the estimate, in standard deviations, and the covariance. The condition of the
    # scaled matrix is 350; the covariance has roundings times its square.
    step = np.linalg.lstsq(matrix, residuals, rcond=None)[0]
    assert np.max(np.abs(step / deviations)) < 1e-12
    covariance = np.linalg.inv(matrix.T @ matrix)
    scaled = np.abs(covariance - FIT["covariance"]) / np.outer(deviations, deviations)
    assert np.max(scaled) < 2 * 350**2 * EPS


def test_noise_has_its_standard_deviation():
    motion = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), np.linspace(0, 1, 4000))
    readings = pt.observe(motion, Gyro(noise=0.05))
    errors = readings.simulated(seed=3).values - readings.values
    # The standard deviation of n numbers has the relative error 1 / sqrt(2 n); bounds of four deviations.
    assert np.allclose(errors.std(axis=0), 0.05, rtol=4 / np.sqrt(8000), atol=0)
    assert np.all(np.abs(errors.mean(axis=0)) < 4 * 0.05 / np.sqrt(4000))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Gyro(noise=-1.0), r"noise must not be negative, got -1\.0\."),
        (
            lambda: Gyro(bias=(1.0, 2.0)),
            r"bias must have shape \(3,\) or .* along the sensor axes, got shape \(2,\)\.",
        ),
        (lambda: Magnetometer(ORBIT), r"field must be a MagneticField, got KeplerOrbit\."),
    ],
)
def test_wrong_arguments_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}$"):
        make()
