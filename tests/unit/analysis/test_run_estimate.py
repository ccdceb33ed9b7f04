"""What a run will take: sizes exactly, times from a sample."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.analysis import run_estimate

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1, 0.2, 0)))
RATES = np.linspace((0, 0, 1), (1, 2, 3), 1000)
START = BODY.state((1, 0, 0, 0), omega_body=RATES)


class Clock:
    """A processor that takes a second for a member and a unit of time."""

    def __init__(self):
        self.now, self.asked = 0.0, []

    def perf_counter(self):
        return self.now

    def propagate(self, _, state, times, **options):
        members = len(state.quaternion) if state.quaternion.ndim > 1 else 1
        self.asked.append((members, len(times)))
        self.now += 1e-4 * members * times[-1] * options.get("slower", 1.0)
        return pt.free_motion(BODY, state, times[:1])


@pytest.fixture
def clock(monkeypatch):
    own = Clock()
    monkeypatch.setattr(run_estimate, "clock", own)
    monkeypatch.setattr(run_estimate, "propagate", own.propagate)
    return own


@pytest.mark.parametrize("end", [1.0, 60.0, 5000.0])
def test_the_time_is_that_of_all_members_up_to_the_end(clock, end):
    found = pt.analysis.estimate_run(TOP, START, np.linspace(0, end, 100), threads=3)
    assert found.seconds == pytest.approx(1e-4 * 1000 * end, rel=1e-9, abs=0)
    assert found.seconds_on(workers=5, threads=6) == pytest.approx(found.seconds / 10)
    assert max(members for members, _ in clock.asked) == found.sampled
    assert found.seconds < 1 or clock.now < 0.7 * found.seconds


def test_sizes_are_those_of_the_motion():
    times = np.linspace(0, 5, 11)
    found = pt.analysis.estimate_run(TOP, START, times, tolerance=1e-9)
    motion = pt.propagate(TOP, START, times, tolerance=1e-9)
    assert found.bytes == sum(rows.nbytes for rows in motion.phase.values())
    assert (found.members, found.times.tolist()) == (1000, times.tolist())
    assert 0 < found.memory < 2**50
    assert f"{found.bytes / 1000:.3g} kB, fits into memory" in repr(found)


def test_one_body_is_one_member():
    found = pt.analysis.estimate_run(TOP, BODY.state((1, 0, 0, 0), omega_body=(0, 0.1, 1)), np.linspace(0, 9, 30))
    assert (found.members, found.threads, found.sampled) == (1, 1, 1)
    assert found.seconds > 0


def test_summary_names_results_larger_than_memory():
    many = pt.analysis.RunEstimate(TOP, 10**6, np.arange(1000.0), 56 * 10**9, 8 * 10**9, 2, 9000.0, 0.2, 512)
    assert "56 GB, is more than memory has room for: give out= (8 GB)" in repr(many)
    assert "2.5 h on 2 threads" in repr(many)
    with pytest.raises(ValueError, match=r"^workers and threads must be positive, got 0 and None\.$"):
        many.seconds_on(0)


def test_a_sample_goes_to_no_store(tmp_path):
    for name, given in {"out": tmp_path / "it.zarr", "chunk": 5, "reduce": len}.items():
        with pytest.raises(TypeError, match=f"^{name} must be given to propagate alone, got it for an estimate"):
            pt.analysis.estimate_run(TOP, START, [0.0, 1.0], **{name: given})
    assert not [*tmp_path.iterdir()]
    with pytest.raises(ValueError, match=r"^threads must be a positive whole number, got -1\.$"):
        pt.analysis.estimate_run(TOP, START, [0.0, 1.0], threads=-1)
