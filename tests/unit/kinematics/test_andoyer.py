"""Andoyer's variables: what they are, that they are canonical, and the way there and back."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt

EPS = np.finfo(float).eps
BODY = pt.Body((1.25, 1.0, 0.75))
FROM_POLE = [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-4, 0.3, np.pi / 2, 2.5, np.pi - 1e-4, np.pi - 1e-8, np.pi]
NAMES = ("l", "g", "h", "L", "G", "H")


def values(variables):
    return np.stack([getattr(variables, name) for name in NAMES], axis=-1)


def attitude(l, g, h, J, I):
    """The five turns, by scipy."""
    turns = (("z", h), ("x", I), ("z", g), ("x", J), ("z", l))
    return Rotation.concatenate([Rotation.from_euler(axis, angle) for axis, angle in turns])


def composed(turns):
    total = turns[0]
    for turn in turns[1:]:
        total = total * turn
    return total


def apart(angles, others):
    return np.max(np.abs(np.exp(1j * np.asarray(angles)) - np.exp(1j * np.asarray(others))))


def states(rng, count):
    q, g = rng.normal(size=(count, 4)), rng.normal(size=(count, 3))
    return BODY.state(q / np.linalg.norm(q, axis=-1, keepdims=True), angular_momentum_body=g)


def difference(function, place, step):
    """The derivatives of a function of six numbers, by differences of the sixth order; shape (6, ...)."""
    weights = np.array([-1, 9, -45, 45, -9, 1]) / (60 * step)
    ahead = np.array([-3, -2, -1, 1, 2, 3]) * step
    return np.array(
        [sum(w * function(place + a * unit) for w, a in zip(weights, ahead, strict=True)) for unit in np.eye(6)]
    )


def state_of(numbers):
    return pt.Andoyer(*numbers).state()


# ---------------------------------------------------------------------- what they are


def test_state_has_the_five_turns_and_the_momentum_along_the_middle(rng):
    for l, g, h, J, I in np.column_stack([rng.uniform(-np.pi, np.pi, (20, 3)), rng.uniform(0.1, 3, (20, 2))]):
        G = rng.uniform(0.5, 2)
        state = pt.Andoyer(l, g, h, G * np.cos(J), G, G * np.cos(I)).state(time=3.0)
        assert (composed(attitude(l, g, h, J, I)).inv() * state.attitude).magnitude() < 16 * EPS
        across = composed(attitude(0, 0, h, 0, I)).apply([0, 0, G])
        assert np.max(np.abs(state.angular_momentum_space - across)) < 20 * EPS
        body = G * np.array([np.sin(J) * np.sin(l), np.sin(J) * np.cos(l), np.cos(J)])
        assert np.max(np.abs(state.angular_momentum_body - body)) < 20 * EPS
        assert state.time == 3.0


def test_variables_of_a_state_are_read_off_its_momentum(rng):
    for n in range(20):
        state = states(rng, 20)
        body, space = state.angular_momentum_body[n], state.angular_momentum_space[n]
        one = pt.Andoyer.from_state(pt.State(state.quaternion[n], state.conjugate_momenta[n]))
        assert np.max(np.abs(values(one)[3:] - [body[2], np.linalg.norm(body), space[2]])) < 4 * EPS
        # The line of nodes of a plane is its normal turned by a right angle: (-y, x) for a normal (x, y, z).
        nodes = np.array([-space[1], space[0], 0])
        assert apart(one.h, np.arctan2(nodes[1], nodes[0])) < 4 * EPS
        assert apart(one.l, np.pi / 2 - np.arctan2(body[1], body[0])) < 8 * EPS
        assert all(-np.pi <= angle <= np.pi for angle in (one.l, one.g, one.h))


def test_g_is_the_angle_between_the_two_lines_of_nodes(rng):
    state = states(rng, 20)
    variables, G = pt.Andoyer.from_state(state), state.angular_momentum_space
    third = state.attitude.as_matrix()[..., 2]
    in_space, in_body = np.cross([0, 0, 1], G), np.cross(G, third)
    angle = np.arctan2(
        np.sum(np.cross(in_space, in_body) * G, axis=-1) / np.linalg.norm(G, axis=-1),
        np.sum(in_space * in_body, axis=-1),
    )
    assert apart(variables.g, angle) < 2e-15


# ---------------------------------------------------------------------- there and back


def loss(angle):
    """Roundings of the sine of an angle that is stored as its cosine."""
    return 1 / max(abs(np.sin(angle)), np.sqrt(EPS))


@pytest.mark.parametrize("J", FROM_POLE)
@pytest.mark.parametrize("I", FROM_POLE)
def test_state_to_variables_and_back(rng, J, I):
    l, g, h = rng.uniform(-np.pi, np.pi, 3)
    momentum = 1.7 * np.array([np.sin(J) * np.sin(l), np.sin(J) * np.cos(l), np.cos(J)])
    state = BODY.state(composed(attitude(l, g, h, J, I)), angular_momentum_body=momentum)
    back = pt.Andoyer.from_state(state).state()
    allowed = 4 * EPS * (2 + loss(J) + loss(I))
    assert (state.attitude.inv() * back.attitude).magnitude() < allowed
    assert np.max(np.abs(back.angular_momentum_body - state.angular_momentum_body)) < allowed
    assert np.max(np.abs(back.angular_momentum_space - state.angular_momentum_space)) < allowed


def test_random_states_to_variables_and_back(rng):
    state = states(rng, 1000)
    variables = pt.Andoyer.from_state(state)
    back = variables.state()
    sines = [np.sqrt(1 - (x / variables.G) ** 2) for x in (variables.L, variables.H)]
    allowed = 4 * EPS * (2 + 1 / sines[0] + 1 / sines[1])
    assert np.all((state.attitude.inv() * back.attitude).magnitude() < allowed)
    off = np.linalg.norm(back.angular_momentum_body - state.angular_momentum_body, axis=-1)
    assert np.all(off < allowed * variables.G)


@pytest.mark.parametrize("J", [1e-3, 0.3, np.pi / 2, 2.5, np.pi - 1e-3])
@pytest.mark.parametrize("I", [1e-3, 0.3, np.pi / 2, 2.5, np.pi - 1e-3])
def test_variables_to_state_and_back(rng, J, I):
    for l, g, h in rng.uniform(-np.pi, np.pi, (10, 3)):
        variables = pt.Andoyer(l, g, h, 1.7 * np.cos(J), 1.7, 1.7 * np.cos(I))
        back = pt.Andoyer.from_state(variables.state())
        allowed = 4 * EPS * (2 + loss(J) + loss(I))
        assert apart([back.l, back.g, back.h], [l, g, h]) < allowed
        # Of 1.7; the worst of 50,000 is 8 EPS, and 5 EPS of those here.
        assert np.max(np.abs(values(back)[3:] - values(variables)[3:])) < 16 * EPS


IDENTITY, HALF_TURN, ABOUT_THIRD = (1, 0, 0, 0), (0, 1, 0, 0), (0.6, 0, 0, 0.8)
TURN = 2 * np.arctan2(0.8, 0.6)


@pytest.mark.parametrize(
    ("q", "up", "g", "L", "H"),
    [
        (IDENTITY, 1, 0, 1, 1),
        (IDENTITY, -1, 0, -1, -1),
        (HALF_TURN, 1, 0, 1, -1),
        (HALF_TURN, -1, 0, -1, 1),
        (ABOUT_THIRD, 1, TURN, 1, 1),
        (ABOUT_THIRD, -1, -TURN, -1, -1),
    ],
)
def test_outer_angles_are_zero_where_only_a_sum_is_determined(q, up, g, L, H):
    state = BODY.state(q, angular_momentum_body=(0, 0, up))
    variables = pt.Andoyer.from_state(state)
    assert (variables.l, variables.h) == (0, 0)
    assert apart(variables.g, g) < 4 * EPS
    assert np.max(np.abs(values(variables)[3:] - [L, 1, H])) < 4 * EPS
    assert (variables.state().attitude.inv() * state.attitude).magnitude() < 8 * EPS


def test_members_are_as_one_by_one(rng):
    many = states(rng, 10)
    variables = pt.Andoyer.from_state(many)
    back = variables.state(time=np.arange(10.0))
    assert back.time.tolist() == list(range(10))
    for n in range(10):
        one = pt.Andoyer.from_state(pt.State(many.quaternion[n], many.conjugate_momenta[n]))
        assert np.max(np.abs(values(one) - values(variables)[n])) < 4 * EPS
        assert np.max(np.abs(one.state().quaternion - back.quaternion[n])) < 4 * EPS


def test_one_number_goes_with_members():
    state = pt.Andoyer([0.1, 0.2, 0.3], 0.4, 0.5, 0.6, [1.0, 2.0, 3.0], 0.7).state()
    alone = pt.Andoyer(0.3, 0.4, 0.5, 0.6, 3.0, 0.7).state()
    assert np.max(np.abs(state.quaternion[2] - alone.quaternion)) < 4 * EPS
    assert np.max(np.abs(state.conjugate_momenta[2] - alone.conjugate_momenta)) < 16 * EPS


# ---------------------------------------------------------------------- canonical


def places(rng, count):
    angles, G = rng.uniform(-np.pi, np.pi, (count, 3)), rng.uniform(0.5, 2, count)
    return np.column_stack([angles, G * rng.uniform(-0.8, 0.8, count), G, G * rng.uniform(-0.8, 0.8, count)])


def test_momenta_times_changes_are_those_of_the_quaternion(rng):
    """Q . dq = L dl + G dg + H dh, along any change of the six."""
    for place in places(rng, 20):
        _, _, _, L, G, H = place
        change = difference(lambda x: state_of(x).quaternion, place, 3e-3)
        assert np.max(np.abs(change @ state_of(place).conjugate_momenta - [L, G, H, 0, 0, 0])) < 2e-11


def test_momenta_along_the_body_axes_have_the_brackets_of_a_rigid_body(rng):
    """{g1, g2} = -g3 and cyclic: the sum of (da/dx)(db/dX) - (da/dX)(db/dx) over the three pairs."""
    for place in places(rng, 20):
        change = difference(lambda x: state_of(x).angular_momentum_body, place, 3e-3)
        brackets = change[:3].T @ change[3:] - change[3:].T @ change[:3]
        g1, g2, g3 = state_of(place).angular_momentum_body
        assert np.max(np.abs(brackets - [(0, -g3, g2), (g3, 0, -g1), (-g2, g1, 0)])) < 1e-10


def hamiltonian_rates(variables, moments):
    """The six rates of H = (G^2 - L^2)/2 (sin^2 l/I1 + cos^2 l/I2) + L^2/(2 I3)."""
    (l, _, _, L, G, _), (I1, I2, I3) = np.moveaxis(values(variables), -1, 0), moments
    across = np.sin(l) ** 2 / I1 + np.cos(l) ** 2 / I2
    slope = (G**2 - L**2) * np.sin(l) * np.cos(l) * (1 / I1 - 1 / I2)
    zero = 0 * l
    return np.stack([L * (1 / I3 - across), G * across, zero, -slope, zero, zero], axis=-1)


@pytest.mark.parametrize("moments", [(1.25, 1.0, 0.75), (0.75, 1.25, 1.0), (1.0, 0.75, 1.25), (1.0, 1.0, 0.4)])
def test_free_motion_obeys_hamiltons_equations(rng, moments):
    body, step = pt.Body(moments), 0.02
    q, g = rng.normal(size=4), rng.normal(size=3)
    start = body.state(q / np.linalg.norm(q), angular_momentum_body=g)
    motion = pt.propagate(pt.System(body), start, [0, 20], dense=True)
    middle = np.linspace(0.1, 19.9, 50)
    neighbours = values(
        pt.Andoyer.from_state(motion((middle + step * np.array([[-3], [-2], [-1], [1], [2], [3]])).ravel()))
    )
    neighbours = neighbours.reshape(6, 50, 6)
    neighbours[..., :3] = np.unwrap(neighbours[..., :3], axis=0)
    rates = np.einsum("k,kni->ni", np.array([-1, 9, -45, 45, -9, 1]) / (60 * step), neighbours)
    variables = pt.Andoyer.from_state(motion(middle))
    assert np.max(np.abs(rates - hamiltonian_rates(variables, moments))) < 1e-9
    # Conserved variables are conserved to rounding.
    conserved = values(variables)[:, [2, 4, 5]]
    assert np.max(np.abs(conserved - values(pt.Andoyer.from_state(start))[[2, 4, 5]])) < 2e-14


# ---------------------------------------------------------------------- bad input

BAD = {
    "nan": (lambda: pt.Andoyer(0, np.nan, 0, 0, 1, 0), ValueError, "g must be finite, got g = nan."),
    "word": (lambda: pt.Andoyer("x", 0, 0, 0, 1, 0), TypeError, "l must be real numbers, got str 'x'."),
    "shape": (
        lambda: pt.Andoyer(0, 0, 0, 0, [[1]], 0),
        ValueError,
        "G must have shape () or (members,), got shape (1, 1).",
    ),
    "no_momentum": (
        lambda: pt.Andoyer(0, 0, 0, 0, [1, 0], 0),
        ValueError,
        "G must be positive, got 0.0. A body at rest has no such variables.",
    ),
    "negative": (
        lambda: pt.Andoyer(0, 0, 0, 0, -1.5, 0),
        ValueError,
        "G must be positive, got -1.5. A body at rest has no such variables.",
    ),
    "kind": (lambda: pt.Andoyer.from_state((1, 0, 0, 0)), TypeError, "state must be a State, got tuple."),
    "rest": (
        lambda: pt.Andoyer.from_state(pt.State((1, 0, 0, 0), (0, 0, 0, 0))),
        ValueError,
        "G must be positive, got 0.0. A body at rest has no such variables.",
    ),
    "L": (
        lambda: pt.Andoyer(0, 0, 0, -3, 2, 0),
        ValueError,
        "L must lie between -G and G, got |L| = 1.5 G.",
    ),
    "H_of_a_member": (
        lambda: pt.Andoyer(0, 0, 0, 0, [2, 1], [1.5, 1.5]),
        ValueError,
        "H must lie between -G and G, got |H| = 1.5 G.",
    ),
    "barely_too_large": (
        lambda: pt.Andoyer(0, 0, 0, 1 + 1e-11, 1, 0),
        ValueError,
        "L must lie between -G and G, got |L| = 1.00000000001 G.",
    ),
    "members": (
        lambda: pt.Andoyer([0, 1], 0, [1, 2, 3], 0, 1, 0),
        ValueError,
        "h must have as many members as l, got 3 and 2.",
    ),
    "members_of_momenta": (
        lambda: pt.Andoyer(0, 0, 0, [0, 0.1], [1, 2, 3], 0),
        ValueError,
        "G must have as many members as L, got 3 and 2.",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_wrong_variables_get_a_sentence(name):
    call, kind, sentence = BAD[name]
    with pytest.raises(kind, match=f"^{re.escape(sentence)}$"):
        call()


def test_rounding_beyond_G_is_accepted():
    state = pt.Andoyer(0.2, 0.3, 0.4, 1 + 1e-15, 1, -1 - 1e-15).state()
    assert (state.attitude.inv() * composed(attitude(0.2, 0.3, 0.4, 0, np.pi))).magnitude() < 8 * EPS
