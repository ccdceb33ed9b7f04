"""`poinsot verify` finds an installation right that is, and wrong that is not."""

import functools
import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import poinsot as pt
from poinsot.analysis import period_map, periodic
from poinsot.cli import app
from poinsot.validation import cases

CASES = {case.title: case for case in cases.CASES}
CHEAP = tuple(
    CASES[title] for title in ("Tumbling brick", "4179 Toutatis", "Gravity gradient in orbit", "Fast heavy top")
)
WIDE = {"COLUMNS": "200"}


LONG = "Two binary asteroids"


def marked(cases):
    """The long one has its turn with `-m slow`, and when `make package` runs the command."""
    return [pytest.param(one, marks=[pytest.mark.slow] * (one.title == LONG), id=one.title) for one in cases]


def run(monkeypatch, chosen):
    monkeypatch.setattr(cases, "CASES", tuple(chosen))
    return CliRunner().invoke(app, ["verify"], env=WIDE)


@pytest.mark.samples
@pytest.mark.parametrize("case", marked(cases.CASES))
def test_case_holds(case):
    rows = cases.comparisons_of(case)
    assert rows
    assert [row for row in rows if not row.holds] == []


def test_command_prints_every_comparison_without_escape_codes(monkeypatch):
    result = run(monkeypatch, CHEAP)
    assert result.exit_code == 0, result.output
    for case in CHEAP:
        assert case.title in result.output
        assert case.source in result.output
        assert all(row.quantity in result.output for row in cases.comparisons_of(case))
    assert "All 13 comparisons hold." in result.output
    assert "llvmlite" in result.output
    assert "FAILED" not in result.output
    assert "\x1b" not in result.output


def test_json_has_every_comparison(monkeypatch):
    monkeypatch.setattr(cases, "CASES", CHEAP)
    output_text = json.loads(CliRunner().invoke(app, ["verify", "--json"]).stdout)
    assert [case["title"] for case in output_text["cases"]] == [case.title for case in CHEAP]
    compared = [one for case in output_text["cases"] for one in case["comparisons"]]
    assert len(compared) == 13
    assert all(one["holds"] and one["difference"] <= one["tolerance"] for one in compared)
    assert "llvmlite" in output_text["installation"]


@pytest.mark.parametrize(
    ("name", "case", "broken"),
    [
        ("TOUTATIS_ROTATION", "4179 Toutatis", 2),  # integrated and in closed form
        ("JEOD_RATE", "Gravity gradient in orbit", 1),
        ("TOP_QUATERNION_EXACT", "Fast heavy top", 1),
    ],
)
def test_one_wrong_number_fails(monkeypatch, name, case, broken):
    monkeypatch.setattr(cases, name, np.asarray(getattr(cases, name)) * (1 + 2e-12))
    result = run(monkeypatch, [CASES[case]])
    assert result.exit_code == 1, result.output
    assert result.output.count("FAILED") == broken
    assert f"{broken} of 4 comparisons fail." in result.output or f"{broken} of 3 comparisons fail." in result.output


def test_case_that_does_not_run_fails_and_says_why(monkeypatch):
    def broken():
        raise OSError("libllvm.so [x]: cannot open shared object file")

    result = run(monkeypatch, [cases.Case("Broken", "nowhere", broken), CASES["4179 Toutatis"]])
    assert result.exit_code == 1
    assert "stopped by OSError: libllvm.so [x]: cannot open shared object file" in result.output
    assert "1 of 5 comparisons fail." in result.output


def test_difference_that_is_not_a_number_does_not_hold():
    assert not cases.Comparison("", np.nan, 1.0).holds
    assert not cases.Comparison("", np.inf, 1.0).holds
    assert cases.Comparison("", 0.0, 0.0).holds


def failing(case):
    return {row.quantity for row in cases.comparisons_of(case) if not row.holds}


INTEGRATIONS = [case for case in cases.CASES if case.title not in ("Chaos of Hyperion", "Dzhanibekov flip", "File")]


@pytest.mark.samples
@pytest.mark.parametrize("case", marked(INTEGRATIONS))
def test_careless_integrator_is_noticed(monkeypatch, case):
    right, transition = pt.propagate, pt.analysis.state_transition
    # The published rates of the brick have ten digits, and g has no part in the drift of q; others are exact.
    tolerance = 1e-8 if case.title == "Tumbling brick" else 1e-11

    def careless(system, state, times, **options):
        if options.get("precision", "double") == "double":
            options["tolerance"] = tolerance
        return right(system, state, times, **options)

    for module in (cases, periodic):
        monkeypatch.setattr(module, "propagate", careless)
    monkeypatch.setattr(period_map, "state_transition", functools.partial(transition, tolerance=tolerance))
    assert failing(case)


@pytest.mark.parametrize("title", ["The paper's three problems", "Jacobi's elliptic functions"])
def test_late_closed_form_is_noticed(monkeypatch, title):
    right = pt.free_motion
    monkeypatch.setattr(cases, "free_motion", lambda body, state, t: right(body, state, np.asarray(t) * (1 + 1e-14)))
    assert {quantity.rpartition(", ")[2] for quantity in failing(CASES[title])} == {cases.CLOSED_FORM}


@pytest.mark.slow
def test_whole_command_in_a_pipe():
    code = "from poinsot.cli import app; app()"
    result = subprocess.run(
        [sys.executable, "-c", code, "verify"], capture_output=True, text=True, timeout=600, check=True
    )
    assert all(case.title in result.stdout for case in cases.CASES)
    assert "\x1b" not in result.stdout
    assert result.stderr == ""
