"""Equations of motion of a problem, traced on symbols, as programs of kernels.

A kernel belongs to the structure of a system. Every real number is a run-time parameter, so that new values compile
nothing.
"""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast

from poinsot import functions
from poinsot.functions import Vector
from poinsot.integration.formulations import Formulation, refuse_spatial_motion
from poinsot.integration.problem import Problem
from poinsot.integration.saltation import Saltation
from poinsot.integration.scaling import momentum_ratios, momentum_scales, power_of_two, torque_scale
from poinsot.integration.state_vector import StateVector, factors_of_parts
from poinsot.integration.variational import TurningBody, VariationalEquations, Variations
from poinsot.kinematics.state import AnyState
from poinsot.mechanics.environment import Environment, shared_blocks, viewed
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.part import Part
from poinsot.random_numbers import normals
from poinsot.records.formula_errors import FormulaError, use_functions
from poinsot.taylor.graph import Graph, GraphScalar, Node, ordered
from poinsot.taylor.llvm_ir import host_features
from poinsot.taylor.lowering import TIME, conditions_of
from poinsot.taylor.rescaling import MOMENTUM_SCALE
from poinsot.taylor.sampling import Update

LANES = 8 if host_features().get("avx512f") else 4 if host_features().get("avx") else 2
"""Members in a vector. On processors that run 512-bit code 8 are faster than 4 at every order: 1.1 to 1.5 times on an
AMD Zen 4, 1.4 to 1.8 times on an Intel Xeon."""

MAX_STORED = 256
"""Kernels and other results about equations that a process stores."""

Result = TypeVar("Result")


class Cache:
    """Results by key, the least recently used dropped first; threads may share it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stored: OrderedDict[Hashable, Any] = OrderedDict()

    def __call__(self, key: Hashable, computed: Callable[[], Result]) -> Result:
        """Return the result of a key, computed on the first call."""
        with self._lock:
            if key in self._stored:
                self._stored.move_to_end(key)
                found: Result = self._stored[key]
                return found
        result = computed()
        with self._lock:
            self._stored[key] = result
            while len(self._stored) > MAX_STORED:
                self._stored.popitem(last=False)
        return result


known = Cache()


def state_vector(problem: Problem, state: AnyState, formulation: Formulation, precision: str) -> StateVector:
    """Return the variables in which a system is integrated: in comoving axes where all its forces allow.

    Quadruple precision stays in the space axes, as an independent check of the comoving ones.
    """
    smooth, system = problem.smooth, problem.dynamics
    if formulation.planar:
        refuse_spatial_motion(system, state)
    torque = torque_scale(system)
    sizes = momentum_scales(system, state, torque)
    scale = power_of_two(MOMENTUM_SCALE / next(iter(sizes.values())))
    parts, ratios = factors_of_parts(system, state), momentum_ratios(sizes)
    if smooth.orbits and formulation.turns and precision == "double" and len(ratios) == 1:
        orbits, views = shared_blocks(smooth.orbits, lambda _: True)
        comoving = StateVector(formulation, scale, parts, orbits, views, comoving=True, torque_scale=torque)
        if set(comoving.views) == {0} and _can_be_comoving(smooth, comoving):
            return comoving.sharing(smooth.alike.by_variables)
    orbits, views = shared_blocks(smooth.orbits, lambda orbit: orbit.integrated)
    variables = StateVector(formulation, scale, parts, orbits, views, ratios=ratios, torque_scale=torque)
    return variables.sharing(smooth.alike.by_variables)


def _can_be_comoving(problem: Problem, variables: StateVector) -> bool:
    """Return True if no formula reads the space axes themselves, whatever its numbers."""
    known = problem.alike
    if "can be comoving" not in known:
        try:
            traced_equations(problem, variables)
            known["can be comoving"] = True
        except functions.NotComoving:
            known["can be comoving"] = False
    found: bool = known["can be comoving"]
    return found


@dataclass(frozen=True)
class Equations:
    """The equations of a kernel as nodes of one graph.

    Attributes
    ----------
    own : list of nodes
        The variables, then the time.
    rates : list of scalars
        The time derivatives of the variables.
    events, counting : lists of scalars
        The values of the events, and conditions that are positive where their zeros count. Another value is the
        distance of the variables from their singularity, if they have one.
    updates : list of Update
        New values of variables at samples.
    saltation : Saltation or None
        Jumps of tangent vectors at switches of formulas.
    """

    own: list[Node]
    rates: list[GraphScalar]
    events: list[GraphScalar]
    counting: list[GraphScalar]
    updates: list[Update]
    saltation: Saltation | None = None

    @property
    def conditions(self) -> dict[Node, GraphScalar]:
        """The conditions on which formulas branch, and the functions that are negative where they hold."""
        return conditions_of([*self.rates, *self.events, *self.counting])


def traced_equations(problem: Problem, variables: StateVector) -> Equations:
    """Return the equations of a problem, from its formulas on symbols."""
    graph = Graph()
    numbers = map(graph.input, itertools.count())
    scale, variables, symbolic = next(numbers), variables.with_factors(numbers), problem.with_numbers(numbers)
    own, time = [graph.symbol(place) for place in range(variables.size)], graph.symbol(TIME)
    chart, system, variations = variables.formulation, symbolic.dynamics, variables.variations
    environment = _environment(symbolic, variables, own, time) if problem.orbits else Environment(time)
    turning = None
    if variables.comoving:
        ((block, along),) = environment.blocks
        turning = block.omega(time, along)
    try:
        motions = [own[place] for place in variables.charts]
        bodies = [chart.physical(motion) for motion in motions]
        axes = [(attitude.matrix, attitude.quaternion) for attitude, _ in bodies]
        for attitude, _ in bodies:
            attitude._complete(comoving=variables.comoving)
        instant = system.instant(bodies, variables.physical(own, scale), environment, variables.scales(scale))
        turnings, blocks = system.changes(instant)
        of_blocks = cast("list[GraphScalar]", [*variables.rates(blocks, scale)])
        of_charts = [
            rate
            for motion, each in zip(motions, turnings, strict=True)
            for rate in chart.rates(motion, each.omega, each.momentum_rate, each.torque, turning)
        ]
        rates = cast("list[GraphScalar]", [*of_charts, *of_blocks])
        events = [cast("Node", event.value(instant)) for event in symbolic.events]
        jumping = system.jumping if problem.dynamics.jumping else ()
        updates = [_update(graph, part, instant, variables, scale) for part in jumping]
        conditions = [cast("Node", event.condition(instant)) for event in symbolic.events]
        distance = chart.nearness([*own, time])
        events += [] if distance is None else [cast("Node", distance)]
        traced = Equations([*own, time], rates, [*events], [*conditions], updates)
        if variations is None:
            return traced
        parts = own[variables.charts[-1].stop : variables.along_orbits.start]
        linear = VariationalEquations(
            variables.tangent_coordinates,
            [
                TurningBody(cast("Any", matrix), quaternion, g, each.omega, each.momentum_rate)
                for (matrix, quaternion), (_, g), each in zip(axes, bodies, turnings, strict=True)
            ],
            parts,
            of_blocks[: len(parts)],
            graph.input,
        )
        _refuse_varied_samples(graph, jumping, variations)
        return _with_variations(traced, graph, variables, linear, variations)
    except FormulaError:
        raise
    except TypeError as error:
        raise FormulaError(use_functions("the formula of a force", error)) from error


def _with_variations(
    traced: Equations, graph: Graph, variables: StateVector, linear: VariationalEquations, variations: Variations
) -> Equations:
    """Return equations together with the variational equations."""
    *own, time = traced.own
    vectors, motion = own[variables.tangent_vectors], [*own[: variables.tangent_vectors.start], time]
    velocity = [*traced.rates, 1.0]
    varied = replace(traced, rates=[*traced.rates, *linear.of(variations, vectors)])
    conditions = varied.conditions
    saltation = Saltation(graph, motion, velocity, conditions, linear, variations) if conditions else None
    updates = [
        _with_tangents(update, variables, linear.differentials(variations, vectors, update.values))
        for update in traced.updates
    ]
    return replace(varied, updates=updates, saltation=saltation if saltation and saltation.stops else None)


def _update(graph: Graph, part: Part, instant: Instant | PairInstant, variables: StateVector, scale: Node) -> Update:
    """Return the formulas of the new values that a part gets at a sample."""
    count = part.jump.draws if part.jump else 0
    draws = [graph.symbol((part.name, i)) for i in range(count + count % 2)]
    slot, values = variables.slots[part.name], part.update(instant, Vector(normals(draws)[:count]))  # type: ignore[arg-type]
    return Update(
        [*range(slot.place.start, slot.place.stop)], cast("list[GraphScalar]", slot.scaled(values, scale)), draws
    )


def _with_tangents(update: Update, variables: StateVector, changes: list[list[GraphScalar]]) -> Update:
    """Return an update with new values of the tangent coordinates of its variables: the differentials of the values."""
    rigid = len(variables.ratios) * len(variables.formulation.tangent)
    behind = variables.tangent_vectors.start + rigid - variables.charts[-1].stop
    k = len(variables.tangent_scales)
    places = [behind + number * k + place for number in range(len(changes)) for place in update.places]
    return update._replace(places=[*update.places, *places], values=[*update.values, *itertools.chain(*changes)])


def _refuse_varied_samples(graph: Graph, parts: Sequence[Part], variations: Variations) -> None:
    """Raise a ValueError for derivatives by numbers that the times of samples depend on."""
    varied = {graph.input(number) for together in variations.inputs for number in together}
    if varied & set(ordered([x for part in parts if part.jump for x in (part.jump.period, part.jump.offset)])):
        raise ValueError(
            "parameters must not be the period or the offset of a sampled law, got one. At samples motions jump; take "
            "differences of motions."
        )


def _environment(symbolic: Problem, variables: StateVector, own: list[Node], time: Node) -> Environment:
    """Return the environment on symbols: each orbit by the variables of the block that it views, if it views one."""
    numbers = {id(orbit): number for orbit, number in zip(symbolic.orbits, variables.views, strict=True)}
    values = [Vector(own[variables.slots[f"orbits[{i}]"].place]) for i in range(len(variables.orbits))]
    blocks = list(zip(viewed(symbolic.orbits, variables.views), values, strict=True))
    return Environment(time, blocks, numbers, variables.comoving)
