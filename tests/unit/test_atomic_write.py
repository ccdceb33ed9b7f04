"""Every writer writes a file whole or not at all, and leaves no part next to it."""

import os
import re
import resource
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
from poinsot import atomic_write as writing

BODY = pt.Body((1.25, 1.0, 0.75))
MOTION = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), np.linspace(0, 100, 2001))
DATED = {"calendar": pt.Calendar("2026-11-21T00:00:00", "TAI"), "reference_frame": "ICRF", "body_frame": "SC_BODY_1"}

WRITERS: dict[str, Any] = {
    "it.nc": pt.save,
    "it.zarr": pt.save,
    "it.html": pt.view,
    "it.aem": lambda motion, path, **options: pt.files.write_aem(motion, path, **DATED, **options),
    "it.apm": lambda motion, path, **options: pt.files.write_apm(BODY, motion.initial, path, **DATED, **options),
    "it.bc": lambda motion, path, **options: pt.files.write_ck(motion, path, **DATED, **options),
    "it.a": lambda motion, path, **options: pt.files.write_stk_attitude(
        motion, path, calendar=DATED["calendar"], reference_frame="ICRF", **options
    ),
    "it.csv": lambda motion, path, **options: pt.files.write_quaternion_csv(
        motion, path, calendar=DATED["calendar"], **options
    ),
    "it.gif": lambda motion, path, **options: pt.animate(motion, path, seconds=0.1, **options),
}
"""What writes a motion, by the name of a file."""


def content(path):
    """The bytes of a file, or of all files in a folder."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    return {file.name: file.read_bytes() for file in files if file.is_file()}


def test_the_list_has_every_writer():
    known = {name for name in dir(pt) if name.startswith("write_")} | {"save", "view"}
    known.add("animate")
    named = {name for write in WRITERS.values() for name in (*write.__code__.co_names, write.__name__)}
    assert known <= named


SAID = {
    "it.nc": r"netCDF says: (NetCDF: HDF error|Permission denied)\. Is the disk full\?",
    "it.bc": r"(the operating system reported: File too large\.|SPICE wrote a part of it without a word\. Is "
    r"the disk full\?)",
}
"""Messages of a full disk that differ from the message of the operating system."""


@pytest.mark.parametrize("size", [0, 300, 5000])
@pytest.mark.parametrize("name", WRITERS)
def test_a_disk_that_is_full_is_one_sentence_and_leaves_the_file_that_was_there(name, size, tmp_path):
    """The system ends each file at some bytes; the old one, of a shorter motion, stays bit for bit."""
    if (name, size) == ("it.apm", 5000):
        pytest.skip("it has less than 1000 bytes")
    path = tmp_path / name
    short = pt.free_motion(BODY, MOTION.initial, MOTION.times[:3])
    WRITERS[name](short, path)
    before = content(path)
    reading, writing_end = os.pipe()
    child = os.fork()
    if not child:
        os.dup2(writing_end, 2)  # with what libraries write there
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        try:
            WRITERS[name](MOTION, path, overwrite=True)
        except OSError as error:
            os.write(2, str(error).encode())
        os._exit(0)
    os.close(writing_end)
    with open(reading, encoding="utf-8") as stream:
        written = stream.read()
    os.waitpid(child, 0)
    reason = SAID.get(name, r"the operating system reported: File too large\.")
    assert re.fullmatch(
        rf"{re.escape(str(tmp_path))}/it\.\w+ must be a file that can be written, but {reason}", written
    )
    assert content(path) == before
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_no_file_is_not_replaced(name, tmp_path):
    """As root, /dev/null would be a text from then on."""
    path = tmp_path / name
    os.mkfifo(path)
    with pytest.raises(FileExistsError, match="must be"):
        WRITERS[name](MOTION, path, overwrite=True)
    assert path.is_fifo()
    assert list(tmp_path.iterdir()) == [path]


DIES = """
import os, sys
from pathlib import Path
from poinsot.atomic_write import new_file
with new_file(Path(sys.argv[1]), True) as part:
    part.write_text("half of it")
    print("written", flush=True)
    sys.stdin.read() if sys.argv[2:] else os.kill(os.getpid(), 9)
"""


def run(path, *more):
    return subprocess.Popen(
        [sys.executable, "-c", DIES, path, *more], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )


def parts(folder):
    return sorted(folder.glob(".*"))


def aged(folder):
    """A folder as if it had been made an hour ago."""
    old = time.time() - 3600
    os.utime(folder, (old, old))


def test_what_a_killed_process_left_goes_with_the_next_writing(tmp_path):
    path = tmp_path / "it.txt"
    path.write_text("old")
    with run(path) as process:
        process.wait()
    assert path.read_text() == "old"
    (left,) = parts(tmp_path)
    writing.write_text(path, "new", overwrite=True)
    assert parts(tmp_path) == [left]  # a fresh one may be waiting for its lock
    aged(left)
    writing.write_text(tmp_path / "other.txt", "new", overwrite=False)
    assert not parts(tmp_path)
    assert path.read_text() == "new"


def test_what_another_process_is_writing_stays(tmp_path):
    path = tmp_path / "it.txt"
    with run(path, "wait") as process:
        process.stdout.readline()
        (live,) = parts(tmp_path)
        aged(live)
        writing.write_text(path, "mine", overwrite=False)
        assert parts(tmp_path) == [live]
        process.communicate()
    assert path.read_text() == "half of it"
    assert not parts(tmp_path)


def test_a_folder_of_another_is_no_part(tmp_path):
    other = tmp_path / ".poinsot-mine"
    other.mkdir()
    aged(other)
    writing.write_text(tmp_path / "it.txt", "new", overwrite=False)
    assert other.is_dir()


def test_a_store_that_cannot_take_its_name_leaves_the_old_one(tmp_path, monkeypatch):
    path = pt.save(MOTION, tmp_path / "it.zarr")
    before, rename = content(path), Path.rename

    def failing(self, target):
        if Path(target) == path and self.name == path.name:
            raise OSError("no")
        return rename(self, target)

    monkeypatch.setattr(writing, "_exchanged", lambda *_: False)
    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(OSError, match="no"):
        pt.save(pt.free_motion(BODY, MOTION.initial, [0.0]), path, overwrite=True)
    assert content(path) == before
    assert not parts(tmp_path)


# ---------------------------------------------------------------------- killed at every instant

CALLS = ("fsync", "link", "mkdir", "open", "rename", "replace", "rmdir", "unlink")


def make(path, text, overwrite):
    """Write a folder as a store is written, with a file that marks it."""
    with writing.new_folder(path, overwrite, "mark") as part:
        part.mkdir()
        (part / "text").write_text(text)
        (part / "mark").write_text("")


def text_of(path):
    """The text in a file, or in a folder that is whole."""
    if path.is_dir():
        assert (path / "mark").is_file()
        return (path / "text").read_text()
    return path.read_text()


def killed_at(instant, call):
    """Call a function in a process; return whether it was killed, before or after a call of the system."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    passed = 0

    def here():
        nonlocal passed
        passed += 1
        if passed == instant:
            os.kill(os.getpid(), signal.SIGKILL)

    def watched(function):
        def called(*arguments, **named):
            here()
            try:
                return function(*arguments, **named)
            finally:
                here()

        return called

    for name in CALLS:
        setattr(os, name, watched(getattr(os, name)))
    writing._exchanged = watched(writing._exchanged)
    try:
        call()
    finally:
        os._exit(0)


@pytest.mark.parametrize("write", [make, writing.write_text], ids=["folder", "file"])
@pytest.mark.parametrize("exchange", [True, False], ids=["exchange", "two renames"])
def test_a_kill_at_any_instant_of_a_replacement_leaves_the_old_result_or_the_new_one(
    write, exchange, tmp_path, monkeypatch
):
    if not exchange:
        monkeypatch.setattr(writing, "_exchanged", lambda *_: False)
    seen, killed = [], True
    while killed:
        folder = tmp_path / str(len(seen))
        folder.mkdir()
        path = folder / "it"
        write(path, "old", overwrite=False)
        killed = killed_at(len(seen) + 1, lambda path=path: write(path, "new", overwrite=True))
        if exchange:
            assert path.exists()
        assert writing.exists(path)
        seen.append(text_of(path))
        for left in parts(folder):
            aged(left)
        write(folder / "other", "other", overwrite=False)
        assert text_of(path) == seen[-1]
        assert not parts(folder)
        write(path, "newest", overwrite=True)
        assert text_of(path) == "newest"
    assert seen[0] == "old"
    assert seen[-1] == "new"
    assert seen == sorted(seen, reverse=True)  # first old, then new


def test_a_store_whose_replacement_was_killed_between_two_renames_is_loaded(tmp_path):
    path, short = pt.save(MOTION, tmp_path / "it.zarr"), pt.free_motion(BODY, MOTION.initial, [0.0])
    (hidden := tmp_path / ".poinsot-0123.part").mkdir()
    (hidden / "lock").touch()
    path.rename(hidden / "before")
    pt.save(short, hidden / "it.zarr")
    assert not path.exists()
    assert np.array_equal(pt.load(path).quaternion, short.quaternion)
    assert not parts(tmp_path)


def test_an_old_and_a_new_folder_whose_name_was_taken_meanwhile_stay(tmp_path):
    """The replacement cannot be finished, and neither folder can be the one that was superseded."""
    path, hidden = tmp_path / "it", tmp_path / ".poinsot-0123.part"
    hidden.mkdir()
    (hidden / "lock").touch()
    make(path, "old", overwrite=False)
    path.rename(hidden / "before")
    make(hidden / "it", "new", overwrite=False)
    path.write_text("of another program")
    writing.write_text(tmp_path / "other", "other", overwrite=False)
    assert (text_of(path), text_of(hidden / "before"), text_of(hidden / "it")) == ("of another program", "old", "new")


# ---------------------------------------------------------------------- names that appear meanwhile


def link_to_nothing(path):
    path.symlink_to(path.with_name("nothing"))


def not_permitted(*_):
    raise PermissionError(1, "Operation not permitted")


def a_file(path):
    path.write_text("of another process")


def a_folder(path):
    path.mkdir()
    (path / "text").write_text("of another process")


@pytest.mark.parametrize("links", [True, False], ids=["hard links", "none"])
@pytest.mark.parametrize("kind", ["file", "folder"])
@pytest.mark.parametrize("meanwhile", [link_to_nothing, a_file, a_folder])
def test_a_name_that_appears_while_a_result_is_written_stays(meanwhile, kind, links, tmp_path, monkeypatch):
    path = tmp_path / "it"
    if not links:
        monkeypatch.setattr(os, "link", not_permitted)
    new = writing.new_file(path, False) if kind == "file" else writing.new_folder(path, False, "mark")
    with pytest.raises(FileExistsError) as caught, new as part:  # noqa: PT012 - the name appears meanwhile
        part.write_text("mine") if kind == "file" else part.mkdir()
        meanwhile(path)
    assert str(caught.value) == f"{path} already exists; overwrite=True replaces it."
    assert not parts(tmp_path)
    if meanwhile is link_to_nothing:
        assert path.is_symlink()
        assert not path.exists()
    else:
        assert (path if path.is_file() else path / "text").read_text() == "of another process"


@pytest.mark.parametrize("name", WRITERS)
def test_a_link_to_nothing_is_not_replaced(name, tmp_path):
    path = tmp_path / name
    link_to_nothing(path)
    with pytest.raises(FileExistsError) as caught:
        WRITERS[name](MOTION, path)
    assert str(caught.value) == f"{path} already exists; overwrite=True replaces it."
    assert path.is_symlink()


def test_a_file_system_without_hard_links(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "link", not_permitted)
    path = writing.write_text(tmp_path / "it", "mine", overwrite=False)
    assert path.read_text() == "mine"


def test_one_of_many_writers_of_a_name_succeeds(tmp_path):
    """Each other one raises an error and writes nothing."""
    begin, wrong, done = threading.Barrier(8), [], []

    def write(number):
        for turn in range(20):
            begin.wait()
            try:
                (make if turn % 2 else writing.write_text)(tmp_path / str(turn), str(number), overwrite=False)
                done.append((turn, str(number)))
            except FileExistsError as error:
                wrong.append(str(error))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert sorted(turn for turn, _ in done) == list(range(20))
    assert {(turn, text_of(tmp_path / str(turn))) for turn in range(20)} == set(done)
    assert len(wrong) == 7 * 20
    assert all(each.endswith(" already exists; overwrite=True replaces it.") for each in wrong)


@pytest.mark.parametrize("name", ["motion.nc", "motion.zarr", "text.txt"])
def test_a_symbolic_link_stays_and_leads_to_the_new_result(tmp_path, name):
    def write(path, factor):
        if name == "text.txt":
            return writing.write_text(path, str(factor), overwrite=True)
        body = pt.Body((1.25, 1.0, 0.75))
        start = body.state((1, 0, 0, 0), omega_body=(0, 0, factor))
        return pt.save(pt.propagate(pt.System(body), start, [0.0, 1.0]), path, overwrite=True)

    def read(path):
        return path.read_text() if name == "text.txt" else pt.load(path).omega_body[0, 2]

    (tmp_path / "data").mkdir()
    target, link = tmp_path / "data" / name, tmp_path / name
    link.symlink_to(Path("data") / name)
    for factor in (1.0, 2.0):  # the link leads to nothing at first
        write(link, factor)
        assert link.is_symlink()
        assert not target.is_symlink()
        assert float(read(target)) == float(read(link)) == factor
    assert {*os.listdir(tmp_path)} == {"data", name}


def test_a_link_to_itself_is_replaced(tmp_path):
    link = tmp_path / "loop.txt"
    link.symlink_to(link)
    writing.write_text(link, "text", overwrite=True)
    assert link.read_text() == "text"
