"""Laws of the rotation group, and round trips of every conversion at and next to its bad angles."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import quaternion_from_matrix, rotation_angle, rotation_matrix, unit_quaternion

EPS = np.finfo(float).eps
SEQUENCES = ["".join(s) for s in itertools.product("123", repeat=3) if s[0] != s[1] and s[1] != s[2]]

lawful = settings(derandomize=True, deadline=None, max_examples=60)
lawful_in_each_sequence = settings(lawful, max_examples=20)  # of twelve

small = st.sampled_from([0.0, *(s * 10.0**-k for k in (1, 3, 5, 8, 12, 15, 16, 17, 300) for s in (1, -1))])
component = st.floats(-1, 1, allow_subnormal=False)


def unit(values):
    return np.array(values) / np.linalg.norm(values)


anywhere = st.tuples(*[component] * 4).filter(lambda q: np.linalg.norm(q) > 0.1).map(unit)
corners = st.sampled_from([s * c for s in (1.0, -1.0) for c in np.eye(4)])
edges = st.sampled_from([unit(q) for q in itertools.product((-1, 0, 1), repeat=4) if any(q)])
nearly = st.builds(lambda q, d: unit(q + np.array(d)), corners | edges, st.tuples(*[small] * 4))
quaternions = anywhere | edges | nearly
usual = st.floats(-10, 10).map(lambda x: x if abs(x) > 1e-100 else 0.0)  # whose squares do not underflow
general = st.tuples(*[usual] * 4).map(np.array)
vectors = st.tuples(*[usual] * 3).map(np.array)


def norm(x):
    return float(np.linalg.norm(x))


# ---------------------------------------------------------------------- the group


@lawful
@given(general, general, general)
def test_product_is_associative(p, q, r):
    difference = quat.product(quat.product(p, q), r) - quat.product(p, quat.product(q, r))
    assert norm(difference) <= 16 * EPS * norm(p) * norm(q) * norm(r)


@lawful
@given(general, general)
def test_norm_is_multiplicative(p, q):
    assert quat.norm(quat.product(p, q)) == pytest.approx(norm(p) * norm(q), rel=8 * EPS, abs=1e-300)


@lawful
@given(general, general)
def test_conjugation_turns_products_around(p, q):
    turned = quat.product(quat.conjugate(q), quat.conjugate(p))
    assert norm(quat.conjugate(quat.product(p, q)) - turned) <= 8 * EPS * norm(p) * norm(q)


@lawful
@given(quaternions)
def test_conjugate_is_the_inverse(q):
    for product in (quat.product(q, quat.conjugate(q)), quat.product(quat.conjugate(q), q)):
        assert np.allclose(product, [1, 0, 0, 0], rtol=0, atol=4 * EPS)


@lawful
@given(quaternions, quaternions, vectors)
def test_rotating_is_a_homomorphism(p, q, x):
    difference = quat.rotate(quat.product(p, q), x) - quat.rotate(p, quat.rotate(q, x))
    assert norm(difference) <= 32 * EPS * norm(x)


@lawful
@given(quaternions, vectors, vectors)
def test_rotating_keeps_lengths_angles_and_orientation(q, x, y):
    turned_x, turned_y = quat.rotate(q, x), quat.rotate(q, y)
    assert abs(turned_x @ turned_y - x @ y) <= 32 * EPS * norm(x) * norm(y)
    assert norm(np.cross(turned_x, turned_y) - quat.rotate(q, np.cross(x, y))) <= 64 * EPS * norm(x) * norm(y)


@lawful
@given(quaternions, vectors)
def test_the_matrix_does_what_the_quaternion_does(q, x):
    assert norm(rotation_matrix(q) @ x - quat.rotate(q, x)) <= 16 * EPS * norm(x)


@lawful
@given(quaternions, quaternions)
def test_the_matrix_is_a_homomorphism(p, q):
    product = rotation_matrix(p) @ rotation_matrix(q)
    assert np.allclose(rotation_matrix(quat.product(p, q)), product, rtol=0, atol=16 * EPS)


@lawful
@given(quaternions, quaternions)
def test_rotation_angle_is_that_of_scipy_and_symmetric(p, q):
    turns = [Rotation.from_quat(x, scalar_first=True) for x in (p, q)]
    assert rotation_angle(p, q) == pytest.approx((turns[0].inv() * turns[1]).magnitude(), abs=16 * EPS)
    assert rotation_angle(p, q) == pytest.approx(rotation_angle(q, p), abs=8 * EPS)
    assert rotation_angle(p, -p) <= 8 * EPS


# ---------------------------------------------------------------------- matrices and scipy


@lawful
@given(quaternions)
def test_quaternion_to_matrix_and_back(q):
    back = quaternion_from_matrix(rotation_matrix(q))
    assert np.allclose(back, np.sign(back @ q) * q, rtol=0, atol=4 * EPS)


axes_of_turns = st.tuples(*[component | small] * 3).filter(lambda a: np.linalg.norm(a) > 0.1).map(unit)


@lawful
@given(axes_of_turns, small)
def test_half_turns_to_matrix_and_back(axis, near):
    q = unit([np.sin(near / 2), *(np.cos(near / 2) * axis)])
    back = quaternion_from_matrix(rotation_matrix(q))
    assert np.allclose(back, np.sign(back @ q) * q, rtol=0, atol=3 * EPS)


@lawful
@given(quaternions)
def test_matrix_to_quaternion_and_back(q):
    A = Rotation.from_quat(q, scalar_first=True).as_matrix()
    assert np.allclose(rotation_matrix(quaternion_from_matrix(A)), A, rtol=0, atol=8 * EPS)


@lawful
@given(quaternions)
def test_rotation_to_quaternion_and_back(q):
    turn = Rotation.from_quat(q, scalar_first=True)
    found = unit_quaternion(turn)
    assert np.allclose(found, q, rtol=0, atol=2 * EPS)
    assert np.allclose(rotation_matrix(found), turn.as_matrix(), rtol=0, atol=8 * EPS)
    state = pt.State(turn, (0, 0, 0, 0))
    assert (turn.inv() * state.attitude).magnitude() <= 8 * EPS


# ---------------------------------------------------------------------- Euler angles

outside_the_pole = st.floats(1e-5, np.pi - 1e-5) | st.sampled_from(
    [d if near == 0 else np.pi - d for near in (0, 1) for d in (1e-5, 1.1e-5, 1e-4, 1e-3, 1e-2)] + [np.pi / 2]
)
first_angles = st.floats(0, 4 * np.pi, exclude_max=True) | st.sampled_from(
    [0.0, np.pi, 2 * np.pi, 3 * np.pi, np.nextafter(4 * np.pi, 0), 1e-17, 1e-9, np.nextafter(2 * np.pi, 0)]
)
third_angles = st.floats(0, 2 * np.pi, exclude_max=True) | st.sampled_from(
    [0.0, np.pi / 2, np.pi, 1e-17, 1e-9, np.nextafter(2 * np.pi, 0), 1e-16]
)


def symmetric(sequence):
    return sequence[0] == sequence[2]


def inside(sequence, first, from_pole, third):
    """Angles in the stated ranges, and the sine of the angle between the outer axes."""
    middle = from_pole if symmetric(sequence) else from_pole - np.pi / 2
    return np.array([first, middle, third]), np.sin(from_pole)


def distance_of_angles(a, b):
    """Differences, the first on a circle of 4 pi, the third on one of 2 pi."""
    d = np.abs(a - b)
    return np.array([min(d[0], 4 * np.pi - d[0]), d[1], min(d[2], 2 * np.pi - d[2])])


@pytest.mark.parametrize("sequence", SEQUENCES)
@lawful_in_each_sequence
@given(first=first_angles, from_pole=outside_the_pole, third=third_angles)
def test_angles_in_their_ranges_come_back(sequence, first, from_pole, third):
    """Up to eps / sin. Where the third angle crosses 2 pi by rounding, the first follows by 2 pi."""
    angles, sine = inside(sequence, first, from_pole, third)
    back = euler.angles_from_quaternion(euler.quaternion_from_angles(angles, sequence), sequence)
    crossed = np.array([2 * np.pi, 0, 0]) * round((angles[2] - back[2]) / (2 * np.pi))
    expected = np.array([np.remainder(angles[0] + crossed[0], 4 * np.pi), angles[1], angles[2]])
    assert np.all(distance_of_angles(back, expected) <= 16 * EPS / sine)
    assert 0 <= back[0] < 4 * np.pi
    assert 0 <= back[2] < 2 * np.pi


@pytest.mark.parametrize("sequence", SEQUENCES)
@lawful_in_each_sequence
@given(q=quaternions)
def test_quaternion_to_angles_and_back_keeps_the_sign(sequence, q):
    try:
        angles = euler.angles_from_quaternion(q, sequence)
    except ValueError:
        assume(False)
    assert np.allclose(euler.quaternion_from_angles(angles, sequence), q, rtol=0, atol=16 * EPS)


@pytest.mark.parametrize("sequence", SEQUENCES)
@lawful_in_each_sequence
@given(first=first_angles, from_pole=outside_the_pole, third=third_angles | small, g=vectors)
def test_state_to_euler_variables_and_back_keeps_the_signs(sequence, first, from_pole, third, g):
    angles, sine = inside(sequence, first, from_pole, third)
    q = euler.quaternion_from_angles(angles, sequence)
    state = pt.State(q, 2 * quat.product(q, quat.pure(g)))
    back = pt.State.from_euler(*state.euler(sequence), sequence)
    assert np.allclose(back.quaternion, state.quaternion, rtol=0, atol=16 * EPS)
    size = norm(state.conjugate_momenta)
    assert norm(back.conjugate_momenta - state.conjugate_momenta) <= 32 * EPS / sine * size + 1e-300
    assert 0 <= state.euler(sequence)[0][0] < 4 * np.pi


@pytest.mark.parametrize("sequence", SEQUENCES)
@lawful_in_each_sequence
@given(first=first_angles, from_pole=st.floats(0.2, np.pi - 0.2), third=third_angles, g=vectors, omega=vectors)
def test_momenta_times_rates_of_the_angles_are_g_times_omega(sequence, first, from_pole, third, g, omega):
    angles, _ = inside(sequence, first, from_pole, third)
    q = euler.quaternion_from_angles(angles, sequence)
    step = 1e-4 / (1 + norm(omega))
    ahead, back = (
        euler.angles_from_quaternion(
            quat.product(q, Rotation.from_rotvec(sign * step * omega).as_quat(scalar_first=True)), sequence
        )
        for sign in (1, -1)
    )
    change = np.remainder(ahead - back + np.pi, 2 * np.pi) - np.pi
    momenta = euler.momenta_from_angular_momentum(angles, g, sequence)
    assert abs(momenta @ change / (2 * step) - g @ omega) <= 1e-5 * (1e-3 + norm(g) * norm(omega))


@pytest.mark.parametrize("sequence", SEQUENCES)
@lawful_in_each_sequence
@given(first=first_angles, from_pole=outside_the_pole, third=third_angles, g=vectors)
def test_momenta_to_angular_momentum_and_back(sequence, first, from_pole, third, g):
    angles, sine = inside(sequence, first, from_pole, third)
    momenta = euler.momenta_from_angular_momentum(angles, g, sequence)
    back = euler.angular_momentum_from_momenta(angles, momenta, sequence)
    assert norm(back - g) <= 32 * EPS / sine * norm(g) + 1e-300


# ---------------------------------------------------------------------- rates

bodies = st.tuples(st.floats(0.1, 5), st.floats(0.1, 5), st.floats(0.01, 0.99)).map(
    lambda m: pt.Body((m[0], m[1], abs(m[0] - m[1]) + m[2] * 2 * min(m[0], m[1])))
)
oblique = st.builds(
    lambda body, q: pt.Body.from_inertia(rotation_matrix(q) @ np.diag(body.moments) @ rotation_matrix(q).T),
    bodies,
    anywhere,
)


@lawful
@given(bodies | oblique, quaternions, vectors)
def test_state_to_rate_and_back(body, q, g):
    state = body.state(q, angular_momentum_body=g)
    moments = np.linalg.eigvalsh(body.inertia)
    slack = 64 * EPS * moments[-1] / moments[0] * (norm(g) + 1e-300)
    rates = {"omega_body": body.omega(state.angular_momentum_body)}
    rates["omega_space"] = quat.rotate(q, rates["omega_body"])
    rates["angular_momentum_space"] = state.angular_momentum_space
    for name, value in rates.items():
        back = body.state(q, **{name: value})
        assert back.quaternion.tolist() == q.tolist()
        assert norm(back.conjugate_momenta - state.conjugate_momenta) <= 2 * slack


@lawful
@given(bodies | oblique, vectors)
def test_twice_the_kinetic_energy_is_g_times_omega(body, g):
    omega = body.omega(g)
    size = norm(g) * norm(omega) + 1e-300
    assert abs(2 * body.kinetic_energy(g) - g @ omega) <= 16 * EPS * size
    assert abs(2 * body.kinetic_energy(g) - omega @ body.inertia @ omega) <= 1e-12 * size


@lawful
@given(quaternions, general)
def test_projection_is_idempotent_and_keeps_the_angular_momentum(q, Q):
    projected = pt.mechanics.project_to_tangent(q, Q)
    assert abs(q @ projected) <= 8 * EPS * norm(Q)
    assert norm(pt.mechanics.project_to_tangent(q, projected) - projected) <= 8 * EPS * norm(Q)
    g, tangent = (quat.imaginary(quat.product(quat.conjugate(q), x)) for x in (Q, projected))
    assert norm(g - tangent) <= 16 * EPS * norm(Q)


# ---------------------------------------------------------------------- orbits

angle = st.floats(0, 2 * np.pi, exclude_max=True)
bad_inclinations = [d if end == 0 else np.pi - d for end in (0, 1) for d in (0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-3)]
inclinations = st.floats(0, np.pi) | st.sampled_from(bad_inclinations)
eccentricities = st.floats(0, 0.97) | st.sampled_from([0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-3])


def vectors_of(orbit, time):
    return (np.array([float(x) for x in at(time)]) for at in (orbit.position_at, orbit.velocity_at))


@lawful
@given(eccentricities, inclinations, angle, angle, angle)
def test_elements_to_vectors_and_back(eccentricity, inclination, node, periapsis, anomaly):
    """At every inclination and eccentricity the vectors are the same; the angles where they are defined."""
    orbit = pt.KeplerOrbit(
        2.0,
        semimajor_axis=1.5,
        eccentricity=eccentricity,
        inclination=inclination,
        node=node,
        argument_of_periapsis=periapsis,
        true_anomaly=anomaly,
        epoch=0.3,
    )
    r, v = vectors_of(orbit, 0.3)
    other = pt.KeplerOrbit.from_vectors(2.0, position=r, velocity=v, epoch=0.3)
    stretch = 1 / (1 - eccentricity)
    again_r, again_v = vectors_of(other, 0.3)
    assert norm(again_r - r) <= 32 * EPS * stretch * norm(r)
    assert norm(again_v - v) <= 32 * EPS * stretch * norm(v)
    assert other.eccentricity == pytest.approx(eccentricity, abs=32 * EPS * stretch)
    assert other.semimajor_axis == pytest.approx(1.5, rel=32 * EPS * stretch, abs=0)
    assert 0 <= other.inclination <= np.pi


@lawful
@given(st.floats(0.01, 0.97), st.floats(0.01, np.pi - 0.01), angle, angle, angle)
def test_elements_come_back(eccentricity, inclination, node, periapsis, anomaly):
    orbit = pt.KeplerOrbit(
        2.0,
        semimajor_axis=1.5,
        eccentricity=eccentricity,
        inclination=inclination,
        node=node,
        argument_of_periapsis=periapsis,
        true_anomaly=anomaly,
        epoch=0.3,
    )
    r, v = vectors_of(orbit, 0.3)
    other = pt.KeplerOrbit.from_vectors(2.0, position=r, velocity=v, epoch=0.3)
    found = np.array([other.inclination, other.node, other.argument_of_periapsis, other.true_anomaly])
    given_angles = np.array([inclination, node, periapsis, anomaly])
    difference = np.remainder(found - given_angles + np.pi, 2 * np.pi) - np.pi
    slack = 64 * EPS / (1 - eccentricity) / eccentricity / np.sin(inclination)
    assert np.max(np.abs(difference)) <= slack


@lawful
@given(vectors, vectors)
def test_vectors_to_elements_and_back(r, v):
    assume(norm(r) > 0.1 and norm(np.cross(r, v)) > 0.05 * norm(r) * norm(v) > 0)
    mu = 2.0
    v = v / norm(v) * np.sqrt(mu / norm(r))
    orbit = pt.KeplerOrbit.from_vectors(mu, position=r, velocity=v, epoch=-4.0)
    again_r, again_v = vectors_of(orbit, -4.0)
    slack = 64 * EPS / (1 - float(orbit.eccentricity))
    assert norm(again_r - r) <= slack * norm(r)
    assert norm(again_v - v) <= slack * norm(v)
