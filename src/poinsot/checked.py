"""The kinds of the arguments of public functions, checked at the call by what their annotations say.

Numbers and arrays (`float`, `ArrayLike`) are not checked here: the functions check them by name and shape. Callable
metadata of `Annotated`, such as a `Quantity`, receives the name and the value and returns the argument of the function.
"""

from __future__ import annotations

import functools
import inspect
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import FunctionType, MethodType, SimpleNamespace, UnionType
from typing import Annotated, Any, NamedTuple, NoReturn, Protocol, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from typing_extensions import Unpack

from poinsot.printable import described, kind_of, quoted, shortened
from poinsot.suggestions import refuse_call, refuse_keyword

__all__ = ["checked", "checked_fields", "hint_of"]

MAX_NAME_BYTES = 255
"""Bytes of the name of a file, the limit of most file systems."""

Function = TypeVar("Function", bound=Callable[..., Any])
Converter = Callable[[str, Any], Any]


class KindTest(NamedTuple):
    """Test of the kind of a value, with the name of the kind in words."""

    holds: Callable[[Any], bool]
    words: str
    is_class: bool = False
    kind: type | None = None


KIND_HINTS = {"a Frame": " An orbit has one: orbit.frame."}


def checked(function: Function) -> Function:
    """Raise a TypeError if an argument of a public function is not of the kind that its annotation names."""
    parameters = inspect.signature(function).parameters.values()
    ordered = [p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    names = [p.name for p in ordered]
    needed = [p.name for p in ordered if p.default is p.empty and p.name not in ("self", "cls")]
    call = function.__qualname__.removesuffix(".__init__") if "__init__" in function.__qualname__ else function.__name__
    order = f" The order is {call}({', '.join(needed)})." if len(needed) > 1 else ""

    others = next((p.name for p in parameters if p.kind is p.VAR_KEYWORD), "")

    @functools.cache
    def rules() -> dict[str, tuple[KindTest | None, list[Converter]]]:
        hints = {p.name: hint_of(p.annotation, function.__globals__) for p in parameters}
        if get_origin(hints.get(others)) is Unpack:
            hints |= _hints_of_group(get_args(hints.pop(others))[0])
        hints |= {others: Any} if others in hints else {}
        return {name: (_rule(hint), _converters(hint)) for name, hint in hints.items()}

    def taken(name: str, value: Any) -> Any:
        rule, converters = rules().get(name) or rules().get(others) or refuse_keyword(call, name, rules())
        if rule is not None and not rule.holds(value):
            _refuse(name, value, rule, order if name in needed else "")
        for convert in converters if value is not None else ():
            value = convert(name, value)
        return value

    @functools.wraps(function)
    def checking(*arguments: Any, **named: Any) -> Any:
        known = map(taken, names, arguments)
        converted = {name: taken(name, value) for name, value in named.items()}
        try:
            return function(*known, *arguments[len(names) :], **converted)
        except TypeError:
            refuse_call(call, function, arguments, named)
            raise

    same_kind: Any = checking
    return same_kind  # type: ignore[no-any-return]


def _hints_of_group(group: Any) -> dict[str, Any]:
    """Return the type hints of a TypedDict, which holds arguments that several functions share."""
    return {name: hint_of(annotation, namespace_of(group)) for name, annotation in group.__annotations__.items()}


def checked_fields(record: Any) -> None:
    """Raise a TypeError if a field of a dataclass is not of the kind that its annotation names."""
    space = namespace_of(type(record))
    for name, annotation in type(record).__annotations__.items():
        if (rule := _rule(hint_of(annotation, space))) and not rule.holds(value := getattr(record, name)):
            _refuse(name, value, rule, "")


def namespace_of(cls: type) -> dict[str, Any]:
    """Return the names that the annotations of a class can mean: those of its module, if that is still there."""
    return getattr(sys.modules.get(cls.__module__), "__dict__", {})


def hint_of(annotation: Any, space: dict[str, Any]) -> Any:
    """Return the type hint of an annotation; names imported for type checkers alone become `Any`."""
    try:
        return get_type_hints(SimpleNamespace(__annotations__={"it": annotation}), space, include_extras=True)["it"]
    except NameError as error:
        return hint_of(annotation, space | {str(error.name): Any})


def _converters(hint: Any) -> list[Converter]:
    """Return the callable metadata of `Annotated`, which convert values."""
    extras = [extra for way in _ways(hint) if get_origin(way) is Annotated for extra in get_args(way)[1:]]
    return [extra for extra in extras if callable(extra) and getattr(extra, "converts", True)]


def _refuse(name: str, value: Any, rule: KindTest, order: str) -> NoReturn:
    words = rule.words
    if rule.is_class:
        kind = described(value)
        if isinstance(value, list | tuple) and "a list" in words:
            kind += f" of {', '.join(dict.fromkeys(map(kind_of, value[:3]))) or 'nothing'}"
        raise TypeError(f"{name} must be {words}, got {kind}.{KIND_HINTS.get(words, order)}")
    remedy = _remedy_of_encoding(value) if "a path" in words and isinstance(value, str) else ""
    raise TypeError(f"{name} must be {words}, got {_shown(value)}.{remedy}")


def _remedy_of_encoding(path: str) -> str:
    """Return the remedy for a name that the encoding of file names lacks, such as ASCII."""
    encoding = sys.getfilesystemencoding()
    try:
        path.encode(encoding, sys.getfilesystemencodeerrors())
    except UnicodeEncodeError:
        if encoding != "utf-8":
            return f" File names of this process are in {encoding}. Set PYTHONUTF8=1 in the environment for UTF-8."
    return ""


def _shown(value: Any) -> str:
    """Return the kind of an argument and, of a number, a text or a function, more than that."""
    if isinstance(value, str | bytes | float | int):
        return f"{kind_of(value)} {quoted(value)}"
    if isinstance(value, FunctionType | MethodType):
        return f"{kind_of(value)} {shortened(f'{value.__name__}{inspect.signature(value)}')}"
    return described(value)


def _ways(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def _rule(hint: Any) -> KindTest | None:
    """Return the test of the kind that an annotation names; None if the annotation has no test."""
    ways = _ways(hint)
    if Path in ways:
        ways = tuple(way for way in ways if way is not str)
    rules = [_rule_of(way) for way in ways if way is not type(None)]
    known = [rule for rule in rules if rule is not None]
    if not known or len(known) < len(rules):
        return None
    tests = [rule.holds for rule in known] + [lambda value: value is None] * (type(None) in ways)
    kinds = tuple(rule.kind for rule in known if rule.kind)
    if len(kinds) == len(tests):
        tests = [lambda value: isinstance(value, kinds)]  # in a third of the time of several tests
    words, is_class = " or ".join(rule.words for rule in known), any(rule.is_class for rule in known)
    return KindTest(tests[0] if len(tests) == 1 else lambda value: any(test(value) for test in tests), words, is_class)


def _rule_of(way: Any) -> KindTest | None:
    outer, inner = get_origin(way) or way, get_args(way)
    if outer is Annotated:
        way = inner[0]
    if outer in (Sequence, list, tuple):
        count = len(inner) if outer is tuple else None
        item = _rule(inner[0])
        several = f"a list of {count}" if count else "a list"
        return item and KindTest(
            functools.partial(_are, item.holds, count), f"{several}, each {item.words}", item.is_class
        )
    kind = get_origin(way) or way
    if isinstance(kind, type) and kind.__module__.startswith("poinsot.") and Protocol not in kind.__bases__:
        article = "an" if kind.__name__[0] in "AEIO" else "a"
        return KindTest(lambda value: isinstance(value, kind), f"{article} {kind.__name__}", True, kind)
    if outer is Callable and inner and isinstance(inner[0], list):
        return _function_of(len(inner[0]))
    return SIMPLE_KINDS.get(outer)


def _function_of(count: int) -> KindTest:
    """Return the rule of functions that can be called with so many values."""
    values = "one value" if count == 1 else f"{count} values"
    return KindTest(functools.partial(_takes, count), f"a function of {values}")


def _takes(count: int, value: Any) -> bool:
    if not callable(value):
        return False
    try:
        inspect.signature(value).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # a function of C may not say what it takes
        return True
    return True


def _are(test: Callable[[Any], bool], count: int | None, value: Any) -> bool:
    if not isinstance(value, Sequence) or isinstance(value, str | bytes):
        return False
    return len(value) == (count or len(value)) and all(map(test, value))


def _is_whole(value: Any) -> bool:
    if isinstance(value, bool | np.timedelta64):  # NumPy has durations among the integers
        return False
    return isinstance(value, int | np.integer) and abs(int(value)) < 2**63


def _is_path(value: Any) -> bool:
    """Return True if a value is a path that the system can encode as text."""
    try:
        path = os.fspath(value)
        names = os.fsencode(path).split(os.fsencode(os.sep))
        return isinstance(path, str) and all(b"\0" not in name and len(name) <= MAX_NAME_BYTES for name in names)
    except Exception:  # of other kinds, with lone surrogates, or of a class of the user's own
        return False


SIMPLE_KINDS: dict[Any, KindTest] = {
    int: KindTest(_is_whole, "a whole number of at most 63 bits"),
    bool: KindTest(lambda value: isinstance(value, bool | np.bool_), "True or False"),
    str: KindTest(lambda value: isinstance(value, str), "a text"),
    Path: KindTest(_is_path, "a path"),
    Callable: KindTest(callable, "a function"),
    Mapping: KindTest(lambda value: isinstance(value, Mapping), "a mapping"),
}
