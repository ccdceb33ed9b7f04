"""Points near two attractors: forces in balance, and the librations of a body held there."""

import numpy as np
import pytest

import poinsot as pt
from in_order import in_order

POINTS = ("L1", "L2", "L3", "L4", "L5")
RATIOS = (0.5, 0.3, 0.0121505856, 3.04e-6, 1e-10)
TIMES = np.array([0.0, 0.3, 7.0, 1e3])
BODY = pt.Body((1.0, 1.3, 1.5))


def point_of(name, mu, separation=2.0, size=3.0, epoch=0.0):
    return pt.orbits.LagrangePointPath((1 - mu) * size, mu * size, separation=separation, point=name, epoch=epoch)


def place(orbit, time=0.0):
    return np.array(orbit.position_at(time))


@pytest.mark.parametrize("mu", RATIOS)
@pytest.mark.parametrize("name", POINTS)
def test_attraction_keeps_the_body_on_its_circle(name, mu):
    point = point_of(name, mu)
    primary, secondary = place(point.from_primary), place(point.from_secondary)
    assert np.max(np.abs(primary - secondary - (2.0, 0, 0))) < 1e-15
    pulls = [
        -attractor * r / np.linalg.norm(r) ** 3
        for attractor, r in ((point.mu_primary, primary), (point.mu_secondary, secondary))
    ]
    centrifugal = point.mean_motion**2 * (primary - (point.mass_ratio * 2.0, 0, 0))
    size = sum(map(np.linalg.norm, pulls))
    # The pull of a light secondary changes fast with the distance: by 1 / mu^(1/3) relative to that of the primary.
    assert np.max(np.abs(sum(pulls) + centrifugal)) < 8e-16 * size / min(1, (mu / 3) ** (1 / 3))


def test_order_of_the_points():
    by_name = {name: place(point_of(name, 0.01).from_primary) / 2.0 for name in POINTS}
    assert 0 < by_name["L1"][0] < 1 < by_name["L2"][0]
    assert -1.1 < by_name["L3"][0] < -0.9
    assert by_name["L4"][1] > 0 > by_name["L5"][1]  # the secondary moves along the second axis, L4 leads it


@pytest.mark.parametrize("name", POINTS)
def test_both_orbits_turn_with_the_frame(name):
    point = point_of(name, 0.2, epoch=0.4)
    for orbit in (point.from_primary, point.from_secondary):
        frame, r = point.frame, np.stack(np.broadcast_arrays(*orbit.position_at(TIMES)), axis=-1)
        turned = frame.attitude(TIMES).apply(place(orbit, 0.4))
        assert np.max(np.abs(r - turned)) < 1e-14
        velocity = np.stack(np.broadcast_arrays(*orbit.velocity_at(TIMES)), axis=-1)
        assert np.max(np.abs(velocity - np.cross(frame.omega_space(TIMES), r))) < 1e-15
        assert np.max(np.abs(np.linalg.norm(r, axis=-1) * orbit.inverse_distance_at(TIMES) - 1)) < 1e-15


@pytest.mark.parametrize("name", POINTS)
def test_librations_of_a_body_held_at_the_point(name):
    # Two attractors pull like the tensor of sum 3 mu n n^T / r^3; its axes are those of rest, and a body with its
    # long axis along the first librates in the plane at sqrt((k1 - k2)(I2 - I1)/I3).
    point = point_of(name, 0.1)
    orbits = point.from_primary, point.from_secondary
    system = pt.System(BODY, *map(pt.GravityGradient, orbits))
    tensor = sum(3 * orbit.mu * np.outer(r, r) / np.linalg.norm(r) ** 5 for orbit, r in ((o, place(o)) for o in orbits))
    strengths = np.linalg.eigvalsh(tensor[:2, :2])
    pitch = np.sqrt((strengths[1] - strengths[0]) * (1.3 - 1.0) / 1.5)
    stable = [found for found in pt.analysis.equilibria(system, point.frame) if found.stability == "lyapunov"]
    assert stable
    for found in stable:
        assert np.min(np.abs(found.frequencies / pitch - 1)) < 1e-12
    if name in ("L1", "L2", "L3"):  # on the line all of the tensor is along it
        assert strengths[0] == 0


def test_motion_at_the_point_keeps_the_jacobi_integral():
    point = point_of("L2", 0.1)
    system = pt.System(BODY, pt.GravityGradient(point.from_primary), pt.GravityGradient(point.from_secondary))
    start = BODY.state((0.9, 0.1, 0.3, -(0.09**0.5)), omega_body=(0.1, -0.3, 0.2))
    motion = pt.propagate(system, start, np.linspace(0, 60, 61))
    assert [integral.name for integral in system.integrals] == ["jacobi_energy"]
    assert np.max(np.abs(motion.drift["jacobi_energy"])) < 1e-13
    assert np.ptp(motion.energy) > 1e-3


WRONG = {
    "mu_secondary must not exceed mu_primary, got 2.0 and 1.0. The primary is the heavier one.": (1, 2, 1, "L1"),
    "separation must be positive, got 0.0.": (1, 0.1, 0, "L1"),
    "point must be one of L1, L2, L3, L4, L5, got 'L6'.": (1, 0.1, 1, "L6"),
    "mu_primary must be positive, got -1.0.": (-1, -2, 1, "L1"),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_points_are_refused(sentence):
    with pytest.raises(ValueError) as error:
        in_order(pt.orbits.LagrangePointPath, *WRONG[sentence])
    assert str(error.value) == sentence


def test_a_point_on_its_attractor_is_refused():
    with pytest.raises(ValueError, match=r"^position must not be zero, got all components 0\. The body would be"):
        pt.orbits.RotatingPosition(1.0, position=(0, 0, 0), rate=1.0)
