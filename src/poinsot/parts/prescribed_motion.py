"""Prescribed motions inside a body: moving masses, and a varying inertia."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_nonpositive
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.kinetics import Matrix, mixed_spread, spread
from poinsot.mechanics.part import NOTHING, Part, tensor_array
from poinsot.quantities import Along, Duration, Rule, Time
from poinsot.records.members import of_scalars
from poinsot.records.parameters import ArrayLength, Positive
from poinsot.taylor.graph import Graph, tangents

__all__ = ["MovingMasses", "VaryingInertia"]

PositiveDuration = Annotated[Duration, Rule(refuse_nonpositive)]

SYMMETRY_TOLERANCE = 1e-12
"""Tolerance of the symmetry of a tensor relative to its largest component, and of the triangle inequality."""


class Transition(Part):
    """Part that moves from one place to another as a function of the time, smoothly at both ends."""

    if TYPE_CHECKING:
        begin: Any
        duration: Any

    @of_scalars
    def progress(self, time: Scalar) -> Scalar:
        """Return 0 before the transition, 1 after it, and 10 x^3 - 15 x^4 + 6 x^5 at a part x of its duration.

        A subclass can define another smooth function of the time.
        """
        x = functions.clip((time - self.begin) / self.duration, 0.0, 1.0)
        return x * x * x * (10 - x * (15 - 6 * x))

    @of_scalars
    def progress_rate(self, time: Scalar) -> Scalar:
        """Return the rate of the progress, its derivative."""
        graph = Graph()
        now = graph.variable(time)
        value: Scalar = graph.finished(tangents([self.progress(now)], {now: 1.0}))[0]
        return value

    @of_scalars
    @abstractmethod
    def changes(self) -> tuple[Matrix, Matrix]:
        """Return the changes of inertia that multiply the progress and its square."""

    @override
    def inertia(self, own: Vector, time: Scalar) -> Matrix:
        progress, (linear, square) = self.progress(time), self.changes()
        return linear * progress + square * (progress * progress)

    @override
    def check(self, body: Any) -> None:
        self.refuse_inertia(body.locked.inertia + self.inertia_change, "at the end of the transition")

    @property
    def inertia_change(self) -> NDArray[np.float64]:
        """Change of the inertia over the whole transition, body axes; shape (3, 3) or (members, 3, 3)."""
        linear, square = self.with_numbers(self.numbers).changes()
        return tensor_array(linear + square)

    def refuse_inertia(self, inertia: NDArray[Any], when: str) -> None:
        """Raise a ValueError for a tensor that no rigid body has."""
        masses = np.linalg.eigvalsh(np.trace(inertia, axis1=-2, axis2=-1)[..., None, None] / 2 * np.eye(3) - inertia)
        if np.any(masses[..., 0] < -SYMMETRY_TOLERANCE * masses[..., 2]):
            found = ", ".join(f"{x:.6g}" for x in np.linalg.eigvalsh(inertia).reshape(-1, 3)[0])
            raise ValueError(
                f"the inertia {when} must be the inertia of a body, got principal moments {found}. "
                "The body's tensor includes all parts before the transition."
            )


class VaryingInertia(Transition):
    """Inertia tensor that changes by a prescribed amount: propellant consumption, or symmetric boom deployment.

    I = I0 + x change. The fraction x increases from 0 at `begin` to 1 at the end as 10 u^3 - 15 u^4 + 6 u^5, with u the
    elapsed fraction of the duration; the principal axes may rotate. The angular momentum of the body is I omega, with
    g' = g x omega + torque; I' does not appear. The model ignores the momentum of the moving masses relative to the
    body, which `MovingMasses` includes, and the momentum of the exhaust (jet damping). The energy is omega . I omega /
    2 plus the potential energies.

    Parameters
    ----------
    change : array (3, 3), body axes
        Symmetric change of the inertia tensor about the centre of mass. The body's tensor is the initial one.
    begin : float
        Start time of the transition.
    duration : float
        Duration of the transition, positive.

    Raises
    ------
    ValueError
        If the change is not symmetric or the duration is not positive. `System` raises it if the final tensor is not
        physical.

    Examples
    --------
    >>> booms = pt.parts.VaryingInertia(np.diag([0.0, 2.0, 2.0]), begin=10.0, duration=30.0)
    >>> system = pt.System(pt.Body((1.0, 2.0, 2.0)), booms)
    >>> motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 0.5)), [0.0, 60.0])
    >>> motion.omega_body[:, 2]
    array([0.5 , 0.25])
    """

    change: Annotated[Any, (3, 3), Along("body axes")]
    begin: Time
    duration: PositiveDuration

    def __post_init__(self) -> None:
        super().__post_init__()
        off = np.abs(self.change - np.swapaxes(self.change, -1, -2))
        if np.any(off > SYMMETRY_TOLERANCE * np.max(np.abs(self.change))):
            raise ValueError(f"change must be a symmetric tensor, got components that differ by {np.max(off):.3g}.")

    @override
    def changes(self) -> tuple[Matrix, Matrix]:
        return Vector(map(Vector, self.change)), NOTHING


class MovingMasses(Transition):
    """Point masses that move along straight lines in the body by a prescribed function of time.

    Mass m_i is at y_i = a_i + x d_i from the centre of mass of the rest. The fraction x increases from 0 at `begin` to
    1 at the end as 10 u^3 - 15 u^4 + 6 u^5, with u the elapsed fraction of the duration. With M the total mass, the
    inertia tensor about the common centre of mass is the sum of the rest and of each m_i at y_i, minus M at sum m_i y_i
    / M. The momentum relative to the body is x' (sum m_i a_i x d_i - (sum m_i a_i) x (sum m_i d_i) / M). The energy is
    omega . I omega / 2 plus the potential energies, without the motion of the masses in the body.

    Parameters
    ----------
    masses : array (n,)
        Masses m, positive.
    total_mass : float
        Total mass M of body and masses.
    positions : array (n, 3), body axes
        Initial positions, relative to the initial centre of mass of body and masses. The body's inertia tensor includes
        the masses at these positions, about this centre.
    destinations : array (n, 3), body axes
        Final positions, relative to the same point of the body.
    begin, duration : float
        Start time and duration of the motion; the duration is positive.

    Examples
    --------
    >>> tip = pt.parts.MovingMasses([2.0], 60.0, [(0, 0, 0.3)], [(0, 0, 6.0)], begin=0.0, duration=120.0)
    >>> np.round(tip.inertia_change, 3).diagonal()  # of the reduced mass 2 (60 - 2) / 60
    array([69.654, 69.654,  0.   ])
    """

    masses: Annotated[Any, ("count",), Rule(refuse_nonpositive)]
    total_mass: Positive
    positions: Annotated[Any, ("count", 3), Along("body axes")]
    destinations: Annotated[Any, ("count", 3), Along("body axes")]
    begin: Time
    duration: PositiveDuration
    moves_center_of_mass: ClassVar[bool] = True
    count = ArrayLength("positions", "Number of masses.")

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.sum(self.masses, axis=-1) >= self.total_mass):
            raise ValueError(
                f"total_mass must be more than the sum of the masses, got {self.total_mass} and "
                f"{np.max(np.sum(self.masses, axis=-1))}. It is the mass of the body and of the point masses."
            )

    def _arms(self) -> list[tuple[Scalar, Vector, Vector]]:
        """Return each mass with a and d, and the sums of m a and m d with the factor -1 / M."""
        each = list(zip(self.masses, map(Vector, self.positions), map(Vector, self.destinations), strict=True))
        rest = self.total_mass - sum(self.masses)
        center = sum((x * m for m, x, _ in each), start=NOTHING[0]) / -rest
        arms = [(m, x - center, there - x) for m, x, there in each]
        sums = (sum((arm[k] * arm[0] for arm in arms), start=NOTHING[0]) for k in (1, 2))
        return [*arms, (-1 / self.total_mass, *sums)]

    @override
    def changes(self) -> tuple[Matrix, Matrix]:
        linear = square = NOTHING
        for mass, arm, step in self._arms():
            linear, square = linear + mixed_spread(arm, step) * mass, square + spread(step) * mass
        return linear, square

    @override
    def momentum(self, own: Vector, time: Scalar) -> Vector:
        swing = sum((functions.cross(arm, step) * mass for mass, arm, step in self._arms()), start=NOTHING[0])
        return Vector(self.progress_rate(time) * x for x in swing)

    @override
    def check(self, body: Any) -> None:
        arms = self.with_numbers(self.numbers)._arms()
        masses = tensor_array(sum((spread(arm) * mass for mass, arm, _ in arms), start=NOTHING))
        self.refuse_inertia(body.locked.inertia - masses, "of the rest, without the masses,")
