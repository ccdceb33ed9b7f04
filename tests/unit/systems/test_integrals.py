"""What a system conserves, found from its formulas."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions

TRIAXIAL, SYMMETRIC, SPHERE = pt.Body((1.25, 1.0, 0.75)), pt.Body((1.0, 1.0, 0.7)), pt.Body((1.0, 1.0, 1.0))
SPACE = ["angular_momentum_space_1", "angular_momentum_space_2", "angular_momentum_space_3"]
CIRCLE = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1)
ELLIPSE = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.3, inclination=0.4, node=1.1)
POLE = pt.orbits.FixedPosition(1.0, position=(0, 0, 2.0))
ASIDE = pt.orbits.FixedPosition(1.0, position=(1.0, 2.0, 2.0))
UP = pt.UniformGravity(0.5, (0, 0, 1))

CASES = {
    "free": (TRIAXIAL, (), ["energy", *SPACE]),
    "free_symmetric": (SYMMETRIC, (), ["energy", *SPACE, "angular_momentum_body_3"]),
    "free_sphere": (SPHERE, (), ["energy", *SPACE, *(f"angular_momentum_body_{k}" for k in (1, 2, 3))]),
    "top": (TRIAXIAL, (pt.UniformGravity(0.5, (1, 0, 0)),), ["energy", SPACE[2]]),
    "lagrange_top": (SYMMETRIC, (UP,), ["energy", SPACE[2], "angular_momentum_body_3"]),
    "symmetric_but_not_about_the_arm": (SYMMETRIC, (pt.UniformGravity(0.5, (1, 0, 0)),), ["energy", SPACE[2]]),
    "pole": (TRIAXIAL, (pt.GravityGradient(POLE),), ["energy", SPACE[2]]),
    "aside": (TRIAXIAL, (pt.GravityGradient(ASIDE),), ["energy", "angular_momentum_space_attractor"]),
    "circular_orbit": (TRIAXIAL, (pt.GravityGradient(CIRCLE),), ["jacobi_energy"]),
    "elliptic_orbit": (TRIAXIAL, (pt.GravityGradient(ELLIPSE),), []),
    "symmetric_on_an_ellipse": (SYMMETRIC, (pt.GravityGradient(ELLIPSE),), ["angular_momentum_body_3"]),
    "damped": (TRIAXIAL, (pt.forces.LinearDamping(0.1),), []),
    "damped_symmetric": (SYMMETRIC, (pt.forces.LinearDamping(0.1),), []),
}


def names(body, forces):
    return [integral.name for integral in pt.System(body, *forces).integrals]


@pytest.mark.parametrize("case", CASES)
def test_integrals_by_name(case):
    body, forces, expected = CASES[case]
    assert names(body, forces) == expected


@pytest.mark.parametrize("case", [case for case, (_, _, expected) in CASES.items() if expected])
def test_integrals_stay_on_the_way(case):
    body, forces, expected = CASES[case]
    start = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    motion = pt.propagate(pt.System(body, *forces), start, np.linspace(0, 10, 21))
    assert list(motion.drift) == expected
    assert max(np.max(np.abs(drift)) for drift in motion.drift.values()) < 5e-14


@pytest.mark.parametrize("name", ["angular_momentum_space_1", "angular_momentum_space_2"])
def test_what_is_not_conserved_does_move(name):
    start = TRIAXIAL.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    motion = pt.propagate(pt.System(TRIAXIAL, pt.UniformGravity(0.5, (1, 0, 0))), start, [0.0, 3.0])
    component = motion.angular_momentum_space[:, int(name[-1]) - 1]
    assert abs(component[1] - component[0]) > 1e-2


def test_values_of_the_integrals():
    state = TRIAXIAL.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    free = {integral.name: integral.value(state) for integral in pt.System(TRIAXIAL).integrals}
    assert free["energy"] == pytest.approx(pt.System(TRIAXIAL).energy(state), rel=1e-15, abs=0)
    assert [free[name] for name in SPACE] == pytest.approx(state.angular_momentum_space.tolist(), abs=1e-15)


def test_value_of_the_jacobi_energy():
    system = pt.System(TRIAXIAL, pt.GravityGradient(CIRCLE))
    state = TRIAXIAL.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    rate = np.sqrt(2.0 / 1.5**3) * np.array([np.sin(0.4) * np.sin(1.1), -np.sin(0.4) * np.cos(1.1), np.cos(0.4)])
    expected = system.energy(state) - rate @ state.angular_momentum_space
    assert system.integrals[0].value(state) == pytest.approx(expected, rel=1e-14, abs=0)


def test_energies_are_marked():
    kinds = {integral.name: integral.is_energy for integral in pt.System(SYMMETRIC, UP).integrals}
    assert kinds == {"energy": True, "angular_momentum_space_3": False, "angular_momentum_body_3": False}


def test_a_users_potential_that_depends_on_time_loses_its_energy():
    class Growing(pt.Potential):
        rate: float

        def energy(self, instant):
            return self.rate * instant.time * instant.attitude.to_body((0, 0, 1))[0]

    assert names(TRIAXIAL, (Growing(0.5),)) == ["angular_momentum_space_3"]
    assert names(TRIAXIAL, (Growing(0.0),)) == ["energy", *SPACE]


def test_a_torque_along_a_space_axis_spares_the_others():
    class Steady(pt.Torque):
        size: float

        def torque(self, instant):
            return instant.attitude.to_body((0, 0, self.size))

    assert names(TRIAXIAL, (Steady(0.5),)) == SPACE[:2]


class Pulsating(pt.Potential):
    """A potential whose strength repeats often."""

    def energy(self, instant):
        return (1 + 0.5 * functions.cos(2 * np.pi * 10 * instant.time)) * instant.attitude.to_body((0, 0, 1))[0]


class Switched(pt.Potential):
    """A potential that appears at a time."""

    def energy(self, instant):
        return functions.where(functions.less(2, instant.time), 1.0, 0.0) * instant.attitude.to_body((0, 0, 1))[0]


@pytest.mark.parametrize("force", [Pulsating(), Switched()], ids=["pulsating", "switched"])
def test_what_changes_with_time_or_appears_late_is_seen(force):
    names = {integral.name for integral in pt.System(pt.Body((1.0, 1.2, 1.5)), force).integrals}
    assert not names & {"angular_momentum_space_1", "angular_momentum_space_2"}
    assert "angular_momentum_space_3" in names
    assert "energy" not in names


class Switching(pt.Torque):
    """A torque where a body axis points near one of space, or where the body spins fast."""

    fast: float

    def torque(self, instant):
        near = functions.less(0.9999, instant.attitude.to_body((0, 0, 1))[2])
        fast = functions.less(self.fast, functions.norm(instant.omega_body))
        return -(functions.where(near, 0.1, 0.0) + functions.where(fast, 0.1, 0.0)) * instant.omega_body


class Stop(pt.Potential):
    """A spring beyond an angle."""

    def energy(self, instant):
        beyond = instant.attitude.to_body((0, 0, 1))[2] - 0.9999
        return functions.where(functions.less(0, beyond), beyond * beyond, 0.0)


def test_what_acts_in_few_attitudes_or_at_high_rates_is_seen():
    assert names(pt.Body((1.0, 1.2, 1.5)), (Switching(100.0),)) == []
    assert names(pt.Body((1.0, 1.2, 1.5)), (Stop(),)) == ["energy", "angular_momentum_space_3"]


def test_the_symmetry_axis_of_a_body_in_other_axes():
    turn = Rotation.from_rotvec((0.3, -0.4, 0.2)).as_matrix()
    body = pt.Body.from_inertia(turn @ np.diag([1, 1, 0.5]) @ turn.T)
    system = pt.System(body)
    (name,) = {integral.name for integral in system.integrals if "body" in integral.name}
    assert name == "angular_momentum_body_principal_3"
    motion = pt.propagate(system, body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 20.0])
    assert np.max(np.abs(motion.drift[name])) < 1e-14
