"""diffrax, Dopri8 with adaptive steps, jitted, in double precision."""

import functools

import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)

import diffrax  # noqa: E402

from benchmarks.problems import ellipse  # noqa: E402

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14)
SHORT_LEVELS = (1e-12,)
MOST_STEPS = 1_000_000


def _to_body(q, x):
    v = q[1:]
    return x + 2 * jnp.cross(v, jnp.cross(v, x) - q[0] * x)


def _free(_problem):
    return lambda _t, _q: jnp.zeros(3)


def _top(problem):
    center, down = jnp.array([1.0, 0.0, 0.0]), jnp.array([0.0, 0.0, -problem.weight])
    return lambda _t, q: jnp.cross(center, _to_body(q, down))


def _satellite(problem):
    o, moments = ellipse(), jnp.array(problem.moments)
    P, L = o.a * jnp.array(o.to_periapsis), o.a * jnp.sqrt(1 - o.e**2) * jnp.array(o.to_latus_rectum)

    def torque(t, q):
        M = o.mean_motion * t
        E = M + o.e * jnp.sin(M)
        for _ in range(4):  # quadratic from e^2 / 2: enough for e = 0.2
            E = E - (E - o.e * jnp.sin(E) - M) / (1 - o.e * jnp.cos(E))
        x = P * (jnp.cos(E) - o.e) + L * jnp.sin(E)
        r = jnp.sqrt(x @ x)
        u = _to_body(q, x / r)
        return 3 * o.mu / r**3 * jnp.cross(u, moments * u)

    return torque


@functools.cache
def _solver(problem):
    moments = jnp.array(problem.moments)
    torque = {"free": _free, "top": _top, "satellite": _satellite}[problem.kind](problem)

    def rates(t, y, _args):
        q, w = y[:4], y[4:]
        q_dot = 0.5 * jnp.concatenate([-(q[1:] @ w)[None], q[0] * w + jnp.cross(q[1:], w)])
        return jnp.concatenate([q_dot, (torque(t, q) - jnp.cross(w, moments * w)) / moments])

    @jax.jit
    def solve(start, tolerance):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(rates),
            diffrax.Dopri8(),
            0.0,
            problem.end,
            None,
            start,
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * problem.smallest),
            saveat=diffrax.SaveAt(t1=True),
            max_steps=MOST_STEPS,
        ).ys[-1, :4]

    return solve


def prepare(problem, level):
    """Return one integration at a relative and absolute tolerance."""
    solve, start = _solver(problem), jnp.array(problem.initial)
    return lambda: (solve(start, level).block_until_ready(), problem.end)
