"""Rounding moves q off the unit sphere; what a kernel keeps there too does not drift."""

import heyoka as hy
import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from poinsot.functions import Vector

MOMENTS = (0.9, 1.7, 1.3)
WEIGHT, CENTER = 0.8, (0.3, -0.2, 0.5)
BODY = pt.Body(MOMENTS)
CIRCLE = pt.KeplerOrbit(
    1.1,
    semimajor_axis=1.2,
    eccentricity=0.0,
    inclination=0.7,
    node=-0.4,
    argument_of_periapsis=1.9,
    true_anomaly=0.3,
    epoch=0.2,
)
FORMULATIONS = ("lie_poisson", "canonical")


# ---------------------------------------------------------------------- the vector field, by quaternion products alone


def hamilton(p, q):
    p0, p1, p2, p3 = p
    q0, q1, q2, q3 = q
    return [
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    ]


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


def to_body(q, x):
    return hamilton(conjugate(q), hamilton([0, *x], q))[1:]


def conserved_by(formulation, potential, along):
    """Energy and momentum along an axis: of (q, Q) it is T + |q|^2 V, for their g changes by |q|^2 times the torque."""

    def of(variables):
        q, momenta = variables[:4], variables[4:]
        size = sum(x * x for x in q)
        canonical = formulation == "canonical"
        g = [x / 2 for x in hamilton(conjugate(q), momenta)[1:]] if canonical else momenta
        kinetic = sum(x * x / moment for x, moment in zip(g, MOMENTS, strict=True)) / 2
        momentum = sum(x * y for x, y in zip(to_body(q, along), g, strict=True))
        return kinetic + potential(q) * (size if canonical else 1), momentum

    return of


def top(q):
    return WEIGHT * sum(c * u for c, u in zip(CENTER, to_body(q, (0, 0, 1)), strict=True))


def gradient(q):
    """U = 3 mu J / (2 r^3), to the attractor at (0.6, 0, -0.8) r, r = 1/2."""
    n = to_body(q, (0.6, 0, -0.8))
    return 1.5 * 0.4 * 8 * sum(moment * x * x for moment, x in zip(MOMENTS, n, strict=True))


FIELDS = {
    "top": (pt.UniformGravity(WEIGHT, CENTER), top, (0, 0, 1)),
    "gradient": (pt.GravityGradient(pt.orbits.FixedPosition(0.4, position=(0.3, 0, -0.4))), gradient, (0.6, 0, -0.8)),
}


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("size", [1.0, 0.8, 1.3])
def test_the_equations_keep_energy_and_momentum_at_any_norm(name, formulation, size):
    force, potential, along = FIELDS[name]
    with mpmath.workdps(40):
        system = pt.System(BODY, force)
        exact = formulas.copied(system, (mpmath.mpf(float(x)) for x in system.dynamics.numbers))
        turn = Rotation.random(rng=np.random.default_rng(3)).as_quat()
        q = [mpmath.mpf(size * x) for x in turn]
        g = [mpmath.mpf(x) for x in (0.3, -0.7, 0.4)]
        canonical = [2 * x for x in hamilton(q, [0, *g])]
        variables = [*q, *(canonical if formulation == "canonical" else g)]
        rates = formulas.rates(exact, formulation, Vector(variables), mpmath.mpf(0))
        moved = conserved_by(formulation, potential, along)
        step = mpmath.mpf(10) ** -12
        ahead, behind = (
            moved([x + side * step * rate for x, rate in zip(variables, rates, strict=True)]) for side in (1, -1)
        )
        slopes = [abs(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
        assert max(slopes) < 1e-14  # rounding of the system's numbers; the difference errs by step^2
        still = moved([x + step * (k == 1) for k, x in enumerate(variables)])
        assert abs(still[0] - moved(variables)[0]) > 1e-2 * step


# ---------------------------------------------------------------------- drift, compared with a script


def script_of_a_top():
    """A heavy top in (q, omega), typed out; its parameters are moments, weight times centre of mass."""
    *q, x, y, z = hy.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    A, B, C, c1, c2, c3 = (hy.par[i] for i in range(6))
    u1, u2, u3 = up(q)
    return by_hand(
        (*q, x, y, z),
        ((B - C) * y * z + u2 * c3 - u3 * c2) / A,
        ((C - A) * z * x + u3 * c1 - u1 * c3) / B,
        ((A - B) * x * y + u1 * c2 - u2 * c1) / C,
    )


def script_of_a_satellite():
    """A satellite in (q, omega) along the axes of its circle; its parameters are moments, 3 n^2 and n."""
    *q, x, y, z = hy.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    A, B, C, K, n = (hy.par[i] for i in range(5))
    u1, u2, u3 = outwards(q)
    *turning, x_, y_, z_ = by_hand(
        (*q, x, y, z),
        (B - C) * (y * z - K * u2 * u3) / A,
        (C - A) * (z * x - K * u3 * u1) / B,
        (A - B) * (x * y - K * u1 * u2) / C,
    )
    around = [0.5 * n * dq for dq in (q[3], q[2], -q[1], -q[0])]
    return [*((v, rate + turn) for (v, rate), turn in zip(turning, around, strict=True)), x_, y_, z_]


def outwards(q):
    q0, q1, q2, q3 = q
    return q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)


def up(q):
    q0, q1, q2, q3 = q
    return 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3


def by_hand(variables, *accelerations):
    q0, q1, q2, q3, x, y, z = variables
    turning = (
        0.5 * (-q1 * x - q2 * y - q3 * z),
        0.5 * (q0 * x + q2 * z - q3 * y),
        0.5 * (q0 * y + q3 * x - q1 * z),
        0.5 * (q0 * z + q1 * y - q2 * x),
    )
    return list(zip(variables, (*turning, *accelerations), strict=True))


def compiled(equations):
    return hy.taylor_adaptive(equations, np.zeros(7))


def grid_by_hand(integrator, start, numbers, times):
    integrator.time, integrator.state[:] = 0.0, start
    integrator.pars[:] = numbers
    return integrator.propagate_grid(times)[-1]


def drift_of(values, sizes):
    return np.max(np.abs(values - values[0])) / np.max(sizes)


def tops(times, count):
    """The largest drifts of energy and vertical momentum of random tops, by hand and by formulation."""
    integrator, random = compiled(script_of_a_top()), np.random.default_rng(14)
    out = {name: [] for name in ("by hand", *FORMULATIONS)}
    for k in range(count):
        moments, lever, q, omega = drawn(random) if k else (MOMENTS, CENTER, (0.6, 0.48, 0.64, 0), (0.3, -0.5, 0.7))
        arm = WEIGHT * np.array(lever)
        rows = grid_by_hand(integrator, [*q, *omega], [*moments, *arm], times)
        u, g = np.stack(up(rows[:, :4].T), axis=-1), rows[:, 4:] * moments
        T, U = 0.5 * np.sum(rows[:, 4:] * g, axis=-1), u @ arm
        vertical = drift_of(np.sum(u * g, axis=-1), np.linalg.norm(g, axis=-1))
        out["by hand"].append((drift_of(T + U, np.abs(T) + np.abs(U)), vertical))
        body = pt.Body(moments)
        system, start = pt.System(body, pt.UniformGravity(WEIGHT, lever)), body.state(q, omega_body=omega)
        for name in FORMULATIONS:
            drift = pt.propagate(system, start, times, formulation=name).drift
            out[name].append([np.max(np.abs(drift[key])) for key in ("energy", "angular_momentum_space_3")])
    return {name: np.array(drifts) for name, drifts in out.items()}


def satellites(times, count):
    """The same of the Jacobi integral on circular orbits; poinsot integrates along comoving axes."""
    integrator, random, n = compiled(script_of_a_satellite()), np.random.default_rng(15), 0.7
    orbit = pt.KeplerOrbit(n * n, semimajor_axis=1.0, eccentricity=0.0)
    out = {name: [] for name in ("by hand", *FORMULATIONS)}
    for _ in range(count):
        moments, _, q, omega = drawn(random)
        rows = grid_by_hand(integrator, [*q, *omega], [*moments, 3 * n * n, n], times)
        radial, normal = (np.stack(vector(rows[:, :4].T), axis=-1) for vector in (outwards, up))
        g = rows[:, 4:] * moments
        T, U = 0.5 * np.sum(rows[:, 4:] * g, axis=-1), 1.5 * n * n * (radial * radial) @ moments
        jacobi = T + U - n * np.sum(normal * g, axis=-1)
        out["by hand"].append([drift_of(jacobi, np.abs(T) + np.abs(U))])
        body = pt.Body(moments)
        system, start = pt.System(body, pt.GravityGradient(orbit)), body.state(q, omega_body=omega)
        for name in FORMULATIONS:
            drift = pt.propagate(system, start, times, formulation=name).drift
            out[name].append([np.max(np.abs(drift["jacobi_energy"]))])
    return {name: np.array(drifts) for name, drifts in out.items()}


def drawn(random):
    a, b, c = random.uniform(0.1, 1.0, 3)
    q = random.normal(size=4)
    return (b + c, a + c, a + b), random.uniform(-0.7, 0.7, 3), q / np.linalg.norm(q), random.uniform(-0.8, 0.8, 3)


def ratios(drifts):
    """Root mean squares over the motions: one drift is a random walk, whose end says little."""
    rms = {name: np.sqrt(np.mean(values**2, axis=0)) for name, values in drifts.items()}
    return {name: rms[name] / rms["by hand"] for name in FORMULATIONS}


@pytest.mark.parametrize("motions", [tops, satellites])
def test_drift_is_that_of_a_script(motions):
    for ratio in ratios(motions(np.linspace(0, 3000, 301), 8)).values():
        assert np.all(ratio < 3)


@pytest.mark.slow
@pytest.mark.parametrize("motions", [tops, satellites])
def test_drift_of_long_runs_is_that_of_a_script(motions):
    for ratio in ratios(motions(np.linspace(0, 2e4, 2001), 24)).values():
        assert np.all(ratio < 3)
