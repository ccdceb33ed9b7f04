"""State transition where torques switch: a rotor in closed form, differences of motions by SciPy, and Monte Carlo."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions as fn

# ---------------------------------------------------------------------- one axis, in closed form


class Rotor(pt.Torque):
    """A torque about the third axis against the sign of the angle: theta'' = -a sign(theta)."""

    size: float

    def torque(self, instant):
        _, sine, _ = instant.attitude.to_body((-1, 0, 0))
        return fn.Vector((0.0, 0.0, self.size * fn.where(fn.less(sine, 0.0), 1.0, -1.0)))


ANGLE, RATE, INERTIA, SIZE = 0.6, 0.03, 4.0, 0.4


@cache
def parabolas():
    """Angle and momentum after n passages, with first and second derivatives by the start and the torque."""
    start = angle, momentum, size = sympy.symbols("angle momentum size", positive=True)
    time, n = sympy.symbols("time n")
    rate, a = momentum / INERTIA, size / INERTIA
    speed = sympy.sqrt(rate**2 + 2 * a * angle)  # at each passage
    since = time - (rate + speed) / a - (n - 1) * 2 * speed / a
    end = (-1) ** n * sympy.Matrix([speed * since - a * since**2 / 2, INERTIA * (speed - a * since)])
    second = [[[sympy.diff(x, p, q) for q in start] for p in start] for x in end]
    return sympy.lambdify([*start, time, n], [end, end.jacobian(start), sympy.Array(second)])


def expected(time):
    a = SIZE / INERTIA
    speed = np.sqrt(RATE**2 + 2 * a * ANGLE)
    n = 1 + int((time - (RATE + speed) / a) // (2 * speed / a))
    return parabolas()(ANGLE, INERTIA * RATE, SIZE, time, n)


@pytest.mark.parametrize(("formulation", "order"), [("planar", 2), ("lie_poisson", 1)])
def test_a_rotor_that_a_thruster_turns_back(formulation, order):
    body, times = pt.Body((2.0, 3.0, INERTIA)), np.array([5.0, 9.0, 31.0])
    start = body.state((np.cos(ANGLE / 2), 0, 0, np.sin(ANGLE / 2)), omega_body=(0, 0, RATE))
    system = pt.System(body, Rotor(SIZE))
    found = pt.analysis.state_transition(system, start, times, ["size"], order=order, formulation=formulation)
    places = [i for i, name in enumerate(found.coordinates) if name.endswith("3")]
    columns = [*places, len(found.coordinates)]
    for i, time in enumerate(times):
        end, first, second = map(np.array, expected(time))
        angle = 2 * np.arctan2(found.motion.quaternion[i, 3], found.motion.quaternion[i, 0])
        assert abs(angle - end[0, 0]) < 1e-13
        own = np.concatenate([found.matrix[i], found.sensitivity[i]], axis=-1)
        np.testing.assert_allclose(own[np.ix_(places, columns)], first, rtol=0, atol=3e-14 * np.max(np.abs(first)))
        if order == 1:
            continue
        bent = found.second[i][np.ix_(places, columns, columns)]
        np.testing.assert_allclose(bent, second, rtol=0, atol=2e-14 * np.max(np.abs(second)))


# ---------------------------------------------------------------------- a tumbling body, by differences of motions

MOMENTS, AXIS = np.array([1.0, 1.3, 1.7]), np.array([0.3, -0.5, 0.4])
STAR, SUN = np.array([0.6, 0.0, 0.8]), np.array([0.8, 0.6, 0.0])
START = Rotation.from_quat((0.1, 0.7, -0.5, 0.5), scalar_first=True), MOMENTS * (0.4, -0.3, 0.6)
TIMES = np.array([2.0, 4.5])
WEIGHTS = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Of central differences that leave out the seventh power of the step."""


class Facing(pt.Torque):
    """A torque that jumps where a body axis passes a level over a plane of space, together with a limited damper."""

    size: float
    level: float
    gain: float
    limit: float

    def torque(self, instant):
        x, _, z = instant.attitude.to_body(tuple(STAR))
        sides = fn.where(fn.less(x, self.level), self.size, -0.5 * self.size) + 0.2 * self.size * fn.sign(z - 0.3 * x)
        return sides * fn.Vector(tuple(AXIS)) - fn.Vector(
            fn.clip(self.gain * w, -self.limit, self.limit) for w in instant.omega_body
        )


def facing(_, R, omega, p, sides):
    x, _, z = R.T @ STAR
    if sides is None:
        w = p["gain"] * omega
        return np.array([x - p["level"], z - 0.3 * x, *(w - p["limit"]), *(w + p["limit"])])
    size = p["size"] * ((1 if sides[0] else -0.5) + 0.2 * (-1 if sides[1] else 1))
    limited = np.where(sides[5:], -p["limit"], np.where(sides[2:5], p["gain"] * omega, p["limit"]))
    return size * AXIS - limited


class Shade(pt.Torque):
    """The pressure of light on an area off the center of mass, outside of a cylinder of shadow."""

    orbit: pt.Orbit
    shadow: float
    size: float

    def torque(self, instant):
        r, s = fn.Vector(instant.position(self.orbit)), fn.Vector(tuple(SUN))
        along = fn.dot(r, s)
        off = fn.dot(r, r) - along * along
        lit = fn.where(fn.less(0.0, along), 1.0, fn.where(fn.less(off, self.shadow**2), 0.0, 1.0))
        return self.size * lit * fn.cross(tuple(AXIS), instant.attitude.to_body(tuple(SUN)))


ORBIT = {"semimajor_axis": 1.0, "eccentricity": 0.2, "inclination": 0.3, "node": 0.4, "argument_of_periapsis": 1.0}


def position(t, a, e):
    mean = t / a**1.5
    E = mean
    for _ in range(60):
        E = mean + e * np.sin(E)
    turn = Rotation.from_euler("ZXZ", [ORBIT[name] for name in ("node", "inclination", "argument_of_periapsis")])
    return turn.apply([a * (np.cos(E) - e), a * np.sqrt(1 - e * e) * np.sin(E), 0.0])


def shade(t, R, _, p, sides):
    if sides is None:
        r = position(t, p["semimajor_axis"], p["eccentricity"])
        return np.array([-(r @ SUN), r @ r - (r @ SUN) ** 2 - p["shadow"] ** 2])
    lit = sides[0] or not sides[1]
    return p["size"] * lit * np.cross(AXIS, R.T @ SUN)


def shaded(**p):
    orbit = pt.KeplerOrbit(1.0, **{**ORBIT, "semimajor_axis": p["semimajor_axis"], "eccentricity": p["eccentricity"]})
    return Shade(orbit, p["shadow"], p["size"])


class Burn(pt.Torque):
    """A thruster between two times, which is weaker where the body turns fast."""

    size: float
    begin: float
    off: float
    most: float

    def torque(self, instant):
        burns = fn.less((instant.time - self.begin) * (instant.time - self.off), 0.0)
        slow = fn.less(instant.omega_body[2], self.most)
        return fn.where(burns, fn.where(slow, self.size, 0.3 * self.size), 0.0) * fn.Vector(tuple(AXIS))


def burn(t, _, omega, p, sides):
    if sides is None:
        return np.array([(t - p["begin"]) * (t - p["off"]), omega[2] - p["most"]])
    return (p["size"] * (1 if sides[1] else 0.3) if sides[0] else 0.0) * AXIS


CASES = {
    "facing": (lambda **p: Facing(**p), facing, {"size": 0.3, "level": 0.1, "gain": 0.4, "limit": 0.15}),
    "shade": (shaded, shade, {"semimajor_axis": 1.0, "eccentricity": 0.2, "shadow": 0.7, "size": 0.3}),
    "burn": (lambda **p: Burn(**p), burn, {"size": 0.4, "begin": 0.7, "off": 4.1, "most": 0.75}),
}


def parts(y):
    return y[:9].reshape(3, 3), y[9:] / MOMENTS


def field(t, y, formula, p, sides):
    R, (wx, wy, wz) = parts(y)
    turned = R @ np.array([(0, -wz, wy), (wz, 0, -wx), (-wy, wx, 0)])
    return np.concatenate([turned.ravel(), np.cross(y[9:], (wx, wy, wz)) + formula(t, *parts(y), p, sides)])


def first_passage(t, y, end, formula, p, sides):
    """Which surface is passed first and when, and the variables there; None and those at the end if none is."""

    def surface(t, y, i):
        return formula(t, *parts(y), p, None)[i]

    def at(t1):
        return solve_ivp(field, (t, t1), y, "DOP853", args=(formula, p, sides), rtol=1e-13, atol=1e-14).y[:, -1]

    events: Any = [lambda t, y, *_, i=i: surface(t, y, i) for i in range(sides.size)]
    for event, side in zip(events, sides, strict=True):
        event.terminal, event.direction = True, 1 if side else -1
    coarse = {"args": (formula, p, sides), "events": events, "rtol": 1e-10, "atol": 1e-11}
    found = solve_ivp(field, (t, end), y, "DOP853", **coarse)
    if found.status == 0:
        return None, end, at(end)
    (i,) = (k for k, times in enumerate(found.t_events) if times.size)
    time = found.t[-1]
    for _ in range(3):
        there = at(time)
        ahead = 1e-6 * field(time, there, formula, p, sides)
        slope = (surface(time + 1e-6, there + ahead, i) - surface(time - 1e-6, there - ahead, i)) / 2e-6
        time -= surface(time, there, i) / slope
    return i, time, at(time)


def by_scipy(formula, x, p):
    """Rotations and angular momenta at the times, integrated anew from each switch; and which these were."""
    t, y = 0.0, np.concatenate([(START[0] * Rotation.from_rotvec(x[:3])).as_matrix().ravel(), START[1] + x[3:]])
    sides, rows, passed = formula(t, *parts(y), p, None) < 0, [], []
    for end in TIMES:
        while t < end:
            i, t, y = first_passage(t, y, end, formula, p, sides)
            if i is not None:
                sides[i] = not sides[i]
                passed.append(i)
        rows.append(y)
    return np.array(rows), passed


def displacement(rows, reference):
    turns = Rotation.from_matrix(reference[:, :9].reshape(-1, 3, 3)).inv() * Rotation.from_matrix(
        rows[:, :9].reshape(-1, 3, 3)
    )
    return np.concatenate([turns.as_rotvec(), rows[:, 9:] - reference[:, 9:]], axis=-1)


@pytest.mark.parametrize(("name", "expected"), [("facing", [2, 1, 0]), ("shade", [1, 0, 1, 1, 0]), ("burn", [0, 1, 0])])
def test_columns_are_differences_of_motions(name, expected):
    """Along three directions. Differences for a step of 1e-3 are good to 2e-12, by the rounding of SciPy's motions."""
    make, formula, numbers = CASES[name]
    system = pt.System(pt.Body(tuple(MOMENTS)), make(**numbers))
    start = system.state(START[0], angular_momentum_body=START[1])
    found = pt.analysis.state_transition(system, start, TIMES, list(numbers))
    reference, passed = by_scipy(formula, np.zeros(6), numbers)
    assert passed == expected

    def end(x):
        own = dict(zip(numbers, np.add([*numbers.values()], x[6:]), strict=True))
        return displacement(by_scipy(formula, x[:6], own)[0], reference)

    columns = np.concatenate([found.matrix, found.sensitivity], axis=-1)
    assert np.all(np.max(np.abs(columns), axis=(0, 1)) > 0.02)
    for direction in np.random.default_rng(5).normal(size=(3, 6 + len(numbers))):
        direction /= np.linalg.norm(direction)
        step = 1e-3 * direction
        change = sum(c * (end(k * step) - end(-k * step)) for k, c in WEIGHTS) / 1e-3
        np.testing.assert_allclose(columns @ direction, change, rtol=0, atol=1e-11 * np.max(np.abs(change)))


# ---------------------------------------------------------------------- second order


class Corner(pt.Torque):
    """A torque with a corner, and one that jumps, on surfaces of attitude, rate and time."""

    size: float

    def torque(self, instant):
        x, y, _ = instant.attitude.to_body(tuple(STAR))
        corner = fn.maximum(0.0, x + 0.3 * y - 0.2 * instant.time)
        jump = fn.where(fn.less(instant.omega_body[1] * y, 0.1), self.size, -self.size)
        return fn.Vector((corner * y, jump, 0.5 * jump + corner))


class Gear(pt.Part):
    """A rotor that is brought to another speed at once where an angle passes a level: the body's rate jumps."""

    spin: float
    level: float
    variables = {"angle": 1}  # noqa: RUF012

    def momentum(self, own, time):
        fast = fn.less(own[0], self.level + 0.1 * time)
        return fn.Vector((fn.where(fast, self.spin, 0.2 * self.spin), 0.0, fn.where(fast, 0.1 * self.spin, self.spin)))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return fn.Vector((0.5 + 0.2 * instant.omega_body[0] + 0.1 * instant.own(self)[0],))


@pytest.mark.slow
def test_second_derivatives_at_jumps_and_corners():
    """Differences of motions leave out the seventh power of the step, up to 2e-10 of it."""
    system = pt.System(pt.Body(tuple(MOMENTS)), Corner(0.3), Gear(0.4, 1.0))

    def start(x):
        attitude = START[0] * Rotation.from_rotvec(x[:3])
        return system.state(attitude, angular_momentum_body=START[1] + x[3:6], gear=[x[6]])

    def end(x):
        motion = pt.propagate(system, start(x), TIMES, precision="quadruple")
        rows = motion.attitude.as_matrix().reshape(-1, 9), motion.angular_momentum_body, motion.own["gear"]
        return np.concatenate(rows, axis=-1)

    found = pt.analysis.state_transition(system, start(np.zeros(7)), TIMES, order=2)
    reference, size = end(np.zeros(7)), 2e-3
    for direction in np.random.default_rng(7).normal(size=(3, 7)):
        direction /= np.linalg.norm(direction)
        total = 0.0
        for k, weight in ((1, 3 / 2), (2, -3 / 20), (3, 1 / 90)):
            for sign in (1, -1):
                total += weight * displacement(end(sign * k * size * direction), reference)
        bent = np.einsum("nijk,j,k->ni", found.second, direction, direction)
        np.testing.assert_allclose(bent, total / size**2, rtol=0, atol=1e-9)


class Flywheel(pt.Part):
    """A rotor in the body that is brought to another axis and speed at a time."""

    time: float

    def momentum(self, own, time):  # noqa: ARG002
        return fn.Vector(fn.where(fn.less(time, self.time), a, b) for a, b in zip(*SPINS, strict=True))


SPINS = np.array([(0.5, -0.2, 0.3), (-0.1, 0.6, 0.2)])


def test_second_derivatives_where_the_rate_of_a_sphere_jumps():
    """In closed form: G = R g is at rest, R' = [G / I] R - R [h / I]. Steps of 0.01 leave 1e-11 in differences."""
    body, switch = pt.Body((INERTIA,) * 3), 1.5
    g, times = np.array([1.6, -1.2, 2.4]), np.array([1.0, 4.0])
    system = pt.System(body, Flywheel(switch))
    found = pt.analysis.state_transition(
        system, system.state(START[0], angular_momentum_body=g), times, ["time"], order=2
    )

    def end(x):
        first, rows = START[0] * Rotation.from_rotvec(x[:3]), []
        momentum = first.apply(g + x[3:6])
        for time in times:
            spins = np.array([min(time, switch + x[6]), max(time - switch - x[6], 0)])[:, None] * SPINS
            turned = Rotation.from_rotvec(time * momentum / INERTIA) * first
            for spin in spins:
                turned *= Rotation.from_rotvec(-spin / INERTIA)
            rows.append([*turned.as_matrix().ravel(), *turned.inv().apply(momentum)])
        return np.array(rows)

    reference, size = end(np.zeros(7)), 1e-2
    for direction in np.random.default_rng(7).normal(size=(3, 7)):
        bent = np.einsum("nijk,j,k->ni", found.second, direction, direction)
        total = sum(
            weight * displacement(end(sign * k * size * direction), reference)
            for k, weight in ((1, 3 / 2), (2, -3 / 20), (3, 1 / 90))
            for sign in (1, -1)
        )
        np.testing.assert_allclose(bent, total / size**2, rtol=0, atol=1e-9)


# ---------------------------------------------------------------------- covariance and Monte Carlo

DRAWN = 200


def in_sunlight(semimajor_axis, pressure):
    earth = pt.KeplerOrbit(3.986004418e14, semimajor_axis=semimajor_axis, eccentricity=0.01, inclination=0.5, node=0.2)
    sun = pt.orbits.FixedPosition(1.32712440018e20, position=(-1.2e11, 0.8e11, -0.3e11))
    box = pt.forces.Facets.from_box((0.1, 0.2, 0.3), (0.01, -0.02, 0.015), specular=0.2, diffuse=0.1)
    light = pt.forces.RadiationPressure(sun, box, [pt.forces.Occulter(earth, 6.378137e6)], pressure=pressure)
    return pt.System(pt.Body((0.02, 0.03, 0.035)), light)


def in_a_cylinder(**numbers):
    return pt.System(pt.Body(tuple(MOMENTS)), shaded(**numbers))


# numbers with their spreads; times, angular velocity, spreads of the start, and a bound
CLOUDS: dict[str, tuple[Any, dict[str, Any], Any]] = {
    "penumbra": (
        in_sunlight,
        {"semimajor_axis": (6.9e6, 300.0), "pressure": (4.54e-6, 5e-9)},
        (np.array([2500.0, 5700.0]), (2e-3, -3e-3, 1e-3), 3e-5, 1e-9, 3e-6),
    ),
    "cylinder": (
        in_a_cylinder,
        {name: (number, 1e-5) for name, number in CASES["shade"][2].items()},
        (TIMES, (0.4, -0.3, 0.6), 1e-5, 1e-5, 5e-9),
    ),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_covariance_through_a_shadow_is_that_of_an_ensemble(name):
    """Draws in opposite pairs have the given covariance exactly; what is left is the second order, squared."""
    make, numbers, (times, rate, of_angles, of_momenta, bound) = CLOUDS[name]
    system = make(**{name: number for name, (number, _) in numbers.items()})
    start = system.state(START[0], omega_body=rate)
    spreads = np.array([*[of_angles] * 3, *[of_momenta] * 3, *(spread for _, spread in numbers.values())])
    found = pt.analysis.state_transition(system, start, times, list(numbers))
    known = found.covariance(np.diag(spreads[:6] ** 2), np.diag(spreads[6:] ** 2))

    half = np.linalg.qr(np.random.default_rng(9).normal(size=(DRAWN // 2, spreads.size)))[0] * np.sqrt(DRAWN / 2)
    draws = np.concatenate([half, -half]) * spreads
    others = make(**{name: numbers[name][0] + draws[:, 6 + i] for i, name in enumerate(numbers)})
    momenta = start.angular_momentum_body + draws[:, 3:6]
    attitudes = START[0] * Rotation.from_rotvec(draws[:, :3])
    cloud = pt.propagate(others, others.state(attitudes, angular_momentum_body=momenta), times)
    for n, attitude in enumerate(found.motion.attitude):
        turns = attitude.inv() * Rotation.from_quat(cloud.quaternion[:, n], scalar_first=True)
        rows = np.hstack([turns.as_rotvec(), cloud.angular_momentum_body[:, n] - found.motion.angular_momentum_body[n]])
        sizes = np.sqrt(np.diagonal(known[n]))
        apart = (rows.T @ rows / DRAWN - known[n]) / np.outer(sizes, sizes)
        assert np.max(np.abs(apart)) < bound
        shares = np.abs(found.sensitivity[n]) * spreads[6:] / sizes[:, None]
        assert np.all(np.max(shares, axis=0) > 0.1)  # each number counts for more than a hundredth of a variance
