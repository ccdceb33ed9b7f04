"""The satellite of the paper.

The satellite of Arribas, Elipe and Palacios (2006), Sec. 6.2: ten revolutions in the gravity gradient of the Earth.

The moments of inertia, the elements and the pair (q, Q) are the printed ones, in kg m^2, km and s. The end is compared
with the same motion in 42 digits, by Taylor series in multiple precision. The perigee lies below the ground (erratum
E11 in docs/paper.md), which does not affect the motion; an orbit with the radius of the Earth gives a warning.
"""

import warnings

import numpy as np

import poinsot as pt

with warnings.catch_warnings(record=True, category=UserWarning, action="always") as told:
    orbit = pt.KeplerOrbit(
        mu=398600.4418,
        semimajor_axis=7000.0,
        eccentricity=0.2,
        inclination=np.pi / 6,
        node=np.pi / 4,
        argument_of_periapsis=np.pi / 12,
        radius=6378.137,
    )
print(told[0].message)
assert "778.137 below the surface" in str(told[0].message)

system = pt.System(pt.Body((400, 500, 600)), pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})
start = pt.State(
    quaternion=(0.5, -1 / np.sqrt(2), 0, 0.5),
    conjugate_momenta=(0.3, -0.6 * np.sqrt(2), 0.1 * np.sqrt(2), -1.5),
)
motion = pt.propagate(system, start, np.linspace(0, 10 * orbit.period, 2001))
print(motion)

q = (0.763082132724031, 0.423729419181828, 0.457167932594955, 0.170752802155719)  # of 42 digits
Q = (-1.39862732190435, 1.82636647076094, 0.263524023779282, 1.01261929814898)
differences = motion.quaternion[-1] - q, (motion.conjugate_momenta[-1] - Q) / np.linalg.norm(Q)
print(f"after ten revolutions q and Q are {np.max(np.abs(differences)):.1e} from 42 digits")
assert np.max(np.abs(differences)) < 8e-13

axes = pt.plot.quaternions(motion, title="A satellite for ten revolutions in the gravity gradient")
axes[0].figure.savefig("paper_satellite.png", dpi=150)
