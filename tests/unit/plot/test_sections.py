"""Points of a section in the unit of the axes."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt


@pytest.fixture
def section():
    mpl.use("Agg")
    body = pt.Body((1.0, 2.0, 3.0))
    system = pt.System(body, units={"time": "s"})
    state = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.1))
    motion = pt.propagate(system, state, [0.0, 20.0], events=[pt.events.AxisCrossing((0, 0, 1), (1, 0, 0))])
    yield pt.analysis.section(
        motion, lambda at: (at.omega_body[:, 0], at.omega_body[:, 1]), labels=("phase [rad]", "rate [rad/s]")
    )
    plt.close("all")


@pytest.mark.parametrize(("angle_unit", "factor"), [("deg", 180 / np.pi), ("rad", 1.0)])
def test_points_are_in_the_unit_of_the_axis(section, angle_unit, factor):
    axes = pt.plot.section(section, angle_unit=angle_unit, rate_unit="rpm")
    drawn = np.concatenate([each.get_offsets() for each in axes.collections])
    wanted = np.stack([section.x * factor, section.y * 30 / np.pi], axis=-1)
    wanted = wanted[np.isfinite(wanted[:, 0])]
    assert len(wanted) > 1
    order, found = np.lexsort(wanted.T), np.lexsort(np.asarray(drawn).T)
    np.testing.assert_allclose(np.asarray(drawn)[found], wanted[order], rtol=1e-14)
    assert angle_unit in axes.get_xlabel()
    assert "rpm" in axes.get_ylabel()
