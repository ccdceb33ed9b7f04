"""Readings in NetCDF files."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.files import netcdf
from poinsot.observables.readings import Readings
from poinsot.scenarios import system_text

DAYS = pt.Calendar("2012-10-10T00:00:00", "TDB", "d")


class Beacon(pt.Observable):
    components = ("x", "y")
    position: pt.BodyVector
    station: pt.Orbit

    def reading(self, instant):
        place = instant.position(self.station) + instant.attitude.to_space(self.position)
        return place[:2]


class Rate(pt.Observable):
    noise: float = 0.0

    def reading(self, instant):
        return instant.omega_body[0]


BEACON = Beacon((0, 0, 1), pt.orbits.FixedPosition(1.0, position=(3, 0, 0)))


@given(
    members=st.sampled_from([(), (1,), (3,)]),
    n=st.integers(1, 4),
    sigma=st.sampled_from(["none", "one", "times", "components", "all"]),
    dated=st.booleans(),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=25, deadline=None)
def test_readings_come_back_bit_for_bit(tmp_path_factory, members, n, sigma, dated, seed):
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(*members, n, 2))
    values[..., 0, 0] = np.nan
    shape = {"none": None, "one": (), "times": (n,), "components": (2,), "all": values.shape}[sigma]
    errors = None if shape is None else rng.uniform(1e-3, 1, shape)
    about = {"calendar": DAYS if dated else None, "attributes": {"units": "km", "title": "a ° b"}}
    made = Readings(BEACON, np.sort(rng.normal(size=n)), values, errors, name="beacon 1", **about)
    plan = Readings(Rate(), rng.normal(size=n), name="plan", **about)
    path = tmp_path_factory.mktemp("nc") / "a.readings.nc"
    back = pt.files.read_readings(pt.files.write_readings([made, plan], path))
    for one, other in zip((made, plan), back, strict=True):
        for name in ("times", "values", "sigma"):
            first, second = getattr(one, name), getattr(other, name)
            assert (first is None) == (second is None)
            assert first is None or np.array_equal(first, second, equal_nan=True)
        assert (one.name, one.calendar, one.attributes) == (other.name, other.calendar, other.attributes)
        assert repr(one.observable) == repr(other.observable)
        assert one.observable.components == other.observable.components


def test_an_observable_of_a_user_has_no_formula(tmp_path):
    path = pt.files.write_readings(Readings(Rate(), [0.0], [1.0]), tmp_path / "a.nc")
    (back,) = pt.files.read_readings(path)
    body = pt.Body((1, 2, 3))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])
    with pytest.raises(TypeError, match=r"must have a formula to be read, got none from its file: the classes of a"):
        pt.observe(motion, back.observable)


def test_an_observable_of_the_package_is_made_again(tmp_path, monkeypatch):
    monkeypatch.setattr(system_text, "_is_outside", lambda _: False)
    path = pt.files.write_readings(
        [Readings(BEACON, [0.0], name="a"), Readings(Beacon((1, 1 / 3, 0), BEACON.station), [0.0], name="b")],
        tmp_path / "a.nc",
    )
    one, two = (each.observable for each in pt.files.read_readings(path))
    assert type(one) is type(two) is Beacon
    assert two.position.tolist() == [1, 1 / 3, 0]
    assert one.station is two.station


def test_a_motion_and_readings_are_not_confused(tmp_path):
    path = pt.files.write_readings(Readings(Rate(), [0.0], [1.0]), tmp_path / "a.nc")
    with pytest.raises(netcdf.ReadingsFoundError, match=r"a\.nc must have a motion, got readings\. Use pt\.files"):
        pt.load(path)
    body = pt.Body((1, 2, 3))
    motion = pt.free_motion(body, body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])
    with pytest.raises(
        ValueError, match=r"b\.nc must have readings, got another file\. A motion is read by pt\.load\.$"
    ):
        pt.files.read_readings(pt.save(motion, tmp_path / "b.nc"))


def test_what_is_not_written(tmp_path):
    one = Readings(Rate(), [0.0], [1.0])
    with pytest.raises(ValueError, match=r"^readings must have different names, got 'Rate' twice\. Give name="):
        pt.files.write_readings([one, one], tmp_path / "a.nc")
    with pytest.raises(ValueError, match=r"^readings must not be empty, got none\.$"):
        pt.files.write_readings([], tmp_path / "a.nc")
    with pytest.raises(ValueError, match=r"^path must end in \.nc, got 'a\.csv'\.$"):
        pt.files.write_readings(one, tmp_path / "a.csv")
    path = pt.files.write_readings(one, tmp_path / "a.nc")
    with pytest.raises(FileExistsError):
        pt.files.write_readings(one, path)


@pytest.mark.parametrize("text", ["{", "[1]", "[]", '[{"name": "a"}]'])
def test_damaged_descriptions_end_in_one_sentence(tmp_path, text):
    path = pt.files.write_readings(Readings(Rate(), [0.0], [1.0]), tmp_path / "a.nc")
    data = netcdf.read_dataset(path).assign_attrs(readings=text)
    netcdf.write_dataset(data, tmp_path / "b.nc", overwrite=False)
    if text == "[]":
        assert pt.files.read_readings(tmp_path / "b.nc") == ()
        return
    with pytest.raises(ValueError, match=r"b\.nc must describe its readings, got"):
        pt.files.read_readings(tmp_path / "b.nc")
