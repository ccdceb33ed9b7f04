"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import fcntl
import secrets
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

from poinsot.printable import shortened

__all__ = ["new_file", "new_folder", "unwritable", "write_text"]

PART, LOCK = ".poinsot-{}.part", "lock"
"""A folder beside what is written, and the file in it that its writer has locked."""

FRESH = 60.0
"""Seconds in which a folder may wait for its lock."""


@contextlib.contextmanager
def new_file(path: str | Path, overwrite: bool) -> Iterator[Path]:
    """Give the path of a file to write, which takes the name of `path` if all went well and goes otherwise.

    Raises
    ------
    FileNotFoundError, FileExistsError, IsADirectoryError
        If there is no such folder, a file of that name and no leave to overwrite it, or something else of that name: a
        folder, or a device or a pipe, which would be gone.
    OSError
        If the system cannot write it: the disk is full, or nobody may write there.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"{shortened(path)} must be the name of a file, got a folder.")
    if path.exists() and not path.is_file():
        raise FileExistsError(f"{shortened(path)} must be the name of a file, got a device, a pipe or a socket.")
    with _part(path, overwrite) as part:
        yield part
        if overwrite:
            part.replace(path)
        else:
            _move_to_free_name(part, path)


@contextlib.contextmanager
def new_folder(path: Path, overwrite: bool, mark: str) -> Iterator[Path]:
    """Give the path of a folder to make, as `new_file` does; one with a file of the name `mark` may be replaced."""
    with _part(path, overwrite) as part:
        if path.exists() and not (path / mark).is_file():
            raise FileExistsError(f"{shortened(path)} must be a Zarr store to be replaced, got something else.")
        yield part
        before = part.with_name("before")
        if overwrite and path.exists():
            path.rename(before)
        try:
            part.rename(path)  # refused if another process has made one there
        except OSError:
            if before.exists():
                before.rename(path)
            raise


def write_text(path: str | Path, text: str, overwrite: bool) -> Path:
    """Write a text in UTF-8, whole or not at all; return its path."""
    with new_file(path, overwrite) as part, part.open("x", encoding="utf-8", newline="\n") as stream:
        stream.write(text)
    return Path(path)


@contextlib.contextmanager
def _part(path: Path, overwrite: bool) -> Iterator[Path]:
    """Give a path in a folder that is locked as long as it lasts, after those that no process has locked are gone."""
    if not path.parent.is_dir():
        raise FileNotFoundError(f"No such folder: {shortened(path.parent)}")
    if path.exists() and not overwrite:
        raise FileExistsError(_existing(path))
    for folder in path.parent.glob(PART.format("*")):
        if _is_left(folder):
            shutil.rmtree(folder, ignore_errors=True)
    folder = path.parent / PART.format(secrets.token_hex(8))
    try:
        folder.mkdir()
        with (folder / LOCK).open("x") as lock:
            with contextlib.suppress(OSError):  # where a file system has no locks, nothing counts as left
                fcntl.flock(lock, fcntl.LOCK_EX)
            yield folder / path.name
    except OSError as error:
        if error.strerror is None:
            raise
        raise type(error)(unwritable(path, f"the system says: {error.strerror}")) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _move_to_free_name(part: Path, path: Path) -> None:
    """Rename a file unless another process or thread has made a file of the new name in the meantime."""
    try:
        path.hardlink_to(part)
    except FileExistsError:
        raise FileExistsError(_existing(path)) from None
    except OSError:  # the file system has no hard links
        part.replace(path)


def _existing(path: Path) -> str:
    return f"{shortened(path)} already exists; overwrite=True replaces it."


def unwritable(path: Path | str, why: str) -> str:
    """Return the sentence about what cannot be written."""
    return f"{shortened(path)} must be a file that can be written, but {why}."


def _is_left(folder: Path) -> bool:
    """Return whether the process that made a folder has ended, or left it otherwise."""
    try:
        if time.time() - folder.stat().st_mtime < FRESH:
            return False
        with (folder / LOCK).open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True
