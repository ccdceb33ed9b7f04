"""Objects that stay as they were made."""

import dataclasses

import numpy as np
import pytest

import poinsot as pt
from kinds import concrete_subclasses
from poinsot.records.parameters import Parametric


class Mixin:
    """A class without fields whose annotation no dataclass reads."""

    friction: float = 0.3


def refusal(name, value):
    return (
        f"{name} of Braked must have an annotation, got the default {value} without one. Repeat the annotation of the "
        "base class, as in `gain: float = 0.3`."
    )


@pytest.mark.parametrize(
    ("bases", "attributes", "name", "value"),
    [
        ((pt.parts.ReactionWheel,), {"friction": 0.3}, "friction", "0.3"),
        ((pt.parts.ReactionWheel,), {"axis": (0.0, 0.0, 1.0)}, "axis", r"(0.0, 0.0, 1.0)"),
        ((Mixin, pt.parts.ReactionWheel), {}, "friction", "0.3"),
        ((pt.Calendar,), {"unit": "days"}, "unit", "'days'"),
    ],
)
def test_a_default_without_an_annotation_raises_an_error(bases, attributes, name, value):
    with pytest.raises(TypeError) as caught:
        type("Braked", bases, attributes)
    assert str(caught.value) == refusal(name, value)


@pytest.mark.parametrize("kind", sorted(concrete_subclasses(Parametric), key=str))
def test_a_default_without_an_annotation_raises_an_error_for_every_kind(kind):
    for field in dataclasses.fields(kind):
        with pytest.raises(TypeError) as caught:
            type("Braked", (kind,), {field.name: 0.3})
        assert str(caught.value) == refusal(field.name, "0.3")


class Braked(pt.parts.ReactionWheel):
    """A wheel with another default."""

    friction: float = 0.3


class Driven(Braked):
    """A wheel with another field."""

    gain: float = 2.0


class Derived(Braked):
    """A wheel whose friction follows from another number."""

    @property
    def friction(self):
        return 0.1


def test_a_default_with_an_annotation_replaces_the_default_of_the_base():
    for kind in (Braked, Driven):
        assert kind((0.0, 0.0, 1.0), 0.1).friction == 0.3


def test_a_property_is_no_default():
    assert Derived.unchecked().friction == 0.1


def nested(levels):
    value = [1.0]
    for _ in range(levels):
        value = [value]
    return value


def endless():
    value = [1.0]
    value.append(value)
    return value


@pytest.mark.parametrize("value", [nested(3000), endless(), {"a": nested(3000)}], ids=["nested", "endless", "mapping"])
def test_lists_within_each_other_raise_an_error(value):
    with pytest.raises(ValueError, match=r"^lists must contain each other at most 64 deep, got ") as caught:
        pt.analysis.SecularEvolution(value, {}, ())
    assert len(str(caught.value)) < 300


def test_nested_arrays_become_read_only():
    inside = np.ones(3)
    made = pt.analysis.SecularEvolution(np.zeros(2), {"a": [[[inside]]]}, ())
    assert not made.values["a"][0][0][0].flags.writeable
