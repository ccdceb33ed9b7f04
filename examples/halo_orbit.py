"""A spacecraft on a halo orbit.

A spacecraft on a halo orbit about L2 of Earth and Moon, under the gravity gradients of both.

The orbit is one of NASA/JPL's catalogue (https://ssd.jpl.nasa.gov/tools/periodic_orbits.html), in units of the
separation and of the mean motion. Position, velocity and attitude are integrated together: the orbit closes, and keeps
its Jacobi constant. A spacecraft held at L2 itself would rest along the line to both attractors.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

MASS_RATIO, KM, SECONDS = 1.215058560962404e-2, 389703.2648292776, 382981.2891290545
PLACE, SPEED, PERIOD = (1.1721212352395958, 0, 8.5877005926413993e-2), -1.8782217382326816e-1, 3.3522346943474246

mu = KM**3 / SECONDS**2
pair = mu * (1 - MASS_RATIO), mu * MASS_RATIO
path = pt.orbits.ThreeBodyPath(
    *pair, separation=KM, position=np.multiply(PLACE, KM), velocity=(0, SPEED * KM / SECONDS, 0)
)
point = pt.orbits.LagrangePointPath(*pair, separation=KM, point="L2")
spacecraft = pt.Body((100.0, 120.0, 130.0))  # its long axis is the first
forces = pt.GravityGradient(path.from_primary), pt.GravityGradient(path.from_secondary)
system = pt.System(spacecraft, *forces, units={"time": "s", "inertia": "kg m2"})
start = spacecraft.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=path.frame)
motion = pt.propagate(system, start, np.linspace(0, 2 * PERIOD * SECONDS, 801))

# Where it went, along the axes that turn with Earth and Moon, from the Moon.
to_synodic = path.frame.attitude(motion.times).inv()
r, v = (
    np.stack(x, axis=-1)
    for x in (motion.environment.position(path.from_secondary), motion.environment.velocity(path.from_secondary))
)
place = to_synodic.apply(r) / KM
drift = to_synodic.apply(v - np.cross(path.frame.omega_space(motion.times), r)) * SECONDS / KM
gaps = [np.linalg.norm(place[i] - place[0]) for i in (400, 800)]
print(f"after one period it is {gaps[0] * KM * 1e6:.2g} mm from where it was, after two {gaps[1] * KM * 1e6:.2g} mm")
assert gaps[0] < 1e-11
assert gaps[1] < 1e-8

earth, moon = (np.linalg.norm(place + np.array(offset), axis=-1) for offset in ((1, 0, 0), (0, 0, 0)))
from_axis = (place[:, 0] + 1 - MASS_RATIO) ** 2 + place[:, 1] ** 2
jacobi = from_axis + 2 * (1 - MASS_RATIO) / earth + 2 * MASS_RATIO / moon - np.sum(drift**2, axis=-1)
print(f"Jacobi constant {path.jacobi_constant:.12f}, changes by {np.ptp(jacobi):.1g}")
assert np.max(np.abs(jacobi - path.jacobi_constant)) < 1e-13

long_axis = motion.relative_to(path.frame).attitude.as_matrix()[:, :, 0]
line = np.degrees(np.arctan2(np.hypot(long_axis[:, 1], long_axis[:, 2]), long_axis[:, 0]))
to_moon = np.degrees(np.arccos(np.clip(np.sum(long_axis * place, axis=-1) / moon, -1, 1)))
print(f"the long axis gets {line.max():.1f} deg away from the line of Earth and Moon")

figure, (left, right) = plt.subplots(ncols=2, width_ratios=(1, 1.5), figsize=(8, 4.8), layout="constrained")
thousand = KM / 1000
left.plot(place[:401, 0] * thousand, place[:401, 1] * thousand, color="#0072B2", label="y")
left.plot(place[:201, 0] * thousand, place[:201, 2] * thousand, color="#D55E00", linestyle="--", label="z")
left.plot(point.from_secondary.position[0] / 1000, 0, "+", color="#000000", label="L2")
left.plot(0, 0, "o", color="#000000", label="Moon")
left.set(xlabel="x from the Moon [1000 km]", ylabel="y, z [1000 km]")
left.set_aspect("equal", adjustable="datalim")
days = motion.times / 86400
right.plot(days, line, color="#000000", label="to the line Earth - Moon")
right.plot(days, to_moon, color="#009E73", linestyle="--", label="to the line Moon - spacecraft")
right.set(xlabel="time [d]", ylabel="angle of the long axis [deg]")
for axes, columns in ((left, 2), (right, 1)):
    axes.grid(alpha=0.25)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, frameon=False)
figure.savefig("halo_orbit.png", dpi=150)
