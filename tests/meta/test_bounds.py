"""Comparisons say the whole of their bound."""

import ast
from pathlib import Path

import numpy as np

import margins
import poinsot as pt
from poinsot.integration.state_vector import StateVector

TESTS = Path(__file__).parents[1]
SAID = {"assert_allclose": {"rtol"}, "allclose": {"rtol", "atol"}}
"""What numpy else adds: 1e-7 or 1e-5 of the values, which is more than most bounds here, and 1e-8 that has no unit."""


def unsaid(text):
    """Yield the line of each comparison that leaves a part of its bound to numpy or pytest."""
    for call in ast.walk(ast.parse(text)):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute | ast.Name):
            name = call.func.attr if isinstance(call.func, ast.Attribute) else call.func.id
            stated = {keyword.arg: keyword.value for keyword in call.keywords}
            absolute = name == "approx" and "abs" not in stated and fine(stated.get("rel"))
            if absolute or SAID.get(name, set()) - stated.keys():
                yield call.lineno


def fine(rel):
    """Whether the 1e-12 that pytest allows besides may be more than a relative bound of what is not far from one."""
    return rel is not None and not (
        isinstance(rel, ast.Constant) and isinstance(rel.value, float) and rel.value >= 1e-6
    )


def test_a_bound_that_is_left_to_others_is_seen():
    calls = "allclose(a, b, atol=1)\nnp.allclose(a, b, rtol=1)\nassert_allclose(a, b, atol=1)\nassert_allclose(a, b)\n"
    assert [*unsaid(calls + "approx(a, rel=1e-9)\npytest.approx(a, rel=4 * EPS)")] == [1, 2, 3, 4, 5, 6]
    stated = "np.allclose(a, b, rtol=0, atol=1)\nassert_allclose(a, b, rtol=1)\napprox(a, rel=1e-9, abs=0)"
    assert [*unsaid(stated + "\napprox(a)\napprox(a, abs=1e-9)\napprox(a, rel=0.1)")] == []


def test_every_comparison_says_its_bound():
    paths = sorted(TESTS.rglob("*.py"))
    assert [f"{path.relative_to(TESTS)}:{line}" for path in paths for line in unsaid(path.read_text())] == []


def test_shaken_starts_are_a_rounding_away(monkeypatch):
    system, start = pt.System(pt.Body((1.25, 1.0, 0.75))), pt.State((0.1, 0.7, -0.5, 0.5), (0.3, 0.2, 0.1, -0.24))
    starts = [pt.propagate(system, start, [0.0]).quaternion[0]]
    monkeypatch.setattr(StateVector, "from_state", StateVector.from_state)  # put back afterwards
    for seed in range(3):
        margins._shake(seed)
        starts.append(pt.propagate(system, start, [0.0]).quaternion[0])
    changes = np.abs(np.subtract(starts[1:], starts[0]))
    assert np.all(np.max(changes, axis=1) > 0)
    assert np.max(changes) < 8 * np.finfo(float).eps
    matrix = pt.analysis.state_transition(system, start, [0.0]).matrix[0]
    np.testing.assert_array_equal(matrix, np.eye(6))  # tangent vectors stay
