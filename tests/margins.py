"""How near the numerical bounds of the tests are to what is measured, on shaken starts and other lane counts.

    python -m pytest -o enable_assertion_pass_hook=true --margins out/margins.txt --shake 7 --lanes 4 --numprocesses 2

A bound that is not derived is at least three times the worst over 20 seeds of `--shake` and over 2, 4 and 8 lanes:
of each comparison that passes, the file lists the largest value over its bound. A bound near the rounding unit without
a comment of its own is such a measured one.
"""

import ast
import operator
import re
import sys
import zlib
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from poinsot.integration import equations, state_vector

SCALAR = re.compile(r"np\.\w+\('?([-+\d.e]+)'?\)")
OPERATIONS: dict[type, Any] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}


def pytest_addoption(parser):
    group = parser.getgroup("margins")
    group.addoption("--shake", type=int, help="seed: shake every start of an integration by a rounding or none")
    group.addoption("--lanes", type=int, help="lanes of a batch, whatever the processor has")
    group.addoption("--margins", type=Path, help="file to list each comparison's value over its bound in")


def pytest_configure(config):
    if config.option.lanes:
        equations.LANES = config.option.lanes
    if config.option.shake is not None:
        _shake(config.option.shake)
    if config.option.margins:
        config.pluginmanager.register(Margins(config.option.margins))


def _shake(seed):
    """Change each variable of a start by -1, 0 or 1 roundings; equal starts equally."""
    plain = state_vector.StateVector.from_state

    def shaken(self, state):
        start = plain(self, state)
        for row in start.reshape(-1, start.shape[-1])[:, : self.tangent_vectors.start]:
            random = np.random.default_rng([seed, zlib.crc32(row.astype(float).tobytes())])
            row *= 1 + np.finfo(float).eps * random.integers(-1, 2, row.shape)
        return start

    state_vector.StateVector.from_state = shaken


class Margins:
    """The largest value over its bound of each comparison in the tests."""

    def __init__(self, path):
        self.path, self.worst, self.test = path, defaultdict(lambda: (0.0, "", "")), ""
        _record_arrays(self)
        _record_approximations(self)

    @pytest.hookimpl
    def pytest_runtest_setup(self, item):
        self.test = item.nodeid

    @pytest.hookimpl
    def pytest_assertion_pass(self, item, lineno, orig, expl):
        for value, bound in _compared(SCALAR.sub(r"\1", expl.split("\n")[0])):
            self.note(f"{item.location[0]}:{lineno}", abs(value), abs(bound), orig)

    @pytest.hookimpl
    def pytest_testnodedown(self, node):
        """Take what a worker has found."""
        for place, found in node.workeroutput.get("margins", {}).items():
            self.worst[place] = max(self.worst[place], tuple(found))

    @pytest.hookimpl
    def pytest_sessionfinish(self, session):
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["margins"] = dict(self.worst)
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        rows = sorted(((ratio, place, test, orig) for place, (ratio, test, orig) in self.worst.items()), reverse=True)
        self.path.write_text("".join(f"{r:.3g}\t{place}\t{test}\t{orig}\n" for r, place, test, orig in rows))

    def note(self, place, value, bound, text):
        """Keep the ratio if it is the largest of its place so far."""
        ratio = value / bound if bound else float(value > 0)
        if bound <= 1e-3 and ratio > self.worst[place][0]:
            self.worst[place] = (ratio, self.test, f"{value:.3g} of {bound:.3g}: {' '.join(text.split())[:100]}")


def _compared(text):
    """Return the smaller and the larger side of each comparison in a chain of numbers; nothing of other assertions."""
    try:
        chain = ast.parse(text, mode="eval").body
        numbers = [_number(side) for side in (chain.left, *chain.comparators)]
    except (AttributeError, KeyError, SyntaxError, ValueError, ZeroDivisionError):
        return []
    pairs = [pair for pair in zip(numbers, numbers[1:], chain.ops, strict=False) if not isinstance(pair[2], ast.Eq)]
    return [(b, a) if isinstance(sign, ast.Gt | ast.GtE) else (a, b) for a, b, sign in pairs]


def _number(formula):
    """Work out a formula of numbers."""
    match formula:
        case ast.Constant(int() | float() as number):
            return float(number)
        case ast.BinOp(left, operation, right):
            return OPERATIONS[type(operation)](_number(left), _number(right))
        case ast.UnaryOp(operation, number):
            return OPERATIONS[type(operation)](_number(number))
    raise ValueError(formula)


def _record_arrays(margins):
    """Let numpy's comparisons of arrays with a tolerance tell their margins too."""
    for module, name, rtol in ((np.testing, "assert_allclose", 1e-7), (np, "allclose", 1e-5)):
        setattr(module, name, _telling(margins, getattr(module, name), name, rtol))


def _telling(margins, plain, name, default):
    def noted(actual, desired, rtol=default, atol=0.0 if name == "assert_allclose" else 1e-8, *args, **kwargs):
        place = sys._getframe(1)
        try:
            a, b = (np.asarray(part) for part in (actual, desired))
            bound = np.broadcast_to(atol + rtol * np.abs(b), np.broadcast_shapes(a.shape, b.shape))
            ratio = np.nan_to_num(np.abs(a - b).astype(float) / np.where(bound > 0, bound, np.nan), nan=0.0, posinf=0.0)
            if ratio.size and "tests" in place.f_code.co_filename:
                i = np.unravel_index(np.argmax(ratio), ratio.shape)
                where = f"{Path(place.f_code.co_filename).name}:{place.f_lineno}"
                margins.note(where, float(ratio[i] * bound[i]), float(bound[i]), f"{name} rtol={rtol} atol={atol}")
        except (TypeError, ValueError):  # quantities, objects, shapes that the comparison itself refuses
            pass
        return plain(actual, desired, rtol, atol, *args, **kwargs)

    return noted


def _record_approximations(margins):
    """Let `pytest.approx` tell its margins too: those of arrays and sequences come to its numbers."""
    kind = type(pytest.approx(1.0))
    plain = kind.__eq__

    def noted(self, actual):
        numbers = all(isinstance(x, float | complex) and np.isfinite(x) for x in (actual, self.expected))
        if numbers and 0 < abs(actual - self.expected) <= self.tolerance:
            place = sys._getframe(1)
            while place and "/tests/" not in place.f_code.co_filename:
                place = place.f_back
            where = f"{Path(place.f_code.co_filename).name}:{place.f_lineno}" if place else "?"
            margins.note(where, float(abs(actual - self.expected)), float(self.tolerance), f"approx {self}")
        return plain(self, actual)

    kind.__eq__ = noted
