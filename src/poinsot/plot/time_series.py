"""Time series of a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Unpack

from poinsot.algebra import quaternion as quat
from poinsot.plot.comparison import median_attitude
from poinsot.plot.curves import (
    CurveOptions,
    SeparateCurveOptions,
    SeparatePairOptions,
    against_time,
    in_one_panel,
    reached,
)
from poinsot.plot.labels import bracketed, column_label, in_words, one_rotation, rate_unit_of, torque_unit_of, unit_of
from poinsot.plot.panels import Axes, plot
from poinsot.printable import quoted
from poinsot.propagation.columns import unit_of_column
from poinsot.propagation.dataset import components
from poinsot.propagation.trajectory import OfTwoBodies, Trajectory
from poinsot.quantities import Array

__all__ = [
    "angular_momentum",
    "angular_velocity",
    "distance",
    "drift",
    "part_variables",
    "quaternions",
    "torques",
]

MIN_DRIFT = 0.5 * np.finfo(float).eps
"""Smallest value on the log axis of relative drifts: the unit roundoff of a float."""
MIN_RELATIVE_TORQUE = 1e-12
"""Fraction of its largest value below which a torque is rounding error and is not drawn."""


@plot
def quaternions(motion: Trajectory, **options: Unpack[SeparatePairOptions]) -> NDArray[Any]:
    """Draw the components of q (left) and of Q (right, in the unit of the system) against time, as in the paper.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble. As in all plots against time, an ensemble is drawn as the median of the
        members with bands between the quartiles and between the 5th and the 95th percentile. The median attitude
        resolves the sign of q and -q, which are the same attitude.
    {options}

    Examples
    --------
    >>> left, right = pt.plot.quaternions(motion, time_unit="min")
    >>> left.get_xlabel()
    'time [min]'
    """
    momenta = f"conjugate momenta $Q${column_label(one_rotation(motion).system, 'conjugate_momenta')}"
    sign = _signs(reached(motion))
    curves = {
        "Euler parameters $q$": _named("$q_{}$", sign * motion.quaternion, 0),
        momenta: _named("$Q_{}$", sign * motion.conjugate_momenta, 0),
    }
    return against_time(motion, curves, **options)


@plot
def angular_velocity(
    motion: Trajectory, *, rate_unit: str | None = None, **options: Unpack[SeparatePairOptions]
) -> NDArray[Any]:
    """Draw the inertial angular velocity along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble. For two bodies, the left panel shows the primary and the right panel the
        secondary, each along its body axes.
    {options}

    Examples
    --------
    >>> pt.plot.angular_velocity(motion, rate_unit="deg/h")[0].get_ylabel()
    'angular velocity, body axes [deg h⁻¹]'
    """
    rates = {body: each.omega_body for body, each in motion.of_bodies.items()}
    unit = rate_unit_of(motion.system.units, rate_unit, np.stack(list(rates.values())))
    curves = {
        f"angular velocity{_of(body) or ', body axes'}{unit.label}": _named(r"$\omega_{}$", unit.factor * rate, 1)
        for body, rate in rates.items()
    }
    if len(rates) == 1:
        in_space = _named(r"$\omega_{{s{}}}$", unit.factor * motion.omega_space, 1)
        curves[f"angular velocity, space axes{unit.label}"] = in_space
    return against_time(reached(motion), curves, **options)


@plot
def angular_momentum(
    motion: Trajectory, *, momentum_unit: str | None = None, **options: Unpack[SeparatePairOptions]
) -> NDArray[Any]:
    """Draw the angular momentum of body and parts along the body axes (left) and along the space axes (right).

    Parameters
    ----------
    motion : Trajectory
        Motion of one body, or an ensemble.
    {options}

    Examples
    --------
    >>> [panel.get_ylabel() for panel in pt.plot.angular_momentum(motion, momentum_unit="mN m s")]
    ['angular momentum, body axes [mN m s]', 'angular momentum, space axes [mN m s]']
    """
    unit = unit_of("momentum_unit", unit_of_column(one_rotation(motion).system, "angular_momentum_body"), momentum_unit)
    curves = {
        f"angular momentum, body axes{unit.label}": _named("$g_{}$", unit.factor * motion.angular_momentum_body, 1),
        f"angular momentum, space axes{unit.label}": _named("$G_{}$", unit.factor * motion.angular_momentum_space, 1),
    }
    return against_time(reached(motion), curves, **options)


@plot
def part_variables(motion: Trajectory, part: str = "", **options: Unpack[SeparateCurveOptions]) -> Axes:
    """Draw the variables of a part, `motion.own`.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body with parts, or an ensemble.
    part : str, optional
        Name of a part with variables. Default: the only such part of the system.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel, with a unit if all variables are angular momenta.

    Raises
    ------
    ValueError
        If the system lacks the part, or contains several and none is named.

    Examples
    --------
    >>> system = pt.System(pt.Body((6.0, 8.0, 10.0)), pt.parts.KaneDamper(0.4, 0.3), units={"time": "s"})
    >>> start = system.state((1, 0, 0, 0), omega_body=(0.8, 0.02, 0.05))
    >>> pt.plot.part_variables(pt.propagate(system, start, range(100))).get_ylabel()
    'variables of kane_damper [s⁻¹]'
    """
    own = {each.name: each for each in one_rotation(motion).system.parts if each.size}
    if not part and len(own) == 1:
        [part] = own
    if not own:
        raise ValueError("motion must be of a body with a part that has variables, got one without.")
    if part not in own:
        raise ValueError(f"part must be one of {', '.join(own)}, got {quoted(part) if part else 'none'}.")
    names, values = components(own[part]), np.moveaxis(motion.own[part], -1, 0)
    label = f"variables of {part}{column_label(motion.system, f'own_{part}')}"
    curves = {name.replace("_", " "): value for name, value in zip(names, values, strict=True)}
    return in_one_panel(reached(motion), label, curves, **options)


@plot
def distance(motion: OfTwoBodies, *, length_unit: str | None = None, **options: Unpack[CurveOptions]) -> Axes:
    """Draw the distance of the centres of mass of two bodies.

    Parameters
    ----------
    motion : Trajectory
        Motion of two bodies, or an ensemble.
    {options}

    Examples
    --------
    >>> pt.plot.distance(pair_motion, length_unit="km", time_unit="h").get_ylabel()
    'distance of the centres of mass [km]'
    """
    unit = unit_of("length_unit", motion.system.units["length"], length_unit)
    label = f"distance of the centres of mass{unit.label}"
    return in_one_panel(reached(motion), label, {"": unit.factor * motion.distance}, **options)


@plot
def torques(motion: Trajectory, *, torque_unit: str | None = None, **options: Unpack[CurveOptions]) -> Axes:
    """Draw the magnitude of the torque of each force, on a log axis.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body with forces, or an ensemble. Torques between the body and its parts are not drawn.
    {options}

    Raises
    ------
    TypeError, ValueError
        If the system contains no forces.

    Examples
    --------
    >>> top = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1, 0, 0)), pt.forces.LinearDamping(0.01))
    >>> falling = pt.propagate(top, top.state((1, 0, 0, 0), omega_body=(0, 0.1, 2)), np.linspace(0, 9, 91))
    >>> [line.get_label() for line in pt.plot.torques(falling).lines]
    ['uniform gravity', 'linear damping']
    """
    found = one_rotation(motion).torques_body
    if not found:
        raise ValueError("motion must have forces to draw their torques, got one without, or of a file without theirs.")
    sizes = {name: np.linalg.norm(torque, axis=-1) for name, torque in found.items()}
    unit = torque_unit_of(motion.system.units, torque_unit)
    shown = {
        in_words(name): np.where(size > MIN_RELATIVE_TORQUE * np.nanmax(size, initial=0), unit.factor * size, np.nan)
        for name, size in sizes.items()
    }
    return in_one_panel(reached(motion), f"torque{unit.label}", shown, log=True, **options)


@plot
def drift(motion: Trajectory, **options: Unpack[CurveOptions]) -> Axes:
    """Draw the relative drift of the conserved quantities, on a log axis.

    The norm error |q| - 1 and the tangency error q . Q / |Q| are zero in exact arithmetic. Each integral of motion is
    drawn relative to its initial value, which the legend contains. For two bodies both errors are drawn for each body.

    Parameters
    ----------
    motion : Trajectory
        Motion of one body or of two, or an ensemble.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel. Values below half the rounding unit, 1.1e-16, are drawn at this value.

    Examples
    --------
    >>> pt.plot.drift(motion).get_ylabel()
    'relative drift'
    """
    reached(motion)
    drifts = {}
    for body, each in motion.of_bodies.items():
        drifts[f"norm error $|q| - 1${_of(body)}"] = each.norm_error
        drifts[rf"tangency error $q \cdot Q\,/\,|Q|${_of(body)}"] = each.tangency_error
    names = _names_of_integrals(motion)
    drifts |= {names[key]: drift for key, drift in motion.drift.items()}
    curves = {
        name: np.where(np.isnan(drift), drift, np.maximum(np.abs(drift), MIN_DRIFT)) for name, drift in drifts.items()
    }
    panel = in_one_panel(motion, "relative drift", curves, log=True, **options)
    panel.set_ylim(bottom=0.8 * MIN_DRIFT)
    return panel


# ---------------------------------------------------------------------- quantities


def _of(body: str) -> str:
    """Return the suffix that names a body, empty for a single body."""
    return body and f" of the {body}"


def _names_of_integrals(motion: Trajectory) -> dict[str, str]:
    """Return the names of the integrals in a legend; for a single motion with their initial values."""
    names, values = {}, motion.integrals
    for integral in motion.system.integrals:
        letter, index = integral.symbol[0], integral.symbol[1:]
        symbol = f"{letter}_{{{index}}}" if index.isalnum() else integral.symbol.replace(".", r" \cdot ")
        words, value = "energy" if integral.is_energy else "angular momentum", ""
        if not motion.is_ensemble:
            unit = unit_of_column(motion.system, f"integral_{integral.name}")
            value = f" = {values[integral.name][0]:.5g}" + ("" if unit == "1" else bracketed(unit))
        names[integral.name] = f"{words} ${symbol}${value}"
    return names


def _named(pattern: str, values: Array, first: int) -> dict[str, Array]:
    """Return the components of vectors by name."""
    return {pattern.format(i + first): values[..., i] for i in range(values.shape[-1])}


def _signs(motion: Trajectory) -> Array:
    """Return the signs that map the quaternions of members to the hemisphere of the median; 1 for a single motion."""
    if not motion.is_ensemble:
        return np.ones(1)
    median = median_attitude(motion.quaternion)
    most = np.sign(np.nansum(quat.dot(motion.quaternion[:, 0], median[0]))) or 1.0
    return np.where(quat.dot(motion.quaternion, median) < 0, -most, most)[..., None]
