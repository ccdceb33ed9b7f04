"""Sets of reaction wheels that apply the torque of a control law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import refuse_negative, refuse_nonpositive, refuse_other_length
from poinsot.functions import Scalar
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer
from poinsot.mechanics.part import NOTHING, Part
from poinsot.quantities import OR_NUMBER, Along, Rule
from poinsot.records.members import Components, of_arrays, of_scalars
from poinsot.records.parameters import ArrayLength

__all__ = ["ReactionWheels"]

TORQUE_FALL_STEEPNESS = 20.0
"""The torque of a motor falls linearly to zero over the last twentieth of the largest speed."""

DRY_FRICTION_RANGE = 1e-3
"""Dry friction grows linearly over this part of the largest speed about rest.

A function such as tanh would be flat to rounding a little farther away, and steps would go across it unawares.
"""

EachPositive = Annotated[Any, ("count",), OR_NUMBER, Rule(refuse_nonpositive)]
EachNotNegative = Annotated[Any, ("count",), OR_NUMBER, Rule(refuse_negative)]
UnitVectors = Annotated[Any, ("count", 3), Along("body axes"), Rule(refuse_other_length, "Divide by the length.")]


class ReactionWheels(Part):
    """Balanced reaction wheels that apply the torque of a control law within the limits of their motors.

    p_i' = T_i - friction_i s_i - dry_friction_i d_i. Here p_i is the inertial angular momentum of a wheel along its
    axis a_i, s_i = p_i / J_i - a_i . omega its speed relative to the body, S_i its largest speed, and d_i = 1000 s_i /
    S_i limited to +-1. The commanded motor torques T are the minimum-norm solution, by the pseudo-inverse, of -sum T_i
    a_i = torque of the law. Each is limited to the largest torque times min(1, 20 (1 -+ s_i / S_i)), so that a wheel at
    its largest speed can only decelerate. The wheels compensate neither friction nor the gyroscopic torque of their
    momenta.

    Parameters
    ----------
    axes : array (n, 3), body axes
        Unit vectors along the wheels' axes: one, two different axes, or more axes that are not coplanar.
    moments : array (n,) or float
        Moments of inertia J about the axes, positive. The body's inertia tensor includes the wheels, locked.
    law : Torque
        Control law for the torque on the body. It acts through the wheels only; do not also pass it to the system.
    largest_torques, largest_speeds : array (n,) or float
        Limits of each motor and wheel, positive; speeds are relative to the body, in angle per time.
    friction, dry_friction : array (n,) or float
        Viscous friction, torque per speed, and dry friction, a torque; not negative.

    Raises
    ------
    ValueError
        If the axes are coplanar or not unit vectors, a number is out of range, or an initial speed exceeds its limit.

    Examples
    --------
    >>> wheels = pt.parts.ReactionWheels(np.eye(3), 1e-3, pt.forces.LinearDamping(0.2), 5e-3, 600.0)
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheels)
    >>> motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.1, -0.2, 0.1)), [200.0])
    >>> bool(np.max(abs(motion.omega_body)) < 1e-6)
    True
    """

    axes: UnitVectors
    moments: EachPositive
    law: Torque
    largest_torques: EachPositive
    largest_speeds: EachPositive
    friction: EachNotNegative = 0.0
    dry_friction: EachNotNegative = 0.0
    momenta: ClassVar[frozenset[str]] = frozenset({"momentum"})
    count = ArrayLength("axes", "Number of wheels.")

    def __post_init__(self) -> None:
        super().__post_init__()
        rank, most = np.min(np.linalg.matrix_rank(self.axes, tol=1e-6)), min(self.count, 3)
        if rank < most:
            raise ValueError(
                f"axes must span {most} dimensions, got {self.count} in {rank}. One wheel more there gives no torque "
                "along another axis."
            )

    @property
    def variables(self) -> Mapping[str, int]:  # type: ignore[override]
        """Momenta of the wheels."""
        return {"momentum": self.count}

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        each = zip(self.moments, self.axes, strict=True)
        return functions.Vector(moment * functions.dot(axis, omega_body) for moment, axis in each)

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        each = zip(own, self.axes, strict=True)
        return sum((functions.Vector(axis) * p for p, axis in each), start=functions.Vector(NOTHING[0]))

    @override
    def spinning_inertia(self, own: functions.Vector) -> Matrix:
        each = zip(self.moments, self.axes, strict=True)
        return sum((outer(axis, axis) * moment for moment, axis in each), start=NOTHING)

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        value: Scalar = sum(p * p / (2 * moment) for p, moment in zip(own, self.moments, strict=True))
        return value

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        return functions.Vector(map(self._torque, range(self.count), *self._demand(instant)))

    @override
    def limits(self, instant: Instant, torque: functions.Vector | None = None) -> Mapping[str, Scalar]:
        """Return, by name, if each motor is at its torque limit, or at the torque limit for the speed of its wheel."""
        found = dict(self.law.limits(instant))
        for i, (wanted, speed) in enumerate(zip(*self._demand(instant), strict=True)):
            downwards, upwards = self._largest(i, speed)
            limit, most = functions.where(wanted > 0, upwards, downwards), self.largest_torques[i]
            short: Any = abs(wanted) >= limit
            found[f"{self.name}_{i}_at_torque_limit"] = np.logical_and(short, limit >= most)
            found[f"{self.name}_{i}_at_speed_limit"] = np.logical_and(short, limit < most)
        return found

    def _demand(self, instant: Instant) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        """Return the torques wanted of the motors, and the speeds of the wheels relative to the body."""
        p, omega = instant.own(self), instant.omega_body
        each = zip(p, self.moments, self.axes, strict=True)
        slips = [x * (1 / moment) - functions.dot(axis, omega) for x, moment, axis in each]
        return self.distributed(-functions.Vector(self.law.torque(instant))), slips

    def _largest(self, i: int, speed: Scalar) -> tuple[Scalar, Scalar]:
        """Return the largest torques of a motor at a speed of its wheel, downwards and upwards."""
        most, part = self.largest_torques[i], speed * (1 / self.largest_speeds[i])
        upwards = most * functions.minimum(1.0, TORQUE_FALL_STEEPNESS * (1 - part))
        return most * functions.minimum(1.0, TORQUE_FALL_STEEPNESS * (1 + part)), upwards

    def _torque(self, i: int, wanted: Scalar, speed: Scalar) -> Scalar:
        """Return the torque of motor and friction on a wheel."""
        downwards, upwards = self._largest(i, speed)
        part = speed * (1 / self.largest_speeds[i])
        rubbing = self.friction[i] * speed + self.dry_friction[i] * functions.clip(
            part * (1 / DRY_FRICTION_RANGE), -1.0, 1.0
        )
        value: Scalar = functions.clip(wanted, -downwards, upwards) - rubbing
        return value

    @of_scalars
    def distributed(self, torque: functions.Vector) -> functions.Vector:
        """Return the minimum-norm torques about the axes whose sum is a torque, or its projection on the axes."""
        axes = [functions.Vector(axis) for axis in self.axes]
        columns = [functions.Vector(column) for column in zip(*axes, strict=True)]
        if self.count < 3:
            gram = [[functions.dot(a, b) for b in axes] for a in axes]
            return _solved(gram, [functions.dot(axis, torque) for axis in axes])
        along = _solved([[functions.dot(a, b) for b in columns] for a in columns], torque)
        return functions.Vector(functions.dot(axis, along) for axis in axes)

    @override
    def check_start(self, instant: Instant) -> None:
        """Raise a ValueError if an initial wheel speed exceeds its limit."""
        own = zip(instant.own(self), self.moments, self.axes, self.largest_speeds, strict=True)
        for i, (p, moment, axis, largest) in enumerate(own):
            speed = np.abs(p / moment - functions.dot(axis, instant.omega_body))
            if np.any(speed > largest):
                place = np.unravel_index(np.argmax(speed - largest), np.shape(speed))
                most = np.broadcast_to(largest, np.shape(speed))[place]
                raise ValueError(
                    f"the speed of wheel {i} must be at most its largest at the start, {most:.6g}, got "
                    f"{speed[place]:.6g}. It is saturated."
                )

    @of_arrays(speeds=("count",), omega_body=(3,))
    def at_speeds(self, speeds: Components, omega_body: Components) -> Any:
        """Return the variables, shape (..., n), for speeds relative to the body and the body's angular velocity."""
        each = zip(self.moments, speeds, self.axes, strict=True)
        return functions.Vector(J * (speed + functions.dot(axis, omega_body)) for J, speed, axis in each)

    @of_arrays(own=("count",), omega_body=(3,))
    def speeds(self, own: Components, omega_body: Components) -> Any:
        """Return the speeds relative to the body, shape (..., n), from variables and the body's angular velocity."""
        each = zip(own, self.moments, self.axes, strict=True)
        return functions.Vector(p / moment - functions.dot(axis, omega_body) for p, moment, axis in each)


def _solved(matrix: list[list[Scalar]], right: Sequence[Scalar]) -> functions.Vector:
    """Return x of A x = b for a positive definite matrix of scalars, by elimination."""
    (pivot, *row), *others = matrix
    inverse = 1 / pivot
    if not others:
        return functions.Vector((inverse * right[0],))
    factors = [other[0] * inverse for other in others]
    rest = [[x - f * y for x, y in zip(o[1:], row, strict=True)] for f, o in zip(factors, others, strict=True)]
    behind = _solved(rest, [b - f * right[0] for f, b in zip(factors, right[1:], strict=True)])
    return functions.Vector((inverse * (right[0] - functions.dot(row, behind)), *behind))
