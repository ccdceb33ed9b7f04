"""Cassini states of the Moon and of Mercury.

The Cassini states of the Moon (2) and of Mercury (1, 3:2 resonance), and obliquities against the nodal period.

In the frame of the node the rotation is periodic: that of the Moon with one revolution, that of Mercury with two, in
which it turns three times. `cassini_state` finds the obliquity and the three free librations. The
figure shows the obliquity of the Moon's states for other nodal periods: the Moon is beyond the fold of state 1 and the
unstable state 4. Numbers and sources are in docs/worlds.md.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import poinsot as pt

year, degree, day = 365.25, np.pi / 180, 86400.0  # days, radians, seconds


def precessing(mu, a, e, inclination, rate, node_period):
    """The orbit, from km3/s2, km, degrees, degrees per day and years; the node moves backwards."""
    node_rate = -2 * np.pi / (node_period * year)
    ellipse = pt.KeplerOrbit(
        mu * day**2, semimajor_axis=a, eccentricity=e, inclination=inclination * degree, argument_of_periapsis=np.pi / 4
    )
    return pt.orbits.PrecessingOrbit.from_mean_motion(
        ellipse, mean_motion=rate * degree - node_rate, node_rate=node_rate
    )


def moon_orbit(node_period=18.600):
    return precessing(398600.4418, 384399, 0.0549, 5.145, 13.176358, node_period)


moon_body = pt.Body.from_ratios(beta=6.31e-4, gamma=2.28e-4)
moon = pt.analysis.cassini_state(moon_body, moon_orbit())
mercury = pt.analysis.cassini_state(
    pt.Body.from_stokes(C20=-6e-5, C22=1e-5, polar_moment_factor=0.34),
    precessing(132712440018, 57909050, 0.2056, 8.6, 360 / 87.969, 328000),
    spin=1.5,
)

found = {
    # what: own, as published, allowed
    "Moon, axis to the orbit [deg]": (moon.obliquity / degree, 6.68, 2e-3),
    "Moon, axis to the ecliptic [deg]": (moon.inclination / degree, 1.54, 1e-2),
    "Moon, longitude [d]": (2 * np.pi / moon.longitude, 1056.16, 2e-3),
    "Moon, precession seen from the node [d]": (2 * np.pi / moon.precession, 8806.9, 3e-3),
    "Moon, wobble [d]": (2 * np.pi / moon.wobble, 27262.99, 4e-3),
    "Mercury, longitude [yr]": (2 * np.pi / mercury.longitude / year, 15.847, 5e-4),
    "Mercury, precession [yr]": (2 * np.pi / mercury.precession / year, 1066, 2e-3),
    "Mercury, obliquity [arcmin]": (60 * mercury.obliquity / degree, 1.6, 0.06),
}
for what, (own, published, allowed) in found.items():
    print(f"{what:40s} {own:11.4f}   published {published:9.2f}")
    assert abs(own / published - 1) < allowed
print(f"{'Mercury, wobble [yr]':40s} {2 * np.pi / mercury.wobble / year:11.4f}")
assert moon.motion.stable
assert mercury.motion.stable
assert abs(moon.obliquity - moon.inclination - 5.145 * degree) < 1e-6  # state 2: beyond the pole, seen from the orbit


def balances(node_period):
    """Tilts of the axis from the normal, away from the pole, at which Peale's equation (docs/worlds.md) holds."""
    (A, B, C), orbit = moon_body.moments, moon_orbit(node_period)
    e, i = orbit.eccentricity, orbit.orbit.inclination
    pull = 1.5 * orbit.mu / orbit.orbit.semimajor_axis**3

    def left_over(x):
        oblate = (C - (A + B) / 2) * (1 - e**2) ** -1.5 * np.cos(x)
        direct = (B - A) / 4 * (1 - 5 * e**2 / 2 + 13 * e**4 / 16) * (1 + np.cos(x))
        return C * orbit.mean_motion * orbit.node_rate * np.sin(i + x) + pull * np.sin(x) * (oblate + direct)

    grid = np.linspace(-np.pi / 2, np.pi / 2, 1000)
    signs = np.sign(left_over(grid))
    return [brentq(left_over, *grid[k : k + 2]) for k in np.flatnonzero(signs[:-1] != signs[1:])]


figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
theory = [(years, x / degree) for years in np.geomspace(10, 500, 400) for x in balances(years)]
axes.semilogx(*np.transpose(theory), ".", color="#000000", markersize=1.5)
axes.plot([], [], color="#000000", label="Peale's equation")
marks = {True: ("o", "#0072B2", "stable"), False: ("x", "#D55E00", "unstable")}
apart = []
for years in (10, 14, 25, 32, 40, 50, 60, 70, 80, 95, 120, 150, 200, 300, 450):
    for x in (x for x in balances(years) if abs(x) < np.pi / 4):
        state = pt.analysis.cassini_state(moon_body, moon_orbit(years), obliquity=x)
        marker, color, _ = marks[state.motion.stable]
        assert state.motion.stable == (years != 40)
        axes.plot(years, np.sign(x) * state.obliquity / degree, marker, color=color)
        apart.append(abs(state.obliquity / abs(x) - 1))
assert max(apart) < 0.03
print(f"{len(apart)} states of the Moon with other nodes: obliquities within {max(apart):.1e} of Peale's equation")
axes.plot(18.6, -moon.obliquity / degree, "*", color="#009E73", markersize=14, label="the Moon")
for marker, color, label in marks.values():
    axes.plot([], [], marker, color=color, label=label)
axes.set_xlabel("period of the node [years]")
axes.set_ylabel("axis from the normal of the orbit,\naway from the pole [deg]")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)
axes.grid(alpha=0.25)
figure.savefig("cassini_states.png", dpi=150)
