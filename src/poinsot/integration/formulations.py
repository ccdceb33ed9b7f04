"""Charts of attitude and angular momentum: the variables in which one flow is integrated.

`lie_poisson` (q, g), `canonical` (q, Q) and `euler_angles` (angles and momenta of the sequence 3-1-3); `planar` is
`lie_poisson` about one axis. A chart is kinematics alone: it knows neither moments of inertia nor forces.
The equations run on scalars of any kind; a state vector is a flat sequence in the order of `blocks`.
"""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar, Vector
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.state import AnyState, Phase, State
from poinsot.subclasses import concrete, is_own
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.dynamics import AnyDynamics, stacked
from poinsot.systems.probing import time_scale

__all__ = [
    "DEFAULT_FORMULATION",
    "FORMULATIONS",
    "GENERAL",
    "Formulation",
    "formulation_of",
    "formulations",
    "refuse_spatial_motion",
]

PLANAR_TOLERANCE = 1e-9
"""Largest size of other components of a planar motion, relative to the planar component."""


class Formulation(ABC):
    """Chart of attitude and angular momentum, from the package or from a user.

    Attributes
    ----------
    name : str
    blocks : mapping
        Number of variables of each block, in order: the attitude first, the momenta last.
    """

    name: str
    blocks: Mapping[str, int]
    tangent: tuple[int, ...] = ()
    """Numbers of its tangent coordinates, out of six: rotation vector and change of angular momentum, body axes."""

    planar = False
    """True for motions about the third body axis only."""

    conjugate = False
    """True if the variables are (q, Q). The product q . Q changes no motion, but its rounding hides small momenta."""

    def check_variables(self, variables: NDArray[np.float64]) -> None:  # noqa: B027
        """Raise a ValueError if variables at the start, shape (..., size), are invalid in this formulation."""

    @functools.cached_property
    def momenta(self) -> slice:
        """Range of the momenta in the variables: the last block."""
        return slice(self.size - list(self.blocks.values())[-1], self.size)

    @functools.cached_property
    def quaternions(self) -> list[slice]:
        """Ranges of the quaternions in the variables, which rotate with the reference axes of the attitude."""
        ends = np.cumsum(list(self.blocks.values()))
        return [slice(end - 4, end) for end, n in zip(ends, self.blocks.values(), strict=True) if n == 4]

    @functools.cached_property
    def size(self) -> int:
        """The number of variables."""
        return sum(self.blocks.values())

    def split(self, variables: Sequence[Scalar]) -> list[Vector]:
        """Return the blocks of a flat sequence of scalars."""
        ends = np.cumsum(list(self.blocks.values()))
        return [functions.Vector(variables[end - n : end]) for end, n in zip(ends, self.blocks.values(), strict=True)]

    turns = True
    """True if the attitude may refer to rotating axes."""

    def nearness(self, variables: Sequence[Scalar]) -> Scalar | None:  # noqa: ARG002
        """Return a function that falls to zero where the variables become singular; None if they never do."""
        return None

    @abstractmethod
    def physical(self, variables: Sequence[Scalar]) -> tuple[Attitude, Vector]:
        """Return the attitude and the angular momentum along the body axes."""

    @abstractmethod
    def rates(
        self, variables: Sequence[Scalar], omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        """Return the time derivatives of the variables.

        `omega` is the angular velocity, `g_rate` the derivative g' of the angular momentum and `torque` its part
        g' - g x omega, all along the body axes; `turning` is the angular velocity, along themselves, of the axes that
        the attitude refers to.
        """

    @abstractmethod
    def from_state(self, state: State) -> NDArray[np.float64]:
        """Return the variables of a state, shape (..., size)."""

    @abstractmethod
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        """Return q, and g or Q according to the variables; shapes (..., 4) and (..., 3) or (..., 4)."""


class LiePoisson(Formulation):
    """Lie-Poisson equations q' = q (0, omega)/2, g' = g x omega + tau; Q = 2 q (0, g)."""

    name = "lie_poisson"
    blocks: Mapping[str, int] = {"attitude": 4, "momentum": 3}
    tangent: tuple[int, ...] = (0, 1, 2, 3, 4, 5)

    @override
    def physical(self, variables: Sequence[Scalar]) -> tuple[Attitude, Vector]:
        q, g = self.split(variables)
        return Attitude.from_quaternion(q), g

    @override
    def rates(
        self, variables: Sequence[Scalar], omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        q, _ = self.split(variables)
        return [*_turned(q, omega, turning), *g_rate]

    @override
    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate([state.quaternion, state.angular_momentum_body], axis=-1)

    @override
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        return {"quaternion": variables[..., :4], "angular_momentum_body": variables[..., 4:]}


class Planar(LiePoisson):
    """Lie-Poisson equations of a body that rotates about its third axis, which is also the third axis of space.

    The variables that such a motion does not have are zero and stay so: it is the user's to say, and checked.
    """

    name = "planar"
    tangent = (2, 5)
    planar = True

    @override
    def check_variables(self, variables: NDArray[np.float64]) -> None:
        tilt = float(np.max(np.linalg.norm(variables[..., 1:3], axis=-1)))
        if tilt > PLANAR_TOLERANCE:
            raise ValueError(
                "formulation 'planar' must be for a third body axis along the third space axis where forces look at "
                f"the space axes, but it is {2 * tilt:.2g} rad off. Turn those, or use the default formulation."
            )

    @override
    def physical(self, variables: Sequence[Scalar]) -> tuple[Attitude, Vector]:
        return super().physical(_planar(variables))

    @override
    def rates(
        self, variables: Sequence[Scalar], omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        return _planar(super().rates(_planar(variables), omega, g_rate, torque, turning))


def _planar(variables: Sequence[Scalar]) -> list[Scalar]:
    """Return the variables with literal zeros for the variables that are always zero."""
    q0, _, _, q3, _, _, g3 = variables
    return [q0, 0.0, 0.0, q3, 0.0, 0.0, g3]


def refuse_spatial_motion(system: AnyDynamics, state: AnyState) -> None:
    """Raise a ValueError if the motion of a system from a state does not turn about the third body axis alone."""
    if not isinstance(system, BodyDynamics):
        raise ValueError("formulation 'planar' must be for one body, got two. Use the default formulation.")
    state = state.of_bodies[""]
    if system.parts:
        raise ValueError(
            f"formulation 'planar' must be for a body without parts, got {type(system.parts[0]).__name__}. "
            "Use the default formulation."
        )
    vectors = {"angular momentum": state.angular_momentum_body, "inertia tensor": system.body.inertia[..., 2]}
    for name, along in (vectors | {"torque": _torques(system, state)}).items():
        aside = np.max(np.abs(along[..., :2]), initial=0.0)
        if aside > PLANAR_TOLERANCE * np.max(np.abs(along), initial=0.0):
            raise ValueError(
                "formulation 'planar' must be for a body that turns about its third axis alone, but its "
                f"{name} has components along the others, up to {aside:.2g}. Use the default formulation."
            )


def _torques(system: BodyDynamics, state: State) -> NDArray[np.float64]:
    """Return torques, body axes, at attitudes rotated about the third axis and at other times; shape (n, 3)."""
    first, last = system.span
    torques = []
    for angle in np.arange(5) * 1.3:
        turned = quat.product(state.quaternion, (np.cos(angle), 0, 0, np.sin(angle)))
        time = np.clip(state.time + angle**3 * time_scale(system), first, last)
        here = State.computed({"quaternion": turned, "conjugate_momenta": np.zeros_like(turned)}, time)
        twin = system.broadcast_to(here.shape)
        torques.append(stacked(twin.torque_at(twin.at(here)), here.shape))
    return np.reshape(torques, (-1, 3))


class Canonical(Formulation):
    """Equations (7) with a tangent force: q' = q (0, omega)/2, Q' = Q (0, omega)/2 + 2 q (0, tau).

    The literal force -dU/dq of a polynomial U lets q . Q grow (erratum E7); this one keeps q . Q and |q|.
    """

    name = "canonical"
    blocks: Mapping[str, int] = {"attitude": 4, "momentum": 4}
    conjugate = True

    @override
    def physical(self, variables: Sequence[Scalar]) -> tuple[Attitude, Vector]:
        q, Q = self.split(variables)
        return Attitude.from_quaternion(q), Vector(0.5 * quat.imaginary(quat.product(quat.conjugate(q), Q)))

    @override
    def rates(
        self, variables: Sequence[Scalar], omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        q, Q = self.split(variables)
        by_torque = Vector(quat.product(q, quat.pure(2 * torque)))
        return [*_turned(q, omega, turning), *(_turned(Q, omega, turning) + by_torque)]

    @override
    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate([state.quaternion, state.conjugate_momenta], axis=-1)

    @override
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        return {"quaternion": variables[..., :4], "conjugate_momenta": variables[..., 4:]}


class EulerAngles(Formulation):
    """Hamilton's equations of (10), corrected (erratum E4), for the sequence 3-1-3; singular at sin a2 = 0.

    With e_i the rotation axes: omega = sum a_i' e_i, and P_i = e_i . g has the derivative
    P_i' = e_i . (torque + g x u_i), u_i the angular velocity of the first i rotations.
    """

    name = "euler_angles"
    blocks: Mapping[str, int] = {"angles": 3, "momenta": 3}
    sequence = "313"

    turns = False

    @override
    def nearness(self, variables: Sequence[Scalar]) -> Scalar | None:
        return functions.sin(variables[1]) ** 2 - euler.SINGULAR_SINE**2

    @override
    def physical(self, variables: Sequence[Scalar]) -> tuple[Attitude, Vector]:
        angles, momenta = self.split(variables)
        g = Vector(euler.angular_momentum_from_momenta(angles, momenta, self.sequence))
        q = euler.quaternion_from_angles(angles, self.sequence)
        return Attitude(euler.rotation_matrix_from_angles(angles, self.sequence), quaternion=q), g

    @override
    def rates(
        self, variables: Sequence[Scalar], omega: Vector, g_rate: Vector, torque: Vector, turning: Vector | None = None
    ) -> list[Scalar]:
        angles, _ = self.split(variables)
        _, g = self.physical(variables)
        first, nodes, third = euler.rotation_axes(angles, self.sequence)
        rates = euler.angle_rates(angles, omega, self.sequence)
        along = [functions.dot(axis, torque) for axis in (first, nodes, third)]
        nodes_turned = rates[0] * functions.dot(g, functions.cross(first, nodes))
        third_turned = functions.dot(third, functions.cross(g, omega))
        return [*rates, along[0], along[1] + nodes_turned, along[2] + third_turned]

    @override
    def from_state(self, state: State) -> NDArray[np.float64]:
        return np.concatenate(state.euler(self.sequence), axis=-1)

    @override
    def to_phase(self, variables: NDArray[np.float64]) -> Phase:
        angles, momenta = variables[..., :3], variables[..., 3:]
        return {
            "quaternion": euler.quaternion_from_angles(angles, self.sequence),
            "angular_momentum_body": euler.angular_momentum_from_momenta(angles, momenta, self.sequence),
        }


def _turned(x: Vector, omega: Vector, turning: Vector | None) -> Iterable[Scalar]:
    """Return x (0, omega/2), minus (0, turning) x / 2 if x refers to rotating axes. Rates are added before products."""
    half_omega = 0.5 * omega
    if turning is None:
        return quat.product(x, quat.pure(half_omega))
    real, *vector = x
    relative, total = half_omega - 0.5 * turning, half_omega + 0.5 * turning
    return Vector((-functions.dot(vector, relative), *(real * relative + functions.cross(vector, total))))


GENERAL: Mapping[str, Formulation] = {f.name: f for f in (LiePoisson(), Canonical(), EulerAngles())}
FORMULATIONS: Mapping[str, Formulation] = {**GENERAL, "planar": Planar()}
DEFAULT_FORMULATION = "lie_poisson"


def formulations() -> dict[str, Formulation]:
    """Return the formulations by name: from the package, and from classes of users that need no arguments."""
    own = (cls for cls in concrete(Formulation) if not is_own(cls))
    plain = {cls.name: cls() for cls in own if hasattr(cls, "name") and cls.__init__ is object.__init__}
    return {**FORMULATIONS, **{name: found for name, found in plain.items() if name not in FORMULATIONS}}


def formulation_of(name: str) -> Formulation:
    """Return the formulation of a run by name; for an unknown name the default, along the same axes."""
    return formulations().get(name, FORMULATIONS[DEFAULT_FORMULATION])
