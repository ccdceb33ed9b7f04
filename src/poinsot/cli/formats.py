"""Contents and conversion of files: `poinsot info`, `poinsot convert`."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from poinsot import files
from poinsot.cli.terminal import (
    RESULTS,
    OfTwo,
    Overwrite,
    answer,
    busy,
    check_new,
    check_there,
    hand_over,
    listed_formats,
    tell,
    writing,
)

__all__ = ["convert", "info"]

Lines = list[str]


def info(
    file: Annotated[Path, typer.Argument(help="A result, a scenario, or another file that the package can read.")],
    scenario: Annotated[bool, typer.Option("--scenario", help="Print only the text of the scenario in it.")] = False,
) -> None:
    """Summarise a file: body and forces, times, method, drift of the integrals, and whether it can be run again.

    It also tells the contents of attitude files ({attitudes}, CCSDS APM), orbits (OEM), shapes (OBJ, PLY, STL, plates)
    and gravity fields (ICGEM, SHADR), and which function of the package reads them.

    For example:

    - `poinsot info top.nc`
    - `poinsot info top.nc --scenario > again.toml`
    - `poinsot info attitude.aem`
    """
    with busy(f"Reading {file}"):
        lines, text = _in_file(file)
    if not scenario:
        answer(*lines)
    elif text is None:
        raise ValueError(f"{file} must have a scenario to print, but it has none.")
    else:
        hand_over(text)


def convert(
    source: Annotated[Path, typer.Argument(help="A result (.nc, .zarr), or an attitude file.")],
    target: Annotated[Path, typer.Argument(help="The file to write; its suffix selects the format.")],
    scenario: Annotated[
        Path | None, typer.Option(help="From an attitude file to a result: a scenario with body and forces.")
    ] = None,
    zero: Annotated[
        str | None, typer.Option(help="The date of t = 0 with its scale, such as '2026-11-21T00:00:00 UTC'.")
    ] = None,
    frame: Annotated[str | None, typer.Option(help="The name of the space axes, such as ICRF.")] = None,
    body: OfTwo = None,
    overwrite: Overwrite = False,
) -> None:
    """Convert between results and attitude files.

    The formats of attitude files are {attitudes}. They need dates and the name of the space axes: pass them if the
    result has none. Times count from the calendar of the scenario, from --zero, or else from the first row.

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
    with writing(target):
        write(source, target, scenario=scenario, zero=zero, frame=frame, body=body, overwrite=overwrite)
    tell(target)


# ------------------------------------------------------------------ what a file has


def _in_file(file: Path) -> tuple[Lines, str | None]:
    """Return the lines about a file, and the text of the scenario in it."""
    check_there(file)
    if file.suffix == ".toml":
        return _of_scenario(file)
    if file.suffix in RESULTS:
        return _of_result(file)
    if not file.is_file():
        raise IsADirectoryError(f"{file} must be a file, got a folder.")
    with file.open("rb") as stream:
        head = stream.read(4096)
    kind = _kind_of(file, head)
    if kind in OF_OTHERS:
        return OF_OTHERS[kind](file), None
    from poinsot.files.attitudes.attitude_format import attitude_formats, format_of

    known = next((each for each in attitude_formats() if each.sniff(head)), format_of(file))
    if known is None:
        raise ValueError(
            f"{file} must be a result (.nc, .zarr), a scenario (.toml), attitudes ({listed_formats()}, CCSDS APM), an "
            "orbit (OEM), a shape (.obj, .ply, .stl, .tab) or a gravity field (.gfc, .tab), but it is none of them."
        )
    lines = _attitudes(f"Attitudes, {known.title}", known.read(file))
    return [*lines, f"  in Python: {known.in_python.format(path=str(file))}"], None


def _kind_of(file: Path, head: bytes) -> str:
    """Return what a file is by its first lines, or else the end of its name."""
    if message := re.search(rb"CCSDS_(APM|OEM|OMM)_VERS|<(apm|oem|omm)[\s>]", head):
        return f".{(message[1] or message[2]).decode().lower()}"
    if file.suffix.lower() == ".tab":
        return ".gfc" if b"," in head.partition(b"\n")[0] else ".obj"
    return file.suffix.lower()


def _of_scenario(file: Path) -> tuple[Lines, str | None]:
    from poinsot.files.scenarios.scenario import read_scenario

    job = read_scenario(file)
    lines = [
        job.provenance.get("title") or f"Scenario {file.name}",
        *_system(job.system),
        *_start(job.state, job.system.units),
        _span(job.times, job.system.units["time"]),
        *_seed(job),
        *(f"  writes: {name}" for name in job.outputs.values()),
    ]
    return lines, job.provenance["scenario"]


def _of_result(file: Path) -> tuple[Lines, str | None]:
    from poinsot.files.netcdf import load

    motion = load(file)
    reason = getattr(motion.system, "not_rerunnable", None)
    lines = [
        motion.provenance.get("title") or f"Result {file.name}",
        *_system(motion.system),
        *repr(motion).splitlines()[1:],
        *_members(motion),
        *_seed(motion),
        f"  versions: {', '.join(f'{name} {version}' for name, version in motion.run.versions.items())}",
        "  can be run again: yes" if reason is None else f"  can be run again: no. {reason}",
    ]
    return lines, motion.provenance.get("scenario")


def _members(motion: Any) -> Lines:
    """Return the line about an ensemble of which not all members are there to the end."""
    if not motion.is_ensemble or motion.reached[:, -1].all():
        return []
    return [f"  at the last time: {motion.reached[:, -1].sum()} of {len(motion)} members"]


def _seed(job: Any) -> Lines:
    seed = job.provenance.get("seed")
    return [] if seed is None else [f"  seed: {seed}"]


def _system(system: Any) -> Lines:
    """Return the lines about body and forces; of a system whose forces are not at hand, what its file says."""
    if hasattr(system, "not_rerunnable"):
        return [f"  system: {system!r}"]
    forces = [f"  force: {force!r}" for force in system.forces]
    return [f"  body: {system.body!r}", *(forces or ["  forces: none"])]


def _start(state: Any, units: Any) -> Lines:
    if state.shape:
        return [f"  members: {len(next(iter(state.phase.values())))}"]
    from poinsot.mechanics.units import DerivedUnits
    from poinsot.plot.labels import bracketed, momentum_label

    known, lines = DerivedUnits(units), Lines()
    for name, one in state.of_bodies.items():
        momentum, of = (
            f"{_written(one.angular_momentum_body)}{momentum_label(units)}",
            f" of the {name}" if name else "",
        )
        lines += [
            f"  start: quaternion{of} {_written(one.quaternion)}, scalar first, body to space",
            f"  start: angular momentum{of} {momentum}, body axes",
        ]
    if len(state.of_bodies) > 1:
        lines += [
            f"  start: position of the secondary {_written(state.position)}{bracketed(known.length)}",
            f"  start: momentum of the orbit {_written(state.momentum)}{bracketed(known.linear_momentum)}",
        ]
        return lines
    return [*lines, *(f"  start: {name} {_written(values)}" for name, values in state.own.items())]


def _written(values: Any) -> str:
    return f"({', '.join(f'{value:.9g}' for value in values)})"


def _span(times: Any, unit: str) -> str:
    return f"  times: {times.size}, {times[0]:.10g} ... {times[-1]:.10g}" + ("" if unit == "1" else f" {unit}")


# ------------------------------------------------------------------ other files


def _attitudes(title: str, table: Any) -> Lines:
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
        "  in Python: pt.files.spice_attitude, pt.files.spice_orbit, with the kernels beside it",
    ]


OF_OTHERS: dict[str, Callable[[Path], Lines]] = {
    **{".apm": _of_apm, ".oem": _of_oem, ".omm": _of_omm, ".tle": _of_omm},
    **dict.fromkeys((".obj", ".ply", ".stl"), _of_mesh),
    **dict.fromkeys((".gfc", ".sha"), _of_field),
    **dict.fromkeys((".bsp", ".tsc", ".tf", ".tls", ".tpc", ".tm"), _of_kernel),
}
