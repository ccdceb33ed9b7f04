"""Numbers of members together with arrays of members and times.

A state of an ensemble has the shape (members, ...), an array of its motion (members, times, ...), and a parameter
(members, ...). `expanded` inserts the axes that a parameter lacks, so that NumPy broadcasts members against members.
An array of times alone, of shape (times,), is common to all members; any other array has the members first.

`members_of` selects members of any object that declares which of its attributes depend on the member, see `OfMembers`.
"""

from __future__ import annotations

import functools
import inspect
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol, Self, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra.quaternion import assemble, components
from poinsot.errors import real_numbers, reals_or_nan
from poinsot.functions import Vector

__all__ = [
    "Components",
    "EveryMember",
    "Members",
    "OfMembers",
    "at_times",
    "common_axis",
    "expanded",
    "inherited_formula",
    "members_of",
    "of_arrays",
    "of_scalars",
    "of_times",
    "with_times",
]

Method = TypeVar("Method", bound=Callable[..., Any])
Shape = tuple[int, ...]
Kinds = tuple[str, ...]

Components = Any
"""A vector of scalars, or an array with the components as its last axis."""

Members = int | slice | NDArray[Any]
"""Number of one member, or a slice or an array of numbers or truth values that selects several."""


class OfMembers(Protocol):
    """Object some of whose numbers may have one value for each member."""

    @property
    def _member_axes(self) -> Mapping[str, int]:
        """Map from each attribute that may depend on the member to the axes that its arrays have for one member."""

    def _with_values(self, *_: Any, **values: Any) -> Self:
        """Return the object with other values of all the attributes in `_member_axes`, given by name."""


Thing = TypeVar("Thing", bound=OfMembers)


class EveryMember:
    """Numbers 0, 1, 2, ... of the members of an ensemble of any size, from which some can be selected."""

    def __getitem__(self, members: Members) -> NDArray[np.int_]:
        return np.asarray(np.r_[members])


def members_of(thing: Thing, members: Members) -> Thing:
    """Return one member of an ensemble, for an `int`, or the ensemble of several members.

    `thing` is a record, state, system, event, problem, state vector, run, or any other object that declares its numbers
    of members, see `OfMembers`. Numbers that all members share stay. An object without numbers of members is returned
    as it is.
    """
    old = {name: getattr(thing, name) for name in thing._member_axes}
    new = {name: _selected(old[name], axes, members) for name, axes in thing._member_axes.items()}
    return thing if _all_same(old.values(), new.values()) else thing._with_values(**new)


def _selected(value: object, axes: int, members: Members) -> object:
    """Return a value for some members; arrays of more than so many axes have the members first."""
    if isinstance(value, np.ndarray):
        return value[members] if value.ndim > axes else value
    if isinstance(value, EveryMember):
        return value[members]
    if _depends_on_members(value):
        return members_of(value, members)
    if isinstance(value, Mapping):
        found = {name: _selected(each, axes, members) for name, each in value.items()}
        return value if _all_same(value.values(), found.values()) else found
    if type(value) is tuple:
        each = tuple(_selected(one, axes, members) for one in value)
        return value if _all_same(value, each) else each
    return value


def _depends_on_members(value: object) -> TypeGuard[OfMembers]:
    return hasattr(type(value), "_member_axes")


def _all_same(old: Iterable[object], new: Iterable[object]) -> bool:
    return all(map(operator.is_, old, new))


def expanded(numbers: Any, axes: int, components: int = 0) -> NDArray[Any]:
    """Return an array with axes of length one after the member axis, so many axes in all before its components."""
    array = np.asarray(numbers)
    own = array.ndim - components
    return array.reshape((*array.shape[:own], *(1,) * (axes - own), *array.shape[own:]))


def common_axis(owner: str, shapes: set[Shape]) -> Shape:
    """Return the one shape of the member axis among several, () where none has members; raise a ValueError for two."""
    found = shapes - {()}
    if len(found) > 1:
        counts = " and ".join(str(shape[0]) for shape in sorted(found))
        raise ValueError(f"{owner} must have equally many members, got {counts}.")
    return found.pop() if found else ()


def with_times(record: Any, time: Any) -> tuple[Any, Any]:
    """Return a record and times that broadcast: (members, 1) and (1, times), or as they are for a single body.

    `record` has a `member_axis` and a method `with_axes`. The times of shape (times,) are common to all members.
    """
    if not record.member_axis:
        return record, time
    time = _common_times(record, time)
    return record.with_axes(np.ndim(time)), time


def at_times(function: Callable[[Any, Any], Any], record: Any, time: Any) -> Any:
    """Return the scalars of a function of a record and the time; of members, each of shape (members, times)."""
    twin, time = with_times(record, time)
    if twin is record:
        return function(record, time)
    shape = (*record.member_axis, *np.shape(time)[1:])
    return _each(function(twin, time), lambda x: np.broadcast_to(x, shape))


def _common_times(record: Any, time: Any) -> Any:
    if not isinstance(time, np.ndarray) or not time.ndim:
        return time
    time = time[None] if time.ndim == 1 else time
    (count,) = record.member_axis
    if time.shape[0] not in (1, count):
        raise ValueError(
            f"time must have shape (), (times,) or (members, times) with {count} members, got shape {time.shape}."
        )
    return time


def of_scalars(method: Method, kinds: Kinds | None = None) -> Method:
    """Mark a method of a record as a formula on scalars: of members it runs on numbers that broadcast.

    Vectors of scalars are `Vector`, or arrays with their components first; arguments that are annotated as `Scalar` are
    scalars, or arrays of them. Overrides of a marked method are marked, too, with the same kinds of arguments.
    """
    known = kinds or _kinds(method)
    return _marked(method, functools.partial(of_scalars, kinds=known), functools.partial(_on_members, method, known))


def of_times(method: Method) -> Method:
    """Mark a method of a record that returns an array (..., components) for a time or an array of times."""

    def run(record: Any, arguments: Sequence[Any]) -> Any:
        twin, time = with_times(record, real_numbers("time", arguments[0]))
        return method(twin, time)

    return _marked(method, of_times, run)


def of_arrays(
    taken: Callable[[str, Any], NDArray[Any]] = reals_or_nan, native: bool = False, **shapes: tuple[Any, ...]
) -> Callable[[Method], Method]:
    """Mark a formula whose arguments may also be arrays with their components last, and which then returns an array.

    Parameters
    ----------
    taken : function of a name and a value
        Returns the value as an array, or raises an error.
    native : bool
        Whether the method itself computes with arrays of a single body.
    **shapes
        The shape of the components of each argument; a text is the name of an attribute.
    """

    def decorated(method: Method) -> Method:
        kinds = ("scalar" if shape == () else "vector" for shape in shapes.values())
        on_members = functools.partial(_on_members, method, tuple(kinds))

        def run(record: Any, arguments: Sequence[Any]) -> Any:
            each = zip(shapes.items(), arguments, strict=True)
            found = [_components(record, name, value, shape, taken) for (name, shape), value in each]
            result = on_members(record, found)
            is_array = [new is not old for new, old in zip(found, arguments, strict=True) if isinstance(new, Vector)]
            return assemble(result) if isinstance(result, Vector) and any(is_array) else result

        return _marked(method, decorated, run, always=not native)

    return decorated


def inherited_formula(cls: type, name: str) -> Callable[[Any], Any] | None:
    """Return the mark of a method that a class overrides; None of any other attribute."""
    function = vars(cls)[name]
    if not inspect.isfunction(function) or hasattr(function, "mark"):
        return None
    marks = (getattr(vars(base).get(name), "mark", None) for base in cls.__mro__[1:])
    return next((mark for mark in marks if mark is not None), None)


def _kinds(method: Any) -> Kinds:
    """Return "time", "scalar" or "vector" for each argument of a formula."""
    arguments = _arguments(method)
    return tuple("time" if x.name == "time" else "scalar" if x.annotation == "Scalar" else "vector" for x in arguments)


def _arguments(method: Any) -> list[inspect.Parameter]:
    return [*inspect.signature(method).parameters.values()][1:]


def _marked(method: Method, mark: Any, run: Callable[[Any, Sequence[Any]], Any], always: bool = False) -> Method:
    signature = inspect.signature(method)

    @functools.wraps(method)
    def called(self: Any, *given: Any, **named: Any) -> Any:
        if not (always or self.member_axis):
            return method(self, *given, **named)
        arguments = [*signature.bind(self, *given, **named).arguments.values()][1:]
        return run(self, [argument for argument in arguments if argument is not None])

    called.mark = mark  # type: ignore[attr-defined]
    marked: Any = called
    return marked  # type: ignore[no-any-return]


def _on_members(method: Any, kinds: Kinds, record: Any, arguments: Sequence[Any]) -> Any:
    """Return what a formula gives for the numbers of all members, with arguments that broadcast against them."""
    if not record.member_axis:
        return method(record, *arguments)
    kinds = kinds[: len(arguments)]
    found = [_scalars(value, kind) for kind, value in zip(kinds, arguments, strict=True)]
    others = [len(_shape(value)) for kind, value in zip(kinds, found, strict=True) if kind != "time"]
    if max(others, default=0) != 1:  # else they are states of members, and so are their times
        found = [_common_times(record, x) if kind == "time" else x for kind, x in zip(kinds, found, strict=True)]
    names = [argument.name for argument in _arguments(method)][: len(found)]
    shape = _joint_shape(record, dict(zip(names, found, strict=True)))
    result = method(record.with_axes(len(shape)), *(_with_axes(x, len(shape)) for x in found))
    return _each(result, lambda x: np.broadcast_to(x, shape))


def _joint_shape(record: Any, arguments: Mapping[str, Any]) -> Shape:
    """Return the shape, members first, of the arguments of a formula together with the members of a record."""
    (count,), shapes = record.member_axis, {name: _shape(value) for name, value in arguments.items()}
    axes = max(1, *map(len, shapes.values())) if shapes else 1
    for name, shape in shapes.items():
        if shape and shape[0] not in (1, count):
            raise ValueError(f"{name} must have the {count} members as its first axis, got shape {shape}.")
    filled = (shape + (1,) * (axes - len(shape)) for shape in shapes.values())
    return np.broadcast_shapes((count, *(1,) * (axes - 1)), *filled)


def _scalars(value: Any, kind: str) -> Any:
    """Return an argument as a scalar, or as a `Vector` of the items of its first axis."""
    if not isinstance(value, np.ndarray | list | tuple):
        return value
    return Vector(value) if kind == "vector" and np.ndim(value) else np.asarray(value)


def _shape(value: Any) -> Shape:
    """Return the shape of a scalar, of the scalars of a vector or a matrix, or of an instant."""
    if isinstance(value, Vector):
        return np.broadcast_shapes(*map(_shape, value))
    shape = getattr(value, "shape", ())
    return shape if isinstance(shape, tuple) else ()


def _with_axes(value: Any, axes: int) -> Any:
    """Return an argument of a formula with its arrays expanded."""
    return _each(value, lambda x: expanded(x, axes) if np.ndim(x) else x)


def _each(value: Any, change: Callable[[Any], Any]) -> Any:
    """Return a formula's argument or result with each of its numbers and arrays changed."""
    if isinstance(value, Vector):
        return Vector(_each(x, change) for x in value)
    if type(value) is tuple:
        made = [_each(x, change) for x in value]
        return type(value)(*made) if hasattr(value, "_fields") else tuple(made)
    if isinstance(value, Mapping):
        return {name: _each(x, change) for name, x in value.items()}
    is_number = isinstance(value, float | int | np.generic | np.ndarray) and np.asarray(value).dtype != object
    return change(value) if is_number else value


def _components(record: Any, name: str, value: Any, shape: tuple[Any, ...], taken: Callable[..., Any]) -> Any:
    """Return an array (..., components) as a `Vector` of its components, and anything else as it is."""
    if isinstance(value, Vector) or (not shape and not isinstance(value, list | tuple)):
        return value
    array = taken(name, value)
    if not shape:
        return array
    (length,) = (getattr(record, count) if isinstance(count, str) else count for count in shape)
    array = array[None] if not array.ndim and length == 1 else array
    if array.shape[-1:] != (length,):
        raise ValueError(f"{name} must have shape (..., {length}), got shape {array.shape}.")
    return Vector(components(array))
