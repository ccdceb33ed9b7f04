"""Rows of a motion in memory and in stores."""

import pickle

import numpy as np
import pytest

import poinsot as pt
from poinsot.propagation.column_reader import LazyColumns, MotionRows
from poinsot.propagation.event_record import NO_EVENTS

TIMES = np.linspace(0.0, 2.0, 5)
BODY = pt.Body((1.25, 1.0, 0.75))
RATES = np.array([(0.1, 0.2, 3.0), (0.3, 0.1, 2.0), (0.2, 0.2, 1.0)])


def counted(calls, name, values):
    def read():
        calls.append(name)
        return values

    return read


def test_lazy_columns_are_read_once_and_on_access():
    calls: list[str] = []
    columns = LazyColumns({name: counted(calls, name, np.arange(3.0)) for name in ("a", "b")})
    assert "a" in columns
    assert "c" not in columns
    assert [*columns] == ["a", "b"]
    assert len(columns) == 2
    assert not calls
    assert columns["a"] is columns["a"]
    assert calls == ["a"]
    back = pickle.loads(pickle.dumps(columns))
    assert np.array_equal(back["b"], np.arange(3.0))
    assert calls == ["a", "b"]


def test_rows_are_computed_on_first_access_and_travel_as_arrays():
    calls: list[str] = []
    rows = MotionRows(counted(calls, "phase", {"quaternion": np.ones((2, 4))}))
    assert not calls
    assert rows.phase is rows.phase
    assert calls == ["phase"]
    assert not rows.phase["quaternion"].flags.writeable
    back = pickle.loads(pickle.dumps(rows))
    assert np.array_equal(back.phase["quaternion"], np.ones((2, 4)))
    assert back.events.records == NO_EVENTS.records == ()


@pytest.mark.parametrize(("members", "at"), [(1, slice(None)), (np.array([0, 2]), np.array([1, 3]))])
def test_selected_rows_are_those_of_the_members_and_times(members, at):
    phase = {"quaternion": np.random.default_rng(1).normal(size=(3, 5, 4))}
    calls: list[str] = []
    columns = LazyColumns({"power": counted(calls, "power", np.arange(15.0).reshape(3, 5))})
    found = MotionRows(phase, columns).isel(members, at)
    expected = phase["quaternion"][members]
    expected = expected[at] if isinstance(members, int) else expected[:, at]
    assert np.array_equal(found.phase["quaternion"], expected)
    assert not calls
    assert found.columns["power"].shape == expected.shape[:-1]


def test_state_variables_are_recorded_columns():
    phase = {"quaternion": np.ones((5, 4)), "wheel": np.zeros((5, 2))}
    assert [*MotionRows(phase, {"power": np.ones(5)}).recorded] == ["quaternion", "own_wheel", "power"]
    pair = {"primary_quaternion": np.ones((5, 4)), "orbit": np.arange(30.0).reshape(5, 6)}
    columns = MotionRows(pair).recorded
    assert [*columns] == ["primary_quaternion", "position", "momentum"]
    assert np.array_equal(columns["momentum"], pair["orbit"][:, 3:])


def test_a_store_reads_the_rows_that_are_asked_for(tmp_path):
    start = BODY.state(np.eye(4)[:3], omega_body=RATES)
    motion = pt.propagate(pt.System(BODY), start, TIMES, progress=False)
    stored = pt.propagate(pt.System(BODY), start, TIMES, out=tmp_path / "it.zarr", chunk=2, progress=False)
    rows = stored._rows
    assert rows.store is not None
    assert not isinstance(rows.phase["quaternion"], np.ndarray)
    assert rows.absent(2) == ""
    assert rows.summary == {}
    assert np.array_equal(rows.in_memory().phase["quaternion"], motion.quaternion)
    back = pickle.loads(pickle.dumps(stored))
    assert back.store is not None
    assert np.array_equal(back.member(1).quaternion, motion.quaternion[1])
