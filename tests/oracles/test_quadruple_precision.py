"""Motions in quadruple precision against integrations with mpmath and closed forms at 50 digits."""

import mpmath
import numpy as np
import pytest
from benchmarks.wide_states import end_of, ends_of
from mpmath import mpf

import poinsot as pt
from poinsot import functions as fn

UNIT = mpf(2) ** -106
DIGITS = 50
BODY = pt.Body((1.25, 1.0, 0.75))
ATTITUDE, OMEGA = (0.1, 0.7, -0.5, 0.5), (0.4, -0.3, 0.6)
REGULAR = (0.3, -0.2, 2.5)
"""Angular velocity of a motion to t = 200: the top with the other one is chaotic and multiplies an error by 3e7."""

WEIGHT = 0.5


@pytest.fixture(autouse=True)
def many_digits():
    with mpmath.workdps(DIGITS):
        yield


# ---------------------------------------------------------------------- free body and heavy top, by hand


def taylor_step(moments, weight, q, g, order):
    """Return the Taylor coefficients of q and g of a top whose centre of mass is on the first axis."""
    q, g = ([[x] for x in each] for each in (q, g))
    omega, up = [[], [], []], [[], [], []]

    def product(a, b, n):
        return mpmath.fsum(a[j] * b[n - j] for j in range(n + 1))

    for n in range(order):
        for i in range(3):
            omega[i].append(g[i][n] / moments[i])
        # the third space axis along the body axes
        up[0].append(2 * (product(q[1], q[3], n) - product(q[0], q[2], n)))
        up[1].append(2 * (product(q[2], q[3], n) + product(q[0], q[1], n)))
        up[2].append(sum(sign * product(x, x, n) for sign, x in zip((1, -1, -1, 1), q, strict=True)))
        x, y, z = omega
        dq = (
            -product(q[1], x, n) - product(q[2], y, n) - product(q[3], z, n),
            product(q[0], x, n) + product(q[2], z, n) - product(q[3], y, n),
            product(q[0], y, n) + product(q[3], x, n) - product(q[1], z, n),
            product(q[0], z, n) + product(q[1], y, n) - product(q[2], x, n),
        )
        dg = (
            product(g[1], z, n) - product(g[2], y, n),
            product(g[2], x, n) - product(g[0], z, n) + weight * up[2][n],
            product(g[0], y, n) - product(g[1], x, n) - weight * up[1][n],
        )
        for series, rate in zip((*q, *g), (*(rate / 2 for rate in dq), *dg), strict=True):
            series.append(rate / (n + 1))
    return q, g


def by_hand(weight, state, end, order=60):
    """Return q and g at the end of a motion, by Taylor series with steps for 45 digits."""
    moments = [mpf(x) for x in (1.25, 1.0, 0.75)]
    q, g = ([mpf(float(x)) for x in each] for each in (state.quaternion, state.angular_momentum_body))
    norm = mpmath.norm(q)
    q = [x / norm for x in q]
    time, end = mpf(0), mpf(end)
    while time < end:
        series = [*taylor_step(moments, mpf(weight), q, g, order)]
        last = max(abs(x[order]) for each in series for x in each)
        step = min((mpf(10) ** -45 / last) ** (mpf(1) / order), end - time)
        q, g = ([mpmath.polyval(x[::-1], step) for x in each] for each in series)
        time += step
    return [*q, *g]


def physical(formulation, variables):
    """Return q and g of the variables of a formulation."""
    if formulation == "canonical":
        (a, b, c, d), (A, B, C, D) = variables[:4], variables[4:]
        g = (a * B - b * A - c * D + d * C, a * C + b * D - c * A - d * B, a * D - b * C + c * B - d * A)
        return [a, b, c, d, *(x / 2 for x in g)]
    if formulation == "euler_angles":
        angles, (p1, p2, p3) = variables[:3], variables[3:]
        half = [x / 2 for x in angles]
        cosine, sine = mpmath.cos(half[1]), mpmath.sin(half[1])
        total, less = half[0] + half[2], half[0] - half[2]
        q = [cosine * mpmath.cos(total), sine * mpmath.cos(less), sine * mpmath.sin(less), cosine * mpmath.sin(total)]
        across = (p1 - p3 * mpmath.cos(angles[1])) / mpmath.sin(angles[1])
        c, s = mpmath.cos(angles[2]), mpmath.sin(angles[2])
        return [*q, c * p2 + s * across, c * across - s * p2, p3]
    return variables


# Three times the largest errors of 14 random starts at t = 20 and of four at t = 200, in units of 2^-106. The other
# formulations derive g or omega from their variables, and Euler angles may pass near their singularity.
ERRORS = {
    ("lie_poisson", 20.0): 290,
    ("lie_poisson", 200.0): 2000,
    ("canonical", 20.0): 920,
    ("canonical", 200.0): 2500,
    ("euler_angles", 20.0): 4200,
    ("euler_angles", 200.0): 38000,
}


@pytest.mark.parametrize("weight", [0.0, WEIGHT], ids=["free", "top"])
@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical", "euler_angles"])
@pytest.mark.parametrize("end", [20.0, pytest.param(200.0, marks=pytest.mark.slow)])
def test_motion_has_32_digits(weight, formulation, end):
    system = pt.System(BODY, *([pt.UniformGravity(weight, (1.0, 0.0, 0.0))] if weight else []))
    state = BODY.state(ATTITUDE, omega_body=OMEGA if end < 100 else REGULAR)
    expected = by_hand(weight, state, end)
    found = physical(formulation, end_of(system, state, end, formulation=formulation))
    sign = mpmath.sign(found[0] * expected[0])
    found[:4] = [sign * x for x in found[:4]]
    assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < ERRORS[formulation, end] * UNIT


def test_members_have_the_bits_of_single_bodies():
    weights = np.linspace(0.1, 0.9, 5)
    state = BODY.state(ATTITUDE, omega_body=OMEGA)
    together = ends_of(pt.System(BODY, pt.UniformGravity(weights, (1.0, 0.0, 0.0))), state, 3.0, progress=False)
    for weight, found in zip(weights, together, strict=True):
        assert found == end_of(pt.System(BODY, pt.UniformGravity(weight, (1.0, 0.0, 0.0))), state, 3.0)


# ---------------------------------------------------------------------- about one axis, in closed form


INERTIA = 3.0
ROTOR = pt.Body((1.0, 2.5, INERTIA))


def angle_and_rate(variables):
    """Return the angle about the third axis and the rate."""
    return 2 * mpmath.atan2(variables[3], variables[0]), variables[6] / mpf(INERTIA)


def rotor(rate, time=0.0):
    return ROTOR.state((1, 0, 0, 0), omega_body=(0, 0, rate), time=time)


class Burn(pt.Torque):
    """A torque between two times."""

    size: float
    begin: float
    end: float

    def torque(self, instant):
        burns = fn.where(instant.time < self.begin, 0.0, fn.where(instant.time < self.end, 1.0, 0.0))
        return fn.Vector((0.0, 0.0, self.size * burns))


def test_switches_at_times():
    on, off, size, rate = 0.3, 1.1, 0.7, 0.25
    angle, found = angle_and_rate(end_of(pt.System(ROTOR, Burn(size, on, off)), rotor(rate), 2.0))
    a, t1, t2, w = mpf(size) / INERTIA, mpf(on), mpf(off), mpf(rate)
    assert abs(found - (w + a * (t2 - t1))) < 8 * UNIT
    assert abs(angle - (2 * w + a * (t2 - t1) * ((t2 - t1) / 2 + 2 - t2))) < 16 * UNIT


class Opposing(pt.Torque):
    """A torque about the third axis against the sign of the angle: theta'' = -a sign(theta)."""

    size: float

    def torque(self, instant):
        _, sine, _ = instant.attitude.to_body((-1, 0, 0))
        return fn.Vector((0.0, 0.0, self.size * fn.where(fn.less(sine, 0.0), 1.0, -1.0)))


def test_switches_in_the_attitude_at_irrational_times():
    rate, size, end = 0.25, 0.9, 5.0
    start = ROTOR.state((np.cos(0.2), 0, 0, np.sin(0.2)), omega_body=(0, 0, rate))
    theta = 2 * mpmath.atan2(mpf(float(start.quaternion[3])), mpf(float(start.quaternion[0])))
    a, w, left = mpf(size) / INERTIA, mpf(rate), mpf(end)
    while True:
        sign = mpmath.sign(theta) if theta else mpmath.sign(w)
        zero = (w + sign * mpmath.sqrt(w * w + 2 * a * abs(theta))) * sign / a
        step = min(zero, left)
        theta, w, left = theta + w * step - sign * a * step**2 / 2, w - sign * a * step, left - step
        if left == 0:
            break
        theta = mpf(0)
    angle, found = angle_and_rate(end_of(pt.System(ROTOR, Opposing(size)), start, end))
    assert abs(found - w) < 100 * UNIT
    assert abs(angle - theta) < 200 * UNIT


class Push(pt.events.AxisCrossing):
    """An impulse about the third axis, in numbers without rounding errors."""

    def act(self, body, state):
        g = state.angular_momentum_body + np.array([0.0, 0.0, 1.5])
        return body.state(state.quaternion, angular_momentum_body=g, time=state.time)


def test_actions_at_irrational_times():
    rate, end = 0.5, 4.0  # g = 1.5, then 3 and 4.5, all doubles
    system = pt.System(ROTOR)
    events = [Push((1, 0, 0), (1, 0, 0), angle=float(np.pi / 3), direction=-1)]
    angle, found = angle_and_rate(end_of(system, rotor(rate), end, events=events))
    # the cosine of the angle of an event is that of a double, to rounding: the event's own formula
    cosine = mpf(float(np.cos(np.pi / 3)))
    passage = min((mpmath.acos(c) for c in (cosine,)), key=abs) / mpf(rate)
    assert found == 1
    assert abs(angle - (mpf(rate) * passage + (4 - passage))) < mpf(10) ** -15


class Sampling(pt.Torque):
    """A torque against the rate."""

    gain: float

    def torque(self, instant):
        return fn.Vector((0.0, 0.0, -self.gain * instant.omega_body[2]))


def test_sampled_laws():
    period, gain, rate = 0.25, 0.7, 0.875
    system = pt.System(ROTOR, pt.control.Sampled(Sampling(gain), period))
    w, theta = mpf(rate), mpf(0)
    for _ in range(8):
        a = -mpf(gain) * w / INERTIA
        theta, w = theta + w * mpf(period) + a * mpf(period) ** 2 / 2, w + a * mpf(period)
    start = system.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    variables = end_of(system, start, 2.0)
    angle, found = angle_and_rate(variables)
    assert abs(found - w) < 16 * UNIT
    assert abs(angle - theta) < 32 * UNIT


class Third(pt.Torque):
    """A torque of a third of the rate: the constant has all digits."""

    def torque(self, instant):
        return fn.Vector((0.0, 0.0, -instant.omega_body[2] / 3))


def test_constants_have_all_digits():
    _, found = angle_and_rate(end_of(pt.System(ROTOR, Third()), rotor(1.0), 2.0))
    assert abs(found - mpmath.exp(-mpf(2) / 9)) < 8 * UNIT


FORMULAS = {
    "sqrt": (lambda t: fn.sqrt(t), lambda t: 2 * t * mpmath.sqrt(t) / 3),
    "exp": (lambda t: fn.exp(-t), lambda t: -mpmath.exp(-t)),
    "log": (lambda t: fn.log(t), lambda t: t * mpmath.log(t) - t),
    "sin": (lambda t: fn.sin(t), lambda t: -mpmath.cos(t)),
    "cos": (lambda t: fn.cos(t), mpmath.sin),
    "tan": (lambda t: fn.tan(t / 2), lambda t: -2 * mpmath.log(mpmath.cos(t / 2))),
    "tanh": (lambda t: fn.tanh(t), lambda t: mpmath.log(mpmath.cosh(t))),
    "asin": (lambda t: fn.asin(t / 4), lambda t: t * mpmath.asin(t / 4) + mpmath.sqrt(16 - t * t)),
    "acos": (lambda t: fn.acos(t / 4), lambda t: t * mpmath.acos(t / 4) - mpmath.sqrt(16 - t * t)),
    "atan": (lambda t: fn.atan(t), lambda t: t * mpmath.atan(t) - mpmath.log(1 + t * t) / 2),
    "atan2": (lambda t: fn.atan2(t, 2.0), lambda t: t * mpmath.atan(t / 2) - mpmath.log(4 + t * t)),
    "pow": (lambda t: t**2.25, lambda t: t ** mpf(3.25) / mpf(3.25)),
    "power of a root": (lambda t: t**-1.5, lambda t: -2 / mpmath.sqrt(t)),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_series_of_elementary_functions(name):
    formula, integral = FORMULAS[name]

    class Of(pt.Torque):
        """A torque that is a function of the time."""

        def torque(self, instant):
            return fn.Vector((0.0, 0.0, formula(instant.time)))

    _, found = angle_and_rate(end_of(pt.System(ROTOR, Of()), rotor(0.0, time=1.0), 2.5))
    expected = (integral(mpf(2.5)) - integral(mpf(1.0))) / INERTIA
    assert abs(found - expected) < 24 * UNIT


def test_keplers_equation_on_the_way():
    """The torque is the distance on an ellipse: its integral over the mean anomaly is elementary in E."""
    e, start, end = 0.3, 0.5, 3.0

    class Distance(pt.Torque):
        """A torque that is 1 - e cos E at the mean anomaly t."""

        def torque(self, instant):
            E = fn.eccentric_anomaly(e, instant.time)
            return fn.Vector((0.0, 0.0, 1.0 - e * fn.cos(E)))

    def integral(mean):
        E = mpmath.findroot(lambda x: x - mpf(e) * mpmath.sin(x) - mean, mean)
        c = mpf(e)  # (1 - e cos E)^2 dE
        return E * (1 + c * c / 2) - 2 * c * mpmath.sin(E) + c * c * mpmath.sin(2 * E) / 4

    _, found = angle_and_rate(end_of(pt.System(ROTOR, Distance()), rotor(0.0, time=start), end))
    assert abs(found - (integral(mpf(end)) - integral(mpf(start))) / INERTIA) < 24 * UNIT
