"""Texts with which a file describes its motion, so that the motion can be computed again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.integration.formulations import formulations
from poinsot.kinematics.state import named
from poinsot.printable import quoted
from poinsot.scenarios.system_text import Text, shape_of, text_of
from poinsot.storage.run_record import Method, RunRecord
from poinsot.systems.system import System

if TYPE_CHECKING:
    import xarray

__all__ = ["OF_SCENARIOS", "WHOLE", "WITH_FILES", "scenario_of", "with_texts"]

OF_SCENARIOS = ("title", "seed", "scenario", "scenario_of", "scenario_read")
"""Entries of a trajectory and of a file about the scenario that made it."""

SYSTEM, WHOLE = "system", "state, times and system"
"""Content of the text of a scenario in a file; the variables of the file contain the rest."""

WITH_FILES = "state, times and system, with files"
"""Content of a scenario that names files. `scenario_read`, the text of the system, and variables replace the files."""

METHODS = {
    Method.TAYLOR: "integration",
    Method.TAYLOR_OF_MEMBERS: "integration",
    Method.CLOSED_FORM: "closed form",
}
"""Names of the methods in a scenario."""


def scenario_of(system: System, run: RunRecord, dense: bool = False) -> Text:
    """Return a system and the options of its run as the text of a scenario.

    A ValueError names the reason if there is none: a class from outside the package, or a motion that was not computed.
    """
    return text_of(system, _options(run, dense))


def with_texts(
    data: xarray.Dataset, system: System, run: RunRecord, provenance: Mapping[str, Any], dense: bool = False
) -> xarray.Dataset:
    """Return the dataset of a motion with the text that makes its system again, or the reason why there is none.

    The arrays that the text names become variables, as do the arrays of the body's shape, whose text is `shape`.
    """
    texts, arrays = _texts_of(system, run, provenance, dense)
    about = {"units": "1", "long_name": "named in a text"}
    own = {
        name: ([f"{name}_axis{i}" for i in range(np.ndim(values))], values, about) for name, values in arrays.items()
    }
    return data.assign(own).assign_attrs(texts)


def _texts_of(
    system: System, run: RunRecord, provenance: Mapping[str, Any], dense: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the texts of scenario and shape, or the reason why there is none, and the arrays that they name."""
    known = {key: provenance[key] for key in OF_SCENARIOS if provenance.get(key) is not None}
    shapes: dict[str, Any] = {}
    for body, one in system.of_bodies.items():
        name = named(body, "shape")
        if shape := shape_of(one, name):
            known[name] = shape.text
            shapes |= shape.data
    if "scenario" in known and ("scenario_read" in known or known["scenario_of"] != WITH_FILES):
        return known, {**provenance.get("data", {}), **shapes}
    if not isinstance(system, System):
        return known | {"not_rerunnable": system.not_rerunnable}, shapes
    try:
        text = scenario_of(system, run, dense)
    except ValueError as error:
        return known | {"not_rerunnable": str(error)}, shapes
    read = {"scenario_read": text.text} if "scenario" in known else {"scenario": text.text, "scenario_of": SYSTEM}
    return known | read, {**text.data, **shapes}


def _options(run: RunRecord, dense: bool) -> dict[str, str | float | bool]:
    known = formulations()
    if run.method not in METHODS:
        raise ValueError(
            f"a motion must be computed from a state to be run again, got a {run.method} ({run.formulation})."
        )
    if run.method is Method.CLOSED_FORM:
        return {"method": "closed form"}
    if run.formulation not in known:
        raise ValueError(
            f"the formulation of a scenario must be one of {', '.join(known)}, got {quoted(run.formulation)}."
        )
    options = {name: getattr(run, name) for name in ("formulation", "tolerance", "precision")}
    return options | ({"dense": True} if dense else {})
