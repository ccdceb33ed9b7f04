"""Classes that are found by what they derive from: a user's own are known like the package's."""

from __future__ import annotations

import inspect
from typing import Any

__all__ = ["concrete", "is_own", "subclasses"]


def subclasses(*bases: type) -> list[type]:
    """Return classes and all that derive from them, each once."""
    stack, found = list(bases), dict[type, None]()
    while stack:
        cls = stack.pop()
        if cls not in found:
            found[cls] = None
            stack += cls.__subclasses__()
    return list(found)


def concrete(base: type) -> list[Any]:
    """Return the concrete subclasses of a class."""
    return [cls for cls in subclasses(base) if not inspect.isabstract(cls)]


def is_own(thing: Any) -> bool:
    """Return True if a class or function belongs to the package."""
    return str(thing.__module__).partition(".")[0] == "poinsot"
