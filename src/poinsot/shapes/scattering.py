"""Laws of scattering: the light that a unit area of a surface reflects towards an observer, by one formula each.

The brightness S of a law is the brightness of a unit area relative to a white Lambert plate of the same area that the
Sun illuminates and the observer views perpendicularly. With the bidirectional reflectance f_r, S = pi f_r mu0 mu.
"""

from __future__ import annotations

import math
import warnings
from abc import ABC, abstractmethod
from functools import partial
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot import functions
from poinsot.errors import level_of_user, refuse_others_than_shares, refuse_outside
from poinsot.functions import Scalar
from poinsot.immutable import Immutable, cached_property
from poinsot.quantities import Real, Rule
from poinsot.records.members import of_scalars
from poinsot.records.parameters import NotNegative, Parametric, Positive
from poinsot.subclasses import is_own

__all__ = [
    "AshikhminShirley",
    "CookTorrance",
    "Hapke",
    "HenyeyGreenstein",
    "IsotropicPhase",
    "Lambert",
    "LambertLommelSeeliger",
    "LommelSeeliger",
    "LunarLambert",
    "Minnaert",
    "PhaseFunction",
    "Phong",
    "Reflection",
    "ScatteringLaw",
]

SAMPLED_NODES = 24
"""Number of directions of each angle at which a law is checked."""

GRAZING_COSINE = 0.1
"""Smallest cosine of incidence at which the reflected energy is checked."""

LAW_TOLERANCE = 1e-2
"""Largest relative violation of reciprocity and energy without a warning, above the error of the sampling."""

SMALL = 1e-30
"""Lower limit of denominators that are zero at single angles."""

LARGEST_COSINE = 1 - 1e-15
"""Upper limit of cosines whose angle has a derivative."""


class Reflection(Immutable):
    """Angles at which a surface element reflects light; the argument of the formula of a scattering law.

    Parameters
    ----------
    mu0, mu : scalar
        Cosines of the angles of incidence and of emission, both positive: normal . direction to the Sun, and normal .
        direction to the observer.
    phase : scalar
        Phase angle between the directions to the Sun and to the observer, in radians.

    Examples
    --------
    >>> light = pt.observables.Reflection(mu0=0.5, mu=1.0, phase=pt.functions.pi / 3)
    >>> round(float(light.cos_phase), 12), round(float(light.half), 12)
    (0.5, 0.866025403784)
    """

    def __init__(self, mu0: Scalar, mu: Scalar, phase: Scalar) -> None:
        self.mu0, self.mu, self.phase = mu0, mu, phase

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the angles: (members, ...) for members."""
        return np.broadcast_shapes(*(getattr(x, "shape", ()) for x in (self.mu0, self.mu, self.phase)))

    @cached_property
    def cos_phase(self) -> Scalar:
        """Cosine of the phase angle."""
        return functions.cos(self.phase)

    @cached_property
    def half_view(self) -> Scalar:
        """Cosine of half the phase angle, v . h with the direction h midway between Sun and observer."""
        return functions.cos(0.5 * self.phase)

    @cached_property
    def half(self) -> Scalar:
        """Cosine n . h of the angle between the normal and the direction h midway between Sun and observer."""
        return (0.5 / self.half_view) * (self.mu0 + self.mu)

    @cached_property
    def mirror(self) -> Scalar:
        """Cosine of the angle between the mirrored ray and the direction to the observer, 2 mu0 mu - cos(phase)."""
        return 2.0 * (self.mu0 * self.mu) - self.cos_phase


Share = Annotated[Real, Rule(refuse_others_than_shares, "It is a share of the light.")]


def _below(low: float, high: float, limits: str) -> partial[None]:
    """Return a check of numbers above or at a lower limit and below an upper limit, which a text describes."""
    return partial(refuse_outside, low, math.nextafter(high, low), limits)


Asymmetry = Annotated[Real, Rule(_below(math.nextafter(-1, 1), 1, "between -1 and 1"), "All light goes one way at 1.")]


class ScatteringLaw(Parametric, ABC):
    """Law of scattering of a surface by one formula; the base class of all laws.

    A subclass defines `brightness(light)`, the brightness S of a unit area relative to a white Lambert plate of this
    area that is illuminated and viewed perpendicularly. The formula must be symmetric in mu0 and mu (reciprocity) and
    must not be negative, and its integral of S / mu0 over the hemisphere of directions to the observer must not exceed
    pi (energy). A warning names a law of the user that violates a condition.

    Examples
    --------
    >>> class Dusty(pt.observables.ScatteringLaw):
    ...     albedo: float
    ...     def brightness(self, light):
    ...         return self.albedo * (light.mu0 * light.mu) / (light.mu0 + light.mu)
    >>> float(Dusty(0.1).brightness(pt.observables.Reflection(1.0, 1.0, 0.0)))
    0.05
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if not is_own(type(self)) and (fault := fault_of(self)):
            warnings.warn(fault, stacklevel=level_of_user())

    @of_scalars
    @abstractmethod
    def brightness(self, light: Reflection) -> Any:
        """Return the brightness S of a unit area; a scalar of the kind of the angles."""


def fault_of(law: ScatteringLaw) -> str:
    """Return the first condition that a law violates, with the worst value, or an empty string."""
    name, members = type(law).__name__, law.member_axis
    nodes, weights = np.polynomial.legendre.leggauss(SAMPLED_NODES)
    incidence = np.linspace(GRAZING_COSINE, 1.0, SAMPLED_NODES)[:, None, None]
    cosines, azimuth = 0.5 * (nodes[:, None] + 1), 0.5 * np.pi * (nodes + 1)
    sines = np.sqrt((1 - incidence**2) * (1 - cosines**2))
    phase = np.arccos(np.clip(incidence * cosines + sines * np.cos(azimuth), -1, 1))
    there, back = (
        np.broadcast_to(np.asarray(law.with_axes(4).brightness(light), dtype=float), (*members, *phase.shape))
        for light in (Reflection(incidence, cosines, phase), Reflection(cosines, incidence, phase))
    )
    size = np.abs(there).max()
    energy = 0.5 * np.pi * np.einsum("...ijk,j,k->...i", there / incidence, weights, weights).max()
    asymmetry = np.abs(there - back).max() / size if size else 0.0
    if there.min() < 0:
        return f"{name}.brightness should not be negative, got {there.min():.3g}."
    if asymmetry > LAW_TOLERANCE:
        return f"{name}.brightness should be symmetric in mu0 and mu, got a relative difference of {asymmetry:.3g}."
    if energy > np.pi * (1 + LAW_TOLERANCE):
        share = energy / np.pi
        return f"{name}.brightness should reflect at most the light that arrives, got {share:.3g} times this light."
    return ""


class Lambert(ScatteringLaw):
    """Lambert's law of a matt surface, S = albedo mu0 mu.

    Parameters
    ----------
    albedo : float
        Share of the light that the surface reflects, in [0, 1].

    Examples
    --------
    >>> float(pt.observables.Lambert(0.5).brightness(pt.observables.Reflection(1.0, 1.0, 0.0)))
    0.5
    """

    albedo: Share

    @override
    def brightness(self, light: Reflection) -> Scalar:
        return self.albedo * (light.mu0 * light.mu)


class PhaseFunction(Parametric, ABC):
    """Phase function p of single scattering by one formula, 1 for isotropic scattering; the base class.

    A subclass defines `value(light)`, which depends on the phase angle alone.

    Examples
    --------
    >>> class Linear(pt.observables.PhaseFunction):
    ...     slope: float
    ...     def value(self, light):
    ...         return 1 - self.slope * light.phase
    >>> law = pt.observables.LommelSeeliger(0.2, Linear(0.5))
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.4))), 12)
    0.02
    """

    @of_scalars
    @abstractmethod
    def value(self, light: Reflection) -> Any:
        """Return p at the phase angle of a reflection."""


class IsotropicPhase(PhaseFunction):
    """Phase function of isotropic scattering, p = 1.

    Examples
    --------
    >>> pt.observables.IsotropicPhase().value(pt.observables.Reflection(1.0, 1.0, 0.4))
    1.0
    """

    @override
    def value(self, light: Reflection) -> float:
        return 1.0


class HenyeyGreenstein(PhaseFunction):
    """Phase function of Henyey and Greenstein, p = (1 - g^2) / (1 + 2 g cos(phase) + g^2)^(3/2).

    Parameters
    ----------
    g : float
        Asymmetry, in (-1, 1): negative for backward scattering, 0 for isotropic scattering.

    References
    ----------
    L. G. Henyey and J. L. Greenstein, Diffuse radiation in the galaxy, Astrophys. J. 93, 70 (1941).

    Examples
    --------
    >>> light = pt.observables.Reflection(1.0, 1.0, 0.0)
    >>> round(float(pt.observables.HenyeyGreenstein(-0.5).value(light)), 12)
    6.0
    """

    g: Asymmetry

    @override
    def value(self, light: Reflection) -> Scalar:
        square = 1 + 2 * self.g * light.cos_phase + self.g * self.g
        return (1 - self.g * self.g) / (square * functions.sqrt(square))


class LommelSeeliger(ScatteringLaw):
    """Law of Lommel and Seeliger of a dark, porous surface, S = (albedo/4) p mu0 mu / (mu0 + mu).

    Parameters
    ----------
    albedo : float
        Albedo of single scattering, in [0, 1]. A unit area that is illuminated and viewed perpendicularly has the
        brightness p albedo / 8.
    phase : PhaseFunction
        Phase function p of the phase angle. Default: isotropic scattering, p = 1.

    References
    ----------
    H. von Seeliger, Zur Theorie der Beleuchtung der grossen Planeten, Abh. Bayer. Akad. Wiss. 16, 405 (1887).

    Examples
    --------
    >>> float(pt.observables.LommelSeeliger(0.2).brightness(pt.observables.Reflection(1.0, 1.0, 0.0)))
    0.025
    """

    albedo: Share
    phase: PhaseFunction = IsotropicPhase()

    @override
    def brightness(self, light: Reflection) -> Scalar:
        return self.factor(light) * lommel_seeliger(light)

    @of_scalars
    def factor(self, light: Reflection) -> Scalar:
        """Return the factor that depends on the phase angle alone, albedo p / 4."""
        factor: Scalar = 0.25 * self.albedo * self.phase.value(light)
        return factor


def lommel_seeliger(light: Reflection) -> Scalar:
    """Return mu0 mu / (mu0 + mu)."""
    return light.mu0 * light.mu / (light.mu0 + light.mu)


class LambertLommelSeeliger(ScatteringLaw):
    """Sum of the laws of Lommel and Seeliger and of Lambert, times a phase function.

    S = f mu0 mu (1 / (mu0 + mu) + c) with f = a exp(-phase/d) + k phase + 1. The law has no albedo: it is for light
    curves on a relative scale.

    Parameters
    ----------
    c : float
        Weight of Lambert's law.
    a, d : float
        Amplitude and width, in radians, of the opposition surge.
    k : float
        Slope of the phase function, per radian.

    References
    ----------
    M. Kaasalainen, J. Torppa and K. Muinonen, Optimization methods for asteroid lightcurve inversion II,
    Icarus 153, 37 (2001).

    Examples
    --------
    >>> law = pt.observables.LambertLommelSeeliger(c=0.1, a=0.5, d=0.1, k=-0.5)
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.0))), 12)
    0.9
    """

    c: NotNegative
    a: float = 0.0
    d: Positive = 1.0
    k: float = 0.0

    @override
    def brightness(self, light: Reflection) -> Scalar:
        phase_function = self.a * functions.exp(-light.phase / self.d) + self.k * light.phase + 1
        return phase_function * (lommel_seeliger(light) + self.c * (light.mu0 * light.mu))


class Minnaert(ScatteringLaw):
    """Minnaert's law, S = albedo (mu0 mu)^k; k = 1 is Lambert's law.

    Parameters
    ----------
    albedo : float
        Brightness of a unit area that is illuminated and viewed perpendicularly, not negative.
    k : float
        Exponent of limb darkening, positive. Below 1 the law reflects more light than arrives at grazing incidence.

    References
    ----------
    M. Minnaert, The reciprocity principle in lunar photometry, Astrophys. J. 93, 403 (1941).

    Examples
    --------
    >>> float(pt.observables.Minnaert(0.5, 0.5).brightness(pt.observables.Reflection(0.25, 1.0, 0.0)))
    0.25
    """

    albedo: NotNegative
    k: Positive

    @override
    def brightness(self, light: Reflection) -> Scalar:
        return self.albedo * (light.mu0 * light.mu) ** self.k


class LunarLambert(ScatteringLaw):
    """Lunar-Lambert law, S = albedo mu (2 L mu0 / (mu0 + mu) + (1 - L) mu0).

    Parameters
    ----------
    albedo : float
        Brightness of a unit area that is illuminated and viewed perpendicularly, not negative.
    L : float
        Weight of the law of Lommel and Seeliger, in [0, 1]; 1 - L is the weight of Lambert's law.

    References
    ----------
    A. S. McEwen, Photometric functions for photoclinometry and other applications, Icarus 92, 298 (1991).

    Examples
    --------
    >>> float(pt.observables.LunarLambert(0.25, 0.75).brightness(pt.observables.Reflection(1.0, 1.0, 0.0)))
    0.25
    """

    albedo: NotNegative
    L: Share

    @override
    def brightness(self, light: Reflection) -> Scalar:
        return self.albedo * (2 * self.L * lommel_seeliger(light) + (1 - self.L) * (light.mu0 * light.mu))


class Hapke(ScatteringLaw):
    """Hapke's law of a regolith with an opposition surge and macroscopic roughness.

    S = (w/4) mu mu0e / (mu0e + mue) ((1 + B) p + H(mu0e) H(mue) - 1) Sr with the surge B = b0 / (1 + tan(phase/2) / h),
    the phase function p = (1 - g^2) / (1 + 2 g cos(phase) + g^2)^(3/2) and H(x) = (1 + 2x) / (1 + 2x sqrt(1 - w)). The
    effective cosines mu0e, mue and the shadowing function Sr follow from the roughness (1984, eqs. 47 to 51). The
    factor mue / mu of some programs is absent because the law would not be reciprocal.

    Parameters
    ----------
    w : float
        Albedo of single scattering, in [0, 1].
    b0, h : float
        Amplitude, and angular width, of the opposition surge. b0 is not negative, h is positive.
    g : float
        Asymmetry of the phase function, in (-1, 1); negative for a surface that scatters backwards.
    roughness : float
        Mean slope angle of the surface in radians, in [0, pi/2); 0 is a smooth surface.

    References
    ----------
    B. Hapke, Bidirectional reflectance spectroscopy 1, J. Geophys. Res. 86, 3039 (1981), and 3, Icarus 59, 41 (1984).

    Examples
    --------
    >>> law = pt.observables.Hapke(w=0.33, b0=1.2, h=0.04, g=-0.3)
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.0))), 6)
    0.252901
    """

    w: Share
    b0: NotNegative
    h: Positive
    g: Asymmetry
    roughness: Annotated[
        Real, Rule(_below(0, 0.5 * math.pi, "from 0 to below pi/2"), "It is the mean slope in radians.")
    ] = 0.0

    @override
    def brightness(self, light: Reflection) -> Scalar:
        mu0, mu, shadowing = self._effective_cosines(light)
        single = HenyeyGreenstein.unchecked(g=self.g).value(light)
        surge = self.b0 / (1 + functions.tan(0.5 * light.phase) / self.h)
        multiple = self._multiple(mu0) * self._multiple(mu)
        smooth = mu0 * mu / (mu0 + mu) * ((1 + surge) * single - 1 + multiple)
        return 0.25 * self.w * (smooth * shadowing)

    def _multiple(self, x: Scalar) -> Scalar:
        """Return the function H(x) of isotropic multiple scattering."""
        return (1 + 2 * x) / (1 + 2 * functions.sqrt(1 - self.w) * x)

    def _effective_cosines(self, light: Reflection) -> tuple[Scalar, Scalar, Scalar]:
        """Return mu0e, mue and mu Sr / mue: all three are symmetric in incidence and emission.

        a is the smaller and b the larger of the angles i and e, psi the azimuth between the planes of incidence and
        emission, f = exp(-2 tan(psi/2)), and Sr = mu0 mue chi / (eta(a) eta(b) (1 - f + f chi cos(a) / eta(a))).
        """
        if _is_zero(self.roughness):
            return light.mu0, light.mu, 1.0
        tangent = functions.maximum(functions.tan(self.roughness), SMALL)
        chi = 1 / functions.sqrt(1 + functions.pi * tangent * tangent)
        cosines = functions.maximum(light.mu0, light.mu), functions.minimum(light.mu0, light.mu)
        (cos_a, sin_a, e1_a, e2_a), (cos_b, sin_b, e1_b, e2_b) = (_slopes(x, tangent) for x in cosines)
        square, tan_half = _half_azimuth(light.phase, *cosines)
        share = tangent / (2 - e1_b - 2 / functions.pi * functions.atan(tan_half) * e1_a)
        near = chi * (cos_a + sin_a * share * ((1 - 2 * square) * e2_b + square * e2_a))
        far = chi * (cos_b + sin_b * share * (e2_b - square * e2_a))
        eta_a = chi * (cos_a + sin_a * tangent * e2_a / (2 - e1_a))
        eta_b = chi * (cos_b + sin_b * tangent * e2_b / (2 - e1_b))
        f = functions.exp(-2 * tan_half)
        shadowing = chi * cos_a * cos_b / (eta_b * ((1 - f) * eta_a + f * chi * cos_a))
        return near, far, shadowing


def _slopes(cosine: Scalar, tangent: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return cos x, sin x, E1(x) and E2(x), with the tangent t of the mean slope.

    E1 = exp(-2 cot(x) / (pi t)) and E2 = exp(-cot(x)^2 / (pi t^2)).
    """
    sine = functions.sqrt(functions.maximum(1 - cosine * cosine, SMALL))
    ratio = cosine / (sine * tangent)
    return cosine, sine, functions.exp(-2 / functions.pi * ratio), functions.exp(-1 / functions.pi * ratio * ratio)


def _half_azimuth(phase: Scalar, cos_a: Scalar, cos_b: Scalar) -> tuple[Scalar, Scalar]:
    """Return sin(psi/2)^2 and tan(psi/2) of the angle psi between two sides of a spherical triangle.

    The formulas of half angles are exact near opposition, where the cosine of psi would lose half of its digits.
    """
    a, b = (functions.acos(functions.minimum(x, LARGEST_COSINE)) for x in (cos_a, cos_b))
    above = functions.sin(0.5 * (phase + b - a)) * functions.sin(0.5 * (phase - b + a))
    below = functions.sin(0.5 * (a + b + phase)) * functions.sin(0.5 * (a + b - phase))
    above, below = functions.maximum(above, SMALL), functions.maximum(below, SMALL)
    return above / (above + below), functions.sqrt(above / below)


def _is_zero(number: Any) -> bool:
    """Return True for a number that is exactly zero, or zero for all members."""
    return isinstance(number, float | np.ndarray) and bool(np.all(number == 0))


class Phong(ScatteringLaw):
    """Phong's law, normalised and reciprocal: S = mu0 mu (diffuse + specular (n + 2)/2 max(0, cos(angle))^n).

    The angle is the angle between the mirrored ray and the direction to the observer, cos(angle) = 2 mu0 mu -
    cos(phase).

    Parameters
    ----------
    diffuse, specular : float
        Shares of the light that the surface reflects diffusely and specularly, in [0, 1].
    n : float
        Exponent of the lobe, positive.

    References
    ----------
    E. P. Lafortune and Y. D. Willems, Using the modified Phong reflectance model for physically based rendering,
    Report CW197, K. U. Leuven (1994).

    Examples
    --------
    >>> law = pt.observables.Phong(diffuse=0.3, specular=0.4, n=20.0)
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.0))), 12)
    4.7
    """

    diffuse: Share
    specular: Share
    n: Positive

    @override
    def brightness(self, light: Reflection) -> Scalar:
        is_lit = functions.less(0, light.mirror)
        lobe = functions.where(is_lit, functions.where(is_lit, light.mirror, 1.0) ** self.n, 0.0)
        return light.mu0 * light.mu * (self.diffuse + 0.5 * self.specular * (self.n + 2) * lobe)


class CookTorrance(ScatteringLaw):
    """Law of Cook and Torrance of rough surfaces with a specular lobe, S = diffuse mu0 mu + pi specular D G F / 4.

    D = exp(-tan(a)^2 / m^2) / (pi m^2 cos(a)^4) with the angle a between the normal and the direction h midway
    between Sun and observer; G = min(1, 2 (n.h) mu / (v.h), 2 (n.h) mu0 / (v.h)) with the direction v to the observer.
    F is the reflectance of a dielectric with the refractive index (1 + sqrt(f0)) / (1 - sqrt(f0)) (Fresnel).

    Parameters
    ----------
    diffuse, specular : float
        Shares of the light that the surface reflects diffusely and specularly, in [0, 1].
    m : float
        Root mean square slope of the microscopic facets, positive.
    f0 : float
        Reflectance at normal incidence, in [0, 1).

    References
    ----------
    R. L. Cook and K. E. Torrance, A reflectance model for computer graphics, ACM Trans. Graph. 1, 7 (1982).

    Examples
    --------
    >>> law = pt.observables.CookTorrance(diffuse=0.3, specular=0.5, m=0.3, f0=0.2)
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.0))), 6)
    0.577778
    """

    diffuse: Share
    specular: Share
    m: Positive
    f0: Annotated[Real, Rule(_below(0, 1, "from 0 to below 1"), "The refractive index is infinite at 1.")]

    @override
    def brightness(self, light: Reflection) -> Scalar:
        square = 1 / (light.half * light.half)
        slopes = functions.exp((1 - square) / (self.m * self.m)) * (square * square) / (self.m * self.m)
        masking = functions.minimum(1.0, 2 / light.half_view * light.half * functions.minimum(light.mu, light.mu0))
        specular = 0.25 * self.specular * self._reflectance(light.half_view)
        return self.diffuse * (light.mu0 * light.mu) + specular * (slopes * masking)

    def _reflectance(self, cosine: Scalar) -> Scalar:
        """Return Fresnel's reflectance of unpolarised light at an angle of incidence."""
        root = functions.sqrt(self.f0)
        index = (1 + root) / (1 - root)
        g = functions.sqrt(index * index - 1 + cosine * cosine)
        across, along = (g - cosine) / (g + cosine), (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
        return 0.5 * across * across * (1 + along * along)


class AshikhminShirley(ScatteringLaw):
    """Law of Ashikhmin and Shirley of a glossy surface, isotropic.

    S = 28 rho / 23 (1 - f0) mu0 mu (1 - (1 - mu0/2)^5) (1 - (1 - mu/2)^5) + (n + 1) / 8 mu0 mu (n.h)^n F /
    ((v.h) max(mu0, mu)) with F = f0 + (1 - f0) (1 - v.h)^5, the direction h midway between Sun and observer, and the
    direction v to the observer.

    Parameters
    ----------
    rho : float
        Share of the light that enters the surface and leaves it diffusely, in [0, 1].
    f0 : float
        Reflectance at normal incidence, in [0, 1].
    n : float
        Exponent of the lobe, positive.

    References
    ----------
    M. Ashikhmin and P. Shirley, An anisotropic Phong BRDF model, J. Graphics Tools 5, 25 (2000).

    Examples
    --------
    >>> law = pt.observables.AshikhminShirley(rho=0.4, f0=0.3, n=30.0)
    >>> round(float(law.brightness(pt.observables.Reflection(1.0, 1.0, 0.0))), 6)
    1.482398
    """

    rho: Share
    f0: Share
    n: Positive

    @override
    def brightness(self, light: Reflection) -> Scalar:
        mu0, mu = light.mu0, light.mu
        diffuse = (
            28 / 23 * self.rho * (1 - self.f0) * (mu0 * mu * (1 - (1 - 0.5 * mu0) ** 5) * (1 - (1 - 0.5 * mu) ** 5))
        )
        reflectance = self.f0 + (1 - self.f0) * (1 - light.half_view) ** 5
        lobe = light.half**self.n * functions.minimum(mu0, mu)
        return diffuse + 0.125 * (self.n + 1) * reflectance / light.half_view * lobe
