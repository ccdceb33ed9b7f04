"""Standard deviations of attitude and angular momentum against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.analysis.transition_matrix import StateTransition
from poinsot.checked import checked
from poinsot.mechanics.parameters import described
from poinsot.plot.labels import (
    BLACK,
    BLUE,
    VERMILION,
    angle_unit_of,
    bracketed,
    checked_motion,
    momentum_unit,
    time_label,
    time_unit_of,
)
from poinsot.plot.panels import panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Pair = Sequence[Axes] | NDArray[Any] | None

__all__ = ["uncertainty"]


@checked
def uncertainty(
    transition: StateTransition,
    initial: ArrayLike,
    of_parameters: ArrayLike | None = None,
    *,
    axes: Pair = None,
    angle_unit: str = "deg",
    time_unit: str | None = None,
    title: str = "",
) -> NDArray[Any]:
    """Draw the standard deviations of the rotation vector (left) and of the angular momentum (right), body axes.

    Parameters
    ----------
    transition : StateTransition
        Of one body in six coordinates.
    initial, of_parameters : arrays
        As in `StateTransition.covariance`.
    axes : pair of matplotlib Axes, optional
        Where to draw; default: a new figure.
    angle_unit : {"deg", "rad", "mrad", "arcmin", "arcsec", "rev"}
        Of the rotation vector.
    time_unit : {"s", "min", "h", "d", "yr"}, optional
        Where the system names its unit of time; default: that one.
    title : str

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    if not isinstance(transition, StateTransition):
        raise TypeError(f"transition must be a StateTransition, got {described(transition)}.")
    motion = checked_motion(transition.motion, "transition.motion")
    covariance = transition.covariance(initial, of_parameters)
    if covariance.shape[-1] != 6:
        raise ValueError("transition must have six coordinates, but it is of planar motion. Leave formulation out.")
    deviations: NDArray[np.float64] = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    units, angle = motion.system.units, angle_unit_of(angle_unit)
    time = time_unit_of(units, time_unit)
    names = (
        (r"$\sigma_{{\theta_{}}}$", rf"$1\sigma$ of the attitude{angle.label}"),
        (r"$\sigma_{{g_{}}}$", rf"$1\sigma$ of the angular momentum{bracketed(momentum_unit(units))}"),
    )
    attitude, momentum = np.split(deviations, 2, axis=-1)
    drawn = panels(axes, 2, (10, 4), title)
    for ax, (name, label), columns in zip(drawn, names, (angle.factor * attitude, momentum), strict=True):
        for i, (color, column) in enumerate(zip((BLACK, BLUE, VERMILION), columns.T, strict=True), 1):
            ax.plot(time.factor * motion.times, column, color=color, label=name.format(i))
        ax.set(xlabel=time_label(motion, time), ylabel=label, yscale="log")
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    return drawn
