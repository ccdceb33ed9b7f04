"""Tests of observables as output variables of motions, ensembles, stores and files."""

import pickle
import tracemalloc
from typing import Any

import numpy as np
import pytest

import poinsot as pt

BODY = pt.Body((1.25, 1.0, 0.75))
SYSTEM = pt.System(BODY, units={"time": "s", "inertia": "kg km2"})
START = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.3, 2))
STATES = BODY.state((1, 0, 0, 0), omega_body=np.random.default_rng(3).normal(size=(7, 3)))
TIMES = np.linspace(0.0, 3.0, 7)


class Rate(pt.Observable):
    bias: pt.BodyVector = (0, 0, 0)
    components = ("x", "y", "z")
    frame = "body"

    def reading(self, instant):
        return instant.omega_body + self.bias

    def unit(self, units):
        return units.rate


class Sight(pt.Observable):
    orbit: pt.Orbit
    gain: float = 1.0
    delayed: bool = False

    def reading(self, instant):
        return self.gain * instant.attitude.to_body(instant.direction(self.orbit))[0]

    @property
    def light_path(self):
        return self.orbit if self.delayed else None


class Upwards(Sight):
    def validity(self, instant):
        return {"below the horizon": pt.functions.less(self.reading(instant), 0.0)}


class Limit(pt.Event):
    """Event that stops members with a large second component of the angular velocity."""

    terminal: bool = True

    def value(self, instant):
        return instant.omega_body[1] - 0.2


ORBIT = pt.orbits.FixedPosition(1.0, position=(3e5, 2e5, 1e5))
OBSERVABLES = [Rate((0.1, 0, 0)), Sight(ORBIT), Sight(ORBIT, 2.0, delayed=True)]
NAMES = ("rate", "sight", "sight_2")


def expected(motion):
    return dict(zip(NAMES, (each.values for each in pt.observe(motion, *OBSERVABLES)), strict=True))


@pytest.mark.parametrize("start", [START, STATES], ids=["one body", "members"])
@pytest.mark.parametrize("dense", [False, True])
def test_readings_are_columns(start, dense):
    if dense and start is STATES:
        pytest.skip("ensembles have no dense output")
    motion = pt.propagate(SYSTEM, start, TIMES, observables=OBSERVABLES, dense=dense)
    plain = pt.propagate(SYSTEM, start, TIMES)
    assert tuple(motion.observables) == NAMES
    assert motion.variable_names[-3:] == NAMES
    for name, values in expected(plain).items():
        assert np.array_equal(motion.column(name), values)
    assert np.array_equal(motion.quaternion, plain.quaternion)
    data = motion.dataset
    assert data["rate"].dims[-2:] == ("time", "component_rate")
    assert [*data.component_rate.values] == ["x", "y", "z"]
    assert data["rate"].attrs == {"units": "rad s-1", "long_name": "readings of rate", "frame": "body"}


def test_selections_keep_readings():
    motion = pt.propagate(SYSTEM, STATES, TIMES, observables=OBSERVABLES)
    for some, index in ((motion[2:5], np.s_[2:5]), (motion.isel(time=[1, 4]), np.s_[:, [1, 4]])):
        assert np.array_equal(some.column("rate"), motion.column("rate")[index])
        assert np.array_equal(some.column("sight_2"), motion.column("sight_2")[index])
    assert np.array_equal(motion.member(3).column("sight"), motion.column("sight")[3])
    again = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(again.column("sight_2"), motion.column("sight_2"))
    assert tuple(again.observables) == NAMES


def test_observables_of_members():
    gains = np.linspace(1, 2, 7)
    many = [Rate(np.linspace(0, 1, 21).reshape(7, 3)), Sight(ORBIT, gains, delayed=True)]
    motion = pt.propagate(SYSTEM, STATES, TIMES, observables=many)
    for name, read in zip(("rate", "sight"), pt.observe(motion, *many), strict=True):
        assert np.array_equal(motion.column(name), read.values)
    one = motion.member(2).observables["sight"]
    assert isinstance(one, Sight)
    assert one.gain == gains[2]
    with pytest.raises(ValueError, match="observables must have the same numbers for one body, got members"):
        pt.propagate(SYSTEM, START, TIMES, observables=many)


@pytest.mark.parametrize("chunk", [3, 7])
def test_a_store_of_readings_alone(tmp_path, chunk):
    stored: Any = pt.propagate(
        SYSTEM,
        STATES,
        TIMES,
        observables=OBSERVABLES,
        out=tmp_path / "s.zarr",
        chunk=chunk,
        variables=["sight", "rate"],
    )
    whole = expected(pt.propagate(SYSTEM, STATES, TIMES))
    assert {str(name) for name in stored.data_vars if "time" in stored[name].dims} == {"sight", "rate"}
    assert np.array_equal(stored["sight"].values, whole["sight"])
    assert np.array_equal(stored["rate"].values, whole["rate"])
    assert stored["rate"].attrs["units"] == "rad s-1"
    again = pt.load(tmp_path / "s.zarr")
    assert np.array_equal(again["sight"].values, whole["sight"])


def test_a_store_of_motions_with_readings(tmp_path):
    options = {"observables": OBSERVABLES, "out": tmp_path / "m.zarr", "chunk": 3}
    stored = pt.propagate(SYSTEM, STATES, TIMES, **options)
    whole = expected(pt.propagate(SYSTEM, STATES, TIMES))
    for motion in (stored, pt.load(tmp_path / "m.zarr"), pt.propagate(SYSTEM, STATES, TIMES, **options)):
        for name in NAMES:
            assert np.array_equal(motion.column(name), whole[name])
            assert np.array_equal(motion[2:4].column(name), whole[name][2:4])
    assert repr(pt.load(tmp_path / "m.zarr").observables["rate"]) == repr(OBSERVABLES[0])
    with pytest.raises(ValueError, match="observables"):
        pt.propagate(SYSTEM, STATES, TIMES, **{**options, "observables": [Rate((0.2, 0, 0)), *OBSERVABLES[1:]]})


def test_a_store_continues(tmp_path):
    """A store without its second chunk computes this chunk again, with equal bits."""
    options = {"observables": OBSERVABLES, "out": tmp_path / "m.zarr", "chunk": 3, "variables": ["sight_2"]}
    first = pt.propagate(SYSTEM, STATES, TIMES, **options)["sight_2"].values.copy()
    (tmp_path / "m.zarr" / "sight_2" / "c.1.0").unlink()
    again = pt.propagate(SYSTEM, STATES, TIMES, **options)["sight_2"].values
    assert np.array_equal(first, again)


def test_reductions():
    reduced = pt.propagate(
        SYSTEM,
        STATES,
        TIMES,
        observables=OBSERVABLES,
        chunk=3,
        variables=["sight"],
        reduce=lambda data: data["sight"].max("time").to_dataset(name="largest"),
    )
    assert np.array_equal(reduced["largest"].values, expected(pt.propagate(SYSTEM, STATES, TIMES))["sight"].max(axis=1))


@pytest.mark.parametrize("start", [START, STATES], ids=["one body", "members"])
@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_files(tmp_path, start, suffix):
    motion = pt.propagate(SYSTEM, start, TIMES, observables=OBSERVABLES)
    loaded = pt.load(pt.save(motion, tmp_path / f"m{suffix}"))
    for name in NAMES:
        assert np.array_equal(loaded.column(name), motion.column(name))
    assert loaded.dataset["rate"].attrs == motion.dataset["rate"].attrs
    assert repr(loaded.observables["sight"]) == repr(OBSERVABLES[1])
    again = pt.load(pt.save(loaded, tmp_path / f"again{suffix}"))
    assert np.array_equal(again.column("rate"), motion.column("rate"))
    with pytest.raises(TypeError, match=r"Sight.* must have a formula to be read, got none from its file"):
        pt.observe(motion, loaded.observables["sight"])


def test_a_changed_file_is_refused(tmp_path):
    import xarray

    motion = pt.propagate(SYSTEM, START, TIMES, observables=OBSERVABLES)
    with xarray.open_dataset(pt.save(motion, tmp_path / "m.nc"), decode_times=False) as data:
        changed = data.load().copy(deep=True)
    changed["sight"].values[2] += 1e-9
    assert pt.load(changed).column("sight")[2] != motion.column("sight")[2]
    changed.attrs["observables"] = "{}}"
    with pytest.raises(ValueError, match="must have observables by name"):
        pt.load(changed)


def test_members_that_stop(tmp_path):
    motion = pt.propagate(SYSTEM, STATES, TIMES, events=[Limit()], observables=OBSERVABLES)
    stopped = np.isnan(motion.quaternion[..., 0])
    assert stopped.any()
    assert not stopped.all()
    for name in ("rate", "sight"):
        assert np.array_equal(np.isnan(motion.column(name).reshape(7, 7, -1)[..., 0]), stopped)
    stored = pt.propagate(
        SYSTEM, STATES, TIMES, events=[Limit()], observables=OBSERVABLES, out=tmp_path / "m.zarr", chunk=2
    )
    for name in NAMES:
        assert np.array_equal(stored.column(name), motion.column(name), equal_nan=True)


def test_absent_readings_warn():
    with pytest.warns(UserWarning, match=r"Upwards .* below the horizon"):
        motion = pt.propagate(SYSTEM, START, TIMES, observables=[Upwards(ORBIT)])
    assert np.isnan(motion.column("upwards")).any()


def test_two_bodies():
    bodies = pt.TwoBodies(*(pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8)) for _ in range(2)), 1.0)
    state = bodies.state((40, 0, 0), (0, 0.3, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)])
    system = pt.System(bodies, pt.forces.MutualGravity())
    both = [Rate().on("secondary"), Rate().on("primary")]
    motion = pt.propagate(system, state, TIMES, observables=both)
    assert tuple(motion.observables) == ("secondary_rate", "primary_rate")
    assert np.array_equal(motion.column("secondary_rate"), motion.secondary.omega_body)


class Late(Rate):
    """Angular velocity 0.3 units of time before the reading."""

    def time_of_body(self, time, units):  # noqa: ARG002
        return time - 0.3


def test_noise_of_sampled_laws_stays_that_of_the_member(tmp_path):
    sensors = pt.control.NoisySensors(rate_noise=1e-2, seed=7.0)
    law = pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=0.1, sensors=sensors)
    system = pt.System(pt.Body((10, 12, 8)), law)
    start = system.state((1, 0, 0, 0), omega_body=np.random.default_rng(0).normal(size=(5, 3)))
    times = np.linspace(0.5, 2.5, 5)
    motion = pt.propagate(system, start, times, observables=[Late()])
    expected = pt.propagate(system, start, times - 0.3).omega_body
    stored = pt.propagate(system, start, times, observables=[Late()], out=tmp_path / "m.zarr", chunk=2)
    assert np.array_equal(motion.column("late"), expected)
    assert np.array_equal(stored.column("late"), expected)
    assert np.array_equal(pt.observe(motion.member(3), Late()).values, expected[3])


@pytest.mark.parametrize("options", [{"formulation": "canonical"}, {"precision": "quadruple"}, {"tolerance": 1e-10}])
def test_another_propagation_has_the_options_of_the_motion(options):
    motion = pt.propagate(SYSTEM, START, TIMES, **options)
    expected = pt.propagate(SYSTEM, START, [0.3, 0.9], **options).omega_body
    assert np.array_equal(pt.observe(motion, Rate(), times=[0.3, 0.9]).values, expected)


@pytest.mark.parametrize("start", [START, STATES], ids=["one body", "members"])
def test_motions_in_closed_form_between_their_times(start):
    motion = pt.free_motion(BODY, start, TIMES)
    expected = pt.propagate(SYSTEM, start, [0.3, 0.9]).omega_body
    assert np.allclose(pt.observe(motion, Rate(), times=[0.3, 0.9]).values, expected, rtol=0, atol=1e-13)


def test_descending_times():
    forwards, backwards = (pt.propagate(SYSTEM, STATES, t, observables=[Late()]) for t in (TIMES, TIMES[::-1]))
    assert np.allclose(backwards.column("late")[:, ::-1], forwards.column("late"), rtol=0, atol=1e-14)


def test_wrong_observables():
    with pytest.raises(TypeError, match="observables"):
        pt.propagate(SYSTEM, START, TIMES, observables=[3.0])
    with pytest.raises(ValueError, match=r"variables must be some of .* sight_2, got 'sigt'"):
        pt.propagate(SYSTEM, STATES, TIMES, observables=OBSERVABLES, chunk=3, out="never.zarr", variables=["sigt"])


def test_a_store_of_readings_holds_no_motions(tmp_path):
    """The largest memory of a run that stores readings alone does not grow with the number of members."""
    peaks = []
    times = np.linspace(0.0, 1.0, 101)
    for members in (64, 512):
        states = BODY.state((1, 0, 0, 0), omega_body=np.random.default_rng(3).normal(size=(members, 3)))
        tracemalloc.start()
        pt.propagate(
            SYSTEM,
            states,
            times,
            observables=[Sight(ORBIT)],
            out=tmp_path / f"{members}.zarr",
            chunk=16,
            variables=["sight"],
            threads=1,
        )
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    motion_bytes = 512 * 101 * 7 * 8
    assert peaks[1] - peaks[0] < motion_bytes / 4


@pytest.mark.parametrize("name", ["OmegaBody", "DriftEnergy", "Time", "Moments", "InitialTime"])
def test_an_observable_must_not_have_the_name_of_another_variable(name):
    kind = type(name, (pt.Observable,), {"reading": lambda _, instant: instant.time})
    with pytest.raises(ValueError, match=r"observables must have other names than the variables of a motion, got '"):
        pt.propagate(SYSTEM, START, TIMES, observables=[kind()])


def test_a_store_has_one_warning_of_absent_readings(tmp_path):
    class Late(pt.Observable):
        def reading(self, instant):
            return instant.time

        def validity(self, instant):
            return {"late": pt.functions.less(0.0, instant.time)}

    (count,) = STATES.shape
    late = count * np.sum(TIMES > 0)
    message = f"some of {count * len(TIMES)} times: late at {late}"
    with pytest.warns(UserWarning, match=message) as seen:
        pt.propagate(SYSTEM, STATES, TIMES, observables=[Late()], out=tmp_path / "a.zarr", chunk=1)
    assert len(seen) == 1
