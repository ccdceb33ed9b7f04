"""Sums of reflected light over facets, with derivatives; the facets of meshes and plates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot.shapes.law_program import LawFormula
from poinsot.shapes.mesh import Mesh
from poinsot.taylor.graph import Number, Primitive

__all__ = ["BLOCK", "Block", "LightOfPlates", "Plates", "ReflectedLight", "Shares"]

Array = NDArray[np.float64]

BLOCK = 16_384
"""Number of facets at all epochs of a block, so that the buffers of a block stay in the cache."""


class Plates(Protocol):
    """Flat one-sided plates of areas (n,) with unit normals (n, 3) along the body axes."""

    @property
    def areas(self) -> Any:
        """Areas of the plates."""

    @property
    def normals(self) -> Any:
        """Unit normals of the plates."""


class Block(ABC):
    """Facets that are lit and seen at consecutive epochs, one after the other.

    Attributes
    ----------
    epochs : slice
        Numbers of the epochs.
    counts : int or array of int
        Number of facets of each epoch.
    mu0, mu : array (n,)
        Cosines of incidence and emission of all facets of all epochs.
    """

    epochs: slice
    counts: int | NDArray[np.int_]
    mu0: Array
    mu: Array

    @abstractmethod
    def sums(self, values: Array | float, power: int) -> Array:
        """Return the sum over the facets of each epoch of A v (power 0), A v n (1) or A v n_k^2 (2).

        The axis of components, of length 1 or 3, is first.
        """

    def slopes(self, values: Array | float) -> Array | float:  # noqa: ARG002
        """Return the derivatives of the sum of A v at each epoch by the vectors, through the clear shares of facets."""
        return 0.0


class Shares(ABC):
    """Clear shares of facets, of which other facets hide the rest.

    Attributes
    ----------
    values : array (epochs, facets)
        Shares from 0 to 1.
    """

    values: Array

    @abstractmethod
    def slopes(self, weights: Array) -> Array:
        """Return the derivatives of the sum of shares times weights by the vectors, shape (vectors, epochs)."""


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
    def blocks(self, vectors: Array, stretch: Array, buffers: int) -> Iterator[tuple[Block, Sequence[Array]]]:
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
        others = {k: k - last - 1 for k in numbers if k > last + 3}  # outputs of the formula
        outputs = (0, *((1, 2) if by_vectors else ()), *others.values())
        program = self.formula.program(outputs)
        columns = self.formula.columns(program, *scalars)
        sums = np.empty((max((last + 3, *numbers)) + 1, vectors.shape[1]))
        for block, buffers in self.blocks(vectors, stretch, program.buffers):
            part, mu0, mu = block.epochs, block.mu0, block.mu
            own = [np.repeat(x[part], block.counts) if np.ndim(x) else x for x in columns]
            found = dict(zip(outputs, program(mu0, mu, own, buffers), strict=True))
            sums[:1, part] = block.sums(found[0], 0)
            if by_vectors:
                sums[7 : last + 1, part] = 0.0
                sums[1:4, part], sums[4:7, part] = block.sums(found[1], 1), block.sums(found[2], 1)
                sums[1 : last + 1, part] += block.slopes(found[0])
            if by_stretch:
                products = vectors[:, part] * sums[1 : last + 1, part]
                matrix = products[9:].reshape(-1, 3, products.shape[1])
                change = block.sums(found[0] - mu0 * found[1] - mu * found[2], 2)
                change += products[:9].reshape(-1, 3, products.shape[1]).sum(axis=0)
                change += matrix.sum(axis=1) - matrix.sum(axis=0) if len(matrix) else 0.0
                sums[last + 1 : last + 4, part] = (sums[:1, part] - change) / stretch[:, None]
            for k, output in others.items():
                sums[k : k + 1, part] = block.sums(found[output], 0)
        return {k: sums[k] for k in numbers}


def _groups(stretch: Sequence[Any], epochs: int) -> Iterator[tuple[Any, Array]]:
    """Yield the epochs of each different stretch, and the stretch."""
    if not any(map(np.ndim, stretch)):
        yield slice(None), np.array(stretch, dtype=float)
        return
    rows = np.stack([np.broadcast_to(x, epochs) for x in stretch], axis=1)
    each, inverse = np.unique(rows, axis=0, return_inverse=True)
    for k, factors in enumerate(each):
        yield np.flatnonzero(inverse.ravel() == k), factors


class LightOfPlates(ReflectedLight):
    """Light of flat one-sided facets."""

    def __init__(self, shape: Mesh | Plates, formula: LawFormula) -> None:
        super().__init__(formula)
        if isinstance(shape, Mesh):
            self._areas, self._normals = shape.face_areas, np.nan_to_num(shape.face_normals)
        else:
            self._areas, self._normals = np.asarray(shape.areas), np.asarray(shape.normals)

    @override
    def blocks(self, vectors: Array, stretch: Array, buffers: int) -> Iterator[tuple[Block, Sequence[Array]]]:
        images = self._normals / stretch
        lengths = np.linalg.norm(images, axis=1, keepdims=True)
        normals = np.divide(images, lengths, out=np.zeros_like(images), where=lengths > 0)
        areas = self._areas[:, None] * lengths * np.prod(stretch)
        weights = [areas, areas * normals, areas * normals * normals]
        epochs, count = vectors.shape[1], len(areas)
        rows = max(1, min(epochs, BLOCK // max(count, 1)))
        space = np.empty((buffers + 5, rows, count))
        for start in range(0, epochs, rows):
            part = slice(start, min(start + rows, epochs))
            (mu0, mu, dense), chosen = space[:3, : part.stop - start], space[3:5]
            np.matmul(vectors[:3, part].T, normals.T, out=mu0)
            np.matmul(vectors[3:6, part].T, normals.T, out=mu)
            block = BlockOfPlates(part, mu0, mu, dense, chosen, weights, self.shares(vectors[:, part], stretch))
            yield block, [x.reshape(-1)[: block.mu0.size] for x in space[5:]]

    def shares(self, vectors: Array, stretch: Array) -> Shares | None:  # noqa: ARG002
        """Return the clear shares of the facets, or None if no facet hides another."""
        return None


class BlockOfPlates(Block):
    """Plates that are lit and seen, chosen from all plates of some epochs."""

    def __init__(
        self,
        epochs: slice,
        mu0: Array,
        mu: Array,
        dense: Array,
        chosen: Array,
        weights: Sequence[Array],
        shares: Shares | None,
    ) -> None:
        self.epochs, self._dense, self._weights, self._shares = epochs, dense, weights, shares
        active = np.minimum(mu0, mu, out=dense) > 0
        if shares is not None:
            active &= shares.values > 0
        self.counts, self._places = np.count_nonzero(active, axis=1), np.flatnonzero(active)
        self.mu0, self.mu = (
            np.take(x, self._places, out=out.reshape(-1)[: self._places.size], mode="clip")
            for x, out in zip((mu0, mu), chosen, strict=True)
        )

    @override
    def sums(self, values: Array | float, power: int) -> Array:
        self._spread(values)
        if self._shares is not None:
            self._dense *= self._shares.values
        return np.asarray((self._dense @ self._weights[power]).T)

    @override
    def slopes(self, values: Array | float) -> Array | float:
        if self._shares is None:
            return 0.0
        self._spread(values)
        return self._shares.slopes(self._dense * self._weights[0][:, 0])

    def _spread(self, values: Array | float) -> None:
        self._dense.fill(0.0)
        self._dense.reshape(-1)[self._places] = values
