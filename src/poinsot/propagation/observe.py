"""Simulated measurements: the readings of observables along a motion."""

from __future__ import annotations

from typing import cast

import numpy as np

from poinsot.checked import checked
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.observable import Observable
from poinsot.propagation.readings import Readings
from poinsot.propagation.trajectory import Trajectory
from poinsot.records.units import DerivedUnits

__all__ = ["observe"]


@checked
def observe(motion: Trajectory, *observables: Observable) -> Readings | tuple[Readings, ...]:
    """Return the readings of observables along a motion.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble.
    *observables : Observable
        Instruments.

    Returns
    -------
    Readings or tuple of Readings
        Readings at the times of the motion, one for each observable; for an ensemble the axis of members is first.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 2)), [0.0, 1.0])
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return pt.functions.norm(instant.omega_body)
    >>> pt.observe(motion, Rate()).values
    array([2., 2.])
    """
    found = tuple(_readings(motion, observable) for observable in observables)
    return found[0] if len(found) == 1 else found


def _readings(motion: Trajectory, observable: Observable) -> Readings:
    instant = cast(Instant, motion.system.at(motion._reader.state, motion.environment))
    reading = observable.reading(instant)
    shape = instant.shape
    if observable.components:
        values = np.stack([np.broadcast_to(np.asarray(x, dtype=float), shape) for x in reading], axis=-1)
    else:
        values = np.broadcast_to(np.asarray(reading, dtype=float), shape).copy()
    attributes = {"units": observable.unit(DerivedUnits(motion.system.units)), "frame": observable.frame}
    given = {name: value for name, value in attributes.items() if value}
    return Readings(observable, motion.times, values, attributes=given | {"time_units": motion.system.units["time"]})
