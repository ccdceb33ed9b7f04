"""Librations of one of two bodies against time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import Unpack

from poinsot.analysis.libration import librations as librations_of
from poinsot.plot.curves import SeparateCurveOptions, against_time, jumps, reached
from poinsot.plot.labels import angle_unit_of
from poinsot.plot.panels import plot
from poinsot.propagation.bodies_of_motion import OfTwoBodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["librations"]

MAX_CHANGE = 0.8 * np.pi
"""Angle, radians: a larger change between two samples interrupts the curve."""


@plot
def librations(
    motion: OfTwoBodies,
    body: str = "secondary",
    *,
    ax: Axes | None = None,
    angle_unit: str | None = None,
    **options: Unpack[SeparateCurveOptions],
) -> Axes:
    """Draw yaw, pitch and roll of one of two bodies relative to their orbit.

    The angles of one motion are drawn in the interval of half a turn on either side.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble.
    body : {"secondary", "primary"}
        Body whose principal axes are drawn, oriented as in `pt.analysis.librations`.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel.

    Examples
    --------
    >>> pt.plot.librations(pair_motion, angle_unit="rad").get_ylabel()
    'librations of the secondary [rad]'
    """
    reached(motion)
    found = librations_of(motion, body)
    angles = {name: getattr(found, name) for name in ("roll", "pitch", "yaw")}
    unit = angle_unit_of(angle_unit, list(angles.values()))
    curves = {f"librations of the {body}{unit.label}": {name: unit.factor * each for name, each in angles.items()}}
    breaks = {name: jumps(each, MAX_CHANGE) for name, each in angles.items()}
    panel: Axes = against_time(motion, curves, ax, breaks=breaks, **options)[0]
    return panel
