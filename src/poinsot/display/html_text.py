"""Results in a few lines, as text and in a notebook: a title, and names with what is said of each."""

from __future__ import annotations

import html
import re
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from poinsot.immutable import Immutable
from poinsot.printable import printable

__all__ = ["PER_TIME", "Summarized", "curves", "markup_table", "rounded", "text_table", "told", "told_times"]

PER_TIME = "rad per unit of time"
"""The unit of rates of a result that knows no units."""

FEW = 6
"""The most numbers that are told one by one."""

LONGEST = 240
"""Characters of a description within a title or a line."""

LONG_NUMBER = re.compile(r"-?\d*\.\d{5,}(?:[eE][+-]?\d+)?|-?\d{8,}(?:\.\d*)?")


class Summarized(Immutable):
    """A result whose `repr`, and the table that a notebook shows, are made of one summary."""

    @abstractmethod
    def _summary(self) -> tuple[str, dict[str, str]]:
        """Return a title, and the lines by name; one without text is left out."""

    def __repr__(self) -> str:
        title, lines = self._summary()
        return printable("\n".join([title, *(f"  {name}: {text}" for name, text in lines.items() if text)]), kept="\n")

    def _repr_html_(self) -> str:
        title, lines = self._summary()
        return text_table(title, lines)


def text_table(title: str, lines: Mapping[str, str]) -> str:
    """Return lines by name as a table of a notebook; one without text is left out."""
    return markup_table(title, ((html.escape(name), html.escape(text)) for name, text in lines.items() if text))


def markup_table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return a table of a notebook; names and cells are markup."""
    cells = "".join(
        f'<tr><th style="text-align: left">{name}</th><td style="text-align: left">{cell}</td></tr>'
        for name, cell in rows
    )
    return f"<table><caption>{html.escape(title)}</caption>{cells}</table>"


WIDE, HIGH, LEFT, EDGE = 440, 130, 52, 18
"""Of a small plot, and the space beside and about its curves, in pixels."""

MOST_POINTS = 300
"""Of a curve of a small plot; of more the least and the largest in each of half as many spans are drawn."""

COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Black, and those of Okabe and Ito after it."""


def curves(title: str, x: Any, lines: Mapping[str, Any], unit: str = "1", errors: bool = False) -> str:
    """Return a small plot as SVG, of columns of numbers over ascending or descending ones.

    Of errors it has the largest so far, on a logarithmic scale. Without two numbers it is empty.
    """
    columns = {name: np.asarray(values, dtype=float) for name, values in lines.items()}
    if errors:
        columns = {name: np.log10(np.fmax.accumulate(np.fmax(np.abs(y), 1e-18))) for name, y in columns.items()}
    known = [y[np.isfinite(y)] for y in columns.values()]
    if x.size < 2 or not all(y.size for y in known) or not known:
        return ""
    low, high = min(np.min(y) for y in known), max(np.max(y) for y in known)
    bottom = HIGH - EDGE
    across = LEFT + (WIDE - LEFT - EDGE) * (x - x[0]) / (x[-1] - x[0])
    drawn, legend = "", ""
    for number, (name, y) in enumerate(columns.items()):
        colour = COLOURS[number % len(COLOURS)]
        places = _few(y)
        up = bottom - (bottom - 2 * EDGE) * ((y - low) / (high - low) if high > low else np.full(y.size, 0.5))
        points = " ".join(f"{across[i]:.1f},{up[i]:.1f}" for i in places)
        drawn += f'<polyline fill="none" stroke="{colour}" points="{points}"/>'
        legend += f'<tspan fill="{colour}"> {html.escape(name)}</tspan>'
    ends = [f"{10**value:.1e}" if errors else f"{value:.4g}" for value in (high, low)]
    behind = "" if unit in ("", "1") else f" {unit}"
    words = [
        (LEFT, 12, "start", f"{html.escape(title)}:{legend}"),
        (LEFT - 4, 2 * EDGE + 4, "end", ends[0]),
        (LEFT - 4, bottom + 4, "end", ends[1]),
        (LEFT, HIGH - 2, "start", html.escape(f"{x[0]:.6g}{behind}")),
        (WIDE - EDGE, HIGH - 2, "end", html.escape(f"{x[-1]:.6g}{behind}")),
    ]
    texts = "".join(f'<text x="{i}" y="{j}" text-anchor="{at}">{text}</text>' for i, j, at, text in words)
    return (
        f'<svg width="{WIDE}" height="{HIGH}" font-size="11" font-family="sans-serif" role="img" '
        f'style="background: white; max-width: 100%"><title>{html.escape(title)}</title>{drawn}{texts}</svg>'
    )


def _few(y: Any) -> list[int]:
    """Return the places of a curve that are drawn: all, or the least and the largest of each span."""
    known = np.flatnonzero(np.isfinite(y))
    if known.size <= MOST_POINTS:
        return [int(i) for i in known]
    spans = np.array_split(known, MOST_POINTS // 2)
    ends = [sorted((span[np.argmin(y[span])], span[np.argmax(y[span])])) for span in spans]
    return [int(i) for pair in ends for i in pair]


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
