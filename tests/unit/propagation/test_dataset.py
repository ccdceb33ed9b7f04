"""The labelled dataset of a motion: units, frames, provenance."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.algebra import quaternion as quat

TIMES = np.linspace(0, 5, 6)
FORCE = pt.UniformGravity(0.5, (1.0, 0.2, -0.3))


def dataset(body, start, **options):
    return pt.propagate(pt.System(body, FORCE, **options), start, TIMES).dataset


def test_values_are_those_of_the_motion(top, start):
    motion = pt.propagate(top, start, TIMES)
    data = motion.dataset
    for name in (
        *("quaternion", "conjugate_momenta", "omega_body", "omega_space", "kinetic_energy", "potential_energy"),
        *("angular_momentum_body", "angular_momentum_space", "norm_error", "tangency_error"),
    ):
        assert np.array_equal(data[name].values, getattr(motion, name)), name
    assert np.array_equal(data["integral_energy"].values, motion.integrals["energy"])
    assert np.array_equal(data["drift_energy"].values, motion.drift["energy"])


def test_dimensions_and_coordinates(body, start):
    data = dataset(body, start)
    assert data["time"].values.tolist() == TIMES.tolist()
    assert data["quaternion"].dims == ("time", "parameter")
    assert data["omega_body"].dims == ("time", "axis")
    assert data["kinetic_energy"].dims == ("time",)
    assert data["axis"].values.tolist() == ["1", "2", "3"]
    assert data["parameter"].values.tolist() == ["0", "1", "2", "3"]
    assert float(data["quaternion"].sel(parameter="2", time=0.0)) == pytest.approx(-0.5, rel=1e-15, abs=0)


UNITS = {
    "none": (
        {},
        {"time": "1", "omega_body": "rad", "conjugate_momenta": "1", "angular_momentum_space": "1"}
        | {"kinetic_energy": "1", "integral_energy": "1", "integral_angular_momentum_space_3": "1"},
    ),
    "both": (
        {"units": {"time": "s", "inertia": "kg m2"}},
        {"time": "s", "omega_body": "rad s-1", "omega_space": "rad s-1", "conjugate_momenta": "kg m2 s-1"}
        | {"angular_momentum_space": "kg m2 s-1", "kinetic_energy": "kg m2 s-2", "potential_energy": "kg m2 s-2"}
        | {"tangency_error": "1", "integral_energy": "kg m2 s-2"}
        | {"integral_angular_momentum_space_3": "kg m2 s-1"},
    ),
    "time_alone": ({"units": {"time": "day"}}, {"time": "d", "omega_body": "rad d-1", "kinetic_energy": "d-2"}),
    "inertia_alone": ({"units": {"inertia": "kg km2"}}, {"time": "1", "omega_body": "rad", "kinetic_energy": "kg km2"}),
}


@pytest.mark.parametrize("case", UNITS)
def test_units(body, start, case):
    options, expected = UNITS[case]
    data = dataset(body, start, **options)
    assert {name: data[name].attrs["units"] for name in expected} == expected
    for name in ("quaternion", "norm_error", "drift_energy", "drift_angular_momentum_space_3"):
        assert data[name].attrs["units"] == "1"


def test_every_variable_has_a_unit_and_a_meaning(body, start):
    data = dataset(body, start)
    for name in data.data_vars:
        assert {"units", "long_name"} <= set(data[name].attrs), name


def test_vectors_say_their_frame(body, start):
    data = dataset(body, start)
    for frame in ("body", "space"):
        assert data[f"omega_{frame}"].attrs["frame"] == frame
        assert data[f"angular_momentum_{frame}"].attrs["frame"] == frame


def test_provenance(top, start):
    motion = pt.propagate(top, start, TIMES, formulation="canonical", tolerance=1e-12)
    attributes = motion.dataset.attrs
    assert "scalar first" in attributes["conventions"]
    assert "x_space = q x_body q~" in attributes["conventions"]
    assert (attributes["method"], attributes["formulation"], attributes["tolerance"]) == ("Taylor", "canonical", 1e-12)
    assert attributes["steps"] == motion.run.steps
    assert attributes["system"] == repr(top)
    assert attributes["initial_state"] == repr(start)
    assert attributes["version_poinsot"] == pt.__version__


def test_integrals_that_do_not_exist_are_not_there(satellite, start):
    data = pt.propagate(satellite, start, TIMES).dataset
    assert not [name for name in data.data_vars if str(name).startswith(("integral", "drift"))]


def test_a_dataset_computes_each_energy_as_often_as_it_needs_it(top, start, monkeypatch):
    """Once for its variable and for the size of drifts; the integral has its own."""
    motion = pt.propagate(top, start, [0.0, 1.0])
    calls, energy = [], pt.System.potential_energy

    def counted(system, state, *others):
        calls.append(np.shape(state.time))
        return energy(system, state, *others)

    monkeypatch.setattr(pt.System, "potential_energy", counted)
    assert set(motion.dataset.attrs) > set(motion.summary) - {"wall_time"}
    calls.clear()
    assert "drift_energy" in motion.dataset.attrs
    assert calls.count((2,)) == 1


def test_a_dataset_turns_quaternions_into_momenta_once(top, start, monkeypatch):
    """q (0, g), Q q~, and two of the rate in space: no product of quaternions is computed again."""
    motion = pt.propagate(top, start, [0.0, 1.0])
    calls, product = [], quat.product
    assert motion.quaternion.shape == (2, 4)

    def counted(p, q):
        calls.append(np.shape(p))
        return product(p, q)

    monkeypatch.setattr(quat, "product", counted)
    assert "drift_energy" in motion.dataset
    assert calls.count((2, 4)) == 4
