"""Runs of ensembles on a GPU: chunks of members, as many as its memory has room for."""

from __future__ import annotations

from typing import cast

from typing_extensions import override

from poinsot.cuda import cuda_kernel
from poinsot.display.progress import bar
from poinsot.integration.formulations import Formulation
from poinsot.integration.kernel_parameters import KernelKind, formulas_of, program
from poinsot.integration.problem import Problem
from poinsot.integration.run import Run
from poinsot.integration.state_vector import StateVector
from poinsot.taylor.lowering import Program

__all__ = ["CudaRun", "check_device"]

MAX_OPERATIONS = 16_000
"""Operations above which the compiler of CUDA would take minutes."""


class CudaRun(Run):
    """Run of an ensemble on a GPU."""

    kernel_name = "cuda"

    @staticmethod
    @override
    def compiled(program: Program, kind: KernelKind) -> cuda_kernel.CudaCode:
        return cuda_kernel.compiled(program.decomposition, kind.order)

    @override
    def _integrate_members(self) -> None:
        """Integrate chunks of members, half as many where the device has no room."""
        left, code = self.fast_first(), cast("cuda_kernel.CudaCode", self.parameters.code)
        memory, most = cuda_kernel.CudaWorker(code), cuda_kernel.most_members(code, self.rising.size)
        with bar("members", left.size, self.settings.progress) as show:
            while left.size and not self.interrupts.stop:
                try:
                    done = self.integrate_slab(memory, left[:most], show)
                except MemoryError:
                    if most == 1:
                        raise
                    most = max(min(most, left.size) // 2, 1)
                else:
                    self.hand_over([done])
                    left = left[most:]


def check_device(problem: Problem, variables: StateVector, members: bool, precision: str) -> None:
    """Raise a ValueError for a run that a GPU does not support, or a computer without a GPU."""
    smooth = problem.smooth
    formulas = formulas_of(smooth, variables)
    refused = {
        "one motion": not members,
        "precision='quadruple'": precision != "double",
        "events": bool(problem.events),
        "a table": bool(problem.knots.size),
        "a sampled law": bool(problem.dynamics.jumping),
        "a formulation with singularities": type(variables.formulation).nearness is not Formulation.nearness,
        f"a formula that switches, or one of more than {MAX_OPERATIONS} operations": formulas.constants.switches
        or program(smooth, variables).decomposition.size > MAX_OPERATIONS,
    }
    for what in [what for what, found in refused.items() if found]:
        raise ValueError(
            f"device='cuda' must have an ensemble of smooth systems without events, got {what}. "
            "Leave device out to use the processor."
        )
    cuda_kernel.check_device()
