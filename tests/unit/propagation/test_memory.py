"""The memory that a process may use: the least of what the machine, its control groups and its limits leave."""

import resource

import pytest

from poinsot.propagation import memory

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
    assert memory.available_memory() == memory.UNKNOWN


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
