"""The results of an analysis of members, chunk by chunk."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.display.progress import Progress
from poinsot.errors import PropagationInterrupted
from poinsot.mechanics.members import members_of
from poinsot.mechanics.state import AnyState
from poinsot.mechanics.system import System
from poinsot.propagation.arguments import broadcast_members, common_members
from poinsot.propagation.chunks import Chunking, Part, Plan, in_chunks, plan_of
from poinsot.propagation.ensemble_store import EnsembleStore
from poinsot.propagation.stored_motion import result_in, told_run

if TYPE_CHECKING:
    import xarray

__all__ = ["EnsembleOfResults", "analysed_in_chunks", "of_each", "results_in_chunks", "taken_out"]

POINTS = "point"
"""The dimension of what members have different numbers of."""

PROOF = ("integral_", "drift_")
"""What names begin with of what a motion conserves: some members conserve more than all."""

OF_ONE = (*PROOF, "failures", "initial_state", "norm_error", "order", "state_variables", "steps", "tangency_error")
"""What attributes of the first member begin with that are not those of all."""


@dataclass(frozen=True)
class EnsembleOfResults:
    """Results of members, each with a `dataset`; see `Ensemble`. No member depends on who else is there.

    Parameters
    ----------
    compute : callable
        Numbers of members to the result of these.
    members : int
    last : float
    problem : mapping
    """

    compute: Callable[[NDArray[np.int_]], Any]
    members: int
    last: float
    problem: Mapping[str, Any]

    @functools.cached_property
    def _first(self) -> xarray.Dataset:
        """The dataset of the first member, in which an unknown number of points is none."""
        data: xarray.Dataset = self.compute(np.arange(1)).dataset
        return data

    @property
    def names(self) -> tuple[str, ...]:
        """The variables along members."""
        along = (str(name) for name, each in self._first.data_vars.items() if each.dims[:1] == ("member",))
        return tuple(name for name in along if not name.startswith(PROOF))

    @property
    def kept(self) -> tuple[str, ...]:
        """Those whose rows have the same shape for all members."""
        return tuple(name for name in self.names if POINTS not in self._first[name].dims)

    @property
    def member_bytes(self) -> int:
        """Bytes of the rows of a member."""
        return sum(int(self._first[name].nbytes) for name in self.names)

    def fixed(self) -> xarray.Dataset:
        """Return what all members share."""
        data = self._first.drop_dims(["member", POINTS], errors="ignore")
        own = {name: value for name, value in data.attrs.items() if not name.startswith(OF_ONE)}
        return data.drop_attrs(deep=False).assign_attrs({**own, "system": repr(self.problem["system"])})

    def empty(self, names: Iterable[str]) -> xarray.Dataset:
        """Return the variables of one member."""
        return self._first[[*names]]

    def computed(self, members: slice, names: Iterable[str], progress: Progress) -> Part:
        """Compute the results of some members."""
        who = np.arange(members.start, members.stop)
        try:
            result, interrupted = self.compute(who), False
        except PropagationInterrupted as error:
            result, interrupted = error.trajectory, True
        if callable(progress):
            progress(who.size)
        motion, data = getattr(result, "motion", result), result.dataset
        failures = {str(members.start + member): why for member, why in motion.failures.items()}
        about = {"failures": failures, "run": told_run(motion.run)}
        points = {} if POINTS not in data.dims else _points(data, members.start)
        return Part(data[[*names]], points, about, interrupted)

    def opened(self, store: EnsembleStore) -> Any:
        """Return the dataset in a store."""
        return result_in(store)


def analysed_in_chunks(
    plan: Plan,
    function: Callable[..., Any],
    system: System,
    state: AnyState,
    times: NDArray[np.float64],
    progress: bool | None,
    settings: Mapping[str, Any],
    varied: Mapping[str, Any] | None = None,
) -> Any:
    """Return what a function of system, state and times makes of an ensemble in chunks.

    `varied` are arguments that may have one value for each member.
    """
    counts = common_members(system, state)
    if not counts:
        raise ValueError("out, chunk, reduce and client must be given for an ensemble, got one body. Save its dataset.")
    whole, varied = broadcast_members(state, counts), varied or {}
    shared = {name: value for name, value in settings.items() if name != "threads"}
    threads = plan.threads(settings.get("threads"))

    def some(members: NDArray[np.int_]) -> Any:
        given = members_of(system, members), members_of(whole, members), times
        return function(*given, **shared, **of_each(varied, members), threads=threads, progress=False)

    problem = {"function": function.__qualname__, "system": system, "times": times, "settings": {**shared, **varied}}
    states = {"states": (dict(whole.phase), whole.time, *whole.jumped.items())}
    ensemble = EnsembleOfResults(some, counts[0], float(times[-1]), problem | states)
    return results_in_chunks(ensemble, plan, progress)


def results_in_chunks(ensemble: EnsembleOfResults, plan: Plan, progress: bool | None) -> Any:
    """Return the results of an ensemble, chunk by chunk, shown on a terminal by default."""
    return in_chunks(ensemble, plan, sys.stderr.isatty() if progress is None else progress)


def of_each(arguments: Mapping[str, Any], members: NDArray[np.int_]) -> dict[str, Any]:
    """Return those of some members, of arguments that may have one value for each."""
    return {name: np.asarray(x)[members] if np.ndim(x) else x for name, x in arguments.items()}


def taken_out(options: dict[str, Any]) -> Plan | None:
    """Take the arguments of chunks out of options, and return what they ask for."""
    return plan_of(**{name: options.pop(name) for name in Chunking.__annotations__ if name in options})


def _points(data: xarray.Dataset, first: int) -> dict[str, Any]:
    """Return points row after row, each with the number of its member."""
    names = [name for name, each in data.data_vars.items() if each.dims == ("member", POINTS)]
    whose, where = np.nonzero(np.isfinite(data[names[0]].values))
    rows = {str(name): (("member",), data[name].values[whose, where], dict(data[name].attrs)) for name in names}
    return {"member": (("member",), whose + first, {"long_name": "number of the member"}), **rows}
