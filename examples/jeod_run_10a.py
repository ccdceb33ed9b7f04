"""NASA JEOD, RUN_10A.

A long satellite for eight hours in the gravity gradient of the Earth, against NASA's JEOD.

The run is RUN_10A of JEOD's SIM_dyncomp, case 10A of the orbital check-cases of the NASA Engineering and Safety Center:
a two-body orbit of 6800 km, a body long along its first axis. The numbers are JEOD's; kg m^2, m, s. The picture shows
the long axis swinging about the vertical.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

orbit = pt.KeplerOrbit.from_vectors(
    mu=3.986004415e14,
    position=(-4292653.41, 955168.47, 5139356.57),
    velocity=(109.649663, -7527.726490, 1484.521489),
)
space_to_body = [
    (-0.6443912270931274, 0.05284210190675609, 0.7628680480341864),
    (-0.7615617870471506, -0.1345758407161209, -0.6339660776454052),
    (0.06916350883930189, -0.9894933326514259, 0.1269620166955875),
]
satellite = pt.Body((500.0, 12250.0, 12250.0))
system = pt.System(satellite, pt.GravityGradient(orbit), units={"time": "s", "inertia": "kg m2"})
start = satellite.state(
    Rotation.from_matrix(np.transpose(space_to_body)),
    omega_body=(-1.97989570839746e-05, -0.001134281491669957, 0.0),
)
motion = pt.propagate(system, start, np.linspace(0, 28800, 961))

jeod = {
    "rate [rad/s]": (-1.97989570839746e-05, -0.001080027400090759, -0.0007098670173048437),
    "long axis": (-0.1303977224153033, -0.9235551691194414, 0.3606137595567613),
    "position [m]": (-1024262.411095882, -6151093.565368023, 2599975.06217899),
}
ours = {
    "rate [rad/s]": motion.omega_body[-1],
    "long axis": motion.attitude[-1].apply([1.0, 0.0, 0.0]),
    "position [m]": np.array(orbit.position_at(28800.0)),
}
for name, bound in (("rate [rad/s]", 4e-16), ("long axis", 6e-13), ("position [m]", 4e-6)):
    difference = np.max(np.abs(ours[name] - jeod[name]))
    print(f"{name} after eight hours: {difference:.1e} from JEOD")
    assert difference < bound

long_axis = motion.relative_to(orbit.frame).attitude.apply([1.0, 0.0, 0.0])  # radial, transverse, normal
figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
axes.plot(motion.times / 3600, np.degrees(np.arccos(np.abs(long_axis[:, 0]))), color="#0072B2")
axes.set_xlabel("time [h]")
axes.set_ylabel("long axis from the vertical [deg]")
axes.grid(alpha=0.25)
figure.savefig("jeod_run_10a.png", dpi=150)
