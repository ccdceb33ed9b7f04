"""Every writer writes a file whole or not at all, and leaves no part beside it for ever."""

import os
import re
import resource
import signal
import subprocess
import sys
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
    "it.aem": lambda motion, path, **said: pt.files.write_aem(motion, path, **DATED, **said),
    "it.apm": lambda motion, path, **said: pt.files.write_apm(BODY, motion.initial, path, **DATED, **said),
    "it.bc": lambda motion, path, **said: pt.files.write_ck(motion, path, **DATED, **said),
    "it.a": lambda motion, path, **said: pt.files.write_stk_attitude(
        motion, path, calendar=DATED["calendar"], reference_frame="ICRF", **said
    ),
    "it.csv": lambda motion, path, **said: pt.files.write_quaternion_csv(
        motion, path, calendar=DATED["calendar"], **said
    ),
    "it.gif": lambda motion, path, **said: pt.animate(motion, path, seconds=0.1, **said),
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
    "it.bc": r"(the system says: File too large\.|SPICE wrote a part of it without a word\. Is the disk full\?)",
}
"""What is said of a disk that is full, where it is not what the system says."""


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
        told = stream.read()
    os.waitpid(child, 0)
    said = SAID.get(name, r"the system says: File too large\.")
    assert re.fullmatch(rf"{re.escape(str(tmp_path))}/it\.\w+ must be a file that can be written, but {said}", told)
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

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(OSError, match="no"):
        pt.save(pt.free_motion(BODY, MOTION.initial, [0.0]), path, overwrite=True)
    assert content(path) == before
    assert not parts(tmp_path)


def test_a_file_that_another_process_makes_in_the_meantime_is_not_replaced(tmp_path):
    path = tmp_path / "it.csv"
    message = f"{path} already exists; overwrite=True replaces it."

    def write_second():
        with writing.new_file(path, False) as part:
            part.write_text("second")
            path.write_text("first")

    with pytest.raises(FileExistsError, match=f"^{re.escape(message)}$"):
        write_second()
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_to_a_missing_file_is_not_replaced(tmp_path):
    path = tmp_path / "it.csv"
    path.symlink_to(tmp_path / "missing.csv")
    with pytest.raises(FileExistsError, match="already exists"):
        writing.write_text(path, "text", False)
    assert path.is_symlink()


def test_a_file_takes_its_name_where_the_file_system_has_no_hard_links(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(Path, "hardlink_to", refuse)
    assert writing.write_text(tmp_path / "it.csv", "text", False).read_text() == "text"
