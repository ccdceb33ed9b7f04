"""Errors that the package raises on purpose, and a limit of the time until they come."""

import contextlib
import linecache
import signal
import traceback
from pathlib import Path

import poinsot as pt

PACKAGE = str(Path(pt.__file__).parent)
PATIENCE = 20.0
"""Seconds after which a call hangs."""


def is_ours(error):
    """Whether an error is a sentence of the package, or the system's about a file that it names."""
    if isinstance(error, OSError) and error.filename is not None:
        return True
    frames = traceback.extract_tb(error.__traceback__)
    line = linecache.getline(frames[-1].filename, frames[-1].lineno).strip()
    return frames[-1].filename.startswith(PACKAGE) and line.startswith("raise ") and bool(str(error))


@contextlib.contextmanager
def patience():
    def stop(*_):
        raise RuntimeError(f"it takes longer than {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
