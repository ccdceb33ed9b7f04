r"""Flat spin of Explorer 1.

Flat spin of Explorer 1: a spin about the axis of the smallest moment does not last.

The satellite with its spent motor, 13.97 kg, 2.051 m long and 0.152 m thick (published), is taken as a homogeneous
cylinder that turns 750 times a minute about its axis (assumed; about ten times a second, says Bollay 1967, Spin
Stability of the Explorer Satellite, Stanford, who has it in flat spin after an orbit). Its whip antennas bent; a small
sphere in a viscous fluid stands for them here, with a moment of inertia of 1e-4 kg m2 and the coefficient that takes
most, chosen so that the axis leaves its direction within an orbit of 114.8 minutes, as it did. At constant angular
momentum $g$ the energy falls from $g^2/(2 C)$ to $g^2/(2 A)$, with $C$ along the axis and $A$ across it. The sphere of
moment $J$ and coefficient $k$ loses energy at the rate that makes the angle $\vartheta$ between axis and angular
momentum grow as

$$ \tan\vartheta = \tan\vartheta_0\, e^{t/T}, \qquad
\frac1T = \left( \frac1C - \frac1A \right) \frac{k (J \nu)^2}{k^2 + (J \nu)^2}, \qquad \nu = \frac gA, $$

to the first order in $J/C$. The picture shows angle, energy and rate of the tumbling.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

mass, length, radius = 13.97, 2.051, 0.076
C, A = mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12
spin, orbit = 750 * 2 * np.pi / 60, 114.8 * 60
tilt = np.radians(0.5)
g = C * spin / np.cos(tilt)
nu = g / A
J = 1e-4
k = J * nu
T = 1 / ((1 / C - 1 / A) * k * (J * nu) ** 2 / (k**2 + (J * nu) ** 2))

damper = pt.parts.KaneDamper(J, k)
system = pt.System(pt.Body((A, A, C)), damper, units={"time": "s", "inertia": "kg m2"})
start = system.state((1, 0, 0, 0), omega_body=(nu * np.sin(tilt), 0, spin))
g = np.linalg.norm(start.angular_momentum_body)
motion = pt.propagate(system, start, np.linspace(0, 2 * orbit, 1001))

along = motion.angular_momentum_body[:, 2] / g
angle = np.arctan2(np.sqrt(1 - along**2), along)
theory = np.arctan(np.tan(angle[0]) * np.exp(motion.times / T))
inside = (theory > np.radians(1)) & (theory < np.radians(80))
found = np.polyfit(motion.times[inside], np.log(np.tan(angle[inside])), 1)[0]
ends = g**2 / (2 * C), g**2 / (2 * A)
print(f"C = {C:.4f}, A = {A:.3f} kg m2, g = {g:.3f} kg m2/s")
print(
    f"energy: {motion.energy[0]:.1f} J at the start, {motion.energy[-1]:.4f} J at the end, g^2/(2 A) = {ends[1]:.4f} J"
)
print(f"time constant: {1 / found:.1f} s, of the energy sink {T:.1f} s")
print(f"angle after an orbit: {np.degrees(angle[500]):.1f} deg; at the end a turn takes {2 * np.pi / nu:.2f} s")
assert abs(motion.energy[0] / ends[0] - 1) < 1e-4  # tilted by half a degree
assert abs(motion.energy[-1] / ends[1] - 1) < 1e-3  # 1 / tan^2 of the last angle times A/C
assert abs(1 / found / T - 1) < 2 * J / C
assert max(abs(motion.drift[name]).max() for name in motion.drift) < 1e-11
assert np.degrees(angle[500]) > 45

figure, panels = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
minutes = motion.times / 60
panels[0].plot(minutes, np.degrees(angle), color="#0072B2", label="integrated")
panels[0].plot(minutes, np.degrees(theory), ":", color="#000000", label="energy sink")
panels[0].set(ylabel="axis from the angular momentum [deg]", yticks=range(0, 91, 15))
panels[1].semilogy(minutes, motion.energy, color="#D55E00")
panels[1].axhline(ends[1], linestyle=":", color="#000000", label=f"$g^2/2A$ = {ends[1]:.2f} J")
panels[1].set(ylabel="kinetic energy [J]")
panels[2].plot(minutes, motion.omega_body[:, 2] * 60 / (2 * np.pi), color="#009E73", label="about the axis")
panels[2].plot(
    minutes, np.linalg.norm(motion.omega_body[:, :2], axis=1) * 60 / (2 * np.pi), color="#CC79A7", label="across it"
)
panels[2].set(ylabel="angular velocity [rpm]", yscale="log")
for panel in panels:
    panel.set(xlabel="time [min]", xlim=(0, minutes[-1]))
    panel.legend(frameon=False)
    panel.grid(alpha=0.25)
figure.savefig("explorer_1.png", dpi=150)
