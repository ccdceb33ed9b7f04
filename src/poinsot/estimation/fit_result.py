"""Result of a fit: estimates, covariance, tests of the residuals, and further solutions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2, norm
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_numbers
from poinsot.estimation.least_squares import Minimum
from poinsot.estimation.null_directions import Determined, NullDirection, determined
from poinsot.estimation.priors import Posterior
from poinsot.estimation.rotation_vectors import difference
from poinsot.estimation.unknowns import Arc, Points, Unknowns, deviations
from poinsot.immutable import cached_property
from poinsot.kinematics.state import State
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.quantities import Array, Times
from poinsot.systems.system import System
from poinsot.systems.times_and_states import checked_times

if TYPE_CHECKING:
    import xarray

__all__ = ["Fit", "Prediction", "ResidualTest", "Solution"]

SAME_SOLUTION = 0.1
"""Largest difference in standard deviations between two starts that found one solution."""

UNIQUE_DECREASE, UNIQUE_STARTS = 25.0, 3
"""Difference of chi2 to the next solution, and number of starts that found the first, of a unique solution."""

REJECTED_SIZE = 5.0
"""Size of a whitened error above which a reading is listed as rejected."""


class Solution(NamedTuple):
    """One of the distinct solutions that the starts found.

    Attributes
    ----------
    start : int
        Number of the start of smallest chi2.
    chi2 : float
        Sum of the losses of the errors.
    weight : float
        Share of the probability in Laplace's approximation, exp(-chi2 / 2) det(P)^(1/2), normalised.
    found_by : int
        Number of starts that led there.
    converged : bool
    """

    start: int
    chi2: float
    weight: float
    found_by: int
    converged: bool


class ResidualTest(NamedTuple):
    """Test of the residuals: its statistic, and the probability of one as extreme if the model is right."""

    name: str
    statistic: float
    p_value: float


class Prediction(NamedTuple):
    """Predicted readings with the covariance of their errors.

    Attributes
    ----------
    readings : Readings
        Predicted readings.
    covariance : array (n, n) or (n c, n c)
        Covariance of all predicted numbers, from the covariance of the unknowns.
    standard_deviations : array of the shape of the values
    """

    readings: Readings
    covariance: Array
    standard_deviations: Array


class Fit(Summarized):
    """Fit of a motion to measurements.

    Attributes
    ----------
    converged : bool
        True if the last step was below the tolerance.
    iterations : int
        Number of steps.
    chi2 : float
        Sum of the losses of the errors, priors included.
    loss : str
        Name of the loss.
    labels : tuple of str
        Names of the unknowns.
    points : Points
        Points that all starts reached, from which `fit(..., starts=found)` continues.
    """

    def __init__(
        self, posterior: Posterior, minimum: Minimum[Points], best: int, loss: str, consider: Mapping[str, float]
    ) -> None:
        self.posterior, self.loss, self.labels = posterior, loss, posterior.labels
        self._minimum, self._best, self._consider = minimum, best, dict(consider)
        self.points = minimum.points
        self.converged, self.iterations = bool(minimum.converged[best]), int(minimum.iterations[best])
        self.chi2 = float(minimum.cost[best])

    # ------------------------------------------------------------------ estimates

    @property
    def _point(self) -> Points:
        return self.points.at([self._best])

    @property
    def _unknowns(self) -> Unknowns:
        return self.posterior.unknowns

    @cached_property
    def _problems(self) -> list[tuple[System, list[Observable]]]:
        return [self._unknowns.problem_at(self._point.numbers[0], i) for i in range(len(self._unknowns.arcs))]

    @property
    def system(self) -> System:
        """System with the estimated numbers; with arcs, of the first arc."""
        return self._problems[0][0]

    @property
    def observables(self) -> tuple[Observable, ...]:
        """Observables with the estimated numbers, in the order of the data; with arcs, of the first arc."""
        return tuple(self._problems[0][1])

    @property
    def states(self) -> tuple[State, ...]:
        """Estimated initial state of each arc."""
        point = self._point
        return tuple(
            self._unknowns.state_at(system, point.quaternions[0, i], point.others[0, i], i)
            for i, (system, _) in enumerate(self._problems)
        )

    @property
    def state(self) -> State:
        """Estimated initial state; with arcs, of the first arc."""
        return self.states[0]

    @property
    def arcs(self) -> tuple[Arc, ...]:
        """Data with the estimated numbers of the observables and the estimated states."""
        found = []
        for arc, (_, observables), state in zip(self._unknowns.arcs, self._problems, self.states, strict=True):
            new = dict(zip(map(id, self._unknowns.observables), observables, strict=True))
            readings = (each.of(new[id(each.observable)]) for each in arc.readings)
            found.append(Arc(*readings, state=state, free=arc.free))
        return tuple(found)

    @property
    def values(self) -> dict[str, float]:
        """Estimates of the unknowns by name, without the rotation vectors of attitudes, which are zero."""
        each = zip(self.labels, self.posterior.values(self._point)[0].tolist(), strict=True)
        return {label: value for label, value in each if not _is_angle(label)}

    @cached_property
    def _determined(self) -> Determined:
        rows = self._minimum.derivatives[self._best] * np.sqrt(self._minimum.weights[self._best])[:, None]
        found = determined(rows, self.labels, self.posterior.values(self._point)[0])
        if not self._consider:
            return found
        columns = self._derivatives_by_considered() * np.sqrt(self._minimum.weights[self._best])[:, None]
        shifts = found.covariance @ rows.T @ columns * [*self._consider.values()]
        covariance = found.covariance + shifts @ shifts.T
        sigmas = np.where(np.isinf(found.standard_deviations), np.inf, np.sqrt(np.diagonal(covariance)))
        return Determined(covariance, sigmas, found.null_directions)

    def _derivatives_by_considered(self) -> Array:
        """Return the derivatives of the whitened residuals by the numbers that are considered, not fitted."""
        names, several = [*self._consider], len(self._unknowns.arcs) > 1
        arcs = [Arc(*arc.readings, state=arc.state, free=() if several else names) for arc in self.arcs]
        unknowns = Unknowns(self.system, None, arcs, names if several else ())
        point = unknowns.start()._replace(scales=self._point.scales)
        _, (derivatives,) = unknowns.evaluated(point)
        zero = np.zeros((len(self.posterior.data) - len(derivatives), len(names)))
        return np.concatenate([derivatives[:, : len(names)], zero])

    @property
    def covariance(self) -> xarray.DataArray:
        """Covariance of the unknowns, (n, n), with their names on both axes; angles along the body axes, radians."""
        import xarray

        names = {"unknown": list(self.labels), "other": list(self.labels)}
        return xarray.DataArray(self._determined.covariance, names, ("unknown", "other"))

    @property
    def correlations(self) -> xarray.DataArray:
        """Correlations of the unknowns, (n, n)."""
        P = self.covariance
        sigma = np.sqrt(np.diagonal(P))
        with np.errstate(invalid="ignore", divide="ignore"):
            return P / np.outer(sigma, sigma)

    @property
    def sigmas(self) -> dict[str, float]:
        """Standard deviations of the unknowns by name; infinite for those that are not determined."""
        return dict(zip(self.labels, self._determined.standard_deviations.tolist(), strict=True))

    @property
    def null_directions(self) -> tuple[NullDirection, ...]:
        """Changes of the unknowns that change no reading and no prior."""
        return self._determined.null_directions

    # ------------------------------------------------------------------ residuals

    @property
    def degrees(self) -> int:
        """Number of readings and priors minus the number of determined unknowns."""
        known = len(self.labels) - len(self.null_directions)
        absent = sum(int(np.isnan(each).sum()) for _, each, _ in self._curves())
        return int(self.posterior.data.size) - absent - known

    def _curves(self) -> Iterator[tuple[Readings, Array, Array]]:
        """Yield readings with their whitened errors (n, errors), NaN where absent, and weights (n,)."""
        residuals, weights = self._minimum.residuals[self._best], self._minimum.weights[self._best]
        first = 0
        for arc in self._unknowns.arcs:
            for readings in arc.readings:
                errors = len(readings.observable.errors) or 1
                stop = first + errors * len(readings)
                whitened = np.array(residuals[first:stop]).reshape(-1, errors)
                values = np.asarray(readings.values).reshape(len(readings), -1)
                whitened[np.isnan(values).any(axis=1)] = np.nan
                yield readings, whitened, weights[first:stop:errors]
                first = stop

    @property
    def residuals(self) -> tuple[xarray.Dataset, ...]:
        """Errors of each curve: `residual` in its unit, `whitened` over sigma, and the `weight` of the loss."""
        import xarray

        found = []
        for readings, whitened, weights in self._curves():
            names = list(readings.observable.errors) or ["value"]
            rows = {
                "residual": (("time", "error"), whitened * deviations(readings)),
                "whitened": (("time", "error"), whitened),
                "weight": (("time",), weights),
            }
            found.append(xarray.Dataset(rows, {"time": readings.times, "error": names}, {"name": readings.name}))
        return tuple(found)

    @property
    def rejected(self) -> tuple[tuple[str, float, float], ...]:
        """Readings whose errors exceed five standard deviations: name, time and size of the whitened error."""
        found = []
        for readings, whitened, _ in self._curves():
            sizes = np.linalg.norm(whitened, axis=1)
            far = np.flatnonzero(sizes > REJECTED_SIZE)
            found += [(readings.name, float(readings.times[i]), float(sizes[i])) for i in far]
        return tuple(found)

    @property
    def tests(self) -> tuple[ResidualTest, ...]:
        """Tests of the residuals: chi2, and of each curve runs of signs, correlation of neighbours, and outliers."""
        found = [ResidualTest("chi2", self.chi2, float(chi2.sf(self.chi2, max(self.degrees, 1))))]
        for readings, whitened, _ in self._curves():
            for name, errors in zip(readings.observable.errors or ("",), whitened.T, strict=True):
                label = f"{readings.name} {name}".rstrip()
                found += _tests_of_curve(label, errors[np.isfinite(errors)])
        return tuple(found)

    # ------------------------------------------------------------------ solutions

    @cached_property
    def solutions(self) -> tuple[Solution, ...]:
        """Distinct solutions of the starts, by chi2; starts closer than 0.1 standard deviations are one."""
        cost, order = self._minimum.cost, np.argsort(self._minimum.cost)
        found: list[tuple[int, int, bool]] = []
        for i in order[np.isfinite(cost[order])]:
            for place, (start, count, converged) in enumerate(found):
                if self._is_same(start, int(i)):
                    found[place] = start, count + 1, converged
                    break
            else:
                found.append((int(i), 1, bool(self._minimum.converged[i])))
        logs = np.array([-0.5 * cost[start] + self._half_log_volume(start) for start, _, _ in found])
        weights = np.exp(logs - logs.max(initial=-np.inf))
        weights /= weights.sum()
        return tuple(
            Solution(start, float(cost[start]), float(weight), count, converged)
            for (start, count, converged), weight in zip(found, weights, strict=True)
        )

    def _is_same(self, start: int, other: int) -> bool:
        change = self.posterior.values(self.points)[other] - self.posterior.values(self.points)[start]
        first = 0
        for arc, chart in enumerate(self._unknowns.charts):
            turn = difference(self.points.quaternions[start, arc], self.points.quaternions[other, arc])
            angles = [i for i in chart.columns if i < 3]
            change[first : first + len(angles)] = turn[angles]
            first += len(chart.columns)
        rows = self._minimum.derivatives[start] * np.sqrt(self._minimum.weights[start])[:, None]
        sigma = np.sqrt(np.diagonal(determined(rows, self.labels, np.zeros(len(self.labels))).covariance))
        return bool(np.all(np.abs(change) <= SAME_SOLUTION * sigma + 1e-300))

    def _half_log_volume(self, start: int) -> float:
        rows = self._minimum.derivatives[start] * np.sqrt(self._minimum.weights[start])[:, None]
        values = np.linalg.svd(rows, compute_uv=False)
        return float(-np.sum(np.log(values[values > 0])))

    @property
    def is_unique(self) -> bool:
        """True if at least three starts found the first solution, and the chi2 of the next one is larger by 25."""
        first, *others = self.solutions
        clear = not others or others[0].chi2 - first.chi2 >= UNIQUE_DECREASE
        return first.found_by >= UNIQUE_STARTS and clear

    # ------------------------------------------------------------------ predictions

    @checked
    def predict(self, times: Times, observable: Observable, arc: int = 0) -> Prediction:
        """Return predicted readings at times, with the covariance that follows from the unknowns.

        Parameters
        ----------
        times : array (n,)
            Times of the readings.
        observable : Observable
            Observable of the data, whose estimated numbers are used, or another one.
        arc : int
            Number of the arc.
        """
        plan = Readings(observable, checked_times(times, self.system))
        ((values, slopes),) = self._unknowns.predictions(self._point, arc, [plan], is_scaled=False)
        of_arc = self._unknowns.arcs[arc].readings
        for place, readings in enumerate(of_arc):
            if readings.observable is observable:
                values, slopes = self._unknowns.scaled(self._point, arc, place, values, slopes)
                break
        rows = slopes[0].reshape(-1, len(self.labels))
        covariance = rows @ self._determined.covariance @ rows.T
        sigma = np.sqrt(np.maximum(np.diagonal(covariance), 0.0)).reshape(values[0].shape)
        return Prediction(plan.of(observable).with_values(values[0]), covariance, sigma)

    @checked
    def draws(self, n: int, seed: int = 0) -> tuple[System, State]:
        """Return systems and initial states from the normal distribution of the estimate, for `propagate`.

        Parameters
        ----------
        n : int
            Number of members.
        seed : int
            Seed of the random numbers.
        """
        steps = np.random.default_rng(seed).multivariate_normal(
            np.zeros(len(self.labels)), self._determined.covariance, n, method="eigh"
        )
        moved = self._unknowns.moved(self._point.repeated(n), steps)
        system, _ = self._unknowns.problem_at(moved.numbers, 0)
        return system, self._unknowns.state_at(system, moved.quaternions[:, 0], moved.others[:, 0], 0)

    def log_density(self, x: Sequence[float] | NDArray[np.float64]) -> float:
        """Return the logarithm of the posterior density, but for a constant, in whitened coordinates.

        The estimate is x = 0, and its covariance is one, so that samplers need no other scale.
        """
        values, axes = np.linalg.eigh(self._determined.covariance)
        step = axes @ (np.sqrt(np.maximum(values, 0.0)) * real_numbers("x", x))
        residuals, _ = self.posterior.evaluated(self._unknowns.moved(self._point, step[None]))
        return float(-0.5 * np.sum(residuals**2))

    # ------------------------------------------------------------------ summary

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        values, sigmas = self.values, self.sigmas
        lines = {
            label: f"{formatted(values[label])} +- {sigmas[label]:.2g}"
            if label in values
            else f"+- {sigmas[label]:.2g} rad"
            for label in self.labels
        }
        worst = min(self.tests, key=lambda each: each.p_value)
        return "Fit" if self.converged else "Fit that has not converged", {
            **lines,
            "chi2": f"{self.chi2:.6g} for {self.degrees} degrees of freedom",
            "least p-value": f"{worst.p_value:.3g} ({worst.name})",
            "not determined": "; ".join(each.text for each in self.null_directions),
            "rejected readings": str(len(self.rejected)) if self.rejected else "",
            "solutions": str(len(self.solutions)) if len(self.solutions) > 1 else "",
            "iterations": str(self.iterations),
        }


def _is_angle(label: str) -> bool:
    return label.rpartition(": ")[2].startswith("theta_")


def _tests_of_curve(name: str, errors: Array) -> list[ResidualTest]:
    """Return the tests of the errors of one curve."""
    n = len(errors)
    if n < 8:
        return []
    above = int(np.sum(errors > 0))
    below = n - above
    found = []
    if above and below:
        runs = 1 + int(np.sum(np.diff(np.sign(errors)) != 0))
        mean = 1 + 2 * above * below / n
        variance = (mean - 1) * (mean - 2) / (n - 1)
        found.append(_normal(f"{name}: runs of signs", (runs - mean) / np.sqrt(variance)))
    centred = errors - errors.mean()
    correlation = float(centred[1:] @ centred[:-1] / (centred @ centred))
    found.append(_normal(f"{name}: correlation of neighbours", correlation * np.sqrt(n)))
    outside, share = int(np.sum(np.abs(errors) > 3)), 2 * float(norm.sf(3))
    found.append(ResidualTest(f"{name}: beyond 3 sigma", outside, float(binom.sf(outside - 1, n, share))))
    return found


def _normal(name: str, statistic: Any) -> ResidualTest:
    return ResidualTest(name, float(statistic), float(2 * norm.sf(abs(statistic))))
