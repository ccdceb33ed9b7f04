r"""Momentum management by magnetorquers.

Momentum management: the wheels of a CubeSat point it along its orbit, and magnetorquers take their momentum away.

Wheels store what external torques bring, up to their largest speed. A magnetic moment $\mathbf m$ in the field
$\mathbf B$ of the Earth gives the torque $\mathbf m \times \mathbf B$, across the field alone: with
$\mathbf m = k\, \mathbf h \times \mathbf B / B^2$, $\mathbf h$ the momentum of the wheels, it is
$-k (\mathbf h - \mathbf b (\mathbf b \cdot \mathbf h))$, $\mathbf b$ along $\mathbf B$, and $\mathbf h$ dies away as
$\mathbf b$ turns along the orbit (Camillo and Markley 1980, J. Guid. Control 3, 567). Both controllers are digital:
pointing at 2 Hz through the wheels, magnetorquers at 1 Hz, each with a limit.

The momentum of satellite and wheels in space changes by external torques alone, whatever the wheels do. So SciPy can
integrate that of the wheels by itself: $\dot{\mathbf h} = -k (1 - \mathbf b \mathbf b^T) \mathbf h + \text{bias}$ in
space, for a body whose axes are those of the orbit. The picture shows the speeds of the wheels with and without
magnetorquers, the torques of these, and the error of pointing.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import poinsot as pt
from poinsot import functions as fn
from poinsot.control import OrbitPointing, Sampled
from poinsot.functions import Vector
from poinsot.parts import ReactionWheels

RADIUS, MU = 6371.2, 398600.4418  # km, s
orbit = pt.KeplerOrbit(MU, semimajor_axis=RADIUS + 500, eccentricity=0.0, inclination=1.2, node=0.5)
earth = pt.orbits.RotationModel(0, np.pi / 2, 0, rate=7.292115e-5)
field = pt.forces.TiltedDipole(orbit, earth, -29350e-9, -1410.3e-9, 4545.5e-9, RADIUS)
inertia, frequency = np.array((0.13, 0.16, 0.21)), 0.25  # kg m2; rad/s
gain, most, bias = 1e-3, 0.5, np.array((1.0e-7, -0.5e-7, 0.8e-7))  # 1/s, A m2, N m


class Magnetorquers(pt.Torque):
    """Moments against the momentum of wheels, within a limit."""

    wheels: ReactionWheels
    field: pt.forces.TiltedDipole
    gain: float
    limit: float

    def moment(self, instant):
        field = self.field.in_body(instant)
        momentum = self.wheels.momentum(instant.own(self.wheels), instant.time)
        wanted = fn.cross(momentum, field) * (self.gain / fn.dot(field, field))
        return Vector(fn.clip(component, -self.limit, self.limit) for component in wanted)

    def torque(self, instant):
        return fn.cross(self.moment(instant), self.field.in_body(instant))


class Bias(pt.Torque):
    """A torque that stays in space, as that of the solar wind does for hours."""

    size: pt.SpaceVector

    def torque(self, instant):
        return instant.attitude.to_body(self.size)


pointing = OrbitPointing(2 * inertia[1] * frequency**2, 2 * inertia[1] * frequency, 2e-3, orbit)
wheels = ReactionWheels(np.eye(3), 2e-5, Sampled(pointing, 0.5), 2e-3, 600.0)
torquers = Sampled(Magnetorquers(wheels, field, gain, most), 1.0, name="torquers")
body, times = pt.Body(inertia), np.linspace(0, 4 * orbit.period, 2001)
axes, turning = orbit.frame.quaternion(0.0), (0, 0, orbit.mean_motion)


def run(*forces):
    """The motion from wheels that turn fast, in the axes of the orbit."""
    system = pt.System(body, wheels, Bias(bias), *forces, units={"time": "s", "inertia": "kg m2"})
    speeds = np.array((350.0, -300.0, 400.0))
    start = system.state(axes, omega_body=turning, reaction_wheels=2e-5 * (speeds + turning))
    return pt.propagate(system, start, times)


def momenta(motion):
    """Those of the wheels, in space."""
    return motion.attitude.apply(motion.own["reaction_wheels"])


def unloaded(time, h):
    """The rate of the momentum of the wheels by the averaged law; the body keeps its own along the orbit."""
    b = np.array([float(x) for x in field.in_space(orbit.position_at(time), time)])
    b /= np.linalg.norm(b)
    return -gain * (h - b * (b @ h)) + bias


alone, managed = run(), run(torquers)
expected = solve_ivp(unloaded, (0, times[-1]), momenta(managed)[0], rtol=1e-9, atol=1e-15, t_eval=times).y.T
off = np.linalg.norm(momenta(managed) - expected, axis=-1) / np.linalg.norm(expected[0])
left = np.linalg.norm(momenta(managed), axis=-1) / np.linalg.norm(expected[0])
error = np.degrees(2 * np.linalg.norm(managed.relative_to(orbit.frame).quaternion[:, 1:], axis=-1))
speeds = {name: motion.own["reaction_wheels"] / 2e-5 for name, motion in (("without", alone), ("with", managed))}
print(f"{managed.run.steps} steps in {managed.run.wall_time:.2f} s: {left[-1]:.3%} of the wheels' momentum is left")
print(f"largest difference from the law in space: {off.max():.1e}; pointing error {error.max():.4f} deg")
grown = alone.angular_momentum_space[-1] - alone.angular_momentum_space[0]
print(f"without magnetorquers the bias brings {np.linalg.norm(grown):.2e} N m s")
assert np.linalg.norm(grown - bias * times[-1]) < 1e-13  # whatever the wheels do
assert left[-1] < 0.02
assert off.max() < 3e-3
assert error[times > 600].max() < 0.05

figure = plt.figure(figsize=(10, 6), layout="constrained")
panels = figure.subplots(2, 2, sharex=True)
hours = times / 3600
for axis, colour in enumerate(("#0072B2", "#D55E00", "#009E73")):
    for panel, name in zip(panels[0], speeds, strict=True):
        panel.plot(hours, speeds[name][:, axis] * 60 / (2 * np.pi), color=colour, label=f"wheel {axis + 1}")
    panels[1, 0].plot(hours, 1e6 * managed.own["torquers"][:, axis], color=colour, label=f"axis {axis + 1}")
panels[1, 1].plot(hours, 3600 * error, color="#000000")
panels[0, 0].set(ylabel="speed without magnetorquers [rpm]")
panels[0, 1].set(ylabel="speed with magnetorquers [rpm]")
panels[1, 0].set(xlabel="time [h]", ylabel="torque of magnetorquers [µN m]")
panels[1, 1].set(xlabel="time [h]", ylabel="pointing error [arcsec]", xlim=(0, hours[-1]))
for panel in panels.flat:
    panel.grid(alpha=0.25)
panels[0, 1].legend(frameon=False)
figure.savefig("desaturation.png", dpi=150)
