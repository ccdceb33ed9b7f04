"""Digest of the definition of a problem, equal for equal definitions in any process."""

from __future__ import annotations

import contextlib
import functools
import hashlib
from collections.abc import Iterator, Mapping
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

__all__ = ["digests", "fingerprint"]


def fingerprint(value: Any) -> str:
    """Return the SHA-256 of a system, arrays, texts, numbers, records of any class, or a user's function.

    Classes and modules count by their qualified names, functions by their code and the values that they close over,
    an object with a `definition` by the values in it, and what cannot be written down, such as a lock, by its class.
    """
    digest = hashlib.sha256()
    for piece in _pieces(value, ()):
        digest.update(piece)
        digest.update(b"\0")
    return digest.hexdigest()


def digests(problem: Mapping[str, Any]) -> dict[str, str]:
    """Return the digest of each argument of a problem."""
    return {name: fingerprint(value) for name, value in problem.items()}


def _pieces(value: Any, within: tuple[int, ...]) -> Iterator[bytes]:
    if id(value) in within:
        yield f"the {within.index(id(value))}th before".encode()
        return
    yield _name(value).encode()
    plain = value is None or isinstance(value, str | bytes | int | float | complex | type)
    if plain:
        yield value.__qualname__.encode() if isinstance(value, type) else repr(value).encode()
    elif isinstance(value, np.ndarray | np.generic) and value.dtype != object:
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    else:
        for inner in _inside(value):
            yield from _pieces(inner, (*within, id(value)))
        yield b"the end"


def _inside(value: Any) -> Iterator[Any]:
    """Yield the parts of a value, each name before its value."""
    if isinstance(value, Mapping):
        for name, each in value.items():
            yield from (name, each)
    elif isinstance(value, set | frozenset):
        yield from sorted(map(fingerprint, value))
    elif isinstance(value, list | tuple | np.ndarray):
        yield from value
    elif isinstance(value, FunctionType | MethodType | functools.partial | CodeType):
        yield from _of_code(value)
    elif hasattr(type(value), "definition"):
        yield from value.definition
    else:
        yield from _own(value)


def _of_code(value: Any) -> Iterator[Any]:
    if isinstance(value, functools.partial):
        yield from (value.func, value.args, value.keywords)
    elif isinstance(value, MethodType):
        yield from (value.__func__, value.__self__)
    elif isinstance(value, CodeType):
        yield from (value.co_code, value.co_names, value.co_consts)
    else:
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        yield from (value.__module__, value.__qualname__, value.__code__, cells)
        yield from (value.__defaults__, value.__kwdefaults__)


def _own(value: Any) -> Iterator[Any]:
    """Yield the attributes of an object of any class, without the values of cached properties."""
    classes = type(value).__mro__
    cached = {
        name for kind in classes for name, each in vars(kind).items() if isinstance(each, functools.cached_property)
    }
    own = {"name": value.__name__} if isinstance(value, ModuleType) else getattr(value, "__dict__", None)
    if own is None:
        with contextlib.suppress(TypeError):  # a lock, a generator
            state = value.__reduce_ex__(2)
            yield from (state[1:3] if isinstance(state, tuple) else (state,))
        return
    for name in sorted(own.keys() - cached):
        yield from (name, own[name])


def _name(value: Any) -> str:
    return f"{type(value).__module__}.{type(value).__qualname__}"
