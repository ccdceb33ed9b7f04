"""Every number that a user gives is a plain one: a unit is converted or refused, a mask and other kinds are refused."""

import warnings
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from astropy import units

from public_calls import public_calls, public_names

mpl.use("Agg")

COMPLEX = {("frequencies", "signal"), ("diffusion", "signal")}
"""Signals may be complex."""


class Pint:
    """A quantity as pint has them, without its package."""

    def __init__(self, value):
        self._value = np.array(value, dtype=float)

    @property
    def magnitude(self):
        return self._value

    @property
    def units(self):
        return "furlong"

    def __array__(self, dtype=None, copy=None):
        return self._value

    def __float__(self):
        return float(self._value)

    def __mul__(self, other):
        return Pint(self._value * other)

    def __neg__(self):
        return Pint(-self._value)


WRONG: dict[str, Any] = {
    "quantity": lambda value: np.array(value, dtype=float) * units.kg,
    "quantities in a list": lambda value: [x * units.kg for x in np.atleast_1d(value)],
    "quantity of another package": Pint,
    "mask": lambda value: np.ma.masked_array(value, mask=np.ones(np.shape(value), bool)),
    "mask without a masked value": np.ma.masked_array,
    "masked in a list": lambda value: [np.ma.masked_array(x, mask=True) for x in np.atleast_1d(value)],
    "structured": lambda value: np.array(np.ones(np.shape(value)), dtype=[("a", float)]),
    "complex": lambda value: np.array(value) + 1j,
    "bool": lambda value: np.ones(np.shape(value), bool),
    "text": lambda value: np.array(value).astype(str),
}


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    return public_calls(tmp_path_factory.mktemp("calls"))


def is_number(value):
    try:
        return np.array(value).dtype.kind in "iuf" and not isinstance(value, bool)
    except (TypeError, ValueError):
        return False


def outcome(function, arguments):
    """Return the error of a call, or None."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            function(**arguments)
    except Exception as error:
        return error
    finally:
        plt.close("all")
    return None


def test_every_public_name_has_its_call(calls):
    missing = [name for name in public_names() if name not in calls]
    assert not missing, " ".join(missing)


@pytest.mark.parametrize("kind", WRONG)
def test_no_number_loses_what_it_is(calls, kind):
    passed = []
    for name, (function, arguments) in calls.items():
        for argument in (key for key, value in arguments.items() if is_number(value)):
            if kind == "complex" and (name, argument) in COMPLEX:
                continue
            error = outcome(function, {**arguments, argument: WRONG[kind](arguments[argument])})
            if not isinstance(error, TypeError | ValueError) or not (argument in str(error) or "epoch" in str(error)):
                passed.append((name, argument, error))
    assert passed == []
