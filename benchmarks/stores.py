"""Ensembles in a store: the memory of a million members, what a chunk costs, and saving a long motion."""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import poinsot as pt
from benchmarks import problems
from benchmarks.ensembles import SATELLITES, SPREADS
from benchmarks.measure import pin
from benchmarks.problems import P2

MILLION = """
import json, sys, time
import numpy as np, poinsot as pt
members, out = int(sys.argv[1]), sys.argv[2]
body = pt.Body((1.25, 1.0, 0.75))
rates = np.random.default_rng(1).normal(size=(members, 3))
start = body.state((1, 0, 0, 0), omega_body=rates)
began, used = time.perf_counter(), time.process_time()
motion = pt.propagate(pt.System(body), start, np.linspace(0, 10, 100), out=out, progress=False)
took, used = time.perf_counter() - began, time.process_time() - used
one = motion.member(members // 2)
exact = pt.free_motion(one.system.body, one.initial, one.times)
status = open("/proc/self/status").read()
peak = 1024 * int(status.partition("VmHWM:")[2].split()[0])
error = float(np.max(np.abs(one.quaternion - exact.quaternion)))
print(json.dumps({"chunk": motion.store.chunk, "seconds": took, "used": used, "peak": peak, "error": error}))
"""


def in_stores(short):
    """Return the figures of a million members, of chunks, and of saving."""
    return {"million": _million(10_000 if short else 1_000_000), "chunks": _chunks(short), "saving": _saving(short)}


def _million(members):
    """Return memory, time and bytes of free rotations at a hundred times, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "million.zarr"
        command = [sys.executable, "-c", MILLION, str(members), str(out)]
        measured = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        stored = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return {"members": members, "times": 100, "stored": stored, **measured}


def _chunks(short):
    """Return processor times on one core of satellites in memory and in chunks to a store, which take turns."""
    pin(1)
    members, chunk = (2048, 1024) if short else (16_384, 4096)
    states, times = problems.ensemble(members, SPREADS[SATELLITES.key]), np.linspace(0.0, SATELLITES.end, 26)
    runs: dict[str, list[float]] = {"memory": [], "store": []}
    ends = {}
    for turn in range(3 if short else 7):
        with tempfile.TemporaryDirectory() as folder:
            for name, options in {"memory": {}, "store": {"out": Path(folder) / "it.zarr", "chunk": chunk}}.items():
                began = time.process_time()
                motion = pt.propagate(SATELLITES.system, states, times, threads=1, progress=False, **options)
                used = time.process_time() - began
                if turn:  # the first compiles
                    runs[name].append(used)
                ends[name] = motion.isel(time=-1).quaternion
    over = statistics.median(b / a - 1 for a, b in zip(runs["memory"], runs["store"], strict=True))
    seconds = {name: statistics.median(found) for name, found in runs.items()}
    same = bool(np.array_equal(ends["memory"], ends["store"]))
    return {"members": members, "chunk": chunk, "times": times.size, "over": over, "same": same, **seconds}


def _saving(short):
    """Return processor times of a heavy top at a million times: to integrate, to compute its dataset, to save it."""
    pin(1)
    count = 10_000 if short else 1_000_000
    times = np.linspace(0.0, 0.02 * count, count)
    found: dict[str, list[float]] = {name: [] for name in ("propagate", "dataset", ".nc", ".zarr")}
    for _ in range(2 if short else 4):
        motion = _timed(found["propagate"], lambda: pt.propagate(P2.system, P2.start, times))
        _timed(found["dataset"], lambda motion=motion: motion.dataset)
        with tempfile.TemporaryDirectory() as folder:
            for suffix in (".nc", ".zarr"):
                path = Path(folder) / f"it{suffix}"
                _timed(found[suffix], lambda motion=motion, path=path: pt.save(motion, path))
    return {"times": count, **{name: min(taken) for name, taken in found.items()}}


def _timed(taken, function):
    began = time.process_time()
    result = function()
    taken.append(time.process_time() - began)
    return result
