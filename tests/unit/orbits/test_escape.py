"""Parabola and hyperbola: what every two-body orbit keeps, their derived numbers, their frame, their derivatives."""

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import poinsot as pt
from poinsot.integration.scaling import momentum_scale
from poinsot.kinematics.attitude import rotation_matrix
from poinsot.orbits.escape import EscapeOrbit
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
MU, Q, EPOCH = 2.0, 0.8, 0.25
SHAPES = {"parabola": 1.0, "nearly": 1 + 1e-12, "bent": 1.01, "hyperbola": 1.6, "straight": 40.0}
ORBITS = {
    name: EscapeOrbit(
        MU,
        periapsis_distance=Q,
        eccentricity=e,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        time_since_periapsis=0.6,
        epoch=EPOCH,
    )
    for name, e in SHAPES.items()
}
TIMES = EPOCH - 0.6 + np.array([-50.0, -3.0, -1e-6, 0.0, 0.2, 1.0, 9.0])
each = pytest.mark.parametrize("name", ORBITS)


def at(orbit, time):
    return (np.array([float(x) for x in f(time)]) for f in (orbit.position_at, orbit.velocity_at))


@each
def test_energy_and_angular_momentum_are_those_of_the_elements(name):
    orbit, e = ORBITS[name], SHAPES[name]
    for time in TIMES:
        r, v = at(orbit, time)
        kinetic, potential = v @ v / 2, MU / np.linalg.norm(r)
        assert abs(kinetic - potential - MU * (e - 1) / (2 * Q)) < 16 * EPS * (kinetic + potential)
        h = np.sqrt(MU * Q * (1 + e)) * orbit.normal
        assert np.linalg.norm(np.cross(r, v) - h) < 8 * EPS * np.linalg.norm(r) * np.linalg.norm(v)


@each
def test_motion_is_that_of_newtons_law(name):
    orbit = ORBITS[name]
    solution = solve_ivp(
        lambda _, y: np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3]),
        (TIMES[1], TIMES[-1]),
        np.concatenate(list(at(orbit, TIMES[1]))),
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
    )
    r, v = at(orbit, TIMES[-1])
    assert np.linalg.norm(solution.y[:3, -1] - r) < 1e-10 * np.linalg.norm(r)
    assert np.linalg.norm(solution.y[3:, -1] - v) < 1e-10 * np.linalg.norm(v)


@each
def test_periapsis_is_the_nearest_point(name):
    orbit = ORBITS[name]
    assert orbit.periapsis_time == EPOCH - 0.6
    r, v = at(orbit, orbit.periapsis_time)
    assert np.linalg.norm(r) == pytest.approx(Q, rel=4 * EPS, abs=0)
    assert abs(r @ v) < 8 * EPS * np.linalg.norm(r) * np.linalg.norm(v)
    assert float(orbit.true_anomaly_at(orbit.periapsis_time)) == 0
    assert all(1 / float(orbit.inverse_distance_at(t)) >= Q * (1 - 4 * EPS) for t in TIMES)


@each
def test_distance_follows_the_conic(name):
    orbit, e = ORBITS[name], SHAPES[name]
    for time in TIMES:
        f = float(orbit.true_anomaly_at(time))
        assert abs(float(orbit.inverse_distance_at(time)) - (1 + e * np.cos(f)) / orbit.parameter) < 4 * EPS * e / Q
        assert abs(f) < orbit.largest_anomaly
    assert float(orbit.true_anomaly_at(1e15)) == pytest.approx(orbit.largest_anomaly, abs=1e-4)


def test_derived_numbers():
    orbit, parabola = ORBITS["hyperbola"], ORBITS["parabola"]
    assert orbit.semimajor_axis == pytest.approx(-Q / 0.6, rel=4 * EPS, abs=0)
    assert orbit.parameter == Q * 2.6
    assert orbit.excess_speed == pytest.approx(np.sqrt(MU * 0.6 / Q), rel=4 * EPS, abs=0)
    assert np.linalg.norm(list(orbit.velocity_at(1e12))) == pytest.approx(orbit.excess_speed, rel=1e-10, abs=0)
    assert orbit.largest_anomaly == pytest.approx(np.arccos(-1 / 1.6), rel=4 * EPS, abs=0)
    assert (orbit.period, parabola.period, parabola.semimajor_axis) == (np.inf, np.inf, -np.inf)
    assert parabola.excess_speed == 0
    assert parabola.largest_anomaly == pytest.approx(np.pi)
    assert orbit.uniform_rotation is None
    assert np.array_equal(orbit.directions["normal"], orbit.normal)


@each
def test_times_of_any_shape(name):
    orbit = ORBITS[name]
    x = np.stack(orbit.position_at(TIMES.reshape(1, -1)))
    assert x.shape == (3, 1, len(TIMES))
    for i, time in enumerate(TIMES):
        r, _ = at(orbit, time)
        assert np.allclose(x[:, 0, i], r, rtol=0, atol=8 * EPS * np.linalg.norm(r))


def test_members_have_their_own_eccentricity():
    e = np.array([1.0, 1.3, 5.0])
    x = np.stack(
        EscapeOrbit(
            MU,
            periapsis_distance=Q,
            eccentricity=e,
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            time_since_periapsis=0.6,
            epoch=EPOCH,
        ).position_at(2.0)
    )
    for i in range(3):
        alone = EscapeOrbit(
            MU,
            periapsis_distance=Q,
            eccentricity=e[i],
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            time_since_periapsis=0.6,
            epoch=EPOCH,
        ).position_at(2.0)
        assert np.allclose(x[:, i], list(alone), rtol=0, atol=1e-14)


@each
def test_frame_turns_as_its_quaternion_does(name):
    frame, step = ORBITS[name].frame, 1e-5
    for time in (-0.9, 0.4, 2.7):
        A = rotation_matrix(frame.quaternion(time))
        spin = (rotation_matrix(frame.quaternion(time + step)) - rotation_matrix(frame.quaternion(time - step))) @ A.T
        found = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / (4 * step)
        assert np.allclose(frame.omega_space(time), found, rtol=0, atol=1e-9)
        r, v = at(ORBITS[name], time)
        assert np.allclose(A[:, 0], r / np.linalg.norm(r), rtol=0, atol=8 * EPS)
        assert np.allclose(frame.omega_space(time), np.cross(r, v) / (r @ r), rtol=0, atol=2e-14)


@each
def test_derivatives_with_respect_to_time(name):
    orbit = ORBITS[name]
    t = Graph().variable(TIMES)
    velocity = t.graph.evaluated(tangents(orbit.position_at(t), {t: 1.0}))
    assert np.allclose(np.stack(velocity), np.stack(orbit.velocity_at(TIMES)), rtol=0, atol=1.5e-14)
    r = np.stack(orbit.position_at(TIMES))
    acceleration = np.stack(t.graph.evaluated(tangents(orbit.velocity_at(t), {t: 1.0})))
    assert np.allclose(acceleration, -MU * r / np.linalg.norm(r, axis=0) ** 3, rtol=0, atol=4e-14)
    (closing,) = t.graph.evaluated(tangents([orbit.inverse_distance_at(t)], {t: 1.0}))
    expected = -np.sum(r * np.stack(orbit.velocity_at(TIMES)), axis=0) / np.linalg.norm(r, axis=0) ** 3
    assert np.allclose(closing, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("time", [Graph().symbol("t"), sympy.Symbol("t")])
def test_symbols_are_refused_with_a_sentence(time):
    with pytest.raises(TypeError, match=r"^the formulas of an EscapeOrbit must have numbers, got a symbol\. "):
        ORBITS["hyperbola"].position_at(time)


# ---------------------------------------------------------------------- in kernels

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3), time=-2.0)
RUN = np.linspace(-3.0, 6.0, 7)


class Wind(pt.Torque):
    """Looks at position and velocity along the space axes."""

    orbit: pt.Orbit
    wind_space: pt.mechanics.Vector

    def torque(self, instant):
        push = instant.attitude.to_body(instant.velocity(self.orbit) + self.wind_space)
        return 0.1 * instant.inverse_distance(self.orbit) * push + 0.1 * instant.position(self.orbit)[2] * push


def systems(name):
    orbit = ORBITS[name]
    ellipse, other = (
        pt.KeplerOrbit(
            MU,
            semimajor_axis=3.0,
            eccentricity=0.3,
            inclination=0.5,
            node=0.3,
            argument_of_periapsis=0.2,
            true_anomaly=1.0,
        ),
        ORBITS["hyperbola" if name != "hyperbola" else "bent"],
    )
    gradient = pt.GravityGradient(orbit)
    return {
        "carried": pt.System(BODY, gradient),
        "space": pt.System(BODY, gradient, pt.UniformGravity(0.3, (1, 0, 0))),
        "wind": pt.System(BODY, Wind(orbit, (0.1, 0.2, 0.3))),
        "with an ellipse": pt.System(BODY, gradient, pt.GravityGradient(ellipse)),
        "two escapes": pt.System(BODY, pt.GravityGradient(other), Wind(orbit, (0, 0, 1))),
    }


@pytest.mark.parametrize(
    ("kind", "formulation"),
    [
        ("carried", "lie_poisson"),
        ("carried", "canonical"),
        ("space", "lie_poisson"),
        ("space", "euler_angles"),
        ("wind", "canonical"),
        ("two escapes", "lie_poisson"),
    ],
)
def test_propagation_does_not_depend_on_axes_and_precision(kind, formulation):
    system = systems("hyperbola")[kind]
    motion = pt.propagate(system, START, RUN, formulation=formulation)
    reference = pt.propagate(system, START, RUN, precision="quadruple")
    np.testing.assert_allclose(motion.attitude.as_matrix(), reference.attitude.as_matrix(), rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.omega_body, reference.omega_body, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", ["carried", "space", "wind", "with an ellipse", "two escapes"])
def test_forces_along_the_path_are_those_of_the_closed_form(kind):
    system = systems("hyperbola")[kind]
    motion = pt.propagate(system, START, RUN, dense=True)
    step = 1e-4
    for time in (-1.5, 0.7):
        after, before = motion(time + step), motion(time - step)
        change = (after.angular_momentum_space - before.angular_momentum_space) / (2 * step)
        torque = motion(time).attitude.apply(system.torque_body(motion(time)))
        assert np.allclose(change, torque, rtol=0, atol=1e-7)
        assert np.linalg.norm(torque) > 1e-3


def test_members_along_hyperbolas_of_their_own():
    e = np.array([1.0, 1.2, 3.0])

    def system(i):
        orbit = EscapeOrbit(
            MU,
            periapsis_distance=Q,
            eccentricity=e[i],
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            time_since_periapsis=0.6,
            epoch=EPOCH,
        )
        return [
            pt.System(BODY, pt.GravityGradient(orbit)),
            pt.System(BODY, pt.GravityGradient(orbit), pt.UniformGravity(0.3, (1, 0, 0))),
        ]

    for k in range(2):
        together = pt.propagate(system(slice(None))[k], START, RUN)
        for i in range(3):
            alone = pt.propagate(system(i)[k], START, RUN)
            np.testing.assert_allclose(together.quaternion[i], alone.quaternion, rtol=0, atol=1e-13)


def test_other_numbers_use_the_same_kernel_also_across_the_parabola(forget_kernels):
    from poinsot.integration import equations
    from poinsot.integration.kernel_parameters import PreparedKernel

    forget_kernels()
    nearly, bent = (pt.propagate(systems(name)["space"], START, RUN).quaternion for name in ("nearly", "bent"))
    assert sum(isinstance(known, PreparedKernel) for known in equations.known._stored.values()) == 1
    parabola = pt.propagate(systems("parabola")["space"], START, RUN).quaternion  # e - 1 is zero
    assert np.max(np.abs(parabola - nearly)) < 1e-11
    assert np.max(np.abs(parabola - bent)) > 1e-4


def test_a_flyby_conserves_the_energy_once_it_is_over():
    far = EscapeOrbit(MU, periapsis_distance=Q, eccentricity=1.6, inclination=0.4, node=1.1, argument_of_periapsis=-0.7)
    system = pt.System(BODY, pt.GravityGradient(far))
    start = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3), time=-1e4)
    energy = pt.propagate(system, start, [-1e4, -9e3, 0.0, 9e3, 1e4]).kinetic_energy
    assert abs(energy[1] - energy[0]) < 1e-11
    assert abs(energy[4] - energy[3]) < 1e-11
    assert abs(energy[4] - energy[0]) > 1e-2


def test_a_distant_epoch_does_not_hide_the_passage():
    """Formulas are tried near the periapsis: elsewhere the attraction is negligible."""
    orbit = EscapeOrbit(
        MU,
        periapsis_distance=Q,
        eccentricity=1.6,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        time_since_periapsis=0.0,
        epoch=1e12,
    )
    system = pt.System(BODY, pt.GravityGradient(orbit), pt.UniformGravity(0.3, (1, 0, 0)))
    assert system.integrals == ()
    alone = pt.System(BODY, pt.GravityGradient(orbit))
    at_rest = BODY.state((0.6, 0.8, 0, 0), omega_body=(0, 0, 0), time=1e12 - 100)
    assert 0.1 < momentum_scale(alone.dynamics, at_rest) < 10
