r"""Librations of Squannit about Moshup.

Moshup and Squannit, 1999 KW4: the moonlet librates, and its libration moves the orbit.

Squannit keeps its long axis towards Moshup. Turned away by a degree it would librate about the line of centres at
$n \sqrt{3 (B - A) / C}$ on a given circle ($n$ the rate of the orbit, $A < B < C$ its moments). This is so near n, the
frequency of an eccentric orbit, that both are coupled although Squannit is small: the period is 7% longer. The linear
theory of distance and angle together has it, with the angular momentum of both kept, and the mean of Moshup's turn.
Masses and distance are those of Ho 2023; semiaxes are approximate, as of the radar model of Ostro et al. 2006 (Science
314, 1276), who saw an orbit of 17.4 h.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

HOUR, DAY = 3600.0, 86400.0  # s, m, kg
moshup = pt.Body.from_ellipsoid(2.353e12, (708.5, 680.5, 591.5))
squannit = pt.Body.from_ellipsoid(0.135e12, (297.5, 225.0, 171.5))
pair = pt.TwoBodies(moshup, squannit)
system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "inertia": "kg m2", "length": "m"})
synchronous = pair.synchronous(distance=2548.0, primary_rate=2 * np.pi / (2.7645 * HOUR))
rate = np.linalg.norm(synchronous.momentum) / pair.reduced_mass / 2548.0
times = np.arange(0.0, 120 * DAY, 0.5 * HOUR)


def turned(degrees):
    """The synchronous start with Squannit turned about the normal of the orbit."""
    own, turn = synchronous.secondary, Rotation.from_rotvec((0, 0, np.radians(degrees)))
    second = squannit.state(turn * own.attitude, angular_momentum_body=own.angular_momentum_body)
    return pt.PairState(synchronous.position, synchronous.momentum, synchronous.primary, second)


def libration(motion):
    """The angle of the long axis from the line of centres, radians."""
    facing = motion.secondary.attitude.inv().apply(motion.position)
    return np.arctan2(-facing[:, 1], facing[:, 0])


angles = {degrees: libration(pt.propagate(system, turned(degrees), times)) for degrees in (1, 5, 20)}
(A, B, C), (A1, B1, C1), (m1, m2) = squannit.moments, moshup.moments, pair.masses
G, mu, r = pair.G, pair.reduced_mass, 2548.0
on_a_circle = 2 * np.pi / (rate * np.sqrt(3 * (B - A) / C)) / HOUR

# Routh's function of distance and angle, the total angular momentum K kept: mu r'^2 / 2 + m a'^2 / 2 + K C a' / M - V.
M, quadrupole = C + mu * r**2, m1 * (B + C - 2 * A) + m2 * (C1 - (A1 + B1) / 2)
K = M * rate
along = -2 * G * m1 * m2 / r**3 - 6 * G * quadrupole / r**5 + K**2 * mu * (4 * mu * r**2 / M - 1) / M**2
across, mass, gyroscopic = 3 * G * m1 * (B - A) / r**3, C * mu * r**2 / M, 2 * mu * r * K * C / M**2
squares = np.roots([mu * mass, -(mu * across + mass * along + gyroscopic**2), along * across])
coupled = np.max(2 * np.pi / np.sqrt(squares)) / HOUR
print(f"orbit: {2 * np.pi / rate / HOUR:.2f} h; seen 17.4 h")
print(f"libration by the linear theory: {on_a_circle:.2f} h on a circle, {coupled:.2f} h with the orbit")
periods = {}
for degrees, angle in angles.items():
    lines = pt.analysis.frequencies(angle, times[1], 2)
    periods[degrees] = 2 * np.pi / np.abs(lines.frequencies[0]) / HOUR
    print(f"    started {degrees:2d} deg away: {periods[degrees]:.2f} h")
assert abs(2 * np.pi / rate / HOUR - 17.4) < 0.1
assert abs(periods[1] / coupled - 1) < 0.003
assert periods[20] > periods[1]  # as of a pendulum

figure, panel = plt.subplots(figsize=(8, 4), layout="constrained")
for (degrees, angle), color in zip(angles.items(), ("#0072B2", "#D55E00", "#009E73"), strict=True):
    panel.plot(times[:480] / DAY, np.degrees(angle[:480]), color=color, linewidth=0.8, label=f"{degrees} deg")
panel.set_xlabel("time [d]")
panel.set_ylabel("long axis from the line of centres [deg]")
panel.legend(title="at the start", loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
panel.grid(alpha=0.25)
figure.savefig("moshup.png", dpi=150)
