"""Readings of observables: `poinsot observe`."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from poinsot import files
from poinsot.cli.formats import facts_of_readings
from poinsot.cli.runs import job_in, remove_store, stored
from poinsot.cli.terminal import (
    INTERRUPTED,
    STOPPED,
    Json,
    Overwrite,
    advise,
    busy,
    check_new,
    hand_over_json,
    one_of,
    opened,
    report_path,
    results_written_first,
    say,
)
from poinsot.printable import quoted

if TYPE_CHECKING:
    from poinsot.files.scenario import Scenario
    from poinsot.observables.readings import Readings
    from poinsot.propagation.trajectory import Trajectory

__all__ = ["observe"]

ENDINGS = {"nc": ".readings.nc", "csv": ".readings.csv", "damit": ".lc.txt", "alcdef": ".alcdef.txt"}
"""Endings of the files by format."""

MAX_SEED = 2**52 - 1000
"""Largest seed, from which the seeds of all observables of a scenario count."""


def observe(
    file: Annotated[Path, typer.Argument(help="Scenario (.toml) with [[observe]], or result (.nc, .zarr) of one.")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="PATH",
            help="Folder for the output files, the file of the readings, or a store NAME.zarr for the readings of an "
            "ensemble; default: the folder of FILE.",
        ),
    ] = None,
    kind: Annotated[
        str,
        typer.Option(
            "--format",
            help="Format: nc (NetCDF, all readings), csv (one file per observable), damit or alcdef (light curves).",
            autocompletion=one_of(*ENDINGS),
        ),
    ] = "nc",
    noise: Annotated[
        int | None,
        typer.Option(min=0, max=MAX_SEED, metavar="SEED", help="Add random errors, which depend on SEED alone."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the run in an existing store, or start it.")
    ] = False,
    overwrite: Overwrite = False,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Number of threads for an ensemble; default: all cores.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Write the readings of the observables in a scenario.

    The tables [[observe]] of NAME.toml describe light curves, gyroscopes, star trackers and other observables. The
    command propagates the scenario and writes NAME.readings.nc. If FILE is a result, the command reads the motion in
    it.

    With --out NAME.zarr the members of an ensemble are propagated in chunks, and the store contains the readings alone,
    so that the memory contains the motions of a few chunks at a time. After an interruption, the same command with
    --resume computes only the missing chunks.

    For example:

    - `poinsot observe asteroid.toml` writes asteroid.readings.nc
    - `poinsot observe asteroid.toml --format csv --noise 7`
    - `poinsot observe asteroid.toml --format damit --out lc.txt`
    - `poinsot observe asteroid.nc` observes the motion in a result
    - `poinsot observe asteroids.toml --out curves.zarr --resume` starts or continues the light curves of an ensemble
    """
    if kind not in ENDINGS:
        raise ValueError(f"--format must be one of {', '.join(ENDINGS)}, got {quoted(kind)}.")
    job, original = job_in(file)
    if not job.plans:
        raise ValueError(f"{file} must have a table [[observe]], got none. `poinsot new --schema` describes it.")
    if out is not None and out.suffix == ".zarr":
        _check_store(job, original is None, kind, noise)
        _observe_in_store(job, file, out, overwrite, resume, threads, as_json)
        return
    if resume:
        raise ValueError("--resume must go with --out NAME.zarr, got no store.")
    paths = list(_paths(job, file, out, kind))
    _check_outputs(paths, overwrite)
    motion = _propagated(job, threads) if original is None else original
    with busy(f"Observing {file}"):
        readings = job.observe(motion, noise=noise)
    _write(readings, kind, paths, overwrite, quiet=as_json)
    if as_json:
        hand_over_json(
            {"files": [str(path) for path in paths], "readings": [facts_of_readings(each) for each in readings]}
        )
    advise((opened("info", paths[0]), "summarises the readings"), (opened("plot", paths[0]), "plots the readings"))
    if motion.failures:
        say(f"{len(motion.failures)} of {len(motion)} members stopped before the last time. Their readings are NaN.")
        raise typer.Exit(STOPPED)


def _check_store(job: Scenario, from_scenario: bool, kind: str, noise: int | None) -> None:
    """Raise a ValueError for readings that no store can contain."""
    from poinsot.systems.times_and_states import common_members

    several = bool(common_members(job.system, job.state))
    rules = {
        "of the format nc": kind == "nc",
        "without --noise": noise is None,
        "of a scenario": from_scenario,
        "of an ensemble": several,
        "at the output times": len(job.instruments) == len(job.plans) or not several,
    }
    for rule, holds in rules.items():
        if not holds:
            raise ValueError(f"--out NAME.zarr must be for readings {rule}, got other readings.")


def _observe_in_store(
    job: Scenario, file: Path, out: Path, overwrite: bool, resume: bool, threads: int | None, as_json: bool
) -> None:
    """Write the readings of an ensemble to a store, in chunks of members."""
    from poinsot.mechanics.observable import observables_by_name

    check_new(out, overwrite or resume, " or --resume")
    if overwrite and out.exists():
        remove_store(out)
    names = list(observables_by_name(job.instruments))
    goes_on = f"{opened('observe', file)} --out {shlex.quote(str(out))} --resume"
    stored(job, goes_on, threads, {"out": out, "variables": names})
    if as_json:
        hand_over_json({"files": [str(out)], "variables": names})
    else:
        report_path(out)
    advise((opened("info", out), "summarises the store"))


def _paths(job: Scenario, file: Path, out: Path | None, kind: str) -> Iterator[Path]:
    """Yield the paths of the files to write: one, or for CSV one for each observable."""
    ending = ENDINGS[kind]
    stem = file.name.removesuffix(file.suffix)
    folder, name = (file.parent if out is None else out), f"{stem}{ending}"
    if out is not None and out.suffix and not out.is_dir():
        folder, name = out.parent, out.name
        if not name.endswith(Path(ending).suffix):
            raise ValueError(f"--out must end in {Path(ending).suffix} for the format {kind}, got {out.name}.")
    if out is not None and not out.suffix:
        folder.mkdir(parents=True, exist_ok=True)
    if kind != "csv" or len(job.plans) == 1:
        yield folder / name
        return
    end = ending if name.endswith(ending) else Path(ending).suffix
    for plan in job.plans:
        own = re.sub(r"[^\w-]+", "_", plan.name)
        yield folder / f"{name.removesuffix(end)}.{own}{end}"


def _check_outputs(paths: list[Path], overwrite: bool) -> None:
    """Check the output files before the run."""
    for path in paths:
        check_new(path, overwrite, " or --out PATH")
        if not os.access(path.parent, os.W_OK | os.X_OK):
            raise PermissionError(f"{path.parent} must be a folder that can be written, but it is not.")


def _write(readings: tuple[Readings, ...], kind: str, paths: list[Path], overwrite: bool, quiet: bool) -> None:
    """Write a file of all readings, or for CSV a file of each."""
    contents = readings if kind == "csv" else [readings]
    with results_written_first():
        for path, content in zip(paths, contents, strict=True):
            with busy(f"Writing {path}"):
                getattr(files, WRITERS[kind])(content, path, overwrite=overwrite)
            if not quiet:
                report_path(path)


def _propagated(job: Scenario, threads: int | None) -> Trajectory:
    """Return the motion of a scenario; exit if it stops early."""
    from poinsot.errors import PropagationError, PropagationInterrupted

    try:
        return job.propagate(threads=threads, progress=sys.stderr.isatty(), readings=False)
    except (PropagationError, PropagationInterrupted) as stopped:
        code = INTERRUPTED if isinstance(stopped, KeyboardInterrupt) else STOPPED
        say(f"poinsot: {stopped} No readings were written.")
        raise typer.Exit(code) from None


WRITERS = {
    "nc": "write_readings",
    "csv": "write_readings_csv",
    "damit": "write_damit",
    "alcdef": "write_alcdef",
}
"""Names of the functions of `poinsot.files` that write readings, by format."""
