"""Two-body orbit of any eccentricity from position and velocity."""

from __future__ import annotations

from numpy.typing import ArrayLike

from poinsot.checked import checked
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.from_cartesian import orbit_point
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.quantities import Time

__all__ = ["two_body_orbit"]


@checked
def two_body_orbit(
    mu: float, *, position: ArrayLike, velocity: ArrayLike, epoch: Time = 0.0, radius: float = 0.0
) -> KeplerOrbit | EscapeOrbit:
    """Return the orbit through a position and velocity: an ellipse, a parabola or a hyperbola.

    Parameters
    ----------
    mu : float
        Gravitational parameter of the attractor, in length^3 / time^2.
    position, velocity : array (3,), space axes
        Position in length and velocity in length per time of the body relative to the attractor.
    epoch : float
        Time of the position and velocity.
    radius : float
        Radius of the attractor's surface, in length. A periapsis below it causes a warning with the depth. 0: a point.

    Returns
    -------
    KeplerOrbit or EscapeOrbit
        An ellipse if the energy is negative, otherwise a parabola or hyperbola.

    Raises
    ------
    ValueError
        If `mu` is not positive, the position is zero, the two vectors are parallel or the radius is negative.

    Examples
    --------
    >>> orbit = pt.orbits.two_body_orbit(1.0, position=(1, 0, 0), velocity=(0, 1.5, 0))
    >>> type(orbit).__name__, float(orbit.eccentricity)
    ('EscapeOrbit', 1.25)
    """
    kind = KeplerOrbit if orbit_point(mu, position, velocity).energy < 0 else EscapeOrbit
    return kind.from_vectors(mu, position=position, velocity=velocity, epoch=epoch, radius=radius)
