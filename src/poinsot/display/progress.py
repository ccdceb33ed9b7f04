"""What a terminal shows of something that lasts."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any, Protocol

from typing_extensions import override

__all__ = ["Progress", "Report", "bar", "later"]

PATIENCE = 0.5
"""Seconds before it is shown."""


class Report(Protocol):
    """What is told of a run: how much more is done, and what is done next."""

    def __call__(self, more: float, part: str = "") -> None:
        """Tell it."""


Progress = bool | Report
"""Whether a run is shown, or what it reports to as a part of a longer one."""


def bar(what: str, total: float, wanted: Progress, console: Any = None) -> AbstractContextManager[Report]:
    """Show how much of a run is done, its rate or its part, and the time left, if it is wanted; give what reports."""
    if callable(wanted):
        return nullcontext(wanted)
    return _shown(what, total, console) if wanted else HIDDEN


@contextmanager
def _shown(what: str, total: float, console: Any) -> Iterator[Report]:
    lock, done, told, began = threading.Lock(), 0.0, "", clock.perf_counter()

    def begun() -> Any:
        from rich.console import Console, RenderableType
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        class Display(Progress):
            """Shows the last report, also one that came before it began."""

            @override
            def get_renderables(self) -> Iterable[RenderableType]:
                for task in self.task_ids:
                    self.update(task, completed=done, told=told)
                return super().get_renderables()

        columns = (TextColumn(what), BarColumn(20), TextColumn("{task.fields[told]}"), TimeRemainingColumn())
        display = Display(*columns, console=console or Console(stderr=True), transient=True)
        display.add_task("", total=total, told="")
        return display

    def report(more: float, part: str = "") -> None:
        nonlocal done, told
        with lock:
            done += more
            told = f"{done:.6g}/{total:.6g}, {part or f'{done / (clock.perf_counter() - began):.3g}/s'}"

    with later(begun):
        yield report


def _nothing(more: float, part: str = "") -> None:
    """Show nothing."""


HIDDEN = nullcontext(_nothing)


@contextmanager
def later(begun: Callable[[], Any]) -> Iterator[list[Any]]:
    """Show a progress display of rich if the run lasts; give a list that has it from then on."""
    shown: list[Any] = []

    def show() -> None:
        shown.append(begun())
        shown[0].start()

    timer = threading.Timer(PATIENCE, show)
    timer.daemon = True
    timer.start()
    try:
        yield shown
    finally:
        timer.cancel()
        timer.join()
        for progress in shown:
            progress.stop()
