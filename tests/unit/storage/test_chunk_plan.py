"""Arguments of chunks: checks, the selection of variables and the number of members."""

import numpy as np
import pytest
import xarray

from poinsot.storage import chunk_plan
from poinsot.storage.chunk_plan import Plan, StoredVariable, plan_of, selected, with_thinned_times
from poinsot.storage.ensemble import Ensemble

ENSEMBLE = Ensemble(
    members=100,
    last=1.0,
    problem={},
    names=("quaternion", "energy"),
    stored=("quaternion",),
    member_bytes=1000,
    fixed=xarray.Dataset(),
    template=lambda _: xarray.Dataset(),
    compute=None,
    open=None,
)
DATA = xarray.Dataset(
    {"x": (("member", "time"), np.arange(10.0).reshape(2, 5)), "number": (("member",), [1, 2])},
    coords={"time": ("time", np.arange(5.0), {"units": "s"})},
)


def test_without_arguments_there_is_no_plan():
    assert plan_of() is None
    assert plan_of(provenance={"title": "it"}) is None


def test_the_default_selection_is_stored_and_a_reduction_sees_all():
    assert [*Plan().selection(ENSEMBLE)] == ["quaternion"]
    assert [*Plan(reduce=lambda data: data).selection(ENSEMBLE)] == ["quaternion", "energy"]
    given = {"energy": StoredVariable("float32", 2)}
    assert Plan(variables=given).selection(ENSEMBLE) == given
    with pytest.raises(ValueError, match=r"^variables must be some of quaternion, energy, got 'mass'\.$"):
        Plan(variables={"mass": StoredVariable()}).selection(ENSEMBLE)


@pytest.mark.parametrize(("free", "members"), [(16_000, 1), (100_000, 4), (1_600_000, 100)])
def test_memory_limits_a_chunk_to_a_power_of_two(free, members, monkeypatch):
    monkeypatch.setattr(chunk_plan, "available_memory", lambda: free)
    assert Plan().members_of_chunk(ENSEMBLE) == members
    assert Plan(chunk=3).members_of_chunk(ENSEMBLE) == 3


def test_threads_of_workers():
    assert Plan().threads(None) is None
    assert Plan(client="a client").threads(None) == 1
    assert Plan(client="a client").threads(4) == 4


def test_selected_variables_are_thinned_and_converted():
    selection = {"x": StoredVariable("float32", 2), "number": StoredVariable("float32")}
    found = selected(DATA, selection)
    assert found["x"].dims == ("member", "time_2")
    assert found["x"].dtype == np.float32
    assert found["number"].dtype == DATA["number"].dtype  # whole numbers stay
    assert np.array_equal(found["x"], DATA["x"][:, ::2])
    labelled = with_thinned_times(DATA, selection)
    assert labelled["time_2"].values.tolist() == [0.0, 2.0, 4.0]
    assert labelled["time_2"].attrs == {"units": "s"}
