"""Chaos of Dimorphos over its shape.

Where the attitude of Dimorphos is chaotic after the impact of DART: MEGNO over its shape.

Before the impact Dimorphos kept one side to Didymos. The impact has made its orbit eccentric, by 0.03. Where the
librations that this forces meet resonances with free motions of Dimorphos, it tumbles, as Agrusa et al. (2021, Icarus
370, 114624) find; the narrow strip at a/b = 1.09 is where a libration takes two orbits. White and purple are regular,
orange is chaos. Both bodies and their orbit move together. The map of docs/dart.md has 100 x 100 shapes.
"""

import numpy as np

import poinsot as pt

SIZE = 12  # shapes along each axis
DISTANCE, RADIUS, DENSITY = 1189.0, 75.5, 2400.0  # m; of a ball of its volume, m; kg/m^3

a_to_b, b_to_c = np.linspace(1.005, 1.5, SIZE), np.linspace(1.005, 1.6, SIZE)
first, second = (each.ravel() for each in np.meshgrid(a_to_b, b_to_c))
mass, b = DENSITY * 4 / 3 * np.pi * RADIUS**3, RADIUS * (second / first) ** (1 / 3)
squares = np.stack([(b * first) ** 2, b**2, (b / second) ** 2], axis=-1)
moments = mass / 5 * (np.sum(squares, axis=-1, keepdims=True) - squares)
didymos = pt.Body.from_ellipsoid(5.26e11, (394, 394, 290))
pair = pt.TwoBodies(didymos, pt.Body(moments, mass=mass))

quadrupoles = (np.sum(didymos.moments) - 3 * didymos.moments[0]) / 5.26e11
quadrupoles = quadrupoles + (np.sum(moments, axis=-1) - 3 * moments[:, 0]) / mass
rate = np.sqrt(pair.G * (5.26e11 + mass) / DISTANCE**3 * (1 + 1.5 * quadrupoles / DISTANCE**2))  # synchronous
zero = np.zeros_like(rate)
start = pair.state(
    (DISTANCE, 0, 0),
    np.stack([zero, rate * DISTANCE - 2.63e-3, zero], axis=-1),
    [(1, 0, 0, 0), (np.cos(0.005), np.sin(0.005), 0, 0)],  # 0.6 deg off the plane of the orbit
    omega_body=[(0, 0, 2 * np.pi / (2.26 * 3600)), np.stack([zero, zero, rate], axis=-1)],
)
system = pt.System(pair, pt.forces.MutualGravity())
found = pt.analysis.chaos_indicators(system, start, [30 * 86400.0], progress=False)
megno = found.mean_megno[:, -1]
chaotic = megno > 4
days = 1 / (86400 * np.median(found.lyapunov[chaotic, -1]))
print(f"{np.mean(chaotic):.0%} of the shapes turn chaotically; small differences grow by e in {days:.1f} days")
assert 0.2 < np.mean(chaotic) < 0.45
assert np.all(megno[first < 1.05] < 4)

panel = pt.plot.map(
    a_to_b,
    b_to_c,
    megno,
    "a/b of Dimorphos",
    "b/c of Dimorphos",
    "mean MEGNO after 30 days",
    center=2,
    limits=(0, 4),
)
panel.figure.savefig("dimorphos_map.png", dpi=150)
