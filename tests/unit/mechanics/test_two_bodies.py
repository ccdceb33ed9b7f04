"""Starts of two bodies and impacts on them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.mechanics.two_bodies import circular_orbit, mean_motion

CASES = Path(__file__).parents[2] / "oracles" / "pair_cases.json"
CASE = next(c for c in json.loads(CASES.read_text())["cases"] if c["name"] == "doubly_synchronous")
EQUAL = pt.TwoBodies(*(pt.Body.from_inertia(CASE[f"inertia{i}"], CASE[f"mass{i}"]) for i in (1, 2)), G=CASE["G"])
LONG, FLAT = pt.Body.from_ellipsoid(0.02, (0.3, 0.25, 0.2)), pt.Body.from_ellipsoid(1.0, (1.0, 1.0, 0.8))
PAIR = pt.TwoBodies(FLAT, LONG, G=1.0)
BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
BALLS = pt.TwoBodies(BALL, pt.Body((0.1, 0.1, 0.1), mass=0.5), G=1.3)
ASYMMETRIC = pt.TwoBodies(pt.Body((0.3, 0.5, 0.6), mass=3.0), pt.Body((0.01, 0.02, 0.025), mass=0.5), G=1.3)
GRAVITY = pt.forces.MutualGravity()
AT_REST = [(0.0, 0.0, 0.0)] * 2
SAME = [(1.0, 0.0, 0.0, 0.0)] * 2


def rate_of(start, body):
    return float(start.secondary.angular_momentum_body[2] / body.moments[2])


def test_the_doubly_synchronous_rate_is_that_of_another_program():
    start = EQUAL.doubly_synchronous(distance=2500.0)
    exact = np.array(CASE["omega2"])
    assert np.array_equal(start.position, CASE["position"])
    assert np.allclose(start.momentum / EQUAL.reduced_mass, CASE["velocity"], rtol=4e-16, atol=0)
    for i, state in ((1, start.primary), (2, start.secondary)):
        assert np.array_equal(state.quaternion, CASE[f"attitude{i}"])
        assert np.allclose(state.angular_momentum_space, np.array(CASE[f"inertia{i}"]) @ exact, rtol=1e-15, atol=0)


@pytest.mark.parametrize("distance", [1.4, 4.0, 1e5])
def test_a_start_is_the_same_from_distance_period_or_rate(distance):
    start = PAIR.doubly_synchronous(distance=distance)
    w = rate_of(start, LONG)
    for given in ({"rate": w}, {"period": 2 * np.pi / w}):
        again = PAIR.doubly_synchronous(**given)
        assert np.allclose(again.position, start.position, rtol=1e-15 * 4, atol=0)
    one = PAIR.synchronous(distance=distance, primary_rate=3.0)
    other = PAIR.synchronous(period=2 * np.pi / rate_of(one, LONG), primary_rate=3.0)
    assert np.allclose(other.position, one.position, rtol=1e-15 * 4, atol=0)
    assert one.primary.angular_momentum_body[2] == 3.0 * FLAT.moments[2]


def test_distances_are_found_where_the_shapes_matter_more_than_the_masses():
    """So near that their ellipsoids overlap: bodies of moments alone."""
    bodies = [pt.Body(body.moments, mass=mass) for body, mass in zip(PAIR.bodies.values(), PAIR.masses, strict=True)]
    pair = pt.TwoBodies(*bodies, G=PAIR.G)
    start = pair.doubly_synchronous(rate=1e3)
    again = pair.doubly_synchronous(distance=float(start.position[0]))
    assert abs(rate_of(again, LONG) / 1e3 - 1) < 1e-14


TURNED = pt.Body.from_inertia(np.array([[1.6, 0.3, 0.1], [0.3, 1.2, -0.2], [0.1, -0.2, 1.4]]), mass=2.0)


@pytest.mark.parametrize(
    ("start", "pair"),
    [
        (PAIR.synchronous(distance=4.0, primary_rate=2.7), PAIR),
        (EQUAL.doubly_synchronous(distance=2500.0), EQUAL),
        *(
            (pair.doubly_synchronous(distance=5.0), pair)
            for pair in [pt.TwoBodies(TURNED, pt.Body((2.5, 1.5, 1.2), mass=1.5), G=1.0)]
        ),
    ],
    ids=["synchronous", "doubly synchronous", "other axes"],
)
def test_the_bodies_stay_at_rest_relative_to_their_orbit(start, pair):
    rate = np.linalg.norm(np.cross(start.position, start.momentum)) / (pair.reduced_mass * start.position[0] ** 2)
    motion: Any = pt.propagate(pt.System(pair, GRAVITY), start, np.linspace(0, 6, 7) / rate)
    assert np.ptp(motion.distance) < 1e-13 * start.position[0]
    for i, t in enumerate(motion.times):
        turn = np.array([np.cos(rate * t / 2), 0, 0, np.sin(rate * t / 2)])
        along = pt.State(turn, (0,) * 4).attitude * start.secondary.attitude
        assert (along.inv() * motion.secondary.attitude[i]).magnitude() < 1e-12


def test_frame_orbit_is_radial_transverse_and_normal():
    position, velocity = np.array([2.0, -1.0, 2.0]), np.array([0.1, 0.5, 0.3])
    turn, rate = np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.1, -0.2, 0.4])
    start = PAIR.state(position, velocity, [turn] * 2, omega_space=[rate] * 2, frame="orbit")
    normal = np.cross(position, velocity)
    axes = np.stack([position / 3, np.cross(normal, position) / np.linalg.norm(normal) / 3, normal], axis=1)
    axes[:, 2] /= np.linalg.norm(normal)
    matrix = start.secondary.attitude.as_matrix()
    assert np.allclose(matrix, axes @ pt.State(turn, (0,) * 4).attitude.as_matrix(), rtol=0, atol=1e-15)
    omega = start.secondary.angular_momentum_body / LONG.moments
    assert np.allclose(matrix @ omega, axes @ rate + normal / 9, rtol=0, atol=1e-15)


def test_starts_of_ensembles_are_those_of_their_members():
    distances, moments = np.array([3.0, 4.0, 5.0]), np.array([[0.1, 0.12, 0.15], [0.15, 0.1, 0.12], [0.1, 0.1, 0.1]])
    whole = pt.TwoBodies(FLAT, pt.Body(moments, mass=[0.1, 0.2, 0.3]), G=1.0)
    starts = whole.synchronous(distance=distances, primary_rate=2.0)
    for i in range(3):
        one = pt.TwoBodies(FLAT, pt.Body(moments[i], mass=0.1 * (i + 1)), G=1.0)
        start = one.synchronous(distance=distances[i], primary_rate=2.0)
        for name, values in start.phase.items():
            assert np.allclose(starts.phase[name][i], values, rtol=1e-15, atol=1e-16)


# ---------------------------------------------------------------------- elements and impacts


def kepler(pair, state):
    return pt.KeplerOrbit.from_vectors(pair.mu, position=state.position, velocity=state.momentum / pair.reduced_mass)


def test_a_start_on_an_orbit_moves_along_it():
    orbit = pt.KeplerOrbit(BALLS.mu, semimajor_axis=5.0, eccentricity=0.4, inclination=0.3, node=0.5, true_anomaly=2.0)
    start = BALLS.state_on(orbit, SAME, omega_body=AT_REST, frame=orbit.frame, time=3.0)
    motion: Any = pt.propagate(pt.System(BALLS, GRAVITY), start, [3.0, 20.0])
    for i, t in enumerate(motion.times):
        assert np.allclose(motion.position[i], list(orbit.position_at(t)), rtol=0, atol=2e-13)
        assert np.allclose(motion.velocity[i], list(orbit.velocity_at(t)), rtol=0, atol=1e-13)
    assert np.allclose(start.secondary.quaternion, orbit.frame.quaternion(3.0), rtol=0, atol=1e-15)


def test_an_impact_changes_the_orbit_and_no_rotation():
    start = BALLS.state((4, 0, 0), (0, 0.7, 0.1), SAME, omega_body=[(0.1, 0.2, 0.3)] * 2)
    change = np.array([0.01, -0.02, 0.03])
    pushed, counter = BALLS.kick(start, change), BALLS.kick(start, -change, body="primary")
    assert np.array_equal(pushed.momentum, counter.momentum)
    assert np.allclose(pushed.momentum, 1 / 3 * (np.array([0, 0.7, 0.1]) + change), rtol=1e-15, atol=0)
    assert np.array_equal(pushed.secondary.angular_momentum_body, start.secondary.angular_momentum_body)
    along = BALLS.kick(start, (0, 0.02, 0), frame="orbit")
    factor = 1 + 0.02 / np.hypot(0.7, 0.1)
    assert np.allclose(along.momentum, factor * start.momentum, rtol=0, atol=1e-15)


@pytest.mark.parametrize("on", ["secondary", "primary"])
def test_an_impact_on_the_way_is_a_kick_between_two_runs(on):
    start, system = PAIR.synchronous(distance=4.0, primary_rate=2.0), pt.System(PAIR, GRAVITY)
    change = np.array([0.002, -0.01, 0.003])
    events = [pt.events.Impact(3.0, change, body=on, axes="orbit")]
    motion: Any = pt.propagate(system, start, [3.0, 10.0], events=events)
    before: Any = pt.propagate(system, start, [3.0])
    kicked = PAIR.kick(before[0], change, body=on, frame="orbit")
    after: Any = pt.propagate(system, kicked, [10.0])
    assert motion.events[0].times.tolist() == [3.0]
    for name, values in after.phase.items():
        assert np.allclose(motion.phase[name][-1], values[-1], rtol=0, atol=1e-13), name


def test_members_are_hit_by_their_own_impacts():
    changes = np.array([[0.0, 0.01, 0.0], [0.0, -0.01, 0.01], [0.0, 0.0, 0.0]])
    start, system = BALLS.state((4, 0, 0), (0, 0.7, 0.1), SAME, omega_body=AT_REST), pt.System(BALLS, GRAVITY)
    motions: Any = pt.propagate(system, start, [0.0, 9.0], events=[pt.events.Impact(2.0, changes)])
    before = kepler(BALLS, start)
    at, speed = np.array(list(before.position_at(2.0))), np.array(list(before.velocity_at(2.0)))
    for i, change in enumerate(changes):
        orbit = pt.KeplerOrbit.from_vectors(BALLS.mu, position=at, velocity=speed + change, epoch=2.0)
        assert np.allclose(motions.position[i, -1], list(orbit.position_at(9.0)), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: PAIR.synchronous(primary_rate=1.0), r"exactly one of distance, period, got none"),
        (
            lambda: PAIR.synchronous(primary_rate=1.0, distance=1.0, period=2.0),
            r"exactly one of distance, period, got distance and period",
        ),
        (lambda: PAIR.doubly_synchronous(distance=0.0), r"distance must be positive, got 0"),
        (lambda: PAIR.doubly_synchronous(rate=-1.0), r"rate must be positive, got -1"),
        (lambda: PAIR.doubly_synchronous(), r"exactly one of distance, period, rate, got none"),
        (lambda: PAIR.state((2, 0, 0), (1, 0, 0), SAME, omega_body=AT_REST, frame="orbit"), r"must span a plane"),
        (lambda: PAIR.state((2, 0, 0), (0, 1, 0), SAME, omega_body=AT_REST, frame="body"), r'a Frame or "orbit", got'),
        (
            lambda: PAIR.state_on(pt.KeplerOrbit(1.0, semimajor_axis=5.0, eccentricity=0.0), SAME, omega_body=AT_REST),
            r"orbit must have mu = G \(m1 \+ m2\) = 1.02, got 1\. Write KeplerOrbit\(pair\.mu",
        ),
        (
            lambda: BALLS.kick(BALLS.doubly_synchronous(distance=4.0), (0, 1, 0), body="moon"),
            r"body must be 'primary' or",
        ),
        (lambda: pt.events.Impact(1.0, (0, 1, 0), body="moon"), r"body must be 'primary' or 'secondary', got 'moon'"),
        (lambda: pt.events.Impact(1.0, (0, 1, 0), axes="body"), r"axes must be 'space' or 'orbit', got 'body'"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


ONES = (1, 1, 1)
MANY = pt.TwoBodies(FLAT, LONG, G=1.0, masses=[(1.0, 0.02)] * 4)
THREE = np.tile((4.0, 0.0, 0.0), (3, 1))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda: PAIR.state(THREE, THREE[:2], SAME, omega_body=AT_REST, frame="orbit"),
            "velocity .* position, got 2",
        ),
        (lambda: MANY.state(THREE, (0, 1, 0), SAME, omega_body=AT_REST), "masses .* position, got 4 and 3"),
        (lambda: MANY.synchronous(distance=[3.0, 4.0], primary_rate=0.1), "pair .* distance, got 4 and 2"),
        (lambda: PAIR.synchronous(period=[9.0, 9.5], primary_rate=[0.1] * 3), "primary_rate .* orbit, got 3 and 2"),
        (lambda: PAIR.kick(STATES, np.ones((4, 3))), "delta_velocity .* state, got 4 and 3"),
        (lambda: MANY.kick(STATES, (0, 1, 0)), "masses .* state, got 4 and 3"),
        (lambda: pt.TwoBodies(FLAT, LONG, G=[1.0, 1.1], masses=[(1.0, 0.02)] * 4), "masses .* G, got 4 and 2"),
        (
            lambda: pt.TwoBodies(pt.Body((1, 1, 1), mass=[1, 2]), pt.Body((1, 1, 1), mass=[1, 2, 3])),
            "mass of the sec.* 3 ",
        ),
    ],
)
def test_other_numbers_of_members_are_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence.replace(" .* ", " must have as many members as ")):
        make()


STATES: Any = PAIR.state(THREE, (0, 0.5, 0), SAME, omega_body=AT_REST)


def energy(system, state, _):
    return system.energy(state)


@pytest.mark.parametrize("run", [pt.propagate, pt.analysis.state_transition, energy])
def test_the_state_is_of_as_many_bodies_as_the_system(run):
    one, two = BALL.state(SAME[0], omega_body=AT_REST[0]), BALLS.doubly_synchronous(distance=4.0)
    with pytest.raises(ValueError, match="state must be of two bodies, as its system is, got one body"):
        run(pt.System(BALLS, GRAVITY), one, [1.0])
    with pytest.raises(ValueError, match="state must be of one body, as its system is, got two bodies"):
        run(pt.System(BALL), two, [1.0])


def test_forces_on_two_bodies_need_a_state_of_two_bodies():
    one = BALL.state(SAME[0], omega_body=AT_REST[0])
    with pytest.raises(ValueError, match="state must be of two bodies, as its system is, got one body"):
        pt.System(BALLS, GRAVITY).force_space(one, body="primary")


class Silent(pt.events.AtTime):
    def act(self, body, state):  # noqa: ARG002
        return state.secondary


def test_an_action_on_two_bodies_returns_both():
    system, start = pt.System(BALLS, GRAVITY), BALLS.doubly_synchronous(distance=4.0)
    with pytest.raises(pt.PropagationError, match="an action must return a PairState, got State"):
        pt.propagate(system, start, [2.0], events=[Silent(1.0)])


@pytest.mark.parametrize("distance", [1.2, 3.0, 1e3])
@pytest.mark.parametrize("primary_turns", [False, True])
def test_distance_of_the_rate_of_a_distance(distance, primary_turns):
    r, rate = circular_orbit(ASYMMETRIC, "orbit", {"distance": distance, "period": None, "rate": None}, primary_turns)
    assert r == distance
    for name, value in (("rate", rate), ("period", 2 * np.pi / rate)):
        given = {"distance": None, "period": None, "rate": None, name: value}
        found, again = circular_orbit(ASYMMETRIC, "orbit", given, primary_turns)
        np.testing.assert_allclose(found, distance, rtol=1e-15)
        np.testing.assert_allclose(again, rate, rtol=1e-15)


def test_rate_has_the_quadrupole_of_both_bodies():
    """w^2 = G M / r^3 + 3 G M / (2 r^5) (s1 / m1 + s2 / m2), s = tr I - 3 A, written out for the numbers."""
    _, rate = circular_orbit(ASYMMETRIC, "orbit", {"distance": 2.0}, False)
    spread = (1.4 - 3 * 0.3) / 3.0 + (0.055 - 3 * 0.01) / 0.5
    np.testing.assert_allclose(rate**2, 1.3 * 3.5 / 8 + 1.5 * 1.3 * 3.5 / 32 * spread, rtol=1e-15)
    np.testing.assert_allclose(mean_motion(ASYMMETRIC, 2.0) ** 2, 1.3 * 3.5 / 8, rtol=1e-15)
