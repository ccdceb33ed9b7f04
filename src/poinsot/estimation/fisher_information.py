"""Fisher information of planned measurements, and bounds of the errors of unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.estimation.null_directions import Determined, NullDirection, determined
from poinsot.estimation.priors import Posterior, Prior
from poinsot.estimation.unknowns import Arc, Unknowns, arcs_of
from poinsot.immutable import cached_property
from poinsot.kinematics.state import State
from poinsot.observables.readings import Readings
from poinsot.quantities import Array
from poinsot.systems.system import System

if TYPE_CHECKING:
    import xarray

__all__ = ["Information", "information"]


class Information(Summarized):
    """Fisher information of measurements about unknowns. The sum of two is the information of both together.

    Attributes
    ----------
    free : tuple of str
        Names of the unknowns.
    values : array (n,)
        Values of the unknowns at which the derivatives are taken; rotation vectors are zero.
    derivatives : array (m, n)
        Derivatives of whitened readings; factors and offsets of curves are eliminated.
    prior : array (n, n)
        Information of the priors.
    """

    def __init__(self, free: tuple[str, ...], values: Array, derivatives: Array, prior: Array) -> None:
        self.free, self.values, self.derivatives, self.prior = free, values, derivatives, prior

    def __add__(self, other: Information) -> Information:
        """Return the information of both measurements; priors count once.

        Raises
        ------
        ValueError
            If the unknowns, their values or the priors differ.
        """
        if not isinstance(other, Information):
            return NotImplemented
        for name in ("free", "values", "prior"):
            if not np.array_equal(getattr(self, name), getattr(other, name)):
                raise ValueError(
                    f"{name} must be the same in both terms of a sum, got others. Give the same arguments."
                )
        rows = np.concatenate([self.derivatives, other.derivatives])
        return Information(self.free, self.values, rows, self.prior)

    @property
    def matrix(self) -> xarray.DataArray:
        """Fisher information of the readings, without priors, (n, n), with the names of the unknowns on both axes."""
        import xarray

        names = {"unknown": list(self.free), "other": list(self.free)}
        return xarray.DataArray(self.derivatives.T @ self.derivatives, names, ("unknown", "other"))

    @cached_property
    def _determined(self) -> Determined:
        values, axes = np.linalg.eigh(self.prior)
        rows = axes.T * np.sqrt(np.maximum(values, 0.0))[:, None]
        return determined(np.concatenate([self.derivatives, rows[values > 0]]), self.free, self.values)

    @property
    def standard_deviations(self) -> dict[str, float]:
        """Cramer-Rao bounds of the standard deviations by name, with priors; infinite if they are not determined."""
        return dict(zip(self.free, self._determined.standard_deviations.tolist(), strict=True))

    @property
    def covariance(self) -> xarray.DataArray:
        """Cramer-Rao bound of the covariance, with priors, within the determined subspace; (n, n)."""
        return self.matrix.copy(data=self._determined.covariance)

    @property
    def null_directions(self) -> tuple[NullDirection, ...]:
        """Changes of the unknowns that change no reading."""
        return self._determined.null_directions

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        bounds = {f"sigma of {name}": formatted(sigma) for name, sigma in self.standard_deviations.items()}
        return f"Information about {len(self.free)} unknowns", bounds | {
            "not determined": "; ".join(each.text for each in self.null_directions)
        }


@checked
def information(
    system: System,
    state: State | None,
    data: Sequence[Readings | Arc],
    free: Sequence[str] = ("state",),
    *,
    priors: Sequence[Prior] = (),
) -> Information:
    """Return the Fisher information of measurements, whose values need not be known yet.

    Parameters
    ----------
    system, state, data, free, priors
        Same as in `fit`. Readings need times and standard deviations. The factor of a relative light curve makes the
        mean of the curve one.

    Returns
    -------
    Information
        Information at the given state and numbers, with Cramer-Rao bounds.

    Raises
    ------
    ValueError
        If an unknown does not exist, or readings have no standard deviation.

    Examples
    --------
    >>> body = pt.Body((0.4, 1.2, 1.5))
    >>> start = body.state((1, 0, 0, 0), angular_momentum_body=(0.36, 2.04, 1.2))
    >>> plan = pt.observables.Readings(pt.observables.Gyro(noise=0.02), np.linspace(0.1, 5.0, 40))
    >>> known = pt.estimation.information(pt.System(body), start, [plan], ["angular_momentum_body", "moments"])
    >>> [each.text for each in known.null_directions]
    ['angular momentum and moments by one common factor']
    """
    arcs, shared = arcs_of(data, free)
    unknowns = Unknowns(system, state, arcs, shared, is_plan=True)
    posterior, points = Posterior(unknowns, priors), unknowns.start()
    _, (derivatives,) = posterior.evaluated(points)
    count, curves = unknowns.data.size, len(unknowns.scales)
    n = len(unknowns.labels) - curves
    rows, prior = derivatives[:count], derivatives[count:, :n]
    if curves:
        q, _ = np.linalg.qr(rows[:, n:])
        left = rows[:, :n] - q @ (q.T @ rows[:, :n])
    else:
        left = rows
    return Information(unknowns.labels[:n], unknowns.values(points)[0, :n], left, prior.T @ prior)
