"""A body at rest relative to an attractor."""

import numpy as np
import pytest

import poinsot as pt

POINT = pt.orbits.FixedPosition(5.0, position=(1.0, 2.0, 2.0))


@pytest.mark.parametrize("time", [0.0, -3.0, 1e9])
def test_position_and_velocity_at_any_time(time):
    assert list(POINT.position_at(time)) == [1, 2, 2]
    assert list(POINT.velocity_at(time)) == [0, 0, 0]
    assert POINT.inverse_distance_at(time) == pytest.approx(1 / 3, rel=1e-15, abs=0)


def test_it_owns_the_attractors_parameter():
    assert POINT.mu == 5.0


def test_its_direction_is_singled_out_and_it_does_not_turn():
    assert POINT.directions["attractor"].tolist() == [1, 2, 2]
    assert POINT.uniform_rotation is None


def test_gravity_gradient_at_rest_is_that_of_the_position(body, start):
    energy = pt.System(body, pt.GravityGradient(POINT)).potential_energy(start)
    u = start.attitude.inv().apply([1, 2, 2]) / 3
    assert energy == pytest.approx(1.5 * 5.0 / 27 * np.sum(np.array([1.25, 1.0, 0.75]) * u**2), rel=1e-14, abs=0)


def test_slow_circular_orbit_is_a_fixed_point_for_a_short_while(body, start):
    far = pt.KeplerOrbit(1e-6, semimajor_axis=3.0, eccentricity=0.0)
    fixed = pt.orbits.FixedPosition(1e-6, position=(3.0, 0.0, 0.0))
    moving, resting = (
        pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, [0.0, 1.0]) for orbit in (far, fixed)
    )
    assert np.allclose(moving.quaternion, resting.quaternion, rtol=0, atol=1e-10)
