"""Tides with a constant time lag, on a given orbit and of two bodies, and damped librations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import real_numbers
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Load, PairLoad, Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.two_bodies import BODIES, GRAVITATIONAL_CONSTANT, check_name_of_body
from poinsot.records.parameters import NotNegative, Positive

__all__ = ["LibrationDamping", "TidalFriction", "TidalTorque", "pseudo_synchronous_rate"]


def _slip(r: Vector, v: Vector, omega: Vector) -> Vector:
    """Return the velocity of the other body in the axes of the body, which rotates with omega."""
    return v - functions.cross(omega, r)


def _across(tide: Any, strength: Scalar, inverse_square: Scalar) -> Scalar:
    """Return the friction of a tide per slip across r, 3 k2 G m^2 R^5 dt / r^8, where the strength is G m^2."""
    bulge = 3 * tide.love_number * strength * tide.radius**5 * tide.time_lag
    value: Scalar = bulge * (inverse_square * inverse_square) * (inverse_square * inverse_square)
    return value


class TidalTorque(Torque):
    """Tidal torque of the attractor of a given orbit, with a constant time lag.

    tau = K / r^8 (x x v - r^2 omega + (x.omega) x), K = 3 k2 G m^2 R^5 dt, with x and v the position and velocity of
    the body, and m = mu / G (Mignard 1979, Moon and Planets 20, 301). The tide does not change the orbit;
    `TidalFriction` also includes the force on the orbit. The bulge without lag exerts no torque. `CreepingTide` models
    the lag of a Maxwell body.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the attractor that raises the tide, with the attractor's `mu`.
    love_number : float
        Love number k2 of the body.
    radius : float
        Radius R of the body, in the unit of length of the orbit.
    time_lag : float
        Time lag dt of the bulge; about 1 / (Q w) for a quality factor Q at the tidal frequency w.
    G : float
        Gravitational constant in the units of moments and orbit. Default: the SI value. For moments per unit of mass,
        pass the gravitational parameter of the body.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> tide = pt.forces.TidalTorque(orbit, love_number=0.5, radius=0.2, time_lag=0.1, G=1e-3)
    >>> system = pt.System(pt.Body((0.4, 0.4, 0.4)), tide)
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 2))).round(6)
    array([ 0.   ,  0.   , -0.048])
    """

    formula = "N = K/r**8*(cross(x, v) - r**2*omega + (dot(x, omega))*x); K = 3*love_number*mu**2/G*radius**5*time_lag"
    orbit: Orbit
    love_number: NotNegative
    radius: Positive
    time_lag: NotNegative
    G: Positive = GRAVITATIONAL_CONSTANT

    @override
    def torque(self, instant: Instant) -> Vector:
        to_body, inverse = instant.attitude.to_body, instant.inverse_distance(self.orbit)
        r, v = to_body(instant.position(self.orbit)), to_body(instant.velocity(self.orbit))
        across = _across(self, self.orbit.mu * self.orbit.mu / self.G, inverse * inverse)
        return Vector(functions.cross(r, _slip(r, v, instant.omega_body)) * across)


@checked
def pseudo_synchronous_rate(eccentricity: ArrayLike) -> NDArray[np.float64]:
    """Return the pseudo-synchronous rotation rate in an eccentric orbit, in units of the mean motion.

    (1 + 15/2 e^2 + 45/8 e^4 + 5/16 e^6) / ((1 - e^2)^(3/2) (1 + 3 e^2 + 3/8 e^4)) (Hut 1981, Astron. Astrophys. 99,
    126, eq. (42)). At this rate the mean torque of a tide with a constant time lag vanishes, for zero obliquity and no
    permanent deformation.

    Parameters
    ----------
    eccentricity : float or array
        Eccentricity of the orbit, from 0 to below 1.

    Returns
    -------
    float or array
        Rotation rate divided by the mean motion, with the shape of the eccentricity.

    Raises
    ------
    ValueError
        If an eccentricity is not in [0, 1).

    Examples
    --------
    >>> float(pt.forces.pseudo_synchronous_rate(0.2).round(4))
    1.2419
    """
    e = real_numbers("eccentricity", eccentricity)
    if not np.all((e >= 0) & (e < 1)):
        raise ValueError(
            f"eccentricity must be from 0 to below 1, got {e.tolist()}. The mean exists for ellipses only."
        )
    x = e * e
    turning = 1 + x * (15 / 2 + x * (45 / 8 + x * (5 / 16)))
    return np.asarray(turning / ((1 - x) ** 1.5 * (1 + x * (3 + x * (3 / 8)))))


class Friction(PairLoad):
    """Friction in one of two bodies: a force along the motion of the separation in the axes of the body.

    The force on the secondary and the torque on the body result from one internal force, which conserves the angular
    momentum of the pair.
    """

    body: str

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name_of_body(self.body)

    def _load(self, instant: Any, across: Any, along: Any) -> Load:
        """Return the load of a force -across (v - omega x r) - along (r.v) r, where v and r are of the separation."""
        each = getattr(instant, self.body)
        r, v = instant.separation, instant.relative_velocity
        omega = each.attitude.to_space(each.omega_body)
        force = -across * _slip(r, v, omega) - along * functions.dot(r, v) * r
        torque = each.attitude.to_body(-functions.cross(r, force))
        nothing = Vector((0.0, 0.0, 0.0))
        return Load(force, (torque, nothing) if self.body == BODIES[0] else (nothing, torque))


class TidalFriction(Friction):
    """Tidal friction between two bodies, with a constant time lag of the tide in one of them.

    F = -3 K dt / r^10 [2 r (r.v) + r^2 (v - omega x r)] acts on the secondary and -r x F on the body. Here r is the
    separation, v its rate of change, omega the angular velocity of the body and K = k2 G m^2 R^5, with m the mass of
    the second body (Mignard 1979, Moon and Planets 20, 301). The dissipated power is 3 K dt / r^10 [2 (r.v)^2 + r^2 |v
    - omega x r|^2], and the angular momentum of the pair is conserved. The model ignores the bulge without lag, which
    has the energy -K / (2 r^6).

    Parameters
    ----------
    body : {"primary", "secondary"}
        Body with the tide. Two forces describe tides in both bodies.
    love_number : float
        Love number k2 of the body.
    radius : float
        Radius R of the body, in the unit of the separation.
    time_lag : float
        Time lag dt of the bulge; about 1 / (Q w) for a quality factor Q at the tidal frequency w.

    Raises
    ------
    ValueError
        If the body is neither of the two, the radius is not positive, or another number is negative.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> tide = pt.forces.TidalFriction("secondary", love_number=0.1, radius=1.0, time_lag=0.01)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity(), tide)
    >>> [integral.symbol for integral in system.integrals]
    ['G1', 'G2', 'G3']
    """

    formula = (
        "F = -(K/r**8*(v - cross(omega, x) + 2*(dot(x, v))/r**2*x)); N = -cross(x, F); "
        "K = 3*love_number*G*m**2*radius**5*time_lag"
    )
    love_number: NotNegative
    radius: Positive
    time_lag: NotNegative

    @override
    def load(self, instant: Any) -> Load:
        masses = instant.pair.each_mass
        other = masses[1 - BODIES.index(self.body)]
        inverse = 1 / functions.dot(instant.separation, instant.separation)
        across = _across(self, instant.pair.G * (other * other), inverse)
        return self._load(instant, across, 2 * across * inverse)


class LibrationDamping(Friction):
    """Damping torque on one of two bodies against its rotation relative to the line of centres.

    tau = -coefficient (omega - r x v / r^2) without its component along r. The opposite torque acts on the orbit
    through a force across r, and the angular momentum of the pair is conserved. Rotation about the line of centres is
    not damped, because no force at the second body can damp it.

    Parameters
    ----------
    body : {"primary", "secondary"}
        Body on which the torque acts.
    coefficient : float
        Torque per angular velocity, not negative.

    Raises
    ------
    ValueError
        If the body is neither of the two, or the coefficient is negative.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.LibrationDamping("secondary", 0.1))
    >>> start = system.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0), (0.5, 0, 2.5)])
    >>> float(system.torque_body(start, body="secondary")[2])
    -0.2
    """

    formula = "F = -(coefficient/r**2*(v - cross(omega, x) - dot(x, v)/r**2*x)); N = -cross(x, F)"
    coefficient: NotNegative

    @override
    def load(self, instant: Any) -> Load:
        inverse = 1 / functions.dot(instant.separation, instant.separation)
        across = self.coefficient * inverse
        return self._load(instant, across, -across * inverse)
