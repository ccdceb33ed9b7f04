"""Ensembles on a GPU from end to end, with the CUDA source compiled for the processor."""

import signal
import sys

import numpy as np
import pytest

import cuda_on_cpu
import poinsot as pt
from poinsot.cuda import cuda_kernel
from poinsot.functions import Vector, less, sqrt, where
from poinsot.taylor import kernels

pytestmark = [
    cuda_on_cpu.needs_compiler,
]

COUNT = 100
TIMES = np.linspace(-3.0, 20.0, 12)
BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1.0, 0.2, -0.3)))
RNG = np.random.default_rng(4)
ATTITUDES = RNG.normal(size=(COUNT, 4))
ATTITUDES /= np.linalg.norm(ATTITUDES, axis=-1, keepdims=True)
STARTS = BODY.state(ATTITUDES, omega_body=RNG.normal(0, 1.5, (COUNT, 3)), time=RNG.uniform(-1, 1, COUNT))


@pytest.fixture(autouse=True)
def cupy(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", cuda_on_cpu)


class Edge(pt.Torque):
    """A torque that there is up to a time."""

    instant: float

    def torque(self, instant):
        return 0.1 * sqrt(self.instant - instant.time) * Vector((0.0, 0.3, 0.2))


class Thruster(pt.Torque):
    """A torque that ends at a time."""

    off: float

    def torque(self, instant):
        return where(less(instant.time, self.off), 0.3, 0.0) * Vector((0.5, -1.0, 0.8))


class Sided(pt.Torque):
    """A torque whose formula depends on the sign of a parameter."""

    size: float

    def torque(self, instant):
        w1, w2, w3 = instant.omega_body
        return Vector((where(less(self.size, 0), 0.3 * w2, w1 * w3), self.size * w1, 0.2 * w2))


def assert_same(one, other):
    assert other.failures == one.failures
    assert other.run.steps == one.run.steps
    for rows in ("quaternion", "angular_momentum_body"):
        np.testing.assert_array_equal(getattr(other, rows), getattr(one, rows))


@pytest.mark.parametrize("times", [TIMES, TIMES[::-1], TIMES[:1], np.array([20.0])])
def test_members_are_those_of_the_processor(times):
    assert_same(pt.propagate(TOP, STARTS, times), pt.propagate(TOP, STARTS, times, device="cuda"))


def test_a_parameter_chooses_between_formulas():
    system = pt.System(BODY, Sided(np.array([-0.4, 0.1])))
    start = BODY.state(ATTITUDES[:2], omega_body=(0.1, 0.2, 0.3))
    looped, there = (pt.propagate(system, start, [3.0], device=device) for device in ("cpu", "cuda"))
    assert_same(looped, there)
    # Some ten steps, each of some rounding errors.
    quadruple = pt.propagate(system, start, [3.0], precision="quadruple")
    np.testing.assert_allclose(looped.omega_body, quadruple.omega_body, rtol=1e-13)


@pytest.mark.parametrize("most", [1, 7, 99])
def test_a_device_of_little_memory_takes_them_in_chunks(most, monkeypatch):
    taken = []
    monkeypatch.setattr(cuda_kernel, "most_members", lambda *_: most)
    launch = cuda_kernel.CudaCode.launch

    def counted(code, queue, count):
        taken.append(count)
        launch(code, queue, count)

    monkeypatch.setattr(cuda_kernel.CudaCode, "launch", counted)
    assert_same(pt.propagate(TOP, STARTS, TIMES), pt.propagate(TOP, STARTS, TIMES, device="cuda"))
    assert max(taken) == 2 * most  # in both directions


def test_where_the_memory_is_full_the_chunks_are_halved(monkeypatch):
    """30 members fit, at most; the first chunk that is small enough has 25 or 12."""
    asarray, refused = cuda_on_cpu.asarray, []

    def little(array):
        if array.ndim == 3 and len(array) > 30:
            refused.append(len(array))
            raise cuda_on_cpu.OutOfMemoryError
        return asarray(array)

    monkeypatch.setattr(cuda_on_cpu, "asarray", little)
    assert_same(pt.propagate(TOP, STARTS, TIMES), pt.propagate(TOP, STARTS, TIMES, device="cuda"))
    assert refused == [100, 50]


def test_a_memory_too_small_for_one_member_is_an_error(monkeypatch):
    def none(_):
        raise cuda_on_cpu.OutOfMemoryError("Out of memory allocating 672 bytes")

    monkeypatch.setattr(cuda_on_cpu, "asarray", none)
    with pytest.raises(MemoryError, match="672 bytes"):
        pt.propagate(TOP, STARTS, TIMES, device="cuda")


def test_without_a_device_no_store_is_made(monkeypatch, tmp_path):
    monkeypatch.setattr(cuda_on_cpu.runtime, "getDeviceCount", lambda: 0)
    with pytest.raises(RuntimeError, match="device='cuda' must have a GPU of NVIDIA with its driver, got none"):
        pt.propagate(TOP, STARTS, TIMES, device="cuda", out=tmp_path / "run.zarr")
    assert not [*tmp_path.iterdir()]


def test_members_fail_as_on_the_processor():
    bodies = pt.Body((1.0, 1.3, 1.7))
    system = pt.System(bodies, Edge(np.array([0.5, 30.0, 1.5])))
    start = bodies.state(ATTITUDES[:3], omega_body=(0.1, 0.2, 0.3))
    here, there = (pt.propagate(system, start, TIMES, device=device) for device in ("cpu", "cuda"))
    assert set(here.failures) == {0, 2}
    assert_same(here, there)


def test_many_steps_are_not_steps_that_lead_nowhere(monkeypatch):
    """Members are looked at every five steps."""
    monkeypatch.setattr(kernels, "BUDGET", 5)
    monkeypatch.setattr(cuda_kernel, "FIRST_LAUNCH_STEPS", 1)
    monkeypatch.setattr(cuda_kernel, "MIN_LAUNCH_SECONDS", 0.0)
    here, there = (pt.propagate(TOP, STARTS, TIMES, device=device) for device in ("cpu", "cuda"))
    assert here.run.steps > 20 * COUNT
    assert_same(here, there)


def test_steps_that_lead_nowhere_are_given_up(monkeypatch):
    """A member turns so fast that it would not end; the other one is complete."""
    monkeypatch.setattr(kernels, "BUDGET", 500)
    start = BODY.state(ATTITUDES[:2], omega_body=[(1e14, 2e14, 1e14), (0.1, 0.2, 0.3)])
    motion = pt.propagate(TOP, start, [1.0], device="cuda")
    assert motion.failures.keys() == {0}
    assert "it would not end. The body turns too fast." in motion.failures[0]
    np.testing.assert_array_equal(np.isnan(motion.quaternion[:, 0, 0]), [True, False])


def test_ctrl_c_keeps_the_members_that_are_finished(monkeypatch):
    monkeypatch.setattr(cuda_kernel, "MIN_LAUNCH_SECONDS", 0.0)
    launch, launched = cuda_kernel.CudaWorker._launch, []

    def interrupted(run):
        launch(run)
        launched.append(run)
        if len(launched) == 2:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(cuda_kernel.CudaWorker, "_launch", interrupted)
    start = BODY.state(ATTITUDES[:4], omega_body=np.array([[0.1], [0.2], [0.1], [9.0]]) * (0.3, 1.0, 0.5))
    with pytest.raises(pt.PropagationInterrupted, match="3 of 4 members are done") as stopped:
        pt.propagate(TOP, start, [30.0], device="cuda")
    monkeypatch.undo()
    whole = pt.propagate(TOP, start, [30.0])
    found = stopped.value.trajectory.quaternion
    np.testing.assert_array_equal(found[:3], whole.quaternion[:3])
    assert np.all(np.isnan(found[3]))


@pytest.mark.parametrize(
    ("what", "given"),
    [
        ("one motion", {"state": BODY.state(ATTITUDES[0], omega_body=(0.1, 0.2, 0.3))}),
        ("a formulation with singularities", {"formulation": "euler_angles"}),
        ("precision='quadruple'", {"precision": "quadruple"}),
        ("events", {"events": [pt.events.AtTime(1.0)]}),
        ("a formula that switches", {"system": pt.System(BODY, Thruster(3.0))}),
    ],
)
def test_what_a_gpu_does_not_do_is_refused(what, given):
    call = {"system": TOP, "state": STARTS, "times": TIMES, "device": "cuda"} | given
    with pytest.raises(ValueError, match=f"got {what}.* Leave device out to use the processor."):
        pt.propagate(**call)


def test_a_computer_without_a_gpu_is_refused(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(ImportError, match="cupy must be installed for device='cuda', got none"):
        pt.propagate(TOP, STARTS, TIMES, device="cuda")


def test_another_device_is_refused():
    with pytest.raises(ValueError, match="device must be 'cpu' or 'cuda', got 'gpu'"):
        pt.propagate(TOP, STARTS, TIMES, device="gpu")
