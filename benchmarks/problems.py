"""The three problems of the paper, their numbers, and the reference solutions of the benchmarks."""

import functools
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.kinematics.attitude import rotation_angle
from poinsot.validation import paper

PERIOD = float(paper.ORBIT.period)
WIDE = "quadruple"
PAPER_CASES = Path(__file__).parents[1] / "tests" / "oracles" / "paper_cases.json"


@dataclass(frozen=True)
class Problem:
    """A system, a start and an end; the numbers in it for those who write the equations by hand."""

    key: str
    title: str
    kind: str  # "free", "top" or "satellite"
    case: str  # its 42-digit numbers in paper_cases.json
    system: pt.System
    end: float
    start: pt.State = paper.PRINTED_PAIR

    @property
    def moments(self):
        """The principal moments of inertia."""
        return tuple(float(moment) for moment in self.system.body.moments)

    @property
    def weight(self):
        """The weight of the top; its center of mass is at (1, 0, 0)."""
        (force,) = self.system.forces
        assert isinstance(force, pt.UniformGravity)
        return float(force.weight)

    @property
    def initial(self):
        """The start as (q, omega)."""
        return np.concatenate([self.start.quaternion, self.system.omega_body(self.start)])

    @property
    def smallest(self):
        """The size of the smaller of q and omega: what an absolute tolerance must be relative to."""
        return min(1.0, float(np.linalg.norm(self.initial[4:])))


@dataclass(frozen=True)
class Ellipse:
    """A Kepler orbit as a script would hold it; `axes` is the attitude of its perifocal axes."""

    mu: float
    a: float
    e: float
    mean_motion: float
    to_periapsis: tuple
    to_latus_rectum: tuple
    axes: tuple


def ellipse(orbit=paper.ORBIT):
    """Return the numbers of an orbit."""
    i, node, arg = (float(x) for x in (orbit.inclination, orbit.node, orbit.argument_of_periapsis))
    c, s, cn, sn, ci, si = np.cos(arg), np.sin(arg), np.cos(node), np.sin(node), np.cos(i), np.sin(i)
    mu, a = float(orbit.mu), float(orbit.semimajor_axis)
    return Ellipse(
        mu,
        a,
        float(orbit.eccentricity),
        float(np.sqrt(mu / a**3)),
        tuple(map(float, (cn * c - sn * s * ci, sn * c + cn * s * ci, s * si))),
        tuple(map(float, (-cn * s - sn * c * ci, -sn * s + cn * c * ci, c * si))),
        tuple(map(float, quat.product(quat.product(_turn(2, node), _turn(0, i)), _turn(2, arg)))),
    )


def _turn(axis, angle):
    """Return the quaternion of a rotation about an axis of space."""
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)[axis])])


P1 = Problem("P1", "torque-free body to t = 1000", "free", "free|printed_qQ_exact_sqrt2", paper.FREE, 1000.0)
P2 = Problem("P2", "heavy top to t = 1000", "top", "top_corrected|printed_qQ_exact_sqrt2", paper.HEAVY_TOP, 1000.0)
P3 = Problem(
    "P3",
    "satellite on a Kepler orbit over 20 periods",
    "satellite",
    "kepler_consistent|printed_qQ_exact_sqrt2",
    paper.KEPLER,
    20 * PERIOD,
)
PROBLEMS = (P1, P2, P3)
HEAVIER = Problem(
    "heavier top",
    "heavy top that tumbles",
    "top",
    "",
    pt.System(pt.Body((0.9, 1.7, 1.3)), pt.UniformGravity(2.0, (1, 0, 0))),
    2e4,
)
_TILTED = quat.product(quat.product(_turn(2, paper.ORBIT.node), _turn(0, paper.ORBIT.inclination)), _turn(0, 0.2))
REGULAR = Problem(
    "regular P3",
    "satellite of P3 that spins five times in a revolution",
    "satellite",
    "",
    paper.KEPLER,
    1e5 * PERIOD,
    paper.KEPLER.body.state(_TILTED, omega_body=(0, 0, 10 * np.pi / PERIOD)),
)
"""Its axis is 0.2 rad off the normal of the orbit; the mean MEGNO is 2 after 1000 revolutions."""

NAMED = {problem.key: problem for problem in (*PROBLEMS, HEAVIER, REGULAR)}


@functools.cache
def _reference(system, q, Q, end):
    state = pt.State(q, Q)
    runs = [
        pt.propagate(system, state, [0.0, end], formulation=name, precision=WIDE).quaternion[-1]
        for name in ("canonical", "lie_poisson")
    ]
    return runs[0], float(rotation_angle(*runs))


def reference(system, start, end):
    """Return the quaternion at the end in wide precision, and its distance to that of a second formulation."""
    return _reference(system, tuple(start.quaternion), tuple(start.conjugate_momenta), float(end))


def error(problem, q, end=None):
    """Return the attitude error at the end, rad."""
    return float(rotation_angle(reference(problem.system, problem.start, end or problem.end)[0], np.asarray(q)))


def distance_to_paper_cases(problem):
    """Return how far the reference is from the 42-digit numbers, at the last time that these have."""
    row = json.loads(PAPER_CASES.read_text())["cases"][problem.case][-1]
    q, _ = reference(problem.system, problem.start, float(row["t"]))
    return float(rotation_angle(np.array(row["q"], dtype=float), q)), float(row["t"])


def turned(state, turns):
    """Return the states with attitudes turned in space by quaternions (..., 4); rates and momenta turn along."""
    return pt.State(quat.product(turns, state.quaternion), quat.product(turns, state.conjugate_momenta))


def ensemble(members, spread, seed=1):
    """Return states of members: the printed pair with random changes of the attitude."""
    vectors = spread * np.random.default_rng(seed).normal(size=(members, 3))
    turns = np.concatenate([np.ones((members, 1)), vectors / 2], axis=1)
    return turned(paper.PRINTED_PAIR, turns / np.linalg.norm(turns, axis=1, keepdims=True))


def member(states, i):
    """Return one member of an ensemble of states."""
    return pt.State(states.quaternion[i], states.conjugate_momenta[i])
