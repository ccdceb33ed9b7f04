"""Poinsot's geometry of free rotation: the rolling ellipsoid, the polhode and the herpolhode."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from poinsot.analysis.polhodes import energy_curve, energy_curves, herpolhode_radii, principal, separatrices
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.plot.labels import BLACK, BLUE, GREEN, GREY, VERMILION, Unit, one_body, rate_unit_of
from poinsot.plot.panels import Axes, Axes3D, dress, one_panel, plot
from poinsot.plot.solids import (
    DrawnEllipsoid,
    DrawnSolid,
    draw_arrow,
    draw_path,
    draw_point,
    finish,
    fit,
    label_axes,
    right_and_up,
    solid_axes,
    view_direction,
)
from poinsot.plot.time_axis import instant
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.storage.selection import checked_index

__all__ = ["herpolhode", "is_constant", "poinsot_construction", "polhode"]

CONSTANT_TOLERANCE = 1e-6
"""Largest relative variation of a constant angular momentum in space or kinetic energy."""

VIEW = (20.0, -60.0)

YELLOW = "#F0E442"


@plot
def poinsot_construction(
    motion: Trajectory,
    time_index: int = -1,
    *,
    view: ArrayLike | None = None,
    ax: Axes3D | None = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
) -> Axes3D:
    """Draw Poinsot's construction at one instant: the inertia ellipsoid rolling on the invariable plane.

    The ellipsoid omega . I omega = 2T, fixed in the body, touches the plane omega . G = 2T, fixed in space, at the tip
    of omega. This point draws the polhode on the ellipsoid (in closed form) and the herpolhode on the plane (a line
    through the samples). Poinsot, Théorie nouvelle de la rotation des corps (1834).

    Parameters
    ----------
    motion : Trajectory
        Torque-free motion of one body. G is not to scale.
    time_index : int
        Index of the instant in `motion.times`; the last by default.
    view : array (2,), optional
        Elevation and azimuth of the viewpoint in degrees; (20, -60) by default.
    {options}

    Returns
    -------
    matplotlib Axes
        Panel in 3D with G upwards: space after the shortest rotation that maps G to the third axis.

    Raises
    ------
    IndexError, TypeError, ValueError
        If the motion is not a trajectory of one body without parts, G is zero or not constant to 1e-6, or the index is
        out of range.

    Examples
    --------
    >>> panel = pt.plot.poinsot_construction(motion, 100, view=(30, 0), rate_unit="deg/s")
    >>> panel.figure.get_suptitle()
    "Poinsot's construction at time 10 s"
    """
    _check_torque_free(motion)
    index = int(checked_index("time_index", time_index, motion.times.size))
    upright, (moments, axes) = _upright(motion), principal(motion.system.of_bodies[""])
    unit = rate_unit_of(motion.system.units, rate_unit, motion.omega_body)
    omega, g = unit.factor * motion.omega_space @ upright.T, unit.factor * motion.angular_momentum_body[index] @ axes
    turned = upright @ rotation_matrix(motion.quaternion[index]) @ axes
    eye = view_direction(VIEW if view is None else view)
    panel: Axes3D = solid_axes(eye, f"Poinsot's construction at {instant(motion, motion.times[index], time_unit)}", ax)
    semiaxes = unit.factor * np.sqrt(2 * motion.kinetic_energy[index] / moments)
    solid = DrawnSolid(panel, DrawnEllipsoid(turned, semiaxes), eye)
    solid.family(map(solid.ellipsoid.section, np.eye(3)), GREY, 0.6)
    G = np.linalg.norm(g)
    polhode = G * energy_curve(moments, g / G) / moments
    solid.curve(polhode @ turned.T, BLUE, 1.8, "polhode, on the inertia ellipsoid")
    fit(panel, *_draw_invariable_plane(solid, omega, index, herpolhode_radii(moments, g)), eye)
    label_axes(panel, _upright_labels(unit))
    finish(panel, ax is None)
    return panel


@plot
def polhode(
    motion: Trajectory,
    *,
    view: ArrayLike | None = None,
    ax: Axes3D | None = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
) -> Axes3D:
    """Draw the path of omega along the body axes, on the ellipsoid omega . I omega = 2T.

    Thin lines are other polhodes of the same energy; black lines are the separatrices. If forces change the kinetic
    energy by more than 1e-6, or the body has parts, this ellipsoid does not exist, and only the path is drawn
    (Goldstein, Classical Mechanics, Sec. 5.6).

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, whose samples a line joins. A dot marks the last one.
    view : array (2,), optional
        Elevation and azimuth of the viewpoint in degrees; by default the last sample is in front.
    {options}

    Returns
    -------
    matplotlib Axes
        Panel in 3D along the given body axes, principal or not.

    Raises
    ------
    TypeError, ValueError
        If the motion is not a trajectory of one body, contains no samples, or is at rest.

    Examples
    --------
    >>> pt.plot.polhode(motion, rate_unit="rpm").get_zlabel().endswith("[rpm]")
    True
    """
    _check_turning(motion)
    unit = rate_unit_of(motion.system.units, rate_unit, motion.omega_body)
    omega = unit.factor * motion.omega_body
    moments, axes = principal(motion.system.of_bodies[""])
    eye = axes @ _facing(omega[-1] @ axes, moments) if view is None else view_direction(view)
    panel: Axes3D = solid_axes(eye, r"Polhode: the path of $\omega$ along the body axes", ax)
    path, last = r"path of $\omega$", f"at {instant(motion, motion.times[-1], time_unit)}"
    if not motion.system.parts and is_constant(motion.kinetic_energy[:, None]):
        energy = unit.factor**2 * motion.kinetic_energy[-1]
        solid = DrawnSolid(panel, DrawnEllipsoid(axes, np.sqrt(2 * energy / moments)), eye)
        _draw_polhodes(solid, moments, energy)
        solid.curve(omega, BLUE, 2, path)
        solid.mark(omega[-1], GREEN, last)
        high = np.array([solid.ellipsoid.reach(axis) for axis in np.eye(3)])
        low = -high
    else:
        draw_path(panel, omega, color=BLUE, linewidth=1.5, label=path)
        draw_point(panel, omega[-1], GREEN, last)
        low, high = np.min(omega, axis=0), np.max(omega, axis=0)
        margin = np.maximum(0.05 * (high - low), 0.1 * np.max(high - low) or 0.1 * np.max(np.abs(omega)))
        low, high = low - margin, high + margin
    fit(panel, low, high, eye)
    label_axes(panel, [rf"$\omega_{i}${unit.label}" for i in (1, 2, 3)])
    finish(panel, ax is None)
    return panel


@plot
def herpolhode(
    motion: Trajectory, *, ax: Axes | None = None, rate_unit: str | None = None, time_unit: str | None = None
) -> Axes:
    """Draw the path of omega in the invariable plane, between the two circles that bound it.

    With k the axis that the polhode encircles and D = 2T/G^2, the circles about the line of G have the radii G sqrt((D
    - 1/I_k) (1/I_i - D)) for the other two axes i; on a separatrix the smaller radius is zero (Poinsot 1834; Goldstein,
    Classical Mechanics, Sec. 5.6).

    Parameters
    ----------
    motion : Trajectory
        Torque-free motion of one body. A line joins its samples, and a dot marks the last one.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel, seen from the tip of G, with equal scales on both axes, which are the first two axes of
        `poinsot_construction`.

    Raises
    ------
    TypeError, ValueError
        If the motion is not a trajectory of one body without parts, or G is zero or not constant to 1e-6.

    Examples
    --------
    >>> pt.plot.herpolhode(motion, rate_unit="deg/s").get_ylabel().endswith("[deg s⁻¹]")
    True
    """
    _check_torque_free(motion)
    unit = rate_unit_of(motion.system.units, rate_unit, motion.omega_body)
    omega = unit.factor * motion.omega_space @ _upright(motion).T
    moments, axes = principal(motion.system.of_bodies[""])
    radii = herpolhode_radii(moments, unit.factor * motion.angular_momentum_body[-1] @ axes)
    panel = one_panel((5.6, 5.8), ax)
    for radius in radii:
        panel.plot(*_circle(radius), color=GREY, linewidth=0.8)
    draw_path(panel, omega[:, :2], color=VERMILION, linewidth=1.1, label=r"$\omega$")
    panel.plot(
        *omega[-1:, :2].T,
        "o",
        color=GREEN,
        markeredgecolor="white",
        label=f"at {instant(motion, motion.times[-1], time_unit)}",
    )
    panel.plot(0, 0, "+", color=BLACK, markersize=9, label=r"$\mathbf{G}$, towards the eye")
    room = 1.1 * max(radii[1], 0.02 * np.max(omega[:, 2]))
    panel.set(xlim=(-room, room), ylim=(-room, room), aspect="equal")
    panel.locator_params(nbins=7)
    x_label, y_label, _ = _upright_labels(unit)
    dress(panel, x_label, y_label)
    return panel


# ---------------------------------------------------------------------- parts of the pictures


def _draw_invariable_plane(
    solid: DrawnSolid, omega: Array, index: int, radii: tuple[float, float]
) -> tuple[Array, Array]:
    """Draw the plane at the tip of omega with the herpolhode on it, omega and G; return two corners around all."""
    panel, tip, height = solid.axes, omega[index], omega[index, 2]
    above = solid.eye[2] > 0
    plane = 5 if above else -5  # in the order of painting
    reach = np.array([solid.ellipsoid.reach(axis) for axis in np.eye(3)[:2]])
    half = np.maximum(1.15 * radii[1], 0.85 * reach)
    x, y = np.meshgrid(*np.outer(half, [-1, 1]))
    panel.plot_surface(x, y, np.full_like(x, height), color=YELLOW, alpha=0.3, edgecolor=GREY, zorder=plane)
    for radius in radii:
        panel.plot(*_circle(radius), height, color=GREY, linewidth=0.8, zorder=plane + 1)
    name = "herpolhode, on the invariable plane"
    trace = np.column_stack([omega[:, :2], np.full(len(omega), height)])
    draw_path(panel, trace, color=VERMILION, linewidth=1.2, zorder=plane + 1, label=name)
    up, head = np.array([0, 0, height]), 0.12 * height
    panel.plot(*np.outer([0, 1], up).T, color=BLACK, linewidth=1, zorder=4)
    draw_arrow(panel, up, 1.5 * up, BLACK, head, plane + 2 if above else plane - 1)
    draw_arrow(panel, 0 * tip, tip, GREEN, head, 4)
    draw_point(panel, tip, GREEN)
    panel.text(*(1.56 * up), r"$\mathbf{G}$", ha="center", fontsize=13, zorder=9)
    side = "left" if right_and_up(solid.eye)[0] @ tip >= 0 else "right"
    panel.text(*(0.6 * tip), r" $\omega$ ", color=GREEN, ha=side, va="top", fontsize=15, zorder=9)
    return np.append(-np.maximum(half, reach), -height), np.append(np.maximum(half, reach), 1.5 * height)


def _draw_polhodes(solid: DrawnSolid, moments: Array, energy: float) -> None:
    """Draw the polhodes of an energy: omega_i = sqrt(2T/D) n_i / I_i along the principal axes."""

    def of(directions: Iterable[Array]) -> Iterator[Array]:
        for n in directions:
            omega = np.sqrt(2 * energy / (n**2 @ (1 / moments)))[:, None] * n / moments
            yield omega @ solid.ellipsoid.axes.T

    long, _, short = np.argsort(moments)
    solid.family(of([*energy_curves(moments, short), *energy_curves(moments, long)]), GREY, 0.6, "other polhodes")
    solid.family(of(separatrices(moments)), BLACK, 1.0, "separatrices")


def _circle(radius: float) -> tuple[Array, Array]:
    angle = np.linspace(0, 2 * np.pi, 361)
    return radius * np.cos(angle), radius * np.sin(angle)


def _upright_labels(unit: Unit) -> list[str]:
    return [
        rf"$\omega_x \perp \mathbf{{G}}${unit.label}",
        rf"$\omega_y \perp \mathbf{{G}}${unit.label}",
        rf"$\omega_z \parallel \mathbf{{G}}${unit.label}",
    ]


# ---------------------------------------------------------------------- directions


def _upright(motion: Trajectory) -> Array:
    """Return the matrix of the shortest rotation of space that maps G to the third axis."""
    from scipy.spatial.transform import Rotation

    turn, _ = Rotation.align_vectors([[0, 0, 1]], motion.initial.angular_momentum_space[None])
    return np.asarray(turn.as_matrix())


def _facing(omega: Array, moments: Array) -> Array:
    """Return a direction, along the principal axes, from which the polhode of omega is in front."""
    nearest = np.argmax(np.abs(omega) * np.sqrt(moments))
    eye = np.full(3, 0.45)
    eye[nearest] = 0.75
    return np.asarray(np.where(omega >= 0, eye, -eye) / np.linalg.norm(eye))


# ---------------------------------------------------------------------- checks


def is_constant(values: Array) -> bool:
    """Return True if vectors (n, k) are constant."""
    change = np.max(np.linalg.norm(values - values[0], axis=-1))
    return bool(change <= CONSTANT_TOLERANCE * np.max(np.linalg.norm(values, axis=-1)))


def _check_turning(motion: Trajectory) -> None:
    if not np.any(one_body(motion).angular_momentum_body):
        raise ValueError("motion must have an angular momentum, but g = 0. A body at rest has no axis of rotation.")


def _check_torque_free(motion: Trajectory) -> None:
    _check_turning(motion)
    if parts := motion.system.parts:
        raise ValueError(f"motion must be of a rigid body, got one with {parts[0].name}. Parts leave no such plane.")
    G, G0 = motion.angular_momentum_space, motion.initial.angular_momentum_space
    change = np.max(np.linalg.norm(G - G0, axis=-1)) / np.max(np.linalg.norm(G, axis=-1))
    if change > CONSTANT_TOLERANCE:
        raise ValueError(
            f"motion must have a constant angular momentum in space, but it changes by {change:.2g} of its size. "
            "Propagate System(body) without forces: only free motion has an invariable plane."
        )
