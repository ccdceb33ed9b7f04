"""Many bodies: members per second, the error of every member, and the floating-point rate of the kernel."""

import time

import numpy as np

import poinsot as pt
from benchmarks import peers, problems
from benchmarks.flops import flops_per_step, multiply_add_peak
from benchmarks.measure import Contender, interleaved, pin
from benchmarks.problems import ENSEMBLE_END, P3
from poinsot.engine import kernels
from poinsot.engine.driver import Driver, Memory
from poinsot.engine.formulations import FORMULATIONS
from poinsot.engine.problem import Problem
from poinsot.mechanics.attitude import rotation_angle
from poinsot.propagation.arguments import DEFAULT_TOLERANCES, broadcast_members

LIMIT = 1e-9
"""The error that every member must stay below, rad."""

LOOSER = (1e-13, 1e-12, 1e-11)
RIGHT = 1e-7
"""The error beyond which a time is not counted, rad."""


class Members:
    """The members, their starts for the others, and their references: wide precision for the first ones."""

    def __init__(self, count, sample, spread=problems.ENSEMBLE_SPREAD):
        self.spread, self.states = spread, problems.ensemble(count, spread)
        self.starts = np.concatenate([self.states.quaternion, P3.system.omega_body(self.states)], axis=1)
        self.sample = np.array(
            [problems.reference(P3.system, problems.member(self.states, i), ENSEMBLE_END)[0] for i in range(sample)]
        )

    def first(self, count):
        """Return the states of the first members."""
        return pt.State(self.states.quaternion[:count], self.states.conjugate_momenta[:count])

    def judge(self, quaternions):
        """Return the largest error of the members that have a reference."""
        count = min(len(quaternions), len(self.sample))
        return float(np.max(rotation_angle(self.sample[:count], np.asarray(quaternions)[:count])))


def _together(members, count, threads, tolerance=None):
    states = members.first(count)

    def run():
        times = [0.0, ENSEMBLE_END]
        motion = pt.propagate(P3.system, states, times, threads=threads, tolerance=tolerance, progress=False)
        return motion.quaternion[:, -1]

    return Contender(lambda: run, members.judge, RIGHT, cores=threads)


def _one_by_one(members, count):
    states = [problems.member(members.states, i) for i in range(count)]

    def run():
        return [pt.propagate(P3.system, state, [0.0, ENSEMBLE_END]).quaternion[-1] for state in states]

    return Contender(lambda: run, members.judge, RIGHT)


def _contenders(members, counts, found):
    many, few = counts
    out = {
        "poinsot, one core": (many, _together(members, many, 1)),
        "poinsot, two cores": (many, _together(members, many, 2)),
        **{
            f"poinsot, two cores, tolerance {tolerance:.0e}": (many, _together(members, many, 2, tolerance))
            for tolerance in LOOSER
        },
        "poinsot, one by one": (few, _one_by_one(members, few)),
    }
    by_hand, soda = found["heyoka_by_hand"], found.get("numbalsoda_dop853")

    def ensemble_of(peer, count, cores, *options):
        prepare = lambda: peer.prepare_ensemble(P3, members.starts[:count], *options)  # noqa: E731
        return count, Contender(prepare, members.judge, RIGHT, cores)

    out["heyoka's ensemble function by hand, two cores"] = ensemble_of(by_hand, many, 2)
    if soda is not None:
        for tolerance in (1e-14, *LOOSER):
            out[f"numbalsoda DOP853 {tolerance:.0e}, two cores"] = ensemble_of(soda, few, 2, 2, tolerance)
    return out


def throughput(short):
    """Return members per second of every tool, the errors, and the floating-point rate on one core."""
    found, _ = peers.available(("heyoka_by_hand", "numbalsoda_dop853"))
    counts, sample = ((1024, 128), 16) if short else ((10_000, 512), 200)
    members = Members(counts[0], sample)
    entered = _contenders(members, counts, found)
    contenders = {name: contender for name, (_, contender) in entered.items()}
    outcomes = interleaved(contenders, repeats=3 if short else 7, budget=8.0)
    for name, (count, _) in entered.items():
        outcomes[name]["members"] = count
    outcomes["poinsot, one by one"]["kernel_seconds"] = _kernel_seconds(members, 32)
    return {
        "tools": outcomes,
        "sample": sample,
        "worst": [
            _worst(group, found["heyoka_by_hand"], 5 if short else 30)
            for group in (members, *(Members(counts[0], 0, spread) for spread in (() if short else (1e-3, 1e-2))))
        ],
        "limit": LIMIT,
        "rate": _rate(members, counts[0], 3 if short else 9),
    }


def _kernel_seconds(members, count):
    """Return the median time of the integration alone of one member, without the call around it."""
    pin(1)
    times = [0.0, ENSEMBLE_END]
    runs = [pt.propagate(P3.system, problems.member(members.states, i), times).run for i in range(count)]
    return float(np.median([run.wall_time for run in runs]))


def _worst(members, by_hand, count):
    """Return the largest errors, of the members in which poinsot and the equations by hand differ most."""
    pin(2)
    theirs = by_hand.prepare_ensemble(P3, members.starts)()
    motion = pt.propagate(P3.system, members.states, [0.0, ENSEMBLE_END], threads=2, progress=False)
    ours = motion.quaternion[:, -1]
    apart = rotation_angle(theirs, ours)
    chosen = np.argsort(-apart)[:count]
    states = [problems.member(members.states, i) for i in chosen]
    wide, between = zip(*(problems.reference(P3.system, state, ENSEMBLE_END) for state in states), strict=True)
    return {
        "spread": members.spread,
        "apart": float(apart[chosen[0]]),
        "poinsot": float(np.max(rotation_angle(np.array(wide), ours[chosen]))),
        "by_hand": float(np.max(rotation_angle(np.array(wide), theirs[chosen]))),
        "references": max(between),
        "judged": count,
    }


def _rate(members, count, repeats):
    """Return operations per second of the ensemble on one core, of its kernel alone, and the measured peak."""
    peak = multiply_add_peak()
    if peak is None:
        return {"trouble": "no llvmlite here, with which the peak is measured"}
    pin(1)
    states, times = broadcast_members(members.first(count), (count,)), np.array([0.0, ENSEMBLE_END])
    problem = Problem(P3.system)
    variables = kernels.state_vector(problem, states, FORMULATIONS["lie_poisson"], "double")
    tolerance = DEFAULT_TOLERANCES["double"]
    with kernels.kernel_of(problem, variables, "double", tolerance, kernels.LANES) as compiled:
        work = flops_per_step(compiled.engine)
        one_batch = _batch(compiled, variables, states)
        all_members, kernel, peaks = [], [], []
        for _ in range(repeats):
            peaks.append(peak())
            began = time.perf_counter()
            done = Driver(problem, variables, tolerance).run(states, times, Memory(variables, count, times))
            all_members.append(done.steps.sum() * work["flops"] / (time.perf_counter() - began))
            kernel.append(one_batch() * work["flops"])
    order = np.argsort(-np.linalg.norm(P3.system.omega_body(states), axis=-1), kind="stable")
    in_batches = done.steps[order][: count // kernels.LANES * kernels.LANES].reshape(-1, kernels.LANES)
    return {
        "peak": float(np.median(peaks)),
        "ensemble": float(np.median(all_members)),
        "kernel": float(np.median(kernel)),
        "busy_lanes": float(in_batches.sum() / (kernels.LANES * in_batches.max(axis=1).sum())),
        "lanes": kernels.LANES,
        "steps": float(done.steps.mean()),
        **work,
    }


def _batch(compiled, variables, states):
    """Return a function that steps one batch for the whole time and returns the lanes' steps per second."""
    engine, lanes = compiled.engine, kernels.LANES
    starts = variables.from_state(states)[:lanes].T

    def run():
        engine.state[:] = starts
        engine.set_time(0.0)
        compiled.begin(True, np.arange(lanes))
        began = time.perf_counter()
        engine.propagate_until(ENSEMBLE_END)
        return sum(lane[3] for lane in engine.propagate_res) / (time.perf_counter() - began)

    return run
