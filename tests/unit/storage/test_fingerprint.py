"""The digest of a problem: the same for the same definition, another one for any number that differs."""

import functools
import pickle
import re
import threading

import numpy as np
import pytest

import forked
import poinsot as pt
from kinds.forces import FORCES
from poinsot.records.parameters import Parametric
from poinsot.storage.fingerprint import digests, fingerprint

BODY = pt.Body((1.25, 1.0, 0.75))


@pytest.mark.parametrize("force", FORCES, ids=lambda force: type(force).__name__)
def test_copies_have_the_same_and_other_numbers_another(force):
    found = fingerprint(force)
    force.structure, force.numbers  # noqa: B018 - a computed and stored value is no definition
    assert found == fingerprint(force)
    assert found == fingerprint(pickle.loads(pickle.dumps(force)))
    for changed in others(force):
        assert fingerprint(changed) != found


def others(record):
    """The record with each of its own arrays of numbers changed by an ulp."""
    kind, fields = type(record), vars(record)
    for name in record.definition[1]:
        value = fields.get(name)
        if isinstance(value, np.ndarray) and value.size and value.dtype.kind == "f":
            first = value.copy()
            first.flat[0] = np.nextafter(first.flat[0], np.inf)
            yield kind.unchecked(**{**{n: v for n, v in fields.items() if n in record.definition[1]}, name: first})
        elif isinstance(value, Parametric):
            for changed in others(value):
                yield kind.unchecked(
                    **{**{n: v for n, v in fields.items() if n in record.definition[1]}, name: changed}
                )


def test_all_forces_differ():
    assert len({fingerprint(force) for force in FORCES}) == len(FORCES)


OWN = """
import functools
import numpy as np
import poinsot as pt
from poinsot.storage.fingerprint import fingerprint

class Push(pt.Torque):
    size: float
    def torque(self, instant):
        return self.size * pt.functions.Vector((1.0, 0.0, instant.time))

def law(scale, data):
    return {"a", "b", "c"} and scale * data.mean() + sum(x for x in (1, 2))

Push.__module__ = law.__module__ = "mine"
orbit = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.1)
values = [
    pt.System(pt.Body((1.25, 1.0, 0.75)), Push(0.5), pt.GravityGradient(orbit), units={"time": "s"}),
    functools.partial(law, 3.0), {"x": [1, 2.5, None, "y", np.float32(2)]}, frozenset("hello"), law,
    np.arange(6).reshape(2, 3), orbit,
]
digests = [fingerprint(value) for value in values]
"""


def test_another_process_finds_the_same():
    """Whatever the seed of hashes of texts is there."""
    here: dict = {"__name__": "mine"}
    exec(compile(OWN, "<string>", "exec"), here)
    there = forked.run(OWN + "print(*digests)").stdout.split()
    assert here["digests"] == there
    assert len({*there}) == len(there)


def twice(data):
    return 2 * data


def thrice(data):
    return 3 * data


def test_functions_differ_by_their_code_and_what_they_close_over():
    def scaled(factor):
        return lambda data: factor * data

    functions = [twice, thrice, scaled(2), scaled(3), functools.partial(twice, 1), np.mean, len, BODY.state]
    assert len({fingerprint(function) for function in functions}) == len(functions)
    assert fingerprint(scaled(2)) == fingerprint(scaled(2))


def test_shapes_and_kinds_of_numbers_count():
    values = [1, 1.0, True, "1", np.ones(1), np.ones((1, 1)), np.ones(1, dtype="f4"), [1], (1,), {1: 1}, None]
    assert len({fingerprint(value) for value in values}) == len(values)


def test_what_contains_itself_ends():
    loop: list = [1]
    loop.append(loop)
    assert fingerprint(loop) == fingerprint(loop)


def test_nested_lists_and_keyword_defaults_count():
    def law(n):
        def inner(data, *, scale=n):
            return scale * data

        return inner

    values = [[[1], 2], [[1, 2]], [(), 1], [(1,)], {"a": [], "b": 1}, law(1), law(2)]
    assert len({fingerprint(value) for value in values}) == len(values)


@pytest.mark.parametrize(
    "held", [np, threading.Lock(), (x for x in "ab"), re.compile("a")], ids=["module", "lock", "generator", "pattern"]
)
def test_what_a_function_holds_may_be_without_numbers(held):
    """A module that the function around it imports, a lock."""

    def law(factor):
        return lambda data: (held, factor * data)

    assert fingerprint(law(2.0)) == fingerprint(law(2.0)) != fingerprint(law(3.0))


def test_digests_are_by_name():
    problem = {"times": np.arange(3.0), "function": "propagate"}
    assert digests(problem) == {name: fingerprint(value) for name, value in problem.items()}
