r"""Convergence of a series of gravity.

Convergence of the series of a gravity field: the torque on a contact binary, to degree $N$ against all degrees.

Two balls that touch, of unequal size, as points of mass on a lattice. An attractor at the distance $r$ from the centre
of mass sees the exact torque of `MasconGravity`; that of `HarmonicGravity` to degree $N$ misses a part that falls with
the degree like $(R/r)^N$, with $R$ the radius of the smallest sphere that holds the body. Inside that sphere, over the
waist, where the attractor does not touch the body, the series does not converge, and more degrees make it worse.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

warnings.filterwarnings("ignore", ".* below the sphere that holds the body")  # at 0.8 R, on purpose

DEGREES, DISTANCES = np.arange(2, 17), (0.8, 1.1, 1.5, 2.0, 3.0, 5.0)
COLOURS = plt.colormaps["cividis"](np.linspace(0.7, 0.0, len(DISTANCES)))  # an order, near to far; seen on white

# A lattice with a step of 0.12 in balls with the radii 0.55 and 0.45.
line = 0.12 * (np.arange(-10, 11) + 0.5)
grid = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
balls = [grid[np.sum((grid - [x, 0.05, 0]) ** 2, axis=-1) < radius**2] for x, radius in ((0.45, 0.55), (-0.55, 0.45))]
points = np.concatenate(balls)
points -= np.mean(points, axis=0)
points /= np.max(np.linalg.norm(points, axis=-1))  # R = 1
masses = np.full(len(points), 1 / len(points))
field, body = pt.shapes.Mascons(masses, points).field(int(DEGREES[-1])), pt.Body.from_point_masses(masses, points)
print(f"{len(points)} points; C20 = {field.C[2, 0]:.3f}, C22 = {field.C[2, 2]:.3f}, C31 = {field.C[3, 1]:.3f}")

# Directions from 50 to 90 degrees off the long axis, where there is room for an attractor.
random = np.random.default_rng(1)
angle, turn = np.radians(random.uniform(50, 90, 20)), random.uniform(0, 2 * np.pi, 20)
directions = np.stack([np.cos(angle), np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn)], axis=-1)


def torques(make, distance):
    """The torques of a force for attractors in all directions, at rest: the body has the members' positions."""
    system = pt.System(body, make(pt.orbits.FixedPosition(np.ones(len(directions)), position=-distance * directions)))
    attitudes = np.tile([1.0, 0, 0, 0], (len(directions), 1))
    return system.torque_body(pt.State(attitudes, np.zeros_like(attitudes)))


errors = {}
for distance in DISTANCES:
    exact = torques(lambda orbit: pt.forces.MasconGravity(orbit, masses, points), distance)
    series = [
        torques(lambda orbit, n=n: pt.forces.HarmonicGravity(orbit, field.truncated(int(n))), distance) for n in DEGREES
    ]
    errors[distance] = np.array([np.linalg.norm(found - exact) / np.linalg.norm(exact) for found in series])

print("| r/R | " + " | ".join(f"N = {n}" for n in DEGREES[::2]) + " | per degree |")
print("|---" * (len(DEGREES[::2]) + 2) + "|")
for distance, found in errors.items():
    reached = found > 1e-13
    step = np.exp(np.polyfit(DEGREES[reached], np.log(found[reached]), 1)[0])
    print(f"| {distance} | " + " | ".join(f"{error:.1e}" for error in found[::2]) + f" | {step:.2f} |")
    if distance > 1:
        assert 0.75 / distance < step < 1.0 / distance
    else:
        assert found[-1] > found[4]

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
for (distance, found), colour in zip(errors.items(), COLOURS, strict=True):
    axes.semilogy(DEGREES, found, "o-", color=colour, markersize=4)
    axes.annotate(f"{distance} R", (DEGREES[-1], found[-1]), (6, 0), textcoords="offset points", va="center")
axes.set(xlabel="degree N of the field", ylabel="error of the torque / torque", xlim=(1.5, 17.2), ylim=(1e-13, 10))
axes.grid(alpha=0.25)
axes.set_title("attractor at distances from 0.8 to 5 radii R of the body", fontsize="medium")
figure.savefig("series_of_gravity.png", dpi=150)
