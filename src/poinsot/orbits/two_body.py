"""The two-body orbit of any kind from position and velocity."""

from __future__ import annotations

from numpy.typing import ArrayLike

from poinsot.checked import checked
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.from_cartesian import passage
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.quantities import Time

__all__ = ["two_body_orbit"]


@checked
def two_body_orbit(
    mu: float, *, position: ArrayLike, velocity: ArrayLike, epoch: Time = 0.0, radius: float = 0.0
) -> KeplerOrbit | EscapeOrbit:
    """Return the orbit through a position with a velocity: an ellipse, a parabola or a hyperbola.

    Parameters
    ----------
    mu : float
        Gravitational parameter of the attractor, length cubed over time squared.
    position, velocity : array (3,)
        Of the body relative to the attractor, space axes.
    epoch : float
        The time at which it is there.
    radius : float
        That of the attractor's surface, in the unit of length: a periapsis below it gives a warning with the depth.
        0: a point, never warned about.

    Returns
    -------
    KeplerOrbit
        If the energy is negative.
    EscapeOrbit
        Otherwise.

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
    kind = KeplerOrbit if passage(mu, position, velocity).energy < 0 else EscapeOrbit
    return kind.from_vectors(mu, position=position, velocity=velocity, epoch=epoch, radius=radius)
