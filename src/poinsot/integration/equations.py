"""Equations of motion of a problem as programs of kernels.

A kernel belongs to the structure of a system; every real number is a runtime parameter, so that new values compile
nothing.
"""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Vector
from poinsot.integration.formulations import Formulation
from poinsot.integration.planar_motion import refuse_spatial_motion
from poinsot.integration.problem import Problem
from poinsot.integration.saltation import Saltation
from poinsot.integration.scaling import momentum_ratios, momentum_scales
from poinsot.integration.state_vector import StateVector, factors_of_parts
from poinsot.integration.tangent_vectors import Variations
from poinsot.integration.variational import TurningBody, VariationalEquations
from poinsot.mechanics.environment import Environment, shared_blocks, viewed
from poinsot.mechanics.event import Event
from poinsot.mechanics.formula_errors import FormulaError, use_functions
from poinsot.mechanics.part import Part
from poinsot.mechanics.state import AnyState
from poinsot.printable import quoted
from poinsot.taylor.decomposition import Crossing, Momenta
from poinsot.taylor.draws import normals
from poinsot.taylor.graph import Graph, Node, ordered, tangents
from poinsot.taylor.llvm_ir import host_features
from poinsot.taylor.lowering import TIME, Constants, Events, Program, conditions_of, simplified
from poinsot.taylor.replay import Replay
from poinsot.taylor.rescaling import SMALL
from poinsot.taylor.updates import Update

FIRST = np.zeros(1, dtype=int)

PRECISIONS = ("double", "quadruple")

LANES = 8 if host_features().get("avx512f") else 4 if host_features().get("avx") else 2
"""Members in a vector. On processors that run 512-bit code 8 are faster than 4 at every order: 1.1 to 1.5 times on an
AMD Zen 4, 1.4 to 1.8 times on an Intel Xeon."""

DECISIONS = 256
"""Answers about equations that are kept."""


class _Answers:
    """Answers about equations by questions, the least recently used dropped first; threads may share it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: OrderedDict[Any, Any] = OrderedDict()

    def __call__(self, key: Any, question: Callable[[], Any]) -> Any:
        """Return the answer to a question about equations, asked once."""
        with self._lock:
            if key in self._known:
                self._known.move_to_end(key)
                return self._known[key]
        answer = question()
        with self._lock:
            self._known[key] = answer
            while len(self._known) > DECISIONS:
                self._known.popitem(last=False)
        return answer


known = _Answers()


def state_vector(problem: Problem, state: AnyState, formulation: Formulation, precision: str) -> StateVector:
    """Return the variables in which a system is integrated: in comoving axes where all its forces allow.

    Quadruple precision stays in the space axes, as an independent check of the comoving ones.
    """
    smooth, system = problem.between_knots(), problem.dynamics
    if formulation.planar:
        refuse_spatial_motion(system, state)
    # A power of two scales without rounding.
    sizes = momentum_scales(system, state)
    scale = np.exp2(np.rint(np.log2(SMALL / next(iter(sizes.values())))))
    parts, ratios = factors_of_parts(system, state), momentum_ratios(sizes)
    if smooth.orbits and formulation.turns and precision == "double" and len(ratios) == 1:
        comoving = StateVector(formulation, scale, parts, *shared_blocks(smooth.orbits, lambda _: True), comoving=True)
        if set(comoving.views) == {0} and smooth.known(_can_be_comoving, comoving):
            return comoving.sharing(smooth.known(_by_variables))
    orbits, views = shared_blocks(smooth.orbits, lambda orbit: orbit.integrated)
    return StateVector(formulation, scale, parts, orbits, views, ratios=ratios).sharing(smooth.known(_by_variables))


def looped_constants(problem: Problem, variables: StateVector) -> Constants:
    """Return the constants of a kernel."""
    known, key = problem.known(_by_variables), ("constants", variables.structure)
    if key not in known:
        known[key] = _looped_constants(problem, variables)
    constants: Constants = known[key]
    return constants


def _by_variables(_: Problem) -> dict[Any, Any]:
    """Return what is found of a structure by its variables, as long as nothing is."""
    return {}


def _looped_constants(problem: Problem, variables: StateVector) -> Constants:
    field = _traced(problem, variables)
    refuse_constant_events(problem.events, field.events, variables.formulation.name)
    program = _program(problem, variables, field, ())
    return Constants([*field.rates, *_events(problem, variables, field).values], program, field.saltation is not None)


def _events(problem: Problem, variables: StateVector, field: _Field) -> Events:
    """Return the events with, last of all, the fall to zero of what says that variables become singular."""
    crossings = [Crossing(event.direction, event.terminal or event.acts) for event in problem.events]
    near = variables.formulation.nearness(field.own)
    if near is None:
        return Events(field.events, tuple(crossings))
    return Events([*field.events, near], (*crossings, Crossing(0, True)))


def looped_program(problem: Problem, variables: StateVector, zeros: Iterable[int] = ()) -> Program:
    """Return the program for runs in which some of the constants are zero."""
    return _program(problem, variables, _traced(problem, variables), zeros)


def _program(problem: Problem, variables: StateVector, field: _Field, zeros: Iterable[int]) -> Program:
    program = simplified(field.rates, zeros, _events(problem, variables, field))
    program = program.with_jumps(field.own, field.updates)
    places = np.arange(variables.size)[variables.momenta].tolist()
    conjugates = tuple((q.start, Q.start) for q, Q in variables.conjugates)
    decomposition = replace(
        program.decomposition,
        stops=tuple(field.saltation.stops if field.saltation else ()),
        attitude=tuple(variables.attitude),
        momenta=Momenta(tuple(places), tuple(variables.scaled), tuple(program.powers.tolist()), conjugates),
    )
    return replace(program, decomposition=decomposition)


def saltation_of(problem: Problem, variables: StateVector) -> Saltation | None:
    """Return how tangent vectors jump where formulas switch; None if they do not."""
    if variables.variations is None:
        return None
    smooth = problem.between_knots()
    found: Saltation | None = known(
        ("saltation", smooth.structure, variables.structure), lambda: _traced(smooth, variables).saltation
    )
    return found


def numbers_of(problem: Problem, variables: StateVector) -> tuple[Any, ...]:
    """Return the inputs of a run."""
    return variables.scale, *variables.factors, *problem.numbers


def numbers_around(
    problem: Problem, variables: StateVector, numbers: Sequence[Any], times: Any, members: NDArray[np.int_]
) -> list[Any]:
    """Return the inputs of members between the knots around times; `numbers` are those around the first of all."""
    around = numbers_of(problem.between_knots(times), variables)
    return [x[members] if np.ndim(y) else x for x, y in zip(around, numbers, strict=True)]


def counting(problem: Problem, variables: StateVector) -> Replay:
    """Return what gives, of variables, time and numbers, what is positive where zeros of events count."""
    field = _traced(problem, variables)
    return Replay(field.counting, np.float64, field.own)


def _can_be_comoving(problem: Problem, variables: StateVector) -> bool:
    """Whether no force looks at the space axes themselves: a matter of its formula, whatever the numbers."""
    try:
        _traced(problem, variables)
    except functions.NotComoving:
        return False
    return True


@dataclass(frozen=True)
class _Field:
    """The equations of a kernel as nodes of one graph.

    Attributes
    ----------
    own : list of nodes
        The variables and, behind them, the time.
    rates : list of scalars
        The time derivatives of the variables.
    events, counting : lists of scalars
        The values of the events, and what is positive where their zeros count.
    saltation : Saltation or None
        The saltation matrices of tangent vectors, where formulas switch.
    updates : list of Update
        What is done at samples.
    """

    own: list[Node]
    rates: list[Any]
    events: list[Any]
    counting: list[Any]
    updates: list[Update]
    saltation: Saltation | None = None

    @property
    def conditions(self) -> dict[Node, Any]:
        """The conditions on which formulas branch, and the functions that are negative where they hold."""
        return conditions_of([*self.rates, *self.events, *self.counting])

    def along(self, outputs: list[Any]) -> list[Any]:
        """Return the derivatives of functions along the motion."""
        return tangents(outputs, dict(zip(self.own, [*self.rates, 1.0], strict=True)))


def _traced(problem: Problem, variables: StateVector) -> _Field:
    """Return the equations of a problem: the formulas are run on symbols."""
    graph = Graph()
    inputs = map(graph.input, itertools.count())
    scale, variables, twin = next(inputs), variables.with_factors(inputs), problem.with_numbers(inputs)
    own, time = [graph.symbol(place) for place in range(variables.size)], graph.symbol(TIME)
    chart, system, variations = variables.formulation, twin.dynamics, variables.variations
    environment = _environment(twin, variables, own, time)
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
        of_blocks = [*variables.rates(blocks, scale)]
        of_charts = [
            rate
            for motion, each in zip(motions, turnings, strict=True)
            for rate in chart.rates(motion, each.omega, each.momentum_rate, each.torque, turning)
        ]
        rates = [*of_charts, *of_blocks]
        events = [event.value(instant) for event in twin.events]
        updates = [_update(graph, part, instant, variables, scale) for part in system.jumping]
        counting = [event.condition(instant) for event in twin.events]
        field = _Field([*own, time], rates, events, counting, updates)
        if variations is None:
            return field
        parts = own[variables.charts[-1].stop : variables.along_orbits.start]
        linear = VariationalEquations(
            variables.tangent_coordinates,
            [
                TurningBody(*of_body, g, each.omega, each.momentum_rate)
                for of_body, (_, g), each in zip(axes, bodies, turnings, strict=True)
            ],
            parts,
            of_blocks[: len(parts)],
            graph.input,
        )
        _refuse_varied_samples(graph, system.jumping, variations)
        motion, velocity = [*own[: variables.tangent_vectors.start], time], [*rates, 1.0]
        rates += linear.of(variations, own[variables.tangent_vectors])
        saltation = (
            Saltation(graph, motion, velocity, field.conditions, linear, variations) if field.conditions else None
        )
        vectors = own[variables.tangent_vectors]
        changed = [
            _with_tangents(update, variables, linear.differentials(variations, vectors, update.values))
            for update in updates
        ]
        return replace(field, updates=changed, saltation=saltation if saltation and saltation.stops else None)
    except FormulaError:
        raise
    except TypeError as error:
        raise FormulaError(use_functions("the formula of a force", error)) from error


def _update(graph: Graph, part: Part, instant: Any, variables: StateVector, scale: Any) -> Update:
    """Return the formulas of the new values that a part gets at a sample."""
    count = part.jump.draws if part.jump else 0
    draws = [graph.symbol((part.name, i)) for i in range(count + count % 2)]
    slot, values = variables.slots[part.name], part.update(instant, Vector(normals(draws)[:count]))
    return Update([*range(slot.place.start, slot.place.stop)], slot.scaled(values, scale), draws)


def _with_tangents(update: Update, variables: StateVector, changes: list[list[Any]]) -> Update:
    """Return an update with that of the tangent coordinates of the same variables: the differentials of the values."""
    rigid = len(variables.ratios) * len(variables.formulation.tangent)
    behind = variables.tangent_vectors.start + rigid - variables.charts[-1].stop
    k = len(variables.tangent_scales)
    places = [behind + number * k + place for number in range(len(changes)) for place in update.places]
    return update._replace(places=[*update.places, *places], values=[*update.values, *itertools.chain(*changes)])


def _refuse_varied_samples(graph: Graph, parts: Sequence[Part], variations: Variations) -> None:
    """Refuse derivatives by what the times of samples depend on."""
    varied = {graph.input(number) for together in variations.inputs for number in together}
    if varied & set(ordered([x for part in parts if part.jump for x in (part.jump.period, part.jump.phase)])):
        raise ValueError(
            "parameters must not be the period or the phase of a sampled law, got one. At samples motions jump; take "
            "differences of motions."
        )


def _environment(twin: Problem, variables: StateVector, own: list[Any], time: Any) -> Environment:
    """Return the environment in a kernel: each orbit by the variables of the block that it views, if it views one."""
    numbers = {id(orbit): number for orbit, number in zip(twin.orbits, variables.views, strict=True)}
    values = [Vector(own[variables.slots[f"orbits[{i}]"].place]) for i in range(len(variables.orbits))]
    blocks = list(zip(viewed(twin.orbits, variables.views), values, strict=True))
    return Environment(time, blocks, numbers, variables.comoving)


def refuse_constant_events(events: Sequence[Event], values: Sequence[Any], formulation: str) -> None:
    """Raise a ValueError if the value of an event, a scalar of a kernel, is the same all the way."""
    for event, value in zip(events, values, strict=True):
        if not (isinstance(value, Node) and value.varies):
            raise ValueError(
                f"the value of {type(event).__name__} must depend on the motion, but it is constant in the variables "
                f"of {quoted(formulation)}."
            )
