"""Object code on disk: what is loaded, what is refused, and runs that go on without a cache."""

import errno
import os
import stat
import subprocess
import sys
import warnings

import numpy as np
import pytest

import poinsot as pt
from poinsot import atomic_write
from poinsot.taylor import kernels, object_cache
from poinsot.taylor.llvm_ir import DOUBLE, Module
from poinsot.taylor.object_cache import REMEDY, ObjectCache, folder, machine_code

KEY, CODE = "ab" * 32, bytes(range(256))

needs_users = pytest.mark.skipif(sys.platform == "win32", reason="files have no mode")


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The folder of the cache, which does not exist yet."""
    monkeypatch.setenv("POINSOT_CACHE", str(tmp_path / "kernels"))
    object_cache._warn.cache_clear()
    return tmp_path / "kernels"


@pytest.fixture
def stored(place):
    """The file of some object code."""
    ObjectCache(place).store(KEY, CODE)
    (path,) = place.iterdir()
    return path


@pytest.fixture
def give_away(monkeypatch):
    """Makes a function that gives a file to another user."""

    def give(path):
        if os.geteuid() == 0:
            os.chown(path, 65534, -1)
        else:
            monkeypatch.setattr(object_cache, "_user", lambda: 65534)

    return give


def refusals(function, *arguments):
    """Return the result of a function and its warnings."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        result = function(*arguments)
    return result, [str(each.message) for each in found]


# ---------------------------------------------------------------------- the folder


@pytest.mark.skipif(sys.platform != "linux", reason="the folder of Linux")
def test_the_folder_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.delenv("POINSOT_CACHE", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert folder() == tmp_path / ".cache/poinsot"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "x"))
    assert folder() == tmp_path / "x/poinsot"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert folder() == tmp_path / ".cache/poinsot"
    monkeypatch.setenv("POINSOT_CACHE", str(tmp_path / "own"))
    assert folder() == tmp_path / "own"
    monkeypatch.setenv("POINSOT_CACHE", "")
    assert folder() is None


def test_no_folder_stores_nothing():
    cache = ObjectCache(None)
    cache.store(KEY, CODE)
    assert cache.load(KEY) is None


# ---------------------------------------------------------------------- contents


@needs_users
def test_a_stored_file_belongs_to_the_user_alone(place, stored):
    assert ObjectCache(place).load(KEY) == CODE
    assert ObjectCache(place).load("cd" * 32) is None
    assert [stat.S_IMODE(path.stat().st_mode) for path in (place, stored)] == [0o700, 0o600]


@pytest.mark.parametrize("damage", ["changed", "cut", "empty"])
def test_a_damaged_file_is_removed_and_written_again(damage, place, stored):
    content = stored.read_bytes()
    stored.write_bytes({"changed": content[:-1] + b"x", "cut": content[:-1], "empty": b""}[damage])
    found, warned = refusals(ObjectCache(place).load, KEY)
    assert found is None
    assert warned == [
        f"a kernel in the cache must be as it was stored, got damaged contents in {stored}. It is removed."
    ]
    assert not stored.exists()
    ObjectCache(place).store(KEY, CODE)
    assert ObjectCache(place).load(KEY) == CODE


@needs_users
@pytest.mark.parametrize("kind", ["group", "others", "owner"])
def test_a_file_that_another_user_can_write_is_not_loaded(kind, place, stored, give_away):
    if kind == "owner":
        cache = ObjectCache(place)
        give_away(stored)
    else:
        cache = ObjectCache(place)
        stored.chmod(0o620 if kind == "group" else 0o602)
    found, warned = refusals(cache.load, KEY)
    assert found is None
    assert warned == [
        f"a kernel in the cache must be as it was stored, got a file that another user can write in {stored}. "
        "It is removed."
    ]


@needs_users
def test_no_link_and_no_pipe_is_loaded(place, stored, tmp_path):
    target = stored.rename(tmp_path / "elsewhere")
    stored.symlink_to(target)
    found, warned = refusals(ObjectCache(place).load, KEY)
    assert found is None
    assert len(warned) == 1
    stored.unlink()
    os.mkfifo(stored, 0o600)
    assert refusals(ObjectCache(place).load, KEY)[0] is None


@needs_users
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o1777])
def test_a_folder_that_another_user_can_write_is_not_used(mode, place, stored):
    place.chmod(mode)
    cache, warned = refusals(ObjectCache, place)
    assert warned == [
        f"the cache folder {place} must be a folder that no other user can write, got {place}, "
        f"{stat.filemode(place.stat().st_mode)} of user {os.geteuid()}. {REMEDY}"
    ]
    assert cache.load(KEY) is None
    cache.store("cd" * 32, CODE)
    assert [*place.iterdir()] == [stored]


@needs_users
@pytest.mark.usefixtures("stored")
def test_a_folder_of_another_user_is_not_used(place, give_away):
    give_away(place)
    cache, (_,) = refusals(ObjectCache, place)
    assert cache.load(KEY) is None


@needs_users
@pytest.mark.usefixtures("stored")
def test_folders_above_count(place, tmp_path):
    tmp_path.chmod(0o777)
    cache, (warned,) = refusals(ObjectCache, place)
    assert f"got {tmp_path}, drwxrwxrwx of user" in warned
    assert cache.load(KEY) is None
    tmp_path.chmod(0o1777)  # nobody else can move what lies there
    assert refusals(ObjectCache(place).load, KEY) == (CODE, [])
    tmp_path.chmod(0o700)


# ---------------------------------------------------------------------- failures


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES])
def test_a_folder_that_takes_no_file_gives_one_warning(number, place, monkeypatch):
    place.mkdir(mode=0o700)

    def fails(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("poinsot.taylor.object_cache.os.fdopen", fails)
    for count in (1, 0):
        _, warned = refusals(ObjectCache(place).store, KEY, CODE)
        assert warned == count * [f"the cache folder {place} must be writable, got: {os.strerror(number)}. {REMEDY}"]
    assert not [*place.iterdir()]


def test_a_folder_that_cannot_be_made_gives_one_warning(place):
    place.write_text("a file")
    cache, (warned,) = refusals(ObjectCache, place)
    rule = "must be a folder that no other user can write"
    assert warned.startswith(f"the cache folder {place} {rule}, got {place}, -rw")
    assert cache.load(KEY) is None


def test_a_killed_writer_leaves_no_file(place, monkeypatch):
    def killed(*_):
        raise KeyboardInterrupt

    place.mkdir(mode=0o700)
    with monkeypatch.context() as patched:
        patched.setattr(atomic_write, "synced", killed)
        with pytest.raises(KeyboardInterrupt):
            ObjectCache(place).store(KEY, CODE)
    assert not [*place.iterdir()]


def test_the_files_used_longest_ago_are_removed(place, monkeypatch):
    cache, size = ObjectCache(place), len(CODE) + object_cache.DIGEST
    monkeypatch.setattr(object_cache, "MAX_BYTES", 3 * size)
    for number in range(3):
        cache.store(f"{number}", CODE)
        os.utime(place / f"{number}.object", (number, number))
    assert cache.load("0") == CODE  # which is used last now
    cache.store("3", CODE)
    assert sorted(path.stem for path in place.iterdir()) == ["0", "2", "3"]


# ---------------------------------------------------------------------- kernels


def doubled():
    """Return the text of a function."""
    module = Module()
    module.function("twice", DOUBLE, [DOUBLE], lambda a: a * 2.0)
    return str(module)


@pytest.mark.usefixtures("place")
def test_a_loaded_kernel_spends_no_time_in_llvm(monkeypatch):
    import llvmlite.binding as llvm

    machine_code(doubled())
    monkeypatch.setattr(llvm.TargetMachine, "emit_object", None)
    assert machine_code(doubled()).get_function_address("twice")
    with pytest.raises(TypeError):
        machine_code(doubled().replace("twice", "thrice"))


@pytest.mark.parametrize("change", ["text", "level", "format", "processor", "features", "llvmlite", "LLVM"])
def test_all_that_decides_the_code_is_in_its_key(change, place, monkeypatch):
    import llvmlite
    import llvmlite.binding as llvm

    machine_code(doubled())
    text, features = doubled(), llvm.get_host_cpu_features()
    if change == "text":
        text = text.replace("twice", "thrice")
    elif change == "level":
        monkeypatch.setattr(object_cache, "CODE_GENERATION", 2)
    elif change == "format":
        monkeypatch.setattr(object_cache, "CODE_FORMAT", -1)
    elif change == "processor":
        monkeypatch.setattr(llvm, "get_host_cpu_name", lambda: "generic")
    elif change == "features":
        features["avx512f"] = False
        monkeypatch.setattr(llvm, "get_host_cpu_features", lambda: features)
    elif change == "llvmlite":
        monkeypatch.setattr(llvmlite, "__version__", "0")
    else:
        monkeypatch.setattr(llvm, "llvm_version_info", (0, 0, 0))
    machine_code(text)
    assert len([*place.iterdir()]) == 2


@pytest.mark.usefixtures("place")
def test_a_long_text_is_not_optimized(monkeypatch):
    import llvmlite.binding as llvm

    levels, create = [], llvm.Target.create_target_machine

    def noted(target, **options):
        levels.append(options["opt"])
        return create(target, **options)

    monkeypatch.setattr(llvm.Target, "create_target_machine", noted)
    monkeypatch.setattr(object_cache, "CODE_GENERATION", 1)
    for most in (len(doubled()), len(doubled()) - 1):
        monkeypatch.setattr(object_cache, "MAX_OPTIMIZED", most)
        machine_code(doubled())
    assert levels == [1, 0]


PROGRAM = """
import numpy as np, poinsot as pt
body = pt.Body((1.25, 1.0, 0.75))
start = body.state((1, 0, 0, 0), omega_body=(0.4, -0.3, 0.6))
motion = pt.propagate(pt.System(body, pt.UniformGravity(0.5, (1.0, 0.2, -0.3))), start, [0.0, 1.0])
print(motion.quaternion[-1].tobytes().hex())
"""


def test_several_processes_may_start_at_once(place):
    command = [sys.executable, "-W", "error", "-c", PROGRAM]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(4)]
    found = {process.communicate()[0] for process in started}
    assert [process.returncode for process in started] == [0] * 4
    assert len(found) == 1
    assert all(path.suffix == ".object" for path in place.iterdir())
    files = {path: path.read_bytes() for path in place.iterdir()}
    assert subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout in found
    assert {path: path.read_bytes() for path in place.iterdir()} == files


@needs_users
def test_a_forked_process_loads_and_stores(place):
    machine_code(doubled())
    child = os.fork()
    if not child:
        failed = 1
        try:
            machine_code(doubled())
            machine_code(doubled().replace("twice", "thrice"))
            failed = 0
        finally:
            os._exit(failed)
    assert os.waitpid(child, 0)[1] == 0
    assert len([*place.iterdir()]) == 2


@pytest.mark.parametrize("fault", ["damaged", "unsafe", "full"])
def test_a_run_goes_on_without_the_cache(fault, place, forget_kernels, monkeypatch):
    def rows():
        forget_kernels()
        kernels.compiled.cache_clear()
        body = pt.Body((1.25, 1.0, 0.75))
        return pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(1, 2, 3)), [0.0, 1.0]).quaternion

    expected = rows()
    if fault == "damaged":
        for path in place.iterdir():
            path.write_bytes(b"no code")
    elif fault == "unsafe":
        place.chmod(0o777)
    else:
        for path in place.iterdir():
            path.unlink()
        monkeypatch.setattr(
            "poinsot.taylor.object_cache.os.fdopen", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left"))
        )
    found, warned = refusals(rows)
    np.testing.assert_array_equal(found, expected)
    assert len(warned) == 1
