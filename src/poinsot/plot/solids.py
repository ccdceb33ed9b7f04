"""Ellipsoids and curves on them, drawn as solid bodies with a faded far side.

The pictures are in parallel projection from one direction, `eye`. matplotlib sorts whole artists by depth, not their
parts. Every curve is therefore cut into near and far parts, and the order of painting is set.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.analysis.polhodes import TURN
from poinsot.errors import real_array
from poinsot.plot.labels import GREY
from poinsot.printable import described
from poinsot.quantities import Array

__all__ = [
    "DrawnEllipsoid",
    "DrawnSolid",
    "draw_arrow",
    "draw_path",
    "draw_point",
    "finish",
    "fit",
    "label_axes",
    "right_and_up",
    "solid_axes",
    "view_direction",
]

FAR_SIDE_OPACITY = 0.3
"""Opacity of curves on the far side."""

MAX_POINTS = 20_000
"""Largest number of points of a line that a vector file stores as a line."""

LIGHT_LAYERS = 24
"""Number of layers of light on a solid."""

SIDE, TALLEST, ROOM = 6.4, 5.6, 0.15
"""Width of a figure, largest height of its picture, and margin, inches."""
BELOW, LINE = 0.45, 0.27
"""Inches of the legend below, and of a line of the title above."""

POINTS_PER_CHARACTER = 4
"""Points between an axis and its name for each character of the ticks after the fifth."""


@dataclass(frozen=True)
class DrawnEllipsoid:
    """Ellipsoid about the origin.

    Attributes
    ----------
    axes : array (3, 3)
        Directions of the axes of the ellipsoid, as columns.
    semiaxes : array (3,)
    """

    axes: Array
    semiaxes: Array

    def normals(self, points: Array) -> Array:
        """Return the outward normals at points of the surface, of any length; shape (..., 3)."""
        return np.asarray(points @ self.axes / self.semiaxes**2 @ self.axes.T)

    def section(self, pole: Array) -> Array:
        """Return the image of the great circle with a pole on the unit sphere; shape (m, 3)."""
        return _circle(pole) * self.semiaxes @ self.axes.T

    def outline(self, eye: Array) -> Array:
        """Return the closed curve that bounds the ellipsoid as seen from a direction; shape (m, 3)."""
        return self.section(eye @ self.axes / self.semiaxes)

    def reach(self, direction: Array) -> float:
        """Return the extent of the ellipsoid along a unit vector."""
        return float(np.linalg.norm(direction @ self.axes * self.semiaxes))


class DrawnSolid:
    """Ellipsoid drawn as seen from one direction.

    The order of painting is: 1 the solid, 2 the curves on its far side, 3 the curves on its near side, 8 points.
    """

    def __init__(self, axes: Any, ellipsoid: DrawnEllipsoid, eye: Array) -> None:
        self.axes = axes
        self.ellipsoid = ellipsoid
        self.eye = eye
        self._shade()

    def _shade(self) -> None:
        """Fill the outline, lighter towards the upper left."""
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        outline = self.ellipsoid.outline(self.eye)
        flat = outline - np.outer(outline @ self.eye, self.eye)
        right, up = right_and_up(self.eye)
        light = 0.45 * flat[np.argmax(flat @ (up - 0.7 * right))]
        light += 0.1 * np.min(self.ellipsoid.semiaxes) * self.eye  # so that the smaller layers lie in front
        layers = [light + size * (flat - light) for size in np.linspace(1, 0, LIGHT_LAYERS, endpoint=False)]
        colours = ["#C9D8E4", *[(1, 1, 1, 2 / LIGHT_LAYERS)] * (LIGHT_LAYERS - 1)]
        self.axes.add_collection3d(Poly3DCollection(layers, facecolors=colours, edgecolors="none", zorder=1))
        self.axes.plot(*outline.T, color="#6E6E6E", linewidth=0.8, zorder=1)

    def curve(self, points: Array, colour: str, width: float, label: str | None = None, **style: Any) -> None:
        """Draw a curve on the surface, shape (m, 3)."""
        near = self._near(points)
        for side, order, opacity, name in ((~near, 2, FAR_SIDE_OPACITY, None), (near, 3, 1.0, label)):
            part = np.where(_widened(side)[:, None], points, np.nan)
            draw_path(self.axes, part, color=colour, linewidth=width, alpha=opacity, zorder=order, label=name, **style)

    def family(self, curves: Iterable[Array], colour: str, width: float, label: str | None = None) -> None:
        """Draw curves of one kind, with one name in the legend."""
        for i, points in enumerate(curves):
            self.curve(points, colour, width, None if i else label)

    def mark(self, point: Array, colour: str, label: str | None = None) -> None:
        """Draw a point of the surface, shape (3,)."""
        draw_point(self.axes, point, colour, label, opacity=1.0 if self._near(point) else FAR_SIDE_OPACITY)

    def _near(self, points: Array) -> Any:
        return self.ellipsoid.normals(points) @ self.eye >= 0


# ---------------------------------------------------------------------- axes


def view_direction(view: ArrayLike) -> Array:
    """Return the unit vector towards the eye, from elevation and azimuth in degrees."""
    elevation, azimuth = np.radians(real_array("view", view, (2,)))
    across = np.cos(elevation)
    return np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)])


def right_and_up(eye: Array) -> tuple[Array, Array]:
    """Return the directions of space that are rightwards and upwards in a view from a direction."""
    azimuth = np.arctan2(eye[1], eye[0])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    return right, np.cross(eye, right)


def solid_axes(eye: Array, title: str, ax: Any = None) -> Any:
    """Return the given 3D axes or axes of a new figure, seen from a direction; artists are painted in their order."""
    import matplotlib.pyplot as plt
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    from poinsot.plot.figure import TextFigure

    if ax is None:
        figure = plt.figure(figsize=(SIDE, SIDE), FigureClass=TextFigure)
        figure.suptitle(title, fontsize=11)
        ax = figure.add_axes((0, 0, 1, 1), projection="3d")
    elif isinstance(ax, Axes3D):
        ax.set_title(title, fontsize=11)
    else:
        raise TypeError(
            f"ax must be 3D axes of matplotlib, got {described(ax)}. They come from plt.subplots(subplot_kw="
            '{"projection": "3d"}).'
        )
    ax.computed_zorder = False
    ax.set_proj_type("ortho")
    ax.view_init(np.degrees(np.arcsin(eye[2])), np.degrees(np.arctan2(eye[1], eye[0])))
    ax.disable_mouse_rotation()
    return ax


def fit(axes: Any, low: Array, high: Array, eye: Array) -> None:
    """Set the limits, one unit as long on all three axes, with room for labels as seen from a direction."""
    sides = high - low
    width, height = (np.abs(across) @ sides for across in right_and_up(eye))
    zoom = min(0.76 / width, 0.82 / height)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(sides, zoom=float(np.linalg.norm(sides) * zoom))


def label_axes(axes: Any, labels: Sequence[str]) -> None:
    """Name the three axes, with few ticks and without walls."""
    from matplotlib.ticker import MaxNLocator

    lengths = np.ptp([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()], axis=-1)
    few = np.where(lengths > 0.3 * np.max(lengths), 4, 2)
    for axis, label, ticks in zip((axes.xaxis, axes.yaxis, axes.zaxis), labels, few, strict=True):
        axis.set_label_text(label)
        axis.set_pane_color((1, 1, 1, 0))
        axis.line.set_color(GREY)
        axis.set_major_locator(MaxNLocator(ticks))
        longest = max(map(len, axis.get_major_formatter().format_ticks(axis.get_majorticklocs())), default=0)
        axis.labelpad = 4 + POINTS_PER_CHARACTER * max(longest - 5, 0)
    axes.tick_params(labelsize=8, colors="#404040")
    axes.grid(visible=False)


def finish(axes: Any, own_figure: bool) -> None:
    """Put the legend below the picture, and let the picture fill a new figure."""
    if own_figure:
        _fill(axes)
    if axes.get_legend_handles_labels()[0]:
        style: Any = {"fontsize": 9, "columnspacing": 1.2, "handlelength": 1.5, "handletextpad": 0.5, "frameon": False}
        if own_figure:
            axes.figure.legend(loc="lower center", ncols=5, **style)
        else:
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2, **style)


def _fill(axes: Any) -> None:
    """Scale and move axes so that the picture fills the width or the height, and fit the height of the figure."""
    figure = axes.figure
    below = BELOW * bool(axes.get_legend_handles_labels()[0]) + ROOM
    above = LINE * (1 + figure.get_suptitle().count("\n")) + 2 * ROOM
    size = SIDE
    for _ in range(2):  # the size of the text is fixed
        low, high = _extent(axes)
        size *= min((SIDE - 2 * ROOM) / (high[0] - low[0]), TALLEST / (high[1] - low[1]))
        axes.set_position((0, 0, size / SIDE, size / figure.get_figheight()))
    low, high = _extent(axes)
    total = high[1] - low[1] + below + above
    left = 0.5 * (SIDE - low[0] - high[0])
    figure.set_figheight(total)
    figure.suptitle(figure.get_suptitle(), y=1 - ROOM / total, va="top", fontsize=11)
    axes.set_position((left / SIDE, (below - low[1]) / total, size / SIDE, size / total))


def _seen(axes: Any, points: Any) -> Array:
    """Return points of space, a row for each coordinate, in the plane of the picture; shape (m, 2)."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    *seen, _ = proj_transform(*points, axes.M)
    return np.stack(seen, axis=-1)


def _corners(text: Any, axes: Any) -> Array:
    """Return two corners of a text in space, pixels, moved from the reported position to the drawn one."""
    moved = axes.transData.transform([_seen(axes, text.get_position_3d()), text.get_position()])
    return np.asarray(text.get_window_extent().get_points() + moved[0] - moved[1])


def _extent(axes: Any) -> tuple[Array, Array]:
    """Return the lower left and the upper right corner of the picture, inches.

    Only visible axes are drawn, which places their text: drawing all would take most of the time of a picture.
    """
    figure = axes.figure
    axes.apply_aspect()
    axes.M = axes.get_proj()
    drawn = [_seen(axes, line.get_data_3d()) for line in axes.lines]
    for each in axes.collections:
        each.do_3d_projection()
        drawn += [path.vertices for path in each.get_paths()]
    renderer, boxes = figure.canvas.get_renderer(), [_corners(text, axes) for text in axes.texts]
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        if axis.get_visible():
            axis.draw(renderer)
            boxes.append(axis.get_tightbbox(renderer).get_points())
    places = np.concatenate([axes.transData.transform(np.concatenate(drawn)), *boxes]) / figure.dpi
    return np.nanmin(places, axis=0), np.nanmax(places, axis=0)


# ---------------------------------------------------------------------- parts


def draw_path(axes: Any, points: Array, **style: Any) -> None:
    """Draw the line through points, shape (n, 2) or (n, 3), rasterised in a vector file if the points are many."""
    axes.plot(*points.T, rasterized=len(points) > MAX_POINTS, **style)


def draw_point(axes: Any, point: Array, colour: str, label: str | None = None, opacity: float = 1.0) -> None:
    """Draw a dot in front of all other artists."""
    axes.plot(
        *point[:, None], "o", color=colour, markeredgecolor="white", markersize=8, alpha=opacity, zorder=8, label=label
    )


def draw_arrow(axes: Any, start: Array, tip: Array, colour: str, head: float, zorder: float) -> None:
    """Draw an arrow with a cone of the given length as its head."""
    along = (tip - start) / np.linalg.norm(tip - start)
    foot = tip - head * along
    rim = foot + 0.3 * head * _circle(along)[::30]
    cone = np.stack([rim, np.broadcast_to(tip, rim.shape)])
    axes.plot(*np.stack([start, foot]).T, color=colour, linewidth=2, zorder=zorder)
    axes.plot_surface(*np.moveaxis(cone, -1, 0), color=colour, shade=False, linewidth=0, zorder=zorder)


def _circle(pole: Array) -> Array:
    """Return the unit circle across a vector; shape (m, 3)."""
    first, second = np.linalg.svd(pole[None])[2][1:]
    return np.outer(np.cos(TURN), first) + np.outer(np.sin(TURN), second)


def _widened(chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask with one more neighbour at each end, so that the parts of a curve meet."""
    wider = chosen.copy()
    wider[1:] |= chosen[:-1]
    wider[:-1] |= chosen[1:]
    return wider
