import numpy as np
import pytest

from poinsot import functions
from poinsot.taylor.graph import MAX_SELECTIONS, Evaluator, Graph, wide


def formulas():
    a, b, c, d = map(Graph().input, range(4))
    return [a * b + c, functions.sin(a) - d, 2.5, a, b / c**2, -3.0 * functions.sqrt(d * d), a - b, 1e300 * d]


def by_hand(a, b, c, d):
    return [a * b + c, np.sin(a) - d, 2.5, a, b / (c * c), -3 * np.sqrt(d * d), a - b, 1e300 * d]


@pytest.mark.parametrize("kind", [np.float64, np.longdouble])
def test_what_changes_is_computed_anew_whichever_numbers_change_together(kind):
    rng, replay = np.random.default_rng(1), Evaluator(formulas(), kind)
    numbers, changed = [*map(np.float64, rng.normal(size=4))], set()
    for _ in range(100):
        others = rng.random(4) < 0.4
        changed.add(tuple(others))
        numbers = [np.float64(rng.normal()) if other else x for other, x in zip(others, numbers, strict=True)]
        assert [*replay(numbers)] == by_hand(*map(kind, numbers))
    assert len(changed) > MAX_SELECTIONS


def test_zeros_of_both_signs_are_different_numbers():
    replay = Evaluator(formulas(), np.float64)
    for zero in (0.0, -0.0, 0.0):
        values = replay([np.float64(zero), 1.0, 2.0, 3.0])
        assert np.signbit(values[3]) == np.signbit(zero)


def test_arrays_are_computed_with_every_time():
    replay, rows = Evaluator(formulas(), np.float64), np.array([1.0, 2.0])
    for scale in (1.0, 2.0):
        rows[:] = scale, 2 * scale
        assert np.array_equal(replay([rows, 1.0, 2.0, 3.0])[0], rows + 2.0)


def test_the_same_numbers_give_the_same_values_and_not_a_number_is_never_the_same():
    replay, numbers = Evaluator(formulas(), np.float64), [0.5, 1.0, 2.0, 3.0]
    values = replay(numbers)
    assert replay([np.float64(x) for x in numbers]) is values
    for _ in range(2):
        assert np.isnan(replay([np.nan, *numbers[1:]])[0])
    assert replay(numbers) == values


@pytest.mark.parametrize("number", [0.1, -0.0, 5e-324, np.inf, np.nan, np.float64(1.1), np.longdouble(1) / 3, 7])
def test_wide_numbers_are_long_doubles_of_the_same_value(number):
    for made in (wide(number), *wide(np.array([number]))):
        assert type(made) is np.longdouble
        assert str(made) == str(np.longdouble(number))
        assert np.signbit(made) == np.signbit(number)
