"""Least squares: the motion, the numbers and the observables that fit measurements best."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

import numpy as np

from poinsot.checked import checked
from poinsot.display.progress import bar
from poinsot.estimation.fit_result import Fit
from poinsot.estimation.least_squares import checked_loss, minimised
from poinsot.estimation.priors import Posterior, Prior
from poinsot.estimation.unknowns import Arc, Points, Unknowns, arcs_of
from poinsot.kinematics.state import State
from poinsot.observables.readings import Readings
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.systems.system import System

__all__ = ["fit"]

RATE_RANGE = 2.0
"""Largest factor between the angular momentum of a drawn start and the given one."""


@checked
def fit(
    system: System,
    state: State | None,
    data: Sequence[Readings | Arc],
    free: Sequence[str] = ("state",),
    *,
    priors: Sequence[Prior] = (),
    bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
    consider: Mapping[str, float] | None = None,
    loss: str = "linear",
    starts: int | State | Fit | None = None,
    seed: int = 0,
    tolerance: float = 1e-10,
    iterations: int = 50,
    progress: bool | None = None,
) -> Fit:
    """Return the least-squares fit of a motion to measurements.

    The fit minimises the sum of rho(|e|^2) over the readings plus the squares of the priors, where e is the error of a
    reading over its standard deviation. Derivatives are exact. Attitudes change by rotations q exp(theta / 2) along the
    body axes; a covariance of an attitude is the covariance of theta.

    Parameters
    ----------
    system : System
        System of one body, with the initial values of its numbers.
    state : State or None
        Initial state; None if each arc has one.
    data : list of Readings, or of Arc
        Measurements of one motion, or arcs with initial states of their own.
    free : sequence of str
        Unknowns: "state" (attitude, angular momentum and variables of parts), "attitude", "angular_momentum_body" or
        "omega_body", names of parts, "offset" (a zero point for each scalar curve), and names of numbers of the system
        and of the observables, such as "moments[0]", "gyro.bias" or "law.albedo". With arcs, the numbers that all arcs
        share. Relative light curves have an unknown factor each in any case.
    priors : list of Prior
        Prior knowledge of unknowns.
    bounds : mapping, optional
        Least and largest value of an unknown by name; None for no bound.
    consider : mapping, optional
        Standard deviations of numbers that are not fitted, by name. They add to the covariance.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}
        Function rho of `scipy.optimize.least_squares`. All but "linear" reduce the weight of outliers.
    starts : int, State or Fit, optional
        Number of starts: the given one, and others drawn from the priors, with any attitude, and angular momenta of
        half to twice the size in any direction. States of an ensemble are starts, too. A `Fit` that was interrupted
        continues.
    seed : int
        Seed of the drawn starts.
    tolerance : float
        Size of the last step in standard deviations.
    iterations : int
        Largest number of steps.
    progress : bool, optional
        True to show a progress bar. Default: on a terminal.

    Returns
    -------
    Fit
        Estimates with covariance, null directions, tests of the residuals, and further solutions. After Ctrl-C, the
        best so far, which has not converged.

    Raises
    ------
    ValueError
        If an unknown does not exist or no reading depends on it, or there are fewer numbers than unknowns.

    Examples
    --------
    >>> gyro = pt.observables.Gyro(noise=0.02)
    >>> system = pt.System(pt.Body((0.4, 1.2, 1.5)))
    >>> start = system.state((1, 0, 0, 0), omega_body=(0.9, 1.7, 0.8))
    >>> motion = pt.propagate(system, start, np.linspace(0.1, 5.0, 40))
    >>> data = pt.observe(motion, gyro).simulated(seed=3)
    >>> found = pt.estimation.fit(system, start, [data], ["omega_body", "moments[0]"])
    >>> found.converged, abs(found.values["body.moments[0]"] - 0.4) < 5 * found.sigmas["body.moments[0]"]
    (True, True)
    """
    checked_loss(loss)
    arcs, shared = arcs_of(data, free)
    unknowns = Unknowns(system, state, arcs, shared)
    posterior = Posterior(unknowns, priors, bounds)
    points = _starts(posterior, starts, seed)
    shown = sys.stderr.isatty() if progress is None else progress
    with bar("iterations", iterations, shown) as report:
        found = minimised(
            posterior,
            points,
            loss,
            tolerance,
            iterations,
            lambda _, cost: report(1, f"chi2 {np.nanmin(cost):.6g}" if np.isfinite(cost).any() else ""),
        )
    if not np.isfinite(found.cost).any():
        raise ValueError("state must start a motion that reaches all readings, but it does not. Give another state.")
    best = int(np.nanargmin(found.cost))
    _check_dependence(posterior, found.derivatives[best])
    return Fit(posterior, found, best, loss, consider or {})


def _check_dependence(posterior: Posterior, derivatives: Array) -> None:
    """Raise a ValueError for unknowns that no reading and no prior depends on."""
    idle = [label for label, column in zip(posterior.labels, derivatives.T, strict=True) if not column.any()]
    if idle:
        raise ValueError(
            f"free must name unknowns that readings depend on, got {', '.join(idle)}. "
            "Leave them out, or give priors or other readings."
        )


def _starts(posterior: Posterior, starts: int | State | Fit | None, seed: int) -> Points:
    """Return the starts of a fit."""
    unknowns = posterior.unknowns
    first = unknowns.start()
    if starts is None:
        return first
    if isinstance(starts, Fit):
        if starts.labels != posterior.labels:
            raise ValueError("starts must be a fit of the same unknowns, got others. Give the same data and free.")
        return starts.points
    if isinstance(starts, State):
        return unknowns.with_best_scales(_of_states(unknowns, first, starts))
    if starts < 1:
        raise ValueError(f"starts must be at least 1, got {quoted(starts)}.")
    return unknowns.with_best_scales(_drawn(posterior, first, starts, np.random.default_rng(seed)))


def _of_states(unknowns: Unknowns, first: Points, states: State) -> Points:
    if len(unknowns.arcs) > 1:
        raise ValueError("starts must be a number where there are several arcs, got states. Give the number of starts.")
    points = first.repeated(len(np.atleast_2d(states.quaternion)))
    others = np.concatenate([states.angular_momentum_body, *states.own.values()], axis=-1)
    return points._replace(quaternions=np.atleast_2d(states.quaternion)[:, None], others=np.atleast_2d(others)[:, None])


def _drawn(posterior: Posterior, first: Points, count: int, rng: np.random.Generator) -> Points:
    """Return the given start and others drawn from the priors."""
    unknowns, points = posterior.unknowns, first.repeated(count)
    drawn = count - 1
    q, others, numbers = points.quaternions, points.others, points.numbers
    for arc, chart in enumerate(unknowns.charts):
        if 0 in chart.columns:
            q[1:, arc] = posterior.drawn_attitudes(arc, drawn, rng)
        if 3 in chart.columns:
            direction = rng.normal(size=(drawn, 3))
            direction /= np.linalg.norm(direction, axis=1, keepdims=True)
            size = np.linalg.norm(others[0, arc, :3]) * RATE_RANGE ** rng.uniform(-1, 1, (drawn, 1))
            others[1:, arc, :3] = size * direction
    numbers[1:] = posterior.drawn_numbers(numbers[1:], rng)
    return points
