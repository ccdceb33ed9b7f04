"""Laws of every shipped control law; a new one joins by one instance in `kinds/control_laws.py`."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from kinds.control_laws import BODY, LAWS, SAMPLED, TARGET
from kinds.forces import ELLIPSE, MAGNETIC_FIELDS, random_attitudes
from kinds.forces_in_files import comes_back
from poinsot.control import OrbitPointing, QuaternionFeedback, RateDamping, Sampled
from poinsot.mechanics.part import Part
from torques import compiled, compiled_torque, sympy_numbers, turned_orbit

START = {"attitude": (0.1, 0.7, -0.5, 0.5), "omega_body": (0.4, -0.6, 0.5)}
TIMES = np.linspace(0, 3, 7)
each_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
each = pytest.mark.parametrize("law", [*LAWS, *SAMPLED], ids=lambda law: repr(law)[:26])


def motion(body, law):
    system = pt.System(body, law)
    return pt.propagate(system, system.state(**START), TIMES)


def test_every_law_of_the_package_is_here():
    shipped = {kind for kind in concrete_subclasses(pt.Torque, Part) if kind.__module__.startswith("poinsot.control")}
    assert shipped == {type(law) for law in (*LAWS, *SAMPLED)}


@each_law
def test_torque_is_one_for_both_engines(law):
    system, omega, time = pt.System(BODY, law), np.array([0.4, -0.7, 0.2]), 0.9
    from_kernel = compiled_torque(system)
    for q in random_attitudes():
        torque = from_kernel(q, omega, time)
        assert np.max(np.abs(torque)) > 1e-3
        assert np.max(np.abs(torque - np.array(sympy_numbers(system, q, omega, time), dtype=float))) < 2e-14


def turned(law, turn):
    """The law with what it sees in space turned."""
    if isinstance(law, QuaternionFeedback):
        target = turn * Rotation.from_quat(law.target, scalar_first=True)
        return dataclasses.replace(law, target=target.as_quat(scalar_first=True))
    return dataclasses.replace(law, orbit=turned_orbit(law.orbit, turn)) if isinstance(law, OrbitPointing) else law


@each_law
def test_torque_is_unchanged_when_the_whole_world_turns(law):
    for turn in Rotation.random(3, np.random.default_rng(5)):
        for q in random_attitudes():
            attitude = Rotation.from_quat(q, scalar_first=True)
            here, there = (BODY.state(a, omega_body=(0.4, -0.7, 0.2), time=0.9) for a in (attitude, turn * attitude))
            before = pt.System(BODY, law).torque_body(here)
            assert np.max(np.abs(pt.System(BODY, turned(law, turn)).torque_body(there) - before)) < 2e-14


@pytest.mark.parametrize("law", LAWS[:2], ids=["space", "orbit"])
def test_a_quaternion_and_its_opposite_are_one_attitude(law):
    """So the body takes the shorter way, and next to half a turn the torque keeps its size."""
    system = pt.System(BODY, law)
    for q in random_attitudes():
        here, there = (system.torque_body(BODY.state(sign * q, omega_body=(0, 0, 0))) for sign in (1, -1))
        assert np.max(np.abs(here - there)) < 1e-15
    frame = np.array((1.0, 0, 0, 0)) if isinstance(law, QuaternionFeedback) else ELLIPSE.frame.quaternion(0.0)
    aim = Rotation.from_quat(frame, scalar_first=True) * Rotation.from_quat(TARGET, scalar_first=True)
    still = {} if isinstance(law, QuaternionFeedback) else {"frame": None}
    for axis in np.eye(3):
        for angle in (0.1, 3.0, np.pi - 1e-9, np.pi + 1e-9, 4.0):
            attitude = aim * Rotation.from_rotvec(angle * axis)
            system = pt.System(BODY, dataclasses.replace(law, kd=0.0, limit=1e3))
            torque = system.torque_body(BODY.state(attitude, omega_body=(0, 0, 0), **still))
            expected = -0.8 * np.sin(angle / 2) * np.sign(np.cos(angle / 2)) * axis
            assert np.max(np.abs(torque - expected)) < 1e-14


# ---------------------------------------------------------------------- parameters


def changed(law):
    """The same law, sampled or not, with one real parameter changed, in every possible way."""
    for name, value in vars(law).items():
        if isinstance(value, np.ndarray):
            for index in np.ndindex(value.shape):
                other = value.copy()
                other[index] += 0.07
                other = other / np.linalg.norm(other) if name == "target" else other
                yield f"{name}{list(index)}", dataclasses.replace(law, **{name: other})
        elif isinstance(value, QuaternionFeedback | RateDamping | OrbitPointing):
            yield from ((f"{name}.{what}", dataclasses.replace(law, **{name: x})) for what, x in changed(value))


@each
def test_other_numbers_use_the_same_kernel_and_reach_the_motion(law, forget_kernels):
    forget_kernels()
    first = motion(BODY, law)
    known = compiled()
    assert len(known) == 1
    others = {name: motion(BODY, other) for name, other in changed(law)}
    assert compiled() == known
    inert = [name for name, other in others.items() if np.max(np.abs(other.quaternion - first.quaternion)) < 1e-4]
    assert len(others) > 1
    assert inert == []


@each
def test_members_are_as_alone(law):
    gains = np.array([0.3, 0.8, 1.1, 2.0, 0.5])

    def with_gain(gain):
        name = "gain" if isinstance(law.law if isinstance(law, Sampled) else law, RateDamping) else "kd"
        if not isinstance(law, Sampled):
            return dataclasses.replace(law, **{name: gain})
        return dataclasses.replace(law, law=dataclasses.replace(law.law, **{name: gain}))

    together = motion(BODY, with_gain(gains))
    for k, gain in enumerate(gains if getattr(law, "name", "") != "noisy" else gains[:1]):
        alone = motion(BODY, with_gain(gain))
        assert np.max(np.abs(together[k].quaternion - alone.quaternion)) < 1e-14


@each
def test_laws_come_back_from_files(law, tmp_path):
    assert comes_back(BODY, law)
    first = motion(BODY, law)
    read = pt.load(pt.save(first, tmp_path / "it.nc"))
    for name, values in first.own.items():
        assert np.array_equal(read.own[name], values)
    assert np.array_equal(read.quaternion, first.quaternion)


WRONG_SIGN = r"should not be negative, got -0\.5\. Feedback of the wrong sign is unstable\.$"


@pytest.mark.parametrize("gain", ["kp", "kd", "gain"])
def test_gains_of_the_wrong_sign_give_a_warning(gain):
    law, names = (RateDamping, ("gain", "limit")) if gain == "gain" else (QuaternionFeedback, ("kp", "kd", "limit"))
    given = dict.fromkeys(names, 1.0)
    with pytest.warns(UserWarning, match=rf"^{gain} {WRONG_SIGN}") as warned:
        law(**{**given, gain: (0.5, -0.5)})
    assert [each.filename for each in warned] == [__file__]


def test_gains_of_magnetorquers_of_the_wrong_sign_give_a_warning():
    with pytest.warns(UserWarning, match=f"^gain {WRONG_SIGN}"):
        pt.forces.BDot((0.5, -0.5), MAGNETIC_FIELDS[0], 1.0)


def test_targets_have_unit_norm():
    with pytest.raises(ValueError, match="target must have unit norm"):
        QuaternionFeedback(1.0, 1.0, 1.0, target=(1, 0, 0, 0.1))
