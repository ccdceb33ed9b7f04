"""Options of plots, axes of the user or of a new figure, and legends."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypedDict, get_args

import numpy as np
from numpy.typing import NDArray

from poinsot.checked import Function, checked, hint_of
from poinsot.errors import array_of
from poinsot.printable import described

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d import Axes3D
else:  # matplotlib is imported when a plot is drawn
    Axes = Axes3D = Any

__all__ = ["PLAIN", "Axes", "Axes3D", "Pair", "PanelOptions", "count_degrees", "dress", "one_panel", "panels", "plot"]

Pair = Any
"""Two axes of matplotlib, as a sequence or an array, or None."""

OPTIONS = {
    "ax": "ax : matplotlib Axes, optional\n    Panel to draw in. Default: a new figure.",
    "axes": "axes : pair of matplotlib Axes, optional\n    Panels to draw in. Default: a new figure.",
    "angle_unit": 'angle_unit : {"deg", "rad", "mrad", "arcmin", "arcsec", "rev"}, optional\n'
    "    Unit of angles. Default: deg, or arcsec if all angles are below 0.1 deg.",
    "rate_unit": "rate_unit : str, optional\n"
    '    Unit of angular velocities, such as "deg/s", "mrad/h" or "rpm"; an angle alone means per unit of time.\n'
    "    Default: a unit that suits the largest value, or radians if the system does not name its unit of time.",
    "time_unit": 'time_unit : {"s", "min", "h", "d", "yr", "date"}, optional\n'
    "    Unit of times. Default: dates if the motion includes a calendar, otherwise a unit that suits the span.",
    "length_unit": "length_unit : str, optional\n"
    '    Unit of lengths, such as "km", "au" or "mm". Default: the unit of the system.',
    "momentum_unit": "momentum_unit : str, optional\n"
    '    Unit of angular momenta, such as "mN m s" or "kg km2 d-1". Default: the unit of the system.',
    "torque_unit": "torque_unit : str, optional\n"
    '    Unit of torques, such as "uN m" or "kg km2 d-2". Default: the unit of the system.',
    "window": "window : pair of times or dates, optional\n    First and last time of the plot. Default: all times.",
    "separate": "separate : bool\n"
    "    True to draw each curve in a separate part of the panel, one of its `child_axes`.",
    "title": "title : str, optional\n    Title above the plot.",
}
"""Descriptions of the options that several plots share."""
DEFAULTS = {"separate": False, "title": ""}
"""Defaults of options in groups; None for all others."""
RETURNS = {
    "ax": "matplotlib Axes\n    The panel; `ax.figure` is its figure, for `savefig`.",
    "axes": "array (2,) of matplotlib Axes\n    Left and right panel; `axes[0].figure` is their figure, for `savefig`.",
}
"""Results of plots in one panel and in two panels."""

TITLE_PAD = 28
"""Space between axes and their title for a legend, points."""
PLAIN = (-4, 5)
"""Powers of ten between which numbers on the axes are written without one."""
POWER_HEIGHT = 0.05
"""Height of the power of ten above a panel, as fraction of the height of the panel."""
RIGHT_ANGLE, TICKS = 90.0, 5
"""Right angle in degrees, and number of ticks per inch."""
MARKUP = re.compile(r"\\[a-z]+|[${}_^]")
SAMPLE, CHARACTER = 0.4, 0.06
"""Widths in a legend, inches: the sample of a line, and a letter."""


class PanelOptions(TypedDict, total=False):
    """Options of plots in one panel."""

    ax: Axes | None
    title: str


def plot(function: Function) -> Function:
    """Check the arguments of a public plot, and complete its docstring and its signature.

    The docstring lists the shared options at `{options}`, and the panels as the result if it has no section `Returns`.
    The signature names each option of the group `**options: Unpack[...]`.
    """
    checking: Any = checked(function)
    signature = _expanded(function)
    options = [OPTIONS[name] for name in signature.parameters if name in OPTIONS]
    if "3D" in str(signature.return_annotation):
        options = [option.replace("Panel to draw in.", "3D panel to draw in.") for option in options]
    text = inspect.cleandoc(function.__doc__ or "")
    if "\nReturns\n" not in text:
        options.append("\nReturns\n-------\n" + RETURNS["axes" if "axes" in signature.parameters else "ax"])
    checking.__doc__ = text.replace("{options}", "\n".join(options))
    checking.__signature__ = signature
    return checking  # type: ignore[no-any-return]


def _expanded(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a plot with its shared options, also of its group, in the order of `OPTIONS`."""
    signature = inspect.signature(function)
    found = dict(signature.parameters)
    if (last := [*found.values()][-1]).kind is last.VAR_KEYWORD:
        [group] = get_args(hint_of(found.pop(last.name).annotation, function.__globals__))
        for name, hint in group.__annotations__.items():
            default, annotation = DEFAULTS.get(name), hint.__forward_arg__
            found[name] = inspect.Parameter(name, last.KEYWORD_ONLY, default=default, annotation=annotation)
    shared = [found.pop(name) for name in OPTIONS if name in found]
    return signature.replace(parameters=[*found.values(), *shared])


def one_panel(size: tuple[float, float], ax: Axes | None = None, title: str = "") -> Axes:
    """Return the given axes, or the axes of a new figure."""
    panel: Axes = panels(ax, 1, size, title)[0]
    return panel


def panels(given: Any, count: int, size: tuple[float, float], title: str = "") -> NDArray[Any]:
    """Return the given axes, or axes side by side in a new figure; shape (count,)."""
    if given is None:
        import matplotlib.pyplot as plt

        from poinsot.plot.figure import TextFigure

        options: Any = {"figsize": size, "layout": "constrained", "squeeze": False, "FigureClass": TextFigure}
        figure, axes = plt.subplots(1, count, **options)
        if title:
            figure.suptitle(title)
        return np.asarray(axes[0])
    from matplotlib.axes import Axes

    found = (
        [given]
        if count == 1
        else list(array_of("axes", given).flat)
        if isinstance(given, Sequence | np.ndarray)
        else []
    )
    if len(found) != count or not all(isinstance(each, Axes) for each in found):
        wanted = "ax must be an Axes" if count == 1 else f"axes must be {count} Axes"
        raise TypeError(f"{wanted} of matplotlib, got {described(given)}.")
    if title:
        found[0].set_title(title, pad=TITLE_PAD)
    drawn = np.empty(count, dtype=object)
    drawn[:] = found
    return drawn


def count_degrees(axis: Any, label: str) -> None:
    """Put ticks at fractions of a right angle on an axis in degrees that is longer than a right angle."""
    from matplotlib.ticker import MaxNLocator

    if label.endswith("[deg]") and np.ptp(axis.get_view_interval()) > RIGHT_ANGLE:
        figure, box = axis.axes.get_figure(root=True), axis.axes.bbox
        inches = (box.height if axis.axis_name == "y" else box.width) / figure.dpi
        axis.set_major_locator(MaxNLocator(min(math.ceil(TICKS * inches), 8), steps=[1, 3, 4.5, 6, 9, 10]))


def dress(panel: Axes, x_label: str, y_label: str, legend_of: Axes | None = None) -> None:
    """Label axes, draw a grid, and write the legend above them in rows, in as many columns as fit.

    The legend names the curves of `legend_of`, a part of the panel, if there is one.
    """
    panel.set(xlabel=x_label, ylabel=y_label)
    panel.grid(alpha=0.25)
    handles, names = (legend_of or panel).get_legend_handles_labels()
    if not names:
        return
    figure: Any = panel.get_figure(root=True)
    width = panel.get_position().width * figure.get_figwidth()
    names = [_in_lines(name, int((width - SAMPLE) / CHARACTER)) for name in names]
    lengths = np.array([SAMPLE + CHARACTER * max(map(_length, name.split("\n"))) for name in names])
    fitting = (n for n in range(len(names), 0, -1) if sum(np.max(lengths[c::n]) for c in range(n)) <= width)
    rows = math.ceil(len(names) / next(fitting, 1))
    columns = math.ceil(len(names) / rows)
    in_rows = [i for column in range(columns) for i in range(column, len(names), columns)]  # matplotlib fills columns
    handles, names = [handles[i] for i in in_rows], [names[i] for i in in_rows]
    options: Any = {"ncols": columns, "frameon": False}
    largest = np.max(np.abs(panel.get_ylim()))
    plain = panel.get_yscale() == "log" or 10.0 ** PLAIN[0] <= largest < 10.0 ** PLAIN[1]
    panel.legend(
        handles, names, loc="lower center", bbox_to_anchor=(0.5, 1.0 if plain else 1.0 + POWER_HEIGHT), **options
    )


def _length(name: str) -> int:
    """Return the number of characters of a name without the markup of formulas."""
    return len(MARKUP.sub("", name))


def _in_lines(name: str, longest: int) -> str:
    """Return a name in lines of at most so many characters, broken at spaces outside formulas."""
    lines: list[str] = []
    for word in re.findall(r"(?:\$[^$]*\$|[^\s$])+", name):
        if lines and _length(f"{lines[-1]} {word}") <= longest:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return "\n".join(lines)
