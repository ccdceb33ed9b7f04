"""heyoka by hand: the equations typed out, numbers as literals, `propagate_until`.

Which way of writing the equations is the fastest depends on the processor: each problem is written in several ways, and
`fastest` finds the one that counts. Some have the half of omega for variables, which saves the kinematics a factor.
"""

import dataclasses
import functools
import time
from collections.abc import Callable

import heyoka as hy
import numpy as np

from benchmarks.problems import NAMED, PERIOD, ellipse
from poinsot.algebra import quaternion as quat

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, None)
SHORT_LEVELS = (1e-8, 1e-12, None)
LANES, EPSILON = 8, float(np.finfo(float).eps)
"""Number of lanes of a batch, and the default tolerance of the engine."""


@dataclasses.dataclass(frozen=True)
class Writing:
    """One way to write the equations of a problem, in q and a share of omega.

    `rates` gives the derivatives of the share of omega; `axes` is the attitude of the axes that q refers to.
    """

    rates: Callable
    share: float
    axes: tuple[float, ...] | None = None

    def system(self, problem):
        """Return the differential equations."""
        q = q0, q1, q2, q3 = hy.make_vars("q0", "q1", "q2", "q3")
        w = w1, w2, w3 = hy.make_vars("w1", "w2", "w3")
        factor = 0.5 / self.share
        kinematics = [
            (q0, factor * (-q1 * w1 - q2 * w2 - q3 * w3)),
            (q1, factor * (q0 * w1 + q2 * w3 - q3 * w2)),
            (q2, factor * (q0 * w2 + q3 * w1 - q1 * w3)),
            (q3, factor * (q0 * w3 + q1 * w2 - q2 * w1)),
        ]
        return kinematics + list(zip(w, self.rates(problem, q, w, self.share), strict=True))

    def start(self, initial):
        """Return (q, omega), shape (..., 7), in these variables."""
        q = initial[..., :4]
        if self.axes:
            q = quat.product(quat.conjugate(np.array(self.axes)), q)
        return np.concatenate([q, self.share * initial[..., 4:]], axis=-1)

    def attitude(self, q):
        """Return the quaternion that these variables stand for."""
        return quat.product(np.array(self.axes), q) if self.axes else np.array(q)


def free(problem, _q, w, share):
    """Return the rates of a free body."""
    (A, B, C), (w1, w2, w3) = problem.moments, w
    return (B - C) / (A * share) * (w2 * w3), (C - A) / (B * share) * (w3 * w1), (A - B) / (C * share) * (w1 * w2)


def top(problem, q, w, share):
    """Return the rates of the top; the third axis of space in the body is homogeneous in q."""
    q0, q1, q2, q3 = q
    return _top(problem, q, w, share, q0**2 + q3**2 - q1**2 - q2**2)


def top_on_the_sphere(problem, q, w, share):
    """Return the rates of the top with |q| = 1 in the attitude: less work, but the energy drifts with |q|."""
    _, q1, q2, _ = q
    return _top(problem, q, w, share, 1 - 2 * (q1**2 + q2**2))


def _top(problem, q, w, share, s3):
    (_, B, C), (q0, q1, q2, q3), weight = problem.moments, q, share * problem.weight
    x, y, z = free(problem, q, w, share)
    return x, y + weight / B * s3, z - 2 * weight / C * (q0 * q1 + q2 * q3)


def satellite(problem, q, w, share):
    """Return the rates of the satellite, its position in the axes of space."""
    o = ellipse()
    x, y, r = _on_the_ellipse(o)
    position = [x * P + y * L for P, L in zip(o.to_periapsis, o.to_latus_rectum, strict=True)]
    return _satellite(problem, q, w, share, position, r)


def satellite_in_the_plane(problem, q, w, share):
    """Return the rates of the satellite, its position in axes along the orbit's own: two components."""
    x, y, r = _on_the_ellipse(ellipse())
    return _satellite(problem, q, w, share, (x, y), r)


def _on_the_ellipse(o):
    """Return position and distance over the semimajor axis, from Kepler's equation."""
    E = hy.kepE(o.e, o.mean_motion * hy.time)
    c, s = hy.cos(E), hy.sin(E)
    return c - o.e, np.sqrt(1 - o.e * o.e) * s, 1 - o.e * c


def _satellite(problem, q, w, share, position, r):
    (A, B, C), (q0, q1, q2, q3), (w1, w2, w3) = problem.moments, q, w
    to_body = [
        [q0**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 + q0 * q3), 2 * (q1 * q3 - q0 * q2)],
        [2 * (q1 * q2 - q0 * q3), q0**2 - q1**2 + q2**2 - q3**2, 2 * (q2 * q3 + q0 * q1)],
        [2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1), q0**2 - q1**2 - q2**2 + q3**2],
    ]
    u1, u2, u3 = (sum(row[k] * x for k, x in enumerate(position)) for row in to_body)
    K = 3 * (share * ellipse().mean_motion) ** 2 * r**-5.0
    return (
        (B - C) / (A * share) * (w2 * w3 - K * u2 * u3),
        (C - A) / (B * share) * (w3 * w1 - K * u3 * u1),
        (A - B) / (C * share) * (w1 * w2 - K * u1 * u2),
    )


WRITINGS = {
    "free": {"omega": Writing(free, 1.0), "omega/2": Writing(free, 0.5)},
    "top": {
        "omega": Writing(top, 1.0),
        "omega/2": Writing(top, 0.5),
        "omega/2, attitude on the unit sphere": Writing(top_on_the_sphere, 0.5),
    },
    "satellite": {
        "omega": Writing(satellite, 1.0),
        "omega/2": Writing(satellite, 0.5),
        "omega/2, axes of the orbit": Writing(satellite_in_the_plane, 0.5, ellipse().axes),
    },
}


@functools.cache
def integrator(key, name, level):
    """Return the integrator of a problem by its key, in a writing, at a tolerance."""
    options = {} if level is None else {"tol": level}
    problem = NAMED[key]
    return hy.taylor_adaptive(WRITINGS[problem.kind][name].system(problem), np.zeros(7), **options)


@functools.cache
def _batch(key, name, level):
    problem = NAMED[key]
    return hy.taylor_adaptive_batch(WRITINGS[problem.kind][name].system(problem), np.zeros((7, LANES)), tol=level)


@functools.cache
def fastest(key, batches_at=None):
    """Return the writing of a problem that takes the least time, of one body or of batches at that tolerance."""
    problem = dataclasses.replace(NAMED[key], end=min(NAMED[key].end, 10 * PERIOD))
    if batches_at is None:
        runs = {name: prepare(problem, None, name) for name in WRITINGS[problem.kind]}
    else:
        starts = np.tile(problem.initial, (LANES, 1))
        runs = {name: prepare_batches(problem, starts, batches_at, name) for name in WRITINGS[problem.kind]}
    rounds = [{name: _seconds(run) for name, run in runs.items()} for _ in range(15)]
    return min(runs, key=lambda name: min(times[name] for times in rounds))


def _seconds(run):
    began = time.process_time()
    run()
    return time.process_time() - began


def prepare(problem, level, name=None):
    """Return one propagation with an integrator that is there already, in the fastest writing if none is given."""
    name = name or fastest(problem.key)
    ta, writing = integrator(problem.key, name, level), WRITINGS[problem.kind][name]
    start = writing.start(problem.initial)

    def run():
        ta.time = 0.0
        ta.state[:] = start
        ta.propagate_until(problem.end)
        return writing.attitude(ta.state[:4]), problem.end

    return run


def prepare_batches(problem, starts, level, name=None):
    """Return a run of one thread over starts (members, 7), a multiple of the lanes, one batch after another."""
    name = name or fastest(problem.key, level)
    ta, writing = _batch(problem.key, name, level), WRITINGS[problem.kind][name]
    own = writing.start(starts).T.copy()

    def run():
        q = np.empty((4, len(starts)))
        for i in range(0, len(starts), LANES):
            ta.set_time(0.0)
            ta.state[:] = own[:, i : i + LANES]
            ta.propagate_until(problem.end)
            q[:, i : i + LANES] = ta.state[:4]
        return writing.attitude(q.T)

    return run


def prepare_variational(problem, name=None):
    """Return one propagation with its variational equations, which are compiled in compact mode."""
    writing = WRITINGS[problem.kind][name or fastest(problem.key)]
    equations = hy.var_ode_sys(writing.system(problem), hy.var_args.vars, order=1)
    ta = hy.taylor_adaptive(equations, np.zeros(7), compact_mode=True)
    start = np.concatenate([writing.start(problem.initial), np.eye(7).ravel()])

    def run():
        ta.time = 0.0
        ta.state[:] = start
        ta.propagate_until(problem.end)
        return writing.attitude(ta.state[:4]), problem.end

    return run


def energy_drift_of_top(problem, times, name):
    """Return the largest change of the energy over that of |T| + |U|."""
    ta, writing = integrator(problem.key, name, None), WRITINGS["top"][name]
    ta.time, ta.state[:] = 0.0, writing.start(problem.initial)
    q0, q1, q2, q3, *rates = ta.propagate_grid(times)[-1].T
    T = 0.5 * sum(moment * (w / writing.share) ** 2 for moment, w in zip(problem.moments, rates, strict=True))
    U = problem.weight * 2 * (q1 * q3 - q0 * q2)
    return float(np.max(np.abs(T + U - T[0] - U[0])) / np.max(np.abs(T) + np.abs(U)))
