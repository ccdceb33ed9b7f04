"""Formulas of forces on named symbols, for `display/formulas.py` to typeset."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import cast

from typing_extensions import override

from poinsot.display.formulas import ForceSummary, Formula, StatedFormula, SystemSummary, TracedFormula
from poinsot.display.notation import split_name
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude, matrix_of
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment, Orbit, orbits_of
from poinsot.mechanics.force import Force, Potential, Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import named_parts
from poinsot.records.parameters import Parametric, same
from poinsot.records.units import DerivedUnits, in_units
from poinsot.systems.integrals import Integral
from poinsot.taylor.graph import Graph, GraphScalar, Node

__all__ = ["formula_of", "stated_formula", "summary_of_system"]

COMPUTED = frozenset({"formula", "energy", "torque", "load", "momentum", "rates", "torque_at"})
"""The attributes of a class that state its formula or compute it."""

ANY_BODY, RIGID_BODY = "rate(q) = q*omega/2; rate(g) = cross(g, omega) + N", "; omega = I**-1*g"
"""The equations of motion of one body, and the equation that is added for a body without parts."""


def summary_of_system(
    body: Parametric, forces: Sequence[Force], units: Mapping[str, str], integrals: Iterable[Integral]
) -> SystemSummary:
    """Return the formulas of a system, the numbers in them and the conserved quantities, as plain data."""
    derived, orbits, single = DerivedUnits(units), _distinct_orbits(forces), isinstance(body, Body)
    return SystemSummary(
        motion=(ANY_BODY if named_parts(forces) else ANY_BODY + RIGID_BODY) if single else "",
        body=in_units(body, derived),
        forces=[
            ForceSummary(
                kind=type(force).__name__,
                description=_description(type(force)),
                numbers=in_units(force, derived),
                formula=formula_of(force, body, orbits),
            )
            for force in forces
        ],
        conserved=[f"{integral.symbol}: {integral.meaning}" for integral in integrals],
        two_bodies=not single,
    )


def formula_of(force: Force, body: Parametric, orbits: Sequence[Orbit]) -> Formula | None:
    """Return the formula that a class states, or the values of its code on named symbols; None if neither exists.

    Letters of the second and the third of the orbits have primes.
    """
    if stated := stated_formula(type(force)):
        own = next(orbits_of(force), None)
        return StatedFormula(stated, _place(own, orbits) if own else 0)
    if not isinstance(force, Potential | Torque) or not isinstance(body, Body):
        return None
    try:
        return _traced(force, body, orbits)
    except Exception:  # a user's code may need numbers, and fail on symbols with any error
        return None


def stated_formula(kind: type[Force]) -> str:
    """Return the formula that a class states; "" if it states none, or if a derived class computes another one."""
    owner = next(each for each in kind.__mro__ if vars(each).keys() & COMPUTED)
    return str(vars(owner).get("formula", ""))


def _description(kind: type[Force]) -> str:
    """Return the docstring of a class up to its parameters."""
    text = inspect.cleandoc(kind.__doc__ or "")
    return " ".join(re.split(r"\n\n(?=\w+\n-+\n)", text)[0].split())


def _distinct_orbits(forces: Iterable[Force]) -> list[Orbit]:
    """Return the orbits of the forces, each once."""
    found: list[Orbit] = []
    for orbit in (orbit for force in forces for orbit in orbits_of(force)):
        found += [] if any(same(orbit, one) for one in found) else [orbit]
    return found


def _place(orbit: Orbit, orbits: Sequence[Orbit]) -> int:
    """Return the number of an orbit among the orbits of a system."""
    return next(i for i, one in enumerate(orbits) if same(one, orbit))


def _traced(force: Potential | Torque, body: Body, orbits: Sequence[Orbit]) -> TracedFormula:
    """Return the energy or the torque of a force on symbols that have the names of its parameters."""
    graph = Graph()
    named = force.with_numbers(graph.symbol(split_name(name)) for name, _ in force.number_names())
    moments = [graph.symbol(("I", str(i))) for i in (1, 2, 3)]
    numbers: list[Scalar] = [*moments, *map(float, body.numbers[3:])]
    primes = {id(new): _place(old, orbits) for new, old in zip(orbits_of(named), orbits_of(force), strict=True)}
    attitude = _NamedAttitude(matrix_of([[graph.symbol(("R", f"{i}{j}")) for j in (1, 2, 3)] for i in (1, 2, 3)]))
    omega = Vector(graph.symbol(("omega", str(i))) for i in (1, 2, 3))
    instant = Instant(body.with_numbers(numbers), attitude, _NamedEnvironment(graph, primes), omega_body=omega)
    if isinstance(named, Potential):
        return TracedFormula("U", [cast("Node", named.energy(instant))])
    return TracedFormula("N", list(named.torque(instant)))


class _Named(Vector):
    """A vector in space whose components along the body axes have names."""

    def __init__(self, graph: Graph, letter: str) -> None:
        super().__init__(graph.symbol((letter, f"s{i}")) for i in (1, 2, 3))
        self.in_body = Vector(graph.symbol((letter, str(i))) for i in (1, 2, 3))


class _NamedAttitude(Attitude):
    """An attitude that resolves a named vector along the body axes by its names."""

    @override
    def to_body(self, vector: Iterable[Scalar]) -> Vector:
        return vector.in_body if isinstance(vector, _Named) else super().to_body(vector)


class _NamedEnvironment(Environment):
    """An environment in which vectors of orbits are letters, with a prime for each orbit before."""

    def __init__(self, graph: Graph, primes: Mapping[int, int]) -> None:
        super().__init__(0.0)
        self.time = graph.symbol(("t", ""))
        self._graph, self._primes = graph, primes

    def _letter(self, letter: str, orbit: Orbit) -> str:
        return letter + "'" * self._primes[id(orbit)]

    @override
    def position(self, orbit: Orbit) -> Vector:
        return _Named(self._graph, self._letter("x", orbit))

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        return _Named(self._graph, self._letter("v", orbit))

    @override
    def direction(self, orbit: Orbit) -> Vector:
        return _Named(self._graph, self._letter("u", orbit))

    @override
    def inverse_distance(self, orbit: Orbit) -> GraphScalar:
        return 1 / self._graph.symbol((self._letter("r", orbit), ""))
