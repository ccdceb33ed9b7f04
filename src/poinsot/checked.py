"""The kinds of the arguments of public functions, checked at the call by what their annotations say.

Numbers and arrays (`float`, `ArrayLike`) are not looked at here: the functions take them by name and shape.
"""

from __future__ import annotations

import functools
import inspect
import os
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

__all__ = ["checked", "checked_fields"]

Function = TypeVar("Function", bound=Callable[..., Any])
Rule = tuple[Callable[[Any], bool], str]

CLASSES = (
    *(
        "AttitudeTable",
        "Bifurcation",
        "Body",
        "Branch",
        "Calendar",
        "ChaosIndicators",
        "Frame",
        "KeplerOrbit",
        "LineSpectrum",
    ),
    *("Orbit", "PeriodicMotion", "PrecessingOrbit", "Section", "Shape", "State", "StateTransition", "System"),
    "Trajectory",
)
"""Those of the package that annotations name, known by their names: a module need not import them to be checked."""

HINTS = {"a Frame": " An orbit has one: orbit.frame."}


def checked(function: Function) -> Function:
    """Refuse arguments of another kind than the annotations of a public function say, in a sentence."""
    parameters = inspect.signature(function).parameters.values()
    rules = {p.name: rule for p in parameters if (rule := _rule(str(p.annotation)))}
    ordered = [p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    names = [p.name for p in ordered]
    needed = [p.name for p in ordered if p.default is p.empty and p.name not in ("self", "cls")]
    call = function.__qualname__.removesuffix(".__init__") if "__init__" in function.__qualname__ else function.__name__
    order = f" The order is {call}({', '.join(needed)})." if len(needed) > 1 else ""

    @functools.wraps(function)
    def checking(*arguments: Any, **named: Any) -> Any:
        for name, value in (*zip(names, arguments, strict=False), *named.items()):
            if name in rules:
                _check(name, value, rules[name], order if name in needed else "")
        return function(*arguments, **named)

    same_kind: Any = checking
    return same_kind  # type: ignore[no-any-return]


def checked_fields(record: Any) -> None:
    """Refuse fields of a dataclass of another kind than their annotations say."""
    for name, annotation in type(record).__annotations__.items():
        if rule := _rule(str(annotation)):
            _check(name, getattr(record, name), rule, "")


def _check(name: str, value: Any, rule: Rule, order: str) -> None:
    holds, words = rule
    if holds(value):
        return
    if words.partition(" ")[2].partition(" ")[0] in CLASSES:
        kind = f"the class {value.__name__}" if isinstance(value, type) else type(value).__name__
        if isinstance(value, list | tuple) and "a list" in words:
            kind += f" of {', '.join(dict.fromkeys(type(item).__name__ for item in value[:3])) or 'nothing'}"
        raise TypeError(f"{name} must be {words}, got {kind}.{HINTS.get(words, order)}")
    raise TypeError(f"{name} must be {words}, got {_shown(value)}.")


def _shown(value: Any) -> str:
    if isinstance(value, type):
        return f"the class {value.__name__}"
    said = isinstance(value, str | bytes | float) or (isinstance(value, int) and abs(value) < 2**64)
    text = f" {value!r}" if said else ""
    return f"{type(value).__name__}{text if len(text) <= 40 else ''}"


@functools.cache
def _rule(annotation: str) -> Rule | None:
    """Return whether a value is of the kind of an annotation, and what that is in words; None if it is not known."""
    ways = re.split(r" \| (?![^\[]*\])", annotation.strip("'\""))
    rules = [rule for way in ways if way != "None" and (rule := _rule_of(way))]
    if not rules or len(rules) < len([way for way in ways if way != "None"]):
        return None
    tests, words = [rule[0] for rule in rules], " or ".join(rule[1] for rule in rules)
    if "Path" in ways:
        tests, words = [_is_path], "a path"
    if "None" in ways:
        tests.append(lambda value: value is None)
    return lambda value: any(test(value) for test in tests), words


def _rule_of(way: str) -> Rule | None:
    if way in CLASSES:
        return functools.partial(_is_a, way), f"{'an' if way[0] in 'AEIO' else 'a'} {way}"
    outer, _, inner = way.partition("[")
    if outer in ("Sequence", "list", "tuple"):
        count = inner.count(",") + 1 if outer == "tuple" else None
        item = _rule(inner.removesuffix("]").partition(",")[0])
        several = f"a list of {count}" if count else "a list"
        return item and (functools.partial(_are, item[0], count), f"{several}, each {item[1]}")
    return SIMPLE.get(outer)


def _is_a(name: str, value: Any) -> bool:
    return any(kind.__name__ == name and kind.__module__.startswith("poinsot.") for kind in type(value).__mro__)


def _are(test: Callable[[Any], bool], count: int | None, value: Any) -> bool:
    if not isinstance(value, Sequence) or isinstance(value, str | bytes):
        return False
    return len(value) == (count or len(value)) and all(map(test, value))


def _is_whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and abs(int(value)) < 2**63


def _is_path(value: Any) -> bool:
    return isinstance(value, str | os.PathLike) and "\0" not in str(value)


SIMPLE: dict[str, Rule] = {
    "int": (_is_whole, "a whole number of at most 63 bits"),
    "bool": (lambda value: isinstance(value, bool | np.bool_), "True or False"),
    "str": (lambda value: isinstance(value, str), "a text"),
    "Path": (_is_path, "a path"),
    "Callable": (callable, "a function"),
    "Mapping": (lambda value: isinstance(value, Mapping), "a mapping"),
}
