"""Kernel of a run and the values of its parameters: numbers of the system, at knots of tables and at the start."""

from __future__ import annotations

import contextvars
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.integration import equations
from poinsot.integration.problem import Problem
from poinsot.integration.saltation import Saltation
from poinsot.integration.state_vector import StateVector
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Evaluator, Number, wide
from poinsot.taylor.lowering import Program, StartRoots
from poinsot.taylor.memory import Layout
from poinsot.taylor.queue import Kernel

__all__ = ["KernelKind", "KernelParameters", "PreparedKernel"]

NEGLIGIBLE = {False: 1e-9, True: 1e-18}
"""Part of the size of a square root that is negligible when squared, in double and in quadruple precision."""

EVERY = slice(None)

QUIET = contextvars.Context()
"""Context in which numpy does not warn of constants that are not finite; such constants stop the run with a message.

Entering a copy of it takes a tenth of the time of `np.errstate`.
"""

QUIET.run(np.seterr, all="ignore")

Array = NDArray[np.float64]
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
        self._kind, self._smooth = kind, equations.between_first_knots(problem)
        self.torque_scale = np.asarray(variables.torque_scale * variables.scale)
        self._constants = equations.constants(self._smooth, variables)
        self._inputs = equations.inputs(self._smooth, variables)
        self._kernel = QUIET.copy().run(self._prepared)
        self.code, self.held = self._kernel.code, self._kernel.roots.places

    def _prepared(self) -> PreparedKernel:
        """Find or compile the kernel for the constants that are zero, and set the table of parameters.

        The kernel of the last run evaluates the constants together with its parameters, and is usually the one wanted.
        """
        constants, kind = self._constants, self._kind
        last, last_zeros = constants.latest.get(kind, (None, ()))
        kernel: PreparedKernel | None = last and last()
        values = _values(kernel.values if kernel else constants.values, self._inputs)
        zeros = () if constants.jumps or self.problem.knots.size else constants.zeros(values, self._inputs)
        if kernel is None or zeros != last_zeros:
            kernel = equations.known((constants, zeros, kind), lambda: self._made(zeros))
            constants.latest[kind] = weakref.ref(kernel), zeros
            values = _values(kernel.values, self._inputs)
        self.table = self._table(kernel, values, self._inputs)
        return kernel

    def _made(self, zeros: tuple[int, ...]) -> PreparedKernel:
        program = equations.program(self._smooth, self.variables, zeros)
        formulas, code = program.formulas, self._kind.compiler(program, self._kind)
        values = WideEvaluator(formulas) if self._kind.wide else Evaluator(formulas, wide)
        return PreparedKernel(code, values, StartRoots(program, self.variables.size))

    def _table(self, kernel: PreparedKernel, values: Values, inputs: Values, members: Members | slice = EVERY) -> Array:
        """Return the parameters of members, shape (n, parameters): the values behind the constants."""
        first, origins = self._constants.count, self.origins[members]
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
        around = equations.inputs(self.problem.between_knots(times), self.variables)
        pairs = zip(around, self._inputs, strict=True)
        return [x[members] if isinstance(x, np.ndarray) and np.ndim(y) else x for x, y in pairs]

    def around(self, times: Array, members: Members) -> Array:
        """Return the parameters of members between the knots around times, shape (n, parameters)."""
        inputs = self.inputs_around(times, members)
        with np.errstate(all="ignore"):
            return self._table(self._kernel, _values(self._kernel.values, inputs), inputs, members)

    @property
    def counting(self) -> Evaluator:
        """Evaluator of the conditions of events, for variables, time and inputs: a zero counts where it is positive."""
        return equations.counting(self._smooth, self.variables)

    @property
    def saltation(self) -> Saltation | None:
        """Jumps of tangent vectors at switches of formulas."""
        return equations.saltation_of(self._smooth, self.variables)


def _values(evaluator: Evaluator | WideEvaluator, inputs: Values) -> Values:
    values = evaluator(inputs)
    return values if np.ndarray in map(type, inputs) else [*map(float, values)]
