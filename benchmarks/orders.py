"""Cost and accuracy of a run by the order of the Taylor expansion: `python -m benchmarks.orders`.

Errors at the end over many starts, energy drifts of the top in long runs, and times, by tolerance.
"""

import time

import numpy as np

import poinsot as pt
from benchmarks.problems import P2, P3, PERIOD, WIDE, turned
from poinsot.kinematics.attitude import rotation_angle
from poinsot.taylor.kernels import ROUNDING

TOLERANCES = {20: ROUNDING["double"], 19: 2.32e-16, 18: 1.72e-15, 17: 1.3e-14}
STARTS, SPREAD = 64, 0.05
ENDS = ((P2, 300.0), (P3, 5 * PERIOD))


def starts(count):
    """Return the printed pair with random changes of its attitude."""
    vectors = SPREAD / 2 * np.random.default_rng(7).normal(size=(count, 3))
    turns = np.concatenate([np.ones((count, 1)), vectors], axis=1)
    return turned(P2.start, turns / np.linalg.norm(turns, axis=1, keepdims=True))


def errors():
    """Return for each problem and order the median and the largest error at the end, rad."""
    states, out = starts(STARTS), {}
    for problem, end in ENDS:
        each = [pt.State(q, Q) for q, Q in zip(states.quaternion, states.conjugate_momenta, strict=True)]
        wide = [pt.propagate(problem.system, state, [end], precision=WIDE).quaternion[-1] for state in each]
        for order, tolerance in TOLERANCES.items():
            found = [pt.propagate(problem.system, state, [end], tolerance=tolerance) for state in each]
            assert {motion.run.order for motion in found} == {order}
            off = rotation_angle(np.array(wide), np.array([motion.quaternion[-1] for motion in found]))
            out[problem.key, order] = float(np.median(off)), float(np.max(off))
    return out


def drifts():
    """Return by spin and order the rms of the largest energy drifts of the top, their mean at the end, and steps.

    The end is t = 2e4, and 4e3 where it spins ten times faster.
    """
    times, out = np.linspace(0.0, 2e4, 401), {}
    for spin in (1, 10):
        states = starts(STARTS)
        fast = pt.State(states.quaternion, spin * states.conjugate_momenta)
        for order, tolerance in TOLERANCES.items():
            motion = pt.propagate(P2.system, fast, times if spin == 1 else times / 5, tolerance=tolerance)
            drift = motion.drift["energy"]
            largest = float(np.sqrt(np.mean(np.max(np.abs(drift), axis=-1) ** 2)))
            out[spin, order] = largest, float(np.mean(drift[:, -1])), motion.run.steps // STARTS
    return out


def seconds():
    """Return for each problem and order the least processor time of a run, in turn."""
    found = {}
    for _ in range(15):
        for problem, end in ENDS:
            for order, tolerance in TOLERANCES.items():
                began = time.process_time()
                pt.propagate(problem.system, problem.start, [10 * end], tolerance=tolerance)
                found.setdefault((problem.key, order), []).append(time.process_time() - began)
    return {key: min(times[1:]) for key, times in found.items()}


def main():
    """Print all, one line each."""
    for (key, order), (median, largest) in errors().items():
        print(f"{key} order {order}: median error {median:.1e}, largest {largest:.1e} rad")
    for (spin, order), (drift, mean, steps) in drifts().items():
        print(f"top, spin times {spin}, order {order}: energy drift {drift:.1e}, mean {mean:.1e}, after {steps} steps")
    times = seconds()
    for (key, order), each in times.items():
        print(f"{key} order {order}: {times[key, 20] / each:.2f} times as fast as order 20")


if __name__ == "__main__":
    main()
