"""Parts of edges inside polygons and outside intervals, against points on the edges."""

import numpy as np

from poinsot.shapes.clipping import inside, lines_of, positive, turn, uncovered

TRIANGLE = np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])[..., None]


def clipped(start, end, on_lines=False):
    """Return the parameters between which an edge is inside the triangle."""
    start, end = np.array(start, dtype=float)[:, None], np.array(end, dtype=float)[:, None]
    return inside(lines_of(TRIANGLE), start, end - start, 1e-12, on_lines)


def test_lines_are_distances_from_the_edges_of_a_triangle():
    lines = lines_of(TRIANGLE)[..., 0]
    np.testing.assert_allclose(lines @ (0.5, 0.25, 1), [0.25, 1 / np.sqrt(5), 0.5], rtol=1e-15, atol=0)
    point = lines_of(np.zeros((3, 2, 1)))[..., 0]
    assert np.all(point @ (0.3, 0.2, 1) < 0)  # nothing is inside a point


def test_an_edge_is_clipped_to_a_triangle():
    begin, end = clipped((-1, 0.25), (3, 0.25))
    np.testing.assert_allclose((begin[0], end[0]), (0.25, 0.625), rtol=1e-15, atol=0)
    begin, end = clipped((0.1, 0.1), (0.2, 0.1))
    assert (begin[0], end[0]) == (0, 1)
    begin, end = clipped((-1, 0.5), (0.5, 2))
    assert begin[0] > end[0]


def test_an_edge_on_a_line_is_inside_if_asked():
    for on_lines in (True, False):
        begin, end = clipped((0.5, 1e-14), (1, -1e-14), on_lines)
        assert (end[0] > begin[0]) == on_lines


def test_a_linear_function_is_positive_between_its_ends_or_nowhere():
    here, there = np.array([1.0, -1, 3, -2, 0]), np.array([2.0, 3, -1, -1, 0])
    begin, end = positive(here, there)
    assert list(begin) == [0, 0.25, 0, 1, 0]
    assert list(end) == [1, 1, 0.75, 0, 1]


def test_what_intervals_leave_uncovered():
    rng = np.random.default_rng(3)
    edges = rng.integers(0, 9, 30)
    begin, end = np.sort(rng.integers(0, 65, (2, 30)), axis=0) / 64
    middles = (np.arange(64) + 0.5) / 64
    free = np.array([[not np.any((edges == k) & (begin < x) & (x < end)) for x in middles] for k in range(10)])
    lengths, moments = uncovered(10, edges, begin, end)
    np.testing.assert_allclose(lengths, free.mean(axis=1), rtol=0, atol=1e-15)
    np.testing.assert_allclose(moments, free @ middles / 64, rtol=0, atol=1e-15)
    assert lengths[9] == 1  # without any interval


def test_a_turn_is_the_area_between_two_vectors():
    assert turn(np.array([2.0, 0]), np.array([1.0, 3.0])) == 6
