"""Fields of public classes say their axes, and take members where a user's type checker looks on."""

import inspect
import re

import pytest

import poinsot as pt
from poinsot.checked import hint_of
from poinsot.quantities import Along, annotated_with, extras_of
from poinsot.records.parameters import Parametric, kinds_of
from public_calls import PUBLIC
from typed_calls import forces_of_members, orbits_of_members

PARTS = {name: getattr(pt.parts, name) for name in pt.parts.__all__}
CLASSES = {name: cls for name, cls in {**PUBLIC, **PARTS}.items() if inspect.isclass(cls)}
RECORDS = {name: cls for name, cls in CLASSES.items() if issubclass(cls, Parametric)}
SHAPES = {name: cls for name, cls in CLASSES.items() if issubclass(cls, pt.shapes.Shape) and cls is not pt.shapes.Shape}

WITHOUT_AXES = {("Body", "moments")}
"""Three numbers that are no vector."""


def heading(cls, field):
    """Return what a docstring says of the type of a parameter."""
    found = re.search(rf"^[\w, ]*\b{field}\b[\w, ]* : (.*)$", inspect.cleandoc(cls.__doc__), re.MULTILINE)
    assert found, f"{cls.__name__} says nothing of {field}"
    return found[1]


@pytest.mark.parametrize("name", RECORDS)
def test_a_vector_says_its_axes_in_its_annotation_and_its_docstring(name):
    cls = RECORDS[name]
    vectors = {field for field, kind in kinds_of(cls).items() if isinstance(kind, tuple) and kind[-1:] == (3,)}
    axes = annotated_with(cls, Along)
    assert vectors - {field for owner, field in WITHOUT_AXES if owner == name} == set(axes)
    for field, along in axes.items():
        assert heading(cls, field).endswith(f", {along.axes}")


@pytest.mark.parametrize("name", SHAPES)
def test_a_vector_of_a_shape_says_its_axes(name):
    function = inspect.unwrap(SHAPES[name].__init__)
    hints = {field: hint_of(annotation, function.__globals__) for field, annotation in function.__annotations__.items()}
    for field, hint in hints.items():
        shape = [extra for extra in extras_of(hint) if isinstance(extra, tuple)]
        if shape and shape[0][-1] == 3 and field != "faces":
            assert Along("axes of the shape") in extras_of(hint)
            assert heading(SHAPES[name], field).endswith(", axes of the shape")


def test_an_error_sentence_says_the_axes():
    with pytest.raises(ValueError, match=r"axis must have shape \(3,\) or \(members, 3\) along the body axes, got"):
        pt.events.SpinFlip((1, 0))


def test_fields_take_members():
    for thing in [*orbits_of_members(), *forces_of_members()]:
        assert (2,) in [number.shape for number in thing.numbers]
