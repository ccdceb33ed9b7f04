"""Output variables of motions: one table of their names, units, frames, meanings and formulas.

To add an output variable, add an entry to `COLUMNS`. Properties and `column` of a `Trajectory`, its dataset, NetCDF
files, stores of ensembles and labels of plots read the table.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, auto
from typing import cast

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.immutable import cached_property, read_only
from poinsot.kinematics.each_body import no_attribute
from poinsot.kinematics.state import AnyState, PairState, named
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.observable import Observable
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.records.units import DerivedUnits
from poinsot.systems.integrals import Integral
from poinsot.systems.system import System

__all__ = [
    "COLUMNS",
    "ORBIT_VARIABLES",
    "RENAMED",
    "Column",
    "ColumnBlock",
    "ColumnTable",
    "Requirement",
    "Scope",
    "columns_of_observables",
    "names_with",
    "refuse_names_of_columns",
    "static_columns",
    "unit_of_column",
]


class Scope(Enum):
    """Kind of motion that has a column."""

    BODY = auto()
    """Each rigid body. In a motion of two bodies the name begins with the name of the body: `primary_quaternion`."""
    ONE_BODY = auto()
    TWO_BODIES = auto()
    MOTION = auto()
    """Any motion, as a whole."""


class Requirement(Enum):
    """Formulas and rows that a column needs in addition to states."""

    FORCES = auto()
    PARTS = auto()
    ORBITS = auto()


@dataclass(frozen=True, eq=False)
class Column:
    """Output variable of a motion along its times.

    Attributes
    ----------
    name : str
        Name in a trajectory, a dataset and a file.
    unit : str or callable
        Attribute of `DerivedUnits`, or a function of these that returns the unit; "1" for a number without unit, or ""
        for variables without a common unit.
    meaning : str
        Description, the `long_name` of a dataset.
    compute : callable, optional
        Function of a `ColumnBlock`, which contains system, states, environment and the other columns. Without it the
        column is only read.
    axis : str
        Dimension after the times; "" for scalars.
    length : int
        Length of this dimension; 0 for scalars and for variables of orbits, whose number depends on the run.
    scope : Scope
        Kind of motion that has the column.
    requires : set of Requirement
        Requirements in addition to the states. A file whose forces cannot be written contains the column.
    attributes : mapping
        Further attributes in a dataset, such as `frame`.
    drift_of : Integral, optional
        Integral whose relative change the column is.
    """

    name: str
    unit: str | Callable[[DerivedUnits], str]
    meaning: str
    compute: Callable[[ColumnBlock], Array] | None
    axis: str = ""
    scope: Scope = Scope.MOTION
    requires: frozenset[Requirement] = frozenset()
    attributes: Mapping[str, str] = field(default_factory=dict)
    drift_of: Integral | None = None
    length: int = 0

    def attributes_in(self, units: DerivedUnits, addition: str = "") -> dict[str, str]:
        """Return the attributes of the variable of a dataset; the addition follows its meaning."""
        unit = self.unit_in(units)
        return {**({"units": unit} if unit else {}), "long_name": f"{self.meaning}{addition}", **self.attributes}

    def unit_in(self, units: DerivedUnits) -> str:
        """Return the unit in the units of a system, in CF notation; "" if it is unknown."""
        if not isinstance(self.unit, str):
            return self.unit(units)
        return self.unit if self.unit in ("", "1") else str(getattr(units, self.unit))

    def of_body(self, body: str) -> Column:
        """Return the column of one of two bodies."""
        name, meaning = named(body, self.name), f"{self.meaning}, of the {body}"
        return replace(self, name=name, meaning=meaning, compute=lambda block: block.bodies[body][self.name])


Formula = Callable[["ColumnBlock"], Array]
NOTHING: frozenset[Requirement] = frozenset()
FORCES, PARTS, ORBITS = (frozenset({each}) for each in Requirement)
OF_BODY, ONE_BODY, TWO_BODIES = Scope.BODY, Scope.ONE_BODY, Scope.TWO_BODIES
RATE = "inertial angular velocity"
FROM_PRIMARY = "of the secondary relative to the primary"
ORBIT_VARIABLES = "orbit_variables"


def _of_body(
    name: str,
    unit: str,
    meaning: str,
    compute: Formula,
    frame: str = "",
    axis: str = "axis",
    requires: frozenset[Requirement] = NOTHING,
) -> Column:
    attributes, length = {"frame": frame} if frame else {}, 4 if axis == "parameter" else 3
    return Column(name, unit, meaning, compute, axis, OF_BODY, requires, attributes, length=length)


def _of_pair(name: str, unit: str, meaning: str, compute: Formula) -> Column:
    return Column(name, unit, meaning, compute, "axis", TWO_BODIES, NOTHING, {"frame": "space"}, length=3)


def _state(name: str) -> Formula:
    return lambda block: np.asarray(getattr(block.state, name))


def _orbit(place: slice) -> Formula:
    return lambda block: np.array(block.state.phase["orbit"])[..., place]


def _velocity(block: ColumnBlock) -> Array:
    momentum = block["momentum"]
    pair = cast(TwoBodies, block.system.body)
    return np.asarray(momentum / pair.with_axes(momentum.ndim).reduced_mass)


def _norm_error(block: ColumnBlock) -> Array:
    errors = [np.asarray(quat.norm(each["quaternion"])) - 1 for each in block.bodies.values()]
    return errors[0] if len(errors) == 1 else np.max(np.abs(errors), axis=0)


def _tangency_error(block: ColumnBlock) -> Array:
    errors = [_tangency_of_body(each) for each in block.bodies.values()]
    return errors[0] if len(errors) == 1 else np.max(np.abs(errors), axis=0)


def _tangency_of_body(block: ColumnBlock) -> Array:
    q, momenta = block["quaternion"], block["conjugate_momenta"]
    size = np.hypot.reduce(momenta, axis=-1)  # squares may overflow
    return np.asarray(quat.dot(q, momenta / np.where(size == 0, 1.0, size)[..., None]))


def _omega_body(block: ColumnBlock) -> Array:
    return np.asarray(block.system.omega_body(block.state))


def _omega_space(block: ColumnBlock) -> Array:
    return quat.rotate(block["quaternion"], block["omega_body"])


def _kinetic_energy(block: ColumnBlock) -> Array:
    return np.asarray(block.system.kinetic_energy(block.state))


def _potential_energy(block: ColumnBlock) -> Array:
    return np.asarray(block.system.potential_energy(block.state, block.environment))


COLUMNS: tuple[Column, ...] = (
    _of_body("quaternion", "1", "Euler parameters q, body to space", _state("quaternion"), axis="parameter"),
    _of_body(
        "conjugate_momenta", "momentum", "momenta Q conjugate to q", _state("conjugate_momenta"), axis="parameter"
    ),
    _of_body("angular_momentum_body", "momentum", "angular momentum", _state("angular_momentum_body"), "body"),
    _of_body("angular_momentum_space", "momentum", "angular momentum", _state("angular_momentum_space"), "space"),
    _of_body("omega_body", "rate", RATE, _omega_body, "body", requires=PARTS),
    _of_body("omega_space", "rate", RATE, _omega_space, "space"),
    _of_pair("position", "length", f"position {FROM_PRIMARY}", _orbit(slice(3))),
    _of_pair("momentum", "linear_momentum", f"reduced mass times velocity {FROM_PRIMARY}", _orbit(slice(3, None))),
    _of_pair("velocity", "velocity", f"velocity {FROM_PRIMARY}", _velocity),
    _of_pair(
        "angular_momentum_space", "momentum", "angular momentum about the barycentre", _state("angular_momentum_space")
    ),
    Column("kinetic_energy", "energy", "rotational kinetic energy T", _kinetic_energy, "", ONE_BODY, PARTS),
    Column("kinetic_energy", "energy", "kinetic energy T", _kinetic_energy, "", TWO_BODIES),
    Column("potential_energy", "energy", "potential energy U", _potential_energy, requires=FORCES),
    Column("norm_error", "1", "|q| - 1", _norm_error),
    Column("tangency_error", "1", "q . Q / |Q|", _tangency_error),
    Column(ORBIT_VARIABLES, "1", "variables of integrated orbits", None, "variable", requires=ORBITS),
)
"""The table of output variables. Parts and integrals of a system add columns of their own: see `ColumnTable`."""

RENAMED = {"carried": ORBIT_VARIABLES}
"""Names of variables in files of version 0.2, with the present names."""


# ---------------------------------------------------------------------- columns of a system


LABELS_OF_DATASETS = frozenset(
    ("time", "member", "axis", "parameter", "principal_axis", "moments", "mass", "principal_axes", "failures")
)
"""Names of the axes of a dataset of a motion, and of the variables that describe the body."""


def static_columns(bodies: tuple[str, ...]) -> Mapping[str, Column]:
    """Return the columns of the table for a motion of bodies with the given names, ("",) for one body."""
    return _static_columns(COLUMNS, bodies)


@functools.lru_cache
def _static_columns(table: tuple[Column, ...], bodies: tuple[str, ...]) -> Mapping[str, Column]:
    if bodies == ("",):
        return read_only({each.name: each for each in table if each.scope is not TWO_BODIES})
    each_body = [each.of_body(body) for body in bodies for each in table if each.scope is OF_BODY]
    together = [each for each in table if each.scope in (TWO_BODIES, Scope.MOTION)]
    return read_only({each.name: each for each in (*each_body, *together)})


class ColumnTable:
    """Columns of the motions of a system: columns of the table, of the system's parts and of its integrals.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system: System) -> None:
        static = static_columns(tuple(system.of_bodies))
        self.system, self._integrals = system, dict[str, Column]()
        self._of_states = {**static, **_of_parts(system)} if system.parts else static
        self._unknown = _unknown_formulas(system)

    def __reduce__(self) -> tuple[type[ColumnTable], tuple[System]]:
        return ColumnTable, (self.system,)

    def find(self, name: str) -> Column | None:
        """Return a column; None for an unknown name."""
        return self._of_states.get(name) or self._of_integrals().get(name)

    def _of_integrals(self) -> dict[str, Column]:
        """Return the columns of the integrals, which are found at the first call."""
        self._integrals = self._integrals or _of_integrals(self.system)
        return self._integrals

    def is_computable(self, column: Column) -> bool:
        """Return True if a column follows from states, without formulas that are unknown."""
        return (column.compute is not None or column.drift_of is not None) and not column.requires & self._unknown

    def of_motion(self, recorded: Collection[str]) -> dict[str, Column]:
        """Return the columns of a motion that contains some columns, by name: recorded and computable columns."""
        every = {**self._of_states, **self._of_integrals()}
        return {name: each for name, each in every.items() if name in recorded or self.is_computable(each)}


def unit_of_column(system: System, name: str) -> str:
    """Return the unit of an output variable of a motion in CF notation; "" if it is unknown."""
    column = ColumnTable(system).find(name)
    return "" if column is None else column.unit_in(DerivedUnits(system.units))


def columns_of_observables(observables: Mapping[str, Observable]) -> dict[str, Column]:
    """Return the columns of the readings of observables, by name; they are read, not computed."""
    found = {}
    for name, each in observables.items():
        count, frame = len(each.components), {"frame": each.frame} if each.frame else {}
        axis = f"component_{name}" if count else ""
        found[name] = Column(name, each.unit, f"readings of {name}", None, axis, attributes=frame, length=count)
    return found


def refuse_names_of_columns(system: System, observables: Iterable[str]) -> None:
    """Raise a ValueError for an observable that has the name of another variable of the dataset of a motion."""
    table = ColumnTable(system)
    for name in observables:
        if table.find(name) or name in LABELS_OF_DATASETS or name.startswith("initial_"):
            raise ValueError(
                f"observables must have other names than the variables of a motion, got {quoted(name)}. "
                "Rename the class."
            )


def names_with(requirement: Requirement) -> list[str]:
    """Return the names of the columns of the table with a requirement, for motions of one body and of two."""
    each = (*static_columns(("",)).values(), *static_columns(PairState.body_names).values())
    return list(dict.fromkeys(column.name for column in each if requirement in column.requires))


def _unknown_formulas(system: System) -> frozenset[Requirement]:
    """Return the kinds of formulas that a system from a file, or one of two bodies, does not have."""
    parts = any(not isinstance(part, Part) for part in system.parts)
    return (PARTS if parts else NOTHING) | (NOTHING if system.dynamics.moves_alone else FORCES)


def _of_parts(system: System) -> dict[str, Column]:
    """Return the column of the variables of each part; variables that are not all momenta have no common unit."""
    found = {}
    for part in (part for part in system.parts if part.size):
        name = f"own_{part.name}"
        meaning, axis = f"variables of the part {part.name}", f"component_{part.name}"
        found[name] = Column(name, _unit_of_part(part), meaning, _own(part.name), axis, length=part.size)
    return found


def _unit_of_part(part: Part) -> str:
    return "momentum" if set(part.momenta) == set(part.variables) else ""


def _own(name: str) -> Formula:
    return lambda block: block.state.own[name]


def _of_integrals(system: System) -> dict[str, Column]:
    """Return the columns of the values of each integral and of its drift."""
    found = {}
    for each in system.integrals:
        kind = "energy" if each.is_energy else "momentum"
        value, drift = f"integral_{each.name}", f"drift_{each.name}"
        attributes = {"symbol": each.symbol, "kind": kind}
        found[value] = Column(value, kind, each.meaning, _value(each), requires=FORCES, attributes=attributes)
        meaning = f"relative drift of {each.meaning}"
        found[drift] = Column(drift, "1", meaning, None, requires=FORCES, drift_of=each)
    return found


def _value(integral: Integral) -> Formula:
    return lambda block: np.asarray(integral.value(block.state))


# ---------------------------------------------------------------------- numbers


class ColumnBlock:
    """Rows of a motion from which columns are computed, together with the columns that are recorded or computed.

    Parameters
    ----------
    columns : ColumnTable
        Columns of the system of the motion.
    state : State
        States in the rows.
    environment : callable
        Returns the environment at the times of the rows.
    recorded : mapping
        Recorded columns by name.
    of_bodies : callable
        Returns the columns of the single bodies by the name of the body.
    """

    def __init__(
        self,
        columns: ColumnTable,
        state: AnyState,
        environment: Callable[[], Environment],
        recorded: Mapping[str, Array],
        of_bodies: Callable[[], Mapping[str, ColumnTable]],
    ) -> None:
        self.system, self.state = columns.system, state
        self._columns, self._of_bodies = columns, of_bodies
        self._environment, self._recorded = environment, recorded
        self._computed: dict[str, Array] = {}

    @property
    def environment(self) -> Environment:
        """Environment at the times of the rows."""
        return self._environment()

    @cached_property
    def bodies(self) -> dict[str, ColumnBlock]:
        """The rows of each rigid body by name; {"": self} for one body."""
        if len(self.system.of_bodies) == 1:
            return {"": self}
        columns = self._of_bodies()
        return {
            name: ColumnBlock(columns[name], state, self._environment, {}, self._of_bodies)
            for name, state in self.state.of_bodies.items()
        }

    def __getitem__(self, name: str) -> Array:
        """Return a column, recorded or computed."""
        if name in self._recorded:
            return np.asarray(self._recorded[name])
        if name not in self._computed:
            self._computed[name] = self._value(name)
        return self._computed[name]

    def _value(self, name: str) -> Array:
        column = self._columns.find(name)
        if column is None or column.compute is None or not self._columns.is_computable(column):
            raise self._missing(name)
        return column.compute(self)

    def _missing(self, name: str) -> AttributeError | ValueError:
        """Return the error for a column that the motion does not have."""
        scopes = {each.scope for each in COLUMNS if each.name == name}
        if Scope.BODY in scopes and len(self.system.of_bodies) > 1:
            return AttributeError(no_attribute("a motion", name))
        if scopes == {Scope.TWO_BODIES}:
            return AttributeError(f"a motion of one body has no {name}: it belongs to a motion of two bodies.")
        if scopes and not isinstance(self.system, System):
            return self.system.formula_missing(name)
        if scopes:
            return AttributeError(f"one of two bodies has no {name} of its own: take the {name} of the pair.")
        known = ", ".join((*self._columns.of_motion(self._recorded), *self._recorded))
        return ValueError(f"name must be some of {known}, got {quoted(name)}.")
