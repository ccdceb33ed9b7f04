"""The gallery: a page for each example, with what it says, draws and prints."""

from __future__ import annotations

import ast
from pathlib import Path

__all__ = ["GROUPS", "pages"]

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"

GROUPS = {
    "Satellites": "attitude_covariance cubesat desaturation detumbling dual_spin explorer_1 gravity_gradient_satellite "
    "jeod_run_10a paper_satellite thermal_snap",
    "Between two attractors": "halo_orbit libration_point",
    "Moons and planets": "cassini_states europa forced_librations hyperion librations_of_worlds phobos "
    "tidal_despinning",
    "Asteroids": "apophis toutatis series_of_gravity yorp",
    "Two bodies": "dart dimorphos_map moshup patroclus",
    "Sections and maps": "heavy_body_section megno_map poincare_hyperion",
}
"""The examples, by what they are of."""


def pages(folder: Path) -> dict[str, str]:
    """Return the text of each page by its path, of results that lie in a folder each."""
    del folder
    names = [name for group in GROUPS.values() for name in group.split()]
    return {"gallery/index.md": index(), **{f"gallery/{name}.md": page(name) for name in names}}


def told(name: str) -> tuple[str, str]:
    """Return title and text of an example: the first sentence of its docstring, and the rest."""
    first, _, rest = (ast.get_docstring(ast.parse((EXAMPLES / f"{name}.py").read_text())) or "").partition("\n\n")
    return " ".join(first.split()).removesuffix("."), rest


def index() -> str:
    """Return the page of all."""
    parts = []
    for group, names in GROUPS.items():
        listed = "\n".join(f"{told(name)[0]} <{name}>" for name in names.split())
        parts.append(f"```{{toctree}}\n:caption: {group}\n:maxdepth: 1\n\n{listed}\n```")
    return "\n\n".join(["# Gallery", *parts]) + "\n"


def page(name: str) -> str:
    """Return the page of one example."""
    title, text = told(name)
    return f"# {title}\n\n{text}\n\n```{{literalinclude}} ../../../examples/{name}.py\n```\n"
