"""Kernels: compiled Taylor integrators of decompositions, which fit the instruction cache.

The whole run is compiled: steps with a loop over the orders, rows at given times, and members that take one another's
lanes. Both layouts, in vectors of any length, give the same bits.
"""

from __future__ import annotations

import functools
import math

from poinsot.taylor.decomposition import Decomposition
from poinsot.taylor.kernel_program import KernelProgram
from poinsot.taylor.layouts import Layout
from poinsot.taylor.object_cache import function_of
from poinsot.taylor.queue import Kernel

__all__ = ["ROUNDING", "Code", "compiled", "order_of"]

ROUNDING = {"double": 2.0**-52, "quadruple": 2.0**-104}
"""Distance from 1 to the next number, by precision: the smallest tolerance."""

MAX_KERNELS = 128
"""The most kernels in the cache."""

BUDGET, SMALL_SYSTEM = 20_000, 25
"""Steps between checks for Ctrl-C, hundredths of a second, in a system of so many inner sums; in larger ones fewer."""


class Code(Kernel):
    """A kernel as machine code of the processor."""

    def __init__(self, program: KernelProgram) -> None:
        super().__init__(program)
        self.budget = max(BUDGET * SMALL_SYSTEM // max(program.sums, SMALL_SYSTEM), 1)
        self.advance = function_of(program.module, "advance")


@functools.lru_cache(MAX_KERNELS)
def order_of(tolerance: float, wide: bool = False) -> int:
    """Return the order of the Taylor polynomials for a tolerance (Jorba and Zou 2005), in quadruple precision 4 more.

    At order 38, of the smallest tolerance there, truncation errors of a free body are three times its rounding errors.
    """
    return max(2, math.ceil(1.0 - 0.5 * math.log(tolerance))) + 4 * wide


@functools.lru_cache(MAX_KERNELS)
def compiled(
    decomposition: Decomposition, order: int, lanes: int, layout: Layout = "batch", wide: bool = False
) -> Code:
    """Return the kernel of a decomposition with polynomials of an order; lanes, of the layout "batch", 1, 2, 4 or 8."""
    return Code(KernelProgram(decomposition, order, lanes, layout, wide))
