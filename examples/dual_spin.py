r"""Stability of a dual-spin satellite.

A dual-spin satellite of prolate shape is stable with a damper on its despun platform, not with one on its rotor.

Rotor and platform turn about one axis without friction; the platform points to the Earth, the rotor keeps the angular
momentum $g$. The moment $A$ across the axis is larger than both along it. In the platform the nutation goes round at
$\nu = g/A$, in the rotor at $\nu - \Omega < 0$. A loss of energy $D$ in the one or the other changes the amplitude $w$
of the nutation by Landon's and Iorillo's rule,

$$ \frac{\dot w}{w} = -\frac{\nu}{A w^2}
\left( \frac{D_\text{platform}}{\nu} + \frac{D_\text{rotor}}{\nu - \Omega} \right), $$

and a sphere of moment $J$ in a fluid of coefficient $k$ takes $D = k (J \lambda w)^2/(k^2 + (J \nu)^2)$, where
$\lambda$ is the rate of the nutation in the frame in which the damper sits (all to the first order in $J$). The same
satellite is integrated twice: with the platform as the body and the rotor as a wheel, and the other way round. The
picture shows the cone of nutation.
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

A, rotor, platform = 900.0, 300.0, 120.0  # kg m2, of both across the axis and of each along it
Omega = 2 * np.pi  # a turn a second
J, k = 0.6, 0.3  # kg m2, N m s
g, axis = rotor * Omega, (0, 0, 1)
nu = g / A
tilt = np.radians(1.0)
taken = k * J**2 / (k**2 + (J * nu) ** 2)
theory = {"platform": -nu / A * taken * nu, "rotor": -nu / A * taken * (nu - Omega)}
times = np.linspace(0, 4800, 961)
body, damper = pt.Body((A, A, rotor + platform)), pt.parts.KaneDamper(J, k)
nutation = (nu * np.tan(tilt), 0.0, 0.0)

wheels = {"platform": pt.parts.ReactionWheel(axis, rotor), "rotor": pt.parts.ReactionWheel(axis, platform)}
rates = {"platform": nutation, "rotor": (nutation[0], 0.0, Omega)}
speeds = {"platform": Omega, "rotor": -Omega}
angles = {}
for place, wheel in wheels.items():
    system = pt.System(body, wheel, damper, units={"time": "s", "inertia": "kg m2"})
    start = system.state(
        (1, 0, 0, 0), omega_body=rates[place], reaction_wheel=wheel.at_speed(speeds[place], rates[place])
    )
    motion = pt.propagate(system, start, times)
    along = motion.angular_momentum_body
    angles[place] = np.arctan2(np.linalg.norm(along[:, :2], axis=1), along[:, 2])
    small = (angles[place] < np.radians(15)) & (times > 20)
    found = np.polyfit(times[small], np.log(np.tan(angles[place][small])), 1)[0]
    print(
        f"damper on the {place}: the nutation goes as e^(t/T), 1/T = {found:+.4e}/s, by the rule {theory[place]:+.4e}/s"
    )
    assert np.all(np.diff(motion.energy) < 1e-9)
    assert abs(found / theory[place] - 1) < 2 * J / platform
assert angles["platform"][-1] < angles["platform"][0] / 4
assert angles["rotor"][-1] > 5 * angles["rotor"][0]

figure, panel = plt.subplots(figsize=(6.5, 4), layout="constrained")
for place, colour in (("platform", "#0072B2"), ("rotor", "#D55E00")):
    panel.semilogy(times / 60, np.degrees(angles[place]), color=colour, label=f"damper on the {place}")
    rule = np.degrees(np.arctan(np.tan(tilt) * np.exp(theory[place] * times)))
    name = "rule of Landon and Iorillo" if place == "rotor" else None
    panel.semilogy(times / 60, rule, ":", color="#000000", label=name)
panel.set(xlabel="time [min]", ylabel="axis from the angular momentum [deg]", xlim=(0, times[-1] / 60))
panel.legend(frameon=False)
panel.grid(alpha=0.25)
figure.savefig("dual_spin.png", dpi=150)
