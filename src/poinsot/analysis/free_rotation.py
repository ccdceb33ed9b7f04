"""Mode, periods, amplitudes, actions and angles of a torque-free rotation."""

from __future__ import annotations

from typing import Any

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, rounded
from poinsot.double_double import DoubleDouble
from poinsot.errors import exactly_one, member_array
from poinsot.immutable import cached_property
from poinsot.kinematics.andoyer import Andoyer
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.orbits.pole import pole_attitude
from poinsot.propagation.free_motion.elements import Elements, elements_of
from poinsot.propagation.free_motion.periods import state_with_periods
from poinsot.propagation.free_motion.theta import is_near_separatrix, theta_functions
from poinsot.quantities import Angle, Duration, Time
from poinsot.records.members import members_of
from poinsot.systems.system import System
from poinsot.systems.times_and_states import broadcast_members, common_members

__all__ = ["FreeRotation"]


class FreeRotation(Summarized):
    """Torque-free rotation of a body from a state: mode, periods, actions and angles in closed form.

    The angular momentum circles either the short axis of the body (of the largest moment) or the long axis (of the
    smallest). "The axis" in the descriptions below is the axis that it circles. Every property is a number, or an array
    of shape (members,), in the user's units and radians.

    `precession_period` and `rotation_period` are P_phi and P_psi of the light-curve literature (Kaasalainen 2001, A&A
    376, 302; Pravec et al. 2014, Icarus 233, 48). Samarasinha and A'Hearn (1991, Icarus 93, 194) follow the long axis
    in both modes: their precession period is `long_axis_precession_period`. `from_periods` is the inverse.

    Parameters
    ----------
    body : Body
        Body with moments of shape (3,) or (members, 3).
    state : State
        State of the body, or one for each member.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or the numbers of members differ.

    Examples
    --------
    >>> body = pt.Body((1.0, 2.0, 2.5))
    >>> rotation = pt.analysis.FreeRotation(body, body.state((1, 0, 0, 0), omega_body=(1.0, 0.2, 0.1)))
    >>> print(rotation.mode, round(rotation.precession_period, 3), round(rotation.rotation_period, 3))
    long-axis 12.558 11.432
    """

    @checked
    def __init__(self, body: Body, state: State) -> None:
        members = common_members(System(body), state)
        self.body = body
        self.state = broadcast_members(state, members) if members else state
        self._elements = elements_of(body.moments, body.principal_matrix, self.state)

    @classmethod
    @checked
    def from_periods(
        cls,
        body: Body,
        mode: str,
        *,
        rotation_period: Duration,
        precession_period: Duration | None = None,
        long_axis_precession_period: Duration | None = None,
        longitude: Angle = 0.0,
        latitude: Angle = np.pi / 2,
        precession_angle: Angle = 0.0,
        rotation_angle: Angle = 0.0,
        axes: str = "space",
        time: Time = 0.0,
    ) -> FreeRotation:
        """Return the rotation with two published periods; its `state` is an initial state.

        x_space = R3(longitude) R2(90 deg - latitude) R3(phi) R1(theta) R3(psi) x_axes, with active rotations R and the
        principal axes in cyclic order with the axis third. theta, at most 90 deg, follows from the periods and psi. phi
        increases; psi decreases in the short-axis mode and increases in the long-axis mode.

        Parameters
        ----------
        mode : {"short-axis", "long-axis"}
            Mode of the rotation.
        rotation_period, precession_period, long_axis_precession_period : float
            P_psi and one of the precession periods, as in the properties of the same names.
        longitude, latitude : float
            Direction of the angular momentum, radians.
        precession_angle, rotation_angle : float
            phi and psi at `time`, radians.
        axes : {"space", "equatorial", "ecliptic"}
            Axes of longitude and latitude: space axes, equator or ecliptic of J2000. The latter two give states in the
            ICRF.

        Raises
        ------
        ValueError
            If no rotation of the body in this mode has these periods; the message contains the possible ratios.
        """
        given = {"precession_period": precession_period, "long_axis_precession_period": long_axis_precession_period}
        precession = exactly_one("the rotation", given)
        nodes = pole_attitude(longitude, latitude, member_array("precession_angle", precession_angle, ()), axes)
        return cls(body, state_with_periods(body, mode, rotation_period, precession, nodes, rotation_angle, time))

    # ------------------------------------------------------------------ what kind of rotation

    @property
    def mode(self) -> Any:
        """Mode of the rotation: "short-axis", "long-axis", "separatrix", "principal" or "rest".

        "principal" means steady rotation about a principal axis, including the intermediate one, and any rotation of a
        spherical body. A body with two equal moments is in the mode of its symmetry axis. Zeros and equal moments must
        be exact: moments that differ by rounding count as different.
        """
        e = self._elements
        across = e.P3.hi == 0  # a symmetric body that turns about an axis across its own
        steady = (e.P1.hi == 0) | across | _is_about_middle_axis(e) | (e.moments[0] == e.moments[2])
        return np.select(
            [e.scale == 0, steady, (e.m_other.hi == 0) & (e.r.hi > 0), e.is_long],
            ["rest", "principal", "separatrix", "long-axis"],
            "short-axis",
        )[()]

    @property
    def modulus(self) -> Any:
        """Modulus k of the elliptic functions: 0 for a symmetric body, 1 on the separatrix."""
        return self._elements.m.sqrt().hi

    @property
    def nutation_range(self) -> tuple[Any, Any]:
        """Smallest and largest angle between the axis and the angular momentum, radians."""
        e = self._elements
        across, along = np.sqrt(e.P1.hi), np.sqrt(e.P3.hi)
        with np.errstate(invalid="ignore"):
            widest = np.where(e.P1.hi > 0, np.sqrt(e.P1.hi / e.r_other.hi), 0.0)
        smallest = np.where(_is_about_middle_axis(e), np.pi / 2, np.arctan2(across, along))[()]
        return _plain(smallest), _plain(np.arctan2(widest, along * np.sqrt(e.m_other.hi)))

    # ------------------------------------------------------------------ periods

    @property
    def precession_period(self) -> Any:
        """Mean period P_phi of the axis about the angular momentum; infinite at rest."""
        return _period(self._elements.precession.hi)

    @property
    def rotation_period(self) -> Any:
        """Period P_psi of the angular momentum about the axis, relative to the body.

        Angular velocity and momentum along the body axes have this period. It is infinite on the separatrix. In steady
        rotation it is the period of an infinitesimal nutation.
        """
        return _period(self._elements.winding.hi)

    @property
    def spin_period(self) -> Any:
        """Mean period P of the rotation about the axis in space, 1/P = 1/P_phi - s/P_psi.

        s is 1 in the short-axis mode and -1 in the long-axis mode. In steady rotation P is 2 pi / |omega|.
        """
        e = self._elements
        return _period((e.precession - e.winding * e.sense).hi)

    @property
    def long_axis_precession_period(self) -> Any:
        """Mean period of the long axis about the angular momentum."""
        e = self._elements
        return _period(np.where(e.is_long, e.precession.hi, (e.precession - e.winding).hi)[()])

    # ------------------------------------------------------------------ energy

    @property
    def angular_momentum(self) -> Any:
        """Magnitude G of the angular momentum."""
        return self._elements.G.hi * self._elements.scale

    @property
    def energy(self) -> Any:
        """Kinetic energy T."""
        return self._twice_energy.hi / 2 * self._elements.scale * self._elements.scale

    @property
    def dynamic_moment(self) -> Any:
        """Dynamic moment of inertia G^2 / (2 T), between the smallest and the largest moment."""
        return (self._elements.G * self._elements.G / self._twice_energy).hi

    @property
    def energy_ratio(self) -> Any:
        """Ratio of T to the energy of rotation about the short axis with the same momentum; at least 1."""
        return np.max(self.body.moments, axis=-1) / self.dynamic_moment

    # ------------------------------------------------------------------ canonical variables

    @property
    def andoyer(self) -> Andoyer:
        """Andoyer variables of the state, relative to the given body axes."""
        return Andoyer.from_state(self.state)

    @cached_property
    def actions(self) -> tuple[Any, Any, Any]:
        """Actions (J, G, H), where J = (1 / 2 pi) times the integral of L dl over a period, about the axis.

        The energy is homogeneous in J and G, hence J = (G Omega - 2 T) / (s w), with the frequencies w and Omega of l
        and g. On the separatrix J = (2 G / pi) asin sqrt(r).
        """
        e = self._elements
        limit = np.where(e.r.hi > 0, 2 / np.pi * e.G.hi * np.arcsin(np.sqrt(e.r.hi)), e.momentum[2].hi) * e.scale
        with np.errstate(all="ignore"):
            J = ((e.G * e.precession - self._twice_energy.scaled(e.scale)) / (e.winding * e.sense)).hi * e.scale
        H = self.state.angular_momentum_space[..., 2]
        return _plain(np.where(e.winding.hi == 0, limit, J)), _plain(self.angular_momentum), _plain(H)

    @cached_property
    def angles(self) -> tuple[Any, Any, Any]:
        """Angles of the state conjugate to the actions, radians, which grow with `frequencies`.

        They are the Andoyer angles (l, g, h) without their periodic part, for the principal axes in cyclic order with
        the axis third and towards the momentum. A symmetric body has no periodic part. In steady rotation only the sum
        of l and g is defined and grows. On the separatrix, where the period is infinite, the first angle is NaN. All
        angles of a member at rest are NaN.

        Raises
        ------
        ValueError
            If a single body is at rest.
        """
        e = self._elements
        if np.all(e.scale == 0):
            raise ValueError("state must have an angular momentum for angles, but the body is at rest.")
        about_axis = Andoyer.from_state(_with_axes(self.state, e))
        rotation, periodic = _mean_angles(e)
        l = np.pi / 2 - e.sense * rotation
        g = about_axis.l + about_axis.g - periodic - l
        l = np.where(e.mean.hi == 0, np.nan, l - _angle_of_axes(e, self.body.principal_matrix))
        moving = np.where(e.scale > 0, 1.0, np.nan)
        return tuple(_plain(moving * _reduced(angle)) for angle in (l, g, about_axis.h))

    @property
    def frequencies(self) -> tuple[Any, Any, Any]:
        """Frequencies of the angles, radians per unit of time: derivatives of the energy by the actions."""
        e = self._elements
        return tuple(map(_plain, (-e.sense * e.winding.hi, e.precession.hi, np.zeros_like(e.precession.hi))))

    # ------------------------------------------------------------------ within

    @property
    def _twice_energy(self) -> DoubleDouble:
        """2 T of the momentum without its scale."""
        (I1, I2, I3), (g1, g2, g3) = self._elements.moments, self._elements.momentum
        total: DoubleDouble = g1 * g1 / I1 + g2 * g2 / I2 + g3 * g3 / I3
        return total

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Free rotation of {rounded(repr(self.body))}", {
            "mode": ", ".join(np.unique(self.mode)),
            "precession period": formatted(self.precession_period),
            "rotation period": formatted(self.rotation_period),
            "nutation range": formatted(np.stack(self.nutation_range), "rad"),
            "angular momentum": formatted(self.angular_momentum),
            "energy": formatted(self.energy),
        }


def _plain(value: Any) -> Any:
    """Return an array of members, or the number of one body as Python shows it."""
    return value if np.ndim(value) else float(value)


def _period(rate: Any) -> Any:
    with np.errstate(divide="ignore"):
        return 2 * np.pi / np.abs(rate)


def _with_axes(state: State, e: Elements) -> State:
    """Return the state of the axes 1, 2, 3 of the elements; at rest, with a momentum in place of none."""
    axes = quaternion_from_matrix(e.axes)
    size = np.where(e.scale > 0, e.scale, 1.0)
    g = np.stack(np.broadcast_arrays(*(component.hi * size for component in e.momentum)), axis=-1)
    return State.computed({"quaternion": quat.product(state.quaternion, axes), "angular_momentum_body": g}, state.time)


def _is_about_middle_axis(e: Elements) -> Any:
    return (e.momentum[0].hi == 0) & (e.momentum[2].hi == 0)


def _angle_of_axes(e: Elements, principal: Any) -> Any:
    """Return the angle about the axis 3 from the principal axes in cyclic order to the axes of the elements.

    The axes of the elements depend on the quadrant in which the momentum starts; the principal ones do not.
    """
    along = np.swapaxes(principal, -1, -2) @ e.axes
    third = np.argmax(np.abs(along[..., 2]), axis=-1)

    def entry(row: Any, column: int) -> Any:
        return np.take_along_axis(along[..., column], row[..., None] % 3, axis=-1)[..., 0]

    quarter = np.arctan2(entry(third + 2, 0) * np.sign(entry(third, 2)), entry(third + 1, 0)) / (np.pi / 2)
    return np.rint(quarter) * (np.pi / 2)


def _mean_angles(e: Elements) -> tuple[Any, Any]:
    """Return pi u / (2 K) at the start and the periodic part of g + l, radians."""
    near = np.asarray(is_near_separatrix(e))
    rotation, periodic = np.empty(near.shape), np.empty(near.shape)
    for side in (near, ~near):
        if np.any(side):
            theta = theta_functions(members_of(e, side), bool(np.all(near[side])))
            endless = e.mean.hi[side] == 0
            rotation[side] = np.where(endless, 0.0, e.mean.hi[side] * np.where(endless, 0.0, theta.start))
            periodic[side] = -np.squeeze(theta.sense * theta.first_angle, axis=-1) * 2
    return rotation[()], periodic[()]


def _reduced(angle: Any) -> Any:
    return np.arctan2(np.sin(angle), np.cos(angle))
