"""What turns a body: potentials (one energy formula) and torques (one torque formula).

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method
its physics. It is frozen and becomes a dataclass by itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from poinsot import functions
from poinsot.algebra.dual import partial, seeded
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.body import Body
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.parameters import Parametric

__all__ = ["Potential", "Torque"]


class Force(Parametric, ABC):
    """What a system takes: a potential or a torque."""

    def check(self, body: Body) -> None:
        """Raise a ValueError if the force is that on another body; a system asks once, when it is made."""

    def validity(self, instant: Instant) -> Mapping[str, Scalar]:  # noqa: ARG002
        """Return, by name, whether the formula is used where it need not hold: a result counts these times."""
        return {}


class Potential(Force):
    """A conservative effect, by one scalar formula in body-frame vectors; its torque is derived."""

    @abstractmethod
    def energy(self, instant: Instant) -> Scalar:
        """Return the potential energy, written with `instant.attitude.to_body(u)` of space vectors u."""


class Torque(Force):
    """An effect that has no potential, by one formula with three body components."""

    @abstractmethod
    def torque(self, instant: Instant) -> Any:
        """Return the torque along the body axes, three scalars."""


class _Recorder(Attitude):
    """An attitude that makes every vector it turns into body axes an independent variable."""

    def __init__(self, attitude: Attitude) -> None:
        super().__init__(attitude.matrix, attitude.comoving)
        self.seen: list[Vector] = []

    def to_body(self, vector: Any) -> Vector:
        turned = seeded(super().to_body(vector), len(self.seen))
        self.seen.append(Vector(component.value for component in turned))
        return turned

    def to_space(self, vector: Any) -> Vector:
        x = Vector(vector)
        return self.in_space(functions.dot(self.to_body(self.in_space(unit)), x) for unit in UNITS)


UNITS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def derived_torque(potential: Potential, instant: Instant) -> Vector:
    """Return the torque of a potential along the body axes: the sum over u of u_body x dV/du_body.

    A space vector u turns in body axes as u' = u x omega, so that V' = -tau . omega. The torque is multiplied
    by the scale of the instant.
    """
    recorder = _Recorder(instant.attitude)
    energy = potential.energy(Instant(instant.body, recorder, instant.environment))
    total = Vector((0.0, 0.0, 0.0))
    for k, seen in enumerate(recorder.seen):
        total = total + functions.cross(seen, [instant.scale * partial(energy, k, i) for i in range(3)])
    return total
