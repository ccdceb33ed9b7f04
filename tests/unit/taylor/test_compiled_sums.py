"""Compiled sums of formulas over tables."""

from typing import Any

import numpy as np
import pytest

from poinsot import functions
from poinsot.taylor.compiled_sums import CompiledSums
from poinsot.taylor.graph import Graph


@pytest.mark.parametrize("rows", [0, 1, 7, 8, 19])
def test_sums_are_sums_of_numpy(rows):
    """Sums of up to 19 terms are exact to 19 roundings of their largest terms."""
    graph = Graph()
    x, y, a, b = (graph.symbol(name) for name in "xyab")
    light: Any = x * a + y * b
    outputs = [light / (1 + x), functions.sqrt(light) * (a * b - 1), 2.0]
    sums = CompiledSums(outputs, functions.less(0.0, light), [x, y], [a, b])
    generator = np.random.default_rng(1)
    columns, inputs = generator.uniform(0.1, 1.0, (2, rows)), generator.normal(size=(2, 40))
    found = sums(CompiledSums.table(columns), inputs)
    light = columns.T @ inputs
    with np.errstate(invalid="ignore"):
        terms = [light / (1 + columns[0][:, None]), np.sqrt(light) * (inputs[0] * inputs[1] - 1), 2.0 + 0 * light]
    expected = [np.where(light > 0, term, 0.0).sum(axis=0) for term in terms]
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-14)
