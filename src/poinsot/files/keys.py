"""Keys with which a file states values, and their checks: unknown keys, misplaced keys and repeated keys."""

from __future__ import annotations

import dataclasses
import difflib
import warnings
from collections.abc import Collection, Iterable
from typing import NamedTuple

from poinsot.errors import level_of_user
from poinsot.printable import quoted, shortened
from poinsot.suggestions import nearest

__all__ = ["Entry", "Keys"]

MISSPELLING_SIMILARITY = 0.85
"""Similarity, as difflib computes it, above which an unknown key is a misspelled one: one wrong letter of seven."""

USER_DEFINED = "USER_DEFINED"
"""Beginning of the keys that CCSDS messages leave to their users."""


class Entry(NamedTuple):
    """Value of a file with its key, and its place for errors."""

    key: str
    value: str
    place: str


@dataclasses.dataclass(frozen=True)
class Keys:
    """The keys of one block of a format.

    A repeated key raises an error, and so does an unknown key that resembles a key with an influence on the result. Any
    other unknown key gives a warning.

    Attributes
    ----------
    used : collection of str
        Keys with an influence on the result.
    ignored : collection of str
        Keys of the format without an influence on the result.
    elsewhere : collection of str
        Keys with an influence on the result in other blocks or versions of the format.
    repeated : collection of str
        Keys that may come several times.
    """

    used: Collection[str]
    ignored: Collection[str] = ()
    elsewhere: Collection[str] = ()
    repeated: Collection[str] = ()

    def by_key(self, entries: Iterable[Entry]) -> dict[str, Entry]:
        """Return checked entries by their keys."""
        found: dict[str, Entry] = {}
        for entry in entries:
            self.check(entry.key, entry.place)
            before = found.get(entry.key)
            if before and entry.key not in self.repeated and not entry.key.startswith(USER_DEFINED):
                raise ValueError(
                    f"{entry.place} must not repeat {shortened(entry.key)}, got {quoted(entry.value)} after "
                    f"{quoted(before.value)}. Remove one of them."
                )
            found[entry.key] = entry
        return found

    def check(self, key: str, place: str) -> None:
        """Raise an error or warn if a key is unknown."""
        if key in self.used or key in self.ignored or key in self.repeated or key.startswith(USER_DEFINED):
            return
        if key in self.elsewhere:
            raise ValueError(
                f"{place} must have a key of its block and version, got {quoted(key)}. Move it to its block, or "
                "remove it."
            )
        given, words = key[:40], sorted({*self.used, *self.elsewhere})
        for word in (given, given.upper()):
            if alike := difflib.get_close_matches(word, words, 1, MISSPELLING_SIMILARITY):
                raise ValueError(
                    f"{place} must have a key of the format, got {quoted(given)}. Did you mean {quoted(alike[0])}?"
                )
        warnings.warn(
            f"{place} should have a key of the format, got {quoted(given)}, which is ignored."
            f"{nearest(given.upper(), sorted({*words, *self.ignored, *self.repeated}))}",
            stacklevel=level_of_user(),
        )

    def in_comment(self, line: str, place: str, after_columns: bool) -> list[Entry]:
        """Return the value that a comment line "# key: value" states, if its key is, or resembles, a key of the format.

        A ValueError refuses a statement after the names of the columns, whose meaning it would change.
        """
        key, colon, value = (part.strip() for part in line[1:].partition(":"))
        if not colon or not self.resembles(key.lower()):
            return []
        if after_columns:
            raise ValueError(f"{place} must come before the names of the columns, got {quoted(line)}.")
        return [Entry(key.lower(), value, place)]

    def resembles(self, key: str) -> bool:
        """Return True if a key is used, or is the misspelling of a used key."""
        return bool(difflib.get_close_matches(key[:40], sorted(self.used), 1, MISSPELLING_SIMILARITY))
