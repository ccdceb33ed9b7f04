"""Processor time of the first call of a process, with an empty cache of machine code and with the code on disk."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import poinsot as pt
from benchmarks.fields import OMEGA, ORBIT, _field
from benchmarks.measure import pin
from benchmarks.problems import P2
from poinsot.integration import equations
from poinsot.taylor import kernels

CASES = {
    "P2": (None, 0),
    "gravity of degree 4": (4, 0),
    "gravity of degree 4, second variations": (4, 2),
    "gravity of degree 8, second variations": (8, 2),
}
"""The degree of the field, and the order of the variations."""


def first_calls(short):
    """Return seconds of processor time of first calls and of the preparation of their equations, and operations."""
    pin(1)
    return {name: _measured(name, 1 if short else 5) for name in [*CASES][: 2 if short else None]}


def _measured(name, repeats):
    found = {"compiled": [], "from disk": []}
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            for way in found:
                environment = os.environ | {"POINSOT_CACHE": folder}
                program = [sys.executable, "-m", "benchmarks.first_calls", name]
                done = subprocess.run(program, env=environment, check=True, capture_output=True, text=True)
                found[way].append(json.loads(done.stdout))
    out = {"operations": found["compiled"][0]["operations"]}
    for way, each in found.items():
        out[way] = statistics.median(one["call"] for one in each)
        out[f"{way}, preparation"] = statistics.median(one["preparation"] for one in each)
    return out


def _system(degree):
    if degree is None:
        return P2.system, P2.start
    field = _field(degree)
    body = pt.Body.from_inertia(field.inertia_deviator + 0.4 * np.eye(3))
    system = pt.System(body, pt.forces.HarmonicGravity(ORBIT, field))
    return system, body.state((0.5, 0.5, -0.5, 0.5), omega_body=OMEGA)


def _one(name):
    """Print the figures of a first call of this process."""
    (degree, order), spent, sizes = CASES[name], [], []
    system, start = _system(degree)

    def timed(module, function):
        plain = getattr(module, function)

        def wrapped(*given):
            began = time.process_time()
            result = plain(*given)
            spent.append(time.process_time() - began)
            return result

        setattr(module, function, wrapped)

    compiled = kernels.compiled

    def noted(decomposition, *given):
        sizes.append(decomposition.size)
        return compiled(decomposition, *given)

    setattr(kernels, "compiled", noted)  # noqa: B010
    for module, function in ((equations, "_traced"), (equations, "_program"), (kernels, "compiled")):
        timed(module, function)
    began = time.process_time()
    if order:
        pt.analysis.state_transition(system, start, [0.0, 1.0], order=order)
    else:
        pt.propagate(system, start, [0.0, 1.0])
    print(json.dumps({"call": time.process_time() - began, "preparation": sum(spent), "operations": max(sizes)}))


if __name__ == "__main__":
    _one(sys.argv[1])
