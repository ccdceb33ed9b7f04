"""Each module has a test module of its name in the mirrored folder, or a row that names the test module covering it."""

import ast
import functools
import re
from pathlib import Path

import pytest
from tools.lines import import_graph, imported_modules
from tools.lines import modules as modules_in

from house.covered_elsewhere import COVERED_BY

TESTS = Path(__file__).parents[1]
SOURCE = TESTS.parent / "src" / "poinsot"
UNITS = sorted((TESTS / "unit").rglob("*.py"))
MODULES = sorted(str(path.relative_to(SOURCE)) for path in SOURCE.rglob("*.py") if not path.name.startswith("__"))


def unit_test(module):
    """Return the test module of the name of a module."""
    path = Path(module)
    return TESTS / "unit" / path.parent / f"test_{path.name}"


@pytest.mark.parametrize("path", UNITS, ids=lambda path: str(path.relative_to(TESTS)))
def test_every_unit_test_has_its_module(path):
    folder, module = path.parent.relative_to(TESTS / "unit"), path.stem.removeprefix("test_")
    assert path.stem.startswith("test_"), "what tests share lies at the top of tests/"
    assert (SOURCE / folder / f"{module}.py").is_file() or (SOURCE / folder / module).is_dir()


def test_every_module_has_a_unit_test_or_a_row():
    without = {module for module in MODULES if not unit_test(module).is_file()}
    assert without - COVERED_BY.keys() == set(), "write a unit test, or add rows to tests/house/covered_elsewhere.py"
    assert COVERED_BY.keys() - set(MODULES) == set(), "rows of modules that do not exist"
    assert COVERED_BY.keys() - without == set(), "rows of modules with a unit test of their name"
    assert [*COVERED_BY] == sorted(COVERED_BY)


@functools.cache
def package():
    """Return the imports of each module of the package, and the module of each public name that one module defines."""
    files, homes = modules_in(SOURCE), {}
    for module, path in files.items():
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, set()).add(module)
    return import_graph(files), homes


@functools.cache
def used_by(path):
    """Return the modules of the package that a test module imports or names, helpers of tests included."""
    graph, homes = package()
    text = path.read_text()
    helpers = modules_in(TESTS)
    known = {name.removeprefix("tests."): file for name, file in helpers.items()}
    used = imported_modules(text, "test", graph)
    used |= {module for word in set(re.findall(r"\w+", text)) for module in homes.get(word, ())}
    for name in imported_modules(text, "test", known):
        used |= used_by(known[name])
    return used


def reached(path):
    """Return the modules of the package that a test module uses, and their imports."""
    graph, _ = package()
    left, found = [*used_by(path)], set()
    while left:
        if (module := left.pop()) not in found:
            found.add(module)
            left += graph[module]
    return found


def test_a_covering_test_reaches_its_module():
    reach = {test: reached(TESTS / test) for test in set(COVERED_BY.values())}
    names = {module: "poinsot." + module.removesuffix(".py").replace("/", ".") for module in COVERED_BY}
    assert [module for module, test in COVERED_BY.items() if names[module] not in reach[test]] == []
