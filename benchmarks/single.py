"""One body: work and precision of every tool, the script written by hand, the formulations, the singular angle."""

import functools

import numpy as np

import poinsot as pt
from benchmarks import peers, problems
from benchmarks.measure import Contender, interleaved
from benchmarks.peers import heyoka_by_hand
from benchmarks.problems import P2, P3, PERIOD, PROBLEMS, Problem
from poinsot.engine.formulations import FORMULATIONS
from poinsot.mechanics.attitude import rotation_angle

POINSOT, BY_HAND = "poinsot_taylor", "heyoka_by_hand"
STARTS_IN_A_PROCESS = 3


def _solve(problem, peer, level, **options):
    return Contender(
        prepare=functools.partial(peer.prepare, problem, level, **options),
        judge=lambda result: problems.error(problem, *result),
    )


def work_precision(short):
    """Return for each problem and tool the time and error at every level, and how sure the reference is."""
    found, missing = peers.available()
    out = {"missing": missing, "titles": peers.TITLES, "problems": {}}
    for problem in PROBLEMS:
        levels = {
            (name, str(level)): _solve(problem, peer, level)
            for name, peer in found.items()
            if problem.kind in peer.SOLVES
            for level in (peer.SHORT_LEVELS if short else peer.LEVELS)
        }
        outcomes = interleaved(levels, repeats=3 if short else 15, budget=0.05 if short else 1.0)
        curves = {}
        for (name, level), outcome in outcomes.items():
            curves.setdefault(name, []).append({"level": level, **outcome})
        away, when = problems.distance_to_paper_cases(problem)
        _, between = problems.reference(problem.system, problem.start, problem.end)
        out["problems"][problem.key] = {
            "title": problem.title,
            "curves": curves,
            "between_references": between,
            "away_from_paper_cases": away,
            "paper_cases_until": when,
        }
    return out


def against_the_script(short, process=0):
    """Return the times and errors of poinsot and of the script, at machine tolerance, on starts of this process.

    One error at the end is a draw from rounding; its median over starts is not. The time of a compiled kernel
    differs more between processes than between repeats, hence several of them.
    """
    found, _ = peers.available((POINSOT, BY_HAND))
    out = {}
    for problem in (P2, P3):
        nearby = [_near(problem, STARTS_IN_A_PROCESS * process + k) for k in range(STARTS_IN_A_PROCESS)]
        contenders = {
            (name, k): _solve(start, found[name], None) for k, start in enumerate(nearby) for name in (POINSOT, BY_HAND)
        }
        outcomes = interleaved(contenders, repeats=7 if short else 15, budget=1.0)
        out[problem.key] = {
            name: {
                quantity: [outcome[quantity] for (who, _), outcome in outcomes.items() if who == name]
                for quantity in ("seconds", "error")
            }
            for name in (POINSOT, BY_HAND)
        }
    return out


def over_processes(results):
    """Return the medians of what several processes found beside the script, and the range of the ratios."""
    out = {}
    for problem in (P2, P3):
        seconds, errors = (
            {name: [one[problem.key][name][quantity] for one in results] for name in (POINSOT, BY_HAND)}
            for quantity in ("seconds", "error")
        )
        ratios = np.median(seconds[POINSOT], axis=1) / np.median(seconds[BY_HAND], axis=1)
        out[problem.key] = {
            "processes": len(results),
            "starts": np.size(errors[POINSOT]),
            "ratio": float(np.median(ratios)),
            "ratios": [float(ratios.min()), float(ratios.max())],
            **{
                name: {
                    "seconds": float(np.median(seconds[name])),
                    "error": float(np.median(errors[name])),
                    "largest_error": float(np.max(errors[name])),
                }
                for name in (POINSOT, BY_HAND)
            },
        }
    return out


def _near(problem, seed):
    vector = 1e-3 * np.random.default_rng(seed).normal(size=3) if seed else np.zeros(3)
    turn = np.array([1.0, *(vector / 2)])
    start = problems.turned(problem.start, turn / np.linalg.norm(turn))
    return Problem(problem.key, problem.title, problem.kind, problem.case, problem.system, problem.end, start)


def long_runs(short):
    """Return times alone of P3 over 50 periods, where the error tells nothing, and how fast a change grows."""
    found, _ = peers.available((POINSOT, BY_HAND))
    longer = Problem(P3.key, P3.title, P3.kind, P3.case, P3.system, 50 * PERIOD)
    contenders = {}
    for name in (POINSOT, BY_HAND):
        contenders[name] = _solve(longer, found[name], None)
        contenders[name].judge, contenders[name].limit = (lambda _: 0.0), 1.0
    outcomes = interleaved(contenders, repeats=3 if short else 15, budget=1.0)
    change, growth = 1e-13, {}
    starts = [problems.turned(P3.start, np.array([1.0, *(change / 2 * axis)])) for axis in np.eye(3)]
    for periods in (10, 20, 50):
        end = periods * PERIOD
        printed, *moved = (problems.reference(P3.system, start, end)[0] for start in (P3.start, *starts))
        growth[str(periods)] = max(float(rotation_angle(printed, q)) for q in moved) / change
    return {"times": outcomes, "change": change, "growth": growth}


def drifts(short):
    """Return the root mean squares of the largest energy drifts of a top, by formulation and by hand, in long runs."""
    times, starts = np.linspace(0.0, 2e3 if short else 2e4, 2001), range(4 if short else 12)
    found = {name: [] for name in (BY_HAND, "lie_poisson", "canonical")}
    for near in (_near(problems.HEAVIER, k) for k in starts):
        found[BY_HAND].append(heyoka_by_hand.energy_drift_of_top(problems.HEAVIER, near.initial, times))
        for name in ("lie_poisson", "canonical"):
            motion = pt.propagate(near.system, near.start, times, formulation=name)
            found[name].append(np.max(np.abs(motion.drift["energy"])))
    sizes = {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in found.items()}
    return {"end": float(times[-1]), "starts": len(starts), "drift": sizes}


def formulations(short):
    """Return steps, time and error of the three formulations on P2 and P3, at machine tolerance."""
    found, _ = peers.available((POINSOT,))
    out = {}
    for problem in (P2, P3):
        contenders = {name: _solve(problem, found[POINSOT], None, formulation=name) for name in FORMULATIONS}
        outcomes = interleaved(contenders, repeats=3 if short else 15, budget=1.0)
        for name, outcome in outcomes.items():
            if "seconds" in outcome:
                motion = pt.propagate(problem.system, problem.start, [0.0, problem.end], formulation=name)
                outcome["steps"] = motion.run.steps
        out[problem.key] = outcomes
    return out


def singular_angle(short):
    """Return steps and error of Euler angles and of the default, as the top passes the singularity at a distance.

    At t = 0 the nutation angle is at its least, the closest approach; the run goes from t = -5 to 5.
    """
    distances = (1.0, 1e-2, 1e-4) if short else (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    return [_pass_at(distance) for distance in distances]


def _pass_at(distance):
    system = P2.system
    nearest = system.body.state((np.cos(distance / 2), np.sin(distance / 2), 0, 0), angular_momentum_body=(0, 0.6, 0.5))
    begin = pt.propagate(system, nearest, [-5.0], precision=problems.WIDE)
    start = pt.State(begin.quaternion[0], begin.conjugate_momenta[0], time=-5.0)
    wide = pt.propagate(system, start, [5.0], formulation="canonical", precision=problems.WIDE)
    row = {"closest": distance}
    for name in ("euler_angles", "lie_poisson"):
        try:
            motion = pt.propagate(system, start, [5.0], formulation=name)
        except pt.PropagationError as stop:
            row[name] = {"stopped": stop.time}
        else:
            error = float(rotation_angle(wide.quaternion[-1], motion.quaternion[-1]))
            row[name] = {"steps": motion.run.steps, "error": error}
    return row
