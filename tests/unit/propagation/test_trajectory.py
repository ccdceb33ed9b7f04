"""What is read from a motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

TIMES = np.linspace(-1, 9, 21)
MOMENTS = np.array([1.25, 1.0, 0.75])


@pytest.fixture(scope="module")
def motion(top, start):
    return pt.propagate(top, start, TIMES)


def test_first_axis_is_the_times(motion):
    for name in ("omega_body", "omega_space", "angular_momentum_body", "angular_momentum_space"):
        assert getattr(motion, name).shape == (21, 3)
    for name in ("quaternion", "conjugate_momenta"):
        assert getattr(motion, name).shape == (21, 4)
    for name in ("times", "kinetic_energy", "potential_energy", "energy", "norm_error", "tangency_error"):
        assert getattr(motion, name).shape == (21,)
    assert len(motion.attitude) == 21


def test_a_motion_knows_its_system_and_its_start(motion, top, start):
    assert motion.system is top
    assert motion.initial is start


def test_angular_momentum_and_rates_are_consistent(motion):
    turn = Rotation.from_quat(motion.quaternion, scalar_first=True)
    assert np.allclose(motion.angular_momentum_body, MOMENTS * motion.omega_body, rtol=0, atol=1e-15)
    assert np.allclose(motion.angular_momentum_space, turn.apply(motion.angular_momentum_body), rtol=0, atol=1e-14)
    assert np.allclose(motion.omega_space, turn.apply(motion.omega_body), rtol=0, atol=1e-14)


def test_attitude_is_scipys_body_to_space(motion):
    expected = Rotation.from_quat(motion.quaternion, scalar_first=True)
    assert np.max((expected.inv() * motion.attitude).magnitude()) < 1e-15


def test_rates_are_the_derivative_of_the_attitude(top, start):
    step = 1e-5
    motion = pt.propagate(top, start, [2 - step, 2.0, 2 + step])
    turn = (motion.attitude[2] * motion.attitude[0].inv()).as_rotvec() / (2 * step)
    assert np.allclose(motion.omega_space[1], turn, rtol=0, atol=1e-9)


def test_energies(motion):
    height = motion.attitude.apply([1.0, 0.2, -0.3])[:, 2]
    assert np.allclose(motion.kinetic_energy, 0.5 * np.sum(MOMENTS * motion.omega_body**2, axis=-1), atol=1e-15)
    assert np.allclose(motion.potential_energy, 0.5 * height, rtol=0, atol=1e-14)
    assert np.array_equal(motion.energy, motion.kinetic_energy + motion.potential_energy)


def test_potential_energy_of_a_free_body_is_zero(body, start):
    assert pt.propagate(pt.System(body), start, TIMES).potential_energy.tolist() == [0.0] * 21


def test_rates_and_energies_of_an_oblique_body(start):
    tensor = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.2], [-0.1, 0.2, 2.5]])
    motion = pt.propagate(pt.System(pt.Body.from_inertia(tensor)), start, TIMES)
    assert np.allclose(motion.omega_body @ tensor, motion.angular_momentum_body, rtol=0, atol=1e-14)
    energy = 0.5 * np.sum(motion.omega_body * motion.angular_momentum_body, axis=-1)
    assert np.allclose(motion.kinetic_energy, energy, rtol=1e-14)
    assert np.max(np.abs(motion.drift["energy"])) < 1e-14


def test_euler_variables_along_the_way(motion):
    angles, momenta = motion.euler()
    states = [
        pt.State(q, pt.project_to_tangent(q, Q)).euler()
        for q, Q in zip(motion.quaternion, motion.conjugate_momenta, strict=True)
    ]
    assert np.allclose(angles, [a for a, _ in states], rtol=0, atol=1e-12)
    assert np.allclose(momenta, [p for _, p in states], rtol=0, atol=1e-12)
    assert np.allclose(motion.euler("321")[0].shape, (21, 3))


def test_third_space_component_is_the_first_momentum_of_313(motion):
    assert np.allclose(motion.euler("313")[1][:, 0], motion.angular_momentum_space[:, 2], rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- proof


def test_norm_and_tangency_errors_are_measured_not_removed(motion):
    assert np.array_equal(motion.norm_error, np.sqrt(np.sum(motion.quaternion**2, axis=-1)) - 1) or np.allclose(
        motion.norm_error, np.linalg.norm(motion.quaternion, axis=-1) - 1, rtol=0, atol=3e-16
    )
    expected = np.sum(motion.quaternion * motion.conjugate_momenta, axis=-1)
    assert np.allclose(motion.tangency_error, expected, rtol=0, atol=1e-15)
    assert np.max(np.abs(motion.norm_error)) < 1e-14


def test_norm_error_of_a_state_off_the_sphere_is_seen(top):
    q = np.array([1 + 5e-10, 0, 0, 0])
    motion = pt.propagate(top, pt.State(q, (0, 1, 0, 0)), [0.0, 1.0])
    assert np.allclose(motion.norm_error, 5e-10, rtol=1e-5)


def test_integrals_and_their_drift(motion, top):
    assert list(motion.integrals) == list(motion.drift) == ["energy", "angular_momentum_space_3"]
    assert np.allclose(motion.integrals["energy"], motion.energy, rtol=0, atol=1e-15)
    scale = np.max(np.abs(motion.kinetic_energy) + np.abs(motion.potential_energy))
    expected = (motion.energy - top.energy(motion.initial)) / scale
    assert np.allclose(motion.drift["energy"], expected, rtol=0, atol=1e-16)
    momentum = np.max(np.linalg.norm(motion.angular_momentum_body, axis=-1))
    expected = (motion.angular_momentum_space[:, 2] - motion.initial.angular_momentum_space[2]) / momentum
    assert np.allclose(motion.drift["angular_momentum_space_3"], expected, rtol=0, atol=1e-16)


def test_drift_grows_with_the_tolerance(top, start):
    loose, tight = (pt.propagate(top, start, TIMES, tolerance=t).drift["energy"] for t in (1e-4, 1e-12))
    assert np.max(np.abs(loose)) > 100 * np.max(np.abs(tight))


def test_drift_of_a_body_at_rest_is_zero(body):
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [0.0, 1.0])
    assert all(drift.tolist() == [0, 0] for drift in motion.drift.values())


def test_no_integrals_no_drift(satellite, start):
    motion = pt.propagate(satellite, start, [0.0, 1.0])
    assert motion.drift == motion.integrals == {}
    assert motion.summary["integrals"] == "none: this system conserves neither energy nor a momentum"


def test_summary_is_one_flat_record(motion):
    summary = motion.summary
    assert summary["method"] == "Taylor"
    assert summary["formulation"] == "lie_poisson"
    assert summary["steps"] == motion.run.steps
    assert summary["tolerance"] == motion.run.tolerance
    assert summary["norm_error"] == np.max(np.abs(motion.norm_error))
    assert summary["drift_energy"] == np.max(np.abs(motion.drift["energy"]))
    assert "drift_angular_momentum_space_3" in summary
    assert all(isinstance(value, str | int | float) for value in summary.values())


def test_repr_says_what_ran_and_how_well(motion):
    lines = repr(motion).splitlines()
    assert lines[0].startswith("Trajectory of System(Body(")
    assert lines[1] == "  times: 21, -1 ... 9"
    for word in ("formulation: lie_poisson", "steps: ", "norm_error: ", "drift_energy: "):
        assert any(line.strip().startswith(word) for line in lines)


# ---------------------------------------------------------------------- frames


def test_relative_to_a_frame_at_rest_is_the_motion_itself(motion):
    relative = motion.relative_to(pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0)))
    assert np.array_equal(relative.quaternion, motion.quaternion)
    assert np.array_equal(relative.omega_body, motion.omega_body)
    assert np.array_equal(relative.times, motion.times)


def test_relative_rate_is_the_derivative_of_the_relative_attitude(satellite, start):
    step, frame = 1e-5, satellite.forces[0].orbit.frame
    motion = pt.propagate(satellite, start, [2 - step, 2.0, 2 + step])
    relative = motion.relative_to(frame)
    turn = (relative.attitude[0].inv() * relative.attitude[2]).as_rotvec() / (2 * step)
    middle = relative.attitude[0].inv() * relative.attitude[1]
    assert np.allclose(relative.omega_body[1], middle.inv().apply(turn), rtol=0, atol=1e-8)


def test_relative_attitude_is_body_to_frame(satellite, start):
    frame = satellite.forces[0].orbit.frame
    motion = pt.propagate(satellite, start, TIMES)
    expected = frame.attitude(TIMES).inv() * motion.attitude
    assert np.max((expected.inv() * motion.relative_to(frame).attitude).magnitude()) < 2.5e-15


def test_gravity_gradient_equilibrium_stays_in_the_orbit_frame():
    orbit = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1)
    body = pt.Body((1.0, 1.3, 1.6))
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), state, np.linspace(0, orbit.period, 9))
    relative = motion.relative_to(orbit.frame)
    assert np.max(relative.attitude.magnitude()) < 1e-13
    assert np.max(np.abs(relative.omega_body)) < 1e-13
