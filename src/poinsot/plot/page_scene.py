"""Surroundings of a body on the page of the 3D view: orbit, Sun, torques, fields, wheels, facets and events."""

from __future__ import annotations

import datetime as dt
import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from poinsot.forces.facets import Facets
from poinsot.forces.magnetic_fields import MagneticField
from poinsot.forces.radiation import Occulter, Sunlight
from poinsot.functions import Vector
from poinsot.kinematics.state import state_of
from poinsot.mechanics.environment import Orbit, within
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import Part
from poinsot.orbits.attractors import MU, RADIUS
from poinsot.parts.rotors import Wheel
from poinsot.parts.wheels import ReactionWheels
from poinsot.plot.labels import different_orbits, in_words, momentum_label, torque_unit_of
from poinsot.plot.page_arrays import packed
from poinsot.plot.solid_parts import facet_corners
from poinsot.propagation.trajectory import Trajectory, is_of_two_bodies
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS
from poinsot.records.parameters import same

__all__ = ["NO_ORBITS", "Surroundings", "calendar_of", "events_of", "surroundings_of", "towards"]

TORQUES = ("#882255", "#44AA99", "#332288", "#AA4499", "#117733", "#999933")
"""Colours of torques from Tol's muted scheme; only so many of the largest torques are drawn."""
FIELDS = ("#56B4E9", "#0072B2")
MOMENTA = ("#B15928", "#6A3D9A")

NO_ORBITS: Mapping[str, Orbit] = {}

MU_TOLERANCE = 1e-3
"""Largest relative difference between the gravitational parameter of an attractor and of a known body."""
METRES_PER_KILOMETRE = 1000.0
"""Metres in a kilometre. In a unit of length 1000 times smaller, mu is 1000^3 times its value in km."""

MAX_EVENTS = 1000
"""Largest number of events of one kind on the time line."""

MAX_FACETS = 1000
"""Largest number of drawn facets. More facets belong to a mesh, which the page draws itself."""


FASTEST_WHEEL = np.pi
"""Largest angular velocity of a wheel on the page, radians per second."""


class Surroundings(NamedTuple):
    """Surroundings of a body: the content for the page, and its arrays at the stored times."""

    content: dict[str, Any]
    arrays: dict[str, Array]


def surroundings_of(motion: Trajectory, speed: float, directions: Mapping[str, Orbit] = NO_ORBITS) -> Surroundings:
    """Return the surroundings of a body or a pair.

    `speed` is the time that passes on the page in a second. `directions` are the orbits from the Sun ("sun") and from
    the observer ("observer"), towards which arrows point.
    """
    found = Surroundings({"vectors": []}, {})
    state = state_of(motion.phase, motion.times)
    instant = motion.system.dynamics.broadcast_to(state.shape).at(state, motion.environment)
    _add_orbit(found, motion)
    _add_sun(found, motion, instant, directions.get("sun"))
    if "observer" in directions:
        found.arrays["observer"] = towards(motion, "observer", directions["observer"])
    found.content["arrows"] = list(directions)
    if is_of_two_bodies(motion):
        return found
    _add_torques(found, motion)
    _add_fields(found, motion, instant)
    _add_momenta(found, motion)
    found.content["facets"] = next(map(_polygons, _within(motion, Facets)), None)
    _add_wheels(found, motion, speed)
    return found


# ---------------------------------------------------------------------- orbit and Sun


def _add_orbit(found: Surroundings, motion: Trajectory) -> None:
    """Add the orbit about the attractor with the largest gravity gradient, and the size of this attractor."""
    suns = [force.sun for force in _within(motion, Sunlight)]
    orbits = different_orbits(motion)
    orbits = [orbit for orbit in orbits if not any(same(orbit, sun) for sun in suns)] or orbits
    if not orbits:
        return
    places = [_rows(motion.environment.position(orbit), motion) for orbit in orbits]
    gradients = [_mu(orbit) / np.linalg.norm(place[0]) ** 3 for orbit, place in zip(orbits, places, strict=True)]
    orbit, position = orbits[int(np.argmax(gradients))], places[int(np.argmax(gradients))]
    velocity = _rows(motion.environment.velocity(orbit), motion)
    distance = np.linalg.norm(position, axis=-1)
    across = np.linalg.norm(np.cross(position, velocity), axis=-1)
    name, radius = _attractor(orbit, motion)
    nearest = float(np.min(distance))
    passes = radius is not None and nearest <= radius
    found.content["orbit"] = {
        "attractor": name,
        "radius": None if passes else radius,
        "size": "drawn small, the orbit enters it" if passes else "" if radius else "its size is unknown",
        "lit": bool(suns) and not any(same(orbit, sun) for sun in suns),
        "nearest": nearest,
        "farthest": float(np.max(distance)),
        "moves": bool(np.all(across > 0)),
        "mean_rate": float(np.mean(across / distance**2)),
        "unit": motion.system.units.get("length", ""),
    }
    found.arrays["orbit_position"], found.arrays["orbit_velocity"] = position, velocity


def _attractor(orbit: Orbit, motion: Trajectory) -> tuple[str, float | None]:
    """Return the name of an attractor, and its radius in the unit of the orbit if it is known."""
    occulters = [each for each in _within(motion, Occulter) if same(each.orbit, orbit)]
    radius = float(occulters[0].radius) if occulters else None
    second = 1 / SECONDS.get(motion.system.units["time"], 1.0)
    for name, mu in MU.items():
        ratio = _mu(orbit) * second**2 / mu
        for unit in (1.0, METRES_PER_KILOMETRE):
            if name in RADIUS and abs(ratio / unit**3 - 1) < MU_TOLERANCE:
                return name.capitalize(), radius or RADIUS[name] * unit
    return orbit.origin if orbit.origin.islower() else orbit.origin.capitalize(), radius


def _mu(orbit: Orbit) -> float:
    return float(np.ravel(np.asarray(orbit.mu))[0])


def _add_sun(found: Surroundings, motion: Trajectory, instant: Instant, sun: Orbit | None) -> None:
    """Add the direction to the Sun, and the part of its disc that occulters leave visible."""
    force = next(iter(_within(motion.system.dynamics.broadcast_to(motion.times.shape), Sunlight)), None)
    if sun is None and force is not None:
        sun = force.sun
    if sun is None:
        return
    found.arrays["sun"] = towards(motion, "sun", sun)
    found.content.update(sun=True, sunlight=force is not None and bool(force.occulters))
    if force is not None and force.occulters:
        found.arrays["sunlight"] = _rows([force.sunlight(instant)], motion)


def towards(motion: Trajectory, name: str, orbit: Orbit) -> Array:
    """Return the unit vectors from the body to the attractor of an orbit at the times of a motion; shape (n, 3)."""
    if orbit.member_axis:
        raise ValueError(f"{name} must be one orbit, got {orbit.member_axis[0]} members. Pass the orbit of one member.")
    position = _rows(motion.environment.position(orbit), motion)
    return np.asarray(-position / np.linalg.norm(position, axis=-1, keepdims=True))


# ---------------------------------------------------------------------- vectors


def _add_torques(found: Surroundings, motion: Trajectory) -> None:
    """Add the torques of the forces, along the body axes, on one scale."""
    torques = {name: torque for name, torque in motion.torques_body.items() if np.any(torque)}
    largest = {name: float(np.max(np.linalg.norm(torque, axis=-1))) for name, torque in torques.items()}
    unit = torque_unit_of(motion.system.units).label
    for i, name in enumerate(sorted(torques, key=largest.__getitem__, reverse=True)[: len(TORQUES)]):
        own = {"letter": f"τ{'₁₂₃₄₅₆'[i]}", "name": f"torque of {in_words(name)}", "colour": TORQUES[i], "unit": unit}
        _add_vector(found, f"torque_{i}", torques[name], own, max(largest.values()))


def _add_fields(found: Surroundings, motion: Trajectory, instant: Instant) -> None:
    """Add magnetic fields at the position of the body."""
    fields: list[MagneticField] = []
    for field in _within(motion.system.dynamics.broadcast_to(motion.times.shape), MagneticField):
        if not any(same(field, known) for known in fields):
            fields.append(field)
    for i, field in enumerate(fields[: len(FIELDS)]):
        values = _rows(field.in_body(instant), motion)
        own = {"letter": "B", "name": "magnetic field", "colour": FIELDS[i], "unit": " [T]"}
        _add_vector(found, f"field_{i}", values, own, float(np.max(np.linalg.norm(values, axis=-1))))


def _add_momenta(found: Surroundings, motion: Trajectory) -> None:
    """Add the angular momenta of parts relative to the body."""
    moving = [part for part in motion.system.parts if type(part).momentum is not Part.momentum]
    unit = momentum_label(motion.system.units)
    for i, part in enumerate(moving[: len(MOMENTA)]):
        own = Vector(np.moveaxis(motion.own[part.name], -1, 0) if part.name in motion.own else ())
        values = _rows(part.momentum(own, motion.times), motion)
        named = {
            "letter": "h",
            "name": f"momentum of {part.name.replace('_', ' ')}",
            "colour": MOMENTA[i],
            "unit": unit,
        }
        _add_vector(found, f"momentum_{i}", values, named, float(np.max(np.linalg.norm(values, axis=-1))))


def _add_vector(found: Surroundings, array: str, values: Array, own: dict[str, str], largest: float) -> None:
    if largest > 0:
        found.arrays[array] = values
        found.content["vectors"].append({"array": array, "largest": largest, **own})


# ---------------------------------------------------------------------- facets and wheels


def _polygons(facets: Facets) -> dict[str, Any] | None:
    """Return facets as squares of their areas, within a unit sphere, with their shares of light."""
    if facets.count > MAX_FACETS:
        return None
    corners = facet_corners(facets)
    size = np.max(np.linalg.norm(corners, axis=-1)) or 1.0
    shares = np.stack([facets.specular, facets.diffuse], axis=-1)
    return {"corners": packed((corners / size).reshape(-1, 3)), "shares": shares.tolist(), "size": float(size)}


def _add_wheels(found: Surroundings, motion: Trajectory, speed: float) -> None:
    """Add the wheels with axes fixed in the body, and their angles, slowed down to a visible rate."""
    wheels = list(_speeds_of_wheels(motion))
    if not wheels:
        return
    axes, speeds = (np.concatenate(each, axis=-1) for each in zip(*wheels, strict=True))
    slower = _round_number(float(np.max(np.abs(speeds))) * speed / FASTEST_WHEEL)
    steps = 0.5 * (speeds[1:] + speeds[:-1]) * np.diff(motion.times)[:, None]
    found.arrays["wheel_angles"] = np.cumsum(np.vstack([0 * speeds[:1], steps]), axis=0) / slower
    found.content["wheels"] = {"axes": axes.T.tolist(), "slower": slower}


def _speeds_of_wheels(motion: Trajectory) -> Iterator[tuple[Array, Array]]:
    """Yield axes as columns, and at all times the speeds relative to the body."""
    for part in motion.system.parts:
        if isinstance(part, ReactionWheels):
            yield np.transpose(part.axes), part.speeds(motion.own[part.name], motion.omega_body)
        elif isinstance(part, Wheel):
            yield np.reshape(part.axis, (3, 1)), part.speed(motion.own[part.name], motion.omega_body)[:, None]


def _round_number(least: float) -> int:
    """Return the first of 1, 2, 5, 10, 20, 50, ... that is not less than a number."""
    rounds: Iterator[int] = (k * 10**power for power in itertools.count() for k in (1, 2, 5))
    return next(each for each in rounds if each >= least)


# ---------------------------------------------------------------------- time


def events_of(motion: Trajectory) -> list[dict[str, Any]]:
    """Return the events of a motion by name, with their times."""
    found = []
    for record in motion.events:
        times, directions = record.times[:MAX_EVENTS], record.directions[:MAX_EVENTS]
        order = np.argsort(times)
        name = type(record.event).__name__
        found.append({"name": name, "times": times[order].tolist(), "directions": directions[order].tolist()})
    return found


def calendar_of(motion: Trajectory) -> dict[str, Any] | None:
    """Return time 0 in milliseconds since 1970 in a time scale, and the unit of time in milliseconds.

    In UTC the first time is exact; later times are exact if no leap second is inserted.
    """
    calendar = motion.calendar
    if calendar is None:
        return None
    zero = _milliseconds(calendar.zero)
    if calendar.scale == "UTC":
        try:
            first = calendar.date(motion.times[0])
        except ImportError:
            return None
        zero = _milliseconds(first.isot) - motion.times[0] * 1000 * SECONDS[calendar.unit]
    return {"zero": zero, "unit": 1000 * SECONDS[calendar.unit], "scale": calendar.scale}


def _milliseconds(date: str) -> float:
    day, _, clock = date.partition("T")
    hours, minutes, seconds = clock.split(":")
    days = (dt.date.fromisoformat(day) - dt.date(1970, 1, 1)).days
    return 1000 * (86400.0 * days + 3600 * int(hours) + 60 * int(minutes) + float(seconds))


# ---------------------------------------------------------------------- reading


def _within(record: Any, kind: Any) -> Iterator[Any]:
    """Yield the objects of a class among the forces of a motion or a system and their fields."""
    system = record.system if isinstance(record, Trajectory) else record
    return (each for force in system.forces for each in within(force) if isinstance(each, kind))


def _rows(vector: Any, motion: Trajectory) -> Array:
    """Return the components of a vector at the times of a motion; shape (n, 3)."""
    return np.stack([np.broadcast_to(np.asarray(x, dtype=float), motion.times.shape) for x in vector], axis=-1)
