"""The state of a rotating body: the attitude quaternion q with its conjugate momentum Q or the body's own, g."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import member_array, real_numbers, refuse_other_members
from poinsot.immutable import cached_property, copied, owned, read_only
from poinsot.kinematics import euler
from poinsot.kinematics.attitude import rotation, unit_quaternion
from poinsot.kinematics.each_body import OfTwoBodies
from poinsot.quantities import Angles, Times

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["AnyState", "Bodies", "PairState", "Phase", "State", "named", "project_to_tangent"]

Phase = dict[str, NDArray[np.float64]]
"""Rows of a state or a motion by name: `quaternion`, and `angular_momentum_body` or `conjugate_momenta`; then
the variables of parts, each under the name of its part.

Each of the two momenta follows from the other and q. Q mixes the components of g, so that a g that comes from Q has the
rounding of the largest component in all of them; a Q that comes from g is tangent to the unit sphere by construction.
"""

OF_ONE = ("quaternion", "angular_momentum_body", "conjugate_momenta")


def named(body: str, name: str) -> str:
    """Return the name of a row of a body in a phase, such as "primary_quaternion"."""
    return f"{body}_{name}" if body else name


RIGID = (*OF_ONE, *(named(body, name) for body in ("primary", "secondary") for name in OF_ONE))
"""The names in a phase that are those of rigid bodies, one or two."""

TANGENCY_TOLERANCE = 1e-9
"""Largest |q . Q| / |Q| in an argument."""


class StateOfBodies(Summarized):
    """Base of the states of one and of two bodies: named rows at one time, or at several."""

    body_names: ClassVar[tuple[str, ...]]
    """Names of the rigid bodies, which the names of their rows begin with."""
    time: NDArray[np.float64]
    phase: Phase

    jumped: Mapping[str, NDArray[np.bool_]] = MappingProxyType({})
    """The name of a part to True where the state holds the variables after a jump of the part at the state's time.

    Rows of motions have it, so that a run from a row does not repeat the jump. States that a user makes are empty here.
    """

    _member_axes: ClassVar[Mapping[str, int]] = {"phase": 1, "time": 0, "jumped": 0}

    def _with_values(self, phase: Phase, time: ArrayLike, jumped: Mapping[str, ArrayLike]) -> Self:
        return self.computed(phase, np.asarray(time), jumped)

    @classmethod
    def computed(cls, phase: Phase, time: ArrayLike, jumped: Mapping[str, ArrayLike] | None = None) -> Self:
        """Return the state of computed rows, whose small defects are errors of the computation."""
        state = object.__new__(cls)
        vars(state).update(phase=read_only(phase), time=owned(time))
        if jumped:
            vars(state)["jumped"] = read_only({name: np.asarray(done) for name, done in jumped.items()})
        return state

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the state: () for one state, (n,) for several."""
        return next(iter(self.phase.values())).shape[:-1]

    @property
    def own(self) -> Phase:
        """Variables of the system's parts: name of the part -> array (..., k)."""
        return copied(own_of(self.phase))


Rows = TypeVar("Rows")
Changed = TypeVar("Changed")
Bodies = TypeVar("Bodies", bound=StateOfBodies)
"""Kind of a state: of one or of two bodies."""


class State(StateOfBodies):
    """State of a rotating body: attitude and momentum at one time, or arrays of these.

    Q = 2 q (0, g), with the angular momentum g = Im(q~ Q)/2 along the body axes, eq. (17) of the paper. A state does
    not contain moments of inertia: `body.omega` or a trajectory gives angular velocities. A state is immutable:
    `quaternion` and `time` are read-only arrays, and momenta are copies.

    Parameters
    ----------
    quaternion : array (4,) or (n, 4)
        Unit quaternion q body -> space, scalar first, x_space = q x_body q~.
    conjugate_momenta : array (4,) or (n, 4)
        Conjugate momentum Q of q, tangent to the unit sphere: q . Q = 0. Unit of angular momentum.
    time : float or array (n,)
        Time in the user's unit.
    own : mapping, optional
        Variables of the system's parts: name of the part -> array (k,) or (n, k).

    Raises
    ------
    ValueError
        If |q| differs from 1 by more than 1e-9, or |q . Q| is above 1e-9 |Q|. poinsot does not normalise them.

    Examples
    --------
    >>> state = pt.State(quaternion=(1, 0, 0, 0), conjugate_momenta=(0, 1.0, 0, 3.0))
    >>> state.angular_momentum_body
    array([0.5, 0. , 1.5])
    """

    body_names: ClassVar[tuple[str, ...]] = ("",)

    def __init__(
        self,
        quaternion: ArrayLike,
        conjugate_momenta: ArrayLike,
        time: Times = 0.0,
        *,
        own: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        q = unit_quaternion(quaternion, "quaternion")
        Q = member_array("conjugate_momenta", conjugate_momenta, (4,))
        self.time = member_array("time", time, ())
        parts = {name: _own_values(name, values) for name, values in (own or {}).items()}
        counts = {name: values.shape[:-1] for name, values in parts.items()}
        refuse_other_members(quaternion=q.shape[:-1], conjugate_momenta=Q.shape[:-1], time=self.time.shape, **counts)
        members = np.broadcast_shapes(q.shape[:-1], Q.shape[:-1], *counts.values())
        q, Q = np.broadcast_to(q, (*members, 4)), np.broadcast_to(Q, (*members, 4))
        _check_tangent(q, Q)
        parts = {name: np.broadcast_to(values, (*members, values.shape[-1])) for name, values in parts.items()}
        self.phase: Phase = {"quaternion": q, "conjugate_momenta": Q, **parts}

    @classmethod
    @checked
    def from_euler(
        cls,
        angles: Angles,
        momenta: ArrayLike,
        sequence: str = "313",
        time: Times = 0.0,
        own: Mapping[str, ArrayLike] | None = None,
    ) -> State:
        """Return the state with Euler angles (radians) and their canonical momenta, shapes (3,) or (n, 3).

        Any angles away from the singularity are valid. The quaternion q changes its sign when the first angle increases
        by 2 pi (eqs. (8), (12), (14) of the paper).
        """
        angles, momenta = member_array("angles", angles, (3,)), member_array("momenta", momenta, (3,))
        euler.refuse_singular_angles(angles, sequence)
        q = euler.quaternion_from_angles(angles, sequence)
        g = euler.angular_momentum_from_momenta(angles, momenta, sequence)
        return state_with(q, g, time, own)

    @checked
    def euler(self, sequence: str = "313") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the Euler angles (radians) and their canonical momenta, each of shape (..., 3).

        The first angle is in [0, 4 pi), which preserves the sign of q, and the third in [0, 2 pi). The second is in (0,
        pi), or in (-pi/2, pi/2) for a sequence of three different axes (eqs. (13), (15) of the paper with the exact
        lift of erratum E6).

        Raises
        ------
        ValueError
            At a singular attitude of the sequence. The error message names a regular sequence.
        """
        angles = euler.angles_from_quaternion(self.quaternion, sequence)
        return angles, euler.momenta_from_angular_momentum(angles, self.angular_momentum_body, sequence)

    @property
    def quaternion(self) -> NDArray[np.float64]:
        """Unit quaternion q body -> space, scalar first; shape (..., 4)."""
        return self.phase["quaternion"]

    @property
    def conjugate_momenta(self) -> NDArray[np.float64]:
        """Momentum Q conjugate to q, Q = 2 q (0, g); shape (..., 4)."""
        if (Q := self.phase.get("conjugate_momenta")) is not None:
            return copied(Q)
        return copied(self._conjugate_momenta)

    @property
    def of_bodies(self) -> dict[str, State]:
        """States of the rigid bodies by name; the name of a single body is empty."""
        return {"": self}

    @property
    def rigid(self) -> Phase:
        """Rows of the rigid body, without the variables of parts."""
        return rigid_rows(self.phase)

    @property
    def attitude(self) -> Rotation:
        """Attitude body -> space as a scipy rotation."""
        return rotation(self.quaternion)

    @cached_property
    def _conjugate_momenta(self) -> NDArray[np.float64]:
        return 2 * quat.product(self.quaternion, quat.pure(self.phase["angular_momentum_body"]))

    @cached_property
    def _angular_momentum_body(self) -> NDArray[np.float64]:
        return 0.5 * quat.imaginary(quat.product(quat.conjugate(self.quaternion), self.phase["conjugate_momenta"]))

    @property
    def angular_momentum_body(self) -> NDArray[np.float64]:
        """Angular momentum g = Im(q~ Q)/2 along the body axes, eq. (17); shape (..., 3)."""
        if (g := self.phase.get("angular_momentum_body")) is not None:
            return copied(g)
        return copied(self._angular_momentum_body)

    @property
    def angular_momentum_space(self) -> NDArray[np.float64]:
        """Angular momentum G = Im(Q q~)/2 along the space axes; shape (..., 3)."""
        return copied(self._angular_momentum_space)

    @cached_property
    def _angular_momentum_space(self) -> NDArray[np.float64]:
        return 0.5 * quat.imaginary(quat.product(self.conjugate_momenta, quat.conjugate(self.quaternion)))

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        members = f" of {len(self.quaternion)} members" if self.quaternion.ndim == 2 else ""
        return f"State{members} at t = {formatted(self.time)}", {
            "quaternion (body to space)": formatted(self.quaternion),
            "angular momentum (body axes)": formatted(self.angular_momentum_body),
            "conjugate momenta": formatted(self.conjugate_momenta),
            **{f"own variables of {name}": formatted(values) for name, values in self.own.items()},
        }


class PairState(OfTwoBodies, StateOfBodies):
    """State of two bodies: relative position and momentum, and the rotational state of each body.

    Parameters
    ----------
    position : array (3,) or (n, 3)
        Position of the secondary's centre of mass relative to the primary's, space axes.
    momentum : array (3,) or (n, 3)
        Reduced mass times the relative velocity, conjugate to the position, space axes.
    primary, secondary : State
        Rotational states at one common time. `TwoBodies.state` makes a pair state from velocities and angular
        velocities.

    Raises
    ------
    ValueError
        If the times differ, the position is zero, or the numbers of members differ.

    Examples
    --------
    >>> upright = pt.State(quaternion=(1, 0, 0, 0), conjugate_momenta=(0, 0, 0, 1))
    >>> pt.PairState((3, 0, 0), (0, 2, 0), upright, upright).secondary.angular_momentum_body
    array([0. , 0. , 0.5])
    """

    body_names: ClassVar[tuple[str, ...]] = ("primary", "secondary")
    _one: ClassVar[type] = State
    _noun: ClassVar[str] = "a state"

    @checked
    def __init__(self, position: ArrayLike, momentum: ArrayLike, primary: State, secondary: State) -> None:
        position, momentum = member_array("position", position, (3,)), member_array("momentum", momentum, (3,))
        if not np.array_equal(primary.time, secondary.time):
            raise ValueError(f"primary and secondary must have one time, got {primary.time} and {secondary.time}.")
        if not np.all(np.any(position, axis=-1)):
            raise ValueError("position must not be zero, got the centres of mass at one place.")
        self.time = primary.time
        given = {"position": position.shape[:-1], "momentum": momentum.shape[:-1]}
        given |= {"primary": primary.shape, "secondary": secondary.shape, "time": self.time.shape}
        refuse_other_members(**given)
        members = np.broadcast_shapes(*given.values())
        orbit = np.concatenate(np.broadcast_arrays(position, momentum), axis=-1)
        each = {"primary": primary, "secondary": secondary}
        phase = {named(body, name): x for body, state in each.items() for name, x in state.phase.items()}
        phase |= {"orbit": orbit}
        self.phase = {name: np.broadcast_to(x, (*members, x.shape[-1])) for name, x in phase.items()}

    @property
    def position(self) -> NDArray[np.float64]:
        """Position of the secondary relative to the primary, space axes; shape (..., 3)."""
        return copied(self.phase["orbit"][..., :3])

    @property
    def momentum(self) -> NDArray[np.float64]:
        """Reduced mass times the relative velocity, space axes; shape (..., 3)."""
        return copied(self.phase["orbit"][..., 3:])

    @property
    def primary(self) -> State:
        """Rotational state of the primary."""
        return self.of_bodies["primary"]

    @property
    def secondary(self) -> State:
        """Rotational state of the secondary."""
        return self.of_bodies["secondary"]

    @property
    def rigid(self) -> Phase:
        """Rows of the rigid bodies, with the relative position and momentum."""
        return rigid_rows(self.phase) | {"position": self.position, "momentum": self.momentum}

    @cached_property
    def of_bodies(self) -> dict[str, State]:
        """States of the rigid bodies by name, "primary" and "secondary"."""
        return {
            body: State.computed(
                {name: x for name in OF_ONE if (x := self.phase.get(named(body, name))) is not None}, self.time
            )
            for body in self.body_names
        }

    @property
    def angular_momentum_space(self) -> NDArray[np.float64]:
        """Total angular momentum of the orbit and both rotations about the barycentre, space axes; shape (..., 3)."""
        own = sum(state.angular_momentum_space for state in self.of_bodies.values())
        return np.asarray(np.cross(self.position, self.momentum) + own)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        members = f" of {self.shape[0]} members" if self.shape else ""
        return f"PairState{members} at t = {formatted(self.time)}", {
            "position (secondary from primary, space axes)": formatted(self.position),
            "momentum (space axes)": formatted(self.momentum),
            **{
                f"{what} of the {body}": formatted(values)
                for body, state in self.of_bodies.items()
                for what, values in (
                    ("quaternion (body to space)", state.quaternion),
                    ("angular momentum (body axes)", state.angular_momentum_body),
                )
            },
        }


AnyState: TypeAlias = State | PairState
"""State of one or of two bodies."""


def state_with(q: ArrayLike, g: ArrayLike, time: Times, own: Mapping[str, ArrayLike] | None = None) -> State:
    """Return the state with an angular momentum along the body axes, which is stored without rounding."""
    checked = State(q, 2 * quat.product(q, quat.pure(g)), time, own=own)
    momenta = np.array(np.broadcast_to(g, (*checked.quaternion.shape[:-1], 3)), dtype=float)
    phase = {"quaternion": checked.quaternion, "angular_momentum_body": momenta, **checked.own}
    return State.computed(phase, checked.time)


def own_of(phase: Phase) -> Phase:
    """Return the variables of parts in a phase, by the name of the part."""
    return {name: values for name, values in phase.items() if name not in RIGID}


def rigid_rows(phase: Phase) -> Phase:
    """Return the rows of rigid bodies in a phase."""
    return {name: values for name, values in phase.items() if name in RIGID}


def state_of(phase: Phase, time: ArrayLike, jumped: Mapping[str, ArrayLike] | None = None) -> AnyState:
    """Return the state of one or of two bodies with computed rows, see `StateOfBodies.computed`."""
    of_two = "orbit" in phase and "quaternion" not in phase
    return PairState.computed(phase, time, jumped) if of_two else State.computed(phase, time, jumped)


def changed(phase: Mapping[str, Rows], change: Callable[[Rows], Changed]) -> dict[str, Changed]:
    """Return a phase with each of its arrays changed."""
    return {name: change(values) for name, values in phase.items()}


@checked
def project_to_tangent(quaternion: ArrayLike, conjugate_momenta: ArrayLike) -> NDArray[np.float64]:
    """Return momenta tangent to the unit sphere, Q - (q . Q) q / |q|^2, with the same angular momentum.

    Parameters
    ----------
    quaternion, conjugate_momenta : array (4,) or (members, 4)
        Quaternion q, scalar first, and momenta Q. Neither needs to be normalised.

    Returns
    -------
    array (4,) or (members, 4)
        Tangent momenta.

    Raises
    ------
    ValueError
        If the quaternion is zero.

    Examples
    --------
    >>> pt.mechanics.project_to_tangent((1, 0, 0, 0), (0.25, 1.0, 0, 3.0))
    array([0., 1., 0., 3.])
    """
    q, Q = (
        member_array(name, value, (4,))
        for name, value in (("quaternion", quaternion), ("conjugate_momenta", conjugate_momenta))
    )
    if not np.all(np.any(q, axis=-1)):
        raise ValueError("quaternion must not be zero, got |q| = 0.")
    return np.asarray(Q - (quat.dot(q, Q) / quat.dot(q, q))[..., None] * q)


def _own_values(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = real_numbers(name, value)
    if array.ndim not in (1, 2) or 0 in array.shape:
        raise ValueError(f"{name} must have shape (k,) or (members, k), got shape {array.shape}.")
    return array


def _check_tangent(q: NDArray[np.float64], Q: NDArray[np.float64]) -> None:
    defect, size = np.abs(np.sum(q * Q, axis=-1)), np.hypot.reduce(Q, axis=-1)
    if np.any(defect > TANGENCY_TOLERANCE * size):
        i = np.argmax(np.atleast_1d(defect - TANGENCY_TOLERANCE * size))
        ratio = np.atleast_1d(defect)[i] / np.atleast_1d(size)[i]
        raise ValueError(
            f"conjugate_momenta must be tangent to the unit sphere, but |q . Q| = {ratio:.3g} |Q|. "
            "Pass project_to_tangent(quaternion, conjugate_momenta), which preserves the angular momentum."
        )
