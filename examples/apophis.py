"""Apophis at the Earth.

Apophis passes the Earth at 38,000 km on 13 April 2029, which changes its rotation: the distribution afterwards.

(99942) Apophis tumbles about its short axis (Pravec et al. 2014, Icarus 233, 48). The effect of the Earth's gravity
gradient depends on the attitude during the flyby. Here nothing is assumed of it: 4000 Monte Carlo samples have
isotropic angular momentum and uniform phases. Sources and published results are in docs/worlds.md.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import simpson, solve_ivp
from scipy.spatial.transform import Rotation

import poinsot as pt

hour, day = 3600.0, 86400.0  # s; km
apophis = pt.Body((0.61, 0.965, 1.0))  # up to a factor, which changes nothing
mu, perigee, excess_speed = 398600.4418, 38000.0, 5.84
flyby = pt.orbits.EscapeOrbit(
    mu, periapsis_distance=perigee, eccentricity=1 + perigee * excess_speed**2 / mu
)  # at the perigee at t = 0
system = pt.System(apophis, pt.GravityGradient(flyby), units={"time": "s"})

# Before: the two periods leave one nutation, and one energy, to a body with these moments.
rotation = 263.0 * hour
before = pt.analysis.FreeRotation.from_periods(
    apophis, "short-axis", rotation_period=rotation, precession_period=27.38 * hour, rotation_angle=np.pi / 2
)
tumbling = apophis.state((1, 0, 0, 0), angular_momentum_body=before.state.angular_momentum_body)
spin = 2 * before.energy / before.angular_momentum  # the effective rate
low, high = np.degrees(before.nutation_range)
print(f"before: {before.mode}, nutation {low:.1f} to {high:.1f} deg, energy ratio {before.energy_ratio:.4f}")
print(f"    long axis round the momentum in {before.long_axis_precession_period / hour:.2f} h")
print(f"    effective period {2 * np.pi / spin / hour:.2f} h")
assert before.mode == "short-axis"
assert abs(before.energy_ratio - 1.024) < 0.013  # Pravec et al.
assert abs(before.long_axis_precession_period / hour - 30.56) < 0.01  # the period that their light curves show

# Members: phases of the free rotation, turned into any orientation.
members, far = 4000, 5 * day
random = np.random.default_rng(2029)
phases = pt.free_motion(apophis, tumbling, np.sort(random.uniform(0, 1000, members)) * rotation)
turned = Rotation.random(members, rng=random) * phases.attitude


def start(time):
    return apophis.state(turned, angular_momentum_body=phases.angular_momentum_body, time=time)


def rotations(motion):
    """The free rotations that go on from the last time."""
    momenta = motion.angular_momentum_body[:, -1]
    return pt.analysis.FreeRotation(apophis, apophis.state(motion.quaternion[:, -1], angular_momentum_body=momenta))


motion = pt.propagate(system, start(-far), [-far, far])
after = rotations(motion)
rate = 2 * after.energy / after.angular_momentum / spin
long_axis = after.mode == "long-axis"
G = motion.angular_momentum_space
pole = np.degrees(np.arccos(np.sum(G[:, 0] * G[:, 1], axis=1) / np.prod(np.linalg.norm(G, axis=2), axis=1)))
print(f"after, of {members}: {np.mean(long_axis):.1%} about the long axis")
for what, values in {
    "effective rate over that before": rate,
    "turn of the angular momentum [deg]": pole,
    "long axis round the momentum [h]": after.long_axis_precession_period / hour,
    "rotation period [h]": after.rotation_period / hour,
}.items():
    print(f"    {what}: percentiles 5, 50, 95:", *np.round(np.percentile(values, [5, 50, 95]), 3))
assert not motion.failures
assert 0.05 < np.mean(long_axis) < 0.2
assert 0.98 < np.median(rate) < 1.08
assert 10 < np.median(pole) < 14

# Five days before and after are far enough: ten and ten change this little, against free motion for the first five.
few = slice(None, None, 40)
momenta = phases.angular_momentum_body[few]
longer = pt.propagate(system, apophis.state(turned[few], angular_momentum_body=momenta, time=-2 * far), [-far, 2 * far])
freely = pt.free_motion(apophis, longer.initial, [-far])
shorter = apophis.state(freely.quaternion[:, 0], angular_momentum_body=freely.angular_momentum_body[:, 0], time=-far)
ends = [rotations(run) for run in (longer, pt.propagate(system, shorter, [far]))]
rates = [end.energy / end.angular_momentum for end in ends]
error = np.max(np.abs(rates[0] / rates[1] - 1))
print(f"from 10 days before to 10 after instead of 5 and 5: effective angular velocities change by {error:.1e} at most")
assert error < 1e-4

# One member again: by Runge and Kutta, with Newton's orbit and Euler's equations; and what the tide's power adds up to.
one = apophis.state(turned[7], angular_momentum_body=phases.angular_momentum_body[7], time=-far)
times = np.linspace(-far, far, 8001)
single = pt.propagate(system, one, times)
I = np.asarray(apophis.moments)


def tide(place, attitude):
    """The torque along the body axes at a place."""
    r = attitude.inv().apply(place)
    return 3 * mu * np.cross(r, I * r) / np.linalg.norm(r, axis=-1, keepdims=True) ** 5


def newton(_, s):
    return np.concatenate([s[3:], -mu * s[:3] / np.linalg.norm(s[:3]) ** 3])


def euler(t, s):
    """Rates of place, velocity, quaternion (scalar first) and rate along the body axes."""
    q, w = s[6:10], s[10:]
    torque = tide(s[:3], Rotation.from_quat(q, scalar_first=True))
    turning = 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])
    return np.concatenate([newton(t, s[:6]), turning, (torque - np.cross(w, I * w)) / I])


fine = {"method": "DOP853", "rtol": 1e-12, "atol": [1e-5] * 3 + [1e-11] * 3}
fastest = np.sqrt(excess_speed**2 + 2 * mu / perigee)
coming = solve_ivp(newton, (0, -far), (perigee, 0, 0, 0, fastest, 0), **fine).y[:, -1]
fine["atol"] += [1e-13] * 4 + [1e-18] * 3
ending = solve_ivp(euler, (-far, far), (*coming, *one.quaternion, *single.omega_body[0]), **fine).y[:, -1]
other = Rotation.from_quat(ending[6:10], scalar_first=True)
angle = (other * single.attitude[-1].inv()).magnitude()
print(f"one member, by DOP853: {angle:.1e} rad apart after the flyby")
assert angle < 1e-8

power = np.sum(tide(np.transpose(flyby.position_at(times)), single.attitude) * single.omega_body, axis=1)
gained, work = single.kinetic_energy[-1] - single.kinetic_energy[0], simpson(power, x=times)
print(
    f"    energy gained {gained / single.kinetic_energy[0]:+.6f} of what it had, work of the tide "
    f"{work / single.kinetic_energy[0]:+.6f}"
)
assert abs(gained - work) < 1e-8 * single.kinetic_energy[0]

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
for mode, chosen, color in (("short-axis", ~long_axis, "#0072B2"), ("long-axis", long_axis, "#D55E00")):
    label = f"{mode} mode"
    left.plot(rate[chosen], after.dynamic_moment[chosen], ".", color=color, markersize=2, label=label)
left.plot(1, before.dynamic_moment, "o", color="#000000", markersize=4, label="before")
left.set_xlabel("effective rate 2T/G, over that before")
left.set_ylabel("dynamic moment G$^2$/2T, over the largest moment")
periods = [after.long_axis_precession_period[chosen] / hour for chosen in (~long_axis, long_axis)]
looks = {"color": ["#0072B2", "#D55E00"], "label": ["short-axis mode", "long-axis mode"]}
right.hist(periods, bins=np.linspace(15, 65, 51), stacked=True, **looks)
right.axvline(before.long_axis_precession_period / hour, color="#000000", label="before")
right.set_xlabel("precession period of the long axis [h]")
right.set_ylabel(f"members of {members}")
for panel in (left, right):
    panel.grid(alpha=0.25)
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, markerscale=2)
figure.savefig("apophis.png", dpi=150)
