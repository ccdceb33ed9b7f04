"""Program that runs one example, or plays and draws one scenario, and writes the square thumbnail of its picture."""

from __future__ import annotations

import itertools
import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

import poinsot as pt
from poinsot.observables import LightCurve

__all__ = ["DRAWINGS", "PANELS", "thumbnail", "write_thumbnail"]

Array = NDArray[np.float64]

SIDE, DOTS = 4.0, 120
"""Inches and dots per inch of a thumbnail."""
SMALLEST = 6
"""Points of the smallest labels of a thumbnail."""
DECADES = 6
"""Largest number of ticks along a horizontal log axis, so that their labels do not touch."""
WIDEST = 0.82
"""Part of the width of a thumbnail that a legend may take."""
PANELS = {"cubesat": 3, "dart": 2, "desaturation": 1, "halo_orbit": 1, "heavy_body_section": 1, "hyperion": 1}
"""Index of the panel in a thumbnail; default: the first."""
BLACK, BLUE, VERMILION, GREY = "#000000", "#0072B2", "#D55E00", "#8C8C8C"


# ---------------------------------------------------------------------- pictures of scenarios


def panels(count: int = 1) -> list[Axes]:
    """Return the axes of a new figure side by side."""
    _, axes = plt.subplots(1, count, figsize=(5.5 * count, 4.5), layout="constrained", squeeze=False)
    for panel in axes[0]:
        panel.grid(alpha=0.25)
    return list(axes[0])


def in_orbit(motion: Any) -> tuple[Array, Array]:
    """Return the revolutions, and the body axes as columns along the radial, transverse and normal directions."""
    orbit = motion.system.orbits[0]
    return motion.times / orbit.period, motion.relative_to(orbit.frame).attitude.as_matrix()


def from_vertical(axes: Array) -> Array:
    """Return the angle of the first body axis from the vertical, either way, in degrees."""
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs(axes[..., 0, 0]), 0, 1))))


def seen_from_body(axes: Array) -> tuple[Array, Array]:
    """Return the longitude and the latitude of the attractor in the body, from the first axis, in degrees."""
    out = axes[..., 0, :]
    out = -out * np.sign(-out[0, 0])
    return np.degrees(np.arctan2(out[..., 1], out[..., 0])), np.degrees(np.arcsin(out[..., 2]))


def apophis_ensemble(ensemble: Any) -> None:
    """Draw the distribution of the effective angular velocity before and after the flyby."""
    pt.plot.histogram(ensemble, "effective_rate", rate_unit="deg/h")


def boom_deployment(motion: Any) -> None:
    """Draw the angular velocity over the orbital rate, and the angle of the boom from the vertical."""
    (left, right), (revolutions, axes) = panels(2), in_orbit(motion)
    minutes, rate = motion.times / 60, motion.omega_body[:, 2] * motion.times[-1] / (2 * np.pi * revolutions[-1])
    left.axhline(1, color=GREY, linestyle="--", label="rate of the orbit")
    left.plot(minutes, rate, color=BLUE, label="satellite")
    left.axvspan(1, 6, color=BLACK, alpha=0.1, linewidth=0, label="deployment")
    left.set(xlabel="time [min]", ylabel="angular velocity over the orbital rate", yscale="log", ylim=(0.5, 100))
    left.legend(frameon=False)
    right.plot(minutes, from_vertical(axes), color=BLUE)
    right.set(xlabel="time [min]", ylabel="boom from the vertical [deg]", ylim=(0, 90), yticks=range(0, 91, 15))


def boom_satellite(ensemble: Any) -> None:
    """Draw the median of the angle of the boom from the vertical, and percentiles over the members."""
    [panel], (revolutions, axes) = panels(), in_orbit(ensemble)
    angle = from_vertical(axes)
    for low, high, opacity in ((5, 95, 0.2), (25, 75, 0.35)):
        words = f"{low} to {high} % of 100 satellites"
        edges = np.percentile(angle, [low, high], axis=0)
        panel.fill_between(revolutions, *edges, color=BLUE, alpha=opacity, linewidth=0, label=words)
    panel.plot(revolutions, np.median(angle, axis=0), color=BLUE, label="median")
    panel.plot(revolutions, angle[0], color=VERMILION, linewidth=0.9, label="first satellite")
    panel.set(xlabel="time [revolutions]", ylabel="boom from the vertical [deg]", xlim=(0, 3), ylim=(0, 10))
    panel.legend(frameon=False, ncols=2, loc="upper center")


def contact_binary(motion: Any) -> None:
    """Draw the libration of the long axis about the direction of the planet."""
    [panel], (revolutions, axes) = panels(), in_orbit(motion)
    angle = np.degrees(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]))
    panel.plot(revolutions, angle - 180 * np.round(angle[0] / 180), color=BLUE)
    panel.set(xlabel="time [revolutions]", ylabel="long axis from the direction of the planet [deg]", xlim=(0, 10))


def didymos(motion: Any) -> None:
    """Draw the librations of Dimorphos and its distance for ten days."""
    axes, window = panels(2), (0, 10 * 86400)
    pt.plot.librations(motion, ax=axes[0], window=window)
    pt.plot.distance(motion, ax=axes[1], window=window)


def digital_slew(motion: Any) -> None:
    """Draw the angle to the target attitude, and the angular velocity."""
    axes = panels(2)
    angle, _ = pt.plot.attitude_error(motion, (1, 0, 0, 0), axes=[axes[0], plt.figure().subplots()], angle_unit="deg")
    angle.set(yscale="log", ylim=(1e-4, 1000))
    rates = np.degrees(motion.omega_body)
    for i, colour in enumerate((BLACK, BLUE, VERMILION)):
        axes[1].plot(motion.times, rates[:, i], color=colour, label=rf"$\omega_{i + 1}$")
    axes[1].set(xlabel="time [s]", ylabel="angular velocity, body axes [deg s⁻¹]", xlim=(0, 120))
    axes[1].legend(frameon=False)


def heavy_top(motion: Any) -> None:
    """Draw the path of the axis through the centre of mass, seen from above."""
    [panel] = panels()
    x, y, _ = motion.attitude.as_matrix()[:, :, 0].T
    circle = np.linspace(0, 2 * np.pi, 361)
    panel.plot(np.cos(circle), np.sin(circle), color=GREY, linewidth=0.8, label="horizontal axis")
    panel.plot(x, y, color=BLUE, linewidth=0.9, label="axis through the centre of mass")
    panel.plot(x[0], y[0], "o", color=VERMILION, label="initial direction")
    panel.set(xlabel="direction along $s_1$", ylabel="direction along $s_2$", aspect="equal")
    panel.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1))
    panel.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize="small")


def io(motion: Any) -> None:
    """Draw the libration in longitude for five revolutions."""
    [panel], (revolutions, axes) = panels(), in_orbit(motion)
    panel.plot(revolutions, seen_from_body(axes)[0], color=BLUE)
    panel.set(xlabel="time [revolutions]", ylabel="libration in longitude [deg]", xlim=(0, 5))


def titan(motion: Any) -> None:
    """Draw the path of Saturn in the sky of Titan."""
    draw_sky(motion, "Saturn")


def moon(motion: Any) -> None:
    """Draw the path of the Earth in the sky of the Moon."""
    draw_sky(motion, "the Earth")


def draw_sky(motion: Any, attractor: str) -> None:
    """Draw the latitude of the attractor over its longitude, in the axes of the body."""
    [panel], (revolutions, axes) = panels(), in_orbit(motion)
    longitude, latitude = seen_from_body(axes)
    shown = revolutions <= 5
    panel.plot(longitude[shown], latitude[shown], color=BLUE, label="five revolutions")
    panel.plot(longitude[0], latitude[0], "o", color=VERMILION, label="first periapsis")
    panel.plot(0, 0, "+", color=BLACK, markersize=12, label="long axis")
    panel.set(xlabel=f"longitude of {attractor} [deg]", ylabel=f"latitude of {attractor} [deg]")
    panel.margins(y=0.2)
    panel.legend(frameon=False, loc="upper center", ncols=3, fontsize="small", columnspacing=1, handletextpad=0.4)


def mercury(motion: Any) -> None:
    """Draw the path of the Sun in the sky of Mercury, and the obliquity."""
    (left, right), (revolutions, axes) = panels(2), in_orbit(motion)
    longitude, _ = seen_from_body(axes)
    left.plot(revolutions, -np.unwrap(longitude, period=360), color=BLUE)
    left.plot(range(5), 180 * np.arange(5), "o", color=VERMILION, label="perihelia")
    left.set(xlabel="time [revolutions]", ylabel="path of the Sun in the sky of Mercury [deg]", xlim=(-0.1, 4.1))
    left.set(ylim=(-20, 740), yticks=range(0, 721, 90))
    left.legend(frameon=False)
    obliquity = 60 * np.degrees(np.arccos(axes[:, 2, 2]))
    right.plot(revolutions, obliquity, color=BLUE)
    right.set(xlabel="time [revolutions]", ylabel="obliquity [arcmin]", ylim=(0, 2))


def spin_orbit_capture(motion: Any) -> None:
    """Draw the angular velocity over the mean motion."""
    [panel], (revolutions, _) = panels(), in_orbit(motion)
    panel.plot(revolutions, motion.omega_space[:, 2], color=BLUE, label="angular velocity")
    panel.axhline(1.5, color=VERMILION, linestyle="--", label="3:2 resonance")
    panel.set(xlabel="time [revolutions]", ylabel="angular velocity over the mean motion", xlim=(0, 60))
    panel.legend(frameon=False)


DRAWINGS: dict[str, Callable[[Any], None]] = {
    each.__name__: each
    for each in (
        apophis_ensemble,
        boom_deployment,
        boom_satellite,
        contact_binary,
        didymos,
        digital_slew,
        heavy_top,
        io,
        mercury,
        moon,
        spin_orbit_capture,
        titan,
    )
}
"""Drawings of the scenarios that have no program."""


# ---------------------------------------------------------------------- thumbnails


def thumbnail(figure: Figure, index: int) -> Axes:
    """Make one panel of a figure fill a square, remove all else, and return the panel."""
    panel = figure.axes[index]
    shared = panel.get_shared_x_axes().get_siblings(panel)
    panel.set_xlabel(next(filter(None, (each.get_xlabel() for each in shared)), ""))
    panel.tick_params(labelbottom=True)
    for other in [each for each in figure.axes if each is not panel]:
        other.remove()
    for words in [*figure.texts, *figure.legends]:
        words.remove()
    figure.suptitle("")
    figure.supxlabel("")
    figure.set_size_inches(SIDE, SIDE)
    figure.set_layout_engine("none")
    panel.set_subplotspec(figure.add_gridspec(1, 1)[0])
    if panel.get_aspect() != "auto":
        panel.set_adjustable("datalim")
    for axis in (panel.xaxis, panel.yaxis):
        axis.label.set_fontsize(11)
    if panel.get_xscale() == "log":
        panel.xaxis.set_major_locator(LogLocator(numticks=DECADES))
    arrange_legend(panel)
    remove_overlapping_ticks(panel)
    for layout in ("none", "constrained"):  # which fails with words that are longer than the figure
        figure.set_layout_engine(layout)
        for words, along in ((panel.title, 0), (panel.xaxis.label, 0), (panel.yaxis.label, 1)):
            shrink(words, along, figure)
    return panel


def shrink(words: Any, along: int, figure: Any) -> None:
    """Make words along the horizontal or vertical direction small enough for the figure around their middle."""
    figure.draw_without_rendering()
    low, high = words.get_window_extent().get_points()[:, along]
    side = SIDE * figure.dpi
    room = 1.96 * min((low + high) / 2, side - (low + high) / 2)
    if high - low > room:
        words.set_fontsize(max(SMALLEST, words.get_fontsize() * room / (high - low)))


def remove_overlapping_ticks(panel: Axes) -> None:
    """Remove the labels of the ticks along the vertical axis if they overlap."""
    figure: Any = panel.figure
    figure.draw_without_rendering()
    boxes = [tick.get_window_extent() for tick in panel.get_yticklabels() if tick.get_text()]
    edges = sorted((box.y0, box.y1) for box in boxes)
    if any(after[0] < before[1] for before, after in itertools.pairwise(edges)):
        panel.tick_params(labelleft=False)


def arrange_legend(panel: Axes) -> None:
    """Put the legend above the panel, in rows of as many columns as fit."""
    old = panel.get_legend()
    if old is None:
        return
    handles: Any = old.legend_handles
    names = [text.get_text() for text in old.get_texts()]
    title = old.get_title().get_text()
    old.remove()
    figure: Any = panel.figure
    for columns in range(len(names), 0, -1):
        in_rows = [i for column in range(columns) for i in range(column, len(names), columns)]
        look: Any = {"title": title or None, "frameon": False, "fontsize": 9, "ncols": columns}
        look |= {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
        look |= {"columnspacing": 1, "handletextpad": 0.4, "handlelength": 1.5}
        new = panel.legend([handles[i] for i in in_rows], [names[i] for i in in_rows], **look)
        figure.draw_without_rendering()
        if new.get_window_extent().width <= WIDEST * SIDE * figure.dpi:
            return


def write_thumbnail(name: str, figure: Figure) -> None:
    """Write the thumbnail of an example from its figure."""
    thumbnail(figure, PANELS.get(name, 0))
    figure.savefig("thumbnail.jpg", dpi=DOTS)


# ---------------------------------------------------------------------- the program


def run_program(path: Path) -> Figure:
    """Run a program, and return the figure whose file has the name of the program, or its first figure."""
    saved: dict[str, Figure] = {}
    save = Figure.savefig

    def remember(figure: Figure, fname: Any, **options: Any) -> None:
        save(figure, fname, **options)
        saved.setdefault(Path(fname).stem, figure)

    Figure.savefig = remember  # type: ignore[method-assign, assignment]
    sys.argv = [str(path)]
    runpy.run_path(str(path), run_name="__main__")
    Figure.savefig = save  # type: ignore[method-assign]
    return saved.get(path.stem) or next(iter(saved.values()))


def play(path: Path, page: Path) -> Any:
    """Write the page that plays a scenario, of an ensemble its first member, and return the motion."""
    scenario = pt.files.read_scenario(path)
    motion = scenario.propagate(progress=False)
    curves = [plan.observable for plan in scenario.plans if isinstance(plan.observable, LightCurve)]
    sun, observer = (curves[0].sun, curves[0].observer) if curves else (None, None)
    one = motion.member(0) if motion.is_ensemble else motion
    pt.view(one, page, sun=sun, observer=observer, overwrite=True)
    return motion


def main(path: Path, page: Path) -> None:
    """Run a program, or play a scenario and draw it unless a program does."""
    name = path.stem
    if path.suffix == ".py":
        write_thumbnail(name, run_program(path))
        return
    motion = play(path, page)
    if name in DRAWINGS:
        DRAWINGS[name](motion)
        figure = plt.figure(1)
        figure.savefig("scenario.png", dpi=110)
        write_thumbnail(name, figure)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
