"""A run that is joined at any of its rows equals the whole run: at samples, events that act, knots and impulses."""

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import poinsot as pt
from kinds.control_laws import SAMPLED
from kinds.parts import BODY as MASSIVE
from kinds.parts import PARTS, started
from kinds.sampled_systems import BODY, START, SYSTEMS, TABLE
from poinsot.control import NoisySensors, RateDamping, Sampled
from poinsot.functions import Vector

BOUND = 1e-13
"""Difference of each variable relative to its largest value: above three times 2.6e-14, the worst of four perturbed
runs of all tests here on 2, 4 and 8 lanes. A saturated law and growing momenta multiply the rounding of a row."""


class Remembering(pt.Part, pt.Torque):
    """A controller that adds up what noisy sensors measure: an update that acts twice changes its memory."""

    gain: float
    period: float
    offset: float = 0.0
    variables = {"torque": 3, "sum": 3}  # noqa: RUF012

    @property
    def jump(self):
        return pt.mechanics.Jump(self.period, self.offset, draws=3, seed=5)

    def update(self, instant, draws):
        total = Vector(instant.own(self)[3:]) + self.period * (instant.omega_body + 0.01 * draws)
        return Vector((*(-self.gain * (instant.omega_body + 0.2 * total)), *total))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return Vector((0.0,) * 6)

    def torque(self, instant):
        return Vector(instant.own(self)[:3])


class Summing(pt.Part, pt.Torque):
    """The controller with a memory of the documentation."""

    gain: float
    period: float
    variables = {"torque": 3, "sum": 3}  # noqa: RUF012

    @property
    def jump(self):
        return pt.mechanics.Jump(self.period, offset=0.0)

    def update(self, instant, draws):  # noqa: ARG002
        total = Vector(instant.own(self)[3:]) + self.period * instant.omega_body
        return Vector((*(-self.gain * (instant.omega_body + 0.1 * total)), *total))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return Vector((0.0,) * 6)

    def torque(self, instant):
        return Vector(instant.own(self)[:3])


class Held(pt.Part, pt.Torque):
    """A torque that an event sets."""

    variables = {"torque": 3}  # noqa: RUF012

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return Vector((0.0,) * 3)

    def torque(self, instant):
        return instant.own(self)


class Controller(pt.Event):
    """An action in each period that adds to the torque that is held."""

    period: float

    def value(self, instant):
        return pt.functions.sin(np.pi * instant.time / self.period)

    def act(self, body, state):
        torque = 0.5 * state.own["held"] - 0.4 * body.omega(state.angular_momentum_body)
        return pt.State(state.quaternion, state.conjugate_momenta, state.time, own={"held": torque})


def kicked(state, impulse):
    momenta = pt.State(state.quaternion, state.conjugate_momenta).angular_momentum_body + impulse
    return BODY.state(state.quaternion, angular_momentum_body=momenta, time=state.time)


class Kick(pt.events.AtTime):
    """An impulse at a time."""

    impulse: pt.BodyVector

    def act(self, body, state):  # noqa: ARG002
        return kicked(state, self.impulse)


class SampledKick(pt.events.AtTime):
    """An impulse on a body with parts."""

    impulse: pt.BodyVector

    def act(self, body, state):
        momenta = state.angular_momentum_body + self.impulse
        return body.locked.state(state.quaternion, angular_momentum_body=momenta, time=state.time)


class Push(pt.events.AtTime):
    """A tenth more momentum."""

    def act(self, body, state):  # noqa: ARG002
        return pt.State(state.quaternion, 1.1 * state.conjugate_momenta, state.time, own=state.own)


class Damper(pt.events.RateCrossing):
    """An impulse where a rate passes a value."""

    impulse: pt.BodyVector

    def act(self, body, state):  # noqa: ARG002
        return kicked(state, self.impulse)


def values(motion):
    """All variables of a motion."""
    return np.concatenate(list(motion.phase.values()), axis=-1)


def difference(part, whole):
    """The largest difference of variables, relative to the largest value of each."""
    whole = values(whole)
    size = np.maximum(np.max(np.abs(whole), axis=-2, keepdims=True), 1e-3)
    return np.max(np.abs(values(part) - whole[..., -values(part).shape[-2] :, :]) / size)


def joined(whole, times, rows=None, **options):
    """The largest difference of runs that start at each of the rows of a motion from the motion."""
    rows = whole if rows is None else rows
    differences = []
    for k in range(times.size - 1):
        rest = pt.propagate(whole.system, rows.isel(time=k), times[k:], **options)
        differences.append(difference(rest, whole))
    return max(differences)


SAMPLED_TIMES = np.array([0.0, 0.1, 0.25, 0.3, 0.4, 0.7, 1.0, 1.3, 1.9, 2.5, 2.6])
"""Among them samples of a period of 0.3 with the offsets 0 and 0.1, and of a period of 0.2 with the offset 0.1."""

LAWS = SYSTEMS | {f"control law {k}": (law,) for k, law in enumerate(SAMPLED)}
LAWS |= {"a memory with noise": (Remembering(0.9, 0.3, 0.1),), "two": (Remembering(0.9, 0.3), *SYSTEMS["feedback"])}


@pytest.mark.parametrize("name", LAWS)
def test_a_run_goes_on_from_its_samples(name):
    system = pt.System(BODY, *LAWS[name])
    whole = pt.propagate(system, system.state(**START), SAMPLED_TIMES, dense=True)
    assert joined(whole, SAMPLED_TIMES) < BOUND
    for k in (4, 7):
        rest = pt.propagate(system, whole(SAMPLED_TIMES[k]), SAMPLED_TIMES[k:])
        assert difference(rest, whole) < BOUND


def test_a_row_next_to_a_sample_is_before_or_after_it():
    """Also where the distances of both times from the start of a step are equal after rounding."""
    system, samples = pt.System(BODY, Remembering(0.9, 0.3, 0.1)), 0.3 * np.arange(3) + 0.1
    around = np.stack([np.nextafter(samples, -9), samples, np.nextafter(samples, 9)], axis=-1)
    starts = np.random.default_rng(8).uniform(-0.15, 0.0, 20)
    motion = pt.propagate(system, system.state(**START, time=starts), around.ravel())
    total = motion.own["remembering"][..., 3:].reshape(20, 3, 3, 3)
    assert np.array_equal(total[:, :, 1], total[:, :, 2])
    assert np.min(np.max(np.abs(total[:, :, 1] - total[:, :, 0]), axis=-1)) > 1e-2


def test_an_impulse_at_a_sample_comes_in_one_order_from_any_row():
    """The zero of an event is found to rounding: it must not fall before the sample from one row and after it from
    another."""
    law = Sampled(RateDamping(0.8, 5.0), 0.25, sensors=NoisySensors(1e-2, seed=3.0))
    system, events = pt.System(BODY, law), [SampledKick(0.5, (0.1, -0.2, 0.05))]
    first = np.sort(np.random.default_rng(3).uniform(0.05, 0.45, 40))
    times = np.unique([*first, 0.25, np.nextafter(0.25, 0), np.nextafter(0.25, 9), 0.5, 0.6, 1.0])
    assert joined(pt.propagate(system, system.state(**START), times, events=events), times, events=events) < BOUND


def test_two_joined_runs_equal_an_integration_from_sample_to_sample():
    """The equations of SciPy's integration share nothing with the package; an update that acts twice is off by 1e-2."""
    moments, rate, total = np.array([6.0, 8.0, 10.0]), np.array([0.1, 0.2, 0.3]), np.zeros(3)
    system = pt.System(pt.Body(moments), Summing(4.0, 0.5))
    whole = pt.propagate(system, system.state((0.6, 0, 0.8, 0), omega_body=rate), [0.0, 5.0, 5.2, 10.0])
    for _ in range(20):
        total = total + 0.5 * rate
        torque = -4.0 * (rate + 0.1 * total)

        def turning(_, w, torque=torque):
            return (np.cross(moments * w, w) + torque) / moments

        rate = solve_ivp(turning, (0, 0.5), rate, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    for k in range(4):
        last = pt.propagate(system, whole.isel(time=k), [10.0]).omega_body[0] if k < 3 else whole.omega_body[3]
        # 20 integrations to 1e-13 of rates below 0.4.
        assert np.max(np.abs(last - rate)) < 20 * 1e-13 * 0.4


@pytest.mark.parametrize("chosen", [slice(None), [3, 1], 2], ids=["all", "some", "one"])
def test_members_remember_their_own_samples(chosen):
    periods, offsets = np.array([0.3, 0.2, 0.3, 0.25, 0.6]), np.array([0.1, 0.1, 0.0, 0.0, 0.7])
    noisy = Sampled(RateDamping(0.5, 5.0), periods, offsets, NoisySensors(1e-2, seed=3.0), name="noisy")
    system = pt.System(BODY, Remembering(0.9, periods, offsets), noisy)
    whole = pt.propagate(system, system.state(**START, time=np.array([0.0, 0.0, -0.2, 0.0, 0.0])), SAMPLED_TIMES)
    some = whole.isel(member=chosen)
    assert joined(some, SAMPLED_TIMES) < BOUND
    done = [whole.isel(time=k).jumped["remembering"].tolist() for k in (4, 5)]
    # In floating point 3 * 0.2 + 0.1 is one rounding after 0.7.
    assert done == [[True, False, False, False, False], [True, False, False, False, True]]
    assert np.array_equal(some.isel(time=4).jumped["noisy"], np.array(done[0])[chosen])


WAYS: dict[str, Any] = {
    "NetCDF": lambda motion, folder: pt.load(pt.save(motion, folder / "motion.nc")),
    "Zarr": lambda motion, folder: pt.load(pt.save(motion, folder / "motion.zarr")),
    "Zarr of NetCDF": lambda motion, folder: pt.load(pt.save(WAYS["NetCDF"](motion, folder), folder / "again.zarr")),
    "dataset": lambda motion, _: pt.load(motion.dataset),
    "pickle": lambda motion, _: pickle.loads(pickle.dumps(motion)),
    "deep copy": lambda motion, _: copy.deepcopy(motion),
}
PERIODS = np.array([0.3, 0.2, 0.6])
REMEMBERED = {
    "outside the package": lambda: (Remembering(0.9, 0.3),),
    "outside, of members": lambda: (Remembering(0.9, PERIODS, 0.1),),
    "of the package": lambda: (Sampled(RateDamping(0.5, 5.0), 0.3, 0.1, NoisySensors(1e-2, seed=3.0)),),
    "of the package, of members": lambda: (Sampled(RateDamping(PERIODS, 5.0), PERIODS, 0.1),),
}


@pytest.mark.parametrize("name", REMEMBERED)
@pytest.mark.parametrize("way", WAYS)
def test_rows_of_files_and_copies_remember_their_samples(name, way, tmp_path):
    system = pt.System(BODY, *REMEMBERED[name]())
    whole = pt.propagate(system, system.state(**START), SAMPLED_TIMES)
    assert joined(whole, SAMPLED_TIMES, WAYS[way](whole, tmp_path)) < BOUND
    for folder in ("late", "one"):
        (tmp_path / folder).mkdir()
    late = pt.propagate(system, whole.isel(time=4), SAMPLED_TIMES[4:])
    again = pt.propagate(system, WAYS[way](late, tmp_path / "late").initial, SAMPLED_TIMES[4:])
    assert np.array_equal(values(again), values(late))
    if whole.is_ensemble:
        one = WAYS[way](whole[2], tmp_path / "one")
        assert joined(whole[2], SAMPLED_TIMES, one) < BOUND
        assert one.isel(time=5).jumped == {next(iter(whole.own)): True}


@pytest.mark.parametrize("name", [name for name in REMEMBERED if name.endswith("members")])
def test_rows_of_stores_remember_their_samples(name, tmp_path):
    system = pt.System(BODY, *REMEMBERED[name]())
    start = system.state(**START)
    whole = pt.propagate(system, start, SAMPLED_TIMES)
    made = pt.propagate(system, start, SAMPLED_TIMES, out=tmp_path / "store.zarr", chunk=2)
    for stored in (made, pt.load(tmp_path / "store.zarr")):
        assert joined(whole, SAMPLED_TIMES, stored) < BOUND
        assert joined(whole[1], SAMPLED_TIMES, stored[1]) < BOUND


def test_a_store_of_other_memories_is_another_one(tmp_path):
    system = pt.System(BODY, Remembering(np.array([0.9, 0.5]), 0.3))
    row = pt.propagate(system, system.state(**START), [0.3]).isel(time=0)
    pt.propagate(system, row, [1.0], out=tmp_path / "store.zarr", chunk=1)
    forgotten = pt.State(row.quaternion, row.conjugate_momenta, row.time, own=row.own)
    with pytest.raises(ValueError, match="store"):
        pt.propagate(system, forgotten, [1.0], out=tmp_path / "store.zarr", chunk=1)


def test_states_of_the_user_have_no_memory():
    """A run from a state that a user makes at a sample begins with it, also from the numbers of a row."""
    system = pt.System(BODY, Remembering(0.9, 0.3, 0.1))
    row = pt.propagate(system, system.state(**START), SAMPLED_TIMES).isel(time=4)
    made = pt.State(row.quaternion, row.conjugate_momenta, row.time, own=row.own)
    expected = row.own["remembering"][3:] + 0.3 * system.omega_body(row)
    rates = pt.System(BODY, Remembering(0.9, 0.3, 0.1)).state
    for state in (made, rates(row.quaternion, omega_body=system.omega_body(row), time=row.time, **row.own)):
        first = pt.propagate(system, state, [0.4, 0.5]).own["remembering"][0, 3:]
        # The noise of a sample is 0.01 of a normal distribution in each of three rates, times the period.
        assert 0 < np.max(np.abs(first - expected)) < 0.3 * 0.01 * 6
    assert np.array_equal(pt.propagate(system, row, [0.4]).own["remembering"][0], row.own["remembering"])


def test_a_memory_is_of_the_part_with_a_name():
    """A controller of another name, or one whose predecessor had no sample at the time of the row, is sampled there."""
    first, other = (pt.System(BODY, Remembering(0.9, period, name="law")) for period in (0.3, 0.25))
    whole = pt.propagate(first, first.state(**START), [0.3, 0.5, 1.5])
    done = [np.array_equal(pt.propagate(other, row, [row.time]).own["law"][0], row.own["law"]) for row in whole]
    assert done == [True, False, True]
    assert [bool(row.jumped["law"]) for row in whole] == [True, False, True]


# ---------------------------------------------------------------------- events that act

KICKS = {
    "impulse": [Kick(1.5, (0.3, -0.2, 0.1))],
    "impulses at once": [Kick(1.5, (0.3, -0.2, 0.1)), pt.events.AtTime(1.5), Kick(1.5, (-0.1, 0.0, 0.2))],
    "impulse at a rate": [Damper((0, 1, 0), BODY.inertia @ (-0.02, 0.0, 0.03), direction=1)],
}


def times_around(times):
    """Times, the doubles next to them, and others between."""
    return np.unique([*np.nextafter(times, -9), *times, *np.nextafter(times, 9), *np.linspace(-1.9, 4.0, 6)])


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical", "euler_angles"])
@pytest.mark.parametrize("way", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("name", KICKS)
def test_a_run_goes_on_from_its_actions(name, way, formulation):
    system, events = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0))), KICKS[name]
    state = BODY.state(**START, time=-2.0 if way > 0 else 5.0)
    known = pt.propagate(system, state, [4.5 if way > 0 else -2.5], events=events, formulation=formulation)
    acted = np.unique(np.concatenate([found.times for found in known.events]))
    times = times_around(acted)[::way]
    given = {"events": events, "formulation": formulation}
    whole = pt.propagate(system, state, times, dense=True, **given)
    assert [len(found) for found in whole.events] == [len(found) for found in known.events]
    assert acted.size > 0
    assert joined(whole, times, **given) < BOUND
    for time in [*acted, *np.nextafter(acted, -9), *np.nextafter(acted, 9)]:
        ahead = times[way * times > way * time][1:]
        assert difference(pt.propagate(system, whole(time), ahead, **given), whole) < BOUND


def test_a_row_at_an_action_has_the_state_after_it():
    impulse = np.array((0.3, -0.2, 0.1))
    system, times = pt.System(BODY), [1.0, 1.5, 2.0]
    for last in (2, 3):
        motion = pt.propagate(system, BODY.state(**START), times[:last], events=[Kick(1.5, impulse)], dense=True)
        before = motion.events[0].states.angular_momentum_body[0]
        for after in (motion.isel(time=1), motion(1.5)):
            # Three times the worst of four perturbed runs: roundings of momenta below 1.
            assert np.max(np.abs(after.angular_momentum_body - before - impulse)) < 1e-15


@pytest.mark.parametrize("part", [part for part in PARTS if part.size], ids=lambda part: type(part).__name__)
def test_a_run_with_a_part_goes_on_from_a_kick(part):
    system, times = pt.System(MASSIVE, part), np.array([0.3, 1.0, 1.1, 2.0, 2.3])
    given = {"events": [Push(1.0), Push(2.0)]}
    assert joined(pt.propagate(system, started(system), times, **given), times, **given) < BOUND


def test_a_controller_by_events_goes_on():
    system, times = pt.System(BODY, Held()), np.array([0.0, 0.25, 0.5, 0.6, 1.0, 1.5, 2.0, 2.2])
    whole = pt.propagate(system, system.state(**START), times, events=[Controller(0.5)])
    assert len(whole.events[0]) == 4
    assert joined(whole, times, events=[Controller(0.5)]) < BOUND


@pytest.mark.parametrize("name", ["pointing along a table, two controllers", "a memory", "feedback and gravity"])
def test_a_run_goes_on_from_knots_samples_and_impulses_at_once(name):
    """Knots of the table, and samples at 0.4 and 1.0: at two of them there is an impulse too."""
    knots = TABLE.knots
    some = knots[(knots > 0) & (knots < 2.5)][[1, 2]]
    times = np.unique([*SAMPLED_TIMES, *some])
    system = pt.System(BODY, *SYSTEMS[name])
    events = [SampledKick(time, (0.1, -0.1, 0.05)) for time in (some[1], 1.0, 1.2)]
    whole = pt.propagate(system, system.state(**START), times, events=events)
    assert [len(found) for found in whole.events] == [1, 1, 1]
    assert joined(whole, times, events=events) < BOUND


@pytest.mark.parametrize("way", [1, -1], ids=["forwards", "backwards"])
def test_a_run_along_a_table_goes_on_from_its_knots(way):
    knots = TABLE.knots
    times = knots[(knots > 0) & (knots < 3)][::way]
    system, events = pt.System(BODY, pt.GravityGradient(TABLE)), [Kick(times[times.size // 2], (0.1, -0.1, 0.05))]
    whole = pt.propagate(system, BODY.state(**START, time=1.5 - 1.5 * way), times, events=events)
    assert times.size == 5
    assert len(whole.events[0]) == 1
    assert joined(whole, times, events=events) < BOUND


def test_members_go_on_from_actions_of_their_own(tmp_path):
    """At a row one member has just been kicked, the others not."""
    instants = np.array([1.0, 1.5, 7.0, 1.0, 0.3])
    system, times = pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0))), np.array([0.1, 1.0, 1.5, 2.0, 2.5])
    rates = np.random.default_rng(4).normal(size=(5, 3))
    given = {"events": [Kick(instants, (0.3, -0.2, 0.1))]}
    whole = pt.propagate(system, BODY.state(START["attitude"], omega_body=rates), times, **given)
    assert joined(whole, times, **given) < BOUND
    for rows in (WAYS["NetCDF"](whole, tmp_path), WAYS["Zarr"](whole, tmp_path)):
        assert joined(whole, times, rows, **given) < BOUND


@pytest.mark.parametrize("name", ["impact", "of one body"])
@pytest.mark.parametrize("way", [1, -1], ids=["forwards", "backwards"])
def test_two_bodies_go_on_from_impacts(way, name, tmp_path):
    ball = pt.Body((0.4, 0.5, 0.6), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0.3, 1)] * 2)
    events = [pt.events.Impact(way * 1.5, (0.1, -0.1, 0.05))] if name == "impact" else [Push(way * 1.5).on("secondary")]
    system, times = pt.System(pair, pt.forces.MutualGravity()), way * np.array([0.5, 1.0, 1.5, 2.0, 2.5])
    whole = pt.propagate(system, start, times, events=events)
    assert len(whole.events[0]) == 1
    for rows in (whole, WAYS["NetCDF"](whole, tmp_path), WAYS["Zarr"](whole, tmp_path)):
        assert joined(whole, times, rows, events=events) < BOUND


# ---------------------------------------------------------------------- files of other versions, damaged ones


def test_a_file_without_the_times_of_jumps_has_no_memory():
    """Version 0.2 stored no times of jumps: rows of parts from outside the package know none."""
    system = pt.System(BODY, Remembering(0.9, 0.3, 0.1))
    data = pt.propagate(system, system.state(**START), SAMPLED_TIMES).dataset
    del data.attrs["jumps"]
    assert pt.load(data).isel(time=4).jumped == {}


@pytest.mark.parametrize(
    "message",
    [
        "3",
        "[]]",
        '{"remembering": [0.3]}',
        '{"remembering": [0.0, 0.1]}',
        '{"remembering": [NaN, 0.1]}',
        '{"remembering": [0.3, Infinity]}',
        '{"remembering": [[0.3, 0.2], 0.1]}',
        '{"remembering": ["x", 0.1]}',
    ],
)
def test_times_of_jumps_in_a_file_are_checked(message):
    system = pt.System(BODY, Remembering(0.9, 0.3, 0.1))
    data = pt.propagate(system, system.state(**START), SAMPLED_TIMES).dataset
    data.attrs["jumps"] = message
    with pytest.raises(ValueError, match=r"the dataset must have (parts by name|jumps of each member)"):
        pt.load(data)


@pytest.mark.parametrize("roundings", [1, 2, 5, 9, 14])
@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_run_goes_on_from_a_row_next_to_a_sample_and_an_impulse(number, roundings):
    """On looped kernels the row before both shows neither, and a run from it does both, in one order."""
    system, kick = pt.System(BODY, Remembering(0.9, 0.25)), 0.25 * (number + 1)
    row, behind = kick * (1 - roundings * 2.0**-53), np.nextafter(kick, 9)
    times, events = np.array([row, kick, behind, kick + 0.1]), [Push(kick)]
    whole = pt.propagate(system, system.state(**START, time=-0.07), times, events=events, dense=True)
    momenta, total = np.linalg.norm(whole.angular_momentum_body, axis=-1), whole.own["remembering"][:, 3:]
    # A tenth more momentum; four rounding errors of momenta below 1.
    assert np.max(np.abs(momenta[1:3] - 1.1 * momenta[0])) < 4 * np.finfo(float).eps
    assert np.min(np.max(np.abs(total[1:3] - total[0]), axis=-1)) > 1e-2
    assert joined(whole, times, events=events) < BOUND
    for k in range(3):
        assert difference(pt.propagate(system, whole(times[k]), times[k:], events=events), whole) < BOUND
