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
    """Return those that derive from a class and of which there can be objects."""
    return [cls for cls in subclasses(base) if not inspect.isabstract(cls)]


def is_own(thing: Any) -> bool:
    """Whether a class or function is the package's own."""
    return str(thing.__module__).partition(".")[0] == "poinsot"
