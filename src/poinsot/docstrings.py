"""Parameters in numpydoc docstrings: their entries, and the entries that classes and constructors inherit."""

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
    """Complete the docstrings of a class and its constructors with entries of parameters that are documented above.

    The class lacks entries that a base class has. A class method lacks entries of parameters with the names of fields.
    """
    if cls.__doc__ is None:
        return
    known = {
        name: entry for base in cls.__mro__[:0:-1] for name, entry in parameter_entries(vars(base)["__doc__"]).items()
    }
    cls.__doc__ = _completed(cls.__doc__, names, known)
    methods = [each.__func__ for name, each in vars(cls).items() if isinstance(each, classmethod) and name[0] != "_"]
    if methods:
        attributes = parameter_entries(cls.__doc__.replace("Attributes\n", "Parameters\n"))
        known |= {**parameter_entries(cls.__doc__), **attributes}
    for method in methods:
        code = inspect.unwrap(method).__code__
        arguments = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
        method.__doc__ = _completed(method.__doc__ or "", arguments, known)


def _completed(docstring: str, names: Iterable[str], known: Mapping[str, str]) -> str:
    """Return a docstring with known entries of the parameters that it lacks, in the order of the names."""
    own = parameter_entries(docstring)
    if not any(name in known and name not in own for name in names):
        return docstring
    head, heading, rest = inspect.cleandoc(docstring).partition(HEADING)
    end = found.start() if (found := SECTION.search(rest if heading else head)) else len(rest or head)
    before, after = (head, rest[end:]) if heading else (f"{head[:end]}\n\n", head[end:])
    entries = {name: own.get(name) or known.get(name) for name in dict.fromkeys([*names, *own])}
    return before + HEADING + "\n".join(filter(None, dict.fromkeys(entries.values()))) + after
