"""The memory that a process may use: the least of what the machine, its control groups and its limits leave."""

import contextlib
import re
import resource

import numpy as np
import pytest

import poinsot as pt
from poinsot.storage import memory

GB = 1024**3


@pytest.fixture
def system(tmp_path, monkeypatch):
    """A machine with 8 GB available whose files can be written."""
    monkeypatch.setattr(memory, "PROC", tmp_path / "proc")
    monkeypatch.setattr(memory, "CGROUPS", tmp_path / "cgroup")
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY,) * 2)

    def write(**files):
        for name, text in files.items():
            path = tmp_path / name.replace("__", "/").replace("_dot_", ".")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    write(proc__meminfo=f"MemTotal: 1 kB\nMemAvailable: {8 * 1024**2} kB\n")
    return write


@pytest.mark.usefixtures("system")
def test_the_machine():
    assert memory.available_memory() == 8 * GB


def test_nothing_is_known(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "PROC", tmp_path)
    monkeypatch.setattr(memory, "CGROUPS", tmp_path)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY,) * 2)
    assert memory.available_memory() == memory.ASSUMED_BYTES


def test_a_group_and_those_that_it_is_in(system):
    own = {"memory_dot_max": "max\n", "memory_dot_current": "5\n", "memory_dot_stat": "inactive_file 0\n"}
    system(proc__self__cgroup="0::/job/step\n", **{f"cgroup__job__step__{name}": text for name, text in own.items()})
    assert memory.available_memory() == 8 * GB
    above = own | {"memory_dot_max": f"{3 * GB}\n", "memory_dot_current": f"{GB}\n"}
    system(**{f"cgroup__job__{name}": text for name, text in above.items()})
    assert memory.available_memory() == 2 * GB
    system(cgroup__job__memory_dot_stat=f"file 7\ninactive_file {GB // 2}\n")  # what the kernel gives back
    assert memory.available_memory() == 2.5 * GB
    system(cgroup__job__step__memory_dot_max=f"{GB}\n")
    assert memory.available_memory() == GB - 5


def test_a_group_of_version_1(system):
    system(proc__self__cgroup="4:cpu:/x\n3:memory:/job\n", cgroup__memory__job__memory_dot_limit_in_bytes=str(2 * GB))
    system(cgroup__memory__job__memory_dot_usage_in_bytes=str(GB))
    system(cgroup__memory__job__memory_dot_stat=f"total_inactive_file {GB // 4}\n")
    assert memory.available_memory() == 1.25 * GB


def test_a_limit_of_addresses(system, monkeypatch):
    system(proc__self__statm="100 50 1 1 0 1 0\n")
    monkeypatch.setattr(resource, "getrlimit", lambda _: (GB, GB))
    assert memory.available_memory() == GB - 100 * resource.getpagesize()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (10, 10))
    assert memory.available_memory() == 0


def test_motions_larger_than_memory_are_refused_before_the_run(monkeypatch):
    """20 000 members at a million times: 7 numbers of 8 bytes each."""
    monkeypatch.setattr(memory, "available_memory", lambda: 4 * 10**9)
    body, times = pt.Body((1.25, 1.0, 0.75)), np.arange(1e6)
    state = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (0, 1, 1), 20_000))
    sentence = (
        "motions must fit into the memory that this process may use, 4 GB, got 20000 members at 1000000 times, "
        "which take 1.12e+03 GB. Write them to a store on disk: out='run.zarr'."
    )
    for call in (lambda: pt.propagate(pt.System(body), state, times), lambda: pt.free_motion(body, state, times)):
        with pytest.raises(ValueError, match=re.escape(sentence)):
            call()


def test_what_motions_take_is_what_is_asked_for(monkeypatch):
    """One byte less than the rows take is too little; so much is enough."""
    monkeypatch.setattr(memory, "MIN_CHECKED_BYTES", 0)
    body, times = pt.Body((1.25, 1.0, 0.75)), np.linspace(0, 1, 11)
    state = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (0, 1, 1), 8))
    for run in (lambda: pt.propagate(pt.System(body), state, times), lambda: pt.free_motion(body, state, times)):
        motion = run()
        rows = sum(values.nbytes for values in motion.phase.values())
        for free, enough in ((rows, True), (rows - 1, False)):
            monkeypatch.setattr(memory, "available_memory", lambda free=free: free)
            with contextlib.nullcontext() if enough else pytest.raises(ValueError, match=r"^motions must fit into"):
                run()
        monkeypatch.setattr(memory, "available_memory", lambda: GB)
