"""Chaos indicators: ensembles, directions of time, failures, and what is refused."""

import os
import re
import signal

import numpy as np
import pytest

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.analysis import chaos
from poinsot.forces.damping import LinearDamping

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
BODY = pt.Body.from_ratios(beta=0.47, gamma=0.26)
SYSTEM = pt.System(BODY, pt.GravityGradient(ORBIT))
TOP = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(0.5, (1, 0.2, -0.3)))
NAMES = ("growth", "fli", "megno", "mean_megno", "gali", "lyapunov")


def states(members, seed=1, time=0.0):
    random = np.random.default_rng(seed)
    q = random.normal(size=(members, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    g = random.normal(size=(members, 3))
    return pt.State(q, 2 * quat.product(q, quat.pure(g)), time)


def member(batch, i):
    time = batch.time[i] if batch.time.ndim else batch.time
    return pt.State(batch.quaternion[i], batch.conjugate_momenta[i], time)


def assert_same(found, i, alone, within=1e-9):
    for name in NAMES:
        np.testing.assert_allclose(getattr(found, name)[i], getattr(alone, name), rtol=within, atol=within)


# ---------------------------------------------------------------------- members and times


@pytest.mark.parametrize("system", [SYSTEM, TOP], ids=["satellite", "top"])
def test_members_are_as_they_are_alone(system):
    batch, times = states(19), [1.0, 2.5, 6.0]
    found = pt.analysis.chaos_indicators(system, batch, times, vectors=2, momentum_unit=2.0)
    assert found.growth.shape == (19, 3)
    assert found.failures == {}
    assert np.array_equal(found.momentum_unit, np.full(19, 2.0))
    for i in (0, 7, 18):
        alone = pt.analysis.chaos_indicators(system, member(batch, i), times, vectors=2, momentum_unit=2.0)
        assert alone.growth.shape == (3,)
        for name in ("growth", "gali", "lyapunov"):
            np.testing.assert_allclose(getattr(found, name)[i], getattr(alone, name), rtol=1e-12, atol=1e-12)
        for name in ("fli", "megno", "mean_megno"):  # sampled more densely where another member is faster
            np.testing.assert_allclose(getattr(found, name)[i], getattr(alone, name), rtol=0.02, atol=0.02)


def test_grids_of_parameters():
    shapes = np.linspace(0.05, 0.9, 12)
    eccentricities = np.linspace(0, 0.3, 12)
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1.1))

    def system(i):
        body = pt.Body(np.stack(np.broadcast_arrays(1 - 0.3 * shapes[i], 1.0, 1.1), axis=-1))
        return pt.System(
            body, pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=eccentricities[i]))
        )

    for formulation in ("planar", None):
        options = {"formulation": formulation, "momentum_unit": 1.0}
        found = pt.analysis.chaos_indicators(system(slice(None)), start, [3.0, 20.0], **options)
        assert found.mean_megno.shape == (12, 2)
        for i in (0, 5, 11):
            alone = pt.analysis.chaos_indicators(system(i), start, [3.0, 20.0], **options)
            np.testing.assert_allclose(found.growth[i], alone.growth, rtol=0, atol=1e-11)
            np.testing.assert_allclose(found.mean_megno[i], alone.mean_megno, rtol=0, atol=0.02)  # along other steps


def test_members_that_start_at_their_own_times():
    batch, times = states(9, time=np.linspace(0, 4, 9)), [5.0, 9.0, 15.0]
    found = pt.analysis.chaos_indicators(SYSTEM, batch, times)
    for i in (0, 3, 8):
        alone = pt.analysis.chaos_indicators(SYSTEM, member(batch, i), times)
        np.testing.assert_allclose(found.growth[i], alone.growth, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.lyapunov[i], alone.lyapunov, rtol=0, atol=1e-12)
        for name in ("megno", "mean_megno", "fli"):
            np.testing.assert_allclose(getattr(found, name)[i], getattr(alone, name), rtol=0, atol=0.02)


def test_the_order_of_the_times_and_more_of_them_change_little():
    batch = states(9)
    coarse = pt.analysis.chaos_indicators(SYSTEM, batch, [-20.0, -5.0, -1.0])
    assert np.all(np.diff(coarse.fli, axis=-1) <= 0)
    turned = pt.analysis.chaos_indicators(SYSTEM, batch, [-1.0, -5.0, -20.0])
    for name in NAMES:
        np.testing.assert_array_equal(getattr(coarse, name), getattr(turned, name)[:, ::-1])
    dense = pt.analysis.chaos_indicators(SYSTEM, batch, np.linspace(-20, -0.005, 4000))
    np.testing.assert_allclose(dense.growth[:, 0], coarse.growth[:, 0], rtol=0, atol=1e-12)
    for name in ("megno", "mean_megno", "fli"):
        np.testing.assert_allclose(getattr(dense, name)[:, 0], getattr(coarse, name)[:, 0], rtol=5e-3, atol=0.02)


def test_at_the_start_nothing_has_grown():
    found = pt.analysis.chaos_indicators(SYSTEM, states(3), [0.0, 1.0], vectors=2)
    np.testing.assert_allclose(found.growth[:, 0], 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.gali[:, 0], 1, rtol=1e-14)
    assert np.all(found.megno[:, 0] == 0)
    assert np.all(np.isnan(found.lyapunov[:, 0]))
    only = pt.analysis.chaos_indicators(SYSTEM, states(3), [0.0])
    np.testing.assert_allclose(only.growth, 0, rtol=0, atol=1e-15)


def test_the_unit_of_momentum_weighs_the_components():
    batch = states(4)
    one, other = (pt.analysis.chaos_indicators(TOP, batch, [1e-7], momentum_unit=unit) for unit in (1e-3, 10.0))
    assert np.max(np.abs(one.growth)) < 1e-4
    assert np.max(np.abs(other.growth)) < 1e-4
    far, near = (pt.analysis.chaos_indicators(TOP, batch, [400.0], momentum_unit=unit).lyapunov for unit in (0.1, 10.0))
    np.testing.assert_allclose(far, near, rtol=0, atol=2 * np.log(100) / 400)


def test_the_unit_of_momentum_by_default():
    circle = pt.System(
        BODY, pt.GravityGradient(pt.KeplerOrbit(8.0, semimajor_axis=2.0, eccentricity=0.0, inclination=0.3))
    )
    found = pt.analysis.chaos_indicators(circle, states(3), [1.0])
    assert found.momentum_unit == pytest.approx(np.max(BODY.moments) * 1.0)  # at the mean motion
    body = pt.Body((1.0, 2.0, 2.5))
    spinning = body.state(states(2).quaternion, angular_momentum_body=np.array([(0, 0, 1.0), (0, 3.0, 0)]))
    found = pt.analysis.chaos_indicators(pt.System(body), spinning, [1.0])
    assert found.momentum_unit == pytest.approx(np.array([1.0, 3.0]) / 1.0 * 2.5)
    np.testing.assert_allclose(np.linalg.norm(found.vectors, axis=-1), 1.0, rtol=1e-14)


@pytest.mark.parametrize("kind", ["orbit", "point", "top"])
@pytest.mark.parametrize("faster", [1e-4, 1e5])
def test_the_unit_of_time_does_not_matter(kind, faster):
    def indicators(pace):
        if kind == "orbit":
            forces: pt.Potential = pt.GravityGradient(
                pt.KeplerOrbit(pace**2, semimajor_axis=1.0, eccentricity=0.1, inclination=0.3)
            )
        elif kind == "point":
            forces = pt.GravityGradient(pt.orbits.FixedPosition(0.3 * pace**2, position=(1.0, 0.2, 0)))
        else:
            forces = pt.UniformGravity(0.5 * pace**2, (1, 0.2, -0.3))
        start = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=pace * np.array((0.4, -0.3, 0.6)), time=2 / pace)
        system, times = pt.System(BODY, forces), np.array([5.0, 20.0]) / pace
        return pt.analysis.chaos_indicators(system, start, times), pt.analysis.lyapunov_spectrum(system, start, times)

    (one, spectrum), (other, scaled) = indicators(1.0), indicators(faster)
    for name in ("growth", "fli", "megno", "mean_megno"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.lyapunov, one.lyapunov * faster, rtol=1e-12)
    np.testing.assert_allclose(scaled.exponents, spectrum.exponents * faster, rtol=0, atol=1e-12 * faster)
    assert scaled.exponents[-1, 0] == pytest.approx(other.lyapunov[-1], rel=1e-12, abs=0)


def test_the_whole_spectrum_of_an_ensemble():
    batch, times = states(5), [3.0, 10.0]
    found = pt.analysis.lyapunov_spectrum(SYSTEM, batch, times)
    assert found.exponents.shape == (5, 2, 6)
    for i in range(5):
        alone = pt.analysis.lyapunov_spectrum(SYSTEM, member(batch, i), times)
        np.testing.assert_allclose(found.exponents[i], alone.exponents, rtol=0, atol=1e-12)
    assert found.run.steps > 0
    damped = pt.System(BODY, *SYSTEM.forces, LinearDamping(0.1))
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1.5))
    planar = pt.analysis.lyapunov_spectrum(damped, start, [40.0], formulation="planar")
    assert planar.exponents.shape == (1, 2)
    assert np.sum(planar.exponents) == pytest.approx(-0.1 / BODY.moments[2], rel=1e-13, abs=0)
    title, *lines = repr(planar).splitlines()
    assert title.startswith("Lyapunov spectrum of System(")
    assert lines[0] == "  times: 1, 40 ... 40"
    assert lines[1].startswith("  exponents at the last time: [")


def test_a_spectrum_counts_from_the_start():
    early, late = states(2), states(2, time=7.0)
    one, other = (
        pt.analysis.lyapunov_spectrum(TOP, start, [t + 3.0, t + 10.0]) for start, t in ((early, 0.0), (late, 7.0))
    )
    np.testing.assert_allclose(one.exponents, other.exponents, rtol=0, atol=1e-12)


def test_it_does_not_matter_how_often_vectors_are_made_orthogonal(monkeypatch):
    batch, times = states(4), [30.0]
    few = pt.analysis.lyapunov_spectrum(TOP, batch, times).exponents
    monkeypatch.setattr(chaos, "ORTHOGONALISATION_ANGLE", 1.0)
    many = pt.analysis.lyapunov_spectrum(TOP, batch, times).exponents
    np.testing.assert_allclose(few, many, rtol=0, atol=1e-12)


# ---------------------------------------------------------------------- what goes wrong


class Pole(pt.Torque):
    """A torque that is infinite at one time."""

    instant: float

    def torque(self, instant):
        return (1 / (self.instant - instant.time) ** 2, 0.0, 0.0)


def test_a_member_that_stops_is_nan_from_there_on():
    system = pt.System(BODY, Pole(np.array([50.0, 5.25, 50.0])))
    start, times = member(states(1), 0), np.arange(1.0, 9.0)
    found = pt.analysis.chaos_indicators(system, start, times, vectors=2)
    assert list(found.failures) == [1]
    assert "members: 3, 1 failed" in repr(found)
    for name in NAMES:
        finite = np.isfinite(getattr(found, name))
        assert finite.sum(axis=1).tolist() == [8, 5, 8], name
    spectrum = pt.analysis.lyapunov_spectrum(system, start, times)
    assert list(spectrum.failures) == [1]
    assert np.isfinite(spectrum.exponents[..., 0]).sum(axis=1).tolist() == [8, 5, 8]


def test_a_single_body_that_stops_says_where():
    system, start = pt.System(BODY, Pole(5.25)), member(states(1), 0)
    with pytest.raises(pt.PropagationError, match=r"^propagation stopped at t = 5\.\d+ of 8") as caught:
        pt.analysis.chaos_indicators(system, start, [2.0, 8.0])
    assert caught.value.time == pytest.approx(5.25, abs=0.01)
    assert np.isfinite(caught.value.trajectory.growth).tolist() == [True, False]
    with pytest.raises(pt.PropagationError, match=r"^propagation stopped at t = 5\.\d+ of ") as caught:
        pt.analysis.lyapunov_spectrum(system, start, [2.0, 8.0])
    assert caught.value.trajectory.exponents.shape == (1, 6)


def test_an_interrupt_keeps_the_finished_members(monkeypatch):
    taken, take = [], chaos._Indicators.take

    def take_and_interrupt(self, members, *rest):
        take(self, members, *rest)
        taken.append(len(members))
        if len(taken) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(chaos._Indicators, "take", take_and_interrupt)
    sentence = r"^the integration was interrupted: \d+ of 20000 members are done\.$"
    with pytest.raises(pt.PropagationInterrupted, match=sentence) as caught:
        pt.analysis.chaos_indicators(TOP, states(20_000), [100.0, 300.0], threads=2)
    found = caught.value.trajectory
    done = np.flatnonzero(np.isfinite(found.mean_megno[:, -1]))
    assert 0 < done.size < 20_000
    assert f" {done.size} of 20000" in str(caught.value)
    alone = pt.analysis.chaos_indicators(TOP, member(states(20_000), done[0]), [100.0, 300.0])
    np.testing.assert_allclose(found.lyapunov[done[0], 0], alone.lyapunov[0], rtol=0, atol=1e-12)


def test_an_interrupted_spectrum_keeps_the_times_before(monkeypatch):
    calls, orthonormalise = [], chaos._OrthonormalVectors.orthonormalise

    def interrupted(vectors, end):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        orthonormalise(vectors, end)

    monkeypatch.setattr(chaos._OrthonormalVectors, "orthonormalise", interrupted)
    sentence = r"^the integration was interrupted at t = 0\.2 of 0\.3\.$"
    with pytest.raises(pt.PropagationInterrupted, match=sentence) as caught:
        pt.analysis.lyapunov_spectrum(TOP, member(states(1), 0), [0.1, 0.2, 0.3])
    assert caught.value.time == 0.2
    assert caught.value.trajectory.times.tolist() == [0.1, 0.2]
    assert caught.value.trajectory.exponents.shape == (2, 6)


def test_no_bar_is_shown_where_none_is_wanted(capsys):
    pt.analysis.chaos_indicators(TOP, states(20), [1.0], progress=False)
    pt.analysis.lyapunov_spectrum(TOP, states(20), [1.0], progress=False)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("arguments", "options", "sentence"),
    [
        (([1.0],), {"vectors": 7}, "vectors must be a whole number from 1 to 6, got 7."),
        (([1.0],), {"momentum_unit": 0.0}, "momentum_unit must be positive, got 0.0."),
        (
            ([-1.0, 1.0],),
            {},
            "times must all lie after the state's time or all before, got [-1, 1] from 0.",
        ),
        (
            ([1.0],),
            {"formulation": "canonical"},
            "formulation must be one of lie_poisson, planar for variational equations, got 'canonical'.",
        ),
    ],
)
def test_bad_input(arguments, options, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.analysis.chaos_indicators(TOP, states(2), *arguments, **options)


@pytest.mark.parametrize(
    ("times", "state", "sentence"),
    [
        ([0.0, 1.0], states(2), "times must rise from the state's time, 0, got [0, ... 1]."),
        ([2.0, 1.0], states(2), "times must rise from the state's time, 0, got [2, ... 1]."),
        (
            [9.0],
            states(2, time=np.array([0.0, 2.0])),
            "state must have one time for a spectrum, got 0 and 2.",
        ),
    ],
)
def test_times_of_a_spectrum(times, state, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.analysis.lyapunov_spectrum(TOP, state, times)


class Controller(pt.Torque):
    """A torque that jumps where the body turns past an angle, and one that goes against the rate up to a limit."""

    size: float
    limit: float

    def torque(self, instant):
        fn = pt.functions
        sine, _, _ = instant.attitude.to_body((0, 0, 1))
        push = fn.where(fn.less(sine, 0.1), self.size, -self.size)
        x, y, z = instant.omega_body
        return push, -fn.clip(0.3 * y, -self.limit, self.limit), fn.where(fn.less(x * z, 0.0), 0.02, 0.0)


def test_vectors_grow_through_jumps_as_the_matrix_says():
    """Some hundred steps with two dozen jumps: vectors are rescaled on the way."""
    system, start, times = pt.System(BODY, Controller(0.1, 0.05)), states(3, seed=4), [20.0, 60.0]
    found = pt.analysis.chaos_indicators(system, start, times, vectors=2)
    assert np.all(found.run.steps > 200)
    matrix = pt.analysis.state_transition(system, start, times).matrix
    units = found.units[:, None, :]
    u = np.einsum("mnij,mnj->mni", matrix, found.vectors[0] * units + np.zeros((3, 2, 6))) / units
    np.testing.assert_allclose(found.growth, np.log(np.linalg.norm(u, axis=-1)), rtol=0, atol=1e-11)
    alone = pt.analysis.chaos_indicators(system, member(start, 1), times, vectors=2)
    np.testing.assert_allclose(found.growth[1], alone.growth, rtol=0, atol=1e-11)
