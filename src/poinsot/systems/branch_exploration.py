"""Conditions in traced formulas: samples take every branch, whatever the times and orbits are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from poinsot.taylor.graph import Graph, Node, ordered

__all__ = ["BRANCH_SAMPLES", "conditions", "on_branches"]

BRANCH_SAMPLES = 16
"""Number of samples, enough for all branches of four conditions."""


def conditions(outputs: Sequence[Any]) -> list[Node]:
    """Return the conditions in traced formulas that depend on what varies."""
    return [node for node in ordered(outputs) if node.name == "less" and node.varies]


def on_branches(graph: Graph, outputs: Sequence[Any], count: int = BRANCH_SAMPLES, other: bool = False) -> list[Any]:
    """Return the values of outputs where sixteen of the samples go all ways of four conditions, or the other ways."""
    samples = np.arange(count)
    ways = {node: (samples >> i % 4 & 1).astype(bool) != other for i, node in enumerate(conditions(outputs))}
    with np.errstate(all="ignore"):  # a branch that is not taken may be outside its range there
        return graph.evaluated(outputs, ways)
