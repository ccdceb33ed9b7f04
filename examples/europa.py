"""Librations of Europa, Io and Titan.

Three moons in their Cassini states: the free librations of Europa, Io and Titan, and Europa's forced libration.

The spin axis of a synchronous moon on an ellipse with a precessing plane precesses with the plane: in the frame of the
node the rotation is periodic with one revolution. `cassini_state` finds it and its free librations: the libration in
longitude, the precession of the axis, the wobble of the axis in the body. The numbers, the linear theory and published
values (Henrard 2005, CMDA 91, 131; Noyelles, Lemaitre and Vienne 2008, A&A 478, 959) are in docs/worlds.md.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

year, degree = 365.25, np.pi / 180  # days, radians
jupiter, saturn = 126686534 * 86400.0**2, 37931206 * 86400.0**2  # km3/day2


def moon(mu, J2, C22, polar, a, e, inclination, rate, node_period):
    """Body and orbit, from the field over M R^2, km, degrees, degrees per day and years; the node moves backwards."""
    node_rate = -2 * np.pi / (node_period * year)
    ellipse = pt.KeplerOrbit(
        mu, semimajor_axis=a, eccentricity=e, inclination=inclination * degree, argument_of_periapsis=np.pi / 4
    )
    orbit = pt.orbits.PrecessingOrbit.from_mean_motion(
        ellipse, mean_motion=rate * degree - node_rate, node_rate=node_rate
    )
    return pt.Body.from_stokes(-J2, C22, polar), orbit


moons = {
    "Europa": moon(jupiter, 435.5e-6, 131.5e-6, 0.346, 671100, 0.0094, 0.466, 101.3747242, 30.184),
    "Io": moon(jupiter, 554e-6 * 10 / 3, 554e-6, 0.377, 421800, 0.0041, 0.036, 203.4889583, 7.420),
    "Titan": moon(saturn, 3.15e-5, 1.1235e-5, 0.31, 1221870, 0.0288, 0.32, 22.5769749, 703),
}


def linear_theory(body, orbit):
    """Frequencies of longitude, precession seen from the node and wobble, and the obliquity, on a circle."""
    (A, B, C), n, node, i = body.moments, orbit.mean_motion, orbit.node_rate, orbit.orbit.inclination
    N, pull = n + node, 3 * orbit.mu / orbit.orbit.semimajor_axis**3
    b, c = (C - A) / B, (C - B) / A
    fast, slow = np.sqrt(np.roots([1, -(N**2 * (1 + b * c) + pull * b), N**2 * b * c * (N**2 + pull)]))
    equations = [
        [A * n**2 - (C - B) * N**2, (C - A - B) * n * N],
        [(C - A - B) * n * N, B * n**2 - (C - A) * (N**2 + pull)],
    ]
    lean = np.linalg.solve(equations, [node * i * (A * n + (C - B) * N), node * i * (B * n + (C - A) * N)])
    return np.array([np.sqrt(pull * (B - A) / C), abs(fast - n), slow]), abs(np.mean(lean))


def frequencies(state):
    return np.array([state.longitude, state.precession, state.wobble])


states = {name: pt.analysis.cassini_state(body, orbit) for name, (body, orbit) in moons.items()}
print("periods of longitude [days], precession from the node, wobble [years]; obliquity [arcmin]")
for name, (body, orbit) in moons.items():
    linear, lean = linear_theory(body, orbit)
    for who, rates, tilt in ((name, frequencies(states[name]), states[name].obliquity), ("on a circle", linear, lean)):
        days, *years = 2 * np.pi / rates / [1, year, year]
        print(f"{who:12s} {days:10.4f} {years[0]:10.4f} {years[1]:10.4f} {60 * tilt / degree:10.4f}")
    assert states[name].motion.stable
    allowed = 3 * orbit.eccentricity**2 + 2e-5
    assert np.all(abs(frequencies(states[name]) / linear - 1) < allowed)
    assert abs(states[name].obliquity / lean - 1) < allowed

# Published values for rigid moons. Titan's precession is theirs in space, where the node's own motion adds to it.
europa, io, titan = states.values()
in_space = titan.precession - moons["Titan"][1].node_rate
published = {
    "Io, longitude": (io.longitude, 13, 0.04),  # "about", Musotto, Varadi, Moore and Schubert 2002
    "Io, wobble": (io.wobble, 230, 0.02),
    "Titan, longitude": (titan.longitude, 2.0977 * year, 2e-3),
    "Titan, precession in space": (in_space, 167.4883 * year, 2e-3),
    "Titan, wobble": (titan.wobble, 306.3360 * year, 2e-3),
}
for what, (rate, days, allowed) in published.items():
    print(f"{what}: {2 * np.pi / rate:.2f} days, published {days:.2f}")
    assert abs(2 * np.pi / rate / days - 1) < allowed

# Europa's periapsis moves: seen from the node it goes back once in 143 revolutions of the longitude, 1.39 years.
body, orbit = moons["Europa"]
turn = -orbit.mean_motion / 143
moving = pt.orbits.PrecessingOrbit.from_mean_motion(
    orbit.orbit, mean_motion=orbit.mean_motion - turn, node_rate=orbit.node_rate, periapsis_rate=turn
)
whole = pt.analysis.periodic_motion(
    pt.System(body, pt.GravityGradient(moving)), europa.motion.state, -2 * np.pi / turn, europa.motion.frame
)
own, lap = frequencies(europa), 2 * np.pi / whole.period  # a look once in a period leaves multiples of lap open
whole_laps = np.rint(own / lap) * lap
nearest = [np.argmin(abs(whole.frequencies - rest)) for rest in abs(own - whole_laps)]
changes = (whole_laps + np.sign(own - whole_laps) * whole.frequencies[nearest]) / own - 1
print("with a periapsis that moves the frequencies change by", ", ".join(f"{x:.1e}" for x in changes))
assert np.all(abs(changes) < 3e-4)

# The forced libration, relative to the uniformly rotating direction; linear theory in docs/worlds.md.
system, start = pt.System(body, pt.GravityGradient(orbit)), europa.motion.state
times = start.time + np.linspace(0, 2, 401) * orbit.period
along = pt.propagate(system, start, times).relative_to(europa.motion.frame).attitude
ahead, aside, normal = np.array(orbit.orbit.plane)
anomaly = orbit.mean_motion * (times - start.time)
long_axis = along.apply((1, 0, 0))
libration = np.angle(np.exp(1j * (np.arctan2(long_axis @ aside, long_axis @ ahead) - anomaly)))
A, B, C = body.moments
K = 3 * (B - A) / C * orbit.mu / orbit.orbit.semimajor_axis**3 / orbit.mean_motion**2
amplitude = -2 * orbit.eccentricity * K / (1 - K)
waves = np.transpose([np.sin(anomaly), np.cos(anomaly), np.sin(2 * anomaly)])
measured = np.linalg.lstsq(waves[:-1], libration[:-1])[0][0]
arcsec = degree / 3600
print(f"Europa's forced libration: {measured / arcsec:.3f} arcsec, linear theory {amplitude / arcsec:.3f} arcsec")
assert abs(measured / amplitude - 1) < 3e-4

# The free precession alone: the rotation vector and the momentum of its mode, small, along the body axes.
multipliers, modes = np.linalg.eig(europa.motion.matrix)
mode = modes[:, np.argmin(abs(np.angle(multipliers) - europa.precession * europa.motion.period))].real
mode *= europa.obliquity / 2 / np.linalg.norm(mode[:3])
turned, momentum = start.attitude * Rotation.from_rotvec(mode[:3]), start.angular_momentum_body + mode[3:]
free = body.state(turned, angular_momentum_body=momentum, time=start.time)
days = start.time + np.arange(0, 2 * np.pi / europa.precession, orbit.period)
seen = pt.propagate(system, free, days).relative_to(europa.motion.frame).attitude.apply((0, 0, 1))

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
revolutions = (times - start.time) / orbit.period
left.plot(revolutions, libration / arcsec, color="#0072B2", label="integrated")
left.plot(revolutions, amplitude * np.sin(anomaly) / arcsec, "--", color="#D55E00", label="linear theory")
left.set_xlabel("revolutions")
left.set_ylabel("libration in longitude [arcsec]")
left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
left.grid(alpha=0.25)
# Seen from above; the normal of the orbit lies across its node from the pole.
right.plot(
    60 * seen[:, 0] / degree,
    60 * seen[:, 1] / degree,
    ".",
    color="#0072B2",
    markersize=3,
    label="axis at periapsis",
)
right.plot(0, 60 * start.attitude.apply((0, 0, 1))[1] / degree, "o", color="#000000", label="Cassini state")
right.plot(0, -60 * np.arccos(normal[2]) / degree, "^", color="#D55E00", label="normal of the orbit")
right.set_xlabel("along the node [arcmin]")
right.set_ylabel("across the node, from the Laplace pole [arcmin]")
right.set_aspect("equal")
right.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
right.grid(alpha=0.25)
figure.savefig("europa.png", dpi=150)
