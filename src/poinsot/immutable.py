"""Objects whose attributes refuse assignment after construction, and whose arrays and dictionaries are read-only.

A kernel receives the numbers of a system when it runs, and later calls reuse derived numbers. A number that changed
after the construction would be shown and not integrated.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import operator
from abc import ABCMeta
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar

import numpy as np

from poinsot.printable import quoted
from poinsot.suggestions import refuse_attribute, refuse_call

__all__ = ["Immutable", "ReadOnlyDict", "cached_property", "copied", "owned", "read_only"]

Kind = TypeVar("Kind")

OPEN = "_under_construction"
"""The entry of an object's dictionary while its `__init__` runs."""


class ReadOnlyDict(dict[Any, Any]):
    """A dictionary that refuses every change."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a dictionary must stay as it was made, got a change. Change a copy, dict(...).")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return read_only, (dict(self),)


CONTAINERS = frozenset((np.ndarray, dict, tuple, list))
"""Classes of values that contain numbers which somebody could write."""


MAX_LEVELS = 64
"""Levels of lists, tuples and dictionaries within each other; an array has at most 64 axes."""


def read_only(value: Kind) -> Kind:
    """Return a value with its arrays made read-only in place; a dictionary becomes a `ReadOnlyDict`."""
    return _each(_locked, value)  # type: ignore[no-any-return]


def owned(value: Kind) -> Kind:
    """Return a value whose arrays nobody else can write: a writable array is copied, the user's stays writable."""
    return _each(_unshared, value)  # type: ignore[no-any-return]


def copied(value: Kind) -> Kind:
    """Return a value with copies of its arrays: SciPy's `Rotation.apply` and others refuse read-only vectors."""
    if isinstance(value, np.ndarray):
        return value.copy()
    return _each(np.copy, value)  # type: ignore[no-any-return]


def _each(change: Callable[[Any], Any], value: Any, level: int = 0) -> Any:
    """Return a value with its arrays changed, in dictionaries, tuples and lists too."""
    kind = value.__class__
    if kind is np.ndarray:
        return change(value)
    if level > MAX_LEVELS:
        raise ValueError(f"lists must contain each other at most {MAX_LEVELS} deep, got {quoted(value)} deeper.")
    if kind is dict:
        return ReadOnlyDict({name: _each(change, one, level + 1) for name, one in value.items()})
    if (kind is tuple or kind is list) and not CONTAINERS.isdisjoint(map(type, value)):
        changed = [_each(change, one, level + 1) for one in value]
        return value if all(map(operator.is_, changed, value)) else kind(changed)
    return value


def _locked(array: Any) -> Any:
    array.flags.writeable = False
    return array


def _unshared(array: Any) -> Any:
    """Return an array that nobody else can write: the array itself, or a read-only copy."""
    owner = array
    while owner.base.__class__ is np.ndarray:
        owner = owner.base
    return array if not owner.flags.writeable and owner.base is None else _locked(array.copy(order="K"))


def _seal(attributes: dict[str, Any], change: Any) -> None:
    for name, value in attributes.items():
        kind = value.__class__
        if kind in CONTAINERS and (kind is np.ndarray or name[0] != "_"):  # a private one may be a cache
            attributes[name] = change(value)


if TYPE_CHECKING:
    from abc import ABCMeta as Construction
    from functools import cached_property
else:

    class cached_property(functools.cached_property):  # noqa: N801
        """A cached property without a lock, as in Python 3.12, whose arrays are read-only.

        A lock doubles the time. Two threads may both compute a value; one of the two values stays.
        """

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            value = self.func(instance)
            if value.__class__ is np.ndarray or self.attrname[0] != "_":  # a private dictionary may be a cache
                value = read_only(value)
            instance.__dict__[self.attrname] = value
            return value

    class Construction(ABCMeta):
        """The class of immutable classes: it opens an object for its `__init__`, and closes the object afterwards."""

        _seals: bool

        def __call__(cls, *arguments: Any, **named: Any) -> Any:
            try:
                if not cls._seals:
                    return super().__call__(*arguments, **named)
                made = cls.__new__(cls, *arguments, **named)
                attributes = made.__dict__
                attributes[OPEN] = True
                made.__init__(*arguments, **named)
            except TypeError:
                refuse_call(cls.__name__, cls.__init__, (None, *arguments), named)
                raise
            del attributes[OPEN]
            _seal(attributes, owned)
            return made

        def __getattr__(cls, name: str) -> NoReturn:
            refuse_attribute(cls, name)

        @property
        def __signature__(cls) -> inspect.Signature:
            """The arguments of `__init__`, for `inspect.signature`."""
            if cls.__init__ is object.__init__:
                return inspect.Signature()
            signature = inspect.signature(cls.__init__)
            return signature.replace(parameters=list(signature.parameters.values())[1:])


def _refuse_defaults_without_annotation(cls: type) -> None:
    """Raise a TypeError for a default of an inherited field without an annotation, which a dataclass ignores.

    The `__init__` of the class would assign the default of the base class. A method or a property is no default.
    """
    fields = dataclasses.fields(cls) if dataclasses.is_dataclass(cls) else ()
    for name in sorted({field.name for field in fields} - inspect.get_annotations(cls).keys()):
        for owner in cls.__mro__:
            if name in vars(owner):
                is_field = "__dataclass_fields__" in vars(owner) and name in inspect.get_annotations(owner)
                if not is_field and not hasattr(value := vars(owner)[name], "__get__"):
                    raise TypeError(
                        f"{name} of {cls.__name__} must have an annotation, got the default {quoted(value)} without "
                        "one. Repeat the annotation of the base class, as in `gain: float = 0.3`."
                    )
                break


class Immutable(metaclass=Construction):
    """Base of objects that stay as they were made.

    `__init__` may assign attributes. After it public attributes refuse assignment, arrays refuse writing, and
    dictionaries refuse new entries; an array that the user gave has been copied.
    """

    _seals: ClassVar[bool] = True
    """True if the values that `__init__` sets are sealed. False for an object whose values are always sealed."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        _refuse_defaults_without_annotation(cls)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            if any(name in vars(cls) for cls in type(self).__mro__):
                object.__getattribute__(self, name)  # a property that raised an AttributeError raises it again
            refuse_attribute(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name[0] != "_" and OPEN not in self.__dict__:
            self._refuse_change(name)
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        self._refuse_change(name)

    def _refuse_change(self, name: str) -> NoReturn:
        kind = type(self).__name__
        raise dataclasses.FrozenInstanceError(
            f"{kind}.{name} must stay as it was made, got another value. Make another {kind}."
        )

    def _complete(self, **attributes: Any) -> None:
        """Set attributes that only the maker of the object knows."""
        self.__dict__.update({name: owned(value) for name, value in attributes.items()})

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a pickled or copied object; NumPy does not store whether an array is read-only."""
        self.__dict__.update(state)
        _seal(self.__dict__, read_only)
