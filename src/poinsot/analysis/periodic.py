"""Periodic motions: what repeats itself in a moving frame after one period, its small oscillations and stability.

x = (rotation vector, change of angular momentum), both along the body axes, becomes matrix x a period later, to first
order. Newton's method finds where nothing is left over; the eigenvalues of the matrix are Floquet's multipliers.
The rotation of a moon in a Cassini state is such a motion, seen from axes that turn with the node of its orbit.
"""

from __future__ import annotations

import dataclasses
from math import factorial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from poinsot.errors import real_array, refuse_nonpositive
from poinsot.forces.gravity import GravityGradient
from poinsot.mechanics import quaternion as quat
from poinsot.mechanics.attitude import rotation
from poinsot.mechanics.body import Body
from poinsot.mechanics.frame import Frame, RotatingFrame, checked_frame
from poinsot.mechanics.parameters import listed
from poinsot.mechanics.state import State
from poinsot.mechanics.system import System
from poinsot.motion.arguments import check_kinds, members_of
from poinsot.motion.propagate import propagate
from poinsot.orbits.precessing import PrecessingOrbit

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["CassiniState", "PeriodicMotion", "cassini_state", "periodic_motion"]

Array = NDArray[Any]

SLOW = 1e-6
"""Angles and growth per period below this count as zero: where multipliers meet, they are not known better."""
SAME = 1e-9
"""By how much a torque or a rate, relative to its size, may change from one period to the next."""
ROUNDS = 40
LARGEST_STEP = 0.3
"""Of Newton's method, radians; of the momentum, what turns the body by so much in a period."""
SETTLED = 1e-7
"""The error after a step is of the order of its square."""
FIRM = 1e-10
"""Singular values below this, of the largest, are those of a direction in which there is another such motion."""
REACH = 6
"""Neighbours on each side of a central difference, whose order is twice that."""
SPACINGS = (0.04, 0.01, 0.0025, 0.0006)
"""Of the neighbours, radians as above."""
SAMPLES = 256
"""Of a mean over a period."""
EXACT, COARSE = 1e-11, 1e-5
"""Relative errors of the matrix with which it is done, and beyond which it is refused."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PeriodicMotion:
    """A motion that repeats itself in a frame, and the small motion about it; radians, the user's unit of time.

    Attributes
    ----------
    state : State
        Where it starts.
    period : float
    frame : Frame
    matrix : array (6, 6)
        x(t + period) = matrix x(t) from the time of the state, x = (rotation vector relative to the frame, change of
        angular momentum), body axes.
    multipliers : complex array (6,)
        Its eigenvalues.
    frequencies : array, ascending
        Positive angles of the multipliers over the period, in (0, pi/period]: a motion looked at once in a period
        does not tell w from 2 pi/period - w, nor from w + 2 pi/period.
    growth_rates : array, ascending
        Positive logarithms of their moduli over the period. Both without those below 1e-6/period.
    """

    state: State
    period: float
    frame: Frame
    matrix: Array
    multipliers: Array
    frequencies: Array
    growth_rates: Array

    @property
    def stable(self) -> bool:
        """Whether the linear equations let nothing grow exponentially."""
        return not self.growth_rates.size

    def __repr__(self) -> str:
        names = ("state", "period", "stable", "frequencies", "growth_rates")
        return f"PeriodicMotion({', '.join(f'{name}={listed(getattr(self, name))}' for name in names)})"


def periodic_motion(system: System, guess: State, period: float, frame: Frame | None = None) -> PeriodicMotion:
    """Return the motion near a guess that repeats itself in a frame after one period.

    Newton's method on the motion over a period. Its derivative is by central differences of 12th order over an
    ensemble of neighbours, whose spacing is the first of four at which orders 10 and 12 agree to 1e-11; if they
    never do, the one at which they agree best.

    Parameters
    ----------
    system : System
        One, not an ensemble. Seen from the frame its torques must repeat themselves after the period.
    guess : State
        Its time is where the period starts.
    period : float
        Positive; the unit of time is that of the system.
    frame : Frame, optional
        `orbit.frame`; a `RotatingFrame` that turns with the node of the orbit. Default: the space axes.

    Raises
    ------
    ValueError
        If the frame or the system does not repeat itself, if Newton's method does not settle, or the motion is so
        unstable that its derivative is not known to 1e-5.
    """
    check_kinds("periodic_motion(system, guess, period)", {"system": (system, System), "guess": (guess, State)})
    _refuse_members("system and guess", members_of(system, guess))
    period = float(real_array("period", period, ()))
    refuse_nonpositive("period", period)
    frame = RotatingFrame((1, 0, 0, 0), (0, 0, 0)) if frame is None else checked_frame(frame)
    step = _Period(system, frame, float(guess.time), period)
    step.check_system(guess)
    step.check_frame()
    return step.motion(*step.settled(guess))


def _refuse_members(names: str, members: tuple[int, ...]) -> None:
    if members:
        raise ValueError(f"{names} must be single ones, but {members[0]} members came. Take the members one by one.")


class _Period:
    """The motion over one period. A point is a unit quaternion body -> frame and an angular momentum, body axes.

    Displacements of points are rotation vectors and momenta times period / largest moment, shape (..., 6), radians.
    """

    def __init__(self, system: System, frame: Frame, time: float, period: float) -> None:
        self.system, self.frame, self.time, self.period = system, frame, time, period
        self.momentum = float(np.max(system.body.moments)) / period

    # ------------------------------------------------------------------ points

    def displaced(self, point: tuple[Array, Array], x: Array) -> tuple[Array, Array]:
        """Return points at displacements from one."""
        from scipy.spatial.transform import Rotation

        p, g = point
        turned = rotation(p) * Rotation.from_rotvec(x[..., :3])
        return turned.as_quat(scalar_first=True), g + self.momentum * x[..., 3:]

    def displacement(self, point: tuple[Array, Array], others: tuple[Array, Array]) -> Array:
        """Return what leads from one point to others."""
        turn = rotation(point[0]).inv() * rotation(others[0])
        return np.concatenate([turn.as_rotvec(), (others[1] - point[1]) / self.momentum], axis=-1)

    def state(self, p: Array, g: Array) -> State:
        """Return the states of points at the start."""
        to_space = quat.product(self.frame.quaternion(self.time), p)
        return self.system.body.state(to_space, angular_momentum_body=g, time=self.time)

    def later(self, p: Array, g: Array) -> tuple[Array, Array]:
        """Return where points, shapes (n, 4) and (n, 3), are after the period."""
        end = self.time + self.period
        motion = propagate(self.system, self.state(p, g), [end], progress=False)
        if motion.failures:
            raise ValueError(f"guess must lead to a motion without end, but {next(iter(motion.failures.values()))}")
        to_frame = quat.conjugate(self.frame.quaternion(end))
        return quat.product(to_frame, motion.quaternion[:, 0]), motion.angular_momentum_body[:, 0]

    # ------------------------------------------------------------------ the motion that repeats itself

    def settled(self, guess: State) -> tuple[tuple[Array, Array], Array]:
        """Return where Newton's method leads, and the derivative of the motion over the period there."""
        to_frame = quat.conjugate(self.frame.quaternion(self.time))
        point = quat.product(to_frame, guess.quaternion), guess.angular_momentum_body
        for _ in range(ROUNDS):
            change, matrix = self.linear(point)
            step = np.linalg.lstsq(np.eye(6) - matrix, change, rcond=FIRM)[0]
            missed, size = (float(np.max(np.linalg.norm(x.reshape(2, 3), axis=-1))) for x in (change, step))
            point = self.displaced(point, step * (LARGEST_STEP / max(size, LARGEST_STEP)))
            if max(missed, size) < SETTLED:
                return point, self.linear(point)[1]
        raise ValueError(
            f"guess must be near a motion that repeats itself, but after {ROUNDS} steps of Newton's method it still "
            f"misses itself by {missed:.2g} rad in a period. Start nearer, or elsewhere."
        )

    def linear(self, point: tuple[Array, Array]) -> tuple[Array, Array]:
        """Return the displacement of a point after the period, (6,), and its derivative, (6, 6)."""
        best = np.inf
        for spacing in SPACINGS:
            change, slopes = self._differences(point, spacing)
            error = float(np.max(np.abs(slopes[1] - slopes[0])) / np.max(np.abs(slopes[1])))
            if error < best:
                best, matrix = error, slopes[1]
            if best < EXACT:
                break
        if not best < COARSE:
            raise ValueError(
                "guess must lead to a motion that depends smoothly on its start, but over the period "
                f"{self.period:.6g} its derivative is known to {best:.1g} of itself only. Choose a shorter period."
            )
        return change, matrix

    def _differences(self, point: tuple[Array, Array], spacing: float) -> tuple[Array, list[Array]]:
        """Return the displacement after the period, and its derivative by differences of two orders."""
        steps = np.concatenate([np.arange(1, REACH + 1), -np.arange(1, REACH + 1)]) * spacing
        x = np.concatenate([np.zeros((1, 6)), *(steps[:, None] * axis for axis in np.eye(6))])
        p, g = self.later(*self.displaced(point, x))
        change = self.displacement(point, (p[0], g[0]))
        ends = self.displacement((p[0], g[0]), (p[1:], g[1:])).reshape(6, 2, REACH, 6)
        odd = (ends[:, 0] - ends[:, 1]) / spacing
        return change, [np.einsum("k,jki->ij", _weights(reach), odd[:, :reach]) for reach in (REACH - 1, REACH)]

    def motion(self, point: tuple[Array, Array], matrix: Array) -> PeriodicMotion:
        """Return what there is to know about the motion from a point."""
        multipliers = np.linalg.eigvals(matrix)
        exponents = np.log(multipliers)
        frequencies, growth = (np.sort(part[part > SLOW]) / self.period for part in (exponents.imag, exponents.real))
        unit = np.array([1.0] * 3 + [self.momentum] * 3)
        matrix = matrix * unit[:, None] / unit
        return PeriodicMotion(self.state(*point), self.period, self.frame, matrix, multipliers, frequencies, growth)

    # ------------------------------------------------------------------ checks

    def check_frame(self) -> None:
        """Refuse a frame whose angular velocity along its own axes does not repeat itself."""
        here, there = (
            quat.rotate(quat.conjugate(self.frame.quaternion(times)), self.frame.omega_space(times))
            for times in self._times()
        )
        change, fastest = np.max(np.abs(there - here)), np.max(np.abs(here))
        if change > self._slack * fastest:
            raise ValueError(
                f"frame must turn in the same way in every period, but its angular velocity changes by "
                f"{change / fastest:.2g} of its size. A RotatingFrame turns at a constant rate."
            )

    def check_system(self, guess: State) -> None:
        """Refuse a system whose torques, seen from the frame, do not repeat themselves."""
        first, last = self.system.span
        if self.time < first or self.time + 2 * self.period > last:
            raise ValueError(
                f"period must fit twice into the span of the orbits, [{first!r}, {last!r}], but {self.period!r} came, "
                f"from {self.time!r}."
            )
        attitudes = np.random.default_rng(20061027).normal(size=(4, 1, 4))
        attitudes /= np.linalg.norm(attitudes, axis=-1, keepdims=True)
        here, there = (self._torques(times, attitudes, guess.angular_momentum_body) for times in self._times())
        change, size = np.max(np.abs(there - here)), np.max(np.abs(here))
        if not change <= self._slack * size:
            raise ValueError(
                f"system must repeat itself in the frame after the period {self.period:.6g}, but its torque changes "
                f"by {change / size:.2g} of its size. Name the period of the orbit, and the frame that turns with its "
                "node."
            )

    def _torques(self, times: Array, attitudes: Array, g: Array) -> Array:
        q = quat.product(self.frame.quaternion(times), attitudes).reshape(-1, 4)
        state = self.system.body.state(
            q, angular_momentum_body=np.broadcast_to(g, (len(q), 3)), time=np.tile(times, len(attitudes))
        )
        return np.asarray(self.system.torque_body(state))

    def _times(self) -> tuple[Array, Array]:
        """Return times in one period and in the next."""
        times = self.time + self.period * np.array([0.0, 0.13, 0.37, 0.71])
        return times, times + self.period

    @property
    def _slack(self) -> float:
        return SAME + 10 * float(np.spacing(abs(self.time) + self.period)) / self.period


def _weights(reach: int) -> Array:
    """Return what multiplies f(k h) - f(-k h) in a central difference, k = 1 ... reach, over h."""
    top = factorial(reach) ** 2
    return np.array(
        [-((-1) ** k) * top / (k * factorial(reach - k) * factorial(reach + k)) for k in range(1, reach + 1)]
    )


# ---------------------------------------------------------------------- Cassini states


@dataclasses.dataclass(frozen=True, eq=False)
class CassiniState:
    """A rotation in resonance with the orbit, whose axis precesses with the node; radians, the user's unit of time.

    Attributes
    ----------
    motion : PeriodicMotion
        In axes that turn with the node, from a passage of the periapsis.
    obliquity : float
        Of the third body axis, its mean over the period, to the normal of the orbit.
    inclination : float
        Of the same to the third space axis, the pole of the plane along which the node moves. It is the sum of
        obliquity and inclination of the orbit in Cassini state 1, their difference in state 2.
    longitude, precession, wobble : float
        Frequencies of the three free motions: about the third axis; of that axis together with the angular momentum,
        seen from the node; of the axis about the angular momentum. In (0, pi/period], see `PeriodicMotion`; NaN where
        the motion is not stable.
    """

    motion: PeriodicMotion
    obliquity: float
    inclination: float
    longitude: float
    precession: float
    wobble: float


def cassini_state(body: Body, orbit: PrecessingOrbit, spin: float = 1.0, obliquity: float = 0.0) -> CassiniState:
    """Return the Cassini state of a body under the gravity gradient of what it orbits.

    The guess, at the periapsis: the first body axis along the radius, the third normal to the orbit or tilted from
    the normal by the obliquity, away from the third space axis; it turns about the third at `spin` mean motions.

    Parameters
    ----------
    body : Body
    orbit : PrecessingOrbit
        With a periapsis that stays where it is from the node: the rate of its mean anomaly is that of the
        longitude, seen from the node.
    spin : float
        Rotations per revolution, seen from the node: 1 for moons, 1.5 for Mercury; a multiple of 1/2.
    obliquity : float
        Radians; of the guess only.

    Raises
    ------
    ValueError
        If the spin is not such a number, or as `periodic_motion`.
    """
    check_kinds("cassini_state(body, orbit)", {"body": (body, Body), "orbit": (orbit, PrecessingOrbit)})
    spin, obliquity = _checked_spin(spin), float(real_array("obliquity", obliquity, ()))
    system = System(body, GravityGradient(orbit))
    _refuse_members("body and orbit", system.members)
    time = float(orbit.epoch - orbit.phase_at(orbit.epoch) / orbit.mean_motion)
    node = RotatingFrame((1, 0, 0, 0), (0, 0, orbit.node_rate), time)
    rate = (0, 0, spin * orbit.mean_motion)
    guess = body.state(_tilted(orbit, time, obliquity), omega_body=rate, time=time, frame=node)
    motion = periodic_motion(system, guess, orbit.period if spin % 1 == 0 else 2 * orbit.period, node)
    axis, normal = _mean_axis(system, motion), orbit.frame.attitude(time).apply((0, 0, 1))
    return CassiniState(motion, _angle(axis, normal), _angle(axis, np.array([0.0, 0, 1])), *_named(motion))


def _checked_spin(spin: float) -> float:
    spin = float(real_array("spin", spin, ()))
    if spin <= 0 or 2 * spin % 1:
        raise ValueError(f"spin must be a positive multiple of 1/2, but {spin} came. It is 1 of moons, 1.5 of Mercury.")
    return spin


def _tilted(orbit: PrecessingOrbit, time: float, obliquity: float) -> Rotation:
    """Return the axes radial, transverse, normal of the orbit, turned about its ascending node."""
    from scipy.spatial.transform import Rotation

    node = orbit.angles_at(time)[0]
    return Rotation.from_rotvec(obliquity * np.array([np.cos(node), np.sin(node), 0])) * orbit.frame.attitude(time)


def _mean_axis(system: System, motion: PeriodicMotion) -> Array:
    """Return the mean direction of the third body axis in the frame of a motion, not normalised."""
    times = motion.state.time + motion.period * np.arange(SAMPLES) / SAMPLES
    along = propagate(system, motion.state, times).relative_to(motion.frame)
    return np.asarray(np.mean(along.attitude.apply((0, 0, 1)), axis=0))


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _named(motion: PeriodicMotion) -> tuple[float, float, float]:
    """Return the frequencies of longitude, precession and wobble, told apart by how axis and momentum move in them."""
    multipliers, modes = np.linalg.eig(motion.matrix)
    angles, growth = np.angle(multipliers), np.log(np.abs(multipliers))
    swings = (angles > SLOW) & (np.abs(growth) < SLOW)
    if np.sum(swings) != 3:
        return float("nan"), float("nan"), float("nan")
    frequencies, sizes = angles[swings] / motion.period, np.abs(modes[:, swings])
    across = np.hypot(sizes[0], sizes[1])
    longitude = int(np.argmax(sizes[2] / across))
    apart = np.hypot(sizes[3], sizes[4]) / across  # of momentum and axis
    precession, wobble = sorted({0, 1, 2} - {longitude}, key=lambda i: float(apart[i]))
    return float(frequencies[longitude]), float(frequencies[precession]), float(frequencies[wobble])
