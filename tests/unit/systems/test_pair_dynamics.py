"""Two bodies: their states, the forces on them, and what a system of them refuses."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration.scaling import orbital_rate

fn = pt.functions
FIRST, SECOND = pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5)
PAIR = pt.TwoBodies(FIRST, SECOND, G=1.0)
SPHERE = pt.Body((1.0, 1.0, 1.0), mass=3.0)
TURNS = [np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]
SUN = pt.KeplerOrbit(1.0, semimajor_axis=100.0, eccentricity=0.1)
SYSTEM = pt.System(PAIR, pt.forces.MutualGravity())
START: Any = PAIR.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=[(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)])


class Magnet(pt.Potential):
    moment: pt.BodyVector
    field: pt.SpaceVector

    def energy(self, instant):
        return -fn.dot(self.moment, instant.attitude.to_body(self.field))


class Fast(pt.Potential):
    def energy(self, instant):
        return fn.norm(instant.relative_velocity)


class Friction(pt.mechanics.PairLoad):
    coefficient: float

    def load(self, instant):
        push = -self.coefficient * instant.relative_velocity
        nothing = fn.Vector((0.0, 0.0, 0.0))
        return pt.mechanics.Load(push, (-self.coefficient * instant.primary.omega_body, nothing))


def test_a_state_keeps_what_it_was_given():
    assert np.array_equal(START.position, (6, 1, 2))
    assert np.allclose(START.momentum, 3 * 0.5 / 3.5 * np.array((-0.1, 0.6, 0.3)), rtol=1e-15, atol=0)
    assert np.array_equal(START.primary.quaternion, TURNS[0])
    assert np.array_equal(START.secondary.angular_momentum_body, np.array((0.1, 0.12, 0.15)) * (0, 0.1, 0.4))


def test_at_their_pace_spheres_are_held_on_a_circle():
    system: Any = pt.System(pt.TwoBodies(SPHERE, SPHERE, G=0.7), pt.forces.MutualGravity())
    force, distance = system.dynamics.load_at(system.at(START)).force, np.linalg.norm(START.position)
    held = system.body.reduced_mass * orbital_rate(system.dynamics, START) ** 2 * distance
    assert np.linalg.norm(list(force)) == pytest.approx(held, rel=1e-14, abs=0)


def test_the_force_and_the_torques_are_slopes_of_the_energy():
    system: Any = pt.System(PAIR, pt.forces.MutualGravity())
    h = 1e-5
    load = system.dynamics.load_at(system.at(START))

    def energy(position=(0, 0, 0), turns=((0, 0, 0), (0, 0, 0))):
        unit = [np.array((1, *np.multiply(0.5, turn))) for turn in turns]
        small = [pt.State(q / np.linalg.norm(q), (0,) * 4) for q in unit]
        turned = [
            (each.attitude * one.attitude).as_quat(scalar_first=True)
            for each, one in zip((START.primary, START.secondary), small, strict=True)
        ]
        moved = PAIR.state(START.position + position, (0, 0, 0), turned, omega_body=[(0, 0, 0)] * 2)
        return system.potential_energy(moved)

    for i in range(3):
        step = h * np.eye(3)[i]
        slopes = [
            -(energy(position=step) - energy(position=-step)) / (2 * h),
            -(energy(turns=(step, 0 * step)) - energy(turns=(-step, 0 * step))) / (2 * h),
            -(energy(turns=(0 * step, step)) - energy(turns=(0 * step, -step))) / (2 * h),
        ]
        # differences leave a third of the step squared and a rounding of the energy over the step
        assert np.allclose([load.force[i], load.torques[0][i], load.torques[1][i]], slopes, rtol=0, atol=3e-10)


def test_a_force_on_one_of_two_bodies():
    magnet, field = Magnet((0.1, 0.0, 0.2), (0.0, 0.3, 0.0)), [np.zeros(3), np.zeros(3)]
    for number, body in enumerate(("primary", "secondary")):
        pair_load: Any = pt.System(PAIR, magnet.on(body))
        load = pair_load.dynamics.load_at(pair_load.at(START))
        alone = (FIRST, SECOND)[number]
        state = (START.primary, START.secondary)[number]
        field[number] = pt.System(alone, magnet).torque_body(state)
        assert np.allclose(np.stack(load.torques), field, rtol=0, atol=1e-16)
        assert not np.any(list(load.force))
        field[number] = np.zeros(3)


@pytest.mark.parametrize("force", [(), (Magnet((0.1, 0.0, 0.2), (0.0, 0.3, 0.0)).on("primary"),)])
def test_two_bodies_without_attraction_move_on_a_straight_line_with_a_warning(force):
    system, times = pt.System(PAIR, *force), np.linspace(0, 5, 6)
    with pytest.warns(UserWarning, match=r"^system should have a force between its two bodies, got (none|Mag.*'\))\. "):
        motion: Any = pt.propagate(system, START, times)
    straight = START.position + times[:, None] * START.momentum / PAIR.reduced_mass
    assert np.allclose(motion.position, straight, rtol=0, atol=1e-14)


def test_a_load_without_potential_takes_energy():
    system = pt.System(PAIR, pt.forces.MutualGravity(), Friction(0.01))
    assert system.integrals == ()
    motion = pt.propagate(system, START, np.linspace(0, 5, 6))
    assert np.all(np.diff(motion.energy) < 0)


def test_ensembles_of_pairs_are_their_members():
    pair = pt.TwoBodies(FIRST, pt.Body((0.1, 0.12, 0.15), mass=np.linspace(0.4, 0.6, 5)), G=1.0)
    start = pair.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=[(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)])
    motions: Any = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, 30, 4))
    for i, mass in enumerate(np.linspace(0.4, 0.6, 5)):
        alone = pt.TwoBodies(FIRST, pt.Body((0.1, 0.12, 0.15), mass=mass), G=1.0)
        one = alone.state((6.0, 1.0, 2.0), (-0.1, 0.6, 0.3), TURNS, omega_body=[(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)])
        motion: Any = pt.propagate(pt.System(alone, pt.forces.MutualGravity()), one, np.linspace(0, 30, 4))
        member = motions.member(i)
        assert np.max(np.abs(member.position - motion.position)) < 1e-12
        assert np.max(np.abs(member.secondary.quaternion - motion.secondary.quaternion)) < 1e-12


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: pt.TwoBodies(pt.Body((1, 1, 1)), SECOND), r"primary must have a mass, got Body.*Give it one"),
        (lambda: pt.TwoBodies(FIRST, SECOND, masses=(1, -1)), r"masses must be positive, got \[1.0, -1.0\]"),
        (lambda: pt.System(PAIR, Magnet((1, 0, 0), (0, 0, 1))), r"two bodies has no attitude"),
        (lambda: pt.System(PAIR, pt.forces.LinearDamping(0.1)), r'Write force\.on\("primary"\)'),
        (lambda: pt.System(FIRST, pt.forces.MutualGravity()), r"MutualGravity must act between TwoBodies"),
        (lambda: pt.System(FIRST, Magnet((1, 0, 0), (0, 0, 1)).on("primary")), r"without `on`"),
        (lambda: Magnet((1, 0, 0), (0, 0, 1)).on("moon"), r"body must be 'primary' or 'secondary', got 'moon'"),
        (lambda: pt.GravityGradient(SUN).on("primary"), r"GravityGradient must be for one body, .* ThirdBody\(orbit\)"),
        (lambda: pt.System(PAIR, Fast()), r"got a velocity or momentum. Write Fast as a PairLoad"),
        (lambda: pt.propagate(SYSTEM, START, [1.0], formulation="planar"), r"'planar' must be for one body, got two"),
        (lambda: START.quaternion, r"no quaternion\. Read primary\.quaternion or secondary\.quaternion"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises((TypeError, ValueError, AttributeError), match=sentence):
        make()
