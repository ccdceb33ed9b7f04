"""Every Python snippet in README and docs runs, in order: in an empty folder, and again where it has left files."""

import operator
import re
from pathlib import Path

import matplotlib as mpl
import pytest
from tools.snippets import missing_numbers, run_page

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
    run_page(page)
    if any(path.suffix != ".png" for path in tmp_path.iterdir()):
        run_page(page)


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
