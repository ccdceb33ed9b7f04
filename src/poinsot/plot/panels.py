"""The axes of a plot: those of the user, or of a new figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.mechanics.parameters import described

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["named_above", "one_panel", "panels"]

PAD = 28
"""Points between axes and their title: room for a legend."""


def one_panel(ax: Axes | None, size: tuple[float, float], title: str = "") -> Axes:
    """Return the axes to draw in, those given or those of a new figure."""
    if ax is not None:
        _check(ax, "ax must be an Axes of matplotlib")
    panel: Axes = panels(None if ax is None else [ax], 1, size, title)[0]
    return panel


def panels(given: Any, count: int, size: tuple[float, float], title: str = "") -> NDArray[Any]:
    """Return axes side by side, those given or those of a new figure; shape (count,)."""
    if given is None:
        import matplotlib.pyplot as plt

        from poinsot.plot.figure import TextFigure

        options: Any = {"figsize": size, "layout": "constrained", "squeeze": False, "FigureClass": TextFigure}
        figure, axes = plt.subplots(1, count, **options)
        if title:
            figure.suptitle(title)
        return np.asarray(axes[0])
    wanted = f"axes must be {count} Axes of matplotlib"
    found = list(np.ravel(given)) if isinstance(given, np.ndarray) else given
    if not isinstance(found, Sequence) or len(found) != count:
        raise TypeError(f"{wanted}, got {described(given)}.")
    for each in found:
        _check(each, wanted)
    named_above(found[0], title)
    drawn = np.empty(count, dtype=object)
    drawn[:] = found
    return drawn


def named_above(panel: Axes, title: str) -> None:
    """Write a title above axes and their legend."""
    if title:
        panel.set_title(title, pad=PAD)


def _check(ax: Any, wanted: str) -> None:
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise TypeError(f"{wanted}, got {described(ax)}.")
