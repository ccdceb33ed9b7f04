"""Sphere of directions of the angular momentum in the body, with the curves of equal energy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from poinsot.analysis.polhodes import energy_curve, energy_curves, principal, separatrices, spherical
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.plot.labels import BLACK, BLUE, GREEN, VERMILION, one_body
from poinsot.plot.panels import Axes3D, plot
from poinsot.plot.solids import DrawnEllipsoid, DrawnSolid, finish, solid_axes, view_direction
from poinsot.plot.time_axis import instant
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array

__all__ = ["momentum_sphere"]

UNIT_SPHERE = DrawnEllipsoid(np.eye(3), np.ones(3))


@plot
def momentum_sphere(
    motion: Trajectory | Body,
    state: State | None = None,
    *,
    view: ArrayLike | None = None,
    ax: Axes3D | None = None,
    time_unit: str | None = None,
) -> Axes3D:
    """Draw the unit sphere of directions g/G of the angular momentum, with the curves of equal energy.

    The momentum of a free body moves along one of the curves: around the short axis (of the largest moment of inertia)
    if 2T < G^2 / I_middle, and around the long axis (of the smallest) if 2T is larger. The separatrices lie between the
    two modes. Landau and Lifshitz, Mechanics, Sec. 37, draw the curves on the ellipsoid of energy.

    Parameters
    ----------
    motion : Trajectory or Body
        A body, or a trajectory, whose path and last sample are drawn on the sphere of its body. With forces or parts
        the path crosses the curves, which are torque-free curves, as the title states. The sphere is in the principal
        axes, numbered like the moments.
    state : State, optional
        State, or array of states, to mark together with its curve.
    view : array (2,), optional
        Elevation and azimuth of the viewpoint in degrees; by default towards the separatrices, with the state in front.
    {options}

    Returns
    -------
    matplotlib Axes
        Panel in 3D, without units.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type, is an ensemble, or is at rest.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> ax = pt.plot.momentum_sphere(body, body.state((1, 0, 0, 0), angular_momentum_body=(0, 1, 0.1)))
    >>> [text.get_text() for text in ax.figure.legends[0].get_texts()]
    ['short-axis mode', 'long-axis mode', 'separatrices', 'state']
    """
    path = one_body(motion) if isinstance(motion, Trajectory) else None
    body = motion if isinstance(motion, Body) else motion.system.of_bodies[""]
    if body.moments.ndim != 1:
        raise ValueError(f"motion must be of one body, got an ensemble of {len(body.moments)} members.")
    moments, axes = principal(body)
    n, marked = _directions("motion", path) @ axes, _directions("state", state) @ axes
    shown = np.concatenate([marked, n])
    eye = _facing(moments, shown[-1] if len(shown) else np.ones(3)) if view is None else view_direction(view)
    forced = path is not None and (bool(path.system.forces) or not path.system.dynamics.moves_alone)
    panel: Axes3D = solid_axes(eye, _title(moments, forced), ax)
    solid = DrawnSolid(panel, UNIT_SPHERE, eye)
    _draw_modes(solid, moments)
    _draw_states(solid, moments, marked)
    if path is not None:
        solid.curve(n, GREEN, 2.2, "motion")
        solid.mark(n[-1], GREEN, f"at {instant(path, path.times[-1], time_unit)}")
    _draw_axes(panel, moments, eye)
    panel.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    panel.set_box_aspect((1, 1, 1), zoom=1.2)
    panel.set_axis_off()
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.set_visible(False)
    finish(panel, ax is None)
    return panel


# ---------------------------------------------------------------------- parts of the picture


def _draw_modes(solid: DrawnSolid, moments: Array) -> None:
    """Draw the curves of both modes, and the separatrices or fixed directions between them."""
    long, middle, short = np.argsort(moments)
    solid.family(energy_curves(moments, short), BLUE, 1.0, "short-axis mode")
    solid.family(energy_curves(moments, long), VERMILION, 1.0, "long-axis mode")
    solid.family(separatrices(moments), BLACK, 1.8, "separatrices")
    if (moments[long] == moments[middle]) != (moments[middle] == moments[short]):
        symmetry = np.eye(3)[short if moments[long] == moments[middle] else long]
        solid.curve(UNIT_SPHERE.section(symmetry), BLACK, 1.4, "fixed directions", linestyle=":")


def _draw_states(solid: DrawnSolid, moments: Array, n: Array) -> None:
    for i, direction in enumerate(n):
        if not spherical(moments):
            solid.curve(energy_curve(moments, direction), GREEN, 2.2)
        solid.mark(direction, GREEN, None if i else "state")


def _draw_axes(panel: Any, moments: Array, eye: Array) -> None:
    """Draw both ends of each principal axis, and name the near one."""
    from matplotlib.patheffects import withStroke

    for i, name in enumerate(_names(moments)):
        sign = 1 if eye[i] >= 0 else -1
        near = sign * np.eye(3)[i]
        out = 1.1 / max(np.sqrt(1 - eye[i] ** 2), 0.5)  # beyond the outline
        panel.plot(*np.outer([1, out], near).T, color=BLACK, linewidth=1, zorder=7)
        panel.plot(*np.outer([-out, -1], near).T, color=BLACK, linewidth=1, zorder=0)
        label = f"{name}\n${'' if sign > 0 else '-'}\\mathbf{{e}}_{i + 1}$"
        halo = [withStroke(linewidth=3, foreground="white")]
        panel.text(*(1.1 * out * near), label, ha="center", va="center", path_effects=halo, zorder=9)


# ---------------------------------------------------------------------- directions


def _directions(name: str, state: State | Trajectory | None) -> Array:
    """Return the directions of g of states or of a trajectory, along the body axes; shape (n, 3)."""
    if state is None:
        return np.empty((0, 3))
    g = np.atleast_2d(state.angular_momentum_body)
    G = np.linalg.norm(g, axis=-1, keepdims=True)
    if not np.all(G):
        raise ValueError(f"{name} must have an angular momentum, but g = 0. A body at rest has no direction to draw.")
    return np.asarray(g / G)


def _facing(moments: Array, n: Array) -> Array:
    """Return a direction in the octant of n, nearest to the intermediate axis, then to the short one."""
    eye = np.empty(3)
    eye[np.argsort(moments)] = 0.43, 0.75, 0.5
    return np.asarray(np.where(n >= 0, eye, -eye) / np.linalg.norm(eye))


# ---------------------------------------------------------------------- words


def _names(moments: Array) -> list[str]:
    """Return the names of the principal axes."""
    if spherical(moments):
        return ["axis"] * 3
    long, middle, short = np.argsort(moments)
    names = ["equatorial axis"] * 3
    if moments[long] < moments[middle] < moments[short]:
        names[middle] = "intermediate axis"
    if moments[long] < moments[middle]:
        names[long] = "long axis"
    if moments[middle] < moments[short]:
        names[short] = "short axis"
    return names


def _title(moments: Array, forced: bool) -> str:
    listed = "$I$ = (" + ", ".join(f"{moment:.4g}" for moment in moments) + ")"
    if spherical(moments):
        return f"Spherical body: every direction of the angular momentum is fixed\n{listed}"
    whose = "; curves of the body free of torques" if forced else ""
    return f"Directions of the angular momentum in the principal axes\n{listed}{whose}"
