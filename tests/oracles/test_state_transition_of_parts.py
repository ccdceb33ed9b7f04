"""State transition of bodies with parts: equations written by hand, the Poisson structure and Liouville's theorem."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp

import poinsot as pt
from poinsot.parts import Gyrostat, KaneDamper, ReactionWheel, SpringMass

INERTIA = np.array([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
BODY = pt.Body.from_inertia(INERTIA)
AXIS, MOMENT, FRICTION, TORQUE = np.array([0.6, 0.0, 0.8]), 0.1, 0.02, 0.01
SPHERE, COEFFICIENT = 0.4, 0.15
WEIGHT, CENTER = 2.0, (0.1, 0.2, 0.3)
OMEGA, ATTITUDE = (0.4, -0.9, 0.3), np.array([0.5, -0.5, 0.1, 0.7])
OWN = {"reaction_wheel": [0.7], "kane_damper": [0.3, -0.2, 0.1]}
TIMES = np.array([0.7, 3.0])


def by_hand():
    """Vector field and Jacobian of (q, g, wheel, sphere) and numbers (friction, coefficient), as functions of them."""
    y, numbers = sympy.Matrix(sympy.symbols("y:11")), sympy.symbols("f c")
    q0, v, g, p, s = y[0], sympy.Matrix(y[1:4]), sympy.Matrix(y[4:7]), y[7], sympy.Matrix(y[8:11])
    axis = sympy.Matrix(AXIS)
    inverse = sympy.Matrix(INERTIA) - MOMENT * axis * axis.T - SPHERE * sympy.eye(3)
    omega = inverse.inv() * (g - p * axis - s)
    up = 2 * (v[2] * v - q0 * v.cross(sympy.Matrix([0, 0, 1]))) + (q0**2 - v.dot(v)) * sympy.Matrix([0, 0, 1])
    rates = [
        -v.dot(omega) / 2,
        *((q0 * omega + v.cross(omega)) / 2),
        *(g.cross(omega) + WEIGHT * up.cross(sympy.Matrix(CENTER))),
        TORQUE - numbers[0] * (p / MOMENT - axis.dot(omega)),
        *(s.cross(omega) - numbers[1] * (s / SPHERE - omega)),
    ]
    field = sympy.Matrix(rates)
    jacobian = field.jacobian([*y, *numbers])
    return sympy.lambdify([y, numbers], [field, jacobian], cse=True)


def product(p, q):
    (a, *b), (c, *d) = p, q
    return np.array([a * c - np.dot(b, d), *(np.multiply(a, d) + np.multiply(c, b) + np.cross(b, d))])


def integrated(start, columns):
    """Motion and variations at the times, DOP853 at 1e-13."""
    function, numbers = by_hand(), (FRICTION, COEFFICIENT)

    def rates(_, x):
        field, jacobian = function(x[:11], numbers)
        own = np.zeros((2, columns.shape[1]))
        own[:, -2:] = np.eye(2)
        return np.concatenate([np.ravel(field), np.ravel(jacobian @ np.vstack([x[11:].reshape(11, -1), own]))])

    begin = np.concatenate([start, columns.ravel()])
    found = solve_ivp(rates, (0, TIMES[-1]), begin, "DOP853", TIMES, rtol=1e-13, atol=1e-14).y.T
    return found[:, :11], found[:, 11:].reshape(len(TIMES), 11, -1)


def test_wheel_and_damper_by_hand():
    system = pt.System(
        BODY,
        ReactionWheel(AXIS, MOMENT, FRICTION, TORQUE),
        KaneDamper(SPHERE, COEFFICIENT),
        pt.UniformGravity(WEIGHT, CENTER),
    )
    q, state = ATTITUDE, system.state(ATTITUDE, omega_body=OMEGA, **OWN)
    found = pt.analysis.state_transition(system, state, TIMES, ["friction", "coefficient"])
    start = np.concatenate([q, state.angular_momentum_body, *OWN.values()])
    columns = np.zeros((11, 12))
    columns[:4, :3] = np.transpose([product(q, [0, *axis]) / 2 for axis in np.eye(3)])
    columns[4:, 3:10] = np.eye(7)
    motion, variations = integrated(start, columns)
    for i in range(len(TIMES)):
        end, back = motion[i, :4], motion[i, :4] * [1, -1, -1, -1]
        assert_allclose(found.motion.quaternion[i], end, rtol=0, atol=3e-14)
        turned = np.transpose([2 * product(back, dq)[1:] for dq in variations[i, :4].T])
        expected = np.vstack([turned, variations[i, 4:]])
        # Ten times the tolerance of the reference over about 30 of its steps, by the size of the entries.
        size = np.max(np.abs(expected))
        assert_allclose(found.matrix[i], expected[:, :10], rtol=0, atol=1e-14 * size)
        assert_allclose(found.sensitivity[i], expected[:, 10:], rtol=0, atol=3e-14 * size)


# ---------------------------------------------------------------------- structure

CROSS = -np.array([[[(i - j) * (j - k) * (k - i) / 2 for k in range(3)] for j in range(3)] for i in range(3)])
CANONICAL = np.array([[0.0, 1.0], [-1.0, 0.0]])
LOSSLESS = {
    "rotors": (Gyrostat((0.3, -0.2, 0.5)), lambda _: np.zeros((0, 0))),
    "wheel": (ReactionWheel(AXIS, MOMENT), lambda _: np.zeros((1, 1))),
    "sphere": (KaneDamper(SPHERE, 0.0), lambda p: -CROSS @ p),
    "spring": (SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 20.0), lambda _: CANONICAL),
}
"""With the Poisson brackets of the variables: of a sphere {p1, p2} = p3, of the body {g1, g2} = -g3."""


def brackets(g, own):
    """Brackets of (rotation vector, g, own): x' = brackets dH."""
    out = np.zeros((6 + len(own), 6 + len(own)))
    out[:3, 3:6], out[3:6, :3], out[3:6, 3:6] = np.eye(3), -np.eye(3), CROSS @ g
    out[6:, 6:] = own
    return out


@pytest.mark.parametrize("name", LOSSLESS)
def test_without_loss_the_matrix_keeps_the_poisson_brackets(name):
    part, own_brackets = LOSSLESS[name]
    system = pt.System(BODY, part, pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)))
    own = {key: values + 0.2 for key, values in system.state(ATTITUDE, omega_body=OMEGA).own.items()}
    state = system.state(ATTITUDE, omega_body=OMEGA, **own)
    found = pt.analysis.state_transition(system, state, np.linspace(2, 20, 10))
    values = found.motion.own.get(part.name, np.zeros((10, 0)))
    start = brackets(state.angular_momentum_body, own_brackets(state.own.get(part.name, ())))
    for matrix, g, variables in zip(found.matrix, found.motion.angular_momentum_body, values, strict=True):
        expected = brackets(g, own_brackets(variables))
        # Sums of about sixty products of two entries, each with a unit in the last place.
        assert np.max(np.abs(matrix @ start @ matrix.T - expected)) < 2e-14 * np.max(np.abs(matrix)) ** 2


def test_wheel_and_damper_contract_the_volume_at_a_constant_rate():
    system = pt.System(BODY, ReactionWheel(AXIS, MOMENT, FRICTION), KaneDamper(SPHERE, COEFFICIENT))
    state = system.state((1, 0, 0, 0), omega_body=OMEGA, **OWN)
    K = np.linalg.inv(INERTIA - MOMENT * np.outer(AXIS, AXIS) - SPHERE * np.eye(3))
    rate = FRICTION * (1 / MOMENT + AXIS @ K @ AXIS) + COEFFICIENT * (3 / SPHERE + np.trace(K))
    times = np.array([-3.0, 2.0, 10.0])
    found = pt.analysis.state_transition(system, state, times)
    assert_allclose(np.linalg.slogdet(found.matrix)[1], -rate * times, rtol=2e-15)
    spectrum = pt.analysis.lyapunov_spectrum(system, state, [30.0])
    assert np.sum(spectrum.exponents) == pytest.approx(-rate, rel=2e-15, abs=0)
    indicators = pt.analysis.chaos_indicators(system, state, [10.0], vectors=10)
    assert indicators.units.size == 10


def test_mass_on_a_spring_contracts_the_volume_by_where_it_is():
    spring = SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), 2.0, 0.3)
    system = pt.System(BODY, spring)
    state = system.state((1, 0, 0, 0), omega_body=OMEGA, spring_mass=(0.2, 0.5))
    motion = pt.propagate(system, state, [0.0, 10.0], dense=True)
    arm, line, mu = np.array((0.3, 0.2, 1)) * 10 / 9, np.array((0.6, 0, 0.8)), 0.9
    lever = np.cross(arm, line)

    def rate(time):
        rho = motion(time).own["spring_mass"][0]
        x = arm + rho * line
        moved = mu * (x @ x * np.eye(3) - np.outer(x, x) - arm @ arm * np.eye(3) + np.outer(arm, arm))
        return 0.3 * (1 / mu + lever @ np.linalg.solve(INERTIA + moved - mu * np.outer(lever, lever), lever))

    found = pt.analysis.state_transition(system, state, [10.0])
    expected = -quad(rate, 0, 10, epsabs=1e-12, epsrel=1e-12, limit=200)[0]
    assert np.linalg.slogdet(found.matrix[0])[1] == pytest.approx(expected, rel=5e-15, abs=0)
