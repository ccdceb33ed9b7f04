"""Other motions on a page."""

import base64

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.plot.page_content import MAX_GHOSTS, content_of, others_of

BODY = pt.Body((1.0, 2.0, 3.0))
RATES = np.linspace(1.0, 2.0, 20)[:, None] * (0.0, 0.1, 1.0)


def motion(rates, times=(0.0, 1.0)):
    return pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=rates), times)


def test_few_others_are_all_shown():
    few = [motion((0, 0, 1)), motion((0, 0, 2))]
    assert others_of(few[0], few) == few
    assert others_of(few[0], None) == []


def test_members_are_spread_over_an_ensemble():
    ensemble = motion(RATES)
    found = others_of(motion((0, 0, 1)), ensemble)
    rates = [float(each.omega_body[0, 2]) for each in found]
    assert len(found) == MAX_GHOSTS
    assert (rates[0], rates[-1]) == pytest.approx((1.0, 2.0), rel=1e-14, abs=0)
    assert np.all(np.diff(rates) > 0)


@pytest.mark.parametrize("moments", [(0.01, 0.02, 0.025), (0.025, 0.01, 0.02)], ids=["abc", "cab"])
@pytest.mark.parametrize(("turn", "tilt"), [(0.2, 0.0), (-1.2, 0.0), (2.9, 0.0), (0.0, 0.3)])
def test_libration_of_the_secondary(moments, turn, tilt):
    """The axis of the least moment is turned away from the line of centres, in the plane of the orbit or out of it."""
    pair = pt.TwoBodies(pt.Body((0.3, 0.5, 0.6), mass=3.0), pt.Body(moments, mass=0.5), G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity())
    long, short = np.eye(3)[np.argmin(moments)], np.eye(3)[np.argmax(moments)]
    across = np.cross(short, long)
    level = Rotation.from_matrix(np.stack([long, across, short]))  # body -> orbit: long axis to the primary
    attitude = Rotation.from_rotvec([0.0, -tilt, turn]) * level
    state = system.state((2.0, 0, 0), (0, 1.3, 0), [(1, 0, 0, 0), attitude], omega_body=[(0, 0, 0), (0, 0, 0)])
    content = content_of(pt.propagate(system, state, [0.0, 1e-9]))
    packed = content["arrays"]["libration"]
    values = np.frombuffer(base64.b64decode(packed["data"]), "<f4").reshape(-1, 2)[0] * packed["scale"]
    longitude = np.pi / 2 - np.mod(np.pi / 2 + turn, np.pi)  # of the line, seen from the body
    np.testing.assert_allclose(values, (longitude, tilt), rtol=0, atol=1e-6)
    assert content["plotted"] == ["distance", "libration"]


def test_motion_at_one_time_is_refused():
    with pytest.raises(ValueError, match="at two times or more, got 1"):
        others_of(motion((0, 0, 1)), motion((0, 0, 1), (1.0,)))
