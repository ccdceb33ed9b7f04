"""Relaxation of a tumbling elastic body by internal dissipation, averaged over the free rotation."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipj, ellipk
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_array, real_numbers, refuse_nonpositive
from poinsot.immutable import cached_property
from poinsot.mechanics.body import Body
from poinsot.quantities import Array

__all__ = ["InelasticRelaxation"]

PHASES_PER_PERIOD = 512
"""Number of phases of a period; consecutive harmonics of a motion near the separatrix have the ratio 0.82."""

MAX_SQUARED_MODULUS = 1 - 1.5e-10
"""Largest squared modulus, near the separatrix: functions of SciPy are accurate below 1 - 1e-10."""

PAIRS = ((1, 2), (2, 0), (0, 1))


class InelasticRelaxation(Summarized):
    """Averaged internal dissipation of a tumbling homogeneous elastic ellipsoid at constant angular momentum.

    The inertial forces of the free rotation strain the body, and each harmonic of the strain loses 2 pi / Q of its
    largest elastic energy in a cycle. The strain is the exact static strain of the ellipsoid with a stress-free surface
    (Breiter, Rozek and Vokrouhlicky 2012, MNRAS 427, 755). The angular momentum in space is constant, and the body
    evolves towards rotation about its short axis. Q is the same for all frequencies. Self-gravity is not included: it
    only loads the body at rest.

    Parameters
    ----------
    body : Body
        Homogeneous ellipsoid made by `Body.from_ellipsoid`.
    rigidity : float
        Shear modulus, mass / (length time^2).
    quality_factor : float
        Quality factor Q.
    poisson_ratio : float
        Poisson ratio, from -1 to below 1/2.

    Raises
    ------
    ValueError
        If the body is not an ellipsoid or is a sphere, or a number is out of its range.

    Examples
    --------
    >>> asteroid = pt.Body.from_ellipsoid(8e11, (600.0, 500.0, 400.0))
    >>> relaxation = pt.analysis.InelasticRelaxation(asteroid, rigidity=1e9, quality_factor=100)
    >>> round(float(relaxation.damping_time(2 * np.pi / 36000)) / 3.15576e13, 1)  # 10 hours; million years
    11.1
    """

    @checked
    def __init__(self, body: Body, rigidity: float, quality_factor: float, poisson_ratio: float = 0.25) -> None:
        self.body = body
        self.rigidity = float(real_array("rigidity", rigidity, ()))
        self.quality_factor = float(real_array("quality_factor", quality_factor, ()))
        self.poisson_ratio = float(real_array("poisson_ratio", poisson_ratio, ()))
        refuse_nonpositive("rigidity", self.rigidity)
        refuse_nonpositive("quality_factor", self.quality_factor)
        if not -1 < self.poisson_ratio < 0.5:
            raise ValueError(f"poisson_ratio must be from -1 to below 1/2, got {self.poisson_ratio:g}.")
        if np.shape(body.semiaxes) != (3,) or np.ndim(body.moments) != 1:
            raise ValueError("body must be one ellipsoid, got another body. Take Body.from_ellipsoid(mass, semiaxes).")
        order = np.argsort(body.moments)
        self._moments: Array = np.asarray(body.moments)[order]
        if self._moments[0] == self._moments[2]:
            raise ValueError("body must not be a sphere, got three equal moments. A sphere does not tumble.")
        self._axes: Array = np.asarray(body.semiaxes, dtype=float)[order]

    def power(self, angular_momentum: ArrayLike, dynamic_moment: ArrayLike) -> Array:
        """Return the mean loss of energy per unit of time.

        Parameters
        ----------
        angular_momentum : float or array
            Magnitude G of the angular momentum.
        dynamic_moment : float or array
            Dynamic moment G^2 / (2 T), between the smallest and the largest moment, as in `FreeRotation`.
        """
        given = {"angular_momentum": angular_momentum, "dynamic_moment": dynamic_moment}
        G, J = np.broadcast_arrays(*(real_numbers(name, x) for name, x in given.items()))
        low, _, high = self._moments
        if not np.all((low <= J) & (high >= J)):
            raise ValueError(f"dynamic_moment must be from {low:g} to {high:g}, got {J.tolist()}.")
        omega, period = _free_rates(self._moments, J)
        products = [*(x * x for x in omega), *(omega[i] * omega[j] for i, j in PAIRS)]
        harmonics = np.fft.rfft(np.stack(products), axis=-1) / PHASES_PER_PERIOD
        energies = np.einsum("i...k,ij,j...k->...k", harmonics.conj(), self._compliance, harmonics).real
        losses = energies @ np.arange(PHASES_PER_PERIOD // 2 + 1)
        return np.asarray(G**5 * (4 * np.pi / self.quality_factor) * losses / period)

    @checked
    def damping_time(self, rate: ArrayLike) -> Array:
        """Return the time in which a small nutation about the short axis decays by the factor e.

        The time is D rigidity Q / (density a^2 rate^3) with the large semiaxis a (Burns and Safronov 1973, MNRAS 165,
        403). D is 7.7 for c / a = 0.9 and 18 for 0.5. Published values of D differ by factors of ten.

        Parameters
        ----------
        rate : float or array
            Angular velocity about the short axis, radians per unit of time.
        """
        A, B, C = self._moments
        spring = self._compliance[4, 4] / (A * (C - A)) + self._compliance[3, 3] / (B * (C - B))
        wobble = np.sqrt((C - A) * (C - B) / (A * B))
        return np.asarray(2 * self.quality_factor / (C * wobble * spring) / real_numbers("rate", rate) ** 3)

    def rates(self, state: Mapping[str, float]) -> dict[str, float]:
        """Return the rate of change of "dynamic_moment", for a secular evolution with other averaged effects.

        Parameters
        ----------
        state : mapping
            Values of "dynamic_moment" and of "rate", the angular momentum divided by the largest moment, which is the
            angular velocity after the tumbling has ended.
        """
        G, J = state["rate"] * self._moments[2], np.clip(state["dynamic_moment"], self._moments[0], self._moments[2])
        return {"dynamic_moment": float(2 * J * J / G**2 * self.power(G, J))}

    @cached_property
    def _compliance(self) -> Array:
        """Matrix C of the energy f.C f / 2, f the squares and products (w2 w3, w3 w1, w1 w2) of rates, axes sorted."""
        a = self._axes
        mass = 2.5 * np.sum(self._moments) / np.sum(a * a)
        density = mass / (4 / 3 * np.pi * np.prod(a))
        stiffness, loads = _elasticity(a, self.poisson_ratio)
        return np.asarray(density**2 / self.rigidity * (loads.T @ np.linalg.solve(stiffness, loads)))

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"InelasticRelaxation of {self.body!r}", {
            "rigidity": formatted(self.rigidity),
            "quality factor": formatted(self.quality_factor),
            "Poisson's ratio": formatted(self.poisson_ratio),
        }


def _free_rates(moments: Array, J: Array) -> tuple[list[Array], Array]:
    """Return the three rates at equal steps of a period, shape (..., PHASES), and the period, for G = 1.

    About the long axis the roles of the largest and the smallest moment are exchanged.
    """
    is_long = moments[1] > J
    A, B, C = (np.where(is_long, moments[2 - i], moments[i]) for i in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        across, along = np.abs(C / J - 1), np.abs(1 - A / J)  # |2 T C - G^2| and |G^2 - 2 T A|
        m = np.minimum(
            np.where((across > 0) & (A != B), np.abs(B - A) * across / (np.abs(C - B) * along), 0.0),
            MAX_SQUARED_MODULUS,
        )
        quarter = ellipk(m)
        period = 4 * quarter * np.sqrt(A * B * C / (np.abs(C - B) * along))
        phase = 4 * quarter[..., None] * (np.arange(PHASES_PER_PERIOD) / PHASES_PER_PERIOD)
        sn, cn, dn, _ = ellipj(phase, m[..., None])
        first = np.sqrt(across / (A * np.abs(C - A)))[..., None] * cn
        middle = np.sqrt(np.where(across > 0, across / (B * np.abs(C - B)), 0.0))[..., None] * sn
        third = np.sqrt(along / (C * np.abs(C - A)))[..., None] * dn
    swap = is_long[..., None]
    return [np.where(swap, third, first), middle, np.where(swap, first, third)], period


# ---------------------------------------------------------------------- statics of an elastic ellipsoid

ODD = tuple(p for p in itertools.product(range(4), repeat=3) if sum(p) in (1, 3))
"""Powers of coordinates over semiaxes in a displacement: linear forces make it cubic."""


def _elasticity(a: Array, poisson_ratio: float) -> tuple[Array, Array]:
    """Return stiffness (n, n) and loads (n, 6) of displacements e_i x^p, of unit rigidity and density.

    The force on a unit of mass is -A x with A = [omega'] + omega omega^T - omega^2, where by Euler's equations
    A_ij = 2 a_i^2 / (a_i^2 + a_j^2) omega_i omega_j off the diagonal: such forces do not turn the body.
    """
    modes = [(i, power) for i in range(3) for power in ODD]
    gradients = [{(i, j): (power[j] / a[j], _lowered(power, j)) for j in range(3) if power[j]} for i, power in modes]
    lame = 2 * poisson_ratio / (1 - 2 * poisson_ratio)
    stiffness = np.array([[_work(left, right, lame, a) for right in gradients] for left in gradients])
    turns = np.array([[_mean_turn(gradient, pair, a) for gradient in gradients] for pair in PAIRS])
    loads = np.zeros((len(modes), 6))
    for number, (i, power) in enumerate(modes):
        for j in range(3):
            moment = a[j] * _integral(_raised(power, j), a)
            if i == j:  # omega_k^2 of both other axes
                loads[number, [k for k in range(3) if k != i]] += moment
            else:
                loads[number, 6 - i - j] -= 2 * a[i] ** 2 / (a[i] ** 2 + a[j] ** 2) * moment
    return stiffness + turns.T @ turns, loads  # without the second term a turn of the whole body has no stiffness


def _work(left: Any, right: Any, lame: float, a: Array) -> float:
    """Return the integral of lame tr e tr e' + 2 e : e', symmetric strains of two gradients of displacements."""
    total = 0.0
    for (i, j), (factor, power) in left.items():
        for (k, l), (other, raised) in right.items():
            weight = lame * (i == j and k == l) + (i == k and j == l) + (i == l and j == k)
            if weight:
                total += weight * factor * other * _integral(tuple(np.add(power, raised)), a)
    return total


def _mean_turn(gradient: Any, pair: tuple[int, int], a: Array) -> float:
    """Return the integral of du_i/dx_j - du_j/dx_i."""
    i, j = pair
    signs = ((1.0, (i, j)), (-1.0, (j, i)))
    return float(sum(sign * gradient[p][0] * _integral(gradient[p][1], a) for sign, p in signs if p in gradient))


def _integral(power: tuple[int, ...], a: Array) -> float:
    """Return the integral of a product of powers of x/a, y/b, z/c over the ellipsoid."""
    if any(p % 2 for p in power):
        return 0.0
    odd = math.prod(math.prod(range(1, p, 2)) for p in power)
    degree = sum(power)
    return float(4 * np.pi * np.prod(a) * odd / (math.prod(range(1, degree + 2, 2)) * (degree + 3)))


def _lowered(power: tuple[int, ...], j: int) -> tuple[int, ...]:
    return tuple(p - (i == j) for i, p in enumerate(power))


def _raised(power: tuple[int, ...], j: int) -> tuple[int, ...]:
    return tuple(p + (i == j) for i, p in enumerate(power))
