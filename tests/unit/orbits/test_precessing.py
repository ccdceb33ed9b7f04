"""The precessing ellipse: its velocity, frame and axes are the derivatives of its position, with all rates."""

import itertools

import numpy as np
import pytest

import poinsot as pt
from in_order import in_order
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
ELLIPSE = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.3,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
CIRCLE = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.0,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
EQUATORIAL = pt.KeplerOrbit(
    2.0, semimajor_axis=1.5, eccentricity=0.0, node=1.1, argument_of_periapsis=-0.7, true_anomaly=2.0, epoch=0.25
)
RATES = {
    "node": (0.3, 0.0, 0.0),
    "periapsis": (0.0, -0.2, 0.0),
    "anomaly": (0.0, 0.0, 0.1),
    "all": (-0.3, 0.5, 0.1),
}
ORBITS = {name: in_order(PrecessingOrbit, ELLIPSE, *rates) for name, rates in RATES.items()}
TIMES = np.array([-3.0, 0.25, 0.4, 2.7, 11.0])
each = pytest.mark.parametrize("name", ORBITS)


def floats(vector):
    return np.array([float(x) for x in vector])


@each
def test_velocity_is_the_derivative_of_the_position(name):
    orbit = ORBITS[name]
    t = Graph().variable(TIMES)
    velocity = t.graph.evaluated(tangents(orbit.position_at(t), {t: 1.0}))
    assert np.allclose(np.stack(velocity), np.stack(orbit.velocity_at(TIMES)), rtol=0, atol=2e-15 * 8)
    step = 1e-5
    for time in TIMES:
        found = (floats(orbit.position_at(time + step)) - floats(orbit.position_at(time - step))) / (2 * step)
        assert np.allclose(floats(orbit.velocity_at(time)), found, rtol=0, atol=1e-9)


@each
def test_frame_turns_as_its_quaternion_does(name):
    orbit, step = ORBITS[name], 1e-5
    for time in TIMES:
        A = rotation_matrix(orbit.frame.quaternion(time))
        change = rotation_matrix(orbit.frame.quaternion(time + step)) - rotation_matrix(
            orbit.frame.quaternion(time - step)
        )
        spin = change @ A.T / (4 * step)
        found = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        assert np.allclose(orbit.frame.omega_space(time), found, rtol=0, atol=1e-8)
        r = floats(orbit.position_at(time))
        assert np.allclose(A[:, 0], r / np.linalg.norm(r), rtol=0, atol=8 * EPS)
        assert A[2, 2] == pytest.approx(np.cos(0.4), abs=6 * EPS)


@each
def test_velocity_is_that_of_the_frame_and_the_climb(name):
    orbit = ORBITS[name]
    for time in TIMES:
        r, v = floats(orbit.position_at(time)), floats(orbit.velocity_at(time))
        across = np.cross(orbit.frame.omega_space(time), r)
        climb = r @ v / (r @ r) * r
        assert np.allclose(v, across + climb, rtol=0, atol=1e-14)


def test_angles_advance_at_their_rates():
    orbit, turns = ORBITS["all"], 2 * np.pi
    for time in (3.0, 700.0):
        node, inclination, periapsis = orbit.angles_at(time)
        assert np.remainder(node - (1.1 - 0.3 * (time - 0.25)) + 1, turns) == pytest.approx(1, abs=1e-12)
        assert np.remainder(periapsis - (-0.7 + 0.5 * (time - 0.25)) + 1, turns) == pytest.approx(1, abs=1e-12)
        assert inclination == 0.4


def test_without_rates_it_is_the_ellipse_to_the_last_bit():
    orbit = PrecessingOrbit(ELLIPSE)
    times = np.array([-1e7, -3.0, 0.25, 5.5, 1e6, 3e8])
    for name in ("position_at", "velocity_at", "inverse_distance_at"):
        assert np.array_equal(np.stack(getattr(orbit, name)(times)), np.stack(getattr(ELLIPSE, name)(times)))
    assert np.allclose(orbit.frame.quaternion(times), ELLIPSE.frame.quaternion(times), rtol=0, atol=4 * EPS)
    assert np.allclose(orbit.frame.omega_space(times), ELLIPSE.frame.omega_space(times), rtol=0, atol=16 * EPS)
    assert (orbit.mu, orbit.period, orbit.epoch) == (ELLIPSE.mu, ELLIPSE.period, ELLIPSE.epoch)


def test_an_observed_mean_motion():
    orbit = PrecessingOrbit.from_mean_motion(ELLIPSE, mean_motion=0.8, node_rate=-0.01, periapsis_rate=0.02)
    assert orbit.mean_motion == pytest.approx(0.8, rel=2 * EPS, abs=0)
    assert orbit.period == pytest.approx(2 * np.pi / 0.8, rel=4 * EPS, abs=0)
    phase = orbit.phase_at(0.25 + 1e6 * orbit.period) - orbit.phase_at(0.25)
    assert abs(np.remainder(phase + 1, 2 * np.pi) - 1) < 2e-9  # what the rounding of that time leaves


def test_at_the_epoch_it_is_where_the_ellipse_is():
    for orbit in ORBITS.values():
        assert np.array_equal(floats(orbit.position_at(0.25)), floats(ELLIPSE.position_at(0.25)))


def test_uniform_rotation_only_where_position_turns_unchanged():
    n = CIRCLE.mean_motion
    assert PrecessingOrbit(ELLIPSE, node_rate=0.0, periapsis_rate=0.1).uniform_rotation is None
    assert PrecessingOrbit(CIRCLE, node_rate=0.1).uniform_rotation is None
    for orbit, rate in (
        (PrecessingOrbit(CIRCLE, node_rate=0.0, periapsis_rate=0.1, anomaly_rate=0.01), n + 0.11),
        (PrecessingOrbit(EQUATORIAL, node_rate=0.2, periapsis_rate=0.1, anomaly_rate=0.01), n + 0.31),
    ):
        turn = orbit.uniform_rotation
        assert np.allclose(turn, rate * orbit.orbit.normal, rtol=0, atol=4 * EPS)
        for time in (1.0, 5.0):
            v = np.cross(turn, floats(orbit.position_at(time)))
            assert np.allclose(floats(orbit.velocity_at(time)), v, rtol=0, atol=8 * EPS)


def test_directions_are_those_that_stay():
    assert list(ORBITS["periapsis"].directions) == ["normal"]
    assert ORBITS["node"].directions == {}


# ---------------------------------------------------------------------- in kernels

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3), time=-2.0)
RUN = np.linspace(-3.0, 9.0, 7)


class Stream(pt.Torque):
    """Looks at velocity and position, but at no axes of space."""

    orbit: pt.Orbit

    def torque(self, instant):
        wind = instant.attitude.to_body(instant.velocity(self.orbit))
        return 0.1 * pt.functions.cross(instant.attitude.to_body(instant.position(self.orbit)), wind) + 0.05 * wind


@each
@pytest.mark.parametrize("force", [pt.GravityGradient, Stream])
def test_axes_of_its_own_and_space_axes_agree(name, force):
    comoving, fixed = (
        pt.System(BODY, force(ORBITS[name]), *more) for more in ([], [pt.UniformGravity(0.0, (1, 0, 0))])
    )
    chosen = FORMULATIONS["lie_poisson"]
    both = [equations.state_vector(Problem(system), START, chosen, "double") for system in (comoving, fixed)]
    assert [variables.comoving for variables in both] == [True, False]
    motions = [pt.propagate(system, START, RUN) for system in (comoving, fixed)]
    np.testing.assert_allclose(motions[0].quaternion, motions[1].quaternion, rtol=0, atol=1e-13)
    np.testing.assert_allclose(motions[0].conjugate_momenta, motions[1].conjugate_momenta, rtol=0, atol=2.5e-13)


def test_a_node_that_moves_moves_the_body():
    still, moving = (
        pt.propagate(pt.System(BODY, pt.GravityGradient(orbit)), START, RUN) for orbit in (ELLIPSE, ORBITS["node"])
    )
    assert np.max(np.abs(still.omega_body - moving.omega_body)) > 1e-2


def test_members_with_rates_of_their_own():
    rates = np.array([0.0, 0.2, -0.3])

    def motion(i):
        return pt.propagate(
            pt.System(BODY, pt.GravityGradient(PrecessingOrbit(ELLIPSE, node_rate=rates[i]))), START, RUN
        )

    together = motion(slice(None))
    for i in range(3):
        np.testing.assert_allclose(together.quaternion[i], motion(i).quaternion, rtol=0, atol=1e-13)


def test_the_formulas_run_on_symbols():
    graph, own = Graph(), ORBITS["all"]
    time, orbit = graph.symbol("time"), own.with_numbers(map(graph.input, itertools.count()))
    formulas = [*orbit.position_at(time), *orbit.velocity_at(time), orbit.inverse_distance_at(time)]
    compiled = WideEvaluator(formulas, [time])
    for instant in TIMES:
        expected = [*own.position_at(instant), *own.velocity_at(instant), own.inverse_distance_at(instant)]
        assert np.allclose(compiled([instant, *own.numbers])[:7], floats(expected), rtol=0, atol=2e-14)


def test_circular_equatorial_precession_has_a_jacobi_integral():
    system = pt.System(
        BODY, pt.GravityGradient(PrecessingOrbit(EQUATORIAL, node_rate=0.2, periapsis_rate=0.1, anomaly_rate=0.01))
    )
    assert [integral.name for integral in system.integrals] == ["jacobi_energy"]
    assert np.max(np.abs(pt.propagate(system, START, RUN).drift["jacobi_energy"])) < 1e-14
