"""Faces of surfaces along the directions to the light and to the observer, and the shadows of the faces."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from poinsot.shapes.boxes import Boxes, ranges
from poinsot.shapes.clipping import inside, lines_of, positive, turn, uncovered
from poinsot.shapes.surface import Surface, bases_of

__all__ = ["Boundary", "Neighbour", "Scene", "ray_hits"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]


class Neighbour(NamedTuple):
    """Another body that casts shadows and hides faces, and its place x -> matrix x + position at each epoch.

    Attributes
    ----------
    surface : Surface
    positions : array (n, 3)
        Centre of mass of the neighbour from the centre of mass of the body, along the axes of the body.
    matrices : array (n, 3, 3)
        Matrices of positive determinant from the axes of the neighbour to the axes of the body: rotation matrices, or
        these with a stretch.
    """

    surface: Surface
    positions: Array
    matrices: Array


class _Edges(NamedTuple):
    """Edges of faces and edges of shadows in the planes of the faces. The last axis of each array is the edge.

    Attributes
    ----------
    cells : array (n,)
        Index of the epoch and face in a list.
    others, views : array (n,)
        Face that casts the shadow, and index of the direction along which it falls; -1 for an edge of the face.
    starts, spans : array (2, n)
        Start and vector of the edge, from the centroid of the face. The face or the shadow is on its left.
    lifts : array (2, n)
        Height of the place that casts the shadow at the start, over the cosine of the direction, and its change along
        the edge.
    turns : array (3, n)
        Derivative of the clear area by the place that casts the shadow, if all of the edge is a boundary.
    places : array (2, 3, n)
        Place that casts the shadow at the start, and its change along the edge.
    """

    cells: Integers
    others: Integers
    views: Integers
    starts: Array
    spans: Array
    lifts: Array
    turns: Array
    places: Array


class Boundary(NamedTuple):
    """Edges of which parts bound the clear parts of faces. The last axis of each array is the edge.

    Attributes
    ----------
    rows, faces : array (n,)
        Epoch and face.
    edges : _Edges
    lengths, moments : array (n,)
        Integrals of 1 and of the parameter, which is from 0 to 1 along the edge, over the parts.
    """

    rows: Integers
    faces: Integers
    edges: _Edges
    lengths: Array
    moments: Array


class _Covers(NamedTuple):
    """Shadows of single faces in the planes of faces. The last axis of each array is the shadow.

    Attributes
    ----------
    cells, others, views : array (n,)
        Index of the epoch and face in a list, face that casts the shadow, and index of the direction.
    lines : array (4, 3, n)
        Factors of x, y and 1 in the distances from the three edges, and from the line in which the other face cuts the
        plane. All distances are positive in the shadow.
    tolerances : array (n,)
        Rounding error of the distances.
    """

    cells: Integers
    others: Integers
    views: Integers
    lines: Array
    tolerances: Array


class Scene:
    """Faces of a surface at the epochs of one block, and a neighbour whose faces follow them in all lists."""

    def __init__(self, surface: Surface, directions: Sequence[Array], neighbour: Neighbour | None, part: slice) -> None:
        self.surface = surface
        self.vertices, self.faces, self.edges = surface.vertices[None], surface.faces, surface.edges
        self.sides, self.convex = surface.sides, surface.convex
        units = [direction[part] for direction in directions]
        fronts = [unit @ surface.normals.T > 0 for unit in units]
        self.facing = np.logical_and.reduce(fronts)
        exposed = self.facing & surface.below
        if neighbour is not None:
            neighbour = Neighbour(neighbour.surface, neighbour.positions[part], neighbour.matrices[part])
            near = _overlap(surface, neighbour, units)
            exposed[near] = self.facing[near]
            if near.any():
                self._add(neighbour)
                for k, unit in enumerate(units):
                    inner = np.einsum("nij,nj->ni", np.linalg.inv(neighbour.matrices), unit)
                    fronts[k] = np.concatenate([fronts[k], inner @ neighbour.surface.normals.T > 0], axis=1)
        self.exposed = np.nonzero(exposed)
        """Epochs and faces of the faces that other faces may hide."""
        self.views = [_Projection(self, k, *each) for k, each in enumerate(zip(units, fronts, strict=True))]

    def _add(self, neighbour: Neighbour) -> None:
        """Add the vertices, faces and edges of a neighbour."""
        own, other = self.surface, neighbour.surface
        places = other.vertices @ neighbour.matrices.transpose(0, 2, 1) + neighbour.positions[:, None]
        self.vertices = np.concatenate(
            [np.broadcast_to(own.vertices, (len(places), *own.vertices.shape)), places], axis=1
        )
        self.faces = np.concatenate([own.faces, other.faces + len(own.vertices)])
        self.edges = np.concatenate([own.edges, other.edges + len(own.vertices)])
        self.sides = np.concatenate([own.sides, other.sides + len(own.faces)])
        self.convex = np.concatenate([own.convex, other.convex])

    def take(self, rows: Integers, indices: Integers) -> Array:
        """Return vertices (3, n) for pairs of an epoch and a number."""
        count = self.vertices.shape[1]
        return self.vertices.reshape(-1, 3)[indices if len(self.vertices) == 1 else rows * count + indices].T

    def parts(self) -> tuple[Array, Boundary]:
        """Return the clear areas (n, faces), and the boundaries in the faces that edges of shadows cross."""
        areas = np.where(self.facing, self.surface.areas, 0.0)
        rows, faces = self.exposed
        crossed = np.zeros((len(self.views), len(rows)), dtype=bool)
        hidden, shadows = np.zeros(len(rows), dtype=bool), []
        for view, here in zip(self.views, crossed, strict=True):
            shadows.append(view.shadows(rows, faces))
            here[shadows[-1].cells] = True
            whole = np.flatnonzero(~here)  # its centroid decides for the face
            hidden[whole[view.hides(rows[whole], faces[whole])]] = True
        areas[rows[hidden], faces[hidden]] = 0.0
        cells = np.flatnonzero(crossed.any(axis=0) & ~hidden)
        rows, faces = rows[cells], faces[cells]
        number = np.full(len(hidden), -1)
        number[cells] = np.arange(len(cells))
        edges, covers = [self._edges_of_faces(faces)], []
        for view, found, here in zip(self.views, shadows, crossed, strict=True):
            edges.append(_chosen(found._replace(cells=number[found.cells]), number[found.cells] >= 0))
            covers.append(view.covers(rows, faces, number[cells[here[cells]]]))
        return self._clipped(areas, rows, faces, _joined(edges), _joined(covers))

    def _clipped(
        self, areas: Array, rows: Integers, faces: Integers, edges: _Edges, covers: _Covers
    ) -> tuple[Array, Boundary]:
        """Return areas, with the clear areas of some faces from the edges that bound them, and the boundaries."""
        lengths, moments = self._bounding(edges, covers)
        turns = np.where(edges.views < 0, 0.5, -0.5) * turn(edges.starts, edges.spans)
        sums = np.bincount(edges.cells, turns * lengths, len(rows))
        areas[rows, faces] = np.clip(sums, 0.0, self.surface.areas[faces])
        return areas, Boundary(rows[edges.cells], faces[edges.cells], edges, lengths, moments)

    def _edges_of_faces(self, faces: Integers) -> _Edges:
        """Return the edges of faces."""
        corners, count = self.surface.flat_corners[:, :, faces], len(faces)
        starts, ends = (np.concatenate(array, axis=-1) for array in (corners, np.roll(corners, -1, axis=0)))
        cells, own = np.tile(np.arange(count), 3), np.tile(faces, 3)
        n = 3 * count
        none = np.zeros((2, n)), np.zeros((3, n)), np.zeros((2, 3, n))
        return _Edges(cells, own, np.full(n, -1), starts, ends - starts, *none)

    def _bounding(self, edges: _Edges, covers: _Covers) -> tuple[Array, Array]:
        """Return the integrals of 1 and of the parameter over the parts of edges that bound clear parts of faces.

        An edge of a face counts where no shadow is on its left, an edge of a shadow where no other shadow is on its
        right. Of several edges of shadows at one place, with the shadows on the same side, the first one counts.
        """
        order, faces = np.argsort(covers.cells, kind="stable"), len(self.faces)
        cells = covers.cells[order]
        first, last = (np.searchsorted(cells, edges.cells, side) for side in ("left", "right"))
        edge, cover = np.repeat(np.arange(len(edges.cells)), last - first), order[ranges(first, last)]
        lines, spans, own = covers.lines[..., cover], edges.spans[:, edge], edges.views[edge] < 0
        along = lines[:, 1] * spans[0] > lines[:, 0] * spans[1]
        earlier = (covers.views * faces + covers.others)[cover] < (edges.views * faces + edges.others)[edge]
        on_lines = np.where(own, along, ~along | earlier)
        begin, end = inside(lines, edges.starts[:, edge], spans, covers.tolerances[cover], on_lines)
        some = end > begin
        return uncovered(len(edges.cells), edge[some], begin[some], end[some])


class _Projection:
    """Faces of a scene along one direction."""

    def __init__(self, scene: Scene, index: int, directions: Array, front: Flags) -> None:
        self.scene, self.index, self.directions, self.front = scene, index, directions, front

    @cached_property
    def axes(self) -> Array:
        """Axes of the views (n, 3, 3), of which the third one is the direction."""
        return np.concatenate([bases_of(self.directions), self.directions[:, None]], axis=1)

    @cached_property
    def places(self) -> Array:
        """Vertices along the axes of the views, shape (n, vertices, 3)."""
        return np.asarray(self.scene.vertices @ self.axes.transpose(0, 2, 1))

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """Lowest and highest coordinates of the faces along the axes of the views, shape (n, faces, 3)."""
        one, two, three = (self.places[:, corner] for corner in self.scene.faces.T)
        return np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)

    @cached_property
    def bright(self) -> tuple[Integers, Boxes]:
        """Numbers of the faces that are oriented towards the direction, and their boxes."""
        rows, faces = np.nonzero(self.front)
        return faces, self._sorted(rows, *(edge[rows, faces] for edge in self.boxes))

    def _sorted(self, rows: Integers, low: Array, high: Array) -> Boxes:
        return Boxes(rows, low, high, self.scene.surface.radius)

    def hides(self, rows: Integers, faces: Integers) -> Flags:
        """Return True where another face hides the centroid of a face."""
        centers = self.scene.surface.centers[faces]
        places = np.einsum("pij,pj->pi", self.axes[rows], centers)
        cell, which = self.bright[1].overlapping(rows, places, places)
        other = self.bright[0][which]
        cell, other = cell[other != faces[cell]], other[other != faces[cell]]
        corners = np.stack([self.scene.take(rows[cell], k) for k in self.scene.faces[other].T]).transpose(2, 0, 1)
        hidden = np.zeros(len(rows), dtype=bool)
        hidden[cell[ray_hits(self.directions[rows[cell]], corners - centers[cell, None])]] = True
        return hidden

    def shadows(self, rows: Integers, faces: Integers) -> _Edges:
        """Return the edges of shadows that cross faces, clipped to the faces."""
        surface = self.scene.surface
        frames, cosines, centers = self._frames(rows, faces)
        cell, others, places = self._outlines(rows, faces)
        starts, ends = (_along(frames[..., cell], place - centers[:, cell]) for place in places)
        rising = self._rising(rows, faces, cell, others, np.stack([starts[2], ends[2]]), places)
        cell, others, places = cell[rising], others[rising], places[..., rising]
        starts, ends = starts[:, rising], ends[:, rising]
        cut_cell, cut_others, cuts = self._cuts(rows, faces)
        cell, others = np.concatenate([cell, cut_cell]), np.concatenate([others, cut_others])
        places = np.concatenate([places, np.zeros((2, 3, len(cut_cell)))], axis=-1)
        starts, ends = np.concatenate([[starts, ends], cuts], axis=-1)
        spans, reaches = ends - starts, places[1] - places[0]
        begin, end = inside(surface.lines[..., faces[cell]], starts[:2], spans[:2], surface.low / cosines[cell])
        above = positive(*(np.where(np.abs(tip[2]) > surface.low, tip[2], 0.0) for tip in (starts, ends)))
        begin, end = np.maximum(begin, above[0]), np.minimum(end, above[1])
        some = np.flatnonzero(end > begin)
        cell, begin, share = cell[some], begin[some], (end - begin)[some]
        starts, spans = starts[:, some] + begin * spans[:, some], share * spans[:, some]
        return _Edges(
            cells=cell,
            others=others[some],
            views=np.full(len(some), self.index),
            starts=starts[:2],
            spans=spans[:2],
            lifts=np.stack([starts[2], spans[2]]) / cosines[cell],
            turns=spans[0] * frames[1][:, cell] - spans[1] * frames[0][:, cell],
            places=np.stack([places[0][:, some] + begin * reaches[:, some], share * reaches[:, some]]),
        )

    def _outlines(self, rows: Integers, faces: Integers) -> tuple[Integers, Integers, Array]:
        """Return edges between bright and dark faces whose shadows may cross faces.

        The result is the index of the face in the list, the bright face at the edge, and both ends (2, 3, n), with
        the bright face on the left.
        """
        scene = self.scene
        bright = self.front[:, scene.sides]
        row, edge = np.nonzero((bright[..., 0] != bright[..., 1]) & scene.convex)
        side = bright[row, edge, 1].astype(np.int64)
        ends = scene.edges[edge, side], scene.edges[edge, 1 - side]
        views = self.places[row, ends[0]], self.places[row, ends[1]]
        boxes = self._sorted(row, np.minimum(*views), np.maximum(*views))
        cell, which = boxes.overlapping(rows, *(edge[rows, faces] for edge in self.boxes))
        apart = (scene.sides[edge[which]] != faces[cell, None]).all(axis=1)
        cell, which = cell[apart], which[apart]
        places = np.stack([scene.take(row[which], end[which]) for end in ends])
        return cell, scene.sides[edge[which], side[which]], places

    def _rising(
        self, rows: Integers, faces: Integers, cell: Integers, others: Integers, heights: Array, places: Array
    ) -> Flags:
        """Return False for edges in the plane of a face if the bright face at the edge does not rise from the plane."""
        scene, surface = self.scene, self.scene.surface
        rising: Flags = np.abs(heights).max(axis=0) > surface.low
        level = np.flatnonzero(~rising)
        row, face = rows[cell[level]], faces[cell[level]]
        corners = [scene.take(row, k) for k in scene.faces[others[level]].T]
        third = np.sum(corners, axis=0) - places[..., level].sum(axis=0) - surface.centers[face].T
        rising[level] = np.sum(third * surface.normals[face].T, axis=0) > surface.low
        return rising

    def _cuts(self, rows: Integers, faces: Integers) -> tuple[Integers, Integers, Array]:
        """Return the segments in which bright faces cut faces: index of the face, other face, and ends (2, 3, n)."""
        cuts = self.scene.surface.cuts
        first, last = (np.searchsorted(cuts.faces, faces, side) for side in ("left", "right"))
        cell, which = np.repeat(np.arange(len(faces)), last - first), ranges(first, last)
        bright = self.front[rows[cell], cuts.others[which]] & self.front[rows[cell], cuts.beyond[which]]
        cell, which = cell[bright], which[bright]
        return cell, cuts.others[which], cuts.ends[..., which]

    def covers(self, rows: Integers, faces: Integers, cells: Integers) -> _Covers:
        """Return the shadows of single faces on some faces."""
        scene, surface = self.scene, self.scene.surface
        row, face = rows[cells], faces[cells]
        cell, which = self.bright[1].overlapping(row, *(edge[row, face] for edge in self.boxes))
        other = self.bright[0][which]
        cell, other = cell[other != face[cell]], other[other != face[cell]]
        frames, cosines, centers = self._frames(row, face)
        corners = np.stack(
            [_along(frames[..., cell], scene.take(row[cell], k) - centers[:, cell]) for k in scene.faces[other].T]
        )
        own, tolerances = surface.lines[..., face[cell]], surface.low / cosines[cell]
        meets = corners[:, 2].max(axis=0) > surface.low
        for line in own:
            meets &= (line[0] * corners[:, 0] + line[1] * corners[:, 1] + line[2]).max(axis=0) > tolerances
        cell, other, corners, tolerances = cell[meets], other[meets], corners[..., meets], tolerances[meets]
        flat, heights = corners[:, :2], np.where(np.abs(corners[:, 2]) > surface.low, corners[:, 2], 0.0)
        lines = np.empty((4, 3, len(cell)))
        lines[:3] = lines_of(flat)
        sizes = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1)
        lines[3] = np.sum((sizes * np.roll(heights, 1, axis=0))[:, None] * lines[:3], axis=0)
        slope = np.hypot(lines[3, 0], lines[3, 1])
        cuts = (heights.min(axis=0) < 0) & (slope > 0)
        lines[3] = np.where(cuts, lines[3] / np.where(cuts, slope, 1.0), [[0.0], [0.0], [1.0]])
        return _Covers(cells[cell], other, np.full(len(cell), self.index), lines, tolerances)

    def _frames(self, rows: Integers, faces: Integers) -> tuple[Array, Array, Array]:
        """Return the projections along the direction on the planes of faces, its cosines, and the centroids.

        The rows of a projection (3, 3) give the place of a shadow in the plane of a face, and the height over it.
        """
        surface, direction = self.scene.surface, self.directions[rows].T
        bases, normals = surface.bases[faces].transpose(1, 2, 0), surface.normals[faces].T
        cosines = np.sum(normals * direction, axis=0)
        tilts = np.sum(bases * direction, axis=1) / cosines
        frames = np.concatenate([bases - tilts[:, None] * normals, normals[None]])
        return frames, cosines, surface.centers[faces].T


def ray_hits(directions: Array, corners: Array) -> Flags:
    """Return True where rays (n, 3) from the origin meet triangles (n, 3, 3), from either side.

    The three volumes of a ray with the edges have the sign of the volume of the triangle (Moeller and Trumbore 1997, J.
    Graphics Tools 2, 21). A volume of zero, where a ray meets an edge, counts as either sign: the volume at an edge of
    two triangles is the same for both, so that no ray passes between them.
    """
    turns = np.cross(corners, np.roll(corners, -1, axis=1))
    volumes = np.einsum("nki,ni->nk", turns, directions)
    volumes *= np.sign(np.einsum("ni,ni->n", turns[:, 0], corners[:, 2]))[:, None]
    return np.asarray((volumes >= 0).all(axis=1) & (volumes > 0).any(axis=1))


def _overlap(surface: Surface, neighbour: Neighbour, directions: list[Array]) -> Flags:
    """Return True at epochs at which the discs of spheres around two bodies overlap along any direction."""
    reach = surface.radius + neighbour.surface.radius * np.linalg.norm(neighbour.matrices, 2, axis=(1, 2))
    across = [np.linalg.norm(np.cross(neighbour.positions, direction), axis=1) for direction in directions]
    return np.asarray(np.min(across, axis=0) < reach)


def _along(frames: Array, vectors: Array) -> Array:
    """Return matrices (3, 3, n) times vectors (3, n)."""
    return np.asarray(frames[:, 0] * vectors[0] + frames[:, 1] * vectors[1] + frames[:, 2] * vectors[2])


Record = TypeVar("Record", _Edges, _Covers)


def _joined(records: list[Record]) -> Record:
    """Return several records of arrays as one."""
    return type(records[0])._make(np.concatenate(arrays, axis=-1) for arrays in zip(*records, strict=True))


def _chosen(edges: _Edges, which: Flags) -> _Edges:
    """Return some edges."""
    return _Edges._make(array[..., which] for array in edges)
