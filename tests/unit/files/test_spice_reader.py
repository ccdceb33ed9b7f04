"""Kernels of SPICE that strangers send: each is read, or ends in one sentence, and never ends this process."""

import os
import signal
import time

import numpy as np
import pytest
import spiceypy as spice

import poinsot as pt
from fuzzing import mutant
from poinsot.files import reader_process
from poinsot.files.attitudes import ck
from tumbling import MOTION, NAMED

pytestmark = pytest.mark.filterwarnings(
    "ignore:Ephemeris. the periapsis:UserWarning",
    "ignore:the position relative to EARTH must be continuous:UserWarning",  # of types 2 and 3, between their records
)

PROBE, EARTH = -1000, 399
TIMES = np.arange(0.0, 3001.0, 100.0)


def states():
    x, y = np.cos(TIMES / 900), np.sin(TIMES / 900)
    return np.ascontiguousarray(np.stack([7e3 * x, 7e3 * y, 0 * x, -7.8 * y, 7.8 * x, 0 * x], axis=-1))


SPK = {
    "2": lambda *of: spice.spkw02(*of, "it", 1000.0, 3, 3, np.linspace(7e3, 8e3, 36), 0.0),
    "3": lambda *of: spice.spkw03(*of, "it", 1000.0, 3, 3, np.linspace(7e3, 8e3, 72), 0.0),
    "5": lambda *of: spice.spkw05(*of, "it", 398600.4, TIMES.size, states(), TIMES),
    "8": lambda *of: spice.spkw08(*of, "it", 3, TIMES.size, states(), 0.0, 100.0),
    "9": lambda *of: spice.spkw09(*of, "it", 5, TIMES.size, states(), TIMES),
    "12": lambda *of: spice.spkw12(*of, "it", 7, TIMES.size, states(), 0.0, 100.0),
    "13": lambda *of: spice.spkw13(*of, "it", 7, TIMES.size, states(), TIMES),
}
"""What writes a segment of each type."""


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """The bytes of kernels, by their names."""
    folder, found = tmp_path_factory.mktemp("kernels"), {}
    for kind, write in SPK.items():
        path = folder / f"{kind}.bsp"
        handle = spice.spkopn(str(path), "it", 0)
        write(handle, PROBE, EARTH, "J2000", 0.0, 3000.0)
        spice.spkcls(handle)
        found[path.name] = path.read_bytes()
    for path in pt.files.write_ck(MOTION, folder / "it.bc", **NAMED):
        found[path.name] = path.read_bytes()
    return found


def orbit(path):
    return pt.files.spice_orbit(str(PROBE), str(EARTH), 100.0, 2000.0, [path], mu=398600.4)


def attitudes(path):
    return ck.read_ck(path)


def outcome(read, path):
    """What a reader does with a file: True if it reads it, False if it says a sentence in time; processes stay."""
    before, began = reader_process._clean["poinsot.files.spice_reader"].process.pid, time.process_time()
    message = " must "
    try:
        read(path)
    except ValueError as error:
        message = str(error)
    assert " must " in message
    assert "\n" not in message
    assert time.process_time() - began < 1
    assert reader_process._clean["poinsot.files.spice_reader"].process.pid == before
    return message == " must "


def tried(good, folder, count, seed):
    """The number of mutants that are read, and of those that are not."""
    for name, content in good.items():
        (folder / name).write_bytes(content)
    assert orbit(folder / "13.bsp").span == (100.0, 2000.0)
    assert attitudes(folder / "it.bc").times.size == MOTION.times.size
    names, results = [name for name in good if name.endswith((".bsp", ".bc"))], []
    for k in range(count):
        rng = np.random.default_rng((seed, k))
        path = folder / names[k % len(names)]
        content = path.read_bytes()
        path.write_bytes(mutant(content, rng, text=False))
        results.append(outcome(orbit if path.suffix == ".bsp" else attitudes, path))
        path.write_bytes(content)
    return results.count(True), results.count(False)


def test_kernels_that_were_changed(good, tmp_path):
    read, refused = tried(good, tmp_path, 64, 1)
    assert read > 5
    assert refused > 20


@pytest.mark.slow
def test_two_thousand_kernels_that_were_changed(good, tmp_path):
    read, refused = tried(good, tmp_path, 2000, 2)
    assert read + refused == 2000


def test_every_type_of_orbit_is_read(good, tmp_path):
    for kind in SPK:
        path = tmp_path / f"{kind}.bsp"
        path.write_bytes(good[path.name])
        assert orbit(path).span == (100.0, 2000.0)


# ------------------------------------------------------------------ the process


@pytest.fixture(params=[True, False], ids=["forked", "spawned"])
def either(request, monkeypatch):
    """Processes that are forked, and those of systems that cannot fork."""
    monkeypatch.setattr(reader_process, "FORKS", request.param)


@pytest.mark.usefixtures("either")
def test_a_reader_that_dies_is_reported_and_another_one_starts():
    process = reader_process.ReaderProcess("poinsot.files.spice_reader", "it must be whole, got ")
    os.kill(process._process.pid, signal.SIGSEGV)
    with pytest.raises(ValueError, match=r"^it must be whole, got its reader leaves the memory that it has\.$"):
        process.call("name_and_mu", 399)
    process.close()
    process = reader_process.ReaderProcess("poinsot.files.spice_reader", "it must be whole, got ")
    assert process.call("name_and_mu", 399)[0] == ["EARTH", None]
    process.close()


@pytest.mark.parametrize("ends", ["clean", "this"])
def test_the_process_that_is_forked_may_end_too(ends):
    """Killed by the system, or left to the parent by a fork of this process."""
    module = "poinsot.files.spice_reader"
    reader_process.ReaderProcess(module, "it: ").close()
    if ends == "clean":
        process = reader_process._clean[module].process
        process.kill()
        process.wait()
    else:
        child = os.fork()
        if not child:
            try:
                ours = reader_process.ReaderProcess(module, "it: ")
                os._exit(0 if ours.call("name_and_mu", 399)[0] == ["EARTH", None] else 1)
            finally:
                os._exit(2)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    another = reader_process.ReaderProcess(module, "it: ")
    assert another.call("number", "", "EARTH")[0] == 399
    another.close()


@pytest.mark.usefixtures("either")
def test_limits_of_the_process(tmp_path):
    module = "poinsot.files.spice_reader"
    process = reader_process.ReaderProcess(module, "it: ")
    many = [np.zeros(20_000_000)]
    with pytest.raises(ValueError, match=r"^it: |little more memory than its size"):
        process.call("turned", "ECLIPJ2000", "J2000", arrays=many)
    process.close()
    process = reader_process.ReaderProcess(module, "it: ")
    with pytest.raises(ValueError, match=r"^it: it takes too much processor time\.$"):
        process.call("turned", "ECLIPJ2000", "J2000", arrays=[np.zeros(200_000)], seconds=-0.9)
    process.close()
    (tmp_path / "it.tf").write_text("KPL/FK\n")
    process = reader_process.ReaderProcess(module, "it: ")
    with pytest.raises(ValueError, match=r"got SPICE\(FILE"):
        process.call("load", str(tmp_path / "it.tf"))
    process.close()


@pytest.mark.usefixtures("either")
def test_a_process_ends_after_its_time(monkeypatch):
    monkeypatch.setattr(reader_process, "ELAPSED_PER_PROCESSOR_SECOND", 0.01)
    process = reader_process.ReaderProcess("poinsot.files.spice_reader", "it: ")
    with pytest.raises(ValueError, match=r"^it: it takes too long\.$"):
        process.call("turned", "ECLIPJ2000", "J2000", arrays=[np.zeros(100_000)], seconds=1.0)
    process.close()


@pytest.mark.usefixtures("either")
def test_files_are_read(good, tmp_path):
    (tmp_path / "13.bsp").write_bytes(good["13.bsp"])
    assert orbit(tmp_path / "13.bsp").span == (100.0, 2000.0)
    pt.save(MOTION, tmp_path / "it.nc")
    np.testing.assert_array_equal(pt.load(tmp_path / "it.nc").quaternion, MOTION.quaternion)
    (tmp_path / "it.nc").write_bytes((tmp_path / "it.nc").read_bytes()[:3000])
    with pytest.raises(ValueError, match="must be"):
        pt.load(tmp_path / "it.nc")


def test_a_kernel_loads_no_other(tmp_path):
    for name, (text, got) in {"it.tm": ("KPL/MK\n", "a meta-kernel"), "it.tf": ("KPL/FK\n", "one that does")}.items():
        path = tmp_path / name
        path.write_text(f"{text}\\begindata\nKernels_To_Load = ( '{tmp_path / 'other.tf'}' )\n\\begintext\n")
        with pytest.raises(ValueError, match=rf"must be a kernel that loads no others, got {got}\. Name "):
            pt.files.spice_attitude("J2000", [0.0], [path])
    for head in (b"DAS/DSK ", b"DAF/EK  ", b"NAIF/DAF", b"DAFETF N", b"\\begindata\n"):
        path.write_bytes(head + bytes(3000))
        with pytest.raises(ValueError, match=r"must be a (whole )?SPICE kernel"):
            pt.files.spice_attitude("J2000", [0.0], [path])
