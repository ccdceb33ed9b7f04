"""Observables: numbers that an instrument reads of a motion, by one formula.

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method the
formula. The base class makes it a frozen dataclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot.functions import Scalar
from poinsot.mechanics.block import default_name
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.light_time import emission_time, speed_of_light
from poinsot.mechanics.two_bodies import check_name_of_body
from poinsot.quantities import Array
from poinsot.records.members import expanded, of_scalars
from poinsot.records.parameters import Parametric, kinds_of
from poinsot.records.units import DerivedUnits

__all__ = ["Observable", "ObservableOn", "deviation_of", "observables_by_name"]


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
    array([3.162278, 3.879282])
    """

    components: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers of a reading; empty for one scalar."""

    not_finite: ClassVar[str] = "value is not finite"
    """Reason why a reading that is infinite or not a number is absent, such as "zero flux" for a magnitude."""

    @property
    def has_unknown_factor(self) -> bool:
        """True if readings are known but for a factor, which differs between `Readings`, as in relative photometry."""
        return False

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
        """Return, by reason, True where the instrument has no reading, such as a blinded sensor; readings are NaN.

        There is also no reading at times at which an observer does not see the body, see `Orbit.hidden_at`.
        """
        return {}

    def check_values(self, values: Array) -> None:
        """Raise a ValueError for values that the instrument cannot read; NaN where there is no reading."""

    def check_times(self, times: Array) -> None:
        """Raise a ValueError for times at which the formula does not hold, such as an observer inside the body."""

    @property
    def light_path(self) -> Orbit | None:
        """Orbit of the body relative to the observer, whose light time is subtracted; None without light time."""
        return None

    def time_of_body(self, time: Array, units: DerivedUnits) -> Array:
        """Return the times at which the body was as it is read at the given times: earlier by the light time.

        Times have the shape (n,). If the light time depends on the member, the result has the shape (members, n).
        """
        path = self.light_path
        return time if path is None else emission_time(path, time, speed_of_light(units))

    # ------------------------------------------------------------------ errors of readings

    @property
    def errors(self) -> tuple[str, ...]:
        """Names of the numbers of an error of a reading; empty for one scalar. By default the components."""
        return self.components

    def difference(self, read: Array, predicted: Array) -> Array:
        """Return the errors of readings with respect to predictions; with `errors`, arrays have them as last axis."""
        return read - predicted

    def disturbed(self, readings: Array, errors: Array) -> Array:
        """Return readings with errors, whose `difference` from the readings is the errors."""
        return readings + errors

    def on(self, body: str) -> Observable:
        """Return the same observable of one of two bodies, "primary" or "secondary"."""
        return ObservableOn(self, body)


class ObservableOn(Observable):
    """Observable of one body, read of one of two bodies; made by `observable.on("secondary")`."""

    observable: Observable
    body: str

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name_of_body(self.body)

    @override
    def __repr__(self) -> str:
        return f"{self.observable!r}.on({self.body!r})"

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        name, fields = self.observable.definition
        return name, fields | {"on": self.body}

    @property
    def components(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the numbers of a reading."""
        return self.observable.components

    @property
    def not_finite(self) -> str:  # type: ignore[override]
        """Reason why a reading that is not finite is absent."""
        return self.observable.not_finite

    @property
    @override
    def has_unknown_factor(self) -> bool:
        return self.observable.has_unknown_factor

    @override
    def reading(self, instant: Any) -> Any:
        return self.observable.reading(getattr(instant, self.body))

    @override
    def unit(self, units: DerivedUnits) -> str:
        return self.observable.unit(units)

    @property
    @override
    def frame(self) -> str:
        return self.observable.frame

    @override
    def validity(self, instant: Any) -> Mapping[str, Scalar]:
        return self.observable.validity(getattr(instant, self.body))

    @override
    def check_times(self, times: Array) -> None:
        self.observable.check_times(times)

    @property
    @override
    def light_path(self) -> Orbit | None:
        return self.observable.light_path

    @override
    def time_of_body(self, time: Array, units: DerivedUnits) -> Array:
        return self.observable.time_of_body(time, units)

    @property
    @override
    def errors(self) -> tuple[str, ...]:
        return self.observable.errors

    @override
    def difference(self, read: Array, predicted: Array) -> Array:
        return self.observable.difference(read, predicted)

    @override
    def disturbed(self, readings: Array, errors: Array) -> Array:
        return self.observable.disturbed(readings, errors)


def deviation_of(observable: Observable) -> Array:
    """Return the standard deviation of errors where data state none: the field `noise` of an observable, or 0.

    It broadcasts against errors, members and times first.
    """
    record = observable.observable if isinstance(observable, ObservableOn) else observable
    noise = np.asarray(getattr(record, "noise", 0.0), dtype=float)
    own = len(kinds_of(type(record)).get("noise", ()))
    axes = 2 if own or not observable.errors else 3  # one number of each member for several errors
    return expanded(noise, axes, own) if noise.ndim > own else noise


def observables_by_name(observables: Iterable[Observable]) -> dict[str, Observable]:
    """Return observables by names: a class in lower case with underscores; the second gyro is `gyro_2`."""
    found: dict[str, Observable] = {}
    for each in observables:
        name = _name_of(each)
        count = sum(known == name or known.startswith(f"{name}_") for known in found)
        found[f"{name}_{count + 1}" if count else name] = each
    return found


def _name_of(observable: Observable) -> str:
    if isinstance(observable, ObservableOn):
        return f"{observable.body}_{_name_of(observable.observable)}"
    return default_name(type(observable))
