r"""Librations of a satellite on a boom.

Librations of a satellite with a long boom about the vertical, in the gravity gradient of the Earth.

A bus of 60 kg, and 3 kg at the end of a boom of six metres, on a circle with mean motion $n$. Linear theory for moments
$A$ (about the boom), $B$ (along the motion), $C$ (across the orbit), with $k = (C - A)/B$ and $l = (C - B)/A$ (Hughes
1986, Spacecraft Attitude Dynamics, Ch. 9), gives the frequency of pitch, in the plane of the orbit, and those of roll
and yaw, which are coupled,

$$ w^2 = 3 n^2 \frac{B - A}{C}, \qquad w^4 - (1 + 3 k + k l)\, n^2 w^2 + 4 k l n^4 = 0, $$

in the limit of a dumbbell $\sqrt3\, n$, $2 n$ and $\sqrt l\, n$. Pitch alone is a pendulum in twice the angle: at the
amplitude $a$ its frequency is $\pi/(2 K(\sin^2 a))$ of that, with the complete elliptic integral $K$. The picture shows
a libration of 10 degrees, and how the frequency falls with the amplitude.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

import poinsot as pt

# Bus, boom and tip: mass [kg], sides [m] and place [m] along the first axis, the boom's.
parts = [(60.0, (0.6, 0.4, 0.3), 0.0), (1.2, (6.0, 0.02, 0.02), 3.3), (3.0, (0.1, 0.1, 0.1), 6.35)]
centre = sum(mass * place for mass, _, place in parts) / sum(mass for mass, _, _ in parts)
across = np.diag([0.0, 1.0, 1.0])
inertia = sum(
    pt.Body.from_box(mass, sides).inertia + mass * (place - centre) ** 2 * across for mass, sides, place in parts
)
satellite = pt.Body.from_inertia(inertia)
A, B, C = satellite.moments

orbit = pt.KeplerOrbit(mu=398600.4418, semimajor_axis=7000.0, eccentricity=0.0, inclination=0.9, node=0.3)
system = pt.System(satellite, pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})
(rest,) = pt.analysis.equilibria(system, orbit.frame, guesses=(1, 0, 0, 0))  # the boom along the vertical
n = orbit.mean_motion


def tilted(angles, momentum=(0, 0, 0)):
    """The motion for twenty revolutions from rest, turned by small angles and with a change of the momentum."""
    attitude = rest.state.attitude * Rotation.from_rotvec(angles)
    start = satellite.state(attitude, angular_momentum_body=rest.state.angular_momentum_body + momentum)
    return pt.propagate(system, start, np.linspace(0, 20 * orbit.period, 4001), dense=True)


def angle_at(motion, axis, time):
    """The rotation vector from the orbit's axes, in radians: yaw (0), roll (1), pitch (2)."""
    frame = Rotation.from_quat(orbit.frame.quaternion(time), scalar_first=True)
    return (frame.inv() * motion(time).attitude).as_rotvec()[..., axis]


def frequency(motion, axis):
    """That of an oscillation, from the zeros of its angle."""
    angle = angle_at(motion, axis, motion.times)
    changes = np.flatnonzero(angle[:-1] * angle[1:] < 0)
    zeros = [brentq(lambda t: angle_at(motion, axis, t), *motion.times[i : i + 2], xtol=1e-9) for i in changes]
    return np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])


k, l = (C - A) / B, (C - B) / A
yaw, roll = np.sqrt(np.sort(np.roots([1, -(1 + 3 * k + k * l), 4 * k * l])))
theory = {"yaw": (yaw, np.sqrt(l)), "roll": (roll, 2.0), "pitch": (np.sqrt(3 * (B - A) / C), np.sqrt(3))}
values, modes = np.linalg.eig(rest.matrix)
print(f"A, B, C = {A:.3f}, {B:.3f}, {C:.3f} kg m2: {rest.stability}")
for axis, (name, (expected, limit)) in enumerate(theory.items()):
    i = np.argmin(np.abs(values - 1j * expected * n))
    mode = np.real(modes[:, i] / modes[axis, i])
    found = frequency(tilted(1e-4 * mode[:3], 1e-4 * mode[3:]), axis)
    print(f"{name:5}: {found / n:.9f} n, linear theory {expected:.9f} n, dumbbell {limit:.4f} n")
    assert abs(found / n / expected - 1) < 3e-9  # of which the amplitude, squared and over 4, is 2.5e-9
    assert abs(values[i].imag / n / expected - 1) < 1e-14

amplitudes = np.radians([1.0, 10, 20, 30, 40, 50, 60])
measured = np.array([frequency(tilted((0, 0, amplitude)), 2) / n for amplitude in amplitudes])
pendulum = theory["pitch"][0] * np.pi / 2 / ellipk(np.sin(amplitudes) ** 2)
print(f"pitch of 1 to 60 degrees: {np.max(np.abs(measured / pendulum - 1)):.1e} from the pendulum's")
assert np.max(np.abs(measured / pendulum - 1)) < 2e-13

motion, figure = tilted(np.radians([0.0, 10, 10])), plt.figure(figsize=(10, 4), layout="constrained")
figure.get_layout_engine().set(wspace=0.05)
swing, slowing = figure.subplots(1, 2, width_ratios=(3, 2))
times = np.linspace(0, 3 * orbit.period, 1001)
for axis, name, colour in ((1, "roll", "#000000"), (2, "pitch", "#0072B2"), (0, "yaw", "#D55E00")):
    swing.plot(times / 60, np.degrees(angle_at(motion, axis, times)), color=colour, label=name)
swing.set(xlabel="time [min]", ylabel="angle from the orbit's axes [deg]", xlim=(0, times[-1] / 60))
angles = np.radians(np.linspace(0, 65, 131))
curve = theory["pitch"][0] * np.pi / 2 / ellipk(np.sin(angles) ** 2)
slowing.plot(np.degrees(angles), curve, color="#000000", label="pendulum")
slowing.plot(np.degrees(amplitudes), measured, "o", color="#0072B2", label="measured")
slowing.set(xlabel="amplitude of the pitch [deg]", ylabel="frequency [mean motion]", xlim=(0, 65))
for panel in (swing, slowing):
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    panel.grid(alpha=0.25)
figure.savefig("gravity_gradient_satellite.png", dpi=150)
