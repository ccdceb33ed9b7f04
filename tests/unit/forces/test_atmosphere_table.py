"""Air by a table along an orbit: against the same density as a formula, and an empirical model that is asked for it."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

import poinsot as pt
from poinsot.forces import Atmosphere, AtmosphericDrag, Facets, TabulatedAtmosphere

ORBIT = pt.KeplerOrbit(3.986004418e14, semimajor_axis=6.778e6, eccentricity=0.002, inclination=1.2, node=0.4)
TIMES = np.linspace(0, 3000, 61)
RATE = 2 * np.pi / 2500


class Bulge(Atmosphere):
    """Air that is thicker once a revolution."""

    mean: float

    def density(self, instant, orbit):  # noqa: ARG002
        return self.mean * pt.functions.exp(0.8 * pt.functions.cos(RATE * instant.time))


def table(times=TIMES, **options):
    return TabulatedAtmosphere.from_table(times, 4e-11 * np.exp(0.8 * np.cos(RATE * times)), **options)


def drag(air):
    box = Facets.from_box((0.2, 0.3, 0.5), (0.02, 0.03, -0.05))
    return pt.System(pt.Body((0.09, 0.11, 0.13)), AtmosphericDrag(ORBIT, air, box))


def motion(air, stop=3000.0, **options):
    system = drag(air)
    start = system.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.001, -0.002, 0.0015))
    return pt.propagate(system, start, [0.0, 0.4 * stop, stop], **options)


def test_a_motion_is_that_in_the_air_of_the_function():
    turning = (0, 0, 7.3e-5)
    exact, coarse, fine = (
        motion(air).quaternion
        for air in (
            Bulge(4e-11, omega_space=turning),
            table(omega_space=turning),
            table(np.linspace(0, 3000, 241), omega_space=turning),
        )
    )
    errors = [np.max(np.abs(found - exact)) for found in (coarse, fine)]
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 50  # fourth order: 256, less what edges and the ends of a spline take


def test_the_table_is_its_rows():
    air, system = table(), drag(table())
    states = system.state((1, 0, 0, 0), omega_body=(0, 0, 0), time=TIMES)
    found = air.density(system.at(states), ORBIT)
    assert np.allclose(found, 4e-11 * np.exp(0.8 * np.cos(RATE * TIMES)), rtol=1e-14, atol=0)


def test_torques_along_a_motion_are_those_of_the_kernel():
    along = motion(table(), dense=True)
    middle, step = 1234.5, 1e-2
    before, after = (along(middle + x).angular_momentum_space for x in (-step, step))
    here = along(middle)
    turned = here.attitude.apply(drag(table()).torque_body(here))
    assert np.max(np.abs((after - before) / (2 * step) - turned)) < 1e-5 * np.max(np.abs(turned))


def test_a_run_beyond_the_table_is_refused():
    with pytest.raises(
        ValueError, match=r"times must lie within the span of orbits, fields and tables, \[0.0, 3000.0\]"
    ):
        motion(table(), stop=3001.0)


def test_a_result_brings_the_table_back(tmp_path):
    whole = motion(table())
    again = pt.load(pt.save(whole, tmp_path / "air.nc"))
    assert np.array_equal(pt.propagate(again.system, again.initial, whole.times).quaternion, whole.quaternion)


@pytest.mark.parametrize(
    ("times", "densities", "sentence"),
    [
        ([0.0], [1.0], r"times must be two or more that rise, got others\."),
        ([0.0, 0.0], [1.0, 1.0], r"times must be two or more that rise, got others\."),
        ([0.0, 1.0], [1.0, 0.0], r"densities must be positive, got 0\.0\."),
        ([0.0, 1.0], [1.0], r"densities must have shape \(2,\), got shape \(1,\)\."),
    ],
)
def test_bad_tables_are_reported(times, densities, sentence):
    with pytest.raises(ValueError, match=sentence):
        TabulatedAtmosphere.from_table(times, densities)


def test_the_model_is_asked_where_and_when_the_body_is(monkeypatch):
    pytest.importorskip("astropy")
    import erfa
    from astropy import units
    from astropy.coordinates import EarthLocation

    asked = {}

    def calculate(dates, longitudes, latitudes, heights, f107s, f107as, aps):
        asked.update(dates=dates, places=(longitudes, latitudes, heights), indices=(f107s, f107as, aps))
        return np.exp(-np.asarray(heights) / 50)[:, None] * np.ones(11)

    monkeypatch.setitem(sys.modules, "pymsis", SimpleNamespace(calculate=calculate))
    calendar = pt.Calendar("2026-11-21T06:30:00", "UTC")
    air = TabulatedAtmosphere.from_msis(ORBIT, TIMES, f107=180.0, ap=7.0, calendar=calendar)
    turn = erfa.era00(2461365.5, (6.5 * 3600 + TIMES) / 86400)  # of UTC in the place of UT1
    x, y, z = np.array(np.broadcast_arrays(*ORBIT.position_at(TIMES)))
    fixed = (np.cos(turn) * x + np.sin(turn) * y, -np.sin(turn) * x + np.cos(turn) * y, z)
    place = EarthLocation.from_geocentric(*fixed, unit=units.m).to_geodetic("WGS84")
    longitudes, latitudes, heights = asked["places"]
    assert np.max(np.abs((longitudes - place.lon.deg + 180) % 360 - 180)) < 1e-7
    assert np.max(np.abs(latitudes - place.lat.deg)) < 1e-9
    assert np.max(np.abs(heights - place.height.to_value("km"))) < 1e-10
    assert asked["dates"][0] == np.datetime64("2026-11-21T06:30:00")
    assert asked["indices"][0][0] == 180.0
    assert asked["indices"][2].shape == (61, 7)
    assert np.allclose(air.rows.densities, np.exp(-heights / 50), rtol=1e-14, atol=0)
    assert np.allclose(air.omega_space, (0, 0, 7.2921159e-5), rtol=1e-9, atol=0)


def test_what_the_model_needs_is_reported(monkeypatch):
    with pytest.raises(ValueError, match="calendar must be given for an orbit without a calendar, got none"):
        TabulatedAtmosphere.from_msis(ORBIT, TIMES)
    pytest.importorskip("astropy")
    calendar = pt.Calendar("2026-11-21T06:30:00", "UTC")
    monkeypatch.setitem(sys.modules, "pymsis", None)
    with pytest.raises(ImportError, match=r"pymsis must be installed .* `pip install 'poinsot\[sky\]'`"):
        TabulatedAtmosphere.from_msis(ORBIT, TIMES, calendar=calendar)
    monkeypatch.setitem(sys.modules, "pymsis", SimpleNamespace())
    kilometres = pt.KeplerOrbit(398600.4418, semimajor_axis=6778.0, eccentricity=0.0)
    with pytest.raises(ValueError, match="orbit must be 0 to 2000 km above the Earth, in metres, got a height of -63"):
        TabulatedAtmosphere.from_msis(kilometres, TIMES, calendar=calendar)
