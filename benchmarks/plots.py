"""Error against time, one curve per tool."""

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt

from poinsot.plot.labels import COLOURS

TOOLS = {
    "poinsot_taylor": ("o", 2.4),
    "heyoka_by_hand": ("s", 1.4),
    "numbalsoda_dop853": ("^", 1.4),
    "diffrax_dopri8": ("D", 1.4),
    "scipy_dop853": ("v", 1.4),
    "mujoco_rk4": ("P", 1.4),
    "basilisk_rkf78": ("X", 1.4),
}
STYLE = {name: (color, *looks) for color, (name, looks) in zip(COLOURS, TOOLS.items(), strict=True)}
"""The colours of all pictures of the package."""


def work_precision(key, problem, titles, folder):
    """Draw one problem and return the name of its picture, written as PNG."""
    figure, axes = plt.subplots(figsize=(8.5, 4.8), layout="constrained")
    for name, curve in problem["curves"].items():
        points = [(1e3 * point["seconds"], point["error"]) for point in curve if "seconds" in point]
        if points:
            color, marker, width = STYLE[name]
            axes.loglog(*zip(*points, strict=True), color=color, marker=marker, lw=width, ms=6, label=titles[name])
    axes.set(xlabel="time [ms]", ylabel="attitude error at the end [rad]", title=f"{key}: {problem['title']}")
    axes.grid(alpha=0.25)
    figure.legend(loc="outside right center", frameon=False)
    name = f"benchmark-{key.lower()}"
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=150)
    plt.close(figure)
    return name
