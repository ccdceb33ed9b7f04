"""The motion linearised about itself, in six tangent coordinates: equations for kernels, written once.

xi = (theta, gamma): the neighbour has the quaternion q exp(theta / 2) and the angular momentum g + gamma, body axes.
With m the rotation matrix, whose rows m_i change by m_i x theta, and g' = F(m, g),

    theta' = d omega - omega x theta,    gamma' = dF/dm (m x theta) + dF/dg gamma.

A change dp of a parameter adds d omega/dp dp and dF/dp dp.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import Any

import heyoka as hy

from poinsot.functions import Vector, cross
from poinsot.mechanics.attitude import Attitude, matrix_of
from poinsot.mechanics.formulations import Formulation
from poinsot.mechanics.sky import Sky
from poinsot.mechanics.system import System
from poinsot.motion.constants import Constants, Multiple

__all__ = ["NONE", "Linearization"]

NONE = hy.expression(0.0)


class Linearization:
    """Linear equations of neighbours of a motion, expressions of the engine.

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
        sky: Sky,
        scale: Any,
        carried: bool,
        constants: Constants,
    ) -> None:
        self.tangent, self._constants = formulation.tangent, constants
        q, g = formulation.split(formulation.active(own[: formulation.size]))
        self._g = {k: constants.expression(x) for k, x in enumerate(g) if isinstance(x, Multiple)}
        self._matrix, attitude = self._with_free_matrix(q, carried)
        kinetics = system.body.kinetics(scale)
        omega = kinetics.omega(g)
        rates = kinetics.gyration(g) + system.torque_at(attitude, Vector(omega), sky, scale)
        self._omega, self._rates = ([NONE + constants.expression(x) for x in vector] for vector in (omega, rates))

    def _with_free_matrix(self, q: Vector, carried: bool) -> tuple[dict[tuple[int, int], Any], Attitude]:
        """Return the entries of the rotation matrix that change, and an attitude in which they are variables."""
        matrix = Attitude.from_unit_quaternion(q).matrix
        known = {(i, j): matrix[i, j] for i in range(3) for j in range(3) if isinstance(matrix[i, j], Multiple)}
        rows = [
            [self._constants.variable(_entry(i, j)) if (i, j) in known else matrix[i, j] for j in range(3)]
            for i in range(3)
        ]
        entries = {place: self._constants.expression(value) for place, value in known.items()}
        return entries, Attitude(matrix_of(rows), carried)

    @functools.cached_property
    def _slopes(self) -> tuple[list[dict[Any, Any]], list[dict[Any, Any]]]:
        """The derivatives of omega and g' by entries of the matrix and components of g, those that are not zero."""
        by: dict[Any, Any] = {place: _entry(*place) for place in self._matrix} | self._g
        return tuple(  # type: ignore[return-value]
            [{name: s for name, x in by.items() if _varies(s := hy.diff(f, x))} for f in functions]
            for functions in (self._omega, self._rates)
        )

    def rates(self, xi: Sequence[Any]) -> list[Any]:
        """Return the time derivatives of tangent coordinates, those that the formulation has."""
        full = [NONE] * 6
        for place, x in zip(self.tangent, xi, strict=True):
            full[place] = x
        theta, gamma = full[:3], full[3:]
        changes = {(i, j): change for i in range(3) for j, change in enumerate(self._turned_row(i, theta))}
        changes |= dict(enumerate(gamma))  # type: ignore[arg-type]
        of_omega, of_g = ([_combined(slopes, changes) for slopes in each] for each in self._slopes)
        turning = [a - b for a, b in zip(of_omega, cross(self._omega, theta), strict=True)]
        return self._chosen([*turning, *of_g])

    def forcing(self, inputs: Iterable[int]) -> list[Any]:
        """Return what a unit change of some inputs of the kernel, together, adds to the rates."""
        slopes = self._constants.slopes(inputs)
        return self._chosen(
            [
                hy.sum([hy.diff(f, hy.par[k]) * self._constants.expression(slope) for k, slope in slopes.items()])
                for f in (*self._omega, *self._rates)
            ]
        )

    def _turned_row(self, i: int, theta: list[Any]) -> Vector:
        row = [_entry(i, j) if (i, j) in self._matrix else NONE for j in range(3)]
        return cross(row, theta)

    def _chosen(self, rates: list[Any]) -> list[Any]:
        """Return the rates of the tangent coordinates that there are, on the variables of the motion."""
        entries = {_entry(*place): value for place, value in self._matrix.items()}
        return list(hy.subs([NONE + rates[i] for i in self.tangent], entries))


def _entry(i: int, j: int) -> Any:
    return hy.expression(f"m{i}{j}")


def _varies(expression: Any) -> bool:
    return bool(expression != NONE)


def _combined(slopes: dict[Any, Any], changes: dict[Any, Any]) -> Any:
    return hy.sum([slope * changes[name] for name, slope in slopes.items() if _varies(changes[name])])
