"""Error report, summary and sketches of motions."""

import numpy as np
import pytest

from poinsot.display.motion import (
    MotionDescription,
    error_report,
    exceptions,
    motion_summary,
    shown_members,
    sketch_of_members,
    sketch_of_motion,
)

TIMES = np.linspace(0.0, 10.0, 11)
RECORD: dict[str, str | float] = {
    **{"method": "Taylor", "formulation": "canonical", "precision": "double", "tolerance": 2.2e-16, "order": 20},
    **{"steps": 7, "wall_time": np.nan, "kernel": "looped", "lanes": 8, "norm_error": 3e-16, "tangency_error": 1e-16},
}


def described(record=RECORD, **changes):
    given = {"members": 0, "failed": 0, "store": "", "dense": (), "events": [], "ends": [], **changes}
    return MotionDescription("System(Body())", "s", TIMES, record, **given)


def test_a_report_has_the_largest_magnitude_of_each_error():
    errors = {"norm_error": np.array([[0.0, -3e-16], [1e-16, np.nan]]), "drift_energy": np.array([2e-15, -1e-15])}
    assert error_report(errors, True) == {"norm_error": 3e-16, "drift_energy": 2e-15}
    assert error_report({"norm_error": np.zeros(0)}, False) == {
        "norm_error": 0.0,
        "integrals": "none: this system conserves neither energy nor a momentum",
    }


def test_exceptions_count_times_and_name_the_error():
    flags = {"tide": np.array([True, False, True]), "wheel": np.array([False, False, True])}
    assert exceptions(flags, {"tide": np.array([0.1, np.nan, 0.25])}) == {
        "tide": "2 of 3 times, error about 25%",
        "wheel": "1 of 3 times",
    }


def test_the_lines_of_a_summary():
    title, lines = motion_summary(
        described({**RECORD, "drift_energy": 1.26e-15, "tide": "2 of 3 times"}, dense=(0.0, 10.0))
    )
    assert title == "Trajectory of System(Body())"
    assert {name: text for name, text in lines.items() if text} == {
        "times": "11, 0 ... 10 s",
        "method": "Taylor, order 20, 7 steps, tolerance 2.2e-16",
        "kernel": "looped, 8 lanes",
        "variables": "canonical, double precision",
        "dense output": "[0, 10] s",
        "norm error": "3e-16",
        "tangency error (relative)": "1e-16",
        "drift": "energy 1.3e-15",
        "tide": "2 of 3 times",
    }


@pytest.mark.parametrize(
    ("changes", "name", "text"),
    [
        ({"members": 3, "failed": 1}, "members", "3, 1 failed"),
        ({"store": "it.zarr"}, "store", "it.zarr"),
        ({"dense": (-np.inf, np.inf)}, "dense output", "any time"),
        ({"events": [("Impact", 2), ("SpinFlip", 0)]}, "events", "Impact 2, SpinFlip 0"),
        ({"ends": [("Impact", 1, 2.5)]}, "ended", "at t = 2.5, by Impact"),
        ({"members": 3, "ends": [("Impact", 2, 2.5)]}, "ended", "2 members, by Impact"),
    ],
)
def test_lines_that_some_motions_have(changes, name, text):
    assert motion_summary(described())[1][name] == ""
    assert motion_summary(described(**changes))[1][name] == text


def test_sketches():
    plots = sketch_of_motion(TIMES, {"q0": np.cos(TIMES)}, {"norm error": 1e-16 * TIMES}, "s")
    assert plots.count("<svg") == 2
    assert "norm error" in plots
    drawn = sketch_of_members("rate", TIMES, {0: np.sin(TIMES), 4: np.cos(TIMES)}, "s")
    assert drawn.count("<polyline") == 2
    assert "member 4" in drawn


@pytest.mark.parametrize(("count", "shown"), [(1, [0]), (3, [0, 1, 2]), (101, [0, 25, 50, 75, 100])])
def test_at_most_five_members_are_shown(count, shown):
    assert shown_members(count) == shown
