"""What is wrong with a scenario, in a sentence with the file, the line, the key and the nearest right name."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError

from poinsot.files.scenarios.registry import Group, Maker, default_of, makers
from poinsot.files.scenarios.schema import scenario_model, short
from poinsot.files.scenarios.toml_text import Path, lines_of
from poinsot.printable import message_of, nearest

__all__ = ["MISSING", "Errors", "has", "maker_at"]

MISSING = "must be there, got none."

KINDS = {
    "string_type": "be text",
    "int_type": "be a whole number",
    "bool_type": "be true or false",
    "list_type": "be a list",
    "model_type": "be a table",
    "union_tag_invalid": "name one that there is",
    "literal_error": "be {expected}",
    "greater_than_equal": "be at least {ge}",
    "less_than_equal": "be at most {le}",
    "less_than": "be less than {lt}",
}
"""What must be where pydantic finds something else; a table, where it says neither."""


class Errors:
    """Makes errors about the keys of one text, which they call by the name of its file."""

    def __init__(self, name: str, text: str) -> None:
        self._name, self._text = name, text

    def at(self, place: Path, sentence: str) -> ValueError:
        """Return a ValueError about a key; the sentence goes on after the key's name."""
        return ValueError(f"{self._where(place)}{_dotted(place)} {sentence}")

    def _where(self, place: Path) -> str:
        lines = lines_of(self._text)
        while place and place not in lines:
            place = place[:-1]
        return f"{self._name}, line {lines[place]}: " if place else f"{self._name}: "

    def told(self, error: ValidationError, data: Any) -> ValueError:
        """Return one of pydantic's errors as a sentence: of an unknown key, which explains others, or the first."""
        errors = error.errors(include_url=False)
        first = next((one for one in errors if one["type"] == "extra_forbidden"), errors[0])
        place, kind, given = _place_in(data, first["loc"]), first["type"], first["input"]
        if kind == "extra_forbidden":
            known = _keys_at(data, place[:-1])
            near = nearest(str(place[-1]), known) or (f" It can have {', '.join(known)}." if known else "")
            return self.at(place, f"must be a key that it can have, got another.{near}")
        if kind == "missing":
            return self.at((*place, str(first["loc"][-1])), MISSING)
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
        """Return an error whose sentence begins with the name of a key, or of something else."""
        return ValueError(f"{self._where(place)}{_dotted(place[:-1], '.')}{sentence}")

    def called(self, place: Path, call: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        """Call what makes a part; what it refuses is told with the place of the key that it names."""
        try:
            with np.errstate(all="ignore"):  # what is not finite then is refused
                return call(*arguments, **keywords)
        except (TypeError, ValueError, ImportError, OverflowError) as error:
            sentence = message_of(error)
            key = re.split(r"\W", sentence, maxsplit=1)[0]
            if key in keywords:
                raise self.prefixed((*place, key), sentence) from None
            inside = "" if key == place[-1] else f"in {_dotted(place)}, "
            raise ValueError(f"{self._where(place)}{inside}{sentence}") from None


def _types_at(data: Any, place: Path) -> str:
    """Return what the table at a place can name as its type."""
    return f" There is {', '.join(makers(_group_at(data, place)))}."


def has(node: Any, part: Any) -> bool:
    """Return whether a table has a key, or a list an element."""
    if isinstance(node, dict):
        return part in node
    return isinstance(node, list) and isinstance(part, int) and part < len(node)


def _place_in(data: Any, location: tuple[Any, ...]) -> Path:
    """Return the place of an error in the file: pydantic's, without the names of the types."""
    place: list[Any] = []
    for part in location:
        if has(data, part):
            data = data[part]
            place.append(part)
    return tuple(place)


def maker_at(data: Any, place: Path) -> Maker:
    """Return what makes a thing of the table at a place: of a body, a force, an orbit, a frame, or in one of them."""
    group = _group_at(data, place)
    for part in place:
        data = data[part]
    return makers(group)[data.get("type") or str(default_of(group))]


def _group_at(data: Any, place: Path) -> Group:
    """Return the group of the table at a place, by the kinds of the keys that lead to it."""
    group: Group = GROUPS[place[0]]
    for end in range(1 if place[0] == "body" else 2, len(place)):
        if isinstance(place[end], str):
            keys = maker_at(data, place[:end]).keys
            group = next(key.group for key in keys if key.name == place[end])
    return group


def _keys_at(data: Any, outer: Path) -> list[str]:
    """Return the keys that the table at a place can have."""
    if outer and outer[0] in GROUPS:
        return [key.name for key in maker_at(data, outer).keys]
    model: Any = scenario_model()
    for part in outer:
        if not isinstance(part, int):
            model = model.model_fields[part].annotation
            while not hasattr(model, "model_fields"):  # in a list or beside None
                model = next(one for one in get_args(model) if hasattr(one, "model_fields") or get_args(one))
    return list(model.model_fields)


GROUPS: dict[Any, str] = {"body": "body", "forces": "force", "orbits": "orbit", "frames": "frame"}
"""Groups of the tables of a scenario."""


def _dotted(place: Path, end: str = "") -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    return text + end if text else ""
