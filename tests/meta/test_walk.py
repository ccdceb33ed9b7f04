"""The way of a system through calls: stays and returns of small packages, and of a call of the package."""

import itertools
import sys

import pytest
from tools import walk

SOURCES = {
    "poinsot.classes": """
class System:
    pass
class Slotted:
    __slots__ = ("inside", "unset")
    def __init__(self, inside):
        self.inside = inside
class Holder:
    def __init__(self, inside):
        self.inside = inside
    def own(self):
        return 0
""",
    "poinsot.lower": """
def one(value):
    return value
def several(*values, **named):
    return values
def generated(value):
    yield value
    yield value
""",
    "elsewhere": """
def outside(value):
    return value
""",
}


def sources():
    """Return the namespaces of the modules of a small package."""
    spaces = {name: {"__name__": name} for name in SOURCES}
    for name, text in SOURCES.items():
        exec(text, spaces[name])
    return spaces.values()


def test_consecutive_calls_in_a_module_are_one_stay():
    classes, lower, other = sources()
    system = classes["System"]()
    holder = classes["Holder"](system)

    def call():
        lower["one"](system)
        lower["one"](system)
        other["outside"](system)
        lower["one"](0)
        holder.own()
        lower["several"](0, system)

    assert walk.walk(call) == ["poinsot.lower", "poinsot.classes", "poinsot.lower"]


def test_arguments_contain_the_system_through_attributes_and_elements():
    classes, lower, _ = sources()
    system = classes["System"]()
    held, slotted = classes["Holder"](system), classes["Slotted"](system)
    far = held
    for _ in range(walk.MAX_DEPTH - 1):
        far = [far]
    for value in (system, held, slotted, [system], (0, {"a": system}), far):
        assert walk.walk(lambda value=value: lower["one"](value)) == ["poinsot.lower"]
    assert walk.walk(lambda: lower["several"](a=system)) == ["poinsot.lower"]
    for value in (0, classes["Holder"](0), [far], {system}):
        assert walk.walk(lambda value=value: lower["one"](value)) == []


def test_instances_of_subclasses_count():
    classes, lower, _ = sources()
    kind = type("Special", (classes["System"],), {})
    assert walk.walk(lambda: lower["one"](kind())) == ["poinsot.lower"]


def test_a_cycle_of_attributes_ends():
    classes, lower, _ = sources()
    holder = classes["Holder"](None)
    holder.inside = [holder]
    assert walk.walk(lambda: lower["one"](holder)) == []


def test_a_resumed_generator_is_no_stay():
    classes, lower, _ = sources()
    system = classes["System"]()

    def call():
        for value in lower["generated"](system):
            classes["Holder"](value).own()

    assert walk.walk(call) == ["poinsot.lower", "poinsot.classes"]


def test_the_way_through_a_later_call_begins_where_arguments_are_checked():
    walk.CASES["propagate"]()
    stays = walk.walk(walk.CASES["propagate"])
    assert stays[:2] == ["poinsot.checked", "poinsot.propagation.propagate"]
    assert all(one != other for one, other in itertools.pairwise(stays))


def test_an_error_ends_the_record():
    def call():
        raise ValueError("no motion")

    with pytest.raises(ValueError, match="no motion"):
        walk.walk(call)
    assert sys.getprofile() is None
