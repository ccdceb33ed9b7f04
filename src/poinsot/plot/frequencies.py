"""Plots of line spectra: stems over the frequencies, and the residual."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from poinsot.analysis.line_spectrum import LineSpectrum
from poinsot.plot.labels import BLUE, VERMILION, bracketed, rate_unit_of
from poinsot.plot.panels import dress, one_panel, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["spectrum"]

NAMED_LINES = 5
"""Number of the strongest lines, whose frequencies are written above them."""
MAX_DIGITS = 10
"""Largest number of digits of a frequency."""


@plot
def spectrum(
    spectrum: LineSpectrum,
    *,
    ax: Axes | None = None,
    time: str = "1",
    unit: str = "1",
    rate_unit: str | None = None,
    title: str = "",
) -> Axes:
    """Draw the amplitudes of the lines of one signal against their frequencies, and the RMS residual.

    Labels give the frequencies of the five strongest lines with the error of the last digit in brackets: 0.4713945(2)
    stands for 0.4713945 +- 0.0000002. Without brackets all ten digits are certain. The width of a bar is the error of
    its frequency. Open circles mark unresolved lines.

    Parameters
    ----------
    spectrum : LineSpectrum
        Spectrum of one signal, from `pt.analysis.frequencies`.
    time, unit : str
        CF units of the time and of the signal, such as "s" and "rad", which the spectrum does not contain.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel; `axes.figure` is its figure, for `savefig`.

    Raises
    ------
    TypeError, ValueError
        If the argument is not the spectrum of one signal.

    Examples
    --------
    >>> found = pt.analysis.frequencies(motion.omega_body[:, 0], motion.times, count=4)
    >>> pt.plot.spectrum(found, time="s", unit="rad s-1", rate_unit="deg/s").get_xlabel()
    'frequency [deg s⁻¹]'
    """
    if spectrum.frequencies.ndim != 1:
        raise ValueError(
            f"spectrum must be of one signal, got frequencies of shape {spectrum.frequencies.shape}. "
            "Take the signal to draw apart alone."
        )
    axes, rate = one_panel(ax, (8, 4.5), title), rate_unit_of({"time": time}, rate_unit, spectrum.frequencies)
    nu, errors = rate.factor * spectrum.frequencies, rate.factor * spectrum.errors
    size, residual = np.abs(spectrum.amplitudes), float(spectrum.residual)
    heights = np.append(size, residual)
    floor = np.min(heights[heights > 0], initial=1.0) / 10
    axes.vlines(nu, floor, size, color=BLUE, linewidth=1)
    for fill, label, chosen in (
        ("full", "lines", spectrum.resolved),
        ("none", "lines not resolved", ~spectrum.resolved),
    ):
        if np.any(chosen) or fill == "full":
            (circles, *_) = axes.errorbar(
                nu[chosen], size[chosen], xerr=errors[chosen], fmt="o", color=BLUE, markersize=4, label=label
            )
            circles.set_fillstyle(fill)
    if residual > 0:
        axes.axhline(residual, color=VERMILION, linestyle="--", label="RMS residual")
    for line in range(min(NAMED_LINES, nu.size)):
        words = _written(float(nu[line]), float(errors[line]))
        axes.annotate(words, (nu[line], size[line]), (0, 5), textcoords="offset points", ha="center", fontsize="small")
    axes.set_yscale("log")
    axes.set_ylim(floor, 10 * np.max(size, initial=10 * floor))
    axes.margins(x=0.15)
    dress(axes, f"frequency{rate.label}", f"amplitude{bracketed(unit)}")
    return axes


def _written(value: float, error: float) -> str:
    """Return a number to the first digit of its standard error, which is in brackets: 0.47139(2)."""
    smallest = abs(value) / 10.0 ** (MAX_DIGITS - 1)
    if error < smallest or value == 0:
        return f"{value:.{MAX_DIGITS}g}"
    last = math.floor(math.log10(error))
    digit = math.ceil(error / 10.0**last)
    if digit == 10:
        last, digit = last + 1, 1
    return f"{round(value, -last):.{max(-last, 0)}f}({digit * 10 ** max(last, 0)})"
