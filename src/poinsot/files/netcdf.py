"""Trajectories as NetCDF-4 files."""

from __future__ import annotations

from pathlib import Path

from poinsot.motion.trajectory import Trajectory

__all__ = ["save"]


def save(motion: Trajectory, path: str | Path) -> Path:
    """Write a trajectory, with units, frames and provenance, as a NetCDF-4 file; return its path.

    An existing file of that name is replaced.

    Raises
    ------
    ValueError
        If the name does not end in `.nc`.
    """
    path = Path(path)
    if path.suffix != ".nc":
        raise ValueError(f"path must end in .nc, but {path.name!r} came.")
    motion.dataset.to_netcdf(path, engine="netcdf4")
    return path
