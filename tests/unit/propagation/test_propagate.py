"""Integration: times, directions, dense output, precision, tolerance, interruption, singular runs."""

import itertools
import os
import re
import signal
import threading
import time as clock

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions
from poinsot.taylor import queue

TIMES = np.linspace(0, 10, 11)
FORMULATIONS = ("lie_poisson", "canonical", "euler_angles")


def rows(motion):
    return np.concatenate([motion.quaternion, motion.conjugate_momenta], axis=-1)


def assert_same(one, other, within=2e-14):
    assert rows(one).shape == rows(other).shape
    assert np.max(np.abs(rows(one) - rows(other)), initial=0.0) < within


# ---------------------------------------------------------------------- times and directions


def test_first_row_is_the_state(top, start):
    motion = pt.propagate(top, start, TIMES)
    assert np.allclose(motion.quaternion[0], start.quaternion, rtol=0, atol=4e-16)
    assert np.allclose(motion.conjugate_momenta[0], start.conjugate_momenta, rtol=0, atol=2e-15)
    assert motion.times.tolist() == TIMES.tolist()


@pytest.mark.parametrize("dense", [False, True])
def test_rows_do_not_depend_on_the_other_times(top, start, dense):
    all_rows, few = (pt.propagate(top, start, times, dense=dense) for times in (TIMES, TIMES[[3, 4, 9]]))
    assert np.max(np.abs(rows(all_rows)[[3, 4, 9]] - rows(few))) < 2e-14


@pytest.mark.parametrize("dense", [False, True])
def test_falling_times_give_the_rows_in_that_order(top, start, dense):
    rising, falling = (pt.propagate(top, start, times, dense=dense) for times in (TIMES, TIMES[::-1]))
    assert falling.times.tolist() == TIMES[::-1].tolist()
    assert np.array_equal(rows(falling), rows(rising)[::-1])


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize("times", [TIMES - 5, (TIMES - 5)[::-1], TIMES - 4.5, TIMES - 30, (TIMES - 30)[::-1]])
def test_both_directions_from_the_states_time(top, start, times, dense):
    motion = pt.propagate(top, start, times, dense=dense)
    assert motion.times.tolist() == times.tolist()
    one_by_one = np.concatenate([rows(pt.propagate(top, start, [time])) for time in times])
    assert np.max(np.abs(rows(motion) - one_by_one)) < 5e-14


def test_the_states_time_may_be_anywhere(top, start):
    later = pt.State(start.quaternion, start.conjugate_momenta, 7.0)
    assert_same(pt.propagate(top, start, TIMES), pt.propagate(top, later, TIMES + 7))


def test_there_and_back(top, start):
    there = pt.propagate(top, start, [20.0])
    end = pt.State(
        there.quaternion[0], pt.mechanics.project_to_tangent(there.quaternion[0], there.conjugate_momenta[0]), 20.0
    )
    back = pt.propagate(top, end, [0.0])
    assert np.allclose(back.quaternion[0], start.quaternion, rtol=0, atol=1e-13)
    assert np.allclose(back.conjugate_momenta[0], start.conjugate_momenta, rtol=0, atol=1e-13)


def test_backwards_is_not_forwards(top, start):
    motion = pt.propagate(top, start, [-1.0, 1.0])
    assert np.max(np.abs(np.diff(motion.quaternion, axis=0))) > 0.1


@pytest.mark.parametrize("dense", [False, True])
def test_one_time_at_the_state(top, start, dense):
    motion = pt.propagate(top, start, [0.0], dense=dense)
    assert np.allclose(motion.quaternion, [start.quaternion], rtol=0, atol=4e-16)
    assert motion.run.steps == 0


def test_times_that_are_an_ulp_apart(top, start):
    motion = pt.propagate(top, start, [1.0, np.nextafter(1.0, 2), 2.0])
    assert np.max(np.abs(motion.quaternion[1] - motion.quaternion[0])) < 1e-15


def test_no_momentum_and_no_force_stays(body):
    motion = pt.propagate(pt.System(body), body.state((0.5, 0.5, 0.5, 0.5), omega_body=(0, 0, 0)), [0.0, 1e6])
    assert motion.quaternion.tolist() == [[0.5, 0.5, 0.5, 0.5]] * 2


def test_many_more_steps_than_between_two_looks_at_the_keyboard(body, start):
    motion = pt.propagate(pt.System(body), start, [0.0, 60000.0])
    assert motion.run.steps > 20_000
    assert max(np.max(np.abs(drift)) for drift in motion.drift.values()) < 1e-12


def test_a_parameter_that_the_formula_does_not_use(body, start):
    class Idle(pt.Torque):
        first: float
        unused: float

        def torque(self, instant):
            return self.first * instant.omega_body

    damped = pt.propagate(pt.System(body, pt.forces.LinearDamping(0.1)), start, TIMES)
    assert_same(pt.propagate(pt.System(body, Idle(-0.1, 5.0)), start, TIMES), damped)


def test_new_numbers_give_new_motions(body, start):
    light, heavy, again = (
        pt.propagate(pt.System(body, pt.UniformGravity(weight, (1, 0, 0))), start, [1.0]) for weight in (0.1, 1.0, 0.1)
    )
    assert np.max(np.abs(light.quaternion - heavy.quaternion)) > 1e-2
    assert np.array_equal(light.quaternion, again.quaternion)


# ---------------------------------------------------------------------- formulations


@pytest.mark.parametrize("formulation", FORMULATIONS[1:])
@pytest.mark.parametrize("system", ["top", "satellite"])
def test_formulations_agree(system, formulation, start, request):
    system = request.getfixturevalue(system)
    times = np.linspace(-3, 3, 7)
    assert_same(
        pt.propagate(system, start, times), pt.propagate(system, start, times, formulation=formulation), within=2e-12
    )


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_run_says_what_ran(top, start, formulation):
    run = pt.propagate(top, start, TIMES, formulation=formulation, tolerance=1e-10).run
    assert (run.method, run.formulation, run.precision, run.tolerance) == ("Taylor", formulation, "double", 1e-10)
    assert run.order >= 10
    assert run.steps > 0
    assert run.wall_time > 0
    assert {"poinsot", "llvmlite", "numpy", "scipy", "python"} <= set(run.versions)


def test_the_default_is_lie_poisson(top, start):
    assert pt.propagate(top, start, TIMES).run.formulation == "lie_poisson"


# ---------------------------------------------------------------------- dense output


@pytest.fixture(scope="module")
def dense(top, start):
    return pt.propagate(top, start, np.linspace(-4, 6, 5), dense=True)


def test_dense_output_at_the_requested_times(dense):
    state = dense(dense.times)
    assert np.allclose(state.quaternion, dense.quaternion, rtol=0, atol=1e-15)
    assert np.allclose(state.conjugate_momenta, dense.conjugate_momenta, rtol=0, atol=2e-15)  # three times the worst


def test_dense_output_between_the_times(dense, top, start):
    times = np.linspace(-4, 6, 101)
    direct = pt.propagate(top, start, times)
    assert np.allclose(dense(times).quaternion, direct.quaternion, rtol=0, atol=2e-14)
    assert np.allclose(dense(times).conjugate_momenta, direct.conjugate_momenta, rtol=0, atol=2e-14)


@pytest.mark.parametrize("time", [0.5, -3.7, 0, -4, 6.0, np.float64(1.5), np.array(1.5)])
def test_dense_output_at_one_time_is_one_state(dense, time):
    state = dense(time)
    assert isinstance(state, pt.State)
    assert state.quaternion.shape == state.conjugate_momenta.shape == (4,)
    assert state.time == time


@pytest.mark.parametrize(
    "times", [[], [0.5], [0.5, 0.25], [3.0, -2.0, 5.0, -2.0, 0.0], [[0.5, -1.0, 2.0], [5.0, 1.0, -3.0]], [[]]], ids=str
)
def test_dense_output_at_arrays_of_times_in_any_order_and_shape(dense, times):
    state = dense(times)
    shape = np.shape(times)
    assert state.quaternion.shape == state.conjugate_momenta.shape == (*shape, 4)
    assert np.shape(state.time) == shape
    for index in np.ndindex(shape):
        assert np.array_equal(state.quaternion[index], dense(np.array(times)[index]).quaternion)


def test_dense_output_reaches_from_the_state_to_the_times(top, start):
    motion = pt.propagate(top, start, [5.0, 6.0], dense=True)
    assert np.allclose(motion(0.0).quaternion, start.quaternion, rtol=0, atol=1e-15)
    assert np.allclose(motion(3.0).quaternion, pt.propagate(top, start, [3.0]).quaternion[0], rtol=0, atol=1e-14)


def test_dense_output_of_no_span_is_the_state(top, start):
    assert np.allclose(
        pt.propagate(top, start, [0.0], dense=True)(0.0).quaternion, start.quaternion, rtol=0, atol=4e-16
    )


@pytest.mark.parametrize(("time", "shown"), [(6.5, "6.5"), (-4.001, "-4.001"), ([0.0, 7.0, 8.0], "8")])
def test_dense_output_outside_is_refused(dense, time, shown):
    with pytest.raises(ValueError, match=rf"^time must lie within \[-4, 6\], got {shown}\.$"):
        dense(time)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_dense_output_in_every_formulation(satellite, start, formulation):
    motion = pt.propagate(satellite, start, [-1.0, 2.0], dense=True, formulation=formulation)
    expected = pt.propagate(satellite, start, [-0.5, 1.5])
    assert np.allclose(motion([-0.5, 1.5]).quaternion, expected.quaternion, rtol=0, atol=1e-14)
    assert np.allclose(motion([-0.5, 1.5]).conjugate_momenta, expected.conjugate_momenta, rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- precision and tolerance


@pytest.mark.parametrize("dense", [False, True])
def test_precisions_agree(top, start, dense):
    double, wider = (pt.propagate(top, start, TIMES, precision=p, dense=dense) for p in ("double", "quadruple"))
    assert_same(double, wider, within=5e-14)
    assert rows(wider).dtype == np.float64
    assert wider.run.precision == "quadruple"
    assert wider.run.tolerance < double.run.tolerance


def test_a_looser_tolerance_takes_fewer_steps_and_errs_more(top, start):
    tolerances = (1e-4, 1e-7, 1e-10, 1e-13)
    reference = rows(pt.propagate(top, start, [50.0]))
    motions = [pt.propagate(top, start, [50.0], tolerance=tolerance) for tolerance in tolerances]
    errors = [np.max(np.abs(rows(motion) - reference)) for motion in motions]
    assert errors == sorted(errors, reverse=True)
    for tolerance, error in zip(tolerances, errors, strict=True):
        assert error < 1e3 * tolerance
    assert [motion.run.tolerance for motion in motions] == list(tolerances)
    work = [motion.run.steps * motion.run.order**2 for motion in motions]
    assert work == sorted(work)


UNITS = {"double": 2.0**-52, "quadruple": 2.0**-104}


@pytest.mark.parametrize("precision", UNITS)
def test_a_tolerance_below_the_rounding_unit_is_refused(top, start, precision):
    unit = UNITS[precision]
    assert pt.propagate(top, start, [0.1], precision=precision, tolerance=unit).run.tolerance == unit
    for tolerance in (0.9 * unit, 1e-60, 1e-320):
        sentence = (
            f"tolerance must be at least the rounding unit of {precision} precision, {unit}, got {tolerance}. "
            "Leave it out for that."
        )
        with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
            pt.propagate(top, start, [0.1], precision=precision, tolerance=tolerance)


@pytest.mark.parametrize("precision", UNITS)
def test_the_default_tolerance_is_the_rounding_unit(top, start, precision):
    assert pt.propagate(top, start, [0.1], precision=precision).run.tolerance == UNITS[precision]


def spinning_tops(count=48):
    """Return symmetric tops that spin about their axis with little nutation, and their starts."""
    rng = np.random.default_rng(1)
    tilt, moment, ratio = rng.uniform(0, 1.5, count), rng.uniform(0.5, 3, count), rng.uniform(0.3, 1.9, count)
    body = pt.Body(np.stack([moment, moment, ratio * moment], axis=-1))
    system = pt.System(body, pt.UniformGravity(rng.uniform(0.05, 0.5, count), (0, 0, 1)))
    omega = np.stack([*1e-3 * rng.normal(size=(2, count)), rng.uniform(1, 6, count)], axis=-1)
    turn = np.stack([np.cos(tilt / 2), np.sin(tilt / 2), 0 * tilt, 0 * tilt], axis=-1)
    return system, system.state(turn, omega_body=omega)


def near_a_point(count=8):
    """Return a homogeneous ellipsoid at a few radii of an attractor, and starts in which it tumbles."""
    rng = np.random.default_rng(3)
    place = pt.orbits.FixedPosition(0.9, position=(3.0, 0.0, 0.0) + 0.3 * rng.normal(size=(count, 3)))
    semiaxes = (1.3, 1.0, 0.7)
    body = pt.Body.from_ellipsoid(1.1, semiaxes)
    system = pt.System(body, pt.forces.EllipsoidGravity(place, 1.1, semiaxes))
    attitudes = Rotation.random(count, rng=rng).as_quat(scalar_first=True)
    return system, system.state(attitudes, omega_body=rng.normal(size=(count, 3)))


@pytest.mark.parametrize(
    ("kind", "end", "lower"), [(spinning_tops, 1e4, 1.72e-15), (near_a_point, 4e3, 2.32e-16)], ids=["18", "19"]
)
def test_no_energy_drifts_by_truncation_as_at_the_orders_below(kind, end, lower):
    """What these leave out has the same sign at every step."""
    system, state = kind()
    drift = {
        tolerance: np.max(np.abs(pt.propagate(system, state, [end], tolerance=tolerance).drift["energy"]))
        for tolerance in (None, lower)
    }
    assert drift[None] < 0.3 * drift[lower]


@pytest.mark.parametrize(
    "call",
    [
        lambda system, state, **tolerance: pt.analysis.chaos_indicators(system, state, [1.0], **tolerance),
        lambda system, state, **tolerance: pt.analysis.lyapunov_spectrum(system, state, [1.0], **tolerance),
        lambda system, state, **tolerance: pt.analysis.state_transition(system, state, [1.0], **tolerance),
        lambda system, state, **tolerance: pt.analysis.andoyer_section(system, state, 1.0, **tolerance),
        lambda system, _, **tolerance: pt.analysis.spin_orbit_section(
            pt.System(system.body, pt.GravityGradient(pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0))),
            0.0,
            1.5,
            1,
            **tolerance,
        ),
    ],
)
def test_whatever_takes_a_tolerance_refuses_one_below_the_rounding_unit(top, start, call):
    with pytest.raises(ValueError, match=r"^tolerance must be at least the rounding unit of double precision, "):
        call(top, start, tolerance=1e-60)


# ---------------------------------------------------------------------- interruption


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize("times", [np.array([0.0, 1e9]), np.linspace(0, 1e9, 100_001)], ids=["ends", "grid"])
def test_an_interrupt_is_heard_within_a_second(top, start, dense, times):
    pt.propagate(top, start, [0.0, 1.0], dense=dense)
    sent = []

    def interrupt():
        sent.append(clock.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        pt.propagate(top, start, times, dense=dense)
    assert clock.perf_counter() - sent[0] < 1.0
    timer.join()


def interrupted(system, state, times, **options):
    """The interrupt that stops a run after a fifth of a second."""
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        pt.propagate(system, state, times, **options)
    timer.join()
    return caught.value


def test_after_an_interrupt_the_next_run_is_right(top, start):
    before = pt.propagate(top, start, TIMES)
    interrupted(top, start, [0.0, 1e9])
    assert np.array_equal(rows(pt.propagate(top, start, TIMES)), rows(before))


@pytest.mark.parametrize("dense", [False, True])
def test_an_interrupt_of_the_way_forwards_skips_the_way_back(top, start, dense):
    pt.propagate(top, start, [0.0, 1.0], dense=dense)
    began = clock.perf_counter()
    interrupted(top, start, [-1e6, 1e9], dense=dense)
    assert clock.perf_counter() - began < 1.2


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize("direction", [1, -1])
def test_an_interrupt_keeps_what_was_reached(top, start, direction, dense):
    grid = direction * np.linspace(0, 1e9, 20_001)
    pt.propagate(top, start, grid[:2], dense=dense)  # compiled before the clock runs
    stop = interrupted(top, start, grid, dense=dense)
    reached = stop.trajectory.times
    assert reached.tolist() == grid[: len(reached)].tolist()
    assert abs(reached[-1]) <= abs(stop.time) < 1e9
    assert 1 <= len(reached) < len(grid)
    assert np.all(np.isfinite(rows(stop.trajectory)))
    assert max(np.max(np.abs(drift)) for drift in stop.trajectory.drift.values()) < 1e-11


@pytest.mark.parametrize("dense", [False, True])
def test_an_interrupt_at_any_call_loses_no_step(top, start, dense, monkeypatch):
    grid = np.linspace(0, 40, 401)
    whole = pt.propagate(top, start, grid, dense=dense)
    advance, lengths = queue.Worker.advance, set()

    def pressed(at):
        calls = itertools.count()

        def advanced(run, budget=None):  # noqa: ARG001
            left = advance(run, 5)
            if next(calls) == at:
                os.kill(os.getpid(), signal.SIGINT)
            return left

        return advanced

    for at in range(12):
        monkeypatch.setattr(queue.Worker, "advance", pressed(at))
        with pytest.raises(pt.PropagationInterrupted) as caught:
            pt.propagate(top, start, grid, dense=dense)
        motion = caught.value.trajectory
        assert motion.times.tolist() == grid[grid <= caught.value.time].tolist()
        assert np.array_equal(rows(motion), rows(whole)[: len(motion.times)])
        if dense:
            assert np.array_equal(motion(caught.value.time).quaternion, whole(caught.value.time).quaternion)
        lengths.add(len(motion.times))
    assert len(lengths) > 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


# ---------------------------------------------------------------------- singular runs


class Pole(pt.Torque):
    """A torque that is infinite at one time."""

    instant: float

    def torque(self, instant):
        return functions.Vector((1 / (self.instant - instant.time) ** 2, 0 * instant.time, 0 * instant.time))


class Root(pt.Torque):
    """A torque that is no real number after one time."""

    instant: float

    def torque(self, instant):
        return functions.Vector((functions.sqrt(self.instant - instant.time), 0 * instant.time, 0 * instant.time))


class Wall(pt.Potential):
    """A potential that is infinite where the third body axis is level, and repels or attracts."""

    strength: float

    def energy(self, instant):
        return self.strength / instant.attitude.to_body((0, 0, 1))[2] ** 2


def stopped(system, state, times, **options):
    with pytest.raises(pt.PropagationError) as caught:
        pt.propagate(system, state, times, **options)
    return caught.value


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize(("force", "direction"), [(Pole, 1), (Pole, -1), (Root, 1)])
def test_a_singular_time_stops_the_run_and_keeps_what_was_reached(body, start, force, direction, dense):
    system, grid = pt.System(body, force(direction * 5.25)), direction * np.linspace(0, 10, 21)
    error = stopped(system, start, grid, dense=dense)
    assert abs(error.time) == pytest.approx(5.25, abs=0.5)
    # The coefficient of a branch of power 3/2 at a distance d is 3e-4 d^1.5 over d^p: below e^-2p nobody sees it.
    assert abs(error.time) <= 5.25 + 1e-8
    reached = error.trajectory
    assert reached.times.tolist() == grid[: len(reached.times)].tolist()
    assert abs(error.time) - 0.5 <= abs(reached.times[-1]) <= abs(error.time)
    assert_same(reached, pt.propagate(system, start, reached.times), within=1e-12)


def test_a_stopped_run_says_where_it_got(body, start):
    error = stopped(pt.System(body, Pole(5.25)), start, np.linspace(0, 10, 21))
    assert re.fullmatch(
        r"propagation stopped at t = 5\.25 of 10: (the state became non-finite\. A force is|"
        r"the step size fell to rounding\. The equations are) singular there\.",
        str(error),
    )
    assert isinstance(error, RuntimeError)


def test_an_attracting_wall_stops_the_run(body):
    state = body.state((np.cos(0.5), np.sin(0.5), 0, 0), omega_body=(0.1, 0, 0))
    system = pt.System(body, Wall(-0.1))
    error = stopped(system, state, np.linspace(0, 10, 101))
    assert 0.5 < error.time < 5
    assert error.trajectory.times[-1] == pytest.approx(error.time, abs=0.1001)
    assert np.all(np.isfinite(rows(error.trajectory)))


def test_a_force_that_is_singular_at_the_start(body):
    class Everywhere(pt.Torque):
        size: float

        def torque(self, instant):
            return functions.Vector((1 / (self.size - self.size) + 0 * instant.time,) * 3)

    state = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3), time=2.0)
    error = stopped(pt.System(body, Everywhere(1.0)), state, np.linspace(2, 10, 5))
    assert error.time == 2.0
    assert str(error) == "propagation stopped at t = 2 of 10: the state became non-finite. A force is singular there."
    assert error.trajectory.times.size <= 1


def test_a_step_that_time_cannot_resolve_stops_the_run(body):
    state = body.state((1, 0, 0, 0), omega_body=(1e8, 1, 2), time=1e9)
    error = stopped(pt.System(body), state, [1e9 + 100])
    assert str(error) == (
        f"propagation stopped at t = {error.time:.10g} of 1000000100: the step size fell to rounding. "
        "The equations are singular there."
    )
    assert error.time == pytest.approx(1e9, abs=0.01)
    assert error.trajectory.times.size == 0


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize("direction", [1, -1])
def test_euler_angles_stop_near_their_singularity(body, direction, dense):
    state = body.state((np.cos(0.2), np.sin(0.2), 0, 0), omega_body=(-0.3 * direction, 0, 0))
    grid = direction * np.linspace(0, 10, 21)
    error = stopped(pt.System(body), state, grid, formulation="euler_angles", dense=dense)
    assert error.time == pytest.approx(direction * (0.4 - 1e-6) / 0.3, rel=1e-9, abs=0)
    assert str(error) == (
        f"propagation stopped at t = {error.time:.10g} of {direction * 10}: sin(theta) fell below 1e-6. "
        "The Euler angles 3-1-3 are singular there; use another formulation."
    )
    assert error.trajectory.times.tolist() == grid[:3].tolist()
    assert_same(error.trajectory, pt.propagate(pt.System(body), state, grid[:3]), within=1e-10)


def test_the_quaternions_pass_where_euler_angles_stop(body):
    state = body.state((np.cos(0.2), np.sin(0.2), 0, 0), omega_body=(-0.3, 0, 0))
    motion = pt.propagate(pt.System(body), state, [0.0, 4.0])
    assert np.allclose(motion.quaternion[1], [np.cos(0.4), -np.sin(0.4), 0, 0], rtol=0, atol=1e-14)


def test_partial_trajectory_can_be_read(body, start):
    reached = stopped(pt.System(body, Pole(5.25)), start, np.linspace(0, 10, 21)).trajectory
    assert reached.kinetic_energy.shape == reached.times.shape
    assert "times: 11" in repr(reached)


def test_both_directions_of_which_one_stops(body, start):
    error = stopped(pt.System(body, Pole(5.25)), start, np.linspace(-5, 10, 31))
    assert error.trajectory.times.tolist() == np.linspace(-5, 5, 21).tolist()
    error = stopped(pt.System(body, Pole(-4.75)), start, np.linspace(-5, 10, 31))
    assert error.trajectory.times.tolist() == np.linspace(-4.5, 10, 30).tolist()


def test_dense_output_ends_where_the_run_stopped(body, start):
    reached = stopped(pt.System(body, Pole(5.25)), start, [0.0, 10.0], dense=True).trajectory
    assert reached.times.tolist() == [0.0]
    assert np.allclose(
        reached(5.0).quaternion, pt.propagate(pt.System(body, Pole(5.25)), start, [5.0]).quaternion, rtol=0, atol=1e-14
    )
    with pytest.raises(ValueError, match=r"^time must lie within \[0, 5\.25\], got 6\.$"):
        reached(6.0)


def test_a_run_that_would_not_end_stops(body):
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 1e13))
    with pytest.raises(pt.PropagationError, match=r"of 10000: the steps became so short, 2e-13, that it would not end"):
        pt.propagate(pt.System(body), start, [0, 1e4])
    members = body.state([(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1e13), (0, 0, 0.1)])
    motion = pt.propagate(pt.System(body), members, [0, 1e4])
    assert list(motion.failures) == [0]
    assert np.all(np.isfinite(motion.quaternion[1]))
