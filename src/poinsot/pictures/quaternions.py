"""The two quaternions against time, as in the paper's figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.pictures.labels import BLACK, BLUE, GREEN, VERMILION, bracketed, checked_motion, momentum_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from poinsot.motion.trajectory import Trajectory

__all__ = ["plot_quaternions"]


def plot_quaternions(motion: Trajectory, title: str = "") -> NDArray[Any]:
    """Draw the four components of q (left) and of Q (right) against time.

    Parameters
    ----------
    motion : Trajectory
        Units on the axes are those of its system.
    title : str
        Above both panels.

    Returns
    -------
    array (2,) of matplotlib Axes
        Their figure is `axes[0].figure`, for `savefig`.

    Raises
    ------
    TypeError, ValueError
        If it is no trajectory, or one of an ensemble.
    """
    import matplotlib.pyplot as plt

    motion = checked_motion(motion)
    units = motion.system.units
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), layout="constrained", sharex=True)
    _draw(axes[0], motion.times, motion.quaternion, "q", "Euler parameters $q$")
    _draw(
        axes[1], motion.times, motion.conjugate_momenta, "Q", f"conjugate momenta $Q${bracketed(momentum_unit(units))}"
    )
    for panel in axes:
        panel.set_xlabel(f"time{bracketed(units['time'])}")
        panel.set_xlim(np.min(motion.times), np.max(motion.times))
    if title:
        figure.suptitle(title)
    return np.asarray(axes)


def _draw(panel: Axes, times: NDArray[Any], components: NDArray[Any], letter: str, label: str) -> None:
    colours = (BLACK, BLUE, VERMILION, GREEN)
    for i, (values, colour) in enumerate(zip(components.T, colours, strict=True)):
        panel.plot(times, values, color=colour, linewidth=1.1, label=f"${letter}_{i}$")
    panel.set_ylabel(label)
    panel.margins(y=0.08)
    panel.grid(alpha=0.25)
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, 1.11), ncols=4, frameon=False)
