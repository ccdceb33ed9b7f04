"""Rows of a run: integrated variables along the times, and the arrays that receive them."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from poinsot.immutable import cached_property
from poinsot.integration.state_vector import StateVector
from poinsot.mechanics.state import Phase

__all__ = ["Memory", "OneMotion", "Rows", "Sink"]

VARIATIONS = ("vectors", "pairs", "exponents")
"""Names of the rows of tangent vectors, of second derivatives and of binary exponents."""

Array = NDArray[np.float64]
Members = NDArray[np.int_]


class Rows:
    """Integrated variables along times by name, converted on access.

    The names are the names of a phase (`quaternion`, the integrated momenta, the variables of parts), `orbits` for the
    variables of all orbits, and `vectors`, `pairs` and `exponents` of variations. Shapes: (members, n, ...), or
    (n, ...) for one body.
    """

    def __init__(self, variables: StateVector, times: Array, values: Array) -> None:
        self._variables, self._times, self._values = variables, times, values

    @cached_property
    def phase(self) -> Phase:
        """Quaternion, momenta and variables of parts."""
        return self._variables.to_phase(self._times, self._values)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Numbers of the two vectors that each of the `pairs` belongs to."""
        return self._variables.variations.pairs if self._variables.variations else []

    @cached_property
    def _variations(self) -> dict[str, Array]:
        variations, values = self._variables.variations, self._values[..., self._variables.tangent_vectors]
        return dict(zip(VARIATIONS, variations.read(values), strict=True)) if variations else {}

    def __getitem__(self, name: str) -> Array:
        if name == "orbits":
            return self._values[..., self._variables.along_orbits]
        return self._variations[name] if name in VARIATIONS else self.phase[name]


class Sink(Protocol):
    """Receiver of rows."""

    def take(self, members: Members, times: Array, rows: Rows) -> None:
        """Store the rows of some members, shapes (members, n, ...), NaN at times that they did not reach.

        Several threads call it, each for other members. Rows of one body have shape (n, ...), at the times reached.
        """


class Memory:
    """Arrays of the integrated variables of an ensemble, NaN at times that a member did not reach.

    Parameters
    ----------
    variables : StateVector
    members : int
    times : array (n,)
    **others : tuple of int
        Further rows: name -> shape.
    """

    def __init__(self, variables: StateVector, members: int, times: Array, **others: tuple[int, ...]) -> None:
        self.times, shape = times, (members, times.size)
        self.phase = {name: np.full((*shape, size), np.nan) for name, size in variables.sizes.items()}
        self.rows = self.phase | {name: np.full((*shape, *own), np.nan) for name, own in others.items()}

    def take(self, members: Members, times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Store the rows of some members."""
        for name, array in self.rows.items():
            array[members] = rows[name]


class OneMotion:
    """Rows of one body at the times that it reached, converted on access."""

    times: Array
    rows: Rows

    @property
    def phase(self) -> Phase:
        """Integrated variables."""
        return self.rows.phase

    def take(self, members: Members, times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Store the rows."""
        self.times, self.rows = times, rows
