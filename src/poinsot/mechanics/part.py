"""What moves inside a body or on it: rotors, dampers, masses on springs.

To add one, inside or outside the package, write a subclass: its fields are its parameters, `variables` what it
integrates, its methods the physics. It is frozen and becomes a dataclass by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import components
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import UNITS, Force
from poinsot.mechanics.kinetics import CompositeKinetics, Matrix, product

__all__ = ["CompositeBody", "Part"]


class Part(Block, Force):
    """Something that moves in the body or on it, with variables of its own or without.

    The total angular momentum g about the centre of mass obeys g' = g x omega + external torque whatever moves inside.
    A part changes the step to the angular velocity, omega = K (g - h), and the kinetic energy,
    (g - h) . K (g - h) / 2 + internal energies. The motor, friction and spring torques between body and part appear
    in `rates` alone.

    The body's inertia tensor is that of body and parts, each locked where `inertia` is zero. `own` are the part's
    variables, scalars of any kind in the order of `variables`; matrices are rows of three scalars.
    """

    moves_center_of_mass: ClassVar[bool] = False
    """Whether the centre of mass moves in the body; at most one part of a system does."""

    def momentum(self, own: Vector, time: Scalar) -> Vector:  # noqa: ARG002
        """Return h, the angular momentum at omega = 0, along the body axes; those of parts add up."""
        return Vector((0.0, 0.0, 0.0))

    def inertia(self, own: Vector, time: Scalar) -> Matrix:  # noqa: ARG002
        """Return the change of the mass distribution: added to the body's inertia, and gravity acts on it."""
        return NOTHING

    def spinning_inertia(self, own: Vector) -> Matrix:  # noqa: ARG002
        """Return the inertia that does not turn with the body: taken out of K^-1 alone."""
        return NOTHING

    def internal_energy(self, own: Vector, time: Scalar) -> Scalar:  # noqa: ARG002
        """Return what the part adds to (g - h) . K (g - h) / 2."""
        return 0.0

    @override
    def rates(self, instant: Any, pull: Vector) -> Vector:
        return Vector(())


NOTHING = Vector((Vector((0.0, 0.0, 0.0)),) * 3)


class CompositeBody(Body):
    """A body with its parts at one instant: what formulas see as the body.

    `moments` are those of the body with its parts locked.
    """

    if TYPE_CHECKING:
        locked: Body
        change: Matrix
        inverse: Matrix
        momentum: Vector
        values: Mapping[str, Vector]

    @classmethod
    def of(cls, body: Body, parts: Sequence[Part], own: Sequence[Vector], time: Scalar) -> CompositeBody:
        """Return a body with parts whose variables have values."""
        pairs = list(zip(parts, own, strict=True))
        locked = Vector(Vector(body.angular_momentum(unit)) for unit in UNITS)
        change = _sum(part.inertia(values, time) for part, values in pairs)
        spinning = _sum(part.spinning_inertia(values) for part, values in pairs)
        return cls.unchecked(
            moments=body.moments,
            locked=body,
            change=change,
            inverse=locked + change - spinning,
            momentum=sum((Vector(part.momentum(values, time)) for part, values in pairs), start=NOTHING[0]),
            values={part.name: values for part, values in pairs},
        )

    @override
    def kinetics(self, scale: Scalar = 1) -> Any:
        return CompositeKinetics(self.inverse, self.momentum, scale)

    @override
    def angular_momentum(self, omega_body: ArrayLike) -> Any:
        return product(self.inverse, Vector(components(omega_body))) + self.momentum

    @override
    def moment_about(self, direction_body: ArrayLike) -> Scalar:
        direction = Vector(components(direction_body))
        return self.locked.moment_about(direction) + functions.dot(direction, product(self.change, direction))

    @override
    def own(self, block: Block) -> Vector:
        if block.name not in self.values:
            raise KeyError(f"block must be one of the system's, {', '.join(self.values)}, got {block.name!r}.")
        return self.values[block.name]

    @property
    @override
    def inertia(self) -> Any:
        rows = [[Vector(self.locked.angular_momentum(u))[i] for u in UNITS] for i in range(3)]
        return Vector(map(Vector, rows)) + self.change


def _sum(matrices: Iterable[Matrix]) -> Matrix:
    return sum((Vector(map(Vector, matrix)) for matrix in matrices), start=NOTHING)
