"""Parameters in docstrings are documented once and inherited."""

import poinsot as pt
from poinsot.docstrings import inherit_parameters, parameter_entries

ENTRIES = {"direction": "direction : {-1, 0, 1}\n    The sign.", "terminal": "terminal : bool\n    The end."}


class Base:
    """Base.

    Parameters
    ----------
    direction : {-1, 0, 1}
        The sign.
    terminal : bool
        The end.
    """


def completed(docstring, *names):
    cls = type("Derived", (Base,), {"__doc__": docstring})
    inherit_parameters(cls, names)
    return cls.__doc__


def test_entries_by_name():
    assert parameter_entries(Base.__doc__) == ENTRIES
    assert parameter_entries("Sum.\n\nParameters\n----------\n*a, b : int\n    Both.\n\nReturns\n-------\nint") == {
        "a": "*a, b : int\n    Both.",
        "b": "*a, b : int\n    Both.",
    }
    assert parameter_entries(None) == parameter_entries("Nothing.") == {}


def test_entries_are_in_the_order_of_the_names():
    own = "Derived.\n\n    Parameters\n    ----------\n    terminal : bool\n        Own."
    assert completed(f"{own}\n\n    Raises\n    ------\n    ValueError\n    ", "direction", "terminal") == (
        "Derived.\n\nParameters\n----------\ndirection : {-1, 0, 1}\n    The sign.\nterminal : bool\n    Own.\n\n"
        "Raises\n------\nValueError"
    )


def test_a_section_precedes_the_others():
    assert completed("Derived.\n\n    Examples\n    --------\n    >>> 1\n    1\n    ", "terminal") == (
        "Derived.\n\nParameters\n----------\nterminal : bool\n    The end.\n\nExamples\n--------\n>>> 1\n1"
    )
    assert completed("Derived.", "terminal") == "Derived.\n\nParameters\n----------\nterminal : bool\n    The end."


def test_nothing_changes_without_inherited_entries():
    assert completed("Derived.\n    ", "other") == "Derived.\n    "
    assert completed(None, "terminal") is None


def test_classes_of_the_package_document_every_field():
    assert list(parameter_entries(pt.events.PairApsis.__doc__)) == ["direction", "terminal"]
    assert list(parameter_entries(pt.parts.ReactionWheel.__doc__))[-1] == "name"


def test_constructors_inherit_the_parameters_of_fields():
    assert list(parameter_entries(pt.KeplerOrbit.from_vectors.__doc__)) == [
        *("mu", "position", "velocity", "epoch", "radius"),
    ]
    entries = parameter_entries(pt.orbits.Ephemeris.from_table.__doc__)
    assert entries["mu"] == parameter_entries(pt.KeplerOrbit.__doc__)["mu"]
    assert entries["calendar"].startswith("calendar : Calendar, optional\n")
