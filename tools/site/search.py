"""The texts of the pages for the summaries of the search, since pages from disk may not fetch one another."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

from docutils import nodes

__all__ = ["keep_text", "write_texts"]

KEPT = "poinsot_texts"
"""Where the build keeps the texts, by page, also of pages that have not changed since the last one."""


def keep_text(app: Any, doctree: nodes.Node, page: str) -> None:
    """Keep the text of a page when it is written."""
    vars(app.env).setdefault(KEPT, {})[page] = f'<main role="main">{text(doctree)}</main>'


def text(node: nodes.Node) -> str:
    """Return the words within a node, with the anchors to which the search leads."""
    if isinstance(node, nodes.Text):
        return html.escape(" ".join(node.split()), quote=False) + " "
    if not isinstance(node, nodes.Element) or isinstance(
        node, nodes.raw | nodes.comment | nodes.math | nodes.math_block
    ):
        return ""
    inside = "".join(map(text, node.children))
    for anchor in node.get("ids", ()):  # the search asks for "#poinsot.view" where dots begin classes
        name, *classes = html.escape(anchor).split(".")
        inside = f'<div id="{name}" class="{" ".join(classes)}">{inside}</div>'
    return inside


def write_texts(app: Any, exception: Exception | None) -> None:
    """Write the texts as a script, which the page of the search loads."""
    if exception is None and app.builder.format == "html":
        texts = {page: stored for page, stored in vars(app.env)[KEPT].items() if page in app.env.found_docs}
        path = Path(app.outdir) / "_static" / "texts.js"
        path.write_text(f"const TEXTS = {json.dumps(texts, ensure_ascii=False)};\n", encoding="utf-8")
