"""A system integrated along its orbit moves as it does along space, and only where its formulas allow it."""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3))
TIMES = np.linspace(0, 5, 6)


def orbit(inclination=0.5, **others):
    return pt.KeplerOrbit(
        1.0,
        semimajor_axis=1.0,
        eccentricity=0.1,
        inclination=inclination,
        node=0.3,
        argument_of_periapsis=0.2,
        **others,
    )


class Offset(pt.Potential):
    """A spring from a point of the body to a point on the way to the attractor: covariant by sums and lengths."""

    orbit: pt.Orbit
    arm: pt.mechanics.Vector

    def energy(self, instant):
        way = instant.position(self.orbit) * 0.5 + instant.attitude.to_space(self.arm)
        wind = fn.cross(instant.position(self.orbit), instant.velocity(self.orbit))
        return 0.1 * fn.dot(way, way) + 0.05 * instant.attitude.to_body(wind / fn.norm(wind))[0] ** 2


class Polar(pt.Potential):
    """Looks at one component of the position in space."""

    orbit: pt.Orbit

    def energy(self, instant):
        return 0.3 * instant.position(self.orbit)[2] * instant.attitude.to_body(instant.direction(self.orbit))[0]


class Field(pt.Potential):
    """A huge part that does not turn the body, together with a small one along a direction fixed in space."""

    orbit: pt.Orbit
    field_space: pt.mechanics.Vector

    def energy(self, instant):
        return instant.attitude.to_body(self.field_space)[0] - 1e9 * instant.inverse_distance(self.orbit)


class Drag(pt.Torque):
    """Along the velocity, with a direction that is summed with one fixed in space."""

    orbit: pt.Orbit
    wind_space: pt.mechanics.Vector

    def torque(self, instant):
        return 0.1 * instant.attitude.to_body(instant.velocity(self.orbit) + self.wind_space)


class Beacon(pt.Torque):
    """Along the direction from a place that is no field: an orbit that only the formula knows."""

    size: float

    def torque(self, instant):
        place = pt.orbits.FixedPosition(1.0, position=(3.0, -2.0, 1.0))
        return self.size * instant.attitude.to_body(instant.direction(place))


def comoving(system):
    return equations.state_vector(Problem(system), START, FORMULATIONS["lie_poisson"], "double").comoving


CASES = {
    "gravity gradient": (lambda o: [pt.GravityGradient(o)], True),
    "with damping": (lambda o: [pt.GravityGradient(o), pt.forces.LinearDamping(0.1)], True),
    "sums, lengths, products": (lambda o: [Offset(o, (0.1, 0.2, 0.3))], True),
    "with gravity along space": (lambda o: [pt.GravityGradient(o), pt.UniformGravity(0.3, (1, 0, 0))], False),
    "a component in space": (lambda o: [Polar(o)], False),
    "a small fixed field": (lambda o: [Field(o, (0, 0, 1e-2))], False),
    "a sum with a fixed vector": (lambda o: [Drag(o, (0, 0, 1))], False),
    "an orbit in a formula": (lambda o: [pt.GravityGradient(o), Beacon(0.1)], False),
    "two orbits": (lambda o: [pt.GravityGradient(o), pt.GravityGradient(orbit(0.1))], False),
}


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@pytest.mark.parametrize("name", CASES)
def test_comoving_or_not_the_motion_is_the_same(name, formulation):
    forces, expected = CASES[name]
    system = pt.System(BODY, *forces(orbit(epoch=0.3, true_anomaly=2.0)))
    assert comoving(system) == expected
    motion = pt.propagate(system, START, TIMES, formulation=formulation)
    reference = pt.propagate(system, START, TIMES, formulation=formulation, precision="quadruple")
    # Here and below: at least three times the worst of shaken starts.
    np.testing.assert_allclose(motion.quaternion, reference.quaternion, rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.conjugate_momenta, reference.conjugate_momenta, rtol=0, atol=4e-14)


@pytest.mark.parametrize("inclination", [0.0, 1e-16, 1e-13, 2 * np.pi])
def test_the_choice_does_not_depend_on_numbers_seen_before(inclination):
    def run(tilt):
        system = pt.System(BODY, pt.GravityGradient(orbit(tilt)), pt.UniformGravity(0.3, (1, 0, 0)))
        return pt.propagate(system, START, TIMES)

    run(inclination)
    reference = pt.propagate(run(0.5).system, START, TIMES, precision="quadruple")
    np.testing.assert_allclose(run(0.5).quaternion, reference.quaternion, rtol=0, atol=3e-15)


def test_members_with_and_without_a_force_fixed_in_space():
    weights = np.linspace(0, 0.3, 3)

    def system(i):
        return pt.System(BODY, pt.GravityGradient(orbit()), pt.UniformGravity(weights[i], (1, 0, 0)))

    motion = pt.propagate(system(slice(None)), START, TIMES)
    for i in range(3):
        alone = pt.propagate(system(i), START, TIMES, precision="quadruple")
        np.testing.assert_allclose(motion.quaternion[i], alone.quaternion, rtol=0, atol=8e-15)
