"""Plots of the results of analyses: spectra, sections, branches of periodic motions, and mean torques of YORP."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from typing_extensions import Unpack

from poinsot.analysis.continuation import Branch
from poinsot.analysis.line_spectrum import LineSpectrum
from poinsot.analysis.periodic import PeriodicMotion
from poinsot.analysis.sections import Section
from poinsot.analysis.yorp import YorpCoefficients
from poinsot.errors import real_array
from poinsot.plot.labels import BLACK, BLUE, COLOURS, GREEN, PURPLE, VERMILION, angle_unit_of, bracketed, rate_unit_of
from poinsot.plot.panels import PLAIN, Axes, PanelOptions, count_degrees, dress, one_panel, plot
from poinsot.printable import quoted
from poinsot.quantities import Array

__all__ = ["branch", "section", "spectrum", "yorp"]

NAMED_LINES = 5
"""Number of the strongest lines, whose frequencies are written above them."""
MAX_DIGITS = 10
"""Largest number of digits of a frequency."""
RADIANS = " [rad]"
RATE = " [rad / unit of time]"
NEIGHBOURS = COLOURS[:5]
MAX_INK = 3e4
"""Number of points of a picture from which on each point is a single dot."""
STYLES: dict[bool, dict[str, Any]] = {
    True: {"color": BLUE, "linestyle": "-"},
    False: {"color": VERMILION, "linestyle": "--"},
}
NAMES = {True: "stable", False: "unstable"}
MARKERS = {
    "fold": ("o", BLACK),
    "branching": ("s", GREEN),
    "doubling": ("D", PURPLE),
    "collision": ("X", BLACK),
    "torus": ("P", GREEN),
    "unresolved": ("$?$", BLACK),
}


@plot
def spectrum(
    spectrum: LineSpectrum,
    *,
    time: str = "1",
    unit: str = "1",
    rate_unit: str | None = None,
    **options: Unpack[PanelOptions],
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

    Raises
    ------
    TypeError, ValueError
        If the argument is not the spectrum of one signal.

    Examples
    --------
    >>> times = np.linspace(0, 60, 601)
    >>> found = pt.analysis.frequencies(np.cos(2 * times) + 0.3 * np.cos(3.1 * times), times, count=2)
    >>> pt.plot.spectrum(found, time="s", unit="rad s-1", rate_unit="deg/s").get_xlabel()
    'frequency [deg s⁻¹]'
    """
    if spectrum.frequencies.ndim != 1:
        raise ValueError(
            f"spectrum must be of one signal, got frequencies of shape {spectrum.frequencies.shape}. "
            "Take the signal to draw apart alone."
        )
    axes, rate = one_panel((8, 4.5), **options), rate_unit_of({"time": time}, rate_unit, spectrum.frequencies)
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


@plot
def section(
    section: Section,
    *,
    angle_unit: str | None = None,
    rate_unit: str | None = None,
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw the points of a section, with different colours for neighbouring members.

    Parameters
    ----------
    section : Section
        Points with the labels of their axes. Coordinates in "[rad]" are angles and coordinates in "[rad/s]" (or per
        other unit of time of the system) angular velocities, both drawn in a suitable unit.
    {options}

    Examples
    --------
    >>> found = pt.analysis.section(motion, lambda at: at.omega_body[:, :2].T, labels=("first", "second"))
    >>> pt.plot.section(found, title="Angular velocity").get_xlabel()
    'first'
    """
    axes = one_panel((7, 6), **options)
    points = np.isfinite(section.x)
    (x, x_label), (y, y_label) = (
        _in_unit(values, label, section.motion.system.units, angle_unit, rate_unit)
        for values, label in zip((section.x, section.y), section.labels, strict=True)
    )
    size = float(np.clip(MAX_INK / max(int(np.count_nonzero(points)), 1), 0.1, 6.0))
    for k, colour in enumerate(NEIGHBOURS):
        mine = points.copy()
        mine[np.arange(len(mine)) % len(NEIGHBOURS) != k] = False
        axes.scatter(x[mine], y[mine], s=size, color=colour, linewidths=0, rasterized=True)
    axes.margins(0.01)
    dress(axes, x_label, y_label)
    for axis in (axes.xaxis, axes.yaxis):
        count_degrees(axis, axis.get_label_text())
    return axes


def _in_unit(
    values: Array, label: str, units: Mapping[str, str], angle_unit: str | None, rate_unit: str | None
) -> tuple[Array, str]:
    """Return coordinates and their label, of angles and angular velocities in the unit of an axis."""
    own = next((unit for unit in (RADIANS, f" [rad/{units['time']}]", RATE) if label.endswith(unit)), None)
    if own is None:
        return values, label
    unit = angle_unit_of(angle_unit, values) if own == RADIANS else rate_unit_of(units, rate_unit, values)
    return unit.factor * values, label.removesuffix(own) + unit.label


@plot
def branch(
    branch: Branch | Sequence[Branch],
    quantity: Callable[[PeriodicMotion], float],
    labels: tuple[str, str],
    **options: Unpack[PanelOptions],
) -> Axes:
    """Draw a quantity of the periodic motions of one or several branches against the parameter.

    Parameters
    ----------
    branch : Branch or sequence of them
        Branches, all in the same parameter.
    quantity : function of a PeriodicMotion
        Function that returns a number, such as an initial angle, or the amplitude over the period.
    labels : pair of str
        Labels of the axes with units: ("eccentricity", "amplitude [deg]").
    {options}

    Raises
    ------
    TypeError, ValueError
        If there is no branch, or the quantity is not a number.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> body = pt.Body((1.0, 1.3, 1.6))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    >>> system = pt.System(body, pt.GravityGradient(orbit))
    >>> at_rest = pt.analysis.periodic_motion(system, start, orbit.period, orbit.frame)
    >>> found = pt.analysis.continue_motion(at_rest, "moments[0]", 1.01, frame=lambda _: orbit.frame)
    >>> pt.plot.branch(found, lambda motion: motion.period, ("moments[0]", "period")).get_ylabel()
    'period'
    """
    if len(labels) != 2:
        raise ValueError(f"labels must be a pair of them, got {quoted(labels)}.")
    branches = [branch] if isinstance(branch, Branch) else branch
    if not branches:
        raise ValueError("branch must be a Branch or several, got none.")
    axes = one_panel((8, 4.5), **options)

    def name(label: str) -> str | None:
        return None if label in axes.get_legend_handles_labels()[1] else label

    for each in branches:
        for stable, points in _parts(each, quantity):
            axes.plot(*np.transpose(points), linewidth=1.6, label=name(NAMES[stable]), **STYLES[stable])
    for each in branches:
        for found in each.bifurcations:
            marker, colour = MARKERS[found.kind]
            place = found.value, _value(quantity, found.motion)
            axes.plot(*place, marker, color=colour, markersize=7, label=name(found.kind), zorder=5)
    dress(axes, *labels)
    return axes


def _value(quantity: Callable[[PeriodicMotion], float], motion: PeriodicMotion) -> float:
    return float(real_array("the quantity of a motion", quantity(motion), ()))


def _parts(branch: Branch, quantity: Callable[[PeriodicMotion], float]) -> Iterator[tuple[bool, list[Any]]]:
    """Yield connected points of one stability, which end at a bifurcation, or at the next point if there is none."""
    part: list[Any] = []
    stable = branch.motions[0].stable
    for i, (value, motion) in enumerate(zip(branch.values, branch.motions, strict=True)):
        point = value, _value(quantity, motion)
        if motion.stable != stable:
            seam = [(b.value, _value(quantity, b.motion)) for b in branch.bifurcations if b.after == i - 1] or [point]
            yield stable, [*part, seam[-1]]
            part, stable = [seam[-1]], motion.stable
        part.append(point)
    yield stable, part


@plot
def yorp(coefficients: YorpCoefficients, *, angle_unit: str | None = None, **options: Unpack[PanelOptions]) -> Axes:
    """Draw the mean torques at unit pressure along the spin axis and towards larger obliquity, against the obliquity.

    Parameters
    ----------
    coefficients : YorpCoefficients
        Coefficients at several obliquities.
    {options}

    Examples
    --------
    >>> box = pt.shapes.Mesh.from_box((2, 1.4, 1), mass=1.0)
    >>> bent = pt.shapes.Mesh(box.vertices + 0.3 * box.vertices[:, [1, 2, 0]] ** 3, box.faces, mass=1.0)
    >>> found = pt.analysis.yorp_coefficients(bent, np.radians([0, 30, 60, 90]))
    >>> pt.plot.yorp(found).get_xlabel()
    'obliquity [deg]'
    """
    panel, unit = one_panel((7.0, 4.4), **options), angle_unit_of(angle_unit, coefficients.obliquities)
    at = unit.factor * coefficients.obliquities
    panel.plot(at, 0 * at, color=BLACK, linewidth=0.8)
    panel.plot(at, coefficients.spin, color=BLUE, label="along the spin axis")
    panel.plot(at, coefficients.tilt, color=VERMILION, linestyle="--", label="towards larger obliquity")
    panel.ticklabel_format(axis="y", scilimits=PLAIN, useMathText=True)
    dress(panel, f"obliquity{unit.label}", "mean torque of unit pressure [length³]")
    count_degrees(panel.xaxis, panel.get_xlabel())
    return panel
