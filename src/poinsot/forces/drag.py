"""Atmospheric drag on facets and meshes."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from poinsot import functions
from poinsot.forces.atmosphere import Atmosphere
from poinsot.forces.directional_torque import DirectionalTorque
from poinsot.forces.facets import PLATE_DRAG_COEFFICIENT, Facets
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.records.parameters import NotNegative

__all__ = ["AtmosphericDrag", "MeshDrag"]


class AtmosphericDrag(Torque):
    """Torque of the atmosphere on facets, in free molecular flow with a speed far above the thermal speed.

    F_i = -rho/2 C_i A_i c (a_i v + 2 (1 - a_i) c n_i) acts at the position of facet i, with c = max(0, n_i . v). Here v
    is the velocity relative to the air, rho the density, A the area, n the normal, C the drag coefficient and a the
    accommodation. The first term is drag along v; the second is lift from molecules that are reflected specularly
    (Maxwell 1879, Phil. Trans. R. Soc. 170, 231). The model ignores the temperature of the air, the velocity of facets
    due to the rotation of the body, and shadows.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the planet.
    atmosphere : Atmosphere
        Density and rotation of the air, in the units of the orbit.
    facets : Facets
        Areas, normals, positions and drag coefficients of the surface.

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
    """Torque of the atmosphere on a mesh through a fitted series, at a cost independent of the number of faces.

    tau = rho/2 C v^2 T(v / |v|), with v the velocity relative to the air along the body axes. The torque approximates
    `AtmosphericDrag` on all faces with one drag coefficient C and full accommodation. It includes shadows if the fit of
    T includes them.

    Parameters
    ----------
    orbit : Orbit
        Orbit of the body about the planet.
    atmosphere : Atmosphere
        Density and rotation of the air, in the units of the orbit.
    field : DirectionalTorque
        Series T in length^3, such as `DirectionalTorque.of_stream(mesh, degree)`.
    coefficient : float
        Drag coefficient C, not negative.

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
    coefficient: NotNegative = PLATE_DRAG_COEFFICIENT

    @override
    def torque(self, instant: Instant) -> Any:
        velocity = self.atmosphere.relative_velocity(instant, self.orbit)
        speed = functions.norm(velocity)
        pressure = 0.5 * self.coefficient * self.atmosphere.density(instant, self.orbit) * (speed * speed)
        return self.field.torque(velocity / speed) * pressure
