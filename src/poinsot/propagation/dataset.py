"""A trajectory as a labelled dataset, with units, frames and provenance, and a dataset as a trajectory."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.mechanics.calendar import SCALES, Calendar
from poinsot.mechanics.environment import SPACE_AXES_UNNAMED
from poinsot.mechanics.shared_orbits import orbits_of

if TYPE_CHECKING:
    import xarray

    from poinsot.propagation.trajectory import Trajectory

__all__ = ["calendar_of", "dataset_of", "space_axes_of"]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"


def dataset_of(motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a trajectory, one variable for each quantity, along `time`, members first.

    It has what a trajectory is made of, bit for bit, and nothing of the machine that computed it; of its system no
    more than its `repr`, to which `save` adds what makes it again.
    """
    if motion.system.moving_parts:
        part = type(motion.system.moving_parts[0]).__name__
        raise ValueError(f"a dataset must be of a body without parts, got {part}. Save motion.phase by numpy.")
    import xarray

    return xarray.Dataset(
        {name: (dims, values, attributes) for name, dims, values, attributes in _Variables(motion).all()},
        coords={
            "time": ("time", motion.times, {"units": motion.system.units["time"], **_said_of_time(motion)}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "Rotation of a rigid body",
            "conventions": CONVENTIONS,
            "system": repr(motion.system),
            "initial_state": repr(motion.initial),
            "state_variables": " ".join(motion.phase),
            **{key: value for key, value in motion.summary.items() if key != "wall_time"},
            **({"failures": json.dumps(motion.failures)} if motion.failures else {}),
            **{f"version_{name}": version for name, version in motion.run.versions.items()},
            **{key: motion.provenance[key] for key in ("title", "seed") if motion.provenance.get(key) is not None},
            **({} if space_axes_of(motion) == SPACE_AXES_UNNAMED else {"reference_frame": space_axes_of(motion)}),
            "units_time": motion.system.units["time"],
            "units_inertia": motion.system.units["inertia"],
        },
    )


def calendar_of(motion: Trajectory) -> Calendar | None:
    """Return what the times of a motion mean as dates: by its orbits, or by the scenario that made it."""
    calendar: Calendar | None = motion.system.calendar or motion.provenance.get("calendar")
    return calendar


def space_axes_of(motion: Trajectory) -> str:
    """Return the name of the space axes of a motion, by its orbits or by the file that had it."""
    named = (orbit.reference_frame for orbit in orbits_of(motion.system))
    own = next((frame for frame in named if frame != SPACE_AXES_UNNAMED), None)
    return str(own or motion.provenance.get("reference_frame", SPACE_AXES_UNNAMED))


def _said_of_time(motion: Trajectory) -> dict[str, str]:
    """Return what the times mean as dates; the unit stays alone, because a decoded date has no 64 bits of time."""
    calendar = calendar_of(motion)
    if calendar is None:
        return {"long_name": "time"}
    counted = {"tai": "TAI", "tt": "TT", "tdb": "TDB", "tcb": "TCB", "tcg": "TCG"}[SCALES[calendar.scale]]
    return {
        "long_name": f"time since {calendar.zero} {calendar.scale}, counted in {counted}",
        "epoch": calendar.zero,
        "scale": calendar.scale,
        "counted_in": counted,
    }


class _Variables:
    """The variables of the dataset, each with its dimensions, unit and meaning."""

    def __init__(self, motion: Trajectory) -> None:
        self.motion = motion
        self.units = _Units(motion.system.units["time"], motion.system.units["inertia"])
        self.leading = ("time",) if motion.quaternion.ndim == 2 else ("member", "time")
        self.found: list[tuple[str, tuple[str, ...], Any, dict[str, str]]] = []
        momentum = self.units.momentum
        self._of_states: dict[str, tuple[str, str, str, dict[str, str]]] = {
            "quaternion": ("1", "Euler parameters q, body to space", "parameter", {}),
            "conjugate_momenta": (momentum, "momenta Q conjugate to q", "parameter", {}),
            "angular_momentum_body": (momentum, "angular momentum", "axis", {"frame": "body"}),
        }

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
        for name, (unit, meaning, axis, said) in self._of_states.items():
            put(name, getattr(motion, name), unit, meaning, axis, **said)
        momentum = motion.angular_momentum_space
        put("angular_momentum_space", momentum, units.momentum, "angular momentum", "axis", frame="space")
        for frame in ("body", "space"):
            omega = getattr(motion, f"omega_{frame}")
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
        for name, values in state.phase.items():
            unit, meaning, axis, said = self._of_states[name]
            self._fixed(f"initial_{name}", values, unit, f"{meaning}, at the start", axis, **said)
        self._fixed("initial_time", state.time, units.time, "time of the start")
        self._fixed("moments", body.moments, units.inertia, "principal moments of inertia", "axis")
        matrix = body.principal_matrix
        meaning = "principal axes along the body axes, in columns"
        self._fixed("principal_axes", matrix, "1", meaning, "axis", "principal_axis", frame="body")
        comoving = getattr(motion.environment, "comoving", None)
        if comoving is not None:
            self._put("carried", comoving, "1", "variables of the orbits that were integrated along", "variable")

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
