"""Observables: numbers that an instrument reads of a motion, by one formula.

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method the
formula. The base class makes it a frozen dataclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Parametric
from poinsot.records.units import DerivedUnits

__all__ = ["Observable"]


class Observable(Parametric, ABC):
    """Measurement of a motion at an instant by one formula; the base class of all observables.

    A subclass defines `reading(instant)`, which returns one scalar, or as many scalars as `components` has names. The
    same formula gives partial derivatives with respect to the state and to named parameters.

    Examples
    --------
    >>> class Beacon(pt.Observable):
    ...     position: pt.BodyVector
    ...     station: pt.Orbit
    ...     def reading(self, instant):
    ...         place = instant.position(self.station) + instant.attitude.to_space(self.position)
    ...         return pt.functions.norm(place)
    >>> beacon = Beacon((0, 0, 1), pt.orbits.FixedPosition(1.0, position=(3, 0, 0)))
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 1, 0)), [0.0, 1.0])
    >>> pt.observe(motion, beacon).values.round(6)
    array([3.162278, 3.878764])
    """

    components: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers of a reading; empty for one scalar."""

    @of_scalars
    @abstractmethod
    def reading(self, instant: Instant) -> Any:
        """Return the reading at an instant: a scalar, or a vector of scalars with one entry for each component."""

    def unit(self, units: DerivedUnits) -> str:  # noqa: ARG002
        """Return the unit of a reading in CF notation for the units of a system; "" if it is unknown."""
        return ""

    @property
    def frame(self) -> str:
        """Axes of the components, "body" or "space"; "" for scalars."""
        return ""

    @of_scalars
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return, by reason, True where the instrument has no reading, such as a blinded sensor; readings are NaN."""
        return {}

    def time_of_body(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the times at which the body was as it is read at the given times: earlier by the light time."""
        return time
