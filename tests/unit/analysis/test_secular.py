"""Averaged evolution: sums of effects, and its end at a zero of `until`."""

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


def test_it_stops_at_a_zero_of_until():
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
    with pytest.raises(TypeError, match=r"^value of until must be real numbers, got NoneType None\.$"):
        pt.analysis.secular_evolution([decay(0.1)], {"rate": 1.0}, [0, 1], until=lambda _: None)


def test_a_variable_that_until_reads_is_one_of_the_start():
    with pytest.raises(ValueError, match=r"^start must have the variable 'rate', got spin\. until reads it\.$"):
        pt.analysis.secular_evolution([lambda _: {}], {"spin": 1.0}, [0, 1], until=lambda state: state["rate"])


YEARS = np.linspace(0.0, 4e15, 41)


def slower(_):
    return {"rate": -1e-21}


@pytest.mark.parametrize(
    ("until", "expected"),
    [
        (lambda s: abs(s["rate"] - 1.5e-6) - 1e-7, 1.4e15),  # a band of rates that lasts two output intervals
        (lambda s: abs(s["rate"] - 1.512e-6) - 7e-9, 1.481e15),  # a band of 0.14 output intervals
        (lambda s: np.sin(np.pi * (s["rate"] / 1e-7 + 0.3)), 3e13),  # a zero in each output interval
        (lambda s: np.sin(np.pi * (s["rate"] / 2e-8 + 0.3)), 6e12),  # five zeros in each
    ],
)
def test_the_first_of_many_zeros_stops_the_evolution(until, expected):
    found = pt.analysis.secular_evolution([slower], {"rate": 3e-6}, YEARS, until=until)
    assert abs(found.stopped / expected - 1) < 1e-9
    assert np.array_equal(found.times, YEARS[found.stopped >= YEARS])
    np.testing.assert_allclose(found.values["rate"], 3e-6 - 1e-21 * found.times, rtol=1e-12)


@pytest.mark.parametrize("scale", [1e-15, 1.0, 1e15])
def test_two_times_resolve_a_band_of_a_500th_of_the_whole_time(scale):
    found = pt.analysis.secular_evolution(
        [lambda _: {"rate": 1 / scale}], {"rate": 0.0}, [0.0, scale], until=lambda s: abs(s["rate"] - 0.4321) - 1e-3
    )
    assert abs(found.stopped - 0.4311 * scale) < 1e-12 * scale


@pytest.mark.parametrize("rate", [1.5e-6, 1.5512e-6, 2.117e-6])
@pytest.mark.parametrize("width", [2e-8, 5e-9])
def test_a_resonance_that_is_crossed_once_is_integrated(rate, width):
    def kick(state):
        return {"obliquity": 1e-16 * np.exp(-(((state["rate"] - rate) / width) ** 2))}

    found = pt.analysis.secular_evolution([slower, kick], {"rate": 3e-6, "obliquity": 0.6}, YEARS)
    assert abs((found.values["obliquity"][-1] - 0.6) / (1e-16 * np.sqrt(np.pi) * width / 1e-21) - 1) < 1e-8


@pytest.mark.parametrize("share", np.linspace(0.0, 1.0, 23))
def test_a_torque_of_a_third_of_an_output_interval_is_not_missed(share):
    """A torque that begins and ends abruptly, which all stages between 0.333 and 0.6 of a step can miss."""

    def brief(state):
        return {"angle": float(0 <= state["clock"] - 17 - share < 1 / 3)}

    found = pt.analysis.secular_evolution(
        [lambda _: {"clock": 1.0}, brief], {"clock": 0.0, "angle": 1.0}, np.arange(41.0)
    )
    # each of the two jumps leaves the tolerance of some steps
    assert abs(found.values["angle"][-1] - 4 / 3) < 1e-9


def test_logarithmic_times_resolve_what_happens_early():
    times = np.concatenate([[0.0], np.logspace(-6, 6, 25)])
    found = pt.analysis.secular_evolution(
        [lambda _: {"clock": 1.0}], {"clock": 0.0}, times, until=lambda s: abs(s["clock"] - 2e-4) - 2e-5
    )
    assert abs(found.stopped - 1.8e-4) < 1e-15


def test_a_zero_at_the_first_time_stops_there():
    found = pt.analysis.secular_evolution([decay(0.1)], {"rate": 2.0}, [3.0, 5.0], until=lambda s: s["rate"] - 2.0)
    assert found.stopped == 3.0
    assert list(found.times) == [3.0]
    assert list(found.values["rate"]) == [2.0]


def test_equal_output_intervals_are_one_step_each():
    calls = []

    def counted(state):
        calls.append(state)
        return {"rate": -0.1}

    pt.analysis.secular_evolution([counted], {"rate": 2.0}, np.linspace(0, 7, 301))
    assert len(calls) < 301 * 14
