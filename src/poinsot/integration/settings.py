"""Settings of a run: formulation, precision of the arithmetic, tolerance of the steps, threads."""

from __future__ import annotations

from typing import NamedTuple

from poinsot.display.progress import Progress
from poinsot.errors import real_array
from poinsot.integration.formulations import Formulation
from poinsot.printable import quoted
from poinsot.taylor.kernels import ROUNDING

__all__ = ["PRECISIONS", "RunSettings", "checked_tolerance"]

PRECISIONS = tuple(ROUNDING)


class RunSettings(NamedTuple):
    """Settings of a run.

    Attributes
    ----------
    formulation : Formulation
        Chart of attitude and momentum.
    tolerance : float
        Relative error per step.
    precision : {"double", "quadruple"}
    threads : int
        Most threads of an ensemble.
    progress : bool or callable
        True to show a progress bar, or the function that receives the progress.
    dense : bool
        True to store the polynomials, for one body.
    device : {"cpu", "cuda"}
        "cuda" for ensembles only.
    """

    formulation: Formulation
    tolerance: float
    precision: str = "double"
    threads: int = 1
    progress: Progress = False
    dense: bool = False
    device: str = "cpu"


def checked_tolerance(tolerance: float | None, precision: str) -> float:
    """Return the tolerance of a run. The default is the rounding unit; in double precision it gives order 20.

    At order p the powers n > p of a step are left out, e^(-2 n) of the state. Along a motion odd ones cancel in the
    energy, even ones add up: e^-40 at orders 18 and 19, which long runs show, e^-44 at order 20.
    """
    if not isinstance(precision, str) or precision not in ROUNDING:
        remedy = " Use 'quadruple', which has 32 digits." * (precision == "extended")
        raise ValueError(f"precision must be 'double' or 'quadruple', got {quoted(precision)}.{remedy}")
    least = ROUNDING[precision]
    if tolerance is None:
        return least
    value = float(real_array("tolerance", tolerance, ()))
    if not 0 < value < 1:
        raise ValueError(f"tolerance must be between 0 and 1, got {value}.")
    if value < least:
        raise ValueError(
            f"tolerance must be at least the rounding unit of {precision} precision, {least}, got {value}. "
            "Leave it out for that."
        )
    return value
