"""Formulas of forces on named symbols, and the plain data of the table of a system."""

import numpy as np

import poinsot as pt
from poinsot.display.formulas import StatedFormula, TracedFormula, equations
from poinsot.display.notation import LATEX
from poinsot.systems.symbolic_formula import formula_of, stated_formula, summary_of_system

BODY = pt.Body((1.25, 1.0, 0.75))
NEAR, FAR = (pt.orbits.FixedPosition(1.0, position=(0, 0, distance)) for distance in (2.0, 3.0))


class Pull(pt.Potential):
    """An energy of the place, the time and the inertia."""

    strength: float
    orbit: pt.Orbit

    def energy(self, instant):
        height = instant.attitude.to_body(instant.environment.position(self.orbit))[2]
        return (
            self.strength
            * height
            * instant.time
            * instant.body.moments[0]
            / instant.environment.inverse_distance(self.orbit)
        )


class Spin(pt.Torque):
    """A torque of the rates."""

    axis: pt.BodyVector

    def torque(self, instant):
        return pt.functions.cross(self.axis, instant.omega_body)


def test_a_potential_is_traced_with_the_names_of_its_parameters():
    found = formula_of(Pull(0.5, FAR), BODY, [NEAR, FAR])
    assert isinstance(found, TracedFormula)
    assert found.letter == "U"
    (text,) = equations(found, LATEX)
    assert set(text.removeprefix("U = ").split(r"\,")) == {r"\mathrm{strength}", "x'_{3}", "t", "I_{1}", "r'"}


def test_a_torque_is_traced_by_its_components():
    found = formula_of(Spin((0, 0, 1)), BODY, [])
    assert isinstance(found, TracedFormula)
    assert (found.letter, len(found.components)) == ("N", 3)
    assert equations(found, LATEX)[0].startswith(
        r"N = \left(\mathrm{axis}_{2}\,\omega_{3} - \mathrm{axis}_{3}\,\omega_{2}, "
    )


def test_a_stated_formula_is_the_formula_of_its_class():
    gravity = pt.GravityGradient(FAR)
    assert formula_of(gravity, BODY, [NEAR, FAR]) == StatedFormula(stated_formula(pt.GravityGradient), 1)
    assert formula_of(gravity, BODY, [FAR]) == StatedFormula(stated_formula(pt.GravityGradient), 0)


def test_a_derived_class_states_no_formula_of_its_base():
    class Halved(pt.forces.LinearDamping):
        def torque(self, instant):
            return super().torque(instant) * 0.5

    assert stated_formula(pt.forces.LinearDamping)
    assert stated_formula(Halved) == ""
    assert stated_formula(Spin) == ""


def test_code_that_needs_numbers_has_no_formula():
    class Table(pt.Torque):
        def torque(self, instant):
            return [np.interp(float(instant.time), [0, 1], [0, 1])] * 3

    assert formula_of(Table(), BODY, []) is None


def test_a_part_without_a_stated_formula_has_none():
    class Idle(pt.Part):
        def rates(self, *_):
            return ()

    assert formula_of(Idle(), BODY, []) is None


def test_the_summary_of_a_system():
    units = {"time": "s", "inertia": "kg m2"}
    system = pt.System(BODY, Spin((0, 0, 1)), pt.GravityGradient(NEAR), units=units)
    found = summary_of_system(system.body, system.forces, system.units, system.integrals)
    assert "omega = I**-1*g" in found.motion
    assert "kg m2" in found.body
    assert [force.kind for force in found.forces] == ["Spin", "GravityGradient"]
    assert found.forces[0].description == "A torque of the rates."
    assert "\n" not in found.forces[1].description
    assert "Parameters" not in found.forces[1].description
    assert not found.two_bodies
    assert len(found.conserved) == len(system.integrals)


def test_parts_separate_the_rate_from_the_momentum():
    system = pt.System(BODY, pt.parts.Gyrostat((0, 0, 0.5)))
    found = summary_of_system(system.body, system.forces, system.units, system.integrals)
    assert found.motion.endswith("+ N")


def test_two_bodies_have_no_equations_of_motion_of_one_body():
    system = pt.System(pt.TwoBodies(BODY, BODY, masses=(1.0, 1.0)))
    found = summary_of_system(system.body, system.forces, system.units, system.integrals)
    assert (found.motion, found.two_bodies) == ("", True)
