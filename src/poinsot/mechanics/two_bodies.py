"""Two rigid bodies that attract each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from poinsot.algebra import quaternion as quat
from poinsot.algebra.ellipsoids import gap
from poinsot.checked import checked
from poinsot.errors import exactly_one, member_array, real_numbers, refuse_nonpositive, refuse_other_members
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude, quaternion_from_matrix, unit_quaternion
from poinsot.kinematics.frame import Frame, RelativeOrbitFrame, axes_at, checked_frame
from poinsot.kinematics.state import PairState
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Orbit
from poinsot.printable import described, quoted
from poinsot.quantities import AngularVelocity, Array, Duration, Real, Times
from poinsot.records.parameters import Parametric, Positive

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "BODIES",
    "GRAVITATIONAL_CONSTANT",
    "TwoBodies",
    "circular_orbit",
    "gap_between",
    "mean_motion",
    "refuse_overlap",
    "upright",
]

BODIES = ("primary", "secondary")
"""The names of the two."""

MU_TOLERANCE = 1e-9
"""Largest relative difference between the gravitational parameters of an orbit and of the pair."""

GRAVITATIONAL_CONSTANT = 6.6743e-11
"""m^3 / (kg s^2), CODATA 2018."""

MAX_ITERATIONS = 100
"""Largest number of iterations of Newton's method, which needs less than ten near Kepler's third law."""

OVERLAP_TOLERANCE = 1e-14
"""Largest relative overlap by rounding of ellipsoids in contact."""


def check_name_of_body(body: Any) -> str:
    """Return the name of one of the two bodies, or raise a ValueError."""
    if not isinstance(body, str) or body not in BODIES:
        raise ValueError(f"body must be 'primary' or 'secondary', got {quoted(body)}.")
    return body


class TwoBodies(Parametric):
    """Two rigid bodies that attract each other, such as a binary asteroid.

    The relative position is the position of the secondary's centre of mass relative to the primary's, along the space
    axes. The motion of the barycentre is not integrated.

    Parameters
    ----------
    primary, secondary : Body
        Bodies with masses: `Body(moments, mass=...)`, or bodies made of a shape.
    G : float
        Constant of gravitation in the units of masses and moments; by default 6.6743e-11 m^3 kg^-1 s^-2.
    masses : array (2,) or (members, 2), optional
        Masses of primary and secondary. Default: the masses of the bodies.

    Raises
    ------
    ValueError
        If a body lacks a mass, or a mass or G is not positive.

    Examples
    --------
    >>> primary = pt.Body.from_ellipsoid(5.26e11, (394, 394, 290))
    >>> pt.TwoBodies(primary, pt.Body.from_ellipsoid(4.3e9, (87, 86, 58))).masses
    array([5.26e+11, 4.30e+09])
    """

    primary: Body
    secondary: Body
    G: Positive = GRAVITATIONAL_CONSTANT
    masses: Annotated[Any, (2,)] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.masses is None and isinstance(self.primary, Body) and isinstance(self.secondary, Body):
            object.__setattr__(self, "masses", _masses(self.primary, self.secondary))
        super().__post_init__()
        if np.any(self.masses <= 0):
            raise ValueError(f"masses must be positive, got {np.asarray(self.masses).tolist()}.")
        bodies = {name: np.shape(body.moments)[:-1] for name, body in self.bodies.items()}
        refuse_other_members(**bodies, G=np.shape(self.G), masses=np.shape(self.reduced_mass))

    @property
    def bodies(self) -> dict[str, Body]:
        """Bodies by name, "primary" and "secondary"."""
        return {"primary": self.primary, "secondary": self.secondary}

    @property
    def total_mass(self) -> Array:
        """Sum of the two masses."""
        first, second = self.each_mass
        return first + second

    @property
    def reduced_mass(self) -> Array:
        """Reduced mass m1 m2 / (m1 + m2), the factor between relative velocity and momentum."""
        first, second = self.each_mass
        return first * second / (first + second)

    @property
    def mu(self) -> Array:
        """Gravitational parameter G (m1 + m2) of the relative orbit, as `KeplerOrbit` requires it."""
        return self.G * self.total_mass

    @property
    def each_mass(self) -> tuple[Array, Array]:
        """The masses, scalars of any kind."""
        first, second = self.masses if isinstance(self.masses, Vector) else np.moveaxis(self.masses, -1, 0)
        return first, second

    @checked
    def state(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        attitudes: Sequence[Rotation | ArrayLike],
        *,
        omega_body: Sequence[ArrayLike] | None = None,
        omega_space: Sequence[ArrayLike] | None = None,
        angular_momentum_body: Sequence[ArrayLike] | None = None,
        angular_momentum_space: Sequence[ArrayLike] | None = None,
        time: Times = 0.0,
        frame: Frame | Literal["orbit"] | None = None,
    ) -> PairState:
        """Return the state with a relative position and velocity, two attitudes and two angular velocities or momenta.

        Parameters
        ----------
        position, velocity : array (3,) or (members, 3)
            Position and velocity of the secondary's centre of mass relative to the primary's, space axes.
        attitudes : two of scipy Rotation or array (4,)
            Attitudes of primary and secondary, body -> space, or body -> frame if a frame is given. A quaternion is
            scalar first.
        omega_body, omega_space, angular_momentum_body, angular_momentum_space : two of array (3,)
            Angular velocities or momenta of primary and secondary, as for `Body.state`; exactly one of the four.
        time : float
            Time of the state.
        frame : Frame or "orbit", optional
            Moving axes to which attitudes and angular velocities refer. Position and velocity remain along the space
            axes. The axes "orbit" are radial from the primary to the secondary, transverse, and normal; they rotate
            with the line of centres in its plane.

        Raises
        ------
        ValueError
            If an argument does not consist of two values, or `Body.state` raises an error.

        Examples
        --------
        >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
        >>> pair = pt.TwoBodies(ball, ball, G=1.0)
        >>> start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0)] * 2, frame="orbit")
        >>> start.secondary.angular_momentum_body / 0.4  # turns with the line of centres
        array([0. , 0. , 0.5])
        """
        given = {
            "omega_body": omega_body,
            "omega_space": omega_space,
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        name, vectors = exactly_one("state", given)
        for what, pair in (("attitudes", attitudes), (name, vectors)):
            if not isinstance(pair, list | tuple | np.ndarray) or getattr(pair, "ndim", 1) == 0:
                raise TypeError(f"{what} must be two, of primary and secondary, got {described(pair)}.")
            if len(pair) != len(BODIES):
                raise ValueError(f"{what} must be two, of primary and secondary, got {len(pair)}.")
        position, velocity = member_array("position", position, (3,)), member_array("velocity", velocity, (3,))
        masses = np.shape(self.reduced_mass)
        refuse_other_members(position=position.shape[:-1], velocity=velocity.shape[:-1], masses=masses)
        if frame is not None:
            frame = _frame(frame, position, velocity)
        attitudes = [unit_quaternion(attitude, f"attitudes[{i}]") for i, attitude in enumerate(attitudes)]
        primary, secondary = (
            body.state(attitude, time=time, frame=frame, **{name: vector})
            for body, attitude, vector in zip(self.bodies.values(), attitudes, vectors, strict=True)
        )
        mass = np.asarray(self.reduced_mass)[..., None]
        start = PairState(position, mass * velocity, primary, secondary)
        semiaxes = [body.semiaxes for body in self.bodies.values()]
        if all(axes is not None for axes in semiaxes):
            first, second, place = (
                Vector(np.moveaxis(x, -1, 0))
                for x in (start.primary.quaternion, start.secondary.quaternion, start.position)
            )
            turned = Attitude.from_quaternion(first), Attitude.from_quaternion(second)
            refuse_overlap(gap_between(semiaxes, turned, place))
        return start

    @checked
    def state_on(
        self,
        orbit: Orbit,
        attitudes: Sequence[Rotation | ArrayLike],
        *,
        omega_body: Sequence[ArrayLike] | None = None,
        omega_space: Sequence[ArrayLike] | None = None,
        angular_momentum_body: Sequence[ArrayLike] | None = None,
        angular_momentum_space: Sequence[ArrayLike] | None = None,
        time: Times = 0.0,
        frame: Frame | Literal["orbit"] | None = None,
    ) -> PairState:
        """Return the state with the secondary on an orbit about the primary with given osculating elements.

        Parameters
        ----------
        orbit : Orbit
            Orbit of the secondary about the primary, such as `KeplerOrbit(pair.mu, semimajor_axis=...,
            eccentricity=...)`.
        attitudes, omega_body, omega_space, angular_momentum_body, angular_momentum_space, time, frame
            Same as in `state`.

        Raises
        ------
        ValueError
            If `orbit.mu` differs from G (m1 + m2) by more than 1e-9 of it, or `state` raises an error.

        Examples
        --------
        >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
        >>> pair = pt.TwoBodies(ball, ball, G=1.0)
        >>> orbit = pt.KeplerOrbit(pair.mu, semimajor_axis=4.0, eccentricity=0.5)
        >>> pair.state_on(orbit, [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2).position
        array([2., 0., 0.])
        """
        mu = np.asarray(orbit.mu)
        off = np.abs(mu / np.asarray(self.mu) - 1)
        if np.any(off > MU_TOLERANCE):
            raise ValueError(
                f"orbit must have mu = G (m1 + m2) = {np.ravel(self.mu)[0]:.10g}, got {np.ravel(mu)[0]:.10g}. "
                "Write KeplerOrbit(pair.mu, ...)."
            )
        path = orbit.with_axes(1)  # whose members are those of the times
        times = real_numbers("time", time)
        place = [np.stack(np.broadcast_arrays(*at(times)), axis=-1) for at in (path.position_at, path.velocity_at)]
        given = {"omega_body": omega_body, "omega_space": omega_space}
        given |= {
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        return self.state(place[0], place[1], attitudes, time=time, frame=frame, **given)

    @checked
    def synchronous(
        self,
        *,
        primary_rate: AngularVelocity,
        distance: Real | None = None,
        period: Duration | None = None,
        time: Times = 0.0,
    ) -> PairState:
        """Return the initial state of a circular orbit with a synchronous secondary.

        The gravity fields are taken to second degree. The secondary is on the first space axis and moves along the
        second. The principal axes of both bodies, from the least moment to the largest, are along the space axes, so
        the long axes are on the line of centres. The secondary rotates with the orbit. The primary rotates at
        `primary_rate` about its axis of largest moment, normal to the orbit. The orbital rate w obeys w^2 = G (m1 + m2)
        / r^3 + 3 G / (2 mu r^5) (m1 (tr I2 - 3 A2) + m2 (tr I1 - 3 D)), with the reduced mass mu, the least moment A2
        of the secondary and the mean D of the two smaller moments of the primary.

        Parameters
        ----------
        primary_rate : float
            Inertial angular velocity of the primary, radians per unit of time.
        distance, period : float
            Distance of the centres of mass, or period of the orbit; exactly one of the two.
        time : float
            Time of the state.

        Examples
        --------
        >>> primary = pt.Body.from_ellipsoid(5.26e11, (394, 394, 290))
        >>> pair = pt.TwoBodies(primary, pt.Body.from_ellipsoid(4.3e9, (87, 86, 58)))
        >>> start = pair.synchronous(period=11.92 * 3600, primary_rate=2 * np.pi / (2.26 * 3600))
        >>> start.position.round(1)
        array([1188.2,    0. ,    0. ])
        """
        given = {"distance": distance, "period": period}
        return self._circular(*circular_orbit(self, "synchronous", given, primary_turns=True), primary_rate, time)

    @checked
    def doubly_synchronous(
        self,
        *,
        distance: Real | None = None,
        period: Duration | None = None,
        rate: AngularVelocity | None = None,
        time: Times = 0.0,
    ) -> PairState:
        """Return the initial state of a circular orbit with two synchronous bodies.

        The state satisfies the equations of `synchronous`, except that D is the least moment of the primary, which also
        rotates with the orbit. With gravity of second degree the state is an exact relative equilibrium. With other
        gravity fields it is close to one.

        Parameters
        ----------
        distance, period, rate : float
            Distance of the centres of mass, period of the orbit, or angular velocity of the orbit in radians per unit
            of time; exactly one of the three.
        time : float
            Time of the state.

        Examples
        --------
        >>> body = pt.Body.from_ellipsoid(1.0, (1.2, 1.0, 0.9))
        >>> start = pt.TwoBodies(body, body, G=1.0).doubly_synchronous(distance=4.0)
        >>> (start.secondary.angular_momentum_body / body.moments).round(4)  # by Kepler 0.1768
        array([0.    , 0.    , 0.1803])
        """
        given = {"distance": distance, "period": period, "rate": rate}
        r, w = circular_orbit(self, "doubly_synchronous", given, primary_turns=False)
        return self._circular(r, w, w, time)

    def _circular(self, distance: Array, rate: Array, primary_rate: ArrayLike, time: Times) -> PairState:
        """Return the start in the plane of the first two axes with both bodies upright."""
        primary_rate = member_array("primary_rate", primary_rate, ())
        refuse_other_members(orbit=np.shape(distance), primary_rate=primary_rate.shape)
        shape = np.broadcast_shapes(np.shape(distance), np.shape(rate))
        along, across, about = (np.broadcast_to(axis, (*shape, 3)) for axis in np.eye(3))
        r, w, spin = (np.asarray(each)[..., None] for each in (distance, rate, primary_rate))
        attitudes = [upright(body) for body in self.bodies.values()]
        return self.state(r * along, r * w * across, attitudes, omega_space=[spin * about, w * about], time=time)

    @checked
    def kick(
        self,
        state: PairState,
        delta_velocity: ArrayLike,
        *,
        body: str = "secondary",
        frame: Frame | Literal["orbit"] | None = None,
    ) -> PairState:
        """Return the state after an impulse that changes the velocity of one of the bodies, such as an impact.

        A change of the secondary's velocity is added to the relative velocity, a change of the primary's is subtracted.
        The rotations do not change.

        Parameters
        ----------
        state : PairState
            State before the impulse.
        delta_velocity : array (3,) or (members, 3)
            Change of the velocity, along the space axes or the axes of a frame.
        body : {"secondary", "primary"}
            Body whose velocity changes.
        frame : Frame or "orbit", optional
            Axes of the change; "orbit" means radial, transverse, normal.

        Examples
        --------
        >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
        >>> pair = pt.TwoBodies(ball, ball, G=1.0)
        >>> start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
        >>> pair.kick(start, (0, -0.1, 0)).momentum  # 0.9 times the reduced mass
        array([0.  , 0.45, 0.  ])
        """
        check_name_of_body(body)
        change = member_array("delta_velocity", delta_velocity, (3,)) * (1 if body == "secondary" else -1)
        mass = np.asarray(self.reduced_mass)[..., None]
        refuse_other_members(state=state.shape, delta_velocity=change.shape[:-1], masses=mass.shape[:-1])
        if frame is not None:
            axes = _frame(frame, state.position, state.momentum / mass)
            change = quat.rotate(axes_at(axes, state.time)[0], change)
        return PairState(state.position, state.momentum + mass * change, state.primary, state.secondary)


def _frame(frame: Frame | str, position: Array, velocity: Array) -> Frame:
    """Return the axes that are meant; those of the orbit as they are without forces that turn its plane."""
    if isinstance(frame, str) and frame == "orbit":
        return RelativeOrbitFrame(lambda _: (position, velocity, np.zeros(3)))
    if isinstance(frame, str):
        raise ValueError(f'frame must be a Frame or "orbit", got {quoted(frame)}.')
    return checked_frame(frame)


def _masses(primary: Body, secondary: Body) -> Array:
    masses: list[Any] = []
    for name, body in zip(BODIES, (primary, secondary), strict=True):
        mass: Any = body.mass  # type: ignore[attr-defined]
        if mass is None:
            raise ValueError(
                f"{name} must have a mass, got {quoted(body)}. Give it one, Body(moments, mass=...), or make it of a "
                "shape."
            )
        masses.append(mass)
    refuse_other_members(**{f"mass of the {name}": np.shape(mass) for name, mass in zip(BODIES, masses, strict=True)})
    return np.stack(np.broadcast_arrays(*masses), axis=-1)


# ---------------------------------------------------------------------- circular orbits, to second degree of gravity


def circular_orbit(pair: TwoBodies, what: str, given: dict[str, Any], primary_turns: bool) -> tuple[Array, Array]:
    """Return distance and rate of the circular orbit with the one of distance, period and rate that is given.

    w^2 = G M / r^3 + 3 G M / (2 r^5) (s1 / m1 + s2 / m2), s = tr I - 3 A with A the moment about the line of centres:
    the least one, or the mean of the two smaller ones where the primary turns by itself.
    """
    name, value = exactly_one(what, given)
    value = member_array(name, value, ())
    refuse_nonpositive(name, value)
    mass, mu = (np.moveaxis(np.asarray(pair.masses), -1, 0), np.asarray(pair.mu))
    first, second = (np.moveaxis(np.sort(body.moments, axis=-1), -1, 0) for body in pair.bodies.values())
    along = (first[0] + first[1]) / 2 if primary_turns else first[0]
    spread = (sum(first) - 3 * along) / mass[0] + (sum(second) - 3 * second[0]) / mass[1]
    excess = 1.5 * mu * spread
    refuse_other_members(**{name: value.shape, "pair": np.shape(excess)})
    if name == "distance":
        return value, np.sqrt(mu / value**3 + excess / value**5)
    rate = value if name == "rate" else 2 * np.pi / value
    return _distance(mu, excess, rate), rate


def _distance(mu: Array, excess: Array, rate: Array) -> Array:
    """Return r of w^2 r^5 = mu r^2 + k, by Newton's method from where w^2 r^5 is more than twice each of the others."""
    r = np.maximum((2 * mu / rate**2) ** (1 / 3), (2 * excess / rate**2) ** (1 / 5))
    for _ in range(MAX_ITERATIONS):
        step = (rate**2 * r**5 - mu * r**2 - excess) / (5 * rate**2 * r**4 - 2 * mu * r)
        r = r - step
        if np.all(np.abs(step) <= np.spacing(r)):
            break
    return np.asarray(r)


def mean_motion(pair: TwoBodies, distance: Any) -> Any:
    """Return the mean motion sqrt(G M / r^3) of two point masses on a circular orbit."""
    return np.sqrt(pair.G * pair.total_mass / distance**3)


def upright(body: Body) -> Array:
    """Return the attitude with the axis of the least moment along the first space axis, the largest's along the third.

    The rotation is the identity for moments in ascending order.
    """
    order = np.argsort(np.asarray(body.moments), axis=-1, kind="stable")
    axes = np.swapaxes(body.principal_matrix, -1, -2)  # rows
    shape = np.broadcast_shapes(axes.shape[:-2], order.shape[:-1])
    axes, order = np.broadcast_to(axes, (*shape, 3, 3)), np.broadcast_to(order, (*shape, 3))
    long, short = (np.take_along_axis(axes, order[..., i, None, None], axis=-2)[..., 0, :] for i in (0, 2))
    return quaternion_from_matrix(np.stack([long, np.cross(short, long), short], axis=-2))


# ---------------------------------------------------------------------- ellipsoids apart from each other


def gap_between(semiaxes: Sequence[Any], attitudes: Sequence[Attitude], separation: Vector) -> Scalar:
    """Return the factor by which two ellipsoids must grow to touch, less one: see `algebra.ellipsoids.gap`.

    Semiaxes and attitudes are those of primary and secondary.
    """
    first, second = attitudes
    turn = [first.to_body(second.to_space(unit)) for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return gap(Vector(semiaxes[0]), Vector(semiaxes[1]), turn, first.to_body(separation))


def refuse_overlap(gaps: Any) -> None:
    """Raise a ValueError if ellipsoids overlap, by the least of the results of `gap_between`."""
    if (least := float(np.min(gaps))) < -OVERLAP_TOLERANCE:
        raise ValueError(
            f"position must separate the bodies, got ellipsoids that overlap: they touch when both are "
            f"{1 + least:.6g} times as large."
        )
