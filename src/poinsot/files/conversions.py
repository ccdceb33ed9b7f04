"""Results to files of attitudes, and back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from poinsot.files.attitudes.aem import read_aem, write_aem
from poinsot.files.attitudes.attitude_table import AttitudeTable, table_of
from poinsot.files.attitudes.ck import read_ck, write_ck
from poinsot.files.attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from poinsot.files.attitudes.stk import read_stk_attitude, write_stk_attitude
from poinsot.files.netcdf import SUFFIXES, load, save
from poinsot.files.scenarios.builder import Parts
from poinsot.files.scenarios.folder import Folder
from poinsot.files.untrusted import read_text
from poinsot.mechanics.calendar import Calendar
from poinsot.propagation.trajectory import Trajectory

__all__ = ["convert"]

ATTITUDES: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    ".aem": (read_aem, write_aem),
    ".xml": (read_aem, write_aem),
    ".bc": (read_ck, write_ck),
    ".a": (read_stk_attitude, write_stk_attitude),
    ".csv": (read_quaternion_csv, write_quaternion_csv),
}
"""What reads and what writes files of attitudes, by the end of their names."""


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
        Results (.nc, .zarr) or attitudes (.aem, .xml, .bc, .a, .csv).
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
    for path in (source, target):
        if path.suffix not in (*SUFFIXES, *ATTITUDES):
            known = ", ".join((*SUFFIXES, *ATTITUDES))
            raise ValueError(f"{path} must end in {known}, but it ends in {path.suffix!r}.")
    from_result, to_result = source.suffix in SUFFIXES, target.suffix in SUFFIXES
    if scenario is not None and (from_result or not to_result):
        raise ValueError("scenario must go with attitudes that become a result, got other files.")
    if from_result and to_result and (zero, frame) != (None, None):
        raise ValueError(f"{'frame' if zero is None else 'zero'} must go with attitudes, got two results.")
    calendar = _calendar(zero)
    if to_result:
        motion = load(source) if from_result else _motion(source, scenario, calendar, frame)
        return save(motion, target, overwrite=overwrite)
    what = load(source) if from_result else _table(source, calendar, frame)
    ATTITUDES[target.suffix][1](what, target, calendar=calendar, reference_frame=frame, overwrite=overwrite)
    return target


def _motion(source: Path, scenario: str | Path | None, calendar: Calendar | None, frame: str | None) -> Trajectory:
    """Return attitudes as a motion of the system in a scenario, counted as its times are."""
    if scenario is None:
        raise ValueError(f"{source} must come with a scenario to become a result: it has neither body nor forces.")
    parts = Parts(read_text(scenario), str(scenario), whole=False, folder=Folder(Path(scenario).parent))
    system = parts.system()
    return _table(source, calendar or parts.calendar, frame).trajectory(system)


def _table(source: Path, calendar: Calendar | None, frame: str | None) -> AttitudeTable:
    counted = {} if calendar is None else {"calendar": calendar}
    return table_of(ATTITUDES[source.suffix][0](source, **counted), reference_frame=frame, dated=False)


def _calendar(zero: str | None) -> Calendar | None:
    if zero is None:
        return None
    date, _, scale = zero.strip().rpartition(" ")
    if not date:
        raise ValueError(f"zero must be a date and its scale, such as '2026-11-21T00:00:00 UTC', got {zero[:40]!r}.")
    return Calendar(date, scale)
