"""Ensembles in chunks: the same numbers bit for bit, whatever the chunks, stored or reduced."""

import contextlib
import copy
import errno
import json
import pickle
import shutil
import threading
from typing import Any

import numpy as np
import pytest
import xarray

import poinsot as pt
from poinsot.propagation import stored_motion
from poinsot.storage import chunk_plan, chunk_run, zarr_group
from poinsot.storage.ensemble_store import EnsembleStore

BODY = pt.Body((1.25, 1.0, 0.75))
TIMES = np.linspace(0, 5, 11)
RNG = np.random.default_rng(19)
COUNT = 23
STARTS = BODY.state(np.broadcast_to((1.0, 0, 0, 0), (COUNT, 4)), omega_body=RNG.normal(size=(COUNT, 3)))
KEPLER = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.1)
BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
PAIR = pt.TwoBodies(BALL, pt.Body((0.3, 0.4, 0.5), mass=0.5), G=1.0)


class Push(pt.Torque):
    """A force from outside the package, with a number of each member."""

    size: float

    def torque(self, instant):
        return self.size * pt.functions.Vector((1.0, 0.0, instant.time * 0.1))


def run(system, states=STARTS, **options):
    return pt.propagate(system, states, TIMES, progress=False, **options)


def pairs():
    return PAIR.state(
        np.add((3.0, 0, 0), RNG.normal(size=(COUNT, 3)) / 10),
        (0, 0.6, 0),
        [(1, 0, 0, 0)] * 2,
        omega_body=[(0, 0, 1), (0.1, 0, 0.5)],
    )


NINTH = np.arange(COUNT) == 9
SYMMETRIC = np.where(NINTH[:, None], BODY.moments, (1.25, 1.25, 0.75))
CIRCLES = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.1 * NINTH)
SYSTEMS: dict[str, tuple[pt.System, dict[str, Any]]] = {
    "free": (pt.System(BODY), {}),
    "a top": (pt.System(BODY, pt.UniformGravity(0.5, (1, 0, 0)), units={"time": "s"}), {"tolerance": 1e-12}),
    # what is zero for all members of most chunks: kernels that leave it out would round in another way
    "zero for most": (pt.System(pt.Body(SYMMETRIC), pt.GravityGradient(CIRCLES)), {}),
    "bodies of members": (pt.System(pt.Body(np.add(BODY.moments, RNG.uniform(0, 0.2, (COUNT, 1))))), {}),
    "in orbit": (pt.System(BODY, pt.GravityGradient(KEPLER)), {"formulation": "canonical"}),
    "from outside": (pt.System(BODY, Push(RNG.uniform(0.1, 0.2, COUNT))), {}),
    "two bodies": (pt.System(PAIR, pt.forces.MutualGravity()), {"states": pairs()}),
    "with events": (pt.System(BODY), {"events": [pt.events.SpinFlip((0, 1, 0))]}),
}


def assert_same_rows(one, other):
    assert list(one.phase) == list(other.phase)
    for name, values in one.phase.items():
        assert np.asarray(values).tobytes() == np.asarray(other.phase[name]).tobytes(), name


def assert_same_events(one, other):
    for found, expected in zip(one.events, other.events, strict=True):
        assert repr(found) == repr(expected)
        assert np.array_equal(found.times, expected.times)
        assert np.array_equal(found.members, expected.members)
        assert np.array_equal(found.directions, expected.directions)
        assert_same_rows(found.states, expected.states)
        if "quaternion" in found.states.phase:
            assert np.array_equal(found.omega_body, expected.omega_body)


@pytest.mark.parametrize("name", SYSTEMS)
def test_members_do_not_depend_on_chunks(name, tmp_path):
    system, options = SYSTEMS[name]
    whole = run(system, **options)
    for chunk, threads in ((1, 1), (5, 2), (COUNT, 1)):
        stored = run(system, **options, threads=threads, out=tmp_path / f"{chunk}.zarr", chunk=chunk)
        assert type(stored) is type(whole)
        assert_same_rows(stored, whole)
        read = pt.load(tmp_path / f"{chunk}.zarr")
        assert_same_rows(read, whole)
        assert read.summary.items() >= {"steps": stored.run.steps, "kernel": whole.run.kernel}.items()
        assert "times: 11" in str(read)
        assert_same_events(stored, whole)
        assert_same_events(read, whole)
        assert_same_events(read.member(9), whole.member(9))
    assert len(whole.events) == (name == "with events")


def test_members_in_euler_angles_do_not_depend_on_chunks(tmp_path):
    """Each member rescales its momenta, which the damping makes small, alone."""
    rates = np.random.default_rng(3).normal(size=(300, 3)) * np.linspace(4, 1, 300)[:, None]
    damped = pt.System(BODY, pt.forces.LinearDamping(0.3))
    given = damped, BODY.state((0.8, 0.2, 0.4, 0.4), omega_body=rates), [10.0, 20.0]
    own: dict[str, Any] = {"formulation": "euler_angles", "progress": False}
    whole = pt.propagate(*given, **own)
    for chunk in (37, 128):
        assert_same_rows(pt.propagate(*given, **own, out=tmp_path / f"{chunk}.zarr", chunk=chunk, threads=1), whole)


@pytest.mark.parametrize("name", ["a top", "bodies of members", "in orbit", "from outside", "two bodies"])
def test_members_and_slices_are_those_of_the_whole(name, tmp_path):
    system, options = SYSTEMS[name]
    whole, stored = run(system, **options), run(system, **options, out=tmp_path / "it.zarr", chunk=4)
    for motion in (stored, pt.load(tmp_path / "it.zarr")):
        for chosen in ({"member": 6}, {"member": slice(3, 15, 4)}, {"member": [7, 2], "time": slice(2, 5)}):
            one, other = motion.isel(**chosen), whole.isel(**chosen)
            assert_same_rows(one, other)
            assert np.array_equal(one.energy, other.energy)
        assert_same_rows(motion.isel(time=3), whole.isel(time=3))
        assert np.array_equal(np.asarray(motion.energy), whole.energy)


def test_a_member_that_fails_is_in_the_store(tmp_path):
    falling = BODY.state((0.5**0.5, 0.5**0.5, 0, 0), omega_body=[(-1, 0, 0), (0, 0, 1), (-1, 0.1, 0)])
    system, own = pt.System(BODY), {"formulation": "euler_angles"}
    whole = run(system, falling, **own)
    assert list(whole.failures) == [0]
    stored = run(system, falling, **own, out=tmp_path / "it.zarr", chunk=1)
    assert stored.failures == whole.failures == pt.load(tmp_path / "it.zarr").failures
    assert np.array_equal(stored.reached, whole.reached)
    assert stored.member(0).times.size == whole.member(0).times.size < TIMES.size


def test_variables_are_chosen(tmp_path):
    system, whole = pt.System(BODY), run(pt.System(BODY))
    selected = {"quaternion": {"dtype": "float32"}, "omega_body": {"every": np.int64(5)}}
    data = run(system, out=tmp_path / "some.zarr", chunk=4, variables=selected)
    loaded = pt.load(tmp_path / "some.zarr")
    for found in (
        data,
        loaded,
        pickle.loads(pickle.dumps(loaded)),
        copy.deepcopy(data),
        xarray.open_zarr(tmp_path / "some.zarr"),
    ):
        assert found["quaternion"].dtype == np.float32
        assert np.array_equal(found["quaternion"], whole.quaternion.astype(np.float32))
        assert np.array_equal(found["omega_body"], whole.omega_body[:, ::5])
        assert np.array_equal(found["time_5"], TIMES[::5])
    named = ["quaternion", "angular_momentum_body", "kinetic_energy"]
    motion = run(system, out=tmp_path / "more.zarr", variables=named)
    assert np.array_equal(motion.dataset["kinetic_energy"], whole.kinetic_energy)
    every = {name: {"every": 2} for name in named[:2]}
    sparse = run(system, out=tmp_path / "sparse.zarr", variables=every)
    assert_same_rows(sparse, whole.isel(time=slice(None, None, 2)))
    assert np.array_equal(pt.load(tmp_path / "sparse.zarr").times, TIMES[::2])


SPARSE = {
    "states": {"quaternion": {"every": 4}, "angular_momentum_body": {"every": 4}},
    "and rates as often": {name: {"every": 4} for name in ("quaternion", "angular_momentum_body", "omega_body")},
    "and rates more often": {
        "quaternion": {"every": 4},
        "angular_momentum_body": {"every": 4},
        "omega_body": {"every": 2},
        "kinetic_energy": {},
    },
}


@pytest.mark.parametrize("name", SPARSE)
def test_what_is_stored_at_some_times_is_saved_and_loaded(name, tmp_path):
    whole = run(pt.System(BODY)).isel(time=slice(None, None, 4))
    sparse = run(pt.System(BODY), out=tmp_path / "it.zarr", chunk=10, variables=SPARSE[name])
    if "kinetic_energy" not in SPARSE[name]:
        assert np.array_equal(sparse.dataset["time"], TIMES[::4])
    for ending in (".nc", ".zarr"):
        read = pt.load(pt.save(sparse, tmp_path / f"copy{ending}"))
        assert np.array_equal(read.times, TIMES[::4])
        assert_same_rows(read, whole)


@pytest.mark.parametrize("name", ["with events", "two bodies", "from outside", "a wheel"])
@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_a_motion_in_a_store_is_saved_with_all_that_it_has(name, ending, tmp_path):
    wheeled = pt.System(BODY, pt.parts.ReactionWheel((0, 0, 1), 0.1, torque=0.01))
    with_wheels = {"states": wheeled.state((1, 0, 0, 0), omega_body=RNG.normal(size=(COUNT, 3)))}
    system, options = SYSTEMS.get(name, (wheeled, with_wheels))
    events = [pt.events.PairApsis() if name == "two bodies" else pt.events.SpinFlip((0, 1, 0))]
    options = {"events": events, **options}
    whole, stored = run(system, **options), run(system, **options, out=tmp_path / "it.zarr", chunk=10)
    for motion in (whole, stored, pt.load(tmp_path / "it.zarr")):
        read = pt.load(pt.save(motion, tmp_path / f"copy{ending}", overwrite=True))
        assert_same_rows(read, whole)
        assert_same_events(read, whole)
        assert_same_events(read[3:20:5].member(2), whole.member(13))
        assert np.array_equal(read.energy, whole.energy)
        assert len(read.events[0]) > COUNT / 4


def test_a_copy_of_a_store_has_nothing_from_outside_it(tmp_path):
    (tmp_path / "outside").write_text("of somebody else")
    motion = run(pt.System(BODY), out=tmp_path / "it.zarr", chunk=10)
    (tmp_path / "it.zarr" / "chunks" / "000000" / "link").symlink_to(tmp_path / "outside")
    pt.save(motion, tmp_path / "copy.zarr")
    assert (tmp_path / "copy.zarr" / "chunks" / "000000" / "link").is_symlink()


def test_a_store_that_is_not_whole_is_copied_and_goes_on(tmp_path):
    system, options = SYSTEMS["with events"]
    whole, out, copy = run(system, **options), tmp_path / "it.zarr", tmp_path / "copy.zarr"
    run(system, **options, out=out, chunk=5)
    shutil.rmtree(out / "chunks" / "000001")
    part = pt.load(out)
    assert part.member(7).failures == {0: "the store does not have this member yet"}
    assert [*part[4:9:3].failures] == [1]
    assert part.member(3).failures == {}
    with pytest.raises(ValueError, match=r"^motion must be whole to be saved as \.nc, got 18 of 23 members\. "):
        pt.save(part, tmp_path / "copy.nc")
    read = pt.load(pt.save(part, copy))
    assert read.store.whole.tolist() == part.store.whole.tolist() == [True, False, True, True, True]
    assert len(read.events[0]) == len(part.events[0]) < len(whole.events[0])
    assert_same_rows(run(system, **options, out=copy), whole)
    assert_same_events(pt.load(copy), whole)


def test_events_are_read_when_they_are_asked_for(tmp_path, monkeypatch):
    system, options = SYSTEMS["with events"]
    run(system, **options, out=tmp_path / "it.zarr", chunk=5)
    read, content = [], zarr_group.StoredArray._content

    def noted(array, number, place, size):
        read.append(array._folder.parent.name)
        return content(array, number, place, size)

    monkeypatch.setattr(zarr_group.StoredArray, "_content", noted)
    motion = pt.load(tmp_path / "it.zarr")
    assert f"SpinFlip {len(run(system, **options).events[0])}" in str(motion)
    one = motion.member(12)
    assert not [place for place in read if place.isdecimal()]
    assert len(one.events) == 1
    assert {place for place in read if place.isdecimal()} == {"000002"}


def largest(data):
    return data[["omega_body"]].max("time")


def spread(data):
    return xarray.Dataset({"energy": data["kinetic_energy"].mean(), "members": data.sizes["member"]})


@pytest.mark.parametrize("stored", [False, True])
def test_reductions_are_those_of_the_result(stored, tmp_path):
    system, whole = pt.System(BODY), run(pt.System(BODY))
    out = {"out": tmp_path / "it.zarr"} if stored else {}
    found = run(system, chunk=5, reduce=largest, **out)
    assert np.array_equal(found["omega_body"], whole.omega_body.max(axis=1))
    assert np.array_equal(found["member"], np.arange(COUNT))
    out = {"out": tmp_path / "other.zarr"} if stored else {}
    found = run(system, chunk=5, reduce=spread, **out)
    assert found["members"].values.tolist() == [5, 5, 5, 5, 3]
    assert np.array_equal(found["energy"], [whole.kinetic_energy[i : i + 5].mean() for i in range(0, COUNT, 5)])
    if stored:
        assert found.identical(pt.load(tmp_path / "other.zarr"))


def labelled(data):
    """Labels of every kind: texts, numbers along a dimension and along members, and none."""
    fast = data.kinetic_energy.max("time").values > 1
    return data[["omega_body"]].assign_coords(axis=["x", "y", "z"], fast=("member", fast), now=3.0).max("time")


REDUCTIONS = {
    "at a time": lambda data: data[["quaternion"]].sel(time=0.5),
    "when it is largest": lambda data: data.kinetic_energy.idxmax("time").rename("when"),
    "integral": lambda data: data.kinetic_energy.integrate("time"),
    "quantiles": lambda data: data.kinetic_energy.quantile([0.1, 0.9], dim="member"),
    "mean of members": lambda data: data[["quaternion"]].mean("member"),
    "some members": lambda data: data[["quaternion"]].where(data.member > 10, drop=True),
    "one member": lambda data: data[["quaternion"]].isel(member=0),
    "labels": labelled,
    "two dimensions as one": lambda data: data[["quaternion"]].stack(both=("time", "parameter")),
    "attributes": lambda data: data.kinetic_energy.max("time").assign_attrs(bins=[1, 2], first=np.float32(0.5)),
}


@pytest.mark.parametrize("name", REDUCTIONS)
def test_a_reduction_is_the_same_in_memory_and_in_a_store(name, tmp_path):
    asked = {"chunk": 9, "reduce": REDUCTIONS[name]}
    system = pt.System(BODY, units={"time": "s", "inertia": "kg m2"})
    found, stored = run(system, **asked), run(system, **asked, out=tmp_path / "it.zarr")
    assert found.identical(stored)
    assert found.identical(pt.load(tmp_path / "it.zarr"))


def test_reductions_know_times_and_units():
    system = pt.System(BODY, units={"time": "s", "inertia": "kg m2"})
    whole = run(system)
    for every in (1, 2):
        seen = {"kinetic_energy": {"every": every}}
        dim = f"time_{every}" if every > 1 else "time"
        found = run(system, chunk=9, variables=seen, reduce=lambda data: data[["kinetic_energy"]].mean("member"))
        assert np.array_equal(found[dim], TIMES[::every])
        assert found.kinetic_energy.attrs["units"] == whole.dataset.kinetic_energy.attrs["units"]
    found = run(system, chunk=9, reduce=lambda data: data.kinetic_energy.integrate("time"))
    np.testing.assert_allclose(found.kinetic_energy, np.trapezoid(whole.kinetic_energy, TIMES), rtol=1e-14)  # 11 sums


@pytest.mark.parametrize("stored", [False, True])
def test_what_chunks_do_not_share_lies_along_chunks(stored, tmp_path):
    def reduce(data):
        counts, edges = np.histogram(data.kinetic_energy, 4)
        largest = {"largest": data.kinetic_energy.max("time"), "mean": data.kinetic_energy.mean()}
        return xarray.Dataset({**largest, "counts": ("edge", counts)}, coords={"edge": edges[:-1], "side": [1, 2]})

    out = {"out": tmp_path / "run.zarr"} if stored else {}
    found, energy = run(pt.System(BODY), chunk=10, reduce=reduce, **out), run(pt.System(BODY)).kinetic_energy
    parts = energy[:10], energy[10:20], energy[20:]
    assert np.array_equal(found.largest, energy.max(1))
    assert found.side.dims == ("side",)
    for number, part in enumerate(parts):
        counts, edges = np.histogram(part, 4)
        assert found["mean"].values[number] == pytest.approx(part.mean(), rel=1e-14, abs=0)  # sums of 110 numbers
        assert np.array_equal(found.counts[number], counts)
        assert np.array_equal(found.edge[number], edges[:-1])


def in_words(data, names):
    """A reduction may name dimensions, members, and coordinates along them in words."""
    last = data[["omega_body"]].isel(time=-1, drop=True)
    words = [f"m{int(member)}" for member in data.member]
    named = {
        "member": words,
        "axis": ["x", "y", "z"],
        "label": ("member", words[::-1]),
        "numbered": ("axis", ["07", "8", "9"]),
    }
    extra = {
        "height": ("member", np.sqrt(data.member.values)),
        "of": "all",
        "place": (("member", "axis"), [["a", "b", ""]] * len(words)),
    }
    return last.assign_coords({name: value for name, value in (named | extra).items() if name in names})


NAMED = [(), ("axis",), ("member", "label"), ("numbered", "of"), ("label", "place", "height", "axis")]


@pytest.mark.parametrize("names", NAMED, ids=lambda names: " ".join(names) or "none")
def test_coordinates_in_words_are_stored(names, tmp_path):
    def reduce(data):
        return in_words(data, names)

    whole = run(pt.System(BODY), chunk=10, reduce=reduce)
    stored = run(pt.System(BODY), chunk=10, reduce=reduce, out=tmp_path / "it.zarr")
    loaded: Any = pt.load(tmp_path / "it.zarr")
    assert {*whole.coords} == {"member", "axis", *names}
    assert stored.identical(whole)
    assert loaded.identical(whole)
    with xarray.open_zarr(tmp_path / "it.zarr" / "chunks" / "000001") as others:
        assert {*others.coords} == {*whole.coords}
        assert np.array_equal(others["omega_body"], whole["omega_body"][10:20])


@pytest.mark.parametrize("stored", [False, True])
@pytest.mark.parametrize(
    "reduce",
    [
        lambda data: data[["kinetic_energy"]].isel(time=slice(0, 1 + int(data.member[0]))),
        lambda data: xarray.Dataset({f"chunk_{int(data.member[0])}": 1.0}),
        lambda data: xarray.Dataset(dict.fromkeys("ab"[: 1 + (data.member[0].item() > 0)], 1.0)),
    ],
)
def test_reductions_that_do_not_go_together_are_refused_at_the_second(stored, reduce, tmp_path):
    seen = []

    def counted(data):
        seen.append(data)
        return reduce(data)

    out = {"out": tmp_path / "run.zarr"} if stored else {}
    with pytest.raises(ValueError, match=r"^reduce must return the same variables and dimensions for each chunk, got"):
        run(pt.System(BODY), chunk=5, reduce=counted, **out)
    assert len(seen) == 2


def test_strangers_read_a_store_without_warnings(tmp_path):
    whole = run(pt.System(BODY))
    run(pt.System(BODY), out=tmp_path / "it.zarr", chunk=4)
    with xarray.open_zarr(tmp_path / "it.zarr") as data:
        assert np.array_equal(data["quaternion"], whole.quaternion)
        assert data["quaternion"].attrs["units"] == "1"
        assert data["quaternion"].chunks[0][0] == 4


WRONG = {
    "chunk alone": ({"chunk": 5}, "chunk, variables and client must come with out= or reduce=, got neither."),
    "no store": ({"out": "it.nc"}, "out must be the name of a store that ends in .zarr, got 'it.nc'."),
    "a number": ({"out": 5}, "out must be a path"),
    "no members": ({"out": "it.zarr", "chunk": 0}, "chunk must be a positive whole number of members, got 0."),
    "half a member": ({"out": "it.zarr", "chunk": 1.5}, "chunk must be a whole number of at most 63 bits"),
    "no function": ({"reduce": "mean"}, "reduce must be a function of one value"),
    "one name": ({"out": "it.zarr", "variables": "quaternion"}, "variables must be a list, each a text"),
    "another name": ({"out": "it.zarr", "variables": ["spin"]}, "variables must be some of quaternion, conj"),
    "another kind": (
        {"out": "it.zarr", "variables": {"quaternion": {"dtype": "int8"}}},
        "dtype must be 'float64' or 'float32', got 'int8'.",
    ),
    "another word": (
        {"out": "it.zarr", "variables": {"quaternion": {"kind": "int8"}}},
        "variables['quaternion'] must be a mapping with dtype, every or neither, got {'kind': 'int8'}. An empty one",
    ),
    "nothing": (
        {"out": "it.zarr", "variables": {"quaternion": None}},
        "variables['quaternion'] must be a mapping with dtype, every or neither, got None. An empty one, {}, keeps",
    ),
    "no times": ({"out": "it.zarr", "variables": {"quaternion": {"every": 0}}}, "every must be a positive whole"),
    "no variables": ({"out": "it.zarr", "variables": []}, "variables must name at least one, got none."),
    "half a time": ({"out": "it.zarr", "variables": {"quaternion": {"every": 2.0}}}, "every must be a positive whole"),
    "an object": (
        {"reduce": lambda data: data.kinetic_energy.max("time").assign_attrs(of=object())},
        "attributes must be texts, numbers, and lists of these, got others: ",
    ),
    "large numbers": (
        {"reduce": lambda _: xarray.Dataset({"it": np.uint64(2**63)}), "out": "it.zarr"},
        "whole numbers of a store must be less than 2**63, got it up to 9223372036854775808.",
    ),
    "a misprint": ({"output": "it.zarr"}, "propagate() got an unexpected keyword argument 'output'"),
    "no dataset": ({"reduce": lambda _: 5}, "reduce must return a dataset, got int."),
    "texts": (
        {"reduce": lambda data: data[["quaternion"]].isel(time=0).assign(name="x"), "out": "it.zarr"},
        "variables of a store must be real numbers with names, got 'name'",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments_are_one_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, sentence = WRONG[name]
    with pytest.raises((ValueError, TypeError)) as refused:
        run(pt.System(BODY), **given)
    assert str(refused.value).startswith(sentence)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("out", [{}, {"out": "it.zarr"}])
def test_an_error_of_a_reduction_says_which_members(out, tmp_path, monkeypatch):
    def reduce(data):
        if 7 in data.member:
            raise FileNotFoundError("no table")
        return data[["kinetic_energy"]].max("time")

    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileNotFoundError, match="no table") as refused:
        run(pt.System(BODY), chunk=5, reduce=reduce, **out)
    assert refused.value.__notes__ == ["reduce was given the members 5 to 9."]


def test_one_body_has_no_chunks():
    with pytest.raises(ValueError, match="out, chunk, reduce and client must be given for an ensemble, got one body"):
        run(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), out="it.zarr")


def test_a_chunk_larger_than_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(chunk_plan, "available_memory", lambda: 100_000)
    with pytest.raises(ValueError, match=r"chunk must fit into the memory that .* 0.0001 GB, got 23 members, which"):
        run(pt.System(BODY), out=tmp_path / "it.zarr", chunk=COUNT)
    monkeypatch.setattr(chunk_plan, "available_memory", lambda: 1000)
    with pytest.raises(ValueError, match=r"got 1 members, which take .* GB. Give fewer times."):
        run(pt.System(BODY), out=tmp_path / "it.zarr")


def test_memory_chooses_the_chunk(tmp_path, monkeypatch):
    monkeypatch.setattr(chunk_plan, "available_memory", lambda: 16 * 5000)
    motion = run(pt.System(BODY), out=tmp_path / "it.zarr")  # 11 rows of 7 + 7 numbers, 1232 bytes a member
    assert motion.store.chunk == 4
    assert "it.zarr, 6 of 6 chunks of 4 members" in str(motion)


PATIENCE = 30.0
"""Seconds in which another thread must have come to a place."""

MEMBERS = 1
"""Place of the members among the arguments of what integrates a chunk."""


def test_a_chunk_is_written_while_the_next_one_is_computed_and_no_more_than_one_waits(tmp_path, monkeypatch):
    begun, written = [threading.Event() for _ in range(5)], []
    write, computed = EnsembleStore.write, stored_motion._integrated

    def slow(store, number, *others):
        assert number == 4 or begun[number + 1].wait(PATIENCE), "the next chunk waits for this one"
        write(store, number, *others)
        written.append(number)

    def noted(*given):
        number = given[MEMBERS].start // 5
        assert written[: number - 1] == [*range(number - 1)], "more than one chunk waits"
        begun[number].set()
        return computed(*given)

    monkeypatch.setattr(EnsembleStore, "write", slow)
    monkeypatch.setattr(stored_motion, "_integrated", noted)
    motion = run(pt.System(BODY), out=tmp_path / "it.zarr", chunk=5)
    assert written == [0, 1, 2, 3, 4]
    assert_same_rows(motion, run(pt.System(BODY)))


def test_a_reduction_reads_the_integrals_of_all_members():
    """The ninth body is not symmetric, unlike the first one, which conserves one momentum more."""
    found = run(pt.System(pt.Body(SYMMETRIC)), chunk=5, threads=1, reduce=lambda data: data.max("time"))
    assert "integral_energy" in found
    assert not [name for name in found if str(name).startswith("integral_angular_momentum_body")]


def test_a_reduction_receives_the_run_and_the_failures_of_its_chunk():
    falling = BODY.state((0.5**0.5, 0.5**0.5, 0, 0), omega_body=[(0, 0, 1), (-1, 0, 0)])
    given, system = [], pt.System(BODY)

    def noted(data):
        given.append(data.attrs)
        return data[["kinetic_energy"]]

    run(system, falling, formulation="euler_angles", chunk=1, threads=1, variables=["kinetic_energy"], reduce=noted)
    assert ["failures" in attributes for attributes in given] == [False, True]
    assert "1" in json.loads(given[1]["failures"])
    assert all(attributes["steps"] > 0 and attributes["order"] > 0 for attributes in given)
    assert given[0]["system"] == repr(system)


@pytest.mark.parametrize("fails", range(5))
def test_what_the_writer_raises_ends_the_call_and_leaves_whole_chunks(fails, tmp_path, monkeypatch):
    write, out = EnsembleStore.write, tmp_path / "it.zarr"

    def full(store, number, *others):
        if number == fails:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(store, number, *others)

    with monkeypatch.context() as patch:
        patch.setattr(EnsembleStore, "write", full)
        with pytest.raises(OSError, match=rf"No space left on device. {fails} of 5 chunks are whole; the same call"):
            run(pt.System(BODY), out=out, chunk=5)
    assert EnsembleStore(out).whole.tolist() == [number < fails for number in range(5)]
    assert not list(out.rglob("*.part"))
    assert_same_rows(run(pt.System(BODY), out=out, chunk=5), run(pt.System(BODY)))


def test_an_interrupt_lets_the_chunk_that_is_written_end(tmp_path, monkeypatch):
    write, computed, out = EnsembleStore.write, stored_motion._integrated, tmp_path / "it.zarr"
    interrupted = threading.Event()

    def slow(store, number, *others):
        assert number != 1 or interrupted.wait(PATIENCE)
        write(store, number, *others)

    def stopped(*given):
        if given[MEMBERS].start == 10:
            interrupted.set()
            raise KeyboardInterrupt
        return computed(*given)

    with monkeypatch.context() as patch:
        patch.setattr(EnsembleStore, "write", slow)
        patch.setattr(stored_motion, "_integrated", stopped)
        with pytest.raises(
            pt.PropagationInterrupted, match=r"10 of 23 members are done. The same call continues the run."
        ):
            run(pt.System(BODY), out=out, chunk=5)
    assert EnsembleStore(out).whole.tolist() == [True, True, False, False, False]
    assert not (out / "lock").exists()
    assert_same_rows(run(pt.System(BODY), out=out, chunk=5), run(pt.System(BODY)))


def test_progress_is_over_all_chunks(tmp_path, monkeypatch):
    reported = []

    @contextlib.contextmanager
    def bar(what, total, wanted):
        assert (what, total, wanted) == ("members", COUNT, True)
        yield lambda more: reported.append(more)

    monkeypatch.setattr(chunk_run, "bar", bar)
    pt.propagate(pt.System(BODY), STARTS, TIMES, progress=True, out=tmp_path / "it.zarr", chunk=5)
    assert sum(reported) == COUNT
    shutil.rmtree(tmp_path / "it.zarr" / "chunks" / "000002")
    reported.clear()
    pt.propagate(pt.System(BODY), STARTS, TIMES, progress=True, out=tmp_path / "it.zarr", chunk=5)
    assert reported[0] == COUNT - 5
    assert sum(reported) == COUNT


def test_a_scenario_gives_datasets_where_it_keeps_no_motion(tmp_path):
    path = tmp_path / "tops.toml"
    path.write_text(
        "body.moments = [1.25, 1.0, 0.75]\n[state]\nquaternion = [1, 0, 0, 0]\nomega_body = [0.1, 0.2, 3]\n"
        "[times]\nstart = 0\nstop = 2\ncount = 3\n[ensemble]\nmembers = 5\nseed = 1\n"
        '[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'
    )
    scenario = pt.files.read_scenario(path)
    whole = scenario.propagate(progress=False)
    selected = scenario.propagate(progress=False, out=tmp_path / "stored.zarr", variables=["omega_body"])
    assert np.array_equal(selected.omega_body, whole.omega_body)
    means: Any = scenario.propagate(progress=False, chunk=2, reduce=lambda data: data.omega_body.mean("member"))
    assert means.sizes["chunk"] == 3
