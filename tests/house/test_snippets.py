"""Every Python snippet in README and docs runs, in order: in an empty folder, and again where it has left files.

A comment behind a `print` has the numbers that it prints.
"""

import functools
import io
import operator
import re
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt

ROOT = Path(__file__).parents[2]
PAGES_OF_DOCS = sorted(
    page
    for page in (ROOT / "docs").rglob("*.md")
    if not {"_build", "_static", "generated"} & set(page.relative_to(ROOT).parts)
)
PAGES = [page for page in (ROOT / "README.md", *PAGES_OF_DOCS) if "```python" in page.read_text()]


@pytest.mark.parametrize(
    "page", [PAGES[0], *(pytest.param(page, marks=pytest.mark.docs) for page in PAGES[1:])], ids=lambda page: page.name
)
def test_snippets_of_a_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    snippets_of(page)
    if any(path.suffix != ".png" for path in tmp_path.iterdir()):
        snippets_of(page)


def snippets_of(page):
    names: dict[str, Any] = {"__name__": "snippet"}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)):
        printed = defaultdict(str)
        names["print"] = functools.partial(printed_by_line, printed)
        exec(compile(code, f"{page.name}, snippet {number}", "exec", dont_inherit=True), names)
        lines = code.splitlines()
        for line, text in printed.items():
            assert not missing_numbers(lines[line - 1].rpartition("  # ")[2], text), f"{lines[line - 1]}\n{text}"
    plt.close("all")


def printed_by_line(printed, *values):
    """Print, and keep what the line of the snippet has printed so far."""
    text = io.StringIO()
    print(*values, file=text)
    print(text.getvalue(), end="")
    printed[sys._getframe(1).f_lineno] += text.getvalue()


DECIMAL = r"(?<![(\d.:\w-])-?\d+\.\d+(?:e-?\d+)?(?![\d:])"


def missing_numbers(comment, text):
    """Return the decimal numbers of a comment that are not in a text, up to a unit of the last digit."""
    found = np.array([float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", text)])
    missing = []
    for said in re.findall(DECIMAL, comment):
        digits, _, power = said.partition("e")
        unit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
        if not np.any(np.abs(found - float(said)) < unit):
            missing.append(said)
    return missing


def test_numbers_that_are_not_printed_are_noticed():
    assert missing_numbers("3.33 arcmin, and 8.0e-5", "[3.3258 8.003e-05]") == []
    assert missing_numbers("0.9767... of 1.2", "0.976753") == ["1.2"]
    assert missing_numbers("at t = 2.22689, by Contact", "ended: at t = 2.87299, by Contact") == ["2.22689"]
    assert missing_numbers("2000-06-28T12:00:00.000, and 24 of them, exp(-0.1)", "") == []


def test_links_between_pages_lead_somewhere():
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *PAGES_OF_DOCS):
        for target, anchor in re.findall(r"\]\((?!http)([^)#]*)#?([^)]*)\)", page.read_text()):
            found = page.parent / target if target else page
            if "generated" in found.parts:
                continue  # `make docs` makes these, and judges links to them
            assert found.exists(), f"{page.name} links to {target}"
            headings = re.findall(r"^#+ (.*)$", found.read_text(), re.MULTILINE) if anchor else []
            slugs = {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}
            assert {anchor} - {""} <= slugs, f"{page.name} links to {target}#{anchor}"


def test_every_page_of_the_docs_is_in_one_table_of_contents():
    docs = ROOT / "docs"
    pages = {page.relative_to(docs).with_suffix("").as_posix() for page in PAGES_OF_DOCS} - {"index"}
    listed = [
        (page.parent / line).relative_to(docs).as_posix()
        for page in PAGES_OF_DOCS
        for table in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(), re.DOTALL)
        for line in table.splitlines()
        if re.fullmatch(r"[\w/-]+", line)
    ]
    assert sorted(name for name in listed if not name.startswith("generated/")) == sorted(pages)


def test_pages_with_code_lead_on_to_others():
    for page in PAGES_OF_DOCS:
        if "import poinsot" in page.read_text() and page.name != "index.md":
            _, _, last = page.read_text().rpartition("\nSee also: ")
            assert len(re.findall(r"\]\([^)]+\.md", last)) >= 2, page.name


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES_OF_DOCS], ids=lambda page: page.name)
def test_names_of_the_package_on_a_page_exist(page):
    for name in set(re.findall(r"\bpt\.([A-Za-z_][\w.]*\w)", page.read_text())):
        operator.attrgetter(name)(pt)
