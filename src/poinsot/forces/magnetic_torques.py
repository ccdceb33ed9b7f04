"""Torques of a magnetic field on a dipole moment, on eddy currents, and on magnetorquers."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import array_of
from poinsot.forces.magnetic_fields import MagneticField
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.force import Potential, Torque
from poinsot.mechanics.instant import Instant
from poinsot.quantities import OR_NUMBER, Along, BodyVector, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Gain, Positive

__all__ = ["BDot", "EddyCurrents", "MagneticMoment"]


class MagneticMoment(Potential):
    """Torque on a magnetic dipole fixed in the body: a permanent magnet, or the residual dipole of a spacecraft.

    U = -m . B, so the torque is m x B. The model ignores the force on the orbit.

    Parameters
    ----------
    moment : array (3,), body axes
        Dipole moment m, in A m2.
    field : MagneticField
        Magnetic field B along the orbit, in tesla.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=6871.2, eccentricity=0.0)  # km, s
    >>> earth = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.292115e-5)
    >>> field = pt.forces.TiltedDipole(orbit, earth, -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2)
    >>> system = pt.System(pt.Body((0.02, 0.025, 0.012)), pt.forces.MagneticMoment((0, 0, 0.05), field))
    >>> (1e9 * system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0)))).round()  # nN m
    array([ -56., -362.,    0.])
    """

    formula = "U = -dot(moment, B)"
    moment: BodyVector
    field: MagneticField

    @override
    def energy(self, instant: Instant) -> Scalar:
        return -functions.dot(self.moment, self.field.in_body(instant))

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        return self.field.validity(instant)


def _refuse_indefinite(name: str, tensor: Any, hint: str) -> None:
    """Raise a ValueError for a tensor whose torque could increase the energy."""
    size = np.max(np.abs(tensor), axis=(-1, -2), keepdims=True)
    skew = np.max(tensor - np.swapaxes(tensor, -1, -2) - 1e-12 * size)
    least = np.min(np.linalg.eigvalsh(tensor) + 1e-12 * size[..., 0])
    if skew > 0 or least < 0:
        what = "one that is not symmetric" if skew > 0 else f"the eigenvalue {least:.6g}"
        raise ValueError(f"{name} must be symmetric and not negative, got {what}. {hint}")


class EddyCurrents(Torque):
    """Torque of the eddy currents that a magnetic field induces in a rotating, conducting body.

    tau = (M (omega x B)) x B (Ortiz Gomez and Walker 2015, Adv. Space Res. 56, 494). The torque dissipates energy if
    the angular velocity is not parallel to the field. The model ignores the variation of the field along the orbit,
    which matters for a body that rotates about once per orbit.

    Parameters
    ----------
    tensor : float or array (3, 3), body axes
        Magnetic tensor M in S m4. A number k stands for k times the unit tensor. A thin spherical shell of conductivity
        s, radius R and thickness e has the tensor 2 pi/3 s e R^4.
    field : MagneticField
        Magnetic field along the orbit, in tesla.

    Raises
    ------
    ValueError
        If the tensor is not symmetric or has a negative eigenvalue.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(6871.2, 0, 0))
    >>> axes = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.0)
    >>> field = pt.forces.TiltedDipole(orbit, axes, -3e-5, 0.0, 0.0, 6371.2)
    >>> system = pt.System(pt.Body((1, 2, 2.5)), pt.forces.EddyCurrents(1e6, field))
    >>> round(1e6 * float(system.torque_body(system.state((1, 0, 0, 0), omega_body=(0.1, 0, 0)))[0]), 1)
    -57.2
    """

    formula = "N = cross(tensor*(cross(omega, B)), B)"
    tensor: Annotated[Any, (3, 3), OR_NUMBER, Along("body axes"), Rule(_refuse_indefinite, "It must take energy.")]
    field: MagneticField

    def __post_init__(self) -> None:
        coefficient = array_of("tensor", self.tensor)
        if coefficient.ndim < 2 and coefficient.dtype.kind in "iuf":
            object.__setattr__(self, "tensor", coefficient[..., None, None] * np.eye(3))
        super().__post_init__()

    @override
    def torque(self, instant: Instant) -> Vector:
        field = self.field.in_body(instant)
        across = functions.cross(instant.omega_body, field)
        currents = Vector(functions.dot(self.tensor[i], across) for i in range(3))
        return functions.cross(currents, field)

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        return self.field.validity(instant)


class BDot(Torque):
    """Magnetic detumbling torque: a magnetorquer moment against the rate of change of the field in body axes.

    m = -gain dB/dt with each component limited to +-limit, tau = m x B (Stickler and Alfriend 1976, J. Spacecraft 13,
    282). Actuator and magnetometer are ideal, without delay or noise. The final angular velocity is about twice the
    mean motion, because the field itself rotates along the orbit.

    Parameters
    ----------
    gain : float
        Gain in A m2 s/T. A negative gain causes a warning. A suitable value is 2 n (1 + sin i) I / B^2 with the
        smallest moment of inertia I, the mean motion n and the inclination i to the magnetic equator (Avanzini and
        Giulietti 2012, J. Guid. Control Dyn. 35, 1326; their gain includes the factor B^2).
    field : MagneticField
        Magnetic field along the orbit, in tesla.
    limit : float
        Largest moment about each body axis, in A m2; positive.

    Raises
    ------
    ValueError
        If the limit is not positive.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(6871.2, 0, 0))
    >>> axes = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=0.0)
    >>> field = pt.forces.TiltedDipole(orbit, axes, -3e-5, 0.0, 0.0, 6371.2)
    >>> system = pt.System(pt.Body((1, 2, 2.5)), pt.forces.BDot(1e5, field, 0.2))
    >>> round(1e6 * float(system.torque_body(system.state((1, 0, 0, 0), omega_body=(0.1, 0, 0)))[0]), 1)
    -4.8
    """

    formula = "N = cross(m, B); m = clip(-(gain*rate(B)), -limit, limit)"
    gain: Gain
    field: MagneticField
    limit: Positive

    @of_scalars
    def moment(self, instant: Instant) -> Vector:
        """Return the magnetic moment of the torquers, A m2, along the body axes."""
        rate = self.field.rate_in_body(instant)
        return Vector(functions.clip(-self.gain * x, -self.limit, self.limit) for x in rate)

    @override
    def torque(self, instant: Instant) -> Vector:
        return functions.cross(self.moment(instant), self.field.in_body(instant))

    @override
    def limits(self, instant: Instant, torque: Vector | None = None) -> Mapping[str, Scalar]:
        largest = functools.reduce(functions.maximum, map(abs, self.moment(instant)))
        return {"b_dot_at_limit": largest >= self.limit}

    @override
    def validity(self, instant: Instant) -> Mapping[str, Scalar]:
        return self.field.validity(instant)
