"""The history of the benchmarks: its format, and that it tells what has become worse."""

import datetime as dt

import pytest
from benchmarks import history, targets
from benchmarks.targets import Target


def results(date):
    return {"machine": {"date": date, "processor": "a processor"}}


def test_the_file_that_is_kept_has_a_number_a_bound_and_a_date_in_every_row():
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
    said = []
    for date, value in (("2026-11-20", 100.0 - most), ("2026-11-21", then), ("2026-11-22", now)):
        found = [Target(f"time (1 to {value} in 7 processes)", value, 2.0, most), Target("other", 5.0, 2.0, most)]
        monkeypatch.setattr(targets, "all_of", lambda _, found=found: found)
        said.append(history.append(results(date), path))
    rows = history.read(path)
    assert [row["value"] for row in rows if row["target"] == "time"] == [
        f"{value:.4g}" for value in (100.0 - most, then, now) if value is not None
    ]
    assert len([row for row in rows if row["target"] == "other"]) == 3
    assert [" on 2026-11-21 at " in line for line in said[-1]] == [True] * worse
