"""The history of the benchmarks: its format, and that it tells what has become worse."""

import datetime as dt

import pytest
from benchmarks import history, report, targets
from benchmarks.targets import Target


def results(date):
    return {"machine": {"date": date, "processor": "a processor"}}


def test_the_file_that_is_stored_has_a_number_a_bound_and_a_date_in_every_row():
    rows = history.read()
    assert len(rows) > 20
    for row in rows:
        assert tuple(row) == history.FIELDS
        assert all(row.values())
        assert row["limit"] in ("most", "least")
        assert float(row["value"]) >= 0 < float(row["bound"])
        assert history.stable(row["target"]) == row["target"]
    dates = [dt.date.fromisoformat(row["date"]) for row in rows]
    assert dates == sorted(dates)


@pytest.mark.parametrize(
    ("most", "then", "now", "worse"),
    [
        (True, 1.0, 1.3, True),
        (True, 1.0, 1.1, False),
        (True, 1.3, 1.0, False),
        (False, 9.0, 7.0, True),
        (False, 7.0, 9.0, False),
        (True, 0.0, 1e-9, True),
        (True, 1.0, None, False),
    ],
)
def test_a_run_is_appended_and_compared_with_the_last_one(tmp_path, monkeypatch, most, then, now, worse):
    path = tmp_path / "history.csv"
    messages = []
    for date, value in (("2026-11-20", 100.0 - most), ("2026-11-21", then), ("2026-11-22", now)):
        found = [Target(f"time (1 to {value} in 7 processes)", value, 2.0, most), Target("other", 5.0, 2.0, most)]
        monkeypatch.setattr(targets, "all_of", lambda _, found=found: found)
        messages.append(history.append(results(date), path))
    rows = history.read(path)
    assert [row["value"] for row in rows if row["target"] == "time"] == [
        f"{value:.4g}" for value in (100.0 - most, then, now) if value is not None
    ]
    assert len([row for row in rows if row["target"] == "other"]) == 3
    assert [" on 2026-11-21 at " in line for line in messages[-1]] == [True] * worse


def test_the_table_of_targets_shows_the_last_run_on_each_other_processor(monkeypatch):
    runs = [("2026-11-20", "this", 1), ("2026-11-20", "that", 2), ("2026-11-21", "that", 4), ("2026-11-21", "fast", 3)]
    rows = [{"date": date, "processor": name, "target": "time", "value": str(value)} for date, name, value in runs]
    monkeypatch.setattr(history, "read", lambda: rows)
    monkeypatch.setattr(targets, "all_of", lambda _: [Target("time (1 to 2 in 7 processes)", 2.0, 3.0, True, " ms")])
    machine = {"date": "2026-11-22", "processor": "this", "cores": 2, "system": "", "versions": {}}
    page = report.targets_page({"machine": machine, "short": False})
    assert "| what | target | reached |  | on that, 2026-11-21 | on fast, 2026-11-21 |" in page
    assert "| at most 3 ms | 2 ms | met | **4 ms** | 3 ms |" in page
