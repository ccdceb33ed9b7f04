"""Suggestions for names that do not exist: attributes of namespaces and objects, and keywords of calls."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from collections.abc import Callable, Iterable
from functools import partial
from importlib.util import find_spec, resolve_name
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from poinsot.habits import HABITS, TOO_MANY
from poinsot.printable import quoted, shortened

__all__ = [
    "advice_on_attribute",
    "attached",
    "holder_of",
    "nearest",
    "refuse_attribute",
    "refuse_call",
    "refuse_name",
    "suggestion",
]

PACKAGE = __name__.partition(".")[0]

IMPORT_SYSTEM = "importlib._bootstrap"
"""Module that asks for an attribute in `from package import name`."""

MAX_LISTED = 8
"""Largest number of arguments that an error message lists."""


def nearest(name: Any, known: Iterable[str]) -> str:
    """Return the suggestion of the nearest known name, or an empty string."""
    found = _nearest(str(name)[:60], list(known))
    return f" Did you mean {quoted(found)}?" if found else ""


def _nearest(name: str, known: list[str]) -> str:
    """Return the known name that differs in case, underscores, a plural or the order of words, or the closest one."""
    import difflib  # 10 ms at the start of a process

    for simplified in (_plain, _words):
        found = {simplified(each): each for each in known}.get(simplified(name))
        if found:
            return found
    return next(iter(difflib.get_close_matches(name, known, n=1)), "")


def _plain(name: str) -> str:
    return name.lower().replace("_", "").removesuffix("s")


def _words(name: str) -> str:
    return "_".join(sorted(name.lower().split("_")))


def suggestion(places: Iterable[str], name: str, known: Iterable[str]) -> str:
    """Return what to write instead of a name, or an empty string.

    Parameters
    ----------
    places : iterable of str
        Namespaces, classes or functions in whose table of habits the name is searched.
    name : str
        The name that does not exist.
    known : iterable of str
        The names that exist.
    """
    answer = next((HABITS[place][name] for place in places if name in HABITS.get(place, ())), "")
    return f" Write {answer}." if answer else nearest(name, known)


class LateText:
    """Text of the error message about an object, composed when it is read; most errors of attributes stay unread."""

    def __init__(self, holder: object, compose: Callable[[], str]) -> None:
        self.holder, self.compose = holder, compose

    def __str__(self) -> str:
        return self.compose()

    def __repr__(self) -> str:
        return repr(str(self))

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        return str, (str(self),)


def refuse_attribute(holder: object, name: str) -> NoReturn:
    """Raise the AttributeError of an object or a class without an attribute of this name.

    The error does not refer to the object, because Python would add a second suggestion.
    """
    raise AttributeError(LateText(holder, partial(_without_attribute, holder, name)), name=name, obj=None)


def _without_attribute(holder: object, name: str) -> str:
    kind = holder if isinstance(holder, type) else type(holder)
    advice = "" if name.startswith("_") else advice_on_attribute(holder, name)
    return f"{shortened(kind.__name__)} has no attribute {quoted(name)}.{advice}"


def advice_on_attribute(holder: object, name: str) -> str:
    """Return what to write instead of an attribute that an object, a class or a module lacks, or an empty string."""
    kind = holder if isinstance(holder, type) else type(holder)
    places = [holder.__name__] if isinstance(holder, ModuleType) else [cls.__name__ for cls in kind.__mro__]
    try:
        known = dir(holder)
    except Exception:  # of an object that is not complete
        known = dir(kind)
    return suggestion(places, name, [each for each in known if not each.startswith("_")])


def refuse_call(call: str, function: Callable[..., Any], arguments: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Raise a TypeError that says which arguments of a call its signature does not have, or which are missing.

    Parameters
    ----------
    call : str
        How the user writes the function: the name of a function or a class.
    function : callable
        The function; `self`, if it has one, is among the arguments.
    arguments, named : tuple and dict
        Arguments of the call. If they fit the signature, nothing is raised.
    """
    signature = inspect.signature(function)
    try:
        signature.bind(*arguments, **named)
        return
    except TypeError as error:
        reason = str(error)
    parameters = [each for each in signature.parameters.values() if each.name not in ("self", "cls")]
    if not any(each.kind is each.VAR_KEYWORD for each in parameters):
        known = [each.name for each in parameters if each.kind not in (each.POSITIONAL_ONLY, each.VAR_POSITIONAL)]
        for name in named:
            if name not in known:
                refuse_keyword(call, name, known)
    missing = re.fullmatch(r"missing a required .*argument: '(.*)'", reason)
    got = f"no {missing[1]}" if missing else reason
    advice = suggestion(_tables_of(call), TOO_MANY, ()) if reason.startswith(TOO_MANY) else ""
    raise TypeError(f"{call}() must be called as {call}({_written(parameters)}), got {got}.{advice}") from None


def refuse_keyword(call: str, name: str, known: Iterable[str]) -> NoReturn:
    """Raise the TypeError of a keyword that a function does not have."""
    known = [each for each in known if each not in ("self", "cls")]
    advice = suggestion(_tables_of(call), name, known)
    if not advice and 0 < len(known) <= MAX_LISTED:
        advice = f" The arguments are {', '.join(known)}."
    raise TypeError(f"{call}() got an unexpected keyword argument {quoted(name)}.{advice}") from None


def _tables_of(call: str) -> list[str]:
    return [f"{call}()", f"{call.rpartition('.')[2]}()"]


def _written(parameters: Iterable[inspect.Parameter]) -> str:
    """Return the arguments that a call needs, as a user writes them."""
    shown = []
    for each in parameters:
        if each.kind is each.VAR_POSITIONAL:
            shown.append(f"*{each.name}")
        elif each.kind is each.POSITIONAL_OR_KEYWORD and each.default is each.empty:
            shown.append(each.name)
        elif each.kind is each.KEYWORD_ONLY and each.default is each.empty:
            shown.append(f"{each.name}=...")
    return ", ".join(shown)


def attached(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return `__getattr__`, `__dir__` and `__all__` of a namespace, whose names are in the stub next to its file.

    The first use of a name imports its module. A name that does not exist raises an AttributeError with a suggestion.
    """
    homes = _homes(package, Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    listed = sorted(homes)

    def get_or_suggest(name: str) -> Any:
        if name in homes:
            value = _imported(homes[name], name, package)
            setattr(sys.modules[package], name, value)
            return value
        if name.startswith("_") or (name.isidentifier() and find_spec(f"{package}.{name}")):
            raise AttributeError(name)  # for a module, `from package import module` asks for the attribute first
        try:
            refuse_name(package, name, listed)
        except AttributeError as error:
            if sys._getframe(1).f_globals.get("__name__") == IMPORT_SYSTEM:  # it would drop the suggestion
                raise ImportError(str(error), name=package) from None
            raise

    return get_or_suggest, listed.copy, listed


def _homes(package: str, stub: str) -> dict[str, str]:
    """Return the module from which a stub imports each name; for modules of the package the package itself."""
    nodes = [node for node in ast.parse(stub).body if isinstance(node, ast.ImportFrom)]
    modules = [resolve_name("." * node.level + (node.module or ""), package) for node in nodes]
    return {alias.name: module for node, module in zip(nodes, modules, strict=True) for alias in node.names}


def _imported(home: str, name: str, package: str) -> Any:
    if home == package:
        return importlib.import_module(f"{package}.{name}")
    return getattr(importlib.import_module(home), name)


def refuse_name(module: str, name: str, known: Iterable[str]) -> NoReturn:
    """Raise the AttributeError of a module without this name."""
    text = LateText(sys.modules[module], partial(_without_name, module, name, known))
    raise AttributeError(text, name=name, obj=None)


def _without_name(module: str, name: str, known: Iterable[str]) -> str:
    advice = suggestion([module], name, ()) or _place_of(name) or nearest(name, known)
    return f"{module} has no attribute {quoted(name)}.{advice}"


def holder_of(error: AttributeError) -> object:
    """Return the object that lacks an attribute."""
    text = error.args[0] if error.args else None
    return text.holder if isinstance(text, LateText) else error.obj


def _place_of(name: str) -> str:
    """Return the suggestion of the namespace that has a name, in any case."""
    package = sys.modules[PACKAGE]
    stubs = sorted(Path(package.__path__[0]).glob("*/__init__.pyi"))
    spaces = [package, *(importlib.import_module(f"{PACKAGE}.{stub.parent.name}") for stub in stubs)]
    found = {each: f"{space.__name__}.{each}" for space in reversed(spaces) for each in space.__all__}
    alike = found.get(name) or next((path for each, path in found.items() if _plain(each) == _plain(name)), "")
    return f" Write {alike}." if alike else ""
