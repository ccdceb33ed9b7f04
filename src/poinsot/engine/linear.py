"""The motion expanded about itself, in six tangent coordinates: equations for kernels, written once.

xi = (theta, gamma): the neighbour has the quaternion q exp(theta / 2) and the angular momentum g + gamma, body axes.
With m the rotation matrix, of which a row changes by m_i x theta, and g' = F(m, g), to first order

    theta' = d omega - omega x theta,    gamma' = dF.

To second order in two changes a and b at once, with d_ab the second differential,

    theta_ab' = d_ab omega - omega x theta_ab + (theta_a x d_b omega + theta_b x d_a omega) / 2,    gamma_ab' = d_ab F,

where m_i changes by m_i x theta_ab + ((m_i x theta_a) x theta_b + (m_i x theta_b) x theta_a) / 2. Parameters change
omega and F as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import heyoka as hy

from poinsot.engine.parameter_folding import Constants, Multiple
from poinsot.functions import Vector, cross
from poinsot.mechanics.attitude import Attitude, matrix_of
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.formulations import Formulation
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.system import System

__all__ = ["NONE", "Linearization"]

NONE = hy.expression(0.0)

Changes = Mapping[Any, Any]
"""What entries of the matrix (i, j), components of g (k) and parameters ("p", n) change by, and xi itself."""


class Linearization:
    """Equations of neighbours of a motion, expressions of the engine.

    Parameters
    ----------
    system : System
        On the constants of a kernel.
    formulation : Formulation
        One with tangent coordinates.
    own : sequence
        The variables of the motion, as multiples; the first are those of the formulation.
    sky : Sky
    scale : scalar
        Of the momenta.
    carried : bool
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
        q, g = formulation.split(formulation.active(own[: formulation.size]))
        self._matrix, attitude = self._with_free_matrix(q, comoving)
        kinetics = system.body.kinetics(scale)
        omega = kinetics.omega(g)
        rates = kinetics.gyration(g) + system.torque_at(Instant(system.body, attitude, environment, omega), scale)
        self._omega, self._rates = ([NONE + constants.expression(x) for x in vector] for vector in (omega, rates))
        self._slopes: dict[Any, Any] = {}
        self._symbols = {place: _entry(*place) for place in self._matrix}
        self._symbols |= {k: constants.expression(x) for k, x in enumerate(g) if isinstance(x, Multiple)}

    def _with_free_matrix(self, q: Vector, comoving: bool) -> tuple[dict[Any, Any], Attitude]:
        """Return the entries of the rotation matrix that change, and an attitude in which they are variables."""
        matrix = Attitude.from_quaternion(q).matrix
        known = {(i, j): matrix[i, j] for i in range(3) for j in range(3) if isinstance(matrix[i, j], Multiple)}
        rows = [
            [self._constants.variable(_entry(i, j)) if (i, j) in known else matrix[i, j] for j in range(3)]
            for i in range(3)
        ]
        entries = {place: self._constants.expression(value) for place, value in known.items()}
        self._constants.stand_ins = {_entry(*place): value for place, value in entries.items()}
        return entries, Attitude(matrix_of(rows), comoving)

    # ------------------------------------------------------------------ changes

    def changes(self, xi: Sequence[Any], inputs: tuple[int, ...] = (), unit: Any = NONE) -> dict[Any, Any]:
        """Return what tangent coordinates, and a change by a unit of some inputs of the kernel together, stand for."""
        theta, gamma = self._full(xi)
        slopes = self._constants.slopes(inputs) if inputs else {}
        return {
            **{(i, j): x for i in range(3) for j, x in enumerate(cross(self._row(i), theta))},
            **dict(enumerate(gamma)),
            **{("p", n): unit * self._constants.expression(slope) for n, slope in slopes.items()},
            "theta": theta,
        }

    def second_changes(
        self,
        xi: Sequence[Any],
        a: Changes,
        b: Changes,
        inputs: tuple[tuple[int, ...], tuple[int, ...]],
        units: tuple[Any, Any],
    ) -> dict[Any, Any]:
        """Return what second derivatives in two changes stand for, both of which may be of inputs, by a unit each."""
        out = self.changes(xi)
        for i in range(3):
            twice = [cross([x.get((i, j), NONE) for j in range(3)], y["theta"]) for x, y in ((a, b), (b, a))]
            out |= {(i, j): out[i, j] + 0.5 * (twice[0][j] + twice[1][j]) for j in range(3)}
        bent = self._constants.bends(*inputs) if all(inputs) else {}
        product = units[0] * units[1]
        return out | {("p", n): product * self._constants.expression(x) for n, x in bent.items()}

    def _full(self, xi: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        full = [NONE] * 6
        for place, x in zip(self.tangent, xi, strict=True):
            full[place] = x
        return full[:3], full[3:]

    def _row(self, i: int) -> list[Any]:
        return [_entry(i, j) if (i, j) in self._matrix else NONE for j in range(3)]

    # ------------------------------------------------------------------ rates

    def rates(self, changes: Changes) -> list[Any]:
        """Return the time derivatives of the tangent coordinates of a change."""
        of_omega, of_g = ([self._first(f, changes) for f in each] for each in (self._omega, self._rates))
        return self._chosen([*self._turning(of_omega, changes), *of_g])

    def second_rates(self, changes: Changes, a: Changes, b: Changes) -> list[Any]:
        """Return those of the second derivatives in two changes."""
        of_omega, of_g = (
            [self._first(f, changes) + self._second(f, a, b) for f in each] for each in (self._omega, self._rates)
        )
        mixed = [cross(x["theta"], [self._first(f, y) for f in self._omega]) for x, y in ((a, b), (b, a))]
        bent = [0.5 * (x + y) for x, y in zip(*mixed, strict=True)]
        return self._chosen([*map(sum, zip(self._turning(of_omega, changes), bent, strict=True)), *of_g])

    def _turning(self, of_omega: list[Any], changes: Changes) -> list[Any]:
        return [a - b for a, b in zip(of_omega, cross(self._omega, changes["theta"]), strict=True)]

    def _first(self, f: Any, changes: Changes) -> Any:
        return hy.sum([self._slope(f, name) * x for name, x in self._moving(changes)])

    def _second(self, f: Any, a: Changes, b: Changes) -> Any:
        terms = []
        for name, x in self._moving(a):
            slope = self._slope(f, name)
            terms += [self._slope(slope, other) * (x * y) for other, y in self._moving(b) if _varies(slope)]
        return hy.sum([term for term in terms if _varies(term)])

    def _moving(self, changes: Changes) -> list[tuple[Any, Any]]:
        return [(name, x) for name, x in changes.items() if name != "theta" and _varies(x)]

    def _slope(self, f: Any, name: Any) -> Any:
        """Return the derivative of an expression by an entry of the matrix, a component of g or a parameter."""
        if (f, name) not in self._slopes:
            symbol = hy.par[name[1]] if isinstance(name, tuple) and name[0] == "p" else self._symbols.get(name)
            self._slopes[f, name] = NONE if symbol is None else hy.diff(f, symbol)
        return self._slopes[f, name]

    def _chosen(self, rates: list[Any]) -> list[Any]:
        """Return the rates of the tangent coordinates that there are, on the variables of the motion."""
        return list(hy.subs([NONE + rates[i] for i in self.tangent], self._constants.stand_ins))


def _entry(i: int, j: int) -> Any:
    return hy.expression(f"m{i}{j}")


def _varies(expression: Any) -> bool:
    return bool(expression != NONE)
