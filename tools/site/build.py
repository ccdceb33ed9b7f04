"""Write the pages of the site that follow from the package, into docs/generated."""

from __future__ import annotations

import re
from pathlib import Path

from tools.site import api, gallery, scenario

__all__ = ["write_pages"]

ROOT = Path(__file__).parents[2]


def write_pages(folder: Path) -> None:
    """Run the examples, write the pages that have changed, and remove those that are no longer made."""
    gallery.run_examples(folder / "gallery", folder / "extra" / "scenes")
    made = {
        **api.pages(),
        **gallery.pages(folder / "gallery"),
        "scenario.md": scenario.page(),
        "changelog.md": project_file("CHANGELOG.md"),
        "contributing.md": project_file("CONTRIBUTING.md"),
    }
    for page in (*folder.rglob("*.md"), *folder.rglob("*.rst")):
        if page.relative_to(folder).as_posix() not in made:
            page.unlink()
    for name, text in made.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def project_file(name: str) -> str:
    """Return a page of the root of the project, with its links as seen from the folder of generated pages."""
    return re.sub(r"\]\(docs/", "](../", (ROOT / name).read_text())
