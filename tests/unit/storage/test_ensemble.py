"""Ensembles as chunks see them."""

import poinsot as pt
from poinsot.storage.ensemble import ChunkResult

BODY = pt.Body((1.25, 1.0, 0.75))
FALLING = BODY.state((0.5**0.5, 0.5**0.5, 0, 0), omega_body=[(0, 0, 1), (-1, 0, 0)])


def test_failures_have_the_numbers_of_the_ensemble():
    motion = pt.propagate(pt.System(BODY), FALLING, [5.0], formulation="euler_angles", threads=1)
    result = ChunkResult.of(motion.failures, motion.run, 10, {}, {}, False)
    assert result.about["failures"] == {"11": motion.failures[1]}
    assert result.about["run"]["steps"] == motion.run.steps
