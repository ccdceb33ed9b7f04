"""The commands and their help texts."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from poinsot.cli.checks import paper, verify
from poinsot.cli.formats import convert, info
from poinsot.cli.plots import animate, plot, view
from poinsot.cli.runs import new, run
from poinsot.cli.terminal import DIFFERS, STOPPED, Command, Commands, Group, answer, exit_statuses

__all__ = ["app"]

app = Commands(
    cls=Group,
    epilog=exit_statuses(
        {
            DIFFERS: "a comparison of `verify` fails, or a repeated result differs from the original",
            STOPPED: "the propagation of a body or a member stopped before its last time",
        }
    ),
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        from poinsot import __version__

        answer(f"poinsot {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[  # noqa: ARG001 - its callback shows it
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Simulate the rotation of rigid bodies near machine precision.

    Start with:

    - `poinsot new top.toml` writes an example scenario with a comment on every line
    - `poinsot run top.toml` propagates it and writes the result top.nc
    - `poinsot info top.nc`, `poinsot plot top.nc` and `poinsot view top.nc` show the result
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


OWN = {
    run: {
        DIFFERS: "a repeated result differs from the original",
        STOPPED: "the propagation of a body or a member stopped before its last time",
    },
    verify: {DIFFERS: "a comparison fails"},
}
for panel, commands in {
    "Scenarios and results": (new, run, info, plot, view, animate, convert),
    "Verification": (verify, paper),
}.items():
    for command in commands:
        app.command(cls=Command, epilog=exit_statuses(OWN.get(command, {})), rich_help_panel=panel)(command)
