"""Random numbers that depend on a key and a count alone: their generator has no state.

Integers are arrays of 64 bits, or values of a kernel with the same operators.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.functions import Scalar

__all__ = ["UNUSED_BITS", "key_of", "normal_numbers", "normals", "uniform", "words"]

STRIDE = 0x9E3779B97F4A7C15
"""2^64 over the golden ratio, odd: the step from one word to the next."""

FACTORS = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB

UNUSED_BITS = 12
"""Bits of a word that are left: a number and a half have room for the others."""


class Integer(Protocol):
    """Integer of 64 bits, whose sums and products are modulo 2^64: an array, or a value of a kernel."""

    def __add__(self, other: Any, /) -> Self: ...
    def __mul__(self, other: Any, /) -> Self: ...
    def __xor__(self, other: Any, /) -> Self: ...
    def __rshift__(self, other: Any, /) -> Self: ...


class Real(Protocol):
    """Real number: a float, an array, or a value of a kernel."""

    def __add__(self, other: Any, /) -> Self: ...
    def __mul__(self, other: Any, /) -> Self: ...


Word = TypeVar("Word", bound=Integer)
Number = TypeVar("Number", bound=Real)
Drawn = TypeVar("Drawn", bound=Scalar)


def mixed(word: Word) -> Word:
    """Return a word whose bits each depend on all bits of another word (Steele, Lea, Flood 2014: SplitMix)."""
    word = (word ^ (word >> 30)) * FACTORS[0]
    word = (word ^ (word >> 27)) * FACTORS[1]
    return word ^ (word >> 31)


def key_of(seed: ArrayLike, member: ArrayLike) -> NDArray[np.integer]:
    """Return the keys of seeds and members, whole numbers below 2^53; shape (...)."""
    seeds, members = (np.atleast_1d(x).astype(np.uint64) for x in (seed, member))
    return mixed(mixed(seeds * np.uint64(STRIDE)) + (members + np.uint64(1)) * np.uint64(STRIDE))


def words(key: Word, number: Word, count: int) -> list[Word]:
    """Return independent words of 64 bits for a key and the number of a sample."""
    first = mixed(key + number * STRIDE)
    return [mixed(first + (i + 1) * STRIDE % 2**64) for i in range(count)]


def uniform(whole: Number) -> Number:
    """Return the number between 0 and 1, both excluded, that a whole number below 2^52 stands for."""
    return whole * 2.0**-52 + 2.0**-53


def normals(between: Sequence[Drawn]) -> list[Drawn]:
    """Return numbers of the standard normal distribution from an even count of uniform ones (Box and Muller)."""
    found = list[Drawn]()
    for size, angle in zip(between[::2], between[1::2], strict=True):
        radius, turn = functions.sqrt(-2.0 * functions.log(size)), 2.0 * functions.pi * angle
        found += [radius * functions.cos(turn), radius * functions.sin(turn)]  # type: ignore[list-item]
    return found


def normal_numbers(seed: int, members: int, samples: int, count: int) -> NDArray[np.float64]:
    """Return independent standard normal numbers for each member and sample; shape (members, samples, count)."""
    keys = key_of(float(seed), np.arange(members))[:, None]
    drawn = words(keys, np.arange(samples, dtype=np.uint64), count + count % 2)
    between = [uniform((word >> UNUSED_BITS).astype(float)) for word in drawn]
    return np.stack(normals(between)[:count], axis=-1)
