"""Summaries of results as text and as HTML tables of notebooks, small plots, and numbers in words."""

from __future__ import annotations

import html
import re
from abc import abstractmethod
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.immutable import Immutable
from poinsot.printable import printable

__all__ = ["Summarized", "curves", "formatted", "formatted_times", "markup_table", "rounded", "text_table"]

MAX_NUMBERS = 6
"""Largest number of values that a summary lists one by one; for more values it states the range."""

MAX_CHARACTERS = 240
"""Largest number of characters of a description in a title or a line."""

LONG_NUMBER = re.compile(r"-?\d*\.\d{5,}(?:[eE][+-]?\d+)?|-?\d{8,}(?:\.\d*)?")
"""Numbers with more than six digits."""


class Summarized(Immutable):
    """Base class of results with one summary, as `repr` and as a table in notebooks."""

    @abstractmethod
    def _summary(self) -> tuple[str, dict[str, str]]:
        """Return the title, and the text of each line by its name; lines without text are omitted."""

    def __repr__(self) -> str:
        title, lines = self._summary()
        rows = [title, *(f"  {name}: {text}" for name, text in lines.items() if text)]
        return printable("\n".join(rows), unescaped="\n")

    def _repr_html_(self) -> str:
        title, lines = self._summary()
        return text_table(title, lines)


def text_table(title: str, lines: Mapping[str, str]) -> str:
    """Return an HTML table of texts by name; lines without text are omitted."""
    return markup_table(title, ((html.escape(name), html.escape(text)) for name, text in lines.items() if text))


def markup_table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return an HTML table with a title, which is text, and rows of a name and a cell, which are markup."""
    cells = "".join(
        f'<tr><th style="text-align: left">{name}</th><td style="text-align: left">{cell}</td></tr>'
        for name, cell in rows
    )
    return f"<table><caption>{html.escape(title)}</caption>{cells}</table>"


WIDTH, HEIGHT, LEFT, MARGIN = 440, 130, 52, 18
"""Size of a small plot, its left margin and its other margins, pixels."""

MAX_POINTS = 300
"""Points of a curve in a small plot. Longer curves are drawn by the minimum and maximum of each of 150 intervals."""

COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Black and colours of Okabe and Ito's palette."""

ZERO_ERROR = 1e-18
"""Smallest error on a logarithmic scale."""


def curves(
    title: str, x: NDArray[np.float64], lines: Mapping[str, ArrayLike], unit: str = "1", errors: bool = False
) -> str:
    """Return a small plot as SVG.

    Parameters
    ----------
    title : str
    x : array (n,)
        Ascending or descending abscissas.
    lines : mapping
        Ordinates by name, arrays (n,).
    unit : str
        Unit of the abscissas.
    errors : bool
        True to draw the largest error up to each abscissa on a logarithmic scale.

    Returns
    -------
    str
        Empty for fewer than two abscissas, or if a line has no finite value.
    """
    columns = {name: np.asarray(values, dtype=float) for name, values in lines.items()}
    if errors:
        columns = {name: np.log10(np.fmax.accumulate(np.fmax(np.abs(y), ZERO_ERROR))) for name, y in columns.items()}
    finite = [y[np.isfinite(y)] for y in columns.values()]
    if x.size < 2 or not all(y.size for y in finite) or not finite:
        return ""
    low, high = min(np.min(y) for y in finite), max(np.max(y) for y in finite)
    bottom = HEIGHT - MARGIN
    across = LEFT + (WIDTH - LEFT - MARGIN) * (x - x[0]) / (x[-1] - x[0])
    drawn, legend = "", ""
    for number, (name, y) in enumerate(columns.items()):
        colour = COLOURS[number % len(COLOURS)]
        up = bottom - (bottom - 2 * MARGIN) * ((y - low) / (high - low) if high > low else np.full(y.size, 0.5))
        points = " ".join(f"{across[i]:.1f},{up[i]:.1f}" for i in _drawn_points(y))
        drawn += f'<polyline fill="none" stroke="{colour}" points="{points}"/>'
        legend += f'<tspan fill="{colour}"> {html.escape(name)}</tspan>'
    top, base = (f"{10**value:.1e}" if errors else f"{value:.4g}" for value in (high, low))
    first, last = (html.escape(_with_unit(f"{value:.6g}", unit)) for value in (x[0], x[-1]))
    words = [
        (LEFT, 12, "start", f"{html.escape(title)}:{legend}"),
        (LEFT - 4, 2 * MARGIN + 4, "end", top),
        (LEFT - 4, bottom + 4, "end", base),
        (LEFT, HEIGHT - 2, "start", first),
        (WIDTH - MARGIN, HEIGHT - 2, "end", last),
    ]
    texts = "".join(f'<text x="{i}" y="{j}" text-anchor="{at}">{text}</text>' for i, j, at, text in words)
    return (
        f'<svg width="{WIDTH}" height="{HEIGHT}" font-size="11" font-family="sans-serif" role="img" '
        f'style="background: white; max-width: 100%"><title>{html.escape(title)}</title>{drawn}{texts}</svg>'
    )


def _drawn_points(y: NDArray[np.float64]) -> list[int]:
    """Return the indices of the points of a curve that are drawn: all, or the extremes of each interval."""
    finite = np.flatnonzero(np.isfinite(y))
    if finite.size <= MAX_POINTS:
        return [int(i) for i in finite]
    intervals = np.array_split(finite, MAX_POINTS // 2)
    extremes = [sorted((each[np.argmin(y[each])], each[np.argmax(y[each])])) for each in intervals]
    return [int(i) for pair in extremes for i in pair]


def formatted(values: ArrayLike | None, unit: str = "1") -> str:
    """Return numbers to 6 digits with their unit: a list of up to six, the range of more; "" for none.

    Examples
    --------
    >>> from poinsot.display.html_text import formatted
    >>> formatted(1 / 3, "s"), formatted([1.0, 2.0]), formatted(range(9), "rad")
    ('0.333333 s', '[1, 2]', '9, 0 ... 8 rad')
    """
    array = np.asarray(() if values is None else values)
    if not array.size:
        return ""
    if array.size == 1:
        return _with_unit(f"{array.item():.6g}", unit)
    if array.size <= MAX_NUMBERS:
        texts = np.vectorize("{:.6g}".format, otypes=[object])(array).tolist()
        return _with_unit(str(texts).replace("'", ""), unit)
    finite = array[np.isfinite(array)]
    span = _with_unit(f"{np.min(finite):.6g} ... {np.max(finite):.6g}", unit) if finite.size else "nan"
    return f"{span}, shape {array.shape}" if array.ndim > 1 else f"{array.size}, {span}"


def formatted_times(times: NDArray[np.float64], unit: str = "1") -> str:
    """Return the number of times, and the first and the last time."""
    if not times.size:
        return "none"
    return _with_unit(f"{times.size}, {times[0]:.8g} ... {times[-1]:.8g}", unit)


def _with_unit(text: str, unit: str) -> str:
    return text if unit in ("", "1") else f"{text} {unit}"


def rounded(text: str) -> str:
    """Return a description with its numbers to 6 digits, and at most `MAX_CHARACTERS` characters of it."""
    short = LONG_NUMBER.sub(lambda number: f"{float(number.group()):.6g}", text)
    return short if len(short) <= MAX_CHARACTERS else f"{short[:MAX_CHARACTERS]} ..."
