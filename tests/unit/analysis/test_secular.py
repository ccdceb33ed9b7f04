"""Averaged evolution: effects add up, and it stops where it is told."""

import numpy as np
import pytest

import poinsot as pt


def decay(rate):
    return lambda state: {"rate": -rate * state["rate"]}


def test_rates_of_change_add_up():
    found = pt.analysis.secular_evolution(
        [decay(0.2), decay(0.3), lambda state: {"obliquity": state["rate"]}],
        {"rate": 2.0, "obliquity": 0.1},
        np.linspace(0, 4, 9),
    )
    np.testing.assert_allclose(found.values["rate"], 2 * np.exp(-0.5 * found.times), rtol=1e-10)
    np.testing.assert_allclose(found.values["obliquity"], 0.1 + 4 * (1 - np.exp(-0.5 * found.times)), rtol=1e-10)
    assert found.stopped is None
    assert "stopped" not in repr(found)


def test_it_stops_where_it_is_told():
    found = pt.analysis.secular_evolution(
        [lambda _: {"rate": -0.5}], {"rate": 2.0}, [0.0, 1.0, 8.0], until=lambda state: state["rate"] - 0.25
    )
    assert abs(found.stopped - 3.5) < 1e-10
    assert list(found.times) == [0.0, 1.0]
    np.testing.assert_allclose(found.values["rate"], [2.0, 1.5], rtol=1e-13)


def test_scales_of_variables_do_not_count():
    tiny = pt.analysis.secular_evolution([decay(1e-15)], {"rate": 3e-9}, [0.0, 1e15])
    np.testing.assert_allclose(tiny.values["rate"][-1], 3e-9 * np.exp(-1), rtol=1e-10)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (([decay(0.1)], {"obliquity": 0.1, "rate": 1.0}, [0.0]), "times must be two at least and ascend, got 0."),
        (
            ([lambda _: {"spin": 1.0}], {"rate": 1.0}, [0, 1]),
            "effects must change variables of the start, rate, got 'spin'.",
        ),
        (
            ([decay(0.1)], {"speed": 1.0}, [0, 1]),
            "start must have the variable 'rate', got speed. An",
        ),
        (([decay(0.1)], {"rate": np.inf}, [0, 1]), "rate must be finite"),
        (([lambda s: {"rate": s["rate"] ** 2}], {"rate": 1.0}, [0, 2]), "effects must have finite rates of change"),
        (([lambda _: None], {"rate": 1.0}, [0, 1]), "effects must return mappings of rates of change by name, got"),
        (([lambda _: {"rate": "1"}], {"rate": 1.0}, [0, 1]), "the rate of change of rate must be real numbers, got"),
    ],
)
def test_wrong_arguments_are_refused_in_sentences(arguments, sentence):
    with pytest.raises((TypeError, ValueError), match=f"^{sentence}"):
        pt.analysis.secular_evolution(*arguments)


def test_an_end_that_is_no_number_is_refused_in_a_sentence():
    with pytest.raises(TypeError, match=r"^what until returns must be real numbers, got NoneType None\.$"):
        pt.analysis.secular_evolution([decay(0.1)], {"rate": 1.0}, [0, 1], until=lambda _: None)
