"""Compiled kernels: reused for other numbers, bounded in number, and safe among threads."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration import equations
from poinsot.integration.kernel_parameters import PreparedKernel

TIMES = np.linspace(0, 20, 41)


def weighted(body, weight):
    return pt.System(body, pt.UniformGravity(weight, (1.0, 0.2, -0.3)))


@pytest.fixture
def built(forget_kernels):
    """Return a function that counts the kernels that were compiled since."""
    forget_kernels()
    return lambda: sum(isinstance(known, PreparedKernel) for known in equations.known._stored.values())


def test_new_numbers_compile_nothing(built, start):
    for k in range(5):
        body = pt.Body((1.25, 1.0, 0.75 + 0.01 * k))
        pt.propagate(weighted(body, 0.1 + 0.1 * k), start, [0.0, 1.0])
    assert built() == 1


def test_another_structure_formulation_precision_or_tolerance_compiles_a_kernel(built, body, start):
    top = weighted(body, 0.5)
    pt.propagate(top, start, [1.0])
    pt.propagate(pt.System(body), start, [1.0])
    pt.propagate(top, start, [1.0], formulation="canonical")
    pt.propagate(top, start, [1.0], tolerance=1e-9)
    pt.propagate(top, start, [1.0], precision="quadruple")
    assert built() == 5
    pt.propagate(top, start, [1.0], tolerance=1e-9)
    pt.propagate(top, start, [1.0], tolerance=1e-9, dense=True)
    assert built() == 5


def test_answers_are_bounded_and_the_least_recently_used_is_dropped(monkeypatch):
    monkeypatch.setattr(equations, "MAX_STORED", 3)
    answers, asked = equations.Cache(), []
    for key in (1, 2, 3, 1, 4, 2, 1):

        def question(key=key):
            asked.append(key)
            return 10 * key

        assert answers(key, question) == 10 * key
    assert asked == [1, 2, 3, 4, 2]


@pytest.mark.parametrize("precision", ["double", "quadruple"])
def test_a_kernel_remembers_nothing_of_other_runs(body, start, precision):
    top = weighted(body, 0.5)
    first = pt.propagate(top, start, TIMES, precision=precision)
    other = body.state((0, 1, 0, 0), omega_body=(3, 2, 1), time=-7.0)
    pt.propagate(weighted(body, 2.0), other, np.linspace(-7, 30, 5), dense=True, precision=precision)
    again = pt.propagate(top, start, TIMES, precision=precision)
    assert np.array_equal(first.quaternion, again.quaternion)
    assert np.array_equal(first.conjugate_momenta, again.conjugate_momenta)


def test_after_a_stopped_run_of_euler_angles_the_next_one_is_right(body):
    away = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    system = pt.System(body)
    before = pt.propagate(system, away, [0.0, 1.0], formulation="euler_angles")
    into = body.state((np.cos(0.2), np.sin(0.2), 0, 0), omega_body=(-0.3, 0, 0))
    with pytest.raises(pt.PropagationError):
        pt.propagate(system, into, [0.0, 10.0], formulation="euler_angles")
    after = pt.propagate(system, away, [0.0, 1.0], formulation="euler_angles")
    assert np.array_equal(before.quaternion, after.quaternion)


@pytest.mark.parametrize("dense", [False, True])
def test_threads_get_the_results_of_a_single_one(body, start, dense):
    weights = np.linspace(0.1, 2.0, 24)

    def run(weight):
        return pt.propagate(weighted(body, weight), start, TIMES, dense=dense)

    alone = [run(weight) for weight in weights]
    with ThreadPoolExecutor(6) as threads:
        together = list(threads.map(run, weights))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one.quaternion, other.quaternion)
        assert np.array_equal(one.conjugate_momenta, other.conjugate_momenta)


def test_threads_of_several_structures_and_formulations(body, satellite, start):
    jobs = [
        (system, formulation)
        for system in (pt.System(body), weighted(body, 0.5), satellite)
        for formulation in ("lie_poisson", "canonical")
    ] * 4

    def run(job):
        return pt.propagate(job[0], start, TIMES, formulation=job[1]).quaternion

    alone = [run(job) for job in jobs]
    with ThreadPoolExecutor(8) as threads:
        together = list(threads.map(run, jobs))
    assert all(np.array_equal(one, other) for one, other in zip(alone, together, strict=True))


@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="Linux lists the processor's instructions in this file")
def test_vectors_have_eight_lanes_where_the_processor_runs_512_bit_code():
    has_it = "avx512f" in Path("/proc/cpuinfo").read_text().split()
    assert (equations.LANES == 8) == has_it
