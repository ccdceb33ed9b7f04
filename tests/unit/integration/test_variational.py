"""The variables of tangent vectors: their layout, and the rescaling of vectors that have grown."""

import numpy as np
import pytest

from poinsot.integration.variational import Variations


@pytest.mark.parametrize("order", [1, 2])
def test_rescaling_changes_no_vector(order):
    random = np.random.default_rng(1)
    variations = Variations(scaled=(False, True, True), count=2, order=order, initial=random.normal(size=(2, 3)))
    rows = variations.start()
    u, pairs, _, _ = variations.split(rows)
    u *= [[2.0**30], [2.0**4]]
    pairs += random.normal(size=pairs.shape) * 2.0**40
    before = variations.read(rows.copy())
    variations.rescale(rows)
    after = variations.read(rows)
    exponents = np.array(after[2])
    assert np.array_equal(exponents > 0, [True, False])
    assert np.array_equal(after[0] * 2.0 ** exponents[:, None], before[0])
    powers = np.array([2.0 ** (exponents[a] + exponents[b]) for a, b in variations.pairs]).reshape(-1, 1)
    assert np.array_equal(after[1] * powers, before[1])
    assert np.max(np.abs(after[0][0])) < 2.0
