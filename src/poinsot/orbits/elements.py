"""Osculating elements of the two-body orbit through a position and velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_numbers, reals_or_nan, refuse_nonpositive
from poinsot.orbits.from_cartesian import orbit_points
from poinsot.quantities import Real

__all__ = ["OsculatingElements", "osculating_elements"]


@dataclass(frozen=True, repr=False, eq=False)
class OsculatingElements(Summarized):
    """Osculating elements of two-body orbits; arrays with the shape of the states, angles in radians.

    Attributes
    ----------
    mu : float
        Gravitational parameter, in length^3 / time^2.
    semimajor_axis : array
        Semimajor axis, in length; negative for a hyperbola.
    eccentricity, inclination, node, argument_of_periapsis, true_anomaly : array
        Elements as in `KeplerOrbit`. The angles are in (-pi, pi], except the argument of periapsis, which is computed
        as the argument of latitude minus the true anomaly.

    Examples
    --------
    >>> found = pt.orbits.osculating_elements(1.0, position=(2, 0, 0), velocity=(0, 0.5, 0))
    >>> found.semimajor_axis.round(4), found.eccentricity.round(4), found.true_anomaly.round(4)
    (np.float64(1.3333), np.float64(0.5), np.float64(3.1416))
    """

    mu: Any
    semimajor_axis: Any
    eccentricity: Any
    inclination: Any
    node: Any
    argument_of_periapsis: Any
    true_anomaly: Any

    @property
    def longitude_of_periapsis(self) -> Any:
        """Node plus argument of periapsis, well defined at small inclinations; in (-pi, pi]."""
        return np.pi - np.mod(np.pi - self.node - self.argument_of_periapsis, 2 * np.pi)

    @property
    def period(self) -> Any:
        """Period of the osculating ellipse; NaN for other orbits."""
        with np.errstate(invalid="ignore"):
            return 2 * np.pi * np.sqrt(self.semimajor_axis**3 / self.mu)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return "Osculating elements", {
            "semimajor axis": formatted(self.semimajor_axis),
            "eccentricity": formatted(self.eccentricity),
            "inclination": formatted(self.inclination, "rad"),
            "node": formatted(self.node, "rad"),
            "argument of periapsis": formatted(self.argument_of_periapsis, "rad"),
            "true anomaly": formatted(self.true_anomaly, "rad"),
        }


@checked
def osculating_elements(mu: Real, *, position: ArrayLike, velocity: ArrayLike) -> OsculatingElements:
    """Return the osculating elements of two-body orbits from positions and velocities.

    Parameters
    ----------
    mu : float or array
        Gravitational parameter, in length^3 / time^2.
    position, velocity : array (..., 3), space axes
        Position in length and velocity in length per time relative to the attractor. A row with only NaN, as of an
        ensemble member that stopped, gives NaN.

    Returns
    -------
    OsculatingElements
        Elements with the shape (...), angles in radians.

    Raises
    ------
    ValueError
        If another number is infinite or NaN.

    Examples
    --------
    >>> times = np.linspace(0, 3, 4)
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.3, node=0.4, inclination=0.1)
    >>> place, speed = (np.stack(at(times), axis=-1) for at in (orbit.position_at, orbit.velocity_at))
    >>> pt.orbits.osculating_elements(1.0, position=place, velocity=speed).eccentricity.round(12)
    array([0.3, 0.3, 0.3, 0.3])
    """
    parameter, place, speed = (
        real_numbers("mu", mu),
        reals_or_nan("position", position),
        reals_or_nan("velocity", velocity),
    )
    refuse_nonpositive("mu", parameter)
    rows = {"position": place, "velocity": speed}
    for name, vectors in rows.items():
        if vectors.shape[-1:] != (3,):
            raise ValueError(f"{name} must have shape (..., 3), got shape {vectors.shape}.")
    is_absent = np.asarray(np.isnan(place).all(axis=-1) & np.isnan(speed).all(axis=-1))
    for name, vectors in rows.items():
        real_numbers(name, np.where(is_absent[..., None], 0.0, vectors))
    with np.errstate(invalid="ignore", divide="ignore"):
        here = orbit_points(parameter, place, speed)
        anomaly = np.arctan2(here.e_sin, here.e_cos)
        argument = here.latitude - anomaly
        axis = -here.mu / (2 * here.energy)
    return OsculatingElements(here.mu, axis, here.eccentricity, here.inclination, here.node, argument, anomaly)
