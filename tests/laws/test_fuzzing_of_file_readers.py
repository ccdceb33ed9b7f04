"""Every reader, given files that were changed by seeds: each is read, or ends in one sentence, in time and memory."""

import gc
import json
import re
import resource
import time
import warnings
from functools import partial
from importlib import resources
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from fuzzing import mutant
from poinsot.files.attitudes import ck
from public_calls import CURVES, SPIN
from tumbling import MOTION, NAMED
from unit.files.bodies import test_fields
from unit.files.orbits import test_oem, test_tle

SECONDS, BYTES = 1.0, 200e6
"""Of this process for each file; readers in processes of their own have limits there."""

BOX = pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), mass=1.0)
DATED = {"calendar": NAMED["calendar"], "reference_frame": NAMED["reference_frame"]}
EPOCH = "2000-06-27T19:00:00 UTC", "2000-06-27T19:30:00 UTC"


def ply():
    rows = [" ".join(map(str, row)) for row in BOX.vertices] + [f"3 {a} {b} {c}" for a, b, c in BOX.faces]
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(BOX.vertices)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(BOX.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        + "\n".join(rows)
        + "\n"
    )


def obj():
    return "".join(f"v {x} {y} {z}\n" for x, y, z in BOX.vertices) + "".join(
        f"f {a} {b} {c}\n" for a, b, c in BOX.faces + 1
    )


def plates():
    places = [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(BOX.vertices, 1)]
    faces = [f"{i} {a} {b} {c}" for i, (a, b, c) in enumerate(BOX.faces + 1, 1)]
    return "\n".join([str(len(places)), *places, str(len(faces)), *faces]) + "\n"


def stl(binary):
    triangles = BOX.vertices[BOX.faces]
    if binary:
        kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
        rows = np.zeros(len(triangles), kind)
        rows["corners"] = triangles
        return bytes(80) + len(rows).to_bytes(4, "little") + rows.tobytes()
    corners = ["".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle) for triangle in triangles]
    return (
        "solid it\n"
        + "".join(f"facet normal 0 0 0\nouter loop\n{c}endloop\nendfacet\n" for c in corners)
        + "endsolid\n"
    )


def damit_shape():
    rows = [" ".join(map(str, row)) for part in (BOX.vertices, BOX.faces + 1) for row in part]
    return "\n".join([f"{len(BOX.vertices)} {len(BOX.faces)}", *rows]) + "\n"


class Brightness(pt.Observable):
    noise: float = 0.1

    def reading(self, instant):
        return instant.omega_body[0]


NIGHTS = [
    pt.observables.Readings(
        Brightness(),
        np.linspace(i, i + 0.2, 9),
        np.linspace(12, 13, 9),
        np.full(9, 0.01),
        name=f"night {i}",
        calendar=pt.Calendar("2012-10-10T00:00:00", "TDB", "d"),
        attributes={"units": "mag"},
    )
    for i in range(3)
]
"""Light curves that the files of observations contain."""


def kvn():
    return "CCSDS_OMM_VERS = 2.0\nCREATION_DATE = 2020-01-01T00:00:00\nORIGINATOR = IT\n" + "".join(
        f"{key} = {value}\n" for key, value in test_tle.MESSAGE.items()
    )


def oem():
    head = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-04T17:22:31\nORIGINATOR = IT\n"
    return head + test_oem.metadata(STOP_TIME=test_oem.dated(2400)) + test_oem.lines(last=20)


TEXTS: dict[str, Any] = {
    "it.oem": oem,
    "it.tle": lambda: "\n".join(test_tle.VANGUARD) + "\n",
    "it.omm": kvn,
    "omm.json": lambda: json.dumps(test_tle.MESSAGE),
    "omm.csv": lambda: ",".join(test_tle.MESSAGE) + "\n" + ",".join(test_tle.MESSAGE.values()) + "\n",
    "it.toml": lambda: (resources.files("poinsot.scenarios") / "template.toml").read_text(),
    "it.gfc": test_fields.icgem,
    "field.tab": test_fields.shadr,
    "it.obj": obj,
    "it.ply": ply,
    "it.stl": partial(stl, False),
    "plates.tab": plates,
    "shape.txt": damit_shape,
    "spin.txt": lambda: SPIN,
    "lc.txt": lambda: CURVES,
}

WRITERS: dict[str, Any] = {
    "it.nc": pt.save,
    "it.aem": partial(pt.files.write_aem, **NAMED),
    "aem.xml": partial(pt.files.write_aem, **NAMED),
    "it.a": partial(pt.files.write_stk_attitude, **DATED),
    "it.csv": partial(pt.files.write_quaternion_csv, **NAMED),
    "it.bc": partial(pt.files.write_ck, **NAMED),
}


OBSERVATIONS: dict[str, Any] = {
    "readings.nc": partial(pt.files.write_readings, NIGHTS),
    "readings.csv": partial(pt.files.write_readings_csv, NIGHTS[0]),
    "alcdef.txt": partial(pt.files.write_alcdef, NIGHTS),
}


def observed(read, path):
    return read(path, Brightness())


def curves(path):
    return pt.files.read_damit(path, BOX, pt.observables.LommelSeeliger(albedo=0.2))


def mesh(path):
    return pt.files.read_mesh(path, mass=1.0)


def field(path):
    return pt.files.read_field(path, mass=1.0)


def elements(read, path):
    return read(path.read_text(errors="replace"), *EPOCH)


READERS: dict[str, Any] = {
    "it.nc": pt.load,
    "it.zarr": pt.load,
    "it.aem": pt.files.read_aem,
    "aem.xml": pt.files.read_aem,
    "it.apm": pt.files.read_apm,
    "apm.xml": pt.files.read_apm,
    "it.a": pt.files.read_stk_attitude,
    "it.csv": pt.files.read_quaternion_csv,
    "it.bc": ck.read_ck,
    "it.oem": pt.files.read_oem,
    "it.tle": partial(elements, pt.files.tle_orbit),
    **dict.fromkeys(("it.omm", "omm.json", "omm.csv"), partial(elements, pt.files.omm_orbit)),
    "it.toml": pt.files.read_scenario,
    **dict.fromkeys(("it.gfc", "field.tab"), field),
    **dict.fromkeys(("it.obj", "it.ply", "it.stl", "binary.stl", "plates.tab", "shape.txt"), mesh),
    "readings.nc": pt.files.read_readings,
    "readings.csv": partial(observed, pt.files.read_readings_csv),
    "alcdef.txt": partial(observed, pt.files.read_alcdef),
    "spin.txt": pt.files.read_damit_spin,
    "lc.txt": curves,
}
"""What reads each kind of file, by a name."""

NUMBER = re.compile(rb"(?<![\w.:-])-?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.:])")

BINARY = ("it.nc", "it.bc", "binary.stl", "readings.nc")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A folder with a good file of each kind."""
    folder = tmp_path_factory.mktemp("good")
    for name, write in WRITERS.items():
        write(MOTION, folder / name)
    for name, write in OBSERVATIONS.items():
        write(folder / name)
    pt.save(MOTION, folder / "it.zarr")
    for name in ("it.apm", "apm.xml"):
        pt.files.write_apm(MOTION.system.body, MOTION.initial, folder / name, **NAMED)
    for name, text in TEXTS.items():
        (folder / name).write_text(text(), newline="")
    (folder / "binary.stl").write_bytes(stl(binary=True))
    return folder


def outcome(name, path):
    """What a reader says of a file; it must be something in time and memory."""
    gc.disable()  # a collection of what other tests have left is not the reader's time
    began, peak = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    message = "read"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", UserWarning)
            READERS[name](path)
    except (ValueError, FileNotFoundError) as error:
        message = str(error)
    finally:
        taken = time.process_time() - began
        gc.enable()
    assert message == "read" or any(words in message for words in (" must ", "unknown key", "missing table [")), message
    assert message.isprintable()  # what a terminal obeys is escaped
    assert "Error" not in message.partition(" must ")[0], message
    assert taken < SECONDS
    assert 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) < BYTES
    return message


def tried(good, name, count, seed):
    """How often a changed file was read."""
    path = good / name
    assert outcome(name, path) == "read"
    files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
    read = 0
    for k in range(count):
        rng = np.random.default_rng((seed, *map(ord, name), k))
        file = files[rng.integers(len(files))]
        before = file.read_bytes()
        file.write_bytes(mutant(before, rng, text=name not in BINARY and not file.name[:1].isdigit()))
        read += outcome(name, path) == "read"
        file.write_bytes(before)
    return read


@pytest.mark.parametrize("name", READERS)
def test_files_that_were_changed(good, name):
    assert tried(good, name, 15, 1) < 15


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_many_files_that_were_changed(good, name):
    assert tried(good, name, 500, 2) < 500


@pytest.mark.parametrize("number", [b"1e999", b"-1e999", b"nan"])
@pytest.mark.parametrize("name", sorted(set(READERS) - {*BINARY, "it.zarr"}))
def test_numbers_that_are_infinite_or_none(good, name, number):
    path = good / name
    before = path.read_bytes()
    found = list(NUMBER.finditer(before))
    for one in found[:: len(found) // 40 + 1]:
        path.write_bytes(before[: one.start()] + number + before[one.end() :])
        outcome(name, path)
    path.write_bytes(before)


@pytest.mark.samples
@pytest.mark.parametrize("mark", [b"\x02", b"\x1b[31m", "\u202e".encode()])
@pytest.mark.parametrize("name", sorted(set(READERS) - {*BINARY, "it.zarr"}))
def test_sentences_have_nothing_that_a_terminal_obeys(good, name, mark):
    path = good / name
    before = path.read_bytes()
    found = list(re.finditer(rb"(?<=[\w\"'.])(?=[\s,=<\"'])|(?<=[ =])(?=\w)", before))
    for one in found[:: len(found) // 100 + 1]:
        path.write_bytes(before[: one.start()] + mark + before[one.start() :])
        outcome(name, path)
    path.write_bytes(before)


def test_every_reader_is_tried():
    used = {getattr(reader, "func", reader) for reader in READERS.values()}
    used |= {argument for reader in READERS.values() for argument in getattr(reader, "args", ())}
    names = {function.__name__ for function in used} | {"read_mesh", "read_field"}
    assert {name for name in dir(pt) if name.startswith("read_")} <= names
