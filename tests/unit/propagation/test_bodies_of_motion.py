"""Motions of two bodies as arguments, and the motion of one body out of any."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.checked import checked
from poinsot.propagation.bodies_of_motion import OfTwoBodies, is_of_two_bodies, of_one_body

BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
PAIR = pt.TwoBodies(BALL, BALL, G=1.0)


def one():
    return pt.free_motion(BALL, BALL.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])


def two():
    start = PAIR.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1), (0, 0, 0.5)])
    return pt.propagate(pt.System(PAIR, pt.forces.MutualGravity()), start, [0.0, 1.0])


@checked
def distance(motion: OfTwoBodies) -> float:
    return float(motion.distance[0])


def test_functions_of_two_bodies_take_no_other_motion():
    assert is_of_two_bodies(two())
    assert not is_of_two_bodies(one())
    assert not is_of_two_bodies(two().primary)
    assert distance(two()) == 2.0
    for motion in (one(), two().primary):
        with pytest.raises(TypeError, match=r"^motion must be the motion of two bodies, got the motion of one body\.$"):
            distance(motion)
    with pytest.raises(TypeError, match=r"^motion must be a Trajectory, got int\.$"):
        distance(3)


def test_one_body_of_any_motion():
    alone, both = one(), two()
    assert of_one_body(alone, None) is alone
    assert np.array_equal(of_one_body(both, "secondary").omega_body, both.secondary.omega_body)
    with pytest.raises(ValueError, match=r"^body must be primary or secondary, got none\.$"):
        of_one_body(both, None)
    with pytest.raises(ValueError, match=r"^body must be primary or secondary, got moon\.$"):
        of_one_body(both, "moon")
    with pytest.raises(ValueError, match=r"^body must not be there for a motion of one body, got primary\.$"):
        of_one_body(alone, "primary")
