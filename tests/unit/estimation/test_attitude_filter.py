"""Tests of the Kalman filter and the smoother."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.estimation import GyroProcess, kalman_filter
from poinsot.estimation.process import Estimate
from poinsot.observables import Gyro, Readings, StarTracker

CASES = json.loads((Path(__file__).parents[2] / "oracles" / "attitude_filters.json").read_text())
TOLERANCE = 1e-11  # standard deviations; three times the roundings of updates whose covariances span 1e-2 to 1e-8


def unit(quaternions):
    array = np.array(quaternions)
    return array / np.linalg.norm(array, axis=-1, keepdims=True)


def tracked(case):
    return Readings(StarTracker(), case["times"], unit(case["quaternions"]), sigma=case["sigma"])


def gyro_run(**options):
    data = CASES["gyro"]["data"]
    gyro, start = data["gyro"], data["start"]
    samples = Readings(Gyro(), np.arange(len(gyro["omega"])) * gyro["interval"], gyro["omega"])
    process = GyroProcess(samples, gyro["white_noise"], gyro["bias_walk"])
    P = np.diag(np.square(start["sigma"]))
    return kalman_filter(
        process, [tracked(data["star_tracker"])], attitude=unit(start["quaternion"]), covariance=P, **options
    )


def system_run():
    case = CASES["dynamic"]
    system = pt.System(pt.Body(case["moments"]), pt.forces.LinearDamping(case["damping"]))
    start = case["start"]
    state = system.state(unit(start["quaternion"]), angular_momentum_body=start["angular_momentum_body"])
    P, density = np.diag(np.square(start["sigma"])), case["torque_noise_density"]
    return kalman_filter(system, [tracked(case["star_tracker"])], state, P, torque_noise=density)


def check(found, expected, own=None):
    """Compare estimates at the times of updates in standard deviations, and covariances relative to these."""
    for row in expected:
        i = np.flatnonzero(np.isclose(found.times, row["time"], rtol=0, atol=1e-9))[-1]
        P = np.array(row["covariance"])
        sigma = np.sqrt(np.diag(P))
        turn = quat.rotation_vector(quat.product(quat.conjugate(np.array(row["quaternion"])), found.quaternion[i]))
        error = np.concatenate([turn, found.own[own][i] - row[own]])
        np.testing.assert_allclose(error / sigma, 0, rtol=0, atol=TOLERANCE)
        np.testing.assert_allclose(
            found.covariance[i] / np.outer(sigma, sigma), P / np.outer(sigma, sigma), rtol=0, atol=TOLERANCE
        )


def test_gyro_filter_agrees_with_40_digits():
    found = gyro_run()
    check(found, CASES["gyro"]["updates"], "bias")
    np.testing.assert_allclose(
        found.nis, [row["nis"] for row in CASES["gyro"]["updates"]], rtol=TOLERANCE, atol=TOLERANCE
    )


def test_smoother_agrees_with_40_digits():
    check(gyro_run().smoothed(), CASES["gyro"]["smoothed"], "bias")


def test_filter_of_a_system_agrees_with_an_independent_integration():
    found = system_run()
    check(found, CASES["dynamic"]["updates"], "angular_momentum_body")
    nis = [row["nis"] for row in CASES["dynamic"]["updates"]]
    np.testing.assert_allclose(found.nis, nis, rtol=TOLERANCE, atol=TOLERANCE)


def test_the_gate_refuses_large_innovations():
    every = gyro_run()
    found = gyro_run(gate=np.sort(every.nis)[-2] + 1e-6)
    assert [update.time for update in found.refused][:1] == [every.updates[np.argmax(every.nis)].time]
    assert not every.refused


def simulated(seed):
    """Return a filter along simulated readings of a free body, with the true state at each time."""
    system = pt.System(pt.Body((1.2, 1.9, 2.3)))
    truth = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.2, 0.4, -0.3)), np.linspace(0.5, 10, 20))
    stars = pt.observe(truth, StarTracker(noise=(1e-3, 2e-3, 3e-3))).simulated(seed)
    rates = pt.observe(truth, Gyro(noise=1e-2)).simulated(seed + 1000)
    rng, P = np.random.default_rng(seed), np.diag(np.square([0.01] * 3 + [0.02] * 3))
    error = rng.multivariate_normal(np.zeros(6), P)
    initial = truth.initial
    wrong = quat.product(initial.quaternion, np.concatenate([[1.0], -0.5 * error[:3]]))
    state = system.state(unit(wrong), angular_momentum_body=initial.angular_momentum_body - error[3:])
    return truth, kalman_filter(system, [stars, rates], state, P)


def test_innovations_and_errors_are_consistent():
    runs = [simulated(seed) for seed in range(12)]
    nis = np.concatenate([found.nis for _, found in runs])
    low, high = chi2.ppf([0.0005, 0.9995], 3 * nis.size)
    assert low < nis.sum() < high
    nees = 0.0
    for truth, found in runs:
        turn = quat.rotation_vector(quat.product(quat.conjugate(found.quaternion[-1]), truth.quaternion[-1]))
        error = np.concatenate([turn, truth.angular_momentum_body[-1] - found.own["angular_momentum_body"][-1]])
        nees += float(error @ np.linalg.solve(found.covariance[-1], error))
    low, high = chi2.ppf([0.0005, 0.9995], 6 * len(runs))
    assert low < nees < high


def test_wheels_are_variables_of_the_filter():
    system = pt.System(pt.Body((6.0, 8.0, 10.0)), pt.parts.ReactionWheel((0, 0, 1), 0.1))
    truth = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.1, 0.02, 0.05)), np.linspace(1, 20, 20))
    stars = pt.observe(truth, StarTracker(noise=1e-4)).simulated(3)
    found = kalman_filter(system, [stars], truth.initial, np.diag(np.square([1e-3] * 3 + [1e-3] * 4)))
    assert found.own["reaction_wheel"].shape == (found.times.size, 1)
    turn = quat.rotation_vector(quat.product(quat.conjugate(found.quaternion[-1]), truth.quaternion[-1]))
    assert np.all(np.abs(turn) < 5 * found.standard_deviations[-1, :3])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"attitude": None}, r"attitude must be given where the process is a gyro, got none\. Give the initial"),
        ({"torque_noise": 1.0}, r"torque_noise must come with a system as the process, got a gyro\. Leave it out\."),
        ({"time": 3.0}, r"data must begin at or after the initial time 3, got 0\. Give an earlier start\."),
        ({"time": -3.0}, r"readings must begin at or before the first time of the filter, -3, got 0\. Start the"),
        ({"covariance": np.eye(3)}, r"covariance must have shape \(6, 6\), got shape \(3, 3\)\."),
    ],
)
def test_wrong_arguments_have_one_message(change, message):
    data = CASES["gyro"]["data"]
    samples = Readings(Gyro(), np.arange(len(data["gyro"]["omega"])) * 0.25, data["gyro"]["omega"])
    given = {"attitude": (1, 0, 0, 0), "covariance": np.eye(6)} | change
    with pytest.raises(ValueError, match=message):
        kalman_filter(GyroProcess(samples, 1e-3, 1e-4), [tracked(data["star_tracker"])], **given)


def test_readings_without_errors_are_refused():
    data = CASES["gyro"]["data"]["star_tracker"]
    system = pt.System(pt.Body((1, 2, 2.5)))
    state = system.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    for readings, missing in (
        (Readings(StarTracker(), data["times"], unit(data["quaternions"])), "sigma"),
        (Readings(StarTracker(), data["times"], sigma=1e-3), "values"),
    ):
        with pytest.raises(ValueError, match=f"data must have {missing}, but StarTracker has none"):
            kalman_filter(system, [readings], state, np.eye(6))
    with pytest.raises(ValueError, match="state must be given where the process is a system, got none"):
        kalman_filter(system, [tracked(data)], None, np.eye(6))


def test_readings_of_the_angular_velocity_change_with_the_bias():
    """The angular velocity of a gyro process is the sample minus the bias."""
    samples = Readings(Gyro(), [0.0, 1.0], [(0.3, -0.2, 0.5)] * 2)
    process, seen = GyroProcess(samples, 1e-3, 1e-4), Readings(Gyro(scale=(0.1, 0, 0)), [0.5], sigma=1.0)
    estimate = Estimate(0.5, unit((1, 0.2, 0.3, 0.4)), np.array([0.01, 0.02, 0.03]))
    values, columns = process.predicted(estimate, seen, 0)
    np.testing.assert_allclose(values, (1.1 * 0.29, -0.22, 0.47), rtol=1e-14, atol=0)
    for column, step in zip(columns.T, 1e-6 * np.eye(6), strict=True):
        ends = [process.predicted(estimate.corrected(sign * step), seen, 0)[0] for sign in (1, -1)]
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / 2e-6, rtol=0, atol=1e-9)
