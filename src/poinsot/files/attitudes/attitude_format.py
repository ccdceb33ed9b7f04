"""Formats of attitude files: each is one object in the module of its reader and writer, also user-defined ones."""

from __future__ import annotations

import functools
import importlib
import pkgutil
import re
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

from poinsot.files import attitudes
from poinsot.files.attitudes.attitude_table import AttitudeTable
from poinsot.subclasses import concrete, is_own

__all__ = ["AttitudeFormat", "attitude_formats", "format_of"]


class AttitudeFormat(ABC):
    """Format of attitude files; the base class from which conversions, the command line and the documentation derive.

    A subclass defines the attributes below and the methods `read` and `write`.

    Attributes
    ----------
    title : str
        Name of the format.
    suffixes : tuple of str
        Endings of the file names, such as (".aem", ".xml").
    in_python : str
        Python expression that reads a file, with {path} in place of the file name.
    conventions : (str, str, str)
        Order of the quaternion components, direction of the quaternions, and kind of rates.
    mark : re.Pattern
        Pattern for which `sniff` searches the first bytes of a file.

    Examples
    --------
    >>> class Spaced(pt.files.AttitudeFormat):
    ...     title, suffixes, in_python = "rows", (".rows",), "np.loadtxt({path!r})"
    ...     conventions = ("scalar first", "body to space", "none")
    >>> Spaced.suffixes
    ('.rows',)
    """

    title: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]
    in_python: ClassVar[str]
    conventions: ClassVar[tuple[str, str, str]]
    mark: ClassVar[re.Pattern[bytes]]

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Return True if the first bytes of a file identify this format."""
        return cls.mark.search(head) is not None

    @staticmethod
    @abstractmethod
    def read(path: str | Path) -> AttitudeTable:
        """Return the attitudes in a file, with times counted by `calendar`."""

    @staticmethod
    @abstractmethod
    def write(motion: Any, path: str | Path, *, calendar: Any, reference_frame: str | None, overwrite: bool) -> Any:
        """Write a motion or a table to a file."""


def attitude_formats() -> tuple[AttitudeFormat, ...]:
    """Return all formats, the formats of the package last. Of two formats with one suffix the last one is selected."""
    _import_all()
    found = sorted(concrete(AttitudeFormat), key=lambda cls: (is_own(cls), cls.title))
    return tuple(cls() for cls in found)


@functools.cache
def _import_all() -> None:
    for module in pkgutil.iter_modules(attitudes.__path__):
        importlib.import_module(f"{attitudes.__name__}.{module.name}")


def format_of(path: Path) -> AttitudeFormat | None:
    """Return the format of a file by the ending of its name, or None for another ending."""
    return {suffix: each for each in attitude_formats() for suffix in each.suffixes}.get(path.suffix.lower())
