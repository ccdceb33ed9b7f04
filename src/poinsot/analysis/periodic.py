"""Periodic motions in a moving frame, their small oscillations and stability.

The vector x = (rotation vector, change of angular momentum), both along the body axes, becomes matrix x a period later,
to first order. Newton's method finds the zero of the displacement over a period. The eigenvalues of the matrix are
Floquet's multipliers. Under a force with this period the periodic motion is the forced motion without free
oscillations: the libration of a moon on an ellipse, or, seen from axes that turn with the node of the orbit, its
rotation in a Cassini state.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import override

from poinsot.analysis.multipliers import MULTIPLIER_TOLERANCE, Multipliers
from poinsot.analysis.pair_point import refuse_open
from poinsot.analysis.period_map import PairPeriodMap, PeriodMap, Point
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, rounded
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.forces.gravity import GravityGradient
from poinsot.kinematics.frame import Frame, RotatingFrame, checked_frame
from poinsot.kinematics.state import AnyState, PairState, State
from poinsot.mechanics.body import Body
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.printable import described, kind_of
from poinsot.propagation.propagate import propagate
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Inclination
from poinsot.records.units import DerivedUnits
from poinsot.systems.system import System, is_of_two_bodies
from poinsot.systems.times_and_states import common_members

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["CassiniState", "PeriodicMotion", "cassini_state", "motion_at", "periodic_motion"]

SAMPLES_PER_PERIOD = 256
"""Number of samples of a mean over a period."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PeriodicMotion(Summarized):
    """Motion that is periodic in a frame, with the Floquet multipliers of small motions about it.

    Attributes
    ----------
    system : System
        System that was integrated.
    state : State or PairState
        Initial state of the period.
    period : float
        Period in the user's unit of time.
    frame : Frame
        Frame in which the motion is periodic.
    matrix : array (k, k)
        Monodromy matrix, x(t + period) = matrix x(t) from the time of the state, x = (rotation vector relative to the
        frame, change of angular momentum, body axes, changes of the variables of parts); k = 6 without parts, and 18
        for two bodies, in the order of `state_transition`.
    multipliers : complex array (k,)
        Eigenvalues of the matrix. For two bodies, the multipliers of motions with equal energy and momenta, without
        rotations and shifts of time: 12, less two for each body with an axis of symmetry, and 14 at a relative
        equilibrium.
    frequencies : array, ascending
        Positive angles of the multipliers divided by the period, in (0, pi/period]. Sampling once per period does not
        distinguish w from 2 pi/period - w and from w + 2 pi/period.
    growth_rates : array, ascending
        Positive logarithms of the moduli of the multipliers divided by the period. Frequencies and growth rates below
        1e-6/period are omitted.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    >>> facing = moon.body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> libration = pt.analysis.periodic_motion(moon, facing, orbit.period)
    >>> libration.stable, libration.frequencies.round(3)
    (True, array([0.432, 0.454, 0.496]))
    """

    system: System
    state: AnyState
    period: float
    frame: Frame
    matrix: Array
    multipliers: Array
    frequencies: Array
    growth_rates: Array

    @property
    def stable(self) -> bool:
        """True if no solution of the linear equations grows exponentially."""
        return not self.growth_rates.size

    @property
    def turn(self) -> float:
        """Angle by which the frame rotates in a period; for two bodies, about their total angular momentum."""
        times = self.state.time + self.period * np.arange(SAMPLES_PER_PERIOD) / SAMPLES_PER_PERIOD
        return self.period * float(np.mean(np.linalg.norm(self.frame.omega_space(times), axis=-1)))

    @property
    def rotations(self) -> Array:
        """Number of rotations of each body in a period, from its mean angular velocity in space; shape (1,) or (2,).

        Newton's method may converge to another resonance than the intended one. In one orbit, 1 is synchronous; in two
        orbits, 3 is the resonance of Mercury.
        """
        each = self.over_period().of_bodies.values()
        means = [np.linalg.norm(np.mean(one.omega_space, axis=0)) for one in each]
        return self.period / (2 * np.pi) * np.array(means)

    @checked
    def over_period(self, count: int = SAMPLES_PER_PERIOD) -> Trajectory:
        """Return the motion at evenly spaced times of one period, including its initial state but not its end."""
        refuse_nonpositive("count", count)
        return propagate(self.system, self.state, self.state.time + self.period * np.arange(count) / count)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        units = DerivedUnits(self.system.units)
        return f"Periodic motion of {rounded(repr(self.system))}", {
            "period": formatted(self.period, units.time),
            "stable": "yes" if self.stable else "no",
            "frequencies": formatted(self.frequencies, units.rate_in_words),
            "growth rates": formatted(self.growth_rates, units.per_time),
            "rotations in a period": formatted(np.round(self.rotations, 6), ""),
            "turn of the frame in a period": formatted(self.turn, "rad"),
            **{
                f"{body and f'{body}: '}{what}": formatted(value, unit)
                for body, state in self.state.of_bodies.items()
                for what, value, unit in (
                    ("attitude at the start (quaternion, body to space)", state.quaternion, ""),
                    ("angular momentum at the start (body axes)", state.angular_momentum_body, units.momentum),
                )
            },
        }


@checked
def periodic_motion(system: System, guess: AnyState, period: float, frame: Frame | None = None) -> PeriodicMotion:
    """Return the motion near a guess that is periodic in a frame.

    Newton's method uses the state-transition matrix over a period. From a distant guess it may converge to another
    resonance; `rotations` of the result identifies the resonance.

    Parameters
    ----------
    system : System
        System, not an ensemble. Its torques and parts must be periodic in the frame. A system of two bodies must
        conserve energy and angular momentum.
    guess : State or PairState
        Guess at the time at which the period begins. The motion of two bodies has its energy and angular momentum.
    period : float
        Period in the unit of time, positive. For two bodies, a guess of the period.
    frame : Frame, optional
        `orbit.frame`, or a `RotatingFrame` that rotates with the node of the orbit. Default: the space axes. For two
        bodies the function finds the `RotatingFrame` about the total angular momentum; the motion is periodic up to
        spins of bodies about axes of symmetry.

    Returns
    -------
    PeriodicMotion
        Periodic motion with its Floquet multipliers.

    Raises
    ------
    ValueError
        If the frame or the system is not periodic, or if Newton's method does not converge.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    >>> moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    >>> facing = moon.body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> libration = pt.analysis.periodic_motion(moon, facing, orbit.period)
    >>> back = pt.propagate(moon, libration.state, [2 * orbit.period])
    >>> float(np.max(np.abs(back.quaternion[0] - libration.state.quaternion))) < 1e-12
    True
    """
    _refuse_members("system and guess", common_members(system, guess))
    period = float(real_array("period", period, (), system.units["time"]))
    refuse_nonpositive("period", period)
    if is_of_two_bodies(system) and isinstance(guess, PairState):
        if frame is not None:
            raise ValueError(f"frame must be left out of two bodies, got {described(frame)}. The motion has its own.")
        return _of_pair(system, guess, period)
    if is_of_two_bodies(system) or not isinstance(guess, State):
        wanted = "PairState of two bodies" if len(system.of_bodies) > 1 else "State of one body"
        raise TypeError(f"guess must be a {wanted}, got a {kind_of(guess)}. system.state makes it.")
    frame = RotatingFrame((1, 0, 0, 0), (0, 0, 0)) if frame is None else checked_frame(frame)
    mapping = PeriodMap(system, frame, guess, period)
    mapping.check()
    return motion_at(mapping, *mapping.fixed_point(guess))


def motion_at(mapping: PeriodMap, point: Point, matrix: Array) -> PeriodicMotion:
    """Return the periodic motion at a fixed point of a period map, from the derivative of the map there."""
    matrix_of_user = matrix * mapping.units[:, None] / mapping.units
    return _motion(mapping.system, mapping.state(point), mapping.period, mapping.frame, matrix_of_user, matrix)


def _motion(system: System, state: AnyState, period: float, frame: Frame, matrix: Array, free: Array) -> PeriodicMotion:
    """Return a motion with the multipliers of a matrix of displacements across the symmetries."""
    multipliers = Multipliers(free).values
    with np.errstate(divide="ignore"):  # a variable that a sample replaces has the multiplier 0
        exponents = np.log(multipliers)
    frequencies, growth = (
        np.sort(part[part > MULTIPLIER_TOLERANCE]) / period for part in (exponents.imag, exponents.real)
    )
    return PeriodicMotion(system, state, period, frame, matrix, multipliers, frequencies, growth)


def _of_pair(system: System[TwoBodies], guess: Any, period: float) -> PeriodicMotion:
    """Return the motion of two bodies that is periodic in axes that turn about their angular momentum."""
    refuse_open(system, guess)
    mapping = PairPeriodMap(system, guess)
    point, period, passage = mapping.fixed_point(period)
    state, about = point.state(guess.time), mapping.about(point)
    turn = passage.turn + 2 * np.pi * _revolutions(system, state, period, about, passage.turn)
    frame = RotatingFrame((1, 0, 0, 0), turn / period * about, state.time)
    matrix = passage.matrix * mapping.units[:, None] / mapping.units
    return _motion(system, state, period, frame, matrix, mapping.reduced(point, passage.matrix))


def _revolutions(system: System[TwoBodies], state: PairState, period: float, about: Array, turn: float) -> float:
    """Return the number of whole turns of the line of centres in a period, beyond a turn in (-pi, pi]."""
    motion: Any = propagate(system, state, state.time + period * np.arange(SAMPLES_PER_PERIOD + 1) / SAMPLES_PER_PERIOD)
    first = state.position - (state.position @ about) * about
    longitudes = np.unwrap(np.arctan2(motion.position @ np.cross(about, first), motion.position @ first))
    return float(np.round((longitudes[-1] - longitudes[0] - turn) / (2 * np.pi)))


def _refuse_members(names: str, members: tuple[int, ...]) -> None:
    if members:
        raise ValueError(f"{names} must be single ones, got {members[0]} members. Take the members one by one.")


# ---------------------------------------------------------------------- Cassini states


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class CassiniState(Summarized):
    """Cassini state: rotation in resonance with the orbit, with an axis that precesses with the node of the orbit.

    All angles are in radians, and frequencies in radians per unit of time.

    Attributes
    ----------
    motion : PeriodicMotion
        Periodic motion in axes that rotate with the node, from a passage of the periapsis.
    obliquity : float
        Mean angle between the third body axis and the normal of the orbit over the period.
    inclination : float
        Mean angle between the third body axis and the third space axis, the pole of the plane along which the node
        moves. It is the sum of obliquity and inclination of the orbit in Cassini state 1, and their difference in state
        2.
    longitude, precession, wobble : float
        Frequencies of the free librations, in (0, pi/period], see `PeriodicMotion`: libration about the third axis;
        precession of this axis together with the angular momentum, relative to the node; wobble of the axis about the
        angular momentum. NaN if the motion is not stable.

    Examples
    --------
    >>> ellipse = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.01, inclination=0.1)
    >>> orbit = pt.orbits.PrecessingOrbit(ellipse, node_rate=-1e-3)
    >>> moon = pt.Body.from_ratios(beta=6e-4, gamma=2e-4)
    >>> found = pt.analysis.cassini_state(moon, orbit)
    >>> round(found.obliquity - found.inclination, 3)  # the inclination of the orbit: Cassini state 2
    0.1
    """

    motion: PeriodicMotion
    obliquity: float
    inclination: float
    longitude: float
    precession: float
    wobble: float

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        units = DerivedUnits(self.motion.system.units)
        names = ("longitude", "precession", "wobble")
        return f"Cassini state of {rounded(repr(self.motion.system))}", {
            "obliquity": formatted(self.obliquity, "rad"),
            "inclination": formatted(self.inclination, "rad"),
            **{f"frequency of {name}": formatted(getattr(self, name), units.rate_in_words) for name in names},
            "period": formatted(self.motion.period, units.time),
        }


@checked
def cassini_state(body: Body, orbit: PrecessingOrbit, spin: float = 1.0, obliquity: Inclination = 0.0) -> CassiniState:
    """Return the Cassini state of a body under the gravity gradient of the attractor of its orbit.

    The initial guess is at the periapsis. The first body axis is along the radius. The third is normal to the orbit or
    tilted from the normal by the obliquity, away from the third space axis. The body rotates about the third axis at
    `spin` mean motions.

    Parameters
    ----------
    body : Body
        Body, not an ensemble.
    orbit : PrecessingOrbit
        Orbit whose periapsis is fixed relative to the node: the rates of its mean anomaly and of its longitude relative
        to the node are equal.
    spin : float
        Rotations per revolution relative to the node: 1 for moons, 1.5 for Mercury; a multiple of 1/2.
    obliquity : float
        Obliquity of the guess, radians.

    Returns
    -------
    CassiniState
        The periodic rotation with its obliquity and free frequencies.

    Raises
    ------
    ValueError
        If the spin is not a multiple of 1/2, or `periodic_motion` raises an error.

    Examples
    --------
    >>> ellipse = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.01, inclination=0.1)
    >>> orbit = pt.orbits.PrecessingOrbit(ellipse, node_rate=-1e-3)
    >>> found = pt.analysis.cassini_state(pt.Body.from_ratios(beta=6e-4, gamma=2e-4), orbit)
    >>> found.motion.stable
    True
    """
    spin, obliquity = _checked_spin(spin), float(real_array("obliquity", obliquity, ()))
    system = System(body, GravityGradient(orbit))
    _refuse_members("body and orbit", system.members)
    time = float(orbit.epoch - orbit.phase_at(orbit.epoch) / orbit.mean_motion)
    node = RotatingFrame((1, 0, 0, 0), np.array((0, 0, orbit.node_rate)), time)
    rate = (0, 0, spin * orbit.mean_motion)
    guess = body.state(_tilted(orbit, time, obliquity), omega_body=rate, time=time, frame=node)
    motion = periodic_motion(system, guess, orbit.period if spin % 1 == 0 else 2 * orbit.period, node)
    axis, normal = _mean_axis(motion), orbit.frame.attitude(time).apply((0, 0, 1))
    return CassiniState(motion, _angle(axis, normal), _angle(axis, np.array([0.0, 0, 1])), *_free_librations(motion))


def _checked_spin(spin: float) -> float:
    spin = float(real_array("spin", spin, ()))
    if spin <= 0 or 2 * spin % 1:
        raise ValueError(f"spin must be a positive multiple of 1/2, got {spin}. It is 1 of moons, 1.5 of Mercury.")
    return spin


def _tilted(orbit: PrecessingOrbit, time: float, obliquity: float) -> Rotation:
    """Return the axes radial, transverse, normal of the orbit, turned about its ascending node."""
    from scipy.spatial.transform import Rotation

    node: Any = orbit.angles_at(time)[0]
    return Rotation.from_rotvec(obliquity * np.array([np.cos(node), np.sin(node), 0])) * orbit.frame.attitude(time)


def _mean_axis(motion: PeriodicMotion) -> Array:
    """Return the mean direction of the third body axis in the frame of a motion, not normalised."""
    along = motion.over_period().relative_to(motion.frame)
    return np.asarray(np.mean(along.attitude.apply((0, 0, 1)), axis=0))


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _free_librations(motion: PeriodicMotion) -> tuple[float, float, float]:
    """Return the frequencies of longitude, precession and wobble, identified by the motion of axis and momentum."""
    multipliers, modes = np.linalg.eig(motion.matrix)
    angles, growth = np.angle(multipliers), np.log(np.abs(multipliers))
    swings = (angles > MULTIPLIER_TOLERANCE) & (np.abs(growth) < MULTIPLIER_TOLERANCE)
    if np.sum(swings) != 3:
        return float("nan"), float("nan"), float("nan")
    frequencies, sizes = angles[swings] / motion.period, np.abs(modes[:, swings])
    across = np.hypot(sizes[0], sizes[1])
    longitude = int(np.argmax(sizes[2] / across))
    ratio = np.hypot(sizes[3], sizes[4]) / across  # amplitude of the momentum relative to the axis
    precession, wobble = sorted({0, 1, 2} - {longitude}, key=lambda i: float(ratio[i]))
    return float(frequencies[longitude]), float(frequencies[precession]), float(frequencies[wobble])
