"""Quantities of a motion at its times: output variables of the table of columns, and quantities derived from them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, cast

import numpy as np

from poinsot.checked import checked
from poinsot.display.html_text import Summarized
from poinsot.kinematics.attitude import rotation
from poinsot.kinematics.frame import Frame, RelativeOrbitFrame, checked_frame
from poinsot.kinematics.state import AnyState, Phase, State
from poinsot.mechanics.environment import Environment
from poinsot.orbits.elements import OsculatingElements, osculating_elements
from poinsot.propagation import two_body_motion as pairs
from poinsot.propagation.column_reader import ColumnReader
from poinsot.propagation.relative_motion import RelativeMotion, euler_angles, relative_motion
from poinsot.quantities import Array, Times
from poinsot.systems.pair_dynamics import PairDynamics, acceleration
from poinsot.systems.system import System

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


__all__ = ["QuantitiesOfMotion"]


class QuantitiesOfMotion(Summarized):
    """Quantities of a motion, each an array whose first axis is the axis of the times, in an ensemble the second."""

    system: System
    times: Array
    _reader: ColumnReader
    _pair: QuantitiesOfMotion | None
    """Motion of both bodies, if this is the motion of one of them, with the name `_body`."""
    _body: str

    @property
    @abstractmethod
    def environment(self) -> Environment:
        """Environment at the times."""

    @abstractmethod
    def __call__(self, time: Times) -> State:
        """Return the state at a time."""

    def __dir__(self) -> list[str]:
        absent = pairs.OF_ONE_BODY if len(self.system.of_bodies) > 1 else pairs.OF_TWO_BODIES
        alone = {"forces_space"} if self._pair is None else set()
        return [name for name in super().__dir__() if name not in absent | alone]

    @checked
    def column(self, name: str) -> Array:
        """Return an output variable by its name in the dataset, one of `variable_names`; shape (n, ...)."""
        return self._read(name)

    @property
    def variable_names(self) -> tuple[str, ...]:
        """Names of the variables of a dataset along the times."""
        return tuple(self._reader.table)

    @property
    def quaternion(self) -> Array:
        """Unit quaternions body -> space, scalar first; shape (n, 4).

        poinsot never normalises them, so that their norm error is a measure of accuracy.
        """
        rows = self._reader.rows.phase.get("quaternion")
        return self._read("quaternion") if rows is None else np.asarray(rows)

    @property
    def conjugate_momenta(self) -> Array:
        """Conjugate momenta Q = 2 q (0, g); shape (n, 4)."""
        return self._read("conjugate_momenta")

    @property
    def angular_momentum_body(self) -> Array:
        """Angular momentum g = Im(q~ Q)/2 along the body axes; shape (n, 3)."""
        return self._read("angular_momentum_body")

    @property
    def angular_momentum_space(self) -> Array:
        """Angular momentum G = Im(Q q~)/2 along the space axes, of two bodies about the barycentre; shape (n, 3)."""
        return self._read("angular_momentum_space")

    @property
    def omega_body(self) -> Array:
        """Inertial angular velocity along the body axes; shape (n, 3)."""
        return self._read("omega_body")

    @property
    def omega_space(self) -> Array:
        """Inertial angular velocity along the space axes; shape (n, 3)."""
        return self._read("omega_space")

    @property
    def kinetic_energy(self) -> Array:
        """Kinetic energy T, eq. (9); shape (n,)."""
        return self._read("kinetic_energy")

    @property
    def potential_energy(self) -> Array:
        """Potential energy U, the sum of all potentials; shape (n,)."""
        return self._read("potential_energy")

    @property
    def energy(self) -> Array:
        """Total energy T + U; shape (n,)."""
        block = self._reader.block(lambda: self.environment)
        return block["kinetic_energy"] + block["potential_energy"]

    @property
    def norm_error(self) -> Array:
        """Norm error |q| - 1, for two bodies the larger of its magnitudes; shape (n,)."""
        return self._read("norm_error")

    @property
    def tangency_error(self) -> Array:
        """Ratio q . Q / |Q|, which is zero for a momentum that is tangent to the unit sphere or zero; shape (n,).

        For two bodies it is the larger of the magnitudes.
        """
        return self._read("tangency_error")

    @property
    def position(self) -> Array:
        """Position of the secondary's centre of mass relative to the primary's, space axes; shape (n, 3)."""
        return self._read("position")

    @property
    def momentum(self) -> Array:
        """Relative velocity of two bodies times the reduced mass, space axes; shape (n, 3)."""
        return self._read("momentum")

    @property
    def velocity(self) -> Array:
        """Velocity of the secondary relative to the primary, space axes; shape (n, 3)."""
        return self._read("velocity")

    @property
    def own(self) -> Phase:
        """Variables of the system's parts: name of the part -> array (n, k)."""
        return self._reader.state.own

    @property
    def attitude(self) -> Rotation:
        """Attitudes body -> space as a scipy rotation."""
        return rotation(self.quaternion)

    @property
    def torques_body(self) -> dict[str, Array]:
        """Torque of each force along the body axes: name of the class -> array (n, 3).

        Torques between the body and its parts are not included. The mapping is empty for a loaded motion whose forces
        are unknown.
        """
        pairs.refuse_two_bodies(self.system, "torques_body")
        return self._loads("torques_body")

    @property
    def forces_space(self) -> dict[str, Array]:
        """Each force of a pair on one of its bodies along the space axes: name of the class -> array (n, 3).

        The forces on the two bodies are opposite. An attractor outside of the pair also accelerates the barycentre;
        its force here is the force relative to the barycentre.
        """
        if self._pair is None:
            pairs.refuse_two_bodies(self.system, "forces_space")
            pairs.refuse_one_body(self.system, "forces_space")
        return self._loads("forces_space")

    def _loads(self, name: str) -> dict[str, Array]:
        """Return the torques or the forces on one body, for one of two bodies computed by the system of both."""
        whole, body = (self, ()) if self._pair is None else (self._pair, (self._body,))
        loads: Callable[..., dict[str, Array]] = getattr(whole.system, name)
        return loads(whole._reader.state, whole.environment, *body)

    @property
    def integrals(self) -> dict[str, Array]:
        """Conserved quantities of the system along the motion, by name; empty if there are none."""
        return self._reader.of_integrals("integral_")

    @property
    def drift(self) -> dict[str, Array]:
        """Relative change of each conserved quantity since the initial state, each of shape (n,) or (members, n).

        The change of an energy is divided by |T| + |U|, and the change of a momentum by |g|, each at its maximum along
        the motion.
        """
        return self._reader.of_integrals("drift_")

    @checked
    def euler(self, sequence: str = "313") -> tuple[Array, Array]:
        """Return Euler angles (radians) and their canonical momenta, each (n, 3), as `State.euler` does.

        Rows are NaN at singular attitudes, where `State.euler` raises an error. One warning names a regular sequence.
        """
        return euler_angles(self.quaternion, self._reader.state, sequence)

    @checked
    def relative_to(self, frame: Frame) -> RelativeMotion:
        """Return attitude and angular velocity relative to a moving frame, such as `orbit.frame`."""
        return relative_motion(self.times, self.quaternion, self.omega_body, checked_frame(frame))

    @property
    def distance(self) -> Array:
        """Distance of the centres of mass of two bodies; shape (n,)."""
        return np.asarray(np.linalg.norm(self.position, axis=-1))

    @property
    def acceleration(self) -> Array:
        """Acceleration of the secondary relative to the primary, space axes; shape (n, 3)."""
        pairs.refuse_one_body(self.system, "acceleration")
        with np.errstate(invalid="ignore"):
            return acceleration(self._dynamics_of_pair, self._reader.state, self.environment)

    @property
    def elements(self) -> OsculatingElements:
        """Osculating elements of the secondary's orbit at all times, with the parameter G (m1 + m2)."""
        pairs.refuse_one_body(self.system, "elements")
        pair, position = pairs.two_bodies(self.system), self.position
        mu = np.asarray(pair.with_axes(position.ndim - 1).mu)
        return osculating_elements(mu, position=position, velocity=self.velocity)

    @property
    def orbit_frame(self) -> Frame:
        """Axes radial (from primary to secondary), transverse and normal, at the times or with dense output at any.

        `motion.secondary.relative_to(motion.orbit_frame)` is the attitude and the rate relative to the orbit.
        """
        pairs.refuse_one_body(self.system, "orbit_frame")
        return RelativeOrbitFrame(self._moving)

    def _moving(self, time: Times) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration at the times of the motion, or at others by dense output."""
        if np.array_equal(np.asarray(time), self.times):
            return self.position, self.velocity, self.acceleration
        state: AnyState = self(time)
        position, momentum = state.phase["orbit"][..., :3], state.phase["orbit"][..., 3:]
        velocity = momentum / np.asarray(pairs.two_bodies(self.system).reduced_mass)
        return position, velocity, acceleration(self._dynamics_of_pair, state)

    @property
    def _dynamics_of_pair(self) -> PairDynamics:
        return cast(PairDynamics, self.system.dynamics)

    def _read(self, name: str) -> Array:
        return self._reader.block(lambda: self.environment)[name]
