"""Chunks of satellites on workers of dask and on threads of one process, all to a store."""

import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import poinsot as pt
from benchmarks import problems
from benchmarks.ensembles import SATELLITES, SPREADS

WORKERS, THREADS = "workers: {}", "threads: {}"


def on_workers(short):
    """Return members per second on one and two threads and workers, which take turns; the starts are not counted."""
    from dask.distributed import Client, LocalCluster

    members, chunk = (1024, 128) if short else (16_384, 1024)
    states, times = problems.ensemble(members, SPREADS[SATELLITES.key]), np.linspace(0.0, SATELLITES.end, 26)
    rates: dict[str, list[float]] = {}
    ends = {}
    with tempfile.TemporaryDirectory() as folder:
        clusters = {
            count: LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=":0", local_directory=folder)
            for count in (1, 2)
        }
        clients: dict[int, Any] = {count: Client(cluster) for count, cluster in clusters.items()}
        ways = {THREADS.format(count): {"threads": count} for count in clusters}
        ways |= {WORKERS.format(count): {"client": client} for count, client in clients.items()}
        for turn in range(3 if short else 6):
            for name, options in ways.items():
                given = {"out": Path(folder) / f"{name} {turn}.zarr", "chunk": chunk, "progress": False, **options}
                began = time.perf_counter()
                motion = pt.propagate(SATELLITES.system, states, times, **given)
                if turn:  # the first compiles
                    rates.setdefault(name, []).append(members / (time.perf_counter() - began))
                ends[name] = motion.isel(time=-1).quaternion
        for closing in (*clients.values(), *clusters.values()):
            closing.close()
    first, *others = ends.values()
    same = all(np.array_equal(first, other) for other in others)
    rate = {name: statistics.median(found) for name, found in rates.items()}
    return {"members": members, "chunk": chunk, "times": times.size, "same": same, "rate": rate}


if __name__ == "__main__":
    print(on_workers(short=False))
