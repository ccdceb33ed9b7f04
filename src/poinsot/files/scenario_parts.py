"""The parts of a scenario, made from its text; every error names the file, the line and the key."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from poinsot.errors import member_array, real_numbers
from poinsot.files.makers import Key, Maker, kind_of, makers
from poinsot.files.scenario_model import converted, scenario_model, short
from poinsot.files.toml_text import lines_of, parsed_toml
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.attitude import quaternion_from_matrix, unit_quaternion
from poinsot.mechanics.body import Body
from poinsot.mechanics.calendar import SECONDS, Calendar
from poinsot.mechanics.euler import quaternion_from_angles
from poinsot.mechanics.frame import Frame, from_roll_pitch_yaw
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System
from poinsot.motion.arguments import members_of

__all__ = ["Parts"]

Array = NDArray[np.float64]
Place = tuple[str | int, ...]

FROM = ("from_primary", "from_secondary")
"""What may follow the name of a path beside two attractors."""

RATES = ("omega_body", "omega_space", "angular_momentum_body", "angular_momentum_space")
ATTITUDES = ("quaternion", "matrix", "euler_angles", "roll_pitch_yaw")

MOST_TIMES = 10_000_000
MOST_ROWS = 100_000_000
"""Times of all members together."""

MOST_DRAWN = 10_000_000
"""Numbers in the place of one."""

ENDINGS = {"result": (".nc", ".zarr"), "plot": (".png", ".pdf", ".svg"), "view": (".html",)}

ONCE = ("body", "state", "times")

STAND_IN: dict[str, Any] = {"state": {}, "times": {}}


class Parts:
    """What the text of a scenario says, checked, and the parts of a propagation made from it.

    Parameters
    ----------
    text, name : str
        The name is that of the file, for errors.
    whole : bool
        Whether state and times must be there.
    """

    def __init__(self, text: str, name: str, whole: bool = True) -> None:
        self.name, self._text = name, text
        data = parsed_toml(text, name)
        self._check_once(data)
        self._calendar_of(data)
        try:
            model = scenario_model().model_validate(
                data if whole else {**STAND_IN, **data}, context={"time_unit": self.time_unit}
            )
        except ValidationError as error:
            raise self._told(error, data) from None
        self.values: dict[str, Any] = model.model_dump(exclude_unset=True)
        self._made: dict[str, Any] = {}
        self._making: list[str] = []
        self._turn: Array | None = None
        self._spread()

    # ------------------------------------------------------------------ errors

    def error(self, place: Place, sentence: str) -> ValueError:
        """Return a ValueError about a key; the sentence goes on after the key's name."""
        return ValueError(f"{self._where(place)}{_dotted(place)} {sentence}")

    def _where(self, place: Place) -> str:
        lines = lines_of(self._text)
        while place and place not in lines:
            place = place[:-1]
        return f"{self.name}, line {lines[place]}: " if place else f"{self.name}: "

    def _told(self, error: ValidationError, data: Any) -> ValueError:
        """Return the first of pydantic's errors as a sentence."""
        errors = error.errors(include_url=False)
        first = next((one for one in errors if one["type"] == "extra_forbidden"), errors[0])
        place = _place_in(data, first["loc"])
        kind, context, came = first["type"], first.get("ctx", {}), first["input"]
        if kind == "extra_forbidden":
            *outer, key = place
            return self.error(place, f"must be a key that it can have, but it is none.{self._near(data, outer, key)}")
        if kind == "missing":
            return self.error((*place, str(first["loc"][-1])), "must be there, but it is not.")
        if kind == "union_tag_invalid":
            known = [tag.strip("'") for tag in context["expected_tags"].split(", ")]
            return self.error(
                (*place, "type"),
                f"must name one that there is, but {short(context['tag'])} came.{_nearest(context['tag'], known)}",
            )
        if kind == "union_tag_not_found":
            missing = isinstance(came, dict)
            return self.error(
                (*place, "type") if missing else place,
                "must be there, but it is not." if missing else f"must be a table, but {short(came)} came.",
            )
        if kind == "literal_error":
            return self.error(
                place,
                f"must be {context['expected']}, but {short(came)} came."
                f"{_nearest(came, re.findall(chr(39) + '([^' + chr(39) + ']*)', context['expected'])[::2])}",
            )
        if kind == "value_error":
            return self._prefixed(place, str(context["error"]))
        rule = KINDS.get(kind, "what it says").format(**context)
        return self.error(place, f"must be {rule}, but {short(came)} came.")

    def _near(self, data: Any, outer: Iterable[Any], key: Any) -> str:
        """Return the nearest of the keys that a table can have, or all of them."""
        known = _keys_at(data, tuple(outer))
        return _nearest(str(key), known) or (f" It can have {', '.join(known)}." if known else "")

    def _prefixed(self, place: Place, sentence: str) -> ValueError:
        """Return an error whose sentence begins with the name of a key, or of something else."""
        return ValueError(f"{self._where(place)}{_dotted(place[:-1], '.')}{sentence}")

    def _called(self, place: Place, call: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        """Call what makes a part; what it refuses is told with the place of the key that it names."""
        try:
            return call(*arguments, **keywords)
        except (TypeError, ValueError, ImportError, OverflowError) as error:
            sentence = str(error)
            first = re.match(r"\w+", sentence)
            key = first.group() if first else ""
            if key in keywords:
                raise self._prefixed((*place, key), sentence) from None
            raise ValueError(f"{self._where(place)}in {_dotted(place)}, {sentence}") from None

    # ------------------------------------------------------------------ what holds for the whole file

    def _check_once(self, data: dict[str, Any]) -> None:
        for name in ONCE:
            if isinstance(data.get(name), list):
                raise self.error((name,), f"must be one table, but a list came. A scenario has one: [{name}].")

    def _calendar_of(self, data: dict[str, Any]) -> None:
        """Find the unit of time, and what the times are as dates."""
        said, told = data.get("units"), data.get("calendar")
        unit = said.get("time") if isinstance(said, dict) else None
        self.calendar: Calendar | None = None
        if isinstance(told, dict) and {"zero", "scale"} <= set(told) <= {"zero", "scale", "unit"}:
            self.calendar = self._called(("calendar",), Calendar, **told)
            if unit not in (None, self.calendar.unit):
                raise self.error(
                    ("units", "time"), f"must be that of the calendar, {self.calendar.unit}, but {short(unit)} came."
                )
            unit = self.calendar.unit
        self.time_unit = unit if isinstance(unit, str) and unit in SECONDS else None

    def _spread(self) -> None:
        """Draw the members of the ensemble, and put them in the places of the numbers that vary."""
        ensemble = self.values.get("ensemble")
        if not ensemble:
            return
        random, members = np.random.default_rng(ensemble["seed"]), ensemble["members"]
        for i, spread in enumerate(ensemble["spread"]):
            place: Place = ("ensemble", "spread", i)
            table, key = self._target(spread["of"], place)
            value = np.zeros(3) if key == "turn" else np.asarray(table[key], dtype=float)
            try:
                size = real_numbers("size", converted(spread["size"], kind_of(str(key)), self.time_unit, "size"))
                size = np.broadcast_to(size, value.shape)
            except (TypeError, ValueError) as error:
                raise self._prefixed((*place, "size"), _about_size(str(error))) from None
            uniform = spread.get("distribution") == "uniform"
            shape = (members, *value.shape)
            if members * value.size > MOST_DRAWN:
                raise self.error(
                    ("ensemble", "members"), f"must make at most {MOST_DRAWN} numbers of one, but {members} make more."
                )
            drawn = value + size * (random.uniform(-1, 1, shape) if uniform else random.standard_normal(shape))
            if key == "turn":
                self._turn = drawn
            else:
                table[key] = drawn

    def _target(self, path: str, place: Place) -> tuple[Any, Any]:
        """Return the table and the key of the number at a path such as state.omega_body."""
        if path == "state.turn":
            return self.values["state"], "turn"
        parts = [
            int(part) if part.isdecimal() and len(part) < 6 else part
            for part in path.replace("[", ".").replace("]", "").split(".")
        ]
        node: Any = self.values if parts[0] in ("body", "state", "forces", "orbits") else {}
        for part in parts[:-1]:
            node = node[part] if _has(node, part) else {}
        if not _has(node, parts[-1]) or not isinstance(node[parts[-1]], np.ndarray):
            raise self.error((*place, "of"), f"must be the place of a number in this file, but {short(path)} is none.")
        if node[parts[-1]].dtype.kind != "f":
            raise self.error((*place, "of"), f"must be the place of a number, but {short(path)} is a date.")
        return node, parts[-1]

    # ------------------------------------------------------------------ parts

    def system(self) -> System:
        """Return the body and the forces on it."""
        body = self._part("body", self.values["body"], ("body",))
        forces = [self._part("force", table, ("forces", i)) for i, table in enumerate(self.values.get("forces", []))]
        for name in self.values.get("orbits", {}):
            self._orbit(name, ("orbits", name))
        return self._called(("forces",) if forces else ("body",), System, body, *forces, units=self.values.get("units"))

    def _part(self, group: str, table: dict[str, Any], place: Place) -> Any:
        """Return what a table describes."""
        kinds = makers(group)
        maker = kinds[table.get("type", next(iter(kinds)))]
        arguments = [
            self._orbit(name, (*place, key.name))
            for key in maker.keys
            if key.kind == "orbits"
            for name in table[key.name]
        ]
        given = {
            key.name: self._value(key, table[key.name], (*place, key.name))
            for key in maker.keys
            if key.name in table and key.kind != "orbits"
        }
        if maker.takes_calendar and self.calendar is not None:
            given["calendar"] = self.calendar
        return self._called(place, maker.call, *arguments, **given)

    def _value(self, key: Key, value: Any, place: Place) -> Any:
        if key.kind == "orbit":
            return self._orbit(value, place)
        if key.kind == "field":
            return self._part("field", value, place)
        if key.kind == "time" and isinstance(value, str) and self.calendar is not None:
            return self._called(place[:-1], self.calendar.time, value)
        return value

    def _orbit(self, reference: str, place: Place) -> Any:
        """Return the orbit of a name, or the orbit about one attractor of a path beside two."""
        name, _, side = reference.partition(".")
        tables = self.values.get("orbits", {})
        if name not in tables:
            known = _nearest(name, tables) or (f" There is {', '.join(tables)}." if tables else " There is none.")
            raise self.error(place, f"must be the name of a table under orbits, but {short(reference)} came.{known}")
        if name in self._making:
            raise self.error(place, f"must be an orbit that is there without this one, but {short(name)} needs itself.")
        if name not in self._made:
            self._making.append(name)
            self._made[name] = self._part("orbit", tables[name], ("orbits", name))
            self._making.pop()
        orbit = self._made[name]
        if not side:
            return orbit
        if side not in FROM or not hasattr(orbit, side):
            raise self.error(
                place,
                f"must be an orbit, or {' or '.join(FROM)} of a path beside two attractors, "
                f"but {short(reference)} came.",
            )
        return getattr(orbit, side)

    # ------------------------------------------------------------------ the state

    def state(self, body: Body) -> State:
        """Return the state from which the motion starts."""
        table, place = self.values["state"], ("state",)
        time = self._time(table.get("time", 0.0), ("state", "time"))
        if "conjugate_momenta" in table:
            self._only(table, ("quaternion", "conjugate_momenta"))
            given = {name: table.get(name) for name in ("quaternion", "conjugate_momenta")}
            self._refuse_turn()
            return self._called(place, State, **given, time=time)
        if "euler_momenta" in table:
            self._only(table, ("euler_angles", "euler_momenta", "sequence"))
            self._refuse_turn()
            angles, momenta = self._needed("euler_angles"), table["euler_momenta"]
            return self._called(place, State.from_euler, angles, momenta, table.get("sequence", "313"), time)
        rates = {name: table[name] for name in RATES if name in table}
        frame = self._frame(table["frame"]) if "frame" in table else None
        return self._called(place, body.state, self._attitude(table), **rates, time=time, frame=frame)

    def _refuse_turn(self) -> None:
        """Refuse to turn a canonical pair, whose momenta would have to turn too."""
        if self._turn is not None:
            raise self.error(("state",), "must have a rate or an angular momentum where its attitude is spread.")

    def _only(self, table: dict[str, Any], names: tuple[str, ...]) -> None:
        """Refuse what does not go with momenta, and miss what they need."""
        self._needed(names[0])
        for name in table:
            if name not in (*names, "time"):
                raise self.error(("state", name), f"must not be beside {names[1]}, but it is.")

    def _needed(self, name: str) -> Any:
        if name not in self.values["state"]:
            raise self.error(("state", name), "must be there, but it is not.")
        return self.values["state"][name]

    def _attitude(self, table: dict[str, Any]) -> Array:
        given = [name for name in ATTITUDES if name in table]
        if len(given) != 1:
            raise self.error(
                ("state",),
                f"must have exactly one of {', '.join(ATTITUDES)}, but {' and '.join(given) or 'none'} came.",
            )
        (name,) = given
        if "sequence" in table and name != "euler_angles":
            raise self.error(("state", "sequence"), "must be beside euler_angles, but it is not.")
        if name == "roll_pitch_yaw" and table.get("frame", "").partition(".")[0] not in self.values.get("orbits", {}):
            raise self.error(("state", "frame"), "must be an orbit beside roll_pitch_yaw, but it is not.")
        ways: dict[str, Callable[..., Any]] = {
            "quaternion": lambda quaternion: unit_quaternion(quaternion, "quaternion"),
            "matrix": lambda matrix: quaternion_from_matrix(matrix),
            "euler_angles": lambda euler_angles: quaternion_from_angles(
                _triple("euler_angles", euler_angles), table.get("sequence", "313")
            ),
            "roll_pitch_yaw": lambda roll_pitch_yaw: from_roll_pitch_yaw(_triple("roll_pitch_yaw", roll_pitch_yaw)),
        }
        return self._turned(self._called(("state",), ways[name], **{name: table[name]}))

    def _turned(self, q: Array) -> Array:
        """Return attitudes turned about their body axes by what the ensemble draws."""
        if self._turn is None:
            return q
        return quat.product(q, np.asarray(Rotation.from_rotvec(self._turn).as_quat(scalar_first=True)))

    def _frame(self, reference: str) -> Frame:
        frames, place = self.values.get("frames", {}), ("state", "frame")
        if reference in frames:
            frame: Frame = self._part("frame", frames[reference], ("frames", reference))
            return frame
        orbit = self._orbit(reference, place)
        found: Frame = self._called(place, lambda: orbit.frame)
        return found

    # ------------------------------------------------------------------ times, run, outputs

    def _time(self, value: Any, place: Place, calendar: Calendar | None = None) -> Any:
        """Return a time, or times, from dates too."""
        if not isinstance(value, str) and not (isinstance(value, list) and any(isinstance(x, str) for x in value)):
            return value
        calendar = calendar or self.calendar
        if calendar is None:
            raise self.error(place, f"must be a number where there is no calendar, but {short(value)} came.")
        return self._called(place[:-1], calendar.time, value)

    def times(self, system: System, state: State) -> Array:
        """Return the times at which the motion is wanted."""
        table, calendar = self.values["times"], system.calendar
        named = [name for name in ("start", "stop", "step", "periods", "values") if name in table]
        read = {name: self._time(table[name], ("times", name), calendar) for name in named}
        for name in named:
            if np.ndim(read[name]) != (name == "values"):
                rule = "a list of times" if name == "values" else "one number"
                raise self.error(("times", name), f"must be {rule}, but shape {np.shape(read[name])} came.")
        if "values" in read:
            self._alone("values", table)
            times = np.asarray(read["values"], dtype=float)
        else:
            start = read.get("start", np.ravel(state.time)[0])
            times = self._grid(float(start), self._stop(float(start), read, table), table)
        members = (members_of(system, state) or (1,))[0]
        if times.size * members > MOST_ROWS:
            raise self.error(
                ("times",), f"must be at most {MOST_ROWS} with all members, but {times.size * members} came."
            )
        return times

    def _alone(self, name: str, table: dict[str, Any]) -> None:
        for other in table:
            if other != name:
                raise self.error(("times", other), f"must not be beside {name}, but it is.")

    def _stop(self, start: float, read: dict[str, Any], table: dict[str, Any]) -> float:
        if ("stop" in table) == ("periods" in table):
            raise self.error(("times",), "must have one of stop and periods, or values.")
        if "stop" in table:
            return float(read["stop"])
        if "orbit" not in table:
            raise self.error(("times", "orbit"), "must be there beside periods, but it is not.")
        orbit = self._orbit(table["orbit"], ("times", "orbit"))
        period = np.ravel(getattr(orbit, "period", math.nan))
        if not np.isfinite(period[0]) or period.size > 1:
            raise self.error(("times", "orbit"), f"must have one period, but {short(table['orbit'])} has not.")
        return start + float(table["periods"]) * float(period[0])

    def _grid(self, start: float, stop: float, table: dict[str, Any]) -> Array:
        if ("count" in table) == ("step" in table):
            raise self.error(("times",), "must have one of count and step, or values.")
        if "count" in table:
            count = table["count"]
            if not 1 <= count <= MOST_TIMES:
                raise self.error(("times", "count"), f"must be from 1 to {MOST_TIMES}, but {short(count)} came.")
            return np.linspace(start, stop, count)
        step = float(table["step"])
        if not (step and (stop - start) / step >= 0):
            raise self.error(("times", "step"), f"must lead from start to stop, but {step} does not.")
        steps = (stop - start) / step * (1 + 1e-12)
        if steps > MOST_TIMES:
            raise self.error(("times", "step"), f"must make at most {MOST_TIMES} times, but {step} makes more.")
        return start + step * np.arange(math.floor(steps) + 1)

    def run(self, system: System) -> dict[str, Any]:
        """Return how to compute, by the names of the arguments of `propagate`."""
        run = dict(self.values.get("run", {}))
        if run.get("method") == "closed form":
            if system.forces:
                raise self.error(("run", "method"), "must be integration where there are forces, but closed form came.")
            for name in run:
                if name != "method":
                    raise self.error(("run", name), "must not be beside the closed form, but it is.")
        if isinstance(run.get("tolerance"), np.ndarray):
            run["tolerance"] = float(self._called(("run",), _one, run["tolerance"]))
        return run

    def outputs(self) -> dict[str, str]:
        """Return the names of the files to write, none of which leads out of its folder."""
        found = self.values.get("outputs", {})
        for kind, name in found.items():
            if re.fullmatch(r"\w[\w .+-]*", name) is None or len(name) > 200:
                raise self.error(
                    ("outputs", kind), f"must be the name of a file, without a folder, but {short(name)} came."
                )
            if not name.endswith(ENDINGS[kind]):
                raise self.error(
                    ("outputs", kind), f"must end in {' or '.join(ENDINGS[kind])}, but {short(name)} came."
                )
        return dict(found)


def _triple(name: str, angles: Array) -> Array:
    return member_array(name, angles, (3,))


def _one(tolerance: Any) -> Any:
    if np.ndim(tolerance):
        raise ValueError(f"tolerance must be one number, but shape {np.shape(tolerance)} came.")
    return tolerance


KINDS = {
    "string_type": "text",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "greater_than_equal": "at least {ge}",
    "less_than_equal": "at most {le}",
    "less_than": "less than {lt}",
}


def _has(node: Any, part: Any) -> bool:
    if isinstance(node, dict):
        return part in node
    return isinstance(node, list) and isinstance(part, int) and part < len(node)


def _place_in(data: Any, location: tuple[Any, ...]) -> Place:
    """Return the place of an error in the file: pydantic's, without the names of the types."""
    place: list[Any] = []
    for i, part in enumerate(location):
        if _has(data, part):
            data = data[part]
            place.append(part)
        elif i == len(location) - 1 and isinstance(part, int):
            break
    return tuple(place)


def _keys_at(data: Any, outer: Place) -> list[str]:
    """Return the keys that the table at a place can have."""
    for part in outer:
        data = data[part]
    groups = {"body": "body", "forces": "force", "orbits": "orbit", "frames": "frame"}
    if outer and outer[0] in groups:
        group = "field" if outer[-1] == "field" else groups[str(outer[0])]
        kinds = makers(group)
        maker: Maker = kinds[data.get("type", next(iter(kinds)))]
        return [key.name for key in maker.keys]
    model: Any = scenario_model()
    for part in outer:
        if not isinstance(part, int):
            model = _model_in(model.model_fields[part].annotation)
    return list(model.model_fields)


def _model_in(annotation: Any) -> Any:
    """Return the model among the parts of an annotation."""
    if hasattr(annotation, "model_fields"):
        return annotation
    return next((found for part in getattr(annotation, "__args__", ()) if (found := _model_in(part))), None)


def _dotted(place: Place, end: str = "") -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    return text + end if text else ""


def _nearest(name: Any, known: Iterable[str]) -> str:
    found = difflib.get_close_matches(str(name)[:60], list(known), n=1)
    return f" Did you mean {found[0]}?" if found else ""


def _about_size(sentence: str) -> str:
    return (
        sentence
        if sentence.startswith("size")
        else f"size must be one number, or one for each component, but {sentence}"
    )
