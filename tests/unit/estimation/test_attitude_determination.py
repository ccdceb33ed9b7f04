"""Tests of attitudes from directions at one instant."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.estimation import triad, wahba

FILE = Path(__file__).parents[2] / "oracles" / "attitude_determination.json"
CASES = {case["name"]: case for case in json.loads(FILE.read_text())["cases"]}
SOLVED = [name for name, case in CASES.items() if "refused" not in case]
TWO = [name for name in SOLVED if "triad" in CASES[name]]
ROUNDING = 2.2e-16


def arguments(name):
    return CASES[name]["body"], CASES[name]["space"], CASES[name]["sigma"]


def angle_between(q, other):
    return 2 * np.linalg.norm(q - np.array(other))


def spread(name):
    """Return the largest over the smallest standard deviation of an attitude, which multiplies roundings."""
    values = np.linalg.eigvalsh(CASES[name]["covariance"])
    return np.sqrt(values[-1] / values[0])


@pytest.mark.parametrize("name", SOLVED)
def test_wahba_agrees_with_40_digits(name):
    found, case = wahba(*arguments(name)), CASES[name]
    roundings = 20 * ROUNDING * spread(name)
    assert angle_between(found.quaternion, case["quaternion"]) < roundings
    np.testing.assert_allclose(
        found.covariance, case["covariance"], rtol=0, atol=roundings * np.max(case["covariance"])
    )
    residuals = np.sqrt(2 * case["loss"])  # in standard deviations; a rounding is 1/sigma of one
    assert abs(np.sqrt(2 * found.loss) - residuals) < 20 * ROUNDING / np.min(case["sigma"])


@pytest.mark.parametrize("name", TWO)
def test_triad_agrees_with_40_digits(name):
    found, case = triad(*arguments(name)), CASES[name]["triad"]
    turn = np.linalg.norm(np.cross(*CASES[name]["space"]))
    roundings = 20 * ROUNDING / turn
    assert angle_between(found.quaternion, case["quaternion"]) < roundings
    np.testing.assert_allclose(
        found.covariance, case["covariance"], rtol=0, atol=roundings * np.max(case["covariance"])
    )


def test_instants_are_solved_together():
    cases = [CASES[name] for name in TWO]
    bodies, spaces, sigmas = (np.array([case[key] for case in cases]) for key in ("body", "space", "sigma"))
    for solve in (wahba, triad):
        together = solve(bodies, spaces, sigmas)
        for i, case in enumerate(cases):
            alone = solve(case["body"], case["space"], case["sigma"])
            np.testing.assert_allclose(together.quaternion[i], alone.quaternion, rtol=0, atol=1e-12)
            np.testing.assert_allclose(together.covariance[i], alone.covariance, rtol=1e-9, atol=0)


@given(seed=st.integers(0, 2**32 - 1))
def test_wahba_and_triad_recover_the_attitude_of_exact_directions(seed):
    rng = np.random.default_rng(seed)
    attitude, space = Rotation.random(random_state=rng), rng.normal(size=(2, 3))
    turn = np.linalg.norm(np.cross(*(space / np.linalg.norm(space, axis=1, keepdims=True))))
    for found in (wahba(attitude.inv().apply(space), space, 1e-3), triad(attitude.inv().apply(space), space)):
        assert (found.attitude.inv() * attitude).magnitude() < 40 * ROUNDING / turn


def test_covariance_is_the_scatter_of_estimates():
    rng, sigma = np.random.default_rng(5), np.array([1e-3, 2e-3, 4e-3])
    truth, space = Rotation.from_rotvec((0.3, -1.2, 0.7)), np.eye(3)
    body = truth.inv().apply(space)
    noisy = np.cross(rng.normal(size=(20_000, 3, 3)) * sigma[:, None], body) + body
    found = wahba(noisy, space, sigma)
    errors = (truth.inv() * found.attitude).as_rotvec()
    ratios = np.cov(errors.T) / wahba(body, space, sigma).covariance
    assert np.allclose(np.diag(ratios), 1, rtol=0, atol=5 * np.sqrt(2 / 20_000))  # five standard deviations
    assert found.loss.mean() == pytest.approx(found.expected_loss, rel=0, abs=5 * np.sqrt(1.5 / 20_000))


def test_collinear_directions_name_the_axis():
    with pytest.raises(ValueError, match=r"rotation about the body axis \(0\.36, 0\.48, 0\.8\) is unknown\. Add a"):
        wahba(*arguments("collinear_refused"))
    with pytest.raises(ValueError, match=r"body must have two directions that are not collinear"):
        triad(*arguments("collinear_refused"))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([(1, 0, 0)], [(1, 0, 0)], 1.0), r"body must have shape \(\.\.\., n, 3\) with at least 2 directions, got"),
        ((np.eye(3), np.eye(3)[:2], 1.0), r"body and space must have the same number of directions, got 3 and 2\."),
        ((np.eye(3), np.eye(3), 0.0), r"sigma must be positive, got 0\.0\."),
        ((np.eye(3), np.eye(3), [1.0, 2.0]), r"sigma must be one number or one for each of the 3 directions, got"),
        ((np.zeros((2, 3)), np.eye(3)[:2], 1.0), r"body must not be zero, got all components 0\."),
    ],
)
def test_wrong_directions_have_one_message(given, message):
    with pytest.raises(ValueError, match=message):
        wahba(*given)


def test_triad_takes_two_directions():
    with pytest.raises(ValueError, match=r"body must have two directions, got 3\. Take wahba for more\."):
        triad(np.eye(3), np.eye(3))


def test_the_attitude_is_one_of_a_state():
    found = wahba(np.eye(3), np.eye(3)[[1, 2, 0]], 1e-3)
    state = pt.Body((1, 2, 2.5)).state(found.attitude, omega_body=(0, 0, 1))
    np.testing.assert_allclose(state.quaternion, found.quaternion, rtol=0, atol=4 * ROUNDING)
    assert "standard deviations" in repr(found)
