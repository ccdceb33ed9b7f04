"""Branches of periodic motions: their derivatives, ends and bifurcations; what comes out, what goes in."""

import dataclasses
import re
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest

import poinsot as pt
from poinsot.analysis import continuation
from poinsot.analysis.continuation import continue_motion
from poinsot.analysis.continuation_problem import ContinuationProblem, NotConvergedError
from poinsot.systems.named_parameters import NamedNumber

mpl.use("Agg")

BODY = pt.Body((1.0, 1.3, 1.6))
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.3, node=0.2, argument_of_periapsis=0.1)
ELLIPSE = pt.KeplerOrbit(
    1.1,
    semimajor_axis=1.2,
    eccentricity=0.07,
    inclination=0.3,
    node=0.5,
    argument_of_periapsis=2.1,
    true_anomaly=1.0,
    epoch=-0.4,
)


def system(orbit, *more, body=BODY):
    return pt.System(body, pt.GravityGradient(orbit), *more)


def at_rest(orbit=CIRCLE, share=0.2, body=BODY, *more):
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    return pt.analysis.periodic_motion(system(orbit, *more, body=body), start, share * orbit.period, orbit.frame)


def orbit_of(system):
    return system.forces[0].orbit


@pytest.fixture(scope="module")
def branch():
    """Through the boundary of stability in pitch."""
    return continue_motion(at_rest(), "moments[0]", 1.5)


# ---------------------------------------------------------------------- named numbers


def test_named_number_changes_one_number_of_the_orbit_that_forces_share():
    flat = pt.forces.Oblateness(ELLIPSE, 1e-3, 0.1, (0, 0, 1))
    own = system(ELLIPSE, flat)
    number = NamedNumber(own, "eccentricity")
    assert (number.name, number.value) == ("forces[0].orbit.eccentricity", 0.07)
    other: Any = number.system(0.2)
    assert other.forces[0].orbit is other.forces[1].orbit
    assert other.forces[0].orbit.eccentricity == 0.2
    assert other.forces[0].orbit.semimajor_axis == ELLIPSE.semimajor_axis
    assert other.body is own.body
    assert own.forces[0].orbit.eccentricity == 0.07
    pole: Any = NamedNumber(own, "pole[2]").system(0.5)
    assert pole.forces[1].pole.tolist() == [0, 0, 0.5]
    assert pole.forces[0] is own.forces[0]
    assert NamedNumber(own, "body.moments[1]").system(1.4).body.moments.tolist() == [1.0, 1.4, 1.6]


# ---------------------------------------------------------------------- derivatives


def node_frame(system):
    orbit = orbit_of(system)
    return pt.RotatingFrame((1, 0, 0, 0), (0, 0, float(orbit.node_rate)), -0.7)


SLOPES: dict[str, Any] = {
    "force": (ELLIPSE, "eccentricity", None, None, None),
    "moment": (ELLIPSE, "moments[1]", None, None, None),
    "period": (ELLIPSE, "semimajor_axis", lambda system: orbit_of(system).period, None, None),
    "frame": (pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=-0.004), "node_rate", None, node_frame, node_frame),
    "frame of the orbit": (CIRCLE, "inclination", None, lambda system: orbit_of(system).frame, lambda _: CIRCLE.frame),
    "period and frame": (
        CIRCLE,
        "mu",
        lambda system: orbit_of(system).period,
        lambda system: orbit_of(system).frame,
        lambda _: CIRCLE.frame,
    ),
}


@pytest.mark.parametrize("name", SLOPES)
def test_derivative_by_the_parameter_is_that_of_differences(name):
    orbit, parameter, period, frame, own = SLOPES[name]
    start = BODY.state((0.9, 0.1, -0.2, 0.3) / np.sqrt(0.95), omega_body=(0.1, -0.2, 0.9))
    one = system(orbit)
    motion = pt.analysis.periodic_motion(one, at_upright(orbit), orbit.period, own and own(one))
    number = NamedNumber(one, parameter)
    problem = ContinuationProblem(number, 1.3 * number.value + 0.1, motion, period, frame)
    mapping = problem.mapping(0.5)
    point = mapping.point(start)  # of no periodic motion
    _, slopes = problem.equations(mapping, point, 0.5)

    def end(u):
        other = problem.mapping(u)
        other.units = mapping.units
        return other.passage(point).end

    middle, h = end(0.5), 1e-3
    ends = [mapping.displacement(middle, end(0.5 + k * h)) for k in (-2, -1, 1, 2)]
    difference = np.array([1, -8, 8, -1]) @ ends / (12 * h)
    np.testing.assert_allclose(-slopes[:, 6], difference, rtol=0, atol=3e-9 * max(1, np.max(np.abs(difference))))


def spinning():
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    return pt.analysis.periodic_motion(pt.System(BODY), start, 2 * np.pi)


def at_upright(orbit):
    return BODY.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)


def test_motion_in_a_larger_orbit_is_the_same_in_units_of_its_period():
    motion = pt.analysis.periodic_motion(system(ELLIPSE), at_upright(ELLIPSE), ELLIPSE.period)
    with pytest.raises(ValueError, match="system must repeat itself in the frame after the period"):
        continue_motion(motion, "semimajor_axis", 1.4)
    branch = continue_motion(motion, "semimajor_axis", 1.4, period=lambda system: orbit_of(system).period)
    np.testing.assert_allclose(branch.periods, ELLIPSE.period * (branch.values / 1.2) ** 1.5, rtol=1e-14)
    for multipliers in branch.multipliers:
        np.testing.assert_allclose(np.poly(multipliers), np.poly(motion.multipliers), rtol=0, atol=1e-11)


# ---------------------------------------------------------------------- branches


def test_points_of_a_branch_are_periodic_motions(branch):
    for value, motion in zip(branch.values[::5], branch.motions[::5], strict=True):
        assert motion.system.body.moments[0] == value
        again = pt.analysis.periodic_motion(motion.system, motion.state, motion.period, motion.frame)
        np.testing.assert_allclose(again.state.quaternion, motion.state.quaternion, rtol=0, atol=1e-13)
        np.testing.assert_allclose(again.matrix, motion.matrix, rtol=0, atol=1e-12)


def test_arrays_of_a_branch_fit_together(branch):
    n = len(branch.motions)
    assert branch.values[0] == 1.0
    assert branch.values[-1] == 1.5
    assert np.all(np.diff(branch.values) > 0)
    assert branch.state.quaternion.shape == (n, 4)
    assert branch.multipliers.shape == (n, 6)
    assert branch.periods.shape == branch.stable.shape == (n,)
    (found,) = branch.bifurcations
    assert branch.values[found.after] < found.value < branch.values[found.after + 1]
    assert np.all(branch.stable == (branch.values < found.value))
    title, *lines = repr(branch).splitlines()
    assert title == "Branch of periodic motions along body.moments[0]"
    assert re.fullmatch(r"  motions: \d+, \d+ stable", lines[0])
    assert lines[1] == "  values: 1 ... 1.5"
    assert lines[3:] == ["  bifurcations: branching at 1.3", "  ending: body.moments[0] = 1.5"]


def test_backwards_it_is_the_same_branch(branch):
    back = continue_motion(branch.motions[-1], "moments[0]", 1.0)
    assert back.bifurcations[0].value == pytest.approx(branch.bifurcations[0].value, abs=1e-12)
    np.testing.assert_allclose(back.motions[-1].matrix, branch.motions[0].matrix, rtol=0, atol=1e-13)


def test_it_ends_where_no_body_has_the_moments():
    branch = continue_motion(at_rest(body=pt.Body((1.0, 1.2, 1.5))), "moments[2]", 2.5)
    assert re.fullmatch(r"beyond body\.moments\[2\] = 2\.199\d+: moments must satisfy .*", branch.ending)
    assert 2.19 < branch.values[-1] < 2.2


class Windmill(pt.Torque):
    """It slows down, or speeds up, what turns in the frame of a circular orbit."""

    strength: float

    def torque(self, instant):
        normal = instant.attitude.to_body(tuple(CIRCLE.normal))
        return tuple(-self.strength * (w - n) for w, n in zip(instant.omega_body, normal, strict=True))


def test_pairs_pass_the_unit_circle_where_friction_becomes_propulsion():
    motion = at_rest(CIRCLE, 0.2, BODY, Windmill(0.01))
    branch = continue_motion(motion, "strength", -0.02)
    (found,) = branch.bifurcations
    assert found.kind == "torus"
    assert found.value == pytest.approx(0, abs=1e-9)
    assert found.change == 6
    assert np.all(branch.stable == (branch.values > 0))


def test_function_is_followed_as_the_number_that_it_changes(branch):
    """With a moment as a function, the branch, what crosses it, and its bifurcations are those of the named number."""
    same = continue_motion(at_rest(), of_moment, 1.5, start=1.0)
    np.testing.assert_allclose(same.values, branch.values, rtol=0, atol=1e-12)
    for own, other in zip(same.motions[::4], branch.motions[::4], strict=True):
        np.testing.assert_allclose(own.matrix, other.matrix, rtol=0, atol=1e-12)
    (found,) = same.bifurcations
    assert found.value == pytest.approx(branch.bifurcations[0].value, abs=1e-12)
    assert found.interval == (found.value, found.value)


def test_interrupted_continuation_keeps_what_it_has(monkeypatch):
    def stop(more, part):
        if len(reports) == 5:
            raise KeyboardInterrupt
        reports.append((more, part))

    reports = []
    monkeypatch.setattr(continuation, "bar", lambda *_: _Context(stop))
    with pytest.raises(
        pt.PropagationInterrupted, match=r"the continuation was interrupted at body\.moments\[0\] ="
    ) as raised:
        continue_motion(at_rest(), "moments[0]", 1.5)
    assert len(raised.value.trajectory.motions) == 7
    assert raised.value.trajectory.ending == "it was interrupted"


class _Context:
    def __init__(self, value):
        self.value = value

    def __enter__(self):
        return self.value

    def __exit__(self, *_):
        return False


def test_it_ends_after_many_points(monkeypatch):
    monkeypatch.setattr(continuation, "MAX_POINTS", 3)
    branch = continue_motion(at_rest(), "moments[0]", 1.5)
    assert (len(branch.motions), branch.ending) == (3, "it has 3 motions")


def test_what_is_not_found_is_unresolved(monkeypatch, branch):
    def lost(*_, **__):
        raise NotConvergedError

    monkeypatch.setattr("scipy.optimize.brentq", lost)
    (found,) = continue_motion(at_rest(), "moments[0]", 1.5).bifurcations
    assert (found.kind, found.change) == ("unresolved", 1)
    assert found.interval == tuple(branch.values[found.after : found.after + 2])
    assert found.value == found.interval[0]


def test_messages_come_after_a_while(monkeypatch, capsys):
    monkeypatch.setattr("poinsot.display.progress.DELAY", 0.01)
    monkeypatch.setenv("FORCE_COLOR", "1")
    continue_motion(at_rest(), "moments[0]", 1.4, progress=True)
    assert "motions, body.moments[0] = " in capsys.readouterr().err
    continue_motion(at_rest(), "moments[0]", 1.05, progress=False)
    assert not capsys.readouterr().err


# ---------------------------------------------------------------------- pictures


def test_picture_changes_its_line_where_stability_changes(branch):
    axes = pt.plot.branch(branch, lambda motion: motion.period, ("moment [kg m²]", "period [s]"), title="title")
    solid, dashed, mark = axes.get_lines()
    (found,) = branch.bifurcations
    assert (solid.get_label(), solid.get_linestyle()) == ("stable", "-")
    assert (dashed.get_label(), dashed.get_linestyle()) == ("unstable", "--")
    stable, unstable, at = (np.asarray(line.get_xdata()) for line in (solid, dashed, mark))
    assert stable[-1] == unstable[0] == at[0] == found.value
    assert len(stable) + len(unstable) == len(branch.values) + 2
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("moment [kg m²]", "period [s]")
    both = pt.plot.branch([branch, branch], lambda motion: motion.period, ("a", "b"))
    assert len(both.get_legend().get_texts()) == 3
    with pytest.raises(TypeError, match=r"a list, each a Branch, got list of PeriodicMotion\."):
        pt.plot.branch([branch.motions[0]], lambda motion: motion.period, ("a", "b"))
    with pytest.raises(TypeError, match=r"branch must be a Branch or a list, each a Branch, got PeriodicMotion\."):
        pt.plot.branch(branch.motions[0], lambda motion: motion.period, ("a", "b"))
    with pytest.raises(ValueError, match=r"branch must be a Branch or several, got none\."):
        pt.plot.branch([], lambda motion: motion.period, ("a", "b"))
    with pytest.raises(TypeError, match=r"quantity must be a function of one value, got str 'period'\."):
        pt.plot.branch(branch, "period", ("a", "b"))
    with pytest.raises(ValueError, match=r"the quantity of a motion must have shape \(\), got shape \(6, 6\)\."):
        pt.plot.branch(branch, lambda motion: motion.matrix, ("a", "b"))
    with pytest.raises(TypeError, match=r"labels must be a list of 2, each a text, got str 'e'\."):
        pt.plot.branch(branch, lambda motion: motion.period, "e")


# ---------------------------------------------------------------------- wrong input


def at_a_fold():
    found = continue_motion(at_rest(), "moments[0]", 1.5).bifurcations[0]
    return dataclasses.replace(found, kind="fold")


def crossing(parameter, **changed):
    found = continue_motion(at_rest(), "moments[0]", 1.5).bifurcations[0]
    return continue_motion(dataclasses.replace(found, kind="branching", **changed), parameter, 1.5)


def with_a_torque(value):
    return system(CIRCLE, Windmill(0.0), body=pt.Body((value, 1.3, 1.6)))


def of_moment(value):
    return system(CIRCLE, body=pt.Body((value, 1.3, 1.6)))


def some_forces(value):
    return of_moment(value) if value > 1 + 5e-7 else with_a_torque(value)


WRONG = {
    "no start": (
        lambda: continue_motion(at_rest(), of_moment, 1.5),
        ValueError,
        r"start must be the value at which parameter returns the system of the motion, got None\.",
    ),
    "parameter": (
        lambda: continue_motion(at_rest(), 3, 1.5),
        TypeError,
        r"parameter must be a text or a function of one value, got int 3\.",
    ),
    "no system": (
        lambda: continue_motion(at_rest(), lambda value: value, 1.5, start=1.0),
        TypeError,
        r"parameter must return a System, got float\.",
    ),
    "other forces": (
        lambda: continue_motion(at_rest(), some_forces, 1.1, start=1.0),
        ValueError,
        r"parameter must return systems that differ in numbers alone, got other forces or orbits\.",
    ),
    "a branching of another system": (
        lambda: crossing(lambda value: system(CIRCLE, pt.forces.LinearDamping(0.1), body=pt.Body((value, 1.3, 1.6)))),
        ValueError,
        r"motion must repeat itself after the period and in the frame of <lambda> = 1\.3, but it does not\. "
        r"The functions period and frame must return its own there\.",
    ),
    "a branching that goes on elsewhere": (
        lambda: crossing("moments[0]", tangent=np.array([1, 0, 0, 0, 0, 0, 1e-4])),
        ValueError,
        r"motion must have a crossing branch, got branching at 1\.3 with none near\.",
    ),
    "a fold": (
        lambda: continue_motion(at_a_fold(), "moments[0]", 1.5),
        ValueError,
        r"motion must be a branching or a doubling where it is a Bifurcation, got a fold\.",
    ),
    "motion": (
        lambda: continue_motion(system(CIRCLE), "mu", 2.0),
        TypeError,
        r"motion must be a PeriodicMotion or a Bifurcation, got System\. The order is continue_motion\(.*\)\.",
    ),
    "name": (lambda: continue_motion(at_rest(), "eccentric", 0.1), ValueError, r".*Near: forces\[0\]\.orbit\.ecc.*"),
    "value": (
        lambda: continue_motion(at_rest(), "moments[0]", 1.0),
        ValueError,
        r"to must be another value than that of body\.moments\[0\], got 1\.0\.",
    ),
    "not finite": (lambda: continue_motion(at_rest(), "moments[0]", np.nan), ValueError, r"to must be finite, .*"),
    "frame": (
        lambda: continue_motion(at_rest(), "mu", 2.0, frame=lambda _: 1),
        TypeError,
        r"frame must be a Frame, got int\. .*",
    ),
    "period": (
        lambda: continue_motion(at_rest(), "mu", 2.0, period=lambda _: -1.0),
        ValueError,
        r"period must be positive, got -1\.0\.",
    ),
    "another period": (
        lambda: continue_motion(spinning(), "moments[0]", 1.1, period=lambda _: 5.0),
        ValueError,
        r"motion must repeat itself after the period and in the frame of body\.moments\[0\] = 1, but it does not\. "
        r"The functions period and frame must return its own there\.",
    ),
    "period that is no function": (
        lambda: continue_motion(spinning(), "moments[0]", 1.1, period=5.0),
        TypeError,
        r"period must be a function of one value, got float 5\.0\.",
    ),
    "frame that stays": (
        lambda: continue_motion(at_rest(), "inclination", 0.5),
        ValueError,
        r"system must repeat itself in the frame .*",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_refused_with_a_sentence(name):
    call, kind, sentence = WRONG[name]
    with pytest.raises(kind) as raised:
        call()
    assert re.fullmatch(sentence, str(raised.value)), str(raised.value)
