"""Readings of an observable at times: simulated or measured values, or a plan of measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, curves, formatted, formatted_times
from poinsot.errors import real_numbers, reals_or_nan
from poinsot.mechanics.environment import orbits_of
from poinsot.mechanics.observable import Observable, deviation_of
from poinsot.printable import quoted
from poinsot.quantities import Array, Times
from poinsot.random_numbers import normal_numbers
from poinsot.records.calendar import Calendar, attributes_of_time, holds_dates
from poinsot.records.members import members_of

if TYPE_CHECKING:
    import xarray

__all__ = ["Readings"]

Several = int | slice | Sequence[int] | NDArray[np.int_] | NDArray[np.bool_]

NO_ATTRIBUTES: Mapping[str, str] = {}
EVERY = slice(None)
MAX_SEED = 2**52

OF_VALUES = ("units", "frame")
"""Attributes that describe the values; the others describe the dataset, but for the unit of time."""


class Readings(Summarized):
    """Values of an observable at times, simulated by `observe` or measured.

    Parameters
    ----------
    observable : Observable
        Observable that the values belong to.
    times : array (n,)
        Times of the readings, in the unit of time of the system; dates if there is a calendar.
    values : array (n,), (n, components), or with an axis of members first, optional
        Values in the unit of the observable; NaN where there is no reading. Without values, the readings are a plan of
        measurements.
    sigma : float or array, optional
        Standard deviation of the error of each value; positive. One number is for all values, an array (n,) for the
        times, (errors,) for the components of an error. Default: `noise` of the observable, if it is positive.
    name : str
        Name of the readings; by default the name of the class of the observable.
    calendar : Calendar, optional
        Calendar of the times. Default: the calendar of the orbits of the observable.
    attributes : mapping
        Unit of the values ("units"), their axes ("frame"), unit of the times ("time_units") and provenance.

    Raises
    ------
    TypeError, ValueError
        If the shapes of times, values and sigma differ, or sigma is not positive.

    Examples
    --------
    >>> gyro = pt.observables.Gyro(noise=0.05)
    >>> plan = pt.observables.Readings(gyro, np.linspace(0, 10, 101))
    >>> plan.values is None, float(plan.sigma)
    (True, 0.05)
    """

    observable: Observable
    name: str
    times: Array
    values: Array | None
    sigma: Array | None
    calendar: Calendar | None
    attributes: Mapping[str, str]

    @checked
    def __init__(
        self,
        observable: Observable,
        times: Times,
        values: ArrayLike | None = None,
        sigma: ArrayLike | None = None,
        *,
        name: str = "",
        calendar: Calendar | None = None,
        attributes: Mapping[str, str] = NO_ATTRIBUTES,
    ) -> None:
        self.observable, self.name = observable, name or _name_of(observable)
        self.calendar = calendar or next((each.calendar for each in orbits_of(observable) if each.calendar), None)
        unit = self.calendar.unit if self.calendar else "1"
        self.attributes = {"time_units": unit, **attributes}
        self.times = _checked_times(times, self.calendar, self.attributes["time_units"])
        self.values = None if values is None else reals_or_nan("values", values)
        self.sigma = self._checked_sigma(sigma)
        shape = (self.times.size, *_length(observable.components))
        if self.values is not None and (self.values.ndim > len(shape) + 1 or self.values.shape[-len(shape) :] != shape):
            raise ValueError(f"values must have shape {shape} or {('members', *shape)}, got shape {self.values.shape}.")
        if self.values is not None:
            self._refuse_infinite_values()
            observable.check_values(self.values)

    def _refuse_infinite_values(self) -> None:
        values = np.asarray(self.values)
        infinite = np.isinf(values)
        if infinite.any():
            place = np.argwhere(infinite)[0]
            found, time = values[tuple(place)], self.times[place[len(self._members)]]
            raise ValueError(
                f"values must be finite, or NaN where there is no reading, got {found} of {self.name} "
                f"at t = {time:.10g}."
            )

    def _checked_sigma(self, sigma: ArrayLike | None) -> Array | None:
        """Return the standard deviation of errors, that broadcasts against them; None if it is unknown."""
        own = deviation_of(self.observable)
        given = np.asarray(own) if sigma is None else real_numbers("sigma", sigma)
        if sigma is None and not np.all(own > 0):
            return None
        if not np.all(given > 0):
            raise ValueError(
                f"sigma must be positive, got {quoted(float(np.min(given)))}. Give the standard deviation of a reading."
            )
        errors = self._error
        if errors and given.shape == self.times.shape and given.shape != errors:
            given = given[:, None]
        full = (*self._members, self.times.size, *errors)
        try:
            fits = np.broadcast_shapes(given.shape, full) == full
        except ValueError:
            fits = False
        if not fits:
            raise ValueError(f"sigma must have shape () or {full}, got shape {given.shape}.")
        return given

    # ------------------------------------------------------------------ shapes

    @property
    def _members(self) -> tuple[int, ...]:
        """Shape of the axis of members: (members,), or () for one body."""
        own = 1 + bool(self.observable.components)
        return self.observable.member_axis if self.values is None else self.values.shape[: self.values.ndim - own]

    @property
    def _error(self) -> tuple[int, ...]:
        """Shape of the error of one reading: (errors,), or () for one scalar."""
        return _length(self.observable.errors)

    @property
    def is_ensemble(self) -> bool:
        """True if the first axis of the values is the axis of members."""
        return bool(self._members)

    def __len__(self) -> int:
        """Return the number of times."""
        return self.times.size

    @checked
    def isel(self, *, time: Several = EVERY, member: Several = EVERY) -> Readings:
        """Return the readings at some of their times, or of some members, selected by index.

        Parameters
        ----------
        time : int, slice, array of int or of bool, optional
            Indices of times; the result has an axis of times in any case.
        member : int, slice, array of int or of bool, optional
            Index of one member, whose values have no axis of members, or indices of several members.

        Raises
        ------
        ValueError
            If a member is chosen, and the readings are of one body.
        """
        if not self.is_ensemble and not (isinstance(member, slice) and member == EVERY):
            raise ValueError("readings must be of an ensemble to have members, but they are of one body.")
        at: Any = np.atleast_1d(np.arange(self.times.size)[time])
        who: Any = member
        values = self.values
        if values is not None:
            values = values[who][..., at, :] if self.observable.components else values[who][..., at]
        sigma = self.sigma
        if sigma is not None:
            full = np.broadcast_to(sigma, (*self._members, self.times.size, *self._error))
            full = full[who] if self.is_ensemble else full
            sigma = sigma if not sigma.ndim else full[..., at, :] if self._error else full[..., at]
        members = who if isinstance(who, int | slice) else np.asarray(who)
        observable = members_of(self.observable, members) if self.is_ensemble else self.observable
        return self._with(observable=observable, times=self.times[at], values=values, sigma=sigma)

    def _with(self, **changes: Any) -> Readings:
        names = ("observable", "times", "values", "sigma", "name", "calendar", "attributes")
        given = {name: getattr(self, name) for name in names} | changes
        return Readings(given.pop("observable"), given.pop("times"), given.pop("values"), given.pop("sigma"), **given)

    # ------------------------------------------------------------------ other readings

    @checked
    def of(self, observable: Observable) -> Readings:
        """Return the same data as readings of another observable, such as the same instrument with another bias."""
        return self._with(observable=observable)

    def with_values(self, values: ArrayLike) -> Readings:
        """Return readings at the same times with other values."""
        return self._with(values=values)

    @checked
    def simulated(self, seed: int) -> Readings:
        """Return the readings with noise: normally distributed errors with the standard deviation `sigma`.

        The errors depend on the seed, the member and the index of the time alone, like the noise of `NoisySensors`.

        Parameters
        ----------
        seed : int
            Whole number from 0 to 2^52.

        Raises
        ------
        ValueError
            If there are no values or no standard deviation, or the seed is out of range.

        Examples
        --------
        >>> gyro = pt.observables.Gyro(noise=0.05)
        >>> pt.observe(motion, gyro).simulated(seed=7).values.shape
        (201, 3)
        """
        if not 0 <= seed <= MAX_SEED:
            raise ValueError(f"seed must be a whole number from 0 to 2^52, got {seed}.")
        if self.values is None:
            raise ValueError("readings must have values to be simulated, got a plan. Write pt.observe(motion, plan).")
        if self.sigma is None:
            raise ValueError(
                "sigma must be positive, got none. Give the standard deviation of a reading, or the noise of the "
                "observable."
            )
        (members,), (count,) = self._members or (1,), self._error or (1,)
        normal = normal_numbers(seed, members, self.times.size, count)
        errors = self.sigma * normal.reshape(*self._members, self.times.size, *self._error)
        return self._with(values=self.observable.disturbed(self.values, errors))

    # ------------------------------------------------------------------ summary and dataset

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Readings of {self.name}", {
            "observable": repr(self.observable),
            "members": str(*self._members) if self.is_ensemble else "",
            "times": formatted_times(self.times, self.attributes["time_units"]),
            "values": formatted(self.values, self.attributes.get("units", "1")) or "none, a plan of measurements",
            "absent": str(np.sum(np.isnan(self.values))) if self.values is not None and self._absent else "",
            "sigma": formatted(self.sigma, self.attributes.get("units", "1")),
        }

    @property
    def _absent(self) -> bool:
        return self.values is not None and bool(np.isnan(self.values).any())

    @override
    def _repr_html_(self) -> str:
        if self.values is None or self.is_ensemble:
            return super()._repr_html_()
        components = self.observable.components
        lines = dict(zip(components, self.values.T, strict=True)) if components else {self.name: self.values}
        unit = self.attributes["time_units"]
        return super()._repr_html_() + curves(self.attributes.get("units", "1"), self.times, lines, unit)

    @property
    def dataset(self) -> xarray.Dataset:
        """Readings as an xarray Dataset with units, frames and provenance."""
        import xarray

        of_values = {name: self.attributes[name] for name in OF_VALUES if name in self.attributes}
        own = {name: text for name, text in self.attributes.items() if name not in (*OF_VALUES, "time_units")}
        variables = {}
        components = self.observable.components
        axis = "component" if self.observable.errors == components else "error"
        coordinates = {"component": list(components)} if components else {}
        coordinates |= {axis: list(self.observable.errors)} if self._error else {}
        for name, array, last, sizes in (
            ("values", self.values, "component", _length(components)),
            ("sigma", self.sigma, axis, self._error),
        ):
            if array is not None:
                full = np.broadcast_to(array, (*self._members, self.times.size, *sizes))
                dims = ("member",) * self.is_ensemble + ("time",) + (last,) * bool(sizes)
                variables[name] = (dims, full, of_values)
        time = ("time", self.times, {"units": self.attributes["time_units"], **attributes_of_time(self.calendar)})
        attributes = {"name": self.name, "observable": repr(self.observable), **own}
        return xarray.Dataset(variables, coords={"time": time, **coordinates}, attrs=attributes)


def _name_of(observable: Observable) -> str:
    """Return the name of the class of an observable, and of one of two bodies the name of the body."""
    name, fields = observable.definition
    return f"{name} of the {fields['on']}" if "on" in fields else name


def _length(components: tuple[str, ...]) -> tuple[int, ...]:
    return (len(components),) if components else ()


def _checked_times(times: Any, calendar: Calendar | None, unit: str) -> Array:
    """Return times as numbers, dates by a calendar; shape (n,), n > 0."""
    if holds_dates(times):
        if calendar is None:
            raise ValueError("times must be numbers without a calendar, got dates. Give calendar=Calendar(...).")
        times = calendar.time(times)
    t = real_numbers("times", times, unit)
    if t.ndim != 1 or not t.size:
        raise ValueError(f"times must have shape (n,), n > 0, got shape {t.shape}.")
    return t
