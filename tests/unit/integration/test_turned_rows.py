"""Products of quaternions along rows: as machine code and as NumPy does it, wherever the rows lie in memory."""

import numpy as np
import pytest

from poinsot.algebra import quaternion as quat
from poinsot.integration import turned_rows

PLACES = {
    "of one body": lambda memory: memory[0, :, 3:7],
    "of members": lambda memory: memory[:, :, 2:6],
    "of members in blocks": lambda memory: memory[:, 1:3, 2:6],
    "by columns": lambda memory: memory[0].reshape(9, -1)[2:6].T,
    "of one instant": lambda memory: memory[1, 2, 5:],
}


@pytest.mark.parametrize("kind", [np.float64, np.longdouble])
@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("place", PLACES)
def test_rows_are_multiplied_where_they_lie(monkeypatch, place, compiled, kind):
    monkeypatch.setattr(turned_rows, "MIN_COMPILED_ROWS", 1 if compiled else 1000)
    memory = np.random.default_rng(4).normal(size=(3, 5, 9)).astype(kind)
    rows = PLACES[place](memory)
    turns, expected = np.random.default_rng(5).normal(size=rows.shape), memory.copy()
    PLACES[place](expected)[:] = quat.product(turns, rows)
    turned_rows.turn_rows(turns, rows)
    assert np.array_equal(memory, expected)


def test_one_turn_is_for_all_rows(monkeypatch):
    monkeypatch.setattr(turned_rows, "MIN_COMPILED_ROWS", 1)
    rows, turn = np.random.default_rng(6).normal(size=(5, 4)), np.array([0.0, 1.0, 0.0, 0.0])
    q0, q1, q2, q3 = rows.T.copy()
    turned_rows.turn_rows(turn, rows)
    assert np.array_equal(rows, np.stack([-q1, q0, -q3, q2], axis=-1))
