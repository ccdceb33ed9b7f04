"""Sunlight on meshes of any number of faces: radiation pressure and YORP."""

from __future__ import annotations

from typing import Self

from typing_extensions import override

from poinsot.checked import checked
from poinsot.forces.directional_torque import DirectionalTorque
from poinsot.functions import Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.parameters import Positive
from poinsot.shapes.mesh import Mesh

__all__ = ["MeshRadiation", "Yorp"]

PRESSURE = 4.56e-6
ASTRONOMICAL_UNIT = 149597870700.0


class MeshRadiation(Torque):
    """Sunlight on a mesh, through a smooth field: a run costs the same for any number of faces.

    tau = pressure (distance / r)^2 T(u), where u is the direction to the Sun along the body axes and r its distance.
    The Sun is a point; there are no eclipses.

    Parameters
    ----------
    sun : Orbit
        Where the body is from the Sun.
    field : DirectionalTorque
        T, such as `DirectionalTorque.of_stream(mesh, degree, specular=0.1, diffuse=0.2)`.
    pressure : float
        Of light that is absorbed, at the distance; default: 4.56e-6 N/m^2.
    distance : float
        From the Sun, in the unit of the orbit; default: one astronomical unit in m.

    Raises
    ------
    ValueError
        If the pressure or the distance is not positive.

    Examples
    --------
    >>> sun = pt.orbits.FixedPosition(1.32712440018e20, position=(-1.495978707e11, 0, 0))
    >>> field = pt.forces.DirectionalTorque.of_stream(pt.shapes.Mesh.from_box((1, 2, 3), mass=10.0), degree=4)
    >>> pt.forces.MeshRadiation(sun, field).field.coefficients.any()  # a box has no torque
    np.False_
    """

    sun: Orbit
    field: DirectionalTorque
    pressure: Positive = PRESSURE
    distance: Positive = ASTRONOMICAL_UNIT

    @override
    def torque(self, instant: Instant) -> Vector:
        near = self.distance * instant.inverse_distance(self.sun)
        to_sun = instant.attitude.to_body(-instant.direction(self.sun))
        torque: Vector = self.field.torque(to_sun) * (self.pressure * (near * near))
        return torque


class Yorp(MeshRadiation):
    """The torque of the light that an asteroid sends back, at once and evenly from each face, through a smooth field.

    tau = -2/3 P sum of A max(0, n.s) r x n over the faces, s the direction to the Sun (Rubincam 2000, Icarus 148, 2):
    without thermal inertia, whatever share is reflected. The pressure of the light that arrives is left out: its mean
    over rotation and orbit is zero. So are eclipses, light from face to face, and roughness within a face.

    Parameters
    ----------
    sun : Orbit
        Where the body is from the Sun.
    field : DirectionalTorque
        `DirectionalTorque.of_emission(mesh, degree)`; `Yorp.from_mesh` makes it.
    pressure : float
        Of sunlight at the distance; default: 4.56e-6 N/m^2.
    distance : float
        From the Sun, in the unit of the orbit; default: one astronomical unit in m.

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
        pressure: float = PRESSURE,
        distance: float = ASTRONOMICAL_UNIT,
    ) -> Self:
        """Return the torque on a mesh, whose axes are those of the body.

        Parameters
        ----------
        sun : Orbit
            Where the body is from the Sun.
        mesh : Mesh
            Lengths as of the pressure: m for N/m^2.
        degree : int
            Of the smooth field, from 0 to 32; its `maximum_error` and `rms_error` say what it leaves out.
        shadows : bool
            Whether faces are dark whose centroids are in the shadow of others.
        pressure : float
            Of sunlight at the distance.
        distance : float
            From the Sun, in the unit of the orbit.
        """
        return cls(sun, DirectionalTorque.of_emission(mesh, degree, shadows=shadows), pressure, distance)
