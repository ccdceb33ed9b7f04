"""Free librations of satellites, planets and spacecraft.

Frequencies of the free librations of satellites, planets and spacecraft, compared with linear theory.

Each body starts 1e-4 rad from its Cassini state, equilibrium or forced libration, and again at twice the distance;
Mercury 3e-4 rad, because rounding errors accumulate in its long run. `frequencies` decomposes the rotation without the
forced part. Frequencies depend on the square of the amplitude, so the two starts are extrapolated to zero amplitude.
Linear values are from the matrices of `cassini_state`, `equilibria` and
`periodic_motion`. Hyperion is in the plane of its orbit, on the islands of regular motion that its chaotic sea leaves.
A halo orbit is not among them: it leaves within a few revolutions.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

SIZES = np.array([1.0, 2.0])
degree, year, day = np.pi / 180, 365.25, 86400.0
rows = []  # body, mode, linear over the mean motion; relative: difference, standard error, amplitude-dependent shift


def starts(rest, body, turn, push, size=1e-4):
    """States beside one, by rotation vectors and by fractions of the momentum, both along the body axes and small."""
    g = rest.angular_momentum_body
    pushed = g + np.multiply.outer(size * SIZES, push) * np.linalg.norm(g)
    turned = rest.attitude * Rotation.from_rotvec(np.multiply.outer(size * SIZES, turn))
    return body.state(turned, angular_momentum_body=pushed, time=rest.time)


def away(motion, still, frame):
    """Rotation vectors from attitudes in a frame, (times) or one of them, to those of a motion: (members, times, 3)."""
    seen = Rotation.from_quat(motion.relative_to(frame).quaternion.reshape(-1, 4), scalar_first=True)
    whole = Rotation.concatenate([still] * (len(seen) // len(still)))
    return (whole.inv() * seen).as_rotvec().reshape(*motion.quaternion.shape[:2], 3)


def compare(world, modes, linear, signal, times, mean_motion):
    """Add a row for each of the strongest lines of a signal, (members, times); linear values ascend, as they do."""
    with warnings.catch_warnings():
        # The warning is about merged weak lines. The compared lines are a thousand times stronger, and the table shows
        # their standard errors next to the difference from linear theory.
        warnings.filterwarnings("ignore", "frequencies should be resolved")
        found = pt.analysis.frequencies(signal, times - times[0], count=12)
    order = np.argsort(found.frequencies[:, : len(linear)], axis=1)
    one, two = np.take_along_axis(found.frequencies, order, 1) / linear - 1
    errors = np.take_along_axis(found.errors, order, 1) / linear
    rest, error = (4 * one - two) / 3, np.hypot(4 * errors[0], errors[1]) / 3
    rows.extend(zip([world] * len(modes), modes, linear / mean_motion, rest, error, one - rest, strict=True))


# Cassini states, seen once in a period, when the forced part is the same each time.
jupiter, saturn, earth, sun = 126686534, 37931206, 398600.4418, 132712440018  # km3/s2
field, lunar = pt.Body.from_stokes, pt.Body.from_ratios(beta=6.31e-4, gamma=2.28e-4)
worlds = {
    # body, mu, a [km], e, i [deg], rate of the longitude [deg/d], period of the node [yr], spin, periods, and one in
    "Europa": (field(-435.5e-6, 131.5e-6, 0.346), jupiter, 671100, 0.0094, 0.466, 101.3747242, 30.184, 1, 4096, 4),
    "Io": (field(-554e-5 / 3, 554e-6, 0.377), jupiter, 421800, 0.0041, 0.036, 203.4889583, 7.420, 1, 1024, 1),
    "Titan": (field(-3.15e-5, 1.1235e-5, 0.31), saturn, 1221870, 0.0288, 0.32, 22.5769749, 703, 1, 28672, 16),
    "Moon": (lunar, earth, 384399, 0.0549, 5.145, 13.176358, 18.6, 1, 8192, 8),
    "Mercury": (field(-6e-5, 1e-5, 0.34), sun, 57909050, 0.2056, 8.6, 360 / 87.969, 328000, 1.5, 16384, 8),
}
for world, (body, mu, a, e, i, rate, node_period, spin, periods, every) in worlds.items():
    node_rate = -2 * np.pi / (node_period * year)
    ellipse = pt.KeplerOrbit(
        mu * day**2, semimajor_axis=a, eccentricity=e, inclination=i * degree, argument_of_periapsis=np.pi / 4
    )
    orbit = pt.orbits.PrecessingOrbit.from_mean_motion(
        ellipse, mean_motion=rate * degree - node_rate, node_rate=node_rate
    )
    state = pt.analysis.cassini_state(body, orbit, spin)
    forced, start = state.motion, state.motion.state
    times = start.time + forced.period * np.arange(0, periods, every)
    size = 3e-4 if world == "Mercury" else 1e-4
    motion = pt.propagate(forced.system, starts(start, body, (1, 1, 1), (0.5, -0.5, 0), size), times, progress=False)
    turned = away(motion, forced.frame.attitude([start.time]).inv() * start.attitude, forced.frame)
    across = {"precession": state.precession, "wobble": state.wobble}
    names = sorted(across, key=across.get)
    compare(world, ["longitude"], np.array([state.longitude]), turned[..., 2], times, orbit.mean_motion)
    compare(world, names, np.sort(list(across.values())), turned[..., 0], times, orbit.mean_motion)

# At rest in a frame: Phobos on a circle, a spacecraft held at the libration points of Earth and Moon.
circle = pt.KeplerOrbit(42828.37, semimajor_axis=9376.0, eccentricity=0.0)
phobos = pt.System(pt.Body((0.3615, 0.4265, 0.5024)), pt.GravityGradient(circle))
held = {"Phobos": (phobos, circle.frame, circle.mean_motion)}
for name in ("L1", "L2", "L3", "L4", "L5"):
    point = pt.orbits.LagrangePointPath(398600.4418, 4902.8, separation=384400.0, point=name)
    forces = pt.GravityGradient(point.from_primary), pt.GravityGradient(point.from_secondary)
    held[name] = pt.System(pt.Body((60.0, 120.0, 150.0)), *forces), point.frame, point.mean_motion
for world, (system, frame, n) in held.items():
    rest = next(e for e in pt.analysis.equilibria(system, frame) if e.stability == "lyapunov")
    times = np.arange(1024) * 0.5 / n
    motion = pt.propagate(system, starts(rest.state, system.body, (1, 1, 1), (0, 0, 0)), times, progress=False)
    turned = away(motion, Rotation.from_quat([rest.attitude], scalar_first=True), frame)
    values, modes = np.linalg.eig(rest.matrix)
    about_third = np.abs(modes[2]) > np.hypot(*np.abs(modes[:2]))
    inside, outside = (np.sort(values.imag[(values.imag > 0) & kind]) for kind in (about_third, ~about_third))
    compare(world, ["in the plane"], inside, turned[..., 2], times, n)
    compare(world, ["out of plane, slow", "out of plane, fast"], outside, turned[..., 0], times, n)

# Hyperion's islands: the forced libration in the plane, and the motions about it.
orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
hyperion = pt.Body.from_ratios(beta=0.47, gamma=0.26)
system = pt.System(hyperion, pt.GravityGradient(orbit))
islands = {"1:1": (0.0, 0.56, 1), "2:1": (0.0, 2.32, 1), "9:4": (0.0, 2.53225, 4), "1:2": (np.pi / 2, 0.8674, 2)}
for island, (angle, rate, revolutions) in islands.items():
    guess = hyperion.state((np.cos(angle / 2), 0, 0, np.sin(angle / 2)), omega_body=(0, 0, rate))
    forced = pt.analysis.periodic_motion(system, guess, revolutions * orbit.period)
    multiplier = np.linalg.eigvals(forced.matrix[np.ix_([2, 5], [2, 5])])[0]  # in the plane
    samples = 4 * revolutions
    times = np.arange(1024) * forced.period / samples
    start = starts(forced.state, hyperion, (0, 0, 1), (0, 0, 0))
    motion = pt.propagate(system, start, times, formulation="planar", progress=False)
    turned = away(motion, forced.over_period(samples).attitude, forced.frame)[..., 2]
    lap = 2 * np.pi / forced.period  # the multiplier leaves whole ones open
    branches = np.array([-1, 1])[:, None] * np.angle(multiplier) / forced.period + lap * np.arange(samples)
    strongest = pt.analysis.frequencies(turned[0], times, count=1).frequencies
    nearest = branches.flat[np.argmin(abs(branches - strongest))]
    compare(f"Hyperion {island}", ["in the plane"], np.array([nearest]), turned, times, 1.0)

print(f"{'':32s} {'linear/n':>13s} {'measured/n':>13s} {'difference':>11s} {'error':>8s} {'shift':>12s}")
for world, mode, linear, difference, error, shift in rows:
    measured = linear * (1 + difference)
    print(f"{world:13s} {mode:18s} {linear:13.10f} {measured:13.10f} {difference:11.1e} {error:8.1e} {shift:12.1e}")
    assert abs(difference) < 1e-8  # three times the worst of three runs, Mercury's longitude
    assert abs(difference) < abs(shift) / 4

_, _, _, *sizes = zip(*rows, strict=True)
figure, axes = plt.subplots(figsize=(8, 8.5), layout="constrained")
place = np.arange(len(rows))
looks = (
    ("s", "#0072B2", "measured - linear"),
    (".", "#000000", "estimated uncertainty"),
    ("o", "#D55E00", "amplitude-dependent shift"),
)
for size, (marker, color, label) in zip(sizes, looks, strict=True):
    axes.semilogx(np.abs(size), place, marker, color=color, label=label, markersize=5)
axes.set_yticks(place, [f"{world}, {mode}" for world, mode, *_ in rows], fontsize="small")
axes.invert_yaxis()
axes.set_xlabel("relative difference of frequencies (dimensionless)")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
axes.grid(alpha=0.25)
figure.savefig("librations_of_worlds.png", dpi=150)
