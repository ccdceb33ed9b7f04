"""Orbit of two bodies about each other, in its plane."""

from __future__ import annotations

import numpy as np
from typing_extensions import Unpack

from poinsot.plot.labels import BLUE, GREY, VERMILION, one_member, unit_of
from poinsot.plot.panels import Axes, PanelOptions, dress, one_panel, plot
from poinsot.plot.solid_parts import surfaces
from poinsot.plot.solids import draw_path
from poinsot.plot.time_axis import instant
from poinsot.propagation.trajectory import OfTwoBodies
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array

__all__ = ["mutual_orbit"]

BODIES = {"primary": BLUE, "secondary": VERMILION}


@plot
def mutual_orbit(
    motion: OfTwoBodies,
    *,
    length_unit: str | None = None,
    time_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw the orbit of the secondary about the primary, and the outlines of both bodies at the last time, to scale.

    The view is along the normal of the orbit at the first time, when the secondary is on the right of the primary.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, whose samples a line joins. A body made of a shape is drawn as the convex hull of each of
        its parts, and any other body as the homogeneous ellipsoid with its mass and moments.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel, with equal scales on both axes and the centre of mass of the primary at the origin.

    Raises
    ------
    TypeError, ValueError
        If the motion is not a motion of two bodies, is an ensemble, or contains no times.

    Examples
    --------
    >>> pt.plot.mutual_orbit(pair_motion).get_xlabel()
    'along the line of centres at the first time [m]'
    """
    one_member(motion)
    across = _plane(motion)
    unit = unit_of("length_unit", motion.system.units["length"], length_unit)
    path, panel = unit.factor * motion.position @ across, one_panel((6.4, 6.4), **options)
    draw_path(panel, path, color=GREY, linewidth=0.8, label="orbit of the secondary")
    places = {"primary": np.zeros(2), "secondary": path[-1]}
    for (body, colour), mass in zip(BODIES.items(), two_bodies(motion.system).masses, strict=True):
        one = motion.of_bodies[body]
        label = f"{body} at {instant(motion, motion.times[-1], time_unit)}" if body == "secondary" else body
        for points in surfaces(one.system.of_bodies[""], mass):
            outline = _hull(unit.factor * one.attitude[-1].apply(points) @ across)
            panel.fill(*(places[body] + outline).T, color=colour, linewidth=0.5, label=label, zorder=3)
            label = ""
    panel.set_aspect("equal")
    panel.locator_params(nbins=7)
    along = f"along the line of centres at the first time{unit.label}"
    dress(panel, along, f"across it, in the plane of the orbit{unit.label}")
    return panel


def _plane(motion: OfTwoBodies) -> Array:
    """Return the line of centres and the direction across it in the plane of the orbit, at the first time; (3, 2)."""
    out = motion.position[0] / np.linalg.norm(motion.position[0])
    onwards = motion.velocity[0] - motion.velocity[0] @ out * out
    if not np.any(onwards):  # the bodies fall straight towards each other
        onwards = np.linalg.svd(out[None])[2][1]
    return np.stack([out, onwards / np.linalg.norm(onwards)], axis=-1)


def _hull(points: Array) -> Array:
    """Return the corners of the convex hull of points of a plane, or all points if they span no area."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return points
