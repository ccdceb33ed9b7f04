"""Sums of reflected light over facets, with derivatives; the facets of meshes and plates."""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.functions import dot
from poinsot.shapes.law_program import FacetFormulas, LawFormula, Wanted
from poinsot.shapes.mesh import Mesh
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Neighbour
from poinsot.shapes.visibility import clear_faces, clear_parts
from poinsot.taylor.compiled_sums import CompiledSums
from poinsot.taylor.graph import Graph, Number, Primitive

__all__ = [
    "MIN_COMPILED",
    "FacetBlock",
    "LightOfPlates",
    "LightOfShadedMesh",
    "Plates",
    "ReflectedLight",
    "Sums",
]

Array = NDArray[np.float64]

BLOCK = 65_536
"""Number of facets at all epochs of a block, so that the buffers of a block stay in the cache."""


class Workspace(threading.local):
    """Memory of one thread for the arrays of a block, which later calls use again."""

    def __init__(self) -> None:
        self._memory = np.empty(0)

    def array(self, *shape: int) -> Array:
        """Return an array of any content, valid until the next call in this thread."""
        size = math.prod(shape)
        if size > self._memory.size:
            self._memory = np.empty(size)
        return self._memory[:size].reshape(shape)


WORKSPACE = Workspace()


class Plates(Protocol):
    """Flat one-sided plates of areas (n,) with unit normals (n, 3) along the body axes."""

    def __hash__(self) -> int: ...

    @property
    def areas(self) -> Any:
        """Areas of the plates."""

    @property
    def normals(self) -> Any:
        """Unit normals of the plates."""


class FacetBlock(ABC):
    """Facets that are lit and seen at consecutive epochs, one after the other.

    Attributes
    ----------
    epochs : slice
        Numbers of the epochs.
    mu0, mu : array (n,)
        Cosines of incidence and emission of all facets of all epochs.
    """

    epochs: slice
    mu0: Array
    mu: Array

    @property
    @abstractmethod
    def counts(self) -> int | NDArray[np.int_]:
        """Number of facets of each epoch."""

    @abstractmethod
    def sums(self, values: Array | float, power: int) -> Array:
        """Return the sum over the facets of each epoch of A v (power 0), A v n (1) or A v n_k^2 (2).

        The axis of components, of length 1 or 3, is first.
        """

    def sums_of_shadows(self, values: Array | float) -> Array | float:  # noqa: ARG002
        """Return the sum of v dA by the vectors, (6 + placed, epochs), of areas that change with shadows."""
        return 0.0


class Sums(NamedTuple):
    """Sums over the facets at each epoch.

    Attributes
    ----------
    value : array (epochs,)
        Sum of A S.
    gradient : array (6 + placed, epochs)
        Derivatives by the vectors; empty if they are not wanted.
    squares : array (3, epochs)
        Sum of A n_k^2 (S - mu0 S_mu0 - mu S_mu); empty if it is not wanted.
    others : array (n, epochs)
        Sums of other outputs of the formula.
    """

    value: Array
    gradient: Array
    squares: Array
    others: Array

    @staticmethod
    def of(wanted: Wanted, found: Array) -> Sums:
        """Return the sums that `LawFormula.compiled_sums` computes, (outputs, epochs)."""
        gradient, squares = 6 * wanted.by_vectors, 3 * wanted.by_stretch
        return Sums(found[0], *np.split(found[1:], [gradient, gradient + squares]))


class ReflectedLight(Primitive):
    """Sum of A S over facets that face the Sun and the observer, with its derivatives.

    The facets may be the nodes of a quadrature over a smooth surface. The variables are the unit vectors s and e, the
    position r and the matrix M, by rows, of a second body that may hide facets, the stretch, the phase angle, and the
    numbers of the law that do not multiply S. The phase angle is a variable of its own: derivatives with respect to s
    and e are taken at fixed phase.

    Under a stretch D the normals are D^-1 n / |D^-1 n| and the areas A det D |D^-1 n|, so that dB/dD_k = (B - sum of
    A n_k^2 (S - mu0 S_mu0 - mu S_mu) - s_k G_k - e_k H_k - r_k R_k + sum_i (M_ik P_ik - M_ki P_ki)) / D_k with the
    gradients G, H, R and P by s, e, r and M.

    Attributes
    ----------
    placed : int
        Number of the variables r and M: 12 if there is a second body, otherwise 0.
    """

    placed = 0

    def __init__(self, formula: LawFormula) -> None:
        self.formula = formula

    @abstractmethod
    def blocks(self, vectors: Array, stretch: Array, buffers: int) -> Iterator[tuple[FacetBlock, Sequence[Array]]]:
        """Yield blocks of epochs, with buffers for their facets, for vectors (6 + placed, epochs) and one stretch."""

    @override
    def entries(self, numbers: Sequence[int], *variables: Number) -> Mapping[int, Number]:
        arrays = np.broadcast_arrays(*variables)
        shape = arrays[0].shape
        count = 6 + self.placed
        vectors = np.stack([x.ravel() for x in arrays[:count]])
        others = [x.ravel() if np.ndim(own) else own for x, own in zip(arrays[count:], variables[count:], strict=True)]
        stretch, scalars = others[:3], others[3:]
        found = {k: np.empty(vectors.shape[1]) for k in numbers}
        with np.errstate(all="ignore"):
            for epochs, factors in _groups(stretch, vectors.shape[1]):
                chosen = [x[epochs] if isinstance(x, np.ndarray) and x.ndim else x for x in scalars]
                for k, values in self._summed(numbers, vectors[:, epochs], factors, chosen).items():
                    found[k][epochs] = values
        return {k: values.reshape(shape)[()] for k, values in found.items()}

    def _summed(
        self, numbers: Sequence[int], vectors: Array, stretch: Array, scalars: Sequence[Any]
    ) -> dict[int, Array]:
        """Return the entries for vectors (6 + placed, epochs) and one stretch.

        Entry 0 is the value. The derivatives by the vectors, by the stretch and by all other numbers follow.
        """
        last = 6 + self.placed
        by_stretch = any(last < k <= last + 3 for k in numbers)
        by_vectors = by_stretch or any(0 < k <= last for k in numbers)
        others = tuple(k - last - 1 for k in numbers if k > last + 3)
        value, gradient, squares, rest = self.sums(Wanted(by_vectors, by_stretch, others), vectors, stretch, scalars)
        found = {0: value} | dict(enumerate(gradient, 1)) | {k + last + 1: x for k, x in zip(others, rest, strict=True)}
        if by_stretch:
            products = (vectors * gradient).reshape(-1, 3, len(value))
            change = squares + products[:3].sum(axis=0)
            if self.placed:
                change += products[3:].sum(axis=1) - products[3:].sum(axis=0)
            found |= dict(enumerate((value - change) / stretch[:, None], last + 1))
        return {k: found[k] for k in numbers}

    def sums(self, wanted: Wanted, vectors: Array, stretch: Array, scalars: Sequence[Any]) -> Sums:
        """Return the sums over the facets for vectors (6 + placed, epochs), one stretch, and phase and numbers."""
        outputs = (0, *((1, 2) if wanted.by_vectors else ()), *wanted.others)
        program = self.formula.program(outputs)
        columns = self.formula.columns(program, *scalars)
        epochs = vectors.shape[1]
        value, rest = np.zeros(epochs), np.zeros((len(wanted.others), epochs))
        gradient = np.zeros((len(vectors) * wanted.by_vectors, epochs))
        squares = np.zeros((3 * wanted.by_stretch, epochs))
        for block, buffers in self.blocks(vectors, stretch, program.buffers):
            part, mu0, mu = block.epochs, block.mu0, block.mu
            own = [np.repeat(x[part], block.counts) if np.ndim(x) else x for x in columns]
            found = dict(zip(outputs, program(mu0, mu, own, buffers), strict=True))
            (value[part],) = block.sums(found[0], 0)
            if wanted.by_vectors:
                gradient[:3, part], gradient[3:6, part] = block.sums(found[1], 1), block.sums(found[2], 1)
                gradient[:, part] += block.sums_of_shadows(found[0])
            if wanted.by_stretch:
                squares[:, part] = block.sums(found[0] - mu0 * found[1] - mu * found[2], 2)
            for k, output in enumerate(wanted.others):
                (rest[k, part],) = block.sums(found[output], 0)
        return Sums(value, gradient, squares, rest)


def _groups(stretch: Sequence[Any], epochs: int) -> Iterator[tuple[Any, Array]]:
    """Yield the epochs of each different stretch, and the stretch."""
    if not any(map(np.ndim, stretch)):
        yield slice(None), np.array(stretch, dtype=float)
        return
    rows = np.stack([np.broadcast_to(x, epochs) for x in stretch], axis=1)
    each, inverse = np.unique(rows, axis=0, return_inverse=True)
    for k, factors in enumerate(each):
        yield np.flatnonzero(inverse.ravel() == k), factors


class StretchedPlates(NamedTuple):
    """Plates under a stretch.

    Attributes
    ----------
    stretch : array (3,)
    normals : array (n, 3)
        Unit normals.
    scales : array (n,)
        Areas over the areas without a stretch.
    weights : list of arrays (n, 1 or 3)
        Areas times the powers 0, 1 and 2 of the normals.
    table : array (4, at least n)
        Components of the normals, and areas, for compiled sums.
    """

    stretch: Array
    normals: Array
    scales: Array
    weights: list[Array]
    table: Array


class LightOfPlates(ReflectedLight):
    """Light of flat one-sided facets that do not shadow each other."""

    def __init__(self, shape: Mesh | Plates, formula: LawFormula) -> None:
        super().__init__(formula)
        if isinstance(shape, Mesh):
            self._areas, self._normals = shape.face_areas, np.nan_to_num(shape.face_normals)
        else:
            self._areas, self._normals = np.asarray(shape.areas), np.asarray(shape.normals)
        self._last = self._stretched(np.ones(3))

    def _stretched(self, stretch: Array) -> StretchedPlates:
        images = self._normals / stretch
        lengths = np.linalg.norm(images, axis=1, keepdims=True)
        normals, scales = images / np.where(lengths > 0, lengths, 1.0), lengths * np.prod(stretch)
        areas = self._areas[:, None] * scales
        weights = [np.asfortranarray(x) for x in (areas, areas * normals, areas * normals * normals)]
        table = CompiledSums.table(np.concatenate([normals, areas], axis=1).T)
        return StretchedPlates(stretch, normals, scales[:, 0], weights, table)

    def _plates(self, stretch: Array) -> StretchedPlates:
        plates = self._last
        if not np.array_equal(plates.stretch, stretch):
            plates = self._last = self._stretched(stretch)
        return plates

    @override
    def sums(self, wanted: Wanted, vectors: Array, stretch: Array, scalars: Sequence[Any]) -> Sums:
        epochs = vectors.shape[1]
        compiled = (
            self.formula.compiled_sums(wanted, plate_formulas) if epochs * len(self._areas) >= MIN_COMPILED else None
        )
        if compiled is None:
            return super().sums(wanted, vectors, stretch, scalars)
        inputs = [*vectors, *(np.broadcast_to(x, epochs) for x in scalars)]
        return Sums.of(wanted, compiled(self._plates(stretch).table, np.stack(inputs)))

    @override
    def blocks(self, vectors: Array, stretch: Array, buffers: int) -> Iterator[tuple[FacetBlock, Sequence[Array]]]:
        _, normals, scales, weights, _ = self._plates(stretch)
        epochs, count = vectors.shape[1], len(normals)
        rows = max(1, min(epochs, BLOCK // max(count, 1)))
        space = WORKSPACE.array(buffers + 5, rows, count)
        for start in range(0, epochs, rows):
            part = slice(start, min(start + rows, epochs))
            (mu0, mu, dense), chosen = space[:3, : part.stop - start], space[3:5]
            np.matmul(vectors[:3, part].T, normals.T, out=mu0)
            np.matmul(vectors[3:6, part].T, normals.T, out=mu)
            shading = self._shading(vectors[:, part], stretch, scales)
            block = BlockOfPlates(part, mu0, mu, dense, chosen, weights, shading)
            yield block, [x.reshape(-1)[: block.mu0.size] for x in space[5:]]

    def _shading(self, vectors: Array, stretch: Array, scales: Array) -> Shading | None:  # noqa: ARG002
        """Return the clear shares of the facets, with their scales under the stretch; None if all are clear."""
        return None


def plate_formulas(graph: Graph) -> FacetFormulas:
    """Return a facet with the components of its normal and its area as a row, and the vectors s and e as inputs."""
    *normal, area = columns = [graph.symbol(name) for name in ("x", "y", "z", "area")]
    inputs = [graph.symbol(k) for k in range(6)]
    return FacetFormulas(columns, inputs, normal, area, dot(normal, inputs[:3]), dot(normal, inputs[3:]))


MIN_COMPILED = 200_000
"""Number of facets at all epochs from which a call is compiled; NumPy takes about a millisecond for fewer."""


class LightOfShadedMesh(LightOfPlates):
    """Light of a mesh whose faces shadow and hide each other, and which a second mesh may shadow and hide.

    Parallel light stays parallel under a stretch D: the clear share of each face is the clear share of the face of the
    unstretched mesh for the directions D^-1 s and D^-1 e. The second mesh, at x -> M x + r under the same stretch, is
    then at x -> D^-1 M D x + D^-1 r.
    """

    def __init__(self, shape: Mesh, formula: LawFormula, exact: bool, other: Mesh | None = None) -> None:
        super().__init__(shape, formula)
        self._surface, self._exact = Surface(shape), exact
        self._other = None if other is None else Surface(other)
        if other is not None:
            self.placed = 12

    @override
    def sums(self, wanted: Wanted, vectors: Array, stretch: Array, scalars: Sequence[Any]) -> Sums:
        return ReflectedLight.sums(self, wanted, vectors, stretch, scalars)

    @override
    def _shading(self, vectors: Array, stretch: Array, scales: Array) -> Shading | None:
        if self._other is None:
            if not self._surface.below.any():
                return None  # a convex mesh
            return Shading(self._surface, vectors, stretch, scales, self._exact, None)
        matrices = vectors[9:].T.reshape(-1, 3, 3) * (stretch / stretch[:, None])
        neighbour = Neighbour(self._other, vectors[6:9].T / stretch, matrices)
        return Shading(self._surface, vectors, stretch, scales, self._exact, neighbour)


class Shading:
    """Clear shares of the faces of a mesh, neither shaded nor hidden, at some epochs.

    Attributes
    ----------
    shares : array (epochs, faces)
        Clear area over the whole area.
    """

    def __init__(
        self,
        surface: Surface,
        vectors: Array,
        stretch: Array,
        scales: Array,
        exact: bool,
        neighbour: Neighbour | None,
    ) -> None:
        self._stretch, self._scales, self._neighbour = stretch, scales, neighbour
        images = [vectors[:3].T / stretch, vectors[3:6].T / stretch]
        self._lengths = [np.linalg.norm(image, axis=1, keepdims=True) for image in images]
        self._units = [image / length for image, length in zip(images, self._lengths, strict=True)]
        self._parts = clear_parts(surface, self._units, neighbour) if exact else None
        if self._parts is None:
            self.shares = clear_faces(surface, self._units, neighbour).astype(float)
        else:
            self.shares = self._parts.areas / np.where(surface.areas > 0, surface.areas, 1.0)

    def slopes(self, values: Array) -> Array:
        """Return the derivatives of the sum of clear areas times values by the vectors, (6 + placed, epochs)."""
        if self._parts is None:
            raise ValueError('shadows must be "exact" for derivatives, got "centroids", which jump.')
        found, stretch = self._parts.slopes(values * self._scales), self._stretch
        slopes = [slope / (length * stretch) for slope, length in zip(found.directions, self._lengths, strict=True)]
        if self._neighbour is not None:
            matrices = found.matrix * (stretch / stretch[:, None])
            slopes += [found.position / stretch, matrices.reshape(-1, 9)]
        return np.concatenate(slopes, axis=1).T


class BlockOfPlates(FacetBlock):
    """Plates that are lit and seen, chosen from all plates of some epochs."""

    def __init__(
        self,
        epochs: slice,
        mu0: Array,
        mu: Array,
        dense: Array,
        chosen: Array,
        weights: Sequence[Array],
        shading: Shading | None,
    ) -> None:
        self.epochs, self._dense, self._weights, self._shading = epochs, dense, weights, shading
        active = np.minimum(mu0, mu, out=dense) > 0
        if shading is not None:
            active &= shading.shares > 0
        self._places = np.flatnonzero(active)
        self.mu0, self.mu = (
            np.take(x, self._places, out=out.reshape(-1)[: self._places.size], mode="clip")
            for x, out in zip((mu0, mu), chosen, strict=True)
        )
        dense.fill(0.0)

    @property
    @override
    def counts(self) -> NDArray[np.int_]:
        rows, count = self._dense.shape
        ends = np.searchsorted(self._places, np.arange(rows + 1) * count)
        return np.asarray(np.diff(ends))

    @override
    def sums(self, values: Array | float, power: int) -> Array:
        self._dense.reshape(-1)[self._places] = values
        if self._shading is not None:
            self._dense *= self._shading.shares
        return np.asarray((self._dense @ self._weights[power]).T)

    @override
    def sums_of_shadows(self, values: Array | float) -> Array | float:
        if self._shading is None:
            return 0.0
        self._dense.reshape(-1)[self._places] = values
        return self._shading.slopes(self._dense)
