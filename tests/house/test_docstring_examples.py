"""The examples in the docstrings of public names and of their methods run, and say what they print."""

import doctest
import importlib
import inspect
import re
import shutil

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from tools.site import names
from tools.site.api import ANNOTATIONS

import poinsot as pt
from public_calls import files, pair_motion

UNITS = {"time": "s", "inertia": "kg m2"}
BODY = pt.Body((1.25, 1.0, 0.75))
MOTION = pt.propagate(
    pt.System(BODY, units=UNITS), BODY.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.2)), np.linspace(0, 20, 201)
)
"""What `motion` stands for in the examples of the plots."""
PAIR_MOTION = pair_motion()

PLOTS = {f"plot.{name}": getattr(pt.plot, name) for name in pt.plot.__all__}
NAMESPACES = [importlib.import_module(f"poinsot.{name}") for name in names.NAMESPACES]
NAMES = {f"{space.__name__}.{name}": getattr(space, name) for space in (pt, *NAMESPACES) for name in space.__all__}
CALLABLE = {name: thing for name, thing in NAMES.items() if inspect.isclass(thing) or inspect.isfunction(thing)}
"""Neither namespaces nor annotations, whose text is on the site."""

GIVEN = {"np": np, "pt": pt, "motion": MOTION, "pair_motion": PAIR_MOTION}
FINDER = doctest.DocTestFinder(exclude_empty=True)
EXAMPLES = {
    test.name: test
    for name, thing in {**CALLABLE, "functions": pt.functions}.items()
    for test in FINDER.find(thing, name, module=False, globs=GIVEN)
    if test.examples
} | {name: doctest.DocTestParser().get_doctest(text, GIVEN, name, None, None) for name, text in ANNOTATIONS.items()}


FIRST_WORDS = [
    "What",
    "Whether",
    "That",
    "Those",
    "These",
    "Which",
    "How",
    "When",
    "Where",
    "Of",
    "It",
    "Its",
    "In",
    "On",
    "By",
    "As",
    "Give",
    "Say",
    "Tell",
]
PRIVATE_WORDS = [
    "told",
    "tell",
    "tells",
    "say",
    "says",
    "said",
    "judge",
    "judges",
    "judged",
    "film",
    "films",
    "kept",
    "worlds",
]


def test_public_docstrings_begin_with_a_noun_or_a_verb_and_use_public_words():
    found = {test.name: test.docstring for test in finder_of_all()}
    assert len(found) > 400
    first = {name: text.split("\n")[0].split()[:2] for name, text in found.items() if text.strip()}
    assert [name for name, words in first.items() if words[0] in FIRST_WORDS] == []
    assert [
        name
        for name, words in first.items()
        if words[0] == "Return" and words[-1].title() in ("What", "That", "Whether")
    ] == []
    words = {name: set(re.findall(r"[a-z]+", text)) & set(PRIVATE_WORDS) for name, text in found.items()}
    assert {name: used for name, used in words.items() if used} == {}


def finder_of_all():
    """Return a test for each docstring of public names and of their methods, examples or not."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = [test for name, thing in CALLABLE.items() for test in finder.find(thing, name, module=False, globs={})]
    return [test for test in found if "._" not in test.name]


def test_every_public_name_has_an_example():
    assert not [name for name in CALLABLE if name not in EXAMPLES]
    others = {name for name, thing in NAMES.items() if not inspect.ismodule(thing)} - CALLABLE.keys()
    assert {name.rpartition(".")[2] for name in others} == set(ANNOTATIONS)
    assert all(EXAMPLES[name].examples for name in ANNOTATIONS)
    assert "functions" in EXAMPLES


@pytest.mark.parametrize("name", PLOTS)
def test_every_argument_of_a_plot_is_documented(name):
    described, _, _ = PLOTS[name].__doc__.partition("\nReturns\n")
    listed = [part for line in described.splitlines() if " : " in line for part in line.partition(" : ")[0].split(", ")]
    assert sorted(listed) == sorted(inspect.signature(PLOTS[name]).parameters)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With files of each kind, in which examples run that read or write one."""
    path = tmp_path_factory.mktemp("examples")
    files(path)
    return path


@pytest.mark.samples
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_prints_what_it_says(name, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(shutil.copytree(folder, tmp_path, dirs_exist_ok=True))
    mpl.use("Agg")
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    stated: list[str] = []
    assert runner.run(EXAMPLES[name], out=stated.append, clear_globs=False).failed == 0, "".join(stated)
    plt.close("all")
