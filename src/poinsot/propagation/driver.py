"""One driver for one body, for ensembles and for variations, forwards and backwards: it hands rows to a sink."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from poinsot.cuda.run import CudaRun, check_device
from poinsot.integration.looped_runs import LoopedRun, constants_of
from poinsot.integration.runs import BOTH_WAYS, Job, Report, Sink
from poinsot.integration.termination import HeldInterrupts
from poinsot.mechanics.state import AnyState

__all__ = ["Driver"]

Array = NDArray[Any]


class Driver(Job):
    """Integrates a job."""

    def run(self, state: AnyState, times: Array, sink: Sink, ways: tuple[bool, ...] = BOTH_WAYS) -> Report:
        """Integrate from a state outwards to all the times, which are monotonic; on Ctrl-C what is finished is kept.

        A state with one time is that of one body, one with times those of an ensemble.
        """
        given, constants, members = (self, state, times, sink, ways), constants_of(self), bool(state.time.ndim)
        self.check_device(members)
        run = (CudaRun if self.device == "cuda" else LoopedRun)(constants, *given)
        with HeldInterrupts(run.interrupt):
            run.go()
        return run.report

    def check_device(self, members: bool) -> None:
        """Refuse what the device does not do, and a computer without one."""
        if self.device == "cuda":
            check_device(self, members, constants_of(self))
