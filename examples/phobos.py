r"""Librations of Phobos.

Librations of Phobos in longitude: free at $0.62301\,n$, and forced by the eccentricity with 1.1 degrees.

Linear theory of the angle $\psi$ between the long axis and the mean direction to Mars, with mean motion $n$ and
$w^2 = 3 \frac{B - A}{C} n^2$: $\ddot\psi + w^2 \psi = 2 e w^2 \sin n t$. The free libration has the frequency $w$, the
forced one the amplitude $2 e w^2/(w^2 - n^2)$, negative as $w < n$; observers find 1.1 degrees. Moments: a unit test of
Tudat.

The gravity gradient is of the second degree of the body's own field. The contribution of the fourth degree is computed
for a homogeneous ellipsoid of its size; docs/worlds.md has the theory.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import poinsot as pt

phobos = pt.Body((0.3615, 0.4265, 0.5024))  # over M R^2: the axes towards Mars, along the orbit, normal to it


def libration(eccentricity, orbits, angle=0.0, rate=0.0, body=phobos, gravity=pt.GravityGradient):
    """The libration angle after numbers of orbits, from an angle and a rate over n at the periapsis."""
    orbit = pt.KeplerOrbit(
        mu=42828.37,
        semimajor_axis=9376.0,
        eccentricity=eccentricity,
    )
    system = pt.System(body, gravity(orbit), units={"time": "s"})
    start = body.state((np.cos(angle / 2), 0, 0, np.sin(angle / 2)), omega_body=(0, 0, orbit.mean_motion * (1 + rate)))
    motion = pt.propagate(system, start, orbits * orbit.period)
    turned = 2 * np.arctan2(motion.quaternion[:, 3], motion.quaternion[:, 0])
    return (turned - 2 * np.pi * (orbits % 1) + np.pi) % (2 * np.pi) - np.pi


def linear(body):
    """The frequency of the free libration over n."""
    return np.sqrt(3 * (body.moments[1] - body.moments[0]) / body.moments[2])


# Free, on a circle: its frequency is that of the zeros.
orbits = np.linspace(0, 100, 4001)
phase = 2 * np.pi * orbits
free = libration(0.0, orbits, angle=np.radians(0.01))
i = np.flatnonzero(free[:-1] * free[1:] < 0)
zeros = phase[i] - free[i] * np.diff(phase)[i] / (free[i + 1] - free[i])
frequency = np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])
w = linear(phobos)
print(f"free libration: {frequency:.5f} n, linear theory {w:.5f} n")
assert abs(frequency - 0.6230063745604) < 5e-6

# Forced, on the ellipse, with as little free libration as linear theory can ask for.
e = 0.0151
amplitude = 2 * e * w**2 / (w**2 - 1)
forced = libration(e, orbits, rate=amplitude)
waves = [wave(x * phase) for x in (1, 2, w) for wave in (np.sin, np.cos)]
measured = np.linalg.lstsq(np.transpose(waves), forced)[0][0]
print(f"forced libration: {np.degrees(measured):.3f} deg, linear theory {np.degrees(amplitude):.3f} deg")
assert abs(measured / amplitude - 1) < 5e-3

# The fourth degree, of the homogeneous ellipsoid of its size in km: w^2 grows by (R/a)^2 (1680 C44 - 30 C42)/(12 C22),
# with C42 = 5/7 C20 C22 and C44 = 5/28 C22^2 (Balmino 1994), C20 and C22 from the squares of the semiaxes.
shape = pt.shapes.Ellipsoid((13.0, 11.4, 9.1), mass=1.0)
body, field = pt.Body.from_inertia(shape.inertia), shape.field(4)
w = linear(body)
x2, y2, z2 = np.array([13.0, 11.4, 9.1]) ** 2
growth = (5 / 4 * (x2 - y2) + 5 / 14 * ((x2 + y2) / 2 - z2)) / 9376.0**2
degrees = {2: pt.GravityGradient, 4: lambda orbit: pt.forces.HarmonicGravity(orbit, field)}


def free_frequency(gravity):
    """Its difference to w makes an angle where linear theory passes zero, a hundred librations later."""
    start, later = 1e-3, 100.25 / w
    (angle,) = libration(0.0, np.array([later]), angle=start, body=body, gravity=gravity)
    return w - np.arcsin(angle / start) / (2 * np.pi * later)


def forced_libration(gravity):
    """Its amplitude: the motion that passes the mean direction at the periapsis passes it at the apoapsis too."""

    def angles(rate, orbits):
        return libration(e, orbits, rate=rate, body=body, gravity=gravity)

    rate = brentq(lambda rate: angles(rate, np.array([0.5]))[0], -0.03, -0.01, xtol=1e-16)
    once = np.arange(400) / 400
    return 2 * np.mean(angles(rate, once) * np.sin(2 * np.pi * once))


for what, measure, expected in (
    ("free libration, frequency", free_frequency, growth / 2),
    ("forced libration, amplitude", forced_libration, growth / (1 - w**2)),
):
    second, fourth = (measure(gravity) for gravity in degrees.values())
    change = fourth / second - 1
    print(f"{what}: {second:.6f}, of degree 4 {change:.5e} more, linear theory {expected:.5e}")
    assert abs(change / expected - 1) < (1e-2 if measure is forced_libration else 1e-5)

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
shown = orbits < 8
axes.plot(orbits[shown], np.degrees(forced[shown]), color="#0072B2", label="forced by the ellipse")
axes.plot(orbits[shown], 100 * np.degrees(free[shown]), color="#D55E00", label="free on a circle, 100 times")
axes.set_xlabel("orbits")
axes.set_ylabel("libration [deg]")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
axes.grid(alpha=0.25)
figure.savefig("phobos.png", dpi=150)
