"""Ends of motions in quadruple precision with all their digits, which results round to doubles."""

from unittest import mock

import mpmath
import numpy as np

import poinsot as pt
from poinsot.integration.run import Slab
from poinsot.records.members import members_of


def ends_of(system, state, time, **options):
    """Return the variables of each member at a time, mpmath numbers: those of the formulation in physical units."""
    found = []
    record = Slab.record

    def recorded(slab):
        record(slab)
        for member, task in zip(slab.owners.tolist(), slab.queue.tasks, strict=True):
            assert task["time"].tolist() == [time, 0.0]
            variables = members_of(slab.run.parameters.variables, member)
            scales = np.ones(variables.size)
            scales[variables.scaled] = variables.scale
            parts = zip(task["state"].tolist(), task["below"].tolist(), scales.tolist(), strict=True)
            found.append((member, [(mpmath.mpf(high) + mpmath.mpf(low)) / scale for high, low, scale in parts]))

    with mock.patch.object(Slab, "record", recorded):
        pt.propagate(system, state, [time], precision="quadruple", **options)
    return [variables for _, variables in sorted(found, key=lambda each: each[0])]


def end_of(system, state, time, **options):
    """Return the variables of one body at a time."""
    (variables,) = ends_of(system, state, time, **options)
    return variables
