"""Saltation: jumps of tangent vectors at switches of formulas, to first and second order.

Where a motion crosses h = 0 its velocity changes from f to g. A neighbour at the distance xi crosses later by the time

    s = -D_xi h / h',    h' = D_f h + dh/dt,

for which it keeps the velocity f. Compared at equal times, xi becomes xi + s (f - g), and the second differential

    xi_ab + s_ab (f - g) + s_a D_b (f - g) + s_b D_a (f - g) + s_a s_b (f'_f - 2 g'_f + g'_g),

s_ab = -(D_ab h + s_a D_b h' + s_b D_a h' + s_a s_b h'') / h', where u'_v is the derivative of u along v and the time.
All are in rotation vectors theta from the attitude at the crossing, whose rate is omega + theta x omega / 2 + ...

Where f = g nothing jumps to first order: formulas that are seen to be continuous, as `maximum`, `clip` and `abs` are,
need no stop. Nor do conditions on time, but for derivatives by numbers that they depend on.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Container, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.functions import Vector, cross
from poinsot.integration.variational import INPUT_UNIT, TangentVector, VariationalEquations, Variations
from poinsot.taylor.graph import Evaluator, Graph, GraphScalar, Node, ordered, replaced, tangents

__all__ = ["NoDerivative", "Saltation", "TangentJump"]

Array = NDArray[np.floating]
Scalars = Sequence[GraphScalar]
Values = Callable[..., Array]

AT_ONCE, AT_ZERO = 2.0**10, 2.0**24
"""Limits in units of the simultaneity tolerance: largest distance of zeros that count as one, and largest distance of
the zero of a function from the switch of its condition, beyond which the function jumps."""

MIN_GRAZING_RATIO = 2.0**20
"""Smallest ratio of the time in which the slope of a function falls to zero to the uncertainty of the zero. Below it
the slope has fewer than six digits."""

SAME_TIME_TOLERANCE = 1e-9
"""Relative tolerance of the crossing times of conditions with the same surface."""


class NoDerivative(Exception):  # noqa: N818
    """Error for a motion without a derivative by its start at a crossing. The message states the reason."""


class Saltation:
    """Formulas of the jumps of tangent vectors in a traced vector field.

    Parameters
    ----------
    graph : Graph
    own : sequence of Node
        The variables of the motion, and the time.
    rates : sequence of scalars
        Their time derivatives; that of the time is 1.
    conditions : mapping
        The conditions on which formulas branch, to what is negative where they hold.
    linear : VariationalEquations
    variations : Variations

    Attributes
    ----------
    stops : list of int
        The conditions, by number, at which tangent vectors may jump.
    """

    def __init__(
        self,
        graph: Graph,
        own: Sequence[Node],
        rates: Scalars,
        conditions: Mapping[Node, GraphScalar],
        linear: VariationalEquations,
        variations: Variations,
    ) -> None:
        self.variations, self._own, self._rates, self._linear = variations, own, rates, linear
        self._functions, k = list(conditions.values()), len(variations.scaled)
        inputs = sorted({number for together in variations.inputs for number in together})
        self.inputs = np.array([[number in together for together in variations.inputs] for number in inputs])
        sizes = {"a": k + len(inputs), "b": k + len(inputs), "pair": k, "velocity": k, "rates": len(own)}
        symbols = {name: [graph.symbol((name, i)) for i in range(size)] for name, size in sizes.items()}
        self._given = {"own": list(own), "holds": list(conditions), **symbols}
        nodes = list(map(graph.input, inputs))
        self._vectors = {
            name: linear.vector(symbols[name][:k], dict(zip(nodes, symbols[name][k:], strict=False)))
            for name in ("a", "b", "pair", "velocity")
        }
        self._known: dict[tuple[str, int], Values] = {}
        kinks = set(conditions) if variations.order == 2 else _jumping(graph, rates, conditions)
        moved = tangents(self._functions, self._vectors["a"].seeds)
        self.stops = [i for i, node in enumerate(conditions) if node in kinks and isinstance(moved[i], Node)]

    # ------------------------------------------------------------------ formulas

    @functools.cached_property
    def velocity(self) -> Values:
        """Velocity in tangent coordinates, then the rates of the variables and of the time."""
        return self._values([*self._linear.chosen(self._linear.velocity), *self._rates])

    @functools.cached_property
    def change(self) -> Values:
        """Change of the velocity along a tangent vector."""
        a = self._vectors["a"]
        return self._values(self._in_chart(tangents(self._linear.velocity, a.seeds), a))

    @functools.cached_property
    def acceleration(self) -> Values:
        """Change of the velocity along other rates of the motion, and the velocity of these rates."""
        rates = dict(zip(self._own, self._given["rates"], strict=True))
        return self._values(self._in_chart(tangents(self._linear.velocity, rates), self._vectors["velocity"]))

    def crossing(self, number: int) -> Values:
        """Return the function of a condition, two derivatives along the motion, and one along a tangent vector."""
        return self._of_function("crossing", number)

    def bent(self, number: int) -> Values:
        """Return the second differential of a condition in two tangent vectors, and of its slope in one."""
        return self._of_function("bent", number)

    def _of_function(self, name: str, number: int) -> Values:
        if (name, number) not in self._known:
            h, a = self._functions[number], self._vectors["a"]
            slope, change = self._along(h), tangents([h], a.seeds)
            if name == "crossing":
                outputs = [h, slope, self._along(slope), *change]
            else:
                outputs = self._linear.second(change, self._vectors["pair"], a, self._vectors["b"])
                outputs += tangents([slope], a.seeds)
            self._known[name, number] = self._values(outputs)
        return self._known[name, number]

    def _along(self, function: GraphScalar) -> GraphScalar:
        slope: GraphScalar = tangents([function], dict(zip(self._own, self._rates, strict=True)))[0]
        return slope

    def _in_chart(self, changes: list[GraphScalar], vector: TangentVector) -> list[GraphScalar]:
        """Return changes of the velocity in a chart of rotation vectors."""
        for i, theta in enumerate(vector.thetas):
            own = slice(6 * i, 6 * i + 3)
            changes[own] = Vector(changes[own]) + 0.5 * cross(theta, Vector(self._linear.velocity[own]))
        return self._linear.chosen(changes)

    def _values(self, outputs: Scalars) -> Values:
        """Return the evaluator of outputs for inputs of the run and groups of numbers by name, shape (outputs, ...)."""
        replay = Evaluator(outputs, np.longdouble, [*itertools.chain(*self._given.values())])

        def values(inputs: Sequence[float], **groups: Sequence[float] | Array) -> Array:
            given = [groups.get(name, [0.0] * len(group)) for name, group in self._given.items()]
            with np.errstate(all="ignore"):
                return np.stack(np.broadcast_arrays(*replay([*itertools.chain(*given), *inputs])))

        return values


class TangentJump:
    """Jump of the tangent vectors of one motion at a switch of conditions.

    Parameters
    ----------
    saltation : Saltation
    row : array (size,)
        All variables there.
    time : float
    inputs : sequence of float
        Of the run.
    near : float
        Simultaneity tolerance.
    """

    def __init__(self, saltation: Saltation, row: Array, time: float, inputs: Sequence[float], near: float) -> None:
        self._saltation, self._inputs, self._near = saltation, inputs, near
        first = row.size - saltation.variations.size
        self._own, self._variables = [*row[:first], time], row[first:].astype(np.longdouble)
        self._u, self._pairs, _, self._units = saltation.variations.split(self._variables)

    def across(self, before: Array, behind: Array) -> Array:
        """Return the variables of tangent vectors after the jump.

        Parameters
        ----------
        before, behind : arrays (conditions,)
            Which conditions hold, 1 or 0.

        Raises
        ------
        NoDerivative
        """
        left = np.flatnonzero(before != behind).tolist()
        while left:
            first, passed = self._first_of(left, before)
            after = before.copy()
            after[passed] = behind[passed]
            self._pass(first, before, after)
            left, before = [number for number in left if number not in passed], after
        return self._variables.astype(float)

    def _first_of(self, left: Sequence[int], holds: Array) -> tuple[_Crossing, list[int]]:
        """Return the first crossing and the conditions that switch there: on the same surface, or by a jump."""
        found = sorted((self._crossing(number, holds) for number in left), key=lambda each: each.distance)
        first, size = found[0], np.max(np.abs(found[0].shift), initial=0.0)
        if not first.distance <= AT_ZERO * self._near:
            raise NoDerivative("the condition of a `where` jumps over zero. Neighbouring motions have no derivative.")
        uncertain = max(self._near, first.distance)
        if not (abs(first.slope) > MIN_GRAZING_RATIO * uncertain * abs(first.bend) and np.isfinite(size)):
            raise NoDerivative("it grazes the switch of a `where`. Neighbouring motions have no derivative there.")
        near = [each for each in found if each.distance <= max(AT_ONCE * self._near, 4 * first.distance)]
        alike = [each for each in near if np.all(np.abs(each.shift - first.shift) <= SAME_TIME_TOLERANCE * size)]
        return first, list(left) if len(alike) == len(near) else [each.number for each in alike]

    def _crossing(self, number: int, holds: Array) -> _Crossing:
        value, slope, bend, change = self._values(self._saltation.crossing(number), holds, a=self._directions)
        with np.errstate(all="ignore"):
            distance = np.abs(value / slope).flat[0]
            return _Crossing(
                number, slope.flat[0], bend.flat[0], distance if distance >= 0 else np.inf, -change / slope
            )

    def _pass(self, crossing: _Crossing, before: Array, after: Array) -> None:
        """Apply the jump of tangent vectors at a change from one velocity to another."""
        k = self._u.shape[-1]
        motions = [self._values(self._saltation.velocity, holds) for holds in (before, after)]
        jump = motions[0][:k] - motions[1][:k]
        if self._pairs.size:
            self._pairs += self._of_pairs(crossing, before, after, motions, jump)
        self._u += np.outer(crossing.shift, jump)

    def _of_pairs(
        self, crossing: _Crossing, before: Array, after: Array, motions: Sequence[Array], jump: Array
    ) -> Array:
        """Return the jumps of second differentials, shape (pairs, k)."""
        own, k, xi, s = self._saltation, jump.size, self._directions, crossing.shift
        a, b = np.array(own.variations.pairs).T
        bent = own.bent(crossing.number)
        of_pairs, slope_a = self._values(bent, before, a=xi[:, a], b=xi[:, b], pair=self._pairs.T)
        _, slope_b = self._values(bent, before, a=xi[:, b], b=xi[:, a], pair=self._pairs.T)
        both = -(of_pairs + s[a] * slope_b + s[b] * slope_a + s[a] * s[b] * crossing.bend) / crossing.slope
        change = (self._values(own.change, before, a=xi) - self._values(own.change, after, a=xi)).T
        ff, gf, gg = (
            self._values(own.acceleration, holds, velocity=motion[:k], rates=motion[k:])
            for holds, motion in ((before, motions[0]), (after, motions[0]), (after, motions[1]))
        )
        mixed = s[a, None] * change[b] + s[b, None] * change[a] + np.outer(s[a] * s[b], ff - 2 * gf + gg)
        return np.asarray(np.outer(both, jump) + mixed)

    @property
    def _directions(self) -> Array:
        """Tangent vectors with their changes of inputs, shape (k + inputs, vectors)."""
        inputs = np.zeros((len(self._saltation.inputs), len(self._u)), dtype=np.longdouble)
        inputs[:, self._saltation.variations.count :] = self._saltation.inputs * (self._units / INPUT_UNIT)
        return np.concatenate([self._u.T, inputs])

    def _values(self, values: Values, holds: Array, **groups: Array) -> Array:
        return values(self._inputs, own=self._own, holds=holds, **groups)


class _Crossing(NamedTuple):
    """Zero of the function of a condition: derivatives along the motion, and delays of neighbouring motions.

    Attributes
    ----------
    distance : float
        The time to its zero.
    shift : array (vectors,)
    """

    number: int
    slope: np.floating
    bend: np.floating
    distance: float
    shift: Array


def _jumping(graph: Graph, rates: Scalars, conditions: Container[Node]) -> set[Node]:
    """Return the conditions at which rates may jump: all except those at which rates are evidently continuous."""
    switches = [node for node in ordered(rates) if node.name == "where" and node.operands[0] in conditions]
    return {node.operands[0] for node in switches if not _is_continuous(graph, node)}


def _is_continuous(graph: Graph, switch: Node) -> bool:
    """Return True if both branches are the same formula where both sides of a `less` are the same scalar."""
    condition, *branches = switch.operands
    number = [x for x in condition.operands if not isinstance(x, Node)]
    common = number[0] if number else graph.symbol("both sides")
    one, other = replaced(branches, dict.fromkeys(condition.nodes, common))
    return one is other or bool(one == other)
