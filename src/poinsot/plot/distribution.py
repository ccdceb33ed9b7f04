"""Histograms of a quantity over the members of an ensemble."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Unpack

from poinsot.plot.labels import BLACK, BLUE, VERMILION, angle_unit_of, momentum_label, one_rotation, rate_unit_of
from poinsot.plot.panels import PanelOptions, dress, one_panel, plot
from poinsot.printable import quoted
from poinsot.propagation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["QUANTITIES", "histogram"]

Array = NDArray[np.float64]

BINS = 80

QUANTITIES = {
    "effective_rate": "effective angular velocity 2T/G",
    "rate": "angular velocity",
    "angular_momentum": "angular momentum",
    "turn": "turn of the angular momentum since the first time",
}
"""Quantities with their labels."""


@plot
def histogram(
    ensemble: Trajectory,
    quantity: str = "effective_rate",
    *,
    angle_unit: str | None = None,
    rate_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw a histogram of a quantity of the members at the last time, with its 5th and 95th percentile.

    The plot shows the medians at the first and at the last time. Members that stopped earlier are omitted.

    Parameters
    ----------
    ensemble : Trajectory
        Ensemble of one body. From a store, only the first and the last time are read.
    quantity : {"effective_rate", "rate", "angular_momentum", "turn"}
        "effective_rate": 2T/G with the kinetic energy T and the magnitude G of the angular momentum. "rate": magnitude
        of the angular velocity. "angular_momentum": G. "turn": angle between the angular momenta at the first and the
        last time.
    {options}

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=np.linspace((0, 0, 1), (0.1, 0, 2), 100))
    >>> tops = pt.propagate(pt.System(body, pt.UniformGravity(0.5, (1, 0, 0))), start, [0, 10])
    >>> pt.plot.histogram(tops, "turn").get_ylabel()
    'members'
    """
    motion = one_rotation(ensemble, "ensemble")
    if not motion.is_ensemble:
        raise ValueError("ensemble must have members, got the motion of one body.")
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity must be one of {', '.join(QUANTITIES)}, got {quoted(quantity)}.")
    first, last = motion.isel(time=[0]), motion.isel(time=[motion.times.size - 1])
    before, after = _values(quantity, first, first), _values(quantity, last, first)
    after = after[np.isfinite(after)]
    if not after.size:
        raise ValueError("ensemble must have members at the last time, got none.")
    factor, written = 1.0, momentum_label(motion.system.units)
    if quantity != "angular_momentum":
        unit = angle_unit_of(angle_unit, after) if quantity == "turn" else None
        unit = unit or rate_unit_of(motion.system.units, rate_unit, after)
        factor, written = unit.factor, unit.label
    panel = one_panel((6.4, 3.6), **options)
    panel.hist(factor * after, bins=BINS, color=BLUE, alpha=0.8)
    for level in (5, 95):
        panel.axvline(factor * float(np.percentile(after, level)), color=BLACK, lw=0.8, ls=":")
    panel.axvline(factor * float(np.median(after)), color=BLACK, lw=1.2, label="median, between 5 and 95 %")
    if quantity != "turn":
        start = factor * float(np.nanmedian(before))
        panel.axvline(start, color=VERMILION, lw=1.2, ls="--", label="median at the first time")
    dress(panel, f"{QUANTITIES[quantity]}{written}", "members")
    return panel


def _values(quantity: str, motion: Trajectory, first: Trajectory) -> Array:
    """Return a quantity of each member at the single time of a motion."""
    if quantity == "rate":
        return np.asarray(np.linalg.norm(motion.omega_body, axis=-1)[:, 0])
    if quantity == "turn":
        one, other = (each.angular_momentum_space[:, 0] for each in (first, motion))
        across = np.linalg.norm(np.cross(one, other), axis=-1)
        return np.asarray(np.arctan2(across, np.vecdot(one, other)))
    size = np.linalg.norm(motion.angular_momentum_body, axis=-1)[:, 0]
    return np.asarray(size if quantity == "angular_momentum" else 2 * motion.kinetic_energy[:, 0] / size)
