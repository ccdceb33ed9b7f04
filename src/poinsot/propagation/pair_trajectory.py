"""The motion of two bodies."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Collection
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.functions import Scalar
from poinsot.mechanics.body_dynamics import BodyDynamics
from poinsot.mechanics.frame import Frame, RelativeOrbitFrame
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.pair_dynamics import PairDynamics, acceleration
from poinsot.mechanics.state import PairState, Phase
from poinsot.mechanics.system import System
from poinsot.mechanics.two_bodies import BODIES, TwoBodies
from poinsot.orbits.elements import OsculatingElements, osculating_elements
from poinsot.propagation.dataset import COLUMNS, OF_TWO
from poinsot.propagation.run_record import Method
from poinsot.propagation.selection import Chosen
from poinsot.propagation.trajectory import OF_PARTS, ORBIT, Trajectory
from poinsot.quantities import Times

__all__ = ["PairTrajectory", "of_one_body", "trajectory_class"]

Array = NDArray[np.float64]


class PairTrajectory(Trajectory):
    """The motion of two bodies at the requested times: the secondary's orbit about the primary, and both rotations.

    What is of one body is read from `motion.primary` and `motion.secondary`.

    Attributes
    ----------
    system : System
        Of `TwoBodies`.
    initial : PairState
    times, run, failures, events, provenance
        As of a `Trajectory`.

    Notes
    -----
    In an ensemble every array has the members as its first axis: (members, n, 3).

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(ball, ball, G=1.0)
    >>> start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1), (0, 0, 0.5)])
    >>> motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [np.pi])
    >>> motion.position.round(12), motion.secondary.omega_body
    (array([[-2.,  0.,  0.]]), array([[0. , 0. , 0.5]]))
    """

    _of_whole: ClassVar[tuple[str, ...]] = (*OF_TWO, *COLUMNS)
    system: System[TwoBodies]
    initial: PairState

    @property
    def position(self) -> Array:
        """The position of the secondary's centre of mass from the primary's, space axes; shape (n, 3)."""
        return np.array(self.phase["orbit"])[..., :3]

    @property
    def momentum(self) -> Array:
        """The relative velocity times the reduced mass, space axes; shape (n, 3)."""
        return np.array(self.phase["orbit"])[..., 3:]

    @property
    def velocity(self) -> Array:
        """The velocity of the secondary relative to the primary, space axes; shape (n, 3)."""
        momentum = self.momentum
        return np.asarray(momentum / self.system.body.with_axes(momentum.ndim).reduced_mass)

    @property
    def acceleration(self) -> Array:
        """The acceleration of the secondary relative to the primary, space axes; shape (n, 3)."""
        state: Any = self._state
        with np.errstate(invalid="ignore"):
            return acceleration(self.system.dynamics, state, self.environment)

    @property
    def distance(self) -> Array:
        """The distance of the centres of mass; shape (n,)."""
        return np.asarray(np.linalg.norm(self.position, axis=-1))

    @property
    @override
    def of_bodies(self) -> dict[str, Trajectory]:
        return {body: self._of(body) for body in BODIES}

    @property
    def elements(self) -> OsculatingElements:
        """The osculating elements of the secondary's orbit at all times, with the parameter G (m1 + m2)."""
        position = self.position
        mu = np.asarray(self.system.body.with_axes(position.ndim - 1).mu)
        return osculating_elements(mu, position=position, velocity=self.velocity)

    @property
    def orbit_frame(self) -> Frame:
        """The axes radial (from primary to secondary), transverse and normal, at the times or with dense output at any.

        `motion.secondary.relative_to(motion.orbit_frame)` is the attitude and the rate relative to the orbit.
        """
        return RelativeOrbitFrame(self._moving)

    def _moving(self, time: Times) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration at the times of the motion, or at others by dense output."""
        if np.array_equal(np.asarray(time), self.times):
            return self.position, self.velocity, self.acceleration
        state: Any = self(time)
        velocity = state.momentum / np.asarray(self.system.body.reduced_mass)
        return state.position, velocity, acceleration(self.system.dynamics, state)

    @property
    def primary(self) -> Trajectory:
        """The rotation of the primary, as the motion of one body."""
        return self._of("primary")

    @property
    def secondary(self) -> Trajectory:
        """The rotation of the secondary, as the motion of one body."""
        return self._of("secondary")

    def _of(self, body: str) -> Trajectory:
        system = System.of(OneOfTwo(self.system.of_bodies[body], ()), self.system.units)
        interpolant = None
        if self._interpolant is not None:
            _, first, last = self._interpolant
            interpolant = functools.partial(_interpolated, self, body), first, last
        rows = functools.partial(_phase_of, self._state, body)
        run = dataclasses.replace(self.run, method=Method.ONE_OF_TWO)
        motion = BodyTrajectory(system, self.initial.of_bodies[body], self.times, rows, run, interpolant, self.failures)
        motion._complete(provenance={key: self.provenance[key] for key in OF_PARTS if key in self.provenance})
        if self._kept_state is not None:
            motion._kept_state = self._kept_state.of_bodies[body]
        motion._pair, motion._body = self, body
        return motion

    def loads(self, name: str, body: str) -> dict[str, Array]:
        """Return the torques or the forces on one body by the class of the force."""
        found: dict[str, Array] = getattr(self.system, name)(self._state, self.environment, body)
        return found

    @property
    @override
    def torques_body(self) -> dict[str, Array]:
        raise AttributeError(_refused("torques_body"))

    @override
    def _at_hand(self, names: Collection[str]) -> dict[str, Array]:
        orbit = {name: getattr(self, name) for name in ORBIT if name in names}
        return super()._at_hand(names) | orbit

    @property
    @override
    def quaternion(self) -> Array:
        raise AttributeError(_refused("quaternion"))

    @property
    @override
    def conjugate_momenta(self) -> Array:
        raise AttributeError(_refused("conjugate_momenta"))

    @property
    @override
    def angular_momentum_body(self) -> Array:
        raise AttributeError(_refused("angular_momentum_body"))

    @property
    @override
    def omega_body(self) -> Array:
        raise AttributeError(_refused("omega_body"))

    @property
    @override
    def angular_momentum_space(self) -> Array:
        """The angular momentum about the barycentre, of the orbit and both rotations, space axes; shape (n, 3)."""
        return self._state.angular_momentum_space

    @property
    @override
    def norm_error(self) -> Array:
        """The larger of | |q| - 1 | of the two bodies; shape (n,)."""
        each = self._state.of_bodies.values()
        return np.asarray(np.max([np.abs(quat.norm(one.quaternion) - 1) for one in each], axis=0))

    @property
    @override
    def tangency_error(self) -> Array:
        """The larger of |q . Q| / |Q| of the two bodies; shape (n,)."""
        return np.asarray(np.max([np.abs(one.tangency_error) for one in self.of_bodies.values()], axis=0))

    @property
    @override
    def _sketched(self) -> dict[str, Array]:
        return {"distance": self.distance}

    @property
    @override
    def _sketched_member(self) -> tuple[str, Array]:
        return "distance", self.distance

    @property
    @override
    def _momentum_size(self) -> Array:
        own = sum(np.linalg.norm(each.angular_momentum_body, axis=-1) for each in self._state.of_bodies.values())
        return np.asarray(own + np.linalg.norm(np.cross(self.position, self.momentum), axis=-1))


class BodyTrajectory(Trajectory):
    """The rotation of one of two bodies."""

    _of_whole: ClassVar[tuple[str, ...]] = tuple(name for name in COLUMNS if name != "potential_energy")
    _pair: PairTrajectory
    """The motion of the two bodies, whose forces act on this one."""
    _body: str

    @property
    @override
    def torques_body(self) -> dict[str, Array]:
        """The torque of each force of the pair along the body axes, by its class; each of shape (n, 3).

        Of a loaded motion whose forces are unknown: empty.
        """
        found: dict[str, Array] = self._pair.loads("torques_body", self._body)
        return found

    @property
    def forces_space(self) -> dict[str, Array]:
        """Each force of the pair on this body along the space axes, by its class; each of shape (n, 3).

        The forces on the two bodies are opposite. An attractor outside of the pair also accelerates the barycentre;
        its force here is the force relative to the barycentre.
        """
        found: dict[str, Array] = self._pair.loads("forces_space", self._body)
        return found

    @override
    def _selected(self, members: Chosen | None, at: NDArray[np.intp]) -> BodyTrajectory:
        part: Any = super()._selected(members, at)
        part._pair, part._body = self._pair._selected(members, at), self._body
        return part  # type: ignore[no-any-return]


def _phase_of(state: Any, body: str) -> Phase:
    phase: Phase = state.of_bodies[body].phase
    return phase


def _interpolated(motion: PairTrajectory, body: str, times: Array) -> Phase:
    return _phase_of(motion(times), body)


class OneOfTwo(BodyDynamics):
    """One of two bodies, whose rotation a motion of the pair contains. The forces belong to the pair."""

    measures = PairDynamics.measures
    moves_alone = False

    @override
    def potential_at(self, instant: Instant) -> Scalar:
        raise AttributeError("one of two bodies has no energy of its own: take `motion.energy` of the pair.")


def _refused(name: str) -> str:
    return f"a motion of two bodies has no {name}. Read primary.{name} or secondary.{name}."


def of_one_body(motion: Trajectory, body: str | None) -> Trajectory:
    """Return the rotation of one body: of two, the one that is named."""
    known = motion.of_bodies
    if body is None and len(known) == 1:
        return motion
    if body not in known:
        rule = "must be primary or secondary" if len(known) > 1 else "must not be there for a motion of one body"
        raise ValueError(f"body {rule}, got {body or 'none'}.")
    return known[body]


def trajectory_class(system: System) -> type[Trajectory]:
    """Return the class of the motions of a system."""
    return PairTrajectory if len(system.of_bodies) > 1 else Trajectory
