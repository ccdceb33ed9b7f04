"""Actions that fail, of one body and in ensembles: who stops, with which sentence, and who goes on."""

# ruff: noqa: ARG001

import os
import re
import signal
import time as clock

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration import equations, run
from poinsot.taylor import queue

BODY = pt.Body((1.0, 2.0, 3.0))
FREE = pt.System(BODY)
TIMES = np.linspace(0.0, 9.0, 10)
RATES = np.array([0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 0.6, 0.8, 1.0, 1.2])
BAD = 2


def spinning(rate):
    rates = np.multiply.outer(np.asarray(rate, dtype=float), (0, 0, 1))
    return BODY.state((1, 0, 0, 0), omega_body=rates)


def event(goes_wrong):
    """Return an event that slows a body down a little, and the second time goes wrong for one rate."""

    class Odd(pt.events.AxisCrossing):
        calls = []  # noqa: RUF012

        def act(self, body, state):
            rate = state.angular_momentum_body[2] / 3
            self.calls.append(rate)
            if abs(rate - 0.99 * RATES[BAD]) < 1e-9:
                return goes_wrong(state)
            slower = 0.99 * state.angular_momentum_body
            return body.state(state.quaternion, angular_momentum_body=slower, time=state.time)

    return Odd((1, 0, 0), (1, 0, 0))


def empty_tank(state):
    raise ValueError("the tank\nis empty.")


def colourful(state):
    raise ValueError("\x1b[2J\x9b the\r\n tank \x07is empty.")


def wordless(state):
    raise ZeroDivisionError


def interrupted(state):
    raise KeyboardInterrupt


WRONG = {
    "ValueError: the tank is empty": empty_tank,
    r"ValueError: \\x1b\[2J\\x9b the tank \\x07is empty\.$": colourful,
    "ZeroDivisionError": wordless,
    "TypeError: an action must return a State of one body, got NoneType": lambda state: None,  # noqa: ARG005
    "TypeError: an action must return a State of one body, got one of several members": lambda state: pt.State(
        state.quaternion[None], state.conjugate_momenta[None]
    ),
    "ValueError: an action must return momenta whose squares are finite, got": lambda state: pt.State(
        state.quaternion, 1e200 * state.conjugate_momenta
    ),
    "ValueError: conjugate_momenta must be finite": lambda state: pt.State(
        state.quaternion, np.inf * np.ones_like(state.conjugate_momenta)
    ),
}
SECOND = np.pi / 2 / RATES[BAD] + np.pi / (0.99 * RATES[BAD])

BEFORE = TIMES < SECOND


@pytest.mark.parametrize("why", WRONG)
def test_an_action_that_fails_stops_one_body_with_a_sentence(why):
    with pytest.raises(pt.PropagationError) as caught:
        pt.propagate(FREE, spinning(RATES[BAD]), TIMES, events=[event(WRONG[why])])
    assert re.match(rf"propagation stopped at t = {SECOND:.8}\d* of 9: Odd\.act failed with {why}", str(caught.value))
    assert type(caught.value.__cause__).__name__ == why.partition(":")[0]
    assert abs(caught.value.time - SECOND) < 1e-14
    motion = caught.value.trajectory
    assert motion.times.tolist() == TIMES[BEFORE].tolist()
    assert np.allclose(motion.events[0].times, [np.pi / 2 / RATES[BAD], SECOND], rtol=1.2e-15, atol=0)


@pytest.mark.parametrize("why", WRONG)
def test_an_action_that_fails_stops_its_member_alone(why):
    motion = pt.propagate(FREE, spinning(RATES), TIMES, events=[event(WRONG[why])], threads=1)
    assert list(motion.failures) == [BAD]
    sentence = rf"propagation stopped at t = {SECOND:.8}\d* of 9: Odd\.act failed with {why}"
    assert re.match(sentence, motion.failures[BAD])
    assert motion.failures[BAD].count("\n") == 0
    assert np.array_equal(np.isfinite(motion.quaternion[BAD, :, 0]), BEFORE)
    for i in np.delete(np.arange(RATES.size), BAD):
        alone = pt.propagate(FREE, spinning(RATES[i]), TIMES, events=[event(empty_tank)])
        assert np.allclose(motion.omega_body[i], alone.omega_body, rtol=0, atol=1e-14)
        assert np.allclose(motion.events[0].member(i).times, alone.events[0].times, rtol=0, atol=1e-14)


def test_an_action_at_the_last_time_may_fail_too():
    for state in (spinning(RATES[BAD]), spinning(RATES[[0, BAD]])):
        try:
            why = pt.propagate(FREE, state, [SECOND], events=[event(empty_tank)]).failures[1]
        except pt.PropagationError as error:
            why = str(error)
        assert "Odd.act failed with ValueError: the tank is empty." in why


@pytest.mark.parametrize("members", [1, equations.LANES - 1, equations.LANES + 1])
def test_an_action_is_called_once_an_event(members):
    """Also where lanes are left over, and repeat another one."""
    slowing = event(interrupted)
    motion = pt.propagate(FREE, spinning(np.linspace(1.0, 2.0, members)), TIMES, events=[slowing])
    assert len(slowing.calls) == len(motion.events[0]) > 2 * members


def test_an_interrupt_in_an_action_is_one():
    with pytest.raises(pt.PropagationInterrupted, match=r"of 9: it was interrupted\.$") as caught:
        pt.propagate(FREE, spinning(RATES[BAD]), TIMES, events=[event(interrupted)])
    assert abs(caught.value.time - SECOND) < 1e-14
    assert caught.value.trajectory.times.tolist() == TIMES[BEFORE].tolist()


def test_only_a_second_interrupt_breaks_into_an_action():
    def pressed(times):
        def press(state):
            for _ in range(times):
                os.kill(os.getpid(), signal.SIGINT)
            after.append(state)
            return state

        after = []
        with pytest.raises(pt.PropagationInterrupted, match=r"it was interrupted\.$") as caught:
            pt.propagate(FREE, spinning(RATES[BAD]), TIMES, events=[event(press)])
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        assert caught.value.time >= SECOND - 1e-14
        return len(after)

    assert (pressed(1), pressed(2)) == (1, 0)


def test_an_interrupt_in_an_action_keeps_the_finished_members(monkeypatch):
    monkeypatch.setattr(equations, "LANES", 2)
    with pytest.raises(pt.PropagationInterrupted, match=r"interrupted: [1-9] of 10 members are done") as caught:
        pt.propagate(FREE, spinning(RATES), TIMES, events=[event(interrupted)], threads=1)
    motion = caught.value.trajectory
    done = np.isfinite(motion.quaternion[:, -1, 0])
    assert not done[BAD]
    assert np.array_equal(np.isfinite(motion.quaternion).all(axis=(1, 2)), done)
    assert np.all(np.isnan(motion.quaternion[~done]))
    assert set(motion.events[0].members.tolist()) == set(np.flatnonzero(done).tolist())


def test_an_interrupt_on_the_way_leaves_nothing_of_members_that_are_not_finished(monkeypatch):
    monkeypatch.setattr(equations, "LANES", 2)
    advance = queue.Worker.advance
    monkeypatch.setattr(queue.Worker, "advance", lambda run, budget=None: advance(run, budget or 3))

    def interrupt(state):
        os.kill(os.getpid(), signal.SIGINT)
        clock.sleep(0.3)  # until the main thread has heard it
        return state

    with pytest.raises(pt.PropagationInterrupted, match=r"interrupted: [1-9] of 10 members are done") as caught:
        pt.propagate(FREE, spinning(RATES), TIMES, events=[event(interrupt)], threads=1)
    motion = caught.value.trajectory
    done = np.flatnonzero(np.isfinite(motion.quaternion[:, -1, 0])).tolist()
    assert str(len(done)) in str(caught.value)
    assert set(motion.events[0].members.tolist()) == set(done)


def test_what_stops_one_thread_stops_all(monkeypatch):
    def leave(state):
        raise SystemExit(3)

    for runs in (run,):
        monkeypatch.setattr(runs, "MAX_SLAB_BYTES", 1)
    slow = event(leave)
    with pytest.raises(SystemExit):
        pt.propagate(FREE, spinning(np.append(RATES[BAD], np.full(10_000, 0.3))), TIMES, events=[slow], threads=2)
    assert len(slow.calls) < 5000
