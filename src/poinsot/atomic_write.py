"""Files and folders that are written whole or not at all.

A writer works in a hidden folder next to the name that it is asked for, locks a file in it, and moves the result to the
name in the end. A process can be killed at any instant: the name then leads to the old result or to the new one, and
the next writer removes the hidden folder.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from poinsot import operating_system
from poinsot.printable import shortened

__all__ = ["exists", "new_file", "new_folder", "synced", "unwritable", "write_text"]

PART, LOCK = ".poinsot-{}.part", "lock"
"""The hidden folder of a writer, and the file in it that the writer has locked."""

BEFORE = "before"
"""The old folder in the hidden one, while a system that cannot exchange two names replaces it."""

LOCK_SECONDS = 60.0
"""Seconds in which a folder may wait for its lock."""

AT_FOLDER, EXCHANGE = -100, 2
"""AT_FDCWD and RENAME_EXCHANGE of Linux."""


@contextlib.contextmanager
def new_file(path: str | Path, overwrite: bool) -> Iterator[Path]:
    """Yield the path of a file to write, which is moved to `path` if no error occurs and removed otherwise.

    A symbolic link that is overwritten stays, and the file to which it leads is replaced.

    Raises
    ------
    FileNotFoundError, FileExistsError, IsADirectoryError
        If the folder does not exist, if `path` exists and must not be overwritten, or if `path` is a folder, a device
        or a pipe. `path` is also checked when the file is whole, so that nothing made meanwhile is replaced.
    OSError
        If the system cannot write the file: the disk is full, or the user may not write there.
    """
    path = _target(Path(path), overwrite)
    if path.is_dir():
        raise IsADirectoryError(f"{shortened(path)} must be the name of a file, got a folder.")
    if path.exists() and not path.is_file():
        raise FileExistsError(f"{shortened(path)} must be the name of a file, got a device, a pipe or a socket.")
    with _part(path, overwrite) as part:
        yield part
        synced(part)
        if overwrite:
            part.replace(path)
        else:
            _take_free_name(part, path)
        synced(path.parent)


@contextlib.contextmanager
def new_folder(path: Path, overwrite: bool, mark: str) -> Iterator[Path]:
    """Yield the path of a folder to make, as `new_file` does; replace only a folder with the file `mark`."""
    path = _target(path, overwrite)
    with _part(path, overwrite) as part:
        _check_mark(path, mark)
        yield part
        if overwrite and os.path.lexists(path):
            _check_mark(path, mark)
            _replace_folder(part, path)
        else:
            try:
                part.rename(path)  # fails if the name leads to a file, a link, or a folder that is not empty
            except OSError:
                _check_free(path)
                raise
        synced(path.parent)


def write_text(path: str | Path, text: str, overwrite: bool) -> Path:
    """Write a text in UTF-8, whole or not at all; return its path."""
    with new_file(path, overwrite) as part, part.open("x", encoding="utf-8", newline="\n") as stream:
        stream.write(text)
    return Path(path)


def synced(path: Path) -> None:
    """Flush a file, or the names in a folder, to the disk, where the file system supports it."""
    with contextlib.suppress(OSError):  # Windows opens no folder
        number = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def unwritable(path: Path | str, why: str) -> str:
    """Return the error message about a file that cannot be written."""
    return f"{shortened(path)} must be a file that can be written, but {why}."


# ---------------------------------------------------------------------- names


def _target(path: Path, overwrite: bool) -> Path:
    """Return the name to replace: of a symbolic link, the name to which it leads."""
    return Path(os.path.realpath(path)) if overwrite and path.is_symlink() else path


def _check_free(path: Path) -> None:
    """Raise a FileExistsError for a name that exists, also as a broken link."""
    if os.path.lexists(path):
        raise FileExistsError(f"{shortened(path)} already exists; overwrite=True replaces it.")


def _check_mark(path: Path, mark: str) -> None:
    """Raise an OSError if a store would replace a file or another folder."""
    if os.path.lexists(path) and not (path / mark).is_file():
        raise FileExistsError(f"{shortened(path)} must be a Zarr store to be replaced, got something else.")


def _take_free_name(part: Path, path: Path) -> None:
    """Move a file to a name, which the system refuses if the name exists."""
    try:
        os.link(part, path)
    except OSError:
        _check_free(path)
        os.close(os.open(path, os.O_CREAT | os.O_EXCL))  # a file system without hard links
        part.replace(path)


def _replace_folder(part: Path, path: Path) -> None:
    """Exchange two folders, in one step where the system can."""
    if _exchanged(part, path):
        return
    before = part.with_name(BEFORE)
    path.rename(before)
    try:
        part.rename(path)  # `_clean_up` finishes this step of a killed process
    except BaseException:
        before.rename(path)
        raise


def _exchanged(one: Path, other: Path) -> bool:
    """Exchange two names in one step; return False where the system cannot."""
    if sys.platform != "linux":
        return False
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    return rename is not None and rename(AT_FOLDER, bytes(one), AT_FOLDER, bytes(other), EXCHANGE) == 0


# ---------------------------------------------------------------------- hidden folders


@contextlib.contextmanager
def _part(path: Path, overwrite: bool) -> Iterator[Path]:
    """Yield a path in a new hidden folder, which stays locked meanwhile; clean up after killed writers before."""
    if not path.parent.is_dir():
        raise FileNotFoundError(f"No such folder: {shortened(path.parent)}")
    _clean_up(path.parent)
    if not overwrite:
        _check_free(path)
    folder = path.parent / PART.format(os.urandom(8).hex())
    try:
        folder.mkdir()
        with (folder / LOCK).open("x") as file:
            with contextlib.suppress(OSError):  # where a file system has no locks, no writer counts as killed
                operating_system.lock(file.fileno(), wait=True)
            yield folder / path.name
    except UnicodeEncodeError as error:
        why = f"its name contains characters beyond {error.encoding}. Set PYTHONUTF8=1 in the environment"
        raise ValueError(unwritable(path, why)) from error
    except OSError as error:
        if error.strerror is None:
            raise
        raise type(error)(unwritable(path, f"the operating system reported: {error.strerror}")) from error
    finally:
        _remove(folder)


def exists(path: Path) -> bool:
    """Return True if a path exists, after completing an unfinished replacement of it."""
    if not path.exists():
        _clean_up(path.parent)
    return path.exists()


def _clean_up(parent: Path) -> None:
    """Finish the replacements that killed writers began in a folder, and remove their hidden folders."""
    for folder in parent.glob(PART.format("*")):
        if _is_left(folder):
            for new in _unfinished(folder):
                if not os.path.lexists(parent / new.name):
                    with contextlib.suppress(OSError):  # another process finishes it
                        new.rename(parent / new.name)
            _remove(folder)


def _unfinished(folder: Path) -> list[Path]:
    """Return the new folder in a hidden one, if the old folder lies there, too."""
    try:
        names = {*os.listdir(folder)} - {LOCK}
    except OSError:
        return []
    return [folder / name for name in names - {BEFORE}] if BEFORE in names else []


def _remove(folder: Path) -> None:
    """Remove a hidden folder, unless its name leads neither to the old folder nor to the new one."""
    if not _unfinished(folder):
        shutil.rmtree(folder, ignore_errors=True)


def _is_left(folder: Path) -> bool:
    """Return True if the process that made a folder has ended or abandoned the folder."""
    try:
        had_lock = (folder / BEFORE).exists()
        if not had_lock and time.time() - folder.stat().st_mtime < LOCK_SECONDS:
            return False
        with (folder / LOCK).open("r+") as file:
            operating_system.lock(file.fileno())
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True
