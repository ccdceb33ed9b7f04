"""Each event of two bodies means what its name says: its passages are those of the quantity itself."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds.pair_events import AXIS, EVENTS, TARGET
from poinsot.events import pair_events

PAIR = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5), G=1.0)
SYSTEM = pt.System(PAIR, pt.forces.MutualGravity())
START = PAIR.state(
    (6.0, 0.5, 0.3), (-0.1, 0.6, 0.05), [(1, 0, 0, 0)] * 2, omega_body=[(0.1, 0.2, 1.0), (0.01, 0.02, 0.12)]
)


def test_every_event_of_two_bodies_is_here():
    assert {name.partition(",")[0] for name in EVENTS} | {"Contact"} >= set(pair_events.__all__)


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_passages_are_those_of_the_quantity(sign):
    times = sign * np.linspace(0, 150.0, 15_001)
    motion: Any = pt.propagate(SYSTEM, START, times, events=[event for event, _ in EVENTS.values()])
    for (name, (_, quantity)), found in zip(EVENTS.items(), motion.events, strict=True):
        values = quantity(motion)
        crossed = np.nonzero(np.sign(values[1:]) != np.sign(values[:-1]))[0]
        assert len(found) == crossed.size > 2, name
        assert np.max(np.abs(found.times - 0.5 * (times[crossed] + times[crossed + 1]))) < 0.02, name
        assert np.array_equal(found.directions, sign * np.sign(values[1:] - values[:-1])[crossed]), name


@pytest.mark.parametrize("end", [80.0, -80.0], ids=["forwards", "backwards"])
def test_members_of_an_ensemble_have_the_events_that_they_have_alone(end):
    events = [event for event, _ in EVENTS.values()]
    shift = np.array([[0.0, 0, 0], [0.2, -0.1, 0]])
    attitudes, rates = [(1, 0, 0, 0)] * 2, [(0.1, 0.2, 1.0), (0.01, 0.02, 0.12)]
    velocity = np.array((-0.1, 0.6, 0.05))
    both = PAIR.state(START.position + shift, velocity, attitudes, omega_body=rates)
    together = pt.propagate(SYSTEM, both, [end], events=events).events
    for i in range(2):
        start = PAIR.state(START.position + shift[i], velocity, attitudes, omega_body=rates)
        alone = pt.propagate(SYSTEM, start, [end], events=events).events
        for found, own in zip(together, alone, strict=True):
            assert len(own) > 1
            assert np.allclose(found.member(i).times, own.times, rtol=0, atol=1e-11)
            assert np.array_equal(found.member(i).directions, own.directions)


def test_an_event_of_one_body_acts_on_it_alone():
    class Stop(pt.events.AtTime):
        def act(self, body, state):
            return body.state(state.quaternion, omega_body=(0, 0, 0), time=state.time)

    motion: Any = pt.propagate(SYSTEM, START, [2.0, 4.0], events=[Stop(3.0).on("secondary")])
    plain: Any = pt.propagate(SYSTEM, START, [2.0, 3.0])
    before = motion.events[0].states
    assert np.allclose(before.secondary.quaternion, plain.secondary.quaternion[1:], rtol=0, atol=1e-15)
    again = PAIR.state(
        plain.position[1],
        plain.velocity[1],
        [plain.primary.quaternion[1], plain.secondary.quaternion[1]],
        omega_body=[plain.primary.omega_body[1], (0, 0, 0)],
        time=3.0,
    )
    after: Any = pt.propagate(SYSTEM, again, [4.0])
    assert np.allclose(motion.position[1], after.position[0], rtol=0, atol=1e-14)
    assert np.allclose(motion.secondary.omega_body[1], after.secondary.omega_body[0], rtol=0, atol=1e-15)


# ---------------------------------------------------------------------- contact

SHAPES = pt.shapes.Ellipsoid((1.0, 0.8, 0.6), mass=3.0), pt.shapes.Ellipsoid((0.5, 0.3, 0.2), mass=0.5)
CLOSE = pt.TwoBodies(*map(pt.Body.from_shape, SHAPES), G=1.0)
FALL = pt.System(CLOSE, pt.forces.MutualGravity())
FALLING = CLOSE.state((3, 0.4, 0.2), (0, 0.2, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0.1, 0.5, 2.0), (0.3, 0.1, 0.7)])


def room(motion, i):
    """How far the surfaces are apart along the best direction, by sampled directions and a search around the best."""
    first, second = (
        Rotation.from_quat(each.quaternion[i], scalar_first=True) for each in (motion.primary, motion.secondary)
    )
    r, best, width = motion.position[i], motion.position[i] / motion.distance[i], 1.0
    rng = np.random.default_rng(1)
    for _ in range(30):
        u = best + width * rng.normal(size=(500, 3))
        u = np.concatenate([best[None], u / np.linalg.norm(u, axis=1)[:, None]])
        sizes = [
            np.linalg.norm(turn.inv().apply(u) * shape.semiaxes, axis=1)
            for turn, shape in zip((first, second), SHAPES, strict=True)
        ]
        gaps = u @ r - sizes[0] - sizes[1]
        best, width = u[np.argmax(gaps)], 0.5 * width
    return np.max(gaps)


def test_a_motion_ends_where_ellipsoids_touch():
    contact = pt.events.Contact.of_shapes(CLOSE)
    motion: Any = pt.propagate(FALL, FALLING, np.linspace(0, 10, 11), events=[contact])
    end = motion.events[0].times
    assert end.size == 1
    assert 1.0 < end[0] < 5.0
    assert motion.times[-1] <= end[0]
    free: Any = pt.propagate(FALL, FALLING, [*(end + np.array([-1e-3, 0.0, 1e-3]))])
    assert room(free, 0) > 1e-4
    assert abs(room(free, 1)) < 1e-12
    assert room(free, 2) < -1e-4
    assert f"ended: at t = {end[0]:.6g}, by Contact" in repr(motion)


def test_members_end_where_they_touch_alone():
    shifts = np.array([[0.0, 0, 0], [0.3, 0.1, 0.0], [9.0, 0, 0]])
    given = {"velocity": (0, 0.2, 0), "attitudes": [(1, 0, 0, 0)] * 2, "omega_body": [(0.1, 0.5, 2.0), (0.3, 0.1, 0.7)]}
    contact, times = pt.events.Contact.of_shapes(CLOSE), np.linspace(0, 5, 6)
    events = [contact, pt.events.AxisCrossing(AXIS, TARGET).on("secondary")]
    together: Any = pt.propagate(FALL, CLOSE.state(FALLING.position + shifts, **given), times, events=events)
    assert together.events[0].members.tolist() == [0, 1]
    assert "ended: 2 members, by Contact" in repr(together)
    assert "AxisCrossing of the secondary" in repr(together)
    for i, shift in enumerate(shifts):
        alone: Any = pt.propagate(FALL, CLOSE.state(FALLING.position + shift, **given), times, events=events)
        for found, own in zip(together.events, alone.events, strict=True):
            assert np.allclose(found.member(i).times, own.times, rtol=0, atol=1e-12)
        count = len(alone.times)
        assert np.allclose(together.position[i, :count], alone.position, rtol=0, atol=1e-12)
        assert np.all(np.isnan(together.position[i, count:]))


def test_other_shapes_touch_where_spheres_that_hold_them_do():
    bone = pt.shapes.Mascons((1.0, 1.0, 1.0), ((1, 0, 0), (-0.5, 0.75, 0), (-0.5, -0.75, 0)))
    pair = pt.TwoBodies(pt.Body.from_shape(bone), pt.Body.from_shape(SHAPES[1]), G=1.0)
    contact = pt.events.Contact.of_shapes(pair)
    assert np.allclose(contact.primary, 1.0, rtol=0, atol=1e-15)
    assert np.array_equal(contact.secondary, (0.5, 0.3, 0.2))
    turned = pt.shapes.Ellipsoid((0.5, 0.3, 0.2), mass=0.5).moved(attitude=Rotation.from_rotvec((0, 0, 0.3)))
    across = pt.TwoBodies(pt.Body.from_shape(bone), pt.Body.from_shape(turned), G=1.0)
    assert np.allclose(pt.events.Contact.of_shapes(across).secondary, 0.5, rtol=0, atol=1e-15)


@pytest.mark.parametrize("members", [(), (3,)])
def test_bodies_that_overlap_at_the_start_are_refused(members):
    place = np.broadcast_to((1.2, 0.0, 0.0), (*members, 3))
    given = {"velocity": (0, 0.2, 0), "attitudes": [(1, 0, 0, 0)] * 2, "omega_body": [(0, 0, 0)] * 2}
    sentence = "position must separate the bodies, got ellipsoids that overlap: they touch when both are 0.8 times"
    with pytest.raises(ValueError, match=sentence):
        CLOSE.state(place, **given)
    ball = pt.TwoBodies(pt.Body.from_ellipsoid(3.0, (1, 1, 1)), pt.Body.from_ellipsoid(3.0, (0.5, 0.5, 0.5)), G=1.0)
    with pytest.raises(ValueError, match=sentence):
        ball.state(place, **given)
    assert ball.state((1.5, 0, 0), **given).position[0] == 1.5  # they touch
    start = PAIR.state(place, **given)
    with pytest.raises(ValueError, match=sentence):
        pt.propagate(SYSTEM, start, [1.0], events=[pt.events.Contact((1.0, 0.8, 0.6), (0.5, 0.3, 0.2))])


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: pt.events.Contact.of_shapes(PAIR), "primary must be made of a shape"),
        (lambda: pt.events.Contact((1, 1, 1), (1, 0, 1)), "secondary must be positive"),
        (lambda: pt.events.LibrationExtreme(body="moon"), "body must be 'primary' or 'secondary', got 'moon'"),
        (lambda: pt.events.SpinFlip((1, 0, 0)).on("moon"), "body must be 'primary' or 'secondary', got 'moon'"),
        (
            lambda: pt.propagate(SYSTEM, START, [1.0], events=[pt.events.SpinFlip((1, 0, 0))]),
            "of SpinFlip must be for the bodies of its system, but an instant of two bodies has no angular_momentum",
        ),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()
