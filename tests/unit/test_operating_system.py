"""Locks of files, with the calls of Linux and macOS, with those of Windows, and without any."""

import os
import subprocess
import sys
import textwrap

import pytest

SYSTEMS = {
    "fcntl": "",
    "msvcrt": """
        import fcntl, subprocess, types  # of the standard library, subprocess alone asks for msvcrt
        def locking(number, kind, size):
            assert size == 1 and os.lseek(number, 0, os.SEEK_CUR) > 2**32  # no byte that anybody reads
            try:
                fcntl.lockf(number, fcntl.LOCK_EX | fcntl.LOCK_NB, size, 0, os.SEEK_CUR)
            except BlockingIOError:
                raise PermissionError(errno.EACCES, "Permission denied") from None
        sys.modules["msvcrt"] = types.SimpleNamespace(locking=locking, LK_LOCK=1, LK_NBLCK=2)
        sys.modules["fcntl"] = sys.modules["resource"] = None
        import signal, socket
        for module, names in {
            os: "fork geteuid getuid pread pwrite register_at_fork sched_getaffinity O_NOFOLLOW O_NONBLOCK",
            signal: "setitimer SIGPROF",
            socket: "recv_fds send_fds",
        }.items():
            for name in names.split():
                delattr(module, name)
        os.supports_fd.clear()
    """,
    "none": "sys.modules['fcntl'] = sys.modules['msvcrt'] = sys.modules['resource'] = None",
}
"""Code that a process runs before it imports the package, by the system calls that remain available."""


def started(system, code, *arguments):
    program = "import errno, os, sys\n" + textwrap.dedent(SYSTEMS[system]) + "\n" + textwrap.dedent(code)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen([sys.executable, "-c", program, *map(str, arguments)], text=True, **pipes)


def printed(system, code, *arguments):
    found = started(system, code, *arguments).communicate(timeout=60)
    assert found[1] == ""
    return found[0].split("\n")[:-1]


LOCK = """
    from poinsot.operating_system import lock
    with open(sys.argv[1], "r+") as file:
        file.seek(3)
        try:
            lock(file.fileno())
            print("locked", os.lseek(file.fileno(), 0, os.SEEK_CUR), flush=True)
        except OSError as error:
            print(type(error).__name__, flush=True)
        if len(sys.argv) > 2:
            sys.stdin.read()
"""


@pytest.mark.parametrize("system", ["fcntl", "msvcrt"])
def test_a_lock_excludes_other_processes_until_its_process_ends(tmp_path, system):
    path = tmp_path / "file"
    path.write_text("text")
    first = started(system, LOCK, path, "wait")
    assert first.stdout.readline() == "locked 3\n"
    assert printed(system, LOCK, path) == ["BlockingIOError"]
    assert path.read_text() == "text"
    first.kill()
    first.communicate()
    assert printed(system, LOCK, path) == ["locked 3"]


def test_a_system_without_locks_raises_an_error(tmp_path):
    (tmp_path / "file").touch()
    assert printed("none", LOCK, tmp_path / "file") == ["OSError"]


STORE = """
    import numpy as np
    import poinsot as pt
    body = pt.Body((1.25, 1.0, 0.75))
    states = body.state((0, 0.6, 0, 0.8), omega_body=np.array([[0.0, 1.0, 2.0], [0.0, 2.0, 1.0]]))
    motion = pt.propagate(pt.System(body), states, [0.0, 1.0], out=sys.argv[1], chunk=1)
    pt.save(pt.propagate(pt.System(body), body.state((0, 0.6, 0, 0.8), omega_body=(0, 1, 2)), [0.0, 1.0]), sys.argv[2])
    pt.save(motion, sys.argv[2], overwrite=True)
    assert (pt.load(sys.argv[2]).quaternion == motion.quaternion).all()
    assert (pt.load(sys.argv[1]).quaternion == motion.quaternion).all()
    print(*sorted(os.listdir(os.path.dirname(sys.argv[1]))), *os.listdir(sys.argv[1]))
"""


@pytest.mark.parametrize("system", SYSTEMS)
def test_stores_and_files_are_written(tmp_path, system):
    """Neither a lease nor a hidden folder stays."""
    found = printed(system, STORE, tmp_path / "run.zarr", tmp_path / "run.nc")[0].split()
    assert found[:2] == ["run.nc", "run.zarr"]
    assert not {"lock", ".poinsot"} & {name.partition("-")[0] for name in found}
    assert os.path.getsize(tmp_path / "run.nc") > 0


LEASES = """
    from pathlib import Path
    from poinsot.storage.lease import lease
    try:
        with lease(Path(sys.argv[1])):
            print("held", flush=True)
            sys.stdin.read()
    except ValueError as error:
        print(str(error).partition(", got")[0])
"""


@pytest.mark.parametrize("system", ["fcntl", "msvcrt"])
def test_a_store_has_one_writer(tmp_path, system):
    first = started(system, LEASES, tmp_path)
    assert first.stdout.readline() == "held\n"
    assert printed(system, LEASES, tmp_path) == ["out must be a store that no other run writes"]
    first.communicate("")
    assert printed(system, LEASES, tmp_path) == ["held"]
    assert list(tmp_path.iterdir()) == []


EVERY_MODULE = """
    import importlib, pkgutil
    import poinsot
    for module in pkgutil.walk_packages(poinsot.__path__, "poinsot."):
        importlib.import_module(module.name)
    from poinsot.storage.memory import available_memory
    print(available_memory() > 0)
"""


@pytest.mark.parametrize("system", ["msvcrt", "none"])
def test_every_module_is_imported(system):
    assert printed(system, EVERY_MODULE) == ["True"]
