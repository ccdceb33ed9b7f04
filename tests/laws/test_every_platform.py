"""Object code of kernels for six platforms takes no symbol from elsewhere that the package does not give it there.

The code is emitted, not run.
"""

import subprocess
import sys

import llvmlite.binding as llvm
import pytest

from object_symbols import undefined
from poinsot.taylor.object_cache import symbols_of

PLATFORMS = {
    "x86_64-unknown-linux-gnu": ("Linux", "x86-64-v3"),
    "aarch64-unknown-linux-gnu": ("Linux", "neoverse-n1"),
    "x86_64-apple-macosx11.0": ("Darwin", "x86-64-v3"),
    "arm64-apple-macosx11.0": ("Darwin", "apple-m1"),
    "x86_64-pc-windows-msvc": ("Windows", "x86-64-v3"),
    "aarch64-pc-windows-msvc": ("Windows", "generic"),
}
"""System and processor of each target of LLVM."""

MODULES = """
import itertools, sys
import numpy as np
from pathlib import Path
from poinsot.taylor import object_cache

plain, numbers = object_cache.machine_code, itertools.count()

def noted(text):
    Path(sys.argv[1], f"{next(numbers)}.ll").write_text(text)
    return plain(text)

object_cache.machine_code = noted
import poinsot as pt
from poinsot.integration import equations

equations.LANES = 4

orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1)
body = pt.Body((1.25, 1.0, 0.75))
start = body.state((0, 0.6, 0, 0.8), omega_body=(0.0, 1e-3, 2e-3))
starts = body.state((0, 0.6, 0, 0.8), omega_body=np.array([[0.0, 1e-3, 2e-3]] * 20))
top = pt.System(body, pt.UniformGravity(weight=0.5, center_of_mass=(1, 0, 0)))
satellite = pt.System(body, pt.GravityGradient(orbit))
pt.propagate(top, start, [0.0, 1.0])
pt.propagate(top, start, [0.0, 1.0], formulation="euler_angles")
pt.propagate(satellite, starts, [0.0, 1.0])
pt.propagate(satellite, start, [0.0, 1.0], events=[pt.events.Apsis(orbit)])
pt.propagate(satellite, start, [0.0, 1.0], precision="quadruple")
pt.analysis.state_transition(top, start, [0.0, 1.0], order=2)
"""
"""Runs of one body and of members, with an orbit, with other charts and precisions, and with second variations, whose
functions need more than 4 KB on the stack."""


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    """Return the texts of the modules that some runs compile."""
    folder = tmp_path_factory.mktemp("modules")
    subprocess.run([sys.executable, "-c", MODULES, str(folder)], check=True)
    texts = [path.read_text() for path in sorted(folder.iterdir())]
    assert len(texts) >= 6
    return texts


@pytest.mark.samples
@pytest.mark.parametrize("triple", PLATFORMS)
def test_object_code_needs_what_the_platform_has(modules, triple):
    system, processor = PLATFORMS[triple]
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=processor, opt=1)
    needed = set()
    for text in modules:
        module = llvm.parse_assembly(text)
        module.triple, module.data_layout = triple, str(machine.target_data)
        needed |= undefined(machine.emit_object(module))
    assert needed - {"_fltused"} - {*symbols_of(system)} == set()
    assert "log2" in needed  # the symbols are read
    assert ("_fltused" in needed) == triple.startswith("x86_64-pc-windows")
    assert ("__chkstk" in needed) == (system == "Windows")
