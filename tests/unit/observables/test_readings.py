"""Tests of readings: shapes, standard deviations, noise by seed, datasets."""

import pickle

import numpy as np
import pytest

import poinsot as pt
from poinsot.observables import Readings

TIMES = np.linspace(0.0, 1.0, 5)


class Speed(pt.Observable):
    noise: float = 0.1

    def reading(self, instant):
        return pt.functions.norm(instant.omega_body)


class Rate(pt.Observable):
    noise: pt.BodyVector = (0.1, 0.2, 0.3)
    components = ("x", "y", "z")
    frame = "body"

    def reading(self, instant):
        return instant.omega_body

    def unit(self, units):
        return units.rate


class Silent(pt.Observable):
    def reading(self, instant):
        return instant.time


def test_a_plan_has_the_noise_of_its_observable():
    plan = Readings(Speed(), TIMES)
    assert plan.values is None
    assert plan.sigma == 0.1
    assert np.array_equal(Readings(Rate(), TIMES).sigma, [0.1, 0.2, 0.3])
    assert Readings(Silent(), TIMES).sigma is None
    assert "a plan of measurements" in repr(plan)
    assert len(plan) == 5


@pytest.mark.parametrize(
    ("observable", "values"),
    [
        (Speed(), np.zeros(4)),
        (Speed(), np.zeros((5, 3))),
        (Rate(), np.zeros(5)),
        (Rate(), np.zeros((3, 5))),
        (Rate(), np.zeros((2, 2, 5, 3))),
    ],
)
def test_values_have_the_shape_of_the_times(observable, values):
    with pytest.raises(ValueError, match=r"values must have shape \(5.*\) or \('members', 5.*got shape"):
        Readings(observable, TIMES, values)


@pytest.mark.parametrize("sigma", [0.0, -1.0, [0.1, 0.2, 0.0, 0.1, 0.1]])
def test_sigma_is_positive(sigma):
    with pytest.raises(
        ValueError, match=r"sigma must be positive, got -?\d.* Give the standard deviation of a reading"
    ):
        Readings(Speed(), TIMES, np.zeros(5), sigma)


def test_sigma_broadcasts_against_times_components_and_members():
    assert Readings(Rate(), TIMES, sigma=np.full(5, 0.3)).sigma.shape == (5, 1)
    assert Readings(Rate(), TIMES, sigma=np.full((5, 3), 0.3)).sigma.shape == (5, 3)
    assert Readings(Speed(), TIMES, np.zeros((2, 5)), np.full((2, 1), 0.3)).sigma.shape == (2, 1)
    for sigma in (np.ones(4), np.ones((2, 5)), np.ones((5, 3))):
        with pytest.raises(ValueError, match=r"sigma must have shape \(\) or \(5,\), got shape"):
            Readings(Speed(), TIMES, np.zeros(5), sigma)


@pytest.mark.parametrize("times", [3.0, [], [[0.0, 1.0]]])
def test_times_have_one_axis(times):
    with pytest.raises(ValueError, match=r"times must have shape \(n,\), n > 0, got shape"):
        Readings(Speed(), times)


def test_dates_need_a_calendar():
    with pytest.raises(ValueError, match=r"times must be numbers without a calendar, got dates\. Give calendar="):
        Readings(Speed(), ["2000-01-02T00:00:00 TDB"])
    calendar = pt.Calendar("2000-01-01T00:00:00", "TDB", "d")
    dated = Readings(Speed(), ["2000-01-02T12:00:00 TDB"], calendar=calendar)
    assert np.array_equal(dated.times, [1.5])
    assert dated.dataset.time.attrs["epoch"] == "2000-01-01T00:00:00"
    assert dated.dataset.time.attrs["units"] == "d"


def test_an_observable_is_an_instance():
    with pytest.raises(TypeError, match="observable must be an Observable, got"):
        Readings(3.0, TIMES)


def test_noise_depends_on_seed_member_and_time_alone():
    rate = Readings(Rate(), TIMES, np.zeros((5, 3)))
    noisy = rate.simulated(7).values
    assert np.array_equal(noisy, rate.simulated(7).values)
    assert not np.any(noisy == rate.simulated(8).values)
    several = Readings(Rate(), TIMES[:3], np.zeros((2, 3, 3))).simulated(7).values
    assert np.array_equal(several[0], noisy[:3])
    assert not np.any(several[0] == several[1])
    doubled = Readings(Rate(), TIMES, np.zeros((5, 3)), 1.0).simulated(7).values
    assert np.allclose(noisy, doubled * [0.1, 0.2, 0.3], rtol=1e-15, atol=0)


def test_noise_has_its_standard_deviation():
    times = np.arange(20_000.0)
    values = Readings(Speed(), times, np.ones(times.size), 0.5).simulated(0).values - 1
    assert abs(values.mean()) < 4 * 0.5 / np.sqrt(times.size)
    assert abs(values.std() / 0.5 - 1) < 4 / np.sqrt(2 * times.size)


def test_noise_needs_values_and_a_standard_deviation():
    with pytest.raises(ValueError, match=r"readings must have values to be simulated, got a plan"):
        Readings(Speed(), TIMES).simulated(1)
    with pytest.raises(ValueError, match=r"sigma must be positive, got none\. Give the standard deviation"):
        Readings(Silent(), TIMES, TIMES).simulated(1)
    with pytest.raises(ValueError, match=r"seed must be a whole number from 0 to 2\^52, got -1"):
        Readings(Speed(), TIMES, TIMES).simulated(-1)


def test_another_observable_reads_the_same_data():
    read = Readings(Speed(0.1), TIMES, TIMES, name="a", attributes={"units": "rad s-1"})
    second = Speed(0.2)
    other = read.of(second)
    assert other.observable is second
    assert np.array_equal(other.values, read.values)
    assert (other.name, other.attributes) == (read.name, read.attributes)


def test_parts_of_readings():
    values = np.arange(30.0).reshape(2, 5, 3)
    read = Readings(Rate(), TIMES, values, np.arange(1.0, 6.0))
    some = read.isel(time=[1, 3], member=1)
    assert np.array_equal(some.times, TIMES[[1, 3]])
    assert np.array_equal(some.values, values[1, [1, 3]])
    assert np.array_equal(some.sigma, np.broadcast_to([[2.0], [4.0]], (2, 3)))
    assert np.array_equal(read.isel(member=[0]).values, values[:1])
    assert read.isel(time=2).values.shape == (2, 1, 3)
    with pytest.raises(ValueError, match=r"readings must be of an ensemble to have members, but they are of one body"):
        some.isel(member=0)


def test_the_dataset_names_axes_units_and_frame():
    attributes = {"units": "rad s-1", "frame": "body", "time_units": "s", "version_poinsot": "0"}
    data = Readings(Rate(), TIMES, np.ones((2, 5, 3)), attributes=attributes).dataset
    assert data["values"].dims == ("member", "time", "component")
    assert data["sigma"].dims == ("member", "time", "component")
    assert data["values"].attrs == {"units": "rad s-1", "frame": "body"}
    assert [*data.component.values] == ["x", "y", "z"]
    assert data.time.attrs["units"] == "s"
    assert data.attrs["version_poinsot"] == "0"
    assert data.attrs["observable"] == "Rate(noise=[0.1, 0.2, 0.3])"


def test_readings_are_frozen_and_can_be_pickled():
    read = Readings(Speed(), TIMES, TIMES)
    with pytest.raises(AttributeError, match=r"Readings\.values must stay as it was made"):
        read.values = TIMES
    with pytest.raises(ValueError, match="read-only"):
        read.values[0] = 1.0
    again = pickle.loads(pickle.dumps(read))
    assert np.array_equal(again.values, read.values)
    assert repr(again) == repr(read)


def test_a_notebook_shows_a_plot():
    assert "<svg" in Readings(Speed(), TIMES, TIMES)._repr_html_()
    assert "<svg" not in Readings(Speed(), TIMES)._repr_html_()


def test_readings_of_some_members_have_the_observable_of_these_members():
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=[(0.1, 0, 1), (0, 0.2, 1), (0.3, 0, 1)])
    motion = pt.propagate(pt.System(body), start, TIMES)
    biases = np.arange(9.0).reshape(3, 3)
    read = pt.observe(motion, pt.observables.Gyro(bias=biases, noise=0.1))
    one, two = read.isel(member=1), read.isel(member=[2, 0])
    assert np.array_equal(vars(one.observable)["bias"], biases[1])
    assert np.array_equal(vars(two.observable)["bias"], biases[[2, 0]])
    assert np.array_equal(pt.observe(motion.isel(member=1), one).values, read.values[1])
    plan = Readings(pt.observables.Gyro(bias=biases, noise=0.1), TIMES)
    assert not plan.isel(member=2).is_ensemble


def test_values_are_finite_or_absent():
    with pytest.raises(ValueError, match=r"values must be finite, or NaN .* got inf of Speed at t = 0\.25\."):
        Readings(Speed(), TIMES, [np.nan, np.inf, 1.0, 2.0, 3.0])
    values = np.ones((2, 5, 3))
    values[1, 4, 2] = -np.inf
    with pytest.raises(ValueError, match=r"values must be finite, .* got -inf of Rate at t = 1\."):
        Readings(Rate(), TIMES, values)
