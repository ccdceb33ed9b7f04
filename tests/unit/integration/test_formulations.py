"""Charts of attitude and angular momentum, the package's and a user's own."""

import math

import numpy as np
import pytest

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.files.scenario import repetition
from poinsot.functions import Vector
from poinsot.integration.formulations import FORMULATIONS, Formulation, LiePoisson

BODY = pt.Body((1.25, 1.0, 0.75))
OBLIQUE = pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.3, eccentricity=0.2)
TIMES = np.linspace(-3.0, 8.0, 12)


class SpaceMomentum(Formulation):
    """(q, G): the angular momentum along the space axes, which torques alone change."""

    name = "space momentum"
    blocks = {"attitude": 4, "momentum": 3}  # noqa: RUF012
    turns = False

    def physical(self, variables):
        q, G = self.split(variables)
        attitude = pt.Attitude.from_quaternion(q)
        return attitude, attitude.to_body(G)

    def rates(self, variables, omega, g_rate, torque, turning=None):  # noqa: ARG002
        q, _ = self.split(variables)
        attitude, _ = self.physical(variables)
        return [*quat.product(q, quat.pure(0.5 * omega)), *attitude.to_space(torque)]

    def from_state(self, state):
        return np.concatenate([state.quaternion, state.angular_momentum_space], axis=-1)

    def to_phase(self, variables):
        q = variables[..., :4]
        return {"quaternion": q, "angular_momentum_body": quat.rotate(quat.conjugate(q), variables[..., 4:])}


class Spin(pt.Torque):
    """A torque that depends on the attitude and the rate."""

    size: float

    def torque(self, instant):
        return self.size * instant.attitude.to_body((0.0, 0.6, 0.8)) - 0.1 * self.size * instant.omega_body


SYSTEMS = {
    "free": pt.System(OBLIQUE),
    "top": pt.System(BODY, pt.UniformGravity(0.5, (1.0, 0.2, -0.3))),
    "satellite": pt.System(OBLIQUE, pt.GravityGradient(ORBIT), Spin(0.3)),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_users_own_formulation_gives_the_same_motion(name):
    """Two integrations of the same tolerance: apart by the rounding of some 100 steps."""
    system = SYSTEMS[name]
    start = system.body.state((0.8, 0.36, -0.48, 0.0), omega_body=(0.3, -0.5, 0.9))
    own, usual = (pt.propagate(system, start, TIMES, formulation=each) for each in (SpaceMomentum(), None))
    assert own.run.formulation == "space momentum"
    assert np.max(np.abs(own.quaternion - usual.quaternion)) < 2e-13
    assert np.max(np.abs(own.omega_body - usual.omega_body)) < 2e-13
    if name == "free":
        assert np.ptp(own.angular_momentum_space, axis=0).max() < 4e-15  # three times the worst of shaken starts


def test_ensembles_and_events_take_it_too():
    rates = np.array([(0.3, -0.5, 0.9), (0.1, 0.8, 0.2), (-0.4, 0.3, 0.6)])
    start = BODY.state((0.8, 0.36, -0.48, 0.0), omega_body=rates)
    events = [pt.events.RateCrossing((0.0, 0.0, 1.0), rate=0.5)]
    own, usual = (
        pt.propagate(SYSTEMS["top"], start, TIMES, events=events, formulation=each) for each in (SpaceMomentum(), None)
    )
    assert np.max(np.abs(own.quaternion - usual.quaternion)) < 2e-13
    assert len(usual.events[0].times) > 2
    assert np.max(np.abs(own.events[0].times - usual.events[0].times)) < 1e-12


@pytest.mark.parametrize("name", ["lie_poisson", "canonical", "euler_angles"])
def test_rates_are_the_derivative_of_the_variables(name):
    """Along a motion with a given omega and g': central differences of an exact turn, to their error of 1e-10."""
    chart, step = FORMULATIONS[name], 1e-5
    q, g = np.array([0.5, 0.1, -0.7, 0.5]), np.array([0.4, -0.3, 0.6])
    omega, torque = np.array([0.3, 0.2, -0.5]), np.array([0.2, -0.1, 0.4])
    g_rate = np.cross(g, omega) + torque

    def variables(t):
        angle = np.linalg.norm(omega) * t / 2
        turn = np.array([np.cos(angle), *np.sin(angle) * omega / np.linalg.norm(omega)])
        return chart.from_state(BODY.state(quat.product(q, turn), angular_momentum_body=g + t * g_rate))

    expected = (variables(step) - variables(-step)) / (2 * step)
    found = chart.rates(Vector(variables(0.0)), Vector(omega), Vector(g_rate), Vector(torque))
    assert np.array(found, dtype=float) == pytest.approx(expected, abs=1e-9)
    attitude, momentum = chart.physical(Vector(variables(0.0)))
    assert np.array(momentum, dtype=float) == pytest.approx(g, abs=1e-15)
    assert np.array(attitude.to_space((0, 0, 1)), dtype=float) == pytest.approx(quat.rotate(q, (0, 0, 1)), abs=1e-15)


class Reversal(pt.events.AtTime):
    """An event that reverses the angular velocity."""

    def act(self, body, state):
        return body.state(state.quaternion, omega_body=-body.omega(state.angular_momentum_body), time=state.time)


@pytest.mark.parametrize("dense", [False, True])
def test_motions_in_euler_angles_stop_at_the_singular_angle_after_an_action_too(dense):
    """A rotation about the first axis: theta = pi / 2 - t; after a reversal at t = 1, theta = pi at t = 2 + pi / 2."""
    upright = (0.5**0.5, 0.5**0.5, 0, 0)
    rates = np.array([(-1.0, 0, 0), (0.0, 0, 1.0)])

    singular = math.asin(1e-6)
    for events, stops in (
        ([], math.pi / 2 - singular),
        ([Reversal(1.0)], 2 + math.pi / 2 - singular),
    ):
        given = {"events": events, "formulation": "euler_angles"}
        if dense:
            with pytest.raises(pt.PropagationError, match="Euler angles 3-1-3 are singular") as stopped:
                pt.propagate(pt.System(BODY), BODY.state(upright, omega_body=rates[0]), [4.0], dense=True, **given)
            assert stopped.value.time == pytest.approx(stops, abs=3e-15)  # three times the worst of 40 rates
        else:
            motion = pt.propagate(pt.System(BODY), BODY.state(upright, omega_body=rates), np.linspace(0, 4, 9), **given)
            assert motion.run.kernel == "looped"
            assert list(motion.failures) == [0]
            assert f"t = {stops:.10g} of 4: sin(theta) fell below 1e-6" in motion.failures[0]
            assert np.all(np.isfinite(motion.quaternion[1]))
            reached = np.isfinite(motion.quaternion[0, :, 0])
            assert np.array_equal(reached, motion.times < stops)
            theta = np.arccos(motion.attitude[0].as_matrix()[reached, 2, 2])
            folded = np.where(motion.times[reached] > 1, motion.times[reached] - 2, -motion.times[reached])
            expected = math.pi / 2 + (folded if events else -motion.times[reached])
            assert theta == pytest.approx(expected, abs=1.1e-13)  # three times the worst of 40 rates


def test_what_is_no_formulation_is_refused():
    with pytest.raises(ValueError, match=r"^formulation must be one of .*, got 'SpaceMomentum'\.$"):
        pt.propagate(SYSTEMS["top"], BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [1.0], formulation="SpaceMomentum")


class Unnamed(LiePoisson):
    """A user's own without a name of its own."""


def test_a_formulation_has_a_name_of_its_own():
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    with pytest.raises(ValueError, match="name of its own, got Unnamed with the name 'lie_poisson'"):
        pt.propagate(SYSTEMS["top"], start, [1.0], formulation=Unnamed())


class Scaled(SpaceMomentum):
    """A user's own with an argument, of which a file knows nothing."""

    def __init__(self, factor):
        self.name, self.factor = "scaled", factor


def test_files_repeat_a_motion_of_a_users_own_formulation(tmp_path):
    start = BODY.state((0.8, 0.36, -0.48, 0.0), omega_body=(0.3, -0.5, 0.9))
    motion = pt.propagate(SYSTEMS["top"], start, TIMES, formulation=SpaceMomentum())
    again = repetition(pt.load(pt.save(motion, tmp_path / "own.nc")), "own.nc")
    assert again.run["formulation"] == "space momentum"
    repeated = pt.propagate(again.system, again.state, again.times, formulation=again.run["formulation"])
    assert np.array_equal(repeated.quaternion, motion.quaternion)

    motion = pt.propagate(SYSTEMS["top"], start, TIMES, formulation=Scaled(2.0))
    read = pt.load(pt.save(motion, tmp_path / "scaled.nc"))
    assert np.array_equal(read.quaternion, motion.quaternion)
    with pytest.raises(ValueError, match="the formulation of a scenario must be one of"):
        repetition(read, "scaled.nc")


def test_an_unfinished_class_does_not_hinder_others():
    class Unfinished(Formulation):
        physical = rates = from_state = to_phase = None

    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    assert pt.propagate(SYSTEMS["free"], start, [1.0], formulation="canonical").run.formulation == "canonical"
    del Unfinished
