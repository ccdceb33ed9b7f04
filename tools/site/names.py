"""The public names of the package, and what pages call them."""

from __future__ import annotations

import importlib
import inspect

__all__ = ["NAMESPACES", "canonical_names", "linked_names", "public"]

NAMESPACES = (
    "analysis",
    "control",
    "events",
    "files",
    "forces",
    "mechanics",
    "observables",
    "orbits",
    "parts",
    "plot",
    "shapes",
)


def public() -> dict[str, object]:
    """Return the public objects by their shortest full name: `poinsot.System`, `poinsot.forces.IGRF`."""
    found: dict[str, object] = {}
    for space in ("", *NAMESPACES):
        path = f"poinsot.{space}".rstrip(".")
        package = importlib.import_module(path)
        for name in package.__all__:
            thing = getattr(package, name)
            if not inspect.ismodule(thing) and not any(thing is other for other in found.values()):
                found[f"{path}.{name}"] = thing
    return found


def canonical_names() -> dict[str, str]:
    """Return the shortest full name of each full name: also of those that a namespace shares, and of the modules'."""
    found = {name: name for name in public()}
    for name, thing in public().items():
        module = getattr(thing, "__module__", "")
        if module.startswith("poinsot"):
            found[f"{module}.{getattr(thing, '__qualname__', '')}"] = name
        for space in NAMESPACES:
            last = name.rpartition(".")[2]
            if getattr(importlib.import_module(f"poinsot.{space}"), last, None) is thing:
                found[f"poinsot.{space}.{last}"] = name
    return found


def linked_names() -> dict[str, str]:
    """Return the full name of what code in a text stands for: `System`, `pt.System`, `plot.spectrum`, `forces.IGRF`.

    A bare name counts if no other namespace has it, but for those of `plot`, which are words, and `view`, a command.
    """
    canonical = canonical_names()
    found: dict[str, str] = {}
    for name, target in canonical.items():
        inside = name.removeprefix("poinsot.")
        found |= {name: target, f"pt.{inside}": target} | ({inside: target} if "." in inside else {})
    lasts = [name.rpartition(".")[2] for name in public()]
    for name in public():
        space, _, last = name.rpartition(".")
        if lasts.count(last) == 1 and space != "poinsot.plot" and last != "view":
            found[last] = name
    return found
