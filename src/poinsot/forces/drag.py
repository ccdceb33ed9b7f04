"""Drag of thin air on the facets of a body."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from poinsot import functions
from poinsot.forces.atmosphere import Atmosphere
from poinsot.forces.directional_torque import DirectionalTorque
from poinsot.forces.facets import ORDINARY_DRAG, Facets
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.parameters import NotNegative

__all__ = ["AtmosphericDrag", "MeshDrag"]


class AtmosphericDrag(Torque):
    """The torque of air on facets, in free molecular flow much faster than the molecules themselves.

    F_i = -rho/2 C_i A_i c (a_i v + 2 (1 - a_i) c n_i) at the position of facet i, c = max(0, n_i . v), v the velocity
    relative to the air, C the drag coefficient, a the accommodation: drag along v, and lift by the molecules that are
    reflected as from a mirror (Maxwell 1879, Phil. Trans. R. Soc. 170, 231). The temperature of the air, the velocity
    of facets by the rotation of the body, and shades are left out.

    Parameters
    ----------
    orbit : Orbit
        Where the body is, about the planet of the air.
    atmosphere : Atmosphere
    facets : Facets

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(3.986004418e14, semimajor_axis=6.778e6, eccentricity=0.0)  # m, s
    >>> air = pt.forces.ExponentialAtmosphere(3.7e-12, 6.778e6, 5.8e4)
    >>> plate = pt.forces.Facets([1.0], [(0, 1, 0)], [(0.1, 0, 0)])
    >>> system = pt.System(pt.Body((1, 1, 1)), pt.forces.AtmosphericDrag(orbit, air, plate))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(7)
    array([ 0.00e+00,  0.00e+00, -2.39e-05])
    """

    formula = (
        "N = -(rho/2*norm(w)**2*sum(drag[i]*areas[i]*c[i]*(cross(positions[i], accommodation[i]*e + "
        "2*(1 - accommodation[i])*c[i]*normals[i])), i)); c[i] = max(0, dot(normals[i], e)); e = w/norm(w)"
    )
    orbit: Orbit
    atmosphere: Atmosphere
    facets: Facets

    @override
    def torque(self, instant: Instant) -> Any:
        facets, velocity = self.facets, self.atmosphere.relative_velocity(instant, self.orbit)
        pairs = list(zip(facets.drag, facets.accommodation, strict=True))
        along, mirrored = [drag * part for drag, part in pairs], [2 * drag * (1 - part) for drag, part in pairs]
        density = self.atmosphere.density(instant, self.orbit)
        return facets.torque(velocity, along, [0.0] * facets.count, mirrored) * (0.5 * density)


class MeshDrag(Torque):
    """The torque of air on a mesh, through a smooth field: a run costs the same for any number of faces.

    tau = rho/2 C v^2 T(v / |v|), v the velocity relative to the air along the body axes: that of `AtmosphericDrag` on
    all faces with one drag coefficient C and full accommodation, and with shadows if the field has them.

    Parameters
    ----------
    orbit : Orbit
        Where the body is, about the planet of the air.
    atmosphere : Atmosphere
    field : DirectionalTorque
        T, such as `DirectionalTorque.of_stream(mesh, degree)`.
    coefficient : float
        C, not negative.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(3.986004418e14, semimajor_axis=6.778e6, eccentricity=0.0)  # m, s
    >>> air = pt.forces.ExponentialAtmosphere(3.7e-12, 6.778e6, 5.8e4)
    >>> field = pt.forces.DirectionalTorque(1, [(0, 0, 0, 0), (0, 0, 0, 0), (0, 0.1, 0, 0)])
    >>> system = pt.System(pt.Body((1, 1, 1)), pt.forces.MeshDrag(orbit, air, field))
    >>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))).round(7)
    array([0.00e+00, 0.00e+00, 4.15e-05])
    """

    formula = "N = rho/2*coefficient*norm(w)**2*T(w/norm(w))"
    orbit: Orbit
    atmosphere: Atmosphere
    field: DirectionalTorque
    coefficient: NotNegative = ORDINARY_DRAG

    @override
    def torque(self, instant: Instant) -> Any:
        velocity = self.atmosphere.relative_velocity(instant, self.orbit)
        speed = functions.norm(velocity)
        pressure = 0.5 * self.coefficient * self.atmosphere.density(instant, self.orbit) * (speed * speed)
        return self.field.torque(velocity / speed) * pressure
