"""Periodic motions in a moving frame, their small oscillations and stability.

x = (rotation vector, change of angular momentum), both along the body axes, becomes matrix x a period later, to first
order. Newton's method finds the zero of the displacement over a period; the eigenvalues of the matrix are Floquet's
multipliers. Under a force with that period it is the forced motion, with all free oscillations removed: the libration
of a moon on an ellipse, or, seen from axes that turn with the node of the orbit, its rotation in a Cassini state.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.analysis.multipliers import SLOW, Multipliers
from poinsot.analysis.pair_equilibrium import refuse_open
from poinsot.analysis.pair_period_map import PairPeriodMap
from poinsot.analysis.period_map import PeriodMap, Point
from poinsot.checked import checked
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.forces.gravity import GravityGradient
from poinsot.html_text import Summarized, rounded, told
from poinsot.mechanics.body import Body
from poinsot.mechanics.frame import Frame, RotatingFrame, checked_frame
from poinsot.mechanics.pair_system import PairSystem
from poinsot.mechanics.state import PairState, State
from poinsot.mechanics.system import System
from poinsot.mechanics.units import DerivedUnits
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.printable import described, kind_of
from poinsot.propagation.arguments import members_of
from poinsot.propagation.propagate import propagate
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Inclination

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["CassiniState", "PeriodicMotion", "cassini_state", "periodic_motion", "recognised"]

Array = NDArray[Any]

SAMPLES = 256
"""Of a mean over a period."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PeriodicMotion(Summarized):
    """A motion that repeats itself in a frame, and the small motion about it; radians, the user's unit of time.

    Attributes
    ----------
    system : System
    state : State
        Where it starts.
    period : float
    frame : Frame
    matrix : array (k, k)
        x(t + period) = matrix x(t) from the time of the state, x = (rotation vector relative to the frame, change of
        angular momentum, body axes, changes of the variables of parts); k = 6 without parts. Of two bodies k = 18, in
        the order of `state_transition`.
    multipliers : complex array (k,)
        Its eigenvalues; of two bodies those among motions of the same energy and momenta, up to turns and times: 12,
        two less for each body with an axis of symmetry, 14 at a relative equilibrium.
    frequencies : array, ascending
        Positive angles of the multipliers over the period, in (0, pi/period]: a motion looked at once in a period
        does not distinguish w from 2 pi/period - w and from w + 2 pi/period.
    growth_rates : array, ascending
        Positive logarithms of their moduli over the period. Both without those below 1e-6/period.

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
    state: State
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
        times = self.state.time + self.period * np.arange(SAMPLES) / SAMPLES
        return self.period * float(np.mean(np.linalg.norm(self.frame.omega_space(times), axis=-1)))

    @property
    def rotations(self) -> Array:
        """Rotations of each body in a period, from its mean angular velocity in space; shape (1,), for two bodies (2,).

        Newton's method may lead from a guess to another resonance than that meant: 1 is synchronous, 3 in two orbits
        that of Mercury.
        """
        each = self.over_period().of_bodies.values()
        means = [np.linalg.norm(np.mean(one.omega_space, axis=0)) for one in each]
        return self.period / (2 * np.pi) * np.array(means)

    @checked
    def over_period(self, count: int = SAMPLES) -> Trajectory:
        """Return the motion at evenly spaced times of one period, from its start on and without its end."""
        refuse_nonpositive("count", count)
        return propagate(self.system, self.state, self.state.time + self.period * np.arange(count) / count)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        units = DerivedUnits(self.system.units)
        return f"Periodic motion of {rounded(repr(self.system))}", {
            "period": told(self.period, units.time),
            "stable": "yes" if self.stable else "no",
            "frequencies": told(self.frequencies, units.rate_in_words),
            "growth rates": told(self.growth_rates, units.per_time),
            "rotations in a period": told(np.round(self.rotations, 6), ""),
            "turn of the frame in a period": told(self.turn, "rad"),
            **{
                f"{body and f'{body}: '}{what}": told(value, unit)
                for body, state in self.state.of_bodies.items()
                for what, value, unit in (
                    ("attitude at the start (quaternion, body to space)", state.quaternion, ""),
                    ("angular momentum at the start (body axes)", state.angular_momentum_body, units.momentum),
                )
            },
        }


@checked
def periodic_motion(system: System, guess: State, period: float, frame: Frame | None = None) -> PeriodicMotion:
    """Return the motion near a guess that repeats itself in a frame after one period.

    Newton's method on the motion over a period, with its state-transition matrix. From far away it may lead to another
    resonance: see `rotations` of the result.

    Parameters
    ----------
    system : System
        One, not an ensemble. Seen from the frame its torques must repeat themselves after the period, and its parts.
        Or of two bodies, under potentials that conserve energy and angular momentum.
    guess : State
        Its time is where the period starts. The motion of two bodies has its energy and angular momentum.
    period : float
        Positive; the unit of time is that of the system. That of two bodies is found near it.
    frame : Frame, optional
        `orbit.frame`; a `RotatingFrame` that turns with the node of the orbit. Default: the space axes. Two bodies
        repeat themselves in a `RotatingFrame` about their total angular momentum, which is found, up to spins of
        bodies about axes of symmetry.

    Raises
    ------
    ValueError
        If the frame or the system does not repeat itself, or if Newton's method does not settle.

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
    _refuse_members("system and guess", members_of(system, guess))
    period = float(real_array("period", period, (), system.units["time"]))
    refuse_nonpositive("period", period)
    if isinstance(system, PairSystem) != isinstance(guess, PairState):
        wanted = "PairState of two bodies" if isinstance(system, PairSystem) else "State of one body"
        raise TypeError(f"guess must be a {wanted}, got a {kind_of(guess)}. system.state makes it.")
    if isinstance(system, PairSystem):
        if frame is not None:
            raise ValueError(f"frame must be left out of two bodies, got {described(frame)}. The motion has its own.")
        return _of_pair(system, guess, period)
    frame = RotatingFrame((1, 0, 0, 0), (0, 0, 0)) if frame is None else checked_frame(frame)
    once = PeriodMap(system, frame, guess, period)
    once.check()
    return recognised(once, *once.settled(guess))


def recognised(once: PeriodMap, point: Point, matrix: Array) -> PeriodicMotion:
    """Return what there is to know about the motion that a period leads back to its point."""
    matrix_of_user = matrix * once.units[:, None] / once.units
    return _motion(once.system, once.state(point), once.period, once.frame, matrix_of_user, matrix)


def _motion(system: System, state: State, period: float, frame: Frame, matrix: Array, free: Array) -> PeriodicMotion:
    """Return a motion with the multipliers of a matrix of displacements that no symmetry leaves alone."""
    multipliers = Multipliers(free).values
    with np.errstate(divide="ignore"):  # what a sample sets anew has the multiplier 0
        exponents = np.log(multipliers)
    frequencies, growth = (np.sort(part[part > SLOW]) / period for part in (exponents.imag, exponents.real))
    return PeriodicMotion(system, state, period, frame, matrix, multipliers, frequencies, growth)


def _of_pair(system: PairSystem, guess: Any, period: float) -> PeriodicMotion:
    """Return the motion of two bodies that repeats itself in axes that turn about their angular momentum."""
    refuse_open(system, guess)
    once = PairPeriodMap(system, guess)
    point, period, passage = once.settled(period)
    state, about = point.state(guess.time), once.about(point)
    turn = passage.turn + 2 * np.pi * _revolutions(system, state, period, about, passage.turn)
    frame = RotatingFrame((1, 0, 0, 0), turn / period * about, state.time)
    matrix = passage.matrix * once.units[:, None] / once.units
    return _motion(system, state, period, frame, matrix, once.reduced(point, passage.matrix))


def _revolutions(system: PairSystem, state: PairState, period: float, about: Array, turn: float) -> float:
    """Return how often the line of centres turns in a period beyond a turn in (-pi, pi]."""
    motion: Any = propagate(system, state, state.time + period * np.arange(SAMPLES + 1) / SAMPLES)
    first = state.position - (state.position @ about) * about
    longitudes = np.unwrap(np.arctan2(motion.position @ np.cross(about, first), motion.position @ first))
    return float(np.round((longitudes[-1] - longitudes[0] - turn) / (2 * np.pi)))


def _refuse_members(names: str, members: tuple[int, ...]) -> None:
    if members:
        raise ValueError(f"{names} must be single ones, got {members[0]} members. Take the members one by one.")


# ---------------------------------------------------------------------- Cassini states


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class CassiniState(Summarized):
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
            "obliquity": told(self.obliquity, "rad"),
            "inclination": told(self.inclination, "rad"),
            **{f"frequency of {name}": told(getattr(self, name), units.rate_in_words) for name in names},
            "period": told(self.motion.period, units.time),
        }


@checked
def cassini_state(body: Body, orbit: PrecessingOrbit, spin: float = 1.0, obliquity: Inclination = 0.0) -> CassiniState:
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
    return CassiniState(motion, _angle(axis, normal), _angle(axis, np.array([0.0, 0, 1])), *_named(motion))


def _checked_spin(spin: float) -> float:
    spin = float(real_array("spin", spin, ()))
    if spin <= 0 or 2 * spin % 1:
        raise ValueError(f"spin must be a positive multiple of 1/2, got {spin}. It is 1 of moons, 1.5 of Mercury.")
    return spin


def _tilted(orbit: PrecessingOrbit, time: float, obliquity: float) -> Rotation:
    """Return the axes radial, transverse, normal of the orbit, turned about its ascending node."""
    from scipy.spatial.transform import Rotation

    node = orbit.angles_at(time)[0]
    return Rotation.from_rotvec(obliquity * np.array([np.cos(node), np.sin(node), 0])) * orbit.frame.attitude(time)


def _mean_axis(motion: PeriodicMotion) -> Array:
    """Return the mean direction of the third body axis in the frame of a motion, not normalised."""
    along = motion.over_period().relative_to(motion.frame)
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
