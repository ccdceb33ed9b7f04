"""Content of the page of the 3D view, as JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.analysis.polhodes import principal
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.euler import sine_of_attitudes
from poinsot.kinematics.frame import LEVEL, roll_pitch_yaw
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.plot.geometry import is_constant
from poinsot.plot.labels import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    TIME_UNITS,
    VERMILION,
    bracketed,
    in_words,
    momentum_label,
    one_member,
    rate_unit_of,
    time_unit_of,
)
from poinsot.plot.page_arrays import packed, rows_of
from poinsot.plot.page_scene import NO_ORBITS, calendar_of, events_of, surroundings_of
from poinsot.plot.solid_parts import extents, gyration_radii, parts_of
from poinsot.propagation.trajectory import Trajectory, is_of_two_bodies
from poinsot.propagation.two_body_motion import two_bodies
from poinsot.quantities import Array
from poinsot.shapes.mascons import Mascons
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.shape import Shape
from poinsot.shapes.solids import Ellipsoid

__all__ = ["content_of", "others_of"]

COLOURS = {
    "space_axes": GREY,
    "body_axes": PURPLE,
    "trace": PURPLE,
    "angular_momentum": BLACK,
    "omega": GREEN,
    "polhode": BLUE,
    "herpolhode": VERMILION,
    "primary": BLUE,
    "secondary": VERMILION,
    "orbit": VERMILION,
    "paths": VERMILION,
    "orbit_frame": "#999933",
    "sun": "#E69F00",
    "observer": "#56B4E9",
    "shadow": GREY,
    "wheels": GREY,
    "ghosts": GREY,
    "events": VERMILION,
    "centres": GREY,
    "components": [BLACK, BLUE, VERMILION, GREEN],
}

MIN_EXTENT = 0.01
"""Smallest extent of a drawn body relative to the largest. A flat plate remains visible from its side."""

MAX_SPHERE = 0.1
"""Largest radius of the sphere of a mass point, relative to the farthest one; many spheres are smaller."""

MAX_SPHERES = 20_000
"""Largest number of drawn mass points, the heaviest ones."""

SECONDS_PER_TURN = 4.0

MIN_MOTION_SECONDS = 10.0
"""Shortest duration of a whole motion at the initial speed of the page, seconds."""


DURATIONS = {"min": "minutes", "h": "hours", "d": "days", "yr": "years", "1": "units of time"}
"""Words for units of time in titles."""

NUDGE = 1e-5
"""Half the angle, radians, by which a body at a pitch of 90 degrees is turned before its roll and yaw are computed."""

OMEGA_SYMBOLS = ("ω₁", "ω₂", "ω₃")

MAX_GHOSTS = 8
"""Largest number of other motions on a page."""


def others_of(motion: Trajectory, given: Trajectory | Sequence[Trajectory] | None) -> list[Trajectory]:
    """Return the motions to show together with the first one; from an ensemble, equally spaced members."""
    motions = [given] if isinstance(given, Trajectory) else list(given or ())
    others = [each for one in motions for each in (one if one.is_ensemble else (one,))]
    for other in others:
        if len(other.of_bodies) != len(motion.of_bodies):
            raise ValueError(
                "others must be motions of as many bodies as the motion, "
                f"got {len(other.of_bodies)} for {len(motion.of_bodies)}."
            )
    if len(others) > MAX_GHOSTS:
        others = [others[i] for i in np.linspace(0, len(others) - 1, MAX_GHOSTS).astype(int)]
    for other in others:
        if other.times.size < 2:
            raise ValueError(f"others must be motions at two times or more, got {other.times.size}.")
    return others


def content_of(
    motion: Trajectory,
    others: Sequence[Trajectory] = (),
    title: str = "",
    directions: Mapping[str, Orbit] = NO_ORBITS,
) -> dict[str, Any]:
    """Return the content of the page for one or two bodies, together with other motions and arrows."""
    if one_member(motion).times.size < 2:
        raise ValueError(f"motion must have two times or more, got {motion.times.size}.")
    own = _of_pair(motion, directions) if is_of_two_bodies(motion) else _of_body(motion, directions)
    rates, quantities = own.pop("rates"), own.pop("quantities")
    momentum = own["arrays"]["angular_momentum_space"] = motion.angular_momentum_space
    own["largest"]["angular_momentum"] = _longest(momentum)
    rows = rows_of(motion.times, rates.values(), own["arrays"], len(others) + 1)
    return {
        **own,
        "title": title or _title_of(motion),
        "note": _note(rows.times, {body: rate[rows.at] for body, rate in rates.items()}),
        "stored": motion.times.size,
        **_labels(motion, rates),
        "quantities": {name: each.on_page() for name, each in quantities.items()},
        "colours": COLOURS,
        **rows.encoded(own["arrays"]),
        "envelopes": {} if rows.are_all else {name: rows.envelope(each.values) for name, each in quantities.items()},
        "rate": _initial_speed(rows.times, own["mean_rate"]),
        "second": 1 / TIME_UNITS[units] if (units := motion.system.units["time"]) in TIME_UNITS else None,
        "ghosts": [_ghost(other, len(others) + 1) for other in others],
        "calendar": calendar_of(motion),
        "events": events_of(motion),
    }


class PlottedQuantity(NamedTuple):
    """Quantity that a plot of the page can show, with the factor from its values to the unit in its label.

    Angles are in radians; beyond half a turn they continue at the other edge of the plot.
    """

    label: str
    symbols: Sequence[str]
    values: Array
    factor: float = 1.0
    are_angles: bool = False

    def on_page(self) -> dict[str, Any]:
        """Return the entries for the page, which has the values among its arrays."""
        common = {"label": self.label, "symbols": list(self.symbols), "factor": self.factor}
        return {**common, "angles": True} if self.are_angles else common


def _of_body(motion: Trajectory, directions: Mapping[str, Orbit]) -> dict[str, Any]:
    """Return the content for one body."""
    units, rate = motion.system.units, np.linalg.norm(motion.omega_body, axis=-1)
    mean_rate = float(np.trapezoid(rate, motion.times) / (motion.times[-1] - motion.times[0]))
    around = surroundings_of(motion, _initial_speed(motion.times, mean_rate), directions)
    arrays = {**_moving(motion), **around.arrays}
    unit = rate_unit_of(units, None, rate)
    quantities = {
        "quaternion": PlottedQuantity("Euler parameters q", ["q₀", "q₁", "q₂", "q₃"], motion.quaternion),
        "momenta": PlottedQuantity(
            f"conjugate momenta Q{momentum_label(units)}", ["Q₀", "Q₁", "Q₂", "Q₃"], motion.conjugate_momenta
        ),
        "omega_body": PlottedQuantity(
            f"angular velocity ω, body axes{unit.label}", OMEGA_SYMBOLS, motion.omega_body, unit.factor
        ),
        "angular_momentum_space": PlottedQuantity(
            f"angular momentum G, space axes{momentum_label(units)}", ["G₁", "G₂", "G₃"], motion.angular_momentum_space
        ),
    }
    plotted = ["quaternion", "momenta"]
    if around.content.get("orbit", {}).get("moves"):
        angles = arrays["roll_pitch_yaw"] = _roll_pitch_yaw(motion, arrays["orbit_position"], arrays["orbit_velocity"])
        names = ("roll", "pitch", "yaw")
        quantities["roll_pitch_yaw"] = PlottedQuantity(
            "roll, pitch, yaw [deg]", names, angles, 180 / np.pi, are_angles=True
        )
        plotted = ["roll_pitch_yaw", "omega_body"]
    return {
        "rates": {"body": rate},
        "quantities": quantities,
        "plotted": plotted,
        "arrays": arrays,
        "around": around.content,
        "largest": {"omega": float(np.max(rate))},
        "mean_rate": mean_rate,
        "solids": _solids(motion),
        "plane": _invariable_plane(motion),
    }


def _roll_pitch_yaw(motion: Trajectory, position: Array, velocity: Array) -> Array:
    """Return roll, pitch and yaw for the axes of an orbit with these positions and velocities, radians; (n, 3)."""
    normal = np.cross(position, velocity)
    axes = [position, np.cross(normal, position), normal]
    frame = quaternion_from_matrix(np.stack([each / np.linalg.norm(each, axis=-1)[:, None] for each in axes], axis=-1))
    relative = quat.product(quat.conjugate(frame), motion.quaternion)
    # Roll and yaw are undefined at a pitch of 90 degrees: there the body is turned by what no plot shows.
    turned = [quat.product(relative, np.array([1.0, *(NUDGE * np.eye(3)[axis])])) for axis in (1, 2)]
    regular, second, third = (
        sine_of_attitudes(quat.product(quat.conjugate(LEVEL), q), "321") for q in (relative, *turned)
    )
    aside = np.where((second > third)[:, None], *turned)
    return roll_pitch_yaw(np.where((regular < NUDGE)[:, None], aside, relative))


def _ghost(other: Trajectory, sharing: int) -> dict[str, Any]:
    """Return the content for another motion."""
    arrays = _moving(other)
    rates = [np.linalg.norm(values, axis=-1) for name, values in arrays.items() if name.endswith("omega_body")]
    return rows_of(other.times, rates, arrays, sharing).encoded(arrays)


def _moving(motion: Trajectory) -> dict[str, Array]:
    """Return the positions and attitudes of the bodies, by the names on the page."""
    if not is_of_two_bodies(motion):
        return {"quaternion": motion.quaternion, "omega_body": motion.omega_body}
    arrays = {"position": motion.position, "velocity": motion.velocity}
    for name, one in motion.of_bodies.items():
        arrays |= {f"{name}_quaternion": one.quaternion, f"{name}_omega_body": one.omega_body}
    return arrays


def _of_pair(motion: Trajectory, directions: Mapping[str, Orbit]) -> dict[str, Any]:
    """Return the content for two bodies."""
    pair, distance = two_bodies(motion.system), motion.distance
    rates, bodies, largest, reach = {}, {}, {}, 0.0
    for (name, one), mass, sign in zip(motion.of_bodies.items(), pair.masses, (-1, 1), strict=True):
        rates[name] = np.linalg.norm(one.omega_body, axis=-1)
        largest[f"{name}_omega_body"] = float(np.max(rates[name])) or 1.0
        share = sign * (1 - mass / pair.total_mass)
        bodies[name] = _solid_of_mass(one.system.of_bodies[""], mass) | {"share": float(share)}
        reach = max(reach, abs(share) * float(np.max(distance)) + bodies[name]["radius"])
    turning = np.linalg.norm(np.cross(motion.position, motion.velocity), axis=-1) / distance**2
    mean_rate = float(np.trapezoid(turning, motion.times) / (motion.times[-1] - motion.times[0]))
    around = surroundings_of(motion, _initial_speed(motion.times, mean_rate), directions)
    arrays = {**_moving(motion), **around.arrays}
    arrays["libration"] = _libration(motion, bodies["secondary"])
    units = motion.system.units
    unit = rate_unit_of(units, None, list(rates.values()))
    quantities = {
        "distance": PlottedQuantity(
            f"distance of the centres of mass{bracketed(units.get('length', '1'))}", "r", distance[:, None]
        ),
        "libration": PlottedQuantity(
            "libration of the secondary [deg]",
            ("in longitude", "in latitude"),
            arrays["libration"],
            180 / np.pi,
            are_angles=True,
        ),
        **{
            f"{name}_omega_body": PlottedQuantity(
                f"angular velocity of the {name}{unit.label}", OMEGA_SYMBOLS, one.omega_body, unit.factor
            )
            for name, one in motion.of_bodies.items()
        },
    }
    return {
        "rates": rates,
        "quantities": quantities,
        "plotted": ["distance", "libration"],
        "arrays": arrays,
        "around": around.content,
        "largest": largest,
        "mean_rate": mean_rate,
        "bodies": bodies,
        "reach": reach,
    }


def _libration(motion: Trajectory, solid: dict[str, Any]) -> Array:
    """Return longitude and latitude of the line of centres, seen from the secondary, radians; shape (n, 2).

    They count from the longest axis of the secondary, whose two ends are alike, and from its equator.
    """
    axes = np.argsort(solid["semiaxes"])[::-1]
    towards = quat.rotate(quat.conjugate(motion.secondary.quaternion), -motion.position)
    long, middle, short = np.moveaxis(quat.rotate(quat.conjugate(np.asarray(solid["principal"])), towards), -1, 0)[axes]
    handed = np.linalg.det(np.eye(3)[axes])
    longitude = np.arctan2(handed * middle * np.sign(long), np.abs(long))
    return np.stack([longitude, np.arctan2(short, np.hypot(long, middle))], axis=-1)


def _solid_of_mass(body: Body, mass: float) -> dict[str, Any]:
    """Return the drawn shapes of one of two bodies, in the unit of length."""
    sides, (_, axes), shape = extents(body, mass), gyration_radii(body), _shape(body.shape)
    sides = np.maximum(sides, MIN_EXTENT * np.max(sides))
    radius = body.shape.circumscribing_radius if shape is not None and body.shape is not None else np.max(sides)
    return {
        "shape": shape,
        "radius": float(radius),
        "principal": quaternion_from_matrix(axes).tolist(),
        "semiaxes": sides.tolist(),
    }


def _initial_speed(times: Array, mean_rate: float) -> float:
    """Return the time that passes in a second at the initial speed of the page."""
    turn = 2 * np.pi / mean_rate if mean_rate else np.inf
    return min(turn / SECONDS_PER_TURN, abs(float(times[-1] - times[0])) / MIN_MOTION_SECONDS)


def _longest(vectors: Array) -> float:
    return float(np.max(np.linalg.norm(vectors, axis=-1)))


def _title_of(motion: Trajectory) -> str:
    """Return the title of the scenario, or the bodies, forces and duration: "Two bodies, mutual gravity, 10 days"."""
    if own := motion.provenance.get("title"):
        return str(own)
    bodies = "Two bodies" if len(motion.of_bodies) > 1 else "One body"
    forces = [in_words(type(force).__name__) for force in motion.system.forces] or ["free rotation"]
    span = time_unit_of(motion.system.units, None, motion.times)
    duration = f"{span.factor * np.ptp(motion.times):.3g} {DURATIONS.get(span.written, span.written)}"
    return textwrap.shorten(", ".join([bodies, *dict.fromkeys(forces), duration]), 300, placeholder=" ...")


def _labels(motion: Trajectory, rates: Mapping[str, Array]) -> dict[str, Any]:
    """Return the labels of the page, and the factors from the numbers of the motion to the units in the labels."""
    units = motion.system.units
    time, rate = time_unit_of(units, None, motion.times), rate_unit_of(units, None, list(rates.values()))
    words = {
        "angular_momentum_space": momentum_label(units),
        "omega_body": rate.label,
        "time": f"time{time.label}",
        "t": "t",
        "unit": "" if time.written == "1" else f" {time.written}",
    }
    return {"labels": words, "factors": {"time": time.factor, "omega_body": rate.factor}}


def _note(times: Array, rates: Mapping[str, Array]) -> str:
    """Return a warning if a body turns too far between stored times, otherwise no text."""
    turns = {name: np.max(np.maximum(rate[1:], rate[:-1]) * np.abs(np.diff(times))) for name, rate in rates.items()}
    fastest = max(turns, key=lambda name: turns[name])
    if turns[fastest] < np.pi:
        return ""
    return (
        f"Between two times of the page the {fastest} turns by up to {np.degrees(turns[fastest]):.0f}°, and what is "
        "shown there is a guess from the rates at both. Store more times, or view a part of the motion."
    )


def _solids(motion: Trajectory) -> dict[str, Any]:
    """Return the drawn shapes of a body along its principal axes, and the attitude of these axes in the body."""
    body = motion.system.of_bodies[""]
    moments, _ = principal(body)
    extent, axes = gyration_radii(body)
    return {
        "shape": _shape(body.shape),
        "principal": quaternion_from_matrix(axes).tolist(),
        "extent": np.maximum(extent / np.max(extent), MIN_EXTENT).tolist(),
        "inertia_ellipsoid": np.sqrt(2 * motion.kinetic_energy[0] / moments).tolist() if _rolls(motion) else None,
    }


def _shape(shape: Shape | None) -> list[dict[str, Any]] | None:
    """Return the parts of a shape from its centre of mass, within a unit sphere; None for a shape of another kind."""
    parts = parts_of(shape)
    if shape is None or parts is None:
        return None
    return [_part(part, shape.center_of_mass, 1 / shape.circumscribing_radius) for part in parts]


def _part(part: Any, center: Array, scale: float) -> dict[str, Any]:
    """Return the appearance of one part, with all lengths multiplied by a scale."""
    if isinstance(part, Mesh):
        return {"triangles": packed(scale * (part.vertices - center)[part.faces])}
    if isinstance(part, Mascons):
        heaviest = np.sort(np.argsort(part.masses)[-MAX_SPHERES:])
        sizes = min(MAX_SPHERE, 0.6 / np.cbrt(heaviest.size)) * np.cbrt(part.masses[heaviest] / np.max(part.masses))
        return {"spheres": packed(np.column_stack([scale * (part.positions[heaviest] - center), sizes]))}
    sides = part.semiaxes if isinstance(part, Ellipsoid) else (part.radius, part.radius, part.height / 2)
    return {
        "solid": "ellipsoid" if isinstance(part, Ellipsoid) else "cylinder",
        "sides": (scale * np.asarray(sides)).tolist(),
        "place": (scale * (part.center_of_mass - center)).tolist(),
        "turn": quaternion_from_matrix(part._axes).tolist(),
    }


def _invariable_plane(motion: Trajectory) -> dict[str, Any] | None:
    """Return the plane omega . G = 2T and the radius of a disc around the herpolhode; None without such a plane."""
    G, omega = motion.angular_momentum_space, motion.omega_space
    if not (_rolls(motion) and is_constant(G)):
        return None
    size = float(np.linalg.norm(G[0]))
    normal, height = G[0] / size, 2 * float(motion.kinetic_energy[0]) / size
    reach = float(np.max(np.linalg.norm(omega - np.outer(omega @ normal, normal), axis=-1)))
    return {"normal": normal.tolist(), "height": height, "radius": max(1.15 * reach, 0.5 * height)}


def _rolls(motion: Trajectory) -> bool:
    """Return True if the polhode lies on an inertia ellipsoid."""
    if motion.system.parts:
        return False
    energy = motion.kinetic_energy
    return bool(energy[0] > 0 and is_constant(energy[:, None]))
