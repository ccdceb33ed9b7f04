"""Files of triangles, written here byte by byte: what is read, and what is refused in one sentence."""

import builtins
import struct
import sys
import warnings
from itertools import starmap

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.files.bodies import meshes

BOX = pt.shapes.Mesh.from_box((1, 2, 3), mass=6.0)  # halves: no rounding in float32
TRIANGLES = BOX.vertices[BOX.faces]


def obj(vertices=BOX.vertices, faces=BOX.faces + 1, face="f {} {} {}"):
    return "".join("v {} {} {}\n".format(*v) for v in vertices) + "".join(starmap((face + "\n").format, faces))


def ply(kind):
    header = (
        f"ply\nformat {kind} 1.0\ncomment made by hand\ncomment TextureFile /etc/passwd\n"
        f"element vertex {len(BOX.vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(BOX.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if kind == "ascii":
        rows = ["{} {} {}".format(*v) for v in BOX.vertices] + ["3 {} {} {}".format(*f) for f in BOX.faces]
        return header + "\n".join(rows).encode() + b"\n"
    order = "<" if "little" in kind else ">"
    points = b"".join(struct.pack(order + "3f", *v) for v in BOX.vertices)
    return header + points + b"".join(struct.pack(order + "B3i", 3, *f) for f in BOX.faces)


def stl_binary():
    return (
        b"solid by hand".ljust(80, b"\0")
        + struct.pack("<I", len(TRIANGLES))
        + b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in TRIANGLES)
    )


def stl_text(shift=0):
    loops = [
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*v) for v in t) + "endloop\nendfacet\n"
        for t in TRIANGLES + shift
    ]
    return "solid box\n" + "".join(loops) + "endsolid box\n"


def plates(apart=True, faces=BOX.faces + 1, first=1):
    counts = (len(BOX.vertices), len(faces))
    rows = [" ".join(map(str, (k, *row))) for part in (BOX.vertices, faces) for k, row in enumerate(part, first)]
    rows[8:8] = [f"  {counts[1]}"] * apart
    return "\r\n".join([f"  {counts[0]}" if apart else "{}\t{}".format(*counts), *rows, ""])


def shape(faces=BOX.faces + 1):
    rows = [" ".join(map(str, row)) for part in (BOX.vertices, faces) for row in part]
    return "\n".join([f"{len(BOX.vertices)} {len(faces)}", *rows, ""])


FILES = {
    "shape.txt": shape(),
    "box.obj": obj(),
    "box.OBJ": obj(face="f {0}/{0}/{0} {1}/{0}/{1} {2}/{0}/{0}"),
    "eros.tab": obj(),
    "plates.tab": plates(),
    "counts.TAB": plates(apart=False),
    "text.ply": ply("ascii"),
    "little.ply": ply("binary_little_endian"),
    "big.ply": ply("binary_big_endian"),
    "binary.stl": stl_binary(),
    "text.stl": stl_text(),
}


def written(folder, name, content):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("name", FILES)
def test_a_box_comes_out_of_every_format(name, tmp_path):
    mesh = pt.files.read_mesh(written(tmp_path, name, FILES[name]), mass=6.0)
    assert len(mesh.vertices) == 8
    assert len(mesh.faces) == 12
    assert mesh.volume == 6
    np.testing.assert_allclose(mesh.inertia, BOX.inertia, rtol=1e-15)


def test_the_unit_is_that_of_the_file(tmp_path):
    path = written(tmp_path, "box.obj", obj())
    mesh = pt.files.read_mesh(path, density=2.0, unit=1000.0)
    assert mesh.volume == pytest.approx(6e9)
    assert mesh.mass == pytest.approx(12e9)
    with pytest.raises(ValueError, match="unit must be positive"):
        pt.files.read_mesh(path, mass=1, unit=0)
    with pytest.raises(ValueError, match="exactly one of mass, density, got none"):
        pt.files.read_mesh(path)


def test_quadrilaterals_and_texture_seams_are_one_surface(tmp_path):
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    seams = "mtllib /etc/passwd\nusemtl stone\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    seamed = [" ".join(f"{v + 1}/{k + 1}/1" for k, v in enumerate(quad)) for quad in quads]
    path = written(tmp_path, "quads.obj", seams + obj(faces=[]) + "".join(f"f {text}\n" for text in seamed))
    mesh = pt.files.read_mesh(path, mass=6.0)
    assert (len(mesh.vertices), mesh.volume) == (8, 6)


def test_parts_of_a_file_are_one_body(tmp_path):
    two = written(tmp_path, "two.stl", stl_text() + stl_text(shift=4))
    assert pt.files.read_mesh(two, mass=12.0).volume == 12
    lines = obj().splitlines()
    painted = [*lines[:8], "usemtl a", *lines[8:11], "usemtl b", *lines[11:17], "usemtl a", *lines[17:]]
    mesh = pt.files.read_mesh(written(tmp_path, "painted.obj", "\n".join(painted)), mass=1.0)
    assert (len(mesh.faces), mesh.volume) == (12, 6)


def test_a_part_that_cannot_be_read_is_not_left_out(tmp_path):
    broken = stl_text(shift=4).replace("vertex", "vertex one", 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(ValueError, match=r"two\.stl: the file must be STL"):
            pt.files.read_mesh(written(tmp_path, "two.stl", stl_text() + broken), mass=12.0)


def test_triangles_that_shrink_to_an_edge_are_dropped_where_vertices_become_one(tmp_path):
    flat = [(*BOX.vertices[0], *BOX.vertices[0], *BOX.vertices[1])]
    content = bytearray(stl_binary() + struct.pack("<12fH", 0, 0, 0, *flat[0], 0))
    content[80:84] = struct.pack("<I", 13)
    assert pt.files.read_mesh(written(tmp_path, "sliver.stl", bytes(content)), mass=1).volume == 6


def test_no_other_file_is_opened(tmp_path, monkeypatch):
    pt.files.read_mesh(written(tmp_path, "warm.ply", ply("ascii")), mass=1)  # modules are imported
    paths = [written(tmp_path, name, "mtllib secret.mtl\n" * ("obj" in name) + FILES["box.obj"]) for name in ("a.obj",)]
    paths.append(written(tmp_path, "b.ply", ply("ascii")))
    opened, true_open = [], builtins.open

    def watched(file, *args, **kwargs):
        opened.append(str(file))
        return true_open(file, *args, **kwargs)

    monkeypatch.setattr(builtins, "open", watched)
    for path in paths:
        pt.files.read_mesh(path, mass=1)
    assert not opened  # the file itself goes through pathlib


def test_surfaces_that_are_not_closed_or_inverted_name_the_file(tmp_path):
    opened = written(tmp_path, "open.obj", obj(faces=BOX.faces[1:] + 1))
    with pytest.raises(ValueError, match=r"open\.obj: faces must close the surface"):
        pt.files.read_mesh(opened, mass=1)
    inverted = written(tmp_path, "in.obj", obj(faces=BOX.faces[:, ::-1] + 1))
    with pytest.raises(ValueError, match=r"in\.obj: faces must be anticlockwise .* Pass repair=True to reverse them"):
        pt.files.read_mesh(inverted, mass=1)
    assert pt.files.read_mesh(inverted, mass=1, repair=True).volume == 6
    flat = written(tmp_path, "flat.obj", obj(vertices=BOX.vertices * (1, 1, 0)))
    with pytest.raises(ValueError, match=r"flat\.obj: faces must"):
        pt.files.read_mesh(flat, mass=1)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.obj", "", "the file must"),
        ("a.obj", obj(faces=[]), "the file must have faces, got none"),
        ("a.obj", obj().replace("v -0.5 -1.0 -1.5", "v nan -1.0 -1.5"), "vertices must be finite"),
        ("a.obj", obj().replace("v -0.5 -1.0 -1.5", "v inf -1.0 -1.5"), "vertices must be finite"),
        ("a.obj", obj().replace("v -0.5 -1.0 -1.5", "v x -1.0 -1.5"), "the file must be OBJ with vertices and faces"),
        ("a.obj", obj(faces=BOX.faces + 2), "the file must be OBJ with vertices and faces"),
        ("a.obj", obj().replace("f ", "f 1/"), "a.obj: "),
        ("a.obj", obj(faces=BOX.faces), r"must name vertices from 1 in OBJ, got vertex 0\. Add 1 to each"),
        ("a.obj", obj(faces=BOX.faces, face="f {}/1 {}/2 {}/3"), "got vertex 0"),
        ("a.obj", plates(), r"the v and f lines of OBJ, got none\. A \.tab may also be a table of plates"),
        ("a.tab", plates().replace("  8", "1 2 3", 1), "the v and f lines of OBJ, got none"),
        ("a.tab", plates()[:-20], r"rows of i x y z and rows of i a b c, got a length that differs from its counts"),
        ("a.tab", plates().replace("  8", "  80", 1), "got a length that differs from its counts"),
        ("a.tab", plates().replace("  12", "  nan", 1), "got a length that differs from its counts"),
        ("a.tab", plates().replace("  8", "  0", 1), "got a length that differs from its counts"),
        ("a.tab", plates().replace("-0.5", "-0.5,", 1), "got text that is no number"),
        ("a.tab", plates().replace("-0.5", "nan", 1), "vertices must be finite"),
        ("a.tab", plates(first=0), "got rows that are not numbered from 1 on"),
        ("a.tab", plates(faces=BOX.faces), "plates must name vertices from 1 to 8, got 0"),
        ("a.tab", plates(faces=BOX.faces + 2), "plates must name vertices from 1 to 8, got 9"),
        ("a.tab", plates(faces=BOX.faces + 0.5), "plates must name vertices from 1 to 8, got 0.5"),
        ("a.tab", plates(faces=[]), "faces must not be empty"),
        ("a.txt", "", r"a shape of DAMIT must be .* rows of a b c, got other numbers in the first line"),
        ("a.txt", shape().replace("8 12", "8.5 12", 1), "got other numbers in the first line"),
        ("a.txt", shape().replace("8 12", "8 nan", 1), "got other numbers in the first line"),
        ("a.txt", shape().replace("8 12", "8 13", 1), "got a length that differs from its numbers"),
        ("a.txt", shape().replace("8 12", "800000000 12", 1), "got a length that differs from its numbers"),
        ("a.txt", shape()[:-8], "got a length that differs from its numbers"),
        ("a.txt", "v " + shape(), "got text that is no number"),
        ("a.txt", shape(BOX.faces), "facets must name vertices from 1 to 8, got 0"),
        ("a.txt", shape().replace("-0.5", "nan", 1), "vertices must be finite"),
        ("a.ply", b"", "a PLY file must have a header with an end"),
        ("a.ply", b"ply\nend_header\n", "the file must be PLY"),
        ("a.ply", ply("ascii").replace(b"face 12", b"face 12000000"), "a PLY file must have a byte for each element"),
        ("a.ply", ply("binary_little_endian")[:-20], "a.ply: "),
        ("a.ply", ply("ascii").replace(b"\n3 ", b"\n3 9"), "faces must name vertices from 0 to 7, got 9"),
        ("a.stl", b"", "the file must"),
        ("a.stl", stl_text().replace("vertex -0.5", "vertex 1e999"), "vertices must be finite"),
        ("a.stl", stl_text().replace("vertex -0.5", "vertex one"), "the file must be STL"),
        ("a.stl", stl_binary()[:-1], "a.stl: "),
    ],
)
def test_bad_files_end_in_one_sentence(name, content, sentence, tmp_path):
    with pytest.raises(ValueError, match=sentence) as caught:
        pt.files.read_mesh(written(tmp_path, name, content), mass=1)
    assert str(caught.value).startswith(str(tmp_path / name))
    assert "\n" not in str(caught.value)


def test_too_large_files_and_other_formats_are_refused(tmp_path, monkeypatch):
    path = written(tmp_path, "box.stl", stl_binary())
    monkeypatch.setattr(meshes, "MAX_FACES", 11)
    for name in ("box.stl", "box.obj", "text.ply", "text.stl", "plates.tab", "counts.TAB", "shape.txt"):
        with pytest.raises(ValueError, match="a mesh must have at most 11 faces, got 12"):
            pt.files.read_mesh(written(tmp_path, name, FILES.get(name, stl_binary())), mass=1)
    monkeypatch.setattr(meshes, "MAX_BYTES", 100)
    with pytest.raises(ValueError, match="must have at most 100 bytes, got more"):
        pt.files.read_mesh(path, mass=1)
    with pytest.raises(ValueError, match=r"path must end in \.obj, \.tab, \.ply, \.stl, \.txt, got box\.glb"):
        pt.files.read_mesh(tmp_path / "box.glb", mass=1)
    with pytest.raises(FileNotFoundError):
        pt.files.read_mesh(tmp_path / "none.obj", mass=1)


@settings(max_examples=150, deadline=10_000, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(sorted(FILES)),
    edits=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 30), st.binary(max_size=12)), min_size=1, max_size=4),
)
def test_any_bytes_end_in_a_mesh_or_in_one_sentence(name, edits, tmp_path):
    content = FILES[name] if isinstance(FILES[name], bytes) else FILES[name].encode()
    for place, dropped, added in edits:
        at = int(place * len(content))
        content = content[:at] + added + content[at + dropped :]
    try:
        assert np.all(np.isfinite(pt.files.read_mesh(written(tmp_path, name, content), mass=1).inertia))
        sentence = ""
    except ValueError as error:
        sentence = str(error)
    assert "\n" not in sentence


def test_without_trimesh_the_message_names_the_extra(monkeypatch, tmp_path):
    for module in ("trimesh", *(f"trimesh.exchange.{kind}" for kind in ("obj", "ply", "stl"))):
        monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / "it.obj").write_text(obj())
    with pytest.raises(
        ImportError,
        match=r"^trimesh must be installed for OBJ files, got none\. `pip install 'poinsot\[meshes\]'` brings it\.$",
    ):
        pt.files.read_mesh(tmp_path / "it.obj", mass=1.0)


@given(seed=st.integers(0, 2**32))
@settings(max_examples=10, deadline=None)
def test_a_written_shape_comes_back(tmp_path_factory, seed):
    rng = np.random.default_rng(seed)
    mesh = pt.shapes.Mesh(BOX.vertices * rng.uniform(0.1, 10, 3) + rng.normal(size=3), BOX.faces, density=2.0)
    folder = tmp_path_factory.mktemp("shape")
    first = pt.files.read_mesh(pt.files.write_damit_shape(mesh, folder / "a.txt"), density=2.0)
    again = pt.files.read_mesh(pt.files.write_damit_shape(first, folder / "b.txt"), density=2.0)
    order = np.lexsort(mesh.vertices.T)
    assert np.array_equal(first.vertices, mesh.vertices[order])
    assert np.array_equal(again.vertices, first.vertices)
    assert np.array_equal(again.faces, first.faces)


def test_a_shape_is_written_in_the_unit_of_the_file(tmp_path):
    path = pt.files.write_damit_shape(BOX, tmp_path / "a.txt", unit=0.5)
    assert path.read_text().split()[:5] == ["8", "12", *map(repr, (2 * BOX.vertices[0]).tolist())]
    with pytest.raises(FileExistsError):
        pt.files.write_damit_shape(BOX, path)
    with pytest.raises(ValueError, match=r"^path must end in \.txt, got a\.obj\.$"):
        pt.files.write_damit_shape(BOX, tmp_path / "a.obj")
