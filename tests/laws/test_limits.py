"""What strangers may send: each reader ends in one sentence, within a second and 200 MB, in a process of its own."""

import json
import os
import re
import resource
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import pytest

import poinsot as pt

HUGE = 10**9

AEM = """\
CCSDS_AEM_VERS = 2.0
META_START
REF_FRAME_A = ICRF
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = TAI
ATTITUDE_TYPE = QUATERNION
META_STOP
DATA_START
"""

HEADS = {
    "nc": b"\x89HDF\r\n\x1a\n",
    "toml": b"",
    "aem": AEM.encode(),
    "apm": b"CCSDS_APM_VERS = 2.0\n",
    "a": b"stk.v.11.0\nBEGIN Attitude\n",
    "csv": b"# order: scalar first\n# direction: body to reference\nt,q0,q1,q2,q3\n",
    "oem": b"CCSDS_OEM_VERS = 2.0\n",
    "bsp": b"DAF/SPK ",
    "bc": b"DAF/CK  ",
    "gfc": b"begin_of_head\nend_of_head\n",
    "obj": b"v 0 0 0\n",
    "ply": b"ply\nformat ascii 1.0\n",
    "stl": b"solid\n",
}

READERS: dict[str, Any] = {
    "nc": pt.load,
    "toml": pt.files.read_scenario,
    "aem": pt.files.read_aem,
    "xml": pt.files.read_aem,
    "apm": pt.files.read_apm,
    "a": pt.files.read_stk_attitude,
    "csv": pt.files.read_quaternion_csv,
    "oem": pt.files.read_oem,
    "bsp": lambda path: pt.files.spice_orbit("-77", "399", 0.0, 9.0, [path]),
    "bc": lambda path: pt.files.spice_attitude("IT", [0.0], [path]),
    "gfc": lambda path: pt.files.read_field(path, mass=1.0),
    **dict.fromkeys(("obj", "ply", "stl", "tab"), lambda path: pt.files.read_mesh(path, mass=1.0)),
}


def seconds(count):
    """Rows of attitudes, the last one cut off."""
    days = ((d, h, m, s) for d in range(1, 9) for h in range(24) for m in range(60) for s in range(60))
    rows = (
        f"2026-01-{d:02}T{h:02}:{m:02}:{s:02} 0 0 0 1\n" for (d, h, m, s), _ in zip(days, range(count), strict=False)
    )
    return "".join(rows)[:-4]


def contents():
    """Yield hostile files by their names, as bytes or as a length."""
    for suffix, head in HEADS.items():
        yield f"zeros.{suffix}", b"", HUGE
        yield f"head.{suffix}", head, HUGE
        yield f"empty.{suffix}", b"", 0
        yield f"noise.{suffix}", head + bytes(range(256)) * 400, None
        yield f"lines.{suffix}", head + b"a = 1\n" * 110_000, None
        if suffix in ("aem", "gfc", "obj", "stl"):
            yield f"more.{suffix}", head + b"1 2 3 4 5\n" * 1_500_000, None
    yield "rows.aem", AEM.encode() + seconds(110_000).encode(), None
    yield "rows.csv", HEADS["csv"] + b"".join(b"%d,1,0,0,0\n" % i for i in range(110_000)) + b"x", None
    yield "spaces.apm", HEADS["apm"] + b"A = x" + b" " * 1_000_000 + b"y\n", None
    yield "tags.xml", b"<aem>" + b"<a/>" * 390_000 + b"</aem>", None
    yield "deep.xml", b"<aem>" + b"<a>" * 190_000 + b"</a>" * 190_000 + b"</aem>", None
    yield "many.xml", b"<aem>" + b"<a/>" * 4_000_000 + b"</aem>", None
    yield "attributes.xml", b"<aem " + b" ".join(b'a%d="1"' % i for i in range(1_000_000)) + b"/>", None
    yield "bomb.xml", b'<!DOCTYPE a [<!ENTITY b "bb"><!ENTITY c "&b;&b;&b;&b;">]><aem>&c;</aem>', None
    yield "million.toml", b"".join(b"k%d = 1\n" % i for i in range(1_000_000)), None
    yield "nested.toml", b"a = " + b"[" * 4000, None
    yield "points.obj", b"v 1 2 3\n" * 7_000_000, None
    yield "points.tab", b"v 1 2 3\n" * 7_000_000, None
    yield "numbers.tab", b"1000000 2000000\n" + b"1 2 3 4\n" * 100_000, None
    yield "points.stl", b"v 1 2 3\n" * 7_000_000, None


def measured(path):
    """Return seconds of work, MB more than before, and the error message of a file, read in a child of this process."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        peak, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
        try:
            with warnings.catch_warnings(action="ignore"):
                message = f"nothing, but {READERS[path.suffix[1:]](path)}"[:100]
        except (ValueError, OSError) as error:
            message = str(error)
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) / 1024
        os.write(writing, json.dumps([time.process_time() - began, grown, message[:1000]]).encode())
        os._exit(0)
    os.close(writing)
    os.waitpid(child, 0)
    with os.fdopen(reading) as stream:
        return json.loads(stream.read())


def measure(folder):
    """Print what each file took, as JSON."""
    import astropy.time
    import netCDF4
    import spiceypy
    import trimesh.exchange.obj  # noqa: F401
    import xarray

    from poinsot.scenarios.schema import scenario_model

    assert astropy.time
    assert netCDF4
    assert spiceypy
    assert xarray
    scenario_model()
    found = []
    for name, content, size in contents():
        path = Path(folder) / name
        with path.open("wb") as stream:
            stream.write(content)
            if size:
                stream.truncate(size)
        found.append((name, *measured(path)))
        path.unlink()
    sys.stdout.write(json.dumps(found))


def test_each_ends_in_a_sentence_within_a_second_and_200_mb(tmp_path):
    for name in ("astropy", "netCDF4", "spiceypy", "trimesh"):
        pytest.importorskip(name)
    import forked

    done = forked.run(Path(__file__).read_text(), tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len({name for name, *_ in found}) == len(found) > 5 * len(HEADS)
    for name, took, grown, message in found:
        assert took < 1, (name, took)
        assert grown < 200, (name, grown)
        assert re.search(" must .*, (but|got) |missing table", message), (name, message)


if __name__ == "__main__":
    measure(sys.argv[1])
