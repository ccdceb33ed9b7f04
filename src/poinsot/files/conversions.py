"""Results to files of attitudes, and back."""

from __future__ import annotations

from pathlib import Path

from poinsot.files.attitudes.attitude_format import AttitudeFormat, attitude_formats, format_of
from poinsot.files.attitudes.attitude_table import AttitudeTable, table_of
from poinsot.files.netcdf import SUFFIXES, load, save
from poinsot.files.scenarios.builder import Parts
from poinsot.files.scenarios.folder import Folder
from poinsot.files.untrusted import read_text
from poinsot.mechanics.calendar import Calendar
from poinsot.propagation.trajectory import Trajectory

__all__ = ["convert"]


def convert(
    source: str | Path,
    target: str | Path,
    *,
    scenario: str | Path | None = None,
    zero: str | None = None,
    frame: str | None = None,
    overwrite: bool = False,
) -> Path:
    """Write what is in one file as another, by the ends of their names, and return its path.

    Parameters
    ----------
    source, target : str or Path
        Results (.nc, .zarr), or attitudes in one of the `attitude_formats`.
    scenario : str or Path, optional
        With the body and the forces of attitudes that become a result, and its calendar.
    zero : str, optional
        The date of t = 0 with its scale, where neither a result nor the scenario says it; files of attitudes are
        counted from their first row without it.
    frame : str, optional
        The name of the space axes, where a file does not say it.
    overwrite : bool

    Raises
    ------
    OSError, TypeError, ValueError, ImportError
        As the readers and the writers; or if an argument is given that this conversion has no use for.
    """
    source, target = Path(source), Path(target)
    before, after = _format(source), _format(target)
    from_result, to_result = before is None, after is None
    if scenario is not None and (from_result or not to_result):
        raise ValueError("scenario must go with attitudes that become a result, got other files.")
    if from_result and to_result and (zero, frame) != (None, None):
        raise ValueError(f"{'frame' if zero is None else 'zero'} must go with attitudes, got two results.")
    calendar = _calendar(zero)
    if after is None:
        motion = load(source) if before is None else _motion(source, before, scenario, calendar, frame)
        return save(motion, target, overwrite=overwrite)
    what = load(source) if before is None else _table(source, before, calendar, frame)
    after.write(what, target, calendar=calendar, reference_frame=frame, overwrite=overwrite)
    return target


def _format(path: Path) -> AttitudeFormat | None:
    """Return the format of attitudes of a file, None for a result."""
    known = format_of(path)
    if known is None and path.suffix not in SUFFIXES:
        suffixes = (*SUFFIXES, *(suffix for each in attitude_formats()[::-1] for suffix in each.suffixes))
        raise ValueError(f"{path} must end in {', '.join(suffixes)}, got {path.suffix!r}.")
    return known


def _motion(
    source: Path, known: AttitudeFormat, scenario: str | Path | None, calendar: Calendar | None, frame: str | None
) -> Trajectory:
    """Return attitudes as a motion of the system in a scenario, counted as its times are."""
    if scenario is None:
        raise ValueError(f"scenario must be given to make a result of {source}, which has neither body nor forces.")
    parts = Parts(read_text(scenario), str(scenario), whole=False, folder=Folder(Path(scenario).parent))
    system = parts.system()
    return _table(source, known, calendar or parts.calendar, frame).trajectory(system)


def _table(source: Path, known: AttitudeFormat, calendar: Calendar | None, frame: str | None) -> AttitudeTable:
    counted = {} if calendar is None else {"calendar": calendar}
    return table_of(known.read(source, **counted), reference_frame=frame, dated=False)


def _calendar(zero: str | None) -> Calendar | None:
    if zero is None:
        return None
    date, _, scale = zero.strip().rpartition(" ")
    if not date:
        raise ValueError(f"zero must be a date and its scale, such as '2026-11-21T00:00:00 UTC', got {zero[:40]!r}.")
    return Calendar(date, scale)
