import io
import time

from rich.console import Console

from poinsot.display import progress


def test_a_display_that_begins_late_shows_what_was_reported_before(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.2)
    written, until = io.StringIO(), time.monotonic() + 30
    with progress.bar("members", 40, True, Console(file=written, force_terminal=True, width=80)) as report:
        report(15)
        report(25)
        while not written.getvalue() and time.monotonic() < until:
            time.sleep(0.01)
    assert "40/40" in written.getvalue()
