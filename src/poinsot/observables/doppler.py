"""Doppler spectra of radar echoes: the bandwidth, and the frequencies of both edges."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import ClassVar

from typing_extensions import override

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.environment import Orbit
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.observable import Observable
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative, Positive
from poinsot.records.units import DerivedUnits
from poinsot.shapes.shape import Shape

__all__ = ["DopplerBandwidth", "DopplerEdges"]


class DopplerSpectrum(Observable):
    """Spectrum of a radar echo that the rotation broadens: shifts 2 v / lambda of points approaching at v.

    v = (omega x x) . e = x . (e x omega) for a point x of the body from its centre of mass, with the unit vector e
    towards the observer. The model ignores shadows, scattering and the motion of the centre of mass.

    Parameters
    ----------
    shape : Shape
        Shape along the body axes.
    observer : Orbit
        Orbit of the body relative to the radar.
    wavelength : float
        Wavelength lambda, in the unit of length of the shape; positive.
    light_time : bool
        False if the times of the readings are already times at the body.
    noise : float
        Standard deviation of each number of a reading.
    """

    shape: Shape
    observer: Orbit
    wavelength: Positive
    _: KW_ONLY
    light_time: bool = True
    noise: NotNegative = 0.0

    @of_scalars
    def shifts(self, instant: Instant) -> tuple[Scalar, Scalar]:
        """Return the largest and the smallest shift of the points of the body."""
        towards = Vector(instant.attitude.to_body(-instant.direction(self.observer)))
        speed = functions.cross(towards, instant.omega_body)
        factor = 2 / self.wavelength
        return factor * self.shape.support(speed), -factor * self.shape.support(-speed)

    @override
    def unit(self, units: DerivedUnits) -> str:
        return units.per_time

    @property
    @override
    def light_path(self) -> Orbit | None:
        return self.observer if self.light_time else None


class DopplerBandwidth(DopplerSpectrum):
    """Bandwidth of a radar echo: 2 / lambda times the extent of x . (e x omega) over the shape.

    For an ellipsoid with the semiaxes D it is 4 |D (e x omega)| / lambda; for a sphere of diameter d that rotates with
    the period P at the angle delta from the equator, 4 pi d cos(delta) / (lambda P).

    Examples
    --------
    >>> radar = pt.orbits.FixedPosition(1.0, position=(1e6, 0, 0))
    >>> ball = pt.shapes.Ellipsoid((100, 100, 100), mass=1.0)  # m, s
    >>> body = pt.Body((1.0, 1.0, 1.0))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3)), [0.0])
    >>> pt.observe(motion, pt.observables.DopplerBandwidth(ball, radar, 0.035, light_time=False)).values.round(3)  # Hz
    array([11.429])
    """

    @override
    def reading(self, instant: Instant) -> Scalar:
        upper, lower = self.shifts(instant)
        return upper - lower


class DopplerEdges(DopplerSpectrum):
    """Shifts of both edges of a radar echo from the centre of mass; positive towards the observer.

    Examples
    --------
    >>> radar = pt.orbits.FixedPosition(1.0, position=(1e6, 0, 0))
    >>> box = pt.shapes.Mesh.from_box((200, 100, 100), mass=1.0)  # m, s
    >>> body = pt.Body((1.0, 1.0, 1.0))
    >>> motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3)), [0.0])
    >>> pt.observe(motion, pt.observables.DopplerEdges(box, radar, 0.035, light_time=False)).values.round(3)  # Hz
    array([[-2.857,  2.857]])
    """

    components: ClassVar[tuple[str, ...]] = ("lower", "upper")

    @override
    def reading(self, instant: Instant) -> Vector:
        upper, lower = self.shifts(instant)
        return Vector((lower, upper))
