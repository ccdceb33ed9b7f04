"""An interactive 3D view of a motion, as one self-contained web page."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from poinsot.analysis.polhodes import principal
from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.mechanics.attitude import quaternion_from_matrix
from poinsot.plot.geometry import is_constant
from poinsot.plot.labels import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    VERMILION,
    bracketed,
    momentum_label,
    one_body,
    rate_unit_of,
)
from poinsot.plot.solid_parts import gyration_radii, parts_of
from poinsot.propagation.trajectory import Trajectory
from poinsot.shapes.mascons import Mascons
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.shape import Shape
from poinsot.shapes.solids import Ellipsoid

__all__ = ["View", "view"]

Array = NDArray[np.float64]

COLOURS = {
    "space_axes": GREY,
    "body_axes": PURPLE,
    "trace": PURPLE,
    "angular_momentum": BLACK,
    "omega": GREEN,
    "polhode": BLUE,
    "herpolhode": VERMILION,
    "components": [BLACK, BLUE, VERMILION, GREEN],
}

SCRIPTS = ("three.min.js", "motion.js", "scene.js", "plots.js", "page.js")

THINNEST = 0.01
"""The least extent of a drawn body, relative to the largest: a flat plate remains visible from its side."""

LARGEST_SPHERE = 0.1
"""Of a mass point, relative to the farthest one; of very many they are smaller."""

MOST_SPHERES = 20_000
"""Of mass points that are drawn, the heaviest ones."""

SECONDS_PER_TURN = 4.0

SHORTEST = 10.0
"""How many seconds a whole motion takes at least, at the speed in which the page starts."""


@dataclass(frozen=True)
class View:
    """A page that shows a motion; a notebook shows it as the value of a cell.

    Attributes
    ----------
    html : str
        The whole page.
    """

    html: str

    def __repr__(self) -> str:
        return f"View({len(self.html) / 1e6:.1f} MB of HTML)"

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts" title="A motion in three dimensions" '
            'style="width: 100%; height: 680px; border: 0"></iframe>'
        )


@overload
def view(motion: Trajectory) -> View: ...
@overload
def view(motion: Trajectory, path: str | Path, *, overwrite: bool = False) -> Path: ...
@checked
def view(motion: Trajectory, path: str | Path | None = None, *, overwrite: bool = False) -> View | Path:
    """Write a motion as a page that plays it in three dimensions, with the plots of q and Q beside it.

    The page works without a network. Between the stored times the attitude moves on the great circle from one
    quaternion to the next, the shorter way; momenta and rates are linear.

    Parameters
    ----------
    motion : Trajectory
        Of one body, at two times or more. Units on the page are those of its system.
    path : str or Path, optional
        Ends in `.html`. Without it the page is returned, for a notebook.
    overwrite : bool
        Whether an existing file of that name is replaced.

    Returns
    -------
    Path, or View without a path

    Raises
    ------
    TypeError, ValueError, FileNotFoundError, FileExistsError
        If it is no trajectory of one body, has fewer than two times, or the path cannot be written.

    Notes
    -----
    A body made of a shape is drawn as that, mass points as spheres. Ellipsoid and box are the homogeneous ones with
    the moments of the body. Of a body without parts the inertia ellipsoid omega . I omega = 2T, on which the polhode
    lies, is there if T is constant to 1e-6, and the invariable plane if the angular momentum in space is, too.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.2))
    >>> pt.view(pt.free_motion(body, start, np.linspace(0, 20, 201)))
    View(0.7 MB of HTML)
    """
    if path is None:
        return View(_page(motion))
    path = Path(path)
    if path.suffix != ".html":
        raise ValueError(f"path must end in .html, got {path.name!r}.")
    return write_text(path, _page(motion), overwrite)


# ---------------------------------------------------------------------- the page


def _page(motion: Trajectory) -> str:
    """Return the page, whose policy lets run the scripts below and load nothing."""
    content = _content(motion)
    folder = resources.files("poinsot.plot") / "page"
    style, *scripts = ((folder / name).read_text(encoding="utf-8") for name in ("page.css", *SCRIPTS))
    allowed = " ".join(map(_hash, scripts))
    policy = f"default-src 'none'; script-src {allowed}; style-src {_hash(style)}; img-src data:; base-uri 'none'"
    parts = {
        "policy": policy,
        "title": html.escape(content["title"]),
        "style": style,
        "herpolhode": " checked" if content["plane"] else "",
        "motion": json.dumps(content, allow_nan=False).replace("<", "\\u003c"),
        "scripts": "\n".join(f"<script>{script}</script>" for script in scripts),
    }
    template = (folder / "page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda name: parts[name[1]], template)


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


# ---------------------------------------------------------------------- what it is told


def _content(motion: Trajectory) -> dict[str, Any]:
    """Return what the page shows, as JSON takes it."""
    if one_body(motion).times.size < 2:
        raise ValueError(f"motion must have two times or more, got {motion.times.size}.")
    forwards = slice(None, None, 1 if motion.times[1] > motion.times[0] else -1)
    times = motion.times[forwards]
    rate = np.linalg.norm(motion.omega_body, axis=-1)[forwards]
    span = float(times[-1] - times[0])
    name = motion.provenance.get("title") or "poinsot"
    mean_rate = float(np.trapezoid(rate, times)) / span
    turn = 2 * np.pi / mean_rate if mean_rate else np.inf
    arrays = {
        "quaternion": motion.quaternion,
        "momenta": motion.conjugate_momenta,
        "omega_body": motion.omega_body,
        "angular_momentum_space": motion.angular_momentum_space,
    }
    return {
        "title": textwrap.shorten(f"{name}: {_rounded(repr(motion.system))}", 300, placeholder=" ..."),
        "note": _note(times, rate),
        "labels": _labels(motion.system.units),
        "colours": COLOURS,
        "times": _base64(times, "<f8"),
        "arrays": {name: _packed(values[forwards]) for name, values in arrays.items()},
        "largest": {
            "omega": float(np.max(rate)),
            "angular_momentum": float(np.max(np.linalg.norm(motion.angular_momentum_space, axis=-1))),
        },
        "mean_rate": mean_rate,
        "rate": min(turn / SECONDS_PER_TURN, span / SHORTEST),
        "solids": _solids(motion),
        "plane": _invariable_plane(motion),
    }


def _rounded(words: str) -> str:
    """Return words with no more than six digits in a number."""
    return re.sub(r"\d+\.\d{6,}(e[-+]?\d+)?", lambda number: f"{float(number[0]):.6g}", words)


def _labels(units: Mapping[str, str]) -> dict[str, str]:
    return {
        "quaternion": "Euler parameters q",
        "momenta": f"conjugate momenta Q{momentum_label(units)}",
        "angular_momentum_space": momentum_label(units),
        "omega_body": rate_unit_of(units, None).label,
        "time": f"time{bracketed(units['time'])}",
        "t": "t",
        "unit": "" if units["time"] == "1" else f" {units['time']}",
    }


def _note(times: Array, rate: Array) -> str:
    """Return a warning if the body turns too far between stored times; else nothing."""
    angle = float(np.max(np.maximum(rate[1:], rate[:-1]) * np.diff(times)))
    if angle < np.pi:
        return ""
    return (
        f"Between two stored times the body turns by up to {np.degrees(angle):.0f}°, and what is shown there is a "
        "guess: it goes the shorter way. Store more times."
    )


def _solids(motion: Trajectory) -> dict[str, Any]:
    """Return the shapes as which the body is drawn, along its principal axes, and the attitude of these in it."""
    moments, _ = principal(motion.system.body)
    extent, axes = gyration_radii(motion.system.body)
    return {
        "shape": _shape(motion.system.body.shape),
        "principal": quaternion_from_matrix(axes).tolist(),
        "extent": np.maximum(extent / np.max(extent), THINNEST).tolist(),
        "inertia_ellipsoid": np.sqrt(2 * motion.kinetic_energy[0] / moments).tolist() if _rolls(motion) else None,
    }


def _shape(shape: Shape | None) -> list[dict[str, Any]] | None:
    """Return the parts of a shape from its centre of mass, within a unit sphere; None of a shape of another kind."""
    parts = parts_of(shape)
    if shape is None or parts is None:
        return None
    return [_part(part, shape.center_of_mass, 1 / shape.circumscribing_radius) for part in parts]


def _part(part: Any, center: Array, scale: float) -> dict[str, Any]:
    """Return what one part looks like, all lengths times a scale."""
    if isinstance(part, Mesh):
        return {"triangles": _packed(scale * (part.vertices - center)[part.faces])}
    if isinstance(part, Mascons):
        heaviest = np.sort(np.argsort(part.masses)[-MOST_SPHERES:])
        sizes = min(LARGEST_SPHERE, 0.6 / np.cbrt(heaviest.size)) * np.cbrt(part.masses[heaviest] / np.max(part.masses))
        return {"spheres": _packed(np.column_stack([scale * (part.positions[heaviest] - center), sizes]))}
    sides = part.semiaxes if isinstance(part, Ellipsoid) else (part.radius, part.radius, part.height / 2)
    return {
        "solid": "ellipsoid" if isinstance(part, Ellipsoid) else "cylinder",
        "sides": (scale * np.asarray(sides)).tolist(),
        "place": (scale * (part.center_of_mass - center)).tolist(),
        "turn": quaternion_from_matrix(part._axes).tolist(),
    }


def _invariable_plane(motion: Trajectory) -> dict[str, Any] | None:
    """Return the plane omega . G = 2T and the radius of a disc that holds the herpolhode; None without one."""
    G, omega = motion.angular_momentum_space, motion.omega_space
    if not (_rolls(motion) and is_constant(G)):
        return None
    size = float(np.linalg.norm(G[0]))
    normal, height = G[0] / size, 2 * float(motion.kinetic_energy[0]) / size
    reach = float(np.max(np.linalg.norm(omega - np.outer(omega @ normal, normal), axis=-1)))
    return {"normal": normal.tolist(), "height": height, "radius": max(1.15 * reach, 0.5 * height)}


def _rolls(motion: Trajectory) -> bool:
    """Return whether the polhode lies on an inertia ellipsoid."""
    if motion.system.parts:
        return False
    energy = motion.kinetic_energy
    return bool(energy[0] > 0 and is_constant(energy[:, None]))


def _packed(values: Array) -> dict[str, Any]:
    """Return rows as numbers of single precision and their largest size, which may be beyond its range."""
    scale = float(np.max(np.abs(values))) or 1.0
    return {"scale": scale, "data": _base64(values / scale, "<f4")}


def _base64(values: Array, kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()
