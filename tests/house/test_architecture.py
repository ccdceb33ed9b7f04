"""The pages for developers name modules and tests that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "CONTRIBUTING.md", ROOT / "docs" / "architecture.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_of_a_page_exist(page):
    paths = re.findall(r"`([\w/]+/(?:[\w.]+\.(?:py|md|csv))?)`", page.read_text())
    assert len(paths) > 5
    missing = [path for path in paths if not any((start / path).exists() for start in (ROOT, ROOT / "src" / "poinsot"))]
    assert missing == []


def test_at_most_ten_modules_make_a_kernel():
    text = PAGES[1].read_text()
    section = text.split("## Modules to know before changing how a kernel is built")[1].split("\n## ")[0]
    assert 5 < len(re.findall(r"`[\w/]+\.py`", section)) <= 10
