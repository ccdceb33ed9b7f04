"""Whatever comes as an argument, a public call works, or refuses it in a sentence of the package."""

import contextlib
import random
import warnings
from decimal import Decimal
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from astropy import units

import poinsot as pt
from public_calls import BODY, START, TOP, public_calls
from refusals import is_ours, patience

mpl.use("Agg")


class Awkward:
    """It has what many kinds have, and is none of them."""

    def __len__(self):
        return 3

    def __getitem__(self, index):
        raise KeyError(index)

    def __repr__(self):
        return "Awkward()"


def endless():
    cycle = [1.0]
    cycle.append(cycle)
    return cycle


WRONG = {
    "None": lambda: None,
    "object": object,
    "awkward": Awkward,
    "text": lambda: "xyz",
    "empty text": lambda: "",
    "text with a null": lambda: "a\0b",
    "bytes": lambda: b"xyz",
    "true": lambda: True,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "minus one": lambda: -1,
    "zero": lambda: 0,
    "half": lambda: 0.5,
    "huge": lambda: 10**400,
    "large": lambda: 2**63,
    "tiny": lambda: 5e-324,
    "complex": lambda: 1j,
    "empty list": list,
    "empty array": lambda: np.empty(0),
    "empty rows": lambda: np.empty((0, 3)),
    "ragged": lambda: [[1.0, 2.0], [3.0]],
    "cycle": endless,
    "three axes": lambda: np.ones((2, 3, 4)),
    "seven": lambda: np.ones(7),
    "vector": lambda: (1.0, 2.0, 3.0),
    "zeros": lambda: np.zeros(4),
    "array of objects": lambda: np.array([object(), None]),
    "array of texts": lambda: np.array(["a", "b"]),
    "texts": lambda: ["a", "b"],
    "Nones": lambda: [None, None],
    "dates": lambda: np.array(["2026-11-21"], dtype="datetime64[s]"),
    "duration": lambda: np.timedelta64(1, "s"),
    "durations": lambda: np.array([1, 2], dtype="timedelta64[s]"),
    "decimal": lambda: Decimal("0.5"),
    "signalling nan": lambda: Decimal("sNaN"),
    "series": lambda: pd.Series([1.0, 2.0]),
    "frame of a table": lambda: pd.DataFrame({"a": [1.0, 2.0]}),
    "timestamp": lambda: pd.Timestamp("2026-11-21"),
    "missing": lambda: pd.NA,
    "no time": lambda: pd.NaT,
    "components": lambda: pt.functions.Vector((1.0, 2.0, 3.0)),
    "unit": lambda: units.s,
    "quantity": lambda: 3.0 * units.kg,
    "masked": lambda: np.ma.masked,
    "mapping": lambda: {"a": 1},
    "set": lambda: {1, 2},
    "generator": lambda: (x for x in (1.0, 2.0)),
    "class": lambda: pt.Body,
    "lambda": lambda: lambda *_: None,
    "function of nothing": lambda: lambda: None,
    "function of names": lambda: lambda *, name: name,
    "module": lambda: np,
    "body": lambda: BODY,
    "state": lambda: START,
    "system": lambda: TOP,
    "path that is not there": lambda: Path("/nowhere/to be/found"),
    "folder": lambda: Path("/"),
}


def raw_error(function, arguments):
    """Return what a call raised that the package did not, or None."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), patience():
            warnings.simplefilter("ignore")
            function(**arguments)
    except BaseException as error:
        return None if is_ours(error) else error
    finally:
        plt.close("all")
    return None


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calls")
    with contextlib.chdir(folder):  # where a wrong path may be written
        yield public_calls(folder)


def raw_among(calls, chosen):
    found = []
    for name, argument, wrong in chosen:
        function, arguments = calls[name]
        error = raw_error(function, {**arguments, argument: WRONG[wrong]()})
        if error is not None:
            found.append(f"{name}({argument}={wrong}): {type(error).__name__} {str(error)[:100]}")
    return found


def every(calls):
    return [(name, argument, wrong) for name, (_, given) in calls.items() for argument in given for wrong in WRONG]


def test_calls_of_the_table_are_right(calls):
    for name, (function, arguments) in calls.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert function(**arguments) is not None, name
        plt.close("all")


def test_some_wrong_calls_are_refused_in_sentences(calls):
    assert raw_among(calls, random.Random(20061027).sample(every(calls), 1500)) == []


@pytest.mark.slow
def test_every_wrong_call_is_refused_in_a_sentence(calls):
    assert raw_among(calls, every(calls)) == []
