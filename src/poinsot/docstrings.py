"""Parameters in numpydoc docstrings: their entries, and the entries that a class inherits."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Iterable, Mapping

__all__ = ["inherit_parameters", "parameter_entries"]

HEADING = "Parameters\n----------\n"

SECTION = re.compile(r"\n\n[A-Z]\w+\n---")
"""Begin of the next section of a docstring."""


@functools.cache
def parameter_entries(docstring: str | None) -> Mapping[str, str]:
    """Return the entry of each parameter in a docstring, by name. Parameters in one heading share the entry."""
    section = SECTION.split(inspect.cleandoc(docstring or "").partition(HEADING)[2])[0].strip()
    entries = re.split(r"\n(?=\S)", section) if section else []
    return {name.strip("* "): entry for entry in entries for name in entry.partition(" : ")[0].split(",")}


def inherit_parameters(cls: type, inherited: Iterable[str]) -> None:
    """Complete the docstring of a class with the entries of inherited parameters from its base classes."""
    if not (inherited := set(inherited)) or cls.__doc__ is None:
        return
    missing = inherited - parameter_entries(cls.__doc__).keys()
    known = {
        name: entry
        for base in cls.__mro__[:0:-1]
        for name, entry in parameter_entries(vars(base)["__doc__"]).items()
        if name in missing
    }
    if not known:
        return
    head, heading, rest = inspect.cleandoc(cls.__doc__).partition(HEADING)
    if not heading:
        head, rest = "", head
    end = found.start() if (found := SECTION.search(rest)) else len(rest)
    before = rest[:end] if heading else f"{rest[:end]}\n\n{HEADING}".removesuffix("\n")
    cls.__doc__ = "\n".join([head + heading + before, *dict.fromkeys(known.values())]) + rest[end:]
