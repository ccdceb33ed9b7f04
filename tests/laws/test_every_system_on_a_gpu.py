"""Every system gives the same bits on a GPU as on the processor; its source is compiled for that."""

import sys

import numpy as np
import pytest

import cuda_on_cpu
import poinsot as pt
from kinds import mutual_gravity, pairs, systems
from kinds.forces import FORCES, label
from kinds.orbits import ORBITS
from kinds.parts import PARTS
from kinds.systems import switches

pytestmark = [
    cuda_on_cpu.needs_compiler,
]

BODY = pt.Body((1.3, 1.0, 0.7))
PART_OF = pt.Body((6.0, 8.0, 10.0))
TIMES = np.array([-0.4, 0.0, 0.9, 2.4])
SYSTEMS = (
    {label(force): (BODY, force) for force in FORCES}
    | {name: (BODY, pt.GravityGradient(orbit)) for name, orbit in ORBITS.items()}
    | {type(part).__name__: (PART_OF, part) for part in PARTS}
    | {name: each for name, each in systems.SYSTEMS.items() if ":" not in name and "table" not in name}
)
PAIRS = {name: pairs.system_of(name) for name in pairs.NAMES} | {
    label(force): pt.System(mutual_gravity.PAIR, force) for force in mutual_gravity.FORCES
}


@pytest.fixture(autouse=True)
def machine(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", cuda_on_cpu)
    for force in FORCES:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


@pytest.mark.samples
@pytest.mark.parametrize(  # each operation has its own test in tests/unit/cuda/test_cuda_kernel.py
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (i % 3 > 0)) for i, name in enumerate(SYSTEMS)]
)
def test_all_bits_are_those_of_the_processor(name):
    system = pt.System(*SYSTEMS[name])
    attitudes = np.array([(0.1, 0.7, -0.5, 0.5), (0.5, 0.5, 0.5, -0.5), (0.8, 0.0, 0.6, 0.0)])
    start = system.state(attitudes, omega_body=[(0.4, -0.3, 0.6), (0.0, 0.0, 1.5), (-0.2, 0.9, 0.1)])
    here = pt.propagate(system, start, TIMES)
    if name == "table" or switches(system):
        what = "a table" if name == "table" else "a formula that switches"
        with pytest.raises(ValueError, match=f"an ensemble of smooth systems without events, got {what}"):
            pt.propagate(system, start, TIMES, device="cuda")
        return
    there = pt.propagate(system, start, TIMES, device="cuda")
    assert not there.failures
    assert there.run.steps == here.run.steps
    for rows in ("quaternion", "angular_momentum_body"):
        np.testing.assert_array_equal(getattr(there, rows), getattr(here, rows))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (i > 0)) for i, name in enumerate(PAIRS)]
)
def test_all_bits_of_two_bodies_are_those_of_the_processor(name):
    start = pairs.start_of(PAIRS[name], shift=np.linspace(0, 0.5, 3)[:, None] * (0.3, -0.8, 0.2))
    here, there = (pt.propagate(PAIRS[name], start, TIMES, device=device) for device in ("cpu", "cuda"))
    assert (there.run.kernel, there.run.steps) == ("cuda", here.run.steps)
    np.testing.assert_array_equal(pairs.rows(there), pairs.rows(here))
