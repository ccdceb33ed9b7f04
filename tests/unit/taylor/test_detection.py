"""Formulas that branch on the way: the integrator stops at each branch, and goes on in the other one."""

# ruff: noqa: ARG002

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.integration import equations
from poinsot.integration.scaling import momentum_scale

BODY = pt.Body((2.0, 3.0, 4.0))
TIMES = np.array([0, 0.5, 1.0, 1.7, 2.5, 3.0, 10.0])


class Thruster(pt.Torque):
    """A constant torque between two times."""

    size: pt.mechanics.Vector
    begin: float
    off: float

    def torque(self, instant):
        burns = fn.where(fn.less(instant.time, self.begin), 0.0, fn.where(fn.less(instant.time, self.off), 1.0, 0.0))
        return burns * fn.Vector(self.size)


class BangBang(pt.Torque):
    """A torque about the third axis against the angle from the first space axis."""

    size: float

    def torque(self, instant):
        _, sine, _ = instant.attitude.to_body((-1, 0, 0))
        return fn.Vector((0.0, 0.0, self.size * fn.where(fn.less(sine, 0.0), 1.0, -1.0)))


class Ridge(pt.Potential):
    """An energy with a corner: |first component of the third body axis| times a strength."""

    strength: float

    def energy(self, instant):
        x, _, _ = instant.attitude.to_space((0, 0, 1))
        return self.strength * fn.where(fn.less(x, 0.0), -x, x)


class Friction(pt.Torque):
    """Dry friction about the third axis."""

    size: float

    def torque(self, instant):
        return fn.Vector((0.0, 0.0, self.size * fn.where(fn.less(instant.omega_body[2], 0.0), 1.0, -1.0)))


class Shadow(pt.Torque):
    """A torque about the third axis where a planet does not hide the first space axis: a cylinder of a radius."""

    orbit: pt.Orbit
    radius: float
    size: float
    unit: float = 1.0

    def torque(self, instant):
        x, y, z = instant.position(self.orbit)
        lit = fn.where(
            fn.less(0.0, x), 1.0, fn.where(fn.less(self.unit * self.radius**2, self.unit * (y * y + z * z)), 1.0, 0.0)
        )
        return fn.Vector((0.0, 0.0, self.size * lit))


def rate(times, on=1.0, off=2.5):
    return 0.1 + 0.5 / 4 * np.clip(times - on, 0, off - on)


THRUSTED = pt.System(BODY, Thruster((0, 0, 0.5), 1.0, 2.5))


@pytest.mark.parametrize("start", [0.0, 0.7, 1.0, 2.0, 2.5, 10.0])
@pytest.mark.parametrize(
    "ways",
    [{}, {"dense": True}, {"formulation": "canonical"}, {"precision": "quadruple"}],
    ids=lambda ways: "-".join(map(str, ways.values())),
)
def test_a_thrust_arc_is_exact_from_any_time_both_ways(start, ways):
    state = BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate(start)), time=start)
    motion = pt.propagate(THRUSTED, state, TIMES, **ways)
    assert np.max(np.abs(motion.omega_body[:, 2] - rate(TIMES))) < 1.2e-15
    if "dense" in ways:
        between = np.linspace(0, 10, 101)
        assert np.max(np.abs(motion(between).angular_momentum_body[:, 2] / 4 - rate(between))) < 1.2e-15


def test_the_angle_is_the_integral_of_the_rate():
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.1))
    motion = pt.propagate(THRUSTED, start, [10.0])
    angle = 0.1 * 10 + 0.125 * (1.5**2 / 2 + 1.5 * 7.5)
    expected = [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
    assert np.max(np.abs(motion.quaternion[0] - expected)) < 1.5e-15


def test_members_switch_each_at_its_own_time():
    on = np.linspace(0.5, 3, 21)
    system = pt.System(BODY, Thruster(np.tile([0, 0, 0.5], (21, 1)), on, on + 1.5))
    motion = pt.propagate(system, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.1)), TIMES)
    assert np.max(np.abs(motion.omega_body[..., 2] - rate(TIMES, on[:, None], on[:, None] + 1.5))) < 1.2e-15


def test_switches_of_several_forces_at_one_time():
    up, down = Thruster((0, 0, 0.5), 0.1 + 0.2, 1.0), Thruster((0, 0, -0.3), 0.3, 1.0)
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.1))
    for system in (pt.System(BODY, up, down), pt.System(BODY, down, up)):
        motion = pt.propagate(system, start, [0.2, 0.3, 0.65, 1.0, 2.0])
        assert np.allclose(motion.omega_body[:, 2], 0.1 + 0.05 * np.array([0, 0, 0.35, 0.7, 0.7]), rtol=0, atol=1e-15)


def test_a_branch_in_the_attitude():
    acceleration, start = 0.1, 0.6  # theta'' = -a sign(theta): parabolas
    quarter = np.sqrt(2 * start / acceleration)
    times = np.linspace(0, 60 * quarter, 97)
    state = BODY.state((np.cos(start / 2), 0, 0, np.sin(start / 2)), omega_body=(0, 0, 0))
    motion = pt.propagate(pt.System(BODY, BangBang(4 * acceleration)), state, times)
    angle = 2 * np.arctan2(motion.quaternion[:, 3], motion.quaternion[:, 0])
    phase = np.mod(times / quarter, 4)
    expected = np.where(phase < 1, 1 - phase**2, np.where(phase < 3, (phase - 2) ** 2 - 1, 1 - (phase - 4) ** 2))
    assert np.max(np.abs(angle - start * expected)) < 2e-13


def test_energy_is_conserved_across_the_corner_of_a_potential():
    system = pt.System(BODY, Ridge(0.7))
    motion = pt.propagate(
        system, BODY.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.3, 0.2, 0.1)), np.linspace(0, 100, 201)
    )
    x = motion.attitude.as_matrix()[:, 0, 2]
    assert np.sum(x[1:] * x[:-1] < 0) > 20
    assert np.max(np.abs(motion.drift["energy"])) < 4e-14


def test_a_run_that_a_switch_holds_stops_with_what_was_computed():
    state = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.5))
    with pytest.raises(pt.PropagationError, match=r"stopped at t = 5 of 10: the branches of a `where` lead back"):
        pt.propagate(pt.System(BODY, Friction(0.4)), state, np.linspace(0, 10, 11))
    motion = pt.propagate(pt.System(BODY, Friction([0.4, 0.01])), state, np.linspace(0, 10, 11))
    assert list(motion.failures) == [0]
    assert np.allclose(motion.omega_body[0, :5, 2], 0.5 - 0.1 * np.arange(5), rtol=0, atol=1e-15)
    assert np.allclose(motion.omega_body[1, :, 2], 0.5 - 0.0025 * np.arange(11), rtol=0, atol=1e-15)


def test_a_member_that_a_switch_holds_leaves_none_of_its_switches_to_the_next_one(monkeypatch):
    """Which begins at a switch, and takes the lane of the one that is held."""
    monkeypatch.setattr(equations, "LANES", 1)
    system = pt.System(BODY, Friction([-0.4, -0.01]), Thruster((0, 0, 0.004), -100.0, 1.0))
    motion = pt.propagate(system, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0.5), time=1.0), [-9.0])
    assert list(motion.failures) == [0]
    assert abs(motion.omega_body[1, 0, 2] - (0.5 - 10 * (0.01 + 0.004) / 4)) < 1e-15


def test_the_shadow_of_a_planet():
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.0)  # a circle of radius 2 about a planet of radius 1
    n = orbit.mean_motion
    system = pt.System(BODY, Shadow(orbit, 1.0, 0.4))
    motion = pt.propagate(system, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [2 * np.pi / n, 200 * np.pi / n])
    lit = (2 * np.pi - np.pi / 3) / n  # sin(half the angle in the dark) = 1/2
    assert np.max(np.abs(motion.omega_body[:, 2] / (0.1 * lit * np.array([1, 100])) - 1)) < 2e-13


def test_a_parameter_that_branches_needs_no_switch():
    class Either(pt.Torque):
        size: float

        def torque(self, instant):
            return fn.Vector((0.0, 0.0, fn.where(fn.less(self.size, 0.0), 0.4, self.size)))

    motion = pt.propagate(pt.System(BODY, Either([-1.0, 0.8])), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [1.0])
    assert np.allclose(motion.omega_body[:, 0, 2], [0.1, 0.2], rtol=0, atol=1e-16)


@pytest.mark.parametrize("on", [1e4, 1e6, 8e8])
def test_a_switch_far_away_costs_no_digit(on):
    """The engine's step control looks at the functions of events too."""
    body = pt.Body((1.0, 2.0, 3.0))
    start = body.state((1, 0, 0, 0), omega_body=(0.01, 0.005, 0.1))
    motion = pt.propagate(pt.System(body, Thruster((0, 0, 1e-3), on, 2 * on)), start, [9999.0])
    exact = pt.free_motion(body, start, [9999.0])
    assert np.max(np.abs(motion.quaternion - exact.quaternion)) < 8e-12
    members = pt.propagate(pt.System(body, Thruster((0, 0, 1e-3), [on, 2e4], 2 * on)), start, [9999.0])
    assert np.max(np.abs(members.quaternion - exact.quaternion)) < 8e-12


@pytest.mark.parametrize("unit", [1e-10, 1e6, 1e14])
def test_the_unit_of_a_condition_costs_no_digit(unit):
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.0)
    start, times = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0)), 2 * np.pi / orbit.mean_motion * np.array([1, 20])
    for size in (0.4, [0.4, 0.4]):
        motion = pt.propagate(pt.System(BODY, Shadow(orbit, 1.0, size, unit)), start, times)
        assert np.max(np.abs(motion.omega_body[..., 2] / (0.1 * 5 / 6 * times) - 1)) < 1e-13
        assert np.max(np.abs(motion.norm_error)) < 4e-14


@pytest.mark.parametrize("on", [3.0, 1e4, [3.0, 1e4]], ids=str)
def test_what_a_thruster_changes_is_no_integral(on):
    thrusted = pt.System(BODY, Thruster((0.1, 0.2, 0.5), on, 1.01 * np.asarray(on)))
    assert thrusted.integrals == ()
    assert np.all(momentum_scale(thrusted.dynamics, BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0))) != 1.0)


def test_a_potential_that_is_switched_on_has_no_energy_to_keep():
    class Weight(pt.Potential):
        begin: float
        off: float

        def energy(self, instant):
            lasts = fn.where(fn.less(instant.time, self.off), 1.0, 0.0)
            return fn.where(fn.less(instant.time, self.begin), 0.0, lasts) * instant.attitude.to_body((0, 0, 1))[2]

    assert [integral.symbol for integral in pt.System(BODY, Weight(3.0, 7.0)).integrals] == ["G3"]
    assert [integral.symbol for integral in pt.System(BODY, Ridge(0.7)).integrals] == ["H", "G1"]
    assert [integral.symbol for integral in pt.System(BODY, Ridge([0.7, 0.8])).integrals] == ["H", "G1"]


def test_a_condition_that_grows_from_zero_costs_no_digit():
    body = pt.Body((1.0, 2.0, 3.0))
    start = body.state((1, 0, 0, 0), omega_body=(1e-7, 5e-8, 1e-6))
    motion = pt.propagate(pt.System(body, Thruster((0, 0, 0), 0.0, 1e12)), start, [1e9])
    exact = pt.free_motion(body, start, [1e9])
    assert np.max(np.abs(motion.quaternion - exact.quaternion)) < 5e-12


class Twice(pt.Torque):
    """A damper with two limits, one after the other: where they are equal, the second condition is zero throughout."""

    first: float
    second: float

    def torque(self, instant):
        once = [fn.clip(-2.0 * w, -self.first, self.first) for w in instant.omega_body]
        return fn.Vector(fn.clip(x, -self.second, self.second) for x in once)


@pytest.mark.parametrize("end", [20.0, -20.0])
def test_equal_limits_one_after_the_other_are_one(end):
    times = np.linspace(0, end, 9)
    start = BODY.state((1, 0, 0, 0), omega_body=(0.4, -0.3, 0.2))
    inner, alone = np.array([0.3, 0.2, 0.3, 0.35]), np.array([0.3, 0.2, 0.3, 0.3])
    systems = [pt.System(BODY, force) for force in (Twice(inner, 0.3), Twice(alone, 1e3))]
    for precision in ("double", "quadruple"):
        both = [pt.propagate(system, start, times, precision=precision) for system in systems]
        one = pt.propagate(pt.System(BODY, Twice(0.3, 0.3)), start, times, precision=precision)
        assert np.max(np.abs(both[0].quaternion - both[1].quaternion)) < 1e-13
        assert np.max(np.abs(one.quaternion - both[1].quaternion[0])) < 1e-13
