"""Trajectories as NetCDF-4 files."""

from __future__ import annotations

from pathlib import Path

from poinsot.mechanics.parameters import came
from poinsot.motion.trajectory import Trajectory

__all__ = ["save"]


def save(motion: Trajectory, path: str | Path) -> Path:
    """Write a trajectory, with units, frames and provenance, as a NetCDF-4 file; return its path.

    An existing file of that name is replaced.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If the first argument is no trajectory, the name does not end in `.nc`, or its folder does not exist.
    """
    if not isinstance(motion, Trajectory):
        raise TypeError(f"motion must be a Trajectory, but {came(motion)} came. The order is save(motion, path).")
    path = Path(path)
    if path.suffix != ".nc":
        raise ValueError(f"path must end in .nc, but {path.name!r} came.")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"path must be in a folder that exists, but there is no {path.parent}.")
    motion.dataset.to_netcdf(path, engine="netcdf4")
    return path
