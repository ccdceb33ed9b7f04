"""Covariance of an attitude over an orbit.

Covariance propagation of an attitude over an orbit by the state-transition matrix, and Monte Carlo samples.

A satellite in the gravity gradient is known at the start to 0.1 degrees and 0.0005 degrees per second, its moments of
inertia to half a percent. The state-transition matrix propagates the covariance; 4000 Monte Carlo samples agree.
"""

import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

moments = np.array([80.0, 100.0, 60.0])  # kg m2: roll, pitch, yaw
orbit = pt.KeplerOrbit(mu=398600.4418e9, semimajor_axis=7000e3, eccentricity=0.001, inclination=1.7)
body = pt.Body(moments)
system = pt.System(body, pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})
start = body.state(Rotation.from_euler("xyz", (3, 5, 4), degrees=True), omega_body=(0, 0, 0), frame=orbit.frame)
times = np.linspace(0, orbit.period, 201)

degree = np.radians(1)
of_attitude, of_momentum = 0.1 * degree, moments * 0.0005 * degree
initial = np.diag(np.concatenate([np.full(3, of_attitude), of_momentum]) ** 2)
names = ["moments[0]", "moments[1]", "moments[2]"]
of_moments = np.diag((0.005 * moments) ** 2)

transition = pt.analysis.state_transition(system, start, times, names)
covariance = transition.covariance(initial, of_moments)
predicted = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))

random, members = np.random.default_rng(1), 4000
theta = random.normal(scale=of_attitude, size=(members, 3))
gamma = random.normal(size=(members, 3)) * of_momentum
drawn = pt.Body(moments * (1 + 0.005 * random.normal(size=(members, 3))))
nominal = Rotation.from_quat(start.quaternion, scalar_first=True)
starts = drawn.state(nominal * Rotation.from_rotvec(theta), angular_momentum_body=start.angular_momentum_body + gamma)
every = slice(None, None, 20)
cloud = pt.propagate(pt.System(drawn, pt.GravityGradient(orbit)), starts, times[every], progress=False)
turns = [
    attitude.inv() * Rotation.from_quat(cloud.quaternion[:, n], scalar_first=True)
    for n, attitude in enumerate(transition.motion.attitude[every])
]
measured = np.stack([np.std(turn.as_rotvec(), axis=0) for turn in turns]), np.std(cloud.angular_momentum_body, axis=0)
ratio = np.hstack(measured) / predicted[every]

print(f"standard deviations after an orbit: {np.degrees(predicted[-1, :3]).round(3)} deg")
print(f"{members} Monte Carlo samples over the matrix: {ratio.min():.3f} ... {ratio.max():.3f}")
assert np.sum(np.abs(ratio - 1) > 0.06) == 1  # the first momentum where it is best known: the second order shows

axes = pt.plot.uncertainty(transition, initial, of_moments, angle_unit="deg", time_unit="min")
for ax, sampled in zip(axes, (np.degrees(measured[0]), measured[1]), strict=True):
    dots = ax.plot(times[every] / 60, sampled, ".", color="#8C8C8C")
    dots[0].set_label(f"{members} samples")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)
axes[0].figure.savefig("attitude_covariance.png", dpi=150)
