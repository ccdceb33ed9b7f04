"""Torque-free motion in closed form: its times next to integration, and its errors against 30 digits."""

import importlib
import sys

import numpy as np

import poinsot as pt
from benchmarks import problems
from benchmarks.ensembles import RIGHT
from benchmarks.measure import Contender, interleaved
from benchmarks.problems import P1, WIDE
from poinsot.kinematics.attitude import rotation_angle
from poinsot.propagation.free_motion.elements import elements_of
from poinsot.propagation.free_motion.theta import is_near_separatrix

BODY = P1.system.body
EPOCHS = 1_000_000
CHECKED = np.linspace(0, EPOCHS - 1, 101).astype(int)
SINGLE_TIMES = (1.0, 10.0, 100.0, 300.0, 1e3, 3e3, 1e4)
BODIES = 100_000
BODIES_TIME = 100.0
CLOSE = 1e-3
"""The distance |delta| below which a stored case counts as near the separatrix."""

PAPER_TIMES = (1e3, 2e4, 5e4, 1e9)
INTEGRATED_UNTIL = 1e5


def closed_form(short):
    """Return the times of a million epochs of one body, of one epoch, and of many bodies at one epoch each."""
    return {"million": _million(short), "single": _single(short), "bodies": _bodies(short)}


def _million(short):
    times = np.linspace(0.0, P1.end, EPOCHS)
    wide, other = (
        pt.propagate(P1.system, P1.start, times[CHECKED], formulation=name, precision=WIDE).quaternion
        for name in ("canonical", "lie_poisson")
    )

    def in_closed_form():
        return pt.free_motion(BODY, P1.start, times).quaternion

    def integrated():
        return pt.propagate(P1.system, P1.start, [0.0, P1.end], dense=True)(times).quaternion

    def judge(q):
        return float(np.max(rotation_angle(wide, q[CHECKED])))

    runs = {"free_motion": in_closed_form, "propagate": integrated}
    contenders = {name: Contender(lambda run=run: run, judge) for name, run in runs.items()}
    return {
        "epochs": EPOCHS,
        "until": P1.end,
        "checked": len(CHECKED),
        "references": float(np.max(rotation_angle(wide, other))),
        **interleaved(contenders, repeats=3 if short else 15, budget=8.0),
    }


def _single(short):
    """Return for every time what closed form and integration to it take, and where the second is the slower one."""
    motion = pt.free_motion(BODY, P1.start, [0.0])
    contenders = {}
    for t in SINGLE_TIMES:
        contenders["free_motion", t] = _to(t, lambda t=t: pt.free_motion(BODY, P1.start, [t]).quaternion[0])
        contenders["propagate", t] = _to(t, lambda t=t: pt.propagate(P1.system, P1.start, [t]).quaternion[0])
        contenders["read", t] = _to(t, lambda t=t: motion(t).quaternion)
    found = interleaved(contenders, repeats=10 if short else 200, budget=1.0)
    rows = [{"t": t, **{name: found[name, t] for name in ("free_motion", "propagate", "read")}} for t in SINGLE_TIMES]
    return {"rows": rows, "equal": _equal(rows), "rate": float(np.linalg.norm(P1.initial[4:]))}


def _to(t, run):
    return Contender(lambda: run, lambda q: problems.error(P1, q, t))


def _equal(rows):
    """Return the time from which on integration takes longer, between the rows linearly; None if there is none."""
    counted = [row for row in rows if all("seconds" in row[name] for name in ("free_motion", "propagate"))]
    excess = [row["propagate"]["seconds"] - row["free_motion"]["seconds"] for row in counted]
    slower = [i for i, more in enumerate(excess) if more <= 0]
    if not slower:
        return counted[0]["t"] if counted else None
    i = slower[-1]
    if i + 1 == len(counted):
        return None
    return float(np.interp(0.0, excess[i : i + 2], [row["t"] for row in counted[i : i + 2]]))


def _bodies(short):
    bodies, states = _random_bodies(BODIES)
    distances = _distances(bodies.moments, states.angular_momentum_body)
    sample = 16 if short else 200
    chosen = np.unique([*range(sample // 2), *np.argsort(np.abs(distances))[: sample // 2]])
    wide, between = zip(*(_reference(bodies, states, i) for i in chosen), strict=True)

    def run():
        return pt.free_motion(bodies, states, [BODIES_TIME]).quaternion[:, 0]

    def judge(q):
        return float(np.max(rotation_angle(np.array(wide), q[chosen])))

    contender = Contender(lambda: run, judge, RIGHT)
    return {
        "bodies": BODIES,
        "until": BODIES_TIME,
        "near": int(np.sum(is_near_separatrix(elements_of(bodies.moments, bodies.principal_matrix, states)))),
        "closest": float(np.min(np.abs(distances))),
        "judged": len(chosen),
        "references": max(between),
        **interleaved({"all": contender}, repeats=1 if short else 7, budget=8.0)["all"],
    }


def _random_bodies(count, seed=1):
    """Return triaxial bodies of random mass distributions in random states."""
    rng = np.random.default_rng(seed)
    a, b, c = np.exp(rng.uniform(-1.5, 1.5, (3, count)))
    bodies = pt.Body(np.stack([b + c, a + c, a + b], axis=-1))
    q, g = rng.normal(size=(count, 4)), rng.normal(size=(count, 3))
    return bodies, bodies.state(q / np.linalg.norm(q, axis=-1, keepdims=True), angular_momentum_body=g)


def _distances(moments, g):
    """Return (G^2 - 2 T I2) / G^2, zero on the separatrix."""
    middle = np.median(moments, axis=-1, keepdims=True)
    return np.sum(g**2 * (1 - middle / moments), axis=-1) / np.sum(g**2, axis=-1)


def _reference(bodies, states, i):
    system = pt.System(pt.Body(bodies.moments[i]))
    return problems.reference(system, problems.member(states, i), BODIES_TIME)


def closed_form_accuracy(short):
    """Return the errors relative to the stored references, or why there are none."""
    try:
        oracle = _oracle()
    except ModuleNotFoundError as problem:
        return {"trouble": f"{problem.name} is not installed"}
    return {"paper": _paper_case(oracle), "random": _random(oracle), "separatrix": _separatrix(oracle)}


def _oracle():
    """Return the module that reads and compares the references; it lies with the tests."""
    sys.path.append(str(problems.PAPER_CASES.parent))
    return importlib.import_module("free_rotation")


def _closed(case):
    return pt.free_motion(pt.Body(case.moments), pt.State(case.q, case.Q), [case.t]).quaternion[0]


def _integrated(case):
    return pt.propagate(pt.System(pt.Body(case.moments)), pt.State(case.q, case.Q), [case.t]).quaternion[0]


def _paper_case(oracle):
    cases = {case.t: case for case in oracle.load_cases("named") if case.name == "paper"}
    return [
        {
            "t": t,
            "free_motion": oracle.attitude_error(_closed(cases[t]), cases[t].q_t),
            "propagate": oracle.attitude_error(_integrated(cases[t]), cases[t].q_t) if t < INTEGRATED_UNTIL else None,
            "input_rounding": cases[t].input_rounding,
        }
        for t in PAPER_TIMES
        if t in cases
    ]


def _random(oracle):
    """Return errors over eps (1 + phase)."""
    eps = np.finfo(float).eps
    return _over(oracle, oracle.load_cases("random"), lambda case: eps * (1 + case.phase))


def _separatrix(oracle):
    """Return errors over what half a unit in the last place of Q makes of the attitude."""
    cases = [case for case in oracle.load_cases("separatrix") if abs(case.delta) < CLOSE]
    return _over(oracle, cases, lambda case: case.input_rounding)


def _over(oracle, cases, unit):
    if not cases:
        return None
    errors = np.array([oracle.attitude_error(_closed(case), case.q_t) for case in cases])
    ratios = errors / [unit(case) for case in cases]
    return {
        "cases": len(cases),
        "error": float(np.max(errors)),
        "median": float(np.median(ratios)),
        "largest": float(np.max(ratios)),
    }
