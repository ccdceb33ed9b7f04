"""Parts of a scenario, made from its text. Every error names the file, the line and the key."""

from __future__ import annotations

import datetime as dt
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from poinsot.algebra import quaternion as quat
from poinsot.errors import member_array, real_numbers, refuse_other_members
from poinsot.integration.settings import checked_tolerance
from poinsot.kinematics.attitude import quaternion_from_matrix, unit_quaternion
from poinsot.kinematics.euler import quaternion_from_angles
from poinsot.kinematics.frame import Frame, RelativeOrbitFrame, from_roll_pitch_yaw
from poinsot.kinematics.state import AnyState, PairState, State
from poinsot.mechanics.body import Body
from poinsot.mechanics.two_bodies import BODIES, TwoBodies
from poinsot.observables.readings import Readings
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.calendar import SECONDS, Calendar, holds_dates
from poinsot.scenarios.errors import MISSING, Errors, has, maker_at
from poinsot.scenarios.folder import Folder
from poinsot.scenarios.registry import RENAMED, RENAMED_TYPES, Group, Key, default_of, makers
from poinsot.scenarios.schema import MAX_TIMES, STARTS, STATE, converted, scenario_model, short
from poinsot.scenarios.toml_text import Path, parsed_toml
from poinsot.suggestions import nearest
from poinsot.systems.system import System, is_of_two_bodies
from poinsot.systems.times_and_states import check_span, checked_times, common_members

__all__ = ["Parts"]

FROM = ("from_primary", "from_secondary")
"""Endings of references to the orbits about the two attractors of a path."""

RATES = ("omega_body", "omega_space", "angular_momentum_body", "angular_momentum_space")
ORBIT = ("position", "velocity")
OF_TWO = {*ORBIT, *BODIES, *STARTS, "elements", "kick"}
"""Keys of the state of two bodies."""

AT_REST: dict[str, Any] = {"attitudes": [(1.0, 0.0, 0.0, 0.0)] * 2, "omega_body": [(0.0, 0.0, 0.0)] * 2}


PAIRS = {"conjugate_momenta": ("quaternion",), "euler_momenta": ("euler_angles", "sequence")}
"""Keys that momenta require, and the sequence of Euler angles."""

ATTITUDES = ("quaternion", "matrix", "euler_angles", "roll_pitch_yaw")

MAX_ROWS = 100_000_000
"""Times of all members together."""

MAX_DRAWN = 10_000_000
"""Numbers in the place of one."""

VARIED = ("body", "state", "forces", "orbits", "observe")
"""Tables whose numbers an ensemble can vary."""

STAND_IN: dict[str, Any] = {"state": {}, "times": {}}


class Parts:
    """Checked contents of a scenario, and the parts of a propagation that it describes.

    Errors begin with the name of the file. `whole` texts must contain state and times. The folder contains the files,
    and the data contain the arrays, that the text names.
    """

    def __init__(
        self,
        text: str,
        name: str,
        whole: bool = True,
        *,
        folder: Folder | None = None,
        data: Mapping[str, Any] | None = None,
    ) -> None:
        self._errors, self._folder = Errors(name, text), folder or Folder(None)
        read = _with_present_names(parsed_toml(text, name))
        for table in ("body", "state", "times"):
            if isinstance(read.get(table), list):
                raise self._errors.at((table,), f"must be one table, got a list. A scenario has one: [{table}].")
        self._calendar_of(read)
        given = read if whole else {**STAND_IN, **read}
        try:
            model = scenario_model().model_validate(given, context={"time_unit": self.time_unit, "data": data})
        except ValidationError as error:
            raise self._errors.from_pydantic(error, read) from None
        self.values: dict[str, Any] = model.model_dump(exclude_unset=True)
        self._made: dict[str, Any] = {}
        self._making: list[str] = []
        self._turns: dict[Path, Array] = {}
        self._spread()

    # ------------------------------------------------------------------ calendar and ensemble

    def _calendar_of(self, data: dict[str, Any]) -> None:
        """Find the unit of time, and the calendar of the times."""
        units, calendar = data.get("units"), data.get("calendar")
        unit = units.get("time") if isinstance(units, dict) else None
        self.calendar: Calendar | None = None
        if isinstance(calendar, dict) and {"zero", "scale"} <= set(calendar) <= {"zero", "scale", "unit"}:
            self.calendar = self._errors.called(("calendar",), _calendar, **calendar)
            if unit not in (None, self.calendar.unit):
                rule = f"must be the unit of the calendar, {self.calendar.unit}"
                raise self._errors.at(("units", "time"), f"{rule}, got {short(unit)}.")
            unit = self.calendar.unit
        self.time_unit = unit if isinstance(unit, str) and unit in SECONDS else None

    def _spread(self) -> None:
        """Draw the members of the ensemble, and put them in the places of the numbers that vary."""
        ensemble = self.values.get("ensemble")
        if not ensemble:
            return
        random, members = np.random.default_rng(ensemble["seed"]), ensemble["members"]
        for i, spread in enumerate(ensemble["spread"]):
            place: Path = ("ensemble", "spread", i)
            table, key, kind = self._target(spread["of"], place)
            value = np.zeros(3) if key == "turn" else np.asarray(table[key], dtype=float)
            if members * value.size > MAX_DRAWN:
                rule = f"must make at most {MAX_DRAWN} numbers of one"
                raise self._errors.at(("ensemble", "members"), f"{rule}, got more with {members}.")
            drawn = self._drawn(random, {**spread, "kind": kind}, value, members, place)
            if key == "turn":
                self._turns[tuple(spread["of"].split(".")[:-1])] = drawn
            else:
                table[key] = drawn

    def _drawn(self, random: Any, spread: dict[str, Any], value: Array, members: int, place: Path) -> Array:
        """Return members of a number or of several, by the distribution of one spread."""
        distribution, shape = spread.get("distribution"), (members, *value.shape)
        if distribution == "isotropic":
            return self._any_turn(random, spread, members, place)
        if spread.get("size") is None:
            raise self._errors.at((*place, "size"), MISSING)
        try:
            size = real_numbers("size", converted(spread["size"], spread["kind"], self.time_unit, "size"))
            size = np.broadcast_to(size, value.shape)
        except (TypeError, ValueError) as error:
            rule = "size must be one number, or one for each component, got others: "
            rule = "" if str(error).startswith("size") else rule
            raise self._errors.prefixed((*place, "size"), f"{rule}{error}") from None
        if np.any(size < 0):
            raise self._errors.at((*place, "size"), f"must not be negative, got {np.min(size):g}.")
        drawn = random.uniform(-1, 1, shape) if distribution == "uniform" else random.standard_normal(shape)
        return np.asarray(value + size * drawn)

    def _any_turn(self, random: Any, spread: dict[str, Any], members: int, place: Path) -> Array:
        """Return rotation vectors of turns in any direction by any angle, each attitude as likely as another."""
        if spread["of"] not in self._turnings:
            rule = f"must be {' or '.join(self._turnings)} if it is isotropic"
            raise self._errors.at((*place, "of"), f"{rule}, got {quoted(spread['of'])}.")
        if spread.get("size") is not None:
            raise self._errors.at((*place, "size"), "must not be given together with isotropic, got both.")
        return np.asarray(Rotation.from_quat(random.standard_normal((members, 4))).as_rotvec())

    def _target(self, path: str, place: Path) -> tuple[Any, Any, str]:
        """Return the table, the key and the kind of the number at a path such as state.omega_body."""
        if path in self._turnings:
            return self.values["state"], "turn", "angle"
        words = path.replace("[", ".").replace("]", "").split(".")
        parts = [int(word) if word.isdecimal() and len(word) < 6 else word for word in words]
        node: Any = self.values if parts[0] in VARIED else {}
        for part in parts[:-1]:
            node = node[part] if has(node, part) else {}
        if isinstance(node, dict):
            parts[-1] = RENAMED.get((str(node.get("type")), str(parts[-1])), parts[-1])
        if not has(node, parts[-1]) or not isinstance(node[parts[-1]], np.ndarray):
            near = nearest(path, _places(self.values))
            raise self._errors.at((*place, "of"), f"must be the place of a number, got {short(path)}.{near}")
        if node[parts[-1]].dtype.kind != "f":
            raise self._errors.at((*place, "of"), f"must be the place of a number, got {short(path)}, a date.")
        *outer, last = parts
        if outer == ["state", "own"]:
            return node, last, "number"
        if outer[0] != "state":
            keys = maker_at(self.values, tuple(outer)).keys
        else:
            keys = next(key.keys for key in STATE if key.name == outer[1]) if outer[1:] else STATE
        return node, last, next(key.kind for key in keys if key.name == last)

    @property
    def _turnings(self) -> list[str]:
        """The names of the turns of attitudes that an ensemble can have: of the body, or of each of two."""
        bodies = [body for body in BODIES if body in self.values["state"]]
        return [f"state.{body}.turn" for body in bodies] or ["state.turn"]

    # ------------------------------------------------------------------ parts

    def system(self) -> System:
        """Return the body and the forces on it."""
        body = self._part("body", self.values["body"], ("body",))
        forces = [self._part("force", table, ("forces", i)) for i, table in enumerate(self.values.get("forces", []))]
        for name in self.values.get("orbits", {}):
            self._orbit(name, ("orbits", name))
        units = self.values.get("units")
        if self.calendar is not None:
            units = {"time": self.calendar.unit, **(units or {})}
        try:
            return System(body, *forces, units=units)
        except (TypeError, ValueError):
            place = self._refused(body, forces)
            system: System = self._errors.called(place, lambda: System(body, *forces, units=units))
            return system

    def _refused(self, body: Any, forces: list[Any]) -> Path:
        """Return the place of what makes no system with a body: a force, or all together."""
        for i, force in enumerate(forces):
            try:
                System(body, force)
            except (TypeError, ValueError) as error:
                if (
                    isinstance(error, TypeError)
                    and isinstance(body, TwoBodies)
                    and "on" not in self.values["forces"][i]
                ):
                    rule = f"must be given for {type(force).__name__}, which acts on one body"
                    raise self._errors.at(("forces", i, "on"), f"{rule}, got none.") from None
                return "forces", i
        return ("forces",) if forces else ("body",)

    def _part(self, group: Group, table: dict[str, Any], place: Path) -> Any:
        """Return the part of a scenario that a table describes."""
        maker = makers(group)[table.get("type") or str(default_of(group))]
        keys = [key for key in maker.keys if key.name in table]
        values = {key.name: self._value(key, table[key.name], (*place, key.name)) for key in keys}
        arguments = [one for key in keys if key.spread for one in values.pop(key.name)]
        if maker.takes_calendar and self.calendar is not None:
            values["calendar"] = self.calendar
        return self._errors.called(place, maker.call, *arguments, **values)

    def _value(self, key: Key, value: Any, place: Path) -> Any:
        if key.kind in ("record", "record or records", "orbit") and isinstance(value, dict):
            return self._part(key.group, value, place)
        if key.kind in ("orbit", "orbits"):
            return self._orbit(value, place) if key.kind == "orbit" else [self._orbit(name, place) for name in value]
        if key.kind.endswith("records"):
            return [self._part(key.group, table, (*place, i)) for i, table in enumerate(value)]
        if key.kind in ("file", "files"):
            try:
                return self._folder.file(value) if key.kind == "file" else [self._folder.file(name) for name in value]
            except ValueError as error:
                raise self._errors.at(place, str(error)) from None
        if key.kind == "time" and holds_dates(value) and self.calendar is not None:
            return self._errors.called(place[:-1], self.calendar.time, value)
        return value

    def _orbit(self, reference: str, place: Path) -> Any:
        """Return the orbit of a name, or the orbit about one of the two attractors of a path."""
        name, _, side = reference.partition(".")
        tables = self.values.get("orbits", {})
        if name not in tables:
            known = nearest(name, tables) or (
                f" Known tables are {', '.join(tables)}." if tables else " The scenario contains none."
            )
            raise self._errors.at(place, f"must be the name of a table under orbits, got {short(reference)}.{known}")
        if name in self._making:
            raise self._errors.at(
                place, f"must be an orbit that does not require this orbit, got {short(name)}, which requires it."
            )
        if name not in self._made:
            self._making.append(name)
            self._made[name] = self._part("orbit", tables[name], ("orbits", name))
            self._making.pop()
        orbit = self._made[name]
        if side and (side not in FROM or not hasattr(orbit, side)):
            rule = f"must be an orbit, or {' or '.join(FROM)} of a path near two attractors"
            raise self._errors.at(place, f"{rule}, got {short(reference)}.")
        return getattr(orbit, side) if side else orbit

    # ------------------------------------------------------------------ the state

    def state(self, system: System) -> AnyState:
        """Return the state from which the motion starts."""
        state, place = self._state(system), ("state",)
        self._errors.called(place, system.at, state)
        return state

    def _state(self, system: System) -> AnyState:
        table, place = self.values["state"], ("state",)
        time = self._time(table.get("time", 0.0), ("state", "time"))
        if is_of_two_bodies(system):
            return self._state_of_two(system, table, time)
        for name in table.keys() & OF_TWO:
            raise self._errors.at((*place, name), "must be given for two bodies only, got one body.")
        own = self._errors.called((*place, "own"), system.dynamics.given_parts, **table.get("own", {}))
        frame = self._frame(table["frame"]) if "frame" in table else None
        return self._rotation(system, place, time, frame, own)

    def _state_of_two(self, system: System[TwoBodies], table: dict[str, Any], time: Any) -> AnyState:
        """Return the state of two bodies: one of `STARTS`, or their orbit and the rotation of each."""
        start, pair, called = next((name for name in STARTS if name in table), None), system.body, self._errors.called
        state: AnyState
        if start:
            self._only(("state",), (start, "time", "kick"), start)
            state = called(("state", start), getattr(pair, start), **table[start], time=time)
        else:
            state = self._started(pair, table, time)
        if "kick" in table:
            state = called(("state", "kick"), pair.kick, state, **table["kick"])
        return state

    def _started(self, pair: TwoBodies, table: dict[str, Any], time: Any) -> AnyState:
        """Return the state with an orbit by position and velocity or by elements, and with two rotations."""
        of_orbit = ("elements",) if "elements" in table else ORBIT
        self._only(("state",), (*of_orbit, *BODIES, "time", "frame", "kick"), of_orbit[0])
        for name in (*of_orbit, *BODIES):
            if name not in table:
                raise self._errors.at(("state", name), MISSING)
        if "elements" in table:
            orbit = self._errors.called(("state", "elements"), KeplerOrbit, pair.mu, **table["elements"])
            there = self._errors.called(("state",), pair.state_on, orbit, **AT_REST, time=time)
        else:
            place = {name: table[name] for name in ORBIT}
            there = self._errors.called(("state",), _moving, pair, **place, time=time)
        frame = self._frame(table["frame"], there, pair) if "frame" in table else None
        each = {name: self._rotation(body, ("state", name), time, frame) for name, body in pair.bodies.items()}
        state: PairState = self._errors.called(("state",), PairState, there.position, there.momentum, **each)
        return state

    def _rotation(
        self, owner: System | Body, place: Path, time: Any, frame: Frame | None, own: Mapping[str, Any] | None = None
    ) -> State:
        """Return the attitude and the momentum of a body, from the table at a place."""
        table, own = self._table(place), own or {}
        for momenta, names in PAIRS.items():
            if momenta in table:
                return self._canonical(place, momenta, names, time, own)
        rates = {name: table[name] for name in RATES if name in table}
        options = {**rates, "time": time, "frame": frame, **own}
        state: State = self._errors.called(place, owner.state, self._attitude(place), **options)
        return state

    def _table(self, place: Path) -> dict[str, Any]:
        node: Any = self.values
        for part in place:
            node = node[part]
        table: dict[str, Any] = node
        return table

    def _canonical(self, place: Path, momenta: str, names: tuple[str, ...], time: Any, own: Any) -> State:
        """Return the state of coordinates and their momenta, which no ensemble can turn: the momenta would turn too."""
        table = self._table(place)
        if names[0] not in table:
            raise self._errors.at((*place, names[0]), MISSING)
        self._only(place, (*names, momenta, "time", "own"), momenta)
        if place in self._turns:
            raise self._errors.at(place, "must have a rate or an angular momentum where its attitude is spread.")
        state: State
        if momenta == "conjugate_momenta":
            pair = {name: table[name] for name in (names[0], momenta)}
            state = self._errors.called(place, State, **pair, time=time, own=own)
        else:
            sequence = table.get("sequence", "313")
            state = self._errors.called(place, State.from_euler, table[names[0]], table[momenta], sequence, time, own)
        return state

    def _only(self, place: Path, names: Iterable[str], other: str) -> None:
        """Raise a ValueError for a key of a table that another key excludes."""
        for name in self._table(place):
            if name not in names:
                raise self._errors.at((*place, name), f"must not be given together with {other}, got both.")

    def _attitude(self, place: Path) -> Array:
        table = self._table(place)
        given = [name for name in ATTITUDES if name in table]
        if len(given) != 1:
            rule = f"must have exactly one of {', '.join(ATTITUDES)}"
            raise self._errors.at(place, f"{rule}, got {' and '.join(given) or 'none'}.")
        (name,) = given
        if "sequence" in table and name != "euler_angles":
            raise self._errors.at((*place, "sequence"), "must be given together with euler_angles, got none.")
        frame = self.values["state"].get("frame", "")
        of_pair = len(place) > 1 and frame == "orbit"
        if name == "roll_pitch_yaw" and not of_pair and frame.partition(".")[0] not in self.values.get("orbits", {}):
            raise self._errors.at(("state", "frame"), "must be an orbit where roll_pitch_yaw is given, got none.")
        ways: dict[str, Callable[..., Any]] = {
            "quaternion": lambda quaternion: unit_quaternion(quaternion, "quaternion"),
            "matrix": quaternion_from_matrix,
            "euler_angles": lambda euler_angles: quaternion_from_angles(
                member_array(name, euler_angles, (3,)), table.get("sequence", "313")
            ),
            "roll_pitch_yaw": lambda roll_pitch_yaw: from_roll_pitch_yaw(member_array(name, roll_pitch_yaw, (3,))),
        }
        q = self._errors.called(place, ways[name], **{name: table[name]})
        if place not in self._turns:
            return np.asarray(q)
        return quat.product(q, np.asarray(Rotation.from_rotvec(self._turns[place]).as_quat(scalar_first=True)))

    def _frame(self, reference: str, there: Any = None, pair: Any = None) -> Frame:
        """Return the axes of a name. The name of the axes of the mutual orbit of two bodies is "orbit"."""
        if there is not None and reference == "orbit":
            velocity = there.momentum / np.asarray(pair.reduced_mass)[..., None]
            return RelativeOrbitFrame(lambda _: (there.position, velocity, np.zeros(3)))
        frames, place = self.values.get("frames", {}), ("state", "frame")
        if reference in frames:
            frame: Frame = self._part("frame", frames[reference], ("frames", reference))
            return frame
        if frames and reference.partition(".")[0] not in self.values.get("orbits", {}):
            known = nearest(reference, [*frames, *self.values.get("orbits", {})])
            rule = "must be the name of a table under frames or orbits"
            raise self._errors.at(place, f"{rule}, got {short(reference)}.{known}")
        orbit = self._orbit(reference, place)
        found: Frame = self._errors.called(place, lambda: orbit.frame)
        return found

    # ------------------------------------------------------------------ times, run, outputs

    def _time(self, value: Any, place: Path, calendar: Calendar | None = None) -> Any:
        """Return a time, or times, from dates too."""
        if not holds_dates(value):
            return value
        calendar = calendar or self.calendar
        if calendar is None:
            raise self._errors.at(place, f"must be a number where there is no calendar, got {short(value)}.")
        return self._errors.called(place[:-1], calendar.time, value)

    def times(self, system: System, state: AnyState) -> Array:
        """Return the times at which the motion is wanted."""
        table, calendar = self.values["times"], system.calendar
        named = [name for name in ("start", "stop", "step", "periods", "values") if name in table]
        read = {name: self._time(table[name], ("times", name), calendar) for name in named}
        for name in named:
            if np.ndim(read[name]) != (name == "values"):
                rule = "a list of times" if name == "values" else "one number"
                raise self._errors.at(("times", name), f"must be {rule}, got shape {np.shape(read[name])}.")
        if "values" in read:
            self._only(("times",), ("values",), "values")
            times = self._errors.called(("times", "values"), checked_times, np.asarray(read["values"], dtype=float))
        else:
            start = read.get("start", np.ravel(state.time)[0])
            times = self._grid(float(start), self._stop(float(start), read, table), table)
        self._errors.called(("times",), check_span, system, state, times)
        members = (self._errors.called(("state",), common_members, system, state) or (1,))[0]
        if times.size * members > MAX_ROWS:
            count = times.size * members
            raise self._errors.at(("times",), f"must be at most {MAX_ROWS} with all members, got {count}.")
        return np.asarray(times)

    def _stop(self, start: float, read: dict[str, Any], table: dict[str, Any]) -> float:
        if ("stop" in table) == ("periods" in table):
            raise self._errors.at(("times",), "must have one of stop and periods, or values.")
        if "stop" in table:
            return float(read["stop"])
        if "orbit" not in table:
            raise self._errors.at(("times", "orbit"), "must be given together with periods, got none.")
        orbit = self._orbit(table["orbit"], ("times", "orbit"))
        period = np.ravel(getattr(orbit, "period", math.nan))
        if not np.isfinite(period[0]) or period.size > 1:
            raise self._errors.at(("times", "orbit"), f"must have one period, got none for {short(table['orbit'])}.")
        return start + float(table["periods"]) * float(period[0])

    def _grid(self, start: float, stop: float, table: dict[str, Any]) -> Array:
        if ("count" in table) == ("step" in table):
            raise self._errors.at(("times",), "must have one of count and step, or values.")
        if "count" in table:
            return np.linspace(start, stop, table["count"])
        step = float(table["step"])
        if not (step and (stop - start) / step >= 0):
            raise self._errors.at(("times", "step"), f"must lead from start to stop, got {step}.")
        steps = (stop - start) / step * (1 + 1e-12)
        if steps > MAX_TIMES:
            raise self._errors.at(("times", "step"), f"must make at most {MAX_TIMES} times, got more with {step}.")
        return np.asarray(start + step * np.arange(math.floor(steps) + 1))

    def run(self, system: System) -> dict[str, Any]:
        """Return how to compute, by the names of the arguments of `propagate`."""
        run = dict(self.values.get("run", {}))
        if run.get("method") == "closed form":
            if system.forces or is_of_two_bodies(system):
                where = "together with forces" if system.forces else "for two bodies"
                raise self._errors.at(("run", "method"), f"must be integration {where}, got 'closed form'.")
            self._only(("run",), ("method",), "the closed form")
        if isinstance(run.get("tolerance"), np.ndarray):
            precision = run.get("precision", "double")
            run["tolerance"] = self._errors.called(("run",), _one, tolerance=run["tolerance"], precision=precision)
        return run

    def plans(self, times: Array) -> tuple[Readings, ...]:
        """Return the readings without values that the tables of observables describe, by default at some times."""
        plans = [self._plan(i, table, times) for i, table in enumerate(self.values.get("observe", []))]
        names = [plan.name for plan in plans]
        for i, name in enumerate(names):
            if name in names[:i]:
                rule = "must differ from the names of other readings"
                raise self._errors.at(("observe", i, "name"), f"{rule}, got {quoted(name)} again.")
        return tuple(plans)

    def _plan(self, i: int, table: dict[str, Any], times: Array) -> Readings:
        place = ("observe", i)
        observable, plan = self._part("observable", table, place)
        given = {"times": times, **plan, "calendar": self.calendar}
        made: Readings = self._errors.called(place, Readings, observable, **given)
        return made

    def outputs(self) -> dict[str, str]:
        """Return the names of the files to write, none of which leads out of its folder."""
        return dict(self.values.get("outputs", {}))


def _moving(pair: TwoBodies, position: Any, velocity: Any, time: Any) -> PairState:
    """Return the state of two bodies at rest about their centres of mass."""
    refuse_other_members(
        velocity=member_array("velocity", velocity, (3,)).shape[:-1], masses=np.shape(pair.reduced_mass)
    )
    return pair.state(position, velocity, **AT_REST, time=time)


def _calendar(zero: str, scale: str, unit: str = "s") -> Calendar:
    """Return a calendar whose date exists."""
    calendar = Calendar(zero, scale, unit)
    try:
        dt.datetime.fromisoformat(re.sub(r":60(\..*)?$", ":59", calendar.zero))
    except ValueError:
        raise ValueError(f"zero must be a date that exists, got {quoted(zero)}.") from None
    return calendar


def _with_present_names(node: Any) -> Any:
    """Return the tables of a text with present types and keys in place of former ones.

    A former key of a table that contains the present one, too, remains and is an unknown key.
    """
    if isinstance(node, list):
        return [_with_present_names(item) for item in node]
    if not isinstance(node, dict):
        return node
    table = {key: _with_present_names(value) for key, value in node.items()}
    kind = table.get("type")
    if not isinstance(kind, str):
        return table
    table["type"] = kind = RENAMED_TYPES.get(kind, kind)
    present = {key: RENAMED.get((kind, key), key) for key in table}
    return {key if present[key] in table else present[key]: value for key, value in table.items()}


def _places(node: Any, path: str = "") -> Iterator[str]:
    """Yield the places of the numbers in the tables that an ensemble can vary."""
    if isinstance(node, np.ndarray):
        yield path
    elif isinstance(node, dict):
        for key, value in node.items():
            if path or key in VARIED:
                yield from _places(value, f"{path}.{key}".lstrip("."))
    elif isinstance(node, list):
        for i, value in enumerate(node):
            yield from _places(value, f"{path}[{i}]")


def _one(tolerance: Any, precision: str) -> float:
    if np.ndim(tolerance):
        raise ValueError(f"tolerance must be one number, got shape {np.shape(tolerance)}.")
    checked_tolerance(float(tolerance), precision)
    return float(tolerance)
