"""The figures of docs/theory/conventions.md: `python -m tools.frames`.

Every axis in them is one that the package computes, so that a figure shows the sign and the order that the code has.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

import poinsot as pt
from poinsot.kinematics.euler import quaternion_from_angles

IMAGES = Path(__file__).parents[1] / "docs" / "images"
GRAY, BLUE, ORANGE, GREEN = "#5A5A5A", "#0072B2", "#D55E00", "#009E73"
AZIMUTH, ELEVATION = np.radians(-56.0), np.radians(24.0)

Array = NDArray[np.float64]


def seen(points: ArrayLike) -> Any:
    """Return points of space as the eye sees them, in parallel projection; (..., 3) -> (..., 2)."""
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    toward = np.array([np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)])
    return np.asarray(points) @ np.stack([right, np.cross(toward, right)], axis=-1)


def canvas(width: float = 5.0, height: float = 4.4) -> Axes:
    """Return axes without a frame, to scale."""
    _, ax = plt.subplots(figsize=(width, height), layout="constrained")
    ax.set_aspect("equal")
    ax.axis("off")
    return ax


def arrow(ax: Axes, tip: ArrayLike, label: str, colour: str, start: ArrayLike = (0, 0, 0), **style: Any) -> None:
    """Draw an arrow of space with its name beyond the tip."""
    (x0, y0), (x1, y1) = seen(start), seen(tip)
    options = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 12}
    ax.annotate("", (x1, y1), (x0, y0), arrowprops=options | style)
    beyond = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
    beyond *= 13 if "$" in label else 13 + 2.6 * max(0, len(label) - 4) * abs(beyond[0])  # half of a long name
    ax.annotate(label, (x1, y1), beyond, textcoords="offset points", color=colour, ha="center", va="center")
    ax.plot([x0, x1], [y0, y1], alpha=0)  # an annotation does not extend the axes


def arc(ax: Axes, axis: ArrayLike, begin: ArrayLike, angle: float, label: str, far: float = 1.22, at: int = 30) -> None:
    """Draw an angle about an axis, from a direction on, with its name next to it."""
    axis, begin = np.asarray(axis, dtype=float), np.asarray(begin, dtype=float)
    turned = np.linspace(0, angle, 60)[:, None]
    points = seen(np.cos(turned) * begin + np.sin(turned) * np.cross(axis, begin))
    ax.plot(*points.T, color=ORANGE, lw=1.2)
    options = {"arrowstyle": "-|>", "color": ORANGE, "lw": 1.2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
    ax.annotate("", points[-1], points[-4], arrowprops=options)
    x, y = points[at] * far
    ax.text(x, y, label, color=ORANGE, ha="center", va="center")


def circle(ax: Axes, first: ArrayLike, second: ArrayLike, colour: str = GRAY, **style: Any) -> None:
    """Draw the circle through two perpendicular directions."""
    t = np.linspace(0, 2 * np.pi, 240)[:, None]
    points = seen(np.cos(t) * np.asarray(first) + np.sin(t) * np.asarray(second))
    ax.plot(*points.T, color=colour, lw=0.9, **style)


def names(letter: str) -> list[str]:
    """Return a bold letter with three indices."""
    return [rf"$\mathbf{{{letter}}}_{k}$" for k in (1, 2, 3)]


def body_and_space() -> Axes:
    """Draw body axes in space, and one vector."""
    ax = canvas()
    q = np.array([0.93, 0.2, 0.18, 0.1])
    attitude = pt.Body((1, 1, 1)).state(q / np.linalg.norm(q), omega_body=(0, 0, 0)).attitude
    for axis, name in zip(1.25 * np.eye(3), names("s"), strict=True):
        arrow(ax, axis, name, GRAY)
    for axis, name in zip(1.1 * attitude.as_matrix().T, names("b"), strict=True):
        arrow(ax, axis, name, BLUE)
    arrow(ax, attitude.apply((0.95, 0.3, 0.85)), r"$\mathbf{x}$", ORANGE)
    return ax


def euler_angles() -> Axes:
    """Draw the angles of the sequence 3-1-3, all positive."""
    ax = canvas()
    phi, theta, psi = angles = np.radians([62.0, 42.0, 50.0])
    q = quaternion_from_angles(angles, "313")
    axes = pt.Body((1, 1, 1)).state(q, omega_body=(0, 0, 0)).attitude.as_matrix().T
    nodes = np.array([np.cos(phi), np.sin(phi), 0.0])
    circle(ax, (1, 0, 0), (0, 1, 0))
    circle(ax, axes[0], axes[1], BLUE, alpha=0.6)
    for axis, name in zip(1.3 * np.eye(3), names("s"), strict=True):
        arrow(ax, axis, name, GRAY)
    for axis, name in zip(1.15 * axes, names("b"), strict=True):
        arrow(ax, axis, name, BLUE)
    arrow(ax, 1.2 * nodes, "line of nodes", GREEN)
    arc(ax, (0, 0, 1), (0.5, 0, 0), phi, r"$\varphi$")
    arc(ax, nodes, (0, 0, 0.62), theta, r"$\vartheta$", 1.14)
    arc(ax, axes[2], 0.72 * nodes, psi, r"$\psi$")
    return ax


def orbital_frame() -> Axes:
    """Draw an orbit, the axes of its frame, and those of a level satellite."""
    ax = canvas(6.4, 4.6)
    orbit = pt.KeplerOrbit(
        1.0, semimajor_axis=1.5, eccentricity=0.25, inclination=0.5, node=0.7, argument_of_periapsis=0.4
    )
    time = -0.13 * orbit.period
    along = np.stack([*orbit.position_at(np.linspace(0, orbit.period, 400))], axis=-1)
    here = np.array([*orbit.position_at(time)])
    radial, transverse, normal = orbit.frame.attitude(time).as_matrix().T
    ax.plot(*seen(along).T, color=GRAY, lw=1)
    ax.plot(*seen((0, 0, 0)), "o", color=GRAY, ms=11)
    ax.annotate("attractor", seen((0, 0, 0)), (-12, -14), textcoords="offset points", color=GRAY, ha="right")
    ax.plot(*np.stack([seen((0, 0, 0)), seen(here)]).T, color=GRAY, lw=0.8, ls="--")
    for axis, name in zip((radial, transverse, normal), ("radial", "transverse", "normal"), strict=True):
        arrow(ax, here + axis, name, BLUE, here)
    arrow(ax, here - 0.7 * radial, "", ORANGE, here)
    arrow(ax, here - 0.7 * normal, "pitch axis", ORANGE, here)
    arrow(ax, here + 0.6 * transverse, "", ORANGE, here)
    ax.annotate("yaw axis", seen(here - 0.5 * radial), (0, 6), textcoords="offset points", color=ORANGE, ha="right")
    ax.annotate("roll axis", seen(here + 0.3 * transverse), (6, -8), textcoords="offset points", color=ORANGE)
    ax.margins(0.12)
    return ax


def elements() -> Axes:
    """Draw the angles of an orbit's plane."""
    ax = canvas()
    node, inclination, periapsis = 0.75, 0.62, 0.9
    axes = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.1, inclination=inclination, node=node, argument_of_periapsis=periapsis
    ).frame.attitude(0.0)
    first, second, normal = axes.as_matrix().T
    rising = np.array([np.cos(node), np.sin(node), 0.0])
    circle(ax, (1, 0, 0), (0, 1, 0))
    circle(ax, first, second, BLUE)
    for axis, name in zip(1.3 * np.eye(3), names("s"), strict=True):
        arrow(ax, axis, name, GRAY)
    arrow(ax, 1.2 * normal, "normal", BLUE)
    arrow(ax, 1.25 * rising, "node", GREEN)
    arrow(ax, 1.2 * first, "periapsis", BLUE)
    arc(ax, (0, 0, 1), (0.5, 0, 0), node, r"$\Omega$")
    arc(ax, rising, (0, 0, 0.6), inclination, "$i$", 1.14)
    arc(ax, normal, 0.7 * rising, periapsis, r"$\omega$")
    return ax


def planet_fixed() -> Axes:
    """Draw the axes that turn with a planet, and the angles that say where they are."""
    ax = canvas()
    ascension, declination, meridian = np.radians([-35.0, 58.0, 115.0])
    planet = pt.orbits.RotationModel(ascension, declination, meridian, rate=1.0)
    first, second, pole = planet.attitude(0.0).as_matrix().T
    rising = np.array([-np.sin(ascension), np.cos(ascension), 0.0])
    foot = np.array([np.cos(ascension), np.sin(ascension), 0.0])
    circle(ax, (1, 0, 0), (0, 1, 0))
    circle(ax, first, second, BLUE)
    for axis, name in zip(1.3 * np.eye(3), names("s"), strict=True):
        arrow(ax, axis, name, GRAY)
    arrow(ax, 1.25 * pole, "pole", BLUE)
    arrow(ax, 1.15 * first, "prime meridian", BLUE)
    arrow(ax, 1.2 * rising, "node of the equator", GREEN)
    ax.plot(*np.stack([seen((0, 0, 0)), seen(foot)]).T, color=GRAY, lw=0.8, ls="--")
    arc(ax, (0, 0, 1), (0.85, 0, 0), ascension, r"$\alpha_0$", 1.12)
    arc(ax, np.cross(foot, (0, 0, 1)), 0.6 * foot, declination, r"$\delta_0$")
    arc(ax, pole, 0.7 * rising, meridian, "$W$", 1.16, 18)
    return ax


FIGURES: dict[str, Callable[[], Axes]] = {
    "frames-body-space": body_and_space,
    "frames-euler-angles": euler_angles,
    "frames-orbit": orbital_frame,
    "frames-elements": elements,
    "frames-planet": planet_fixed,
}


def write(folder: Path) -> None:
    """Write all figures into a folder."""
    mpl.use("Agg")
    with mpl.rc_context({"svg.hashsalt": "poinsot", "mathtext.fontset": "cm", "font.size": 11}):
        for name, draw in FIGURES.items():
            figure: Any = draw().figure
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    plt.close("all")


if __name__ == "__main__":
    write(IMAGES)
