"""The reference of the command line, from the commands themselves."""

from __future__ import annotations

import re
from typing import Any

import typer

from poinsot.cli import app

__all__ = ["page"]


def page() -> str:
    """Return the page, in MyST."""
    group: Any = typer.main.get_command(app)
    context = group.make_context("poinsot", [], resilient_parsing=True)
    commands = [group.get_command(context, name) for name in group.list_commands(context)]
    index = "\n".join(f"- [`poinsot {each.name}`](#poinsot-{each.name}): {first_sentence(each)}" for each in commands)
    head = "# Command line\n\nThe commands as `--help` describes them; [Commands](../commands.md) has what they share."
    return "\n\n".join([head, index, *(section(each, context) for each in commands)]) + "\n"


def first_sentence(command: Any) -> str:
    """Return the first paragraph of a command's help."""
    return " ".join(words(command.help).partition("\n\n")[0].split())


def words(text: str | None) -> str:
    """Return a help text with the formats of attitudes named."""
    from poinsot.cli.terminal import listed_formats

    return re.sub(r"[\b\f]", "", text or "").replace("{attitudes}", listed_formats()).strip()


def section(command: Any, context: Any) -> str:
    """Return what there is about a command."""
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [each for each in command.params if each.param_type_name == "option"]
    usage = " ".join([f"poinsot {command.name}", *command.collect_usage_pieces(context)])
    parts = [f"(poinsot-{command.name})=\n## poinsot {command.name}", f"```text\n{usage}\n```", words(command.help)]
    parts += [table("argument", [(each.name.upper(), each.help) for each in arguments])] if arguments else []
    parts += [table("option", [(", ".join(each.opts), each.help) for each in options])] if options else []
    return "\n\n".join([*parts, words(command.epilog)])


def table(heading: str, rows: list[tuple[str, str | None]]) -> str:
    """Return arguments or options with their help."""
    lines = (f"| `{name}` | {' '.join((text or '').split())} |" for name, text in rows)
    return "\n".join([f"| {heading} | |", "|---|---|", *lines])
