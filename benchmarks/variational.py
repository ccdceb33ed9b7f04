"""Variational equations compared with an older version: state transition of one motion, and maps of chaos (MEGNO).

The sections run with the package of this commit and with that of `BEFORE`, each in processes of its own.
"""

import statistics
import time
from dataclasses import replace

import numpy as np

import poinsot as pt
from benchmarks import problems
from benchmarks.measure import ALLOWED, Contender, computed_by, interleaved, pin
from benchmarks.peers import heyoka_by_hand
from benchmarks.problems import P2, P3, PERIOD

BEFORE = "7c0bc1e"
"""The last commit whose only kernels are the engine's."""

TRANSITIONS = (replace(P2, end=100.0), replace(P3, end=10 * PERIOD))
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
MOON = pt.Body.from_ratios(beta=0.47, gamma=0.26)
SYSTEM = pt.System(MOON, pt.GravityGradient(ORBIT))
ORBITS, TOLERANCE, TILT = 100, 1e-9, 0.1
"""The tilt of the spin axis from the normal of the orbit, in space."""


def state_transition(short, process=0):
    """Return the times of a motion with its state-transition matrix, of poinsot and of the engine by hand."""
    out = {}
    for problem in TRANSITIONS:
        contenders = {
            name: Contender(lambda run=run: run, lambda q, problem=problem: problems.error(problem, q))
            for name, run in (("poinsot", _transition_of(problem)), ("by_hand", _by_hand(problem)))
        }
        out[problem.key] = interleaved(contenders, repeats=5 if short else 15, budget=2.0)
    return out


def _transition_of(problem):
    def run():
        found = pt.analysis.state_transition(problem.system, problem.start, [0.0, problem.end])
        return found.motion.quaternion[-1]

    return run


def _by_hand(problem):
    run = heyoka_by_hand.prepare_variational(problem)
    return lambda: run()[0]


def transitions_of_versions(results):
    """Return the medians over processes of each version."""
    return {
        problem.key: {
            (version if name == "poinsot" else "by_hand"): {
                key: statistics.median([one[problem.key][name][key] for one in results[version]])
                for key in ("seconds", "error")
            }
            for version in results
            for name in ("by_hand", "poinsot")
        }
        for problem in TRANSITIONS
    }


def maps_of_versions(results):
    """Return the maps of this version, with the seconds of the other one."""
    out = results["now"][0]
    for name, found in out["maps"].items():
        before = results.get("before")
        found["before"] = before[0]["maps"][name]["seconds"] if before else None
    return out


def chaos_maps(short, process=0):
    """Return members, seconds and steps of each map, and how far its MEGNO is from one of ten times the samples."""
    pin(2)
    side = 24 if short else 200
    return {
        "orbits": ORBITS,
        "tolerance": TOLERANCE,
        "cores": min(2, len(ALLOWED) or 2),
        "maps": {
            "planar": _map(side, 0.0, "planar"),
            "three-dimensional": _map(side, TILT, None),
        },
    }


def _map(side, tilt, formulation):
    options = {"formulation": formulation, "tolerance": TOLERANCE, "threads": 2, "progress": False}
    pt.analysis.chaos_indicators(SYSTEM, _starts(4, tilt), [1.0], **options)  # compiles
    start, times = _starts(side, tilt), [ORBITS * ORBIT.period]
    began, used = time.perf_counter(), time.process_time()
    found = pt.analysis.chaos_indicators(SYSTEM, start, times, **options)
    took, used = time.perf_counter() - began, time.process_time() - used
    last = found.mean_megno[:, -1]
    return {
        "computed_by": computed_by(found.run),
        "members": last.size,
        "seconds": took,
        "busy": used / took,
        "steps": found.run.steps / last.size,
        "chaotic": float(np.mean(last > 4)),
        "error": _error_of_megno(tilt, options),
    }


def _error_of_megno(tilt, options):
    """Return the largest relative error of the mean MEGNO of some members, against samples ten times as dense."""
    start, period = _starts(8, tilt), ORBIT.period
    dense = np.linspace(0, 20 * period, 20 * 8 * 10 + 1)[1:]
    coarse, fine = (
        pt.analysis.chaos_indicators(SYSTEM, start, t, **options).mean_megno[:, -1] for t in (dense[-1:], dense)
    )
    return float(np.max(np.abs(coarse - fine) / np.maximum(2, np.abs(fine))))


def _starts(side, tilt):
    """States on a grid of the angle of the long axis from the periapsis and of the rate about the third axis."""
    angles, rates = np.meshgrid(np.linspace(0, np.pi, side, endpoint=False), np.linspace(0.05, 3, side))
    c, s, rate = np.cos(angles.ravel() / 2), np.sin(angles.ravel() / 2), rates.ravel()
    ct, st = np.cos(tilt / 2), np.sin(tilt / 2)
    return MOON.state(np.stack([c * ct, c * st, s * st, s * ct], axis=-1), omega_body=rate[:, None] * (0, 0, 1.0))
