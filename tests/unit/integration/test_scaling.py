"""Sizes of momenta: closed forms for a heavy body at rest, and the larger of both sizes for a rotating body."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration.scaling import momentum_scale, torque_scale

BODY = pt.Body((1.25, 1.0, 0.75))
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1.0, 0.0, 0.0)))


def test_torque_of_a_weight_gives_the_root_of_moment_times_torque():
    """The torque at samples is at most the weight times the distance, and a few tenths of it at least."""
    largest = np.sqrt(1.25 * 2 * 0.5)  # the difference of energies reaches twice the torque
    assert 0.5 * np.sqrt(1.25 * 0.5) < torque_scale(TOP.dynamics) <= largest
    heavier = pt.System(BODY, pt.UniformGravity(50.0, (1.0, 0.0, 0.0)))
    assert torque_scale(heavier.dynamics) == pytest.approx(
        10 * torque_scale(TOP.dynamics), rel=1e-14, abs=0
    )  # roundings


@pytest.mark.parametrize("rate", [0.0, 1e-3, 100.0])
def test_momentum_of_a_body_is_the_larger_of_its_own_and_that_of_the_torque(rate):
    state = BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    assert momentum_scale(TOP.dynamics, state) == max(0.75 * rate, torque_scale(TOP.dynamics))
