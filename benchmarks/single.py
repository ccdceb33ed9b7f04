"""One body: work and precision of every tool, the script written by hand, the formulations, the singular angle."""

import functools
from dataclasses import replace

import numpy as np

import poinsot as pt
from benchmarks import flops, peers, problems
from benchmarks.measure import Contender, computed_by, interleaved
from benchmarks.peers import heyoka_by_hand
from benchmarks.problems import P2, P3, PERIOD, PROBLEMS, REGULAR
from poinsot.kinematics.attitude import rotation_angle

POINSOT, BY_HAND = "poinsot_taylor", "heyoka_by_hand"
CHANGE = 1e-13
"""Change of the initial attitude in radians, whose growth measures how chaotic P3 is."""

DRIFTING = ("lie_poisson", "canonical")
"""The formulations whose energy drift is a target."""

FORMULATIONS = ("lie_poisson", "canonical", "euler_angles")


def _solve(problem, peer, level, **options):
    return Contender(
        prepare=functools.partial(peer.prepare, problem, level, **options),
        judge=lambda result: problems.error(problem, *result),
    )


def work_precision(short):
    """Return for each problem and tool the time and error at every level, and how sure the reference is."""
    found, missing = peers.available()
    out = {"missing": missing, "problems": {}}
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
    """Return the times of poinsot and of every writing of the script, each at its default tolerance.

    The time of a compiled kernel differs more between processes than between repeats, hence several of them.
    """
    out = {}
    for problem in (P2, P3):
        outcomes = interleaved(_compared_with_the_script(_near(problem, process)), repeats=15, budget=1.0)
        out[problem.key] = {name: outcome["seconds"] for name, outcome in outcomes.items()}
    return out


def over_processes(results):
    """Return the medians over processes, and those of the ratio to the fastest writing of the script with its range."""
    out = {}
    for key in (P2.key, P3.key):
        seconds = {name: [one[key][name] for one in results["now"]] for name in results["now"][0][key]}
        scripts = [times for name, times in seconds.items() if name != POINSOT]
        ratios = np.array(seconds[POINSOT]) / np.min(scripts, axis=0)
        out[key] = {
            "processes": len(ratios),
            "ratio": float(np.median(ratios)),
            "ratios": [float(ratios.min()), float(ratios.max())],
            "seconds": {name: float(np.median(times)) for name, times in seconds.items()},
        }
    return out


def errors_of_the_script(short):
    """Return the errors of poinsot and of every writing of the script on many starts, and how fast a change grows.

    One error at the end is a draw from rounding; the median over starts of its ratio to that of the script is not. The
    writings are equally good here: the error of the script at a start is the median of theirs.
    """
    out = {}
    for problem in (P2, P3):
        starts = [_near(problem, k) for k in range(5 if short else 41)]
        errors = [
            {name: c.judge(c.prepare()()) for name, c in _compared_with_the_script(one).items()} for one in starts
        ]
        scripts = [[value for name, value in one.items() if name != POINSOT] for one in errors]
        out[problem.key] = {
            "computed_by": computed_by(pt.propagate(problem.system, problem.start, [1.0]).run),
            "ratio": float(np.median([one[POINSOT] for one in errors] / np.median(scripts, axis=1))),
            "errors": {
                name: {
                    "median": float(np.median([one[name] for one in errors])),
                    "largest": float(max(one[name] for one in errors)),
                }
                for name in errors[0]
            },
        }
    return {"starts": len(starts), "problems": out, "change": CHANGE, "growth": _growth()}


def _compared_with_the_script(problem):
    """Return the contenders at default tolerances: poinsot, and the script by its writings."""
    found, _ = peers.available((POINSOT,))
    return {
        POINSOT: _solve(problem, found[POINSOT], None),
        **{name: _solve(problem, heyoka_by_hand, None, name=name) for name in heyoka_by_hand.WRITINGS[problem.kind]},
    }


def _growth():
    """Return by how much a small change of the attitude grows in P3, by the number of periods."""
    starts = [problems.turned(P3.start, np.array([1.0, *(CHANGE / 2 * axis)])) for axis in np.eye(3)]
    growth = {}
    for periods in (10, 20, 50):
        end = periods * PERIOD
        printed, *moved = (problems.reference(P3.system, start, end)[0] for start in (P3.start, *starts))
        growth[str(periods)] = max(float(rotation_angle(printed, q)) for q in moved) / CHANGE
    return growth


def _near(problem, seed):
    """Return the problem with a start within about 1e-3 rad of its own, which is the one of seed 0."""
    vector = 1e-3 * np.random.default_rng(seed).normal(size=3) if seed else np.zeros(3)
    turn = np.array([1.0, *(vector / 2)])
    return replace(problem, start=problems.turned(problem.start, turn / np.linalg.norm(turn)))


def long_run(short):
    """Return the times of a regular motion over many revolutions, how far two tools are apart, and rates.

    There is no reference so far away: every result is compared with the first one.
    """
    revolutions = 1000 if short else 100_000
    problem = replace(REGULAR, end=revolutions * PERIOD)
    found, _ = peers.available((POINSOT, BY_HAND))
    ends = []

    def judge(result):
        ends.append(result[0])
        return float(rotation_angle(ends[0], result[0]))

    contenders = {name: Contender(lambda peer=peer: peer.prepare(problem, None), judge) for name, peer in found.items()}
    run = pt.propagate(problem.system, problem.start, [PERIOD]).run
    return {
        "revolutions": revolutions,
        "tools": interleaved(contenders, repeats=5 if short else 2, budget=60.0),
        "work": flops.of_motion(problem, run.tolerance),
        "computed_by": computed_by(run),
        "peak": flops.peak(),
    }


def drifts(short):
    """Return the root mean squares of the largest energy drifts of two tops over starts, in long runs."""
    times, starts = np.linspace(0.0, 2e3 if short else 2e4, 2001), range(4 if short else 12)
    writings = heyoka_by_hand.WRITINGS["top"]
    out = {}
    for problem in (P2, problems.HEAVIER):
        found = {name: [] for name in (*DRIFTING, *writings)}
        for near in (_near(problem, k) for k in starts):
            for name in writings:
                found[name].append(heyoka_by_hand.energy_drift_of_top(near, times, name))
            for name in DRIFTING:
                motion = pt.propagate(near.system, near.start, times, formulation=name)
                found[name].append(np.max(np.abs(motion.drift["energy"])))
        out[problem.key] = {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in found.items()}
    return {"end": float(times[-1]), "starts": len(starts), "drift": out}


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
    nearest = system.of_bodies[""].state(
        (np.cos(distance / 2), np.sin(distance / 2), 0, 0), angular_momentum_body=(0, 0.6, 0.5)
    )
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
