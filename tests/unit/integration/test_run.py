"""Runs on looped kernels: which kernel they take, Ctrl-C, members that fail or start anywhere, reports."""

import os
import signal
import sys

import llvmlite.binding
import numpy as np
import pytest

import poinsot as pt
from poinsot.integration import equations, report, run
from poinsot.integration.event_log import EventLog
from poinsot.integration.kernel_parameters import PreparedKernel
from poinsot.integration.report import HeldInterrupts
from poinsot.integration.rows import Rows
from poinsot.integration.variational import STEPS_AT_A_TIME
from poinsot.taylor import kernels
from poinsot.taylor.queue import Queue, Worker

BODY = pt.Body((1.3, 1.0, 0.7))
START = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.6, 0.5))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1.0, 0.2, -0.3)))
GRID = np.linspace(0, 40, 401)


WITHIN = 2e-13
"""What states that are converted one by one or together differ by, rounding, becomes in these motions."""


def rows(motion):
    return np.concatenate([motion.quaternion, motion.conjugate_momenta], axis=-1)


def tops(count, time=0.0):
    """Return states of one body that turns in many ways, from an attitude that no conversion rounds."""
    generator = np.random.default_rng(5)
    rates = np.array((0, 0, 1)) + generator.normal(size=(count, 3))
    return BODY.state(np.tile((1.0, 0, 0, 0), (count, 1)), omega_body=rates, time=np.broadcast_to(time, count))


def member(batch, i):
    return pt.State(batch.quaternion[i], batch.conjugate_momenta[i], batch.time[i])


@pytest.fixture
def few_steps(monkeypatch):
    """A run looks for Ctrl-C after five steps."""
    monkeypatch.setattr(Worker.advance, "__defaults__", (5,))


# ---------------------------------------------------------------------- which kernel


def motion(force):
    return pt.propagate(pt.System(BODY, force), START, np.linspace(0, 5, 3))


def codes():
    return [known.code for known in equations.known._stored.values() if isinstance(known, PreparedKernel)]


def test_a_sweep_through_zero_takes_one_kernel_more(forget_kernels):
    forget_kernels()
    for y in (-0.2, -0.1, 0.0, 0.1, 0.2):
        motion(pt.UniformGravity(0.7, (0.3, y, 0.5)))
    assert len(codes()) == 2


def test_a_zero_of_some_members_is_none_of_the_others(forget_kernels):
    forget_kernels()
    centers = [(0.3, 0.0, 0.0), (0.3, 0.2, 0.0)]
    motions = motion(pt.UniformGravity(0.7, centers))
    for center, quaternion in zip(centers, motions.quaternion, strict=True):
        assert np.max(np.abs(motion(pt.UniformGravity(0.7, center)).quaternion - quaternion)) < 3e-14


def test_an_ensemble_of_one_member_leaves_no_lane_idle():
    one, five = (pt.propagate(TOP, tops(count), GRID) for count in (1, 5))
    assert (one.run.lanes, five.run.lanes) == (1, equations.LANES)
    assert np.array_equal(rows(one), rows(five)[:1])
    found = pt.analysis.state_transition(TOP, START, [-2.0, 3.0], ["moments[0]"])
    assert found.motion.run.lanes == 1


@pytest.mark.parametrize("times", [GRID, np.linspace(-3, 4, 8), [-2.0]])
def test_what_a_run_left_in_the_memory_of_a_kernel_is_not_in_the_next_one(times, monkeypatch):
    """Also where it stopped, was rescaled or had other times; and its rows stay as they were."""
    starts = [START, BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(-3.0, 0.1, 2.0)), START]
    first, second, third = (pt.propagate(TOP, start, times) for start in starts)
    before = rows(first).copy()
    pt.propagate(TOP, starts[1], times[:1])
    assert np.array_equal(rows(first), before)
    assert np.array_equal(rows(third), before)
    monkeypatch.setattr(Worker, "queue", lambda run, *given: Queue(run._kernel, *given))
    assert np.array_equal(rows(pt.propagate(TOP, starts[1], times)), rows(second))
    assert second.run.steps == pt.propagate(TOP, starts[1], times).run.steps


class Root(pt.Potential):
    """Whose slope is 0/0 for k = 0."""

    k: float

    def energy(self, instant):
        return pt.functions.sqrt(self.k * (2 + instant.attitude.to_body((0, 0, 1))[2]))


def test_a_formula_that_has_no_slope_at_zero_stops_as_before():
    motion(Root(0.3))
    with pytest.raises(pt.PropagationError, match="the state became non-finite"):
        motion(Root(0.0))


# ---------------------------------------------------------------------- Ctrl-C


class PressedAtCall:
    """Ctrl-C at the n-th call or return of a function in a run, and the time that the kernel had reached by then."""

    def __init__(self, at):
        self.at, self.seen, self.reached = at, 0, 0.0

    def __call__(self, frame, event, _):
        if frame.f_code is HeldInterrupts.__exit__.__code__:
            sys.setprofile(None)
            return
        self.seen += 1
        if event == "return" and frame.f_code is Worker.advance.__code__:
            self.reached = float(frame.f_locals["self"]._work["time"][0, 0, 0])
        if self.seen == self.at:
            sys.setprofile(None)
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture
def pressed(monkeypatch):
    """Makes a Ctrl-C at the n-th call from the first step on."""
    go = run.Slab.advance

    def at_call(at):
        press = PressedAtCall(at)

        def watched(*arguments):
            sys.setprofile(press)
            go(*arguments)

        monkeypatch.setattr(run.Slab, "advance", watched)
        return press

    return at_call


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize("dense", [False, True])
def test_an_interrupt_at_any_call_loses_no_step(dense, pressed):
    whole = pt.propagate(TOP, START, GRID, dense=dense)
    count = pressed(0)
    pt.propagate(TOP, START, GRID, dense=dense)
    lengths = set()
    for at in range(1, count.seen, count.seen // 40):
        press = pressed(at)
        with pytest.raises(pt.PropagationInterrupted) as caught:
            pt.propagate(TOP, START, GRID, dense=dense)
        motion = caught.value.trajectory
        assert caught.value.time >= press.reached
        assert motion.times.tolist() == GRID[caught.value.time >= GRID].tolist()
        assert np.array_equal(rows(motion), rows(whole)[: len(motion.times)])
        if dense:
            assert np.array_equal(motion(caught.value.time).quaternion, whole(caught.value.time).quaternion)
        lengths.add(len(motion.times))
    assert len(lengths) > 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("few_steps")
def test_an_interrupt_keeps_members_that_are_finished(pressed):
    batch = tops(3 * equations.LANES)
    whole = pt.propagate(TOP, batch, GRID, threads=1)
    count, done = pressed(0), set()
    pt.propagate(TOP, batch, GRID, threads=1)
    for at in range(1, count.seen, count.seen // 15):
        pressed(at)
        with pytest.raises(
            pt.PropagationInterrupted, match=rf"\d+ of {3 * equations.LANES} members are done"
        ) as caught:
            pt.propagate(TOP, batch, GRID, threads=1)
        motion = caught.value.trajectory
        finished = np.isfinite(motion.quaternion[:, -1, 0])
        assert f"{finished.sum()} of" in str(caught.value)
        assert np.array_equal(rows(motion)[finished], rows(whole)[finished])
        assert np.all(np.isnan(motion.quaternion[~finished]))
        done.add(int(finished.sum()))
    assert len(done) > 2


@pytest.mark.usefixtures("few_steps")
def test_an_interrupt_waits_for_no_events_of_members_that_are_not_stored(pressed, monkeypatch):
    monkeypatch.setattr(run, "MAX_SLAB_OF_EVENTS", equations.LANES)
    take, taken = EventLog.take, []

    def counted(noted, notes):
        taken.append((len(noted.records), np.unique(notes["task"]).size))
        return take(noted, notes)

    monkeypatch.setattr(EventLog, "take", counted)
    batch, events = tops(3 * equations.LANES), [pt.events.AxisCrossing((0, 0, 1), (0, 0, 1))]
    whole = pt.propagate(TOP, batch, GRID, events=events, threads=1).events[0]
    assert [size for size, _ in taken] == [equations.LANES] * 3
    count = pressed(0)  # of a later run, which compiles nothing
    pt.propagate(TOP, batch, GRID, events=events, threads=1)
    taken.clear()
    pressed(count.seen // 2)
    with pytest.raises(pt.PropagationInterrupted) as caught:
        pt.propagate(TOP, batch, GRID, events=events, threads=1)
    motion = caught.value.trajectory
    finished = np.flatnonzero(np.isfinite(motion.quaternion[:, -1, 0]))
    assert 0 < finished.size < 3 * equations.LANES
    assert sum(members for _, members in taken) == np.unique(motion.events[0].members).size
    assert np.array_equal(motion.events[0].times, whole.times[np.isin(whole.members, finished)])


# ---------------------------------------------------------------------- members


class Pole(pt.Torque):
    """A torque that is infinite at one time."""

    instant: float

    def torque(self, instant):
        return (1 / (self.instant - instant.time) ** 2, 0.0, 0.0)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("threads", [1, 2])
def test_members_that_fail_fail_alone(way, threads):
    count = 2 * equations.LANES + 1
    instants, times = np.full(count, 50.0 * way), way * np.arange(11.0)
    instants[[1, -1]] = 5.25 * way
    batch = tops(count)
    motion = pt.propagate(pt.System(BODY, Pole(instants)), batch, times, threads=threads)
    assert list(motion.failures) == [1, count - 1]
    finite = np.isfinite(motion.quaternion[..., 0])
    assert np.array_equal(finite, (times * way < instants[:, None] * way))
    for i in range(count):
        if i in motion.failures:
            with pytest.raises(pt.PropagationError) as caught:
                pt.propagate(pt.System(BODY, Pole(instants[i])), member(batch, i), times)
            assert str(caught.value) == motion.failures[i]
            alone = caught.value.trajectory
        else:
            alone = pt.propagate(pt.System(BODY, Pole(instants[i])), member(batch, i), times)
        np.testing.assert_allclose(rows(motion)[i, finite[i]], rows(alone), rtol=0, atol=WITHIN)


@pytest.mark.parametrize("times", [[-2.0, 0.0, 3.0], [3.0, 0.0, -2.0], [0.0], [-1.0]], ids=str)
def test_members_that_start_before_at_behind_and_beyond_the_times(times):
    origins = np.array([-5.0, -2.0, -1.0, 0.0, 0.5, 3.0, 9.0])
    batch = tops(origins.size, time=origins)
    motion = pt.propagate(TOP, batch, times, threads=1)
    assert motion.failures == {}
    for i in range(origins.size):
        alone = pt.propagate(TOP, member(batch, i), times)
        np.testing.assert_allclose(rows(motion)[i], rows(alone), rtol=0, atol=WITHIN)
        assert motion.run.steps >= alone.run.steps


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_members_are_bit_for_bit_those_alone(threads):
    batch = tops(40)
    motion = pt.propagate(TOP, batch, GRID[::40], threads=threads)
    for i in range(0, 40, 3):
        alone = pt.propagate(TOP, member(batch, i), GRID[::40])
        assert np.array_equal(motion.quaternion[i], alone.quaternion)


# ---------------------------------------------------------------------- reports


def test_a_run_of_no_span_reports_no_steps():
    for state in (START, tops(3)):
        motion = pt.propagate(TOP, state, [0.0])
        assert motion.run.steps == 0
        assert np.all(np.isfinite(motion.quaternion))
        assert motion.run.order == kernels.order_of(motion.run.tolerance)


def test_the_wall_time_has_no_compilation(monkeypatch):
    monkeypatch.setattr(equations, "known", lambda _, question: question())
    kernels.compiled.cache_clear()
    began = pt.propagate(TOP, START, [0.0, 1.0]).run.wall_time
    again = pt.propagate(TOP, START, [0.0, 1.0]).run.wall_time
    assert began < 10 * again + 0.01


@pytest.mark.parametrize("handed", [1, 10_000])
def test_members_are_handed_over_few_at_a_time(handed, monkeypatch):
    batch, taken = tops(40), []
    whole = pt.propagate(TOP, batch, GRID[::-40], threads=1)

    class Told(Rows):
        def __init__(self, *given):
            taken.append(given[-1])
            super().__init__(*given)

    monkeypatch.setattr(run, "Rows", Told)
    monkeypatch.setattr(run, "BYTES_AT_A_TIME", handed)
    motion = pt.propagate(TOP, batch, GRID[::-40], threads=1)
    assert sum(map(len, taken)) == 40
    assert max(own.nbytes for own in taken) <= max(handed, taken[0][0].nbytes)
    np.testing.assert_allclose(rows(motion), rows(whole), rtol=0, atol=WITHIN)


class Brake(pt.events.AtTime):
    """An event that halves the angular velocity."""

    def act(self, body, state):
        return body.state(state.quaternion, omega_body=0.5 * body.omega(state.angular_momentum_body), time=state.time)


@pytest.mark.parametrize("count", [63, 64, 65, 130])
@pytest.mark.parametrize("members", [False, True])
def test_any_number_of_events_is_recorded(count, members):
    """Integers of 64 bits mark the events of a kernel: events at known times, and the last event acts."""
    times = 0.01 * (1 + np.arange(count))
    events = [*map(pt.events.AtTime, times[:-1]), Brake(times[-1])]
    rates = np.array([(0.0, 0.0, 1.0), (0.0, 0.5, 0.0)])
    body = pt.Body((1.0, 1.2, 1.5))
    start = body.state((1, 0, 0, 0), omega_body=rates if members else rates[0])
    motion = pt.propagate(pt.System(body), start, [0.0, 2.0], events=events)
    assert motion.run.kernel == "looped"
    for k, one in enumerate([motion.member(0), motion.member(1)] if members else [motion]):
        found = [record.times for record in one.events]
        assert [each.size for each in found] == [1] * count
        assert np.ravel(found) == pytest.approx(times, abs=2 * np.spacing(times[-1]))
        assert one.omega_body[-1] == pytest.approx(0.5 * rates[k], abs=4 * np.spacing(0.5))


@pytest.mark.parametrize("count", [63, 64, 128])
def test_events_next_to_the_singular_angle(count):
    """The singular angle of Euler angles is one event more, in the next integer if there are as many events as bits."""
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((0.5**0.5, 0.5**0.5, 0, 0), omega_body=(-1.0, 0, 0))
    events = [pt.events.AtTime(0.01 * (1 + i)) for i in range(count)]
    free = pt.propagate(pt.System(body), start, [1.5], events=events, formulation="euler_angles")
    assert [len(record) for record in free.events] == [1] * count
    with pytest.raises(pt.PropagationError, match="Euler angles 3-1-3 are singular") as stopped:
        pt.propagate(pt.System(body), start, [4.0], events=events, formulation="euler_angles")
    assert stopped.value.time == pytest.approx(np.pi / 2 - 1e-6, abs=2e-15)  # three times the worst of 40 rates


def test_a_processor_without_fused_multiply_add_gives_the_same_bits(monkeypatch, forget_kernels, tmp_path):
    expected = rows(pt.propagate(TOP, START, [0.0, 1.0, 20.0]))
    forget_kernels()
    kernels.compiled.cache_clear()
    monkeypatch.setenv("POINSOT_CACHE", str(tmp_path))
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_name", lambda: "x86-64")
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", llvmlite.binding.FeatureMap)
    again = pt.System(BODY, *TOP.forces)  # a system remembers the kernels of its structure
    assert np.array_equal(rows(pt.propagate(again, START, [0.0, 1.0, 20.0])), expected)
    assert any(tmp_path.rglob("*")), "no kernel was compiled for the other processor"
    kernels.compiled.cache_clear()


@pytest.mark.parametrize("members", [1, 2])
@pytest.mark.parametrize("steps", [5, 20_000])
def test_a_task_with_tangent_vectors_that_would_not_end_is_given_up(members, steps, monkeypatch):
    """A lane is checked after some steps; a task in no lane is checked before its vectors are rescaled."""
    batch = tops(members)
    monkeypatch.setattr(Worker.advance, "__defaults__", (steps,))
    monkeypatch.setattr(kernels, "BUDGET", 10)
    monkeypatch.setattr(report, "MAX_CHUNKS_AHEAD", 1.0)
    found = pt.analysis.state_transition(TOP, batch, [2000.0])
    assert np.all(np.isnan(found.directions))
    assert list(found.motion.failures) == [*range(members)]
    assert all("the steps became so short" in why for why in found.motion.failures.values())
    assert found.motion.run.steps <= members * (STEPS_AT_A_TIME[1] * 11 // 10 + 1)
    with pytest.raises(pt.PropagationError, match="the steps became so short"):
        pt.analysis.state_transition(TOP, member(batch, 0), [2000.0])
