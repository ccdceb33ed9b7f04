"""What a terminal shows of a run that lasts."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["bar"]

PATIENCE = 0.5
"""Seconds before a run is shown."""


@contextmanager
def bar(what: str, total: float, wanted: bool) -> Iterator[Callable[[float], None]]:
    """Show how much of a run is done, at which rate, and the time left, if it is wanted; give what reports more."""
    if not wanted:
        yield lambda _: None
        return
    shown: list[Any] = []
    lock, done, began = threading.Lock(), [0.0], [0.0]
    timer = threading.Timer(PATIENCE, lambda: shown.append(_started(what, total)))
    timer.daemon = True
    timer.start()

    def report(more: float) -> None:
        with lock:
            began[0] = began[0] or clock.perf_counter()
            done[0] += more
            if shown:
                rate = done[0] / max(clock.perf_counter() - began[0], 1e-9)
                told = f"{done[0]:.6g}/{total:.6g}, {rate:.3g}/s"
                shown[0].update(shown[0].task_ids[0], completed=done[0], told=told)

    try:
        yield report
    finally:
        timer.cancel()
        timer.join()
        for progress in shown:
            progress.stop()


def _started(what: str, total: float) -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), TextColumn("{task.fields[told]}"), TimeRemainingColumn())
    progress = Progress(*columns, console=Console(stderr=True), transient=True)
    progress.add_task("", total=total, told="")
    progress.start()
    return progress
