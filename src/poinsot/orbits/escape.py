"""Unbound two-body orbits: parabola and hyperbola."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar
from poinsot.immutable import cached_property
from poinsot.orbits.angle_reduction import elapsed
from poinsot.orbits.conic import ConicBlock, ConicOrbit, Named, Radius
from poinsot.orbits.from_cartesian import OrbitPoint
from poinsot.orbits.universal import refuse_symbols, universal_place, universal_time
from poinsot.quantities import Angle, Duration, Inclination, Real, Rule, Time
from poinsot.records.members import of_scalars
from poinsot.records.parameters import Positive

__all__ = ["EscapeBlock", "EscapeOrbit"]


def _refuse_bound(name: str, eccentricity: Any, hint: str) -> None:
    """Raise a ValueError that shows the first eccentricity that is one of an ellipse."""
    e = np.asarray(eccentricity)
    if np.any(e < 1):
        raise ValueError(f"{name} must be at least 1, got {e[e < 1].flat[0]}. {hint}")


ESCAPING = Rule(_refuse_bound, "An ellipse is a KeplerOrbit.")
"""Rule for the eccentricity of a parabola or hyperbola."""


class EscapeOrbit(ConicOrbit):
    """Hyperbolic or parabolic two-body orbit, continuous in the eccentricity at e = 1.

    Universal variables give the position to machine precision at any time. A compiled kernel integrates one universal
    variable with the attitude, and corrects it by the time.

    Parameters
    ----------
    periapsis_distance : float
        Periapsis distance q, in length.
    eccentricity : float
        Eccentricity, at least 1.
    time_since_periapsis : float
        Time since periapsis at the epoch; negative before the passage.

    Raises
    ------
    ValueError
        If `mu` or the distance is not positive, the eccentricity is below 1, or the radius is negative.

    Examples
    --------
    >>> flyby = pt.orbits.EscapeOrbit(398600.4418, periapsis_distance=7000.0, eccentricity=1.2)  # km, s
    >>> round(float(flyby.excess_speed), 3)
    3.375
    """

    mu: Positive
    _: KW_ONLY
    periapsis_distance: Positive
    eccentricity: Annotated[Real, ESCAPING]
    inclination: Inclination = 0.0
    node: Angle = 0.0
    argument_of_periapsis: Angle = 0.0
    time_since_periapsis: Duration = 0.0
    epoch: Time = 0.0
    radius: Radius = 0.0

    @classmethod
    @override
    def _shape_from(cls, e: Any, length: Named, anomaly: Named, mu: Any) -> dict[str, Any]:
        ESCAPING.check("eccentricity", e)
        q = _periapsis_distance(e, *length)
        since = _scaled_time(e, *anomaly) * np.sqrt(q**3 / mu)
        return {"periapsis_distance": q, "eccentricity": e, "time_since_periapsis": since}

    @classmethod
    @override
    def _shape_of(cls, here: OrbitPoint) -> tuple[dict[str, Any], float]:
        if here.energy < 0:
            raise ValueError(
                "position and velocity must belong to a parabola or hyperbola, but the orbital energy is "
                f"{here.energy:.6g} < 0. An ellipse is a KeplerOrbit."
            )
        e = max(here.eccentricity, 1.0)
        S1 = here.climb / (e * np.sqrt(here.mu * here.parameter / (1 + e)))
        S2 = S1 * S1 / (1 + np.sqrt(1 + (e - 1) * S1 * S1))
        q = here.distance / (1 + e * S2)
        since = universal_time(e, _anomaly_of(e, S1)) * np.sqrt(q**3 / here.mu)
        anomaly = float(np.arctan2(np.sqrt(1 + e) * S1, 1 - S2))
        shape = {"periapsis_distance": q, "eccentricity": e, "time_since_periapsis": since}
        return shape, anomaly

    @property
    def parameter(self) -> Any:
        """Semi-latus rectum p = q (1 + e)."""
        return self.periapsis_distance * (1 + self.eccentricity)

    @property
    def semimajor_axis(self) -> Any:
        """Semimajor axis q/(1 - e), negative; -inf for a parabola."""
        with np.errstate(divide="ignore"):
            return -np.divide(self.periapsis_distance, self.eccentricity - 1)

    @property
    def period(self) -> Any:
        """Orbital period, infinite for an escape orbit."""
        return np.full(np.shape(self.eccentricity), np.inf)[()]

    @property
    def excess_speed(self) -> Any:
        """Hyperbolic excess speed, sqrt(mu (e - 1)/q)."""
        return functions.sqrt(self.mu * (self.eccentricity - 1) / self.periapsis_distance)

    @property
    def largest_anomaly(self) -> Any:
        """True anomaly of the asymptote, acos(-1/e), radians."""
        return _largest_anomaly(self.eccentricity)

    @property
    def periapsis_time(self) -> Any:
        """Time of the periapsis passage."""
        return self.epoch - self.time_since_periapsis

    @property
    @override
    def sample_time(self) -> Any:
        return self.periapsis_time

    @property
    @override
    def closed_form(self) -> bool:
        return False

    @cached_property
    def block(self) -> EscapeBlock:
        """Universal variable, integrated with the attitude."""
        return EscapeBlock(self)

    @override
    def position_at(self, time: Scalar) -> functions.Vector:
        S1, S2 = self.place(time)
        q = self.periapsis_distance
        return self.in_space(q * (1 - S2), q * functions.sqrt(1 + self.eccentricity) * S1)

    @override
    def velocity_at(self, time: Scalar) -> functions.Vector:
        S1, S2 = self.place(time)
        e = self.eccentricity
        speed = functions.sqrt(self.mu / self.periapsis_distance) / (1 + e * S2)
        return self.in_space(-speed * S1, speed * functions.sqrt(1 + e) * (1 + (e - 1) * S2))

    @override
    def inverse_distance_at(self, time: Scalar) -> Scalar:
        return 1 / (self.periapsis_distance * (1 + self.eccentricity * self.place(time)[1]))

    def true_anomaly_at(self, time: Scalar) -> Scalar:
        """Return the true anomaly, radians, between the anomalies of the two asymptotes."""
        return self.anomaly(*self.place(time))

    @of_scalars
    def anomaly(self, S1: Scalar, S2: Scalar) -> Scalar:
        """Return the true anomaly, radians."""
        return functions.atan2(functions.sqrt(1 + self.eccentricity) * S1, 1 - S2)

    @of_scalars
    def place(self, time: Scalar) -> tuple[Scalar, Scalar]:
        """Return S_1 and S_2."""
        refuse_symbols(type(self).__name__, time, *(vars(self)[name] for name in ("mu", "eccentricity")))
        return universal_place(self.eccentricity, self.scaled(time))

    @of_scalars
    def scaled(self, time: Scalar) -> Scalar:
        """Return the time since the periapsis in units of sqrt(q^3 / mu)."""
        return elapsed(self.time_since_periapsis, time, self.epoch) * self.rate

    @property
    def rate(self) -> Scalar:
        """sqrt(mu / q^3)."""
        return functions.sqrt(self.mu / self.periapsis_distance**3)


class EscapeBlock(ConicBlock):
    """Block of a parabola or hyperbola. The variable is asinh(S_1)/32.

    It stays below one, the size of a quaternion, because the step control uses the largest variable. Its error is a
    relative error of the distance. Every quantity, including the rate of the variable, is computed after one step of
    Newton's method for the time of `universal_time`. The step squares the error of the variable, which therefore does
    not grow towards the periapsis.
    """

    orbit: EscapeOrbit

    @override
    def start_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.arcsinh(np.asarray(self.orbit.place(time)[0])) / ANOMALY_SCALE)[..., None]

    @override
    def rates_at(self, time: Scalar, own: Any) -> functions.Vector:
        S1, S2 = self._place(time, own)
        e, slope = self.orbit.eccentricity, functions.sqrt(1 + S1 * S1)
        return functions.Vector((self.orbit.rate / ANOMALY_SCALE * (1 + (e - 1) * S2) / ((1 + e * S2) * slope),))

    @override
    def true_anomaly(self, time: Scalar, own: Any) -> Scalar:
        return self.orbit.anomaly(*self._place(time, own))

    @override
    def cosines(self, time: Scalar, own: Any) -> tuple[Scalar, Scalar]:
        S1, S2 = self._place(time, own)
        e = self.orbit.eccentricity
        inverse = 1 / (1 + e * S2)
        return (1 - S2) * inverse, functions.sqrt(1 + e) * S1 * inverse

    @override
    def closeness(self, time: Scalar, own: Any) -> Scalar:
        e = self.orbit.eccentricity
        return (1 + e) / (1 + e * self._place(time, own)[1])

    def _place(self, time: Scalar, own: Any) -> tuple[Scalar, Scalar]:
        """Return S_1 and S_2 at the time."""
        e, grown = self.orbit.eccentricity, functions.exp(ANOMALY_SCALE * own[0])
        S1 = 0.5 * (grown - 1 / grown)
        square = S1 * S1
        cosh = functions.sqrt(1 + (e - 1) * square)
        S2, rate = square / (1 + cosh), functions.sqrt(e - 1 + MIN_EXCESS)
        # x + e S_3 = S_1 + S_3, for S_1 = x + (e - 1) S_3.
        late = S1 + functions.asinh_defect(rate * S1) / (rate * rate * rate) - self.orbit.scaled(time)
        change = late / (1 + e * S2)
        return S1 - cosh * change, S2 - S1 * change


ANOMALY_SCALE = 32.0
"""Scale of asinh(S_1). Distances of e^32 periapsis distances are beyond any orbit."""

MIN_EXCESS = 1e-120
"""Number added to e - 1, so that no kernel divides by zero at a parabola."""


def _periapsis_distance(e: Any, name: str, length: Any) -> Any:
    if name == "periapsis_distance":
        return length
    _refuse_parabola(e, "semimajor_axis", "Give the periapsis_distance.")
    if np.any(length >= 0):
        raise ValueError(
            f"semimajor_axis must be negative with an eccentricity above 1, got {length[length >= 0].flat[0]}. "
            "A hyperbola has a = q/(1 - e)."
        )
    return length * (1 - e)


def _scaled_time(e: Any, name: str, anomaly: Any) -> Any:
    """Return the time since the periapsis times sqrt(mu / q^3)."""
    if name == "true_anomaly":
        largest = np.broadcast_to(_largest_anomaly(e), np.broadcast_shapes(e.shape, anomaly.shape))
        if np.any(np.abs(anomaly) >= largest):
            i = np.argmax(np.abs(anomaly) >= largest)
            raise ValueError(
                f"true_anomaly must be within the asymptotes, |f| < {largest.flat[i]:.6g}, got "
                f"{np.broadcast_to(anomaly, largest.shape).flat[i]}."
            )
        w = np.tan(0.5 * anomaly) / np.sqrt(1 + e)  # tanh(H/2)/sqrt(e - 1)
        return universal_time(e, _anomaly_of(e, 2 * w / (1 - (e - 1) * w * w)))
    _refuse_parabola(e, name, "Give the true_anomaly.")
    if name == "mean_anomaly":
        return anomaly / (e - 1) ** 1.5
    return universal_time(e, anomaly / np.sqrt(e - 1))


def _refuse_parabola(e: Any, name: str, hint: str) -> None:
    if np.any(e == 1):
        raise ValueError(f"{name} must belong to a hyperbola, but the eccentricity is 1. {hint}")


def _largest_anomaly(e: Any) -> Any:
    """Return acos(-1/e), which is 2 atan(sqrt((e + 1)/(e - 1)))."""
    return 2 * functions.atan2(functions.sqrt(e + 1), functions.sqrt(e - 1))


def _anomaly_of(e: Any, S1: Any) -> Any:
    """Return x of x c_1 = S1, which is sinh(sqrt(e - 1) x)/sqrt(e - 1)."""
    rate = np.sqrt(e - 1)
    small = rate * np.abs(S1) < 1e-8
    return np.where(small, S1, np.arcsinh(rate * S1) / np.where(small, 1.0, rate))[()]
