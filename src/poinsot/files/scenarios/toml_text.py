"""TOML that strangers wrote: bounded before it is parsed, and the line of every key."""

from __future__ import annotations

import re
import tomllib
from typing import Any

__all__ = ["MOST_CHARACTERS", "MOST_KEYS", "MOST_NUMBERS", "Path", "lines_of", "parsed_toml"]

MOST_CHARACTERS = 1_000_000
"""Of a scenario: what is read in a second."""

MOST_NUMBERS = 20_000
MOST_KEYS = 5_000
MOST_PARTS = 8

_KEY = r"(?:(?<![\w-])[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')"
_LONG_KEY = re.compile(rf"(?:{_KEY}\s*+\.\s*+){{{MOST_PARTS}}}")

_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}'
    r'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\''
    r"|\#[^\n]*|\n|[\[\]{}=,.]|[^\s\[\]{}=,.\#\"']+",
    re.DOTALL,
)

Path = tuple[str | int, ...]
"""Of a key: ("forces", 0, "orbit")."""


def parsed_toml(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a text.

    Raises
    ------
    ValueError
        If it is too long or too deep to be read in a second, or no TOML.
    """
    counted = {"characters": (len(text), MOST_CHARACTERS), "numbers in lists": (text.count(","), MOST_NUMBERS)}
    counted["keys and tables"] = (text.count("=") + text.count("[") - text.count(","), MOST_KEYS)
    for what, (count, most) in counted.items():
        if count > most:
            raise ValueError(f"{name} must have at most {most} {what}, got {count}.")
    if _LONG_KEY.search(text):
        raise ValueError(f"{name} must have keys of at most {MOST_PARTS} parts, got a longer one.")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"{name} must have lists at most some hundred deep, got deeper ones.") from None
    except ValueError as error:
        raise ValueError(_told(str(error), text, name)) from None


def _told(error: str, text: str, name: str) -> str:
    """Return what is wrong as a sentence with its line."""
    found = re.fullmatch(r"(.*?) \(at line (\d+), column \d+\)", error)
    if found is None:
        return f"{name} must be TOML, got {error}."
    what, line = found[1], int(found[2])
    place = f"{name}, line {line}: "
    key = text.split("\n")[line - 1].partition("=")[0].strip()[:60]
    if what == "Cannot overwrite a value" and key:
        return f"{place}{key} must be there once, got it again."
    twice = re.fullmatch(r"Cannot declare \((.*)\) twice", what)
    if twice:
        table = ".".join(part.strip("' ") for part in twice[1].rstrip(",").split(","))
        return f"{place}{table} must be one table, got [{table}] again."
    return f"{place}the text must be TOML, got {what}."


def lines_of(text: str) -> dict[Path, int]:
    """Return the line of each key and table of a text that is TOML, by its path: ("forces", 0, "orbit") -> 12."""
    return _Lines(text).found


class _Lines:
    """Walks over the words, and notes the line of each key."""

    def __init__(self, text: str) -> None:
        self.found: dict[Path, int] = {}
        self._words: list[tuple[str, int]] = []
        line = 1
        for word in _TOKEN.findall(text):
            if not word.startswith("#"):
                self._words.append((word, line))
            line += word.count("\n")
        self._at = 0
        self._table: Path = ()
        self._counts: dict[Path, int] = {}
        while self._at < len(self._words):
            self._statement()

    def _peek(self) -> str:
        return self._words[self._at][0] if self._at < len(self._words) else "\n"

    def _take(self) -> str:
        word = self._peek()
        self._at += 1
        return word

    def _statement(self) -> None:
        word = self._peek()
        if word == "\n":
            self._take()
        elif word == "[":
            self._header()
        else:
            self._pair(self._table)

    def _header(self) -> None:
        line = self._words[self._at][1]
        self._take()
        several = self._peek() == "["
        if several:
            self._take()
        *outer, last = self._key("]")
        path = self._resolved((), outer)
        self._take()
        if several:
            self._take()
            self._counts[*path, last] = self._counts.get((*path, last), -1) + 1
            self.found.setdefault((*path, last), line)
        self._table = self._resolved(path, [last])
        self.found.setdefault(self._table, line)

    def _resolved(self, path: Path, parts: list[str]) -> Path:
        for part in parts:
            path = (*path, part)
            if path in self._counts:
                path = (*path, self._counts[path])
        return path

    def _key(self, end: str) -> list[str]:
        parts: list[str] = []
        while self._peek() not in (end, "\n"):
            word = self._take()
            if word != ".":
                parts.append(word[1:-1] if word[0] in "\"'" else word)
        return parts or [""]

    def _pair(self, table: Path) -> None:
        line = self._words[self._at][1]
        path = table
        for part in self._key("="):
            path = (*path, part)
            self.found.setdefault(path, line)
        self._take()
        self._value(path)

    def _value(self, path: Path) -> None:
        word = self._peek()
        if word == "{":
            self._inline(path)
        elif word == "[":
            self._list(path)
        else:
            while self._peek() not in (",", "]", "}", "\n"):
                self._take()

    def _inline(self, path: Path) -> None:
        self._take()
        while self._peek() != "}" and self._at < len(self._words):
            if self._peek() in (",", "\n"):
                self._take()
            else:
                self._pair(path)
        self._take()

    def _list(self, path: Path) -> None:
        self._take()
        index = 0
        while self._peek() != "]" and self._at < len(self._words):
            word = self._peek()
            if word in (",", "\n"):
                index += word == ","
                self._take()
            else:
                if word in ("{", "["):
                    self.found.setdefault((*path, index), self._words[self._at][1])
                self._value((*path, index))
        self._take()
