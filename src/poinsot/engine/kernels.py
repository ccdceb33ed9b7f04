"""Compiled kernels: the only place that builds an integrator.

A kernel belongs to the structure of a system; every real number is a runtime parameter, so that new values
compile nothing. Idle integrators wait in one bounded, thread-safe pool, the package's only global state.
"""

from __future__ import annotations

import functools
import itertools
import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.algebra.draws import normals
from poinsot.algebra.program import Graph, Node, ordered, tangents
from poinsot.algebra.replay import Replay
from poinsot.engine.decomposition import Crossing, Momenta
from poinsot.engine.discontinuities import Discontinuities, Pieces, event_class, lane_of
from poinsot.engine.event_detection import EventDetection, refuse_constant_events
from poinsot.engine.formulations import Formulation
from poinsot.engine.heyoka_expressions import Expressions
from poinsot.engine.jumps import Update
from poinsot.engine.kernel_momenta import SMALL
from poinsot.engine.lowering import TIME, Constants, Events, Program, conditions_of, lowered, simplified
from poinsot.engine.planar_motion import refuse_spatial_motion
from poinsot.engine.problem import Problem
from poinsot.engine.roots import Roots
from poinsot.engine.saltation import Jump, NoDerivative, Saltation
from poinsot.engine.scales import Scales
from poinsot.engine.state_vector import StateVector, factors_of_parts
from poinsot.engine.tangent_vectors import STEPS_AT_A_TIME, Variations
from poinsot.engine.termination import LONGEST
from poinsot.engine.variational import TurningBody, VariationalEquations
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment, shared_blocks, viewed
from poinsot.mechanics.formula_errors import FormulaError, use_functions
from poinsot.mechanics.part import Part
from poinsot.mechanics.state import State

PRECISIONS: dict[str, Any] = {
    "double": np.float64,
    "extended": np.longdouble,
    "quadruple": getattr(hy, "real128", None),
}


def _fastest_lanes(features: Collection[str], recommended: int) -> int:
    """Return how many lanes a batch has on a processor, of the engine's recommendation where it runs no 512-bit code.

    On some that do the engine recommends 4, and 8 are faster all the same at every order: 1.1 to 1.5 times on an AMD
    Zen 4, 1.4 to 1.8 times on an Intel Xeon. The engine has no batches of one.
    """
    return 8 if {"AVX512F", "AVX512_SKX", "X86_V4"} & set(features) else max(2, recommended)


def _features() -> list[str]:
    """Return the names of the processor's instructions that NumPy knows."""
    config: Any = np.show_config(mode="dicts")
    known = config.get("SIMD Extensions", {})
    return [*known.get("baseline", ()), *known.get("found", ())]


LANES = _fastest_lanes(_features(), hy.recommended_simd_size())
IDLE_INTEGRATORS = 64
DECISIONS = 256
LARGE = {"double": 350, "extended": 80, "quadruple": 80}
"""Operations of a step above which the compiler would take many seconds: a system this large runs in the
engine's compact mode, which compiles in one or two and takes two or three times as long a step; with many tangent
vectors it takes a quarter longer."""

SHARE, SHORTER = 0.0437, 0.618
"""The longest step over the time of a run with events, and what it is times that where a zero was lost.

Where a zero lies on a point of bisection of a step, the engine loses others. Shares that are no round numbers keep
round times off these points.
"""

SAMPLES = 32
"""How many rows of a chunk of steps are looked at."""

FIRST = np.zeros(1, dtype=int)

OUTCOMES = {
    int(getattr(hy.taylor_outcome, name)): name for name in ("success", "step_limit", "time_limit", "err_nf_state")
}
TIME_LIMIT, NOT_FINITE = int(hy.taylor_outcome.time_limit), int(hy.taylor_outcome.err_nf_state)

hy.set_logger_level_error()  # it warns of each event at each step of each member that fails; `failures` says it once


@dataclass(frozen=True)
class _Compiled:
    """An integrator, the arithmetic of its parameters, and what changes them on the way, if anything does."""

    engine: Any
    values: Replay
    powers: NDArray[np.int_]
    roots: Roots
    discontinuities: Discontinuities | None
    detection: EventDetection | None


class _Pool:
    """Idle integrators by what they are built for, the least recently used dropped first."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: OrderedDict[Any, list[_Compiled]] = OrderedDict()
        self._decided: OrderedDict[Any, Any] = OrderedDict()

    def take(self, key: Any) -> _Compiled | None:
        with self._lock:
            idle = self._idle.get(key)
            return idle.pop() if idle else None

    def give(self, key: Any, built: _Compiled) -> None:
        with self._lock:
            self._idle.setdefault(key, []).append(built)
            self._idle.move_to_end(key)
            while sum(map(len, self._idle.values())) > IDLE_INTEGRATORS:
                oldest = next(iter(self._idle))
                self._idle[oldest].pop()
                if not self._idle[oldest]:
                    del self._idle[oldest]

    def known(self, key: Any, question: Callable[[], Any]) -> Any:
        """Return the answer to a question about equations, asked once."""
        with self._lock:
            if key in self._decided:
                self._decided.move_to_end(key)
                return self._decided[key]
        answer = question()
        with self._lock:
            self._decided[key] = answer
            while len(self._decided) > DECISIONS:
                self._decided.popitem(last=False)
        return answer


_pool = _Pool()


def known(key: Any, question: Callable[[], Any]) -> Any:
    """Return the answer to a question about equations, asked once."""
    return _pool.known(key, question)


def state_vector(problem: Problem, state: State, formulation: Formulation, precision: str) -> StateVector:
    """Return the variables in which a system is integrated: in comoving axes where all its forces allow.

    Extended precision stays in the space axes, as an independent check of the comoving ones.
    """
    smooth, system = problem.between_knots(), problem.system
    if formulation.planar:
        refuse_spatial_motion(system, state)
    # A power of two scales without rounding.
    scale = np.exp2(np.rint(np.log2(SMALL / system.momentum_scale(state))))
    parts, ratios = factors_of_parts(system, state), system.momentum_ratios(state)
    if smooth.orbits and formulation.turns and precision == "double" and len(ratios) == 1:
        comoving = StateVector(formulation, scale, parts, *shared_blocks(smooth.orbits, lambda _: True), comoving=True)
        if set(comoving.views) == {0} and smooth.known(_can_be_comoving, comoving):
            return comoving.sharing(smooth.known(_by_variables))
    orbits, views = shared_blocks(smooth.orbits, lambda orbit: orbit.integrated)
    return StateVector(formulation, scale, parts, orbits, views, ratios=ratios).sharing(smooth.known(_by_variables))


class Kernel:
    """A compiled integrator with its parameters, for one problem in given variables.

    Attributes
    ----------
    engine : the engine's integrator
        Its state and its time are set from outside.
    detection : EventDetection or None
        The user's events.
    variables : StateVector
    scales : Scales
        Those of the momenta: what the engine's state is in.
    limits : dict
        Arguments for the engine.
    watches : bool
        Whether there are zeros to look for.
    """

    def __init__(self, built: _Compiled, problem: Problem, variables: StateVector, precision: str, lanes: int) -> None:
        self.engine, self._discontinuities, self.detection = built.engine, built.discontinuities, built.detection
        self._roots = built.roots
        self._variations, self._first = variables.variations, variables.tangent_vectors.start

        def values(smooth: Problem) -> tuple[Any, ...]:
            with np.errstate(all="ignore"):  # a constant that is not finite stops the run with a sentence
                return built.values((variables.scale, *variables.factors, *smooth.numbers))

        self._values, self._problem, self.variables = values, problem, variables
        self.scales = Scales(problem.system, variables, built.powers, lanes, self.engine.order)
        self._monitors = [part for part in (self.detection, self._discontinuities) if part is not None]
        for part in self._monitors:
            part.scales = self.scales
        self._refused, saltation = dict[int, str](), saltation_of(problem, variables)
        if self._discontinuities is not None:
            self._discontinuities.jump = functools.partial(self._jump, saltation) if saltation else None
        self.limits: dict[str, Any] = {}
        self.watches, self._kind = bool(self._monitors), PRECISIONS[precision]
        self._limited = precision == "double" or self.watches
        self.limit_steps(np.zeros(lanes))

    def begin(self, forwards: bool, members: NDArray[np.int_] = FIRST) -> None:
        """Set the parameters for the time and the state that the engine has, and for members in its lanes.

        The state is in the scale of the variables.
        """
        pars, self._members = self.engine.pars, np.array(members)  # the only record of who is in which lane
        self._refused.clear()
        self.scales.begin(self.engine.state, self._members)
        if self._discontinuities is not None:
            self._discontinuities.begin(self.engine, self._pieces, forwards, self._members)
        else:
            table = self._table[:, members] if pars.ndim > 1 else self._values(self._problem)[: len(pars)]
            pars[: len(table)] = table
            for lane in np.flatnonzero(self.scales.bits).tolist() if self.scales.bits.any() else ():
                own = lane_of(pars, lane)[: len(table)]
                own[:] = self.scales.parameters(own, lane)
        self._roots.begin(self.engine)
        if self.detection is not None:
            self.detection.begin(self.engine, self._problem, self.variables, forwards, self._members)
        if self.engine.with_events:
            self.engine.reset_cooldowns()

    @functools.cached_property
    def _table(self) -> NDArray[np.float64]:
        """The values of the parameters of all members, one column each."""
        values = self._values(self._problem)[: len(self.engine.pars)]
        members = np.broadcast_shapes(self._problem.members, np.shape(self.variables.scale))
        return np.reshape([np.broadcast_to(value, members) for value in values], (len(values), *members))

    @functools.cached_property
    def _pieces(self) -> Pieces:
        return Pieces(self._problem, self._values)

    def limit_steps(self, spans: NDArray[Any], tries: int = 0) -> None:
        """Let no step be too long for the time that a run takes in each lane, the shorter the more tries there were."""
        for part in self._monitors:
            part.spans = spans
        self._longest = np.full(spans.size, LONGEST)
        if self._monitors:
            share = np.maximum(SHARE * SHORTER**tries * spans, np.finfo(float).tiny)  # no step is of length 0
            self._longest = np.minimum(self._longest, np.where(spans > 0, share, LONGEST))
        if self._limited:
            longest = list(self._longest)
            self.limits["max_delta_t"] = longest if len(longest) > 1 else self._kind(longest[0])

    def overlooked(self, lanes: list[int]) -> list[int]:
        """Return the lanes in which a zero of an event or of a condition was lost since this was asked last."""
        if not self._monitors:
            return []
        return [lane for lane in lanes if any(part.overlooked(self.engine, lane) for part in self._monitors)]

    def settle(self, lane: int = 0) -> None:
        """Set the conditions as their functions say: one of them jumped over zero."""
        if self._discontinuities is not None:
            self._discontinuities.switch(self.engine, lane)

    def _jump(
        self, saltation: Saltation, engine: Any, lane: int, near: float, before: NDArray[Any], behind: NDArray[Any]
    ) -> bool:
        """Let tangent vectors jump where conditions have switched, and return whether the motion goes on."""
        if not np.any((before != behind)[saltation.stops]):
            return True
        time, scales = np.ravel(engine.time)[lane : lane + 1], self.scales
        inputs = numbers_around(self._problem, self.variables, self._numbers, time, self._members[lane : lane + 1])
        row = scales.outward(np.array(lane_of(engine.state, lane)), lane)
        numbers = [float(np.ravel(number)[0]) for number in inputs]
        try:
            row[self._first :] = Jump(saltation, row, time[0], numbers, near).across(before, behind)
        except NoDerivative as error:
            self._refused[lane] = str(error)
            return False
        lane_of(engine.state, lane)[:] = scales.inward(row, lane)
        return True

    @functools.cached_property
    def _numbers(self) -> tuple[Any, ...]:
        return numbers_of(self._problem.between_knots(), self.variables)

    def outcome(self, engines: Any, lane: int = 0) -> str:
        """Return how steps ended: the engine's name for it, what the detection says, "switch" or "angles"."""
        if lane in self._refused:
            return self._refused[lane]
        name = OUTCOMES.get(int(engines), "")
        if name == "step_limit" and self.detection is not None and self.detection.stopped[lane]:
            return self.detection.stopped[lane]  # in the last step the engine says nothing of an event
        if name:
            return name
        if int(engines) >= 0:  # an event after which the lane goes on, in the step in which another lane stopped
            return "success"
        if self.detection is not None and self.detection.stopped[lane]:
            return self.detection.stopped[lane]
        discontinuities = len(self._discontinuities.events) if self._discontinuities else 0
        return "switch" if -int(engines) <= discontinuities else "angles"

    def steps_at_a_time(self, most: int, first: bool = False) -> int:
        """Return after how many steps `rescale` is due."""
        if self._variations is None:
            return most
        return STEPS_AT_A_TIME[self._variations.order] // (10 if first else 1)

    def failing(self, lanes: list[int], results: list[Any]) -> bool:
        """Whether a chunk of steps has ended with a state that is not finite in one of some lanes."""
        return NOT_FINITE in [int(results[lane][0]) for lane in lanes]

    def doubtful(self, lanes: list[int], results: list[Any], rows: NDArray[Any]) -> bool:
        """Whether a chunk of steps in some lanes may have begun one with momenta out of the band of their scale.

        `results` are the engine's: how each lane ended, its shortest and its longest step; `rows` are variables on the
        way, shape (n, size, lanes). A chunk that ends with a state that is not finite is taken again up to there.
        """
        if self.failing(lanes, results):
            return True
        looked_at = rows[: -1 : max(len(rows) // SAMPLES, 1)]
        if self.scales.all_fit(self.engine.state, looked_at):
            return False
        return any(self._doubtful(lane, results[lane], looked_at[:, :, lane]) for lane in lanes)

    def _doubtful(self, lane: int, result: Any, rows: NDArray[Any]) -> bool:
        if self.detection is not None and self.detection.stopped[lane] == "act":  # they were within before
            return False
        return (
            not self.scales.fits(self.engine.state, lane)
            or not self.scales.fit(rows, lane)
            or self.scales.doubtful(lane, float(result[1]), float(result[2]))
        )

    def sound_steps(self, ends: NDArray[Any], most: int) -> int:
        """Take steps, up to the one in which momenta leave the band of their scale, and return how many.

        Actions are not taken. The engine is to be brought back by `begin`.
        """
        if self.detection is not None:
            self.detection.rehearsing = True
        count = 0
        while count < most and np.any(ends != self.engine.time):
            outcomes = self._step_towards(ends)
            if NOT_FINITE in map(int, outcomes):
                return max(count, 1)
            count += 1
            if any(map(_stops, outcomes)):
                return count + 1  # at the limit of steps the engine says nothing of an event
            if not all(self.scales.fits(self.engine.state, lane) for lane in range(len(outcomes))):
                return count
        return most

    def _step_towards(self, ends: NDArray[Any]) -> list[Any]:
        """Take one step in each lane, and return how they ended."""
        ahead = ends - self.engine.time
        if self._limited:
            longest = self._longest if np.ndim(ahead) else self.limits["max_delta_t"]
            ahead = np.clip(ahead, -longest, longest)
        if np.ndim(ahead):
            self.engine.step(list(ahead))
            return [result[0] for result in self.engine.step_res]
        return [self.engine.step(ahead)[0]]

    def certain(self, certain: bool) -> None:
        """Say whether the steps to come begin with momenta in the band of their scale: actions wait for that."""
        if self.detection is not None:
            self.detection.certain = certain

    def rescale(self) -> None:
        """Choose the scales anew of momenta that left their band, and those of tangent vectors."""
        self.scales.rescale(self.engine.state, self.engine.pars)
        if self.detection is not None:
            self.detection.go_on()
        if self._variations is not None:
            self._variations.rescale(self.engine.state[self._first :].T)

    def repeat(self, busy: int, idle: NDArray[np.int_]) -> None:
        """Let lanes follow another one."""
        self.engine.pars[:, idle] = self.engine.pars[:, [busy]]
        self._members[idle] = self._members[busy]
        if self._limited:
            self._longest[idle] = self._longest[busy]
            self.limits["max_delta_t"] = list(self._longest)
        self.scales.bits[idle] = self.scales.bits[busy]
        for part in self._monitors:
            part.repeat(busy, idle)


def looped_constants(problem: Problem, variables: StateVector) -> Constants | None:
    """Return the constants of a looped kernel; None if its variables have a singularity."""
    known, key = problem.known(_by_variables), ("constants", variables.structure)
    if key not in known:
        known[key] = _looped_constants(problem, variables)
    constants: Constants | None = known[key]
    return constants


def _by_variables(_: Problem) -> dict[Any, Any]:
    """Return what is found of a structure by its variables, as long as nothing is."""
    return {}


def _looped_constants(problem: Problem, variables: StateVector) -> Constants | None:
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


def updates(problem: Problem, variables: StateVector) -> list[tuple[list[int], Replay, int]]:
    """Return where variables jump, and what gives their new values of variables, time, uniform numbers and inputs."""
    field = _traced(problem, variables)
    return [
        (each.places, Replay(each.values, np.longdouble, [*field.own, *each.draws]), len(each.draws))
        for each in field.updates
    ]


@contextmanager
def kernel_of(
    problem: Problem, variables: StateVector, precision: str, tolerance: float, lanes: int = 1
) -> Iterator[Kernel]:
    """Provide a kernel, which goes back to the pool when it is not needed any more."""
    smooth = problem.between_knots()
    asked = precision, tolerance, lanes, smooth is not problem
    key = smooth.structure, variables.structure, asked  # without any real number of the system
    built = _pool.take(key) or _build(smooth, variables, *asked)
    yield Kernel(built, problem, variables, precision, lanes)
    _pool.give(key, built)


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
    chart, system, variations = variables.formulation, twin.system, variables.variations
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


def _stops(outcome: Any) -> bool:
    """Whether a step ended at an event that stops the engine."""
    return OUTCOMES.get(int(outcome)) not in ("success", "time_limit") and int(outcome) < 0


def available(precision: str) -> bool:
    """Whether this machine's engine has that precision, wider than double unless it is double."""
    kind = PRECISIONS[precision]
    if precision == "extended":
        return bool(np.finfo(np.longdouble).eps < np.finfo(np.float64).eps)
    return kind is not None


def _build(
    problem: Problem, variables: StateVector, precision: str, tolerance: float, lanes: int, with_knots: bool
) -> _Compiled:
    field, kind = _traced(problem, variables), PRECISIONS[precision]
    refuse_constant_events(problem.events, field.events, variables.formulation.name)
    conditions = field.conditions
    watched = [[*conditions.values()], field.events]
    others = [[*functions, *field.along(functions)] for functions in watched]
    near = variables.formulation.nearness(field.own)
    others += [field.counting, [] if near is None else [near]]
    program = lowered(field.rates, [value for each in others for value in each])
    made = Expressions(program.decomposition)
    values = iter(made.of(program.others))
    of_conditions, of_events, counting, nearness = ([next(values) for _ in each] for each in others)
    attitude = [made.rates[place] for place in variables.attitude]
    discontinuities, detection, stops = None, None, {}
    first = len(program.parameters)
    if with_knots or conditions:
        places = [program.conditions[node.place] for node in conditions]
        look = made.compiled([*of_conditions, *attitude], kind)
        discontinuities = Discontinuities(of_conditions[: len(places)], places, look, first, lanes, kind)
        stops["t_events"], first = discontinuities.events, discontinuities.parameters
    if field.events:
        look = made.compiled([*of_events, *counting, *attitude], kind)
        detection = EventDetection(problem.events, of_events[: len(counting)], look, first, lanes, kind)
        stops = {"t_events": [*stops.get("t_events", []), *detection.stops], "nt_events": detection.passed}
        if discontinuities:
            discontinuities.look, detection.settle = detection.look, discontinuities.settle
    if nearness:
        stops["t_events"] = [*stops.get("t_events", []), event_class(lanes, kind)(*nearness)]
    build = hy.taylor_adaptive if lanes == 1 else hy.taylor_adaptive_batch
    many_vectors = variables.variations is not None and variables.variations.total > 1
    engine = build(
        list(zip(made.symbols, made.rates, strict=True)),
        np.full((variables.size, *(lanes,) * (lanes > 1)), kind(0.0)),
        tol=kind(tolerance),
        fp_type=kind,
        compact_mode=many_vectors or program.decomposition.size > LARGE[precision],
        **stops,
    )
    used = [root for root in program.roots if root.parameter < len(engine.pars)]  # the engine needs none of slopes
    roots = Roots([(made.of([root.value])[0], root.parameter) for root in used], made, variables.momenta, kind)
    replay = program.values(_type_of_numbers(precision, lanes, with_knots))
    return _Compiled(engine, replay, program.powers, roots, discontinuities, detection)


def _type_of_numbers(precision: str, lanes: int, with_knots: bool) -> Callable[[Any], Any]:
    """Return what makes the numbers of a run wide enough to compute its parameters."""
    kind: Any = np.longdouble if precision == "double" else PRECISIONS[precision]
    if precision == "quadruple" and with_knots:  # no array of these takes part in sums with other numbers
        one_by_one: Callable[[Any], Any] = np.frompyfunc(kind, 1, 1)
        return one_by_one
    scalar: Callable[[Any], Any] = kind
    return scalar if lanes == 1 and not with_knots else functools.partial(np.asarray, dtype=kind)
