"""Standard deviations of attitude and angular momentum against time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.analysis.transition_matrix import StateTransition
from poinsot.checked import checked
from poinsot.mechanics.parameters import described
from poinsot.plot.labels import BLACK, BLUE, VERMILION, bracketed, checked_motion, momentum_unit, time_label

__all__ = ["uncertainty"]


@checked
def uncertainty(transition: StateTransition, initial: ArrayLike, of_parameters: ArrayLike | None = None) -> Any:
    """Draw the standard deviations of the rotation vector (left) and of the angular momentum (right), body axes.

    Parameters
    ----------
    transition : StateTransition
        Of one body in six coordinates.
    initial, of_parameters : arrays
        As in `StateTransition.covariance`.

    Returns
    -------
    array (2,) of matplotlib Axes
    """
    import matplotlib.pyplot as plt

    from poinsot.plot.figure import TextFigure

    if not isinstance(transition, StateTransition):
        raise TypeError(f"transition must be a StateTransition, got {described(transition)}.")
    motion = checked_motion(transition.motion, "transition.motion")
    covariance = transition.covariance(initial, of_parameters)
    if covariance.shape[-1] != 6:
        raise ValueError("transition must have six coordinates, but it is of planar motion. Leave formulation out.")
    deviations: NDArray[np.float64] = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    figure = plt.figure(FigureClass=TextFigure, figsize=(10, 4), layout="constrained")
    axes: NDArray[Any] = np.asarray(figure.subplots(1, 2))
    unit = bracketed(momentum_unit(motion.system.units))
    names = (r"$\sigma_{{\theta_{}}}$", "attitude, standard deviation [rad]"), (r"$\sigma_{{g_{}}}$", f"momentum{unit}")
    for ax, (name, label), columns in zip(axes, names, np.split(deviations, 2, axis=-1), strict=True):
        for i, (color, column) in enumerate(zip((BLACK, BLUE, VERMILION), columns.T, strict=True), 1):
            ax.plot(motion.times, column, color=color, label=name.format(i))
        ax.set(xlabel=time_label(motion.system), ylabel=label, yscale="log")
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    return axes
