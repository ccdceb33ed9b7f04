r"""Forced librations on ever longer ellipses.

Forced librations of satellites on ever longer ellipses: continued in the eccentricity, with their stability.

The eccentricity of the orbit forces a libration of a synchronous body. To first order in $e$ the angle to the mean
direction is $\frac{2 e w^2}{w^2 - 1} \sin M$, $w^2 = 3 (B - A)/C$ (docs/worlds.md: Phobos). A branch begins at rest on
the circle and follows the whole forced motion, free librations removed. Faster than the orbit, $w > 1$, it ends in a
fold, where it meets a libration that on the circle is free. Dashed: unstable.
"""

import numpy as np

import poinsot as pt

BODIES = {
    "Phobos": pt.Body((0.3615, 0.4265, 0.5024)),  # over M R^2: a unit test of Tudat
    "w = 0.88": pt.Body((0.72, 0.978, 1.0)),
    "w = 1.13": pt.Body((0.90, 1.60, 1.65)),
}


def start(body):
    """The body at rest in the axes of a circular orbit, in units of its mean motion."""
    orbit = pt.KeplerOrbit(mu=1.0, semimajor_axis=1.0, eccentricity=0.0)
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    return pt.analysis.periodic_motion(pt.System(body, pt.GravityGradient(orbit)), state, orbit.period)


MEAN = pt.RotatingFrame((1, 0, 0, 0), (0, 0, 1))


def amplitude(motion):
    """The coefficient of sin M of the angle to the mean direction, degrees."""
    angles = motion.over_period().relative_to(MEAN).attitude.as_rotvec()[:, 2]
    return np.degrees(2 * np.mean(angles * np.sin(motion.over_period().times)))


branches = []
for name, body in BODIES.items():
    w2 = 3 * (body.moments[1] - body.moments[0]) / body.moments[2]
    branch = pt.analysis.continue_motion(start(body), "eccentricity", 0.25)
    branches.append(branch)
    small = np.flatnonzero((branch.values > 0) & (branch.values < 2e-3))[0]
    linear = np.degrees(2 * branch.values[small] * w2 / (w2 - 1))
    own = amplitude(branch.motions[small])
    print(f"{name}: at e = {branch.values[small]:.5f} {own:.5f} deg, linear theory {linear:.5f} deg; {branch}")
    assert abs(own / linear - 1) < 0.01

phobos = pt.analysis.continue_motion(start(BODIES["Phobos"]), "eccentricity", 0.0151).motions[-1]
print(f"Phobos, e = 0.0151: {amplitude(phobos):.3f} deg, observed -1.1 deg")
assert abs(amplitude(phobos) + 1.1) < 0.03
assert [each.kind for each in branches[-1].bifurcations if each.kind == "fold"] == ["fold"]

axes = pt.plot.branch(
    branches,
    amplitude,
    ("eccentricity", "forced libration in longitude [deg]"),
    title="w: free frequency of small librations in longitude over the mean motion",
)
for (name, body), branch in zip(BODIES.items(), branches, strict=True):
    w = np.sqrt(3 * (body.moments[1] - body.moments[0]) / body.moments[2])
    said = name if "w" in name else f"{name}, w = {w:.2f}"
    axes.annotate(said, (branch.values[-1], amplitude(branch.motions[-1])), xytext=(5, 3), textcoords="offset points")
axes.set(xlim=(-0.003, 0.315), ylim=(-30, 48))
axes.figure.savefig("forced_librations.png", dpi=150)
