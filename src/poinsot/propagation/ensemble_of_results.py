"""Results of an analysis of members, computed in chunks."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.errors import PropagationInterrupted
from poinsot.kinematics.state import AnyState
from poinsot.propagation.stored_motion import result_in
from poinsot.records.members import members_of
from poinsot.storage.chunk_plan import Chunking, Plan, plan_of
from poinsot.storage.chunk_run import run_in_chunks
from poinsot.storage.ensemble import ChunkResult, Ensemble
from poinsot.storage.ensemble_store import plain_variables
from poinsot.storage.fingerprint import digests
from poinsot.storage.zarr_group import Attributes, Described
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, common_members

if TYPE_CHECKING:
    import xarray

__all__ = ["Analysis", "analysed_in_chunks", "taken_out"]

POINTS = "point"
"""Dimension of points, whose number differs between members."""

PROOF = ("integral_", "drift_")
"""Prefixes of the names of conserved quantities: some members conserve more quantities than all members."""

OF_ONE = (*PROOF, "failures", "initial_state", "norm_error", "order", "state_variables", "steps", "tangency_error")
"""Prefixes of the names of attributes that describe the first member only."""


Compute = Callable[[NDArray[np.int_]], Any]


def _ensemble_of_results(
    compute: Compute, members: int, last: float, problem: Mapping[str, Any]
) -> Ensemble[xarray.Dataset]:
    """Return results of members as an ensemble in chunks. No result depends on the other members.

    Parameters
    ----------
    compute : callable
        Returns the result of some members, which has a `dataset`, from the numbers of the members.
    members : int
        Number of members.
    last : float
        Last time.
    problem : mapping
        Arguments by name, of which a store contains the digests; `system` is one of them.
    """
    first: xarray.Dataset = compute(np.arange(1)).dataset  # in which an unknown number of points is none
    along = [name for name, each in first.data_vars.items() if each.dims[:1] == ("member",)]
    rows = plain_variables(first[along].drop_vars(first.coords, errors="ignore"))
    variables = {name: _described(members, *row) for name, row in rows.items() if not name.startswith(PROOF)}
    shared = first.drop_dims(["member", POINTS], errors="ignore")
    own = {name: value for name, value in shared.attrs.items() if not name.startswith(OF_ONE)}
    return Ensemble(
        members=members,
        last=last,
        problem=digests(problem),
        variables=variables,
        stored=tuple(name for name, about in variables.items() if POINTS not in about.dims),
        member_bytes=sum(about.member_bytes for about in variables.values()),
        fixed=shared.drop_attrs(deep=False).assign_attrs({**own, "system": repr(problem["system"])}),
        compute=functools.partial(_computed, compute),
        open=result_in,
    )


def _described(members: int, dims: tuple[str, ...], values: NDArray[np.generic], attributes: Attributes) -> Described:
    """Return the description of a variable of all members, from the variable of one member."""
    one = Described.of(dims, values, attributes)
    return replace(one, shape=(members, *one.shape[1:]))


def _computed(compute: Compute, members: slice, names: tuple[str, ...], progress: Progress) -> ChunkResult:
    """Compute the results of some members."""
    who = np.arange(members.start, members.stop)
    result: Any
    try:
        result, interrupted = compute(who), False
    except PropagationInterrupted as error:
        result, interrupted = error.trajectory, True
    if callable(progress):
        progress(who.size)
    run_of, data = getattr(result, "motion", result), result.dataset
    points = {} if POINTS not in data.dims else _points(data, members.start)
    rows = {name: data[name].values for name in names}
    return ChunkResult.of(run_of.failures, run_of.run, members.start, rows, points, interrupted)


class Analysis(NamedTuple):
    """Call of a function of a system, a state and times.

    Parameters
    ----------
    function : callable
        Returns the result of an ensemble, which has a `dataset`.
    system, state, times
        First arguments of the function.
    settings : mapping
        Arguments by name that all members share; `threads` does not change the result.
    varied : mapping
        Arguments by name that may have one value for each member.
    """

    function: Callable[..., Any]
    system: System
    state: AnyState
    times: NDArray[np.float64]
    settings: Mapping[str, Any]
    varied: Mapping[str, Any] = MappingProxyType({})


def analysed_in_chunks(plan: Plan, analysis: Analysis, progress: bool | None) -> xarray.Dataset:
    """Return the dataset of an analysis of an ensemble in chunks; a terminal shows the progress by default."""
    function, system, state, times, settings, varied = analysis
    counts = common_members(system, state)
    if not counts:
        raise ValueError("out, chunk, reduce and client must be given for an ensemble, got one body. Save its dataset.")
    whole = broadcast_members(state, counts)
    shared = {name: value for name, value in settings.items() if name != "threads"}
    threads = plan.threads(settings.get("threads"))

    def some(members: NDArray[np.int_]) -> Any:
        given = members_of(system, members), members_of(whole, members), times
        return function(*given, **shared, **_of_each(varied, members), threads=threads, progress=False)

    problem = {"function": function.__qualname__, "system": system, "times": times, "settings": {**shared, **varied}}
    states = {"states": (dict(whole.phase), whole.time, *whole.jumped.items())}
    ensemble = _ensemble_of_results(some, counts[0], float(times[-1]), problem | states)
    return run_in_chunks(ensemble, plan, sys.stderr.isatty() if progress is None else progress)


def _of_each(arguments: Mapping[str, Any], members: NDArray[np.int_]) -> dict[str, Any]:
    """Return arguments of some members; arguments that all members share stay."""
    return {name: np.asarray(x)[members] if np.ndim(x) else x for name, x in arguments.items()}


def taken_out(options: dict[str, Any]) -> Plan | None:
    """Remove the arguments of chunks from options and return the plan; None without any."""
    return plan_of(**{name: options.pop(name) for name in Chunking.__annotations__ if name in options})


def _points(data: xarray.Dataset, first: int) -> dict[str, Any]:
    """Return points row after row, each with the number of its member."""
    names = [name for name, each in data.data_vars.items() if each.dims == ("member", POINTS)]
    whose, where = np.nonzero(np.isfinite(data[names[0]].values))
    rows = {str(name): (("member",), data[name].values[whose, where], dict(data[name].attrs)) for name in names}
    return {"member": (("member",), whose + first, {"long_name": "number of the member"}), **rows}
