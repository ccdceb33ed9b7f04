"""Periods of Patroclus and Menoetius.

Patroclus and Menoetius, which keep one side to each other: with which periods would they librate?

Two bodies of nearly one size, both of which turn once in a revolution of 4.283 d: a relative equilibrium. The linear
equations about it have seven frequencies: of the distance and both librations in longitude, in the plane of the orbit,
and four of motions across it. A motion that starts near it with the same angular momentum must have them as the lines
of its angles, but for a part that falls as the square of the disturbance. The numbers are those of patroclus.toml, all
of them approximate, and so are the periods.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

DAY = 86400.0  # s, km, kg
patroclus = pt.Body.from_ellipsoid(7.89e17, (63.5, 58.5, 49))
menoetius = pt.Body.from_ellipsoid(6.17e17, (58.5, 54, 45))
pair = pt.TwoBodies(patroclus, menoetius, G=6.6743e-20)
system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "inertia": "kg km2", "length": "km"})
(rest,) = pt.analysis.pair_equilibria(system, pair.doubly_synchronous(period=4.283 * DAY))
linear = 2 * np.pi / rest.frequencies / DAY
print(f"distance {rest.distance:.1f} km, stability: {rest.stability}")
assert rest.stability == "lyapunov"
assert linear.size == 7

times = np.arange(0.0, 1500 * DAY, 0.25 * DAY)


def turned(body, state, degrees):
    """A state turned about the body axes, with its angular momentum in space."""
    turn = Rotation.from_rotvec(np.radians(degrees))
    return body.state(state.attitude * turn, angular_momentum_body=turn.as_matrix().T @ state.angular_momentum_body)


def disturbed(size):
    """The yaw and the roll of both bodies, radians, after turns of some tenths of a degree times `size`."""
    first = turned(patroclus, rest.state.primary, size * np.array([0.3, -0.2, 0.4]))
    second = turned(menoetius, rest.state.secondary, size * np.array([-0.2, 0.3, 0.3]))
    stretch = 1 + 3e-4 * size
    start = pt.PairState(stretch * rest.state.position, rest.state.momentum / stretch, first, second)
    motion = pt.propagate(system, start, times)
    both = {body: pt.analysis.librations(motion, body) for body in ("primary", "secondary")}
    return {(body, name): getattr(found, name) for body, found in both.items() for name in ("yaw", "roll")}


def lines_of(angles):
    """The three strongest lines of each angle: periods, days, and amplitudes, degrees."""
    found = {key: pt.analysis.frequencies(angle, times, 3) for key, angle in angles.items()}
    return {
        key: (2 * np.pi / lines.frequencies / DAY, np.degrees(np.abs(lines.amplitudes))) for key, lines in found.items()
    }


def differences(lines):
    """By linear period, the largest relative difference of the lines nearest to it; NaN where there is none."""
    worst = np.full(linear.size, np.nan)
    for period in np.concatenate([periods for periods, _ in lines.values()]):
        nearest = np.argmin(np.abs(linear - period))
        worst[nearest] = np.fmax(worst[nearest], abs(period / linear[nearest] - 1))
    return worst


angles = disturbed(1.0)
lines = lines_of(angles)
large, small = differences(lines), differences(lines_of(disturbed(0.1)))
print("period by the linear equations (d)   lines differ by, disturbed   a tenth of that")
for row in zip(linear, large, small, strict=True):
    print("{:34.4f}   {:26.1e}   {:15.1e}".format(*row))
assert np.all(large < 1e-4)  # the largest is 2.4e-5, and falls as the square of the disturbance
assert np.all(small < large / 50)

figure, (motions, spectrum) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained", width_ratios=(3, 2))
names = {"primary": "Patroclus", "secondary": "Menoetius"}
shown = times <= 90 * DAY
for (body, name), angle in angles.items():
    drawn = {"color": "#0072B2" if body == "primary" else "#D55E00", "ls": "-" if name == "yaw" else ":"}
    motions.plot(times[shown] / DAY, np.degrees(angle[shown]), lw=1, label=f"{name} of {names[body]}", **drawn)
    mark = {"marker": "o" if name == "yaw" else "s", "mfc": "none", "color": drawn["color"], "ls": ""}
    spectrum.plot(*lines[body, name], label=f"{name} of {names[body]}", **mark)
for period in linear:
    spectrum.axvline(period, color="0.7", lw=0.8, zorder=0, label="linear equations" if period == linear[0] else None)
motions.set(xlabel="time [d]", ylabel="angle to the axes of the orbit [deg]")
spectrum.set(yscale="log", xlabel="period [d]", ylabel="amplitude [deg]")
for panel in (motions, spectrum):
    panel.grid(alpha=0.25)
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize="small")
figure.savefig("patroclus.png", dpi=150)
