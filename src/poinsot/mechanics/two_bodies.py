"""Two rigid bodies that attract each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from poinsot.checked import checked
from poinsot.errors import exactly_one, member_array
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.body import Body
from poinsot.mechanics.frame import Frame
from poinsot.mechanics.parameters import Parametric, Positive
from poinsot.mechanics.state import PairState
from poinsot.quantities import Times

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["BODIES", "GRAVITATIONAL_CONSTANT", "TwoBodies"]

Array = NDArray[np.float64]

BODIES = ("primary", "secondary")
"""The names of the two."""

GRAVITATIONAL_CONSTANT = 6.6743e-11
"""m^3 / (kg s^2), CODATA 2018."""


class TwoBodies(Parametric):
    """Two rigid bodies that attract each other, such as a binary asteroid.

    The secondary's position is that of its centre of mass from the primary's, along the space axes; the barycentre is
    dropped.

    Parameters
    ----------
    primary, secondary : Body
        Each with its mass: `Body(moments, mass=...)`, or a body made of a shape.
    G : float
        The constant of gravitation in the units of masses and moments; by default that of the SI.
    masses : array (2,) or (members, 2), optional
        By default those of the bodies.

    Raises
    ------
    ValueError
        If a body has no mass, or a mass or G is not positive.

    Examples
    --------
    >>> primary = pt.Body.from_ellipsoid(5.26e11, (394, 394, 290))
    >>> pt.TwoBodies(primary, pt.Body.from_ellipsoid(4.3e9, (87, 86, 58))).masses
    array([5.26e+11, 4.30e+09])
    """

    primary: Body
    secondary: Body
    G: Positive = GRAVITATIONAL_CONSTANT
    masses: Annotated[Any, (2,)] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.masses is None and isinstance(self.primary, Body) and isinstance(self.secondary, Body):
            object.__setattr__(self, "masses", _masses(self.primary, self.secondary))
        super().__post_init__()
        if np.any(self.masses <= 0):
            raise ValueError(f"masses must be positive, got {np.asarray(self.masses).tolist()}.")

    @property
    def bodies(self) -> dict[str, Body]:
        """The two by name."""
        return {"primary": self.primary, "secondary": self.secondary}

    @property
    def total_mass(self) -> Scalar:
        """The sum of the masses."""
        first, second = self.each_mass
        return first + second

    @property
    def reduced_mass(self) -> Scalar:
        """m1 m2 / (m1 + m2), by which the relative velocity is multiplied for the momentum."""
        first, second = self.each_mass
        return first * second / (first + second)

    @property
    def each_mass(self) -> tuple[Scalar, Scalar]:
        """The masses, scalars of any kind."""
        first, second = self.masses if isinstance(self.masses, Vector) else np.moveaxis(self.masses, -1, 0)
        return first, second

    @checked
    def state(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        attitudes: Sequence[Rotation | ArrayLike],
        *,
        omega_body: Sequence[ArrayLike] | None = None,
        omega_space: Sequence[ArrayLike] | None = None,
        angular_momentum_body: Sequence[ArrayLike] | None = None,
        angular_momentum_space: Sequence[ArrayLike] | None = None,
        time: Times = 0.0,
        frame: Frame | None = None,
    ) -> PairState:
        """Return the state with a relative position and velocity, and with two attitudes and rates.

        Parameters
        ----------
        position, velocity : array (3,) or (members, 3)
            Of the secondary's centre of mass from the primary's, space axes.
        attitudes : two of scipy Rotation or array (4,)
            Of primary and secondary, body -> space; with a frame, body -> frame. A quaternion is scalar first.
        omega_body, omega_space, angular_momentum_body, angular_momentum_space : two of array (3,)
            Those of primary and secondary, as for `Body.state`; exactly one of the four.
        time : float
        frame : Frame, optional
            Moving axes to which attitudes and rates refer; position and velocity stay along the space axes.

        Raises
        ------
        ValueError
            If there are not two of each, or what `Body.state` raises.
        """
        given = {
            "omega_body": omega_body,
            "omega_space": omega_space,
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        name, vectors = exactly_one("state", given)
        for what, pair in (("attitudes", attitudes), (name, vectors)):
            if len(pair) != len(BODIES):
                raise ValueError(f"{what} must be two, of primary and secondary, got {len(pair)}.")
        primary, secondary = (
            body.state(attitude, time=time, frame=frame, **{name: vector})
            for body, attitude, vector in zip(self.bodies.values(), attitudes, vectors, strict=True)
        )
        mass = np.asarray(self.reduced_mass)[..., None]
        return PairState(position, mass * member_array("velocity", velocity, (3,)), primary, secondary)


def _masses(primary: Body, secondary: Body) -> Array:
    masses: list[Any] = []
    for name, body in zip(BODIES, (primary, secondary), strict=True):
        mass: Any = body.mass  # type: ignore[attr-defined]
        if mass is None:
            raise ValueError(
                f"{name} must have a mass, got {body!r}. Give it one, Body(moments, mass=...), or make it of a shape."
            )
        masses.append(mass)
    return np.stack(np.broadcast_arrays(*masses), axis=-1)
