"""Identification of lines, against published rotations, exhaustive searches and least squares of SciPy."""

import itertools
import re
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

import poinsot as pt

APOPHIS, TOUTATIS = pt.Body((0.61, 0.965, 1.0)), pt.Body((3.0836, 3.235, 1.0))
SHORT = np.array([[2, -2], [1, 0], [4, -4], [2, 0], [1, -2], [0, 2], [2, -4], [1, 2]])  # of a simulated ellipsoid
LONG = np.array([[2, 0], [2, 2], [0, 2], [4, 2], [2, -1]])


def spectrum(nu, errors, mean=0.0):
    nu, errors = np.asarray(nu, dtype=float), np.broadcast_to(np.asarray(errors, dtype=float), np.shape(nu))
    sizes = 1.0 / np.arange(1, nu.size + 1)
    if mean:
        nu, errors, sizes = np.append(0.0, nu), np.append(0.0, errors), np.append(mean, sizes)
    return pt.analysis.LineSpectrum(nu, sizes, errors, np.ones(nu.size, bool), 0.0)


def test_lines_of_apophis_give_the_published_periods_first():
    """P_phi = 27.38 h and P_psi = 263 h in the short-axis mode, P_1 = 30.56 h (Pravec et al. 2014, Icarus 233, 48)."""
    base = 2 * np.pi / np.array([27.38, 263.0])
    found = pt.analysis.identify_lines(spectrum(SHORT @ base, 2e-5, mean=19.0), body=APOPHIS)
    assert found[0].mode == "short-axis"
    np.testing.assert_allclose(found[0].periods, (27.38, 263.0), rtol=1e-12, atol=0)
    np.testing.assert_array_equal(found[0].multiples, SHORT)
    (other,) = [one for one in found if one.mode == "long-axis" and abs(one.periods[1] - 263) < 1]
    np.testing.assert_allclose(other.periods, (1 / (1 / 27.38 - 1 / 263), 263.0), rtol=1e-12, atol=0)
    assert abs(other.periods[0] - 30.56) < 0.005  # P_1, of the long axis with the same lines
    assert other.explained == 8
    assert [one.evidence for one in found] == sorted((one.evidence for one in found), reverse=True)


def test_lines_of_toutatis_have_no_short_axis_mode():
    """P_phi = 7.35 d and P_psi = 5.41 d (Hudson and Ostro 1995, Science 270, 84): P_psi < 2 P_phi."""
    base = 2 * np.pi / np.array([7.35, 5.41])
    found = pt.analysis.identify_lines(spectrum(LONG @ base, 1e-5), body=TOUTATIS)
    assert {one.mode for one in found} == {"long-axis"}
    np.testing.assert_allclose(found[0].periods, (7.35, 5.41), rtol=1e-12, atol=0)
    np.testing.assert_array_equal(found[0].multiples, LONG)


@pytest.mark.parametrize(("body", "mode", "ratio"), [(None, "short-axis", 2.0), (APOPHIS, "short-axis", 7.56693)])
def test_alternatives_have_periods_that_the_body_can_have(body, mode, ratio):
    base = 2 * np.pi / np.array([27.38, 263.0])
    found = pt.analysis.identify_lines(spectrum(SHORT @ base, 2e-5), body=body, count=1000)
    ratios = [one.periods[1] / one.periods[0] for one in found if one.mode == mode]
    assert min(ratios) > ratio
    assert len(found) > 20
    for one in found[:10] if body else ():
        if one.periods[1] / one.periods[0] < 60:  # farther from the separatrix
            pt.analysis.FreeRotation.from_periods(
                body, one.mode, precession_period=one.periods[0], rotation_period=one.periods[1]
            )


def test_multiples_of_known_frequencies_are_those_of_an_exhaustive_search():
    base, rng = np.array([1.0, 0.3137, 0.0717]), np.random.default_rng(1)
    errors = rng.uniform(1e-3, 4e-3, 40)
    nu = rng.uniform(0.1, 3.0, 40)
    found = pt.analysis.identify_lines(spectrum(nu, errors), base, order=5)
    assert len(found) == 1
    for i in range(40):
        near = [
            n
            for n in itertools.product(range(-5, 6), repeat=3)
            if 0 < sum(map(abs, n)) <= 5 and abs(np.dot(n, base) - nu[i]) <= 4 * errors[i]
        ]
        assert sorted(near) == sorted(map(tuple, found[0].alternatives(i).tolist()))
        got = tuple(found[0].multiples[i].tolist())
        assert got in near if near else got == (0, 0, 0)
        assert np.isnan(found[0].deviations[i]) == (not near)
    assert 0 < found[0].explained < 40


def test_frequencies_and_errors_are_the_least_squares():
    base, rng = 2 * np.pi / np.array([27.38, 263.0]), np.random.default_rng(2)
    errors = rng.uniform(1e-5, 4e-5, 8)
    nu = SHORT @ base + errors * rng.normal(size=8)
    found = pt.analysis.identify_lines(spectrum(nu, errors), body=APOPHIS)[0]
    solved = least_squares(lambda f: (SHORT @ f - nu) / errors, base, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    jacobian = np.asarray(solved.jac)
    np.testing.assert_allclose(found.base, solved.x, rtol=1e-9, atol=0)
    np.testing.assert_allclose(
        found.base_errors, np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))), rtol=1e-6, atol=0
    )
    assert abs(found.chi2 - 2 * solved.cost) < 1e-6
    np.testing.assert_allclose(found.period_errors / found.periods, found.base_errors / found.base, rtol=1e-14, atol=0)


def test_a_line_of_another_source_has_no_combination():
    base = 2 * np.pi / np.array([27.38, 263.0])
    nu = np.append(SHORT @ base, 0.4712345)
    found = pt.analysis.identify_lines(spectrum(nu, 2e-6), body=APOPHIS)[0]
    np.testing.assert_array_equal(found.multiples[:8], SHORT)
    np.testing.assert_array_equal(found.multiples[8], (0, 0))
    assert found.explained == 8
    assert "0.471235: none" in repr(found)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "one line": (
        {"spectrum": spectrum([1.0], 0.1, mean=2.0)},
        "spectrum must have at least 2 lines beyond the mean, got 1.",
    ),
    "several signals": (
        {"spectrum": pt.analysis.frequencies(np.cos(np.outer((1, 2), np.arange(99))), 1.0, 1)},
        "spectrum must have the lines of one signal, got shape (2, 1). Pass each signal alone.",
    ),
    "no errors": (
        {"spectrum": spectrum([1.0, 2.0], 0.0)},
        "spectrum must have positive errors of its lines, got 0.0.",
    ),
    "base": ({"base": [1.0, 0.0]}, "base must be positive, got 0.0."),
    "no base": ({"base": []}, "base must have at least one frequency, got none. Leave it out for a tumbling body."),
    "order": ({"order": 0}, "order must be positive, got 0."),
    "large order": (
        {"order": 40, "base": [1.0, 2.0, 3.0]},
        "order must have at most 100000 combinations of 3 base frequencies, got 40.",
    ),
    "members": (
        {"body": pt.Body(np.ones((2, 3)))},
        "moments of the body must have shape (3,), got shape (2, 3).",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments(name):
    changed, sentence = WRONG[name]
    arguments: dict[str, Any] = {"spectrum": spectrum([1.0, 2.7], 0.1)}
    with pytest.raises(ValueError, match="^" + re.escape(sentence) + "$"):
        pt.analysis.identify_lines(**(arguments | changed))


def test_a_line_that_does_not_exist():
    found = pt.analysis.identify_lines(spectrum([1.0, 2.7], 0.1), base=(1.0, 0.3))[0]
    with pytest.raises(ValueError, match=r"^line must be below the number of lines, 2, got 2\.$"):
        found.alternatives(2)
