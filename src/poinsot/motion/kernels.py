"""Compiled kernels: the only place that builds an integrator.

A kernel belongs to the structure of a system; every real number is a runtime parameter, so that new values
compile nothing. Idle integrators wait in one bounded, thread-safe pool, the package's only global state.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from poinsot import functions
from poinsot.mechanics.axes import Axes, TrackingAxes
from poinsot.mechanics.euler import SINGULAR_SINE
from poinsot.mechanics.formulations import FORMULATIONS, EulerAngles
from poinsot.mechanics.state import State
from poinsot.mechanics.system import USE_FUNCTIONS, System
from poinsot.motion.constants import Constants
from poinsot.motion.coordinates import SMALL, Coordinates

PRECISIONS: dict[str, Any] = {
    "double": np.float64,
    "extended": np.longdouble,
    "quadruple": getattr(hy, "real128", None),
}
LANES = hy.recommended_simd_size()
IDLE_INTEGRATORS = 64
DECISIONS = 1024
LARGE = 400
"""Operations of a step above which the compiler would take many seconds: a system this large runs in the
engine's compact mode, which compiles in less than one and takes up to twice as long a step."""

MANY_TERMS = 5000
"""Terms in the equations, repeated ones counted again, below which a system is not large."""


@dataclass(frozen=True)
class Kernel:
    """What an integrator is built for: hashable, without any real number of the system but the tolerance."""

    structure: tuple[Any, ...]
    formulation: str
    precision: str
    tolerance: float
    lanes: int


class _Pool:
    """Idle integrators by kernel, the least recently used dropped first."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: OrderedDict[Kernel, list[Any]] = OrderedDict()
        self._decided: OrderedDict[Any, bool] = OrderedDict()

    def take(self, kernel: Kernel) -> Any | None:
        with self._lock:
            idle = self._idle.get(kernel)
            return idle.pop() if idle else None

    def give(self, kernel: Kernel, integrator: Any) -> None:
        with self._lock:
            self._idle.setdefault(kernel, []).append(integrator)
            self._idle.move_to_end(kernel)
            while sum(map(len, self._idle.values())) > IDLE_INTEGRATORS:
                oldest = next(iter(self._idle))
                self._idle[oldest].pop()
                if not self._idle[oldest]:
                    del self._idle[oldest]

    def decide(self, key: Any, question: Callable[[], bool]) -> bool:
        """Return the answer to a question about equations, asked once."""
        with self._lock:
            known = self._decided.get(key)
        if known is None:
            known = question()
            with self._lock:
                self._decided[key] = known
                while len(self._decided) > DECISIONS:
                    self._decided.popitem(last=False)
        return known


_pool = _Pool()


def coordinates(system: System, state: State, formulation: str, precision: str) -> Coordinates:
    """Return the variables in which a system is integrated: carried by its orbit where all its forces allow.

    Wide precision stays in the space axes, so that it judges the carried ones.
    """
    chosen = FORMULATIONS[formulation]
    axes: Axes = system.space_axes
    carried = None if isinstance(chosen, EulerAngles) or precision != "double" else system.common_axes
    if carried is not None and _pool.decide(system.structure, lambda: _can_be_carried(system, carried)):
        axes = carried
    # A power of two scales without rounding.
    return Coordinates(chosen, axes, np.exp2(np.round(np.log2(SMALL / system.momentum_scale(state)))))


@contextmanager
def integrator(
    system: System, variables: Coordinates, precision: str, tolerance: float, lanes: int = 1
) -> Iterator[tuple[Any, Callable[[], list[Any]]]]:
    """Lend an integrator and the values of its parameters; those, state and time are the borrower's to set."""
    structure = (*system.structure, *variables.axes.structure)
    kernel = Kernel(structure, variables.formulation.name, precision, tolerance, lanes)
    built, constants = lent = _pool.take(kernel) or _build(system, variables, kernel)

    def values() -> list[Any]:
        kind: Any = np.longdouble if precision == "double" else PRECISIONS[precision]
        numbers = (variables.scale, *variables.axes.numbers, *system.numbers)
        numbers = tuple(map(kind, numbers)) if lanes == 1 else tuple(np.asarray(number, kind) for number in numbers)
        return constants.values(numbers)[: len(built.pars)]  # the last ones may be unused

    yield built, values
    _pool.give(kernel, lent)


def _can_be_carried(system: System, axes: Axes) -> bool:
    """Whether no force looks at the space axes themselves: a matter of its formula, whatever the numbers."""
    variables = Coordinates(FORMULATIONS["lie_poisson"], axes, 1.0)
    try:
        _equations(system, variables, [hy.expression(f"x{i}") for i in range(variables.size)], Constants())
    except functions.NotCarried:
        return False
    return True


def _equations(system: System, variables: Coordinates, symbols: list[Any], constants: Constants) -> list[Any]:
    inputs = constants.inputs()
    scale, axes = next(inputs), variables.axes.with_numbers(inputs)
    twin = system.with_numbers(inputs)
    if isinstance(axes, TrackingAxes):  # of the twin's own orbits, for its formulas name those
        axes = twin.space_axes
    own, time = [constants.variable(symbol) for symbol in symbols], constants.variable(hy.time)
    try:
        rates = twin.derivatives(variables.formulation.name, own, time, scale=scale, axes=axes)
        return [hy.expression(0.0) + constants.expression(rate) for rate in rates]
    except TypeError as error:
        raise TypeError(f"the formulas of a system {USE_FUNCTIONS.format('on symbols they', error)}") from error


def available(precision: str) -> bool:
    """Whether this machine's engine has that precision, wider than double unless it is double."""
    kind = PRECISIONS[precision]
    if precision == "extended":
        return bool(np.finfo(np.longdouble).eps < np.finfo(np.float64).eps)
    return kind is not None


def _build(system: System, variables: Coordinates, kernel: Kernel) -> tuple[Any, Constants]:
    symbols = [hy.expression(f"x{i}") for i in range(variables.size)]
    constants = Constants()
    equations = _equations(system, variables, symbols, constants)
    kind: Any = PRECISIONS[kernel.precision]
    stops = {}
    if kernel.formulation == "euler_angles":
        nearness = hy.sin(symbols[1]) ** 2 - SINGULAR_SINE**2
        stops["t_events"] = [_terminal(kernel)(nearness)]
    build = hy.taylor_adaptive if kernel.lanes == 1 else hy.taylor_adaptive_batch
    zeros = np.full((variables.size, *(kernel.lanes,) * (kernel.lanes > 1)), kind(0.0))

    def compiled(compact: bool) -> Any:
        return build(
            list(zip(symbols, equations, strict=True)),
            zeros,
            tol=kind(kernel.tolerance),
            fp_type=kind,
            compact_mode=compact,
            **stops,
        )

    if sum(map(len, equations)) > MANY_TERMS:
        built = compiled(compact=True)
        if len(built.decomposition) > LARGE:
            return built, constants
    return compiled(compact=False), constants


def _terminal(kernel: Kernel) -> Any:
    if kernel.lanes > 1:
        return hy.t_event_batch_dbl
    return {"double": hy.t_event_dbl, "extended": hy.t_event_ldbl, "quadruple": getattr(hy, "t_event_f128", None)}[
        kernel.precision
    ]
