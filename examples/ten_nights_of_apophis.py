"""Ten nights of Apophis.

A simulated light curve of the tumbling asteroid Apophis, from which its two periods are recovered.

(99942) Apophis precesses with a period of 27.38 h and rotates with a period of 263 h in the short-axis mode (Pravec et
al. 2014, Icarus 233, 48). Here it is an ellipsoid with their moments of inertia. Two observatories measure magnitudes
in ten nights of January 2013, with an error of 0.02 mag. `frequencies` finds the lines of the light curve in spite of
the gaps, and `identify_lines` finds both periods and lists the alternatives.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt
from poinsot.observables import LightCurve, LommelSeeliger, Readings

day, au = 24.0, 149597870.7  # h, km
mu = 1.32712440018e11 * 3600**2  # of the Sun, km3/h2
published = {"rotation_period": 263.0, "precession_period": 27.38}  # h
longitude, latitude, phi, psi = np.radians((250.0, -75.0, 152.0, 14.0))  # of the momentum; at t = 0

# The body: a homogeneous ellipsoid with the moments 0.61 : 0.965 : 1 and a diameter of 375 m.
squares = np.array([0.965 + 1.0 - 0.61, 0.61 + 1.0 - 0.965, 0.61 + 0.965 - 1.0])
semiaxes = np.sqrt(squares) / np.prod(squares) ** (1 / 6) * 0.1875  # km
shape = pt.shapes.Ellipsoid(semiaxes, density=2e12)
body = pt.Body.from_shape(shape)
tumbling = pt.analysis.FreeRotation.from_periods(
    body,
    "short-axis",
    **published,
    longitude=longitude,
    latitude=latitude,
    precession_angle=phi,
    rotation_angle=psi,
)
print(tumbling)

# Orbits along the ecliptic of J2000 from 20 January 2013 on.
angles = {"inclination": np.radians(3.33), "node": np.radians(204.45), "argument_of_periapsis": np.radians(126.4)}
about_sun = pt.KeplerOrbit.from_elements(
    mu, semimajor_axis=0.9223 * au, eccentricity=0.1911, mean_anomaly=np.radians(136.8), **angles
)
ellipse = {"semimajor_axis": au, "eccentricity": 0.0167, "mean_anomaly": np.radians(16.9)}
sun_from_earth = pt.KeplerOrbit.from_elements(
    mu, inclination=0.0, node=0.0, argument_of_periapsis=np.radians(102.9 + 180), **ellipse
)
about_earth = pt.orbits.composite_orbit(about_sun, sun_from_earth, start=-2.0, stop=11 * day)

# Ten nights of eight hours at two observatories, eleven hours of longitude apart: an exposure every ten minutes.
night = np.concatenate([np.arange(0, 8, 1 / 6), np.arange(11, 19, 1 / 6)])
times = np.ravel(np.arange(10)[:, None] * day + night)
curve = LightCurve(shape, LommelSeeliger(albedo=0.6), about_sun, about_earth, kind="magnitude")
system = pt.System(body, units={"time": "h", "inertia": "kg km2"})
motion = pt.propagate(system, tumbling.state, np.linspace(-1, 10 * day, 1206), dense=True)
seen = pt.observe(motion, Readings(curve, times, sigma=0.02)).simulated(seed=99942)
model = pt.observe(motion, curve, times=np.linspace(0, 10 * day, 2401))

# Magnitudes at unit distances, without the slow change by the phase angle.
sun, earth = (np.transpose(orbit.position_at(times)) for orbit in (about_sun, about_earth))
distances = [np.linalg.norm(places, axis=1) for places in (sun, earth)]
phase = np.degrees(np.arccos(np.sum(sun * earth, axis=1) / np.prod(distances, axis=0)))
reduced = seen.values - 5 * np.log10(np.prod(distances, axis=0) / au**2)
print(f"{times.size} magnitudes around {seen.values.mean():.2f}, phase angle {phase[0]:.1f} to {phase[-1]:.1f} deg")
print(f"    range {np.ptp(reduced):.2f} mag, {distances[1][0] / au:.2f} au from the Earth")
reduced = reduced - np.polyval(np.polyfit(times, reduced, 1), times)

# The lines, and both periods.
with warnings.catch_warnings():
    # The warning is about weak slow lines, which the run of less than one rotation period does not resolve.
    warnings.filterwarnings("ignore", "frequencies should be resolved")
    lines = pt.analysis.frequencies(reduced, times, count=10, sigma=0.02, highest=2 * np.pi / 2)
print(lines)
alternatives = pt.analysis.identify_lines(lines, body=body)
for found in alternatives[:4]:
    print(f"    {found.mode}: {found.periods[0]:.2f} h and {found.periods[1]:.1f} h, evidence {found.evidence:.1f}")
best = alternatives[0]
print(best)
long_axis = 1 / (1 / best.periods[0] - 1 / best.periods[1])
print(f"long axis around the angular momentum in {long_axis:.2f} h")
assert best.mode == "short-axis"
assert abs(best.periods[0] / published["precession_period"] - 1) < 0.01
assert abs(best.periods[1] / published["rotation_period"] - 1) < 0.05
assert abs(long_axis - 30.56) < 0.1
assert best.multiples[0].tolist() == [2, -2]

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained", width_ratios=(3, 2))
left.plot(model.times / day, model.values, color="#BBBBBB", label="ellipsoid")
left.plot(times / day, seen.values, ".", color="#0072B2", markersize=3, label="observed")
left.invert_yaxis()
left.set_xlabel("time [d]")
left.set_ylabel("magnitude")
left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
sizes = np.abs(lines.amplitudes[lines.frequencies > 0])
right.stem(best.lines * day / (2 * np.pi), sizes, basefmt=" ", markerfmt=".")
for nu, size, (n1, n2) in zip(best.lines, sizes, best.multiples, strict=True):
    right.annotate(f"({n1}, {n2})", (nu * day / (2 * np.pi), 1.1 * size), ha="center", fontsize=8)
right.set_yscale("log")
right.set_xlim(0, 3.5)
right.set_ylim(top=2 * max(sizes))
right.set_xlabel("frequency [cycles per day]")
right.set_ylabel("amplitude [mag]")
right.set_title(f"$(n_1, n_2)$: $P_\\phi$ = {best.periods[0]:.2f} h, $P_\\psi$ = {best.periods[1]:.0f} h", fontsize=10)
for panel in (left, right):
    panel.grid(alpha=0.25)
figure.savefig("ten_nights_of_apophis.png", dpi=150)
