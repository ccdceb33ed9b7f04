"""Stores of ensembles whose run is killed, whose disk is full, which two runs want, or which are of another problem."""

import dataclasses
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import forked
import poinsot as pt
from poinsot.storage import ensemble_store, lease, store_opening, zarr_group
from poinsot.storage.run_record import versions

PROBLEM = """
import numpy as np, poinsot as pt
BODY = pt.Body((1.25, 1.0, 0.75))
COUNT, TIMES = 21, np.linspace(0, 20, 6)
RATES = np.random.default_rng(19).normal(size=(COUNT, 3))
SYSTEM = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)))
STATES = BODY.state(np.broadcast_to((1.0, 0, 0, 0), (COUNT, 4)), omega_body=RATES)
EVENTS = [pt.events.SpinFlip((0, 1, 0))]

def run(out, **options):
    given = {"chunk": 6, "threads": 1, "events": EVENTS, "progress": False} | options
    return pt.propagate(SYSTEM, STATES, TIMES, out=out, **given)
"""
problem: dict = {}
exec(PROBLEM, problem)
run, SYSTEM, STATES, TIMES, COUNT = (problem[name] for name in ("run", "SYSTEM", "STATES", "TIMES", "COUNT"))

KILLED = """
import os, pathlib, signal, sys
os.environ["POINSOT_CACHE"] = ""  # so that every process synchronises the same files
calls, last = 0, int(sys.argv[2])

def before(function):
    def called(*arguments, **named):
        global calls
        calls += 1
        if calls == last:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments, **named)
    return called

os.fsync, pathlib.Path.replace, pathlib.Path.mkdir = map(before, (os.fsync, pathlib.Path.replace, pathlib.Path.mkdir))
run(sys.argv[1])
print(calls)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A store that nothing has interrupted, and the result in memory."""
    folder = tmp_path_factory.mktemp("whole")
    run(folder / "it.zarr")
    return folder / "it.zarr", pt.propagate(SYSTEM, STATES, TIMES, progress=False, events=problem["EVENTS"])


def contents(store):
    """The files of a store, with their bytes."""
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def count_of_instants(tmp_path):
    ended = forked.run(PROBLEM + KILLED, tmp_path / "count.zarr", 10**9)
    return int(ended.stdout)


def check_killed(tmp_path, whole, instant):
    """A run that is killed before an instant leaves what is whole, and the same call goes on from there."""
    store, result = tmp_path / f"{instant}.zarr", whole[1]
    assert forked.run(PROBLEM + KILLED, store, instant).returncode == -signal.SIGKILL
    done = 0
    if store.exists():
        found = pt.load(store)
        done = found.store.finished
        for number in np.flatnonzero(found.store.whole):
            members = found.store.members_of(number)
            assert np.array_equal(found[members].quaternion, result[members].quaternion)
        left = np.repeat(~found.store.whole, found.store.chunk)[:COUNT]
        assert np.isnan(found.quaternion[left]).all()
    before = {path: os.stat(path).st_mtime_ns for path in store.glob("quaternion/c.*") if path.suffix != ".part"}
    run(store)
    assert contents(store) == contents(whole[0])
    assert sum(os.stat(path).st_mtime_ns == then for path, then in before.items()) >= done // 6  # not done again
    return done


def test_killed_at_some_instants(tmp_path, whole):
    instants = count_of_instants(tmp_path)
    assert instants > 50
    done = [check_killed(tmp_path, whole, instant) for instant in (instants // 2, instants)]
    assert 0 < done[0] < done[1] == COUNT  # all but the last synchronisation


@pytest.mark.slow
def test_killed_at_instants_all_along(tmp_path, whole):
    count = count_of_instants(tmp_path)
    found = [check_killed(tmp_path, whole, instant) for instant in (*range(1, count, 6), count)]
    assert sorted(found) == found
    assert {*found} == {0, 6, 12, 18, COUNT}


LONG = (
    PROBLEM
    + """
import sys
COUNT, TIMES, EVENTS = 1000, np.linspace(0, 600, 6), []
STATES = BODY.state(np.ones((COUNT, 4)) / 2, omega_body=np.random.default_rng(1).normal(size=(COUNT, 3)))
if __name__ == "__main__":
    run(sys.argv[1], chunk=50)
"""
)


def started(out):
    """A long run in a process of its own that has finished some chunks."""
    process = subprocess.Popen([sys.executable, "-c", LONG, out], stderr=subprocess.PIPE, text=True)
    for _ in range(3000):
        if sum(1 for _ in (out / "chunks").glob("*/zarr.json")) >= 2:
            return process
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.02)
    raise AssertionError("no chunk was written in a minute")


@pytest.mark.parametrize(
    "signal_",
    [*(pytest.param(each, marks=pytest.mark.slow) for each in (signal.SIGKILL, signal.SIGTERM)), signal.SIGINT],
)
def test_a_run_that_is_ended_is_resumed(signal_, tmp_path):
    out = tmp_path / "it.zarr"
    process = started(out)
    with pytest.raises(ValueError, match=f"which process {process.pid} on .* writes"):  # while it runs
        long_run(out)
    process.send_signal(signal_)
    error = process.communicate(timeout=60)[1]
    done = pt.load(out).store.finished
    assert 100 <= done < 1000
    if signal_ == signal.SIGINT:
        assert (
            f"propagation was interrupted: {done} of 1000 members are done. The same call continues the run." in error
        )
    stored = long_run(out)
    assert stored.store.whole.all()
    direct = long_run(None, chunk=None)
    assert np.array_equal(stored.quaternion, direct.quaternion)


def long_run(out, **options):
    space: dict = {"__name__": "a test"}
    exec(LONG, space)
    return space["run"](out, **{"chunk": 50} | options)


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
import signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
try:
    run(sys.argv[1], events=())
except OSError as error:
    print(error)
"""


def test_a_full_disk_is_one_sentence_and_nothing_is_lost(tmp_path):
    """The last chunk is of three members: a limit that their shards keep and those of six members do not."""
    out = tmp_path / "it.zarr"
    run(out, events=())
    for number in (1, 3):
        shutil.rmtree(out / "chunks" / f"{number:06}")
    expected = contents_of_run(tmp_path)
    sizes = [path.stat().st_size for path in out.rglob("c.*") if path.parent.parent == out]
    output = forked.run(PROBLEM + FULL, out, max(sizes) - 1).stdout
    assert output == (
        f"out must be a store that can be written, got {out}: File too large. "
        "2 of 4 chunks are whole; the same call goes on.\n"
    )
    assert pt.load(out).store.finished == 12
    assert not list(out.rglob("*.part"))
    run(out, events=())
    assert contents(out) == expected
    output = forked.run(PROBLEM + FULL, tmp_path / "new.zarr", 1000).stdout
    assert output.startswith(f"out must be a store that can be written, got {tmp_path / 'new.zarr'}: File too large.")
    assert not (tmp_path / "new.zarr").exists()


def contents_of_run(tmp_path):
    run(tmp_path / "other.zarr", events=())
    return contents(tmp_path / "other.zarr")


# ---------------------------------------------------------------------- other problems


def test_the_same_call_does_nothing_again(whole, monkeypatch):
    monkeypatch.setattr(ensemble_store.EnsembleStore, "write", None)
    again = run(whole[0])
    assert np.array_equal(again.quaternion, whole[1].quaternion)
    assert np.array_equal(run(whole[0], chunk=None).quaternion, whole[1].quaternion)


def test_the_same_call_gives_a_store_another_title(tmp_path):
    out = tmp_path / "it.zarr"
    run(out, provenance={"title": "Before"})
    shutil.rmtree(out / "chunks" / "000001")
    before = contents(out)
    assert run(out, provenance={"title": "After"}).provenance["title"] == "After"
    assert pt.load(out).provenance["title"] == "After"
    changed = {name for name, content in contents(out).items() if before.get(name, content) != content}
    assert changed == {"zarr.json"}


OTHERS = {
    "times": {"times": TIMES + 1e-9},
    "states": {"state": STATES.__class__(STATES.quaternion, -STATES.conjugate_momenta)},
    "system": {"system": pt.System(problem["BODY"], pt.UniformGravity(0.5, (1, 0, 1e-12)))},
    "events": {"events": [pt.events.SpinFlip((1, 0, 0))]},
    "settings": {"tolerance": 1e-14},
    "variables": {"variables": ["quaternion"]},
    "variables and reduce": {"reduce": lambda data: data[["quaternion"]].mean()},
    "chunks, of 6 members": {"chunk": 7},
    "times and events": {"times": TIMES[:-1], "events": ()},
}


@pytest.mark.parametrize("name", OTHERS)
def test_another_problem_is_refused(name, whole):
    given = {"system": SYSTEM, "state": STATES, "times": TIMES, "events": problem["EVENTS"], "chunk": 6} | OTHERS[name]
    before = contents(whole[0])
    with pytest.raises(ValueError) as refused:
        pt.propagate(**given, out=whole[0], progress=False)
    assert str(refused.value) == (
        f"out must be a new name or the store of this problem, got {whole[0]}, which differs in its {name}. "
        "Give another name."
    )
    assert contents(whole[0]) == before


def test_another_version_is_refused(whole, monkeypatch):
    of = versions()
    monkeypatch.setattr(store_opening, "versions", lambda: of | {"llvmlite": "99.0"})
    with pytest.raises(ValueError, match=f"differs in its versions, llvmlite {of['llvmlite']} and now 99.0"):
        run(whole[0])


def damaged(store, number):
    """A copy of which a file is removed, cut short or changed."""
    if number == 0:
        (store / "quaternion" / "c.1.0.0").unlink()
    elif number == 1:
        os.truncate(store / "angular_momentum_body" / "c.2.0.0", 100)
    elif number == 2:
        shutil.rmtree(store / "chunks" / "000001" / "event_0_time")
    else:
        (store / "chunks" / "000002" / "zarr.json").write_text("{}")


@pytest.mark.parametrize("number", range(4))
def test_half_a_store_is_refused_and_mended(number, whole, tmp_path):
    store = tmp_path / "it.zarr"
    shutil.copytree(whole[0], store)
    damaged(store, number)
    with pytest.raises(ValueError, match="must be a whole result as save writes it, got another: "):
        pt.load(store)
    run(store)
    assert contents(store) == contents(whole[0])


@pytest.mark.parametrize("name", ["quaternion", "time", "initial_time"])
def test_lengths_that_do_not_go_together_are_refused_before_memory_is_taken(name, whole, tmp_path):
    """Metadata of a stranger, with its digest, and a file with a hole of the size that they announce."""
    store = tmp_path / "it.zarr"
    shutil.copytree(whole[0], store)
    described, attributes = zarr_group.read_group(store)
    about, many = described[name], 2**40
    more = dataclasses.replace(about, shape=(many, *about.shape[1:]))
    if about.chunk:
        attributes["store"]["members"] = many
        described |= {
            key: dataclasses.replace(one, shape=(many, *one.shape[1:])) for key, one in described.items() if one.chunk
        }
    else:
        os.truncate(store / name / about.key(), more.size_of(many))
    zarr_group.write_group(store, described | {name: more}, attributes)
    with pytest.raises(ValueError, match=r"got another: \w+ has another length along \w+ than the others\.$"):
        pt.load(store)


def test_a_store_larger_than_memory_is_refused(whole, monkeypatch):
    monkeypatch.setattr(ensemble_store, "available_memory", lambda: 100)
    with pytest.raises(ValueError, match=r"it needs \d{4} bytes of memory, of which 100 are left\.$"):
        pt.load(whole[0])


def test_more_chunks_than_a_store_has_are_refused(whole, monkeypatch):
    monkeypatch.setattr(ensemble_store, "MAX_CHUNKS", 3)
    with pytest.raises(ValueError, match=r"it has 4 chunks, more than 3\.$"):
        pt.load(whole[0])


def test_what_is_no_store_is_refused(whole, tmp_path):
    (tmp_path / "folder.zarr").mkdir()
    (tmp_path / "file.zarr").write_text("x")
    pt.save(whole[1].member(0), tmp_path / "one.zarr")
    for name in ("folder", "file", "one"):
        with pytest.raises(ValueError, match=f"out must be a new name or the store of this problem, got .*{name}.zarr"):
            run(tmp_path / f"{name}.zarr")
    with pytest.raises(FileNotFoundError, match="No such folder"):
        run(tmp_path / "nowhere" / "it.zarr")


def test_a_store_that_cannot_be_written_is_one_sentence(whole, tmp_path, monkeypatch):
    store = tmp_path / "it.zarr"
    shutil.copytree(whole[0], store)
    shutil.rmtree(store / "chunks" / "000001")
    real = os.open

    def read_only(path, flags, *mode, **named):
        if flags & (os.O_WRONLY | os.O_RDWR) and str(tmp_path) in str(path):
            raise OSError(30, os.strerror(30), str(path))
        return real(path, flags, *mode, **named)

    monkeypatch.setattr(os, "open", read_only)
    with pytest.raises(OSError, match=f"out must be a store that can be written, got {store}: Read-only file system"):
        run(store)


def test_a_whole_store_is_read_where_nothing_can_be_written(whole, tmp_path, monkeypatch):
    store = tmp_path / "it.zarr"
    shutil.copytree(whole[0], store)
    monkeypatch.setattr(os, "access", lambda *_: False)
    before = contents(store)
    assert np.array_equal(run(store).quaternion, whole[1].quaternion)
    assert contents(store) == before
    os.truncate(store / "quaternion" / "c.1.0.0", 100)
    with pytest.raises(ValueError, match=f"out must be a whole store, got {store} with parts missing: quaternion/c.1"):
        run(store)


@pytest.mark.parametrize("error", [FileNotFoundError(2, "No such file"), ConnectionError("down"), ValueError("mine")])
def test_what_a_reduction_raises_is_not_of_the_store(error, tmp_path):
    def fails(_):
        raise error

    with pytest.raises(type(error)) as caught:
        run(tmp_path / "it.zarr", reduce=fails)
    assert caught.value is error


def test_a_store_that_another_run_makes_at_the_same_time_stays(tmp_path, monkeypatch):
    out, plain = tmp_path / "it.zarr", ensemble_store.StoreHeader.write

    def second(frame, folder):
        plain(frame, folder)
        if not out.exists():
            monkeypatch.setattr(ensemble_store.StoreHeader, "write", plain)
            run(out)
            times.append((out / "zarr.json").stat().st_mtime_ns)

    times: list[int] = []
    monkeypatch.setattr(ensemble_store.StoreHeader, "write", second)
    run(out)
    assert (out / "zarr.json").stat().st_mtime_ns == times[0]


def test_two_threads_write_the_same_chunk(tmp_path):
    """Of a worker whose chunk another run takes before it has ended."""
    values = np.arange(4000.0).reshape(1000, 4)
    about = zarr_group.Described.of(("member", "parameter"), values, {}).in_shards(1000, 1)

    def write(_):
        about.written(tmp_path, values)
        zarr_group.write_group(tmp_path, {}, {})

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(20)))
    array = zarr_group.StoredArray(tmp_path, about, np.ones(1, dtype=bool))
    assert np.array_equal(np.asarray(array), values)
    assert not [*tmp_path.glob("*.part")]


# ---------------------------------------------------------------------- leases


def test_a_lease_of_another_machine_is_waited_for_a_minute(whole, tmp_path):
    store = tmp_path / "it.zarr"
    shutil.copytree(whole[0], store)
    owner = {"host": "elsewhere", "process": 7, "token": "x"}
    (store / "lock").write_text(json.dumps(owner))
    with pytest.raises(ValueError, match=r"out must be a store that no other run writes, got .*, which process 7 on"):
        run(store)
    now = time.time()
    os.utime(store / "lock", (now - 2 * lease.LEASE_SECONDS,) * 2)
    run(store)
    assert not (store / "lock").exists()
    (store / "lock").write_text(json.dumps(owner | {"host": socket.gethostname()}))  # killed on this machine
    run(store)


def test_a_lease_that_is_lost_ends_the_run(tmp_path):
    with lease.lease(tmp_path) as held:
        held.check()
        (tmp_path / "lock").write_text(json.dumps({"host": "elsewhere", "process": 7, "token": "x"}))
        with pytest.raises(ValueError, match=r"no other run writes, got .*, which process 7 on elsewhere writes"):
            held.check()
    assert (tmp_path / "lock").exists()


def test_a_lease_is_renewed(tmp_path, monkeypatch):
    monkeypatch.setattr(lease, "LEASE_SECONDS", 0.2)
    with lease.lease(tmp_path):
        os.utime(tmp_path / "lock", (0, 0))
        for _ in range(100):
            if (tmp_path / "lock").stat().st_mtime > 0:
                return
            time.sleep(0.02)
    raise AssertionError("it was not renewed")


# ---------------------------------------------------------------------- arrays


@pytest.mark.parametrize(("chunk", "member_bytes"), [(1000, 8), (997, 10**5), (10**6, 10), (7, 10**9), (1, 1)])
def test_blocks_divide_chunks(chunk, member_bytes):
    block = ensemble_store.block_of(chunk, member_bytes)
    assert chunk % block == 0
    assert block == 1 or block * member_bytes <= zarr_group.BLOCK_BYTES


def test_one_member_is_read_alone(whole, monkeypatch):
    motion, read = pt.load(whole[0]), []
    content = zarr_group.StoredArray._content

    def noted(array, number, place, size):
        read.append(number)
        return content(array, number, place, size)

    monkeypatch.setattr(zarr_group.StoredArray, "_content", noted)
    motion.member(7)
    assert {*read} == {1}
    assert textwrap.shorten(str(motion), 1000).count("4 of 4 chunks of 6 members") == 1


@pytest.mark.parametrize("with_dask", [True, False])
def test_datasets_read_chunk_after_chunk(whole, with_dask, monkeypatch):
    if with_dask:
        pytest.importorskip("dask")
    else:
        monkeypatch.setattr(ensemble_store, "find_spec", lambda _: None)
    store, motion = whole
    data, read, content = pt.load(store).dataset, [], zarr_group.StoredArray._content

    def noted(array, number, place, size):
        read.append(number)
        return content(array, number, place, size)

    monkeypatch.setattr(zarr_group.StoredArray, "_content", noted)
    assert (data["quaternion"].chunks is not None) is with_dask
    some = data["quaternion"].isel(member=[7, 8], time=slice(None, None, 2), parameter=1)
    assert not read
    assert np.array_equal(some, motion.quaternion[7:9, ::2, 1])
    assert {*read} == {1}
    assert np.array_equal(data["quaternion"].isel(time=-1), motion.quaternion[:, -1])
    assert np.array_equal(data["quaternion"].isel(member=3), motion.quaternion[3])
    assert np.allclose(
        data["angular_momentum_body"].mean("member"), motion.angular_momentum_body.mean(axis=0), rtol=0, atol=1e-15
    )


def test_a_store_that_is_removed_under_its_run_says_so(tmp_path):
    def reduce(data):
        shutil.rmtree(tmp_path / "it.zarr")
        return data[["quaternion"]].max("time")

    with pytest.raises(ValueError, match=r"^out must be a whole store, got .*it\.zarr with parts missing: "):
        run(tmp_path / "it.zarr", reduce=reduce)


def test_a_link_to_nothing_is_no_store(tmp_path):
    (tmp_path / "link.zarr").symlink_to(tmp_path / "nothing.zarr")
    with pytest.raises(ValueError, match=r"link\.zarr, a link to nothing\.$"):
        run(tmp_path / "link.zarr")
