"""The state: attitude, conjugate momenta and time."""

import copy
import itertools
import pickle
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.integration.formulations import FORMULATIONS

EPS = np.finfo(float).eps
SEQUENCES = [a + b + c for a, b, c in itertools.product("123", repeat=3) if a != b and b != c]
ROOT = np.sqrt(2.0)
PRINTED = ((0.5, -1 / ROOT, 0, 0.5), (0.3, -0.6 * ROOT, 0.1 * ROOT, -1.5))


def test_angular_momentum_of_the_papers_state():
    state = pt.State(*PRINTED)
    assert np.allclose(state.angular_momentum_body, [-0.05 * ROOT, 0.55 * ROOT, -0.4], rtol=0, atol=4e-16)
    A = Rotation.from_quat(PRINTED[0], scalar_first=True)
    assert np.allclose(state.angular_momentum_space, A.apply(state.angular_momentum_body), rtol=0, atol=1e-15)


def test_conjugate_momenta_are_twice_q_times_g():
    state = pt.State((0.0, 1.0, 0.0, 0.0), (-2.0, 0.0, -6.0, 4.0))
    assert state.angular_momentum_body.tolist() == [1.0, 2.0, 3.0]
    assert state.angular_momentum_space.tolist() == [1.0, -2.0, -3.0]


def test_momenta_of_the_identity_attitude():
    state = pt.State((1, 0, 0, 0), (0, 2, 4, 6))
    assert state.angular_momentum_body.tolist() == state.angular_momentum_space.tolist() == [1, 2, 3]


def test_the_other_sign_of_both_is_the_same_physical_state():
    state, other = pt.State(*PRINTED), pt.State(*(-np.array(x) for x in PRINTED))
    assert np.array_equal(state.angular_momentum_body, other.angular_momentum_body)
    assert (state.attitude.inv() * other.attitude).magnitude() < 1e-15


def test_attitude_is_scipys_body_to_space():
    state = pt.State((np.sqrt(0.5), 0, 0, np.sqrt(0.5)), (0, 1, 0, 0))
    assert np.allclose(state.attitude.apply([1, 0, 0]), [0, 1, 0], rtol=0, atol=1e-15)


def test_a_rotation_is_accepted_as_quaternion():
    turn = Rotation.from_rotvec([0.1, 0.2, 0.3])
    assert np.allclose(pt.State(turn, (0, 0, 0, 0)).quaternion, turn.as_quat(scalar_first=True), rtol=0, atol=1e-15)


def test_zero_momenta_are_tangent():
    assert pt.State((1, 0, 0, 0), (0, 0, 0, 0)).angular_momentum_body.tolist() == [0, 0, 0]


def test_small_defects_are_preserved_as_they_are():
    state = pt.State((1 + 9e-10, 0, 0, 0), (9e-10, 1, 0, 0))
    assert state.quaternion[0] == 1 + 9e-10
    assert state.conjugate_momenta[0] == 9e-10


def test_arrays_of_states():
    q, Q, times = np.tile(PRINTED[0], (3, 1)), np.tile(PRINTED[1], (3, 1)), np.arange(3.0)
    state = pt.State(q, Q, times)
    assert state.angular_momentum_body.shape == (3, 3)
    assert np.allclose(state.angular_momentum_space[2], pt.State(*PRINTED).angular_momentum_space, rtol=0, atol=1e-15)
    assert len(state.attitude) == 3


def test_one_quaternion_with_many_momenta_broadcasts():
    state = pt.State((1, 0, 0, 0), [(0, 1, 0, 0), (0, 0, 1, 0)])
    assert state.quaternion.tolist() == [[1, 0, 0, 0], [1, 0, 0, 0]]


def test_repr_shows_the_numbers():
    state = pt.State((1, 0, 0, 0), (0, 1, 0, 0), 2.0)
    assert repr(state).splitlines() == [
        "State at t = 2",
        "  quaternion (body to space): [1, 0, 0, 0]",
        "  angular momentum (body axes): [0.5, 0, 0]",
        "  conjugate momenta: [0, 1, 0, 0]",
    ]


def test_repr_of_many_states_is_short():
    state = pt.State((1, 0, 0, 0), np.zeros((50, 4)), np.arange(50.0))
    assert repr(state).startswith("State of 50 members at t = 50, 0 ... 49\n")
    assert len(repr(state)) < 260


# ---------------------------------------------------------------------- Euler variables


def test_the_papers_euler_variables_of_its_first_problem():
    state = pt.State.from_euler((np.pi / 4, 3 * np.pi / 2, np.pi / 4), (0.5, 0.6, 0.4))
    assert np.allclose(state.quaternion, [-0.5, 1 / ROOT, 0, -0.5], rtol=0, atol=4e-16)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_from_euler_gives_the_attitude_of_scipy(sequence):
    angles = (0.4, 0.9, 2.3)
    state = pt.State.from_euler(angles, (0.5, 0.6, 0.4), sequence, time=3.0)
    expected = Rotation.from_euler(sequence.translate(str.maketrans("123", "XYZ")), angles)
    assert (expected.inv() * state.attitude).magnitude() < 2e-15
    assert state.time == 3.0


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_momenta_are_projections_on_the_rotation_axes(sequence):
    angles, momenta = np.array([0.4, 0.9, 2.3]), (0.5, 0.6, 0.4)
    state = pt.State.from_euler(angles, momenta, sequence)
    i, j, k = (int(digit) - 1 for digit in sequence)
    nodes = Rotation.from_rotvec(angles[0] * np.eye(3)[i]).apply(np.eye(3)[j])
    assert state.angular_momentum_space[i] == pytest.approx(0.5, abs=1e-14)
    assert state.angular_momentum_space @ nodes == pytest.approx(0.6, abs=1e-14)
    assert state.angular_momentum_body[k] == pytest.approx(0.4, abs=1e-14)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_variables_come_back_with_the_sign(sequence):
    for first in (0.4, 0.4 + 2 * np.pi):
        given, momenta = np.array([first, 0.9, 2.3]), np.array([0.5, 0.6, 0.4])
        angles, back = pt.State.from_euler(given, momenta, sequence).euler(sequence)
        assert np.allclose(angles, given, rtol=0, atol=5e-15)
        assert np.allclose(back, momenta, rtol=0, atol=5e-15)


def singular_attitude(sequence, angle=0.3):
    """An attitude with parallel outer axes, composed by SciPy."""
    middle = 0.0 if sequence[0] == sequence[2] else np.pi / 2
    return Rotation.from_euler(sequence.translate(str.maketrans("123", "XYZ")), (angle, middle, 0.0))


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_a_singular_attitude_is_refused_with_a_regular_sequence(sequence):
    state = pt.Body((2.0, 2.5, 3.5)).state(singular_attitude(sequence), omega_body=(0.1, 0.2, 0.3))
    with pytest.raises(ValueError, match=rf"^the second angle of sequence {sequence} must stay") as caught:
        state.euler(sequence)
    regular = re.search(r"there\. Use sequence (\d{3})\.$", str(caught.value))
    assert regular
    angles, _ = state.euler(regular[1])
    letters = regular[1].translate(str.maketrans("123", "XYZ"))
    assert (Rotation.from_euler(letters, angles).inv() * state.attitude).magnitude() < 1e-14


def test_attitudes_at_which_no_sequence_is_regular():
    attitudes = Rotation.concatenate([singular_attitude(sequence, angle=0.0) for sequence in SEQUENCES])
    states = pt.Body((2.0, 2.5, 3.5)).state(attitudes, omega_body=(0.1, 0.2, 0.3))
    with pytest.raises(ValueError, match=r"there\. No sequence is regular at all these attitudes\.$"):
        states.euler("321")


def test_default_sequence_is_313():
    given = ((0.3, 0.8, 1.9), (1.0, -2.0, 0.5))
    assert np.array_equal(pt.State.from_euler(*given).quaternion, pt.State.from_euler(*given, "313").quaternion)
    state = pt.State.from_euler(*given)
    assert np.array_equal(state.euler()[0], state.euler("313")[0])


def test_batches_of_euler_variables():
    angles = np.array([[0.3, 0.8, 1.9], [0.5, 1.8, 0.2]])
    state = pt.State.from_euler(angles, (1.0, -2.0, 0.5))
    back, momenta = state.euler()
    assert np.allclose(back, angles, rtol=0, atol=1e-14)
    assert np.allclose(momenta, [[1.0, -2.0, 0.5]] * 2, rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- projection


def test_project_to_tangent_keeps_the_angular_momentum():
    q, Q = np.array(PRINTED[0]), np.array([0.3, -0.848528, 0.141421, -1.5])
    projected = pt.mechanics.project_to_tangent(q, Q)
    state = pt.State(q, projected)
    assert abs(q @ projected) < 1e-16
    conjugate = q * [1, -1, -1, -1]
    g = [
        0.5 * (conjugate[0] * Q[a] + conjugate[a] * Q[0] + conjugate[b] * Q[c] - conjugate[c] * Q[b])
        for a, b, c in ((1, 2, 3), (2, 3, 1), (3, 1, 2))
    ]
    assert np.allclose(state.angular_momentum_body, g, rtol=0, atol=1e-15)


def test_project_to_tangent_of_tangent_momenta_changes_nothing():
    assert pt.mechanics.project_to_tangent((1, 0, 0, 0), (0, 1, 2, 3)).tolist() == [0, 1, 2, 3]


def test_project_to_tangent_of_many(rng):
    q, Q = rng.normal(size=(5, 4)), rng.normal(size=(5, 4))
    assert np.max(np.abs(np.sum(q * pt.mechanics.project_to_tangent(q, Q), axis=-1))) < 1e-14


# ---------------------------------------------------------------------- slender bodies


@pytest.mark.parametrize("given", ["omega_body", "angular_momentum_body"])
@pytest.mark.parametrize("ratio", [1.0, 1e-3, 1e-6, 1e-9])
def test_a_state_keeps_what_it_was_made_of(ratio, given):
    """Q is a sum of all components of g: the one about the axis of a slender body would lose the ratio's digits."""
    body, asked = pt.Body((ratio, 1.0, 1.0)), np.array((1e-3, -2e-3, 3e-3))
    value = asked if given == "omega_body" else asked * body.moments
    state = body.state((0.6, 0, 0.8, 0), **{given: value})
    members = body.state(np.tile((0.6, 0, 0.8, 0), (3, 1)), **{given: value})
    for each in (state, members, copy.deepcopy(state), pickle.loads(pickle.dumps(state))):
        assert np.allclose(body.omega(each.angular_momentum_body), asked, rtol=4 * EPS, atol=0)
        assert np.allclose(pt.System(body).omega_body(each), asked, rtol=4 * EPS, atol=0)
    variables = FORMULATIONS["lie_poisson"].from_state(state)
    assert np.array_equal(variables[4:], state.angular_momentum_body)


def test_the_momenta_of_a_state_are_not_set():
    """One of the two would no longer be that of the other."""
    state = pt.Body((1e-6, 1.0, 1.0)).state((0.6, 0, 0.8, 0), omega_body=(1e-3, -2e-3, 3e-3))
    for name in ("conjugate_momenta", "angular_momentum_body"):
        with pytest.raises(AttributeError):
            setattr(state, name, 2 * getattr(state, name))


@pytest.mark.parametrize("members", [None, 3])
def test_a_slender_body_turns_at_the_rate_it_was_given(members):
    """A free symmetric body turns by G t / B about G in space, after (1 / A - 1 / B) g1 t about its own axis."""
    A, B, end = 1e-9, 1.0, 10.0
    body, omega, q = pt.Body((A, B, B)), np.array((0.7, 0.3, 0.1)), (0.6, 0, 0.8, 0)
    g = omega * body.moments
    attitude = Rotation.from_quat(q, scalar_first=True)
    own = Rotation.from_rotvec((1 / A - 1 / B) * g[0] * end * np.array((1, 0, 0)))
    expected = Rotation.from_rotvec(attitude.apply(g) * end / B) * attitude * own
    start = body.state(q if members is None else np.tile(q, (members, 1)), omega_body=omega)
    motion = pt.propagate(pt.System(body), start, [end])
    for each in motion.quaternion.reshape(-1, 4):
        assert (expected.inv() * Rotation.from_quat(each, scalar_first=True)).magnitude() < 1e-12


# ---------------------------------------------------------------------- variables of parts


def test_variables_of_parts_travel_with_their_names():
    state = pt.State((1, 0, 0, 0), (0, 1, 2, 3), own={"wheel": [0.5], "slosh": [[0.1, 0.2], [0.3, 0.4]]})
    assert state.quaternion.shape == (2, 4)
    np.testing.assert_array_equal(state.own["wheel"], [[0.5], [0.5]])
    np.testing.assert_array_equal(state.own["slosh"], [[0.1, 0.2], [0.3, 0.4]])
    assert pt.State((1, 0, 0, 0), (0, 1, 2, 3)).own == {}
    assert repr(pt.State((1, 0, 0, 0), (0, 1, 2, 3), own={"wheel": [0.5]})).endswith("wheel: 0.5")


@pytest.mark.parametrize(
    ("own", "sentence"),
    [
        ({"wheel": 0.5}, r"wheel must have shape \(k,\) or \(members, k\), got shape \(\)\."),
        ({"a": [[1.0], [2.0]], "b": [[1.0]] * 3}, "b must have as many members as a, got 3 and 2."),
        ({"wheel": [np.nan]}, r"wheel must be finite, got wheel\[0\] = nan\."),
    ],
)
def test_variables_of_parts_must_fit(own, sentence):
    with pytest.raises(ValueError, match=sentence):
        pt.State((1, 0, 0, 0), (0, 1, 2, 3), own=own)
