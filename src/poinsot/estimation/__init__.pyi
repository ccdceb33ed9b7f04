"""The public names of poinsot.estimation, by the module of each, as `make face` writes them."""

from .attitude_determination import AttitudeEstimate, triad, wahba
from .attitude_filter import Filtered, Smoothed, kalman_filter
from .batch_fit import fit
from .fisher_information import Information, information
from .fit_result import Fit, Prediction, ResidualTest, Solution
from .least_squares import LOSSES, LeastSquares, Loss, Minimum, checked_loss, minimised
from .null_directions import Determined, NullDirection, determined
from .priors import Posterior, Prior, place_of
from .process import Estimate, GyroProcess, Process, Step, SystemProcess
from .residuals import difference_slopes, differences
from .rotation_vectors import cross_matrix, difference, jacobian, rotated, turn
from .unknowns import Arc, Points, Unknowns, arcs_of, deviations

__all__ = [  # noqa: RUF022
    "Arc",
    "AttitudeEstimate",
    "Determined",
    "Estimate",
    "Filtered",
    "Fit",
    "GyroProcess",
    "Information",
    "LOSSES",
    "LeastSquares",
    "Loss",
    "Minimum",
    "NullDirection",
    "Points",
    "Posterior",
    "Prediction",
    "Prior",
    "Process",
    "ResidualTest",
    "Smoothed",
    "Solution",
    "Step",
    "SystemProcess",
    "Unknowns",
    "arcs_of",
    "checked_loss",
    "cross_matrix",
    "determined",
    "deviations",
    "difference",
    "difference_slopes",
    "differences",
    "fit",
    "information",
    "jacobian",
    "kalman_filter",
    "minimised",
    "place_of",
    "rotated",
    "triad",
    "turn",
    "wahba",
]
