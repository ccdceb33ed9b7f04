"""Variational equations of a motion: tangent vectors and derivatives by parameters, integrated along with it.

A tangent vector has six coordinates, body axes: xi = (theta, gamma) changes (q, g) to (q exp(theta / 2), g + gamma).
Behind them are the changes of the variables of parts; below, g and gamma stand for these as well. With m the rotation
matrix, d m_i = m_i x theta for each of its rows, and g' = F(m, g), to first order

    theta' = d omega - omega x theta,    gamma' = dF.

The second derivatives in two tangent vectors a and b obey, with d_ab the second differential,

    theta_ab' = d_ab omega - omega x theta_ab + (theta_a x d_b omega + theta_b x d_a omega) / 2,    gamma_ab' = d_ab F,

where d_ab m_i = m_i x theta_ab + ((m_i x theta_a) x theta_b + (m_i x theta_b) x theta_a) / 2. omega and F have
differentials by parameters as well.

The equations are linear: a tangent vector is integrated as u 2^n with a small u. Now and then a u that has grown is
made small again by a power of two, and n raised.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot.engine.formulations import Formulation
from poinsot.engine.parameter_folding import Constants, Multiple
from poinsot.functions import cross
from poinsot.mechanics.attitude import Attitude, matrix_of
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.system import System

__all__ = ["STEPS_AT_A_TIME", "ZERO", "VariationalEquations", "Variations"]

Array = NDArray[np.float64]

ZERO = hy.expression(0.0)

Differentials = Mapping[Any, Any]
"""Of entries of the matrix (i, j), g and variables of parts (k), omega ("w", i), parameters ("p", n); theta itself."""

INITIAL_EXPONENT = -10
"""Binary exponent of a vector at the start: large enough for the step control where the motion itself is at rest."""

GROWN = 8
"""Bits above that, from which on a vector is rescaled."""

STEPS_AT_A_TIME = {1: 700, 2: 300}
"""Steps between two checks of the size of the vectors, by order; up to the first one, a tenth.

A vector that doubles in every step does not overflow in so many; one that grows like the time does not outgrow the
attitude, which would loosen the step control. One that grows exponentially may: it has steps as short as the motion.
"""

COUNTED = 2.0**-20
"""What the variable n counts in, to stay below the attitude for the engine's step control."""


class VariationalEquations:
    """Rates of tangent coordinates to first and second order, expressions of the engine.

    Parameters
    ----------
    system : System
        On the constants of a kernel.
    formulation : Formulation
        One with tangent coordinates.
    own : sequence
        Those of the formulation, as multiples.
    environment : Environment
    scale : scalar
        Of the momenta.
    comoving : bool
        Whether attitudes refer to turning axes.
    constants : Constants
    """

    def __init__(
        self,
        system: System,
        formulation: Formulation,
        own: Sequence[Any],
        environment: Environment,
        scale: Any,
        comoving: bool,
        constants: Constants,
    ) -> None:
        self.tangent, self._constants = formulation.tangent, constants
        attitude, g = formulation.physical(own)
        self._matrix, attitude = self._with_matrix_of_symbols(attitude.matrix, comoving)
        body = system.body_at(formulation.own(own, scale), environment.time)
        instant = Instant(body, attitude, environment, angular_momentum_body=g, scale=scale)
        omega, spins = instant.omega_body, dict[Any, Any]()
        if system.moving_parts:  # their rates are far shorter on omega as three variables
            spins = {("w", i): hy.expression(f"w{i}") for i in range(3)}
            constants.stand_ins |= {spins["w", i]: ZERO + constants.expression(x) for i, x in enumerate(omega)}
            instant = Instant(body, attitude, environment, [*map(constants.variable, spins.values())], g, scale)
        rates = [*system.momentum_rate(instant, system.torque_at(instant))]
        of_parts = formulation.own_rates(system.own_rates(instant), scale)
        rates += [of_parts[place - len(own)] for place in formulation.own_places]
        self._omega, self._rates = ([ZERO + constants.expression(x) for x in each] for each in (omega, rates))
        self._derivatives: dict[Any, Any] = {}
        self._symbols = {place: _entry(*place) for place in self._matrix} | spins
        changing = enumerate([*g, *(own[place] for place in formulation.own_places)])
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
    """

    scaled: tuple[bool, ...]
    count: int
    inputs: tuple[tuple[int, ...], ...] = ()
    order: int = 1
    initial: Any = field(default=None, compare=False)

    @property
    def size(self) -> int:
        """How many variables: u of each vector and of each pair, n of each vector, and the unit of each input."""
        return (self.total + len(self.pairs)) * len(self.scaled) + self.total + len(self.inputs)

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
        """Which of the variables scale as momenta do."""
        return [place for place, scales in enumerate(self.scaled * (self.total + len(self.pairs))) if scales]

    def _split(self, rows: Any) -> tuple[Any, Any, Any, Any]:
        """Return views of u (..., vectors, k), of pairs (..., pairs, k), of n and of units in rows of variables."""
        k, first, second = len(self.scaled), self.total * len(self.scaled), len(self.pairs) * len(self.scaled)
        u, pairs, n, units = np.split(rows, [first, first + second, first + second + self.total], axis=-1)
        return u.reshape(*u.shape[:-1], -1, k), pairs.reshape(*pairs.shape[:-1], len(self.pairs), k), n, units

    def start(self) -> Array:
        """Return the variables at the start; shape (..., size)."""
        vectors = np.ldexp(np.asarray(self.initial, dtype=float), INITIAL_EXPONENT)
        rows = np.zeros((*vectors.shape[:-2], self.size))
        rows[..., : self.count * len(self.scaled)] = vectors.reshape(*vectors.shape[:-2], -1)
        rows[..., self.size - len(self.inputs) :] = 2.0**INITIAL_EXPONENT
        return rows

    def rates(self, symbols: list[Any], equations: VariationalEquations) -> list[Any]:
        """Return the time derivatives of the variables."""
        u, pairs, _, units = self._split(np.array(symbols, dtype=object))
        inputs = [()] * self.count + list(self.inputs)
        units = [ZERO] * self.count + list(units)
        d = [equations.differentials(x, *given) for x, *given in zip(u, inputs, units, strict=True)]
        rates = [rate for each in d for rate in equations.rates(each)]
        for (a, b), x in zip(self.pairs, pairs, strict=True):
            second = equations.second_differentials(x, d[a], d[b], (inputs[a], inputs[b]), (units[a], units[b]))
            rates += equations.second_rates(second, d[a], d[b])
        return rates + [ZERO] * (self.size - len(rates))

    def rescale(self, rows: Array) -> None:
        """Rescale vectors that have grown, in rows of variables; shape (..., size)."""
        u, _, n, units = self._split(rows)
        _, bits = np.frexp(np.max(np.abs(u), axis=-1))
        bits = np.where(bits > INITIAL_EXPONENT + GROWN, bits - INITIAL_EXPONENT, 0)
        if not np.any(bits):
            return
        of_pairs = [bits[..., a] + bits[..., b] for a, b in self.pairs]
        k, own = len(self.scaled), self.total * len(self.scaled)
        rows[..., :own] = np.ldexp(rows[..., :own], -np.repeat(bits, k, axis=-1))
        for i, both in enumerate(of_pairs):
            pair = slice(own + i * k, own + (i + 1) * k)
            rows[..., pair] = np.ldexp(rows[..., pair], -both[..., None])
        n += COUNTED * bits
        units[...] = np.ldexp(units, -bits[..., self.count :])

    def read(self, rows: Array) -> tuple[Array, Array, Array]:
        """Return u of vectors (..., vectors, k) and of pairs (..., pairs, k), and exponents n (..., vectors).

        A vector is u 2^n, the second derivative of a pair u 2^(n + n).
        """
        u, pairs, n, _ = self._split(rows)
        return np.ldexp(u, -INITIAL_EXPONENT), np.ldexp(pairs, -2 * INITIAL_EXPONENT), n / COUNTED
