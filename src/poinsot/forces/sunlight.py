"""Sunlight on meshes of any number of faces: radiation pressure and YORP."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from typing_extensions import override

from poinsot.checked import checked
from poinsot.forces.directional_torque import DirectionalTorque
from poinsot.forces.radiation import ASTRONOMICAL_UNIT, PRESSURE, SUN_RADIUS, Occulter, Sunlight
from poinsot.functions import Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.parameters import NotNegative, Positive
from poinsot.shapes.mesh import Mesh

__all__ = ["MeshRadiation", "Yorp"]


class MeshRadiation(Sunlight):
    """Sunlight on a mesh, through a smooth field: a run costs the same for any number of faces.

    tau = pressure (distance / r)^2 T(u), where u is the direction to the Sun along the body axes and r its distance,
    times the part of the Sun's disc that is seen behind occulters, as of `RadiationPressure`.

    Parameters
    ----------
    sun : Orbit
        Where the body is from the Sun.
    field : DirectionalTorque
        T, such as `DirectionalTorque.of_stream(mesh, degree, specular=0.1, diffuse=0.2)`.
    occulters : sequence of Occulter
        Spheres nearer than the Sun.
    pressure : float
        On what absorbs all light, at the distance; default: 4.54e-6 N/m2, 1361 W/m2 over the speed of light.
    distance : float
        Default: the astronomical unit in metres. Other units of length need their own.
    sun_radius : float
        In the unit of `distance`; default: 6.957e8 metres.

    Raises
    ------
    ValueError
        If the pressure is negative, a length is not positive, or the body is inside the Sun.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.32712440018e20, position=(-1.495978707e11, 0, 0))
    >>> field = pt.forces.DirectionalTorque.of_stream(pt.shapes.Mesh.from_box((1, 2, 3), mass=10.0), degree=4)
    >>> pt.forces.MeshRadiation(sun, field).field.coefficients.any()  # a box has no torque
    np.False_
    """

    formula = "N = pressure*(distance/r)**2*f*T(-u)"
    sun: Orbit
    field: DirectionalTorque
    occulters: tuple[Occulter, ...] = ()
    pressure: NotNegative = PRESSURE
    distance: Positive = ASTRONOMICAL_UNIT
    sun_radius: Positive = SUN_RADIUS

    @override
    def _torque_from(self, towards: Vector) -> Vector:
        return self.field.torque(towards)


class Yorp(MeshRadiation):
    """The torque of the light that an asteroid sends back, at once and evenly from each face, through a smooth field.

    tau = -2/3 P sum of A max(0, n.s) r x n over the faces, s the direction to the Sun (Rubincam 2000, Icarus 148, 2):
    without thermal inertia, whatever share is reflected. The pressure of the light that arrives is left out: its mean
    over rotation and orbit is zero. So are light from face to face, and roughness within a face.

    Parameters
    ----------
    sun : Orbit
        Where the body is from the Sun.
    field : DirectionalTorque
        `DirectionalTorque.of_emission(mesh, degree)`; `Yorp.from_mesh` makes it.
    occulters, pressure, distance, sun_radius
        As of `MeshRadiation`.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.32712440018e20, position=(-1.495978707e11, 0, 0))
    >>> box = pt.shapes.Mesh.from_box((1, 2, 3), mass=10.0)
    >>> wedge = pt.shapes.Mesh(box.vertices + 0.2 * box.vertices[:, [1, 2, 0]] ** 3, box.faces, mass=10.0)
    >>> pt.forces.Yorp.from_mesh(sun, wedge, degree=6).field.degree
    6
    """

    @classmethod
    @checked
    def from_mesh(
        cls,
        sun: Orbit,
        mesh: Mesh,
        degree: int,
        *,
        shadows: bool = True,
        occulters: Sequence[Occulter] = (),
        pressure: float = PRESSURE,
        distance: float = ASTRONOMICAL_UNIT,
        sun_radius: float = SUN_RADIUS,
    ) -> Self:
        """Return the torque on a mesh, whose axes are those of the body.

        Parameters
        ----------
        sun : Orbit
            Where the body is from the Sun.
        mesh : Mesh
            Lengths as of the pressure: m for N/m^2.
        degree : int
            Of the smooth field, from 0 to 32; its `maximum_error` and `rms_error` are the errors of the truncation.
        shadows : bool
            Whether faces are dark whose centroids are in the shadow of others.
        occulters, pressure, distance, sun_radius
            As of `MeshRadiation`.
        """
        field = DirectionalTorque.of_emission(mesh, degree, shadows=shadows)
        return cls(sun, field, tuple(occulters), pressure, distance, sun_radius)
