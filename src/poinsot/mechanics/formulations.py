"""Sets of variables for one flow, each with its equations of motion.

`lie_poisson` (q, g), `canonical` (q, Q) and `euler_angles` (angles and momenta of the sequence 3-1-3); `planar` is
`lie_poisson` about one axis.
The equations run on scalars of any kind; a state vector is a flat sequence in the order of `blocks`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.dual import partial, seeded
from poinsot.functions import Scalar, Vector
from poinsot.mechanics import euler
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.kinetics import Kinetics
from poinsot.mechanics.probing import time_scale
from poinsot.mechanics.state import Phase, State, computed_state

__all__ = ["DEFAULT_FORMULATION", "FORMULATIONS", "GENERAL", "Formulation"]

TorqueOf = Callable[[Attitude, Any], Vector]
"""Attitude and omega_body -> torque along the body axes."""

FLAT = 1e-9
"""What a planar motion may have of other components, relative."""


class Formulation(ABC):
    """A set of variables and its equations of motion."""

    name: str
    blocks: Mapping[str, int]
    tangent: tuple[int, ...] = ()
    """Which of the six tangent coordinates it has: rotation vector, change of angular momentum, body axes."""

    def check(self, system: Any, state: State) -> None:  # noqa: B027
        """Raise a ValueError if the variables cannot hold the motion of a system from a state."""

    def check_variables(self, variables: NDArray[np.float64]) -> None:  # noqa: B027
        """Raise a ValueError if variables at the start, shape (..., size), are none of this formulation."""

    @property
    def structure(self) -> tuple[Any, ...]:
        """What selects the equations besides the name."""
        return ()

    def own(self, variables: Any, scale: Scalar) -> dict[str, Vector]:  # noqa: ARG002
        """Return the variables of parts among those of the formulation, in physical units."""
        return {}

    def own_rates(self, rates: Mapping[str, Vector], scale: Scalar) -> list[Scalar]:  # noqa: ARG002
        """Return the rates of the variables of parts as those of the formulation."""
        return []

    @property
    def momenta(self) -> slice:
        """Where the momenta are among the variables: the last block."""
        return slice(self.size - list(self.blocks.values())[-1], self.size)

    @property
    def quaternions(self) -> list[slice]:
        """Where the quaternions are among the variables: what turns with the axes that the attitude refers to."""
        ends = np.cumsum(list(self.blocks.values()))
        return [slice(end - 4, end) for end, n in zip(ends, self.blocks.values(), strict=True) if n == 4]

    @property
    def size(self) -> int:
        """The number of variables."""
        return sum(self.blocks.values())

    def active(self, variables: Any) -> Any:
        """Return a flat sequence with literal zeros for the variables that are always zero."""
        return variables

    def split(self, variables: Any) -> list[Any]:
        """Return the blocks of a flat sequence of scalars."""
        ends = np.cumsum(list(self.blocks.values()))
        return [functions.Vector(variables[end - n : end]) for end, n in zip(ends, self.blocks.values(), strict=True)]

    @abstractmethod
    def derivatives(
        self, variables: Any, kinetics: Kinetics, torque_of: TorqueOf, turning: Vector | None = None
    ) -> list[Scalar]:
        """Return the time derivatives of the variables.

        `turning` is the angular velocity, along themselves, of the axes that the attitude refers to.
        """

    @abstractmethod
    def from_state(self, state: State) -> NDArray[np.float64]:
        """Return the variables of a state, shape (..., size)."""

    @abstractmethod
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        """Return q, and g or Q, whichever the variables hold; shapes (..., 4) and (..., 3) or (..., 4)."""


class LiePoisson(Formulation):
    """q' = q (0, omega)/2, g' = g x omega + tau; Q = 2 q (0, g)."""

    name = "lie_poisson"
    blocks: Mapping[str, int] = {"attitude": 4, "momentum": 3}
    tangent: tuple[int, ...] = (0, 1, 2, 3, 4, 5)

    def derivatives(
        self, variables: Any, kinetics: Kinetics, torque_of: TorqueOf, turning: Vector | None = None
    ) -> list[Scalar]:
        q, g = self.split(variables)
        torque = torque_of(Attitude.from_quaternion(q, comoving=turning is not None), kinetics.omega(g))
        return [*_turned(q, kinetics.half_omega(g), turning), *(kinetics.gyration(g) + torque)]

    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate([state.quaternion, state.angular_momentum_body], axis=-1)

    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        return {"quaternion": variables[..., :4], "angular_momentum_body": variables[..., 4:]}


class Planar(LiePoisson):
    """The same for a body that turns about its third axis only, in axes whose third axis is that one too.

    The variables that such a motion does not have are zero and stay so: it is the user's to say, and checked.
    """

    name = "planar"
    tangent = (2, 5)

    def check(self, system: Any, state: State) -> None:
        if system.moving_parts:
            raise ValueError(
                f"formulation 'planar' must be for a body without parts, got {type(system.moving_parts[0]).__name__}. "
                "Use the default formulation."
            )
        for name, vectors in _about_third_axis(system, state).items():
            aside = np.max(np.abs(vectors[..., :2]), initial=0.0)
            if aside > FLAT * np.max(np.abs(vectors), initial=0.0):
                raise ValueError(
                    "formulation 'planar' must be for a body that turns about its third axis alone, but its "
                    f"{name} has components along the others, up to {aside:.2g}. Use the default formulation."
                )

    def check_variables(self, variables: NDArray[np.float64]) -> None:
        tilt = float(np.max(np.linalg.norm(variables[..., 1:3], axis=-1)))
        if tilt > FLAT:
            raise ValueError(
                "formulation 'planar' must be for a third body axis along the third space axis where forces look at "
                f"the space axes, but it is {2 * tilt:.2g} rad off. Turn those, or use the default formulation."
            )

    def active(self, variables: Any) -> Any:
        q0, _, _, q3, _, _, g3 = variables
        return q0, 0.0, 0.0, q3, 0.0, 0.0, g3

    def derivatives(
        self, variables: Any, kinetics: Kinetics, torque_of: TorqueOf, turning: Vector | None = None
    ) -> list[Scalar]:
        return list(self.active(super().derivatives(self.active(variables), kinetics, torque_of, turning)))


def _about_third_axis(system: Any, state: State) -> dict[str, NDArray[np.float64]]:
    """Return vectors along the body axes that a planar motion has along the third one alone, largest first axis."""
    first, last = system.span
    torques = []
    for angle in np.arange(5) * 1.3:
        turned = quat.product(state.quaternion, (np.cos(angle), 0, 0, np.sin(angle)))
        time = np.clip(state.time + angle**3 * time_scale(system), first, last)
        torques.append(system.torque_body(computed_state(turned, np.zeros_like(turned), time)))
    return {
        "angular momentum": state.angular_momentum_body,
        "inertia tensor": system.body.inertia[..., 2],
        "torque": np.reshape(torques, (-1, 3)),
    }


class Canonical(Formulation):
    """Equations (7) with a tangent force: q' = q (0, omega)/2, Q' = Q (0, omega)/2 + 2 q (0, tau).

    The literal force -dU/dq of a polynomial U lets q . Q grow (erratum E7); this one keeps q . Q and |q|.
    """

    name = "canonical"
    blocks: Mapping[str, int] = {"attitude": 4, "momentum": 4}

    def derivatives(
        self, variables: Any, kinetics: Kinetics, torque_of: TorqueOf, turning: Vector | None = None
    ) -> list[Scalar]:
        q, Q = self.split(variables)
        g = 0.5 * quat.imaginary(quat.product(quat.conjugate(q), Q))
        half_omega = kinetics.half_omega(g)
        push = quat.product(
            q,
            quat.pure(2 * torque_of(Attitude.from_quaternion(q, comoving=turning is not None), kinetics.omega(g))),
        )
        return [*_turned(q, half_omega, turning), *(_turned(Q, half_omega, turning) + push)]

    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate([state.quaternion, state.conjugate_momenta], axis=-1)

    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        return {"quaternion": variables[..., :4], "conjugate_momenta": variables[..., 4:]}


class EulerAngles(Formulation):
    """Hamilton's equations of (10), corrected (erratum E4), for the sequence 3-1-3; singular at sin a2 = 0.

    a' = dT/dP, P' = -dT/da + (the torque along each rotation axis), T(a, P) the kinetic energy of eq. (8).
    """

    name = "euler_angles"
    blocks: Mapping[str, int] = {"angles": 3, "momenta": 3}
    sequence = "313"

    def derivatives(
        self, variables: Any, kinetics: Kinetics, torque_of: TorqueOf, turning: Vector | None = None
    ) -> list[Scalar]:
        if turning is not None:
            raise ValueError("axes must be the space axes for Euler angles, got turning axes.")
        angles, momenta = self.split(variables)
        attitude = Attitude(euler.rotation_matrix_from_angles(angles, self.sequence))
        axes = euler.rotation_axes(angles, self.sequence)
        g = euler.angular_momentum_from_momenta(angles, momenta, self.sequence)
        torque = torque_of(attitude, kinetics.omega(g))
        energy = kinetics.kinetic_energy(
            euler.angular_momentum_from_momenta(seeded(angles, "a"), seeded(momenta, "P"), self.sequence)
        )
        return [
            *(partial(energy, "P", i) for i in range(3)),
            *(quat.dot(axis, torque) - partial(energy, "a", i) for i, axis in enumerate(axes)),
        ]

    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate(state.euler(self.sequence), axis=-1)

    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        angles, momenta = variables[..., :3], variables[..., 3:]
        return {
            "quaternion": euler.quaternion_from_angles(angles, self.sequence),
            "angular_momentum_body": euler.angular_momentum_from_momenta(angles, momenta, self.sequence),
        }


def _turned(x: Any, half_omega: Any, turning: Vector | None) -> Any:
    """Return x (0, omega/2), less (0, turning) x / 2 if x refers to turning axes: rates are added before products."""
    if turning is None:
        return quat.product(x, quat.pure(half_omega))
    real, *vector = x
    relative, total = Vector(half_omega) - 0.5 * turning, Vector(half_omega) + 0.5 * turning
    return Vector((-functions.dot(vector, relative), *(real * relative + functions.cross(vector, total))))


GENERAL: Mapping[str, Formulation] = {f.name: f for f in (LiePoisson(), Canonical(), EulerAngles())}
FORMULATIONS: Mapping[str, Formulation] = {**GENERAL, "planar": Planar()}
DEFAULT_FORMULATION = "lie_poisson"
