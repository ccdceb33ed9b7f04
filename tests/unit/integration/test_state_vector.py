"""The slots of a kernel's variables: every variable in one, and a state in and out of them."""

import dataclasses

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem
from poinsot.integration.variational import Variations

BODY = pt.Body((6.0, 8.0, 10.0))
MEMBERS = pt.Body([(6.0, 8.0, 10.0), (6.5, 8.0, 9.0)])
ELLIPSE = pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.2, eccentricity=0.3, inclination=0.4, node=0.2))
FLYBY = pt.GravityGradient(pt.orbits.EscapeOrbit(1.0, periapsis_distance=0.8, eccentricity=1.5))
WEIGHT = pt.UniformGravity(0.3, (1, 0, 0))
WHEEL, DAMPER = pt.parts.ReactionWheel((0.6, 0, 0.8), 0.1), pt.parts.KaneDamper(0.4, 0.1)
SYSTEMS = {
    "rigid": (pt.System(BODY, WEIGHT), {}, False),
    "comoving": (pt.System(BODY, ELLIPSE), {"orbits[0]": 1}, True),
    "one path": (pt.System(BODY, FLYBY, FLYBY, WEIGHT), {"orbits[0]": 1}, False),
    "closed form": (pt.System(BODY, ELLIPSE, WEIGHT), {}, False),
    "parts": (pt.System(BODY, WHEEL, DAMPER), {"reaction_wheel": 1, "kane_damper": 3}, False),
    "parts and orbits": (pt.System(MEMBERS, WHEEL, FLYBY, WEIGHT), {"reaction_wheel": 1, "orbits[0]": 1}, False),
}
each = pytest.mark.parametrize("name", SYSTEMS)
charts = pytest.mark.parametrize("chart", ["lie_poisson", "canonical"])


def started(system):
    at_rest = system.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.4, -0.9, 0.3), time=0.7).own
    own = {part: values + 0.1 for part, values in at_rest.items()}
    state = system.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.4, -0.9, 0.3), time=0.7, **own)
    return pt.State(state.quaternion, state.conjugate_momenta, 0.7 + np.zeros(system.members), own=state.own)


def variables_of(name, chart):
    system, *_ = SYSTEMS[name]
    return equations.state_vector(Problem(system), started(system), FORMULATIONS[chart], "double"), started(system)


@charts
@each
def test_every_variable_is_in_one_slot(name, chart):
    variables, _ = variables_of(name, chart)
    _, slots, comoving = SYSTEMS[name]
    assert variables.comoving == comoving
    tangent = Variations((False,) * 3 + (True,) * 3, 2, initial=np.eye(6)[:2])
    for full in (variables, dataclasses.replace(variables, variations=tangent)):
        places = [np.arange(full.size)[slot.place] for slot in full.slots.values()]
        assert np.array_equal(np.concatenate(places), np.arange(full.size))
        assert all(len(slot.factors) == len(place) for slot, place in zip(full.slots.values(), places, strict=True))
    assert {key: len(slot.factors) for key, slot in list(variables.slots.items())[1:]} == slots


@charts
@each
def test_a_state_comes_back_from_its_variables(name, chart):
    variables, state = variables_of(name, chart)
    rows = variables.from_state(state)
    back = variables.to_phase(np.reshape(state.time, (-1, 1))[0], rows[..., None, :])
    expected = variables.formulation.to_phase(variables.formulation.from_state(state)) | state.own
    assert list(back) == list(expected) == list(variables.sizes)
    for key, values in back.items():  # two products of unit quaternions: four roundings of each component
        np.testing.assert_allclose(
            values[..., 0, :], expected[key], rtol=0, atol=8 * np.max(np.abs(expected[key])) * 2e-16
        )


@each
def test_a_state_takes_the_place_of_another_next_to_the_orbits(name):
    variables, state = variables_of(name, "lie_poisson")
    if variables.of_one:
        row = variables.from_state(state)
        packed = variables.with_state(row, state, state.time)
        np.testing.assert_allclose(packed, row[: variables.along_orbits.start], rtol=0, atol=1e-15)
