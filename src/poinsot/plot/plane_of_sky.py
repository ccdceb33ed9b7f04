"""A body as the observer of a light curve sees it, in the plane of the sky."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from poinsot.errors import real_array
from poinsot.forces.facets import Facets
from poinsot.functions import Vector
from poinsot.mechanics.instant import Instant
from poinsot.observables.light_curve import LightCurve
from poinsot.plot.labels import BLACK, GREEN, one_body
from poinsot.plot.panels import Axes, PanelOptions, dress, one_panel, plot
from poinsot.plot.solid_parts import triangles_of
from poinsot.plot.time_axis import instant
from poinsot.printable import quoted
from poinsot.propagation.propagate import propagated_again
from poinsot.propagation.readings_along import states_at
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.units import DerivedUnits
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.scattering import Reflection
from poinsot.shapes.solids import Ellipsoid
from poinsot.shapes.views import ray_hits
from poinsot.systems.times_and_states import checked_times

__all__ = ["sky"]

NORTH = (0.0, 0.0, 1.0)
ARROW, SPACING, BELOW = 1.45, 3.1, 0.35
"""Length of the arrows, distance of neighbouring pictures and space for the scale, in radii of the body."""
TEXT = (-1.5, 1.5)
"""Place of the time, in radii of the body from the middle of a picture."""
DEFAULT_COUNT = 8
"""Number of pictures without times."""
MAX_COLUMNS = 4
"""Largest number of pictures in a row."""
INCHES, MIN_WIDTH = 2.3, 4.2
"""Side of a picture, and smallest width of all pictures, inches."""
DARK, BRIGHT = 0.12, 0.97
"""Grey of facets without light, and of the brightest facet."""
SATURATION = 10.0
"""Brightness over the median of lit facets that is drawn white, so that a glint does not darken the other facets."""
FINE = 3000
"""Number of triangles up to which the triangles of a mesh with shadows are divided."""
ARROWS = {"angular momentum": BLACK, "angular velocity": GREEN, "Sun": "#E69F00"}
"""Colours of the arrows."""
MIN_SINE, TINY = 1e-6, 1e-300
"""Smallest sine between north and the line of sight, and smallest denominator."""
MAX_PAIRS = 1_000_000
"""Largest number of pairs of a triangle and a face in one block."""
ROUNDING = 1e-9
"""Height over a face, relative to the size of the body, that is rounding."""


@plot
def sky(
    motion: Trajectory,
    curve: LightCurve,
    times: Times | None = None,
    *,
    north: ArrayLike = NORTH,
    time_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw a body as the observer of a light curve sees it: its facets by their brightness, with shadows.

    North is upwards and east is to the left, as on the sky: with the direction u from the observer to the body, east is
    north x u. Arrows of one length in space show the angular velocity, the angular momentum and the direction to the
    Sun, projected on the plane of the sky. An arrow that points away from the observer begins behind the body.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body.
    curve : LightCurve
        Light curve, whose shape, scattering law, Sun and observer are used, with the light time.
    times : array (n,), optional
        Times of the observations, dates if an orbit has a calendar. Default: eight of the times of the motion.
    north : array (3,), optional
        Direction of north, space axes. Default: the third axis, the pole of equatorial or ecliptic axes.
    {options}

    Raises
    ------
    TypeError, ValueError
        If the motion is not of one body, or north is along the line of sight.

    Examples
    --------
    >>> sun, earth = (pt.orbits.FixedPosition(1.0, position=place) for place in ((-3, 0, 0), (-2, 1, 0)))
    >>> ball = pt.shapes.Ellipsoid((0.9, 0.6, 0.5), density=2.0)
    >>> curve = pt.observables.LightCurve(ball, pt.observables.Lambert(0.2), sun=sun, observer=earth)
    >>> pt.plot.sky(motion, curve, [0.0, 2.0]).get_xlabel()
    'east to the left'
    """
    one_body(motion)
    some = np.unique(np.linspace(0, motion.times.size - 1, DEFAULT_COUNT).astype(int))
    at = motion.times[some] if times is None else checked_times(times, motion.system)
    views = _views(motion, curve, at, real_array("north", north, (3,)))
    columns = min(len(views), MAX_COLUMNS)
    rows = -(-len(views) // columns)
    radius = max(float(np.max(np.linalg.norm(view.corners, axis=-1))) for view in views)
    lit = np.concatenate([view.brightness[view.brightness > 0] for view in views])
    brightest = min(float(np.max(lit)), SATURATION * float(np.median(lit))) if lit.size else 1.0
    width = max(INCHES * columns, MIN_WIDTH)
    panel = one_panel((width + 0.6, width * rows / columns + 0.9), **options)
    for i, (view, time) in enumerate(zip(views, at, strict=True)):
        centre = SPACING * radius * np.array([i % columns, -(i // columns)])
        _draw(panel, view, centre, radius, brightest, labelled=not i)
        x, y = centre + radius * np.array(TEXT)
        panel.text(x, y, instant(motion, time, time_unit), ha="left", va="top", fontsize="small")
    half = 0.5 * SPACING * radius
    panel.set(
        xlim=(-half, (2 * columns - 1) * half),
        ylim=((1 - 2 * rows) * half - BELOW * radius, half),
        xticks=[],
        yticks=[],
    )
    panel.set_aspect("equal")
    _draw_scale(panel, radius, _length_unit(motion.system.units))
    dress(panel, "east to the left", "north upwards")
    return panel


# ---------------------------------------------------------------------- geometry


@dataclass(frozen=True)
class _View:
    """Body as it is seen, in coordinates to the right, upwards and towards the observer.

    Attributes
    ----------
    corners : array (n, 3, 3)
        Triangles that face the observer, from the farthest to the nearest.
    brightness : array (n,)
        Brightness of a unit area of the picture, 0 without light.
    arrows : mapping
        Unit vectors by their names.
    """

    corners: Array
    brightness: Array
    arrows: dict[str, Array]


def _views(motion: Trajectory, curve: LightCurve, times: Array, north: Array) -> list[_View]:
    """Return the views of the body at times of observation."""
    seen = curve.time_of_body(times, DerivedUnits(motion.system.units))
    wanted, place = np.unique(seen, return_inverse=True)
    state, environment = states_at(motion, wanted, propagated_again)
    missed = np.setdiff1d(wanted, np.asarray(environment.time))
    if missed.size:
        raise ValueError(f"times must be times that the motion reaches, got {quoted(float(missed[0]))}.")
    seen_at = cast(Instant, motion.system.at(state, environment))
    in_space = seen_at.attitude.to_space
    vectors = {
        "Sun": -seen_at.direction(curve.sun),
        "observer": -seen_at.direction(curve.observer),
        "angular velocity": in_space(seen_at.omega_body),
        "angular momentum": in_space(seen_at.angular_momentum_body),
    }
    units = {name: _unit_rows(vector, wanted) for name, vector in vectors.items()}
    axes = np.stack([_unit_rows(in_space(Vector(axis)), wanted) for axis in np.eye(3)], axis=1)
    surface = _Surface(triangles_of(_shape_of(curve)) * np.asarray(curve.stretch))
    return [_view(curve, surface, axes[i], {name: rows[i] for name, rows in units.items()}, north) for i in place]


def _shape_of(curve: LightCurve) -> Mesh | Ellipsoid | Facets:
    """Return the shape of the light curve of one body."""
    shapes = curve._surfaces.each
    if len(shapes) > 1:
        raise ValueError("curve must be of one body, got a light curve of two bodies. Draw a light curve of each.")
    if curve.member_axis:
        raise ValueError(f"curve must be one light curve, got {curve.member_axis[0]} members. Pass one of them.")
    return shapes[0]


def _view(curve: LightCurve, surface: _Surface, axes: Array, units: dict[str, Array], north: Array) -> _View:
    """Return the view of a surface for body axes as rows of an array, and unit vectors in space."""
    screen = _screen(units["observer"], north)
    sun, observer = axes @ units["Sun"], axes @ units["observer"]
    corners, mu0, mu = surface.corners, surface.normals @ sun, surface.normals @ observer
    lit = (mu0 > 0) & (mu > 0)
    if curve.shadows != "none" and isinstance(_shape_of(curve), Mesh):
        lit[lit] &= ~surface.shaded(np.flatnonzero(lit), sun)
    light = Reflection(mu0[lit], mu[lit], np.arccos(np.clip(sun @ observer, -1, 1)))
    brightness = np.zeros(len(corners))
    brightness[lit] = curve.law.brightness(light) / mu[lit]
    drawn = corners @ axes @ screen.T
    order = np.flatnonzero(mu > 0)
    order = order[np.argsort(np.mean(drawn[order, :, 2], axis=-1))]
    arrows = {name: screen @ unit for name, unit in units.items() if name != "observer"}
    return _View(drawn[order], brightness[order], arrows)


def _screen(observer: Array, north: Array) -> Array:
    """Return the directions to the right, upwards and towards the observer as rows; east is to the left."""
    east = np.cross(north, -observer)
    if np.linalg.norm(east) <= MIN_SINE * np.linalg.norm(north):
        raise ValueError(f"north must not be zero or along the line of sight, got {north}. Give another direction.")
    right = -east / np.linalg.norm(east)
    return np.stack([right, np.cross(observer, right), observer])


class _Surface:
    """Triangles of a surface, (n, 3, 3), divided so that shadows and overlaps are smooth in a picture."""

    def __init__(self, triangles: Array) -> None:
        self.faces, self.of_face = triangles, np.arange(len(triangles))
        self.corners = triangles
        while len(self.corners) < FINE:
            self.corners, self.of_face = _quartered(self.corners), np.repeat(self.of_face, 4)
        across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        self.of_faces = across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), TINY)
        self.normals = self.of_faces[self.of_face]
        self.rounding = ROUNDING * float(np.max(np.abs(triangles)))

    def shaded(self, triangles: NDArray[np.int_], sun: Array) -> NDArray[np.bool_]:
        """Return True for triangles with their middle in the shadow of other faces."""
        found = np.zeros(len(triangles), dtype=bool)
        middles, normals = np.mean(self.corners[triangles], axis=1), self.normals[triangles]
        facing = self.faces[self.of_faces @ sun > 0]  # a ray that leaves the body meets such a face last
        rows = max(1, MAX_PAIRS // max(1, len(facing)))
        for start in range(0, len(triangles), rows):
            place, normal = middles[start : start + rows], normals[start : start + rows]
            heights = np.einsum("ni,fki->nfk", normal, facing) - np.vecdot(normal, place)[:, None, None]
            ray, face = np.nonzero(np.max(heights, axis=-1) > self.rounding)
            hit = ray_hits(np.broadcast_to(sun, (ray.size, 3)), facing[face] - place[ray][:, None])
            found[start + ray[hit]] = True
        return found


def _quartered(triangles: Array) -> Array:
    """Return triangles divided at the middles of their sides, the four parts of each one after the other."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [np.stack(part, axis=1) for part in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))]
    return np.stack(parts, axis=1).reshape(-1, 3, 3)


def _unit_rows(vector: Vector, times: Array) -> Array:
    """Return a vector at times over its length, 0 without length; shape (n, 3)."""
    rows = np.stack([np.broadcast_to(np.asarray(x, dtype=float), times.shape) for x in vector], axis=-1)
    return np.asarray(rows / np.maximum(np.linalg.norm(rows, axis=-1, keepdims=True), TINY))


# ---------------------------------------------------------------------- drawing


def _draw(panel: Axes, view: _View, centre: Array, radius: float, brightest: float, labelled: bool) -> None:
    """Draw a view about a point of the panel."""
    from matplotlib.collections import PolyCollection

    grey = DARK + (BRIGHT - DARK) * np.sqrt(np.minimum(view.brightness / brightest, 1))
    colours = np.repeat(np.where(view.brightness > 0, grey, DARK)[:, None], 3, axis=1)
    look: Any = {
        "facecolors": colours,
        "edgecolors": colours,
        "linewidths": 0,
        "antialiaseds": False,
        "zorder": 2,
        "rasterized": True,
    }
    panel.add_collection(PolyCollection(list(centre + view.corners[..., :2]), **look))
    for name, colour in ARROWS.items():
        x, y, depth = ARROW * radius * view.arrows[name]
        tip, order = centre + np.array((x, y)), 3 if depth >= 0 else 1
        style: Any = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
        panel.annotate("", tuple(tip), tuple(centre), arrowprops={**style, "zorder": order}, zorder=order)
        if labelled:
            panel.plot([], [], color=colour, linewidth=1.6, label=name)


def _length_unit(units: Mapping[str, str]) -> str:
    """Return the unit of length, from the unit of inertia for one body: "km" for "kg km2"."""
    found = re.search(r"(\w+)2\b", units["inertia"])
    return units.get("length") or (found[1] if found else "1")


def _draw_scale(panel: Axes, radius: float, unit: str) -> None:
    """Draw a round length below the last picture."""
    power = 10.0 ** math.floor(math.log10(radius))
    length = max(k * power for k in (1, 2, 5) if k * power <= radius)
    right, below = panel.get_xlim()[1], panel.get_ylim()[0]
    x, y = right - 0.15 * radius, below + 0.15 * radius
    panel.plot([x - length, x], [y, y], color=BLACK, linewidth=1.2, solid_capstyle="butt")
    words = f"{length:g}" + ("" if unit == "1" else f" {unit}")
    panel.text(x - 0.5 * length, y + 0.03 * radius, words, ha="center", va="bottom", fontsize="small")
