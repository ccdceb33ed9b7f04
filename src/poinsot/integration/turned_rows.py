"""Products of quaternions along rows, in place: by machine code for many rows."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Module, Value
from poinsot.taylor.llvm_ir import Array as Memory
from poinsot.taylor.object_cache import function_of

Reals = NDArray[np.floating]

__all__ = ["MIN_COMPILED_ROWS", "turn_rows"]

MIN_COMPILED_ROWS = 8192
"""Number of rows above which machine code multiplies them: 7 ms to compile, then a sixth of the time of NumPy."""


def turn_rows(turns: Reals, rows: Reals) -> None:
    """Replace quaternions q by the products p q, in place; shapes (..., 4), or shapes that NumPy broadcasts."""
    if rows.shape == turns.shape and rows.size >= 4 * MIN_COMPILED_ROWS and rows.dtype == turns.dtype == np.float64:
        each, flat = np.ascontiguousarray(turns), rows.reshape(-1, 4)
        if flat.strides[1] == flat.itemsize and np.may_share_memory(flat, rows):
            _compiled()(len(flat), flat.strides[0] // flat.itemsize, each.ctypes.data, flat.ctypes.data)
            return
    turned = quat.hamilton(*map(_components, (turns, rows)))
    for place, component in enumerate(turned):
        rows[..., place] = np.asarray(component)


def _components(array: Reals) -> Sequence[Scalar]:
    """Return the components of one quaternion as floats, which are faster than arrays, or the columns of rows."""
    return array.tolist() if array.ndim == 1 else quat.components(array)


@functools.cache
def _compiled() -> Callable[..., int]:
    """Return the product as machine code, with the same bits; an argument is the distance of rows in numbers."""

    def body(count: Value, apart: Value, turns: Value, rows: Value) -> None:
        def turn(row: Value) -> None:
            places = Memory(turns, DOUBLE).at(row * 4), Memory(rows, DOUBLE).at(row * apart)
            p, q = (Memory(place, DOUBLE) for place in places)
            product = quat.product(*(Vector(each[i] for i in range(4)) for each in (p, q)))
            for i, component in enumerate(product):
                q[i] = component

        count.function.count(count, turn)

    module = Module()
    module.function("turn", "void", [INTEGER, INTEGER, POINTER, POINTER], body)
    return function_of(module, "turn")
