"""An interactive 3D view of a motion, as one self-contained web page."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, overload

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.mechanics.environment import Orbit
from poinsot.plot.page_content import content_of, others_of
from poinsot.printable import quoted
from poinsot.propagation.trajectory import Trajectory

__all__ = ["View", "view"]

SCRIPTS = {
    seen: (
        *("three.min.js", "algebra.js", "motion.js", "theme.js", "stage.js", "scene.js", "surroundings.js"),
        *("ghosts.js", "views.js", *own, f"{seen}.js"),
        *("plots.js", "time.js", "gif.js", "film.js", "controls.js", "page.js"),
    )
    for seen, own in {"body": ("fittings.js",), "pair": ()}.items()
}
SEEN = {"body": "The body", "pair": "Two bodies"}
"""Content of each kind of scene in words."""

CAPTIONS = {
    "body": {
        "orbit": "Orbit and attractor are to scale with each other, the body is larger.",
        "facets": "Facets: dark ones absorb light, white ones scatter it, blue ones mirror it.",
    },
    "pair": {"bodies": "Bodies and orbits are to scale.", "orbit": "What they orbit has a scale of its own."},
}
"""Captions by kind of scene and by its contents."""


FRAME = (
    ".poinsot-view { container-type: inline-size; }"
    ".poinsot-view iframe { width: 100%; height: 680px; border: 0; }"
    "@container (max-width: 760px) { .poinsot-view iframe { height: 1240px; } }"
)
"""Style of the page inside a notebook: narrow pages stack the scene, the controls and the plots."""


Motions = Trajectory | Sequence[Trajectory]


@dataclass(frozen=True)
class View:
    """Page that shows a motion; a notebook displays it as the value of a cell.

    Attributes
    ----------
    html : str
        Text of the page.
    """

    html: str

    def __repr__(self) -> str:
        return f"View({len(self.html) / 1e6:.1f} MB of HTML)"

    def _repr_html_(self) -> str:
        return (
            f'<style>{FRAME}</style><div class="poinsot-view"><iframe srcdoc="{html.escape(self.html)}" '
            'sandbox="allow-scripts allow-downloads" title="A motion in three dimensions"></iframe></div>'
        )


@overload
def view(
    motion: Trajectory,
    *,
    others: Motions | None = None,
    sun: Orbit | None = None,
    observer: Orbit | None = None,
    title: str = "",
) -> View: ...
@overload
def view(
    motion: Trajectory,
    path: str | Path,
    *,
    others: Motions | None = None,
    sun: Orbit | None = None,
    observer: Orbit | None = None,
    title: str = "",
    overwrite: bool = False,
) -> Path: ...
@checked
def view(
    motion: Trajectory,
    path: str | Path | None = None,
    *,
    others: Motions | None = None,
    sun: Orbit | None = None,
    observer: Orbit | None = None,
    title: str = "",
    overwrite: bool = False,
) -> View | Path:
    """Write a page that plays a motion in three dimensions, together with plots of quantities that the reader chooses.

    Two bodies move about their barycentre, to scale. The first plots are those of the quaternions q and Q, of roll,
    pitch, yaw and rates for a body on an orbit, or of distance and libration for two bodies. If the forces include
    sunlight, the Sun lights the scene. The page requires no network. Between stored times it interpolates the attitude
    by a cubic rotation vector, and momenta and angular velocities linearly. A body made of a shape is drawn as this
    shape. Other bodies are drawn as homogeneous ellipsoid or box with the same moments. For a body without parts, the
    page shows the inertia ellipsoid omega . I omega = 2 T with the polhode if T is constant to 1e-6, and the invariable
    plane if the angular momentum in space is constant, too.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body or of two, at two times or more. The page uses the default units of plots: times by their
        span, rates in deg/s or rpm, and N m and N m s for a system in kg, m and s.
    path : str or Path, optional
        Name of the file, which ends in `.html`. Without it the function returns the page, for a notebook.
    others : Trajectory, or sequence of these, optional
        Other motions of the same bodies, drawn translucent; at most 8 members of an ensemble.
    sun : Orbit, optional
        Orbit of the body relative to the Sun, such as `curve.sun` of a light curve. The Sun lights the scene, and an
        arrow points to it. Default: the Sun of the forces.
    observer : Orbit, optional
        Orbit of the body relative to an observer, such as `curve.observer`. An arrow points to the observer, from whom
        the camera can look at the body.
    title : str, optional
        Title of the page. By default the title of the scenario, or the bodies, forces and duration.
    overwrite : bool
        True to replace an existing file of that name.

    Returns
    -------
    View or Path
        The page, or the path of the file if a path is given.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError, FileExistsError
        If the motion is not a trajectory, is an ensemble or has fewer than two times, or the path cannot be written.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.2))
    >>> pt.view(pt.free_motion(body, start, np.linspace(0, 20, 201)))
    View(0.7 MB of HTML)
    """
    path = None if path is None else Path(path)
    if path is not None and path.suffix != ".html":
        raise ValueError(f"path must end in .html, got {quoted(path.name)}.")
    directions = {name: orbit for name, orbit in (("sun", sun), ("observer", observer)) if orbit is not None}
    page = _page(content_of(motion, others_of(motion, others), title, directions))
    return View(page) if path is None else write_text(path, page, overwrite)


# ---------------------------------------------------------------------- the page


def _page(content: dict[str, Any]) -> str:
    """Return the page of a content, whose policy allows its own scripts and no requests."""
    seen = "pair" if "bodies" in content else "body"
    folder = resources.files("poinsot.plot") / "page"
    files = ("page.html", f"{seen}.html", "page.css", *SCRIPTS[seen])
    around = content["around"]
    template, parts, style, *scripts = ((folder / file).read_text(encoding="utf-8") for file in files)
    allowed = " ".join(map(_hash, scripts))
    policy = f"default-src 'none'; script-src {allowed}; style-src {_hash(style)}; img-src data:; base-uri 'none'"
    slots = {
        "policy": policy,
        "title": html.escape(content["title"]),
        "style": style,
        "seen": SEEN[seen],
        "plots": "\n".join(map(_figure, content["plotted"])),
        "scale": " ".join(text for part, text in CAPTIONS[seen].items() if (content | around).get(part)),
        "alone": "" if "orbit" in around else " checked",
        "herpolhode": " checked" if content.get("plane") else "",
        "arrows": "\n".join(_labels_of_arrows(around)),
        "around": _group("Surroundings", list(_labels_around(around, len(content.get("ghosts", ()))))),
        "motion": json.dumps(content, allow_nan=False).replace("<", "\\u003c"),
        "scripts": "\n".join(f"<script>{script}</script>" for script in scripts),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda slot: slots[slot[1]], template.replace("{{parts}}", parts))


def _figure(quantity: str) -> str:
    """Return the element of a plot that shows this quantity first."""
    return (
        f'<figure data-quantity="{quantity}">\n<figcaption><select aria-label="plotted quantity"></select>\n'
        '<span class="values"></span></figcaption>\n<canvas role="img"></canvas><div class="cursor"></div>\n</figure>'
    )


def _group(title: str, controls: list[str]) -> str:
    """Return controls as a group that the reader can fold; nothing without controls."""
    inside = "\n".join(controls)
    return f"<details><summary>{title}</summary>\n<div>\n{inside}\n</div>\n</details>" if controls else ""


def _labels_of_arrows(around: dict[str, Any]) -> Iterator[str]:
    """Yield the controls of further arrows. Only the arrows that the user requests are drawn at first."""
    orbit = around.get("orbit", {})
    if orbit.get("moves"):
        words = "axes of the orbit: <i>r</i> radial, <i>t</i> transverse, <i>n</i> normal"
        yield _label("orbit_frame", words, marked=True, checked=False)
    if "sun" in around:
        seen = f"; part of its disc that is seen: {_reading('sunlight', '')}" if around["sunlight"] else ""
        yield _label("sun", f"Sun{seen}", marked=True, checked="sun" in around["arrows"])
    if "observer" in around["arrows"]:
        yield _label("observer", "observer")
    for vector in around.get("vectors", ()):
        name, unit = html.escape(vector["name"]), html.escape(vector["unit"])
        words = f"<i>{vector['letter']}</i> {name} {_reading(vector['array'], unit)}"
        yield _label(vector["array"], words, vector["colour"], marked=True, checked=False)


def _labels_around(around: dict[str, Any], ghosts: int) -> Iterator[str]:
    """Yield the controls of the surroundings of a body."""
    orbit = around.get("orbit", {})
    if orbit:
        size = f" ({orbit['size']})" if orbit["size"] else ""
        yield _label("orbit", f"orbit and {orbit['attractor']}{size}")
    if "sun" in around and orbit.get("lit") and orbit["radius"]:
        yield _label("shadow", f"shadow of {orbit['attractor']}", checked=False)
    if around.get("wheels"):
        slower = around["wheels"]["slower"]
        yield _label("wheels", "wheels" if slower == 1 else f"wheels, {slower} times slower")
    if ghosts:
        yield _label("ghosts", "the other motion" if ghosts == 1 else f"{ghosts} other motions")


def _label(part: str, words: str, colour: str = "", marked: bool = False, checked: bool = True) -> str:
    own = f' data-colour="{colour}"' if colour else ""
    words = words if marked else html.escape(words)
    return f'<label><input type="checkbox" data-part="{part}"{own}{" checked" * checked}><b>{words}</b></label>'


def _reading(array: str, unit: str) -> str:
    return f'<output data-size="{array}" data-unit="{unit}"></output>'


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
