r"""Thermal snap of a boom.

A boom that bends in sunlight turns its satellite: thermal snap at the edges of the Earth's shadow.

A bus of 60 kg hangs in the gravity gradient of the Earth on a boom of six metres, 3 kg at its end (the satellite of
gravity_gradient_satellite.py, its boom without mass). Sunlight makes one side of the boom longer: a tube of length $L$
and diameter $d$ with the difference $T$ of temperatures across it and the expansion $a$ bends by $a T L^2/(2 d)$, here
18 mm for 1 K, 20 mm and 2e-5/K (assumed, of the usual size). In the shadow it is straight. Both take a minute, the time
in which a thin tube warms and cools. Bus, boom and tip are one free body: as the tip moves by $s$, the bus turns by
$\mu y s/B$ the other way, where $y$ is the distance of bus and tip, $\mu$ their reduced mass and $B$ the moment of
inertia across; the line from bus to tip, along which gravity holds them, keeps its direction but for a small part
$A/B$. The picture shows the pitch of the bus and of this line for two orbits, and for four minutes about a sunrise.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions as fn

bus, tip, length, bend = 60.0, 3.0, 6.35, 0.018
mu = bus * tip / (bus + tip)
box = pt.Body.from_box(bus, (0.6, 0.4, 0.3)).inertia  # kg m2
satellite = pt.Body.from_inertia(box + mu * length**2 * np.diag([0.0, 1.0, 1.0]))
orbit = pt.KeplerOrbit(mu=398600.4418, semimajor_axis=7000.0, eccentricity=0.0)
n, shadow = orbit.mean_motion, 2 * np.arcsin(6378.0 / 7000.0)  # the angle of the orbit in the shadow


class SunlitBoom(pt.parts.MovingMasses):
    """Straight in the shadow, which is about the angle 0 of the orbit, and bent outside; `duration` for a change."""

    rate: float
    edge: float

    def progress(self, time):
        """From 0 to 1 as the Sun rises."""
        speed = self.rate * fn.sqrt(1 - self.edge * self.edge)
        x = fn.clip((self.edge - fn.cos(self.rate * time)) / (speed * self.duration) + 0.5, 0.0, 1.0)
        return x * x * x * (10 - x * (15 - 6 * x))


arm = length * bus / (bus + tip)
boom = SunlitBoom([tip], bus + tip, [(arm, 0, 0)], [(arm, bend, 0)], 0.0, 60.0, n, np.cos(shadow / 2))
system = pt.System(satellite, boom, pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})
frame = orbit.frame
start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=frame)  # the first axis along the vertical
times = np.linspace(0, 2 * orbit.period, 4001)
motion = pt.propagate(system, start, times, dense=True)


def pitch(time):
    """The angle of the bus from the orbit's axes, and that of the line from bus to tip."""
    axes = Rotation.from_quat(frame.quaternion(time), scalar_first=True)
    turn = (axes.inv() * motion(time).attitude).as_rotvec()[..., 2]
    bent = np.array([float(boom.progress(t)) for t in np.ravel(time)]).reshape(np.shape(time))
    return turn, turn + np.arctan(bent * bend / length)


sunrise = shadow / 2 / n
before, after = (np.array(pitch(np.array([sunrise + side * 45.0]))) for side in (-1, 1))
jump, line = (after - before)[:, 0]
A, B = satellite.moments[0], satellite.moments[2]
expected = -mu * length * bend / B
print(f"sunrise turns the bus by {np.degrees(jump):.4f} deg, expected {np.degrees(expected):.4f} deg")
print(f"and the line to the tip by {np.degrees(line):.4f} deg; A/B = {A / B:.4f}")
assert abs(jump / expected - 1) < 2e-3  # while gravity and libration turn it on
assert abs(line) < 3 * A / B * abs(jump)

figure, (long, short) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained", width_ratios=(3, 2))
for panel, shown, unit in ((long, times, 60.0), (short, sunrise + np.linspace(-120, 120, 481), 1.0)):
    origin = 0.0 if panel is long else sunrise
    of_bus, of_line = np.degrees(pitch(shown))
    panel.plot((shown - origin) / unit, of_bus, color="#0072B2", label="bus")
    panel.plot((shown - origin) / unit, of_line, color="#D55E00", label="line from bus to tip")
    panel.set(ylabel="pitch [deg]", xlim=((shown[0] - origin) / unit, (shown[-1] - origin) / unit))
    panel.grid(alpha=0.25)
for i in range(3):
    ends = np.clip((i * orbit.period + np.array([-sunrise, sunrise])) / 60, 0, times[-1] / 60)
    long.axvspan(*ends, color="#000000", alpha=0.1, linewidth=0, label="shadow" if i == 0 else None)
long.set(xlabel="time [min]")
short.set(xlabel="time from sunrise [s]")
long.legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
figure.savefig("thermal_snap.png", dpi=150)
