"""DART and the shape of Dimorphos.

DART: what the impact did to the orbit of Dimorphos, and how the shape of Dimorphos shows in it.

Didymos is oblate, 394 x 394 x 290 m, and turns in 2.26 h; its moonlet Dimorphos went about it in 11.921481 h at a
distance of 1189 m, always with the same side to it. The impact took 2.63 mm/s along the orbit: the period becomes
11.377 h (-32.7 min), and the orbit precesses by 6.7 deg a day if Dimorphos is 1.27 times as long as wide (Naidu et al.
2024, Planet. Sci. J. 5, 74). Both bodies are extended here, to second degree: they move one another and turn one
another. The first picture has period, precession and librations against the shape of Dimorphos, the second one how
far 2,000 impacts turn it out of its place.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

HOUR, DAY = 3600.0, 86400.0
distance, before = 1189.0, 11.921481 * HOUR
radius, density = 75.5, 2400.0  # of Dimorphos: that of a ball of its volume, m, and kg/m^3
mass = density * 4 / 3 * np.pi * radius**3
rate = 2 * np.pi / before


def bodies(a_to_b, a_to_c):
    """The pair for shapes of Dimorphos; the period before the impact gives the mass of Didymos."""
    a = radius * (a_to_b * a_to_c) ** (1 / 3)
    squares = np.stack([a**2, (a / a_to_b) ** 2, (a / a_to_c) ** 2])
    moments = mass / 5 * (np.sum(squares, axis=0) - squares).T
    didymos = pt.Body.from_ellipsoid(1.0, (394, 394, 290)).moments  # of a unit of mass
    quadrupoles = np.sum(didymos) - 3 * didymos[0] + (np.sum(moments, axis=-1) - 3 * moments[:, 0]) / mass
    total = rate**2 * distance**3 / pt.TwoBodies.G / (1 + 1.5 * quadrupoles / distance**2)
    primary = total - mass
    return pt.TwoBodies(pt.Body(primary[:, None] * didymos, mass=primary), pt.Body(moments, mass=mass))


def after_impact(pair, delta_velocity):
    """The state after an impact on Dimorphos in synchronous rotation; metres, seconds."""
    start = pair.synchronous(distance=distance, primary_rate=2 * np.pi / (2.26 * HOUR))
    return pair.kick(start, delta_velocity)


# Against the shape, for a/c = 1.6 where Dimorphos is longer than 1.2 b.
a_to_b = np.array([1.02, 1.1, 1.15, 1.2, 1.25, 1.27, 1.3, 1.35, 1.4])
a_to_c = np.interp(a_to_b, [1.02, 1.1, 1.2], [1.5, 1.55, 1.6])
pair = bodies(a_to_b, a_to_c)
system = pt.System(pair, pt.forces.MutualGravity())
start = after_impact(pair, (0.0, -2.63e-3, 0.0))
motions = pt.propagate(system, start, np.arange(0.0, 60 * DAY, 120.0), progress=False)
orbits = pt.analysis.revolutions(motions)
period, spread = orbits.mean_period / HOUR, orbits.variation
precession = np.degrees(pt.analysis.apsidal_precession(motions)) * DAY
libration = np.degrees(np.max(pt.analysis.librations(motions).misalignment, axis=-1))
print(" a/b   period (h)  change (min)  precession (deg/day)  largest angle (deg)  range of periods (s)")
for row in zip(a_to_b, period, 60 * period - before / 60, precession, libration, spread, strict=True):
    print("{:.2f}  {:10.4f}  {:12.2f}  {:20.2f}  {:19.1f}  {:20.0f}".format(*row))
assert np.all(np.abs(period - 11.3777) < 0.001)
assert np.all(np.abs(60 * period - before / 60 + 32.65) < 0.1)
assert abs(np.interp(6.7, precession[::-1], a_to_b[::-1]) - 1.27) < 0.01

figure, panels = plt.subplots(3, 1, sharex=True, figsize=(6, 7), layout="constrained")
published = {"mutual period [h]": (11.377, 0.004), "apsidal precession [deg/day]": (6.7, 0.2)}
for panel, (name, values) in zip(
    panels,
    {
        "mutual period [h]": period,
        "apsidal precession [deg/day]": precession,
        "largest angle of the long\naxis to Didymos [deg]": libration,
    }.items(),
    strict=True,
):
    panel.plot(a_to_b, values, "o-", color="#0072B2", label="this model")
    panel.grid(alpha=0.25)
    panel.set_ylabel(name)
    if name in published:
        value, error = published[name]
        panel.axhspan(value - error, value + error, color="#D55E00", alpha=0.3, label="Naidu et al. 2024")
panels[0].ticklabel_format(useOffset=False)
panels[0].legend()
panels[-1].set_xlabel("a/b of Dimorphos after the impact")
figure.savefig("dart.png", dpi=150)

# 2,000 impacts: shapes after them that may be, and velocities with parts across the orbit.
random, count = np.random.default_rng(20220926), 2000
a_to_b, a_to_c = random.uniform(1.02, 1.45, count), random.uniform(1.45, 1.7, count)
pair = bodies(a_to_b, a_to_c)
kicks = random.normal((0.0, -2.63e-3, 0.0), (0.3e-3, 0.06e-3, 0.3e-3), (count, 3))
motions = pt.propagate(
    pt.System(pair, pt.forces.MutualGravity()),
    after_impact(pair, kicks),
    np.arange(0.0, 90 * DAY, 0.1 * before),
    tolerance=1e-10,
    progress=False,
)
found = pt.analysis.librations(motions)
yaw, roll = (np.degrees(np.max(np.abs(angle), axis=-1)) for angle in (found.yaw, found.roll))
librates, rolls = yaw < 90, roll > 90
print(
    f"of {count} impacts {np.mean(librates & ~rolls):.0%} leave Dimorphos librating, "
    f"in {np.mean(librates & rolls):.0%} it rolls about its long axis, "
    f"in {np.mean(~librates):.0%} the long axis turns away from Didymos"
)
assert 0.15 < np.mean(rolls) < 0.6

figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for kind, chosen, color in (
    ("librates", librates & ~rolls, "#0072B2"),
    ("rolls about its long axis", librates & rolls, "#D55E00"),
    ("turns its long axis away", ~librates, "#009E73"),
):
    panels[0].plot(a_to_b[chosen], a_to_c[chosen], ".", color=color, ms=4, label=f"{kind}: {np.mean(chosen):.0%}")
panels[0].set(xlabel="a/b of Dimorphos after the impact", ylabel="a/c")
panels[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2, fontsize="small", frameon=False)
for name, values, color in (
    ("libration of the long axis", yaw, "#000000"),
    ("roll about the long axis", roll, "#CC79A7"),
):
    panels[1].hist(values, np.arange(0, 181, 5), histtype="step", color=color, label=name)
panels[1].set(xlabel="largest angle in 90 days [deg]", ylabel=f"of {count} impacts")
panels[1].set(xlim=(0, 180), xticks=range(0, 181, 30))
panels[1].legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2, fontsize="small", frameon=False)
for panel in panels:
    panel.grid(alpha=0.25)
figure.savefig("dart_impacts.png", dpi=150)
