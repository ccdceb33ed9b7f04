"""Lease of a folder for one writer: a lock on one machine, and a renewed file between machines."""

from __future__ import annotations

import contextlib
import json
import os
import platform
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from poinsot.operating_system import REGULAR_FILE, lock
from poinsot.printable import shortened

__all__ = ["LEASE_SECONDS", "Lease", "lease"]

NAME = "lock"

LEASE_SECONDS = 60.0
"""Duration of a lease in seconds. A lease that is not renewed ends: its owner was killed on another machine."""

RENEWALS_PER_LEASE = 4
"""Number of renewals of a lease in its duration."""


@contextlib.contextmanager
def lease(folder: Path) -> Iterator[Lease]:
    """Hold the lease of a folder; raise a ValueError that names another owner."""
    held = Lease(folder / NAME)
    try:
        held.take()
        yield held
    finally:
        held.close()


class Lease:
    """Exclusive right to write into a folder.

    On one machine the kernel keeps it, which ends it with its process. On a file system that others share it is the
    text in the file and the time of its last change.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._mine, self._ended = path, False, threading.Event()
        self._token = {"host": platform.node(), "process": os.getpid(), "token": os.urandom(8).hex()}
        self._renewing = threading.Thread(target=self._renew, daemon=True)
        self._number = self._opened()

    def _opened(self) -> int:
        return os.open(self._path, os.O_RDWR | os.O_CREAT | REGULAR_FILE, 0o666)

    def take(self) -> None:
        """Take the lease; raise a ValueError if another run has it."""
        while not self._lock():
            os.close(self._number)
            self._number = self._opened()
        owner = self._owner()
        if owner.get("host", self._token["host"]) != self._token["host"] and self._age() < LEASE_SECONDS:
            self._refuse(owner)
        self._mine = True
        os.ftruncate(self._number, 0)
        os.lseek(self._number, 0, os.SEEK_SET)
        os.write(self._number, json.dumps(self._token).encode())
        self._renewing.start()

    def _lock(self) -> bool:
        """Lock the file; return True if it still has its name, which the last owner may have removed."""
        try:
            lock(self._number)
        except BlockingIOError:
            self._refuse(self._owner())
        except OSError:  # a file system without locks: the lease alone counts
            pass
        try:
            return os.path.samestat(os.stat(self._path), os.fstat(self._number))
        except FileNotFoundError:
            return False

    def check(self) -> None:
        """Raise a ValueError if another run has taken the lease, which this run did not renew in time."""
        owner = self._named()
        if owner.get("token") != self._token["token"]:
            self._refuse(owner)

    def _named(self) -> dict[str, str | int]:
        """Return the owner in the file with the name of the lease."""
        try:
            return _owner_in(self._path.read_bytes())
        except OSError:
            return {}

    def close(self) -> None:
        """End the lease and remove its file."""
        self._ended.set()
        if self._mine:
            self._renewing.join()
            if self._named().get("token") == self._token["token"]:
                self._remove()
        os.close(self._number)

    def _remove(self) -> None:
        try:
            self._path.unlink(missing_ok=True)
        except PermissionError:  # Windows removes no open file; the next owner may have opened it
            os.close(self._number)
            self._number = os.open(os.devnull, os.O_RDONLY)
            with contextlib.suppress(OSError):
                self._path.unlink()

    def _renew(self) -> None:
        while not self._ended.wait(LEASE_SECONDS / RENEWALS_PER_LEASE):
            with contextlib.suppress(OSError):
                os.utime(self._number if os.utime in os.supports_fd else self._path)

    def _owner(self) -> dict[str, str | int]:
        """Return the owner in the open file."""
        os.lseek(self._number, 0, os.SEEK_SET)
        return _owner_in(os.read(self._number, 1000))

    def _age(self) -> float:
        """Return the seconds since the lease was renewed, by the clock of the file system."""
        probe = self._path.with_name(f"{NAME}.{self._token['token']}.part")
        with probe.open("wb") as file:  # the owner may remove it at once, as what a killed run left
            now = os.fstat(file.fileno()).st_mtime
        probe.unlink(missing_ok=True)
        return now - os.fstat(self._number).st_mtime

    def _refuse(self, owner: dict[str, str | int]) -> NoReturn:
        who = f"process {owner.get('process', '?')} on {str(owner.get('host', '?'))[:60]}"
        raise ValueError(
            f"out must be a store that no other run writes, got {shortened(self._path.parent)}, which {who} writes."
        )


def _owner_in(content: bytes) -> dict[str, str | int]:
    with contextlib.suppress(ValueError):
        owner = json.loads(content)
        if isinstance(owner, dict):
            return owner
    return {}
