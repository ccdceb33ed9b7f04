"""Neighbours of a motion: tangent vectors and derivatives by parameters, integrated along with it.

A vector is u 2^n with a small u, whose size means nothing in linear equations. Now and then a u that has grown is made
small again, by a power of two, and n is raised.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.engine.linear import NONE, Linearization

__all__ = ["STEPS_AT_A_TIME", "Neighbours"]

Array = NDArray[np.float64]

FIRST_BITS = -10
"""Binary exponent of a vector at the start: large enough for the step control where the motion itself is at rest."""

GROWN = 8
"""Bits above that, from which on a vector is brought back."""

STEPS_AT_A_TIME = {1: 700, 2: 300}
"""Steps between two looks at the size of the vectors, by order; between the first two, a tenth.

A vector that doubles in every step does not overflow in so many; one that grows like the time does not outgrow the
attitude, which would loosen the step control. One that grows exponentially may: it has steps as short as the motion.
"""

COUNTED = 2.0**-20
"""What the variable n counts in, to stay below the attitude for the engine's step control."""


@dataclass(frozen=True)
class Neighbours:
    """A companion of vectors.

    Parameters
    ----------
    tangent : tuple of int
        The tangent coordinates that the formulation has, k of them.
    count : int
        How many are tangent vectors.
    inputs : tuple of tuples of int
        Of the others, which are derivatives: the inputs of the kernel that change together.
    order : {1, 2}
        Whether there are second derivatives too, one for each two vectors.
    vectors : array (..., count, k)
        The tangent vectors at the start, of size one, with members first.
    """

    tangent: tuple[int, ...]
    count: int
    inputs: tuple[tuple[int, ...], ...] = ()
    order: int = 1
    vectors: Any = field(default=None, compare=False)

    @property
    def size(self) -> int:
        """How many variables: u of each vector and of each pair, n of each vector, and the unit of each input."""
        return (self.total + len(self.pairs)) * len(self.tangent) + self.total + len(self.inputs)

    @property
    def total(self) -> int:
        """How many vectors."""
        return self.count + len(self.inputs)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """The pairs of vectors with second derivatives."""
        return [(a, b) for a in range(self.total) for b in range(a + 1)] if self.order == 2 else []

    @property
    def momenta(self) -> list[int]:
        """Which of the variables are components of changes of momenta."""
        k, vectors = len(self.tangent), self.total + len(self.pairs)
        return [i * k + j for i in range(vectors) for j, place in enumerate(self.tangent) if place >= 3]

    def _split(self, rows: Any) -> tuple[Any, Any, Any, Any]:
        """Return views of u (..., vectors, k), of pairs (..., pairs, k), of n and of units in rows of variables."""
        k, first, second = len(self.tangent), self.total * len(self.tangent), len(self.pairs) * len(self.tangent)
        u, pairs, n, units = np.split(rows, [first, first + second, first + second + self.total], axis=-1)
        return u.reshape(*u.shape[:-1], -1, k), pairs.reshape(*pairs.shape[:-1], len(self.pairs), k), n, units

    def start(self) -> Array:
        """Return the variables at the start; shape (..., size)."""
        vectors = np.ldexp(np.asarray(self.vectors, dtype=float), FIRST_BITS)
        rows = np.zeros((*vectors.shape[:-2], self.size))
        rows[..., : self.count * len(self.tangent)] = vectors.reshape(*vectors.shape[:-2], -1)
        rows[..., self.size - len(self.inputs) :] = 2.0**FIRST_BITS
        return rows

    def equations(self, symbols: list[Any], linear: Linearization) -> list[Any]:
        """Return the time derivatives."""
        u, pairs, _, units = self._split(np.array(symbols, dtype=object))
        inputs = [()] * self.count + list(self.inputs)
        units = [NONE] * self.count + list(units)
        changes = [linear.changes(x, *given) for x, *given in zip(u, inputs, units, strict=True)]
        rates = [rate for change in changes for rate in linear.rates(change)]
        for (a, b), x in zip(self.pairs, pairs, strict=True):
            bent = linear.second_changes(x, changes[a], changes[b], (inputs[a], inputs[b]), (units[a], units[b]))
            rates += linear.second_rates(bent, changes[a], changes[b])
        return rates + [NONE] * (self.size - len(rates))

    def rescale(self, rows: Array) -> None:
        """Bring vectors that have grown back to a small size, in rows of variables; shape (..., size)."""
        u, _, n, units = self._split(rows)
        _, bits = np.frexp(np.max(np.abs(u), axis=-1))
        bits = np.where(bits > FIRST_BITS + GROWN, bits - FIRST_BITS, 0)
        if not np.any(bits):
            return
        of_pairs = [bits[..., a] + bits[..., b] for a, b in self.pairs]
        k, own = len(self.tangent), self.total * len(self.tangent)
        rows[..., :own] = np.ldexp(rows[..., :own], -np.repeat(bits, k, axis=-1))
        for i, both in enumerate(of_pairs):
            pair = slice(own + i * k, own + (i + 1) * k)
            rows[..., pair] = np.ldexp(rows[..., pair], -both[..., None])
        n += COUNTED * bits
        units[...] = np.ldexp(units, -bits[..., self.count :])

    def read(self, rows: Array) -> tuple[Array, Array, Array]:
        """Return vectors (..., vectors, k), those of pairs (..., pairs, k), and numbers n (..., vectors).

        The truth is vector 2^n; of a pair, vector 2^(n + n).
        """
        u, pairs, n, _ = self._split(rows)
        return np.ldexp(u, -FIRST_BITS), np.ldexp(pairs, -2 * FIRST_BITS), n / COUNTED
