"""Tidal despinning of a captured moon.

Tides slow a captured moon down to the pseudo-synchronous rate, and turn its axis upright.

A moon with the size and mass of Triton on an ellipse about Neptune, and forty ways in which it may have come to spin.
With a constant time lag and without a permanent figure, the averaged equations are linear: the spin tends to a vector
normal to the orbit exponentially, each component along the space axes at a rate of its own (Hut 1981, Astron.
Astrophys. 99, 126). The picture has the runs and that closed form: all end upright, at two mean motions, for the tide
at the periapsis counts most. The time lag is ten thousand times a usual one, so that 500 revolutions suffice: with a
lag of 100 s the same takes ten thousand times as long.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

G, mass, radius, gyration = 6.6743e-11, 2.1390e22, 1.3534e6, 0.33  # of Triton; kg, m
moment = gyration * mass * radius**2
orbit = pt.KeplerOrbit(6.836527e15, semimajor_axis=20 * 2.4764e7, eccentricity=0.4)  # about Neptune, m3/s2, m
k2, lag = 0.1, 1e6  # s
moon = pt.System(
    pt.Body((moment,) * 3),
    pt.forces.TidalTorque(orbit, love_number=k2, radius=radius, time_lag=lag),
    units={"time": "s", "inertia": "kg m2"},
)

members, n, e = 40, orbit.mean_motion, orbit.eccentricity
rng = np.random.default_rng(1846)
directions = rng.normal(size=(members, 3))
directions /= np.linalg.norm(directions, axis=1, keepdims=True)
spins = n * rng.uniform(0.5, 8.0, (members, 1)) * directions
times = np.arange(501) * orbit.period  # at the periapsis
start = moon.state((1, 0, 0, 0), omega_space=spins)
motion = pt.propagate(moon, start, times, progress=False)
omega = motion.angular_momentum_space / moment / n

# The averages of r^-6, of r^-6 x x^T / r^2, and of x x v / r^8, over those of a circle.
circle = (1 - e**2) ** -4.5
spin_part = circle * (1 + 3 * e**2 + 3 / 8 * e**4)
tilt_part = circle * (3 / 2 * e**2 + e**4 / 4)
rates = np.array([(spin_part - tilt_part) / 2, (spin_part + tilt_part) / 2, spin_part])
strength = 3 * k2 * orbit.mu**2 / G * radius**5 * lag / orbit.semimajor_axis**6 / moment
end = np.array([0, 0, pt.forces.pseudo_synchronous_rate(e)])
theory = end + (spins / n - end)[:, None] * np.exp(-strength * np.multiply.outer(times, rates))

apart = np.max(np.abs(omega - theory))
within = strength * orbit.period * spin_part  # what a revolution changes, which an average leaves out
print(f"rate at the end: {np.mean(omega[:, -1, 2]):.4f} mean motions; closed form {end[2]:.4f}")
print(
    f"runs and closed form differ by {apart:.4f} mean motions; a revolution takes {100 * within:.1f} % of a spin away"
)
assert apart < 3 * within**2 * np.max(np.abs(spins)) / n
assert np.max(np.abs(omega[:, -1, 2] - end[2])) < 0.02
print(f"a lag of 100 s takes {lag / 100 / (strength * spin_part) / 3.15576e7:.0f} years for a factor e")

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
turns = times / orbit.period
for axes, quantity in (
    (left, lambda w: np.linalg.norm(w, axis=-1)),
    (right, lambda w: np.degrees(np.arctan2(np.hypot(w[..., 0], w[..., 1]), w[..., 2]))),
):
    axes.plot(turns, quantity(omega).T, color="#0072B2", linewidth=0.7, alpha=0.7)
    axes.plot(turns[::25], quantity(theory)[:, ::25].T, ".", color="#D55E00", markersize=3)
    axes.set_xlabel("revolutions")
    axes.grid(alpha=0.25)
left.axhline(end[2], color="#000000", linestyle="--", linewidth=1)
left.set_ylabel("spin over the mean motion")
right.set_ylabel("axis from the normal of the orbit [deg]")
left.plot([], [], color="#0072B2", label="runs")
left.plot([], [], ".", color="#D55E00", label="closed form")
left.plot([], [], color="#000000", linestyle="--", label="pseudo-synchronous")
left.legend(frameon=False)
figure.savefig("tidal_despinning.png", dpi=150)
