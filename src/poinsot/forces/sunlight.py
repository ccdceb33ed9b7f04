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
from poinsot.records.parameters import NotNegative, Positive
from poinsot.shapes.mesh import Mesh

__all__ = ["MeshRadiation", "Yorp"]


class MeshRadiation(Sunlight):
    """Torque of sunlight on a mesh through a fitted series, at a cost independent of the number of faces.

    tau = pressure (distance / r)^2 T(u), with u the direction to the Sun along the body axes and r the distance to the
    Sun, times the visible fraction of the Sun's disc as in `RadiationPressure`.

    Parameters
    ----------
    field : DirectionalTorque
        Series T in length^3, such as `DirectionalTorque.of_stream(mesh, degree, specular=0.1, diffuse=0.2)`.

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
    """YORP torque: recoil of the light that an asteroid emits at once and diffusely, through a fitted series.

    tau = -2/3 P sum of A max(0, n.s) r x n over the faces, with s the direction to the Sun (Rubincam 2000, Icarus 148,
    2). Without thermal inertia the torque does not depend on the albedo. The model ignores the pressure of the incident
    light, whose mean over rotation and orbit is zero, light exchanged between faces, and roughness within a face.

    Parameters
    ----------
    field : DirectionalTorque
        Series `DirectionalTorque.of_emission(mesh, degree)`, in length^3; `Yorp.from_mesh` computes it.

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
        """Return the YORP torque on a mesh, whose axes are the body axes.

        Parameters
        ----------
        mesh : Mesh
            Closed surface, with lengths in the unit of the pressure: m for N/m^2.
        degree : int
            Degree of the fitted series, from 0 to 32. Its `maximum_error` and `rms_error` give the residual of the fit.
        shadows : bool
            True if a face is dark when another face shadows its centroid.

        Returns
        -------
        Yorp
            The torque with the fitted series.
        """
        field = DirectionalTorque.of_emission(mesh, degree, shadows=shadows)
        return cls(sun, field, tuple(occulters), pressure, distance, sun_radius)
