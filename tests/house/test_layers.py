"""Imports go downwards and in no circle, those of TYPE_CHECKING and inside functions included."""

import tomllib
from pathlib import Path

from tools.lines import import_graph, modules

from imports import circles, place_of, set_elsewhere, upward

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def contracts():
    """Return the contracts on imports by their names."""
    rows = tomllib.loads(PROJECT.read_text())["tool"]["importlinter"]["contracts"]
    return {row["name"]: row for row in rows}


def layers():
    """Return the layers of the project, the uppermost first; modules of one layer stand side by side."""
    return [[name.strip() for name in row.split("|")] for row in contracts()["imports go down"]["layers"]]


def test_no_circle_of_imports():
    assert circles(import_graph(modules())) == []


def test_no_import_goes_up():
    assert upward(import_graph(modules()), layers()) == []


def test_every_module_is_in_a_layer():
    outside = [name for name in modules() if place_of(name, layers()) is None]
    assert outside == ["poinsot", "poinsot.__main__"]


def test_every_package_imports_the_compiler_by_one_rule():
    """Packages above the bridge and below it have a contract each; `integration` and `cuda` import any module."""
    names = [name for row in layers() for name in row]
    bridge, compiler = names.index("poinsot.integration"), names.index("poinsot.taylor")
    above = contracts()["results and analyses reach the compiler through integration alone"]
    below = contracts()["descriptions import the graph of formulas alone"]
    assert sorted(above["source_modules"]) == sorted(set(names[:bridge]) - {"poinsot.cuda"})
    assert sorted(below["source_modules"]) == sorted(names[bridge + 1 : compiler])
    for contract in (above, below):
        assert contract["forbidden_modules"] == ["poinsot.taylor"]


def test_no_module_sets_a_global_of_another_one():
    found = {name: [*set_elsewhere(path.read_text())] for name, path in modules().items()}
    assert {name: names for name, names in found.items() if names} == {}
