"""Error messages about a scenario: the file, the line, the key, the rule, and the nearest valid name."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError

from poinsot.printable import message_of, quoted
from poinsot.scenarios.registry import Group, Maker, default_of, makers
from poinsot.scenarios.schema import scenario_model, short
from poinsot.scenarios.toml_text import Path, lines_of
from poinsot.suggestions import nearest

__all__ = ["MISSING", "Errors", "has", "maker_at"]

MISSING = "must be given, got none."

KINDS = {
    "string_type": "be text",
    "int_type": "be a whole number",
    "bool_type": "be true or false",
    "list_type": "be a list",
    "model_type": "be a table",
    "union_tag_invalid": "name a known type",
    "literal_error": "be {expected}",
    "greater_than_equal": "be at least {ge}",
    "less_than_equal": "be at most {le}",
    "less_than": "be less than {lt}",
}
"""Rules of the messages by the type of pydantic's error; any other type reads as the rule of a table."""


class Errors:
    """Errors about the keys of one TOML text, with the name of its file."""

    def __init__(self, name: str, text: str) -> None:
        self._name, self._text = name, text

    def at(self, place: Path, sentence: str) -> ValueError:
        """Return a ValueError whose message begins with the place of a key and continues with a rule."""
        return ValueError(f"{self._where(place)}{_dotted(place)} {sentence}")

    def _where(self, place: Path) -> str:
        lines = lines_of(self._text)
        while place and place not in lines:
            place = place[:-1]
        return f"{self._name}, line {lines[place]}: " if place else f"{self._name}: "

    def from_pydantic(self, error: ValidationError, data: Any) -> ValueError:
        """Return the message of pydantic's first unknown key, which explains other errors, or of its first error."""
        errors = error.errors(include_url=False)
        first = next((one for one in errors if one["type"] == "extra_forbidden"), errors[0])
        place, kind, given = _place_in(data, first["loc"]), first["type"], first["input"]
        if kind == "extra_forbidden":
            known = _keys_at(data, place[:-1])
            near = nearest(str(place[-1]), known) or (f" Known keys are {', '.join(known)}." if known else "")
            table = _dotted(place[:-1])
            inside = f" in {table if table.endswith(']') else f'[{table}]'}" if table else ""
            return ValueError(f"{self._where(place)}unknown key {quoted(place[-1])}{inside}.{near}")
        if kind == "missing":
            key = str(first["loc"][-1])
            if not place and key in ("body", "state", "times"):
                return ValueError(f"{self._where(place)}missing table [{key}].")
            return self.at((*place, key), MISSING)
        if kind == "value_error":
            named = re.sub(r"^\w+", lambda _: str(place[-1]), str(first["ctx"]["error"]))  # of a table in a key too
            return self.prefixed(place, named)
        if kind == "union_tag_not_found" and isinstance(given, dict):
            return self.at((*place, "type"), f"{MISSING}{_types_at(data, place)}")
        types = _types_at(data, place) if kind == "union_tag_invalid" else ""
        if types:
            place, given = (*place, "type"), first["ctx"]["tag"]
        context = first.get("ctx", {})
        near = nearest(given, re.findall(r"'([^']*)'", context.get("expected", context.get("expected_tags", ""))))
        near = near or types
        rule = KINDS.get(kind, KINDS["model_type"]).format(**context)
        return self.at(place, f"must {rule}, got {short(given)}.{near}")

    def prefixed(self, place: Path, sentence: str) -> ValueError:
        """Return an error whose message begins with the name of a key inside the table at a place."""
        return ValueError(f"{self._where(place)}{_dotted(place[:-1], '.')}{sentence}")

    def called(self, place: Path, call: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        """Call a constructor and add the place of the key that its error message names."""
        try:
            with np.errstate(all="ignore"):  # constructors refuse values that are not finite
                return call(*arguments, **keywords)
        except (TypeError, ValueError, ImportError, OverflowError) as error:
            sentence = message_of(error)
            key = re.split(r"\W", sentence, maxsplit=1)[0]
            if key in keywords:
                raise self.prefixed((*place, key), sentence) from None
            inside = "" if key == place[-1] else f"in {_dotted(place)}, "
            raise ValueError(f"{self._where(place)}{inside}{sentence}") from None


def _types_at(data: Any, place: Path) -> str:
    """Return the hint with the known types of the table at a place."""
    return f" Known types are {', '.join(makers(_group_at(data, place)))}."


def has(node: Any, part: Any) -> bool:
    """Return True for a key of a table or an index of a list."""
    if isinstance(node, dict):
        return part in node
    return isinstance(node, list) and isinstance(part, int) and part < len(node)


def _place_in(data: Any, location: tuple[Any, ...]) -> Path:
    """Return the place of an error in the file: pydantic's location without the names of types."""
    place: list[Any] = []
    for part in location:
        if has(data, part):
            data = data[part]
            place.append(part)
    return tuple(place)


def maker_at(data: Any, place: Path) -> Maker:
    """Return the maker of the table at a place: of a body, a force, an orbit, a frame, or a table inside one."""
    group = _group_at(data, place)
    for part in place:
        data = data[part]
    return makers(group)[data.get("type") or str(default_of(group))]


def _group_at(data: Any, place: Path) -> Group:
    """Return the group of the table at a place, from the keys that lead to it."""
    group: Group = GROUPS[place[0]]
    for end in range(1 if place[0] == "body" else 2, len(place)):
        if isinstance(place[end], str):
            keys = maker_at(data, place[:end]).keys
            group = next(key.group for key in keys if key.name == place[end])
    return group


def _keys_at(data: Any, outer: Path) -> list[str]:
    """Return the known keys of the table at a place."""
    if outer and outer[0] in GROUPS:
        return [key.name for key in maker_at(data, outer).keys]
    model: Any = scenario_model()
    for part in outer:
        if not isinstance(part, int):
            model = model.model_fields[part].annotation
            while not hasattr(model, "model_fields"):  # inside a list, or in a union with None
                model = next(one for one in get_args(model) if hasattr(one, "model_fields") or get_args(one))
    return list(model.model_fields)


GROUPS: dict[Any, str] = {
    "body": "body",
    "forces": "force",
    "frames": "frame",
    "observe": "observable",
    "orbits": "orbit",
}
"""Groups of the tables of a scenario."""


def _dotted(place: Path, end: str = "") -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    return text + end if text else ""
