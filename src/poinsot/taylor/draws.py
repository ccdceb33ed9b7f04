"""Numbers drawn at random that depend on a key and a count alone: a generator without a state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.functions import Scalar

__all__ = ["UNUSED_BITS", "key_of", "normals", "uniform", "uniforms", "words"]

STRIDE = 0x9E3779B97F4A7C15
"""2^64 over the golden ratio, odd: the step from one word to the next."""

FACTORS = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB

UNUSED_BITS = 12
"""Bits of a word that are left: a number and a half have room for the others."""


def mixed(word: Any) -> Any:
    """Return a word of 64 bits, each of whose bits depends on all of another one (Steele, Lea, Flood 2014: SplitMix).

    Integers of any kind whose products are modulo 2^64.
    """
    word = (word ^ (word >> 30)) * FACTORS[0]
    word = (word ^ (word >> 27)) * FACTORS[1]
    return word ^ (word >> 31)


def key_of(seed: Any, member: Any) -> NDArray[np.uint64]:
    """Return the keys of seeds and members, whole numbers below 2^53; shape (...)."""
    seeds, members = (np.atleast_1d(x).astype(np.uint64) for x in (seed, member))
    keys: NDArray[np.uint64] = mixed(mixed(seeds * np.uint64(STRIDE)) + (members + np.uint64(1)) * np.uint64(STRIDE))
    return keys


def words(key: Any, number: Any, count: int) -> list[Any]:
    """Return independent words of 64 bits for a key and the number of a sample."""
    first = mixed(key + number * STRIDE)
    return [mixed(first + (i + 1) * STRIDE % 2**64) for i in range(count)]


def uniforms(keys: NDArray[np.uint64], numbers: ArrayLike, count: int) -> list[NDArray[np.float64]]:
    """Return independent numbers between 0 and 1, both excluded: arrays of the shape of the keys."""
    found = words(keys, np.asarray(numbers).astype(np.int64).astype(np.uint64), count)
    return [uniform((word >> UNUSED_BITS).astype(float)) for word in found]


def uniform(whole: Any) -> Any:
    """Return the number between 0 and 1 that a whole number below 2^52 stands for."""
    return whole * 2.0**-52 + 2.0**-53


def normals(between: Sequence[Scalar]) -> list[Scalar]:
    """Return numbers of the standard normal distribution from an even count of uniform ones (Box and Muller)."""
    found = list[Scalar]()
    for size, angle in zip(between[::2], between[1::2], strict=True):
        radius, turn = functions.sqrt(-2.0 * functions.log(size)), 2.0 * functions.pi * angle
        found += [radius * functions.cos(turn), radius * functions.sin(turn)]
    return found
