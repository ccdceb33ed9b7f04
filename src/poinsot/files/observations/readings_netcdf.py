"""Readings in NetCDF files, which are read bit for bit."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import checked
from poinsot.files.netcdf import READINGS, read_dataset, write_dataset
from poinsot.files.observations.readings_csv import several
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import described, message_of, quoted, shortened
from poinsot.propagation.recorded import RecordedObservable
from poinsot.records.calendar import Calendar
from poinsot.scenarios.system_text import rebuilt_observables, text_of_observables

if TYPE_CHECKING:
    import xarray

__all__ = ["read_readings", "write_readings"]

TEXT = "observable_text"
"""Attribute with the text that makes the observables again."""

ARRAYS = ("time", "values", "sigma")
"""Ends of the names of the variables of readings, of which the last two are optional."""


@checked
def write_readings(readings: Readings | Sequence[Readings], path: str | Path, *, overwrite: bool = False) -> Path:
    """Write readings with their observables to a NetCDF file (.nc) that `read_readings` reads.

    Parameters
    ----------
    readings : Readings or sequence of Readings
        Readings of one body or of an ensemble, or plans of measurements. Their names must differ.
    path : str or Path
        Name of the file, which ends in .nc.
    overwrite : bool
        True to replace an existing file.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If an argument is invalid, two readings have one name, or the file exists.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return instant.omega_body[0]
    >>> seen = pt.observe(motion, Rate())
    >>> path = pt.files.write_readings(seen, "new.readings.nc")
    >>> bool(np.all(pt.files.read_readings(path)[0].values == seen.values))
    True
    """
    import xarray

    path = _checked_path(path)
    found = several(readings)
    _check_names([each.name for each in found])
    variables: dict[str, Any] = {}
    for i, each in enumerate(found):
        for end, array in zip(ARRAYS, (each.times, each.values, each.sigma), strict=True):
            if array is not None:
                own = f"{READINGS}_{i}_{end}"
                variables[own] = _variable(own, array, each.name)
    attributes, arrays = _text_of(found)
    variables |= {name: _variable(name, array, "named in a text") for name, array in arrays.items()}
    attributes[READINGS] = json.dumps([_description(each) for each in found])
    write_dataset(xarray.Dataset(variables, attrs=attributes), path, overwrite)
    return path


def _check_names(names: Sequence[str]) -> None:
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ValueError(f"readings must have different names, got {quoted(name)} twice. Give name=...")


def _variable(name: str, array: NDArray[Any], meaning: str) -> tuple[list[str], NDArray[Any], dict[str, str]]:
    """Return an array as a variable of a dataset, with dimensions of its own."""
    return [f"{name}_axis{i}" for i in range(array.ndim)], array, {"long_name": meaning}


def _text_of(readings: Sequence[Readings]) -> tuple[dict[str, str], Mapping[str, NDArray[Any]]]:
    """Return the text that makes the observables again, or the reason why there is none, and the arrays it names."""
    calendars = {each.calendar for each in readings}
    if len(calendars) > 1:
        return {"not_readable": "the readings of a file must share one calendar, got several."}, {}
    try:
        made = text_of_observables({each.name: each.observable for each in readings}, *calendars)
    except ValueError as error:
        return {"not_readable": str(error)}, {}
    return {TEXT: made.text}, made.data


def _description(readings: Readings) -> dict[str, Any]:
    """Return everything about readings except their numbers."""
    calendar, observable = readings.calendar, readings.observable
    return {
        "name": readings.name,
        "observable": repr(observable),
        "components": list(observable.components),
        "errors": list(observable.errors),
        "calendar": None if calendar is None else [calendar.zero, calendar.scale, calendar.unit],
        "attributes": dict(readings.attributes),
    }


@checked
def read_readings(path: str | Path) -> tuple[Readings, ...]:
    """Return the readings in a file that `write_readings` wrote.

    Numbers are restored bit for bit. Observables are restored from the text in the file. An observable of a class from
    outside the package has no formula; its readings can be plotted and written.

    Parameters
    ----------
    path : str or Path
        Name of the file.

    Returns
    -------
    tuple of Readings
        Readings in the order in which they were written.

    Raises
    ------
    OSError, ValueError
        If the file cannot be opened, was not written by `write_readings`, or is incomplete.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     def reading(self, instant):
    ...         return instant.omega_body[0]
    >>> path = pt.files.write_readings(pt.observe(motion, Rate()), "new.readings.nc")
    >>> pt.files.read_readings(path)[0].values.shape
    (201,)
    """
    path = _checked_path(path)
    name, data = shortened(path), read_dataset(path)
    if READINGS not in data.attrs:
        raise ValueError(f"{name} must have readings, got another file. A motion is read by pt.load.")
    described = _descriptions(data.attrs[READINGS], name)
    observables = _observables(data, described, name)
    try:
        return tuple(
            _readings(data, i, about, observable)
            for i, (about, observable) in enumerate(zip(described, observables, strict=True))
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{name} must have whole readings, got others: {message_of(error)}") from None


def _readings(data: xarray.Dataset, i: int, about: Mapping[str, Any], observable: Observable) -> Readings:
    times, values, sigma = (
        np.array(data[own].values, dtype=float) if (own := f"{READINGS}_{i}_{end}") in data.variables else None
        for end in ARRAYS
    )
    if times is None:
        raise ValueError(f"there are no times of {quoted(about['name'])}.")
    calendar = None if about["calendar"] is None else Calendar(*about["calendar"])
    attributes = {str(key): str(value) for key, value in about["attributes"].items()}
    return Readings(observable, times, values, sigma, name=str(about["name"]), calendar=calendar, attributes=attributes)


def _descriptions(text: Any, name: str) -> list[Mapping[str, Any]]:
    """Return the descriptions of readings in an attribute."""
    try:
        found = json.loads(text)
        whole = all(
            isinstance(each["name"], str)
            and isinstance(each["observable"], str)
            and isinstance(each["attributes"], dict)
            for each in found
        ) and all(isinstance(word, str) for each in found for word in (*each["components"], *each["errors"]))
    except (KeyError, TypeError, ValueError, RecursionError):
        whole = False
    if not whole:
        raise ValueError(f"{name} must describe its readings, got {described(text)}.")
    known: list[Mapping[str, Any]] = found
    return known


def _observables(data: xarray.Dataset, about: Sequence[Mapping[str, Any]], name: str) -> Sequence[Observable]:
    """Return the observables of readings, made again from the text in a file if there is one."""
    reason = str(data.attrs.get("not_readable", "the file contains no text of its observables."))
    if TEXT in data.attrs:
        arrays = {str(key): data[key].values for key in data.variables if str(key).startswith("observable_")}
        try:
            made = rebuilt_observables(str(data.attrs[TEXT]), f"the observables in {name}", data=arrays)
            if len(made) == len(about):
                return made
            reason = f"its text describes {len(made)} observables."
        except (ValueError, TypeError, ImportError) as error:
            reason = message_of(error)
    return [
        RecordedObservable(each["observable"], " ".join(each["components"]), " ".join(each["errors"]), reason=reason)
        for each in about
    ]


def _checked_path(path: str | Path) -> Path:
    if Path(path).suffix != ".nc":
        raise ValueError(f"path must end in .nc, got {quoted(Path(path).name)}.")
    return Path(path)
