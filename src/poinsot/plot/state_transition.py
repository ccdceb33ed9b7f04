"""Standard deviations of attitude and angular momentum against time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.analysis.transition_matrix import StateTransition
from poinsot.plot.curves import against_time
from poinsot.plot.labels import angle_unit_of, momentum_label, one_body
from poinsot.plot.panels import Pair, plot

__all__ = ["uncertainty"]


@plot
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
        Of one body in six coordinates, and those of its parts, which are not drawn.
    initial, of_parameters : arrays
        As in `StateTransition.covariance`.
    {options}

    Returns
    -------
    array (2,) of matplotlib Axes

    Raises
    ------
    TypeError, ValueError
        If it is of an ensemble or of planar motion.

    Examples
    --------
    >>> transition = pt.analysis.state_transition(motion.system, motion.initial, motion.times)
    >>> start = np.diag([1e-3] * 3 + [1e-2] * 3) ** 2  # of the rotation vector, rad, and of the angular momentum
    >>> attitude, momentum = pt.plot.uncertainty(transition, start, angle_unit="arcsec", time_unit="min")
    >>> attitude.get_xlabel()
    'time [min]'
    """
    if transition.coordinates[0] != "theta_1":
        raise ValueError(
            f"transition must be of one body in space, from theta_1 on, got {transition.coordinates[0]}. Leave "
            "formulation out; of two bodies draw the diagonal of `covariance`."
        )
    motion = one_body(transition.motion, "transition.motion")
    covariance = transition.covariance(initial, of_parameters)
    deviations: NDArray[np.float64] = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)).T
    angle = angle_unit_of(angle_unit)
    attitude = {rf"$\sigma_{{\theta_{i + 1}}}$": angle.factor * deviations[i] for i in range(3)}
    momentum = {rf"$\sigma_{{g_{i + 1}}}$": deviations[i + 3] for i in range(3)}
    curves = {
        rf"$1\sigma$ of the attitude{angle.label}": attitude,
        rf"$1\sigma$ of the angular momentum{momentum_label(motion.system.units)}": momentum,
    }
    return against_time(motion, curves, axes, time_unit, title, log=True)
