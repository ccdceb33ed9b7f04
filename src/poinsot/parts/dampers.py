"""Dampers that dissipate the energy of nutation inside the body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix
from poinsot.mechanics.part import Part
from poinsot.records.members import Components, of_arrays
from poinsot.records.parameters import NotNegative, Positive

__all__ = ["KaneDamper"]


class KaneDamper(Part):
    """Kane damper: a homogeneous sphere in a spherical cavity filled with viscous fluid.

    p' = p x omega - coefficient (p / moment - omega), with p the inertial angular momentum of the sphere along the body
    axes. The model ignores the inertia of the fluid. The part models any internal energy dissipation (Kane, Likins and
    Levinson 1983, Spacecraft Dynamics).

    Parameters
    ----------
    moment : float
        Moment of inertia of the sphere about a diameter, positive. The body's inertia tensor includes the sphere,
        locked.
    coefficient : float
        Torque per angular velocity of the sphere relative to the body, not negative.

    Raises
    ------
    ValueError
        If the moment is not positive or the coefficient is negative.

    Examples
    --------
    >>> system = pt.System(pt.Body((1.0, 1.6, 2.5)), pt.parts.KaneDamper(0.1, 0.05))
    >>> start = system.state((1, 0, 0, 0), omega_body=(1, 0.1, 0))  # about the axis of the smallest moment
    >>> motion = pt.propagate(system, start, [0.0, 50.0])
    >>> bool(motion.energy[1] < motion.energy[0])
    True
    """

    formula = "rate(h) = cross(h, omega) - coefficient*(h/moment - omega)"
    moment: Positive
    coefficient: NotNegative
    variables: ClassVar[Mapping[str, int]] = {"momentum": 3}
    momenta: ClassVar[frozenset[str]] = frozenset({"momentum"})

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        return functions.Vector(self.moment * component for component in omega_body)

    @override
    def momentum(self, own: functions.Vector, time: Scalar) -> functions.Vector:
        return own

    @override
    def spinning_inertia(self, own: functions.Vector) -> Matrix:
        return functions.Vector(functions.Vector(self.moment if i == j else 0.0 for j in range(3)) for i in range(3))

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        return functions.dot(own, own) / (2 * self.moment)

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        p, omega = instant.own(self), instant.omega_body
        slip = p * (1 / self.moment) - omega
        return functions.Vector(functions.cross(p, omega) - slip * self.coefficient)

    @of_arrays(relative_rate=(3,), omega_body=(3,))
    def at_rate(self, relative_rate: Components, omega_body: Components) -> Any:
        """Return the variables, shape (..., 3), for an angular velocity of the sphere relative to the body."""
        return (relative_rate + omega_body) * self.moment

    @of_arrays(own=(3,), omega_body=(3,))
    def relative_rate(self, own: Components, omega_body: Components) -> Any:
        """Return the angular velocity of the sphere relative to the body, shape (..., 3), along the body axes."""
        return own / self.moment - omega_body
