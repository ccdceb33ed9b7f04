"""Elliptic two-body orbits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.orbits.angle_reduction import NearbyAngle, angle_at, mean_motion_of
from poinsot.orbits.conic import ConicBlock, ConicOrbit, Named, Radius
from poinsot.orbits.from_cartesian import OrbitPoint
from poinsot.quantities import Angle, Inclination, Real, Rule, Time
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Positive

__all__ = ["EccentricBlock", "EllipticBlock", "KeplerBlock", "KeplerOrbit", "LongEllipticBlock"]


def _refuse_unbound(name: str, eccentricity: Any, hint: str) -> None:
    """Raise a ValueError that shows the first eccentricity that is not one of an ellipse."""
    e = np.asarray(eccentricity)
    wrong = e[(e < 0) | (e >= 1)]
    if wrong.size:
        raise ValueError(f"{name} must be in [0, 1), got {wrong.flat[0]}. {hint}")


ELLIPTIC = Rule(_refuse_unbound, "A Kepler orbit is an ellipse.")
"""Rule for the eccentricity of an ellipse."""


class KeplerOrbit(ConicOrbit):
    """Elliptic two-body orbit of the body about an attractor.

    The position is accurate to machine precision at any time, because the reduction of the mean anomaly to one
    revolution uses twice the digits. A compiled kernel evaluates the closed form in its own precision. Above an
    eccentricity of 0.7 it integrates an anomaly with the attitude, and corrects it by the time.

    Parameters
    ----------
    semimajor_axis : float
        Semimajor axis a, in length.
    eccentricity : float
        Eccentricity e, in [0, 1).
    true_anomaly : float
        True anomaly at the epoch, radians.

    Raises
    ------
    ValueError
        If `mu` or the semimajor axis is not positive, the eccentricity is outside [0, 1), or the radius is negative.

    Examples
    --------
    >>> low = pt.orbits.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.01)  # km, s
    >>> round(float(low.period), 3)
    5828.517
    """

    mu: Positive
    _: KW_ONLY
    semimajor_axis: Positive
    eccentricity: Annotated[Real, ELLIPTIC]
    inclination: Inclination = 0.0
    node: Angle = 0.0
    argument_of_periapsis: Angle = 0.0
    true_anomaly: Angle = 0.0
    epoch: Time = 0.0
    radius: Radius = 0.0

    @classmethod
    @override
    def _shape_from(cls, e: Any, length: Named, anomaly: Named, mu: Any) -> dict[str, Any]:
        ELLIPTIC.check("eccentricity", e)
        (name, angle), (kind, size) = anomaly, length
        if name == "mean_anomaly":
            angle = functions.eccentric_anomaly(e, angle)
        if name != "true_anomaly":
            half = 0.5 * angle
            angle = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(half), np.sqrt(1 - e) * np.cos(half))
        a = size if kind == "semimajor_axis" else size / (1 - e)
        return {"semimajor_axis": a, "eccentricity": e, "true_anomaly": angle}

    @classmethod
    @override
    def _shape_of(cls, here: OrbitPoint) -> tuple[dict[str, Any], float]:
        if not here.energy < 0:
            raise ValueError(
                f"position and velocity must belong to an ellipse, but the orbital energy is {here.energy:.6g} >= 0."
            )
        e = min(here.eccentricity, float(np.nextafter(1.0, 0.0)))
        anomaly = float(np.arctan2(here.e_sin, here.e_cos)) if e > 0 else here.latitude
        # The distance r = a (1 - e)(1 + e)/(1 + e cos f) is reproduced.
        a = here.distance * ((1 - e) + 2 * e * np.cos(0.5 * anomaly) ** 2) / ((1 - e) * (1 + e))
        shape = {"semimajor_axis": a, "eccentricity": e, "true_anomaly": anomaly}
        return shape, anomaly

    @property
    def mean_motion(self) -> Any:
        """Mean motion sqrt(mu / a^3), radians per unit of time."""
        return functions.sqrt(self.mu / self.semimajor_axis**3)

    @property
    def period(self) -> Any:
        """Orbital period."""
        return 2 * np.pi / self.mean_motion

    @property
    def parameter(self) -> Any:
        """Semi-latus rectum p = a (1 - e^2)."""
        return self.semimajor_axis * (1 - self.eccentricity) * (1 + self.eccentricity)

    @property
    def periapsis_distance(self) -> Any:
        """Periapsis distance a (1 - e)."""
        return self.semimajor_axis * (1 - self.eccentricity)

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """Mean motion about the normal for a circular orbit (to rounding); None otherwise."""
        return np.asarray(self.mean_motion)[..., None] * self.normal if is_circle(self) else None

    @cached_property
    def elongated(self) -> bool:
        """True if the eccentricity of any member is above 0.7, where rounding errors grow near the periapsis."""
        return bool(np.any(np.asarray(self.eccentricity) > ELONGATED_ECCENTRICITY))

    def with_numbers(self, scalars: Iterable[Scalar]) -> Self:
        """Return the same orbit with other scalars and the present value of `elongated`, for use with symbols."""
        copy = super().with_numbers(scalars)
        object.__setattr__(copy, "elongated", self.elongated)
        return copy

    @property
    @override
    def integrated(self) -> bool:
        return self.elongated

    @cached_property
    def block(self) -> KeplerBlock | EccentricBlock:
        """True or eccentric anomaly, integrated with the attitude."""
        return EccentricBlock(self) if self.elongated else KeplerBlock(self)

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        return self.in_space(*self.place(self.phase_at(time)))

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        ahead, aside = self.slope(self.phase_at(time))
        return self.in_space(self.mean_motion * ahead, self.mean_motion * aside)

    @override
    def inverse_distance_at(self, time: Scalar) -> Scalar:
        return 1 / self.distance(self.phase_at(time))

    def mean_anomaly_at(self, time: Scalar) -> Scalar:
        """Return the mean anomaly, radians, including full revolutions."""
        return self._mean_anomaly(time, whole=True)

    def phase_at(self, time: Scalar) -> Scalar:
        """Return the mean anomaly, radians, to machine precision at any time; for floats modulo two revolutions."""
        return self._mean_anomaly(time)

    def _mean_anomaly(self, time: Scalar, whole: bool = False) -> Scalar:
        near = None if whole else self._nearby_anomaly.at(time)
        if near is not None:
            value: Scalar = near
            return value
        return angle_at(self.mean_anomaly_at_epoch, self._precise_mean_motion, time, self.epoch, whole)

    @cached_property
    def _precise_mean_motion(self) -> Any:
        return mean_motion_of(self.mu, self.semimajor_axis)

    @cached_property
    def _nearby_anomaly(self) -> NearbyAngle:
        return NearbyAngle(self.mean_anomaly_at_epoch, self._precise_mean_motion, self.epoch)

    @cached_property
    def mean_anomaly_at_epoch(self) -> Any:
        """Mean anomaly at the epoch, radians, which corresponds to `true_anomaly`."""
        e, half = self.eccentricity, 0.5 * self.true_anomaly
        ahead, aside = functions.sqrt(1 + e) * functions.cos(half), functions.sqrt(1 - e) * functions.sin(half)
        E = 2 * functions.atan2(aside, ahead)
        return (1 - e) * E + e * functions.sine_defect(E)

    # ------------------------------------------------------------------ the ellipse, by the mean anomaly

    @of_scalars
    def place(self, mean_anomaly: Scalar) -> tuple[Scalar, Scalar]:
        """Return the position a (cos E - e), b sin E along the axes of the ellipse."""
        a, e = self.semimajor_axis, self.eccentricity
        sine, cosine = self._half_anomaly(mean_anomaly)
        return a * (1 - e) - 2 * a * (sine * sine), 2 * a * self._ratio * (sine * cosine)

    @of_scalars
    def slope(self, mean_anomaly: Scalar) -> tuple[Scalar, Scalar]:
        """Return the derivatives of the position with respect to the mean anomaly."""
        a, e = self.semimajor_axis, self.eccentricity
        sine, cosine = self._half_anomaly(mean_anomaly)
        fast = 1 / ((1 - e) + 2 * e * (sine * sine))
        return -2 * a * (sine * cosine) * fast, a * self._ratio * (1 - 2 * (sine * sine)) * fast

    @of_scalars
    def distance(self, mean_anomaly: Scalar) -> Scalar:
        """Return a (1 - e cos E)."""
        a, e = self.semimajor_axis, self.eccentricity
        sine, _ = self._half_anomaly(mean_anomaly)
        return a * ((1 - e) + 2 * e * (sine * sine))

    def _half_anomaly(self, mean_anomaly: Scalar) -> tuple[Scalar, Scalar]:
        """Return sin E/2 and cos E/2, from which 1 - cos E is accurate to its last digit near the periapsis."""
        E = functions.eccentric_anomaly(self.eccentricity, mean_anomaly)
        return functions.sin(0.5 * E), functions.cos(0.5 * E)

    @property
    def _ratio(self) -> Scalar:
        return functions.sqrt((1 - self.eccentricity) * (1 + self.eccentricity))


class EllipticBlock(ConicBlock):
    """Block of an ellipse. The variable is f - M, the true minus the mean anomaly.

    The true anomaly f would grow with every revolution and loosen the step control, which uses the largest variable.
    """

    @override
    def start_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        return centre_equation(self.orbit.eccentricity, self.orbit.phase_at(time))

    @override
    def rates_at(self, time: Scalar, own: Any) -> functions.Vector:
        return functions.Vector((self.anomaly_rate(time, own) - self.orbit.mean_motion,))

    @override
    def true_anomaly(self, time: Scalar, own: Any) -> Scalar:
        value: Scalar = own[0] + self.orbit.phase_at(time)
        return value


class KeplerBlock(EllipticBlock):
    """Block of an ellipse that is fixed in space."""

    orbit: KeplerOrbit


class LongEllipticBlock(ConicBlock):
    """Block of an elongated ellipse. The variable is E - M, the eccentric minus the mean anomaly.

    Every quantity, including the rate of the variable, is computed after one step of Newton's method for Kepler's
    equation. The step squares the error of the variable, which therefore does not grow from apoapsis to periapsis.
    """

    @override
    def start_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        e = self.orbit.eccentricity
        E = functions.eccentric_anomaly(e, self.orbit.phase_at(time))
        return np.asarray(e * functions.sin(E))[..., None]

    @override
    def rates_at(self, time: Scalar, own: Any) -> functions.Vector:
        _, _, distance = self._place(time, own)
        return functions.Vector((self.orbit.mean_motion * (1 / distance - 1),))

    @override
    def true_anomaly(self, time: Scalar, own: Any) -> Scalar:
        e, (sine, cosine, _) = self.orbit.eccentricity, self._place(time, own)
        ratio = functions.sqrt((1 - e) * (1 + e))
        beyond = functions.atan2(2 * e * sine * cosine, 1 + ratio - e + 2 * e * sine * sine)  # half of f - E
        return self._anomaly(time, own) + 2 * beyond

    @override
    def cosines(self, time: Scalar, own: Any) -> tuple[Scalar, Scalar]:
        e, (sine, cosine, distance) = self.orbit.eccentricity, self._place(time, own)
        inverse = 1 / distance
        ratio = functions.sqrt((1 - e) * (1 + e))
        return ((1 - e) - 2 * (sine * sine)) * inverse, 2 * ratio * (sine * cosine) * inverse

    @override
    def closeness(self, time: Scalar, own: Any) -> Scalar:
        e = self.orbit.eccentricity
        value: Scalar = (1 - e) * (1 + e) / self._place(time, own)[2]
        return value

    def _anomaly(self, time: Scalar, own: Any) -> Scalar:
        value: Scalar = own[0] + self.orbit.phase_at(time)
        return value

    def _place(self, time: Scalar, own: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Return sin E/2 and cos E/2, and the distance over the semimajor axis, at the time."""
        e, E = self.orbit.eccentricity, self._anomaly(time, own)
        sine, cosine = functions.sin(0.5 * E), functions.cos(0.5 * E)
        late = (1 - e) * E + e * functions.sine_defect(E) - self.orbit.phase_at(time)
        half = 0.5 * late / ((1 - e) + 2 * e * (sine * sine))
        sine, cosine = sine - half * cosine, cosine + half * sine
        return sine, cosine, (1 - e) + 2 * e * (sine * sine)


class EccentricBlock(LongEllipticBlock):
    """Block of an elongated ellipse that is fixed in space."""

    orbit: KeplerOrbit


ELONGATED_ECCENTRICITY = 0.7
"""Eccentricity above which the solution of Kepler's equation in a kernel loses digits near the periapsis."""


def centre_equation(eccentricity: Any, mean_anomaly: Any) -> NDArray[np.float64]:
    """Return the equation of the centre, the true minus the mean anomaly in radians, with a last axis of length 1."""
    E: Any = functions.eccentric_anomaly(eccentricity, mean_anomaly)
    e = eccentricity
    beta = e / (1 + np.sqrt((1 - e) * (1 + e)))
    return np.asarray(E - mean_anomaly + 2 * np.arctan2(beta * np.sin(E), 1 - beta * np.cos(E)))[..., None]


def is_circle(orbit: KeplerOrbit) -> bool:
    """Return True if the eccentricity of every member is zero to rounding."""
    return bool(np.all(np.asarray(orbit.eccentricity) < 1e-14))
