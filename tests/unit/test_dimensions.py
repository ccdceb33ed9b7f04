"""Arrays of xarray and pandas as arguments: their axes by the names of the dimensions."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import poinsot as pt
from poinsot.records.parameters import Vector

BODY = pt.Body((1.25, 1.0, 0.75))
MEMBERS = ("member", "axis")
RATES = np.arange(9.0).reshape(3, 3) / 10
AXES = ["1", "2", "3"]


def rates(given):
    return BODY.omega(BODY.state((1, 0, 0, 0), omega_body=given).angular_momentum_body)


LABELLED = {
    "in order": xr.DataArray(RATES, dims=MEMBERS),
    "transposed": xr.DataArray(RATES.T, dims=MEMBERS[::-1]),
    "members of another name": xr.DataArray(RATES.T, dims=("axis", "case")),
    "components of another name": xr.DataArray(RATES.T, dims=("component", "member")),
    "components in another order": xr.DataArray(RATES[:, ::-1], dims=MEMBERS, coords={"axis": AXES[::-1]}),
    "components with labels of the user": xr.DataArray(RATES, dims=MEMBERS, coords={"axis": ["z", "y", "x"]}),
    "variable": xr.Variable(("axis", "member"), RATES.T),
    "table": pd.DataFrame(RATES, columns=["c", "b", "a"]),
    "transposed table": xr.DataArray(RATES.T, dims=MEMBERS[::-1], coords={"axis": AXES}).to_pandas(),
    "rows": [xr.DataArray(row, dims="axis") for row in RATES],
}


@pytest.mark.parametrize("name", LABELLED)
def test_axes_are_those_of_the_names(name):
    np.testing.assert_allclose(rates(LABELLED[name]), RATES, rtol=0, atol=2e-16)  # two roundings of numbers below 1


def test_a_transposed_dataset_gives_the_same_motion():
    data = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=RATES), [0.0, 1.0]).dataset
    end, turned = data.isel(time=1), data.isel(time=1).transpose()
    states = [pt.State(each["quaternion"], each["conjugate_momenta"]) for each in (end, turned)]
    assert np.array_equal(states[0].quaternion, states[1].quaternion)
    assert np.array_equal(states[0].conjugate_momenta, states[1].conjugate_momenta)
    along = data["angular_momentum_body"]
    assert np.array_equal(BODY.omega(along.transpose("axis", "time", "member")), BODY.omega(along.values))


class Anything(pt.Torque):
    size: float
    direction: Vector

    def torque(self, instant):  # noqa: ARG002
        return self.direction


def test_parameters_of_forces_go_by_name_too():
    force = Anything(xr.DataArray([1.0, 2.0, 3.0], dims="member"), xr.DataArray(RATES.T, dims=MEMBERS[::-1]))
    assert np.array_equal(force.direction, RATES)


ORDER = "must have dimensions whose names determine their order, such as member, time and axis, got"
REFUSED = {
    "two unknown names": (
        lambda: rates(xr.DataArray(RATES, dims=("a", "b"))),
        f"omega_body {ORDER} ('a', 'b'). Rename them, or pass np.asarray(omega_body).",
    ),
    "members for components": (
        lambda: rates(xr.DataArray(RATES[0], dims="member")),
        "omega_body must have 1 dimension of components, got an array with the dimensions ('member',).",
    ),
    "components for members": (
        lambda: pt.forces.LinearDamping(xr.DataArray(RATES[0], dims="axis")),
        "coefficient must have no dimensions of components, got an array with the dimensions ('axis',).",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_names_that_determine_no_order_are_refused(name):
    call, message = REFUSED[name]
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        call()


def test_times_of_a_dataset_are_times():
    times = xr.DataArray([0.0, 1.0], dims="time")
    state = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    assert pt.propagate(pt.System(BODY), state, times).times.tolist() == [0.0, 1.0]
