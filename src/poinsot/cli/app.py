"""The commands and their help texts."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Annotated

import typer

from poinsot.cli.checks import paper, verify
from poinsot.cli.formats import convert, info
from poinsot.cli.observations import observe
from poinsot.cli.plots import animate, plot, view
from poinsot.cli.runs import new, run
from poinsot.cli.terminal import DIFFERS, IMPORT, STOPPED, Command, Commands, Group, answer, exit_statuses
from poinsot.printable import message_of, quoted

__all__ = ["app"]

app = Commands(
    cls=Group,
    epilog=exit_statuses(
        {
            DIFFERS: "`verify` found a difference above its tolerance, or a repeated result differs from the original",
            STOPPED: "a propagation stopped before its last output time",
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


def _import(names: list[str]) -> None:
    """Import the modules of the user by name or by path, also from the current folder, as `python -m` does."""
    for name in names:
        path = Path(name)
        folder = "" if path.parent == Path() else str(path.parent)
        if folder not in sys.path:
            sys.path.insert(0, folder)
        try:
            importlib.import_module(path.name.removesuffix(".py"))
        except (ImportError, ValueError, SyntaxError) as error:
            raise ValueError(f"{IMPORT} must name a module, got {quoted(name)}: {message_of(error)}.") from None


@app.callback()
def main(
    version: Annotated[  # noqa: ARG001 - its callback shows it
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    modules: Annotated[
        list[str],
        typer.Option(
            IMPORT,
            metavar="MODULE",
            help="Module or .py file with forces, parts, orbits or file formats of your own, imported before the "
            "command.",
        ),
    ] = [],  # noqa: B006 - typer copies it
) -> None:
    """Simulate the rotation of rigid bodies, near machine precision.

    A first simulation:

    - `poinsot new satellite.toml` writes an example scenario with a comment on every line
    - `poinsot run satellite.toml` propagates the scenario and writes the result, satellite.nc
    - `poinsot info satellite.nc` summarises the result
    - `poinsot plot satellite.nc` plots the result
    - `poinsot view satellite.nc` writes an interactive 3D view of the result
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    _import(modules)


OWN = {
    run: {
        DIFFERS: "the repeated result differs from the original",
        STOPPED: "the propagation, or the propagation of an ensemble member, stopped before its last output time",
    },
    observe: {
        STOPPED: "the propagation, or the propagation of an ensemble member, stopped before its last output time"
    },
    verify: {DIFFERS: "a difference exceeds its tolerance"},
}
for panel, commands in {
    "Scenarios and results": (new, run, observe, info, plot, view, animate, convert),
    "Verification": (verify, paper),
}.items():
    for command in commands:
        app.command(cls=Command, epilog=exit_statuses(OWN.get(command, {})), rich_help_panel=panel)(command)
