"""A glinting rocket body.

A tumbling rocket stage glints whenever its side mirrors the Sun to the observer, at times that geometry predicts.

The stage is a cylinder with 72 shiny facets, 10 m long, on a circular orbit 850 km high. It turns end over end in half
a minute and rolls slowly. A station on the rotating Earth sees it after sunset. Its side is a mirror for directions
that are symmetric about a normal of the side, so a glint occurs when the long axis is perpendicular to the direction
midway between the Sun and the observer. The program finds the glints in the light curve, and compares their times with
the zeros of this scalar product. The axis of the stage for the prediction follows from the closed form for symmetric
bodies, a uniform rotation about the angular momentum, and not from the simulation.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.signal import find_peaks
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.observables import LightCurve, Phong

# The surface of the stage: a prism with 72 sides around the third axis, in metres.
LENGTH, RADIUS, MASS, SIDES = 10.0, 1.5, 2000.0, 72
angles = 2 * np.pi * np.arange(SIDES) / SIDES
ring = RADIUS * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
up = np.array((0, 0, LENGTH / 2))
i, j = np.arange(SIDES), np.roll(np.arange(SIDES), -1)
below, above = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
faces = [(i, j, j + SIDES), (i, j + SIDES, i + SIDES), (j, i, below), (i + SIDES, j + SIDES, above)]
surface = pt.shapes.Mesh(
    np.concatenate([ring - up, ring + up, [-up, up]]),
    np.concatenate([np.stack(corners, axis=-1) for corners in faces]),
    mass=MASS,
)
across, along = MASS * (RADIUS**2 / 2 + LENGTH**2 / 12), MASS * RADIUS**2  # thin shell
body = pt.Body((across, across, along))

# The pass over the station, with the Sun behind the observer in the west.
orbit = pt.KeplerOrbit(
    3.986004418e14, semimajor_axis=7.228e6, eccentricity=0.0, inclination=np.radians(81.0), node=np.radians(4.0)
)
earth = pt.orbits.RotationModel(0.0, np.pi / 2, -np.pi / 2, rate=7.292115e-5)
station = pt.orbits.GroundStation(
    orbit, earth, latitude=np.radians(48.0), longitude=np.radians(6.0), minimum_elevation=np.radians(20.0)
)
to_sun = np.array((-0.35, -0.9, 0.25)) / np.linalg.norm((-0.35, -0.9, 0.25))
sun = pt.orbits.FixedPosition(1.32712440018e20, position=-1.495978707e11 * to_sun)

START = Rotation.from_euler("ZXZ", (20, 70, 0), degrees=True)
RATE = np.array((2 * np.pi / 30, 0.0, 0.01))  # body axes, rad/s
times = np.arange(400.0, 1200.0, 0.05)
times = times[station.elevation_at(times) > station.minimum_elevation]
system = pt.System(body, units={"time": "s", "inertia": "kg m2"})
motion = pt.propagate(system, body.state(START, omega_body=RATE), np.append(0.0, times), dense=True)

curve = LightCurve(
    surface, Phong(diffuse=0.1, specular=0.4, n=100), sun, station, kind="magnitude", astronomical_unit=1.495978707e11
)
seen = pt.observe(motion, curve, times=times)
print(f"above 20 deg for {np.ptp(times):.0f} s, magnitudes {np.min(seen.values):.1f} to {np.max(seen.values):.1f}")

# The prediction: the axis turns about the angular momentum at the rate |G| / across.
momentum = START.apply(RATE * body.moments)
turning = momentum / across


def axis(t):
    return (Rotation.from_rotvec(turning * t) * START).apply((0, 0, 1))


def offset(t):
    """Return the cosine between the axis and the direction midway between Sun and station, less the light time."""
    place = np.array([float(x) for x in station.position_at(t)])
    distance = np.linalg.norm(place)
    middle = to_sun - place / distance
    return axis(t - distance / 299792458.0) @ middle / np.linalg.norm(middle)


grid = times[::20]
values = [offset(t) for t in grid]
predicted = [brentq(offset, *grid[i : i + 2]) for i in range(grid.size - 1) if values[i] * values[i + 1] < 0]
whole = [t for t in predicted if times[0] + 5 < t < times[-1] - 5]
peaks, _ = find_peaks(-seen.values, prominence=2)
found = [t for t in times[peaks] if times[0] + 5 < t < times[-1] - 5]
assert len(found) == len(whole)
differences = np.abs(np.subtract(found, whole))
print(f"{len(found)} glints, at the predicted times to {np.max(differences):.2f} s")
assert np.max(differences) < 0.1

figure, axes = plt.subplots(2, 1, figsize=(9, 7), layout="constrained", height_ratios=(3, 2))
pt.plot.readings(seen, ax=axes[0], time_unit="s")
for i, t in enumerate(predicted):
    axes[0].axvline(t, color="#D55E00", linewidth=0.8, label=None if i else "predicted glints", zorder=0)
axes[0].legend(frameon=False)
middle = len(predicted) // 2
first, second = predicted[middle : middle + 2]
pt.plot.sky(motion, curve, np.linspace(first, second, 5)[:4], ax=axes[1], time_unit="s")
figure.savefig("glinting_rocket.png", dpi=150)
