"""Pictures of readings: the drawn numbers, axes that are upside down, units, legends and errors."""

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer

import poinsot as pt
from poinsot.observables.readings import Readings

MAGNITUDES = {"units": "mag", "time_units": "h"}
TIMES = np.array([0.0, 1.0, 2.0, 3.0, 30.0, 31.0])
VALUES = np.array([18.0, 18.5, 18.2, 17.9, 18.1, 18.4])
PERIODS = (5.0, 7.0)


class Glow(pt.Observable):
    def reading(self, instant):
        return instant.omega_body[0]


class Compass(pt.Observable):
    components = ("x", "y", "z")

    def reading(self, instant):
        return instant.omega_body


class Dated(pt.Observable):
    orbit: pt.Orbit

    def reading(self, instant):
        return instant.omega_body[0]


def of(times=TIMES, values=VALUES, sigma=None, name="", observable: Any = None, **attributes) -> Readings:
    return Readings(observable or Glow(), times, values, sigma, name=name, attributes=MAGNITUDES | attributes)


def ephemeris(calendar):
    def along(times):
        return np.stack([1 + 0 * times, times, 0 * times], axis=-1)

    return pt.orbits.Ephemeris.from_function(2.0, position=along, start=0.0, stop=40.0, calendar=calendar)


@pytest.fixture(autouse=True)
def _closed():
    mpl.use("Agg")
    yield
    plt.close("all")


def points_of(panel):
    """The places of points with error bars, by their names."""
    bars = [each for each in panel.containers if isinstance(each, ErrorbarContainer)]
    return {each.get_label(): np.stack(each.lines[0].get_data()) for each in bars}


def first_points(panel):
    return next(iter(points_of(panel).values()))


def lengths_of_bars(panel):
    return [np.diff(piece[:, 1])[0] for bars in panel.collections for piece in bars.get_segments()]


def test_brighter_is_higher_and_units_are_on_the_axes():
    panel = pt.plot.readings(of())
    assert panel.yaxis_inverted()
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("time [h]", "magnitude [mag]")
    assert panel.get_legend() is None
    again = pt.plot.readings(of(), ax=panel)
    assert again is panel
    assert panel.yaxis_inverted()
    rate = pt.plot.readings(of(units="rad s-1", frame="body"))
    assert not rate.yaxis_inverted()
    assert rate.get_ylabel() == "glow, body axes [rad s⁻¹]"


def test_a_curve_is_interrupted_at_the_end_of_a_night():
    [line] = pt.plot.readings(of(), time_unit="min").lines
    x, y = line.get_data()
    assert np.array_equal(x, 60 * TIMES[[0, 1, 2, 3, 4, 4, 5]])
    assert np.array_equal(y, [*VALUES[:4], np.nan, *VALUES[4:]], equal_nan=True)
    assert not np.isnan(pt.plot.readings(of(TIMES[:4], VALUES[:4])).lines[0].get_ydata()).any()


def test_readings_with_sigma_are_points_with_error_bars():
    panel = pt.plot.readings([of(sigma=0.1, name="first"), of(TIMES + 0.5, VALUES + 1, 0.2, name="second")])
    drawn = points_of(panel)
    assert list(drawn) == ["first", "second"]
    assert np.array_equal(drawn["first"], [TIMES, VALUES])
    assert np.array_equal(drawn["second"], [TIMES + 0.5, VALUES + 1])
    assert np.allclose(lengths_of_bars(panel), np.repeat([0.2, 0.4], TIMES.size), rtol=1e-12, atol=0)
    assert len(panel.get_legend().get_texts()) == 2
    low, high = panel.get_xlim()
    assert low < 0
    assert high > 31.5


def test_points_can_be_asked_for_and_refused():
    assert np.array_equal(first_points(pt.plot.readings(of(), points=True))[1], VALUES)
    assert not points_of(pt.plot.readings(of(sigma=0.1), points=False))


def test_readings_of_one_name_are_numbered_and_many_are_not_named():
    nights = [of(TIMES + 40 * k, sigma=0.1) for k in range(3)]
    assert list(points_of(pt.plot.readings(nights))) == ["glow 1", "glow 2", "glow 3"]
    assert pt.plot.readings([of(TIMES + 40 * k, sigma=0.1) for k in range(13)]).get_legend() is None


def test_components_are_curves_and_equal_ones_differ_in_style():
    values = np.stack([VALUES, 2 * VALUES, 2 * VALUES], axis=-1)
    panel = pt.plot.readings(of(values=values, observable=Compass(), units="T"))
    assert [line.get_label() for line in panel.lines] == ["x", "y", "z"]
    assert all(np.array_equal(np.delete(line.get_ydata(), 4), values[:, i]) for i, line in enumerate(panel.lines))
    assert panel.lines[1].get_linestyle() != panel.lines[2].get_linestyle()
    both = [of(values=values, observable=Compass(), units="T", name=name) for name in ("north", "south")]
    names = [line.get_label() for line in pt.plot.readings(both).lines]
    assert names == ["north x", "north y", "north z", "south x", "south y", "south z"]


def test_readings_of_one_of_two_bodies_name_the_body():
    panel = pt.plot.readings([of(observable=Glow().on(body)) for body in ("primary", "secondary")])
    assert [line.get_label() for line in panel.lines] == ["glow of the primary", "glow of the secondary"]
    assert pt.plot.readings(of(observable=Glow().on("primary"), units="m2")).get_ylabel() == "glow [m²]"


def test_readings_that_are_absent_are_not_drawn():
    values = np.where(TIMES == 2.0, np.nan, VALUES)
    [line] = pt.plot.readings(of(values=values)).lines
    assert np.array_equal(np.delete(line.get_ydata(), 4), values, equal_nan=True)
    plane = pt.plot.phase_plane(of(values=values), PERIODS, of(values=values))
    assert np.count_nonzero(np.isfinite(np.ma.filled(plane.images[0].get_array(), np.nan))) == TIMES.size - 1


def test_an_ensemble_is_its_median_between_bands():
    values = VALUES + np.linspace(-1, 1, 21)[:, None] ** 3
    panel = pt.plot.readings(of(values=values))
    assert np.allclose(np.delete(panel.lines[0].get_ydata(), 4), np.median(values, axis=0), rtol=1e-15, atol=0)
    assert len(panel.collections) == 2
    assert "Median of 21 members" in panel.figure.get_supxlabel()


def test_unsorted_readings_are_drawn_in_the_order_of_time():
    order = [3, 0, 2, 1, 5, 4]
    [line] = pt.plot.readings(of(TIMES[order], VALUES[order])).lines
    assert np.array_equal(np.delete(line.get_ydata(), 4), VALUES)


def test_a_window_shows_some_of_the_readings():
    [line] = pt.plot.readings(of(), window=(1.0, 3.0)).lines
    assert np.array_equal(line.get_ydata(), VALUES[1:4])
    message = r"^window must hold a time of the readings, which are from 0 to 31, got \(50, 60\)\.$"
    with pytest.raises(ValueError, match=message):
        pt.plot.readings(of(), window=(50, 60))


def test_readings_of_orbits_with_a_calendar_have_dates():
    pytest.importorskip("astropy")
    seen = Dated(ephemeris(pt.Calendar("2026-11-28T00:00:00", "TDB", "h")))
    assert pt.plot.readings(of(observable=seen)).get_xlabel() == "date, from 2026-11-28T00:00:00 TDB"
    folded = pt.plot.phased(of(observable=seen), 5.0, epoch="2026-11-28T01:00:00 TDB")
    assert np.allclose(first_points(folded)[0], (TIMES - 1) / 5 % 1, rtol=0, atol=1e-9)
    with pytest.raises(ValueError, match=r"^time_unit must not be 'date' without a calendar of the times, got 'date'"):
        pt.plot.readings(of(), time_unit="date")


# ---------------------------------------------------------------------- phases


def test_readings_are_folded_with_a_period_from_an_epoch():
    panel = pt.plot.phased(of(), 5.0, epoch=1.0)
    assert np.allclose(first_points(panel), [[0.8, 0, 0.2, 0.4, 0.8, 0], VALUES], rtol=0, atol=1e-14)
    assert panel.get_xlabel() == "phase, period 5 h"
    assert panel.get_xlim() == (0, 1)
    assert panel.yaxis_inverted()
    assert pt.plot.phased(of(), 5.0, time_unit="min").get_xlabel() == "phase, period 300 min"


def test_the_model_is_a_curve_for_each_cycle():
    times = np.linspace(0, 10, 41)
    panel = pt.plot.phased(of(sigma=0.1), 5.0, of(times, 18 + np.sin(times)))
    [line] = [line for line in panel.lines if line.get_label() == "model"]
    phase, values = map(np.asarray, line.get_data())
    assert np.count_nonzero(np.isnan(values)) == 2
    known = ~np.isnan(values)
    assert np.allclose(phase[known], times / 5 % 1, rtol=0, atol=1e-14)
    assert np.array_equal(values[known], 18 + np.sin(times))


def test_points_on_the_phase_plane_have_the_colours_of_their_values():
    panel = pt.plot.phase_plane(of(), PERIODS, epoch=0.5)
    [points] = panel.collections
    expected = np.mod((TIMES[:, None] - 0.5) / PERIODS, 1)
    assert np.allclose(points.get_offsets(), expected, rtol=0, atol=1e-14)
    assert np.array_equal(points.get_array(), VALUES)
    assert panel.get_xlabel() == r"phase of rotation, $P_\psi$ = 5 h"
    assert panel.get_ylabel() == r"phase of precession, $P_\phi$ = 7 h"
    [bar] = [each for each in panel.figure.axes if each is not panel]
    assert bar.get_ylabel() == "magnitude [mag]"
    assert bar.yaxis_inverted()
    dark, bright = (np.sum(points.cmap(points.norm(value))[:3]) for value in (18.5, 17.9))
    assert dark < bright


def test_the_model_is_the_background_of_the_phase_plane():
    times = np.random.default_rng(3).uniform(0, 3000, 200_000)
    phases = np.mod(times[:, None] / PERIODS, 1)
    panel = pt.plot.phase_plane(of(), PERIODS, of(times, 18 + phases[:, 0] + 2 * phases[:, 1]))
    [image] = panel.images
    middle = (np.arange(60) + 0.5) / 60
    expected = 18 + middle[None, :] + 2 * middle[:, None]  # rows: phase of precession; columns: phase of rotation
    assert np.allclose(image.get_array(), expected, rtol=0, atol=3 / 60)
    assert image.get_clim() == panel.collections[0].get_clim()
    sparse = pt.plot.phase_plane(of(), PERIODS, of())
    assert np.count_nonzero(np.isfinite(np.ma.filled(sparse.images[0].get_array(), np.nan))) == TIMES.size


# ---------------------------------------------------------------------- wrong arguments

FLUX = {"units": "m2", "time_units": "h"}
MEMBERS = of(values=np.tile(VALUES, (3, 1)))
VECTORS = of(values=np.zeros((6, 3)), observable=Compass())
WRONG: dict[str, Any] = {
    "plan": (lambda: pt.plot.readings(of(values=None)), "readings must contain values to draw, got 'Glow' without."),
    "none": (lambda: pt.plot.readings([]), "readings must contain readings to draw, got none."),
    "units": (
        lambda: pt.plot.readings([of(), of(units="m2")]),
        "readings must have equal units, got 'mag' and 'm2'. Draw them in separate panels.",
    ),
    "time units": (
        lambda: pt.plot.phased(of(), 5.0, of(time_units="s")),
        "readings must have equal time_units, got 'h' and 's'. Draw them in separate panels.",
    ),
    "period": (lambda: pt.plot.phased(of(), 0.0), "period must be positive, got 0.0."),
    "date": (
        lambda: pt.plot.phased(of(), 5.0, epoch="2026-01-01"),
        "epoch must be a number where the readings have no calendar, got '2026-01-01'.",
    ),
    "one period": (lambda: pt.plot.phase_plane(of(), 5.0), "periods must have shape (2,), got shape ()."),
    "members": (
        lambda: pt.plot.phase_plane(MEMBERS, PERIODS),
        "readings must be of one body, got an ensemble.",
    ),
    "vectors": (
        lambda: pt.plot.phase_plane(of(), PERIODS, VECTORS),
        "model must be of one number, got 3 components: x, y, z.",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_arguments_have_one_message(case):
    call, message = WRONG[case]
    with pytest.raises(ValueError) as error:
        call()
    assert str(error.value).startswith(message)


def test_what_is_no_readings_is_refused():
    with pytest.raises(TypeError, match=r"^readings must be a Readings or a list, each a Readings, got int\.$"):
        pt.plot.readings(3)
