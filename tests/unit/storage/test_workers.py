"""Chunks on the workers of a real cluster of two processes: killed, interrupted, resumed, always the same bits."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.records.members import members_of

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")

COUNT, CHUNK = 240, 20
WAIT = 600
"""Seconds in which a run has begun even where many others have the processor."""
BODY = pt.Body((1.25, 1.0, 0.75))
TIMES = np.linspace(0.0, 5.0, 6)
START = BODY.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (1, 2, 3), COUNT))


class Thruster(pt.Torque):
    """A force of the user's own."""

    along: pt.BodyVector

    def torque(self, instant):
        return 0.1 * fn.where(fn.less(instant.time, 2.0), 1.0, 0.0) * fn.Vector(self.along)


TOP = pt.System(BODY, pt.UniformGravity(np.linspace(0.1, 0.9, COUNT), (1, 0.2, 0)), Thruster((0.1, 0.2, 0.3)))


def slow(data):
    """What a reduction keeps, after a while."""
    time.sleep(0.15)
    return data[["quaternion"]].isel(time=[0, -1])


@pytest.fixture(scope="module")
def cluster():
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 3}),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as own,
    ):
        yield own


@pytest.fixture
def client(cluster):
    with distributed.Client(cluster) as own:
        own.wait_for_workers(2)
        yield own


@pytest.fixture(scope="module")
def serial():
    return pt.propagate(TOP, START, TIMES)


def whole_chunks(out):
    return len(list(Path(out).glob("chunks/*/zarr.json")))


@contextlib.contextmanager
def when_chunks_are_there(out, act, count=2):
    """Do something as soon as some chunks are whole, while others are computed."""

    def watch():
        ends = time.monotonic() + WAIT
        while time.monotonic() < ends and not ended.wait(0.02):
            if whole_chunks(out) >= count:
                done.append(whole_chunks(out))
                act()
                return

    ended, done = threading.Event(), []
    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    yield done
    ended.set()
    thread.join()


def test_workers_compute_what_threads_do(client, serial, tmp_path, capsys):
    events = [pt.events.RateCrossing((0.2, 1.0, 0.1))]
    here = pt.propagate(TOP, START, TIMES, events=events)
    motion = pt.propagate(TOP, START, TIMES, events=events, out=tmp_path / "run.zarr", chunk=CHUNK, client=client)
    for name, rows in here.phase.items():
        assert np.array_equal(np.asarray(motion.phase[name]), rows)
    assert np.array_equal(motion.events[0].times, here.events[0].times)
    assert len(here.events[0]) > COUNT
    found = pt.propagate(TOP, START, TIMES, chunk=CHUNK, client=client, reduce=lambda data: data.omega_body.max("time"))
    assert np.array_equal(found.omega_body, serial.omega_body.max(axis=1))
    given = pt.System(BODY, Thruster((0.1, 0.2, 0.3))), members_of(START, slice(0, 40)), TIMES[1:]
    chaos: Any = pt.analysis.chaos_indicators(*given, out=tmp_path / "chaos.zarr", chunk=CHUNK, client=client)
    assert np.array_equal(chaos.mean_megno.values, pt.analysis.chaos_indicators(*given).mean_megno)
    assert capsys.readouterr().err == ""


def test_a_killed_worker_loses_its_chunk_only(client, serial, tmp_path):
    out, pids = tmp_path / "run.zarr", client.run(os.getpid)
    victim = next(iter(pids.values()))
    with when_chunks_are_there(out, lambda: os.kill(victim, signal.SIGKILL)) as done:
        found = pt.propagate(TOP, START, TIMES, out=out, chunk=CHUNK, client=client, reduce=slow)
    assert done
    assert done[0] < COUNT // CHUNK
    assert np.array_equal(found.quaternion, serial.quaternion[:, [0, -1]])
    client.wait_for_workers(2)
    assert victim not in client.run(os.getpid).values()


DRIVER = f"""
import sys
import distributed
from {__name__} import CHUNK, START, TIMES, TOP, slow
import poinsot as pt
with distributed.Client(sys.argv[1]) as client:
    pt.propagate(TOP, START, TIMES, out=sys.argv[2], chunk=CHUNK, client=client, reduce=slow)
"""


@pytest.mark.slow
def test_a_killed_driver_leaves_a_store_that_goes_on(cluster, client, serial, tmp_path):
    out = tmp_path / "run.zarr"
    own = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    driver = subprocess.Popen([sys.executable, "-c", DRIVER, cluster.scheduler_address, out], env=own)
    with when_chunks_are_there(out, driver.kill) as done:
        driver.wait(timeout=WAIT)
    assert driver.returncode == -signal.SIGKILL
    assert 2 <= done[0] < COUNT // CHUNK
    written = {path: path.stat().st_mtime_ns for path in out.glob("chunks/*/zarr.json")}
    found = pt.propagate(TOP, START, TIMES, out=out, chunk=CHUNK, client=client, reduce=slow)
    assert np.array_equal(found.quaternion, serial.quaternion[:, [0, -1]])
    assert all(path.stat().st_mtime_ns == before for path, before in written.items())


def test_an_interrupt_leaves_a_store_that_goes_on(client, serial, tmp_path):
    out = tmp_path / "run.zarr"
    asked = {"out": out, "chunk": CHUNK, "client": client, "reduce": slow}
    with (
        when_chunks_are_there(out, lambda: os.kill(os.getpid(), signal.SIGINT)),
        pytest.raises(pt.PropagationInterrupted, match=rf"^propagation was interrupted: \d+ of {COUNT} members"),
    ):
        pt.propagate(TOP, START, TIMES, **asked)
    assert 2 <= whole_chunks(out) < COUNT // CHUNK
    assert np.array_equal(pt.propagate(TOP, START, TIMES, **asked).quaternion, serial.quaternion[:, [0, -1]])


def test_a_connection_that_ends_leaves_a_store_that_goes_on(cluster, serial, tmp_path):
    out, own = tmp_path / "run.zarr", distributed.Client(cluster)
    asked = {"out": out, "chunk": CHUNK, "reduce": slow}
    with (
        when_chunks_are_there(out, own.close),
        pytest.raises(
            RuntimeError, match=r"^client must be connected until the last chunk ends, got a client that is clos"
        ),
    ):
        pt.propagate(TOP, START, TIMES, client=own, **asked)
    assert whole_chunks(out) < COUNT // CHUNK
    assert np.array_equal(pt.propagate(TOP, START, TIMES, **asked).quaternion, serial.quaternion[:, [0, -1]])


def test_another_client_may_be_open(client, serial, monkeypatch):
    """Futures are waited for on the event loop of their own client: on another one a run may wait for ever."""
    loops, plain = [], distributed.as_completed

    def watched(*arguments, **options):
        found = plain(*arguments, **options)
        loops.append(found.loop)
        return found

    monkeypatch.setattr(distributed, "as_completed", watched)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0") as other,
        distributed.Client(other) as last,
    ):
        found = pt.propagate(TOP, START, TIMES, chunk=120, client=client, reduce=lambda data: data[["quaternion"]])
        assert client.loop is not last.loop
    assert loops == [client.loop]
    assert np.array_equal(found.quaternion, serial.quaternion)


def test_a_large_task_gives_no_warning(client, serial):
    """It is in the graph on purpose, as what is scattered dies with its worker."""
    numbers = np.arange(1e5)

    def first(data):
        return data[["quaternion"]] + numbers[0]

    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "100 kB"}):
        found = pt.propagate(TOP, START, TIMES, chunk=120, client=client, reduce=first)
    assert np.array_equal(found.quaternion, serial.quaternion)


def test_what_cannot_travel_is_reported(client, tmp_path):
    lock = threading.Lock()

    class Locked(pt.Torque):
        def torque(self, instant):
            with lock:
                return fn.Vector(instant.omega_body)

    with pytest.raises(
        TypeError, match=r"^system, events and reduce must travel to the workers, got an object that does not: "
    ):
        pt.propagate(pt.System(BODY, Locked()), START, TIMES, out=tmp_path / "a.zarr", client=client)


def test_no_workers_and_no_client_are_reported(tmp_path):
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0") as empty,
        distributed.Client(empty) as client,
        pytest.raises(ValueError, match=r"^client must have workers, got none\. Wait for them: "),
    ):
        pt.propagate(TOP, START, TIMES, out=tmp_path / "a.zarr", client=client)
    with pytest.raises(ValueError, match=r"^client must be connected to its scheduler, got a client that is closed\.$"):
        pt.propagate(TOP, START, TIMES, out=tmp_path / "a.zarr", client=client)
    with pytest.raises(TypeError, match=r"^client must be a dask\.distributed Client, got str\.$"):
        pt.propagate(TOP, START, TIMES, out=tmp_path / "a.zarr", client="tcp://here:8786")
    assert not (tmp_path / "a.zarr").exists()


def fails(_):
    """A function that ends its worker."""
    os._exit(1)


@pytest.mark.slow
def test_a_chunk_that_kills_its_workers_stops_the_run(tmp_path):
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as own,
        distributed.Client(own) as client,
        pytest.raises(RuntimeError, match=r"^workers must live as long as a chunk takes, got 1 that died on the same"),
    ):
        pt.propagate(TOP, START, TIMES, out=tmp_path / "a.zarr", chunk=CHUNK, client=client, reduce=fails)
