"""The pages of the site: what they are made from, and, once `make docs` has built them, what they ask for and show."""

import re
from pathlib import Path

import pytest
from tools.site import api, gallery, names

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "_build" / "html"

REQUEST = re.compile(r"""<(?:script|img|iframe|link|source|video)\b[^>]*?(?:src|href|data)=["'](?:https?:)?//""")
STYLE_REQUEST = re.compile(r"""(?:url\(|@import\s)\s*["']?(?:https?:)?//""")
"""What loads something from elsewhere; links to other sites load nothing until they are followed."""


def test_every_example_is_in_one_group_of_the_gallery():
    grouped = [name for group in gallery.GROUPS.values() for name in group.split()]
    assert sorted(grouped) == sorted({path.stem for path in (ROOT / "examples").glob("*.[pt][yo]*")})


def test_every_name_of_the_root_is_in_one_group_of_the_api():
    grouped = [f"poinsot.{name}" for group in api.ROOT_GROUPS.values() for name in group.split()]
    assert sorted(grouped) == sorted(name for name in names.public() if name.count(".") == 1)


@pytest.mark.docs
def test_no_page_loads_anything_from_elsewhere():
    pages = list(SITE.rglob("*.html"))
    assert len(pages) > 100
    assert [str(page) for page in pages if REQUEST.search(page.read_text())] == []
    assert [str(sheet) for sheet in SITE.rglob("*.css") if STYLE_REQUEST.search(sheet.read_text())] == []
