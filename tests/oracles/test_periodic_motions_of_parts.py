"""Periodic motions of bodies with parts: linear theory on a circular orbit, and motions that return on an ellipse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import poinsot as pt
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, SpringMass

A, B, C = 0.5, 0.8, 1.0
BODY = pt.Body((A, B, C))
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
PERIOD = 0.8  # of an equilibrium any will do
STIFFNESS = 3 * (B - A)  # in pitch, about the normal of the orbit


def upright(part, **own):
    system = pt.System(BODY, part, pt.GravityGradient(CIRCLE))
    guess = system.state((1, 0, 0, 0), omega_body=(0, 0, 1.0), **own)
    return pt.analysis.periodic_motion(system, guess, PERIOD, CIRCLE.frame)


def roll_and_yaw(h):
    """Frequencies of a gyrostat with the momentum h along the normal, for the mean motion 1.

    The potential in the frame bends by (C - B) + h about the radius and 4 (C - A) + h about the velocity.
    """
    radius, velocity, gyroscopic = C - B + h, 4 * (C - A) + h, A + B - C - h
    squares = np.roots([A * B, -(A * velocity + B * radius + gyroscopic**2), radius * velocity])
    return np.sqrt(squares)


@pytest.mark.parametrize("h", [-0.1, 0.1, 0.3])
def test_gyrostat(h):
    found = upright(Gyrostat((0, 0, h)))
    assert_allclose(found.frequencies, np.sort([*roll_and_yaw(h), np.sqrt(STIFFNESS / C)]), rtol=2e-14)
    assert found.stable


def test_wheel_without_friction_is_a_gyrostat_that_turns_freely_in_pitch():
    moment = 0.1
    found = upright(ReactionWheel((0, 0, 1.0), moment), reaction_wheel=[moment + 0.2])
    assert found.matrix.shape == (7, 7)
    expected = np.sort([*roll_and_yaw(0.2), np.sqrt(STIFFNESS / (C - moment))])
    assert_allclose(found.frequencies, expected, rtol=1e-14)
    assert np.sum(found.multipliers == 1) == 1  # that of its momentum, which is constant
    assert found.stable


def test_damper_in_pitch():
    moment, coefficient = 0.1, 0.2
    found = upright(KaneDamper(moment, coefficient))
    # Angle, momentum of all and of the sphere about the normal.
    rate = np.array([0, 1, -1]) / (C - moment)
    pitch = np.array([rate, (-STIFFNESS, 0, 0), coefficient * (rate - np.array([0, 0, 1]) / moment)])
    exponents = np.log(found.multipliers) / PERIOD
    for each in np.linalg.eigvals(pitch):
        assert np.min(np.abs(exponents - each)) < 2e-14
    assert found.stable
    assert np.all(exponents.real < -1e-3)


def test_gyrostat_loses_its_stability_where_the_potential_is_flat():
    branch = pt.analysis.continue_motion(upright(Gyrostat((0, 0, 0.1))), "rotor_momentum[2]", -3.0, progress=False)
    assert [found.kind for found in branch.bifurcations] == ["branching", "branching"]
    assert_allclose([found.value for found in branch.bifurcations], [-(C - B), -4 * (C - A)], rtol=1e-13)
    assert_allclose(branch.values[-1], -3.0, rtol=1e-15)


def test_family_of_wheels():
    start = upright(ReactionWheel((0, 0, 1.0), 0.1), reaction_wheel=[0.3])
    branch = pt.analysis.continue_motion(start, "forces[0].moment", 0.4, progress=False)
    assert branch.values[-1] == 0.4
    for moment, motion in zip(branch.values, branch.motions, strict=True):
        (p,) = motion.state.own["reaction_wheel"]
        expected = np.sort([*roll_and_yaw(p - moment), np.sqrt(STIFFNESS / (C - moment))])
        assert_allclose(motion.frequencies, expected, rtol=1e-14)


ELLIPSE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.05)
PARTS = (
    Gyrostat((0.002, 0.001, 0.3)),
    ReactionWheel((0.6, 0.0, 0.8), 0.05, 0.02),
    KaneDamper(0.1, 0.2),
    SpringMass(1, 10, (0.0, 0.02, 0.3), (0, 0.6, 0.8), 20.0, 0.5),
)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
def test_motion_on_an_ellipse_returns_with_its_parts(part):
    system = pt.System(pt.Body((0.6, 0.8, 1.0)), part, pt.GravityGradient(ELLIPSE))
    guess = system.state((1, 0, 0, 0), omega_body=(0, 0, 1.05))
    found = pt.analysis.periodic_motion(system, guess, ELLIPSE.period)
    assert found.matrix.shape == (6 + part.size,) * 2
    motion = pt.propagate(system, found.state, ELLIPSE.period * np.arange(3))
    for name, values in motion.phase.items():
        assert_allclose(values[2], values[0], rtol=0, atol=4e-14, err_msg=name)  # q has turned twice


def test_part_that_changes_for_good_is_refused():
    class Boom(pt.Part):
        """A mass that runs out."""

        speed: float

        def inertia(self, own, time):  # noqa: ARG002
            square = (0.1 + self.speed * time) ** 2
            return ((0.0, 0.0, 0.0), (0.0, square, 0.0), (0.0, 0.0, square))

    with pytest.raises(ValueError, match="system must repeat itself in the frame after the period"):
        upright(Boom(0.01))
