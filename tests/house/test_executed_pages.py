"""Every page of the documentation that is a notebook runs, its cells in order, in an empty folder."""

import re
import shlex
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from tools import frames
from typer.testing import CliRunner

from poinsot.cli import app

DOCS = Path(__file__).parents[2] / "docs"
CELL = re.compile(r"```\{code-cell\} ipython3\n((?::[^\n]*\n)*)(.*?)```", re.DOTALL)
OWN = [page for page in sorted(DOCS.rglob("*.md")) if not {"_build", "generated"} & {*page.relative_to(DOCS).parts}]
PAGES = [page for page in OWN if "{code-cell}" in page.read_text()]


def run(command):
    """Run what a notebook gives to the shell, `!poinsot ... 2>/dev/null`."""
    name, *arguments = shlex.split(command.removeprefix("!").removesuffix("2>/dev/null\n"))
    assert name == "poinsot"
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output


@pytest.mark.slow  # `make docs` runs all their cells
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_cells_of_a_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    names = {"__name__": "notebook"}
    for number, (options, code) in enumerate(CELL.findall(page.read_text())):
        if "slow" in options:  # they run when the site is built
            continue
        if code.startswith("!"):
            run(code)
        else:
            exec(compile(code, f"{page.name}, cell {number}", "exec", dont_inherit=True), names)
    plt.close("all")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_a_page_with_cells_says_its_kernel_and_checks_something(page):
    text = page.read_text()
    assert text.startswith("---\njupytext:\n")
    assert "name: python3" in text.split("---\n")[1]
    assert "assert " in text


def test_the_page_of_validation_has_every_oracle():
    oracles = {file.stem for file in (DOCS.parent / "tests" / "oracles").glob("test_*.py")}
    assert set(re.findall(r"`(test_\w+)` \|", (DOCS / "validation.md").read_text())) == oracles


def test_the_page_of_conventions_shows_every_figure_of_frames(tmp_path):
    frames.write(tmp_path)
    drawn = {file.name for file in tmp_path.iterdir()}
    page = (DOCS / "theory" / "conventions.md").read_text()
    assert drawn == set(re.findall(r"\(\.\./images/(frames-[\w-]+\.svg)\)", page))
    assert drawn == {file.name for file in (DOCS / "images").glob("frames-*")}
