"""A trajectory as a labelled dataset, with units, frames and provenance, and a dataset as a trajectory."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.motion.scenario_text import text_of

if TYPE_CHECKING:
    import xarray

    from poinsot.motion.trajectory import Trajectory

__all__ = ["PROVENANCE", "SYSTEM", "WHOLE", "dataset_of"]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"

PROVENANCE = ("title", "seed", "scenario", "scenario_of")
"""What a trajectory knows of the scenario that made it, and a dataset too."""

SYSTEM, WHOLE = "system", "state, times and system"
"""What the text of a scenario in a file is of: the rest is in the variables."""


def dataset_of(motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a trajectory, one variable for each quantity, along `time`, members first.

    It has what a trajectory is made of, to the bit, and nothing of the machine that computed it. The attribute
    `scenario` has the text that makes the system again; where there can be none, `not_rerunnable` says why.
    """
    import xarray

    return xarray.Dataset(
        {name: (dims, values, attributes) for name, dims, values, attributes in _Variables(motion).all()},
        coords={
            "time": ("time", motion.times, {"units": motion.system.units["time"], "long_name": "time"}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "Rotation of a rigid body",
            "conventions": CONVENTIONS,
            "system": repr(motion.system),
            "initial_state": repr(motion.initial),
            **{key: value for key, value in motion.summary.items() if key != "wall_time"},
            **({"failures": json.dumps(motion.failures)} if motion.failures else {}),
            **{f"version_{name}": version for name, version in motion.run.versions.items()},
            **_scenario_of(motion),
            "units_time": motion.system.units["time"],
            "units_inertia": motion.system.units["inertia"],
        },
    )


def _scenario_of(motion: Trajectory) -> dict[str, Any]:
    """Return the text of the scenario, or why there is none, and what else is known of it."""
    known = {key: value for key, value in motion.provenance.items() if value is not None}
    if "scenario" in known:
        return known
    if hasattr(motion.system, "not_rerunnable"):
        return {**known, "not_rerunnable": motion.system.not_rerunnable}
    try:
        return {**known, "scenario": text_of(motion), "scenario_of": SYSTEM}
    except ValueError as error:
        return {**known, "not_rerunnable": str(error)}


class _Variables:
    """The variables of the dataset, each with its dimensions, unit and meaning."""

    def __init__(self, motion: Trajectory) -> None:
        self.motion = motion
        self.units = _Units(motion.system.units["time"], motion.system.units["inertia"])
        self.leading = ("time",) if motion.quaternion.ndim == 2 else ("member", "time")
        self.found: list[tuple[str, tuple[str, ...], Any, dict[str, str]]] = []

    def all(self) -> list[tuple[str, tuple[str, ...], Any, dict[str, str]]]:
        self._motion()
        self._proof()
        self._origin()
        return self.found

    def _put(self, name: str, values: Any, unit: str, meaning: str, axis: str | None = None, **attributes: str) -> None:
        dims = self.leading if axis is None else (*self.leading, axis)
        self.found.append((name, dims, values, {"units": unit, "long_name": meaning, **attributes}))

    def _motion(self) -> None:
        motion, units, put = self.motion, self.units, self._put
        put("quaternion", motion.quaternion, "1", "Euler parameters q, body to space", "parameter")
        put("conjugate_momenta", motion.conjugate_momenta, units.momentum, "momenta Q conjugate to q", "parameter")
        for frame in ("body", "space"):
            momentum, omega = getattr(motion, f"angular_momentum_{frame}"), getattr(motion, f"omega_{frame}")
            put(f"angular_momentum_{frame}", momentum, units.momentum, "angular momentum", "axis", frame=frame)
            put(f"omega_{frame}", omega, units.rate, "inertial angular velocity", "axis", frame=frame)
        put("kinetic_energy", motion.kinetic_energy, units.energy, "rotational kinetic energy T")
        put("potential_energy", motion.potential_energy, units.energy, "potential energy U")

    def _proof(self) -> None:
        motion, units, put = self.motion, self.units, self._put
        put("norm_error", motion.norm_error, "1", "|q| - 1")
        put("tangency_error", motion.tangency_error, units.momentum, "q . Q")
        values, drift = motion.integrals, motion.drift
        for integral in motion.system.integrals:
            name, kind = integral.name, "energy" if integral.is_energy else "momentum"
            unit = units.energy if integral.is_energy else units.momentum
            put(f"integral_{name}", values[name], unit, integral.meaning, symbol=integral.symbol, kind=kind)
            put(f"drift_{name}", drift[name], "1", f"relative drift of {integral.meaning}")

    def _origin(self) -> None:
        """Add what the motion started from, and what was integrated along with it."""
        motion, units = self.motion, self.units
        state, body = motion.initial, motion.system.body
        self._fixed("initial_quaternion", state.quaternion, "1", "q at the start", "parameter")
        self._fixed("initial_conjugate_momenta", state.conjugate_momenta, units.momentum, "Q at the start", "parameter")
        self._fixed("initial_time", state.time, units.time, "time of the start")
        self._fixed("moments", body.moments, units.inertia, "principal moments of inertia", "axis")
        matrix = body.principal_matrix
        meaning = "principal axes along the body axes, in columns"
        self._fixed("principal_axes", matrix, "1", meaning, "axis", "principal_axis", frame="body")
        carried = getattr(motion.sky, "carried", None)
        if carried is not None:
            self._put("carried", carried, "1", "variables of the orbits that were integrated along", "variable")

    def _fixed(self, name: str, values: Any, unit: str, meaning: str, *axes: str, **attributes: str) -> None:
        values = np.asarray(values)
        dims = axes if values.ndim == len(axes) else ("member", *axes)
        self.found.append((name, dims, values, {"units": unit, "long_name": meaning, **attributes}))


class _Units:
    """Units of the derived quantities, in CF notation, from those of time and inertia."""

    def __init__(self, time: str, inertia: str) -> None:
        self.time, self.inertia = time, inertia
        self.rate = "rad" if time == "1" else f"rad {time}-1"
        self.momentum = _product(inertia, _power(time, -1))
        self.energy = _product(inertia, _power(time, -2))


def _power(unit: str, exponent: int) -> str:
    return "1" if unit == "1" else f"{unit}{exponent}"


def _product(*units: str) -> str:
    return " ".join(unit for unit in units if unit != "1") or "1"
