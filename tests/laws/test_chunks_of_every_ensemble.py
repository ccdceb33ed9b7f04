"""Every function of an ensemble computes it in chunks, too: the same bits in a store, and reductions of them."""

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray

import poinsot as pt
from poinsot.storage.ensemble_store import EnsembleStore

COUNT, CHUNK = 10, 4
BODY = pt.Body((1.25, 1.0, 0.75))
RATES = np.linspace((0.1, 0, 1), (1, 2, 3), COUNT)
START = BODY.state((1, 0, 0, 0), omega_body=RATES)
UNITS = {"time": "s", "inertia": "kg m2"}
TOP = pt.System(BODY, pt.UniformGravity(np.linspace(0.1, 0.9, COUNT), (1, 0.2, 0)), units=UNITS)
FREE = pt.System(BODY, units=UNITS)
MOON = pt.System(
    pt.Body.from_ratios(beta=0.26, gamma=0.1),
    pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)),
)
PAIR = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5), G=1.0)
BOTH = pt.System(PAIR, pt.forces.MutualGravity())
PLACES = np.linspace(4, 7, COUNT)[:, None] * (1.0, 0.2, 0.1)
APART = PAIR.state(PLACES, (-0.1, 0.4, 0.2), [(1, 0, 0, 0)] * 2, omega_body=[(0.1, 0.2, 1.0), (0, 0.1, 0.4)])
TIMES = np.array([1.0, 2.0, 5.0])

ONE = BODY.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
ENSEMBLES: dict[str, tuple[Callable[..., Any], str]] = {
    "propagate": (lambda **given: pt.propagate(TOP, START, TIMES, **given), "quaternion"),
    "pairs": (lambda **given: pt.propagate(BOTH, APART, TIMES, **given), "position"),
    "free_motion": (lambda **given: pt.free_motion(BODY, START, TIMES, units=UNITS, **given), "quaternion"),
    "chaos_indicators": (
        lambda **given: pt.analysis.chaos_indicators(
            TOP, START, TIMES, vectors=2, momentum_unit=np.linspace(1, 2, COUNT), **given
        ),
        "mean_megno",
    ),
    "state_transition": (
        lambda **given: pt.analysis.state_transition(TOP, START, TIMES, ["moments[0]"], **given),
        "matrix",
    ),
    "state_transition without parameters": (
        lambda **given: pt.analysis.state_transition(TOP, START, TIMES, **given),
        "matrix",
    ),
    "lyapunov_spectrum": (lambda **given: pt.analysis.lyapunov_spectrum(TOP, START, TIMES, **given), "exponents"),
    "andoyer_section": (lambda **given: pt.analysis.andoyer_section(FREE, START, 30.0, angle=0.1, **given), "y"),
    "spin_orbit_section": (
        lambda **given: pt.analysis.spin_orbit_section(MOON, 0.1, np.linspace(1, 2, COUNT), 5, **given),
        "x",
    ),
}
each = pytest.mark.parametrize("name", ENSEMBLES)


def rows(found, variable):
    """The numbers of a result along members; of points without the gaps."""
    values = np.asarray(getattr(found, variable))
    return values[np.isfinite(values)]


def test_every_function_of_ensembles_is_here():
    """Functions with `threads` integrate ensembles; `estimate_run` computes a sample of one, and stores contain
    readings, not their partial derivatives."""
    functions = {name: getattr(each, name) for each in (pt, pt.analysis) for name in dir(each)}
    takers = {"threads", "options", "chunking"}
    found = {name for name, value in functions.items() if takers & {*parameters_of(value)}}
    without_stores = {"estimate_run", "observed_partials"}
    assert found - without_stores == {name.split(" without ")[0] for name in ENSEMBLES} - {"pairs"}


def parameters_of(function):
    """The names of what a function takes; none of another thing."""
    return inspect.signature(function).parameters if inspect.isfunction(function) else ()


@each
def test_a_store_has_the_bits_of_the_ensemble(name, tmp_path):
    compute, variable = ENSEMBLES[name]
    whole, out = compute(), tmp_path / "run.zarr"
    stored = compute(out=out, chunk=CHUNK)
    again, loaded = compute(out=out), pt.load(out)
    for found in (stored, again, loaded):
        assert np.array_equal(rows(found, variable), rows(whole, variable))
    assert type(loaded) is type(stored)
    if isinstance(loaded, xarray.Dataset) and "point" not in whole.dataset.dims:
        coordinates = {name: each for name, each in whole.dataset.coords.items() if name != "member"}
        assert coordinates
        for name, each in coordinates.items():
            assert np.array_equal(loaded.coords[name], each), name
    assert len(list(out.glob("chunks/*/zarr.json"))) == -(-COUNT // CHUNK)


@each
def test_every_variable_of_a_store_equals_the_variable_of_the_ensemble(name, tmp_path):
    """An array of size zero has no file in the store, and is read, saved and copied like any other array."""
    compute, _ = ENSEMBLES[name]
    whole, stored = compute().dataset, compute(out=tmp_path / "run.zarr", chunk=CHUNK)
    data = stored.dataset if isinstance(stored, pt.Trajectory) else stored
    along = [name for name, each in data.data_vars.items() if each.dims[:1] == ("member",) and each.ndim > 1]
    assert along or "point" in whole.dims  # a store of points has one row for each point
    for each in along:
        expected = np.broadcast_to(whole[each].values, data[each].shape)  # a potential energy of zero is one number
        assert np.array_equal(data[each].values, expected, equal_nan=True), each
    EnsembleStore(tmp_path / "run.zarr").copy_to(tmp_path / "copy.zarr", {})
    copy = EnsembleStore(tmp_path / "copy.zarr").variables()
    assert all(np.array_equal(copy[each].values, data[each].values, equal_nan=True) for each in along)
    data[along].to_netcdf(tmp_path / "run.nc")


@each
def test_a_reduction_sees_the_members_of_each_chunk(name):
    compute, variable = ENSEMBLES[name]
    whole, seen = compute(), []

    def reduce(data):
        seen.append(data.member.values.tolist())
        return data[variable].max([dim for dim in data[variable].dims if dim != "member"])

    found = compute(chunk=CHUNK, reduce=reduce)
    assert seen == [list(range(first, min(first + CHUNK, COUNT))) for first in range(0, COUNT, CHUNK)]
    values = np.asarray(getattr(whole, variable)).reshape(COUNT, -1)
    assert np.array_equal(found[variable].values, np.nanmax(values, axis=1))


@each
def test_another_problem_is_refused(name, tmp_path):
    compute, _ = ENSEMBLES[name]
    other = "chaos_indicators" if name != "chaos_indicators" else "propagate"
    compute(out=tmp_path / "run.zarr", chunk=CHUNK)
    with pytest.raises(ValueError, match=r"^out must be a new name or the store of this problem, got "):
        ENSEMBLES[other][0](out=tmp_path / "run.zarr", chunk=CHUNK)


@pytest.mark.parametrize(
    "call",
    [
        lambda **given: pt.propagate(FREE, ONE, TIMES, **given),
        lambda **given: pt.free_motion(BODY, ONE, TIMES, **given),
        lambda **given: pt.analysis.chaos_indicators(FREE, ONE, TIMES, **given),
        lambda **given: pt.analysis.state_transition(FREE, ONE, TIMES, **given),
        lambda **given: pt.analysis.lyapunov_spectrum(FREE, ONE, TIMES, **given),
        lambda **given: pt.analysis.andoyer_section(FREE, ONE, 3.0, **given),
        lambda **given: pt.analysis.spin_orbit_section(MOON, 0.1, 1.5, 5, **given),
    ],
)
def test_one_body_is_no_ensemble(call, tmp_path):
    with pytest.raises(
        ValueError, match=r"^out, chunk, reduce and client must be given for an ensemble, got one body\."
    ):
        call(out=tmp_path / "run.zarr")
