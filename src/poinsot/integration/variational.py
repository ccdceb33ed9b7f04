"""Variational equations of a motion: tangent vectors and derivatives by parameters, integrated along with it.

A tangent vector has six coordinates, body axes: xi = (theta, gamma) changes (q, g) to (q exp(theta / 2), g + gamma). Of
two bodies each has six. Behind them are the changes of the variables of parts; below, g and gamma stand for these as
well. With m the rotation matrix, d m_i = m_i x theta for each of its rows, and g' = F(m, g), to first order

    theta' = d omega - omega x theta,    gamma' = dF.

The second derivatives in two tangent vectors a and b obey, with d_ab the second differential,

    theta_ab' = d_ab omega - omega x theta_ab + (theta_a x d_b omega + theta_b x d_a omega) / 2,    gamma_ab' = d_ab F,

where d_ab m_i = m_i x theta_ab + ((m_i x theta_a) x theta_b + (m_i x theta_b) x theta_a) / 2. omega and F have
differentials by parameters as well. The quaternion has d q = q (0, theta) / 2, and d_ab q is like d_ab m_i.

These equations are linear: a vector is integrated as u 2^n with a small u. Now and then a u that has grown is made
small again by a power of two, and n raised.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector, cross
from poinsot.quantities import Array
from poinsot.taylor.graph import GraphScalar, Node, tangents

__all__ = [
    "INPUT_UNIT",
    "STEPS_AT_A_TIME",
    "TangentSpace",
    "TangentVector",
    "TurningBody",
    "VariationalEquations",
    "Variations",
]

Element = TypeVar("Element")

Scalars = Sequence[GraphScalar]

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


class TurningBody(NamedTuple):
    """Attitude and momentum of a body, nodes or numbers, with their rates along the body axes, if these are known."""

    matrix: NDArray[np.object_]
    quaternion: Scalars
    momentum: Scalars
    omega: Scalars = ()
    momentum_rate: Scalars = ()


class TangentSpace:
    """Tangent vectors at a state: how their coordinates change the nodes of attitudes, momenta and other variables.

    Parameters
    ----------
    chosen : sequence of int
        Numbers of the coordinates in use: theta, gamma of each body, and the changes of other variables.
    bodies : sequence of TurningBody
    variables : sequence of scalars
        The variables of parts, or of the relative orbit.
    """

    def __init__(self, chosen: Sequence[int], bodies: Sequence[TurningBody], variables: Scalars) -> None:
        self._chosen, self._bodies = chosen, bodies
        self._rows = [[Vector(row) for row in body.matrix] for body in bodies]
        self._quaternions = [Vector(body.quaternion) for body in bodies]
        self._momenta = [x for body in bodies for x in body.momentum] + list(variables)

    def vector(self, xi: Scalars, inputs: Mapping[Node, GraphScalar]) -> TangentVector:
        """Return the tangent vector of the coordinates in use and of changes of inputs."""
        bodies = len(self._bodies)
        full = list[GraphScalar]([0.0] * (3 * bodies + len(self._momenta)))
        for place, x in zip(self._chosen, xi, strict=True):
            full[place] = x
        thetas = [Vector(full[6 * i : 6 * i + 3]) for i in range(bodies)]
        gamma = [x for i in range(bodies) for x in full[6 * i + 3 : 6 * i + 6]] + full[6 * bodies :]
        row_changes = [[cross(row, theta) for row in rows] for rows, theta in zip(self._rows, thetas, strict=True)]
        turns = self._turns(thetas)
        seeds = _seeds([*_flat(self._rows), *self._quaternions], [*_flat(row_changes), *turns])
        seeds |= _seeds([self._momenta], [gamma]) | dict(inputs)
        return TangentVector(thetas, gamma, row_changes, turns, seeds)

    def _turns(self, thetas: Sequence[Vector]) -> list[Vector]:
        return [_half_product(q, theta) for q, theta in zip(self._quaternions, thetas, strict=True)]


class VariationalEquations(TangentSpace):
    """Rates of tangent coordinates to first and second order.

    Parameters
    ----------
    chosen, bodies, variables
        Same as in `TangentSpace`.
    rates : sequence of scalars
        The time derivatives of the variables.
    inputs : callable
        Function from the number of an input of the run to its node.

    Attributes
    ----------
    velocity : list of scalars
        Velocity of the motion as a tangent vector, all coordinates.
    """

    def __init__(
        self,
        chosen: Sequence[int],
        bodies: Sequence[TurningBody],
        variables: Scalars,
        rates: Scalars,
        inputs: Callable[[int], Node],
    ) -> None:
        super().__init__(chosen, bodies, variables)
        self._inputs = inputs
        self.velocity = [x for body in bodies for x in (*body.omega, *body.momentum_rate)] + list(rates)

    def of(self, variations: Variations, symbols: Scalars) -> list[GraphScalar]:
        """Return the time derivatives of the variables of tangent vectors."""
        vectors, pairs = self._vectors(variations, symbols)
        changes = [tangents(self.velocity, vector.seeds) for vector in vectors]
        out = [rate for vector, each in zip(vectors, changes, strict=True) for rate in self._first(vector, each)]
        for (a, b), x in zip(variations.pairs, pairs, strict=True):
            out += self._second(x, (vectors[a], vectors[b]), (changes[a], changes[b]))
        return out + [0.0] * (variations.size - len(out))

    def differentials(self, variations: Variations, symbols: Scalars, outputs: Scalars) -> list[list[GraphScalar]]:
        """Return the differentials of outputs along each vector, then the second differentials in each pair."""
        vectors, pairs = self._vectors(variations, symbols)
        changes = [tangents(outputs, vector.seeds) for vector in vectors]
        return changes + [
            self.second(changes[a], self.vector(x, {}), vectors[a], vectors[b])
            for (a, b), x in zip(variations.pairs, pairs, strict=True)
        ]

    def _vectors(self, variations: Variations, symbols: Scalars) -> tuple[list[TangentVector], NDArray[np.object_]]:
        """Return the tangent vectors, and the coordinates of pairs."""
        rows: NDArray[np.object_] = np.array(symbols, dtype=object)
        u, pairs, _, units = variations.split(rows)
        none: dict[Node, GraphScalar] = {}
        own = [none] * variations.count + [
            {self._inputs(number): unit * (1 / INPUT_UNIT) for number in numbers}
            for numbers, unit in zip(variations.inputs, units, strict=True)
        ]
        return [self.vector(x, given) for x, given in zip(u, own, strict=True)], pairs

    def second(self, changes: Scalars, pair: TangentVector, a: TangentVector, b: TangentVector) -> list[GraphScalar]:
        """Return second differentials in two tangent vectors, from the differentials along the first vector.

        `pair` contains the second differentials of the coordinates.
        """
        rows, turns = [], list(pair.turns)
        for i, theta in enumerate(pair.thetas):
            rows += [
                cross(row, theta) + 0.5 * (cross(row_a, b.thetas[i]) + cross(row_b, a.thetas[i]))
                for row, row_a, row_b in zip(self._rows[i], a.row_changes[i], b.row_changes[i], strict=True)
            ]
            turns[i] += 0.5 * (_half_product(a.turns[i], b.thetas[i]) + _half_product(b.turns[i], a.thetas[i]))
        seeds = b.seeds | _seeds([*_flat(a.row_changes), *a.turns, a.gamma], [*rows, *turns, pair.gamma])
        return tangents(changes, seeds)

    def chosen(self, coordinates: Scalars) -> list[GraphScalar]:
        """Return the coordinates in use out of all tangent coordinates."""
        return [coordinates[place] for place in self._chosen]

    def _first(self, vector: TangentVector, changes: Scalars) -> list[GraphScalar]:
        rates = list(changes)
        for i, (body, theta) in enumerate(zip(self._bodies, vector.thetas, strict=True)):
            own = slice(6 * i, 6 * i + 3)
            rates[own] = Vector(changes[own]) - cross(body.omega, theta)
        return self.chosen(rates)

    def _second(
        self,
        xi: Scalars,
        vectors: tuple[TangentVector, TangentVector],
        changes: tuple[list[GraphScalar], list[GraphScalar]],
    ) -> list[GraphScalar]:
        pair, (a, b) = self.vector(xi, {}), vectors
        rates = self.second(changes[0], pair, a, b)
        for i, (body, theta) in enumerate(zip(self._bodies, pair.thetas, strict=True)):
            own = slice(6 * i, 6 * i + 3)
            mixed = cross(a.thetas[i], changes[1][own]) + cross(b.thetas[i], changes[0][own])
            rates[own] = Vector(rates[own]) - cross(body.omega, theta) + 0.5 * mixed
        return self.chosen(rates)


class TangentVector(NamedTuple):
    """Tangent vector: changes of attitudes, momenta and variables of parts, and `seeds`, the changes of all nodes."""

    thetas: list[Vector]
    gamma: list[GraphScalar]
    row_changes: list[list[Vector]]
    turns: list[Vector]
    seeds: dict[Node, GraphScalar]


def _flat(lists: Iterable[Iterable[Element]]) -> list[Element]:
    return [x for each in lists for x in each]


def _half_product(q: Vector, theta: Vector) -> Vector:
    return Vector(0.5 * x for x in quat.product(q, quat.pure(theta)))


def _seeds(scalars: Iterable[Scalars], changes: Iterable[Scalars]) -> dict[Node, GraphScalar]:
    """Return the changes of the scalars that are nodes."""
    pairs = (pair for one, other in zip(scalars, changes, strict=True) for pair in zip(one, other, strict=True))
    return {x: change for x, change in pairs if isinstance(x, Node)}
