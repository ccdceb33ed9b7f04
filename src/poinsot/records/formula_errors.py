"""Errors of a user's formulas: functions of other packages, and attributes that do not exist."""

from __future__ import annotations

import dis
import functools
from collections.abc import Callable
from types import FunctionType, ModuleType, TracebackType
from typing import Any

from poinsot import functions as formulas
from poinsot.printable import kind_of, message_of, quoted, shortened
from poinsot.subclasses import is_own
from poinsot.suggestions import advice_on_attribute, holder_of

__all__ = ["FormulaError", "explain_formulas", "use_functions"]

RENAMED = {
    **{"absolute": "abs", "fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
    **{"fmin": "minimum", "fmax": "maximum", "hypot": "norm", "vdot": "dot", "inner": "dot"},
}
FOREIGN = ("math", "numpy")

ON_OTHER_SCALARS = ("Node", "arrays can be converted")
"""Parts of the messages of functions that compute with numbers alone, called with symbols or with arrays."""


class FormulaError(TypeError):
    """The error of a formula of the user's own, which names the formula and its fault."""


def explain_formulas(cls: type) -> None:
    """Let the formulas of a class of the user's own, those that a base class of the package declares, name themselves.

    A formula that uses an attribute that does not exist, or calls a function of another package with symbols or
    arrays, raises a `FormulaError`.
    """
    if is_own(cls):
        return
    declared = {name for base in cls.__mro__ if is_own(base) for name in vars(base) if not name.startswith("_")}
    for name in declared & vars(cls).keys():
        if isinstance(formula := vars(cls)[name], FunctionType):
            setattr(cls, name, _explained(formula))


def _explained(formula: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(formula)
    def explained(record: Any, *arguments: Any, **named: Any) -> Any:
        try:
            return formula(record, *arguments, **named)
        except AttributeError as error:
            if holder_of(error) is None or error.name is None:
                raise
            raise FormulaError(_missing(_name(record, formula), error)) from error
        except FormulaError:
            raise
        except TypeError as error:
            if not any(part in str(error) for part in ON_OTHER_SCALARS) or _foreign_call(error.__traceback__) is None:
                raise
            raise FormulaError(use_functions(_name(record, formula), error)) from error

    return explained


def _name(record: Any, formula: Callable[..., Any]) -> str:
    return f"{kind_of(record)}.{formula.__name__}"


def _missing(formula: str, error: AttributeError) -> str:
    """Return the message about an attribute that does not exist, with the nearest one that does."""
    thing, name = holder_of(error), str(error.name)
    owner = thing.__name__ if isinstance(thing, ModuleType) else kind_of(thing)
    hint = advice_on_attribute(thing, name)
    return f"{formula} must use attributes that exist, got {quoted(name)} of {owner}.{hint}"


def use_functions(formula: str, error: Exception) -> str:
    """Return the message about a formula that raised an error on arrays or on symbols."""
    rule = f"{formula} must use + - * / ** and poinsot.functions alone"
    called = _foreign_call(error.__traceback__)
    if called is None:
        why = shortened(message_of(error)).rstrip(".")
        return f"{rule}, but it raised {kind_of(error)}: {why}. Replace functions of math and numpy by those there."
    name = called.__name__
    own = RENAMED.get(name, name)
    hint = f"Write poinsot.functions.{own}." if own in formulas.__all__ else f"These are {', '.join(NAMES)}."
    return f"{rule}, got {called.__module__}.{name}. {hint}"


NAMES = [name for name in formulas.__all__ if callable(getattr(formulas, name)) and name != "Vector"]


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
