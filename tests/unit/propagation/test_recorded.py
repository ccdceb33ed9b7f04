"""Systems, parts and events of which a file contains a description and no formula."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.mechanics.part import Jump
from poinsot.propagation.recorded import RecordedEvent, RecordedPart, RecordedSystem, recorded_integral
from poinsot.records.members import members_of

BODY = pt.Body([(1.0, 1.5, 2.0), (1.1, 1.5, 2.0), (1.2, 1.5, 2.0)])
START = BODY.state((1, 0, 0, 0), omega_body=np.eye(3))
ENERGY = recorded_integral("energy", {"symbol": "H", "long_name": "total energy", "kind": "energy"})
WHEEL = RecordedPart(
    "wheel", {"momentum": 1, "angle": 2}, frozenset({"momentum"}), Jump(np.array([1.0, 2.0, 3.0]), 0.0)
)


def system(*parts):
    return RecordedSystem(BODY, {"time": "s"}, "System(Body(), Magnet())", "the class is outside.", (ENERGY,), parts)


def test_a_system_has_its_text_and_its_reason():
    assert repr(system()) == "System(Body(), Magnet())"
    assert system().not_rerunnable == "the class is outside."
    assert dict(system().units) == {"time": "s", "inertia": "1"}
    assert not system().moves_alone
    assert system().torques_body(START) == system().validity(START) == system().limits(START) == {}


def test_a_body_without_parts_turns_with_its_momentum():
    assert np.array_equal(system().omega_body(START), np.eye(3))
    assert np.array_equal(system().kinetic_energy(START), [0.5, 0.75, 1.0])


@pytest.mark.parametrize("name", ["omega_body", "kinetic_energy"])
def test_a_body_with_parts_needs_their_formulas(name):
    with pytest.raises(ValueError, match=f"^{name} must have the parts of the body to be computed, got a file without"):
        getattr(system(WHEEL), name)(START)


def test_members_have_their_bodies_and_jumps():
    some = members_of(system(WHEEL), np.array([2, 0]))
    assert some.body.moments[:, 0].tolist() == [1.2, 1.0]
    assert some.jumping[0].jump.period.tolist() == [3.0, 1.0]
    assert members_of(system(WHEEL), 1).parts[0].jump.period == 2.0
    assert WHEEL.size == 3


def test_integrals_and_events_have_no_formula():
    assert (ENERGY.symbol, ENERGY.meaning, ENERGY.is_energy) == ("H", "total energy", True)
    with pytest.raises(ValueError, match=r"^energy must have its forces to be computed, got none in the file\."):
        ENERGY.value(START)
    event = RecordedEvent("flip", "SpinFlip(axis=[0, 0, 1])", terminal=True)
    assert (event.kind, repr(event), event.terminal) == ("flip", "SpinFlip(axis=[0, 0, 1])", True)
    with pytest.raises(ValueError, match=r"^flip must have its formula to be computed, got none in the store\.$"):
        event.value(pt.System(pt.Body((1.0, 1.5, 2.0))).at(members_of(START, 0)))
