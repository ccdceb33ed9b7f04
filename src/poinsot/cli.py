"""The command line."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

CODES = (
    "Exit status: 0 done; 1 a comparison of `verify`, or of a repeated result with the original, failed; 2 the command "
    "line, a file or a value was not right; 3 a propagation stopped before its last time; 130 Ctrl-C. After 3 and 130 "
    "NAME.partial.nc has what was computed."
)

app = typer.Typer(
    help="Rotation of rigid bodies, at machine precision.",
    epilog=CODES,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

Out = Annotated[Path | None, typer.Option(help="Folder for what is written; default: that of the file.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace files that exist.")]

WRONG, STOPPED, INTERRUPTED = 2, 3, 130


def _version(wanted: bool) -> None:
    if wanted:
        from poinsot import __version__

        typer.echo(f"poinsot {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Rotation of rigid bodies, at machine precision.

    `poinsot new` writes a scenario to start from, `poinsot run` computes it, `poinsot info`, `plot` and `view` look at
    the result.
    """


# ------------------------------------------------------------------ scenarios and results


@app.command(epilog=CODES)
def run(
    file: Annotated[Path, typer.Argument(help="A scenario (.toml), or a result (.nc, .zarr) to be repeated.")],
    out: Out = None,
    overwrite: Overwrite = False,
    threads: Annotated[int | None, typer.Option(min=1, help="For an ensemble; default: all cores.")] = None,
) -> None:
    """Compute the motion that a scenario describes, and write it with all that is needed to compute it again.

    The result is NetCDF-4, named like the scenario, or as the scenario says under outputs (also a plot, a view).
    A result is repeated from what it has in itself, and compared: on the same versions it is the same to the bit.

    Examples: `poinsot run top.toml`; `poinsot run top.nc --out again`.
    """
    with _sentences():
        from poinsot.files.netcdf import load
        from poinsot.files.scenarios.scenario import read_scenario, repetition

        original = None if file.suffix == ".toml" else load(file)
        job = read_scenario(file) if original is None else repetition(original, str(file))
        names = _output_names(job, file, out, overwrite)
        motion = _propagated(job, names, overwrite, threads)
        _write_outputs(motion, names, overwrite)
        if original is not None and not _compare(original, motion):
            raise typer.Exit(1)


def _output_names(job: Any, file: Path, out: Path | None, overwrite: bool) -> dict[str, Path]:
    """Return the paths of the files to write; none of them is there, or all may be replaced."""
    folder = file.parent if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    named = {"result": f"{file.stem}.nc", **job.outputs}
    names = {kind: folder / name for kind, name in named.items()}
    names["partial"] = names["result"].with_suffix(f".partial{names['result'].suffix}")
    for path in names.values():
        if path.exists() and not overwrite:
            raise FileExistsError(
                f"{path} must be a new file, but it exists. --overwrite replaces it, --out leads away."
            )
    return names


def _propagated(job: Any, names: dict[str, Path], overwrite: bool, threads: int | None) -> Any:
    """Return the motion; of one that stops keep what there is, and exit."""
    from poinsot.errors import PropagationError, PropagationInterrupted
    from poinsot.files.netcdf import save

    try:
        with _busy(_title(job)):
            return job.propagate(threads=threads)
    except (PropagationError, PropagationInterrupted) as stopped:
        code = INTERRUPTED if isinstance(stopped, KeyboardInterrupt) else STOPPED
        save(stopped.trajectory, names["partial"], overwrite=overwrite)
        typer.echo(f"{stopped} What was computed is in {names['partial']}.", err=True)
        raise typer.Exit(code) from None


def _title(job: Any) -> str:
    """Return what a bar says of a scenario."""
    return str(job.provenance.get("title") or job.name)


def _write_outputs(motion: Any, names: dict[str, Path], overwrite: bool) -> None:
    from poinsot.files.netcdf import save

    written = [save(motion, names["result"], overwrite=overwrite)]
    if "plot" in names:
        written.append(_picture(motion, "quaternions", names["plot"]))
    if "view" in names:
        from poinsot.pictures.view import view as page

        written.append(page(motion, names["view"], overwrite=overwrite))
    for path in written:
        typer.echo(str(path))
    for member, why in list(motion.failures.items())[:10]:
        typer.echo(f"member {member}: {why}", err=True)


def _compare(original: Any, motion: Any) -> bool:
    """Say how a repeated motion differs from the original; return whether it is the same to the bit."""
    import numpy as np

    pairs = [(getattr(one, name) for one in (original, motion)) for name in ("quaternion", "conjugate_momenta")]
    arrays = [tuple(pair) for pair in pairs]
    if all(a.tobytes() == b.tobytes() for a, b in arrays):
        typer.echo("The same to the bit.")
        return True
    if arrays[0][0].shape != arrays[0][1].shape:
        typer.echo(f"It has other times: {original.times.size} before, {motion.times.size} now.")
        return False
    largest = max(float(np.nanmax(np.abs(a - b), initial=0.0)) for a, b in arrays)
    typer.echo(f"It differs by up to {largest:.2g} in q and Q.")
    before, now = original.run.versions, motion.run.versions
    others = [f"{name} {before.get(name)} -> {now[name]}" for name in now if before.get(name) != now[name]]
    typer.echo(f"Versions that differ: {', '.join(others) or 'none'}.")
    return False


class Kind(StrEnum):
    """What is drawn of a result."""

    quaternions = "quaternions"
    euler_angles = "euler_angles"
    rates = "rates"
    angular_momentum = "angular_momentum"
    drift = "drift"
    poinsot = "poinsot"
    polhode = "polhode"
    herpolhode = "herpolhode"


@app.command(epilog=CODES)
def plot(
    file: Annotated[Path, typer.Argument(help="A result (.nc, .zarr).")],
    kind: Annotated[Kind, typer.Option(help="What to draw.")] = Kind.quaternions,
    picture: Annotated[
        Path | None, typer.Argument(help="Ends in .png, .pdf or .svg; default: beside the result.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw a result, as the functions `plot_...` of the package do.

    Example: `poinsot plot top.nc --kind polhode`.
    """
    with _sentences():
        from poinsot.files.netcdf import load

        path = file.with_name(f"{file.stem}-{kind}.png") if picture is None else picture
        _check_new(path, overwrite)
        typer.echo(str(_picture(load(file), kind, path)))


def _picture(motion: Any, kind: str, path: Path) -> Path:
    import matplotlib as mpl
    import numpy as np

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    import poinsot

    figure = np.ravel(getattr(poinsot, f"plot_{kind}")(motion))[0].figure
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path


@app.command(epilog=CODES)
def view(
    file: Annotated[Path, typer.Argument(help="A result (.nc, .zarr) of one body.")],
    page: Annotated[Path | None, typer.Argument(help="Ends in .html; default: beside the result.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a page that plays a result in three dimensions, in any browser, without a network.

    Example: `poinsot view top.nc`.
    """
    with _sentences():
        from poinsot.files.netcdf import load
        from poinsot.pictures.view import view as write

        typer.echo(str(write(load(file), page or file.with_suffix(".html"), overwrite=overwrite)))


@app.command(epilog=CODES)
def info(
    file: Annotated[Path, typer.Argument(help="A result (.nc, .zarr) or a scenario (.toml).")],
    scenario: Annotated[
        bool, typer.Option("--scenario", help="Print the text of the scenario in it, no more.")
    ] = False,
) -> None:
    """Tell what a file has: body and forces, times, how it was computed, its drift, and whether it can be run again.

    Example: `poinsot info top.nc --scenario > again.toml`.
    """
    with _sentences():
        from poinsot.files.netcdf import load
        from poinsot.files.scenarios.scenario import read_scenario

        if file.suffix == ".toml":
            job = read_scenario(file)
            motion, lines = None, [f"Scenario of {job.system!r}", f"  start: {job.state!r}", _span(job.times)]
            text = job.provenance["scenario"]
        else:
            motion = load(file)
            lines, text = _told(motion), motion.provenance.get("scenario", "")
        typer.echo(text if scenario else "\n".join(lines), nl=not scenario)


def _told(motion: Any) -> list[str]:
    """Return the lines about a result."""
    title, seed = (motion.provenance.get(key) for key in ("title", "seed"))
    reason = getattr(motion.system, "not_rerunnable", None)
    versions = ", ".join(f"{name} {version}" for name, version in motion.run.versions.items())
    return [
        *([title] if title else []),
        *(line for line in repr(motion).splitlines() if not line.startswith("  wall_time")),
        *([f"  seed: {seed}"] if seed is not None else []),
        f"  versions: {versions}",
        "  can be run again: yes" if reason is None else f"  can be run again: no. {reason}",
    ]


def _span(times: Any) -> str:
    return f"  times: {times.size}, {times[0]:.10g} ... {times[-1]:.10g}"


@app.command(epilog=CODES)
def convert(
    source: Annotated[Path, typer.Argument(help="A result (.nc, .zarr), or attitudes (.aem, .bc, .a, .csv).")],
    target: Annotated[Path, typer.Argument(help="The file to write; its end says the format.")],
    scenario: Annotated[
        Path | None, typer.Option(help="From attitudes to a result: a scenario with body and forces.")
    ] = None,
    zero: Annotated[
        str | None, typer.Option(help="The date of t = 0 with its scale, '2026-11-21T00:00:00 UTC'.")
    ] = None,
    frame: Annotated[str | None, typer.Option(help="The name of the space axes, such as ICRF.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Convert between results and files of attitudes: CCSDS AEM (.aem), SPICE CK (.bc), STK (.a), tables (.csv).

    Files of attitudes have dates, and the name of the space axes: say them where the result has none.

    Examples: `poinsot convert top.nc top.zarr`; `poinsot convert sat.nc sat.aem --zero "2026-11-21T00:00:00 UTC"
    --frame ICRF`; `poinsot convert sat.aem sat.nc --scenario sat.toml`.
    """
    with _sentences():
        from poinsot.files.conversions import convert as write

        typer.echo(str(write(source, target, scenario=scenario, zero=zero, frame=frame, overwrite=overwrite)))


@app.command(epilog=CODES)
def new(
    file: Annotated[Path, typer.Argument(help="The scenario to write, .toml.")] = Path("scenario.toml"),
    overwrite: Overwrite = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON Schema for editors instead.")] = False,
) -> None:
    """Write a scenario to start from, with a comment on every line.

    Example: `poinsot new satellite.toml && poinsot run satellite.toml`.
    """
    with _sentences():
        if schema:
            import json

            from poinsot.files.scenarios.model import schema as of_scenarios

            typer.echo(json.dumps(of_scenarios(), indent=1))
            return
        from poinsot.files.scenarios.start import START
        from poinsot.files.writing import write_text

        if file.suffix != ".toml":
            raise ValueError(f"file must end in .toml, but {file.name!r} came.")
        _check_new(file, overwrite)
        typer.echo(str(write_text(file, START, overwrite)))


@contextlib.contextmanager
def _sentences() -> Iterator[None]:
    """Tell errors and warnings as one sentence each."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            yield
        except (OSError, ValueError, ImportError, MemoryError) as error:
            typer.echo(f"poinsot: {error}", err=True)
            raise typer.Exit(WRONG) from None
        except KeyboardInterrupt:
            raise typer.Exit(INTERRUPTED) from None
        finally:
            for message in dict.fromkeys(str(warning.message) for warning in told if warning.category is UserWarning):
                typer.echo(f"warning: {message}", err=True)


@contextlib.contextmanager
def _busy(what: str) -> Iterator[None]:
    """Show that something is being computed, and for how long, on a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        bar.add_task(what, total=None)
        yield


def _check_new(path: Path, overwrite: bool) -> None:
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} must be a new file, but it exists. --overwrite replaces it.")


# ------------------------------------------------------------------ the paper, and checks


@app.command()
def paper(
    out: Annotated[Path, typer.Option(help="Folder for figures, NetCDF files and the table.")] = Path("out"),
) -> None:
    """Integrate the three problems of Arribas, Elipe and Palacios (2006) and show how exact the result is.

    Writes Figs. 1-3 (PNG, PDF), one NetCDF file for each case, and table.md. Files of these names are replaced.
    """
    import matplotlib as mpl
    from rich.console import Console
    from rich.progress import track

    mpl.use("Agg")
    from poinsot import paper as problems

    console = Console()
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise typer.BadParameter(f"out must be a folder that can be written, but {error}.") from None
    rows: list[problems.Row] = []
    for problem in track(problems.PROBLEMS, "The paper's problems", console=console, disable=not console.is_terminal):
        motion, found = problems.solve(problem)
        problems.write(motion, problem, out)
        rows += found
        console.print(_table(problem.title, found))
        (out / "table.md").write_text(problems.markdown_table(rows))
    console.print(problems.PERIGEE, highlight=False)
    console.print(f"Figures (png, pdf), motions (nc) and table.md are in {out}/. Start with {out}/fig1-torque-free.png")


@app.command()
def verify() -> None:
    """Check this installation against motions that others published; exit status 1 if one differs too much.

    Ten seconds, the first time half a minute. `expected` is the most that a difference may be.
    """
    from rich.console import Console
    from rich.progress import track

    from poinsot import verify as checks

    console = Console()
    cases = track(checks.CASES, "Verifying", console=console, transient=True, disable=not console.is_terminal)
    found = [(case, checks.rows_of(case)) for case in cases]
    console.print(_comparisons(found))
    rows = [row for _, rows in found for row in rows]
    failed = sum(not row.holds for row in rows)
    console.print(f"{failed} of {len(rows)} comparisons fail." if failed else f"All {len(rows)} comparisons hold.")
    console.print(checks.installation(), highlight=False)
    if failed:
        raise typer.Exit(1)


def _comparisons(found: list) -> object:  # type: ignore[type-arg]
    """Return the comparisons of all cases, each under its title and source."""
    from rich import box
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("case, source, what is compared")
    for heading in ("difference", "expected"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for number, (case, rows) in enumerate(found, 1):
        table.add_row(Text(f"{number}. {case.title}", style="bold"))
        table.add_row(Padding(Text(case.source, style="dim"), (0, 0, 0, 3)))
        for row in rows:
            verdict = Text("ok") if row.holds else Text("FAILED", style="bold red")
            quantity = Padding(Text(row.quantity), (0, 0, 0, 3))
            table.add_row(quantity, f"{row.difference:.1e}", f"{row.expected:.1e}", verdict)
    return table


def _table(title: str, rows: list) -> object:  # type: ignore[type-arg]
    """Return the rows of one case, narrow enough for any terminal."""
    from rich import box
    from rich.table import Table

    headings = ("formulation", "steps", "order", "ms", "|q|-1", "q.Q", "drift", "error")
    table = Table(*headings, title=f"{title} (error in rad)", title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    for row in rows:
        cells = (row.formulation, row.steps, row.order, row.milliseconds, row.norm_error, row.tangency_error)
        table.add_row(*cells, row.drift.replace(", ", "\n"), row.attitude_error)
    return table
