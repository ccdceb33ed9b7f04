"""Pointing budget of a CubeSat.

Where a 12U CubeSat points, and which torque disturbs it: an orbit from a two-line element set.

Gravity, air that turns with the Earth, sunlight with the Earth's shadow, and a residual magnetic moment in the IGRF
disturb it; four wheels in a pyramid, driven by proportional and derivative feedback, hold it to the axes of the orbit.
The satellite and its elements are made up, of ordinary size; kg m^2, m, s. The orbit is SGP4's, along the axes of the
ICRF, that of the Earth VSOP2013's. The picture shows the torques, roll, pitch and yaw, the wheels, and the budget: what
each effect alone does to the pointing.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces import (
    IGRF,
    AtmosphericDrag,
    ExponentialAtmosphere,
    Facets,
    MagneticMoment,
    Occulter,
    RadiationPressure,
)

ELEMENTS = (
    "1 99999U 26001A   26079.50000000  .00002000  00000-0  10000-3 0  9999",
    "2 99999  97.4000 130.0000 0012000  80.0000 280.0000 15.21900000    11",
)
REVOLUTION = 86400 / 15.219
SPAN = (0.0, 2.1 * REVOLUTION)

# Where it is: about the Earth, about the Sun, and how the Earth turns.
orbit = pt.orbits.kilometres_to_metres(pt.files.tle_orbit(ELEMENTS, *SPAN, reference_frame="ICRF"))
of_earth = pt.orbits.kilometres_to_metres(pt.orbits.planet_orbit("earth", "sun", *SPAN, calendar=orbit.calendar))
sun = pt.orbits.composite_orbit(orbit, of_earth)
earth = pt.orbits.RotationModel.earth(calendar=orbit.calendar)

# What it is: 24 kg in a box with two wings, whose centre of mass is not in the middle.
body = pt.Body.from_inertia([(0.62, 0.004, -0.003), (0.004, 0.31, 0.005), (-0.003, 0.005, 0.55)])
facets = Facets.from_box(
    (0.226, 0.226, 0.341),
    (0.004, -0.003, 0.010),
    wing_areas=[0.18, 0.18],
    wing_normals=[(0, 0, 1), (0, 0, 1)],
    wing_positions=[(0, 0.42, 0.1), (0, -0.42, 0.1)],
    specular=0.2,
    diffuse=0.2,
)
air = ExponentialAtmosphere(1.0e-12, 6.878e6, 6.3e4, omega_space=earth.omega_space(0.0))  # at 500 km
disturbances = {
    "gravity": pt.GravityGradient(orbit),
    "drag": AtmosphericDrag(orbit, air, facets),
    "sunlight": RadiationPressure(sun, facets, [Occulter(orbit, 6.3781e6)]),
    "magnetism": MagneticMoment((0.01, -0.02, 0.015), IGRF(orbit, earth, degree=8, radius=6.3712e6)),  # A m^2
}

# What holds it: wheels of 15 mN m s.
LEVEL = (0.5, -0.5, -0.5, 0.5)  # first axis forward, third one down: no roll, pitch and yaw
law = pt.control.OrbitPointing(kp=0.02, kd=0.12, limit=2e-3, orbit=orbit, target=LEVEL)
axes = np.array([(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)]) / np.sqrt(3)
wheels = pt.parts.ReactionWheels(axes, 2.4e-5, law, largest_torques=4e-3, largest_speeds=630.0, friction=2e-8)


def motion_with(*effects):
    """Return a revolution under some of the disturbances, level and at rest in the orbit at first."""
    forces = [disturbances[name] for name in effects]
    system = pt.System(body, wheels, *forces, units={"time": "s", "inertia": "kg m2"})
    start = system.state(LEVEL, omega_body=(0, 0, 0), frame=orbit.frame)
    return pt.propagate(system, start, np.linspace(0, REVOLUTION, 1136))


def pointing_error(motion):
    """Return the angle between the body and where it should point, arcminutes."""
    level = Rotation.from_quat(LEVEL, scalar_first=True)
    return 60 * np.degrees((level.inv() * motion.relative_to(orbit.frame).attitude).magnitude())


def size(vectors):
    """Return the lengths of vectors."""
    return np.linalg.norm(vectors, axis=-1)


motion = motion_with(*disturbances)
error = pointing_error(motion)
settled = motion.times > 600
print(f"pointing error after ten minutes: at most {error[settled].max():.2f} arcminutes")

# A slow torque T turns the body by 2 T / kp, as the law acts on half the angle. Two are of the wheels: their momentum
# turns with the orbit, g x omega, and their friction carries the body along.
speeds = wheels.speeds(motion.own["reaction_wheels"], motion.omega_body)
of_wheels = np.cross(motion.angular_momentum_body, motion.omega_body) + wheels.friction[0] * speeds @ axes
slow = 60 * np.degrees(2 * size(sum(motion.torques_body.values()) + of_wheels) / law.kp)
print(f"with the torques that act: at most {slow[settled].max():.2f} arcminutes")
assert np.max(np.abs(error - slow)[settled]) < 0.05 * np.max(slow)

budget = {name: pointing_error(motion_with(name)) for name in disturbances} | {"none": pointing_error(motion_with())}
for name, values in budget.items():
    print(f"{name:>9}: {np.sqrt(np.mean(values[settled] ** 2)):.4f} arcminutes (root mean square)")

# The shadow of a sphere on a circle whose plane is the angle beta from the Sun.
place, velocity, shine = (np.array(vector(0.0)) for vector in (orbit.position_at, orbit.velocity_at, sun.position_at))
normal = np.cross(place, velocity)
beta = np.arcsin(normal @ shine / (size(normal) * size(shine)))
height = np.mean(size(np.transpose(list(orbit.position_at(motion.times)))))
geometry = np.arccos(np.sqrt(1 - (6.3781e6 / height) ** 2) / np.cos(beta)) / np.pi
dark = np.mean(size(motion.torques_body["RadiationPressure"]) == 0)
print(f"in the shadow for {100 * dark:.1f}% of the revolution, by plane geometry for {100 * geometry:.1f}%")
assert abs(dark - geometry) < 0.01

figure, panels = plt.subplots(2, 2, figsize=(12, 9), layout="constrained")
pt.plot.torques(motion, ax=panels[0, 0], time_unit="min")
pt.plot.roll_pitch_yaw(motion, orbit, ax=panels[0, 1], angle_unit="arcmin", time_unit="min")
panels[0, 1].set_ylabel("pointing error [arcmin]")
colors = "#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7"
for panel in panels[1]:
    panel.set_prop_cycle(color=colors)
panels[1, 0].plot(motion.times / 60, speeds * 30 / np.pi, label=[f"wheel {i}" for i in (1, 2, 3, 4)])
panels[1, 0].set(xlabel="time [min]", ylabel="speed of the wheels [rpm]")
for name, values in budget.items():
    panels[1, 1].semilogy(
        motion.times / 60, np.maximum(values, 1e-3), label=f"{name} alone" if name != "none" else name
    )
panels[1, 1].set(xlabel="time [min]", ylabel="angle of the pointing error [arcmin]", ylim=(2e-3, None))
for panel, columns in zip(panels[1], (4, 3), strict=True):
    panel.grid(alpha=0.25)
    panel.set_xlim(0, motion.times[-1] / 60)
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, fontsize="small", frameon=False)
figure.savefig("cubesat.png", dpi=150)
