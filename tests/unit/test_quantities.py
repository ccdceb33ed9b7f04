"""Quantities with a unit: which convert, to what, and the sentences about the others."""

import datetime as dt
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time

import poinsot as pt
from poinsot.storage.run_record import RunRecord
from poinsot.taylor.graph import Graph, Node
from public_calls import ELLIPSE, START, TOP, public_calls

ANGLES = {
    *("inclination", "node", "argument_of_periapsis", "true_anomaly", "mean_anomaly", "eccentric_anomaly"),
    *("angle", "angles", "obliquity", "l", "g", "h"),
}
"""Names of arguments, which are angles wherever they are."""

DAYS = pt.System(TOP.body, *TOP.forces, units={"time": "d"})
SI = pt.System(pt.Body((1.0, 2.0, 3.0)), units={"time": "s", "inertia": "kg m2"})
UNNAMED = pt.System(TOP.body, *TOP.forces)


def numbers_of(result):
    """Every number in a result, of records and states."""
    if isinstance(result, dict):
        result = list(result.values())
    if isinstance(result, list | tuple):
        return [number for one in result for number in numbers_of(one)]
    if isinstance(result, np.ndarray | float):
        return list(np.ravel(result))
    if not type(result).__module__.startswith("poinsot") or isinstance(result, RunRecord | Graph | Node):
        return []
    derived = {
        name for name in vars(result) if isinstance(getattr(type(result), name, None), functools.cached_property)
    }
    return numbers_of({name: value for name, value in vars(result).items() if name not in derived})


@pytest.mark.parametrize("unit", ["deg", "arcmin", "rad"])
def test_angles_convert_to_radians_everywhere(tmp_path, unit):
    tried = 0
    for name, (function, arguments) in public_calls(tmp_path).items():
        for argument in arguments.keys() & (ANGLES - {"g", "h"} if name.endswith("Harmonics") else ANGLES):
            given = {**arguments, argument: np.array(arguments[argument]) * u.rad.to(unit) * u.Unit(unit)}
            plain, converted = (np.array(numbers_of(function(**each)), dtype=complex) for each in (arguments, given))
            np.testing.assert_allclose(converted, plain, rtol=2e-14, atol=2e-14, err_msg=f"{name} {argument}")
            tried += plain.size > 0
    assert tried > 15


def test_times_convert_where_their_unit_is_named():
    times = np.array([0.5, 1.0]) * u.h
    assert pt.propagate(DAYS, START, times).times == pytest.approx([1 / 48, 1 / 24], rel=1e-15, abs=0)
    assert pt.free_motion(TOP.body, START, times, units={"time": "min"}).times.tolist() == [30.0, 60.0]
    motion = pt.propagate(DAYS, START, times, dense=True)
    np.testing.assert_array_equal(motion(0.75 * u.h).quaternion, motion(1 / 32).quaternion)
    calendar = pt.Calendar("2026-11-21T00:00:00", "TAI", "min")
    assert calendar.time(2 * u.h) == 120.0
    orbit = pt.orbits.Ephemeris.from_function(
        2.0, position=lambda t: np.stack(ELLIPSE.position_at(t), -1), start=0, stop=3, calendar=calendar
    )
    summed = pt.orbits.composite_orbit(orbit, orbit, start=60 * u.s, stop=120 * u.s)
    assert summed.span == (1.0, 2.0)


def test_states_of_a_system_with_units():
    state = SI.state((1, 0, 0, 0), omega_body=(0, 0, 90) * u.deg / u.min, time=1 * u.min)
    assert state.time == 60.0
    np.testing.assert_allclose(SI.omega_body(state), (0, 0, np.pi / 120), rtol=1e-15)
    state = SI.state((1, 0, 0, 0), angular_momentum_body=(0, 0, 2) * u.N * u.m * u.s)
    np.testing.assert_allclose(state.angular_momentum_body, (0, 0, 2), rtol=1e-15)


def test_states_of_two_bodies_with_units():
    body = pt.Body((1.0, 2.0, 3.0), mass=1.0)
    units = {"time": "s", "inertia": "kg m2", "length": "m"}
    pair: Any = pt.System(pt.TwoBodies(body, body), pt.forces.MutualGravity(), units=units)
    state = pair.state(
        (1, 0, 0) * u.km, (0, 0, 3.6) * u.km / u.h, [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2 * u.deg / u.s
    )
    plain = pair.state((1000, 0, 0), (0, 0, 1.0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, np.pi / 180)] * 2)
    for name in ("primary", "secondary"):
        np.testing.assert_allclose(
            state.of_bodies[name].angular_momentum_body, plain.of_bodies[name].angular_momentum_body, rtol=1e-15
        )
    np.testing.assert_allclose(state.position, plain.position, rtol=1e-15)
    np.testing.assert_allclose(state.momentum, plain.momentum, rtol=1e-15)


NAMES_IT = "System(..., units={'time': 's'}) names it."
SENTENCES = {
    "another kind of unit": (
        lambda: SI.state((1, 0, 0, 0), omega_body=(0, 0, 1) * u.m),
        "omega_body must convert to rad s-1, the unit of the system, got a quantity in m.",
    ),
    "no unit of inertia": (
        lambda: DAYS.state((1, 0, 0, 0), angular_momentum_body=(0, 0, 1) * u.kg * u.m**2 / u.s),
        "angular_momentum_body must be plain numbers in your own units, got a quantity in m2 kg / s. "
        "Write value.to_value(unit), with the unit that your other numbers have.",
    ),
    "unit of a system": (
        lambda: pt.System(TOP.body, units={"time": u.s}),
        "units must be words, but units['time'] = Unit(\"s\"). Write 's'.",
    ),
    "no unit of time": (
        lambda: pt.propagate(UNNAMED, START, [1, 2] * u.s),
        f"times must be plain numbers, or times where the unit of time is named, got a quantity in s. {NAMES_IT}",
    ),
    "another unit": (
        lambda: pt.propagate(DAYS, START, [1, 2] * u.kg),
        "times must convert to d, the unit of the system, got a quantity in kg.",
    ),
    "rate": (
        lambda: TOP.body.state((1, 0, 0, 0), omega_body=(1, 2, 3) * u.deg / u.s),
        "omega_body must be plain numbers in your own units, got a quantity in deg / s. "
        "Write value.to_value(unit), with the unit that your other numbers have.",
    ),
    "no dimension": (
        lambda: pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0.1 * u.one),
        "eccentricity must be plain numbers in your own units, got a dimensionless quantity. "
        "Write value.to_value(unit), with the unit that your other numbers have.",
    ),
    "length for an angle": (
        lambda: pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0.1, inclination=3 * u.km),
        "inclination must be an angle, got a quantity in km.",
    ),
    "mask": (
        lambda: pt.Body(np.ma.masked_array((1.25, 1, 0.75), mask=(0, 1, 0))),
        "moments must be plain numbers, got a masked array. Write value.compressed(), or value.filled(number).",
    ),
}


@pytest.mark.parametrize("name", SENTENCES)
def test_others_are_refused(name):
    call, sentence = SENTENCES[name]
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == sentence


DATED = {
    "datetime": [dt.datetime(2026, 1, 1)],
    "date": [dt.date(2026, 1, 1)],
    "numpy": np.array(["2026-01-01", "2026-01-02"], "M8[D]"),
    "text": ["2026-01-01T00:00:00 UTC"],
    "astropy": Time(["2026-01-01", "2026-01-02"]),
    "astropy, in a list": [Time("2026-01-01")],
}


@pytest.mark.parametrize("name", DATED)
def test_dates_without_a_calendar_are_refused_with_the_conversion(name):
    calls: dict[str, list[Callable[[object], object]]] = {
        "times": [lambda t: pt.propagate(TOP, START, t), lambda t: pt.free_motion(TOP.body, START, t)],
        "time": [lambda t: TOP.body.state((1, 0, 0, 0), omega_body=(0, 0, 1), time=t), lambda t: pt.events.AtTime(t)],
    }
    for argument, those in calls.items():
        for call in those:
            with pytest.raises(TypeError) as caught:
                call(DATED[name])
            sentence = f"{argument}=pt.Calendar('2026-01-01T00:00:00', 'UTC').time(dates)."
            assert str(caught.value).startswith(f"{argument} must be real numbers, got ")
            assert str(caught.value).endswith(f" A calendar makes numbers of dates: {sentence}")


@pytest.mark.parametrize("times", [[dt.timedelta(0), dt.timedelta(seconds=2)], np.array([0, 2], "m8[s]")])
def test_durations_are_refused_with_the_conversion(times):
    hint = r"np.array\(times, 'm8\[us\]'\) / np.timedelta64\(1, 's'\)"
    with pytest.raises(TypeError, match=rf"^times must be real numbers, got .* Durations become numbers: {hint}\.$"):
        pt.propagate(TOP, START, times)
    np.testing.assert_array_equal(np.array(times, "m8[us]") / np.timedelta64(1, "s"), [0.0, 2.0])


def test_an_inclination_is_no_number_of_degrees():
    sentence = r"^inclination must be within 2 pi, in radians, got 51.6. Degrees: np.radians\(51.6\).$"
    with pytest.raises(ValueError, match=sentence):
        pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0.1, inclination=51.6)
    assert pt.KeplerOrbit(1, semimajor_axis=1, eccentricity=0.1, inclination=-2 * np.pi, node=300.0).node == 300.0
    assert pt.KeplerOrbit(
        1, semimajor_axis=1, eccentricity=0.1, inclination=[0.1, 0.2] * u.deg
    ).inclination == pytest.approx(np.radians([0.1, 0.2]))
