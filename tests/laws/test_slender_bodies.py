"""A body with one small moment: every row of every kind of run has the rates of Euler's equations to rounding.

Q mixes the components of g, so that the rate about the axis of the small moment loses the digits of the ratio of the
moments wherever g is made of q and Q: 1e-10 at a ratio of 1e-6.
"""

import copy
import functools
import pickle

import numpy as np
import pytest
from mpmath import mp, mpf

import poinsot as pt
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.problem import Problem

EPS = np.finfo(float).eps
RATIOS = (1e-3, 1e-6, 1e-9)
TIMES = np.array([-2.0, 0.0, 1.0, 2.5, 5.0])
ATTITUDE, RATES = (0.6, 0.0, 0.8, 0.0), np.array([0.3, -0.2, 0.5])
ORBIT = pt.KeplerOrbit(
    1.0,
    semimajor_axis=4.0,
    eccentricity=0.2,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=0.3,
    epoch=0.0,
)

SHAPES = {
    "symmetric": lambda r: (r, 1.0, 1.0),
    "triaxial": lambda r: (1.0, r, 1.0 - 0.8 * r),
}

ROWS = 12 * EPS
"""Of the largest rate: three times the worst of 20 starts shaken by an ulp, with 2, 4 and 8 lanes."""

FIRST = 2 * EPS
"""I omega, 1 / I and their product are rounded."""


class Central(pt.Potential):
    """It turns nothing, and has the attitude carried along by the orbit."""

    orbit: pt.Orbit

    def energy(self, instant):
        return -0.1 * instant.inverse_distance(self.orbit)


class Same(pt.events.AtTime):
    """An action that leaves the state as it is."""

    def act(self, body, state):  # noqa: ARG002
        return state


@functools.cache
def reference(shape, ratio):
    """The rates at the times by Euler's equations in 25 digits."""
    with mp.workdps(25):
        a, b, c = map(mpf, SHAPES[shape](ratio))

        def rates(_, w):
            return [(b - c) * w[1] * w[2] / a, (c - a) * w[2] * w[0] / b, (a - b) * w[0] * w[1] / c]

        def back(t, w):
            return [-x for x in rates(t, w)]

        start = list(map(mpf, RATES.tolist()))
        later, earlier = mp.odefun(rates, 0, start), mp.odefun(back, 0, start)
        return np.array([[float(x) for x in (later(t) if t >= 0 else earlier(-t))] for t in TIMES.tolist()])


def start(body):
    return body.state(ATTITUDE, omega_body=RATES)


def members(body):
    return body.state(np.tile(ATTITUDE, (5, 1)), omega_body=RATES)


def free(body):
    return pt.System(body)


def along(body):
    return pt.System(body, Central(ORBIT))


def run(system, **options):
    return pt.propagate(system, start(system.body), TIMES, **options)


def rates(body, state):
    return pt.System(body).omega_body(state)


def many(body, folder):  # noqa: ARG001
    bodies = pt.Body(np.tile(body.moments, (5, 1)))
    return pt.propagate(pt.System(bodies), bodies.state(ATTITUDE, omega_body=RATES), TIMES).omega_body


def crossed(body, folder):  # noqa: ARG001
    motion = run(along(body), events=[pt.events.AtTime(time) for time in TIMES[TIMES != 0]])
    found = [each.member(0) for each in motion.events]
    return np.insert([rates(body, each.states)[0] for each in found], 1, rates(body, motion.initial), axis=0)


def acted(body, folder):  # noqa: ARG001
    return run(along(body), events=[Same(time) for time in TIMES[TIMES != 0] - 0.1]).omega_body


def resumed(body, folder):  # noqa: ARG001
    motion = run(free(body), dense=True)
    starts = [motion(max(time - 0.5, TIMES[0])) for time in TIMES]
    return np.concatenate([pt.propagate(free(body), s, [t]).omega_body for s, t in zip(starts, TIMES, strict=True)])


def saved(suffix, system):
    def way(body, folder):
        motion = run(system(body))
        back = pt.load(pt.save(motion, folder / f"motion.{suffix}"))
        assert back.omega_body.tobytes() == motion.omega_body.tobytes()
        assert back.conjugate_momenta.tobytes() == motion.conjugate_momenta.tobytes()
        again = pt.propagate(back.system, back.initial, back.times)
        assert again.omega_body.tobytes() == motion.omega_body.tobytes()
        return pt.load(back.dataset).omega_body

    return way


KINDS = {
    "one body": lambda body, _: run(free(body)).omega_body,
    "backwards": lambda body, _: pt.propagate(free(body), start(body), TIMES[::-1]).omega_body[::-1],
    "dense": lambda body, _: run(free(body), dense=True).omega_body,
    "called": lambda body, _: rates(body, run(free(body), dense=True)(TIMES)),
    "quadruple": lambda body, _: run(free(body), precision="quadruple").omega_body,
    "ensemble": lambda body, _: pt.propagate(free(body), members(body), TIMES).omega_body,
    "ensemble of bodies": many,
    "along an orbit": lambda body, _: run(along(body)).omega_body,
    "dense, along an orbit": lambda body, _: rates(body, run(along(body), dense=True)(TIMES)),
    "ensemble, along an orbit": lambda body, _: pt.propagate(along(body), members(body), TIMES).omega_body,
    "events": crossed,
    "actions": acted,
    "resumed": resumed,
    "neighbours": lambda body, _: pt.analysis.state_transition(along(body), start(body), TIMES).motion.omega_body,
    "relative": lambda body, _: run(free(body)).relative_to(pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0))).omega_body,
    "pickled": lambda body, _: pickle.loads(pickle.dumps(run(along(body)))).omega_body,
    "copied": lambda body, _: copy.deepcopy(run(free(body))).omega_body,
    "NetCDF": saved("nc", free),
    "Zarr": saved("zarr", free),
    "closed form": lambda body, _: pt.free_motion(body, start(body), TIMES).omega_body,
    "closed form, called": lambda body, _: rates(body, pt.free_motion(body, start(body), [0.0])(TIMES)),
    "closed form, ensemble": lambda body, _: pt.free_motion(body, members(body), TIMES).omega_body,
}


COMPUTED_START = {"resumed", "closed form", "closed form, called", "closed form, ensemble"}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_those_of_eulers_equations(kind, ratio, shape, tmp_path):
    found = KINDS[kind](pt.Body(SHAPES[shape](ratio)), tmp_path)
    assert np.max(np.abs(found - reference(shape, ratio))) < ROWS * np.max(np.abs(RATES))
    if kind not in COMPUTED_START:
        assert np.all(np.abs(found[..., 1, :] - RATES) <= FIRST * np.abs(RATES))


def test_the_attitude_is_carried_along_by_the_orbit():
    body = pt.Body((1e-6, 1.0, 1.0))
    assert equations.state_vector(Problem(along(body)), start(body), FORMULATIONS["lie_poisson"], "double").comoving


@pytest.mark.parametrize("formulation", ["canonical", "euler_angles"])
@pytest.mark.parametrize("ratio", RATIOS)
def test_variables_without_g_lose_the_digits_of_the_ratio(ratio, formulation):
    """They do not hold the small component: what `propagate` says of them."""
    motion = run(free(pt.Body((ratio, 1.0, 1.0))), formulation=formulation)
    lost = np.max(np.abs(motion.omega_body - reference("symmetric", ratio))) * ratio / EPS
    assert 0.1 < lost < 1000
