"""Other motions on a page."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.plot.page_content import MAX_GHOSTS, others_of

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
    assert (rates[0], rates[-1]) == pytest.approx((1.0, 2.0), rel=1e-14)
    assert np.all(np.diff(rates) > 0)


def test_motion_at_one_time_is_refused():
    with pytest.raises(ValueError, match="at two times or more, got 1"):
        others_of(motion((0, 0, 1)), motion((0, 0, 1), (1.0,)))
