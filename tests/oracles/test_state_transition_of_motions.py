"""State transition against differences of runs in wide precision, the Poisson structure, and Monte Carlo."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions

T = [0.4, 1.7]
ORBIT = {"mu": 1.0, "semimajor_axis": 1.0, "eccentricity": 0.1, "inclination": 0.3, "node": 0.4}
ATTITUDE = Rotation.from_euler("zxz", (0.3, 1.1, -0.4))
G, REST = np.array([0.3, -0.2, 1.4]), np.zeros(6)
FIRST = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))


class Drag(pt.Torque):
    """A torque against the rate, larger where the third axis looks along x."""

    coefficient: float

    def torque(self, instant):
        """Return the torque."""
        return -self.coefficient * functions.exp(instant.attitude.to_body((1.0, 0.0, 0.0))[2]) * instant.omega_body


def kepler(**changes):
    return pt.KeplerOrbit(**ORBIT | changes, argument_of_periapsis=0.5, true_anomaly=0.7)


def everything(**p):
    orbit = kepler(**{k: p[k] for k in ORBIT if k in p})
    forces = (
        pt.GravityGradient(orbit),
        pt.forces.Oblateness(orbit, p.get("j2", 0.05), 0.4, (0.1, 0.2, 1.0)),
        Drag(p.get("coefficient", 0.02)),
        pt.UniformGravity(p.get("weight", 0.3), (0.1, 0.2, 0.3)),
    )
    return pt.System(pt.Body((p.get("A", 1.0), 1.3, 1.7)), *forces)


def oblique():
    tensor = ((1.0, 0.1, 0.05), (0.1, 1.3, -0.07), (0.05, -0.07, 1.7))
    return pt.System(pt.Body.from_inertia(tensor), pt.GravityGradient(kepler()))


def mascons():
    masses, places = (1.0, 0.5, 0.5), ((0.2, 0.1, 0.0), (-0.3, 0.2, 0.4), (-0.1, -0.4, -0.4))
    return pt.System(pt.Body.from_point_masses(masses, places), pt.forces.MasconGravity(kepler(), masses, places))


def table():
    orbit = kepler()
    fitted = pt.orbits.Ephemeris.from_function(
        1.0, position=lambda t: np.stack(list(orbit.position_at(t)), axis=-1), start=-1.0, stop=3.0, tolerance=1e-13
    )
    return pt.System(pt.Body((1.0, 1.3, 1.7)), pt.GravityGradient(fitted))


def state(system, x=REST):
    attitude = ATTITUDE * Rotation.from_rotvec(x[:3])
    return system.body.state(attitude, angular_momentum_body=G + x[3:6])


def displacement(motion, reference):
    turn = reference.attitude.inv() * motion.attitude
    return np.concatenate([turn.as_rotvec(), motion.angular_momentum_body - reference.angular_momentum_body], axis=-1)


def ends(system, x, reference=None):
    motion = pt.propagate(system, state(system, x), T, precision="quadruple")
    return motion if reference is None else displacement(motion, reference)


def differences(function, h=1e-3):
    return sum(c * (function(k * h) - function(-k * h)) for k, c in FIRST) / h


@pytest.mark.parametrize("make", [everything, oblique, mascons, table])
def test_matrix_is_the_derivative_by_the_start(make):
    system = make()
    matrix = pt.analysis.state_transition(system, state(system), T).matrix
    reference = ends(system, REST)
    for i, axis in enumerate(np.eye(6)):
        column = differences(lambda h, axis=axis: ends(system, h * axis, reference))
        assert_allclose(matrix[:, :, i], column, rtol=0, atol=1.5e-11 * np.max(np.abs(column)))


PARAMETERS = {
    "moments[0]": ("A", 1.0),
    "forces[0].orbit.mu": ("mu", 1.0),
    "semimajor_axis": ("semimajor_axis", 1.0),
    "eccentricity": ("eccentricity", 0.1),
    "inclination": ("inclination", 0.3),
    "j2": ("j2", 0.05),
    "coefficient": ("coefficient", 0.02),
    "weight": ("weight", 0.3),
}


def test_sensitivity_is_the_derivative_by_parameters():
    system = everything()
    found = pt.analysis.state_transition(system, state(system), T, list(PARAMETERS))
    reference = ends(system, REST)
    for i, (key, value) in enumerate(PARAMETERS.values()):
        column = differences(lambda h, k=key, v=value: ends(everything(**{k: v + h}), REST, reference))
        assert np.max(np.abs(column)) > 1e-3
        assert_allclose(found.sensitivity[:, :, i], column, rtol=0, atol=3e-12)
    assert found.parameters == tuple(PARAMETERS)


@pytest.fixture(scope="module")
def found():
    """The state transition of everything, with second derivatives by these three, too."""
    names = ["moments[0]", "eccentricity", "coefficient"]
    return pt.analysis.state_transition(everything(), state(everything()), T, names, order=2)


def test_second_derivatives_leave_a_third_order_error(found):
    first = np.concatenate([found.matrix, found.sensitivity], axis=-1)
    direction = np.array([0.3, -0.2, 0.5, 0.4, -0.1, 0.2, 0.5, -0.3, 0.3])
    reference = ends(everything(), REST)

    def error(h):
        x = h * direction
        system = everything(A=1.0 + x[6], eccentricity=0.1 + x[7], coefficient=0.02 + x[8])
        expanded = first @ x + 0.5 * np.einsum("nijk,j,k->ni", found.second, x, x)
        return np.max(np.abs(ends(system, x, reference) - expanded))

    assert error(1e-2) / error(5e-3) == pytest.approx(8, rel=0.1)
    assert error(1e-3) < 1e-8


@pytest.mark.parametrize("pair", [(0, 0), (1, 2), (0, 4), (3, 5), (6, 6), (1, 6), (4, 7), (7, 7), (6, 7)])
def test_each_second_derivative(pair, found):
    h, a, b = 4e-3, *(np.eye(8)[i] for i in pair)
    reference = ends(everything(), REST)

    def at(x):
        return ends(everything(A=1.0 + x[6], eccentricity=0.1 + x[7]), x, reference)

    mixed = sum(
        c * d * r * s * at(h * (k * r * a + j * s * b))
        for k, c in FIRST
        for j, d in FIRST
        for r in (1, -1)
        for s in (1, -1)
    )
    assert_allclose(found.second[(slice(None), slice(None), *pair)], mixed / h**2, rtol=0, atol=5e-10)


def poisson(g):
    """Return the form of two tangent vectors, theta1 . [g] theta2 - theta1 . gamma2 + gamma1 . theta2."""
    form = np.zeros((*g.shape[:-1], 6, 6))
    x, y, z = np.moveaxis(g, -1, 0)
    form[..., 0, 1], form[..., 1, 2], form[..., 2, 0] = -z, -x, -y
    form[..., 1, 0], form[..., 2, 1], form[..., 0, 2] = z, x, y
    form[..., :3, 3:], form[..., 3:, :3] = -np.eye(3), np.eye(3)
    return form


def test_matrix_keeps_the_poisson_structure():
    system = pt.System(pt.Body((1.0, 1.3, 1.7)), pt.GravityGradient(kepler()), pt.UniformGravity(0.3, (0.1, 0.2, 0.3)))
    found = pt.analysis.state_transition(system, state(system), np.linspace(1, 20, 20))
    forms = poisson(found.motion.angular_momentum_body)
    transported = np.swapaxes(found.matrix, -1, -2) @ forms @ found.matrix
    size = np.max(np.abs(found.matrix), axis=(-1, -2), keepdims=True)
    assert np.max(np.abs(transported - poisson(G)) / size**2) < 2e-14
    damped = pt.analysis.state_transition(everything(), state(everything()), [2.0]).matrix[0]
    assert abs(np.linalg.det(damped) - 1) > 1e-2


@pytest.mark.parametrize("time", [0.5, 100.0])
def test_body_about_its_middle_axis_in_closed_form(time):
    """After 100 units of time vectors have been made small several times, each at its own times."""
    A, B, C = 0.099, 0.1, 0.101
    body = pt.Body((A, B, C))
    start = body.state((1, 0, 0, 0), angular_momentum_body=(0, 1.0, 0))
    found = pt.analysis.state_transition(pt.System(body), start, [time], ["moments[1]"], order=2)
    k = np.sqrt((1 / A - 1 / B) * (1 / B - 1 / C))
    by_B = ((1 / B - 1 / C) - (1 / A - 1 / B)) / (2 * k * B**2)
    third = (1 / B - 1 / A) / k
    first, second = np.concatenate([found.matrix, found.sensitivity], axis=-1)[0], found.second[0]
    assert_allclose(first[3, 3], np.cosh(k * time), rtol=1e-12)
    assert_allclose(first[5, 3], third * np.sinh(k * time), rtol=1e-12)
    assert_allclose(first[1, 6], -time / B**2, rtol=1e-14)
    assert_allclose(second[1, 6, 6], 2 * time / B**3, rtol=1e-14)
    assert_allclose(second[3, 3, 4], time * k * np.sinh(k * time), rtol=1e-12)
    assert_allclose(second[3, 3, 6], time * by_B * np.sinh(k * time), rtol=1e-11)
    assert_allclose(second[4, 3, 3], (1 / A - 1 / C) * third * np.sinh(k * time) ** 2 / k, rtol=1e-12)


def test_times_at_which_the_integrator_looks_at_the_vectors_are_reached_too():
    """Each step ends at a knot of the table, and so does the chunk of steps after which vectors are looked at."""
    orbit, times = kepler(), np.linspace(0, 3, 301)
    r, v = (np.stack(list(part(times)), axis=-1) for part in (orbit.position_at, orbit.velocity_at))
    table_of_orbit = pt.orbits.Ephemeris.from_table(orbit.mu, times=times, positions=r, velocities=v)
    systems = [pt.System(pt.Body((1.0, 1.3, 1.7)), pt.GravityGradient(each)) for each in (table_of_orbit, orbit)]
    found, exact = (pt.analysis.state_transition(system, state(system), times[1:]).matrix for system in systems)
    assert_allclose(found, exact, rtol=0, atol=1e-13)


def test_free_symmetric_body_in_closed_form():
    """About its axis: theta3 grows with gamma3 / C, and nothing else does."""
    body = pt.Body((2.0, 2.0, 3.0))
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0.7))
    matrix = pt.analysis.state_transition(pt.System(body), start, [5.0]).matrix[0]
    nutation = Rotation.from_rotvec((0, 0, (1 - 3 / 2) * 0.7 * 5.0)).as_matrix()  # of gamma, seen from the body
    expected = np.zeros(6)
    expected[[2, 5]] = 5.0 / 3.0, 1.0
    assert_allclose(matrix[:, 5], expected, rtol=0, atol=1e-14)
    assert_allclose(matrix[3:, 3:], nutation.T, rtol=0, atol=2e-14)


def test_covariance_agrees_with_an_ensemble():
    random, members = np.random.default_rng(5), 20_000
    system = pt.System(pt.Body((1.0, 1.3, 1.7)), pt.GravityGradient(kepler()))
    initial = np.diag(np.array([2e-4, 1e-4, 3e-4, 1e-4, 2e-4, 1e-4]) ** 2)
    initial[0, 5] = initial[5, 0] = 0.5 * 2e-4 * 1e-4
    of_moments = np.array([[4e-8, 1e-8], [1e-8, 2e-8]])
    found = pt.analysis.state_transition(system, state(system), T, ["moments[0]", "moments[2]"])
    predicted = found.covariance(initial, of_moments)
    x = random.multivariate_normal(np.zeros(6), initial, members)
    p = random.multivariate_normal(np.zeros(2), of_moments, members)
    moments = np.array([1.0, 1.3, 1.7]) + np.stack([p[:, 0], 0 * p[:, 0], p[:, 1]], axis=-1)
    body = pt.Body(moments)
    spread = pt.System(body, pt.GravityGradient(kepler()))
    start = body.state(ATTITUDE * Rotation.from_rotvec(x[:, :3]), angular_momentum_body=G + x[:, 3:])
    motion = pt.propagate(spread, start, T, progress=False)
    for n in range(len(T)):
        turn = found.motion.attitude[n].inv() * Rotation.from_quat(motion.quaternion[:, n], scalar_first=True)
        moved = motion.angular_momentum_body[:, n] - found.motion.angular_momentum_body[n]
        measured = np.cov(np.concatenate([turn.as_rotvec(), moved], axis=-1).T)
        deviations = np.sqrt(np.diag(predicted[n]))
        scatter = np.sqrt((predicted[n] ** 2 + np.outer(deviations, deviations) ** 2) / members)
        assert np.max(np.abs(measured - predicted[n]) / scatter) < 4.5


@pytest.mark.slow
def test_thousand_revolutions_of_a_chaotic_body_do_not_overflow():
    body = pt.Body.from_ratios(beta=0.47, gamma=0.26)
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
    system = pt.System(body, pt.GravityGradient(orbit))
    starts = body.state((1, 0, 0, 0), omega_body=np.linspace((0.01, 0, 0.8), (0.3, 0, 1.2), 8))
    times = orbit.period * np.array([250.0, 500.0, 1000.0])
    found = pt.analysis.state_transition(system, starts, times, ["eccentricity"])
    assert np.all(np.isfinite(found.directions))
    assert np.all(np.isfinite(found.growth))
    assert np.max(found.growth) > 710  # exp of which is no number
    assert np.isinf(np.max(found.matrix))
    assert_allclose(np.linalg.norm(found.directions, axis=-2), 1, rtol=0, atol=1e-14)
    alone = pt.analysis.chaos_indicators(system, starts, times).growth  # the same to the scatter of chaotic motions
    assert_allclose(np.mean(found.growth[:, :, 0], axis=0), np.mean(alone, axis=0), rtol=0.4)
