"""Objects whose attributes refuse assignment after construction, and whose arrays and dictionaries are read-only.

A kernel receives the numbers of a system when it runs, and later calls reuse derived numbers. A number that changed
after the construction would be shown and not integrated.
"""

from __future__ import annotations

import dataclasses
import inspect
import operator
from abc import ABCMeta
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

__all__ = ["Immutable", "ReadOnlyDict", "copied", "owned", "read_only"]

OPEN = "_under_construction"
"""The entry of an object's dictionary while its `__init__` runs."""


class ReadOnlyDict(dict[Any, Any]):
    """A dictionary that refuses every change."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a dictionary must stay as it was made, got a change. Change a copy, dict(...).")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return read_only, (dict(self),)


CONTAINERS = frozenset((np.ndarray, dict, tuple, list))
"""Classes of values that contain numbers which somebody could write."""


def read_only(value: Any) -> Any:
    """Return a value with its arrays made read-only in place; a dictionary becomes a `ReadOnlyDict`."""
    return _each(_locked, value)


def owned(value: Any) -> Any:
    """Return a value whose arrays nobody else can write: a writable array is copied, the user's stays writable."""
    return _each(_unshared, value)


def copied(value: Any) -> Any:
    """Return a value with copies of its arrays: SciPy's `Rotation.apply` and others refuse read-only vectors."""
    return value.copy() if value.__class__ is np.ndarray else _each(np.copy, value)


def _each(change: Any, value: Any) -> Any:
    """Return a value with its arrays changed, in dictionaries, tuples and lists too."""
    kind = value.__class__
    if kind is np.ndarray:
        return change(value)
    if kind is dict:
        return ReadOnlyDict({name: _each(change, one) for name, one in value.items()})
    if (kind is tuple or kind is list) and not CONTAINERS.isdisjoint(map(type, value)):
        changed = [_each(change, one) for one in value]
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


class Construction(ABCMeta):
    """The class of immutable classes: it opens an object for its `__init__`, and closes the object afterwards."""

    _seals: bool

    def __call__(cls, *arguments: Any, **named: Any) -> Any:
        if not cls._seals:
            return super().__call__(*arguments, **named)
        made = cls.__new__(cls, *arguments, **named)
        attributes = made.__dict__
        attributes[OPEN] = True
        made.__init__(*arguments, **named)
        del attributes[OPEN]
        _seal(attributes, owned)
        return made

    @property
    def __signature__(cls) -> inspect.Signature:
        """The arguments of `__init__`, for `inspect.signature`."""
        if cls.__init__ is object.__init__:  # type: ignore[misc]
            return inspect.Signature()
        signature = inspect.signature(cls.__init__)  # type: ignore[misc]
        return signature.replace(parameters=list(signature.parameters.values())[1:])


class Immutable(metaclass=ABCMeta if TYPE_CHECKING else Construction):
    """Base of objects that stay as they were made.

    `__init__` may assign attributes. After it public attributes refuse assignment, arrays refuse writing, and
    dictionaries refuse new entries; an array that the user gave has been copied.
    """

    _seals: ClassVar[bool] = True
    """Whether the values that `__init__` sets are sealed. False for an object of sealed values in every run."""

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
