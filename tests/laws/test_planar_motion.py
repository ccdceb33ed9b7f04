"""The formulation "planar": the motion of a body that turns about its third axis alone, and its tangent vectors."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.2, argument_of_periapsis=0.4)
BODY = pt.Body.from_ratios(beta=0.47, gamma=0.26)
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT))
UP = (np.cos(0.2), 0, 0, np.sin(0.2))
TIMES = np.linspace(-7, 20, 14)


@pytest.mark.parametrize("rate", [0.4, 2.5])
@pytest.mark.parametrize("forces", [(), (pt.forces.LinearDamping(0.05),)], ids=["conservative", "damped"])
def test_the_motion_is_the_one_in_space(rate, forces):
    system, start = pt.System(BODY, *SYSTEM.forces, *forces), BODY.state(UP, omega_body=(0, 0, rate))
    planar, space = (pt.propagate(system, start, TIMES, formulation=name) for name in ("planar", "lie_poisson"))
    np.testing.assert_allclose(planar.quaternion, space.quaternion, rtol=0, atol=3e-13)
    np.testing.assert_allclose(planar.omega_body, space.omega_body, rtol=0, atol=3e-13)
    assert np.all(planar.quaternion[:, 1:3] == 0)
    assert planar.run.formulation == "planar"


def test_tangent_vectors_are_those_in_space():
    start = BODY.state(UP, omega_body=(0, 0, 2.5))
    plane = pt.analysis.state_transition(SYSTEM, start, TIMES, ["eccentricity"], formulation="planar")
    space = pt.analysis.state_transition(SYSTEM, start, TIMES, ["eccentricity"])
    own = np.ix_(range(len(TIMES)), [2, 5], [2, 5])
    # Three times the worst of 21 shaken starts; entries grow to 42.
    np.testing.assert_allclose(plane.matrix, space.matrix[own], rtol=0, atol=2e-11)
    np.testing.assert_allclose(plane.sensitivity, space.sensitivity[:, [2, 5]], rtol=0, atol=1e-11)
    np.testing.assert_allclose(np.linalg.det(plane.matrix), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("formulation", ["planar", "lie_poisson"])
def test_tangent_vectors_leave_the_motion_alone(formulation):
    start = BODY.state(np.array([UP, UP]), omega_body=(0, 0, 2.5) * np.ones((2, 1)))
    alone = pt.propagate(SYSTEM, start, TIMES, formulation=formulation)
    reference = pt.analysis.state_transition(SYSTEM, start, TIMES, formulation=formulation).motion
    np.testing.assert_allclose(reference.quaternion, alone.quaternion, rtol=0, atol=6e-14)
    np.testing.assert_allclose(reference.conjugate_momenta, alone.conjugate_momenta, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("system", "start", "what"),
    [
        (SYSTEM, BODY.state(UP, omega_body=(0, 1e-3, 1)), "angular momentum has components along the others, up to"),
        (SYSTEM, BODY.state((0.8, 0.6, 0, 0), omega_body=(0, 0, 1)), "torque has components along the others, up to"),
        (
            pt.System(pt.Body.from_inertia([[2, 0, 0.1], [0, 2.5, 0], [0.1, 0, 3]])),
            pt.State((1, 0, 0, 0), (0, 0, 0, 1)),
            "inertia tensor has components along the others, up to 0.1. Use the default formulation.",
        ),
        (pt.System(BODY, pt.UniformGravity(1.0, (1, 0, 0))), BODY.state(UP, omega_body=(0, 0, 1)), "torque has"),
    ],
    ids=["momentum", "attitude", "inertia", "gravity"],
)
def test_a_body_that_turns_otherwise_is_refused(system, start, what):
    sentence = "formulation 'planar' must be for a body that turns about its third axis alone, but its " + re.escape(
        what
    )
    with pytest.raises(ValueError, match=f"^{sentence}"):
        pt.propagate(system, start, [1.0], formulation="planar")
    with pytest.raises(ValueError, match=f"^{sentence}"):
        pt.analysis.chaos_indicators(system, start, [1.0], formulation="planar")


def test_ensembles_of_states_and_of_parameters():
    rates = np.linspace(0.3, 2.7, 9)
    spins = rates[:, None] * (0, 0, 1.0)
    many = pt.propagate(SYSTEM, BODY.state(np.broadcast_to(UP, (9, 4)), omega_body=spins), TIMES, formulation="planar")
    eccentricities = np.linspace(0, 0.4, 9)
    orbits = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=eccentricities, argument_of_periapsis=0.4)
    start = BODY.state(UP, omega_body=(0, 0, 1.0))
    others = pt.propagate(pt.System(BODY, pt.GravityGradient(orbits)), start, TIMES, formulation="planar")
    for i in (0, 4, 8):
        one = pt.propagate(SYSTEM, BODY.state(UP, omega_body=spins[i]), TIMES)
        np.testing.assert_allclose(many.quaternion[i], one.quaternion, rtol=0, atol=3e-12)
        orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=eccentricities[i], argument_of_periapsis=0.4)
        one = pt.propagate(pt.System(BODY, pt.GravityGradient(orbit)), start, TIMES)
        np.testing.assert_allclose(others.quaternion[i], one.quaternion, rtol=0, atol=3e-12)


class Pole(pt.Potential):
    """An energy of the third body axis along the normal of an inclined orbit, given by its components in space."""

    def energy(self, instant):
        return 0.1 * instant.attitude.to_body((np.sin(0.5), 0.0, np.cos(0.5)))[2] ** 2


def test_an_inclined_orbit_is_taken_along_itself_and_refused_in_the_space_axes():
    orbit, body = (
        pt.KeplerOrbit(
            1.0, semimajor_axis=1.0, eccentricity=0.1, inclination=0.5, node=np.pi / 2, argument_of_periapsis=0.2
        ),
        pt.Body((1.0, 1.3, 1.7)),
    )
    start = body.state(Rotation.from_euler("ZXZ", (np.pi / 2, 0.5, 0.3)), omega_body=(0, 0, 1.3))
    along = pt.System(body, pt.GravityGradient(orbit))
    planar = pt.propagate(along, start, [5.0], formulation="planar")
    assert np.max(np.abs(planar.quaternion - pt.propagate(along, start, [5.0]).quaternion)) < 1e-14
    for system, parameters in ((pt.System(body, pt.GravityGradient(orbit), Pole()), []), (along, ["eccentricity"])):
        with pytest.raises(ValueError, match=r"along the third space axis .*, but it is 0\.49 rad off"):
            pt.analysis.state_transition(system, start, [5.0], parameters, formulation="planar")
