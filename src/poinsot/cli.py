"""The command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    help="Rotation of rigid bodies, at machine precision.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


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
    """Rotation of rigid bodies, at machine precision."""


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
