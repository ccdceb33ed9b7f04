"""Everything that the package returns pickles, is copied, and comes back equal to the last bit."""

import copy
import html
import inspect
import pickle
import re

import numpy as np
import pytest

import poinsot as pt
from kinds.results import DESCRIPTIONS, RESULTS, STATE, contents
from public_calls import (
    NOT_CALLED,
    PUBLIC,
)

COPIES = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "old pickle": lambda thing: pickle.loads(pickle.dumps(thing, protocol=0)),
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
}


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("name", RESULTS)
def test_what_comes_back_is_equal(tmp_path, name, way):
    thing = RESULTS[name](tmp_path)
    back = COPIES[way](thing)
    assert type(back) is type(thing)
    assert contents(back) == contents(thing)
    assert str(back) == str(thing)
    assert isinstance(back == thing, bool)  # not an error of numpy about the truth of arrays


@pytest.mark.parametrize("name", ["Trajectory", "closed form", "along an ellipse", "both ways, in quadruple precision"])
def test_dense_output_comes_back_with_its_polynomials(tmp_path, name):
    thing = RESULTS[name](tmp_path)
    times = np.linspace(thing.times[0], thing.times[-1], 101)
    again = COPIES["pickle"](COPIES["pickle"](thing))
    for back in (again, *(COPIES[way](thing) for way in ("pickle", "old pickle", "deepcopy"))):
        for part in STATE[1:]:
            np.testing.assert_array_equal(getattr(back(times), part), getattr(thing(times), part))


def test_a_copy_can_be_run_again():
    thing = RESULTS["own force"](None)
    back = COPIES["pickle"](thing)
    again = pt.propagate(back.system, back.initial, back.times)
    np.testing.assert_allclose(again.quaternion, thing.quaternion, rtol=0, atol=1e-14)  # dense output has other steps


def in_minutes(name, folder):
    """The same thing of a system that names its unit of time; None where there is none."""
    thing = copy.deepcopy(RESULTS[name](folder))
    thing = thing[0] if isinstance(thing, list) else thing
    for owner in (thing, getattr(thing, "motion", None), *getattr(thing, "motions", [])):
        for one in (owner, getattr(owner, "motion", None)):
            if hasattr(one, "system"):
                vars(one.system)["units"] = {"time": "min", "inertia": "kg m2"}
    return thing


@pytest.mark.parametrize("name", sorted(RESULTS.keys() - DESCRIPTIONS))
def test_a_result_is_summarised_in_a_few_lines_with_units(tmp_path, name):
    thing = in_minutes(name, tmp_path)
    if thing is None:
        pytest.skip("there is none")
    text = repr(thing)
    title, *lines = text.splitlines()
    assert 1 <= len(lines) < 14
    assert not re.search(r"[1-9](?:[.]?\d){8,}", text), text
    assert "object at 0x" not in text
    assert max(map(len, (title, *lines))) < 320
    known = any(hasattr(thing, owner) for owner in ("system", "motion", "motions"))
    assert bool(re.search(r"\bmin(-1)?\b", text)) == known, text
    assert all(re.match(r"  \S.*: \S", line) for line in lines), text


@pytest.mark.parametrize("name", sorted(RESULTS.keys() - DESCRIPTIONS))
def test_a_notebook_shows_the_lines_of_a_result_without_markup(tmp_path, name, monkeypatch):
    thing = in_minutes(name, tmp_path)
    if thing is None:
        pytest.skip("there is none")
    shown = [html.unescape(cell) for cell in re.findall(r">([^<>]+)<", thing._repr_html_().partition("<svg")[0])]
    title, *lines = repr(thing).splitlines()
    assert shown[0] == title
    assert [f"  {name}: {text}" for name, text in zip(shown[1::2], shown[2::2], strict=True)] == lines
    hostile = "<script>alert('&')</script>"
    monkeypatch.setattr(type(thing), "_summary", lambda _: (hostile, {hostile: hostile}))
    assert repr(thing) == f"{hostile}\n  {hostile}: {hostile}"
    assert html.unescape(thing._repr_html_()).count(hostile) == 3
    assert "<script" not in thing._repr_html_()


def test_every_result_is_among_them():
    results = {name for name in NOT_CALLED if inspect.isclass(PUBLIC.get(name))}
    bases = {
        "Event",
        "Frame",
        "Observable",
        "Orbit",
        "Part",
        "Potential",
        "Shape",
        "Torque",
        "Attitude",
        "AttitudeFormat",
    }
    bases |= {"Atmosphere", "Jump", "TabulatedAtmosphere"}
    bases |= {"Environment", "Instant", "Load", "PairInstant", "PairLoad", "Vector"}
    assert results - bases <= RESULTS.keys()
