"""State transition where torques switch: a rotor in closed form, differences of motions by SciPy, and Monte Carlo."""

from functools import cache

import numpy as np
import pytest
import sympy

import poinsot as pt
from poinsot import functions as fn
from poinsot.engine import looped_kernel


@pytest.fixture(params=["looped", "heyoka"])
def kernel(request, monkeypatch):
    """Run on either kernel."""
    if request.param == "heyoka":
        monkeypatch.setattr(looped_kernel, "available", lambda: False)
    return request.param


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
def test_a_rotor_that_a_thruster_turns_back(formulation, order, kernel):
    body, times = pt.Body((2.0, 3.0, INERTIA)), np.array([5.0, 9.0, 31.0])
    start = body.state((np.cos(ANGLE / 2), 0, 0, np.sin(ANGLE / 2)), omega_body=(0, 0, RATE))
    system = pt.System(body, Rotor(SIZE))
    found = pt.analysis.state_transition(system, start, times, ["size"], order=order, formulation=formulation)
    assert found.motion.run.kernel == kernel
    places = [i for i, name in enumerate(found.coordinates) if name.endswith("3")]
    columns = [*places, len(found.coordinates)]
    for i, time in enumerate(times):
        end, first, second = map(np.array, expected(time))
        angle = 2 * np.arctan2(found.motion.quaternion[i, 3], found.motion.quaternion[i, 0])
        assert abs(angle - end[0, 0]) < 1e-13
        own = np.concatenate([found.matrix[i], found.sensitivity[i]], axis=-1)
        np.testing.assert_allclose(own[np.ix_(places, columns)], first, rtol=0, atol=1e-12 * np.max(np.abs(first)))
        if order == 1:
            continue
        bent = found.second[i][np.ix_(places, columns, columns)]
        np.testing.assert_allclose(bent, second, rtol=0, atol=1e-12 * np.max(np.abs(second)))
