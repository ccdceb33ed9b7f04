"""Bifurcations of forced motions: judged by Hill's equations of a libration in the plane, and by closed forms of tops.

The equations are written here from Euler's, over the true anomaly, and integrated by DOP853.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import poinsot as pt

BETA, GAMMA = 0.47, 0.1
A, B, C = pt.Body.from_ratios(beta=BETA, gamma=GAMMA).moments


# ---------------------------------------------------------------------- Hill's equations


def rates(f, y, e):
    """Of the libration t(f) (Beletsky 1959) with six neighbours (x, w), body axes, in units of the mean motion.

    x' = w - W x x, I w' = d(torque) - d(w x I w), W = (0, 0, rate), torque = 3 u x I u/r^3, u the radius in the body,
    du = u x x. Rows of y: t, t', then x1, x2, x3, w1, w2, w3 of each neighbour.
    """
    r = (1 - e * e) / (1 + e * np.cos(f))
    pace = r * r / np.sqrt(1 - e * e)  # dt/df
    rate = (1 + y[1]) / pace
    k, c, s = 3 / r**3, np.cos(y[0]), -np.sin(y[0])
    x1, x2, x3, w1, w2, w3 = y[2:].reshape(6, 6)
    out_of_plane = c * x2 - s * x1
    turned = [w1 + rate * x2, w2 - rate * x1, w3]
    driven = [
        ((B - C) * rate * w2 + k * (C - B) * s * out_of_plane) / A,
        ((C - A) * rate * w1 + k * (A - C) * c * out_of_plane) / B,
        k * (B - A) * (s * s - c * c) * x3 / C,
    ]
    bent = (2 * e * np.sin(f) * (1 + y[1]) - 3 * (B - A) / C * np.sin(y[0]) * np.cos(y[0])) / (1 + e * np.cos(f))
    return np.concatenate([[y[1], bent], pace * np.ravel(turned + driven)])


def passed(e, slope, end):
    y = np.concatenate([[0.0, slope], np.ravel(np.eye(6))])
    return solve_ivp(rates, (0, end), y, method="DOP853", rtol=1e-12, atol=1e-13, args=(e,)).y[:, -1]


def sums(e, slope):
    """m + 1/m of the libration in the plane near a slope, and of the two out of it.

    It is odd in f: t(pi) = 0, by Newton's method, where a neighbour of the slope turns by x3 for its rate.
    """
    pace = (1 - e) ** 2 / np.sqrt(1 - e * e)
    for _ in range(3):
        half = passed(e, slope, np.pi)
        slope -= half[0] / (half[2:].reshape(6, 6)[2, 5] / pace)
    matrix = passed(e, slope, 2 * np.pi)[2:].reshape(6, 6)
    plane, across = (np.poly(matrix[np.ix_(rows, rows)]) for rows in ([2, 5], [0, 1, 3, 4]))
    return np.concatenate([-plane[1:2], np.roots([1, across[1], across[2] - 2])])


DISTANCES = {
    "branching": lambda each: np.prod(each - 2).real,
    "doubling": lambda each: np.prod(each + 2).real,
    "collision": lambda each: ((each[1] - each[2]) ** 2).real,  # the plane has nothing to meet
}


def system(e):
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=e)
    return pt.System(pt.Body((A, B, C)), pt.GravityGradient(orbit))


def slope_of(motion, e):
    """dt/df at the periapsis."""
    return motion.state.angular_momentum_body[2] / C * (1 - e) ** 2 / np.sqrt(1 - e * e) - 1


@pytest.fixture(scope="module")
def hyperion():
    start = system(0.02).body.state((1, 0, 0, 0), omega_body=(0, 0, 1.0))
    motion = pt.analysis.periodic_motion(system(0.02), start, 2 * np.pi)
    return pt.analysis.continue_motion(motion, "eccentricity", 0.75)


@pytest.mark.slow
def test_bifurcations_of_librations_are_those_of_hills_equations(hyperion):
    """The chord between two values d = 2e-7 off the root misses it by d^2 over the 2e-3 to the next: 2e-11.

    The sums are known to 2e-13, and pass with slopes above 1e-3 here: 2e-10.
    """
    kinds = [each.kind for each in hyperion.bifurcations]
    assert kinds == [*["doubling"] * 3, "collision", "doubling", "collision", "branching", "branching"]
    for found in hyperion.bifurcations:
        e, distance = found.value + 2e-7 * np.array([-1, 1]), DISTANCES[found.kind]
        ends = [distance(sums(x, slope_of(found.motion, found.value))) for x in e]
        assert ends[0] * ends[1] < 0
        assert (e[0] * ends[1] - e[1] * ends[0]) / (ends[1] - ends[0]) == pytest.approx(found.value, abs=1e-9)


@pytest.mark.slow
def test_counts_of_unstable_multipliers_are_those_of_hills_equations(hyperion):
    changes = np.cumsum([0] + [each.change for each in hyperion.bifurcations])
    at = [each.value for each in hyperion.bifurcations]
    for i in (0, 4, 8, 20, 28, 35, 41, len(hyperion.values) - 1):
        e, motion = hyperion.values[i], hyperion.motions[i]
        multipliers = [np.roots([1, -each, 1]) for each in sums(e, slope_of(motion, e))]
        count = np.sum(np.abs(multipliers) > 1 + 1e-5)
        assert count == changes[np.searchsorted(at, e)] == motion.growth_rates.size


# ---------------------------------------------------------------------- branches that cross


def side(found):
    """To which side the branch goes, tried on both; the other one is refused."""
    branches = []
    for to in (found.value - 0.004, found.value + 0.004):
        try:
            branches.append((to, pt.analysis.continue_motion(found, "eccentricity", to)))
        except ValueError as error:
            assert "to which the branch goes" in str(error)  # noqa: PT017
    (only,) = branches
    return only


@pytest.mark.slow
@pytest.mark.parametrize("i", [0, 1, 2, 6, 7])
def test_branches_that_cross_or_double(hyperion, i):
    """A multiplier is 1 where it begins; stability is exchanged with that of the other side."""
    found = hyperion.bifurcations[i]
    to, branch = side(found)
    turns = 2 if found.kind == "doubling" else 1
    assert branch.values[0] == pytest.approx(found.value, abs=1e-15)
    np.testing.assert_allclose(branch.periods, turns * 2 * np.pi, rtol=1e-15)
    # A double root, the root of roundings: three times the worst of 21 shaken starts.
    assert np.sort(np.abs(np.linalg.eigvals(branch.motions[0].matrix) - 1))[1] < 1.2e-6
    np.testing.assert_allclose(branch.motions[0].state.quaternion, found.motion.state.quaternion, rtol=0, atol=1e-12)
    middle = branch.motions[len(branch.motions) // 2]
    parent = hyperion.motions[found.after].growth_rates.size
    lower, upper = parent, parent + found.change
    assert branch.motions[1].growth_rates.size == (lower if to > found.value else upper)
    begin = middle.state
    once, twice = (
        np.append(
            (begin.attitude.inv() * over.attitude[0]).as_rotvec(),
            over.angular_momentum_body - begin.angular_momentum_body,
        )
        for over in (pt.propagate(middle.system, begin, [n / 2 * middle.period]) for n in (1, 2))
    )
    assert np.max(np.abs(twice)) < 1e-12
    if turns == 2:
        assert np.max(np.abs(once)) > 1e-3
    else:  # the libration passes the periapsis with the angle 0, in the plane
        assert np.max(np.abs([*begin.attitude.as_rotvec(), *begin.angular_momentum_body[:2]])) > 1e-3


# ---------------------------------------------------------------------- tops


def upright(c):
    return pt.System(pt.Body((1.0, 1.2, c)), pt.UniformGravity(weight=0.5, center_of_mass=(0, 0, 1)))


def test_top_of_three_moments_turns_over_where_its_formula_says():
    """Upright at the rate w: (C - A) w^2 = (weight) (height) and the same of B (Euler's equations, linear)."""
    start = upright(0.4).body.state((1, 0, 0, 0), omega_body=(0, 0, 4.0))
    branch = pt.analysis.continue_motion(
        pt.analysis.periodic_motion(upright(0.4), start, np.pi / 2), upright, 1.9, start=0.4
    )
    assert branch.parameter == "upright"
    assert [each.kind for each in branch.bifurcations] == ["branching"] * 2
    assert [each.change for each in branch.bifurcations] == [1, -1]
    values = [each.value for each in branch.bifurcations]
    assert values == pytest.approx([1.0 + 0.5 / 16, 1.2 + 0.5 / 16], abs=1e-14)


def test_sleeping_top_wakes_where_lagrange_says():
    """(C w)^2 = 4 A (weight) (height)."""
    top = pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(weight=0.5, center_of_mass=(0, 0, 1)))
    start = top.body.state((1, 0, 0, 0), omega_body=(0, 0, 4.0))
    branch = pt.analysis.continue_motion(pt.analysis.periodic_motion(top, start, np.pi / 2), "weight", 1.5)
    (found,) = branch.bifurcations
    assert (found.kind, found.change) == ("collision", 2)
    assert found.value == pytest.approx(1.0, abs=2e-14)


def test_steady_precession_goes_off_where_the_sleeping_top_wakes():
    """A W^2 cos + (weight) (height) = C n W for the rate n about the axis; the spin n - W cos is conserved."""
    weight, c, rate = 1.28, 1.6, 1.6
    top = pt.System(pt.Body((1.0, 1.0, c)), pt.UniformGravity(weight=weight, center_of_mass=(0, 0, 1)))
    start, frame = top.body.state((1, 0, 0, 0), omega_body=(0, 0, 2.0)), pt.RotatingFrame((1, 0, 0, 0), (0, 0, rate))
    branch = pt.analysis.continue_motion(pt.analysis.periodic_motion(top, start, np.pi / 0.2, frame), "weight", 3.584)
    (found,) = branch.bifurcations
    assert (found.kind, found.change) == ("branching", 2)
    assert found.value == pytest.approx(2.56, abs=3e-10)  # a double zero: halved to 1e-10 of 2.304
    crossing = pt.analysis.continue_motion(found, "weight", 2.432)
    assert crossing.ending == "forces[0].weight = 2.432"
    tilted = crossing.state  # bounds: three times the worst of shaken runs, but for the bifurcation
    cosine, spin = tilted.attitude.as_matrix()[:, 2, 2], top.omega_body(tilted)[:, 2]
    assert np.max(np.abs(c * spin * rate - rate**2 * cosine - crossing.values)[1:]) < 4e-14
    assert np.max(np.abs(spin - rate * cosine - 0.4)) < 3e-14
