"""Records whose annotated fields are physical parameters: what bodies, forces and orbits have in common.

A field is declared by its annotation: `float` (a scalar), `Vector` (three components), `Annotated[Any, (5, 5)]` (any
other shape; a length may be the name of an `int` field or of an `ArrayLength`), a quantity (`Angle`, `AngularVelocity`,
`Time`, or `Annotated[Vector, Quantity("rate")]`), another record, several (`tuple[Orbit, ...]`), or structure (`int`,
`bool`, `str`, a `Table`, a shape), which selects a formula and is no number to vary. Records, tables and shapes may be
alternatives (`Orbit | MagneticField`). Every real number may carry a leading member axis.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, ClassVar, Protocol, Self, dataclass_transform, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.display.html_text import rounded, text_table
from poinsot.docstrings import inherit_parameters
from poinsot.errors import (
    array_of,
    member_array,
    real_numbers,
    refuse_negative,
    refuse_nonpositive,
    refuse_other_length,
    refuse_outside,
    refuse_zero,
    warn_of_negative,
)
from poinsot.functions import Scalar
from poinsot.immutable import Immutable, cached_property
from poinsot.printable import described, quoted
from poinsot.quantities import (
    Along,
    Angle,
    BodyVector,
    Quantity,
    Real,
    Rule,
    SpaceVector,
    annotated_with,
    extras_of,
    hints_of,
    quantity_of,
)
from poinsot.records.formula_errors import explain_formulas
from poinsot.records.members import common_axis, expanded, inherited_formula
from poinsot.subclasses import is_own

__all__ = [
    "ArrayLength",
    "BodyDirection",
    "BodyUnitVector",
    "Gain",
    "HalfTurn",
    "Matrix",
    "NotNegative",
    "Parametric",
    "Points",
    "Positive",
    "QuarterTurn",
    "SpaceDirection",
    "Structural",
    "Table",
    "Vector",
    "kinds_of",
    "of_each",
    "records_in",
    "same",
]


Vector = Annotated[Any, (3,)]
"""Annotation of a parameter of three numbers without axes; `BodyVector` and `SpaceVector` say theirs."""

Positive = Annotated[Real, Rule(refuse_nonpositive)]
NotNegative = Annotated[Real, Rule(refuse_negative)]
Gain = Annotated[Real, Rule(warn_of_negative, "Feedback of the wrong sign is unstable.")]
BodyDirection = Annotated[BodyVector, Rule(refuse_zero, "It is a direction.")]
BodyUnitVector = Annotated[BodyVector, Rule(refuse_other_length, "Divide by the length.")]
SpaceDirection = Annotated[SpaceVector, Rule(refuse_zero, "It is a direction.")]
DEGREES = "Degrees: np.radians(value)."
HalfTurn = Annotated[Angle, Rule(functools.partial(refuse_outside, 0.0, math.pi, "from 0 to pi"), DEGREES)]
QuarterTurn = Annotated[
    Angle, Rule(functools.partial(refuse_outside, -math.pi / 2, math.pi / 2, "from -pi/2 to pi/2"), DEGREES)
]
"""Annotations of parameters whose values a record checks."""

Points = Annotated[ArrayLike, ("n", 3)]
Matrix = Annotated[ArrayLike, ("n", "n")]
"""Annotations of arguments that are arrays of two axes."""


class Structural(Immutable):
    """Base of values of fields that select a formula and are no numbers to vary; two are equal if they are one."""


class Table(Structural):
    """Base of data that no formula sees as a whole, such as an ephemeris."""

    title: ClassVar[str]
    """The name of the table in an error message."""
    knots: NDArray[np.float64]
    """The times at which one polynomial follows another, ascending, with the ends of the span."""

    @property
    def end_margin(self) -> float:
        """Time beyond the ends of the span within which the first and the last polynomial hold."""
        return 0.0

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time of the table."""
        return float(self.knots[0]), float(self.knots[-1])

    def pieces_around(self, time: ArrayLike) -> NDArray[np.int_]:
        """Return the numbers of the polynomials around times; before and after the table the first and the last."""
        found = np.searchsorted(self.knots, time, side="right") - 1
        return np.asarray(np.clip(found, 0, len(self.knots) - 2))

    def pieces_at(self, time: NDArray[np.float64]) -> NDArray[np.int_]:
        """Return the numbers of the polynomials at times, or raise a ValueError for a time outside of the table."""
        first, last = self.span
        outside = time[(time < first - self.end_margin) | (time > last + self.end_margin)]
        if outside.size:
            raise ValueError(
                f"time must lie within the span of the {self.title}, [{quoted(first)}, {quoted(last)}], got "
                f"{quoted(float(outside.flat[0]))}."
            )
        return self.pieces_around(time)


class ArrayLength:
    """Length of an axis of an array, under its name in the shapes of fields; it belongs to the structure of a record.

    Parameters
    ----------
    field : str
        Name of a field whose shape contains the length.
    meaning : str
        Docstring of the attribute.
    """

    def __init__(self, field: str, meaning: str) -> None:
        self._field, self.__doc__ = field, meaning

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, record: Parametric | None, owner: type) -> int:
        if record is None:
            return self  # type: ignore[return-value]
        kind, value = kinds_of(owner)[self._field], getattr(record, self._field)
        if isinstance(value, functions.Vector):
            return len(value)
        shape = (value if isinstance(value, np.ndarray) else real_numbers(self._field, value)).shape
        if len(shape) < len(kind):
            own = tuple("n" if isinstance(length, str) else length for length in kind)
            one, members = (repr(text).replace("'", "") for text in (own, ("members", *own)))
            raise ValueError(f"{self._field} must have shape {one} or {members}, got shape {shape}.")
        return int(shape[kind.index(self._name) - len(kind)])


def _stays(record: Parametric, name: str, value: Any) -> None:  # noqa: ARG001
    """Refuse to change a record, also in an `__init__` of the user."""
    raise dataclasses.FrozenInstanceError(
        f"{type(record).__name__}.{name} must stay as it was made, got another value. Make another one; a class of "
        "your own needs no __init__, its annotated fields are its arguments."
    )


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field,))
class Parametric(Immutable):
    """Base of the frozen records, which makes a dataclass of each subclass by its annotated fields."""

    extra_numbers: ClassVar[Mapping[str, tuple[int, ...]]] = {}
    """Real numbers of records that are no fields, and the shape of each for one member."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        for name in cls.__annotations__.keys() - vars(cls).keys():
            if callable(getattr(cls, name, None)):  # a field may have the name of a method, which is not its default
                setattr(cls, name, dataclasses.field())
        for name in list(vars(cls)):
            if mark := inherited_formula(cls, name):
                setattr(cls, name, mark(vars(cls)[name]))
        dataclasses.dataclass(frozen=True, eq=False, repr=False)(cls)
        if is_own(cls):
            fields = sorted(vars(cls)["__dataclass_fields__"].values(), key=lambda field: bool(field.kw_only))
            inherit_parameters(cls, [field.name for field in fields])
        cls.__setattr__ = _stays  # type: ignore[assignment]
        explain_formulas(cls)

    def __dir__(self) -> list[str]:
        """Return the names of attributes, without the methods of this base class."""
        internal = vars(Parametric).keys() - {field.name for field in dataclasses.fields(self)}  # type: ignore[arg-type]
        return [name for name in super().__dir__() if name.startswith("_") or name not in internal]

    @classmethod
    def unchecked(cls, **fields: Any) -> Self:
        """Return a record of computed values of any kind, which need no check and broadcast as they are."""
        record = object.__new__(cls)
        object.__setattr__(record, "member_axis", ())
        for name, value in fields.items():
            object.__setattr__(record, name, value)
        return record

    def __post_init__(self) -> None:
        for name, kind in kinds_of(type(self)).items():  # first what may be the length of an array
            if isinstance(kind, Several):
                object.__setattr__(self, name, kind.checked(name, getattr(self, name)))
            elif not isinstance(kind, tuple):
                _check_kind(name, getattr(self, name), kind)
        quantities, axes = annotated_with(type(self), Quantity), annotated_with(type(self), Along)
        numbers_for_all = annotated_with(type(self), str).keys() & _fields(type(self))[1]
        for name, kind in _fields_of(self).items():
            if isinstance(kind, tuple):
                value = getattr(self, name)
                value = quantities[name](name, value) if name in quantities else value
                if name in numbers_for_all and array_of(name, value).ndim == 0:
                    value = np.full(kind, real_numbers(name, value))
                along = axes[name].axes if name in axes else ""
                object.__setattr__(self, name, member_array(name, value, kind, along))
        for name, rule in annotated_with(type(self), Rule).items():
            rule.check(name, getattr(self, name))

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={listed(getattr(self, name))}" for name in _fields_of(self))
        return f"{type(self).__name__}({fields})"

    def _repr_html_(self) -> str:
        name, fields = self.definition
        kinds = annotated_with(type(self), Quantity)
        angles = {field for field, quantity in kinds.items() if quantity.kind == "angle"}
        return text_table(name, {x: rounded(listed(value)) + " rad" * (x in angles) for x, value in fields.items()})

    @property
    def records(self) -> Iterator[Parametric]:
        """The records among the fields."""
        kind: Any = type(self)
        return (record for name in _fields_with_records(kind) for record in records_in(getattr(self, name)))

    @property
    def definition(self) -> tuple[str, dict[str, Any]]:
        """The name of what makes the record again, and its arguments by name: the class and its fields."""
        return type(self).__name__, {name: getattr(self, name) for name in _fields_of(self)}

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """Class and structural fields, which select the equations, without any real number."""
        fields = ((getattr(self, name), kind) for name, kind in _fields_of(self).items())
        own = (None if isinstance(kind, tuple) else of_each(value, _structure) for value, kind in fields)
        lengths = (getattr(self, name) for name in _lengths(type(self)))
        return type(self), *own, *lengths

    @cached_property
    def numbers(self) -> tuple[NDArray[np.float64], ...]:
        """The real parameters in the order of their declaration, each of shape () or (members,)."""
        return tuple(self._numbers())

    @cached_property
    def member_axis(self) -> tuple[int, ...]:
        """The shape of the member axis: (members,), or () for a single body and for numbers that broadcast."""
        shapes = {record.member_axis for record in self.records}
        for name, kind in _fields_of(self).items():
            value = getattr(self, name)
            if isinstance(kind, tuple) and isinstance(value, np.ndarray):
                shapes.add(value.shape[: value.ndim - len(kind)])
        return common_axis(f"the numbers of {type(self).__name__}", shapes)

    @property
    def _member_axes(self) -> dict[str, int]:
        kinds: dict[str, Any] = {**type(self).extra_numbers, **kinds_of(type(self))}
        numbers = {name: len(kind) for name in vars(self) if isinstance(kind := kinds.get(name), tuple)}
        return dict.fromkeys((name for name, value in self._own_values() if records_in(value)), 0) | numbers

    def _with_values(self, **values: Any) -> Self:
        arrays = {name: np.asarray(x) if isinstance(x, np.generic) else x for name, x in values.items()}
        chosen = self.unchecked(**dict(self._own_values()) | arrays)
        del vars(chosen)["member_axis"]  # which follows from the numbers
        return chosen

    def _own_values(self) -> Iterator[tuple[str, Any]]:
        """Yield the names and values of attributes that are not computed from others."""
        kind = type(self)
        each = vars(self).items()
        return ((name, x) for name, x in each if not isinstance(getattr(kind, name, None), functools.cached_property))

    def with_axes(self, axes: int) -> Self:
        """Return the record with numbers of shape (members, 1, ...) that broadcast against arrays of so many axes."""
        if not self.member_axis:
            return self
        if axes not in self._with_axes:
            self._with_axes[axes] = self.with_numbers(expanded(number, axes) for number in self.numbers)
        return self._with_axes[axes]

    @cached_property
    def _with_axes(self) -> dict[int, Self]:
        return {}

    def _numbers(self) -> Iterator[NDArray[np.float64]]:
        for name, kind in _fields_of(self).items():
            value = getattr(self, name)
            for record in records_in(value):
                yield from record.numbers
            if isinstance(value, functions.Vector):
                yield from value
            elif kind == () and not isinstance(value, np.ndarray):  # a scalar of another kind
                yield value
            elif isinstance(kind, tuple):
                rows = value.reshape(*value.shape[: value.ndim - len(kind)], math.prod(kind))
                yield from rows.T if rows.ndim < 3 else np.moveaxis(rows, -1, 0)

    def number_names(self) -> Iterator[tuple[str, tuple[int, str]]]:
        """Yield the name of each of `numbers`, and what is the same for one number of one record."""
        for name, kind in _fields_of(self).items():
            value = getattr(self, name)
            for i, record in enumerate(records_in(value)):
                place = f"{name}[{i}]" if isinstance(value, tuple) else name
                yield from ((f"{place}.{inner}", own) for inner, own in record.number_names())
            if isinstance(kind, tuple):
                brackets = ("".join(f"[{i}]" for i in index) for index in np.ndindex(kind))
                yield from ((f"{name}{end}", (id(self), f"{name}{end}")) for end in brackets)

    @cached_property
    def knots(self) -> NDArray[np.float64]:
        """Times, ascending, at which formulas or numbers change; those of the parts. A kernel stops at each."""
        kind: Any = type(self)
        return union_of_knots(self.records) if _fields_with_records(kind) else NO_KNOTS

    def between_knots(self, time: ArrayLike) -> Self:
        """Return the record between the knots around a time, or around each of an array of times."""
        if not self.knots.size:
            return self
        fields = {name: getattr(self, name) for name in _fields_of(self)}
        return self.unchecked(**{n: of_each(value, lambda x: x.between_knots(time)) for n, value in fields.items()})

    def with_numbers(self, scalars: Iterable[Scalar]) -> Self:
        """Return the same record with each real parameter replaced by the next scalar, of any kind."""
        fields, scalars = {}, iter(scalars)
        for name, kind in _fields_of(self).items():
            value = of_each(getattr(self, name), lambda x: x.with_numbers(scalars))
            fields[name] = _take(scalars, kind) if isinstance(kind, tuple) else value
        return self.unchecked(**fields)


@dataclasses.dataclass(frozen=True)
class Several:
    """The kind of a field that has any number of records of a class, and their order."""

    kind: type[Parametric]

    def checked(self, name: str, value: Any) -> tuple[Parametric, ...]:
        """Return the records of a list, or raise a TypeError."""
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise TypeError(f"{name} must be a list, each {_article(self.kind)}, got {described(value)}.")
        for i, item in enumerate(value):
            _check_kind(f"{name}[{i}]", item, self.kind)
        return tuple(value)


def records_in(value: Any) -> tuple[Parametric, ...]:
    """Return the record that a field has, or the several; none of a field that has something else."""
    if isinstance(value, Parametric):
        return (value,)
    return value if isinstance(value, tuple) and all(isinstance(item, Parametric) for item in value) else ()


def of_each(value: Any, change: Callable[[Any], Any]) -> Any:
    """Return what a change makes of the record that a field has, or of each of several; another value as it is."""
    if isinstance(value, Parametric):
        return change(value)
    changed = tuple(map(change, records_in(value)))
    return value if all(new is old for new, old in zip(changed, records_in(value), strict=True)) else changed


def _structure(record: Parametric) -> tuple[Any, ...]:
    return record.structure


def same(a: Parametric, b: Parametric) -> bool:
    """Return True if two records have equal numbers, whatever the shape of their members."""
    return a is b or (
        a.structure == b.structure
        and all(np.array_equal(np.ravel(x), np.ravel(y)) for x, y in zip(a.numbers, b.numbers, strict=True))
    )


class Tabulated(Protocol):
    """Record, or records taken together, which may contain tables."""

    @property
    def knots(self) -> NDArray[np.float64]:
        """Times at which the tables change their polynomials."""


def union_of_knots(records: Iterable[Tabulated]) -> NDArray[np.float64]:
    """Return the knots of all records, ascending."""
    some = [knots for record in records if (knots := record.knots).size]
    return functools.reduce(np.union1d, some) if some else NO_KNOTS


NO_KNOTS = np.empty(0)


def kinds_of(cls: type[Parametric]) -> dict[str, Any]:
    """Return the kind of each field by name: the shape of a real parameter, `Several`, or the class of another."""
    kinds: dict[str, Any] = _fields(cls)[0]
    return kinds


def _fields_of(record: Any) -> dict[str, Any]:
    kind: Any = record.__class__
    fields, with_names = _fields(kind)
    if not with_names:
        return fields
    return fields | {
        name: tuple(getattr(record, n) if isinstance(n, str) else n for n in fields[name]) for name in with_names
    }


@functools.cache
def _fields(cls: Any) -> tuple[dict[str, Any], list[str]]:
    """Return the kinds of the fields by name, and the names of those whose shape names an int field."""
    hints = hints_of(cls)
    kinds = {field.name: _kind(cls, field.name, hints[field.name]) for field in dataclasses.fields(cls)}
    return kinds, [
        name
        for name, kind in kinds.items()
        if isinstance(kind, tuple) and any(isinstance(length, str) for length in kind)
    ]


@functools.cache
def _lengths(cls: Any) -> list[str]:
    """Return the names of lengths in shapes that are no int fields."""
    kinds = kinds_of(cls)
    shapes = (kind for kind in kinds.values() if isinstance(kind, tuple))
    return list(dict.fromkeys(n for n in itertools.chain(*shapes) if isinstance(n, str) and n not in kinds))


@functools.cache
def _fields_with_records(cls: Any) -> list[str]:
    return [
        name
        for name, kind in kinds_of(cls).items()
        if isinstance(kind, Several) or any(issubclass(one, Parametric) for one in _classes(kind))
    ]


def _classes(kind: Any) -> tuple[type, ...]:
    """Return the classes of records, tables and shapes that a field may have: one class, or alternatives."""
    alternatives = get_args(kind) if isinstance(kind, UnionType) else (kind,)
    known = all(isinstance(one, type) and issubclass(one, Parametric | Structural) for one in alternatives)
    return alternatives if known else ()


def _kind(cls: type, name: str, hint: Any) -> Any:
    """Return the shape of a real parameter, or the class of anything else."""
    shape = next((extra for extra in extras_of(hint) if isinstance(extra, tuple)), None)
    if shape is not None or hint is float or quantity_of(hint):
        return shape or ()
    kinds = (hint, *get_args(hint)) if get_origin(hint) is Annotated else (hint,)  # class of the value that is stored
    if kind := next((x for x in kinds if x in (int, bool, str) or _classes(x)), None):
        return kind
    several = get_args(hint) if get_origin(hint) is tuple else ()
    if len(several) == 2 and several[1] is ... and issubclass(several[0], Parametric):
        return Several(several[0])
    raise TypeError(
        f"{cls.__name__}.{name} must be declared as float, Vector, BodyVector, SpaceVector, Annotated[Any, shape], "
        f"int, bool, str, Orbit or tuple[Orbit, ...], got {quoted(hint)}."
    )


def _check_kind(name: str, value: Any, kind: type | UnionType) -> None:
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise TypeError(f"{name} must be {_article(kind)}, got {described(value)}.")
    if isinstance(value, int) and abs(value) >= 2**63:
        raise ValueError(f"{name} must be an int of at most 63 bits, got one of {value.bit_length()} bits.")


def _take(scalars: Iterator[Scalar], shape: tuple[int, ...]) -> Any:
    """Return the next scalars as one scalar, a formula's vector, or an object array of a higher rank."""
    if len(shape) < 2:
        return functions.Vector(itertools.islice(scalars, shape[0])) if shape else next(scalars)
    taken = np.empty(shape, dtype=object)
    for index in np.ndindex(shape):
        taken[index] = next(scalars)
    return taken


def _article(kind: Any) -> str:
    if isinstance(kind, UnionType):
        return " or ".join(map(_article, get_args(kind)))
    return f"{'an' if kind.__name__[0] in 'AEIOaeio' else 'a'} {kind.__name__}"


def listed(value: Any) -> str:
    """Return an array by its numbers to 10 digits, a long one by its shape, anything else by its repr."""
    if not isinstance(value, np.ndarray):
        return f"{float(f'{value:.10g}')!r}" if isinstance(value, float) else repr(value)
    if value.size > 16 or value.dtype.kind != "f":
        return repr(value.tolist()) if value.size <= 16 else f"<array {value.shape}>"
    return repr(np.array([float(f"{number:.10g}") for number in value.flat]).reshape(value.shape).tolist())
