"""Tests of fits to gyros, star trackers and light curves."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import chi2

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.estimation import Arc, Prior, fit, information
from poinsot.estimation.priors import Posterior
from poinsot.estimation.unknowns import Unknowns
from poinsot.observables import Gyro, LightCurve, LommelSeeliger, Readings, StarTracker

CASES = json.loads((Path(__file__).parents[2] / "oracles" / "batch_fits.json").read_text())
SIGMAS = 1e-9  # three times the largest difference in standard deviations over the cases, rounded up to a power of ten
SEMIAXES = CASES["light_curve_fit"]["semi_axes"]


class Thrust(pt.Torque):
    """Torque along a fixed body axis."""

    size: float
    direction: pt.BodyVector

    def torque(self, instant):  # noqa: ARG002
        return self.size * pt.functions.Vector(self.direction)


def unit(q):
    return np.array(q) / np.linalg.norm(q)


def gyro_problem():
    case = CASES["gyro_fit"]
    start = case["start"]
    system = pt.System(pt.Body((*start["moments"][:2], case["moments_2"])))
    state = system.state((1, 0, 0, 0), angular_momentum_body=start["angular_momentum_body"])
    return system, state, Readings(Gyro(noise=case["sigma"]), case["times"], case["omega"])


def curve_of(night):
    places = {
        name: pt.orbits.FixedPosition(1.0, position=-np.array(night[f"to_{name}"])) for name in ("sun", "observer")
    }
    shape, law = pt.shapes.Ellipsoid(SEMIAXES, density=1.0), LommelSeeliger(albedo=CASES["light_curve_fit"]["w"])
    curve = LightCurve(shape, law, **places, kind="relative", light_time=False)
    return Readings(curve, night["times"], night.get("flux"), night["sigma"])


def curve_problem(numbers):
    case = CASES["light_curve_fit"]
    body = pt.Body((numbers["moments_0"], *case["moments"][1:]))
    system = pt.System(body, Thrust(numbers["torque"], case["torque_direction_body"]))
    state = system.state(unit(numbers["quaternion"]), angular_momentum_body=numbers["angular_momentum_body"])
    return system, state, [Prior("size", case["prior"]["torque"], case["prior"]["sigma"])]


def test_gyro_fit_agrees_with_40_digits():
    case, (system, state, data) = CASES["gyro_fit"], gyro_problem()
    found = fit(system, state, [data], ["angular_momentum_body", "moments[0]", "moments[1]", "bias"])
    sigma = np.sqrt(np.diag(case["covariance"]))
    assert found.converged
    np.testing.assert_allclose((np.array([*found.values.values()]) - case["estimate"]) / sigma, 0, rtol=0, atol=SIGMAS)
    change = (found.covariance.values - case["covariance"]) / np.outer(sigma, sigma)
    np.testing.assert_allclose(change, 0, rtol=0, atol=SIGMAS)
    assert found.chi2 == pytest.approx(case["chi2"], rel=1e-12, abs=0)


def test_light_curve_fit_agrees_with_40_digits():
    case = CASES["light_curve_fit"]
    system, state, priors = curve_problem(case["start"])
    data = [curve_of(night) for night in case["curves"]]
    found = fit(system, state, data, ["state", "moments[0]", "size"], priors=priors)
    # A relative brightness is a brightness over the mean projected area; the scales of the reference are not.
    area = data[0].observable.reading(system.at(state)) / brightness_of(data[0], system, state)
    unit_of = np.concatenate([np.ones(8), [area, area]])
    sigma = np.sqrt(np.diag(case["covariance"]))
    expected = case["estimate"]
    turn = quat.rotation_vector(quat.product(quat.conjugate(np.array(expected["quaternion"])), found.state.quaternion))
    numbers = [*expected["angular_momentum_body"], expected["moments_0"], expected["torque"], *expected["scales"]]
    error = np.concatenate([turn, np.array([*found.values.values()]) * unit_of[3:] - numbers])
    np.testing.assert_allclose(error / sigma, 0, rtol=0, atol=SIGMAS)
    change = (found.covariance.values * np.outer(unit_of, unit_of) - case["covariance"]) / np.outer(sigma, sigma)
    np.testing.assert_allclose(change, 0, rtol=0, atol=SIGMAS)
    assert found.chi2 == pytest.approx(case["chi2"], rel=1e-12, abs=0)


def brightness_of(readings, system, state):
    """Return the brightness of the ellipsoid in the direction of the observer, in place of a relative brightness."""
    from poinsot.shapes.brightness import brightness_of as brightness

    curve, instant = readings.observable, system.at(state)
    towards = [instant.attitude.to_body(-instant.position(orbit)) for orbit in (curve.sun, curve.observer)]
    return brightness(pt.shapes.Ellipsoid(SEMIAXES, density=1.0), curve.law, *towards)


def test_information_of_nights_agrees_with_40_digits():
    case = CASES["fisher"]
    system, state, priors = curve_problem(CASES["light_curve_fit"]["truth"])
    nights = [
        information(system, state, [curve_of(night)], ["state", "moments[0]", "size"], priors=priors)
        for night in case["nights"]
    ]
    for found, expected in zip(nights, case["information"], strict=True):
        root = np.sqrt(np.diag(expected))
        np.testing.assert_allclose((found.matrix.values - expected) / np.outer(root, root), 0, rtol=0, atol=1e-12)
    for name, expected in case["standard_deviations"].items():
        first, *others = (nights[int(i)] for i in name.split("+"))
        found = sum(others, start=first)
        np.testing.assert_allclose([*found.standard_deviations.values()], expected, rtol=1e-10, atol=0)


@pytest.mark.parametrize(
    ("free", "texts"),
    [
        (["angular_momentum_body", "moments"], ["angular momentum and moments by one common factor"]),
        (["omega_body", "moments"], ["moments by one common factor"]),
        (["angular_momentum_body", "moments[0]"], []),
        (
            ["state", "moments"],
            ["angular momentum and moments by one common factor", "theta_1", "theta_2", "theta_3"],
        ),
    ],
)
def test_null_directions_are_named(free, texts):
    case = CASES["unobservable"]
    system = pt.System(pt.Body(case["moments"]))
    state = system.state((1, 0, 0, 0), angular_momentum_body=case["angular_momentum_body"])
    plan = Readings(Gyro(noise=0.02), CASES["gyro_fit"]["times"])
    found = information(system, state, [plan], free)
    assert [each.text for each in found.null_directions] == texts
    if free == ["angular_momentum_body", "moments"]:
        np.testing.assert_allclose(found.null_directions[0].vector, case["null_direction"], rtol=0, atol=1e-11)
        assert all(np.isinf([*found.standard_deviations.values()]))


LOSSES: dict[str, Any] = {
    "linear": lambda z: z,
    "soft_l1": lambda z: 2 * (np.sqrt(1 + z) - 1),
    "huber": lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1),
    "cauchy": np.log1p,
    "arctan": np.arctan,
}
"""Losses of SciPy's documentation."""


@pytest.mark.parametrize("loss", LOSSES)
def test_losses_are_smallest_at_the_estimate(loss):
    system, state, data = gyro_problem()
    values = np.array(data.values)
    values[5, 0] += 0.3
    data = data.with_values(values)
    found = fit(system, state, [data], ["angular_momentum_body"], loss=loss)
    root, estimate = np.linalg.cholesky(found.covariance.values), found.state.angular_momentum_body

    def cost(x):
        start = system.state((1, 0, 0, 0), angular_momentum_body=estimate + root @ x)
        errors = (pt.propagate(system, start, data.times).omega_body - values) / 0.02
        return np.sum(LOSSES[loss](np.sum(errors**2, axis=1)))

    step = 1e-3
    slopes = [(cost(step * each) - cost(-step * each)) / (2 * step) for each in np.eye(3)]
    np.testing.assert_allclose(slopes, 0, rtol=0, atol=1e-4)  # the second derivative is about 2
    assert found.chi2 == pytest.approx(cost(np.zeros(3)), rel=1e-12, abs=0)
    assert found.chi2 <= cost(np.linalg.solve(root, state.angular_momentum_body - estimate))
    if loss != "linear":
        assert data.times[5] in [time for _, time, _ in found.rejected]


def test_the_linear_fit_agrees_with_scipy():
    system, state, data = gyro_problem()
    found = fit(system, state, [data], ["angular_momentum_body"])

    def residuals(g):
        start = system.state((1, 0, 0, 0), angular_momentum_body=g)
        return ((pt.propagate(system, start, data.times).omega_body - data.values) / 0.02).ravel()

    options = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "jac": "3-point"}
    expected = least_squares(residuals, state.angular_momentum_body, **options)
    errors = (found.state.angular_momentum_body - expected.x) / [*found.sigmas.values()]
    np.testing.assert_allclose(errors, 0, rtol=0, atol=1e-5)  # with derivatives by differences
    assert found.chi2 == pytest.approx(2 * expected.cost, rel=1e-12, abs=0)


def test_bounds_hold():
    system, state, data = gyro_problem()
    found = fit(system, state, [data], ["angular_momentum_body", "bias"], bounds={"bias[0]": (-1e-4, 1e-4)})
    free = fit(system, state, [data], ["angular_momentum_body", "bias"])
    assert not -1e-4 <= free.values["gyro.bias[0]"] <= 1e-4
    assert -1e-4 <= found.values["gyro.bias[0]"] <= 1e-4
    assert found.chi2 > free.chi2


def thrown(seed, moments=(1.0, 1.6, 2.1), bias=(0.02, -0.01, 0.03)):
    """Return arcs of a body with a gyro, each with an angular velocity of its own, and the true numbers."""
    system, rng = pt.System(pt.Body(moments)), np.random.default_rng(seed)
    gyro, arcs = Gyro(noise=0.01), []
    for i in range(3):
        start = system.state((1, 0, 0, 0), omega_body=rng.normal(size=3))
        motion = pt.propagate(system, start, np.linspace(0.05, 5, 60))
        data = pt.observe(motion, Gyro(noise=0.01, bias=bias)).simulated(100 * seed + i).of(gyro)
        guess = system.state((1, 0, 0, 0), omega_body=start.angular_momentum_body / moments * 1.02)
        arcs.append(Arc(data, state=guess, free=["omega_body"]))
    return arcs, gyro, np.array([*moments[1:], *bias])


def fit_of_throws(arcs):
    return fit(pt.System(pt.Body((1.0, 1.5, 2.0))), None, arcs, ["moments[1]", "moments[2]", "bias"])


def test_arcs_share_numbers():
    arcs, _, truth = thrown(1)
    found = fit_of_throws(arcs)
    names = ["body.moments[1]", "body.moments[2]", *(f"gyro.bias[{i}]" for i in range(3))]
    errors = [(found.values[name] - true) / found.sigmas[name] for name, true in zip(names, truth, strict=True)]
    assert found.converged
    assert np.max(np.abs(errors)) < 4
    assert found.labels[:3] == ("arc 0: omega_1", "arc 0: omega_2", "arc 0: omega_3")
    assert all(test.p_value > 1e-4 for test in found.tests)


@pytest.mark.slow
def test_errors_of_many_fits_are_those_of_the_covariance():
    """NEES of 100 fits in its 99.9 % band, and the variance of each component within its band."""
    errors, total = [], 0.0
    for seed in range(100):
        arcs, _, truth = thrown(seed)
        found = fit_of_throws(arcs)
        names = ["body.moments[1]", "body.moments[2]", *(f"gyro.bias[{i}]" for i in range(3))]
        P = found.covariance.sel(unknown=names, other=names).values
        error = np.array([found.values[name] for name in names]) - truth
        errors.append(error / np.sqrt(np.diag(P)))
        total += error @ np.linalg.solve(P, error)
    low, high = chi2.ppf([0.0005, 0.9995], 5 * 100)
    assert low < total < high
    low, high = chi2.ppf([0.0001, 0.9999], 100) / 100
    assert np.all((low < np.mean(np.square(errors), axis=0)) & (np.mean(np.square(errors), axis=0) < high))


def test_star_trackers_and_gyros_give_the_attitude():
    system = pt.System(pt.Body((1.2, 1.9, 2.3)))
    truth = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.2, 0.4, -0.3)), np.linspace(0.5, 10, 20))
    data = [
        pt.observe(truth, StarTracker(noise=(1e-3, 2e-3, 3e-3))).simulated(1),
        pt.observe(truth, Gyro(noise=1e-2)).simulated(2),
    ]
    guess = system.state(unit((1, 0.1, -0.2, 0.1)), omega_body=(0.25, 0.3, -0.3))
    found = fit(system, guess, data, ["state", "moments[0]", "moments[1]"])
    turn = quat.rotation_vector(quat.product(quat.conjugate(found.state.quaternion), truth.initial.quaternion))
    assert found.converged
    assert np.all(np.abs(turn) < 5 * np.array([*found.sigmas.values()][:3]))
    assert abs(found.values["body.moments[0]"] - 1.2) < 5 * found.sigmas["body.moments[0]"]


def test_priors_of_attitudes_replace_sensors():
    system, state, data = gyro_problem()
    prior = Prior("attitude", unit((1, 0.1, 0, 0)), sigma=(0.1, 0.2, 0.3))
    found = fit(system, state, [data], ["state"], priors=[prior])
    np.testing.assert_allclose(found.state.quaternion, unit((1, 0.1, 0, 0)), rtol=0, atol=1e-12)
    np.testing.assert_allclose([*found.sigmas.values()][:3], (0.1, 0.2, 0.3), rtol=1e-9, atol=0)


def test_predictions_and_draws_have_the_covariance():
    system, state, data = gyro_problem()
    found = fit(system, state, [data], ["angular_momentum_body", "moments[0]", "moments[1]"])
    times = np.array([1.0, 9.0])
    predicted = found.predict(times, data.observable)
    systems, states = found.draws(4000, seed=2)
    spread = pt.observe(pt.propagate(systems, states, times), data.observable).values
    ratios = spread.std(axis=0) / predicted.standard_deviations
    np.testing.assert_allclose(ratios, 1, rtol=0, atol=5 / np.sqrt(2 * 4000))
    assert predicted.readings.values.shape == (2, 3)


def test_considered_numbers_add_to_the_covariance():
    system, state, data = gyro_problem()
    known = fit(system, state, [data], ["angular_momentum_body"])
    found = fit(system, state, [data], ["angular_momentum_body"], consider={"moments[0]": 0.02})
    step = 1e-6
    shifted = [
        fit(pt.System(pt.Body((0.404 + sign * step, 1.194, 1.5))), state, [data], ["angular_momentum_body"])
        for sign in (1, -1)
    ]
    slope = (shifted[0].state.angular_momentum_body - shifted[1].state.angular_momentum_body) / (2 * step)
    expected = known.covariance.values + 0.02**2 * np.outer(slope, slope)
    assert np.any(np.diag(expected) > 4 * np.diag(known.covariance))
    # A fit whose residuals are not zero shifts by second derivatives, too, which the covariance leaves out.
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), np.sqrt(np.diag(expected)), rtol=0.05, atol=0)


def test_several_starts_find_distinct_solutions():
    case = CASES["light_curve_fit"]
    system, state, priors = curve_problem(case["start"])
    data = [curve_of(night) for night in case["curves"]]
    found = fit(system, state, data, ["state", "size"], priors=priors, starts=12, seed=4, iterations=25)
    alone = fit(system, state, data, ["state", "size"], priors=priors)
    assert found.chi2 <= alone.chi2 * (1 + 1e-9)
    assert [each.chi2 for each in found.solutions] == sorted(each.chi2 for each in found.solutions)
    assert sum(each.found_by for each in found.solutions) <= 12
    assert sum(each.weight for each in found.solutions) == pytest.approx(1, rel=1e-12, abs=0)


def test_an_interrupted_fit_continues(monkeypatch):
    system, state, data = gyro_problem()
    free = ["angular_momentum_body", "moments[0]", "moments[1]", "bias"]
    module = sys.modules["poinsot.estimation.batch_fit"]
    real = module.minimised

    def interrupted(problem, points, loss, tolerance, iterations, step_taken):
        def taken(number, cost):
            step_taken(number, cost)
            if number == 1:
                raise KeyboardInterrupt

        return real(problem, points, loss, tolerance, iterations, taken)

    monkeypatch.setattr(module, "minimised", interrupted)
    first = fit(system, state, [data], free)
    monkeypatch.undo()
    assert not first.converged
    assert first.iterations == 2
    found = fit(system, state, [data], free, starts=first)
    assert found.chi2 == pytest.approx(CASES["gyro_fit"]["chi2"], rel=1e-12, abs=0)


@pytest.mark.parametrize(
    ("free", "options", "message"),
    [
        (["bais"], {}, "parameters must name single numbers of the system and the observables, got 'bais'. Near: "),
        (["angular_momentum_body", "omega_body"], {}, "free must have omega_body or angular_momentum_body, got both"),
        (["attitude"], {}, "free must name unknowns that readings depend on, got theta_1, theta_2, theta_3. Leave"),
        (["bias"], {"loss": "cauchi"}, "loss must be one of linear, soft_l1, huber, cauchy, arctan, got 'cauchi'"),
        (["bias"], {"priors": [Prior("moments[0]", 1, 1)]}, r"priors must name one unknown, got 'moments\[0\]'. Near"),
        (["bias"], {"bounds": {"bias[0]": (1, 0)}}, r"bounds of bias\[0\] must ascend, got 1 and 0"),
        (["bias"], {"starts": 0}, "starts must be at least 1, got 0"),
    ],
)
def test_wrong_arguments_have_one_message(free, options, message):
    system, state, data = gyro_problem()
    with pytest.raises(ValueError, match=message):
        fit(system, state, [data], free, **options)


def test_steps_to_moments_that_no_body_has_are_shortened():
    system = pt.System(pt.Body((1.0, 1.6, 2.1)))
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.1, 3.0, 0.2)), np.linspace(0.01, 1, 100))
    data = pt.observe(motion, Gyro(noise=0.01)).simulated(seed=1)
    thin = pt.System(pt.Body((1.0, 1.6, 0.61)))
    start = thin.state((1, 0, 0, 0), omega_body=(0.1, 3.0, 0.2))
    prior = Prior("moments[1]", 1.6, sigma=0.01)
    found = fit(thin, start, [data], ["omega_body", "moments[1]", "moments[2]"], priors=[prior])
    assert found.converged
    assert abs(found.values["body.moments[2]"] - 2.1) < 5 * found.sigmas["body.moments[2]"]


WHEEL = pt.parts.ReactionWheel((0, 0.6, 0.8), 0.1)
SHAPE = pt.shapes.Ellipsoid((2.0, 1.3, 0.9), density=1.0)
PLACES = [pt.orbits.FixedPosition(1.0, position=place) for place in ((2, 1, 3), (3, -1, 1))]
MAGNITUDE = LightCurve(SHAPE, LommelSeeliger(0.2), *PLACES, kind="magnitude", light_time=False)
UNKNOWNS = {
    "state and moments": (Gyro(noise=0.1), ["state", "moments", "bias"]),
    "angular velocity": (Gyro(noise=0.1), ["omega_body", "moments", "scale"]),
    "angular velocity with a wheel": (Gyro(noise=0.1), ["omega_body", "reaction_wheel", "moments[0]"]),
    "attitudes": (StarTracker(noise=0.1), ["attitude", "omega_body", "moments[1]"]),
    "zero point of magnitudes": (MAGNITUDE, ["state", "offset", "albedo"]),
}


@pytest.mark.parametrize("name", UNKNOWNS)
def test_derivatives_are_differences_of_residuals(name):
    """Before and after the time of the state, which is between the readings."""
    observable, free = UNKNOWNS[name]
    system = pt.System(pt.Body((2.0, 2.6, 3.1)), *([WHEEL] if "wheel" in name else []))
    start = system.state(unit((1, 0.2, -0.3, 0.4)), omega_body=(0.3, 0.5, -0.2), time=1.0)
    plan = Readings(observable, np.linspace(-1, 3, 7), sigma=0.1)
    values = pt.observe(pt.propagate(system, start, plan.times), observable).values
    near = values if name == "attitudes" else values + 0.01
    unknowns = Unknowns(system, start, [Arc(plan.with_values(near), free=free)], [])
    points = unknowns.start()
    _, (found,) = unknowns.evaluated(points)
    for column, step in zip(found.T, 1e-5 * np.eye(len(unknowns.labels)), strict=True):
        ends = [unknowns.evaluated(unknowns.moved(points, sign * step[None]))[0][0] for sign in (1, -1)]
        difference = (ends[0] - ends[1]) / 2e-5
        np.testing.assert_allclose(column, difference, rtol=0, atol=1e-7 * max(1.0, np.max(np.abs(difference))))
    assert np.linalg.matrix_rank(found) >= 5


def test_zero_points_and_factors_start_at_their_best_values():
    system = pt.System(pt.Body((2.0, 2.6, 3.1)))
    start = system.state(unit((1, 0.2, -0.3, 0.4)), omega_body=(0.3, 0.5, -0.2))
    times = np.linspace(0, 3, 9)
    motion = pt.propagate(system, start, times)
    relative = LightCurve(SHAPE, LommelSeeliger(0.2), *PLACES, kind="relative", light_time=False)
    for observable, free, change, expected in (
        (MAGNITUDE, ["state", "offset"], lambda x: x + 0.7, 0.7),
        (relative, ["state"], lambda x: 3.0 * x, 3.0),
    ):
        data = Readings(observable, times, change(pt.observe(motion, observable).values), sigma=0.1)
        assert Unknowns(system, start, [Arc(data, free=free)], []).start().scales == pytest.approx(
            np.array([[expected]]), rel=1e-12, abs=0
        )


def test_residuals_are_readings_minus_predictions():
    system, state, data = gyro_problem()
    found = fit(system, state, [data], ["angular_momentum_body"])
    predicted = pt.observe(pt.propagate(found.system, found.state, data.times), data.observable).values
    (residuals,) = found.residuals
    np.testing.assert_allclose(residuals["residual"], data.values - predicted, rtol=0, atol=1e-13)
    np.testing.assert_allclose(residuals["whitened"], (data.values - predicted) / 0.02, rtol=0, atol=1e-11)


def test_solutions_that_differ_by_a_half_turn_are_two():
    """The light of an ellipsoid does not change by a half turn about a body axis."""
    case = CASES["light_curve_fit"]
    system, state, priors = curve_problem(case["start"])
    data = [curve_of(night) for night in case["curves"]]
    options = {"free": ["state", "size"], "priors": priors}
    best = fit(system, state, data, **options).state
    turned = quat.product(best.quaternion, np.array([0.0, 1, 0, 0]))
    g = best.angular_momentum_body
    near, other = np.tile(best.quaternion, (3, 1)), turned[None]
    starts = system.state(np.concatenate([near, other]), angular_momentum_body=[g, g, g, g * (1, -1, -1)])
    same = fit(system, state, data, **options, starts=system.state(near, angular_momentum_body=[g] * 3))
    assert [each.found_by for each in same.solutions] == [3]
    assert same.is_unique
    found = fit(system, state, data, **options, starts=starts)
    assert sorted(each.found_by for each in found.solutions) == [1, 3]
    assert not found.is_unique or found.solutions[1].chi2 - found.solutions[0].chi2 >= 25
    few = fit(system, state, data, **options, starts=system.state(near[:2], angular_momentum_body=[g] * 2))
    assert not few.is_unique


def test_numbers_of_starts_are_drawn_from_their_priors():
    system, state, data = gyro_problem()
    unknowns = Unknowns(system, state, [Arc(data, free=["angular_momentum_body", "bias", "moments[0]"])], [])
    posterior = Posterior(unknowns, [Prior("bias[1]", 0.3, sigma=0.1)], {"bias[1]": (0.2, None)})
    numbers = np.repeat(unknowns.start().numbers, 4000, axis=0)
    drawn = posterior.drawn_numbers(numbers, np.random.default_rng(1))
    changed = [
        label for label, column in zip(unknowns.labels[3:], (drawn != numbers).any(axis=0), strict=True) if column
    ]
    assert changed == ["gyro.bias[1]"]
    column = drawn[:, unknowns.labels[3:].index("gyro.bias[1]")]
    assert np.median(column) == pytest.approx(0.3, rel=0, abs=5 * 0.1 * 1.2533 / 4000**0.5)
    assert column.min() == 0.2


def test_wrong_data_have_one_message():
    system, state, data = gyro_problem()
    cases = [
        ([], "data must have readings, got none"),
        ([data.isel(time=[0])], "data must have at least as many numbers as there are unknowns, 6, got 3"),
        ([Readings(data.observable, data.times)], "data must have values, but Gyro has none"),
        ([Readings(Gyro(), data.times, data.values)], "data must have sigma, but Gyro has none"),
    ]
    for given, message in cases:
        with pytest.raises(ValueError, match=message):
            fit(system, state, given, ["angular_momentum_body", "bias"])
    with pytest.raises(ValueError, match="readings must be given for an arc, got none"):
        Arc()
    with pytest.raises(ValueError, match="state must be given, got none"):
        fit(system, None, [data], ["angular_momentum_body"])
    with pytest.raises(ValueError, match="sigma must be positive, got 0"):
        Prior("moments[0]", 1.0, 0.0)
