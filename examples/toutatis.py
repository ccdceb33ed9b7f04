"""The tumbling of Toutatis.

The tumbling of 4179 Toutatis from November 1992 to 2010, under the gravity-gradient torques of Sun and Earth.

The spin state is that of Takahashi, Busch and Scheeres (2013, Astron. J. 146, 95), with attitudes in the axes of the
ecliptic of J2000. The orbit is integrated from osculating elements, with the Earth of VSOP2013 and other planets on
ellipses, and passes the Earth at the published dates and distances. Sources and results are in docs/worlds.md.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import simpson, solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import poinsot as pt

day, au = 86400.0, 149597870.7  # s, km
ecliptic = Rotation.from_euler("x", 84381.448 / 3600, degrees=True)  # its axes along those of the ICRF
calendar = pt.Calendar("1992-11-09T17:49:47", "UTC")
known = {"start": 0.0, "stop": calendar.time("2010-12-31T00:00:00 UTC"), "calendar": calendar}

toutatis = pt.Body((3.0836, 3.235, 1.0))  # up to a factor, which changes nothing; the long axis is the third
start = toutatis.state(
    ecliptic * Rotation.from_euler("ZXZ", (145.498, 65.865, 241.524), degrees=True),
    omega_body=np.radians((14.51, 33.529, -98.709)) / day,
)


def on_the_ecliptic(vectors):
    """Longitude and latitude in degrees."""
    x, y, z = ecliptic.inv().apply(vectors).T
    return np.degrees(np.arctan2(y, x)) % 360, np.degrees(np.arctan2(z, np.hypot(x, y)))


# Torque-free: the body turns about its long axis in 5.4 days, and the axis about the momentum in 7.4.
free = pt.analysis.FreeRotation(toutatis, start)
longitude, latitude = on_the_ecliptic(start.angular_momentum_space)
print(f"{free.mode}: rotation {free.rotation_period / day:.4f} d, precession {free.precession_period / day:.4f} d")
print(f"angular momentum towards longitude {longitude:.1f}, latitude {latitude:.1f} deg of the ecliptic")
assert free.mode == "long-axis"
assert 5.35 < free.rotation_period / day < 5.41  # 5.38 +- 0.03, Zhao et al. 2015
assert 7.37 < free.precession_period / day < 7.43  # 7.40 +- 0.03
assert abs(longitude - 180.2) < 1.5  # Zhao et al. 2015 have this pole 20 years later
assert abs(latitude + 54.75) < 1.5

# The ephemerides: Earth and Moon from their theories; other planets on ellipses of 2000 (Standish, for 1800 to 2050):
# Sun over planet, a [au], e, i, mean longitude, longitude of perihelion, node [deg], degrees per century.
ELLIPSES = (
    (408523.7, 0.72333566, 0.00677672, 3.39467605, 181.97909950, 131.60246718, 76.67984255, 58517.81538729),
    (3098703.6, 1.52371034, 0.09339410, 1.84969142, -4.55343205, -23.94362959, 49.55953891, 19140.30268499),
    (1047.3486, 5.20288700, 0.04838624, 1.30439695, 34.39644051, 14.72847983, 100.47390909, 3034.74612775),
    (3497.898, 9.53667594, 0.05386179, 2.48599187, 49.95424423, 92.59887831, 113.66242448, 1222.49362201),
)
earth_to_sun, moon_to_sun = (pt.orbits.planet_orbit("sun", body, **known) for body in ("earth", "moon"))
sun = pt.orbits.planet_orbit("earth", "sun", 0.0, day).mu
J2000 = calendar.time("2000-01-01T12:00:00 TDB")
times = np.linspace(0, known["stop"], 12000)
places = [-np.transpose(orbit.position_at(times)) for orbit in (earth_to_sun, moon_to_sun)]
for _, a, e, i, mean, perihelion, node, rate in ELLIPSES:
    angles, n = np.radians([i, node, perihelion - node, mean - perihelion]), np.radians(rate) / (36525 * day)
    ellipse = pt.KeplerOrbit.from_elements(
        n**2 * (a * au) ** 3,
        semimajor_axis=a * au,
        eccentricity=e,
        inclination=angles[0],
        node=angles[1],
        argument_of_periapsis=angles[2],
        mean_anomaly=angles[3],
    )
    places.append(ecliptic.apply(np.transpose(ellipse.position_at(times - J2000))))
planets = CubicSpline(times, np.stack(places, axis=1))
masses = np.array([earth_to_sun.mu, moon_to_sun.mu, *(sun / row[0] for row in ELLIPSES)])


def pull(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True) ** 3


def path_rates(time, state):
    """Newton's equations about the Sun, with the planets and the Sun's relativity; km, s."""
    place, velocity = state[:3], state[3:]
    others = planets(time)
    newton = -sun * pull(place) + masses @ (pull(others - place) - pull(others))
    r, v = np.linalg.norm(place), np.linalg.norm(velocity)
    bent = (4 * sun / r - v**2) * place + 4 * (place @ velocity) * velocity
    return np.concatenate([velocity, newton + sun / (299792.458**2 * r**3) * bent])


seed = pt.KeplerOrbit.from_elements(
    sun,
    semimajor_axis=2.511172982 * au,
    eccentricity=0.640579552,
    inclination=np.radians(0.461729511),
    node=np.radians(127.202325178),
    argument_of_periapsis=np.radians(275.648230484),
    mean_anomaly=np.radians(-0.928969277),
)
first = np.concatenate([ecliptic.apply(part(0.0)) for part in (seed.position_at, seed.velocity_at)])
path = solve_ivp(
    path_rates, (0, known["stop"]), first, method="DOP853", rtol=1e-12, atol=[1e-3] * 3 + [1e-10] * 3, dense_output=True
).sol
labels = {"reference_frame": "ICRF", "origin": "SUN", "calendar": calendar}
from_sun = pt.orbits.Ephemeris.from_function(
    sun, position=lambda t: path(t)[:3].T, start=0.0, stop=known["stop"], tolerance=1e-11, **labels
)
from_earth = pt.orbits.composite_orbit(from_sun, earth_to_sun)

flybys = []
for date, published in {
    "1992-12-08": 0.0242,
    "1996-11-29": 0.0354,
    "2000-10-31": 0.0739,
    "2004-09-29": 0.0104,
    "2008-11-09": 0.0502,
}.items():
    hours = calendar.time(f"{date}T00:00:00 UTC") + np.linspace(-1, 2, 3001) * day
    distances = np.linalg.norm(from_earth.position_at(hours), axis=0) / au
    flybys.append(hours[distances.argmin()])
    print(f"{calendar.date(flybys[-1]).iso[:16]} UTC: {distances.min():.5f} au, published {date}, {published} au")
    assert abs(distances.min() / published - 1) < 0.03
    assert -0.1 < (flybys[-1] - hours[1000]) / day < 1.2

# The rotation, read at each aphelion, where all is quiet: what the Sun does, what the Earth does, and both.
times = np.arange(0, known["stop"], day / 10)
place = path(times)[:3].T
distance = np.linalg.norm(place, axis=1)
aphelia = np.flatnonzero((distance[1:-1] > distance[:-2]) & (distance[1:-1] > distance[2:])) + 1
tides = {"Sun": [from_sun], "Earth": [from_earth], "Sun and Earth": [from_sun, from_earth]}
motions = {
    who: pt.propagate(pt.System(toutatis, *map(pt.GravityGradient, orbits)), start, times)
    for who, orbits in tides.items()
}


def rotations(motion, rows):
    """The free rotations that would go on from some of the times."""
    momenta = motion.angular_momentum_body[rows]
    return pt.analysis.FreeRotation(toutatis, toutatis.state(motion.attitude[rows], angular_momentum_body=momenta))


print("at the start, then at the aphelia of", ", ".join(calendar.date(times[aphelia]).strftime("%B %Y")))
for who, motion in motions.items():
    rows = np.append(0, aphelia)
    at, G = rotations(motion, rows), motion.angular_momentum_space[rows]
    print(f"{who}: precession", *(f"{x:.5f}" for x in at.precession_period / day), "d")
    print("    rotation", *(f"{x:.5f}" for x in at.rotation_period / day), "d")
    print("    |G|, relative change", *(f"{x:+.1e}" for x in at.angular_momentum / at.angular_momentum[0] - 1))
    print("    longitude, latitude of G", *(f"{x:.2f},{y:.2f}" for x, y in zip(*on_the_ecliptic(G), strict=True)))

# Between aphelia the Sun alone leaves the size of G and both periods, and turns G about the normal n of the orbit: the
# mean of its tide over the free rotation is that of a body with moments I_along G and I_across, and the angle is
# (3/2) mu (I_across - I_along) (n . G) / |G|^2 times the integral of 1/r^3.
quiet, G = rotations(motions["Sun"], aphelia), motions["Sun"].angular_momentum_space[aphelia]
own = pt.free_motion(toutatis, start, np.linspace(0, 3000, 100001) * day).angular_momentum_body / free.angular_momentum
I_along = np.mean(own**2 @ toutatis.moments)
I_across = (np.sum(toutatis.moments) - I_along) / 2
between = slice(aphelia[0], aphelia[-1] + 1)
nearness = simpson(distance[between] ** -3.0, x=times[between])
normal = ecliptic.apply(seed.normal)
expected = 1.5 * sun * (I_across - I_along) * (normal @ G[0]) / (G[0] @ G[0]) * nearness
across = G - np.outer(G @ normal, normal)
turned = np.arctan2(np.cross(across[0], across[-1]) @ normal, across[0] @ across[-1])
print(f"Sun alone, four revolutions: G turns by {np.degrees(turned):.4f} deg, mean theory {np.degrees(expected):.4f}")
assert abs(turned / expected - 1) < 3e-3
assert np.ptp(quiet.angular_momentum) < 1e-5 * free.angular_momentum
assert np.ptp(quiet.precession_period) < 1e-5 * free.precession_period

# The momentum changes by the integral of the torque, with the torque and the places of other formulas.
motion = motions["Sun and Earth"]
axes, torque = motion.attitude.as_matrix(), np.zeros_like(place)
for mu, r in ((sun, place), (earth_to_sun.mu, place - planets(times)[:, 0])):
    inertia_along = np.einsum("tij,j,tkj,tk->ti", axes, toutatis.moments, axes, r)
    torque += 3 * mu / np.linalg.norm(r, axis=1)[:, None] ** 5 * np.cross(r, inertia_along)
change = motion.angular_momentum_space[-1] - motion.angular_momentum_space[0]
apart = np.linalg.norm(change - simpson(torque, x=times, axis=0)) / np.linalg.norm(change)
print(f"change of the angular momentum against the integral of the torque: {apart:.1e} of it")
assert apart < 1e-6

figure, (above, below) = plt.subplots(2, 1, figsize=(10, 6), height_ratios=(2.5, 1), layout="constrained")
years, seen = 1992.857 + times / (365.25 * day), slice(None, None, 10)  # daily
colors = {"Sun": "#D55E00", "Earth": "#0072B2", "Sun and Earth": "#000000"}
for who, motion in motions.items():
    at = rotations(motion, seen)
    above.plot(years[seen], at.precession_period / day, color=colors[who], linewidth=0.5, label=who)
    longitude, latitude = on_the_ecliptic(motion.angular_momentum_space)
    east = (longitude - longitude[0]) * np.cos(np.radians(latitude))
    below.plot(east, latitude - latitude[0], color=colors[who], linewidth=0.8)
flyby = "flyby of the Earth"
for year in 1992.857 + np.array(flybys) / (365.25 * day):
    above.axvline(year, color="#CC79A7", linewidth=0.8, label=flyby)
    flyby = ""
above.set_xticks(range(1993, 2012, 3))
above.set_xlim(1992.5, 2011.3)
above.set_xlabel("year")
above.set_ylabel("precession period of the long axis [d]")
for line in above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False).get_lines():
    line.set_linewidth(2)
below.set_aspect("equal", adjustable="datalim")
below.set_xlabel("angular momentum, along the ecliptic [deg]")
below.set_ylabel("across it [deg]")
for panel in (above, below):
    panel.grid(alpha=0.25)
figure.savefig("toutatis.png", dpi=150)
