"""Tests of support functions of many points: the same as those of few, with the farthest point as gradient."""

from typing import Any

import numpy as np
import pytest

from poinsot.functions import Vector
from poinsot.shapes.support import MAX_WRITTEN, extreme_points, support_of_points
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps


@pytest.mark.parametrize("count", [MAX_WRITTEN, MAX_WRITTEN + 1, 5000])
def test_value_and_gradient_are_those_of_the_farthest_point(count, rng):
    points, w = rng.normal(size=(count, 3)), rng.normal(size=(3, 40))
    products = points @ w
    assert np.allclose(support_of_points(points, Vector(w)), products.max(axis=0), rtol=4 * EPS, atol=0)
    graph = Graph()
    nodes = Vector(map(graph.variable, w))
    reading = support_of_points(points, nodes)
    slopes = [graph.evaluated(tangents([reading], {node: 1.0}))[0] for node in nodes]
    assert np.array_equal(np.transpose(slopes), points[products.argmax(axis=0)])


def test_vertices_of_the_hull_have_the_support_of_all_points(rng):
    inside = 0.3 * rng.uniform(-1, 1, size=(50, 3))
    corners = np.array([(x, y, z) for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
    found = extreme_points(np.concatenate([inside, corners]))
    assert sorted(map(tuple, found)) == sorted(map(tuple, corners))
    flat = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, 0)])
    assert np.array_equal(extreme_points(flat), flat)


def test_blocks_change_nothing(rng, monkeypatch):
    points, w = rng.normal(size=(200, 3)), rng.normal(size=(3, 2, 25))
    whole: Any = support_of_points(points, Vector(w))
    monkeypatch.setattr("poinsot.shapes.support.BLOCK", 1500)
    assert np.array_equal(support_of_points(points, Vector(w)), whole)
    assert whole.shape == (2, 25)
    assert support_of_points(points, Vector(w[:, 0, 0])) == whole[0, 0]
