"""Contents and conversion of files: `poinsot info`, `poinsot convert`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from poinsot import files
from poinsot.cli.terminal import (
    RESULTS,
    Json,
    Member,
    OfTwo,
    Overwrite,
    advise,
    answer,
    busy,
    check_new,
    check_there,
    hand_over,
    hand_over_json,
    listed_formats,
    opened,
    report_path,
)

if TYPE_CHECKING:
    import numpy as np
    import xarray
    from numpy.typing import NDArray

    from poinsot.files.attitudes.attitude_table import AttitudeTable
    from poinsot.files.scenario import Scenario
    from poinsot.kinematics.state import AnyState
    from poinsot.observables.readings import Readings
    from poinsot.propagation.recorded import RecordedSystem
    from poinsot.propagation.trajectory import Trajectory
    from poinsot.systems.system import System

__all__ = ["convert", "facts_of_readings", "info"]

Lines = list[str]


@dataclass(frozen=True)
class Contents:
    """Contents of a file.

    Attributes
    ----------
    kind : str
        "result", "ensemble", "store" (of an ensemble, not whole), "dataset", "readings", "scenario", "attitudes" or
        "other".
    lines : list of str
        A title, and "  name: text" for each fact.
    scenario : str, optional
        The text of the scenario in it.
    data : mapping
        Facts for programs.
    """

    kind: str
    lines: Lines
    scenario: str | None = None
    data: Mapping[str, Any] = field(default_factory=dict)

    @property
    def facts(self) -> dict[str, Any]:
        """Texts of the lines by name, in lists, and the facts for programs."""
        title, *lines = self.lines
        texts: dict[str, Any] = {}
        for name, _, text in (line.strip().partition(": ") for line in lines):
            texts.setdefault(name, []).append(text)
        return {"kind": self.kind, "title": title, "lines": texts, **self.data}


def info(
    file: Annotated[Path, typer.Argument(help="Result, scenario, or file in another format that poinsot reads.")],
    scenario: Annotated[
        bool, typer.Option("--scenario", help="Print only the scenario that the result contains.")
    ] = False,
    member: Member = None,
    time: Annotated[
        float | None, typer.Option(help="Also print the state at the stored time nearest to this time.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Summarise a file.

    For a result the summary lists body, forces, output times, integration method, versions, the drift of the conserved
    quantities, and whether the run can be repeated. For a scenario it lists body, forces, initial state, output times
    and output files.

    For readings it lists the observables and their values. For attitude files ({attitudes}, CCSDS APM), orbits (OEM),
    light curves (DAMIT, ALCDEF), shapes (OBJ, PLY, STL, plate tables, DAMIT) and gravity fields (ICGEM, SHADR) it
    describes the contents and names the Python function that reads the file.

    For example:

    - `poinsot info top.nc`
    - `poinsot info top.nc --scenario > again.toml` extracts the scenario
    - `poinsot info tops.nc --member 7 --time 12.5` prints the state of one ensemble member at one time
    - `poinsot info top.nc --json`
    - `poinsot info attitude.aem`
    """
    with busy(f"Reading {file}"):
        found = _in_file(file, member, time)
    if scenario and found.scenario is None:
        raise ValueError(f"{file} must contain a scenario, got none.")
    if scenario:
        hand_over(str(found.scenario))
    elif as_json:
        hand_over_json({"file": str(file), **found.facts})
    else:
        answer(*found.lines)
    advise(*_next_steps(found.kind, file))


def _next_steps(kind: str, file: Path) -> tuple[tuple[str, str], ...]:
    """Return the commands that apply to a file."""
    if kind == "scenario":
        return ((opened("run", file), "propagates the scenario"),)
    if kind == "store":
        return ((f"{opened('run', file)} --resume", "continues the run"),)
    if kind == "ensemble":
        return (
            (f"{opened('info', file)} --member 0", "summarises one member"),
            (f"{opened('view', file)} --member 0", "writes a 3D view of one member"),
            (opened("plot", file), "plots the result"),
        )
    if kind == "readings":
        return ((opened("plot", file), "plots the readings"),)
    if kind == "result":
        return tuple((opened(name, file), what) for name, what in OF_RESULTS.items())
    if kind == "attitudes":
        made = opened("convert", file, file.with_suffix(".nc"))
        return ((f"{made} --scenario NAME.toml", "converts the attitudes to a result"),)
    return (("poinsot new", "writes an example scenario; its comments show how to use such a file"),)


OF_RESULTS = {"plot": "plots the result", "view": "writes a 3D view", "run": "repeats the run and compares"}


def convert(
    source: Annotated[Path, typer.Argument(help="Result (.nc, .zarr) or attitude file to convert.")],
    target: Annotated[Path, typer.Argument(help="File to write; its suffix selects the format.")],
    scenario: Annotated[
        Path | None,
        typer.Option(help="Scenario with body and forces, required to convert an attitude file to a result."),
    ] = None,
    zero: Annotated[
        str | None, typer.Option(help="Date of t = 0 with its time scale, such as '2026-11-21T00:00:00 UTC'.")
    ] = None,
    frame: Annotated[str | None, typer.Option(help="Name of the space axes, such as ICRF.")] = None,
    member: Member = None,
    body: OfTwo = None,
    overwrite: Overwrite = False,
) -> None:
    """Convert between results and attitude files.

    The formats of attitude files are {attitudes}. An attitude file contains dates and the name of the space axes; pass
    --zero and --frame if the result does not contain them. The times of a result that is made from an attitude file
    count from the calendar of the scenario, without a calendar from --zero, and without both from the first row.

    For example:

    - `poinsot convert top.nc top.zarr`
    - `poinsot convert sat.nc sat.aem --zero "2026-11-21T00:00:00 UTC" --frame ICRF`
    - `poinsot convert sat.aem sat.nc --scenario sat.toml`
    """
    from poinsot.files.conversions import convert as write

    if source.resolve() == target.resolve():
        raise ValueError(f"{target} must be another file than the one to convert, but it is the same.")
    for file in (source, scenario or source):
        check_there(file)
    check_new(target, overwrite)
    with busy(f"Writing {target}"):
        write(source, target, scenario=scenario, zero=zero, frame=frame, member=member, body=body, overwrite=overwrite)
    report_path(target)
    advise((opened("info", target), "summarises the file"))


# ------------------------------------------------------------------ what a file has


def _in_file(file: Path, member: int | None, time: float | None) -> Contents:
    """Return the contents of a file."""
    check_there(file)
    if file.suffix in RESULTS:
        return _of_result(file, member, time)
    for option, value in (("--member", member), ("--time", time)):
        if value is not None:
            raise ValueError(f"{option} must go with a result, .nc or .zarr, got {file}.")
    return _of_scenario(file) if file.suffix == ".toml" else _of_other(file)


def _of_other(file: Path) -> Contents:
    if not file.is_file():
        raise IsADirectoryError(f"{file} must be a file, got a folder.")
    with file.open("rb") as stream:
        head = stream.read(4096)
    kind = _kind_of(file, head)
    if kind in OF_OTHERS:
        return Contents("other", OF_OTHERS[kind](file))
    from poinsot.files.attitudes.attitude_format import attitude_formats, format_of

    known = next((each for each in attitude_formats() if each.sniff(head)), format_of(file))
    if known is None:
        raise ValueError(
            f"{file} must be a result (.nc, .zarr), a scenario (.toml), attitudes ({listed_formats()}, CCSDS APM), an "
            "orbit (OEM), light curves (DAMIT, ALCDEF), a shape (.obj, .ply, .stl, .tab, .txt) or a gravity field "
            "(.gfc, .tab), but it is none of them."
        )
    lines = _attitudes(f"Attitudes, {known.title}", known.read(file))
    return Contents("attitudes", [*lines, f"  in Python: {known.in_python.format(path=str(file))}"])


def _kind_of(file: Path, head: bytes) -> str:
    """Return the kind of a file from its first lines, or else from its extension."""
    if message := re.search(rb"CCSDS_(APM|OEM|OMM)_VERS|<(apm|oem|omm)[\s>]", head):
        return f".{(message[1] or message[2]).decode().lower()}"
    if file.suffix.lower() == ".tab":
        return ".gfc" if b"," in head.partition(b"\n")[0] else ".obj"
    return next((kind for kind, mark in TEXTS.items() if mark.match(head)), file.suffix.lower())


TEXTS = {
    "alcdef": re.compile(rb"(#[^\n]*\n|\s)*STARTMETADATA"),
    "damit curves": re.compile(rb"\s*\d+[ \t\r]*\n\s*\d+[ \t]+[01][ \t\r]*\n"),
    "damit shape": re.compile(rb"\s*\d+[ \t]+\d+[ \t\r]*\n\s*(?:[-+.\deE]+[ \t]+){2}[-+.\deE]+[ \t\r]*\n"),
    "damit spin": re.compile(rb"\s*(?:[-+.\d]+[ \t]+){2}[-+.\d]+[ \t\r]*\n[ \t]*\d{7}[.\d]*[ \t]+[-+.\d]+\s"),
    "readings": re.compile(rb"# (readings|observable): "),
}
"""Marks of observations by their kind: files of text whose names end as the names of other files do."""


def _of_scenario(file: Path) -> Contents:
    from poinsot.files.scenario import read_scenario

    job = read_scenario(file)
    lines = [
        job.provenance.get("title") or f"Scenario {file.name}",
        *_system(job.system),
        *_start("start", job.state, job.system.units),
        _span(job.times, job.system.units["time"]),
        *_seed(job),
        *(f"  writes: {name}" for name in job.outputs.values()),
    ]
    data = {"times": _ends(job.times), "units": job.system.units, "outputs": job.outputs}
    return Contents("scenario", lines, job.provenance["scenario"], data)


def _of_result(file: Path, member: int | None, time: float | None) -> Contents:
    import xarray

    from poinsot.files.netcdf import ReadingsFoundError, load

    try:
        found: Trajectory | xarray.Dataset = load(file)
    except ReadingsFoundError:
        return _of_readings(file)
    if isinstance(found, xarray.Dataset):
        return _of_dataset(file, found)
    motion = found if member is None else found.member(member)
    reason = getattr(motion.system, "not_rerunnable", None)
    lines = [
        motion.provenance.get("title") or f"Result {file.name}",
        *_system(motion.system),
        *repr(motion).splitlines()[1:],
        *_members(motion),
        *_seed(motion),
        f"  versions: {', '.join(f'{name} {version}' for name, version in motion.run.versions.items())}",
        "  can be run again: yes" if reason is None else f"  can be run again: no. {reason}",
        *_state_near(motion, time),
    ]
    data = {
        "times": _ends(motion.times),
        "units": motion.system.units,
        "members": len(motion) if motion.is_ensemble else None,
        "finished": None if motion.store is None else motion.store.finished,
        "summary": motion.summary,
        "versions": motion.run.versions,
        "rerunnable": reason is None,
    }
    partial = motion.store is not None and not motion.store.whole.all()
    kind = "store" if partial else "ensemble" if motion.is_ensemble else "result"
    return Contents(kind, lines, motion.provenance.get("scenario"), data)


def _of_readings(file: Path) -> Contents:
    """Return the contents of a file of readings."""
    found = files.read_readings(file)
    lines = [f"Readings {file.name}"]
    for each in found:
        title, *facts = repr(each).splitlines()
        lines += [f"  {title}", *(f"  {fact}" for fact in facts)]
    return Contents("readings", lines, data={"readings": [facts_of_readings(each) for each in found]})


def facts_of_readings(readings: Readings) -> dict[str, Any]:
    """Return facts about readings for programs."""
    import numpy as np

    values = readings.values
    return {
        "name": readings.name,
        "observable": repr(readings.observable),
        "components": list(readings.observable.components),
        "times": _ends(readings.times),
        "units": readings.attributes.get("units"),
        "members": len(values) if readings.is_ensemble and values is not None else None,
        "absent": None if values is None else int(np.isnan(values).sum()),
    }


def _of_dataset(file: Path, found: xarray.Dataset) -> Contents:
    """Return the contents of a store without whole states: selected variables, or the results of a reduction."""
    from poinsot.storage.ensemble_store import EnsembleStore

    store = EnsembleStore(file)
    sizes = ", ".join(f"{size} along {name}" for name, size in found.sizes.items())
    variables = [
        f"  variable: {name}, {each.dtype}, along {', '.join(map(str, each.dims))}" for name, each in found.items()
    ]
    done = f"  members: {store.finished} of {store.members} are done"
    lines = [f"Dataset {file.name}", f"  store: {store}", done, f"  sizes: {sizes}", *variables]
    data = {"sizes": found.sizes, "members": store.members, "finished": store.finished}
    return Contents("dataset", lines, data=data)


def _ends(times: NDArray[np.float64]) -> dict[str, Any]:
    return {"count": times.size, "first": times[0], "last": times[-1]} if times.size else {"count": 0}


def _state_near(motion: Trajectory, time: float | None) -> Lines:
    """Return the state at the time that is nearest to one."""
    if time is None:
        return []
    if motion.is_ensemble:
        raise ValueError(f"--time must go with --member for an ensemble, got none of {len(motion)} members.")
    import numpy as np

    units, (first, last) = motion.system.units, (float(np.min(motion.times)), float(np.max(motion.times)))
    if not first <= time <= last:
        raise ValueError(
            f"--time must lie within the times of the result, {first:.10g} ... {last:.10g}, got {time:.10g}."
        )
    place = int(np.argmin(np.abs(motion.times - time)))
    at = f"at t = {motion.times[place]:.10g}" + ("" if units["time"] == "1" else f" {units['time']}")
    from poinsot.plot.labels import rate_unit_of

    rates = [
        f"  {at}: angular velocity{f' of the {name}' if name else ''} {_written(one.omega_body[place])}"
        f"{rate_unit_of(units, None).label}, body axes"
        for name, one in motion.of_bodies.items()
    ]
    return [*_start(at, motion.isel(time=place), units), *rates]


def _members(motion: Trajectory) -> Lines:
    """Return the line about an ensemble of which not all members are there to the end."""
    if not motion.is_ensemble:
        return []
    if motion.store is not None:
        done = motion.store.finished - len(motion.failures)
    else:
        done = int(motion.reached[:, -1].sum())
    return [] if done == len(motion) else [f"  at the last time: {done} of {len(motion)} members"]


def _seed(job: Scenario | Trajectory) -> Lines:
    seed = job.provenance.get("seed")
    return [] if seed is None else [f"  seed: {seed}"]


def _system(system: System | RecordedSystem) -> Lines:
    """Return the lines about body and forces; if the forces cannot be constructed, the lines of the file."""
    if hasattr(system, "not_rerunnable"):
        return [f"  system: {system!r}"]
    from poinsot.records.units import DerivedUnits, in_units

    known = DerivedUnits(system.units)
    forces = [f"  force: {in_units(force, known)}" for force in system.forces]
    return [f"  body: {in_units(system.body, known)}", *(forces or ["  forces: none"])]


def _start(when: str, state: AnyState, units: Mapping[str, str]) -> Lines:
    if state.shape:
        return [f"  members: {len(next(iter(state.phase.values())))}"]
    from poinsot.kinematics.state import PairState
    from poinsot.plot.labels import bracketed, momentum_label
    from poinsot.records.units import DerivedUnits

    known, lines = DerivedUnits(units), Lines()
    for name, one in state.of_bodies.items():
        momentum, of = (
            f"{_written(one.angular_momentum_body)}{momentum_label(units)}",
            f" of the {name}" if name else "",
        )
        lines += [
            f"  {when}: quaternion{of} {_written(one.quaternion)}, scalar first, body to space",
            f"  {when}: angular momentum{of} {momentum}, body axes",
        ]
    if isinstance(state, PairState):
        lines += [
            f"  {when}: position of the secondary {_written(state.position)}{bracketed(known.length)}",
            f"  {when}: momentum of the orbit {_written(state.momentum)}{bracketed(known.linear_momentum)}",
        ]
        return lines
    return [*lines, *(f"  {when}: {name} {_written(values)}" for name, values in state.own.items())]


def _written(values: NDArray[np.float64]) -> str:
    return f"({', '.join(f'{value:.9g}' for value in values)})"


def _span(times: NDArray[np.float64], unit: str) -> str:
    return f"  times: {times.size}, {times[0]:.10g} ... {times[-1]:.10g}" + ("" if unit == "1" else f" {unit}")


# ------------------------------------------------------------------ other files


def _attitudes(title: str, table: AttitudeTable) -> Lines:
    small = table.norm_error < 1e-15
    return [
        f"{title}: {table.body_frame} in {table.reference_frame}",
        _span(table.times, "1" if table.calendar is None else table.calendar.unit),
        f"  dates: {table.calendar or 'none'}",
        f"  rates: {'in the file' if table.omega_body is not None else 'none, differentiated where needed'}",
        f"  norm: {'unit quaternions' if small else f'largest | |q| - 1 |: {table.norm_error:.2g}'}",
    ]


def _of_apm(file: Path) -> Lines:
    table, body = files.read_apm(file)
    return [
        *_attitudes("One attitude, CCSDS APM", table),
        f"  body: {'none that can be used' if body is None else repr(body)}",
        f"  in Python: pt.files.read_apm({str(file)!r})",
    ]


def _of_oem(file: Path) -> Lines:
    return [f"Orbit, CCSDS OEM: {files.read_oem(file)!r}", f"  in Python: pt.files.read_oem({str(file)!r})"]


def _of_omm(file: Path) -> Lines:
    return [f"Mean elements of an orbit, for SGP4: {file.name}", "  in Python: pt.files.omm_orbit, pt.files.tle_orbit"]


def _of_alcdef(file: Path) -> Lines:
    from poinsot.files.observations import alcdef

    blocks = alcdef.blocks_in(file)
    objects = dict.fromkeys(block.rows.metadata.get("OBJECTNAME", "unknown") for block in blocks)
    return [
        f"Light curves, ALCDEF: {len(blocks)}",
        f"  objects: {', '.join(objects)}",
        f"  data: {sum(len(block.rows.dates) for block in blocks)}",
        f"  in Python: pt.files.read_alcdef({str(file)!r}, light_curve)",
    ]


def _of_damit_curves(file: Path) -> Lines:
    from poinsot.files.observations import damit_curves

    curves = damit_curves.curves_in(file)
    calibrated = sum(calibrated for _, calibrated in curves)
    dates = [date for rows, _ in curves for date in (rows.dates[0], rows.dates[-1])]
    return [
        f"Light curves, DAMIT: {len(curves)}, {calibrated} of which are calibrated",
        f"  data: {sum(len(rows.dates) for rows, _ in curves)}",
        f"  Julian dates: {min(dates)} ... {max(dates)}",
        f"  in Python: pt.files.read_damit({str(file)!r}, shape, law)",
    ]


def _of_damit_spin(file: Path) -> Lines:
    return [*repr(files.read_damit_spin(file)).splitlines(), f"  in Python: pt.files.read_damit_spin({str(file)!r})"]


def _of_csv(file: Path) -> Lines:
    return [f"Readings: {file.name}", f"  in Python: pt.files.read_readings_csv({str(file)!r}, observable)"]


def _of_mesh(file: Path) -> Lines:
    mesh = files.read_mesh(file, density=1.0)
    return [
        f"Shape: {len(mesh.vertices)} vertices, {len(mesh.faces)} faces, closed",
        f"  volume: {mesh.mass:.6g}, in the unit of length of the file",
        f"  farthest from the centre of mass: {mesh.circumscribing_radius:.6g}",
        f"  in Python: pt.files.read_mesh({str(file)!r}, density=...)",
    ]


def _of_field(file: Path) -> Lines:
    field = files.read_field(file, mass=1.0)
    return [
        f"Gravity field: degree {field.degree}, reference radius {field.radius:.10g}",
        f"  in Python: pt.files.read_field({str(file)!r}, mass=...)",
    ]


def _of_kernel(file: Path) -> Lines:
    return [
        f"Kernel of SPICE: {file.name}",
        "  in Python: pt.files.spice_attitude, pt.files.spice_orbit, together with the kernels that it requires",
    ]


OF_OTHERS: dict[str, Callable[[Path], Lines]] = {
    **{".apm": _of_apm, ".oem": _of_oem, ".omm": _of_omm, ".tle": _of_omm},
    **{"alcdef": _of_alcdef, "damit curves": _of_damit_curves, "damit spin": _of_damit_spin, "readings": _of_csv},
    **dict.fromkeys((".obj", ".ply", ".stl", "damit shape"), _of_mesh),
    **dict.fromkeys((".gfc", ".sha"), _of_field),
    **dict.fromkeys((".bsp", ".tsc", ".tf", ".tls", ".tpc", ".tm"), _of_kernel),
}
