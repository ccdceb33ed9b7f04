"""Chaotic rotation of Hyperion.

Hyperion cannot rotate regularly: chaos in the plane of its orbit, and tumbling out of it.

With the spin axis kept normal to the orbit the rotation is chaotic: nearby trajectories diverge by a factor of e in
little more than an orbit. And it is unstable out of the plane: an axis started a tenth of a degree off the normal
leaves it (Wisdom, Peale and Mignard 1984, Icarus 58, 137). The picture shows motions in the plane at every periapsis
passage, regular ones as curves and chaotic ones as a cloud, and the angle between the short axis of the body and the
normal.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

orbit = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.123233)
hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)  # (C - A)/B and (B - A)/C: about 190 x 145 x 114 km
system = pt.System(hyperion, pt.GravityGradient(orbit))


def at_periapsis(angle, rate, tilt=0.0):
    """States with the long axis at an angle from the periapsis and the short one tilted from the normal."""
    angle, rate, tilt = np.broadcast_arrays(*np.atleast_1d(angle, rate, tilt))
    c, s, ct, st = np.cos(angle / 2), np.sin(angle / 2), np.cos(tilt / 2), np.sin(tilt / 2)
    spin = np.stack([0 * rate, 0 * rate, rate], axis=-1)
    return hyperion.state(np.stack([c * ct, c * st, s * st, s * ct], axis=-1), omega_space=spin)


def in_plane(motion):
    """Angle and rate of motions in the plane of the orbit, shape (2, members, times)."""
    q = motion.quaternion
    return np.stack([2 * np.arctan2(q[..., 3], q[..., 0]), motion.omega_body[..., 2]])


def reduced(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


# The divergence of 60 pairs of nearby trajectories, rescaled after each orbit.
orbits, pairs, tiny = 100, 60, 1e-8
motions = np.array([0.01 + np.linspace(-5e-4, 5e-4, pairs), np.ones(pairs)])
apart = np.array([np.full(pairs, tiny), np.zeros(pairs)])
growth = np.zeros(pairs)
for _ in range(orbits):
    starts = at_periapsis(*np.concatenate([motions, motions + apart], axis=1))
    ends = in_plane(pt.propagate(system, starts, [orbit.period], progress=False))[:, :, 0]
    motions, apart = ends[:, :pairs], ends[:, pairs:] - ends[:, :pairs]
    apart[0] = reduced(apart[0])
    growth += np.log(np.linalg.norm(apart, axis=0) / tiny)
    apart *= tiny / np.linalg.norm(apart, axis=0)
exponent = np.mean(growth) / orbits
print(f"planar Lyapunov exponent: {exponent:.2f} per orbit; published 0.75 to 0.95")
assert 0.75 < exponent < 0.95

# The same start with the short axis a little off the normal.
tilts = np.radians([0.5, 0.2, 0.1])
times = np.linspace(0, 100, 10001) * orbit.period
tumbling = pt.propagate(system, at_periapsis(0.01, 1.0, tilts), times, progress=False)
height = 1 - 2 * (tumbling.quaternion[..., 1] ** 2 + tumbling.quaternion[..., 2] ** 2)
obliquity = np.degrees(np.arccos(np.clip(height, -1, 1)))
for tilt, angle in zip(np.degrees(tilts), obliquity, strict=True):
    print(f"{tilt:.1f} deg off the normal become 45 deg after {np.argmax(angle > 45) / 100:.0f} orbits")
assert np.all(np.max(obliquity, axis=1) > 90)

section = at_periapsis(np.repeat([0, np.pi / 2], 25), np.tile(np.linspace(0.1, 2.8, 25), 2))
angles, rates = in_plane(pt.propagate(system, section, np.arange(300) * orbit.period, progress=False))

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
left.plot(np.degrees(angles.T % np.pi), rates.T, ",", color="#0072B2")
left.set_xlabel("angle of the long axis from the periapsis [deg]")
left.set_xticks(range(0, 181, 30))
left.set_ylabel("rate over the mean motion")
for tilt, angle, color in zip(np.degrees(tilts), obliquity, ("#D55E00", "#0072B2", "#009E73"), strict=True):
    right.semilogy(times / orbit.period, angle, color=color, linewidth=0.8, label=f"{tilt:.1f} deg")
right.set_xlabel("orbits")
right.set_ylabel("short axis from the normal [deg]")
right.legend(title="at the start", frameon=False)
right.grid(alpha=0.25)
figure.savefig("hyperion.png", dpi=150)
