"""Two bodies: thirty days of Didymos after the impact of DART, one motion and ensembles, and what a map of chaos takes.

The peer is heyoka with the equations of second degree typed out, in units of the size of the system; what GUBAS takes
is cited in the report.
"""

import time
from typing import Any

import numpy as np

import poinsot as pt
from benchmarks.measure import ALLOWED, Contender, computed_by, interleaved, pin
from benchmarks.peers import two_bodies_by_hand
from benchmarks.problems import WIDE

DAYS, DAY = 30, 86400.0
END = DAYS * DAY
SECOND, FOURTH, BY_HAND = "poinsot, second degree", "poinsot, degree 4", "heyoka by hand, second degree"
LIMIT = 1e-8
"""The error of the position, relative, beyond which a time is not counted."""


def didymos(a_to_b=1.2):
    """Return Didymos and Dimorphos, kg and m, and their state after the impact."""
    a = 75.5 * (a_to_b * 1.6) ** (1 / 3)
    shapes = (394, 394, 290), (a, a / a_to_b, a / 1.6)
    bodies = (
        pt.Body.from_shape(pt.shapes.Ellipsoid(axes, mass=mass))
        for axes, mass in zip(shapes, (5.26e11, 4.3265e9), strict=True)
    )
    pair = pt.TwoBodies(*bodies)
    start = pair.synchronous(distance=1189.0, primary_rate=2 * np.pi / (2.26 * 3600))
    return pair, pair.kick(start, (0.0, -2.63e-3, 1e-4))


def two_bodies(short):
    """Return times and errors of one motion, and the first calls; those of members, and of a map."""
    pin(1)
    pair, start = didymos()
    systems = {
        SECOND: pt.System(pair, pt.forces.MutualGravity()),
        FOURTH: pt.System(pair, pt.forces.MutualHarmonics.of_shapes(pair, degree=4)),
    }
    first, energy, tools = {}, {}, {}
    wide: Any = pt.propagate(systems[SECOND], start, [END], precision=WIDE)
    exact = wide.position[0]
    for name, system in systems.items():
        began = time.perf_counter()
        motion: Any = pt.propagate(system, start, np.linspace(DAY, END, DAYS))
        first[name] = time.perf_counter() - began - motion.run.wall_time
        energy[name] = float(np.max(np.abs(motion.drift["energy"])))
        tools[name] = _motion(system, start, exact if name == SECOND else motion.position[-1])
    run = two_bodies_by_hand.prepare(pair, start, END, compact=short)
    tools[BY_HAND] = Contender(lambda: run, lambda position: _apart(position, exact), LIMIT)
    outcomes = interleaved(tools, repeats=3 if short else 15, budget=4.0)
    return {
        "days": DAYS,
        "tools": outcomes,
        "first": first,
        "energy": energy,
        "computed_by": computed_by(motion.run),
        "members": _members(systems[SECOND], start, 64 if short else 1000),
        "map": _map(16 if short else 256),
    }


def _motion(system, start, exact):
    def run():
        motion: Any = pt.propagate(system, start, [END])
        return motion.position[0]

    return Contender(lambda: run, lambda position: _apart(position, exact), LIMIT)


def _apart(position, exact):
    return float(np.linalg.norm(position - exact) / np.linalg.norm(exact))


def _members(system, start, count):
    """Return members per second of an ensemble of impacts on two cores, in a second call."""
    kicks = np.random.default_rng(1).normal(0, 1e-4, (count, 3))
    starts = system.body.kick(start, kicks)
    pt.propagate(system, system.body.kick(start, kicks[:4]), [DAY], threads=2, progress=False)  # compiles
    return _timed(count, lambda: pt.propagate(system, starts, [END], threads=2, progress=False))


def _map(count):
    """Return members per second of a map of chaos on two cores."""
    pair, start = didymos()
    system = pt.System(pair, pt.forces.MutualGravity())
    kicks = np.random.default_rng(2).normal(0, 1e-4, (count, 3))
    pt.analysis.chaos_indicators(system, pair.kick(start, kicks[:4]), [DAY], threads=2, progress=False)
    starts = pair.kick(start, kicks)
    return _timed(count, lambda: pt.analysis.chaos_indicators(system, starts, [END], threads=2, progress=False))


def _timed(count, run):
    pin(2)
    began, used = time.perf_counter(), time.process_time()
    run()
    took, used = time.perf_counter() - began, time.process_time() - used
    pin(1)
    return {"members": count, "seconds": took, "busy": used / took, "cores": min(2, len(ALLOWED) or 2)}
