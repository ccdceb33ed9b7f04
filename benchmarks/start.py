"""Processor time and memory of the first motion of a process, now and at an earlier commit, side by side."""

import io
import json
import os
import statistics
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

from benchmarks.measure import pin

ROOT = Path(__file__).parents[1]

THEN = "64d5040b"
"""The commit to compare with."""

MEASURED = """
import json, time
import numpy as np
began = time.process_time()
{}
seconds = time.process_time() - began
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print(json.dumps({{"seconds": seconds, "memory": int(status["VmHWM"].split()[0]) / 1024}}))
"""
"""Program that prints its processor time after the import of NumPy, s, and its peak memory, MB."""

MOTION = """
import poinsot as pt
top = pt.System(pt.Body((1.25, 1.0, 0.75)), pt.UniformGravity(weight=0.5, center_of_mass=(1, 0, 0)))
attitude, momenta = (0.5, -(2**-0.5), 0, 0.5), (0.3, -0.6 * 2**0.5, 0.1 * 2**0.5, -1.5)
motion = pt.propagate(top, pt.State(quaternion=attitude, conjugate_momenta=momenta), np.linspace(0, 10, 11))
motion.quaternion
"""
"""The first motion of P2, written out, so that earlier versions run it too."""


def first_motion(short):
    """Return the median processor time and memory of processes with one motion, by version, and of the import alone.

    Bytecode and kernels come from the first turn, as after an installation; the versions alternate.
    """
    pin(1)
    with tempfile.TemporaryDirectory() as folder:
        sources = {"now": (ROOT / "src", MOTION), "names": (ROOT / "src", "import poinsot")}
        if (older := _source(Path(folder))) is not None:
            sources["then"] = (older, MOTION)
        found = {name: [] for name in sources}
        for turn in range(4 if short else 16):
            for name, (source, program) in sources.items():
                one = _measured(source, program, folder)
                if turn:
                    found[name].append(one)
    return {
        name: {what: statistics.median(one[what] for one in each) for what in each[0]} for name, each in found.items()
    }


def _source(folder):
    """Return the folder of the package at `THEN`; None without the repository or what this commit needs."""
    archive = subprocess.run(["git", "archive", THEN, "src"], capture_output=True, cwd=ROOT, check=False)
    if archive.returncode:
        return None
    with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as files:
        files.extractall(folder / "then", filter="data")
    try:
        _measured(folder / "then" / "src", MOTION, str(folder))
    except subprocess.CalledProcessError:  # heyoka is missing
        return None
    return folder / "then" / "src"


def _measured(source, program, folder):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment |= {"PYTHONPATH": str(source), "PYTHONPYCACHEPREFIX": f"{folder}/bytecode", "POINSOT_CACHE": folder}
    command = [sys.executable, "-c", MEASURED.format(program)]
    return json.loads(subprocess.run(command, capture_output=True, check=True, env=environment).stdout)
