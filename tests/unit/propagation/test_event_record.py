"""Events: what is recorded, what acts, what ends a motion, and what none of them may change."""

# ruff: noqa: ARG002

import os
import signal
import threading
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.taylor import queue

BODY = pt.Body((1.0, 2.0, 3.0))
FREE = pt.System(BODY)
ROUNDING = 16 * np.finfo(float).eps


def spinning(rate=0.7, time=0.0, body=BODY):
    rates = np.multiply.outer(np.asarray(rate, dtype=float), (0, 0, 1))
    return body.state((1, 0, 0, 0), omega_body=rates, time=time)


ACROSS = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0))  # at cos(rate t) = 0


def quarters(rate, until):
    """The times at which cos(rate t) = 0."""
    return (np.arange(int(until * rate / np.pi + 0.5)) + 0.5) * np.pi / rate


class Kick(pt.Event):
    """A torque impulse along the third axis where the third axis has turned by a multiple of half a turn."""

    impulse: float

    def value(self, instant):
        return instant.attitude.to_body((0, 1, 0))[0]  # sin(angle)

    def act(self, body, state):
        changed = state.angular_momentum_body + np.array([0, 0, self.impulse])
        return body.state(state.quaternion, angular_momentum_body=changed, time=state.time)


class Bounce(pt.Event):
    """A wall in the way of the first axis: it comes back with a part of its rate."""

    restitution: float

    def value(self, instant):
        return instant.attitude.to_body((1, 0, 0))[1]  # -sin(angle)

    def act(self, body, state):
        return body.state(
            state.quaternion, angular_momentum_body=-self.restitution * state.angular_momentum_body, time=state.time
        )


class Push(pt.Torque):
    size: float

    def torque(self, instant):
        return fn.Vector((0.0, 0.0, self.size))


WAYS: list[dict[str, Any]] = [
    {},
    {"dense": True},
    {"formulation": "canonical"},
    {"formulation": "planar"},
    {"precision": "quadruple"},
    {"tolerance": 1e-12},
]


@pytest.mark.parametrize("ways", WAYS, ids=lambda ways: "-".join(map(str, ways.values())) or "default")
@pytest.mark.parametrize("times", [[0.0, 50.0], [50.0, 0.0]], ids=["up", "down"])
def test_times_states_and_directions_are_recorded_in_the_order_of_the_times(times, ways):
    motion = pt.propagate(FREE, spinning(), times, events=[ACROSS], **ways)
    found, expected = motion.events[0], quarters(0.7, 50.0)
    order = slice(None, None, 1 if times[0] < times[1] else -1)
    slack = 1e-9 if "tolerance" in ways else ROUNDING
    assert np.allclose(found.times, expected[order], rtol=slack, atol=0)
    assert found.directions.tolist() == [-1 if k % 2 == 0 else 1 for k in range(expected.size)][order]
    assert np.allclose(found.states.quaternion[:, 0], np.cos(0.35 * found.times), rtol=0, atol=max(slack, 4e-14))
    assert np.array_equal(found.states.time, found.times)
    assert np.allclose(found.omega_body, [0, 0, 0.7], rtol=0, atol=4e-15)
    assert len(found) == expected.size
    title, times, directions = repr(found).splitlines()
    assert title == "EventRecord of AxisCrossing(axis=[1.0, 0.0, 0.0], target=[1.0, 0.0, 0.0], angle=1.5708): 11"
    assert (times, directions) == ("  times: 11, 2.24399 ... 47.1239", "  directions: 5 rising, 6 falling")


def test_both_directions_of_time_from_a_start_within():
    motion = pt.propagate(FREE, spinning(time=10.0), [-40.0, 60.0], events=[ACROSS])
    expected = quarters(0.7, 50.0)
    assert np.allclose(motion.events[0].times, np.sort([*(10 - expected), *(10 + expected)]), rtol=0, atol=8e-14)


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_direction_chooses_rising_or_falling_in_time_whichever_way_the_run_goes(direction):
    event = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), direction=direction)
    for end in (50.0, -50.0):
        motion = pt.propagate(FREE, spinning(), [end], events=[event, ACROSS])
        chosen, both = motion.events
        assert set(chosen.directions) == {direction}
        assert np.array_equal(chosen.times, both.times[both.directions == direction])


def test_members_have_their_own_events():
    rates = np.linspace(0.3, 2, 37)
    motion = pt.propagate(FREE, spinning(rates), np.linspace(-20, 50, 6), events=[ACROSS])
    found = motion.events[0]
    assert np.all(np.diff(found.members) >= 0)
    for k in (0, 20, 36):
        expected = np.sort([*(-quarters(rates[k], 20)), *quarters(rates[k], 50)])
        assert np.allclose(found.member(k).times, expected, rtol=0, atol=7e-14)
        assert np.allclose(found.member(k).omega_body[:, 2], rates[k], rtol=1.2e-15, atol=0)
    assert len(found) == sum(quarters(r, 20).size + quarters(r, 50).size for r in rates)


def test_parameters_of_events_may_have_members_and_compile_nothing():
    thirds = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), angle=np.linspace(0.2, 3.0, 9), direction=-1)
    found = pt.propagate(FREE, spinning(1.0), [6.0], events=[thirds]).events[0]
    assert np.allclose(found.times, np.linspace(0.2, 3.0, 9), rtol=0, atol=2e-14)
    assert found.members.tolist() == list(range(9))


@pytest.mark.parametrize("steps", range(1, 9))
@pytest.mark.parametrize("way", [1, -1])
def test_a_terminal_event_ends_the_motion_whatever_step_of_a_chunk_it_is_in(steps, way, monkeypatch):
    """An event at an output time has its row, also where a call of the kernel ends."""
    advance = queue.Worker.advance
    monkeypatch.setattr(queue.Worker, "advance", lambda run, budget=None: advance(run, budget or steps))
    times, tumbling = way * np.arange(10.0), (0.3, 0.8, 0.9)
    events = [pt.events.AtTime(2.0 * way, terminal=True)]
    one = pt.propagate(FREE, BODY.state((1, 0, 0, 0), omega_body=tumbling), times, events=events)
    two = BODY.state([(1.0, 0, 0, 0)] * 2, omega_body=[tumbling, (0.3, 0.2, 0.1)])
    several = pt.propagate(FREE, two, times, events=events)
    assert one.times.tolist() == times[:3].tolist()
    assert np.isfinite(several.quaternion[..., 0]).sum(axis=1).tolist() == [3, 3]
    assert np.abs(several.quaternion[0, :3] - one.quaternion).max() < ROUNDING
    assert [len(one.events[0]), len(several.events[0])] == [1, 2]


@pytest.mark.parametrize("members", [False, True])
def test_a_terminal_event_ends_the_motion_without_a_failure(members):
    event = pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), terminal=True)
    rates, times = np.linspace(0.3, 2, 11), np.linspace(-1, 6, 15)
    if not members:
        motion = pt.propagate(FREE, spinning(0.7), times, events=[event, ACROSS])
        assert np.array_equal(motion.times, times[times < np.pi / 1.4])
        assert np.allclose([e.times for e in motion.events], np.pi / 1.4, rtol=2e-15, atol=0)
        return
    motion = pt.propagate(FREE, spinning(rates), times, events=[event])
    assert motion.failures == {}
    for k, rate in enumerate(rates):
        inside = np.abs(times) < np.pi / 2 / rate
        inside |= (times < 0) & (times > -np.pi / 2 / rate)
        assert np.array_equal(np.isfinite(motion.quaternion[k, :, 0]), inside)
        ends = motion.events[0].member(k).times
        assert np.allclose(np.abs(ends), np.pi / 2 / rate, rtol=2e-15, atol=0)


@pytest.mark.parametrize("angle", [1e-2, 1e-5])
def test_a_narrow_cone_ends_a_motion_though_its_value_cancels(angle):
    event, rates = (
        pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), angle=angle, direction=1, terminal=True),
        np.linspace(0.3, 2, 97),
    )
    motion = pt.propagate(FREE, spinning(rates), [100.0], events=[event])
    found = motion.events[0]
    assert len(found) == 97
    assert np.allclose(found.times * rates, 2 * np.pi - angle, rtol=0, atol=4e-15 / angle)
    assert np.all(np.isnan(motion.quaternion))


@pytest.mark.parametrize("ways", [{}, {"dense": True}, {"formulation": "canonical"}, {"precision": "quadruple"}])
def test_an_impulse_changes_the_rate_and_nothing_else(ways):
    motion = pt.propagate(FREE, spinning(0.5), np.arange(0.1, 30), events=[Kick(0.3)], **ways)
    rates = 0.5 + 0.1 * np.arange(40)
    expected = np.cumsum(np.pi / rates)
    found = motion.events[0]
    assert np.allclose(found.times, expected[: len(found)], rtol=1e-14, atol=0)
    assert expected[len(found)] > 29.1 - 1e-9
    assert np.allclose(found.omega_body[:, 2], rates[: len(found)], rtol=1e-14, atol=0)  # before it acts
    assert np.allclose(motion.omega_body[:, 2], rates[np.searchsorted(expected, motion.times)], rtol=1.2e-14, atol=0)
    angle = np.interp(motion.times, [0, *expected], np.pi * np.arange(41))
    assert np.allclose(np.cos(2 * motion.attitude.as_rotvec()[:, 2]), np.cos(2 * angle), rtol=0, atol=1e-12)
    if "dense" in ways:
        assert np.isclose(motion(8.0).angular_momentum_body[2], 3 * rates[np.searchsorted(expected, 8.0)], rtol=1e-14)


def test_impulses_of_members_in_batches_are_those_of_each_alone():
    impulses = np.linspace(0.05, 0.6, 13)
    orbit = pt.KeplerOrbit(
        1.0, semimajor_axis=2.0, eccentricity=0.1, inclination=0.2, node=0.3, argument_of_periapsis=0.4
    )
    system = pt.System(BODY, pt.GravityGradient(orbit))
    start, times = BODY.state((1, 0, 0, 0), omega_body=(0.02, 0.01, 0.5)), np.linspace(0, 20, 5)
    together = pt.propagate(system, start, times, events=[Kick(impulses), pt.events.Apsis(orbit)])
    for k in (0, 5, 12):
        alone = pt.propagate(system, start, times, events=[Kick(impulses[k]), pt.events.Apsis(orbit)])
        assert np.max(np.abs(together.quaternion[k] - alone.quaternion)) < 2e-13
        for a, b in zip(together.events, alone.events, strict=True):
            assert np.allclose(a.member(k).times, b.times, rtol=0, atol=2e-13)


def test_moments_of_members_reach_the_action():
    moments = np.array([[1.0, 2.0, 2.5], [1.0, 2.0, 3.0]])
    body = pt.Body(moments)
    motion = pt.propagate(pt.System(body), spinning([1.0, 1.0], body=body), [3.0, 3.3], events=[Kick(0.5)])
    assert np.allclose(motion.omega_body[:, 1, 2], 1 + 0.5 / moments[:, 2], rtol=1e-14, atol=0)


@pytest.mark.parametrize("members", [False, True])
def test_what_bounces_back_faster_and_faster_stops_with_a_sentence(members):
    """A constant torque against a wall: the times between bounces shrink by the restitution, to a finite sum."""
    system = pt.System(BODY, Push([-0.6, -0.6] if members else -0.6))  # angle'' = -0.2
    start = BODY.state((np.cos(0.5), 0, 0, np.sin(0.5)), omega_body=(0, 0, 0))
    first = np.sqrt(10.0)
    end = first * (1 + 2 * 0.5 / (1 - 0.5))
    if members:
        motion = pt.propagate(system, start, [9.0, 20.0], events=[Bounce(0.5)])
        assert all("an event acts again and again without end" in why for why in motion.failures.values())
        assert len(motion.failures) == 2
        bounces = motion.events[0].member(1)
    else:
        with pytest.raises(pt.PropagationError, match="an event acts again and again without end") as stop:
            pt.propagate(system, start, [9.0, 20.0], events=[Bounce(0.5)])
        motion, bounces = stop.value.trajectory, stop.value.trajectory.events[0]
        assert motion.times.tolist() == [9.0]
        assert abs(stop.value.time - end) < 1e-4
    assert np.allclose(np.diff(bounces.times)[:12], 2 * first * 0.5 ** np.arange(1, 13), rtol=1e-11, atol=0)


def test_a_zero_at_the_start_is_none_and_at_the_end_is_one():
    sine = pt.events.AxisCrossing((0, 1, 0), (1, 0, 0))  # -sin(rate t)
    for end in (4 * np.pi, -4 * np.pi):
        found = pt.propagate(FREE, spinning(1.0), [end], events=[sine]).events[0]
        assert np.allclose(np.sort(np.abs(found.times)), np.pi * np.arange(1, 5), rtol=2e-15, atol=0)
    members = pt.propagate(FREE, spinning([1.0, 0.5, 2.0]), [4 * np.pi], events=[sine]).events[0]
    assert [len(members.member(k)) for k in range(3)] == [4, 2, 8]
    motion = pt.propagate(
        FREE, spinning(1.0), [1.0, 2.0], events=[pt.events.AtTime(0.0, terminal=True), pt.events.AtTime(2.0)]
    )
    assert len(motion.times) == 2
    assert [len(found) for found in motion.events] == [0, 1]


@pytest.mark.parametrize("members", [False, True])
def test_events_at_one_instant_all_happen(members):
    """Passing, acting and terminal ones, and one with another formula of the same zero."""
    events = [
        pt.events.AtTime(2.0),
        Late(2.0, 0.3, 1.0),
        Late(2.0, 0.5, 7.0),
        pt.events.AtTime(2.0),
        pt.events.AtTime(5.0, terminal=True),
        pt.events.AtTime(5.0),
    ]
    motion = pt.propagate(FREE, spinning([0.5, 0.5] if members else 0.5), [1.0, 3.0, 6.0], events=events)
    last = motion.events[0].times.size
    assert [len(found) for found in motion.events] == [last] * 6
    assert last == (2 if members else 1)
    assert np.allclose(motion.omega_body[..., 1, 2], 0.5 + 0.8 / 3, rtol=1e-15, atol=0)
    assert motion.quaternion.shape[-2] == (3 if members else 2)


class Late(pt.Event):
    """An impulse at an instant."""

    time: float
    impulse: float
    factor: float

    def value(self, instant):
        return self.factor * (instant.time - self.time)

    act = Kick.act


def test_an_event_where_a_formula_branches_is_not_lost():
    class Brake(pt.Torque):
        def torque(self, instant):
            return fn.Vector((0.0, 0.0, fn.where(fn.less(instant.omega_body[2], 0.1), -0.3, -0.9)))

    for members in (1.0, np.linspace(0.2, 2.5, 97)):
        motion = pt.propagate(
            pt.System(BODY, Brake()), spinning(members), [9.0], events=[pt.events.RateCrossing((0, 0, 1), rate=0.1)]
        )
        assert np.allclose(motion.events[0].times, (np.ravel(members) - 0.1) / 0.3, rtol=1e-14, atol=0)


@pytest.mark.parametrize("slope", [0.0, 0.01, -0.01])
def test_a_value_that_jumps_over_zero_does_so_where_it_branches(slope):
    class Latch(pt.Event):
        def value(self, instant):
            return fn.where(fn.less(instant.time, 1.0), -1.0, 1.0) + slope * instant.time

    for start, end in ((0.0, 3.0), (3.0, -1.0)):
        found = pt.propagate(FREE, spinning(time=start), [end], events=[Latch()]).events[0]
        assert (found.times.tolist(), found.directions.tolist()) == ([1.0], [1])


def test_an_action_sets_the_branches_anew():
    class Wall(pt.Torque):
        def torque(self, instant):
            return fn.Vector((0.0, 0.0, fn.where(fn.less(instant.omega_body[2], 1.0), 0.0, 0.6)))

    motion = pt.propagate(pt.System(BODY, Wall()), spinning(0.5), [1.0, 3.0], events=[Late(2.0, 3.0, 1.0)])
    assert np.allclose(motion.omega_body[:, 2], [0.5, 1.5 + 0.2], rtol=1e-14, atol=0)


def test_a_touch_without_a_crossing_is_an_even_number_of_zeros_or_none():
    class Touch(pt.Event):
        def value(self, instant):
            return 1 + instant.attitude.to_body((1, 0, 0))[0]  # 1 + cos

    found = pt.propagate(FREE, spinning(1.0), [7.0], events=[Touch()]).events[0]
    assert len(found) <= 2
    assert np.allclose(found.times, np.pi, rtol=0, atol=1e-6)


def test_values_that_are_not_finite_stop_the_run():
    """At the latest where it ends: a step that begins just at the root is as long as any."""

    class Root(pt.Event):
        def value(self, instant):
            return fn.sqrt(1.5 - instant.time) - 2

    with pytest.raises(pt.PropagationError, match="stopped at t = 1"):
        pt.propagate(FREE, spinning(), [1.0, 1.9], events=[Root()])


@pytest.mark.parametrize("unit", [1.0, 86400.0, 3.2e7, 1e-9])
@pytest.mark.parametrize("inertia", [1.0, 1e35])
def test_events_change_the_motion_by_rounding_in_any_unit(unit, inertia):
    """In an eccentric orbit, with events of very different sizes; the steps need not be the same."""
    orbit = pt.KeplerOrbit(
        1e9 / unit**2, semimajor_axis=1e3, eccentricity=0.3, inclination=0.4, node=0.5, argument_of_periapsis=0.6
    )
    body = pt.Body(inertia * np.array([1.0, 1.5, 2.0]))
    system = pt.System(body, pt.GravityGradient(orbit))
    start = body.state((1, 0, 0, 0), omega_body=np.array([0.2, 0.3, 1.1]) / unit)
    times = np.linspace(0, 8, 5) * unit
    events = [
        pt.events.AxisCrossing((3, 1, 0), (0, 0, 1e9), angle=1.3),
        pt.events.AttractorCrossing((0, 0, 1), orbit),
        pt.events.RateCrossing((1, 0, 0)),
        pt.events.SpinFlip((0, 1e-9, 0)),
        pt.events.Apsis(orbit),
        pt.events.AtTime(7 * unit),
        pt.events.AndoyerCrossing(),
    ]
    plain, watched = pt.propagate(system, start, times), pt.propagate(system, start, times, events=events)
    assert np.max(np.abs(plain.quaternion - watched.quaternion)) < 4e-14
    wide = pt.propagate(system, start, times, events=events, precision="quadruple")
    for found, better in zip(watched.events, wide.events, strict=True):
        assert len(found) == len(better) > 0
        assert np.allclose(found.times, better.times, rtol=0, atol=1e-13 * unit)


def test_an_event_that_grows_from_nothing_costs_no_digit():
    class Distance(pt.Event):
        """Zero with its derivatives at the start, and large later."""

        def value(self, instant):
            return instant.time**2 * (1e9 + instant.time) * instant.attitude.to_body((1, 0, 0))[0]

    times = np.linspace(0, 300, 4)
    motion = pt.propagate(FREE, spinning(), times, events=[Distance()])
    assert np.allclose(motion.events[0].times, quarters(0.7, 300.0), rtol=1e-14, atol=0)
    assert np.max(np.abs(motion.quaternion - pt.free_motion(BODY, spinning(), times).quaternion)) < 1e-13


def test_orbits_of_events_need_not_be_those_of_forces():
    ellipse = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.3, inclination=0.2, node=0.3, argument_of_periapsis=0.4
    )
    system = pt.System(
        BODY,
        pt.GravityGradient(
            pt.KeplerOrbit(
                1.0, semimajor_axis=2.0, eccentricity=0.0, inclination=0.2, node=0.3, argument_of_periapsis=0.4
            )
        ),
    )
    found = pt.propagate(system, spinning(), [40.0], events=[pt.events.Apsis(ellipse, direction=1)]).events[0]
    assert np.allclose(found.times, 2 * np.pi * np.arange(1, 7), rtol=1e-15, atol=0)
    found = pt.propagate(FREE, spinning(), [40.0], events=[pt.events.Apsis(ellipse, direction=-1)]).events[0]
    assert np.allclose(found.times, np.pi * np.arange(1, 13, 2), rtol=1e-15, atol=0)


@pytest.mark.parametrize("members", [False, True])
def test_orbits_that_are_integrated_along_and_actions_on_their_way(members):
    """The action must leave the variables of the orbit alone, and a body without forces may have such an event."""
    path = pt.orbits.ThreeBodyPath(
        3.1, 0.4, separation=2.5, position=(1.9, 0.7, 0.3), velocity=(-0.2, 0.1, 0.15), epoch=0.7
    )
    orbit, other = path.from_primary, path.from_secondary
    system = FREE if members else pt.System(BODY, pt.GravityGradient(orbit))
    start = spinning([1.5, 1.6] if members else 1.5, time=0.7)
    events = [pt.events.Apsis(orbit), Kick(0.1), pt.events.AttractorCrossing((1, 0, 0), other)]
    motion = pt.propagate(system, start, [3.0, 6.0], events=events)
    apsis, kicked, seen = motion.events
    r, v = (np.stack(x, axis=-1) for x in (orbit.position_at(apsis.times), orbit.velocity_at(apsis.times)))
    assert len(apsis) > 0
    assert np.max(np.abs(np.sum(r * v, axis=-1))) < 1.5e-12
    assert len(kicked) > 0
    assert len(seen) > 0
    downwards = -np.stack(other.position_at(seen.times), axis=-1)
    axes = seen.states.attitude.apply([1.0, 0.0, 0.0])
    assert np.max(np.abs(np.sum(downwards * axes, axis=-1))) < 1e-12
    environment = np.stack(motion.environment.position(orbit), axis=-1)
    assert np.allclose(environment, np.stack(orbit.position_at(motion.times), axis=-1), rtol=0, atol=1e-12)


def test_events_where_tables_change_their_polynomials():
    ellipse = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.2, inclination=0.2, node=0.3, argument_of_periapsis=0.4
    )
    table = pt.orbits.Ephemeris.from_function(
        1.0, position=lambda t: np.stack(ellipse.position_at(t), axis=-1), start=0.0, stop=13.0
    )
    system = pt.System(BODY, pt.GravityGradient(table))
    knots = table.knots[(table.knots > 0) & (table.knots < 13)][::3]
    events = [pt.events.Apsis(table, direction=1), *(pt.events.AtTime(knot) for knot in knots)]
    for rate in (0.5, [0.5, 0.6]):
        apsis, *at_knots = pt.propagate(system, spinning(rate), [0.0, 13.0], events=events).events
        assert np.allclose(apsis.member(0).times, 2 * np.pi * np.arange(1, 3), rtol=1e-12, atol=0)
        assert [len(found) for found in at_knots] == [np.size(rate)] * knots.size


def test_an_interrupt_keeps_the_events_so_far():
    pt.propagate(FREE, spinning(1.0), [1.0], events=[ACROSS])  # compiled before it
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(pt.PropagationInterrupted) as stop:
        pt.propagate(FREE, spinning(1.0), np.linspace(0, 1e9, 1001), events=[ACROSS])
    found = stop.value.trajectory.events[0]
    assert len(found) > 1
    assert np.allclose(found.times, (np.arange(len(found)) + 0.5) * np.pi, rtol=1e-14, atol=0)


def test_a_motion_without_events_has_none():
    assert pt.propagate(FREE, spinning(), [1.0]).events == ()
    motion = pt.propagate(FREE, spinning(), [1.0], events=[ACROSS])
    assert len(motion.events[0]) == 0
    assert motion.events[0].omega_body.shape == (0, 3)


def test_wrong_events_are_refused_in_a_sentence():
    def run(*events):
        pt.propagate(FREE, spinning(), [1.0], events=list(events))

    with pytest.raises(TypeError, match=r"events must be a list, each an Event, got AxisCrossing\."):
        pt.propagate(FREE, spinning(), [1.0], events=ACROSS)
    with pytest.raises(TypeError, match=r"events must be a list, each an Event, got list of AxisCrossing, int\."):
        run(ACROSS, 3)
    with pytest.raises(ValueError, match=r"direction must be -1, 0 or 1, got 2\."):
        pt.events.AtTime(1.0, direction=2)
    with pytest.raises(ValueError, match=r"Kick must either act or be terminal, but it does both\."):
        Kick(1.0, terminal=True)
    with pytest.raises(ValueError, match=r"axis must not be zero"):
        pt.events.RateCrossing((0, 0, 0))
    with pytest.raises(ValueError, match=r"angle must be in \(0, pi\), got 4\.0\."):
        pt.events.AxisCrossing((1, 0, 0), (1, 0, 0), angle=4.0)
    with pytest.raises(TypeError, match=r"a force must be a Potential, a Torque or a Part, got AxisCrossing\."):
        pt.System(BODY, ACROSS)

    class Wrong(pt.Event):
        def value(self, instant):
            return instant.omega_body

    with pytest.raises(TypeError, match=r"the value of Wrong must be one scalar, got 3 components\."):
        run(Wrong())

    class Constant(pt.Event):
        def value(self, instant):
            return 1.0

    with pytest.raises(ValueError, match=r"the value of Constant must depend on the motion, but it is constant"):
        run(Constant())

    class Odd(Kick):
        def act(self, body, state):
            return 3

    sentence = r"of 9: Odd\.act failed with TypeError: an action must return a State of one body, got int\.$"
    with pytest.raises(pt.PropagationError, match=sentence) as caught:
        pt.propagate(FREE, spinning(), [9.0], events=[Odd(1.0)])
    assert isinstance(caught.value.__cause__, TypeError)
