"""The examples in the docstrings of public names and of their methods run, and say what they print."""

import doctest

import numpy as np
import pytest

import poinsot as pt
from public_calls import PUBLIC

FINDER = doctest.DocTestFinder(exclude_empty=True)
EXAMPLES = {
    test.name: test
    for name, thing in PUBLIC.items()
    for test in FINDER.find(thing, name, module=False, globs={"np": np, "pt": pt})
    if test.examples
}


def test_there_are_examples():
    assert {"KeplerOrbit", "EscapeOrbit", "FixedPosition", "two_body_orbit"} <= set(EXAMPLES)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_prints_what_it_says(name):
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    said: list[str] = []
    assert runner.run(EXAMPLES[name], out=said.append, clear_globs=False).failed == 0, "".join(said)
