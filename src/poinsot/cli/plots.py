"""Plots, 3D views and animations: `poinsot plot`, `poinsot view`, `poinsot animate`."""

from __future__ import annotations

import inspect
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import poinsot
from poinsot.cli.terminal import (
    OPTIONS,
    Member,
    OfTwo,
    Overwrite,
    advise,
    busy,
    check_ending,
    check_new,
    checked_result,
    loaded_motion,
    one_of,
    opened,
    report_path,
)
from poinsot.printable import quoted
from poinsot.quantities import ANGLE_UNITS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from poinsot.mechanics.environment import Orbit
    from poinsot.observables.light_curve import LightCurve
    from poinsot.observables.readings import Readings
    from poinsot.propagation.trajectory import Trajectory

__all__ = ["KINDS", "animate", "drawn", "plot", "usual_kind", "view", "viewed"]

OF_ANALYSES = {"branch", "chaos", "map", "section", "spectrum", "uncertainty", "yorp"}
OF_READINGS = ("readings", "phased", "phase_plane")
"""The kinds of plot of readings."""
KINDS = tuple(name for name in poinsot.plot.__all__ if name not in OF_ANALYSES | {*OF_READINGS})
"""The kinds of plot of a result: the functions of `poinsot.plot` that need only a motion."""

Window = Annotated[
    str | None,
    typer.Option(
        "--time",
        metavar="FROM:TO",
        help="Interval of times, in the time unit of the result; FROM or TO may be omitted.",
    ),
]

ONLY_OF_TWO = {"distance", "librations", "mutual_orbit"}
OF_TWO = {"angular_velocity", "difference", "drift"} | ONLY_OF_TWO
"""The kinds of plot that draw two bodies together."""
QUANTITIES = ("effective_rate", "rate", "angular_momentum", "turn")
"""The quantities of a histogram; the import of the module that draws them takes half a second."""
OFTEN = ("angular_velocity", "drift", "polhode")


def plot(
    file: Annotated[Path, typer.Argument(help="Result (.nc, .zarr), or readings (.nc).")],
    picture: Annotated[
        Path | None,
        typer.Argument(help="Image file to write (.png, .pdf, .svg); default: FILE-KIND.png in the folder of FILE."),
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option(
            help=f"Kind of plot: {', '.join(KINDS)}; default: quaternions, for two bodies mutual_orbit. Of readings: "
            f"{', '.join(OF_READINGS)}; default: readings.",
            autocompletion=one_of(*KINDS, *OF_READINGS),
        ),
    ] = None,
    other: Annotated[
        Path | None,
        typer.Option(
            "--with",
            help="Second result at the same times, for --kind difference or attitude_error, or computed readings, for "
            "--kind phased or phase_plane.",
        ),
    ] = None,
    period: Annotated[
        str | None,
        typer.Option(
            metavar="P",
            help="Period, for --kind phased, or two periods P1,P2 for --kind phase_plane, in the time unit "
            "of the readings.",
        ),
    ] = None,
    orbit: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Number (1, 2, ...) of the reference orbit, for --kind roll_pitch_yaw with several orbits.",
        ),
    ] = None,
    part: Annotated[
        str | None, typer.Option(help="Name of the part, for --kind part_variables with several parts.")
    ] = None,
    quantity: Annotated[
        str | None,
        typer.Option(
            help=f"Quantity, for --kind histogram: {', '.join(QUANTITIES)}; default: {QUANTITIES[0]}.",
            autocompletion=one_of(*QUANTITIES),
        ),
    ] = None,
    angle_unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of angles: deg, rad, mrad, arcmin, arcsec, rev; default: chosen from the size of the values.",
            autocompletion=one_of(*ANGLE_UNITS),
        ),
    ] = None,
    rate_unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of angular velocities, such as deg/s, mrad/h, rpm; default: chosen from the size of the values."
        ),
    ] = None,
    time_unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of times: s, min, h, d, yr, date; default: date with a calendar, else chosen from the time span."
        ),
    ] = None,
    dpi: Annotated[int, typer.Option(min=20, max=1200, help="Resolution of a .png, in dots per inch.")] = 150,
    time: Window = None,
    member: Member = None,
    body: OfTwo = None,
    overwrite: Overwrite = False,
) -> None:
    """Plot a result, or readings. The kinds of plots are functions of the module `poinsot.plot`.

    For example:

    - `poinsot plot top.nc` plots q and Q in top-quaternions.png
    - `poinsot plot top.nc top.pdf --kind polhode`
    - `poinsot plot satellite.nc --kind angular_velocity --time-unit h --rate-unit deg/s`
    - `poinsot plot top.nc --time 10:20 --dpi 300`
    - `poinsot plot top.nc --kind difference --with top-again.nc`
    - `poinsot plot tops.zarr --kind histogram --quantity effective_rate` plots all members
    - `poinsot plot binary.nc` plots the mutual orbit and both rotations in binary-mutual_orbit.png
    - `poinsot plot binary.nc --kind euler_angles --body secondary`
    - `poinsot plot asteroid.readings.nc --kind phased --period 5.27`
    """
    from poinsot.files.netcdf import ReadingsFoundError

    checked_result(file)
    with busy(f"Reading {file}"):
        try:
            motion = _loaded(file, member, time)
        except ReadingsFoundError:
            motion = None
    if motion is None:
        given = {"other": other, "orbit": orbit, "part": part, "quantity": quantity, "body": body}
        given |= {"angle_unit": angle_unit, "rate_unit": rate_unit}
        options = {"period": period, "time_unit": time_unit, "time": time, "member": member}
        _plot_readings(file, picture, kind or "readings", overwrite, dpi, given, options)
        return
    if period is not None:
        raise ValueError(f"--period must go with readings, got the result {file}.")
    kind = kind or usual_kind(_chosen(motion, body))
    path = file.with_name(f"{file.stem}-{kind}.png") if picture is None else picture
    words = {
        "part": part,
        "quantity": quantity,
        "angle_unit": angle_unit,
        "rate_unit": rate_unit,
        "time_unit": time_unit,
    }
    _check_options(kind, {"other": other, "orbit": orbit, **words})
    check_new(path, overwrite)
    motion = _chosen(motion, body, kind in OF_TWO)
    if kind in ONLY_OF_TWO and len(motion.of_bodies) == 1:
        raise ValueError(f"--kind must be a plot of one body, got {kind}.")
    report_path(drawn(motion, kind, path, overwrite, dpi, other=other, orbit=orbit, time=time, body=body, **words))
    advise(
        (f"{opened('plot', file)} --kind NAME", f"other plots: {', '.join(OFTEN)}, ..."),
        (opened("view", file), "writes a 3D view"),
    )


def _plot_readings(
    file: Path,
    picture: Path | None,
    kind: str,
    overwrite: bool,
    dpi: int,
    given: dict[str, Any],
    options: dict[str, Any],
) -> None:
    """Plot the readings in a file."""
    if kind not in OF_READINGS:
        raise ValueError(f"--kind must be one of {', '.join(OF_READINGS)} for readings, got {quoted(kind)}.")
    for name, value in given.items():
        if value is not None and not (name == "other" and "model" in _wanted(kind)):
            raise ValueError(f"{OPTIONS[name]} must go with a result, got the readings {file}.")
    if options["period"] is None and kind != "readings":
        raise ValueError(f"--period must be given for --kind {kind}, got none.")
    if options["period"] is not None and kind == "readings":
        raise ValueError("--period must go with --kind phased or phase_plane, got --kind readings.")
    path = file.with_name(f"{file.stem}-{kind}.png") if picture is None else picture
    check_new(path, overwrite)
    member, window = options.pop("member"), options.pop("time")
    found = _readings_in(file, member, window)
    model = None if given["other"] is None else _readings_in(given["other"], member, window)
    report_path(drawn(found, kind, path, overwrite, dpi, model=model, **options))
    advise((f"{opened('plot', file)} --kind NAME", f"other plots: {', '.join(OF_READINGS)}"))


def _readings_in(file: Path, member: int | None, window: str | None) -> tuple[Readings, ...]:
    """Return the readings in a file, of one of the members, at their times or at those within a window."""
    from poinsot.files import read_readings

    found = read_readings(file)
    if member is not None:
        found = tuple(each.isel(member=member) for each in found)
    if window is not None:
        found = tuple(each.isel(time=_places(each.times, window)) for each in found)
    return found


def view(
    file: Annotated[Path, typer.Argument(help="Result (.nc, .zarr).")],
    page: Annotated[
        Path | None, typer.Argument(help="Page to write (.html); default: FILE with the suffix .html.")
    ] = None,
    other: Annotated[Path | None, typer.Option("--with", help="Second result, drawn as a translucent body.")] = None,
    time: Window = None,
    member: Member = None,
    body: OfTwo = None,
    overwrite: Overwrite = False,
) -> None:
    """Write an interactive 3D view of a result as one HTML file, which any browser opens offline.

    For example:

    - `poinsot view top.nc`
    - `poinsot view top.nc talk/top.html --time 10:20`
    - `poinsot view top.nc both.html --with nudged.nc`
    """
    for result in (file, *((other,) if other else ())):
        checked_result(result)
    path = page or file.with_suffix(".html")
    check_new(path, overwrite)
    check_ending(path, ".html")
    with busy(f"Reading {file}"):
        motion = _chosen(_loaded(file, member, time), body)
        others = None if other is None else _chosen(_loaded(other, None, time), body)
    report_path(viewed(motion, path, overwrite, others))
    advise((path.resolve().as_uri(), "the 3D view, for any browser"))


def animate(
    file: Annotated[Path, typer.Argument(help="Result (.nc, .zarr).")],
    animation: Annotated[
        Path | None, typer.Argument(help="Animation to write (.gif, .mp4); default: FILE with the suffix .gif.")
    ] = None,
    seconds: Annotated[float, typer.Option(help="Duration of the animation in seconds.")] = 10.0,
    time: Window = None,
    member: Member = None,
    body: OfTwo = None,
    overwrite: Overwrite = False,
) -> None:
    """Write an animation of a result as GIF or MP4. No display is required.

    For example:

    - `poinsot animate top.nc`
    - `poinsot animate top.nc talk/top.mp4 --seconds 20 --time 10:20`
    """
    checked_result(file)
    path = animation or file.with_suffix(".gif")
    check_new(path, overwrite)
    check_ending(path, ".gif", ".mp4")
    with busy(f"Reading {file}"):
        motion = _chosen(_loaded(file, member, time), body)
    from poinsot.plot.animation import animate as write_animation

    sun, observer = _sun_and_observer(motion)
    with busy(f"Writing {path}"):
        write_animation(motion, path, seconds=seconds, sun=sun, observer=observer, overwrite=overwrite)
    report_path(path)
    advise((opened("view", file), "writes an interactive 3D view"))


def usual_kind(motion: Trajectory) -> str:
    """Return the default kind of plot of a motion."""
    if len(motion.of_bodies) == 1:
        return "quaternions"
    return "distance" if motion.is_ensemble else "mutual_orbit"


def drawn(
    motion: Trajectory | tuple[Readings, ...], kind: str, path: Path, overwrite: bool, dpi: int = 150, **options: Any
) -> Path:
    """Draw a motion or readings into a file, whole or not at all, and return its path.

    `options` are options of the command.
    """
    check_ending(path, ".png", ".pdf", ".svg")
    check_new(path, overwrite)
    import matplotlib as mpl
    import numpy as np

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from poinsot.atomic_write import new_file

    draw = getattr(poinsot.plot, kind)
    with busy(f"Writing {path}"):
        arguments = (
            _of_readings(kind, motion, **options) if isinstance(motion, tuple) else _arguments(kind, motion, **options)
        )
        figure = np.ravel(draw(**arguments))[0].figure
        content = io.BytesIO()
        figure.savefig(content, format=path.suffix[1:], **({"dpi": dpi} if path.suffix == ".png" else {}))
        plt.close(figure)
        with new_file(path, overwrite) as part:
            part.write_bytes(content.getvalue())
    return path


def viewed(motion: Trajectory, path: Path, overwrite: bool, others: Trajectory | None = None) -> Path:
    """Write the page of a motion, and return its path."""
    from poinsot.plot.view import view as page_of

    sun, observer = _sun_and_observer(motion)
    with busy(f"Writing {path}"):
        return page_of(motion, path, others=others, sun=sun, observer=observer, overwrite=overwrite)


def _check_options(kind: str, given: dict[str, Any]) -> None:
    """Raise a ValueError for an unknown kind, for options that it does not use, and for a missing second result."""
    if kind not in KINDS:
        raise ValueError(f"--kind must be one of {', '.join(KINDS)}, got {quoted(kind)}.")
    for name, value in given.items():
        if value and name not in _wanted(kind):
            kinds = " or ".join(known for known in KINDS if name in _wanted(known))
            raise ValueError(f"{OPTIONS[name]} must go with --kind {kinds}, got --kind {kind}.")
    needed = [name for name, parameter in _wanted(kind).items() if parameter.default is parameter.empty]
    if given["other"] is not None:
        checked_result(given["other"])
    elif "other" in needed:
        raise ValueError("--with must be another result, such as --with other.nc, got none.")


def _wanted(kind: str) -> Mapping[str, inspect.Parameter]:
    """Return the arguments of a function of the package, by name."""
    return inspect.signature(getattr(poinsot.plot, kind)).parameters


def _arguments(
    kind: str,
    motion: Trajectory,
    other: Path | None = None,
    orbit: int | None = None,
    time: str | None = None,
    body: str | None = None,
    **words: str | None,
) -> dict[str, Any]:
    """Return the arguments of a function of the package, by their names, from a motion and the options."""
    made: dict[str, Callable[[], Any]] = {
        "motion": lambda: motion,
        "ensemble": lambda: motion,
        "other": lambda: None if other is None else _chosen(_loaded(other, time=time), body),
        "orbit": lambda: _orbit(motion, orbit),
        "curve": lambda: _light_curve(motion),
        "title": lambda: motion.provenance.get("title") or "",
    }
    given = {name: made[name]() for name in _wanted(kind) if name in made}
    return given | {name: word for name, word in words.items() if word is not None}


def _of_readings(
    kind: str,
    readings: tuple[Readings, ...],
    model: tuple[Readings, ...] | None,
    period: str | None,
    time_unit: str | None,
) -> dict[str, Any]:
    """Return the arguments of a function that draws readings, from the options."""
    made: dict[str, Any] = {"readings": readings, "model": model, "time_unit": time_unit}
    made["title"] = next((each.attributes["title"] for each in readings if "title" in each.attributes), "")
    periods = _numbers("--period", period)
    count = 1 + (kind == "phase_plane")
    if period is not None and len(periods) != count:
        raise ValueError(f"--period must be {count} numbers for --kind {kind}, got {quoted(period)}.")
    if period is not None:
        made["periods" if count > 1 else "period"] = periods if count > 1 else periods[0]
    return {name: value for name, value in made.items() if value is not None and name in _wanted(kind)}


def _numbers(option: str, text: str | None) -> list[float]:
    """Return the numbers in an option, separated by commas."""
    try:
        return [] if text is None else [float(word) for word in text.split(",")]
    except ValueError:
        raise ValueError(f"{option} must be numbers separated by commas, got {quoted(text)}.") from None


def _light_curves(motion: Trajectory) -> list[LightCurve]:
    """Return the light curves among the observables in the scenario of a motion."""
    from poinsot.files.scenario import repetition
    from poinsot.observables.light_curve import LightCurve

    plans = repetition(motion, "the result").plans if "scenario" in motion.provenance else ()
    return [plan.observable for plan in plans if isinstance(plan.observable, LightCurve)]


def _light_curve(motion: Trajectory) -> LightCurve:
    """Return the first light curve in the scenario of a motion."""
    for curve in _light_curves(motion):
        return curve
    raise ValueError("--kind sky must be of a scenario with a light curve, [[observe]] type = 'LightCurve', got none.")


def _sun_and_observer(motion: Trajectory) -> tuple[Orbit | None, Orbit | None]:
    """Return the orbits from the Sun and from the observer of the first light curve in the scenario of a motion."""
    return next(((curve.sun, curve.observer) for curve in _light_curves(motion)), (None, None))


def _orbit(motion: Trajectory, number: int | None) -> Orbit:
    """Return the orbit of a motion, or the one of a number if there are several."""
    from poinsot.plot.labels import different_orbits

    found = different_orbits(motion)
    if not found:
        raise ValueError("the result must contain an orbit as the observer's position, got none.")
    if number is None and len(found) == 1:
        return found[0]
    if number is None or number > len(found):
        listed = "; ".join(f"{i}: {type(orbit).__name__}" for i, orbit in enumerate(found, 1))
        raise ValueError(f"--orbit must name one orbit, got {number or 'none'}. There are {listed}.")
    return found[number - 1]


def _chosen(motion: Trajectory, body: str | None, whole: bool = True) -> Trajectory:
    """Return the motion of the named body; without a name the whole motion, if the plot can draw it."""
    from poinsot.propagation.trajectory import of_one_body

    return motion if whole and body is None else of_one_body(motion, body)


def _loaded(file: Path, member: int | None = None, time: str | None = None) -> Trajectory:
    """Return a result, or one of its members, at its times or at those within a window."""
    motion = loaded_motion(checked_result(file))
    motion = motion if member is None else motion.member(member)
    return motion if time is None else motion.isel(time=_places(motion.times, time))


def _places(times: NDArray[np.float64], window: str) -> NDArray[np.int_]:
    """Return the places of the times within FROM:TO."""
    import numpy as np

    first, colon, last = window.partition(":")
    try:
        if not colon:
            raise ValueError
        low, high = float(first or -np.inf), float(last or np.inf)
    except ValueError:
        raise ValueError(f"--time must be FROM:TO, two numbers, got {quoted(window)}.") from None
    places = np.flatnonzero((times >= low) & (times <= high))
    if not places.size:
        raise ValueError(f"--time must meet times of the result, {times[0]:.6g} ... {times[-1]:.6g}, got {window}.")
    return places
