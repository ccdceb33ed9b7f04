"""Standard deviations of attitude, angular momentum and relative orbit against time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from poinsot.analysis.transition_matrix import StateTransition
from poinsot.errors import real_array
from poinsot.mechanics.two_bodies import BODIES
from poinsot.mechanics.units import DerivedUnits
from poinsot.plot.curves import PairOptions, against_time
from poinsot.plot.labels import angle_unit_of, bracketed, momentum_label, one_member
from poinsot.plot.panels import plot

__all__ = ["uncertainty"]

Array = NDArray[np.float64]


@plot
def uncertainty(
    transition: StateTransition,
    initial: ArrayLike,
    of_parameters: ArrayLike | None = None,
    *,
    angle_unit: str | None = None,
    **options: Unpack[PairOptions],
) -> NDArray[Any]:
    """Draw the standard deviations of the rotation vector (left) and of the angular momentum (right), body axes.

    For two bodies both are drawn for each, together with the standard deviations of the relative position and momentum,
    space axes.

    Parameters
    ----------
    transition : StateTransition
        Transition of a motion, not of an ensemble. The coordinates of parts are not drawn.
    initial : array (k, k)
        Covariance at the initial time, as in `StateTransition.covariance`.
    of_parameters : array (p, p), optional
        Covariance of the parameters, as in `StateTransition.covariance`.
    {options}

    Returns
    -------
    array (2,) or (4,) of matplotlib Axes
        Two panels for one body, four for two bodies.

    Raises
    ------
    TypeError, ValueError
        If the transition is of an ensemble or of planar motion.

    Examples
    --------
    >>> transition = pt.analysis.state_transition(motion.system, motion.initial, motion.times)
    >>> start = np.diag([1e-3] * 3 + [1e-2] * 3) ** 2  # of the rotation vector, rad, and of the angular momentum
    >>> attitude, momentum = pt.plot.uncertainty(transition, start, angle_unit="arcsec", time_unit="min")
    >>> attitude.get_xlabel()
    'time [min]'
    """
    coordinates = transition.coordinates
    if not coordinates[0].endswith("theta_1"):
        raise ValueError(f"transition must be in space, from theta_1 on, got {coordinates[0]}. Leave formulation out.")
    motion = one_member(transition.motion, "transition.motion")
    covariance = transition.covariance(real_array("initial", initial, (None, None)), of_parameters)
    deviations = dict(zip(coordinates, np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)).T, strict=True))
    turned = [each for name, each in deviations.items() if name.endswith(("theta_1", "theta_2", "theta_3"))]
    angle, units = angle_unit_of(angle_unit, turned), motion.system.units
    curves = {
        rf"$1\sigma$ of the attitude{angle.label}": _of("theta", deviations, r"\theta", angle.factor),
        rf"$1\sigma$ of the angular momentum{momentum_label(units)}": _of("g", deviations, "g"),
    }
    if len(motion.of_bodies) > 1:
        lengths = bracketed(units["length"]), bracketed(DerivedUnits(units).linear_momentum)
        curves |= {
            rf"$1\sigma$ of the position{lengths[0]}": _of("position", deviations, "r"),
            rf"$1\sigma$ of the momentum{lengths[1]}": _of("momentum", deviations, "p"),
        }
    return against_time(motion, curves, log=True, **options)


def _of(kind: str, deviations: dict[str, Array], symbol: str, factor: float = 1.0) -> dict[str, Array]:
    """Return the curves of the coordinates of a kind, of each body, by their label."""
    named = {name: name.rpartition(".") for name in deviations}
    return {
        rf"{body} $\sigma_{{{symbol}_{short[-1]}}}$".strip(): factor * deviations[name]
        for name, (body, _, short) in named.items()
        if short[:-2] == kind and body in ("", *BODIES)
    }
