"""MEGNO map of a moon.

Chaotic rotation of a moon: MEGNO over the angle and the angular velocity at the periapsis.

The spin axis is kept normal to the orbit, as in Hyperion's section (Wisdom, Peale and Mignard 1984, Icarus 58, 137):
(B - A)/C = 0.26, eccentricity 0.1. White is regular, MEGNO = 2; purple are the cores of the islands, near periodic
motions; orange is chaos. The second picture has three motions against time.
"""

import numpy as np

import poinsot as pt

orbit = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.1)
moon = pt.Body.from_ratios(beta=0.47, gamma=0.26)  # (C - A)/B and (B - A)/C
system = pt.System(moon, pt.GravityGradient(orbit))

angles = np.radians(np.arange(0, 180, 4.0))  # of the long axis from the periapsis; turned by 180 deg it is the same
rates = np.linspace(0.05, 3.0, 45)  # over the mean motion
angle, rate = (each.ravel() for each in np.meshgrid(angles, rates))
zero = np.zeros_like(angle)
attitudes = np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=-1)
start = moon.state(attitudes, omega_body=np.stack([zero, zero, rate], axis=-1))

found = pt.analysis.chaos_indicators(
    system, start, [50 * orbit.period], formulation="planar", tolerance=1e-9, progress=False
)
megno, exponent = found.mean_megno[:, -1], found.lyapunov[:, -1] * orbit.period
chaotic = megno > 4
print(f"{np.mean(chaotic):.0%} of the starts are chaotic, with {np.median(exponent[chaotic]):.2f} e-foldings an orbit")
assert 0.45 < np.mean(chaotic) < 0.75
assert 0.5 < np.median(exponent[chaotic]) < 0.9

names = ("synchronous libration", "chaos", "circulation")
spins = np.array([0.35, 1.0, 2.95])[:, None] * (0, 0, 1)
three = pt.analysis.chaos_indicators(
    system,
    moon.state(np.broadcast_to((1.0, 0, 0, 0), (3, 4)), omega_body=spins),
    np.geomspace(0.2, 100, 200) * orbit.period,
    formulation="planar",
)
print(", ".join(f"{name}: MEGNO {value:.2f}" for name, value in zip(names, three.mean_megno[:, -1], strict=True)))
assert three.mean_megno[1, -1] > 20
assert np.all(three.mean_megno[[0, 2], -1] < 2.2)

panel = pt.plot.map(
    np.degrees(angles),
    rates,
    megno,
    "angle of the long axis from the periapsis [deg]",
    "rate over the mean motion",
    "mean MEGNO after 50 orbits",
    center=2,
    limits=(0, 4),
)
panel.figure.savefig("megno_map.png", dpi=150)
pt.plot.chaos(three, names)[0].figure.savefig("megno_against_time.png", dpi=150)
