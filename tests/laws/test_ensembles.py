"""An ensemble is its members run alone: states, events, failures, whatever else is in the batch."""

import functools
import itertools
import re

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.integration import equations, run
from poinsot.taylor import queue

MOST = 17
BODY = pt.Body((1.0, 1.3, 1.7))
RNG = np.random.default_rng(14)
ATTITUDES = RNG.normal(size=(MOST, 4))
ATTITUDES /= np.linalg.norm(ATTITUDES, axis=-1, keepdims=True)
RATES = RNG.normal(0, 0.8, (MOST, 3))
TIMES = {
    "forwards": np.linspace(1.1, 9.1, 9),
    "backwards": -np.linspace(1.1, 9.1, 9),
    "both ways": np.linspace(-6.05, 7.05, 14),
}
STARTS = {"together": np.zeros(MOST), "apart": RNG.uniform(-1, 1, MOST)}
BASE = np.array([-2.0, -1.0, 0.3, 1.0, 2.5, 4.0])
SPECIAL_TIMES = {
    "in clusters": np.unique([BASE + k * np.spacing(BASE) for k in (-3, -1, 0, 1, 2, 7, 1000, 10**5)]),
}
SPECIAL_STARTS = {"in clusters": np.concatenate([BASE, BASE + np.spacing(BASE), BASE - 2 * np.spacing(BASE)])[:MOST]}

WITHIN = 1e-12
"""Tens of steps of 1e-16, and what the passages of kicks and branches make of it: some hundred times; 3e-14 is seen."""


class Edge(pt.Torque):
    """A torque that there is only to one side of a time."""

    instant: float
    side: float

    def torque(self, instant):
        return 0.1 * fn.sqrt(self.side * (instant.time - self.instant)) * fn.Vector((0.0, 0.3, 0.2))


class Thruster(pt.Torque):
    """A torque between two times."""

    begin: float
    off: float

    def torque(self, instant):
        burns = fn.where(fn.less(instant.time, self.begin), 0.0, fn.where(fn.less(instant.time, self.off), 0.3, 0.0))
        return burns * fn.Vector((0.5, -1.0, 0.8))


class BangBang(pt.Torque):
    """A torque against the tilt of an axis."""

    size: float

    def torque(self, instant):
        _, sine, _ = instant.attitude.to_body((-1, 0, 0))
        return fn.Vector((0.1, 0.0, self.size * fn.where(fn.less(sine, 0.0), 1.0, -1.0)))


class Saturated(pt.Torque):
    """A damping torque with a largest size."""

    gain: float

    def torque(self, instant):
        wanted = [-self.gain * rate for rate in instant.omega_body]
        limited = [fn.where(fn.less(x, -0.05), -0.05, fn.where(fn.less(0.05, x), 0.05, x)) for x in wanted]
        return fn.Vector(limited)


class Kick(pt.events.AxisCrossing):
    """What turns and shortens the momentum."""

    factor: float

    def act(self, body, state):
        x, y, z = state.angular_momentum_body
        return body.state(state.quaternion, angular_momentum_body=self.factor * np.array([y, -x, z]), time=state.time)


LOW = pt.KeplerOrbit(1.0, semimajor_axis=1.6, eccentricity=0.2, inclination=0.5, node=0.3, argument_of_periapsis=0.7)
TABLE = pt.orbits.Ephemeris.from_function(
    1.0, position=lambda t: np.stack(list(LOW.position_at(t)), -1), start=-12.0, stop=12.0
)
GAINS = RNG.uniform(0.05, 0.3, MOST)
SWITCHES = ("none", "time", "attitude", "rate", "table", "members' times")


def force(switch, i):
    return {
        "none": pt.UniformGravity(GAINS[i], (0.3, 0.1, 1.0)),
        "time": Thruster(0.7, 3.3),
        "attitude": BangBang(GAINS[i]),
        "rate": Saturated(GAINS[i]),
        "table": pt.GravityGradient(TABLE),
        "members' times": Thruster(np.linspace(-3, 3, MOST)[i], np.linspace(4, 8, MOST)[i]),
    }[switch]


RECORDED = pt.events.RateCrossing((0.2, 1.0, 0.1))
TERMINAL = pt.events.AxisCrossing((0, 1, 0), (0.3, 0, 1), angle=0.4, terminal=True)
FACTORS = RNG.uniform(0.7, 1.1, MOST)


EVENTS = ("none", "recorded", "terminal", "acting", "all")


def watched(events, i):
    acting = Kick((0, 0, 1), (1, 0.2, 0), factor=FACTORS[i], direction=1)
    return {
        "none": [],
        "recorded": [RECORDED],
        "terminal": [TERMINAL],
        "acting": [acting],
        "all": [RECORDED, acting, TERMINAL],
    }[events]


EDGES = np.full(MOST, -40.0)
EDGES[[0, 5, 6, 8, 15]] = 4.55, 2.62, -4.7, 6.43, -2.41  # between the times
SIDES = np.where(EDGES > 0, -1.0, 1.0)


def system(switch, fails, i):
    forces = [Edge(EDGES[i], SIDES[i])] if fails else []
    return pt.System(BODY, force(switch, i), *forces)


def state(starts, i):
    return BODY.state(ATTITUDES[i], omega_body=RATES[i], time=(STARTS | SPECIAL_STARTS)[starts][i])


@functools.cache
def alone(switch, events, starts, way, fails, i):
    """Return the motion of one member, and the sentence if it failed."""
    times, sentence = (TIMES | SPECIAL_TIMES)[way], None
    try:
        motion = pt.propagate(system(switch, fails, i), state(starts, i), times, events=watched(events, i))
    except pt.PropagationError as error:
        motion, sentence = error.trajectory, str(error)
    assert sentence is None or reaches_its_edge(motion.times, times, i), sentence
    return motion, sentence


def reaches_its_edge(reached, times, i):
    """Return True if a failed member has rows at all times before its end."""
    sign = -SIDES[i]
    before = sign * times[sign * times < sign * EDGES[i]]
    return not before.size or np.max(sign * reached) == np.max(before)


def wrong_members(switch, events, starts, way, fails, members, threads):
    """Return what is wrong with whom in an ensemble."""
    every = np.arange(members)
    times, chosen = (TIMES | SPECIAL_TIMES)[way], watched(events, every)
    together = pt.propagate(system(switch, fails, every), state(starts, every), times, events=chosen, threads=threads)
    found = {i: wrong_member(together, i, *alone(switch, events, starts, way, fails, i)) for i in range(members)}
    return {i: what for i, what in found.items() if what}


def wrong_member(together, i, motion, sentence):
    """Return what differs between a member of an ensemble and its motion alone."""
    if output(together.failures.get(i)) != output(sentence):
        return f"failure {together.failures.get(i)!r}, alone {sentence!r}"
    rows = np.concatenate([together.quaternion[i], together.conjugate_momenta[i]], axis=-1)
    whole = np.isfinite(rows).all(axis=-1)
    if not np.array_equal(together.times[whole], motion.times):
        return f"times {together.times[whole]}, alone {motion.times}"
    if not near(rows[whole], np.concatenate([motion.quaternion, motion.conjugate_momenta], axis=-1)):
        return "states"
    return next(filter(None, map(wrong_event, [found.member(i) for found in together.events], motion.events)), "")


def wrong_event(ours, theirs):
    """Return what differs between the passages of an event in an ensemble and alone."""
    if (
        len(ours) != len(theirs)
        or not near(ours.times, theirs.times)
        or not np.array_equal(ours.directions, theirs.directions)
    ):
        return f"event at {ours.times}, alone {theirs.times}"
    pairs = [(getattr(ours.states, name), getattr(theirs.states, name)) for name in ("quaternion", "conjugate_momenta")]
    return "" if all(near(*pair) for pair in pairs) else f"states of the event at {ours.times}"


def near(a, b):
    return np.allclose(a, b, rtol=0, atol=WITHIN)


def output(sentence):
    """Return a sentence with its numbers to five digits: steps towards an edge depend on the scales of events."""
    return sentence and re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda number: f"{float(number[0]):.5g}", sentence)


def covering(*levels):
    """Return cases that have each pair of levels of two factors, as few as a greedy choice needs."""
    cases = list(itertools.product(*levels))
    places = list(itertools.combinations(range(len(levels)), 2))
    missing = {(a, b, case[a], case[b]) for case in cases for a, b in places}
    chosen = []
    while missing:
        best = max(cases, key=lambda case: sum((a, b, case[a], case[b]) in missing for a, b in places))
        missing -= {(a, b, best[a], best[b]) for a, b in places}
        chosen.append(best)
    return chosen


COUNTS, THREADS, CHUNKS = (1, 7, 8, 9, MOST), (1, 2), (5000, 50)


@pytest.mark.parametrize(
    ("switch", "events", "starts", "way", "members", "threads", "chunk"),
    covering(SWITCHES, ("none", "all"), STARTS, TIMES, COUNTS, THREADS, CHUNKS),
)
def test_an_ensemble_is_its_members_alone(switch, events, starts, way, members, threads, chunk, monkeypatch):
    advance = queue.Worker.advance
    monkeypatch.setattr(queue.Worker, "advance", lambda run, budget=None: advance(run, budget or chunk))
    monkeypatch.setattr(run, "MAX_SLAB_BYTES", 1)
    assert wrong_members(switch, events, starts, way, True, members, threads) == {}


@pytest.mark.parametrize(
    ("switch", "events", "starts", "way", "members"),
    [
        ("time", "all", "together", "both ways", 7),
        ("table", "acting", "together", "forwards", 9),
        ("rate", "all", "together", "backwards", 9),
    ],
)
def test_a_failure_after_an_event_at_which_steps_begin(switch, events, starts, way, members):
    """There the engine takes steps of length 0, by which a rehearsal of steps and the steps differ."""
    assert wrong_members(switch, events, starts, way, True, members, 1) == {}


# ---------------------------------------------------------------------- members taken out


def same_motion(one, other):
    """Whether two motions have the same numbers bit for bit."""
    arrays = [(a.times, *a.phase.values(), a.energy, *a.drift.values()) for a in (one, other)]
    events = [[(e.times, *e.states.phase.values(), e.directions, e.omega_body) for e in a.events] for a in (one, other)]
    return all(map(np.array_equal, *arrays)) and all(
        all(map(np.array_equal, *pair)) for pair in zip(*events, strict=True)
    )


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # a root outside its range, in a trial
@pytest.mark.parametrize(("switch", "fails"), [("none", True), ("table", False), ("members' times", True)])
def test_a_member_of_an_ensemble_is_its_run_alone(switch, fails):
    every, case = np.arange(9), ("apart", "both ways", fails)
    given = system(switch, fails, every), state("apart", every), TIMES["both ways"]
    together = pt.propagate(*given, events=watched("all", every))
    for i in every.tolist():
        one, (motion, sentence) = together.member(i), alone(switch, "all", *case, i)
        assert output(one.failures.get(0)) == output(sentence)
        assert one.failures.get(0) == together.failures.get(i)
        reached = np.isfinite(together.quaternion[i, :, 0])
        assert np.array_equal(one.times, motion.times)
        assert all(np.array_equal(one.phase[name], rows[i, reached]) for name, rows in together.phase.items())
        assert np.array_equal(one.kinetic_energy, together.kinetic_energy[i, reached])
        assert np.allclose(one.energy, motion.energy, rtol=0, atol=WITHIN)
        assert one.system.dynamics.numbers == motion.system.dynamics.numbers
        assert [e.event.numbers for e in one.events] == [e.event.numbers for e in motion.events]
        assert not any(map(wrong_event, one.events, motion.events))
        assert all(
            np.array_equal(e.times, whole.member(i).times) for e, whole in zip(one.events, together.events, strict=True)
        )
    again = pt.propagate(one.system, one.initial, one.times, events=[e.event for e in one.events])
    assert same_motion(again, pt.propagate(motion.system, motion.initial, motion.times, events=watched("all", i)))


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_members_of_members_are_members():
    every = np.arange(9)
    given = system("members' times", True, every), state("apart", every), TIMES["both ways"]
    together = pt.propagate(*given, events=watched("all", every))
    order = [7, 0, 5, 5, 2]
    some = together.isel(member=order)
    assert len(some) == len(some.quaternion) == 5
    assert some.failures == {1: together.failures[0], 2: together.failures[5], 3: together.failures[5]}
    for new, old in enumerate(order):
        assert same_motion(some.member(new), together.member(old))
    chosen = np.isin(every, [3, 4, 5])
    for other in (together[3:6], together.isel(member=chosen), together.isel(member=[3, 4, -4])):
        assert other.failures == {2: together.failures[5]}
        assert all(same_motion(other[k], together[k + 3]) for k in range(3))
    assert [motion.failures.get(0) for motion in together] == [together.failures.get(i) for i in range(9)]


class Broken(pt.Torque):
    """A torque that is no number from a time on."""

    instant: float

    def torque(self, instant):
        x = instant.attitude.to_body((0, 0, 1))[0]
        return fn.Vector((0.0, 0.1, 0.0)) * fn.sqrt(fn.where(fn.less(instant.time, self.instant), 1.0, -2.0) + x * x)


def test_times_that_lanes_pass_while_another_fails():
    """One member fails between two steps, in which the others pass tens of times."""
    times, instants = np.linspace(0, 5, 501), np.full(7, 10.0)
    instants[[2, 5]] = 1.2345, 2.3456
    every = range(7)
    together = pt.propagate(pt.System(BODY, Broken(instants)), state("together", np.array(every)), times, threads=1)
    assert sorted(together.failures) == [2, 5]
    for i in every:
        motion = pt.propagate(pt.System(BODY, Broken(10.0)), state("together", i), times)
        reached = times < instants[i]
        assert np.array_equal(np.isfinite(together.quaternion[i, :, 0]), reached)
        assert near(together.quaternion[i, reached], motion.quaternion[reached])
        assert i not in together.failures or f"stopped at t = {instants[i]:.5g} of 5:" in together.failures[i]


def test_a_member_that_fails_both_ways_says_what_it_says_alone():
    system = pt.System(BODY, Edge([4.55, 40.0], [-1.0, -1.0]), Edge([-2.41, -40.0], [1.0, 1.0]))
    together = pt.propagate(system, state("together", [0, 1]), TIMES["both ways"])
    with pytest.raises(pt.PropagationError) as caught:
        pt.propagate(pt.System(BODY, Edge(4.55, -1.0), Edge(-2.41, 1.0)), state("together", 0), TIMES["both ways"])
    assert {i: output(why) for i, why in together.failures.items()} == {0: output(str(caught.value))}
    assert np.array_equal(together.times[np.isfinite(together.quaternion[0, :, 0])], caught.value.trajectory.times)


@pytest.mark.parametrize(("switch", "events"), [("none", "none"), ("rate", "all")])
def test_times_between_which_there_is_no_room(switch, events):
    """The engine wants grids of one length, which are filled up between times."""
    assert wrong_members(switch, events, "in clusters", "in clusters", False, MOST, 1) == {}


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_any_ensemble_is_its_members_alone(lanes, monkeypatch):
    monkeypatch.setattr(equations, "LANES", lanes)
    wrong, tried = {}, 0
    for case in itertools.product(SWITCHES, EVENTS, STARTS, TIMES, (False, True), COUNTS, THREADS):
        found = wrong_members(*case)
        tried += 1
        if found:
            wrong[case] = found
    print(f"{lanes} lanes: {tried} ensembles, {len(wrong)} bad")
    assert wrong == {}


# ---------------------------------------------------------------------- what runs ensembles


def both(system_of, starts, call):
    """Return the result of a call for nine members, and those of each alone with the sentences of failures."""
    every = np.arange(9)
    alone = []
    for i in every:
        try:
            alone.append((call(system_of(i), state(starts, i)), None))
        except pt.PropagationError as error:
            alone.append((error.trajectory, str(error)))
    return call(system_of(every), state(starts, every)), alone


@pytest.mark.parametrize(("switch", "fails", "chunk"), [("table", True, 10), ("members' times", False, 700)])
def test_state_transitions_are_those_of_members_alone(switch, fails, chunk, monkeypatch):
    monkeypatch.setattr(run, "STEPS_AT_A_TIME", {1: chunk})

    def call(*given):
        return pt.analysis.state_transition(*given, TIMES["both ways"])

    together, found = both(functools.partial(system, switch, fails), "apart", call)
    for i, (one, sentence) in enumerate(found):
        assert output(together.motion.failures.get(i)) == output(sentence)
        size = np.max(np.abs(one.matrix), axis=(1, 2), keepdims=True)
        np.testing.assert_allclose(together.matrix[i] / size, one.matrix / size, rtol=0, atol=WITHIN)
        np.testing.assert_allclose(together.motion.quaternion[i], one.motion.quaternion, rtol=0, atol=WITHIN)
    motion, _ = alone(switch, "none", "apart", "both ways", fails, 7)
    assert near(together.motion.quaternion[7], motion.quaternion)


def test_second_derivatives_are_those_of_members_alone(monkeypatch):
    monkeypatch.setattr(run, "STEPS_AT_A_TIME", {2: 20})

    def call(*given):
        return pt.analysis.state_transition(*given, TIMES["both ways"], order=2)

    together, found = both(functools.partial(system, "members' times", False), "together", call)
    for i, (one, _) in enumerate(found):
        assert np.allclose(together.second[i], one.second, rtol=0, atol=1e-11 * np.max(np.abs(one.second)))


@pytest.mark.parametrize("way", ["forwards", "backwards"])
def test_indicators_are_those_of_members_alone(way):
    """Members that an edge stops fail; those that start behind one, at other times, must not go there."""
    turn = 1.0 if way == "forwards" else -1.0
    edges, sides = STARTS["apart"][:9] - 0.1 * turn, np.full(9, turn)
    edges[[2, 7]], sides[[2, 7]] = 4.55 * turn, -turn

    def system_of(i):
        return pt.System(BODY, force("members' times", i), Edge(edges[i], sides[i]))

    def call(*given):
        return pt.analysis.chaos_indicators(*given, TIMES[way], vectors=2, momentum_unit=1.0)

    together, found = both(system_of, "apart", call)
    assert sorted(together.failures) == [2, 7]
    for i, (one, sentence) in enumerate(found):
        assert output(together.failures.get(i)) == output(sentence)
        for name in ("growth", "gali"):  # the others are sampled more densely where another member is faster
            assert np.allclose(getattr(together, name)[i], getattr(one, name), rtol=0, atol=1e-10, equal_nan=True)
        assert np.all(np.isfinite(together.mean_megno[i]) == np.isfinite(one.mean_megno))


@pytest.mark.parametrize("switch", ["none", "time", "members' times"])
def test_units_of_indicators_are_those_of_members_alone(switch):
    def call(*given):
        return pt.analysis.chaos_indicators(*given, TIMES["forwards"], vectors=2)

    together, found = both(functools.partial(system, switch, False), "together", call)
    for i, (one, _) in enumerate(found):
        assert one.momentum_unit == together.momentum_unit[i]
        assert np.allclose(together.growth[i], one.growth, rtol=0, atol=1e-10)


def test_spectra_do_not_depend_on_the_order_of_members():
    """Alone they have other times of orthogonalisation."""
    order = np.random.default_rng(0).permutation(9)
    one, other = (
        pt.analysis.lyapunov_spectrum(system("members' times", True, i), state("together", i), [1.0, 3.0, 7.0])
        for i in (np.arange(9), order)
    )
    np.testing.assert_allclose(one.exponents[order], other.exponents, rtol=0, atol=1e-10)
    assert one.failures == {int(order[i]): why for i, why in other.failures.items()}
    assert sorted(one.failures) == [0, 5, 8]


def test_sections_are_those_of_members_alone():
    def section_of(motion):
        return pt.analysis.section(motion, lambda points: (points.times, points.omega_body[:, 2]), 0)

    every = np.arange(9)
    given = system("rate", True, every), state("apart", every), TIMES["both ways"]
    together = section_of(pt.propagate(*given, events=watched("all", every)))
    for i in every:
        one = section_of(alone("rate", "all", "apart", "both ways", True, int(i))[0])
        points = np.isfinite(together.x[i])
        assert near(together.x[i][points], one.x[0])
        assert near(together.y[i][points], one.y[0])


@pytest.mark.parametrize("switch", ["attitude", "rate", "members' times"])
def test_a_run_depends_on_nothing_that_another_has_left(switch):
    """Integrators are lent again bit for bit as they were made."""
    given = system(switch, False, 3), state("apart", 3), TIMES["both ways"]
    first = pt.propagate(*given)
    for i in range(MOST):
        pt.propagate(system(switch, False, i), state("apart", i), TIMES["forwards"])
        assert np.array_equal(pt.propagate(*given).quaternion, first.quaternion)
