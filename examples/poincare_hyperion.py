r"""Poincare section of Hyperion.

Poincare section of Hyperion: one chaotic sea, and islands of regular motion.

The rotation in the plane of the orbit is marked at each periapsis, for $(B - A)/C = 0.26$ and $e = 0.1$ (Wisdom, Peale
and Mignard 1984, Icarus 58, 137, Fig. 2). The sea surrounds all states from 1:2 to 2:1; islands of regular libration
remain at 1:1, 2:1 and 9:4 and a small one at 1:2, and none at 3:2. A scan over starts counts them: a motion is locked
to the state $p$ if the angle less $p$ times the mean anomaly stays within half a turn.
"""

import dataclasses

import numpy as np

import poinsot as pt

orbit = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.1)
hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)
system = pt.System(hyperion, pt.GravityGradient(orbit))

# The picture: starts along the two lines of symmetry, and in the sea.
n = orbit.mean_motion
rates = n * np.concatenate([np.linspace(0, 3, 61), np.linspace(0.8, 0.95, 7), np.linspace(1.9, 2.05, 7)])
angles, rates = (x.ravel() for x in np.meshgrid([0, np.pi / 2], rates))
section = pt.analysis.spin_orbit_section(system, angles, rates, 400, progress=False)
labels = "angle of the long axis from the periapsis [rad]", "rate over the mean motion"
section = dataclasses.replace(section, y=section.y / n, labels=labels)
axes = pt.plot.section(section, title="Hyperion at each periapsis, (B - A)/C = 0.26, e = 0.1")
axes.figure.savefig("poincare_hyperion.png", dpi=150)

# The scan: four looks at each of the revolutions, so that whole turns are seen.
revolutions = 300
angles, rates = (x.ravel() for x in np.meshgrid(np.arange(20) * np.pi / 20, n * np.linspace(0, 3, 61)))
starts = pt.analysis.spin_orbit_section(system, angles, rates, 1, progress=False).motion.initial
times = np.arange(4 * revolutions + 1) * orbit.period / 4
motion = pt.propagate(system, starts, times, formulation="planar", tolerance=1e-10, progress=False)
turned = 2 * np.unwrap(np.arctan2(motion.quaternion[..., 3], motion.quaternion[..., 0]), axis=-1)
mean_anomaly = orbit.mean_motion * times
locked = {}
for name, state in {"1:2": 0.5, "1:1": 1.0, "3:2": 1.5, "2:1": 2.0, "9:4": 2.25}.items():
    locked[name] = int(np.sum(np.ptp((turned - state * mean_anomaly)[:, ::4], axis=1) < np.pi))
print(f"of {angles.size} starts locked over {revolutions} revolutions:", locked)
assert locked["3:2"] == 0
assert locked["1:1"] > locked["9:4"] > 0
assert locked["2:1"] > 0
assert 0 < locked["1:2"] < 5
