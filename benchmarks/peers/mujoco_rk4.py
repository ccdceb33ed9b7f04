"""MuJoCo with its RK4: a free body, a body on a ball joint, a torque from `mjcb_passive`."""

import functools
import math

import mujoco
import numpy as np

from benchmarks.problems import ellipse

SOLVES = ("free", "top", "satellite")
LEVELS = (20_000, 50_000, 100_000, 200_000, 500_000)  # steps
SHORT_LEVELS = (50_000,)
SATELLITE_SHARE = 10  # the satellite turns more slowly, and Python computes its torque: fewer steps
TOP_MASS = 0.05  # only the weight matters; the moments about the fixed point are the paper's


def _body(problem):
    A, B, C = problem.moments
    if problem.kind == "top":
        inertia = f'pos="1 0 0" mass="{TOP_MASS}" diaginertia="{A} {B - TOP_MASS} {C - TOP_MASS}"'
        return f'<joint type="ball"/><inertial {inertia}/>'
    joint = '<joint type="free"/>' if problem.kind == "free" else '<joint type="ball"/>'
    return f'{joint}<inertial pos="0 0 0" mass="1" diaginertia="{A} {B} {C}"/>'


@functools.cache
def _model(problem):
    gravity = problem.weight / TOP_MASS if problem.kind == "top" else 0.0
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="RK4" gravity="0 0 {-gravity!r}"/>'
        f"<worldbody><body>{_body(problem)}</body></worldbody></mujoco>"
    )


def _gravity_gradient(problem):
    A, B, C = problem.moments
    o = ellipse()
    e, b = o.e, o.a * math.sqrt(1 - o.e**2)

    def passive(_model, data):
        M = o.mean_motion * data.time
        E = M + e * math.sin(M)
        for _ in range(20):
            step = (E - e * math.sin(E) - M) / (1 - e * math.cos(E))
            E -= step
            if abs(step) < 1e-15 * max(1.0, abs(E)):
                break
        x, y = o.a * (math.cos(E) - e), b * math.sin(E)
        r = math.hypot(x, y)
        s1, s2, s3 = ((x * P + y * L) / r for P, L in zip(o.to_periapsis, o.to_latus_rectum, strict=True))
        q0, q1, q2, q3 = data.qpos.tolist()
        c1, c2, c3 = q2 * s3 - q3 * s2 - q0 * s1, q3 * s1 - q1 * s3 - q0 * s2, q1 * s2 - q2 * s1 - q0 * s3
        u1, u2, u3 = s1 + 2 * (q2 * c3 - q3 * c2), s2 + 2 * (q3 * c1 - q1 * c3), s3 + 2 * (q1 * c2 - q2 * c1)
        K = 3 * o.mu / r**3
        data.qfrc_passive[:] = K * (C - B) * u2 * u3, K * (A - C) * u3 * u1, K * (B - A) * u1 * u2

    return passive


def prepare(problem, level):
    """Return one simulation of that many steps."""
    model, steps = _model(problem), level
    if problem.kind == "satellite":
        steps //= SATELLITE_SHARE
    model.opt.timestep = problem.end / steps
    data = mujoco.MjData(model)
    data.qpos[-4:], data.qvel[-3:] = problem.initial[:4], problem.initial[4:]
    callback = _gravity_gradient(problem) if problem.kind == "satellite" else None

    def run():
        mujoco.set_mjcb_passive(callback)
        mujoco.mj_step(model, data, nstep=steps)
        mujoco.set_mjcb_passive(None)
        return np.array(data.qpos[-4:]), problem.end

    return run
