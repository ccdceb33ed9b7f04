"""Progress bars of long runs."""

import io
import time
from typing import ClassVar

import pytest
from rich.console import Console

from poinsot.display import progress


def test_a_display_that_begins_late_shows_what_was_reported_before(monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 0.2)
    written, until = io.StringIO(), time.monotonic() + 30
    with progress.bar("members", 40, True, Console(file=written, force_terminal=True, width=80)) as report:
        report(15)
        report(25)
        while not written.getvalue() and time.monotonic() < until:
            time.sleep(0.01)
    assert "40/40" in written.getvalue()


def written_within(monkeypatch, wanted, *, patience=30.0):
    """What a run of one report writes, and the report that it got."""
    monkeypatch.setattr(progress, "DELAY", patience)
    written = io.StringIO()
    with progress.bar("members", 40, wanted, Console(file=written, force_terminal=True, width=80)) as report:
        report(15)
    return written.getvalue(), report


def test_a_short_run_and_a_run_without_a_bar_show_nothing(monkeypatch):
    assert written_within(monkeypatch, True)[0] == ""
    assert written_within(monkeypatch, False, patience=0.0)[0] == ""


def test_a_part_of_a_longer_run_reports_to_the_function_of_the_run(monkeypatch):
    reports = []
    written, _ = written_within(monkeypatch, lambda more, part="": reports.append((more, part)), patience=0.0)
    assert (written, reports) == ("", [(15, "")])


def test_a_display_shows_the_part_in_place_of_the_rate(monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 0.01)
    written, until = io.StringIO(), time.monotonic() + 30
    with progress.bar("members", 4, True, Console(file=written, force_terminal=True, width=80)) as report:
        report(1, "forces")
        while "forces" not in written.getvalue() and time.monotonic() < until:
            time.sleep(0.01)
    assert "1/4, forces" in written.getvalue()


def test_a_display_ends_where_a_run_fails(monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 0.01)

    class Display:
        """Counts its starts and stops."""

        counts: ClassVar[list[str]] = []

        def start(self):
            self.counts.append("start")

        def stop(self):
            self.counts.append("stop")

    until = time.monotonic() + 30

    def run():
        with progress.later(Display) as shown:
            while not Display.counts and time.monotonic() < until:
                time.sleep(0.01)
            assert len(shown) == 1
            raise RuntimeError("failed")

    with pytest.raises(RuntimeError, match="failed"):
        run()
    assert Display.counts == ["start", "stop"]
