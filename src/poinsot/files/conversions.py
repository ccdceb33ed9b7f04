"""Results to files of attitudes, and back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from poinsot.files.attitudes.aem import read_aem, write_aem
from poinsot.files.attitudes.ck import read_ck, write_ck
from poinsot.files.attitudes.quaternion_csv import read_quaternion_csv, write_quaternion_csv
from poinsot.files.attitudes.stk import read_stk_attitude, write_stk_attitude
from poinsot.files.netcdf import load, save
from poinsot.files.scenarios.scenario import rebuilt_system
from poinsot.files.strangers import read_text
from poinsot.mechanics.calendar import Calendar

__all__ = ["convert"]

ATTITUDES: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    ".aem": (read_aem, write_aem),
    ".bc": (read_ck, write_ck),
    ".a": (read_stk_attitude, write_stk_attitude),
    ".csv": (read_quaternion_csv, write_quaternion_csv),
}
"""What reads and what writes files of attitudes, by the end of their names."""

RESULTS = (".nc", ".zarr")


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
        Results (.nc, .zarr) or attitudes (.aem, .bc, .a, .csv).
    scenario : str or Path, optional
        With the body and the forces of attitudes that become a result.
    zero, frame : str, optional
        The date of t = 0 with its scale, and the name of the space axes, where a result does not say them.
    overwrite : bool

    Raises
    ------
    OSError, TypeError, ValueError, ImportError
        As the readers and the writers.
    """
    source, target = Path(source), Path(target)
    for path in (source, target):
        if path.suffix not in (*RESULTS, *ATTITUDES):
            raise ValueError(f"{path} must end in {', '.join((*RESULTS, *ATTITUDES))}, but it ends in {path.suffix!r}.")
    read = load if source.suffix in RESULTS else ATTITUDES[source.suffix][0]
    what = read(source)
    if target.suffix in RESULTS:
        return save(_motion_of(what, source, scenario), target, overwrite=overwrite)
    said = {"calendar": _calendar(zero), "reference_frame": frame}
    ATTITUDES[target.suffix][1](what, target, **said, overwrite=overwrite)
    return target


def _motion_of(what: Any, source: Path, scenario: str | Path | None) -> Any:
    if source.suffix in RESULTS:
        return what
    if scenario is None:
        raise ValueError(f"{source} must come with a scenario to become a result: it has neither body nor forces.")
    return what.trajectory(rebuilt_system(read_text(scenario), str(scenario), folder=Path(scenario).parent))


def _calendar(zero: str | None) -> Calendar | None:
    if zero is None:
        return None
    date, _, scale = zero.strip().rpartition(" ")
    if not date:
        raise ValueError(
            f"zero must be a date and its scale, such as '2026-11-21T00:00:00 UTC', but {zero[:40]!r} came."
        )
    return Calendar(date, scale)
