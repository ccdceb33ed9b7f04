"""Calls on open files that differ between operating systems."""

from __future__ import annotations

import errno
import os

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]
try:
    import msvcrt
except ImportError:
    msvcrt = None  # type: ignore[assignment]

__all__ = ["BINARY", "REGULAR_FILE", "lock"]

BINARY: int = getattr(os, "O_BINARY", 0)
"""Flag of `os.open` without which Windows changes the ends of lines."""

REGULAR_FILE: int = BINARY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Flags of `os.open` that follow no symbolic link and wait for no other process, where the system has such flags."""

LOCKED_BYTE = 2**40
"""Position of the byte that represents the file in locks of Windows, which keep other processes from reading it."""


def lock(number: int, *, wait: bool = False) -> None:
    """Lock an open file until it is closed or its process ends.

    Raises
    ------
    BlockingIOError
        If another process has locked it; with `wait` the call waits instead (on Windows ten seconds).
    OSError
        If the system, or the file system, has no locks.
    """
    if fcntl is not None:
        fcntl.flock(number, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        return
    if msvcrt is None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))
    before = os.lseek(number, 0, os.SEEK_CUR)
    os.lseek(number, LOCKED_BYTE, os.SEEK_SET)
    try:
        kind = msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK
        msvcrt.locking(number, kind, 1)
    except OSError as error:
        if error.errno not in (errno.EACCES, errno.EDEADLK):
            raise
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)) from error
    finally:
        os.lseek(number, before, os.SEEK_SET)
