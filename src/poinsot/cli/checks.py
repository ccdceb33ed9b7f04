"""Verification against published motions: `poinsot paper`, `poinsot verify`."""

from __future__ import annotations

import shlex
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from poinsot.cli.terminal import (
    DIFFERS,
    INTERRUPTED,
    Json,
    Overwrite,
    advise,
    answer,
    check_new,
    hand_over_json,
    opened,
    say,
)
from poinsot.display.progress import ReportProgress, bar

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from poinsot.validation.cases import Case, Comparison
    from poinsot.validation.paper import ErrorRow

    Results = list[tuple[Case, list[Comparison]]]

__all__ = ["paper", "verify"]


def paper(
    out: Annotated[
        Path, typer.Option(help="Folder for the figures, NetCDF files and the table of errors.", file_okay=False)
    ] = Path("out"),
    overwrite: Overwrite = False,
) -> None:
    """Integrate the three problems of Arribas, Elipe and Palacios (2006) and print the errors.

    The command writes Figs. 1-3 of the paper (PNG, PDF), one NetCDF file for each case, and table.md. The first run
    takes half a minute. After Ctrl-C the files of the completed cases remain.

    For example:

    - `poinsot paper`
    - `poinsot paper --out problems --overwrite`
    """
    import matplotlib as mpl
    from rich.console import Console

    mpl.use("Agg")
    from poinsot.atomic_write import write_text
    from poinsot.validation import paper as problems

    console = Console()
    out.mkdir(parents=True, exist_ok=True)
    for name in [f"{problem.name}{end}" for problem in problems.PROBLEMS for end in (".png", ".pdf", ".nc")]:
        check_new(out / name, overwrite)
    check_new(out / "table.md", overwrite)
    rows: list[problems.ErrorRow] = []
    with _bar("The paper's problems", len(problems.PROBLEMS), console) as report:
        for problem in problems.PROBLEMS:
            report(bool(rows), problem.title)
            motion, found = problems.solve(problem)
            problems.write(motion, problem, out)
            rows += found
            console.print(_table(problem.title, found))
            write_text(out / "table.md", problems.markdown_table(rows), overwrite=True)
    console.print(problems.PERIGEE, highlight=False)
    answer(f"The folder {out}/ contains the figures (png, pdf), the motions (nc) and table.md.")
    first = out / problems.PROBLEMS[0].name
    advise(
        (f"open {shlex.quote(f'{first}.png')}", "opens the first figure"),
        (opened("view", first.with_suffix(".nc")), "writes a 3D view of the motion"),
    )


def verify(as_json: Json = False) -> None:
    """Compare results of this installation with published and exact solutions.

    The comparisons take ten seconds, on the first run half a minute. Each one holds if the difference is at most the
    tolerance. After Ctrl-C the command prints the completed comparisons.

    For example:

    - `poinsot verify`
    - `poinsot verify --json`
    """
    from rich.console import Console

    from poinsot.validation import cases as checks

    console = Console()
    found: Results = []
    interrupted = False
    with _bar("Verifying", len(checks.CASES), console) as report:
        try:
            for case in checks.CASES:
                report(bool(found), case.title)
                found.append((case, checks.comparisons_of(case)))
        except KeyboardInterrupt:
            interrupted = True
    failed = sum(not row.holds for _, rows in found for row in rows)
    if as_json:
        hand_over_json({"installation": checks.installation(), "interrupted": interrupted, "cases": _facts(found)})
    else:
        _show(console, found, failed, checks.installation())
    if interrupted:
        say(f"poinsot: interrupted. {len(found)} of {len(checks.CASES)} cases were compared.")
        raise typer.Exit(INTERRUPTED)
    if failed:
        advise(("poinsot verify --json > verify.json", "writes the results for a bug report"))
        raise typer.Exit(DIFFERS)
    advise(("poinsot new", "writes an example scenario"))


def _facts(found: Results) -> list[dict[str, Any]]:
    """Return the comparisons of all cases for programs."""
    return [
        {
            "title": case.title,
            "source": case.source,
            "comparisons": [{**vars(row), "holds": bool(row.holds)} for row in rows],
        }
        for case, rows in found
    ]


def _show(console: Console, found: Results, failed: int, installation: str) -> None:
    count = sum(len(rows) for _, rows in found)
    if count:
        console.print(_comparisons(found))
        console.print(f"{failed} of {count} comparisons fail." if failed else f"All {count} comparisons hold.")
    console.print(installation, highlight=False)


def _bar(what: str, total: int, console: Console) -> AbstractContextManager[ReportProgress]:
    """Return a bar where tables go, if that is a terminal, else on the standard error."""
    from rich.console import Console

    shown = console if console.is_terminal else Console(stderr=True)
    return bar(what, total, shown.is_terminal, shown)


def _comparisons(found: Results) -> Table:
    """Return the comparisons of all cases, each under its title and source."""
    from rich import box
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("case, source, compared quantity")
    for heading in ("difference", "tolerance"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for number, (case, rows) in enumerate(found, 1):
        table.add_row(Text(f"{number}. {case.title}", style="bold"))
        table.add_row(Padding(Text(case.source, style="dim"), (0, 0, 0, 3)))
        for row in rows:
            verdict = Text("ok") if row.holds else Text("FAILED", style="bold red")
            quantity = Padding(Text(row.quantity), (0, 0, 0, 3))
            table.add_row(quantity, f"{row.difference:.1e}", f"{row.tolerance:.1e}", verdict)
    return table


def _table(title: str, rows: list[ErrorRow]) -> Table:
    """Return the rows of one case, narrow enough for any terminal."""
    from rich import box
    from rich.table import Table

    from poinsot.validation.paper import HEADINGS

    table = Table(*HEADINGS[1:], title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    for row in rows:
        _, *cells = vars(row).values()
        table.add_row(*(cell.replace(", ", "\n") for cell in cells))
    return table
