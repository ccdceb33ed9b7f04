"""Tangent vectors and derivatives by parameters as variables of a kernel.

Their equations are linear: a vector is integrated as u 2^n with a small u. Now and then a u that has grown is made
small again by a power of two, and n raised.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["INPUT_UNIT", "STEPS_AT_A_TIME", "Variations"]

Array = NDArray[np.float64]
Rows = TypeVar("Rows", NDArray[np.float64], NDArray[np.floating], NDArray[np.object_])

INITIAL_EXPONENT = -10
"""Binary exponent of a vector at the start: large enough for the step control where the motion itself is at rest."""

MAX_GROWTH_BITS = 8
"""Growth in bits above the initial exponent at which a vector is rescaled."""

STEPS_AT_A_TIME = {1: 700, 2: 300}
"""Steps between two checks of the size of the vectors, by order; the first check comes after a tenth of them.

A vector that doubles in every step does not overflow in so many; one that grows like the time does not outgrow the
attitude, which would loosen the step control. One that grows exponentially may: it has steps as short as the motion.
"""

COUNT_UNIT = 2.0**-20
"""Unit of the variable n, so that n stays below the attitude in the step control."""


INPUT_UNIT = 2.0**-200
"""Unit of the units of inputs, so that they stay below the attitude in the step control."""

MAX_EXPONENT = 180
"""Largest binary exponent of the size of an input."""


@dataclass(frozen=True)
class Variations:
    """Tangent vectors and derivatives by parameters as variables of a kernel.

    Parameters
    ----------
    scaled : tuple of bool
        Of the k tangent coordinates, which scale as momenta do.
    count : int
        How many are tangent vectors.
    inputs : tuple of tuples of int
        Of the others, which are derivatives: the inputs of the kernel that change together.
    order : {1, 2}
        Whether there are second derivatives too, one for each two vectors.
    initial : array (..., count, k)
        The tangent vectors at the start, of size one, with members first.
    sizes : array of int (inputs,) or (members, inputs)
        Binary exponents of about what the inputs change by: where the derivative by one is a small number, the step
        control would not see it.
    """

    scaled: tuple[bool, ...]
    count: int
    inputs: tuple[tuple[int, ...], ...] = ()
    order: int = 1
    initial: Array | None = field(default=None, compare=False)
    sizes: NDArray[np.int_] | tuple[()] = field(default=(), compare=False)

    @property
    def size(self) -> int:
        """Number of variables: u of each vector and of each pair, n of each vector, and the unit of each input."""
        return (self.total + len(self.pairs)) * len(self.scaled) + self.total + len(self.inputs)

    @property
    def total(self) -> int:
        """Number of vectors."""
        return self.count + len(self.inputs)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of vectors with second derivatives."""
        return [(a, b) for a in range(self.total) for b in range(a + 1)] if self.order == 2 else []

    @property
    def momenta(self) -> list[int]:
        """Places of the variables that scale like momenta."""
        return [place for place, scales in enumerate(self.scaled * (self.total + len(self.pairs))) if scales]

    def split(self, rows: Rows) -> tuple[Rows, Rows, Rows, Rows]:
        """Return views of u (..., vectors, k), of pairs (..., pairs, k), of n and of units in rows of variables."""
        k, first, second = len(self.scaled), self.total * len(self.scaled), len(self.pairs) * len(self.scaled)
        u, pairs, n, units = np.split(rows, [first, first + second, first + second + self.total], axis=-1)
        return u.reshape(*u.shape[:-1], -1, k), pairs.reshape(*pairs.shape[:-1], len(self.pairs), k), n, units

    def start(self) -> Array:
        """Return the variables at the start; shape (..., size)."""
        vectors = np.ldexp(np.asarray(self.initial, dtype=float), INITIAL_EXPONENT)
        rows = np.zeros((*vectors.shape[:-2], self.size))
        rows[..., : self.count * len(self.scaled)] = vectors.reshape(*vectors.shape[:-2], -1)
        sizes = np.minimum(self.sizes if np.size(self.sizes) else np.zeros(len(self.inputs), dtype=int), MAX_EXPONENT)
        _, _, n, units = self.split(rows)
        units[...], n[..., self.count :] = INPUT_UNIT * np.exp2(INITIAL_EXPONENT + sizes), -COUNT_UNIT * sizes
        return rows

    def rescale(self, rows: Array) -> None:
        """Rescale vectors that have grown, in rows of variables; shape (..., size)."""
        u, _, n, units = self.split(rows)
        _, bits = np.frexp(np.max(np.abs(u), axis=-1))
        bits = np.where(bits > INITIAL_EXPONENT + MAX_GROWTH_BITS, bits - INITIAL_EXPONENT, 0)
        if not np.any(bits):
            return
        of_pairs = [bits[..., a] + bits[..., b] for a, b in self.pairs]
        k, own = len(self.scaled), self.total * len(self.scaled)
        rows[..., :own] = np.ldexp(rows[..., :own], -np.repeat(bits, k, axis=-1))
        for i, both in enumerate(of_pairs):
            pair = slice(own + i * k, own + (i + 1) * k)
            rows[..., pair] = np.ldexp(rows[..., pair], -both[..., None])
        n += COUNT_UNIT * bits
        units[...] = np.ldexp(units, -bits[..., self.count :])

    def read(self, rows: Array) -> tuple[Array, Array, Array]:
        """Return u of vectors (..., vectors, k) and of pairs (..., pairs, k), and exponents n (..., vectors).

        A vector is u 2^n, the second derivative of a pair u 2^(n + n).
        """
        u, pairs, n, _ = self.split(rows)
        unit = 2.0**-INITIAL_EXPONENT  # exact, and several times as fast as ldexp
        return u * unit, pairs * unit**2, n / COUNT_UNIT
