"""The pool of built integrators: reused, bounded, safe among threads."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.engine import kernels

TIMES = np.linspace(0, 20, 41)


@pytest.fixture
def built(monkeypatch, forget_kernels, request):
    """An empty pool, and the list of what heyoka built since."""
    request.getfixturevalue("heyoka_alone")
    record, build = [], kernels._build

    def recorded(*arguments, **options):
        record.append(arguments)
        return build(*arguments, **options)

    forget_kernels()
    monkeypatch.setattr(kernels, "_build", recorded)
    return record


def weighted(body, weight):
    return pt.System(body, pt.UniformGravity(weight, (1.0, 0.2, -0.3)))


def idle():
    return sum(len(waiting) for waiting in kernels._pool._idle.values())


def test_new_numbers_build_nothing(built, start):
    for k in range(5):
        body = pt.Body((1.25, 1.0, 0.75 + 0.01 * k))
        pt.propagate(weighted(body, 0.1 * k), start, [0.0, 1.0])
    assert len(built) == 1
    assert idle() == 1


def test_another_structure_formulation_precision_or_tolerance_builds_anew(built, body, start):
    top = weighted(body, 0.5)
    pt.propagate(top, start, [1.0])
    pt.propagate(pt.System(body), start, [1.0])
    pt.propagate(top, start, [1.0], formulation="canonical")
    pt.propagate(top, start, [1.0], tolerance=1e-9)
    pt.propagate(top, start, [1.0], precision="extended") if kernels.available("extended") else built.append(None)
    assert len(built) == 5
    pt.propagate(top, start, [1.0], tolerance=1e-9)
    assert len(built) == 5


def test_dense_output_and_grid_share_an_integrator(built, body, start):
    pt.propagate(weighted(body, 0.5), start, TIMES)
    pt.propagate(weighted(body, 0.5), start, TIMES, dense=True)
    assert len(built) == 1


def test_the_pool_is_bounded_and_drops_the_least_recently_used(monkeypatch, built, body, start):
    monkeypatch.setattr(kernels, "IDLE_INTEGRATORS", 3)
    tolerances = (1e-5, 1e-6, 1e-7, 1e-8)
    for tolerance in tolerances:
        pt.propagate(pt.System(body), start, [1.0], tolerance=tolerance)
    assert idle() == 3
    pt.propagate(pt.System(body), start, [1.0], tolerance=1e-8)
    pt.propagate(pt.System(body), start, [1.0], tolerance=1e-6)
    assert len(built) == 4
    pt.propagate(pt.System(body), start, [1.0], tolerance=1e-5)
    assert len(built) == 5
    assert idle() == 3


def test_a_reused_integrator_remembers_nothing(built, body, start):
    top = weighted(body, 0.5)
    first = pt.propagate(top, start, TIMES)
    other = body.state((0, 1, 0, 0), omega_body=(3, 2, 1), time=-7.0)
    pt.propagate(weighted(body, 2.0), other, np.linspace(-7, 30, 5), dense=True)
    again = pt.propagate(top, start, TIMES)
    assert len(built) == 1
    assert np.array_equal(first.quaternion, again.quaternion)
    assert np.array_equal(first.conjugate_momenta, again.conjugate_momenta)


def test_after_a_stopped_run_of_euler_angles_the_next_one_is_right(built, body):
    away = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
    system = pt.System(body)
    before = pt.propagate(system, away, [0.0, 1.0], formulation="euler_angles")
    into = body.state((np.cos(0.2), np.sin(0.2), 0, 0), omega_body=(-0.3, 0, 0))
    with pytest.raises(pt.PropagationError):
        pt.propagate(system, into, [0.0, 10.0], formulation="euler_angles")
    after = pt.propagate(system, away, [0.0, 1.0], formulation="euler_angles")
    assert len(built) == 1
    assert np.array_equal(before.quaternion, after.quaternion)


def test_a_run_within_a_run_has_its_own_integrator(built, body, start):
    pt.propagate(weighted(body, 0.5), start, [1.0])
    with ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda _: pt.propagate(weighted(body, 0.5), start, [0.0, 3000.0]), range(2)))
    assert len(built) <= 2
    assert idle() == len(built)


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


@pytest.mark.parametrize("precision", ["double", "extended", "quadruple"])
def test_available_precisions_run(body, start, precision):
    if kernels.available(precision):
        assert pt.propagate(pt.System(body), start, [1.0], precision=precision).run.precision == precision


def test_double_precision_is_always_available():
    assert kernels.available("double")


def test_lanes_are_those_of_512_bits_where_the_processor_has_them():
    assert kernels._fastest_lanes({"AVX512F"}, 4) == kernels._fastest_lanes({"X86_V4"}, 4) == 8
    assert [kernels._fastest_lanes({"AVX2"}, engines) for engines in (1, 2, 4)] == [2, 2, 4]


@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="Linux says in this file what the processor has")
def test_512_bit_code_is_known_by_what_the_system_says():
    has_it = "avx512f" in Path("/proc/cpuinfo").read_text().split()
    assert kernels._fastest_lanes(kernels._features(), 4) == (8 if has_it else 4)
