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
    """A format of attitude files; a subclass is all that conversions, the command line and the docs need.

    Attributes
    ----------
    title : str
    suffixes : tuple of str
        The ends of the names of such files, such as (".aem", ".xml").
    in_python : str
        What reads a file in Python, with {path} in the place of its name.
    conventions : (str, str, str)
        Order and direction of the quaternions, and the rates.
    mark : re.Pattern
        What the first bytes of such files have; `sniff` looks for it.

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
        """Return the attitudes in a file; `calendar` counts its times."""

    @staticmethod
    @abstractmethod
    def write(motion: Any, path: str | Path, *, calendar: Any, reference_frame: str | None, overwrite: bool) -> Any:
        """Write a motion or a table."""


def attitude_formats() -> tuple[AttitudeFormat, ...]:
    """Return all formats, the package's own last: where two have one suffix, the last one is meant."""
    _import_all()
    found = sorted(concrete(AttitudeFormat), key=lambda cls: (is_own(cls), cls.title))
    return tuple(cls() for cls in found)


@functools.cache
def _import_all() -> None:
    for module in pkgutil.iter_modules(attitudes.__path__):
        importlib.import_module(f"{attitudes.__name__}.{module.name}")


def format_of(path: Path) -> AttitudeFormat | None:
    """Return the format that the end of a name says; None if it says none."""
    return {suffix: each for each in attitude_formats() for suffix in each.suffixes}.get(path.suffix.lower())
