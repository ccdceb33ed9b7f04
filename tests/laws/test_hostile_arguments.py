"""Error messages repeat at most 200 printable characters of an argument, whatever the argument is and does."""

import ast
import contextlib
import random
import unicodedata
import warnings
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import poinsot as pt
from public_calls import public_calls
from refusals import is_ours, patience

mpl.use("Agg")

SOURCE = Path(pt.__file__).parent

LONGEST = 1200
"""Characters of a message: at most three arguments and 600 characters of the package's own, such as a list of names."""


class Refusing:
    """Every question about it raises an error."""

    def _refuse(self, *_, **__):
        raise RuntimeError("refused \x1b[2J\u202e" + "x" * 10_000)

    __repr__ = __str__ = __float__ = __int__ = __index__ = __len__ = __iter__ = __getitem__ = __array__ = _refuse
    __bool__ = __eq__ = __lt__ = __neg__ = __add__ = __fspath__ = __contains__ = _refuse
    __hash__ = object.__hash__


class Verbose:
    def __repr__(self):
        return "\u202e\x1b]0;title\x07\n" + "y" * 1_000_000


def nested():
    inner = [1.0]
    for _ in range(5000):
        inner = [inner]
    return inner


def refusing_array():
    array = np.empty(3, dtype=object)
    for place in range(3):
        array[place] = Refusing()
    return array


LONG_NAME = type("N" * 100_000, (), {})

HOSTILE: dict[str, Any] = {
    "nested lists": nested,
    "number of 5001 digits": lambda: 10**5000,
    "object that refuses": Refusing,
    "list of objects that refuse": lambda: [Refusing(), Refusing()],
    "array of objects that refuse": refusing_array,
    "mapping of objects that refuse": lambda: {Refusing(): Refusing()},
    "object with a long repr": Verbose,
    "list of objects with a long repr": lambda: [Verbose()],
    "class with a long name": lambda: LONG_NAME,
    "object of a class with a long name": LONG_NAME,
    "long text": lambda: "a" * 1_000_000,
    "long bytes": lambda: b"\x00\xff" * 500_000,
    "control characters": lambda: "a\x1b[2J\r\n\x9b\x07b\x7f",
    "bidirectional marks": lambda: "a\u202e\u2066b\u200f.nc",
    "lone surrogates": lambda: "a\ud800b\udfff",
    "separators": lambda: "a\u2028\u2029\x85b",
    "list of long texts": lambda: ["b" * 1_000_000, "\x1b[2J"],
    "mapping with a long text": lambda: {"\x1b" + "c" * 1_000_000: "\u202e" * 1000},
    "array of texts": lambda: np.array(["\x1b\u202e" + "d" * 10_000]),
    "path of control characters": lambda: Path("no folder\x1b[2J\u202e") / ("e" * 3000),
    "labelled array": lambda: xr.DataArray(np.ones((2, 3)), dims=("\x1b[2J\u202e", "f" * 10_000)),
    "labelled table": lambda: pd.DataFrame({"\x1b[2J" + "g" * 10_000: [1.0, 2.0]}),
}


def fault_of(error):
    """Return the fault of an error, or None."""
    message = str(error)
    wrong = {letter for letter in message if not letter.isprintable()}
    if wrong:
        return f"characters {sorted(map(ascii, wrong))}, of {sorted(map(unicodedata.category, wrong))}"
    if len(message) > LONGEST:
        return f"{len(message)} characters: {message[:80]}"
    return None if is_ours(error) else f"{type(error).__name__} {message[:100]}"


def fault(function, arguments):
    """Return the fault of the error that a call raises, or None."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), patience():
            warnings.simplefilter("ignore")
            function(**arguments)
    except Exception as error:
        return fault_of(error)
    finally:
        plt.close("all")
    return None


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calls")
    with contextlib.chdir(folder):
        yield public_calls(folder)


def every(calls):
    return [(name, argument, kind) for name, (_, given) in calls.items() for argument in given for kind in HOSTILE]


def faults(calls, chosen):
    found = []
    for name, argument, kind in chosen:
        function, arguments = calls[name]
        if wrong := fault(function, {**arguments, argument: HOSTILE[kind]()}):
            found.append(f"{name}({argument}={kind}): {wrong}")
    return found


def test_messages_about_some_hostile_arguments_are_short_and_printable(calls):
    assert faults(calls, random.Random(20061027).sample(every(calls), 800)) == []


@pytest.mark.slow
def test_messages_about_all_hostile_arguments_are_short_and_printable(calls):
    assert faults(calls, every(calls)) == []


def test_no_error_repeats_an_argument_by_its_repr():
    """An argument comes into a message by `quoted` or `shortened`, which bound and escape it."""
    found = []
    for path in SOURCE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Raise):
                inner = list(ast.walk(node))
                conversions = [each for each in inner if isinstance(each, ast.FormattedValue) and each.conversion != -1]
                calls = [each for each in inner if isinstance(each, ast.Name) and each.id in ("repr", "ascii")]
                found += [f"{path.relative_to(SOURCE)}:{node.lineno}"] * bool(conversions or calls)
    assert found == []
