"""Ensembles: the same motion as one body at a time, whatever has the member axis."""

import os
import re
import signal
import threading
import time as clock

import numpy as np
import pytest

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.integration import equations

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0.1, -0.2)))
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.2, inclination=0.3, node=0.4, argument_of_periapsis=0.5)
SATELLITE = pt.System(BODY, pt.GravityGradient(ORBIT))
TIMES = np.linspace(-3.0, 8.0, 9)


def states(members, seed=1, time=0.0):
    random = np.random.default_rng(seed)
    q = random.normal(size=(members, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    g = random.normal(size=(members, 3))
    return pt.State(q, 2 * quat.product(q, quat.pure(g)), time)


def member(batch, i):
    time = batch.time[i] if batch.time.ndim else batch.time
    return pt.State(batch.quaternion[i], batch.conjugate_momenta[i], time)


def assert_member(motion, i, alone, within=2e-13):
    for name in ("quaternion", "conjugate_momenta", "omega_body", "omega_space", "energy"):
        np.testing.assert_allclose(getattr(motion, name)[i], getattr(alone, name), rtol=0, atol=within)


@pytest.mark.parametrize("system", [pt.System(BODY), TOP, SATELLITE], ids=["free", "top", "satellite"])
@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@pytest.mark.parametrize("members", [1, equations.LANES, 3 * equations.LANES - 3])
def test_members_move_as_they_do_alone(system, formulation, members):
    batch = states(members)
    motion = pt.propagate(system, batch, TIMES, formulation=formulation, threads=2)
    assert motion.quaternion.shape == (members, len(TIMES), 4)
    assert motion.failures == {}
    for i in range(members):
        assert_member(motion, i, pt.propagate(system, member(batch, i), TIMES, formulation=formulation))


def test_euler_angles_in_batches():
    batch = states(5)
    motion = pt.propagate(TOP, batch, [0.0, 0.5], formulation="euler_angles")
    reference = pt.propagate(TOP, batch, [0.0, 0.5])
    np.testing.assert_allclose(motion.attitude.as_matrix(), reference.attitude.as_matrix(), rtol=0, atol=1e-13)


def test_falling_times_are_the_rising_ones_turned_round():
    rising, falling = (pt.propagate(TOP, states(5), times) for times in (TIMES, TIMES[::-1]))
    assert np.array_equal(rising.quaternion, falling.quaternion[:, ::-1])
    assert falling.times.tolist() == TIMES[::-1].tolist()


def test_each_member_may_start_at_its_own_time():
    batch = states(11, time=np.linspace(-5, 9, 11))
    motion = pt.propagate(SATELLITE, batch, TIMES)
    for i in range(11):
        assert_member(motion, i, pt.propagate(SATELLITE, member(batch, i), TIMES))


def test_moments_forces_and_orbits_may_have_members():
    random = np.random.default_rng(5)
    moments = np.array([1.25, 1.0, 0.75]) * random.uniform(0.9, 1.1, (6, 1))
    weights, arms = random.uniform(0.1, 1, 6), random.normal(size=(6, 3))
    axes, tilts = random.uniform(0.9, 1.1, 6), random.uniform(0, 1, 6)

    def system(i):
        orbit = pt.KeplerOrbit(
            1.0, semimajor_axis=axes[i], eccentricity=0.2, inclination=tilts[i], node=0.4, argument_of_periapsis=0.5
        )
        return pt.System(pt.Body(moments[i]), pt.UniformGravity(weights[i], arms[i]), pt.GravityGradient(orbit))

    start = member(states(1), 0)
    motion = pt.propagate(system(slice(None)), start, TIMES)
    for i in range(6):
        assert_member(motion, i, pt.propagate(system(i), start, TIMES))


def test_orbits_with_members_carry_the_attitude_of_each():
    axes, anomalies = np.linspace(0.9, 1.2, 7), np.linspace(0, 6, 7)
    start = member(states(1), 0)

    def system(i):
        orbit = pt.KeplerOrbit(
            1.0,
            semimajor_axis=axes[i],
            eccentricity=0.2,
            inclination=0.3,
            node=0.4,
            argument_of_periapsis=0.5,
            true_anomaly=anomalies[i],
        )
        return pt.System(BODY, pt.GravityGradient(orbit))

    motion = pt.propagate(system(slice(None)), start, TIMES)
    for i in range(7):
        assert_member(motion, i, pt.propagate(system(i), start, TIMES))


def test_oblique_bodies_may_have_members():
    tensor = np.array([[2, 0.1, 0.2], [0.1, 2.5, 0.3], [0.2, 0.3, 3]])
    system, batch = pt.System(pt.Body.from_inertia(tensor), pt.UniformGravity(0.5, (1, 0, 0))), states(3)
    motion = pt.propagate(system, batch, TIMES)
    assert_member(motion, 2, pt.propagate(system, member(batch, 2), TIMES))


class Pole(pt.Torque):
    """A torque that is infinite at one time."""

    instant: float

    def torque(self, instant):
        return (1 / (self.instant - instant.time) ** 2, 0.0, 0.0)


def test_a_failure_is_isolated_and_explained():
    instants = np.full(2 * equations.LANES + 1, 50.0)
    instants[[1, -1]] = 5.25
    system, times = pt.System(BODY, Pole(instants)), np.arange(11.0)
    motion = pt.propagate(system, member(states(1), 0), times)
    assert list(motion.failures) == [1, len(instants) - 1]
    sentence = (
        r"propagation stopped at t = 5\.\d+ of 10: (the state became non-finite|the step size fell to rounding)\."
    )
    assert re.match(sentence, motion.failures[1])
    whole = np.isfinite(motion.quaternion[..., 0])
    assert whole[[1, -1]].sum(axis=1).tolist() == [6, 6]
    assert np.all(np.delete(whole, [1, len(instants) - 1], axis=0))
    alone = pt.propagate(pt.System(BODY, Pole(50.0)), member(states(1), 0), times)
    assert_member(motion, 0, alone)
    assert np.isfinite(motion.summary["norm_error"])


def test_threads_do_not_change_a_bit():
    batch = states(40)
    one, two = (pt.propagate(SATELLITE, batch, TIMES, threads=threads) for threads in (1, 2))
    assert np.array_equal(one.quaternion, two.quaternion)


def test_integrals_and_their_drift_have_members():
    motion = pt.propagate(TOP, states(9), TIMES)
    assert set(motion.drift) == {"energy", "angular_momentum_space_3"}
    assert all(drift.shape == (9, len(TIMES)) and np.max(np.abs(drift)) < 1e-13 for drift in motion.drift.values())


def test_dataset_leads_with_members():
    data = pt.propagate(SATELLITE, states(4), TIMES).dataset
    assert data.quaternion.dims == ("member", "time", "parameter")
    assert data.kinetic_energy.dims == ("member", "time")


def test_an_interrupt_keeps_the_finished_members():
    pt.propagate(TOP, states(equations.LANES), [0.0, 1.0])
    sent = []

    def interrupt():
        sent.append(clock.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.7, interrupt)
    timer.start()
    with pytest.raises(
        pt.PropagationInterrupted, match=r"^propagation was interrupted: \d+ of 20000 members are done\.$"
    ) as caught:
        pt.propagate(TOP, states(20_000), [0.0, 300.0], threads=2)
    assert clock.perf_counter() - sent[0] < 1.0
    timer.join()
    done = np.isfinite(caught.value.trajectory.quaternion[:, -1, 0])
    assert 0 < done.sum() < 20_000
    i = int(np.flatnonzero(done)[0])
    alone = pt.propagate(TOP, member(states(20_000), i), [0.0, 300.0])
    np.testing.assert_allclose(caught.value.trajectory.energy[i], alone.energy, rtol=0, atol=1e-12)


def test_progress_is_shown_where_it_is_wanted(capsys, monkeypatch):
    pt.propagate(TOP, states(20), [0.0, 1.0], progress=True)
    assert capsys.readouterr().err == ""  # of what is done at once
    monkeypatch.setattr("poinsot.display.progress.DELAY", 0.01)
    monkeypatch.setenv("FORCE_COLOR", "1")  # as a terminal does
    pt.propagate(TOP, states(4000), [0.0, 30.0], progress=True)
    assert "members" in capsys.readouterr().err
    pt.propagate(TOP, states(20), [0.0, 1.0], progress=False)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            {"dense": True},
            "an ensemble must be propagated without dense=True, got it. Propagate members one by one.",
        ),
        (
            {"precision": "extended"},
            "precision must be 'double' or 'quadruple', got 'extended'. Use 'quadruple', which has 32 digits.",
        ),
        ({"threads": 0}, "threads must be a positive whole number, got 0."),
        ({"threads": 1.5}, "threads must be a whole number of at most 63 bits, got float 1.5."),
    ],
)
def test_what_an_ensemble_cannot_do(options, sentence):
    with pytest.raises((TypeError, ValueError), match=f"^{re.escape(sentence)}$"):
        pt.propagate(TOP, states(3), TIMES, **options)


def test_unequal_members_are_refused():
    system = pt.System(pt.Body(np.ones((4, 3))))
    with pytest.raises(ValueError, match=r"^state and system must have equally many members, got 3 and 4\.$"):
        pt.propagate(system, states(3), TIMES)
    with pytest.raises(ValueError, match=r"^body and forces must have equally many members, got 2 and 4\.$"):
        pt.propagate(pt.System(system.body, pt.UniformGravity([1, 2], (1, 0, 0))), states(4), TIMES)


def test_a_picture_in_space_is_of_one_body():
    motion = pt.propagate(TOP, states(3), TIMES)
    with pytest.raises(ValueError, match=r"^motion must be of one body, got an ensemble of 3 members\. "):
        pt.plot.herpolhode(motion)


@pytest.mark.parametrize("nudges", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)], ids=str)
def test_members_that_start_within_rounding_of_a_time(nudges):
    origins = np.array([TIMES[2], TIMES[4], 0.1]) + np.array(nudges) * np.spacing(TIMES[[2, 4, 4]])
    batch = states(3, time=origins)
    motion = pt.propagate(SATELLITE, batch, TIMES)
    for i in range(3):
        assert_member(motion, i, pt.propagate(SATELLITE, member(batch, i), TIMES))


@pytest.mark.parametrize("rate", [1e50, 1e200])  # of the larger one the square overflows too
def test_no_force_is_blamed_where_powers_of_a_rate_overflow(rate):
    body = pt.Body((1.0, 2.0, 3.0))
    start = body.state((1, 0, 0, 0), omega_body=(rate, 0.1 * rate, rate))
    why = f"the state became non-finite: the body turns so fast, {rate:.0g}, that powers of its rate overflow."
    sentence = f"propagation stopped at t = 0 of 1: {why} Count in a shorter unit of time."
    with pytest.raises(pt.PropagationError, match=f"^{re.escape(sentence)}$"):
        pt.propagate(pt.System(body), start, [1.0])
    pair = body.state([(1, 0, 0, 0)] * 2, omega_body=[(rate, 0.1 * rate, rate), (0, 0.1, 0)])
    motion = pt.propagate(pt.System(body), pair, [1.0])
    assert motion.failures == {0: sentence}
    with pytest.raises(pt.PropagationError, match=re.escape(why)):
        pt.analysis.chaos_indicators(pt.System(body), start, [1 / rate])
    with pytest.raises(ValueError, match=r"^times must be at most 1e\+08 steps of .* from the state's time, got 1\. "):
        pt.analysis.chaos_indicators(pt.System(body), start, [1.0])
