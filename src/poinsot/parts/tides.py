"""Deformable bodies whose figure relaxes towards equilibrium by creep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import Matrix, outer
from poinsot.mechanics.part import Part
from poinsot.mechanics.two_bodies import GRAVITATIONAL_CONSTANT
from poinsot.records.members import Components, of_arrays
from poinsot.records.parameters import Positive

__all__ = ["CreepingTide"]


class CreepingTide(Part):
    """Tidal and centrifugal deformation of a Maxwell body to second degree, which relaxes towards equilibrium.

    D' = (D_e - D) / relaxation_time along the body axes, with D the trace-free change of the inertia tensor. The
    equilibrium D_e is the trace-free part of k R^5 / (3 G) [omega omega^T - 3 mu / r^3 n n^T], due to rotation and an
    attractor in the direction n (Correia, Boue, Laskar and Rodriguez 2014, Astron. Astrophys. 571, A50). The
    gravitational forces of the system, such as `GravityGradient`, act on D; their torque on D is the tidal torque. At
    the frequency w, k2 = k / (1 + i w relaxation_time).

    Parameters
    ----------
    love_number : float
        k, the fluid Love number of second degree minus the elastic Love number. The elastic bulge follows at once and
        exerts no torque.
    radius : float
        Radius R of the body, in the unit of length of the orbit.
    relaxation_time : float
        Relaxation time: viscosity over rigidity, including self-gravity. It limits the integration step. If it is much
        shorter than a rotation period, use `TidalTorque` with love_number k and time_lag relaxation_time.
    G : float
        Gravitational constant in the units of moments and orbit. Default: the SI value.

    Examples
    --------
    >>> tide = pt.parts.CreepingTide(love_number=0.9, radius=1.0, relaxation_time=3.0, G=1.0)
    >>> system = pt.System(pt.Body((0.38, 0.4, 0.42)), tide)
    >>> motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.2, 0, 0.1)), [0.0, 500.0])
    >>> bool(motion.energy[1] < motion.energy[0])  # and the angular momentum stays
    True
    """

    love_number: Positive
    radius: Positive
    relaxation_time: Positive
    G: Positive = GRAVITATIONAL_CONSTANT
    variables: ClassVar[Mapping[str, int]] = {"inertia": 5}
    """D11, D22, D12, D13, D23."""

    @property
    def _compliance(self) -> Scalar:
        """D over the trace-free tensor of forces: the internal energy is D:D / (2 compliance)."""
        return self.love_number * self.radius**5 * (2 / 3) / self.G

    @override
    def start(self, time: Scalar, omega_body: functions.Vector) -> functions.Vector:
        return functions.Vector(_trace_free(outer(omega_body, omega_body)) * (self._compliance / 2))

    @override
    def inertia(self, own: functions.Vector, time: Scalar) -> Matrix:
        a, b, c, d, e = own
        rows = ((a, c, d), (c, b, e), (d, e, -a - b))
        return functions.Vector(map(functions.Vector, rows))

    @override
    def internal_energy(self, own: functions.Vector, time: Scalar) -> Scalar:
        a, b, c, d, e = own
        value: Scalar = (a * a + a * b + b * b + c * c + d * d + e * e) / self._compliance
        return value

    @override
    def rates(self, instant: Instant, generalised_force: functions.Vector) -> functions.Vector:
        # The generalised force is per variable. As a trace-free tensor P it satisfies P : dD = force . d own.
        a, b, c, d, e = generalised_force
        gravity = functions.Vector(((2 * a - b) / 3, (2 * b - a) / 3, c / 2, d / 2, e / 2))
        centrifugal = _trace_free(outer(instant.omega_body, instant.omega_body)) * 0.5
        force = (gravity + centrifugal) * self._compliance
        return functions.Vector((force - instant.own(self)) * (1 / self.relaxation_time))

    @of_arrays(omega_body=(3,), position_body=(3,), mu=())
    def at_equilibrium(self, omega_body: Components, position_body: Components, mu: Scalar) -> Any:
        """Return the variables, shape (..., 5), of the equilibrium figure for a rotation and one attractor.

        Parameters
        ----------
        omega_body : array (..., 3), body axes
            Inertial angular velocity, in angle per time.
        position_body : array (..., 3), body axes
            Position of the attractor relative to the body, of either sign.
        mu : float or array (...)
            Gravitational parameter of the attractor, in length^3 / time^2.

        Returns
        -------
        array (..., 5)
            Variables of the part.
        """
        gradient = 3 * mu / functions.norm(position_body) ** 5
        tensor = outer(omega_body, omega_body) - outer(position_body * gradient, position_body)
        return _trace_free(tensor) * (self._compliance / 2)


TENSOR_INDICES = ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))
"""Row and column of each variable in the tensor."""


def _trace_free(tensor: Matrix) -> functions.Vector:
    """Return five components of the trace-free part of a symmetric tensor."""
    third = (tensor[0][0] + tensor[1][1] + tensor[2][2]) / 3
    return functions.Vector(tensor[i][j] - third if i == j else tensor[i][j] for i, j in TENSOR_INDICES)
