"""Compiled kernels: the only place that builds an integrator.

A kernel belongs to the structure of a system; every real number is a runtime parameter, so that new values
compile nothing. Idle integrators wait in one bounded, thread-safe pool, the package's only global state.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from poinsot.mechanics.euler import SINGULAR_SINE
from poinsot.mechanics.formulations import FORMULATIONS
from poinsot.mechanics.system import System

PRECISIONS: dict[str, Any] = {
    "double": np.float64,
    "extended": np.longdouble,
    "quadruple": getattr(hy, "real128", None),
}
IDLE_INTEGRATORS = 64


@dataclass(frozen=True)
class Kernel:
    """What an integrator is built for: hashable, without any real number of the system but the tolerance."""

    structure: tuple[Any, ...]
    formulation: str
    precision: str
    tolerance: float


class _Pool:
    """Idle integrators by kernel, the least recently used dropped first."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: OrderedDict[Kernel, list[Any]] = OrderedDict()

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


_pool = _Pool()


@contextmanager
def integrator(system: System, formulation: str, precision: str, tolerance: float) -> Iterator[Any]:
    """Lend an integrator for the system, its parameters set; state and time are the borrower's to set."""
    kernel = Kernel(system.structure, formulation, precision, tolerance)
    built = _pool.take(kernel) or _build(system, kernel)
    built.pars[:] = [PRECISIONS[precision](number) for number in system.numbers]
    yield built
    _pool.give(kernel, built)


def available(precision: str) -> bool:
    """Whether this machine's engine has that precision, wider than double unless it is double."""
    kind = PRECISIONS[precision]
    if precision == "extended":
        return bool(np.finfo(np.longdouble).eps < np.finfo(np.float64).eps)
    return kind is not None


def _build(system: System, kernel: Kernel) -> Any:
    symbolic = system.with_numbers(hy.par[i] for i in range(len(list(system.numbers))))
    formulation = FORMULATIONS[kernel.formulation]
    variables = [hy.expression(f"x{i}") for i in range(formulation.size)]
    try:
        equations = symbolic.derivatives(kernel.formulation, variables, hy.time)
    except TypeError as error:
        raise TypeError(
            "the formulas of a system must use + - * / ** and poinsot.functions alone, but on symbols they gave: "
            f"{error}. Replace functions of math and numpy by those of poinsot.functions."
        ) from error
    kind: Any = PRECISIONS[kernel.precision]
    stops = {}
    if kernel.formulation == "euler_angles":
        nearness = hy.sin(variables[1]) ** 2 - SINGULAR_SINE**2
        stops["t_events"] = [_terminal(kernel.precision)(nearness)]
    return hy.taylor_adaptive(
        [(x, hy.expression(0.0) + rate) for x, rate in zip(variables, equations, strict=True)],
        [kind(0.0)] * formulation.size,
        pars=[kind(0.0)] * max(len(list(system.numbers)), 1),
        tol=kind(kernel.tolerance),
        fp_type=kind,
        **stops,
    )


def _terminal(precision: str) -> Any:
    return {
        "double": hy.t_event_dbl,
        "extended": hy.t_event_ldbl,
        "quadruple": getattr(hy, "t_event_f128", None),
    }[precision]
