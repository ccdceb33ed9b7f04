"""Animation of a motion as GIF or MP4, drawn without a screen."""

from __future__ import annotations

import contextlib
import importlib
import io
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.algebra import quaternion as quat
from poinsot.atomic_write import new_file, unwritable
from poinsot.checked import checked
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.mechanics.environment import Orbit
from poinsot.plot.labels import BLACK, BLUE, GREEN, PURPLE, VERMILION, one_member
from poinsot.plot.page_scene import towards
from poinsot.plot.solid_parts import triangles
from poinsot.plot.solids import right_and_up, view_direction
from poinsot.printable import quoted
from poinsot.propagation.trajectory import Trajectory, is_of_two_bodies
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["animate"]

FRAMES_PER_SECOND = 20
"""Frames in a second; the delays in a GIF are whole hundredths of a second."""

MAX_SECONDS = 600
"""Longest duration of an animation, seconds."""

INCHES, DOTS = 4.8, 100
VIEW = (22.0, -59.0)
"""Elevation and azimuth of the eye in degrees, equal to the initial view of the page."""

AXIS, LONGEST_RATE, LONGEST_MOMENTUM, REACH, ROOM = 1.35, 1.55, 1.9, 1.85, 2.1
"""Lengths in units of the largest extent of the body, as on the page; for two bodies, of their orbits."""

MIN_LABELLED_SIZE = 0.5
"""Smallest size of a body whose vectors are labelled."""

LIGHT, SHADE = np.array([0.83, 0.88, 0.92]), np.array([0.62, 0.71, 0.79])
"""Colours of alternate octants of a body, which make its rotation visible."""

LIT_BY_EYE, LIT_BY_SUN = np.array([0.62, 0.38]), np.array([0.3, 0.7])
"""Brightness of a surface: a constant, and a part in proportion to the cosine between its normal and the light."""

ARROW, ARROWS = 1.4, {"sun": ("Sun", "#E69F00"), "observer": ("observer", "#56B4E9")}
"""Length, names and colours of the arrows to the Sun and to the observer."""

LONGEST_SYMBOL = 2
"""Largest number of characters of a label that is centred at the tip of its arrow."""

TRACE_FRAMES = 20
"""Number of frames for which the tip of an axis leaves a trace."""

TRACE_POINTS_PER_FRAME = 8
"""Number of points of a trace for each frame."""


@checked
def animate(
    motion: Trajectory,
    path: str | Path,
    *,
    seconds: float = 10.0,
    view: ArrayLike | None = None,
    sun: Orbit | None = None,
    observer: Orbit | None = None,
    overwrite: bool = False,
) -> Path:
    """Write an animation that shows a moving body with its axes, angular momentum G, omega and the trace of an axis.

    Two bodies move about their barycentre, to scale. Equal intervals of the motion last equally long in the animation.
    Between stored times the animation uses the dense output, or the great circle between attitudes.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body or of two, at two times or more.
    path : str or Path
        Name of the file, which ends in `.gif` or `.mp4`. Writing `.mp4` requires ffmpeg, on the path or from the
        package imageio-ffmpeg.
    seconds : float
        Duration of the animation, at most 600, with 20 frames per second. `motion[:1000]` selects a part of the motion.
    view : array (2,), optional
        Elevation and azimuth of the viewpoint in degrees; (22, -59) by default.
    sun : Orbit, optional
        Orbit of the body relative to the Sun, which lights the body. An arrow points to the Sun.
    observer : Orbit, optional
        Orbit of the body relative to an observer, to whom an arrow points.
    overwrite : bool
        True to replace an existing file of that name.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError, FileExistsError
        If the motion is not a trajectory, is an ensemble or has fewer than two times, if the path cannot be written, or
        if ffmpeg is missing for `.mp4`.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1, 0.2))
    >>> pt.animate(pt.free_motion(body, start, np.linspace(0, 20, 201)), "body.gif", seconds=0.2)
    PosixPath('body.gif')
    """
    path = Path(path)
    if path.suffix not in WRITERS:
        raise ValueError(f"path must end in {' or '.join(WRITERS)}, got {quoted(path.name)}.")
    if one_member(motion).times.size < 2:
        raise ValueError(f"motion must have two times or more, got {motion.times.size}.")
    seconds = float(real_array("seconds", seconds, ()))
    refuse_nonpositive("seconds", seconds)
    if seconds > MAX_SECONDS:
        raise ValueError(f"seconds must be at most {MAX_SECONDS}, got {seconds}.")
    write = WRITERS[path.suffix]
    times = np.linspace(np.min(motion.times), np.max(motion.times), max(2, round(seconds * FRAMES_PER_SECOND)))
    arrows = {
        name: _between(motion.times, towards(motion, name, orbit), times)
        for name, orbit in (("sun", sun), ("observer", observer))
        if orbit is not None
    }
    with new_file(path, overwrite) as part:
        write(part, _frames(motion, times, view_direction(VIEW if view is None else view), arrows))
    return path


# ---------------------------------------------------------------------- bodies


@dataclass(frozen=True)
class _AnimatedBody:
    """Body at the times of the frames, in units of the picture, space axes."""

    corners: Array
    colours: Array
    size: float
    place: Array
    attitude: Array
    rate: Array
    trace: Array
    colour: str

    def triangles(self, i: int) -> Array:
        """Return the triangles of the surface in a frame; shape (m, 3, 3)."""
        return np.asarray(self.place[i] + quat.rotate(self.attitude[i], self.corners))


def _bodies(motion: Trajectory, times: Array) -> list[_AnimatedBody]:
    """Return the bodies of a motion."""
    if not is_of_two_bodies(motion):
        return [_moving(motion, times, triangles(motion.system.of_bodies[""]), 1.0, PURPLE)]
    pair = two_bodies(motion.system)
    shares = [sign * (1 - mass / pair.total_mass) for mass, sign in zip(pair.masses, (-1, 1), strict=True)]
    solids = [triangles(body, mass) for body, mass in zip(pair.bodies.values(), pair.masses, strict=True)]
    sizes = [float(np.max(np.linalg.norm(solid, axis=-1))) for solid in solids]
    reach = max(abs(share) * np.max(motion.distance) + size for share, size in zip(shares, sizes, strict=True))
    each = zip(motion.of_bodies.values(), solids, shares, (BLUE, VERMILION), strict=True)
    scale = REACH / reach
    return [
        _moving(one, times, solid, scale, colour, share * scale * motion.position) for one, solid, share, colour in each
    ]


def _moving(
    motion: Trajectory, times: Array, corners: Array, scale: float, colour: str, path: Array | None = None
) -> _AnimatedBody:
    """Return a body at the times of the frames; a body without a path has the size of the unit of the picture."""
    largest = float(np.max(np.linalg.norm(corners, axis=-1)))
    size = 1.0 if path is None else scale * largest
    octants = np.prod(np.mean(corners, axis=1), axis=-1) > 0
    fine = np.linspace(times[0], times[-1], TRACE_POINTS_PER_FRAME * (times.size - 1) + 1)
    attitude = _attitudes(motion, fine)
    trace = AXIS * quat.rotate(attitude, np.array([0, 0, 1.0])) if path is None else _between(motion.times, path, fine)
    rate = motion.omega_space
    return _AnimatedBody(
        corners * (size / largest),
        np.where(octants[:, None], LIGHT, SHADE),
        size,
        np.zeros((times.size, 3)) if path is None else trace[::TRACE_POINTS_PER_FRAME],
        attitude[::TRACE_POINTS_PER_FRAME],
        _between(motion.times, rate * (LONGEST_RATE * size / (np.max(np.linalg.norm(rate, axis=-1)) or 1.0)), times),
        trace,
        colour,
    )


def _attitudes(motion: Trajectory, times: Array) -> Array:
    """Return the attitudes at the times of the frames."""
    if motion.has_dense_output:
        return motion(times).quaternion
    from scipy.spatial.transform import Slerp

    order = np.argsort(motion.times)
    turns: Any = Slerp(motion.times[order], motion.attitude[order])
    return np.asarray(turns(times).as_quat(scalar_first=True))


def _between(stored: Array, vectors: Array, times: Array) -> Array:
    """Return vectors between stored times, linearly."""
    order = np.argsort(stored)
    return np.stack([np.interp(times, stored[order], each[order]) for each in vectors.T], axis=-1)


# ---------------------------------------------------------------------- frames


def _frames(motion: Trajectory, times: Array, eye: Array, arrows: dict[str, Array]) -> Iterator[NDArray[np.uint8]]:
    """Yield the pictures with the arrows to the Sun and to the observer; each (height, width, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(INCHES, INCHES), dpi=DOTS)
    canvas: Any = FigureCanvasAgg(figure)
    panel = figure.add_axes((0, 0, 1, 1))
    bodies = _bodies(motion, times)
    momentum = _between(motion.times, motion.angular_momentum_space, times)
    momentum *= LONGEST_MOMENTUM / (np.max(np.linalg.norm(momentum, axis=-1)) or 1.0)
    across = np.stack(right_and_up(eye), axis=-1)
    for i, time in enumerate(times):
        panel.clear()
        panel.set(xlim=(-ROOM, ROOM), ylim=(-ROOM, ROOM))
        panel.set_axis_off()
        _draw(panel, bodies, momentum[i] if len(bodies) == 1 else None, i, across, eye, arrows.get("sun"))
        for name, towards_it in arrows.items():
            _arrow(panel, np.zeros(3), ARROW * towards_it[i], *ARROWS[name], across, eye)
        panel.text(0.02, 0.02, _time_text(motion, time), transform=panel.transAxes, color=BLACK)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _time_text(motion: Trajectory, time: float) -> str:
    unit = motion.system.units["time"]
    return f"t = {time:.6g}" + ("" if unit == "1" else f" {unit}")


def _draw(
    panel: Axes,
    bodies: list[_AnimatedBody],
    momentum: Array | None,
    i: int,
    across: Array,
    eye: Array,
    sun: Array | None,
) -> None:
    """Draw one frame, the farthest objects first, in the light of the Sun, or with light from the eye."""
    from matplotlib.collections import PolyCollection

    corners = np.concatenate([body.triangles(i) for body in bodies])
    colours = np.concatenate([body.colours for body in bodies])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-300)
    facing = normals @ eye
    lit = LIT_BY_EYE @ [np.ones(len(facing)), facing]
    if sun is not None:
        lit = LIT_BY_SUN @ [np.ones(len(facing)), np.maximum(normals @ sun[i], 0)]
    seen = np.flatnonzero(facing > 0)
    order = seen[np.argsort(np.mean(corners[seen] @ eye, axis=-1))]
    shaded = colours[order] * lit[order, None]
    panel.add_collection(
        PolyCollection(list(corners[order] @ across), facecolors=shaded, edgecolors=shaded, linewidths=0.3, zorder=2)
    )
    for body in bodies:
        _draw_axes(panel, body, i, across, eye)
    if momentum is not None:
        _arrow(panel, np.zeros(3), momentum, "G", BLACK, across, eye)


def _draw_axes(panel: Axes, body: _AnimatedBody, i: int, across: Array, eye: Array) -> None:
    """Draw the axes and the rate of a body, and the trace of its third axis, or of a moving body itself."""
    panel.plot(
        *(body.trace[max(0, i - TRACE_FRAMES) * TRACE_POINTS_PER_FRAME : i * TRACE_POINTS_PER_FRAME + 1] @ across).T,
        color=body.colour,
        lw=1.2,
        zorder=3,
    )
    axes = AXIS * body.size * quat.rotate(body.attitude[i], np.eye(3))
    named = body.size > MIN_LABELLED_SIZE
    for name, axis in zip(("b₁", "b₂", "b₃"), axes, strict=True):
        _arrow(panel, body.place[i], axis, name if named else "", PURPLE, across, eye)
    _arrow(panel, body.place[i], body.rate[i], "ω" if named else "", GREEN, across, eye)


def _arrow(panel: Axes, start: Array, vector: Array, name: str, colour: str, across: Array, eye: Array) -> None:
    """Draw a vector, behind the bodies if it leads away from the eye."""
    from_eye = start @ across
    tip = (start + vector) @ across
    order = 4 if vector @ eye >= 0 else 1
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    panel.annotate("", xy=tuple(tip), xytext=tuple(from_eye), arrowprops={**style, "zorder": order}, zorder=order)
    if name:
        where = (start + vector * (1 + 0.12 / max(float(np.linalg.norm(vector)), 0.12))) @ across
        side = "center" if len(name) <= LONGEST_SYMBOL else "left" if where[0] >= from_eye[0] else "right"
        panel.text(where[0], where[1], name, color=colour, ha=side, va="center", style="italic", zorder=order)


# ---------------------------------------------------------------------- files


def _write_gif(path: Path, frames: Iterator[NDArray[np.uint8]]) -> None:
    from PIL import Image

    first, *others = (Image.fromarray(frame).quantize(64, dither=Image.Dither.NONE) for frame in frames)
    options: Any = {"duration": 1000 // FRAMES_PER_SECOND, "loop": 0, "optimize": False}
    content = io.BytesIO()
    first.save(content, "GIF", save_all=True, append_images=others, **options)
    path.write_bytes(content.getvalue())


def _write_mp4(path: Path, frames: Iterator[NDArray[np.uint8]]) -> None:
    side = round(INCHES * DOTS)
    taken = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{side}x{side}", "-r", str(FRAMES_PER_SECOND), "-i", "-"]
    made = ["-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(path)]
    command = [_ffmpeg(), "-y", "-loglevel", "error", *taken, *made]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:  # noqa: S603 - no shell
        with contextlib.suppress(BrokenPipeError):  # the error message of the process follows below
            for frame in frames:
                process.stdin.write(frame.tobytes())  # type: ignore[union-attr]
        _, message = process.communicate()
    if process.returncode:
        why, *_ = message.decode(errors="replace").splitlines() or ["nothing"]
        raise OSError(unwritable(path.name, f"ffmpeg reported: {why.rstrip('.')}"))


def _ffmpeg() -> str:
    """Return the path of ffmpeg."""
    if found := shutil.which("ffmpeg"):
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except ImportError:
        raise FileNotFoundError(
            "ffmpeg must be installed to write .mp4, got none. Run `pip install imageio-ffmpeg`, or write a .gif."
        ) from None


WRITERS = {".gif": _write_gif, ".mp4": _write_mp4}
"""Writers of animations by file extension."""
