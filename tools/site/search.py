"""The search: the page of each frequent query, and the texts of the pages for its summaries."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from typing import Any

from docutils import nodes

__all__ = ["FIRST_RESULTS", "keep_text", "with_index_entries", "write_texts"]

FIRST_RESULTS = {
    "ensembles": "ensemble, monte carlo",
    "forces": "torque, torques, force, potential",
    "gravity": "gravity gradient, gravity",
    "surfaces": "eclipse, drag, radiation pressure, solar radiation pressure, shadow",
    "magnetic": "magnetic field, magnetorquer, b-dot, igrf",
    "yorp": "yorp",
    "tides": "tides, tidal torque",
    "parts": "reaction wheel, momentum wheel, moving parts",
    "control": "control, attitude control, kalman filter",
    "ephemerides": "two-line elements, tle, spice, ephemeris",
    "events": "event, events",
    "frequencies": "frequency, frequencies, spectrum",
    "chaos": "chaos, lyapunov exponent, megno",
    "equilibria": "equilibrium, equilibria",
    "state_transition": "state transition, covariance",
    "periodic": "periodic motion, periodic orbit",
    "two_bodies": "binary asteroid, two bodies",
    "shapes": "inertia tensor, mesh, shape",
    "files": "ccsds, aem, attitude files",
    "stores": "store, zarr",
    "view": "3d view, animation, plot",
    "accuracy": "accuracy, error",
    "limits": "limits",
    "install": "install, installation",
    "free_rotation": "free rotation, torque-free motion",
    "theory/conventions": "quaternion, quaternions, euler angles, convention, units",
    "generated/api/poinsot.propagate": "propagate, attitude",
    "generated/api/poinsot.free_motion": "euler-poinsot motion",
    "generated/api/poinsot.save": "save",
    "generated/api/poinsot.load": "load",
    "generated/api/poinsot.Body": "body, moment of inertia",
}
"""Queries by the page that a reader means, which the search lists first."""

KEPT = "poinsot_texts"
"""Where the build keeps the texts, by page, also of pages that have not changed since the last one."""


def with_index_entries(page: str, content: list[str], suffix: str) -> None:
    """Add a main index entry for each query to the page that the search lists first."""
    if queries := FIRST_RESULTS.get(page):
        rst = suffix == ".rst"
        entry = ".. index:: ! {}\n" if rst else "```{{index}} ! {}\n```\n"
        entries = "".join(map(entry.format, queries.split(", ")))
        heading = r"\A" if rst else r"^# .*\n"
        content[0] = re.sub(heading, lambda found: f"{found[0]}\n{entries}\n", content[0], count=1, flags=re.MULTILINE)


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
        texts = {page: kept for page, kept in vars(app.env)[KEPT].items() if page in app.env.found_docs}
        path = Path(app.outdir) / "_static" / "texts.js"
        path.write_text(f"const TEXTS = {json.dumps(texts, ensure_ascii=False)};\n", encoding="utf-8")
