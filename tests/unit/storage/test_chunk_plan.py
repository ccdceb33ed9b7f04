"""Arguments of chunks: checks, the selection of variables and the number of members."""

import numpy as np
import pytest
import xarray

from poinsot.storage import chunk_plan
from poinsot.storage.chunk_plan import Plan, StoredVariable, plan_of, with_thinned_times
from poinsot.storage.zarr_group import Described

VARIABLES, STORED = ("quaternion", "energy"), ("quaternion",)


def test_without_arguments_there_is_no_plan():
    assert plan_of() is None
    assert plan_of(provenance={"title": "it"}) is None


def test_the_default_selection_is_stored_and_a_reduction_sees_all():
    assert [*Plan().selection(VARIABLES, STORED)] == ["quaternion"]
    assert [*Plan(reduce=lambda data: data).selection(VARIABLES, STORED)] == ["quaternion", "energy"]
    given = {"energy": StoredVariable("float32", 2)}
    assert Plan(variables=given).selection(VARIABLES, STORED) == given
    with pytest.raises(ValueError, match=r"^variables must be some of quaternion, energy, got 'mass'\.$"):
        Plan(variables={"mass": StoredVariable()}).selection(VARIABLES, STORED)


@pytest.mark.parametrize(("free", "members"), [(16_000, 1), (100_000, 4), (1_600_000, 100)])
def test_memory_limits_a_chunk_to_a_power_of_two(free, members, monkeypatch):
    monkeypatch.setattr(chunk_plan, "available_memory", lambda: free)
    assert Plan().members_of_chunk(100, 1000) == members
    assert Plan(chunk=3).members_of_chunk(100, 1000) == 3


def test_threads_of_workers():
    assert Plan().threads(None) is None
    assert Plan(client="a client").threads(None) == 1
    assert Plan(client="a client").threads(4) == 4


def test_selected_variables_are_thinned_and_converted():
    options, values = StoredVariable("float32", 2), np.arange(30.0).reshape(2, 5, 3)
    variable = Described(("member", "time", "axis"), (100, 5, 3), "float64", {"units": "s"})
    stored = Described(("member", "time_2", "axis"), (100, 3, 3), "float32", {"units": "s"})
    assert options.described(variable) == stored
    found = options.rows(variable, values)
    assert found.dtype == np.float32
    assert np.array_equal(found, values[:, ::2])


def test_whole_numbers_stay():
    options, number = StoredVariable("float32", 2), Described(("member",), (100,), "int64")
    assert options.described(number) == number
    assert options.rows(number, np.arange(2)).dtype == np.int64


def test_thinned_times_are_coordinates():
    times = xarray.Dataset(coords={"time": ("time", np.arange(5.0), {"units": "s"})})
    labelled = with_thinned_times(times, {"x": StoredVariable(every=2)})
    assert labelled["time_2"].values.tolist() == [0.0, 2.0, 4.0]
    assert labelled["time_2"].attrs == {"units": "s"}
