"""Many bodies: members per second of every tool, their errors, and what a device makes of a million."""

from dataclasses import replace
from typing import Any

import numpy as np

import poinsot as pt
from benchmarks import flops, peers, problems
from benchmarks.measure import ALLOWED, Contender, computed_by, in_a_line, interleaved, pin
from benchmarks.peers import heyoka_by_hand
from benchmarks.problems import P2, P3, PERIOD
from poinsot.kinematics.attitude import rotation_angle

LIMIT = 1e-9
"""The error that every member must stay below, rad."""

LOOSER = (1e-13, 1e-12, 1e-11)
RIGHT = 1e-7
"""The error beyond which a time is not counted, rad."""

SATELLITES, TOPS = replace(P3, end=10 * PERIOD), replace(P2, end=100.0)
SPREADS = {SATELLITES.key: 1e-4, TOPS.key: 0.1}
"""Spread of the attitudes, rad; small for the satellites, so that all are about equally chaotic."""

ONE_CORE, TWO_CORES, ONE_BY_ONE = "poinsot, one core", "poinsot, two cores", "poinsot, one by one"
BATCHES = f"heyoka by hand, batches of {heyoka_by_hand.LANES}, one core"


class Members:
    """The members, their starts for the others, and their references: wide precision for the first ones."""

    def __init__(self, problem, count, sample, spread=None):
        self.problem, self.count, self.spread = problem, count, spread or SPREADS[problem.key]
        self.states = problems.ensemble(count, self.spread)
        self.starts = np.concatenate([self.states.quaternion, problem.system.omega_body(self.states)], axis=1)
        self.sample = np.array(
            [problems.reference(problem.system, problems.member(self.states, i), problem.end)[0] for i in range(sample)]
        )

    def judge(self, quaternions):
        """Return the largest error of the members that have a reference."""
        count = min(len(quaternions), len(self.sample))
        return float(np.max(rotation_angle(self.sample[:count], np.asarray(quaternions)[:count])))

    def run(self, **options):
        """Return the quaternions at the end of all members, and how they were computed."""
        motion = pt.propagate(self.problem.system, self.states, [0.0, self.problem.end], progress=False, **options)
        return motion.quaternion[:, -1], motion.run

    def poinsot(self, cores, **options):
        """Return the members as one call of `propagate`."""
        return Contender(lambda: lambda: self.run(threads=cores, **options)[0], self.judge, RIGHT, cores)

    def batches(self, tolerance):
        """Return the members as batches of the script."""
        return Contender(
            lambda: heyoka_by_hand.prepare_batches(self.problem, self.starts, tolerance), self.judge, RIGHT
        )


def satellites(short):
    """Return members per second of every tool, and the errors, over satellites."""
    many, few, sample = (1024, 128, 16) if short else (10_000, 512, 200)
    members, small = Members(SATELLITES, many, sample), Members(SATELLITES, few, min(few, sample))
    contenders = {
        f"{TWO_CORES}, tolerance {tolerance:.0e}": (members, members.poinsot(2, tolerance=tolerance))
        for tolerance in LOOSER
    }
    contenders[ONE_BY_ONE] = small, _one_by_one(small)
    soda = peers.available(("numbalsoda_dop853",))[0].get("numbalsoda_dop853")
    for tolerance in (1e-14, *LOOSER) if soda else ():
        prepare = lambda tolerance=tolerance: soda.prepare_ensemble(SATELLITES, small.starts, 2, tolerance)  # noqa: E731
        contenders[f"numbalsoda DOP853 {tolerance:.0e}, two cores"] = small, Contender(prepare, small.judge, RIGHT, 2)
    return {
        **_measured(members, contenders, short),
        "limit": LIMIT,
        "worst": [
            _worst(group, 5 if short else 30)
            for group in (
                members,
                *(Members(SATELLITES, many, 0, spread) for spread in (() if short else (1e-3, 1e-2))),
            )
        ],
    }


def tops(short):
    """Return members per second and errors over heavy tops."""
    return _measured(Members(TOPS, *((1024, 16) if short else (10_000, 200))), {}, short)


def _measured(members, more, short):
    """Return the outcomes of poinsot and the script at equal tolerance, and of more contenders with their members."""
    _, run = members.run(threads=2)
    tolerance = run.tolerance
    contenders = {
        ONE_CORE: (members, members.poinsot(1)),
        TWO_CORES: (members, members.poinsot(2)),
        BATCHES: (members, members.batches(tolerance)),
        **more,
    }
    outcomes = interleaved({name: c for name, (_, c) in contenders.items()}, repeats=3 if short else 7, budget=8.0)
    for name, (group, _) in contenders.items():
        outcomes[name]["members"] = group.count
    pin(1)
    return {
        "tools": outcomes,
        "sample": len(members.sample),
        "spread": members.spread,
        "tolerance": tolerance,
        "computed_by": computed_by(run),
        "writing": heyoka_by_hand.fastest(members.problem.key, tolerance),
        "work": flops.of_motion(members.problem, tolerance),
        "peak": flops.peak(),
    }


def _one_by_one(members):
    states = [problems.member(members.states, i) for i in range(members.count)]

    def run():
        times = [0.0, members.problem.end]
        return [pt.propagate(members.problem.system, state, times).quaternion[-1] for state in states]

    return Contender(lambda: run, members.judge, RIGHT)


def _worst(members, count):
    """Return the largest errors, of the members in which poinsot and the equations by hand differ most."""
    problem = members.problem
    theirs = heyoka_by_hand.prepare_batches(problem, members.starts, heyoka_by_hand.EPSILON)()
    pin(2)
    ours, _ = members.run(threads=2)
    apart = rotation_angle(theirs, ours)
    chosen = np.argsort(-apart)[:count]
    states = [problems.member(members.states, i) for i in chosen]
    wide, between = zip(*(problems.reference(problem.system, state, problem.end) for state in states), strict=True)
    return {
        "spread": members.spread,
        "apart": float(apart[chosen[0]]),
        "poinsot": float(np.max(rotation_angle(np.array(wide), ours[chosen]))),
        "by_hand": float(np.max(rotation_angle(np.array(wide), theirs[chosen]))),
        "references": max(between),
        "judged": count,
    }


def on_a_device(short):
    """Return members per second of satellites on a GPU and on all cores of its machine, or why there are none."""
    cores, on_device = len(ALLOWED) or 1, {"device": "cuda"}
    try:
        Members(SATELLITES, 8, 0).run(**on_device)
    except Exception as problem:
        return {"trouble": in_a_line(problem)}
    many, few = (
        Members(SATELLITES, count, 16 if short else 200) for count in ((10_000, 1024) if short else (10**6, 10**5))
    )
    contenders = {
        "one GPU": Contender(lambda: lambda: many.run(**on_device)[0], many.judge, RIGHT, cores),
        "all cores": few.poinsot(cores),
    }
    outcomes = interleaved(contenders, repeats=3, budget=60.0)
    for name, group in (("one GPU", many), ("all cores", few)):
        outcomes[name]["members"] = group.count
    return {"tools": outcomes, "cores": cores, "device": _device_name()}


def _device_name():
    import importlib

    properties: Any = importlib.import_module("cupy").cuda.runtime.getDeviceProperties(0)
    return properties["name"].decode()
