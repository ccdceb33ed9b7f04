"""A trajectory as a labelled dataset: units, frames, provenance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

    from poinsot.motion.trajectory import Trajectory

__all__ = ["dataset_of"]

CONVENTIONS = "Hamilton product, scalar first; x_space = q x_body q~; rates are inertial"


def dataset_of(motion: Trajectory) -> xarray.Dataset:
    """Return the dataset of a trajectory, one variable for each quantity, along `time`, members first."""
    import xarray

    units = _Units(motion.system.units["time"], motion.system.units["inertia"])
    data: dict[str, Any] = {}

    leading = ("time",) if motion.quaternion.ndim == 2 else ("member", "time")

    def put(name: str, values: Any, unit: str, meaning: str, axis: str | None = None, **attributes: str) -> None:
        dims = leading if axis is None else (*leading, axis)
        data[name] = (dims, values, {"units": unit, "long_name": meaning, **attributes})

    put("quaternion", motion.quaternion, "1", "Euler parameters q, body to space", "parameter")
    put("conjugate_momenta", motion.conjugate_momenta, units.momentum, "momenta Q conjugate to q", "parameter")
    for frame in ("body", "space"):
        momentum, omega = getattr(motion, f"angular_momentum_{frame}"), getattr(motion, f"omega_{frame}")
        put(f"angular_momentum_{frame}", momentum, units.momentum, "angular momentum", "axis", frame=frame)
        put(f"omega_{frame}", omega, units.rate, "inertial angular velocity", "axis", frame=frame)
    put("kinetic_energy", motion.kinetic_energy, units.energy, "rotational kinetic energy T")
    put("potential_energy", motion.potential_energy, units.energy, "potential energy U")
    put("norm_error", motion.norm_error, "1", "|q| - 1")
    put("tangency_error", motion.tangency_error, units.momentum, "q . Q")
    drift = motion.drift
    for integral in motion.system.integrals:
        unit = units.energy if integral.is_energy else units.momentum
        put(f"integral_{integral.name}", motion.integrals[integral.name], unit, integral.meaning)
        put(f"drift_{integral.name}", drift[integral.name], "1", f"relative drift of {integral.meaning}")
    return xarray.Dataset(
        data,
        coords={
            "time": ("time", motion.times, {"units": units.time, "long_name": "time"}),
            "parameter": ["0", "1", "2", "3"],
            "axis": ["1", "2", "3"],
        },
        attrs={
            "title": "Rotation of a rigid body",
            "conventions": CONVENTIONS,
            "system": repr(motion.system),
            "initial_state": repr(motion.initial),
            **motion.summary,
            **({"failures": "; ".join(f"{k}: {why}" for k, why in motion.failures.items())} if motion.failures else {}),
            **{f"version_{name}": version for name, version in motion.run.versions.items()},
        },
    )


class _Units:
    """Units of the derived quantities, in CF notation, from those of time and inertia."""

    def __init__(self, time: str, inertia: str) -> None:
        self.time = time
        self.rate = "rad" if time == "1" else f"rad {time}-1"
        self.momentum = _product(inertia, _power(time, -1))
        self.energy = _product(inertia, _power(time, -2))


def _power(unit: str, exponent: int) -> str:
    return "1" if unit == "1" else f"{unit}{exponent}"


def _product(*units: str) -> str:
    return " ".join(unit for unit in units if unit != "1") or "1"
