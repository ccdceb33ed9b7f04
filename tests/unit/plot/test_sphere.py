"""Names and lines of the principal axes on the sphere of directions of the angular momentum."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt
from poinsot.plot.solids import view_direction


@pytest.mark.parametrize("view", [(20.0, 30.0), (-35.0, 200.0)])
def test_names_stand_at_the_near_ends_of_the_axes(view):
    mpl.use("Agg")
    panel = pt.plot.momentum_sphere(pt.Body((1.0, 2.0, 3.0)), view=view)
    eye = view_direction(view)
    for text in panel.texts:
        label = text.get_text()
        if "mathbf{e}" not in label:
            continue
        axis = int(label.partition("e}_")[2][0]) - 1
        place = np.array(text.get_position_3d())
        assert np.sign(place[axis]) == np.sign(eye[axis])
        assert ("-" in label) == (place[axis] < 0)
        assert np.linalg.norm(place) > 1.1
    plt.close("all")
