"""The kernel in CUDA C, compiled for the processor, against the one in LLVM's representation."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

import cuda_on_cpu
from poinsot.cuda import cuda_kernel
from poinsot.taylor import kernels
from poinsot.taylor.decomposition import Coefficient, Momenta
from poinsot.taylor.queue import FOREVER, Output, Queue, Worker
from poinsot.taylor.tasks import Status
from unit.taylor.test_kernels import DECOMPOSITIONS, ORDER, SYSTEMS, decomposed, starts, with_slopes

pytestmark = [
    cuda_on_cpu.needs_compiler,
]

RESULTS = ("state", "time", "status", "steps", "index", "exponent", "pause")
TOP = DECOMPOSITIONS["top"]


@pytest.fixture(autouse=True)
def cupy(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", cuda_on_cpu)


@pytest.fixture
def few_steps(monkeypatch):
    """Seven steps a launch."""
    monkeypatch.setattr(cuda_kernel, "FIRST_LAUNCH_STEPS", 7)
    monkeypatch.setattr(cuda_kernel, "MIN_LAUNCH_SECONDS", 0.0)


def queue_of(code, states, times, parameters=None):
    """Return tasks from t = 0 in both directions to rising times; results are in `tasks` and `output.rows`."""
    count, times = len(states), np.asarray(times, dtype=float)
    place, m = int(np.searchsorted(times, 0.0)), len(times)
    ways = [way for way, some in ((1, place < m), (-1, place > 0)) if some]
    way, rows = np.repeat(ways, count), np.full((count, m, code.variables), np.nan)
    members, first = np.tile(np.arange(count), len(ways)), np.where(way > 0, place, place - 1)
    output = Output.of(times, rows, members, first, np.where(way > 0, m - place, place), way)
    numbers = np.zeros((count, 0)) if parameters is None else np.asarray(parameters)
    return Queue(code, states[members], np.zeros(way.size), numbers[members], output)


def begun(run, queue):
    run.start(queue)
    return run


def done(run):
    """Let a run do all that is to do, and return how many launches or chunks of steps it takes."""
    count = 1
    while run.advance():
        count += 1
    run.finish()
    return count


def on_both(decomposition, states, times, parameters=None):
    """Return queues that the processor's kernel and the other one have worked on."""
    own = kernels.compiled(decomposition, ORDER, 4)
    other = cuda_kernel.compiled(decomposition, ORDER)
    queues = [queue_of(code, states, times, parameters) for code in (own, other)]
    done(begun(Worker(own), queues[0]))
    done(begun(cuda_kernel.CudaWorker(other), queues[1]))
    return queues


def assert_same(one, other):
    np.testing.assert_array_equal(other.output.rows, one.output.rows)
    for name in RESULTS:
        np.testing.assert_array_equal(other.tasks[name], one.tasks[name], err_msg=name)


def every_function():
    """Return the decomposition of rates that are the values of all elementary functions."""
    symbols, exact = with_slopes()

    def rates(_, time):
        return symbols(0.1 * (time * time) + 0.3 * time + 0.4, -0.2 * time + 0.5).values()

    return decomposed(len(exact), rates, parameters=1), len(exact)


@pytest.mark.parametrize("name", SYSTEMS)
def test_all_bits_are_those_of_the_kernel_for_the_processor(name):
    end = SYSTEMS[name][1]
    own, other = on_both(DECOMPOSITIONS[name], starts(name, 70), np.linspace(-0.3 * end, end, 23))
    assert np.all(own.tasks["status"] == Status.DONE)
    assert_same(own, other)


def test_so_are_those_of_every_elementary_function():
    decomposition, count = every_function()
    assert_same(*on_both(decomposition, np.zeros((2, count)), [-0.1, 0.1, 0.3], parameters=[[0.3], [0.4]]))


@pytest.mark.usefixtures("few_steps")
def test_so_are_those_of_momenta_that_are_rescaled():
    """m' = -k m + f and x' = g m, as a test of the other kernel has it; in launches of seven steps."""
    momenta = Momenta((0, 1), (0, 1), (0, 1, -1))

    def rates(states, _):
        m1, m2, _ = states
        k = Coefficient(-1.0, 0)
        return [k * m1 + Coefficient(1.0, 1), k * m2 - 0.5 * m1, Coefficient(1.0, 2) * m1]

    states = np.array([[0.8, 0.0, 0.5], [0.05, 0.0, 0.5], [0.8, 0.0, 0.5]])
    parameters = [[1.0, 0.0, 0.25], [-1.0, 0.0, 0.25], [1.0, 1e-6, 0.25]]
    decomposition = decomposed(3, rates, 3, momenta=momenta)
    own, other = on_both(decomposition, states, [5.0, 15.0, 25.0], parameters)
    assert np.all(np.abs(own.tasks["exponent"]) > 10)
    assert_same(own, other)


def test_members_fail_as_there():
    """x' = x^2/100 + sqrt(y), y' = -1/100: infinite where x is large at the start, not finite where y is negative."""
    decomposition = decomposed(
        2, lambda x, _: [0.01 * (x[0] * x[0]) + x[1].function("sqrt", slopes=lambda own: (0.5 / own,)), -0.01]
    )
    states = np.array([[-1.0, 9.0], [2.0, 9.0], [-1.0, -1.0], [-2.0, 9.0], [-1.5, 9.0]])
    own, other = on_both(decomposition, states, [5.0, 9.0])
    assert {Status.DONE, Status.STALLED, Status.NOT_FINITE} == set(own.tasks["status"])
    assert_same(own, other)


@pytest.mark.usefixtures("few_steps")
def test_launches_of_few_steps_change_no_bit():
    states, times = starts("top", 70), np.linspace(-20.0, 30.0, 40)
    own, other = on_both(TOP, states, times)
    assert_same(own, other)
    code = cuda_kernel.compiled(TOP, ORDER)
    assert done(begun(cuda_kernel.CudaWorker(code), queue_of(code, states, times))) == -(
        -np.max(own.tasks["steps"]) // 7
    )


@pytest.mark.usefixtures("few_steps")
def test_tasks_that_pause_go_on_when_they_are_put_back():
    states, times = starts("top", 6), np.linspace(0.0, 30.0, 40)[1:]
    code = cuda_kernel.compiled(TOP, ORDER)
    at_once, queue = queue_of(code, states, times), queue_of(code, states, times)
    done(begun(cuda_kernel.CudaWorker(code), at_once))
    queue.tasks["pause"][:4], run = 10, begun(cuda_kernel.CudaWorker(code), queue)
    done(run)
    paused = np.flatnonzero(queue.tasks["status"] == Status.PAUSED)
    np.testing.assert_array_equal(paused, range(4))
    np.testing.assert_array_equal(queue.tasks["steps"][paused], 10)
    queue.tasks["pause"] = FOREVER
    queue.put(paused)
    done(run)
    assert_same(at_once, queue)


@pytest.mark.usefixtures("few_steps")
def test_what_is_done_is_there_when_a_run_is_left():
    states, times = starts("top", 2), [1.0, 300.0]
    code = cuda_kernel.compiled(TOP, ORDER)
    queue = queue_of(code, states, times)
    run = begun(cuda_kernel.CudaWorker(code), queue)
    assert run.advance()
    assert np.all(np.isnan(queue.output.rows))
    run.finish()
    np.testing.assert_array_equal(queue.tasks["status"], Status.PAUSED)
    np.testing.assert_array_equal(queue.tasks["steps"], 7)
    np.testing.assert_array_equal(np.isnan(queue.output.rows[..., 0]), [[False, True]] * 2)


def test_launches_take_neither_seconds_nor_an_instant(monkeypatch):
    """Four steps at first; the clock makes a launch last 0.01 s a step."""
    now, launched = [0.0], []
    monkeypatch.setattr(cuda_kernel, "FIRST_LAUNCH_STEPS", 4)
    monkeypatch.setattr(cuda_kernel, "clock", SimpleNamespace(perf_counter=lambda: now[0]))
    code = cuda_kernel.compiled(TOP, ORDER)
    queue = queue_of(code, starts("top"), [100.0])
    run = begun(cuda_kernel.CudaWorker(code), queue)
    launch = run._launch

    def timed():
        launch()
        launched.append(run._budget)
        now[0] += 0.01 * run._budget

    monkeypatch.setattr(run, "_launch", timed)
    done(run)
    assert launched[:4] == [4, 8, 16, 16]
    run._budget, before = 100, len(launched)
    queue.put(np.array([0]))
    done(run)
    assert launched[before:][:1] == [100]
    assert run._budget == 50


def test_a_product_and_a_sum_are_rounded_one_by_one():
    assert "--fmad=false" in cuda_kernel.OPTIONS
    assert "fma(" in cuda_kernel.compiled(TOP, ORDER).source


def test_a_computer_without_cupy_is_refused(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)
    message = r"cupy must be installed for device='cuda', got none. `pip install 'poinsot\[cuda\]'` brings it."
    with pytest.raises(ImportError, match=message):
        cuda_kernel.check_device()


@pytest.mark.parametrize("driver", ["none", "no device"])
def test_a_computer_without_a_device_is_refused(driver, monkeypatch):
    def count():
        if driver == "none":
            raise cuda_on_cpu.CUDARuntimeError("cudaErrorInsufficientDriver")
        return 0

    monkeypatch.setattr(cuda_on_cpu.runtime, "getDeviceCount", count)
    with pytest.raises(RuntimeError, match="device='cuda' must have a GPU of NVIDIA with its driver, got none"):
        cuda_kernel.check_device()


def test_the_memory_of_the_device_limits_the_members(monkeypatch):
    code = cuda_kernel.compiled(TOP, ORDER)
    each = 8 * 1000 * 7 + 2 * (code.context.task.itemsize + 8)
    assert cuda_kernel.most_members(code, 1000) == 2**30 // each
    monkeypatch.setattr(cuda_on_cpu.runtime, "memGetInfo", lambda: (10 * each + 2, 2**34))
    assert cuda_kernel.most_members(code, 1000) == 5
    monkeypatch.setattr(cuda_on_cpu.runtime, "memGetInfo", lambda: (each, 2**34))
    assert cuda_kernel.most_members(code, 1000) == 1
