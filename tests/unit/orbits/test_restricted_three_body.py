"""The path near two attractors: its numbers, its views, and how a kernel integrates it along once."""

import dataclasses
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import sympy

import poinsot as pt
from in_order import in_order
from poinsot.integration import equations
from poinsot.integration.formulations import FORMULATIONS
from poinsot.integration.kernel_parameters import PreparedKernel
from poinsot.integration.problem import Problem
from poinsot.taylor.graph import Graph, tangents

MU1, MU2, SEPARATION, EPOCH = 3.1, 0.4, 2.5, 0.7
PLACE, DRIFT = (1.9, 0.7, 0.3), (-0.2, 0.1, 0.15)
PATH = pt.orbits.ThreeBodyPath(MU1, MU2, separation=SEPARATION, position=PLACE, velocity=DRIFT, epoch=EPOCH)
OTHER = pt.orbits.ThreeBodyPath(
    MU1, MU2, separation=SEPARATION, position=(-1.0, 1.8, 0.1), velocity=(0.1, 0.2, 0.0), epoch=EPOCH
)
TIMES = EPOCH + np.array([-2.0, -0.5, 0.0, 1e-9, 0.3, 1.1, 3.7])
VIEWS = {"primary": PATH.from_primary, "secondary": PATH.from_secondary}
each = pytest.mark.parametrize("name", VIEWS)


def stacked(vector):
    return np.stack(np.broadcast_arrays(*vector), axis=-1)


# ---------------------------------------------------------------------- numbers


@each
def test_start_is_the_given_one(name):
    orbit, n = VIEWS[name], PATH.mean_motion
    reduced = MU2 / (MU1 + MU2) * SEPARATION
    attractor = np.array([-reduced if name == "primary" else SEPARATION - reduced, 0, 0])
    r = np.array(PLACE) - attractor
    assert np.max(np.abs(stacked(orbit.position_at(EPOCH)) - r)) < 2e-15
    assert np.max(np.abs(stacked(orbit.velocity_at(EPOCH)) - DRIFT - np.cross((0, 0, n), r))) < 1e-15
    assert orbit.inverse_distance_at(EPOCH) == pytest.approx(1 / np.linalg.norm(r), rel=1e-15, abs=0)
    assert (orbit.mu, orbit.sample_time, orbit.closed_form) == ({"primary": MU1, "secondary": MU2}[name], EPOCH, False)


def test_views_differ_by_the_line_between_the_attractors():
    apart = stacked(PATH.from_primary.position_at(TIMES)) - stacked(PATH.from_secondary.position_at(TIMES))
    line = PATH.frame.attitude(TIMES).apply((SEPARATION, 0, 0))
    assert np.max(np.abs(apart - line)) < 4e-15
    change = stacked(PATH.from_primary.velocity_at(TIMES)) - stacked(PATH.from_secondary.velocity_at(TIMES))
    assert np.max(np.abs(change - np.cross(PATH.frame.omega_space(TIMES), line))) < 4e-15


@each
def test_derivatives_with_respect_to_time(name):
    orbit, other = VIEWS[name], VIEWS["secondary" if name == "primary" else "primary"]
    t = Graph().variable(TIMES)
    r, v, r2 = (stacked(x) for x in (orbit.position_at(TIMES), orbit.velocity_at(TIMES), other.position_at(TIMES)))
    slope = np.stack(t.graph.evaluated(tangents(orbit.position_at(t), {t: 1.0})), axis=-1)
    assert np.max(np.abs(slope - v)) < 1e-14
    acceleration = np.stack(t.graph.evaluated(tangents(orbit.velocity_at(t), {t: 1.0})), axis=-1)
    d, d2, line = np.linalg.norm(r, axis=-1)[:, None], np.linalg.norm(r2, axis=-1)[:, None], r - r2
    # The pulls on the body, and that of the other attractor on this one.
    newton = -orbit.mu * r / d**3 - other.mu * r2 / d2**3 - other.mu * line / SEPARATION**3
    assert np.max(np.abs(acceleration - newton)) < 4e-14
    (closing,) = t.graph.evaluated(tangents([orbit.inverse_distance_at(t)], {t: 1.0}))
    assert np.max(np.abs(closing + np.sum(r * v, axis=-1) / d[:, 0] ** 3)) < 1e-14


def test_path_does_not_depend_on_the_order_of_questions():
    def fresh():
        return pt.orbits.ThreeBodyPath(
            MU1, MU2, separation=SEPARATION, position=PLACE, velocity=DRIFT, epoch=EPOCH
        ).from_primary

    together, piecemeal = fresh(), fresh()
    r = stacked(together.position_at(TIMES.reshape(1, -1)))[0]
    for i in (3, 6, 0, 1, 5, 2, 4):
        assert np.array_equal(stacked(piecemeal.position_at(TIMES[i])), r[i])


def test_a_copy_has_the_same_path():
    path = pt.orbits.ThreeBodyPath(MU1, MU2, separation=SEPARATION, position=PLACE, velocity=DRIFT, epoch=EPOCH)
    r = stacked(path.from_primary.position_at(TIMES))
    copy = pickle.loads(pickle.dumps(path))
    assert np.array_equal(stacked(copy.from_primary.position_at(TIMES)), r)


@pytest.mark.parametrize("after", [3.0, -2.0])
def test_path_leads_back(after):
    orbit = PATH.from_primary
    n, time = PATH.mean_motion, EPOCH + after
    turn = PATH.frame.attitude(time).inv()
    r = turn.apply(stacked(orbit.position_at(time)))
    v = turn.apply(stacked(orbit.velocity_at(time))) - np.cross((0, 0, n), r)
    reduced = MU2 / (MU1 + MU2) * SEPARATION
    back = pt.orbits.ThreeBodyPath(
        MU1, MU2, separation=SEPARATION, position=r - (reduced, 0, 0), velocity=v, epoch=time
    )
    assert back.jacobi_constant == pytest.approx(PATH.jacobi_constant, abs=1e-14)
    end = stacked(back.from_primary.position_at(EPOCH))
    start = back.frame.attitude(EPOCH).apply(stacked(orbit.position_at(EPOCH)))
    assert np.max(np.abs(end - start)) < 2e-13


def test_long_doubles_are_preserved():
    exact = PATH.with_numbers(map(np.longdouble, PATH.numbers)).from_primary
    found = stacked(exact.position_at(np.longdouble(TIMES[5])))
    assert found.dtype == np.longdouble
    assert 0 < np.max(np.abs(found - stacked(PATH.from_primary.position_at(TIMES[5])))) < 1e-14


def test_units_scale():
    length, time = 1000.0, 60.0
    mu = length**3 / time**2
    same = pt.orbits.ThreeBodyPath(
        MU1 * mu,
        MU2 * mu,
        separation=SEPARATION * length,
        position=np.multiply(PLACE, length),
        velocity=np.multiply(DRIFT, length / time),
        epoch=EPOCH,
    )
    t = EPOCH + (TIMES - EPOCH) * time
    expected = np.multiply(length, stacked(PATH.from_secondary.position_at(TIMES)))
    assert np.max(np.abs(stacked(same.from_secondary.position_at(t)) - expected)) < 1.5e-10
    assert same.jacobi_constant == pytest.approx(PATH.jacobi_constant, rel=1e-15, abs=0)


def test_members_are_what_each_is_alone():
    places = np.array([PLACE, (1.8, 0.75, 0.2), (-1.0, 1.8, 0.1)])
    together = pt.orbits.ThreeBodyPath(MU1, MU2, separation=SEPARATION, position=places, velocity=DRIFT, epoch=EPOCH)
    assert together.jacobi_constant.shape == (3,)
    r = stacked(together.from_primary.position_at(np.full(3, 2.0)))
    for i in range(3):
        alone = pt.orbits.ThreeBodyPath(
            MU1, MU2, separation=SEPARATION, position=places[i], velocity=DRIFT, epoch=EPOCH
        )
        assert np.max(np.abs(r[i] - stacked(alone.from_primary.position_at(2.0)))) < 1e-14


FALL = 0.03


def falling(name, mu=0.01):
    """A path from rest near an attractor, and times just before and after the fall, the tide left out."""
    mass, x = {"primary": (1 - mu, -mu), "secondary": (mu, 1 - mu)}[name]
    path = pt.orbits.ThreeBodyPath(1 - mu, mu, separation=1.0, position=(x + FALL, 0, 0), velocity=(0, -FALL, 0))
    return path, np.pi * np.sqrt(FALL**3 / (8 * mass)) * np.array([0.99, 1.01])


def test_nothing_is_beyond_a_collision():
    path, t = falling("primary")
    x, *_ = path.from_primary.position_at(t)
    assert 0 < x[0] < 0.003
    assert np.isnan(x[1])


def test_passage_close_to_the_secondary_keeps_the_jacobi_constant():
    path, t = falling("secondary")  # the tide leads it past, at 1.8e-10
    x, y, _, *velocity = path.variables_at(t[1])
    assert 0.001 < np.hypot(x, y) < 0.003
    after = pt.orbits.ThreeBodyPath(0.99, 0.01, separation=1.0, position=(x + 0.99, y, 0), velocity=velocity)
    rounding = np.finfo(float).eps * 2 * 0.01 / 1.8e-10  # of the potential at the periapsis
    assert abs(after.jacobi_constant - path.jacobi_constant) < 4 * rounding


def test_times_must_be_finite():
    with pytest.raises(ValueError, match=r"^time must be finite, got time\[1\] = -inf\.$"):
        PATH.variables_at(np.array([EPOCH, -np.inf, np.nan]))


@pytest.mark.parametrize("way", ["pickle.loads(copy)", "ThreeBodyPath(**numbers).from_primary"])
def test_engine_is_there_without_a_propagation(way):
    numbers = {name: value.tolist() for name, value in dataclasses.asdict(PATH).items()}
    code = "import pickle; from poinsot.orbits.restricted_three_body import ThreeBodyPath; "
    code += f"copy, numbers = {pickle.dumps(PATH.from_primary)!r}, {numbers!r}; print(*{way}.position_at(2.0))"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert np.array_equal(np.array(printed.split(), dtype=float), stacked(PATH.from_primary.position_at(2.0)))


# ---------------------------------------------------------------------- ways in


def test_paths_from_a_libration_point():
    point = pt.orbits.LagrangePointPath(3.1, 0.4, separation=2.5, point="L2", epoch=0.7)
    offset, drift = np.array([0.01, -0.02, 0.03]), (0.1, 0.0, -0.1)
    path = point.path(offset=offset, velocity=drift)
    assert (path.mass_ratio, path.mean_motion, path.epoch) == (point.mass_ratio, point.mean_motion, 0.7)
    for view, held in ((path.from_primary, point.from_primary), (path.from_secondary, point.from_secondary)):
        assert np.max(np.abs(stacked(view.position_at(0.7)) - held.position - offset)) < 1e-15
    assert np.array_equal(path.velocity, drift)
    assert point.path(offset=np.zeros((4, 3))).position.shape == (4, 3)


AT_SECONDARY, AT_PRIMARY = (SEPARATION * MU1 / (MU1 + MU2), 0, 0), (-SEPARATION * MU2 / (MU1 + MU2), 0, 0)
WRONG = {
    "position must be apart from both attractors, got a body at the secondary.": (3.1, 0.4, 2.5, AT_SECONDARY),
    "position must be apart from both attractors, got a body at the primary.": (3.1, 0.4, 2.5, AT_PRIMARY),
    "mu_secondary must not exceed mu_primary, got 2.0 and 1.0. The primary is the heavier one.": (1, 2, 1, PLACE),
    "separation must be positive, got 0.0.": (1, 0.1, 0, PLACE),
    "mu_primary must be positive, got -1.0.": (-1, -2, 1, PLACE),
    "position must have shape (3,) or (members, 3) along the synodic axes, got shape (2,).": (3.1, 0.4, 2.5, (1, 2)),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_paths_are_refused(sentence):
    with pytest.raises(ValueError) as error:
        in_order(pt.orbits.ThreeBodyPath, *WRONG[sentence], DRIFT)
    assert str(error.value) == sentence


@pytest.mark.parametrize("time", [Graph().symbol("t"), sympy.Symbol("t")])
def test_symbols_are_refused_with_a_sentence(time):
    sentence = (
        r"^the formulas of a ThreeBodyPath must have numbers, got a symbol\. "
        r"In a kernel its path is integrated along: instant\.position\(orbit\) has the position there\.$"
    )
    with pytest.raises(TypeError, match=sentence):
        PATH.from_primary.position_at(time)


# ---------------------------------------------------------------------- in kernels

BODY = pt.Body((1.0, 1.2, 1.5))
START = BODY.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3), time=0.2)
RUN = np.linspace(-1.0, 4.0, 6)


class Push(pt.Torque):
    """Looks at position and velocity along the space axes."""

    orbit: pt.Orbit

    def torque(self, instant):
        return 0.1 * instant.attitude.to_body(instant.velocity(self.orbit) + 0.3 * instant.position(self.orbit))


def both(path):
    return [pt.GravityGradient(path.from_primary), pt.GravityGradient(path.from_secondary)]


UPRIGHT = pt.UniformGravity(0.3, (1, 0, 0))
FLYBY = pt.orbits.EscapeOrbit(
    1.0,
    periapsis_distance=2.0,
    eccentricity=1.6,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    time_since_periapsis=0.6,
)
A, B = Push(PATH.from_primary), Push(OTHER.from_secondary)
SYSTEMS = {
    "synodic": both(PATH),
    "space": [*both(PATH), UPRIGHT],
    "first path shared": [A, A, B],
    "second path shared": [A, B, B],
    "with a flyby": [Push(FLYBY), A, Push(PATH.from_secondary), A],
}
SIZES = {"first path shared": 12, "second path shared": 12, "with a flyby": 7}


@pytest.mark.parametrize("name", SYSTEMS)
def test_each_path_is_integrated_once_and_the_torques_are_those_along_it(name):
    system = pt.System(BODY, *SYSTEMS[name])
    assert sum(block.size for block in system.dynamics.blocks) == SIZES.get(name, 6)
    variables = equations.state_vector(Problem(system), START, FORMULATIONS["lie_poisson"], "double")
    assert variables.comoving == (name == "synodic")
    motion = pt.propagate(system, START, RUN, dense=True)
    step = 1e-4
    for time in (-0.6, 2.7):
        after, before = motion(time + step), motion(time - step)
        change = (after.angular_momentum_space - before.angular_momentum_space) / (2 * step)
        torque = motion(time).attitude.apply(system.torque_body(motion(time)))
        assert np.max(np.abs(change - torque)) < 1e-6 * max(1.0, float(np.linalg.norm(torque)))
        assert np.linalg.norm(torque) > 1e-2


def test_axes_formulations_and_precisions_agree():
    system = pt.System(BODY, *SYSTEMS["synodic"])
    reference = pt.propagate(system, START, RUN, precision="quadruple")  # along the space axes
    for formulation in ("lie_poisson", "canonical"):
        motion = pt.propagate(system, START, RUN, formulation=formulation)
        assert np.max(np.abs(motion.attitude.as_matrix() - reference.attitude.as_matrix())) < 5e-13
        assert np.max(np.abs(motion.omega_body - reference.omega_body)) < 5e-13


def test_other_numbers_use_the_same_kernel(forget_kernels):
    forget_kernels()
    motions = [pt.propagate(pt.System(BODY, *both(path)), START, RUN).quaternion for path in (PATH, OTHER)]
    assert sum(isinstance(known, PreparedKernel) for known in equations.known._stored.values()) == 1
    assert np.max(np.abs(motions[0] - motions[1])) > 1e-2


@pytest.mark.parametrize("name", ["synodic", "space", "second path shared", "with a flyby"])
def test_environment_of_a_motion_is_the_integrated_one(name, monkeypatch):
    system = pt.System(BODY, *SYSTEMS[name])
    motion = pt.propagate(system, START, RUN[::-1])
    state = pt.State(motion.quaternion, motion.conjugate_momenta, motion.times)
    energy, torque = system.potential_energy(state), system.torque_body(state)
    integrated = [PATH.from_primary, PATH.from_secondary, *[FLYBY] * (name == "with a flyby")]
    for view in (*integrated, pt.orbits.FixedPosition(1.0, position=(1, 2, 3))):
        place, inverse = stacked(view.position_at(motion.times)), view.inverse_distance_at(motion.times)
        with monkeypatch.context() as blinded:
            if view in integrated:
                blinded.delattr(type(view), "position_at")
                blinded.delattr(type(view), "inverse_distance_at")
            assert np.max(np.abs(stacked(motion.environment.position(view)) - place)) < 1e-12
            assert np.max(np.abs(motion.environment.inverse_distance(view) - inverse)) < 1e-12
    assert np.max(np.abs(motion.potential_energy - energy)) < 1e-12 * np.max(np.abs(energy) + 1)
    assert np.max(np.abs(system.torque_body(state, motion.environment) - torque)) < 1e-12 * np.max(np.abs(torque))


@pytest.mark.parametrize("name", ["synodic", "space"])
def test_members_along_paths_of_their_own(name):
    places = np.array([PLACE, (1.8, 0.75, 0.2), (-1.0, 1.8, 0.1)])

    def system(chosen):
        path = pt.orbits.ThreeBodyPath(
            MU1, MU2, separation=SEPARATION, position=places[chosen], velocity=DRIFT, epoch=EPOCH
        )
        return pt.System(BODY, *both(path), *([UPRIGHT] if name == "space" else []))

    together: Any = pt.propagate(system(slice(None)), START, RUN)
    primary = together.system.forces[0].orbit
    for i in range(3):
        alone: Any = pt.propagate(system(i), START, RUN)
        assert np.max(np.abs(together.quaternion[i] - alone.quaternion)) < 1e-12
        assert np.max(np.abs(together.potential_energy[i] / alone.potential_energy - 1)) < 1e-12
        r = alone.environment.position(alone.system.forces[0].orbit)
        assert np.max(np.abs(np.stack(together.environment.position(primary))[:, i] - np.stack(r))) < 1e-12


def test_attitudes_that_differ_go_along_one_path():
    starts = BODY.state(np.array([(0.6, 0.8, 0, 0), (1, 0, 0, 0)]), omega_body=(0.1, 0.2, 0.3), time=0.2)
    system = pt.System(BODY, *both(PATH))
    motion = pt.propagate(system, starts, RUN)
    r = np.stack(motion.environment.position(PATH.from_primary))
    assert r.shape == (3, 2, 6)
    assert np.max(np.abs(r - np.stack(PATH.from_primary.position_at(RUN))[:, None])) < 1e-12


def test_formulas_are_tried_near_the_epoch():
    """Far away a path may be chaotic or over: what a system conserves is found within half a revolution."""
    symmetric = pt.Body((1.0, 1.0, 1.5))
    assert [integral.symbol for integral in pt.System(symmetric, *both(PATH)).integrals] == ["g3"]
    assert pt.System(BODY, *both(PATH)).integrals == ()
