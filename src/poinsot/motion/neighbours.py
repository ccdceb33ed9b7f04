"""Neighbours of a motion, to first order: tangent vectors and derivatives by parameters, integrated along with it.

A vector is u 2^n with a tiny u, whose size means nothing in linear equations: so the engine's step control looks at
the motion alone. Now and then a u that has grown is made tiny again, by a power of two, and n is raised.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.motion.linear import Linearization

__all__ = ["STEPS_AT_A_TIME", "Neighbours"]

Array = NDArray[np.float64]

START, GROWN = -500, -400
"""Binary exponents of a vector at the start, and of one that is brought back to that."""

STEPS_AT_A_TIME = 500
"""Steps between two looks at the size of the vectors: they may grow by 2^350 before they are seen."""

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
    vectors : array (..., count, k)
        The tangent vectors at the start, of size one, with members first.
    """

    tangent: tuple[int, ...]
    count: int
    inputs: tuple[tuple[int, ...], ...] = ()
    vectors: Any = field(default=None, compare=False)

    @property
    def size(self) -> int:
        """How many variables: u and n of each vector, and what a unit change of the parameter is, of derivatives."""
        return (self.count + len(self.inputs)) * self._each + len(self.inputs)

    @property
    def _each(self) -> int:
        return len(self.tangent) + 1

    def start(self) -> Array:
        """Return the variables at the start; shape (..., size)."""
        u = np.ldexp(np.asarray(self.vectors, dtype=float), START)
        u = np.concatenate([u, np.zeros((*u.shape[:-2], len(self.inputs), u.shape[-1]))], axis=-2)
        rows = np.concatenate([u, np.zeros((*u.shape[:-1], 1))], axis=-1).reshape(*u.shape[:-2], -1)
        return np.concatenate([rows, np.full((*u.shape[:-2], len(self.inputs)), 2.0**START)], axis=-1)

    def equations(self, symbols: list[Any], linear: Linearization) -> list[Any]:
        """Return the time derivatives."""
        units, rates = symbols[len(symbols) - len(self.inputs) :], []
        for i, u in enumerate(self._split(symbols)):
            change = linear.rates(u)
            if i >= self.count:
                forcing, unit = linear.forcing(self.inputs[i - self.count]), units[i - self.count]
                change = [c + unit * f for c, f in zip(change, forcing, strict=True)]
            rates += [*change, 0.0]
        return [*rates, *[0.0] * len(units)]

    def _split(self, symbols: list[Any]) -> list[list[Any]]:
        return [symbols[i : i + self._each - 1] for i in range(0, self.size - len(self.inputs), self._each)]

    def rescale(self, rows: Array) -> None:
        """Bring vectors that have grown back to a small size, in rows of variables; shape (..., size)."""
        for i in range(self.count + len(self.inputs)):
            own = slice(i * self._each, (i + 1) * self._each - 1)
            _, bits = np.frexp(np.max(np.abs(rows[..., own]), axis=-1))
            bits = np.where(bits > GROWN, bits - START, 0)
            rows[..., own] = np.ldexp(rows[..., own], -bits[..., None])
            rows[..., own.stop] += COUNTED * bits
            if i >= self.count:
                unit = i - self.count - len(self.inputs)
                rows[..., unit] = np.ldexp(rows[..., unit], -bits)

    def read(self, rows: Array) -> tuple[Array, Array]:
        """Return the vectors (..., vectors, k) and the numbers n (..., vectors): the truth is vector 2^n."""
        each = rows[..., : self.size - len(self.inputs)].reshape(*rows.shape[:-1], -1, self._each)
        return np.ldexp(each[..., :-1], -START), each[..., -1] / COUNTED
