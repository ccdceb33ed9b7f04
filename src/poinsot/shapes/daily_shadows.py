"""Mean torques that the faces of a mesh lose to shadows in a rotation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.shapes.surface import Surface

__all__ = ["DailyShadows"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

TURN = 2 * np.pi

CUT = np.sqrt(2.0)
"""Angle from the first axis to the meridian at which rotation phases begin; no regular mesh has edges there."""

MAX_PAIRS = 4_000_000
"""Largest number of pairs of an arc and a latitude of the Sun, or of a face and a corner, in one block."""


class _Outlines(NamedTuple):
    """Arcs of great circles around the parts of the sky that other faces hide from the centroids of faces.

    Attributes
    ----------
    faces : array (n,)
    senses : array (n,)
        The number of hidden triangles to the left of an arc, minus the number to its right.
    starts, ends : array (n, 3)
        Vectors from the centroid to the ends of the edge, along the rotation axes.
    at_pole : array (faces of the mesh,)
        The number of triangles that contain the southern pole of the sky.
    """

    faces: Integers
    senses: Integers
    starts: Array
    ends: Array
    at_pole: Integers


class DailyShadows:
    """Means over a rotation of the torques that faces of a mesh lose because other faces hide the Sun.

    The faces that hide the Sun from the centroid of a face cover a part of the sky. Its outline consists of arcs of
    great circles. The Sun at one latitude crosses an arc at phases in closed form, and the light on the face between
    two phases has an antiderivative: the mean over the phase is exact.

    A corner is either below a latitude of the Sun or not, for all arcs that end there. Outlines are closed, so that
    the Sun enters an outline as often as it leaves it. Rounding shifts a crossing but neither adds nor removes one.
    """

    def __init__(self, light: Surface, axes: Array, torques: Array) -> None:
        """Rotate the mesh and find the outlines.

        Parameters
        ----------
        light : Surface
        axes : array (3, 3)
            Rotation matrix, whose third row is the rotation axis.
        torques : array (faces, 3)
            Torques of the faces under vertical light, along these axes.
        """
        c, s = np.cos(CUT), np.sin(CUT)
        turn = np.array([(c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)])
        rotated = turn @ axes
        self._torques, normals = torques @ turn.T, light.normals @ rotated.T
        self._levels, self._ups = np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2]
        self._noons = np.arctan2(normals[:, 1], normals[:, 0]) % TURN
        self._centers, self._corners, self._faces = light.centers @ rotated.T, light.vertices @ rotated.T, light.faces
        directed = light.faces[:, [(0, 1), (1, 2), (2, 0)]]
        pairs, edges = np.unique(np.sort(directed, axis=-1).reshape(-1, 2), axis=0, return_inverse=True)
        self._pairs, self._edges = pairs, edges.reshape(-1, 3)
        self._directions = np.where(directed[..., 0] < directed[..., 1], 1, -1)
        self._outlines = [self._outlined(face, other) for face, other in _hiding(light) if len(face)]

    def torques(self, sines: Array) -> tuple[Array, Complex]:
        """Return the lost torques along the axis, and across it times exp(-i phase of the Sun).

        Parameters
        ----------
        sines : array (n,)
            Ascending sines of the latitude of the Sun, between -1 and 1.
        """
        along, across = np.zeros(len(sines)), np.zeros(len(sines), dtype=complex)
        for outlines in self._outlines:
            rows = max(1, MAX_PAIRS // (len(outlines.faces) + len(self._centers)))
            for start in range(0, len(sines), rows):
                part = slice(start, start + rows)
                lost = self._lost(outlines, sines[part])
                along[part] += lost[0]
                across[part] += lost[1]
        return along, across

    def _outlined(self, face: Integers, other: Integers) -> _Outlines:
        """Return the outlines for pairs of a face and another that may hide the Sun; common edges of two cancel."""
        first, count = face.min(), len(self._pairs)
        keys = (face - first)[:, None] * count + self._edges[other]
        senses = np.bincount(keys.ravel(), weights=self._directions[other].ravel())
        left = np.flatnonzero(senses)
        seen, edge = left // count + first, left % count
        starts, ends = (self._corners[self._pairs[edge, k]] - self._centers[seen] for k in (0, 1))
        corners = self._corners[self._faces[other]] - self._centers[face][:, None]
        turns = np.sum([_eastwards(corners[:, k], corners[:, k - 2]) for k in range(3)], axis=0)
        at_pole = np.bincount(face[turns < 0], minlength=len(self._centers))
        return _Outlines(seen, senses[left].astype(np.int64), starts, ends, at_pole)

    def _lost(self, outlines: _Outlines, sines: Array) -> tuple[Array, Complex]:
        """Return the lost torques of some faces."""
        at_start = _depths_at_start(outlines, sines)
        dark, latitude = np.nonzero(at_start)
        depths, zero = at_start[dark, latitude], np.zeros(len(dark))
        arc, place, phase, step = _crossings(outlines, sines)
        face = np.concatenate([dark, outlines.faces[arc], dark])
        place = np.concatenate([latitude, place, latitude])
        phase = np.concatenate([zero, phase, zero + TURN])
        step = np.concatenate([depths, step, -depths])
        order = np.argsort((face * len(sines) + place) + phase / 7)  # a whole rotation of each face and latitude
        shaded = np.concatenate([[0], np.cumsum(step[order]) > 0])
        change = shaded[:-1] - shaded[1:]
        at = order[change != 0]
        face, place = face[at], place[at]
        mean, first = self._light_until(face, sines[place], phase[at])
        share = change[change != 0] / TURN
        t, n = self._torques[face], len(sines)
        lost = share * first * (t[:, 0] + 1j * t[:, 1])
        along, across = np.zeros(n), np.zeros(n, dtype=complex)
        np.add.at(along, place, share * mean * t[:, 2])
        np.add.at(across, place, lost)
        return along, across

    def _light_until(self, face: Integers, sine: Array, phase: Array) -> tuple[Array, Complex]:
        """Return antiderivatives of the light on faces without shadows, and of the light times exp(-i phase)."""
        p, q = self._levels[face] * np.sqrt(1 - sine**2), self._ups[face] * sine
        half = np.arccos(np.clip(np.divide(-q, p, out=-np.sign(q), where=p > 0), -1.0, 1.0))
        past = phase - self._noons[face]
        days = np.rint(past / TURN)
        x = np.clip(past - TURN * days, -half, half)

        def odd(x: Array) -> tuple[Array, Array]:
            return p * np.sin(x) + q * x, p * (x + np.sin(x) * np.cos(x)) / 2 + q * np.sin(x)

        (mean, real), (day, day_real) = odd(x), odd(half)
        first = real + 2 * days * day_real + 1j * (q * np.cos(x) - p * np.sin(x) ** 2 / 2)
        return mean + 2 * days * day, first * np.exp(-1j * self._noons[face])


def _hiding(surface: Surface) -> Iterator[tuple[Integers, Integers]]:
    """Yield pairs of faces, of which the second has a corner above the first and looks away from its centroid.

    A ray that leaves the body meets such a face last, wherever else it entered.
    """
    offsets = np.einsum("fi,fi->f", surface.normals, surface.centers)
    rows = max(1, MAX_PAIRS // (3 * len(surface.areas)))
    for start in range(0, len(surface.areas), rows):
        part = slice(start, start + rows)
        heights = np.einsum("ai,fki->afk", surface.normals[part], surface.corners) - offsets[part, None, None]
        above = (heights > surface.low).any(axis=2)
        behind = surface.centers[part] @ surface.normals.T < offsets
        first, second = np.nonzero(above & behind)
        yield first + start, second


def _eastwards(starts: Array, ends: Array) -> Integers:
    """Return 1 for arcs that cross the meridian of phase zero eastwards, -1 westwards, 0 for others."""
    senses = (starts[:, 1] < 0).astype(np.int64) - (ends[:, 1] < 0)
    height = starts[:, 0] * ends[:, 1] - ends[:, 0] * starts[:, 1]
    return np.where(senses * height > 0, senses, 0)


def _depths_at_start(outlines: _Outlines, sines: Array) -> Integers:
    """Return how many triangles contain the Sun at phase zero; shape (faces, latitudes)."""
    senses = _eastwards(outlines.starts, outlines.ends)
    some = np.flatnonzero(senses)
    a, b = outlines.starts[some], outlines.ends[some]
    met = a * np.abs(b[:, 1:2]) + b * np.abs(a[:, 1:2])
    steps = np.zeros((len(outlines.at_pole), len(sines) + 1), dtype=np.int64)
    steps[:, 0] = outlines.at_pole
    places = np.searchsorted(sines, met[:, 2] / np.hypot(met[:, 0], met[:, 2]), "right")
    np.add.at(steps, (outlines.faces[some], places), senses[some] * outlines.senses[some])
    return np.cumsum(steps[:, :-1], axis=1)


def _crossings(outlines: _Outlines, sines: Array) -> tuple[Integers, Integers, Array, Integers]:
    """Return the arcs, latitudes and phases at which the Sun crosses outlines, and the change of the depth.

    An arc whose ends are on different sides of a latitude crosses it once. An arc between ends on one side crosses it
    twice, where the highest or lowest point of its great circle is on the arc and on the other side.
    """
    a, b = outlines.starts, outlines.ends
    normals = np.cross(a, b)
    slopes = np.hypot(normals[:, 0], normals[:, 1])
    highest = _over(slopes, np.sqrt(np.sum(normals**2, axis=1)))
    rise_a, rise_b = (normals[:, 0] * x[:, 1] - normals[:, 1] * x[:, 0] for x in (a, b))
    height_a, height_b = (_over(x[:, 2], np.sqrt(np.sum(x**2, axis=1))) for x in (a, b))
    of_a, of_b = (np.searchsorted(sines, x, "right") for x in (height_a, height_b))
    low, high = np.minimum(of_a, of_b), np.maximum(of_a, of_b)
    top = np.where((rise_a > 0) & (rise_b < 0), np.maximum(high, np.searchsorted(sines, highest)), high)
    bottom = np.where((rise_a < 0) & (rise_b > 0), np.minimum(low, np.searchsorted(sines, -highest)), low)

    # once between the heights of the ends; twice up to the highest point, twice down to the lowest
    start, stop = np.concatenate([low, high, high, bottom, bottom]), np.concatenate([high, top, top, low, low])
    up = np.ones(len(a), dtype=np.int64)
    way = np.concatenate([np.where(of_b > of_a, 1, -1), up, -up, up, -up])
    count = stop - start
    arc = np.repeat(np.tile(np.arange(len(a)), 5), count)
    way = np.repeat(way, count)
    place = np.arange(len(arc)) - np.repeat(np.cumsum(count) - count - start, count)

    tangents = sines / np.sqrt(1 - sines**2)
    apart = np.arccos(np.clip(_over(-normals[:, 2], slopes)[arc] * tangents[place], -1.0, 1.0))
    phase = np.arctan2(normals[:, 1], normals[:, 0])[arc] + way * apart
    # rounding must not move a crossing beyond the ends of its arc
    phase_a, phase_b = (np.arctan2(x[:, 1], x[:, 0]) for x in (a, b))
    span = _wrapped(phase_b - phase_a)
    other_side = (np.abs(span) > 3) & (span * normals[:, 2] < 0)  # near half a turn the normal decides
    span = np.where(other_side, span - np.copysign(TURN, span), span)
    middle, half = phase_a + span / 2, np.abs(span) / 2
    phase = middle[arc] + np.clip(_wrapped(phase - middle[arc]), -half[arc], half[arc])
    return arc, place, phase % TURN, -way * outlines.senses[arc]


def _over(dividend: Array, divisor: Array) -> Array:
    """Return quotients, zero where the divisor is."""
    return np.asarray(np.divide(dividend, divisor, out=np.zeros_like(dividend), where=divisor > 0))


def _wrapped(angles: Array) -> Array:
    """Return angles from -pi to pi."""
    return np.asarray((angles + np.pi) % TURN - np.pi)
