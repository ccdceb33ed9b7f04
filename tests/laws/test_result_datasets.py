"""Every result of an ensemble is a dataset: members first, with units and meanings."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import poinsot as pt

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0.2, 0)), units={"time": "s", "inertia": "kg m2"})
FREE = pt.System(BODY, units={"time": "s", "inertia": "kg m2"})
ONE = BODY.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
RATES = [(0.1, 1.0, 0.2), (0.2, 1.0, 0.1), (0.3, 0.9, 0.1)]
THREE = BODY.state((1, 0, 0, 0), omega_body=RATES)
TIMES = np.array([1.0, 2.0])
RESULTS: dict[str, tuple[Callable[[pt.State], Any], tuple[str, ...], tuple[str, ...]]] = {
    "trajectory": (lambda state: pt.propagate(TOP, state, TIMES), ("quaternion", "omega_body"), ("time",)),
    "closed form": (lambda state: pt.free_motion(BODY, state, TIMES), ("quaternion", "omega_body"), ("time",)),
    "indicators": (
        lambda state: pt.analysis.chaos_indicators(TOP, state, TIMES, vectors=2),
        ("growth", "fli", "megno", "mean_megno", "gali", "lyapunov"),
        ("time",),
    ),
    "spectrum": (lambda state: pt.analysis.lyapunov_spectrum(TOP, state, TIMES), ("exponents",), ("time", "vector")),
    "transition": (
        lambda state: pt.analysis.state_transition(TOP, state, TIMES, ["moments[0]"], order=2),
        ("directions", "growth", "matrix", "sensitivity", "second"),
        ("time",),
    ),
    "section": (lambda state: pt.analysis.andoyer_section(FREE, state, 20.0), ("x", "y"), ("point",)),
}


@pytest.mark.parametrize("name", RESULTS)
def test_members_come_first_in_the_dataset_of_an_ensemble(name):
    compute, variables, dims = RESULTS[name]
    for state in (ONE, THREE):
        found = compute(state)
        data = found.dataset
        members = ("member",) * (state is THREE or name == "section")
        for variable in variables:
            assert data[variable].dims[: len(members) + len(dims)] == members + dims
            values = getattr(found, variable)
            assert np.array_equal(data[variable].values, values, equal_nan=True)
        assert all(values.dims[0] == "member" for values in data.data_vars.values() if "member" in values.dims)
        assert all(values.attrs["long_name"] for values in data.data_vars.values())
        assert data.attrs["version_poinsot"]
        assert data.attrs["title"]


def test_units_are_those_of_the_system():
    data = RESULTS["indicators"][0](THREE).dataset
    assert (data.lyapunov.units, data.momentum_unit.units, data.time.units) == ("s-1", "kg m2 s-1", "s")
    assert RESULTS["spectrum"][0](THREE).dataset.exponents.units == "s-1"
    section = RESULTS["section"][0](THREE).dataset
    assert (section.x.units, section.x.long_name, section.y.units) == ("rad", "l", "1")
    columns = RESULTS["transition"][0](THREE).dataset.column
    assert columns.values.tolist() == ["theta_1", "theta_2", "theta_3", "g_1", "g_2", "g_3", "moments[0]"]


class Runaway(pt.Torque):
    """It makes the rate infinite in a finite time."""

    def torque(self, instant):
        return pt.functions.Vector(9 * component**3 for component in instant.omega_body)


def test_failures_are_reported():
    fast = BODY.state((1, 0, 0, 0), omega_body=[(0.01, 0, 0), (0.9, 0, 0)])
    found = pt.analysis.chaos_indicators(pt.System(BODY, Runaway()), fast, TIMES)
    assert list(json.loads(found.dataset.attrs["failures"])) == ["1"]
