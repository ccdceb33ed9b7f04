"""Mean torques of YORP over obliquity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from poinsot.analysis.yorp import YorpCoefficients
from poinsot.plot.labels import BLACK, BLUE, VERMILION, angle_unit_of
from poinsot.plot.panels import PLAIN, count_degrees, dress, one_panel, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["yorp"]


@plot
def yorp(
    coefficients: YorpCoefficients, *, ax: Axes | None = None, angle_unit: str | None = None, title: str = ""
) -> Axes:
    """Draw the mean torques at unit pressure along the spin axis and towards larger obliquity, against the obliquity.

    Parameters
    ----------
    coefficients : YorpCoefficients
        Coefficients at several obliquities.
    {options}

    Returns
    -------
    matplotlib Axes
        The panel.

    Examples
    --------
    >>> box = pt.shapes.Mesh.from_box((2, 1.4, 1), mass=1.0)
    >>> bent = pt.shapes.Mesh(box.vertices + 0.3 * box.vertices[:, [1, 2, 0]] ** 3, box.faces, mass=1.0)
    >>> found = pt.analysis.yorp_coefficients(bent, np.radians([0, 30, 60, 90]))
    >>> pt.plot.yorp(found).get_xlabel()
    'obliquity [deg]'
    """
    panel, unit = one_panel(ax, (7.0, 4.4), title), angle_unit_of(angle_unit, coefficients.obliquities)
    at = unit.factor * coefficients.obliquities
    panel.plot(at, 0 * at, color=BLACK, linewidth=0.8)
    panel.plot(at, coefficients.spin, color=BLUE, label="along the spin axis")
    panel.plot(at, coefficients.tilt, color=VERMILION, linestyle="--", label="towards larger obliquity")
    panel.ticklabel_format(axis="y", scilimits=PLAIN, useMathText=True)
    dress(panel, f"obliquity{unit.label}", "mean torque of unit pressure [length³]")
    count_degrees(panel.xaxis, panel.get_xlabel())
    return panel
