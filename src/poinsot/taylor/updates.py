"""New values that variables get at samples: formulas that a kernel evaluates between two steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from poinsot.taylor.graph import Node

__all__ = ["Jumps", "Update"]


class Update(NamedTuple):
    """The new values of some variables, at their places, and the symbols of the uniform numbers drawn for them."""

    places: list[int]
    values: list[Any]
    draws: list[Node]


@dataclass(frozen=True, eq=False)
class Jumps:
    """The formulas of all updates, in the order in which they are done at one time.

    Parameters
    ----------
    own : list of Node
        The variables and, behind them, the time.
    updates : list of Update
    constants : list of Node
        What they need that is the same all the way: parameters of a kernel, the first of them number `first`.
    first : int
    """

    own: list[Node]
    updates: list[Update]
    constants: list[Node]
    first: int
