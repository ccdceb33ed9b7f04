"""Variational equations of a motion: tangent vectors and derivatives by parameters, integrated along with it.

A tangent vector has six coordinates, body axes: xi = (theta, gamma) changes (q, g) to (q exp(theta / 2), g + gamma).
Behind them are the changes of the variables of parts; below, g and gamma stand for these as well. With m the rotation
matrix, d m_i = m_i x theta for each of its rows, and g' = F(m, g), to first order

    theta' = d omega - omega x theta,    gamma' = dF.

The second derivatives in two tangent vectors a and b obey, with d_ab the second differential,

    theta_ab' = d_ab omega - omega x theta_ab + (theta_a x d_b omega + theta_b x d_a omega) / 2,    gamma_ab' = d_ab F,

where d_ab m_i = m_i x theta_ab + ((m_i x theta_a) x theta_b + (m_i x theta_b) x theta_a) / 2. omega and F have
differentials by parameters as well.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import heyoka as hy
import numpy as np

from poinsot.engine.parameter_folding import Constants, Multiple
from poinsot.engine.state_vector import StateVector
from poinsot.engine.tangent_vectors import Variations
from poinsot.functions import cross
from poinsot.mechanics.attitude import Attitude, matrix_of
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.system import System

__all__ = ["ZERO", "VariationalEquations"]

ZERO = hy.expression(0.0)

Differentials = Mapping[Any, Any]
"""Of entries of the matrix (i, j), g and variables of parts (k), omega ("w", i), parameters ("p", n); theta itself."""


class VariationalEquations:
    """Rates of tangent coordinates to first and second order, expressions of the engine.

    Parameters
    ----------
    system : System
        On the constants of a kernel.
    variables : StateVector
        In a chart with tangent coordinates.
    own : sequence
        The variables of the motion, as multiples.
    environment : Environment
    scale : scalar
        Of the momenta.
    constants : Constants
    """

    def __init__(
        self,
        system: System,
        variables: StateVector,
        own: Sequence[Any],
        environment: Environment,
        scale: Any,
        constants: Constants,
    ) -> None:
        chart = variables.formulation
        of_parts = own[chart.size : variables.along_orbits.start]
        self.tangent, self._constants = (*chart.tangent, *range(6, 6 + len(of_parts))), constants
        attitude, g = chart.physical(own[: chart.size])
        self._matrix, attitude = self._with_matrix_of_symbols(attitude.matrix, variables.comoving)
        body = system.body_at(variables.physical(own, scale), environment.time)
        instant = Instant(body, attitude, environment, angular_momentum_body=g, scale=scale)
        omega, spins = instant.omega_body, dict[Any, Any]()
        if system.parts:  # their rates are far shorter on omega as three variables
            spins = {("w", i): hy.expression(f"w{i}") for i in range(3)}
            constants.stand_ins |= {spins["w", i]: ZERO + constants.expression(x) for i, x in enumerate(omega)}
            instant = Instant(body, attitude, environment, [*map(constants.variable, spins.values())], g, scale)
        rates = [*system.momentum_rate(instant, system.torque_at(instant))]
        rates += itertools.islice(variables.rates(system.block_rates(instant), scale), len(of_parts))
        self._omega, self._rates = ([ZERO + constants.expression(x) for x in each] for each in (omega, rates))
        self._derivatives: dict[Any, Any] = {}
        self._symbols = {place: _entry(*place) for place in self._matrix} | spins
        changing = enumerate([*g, *of_parts])
        self._symbols |= {k: constants.expression(x) for k, x in changing if isinstance(x, Multiple)}

    def _with_matrix_of_symbols(self, matrix: Any, comoving: bool) -> tuple[dict[Any, Any], Attitude]:
        """Return the entries of the rotation matrix that change, and an attitude in which they are variables."""
        known = {(i, j): matrix[i, j] for i in range(3) for j in range(3) if isinstance(matrix[i, j], Multiple)}
        rows = [
            [self._constants.variable(_entry(i, j)) if (i, j) in known else matrix[i, j] for j in range(3)]
            for i in range(3)
        ]
        entries = {place: self._constants.expression(value) for place, value in known.items()}
        self._constants.stand_ins = {_entry(*place): value for place, value in entries.items()}
        return entries, Attitude(matrix_of(rows), comoving)

    def of(self, variations: Variations, symbols: Sequence[Any]) -> list[Any]:
        """Return the time derivatives of the variables of tangent vectors."""
        u, pairs, _, units = variations.split(np.array(symbols, dtype=object))
        inputs = [()] * variations.count + list(variations.inputs)
        units = [ZERO] * variations.count + list(units)
        d = [self.differentials(x, *given) for x, *given in zip(u, inputs, units, strict=True)]
        rates = [rate for each in d for rate in self.rates(each)]
        for (a, b), x in zip(variations.pairs, pairs, strict=True):
            second = self.second_differentials(x, d[a], d[b], (inputs[a], inputs[b]), (units[a], units[b]))
            rates += self.second_rates(second, d[a], d[b])
        return rates + [ZERO] * (variations.size - len(rates))

    # ------------------------------------------------------------------ differentials

    def differentials(self, xi: Sequence[Any], inputs: tuple[int, ...] = (), unit: Any = ZERO) -> dict[Any, Any]:
        """Return the differentials for tangent coordinates, and for a unit of some inputs of the kernel together."""
        theta, gamma = self._full(xi)
        by_inputs = self._constants.derivatives(inputs) if inputs else {}
        out: dict[Any, Any] = {
            **{(i, j): x for i in range(3) for j, x in enumerate(cross(self._row(i), theta))},
            **dict(enumerate(gamma)),
            **{("p", n): unit * self._constants.expression(x) for n, x in by_inputs.items()},
            "theta": theta,
        }
        return out | {("w", i): self._differential(f, out) for i, f in enumerate(self._omega)}

    def second_differentials(
        self,
        xi: Sequence[Any],
        a: Differentials,
        b: Differentials,
        inputs: tuple[tuple[int, ...], tuple[int, ...]],
        units: tuple[Any, Any],
    ) -> dict[Any, Any]:
        """Return the second differentials for second derivatives in two vectors, which may be of inputs as well."""
        out = self.differentials(xi)
        for i in range(3):
            twice = [cross([x.get((i, j), ZERO) for j in range(3)], y["theta"]) for x, y in ((a, b), (b, a))]
            out |= {(i, j): out[i, j] + 0.5 * (twice[0][j] + twice[1][j]) for j in range(3)}
        by_inputs = self._constants.second_derivatives(*inputs) if all(inputs) else {}
        product = units[0] * units[1]
        out |= {("p", n): product * self._constants.expression(x) for n, x in by_inputs.items()}
        return out | {
            ("w", i): self._differential(f, out) + self._second_differential(f, a, b) for i, f in enumerate(self._omega)
        }

    def _full(self, xi: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        full = [ZERO] * (3 + len(self._rates))
        for place, x in zip(self.tangent, xi, strict=True):
            full[place] = x
        return full[:3], full[3:]

    def _row(self, i: int) -> list[Any]:
        return [_entry(i, j) if (i, j) in self._matrix else ZERO for j in range(3)]

    # ------------------------------------------------------------------ rates

    def rates(self, d: Differentials) -> list[Any]:
        """Return the time derivatives of tangent coordinates."""
        return self._chosen([*self._theta_rates(d), *(self._differential(f, d) for f in self._rates)])

    def second_rates(self, d: Differentials, a: Differentials, b: Differentials) -> list[Any]:
        """Return those of second derivatives in two vectors."""
        mixed = [cross(x["theta"], _omega_of(y)) for x, y in ((a, b), (b, a))]
        half = [0.5 * (x + y) for x, y in zip(*mixed, strict=True)]
        rates = [self._differential(f, d) + self._second_differential(f, a, b) for f in self._rates]
        return self._chosen([*map(sum, zip(self._theta_rates(d), half, strict=True)), *rates])

    def _theta_rates(self, d: Differentials) -> list[Any]:
        return [a - b for a, b in zip(_omega_of(d), cross(self._omega, d["theta"]), strict=True)]

    def _differential(self, f: Any, d: Differentials) -> Any:
        return hy.sum([self._derivative(f, name) * x for name, x in self._nonzero(d)])

    def _second_differential(self, f: Any, a: Differentials, b: Differentials) -> Any:
        terms = []
        for name, x in self._nonzero(a):
            first = self._derivative(f, name)
            terms += [self._derivative(first, other) * (x * y) for other, y in self._nonzero(b) if _is_nonzero(first)]
        return hy.sum([term for term in terms if _is_nonzero(term)])

    def _nonzero(self, d: Differentials) -> list[tuple[Any, Any]]:
        return [(name, x) for name, x in d.items() if name != "theta" and _is_nonzero(x)]

    def _derivative(self, f: Any, name: Any) -> Any:
        """Return the derivative of an expression by an entry of the matrix, a component of g or a parameter."""
        if (f, name) not in self._derivatives:
            symbol = hy.par[name[1]] if isinstance(name, tuple) and name[0] == "p" else self._symbols.get(name)
            self._derivatives[f, name] = ZERO if symbol is None else hy.diff(f, symbol)
        return self._derivatives[f, name]

    def _chosen(self, rates: list[Any]) -> list[Any]:
        """Return the rates of the tangent coordinates that there are, on the variables of the motion."""
        return list(hy.subs([ZERO + rates[i] for i in self.tangent], self._constants.stand_ins))


def _entry(i: int, j: int) -> Any:
    return hy.expression(f"m{i}{j}")


def _omega_of(d: Differentials) -> list[Any]:
    return [d["w", i] for i in range(3)]


def _is_nonzero(expression: Any) -> bool:
    return bool(expression != ZERO)
