"""Random motions against an Euler-Newton integration that never imports poinsot."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from in_order import in_order
from oracles import euler_newton as oracle

TIMES = np.array([-4.0, -2.5, -1.0, 0.3, 2.0, 4.5, 8.0])
SEEDS = range(2)
FORMULATIONS = ("lie_poisson", "canonical")


@dataclass
class Problem:
    """One body, start and set of forces, given to both sides; the flags are the forces, `sign` turns one over."""

    seed: int
    oblique: bool = False
    gravity: bool = False
    orbit: bool = False
    attractor_at_rest: bool = False
    damping: bool = False
    start: float = 0.7

    def __post_init__(self):
        random = np.random.default_rng(self.seed)
        self.inertia = oblique_inertia(random) if self.oblique else np.diag(random.uniform(0.7, 1.3, 3))
        self.attitude = Rotation.random(None, random)
        self.omega = random.uniform(-1, 1, 3)
        self.weight, self.lever = random.uniform(0.5, 1), random.uniform(-1, 1, 3)
        angles = random.uniform(-2, 2, 4)
        self.elements = (1.3, 1.4, random.uniform(0.1, 0.4), abs(angles[0]), *angles[1:])
        self.epoch = random.uniform(-1, 1)
        self.mu_at_rest, self.place = 0.9, random.uniform(0.6, 1, 3) * random.choice([-1, 1], 3)
        self.coefficient = random.uniform(0.02, 0.05)

    @property
    def body(self):
        return pt.Body.from_inertia(self.inertia) if self.oblique else pt.Body(np.diag(self.inertia))

    @property
    def system(self):
        forces = {
            "gravity": lambda: pt.UniformGravity(self.weight, self.lever),
            "orbit": lambda: pt.GravityGradient(in_order(pt.KeplerOrbit, *self.elements, epoch=self.epoch)),
            "attractor_at_rest": lambda: pt.GravityGradient(
                pt.orbits.FixedPosition(self.mu_at_rest, position=self.place)
            ),
            "damping": lambda: pt.forces.LinearDamping(self.coefficient),
        }
        return pt.System(self.body, *(make() for name, make in forces.items() if getattr(self, name)))

    def propagate(self, times=TIMES, **options):
        state = self.body.state(self.attitude, omega_body=self.omega, time=self.start)
        return pt.propagate(self.system, state, times, **options)

    def judge(self, times=TIMES, reversed_torque=None):
        """The motion by the oracle, with one of the torques turned over where that is asked for."""
        moving = oracle.Attractor(self.elements[0], *oracle.cartesian_vectors(*self.elements), epoch=self.epoch)
        resting = oracle.Attractor(self.mu_at_rest, self.place)
        torques = {
            "gravity": oracle.uniform_gravity(self.weight, self.lever),
            "orbit": oracle.gravity_gradient(self.inertia, moving, 0),
            "attractor_at_rest": oracle.gravity_gradient(self.inertia, resting, 1),
            "damping": oracle.linear_damping(self.coefficient),
        }
        chosen = [
            reversed_sign(torque) if name == reversed_torque else torque
            for name, torque in torques.items()
            if getattr(self, name)
        ]
        matrix = self.attitude.as_matrix()
        return oracle.integrate(self.inertia, matrix, self.omega, self.start, times, chosen, [moving, resting])


def reversed_sign(torque):
    return lambda *arguments: -torque(*arguments)


def oblique_inertia(random):
    """The inertia of twelve random points of mass, with products of inertia of the size of the moments."""
    points = random.normal(size=(12, 3)) * [1.2, 0.8, 0.6] @ Rotation.random(None, random).as_matrix()
    return (np.sum(points**2) * np.eye(3) - points.T @ points) / 12


def difference(motion, judged):
    matrices, rates = judged
    return max(
        np.max(np.abs(motion.attitude.as_matrix() - matrices)),
        np.max(np.abs(motion.omega_body - rates)),
    )


FORCES = ("gravity", "orbit", "attractor_at_rest", "damping")
CONFIGURATIONS = {
    "none": {},
    **{name: {name: True} for name in FORCES},
    "gravity and damping": {"gravity": True, "damping": True},
    "two attractors": {"orbit": True, "attractor_at_rest": True},
    "all": dict.fromkeys(FORCES, True),
}


@pytest.mark.parametrize("oblique", [False, True], ids=["principal axes", "oblique axes"])
@pytest.mark.parametrize("forces", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
@pytest.mark.parametrize("seed", SEEDS)
def test_motion_is_that_of_euler_and_newton(seed, forces, oblique):
    problem = Problem(seed, oblique, **forces)
    judged = problem.judge()
    for formulation in FORMULATIONS:
        assert difference(problem.propagate(formulation=formulation), judged) < 1e-11


@pytest.mark.parametrize("oblique", [False, True], ids=["principal axes", "oblique axes"])
@pytest.mark.parametrize("name", FORCES)
def test_a_torque_of_the_wrong_sign_would_be_noticed(name, oblique):
    problem = Problem(0, oblique, **dict.fromkeys(FORCES, True))
    assert difference(problem.propagate(), problem.judge(reversed_torque=name)) > 1e-2


@pytest.mark.parametrize("seed", SEEDS)
def test_euler_angles_follow_the_same_motion(seed):
    problem = Problem(seed, oblique=True, **dict.fromkeys(FORCES, True))
    assert difference(problem.propagate(formulation="euler_angles"), problem.judge()) < 1e-11


@pytest.mark.parametrize("start", [-4.0, 0.0, 4.5, 8.0, 11.0])
def test_start_at_and_beyond_the_ends_of_the_times(start):
    # The judge loses a digit on the longer ways.
    problem = Problem(3, oblique=True, orbit=True, gravity=True, start=start)
    assert difference(problem.propagate(), problem.judge()) < 1e-10


@pytest.mark.parametrize("dense", [False, True])
def test_times_in_falling_order(dense):
    problem = Problem(4, oblique=True, orbit=True, gravity=True, damping=True)
    motion = problem.propagate(TIMES[::-1], dense=dense)
    matrices, rates = problem.judge()
    assert np.array_equal(motion.times, TIMES[::-1])
    assert difference(motion, (matrices[::-1], rates[::-1])) < 1e-11


def test_dense_output_in_between():
    problem = Problem(5, oblique=True, **dict.fromkeys(FORCES, True))
    motion, times = problem.propagate([-4, 8], dense=True), np.linspace(-4, 8, 50)
    states = motion(times)
    matrices, rates = problem.judge(times)
    assert np.max(np.abs(states.attitude.as_matrix() - matrices)) < 1e-11
    assert np.max(np.abs(problem.body.omega(states.angular_momentum_body) - rates)) < 1e-11


@pytest.mark.parametrize("given", ["omega_space", "angular_momentum_body", "angular_momentum_space"])
def test_each_way_of_giving_the_rate_is_the_same_motion(given):
    problem = Problem(6, oblique=True, gravity=True)
    A, g = problem.attitude.as_matrix(), problem.inertia @ problem.omega
    value = {"omega_space": A @ problem.omega, "angular_momentum_body": g, "angular_momentum_space": A @ g}[given]
    state = problem.body.state(problem.attitude, **{given: value}, time=problem.start)
    assert difference(pt.propagate(problem.system, state, TIMES), problem.judge()) < 1e-11


def test_energies_of_the_moving_body():
    problem = Problem(7, oblique=True, gravity=True, attractor_at_rest=True)
    matrices, rates = problem.judge()
    kinetic = 0.5 * np.einsum("ni,ij,nj->n", rates, problem.inertia, rates)
    height = matrices[:, 2] @ problem.lever
    distance = np.linalg.norm(problem.place)
    radial = np.einsum("nji,j->ni", matrices, problem.place / distance)
    moment = np.einsum("ni,ij,nj->n", radial, problem.inertia, radial)
    potential = problem.weight * height + 1.5 * problem.mu_at_rest / distance**3 * moment
    motion = problem.propagate()
    assert np.max(np.abs(motion.kinetic_energy - kinetic)) < 4e-13
    assert np.max(np.abs(motion.potential_energy - potential)) < 3e-13


def test_orbit_from_its_elements_and_from_its_vectors():
    problem = replace(Problem(8), orbit=True)
    position, velocity = oracle.cartesian_vectors(*problem.elements)
    orbit = pt.KeplerOrbit.from_vectors(problem.elements[0], position=position, velocity=velocity, epoch=problem.epoch)
    state = problem.body.state(problem.attitude, omega_body=problem.omega, time=problem.start)
    motion = pt.propagate(pt.System(problem.body, pt.GravityGradient(orbit)), state, TIMES)
    assert difference(motion, problem.judge()) < 1e-11
