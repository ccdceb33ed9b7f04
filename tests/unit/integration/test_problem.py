"""A system and the events to watch for, side by side."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration.problem import Problem
from poinsot.mechanics.force import Force

BODY = pt.Body((1.25, 1.0, 0.75))
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.1)


def position(times):
    return np.stack(ORBIT.position_at(times), axis=-1)


def crossing(members=()):
    return pt.events.AxisCrossing((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), angle=np.full(members, 0.3))


def test_an_event_is_no_force():
    assert not isinstance(crossing(), Force)
    with pytest.raises(TypeError, match=r"^a force must be a Potential, a Torque or a Part, got AxisCrossing\.$"):
        pt.System(BODY, crossing())


def test_numbers_orbits_and_members_are_those_of_both():
    system = pt.System(BODY, pt.forces.LinearDamping(0.1))
    problem: Any = Problem(system, [crossing((4,)), pt.events.Apsis(ORBIT)])
    assert len(problem.numbers) == len(system.dynamics.numbers) + 7 + len(ORBIT.numbers)
    assert (system.members, problem.members) == ((), (4,))
    copied = problem.with_numbers(iter(range(100, 200)))
    assert list(copied.dynamics.body.moments) == [100, 101, 102]
    assert (copied.dynamics.forces[0].coefficient, copied.events[0].angle) == (103, 110)
    assert (problem.system, problem.events[1].orbit) == (system, ORBIT)


def test_orbits_of_events_must_share_the_axes_of_the_system():
    here, dated = (
        pt.orbits.Ephemeris.from_function(1.0, position=position, start=0.0, stop=1.0, reference_frame=name)
        for name in ("ICRF", "TEME")
    )
    system = pt.System(BODY, pt.GravityGradient(here))
    with pytest.raises(ValueError, match=r"^the orbits of a system must have one reference frame, got ICRF and TEME"):
        Problem(system, [pt.events.Apsis(dated)])


class Wide(pt.Event):
    """An event whose formulas give three components where asked."""

    what: str

    def value(self, instant):
        return instant.omega_body if self.what == "value" else instant.omega_body[0]

    def condition(self, instant):
        return instant.omega_body if self.what == "condition" else 1.0


@pytest.mark.parametrize("what", ["value", "condition"])
def test_formulas_of_events_are_tried(what):
    with pytest.raises(TypeError, match=rf"^the {what} of Wide must be one scalar, got 3 components\.$"):
        pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [1.0], events=[Wide(what)])
