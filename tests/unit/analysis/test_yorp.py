"""YORP averaged over rotation and orbit, and the averaged evolution."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from unit.shapes.test_visibility import bumpy, sphere_points

OBLIQUITIES = np.linspace(0, np.pi, 13)


def lopsided(count=120):
    """A body turned so that its third axis is that of the largest moment."""
    mesh = bumpy(count, 0.4).in_principal_axes()
    order = np.argsort(np.diag(mesh.inertia))
    turn = np.eye(3)[order]
    return mesh.moved(attitude=Rotation.from_matrix(turn * np.linalg.det(turn)))


MESH = lopsided()
FIELD = pt.forces.DirectionalTorque.of_emission(MESH, 6)


def test_a_body_with_a_mirror_along_the_axis_has_no_mean_torque():
    points, faces = sphere_points(100)
    points, faces = np.concatenate([points, points * (-1, 1, 1)]), np.concatenate([faces, faces[:, ::-1] + 100])
    mirrored = pt.shapes.Mesh(
        points * (3.0, 2.0, 1.0) + np.repeat([(4.0, 0, 0), (-4.0, 0, 0)], 100, axis=0), faces, mass=1
    )
    for shadows in (False, True):
        found = pt.analysis.yorp_coefficients(mirrored, OBLIQUITIES, shadows=shadows)
        assert np.max(np.abs(found.spin)) < 1e-12
        assert np.max(np.abs(found.tilt)) < 1e-12


def test_the_spin_is_even_and_the_tilt_odd_about_a_right_angle():
    for surface in (MESH, FIELD):
        found = pt.analysis.yorp_coefficients(surface, OBLIQUITIES)
        np.testing.assert_allclose(found.spin, found.spin[::-1], rtol=0, atol=1e-16)
        np.testing.assert_allclose(found.tilt, -found.tilt[::-1], rtol=0, atol=1e-16)
        assert np.ptp(found.spin) > 1e-3
        assert np.ptp(found.tilt) > 1e-3


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (0.3, -2.0, 1.0)])
def test_means_of_a_field_are_means_of_its_torque_along_an_ellipse(axis):
    """By samples in time, where light falls with the square of the distance."""
    obliquity, eccentricity = 0.9, 0.4
    found = pt.analysis.yorp_coefficients(FIELD, [obliquity], axis=axis)
    pole = np.array(axis) / np.linalg.norm(axis)
    first = np.cross(pole, (1, 0, 0)) / np.linalg.norm(np.cross(pole, (1, 0, 0)))
    to_body = np.stack([first, np.cross(pole, first), pole], axis=-1)  # rotation axes -> body
    mean_anomaly = 2 * np.pi * (np.arange(200) + 0.5) / 200
    E = np.array([pt.functions.eccentric_anomaly(eccentricity, m) for m in mean_anomaly])
    true = 2 * np.arctan(np.sqrt((1 + eccentricity) / (1 - eccentricity)) * np.tan(E / 2))
    flux, longitude = 1 / (1 - eccentricity * np.cos(E)) ** 2, true + 0.6
    suns = np.stack(
        [np.cos(longitude), np.sin(longitude) * np.cos(obliquity), np.sin(longitude) * np.sin(obliquity)], axis=-1
    )
    total = np.zeros(3)
    for phase in 2 * np.pi * np.arange(20) / 20:
        turn = Rotation.from_rotvec((0, 0, phase))
        in_body = turn.inv().apply(suns) @ to_body.T
        torque = np.stack(FIELD.torque(in_body.T), axis=-1) @ to_body
        total += np.mean(flux[:, None] * turn.apply(torque), axis=0) / 20
    # 200 samples of an ellipse of 0.4 leave less than rounding; the degree is 6.
    np.testing.assert_allclose(
        total[[2, 1]] * np.sqrt(1 - eccentricity**2), [found.spin[0], found.tilt[0]], rtol=0, atol=1e-14
    )


def full_and_averaged(pressure):
    """Mean changes of rate and obliquity from the first orbit to the eighth, of the full torque and of the averaged."""
    body, radius, orbits, rows = pt.Body.from_shape(MESH), 1000.0, 8, 200
    period, moment, tilted = 2 * np.pi * 117.004, float(pt.Body.from_shape(MESH).moments[2]), 0.8
    sun = pt.KeplerOrbit(radius**3 * (2 * np.pi / period) ** 2, semimajor_axis=radius, eccentricity=0.0)
    start = body.state(Rotation.from_rotvec((tilted, 0, 0)), omega_body=(0, 0, 1))
    times = np.linspace(0, orbits * period, orbits * rows + 1)
    motion = pt.propagate(
        pt.System(body, pt.forces.Yorp(sun, FIELD, pressure=pressure, distance=radius, sun_radius=1.0)), start, times
    )
    momentum = motion.attitude.apply(motion.angular_momentum_body)
    size = np.linalg.norm(momentum, axis=-1)
    full = {"rate": size / moment, "obliquity": np.arccos(momentum[:, 2] / size)}
    drift = pt.analysis.yorp_coefficients(FIELD, np.linspace(0, np.pi, 73)).drift(pressure, moment)
    averaged = pt.analysis.secular_evolution([drift], {"rate": 1.0, "obliquity": tilted}, times).values
    means = [
        [np.mean(x[-rows:]) - np.mean(x[:rows]) for x in (each["rate"], each["obliquity"])] for each in (full, averaged)
    ]
    return np.array(means)


def test_the_averaged_law_is_the_limit_of_the_full_torque():
    off = []
    for pressure in (2e-5, 1e-5):
        full, averaged = full_and_averaged(pressure)
        assert np.all(np.abs(averaged) > 1e-6)
        off.append(full / averaged - 1)
    # What is left is of the second order of the torque: half as much, of half the pressure.
    assert np.max(np.abs(off[1])) < 0.01
    np.testing.assert_allclose(off[1], np.array(off[0]) / 2, rtol=0, atol=5e-4)


def test_drift_follows_the_coefficients_between_obliquities():
    fine = pt.analysis.yorp_coefficients(FIELD, [1.23])
    drift = pt.analysis.yorp_coefficients(FIELD, np.linspace(0, np.pi, 73)).drift(0.5, 4.0)
    rates = drift({"rate": 2.0, "obliquity": 1.23})
    # Splines of steps of 0.044 rad: the fourth power of the step.
    assert abs(rates["rate"] - 0.5 * fine.spin[0] / 4) < 1e-7
    assert abs(rates["obliquity"] - 0.5 * fine.tilt[0] / (4 * 2)) < 1e-7


def test_wrong_arguments_are_refused_in_sentences():
    some = pt.analysis.yorp_coefficients(FIELD, OBLIQUITIES)
    for call, sentence in (
        (lambda: pt.analysis.yorp_coefficients(FIELD, [0.0, 45.0]), r"obliquities must be a list .* 0 to pi, got \[0"),
        (lambda: pt.analysis.yorp_coefficients(FIELD, [0.0], axis=(0, 0, 0)), "axis must not be zero"),
        (lambda: some.with_lag(-1.0), "thermal_parameter must not be negative"),
        (lambda: some.with_lag(1.0, albedo=1.2), r"albedo must be from 0 to 1, got 1\.2\."),
        (lambda: some.drift(1.0, 0.0), "moment_of_inertia must be positive"),
        (
            lambda: pt.analysis.yorp_coefficients(FIELD, OBLIQUITIES[1:]).drift(1.0, 1.0),
            "obliquities must ascend from 0 to pi",
        ),
    ):
        with pytest.raises(ValueError, match=f"^{sentence}"):
            call()
