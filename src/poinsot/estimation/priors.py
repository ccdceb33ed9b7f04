"""Prior knowledge of unknowns: means with standard deviations, and bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.errors import real_numbers, refuse_nonpositive
from poinsot.estimation.rotation_vectors import difference, jacobian, rotated
from poinsot.estimation.unknowns import Points, Unknowns
from poinsot.kinematics.attitude import unit_quaternion
from poinsot.printable import quoted
from poinsot.quantities import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Posterior", "Prior", "place_of"]


class Prior:
    """Normally distributed prior knowledge of an unknown.

    Parameters
    ----------
    name : str
        Name of an unknown number, a component of the state such as "g_1", or "attitude".
    mean : float, or attitude
        Mean. For "attitude" a quaternion, body -> space, or a scipy rotation.
    sigma : float, or array (3,)
        Standard deviation; positive. For "attitude" of the rotation about each body axis, radians.

    Raises
    ------
    ValueError
        If sigma is not positive.

    Examples
    --------
    >>> pt.estimation.Prior("moments[1]", 1.7, sigma=0.3)
    Prior('moments[1]', 1.7, sigma=0.3)
    """

    @checked
    def __init__(self, name: str, mean: Rotation | ArrayLike, sigma: ArrayLike) -> None:
        self.name = name
        self.mean = unit_quaternion(mean) if name.endswith("attitude") else real_numbers("mean", mean)
        self.sigma = real_numbers("sigma", sigma)
        refuse_nonpositive("sigma", self.sigma)
        if not name.endswith("attitude") and (self.mean.shape or self.sigma.shape):
            raise ValueError(
                f"mean and sigma of {name} must be numbers, got shapes {self.mean.shape}, {self.sigma.shape}."
            )

    def __repr__(self) -> str:
        return f"Prior({self.name!r}, {self.mean.tolist()}, sigma={self.sigma.tolist()})"


def place_of(name: str, labels: Sequence[str], argument: str) -> int:
    """Return the place of an unknown by its label or the end of its label."""
    found = [i for i, label in enumerate(labels) if label == name or label.endswith((f".{name}", f": {name}"))]
    if len(found) != 1:
        import difflib

        near = [labels[i] for i in found] or difflib.get_close_matches(name, labels, 3, 0.0)
        raise ValueError(f"{argument} must name one unknown, got {quoted(name)}. Near: {', '.join(near)}.")
    return found[0]


class Posterior:
    """Residuals of data and priors: the interface of `least_squares.LeastSquares`."""

    def __init__(
        self,
        unknowns: Unknowns,
        priors: Sequence[Prior] = (),
        bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
    ) -> None:
        self.unknowns, self.priors = unknowns, tuple(priors)
        self.labels = unknowns.labels
        self._places = tuple(self._place(prior) for prior in priors)
        count = sum(len(place) for place in self._places)
        self.data: NDArray[np.int_] = np.concatenate([unknowns.data, np.full(count, -1)])
        self.bounds = self._bounds(bounds or {})
        free, known = len(self.labels), self.data.size
        if known < free:
            raise ValueError(
                f"data must have at least as many numbers as there are unknowns, {free}, got {known}. "
                "Give priors, or leave unknowns out of free."
            )

    def _place(self, prior: Prior) -> tuple[int, ...]:
        if not prior.name.endswith("attitude"):
            return (place_of(prior.name, self.labels, "priors"),)
        stem = prior.name.removesuffix("attitude")
        return tuple(place_of(f"{stem}theta_{i}", self.labels, "priors") for i in (1, 2, 3))

    def _bounds(self, bounds: Mapping[str, tuple[float | None, float | None]]) -> tuple[Array, Array] | None:
        if not bounds:
            return None
        low, high = np.full(len(self.labels), -np.inf), np.full(len(self.labels), np.inf)
        for name, (least, most) in bounds.items():
            place = place_of(name, self.labels, "bounds")
            low[place], high[place] = -np.inf if least is None else least, np.inf if most is None else most
            if not low[place] < high[place]:
                raise ValueError(f"bounds of {name} must ascend, got {least} and {most}.")
        return low, high

    def evaluated(self, points: Points) -> tuple[Array, Array]:
        """Return whitened residuals (starts, m) and derivatives (starts, m, n); NaN where a motion has failed."""
        residuals, derivatives = self.unknowns.evaluated(points)
        values = self.unknowns.values(points)
        for prior, place in zip(self.priors, self._places, strict=True):
            rows = np.zeros((len(values), len(place), len(self.labels)))
            if len(place) == 1:
                left = (prior.mean - values[:, place]) / prior.sigma
                rows[:, 0, place[0]] = -1 / prior.sigma
            else:
                q = points.quaternions[:, self._arc_of(place)]
                turn = difference(q, np.broadcast_to(prior.mean, q.shape))
                sigma = np.broadcast_to(prior.sigma, 3)
                left = turn / sigma
                rows[:, :, place] = -np.linalg.inv(jacobian(-turn)) / sigma[:, None]
            residuals = np.concatenate([residuals, left], axis=1)
            derivatives = np.concatenate([derivatives, rows], axis=1)
        return residuals, derivatives

    def _arc_of(self, place: tuple[int, ...]) -> int:
        ends = np.cumsum([len(chart.columns) for chart in self.unknowns.charts])
        return int(np.searchsorted(ends, place[0], side="right"))

    def moved(self, points: Points, steps: Array) -> Points:
        """Return the points after steps (starts, n)."""
        return self.unknowns.moved(points, steps)

    def chosen(self, which: NDArray[np.bool_], points: Points, others: Points) -> Points:
        """Return points where `which` is True and other points elsewhere."""
        return self.unknowns.chosen(which, points, others)

    def values(self, points: Points) -> Array:
        """Return the values of the unknowns (starts, n); the rotation vectors of attitudes are zero."""
        return self.unknowns.values(points)

    # ------------------------------------------------------------------ random starts

    def drawn_attitudes(self, arc: int, count: int, rng: np.random.Generator) -> Array:
        """Return attitudes (count, 4) from the prior of an arc; without one, from all attitudes."""
        for prior, place in zip(self.priors, self._places, strict=True):
            if len(place) == 3 and self._arc_of(place) == arc:
                turns = rng.normal(size=(count, 3)) * prior.sigma
                return rotated(np.broadcast_to(prior.mean, (count, 4)), turns)
        q = rng.normal(size=(count, 4))
        return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))

    def drawn_numbers(self, numbers: Array, rng: np.random.Generator, tries: int = 100) -> Array:
        """Return valid numbers (count, p) from the priors, within bounds; numbers without priors stay as they are."""
        drawn, first = np.array(numbers), sum(len(chart.columns) for chart in self.unknowns.charts)
        for prior, place in zip(self.priors, self._places, strict=True):
            column = place[0] - first
            if len(place) == 1 and 0 <= column < numbers.shape[1]:
                drawn[:, column] = prior.mean + prior.sigma * rng.normal(size=len(numbers))
        if self.bounds is not None:
            low, high = (each[first : first + numbers.shape[1]] for each in self.bounds)
            drawn = np.clip(drawn, low, high)
        invalid = [i for i, row in enumerate(drawn) if not self.unknowns.are_valid(row)]
        if invalid:
            if tries == 0:
                rule = "priors must allow numbers that the system accepts"
                raise ValueError(f"{rule}, but it accepts none of 100 draws. Give narrower priors.")
            drawn[invalid] = self.drawn_numbers(numbers[invalid], rng, tries - 1)
        return drawn
