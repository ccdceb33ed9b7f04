"""YORP of an asteroid and its mirror image.

YORP spins an asteroid up or down and turns its axis: averaged over rotation and orbit, beside the full torque.

An asteroid of 500 m at 1.5 au has two hollows and a hump. Its coefficients of YORP by obliquity say to which
obliquities its axis goes, and whether it ends at the spin barrier of 2.2 hours or turns ever slower. Its mirror image
has the opposite coefficients; with thermal lag both go to obliquities of 0 and 180 degrees, where one is sped up and
the other slowed down. The full torque, ten thousand times stronger, changes rate and obliquity at the averaged rates.
A body of the size of (54509) YORP is sped up or slowed down by the order of 1e-4 deg/d2; that one by (2.0 +- 0.2)e-4
deg/d2 (Lowry et al. 2007, Science 316, 272).
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import poinsot as pt

au, year, hour, day = 149597870700.0, 365.25 * 86400, 3600.0, 86400.0  # m, s
pressure_at_1_au = 4.54e-6  # N/m2


def asteroid(radius, density=2000.0, points=500):
    """A shape of triangles with its axis of the largest moment along the third axis."""
    heights, turns = 1 - (2 * np.arange(points) + 1) / points, np.pi * (3 - np.sqrt(5)) * np.arange(points)
    across = np.sqrt(1 - heights**2)
    units = np.stack([across * np.cos(turns), across * np.sin(turns), heights], axis=-1)
    centers = np.array([(0.6, 0.0, 0.8), (-0.64, 0.6, -0.48), (0.48, -0.8, -0.36)])
    bumps = np.exp(-5 * (1 - units @ centers.T)) @ (-0.35, -0.3, 0.4)
    places = radius * np.exp(bumps)[:, None] * units * (1.25, 1.0, 0.85)
    faces = ConvexHull(units).simplices
    inwards = np.linalg.det(units[faces]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    mesh = pt.shapes.Mesh(places, faces.astype(np.int64), density=density).in_principal_axes()
    turn = np.eye(3)[np.argsort(np.diag(mesh.inertia))]
    return mesh.moved(attitude=Rotation.from_matrix(turn * np.linalg.det(turn)))


mesh = asteroid(500.0)
body, moment = pt.Body.from_shape(mesh), mesh.inertia[2, 2]
obliquities = np.linspace(0, np.pi, 37)
coefficients = pt.analysis.yorp_coefficients(mesh, obliquities)
lagged = coefficients.with_lag(thermal_parameter=1.0, albedo=0.1)
field = pt.forces.DirectionalTorque.of_emission(mesh, degree=8)
print(
    f"{len(mesh.faces)} faces; the field of degree 8 leaves {field.rms_error:.2g} m3, {field.maximum_error:.2g} at most"
)

# ---------------------------------------------------------------------- the full torque against the averaged one
pressure, rate, tilted = pressure_at_1_au / 1.5**2, 2 * np.pi / (6 * hour), np.radians(35)
stronger, orbits, rows = 1e4, 6, 250
# turns fast enough for an average: a quick orbit of 117 rotations makes the run short
period = 117.003 * 2 * np.pi / rate
near = pt.KeplerOrbit((1.5 * au) ** 3 * (2 * np.pi / period) ** 2, semimajor_axis=1.5 * au, eccentricity=0.0)
force = pt.forces.Yorp(near, field, pressure=stronger * pressure_at_1_au, distance=au)
times = np.linspace(0, orbits * period, orbits * rows + 1)
start = body.state(Rotation.from_rotvec((tilted, 0, 0)), omega_body=(0, 0, rate))
motion = pt.propagate(pt.System(body, force, units={"time": "s", "inertia": "kg m2"}), start, times)
momentum = motion.attitude.apply(motion.angular_momentum_body)
size = np.linalg.norm(momentum, axis=-1)
full = {"rate": size / moment, "obliquity": np.arccos(momentum[:, 2] / size)}
drift = pt.analysis.yorp_coefficients(field, obliquities).drift(stronger * pressure, moment)
averaged = pt.analysis.secular_evolution([drift], {"rate": rate, "obliquity": tilted}, times).values
for name in full:
    changes = [np.mean(x[-rows:]) - np.mean(x[:rows]) for x in (full[name], averaged[name])]
    print(f"{name}: the full torque changes it by {changes[0]:.5g}, the averaged law by {changes[1]:.5g}")
    assert abs(changes[0] / changes[1] - 1) < 0.02

# ---------------------------------------------------------------------- end states, over millions of years
mirrored = pt.shapes.Mesh(mesh.vertices * (-1, 1, 1), mesh.faces[:, ::-1], mass=mesh.mass)
opposite = pt.analysis.yorp_coefficients(mirrored, obliquities)
assert np.max(np.abs(opposite.spin + coefficients.spin)) < 0.01 * np.ptp(coefficients.spin)
fast, slow = 2 * np.pi / (2.2 * hour), 2 * np.pi / (100 * hour)


def evolution(means, degrees):
    """Rate and obliquity from a period of 6 h to 2.2 h or 100 h."""
    law, begin = means.drift(pressure, moment), {"rate": rate, "obliquity": np.radians(degrees)}
    ended = lambda state: (state["rate"] - fast) * (state["rate"] - slow)  # noqa: E731
    return pt.analysis.secular_evolution([law], begin, np.linspace(0, 20e6 * year, 1001), until=ended)


sets = {
    "without lag": coefficients,
    "mirror image, without lag": opposite,
    "with lag": lagged,
    "mirror image, with lag": opposite.with_lag(thermal_parameter=1.0, albedo=0.1),
}
starts = range(5, 180, 10)
tracks = {name: {degrees: evolution(means, degrees) for degrees in starts} for name, means in sets.items()}
for name, some in tracks.items():
    last = {
        degrees: (each.values["rate"][-1], np.degrees(each.values["obliquity"][-1])) for degrees, each in some.items()
    }
    ends = sorted({round(float(angle) / 90) * 90 for _, angle in last.values()})
    spun_up = sum(end > rate for end, _ in last.values())
    print(f"{name}: obliquities near {ends} deg at the end, {spun_up} of {len(last)} at the spin barrier")
    assert all(each.stopped for each in some.values())
assert all(np.abs(np.cos(each.values["obliquity"][-1])) > 0.9 for each in tracks["with lag"].values())

# ---------------------------------------------------------------------- the size of (54509) YORP
small = asteroid(57.0)
means = pt.analysis.yorp_coefficients(small, np.radians([0.0]))
change = np.degrees(means.spin[0] * pressure_at_1_au / small.inertia[2, 2]) * day**2
print(f"57 m at 1 au, obliquity 0: {change:.2g} deg/d2; (54509) YORP has 2.0e-4")
assert 2e-5 < abs(change) < 2e-3

# ---------------------------------------------------------------------- picture
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 5), layout="constrained")
pt.plot.yorp(coefficients, ax=left)
left.plot(np.degrees(obliquities), lagged.tilt / 10, color="#009E73", linestyle=":", label="with thermal lag, over 10")
left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.05), ncols=2, frameon=False)
for panel, end in ((middle, "without lag"), (right, "with lag")):
    for name, color in ((end, "#0072B2"), (f"mirror image, {end}", "#D55E00")):
        for degrees, track in tracks[name].items():
            label = name if degrees == starts[0] else None
            angles, hours = np.degrees(track.values["obliquity"]), 2 * np.pi / track.values["rate"] / hour
            panel.plot(angles, hours, color=color, linewidth=1, label=label)
    panel.plot(starts, [6.0] * len(starts), "k.", label="initial states")
    panel.axhline(2.2, color="black", linestyle="--", linewidth=1, label="spin barrier")
    panel.set(xlabel="obliquity [deg]", ylabel=f"rotation period {end} [h]", yscale="log", xlim=(0, 180))
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
right.set(yscale="linear", ylim=(2, 10))
for panel in (left, middle, right):
    panel.set_xticks(range(0, 181, 30))
figure.savefig("yorp.png", dpi=110)
