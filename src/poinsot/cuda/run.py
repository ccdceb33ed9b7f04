"""Runs of ensembles on a GPU: chunks of members, as many as its memory has room for."""

from __future__ import annotations

from typing_extensions import override

from poinsot.cuda import cuda_kernel
from poinsot.display.progress import bar
from poinsot.integration.formulations import Formulation
from poinsot.integration.looped_runs import LoopedRun
from poinsot.integration.runs import Job
from poinsot.taylor.layouts import Layout
from poinsot.taylor.lowering import Constants, Program

__all__ = ["CudaRun", "check_device"]

MAX_OPERATIONS = 16_000
"""Operations above which the compiler of CUDA would take minutes."""


class CudaRun(LoopedRun):
    """One of an ensemble."""

    code: cuda_kernel.Code
    kernel_name = "cuda"

    @override
    def compiled(self, program: Program, order: int, layout: Layout, lanes: int) -> cuda_kernel.Code:
        return cuda_kernel.compiled(program.decomposition, order)

    @override
    def _go_on_members(self) -> None:
        """Integrate chunks of members, half as many where the device has no room."""
        left, kernel = self.fast_first(), cuda_kernel.Run(self.code)
        most = cuda_kernel.most_members(self.code, self.rising.size)
        with bar("members", left.size, self.job.progress) as told:
            while left.size and not self.stop:
                try:
                    done = self.integrate(kernel, left[:most], told)
                except MemoryError:
                    if most == 1:
                        raise
                    most = max(min(most, left.size) // 2, 1)
                else:
                    self.hand_over([done])
                    left = left[most:]


def check_device(job: Job, members: bool, constants: Constants) -> None:
    """Refuse jobs that a GPU does not do, and computers without one."""
    refused = {
        "one motion": not members,
        "precision='quadruple'": job.precision != "double",
        "events": bool(job.problem.events),
        "a table": bool(job.problem.knots.size),
        "a sampled law": bool(job.problem.dynamics.jumping),
        "a formulation with singularities": type(job.variables.formulation).nearness is not Formulation.nearness,
        f"a formula that switches, or one of more than {MAX_OPERATIONS} operations": constants.switches
        or constants.size > MAX_OPERATIONS,
    }
    for what in [what for what, found in refused.items() if found]:
        raise ValueError(
            f"device='cuda' must have an ensemble of smooth systems without events, got {what}. "
            "Leave device out to use the processor."
        )
    cuda_kernel.check_device()
