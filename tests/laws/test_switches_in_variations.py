"""Tangent vectors pass every kind of switch, of every kind of system, both ways of time and on either kernel.

They are judged by differences of motions without variations, whose switches are judged in `test_both_kernels.py`.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions as fn
from poinsot.functions import Vector
from poinsot.kinematics.state import changed, state_of

END = 3.0
LEVELS = {"time": 1.1, "attitude": 0.3, "rate": 0.45, "clip": 0.2, "sign": 0.1}
BODY, SECOND = pt.Body((1.0, 1.3, 1.7)), pt.Body((0.1, 0.12, 0.15), mass=0.5)
PAIR = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), SECOND, G=1.0)
ATTITUDES = Rotation.from_quat([(0.1, 0.7, -0.5, 0.5), (0.5, 0.5, -0.5, 0.5)], scalar_first=True)
WHEEL = pt.parts.ReactionWheel((0.6, 0.0, 0.8), 0.1, 0.02)
WEIGHTS = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Of central differences that leave out the seventh power of the step."""
STEP = 1e-3
SIZES = {"one": 0.5, "part": 0.5, "pair": 0.1}


class Time(pt.Torque):
    """A torque between a time and the opposite one."""

    level: float
    size: float

    def torque(self, instant):
        on = fn.less(instant.time * instant.time, self.level * self.level)
        return fn.where(on, self.size, 0.0) * Vector((0.3, -0.5, 0.4))


class Attitude(Time):
    """One that changes its sign where an axis passes a level over a plane of space."""

    def torque(self, instant):
        height, _, _ = instant.attitude.to_body((0.6, 0.0, 0.8))
        return fn.where(fn.less(height, self.level), self.size, -self.size) * Vector((0.3, -0.5, 0.4))


class Rate(Time):
    """A damper of bodies that turn fast."""

    def torque(self, instant):
        fast = fn.dot(instant.omega_body, (0.6, 0.0, 0.8)) > self.level
        return -fn.where(fast, self.size, 0.5 * self.size) * instant.omega_body


class Clip(Time):
    """A damper of limited torque."""

    def torque(self, instant):
        return Vector(self.size * fn.clip(-w, -self.level, self.level) for w in instant.omega_body)


class Sign(Time):
    """A torque with the sign of the height of an axis over a level: two conditions with one surface."""

    def torque(self, instant):
        _, height, _ = instant.attitude.to_body((0.8, 0.0, 0.6))
        return self.size * fn.sign(height - self.level) * Vector((0.4, 0.3, -0.5))


KINDS = {"time": Time, "attitude": Attitude, "rate": Rate, "clip": Clip, "sign": Sign}


def one(force, x):
    system = pt.System(BODY, force)
    return system, system.state(
        turned(0, x[..., :3]), angular_momentum_body=BODY.moments * (0.4, -0.3, 0.6) + x[..., 3:]
    )


def part(force, x):
    system = pt.System(BODY, WHEEL, force)
    momentum = BODY.moments * (0.4, -0.3, 0.6) + x[..., 3:6]
    own = {"reaction_wheel": 0.05 + x[..., 6:]}
    return system, system.state(turned(0, x[..., :3]), angular_momentum_body=momentum, **own)


def pair(force, x):
    system = pt.System(PAIR, pt.forces.MutualGravity(), force.on("secondary"))
    rates = (0.1, 0.2, 1.0), (0.4, -0.3, 0.6)
    each = [
        body.state(
            turned(i, x[..., 6 * i : 6 * i + 3]), angular_momentum_body=body.moments * w + x[..., 6 * i + 3 : 6 * i + 6]
        )
        for i, (body, w) in enumerate(zip((PAIR.primary, PAIR.secondary), rates, strict=True))
    ]
    orbit = np.array([4.0, 1.0, 2.0, -0.04, 0.26, 0.13]) + x[..., 12:]
    return system, pt.PairState(orbit[..., :3], orbit[..., 3:], *each)


SYSTEMS = {"one": (one, 6), "part": (part, 7), "pair": (pair, 18)}


def turned(i, theta):
    return (ATTITUDES[i] * Rotation.from_rotvec(theta)).as_quat(scalar_first=True)


def displacements(motion, reference):
    """Tangent coordinates of members (members, n, k) from one motion."""

    def bodies(each):
        return [each.primary, each.secondary] if hasattr(each, "primary") else [each]

    out = []
    for a, b in zip(bodies(motion), bodies(reference), strict=True):
        turn = [(b.attitude.inv() * Rotation.from_quat(q, scalar_first=True)).as_rotvec() for q in a.quaternion]
        out += [np.array(turn), a.angular_momentum_body - b.angular_momentum_body]
    out += [own - reference.own[name] for name, own in motion.own.items()]
    return np.concatenate(out, axis=-1)


def transition(kind, system, size=None, level=None):
    """Along a motion of the system, with the derivative by the level."""
    make, k = SYSTEMS[system]
    force = KINDS[kind](LEVELS[kind] if level is None else level, SIZES[system] if size is None else size)
    return pt.analysis.state_transition(*make(force, np.zeros(k)), [END], ["level"])


def columns(found):
    return np.concatenate([found.matrix, found.sensitivity], axis=-1)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("kind", KINDS)
def test_columns_are_differences_of_motions(kind, system):
    """Along two directions. Rounding over the step is 1e-11, and so much the step leaves out."""
    (make, k), level, size, found = SYSTEMS[system], LEVELS[kind], SIZES[system], transition(kind, system)
    reference = pt.propagate(*make(KINDS[kind](level, size), np.zeros(k)), [END])
    steps, weights = np.array([(s * n, s * w / STEP) for n, w in WEIGHTS for s in (1, -1)]).T
    assert np.max(np.abs(found.sensitivity)) > 0.1  # the motion switches on the way
    for direction in np.random.default_rng(3).normal(size=(2, k + 1)):
        direction /= np.linalg.norm(direction)
        x = STEP * steps[:, None] * direction
        members = pt.propagate(*make(KINDS[kind](level + x[:, k], size), x[:, :k]), [END])
        change = np.einsum("m,mnk->nk", weights, displacements(members, reference))
        np.testing.assert_allclose(columns(found) @ direction, change, rtol=0, atol=1e-10 * np.max(np.abs(change)))


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("kind", KINDS)
def test_back_and_forth_is_the_identity(kind, system):
    """The bound is ten times the largest seen, 3e-16 of the sizes of both."""
    there = transition(kind, system)
    last = state_of(changed(there.motion.phase, lambda x: x[0]), np.array(END))
    back = pt.analysis.state_transition(there.motion.system, last, [0.0], ["level"])
    own = back.matrix[0] @ columns(there)[0]
    own[:, -1:] += back.sensitivity[0]
    k, size = len(own), np.linalg.norm(back.matrix[0], 2) * np.linalg.norm(columns(there)[0], 2)
    np.testing.assert_allclose(own, np.eye(k, k + 1), rtol=0, atol=3e-15 * size)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("kind", KINDS)
def test_members_are_as_they_are_alone(kind, system):
    """To rounding; on this kernel it is the same."""
    size, level = SIZES[system] * np.array([1.0, 0.9, 1.05]), LEVELS[kind] * np.array([1.0, 1.02, 0.97])
    found = columns(transition(kind, system, size, level))
    for i in range(3):
        alone = columns(transition(kind, system, size[i], level[i]))
        np.testing.assert_allclose(found[i], alone, rtol=0, atol=3e-13 * np.max(np.abs(alone)))
