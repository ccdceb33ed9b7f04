"""Quadruple precision next to heyoka's `real128` on equations written by hand, and the time of Euler angles."""

import statistics
import time
from types import SimpleNamespace

import heyoka as hy
import mpmath
import numpy as np

import poinsot as pt
from benchmarks.measure import pin
from benchmarks.peers import heyoka_by_hand
from benchmarks.problems import NAMED
from benchmarks.wide_states import end_of

ENDS = {"P1": (20.0, 200.0), "P2": (20.0, 200.0)}
EULER = ("P1", "P2", "P3")


def quadruple(short):
    """Return seconds of both integrators, and the largest differences of their variables, by problem and end."""
    pin(1)
    return {f"{key}, t = {end:g}": _both(NAMED[key], end, 3 if short else 15) for key in ENDS for end in ENDS[key]}


def _both(problem, end, repeats):
    wide = hy.real128
    writing = heyoka_by_hand.WRITINGS[problem.kind]["omega/2"]
    numbers = SimpleNamespace(moments=tuple(map(wide, problem.moments)))
    if problem.kind == "top":
        numbers.weight = wide(problem.weight)
    momenta = zip(problem.start.angular_momentum_body.tolist(), problem.moments, strict=True)
    rates = [wide(g) / wide(moment) * wide(writing.share) for g, moment in momenta]
    q = [*map(wide, problem.start.quaternion.tolist())]
    start = [*(x / np.sqrt(sum(x * x for x in q)) for x in q), *rates]
    engine = hy.taylor_adaptive(writing.system(numbers), start, fp_type=wide, compact_mode=True)
    ours, theirs = [], []
    for _ in range(repeats):
        motion = pt.propagate(problem.system, problem.start, [0.0, end], precision="quadruple")
        ours.append(motion.run.wall_time)
        engine.time = wide(0.0)
        engine.state[:] = start
        began = time.perf_counter()
        engine.propagate_until(wide(end))
        theirs.append(time.perf_counter() - began)
    return {
        "poinsot": statistics.median(ours),
        "heyoka": statistics.median(theirs),
        "ratio": statistics.median(b / a for a, b in zip(ours, theirs, strict=True)),
        **_differences(problem, engine.state, writing, end),
    }


def _differences(problem, state, writing, end):
    """Return the largest differences of the quaternion, and of the angular momentum over its size."""
    with mpmath.workdps(40):
        found, theirs = end_of(problem.system, problem.start, end), [mpmath.mpf(str(x)) for x in state]
        momenta = zip(theirs[4:], problem.moments, strict=True)
        g = [mpmath.mpf(moment) * rate / mpmath.mpf(writing.share) for rate, moment in momenta]
        turned, slowed = (
            [abs(a - b) for a, b in zip(*each, strict=True)] for each in ((found[:4], theirs[:4]), (found[4:], g))
        )
        return {"attitude": float(max(turned)), "momentum": float(max(slowed) / mpmath.norm(g))}


def euler_angles(short):
    """Return seconds of motions in Euler angles and in the default variables, medians of alternating runs."""
    pin(1)
    found = {}
    for key in EULER:
        problem, times = NAMED[key], {"lie_poisson": [], "euler_angles": []}
        end = 0.1 * problem.end
        for _ in range(3 if short else 15):
            for name, spent in times.items():
                motion = pt.propagate(problem.system, problem.start, np.linspace(0.0, end, 101), formulation=name)
                spent.append(motion.run.wall_time)
        found[key] = {name: statistics.median(spent) for name, spent in times.items()}
    return found
