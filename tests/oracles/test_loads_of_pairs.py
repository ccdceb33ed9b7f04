"""Force and torque on each of two bodies made of points of mass, against a sum over all pairs of points."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

G = 0.8
FIRST = np.array([1.0, 2.0, 1.5, 0.5]), np.array([(1.0, 0.2, 0), (-0.3, 0.6, 0.1), (0, -0.9, 0.4), (-0.8, 0.7, -1.6)])
SECOND = np.array([0.4, 0.3, 0.5, 0.2]), np.array([(0.5, 0, 0.1), (0, 0.4, -0.3), (-0.4, -0.2, 0), (0.3, 0.1, 0.6)])
MEMBERS = {"one pair": (), "as many members as axes": (3,), "five members": (5,)}


def centred(masses, places):
    return masses, places - masses @ places / masses.sum()


def summed(r, first, second):
    """Force on the second body and both torques about the centres of mass, space axes, by Newton's law."""
    (m, x), (n, y) = centred(*FIRST), centred(*SECOND)
    x, y = first.apply(x), second.apply(y)
    way = r + y[None] - x[:, None]
    pull = -G * m[:, None, None] * n[None, :, None] * way / np.linalg.norm(way, axis=-1, keepdims=True) ** 3
    return pull.sum((0, 1)), np.cross(x, -pull.sum(1)).sum(0), np.cross(y, pull.sum(0)).sum(0)


def pair() -> Any:
    bodies = [pt.Body.from_point_masses(*masses) for masses in (FIRST, SECOND)]
    gravity = pt.forces.MutualMascons(*centred(*FIRST), *centred(*SECOND))
    return pt.System(pt.TwoBodies(*bodies, G=G), gravity, pt.forces.LinearDamping(0.1).on("secondary"))


@pytest.mark.parametrize("name", MEMBERS)
def test_loads_are_those_of_the_points(name, rng):
    shape = MEMBERS[name]
    turns = [Rotation.random(*shape, rng=rng) for _ in range(2)]
    r = np.array([4.0, -1.0, 2.0]) + rng.uniform(-0.5, 0.5, (*shape, 3))
    system, times = pair(), np.array([0.0, 0.3, 0.7])
    spins = [(0.1, 0.2, 0.3), (0.3, -0.2, 0.1)]
    attitudes = [turn.as_quat(scalar_first=True) for turn in turns]
    state: Any = system.state(r, np.broadcast_to((0.1, 0.3, -0.2), r.shape), attitudes, omega_body=spins)
    motion: Any = pt.propagate(system, state, times)
    bodies = {"primary": motion.primary, "secondary": motion.secondary}
    for index in np.ndindex(*shape, times.size):
        turned = [Rotation.from_quat(one.quaternion[index], scalar_first=True) for one in bodies.values()]
        force, *torques = summed(motion.position[index], *turned)
        # rounding of 16 pairs whose sum is the size of the force
        assert np.allclose(motion.secondary.forces_space["MutualMascons"][index], force, rtol=0, atol=1e-14)
        for one, turn, torque in zip(bodies.values(), turned, torques, strict=True):
            found = turn.apply(one.torques_body["MutualMascons"][index])
            assert np.linalg.norm(torque) > 1e-3
            assert np.allclose(found, torque, rtol=0, atol=1e-14)
    damping = motion.secondary.torques_body["LinearDamping"]
    assert np.allclose(damping, -0.1 * motion.secondary.omega_body, rtol=0, atol=1e-16)
    assert not np.any(motion.primary.torques_body["LinearDamping"])


@pytest.mark.parametrize("name", MEMBERS)
def test_forces_are_opposite_and_torques_balance(name, rng):
    """F1 + F2 = 0 and r x F2 + tau1 + tau2 = 0 for forces between the two bodies, at a state and along a motion."""
    shape = MEMBERS[name]
    system: Any = pt.System(pair().body, pair().forces[0])
    attitudes = [Rotation.random(*shape, rng=rng).as_quat(scalar_first=True) for _ in range(2)]
    r = np.array([4.0, -1.0, 2.0]) + rng.uniform(-0.5, 0.5, (*shape, 3))
    state: Any = system.state(r, np.zeros(r.shape), attitudes, omega_body=[(0.1, 0.2, 0.3), (0.3, -0.2, 0.1)])
    forces = [system.force_space(state, body=body) for body in ("primary", "secondary")]
    assert np.array_equal(forces[0], -forces[1])
    torques = [
        one.attitude.apply(system.torque_body(state, body=body))
        for body, one in (("primary", state.primary), ("secondary", state.secondary))
    ]
    balance = np.cross(r, forces[1]) + torques[0] + torques[1]
    assert np.max(np.abs(balance)) < 2e-15 * np.max(np.abs(np.cross(r, forces[1]))) + 1e-15


def test_selected_times_and_members_have_their_own_loads(rng):
    system = pair()
    attitudes = [Rotation.random(4, rng=rng).as_quat(scalar_first=True) for _ in range(2)]
    state: Any = system.state(
        (4.0, -1.0, 2.0), (0.1, 0.3, -0.2), attitudes, omega_body=[(0.1, 0.2, 0.3), (0.3, -0.2, 0.1)]
    )
    motion: Any = pt.propagate(system, state, [0.0, 0.3, 0.7])
    whole = motion.secondary.torques_body["MutualMascons"]
    assert np.array_equal(motion.secondary.isel(time=[0, 2]).torques_body["MutualMascons"], whole[:, [0, 2]])
    assert np.array_equal(motion.member(1).secondary.torques_body["MutualMascons"], whole[1])
    assert np.array_equal(motion.secondary.member(1).torques_body["MutualMascons"], whole[1])


@pytest.mark.parametrize("name", ["omega_body", "torque_body", "torques_body", "force_space", "forces_space"])
def test_a_load_needs_the_name_of_the_body(name):
    system = pair()
    state: Any = system.state((4.0, -1.0, 2.0), (0, 0, 0), ((1, 0, 0, 0),) * 2, omega_body=[(0.1, 0.2, 0.3)] * 2)
    for wrong in ({}, {"body": "third"}):
        with pytest.raises(ValueError, match=r"^body must be 'primary' or 'secondary', got ") as caught:
            getattr(system, name)(state, **wrong)
        assert str(caught.value).endswith(f"got {wrong.get('body')!r}.")


class Drag(pt.mechanics.PairLoad):
    """A force of the user's own, whose formula no file contains."""

    friction: float

    def load(self, instant):
        nothing = pt.functions.Vector((0.0, 0.0, 0.0))
        return pt.mechanics.Load(-self.friction * instant.relative_velocity, (nothing, nothing))


@pytest.mark.parametrize("known", [True, False])
def test_a_file_gives_the_loads_of_forces_that_it_contains(tmp_path, known):
    system = pair() if known else pt.System(pair().body, *pair().forces, Drag(0.1))
    start = system.state((4.0, -1, 2), (0, 0, 0.1), ((1, 0, 0, 0),) * 2, omega_body=[(0, 0, 1)] * 2)
    motion: Any = pt.propagate(system, start, [0.0, 1.0])
    pt.save(motion, tmp_path / "pair.nc")
    back: Any = pt.load(tmp_path / "pair.nc")
    for name in ("torques_body", "forces_space"):
        expected = getattr(motion.primary, name) if known else {}
        found = getattr(back.primary, name)
        assert found.keys() == expected.keys()
        assert all(np.array_equal(found[force], values) for force, values in expected.items())
