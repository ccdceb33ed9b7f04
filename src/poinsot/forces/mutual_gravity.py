"""The gravity between two bodies."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from poinsot.functions import Scalar
from poinsot.mechanics.force import Potential
from poinsot.mechanics.two_bodies import TwoBodies

__all__ = ["MutualGravity"]


class MutualGravity(Potential):
    """The gravity of two bodies to second degree, complete: it moves the orbit and turns both.

    V = -G m1 m2 / r - G / (2 r^3) (m1 (tr I2 - 3 u.I2 u) + m2 (tr I1 - 3 u.I1 u)), u the direction between the centres.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> system = pt.System(pt.TwoBodies(ball, ball, G=1.0), pt.forces.MutualGravity())
    >>> [integral.symbol for integral in system.integrals]
    ['H', 'G1', 'G2', 'G3']
    """

    @override
    def check(self, body: Any) -> None:
        if not isinstance(body, TwoBodies):
            raise ValueError(f"MutualGravity must act between TwoBodies, got {body!r}.")

    @override
    def energy(self, instant: Any) -> Scalar:
        pair, inverse = instant.pair, 1 / instant.distance
        masses = pair.each_mass
        direction = inverse * instant.separation
        bodies = (instant.primary, instant.secondary)
        spread = [
            sum(each.body.moments) - 3 * each.body.moment_about(each.attitude.to_body(direction)) for each in bodies
        ]
        second = masses[1] * spread[0] + masses[0] * spread[1]
        return -pair.G * inverse * (masses[0] * masses[1] + 0.5 * inverse * inverse * second)
