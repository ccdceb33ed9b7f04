"""Shapes in files of triangles: OBJ, PLY, STL, tables of plates and shapes of DAMIT."""

from __future__ import annotations

import io
import logging
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poinsot.atomic_write import write_text
from poinsot.checked import checked
from poinsot.errors import optional, real_array, refuse_nonpositive
from poinsot.files.untrusted import read_bytes
from poinsot.printable import shortened
from poinsot.shapes.mesh import Mesh

__all__ = ["read_mesh", "write_damit_shape"]

MAX_BYTES = 200_000_000
MAX_FACES = 5_000_000

KINDS = {".obj": "OBJ", ".tab": "OBJ", ".ply": "PLY", ".stl": "STL", ".txt": "DAMIT"}
"""Formats by the end of the name; a shape model in .tab is the lines of OBJ or a table of plates."""

TABLE = re.compile(rb"\s*\d{1,9}(?:[ \t]+\d{1,9})?[ \t\r]*\n")
"""First line of a table of plates: the number of vertices, or the numbers of vertices and plates."""

PLATES = "a table of plates must be counts, rows of i x y z and rows of i a b c, got"

SHAPE = "a shape of DAMIT must be the numbers of vertices and facets, rows of x y z and rows of a b c, got"

VERTEX = re.compile(rb"vertex", re.IGNORECASE)

MAX_COORDINATE = 1e50
"""Largest coordinate of a vertex: moments, fifth powers of lengths, do not overflow."""

MAX_VERTICES_PER_FACE = 16
"""Vertices for each face above which a file is refused: each corner of a quadrilateral is 4, with normals and more."""

SILENT = logging.NullHandler()
"""Handler that hides the log of trimesh from terminals without a logging configuration."""


@checked
def read_mesh(
    path: str | Path,
    *,
    mass: float | None = None,
    density: float | None = None,
    unit: float = 1.0,
    repair: bool = False,
) -> Mesh:
    """Return the homogeneous body inside the surface in a file: OBJ, PLY, STL, a table of plates or a shape of DAMIT.

    The reader ignores materials and textures and opens no other file. It merges vertices at equal positions and splits
    quadrilaterals into two triangles. A table of plates, as in the PDS, contains a line with the number of vertices,
    one line "i x y z" for each vertex, a line with the number of plates, and one line "i a b c" for each plate,
    numbered from 1. Both numbers may also be in the first line. A .tab file may also contain v and f lines of OBJ. A
    shape of DAMIT (.txt) contains the numbers of vertices and facets, one line "x y z" for each vertex and one line
    "a b c" for each facet, numbered from 1.

    Parameters
    ----------
    path : str or Path
        Name of the file, whose ending is the format. At most 200 MB and 5 million faces.
    mass, density : float
        Mass, or density per cube of the user's length; exactly one of the two.
    unit : float
        Unit of length of the file in the user's unit: 1000.0 for a file in km if lengths are in m.
    repair : bool
        True to repair the faces, as in `Mesh`.

    Returns
    -------
    Mesh
        The homogeneous body.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, is too large or not in its format, or contains no closed surface around a volume;
        see `Mesh`.
    ImportError
        If trimesh, which parses OBJ, PLY and STL, is not installed.

    Examples
    --------
    >>> pt.files.read_mesh("m.obj", mass=1.0)
    Mesh(4 vertices, 4 faces, mass=1)
    """
    path = Path(path)
    kind = KINDS.get(path.suffix.lower())
    if kind is None:
        raise ValueError(f"path must end in {', '.join(KINDS)}, got {shortened(path.name)}.")
    factor = float(real_array("unit", unit, ()))
    refuse_nonpositive("unit", factor)
    content = read_bytes(path, MAX_BYTES)
    try:
        if path.suffix.lower() == ".tab" and TABLE.match(content):
            found = _plates(content.lstrip())
        elif kind == "DAMIT":
            found = _shape(content)
        else:
            _refuse_many(_most_faces(kind, content))
            found = _parsed(kind, content)
        vertices, faces = _joined(*found)
        return Mesh(factor * vertices, faces, mass=mass, density=density, repair=repair)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{shortened(path)}: {error}") from None


def _refuse_many(faces: int) -> None:
    if faces > MAX_FACES:
        raise ValueError(f"a mesh must have at most {MAX_FACES} faces, got {faces}.")


def _most_faces(kind: str, content: bytes) -> int:
    """Return the number of faces, or of other elements, that a file announces."""
    if kind == "OBJ":
        return _refuse_spare(content.count(b"\nv"), content.count(b"\nf") + content.startswith(b"f"))
    if kind == "STL":
        binary = _is_binary(content)
        corners = (len(content) - 84) // 50 * 3 if binary else sum(1 for _ in VERTEX.finditer(content))
        return _refuse_spare(corners or MAX_VERTICES_PER_FACE * 2000, corners // 3)
    header, found, _ = content.partition(b"end_header")
    if not found or len(header) > 100_000:
        raise ValueError("a PLY file must have a header with an end, got none.")
    counts = {name: int(count[:12]) for name, count in re.findall(rb"element\s+(\S+)\s+(\d+)", header)}
    if sum(counts.values()) > len(content):
        raise ValueError(f"a PLY file must have a byte for each element, got {sum(counts.values())} in {len(content)}.")
    _refuse_spare(counts.get(b"vertex", 0), counts.get(b"face", 0))
    return max(counts.values(), default=0)


def _refuse_spare(vertices: int, faces: int) -> int:
    """Return the number of faces. Raise a ValueError for far more vertices than faces use, before reading them."""
    if vertices > MAX_VERTICES_PER_FACE * (faces + 1000):
        given = f"{faces} faces for {vertices} vertices" if faces else "none"
        raise ValueError(f"the file must have faces, got {given}.")
    return faces


def _plates(content: bytes) -> tuple[Any, Any]:
    """Return vertices and faces of a table of plates, checked by its length and by the numbers of its rows."""
    numbers = _numbers(content, PLATES)
    given = len(content.split(b"\n", 1)[0].split())
    middle = given + 4 * int(numbers[0])
    counted = numbers[1:2] if given == 2 else numbers[middle : middle + 1]
    rest = middle + 2 - given
    if numbers.size != rest + 4 * counted.sum():
        raise ValueError(f"{PLATES} a length that differs from its counts.")
    _refuse_many(len(numbers[rest:]) // 4)
    places, corners = numbers[given:middle].reshape(-1, 4), numbers[rest:].reshape(-1, 4)
    for rows in (places, corners):
        if not np.array_equal(rows[:, 0], np.arange(1, len(rows) + 1)):
            raise ValueError(f"{PLATES} rows that are not numbered from 1 on.")
    return places[:, 1:], _from_zero(corners[:, 1:], len(places), "plates")


def _shape(content: bytes) -> tuple[Any, Any]:
    """Return vertices and faces of a shape of DAMIT, checked by its length."""
    numbers = _numbers(content, SHAPE)
    counts = numbers[:2]
    if len(counts) < 2 or np.any(counts != np.floor(counts)) or np.any(counts < 1):
        raise ValueError(f"{SHAPE} other numbers in the first line.")
    if numbers.size != 2 + 3 * counts.sum():
        raise ValueError(f"{SHAPE} a length that differs from its numbers.")
    _refuse_many(int(counts[1]))
    rows = numbers[2:].reshape(-1, 3)
    places, corners = np.split(rows, [int(counts[0])])
    return places, _from_zero(corners, len(places), "facets")


def _numbers(content: bytes, rule: str) -> NDArray[np.float64]:
    """Return the numbers of a text that has nothing else."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # some NumPy only warn of other text
            return np.fromstring(content, sep=" ")
    except (DeprecationWarning, ValueError):
        raise ValueError(f"{rule} text that is no number.") from None


def _from_zero(corners: NDArray[np.float64], vertices: int, name: str) -> NDArray[np.int64]:
    """Return the numbers of vertices from 0, of triangles that number them from 1."""
    wrong = corners[~((corners == np.floor(corners)) & (corners >= 1) & (corners <= vertices))]
    if wrong.size:
        raise ValueError(f"{name} must name vertices from 1 to {vertices}, got {wrong[0]:g}.")
    return corners.astype(np.int64) - 1


@checked
def write_damit_shape(mesh: Mesh, path: str | Path, *, unit: float = 1.0, overwrite: bool = False) -> Path:
    """Write the vertices and faces of a mesh as a shape of DAMIT (.txt).

    Numbers are written with all digits, so that `read_mesh` restores the vertices exactly, in the order of their
    coordinates.

    Parameters
    ----------
    mesh : Mesh
        Mesh to write.
    path : str or Path
        Name of the file, which ends in .txt.
    unit : float
        Unit of length of the file in the unit of the mesh.
    overwrite : bool
        True to replace an existing file.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError, ValueError, OSError
        If the name has another ending, or the file exists.

    Examples
    --------
    >>> path = pt.files.write_damit_shape(pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0), "box.txt")
    >>> pt.files.read_mesh(path, mass=1.0)
    Mesh(8 vertices, 12 faces, mass=1)
    """
    path = Path(path)
    if KINDS.get(path.suffix.lower()) != "DAMIT":
        raise ValueError(f"path must end in .txt, got {shortened(path.name)}.")
    factor = float(real_array("unit", unit, ()))
    refuse_nonpositive("unit", factor)
    lines = [f"{len(mesh.vertices)} {len(mesh.faces)}"]
    lines += [" ".join(map(repr, row)) for row in (mesh.vertices / factor).tolist()]
    lines += [" ".join(map(str, row)) for row in (mesh.faces + 1).tolist()]
    return write_text(path, "\n".join(lines) + "\n", overwrite)


def _parsed(kind: str, content: bytes) -> tuple[Any, Any]:
    """Return vertices and faces as trimesh reads them from memory, without any other file."""
    obj, ply, stl = (optional(f"trimesh.exchange.{each}", f"{kind} files", "meshes") for each in ("obj", "ply", "stl"))
    stream = io.BytesIO(_bare(kind, content))
    logging.getLogger("trimesh").addHandler(SILENT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # some NumPy only warn of numbers that end in other text
            if kind == "OBJ":
                found = obj.load_obj(stream, skip_materials=True)
            elif kind == "PLY":
                found = ply.load_ply(stream, skip_materials=True, fix_texture=False)
            else:
                found = stl.load_stl(stream)
        part = next(iter(found["geometry"].values()), {}) if "geometry" in found else found
    except Exception as error:  # of any kind: the parsers do not check what they index
        what = " ".join(str(error).split())[:100] or type(error).__name__
        raise ValueError(f"the file must be {kind} with vertices and faces, got an error: {what}.") from None
    if part.get("faces") is None:
        raise ValueError("the file must have faces, got none.")
    return part["vertices"], part["faces"]


def _bare(kind: str, content: bytes) -> bytes:
    """Return the vertices and faces of a file in text, without its names: many of them take trimesh very long."""
    if kind == "OBJ":
        lines = re.findall(rb"^[ \t]*[vf][ \t][^\n]*", content.replace(b"\\\n", b" "), re.MULTILINE)
        bare = re.sub(rb"/[^\s]*", b"", b"\n".join(lines))
        if re.search(rb"^[ \t]*f[^\n]*\s0+(?!\S)", bare, re.MULTILINE):
            raise ValueError("a face must name vertices from 1 in OBJ, got vertex 0. Add 1 to each of them.")
        if not bare:
            raise ValueError(
                "the file must have the v and f lines of OBJ, got none. A .tab may also be a table of plates: "
                "counts, then rows with their numbers."
            )
        return bare
    if kind == "STL" and not _is_binary(content):
        return b"solid\n" + b"\n".join(re.findall(rb"vertex[^\n]*", content.lower())) + b"\nendsolid"
    return content


def _is_binary(content: bytes) -> bool:
    return len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")


def _joined(points: Any, polygons: Any) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Return the points, each once, and triangles of them, without those that shrink to an edge."""
    with np.errstate(invalid="ignore"):  # a NaN of 32 bits may warn before it is refused
        vertices = real_array("vertices", points, (None, 3))
    if np.any(np.abs(vertices) > MAX_COORDINATE):
        raise ValueError(f"vertices must be within {MAX_COORDINATE:g}, got {np.max(np.abs(vertices)):g}.")
    order = np.lexsort(vertices.T)
    new = np.append(True, np.any(vertices[order][1:] != vertices[order][:-1], axis=1))[: len(vertices)]
    place = np.empty(len(vertices), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    triangles = place[_triangles(polygons, len(place))]
    return vertices[order][new], triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def _triangles(polygons: Any, vertices: int) -> NDArray[np.int64]:
    array = np.asarray(polygons)
    if array.ndim != 2 or array.shape[1] not in (3, 4) or array.dtype.kind not in "iu":
        raise ValueError(f"faces must be triangles or quadrilaterals, got an array of shape {array.shape}.")
    wrong = array[(array < 0) | (array >= vertices)]
    if wrong.size:
        raise ValueError(f"faces must name vertices from 0 to {vertices - 1}, got {wrong[0]}.")
    halves = [array[:, :3], array[:, [0, 2, 3]]] if array.shape[1] == 4 else [array]
    return np.concatenate(halves).astype(np.int64)
