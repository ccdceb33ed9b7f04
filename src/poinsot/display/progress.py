"""Progress bars of long runs on a terminal."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Protocol

from typing_extensions import override

if TYPE_CHECKING:
    from rich import progress as rich_progress
    from rich.console import Console, RenderableType

__all__ = ["Progress", "ReportProgress", "bar", "later"]

DELAY = 0.5
"""Seconds after which a progress bar appears."""


class ReportProgress(Protocol):
    """Function that receives the progress of a run."""

    def __call__(self, more: float, part: str = "") -> None:
        """Add an amount to the part of the run that is done, and name the next part, if it has a name."""


Progress = bool | ReportProgress
"""True to show a progress bar, or the function that receives the progress as a part of a longer run."""


def bar(
    name: str, total: float, shown: Progress, console: Console | None = None
) -> AbstractContextManager[ReportProgress]:
    """Return a context in which a progress bar shows the completed amount, rate or part, and remaining time.

    Parameters
    ----------
    name : str
        Name of the counted quantity.
    total : float
        Amount of the whole run.
    shown : bool or ReportProgress
        True to show the bar. A function receives the progress in its place.
    console : Console, optional
        Default: the standard error.
    """
    if callable(shown):
        return nullcontext(shown)
    return _display(name, total, console) if shown else HIDDEN


@contextmanager
def _display(name: str, total: float, console: Console | None) -> Iterator[ReportProgress]:
    lock, done, text, start = threading.Lock(), 0.0, "", clock.perf_counter()

    def started() -> rich_progress.Progress:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        class Display(Progress):
            """Progress bar that shows the last report, also a report that came before the bar appeared."""

            @override
            def get_renderables(self) -> Iterable[RenderableType]:
                for task in self.task_ids:
                    self.update(task, completed=done, text=text)
                return super().get_renderables()

        columns = (TextColumn(name), BarColumn(20), TextColumn("{task.fields[text]}"), TimeRemainingColumn())
        display = Display(*columns, console=console or Console(stderr=True), transient=True)
        display.add_task("", total=total, text="")
        return display

    def report(more: float, part: str = "") -> None:
        nonlocal done, text
        with lock:
            done += more
            text = f"{done:.6g}/{total:.6g}, {part or f'{done / (clock.perf_counter() - start):.3g}/s'}"

    with later(started):
        yield report


def _nothing(more: float, part: str = "") -> None:
    """Show nothing."""


HIDDEN = nullcontext(_nothing)


@contextmanager
def later(started: Callable[[], rich_progress.Progress]) -> Iterator[list[rich_progress.Progress]]:
    """Show a progress display if the run takes longer than `PATIENCE`.

    The context yields a list, which contains the display from then on.
    """
    shown: list[rich_progress.Progress] = []

    def show() -> None:
        shown.append(started())
        shown[0].start()

    timer = threading.Timer(DELAY, show)
    timer.daemon = True
    timer.start()
    try:
        yield shown
    finally:
        timer.cancel()
        timer.join()
        for progress in shown:
            progress.stop()
