"""Directions and rotations of catalogues, against rotations of SciPy."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.orbits.pole import pole_attitude

LONGITUDE, LATITUDE, PERIOD, ANGLE, EPOCH = np.radians(250.0), np.radians(-75.0), 30.56, 0.7, 12.0
OBLIQUITY = np.radians(84381.448 / 3600)  # IAU 1976
ARCSECOND = np.radians(1 / 3600)
TIMES = np.array([EPOCH, 40.0, 1234.5])


def turned(time, frame=None):
    """Attitude of DAMIT's formula, and its frame in the ICRF."""
    own = Rotation.from_euler("ZYZ", [LONGITUDE, np.pi / 2 - LATITUDE, ANGLE + 2 * np.pi * (time - EPOCH) / PERIOD])
    return Rotation.from_euler("X", OBLIQUITY) * own if frame == "ecliptic" else own


@pytest.mark.parametrize("axes", ["space", "equatorial"])
def test_rotation_about_a_pole_is_the_formula_of_the_catalogue(axes):
    model = pt.orbits.RotationModel.from_pole(LONGITUDE, LATITUDE, PERIOD, ANGLE, epoch=EPOCH, axes=axes)
    for time in TIMES:
        assert (turned(time).inv() * model.attitude(time)).magnitude() < 1e-13  # 240 rad at 1234.5
    np.testing.assert_allclose(model.axes_at(7.0)[2], turned(7.0).as_matrix()[:, 2], rtol=0, atol=1e-15)


def test_ecliptic_of_the_theories_is_the_conventional_one_to_a_tenth_of_an_arcsecond():
    model = pt.orbits.RotationModel.from_pole(LONGITUDE, LATITUDE, PERIOD, ANGLE, epoch=EPOCH, axes="ecliptic")
    assert model.reference_frame == "ICRF"
    for time in TIMES:
        assert (turned(time, "ecliptic").inv() * model.attitude(time)).magnitude() < 0.1 * ARCSECOND
    north = pole_attitude(0.0, np.pi / 2, 0.0, "ecliptic")
    pole = Rotation.from_quat(north, scalar_first=True).apply((0, 0, 1))
    np.testing.assert_allclose(pole, (0, -np.sin(OBLIQUITY), np.cos(OBLIQUITY)), rtol=0, atol=0.1 * ARCSECOND)


def test_pole_at_the_third_axis_has_a_rotation():
    model = pt.orbits.RotationModel.from_pole(0.4, np.pi / 2, PERIOD, 0.3)
    assert (Rotation.from_euler("Z", 0.7).inv() * model.attitude(0.0)).magnitude() < 1e-15


def test_body_at_rest_in_the_axes_of_a_catalogue_rotates_about_the_pole():
    body = pt.Body((1.0, 1.5, 2.0))
    model = pt.orbits.RotationModel.from_pole(LONGITUDE, LATITUDE, PERIOD, ANGLE, epoch=EPOCH)
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=model, time=40.0)
    motion = pt.propagate(pt.System(body), state, [40.0, 100.0])
    assert (turned(100.0).inv() * motion.attitude[-1]).magnitude() < 1e-13
    np.testing.assert_allclose(motion.omega_body[0], (0, 0, 2 * np.pi / PERIOD), rtol=0, atol=1e-16)


def test_members_have_poles_of_their_own():
    poles, periods = np.array([0.1, 0.2]), np.array([1.0, 2.0])
    both = pt.orbits.RotationModel.from_pole(poles, 0.5, periods, 0.3)
    for member in range(2):
        one = pt.orbits.RotationModel.from_pole(poles[member], 0.5, periods[member], 0.3)
        np.testing.assert_array_equal(both.quaternion(TIMES)[member], one.quaternion(TIMES))


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        (
            {"period": -3.0},
            "period must be positive, got -3.0. The pole of a retrograde rotation has a negative latitude.",
        ),
        ({"axes": "galactic"}, "axes must be one of space, equatorial, ecliptic, got 'galactic'."),
        ({"latitude": [0.1, 0.2, 0.3]}, "latitude must have as many members as longitude, got 3 and 2."),
    ],
)
def test_wrong_arguments(changed, sentence):
    arguments = {"longitude": [0.1, 0.2], "latitude": 0.5, "period": 3.0}
    with pytest.raises(ValueError, match="^" + re.escape(sentence) + "$"):
        pt.orbits.RotationModel.from_pole(**(arguments | changed))
