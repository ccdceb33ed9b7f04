"""`free_motion` against 40-digit integrations of Euler's equations, and against other people's numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from oracles.free_rotation import attitude_error, load_cases, momentum_error

EPS = float(np.finfo(float).eps)
ROUNDING = 12 * EPS
"""Of a unit quaternion and a rotated vector, with a start that is itself rounded."""

CASES = load_cases()
NAMES = [f"{case.group}-{case.name}-{i}" for i, case in enumerate(CASES)]


def errors(case):
    motion = pt.free_motion(pt.Body(case.moments), pt.State(case.q, case.Q), [case.t])
    return (
        attitude_error(motion.quaternion[0], case.q_t),
        momentum_error(motion.angular_momentum_body[0], case.g_t),
    )


def rounding(case):
    """Units of rounding, and as many as the phase has from the unstable axis on: the logarithm of the distance."""
    return ROUNDING - EPS / 2 * np.log(max(abs(case.delta), 1e-32))


@pytest.mark.samples
@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_every_case_to_rounding_at_any_time(case):
    # Phases up to 1e9 radians: the error does not grow with time, nor with what rounding of the input would do.
    attitude, momentum = errors(case)
    assert attitude < rounding(case)
    assert momentum < rounding(case)


def test_median_error_of_random_cases_is_a_unit_in_the_last_place():
    ratios = [errors(case)[0] / (EPS * (1 + abs(case.phase))) for case in CASES if case.group == "random"]
    assert np.median(ratios) < 0.5
    assert np.max(ratios) < 5


PAPER = json.loads((Path(__file__).parent / "paper_cases.json").read_text())["cases"]
STARTS = {
    "printed_qQ_exact_sqrt2": pt.State((0.5, -1 / 2**0.5, 0, 0.5), (0.3, -0.6 * 2**0.5, 0.1 * 2**0.5, -1.5)),
    "euler_pP": pt.State.from_euler((np.pi / 4, 3 * np.pi / 2, np.pi / 4), (0.5, 0.6, 0.4)),
}


@pytest.mark.parametrize("start", STARTS)
def test_torque_free_case_of_the_paper(start):
    rows = PAPER[f"free|{start}"]
    motion = pt.free_motion(pt.Body((1.25, 1.0, 0.75)), STARTS[start], [float(row["t"]) for row in rows])
    for q, Q, row in zip(motion.quaternion, motion.conjugate_momenta, rows, strict=True):
        # The reference starts from exact roots and angles, this motion from their doubles.
        input_rounding = 4 * EPS * (1 + abs(float(row["t"])))
        assert attitude_error(q, row["q"]) < ROUNDING + input_rounding
        sign = np.sign(q @ np.array(row["q"], dtype=float))
        assert np.max(np.abs(sign * Q - np.array(row["Q"], dtype=float))) < 2 * (ROUNDING + input_rounding)


@pytest.mark.parametrize("size", [1e-290, 1e-160, 1e150, 1e250])
def test_any_unit_of_mass(size):
    moments, momentum = np.array([2, 2.5, 3.5]), np.array([0.3, 1, 2])
    bodies = pt.Body(moments), pt.Body(moments * size)
    starts = [
        body.state((1, 0, 0, 0), angular_momentum_body=momentum * k) for body, k in zip(bodies, (1, size), strict=True)
    ]
    motions = [pt.free_motion(body, start, [1.0, 1e3]) for body, start in zip(bodies, starts, strict=True)]
    # The moments round differently: their ratios are off by a unit in the last place, and so is the rate.
    assert np.max(np.abs(motions[0].quaternion - motions[1].quaternion)) < 1e3 * 4 * EPS
    rotations = [pt.analysis.FreeRotation(body, start) for body, start in zip(bodies, starts, strict=True)]
    for name in ("precession_period", "rotation_period", "spin_period", "energy_ratio"):
        assert abs(getattr(rotations[1], name) / getattr(rotations[0], name) - 1) < 8 * EPS
    for name in ("energy", "angular_momentum", "dynamic_moment"):
        assert abs(getattr(rotations[1], name) / getattr(rotations[0], name) / size - 1) < 8 * EPS


@pytest.mark.parametrize("size", [1e-290, 1e290])
def test_any_unit_of_time(size):
    body = pt.Body((2, 2.5, 3.5))
    quick = body.state((1, 0, 0, 0), angular_momentum_body=np.array([0.3, 1, 2]))
    other = body.state((1, 0, 0, 0), angular_momentum_body=np.array([0.3, 1, 2]) / size)
    times = np.array([0, 1.0, 100.0])
    motions = pt.free_motion(body, quick, times), pt.free_motion(body, other, times * size)
    assert np.max(np.abs(motions[0].quaternion - motions[1].quaternion)) < 1e2 * 8 * EPS


def test_an_energy_that_overflows_is_infinite_without_a_word():
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.free_motion(body, body.state((1, 0, 0, 0), omega_body=(1e199, 1e200, 2e199)), [0.0, 1e-200])
    assert np.all(np.isinf(motion.energy))
    assert np.isinf(motion.system.energy(motion.initial))
    assert np.all(np.isfinite(motion.omega_body))
    assert np.all(np.isnan(motion.drift["energy"]))
    assert repr(motion)
