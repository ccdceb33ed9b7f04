"""What the package ships of a kind, so that the laws of a kind leave nothing out."""

import importlib
import inspect
import pkgutil

import poinsot


def concrete_subclasses(*kinds):
    """All classes of the package that are not abstract and derive from one of the kinds."""
    for module in pkgutil.walk_packages(poinsot.__path__, "poinsot."):
        if not module.name.startswith(("poinsot.cli", "poinsot.plot", "poinsot.files")):
            importlib.import_module(module.name)
    found, left = set(), list(kinds)
    while left:
        left += (kind := left.pop()).__subclasses__()
        if kind.__module__.startswith("poinsot.") and not inspect.isabstract(kind):
            found.add(kind)
    return found - set(kinds)
