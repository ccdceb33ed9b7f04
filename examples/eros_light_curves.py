"""Seventy years of light curves of Eros.

One published pole and one rate explain the light curves of 433 Eros from 1951 to 2023.

The program reads a file of light curves in the format of DAMIT, whose name follows its own on the command line. DAMIT,
the database of asteroid models from inversion techniques (Durech, Sidorin and Kaasalainen 2010, A&A 513, A46), has a
file for Eros. The model is an ellipsoid of 34.4 x 11.2 x 11.2 km with the law of Lommel and Seeliger, which rotates
about the pole at the ecliptic longitude 17.22 deg and latitude 11.35 deg. For each curve the program fits one factor
of brightness and one angle of rotation. The angles show a rate that is wrong by less than a millionth: with the rate
of the IAU report they drift by 18 deg in seventy years, with a rate from the spacecraft NEAR they stay constant to 2
deg.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt
from poinsot.observables import LommelSeeliger, Readings

files = [argument for argument in sys.argv[1:] if argument.endswith(".txt")]
if not files:
    raise SystemExit(
        "This example reads light curves of Eros that you supply: python eros_light_curves.py lc.txt. "
        "The file is in the format of DAMIT, https://astro.troja.mff.cuni.cz/projects/damit, asteroid 433."
    )

calendar = pt.Calendar("2000-01-01T12:00:00", "TDB", "d")
shape = pt.shapes.Ellipsoid((17.2, 5.6, 5.6), density=2.67e12)  # km, kg/km3
eros = pt.Body.from_shape(shape)
curves = pt.files.read_damit(files[0], shape, LommelSeeliger(albedo=0.2), calendar=calendar)
times = np.unique(np.concatenate([curve.times for curve in curves]))

RATES = {"IAU report": 1639.38864745, "NEAR": 1639.38928}  # deg/d
POLE = np.radians((17.22, 11.35))  # ecliptic longitude and latitude
PHASES = np.arange(-40, 41)  # deg


def motion_at(rate, angles, times):
    """Return the motions of members with different angles of rotation at the epoch, radians."""
    model = pt.orbits.RotationModel.from_pole(*POLE, 360 / rate, angles, axes="ecliptic")
    still = {"omega_body": np.zeros((len(angles), 3)), "frame": model, "time": 0.0}
    start = eros.state(np.tile((1.0, 0, 0, 0), (len(angles), 1)), **still)
    return pt.free_motion(eros, start, times, units={"time": "d"})


def logarithms(rate, angles):
    """Return the logarithms of observed over computed brightness of each curve, (members, n), less their means."""
    computed = pt.observe(motion_at(rate, angles, times), *curves)
    ratios = [np.log(curve.values / found.values) for curve, found in zip(curves, computed, strict=True)]
    return [ratio - np.mean(ratio, axis=-1, keepdims=True) for ratio in ratios]


def rotation(rate):
    """Return the best angle for all curves, the angle of each curve from it with its weight, and the residuals."""
    first = np.radians(np.arange(0, 180, 4.0))
    best = first[np.argmin(sum(np.sum(each**2, axis=-1) for each in logarithms(rate, first)))]
    found = logarithms(rate, best + np.radians(PHASES))
    offsets, weights = np.full(len(curves), np.nan), np.zeros(len(curves))
    for i, each in enumerate(found):
        squares = np.sum(each**2, axis=-1)
        k = int(np.argmin(squares))
        if 0 < k < PHASES.size - 1 and curves[i].times.size > 20:  # the lowest point of a parabola
            slope, curvature = (squares[k + 1] - squares[k - 1]) / 2, squares[k + 1] - 2 * squares[k] + squares[k - 1]
            offsets[i] = PHASES[k] - slope / curvature
            weights[i] = curvature * curves[i].times.size / squares[k]
    middle = PHASES.size // 2
    scatter = np.sqrt(np.mean(np.concatenate([each[middle] for each in found]) ** 2))
    return best, offsets, weights, scatter


def drift(epochs, offsets, weights):
    """Return the line of the angles over time, with small weights of outliers, and the standard error of its slope."""
    known = np.isfinite(offsets)
    t, angles, weights = epochs[known], offsets[known], weights[known]
    columns = np.stack([np.ones_like(t), t], axis=-1)
    for _ in range(5):
        matrix = np.linalg.inv((columns * weights[:, None]).T @ columns)
        line = matrix @ (columns.T @ (weights * angles))
        off = angles - columns @ line
        scale = np.sum(weights * off**2) / (t.size - 2)
        weights = weights / (1 + (off / 10) ** 2)
    return line, np.sqrt(scale * matrix[1, 1])


epochs = np.array([np.mean(curve.times) for curve in curves])
years = 2000 + epochs / 365.25
figure, axes = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
for (name, rate), colour in zip(RATES.items(), ("#D55E00", "#0072B2"), strict=True):
    best, offsets, weights, scatter = rotation(rate)
    line, error = drift(epochs, offsets, weights)
    total = line[1] * np.ptp(epochs)
    print(
        f"{name}: {rate} deg/d, residuals {100 * scatter:.1f} %, drift {total:.1f} deg in {np.ptp(years):.0f} years, "
        f"corrected rate {rate + line[1]:.5f} +- {error:.5f} deg/d"
    )
    axes[0].plot(years, offsets, "o", markersize=3.5, color=colour, label=f"{name}, {rate} deg/d")
    axes[0].plot(years, line[0] + line[1] * epochs, color=colour, linewidth=1)
    if name == "NEAR":
        assert scatter < 0.12
        assert abs(total) < 3
        assert abs(rate + line[1] - 1639.38928) < 1e-4
    else:
        assert 15 < total < 25
axes[0].set(xlabel="year", ylabel="angle of rotation from the model [deg]", ylim=(-25, 25))
axes[0].legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize="small")
axes[0].grid(alpha=0.25)

# The curve with most data, with the last model.
longest = max(curves, key=lambda curve: curve.times.size)
moments = np.linspace(longest.times[0], longest.times[-1], 400)
model = pt.observe(motion_at(rate, np.array([best]), moments), longest.observable).isel(member=0)
scale = np.mean(longest.values) / np.mean(np.interp(longest.times, moments, model.values))
observed = Readings(longest.observable, longest.times, longest.values / scale, attributes=model.attributes)
pt.plot.phased(observed, 360 / rate, model, epoch=longest.times[0], time_unit="h", ax=axes[1])
axes[1].set_ylabel("relative brightness")
axes[1].set_title(f"{years[curves.index(longest)]:.1f}", loc="right", fontsize="medium")
figure.savefig("eros_light_curves.png", dpi=110)
