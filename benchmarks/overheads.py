"""Overhead of a run in addition to the integration: the second call, and reading of dense output."""

import statistics
import time

import numpy as np

import poinsot as pt
from benchmarks.measure import pin
from benchmarks.problems import P2, P3, WIDE
from poinsot.kinematics.attitude import rotation_angle


def second_propagate(short, process=0):
    """Return the time of `propagate` beyond the integration, for new numbers every time; the first call apart.

    The first hundreds of calls take up to twice as long in some processes.
    """
    pin(1)
    out = {}
    for problem in (P2, P3):
        over, build = [], []
        for k in range(20 if short else 1000):
            began = time.perf_counter()
            body = pt.Body(np.array(problem.moments) * (1 + 1e-4 * (k + 0.1 * process)))
            system = pt.System(body, *problem.system.forces)
            called = time.perf_counter()
            motion = pt.propagate(system, problem.start, [0.0, problem.end / 20])
            over.append(time.perf_counter() - called - motion.run.wall_time)
            build.append(called - began)
        wide = pt.propagate(system, problem.start, motion.times, formulation="canonical", precision=WIDE)
        out[problem.key] = {
            "first": over[0],
            "seconds": statistics.median(over[1:]),
            "build": statistics.median(build[1:]),
            "error": float(rotation_angle(motion.quaternion[-1], wide.quaternion[-1])),
        }
    return out


def over_processes(results):
    """Return the medians over processes."""
    found = results["now"]
    return {
        key: {name: statistics.median(one[key][name] for one in found) for name in found[0][key]} for key in found[0]
    }


def dense_output(short):
    """Return the nanoseconds per time of a million times, and their distance to a run that stops there."""
    pin(1)
    out = {}
    for problem in (P2, P3):
        motion = pt.propagate(problem.system, problem.start, [0.0, problem.end], dense=True)
        times = np.linspace(0.0, problem.end, 1_000_000)
        checked = times[:: len(times) // 100]
        wide = pt.propagate(problem.system, problem.start, checked, formulation="canonical", precision=WIDE)
        taken = []
        for _ in range(2 if short else 7):
            began = time.process_time()
            states = motion(times)
            taken.append(time.process_time() - began)
        error = float(np.max(rotation_angle(states.quaternion[:: len(times) // 100], wide.quaternion)))
        out[problem.key] = {"nanoseconds": 1e9 * statistics.median(taken) / len(times), "error": error}
    return out
