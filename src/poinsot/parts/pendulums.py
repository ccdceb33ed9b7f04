"""Pendulum models of liquid slosh in a tank."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import components
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer, spread
from poinsot.mechanics.part import NOTHING
from poinsot.parts.gyros import refuse_oblique
from poinsot.parts.springs import AttachedMass
from poinsot.quantities import BodyVector
from poinsot.records.members import Components, of_arrays, of_scalars
from poinsot.records.parameters import BodyUnitVector, NotNegative, Positive

__all__ = ["SloshPendulum"]


class SloshPendulum(AttachedMass):
    """Pendulum model of liquid slosh: a point mass on a massless rod from a pivot in a free body.

    With the angles a and b, the rod is along e = cos a cos b d + sin a cos b c + sin b d x c, the mass at y = r + l e
    from the centre of mass of the rest, and mu = mass (total_mass - mass) / total_mass. Lagrange's equations of T = mu
    |v|^2 / 2, v = y' + omega x y, give with e_i = de / d angle_i the momenta p_i = mu l^2 |e_i|^2 angle_i' + mu omega .
    (y x l e_i), and p_i' = mu l v . (e_i' + omega x e_i) + stiffness d . e_i - damping |e_i|^2 angle_i'. A thrust with
    acceleration A of the body along -d corresponds to stiffness = mass A l and the torque mass A l (e x d) on the body,
    see `displacement`. The angles are singular at b = 90 degrees.

    Parameters
    ----------
    pivot : array (3,), body axes
        Pivot relative to the centre of mass of body and pendulum at rest. The inertia tensor includes the pendulum at
        rest.
    direction, across : array (3,), body axes
        Perpendicular unit vectors: d along the rod at rest, and c.
    length : float
        Length l of the rod, positive.
    stiffness, damping : float
        Torque per angle at small angles, and per angular velocity; not negative.
    planar : bool
        True if the pendulum swings only in the plane of direction and across, with b = 0.

    Examples
    --------
    >>> tank = pt.parts.SloshPendulum(20.0, 500.0, (0, 0, 0.5), (0, 0, -1), (1, 0, 0), length=0.4)
    >>> tank.at_angles((0.1, 0.0), (0.0, 0.0), omega_body=(0, 0, 0))
    array([0.1, 0. , 0. , 0. ])
    """

    pivot: BodyVector
    direction: BodyUnitVector
    across: BodyUnitVector
    length: Positive
    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    planar: bool = False
    momenta: ClassVar[frozenset[str]] = frozenset({"momentum"})

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_oblique("across", self.across, "direction", self.direction)

    @property
    def angle_count(self) -> int:
        """Number of angles."""
        return 1 if self.planar else 2

    @property
    def variables(self) -> Mapping[str, int]:  # type: ignore[override]
        """Angles and their momenta."""
        return {"angle": self.angle_count, "momentum": self.angle_count}

    @property
    def _axes(self) -> tuple[Vector, Vector, Vector]:
        """Axis along the rod at rest, and the two axes towards which it swings."""
        down, across = Vector(components(self.direction)), Vector(components(self.across))
        return down, across, functions.cross(down, across)

    @property
    def _pivot(self) -> Vector:
        """Position of the pivot relative to the centre of mass of the rest."""
        pivot = Vector(components(self.pivot))
        hanging = pivot + self._axes[0] * self.length
        return pivot + hanging * (self.mass / (self.total_mass - self.mass))

    def _halves(self, own: Any) -> tuple[Any, Any]:
        count = self.angle_count
        return own[:count], own[count:]

    def _directions(self, angles: Any) -> tuple[Vector, Vector, Vector, Vector, Scalar, Scalar]:
        """Return e, e at b = 0 and its derivative by a, the axis of b, and sin b and cos b."""
        down, across, out_of_plane = self._axes
        c, s = functions.cos(angles[0]), functions.sin(angles[0])
        outwards, tangent = down * c + across * s, across * c - down * s
        if self.planar:
            return outwards, outwards, tangent, out_of_plane, 0.0, 1.0
        rise, reach = functions.sin(angles[1]), functions.cos(angles[1])
        return outwards * reach + out_of_plane * rise, outwards, tangent, out_of_plane, rise, reach

    def _placed(self, angles: Any) -> tuple[Vector, list[tuple[Vector, Scalar]]]:
        """Return the position of the mass, and the unit vector and the length of the derivative of e by each angle."""
        rod, outwards, tangent, out_of_plane, rise, reach = self._directions(angles)
        second = [] if self.planar else [(out_of_plane * reach - outwards * rise, 1.0)]
        return self._pivot + rod * self.length, [(tangent, reach), *second]

    def _turned(self, angles: Any, rates: Any) -> list[Vector]:
        """Return the rates of the derivatives of e by each angle."""
        rod, outwards, tangent, _, rise, reach = self._directions(angles)
        if self.planar:
            return [outwards * -rates[0]]
        first = outwards * (-reach * rates[0]) - tangent * (rise * rates[1])
        return [first, tangent * (-rise * rates[0]) - rod * rates[1]]

    @property
    def _hanging(self) -> Vector:
        """Position of the mass at rest, relative to the centre of mass of the rest of the body."""
        return self._pivot + self._axes[0] * self.length

    @of_scalars
    def displacement(self, own: Any) -> Vector:
        """Return the displacement of the mass from its rest position, along the body axes; scalars of any kind."""
        return self._placed(self._halves(own)[0])[0] - self._hanging

    @of_scalars
    def angle_rates(self, own: Any, omega_body: Any) -> Vector:
        """Return the rates of the angles; scalars of any kind, or arrays with the components first."""
        angles, momenta = self._halves(own)
        y, slopes = self._placed(angles)
        return Vector(
            (p / (self.reduced_mass * self.length * reach) - functions.dot(omega_body, functions.cross(y, tangent)))
            / (self.length * reach)
            for p, (tangent, reach) in zip(momenta, slopes, strict=True)
        )

    @override
    def momentum(self, own: Vector, time: Scalar) -> Vector:
        angles, momenta = self._halves(own)
        y, slopes = self._placed(angles)
        each = zip(momenta, slopes, strict=True)
        terms = (functions.cross(y, tangent) * (p / (self.length * reach)) for p, (tangent, reach) in each)
        return sum(terms, start=Vector(NOTHING[0]))

    @override
    def inertia(self, own: Vector, time: Scalar) -> Matrix:
        y, _ = self._placed(self._halves(own)[0])
        return (spread(y) - spread(self._hanging)) * self.reduced_mass

    @override
    def spinning_inertia(self, own: Vector) -> Matrix:
        y, slopes = self._placed(self._halves(own)[0])
        levers = (functions.cross(y, tangent) for tangent, _ in slopes)
        return sum((outer(lever, lever) for lever in levers), start=NOTHING) * self.reduced_mass

    @override
    def internal_energy(self, own: Vector, time: Scalar) -> Scalar:
        angles, momenta = self._halves(own)
        y, slopes = self._placed(angles)
        each = zip(momenta, slopes, strict=True)
        kinetic = sum((p / (self.length * reach)) ** 2 for p, (_, reach) in each) / (2 * self.reduced_mass)
        lift = functions.dot(self._hanging - y, self._axes[0]) / self.length
        value: Scalar = kinetic + self.stiffness * lift
        return value

    @override
    def rates(self, instant: Instant, generalised_force: Vector) -> Vector:
        own, omega = instant.own(self), instant.omega_body
        angles, _ = self._halves(own)
        y, slopes = self._placed(angles)
        turning = self.angle_rates(own, omega)
        slope = [tangent * reach for tangent, reach in slopes]
        speed = functions.cross(omega, y)
        for along, rate in zip(slope, turning, strict=True):
            speed = speed + along * (self.length * rate)
        scaled_momentum = speed * (self.reduced_mass * self.length)
        forces = [
            functions.dot(scaled_momentum, turned + functions.cross(omega, along))
            + self.stiffness * functions.dot(self._axes[0], along)
            - self.damping * (reach * reach) * rate
            for turned, along, (_, reach), rate in zip(
                self._turned(angles, turning), slope, slopes, turning, strict=True
            )
        ]
        return Vector((*turning, *(force + generalised_force[i] for i, force in enumerate(forces))))

    @override
    def start(self, time: Scalar, omega_body: Vector) -> Vector:
        angles = (0.0,) * (self.angle_count)
        return Vector((*angles, *self._momenta(angles, angles, omega_body)))

    def _momenta(self, angles: Any, rates: Any, omega_body: Any) -> Vector:
        """Return the momenta of angles and their rates."""
        y, slopes = self._placed(angles)
        return Vector(
            (self.length * reach * rate + functions.dot(omega_body, functions.cross(y, tangent)))
            * (self.reduced_mass * self.length * reach)
            for rate, (tangent, reach) in zip(rates, slopes, strict=True)
        )

    @of_arrays(angles=("angle_count",), rates=("angle_count",), omega_body=(3,))
    def at_angles(self, angles: Components, rates: Components, omega_body: Components) -> Any:
        """Return the variables, shape (..., 4), or (..., 2) if planar, for angles, rates and angular velocity."""
        return Vector((*angles, *self._momenta(angles, rates, omega_body)))
