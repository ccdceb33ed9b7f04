"""Texts with which a file describes its motion, so that the motion can be computed again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.integration.formulations import formulations
from poinsot.mechanics.state import named
from poinsot.mechanics.system import System
from poinsot.printable import quoted
from poinsot.propagation.trajectory import Trajectory
from poinsot.scenarios.system_text import Text, shape_of, text_of
from poinsot.storage.run_record import Method

if TYPE_CHECKING:
    import xarray

__all__ = ["OF_SCENARIOS", "WHOLE", "WITH_FILES", "scenario_of", "with_texts"]

OF_SCENARIOS = ("title", "seed", "scenario", "scenario_of", "scenario_read")
"""What a trajectory knows of the scenario that made it, and a file too."""

SYSTEM, WHOLE = "system", "state, times and system"
"""What the text of a scenario in a file is of: the rest is in the variables."""

WITH_FILES = "state, times and system, with files"
"""The scenario names files: what was read from them is in `scenario_read`, the text of the system, and variables."""

METHODS = {
    Method.TAYLOR: "integration",
    Method.TAYLOR_OF_MEMBERS: "integration",
    Method.CLOSED_FORM: "closed form",
}
"""What a scenario calls the methods that it can have."""


def scenario_of(motion: Trajectory) -> Text:
    """Return the system of a motion and the options of its run as the text of a scenario.

    A ValueError names the reason if there is none: a class from outside the package, or a motion that was not computed.
    """
    return text_of(motion.system, _options(motion))


def with_texts(data: xarray.Dataset, motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a motion with the text that makes its system again, or why there can be none.

    Arrays that the text names are variables, and so are those of the body's shape, whose text is `shape`.
    """
    texts, arrays = _texts_of(motion)
    about = {"units": "1", "long_name": "named in a text"}
    own = {
        name: ([f"{name}_axis{i}" for i in range(np.ndim(values))], values, about) for name, values in arrays.items()
    }
    return data.assign(own).assign_attrs(texts)


def _texts_of(motion: Trajectory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the texts of scenario and shape, or why there is none, and the arrays that they name."""
    known = {key: motion.provenance[key] for key in OF_SCENARIOS if motion.provenance.get(key) is not None}
    shapes: dict[str, Any] = {}
    for body, one in zip(motion.initial.of_bodies, motion.system.of_bodies.values(), strict=True):
        name = named(body, "shape")
        if shape := shape_of(one, name):
            known[name] = shape.text
            shapes |= shape.data
    if "scenario" in known and ("scenario_read" in known or known["scenario_of"] != WITH_FILES):
        return known, {**motion.provenance.get("data", {}), **shapes}
    if not isinstance(motion.system, System):
        return known | {"not_rerunnable": motion.system.not_rerunnable}, shapes
    try:
        text = scenario_of(motion)
    except ValueError as error:
        return known | {"not_rerunnable": str(error)}, shapes
    read = {"scenario_read": text.text} if "scenario" in known else {"scenario": text.text, "scenario_of": SYSTEM}
    return known | read, {**text.data, **shapes}


def _options(motion: Trajectory) -> dict[str, Any]:
    run, known = motion.run, formulations()
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
    options = {"formulation": run.formulation, "tolerance": run.tolerance, "precision": run.precision}
    return options | ({"dense": True} if motion.has_dense_output else {})
