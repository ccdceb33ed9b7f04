"""Kernel of a run and the values of its parameters: numbers of the system, at knots of tables and at the start."""

from __future__ import annotations

import contextvars
import weakref
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.integration import equations
from poinsot.integration.equations import Equations
from poinsot.integration.problem import Problem
from poinsot.integration.saltation import Saltation
from poinsot.integration.state_vector import StateVector
from poinsot.mechanics.event import Event
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.taylor.decomposition import Crossing, Momenta
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Evaluator, GraphScalar, Node, Number, wide
from poinsot.taylor.lowering import Constants, Program, StartRoots, simplified
from poinsot.taylor.memory import Layout
from poinsot.taylor.queue import Kernel
from poinsot.taylor.rescaling import powers_of

__all__ = ["KernelFormulas", "KernelKind", "KernelParameters", "PreparedKernel", "formulas_of", "program"]

NEGLIGIBLE = {False: 1e-9, True: 1e-18}
"""Part of the size of a square root that is negligible when squared, in double and in quadruple precision."""

EVERY = slice(None)

QUIET = contextvars.Context()
"""Context in which numpy does not warn of constants that are not finite; such constants stop the run with a message.

Entering a copy of it takes a tenth of the time of `np.errstate`.
"""

QUIET.run(np.seterr, all="ignore")

Members = NDArray[np.int_]
Values = Sequence[Number]
"""Values of formulas: a list of floats if all inputs are scalars, otherwise a tuple that contains arrays (members,)."""

Compiler = Callable[[Program, "KernelKind"], Kernel]


class KernelKind(NamedTuple):
    """Properties of a kernel in addition to its equations."""

    order: int
    layout: Layout
    lanes: int
    wide: bool
    compiler: Compiler


@dataclass(frozen=True, slots=True, weakref_slot=True)
class PreparedKernel:
    """A compiled kernel, the evaluator of its constants and parameters, and the square roots that depend on starts."""

    code: Kernel
    values: Evaluator | WideEvaluator
    roots: StartRoots


@dataclass(eq=False)
class KernelFormulas:
    """Formulas of the kernels of all problems of one structure in variables of one structure.

    Attributes
    ----------
    constants : Constants
    counting : Evaluator
        Conditions of events for variables, time and inputs. A zero of an event counts where its condition is positive.
    saltation : Saltation or None
        Jumps of tangent vectors at switches of formulas; None if they do not jump.
    traced : Equations or None
        Traced equations, stored until the first program is made of them.
    latest : dict
        Weak reference to the kernel of the last run of a kind, and the constants that were zero in it.
    """

    constants: Constants
    counting: Evaluator
    saltation: Saltation | None
    traced: Equations | None
    latest: dict[KernelKind, tuple[weakref.ref[PreparedKernel], tuple[int, ...]]] = field(default_factory=dict)


def formulas_of(problem: Problem, variables: StateVector) -> KernelFormulas:
    """Return the formulas of the kernels of a problem without knots, traced once for each structure."""
    stored, key = problem.alike.by_variables, ("formulas", variables.structure)
    if key not in stored:
        traced = equations.traced_equations(problem, variables)
        _refuse_constant_events(problem.events, traced.events, variables.formulation.name)
        constants = Constants([*traced.rates, *traced.events])
        counting = Evaluator(traced.counting, np.float64, traced.own)
        stored[key] = KernelFormulas(constants, counting, traced.saltation, traced)
    found: KernelFormulas = stored[key]
    return found


def program(problem: Problem, variables: StateVector, zeros: Iterable[int] = ()) -> Program:
    """Return the program for runs in which some of the constants are zero."""
    formulas = formulas_of(problem, variables)
    traced, formulas.traced = formulas.traced or equations.traced_equations(problem, variables), None
    made = simplified(traced.rates, zeros, traced.events).with_jumps(traced.own, traced.updates)
    crossings = [Crossing(event.direction, event.terminal or event.acts) for event in problem.events]
    singular = [Crossing(0, True)] * (len(traced.events) - len(crossings))
    places = np.arange(variables.size)[variables.momenta].tolist()
    conjugates = tuple((q.start, Q.start) for q, Q in variables.conjugates)
    decomposition = replace(
        made.decomposition,
        events=(*crossings, *singular),
        stops=tuple(traced.saltation.stops if traced.saltation else ()),
        attitude=tuple(variables.attitude),
        momenta=Momenta(tuple(places), tuple(variables.scaled), powers_of(made.parameters), conjugates),
    )
    return replace(made, decomposition=decomposition)


class KernelParameters:
    """Kernel of a run, which depends on which constants are zero, and the values of its parameters for all members.

    Parameters
    ----------
    problem : Problem
    variables : StateVector
    starts : array (members, size)
        Variables at the start.
    origins : array (members,)
        Times of the start.
    kind : KernelKind

    Attributes
    ----------
    problem, variables, starts, origins
        The arguments.
    formulas : KernelFormulas
    code : Kernel
        The compiled kernel.
    table : array (members, parameters)
        Parameters at the start, between the first two knots of tables.
    held : list of int
        Parameters that keep their values at knots: square roots of zero at the start.
    torque_scale : array () or (members,)
        Momenta that forces give a body at rest, in the scale of the variables.
    """

    code: Kernel
    table: Array

    def __init__(
        self, problem: Problem, variables: StateVector, starts: Array, origins: Array, kind: KernelKind
    ) -> None:
        self.problem, self.variables, self.starts, self.origins = problem, variables, starts, origins
        self._kind, self._smooth = kind, problem.smooth
        self.torque_scale = np.asarray(variables.torque_scale * variables.scale)
        self.formulas = formulas_of(self._smooth, variables)
        self._inputs = _inputs(self._smooth, variables)
        self._kernel = QUIET.copy().run(self._prepared)
        self.code, self.held = self._kernel.code, self._kernel.roots.places

    def _prepared(self) -> PreparedKernel:
        """Find or compile the kernel for the constants that are zero, and set the table of parameters.

        The kernel of the last run evaluates the constants together with its parameters, and is usually the one wanted.
        """
        formulas, kind = self.formulas, self._kind
        last, last_zeros = formulas.latest.get(kind, (None, ()))
        kernel = last() if last else None
        values = _values(kernel.values if kernel else formulas.constants.values, self._inputs)
        may_be_zero = formulas.saltation is None and not self.problem.knots.size
        zeros = formulas.constants.zeros(values, self._inputs) if may_be_zero else ()
        if kernel is None or zeros != last_zeros:
            kernel = equations.known((formulas, zeros, kind), lambda: self._made(zeros))
            formulas.latest[kind] = weakref.ref(kernel), zeros
            values = _values(kernel.values, self._inputs)
        self.table = self._table(kernel, values, self._inputs)
        return kernel

    def _made(self, zeros: tuple[int, ...]) -> PreparedKernel:
        made = program(self._smooth, self.variables, zeros)
        formulas, code = made.formulas, self._kind.compiler(made, self._kind)
        values = WideEvaluator(formulas) if self._kind.wide else Evaluator(formulas, wide)
        return PreparedKernel(code, values, StartRoots(made, self.variables.size))

    def _table(self, kernel: PreparedKernel, values: Values, inputs: Values, members: Members | slice = EVERY) -> Array:
        """Return the parameters of members, shape (n, parameters): the values behind the constants."""
        first, origins = self.formulas.constants.count, self.origins[members]
        columns = values[first:]
        if self._kind.wide:  # the high parts of all values, then the low parts
            half = len(values) // 2
            columns = [*values[first:half], *values[half + first :]]
        table = np.empty((origins.size, len(columns)))
        if isinstance(values, list):
            table[:] = columns
        else:
            for place, column in enumerate(columns):
                table[:, place] = column
        if kernel.roots.places:
            given = self.starts[members], origins, self.variables.momenta, NEGLIGIBLE[self._kind.wide]
            kernel.roots.set(table, inputs, *given)
        return table

    def inputs_around(self, times: Array, members: Members) -> Values:
        """Return the inputs of the equations for members, between the knots around times."""
        around = _inputs(self.problem.between_knots(times), self.variables)
        pairs = zip(around, self._inputs, strict=True)
        return [x[members] if isinstance(x, np.ndarray) and np.ndim(y) else x for x, y in pairs]

    def around(self, times: Array, members: Members) -> Array:
        """Return the parameters of members between the knots around times, shape (n, parameters)."""
        inputs = self.inputs_around(times, members)
        with np.errstate(all="ignore"):
            return self._table(self._kernel, _values(self._kernel.values, inputs), inputs, members)


def _values(evaluator: Evaluator | WideEvaluator, inputs: Values) -> Values:
    values = evaluator(inputs)
    return values if np.ndarray in map(type, inputs) else [*map(float, values)]


def _inputs(problem: Problem, variables: StateVector) -> tuple[Number, ...]:
    """Return the inputs of a run: the scale of the momenta, factors of variables, and the numbers of the problem."""
    return variables.scale, *variables.factors, *problem.numbers


def _refuse_constant_events(events: Sequence[Event], values: Sequence[GraphScalar], formulation: str) -> None:
    """Raise a ValueError if the value of an event, a scalar of a kernel, is constant along the motion."""
    for event, value in zip(events, values, strict=False):
        if not (isinstance(value, Node) and value.varies):
            raise ValueError(
                f"the value of {type(event).__name__} must depend on the motion, but it is constant in the variables "
                f"of {quoted(formulation)}."
            )
