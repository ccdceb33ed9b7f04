"""What is said where a formula calls functions of other packages."""

from __future__ import annotations

import dis
import functools
from types import TracebackType
from typing import Any

from poinsot import functions as formulas
from poinsot.printable import message_of

__all__ = ["use_functions"]

RENAMED = {"absolute": "abs", "fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"}
FOREIGN = ("math", "numpy")


def use_functions(formula: str, scalars: str, error: Exception) -> str:
    """Return the sentence about a formula that raised an error on scalars of a kind."""
    rule = f"{formula} must use + - * / ** and poinsot.functions alone"
    called = _foreign_call(error.__traceback__)
    if called is None:
        why = message_of(error).rstrip(".")
        return f"{rule}, but on {scalars} it gave: {why}. Replace functions of math and numpy by those there."
    name = called.__name__
    own = RENAMED.get(name, name)
    hint = f"Write poinsot.functions.{own}." if own in formulas.__all__ else "That has none of this name."
    return f"{rule}, got {called.__module__}.{name} of {scalars}. {hint}"


def _foreign_call(trace: TracebackType | None) -> Any:
    """Return the function of math or numpy that the innermost frame outside these called; None if there is none."""
    called = None
    while trace is not None:
        frame = trace.tb_frame
        if frame.f_globals.get("__name__", "").partition(".")[0] not in (*FOREIGN, "poinsot"):
            called = _called(trace)
        trace = trace.tb_next
    return called if (getattr(called, "__module__", None) or "").partition(".")[0] in FOREIGN else None


def _called(trace: TracebackType) -> Any:
    """Return what the instruction at which a frame stands calls by a name such as `np.linalg.norm`; None for others."""
    code = trace.tb_frame.f_code
    line, _, column, _ = list(code.co_positions())[trace.tb_lasti // 2]
    names = [
        each.argval
        for each in dis.get_instructions(code)
        if each.opname.startswith("LOAD_") and each.positions and (line, column) == each.positions[::2]
    ]
    if line is None or column is None or not all(isinstance(name, str) for name in names):
        return None
    first, *rest = names or [""]
    known = {**trace.tb_frame.f_globals, **trace.tb_frame.f_locals}
    return functools.reduce(lambda thing, name: getattr(thing, name, None), rest, known.get(first))
