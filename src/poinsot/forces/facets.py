"""Flat facets of a surface under the pressure of light and air."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot import functions
from poinsot.checked import checked
from poinsot.errors import (
    array_of,
    real_array,
    refuse_negative,
    refuse_nonpositive,
    refuse_other_length,
    refuse_others_than_shares,
)
from poinsot.functions import Vector
from poinsot.quantities import OR_NUMBER, Along, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import ArrayLength, Parametric
from poinsot.shapes.mesh import Mesh

__all__ = ["PLATE_DRAG_COEFFICIENT", "Facets"]

PLATE_DRAG_COEFFICIENT = 2.2
"""Approximate drag coefficient of a flat plate in the upper atmosphere."""

CLOSURE_TOLERANCE = 1e-6
"""Largest sum of areas times normals of a closed surface, relative to the total area."""

SHARE_TOLERANCE = 1e-9
"""Largest excess over 1 of a sum of shares."""


Numbers = Annotated[Any, ("count",), Rule(refuse_negative)]
Shares = Annotated[Any, ("count",), OR_NUMBER, Rule(refuse_others_than_shares, "It is a share of what arrives.")]
EachOrAll = Annotated[ArrayLike, OR_NUMBER]


class Facets(Parametric):
    """Flat facets of a body's surface, on which radiation pressure and drag act.

    A stream acts only on the front side of a facet, to which the normal points. Facets do not shadow each other.

    Parameters
    ----------
    areas : array (n,)
        Areas, in length^2.
    normals : array (n, 3), body axes
        Outward unit normals.
    positions : array (n, 3), body axes
        Centres of pressure relative to the centre of mass, in the unit of length of the torque. They stay fixed in the
        body axes if a part moves the centre of mass.
    specular, diffuse : array (n,) or float
        Fractions of the light that are reflected specularly and diffusely. The facet absorbs the rest.
    drag : array (n,) or float
        Drag coefficients at normal incidence.
    accommodation : array (n,) or float
        Fraction of the molecules that leave diffusely and without momentum. The other molecules are reflected
        specularly.
    closed : bool
        True if the facets form the complete surface of a body, panels with both sides. The class checks this.

    Raises
    ------
    ValueError
        If an area is negative, a normal is not a unit vector, a fraction is outside [0, 1], specular and diffuse add up
        to more than 1, or facets declared as closed are not closed or point inwards.

    Examples
    --------
    >>> plate = pt.forces.Facets([2.0], [(0, 0, 1)], [(0.1, 0, 0)], specular=0.3, diffuse=0.1)
    >>> plate.count
    1
    """

    areas: Numbers
    normals: Annotated[Any, ("count", 3), Along("body axes"), Rule(refuse_other_length, "Divide by the length.")]
    positions: Annotated[Any, ("count", 3), Along("body axes")]
    specular: Shares = 0.0
    diffuse: Shares = 0.0
    drag: Annotated[Numbers, OR_NUMBER] = PLATE_DRAG_COEFFICIENT
    accommodation: Shares = 1.0
    closed: bool = False

    count = ArrayLength("areas", "Number of facets.")

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_shares()
        if self.closed:
            self._check_closed()

    @classmethod
    @checked
    def from_box(
        cls,
        sides: ArrayLike,
        position: Annotated[ArrayLike, (3,), Along("body axes")] = (0, 0, 0),
        *,
        wing_areas: ArrayLike = (),
        wing_normals: Annotated[ArrayLike, ("wings", 3), Along("body axes")] = (),
        wing_positions: Annotated[ArrayLike, ("wings", 3), Along("body axes")] = (),
        specular: EachOrAll = 0.0,
        diffuse: EachOrAll = 0.0,
        drag: EachOrAll = PLATE_DRAG_COEFFICIENT,
        accommodation: EachOrAll = 1.0,
    ) -> Facets:
        """Return the facets of a box along the body axes and of thin two-sided wings, such as solar panels.

        The order is +x, -x, +y, -y, +z, -z, then for each wing the side of its normal and the opposite side.

        Parameters
        ----------
        sides : array (3,)
            Full lengths of the box along the body axes.
        position : array (3,), body axes
            Centre of the box relative to the centre of mass.
        wing_areas : array (w,)
            Area of one side of each wing.
        wing_normals, wing_positions : array (w, 3), body axes
            Unit normal of each wing, and its centre relative to the centre of mass.
        specular, diffuse, drag, accommodation : array (6 + 2 w,) or float
            Surface properties as in `Facets`, for each facet or one number for all.

        Returns
        -------
        Facets
            The 6 + 2 w facets.
        """
        lengths, middle = real_array("sides", sides, (3,)), real_array("position", position, (3,))
        refuse_nonpositive("sides", lengths)
        directions = np.repeat(np.eye(3), 2, axis=0) * np.array([1, -1] * 3)[:, None]
        faces = np.repeat(np.prod(lengths) / lengths, 2)
        wings = real_array("wing_areas", wing_areas, (None,))
        normals, places = (
            real_array(name, value if array_of(name, value).size else np.zeros((0, 3)), (wings.size, 3))
            for name, value in (("wing_normals", wing_normals), ("wing_positions", wing_positions))
        )
        both = np.repeat(normals, 2, axis=0) * np.tile([1.0, -1.0], wings.size)[:, None]
        return cls(
            np.concatenate([faces, np.repeat(wings, 2)]),
            np.concatenate([directions, both]),
            np.concatenate([middle + 0.5 * lengths * directions, np.repeat(places, 2, axis=0)]),
            *(specular, diffuse, drag, accommodation),
            closed=True,
        )

    @classmethod
    @checked
    def from_mesh(
        cls,
        mesh: Mesh,
        *,
        specular: EachOrAll = 0.0,
        diffuse: EachOrAll = 0.0,
        drag: EachOrAll = PLATE_DRAG_COEFFICIENT,
        accommodation: EachOrAll = 1.0,
    ) -> Facets:
        """Return the faces of a mesh as facets, about the centre of mass and along the axes of `Body.from_shape`.

        Each facet adds a condition at which an integration stops when the facet turns into or out of the light. Tens of
        facets are fast, thousands are slow; `MeshRadiation` and `MeshDrag` handle large meshes.

        Parameters
        ----------
        mesh : Mesh
            Closed surface, with lengths in the unit of length of the torque.
        specular, diffuse, drag, accommodation : array (n,) or float
            Surface properties as in `Facets`, for each face or one number for all.

        Returns
        -------
        Facets
            One facet per face.
        """
        arms = mesh.face_centers - mesh.center_of_mass
        return cls(mesh.face_areas, mesh.face_normals, arms, specular, diffuse, drag, accommodation, closed=True)

    def joined(self, *others: Facets) -> Facets:
        """Combine these facets with other facets of the same body."""
        every = (self, *others)
        names = ("areas", "normals", "positions", "specular", "diffuse", "drag", "accommodation")
        fields: Any = {name: np.concatenate([getattr(x, name) for x in every], axis=_axis(name)) for name in names}
        return Facets(**fields, closed=all(one.closed for one in every))

    @of_scalars
    def torque(self, towards: Vector, along: Any, across: Any, mirrored: Any) -> Any:
        """Return the torque of a stream, the sum of r x F over the facets, along the body axes.

        F = -A c (along u + (across + mirrored c) n), c = max(0, n . u).

        Parameters
        ----------
        towards : Vector
            Unit vector u towards the source of the stream, along the body axes.
        along, across, mirrored : sequence of scalars
            Coefficients of each facet, in force per area.

        Returns
        -------
        Vector
            The torque along the body axes.
        """
        carried, total = Vector((0.0, 0.0, 0.0)), Vector((0.0, 0.0, 0.0))
        rows = zip(self.areas, self.normals, self.positions, along, across, mirrored, strict=True)
        for area, normal, position, own, plain, square in rows:
            facing = functions.maximum(0.0, functions.dot(normal, towards))
            carried = carried + Vector(position) * (area * own) * facing
            turning = functions.cross(position, normal) * area
            total = total + turning * (plain * facing) + turning * square * (facing * facing)
        return -functions.cross(carried, towards) - total

    def _check_shares(self) -> None:
        total = np.asarray(self.specular) + np.asarray(self.diffuse)
        if np.any(total > 1 + SHARE_TOLERANCE):
            place = np.unravel_index(np.argmax(total), total.shape)
            one, other = (np.broadcast_to(x, total.shape)[place] for x in (self.specular, self.diffuse))
            raise ValueError(
                f"specular and diffuse must add up to at most 1, got {one} + {other} of facet {place[-1]}. "
                "The rest is absorbed."
            )

    def _check_closed(self) -> None:
        weighted: NDArray[np.float64] = np.asarray(self.areas)[..., None] * self.normals
        whole = np.sum(self.areas, axis=-1)
        left = np.linalg.norm(np.sum(weighted, axis=-2), axis=-1)
        if np.any(left > CLOSURE_TOLERANCE * whole):
            raise ValueError(
                "normals must close: areas times normals of a closed surface add up to zero, got a vector of length "
                f"{np.max(left):.3g}. Is a facet inside out, or a side of a panel missing?"
            )
        # By the theorem of Gauss the sum of areas times normals times centroids is the volume times the unit tensor.
        tensor = np.swapaxes(weighted, -1, -2) @ self.positions
        volume, size = np.trace(tensor, axis1=-2, axis2=-1) / 3, np.max(np.abs(tensor), axis=(-2, -1))
        if np.any(volume < -CLOSURE_TOLERANCE * whole**1.5):
            raise ValueError(
                f"normals must point outwards, got a surface that encloses the volume {np.min(volume):.3g}. "
                "All are inside out."
            )
        uneven = np.max(np.abs(tensor - volume[..., None, None] * np.eye(3)), axis=(-2, -1))
        if np.any(uneven > CLOSURE_TOLERANCE * np.maximum(size, whole**1.5)):
            raise ValueError(
                "normals and positions must form a closed surface, got a volume that differs by direction by "
                f"{np.max(uneven):.3g}. Are two facets inside out, or is a position not the middle of its facet?"
            )


def _axis(name: str) -> int:
    return -2 if name in ("normals", "positions") else -1
