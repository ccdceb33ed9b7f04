"""Texts that others have written, as messages and results repeat them: printable, and in error messages short."""

from __future__ import annotations

from typing import Any

__all__ = ["described", "kind_of", "message_of", "printable", "quoted", "shortened"]

MAX_CHARACTERS = 200
"""Characters of an argument that an error message repeats."""


def printable(text: str, unescaped: str = "") -> str:
    """Return a text with escapes for letters that are not printable, except the `unescaped` ones."""
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in unescaped else letter.encode("unicode_escape").decode()
        for letter in text
    )


def quoted(value: Any) -> str:
    """Return the `repr` of an argument for an error message: at most 200 printable characters on one line.

    An argument whose `repr` raises an error, such as a list within 5000 others, is described by that error.
    """
    try:
        text = repr(_beginning(value))
    except Exception as error:
        return f"(its repr raises {kind_of(error)})"
    return shortened(" ".join(map(str.strip, text[: 2 * MAX_CHARACTERS].split("\n"))))  # rows of an array


def shortened(text: Any) -> str:
    """Return a name, a path or another text for an error message: at most 200 printable characters on one line."""
    line = printable(str(text)[: MAX_CHARACTERS + 1])
    return line if len(line) <= MAX_CHARACTERS else f"{line[: MAX_CHARACTERS - 3]}..."


def kind_of(value: Any) -> str:
    """Return the name of the class of an argument for an error message."""
    return shortened(type(value).__name__)


def described(value: Any) -> str:
    """Return the class of an argument for an error message, or the argument that is a class."""
    return f"the class {shortened(value.__name__)}" if isinstance(value, type) else kind_of(value)


def message_of(error: BaseException) -> str:
    """Return the message of an error, on one line of printable characters."""
    try:
        return printable(" ".join(str(error).split()))
    except Exception as other:  # of an error of the user's own
        return f"{kind_of(error)} (its str raises {kind_of(other)})"


def _beginning(value: Any) -> Any:
    """Return as many items of a long text or list as can be repeated; another value unchanged."""
    is_long = type(value) in (str, bytes, list, tuple) and len(value) > MAX_CHARACTERS
    return value[: MAX_CHARACTERS + 1] if is_long else value
