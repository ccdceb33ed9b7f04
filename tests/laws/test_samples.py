"""What holds for every law that is computed at samples and held between them, on all equations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds.forces import FORCES, MAGNETIC_FIELDS
from kinds.sampled_systems import BODY, FEEDBACK, ORBIT, START, SYSTEMS, Integrating, Pole
from poinsot.analysis import transition_matrix
from poinsot.control import NoisySensors, OrbitPointing, QuaternionFeedback, RateDamping, Sampled
from poinsot.functions import Vector
from poinsot.integration import equations
from poinsot.taylor import queue

TIMES = np.array([0.0, 0.1, 0.25, 0.4, 0.7, 1.0, 1.3, 1.9, 2.5, 2.6])
"""Among them samples of a period of 0.3 with the offset 0.1, and the start."""


each_system = pytest.mark.parametrize("forces", SYSTEMS.values(), ids=SYSTEMS)


def values(motion):
    """All variables of a motion."""
    own = [motion.quaternion, motion.angular_momentum_body, *motion.own.values()]
    return np.concatenate(own, axis=-1)


def difference(motion, other):
    """The largest difference, relative to the size of each variable."""
    size = np.maximum(np.max(np.abs(values(other)), axis=0), 1e-3)
    return np.max(np.abs(values(motion) - values(other)) / size)


@each_system
def test_double_and_quadruple_precision_give_one_motion(forces):
    system = pt.System(BODY, *forces)
    start = system.state(**START)
    double, quadruple = (
        pt.propagate(system, start, TIMES, dense=True, precision=precision) for precision in ("double", "quadruple")
    )
    # Both round some 30 steps; samples of tables and saturated laws multiply an error by ten.
    assert difference(double, quadruple) < 1e-13
    for motion in (double, quadruple):
        assert difference(motion(TIMES), motion) < 1e-14  # at samples it has the variables after them
    assert np.array_equal(values(pt.propagate(system, start, TIMES[::-1]))[::-1], values(double))


@each_system
def test_at_a_sample_the_variables_are_those_of_the_update(forces):
    system = pt.System(BODY, *forces)
    parts = [part for part in system.parts if part.jump]
    first, *others = parts
    before = np.nextafter(TIMES[3], 0.0)
    motion = pt.propagate(system, system.state(**START), [before, *TIMES[3:5]])
    instant = system.at(motion.isel(time=0))
    expected = np.array([float(x) for x in first.update(instant, Vector(()))])
    own = motion.own[first.name]
    assert np.max(np.abs(own[1] - expected)) < 1e-13 * np.max(np.abs(expected))
    assert np.max(np.abs(own[1] - own[0])) > 1e-3
    for part in others:  # between two of its samples
        assert np.array_equal(motion.own[part.name][1], motion.own[part.name][0])


@each_system
def test_members_are_as_alone_in_all_lanes(forces, monkeypatch):
    count = 11
    random = np.random.default_rng(5)
    omega = random.normal(size=(count, 3)) * (1 + np.arange(count) % 4)[:, None]
    system = pt.System(BODY, *forces)
    times = np.linspace(1.0, 2.5, 4)
    start = system.state(
        START["attitude"], omega_body=omega, time=np.array([0.0, 0.1, -0.4, 1.0, 0.31])[np.arange(count) % 5]
    )
    together = pt.propagate(system, start, times)
    for k in range(count):
        own = system.state(START["attitude"], omega_body=omega[k], time=start.time[k])
        assert np.array_equal(values(pt.propagate(system, own, times)), values(together[k]))
    for lanes in (1, 2, 4, 8):
        monkeypatch.setattr(equations, "LANES", lanes)
        for threads in (1, 2):
            assert np.array_equal(values(pt.propagate(system, start, times, threads=threads)), values(together))


def test_members_have_samples_of_their_own(monkeypatch):
    periods, offsets = np.array([0.2, 0.3, 0.07, 1.1, 5.0]), np.array([0.0, 0.1, 0.02, -0.3, 0.7])
    system = pt.System(BODY, Sampled(FEEDBACK, periods, offsets))
    for lanes in (1, 2, 4, 8):
        monkeypatch.setattr(equations, "LANES", lanes)
        together = pt.propagate(system, system.state(**START), TIMES)
        for k, (period, offset) in enumerate(zip(periods, offsets, strict=True)):
            alone = pt.System(BODY, Sampled(FEEDBACK, period, offset))
            assert np.array_equal(values(pt.propagate(alone, alone.state(**START), TIMES)), values(together[k]))


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_a_member_that_fails_disturbs_no_other(lanes, monkeypatch):
    monkeypatch.setattr(equations, "LANES", lanes)
    poles = np.where(np.arange(9) % 4 == 1, 1.0, 9.0)
    law = Sampled(FEEDBACK, 0.3, 0.1)
    system = pt.System(BODY, law, Pole(poles))
    together = pt.propagate(system, system.state(**START), TIMES)
    assert list(together.failures) == [1, 5]
    one = pt.System(BODY, law, Pole(9.0))
    expected = values(pt.propagate(one, one.state(**START), TIMES))
    for k in np.flatnonzero(poles == 9.0):
        assert np.max(np.abs(values(together[k]) - expected)) < 1e-14


@each_system
def test_a_motion_goes_on_from_any_of_its_states(forces):
    """From a sample too: laws that see the motion alone give the same torque again."""
    system = pt.System(BODY, *forces)
    whole = pt.propagate(system, system.state(**START), TIMES)
    for k in (2,) if isinstance(forces[0], Integrating) else (2, 3, 5):
        rest = pt.propagate(system, whole.isel(time=k), TIMES[k:])
        size = np.maximum(np.max(np.abs(values(whole)), axis=0), 1e-3)
        assert np.max(np.abs(values(rest) - values(whole)[k:]) / size) < 1e-13


@pytest.mark.parametrize("name", ["feedback", "pointing along a table, two controllers", "two controllers"])
def test_chunks_of_steps_change_nothing(name, monkeypatch):
    system = pt.System(BODY, *SYSTEMS[name])
    whole = pt.propagate(system, system.state(**START), TIMES, dense=True)
    monkeypatch.setattr(queue, "STEPS_IN_BLOCK", 3)
    advance = queue.Worker.advance
    monkeypatch.setattr(queue.Worker, "advance", lambda self, budget=None: advance(self, min(budget or 2, 2)))
    parts = pt.propagate(system, system.state(**START), TIMES, dense=True)
    assert np.array_equal(values(parts), values(whole))
    assert np.array_equal(values(parts(TIMES)), values(whole(TIMES)))


# ---------------------------------------------------------------------- noise

NOISY = NoisySensors(rate_noise=0.02, attitude_noise=0.03, rate_quantum=0.004, attitude_quantum=0.01, seed=11)


def test_noise_is_the_same_in_all_precisions_and_lanes(monkeypatch):
    seeds = np.array([11.0, 11.0, 5.0, 11.0, 0.0, 2.0, 3.0])
    sensors = NoisySensors(0.02, 0.03, 0.004, 0.01, seeds)
    for law in (FEEDBACK, OrbitPointing(2.0, 3.0, 0.7, ORBIT)):
        system = pt.System(BODY, Sampled(law, 0.3, 0.1, sensors))
        together = pt.propagate(system, system.state(**START), TIMES)
        own = values(together)
        assert np.min(np.ptp(own[:2, -1, -3:], axis=0)) > 1e-4  # of one seed, but two members
        quadruple = pt.propagate(system, system.state(**START), TIMES, precision="quadruple")
        assert np.max(np.abs(values(quadruple) - own)) < 1e-13
        for lanes in (1, 2, 4, 8):
            monkeypatch.setattr(equations, "LANES", lanes)
            for threads in (1, 2):
                again = pt.propagate(system, system.state(**START), TIMES[::3], threads=threads)
                assert np.max(np.abs(values(again) - own[:, ::3])) == 0
        alone = pt.System(BODY, Sampled(law, 0.3, 0.1, NOISY))  # the first member's
        one = pt.propagate(alone, alone.state(**START), TIMES, dense=True)
        assert np.array_equal(values(one), own[0])


def test_controllers_and_simulated_readings_have_the_noise_of_one_seed():
    """A gyro that is read at the samples of a controller, with the seed of its sensors, has the errors that it had."""
    sensors, still = NoisySensors(rate_noise=0.02, seed=7), pt.Body((1e9, 1e9, 1e9))
    system = pt.System(still, Sampled(pt.forces.LinearDamping(1.0), 0.5, sensors=sensors))
    start = system.state((1, 0, 0, 0), omega_body=[(0, 0, 0.3), (0.1, 0, 0)])
    motion = pt.propagate(system, start, np.arange(20) * 0.5)
    readings = pt.observe(motion, pt.observables.Gyro(noise=0.02)).simulated(seed=7)
    measured = -motion.own["sampled"]
    assert np.max(np.abs(measured - motion.omega_body)) > 0.04
    # The logarithm and the cosine of kernels and of NumPy differ by roundings.
    assert np.allclose(measured, readings.values, rtol=0, atol=1e-15)


def test_noise_has_the_spread_that_it_is_given():
    count, still = 4000, pt.Body((1e9, 1e9, 1e9))
    times, spread = np.arange(count) * 0.5, 4 / np.sqrt(count)
    rates = Sampled(RateDamping(1.0, 1e3), 0.5, sensors=NoisySensors(rate_noise=0.02, seed=4))
    angles = Sampled(QuaternionFeedback(2.0, 0.0, 1e3), 0.5, sensors=NoisySensors(attitude_noise=0.01, seed=4))
    for law, size in ((rates, 0.02), (angles, 0.01)):
        system = pt.System(still, law)
        found = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0)), times).own["sampled"]
        assert np.max(np.abs(found.mean(axis=0))) < spread * size
        assert np.max(np.abs(found.std(axis=0) / size - 1)) < spread
        assert np.max(np.abs(np.corrcoef(found.T) - np.eye(3))) < spread
        assert abs(np.mean(found[1:] * found[:-1])) < spread * size**2
    stepped = Sampled(RateDamping(1.0, 1e3), 0.5, sensors=NoisySensors(0.02, rate_quantum=0.005, seed=4))
    system = pt.System(still, stepped)
    found = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0)), times).own["sampled"]
    steps = found / 0.005
    assert np.max(np.abs(steps - np.rint(steps))) < 1e-12
    assert np.unique(np.rint(steps)).size > 10


@pytest.mark.parametrize("law", [QuaternionFeedback(2.0, 0.0, 1e3), OrbitPointing(2.0, 0.0, 1e3, ORBIT)])
def test_attitudes_in_steps_are_those_of_rounded_quaternions(law):
    """Those of a body at rest, by the quaternion and by the axes that a law sees."""
    still, quantum = pt.Body((1e9, 1e9, 1e9)), 0.02
    for seen, rounding in ((quantum, 0.5 * quantum), (0.0, 1e-300)):
        q = Rotation.random(20, np.random.default_rng(3)).as_quat(scalar_first=True)
        system = pt.System(still, Sampled(law, 0.5, sensors=NoisySensors(attitude_quantum=seen)))
        found = pt.propagate(system, system.state(q, omega_body=(0, 0, 0)), [0.0]).own["sampled"][:, 0]
        given = np.rint(q / rounding) * rounding
        alone = pt.System(still, law)
        known = [alone.torque_body(still.state(x / np.linalg.norm(x), omega_body=(0, 0, 0))) for x in given]
        assert np.max(np.abs(found - known)) < 1e-14
        assert (np.max(np.abs(given - q)) > 1e-3) == (seen > 0)


@pytest.mark.parametrize("quantum", [-0.1, 1.5])
def test_steps_of_attitudes_are_less_than_a_radian(quantum):
    with pytest.raises(
        ValueError, match=r"attitude_quantum must (not be negative, got -0\.1|be at most 1 radian, got 1\.5)"
    ):
        NoisySensors(attitude_quantum=quantum)
    NoisySensors(attitude_quantum=1.0)


def test_noise_of_size_zero_is_none():
    start = START["attitude"], START["omega_body"]
    with_none, without = (pt.System(BODY, Sampled(FEEDBACK, 0.3, 0.1, *more)) for more in ((), (NoisySensors(seed=3),)))
    motions = [
        pt.propagate(system, system.state(start[0], omega_body=start[1]), TIMES) for system in (with_none, without)
    ]
    assert np.max(np.abs(values(motions[0]) - values(motions[1]))) < 1e-14


@pytest.mark.parametrize("seed", [0.5, -1.0, 2.0**53])
def test_seeds_are_whole_numbers(seed):
    with pytest.raises(ValueError, match="seed must be a whole number from 0 to"):
        NoisySensors(seed=seed)


# ---------------------------------------------------------------------- events


class Kick(pt.events.AtTime):
    """An impulse at a time."""

    impulse: pt.BodyVector

    def act(self, body, state):
        changed = state.angular_momentum_body + self.impulse
        return body.locked.state(state.quaternion, angular_momentum_body=changed, time=state.time)


def test_events_see_the_held_torque_and_do_not_move_samples():
    law = Sampled(FEEDBACK, 0.3, 0.1)
    system = pt.System(BODY, law)
    start = system.state(**START)
    plain = pt.propagate(system, start, TIMES)
    rate = float(np.mean(plain.omega_body[3:5, 2]))
    events = [pt.events.RateCrossing((0, 0, 1), rate=rate), pt.events.AtTime(0.7), pt.events.AtTime(1.15)]
    for precision in ("double", "quadruple"):
        watched = pt.propagate(system, start, TIMES, events=events, precision=precision)
        assert difference(watched, plain) < 1e-13
        crossing, at_sample, between = watched.events
        assert crossing.times.size > 0
        assert np.max(np.abs(crossing.omega_body[:, 2] - rate)) < 1e-14
        assert np.max(np.abs(at_sample.times - 0.7)) < 1e-15
        assert np.max(np.abs(between.times - 1.15)) < 1e-15


def test_an_action_between_samples_leaves_the_torque_that_is_held():
    system = pt.System(BODY, Sampled(FEEDBACK, 0.3, 0.1))
    times, kick = np.array([0.5, 0.55, 0.6, 0.8, 1.5]), np.array((0.1, -0.2, 0.05))
    before = pt.propagate(system, system.state(**START), times[:2]).isel(time=1)
    g, own = before.angular_momentum_body + kick, before.own
    after = system.state(before.quaternion, angular_momentum_body=g, time=0.55, **own)
    expected = values(pt.propagate(system, after, times[2:]))
    for precision in ("double", "quadruple"):
        kicked = pt.propagate(system, system.state(**START), times, events=[Kick(0.55, kick)], precision=precision)
        assert np.max(np.abs(values(kicked)[2:] - expected)) < 1e-14
        assert np.max(np.abs(kicked.own["sampled"][2] - before.own["sampled"])) < 2e-15  # roundings of a torque near 1


def test_a_motion_ends_at_a_terminal_event_between_samples():
    system = pt.System(BODY, Sampled(FEEDBACK, 0.3, 0.1))
    for precision in ("double", "quadruple"):
        events = [pt.events.AtTime(0.5, terminal=True)]
        ended = pt.propagate(system, system.state(**START), TIMES, events=events, precision=precision)
        assert ended.times.tolist() == TIMES[TIMES < 0.5].tolist()


# ---------------------------------------------------------------------- what is refused


def test_samples_run_forwards_only():
    system = pt.System(BODY, *SYSTEMS["feedback"])
    sentence = (
        r"times must not be before the state's where 'sampled' is sampled, got -1\.0 before 0\.0\. Such motions run"
    )
    with pytest.raises(ValueError, match=sentence):
        pt.propagate(system, system.state(**START), [-1.0, 1.0])


def test_times_at_which_samples_cannot_be_distinguished_are_refused():
    system = pt.System(BODY, Sampled(FEEDBACK, 1e-8))
    with pytest.raises(
        ValueError, match=r"period must be longer than the rounding of the time, got 1e-08 at t = 1000000000\."
    ):
        pt.propagate(system, system.state(**START, time=1e9), [2e9])


def test_two_bodies_have_no_sampled_laws():
    ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    with pytest.raises(TypeError, match="forces on two bodies must have no parts, got ReactionWheel in ReactionWheel"):
        pt.System(pair, pt.parts.ReactionWheel((0, 0, 1), 0.1))
    with pytest.raises(TypeError, match="forces on two bodies must have no parts, got Sampled in"):
        pt.System(pair, pt.forces.MutualGravity(), Sampled(FEEDBACK, 0.3).on("primary"))


@pytest.mark.parametrize("name", [*SYSTEMS, "noise"])
def test_tangent_vectors_jump_as_differences_of_motions_do(name):
    """Central differences for a step of 1e-4 are good to 1e-9, by rounding; longer steps reach saturation."""
    noisy = Sampled(FEEDBACK, 0.3, 0.1, NoisySensors(1e-3, 1e-3, seed=5))
    system = pt.System(BODY, *({"noise": (noisy,)} | SYSTEMS)[name])
    first = system.state(**START)
    own = {part: np.asarray(values) for part, values in first.own.items()}
    places = np.cumsum([6, *(values.size for values in own.values())])
    attitude, momentum, times = first.attitude, first.angular_momentum_body, [1.0, 2.5]

    def start(x):
        parts = {part: v + x[i : i + v.size] for (part, v), i in zip(own.items(), places, strict=False)}
        return system.state(attitude * Rotation.from_rotvec(x[:3]), angular_momentum_body=momentum + x[3:6], **parts)

    def rows(motion):
        turn = (reference.attitude.inv() * motion.attitude).as_rotvec()
        parts = [motion.own[part] - reference.own[part] for part in own]
        return np.concatenate([turn, motion.angular_momentum_body - reference.angular_momentum_body, *parts], axis=-1)

    reference, k = pt.propagate(system, first, times), places[-1]
    found = pt.analysis.state_transition(system, first, times).matrix
    for direction in np.random.default_rng(2).normal(size=(2, k)):
        step = 1e-4 * direction / np.linalg.norm(direction)
        change = sum(
            sign * weight * rows(pt.propagate(system, start(sign * n * step), times))
            for n, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
            for sign in (1, -1)
        )
        np.testing.assert_allclose(found @ step, change, rtol=0, atol=1e-9 * np.max(np.abs(change)))


def test_derivatives_by_gains_and_not_by_the_times_of_samples():
    system = pt.System(BODY, Sampled(RateDamping(0.8, 5.0), 0.3, 0.1))
    start, h = system.state(**START), 1e-3
    found = pt.analysis.state_transition(system, start, [2.0], ["gain"]).sensitivity[0, 3:6, 0]
    change = sum(
        sign
        * weight
        * pt.propagate(
            pt.System(BODY, Sampled(RateDamping(0.8 + sign * n * h, 5.0), 0.3, 0.1)), start, [2.0]
        ).angular_momentum_body[0]
        for n, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
        for sign in (1, -1)
    )
    np.testing.assert_allclose(found, change / h, rtol=0, atol=1e-11)
    for name in ("period", "offset"):
        with pytest.raises(ValueError, match="parameters must not be the period or the offset of a sampled law"):
            pt.analysis.state_transition(system, start, [2.0], [name])


def test_a_spectrum_refuses_digital_controllers():
    law = Sampled(RateDamping(0.4, 0.2), 0.3)
    system = pt.System(BODY, law)
    with pytest.raises(ValueError, match="system must have no digital controller, got 'sampled'"):
        pt.analysis.lyapunov_spectrum(system, system.state(**START), [1.0])


@pytest.mark.parametrize("members", [(), (3,)])
def test_columns_that_are_computed_apart_are_of_the_same_noise(members, monkeypatch):
    """Three controllers make fifteen tangent coordinates, each a copy of the member with the member's noise."""
    sensors = (NoisySensors(1e-2, 2e-2, 1e-3, seed=float(seed)) for seed in range(3))
    laws = [Sampled(RateDamping(0.2, 0.4), 0.2, 0.1, each, name=f"law{i}") for i, each in enumerate(sensors)]
    rates = np.random.default_rng(1).normal(size=(*members, 3))
    system, times = pt.System(BODY, *laws), [0.5, 2.0]
    state = system.state((1, 0, 0, 0), omega_body=rates)
    found = pt.analysis.state_transition(system, state, times, ["moments[0]"])
    motion = pt.propagate(system, state, times)
    np.testing.assert_allclose(found.motion.omega_body, motion.omega_body, rtol=0, atol=1e-15)
    monkeypatch.setattr(transition_matrix, "MAX_COORDINATES_TOGETHER", 16)
    whole = pt.analysis.state_transition(system, state, times, ["moments[0]"])
    for name in ("matrix", "sensitivity"):
        one, other = getattr(found, name), getattr(whole, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-13 * np.max(np.abs(other)))


HELD = [force for force in FORCES if isinstance(force, pt.Torque)]
HELD += [pt.forces.BDot(0.8, field, 0.4) for field in MAGNETIC_FIELDS[1:]]


@pytest.mark.parametrize("law", HELD, ids=lambda law: type(law).__name__)
def test_every_torque_is_held_as_it_is_at_a_sample(law):
    system, plain = pt.System(BODY, Sampled(law, 0.3, 0.1)), pt.System(BODY, law)
    motion = pt.propagate(system, system.state(**START), TIMES[:3])
    (held,) = motion.own.values()
    state = {"attitude": motion.quaternion[1], "omega_body": motion.omega_body[1]}
    torque = plain.torque_body(plain.state(time=TIMES[1], **state))
    assert np.max(np.abs(torque)) > 1e-2
    # Rounding of the position along an orbit and of the attitude: 3.1e-15 at worst in 20 starts a rounding away.
    assert np.max(np.abs(held[1] - torque)) < 1e-14 * np.max(np.abs(torque))
    assert np.array_equal(held[2], held[1])
