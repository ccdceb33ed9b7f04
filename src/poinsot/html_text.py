"""Results in a few lines, as text and in a notebook: a title, and names with what is said of each."""

from __future__ import annotations

import html
import re
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

__all__ = ["PER_TIME", "Summarized", "rounded", "told", "told_times"]

PER_TIME = "rad per unit of time"
"""The unit of rates of a result that knows no units."""

FEW = 6
"""The most numbers that are told one by one."""

LONGEST = 240
"""Characters of a description within a title or a line."""

LONG_NUMBER = re.compile(r"-?\d*\.\d{5,}(?:[eE][+-]?\d+)?|-?\d{8,}(?:\.\d*)?")


class Summarized(ABC):
    """A result whose `repr`, and the table that a notebook shows, are made of one summary."""

    @abstractmethod
    def _summary(self) -> tuple[str, dict[str, str]]:
        """Return a title, and the lines by name; one without text is left out."""

    def __repr__(self) -> str:
        title, lines = self._summary()
        return "\n".join([title, *(f"  {name}: {text}" for name, text in lines.items() if text)])

    def _repr_html_(self) -> str:
        title, lines = self._summary()
        rows = ((html.escape(name), html.escape(text)) for name, text in lines.items() if text)
        cells = "".join(f"<tr><th>{name}</th><td>{text}</td></tr>" for name, text in rows)
        return f"<table><caption>{html.escape(title)}</caption>{cells}</table>"


def told(values: Any, unit: str = "1") -> str:
    """Return a number or a few of them to 6 digits, of many the range, with the unit; "" of None and of no numbers."""
    array = np.asarray(() if values is None else values)
    if not array.size:
        return ""
    behind = "" if unit in ("", "1") else f" {unit}"
    if array.size == 1:
        return f"{array.item():.6g}{behind}"
    if array.size <= FEW:
        return str(np.vectorize("{:.6g}".format, otypes=[object])(array).tolist()).replace("'", "") + behind
    known = array[np.isfinite(array)]
    span = f"{np.min(known):.6g} ... {np.max(known):.6g}{behind}" if known.size else "nan"
    return f"{span}, shape {array.shape}" if array.ndim > 1 else f"{array.size}, {span}"


def told_times(times: Any, unit: str = "1") -> str:
    """Return how many times there are, the first and the last one."""
    if not times.size:
        return "none"
    return f"{times.size}, {times[0]:.8g} ... {times[-1]:.8g}" + ("" if unit in ("", "1") else f" {unit}")


def rounded(text: str) -> str:
    """Return a description with its numbers to 6 digits, cut where it is long."""
    short = LONG_NUMBER.sub(lambda number: f"{float(number.group()):.6g}", text)
    return short if len(short) <= LONGEST else f"{short[:LONGEST]} ..."
