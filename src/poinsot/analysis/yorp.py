"""YORP torques averaged over rotation and orbit, which change the spin axis and the rate of an asteroid."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_array, real_numbers, refuse_negative, refuse_nonpositive, refuse_zero
from poinsot.forces.directional_torque import DirectionalTorque
from poinsot.quantities import Angles, Array
from poinsot.shapes.daily_shadows import DailyShadows
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.surface import Surface

__all__ = ["YorpCoefficients", "yorp_coefficients"]

MAX_PAIRS = 4_000_000
"""Largest number of pairs of a face and a longitude of the Sun in one block."""

SHADOW_TOLERANCE = 1e-6
"""Largest error of shadows that is accepted, as a fraction of the sum of the torques of all faces."""

FEWEST_LATITUDES, MAX_LATITUDES = 32, 4096
"""Numbers of latitudes of the Sun in a mean over the orbit; divisible by 4, for four sums of every fourth."""

MIN_OBLIQUITY = 1e-12
"""Obliquity whose mean replaces the mean at 0, where edges can lie in the orbital plane."""

STEPS = 0.15 * np.arange(-22, 23)
"""Steps of the double exponential rule of Takahasi and Mori: the last weights are 1e-12 of the largest."""
NODES = 0.5 * (1 + np.tanh(0.5 * np.pi * np.sinh(STEPS)))
WEIGHTS = 0.15 * 0.25 * np.pi * np.cosh(STEPS) / np.cosh(0.5 * np.pi * np.sinh(STEPS)) ** 2


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class YorpCoefficients(Summarized):
    """Mean YORP torques at unit pressure over rotation about one axis and a circular orbit, as functions of obliquity.

    With the radiation pressure P at the semimajor axis, the moment of inertia C and the angular velocity w, dw/dt = P
    spin / C and d(obliquity)/dt = P tilt / (C w). On an eccentric orbit both are larger by 1 / sqrt(1 - e^2), because
    light and time are distributed evenly over the true anomaly.

    Attributes
    ----------
    obliquities : array (n,)
        Angles between the spin axis and the normal of the orbit, radians.
    spin : array (n,)
        Coefficients along the spin axis, cubes of lengths.
    tilt : array (n,)
        Coefficients normal to the spin axis, away from the normal of the orbit, cubes of lengths.
    late : array (n,)
        Values of `tilt` if all faces emitted the light a quarter of a turn later.
    error : array (n,)
        Estimated largest error of `spin` and of `tilt` + i `late`, cubes of lengths; not a strict bound. Zero without
        shadows.

    Examples
    --------
    >>> box = pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0)
    >>> wedge = pt.shapes.Mesh(box.vertices + 0.2 * box.vertices[:, [1, 2, 0]] ** 3, box.faces, mass=1.0)
    >>> pt.analysis.yorp_coefficients(wedge, np.radians([0, 60, 90])).spin.round(4)
    array([ 0.0461, -0.0006, -0.0308])
    """

    obliquities: Array
    spin: Array
    tilt: Array
    late: Array
    error: Array

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return "YorpCoefficients", {
            "obliquities": formatted(self.obliquities, "rad"),
            "spin": formatted(self.spin),
            "tilt": formatted(self.tilt),
            "error": formatted(self.error),
        }

    @checked
    def with_lag(self, thermal_parameter: float, albedo: float = 0.0) -> YorpCoefficients:
        """Return the coefficients with thermal inertia in linear theory, which changes the tilt but not the spin.

        The first harmonic of the absorbed light in the rotation phase is radiated times 1 / (1 + (1 + i) Theta / 2),
        and no other harmonic contributes to a mean (Capek and Vokrouhlicky 2004, Icarus 172, 526; Vokrouhlicky 1998,
        A&A 335, 1093). The theory assumes that heat penetrates less deep than the size of a face.

        Parameters
        ----------
        thermal_parameter : float
            Thermal parameter Theta = Gamma sqrt(w) / (emissivity sigma T^3), not negative, with the subsolar
            temperature T.
        albedo : float
            Fraction of the light that is reflected, without delay; from 0 to 1.
        """
        parameter = float(real_array("thermal_parameter", thermal_parameter, ()))
        share = float(real_array("albedo", albedo, ()))
        refuse_negative("thermal_parameter", parameter)
        if not 0 <= share <= 1:
            raise ValueError(f"albedo must be from 0 to 1, got {share:g}.")
        factor = share + (1 - share) / (1 + (1 + 1j) * parameter / 2)
        lagged = factor * (self.tilt + 1j * self.late)
        return dataclasses.replace(self, tilt=lagged.real, late=lagged.imag)

    @checked
    def drift(self, pressure: float, moment_of_inertia: float) -> Callable[[Mapping[str, float]], dict[str, float]]:
        """Return the rates of change of "rate" and "obliquity", for `pt.analysis.secular_evolution`.

        Cubic splines interpolate the coefficients between the obliquities, which must reach from 0 to pi.

        Parameters
        ----------
        pressure : float
            Radiation pressure of sunlight at the semimajor axis, times 1 / sqrt(1 - e^2) on an eccentric orbit.
        moment_of_inertia : float
            Moment of inertia about the spin axis.
        """
        from scipy.interpolate import CubicSpline

        size, moment = real_array("pressure", pressure, ()), real_array("moment_of_inertia", moment_of_inertia, ())
        refuse_nonpositive("moment_of_inertia", moment)
        at = self.obliquities
        if len(at) < 4 or np.any(np.diff(at) <= 0) or at[0] > 1e-9 or at[-1] < np.pi - 1e-9:
            raise ValueError("obliquities must ascend from 0 to pi, four at least. np.linspace(0, np.pi, 37) does.")
        spin = CubicSpline(at, self.spin, bc_type="clamped")  # even about both ends
        tilt = CubicSpline(at, self.tilt, bc_type="natural")  # odd
        scale = float(size / moment)

        def rates(state: Mapping[str, float]) -> dict[str, float]:
            folded = abs((state["obliquity"] + np.pi) % (2 * np.pi) - np.pi)
            side = np.sign(np.sin(state["obliquity"]))
            return {
                "rate": scale * float(spin(folded)),
                "obliquity": scale * side * float(tilt(folded)) / state["rate"],
            }

        return rates


@checked
def yorp_coefficients(
    surface: Mesh | DirectionalTorque, obliquities: Angles, *, axis: Any = (0, 0, 1), shadows: bool = True
) -> YorpCoefficients:
    """Return the mean YORP torques of a surface over rotation and orbit, without thermal inertia.

    `YorpCoefficients.with_lag` adds thermal inertia. The mean over the rotation is a closed form between the phases at
    which shadows begin and end on faces. Without shadows the mean over the orbit is accurate to rounding. With shadows
    the function sums over latitudes of the Sun and doubles their number, up to 4096, until the estimated error is below
    1e-6 of the sum of the torques of all faces.

    Parameters
    ----------
    surface : Mesh or DirectionalTorque
        Shape of the body, or its smoothed torque, for means that agree with a propagation under this torque.
    obliquities : array (n,)
        Obliquities from 0 to pi, radians.
    axis : array (3,), axes of the shape
        Spin axis of any nonzero length; default: the third axis.
    shadows : bool
        True if faces of a mesh are dark when other faces shade their centroids. The argument does not affect a
        `DirectionalTorque`.

    Returns
    -------
    YorpCoefficients
        Coefficients at the obliquities.

    Raises
    ------
    ValueError
        If an obliquity is outside 0 to pi or the axis is zero.

    Examples
    --------
    >>> box = pt.shapes.Mesh.from_box((2, 1.4, 1), mass=1.0)
    >>> bent = pt.shapes.Mesh(box.vertices + 0.3 * box.vertices[:, [1, 2, 0]] ** 3, box.faces, mass=1.0)
    >>> found = pt.analysis.yorp_coefficients(bent, np.radians([30, 150]), shadows=False)
    >>> bool(abs(found.spin[0] - found.spin[1]) < 1e-15)  # even about a right angle
    True
    """
    angles = np.atleast_1d(real_numbers("obliquities", obliquities))
    if angles.ndim > 1 or np.any((angles < 0) | (angles > np.pi)):
        raise ValueError(f"obliquities must be a list of angles from 0 to pi, got {formatted(angles)}.")
    pole = real_array("axis", axis, (3,))
    refuse_zero("axis", pole)
    turned = _axes_about(pole / np.linalg.norm(pole))
    if isinstance(surface, DirectionalTorque):
        spin, tilt = _means_of(lambda u: np.stack(surface.torque(u.T), axis=-1), surface.degree + 1, turned, angles)
        return YorpCoefficients(angles, spin, tilt.real, -tilt.imag, np.zeros_like(spin))
    light = Surface(surface)
    turns = -2 / 3 * light.areas[:, None] * (np.cross(light.centers, light.normals) @ turned.T)
    spin, tilt = _means_of_convex(light, turns, turned, angles)
    error = np.zeros_like(spin)
    if shadows:
        lost_spin, lost_tilt, error = _lost_to_shadows(light, turns, turned, angles)
        spin, tilt = spin - lost_spin, tilt - lost_tilt
    return YorpCoefficients(angles, spin, tilt.real, -tilt.imag, error)


def _axes_about(pole: Array) -> Array:
    """Return a rotation matrix whose third row is a unit vector."""
    first = np.cross(np.eye(3)[np.argmin(np.abs(pole))], pole)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(pole, first), pole])


def _means_of(
    torque: Callable[[Array], Array], rows: int, turned: Array, obliquities: Array
) -> tuple[Array, NDArray[np.complex128]]:
    """Return the means of a torque that is a function of the direction to the Sun, along the axis and across it.

    A mean over the rotation depends on the latitude of the Sun alone: along the axis it is a series of Legendre
    polynomials of its sine, across it that times the cosine, along the meridian of the Sun and, imaginary, ahead of it.
    """
    heights, weights = np.polynomial.legendre.leggauss(rows)
    turns = np.exp(1j * np.pi * (np.arange(2 * rows) + 0.5) / rows)
    across = np.sqrt(1 - heights**2)[:, None]
    z = np.broadcast_to(heights[:, None], (rows, 2 * rows))
    suns = np.stack([across * turns.real, across * turns.imag, z], axis=-1)
    t = (torque(suns.reshape(-1, 3) @ turned) @ turned.T).reshape(suns.shape)
    along, ahead = t[..., 2].mean(axis=1), ((t[..., 0] + 1j * t[..., 1]) * turns.conj()).mean(axis=1)
    project = (np.polynomial.legendre.legvander(heights, rows - 1) * weights[:, None]).T
    project *= np.arange(rows)[:, None] + 0.5
    sines = np.sin(
        2 * np.pi * (np.arange(4 * rows) + 0.5) / (4 * rows)
    )  # sines of the longitudes of the Sun from the equinox
    series = np.polynomial.legendre.legvander(np.sin(obliquities)[:, None] * sines, rows - 1)
    tilts = series @ (project @ (ahead / across[:, 0])) * sines * np.cos(obliquities)[:, None]
    return np.mean(series @ (project @ along), axis=1), np.asarray(np.mean(tilts, axis=1))


def _lost_to_shadows(
    light: Surface, turns: Array, turned: Array, obliquities: Array
) -> tuple[Array, NDArray[np.complex128], Array]:
    """Return the means of the torques that faces in shadow lose, and the estimated error.

    A mean over the orbit is a mean over equidistant longitudes of the Sun, with as many latitudes. Corners of shadows
    make it converge as slowly as the power -3/2 of the number. Every fourth latitude gives one of four sums, whose
    errors are about 8 times larger than the error of their mean: half of the largest deviation leaves a margin of 4.
    """
    shadows, accepted = DailyShadows(light, turned, turns), SHADOW_TOLERANCE * np.linalg.norm(turns, axis=1).sum()
    folded, back = np.unique(np.minimum(obliquities, np.pi - obliquities).round(14), return_inverse=True)
    folded = np.maximum(folded, MIN_OBLIQUITY)
    lost, error, number = np.zeros((len(folded), 3)), np.full(len(folded), np.inf), FEWEST_LATITUDES
    while number <= MAX_LATITUDES and np.any(error > accepted):
        rough = np.flatnonzero(error > accepted)
        longitudes = np.pi * ((np.arange(number) + 0.5) / number - 0.5)
        sines = np.sin(folded[rough])[:, None] * np.sin(longitudes)
        order = np.argsort(sines, axis=None)
        along, across = (np.empty(sines.size, dtype) for dtype in (float, complex))
        along[order], across[order] = shadows.torques(sines.ravel()[order])
        ascensions = (
            np.sin(longitudes) * np.cos(folded[rough])[:, None] / np.sqrt(1 - sines**2)
        )  # sines of the right ascensions
        first = across.reshape(sines.shape) * ascensions
        values = np.stack([along.reshape(sines.shape), first.real, first.imag], axis=-1)
        lost[rough] = values.mean(axis=1)
        # each latitude occurs twice in the orbit
        quarters = np.concatenate([values, values[:, ::-1]], axis=1).reshape(len(rough), -1, 8, 3).mean(axis=1)[:, :4]
        off = quarters - lost[rough][:, None]
        error[rough] = np.maximum(np.abs(off[..., 0]), np.hypot(off[..., 1], off[..., 2])).max(axis=1) / 2
        number *= 2
    spin, tilt = lost[back, 0], (lost[:, 1] + 1j * lost[:, 2])[back]
    return spin, np.where(obliquities > np.pi / 2, -tilt, tilt), error[back]


def _means_of_convex(
    light: Surface, t: Array, turned: Array, obliquities: Array
) -> tuple[Array, NDArray[np.complex128]]:
    """Return the means of the torque without shadows, by the mean light on each face and its first harmonic."""
    n = light.normals @ turned.T
    inwards = np.hypot(n[:, 0], n[:, 1])
    across = (t[:, 0] + 1j * t[:, 1]) * np.divide(n[:, 0] - 1j * n[:, 1], inwards, where=inwards > 0, out=0j * inwards)
    spin, tilt = np.zeros(len(obliquities)), np.zeros(len(obliquities), dtype=complex)
    rows = MAX_PAIRS // (2 * len(NODES))
    for start in range(0, len(n), rows):
        part = slice(start, start + rows)
        for i, obliquity in enumerate(obliquities):
            light_mean, first = _mean_light(inwards[part], n[part, 2], obliquity)
            spin[i] += light_mean @ t[part, 2]
            tilt[i] += first @ across[part]
    return spin, tilt


def _mean_light(inwards: Array, height: Array, obliquity: float) -> tuple[Array, Array]:
    """Return the means over an orbit of the light on faces and of its first harmonic times sin(right ascension).

    Each mean over the rotation has a kink where the face's longest day becomes a whole turn, |sin(longitude)
    sin(obliquity)| = cos(latitude of the face): the longitudes of the Sun from 0 to a right angle are cut there.
    """
    tilted = np.sin(obliquity)
    kinks = np.arcsin(np.minimum(1.0, np.divide(inwards, tilted, where=tilted > 0, out=np.ones_like(inwards))))
    lengths = np.stack([kinks, np.pi / 2 - kinks], axis=-1)
    longitudes = np.stack([kinks * 0, kinks], axis=-1)[..., None] + lengths[..., None] * NODES
    sines = np.sin(longitudes)
    cosines = np.hypot(np.cos(longitudes), sines * np.cos(obliquity))  # cosines of the latitude of the Sun
    level, up = inwards[:, None, None] * cosines, height[:, None, None] * tilted * sines
    (day, day_first), (night, night_first) = _daily_light(level, up), _daily_light(level, -up)
    ascension = np.divide(sines * np.cos(obliquity), cosines, where=cosines > 0, out=np.zeros_like(sines))
    shares = lengths[..., None] * WEIGHTS / np.pi
    return np.sum((day + night) * shares, axis=(1, 2)), np.sum(
        (day_first - night_first) * ascension * shares, axis=(1, 2)
    )


def _daily_light(level: Array, up: Array) -> tuple[Array, Array]:
    """Return the mean of max(0, level cos x + up) over a turn and its first harmonic, by the half length of the day."""
    noon = np.divide(-up, level, where=level > 0, out=-np.sign(up))
    half = np.arccos(np.clip(noon, -1.0, 1.0))
    sine = np.sin(half)
    return (level * sine + up * half) / np.pi, (level * (half + sine * np.cos(half)) / 2 + up * sine) / np.pi
