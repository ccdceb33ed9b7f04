"""Scenarios and results: `poinsot new`, `poinsot run`."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from poinsot.cli.terminal import (
    DIFFERS,
    INTERRUPTED,
    RESULTS,
    STOPPED,
    Json,
    Overwrite,
    advise,
    answer,
    busy,
    check_ending,
    check_new,
    check_there,
    hand_over,
    hand_over_json,
    loaded_motion,
    opened,
    report_path,
    results_written_first,
    say,
)
from poinsot.printable import quoted

if TYPE_CHECKING:
    from poinsot.files.scenario import Scenario
    from poinsot.propagation.trajectory import Trajectory
    from poinsot.storage.chunk_plan import Chunking

__all__ = ["job_in", "new", "remove_store", "run", "stored"]

MIN_BYTES_PER_ROW = 150
"""Smallest size of a result in bytes, for each time and member."""

NO_FOLDERS = {".nc", ".nc4", ".zarr", ".h5", ".hdf5", ".npz", ".csv", ".txt", ".json", ".toml", ".html", ".png", ".pkl"}
"""Endings of files, which no folder should have."""

MAX_LISTED_FAILURES = 10
"""Largest number of members whose failures are listed one by one."""


def new(
    file: Annotated[Path, typer.Argument(help="Scenario file to write (.toml).")] = Path("scenario.toml"),
    overwrite: Overwrite = False,
    schema: Annotated[
        bool,
        typer.Option(
            "--schema", help="Print the JSON Schema, with which editors check and complete scenarios, instead."
        ),
    ] = False,
) -> None:
    """Write an example scenario of a satellite, with a comment on every line.

    For example:

    - `poinsot new satellite.toml`, then `poinsot run satellite.toml`
    - `poinsot new --schema > scenario.schema.json`
    """
    if schema:
        import json

        from poinsot.scenarios.schema import schema as of_scenarios

        hand_over(json.dumps(of_scenarios(), indent=1) + "\n")
        advise(("poinsot new NAME.toml", "writes an example scenario"))
        return
    from poinsot.atomic_write import write_text

    check_ending(file, ".toml")
    check_new(file, overwrite)
    template = (resources.files("poinsot.scenarios") / "template.toml").read_text(encoding="utf-8")
    with busy(f"Writing {file}"):
        write_text(file, template, overwrite)
    report_path(file)
    advise((opened("run", file), "propagates the scenario"))


def run(
    file: Annotated[Path, typer.Argument(help="Scenario (.toml), or result (.nc, .zarr) to repeat.")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="PATH",
            help="Folder for the output files, or the file of the result, NAME.nc or NAME.zarr, next to which the "
            "other files are written; default: the folder of FILE.",
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the run in an existing store, or start it.")
    ] = False,
    chunk: Annotated[
        int | None,
        typer.Option(
            min=1, help="Number of members per chunk of the store; default: chosen from the available memory."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address of a dask scheduler, such as tcp://host:8786; the workers of its cluster compute the chunks.",
        ),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Estimate size and run time from a small sample, and write nothing.")
    ] = False,
    overwrite: Overwrite = False,
    threads: Annotated[
        int | None,
        typer.Option(min=1, help="Number of threads for an ensemble; default: all cores, on a dask worker one."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Propagate a scenario and write the result, or repeat a result.

    The result of NAME.toml is NAME.nc (NetCDF-4). It contains the scenario, so that the run can be repeated. The table
    [outputs] of the scenario can set another file name and request a plot and a 3D view. After Ctrl-C, or if the
    propagation stops early, NAME.partial.nc contains the output times reached so far.

    With --out NAME.zarr the members of an ensemble are written to a store in chunks, so that the memory contains only
    a few chunks at a time. After Ctrl-C, SIGTERM, kill -9 or a full disk, the same command with --resume computes only
    the missing chunks. `poinsot run NAME.zarr --resume` does the same with the scenario in the store.

    If FILE is a result, poinsot repeats its propagation, writes NAME-again.nc and compares both results. With the same
    versions of poinsot and its dependencies they agree bit for bit.

    For example:

    - `poinsot run top.toml` writes top.nc
    - `poinsot run top.nc` repeats the result, writes top-again.nc and compares
    - `poinsot run top.toml --out spin.nc` writes spin.nc
    - `poinsot run tops.toml --out results --threads 4`
    - `poinsot run tops.toml --dry-run` estimates size and run time
    - `poinsot run tops.toml --out tops.zarr --resume` starts or continues the run in a store
    - `poinsot run tops.zarr --resume`
    - `poinsot run tops.toml --out /shared/tops.zarr --resume --scheduler tcp://host:8786`
    - `poinsot run top.toml --json`
    """
    job, original = job_in(file)
    if resume and file.suffix == ".zarr" and out in (None, file):
        out, original = file, None
    store = _store(job, out, resume=resume, chunk=chunk, scheduler=scheduler)
    if dry_run:
        _estimate(job, threads, as_json)
        advise((opened("run", file), "propagates the scenario"))
        return
    names = _output_names(job, original is not None, file, out, store)
    _check_outputs(job, names, overwrite, resume)
    if store is None:
        motion = _propagated(job, names["partial"], overwrite, threads)
    else:
        goes_on = f"{opened('run', file)} --out {shlex.quote(str(store))} --resume"
        goes_on += f" --scheduler {shlex.quote(scheduler)}" if scheduler else ""
        with _workers(scheduler) as client:
            if overwrite and store.exists():
                remove_store(store)
            motion = stored(job, goes_on, threads, {"out": store, "chunk": chunk, "client": client})
    written: dict[str, Any] = {}
    for kind, path in _write_outputs(motion, names, overwrite):
        written[kind] = str(path)
        if not as_json:
            report_path(path)
    status = _report(motion, original, written if as_json else None)
    members = " --member 0" * motion.is_ensemble
    advise(
        (opened("info", names["result"]), "summarises the result"),
        (opened("plot", names["result"]), "plots the result"),
        (f"{opened('view', names['result'])}{members}", "writes a 3D view"),
    )
    if status:
        raise typer.Exit(status)


def _estimate(job: Scenario, threads: int | None, as_json: bool) -> None:
    """Print the estimated time and memory of a run."""
    from poinsot.analysis.run_estimate import estimate_run

    options = {name: value for name, value in job.run.items() if name != "method"}
    if job.run.get("method") == "closed form":
        raise ValueError("--dry-run must go with an integration, got run.method = 'closed form'. It takes no time.")
    with busy("Computing a sample"):
        found = estimate_run(job.system, job.state, job.times, threads=threads, **options)
    if as_json:
        facts = {name: value for name, value in vars(found).items() if name not in ("system", "times")}
        hand_over_json({**facts, "times": found.times.size})
    else:
        answer(*repr(found).replace("give out=", "give --out NAME.zarr").splitlines())


@contextlib.contextmanager
def _workers(scheduler: str | None) -> Iterator[Any]:
    """Yield a client of the workers of a scheduler, or None without a scheduler."""
    if scheduler is None:
        yield None
        return
    try:
        import distributed
    except ImportError:
        raise ImportError("--scheduler needs dask: pip install 'poinsot[cluster]'.") from None
    if not re.fullmatch(r"(\w+://)?[^/]+:\d+", scheduler):
        raise ValueError(f"--scheduler must be an address such as tcp://host:8786, got {quoted(scheduler)}.")
    with busy(f"Connecting to {scheduler}"):
        try:
            made: Any = distributed.Client
            client = made(scheduler, timeout=SCHEDULER_TIMEOUT)
        except OSError as error:
            why = f"{error}".split("\n")[0].rstrip(".")
            raise OSError(f"--scheduler must be the address of one that runs, got {scheduler}: {why}.") from None
    with client:
        yield client


SCHEDULER_TIMEOUT = "10s"
"""Longest wait for a scheduler."""


def _report(motion: Trajectory, original: Trajectory | None, written: dict[str, Any] | None) -> int:
    """Print the comparison with a repeated motion and the failed members; return the exit status."""
    same, compared = (True, []) if original is None else _compared(original, motion)
    if written is not None:
        written |= {} if original is None else {"same": same, "compared": compared}
        hand_over_json({**written, "summary": motion.summary, "failures": motion.failures})
    elif compared:
        answer(*compared)
    if motion.failures:
        _report_failures(motion)
    return DIFFERS if not same else STOPPED if motion.failures else 0


def _store(job: Scenario, out: Path | None, **of_stores: object) -> Path | None:
    """Return the store of an ensemble if one is asked for; refuse options that go with one alone."""
    from poinsot.systems.times_and_states import common_members

    named = out is not None and out.suffix == ".zarr"
    if named and common_members(job.system, job.state):
        return out
    for name, value in of_stores.items():
        if value:
            given = "one motion" if named else "no store"
            raise ValueError(f"--{name} must go with an ensemble and --out NAME.zarr, got {given}.")
    return None


def job_in(file: Path) -> tuple[Scenario, Trajectory | None]:
    """Return the job that a file describes, and the original motion if the file is a result."""
    from poinsot.files.scenario import read_scenario, repetition

    check_there(file)
    if file.suffix == ".toml":
        return read_scenario(file), None
    if file.suffix not in RESULTS:
        raise ValueError(f"{file} must be a scenario, .toml, or a result, .nc or .zarr, but it is none.")
    original = loaded_motion(file)
    return repetition(original, str(file)), original


def _output_names(job: Scenario, repeated: bool, file: Path, out: Path | None, store: Path | None) -> dict[str, Path]:
    """Return the paths of the files to write, by kind."""
    if store is not None:
        others = {kind: store.parent / name for kind, name in job.outputs.items() if kind != "result"}
        return {"result": store, **others}
    folder = file.parent if out is None else out
    if out is not None and out.suffix not in RESULTS and (out.is_file() or _looks_like_a_file(out)):
        raise ValueError(f"--out must be a folder, NAME.nc or NAME.zarr, got the file {out}.")
    if out is not None and out.suffix in RESULTS:
        folder, named = out.parent, {**job.outputs, "result": out.name}
    elif repeated:
        named = {"result": file.name if out is not None else f"{file.stem}-again{file.suffix}"}
    else:
        named = {"result": f"{file.stem}.nc", **job.outputs}
    names = {kind: folder / name for kind, name in named.items()}
    return names | {"partial": names["result"].with_suffix(f".partial{names['result'].suffix}")}


def _looks_like_a_file(path: Path) -> bool:
    """Return True if a path that is no folder ends like a file."""
    return path.suffix.lower() in NO_FOLDERS and not path.is_dir()


def _check_outputs(job: Scenario, names: dict[str, Path], overwrite: bool, resume: bool) -> None:
    """Check the output files before the run."""
    from poinsot.systems.times_and_states import common_members

    members = common_members(job.system, job.state)
    if "view" in names and members:
        raise ValueError(f"{names['view']} must be of one motion, but the scenario has an ensemble, which has no view.")
    folder = names["result"].parent
    folder.mkdir(parents=True, exist_ok=True)
    for kind, path in names.items():
        store = kind == "result" and "partial" not in names
        check_new(path, overwrite or (store and resume), " or --resume" if store else " or --out DIR")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} must be a folder that can be written, but it is not.")
    needed, free = MIN_BYTES_PER_ROW * job.times.size * max(members or (1,)), shutil.disk_usage(folder).free
    if free < needed and "partial" in names:
        raise OSError(f"{folder} must have room for some {needed / 1e6:.0f} MB, but {free / 1e6:.0f} MB are free.")


def _propagated(job: Scenario, partial: Path, overwrite: bool, threads: int | None) -> Trajectory:
    """Return the motion; if it stops early, write the partial motion and exit."""
    import numpy as np

    from poinsot.errors import PropagationError, PropagationInterrupted
    from poinsot.files.netcdf import save

    try:
        return job.propagate(threads=threads, progress=sys.stderr.isatty())
    except (PropagationError, PropagationInterrupted) as stopped:
        code = INTERRUPTED if isinstance(stopped, KeyboardInterrupt) else STOPPED
        where = "No output time was reached."
        if np.any(stopped.trajectory.reached):
            with results_written_first(), busy(f"Writing {partial}"):
                save(stopped.trajectory, partial, overwrite=overwrite)
            where = f"The output times reached so far are in {partial}."
        say(f"poinsot: {stopped} {where}")
        raise typer.Exit(code) from None


def stored(job: Scenario, goes_on: str, threads: int | None, chunking: Chunking) -> Trajectory:
    """Return the motions of an ensemble in a store. If the run stops, print the command that continues it, and exit."""
    from poinsot.errors import PropagationInterrupted

    try:
        return job.propagate(threads=threads, progress=sys.stderr.isatty(), **chunking)
    except PropagationInterrupted as stopped:
        message = str(stopped).removesuffix(" The same call continues the run.")
        say(f"poinsot: {message} `{goes_on}` continues the run.")
        raise typer.Exit(INTERRUPTED) from None
    except OSError as error:
        raise OSError(str(error).replace("the same call goes on.", f"`{goes_on}` continues the run.")) from None


def remove_store(path: Path) -> None:
    """Remove the store of another run; refuse another folder."""
    from poinsot.storage.ensemble_store import EnsembleStore
    from poinsot.storage.zarr_group import StoreError

    try:
        EnsembleStore(path)
    except StoreError:
        raise ValueError(f"{path} must be the store of an ensemble to be replaced, got another folder.") from None
    shutil.rmtree(path)


def _write_outputs(motion: Trajectory, names: dict[str, Path], overwrite: bool) -> Iterator[tuple[str, Path]]:
    """Write the files, and yield the kind and the path of each when it is there."""
    from poinsot.files.netcdf import save

    if "partial" in names:
        with results_written_first(), busy(f"Writing {names['result']}"):
            save(motion, names["result"], overwrite=overwrite)
    yield "result", names["result"]
    if "plot" in names:
        from poinsot.cli.plots import drawn, usual_kind

        yield "plot", drawn(motion, usual_kind(motion), names["plot"], overwrite)
    if "view" in names:
        from poinsot.cli.plots import viewed

        yield "view", viewed(motion, names["view"], overwrite)


def _report_failures(motion: Trajectory) -> None:
    failures = motion.failures
    say(f"{len(failures)} of {len(motion)} members stopped before the last time.")
    for member, why in list(failures.items())[:MAX_LISTED_FAILURES]:
        say(f"member {member}: {why}")
    if len(failures) > MAX_LISTED_FAILURES:
        say(f"... and {len(failures) - MAX_LISTED_FAILURES} more, which `motion.failures` lists.")


def _compared(original: Trajectory, motion: Trajectory) -> tuple[bool, list[str]]:
    """Return True if a repeated motion equals the original bit for bit, and sentences about the comparison."""
    import numpy as np

    shared = np.isin(motion.times, original.times)
    if np.sum(shared) != original.times.size:
        return False, [f"The number of output times differs: {original.times.size} before, {motion.times.size} now."]
    known = original.reached
    again = {name: motion.phase[name] if name in motion.phase else getattr(motion, name) for name in original.phase}
    before = {name: np.asarray(values) for name, values in original.phase.items()}
    pairs = [(values[known], np.asarray(again[name])[..., shared, :][known]) for name, values in before.items()]
    if all(one.tobytes() == other.tobytes() for one, other in pairs):
        whole = motion.times.size == original.times.size and np.array_equal(known, motion.reached)
        return True, [
            "The two results agree bit for bit."
            if whole
            else "The two results agree bit for bit at all output times of the original."
        ]
    largest = max(float(np.nanmax(np.abs(other - one), initial=0.0)) for one, other in pairs)
    old, now = original.run.versions, motion.run.versions
    others = [f"{name} {old.get(name)} -> {now[name]}" for name in now if old.get(name) != now[name]]
    return False, [
        f"The quaternions and momenta differ by up to {largest:.2g}.",
        f"Packages with different versions: {', '.join(others) or 'none'}.",
    ]
