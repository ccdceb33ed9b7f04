"""Every force comes back from the text that a result has of its system: on one body, and on one or both of two."""

import dataclasses

import pytest

import poinsot as pt
from kinds import concrete_subclasses
from kinds.forces_in_files import FIRST, OF_ONE, OF_TWO, PAIR, comes_back, label
from kinds.parts import PARTS
from poinsot.scenarios.registry import keys_of


@pytest.fixture(autouse=True)
def any_body(monkeypatch):
    """It is not asked whether the body of a force is the one that turns."""
    for force in OF_ONE:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


def test_every_force_is_here():
    known = {type(force) for force in (*OF_ONE, *OF_TWO)}
    shipped = concrete_subclasses(pt.Potential, pt.Torque, pt.mechanics.PairLoad)
    on_one_body_alone = {pt.control.Sampled}  # in the laws of control laws
    assert {cls for cls in shipped if not cls.__name__.endswith("On")} == known | on_one_body_alone


@pytest.mark.parametrize("force", OF_ONE, ids=label)
def test_forces_on_one_body_come_back(force):
    assert comes_back(FIRST, force)
    for body in ("primary", "secondary") if getattr(force, "moves_orbit", True) else ():
        assert comes_back(PAIR, force.on(body))


@pytest.mark.parametrize("force", OF_TWO, ids=label)
def test_forces_on_two_bodies_come_back(force):
    assert comes_back(PAIR, force)


def with_records(record):
    """A record and all within it."""
    return [record, *(inner for each in record.records for inner in with_records(each))]


def takes_a_number(record, name):
    try:
        dataclasses.replace(record, **{name: 0.5})
    except (TypeError, ValueError):
        return False
    return True


def test_tables_have_one_number_for_an_array_where_the_class_takes_it():
    """So the schema of scenarios allows what a run does."""
    records = [each for force in (*OF_ONE, *OF_TWO, *PARTS) for each in with_records(force)]
    found = [(each, key) for each in records if dataclasses.is_dataclass(each) for key in keys_of(type(each))]
    arrays = [(each, key) for each, key in found if key.rank and hasattr(each, key.name)]
    wrong = {
        f"{type(each).__name__}.{key.name}" for each, key in arrays if key.or_number != takes_a_number(each, key.name)
    }
    assert wrong == set()
    assert {key.name for _, key in arrays if key.or_number} >= {"specular", "drag", "tensor", "friction"}
