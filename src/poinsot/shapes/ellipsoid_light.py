"""Reflected light of ellipsoids: quadratures over the part of the surface that is lit and seen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.functions import norm
from poinsot.shapes.law_program import FacetFormulas, LawFormula, Wanted
from poinsot.shapes.reflected_light import MIN_COMPILED, FacetBlock, ReflectedLight, Sums
from poinsot.shapes.solids import Ellipsoid
from poinsot.taylor.compiled_sums import CompiledSums
from poinsot.taylor.graph import Graph, Number

__all__ = ["LightOfEllipsoid", "Quadrature"]

Array = NDArray[np.float64]


class LightOfEllipsoid(ReflectedLight):
    """Light of an ellipsoid, as an integral over the part of the unit sphere that is lit and seen.

    The linear map L of the unit sphere to the stretched ellipsoid takes the area element dw at the unit vector u to
    n dA = det L L^-T u dw. The lit and seen part is a lune between two great circles: with the angle gamma between the
    images s' = L^-1 s and e' = L^-1 e, its longitudes from the mean direction in the plane of s' and e' lie within
    (pi - gamma)/2. Integrands vanish at its edges, and so derivatives are integrals of derivatives.

    The quadrature is chosen once, for the stretch and the numbers of the law of the first call.
    """

    def __init__(self, shape: Ellipsoid, formula: LawFormula, rule: Quadrature | None = None) -> None:
        super().__init__(formula)
        self._shape, self._rule = shape, rule

    @override
    def entries(self, numbers: Sequence[int], *variables: Number) -> Mapping[int, Number]:
        if self._rule is None:
            self._rule = _quadrature(self._shape, self.formula, [float(np.ravel(x)[0]) for x in variables[6:]])
        return super().entries(numbers, *variables)

    @override
    def sums(self, wanted: Wanted, vectors: Array, stretch: Array, scalars: Sequence[Any]) -> Sums:
        rule, epochs = cast("Quadrature", self._rule), vectors.shape[1]
        is_long = epochs * rule.count >= MIN_COMPILED and not rule.halves
        compiled = self.formula.compiled_sums(wanted, lune_formulas) if is_long else None
        if compiled is None:
            return super().sums(wanted, vectors, stretch, scalars)
        found = []
        rows = max(1, LONGITUDES_OF_BLOCK // len(rule.weights))
        for start in range(0, epochs, rows):
            part = slice(start, start + rows)
            lune = Lune(self._shape, rule, vectors[:, part], stretch)
            own = (x[part, None] if np.ndim(x) else x for x in scalars)
            inputs = [*lune.first, *lune.second, *lune.edges, *(np.broadcast_to(x, lune.weights.shape) for x in own)]
            table = CompiledSums.table(np.stack([lune.cosines, lune.sines, lune.areas]).reshape(3, -1))
            each = compiled(table, np.stack(inputs).reshape(len(inputs), -1))
            found.append(np.sum(each.reshape(-1, *lune.weights.shape) * lune.weights, axis=-1))
        return Sums.of(wanted, np.concatenate(found, axis=1))

    @override
    def blocks(self, vectors: Array, stretch: Array, buffers: int) -> Iterator[tuple[FacetBlock, Sequence[Array]]]:
        rule, epochs = cast("Quadrature", self._rule), vectors.shape[1]
        rows = max(1, min(epochs, NODES_OF_BLOCK // rule.count))
        space = np.empty((buffers, rows * rule.count))
        for start in range(0, epochs, rows):
            part = slice(start, min(start + rows, epochs))
            block = BlockOfEllipsoid(part, Lune(self._shape, rule, vectors[:, part], stretch))
            yield block, [x[: block.mu0.size] for x in space]


class Quadrature:
    """Nodes in two angles, each mapped from [-1, 1].

    Parameters
    ----------
    after, before : array (n,)
        Distances 1 + x and 1 - x of the nodes from the ends, without cancellation.
    weights : array (n,)
        Weights, of sum 2.
    halves : bool
        True to divide the longitudes where the cosines of incidence and emission are equal, and the latitudes where the
        normal lies in the plane of both directions: laws with kinks there are smooth in all parts.
    """

    def __init__(self, after: Array, before: Array, weights: Array, halves: bool) -> None:
        self.after, self.before, self.weights, self.halves = after, before, weights, halves
        self.count = (len(weights) * (1 + halves)) ** 2

    @staticmethod
    def gauss(count: int, halves: bool = False) -> Quadrature:
        """Return the rule of Gauss and Legendre."""
        nodes, weights = np.polynomial.legendre.leggauss(count)
        return Quadrature(1 + nodes, 1 - nodes, weights, halves)

    @staticmethod
    def double_exponential(count: int, halves: bool = False) -> Quadrature:
        """Return the rule with x = tanh(pi/2 sinh t), for powers at the edges."""
        t = np.linspace(-TANH_SINH_END, TANH_SINH_END, count)
        exponent = np.pi * np.sinh(t)
        before, after = 2 / (1 + np.exp(exponent)), 2 / (1 + np.exp(-exponent))
        weights = 0.5 * np.pi * np.cosh(t) * before * after * (t[1] - t[0])
        return Quadrature(after, before, weights, halves)

    def nodes(self, split: Array) -> tuple[Array, Array, Array]:
        """Return 1 + x, 1 - x and weights, divided at 1 + x = split; the axis of nodes is last."""
        split = split[..., None]
        if not self.halves:
            whole = np.ones_like(split)
            return whole * self.after, whole * self.before, whole * self.weights
        low, high = 0.5 * split * self.after, 0.5 * (2 - split) * self.before
        after, before = (np.concatenate(x, axis=-1) for x in ((low, 2 - high), (2 - low, high)))
        weights = 0.5 * np.concatenate([split * self.weights, (2 - split) * self.weights], axis=-1)
        return after, before, weights


TANH_SINH_END = 3.3
"""Last t of the double-exponential rule: the outer nodes are within 1e-18 of the edges."""

QUADRATURES: tuple[tuple[Callable[[int, bool], Quadrature], bool, tuple[int, ...]], ...] = (
    (Quadrature.gauss, False, (8, 12, 16, 24, 32, 48, 64)),
    (Quadrature.gauss, True, (16, 24, 32, 48, 64)),
    (Quadrature.double_exponential, False, (47, 63, 95, 127, 159)),
    (Quadrature.double_exponential, True, (47, 63, 95, 127)),
)
"""Rules in the order in which they are tried, and numbers of nodes."""

QUADRATURE_TOLERANCE = 1e-10
"""Relative difference of two rules below which the rule with more nodes is accepted."""

KINK_TOLERANCE = 1e-5
"""Relative difference that is accepted for laws with kinks inside the lit part, such as masking and roughness."""

PHASES = (0.0, 0.3, 0.8, 1.4, 2.0, 2.4)
"""Phase angles at which rules are compared."""


def _quadrature(shape: Ellipsoid, formula: LawFormula, numbers: Sequence[float]) -> Quadrature:
    """Return the first rule that agrees with the rule before it, or the smallest one that nearly agrees.

    The numbers are the stretch, the phase angle and numbers of the law.
    """
    sun, observer, towards_sun, towards_observer = _sampled_directions()
    scalars: Sequence[Number] = *numbers[:3], np.array(PHASES), *numbers[4:]
    found: list[tuple[float, Quadrature]] = []
    for make, halves, counts in QUADRATURES:
        last = None
        for count in counts:
            rule = make(count, halves)
            entries = LightOfEllipsoid(shape, formula, rule).entries(range(11), *sun, *observer, *scalars)
            values = np.stack([entries[k] for k in range(11)])
            values[1:4] -= values[10] * towards_observer
            values[4:7] -= values[10] * towards_sun
            if last is not None:
                found.append((_difference(values, last), rule))
                if found[-1][0] < QUADRATURE_TOLERANCE:
                    return rule
            last = values
    nearly = [rule for error, rule in found if error < KINK_TOLERANCE]
    return min(nearly, key=lambda rule: rule.count) if nearly else min(found, key=lambda each: each[0])[1]


def _sampled_directions() -> tuple[Array, Array, Array, Array]:
    """Return unit vectors (3, n) to Sun and observer, and the unit tangents from one to the other, at both of them."""
    sun, across = np.random.default_rng(0).normal(size=(2, 3, len(PHASES)))
    sun /= np.linalg.norm(sun, axis=0)
    across = np.cross(np.cross(sun, across, axis=0), sun, axis=0)
    across /= np.linalg.norm(across, axis=0)
    cosines, sines = np.cos(PHASES), np.sin(PHASES)
    return sun, cosines * sun + sines * across, sines * sun - cosines * across, across


def _difference(values: Array, others: Array) -> float:
    """Return the largest relative difference of values and of gradients by sun, observer and stretch."""
    parts = slice(0, 1), slice(1, 4), slice(4, 7), slice(7, 10)
    return max(float(np.max(np.abs(values - others)[x] / np.abs(values[x]).max(axis=0))) for x in parts)


class Lune:
    """Part of the unit sphere that is lit and seen at some epochs, with the nodes of a quadrature.

    At the node of a longitude and of the latitude b, L^-T u = cos b * first + sin b * second is the normal times its
    length, and cos b * edges are the cosines of incidence and emission times this length. The area is the length times
    weight * area.

    Attributes
    ----------
    first, second : array (3, epochs, longitudes)
    edges : two of array (epochs, longitudes)
    weights : array (epochs, longitudes)
    cosines, sines, areas : array (epochs, longitudes, latitudes)
        Cosine and sine of b, and weights; both axes before the last one have length 1 if all latitudes are equal.
    """

    def __init__(self, shape: Ellipsoid, rule: Quadrature, vectors: Array, stretch: Array) -> None:
        to_sphere = shape.to_unit_sphere / stretch
        images = np.stack([to_sphere @ vectors[:3], to_sphere @ vectors[3:]])
        lengths = np.linalg.norm(images, axis=1)
        sun, observer = images / lengths[:, None]
        together, apart = sun + observer, sun - observer
        cosine, sine = (0.5 * np.linalg.norm(x, axis=0) for x in (together, apart))
        x_axis = _unit(together, sun)
        across_x = apart - x_axis * np.sum(x_axis * apart, axis=0)  # differs from `apart` at a phase of rounding
        y_axis = _unit(across_x, _perpendicular(x_axis))
        axes = np.stack([x_axis, y_axis, np.cross(x_axis, y_axis, axis=0)])
        half = np.maximum(np.arctan2(cosine, sine), EDGE)
        ratio = (lengths[1] - lengths[0]) / (lengths[1] + lengths[0])
        after, before, weights = rule.nodes(1 + np.arctan(np.tan(half) * ratio) / half)
        half = half[:, None]
        along, across = np.cos(half * (after - 1)), np.sin(half * (after - 1))
        columns = np.einsum("ji,kje->ike", to_sphere, axes)[..., None]
        self.first = along * columns[:, 0] + across * columns[:, 1]
        self.second = np.broadcast_to(columns[:, 2], self.first.shape)
        self.edges = [
            length[:, None] * np.sin(half * edge) for length, edge in zip(lengths, (after, before), strict=True)
        ]
        self.weights = float(np.prod(shape.semiaxes) * np.prod(stretch)) * half * weights
        split = np.ones((1, 1))
        if rule.halves:
            normal = to_sphere @ np.cross(vectors[:3], vectors[3:], axis=0)
            pole = np.einsum("kje,je->ke", axes, normal)[..., None]
            split = 1 + 2 / np.pi * np.arctan2(-(along * pole[0] + across * pole[1]), np.maximum(pole[2], EDGE))
        latitude, below, areas = rule.nodes(split)
        self.cosines = np.sin(0.5 * np.pi * np.minimum(latitude, below))
        self.sines = np.sin(0.5 * np.pi * (latitude - 1))
        self.areas = 0.5 * np.pi * areas * self.cosines


class BlockOfEllipsoid(FacetBlock):
    """Nodes of the quadrature over the lit and seen part of an ellipsoid at some epochs."""

    def __init__(self, epochs: slice, lune: Lune) -> None:
        self.epochs = epochs
        normals = lune.cosines * lune.first[..., None] + lune.sines * lune.second[..., None]
        size = np.sqrt(np.sum(normals * normals, axis=0))
        normals /= size
        shared = lune.cosines / size
        self.mu0, self.mu = ((edge[..., None] * shared).ravel() for edge in lune.edges)
        self._areas = (lune.areas * size * lune.weights[..., None]).reshape(len(size), -1)
        self._normals = normals.reshape(3, len(size), -1)

    @property
    @override
    def counts(self) -> int:
        return int(self._areas.shape[1])

    @override
    def sums(self, values: Array | float, power: int) -> Array:
        weighted = self._areas * np.reshape(values, (-1, 1) if np.ndim(values) == 0 else self._areas.shape)
        if power == 0:
            return np.asarray(np.sum(weighted, axis=1)[None])
        return np.asarray(np.einsum("ef,kef->ke", weighted, self._normals**power))


def lune_formulas(graph: Graph) -> FacetFormulas:
    """Return the facet at a node of a `Lune`: a row is a latitude, and an input is a longitude at an epoch."""
    cosine, sine, weight = columns = [graph.symbol(name) for name in ("cosine", "sine", "area")]
    inputs = [graph.symbol(k) for k in range(8)]
    vector = [cosine * a + sine * b for a, b in zip(inputs[:3], inputs[3:6], strict=True)]
    size = norm(vector)
    shared = cosine / size
    return FacetFormulas(
        columns, inputs, [x / size for x in vector], weight * size, shared * inputs[6], shared * inputs[7]
    )


LONGITUDES_OF_BLOCK = 100_000
"""Number of longitudes at all epochs of a call of compiled sums."""

NODES_OF_BLOCK = 16_384
"""Number of nodes at all epochs of a block."""

EDGE = 1e-9
"""Smallest half width of a lune, in radians; the light of a narrower one is below 1e-27."""


def _unit(vectors: Array, otherwise: Array) -> Array:
    """Return unit vectors (3, epochs), or others where a vector is zero."""
    lengths = np.linalg.norm(vectors, axis=0)
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), otherwise)


def _perpendicular(vectors: Array) -> Array:
    """Return unit vectors perpendicular to unit vectors (3, epochs)."""
    axis = np.eye(3)[np.argmin(np.abs(vectors), axis=0)].T
    across = np.cross(vectors, axis, axis=0)
    return np.asarray(across / np.linalg.norm(across, axis=0))
