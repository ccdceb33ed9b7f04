"""Runs on looped kernels: which kernel they take."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.engine import kernels, looped_kernel

pytestmark = pytest.mark.skipif(not looped_kernel.available(), reason="needs llvmlite")

BODY = pt.Body((1.3, 1.0, 0.7))
START = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.6, 0.5))


def motion(force):
    return pt.propagate(pt.System(BODY, force), START, np.linspace(0, 5, 3))


def codes():
    return [known for known in kernels._pool._decided.values() if isinstance(known, looped_kernel.Code)]


def test_a_sweep_through_zero_takes_one_kernel_more(monkeypatch):
    monkeypatch.setattr(kernels, "_pool", kernels._Pool())
    for y in (-0.2, -0.1, 0.0, 0.1, 0.2):
        motion(pt.UniformGravity(0.7, (0.3, y, 0.5)))
    assert len(codes()) == 2


def test_a_zero_of_some_members_is_none_of_the_others(monkeypatch):
    monkeypatch.setattr(kernels, "_pool", kernels._Pool())
    centers = [(0.3, 0.0, 0.0), (0.3, 0.2, 0.0)]
    motions = motion(pt.UniformGravity(0.7, centers))
    for center, quaternion in zip(centers, motions.quaternion, strict=True):
        assert np.max(np.abs(motion(pt.UniformGravity(0.7, center)).quaternion - quaternion)) < 3e-14


class Root(pt.Potential):
    """Whose slope is 0/0 for k = 0."""

    k: float

    def energy(self, instant):
        return pt.functions.sqrt(self.k * (2 + instant.attitude.to_body((0, 0, 1))[2]))


def test_a_formula_that_has_no_slope_at_zero_stops_as_before():
    motion(Root(0.3))
    with pytest.raises(RuntimeError, match="non-finite"):
        motion(Root(0.0))
