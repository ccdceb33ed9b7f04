"""State transition: members, both ways of time, planar motion, names of parameters, refusals."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import poinsot as pt
from poinsot import functions

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
BODY = pt.Body((1.0, 1.3, 1.7))
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT))
START = BODY.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.1, 0.2, 0.9))


def test_the_motion_is_that_without_variational_equations():
    times = np.linspace(0, 20, 5)
    along = pt.analysis.state_transition(SYSTEM, START, times).motion
    assert_allclose(along.quaternion, pt.propagate(SYSTEM, START, times).quaternion, rtol=0, atol=2e-12)


def test_back_and_forth_is_the_identity():
    there = pt.analysis.state_transition(SYSTEM, START, [3.0])
    there_state = pt.State(there.motion.quaternion[0], there.motion.conjugate_momenta[0], 3.0)
    back = pt.analysis.state_transition(SYSTEM, there_state, [0.0])
    assert_allclose(back.matrix[0] @ there.matrix[0], np.eye(6), rtol=0, atol=1e-12)


def test_falling_times_are_in_their_order():
    falling = pt.analysis.state_transition(SYSTEM, START, [2.0, 1.0, -1.0])
    rising = pt.analysis.state_transition(SYSTEM, START, [-1.0, 1.0, 2.0])
    assert_allclose(falling.matrix, rising.matrix[::-1], rtol=0, atol=0)
    assert_allclose(falling.motion.quaternion, rising.motion.quaternion[::-1], rtol=0, atol=0)


def test_members_are_those_one_by_one():
    eccentricities = np.array([0.0, 0.1, 0.3])
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=eccentricities)
    found = pt.analysis.state_transition(
        pt.System(BODY, pt.GravityGradient(orbit)), START, [1.0, 2.0], ["eccentricity"]
    )
    assert found.matrix.shape == (3, 2, 6, 6)
    for i, e in enumerate(eccentricities):
        alone = pt.System(BODY, pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=e)))
        single = pt.analysis.state_transition(alone, START, [1.0, 2.0], ["eccentricity"])
        assert_allclose(found.matrix[i], single.matrix, rtol=0, atol=1e-13)
        assert_allclose(found.sensitivity[i], single.sensitivity, rtol=0, atol=1e-13)


def test_planar_motion_has_a_block_of_the_six():
    start = BODY.state((np.cos(0.2), 0, 0, np.sin(0.2)), omega_body=(0, 0, 1.2))
    six = pt.analysis.state_transition(SYSTEM, start, [5.0], ["eccentricity"])
    two = pt.analysis.state_transition(SYSTEM, start, [5.0], ["eccentricity"], formulation="planar")
    block = np.ix_([0], (2, 5), (2, 5))
    assert_allclose(two.matrix, six.matrix[block], rtol=0, atol=1e-13)
    assert_allclose(two.sensitivity, six.sensitivity[:, (2, 5)], rtol=0, atol=1e-12)


def test_one_orbit_of_several_forces_is_one_parameter():
    system = pt.System(BODY, pt.GravityGradient(ORBIT), pt.forces.Oblateness(ORBIT, 0.01, 0.5, (0, 0, 1)))
    assert pt.analysis.state_transition(system, START, [1.0], ["eccentricity"]).sensitivity.shape == (1, 6, 1)


def test_covariance_of_known_parameters_is_that_of_the_state():
    found = pt.analysis.state_transition(SYSTEM, START, [1.0])
    phi = found.matrix[0]
    assert_allclose(found.covariance(np.eye(6))[0], phi @ phi.T, rtol=1e-14)


class Timed(pt.Torque):
    """A torque that ends at a time."""

    end: float

    def torque(self, instant):
        """Return the torque."""
        return functions.Vector((functions.where(functions.less(instant.time, self.end), 0.1, 0.0), 0.0, 0.0))


def test_torques_that_end_at_a_time_are_taken():
    found = pt.analysis.state_transition(pt.System(BODY, Timed(0.5)), START, [0.5, 1.0])
    rest = pt.State(found.motion.quaternion[0], found.motion.conjugate_momenta[0], 0.5)
    free = pt.analysis.state_transition(pt.System(BODY), rest, [1.0])
    assert_allclose(found.matrix[1], free.matrix[0] @ found.matrix[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"parameters": ["eccentricty"]}, "'eccentricty'. Near: forces[0].orbit.eccentricity"),
        ({"parameters": ["moments"]}, "must name single numbers"),
        ({"parameters": "moments[0]"}, "parameters must be a list, each a text, got str"),
        ({"order": 3}, "order must be 1 or 2"),
        ({"formulation": "canonical"}, "formulation must be one of lie_poisson, planar for variational equations"),
        ({"formulation": "planar"}, "must be for a body that turns about its third axis alone"),
    ],
)
def test_refusals(arguments, sentence):
    with pytest.raises((ValueError, TypeError), match=r"^[a-z ']+must") as raised:
        pt.analysis.state_transition(SYSTEM, START, [1.0], **arguments)
    assert sentence in str(raised.value)


def test_orbits_that_are_integrated_along():
    path = pt.orbits.ThreeBodyPath(1.0, 0.0123, separation=1.0, position=(0.85, 0.0, 0.1), velocity=(0.0, 0.25, 0.0))
    system = pt.System(BODY, pt.GravityGradient(path.from_primary), pt.GravityGradient(path.from_secondary))
    matrix = pt.analysis.state_transition(system, START, [1.0]).matrix[0]
    assert abs(np.linalg.det(matrix) - 1) < 1e-12
    with pytest.raises(ValueError, match="must not belong to an orbit that is integrated with the motion"):
        pt.analysis.state_transition(system, START, [1.0], ["forces[0].orbit.path.mu_primary"])


@pytest.mark.parametrize(
    ("matrix", "rule"),
    [(np.eye(5), "shape"), (np.eye(6) + np.eye(6, k=1), "symmetric"), (-np.eye(6), "no negative eigenvalue")],
)
def test_covariances_are_checked(matrix, rule):
    with pytest.raises(ValueError, match=rule):
        pt.analysis.state_transition(SYSTEM, START, [1.0]).covariance(matrix)


def test_a_state_transition_that_would_not_end_stops():
    body = pt.Body((1.3, 1.0, 0.7))
    start = body.state((1, 0, 0, 0), omega_body=(0.4, -0.6, 0.5))
    with pytest.raises(pt.PropagationError, match=r"the steps became so short, [\d.]+, that it would not end\."):
        pt.analysis.state_transition(pt.System(body), start, [2.0**53])
