"""Branches of periodic motions: whatever changes in stability between two motions has its bifurcation."""

import numpy as np
import pytest

import poinsot as pt

CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.3, node=0.2, argument_of_periapsis=0.1)


def forced(beta, gamma, to, e=0.01):
    """Librations of a body on an ellipse."""
    body, orbit = pt.Body.from_ratios(beta=beta, gamma=gamma), pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=e)
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1.0))
    motion = pt.analysis.periodic_motion(pt.System(body, pt.GravityGradient(orbit)), start, orbit.period)
    return pt.analysis.continue_motion(motion, "eccentricity", to)


def upright(c):
    """A top with three different moments, its centre of mass above the point that is fixed."""
    return pt.System(pt.Body((1.0, 1.2, c)), pt.UniformGravity(weight=0.5, center_of_mass=(0, 0, 1)))


def spinning_top():
    start = upright(0.4).body.state((1, 0, 0, 0), omega_body=(0, 0, 4.0))
    return pt.analysis.continue_motion(
        pt.analysis.periodic_motion(upright(0.4), start, np.pi / 2), upright, 1.9, start=0.4
    )


def sleeping_top():
    system = pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(weight=0.5, center_of_mass=(0, 0, 1)))
    start = system.body.state((1, 0, 0, 0), omega_body=(0, 0, 4.0))
    return pt.analysis.continue_motion(pt.analysis.periodic_motion(system, start, np.pi / 2), "weight", 1.5)


def sleeping_top_seen_from_its_precession():
    """At the end the multipliers outside are 8e6, and rounding has its part in those at 1."""
    system = pt.System(pt.Body((1.0, 1.0, 1.6)), pt.UniformGravity(weight=1.28, center_of_mass=(0, 0, 1)))
    start, frame = system.body.state((1, 0, 0, 0), omega_body=(0, 0, 2.0)), pt.RotatingFrame((1, 0, 0, 0), (0, 0, 1.6))
    return pt.analysis.continue_motion(pt.analysis.periodic_motion(system, start, np.pi / 0.2, frame), "weight", 3.584)


class Brake(pt.Torque):
    """What slows the rotation about one axis, from the rate of the orbit, and drives it when negative."""

    strength: float

    def torque(self, instant):
        normal = instant.attitude.to_body(tuple(CIRCLE.normal))
        return 0.0, 0.0, -self.strength * (instant.omega_body[2] - normal[2])


def driven():
    body = pt.Body((1.0, 1.3, 1.6))
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=CIRCLE.frame)
    system = pt.System(body, pt.GravityGradient(CIRCLE), Brake(0.02))
    return pt.analysis.continue_motion(
        pt.analysis.periodic_motion(system, start, 0.2 * CIRCLE.period, CIRCLE.frame), "strength", -0.03
    )


FAMILIES = {
    "Hyperion": lambda: forced(0.47, 0.1, 0.75, 0.02),  # two branchings within 0.0025 of the eccentricity
    "Hyperion, in other steps": lambda: forced(0.47, 0.1, 0.72, 0.02),
    "two doublings and a branching": lambda: forced(0.556658, 0.178981, 0.5),
    "with a fold": lambda: forced(0.663502, 0.494367, 0.5),
    "with a collision": lambda: forced(0.385931, 0.0749014, 0.3),
    "spinning top": spinning_top,
    "sleeping top": sleeping_top,
    "sleeping top, seen from its precession": sleeping_top_seen_from_its_precession,
    "driven": driven,
}


SLOW = {"Hyperion", "Hyperion, in other steps", "two doublings and a branching"}


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in FAMILIES],
)
def branch(request):
    name = request.param
    return FAMILIES[name]()


def outside(motion):
    """By LAPACK alone; where multipliers meet it does not know them better than the root of a rounding."""
    return int(np.sum(np.abs(np.linalg.eigvals(motion.matrix)) > 1 + 1e-5))


def test_counts_of_unstable_multipliers_are_explained(branch):
    counts = [outside(motion) for motion in branch.motions]
    assert len({*counts}) > 1 or "fold" in {each.kind for each in branch.bifurcations}
    for i, change in enumerate(np.diff(counts)):
        between = [each for each in branch.bifurcations if each.after == i]
        assert change == sum(each.change for each in between), branch.values[i : i + 2]
        low, high = sorted(branch.values[i : i + 2])
        assert all(each.kind == "fold" or low <= each.value <= high for each in between)


def test_multipliers_are_where_the_kind_says(branch):
    """Two multipliers that meet are known to the root of a rounding times the matrix: 2e-7 at the worst here."""
    for found in branch.bifurcations:
        assert found.kind != "unresolved"
        multipliers = np.linalg.eigvals(found.motion.matrix)
        if found.kind in ("fold", "branching"):
            assert np.min(np.abs(multipliers - 1)) < 1e-6
        elif found.kind == "doubling":
            assert np.min(np.abs(multipliers + 1)) < 1e-6
        elif found.kind == "collision":
            upper = multipliers[(multipliers.imag > 1e-6) & (np.abs(np.abs(multipliers) - 1) < 1e-6)]
            assert np.min(np.abs(upper[:, None] - upper) + 9 * np.eye(upper.size)) < 1e-6
        else:  # one pair passes, and the others stay on the circle
            np.testing.assert_allclose(np.abs(multipliers), 1, rtol=0, atol=1e-11)


def test_bifurcations_repeat_themselves(branch):
    for found in branch.bifurcations:
        motion = found.motion
        end = motion.state.time + motion.period
        over = pt.propagate(motion.system, motion.state, [end])
        seen = [
            motion.frame.attitude(float(time)).inv() * attitude
            for time, attitude in ((motion.state.time, motion.state.attitude), (end, over.attitude[0]))
        ]
        assert (seen[0].inv() * seen[1]).magnitude() < 1e-12
        g = [np.ravel(x.angular_momentum_body) for x in (motion.state, over)]
        np.testing.assert_allclose(g[1], g[0], rtol=0, atol=1e-12)
