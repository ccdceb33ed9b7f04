"""The two quaternions against time, as in the paper's figures."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.parameters import came
from poinsot.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_quaternions"]

COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73")
"""Black, blue, vermilion and green of Okabe and Ito: told apart by all eyes."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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

    if not isinstance(motion, Trajectory):
        raise TypeError(f"motion must be a Trajectory, but {came(motion)} came.")
    if motion.quaternion.ndim != 2:
        raise ValueError(f"motion must be of one body, but an ensemble of {len(motion.quaternion)} members came.")
    units = motion.system.units
    momentum = " ".join(unit for unit in (units["inertia"], _inverse(units["time"])) if unit != "1") or "1"
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), layout="constrained", sharex=True)
    _draw(axes[0], motion.times, motion.quaternion, "q", "Euler parameters $q$")
    _draw(axes[1], motion.times, motion.conjugate_momenta, "Q", f"conjugate momenta $Q${_bracketed(momentum)}")
    for panel in axes:
        panel.set_xlabel(f"time{_bracketed(units['time'])}")
        panel.set_xlim(np.min(motion.times), np.max(motion.times))
    if title:
        figure.suptitle(title)
    return np.asarray(axes)


def _draw(panel: Axes, times: NDArray[Any], components: NDArray[Any], letter: str, label: str) -> None:
    for i, (values, colour) in enumerate(zip(components.T, COLOURS, strict=True)):
        panel.plot(times, values, color=colour, linewidth=1.1, label=f"${letter}_{i}$")
    panel.set_ylabel(label)
    panel.margins(y=0.08)
    panel.grid(alpha=0.25)
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, 1.11), ncols=4, frameon=False)


def _inverse(unit: str) -> str:
    return "1" if unit == "1" else f"{unit}-1"


def _bracketed(unit: str) -> str:
    """Return a CF unit as people write it: "kg m2 s-1" becomes " [kg m² s⁻¹]"."""
    if unit == "1":
        return " (dimensionless)"
    raised = re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power.group().translate(SUPERSCRIPTS), unit)
    return f" [{raised}]"
