"""What the closed form of torque-free motion keeps, what it must not depend on, and where it must be continuous."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import Phase, assume, example, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.propagation.free_motion import motion as closed_form

LAWS = settings(
    derandomize=True, max_examples=40, deadline=None, database=None, phases=(Phase.explicit, Phase.generate)
)
EPS = np.finfo(float).eps
ROUNDING = 8 * EPS
"""Of a quaternion at any time; of the momentum, relative to its size."""
EVER = 1e9

# ---------------------------------------------------------------------- bodies and states

GENERIC = st.tuples(*[st.floats(0.1, 1)] * 3).map(lambda x: np.array([x[1] + x[2], x[0] + x[2], x[0] + x[1]]))
DEGENERATE = st.sampled_from(
    [
        (1.0, 1.0, 1.0),
        (1.0, 1.0, 1 + 1e-9),
        (1.0, 1 + 1e-15, 1 - 1e-15),
        (1.0, 1.0, 0.6),
        (0.5, 1.0, 1.0),
        (1.0, 1 + 1e-10, 0.6),
        (0.4, 0.6, 1.0),
        (0.4, 0.6, 1 - 1e-12),
        (1.6, 1.0, 1.0),
        (1.0, 1.0, 1e-4),
        (6.0, 4.0, 3.0),
    ]
).map(np.array)
MOMENTS = GENERIC | DEGENERATE
NOT_TINY = st.floats(-1.5, 1.5).map(lambda x: x if abs(x) > 1e-30 else 0.0)
ANYWHERE = st.tuples(*[NOT_TINY] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
QUATERNIONS = (ANYWHERE | st.sampled_from([(1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 0, 1.0), (0.5, 0.5, -0.5, 0.5)])).map(
    lambda q: np.array(q) / np.linalg.norm(q)
)
MOMENTA = st.tuples(*[NOT_TINY] * 3).filter(lambda g: np.linalg.norm(g) > 0.01) | st.sampled_from(
    [(0.0, 0, 0), (0, 1.0, 0), (0, 1.0, 1e-9), (0, 0, -1.0), (1.0, 0.75, 1.0), (-1.0, 0, 1.0), (1.0, 0.75, 1 + 1e-12)]
)


@st.composite
def bodies(draw):
    """Bodies along their principal axes and along others."""
    moments, turn = draw(MOMENTS), draw(st.none() | QUATERNIONS)
    return pt.Body(moments) if turn is None else oblique(moments, Rotation.from_quat(turn, scalar_first=True))


def oblique(moments, turn):
    """The body along axes in which `turn` gives the principal axes."""
    tensor = turn.as_matrix() @ np.diag(moments) @ turn.as_matrix().T
    return pt.Body.from_inertia((tensor + tensor.T) / 2)


@st.composite
def states(draw, time=0.0):
    return canonical(pt.Body((1, 1, 1)).state(draw(QUATERNIONS), angular_momentum_body=draw(MOMENTA), time=time))


def canonical(state):
    """The state of the same q and Q, from which the laws make others without a rounding."""
    return pt.State(state.quaternion, state.conjugate_momenta, state.time)


def largest_rate(body, state):
    """Of the body about any axis, with this momentum; one at rest."""
    return np.linalg.norm(state.angular_momentum_body) / np.min(body.moments) or 1.0


def instability(body, state, phase):
    """How much a rounding can grow until the largest rate has made this angle.

    A difference d of two momenta obeys |d|' <= |d| G (1/I_min - 1/I_max) / 2, as far as Euler's equations let it
    grow; near the separatrix it has grown by about one over the distance when the momentum has passed once.
    """
    g = body.principal_axes.inv().apply(state.angular_momentum_body)
    middle, rates = np.median(1 / body.moments), 1 / body.moments
    spread, G2 = np.ptp(rates), g @ g
    distance = abs(g**2 @ (rates - middle)) / (spread * G2) if spread and G2 else 1.0
    return min(np.exp(min(phase * spread / np.max(rates) / 2, 700)), 1 / max(distance, 1e-300))


def rounding(body, state):
    """Return the effect of a rounding of the momentum along its trajectory, a logarithm near the separatrix."""
    return ROUNDING * (1 + np.log(instability(body, state, EVER)) / 10)


def momentum_error(found, expected):
    """The largest difference relative to the size; zero for a body at rest."""
    size = np.max(np.linalg.norm(np.atleast_2d(expected), axis=-1))
    return np.max(np.abs(found - expected)) / (size or 1.0)


def differences(motion, quaternion, momenta):
    """The largest difference in q, its sign included, and in Q / 2G."""
    return max(np.max(np.abs(motion.quaternion - quaternion)), momentum_error(motion.conjugate_momenta, momenta))


# ---------------------------------------------------------------------- the same as an integration


@LAWS
@given(bodies(), states(), st.floats(1, 300))
@example(pt.Body((1.0, 1.0, 1e-4)), pt.State((1, 0, 0, 0), (0, 2, 0.3, 0.1)), 100.0)
def test_closed_form_is_the_integration(body, state, phase):
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    motion = pt.free_motion(body, state, times)
    other = pt.propagate(pt.System(body), state, times)
    allowed = 1e-13 * (1 + phase / 100) * instability(body, state, phase)
    assert differences(motion, other.quaternion, other.conjugate_momenta) < allowed


# ---------------------------------------------------------------------- conserved quantities


@LAWS
@given(bodies(), states(), st.sampled_from([1.0, 1e3, 1e6, 1e9]))
def test_norm_energy_and_momentum_in_space_are_conserved_at_any_time(body, state, phase):
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    motion = pt.free_motion(body, state, times)
    q, Q = motion.quaternion, motion.conjugate_momenta
    G = np.linalg.norm(state.angular_momentum_body)
    assert np.max(np.abs(np.linalg.norm(q, axis=-1) - 1)) <= 5 * EPS
    assert np.max(np.abs(np.sum(q * Q, axis=-1))) <= 8 * EPS * G
    momentum = motion.attitude.apply(motion.angular_momentum_body)
    assert np.max(np.abs(momentum - state.angular_momentum_space)) <= 16 * EPS * G
    g = motion.angular_momentum_body
    energy = 0.5 * np.einsum("ni,ni->n", g, np.linalg.solve(body.inertia, g.T).T)
    at_start = 0.5 * state.angular_momentum_body @ np.linalg.solve(body.inertia, state.angular_momentum_body)
    assert np.max(np.abs(energy - at_start)) <= 16 * EPS * G**2 / np.min(body.moments)


@LAWS
@given(bodies(), states())
def test_it_starts_where_the_state_is(body, state):
    motion = pt.free_motion(body, state, [0.0])
    assert differences(motion, state.quaternion, state.conjugate_momenta) <= rounding(body, state)


def test_rates_are_those_of_the_equations():
    """q' = q (0, omega) / 2 at a time of a million turns, by differences of the sixth order."""
    body = pt.Body((1.25, 1.0, 0.75))
    state = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    step, start = 2.0**-6, 2.0**23
    motion = pt.free_motion(body, state, start + step * np.arange(-3, 4))
    rate = np.array([-1, 9, -45, 0, 45, -9, 1]) @ motion.quaternion / (60 * step)
    expected = quat.product(motion.quaternion[3], [0, *(motion.angular_momentum_body[3] / body.moments)]) / 2
    assert np.max(np.abs(rate - expected)) < 3e-14


# ---------------------------------------------------------------------- time


@LAWS
@given(bodies(), states(), st.floats(0.1, 100), st.floats(-100, 100))
def test_motion_goes_on_from_wherever_it_is(body, state, phase, other):
    assume(instability(body, state, phase + abs(other)) < 1e3)
    first, second = np.array([phase, other]) / largest_rate(body, state)
    there = pt.free_motion(body, state, [first])
    then = pt.State(there.quaternion[0], there.conjugate_momenta[0], first)
    whole = pt.free_motion(body, state, [first + second])
    rest = pt.free_motion(body, then, [first + second])
    allowed = ROUNDING * (1 + phase + abs(other)) * instability(body, state, phase + abs(other))
    assert differences(rest, whole.quaternion, whole.conjugate_momenta) < allowed


@LAWS
@given(bodies(), states(), st.sampled_from([1.0, 1e3, 1e9]))
def test_turning_the_momentum_over_runs_the_motion_back(body, state, phase):
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    back = pt.free_motion(body, pt.State(state.quaternion, -state.conjugate_momenta), times)
    motion = pt.free_motion(body, state, -times)
    assert differences(back, motion.quaternion, -motion.conjugate_momenta) <= 2 * rounding(body, state)


@LAWS
@given(bodies(), states(), st.sampled_from([-(2.0**20), 0.5, 2.0**30]))
def test_clock_is_arbitrary(body, state, start):
    times = np.linspace(-3, 8, 12)
    later = pt.free_motion(body, pt.State(state.quaternion, state.conjugate_momenta, start), start + times)
    motion = pt.free_motion(body, state, times)
    assert np.array_equal(later.quaternion, motion.quaternion)
    assert np.array_equal(later.conjugate_momenta, motion.conjugate_momenta)


def test_difference_of_time_and_start_is_taken_without_rounding():
    """0.1 - 1e9 has more digits than a double; a sphere at rate one turns by that angle."""
    body, state = pt.Body((1, 1, 1)), pt.State((1, 0, 0, 0), (0, 0, 0, 2), 1e9)
    motion = pt.free_motion(body, state, [0.1])
    with mp.workdps(30):
        half = (mpf(0.1) - 10**9) / 2
        assert abs(motion.quaternion[0, 0] - mp.cos(half)) < 2 * EPS
        assert abs(motion.quaternion[0, 3] - mp.sin(half)) < 2 * EPS


@LAWS
@given(bodies(), states())
def test_order_and_number_of_times_change_nothing(body, state):
    times = np.linspace(-7, 12, 39)
    motion = pt.free_motion(body, state, times)
    falling = pt.free_motion(body, state, times[::-1])
    assert np.array_equal(falling.times, times[::-1])
    assert differences(falling, motion.quaternion[::-1], motion.conjugate_momenta[::-1]) <= 2 * EPS
    for i in (0, 17, 38):
        alone = pt.free_motion(body, state, times[[i]])
        assert differences(alone, motion.quaternion[[i]], motion.conjugate_momenta[[i]]) <= 4 * EPS
        called = motion(times[i])
        assert called.time == times[i]
        assert np.max(np.abs(called.quaternion - motion.quaternion[i])) <= 2 * EPS


def test_motion_can_be_called_at_any_time_in_any_shape():
    body, state = pt.Body((1.25, 1.0, 0.75)), pt.State((0.5, 0.5, 0.5, 0.5), (-1.0, 0.2, 0.3, 0.5), 3.0)
    times = np.linspace(-100, 100, 10_001)
    motion = pt.free_motion(body, state, times)
    few = pt.free_motion(body, state, [0.0])
    for of_it in (motion, few):
        shaped = of_it(times[:24].reshape(2, 3, 4))
        assert shaped.quaternion.shape == (2, 3, 4, 4)
        assert np.max(np.abs(shaped.quaternion.reshape(24, 4) - motion.quaternion[:24])) <= 2 * EPS
        assert shaped.time.tolist() == times[:24].reshape(2, 3, 4).tolist()
        every = of_it(times)
        assert differences(motion, every.quaternion, every.conjugate_momenta) <= 2 * EPS
    assert np.max(np.abs(motion(3.0).quaternion - state.quaternion)) <= ROUNDING


# ---------------------------------------------------------------------- axes and units

HALF_TURNS = [s * row for row in np.eye(4) for s in (1, -1)]
QUARTER_TURNS = [
    np.array(q) / np.linalg.norm(q)
    for q in itertools.product((-1, 0, 1), repeat=4)
    if np.count_nonzero(q) in (2, 4) or (np.count_nonzero(q) == 1 and sum(q) > 0)
]
"""The quaternions of the 24 turns of a cube, all but four of them twice."""


def turned_by(state, left=(1, 0, 0, 0), right=(1, 0, 0, 0)):
    q, Q = (quat.product(quat.product(left, x), right) for x in (state.quaternion, state.conjugate_momenta))
    return pt.State(q, Q)


@LAWS
@given(bodies(), states(), st.sampled_from(HALF_TURNS), st.sampled_from([1.0, 1e3, 1e9]))
def test_world_turned_by_half_a_turn_has_the_same_digits(body, state, turn, phase):
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    motion, elsewhere = pt.free_motion(body, state, times), pt.free_motion(body, turned_by(state, turn), times)
    expected = [quat.product(turn, x) for x in (motion.quaternion, motion.conjugate_momenta)]
    # The momentum along the body has 32 digits, of which the separatrix and time take some.
    allowed = rounding(body, state) + 1e-31 * (1 + phase) * instability(body, state, phase)
    assert differences(elsewhere, *expected) <= allowed


@LAWS
@given(bodies(), states(), QUATERNIONS, st.floats(0.1, 100))
def test_turned_world_has_the_turned_motion(body, state, turn, phase):
    assume(instability(body, state, phase) < 1e3)
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    motion, elsewhere = pt.free_motion(body, state, times), pt.free_motion(body, turned_by(state, turn), times)
    expected = [quat.product(turn, x) for x in (motion.quaternion, motion.conjugate_momenta)]
    allowed = ROUNDING * (1 + phase) * instability(body, state, phase)
    assert differences(elsewhere, *expected) < allowed


def permuted(moments, turn):
    """The moments along the axes whose columns the turn gives in the old ones."""
    axes = Rotation.from_quat(turn, scalar_first=True).as_matrix()
    return np.array(moments)[np.argmax(np.abs(axes), axis=0)]


def test_there_are_24_names_of_the_axes():
    matrices = {tuple(Rotation.from_quat(q, scalar_first=True).as_matrix().round().ravel()) for q in QUARTER_TURNS}
    assert len(matrices) == 24


@pytest.mark.parametrize("moments", [(1.25, 1.0, 0.75), (1.0, 1.0, 0.6), (1.6, 1.0, 1.0), (1.0, 1 + 1e-15, 1 - 1e-15)])
@pytest.mark.parametrize("g", [(0.9, 0.3, 0.2), (-0.2, 0.3, 0.9), (0, 1, 0), (0.1, 0, -1)])
def test_names_of_the_axes_are_arbitrary(moments, g):
    phase = 30
    body = pt.Body(moments)
    state = canonical(body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=g))
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(body, state)
    motion = pt.free_motion(body, state, times)
    exact = [row.tolist() for row in HALF_TURNS]
    for turn in QUARTER_TURNS:
        renamed = pt.free_motion(pt.Body(permuted(moments, turn)), turned_by(state, right=turn), times)
        expected = [quat.product(x, turn) for x in (motion.quaternion, motion.conjugate_momenta)]
        input_rounding = 0 if turn.tolist() in exact else 4 * EPS * phase * instability(body, state, phase)
        assert differences(renamed, *expected) < ROUNDING + input_rounding


@LAWS
@given(bodies(), states(), st.integers(-200, 200), st.integers(-200, 200))
def test_units_of_powers_of_two_change_no_digit(body, state, a, b):
    inertia, momentum = 2.0**a, 2.0**b
    times = np.linspace(-30, 80, 27)
    motion = pt.free_motion(body, state, times)
    axes = [] if type(body) is pt.Body else [body.axes]
    larger = type(body)(body.moments * inertia, *axes)
    scaled = pt.State(state.quaternion, state.conjugate_momenta * momentum)
    other = pt.free_motion(larger, scaled, times * (inertia / momentum))
    assert np.array_equal(other.quaternion, motion.quaternion)
    assert np.array_equal(other.conjugate_momenta, motion.conjugate_momenta * momentum)


@LAWS
@given(MOMENTS, states(), QUATERNIONS, st.floats(0.1, 100))
def test_oblique_axes_have_the_motion_of_the_principal_ones(moments, state, turn, phase):
    """The body axes are turned by t in the principal ones: I = R(t~) diag R(t), q' = q t."""
    principal = pt.Body(moments)
    assume(instability(principal, state, phase) < 1e3)
    slanted = oblique(moments, Rotation.from_quat(turn, scalar_first=True).inv())
    times = np.linspace(-0.3, 1, 27) * phase / largest_rate(principal, state)
    motion = pt.free_motion(principal, state, times)
    other = pt.free_motion(slanted, turned_by(state, right=turn), times)
    expected = [quat.product(x, turn) for x in (motion.quaternion, motion.conjugate_momenta)]
    # The tensor is rounded relative to its largest entry, rates relative to the smallest moment.
    allowed = 8 * ROUNDING * (1 + phase) * np.max(moments) / np.min(moments)
    assert differences(other, *expected) < allowed * instability(principal, state, phase)


# ---------------------------------------------------------------------- continuity

SIZES = [0.0, *(s * 10.0**-n for n in (*range(3, 17), 20, 50, 100, *range(140, 165, 3), 200, 300) for s in (1, -1))]
GENERAL = (0.5, -0.3, 0.8)
# name: moments and momentum of the member of a family
FAMILIES = {
    "prolate": (lambda s: (1, 1 + s, 0.6), lambda _: GENERAL),
    "oblate": (lambda s: (1.5, 1, 1 + s), lambda _: GENERAL),
    "sphere": (lambda s: (1, 1 + s, 1 - 0.7 * s), lambda _: GENERAL),
    "sphere, other way": (lambda s: (1 + 0.3 * s, 1 - s, 1), lambda _: GENERAL),
    "prolate, momentum across": (lambda _: (1, 1, 0.6), lambda s: (0.3, 1, s)),
    "oblate, momentum across": (lambda _: (1.5, 1, 1), lambda s: (s, 1, -0.3)),
    "nearly prolate, momentum across": (lambda s: (1, 1 + s, 0.6), lambda s: (0.3, 1, s)),
    "nearly prolate, momentum along the equal axis": (lambda s: (1, 1 + s, 0.6), lambda s: (s, 1, 0.2 * s)),
    "about the short axis": (lambda _: (6, 4, 3), lambda s: (-1, s, 0.4 * s)),
    "about the long axis": (lambda _: (6, 4, 3), lambda s: (0.7 * s, s, 1)),
    "about the middle axis": (lambda _: (6, 4, 3), lambda s: (s, 1, 0.3 * s)),
    "about the middle axis, other side": (lambda _: (6, 4, 3), lambda s: (0.3 * s, -1, s)),
    "about the middle axis, along the separatrix": (lambda _: (6, 4, 3), lambda s: (s, 1, s)),
    "separatrix": (lambda _: (6, 4, 3), lambda s: (1, 0.75, 1 + s)),
    "separatrix, by the moments": (lambda s: (6, 4 * (1 + s), 3), lambda _: (1, 0.75, 1)),
    "separatrix, near its ends": (lambda _: (6, 4, 3), lambda s: (1e-3, 2, 1e-3 + s)),
    "separatrix of a slender body": (lambda _: (9, 8, 4), lambda s: (3 + s, 0.75, 1)),
    "momentum through a principal plane": (lambda _: (6, 4, 3), lambda s: (s, 0.6, 0.8)),
    "momentum through another": (lambda _: (6, 4, 3), lambda s: (0.6, s, 0.8)),
    "from far to near the separatrix": (lambda _: (6, 4, 3), lambda s: (1, 0.5, 1.7 + 30 * s)),
}
Q = np.array([0.1, 0.7, -0.5, 0.5])


def bound_of_change(bodies, states, t):
    """What the motion can change by time t when moments and momentum change; of the attitude (radians) and g / G.

    With D the change of the rates c = 1/I: d' = d x omega + g x (c d) + g x (D g), of which the first term turns d
    only, the second adds at most K |d|, K = G (c_max - c_min) / 2, and the third G^2 |D|. Then |d| is below
    e^(K t) (|d0| + G^2 |D| t), and the attitude gains G |D| + c_max |d| per unit of time.
    """
    momenta, rates = [state.angular_momentum_body for state in states], [1 / body.moments for body in bodies]
    G, highest = max(np.linalg.norm(g) for g in momenta), np.max(rates)
    change, by_rates = np.linalg.norm(momenta[1] - momenta[0]), np.max(np.abs(rates[1] - rates[0])) * G
    growth = np.exp(G * max(np.ptp(c) for c in rates) / 2 * t)
    momentum = growth * (change + by_rates * G * t)
    return by_rates * t + highest * momentum * t, momentum / G


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("q", [Q, (1, 0, 0, 0)], ids=["rounded", "exact"])
def test_motion_is_continuous_in_body_and_state(name, q):
    moments, momentum = FAMILIES[name]
    family = [pt.Body(moments(s)) for s in sorted(SIZES)]
    starts = [body.state(q, angular_momentum_body=momentum(s)) for body, s in zip(family, sorted(SIZES), strict=True)]
    times = np.linspace(-1, 1, 15) * 12 / largest_rate(family[0], starts[0])
    momenta = [state.angular_momentum_body for state in starts]
    bodies = pt.Body([body.moments for body in family])
    motions = pt.free_motion(bodies, bodies.state(q, angular_momentum_body=momenta), times)
    for i, (one, other) in enumerate(itertools.pairwise(motions)):
        turns = (one.attitude.inv() * other.attitude).magnitude()
        changes = momentum_error(one.angular_momentum_body, other.angular_momentum_body)
        bounds = [bound_of_change(family[i : i + 2], starts[i : i + 2], abs(t)) for t in times]
        assert np.all(turns < np.array(bounds)[:, 0] + 2 * ROUNDING)
        assert changes < bounds[0][1] + 2 * ROUNDING
        # q itself does not change its sign either.
        assert np.max(np.abs(one.quaternion - other.quaternion)) < 0.5


# ---------------------------------------------------------------------- members


def every_case():
    pairs = [(moments(s), momentum(s)) for moments, momentum in FAMILIES.values() for s in (0.0, 1e-3, -1e-7, 1e-12)]
    pairs += [((1.25, 1.0, 0.75), (0, 0, 0)), ((1, 1, 1), (0, 0, 0)), ((1, 1, 1e-4), (1, 0.2, 1e-4))]
    return (np.array(values, dtype=float) for values in zip(*pairs, strict=True))


@pytest.mark.parametrize(
    "times", [np.linspace(-20, 60, 33), [1e9], np.linspace(0, 1, 300)], ids=["few", "one", "more than a block"]
)
def test_members_are_as_one_by_one(times, monkeypatch):
    monkeypatch.setattr(closed_form, "ATTITUDES_PER_BLOCK", 256)
    moments, g = every_case()
    rng = np.random.default_rng(5)
    q, start = rng.normal(size=(len(g), 4)), rng.uniform(-5, 5, len(g))
    bodies = pt.Body(moments)
    state = bodies.state(q / np.linalg.norm(q, axis=-1, keepdims=True), angular_momentum_body=g, time=start)
    motion = pt.free_motion(bodies, state, times)
    assert motion.quaternion.shape == (len(g), len(times), 4)
    for n in range(len(g)):
        body = pt.Body(moments[n])
        alone = pt.free_motion(body, body.state(state.quaternion[n], angular_momentum_body=g[n], time=start[n]), times)
        assert np.max(np.abs(motion.quaternion[n] - alone.quaternion)) <= 4 * EPS
        assert momentum_error(motion.conjugate_momenta[n], alone.conjugate_momenta) <= 4 * EPS


def test_one_body_in_many_states_and_many_bodies_in_one_state():
    moments, g = every_case()
    body = oblique((1.25, 1.0, 0.75), Rotation.from_rotvec([0.4, -0.7, 0.3]))
    times = np.linspace(-20, 60, 33)
    states = body.state(Q, angular_momentum_body=g)
    motion = pt.free_motion(body, states, times)
    for n in range(0, len(g), 7):
        alone = pt.free_motion(body, body.state(Q, angular_momentum_body=g[n]), times)
        assert np.max(np.abs(motion.quaternion[n] - alone.quaternion)) <= 4 * EPS
    state = body.state(Q, angular_momentum_body=GENERAL)
    motion = pt.free_motion(pt.Body(moments), state, times)
    for n in range(0, len(g), 7):
        alone = pt.free_motion(pt.Body(moments[n]), state, times)
        assert np.max(np.abs(motion.quaternion[n] - alone.quaternion)) <= 4 * EPS


def test_members_are_as_an_ensemble_of_integrations():
    moments, g = every_case()
    bodies = pt.Body(moments)
    state = bodies.state(Q, angular_momentum_body=g, time=0.5)
    times = np.linspace(-2, 4, 13)
    motion, other = pt.free_motion(bodies, state, times), pt.propagate(pt.System(bodies), state, times)
    chosen = np.linalg.norm(g, axis=-1) / np.min(moments, axis=-1) < 3
    assert np.count_nonzero(chosen) > 60
    assert np.max(np.abs(motion.quaternion - other.quaternion)[chosen]) < 2e-14


# ---------------------------------------------------------------------- bad input

BODY = pt.Body((1.25, 1.0, 0.75))
STATE = BODY.state((1, 0, 0, 0), omega_body=(0.4, -0.3, 0.6))
THREE = pt.State(np.tile((1.0, 0, 0, 0), (3, 1)), (0, 1, 0, 0))
ORDER = "The order is free_motion(body, state, times)."
BAD = {
    "order": (lambda: pt.free_motion(STATE, BODY, [0]), TypeError, f"body must be a Body, got State. {ORDER}"),
    "system": (
        lambda: pt.free_motion(pt.System(BODY), STATE, [0]),
        TypeError,
        f"body must be a Body, got System. {ORDER}",
    ),
    "class": (
        lambda: pt.free_motion(pt.Body, STATE, [0]),
        TypeError,
        f"body must be a Body, got the class Body. {ORDER}",
    ),
    "times_first": (
        lambda: pt.free_motion(BODY, [0, 1], STATE),
        TypeError,
        f"state must be a State, got list. {ORDER}",
    ),
    "equal_times": (
        lambda: pt.free_motion(BODY, STATE, [0, 1, 1, 2]),
        ValueError,
        "times must be strictly monotonic, but times[1] = times[2] = 1.0.",
    ),
    "back_and_forth": (
        lambda: pt.free_motion(BODY, STATE, [0, 2, 1]),
        ValueError,
        "times must be strictly monotonic, but times[1] = 2.0 and times[2] = 1.0.",
    ),
    "no_times": (
        lambda: pt.free_motion(BODY, STATE, []),
        ValueError,
        "times must not be empty, got shape (0,).",
    ),
    "one_number": (
        lambda: pt.free_motion(BODY, STATE, 1.0),
        ValueError,
        "times must have shape (n,), got the number 1.0. Write [1.0].",
    ),
    "infinite_time": (
        lambda: pt.free_motion(BODY, STATE, [0, np.inf]),
        ValueError,
        "times must be finite, got times[1] = inf.",
    ),
    "words": (
        lambda: pt.free_motion(BODY, STATE, ["now"]),
        TypeError,
        "times must be real numbers, got list ['now'].",
    ),
    "members": (
        lambda: pt.free_motion(pt.Body(np.ones((2, 3))), THREE, [0]),
        ValueError,
        "state and system must have equally many members, got 2 and 3.",
    ),
    "units": (
        lambda: pt.free_motion(BODY, STATE, [0], units="SI"),
        TypeError,
        "units must be a mapping, got str 'SI'.",
    ),
    "called_at_no_time": (
        lambda: pt.free_motion(BODY, STATE, [0])(np.nan),
        ValueError,
        "time must be finite, got time = nan.",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_wrong_arguments_get_a_sentence(name):
    call, kind, sentence = BAD[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence)}$"):
        call()


def test_an_ensemble_cannot_be_called():
    with pytest.raises(ValueError, match="a trajectory must have dense output to be called, got none"):
        pt.free_motion(BODY, THREE, [0.0, 1.0])(0.5)
