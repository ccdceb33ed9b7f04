"""Untrusted TOML: bounded before it is parsed, and the line of every key."""

from __future__ import annotations

import re
import tomllib
from typing import Any

__all__ = ["MAX_CHARACTERS", "MAX_KEYS", "MAX_NUMBERS", "Path", "lines_of", "parsed_toml"]

MAX_CHARACTERS = 1_000_000
"""Limits of a scenario, which takes a second to read."""

MAX_NUMBERS = 20_000
MAX_KEYS = 5_000
MAX_PARTS = 8

_KEY = r"(?:(?<![\w-])[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')"
_LONG_KEY = re.compile(rf"(?:{_KEY}\s*+\.\s*+){{{MAX_PARTS}}}")

_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}'
    r'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\''
    r"|\#[^\n]*|\n|[\[\]{}=,.]|[^\s\[\]{}=,.\#\"']+",
    re.DOTALL,
)

Path = tuple[str | int, ...]
"""Path of a key, such as ("forces", 0, "orbit")."""


def parsed_toml(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a text; refuse one that is no TOML, or too long or too deep to be read in a second."""
    counted = {"characters": (len(text), MAX_CHARACTERS), "numbers in lists": (text.count(","), MAX_NUMBERS)}
    counted["keys and tables"] = (text.count("=") + text.count("[") - text.count(","), MAX_KEYS)
    for what, (count, most) in counted.items():
        if count > most:
            raise ValueError(f"{name} must have at most {most} {what}, got {count}.")
    if _LONG_KEY.search(text):
        raise ValueError(f"{name} must have keys of at most {MAX_PARTS} parts, got a longer one.")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"{name} must have lists at most some hundred deep, got deeper ones.") from None
    except ValueError as error:
        raise ValueError(_message(str(error), text, name)) from None


def _message(error: str, text: str, name: str) -> str:
    """Return the message of an error of the parser, with its line."""
    found = re.fullmatch(r"(.*?) \(at line (\d+), column \d+\)", error)
    if found is None:
        return f"{name} must be TOML, got {error}."
    what, line = found[1], int(found[2])
    place = f"{name}, line {line}: "
    key = text.split("\n")[line - 1].partition("=")[0].strip()[:60]
    if what == "Cannot overwrite a value" and key:
        return f"{place}{key} must be given once, got it twice."
    twice = re.fullmatch(r"Cannot declare \((.*)\) twice", what)
    if twice:
        table = ".".join(part.strip("' ") for part in twice[1].rstrip(",").split(","))
        return f"{place}{table} must be one table, got [{table}] again."
    return f"{place}the text must be TOML, got {what}."


def lines_of(text: str) -> dict[Path, int]:
    """Return the line of each key and table of a text that is TOML, by its path: ("forces", 0, "orbit") -> 12."""
    lines, line = _Lines(), 1
    for word in _TOKEN.findall(text + "\n"):
        if not word.startswith("#"):
            lines.take(word, line)
        line += word.count("\n")
    return lines.found


class _Lines:
    """Reader of the words of a text, which records the line of each key."""

    def __init__(self) -> None:
        self.found: dict[Path, int] = {}
        self._table: Path = ()
        self._counts: dict[Path, int] = {}
        self._key: list[str] = []  # before = or in a heading
        self._value: Path | None = None  # after =
        self._open: list[tuple[Path, bool]] = []  # inline tables and lists, and which are lists
        self._heading = 0  # brackets

    def take(self, word: str, line: int) -> None:
        is_list = bool(self._open) and self._open[-1][1]
        if self._heading or (word == "[" and not self._open and self._value is None):
            self._take_heading(word, line)
        elif word in ("[", "{"):
            path = self._value or ()
            if is_list:
                path = (*self._open[-1][0], self._counts[self._open[-1][0]])
            self.found.setdefault(path, line)
            self._open.append((path, word == "["))
            self._counts[path] = 0
            self._value = None
        elif word in ("]", "}"):
            self._counts.pop(self._open.pop()[0])
        elif is_list:
            self._counts[self._open[-1][0]] += word == ","
        else:
            self._take_pair(word, line)

    def _take_heading(self, word: str, line: int) -> None:
        if word == "[":
            self._heading += 1
        elif word == "\n":
            path: Path = ()
            for i, part in enumerate(self._key):
                path = (*path, part)
                if i == len(self._key) - 1 and self._heading == 2:
                    self._counts[path] = self._counts.get(path, -1) + 1
                    self.found.setdefault(path, line)
                path = (*path, self._counts[path]) if path in self._counts else path
            self.found.setdefault(path, line)
            self._table, self._key, self._heading = path, [], 0
        elif word not in ("]", "."):
            self._key.append(_bare(word))

    def _take_pair(self, word: str, line: int) -> None:
        if word == "=":
            path = self._open[-1][0] if self._open else self._table
            for part in self._key:
                path = (*path, part)
                self.found.setdefault(path, line)
            self._value, self._key = path, []
        elif word in (",", "\n"):
            self._key, self._value = [], None
        elif self._value is None and word != ".":
            self._key.append(_bare(word))


def _bare(word: str) -> str:
    return word[1:-1] if word[0] in "\"'" else word
