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


def inherit_parameters(cls: type, names: Iterable[str]) -> None:
    """Complete the docstring of a class with entries of its parameters from base classes, in the given order."""
    if cls.__doc__ is None:
        return
    own = parameter_entries(cls.__doc__)
    missing = [name for name in names if name not in own]
    known = {
        name: entry for base in cls.__mro__[:0:-1] for name, entry in parameter_entries(vars(base)["__doc__"]).items()
    }
    if known.keys().isdisjoint(missing):
        return
    head, heading, rest = inspect.cleandoc(cls.__doc__).partition(HEADING)
    end = found.start() if (found := SECTION.search(rest if heading else head)) else len(rest or head)
    before, after = (head, rest[end:]) if heading else (f"{head[:end]}\n\n", head[end:])
    entries = {name: own.get(name) or known.get(name) for name in dict.fromkeys([*names, *own])}
    cls.__doc__ = before + HEADING + "\n".join(filter(None, dict.fromkeys(entries.values()))) + after
