"""Variational equations of a motion: tangent vectors and derivatives by parameters, integrated along with it.

A tangent vector has six coordinates, body axes: xi = (theta, gamma) changes (q, g) to (q exp(theta / 2), g + gamma).
Behind them are the changes of the variables of parts; below, g and gamma stand for these as well. With m the rotation
matrix, d m_i = m_i x theta for each of its rows, and g' = F(m, g), to first order

    theta' = d omega - omega x theta,    gamma' = dF.

The second derivatives in two tangent vectors a and b obey, with d_ab the second differential,

    theta_ab' = d_ab omega - omega x theta_ab + (theta_a x d_b omega + theta_b x d_a omega) / 2,    gamma_ab' = d_ab F,

where d_ab m_i = m_i x theta_ab + ((m_i x theta_a) x theta_b + (m_i x theta_b) x theta_a) / 2. omega and F have
differentials by parameters as well. The quaternion has d q = q (0, theta) / 2, and d_ab q is like d_ab m_i.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.algebra.program import Node, tangents
from poinsot.engine.tangent_vectors import Variations
from poinsot.functions import Vector, cross

__all__ = ["VariationalEquations"]


class VariationalEquations:
    """Rates of tangent coordinates to first and second order.

    Parameters
    ----------
    tangent : tuple of int
        Which of the coordinates theta, gamma there are.
    matrix, quaternion
        The attitude, nodes or numbers.
    momenta, rates : sequences
        g and the variables of parts, and their time derivatives.
    omega : sequence
        The angular velocity along the body axes.
    inputs : callable
        The number of an input of the run to its node.
    """

    def __init__(
        self,
        tangent: tuple[int, ...],
        matrix: Any,
        quaternion: Any,
        momenta: Sequence[Any],
        rates: Sequence[Any],
        omega: Sequence[Any],
        inputs: Any,
    ) -> None:
        self._tangent, self._rows, self._quaternion = tangent, [Vector(row) for row in matrix], Vector(quaternion)
        self._momenta, self._rates, self._omega, self._inputs = momenta, rates, omega, inputs

    def of(self, variations: Variations, symbols: Sequence[Any]) -> list[Any]:
        """Return the time derivatives of the variables of tangent vectors."""
        u, pairs, _, units = variations.split(np.array(symbols, dtype=object))
        own = [{}] * variations.count + [
            {self._inputs(number): unit for number in numbers}
            for numbers, unit in zip(variations.inputs, units, strict=True)
        ]
        vectors = [_TangentVector(self._full(x), given) for x, given in zip(u, own, strict=True)]
        out = [rate for vector in vectors for rate in self._first(vector)]
        for (a, b), x in zip(variations.pairs, pairs, strict=True):
            out += self._second(_TangentVector(self._full(x), {}), vectors[a], vectors[b])
        return out + [0.0] * (variations.size - len(out))

    def _full(self, xi: Sequence[Any]) -> list[Any]:
        full = [0.0] * (3 + len(self._momenta))
        for place, x in zip(self._tangent, xi, strict=True):
            full[place] = x
        return full

    def _first(self, vector: _TangentVector) -> list[Any]:
        vector.row_changes = [cross(row, vector.theta) for row in self._rows]
        vector.turn = self._turn(vector.theta)
        seeds = _seeds([*self._rows, self._quaternion], [*vector.row_changes, vector.turn])
        seeds |= _seeds([self._momenta], [vector.gamma]) | vector.inputs
        vector.seeds = seeds
        vector.changes = tangents([*self._omega, *self._rates], seeds)
        theta = Vector(vector.changes[:3]) - cross(self._omega, vector.theta)
        return self._chosen([*theta, *vector.changes[3:]])

    def _second(self, pair: _TangentVector, a: _TangentVector, b: _TangentVector) -> list[Any]:
        rows = [
            cross(row, pair.theta) + 0.5 * (cross(row_a, b.theta) + cross(row_b, a.theta))
            for row, row_a, row_b in zip(self._rows, a.row_changes, b.row_changes, strict=True)
        ]
        turn = self._turn(pair.theta) + 0.5 * (_half_product(a.turn, b.theta) + _half_product(b.turn, a.theta))
        seeds = b.seeds | _seeds([*a.row_changes, a.turn, a.gamma], [*rows, turn, pair.gamma])
        changes = tangents(a.changes, seeds)
        mixed = cross(a.theta, b.changes[:3]) + cross(b.theta, a.changes[:3])
        theta = Vector(changes[:3]) - cross(self._omega, pair.theta) + 0.5 * mixed
        return self._chosen([*theta, *changes[3:]])

    def _turn(self, theta: Vector) -> Vector:
        return _half_product(self._quaternion, theta)

    def _chosen(self, rates: Sequence[Any]) -> list[Any]:
        """Return the rates of the tangent coordinates that there are."""
        return [rates[place] for place in self._tangent]


class _TangentVector:
    """A tangent vector and what is known of the differentials along it."""

    row_changes: list[Vector]
    turn: Vector
    seeds: dict[Node, Any]
    changes: list[Any]

    def __init__(self, xi: Sequence[Any], inputs: Mapping[Node, Any]) -> None:
        self.theta, self.gamma, self.inputs = Vector(xi[:3]), Vector(xi[3:]), dict(inputs)


def _half_product(q: Vector, theta: Vector) -> Vector:
    return Vector(0.5 * x for x in quat.product(q, quat.pure(theta)))


def _seeds(scalars: Iterable[Iterable[Any]], changes: Iterable[Iterable[Any]]) -> dict[Node, Any]:
    """Return the changes of the scalars that are nodes."""
    pairs = (pair for one, other in zip(scalars, changes, strict=True) for pair in zip(one, other, strict=True))
    return {x: change for x, change in pairs if isinstance(x, Node)}
