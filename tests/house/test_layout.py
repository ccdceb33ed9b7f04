"""The tests of units lie as the source does."""

from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
SOURCE = TESTS.parent / "src" / "poinsot"
UNITS = sorted((TESTS / "unit").rglob("*.py"))


@pytest.mark.parametrize("path", UNITS, ids=lambda path: str(path.relative_to(TESTS)))
def test_every_unit_test_has_its_module(path):
    folder, module = path.parent.relative_to(TESTS / "unit"), path.stem.removeprefix("test_")
    assert path.stem.startswith("test_"), "what tests share lies at the top of tests/"
    assert (SOURCE / folder / f"{module}.py").is_file() or (SOURCE / folder / module).is_dir()
