"""Conversion between results and files of attitudes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from poinsot.files.attitudes.attitude_format import AttitudeFormat, attitude_formats, format_of
from poinsot.files.attitudes.attitude_table import table_of
from poinsot.files.netcdf import SUFFIXES, load, save
from poinsot.files.untrusted import read_text
from poinsot.printable import quoted, shortened
from poinsot.propagation.trajectory import of_one_body
from poinsot.records.calendar import Calendar
from poinsot.scenarios.builder import Parts
from poinsot.scenarios.folder import Folder

__all__ = ["convert"]


def convert(
    source: str | Path,
    target: str | Path,
    *,
    scenario: str | Path | None = None,
    zero: str | None = None,
    frame: str | None = None,
    member: int | None = None,
    body: str | None = None,
    overwrite: bool = False,
) -> Path:
    """Convert a file to another format, by the endings of both names, and return the path of the new file.

    The options of the command `poinsot convert`, which have the same names, describe the arguments. A ValueError names
    an argument that this conversion does not use; the reader and the writer raise further errors.
    """
    source, target = Path(source), Path(target)
    before, after = _format(source), _format(target)
    from_result, to_result = before is None, after is None
    if scenario is not None and (from_result or not to_result):
        raise ValueError("scenario must go with attitudes that become a result, got other files.")
    if from_result and to_result and (zero, frame) != (None, None):
        raise ValueError(f"{'frame' if zero is None else 'zero'} must go with attitudes, got two results.")
    if member is not None and not from_result:
        raise ValueError(f"member must go with a result, got {source}.")
    calendar = None if zero is None else _calendar(zero)
    what = load(source) if before is None else _read(source, before, calendar, frame, scenario, to_result)
    if body is not None and not (from_result and not to_result):
        raise ValueError("body must go with a result that becomes attitudes, got other files.")
    what = what if member is None else what.member(member)
    if after is not None:
        what = of_one_body(what, body) if from_result else what
        after.write(what, target, calendar=calendar, reference_frame=frame, overwrite=overwrite)
        return target
    return save(what, target, overwrite=overwrite)


def _calendar(zero: str) -> Calendar:
    """Return the calendar that counts from a date with its scale."""
    date, _, scale = zero.strip().rpartition(" ")
    if not date:
        raise ValueError(f"zero must be a date and its scale, such as '2026-11-21T00:00:00 UTC', got {quoted(zero)}.")
    return Calendar(date, scale)


def _format(path: Path) -> AttitudeFormat | None:
    """Return the format of attitudes of a file, None for a result."""
    known = format_of(path)
    if known is None and path.suffix not in SUFFIXES:
        suffixes = (*SUFFIXES, *(suffix for each in attitude_formats()[::-1] for suffix in each.suffixes))
        raise ValueError(f"{shortened(path)} must end in {', '.join(suffixes)}, got {quoted(path.suffix)}.")
    return known


def _read(
    source: Path,
    known: AttitudeFormat,
    calendar: Calendar | None,
    frame: str | None,
    scenario: str | Path | None,
    to_result: bool,
) -> Any:
    """Return attitudes, or their motion of the system in a scenario, counted as its times are."""
    if to_result and scenario is None:
        raise ValueError(f"scenario must be given for {source}, which states neither body nor forces.")
    system = None
    if scenario is not None:
        parts = Parts(read_text(scenario), str(scenario), whole=False, folder=Folder(Path(scenario).parent))
        system, calendar = parts.system(), calendar or parts.calendar
    counted = {} if calendar is None else {"calendar": calendar}
    table = table_of(known.read(source, **counted), reference_frame=frame, dated=False)
    return table if system is None else table.trajectory(system)
