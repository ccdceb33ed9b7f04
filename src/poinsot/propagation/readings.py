"""Readings of an observable at times: simulated or measured values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot.display.html_text import Summarized, formatted, formatted_times
from poinsot.errors import real_numbers
from poinsot.mechanics.observable import Observable
from poinsot.printable import quoted

if TYPE_CHECKING:
    import xarray

__all__ = ["Readings"]

NO_ATTRIBUTES: Mapping[str, str] = {}


class Readings(Summarized):
    """Values of an observable at times, simulated by `observe` or measured.

    Parameters
    ----------
    observable : Observable
        Observable that the values belong to.
    times : array (n,)
        Times of the readings.
    values : array (n,), (n, components), or with an axis of members first, optional
        Values in the unit of the observable. Without them the readings are a plan of measurements.
    sigma : float or array, optional
        Standard deviation of each value; positive.
    name : str
        Name of the readings; by default the name of the class of the observable.
    attributes : mapping
        Units, frames and provenance for the dataset.

    Raises
    ------
    ValueError
        If the shapes of times and values differ, or sigma is not positive.
    """

    def __init__(
        self,
        observable: Observable,
        times: ArrayLike,
        values: ArrayLike | None = None,
        sigma: ArrayLike | None = None,
        *,
        name: str = "",
        attributes: Mapping[str, str] = NO_ATTRIBUTES,
    ) -> None:
        self.observable, self.name = observable, name or type(observable).__name__
        self.times = real_numbers("times", times)
        self.values = None if values is None else real_numbers("values", values)
        self.sigma = None if sigma is None else real_numbers("sigma", sigma)
        self.attributes = dict(attributes)
        shape = (self.times.size, *((len(observable.components),) if observable.components else ()))
        if self.values is not None and self.values.shape[-len(shape) :] != shape:
            raise ValueError(f"values must have shape {shape}, got shape {self.values.shape}.")
        if self.sigma is not None and not np.all(self.sigma > 0):
            raise ValueError(
                f"sigma must be positive, got {quoted(float(np.min(self.sigma)))}. "
                "Give the standard deviation of a reading."
            )

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Readings of {self.name}", {
            "times": formatted_times(self.times, self.attributes.get("time_units", "1")),
            "values": formatted(self.values, self.attributes.get("units", "1")),
            "sigma": formatted(self.sigma),
        }

    @property
    def dataset(self) -> xarray.Dataset:
        """Readings as an xarray Dataset with units, frames and provenance."""
        import xarray

        components = self.observable.components
        dims = ("time", "component") if components else ("time",)
        variables = {}
        for name, array in (("values", self.values), ("sigma", self.sigma)):
            if array is not None:
                own = ("member", *dims)[-array.ndim :] if array.ndim else ()
                variables[name] = (own, array, self.attributes)
        coordinates = {"time": self.times, **({"component": list(components)} if components else {})}
        return xarray.Dataset(variables, coords=coordinates, attrs={"observable": repr(self.observable)})
