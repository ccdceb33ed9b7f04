"""A satellite that hangs in the gravity gradient of the Earth, and librates about the vertical.

Linear theory for a body long along its first axis, on a circle with mean motion n: sqrt(3) n in the plane of the
orbit, 2 n across it (for a dumbbell). The picture shows the long axis as seen from the orbit frame.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

orbit = pt.KeplerOrbit(
    mu=398600.4418, semimajor_axis=7000.0, eccentricity=0.0, inclination=0.9, node=0.3, argument_of_periapsis=0.0
)
satellite = pt.Body((1e-6, 1.0, 1.0))  # a dumbbell along the first axis
system = pt.System(satellite, pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})

# Tilted by two degrees in the plane of the orbit and across it, at rest in the orbit frame.
tilt = np.radians(2.0)
attitude = np.array([1.0, 0.0, tilt / 2, tilt / 2])
start = satellite.state(attitude / np.linalg.norm(attitude), omega_body=(0, 0, 0), frame=orbit.frame)
motion = pt.propagate(system, start, np.linspace(0, 3 * orbit.period, 3001))

long_axis = motion.relative_to(orbit.frame).attitude.apply([1.0, 0.0, 0.0])  # radial, transverse, normal
in_plane, across = (np.degrees(np.arcsin(long_axis[:, i])) for i in (1, 2))


def frequency(angle):
    """The angular frequency of an oscillation that starts at a turning point, from its zeros."""
    i = np.flatnonzero(angle[:-1] * angle[1:] < 0)
    zeros = motion.times[i] - angle[i] * np.diff(motion.times)[i] / (angle[i + 1] - angle[i])
    return np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])


print(f"in the plane: {frequency(in_plane) / orbit.mean_motion:.4f} n, linear theory {np.sqrt(3):.4f} n")
print(f"across it:    {frequency(across) / orbit.mean_motion:.4f} n, linear theory 2 n")
assert abs(frequency(in_plane) / orbit.mean_motion - np.sqrt(3)) < 2e-3
assert abs(frequency(across) / orbit.mean_motion - 2) < 2e-3

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
axes.plot(motion.times / 60, in_plane, color="#0072B2", label="in the plane of the orbit")
axes.plot(motion.times / 60, across, color="#D55E00", label="across it")
axes.set_xlabel("time [min]")
axes.set_ylabel("angle from the vertical [deg]")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
axes.grid(alpha=0.25)
figure.savefig("libration.png", dpi=150)
