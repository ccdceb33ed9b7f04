"""The table from formula to test names what exists, and leaves no kind out."""

import pkgutil
import re
from pathlib import Path

import pytest

import poinsot as pt
from kinds import concrete_subclasses
from poinsot.integration.formulations import Formulation
from poinsot.mechanics.part import Part
from poinsot.shapes.scattering import ScatteringLaw
from poinsot.shapes.shape import Shape

TESTS = Path(__file__).parents[1]
PAGE = (TESTS.parent / "docs" / "formulas.md").read_text()
ROWS = [line.split(" | ") for line in PAGE.splitlines() if line.startswith("| ") and "`" in line]


def named(column):
    return [name for row in ROWS for name in re.findall(r"`([^`]+)`", row[column])]


def test_every_row_has_a_function_a_test_and_a_judge():
    assert len(ROWS) > 50
    for row in ROWS:
        assert len(row) == 5, row[0]
        assert all(cell.strip("| ") for cell in row), row[0]
        assert all("`" in cell for cell in row[2:4]), row[0]


@pytest.mark.parametrize("name", sorted(set(named(2))))
def test_function_exists(name):
    assert pkgutil.resolve_name(f"poinsot.{name}").__doc__


@pytest.mark.parametrize("name", sorted(set(named(3))))
def test_test_exists(name):
    file, test = name.split("::")
    assert re.search(rf"^def {test}\(", (TESTS / f"{file}.py").read_text(), re.MULTILINE)


@pytest.mark.parametrize("kind", [pt.Potential, pt.Torque, Part, pt.Orbit, pt.Event, Shape, ScatteringLaw, Formulation])
def test_every_class_of_a_kind_is_named(kind):
    classes = {each.__qualname__ for each in concrete_subclasses(kind)}
    classes -= {"RecordedEvent"}  # of a file, without a formula
    assert classes <= {name.rpartition(".")[2] for name in named(2)}
