r"""Detumbling of a thousand CubeSats.

Detumbling of 1000 CubeSats by magnetorquers: the B-dot law in the field of a tilted dipole, as one ensemble.

Each satellite of three units begins in any attitude, with 2 to 12 degrees per second about any axis. The torquers make
a moment against the change of the field that a magnetometer sees, at most 0.1 A m2 along each axis. The gain is that of
Avanzini and Giulietti (2012, J. Guid. Control Dyn. 35, 1326), $k = 2 n (1 + \sin i) J / B^2$ of the smallest moment
$J$.

Rates fall with the time constant $3 J / (2 k B^2)$, here of the largest moment: the torque takes no rate along the
field, which leaves two thirds of the mean. They end where the mean torque vanishes on a body that follows the field,
$\langle B^2 - \mathbf B \mathbf B^T \rangle\, \boldsymbol\omega = \langle \mathbf B \times \dot{\mathbf B} \rangle$: at
about twice the orbital rate, since the field turns twice in an orbit.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=6871.2, eccentricity=0.0, inclination=np.radians(97.4), node=0.7)
planet = pt.orbits.RotationModel.iau("earth")
field = pt.forces.TiltedDipole(orbit, planet, -29350e-9, -1410.3e-9, 4545.5e-9, 6371.2)  # km, T; IGRF-14 in 2025
satellite = pt.Body((0.033, 0.032, 0.0067))  # kg m2

n, period = float(orbit.mean_motion), float(orbit.period)
along = np.linspace(0, 5 * period, 2001)
B = np.stack(list(field.in_space(orbit.position_at(along), along)), axis=-1)
square = np.mean(np.sum(B * B, axis=-1))
gain = 2 * n * (1 + np.sin(np.radians(82))) * 0.0067 / square

members, random = 1000, np.random.default_rng(2012)
axes = random.normal(size=(members, 3))
omega = axes / np.linalg.norm(axes, axis=-1, keepdims=True) * np.radians(random.uniform(2, 12, (members, 1)))
attitudes = Rotation.random(members, random_state=random).as_quat(scalar_first=True)
start = satellite.state(attitudes, omega_body=omega)

control = pt.forces.BDot(gain, field, limit=0.1)
system = pt.System(satellite, control, units={"time": "s", "inertia": "kg m2"})
motion = pt.propagate(system, start, np.linspace(0, 5 * period, 301), tolerance=1e-10)
rates = np.linalg.norm(motion.omega_body, axis=-1) / n  # (members, times)

# Where the mean torque of a body that follows the field vanishes.
change = np.gradient(B, along, axis=0, edge_order=2)
across = square * np.eye(3) - np.einsum("ni,nj->ij", B, B) / along.size
followed = np.linalg.norm(np.linalg.solve(across, np.mean(np.cross(B, change), axis=0))) / n
final = rates[:, -60:].mean(axis=-1)
print(
    f"final rates: {final.min():.2f} to {final.max():.2f} of the orbital rate; the field is followed at {followed:.2f}"
)
assert np.all(np.abs(final - followed) < 0.15)

constant = 1.5 * 0.033 / (gain * square)
slow = rates < 3
reached = motion.times[np.argmax(slow, axis=-1)]
expected = constant * np.log(rates[:, 0] / 3)
ratio = np.median(reached / expected)
print(f"gain {gain:.3g} A m2 s/T, time constant {constant / period:.2f} orbits")
print(f"below three times the orbital rate after {np.median(reached) / period:.2f} orbits, {ratio:.2f} of the estimate")
assert np.all(slow[:, -1])
assert 0.8 < ratio < 1.8  # longer where moments are at their limit

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained", width_ratios=(2, 1))
orbits = motion.times / period
left.semilogy(orbits, rates[::10].T, color="#0072B2", alpha=0.15, lw=0.7)
left.semilogy(orbits, np.median(rates, axis=0), color="k", lw=1.6, label="median of 1000")
left.axhline(followed, color="#D55E00", ls="--", label="zero mean torque")
left.set(xlabel="orbits", ylabel="angular velocity over the orbital rate", xlim=(0, 5))
left.legend(frameon=False)
bins = np.linspace(0, 2.5, 51)
right.hist(reached / period, bins, color="#0072B2", alpha=0.6, label="satellites")
right.hist(expected / period, bins, histtype="step", color="k", label="time constant alone")
right.set(xlabel="orbits until three times the orbital rate", ylabel="satellites", xlim=(0, 2.5))
right.legend(loc="lower left", bbox_to_anchor=(0, 1.0), frameon=False)
figure.savefig("detumbling.png", dpi=150)
