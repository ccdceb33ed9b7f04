"""The times of a page and the encoding of its numbers."""

import base64

import numpy as np
import pytest

from poinsot.plot.page_arrays import MAX_PAGE_BYTES, NARROW, WIDE, packed, rows_of


@pytest.mark.parametrize("kind", [WIDE, NARROW])
@pytest.mark.parametrize("size", [1e-300, 0.3, 1e200])
def test_packed_numbers(kind, size):
    values = size * np.array([[0.25, -1.0], [0.5, 0.0]])
    content = packed(values, kind)
    numbers = np.frombuffer(base64.b64decode(content["data"]), kind).reshape(2, 2).astype(float)
    step = 2**-24 if kind == WIDE else 0.5 / 32767
    bound = size * (step + 2**-51)  # half a unit, and the roundings of scale, product and difference
    np.testing.assert_allclose(numbers * content["scale"], values, rtol=0, atol=bound)


def test_all_times_while_they_fit():
    numbers = 16
    fit = int(MAX_PAGE_BYTES) // (8 + 4 * numbers)
    times = np.linspace(5.0, -3.0, fit)
    found = rows_of(times, [np.ones(fit)], {"all": np.empty((fit, numbers))})
    assert found.are_all
    assert found.kind == WIDE
    assert np.array_equal(found.times, times[::-1])
    more = np.linspace(0.0, 1.0, fit + 1)
    assert rows_of(more, [np.ones(fit + 1)], {"all": np.empty((fit + 1, numbers))}).kind == NARROW


def test_fewer_times_follow_the_rotation():
    numbers, count = 16, 2 * int(MAX_PAGE_BYTES) // (8 + 2 * 16)
    times = np.linspace(0.0, 1.0, count)
    rate = np.where(times < 0.5, 1.0, 9.0)
    found = rows_of(times, [rate], {"all": np.empty((count, numbers))})
    assert len(found.times) <= MAX_PAGE_BYTES / (8 + 2 * numbers) + 1
    assert (found.times[0], found.times[-1]) == (0.0, 1.0)
    slow, fast = np.count_nonzero(found.times < 0.5), np.count_nonzero(found.times > 0.5)
    assert 2.0 < fast / slow < 2.5  # equal shares of the time, and 0.1 and 0.9 of the rotation: 1.4 / 0.6
