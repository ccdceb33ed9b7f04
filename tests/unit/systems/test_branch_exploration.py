"""Conditions in traced formulas, forced to go every way."""

import numpy as np

from poinsot import functions
from poinsot.systems.branch_exploration import BRANCH_SAMPLES, conditions, on_branches
from poinsot.taylor.graph import Graph


def test_samples_go_all_ways_of_four_conditions_whatever_the_times_are():
    graph = Graph()
    time = graph.variable(np.zeros(BRANCH_SAMPLES))
    steps = [functions.where(functions.less(limit, time), 1.0, 0.0) for limit in (1.0, 2.0, 3.0, 4.0)]
    found = np.array(on_branches(graph, [*steps, steps[0] + 2 * time]))
    assert len({tuple(column) for column in found[:4].T}) == BRANCH_SAMPLES
    assert np.array_equal(found[4], found[0])
    assert np.array_equal(np.array(on_branches(graph, steps, other=True)), 1 - found[:4])
    assert np.array_equal(graph.evaluated(steps)[0], np.zeros(BRANCH_SAMPLES))


def test_more_samples_repeat_the_ways():
    graph = Graph()
    time = graph.variable(np.zeros(2 * BRANCH_SAMPLES))
    (found,) = on_branches(graph, [functions.where(functions.less(time, 1.0), 1.0, 0.0)], 2 * BRANCH_SAMPLES)
    assert np.array_equal(found[:BRANCH_SAMPLES], found[BRANCH_SAMPLES:])
    assert np.sum(found) == BRANCH_SAMPLES


def test_conditions_are_those_on_what_varies():
    graph = Graph()
    time = graph.variable(np.zeros(BRANCH_SAMPLES))
    fixed = functions.where(functions.less(graph.input(0), 1.0), 1.0, 2.0)
    asked = functions.less(time, 1.0)
    assert conditions([fixed, 2.5]) == []
    assert conditions([fixed * time, functions.where(asked, time, 0.0) + time]) == [asked]
