"""SPICE kernels: one written from an analytic orbit with SPICE's own writer comes back."""

import sys

import numpy as np
import pytest
import spiceypy as spice

import poinsot as pt

ORBIT = pt.KeplerOrbit(
    398600.4418, semimajor_axis=9000.0, eccentricity=0.1, inclination=1.0, node=0.3, argument_of_periapsis=0.2
)
BEGIN = 86400.0 * 3
DAY = 86400.0
PROBE = -999


@pytest.fixture(scope="module")
def kernel(tmp_path_factory):
    """Hermite polynomials through states two minutes apart (type 13), of the probe from the Earth."""
    path = tmp_path_factory.mktemp("spk") / "probe.bsp"
    times = np.arange(BEGIN - 3600, BEGIN + DAY + 3601, 120.0)
    rows = np.stack([*ORBIT.position_at(times - BEGIN), *ORBIT.velocity_at(times - BEGIN)], axis=-1)
    handle = spice.spkopn(str(path), "probe", 0)
    spice.spkw13(
        handle, PROBE, 399, "J2000", times[0], times[-1], "kepler", 11, len(times), np.ascontiguousarray(rows), times
    )
    spice.spkcls(handle)
    return path


@pytest.fixture
def constants(tmp_path):
    path = tmp_path / "gm.tpc"
    path.write_text("KPL/PCK\n\\begindata\nBODY399_GM = ( 398600.5 )\n\\begintext\n")
    return path


@pytest.fixture(autouse=True)
def nothing_stays_loaded():
    yield
    assert spice.ktotal("ALL") == 0


def place(orbit, times):
    return np.stack(orbit.position_at(np.atleast_1d(times)), axis=-1)


def test_written_orbit_comes_back(kernel):
    orbit = pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + DAY, [kernel])
    times = np.linspace(0, DAY, 4001)
    errors = place(orbit, BEGIN + times) - np.stack(ORBIT.position_at(times), axis=-1)
    assert np.max(np.linalg.norm(errors, axis=-1)) < 4e-8
    speeds = np.stack(orbit.velocity_at(BEGIN + times), axis=-1) - np.stack(ORBIT.velocity_at(times), axis=-1)
    assert np.max(np.linalg.norm(speeds, axis=-1)) < 3e-8
    assert orbit.span == (BEGIN, BEGIN + DAY)
    assert (orbit.reference_frame, orbit.origin) == ("ICRF", "EARTH")
    assert orbit.calendar == pt.Calendar("2000-01-01T12:00:00", "TDB")
    assert orbit.mu == pytest.approx(398600.435507, rel=1e-11, abs=0)


def test_dates_and_another_calendar(kernel):
    calendar = pt.Calendar("2000-01-04T11:58:55.816", "UTC")  # 3 days after J2000 in TDB, to some microseconds
    orbit = pt.files.spice_orbit(PROBE, 399, 60.0, "2000-01-04T13:00:00 UTC", [kernel], calendar=calendar)
    date = "2000-01-04T12:30:00 TDB"
    passed = pt.Calendar("2000-01-04T12:00:00", "TDB").time(date)
    expected = np.stack(ORBIT.position_at(passed), axis=-1)
    np.testing.assert_allclose(place(orbit, calendar.time(date))[0], expected, rtol=0, atol=2e-9)


def test_axes_of_the_ecliptic(kernel):
    orbit = pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 6000, [kernel], frame="ECLIPJ2000")
    x, y, z = ORBIT.position_at(3000.0)
    tilt = np.radians(84381.448 / 3600)
    expected = (x, np.cos(tilt) * y + np.sin(tilt) * z, -np.sin(tilt) * y + np.cos(tilt) * z)
    np.testing.assert_allclose(place(orbit, BEGIN + 3000)[0], expected, rtol=0, atol=1e-10)
    assert orbit.reference_frame == "ECLIPJ2000"


def test_other_way_round(kernel):
    orbit = pt.files.spice_orbit("EARTH", PROBE, BEGIN, BEGIN + 6000, [kernel], mu=1e-9)
    np.testing.assert_allclose(place(orbit, BEGIN)[0], -np.stack(ORBIT.position_at(0.0), axis=-1), rtol=0, atol=1e-11)
    assert orbit.mu == 1e-9


def test_mu_of_the_kernels_and_of_the_argument(kernel, constants):
    assert pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 600, [kernel, constants]).mu == 398600.5
    assert pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 600, [str(kernel), constants], mu=2.0).mu == 2.0


def test_kernels_of_the_user_stay_loaded(kernel, constants):
    spice.furnsh(str(constants))
    try:
        pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 600, [kernel])
        assert spice.ktotal("ALL") == 1
    finally:
        spice.kclear()


@pytest.mark.parametrize(
    ("arguments", "options", "sentence"),
    [
        (
            (PROBE, "EARTH", BEGIN, BEGIN + 9 * DAY),
            {},
            r"kernels must cover -999 from 'EARTH' .* SPICE\(SPKINSUFFDATA\)",
        ),
        ((-998, "EARTH", BEGIN, BEGIN + 1), {}, "kernels must cover -998 from 'EARTH' at all times from start to stop"),
        (("NOBODY", "EARTH", BEGIN, BEGIN + 1), {}, "target must be a body that SPICE knows, got 'NOBODY'"),
        ((PROBE, "", BEGIN, BEGIN + 1), {}, "center must be a body that SPICE knows, got ''"),
        ((PROBE, None, BEGIN, BEGIN + 1), {}, "center must be a text or a whole number"),
        ((399, "EARTH", BEGIN, BEGIN + 1), {}, "target and center must be two bodies, got 399"),
        ((PROBE, "EARTH", BEGIN, BEGIN + 1), {"frame": "XYZ"}, "frame must be a frame that SPICE defines, got 'XYZ'"),
        ((PROBE, "EARTH", BEGIN, BEGIN + 1), {"frame": None}, "frame must be a text, got NoneType"),
        ((PROBE, "EARTH", BEGIN, BEGIN + 1), {"frame": "IAU_EARTH"}, "frame must be a frame that does not rotate"),
        (("EARTH", PROBE, BEGIN, BEGIN + 1), {}, "mu must be given for an attractor that is not the Sun"),
        ((PROBE, "EARTH", BEGIN, BEGIN), {}, "stop must be later than start"),
    ],
)
def test_bad_input(kernel, arguments, options, sentence):
    with pytest.raises((TypeError, ValueError), match=f"^{sentence}"):
        pt.files.spice_orbit(*arguments, [kernel], **options)


def test_missing_package_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "spiceypy", None)
    with pytest.raises(ImportError, match=r"^spiceypy must be installed for SPICE kernels, got none. `pip install"):
        pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 1, [])


def test_bad_kernels(kernel, tmp_path):
    with pytest.raises(FileNotFoundError, match=r"^No such file: .*none\.bsp$"):
        pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 1, [kernel, tmp_path / "none.bsp"])
    with pytest.raises(TypeError, match=r"^kernels must be a list, each a path, got str"):
        pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 1, str(kernel))
    (tmp_path / "torn.bsp").write_bytes(kernel.read_bytes()[:1500])
    with pytest.raises(ValueError, match=r"got SPICE\("):
        pt.files.spice_orbit(PROBE, "EARTH", BEGIN, BEGIN + 1, [tmp_path / "torn.bsp"])
