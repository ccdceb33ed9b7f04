r"""A spacecraft at a libration point.

Equilibria and librations of a spacecraft held at a libration point of Earth and Moon.

After Abad, Arribas and Elipe (1989). At L1, L2 and L3 both attractors pull along the same line, like one with the
coefficient $3 n^2 c$, $c = (1 - \mu)/r_1^3 + \mu/r_2^3$ in units of their separation; the libration in the plane has
the frequency $\sqrt{3 c (B - A)/C}\, n$. At L4 and L5 they pull from 60 degrees apart, and the long axis rests in
between.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

EARTH, MOON, SEPARATION = 398600.4418, 4902.8, 384400.0  # km, s
A, B, C = 60.0, 120.0, 150.0
spacecraft = pt.Body((A, B, C))

COLOURS = {"L1": "#000000", "L2": "#0072B2", "L3": "#D55E00", "L4": "#009E73", "L5": "#CC79A7"}

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
for name, colour in COLOURS.items():
    point = pt.orbits.LagrangePointPath(EARTH, MOON, separation=SEPARATION, point=name)
    n, mu = point.mean_motion, point.mass_ratio
    attractors = (pt.GravityGradient(orbit) for orbit in (point.from_primary, point.from_secondary))
    system = pt.System(spacecraft, *attractors, units={"time": "s"})
    at_rest = [found for found in pt.analysis.equilibria(system, point.frame) if found.stability == "lyapunov"]
    along, across, _ = Rotation.from_quat(at_rest[0].attitude, scalar_first=True).as_matrix()[:, 0]
    angle = np.degrees(np.arctan2(across, along)) % 180
    print(f"{name}: the long axis rests at {angle:.2f} deg from the line, librates at", at_rest[0].frequencies / n)
    if name in ("L1", "L2", "L3"):
        r1, r2 = (np.linalg.norm(orbit.position) / SEPARATION for orbit in (point.from_primary, point.from_secondary))
        c = (1 - mu) / r1**3 + mu / r2**3
        assert min(angle, 180 - angle) < 1e-6
        assert np.min(np.abs(at_rest[0].frequencies / n - np.sqrt(3 * c * (B - A) / C))) < 1e-12

    # A push of a hundredth of n, and two revolutions of the Moon.
    rest = at_rest[0].state
    push = np.array([0, 0, 0.01 * n])
    pushed = spacecraft.state(rest.quaternion, omega_body=spacecraft.omega(rest.angular_momentum_body) + push)
    motion = pt.propagate(system, pushed, np.linspace(0, 4 * np.pi / n, 401))
    relative = motion.relative_to(point.frame)
    turned = 2 * np.arctan2(relative.quaternion[:, 3], relative.quaternion[:, 0])
    away = np.degrees(np.unwrap(turned - turned[0]))
    axes.plot(n * motion.times / (2 * np.pi), away, color=colour, label=name, linestyle="--" if name == "L5" else "-")
    assert np.max(np.abs(motion.drift["jacobi_energy"])) < 1e-13

axes.set_xlabel("revolutions of the Moon")
axes.set_ylabel("libration in the plane [deg]")
axes.grid(alpha=0.25)
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, frameon=False)
figure.savefig("libration_point.png", dpi=150)
