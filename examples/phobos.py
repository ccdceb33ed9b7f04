"""Phobos keeps one face to Mars, and librates: freely at 0.62301 n, and forced by its ellipse by 1.1 degrees.

Linear theory of the angle psi between the long axis and the mean direction to Mars, with mean motion n and
w^2 = 3 (B - A)/C n^2: psi'' + w^2 psi = 2 e w^2 sin(n t). The free libration has the frequency w, the forced one the
amplitude 2 e w^2/(w^2 - n^2), negative as w < n; observers find 1.1 degrees. Moments: a unit test of Tudat.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

phobos = pt.Body((0.3615, 0.4265, 0.5024))  # over M R^2: the axes towards Mars, along the orbit, normal to it


def libration(eccentricity, orbits, angle=0.0, rate=0.0):
    """Mean motion, times and libration angle, from an angle and a rate over n at the periapsis."""
    orbit = pt.KeplerOrbit(
        mu=42828.37,
        semimajor_axis=9376.0,
        eccentricity=eccentricity,
        inclination=0.0,
        node=0.0,
        argument_of_periapsis=0.0,
    )
    n = orbit.mean_motion
    system = pt.System(phobos, pt.GravityGradient(orbit), units={"time": "s"})
    start = phobos.state((np.cos(angle / 2), 0, 0, np.sin(angle / 2)), omega_body=(0, 0, n * (1 + rate)))
    motion = pt.propagate(system, start, np.linspace(0, orbits * orbit.period, 40 * orbits + 1))
    turned = 2 * np.arctan2(motion.quaternion[:, 3], motion.quaternion[:, 0])
    return n, motion.times, (turned - n * motion.times + np.pi) % (2 * np.pi) - np.pi


# Free, on a circle: its frequency is that of the zeros.
n, t, free = libration(eccentricity=0.0, orbits=100, angle=np.radians(0.01))
i = np.flatnonzero(free[:-1] * free[1:] < 0)
zeros = t[i] - free[i] * np.diff(t)[i] / (free[i + 1] - free[i])
frequency = np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0]) / n
w = np.sqrt(3 * (phobos.moments[1] - phobos.moments[0]) / phobos.moments[2])
print(f"free libration: {frequency:.5f} n, linear theory {w:.5f} n")
assert abs(frequency - 0.6230063745604) < 5e-6

# Forced, on the ellipse, with as little free libration as linear theory can ask for.
e = 0.0151
amplitude = 2 * e * w**2 / (w**2 - 1)
n, t, forced = libration(eccentricity=e, orbits=100, rate=amplitude)
waves = [wave(x * n * t) for x in (1, 2, w) for wave in (np.sin, np.cos)]
measured = np.linalg.lstsq(np.transpose(waves), forced)[0][0]
print(f"forced libration: {np.degrees(measured):.3f} deg, linear theory {np.degrees(amplitude):.3f} deg")
assert abs(measured / amplitude - 1) < 5e-3

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
shown = n * t < 2 * np.pi * 8
axes.plot(n * t[shown] / (2 * np.pi), np.degrees(forced[shown]), color="#0072B2", label="forced by the ellipse")
axes.plot(
    n * t[shown] / (2 * np.pi), 100 * np.degrees(free[shown]), color="#D55E00", label="free on a circle, 100 times"
)
axes.set_xlabel("orbits")
axes.set_ylabel("libration [deg]")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
axes.grid(alpha=0.25)
figure.savefig("phobos.png", dpi=150)
